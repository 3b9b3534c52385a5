//! The image is linked by `cortex-m-rt`'s script with the board's memory map (`hal`), and by
//! `defmt`'s, which keeps the texts of the log out of the image.
fn main() {
    for argument in ["-Tlink.x", "-Tdefmt.x", "--nmagic"] {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
}
