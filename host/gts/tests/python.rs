//! The Python package on the library of this build.

mod toolchain;

use std::path::PathBuf;
use toolchain::{command, libraries, output_of, root, skip};

#[test]
fn the_packages_own_tests_pass() {
    let python = PathBuf::from("python3");
    if std::process::Command::new(&python).arg("--version").output().is_err() {
        return skip("there is no python3");
    }
    let library = libraries().join("libgts.so").to_string_lossy().into_owned();
    let mut tests = command(&python, &[("BEAMTICK_LIBRARY", &library), ("PYTHONDONTWRITEBYTECODE", "1")]);
    // unittest tells of its tests on the other stream.
    let script = "import sys, unittest; found = unittest.main(module=None, argv=['x', 'discover', '-s', 'tests'], exit=False).result; \
                  print(found.testsRun, len(found.failures) + len(found.errors), file=sys.stdout); sys.exit(not found.wasSuccessful())";
    let text = output_of(tests.args(["-c", script]).current_dir(root().join("host/python")));
    assert!(text.trim().ends_with(" 0") && !text.trim().starts_with('0'), "{text}");
}
