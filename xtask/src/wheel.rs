//! The Python wheel, with the library inside.
//!
//! In: libgts in release, the package. Out: `out/beamtick-VERSION-py3-none-PLATFORM.whl`. Fails
//! where there is no Python.
use crate::shell::{self, Outcome, cargo, program, root, target};

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
    shell::run(cargo().args(["build", "--release", "-p", "beamtick-gts"]))?;
    let library = target().join("release").join(LIBRARY);
    shell::run(program("python3").arg("host/python/wheel.py").arg(library).arg(root().join("out")))
}
