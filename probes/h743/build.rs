//! Puts this program's linker files where the linker finds them.
use std::path::Path;
use std::{env, fs};

fn main() {
    let out = env::var_os("OUT_DIR").expect("cargo sets OUT_DIR");
    for file in ["memory.x", "device.x"] {
        fs::copy(file, Path::new(&out).join(file)).expect("a linker file");
        println!("cargo:rerun-if-changed={file}");
    }
    println!("cargo:rustc-link-search={}", Path::new(&out).display());
    // Else the linker would take the one of the current folder, which is the board's.
    println!("cargo:rustc-link-arg-bins=--remap-inputs=memory.x={}", Path::new(&out).join("memory.x").display());
    for argument in ["-Tlink.x", "--nmagic"] {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
}
