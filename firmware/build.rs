//! The image is linked by `cortex-m-rt`'s script with the board's memory map (`hal`), and by
//! `defmt`'s, which keeps the texts of the log out of the image.
fn main() {
    // `link.x` includes `memory.x`, and the linker would take that of the current folder: the
    // reference board's, for every board.
    let memory = std::env::var("DEP_BEAMTICK_BOARD_MEMORY").expect("hal names the board's map");
    println!("cargo:rustc-link-arg-bins=--remap-inputs=memory.x={memory}");
    for argument in ["-Tlink.x", "-Tdefmt.x", "--nmagic"] {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
}
