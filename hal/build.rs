//! Puts the board's linker files where the firmware's linker finds them.
//!
//! The reference board's map is `memory.x` at the top of the workspace; other boards have theirs in
//! their folder. The linker looks for `memory.x` in the current folder first, which is the top of
//! the workspace. So a program says by path which map it means: `DEP_BEAMTICK_BOARD_MEMORY` in its
//! own build script.
use std::path::Path;
use std::{env, fs};

fn main() {
    let out = env::var_os("OUT_DIR").expect("cargo sets OUT_DIR");
    let out = Path::new(&out);
    let files: &[(&str, &str)] = if env::var_os("CARGO_FEATURE_MPS2_AN500").is_some() {
        &[("src/mps2_an500/memory.x", "memory.x"), ("src/mps2_an500/device.x", "device.x")]
    } else {
        // The interrupts of a chip with a crate of its own come with that.
        &[("../memory.x", "memory.x")]
    };
    for (from, file) in files {
        // A file that is not there would make every build begin anew.
        println!("cargo:rerun-if-changed={from}");
        fs::copy(from, out.join(file)).expect("the board's linker file");
    }
    println!("cargo:rustc-link-search={}", out.display());
    println!("cargo:memory={}", out.join("memory.x").display());
}
