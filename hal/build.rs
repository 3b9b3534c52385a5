//! Puts the board's linker files where the firmware's linker finds them.
use std::path::Path;
use std::{env, fs};

fn main() {
    let out = env::var_os("OUT_DIR").expect("cargo sets OUT_DIR");
    for file in ["memory.x", "device.x"] {
        let from = Path::new("src/mps2_an500").join(file);
        fs::copy(&from, Path::new(&out).join(file)).expect("the board's linker file");
        println!("cargo:rerun-if-changed={}", from.display());
    }
    println!("cargo:rustc-link-search={}", Path::new(&out).display());
}
