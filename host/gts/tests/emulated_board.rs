//! An example on the emulated board: the same program, another link. The image is the one that
//! `BEAMTICK_IMAGE` names.

mod toolchain;

use toolchain::{Language, build_file, output, root, skip};

#[test]
fn an_example_runs_on_the_emulated_board() {
    let Ok(image) = std::env::var("BEAMTICK_IMAGE") else {
        return skip("no image (BEAMTICK_IMAGE)");
    };
    let source = root().join("examples/c/pt_static.cpp");
    let Some(built) = build_file(Language::Cpp, "pt_static", &source, &[]) else { return };
    let text = output(&built, &[("BEAMTICK_LINK", "qemu"), ("BEAMTICK_IMAGE", &image)]);
    assert_eq!(text, "32 free segments\n29 free segments after three\nat 4096.0 with 0.00 pulse/ms\n");
}

#[test]
fn calls_in_loops_run_on_the_emulated_board() {
    let Ok(image) = std::env::var("BEAMTICK_IMAGE") else {
        return skip("no image (BEAMTICK_IMAGE)");
    };
    let source = root().join("host/gts/tests/programs/calls.cpp");
    let Some(built) = build_file(Language::Cpp, "calls", &source, &["-Wpedantic"]) else { return };
    let text = output(&built, &[("BEAMTICK_LINK", "qemu"), ("BEAMTICK_IMAGE", &image)]);
    for name in ["read ", "command ", "PtData "] {
        let line = text.lines().find_map(|line| line.strip_prefix(name)).unwrap_or_else(|| panic!("{text}"));
        assert!(line.parse::<f64>().unwrap() > 0.0, "{text}");
    }
}
