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
                  print(*[why for _, why in found.skipped], sep='\\n', file=sys.stdout); \
                  print(found.testsRun, len(found.failures) + len(found.errors), file=sys.stdout); sys.exit(not found.wasSuccessful())";
    let text = output_of(tests.args(["-c", script]).current_dir(root().join("host/python")));
    let mut lines: Vec<&str> = text.lines().filter(|line| !line.is_empty()).collect();
    let totals = lines.pop().unwrap_or_default();
    assert!(totals.ends_with(" 0") && !totals.starts_with('0'), "{text}");
    lines.iter().for_each(|why| skip(why));
}
