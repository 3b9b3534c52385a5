//! The image: builds it and says how large it is.
use crate::setup::{TARGET, compiler};
use crate::shell::{Outcome, run, target};
use crate::supply;
use object::{Object, ObjectSection, SectionFlags};
use std::path::{Path, PathBuf};

/// Builds the image of the emulated board and returns its path.
pub fn build() -> Outcome<PathBuf> {
    build_bin("beamtick-firmware", "beamtick-mps2")
}

/// Builds a program for the Cortex-M7 with the image's profile.
pub fn build_bin(package: &str, bin: &str) -> Outcome<PathBuf> {
    let compiler = compiler()?;
    let mut cargo = compiler.cargo();
    cargo.args(["build", "--package", package, "--bin", bin, "--profile", "image"]).args(compiler.arguments());
    run(&mut cargo)?;
    Ok(target().join(TARGET).join("image").join(bin))
}

/// Sizes of an image in bytes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Size {
    /// Code and constants.
    pub flash: u64,
    /// Variables.
    pub ram: u64,
}

/// Measures an ELF file: what it loads, and what RAM it takes.
pub fn size(path: &Path) -> Outcome<Size> {
    const WRITE: u64 = 1;
    const ALLOC: u64 = 2;
    let bytes = std::fs::read(path).map_err(|e| format!("{}: {e}", path.display()))?;
    let file = object::File::parse(&*bytes).map_err(|e| format!("{}: {e}", path.display()))?;
    let mut size = Size::default();
    for section in file.sections() {
        let SectionFlags::Elf { sh_flags } = section.flags() else { continue };
        if sh_flags & ALLOC == 0 {
            continue;
        }
        let loaded = section.file_range().is_some();
        let writable = sh_flags & WRITE != 0;
        if loaded {
            size.flash += section.size();
        }
        if writable {
            size.ram += section.size();
        }
    }
    Ok(size)
}

/// Builds the image and prints its size.
pub fn report() -> Outcome {
    let path = build()?;
    let Size { flash, ram } = size(&path)?;
    println!("{}: {flash} bytes of code and constants, {ram} bytes of RAM without the stack", path.display());
    println!("{}: what it is made of", supply::bill("beamtick-firmware", &path)?.display());
    Ok(())
}
