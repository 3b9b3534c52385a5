//! Puts the board's linker files where the firmware's linker finds them.
use std::path::Path;
use std::{env, fs};

fn main() {
    let out = env::var_os("OUT_DIR").expect("cargo sets OUT_DIR");
    let board = if env::var_os("CARGO_FEATURE_MPS2_AN500").is_some() { "mps2_an500" } else { "stm32h743" };
    for file in ["memory.x", "device.x"] {
        let from = Path::new("src").join(board).join(file);
        println!("cargo:rerun-if-changed={}", from.display());
        // The interrupts of a chip with a crate of its own come with that.
        if from.exists() {
            fs::copy(&from, Path::new(&out).join(file)).expect("the board's linker file");
        }
    }
    println!("cargo:rustc-link-search={}", Path::new(&out).display());
}
