//! The Python wheel, with the library inside.
//!
//! In: libgts in release, the package. Out: `out/beamtick-VERSION-py3-none-PLATFORM.whl`. Fails
//! where there is no Python.
use crate::shell::{self, Outcome, cargo, program, root, target};
use std::path::Path;

/// What the library is called here.
const LIBRARY: &str = if cfg!(windows) {
    "gts.dll"
} else if cfg!(target_os = "macos") {
    "libgts.dylib"
} else {
    "libgts.so"
};

/// Builds both.
pub fn make() -> Outcome {
    make_in(&root().join("out"))
}

/// Builds both, the wheel into this folder.
pub fn make_in(folder: &Path) -> Outcome {
    std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    shell::run(cargo().args(["build", "--release", "-p", "beamtick-gts"]))?;
    let library = target().join("release").join(LIBRARY);
    shell::run(program("python3").arg("host/python/wheel.py").arg(library).arg(folder))
}
