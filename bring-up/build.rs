//! Linked as the board's image is, with the same map of memories.
fn main() {
    let memory = std::env::var("DEP_BEAMTICK_BOARD_MEMORY").expect("hal names the board's map");
    println!("cargo:rustc-link-arg-bins=--remap-inputs=memory.x={memory}");
    for argument in ["-Tlink.x", "--nmagic"] {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
}
