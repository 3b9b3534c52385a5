//! The manuals' texts, where they are at hand: in the folder that `BEAMTICK_MANUALS` names, or
//! beside the checkout.
use std::io::Write;
use std::path::{Path, PathBuf};

/// The manual whose file begins with `number`.
pub fn manual(number: &str) -> Option<String> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/manuals");
    let folder = std::env::var_os("BEAMTICK_MANUALS").map_or_else(beside, PathBuf::from);
    let mut files = std::fs::read_dir(folder).ok()?;
    let file = files.find_map(|file| file.ok().filter(|file| file.file_name().to_string_lossy().starts_with(number)));
    std::fs::read_to_string(file?.path()).ok()
}

/// Says that a test does nothing without them. Not println!, which is kept back where a test
/// passes.
pub fn skipped() {
    let _ = writeln!(std::io::stderr(), "skipped: the manuals are not here (set BEAMTICK_MANUALS to their folder)");
}
