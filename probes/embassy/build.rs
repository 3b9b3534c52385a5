//! Links the probes as the image is linked.
fn main() {
    // As in the image's build script.
    let memory = std::env::var("DEP_BEAMTICK_BOARD_MEMORY").expect("hal names the board's map");
    println!("cargo:rustc-link-arg-bins=--remap-inputs=memory.x={memory}");
    // What the linker leaves out has no place in what debuggers read: else it would be reported at
    // address 0, where code is.
    for argument in ["-Tlink.x", "--nmagic", "-zdead-reloc-in-nonalloc=.debug_*=0xffffffff"] {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
}
