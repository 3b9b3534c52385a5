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
    let (memory, device) = if env::var_os("CARGO_FEATURE_MPS2_AN500").is_some() {
        ("src/mps2_an500/memory.x", "src/mps2_an500/device.x")
    } else {
        // The interrupts of a chip with a crate of its own come with that.
        ("../memory.x", "src/stm32h743/device.x")
    };
    for (from, file) in [(memory, "memory.x"), (device, "device.x")] {
        println!("cargo:rerun-if-changed={from}");
        if Path::new(from).exists() {
            fs::copy(from, out.join(file)).expect("the board's linker file");
        }
    }
    println!("cargo:rustc-link-search={}", out.display());
    println!("cargo:memory={}", out.join("memory.x").display());
}
