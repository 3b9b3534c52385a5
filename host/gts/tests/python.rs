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

/// The wheel in an environment of its own, away from the checkout: three lines to a plot.
#[test]
fn a_wheel_is_all_that_a_new_environment_needs() {
    let folder = toolchain::scratch().join("wheel");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let python = PathBuf::from("python3");
    let have = |module: &str| {
        std::process::Command::new(&python)
            .args(["-c", &format!("import {module}")])
            .output()
            .is_ok_and(|done| done.status.success())
    };
    if !have("venv") || !have("ensurepip") {
        return skip("there is no python3 with venv");
    }
    let make = |to: &str| {
        let script = root().join("host/python/wheel.py");
        let mut make = command(&python, &[]);
        output_of(make.arg(script).arg(libraries().join("libgts.so")).arg(folder.join(to))).trim().to_owned()
    };
    let wheel = make("one");
    // The same files are the same wheel.
    assert!(std::fs::read(&wheel).unwrap() == std::fs::read(make("two")).unwrap());
    let own = folder.join("venv");
    output_of(command(&python, &[]).args(["-m", "venv"]).arg(&own));
    let own = own.join("bin/python");
    let pip = ["-m", "pip", "install", "--no-index", "--disable-pip-version-check", "-q"];
    output_of(command(&own, &[]).args(pip).arg(&wheel));
    let lines = "import beamtick\n\
                 with beamtick.Beamtick('virtual:max', plot='t.png') as card:\n    \
                 card.AxisOn(1); card.PrfJog(1); card.SetJogPrm(1, dict(acc=1, dec=1)); card.SetVel(1, 10); card.Update(1); card.sleep(99)\n\
                 print(beamtick.__file__, beamtick.__version__)\n";
    let mut three = command(&own, &[]);
    let said = output_of(three.args(["-c", lines]).current_dir(&folder).env_remove("PYTHONPATH"));
    assert!(said.contains("site-packages") && said.trim_end().ends_with(env!("CARGO_PKG_VERSION")), "{said}");
    let picture = std::fs::read(folder.join("t.png")).unwrap();
    assert!(picture.starts_with(b"\x89PNG") && picture.len() > 10_000, "{}", picture.len());
}
