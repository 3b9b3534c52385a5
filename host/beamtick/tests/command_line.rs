//! The program as a user calls it.
use assert_cmd::Command;
use std::fs;
use std::path::{Path, PathBuf};

fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples").join(name)
}

/// Output, errors, exit code.
fn beamtick(arguments: &[&str]) -> (String, String, i32) {
    let output = Command::cargo_bin("beamtick").unwrap().env_remove("BEAMTICK_IMAGE").args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (text(output.stdout), text(output.stderr), output.status.code().unwrap())
}

fn sim(name: &str, more: &[&str]) -> String {
    let path = example(name);
    let (out, errors, code) = beamtick(&[&["sim", path.to_str().unwrap()], more].concat());
    assert_eq!(code, 0, "{out}\n{errors}");
    out
}

/// The failure of a job with this text.
fn failing(text: &str) -> (String, i32) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bad.gts");
    fs::write(&path, text).unwrap();
    let (_, errors, code) = beamtick(&["sim", path.to_str().unwrap()]);
    (errors, code)
}

#[test]
fn the_trapezoid_ends_where_and_when_it_should() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (csv, vcd, svg) = (file("t.csv"), file("t.vcd"), file("t.svg"));
    let out = sim("pt_static.gts", &["--trace", &csv, "--vcd", &vcd, "--plot", &svg, "--tick-us", "1000"]);
    for part in ["PtSpace space = 32", "PtSpace space = 29", "prfVel = 2", "prfPos = 4096", "planned 4096.000000", "no late entries"] {
        assert!(out.contains(part), "{part:?} is not in\n{out}");
    }
    let rows = fs::read_to_string(&csv).unwrap();
    let mut lines = rows.lines();
    assert_eq!(lines.next(), Some("t_ms,axis1_pos,axis1_vel"));
    assert_eq!(lines.next(), Some("0.000000,0.000000,0.000000"));
    // Started at 0, in force from 1 ms on: 2 pulse/ms from 1025 to 2049 ms, at rest at 3073 ms.
    let row = |t: &str| rows.lines().find(|line| line.starts_with(&format!("{t},"))).map(str::to_owned);
    assert_eq!(row("1025.000000").as_deref(), Some("1025.000000,1024.000000,2.000000"));
    assert_eq!(row("1537.000000").as_deref(), Some("1537.000000,2048.000000,2.000000"));
    assert_eq!(row("3073.000000").as_deref(), Some("3073.000000,4096.000000,0.000000"));
    assert!(fs::read_to_string(&vcd).unwrap().contains("axis1_step"));
    assert!(fs::read_to_string(&svg).unwrap().contains("<svg"));
}

#[test]
fn the_sine_returns_to_zero() {
    let folder = tempfile::tempdir().unwrap();
    let csv = folder.path().join("t.csv").to_str().unwrap().to_owned();
    let out = sim("pt_dynamic.gts", &["--trace", &csv, "--tick-us", "1000"]);
    assert!(out.contains("prfPos = 0\n") && out.contains("ran to its end"), "{out}");
    let rows = fs::read_to_string(&csv).unwrap();
    let position = |t: &str| rows.lines().find(|line| line.starts_with(t)).and_then(|line| line.split(',').nth(1));
    assert_eq!(position("1001.000000,"), Some("0.000000"));
    assert_eq!(position("2001.000000,"), Some("0.000000"));
    assert_ne!(position("501.000000,"), Some("0.000000"));
}

#[test]
fn the_other_examples_run() {
    let out = sim("jog_trap.gts", &[]);
    assert!(out.contains("axis 2: planned 0.000000"), "{out}");
    let out = sim("stop.gts", &[]);
    assert!(out.contains("axis 1: planned") && !out.contains("still moved"), "{out}");
    let out = sim("eight_axes_stream.gts", &[]);
    assert_eq!(out.matches("ran to its end").count(), 8, "{out}");
    assert_eq!(out.matches("planned 0.000000").count(), 8, "{out}");
    assert!(!out.contains("UNDERRUN"), "{out}");
    let out = sim("stop.gts", &["--profile", "gsn-048", "--strict"]);
    assert!(out.contains("axis 2: planned"), "{out}");
}

#[test]
fn what_still_moves_at_the_end_is_stopped_and_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("left.gts");
    fs::write(
        &path,
        "TJogPrm j = {1, 1, 0}; GT_Reset(); GT_LmtsOff(2); GT_AlarmOff(2); GT_AxisOn(2); GT_PrfJog(2); GT_SetJogPrm(2, &j); \
         GT_SetVel(2, 5); GT_Update(2); Sleep(100);",
    )
    .unwrap();
    let (out, errors, code) = beamtick(&["sim", path.to_str().unwrap()]);
    assert_eq!(code, 0, "{out}\n{errors}");
    assert!(out.contains("still moved when the script ended: stopped smoothly"), "{out}");
}

#[test]
fn refused_calls_show_line_code_and_reason() {
    const READY: &str = "GT_Reset(); GT_LmtsOff(1); GT_AlarmOff(1); GT_AxisOn(1); GT_PrfPt(1);\n";
    for (text, parts) in [
        (format!("{READY}GT_PtData(1, 5, 10);\nGT_PtData(1, 6, 10);\n"), ["bad.gts:3:1", "GT_PtData returned 7", "greater than 10"]),
        (format!("{READY}GT_PtData(1, NAN, 10);"), ["bad.gts:2:1", "GT_PtData returned 7", "finite"]),
        (format!("{READY}GT_PtData(1, 1e13, 10);"), ["bad.gts:2:1", "GT_PtData returned 7", "pos"]),
        (format!("{READY}GT_PtStart(1);"), ["bad.gts:2:1", "GT_PtStart returned 1", "holds no data"]),
        ("GT_AxisOn(0);".into(), ["bad.gts:1:1", "GT_AxisOn returned 7", "axis is 0"]),
        ("GT_AxisOn(99);".into(), ["bad.gts:1:1", "GT_AxisOn returned 7", "axis is 99"]),
        ("GT_PrfTrap(1);\nGT_PtData(1, 1, 1);".into(), ["bad.gts:2:1", "GT_PtData returned 1", "not in the mode"]),
    ] {
        let (errors, code) = failing(&text);
        assert_eq!(code, 1, "{errors}");
        for part in parts {
            assert!(errors.contains(part), "{part:?} is not in\n{errors}");
        }
    }
    let many: String = (1..=33).map(|n| format!("GT_PtData(1, {n}, {n});\n")).collect();
    let (errors, code) = failing(&format!("{READY}{many}"));
    assert!(code == 1 && errors.contains("bad.gts:34:1") && errors.contains("FIFO is full"), "{errors}");
}

#[test]
fn wrong_input_has_its_own_exit_code() {
    let path = example("pt_static.gts");
    let path = path.to_str().unwrap();
    for (arguments, part) in [
        (&["sim", "no/such/job.gts"][..], "no/such/job.gts: the job file cannot be read"),
        (&["sim", path, "--profile", "gtx"], "gsn-048"),
        (&["sim", path, "--plot", "a.pdf"], ".svg or .png"),
        (&["sim", path, "--tick-us", "5"], "10..=1000"),
        (&["run", path], "--link"),
    ] {
        let (_, errors, code) = beamtick(arguments);
        assert_eq!(code, 2, "{errors}");
        assert!(errors.contains(part), "{part:?} is not in\n{errors}");
    }
    let (errors, code) = failing("GTN_PrfXyz(1, 1);\nGT_AxisOn();");
    assert_eq!(code, 2);
    for part in ["bad.gts:1:1", "no function `GTN_PrfXyz`", "bad.gts:2:1", "`axis` is missing", "2 errors"] {
        assert!(errors.contains(part), "{part:?} is not in\n{errors}");
    }
}

#[test]
fn ports_and_images_that_are_not_there() {
    let path = example("pt_static.gts");
    for (link, part) in [("serial:/dev/no-such-port", "no-such-port"), ("tcp:127.0.0.1:1", "127.0.0.1:1"), ("usb:1", "tcp:HOST:PORT")] {
        let (_, errors, code) = beamtick(&["run", path.to_str().unwrap(), "--link", link]);
        assert_eq!(code, 1, "{errors}");
        assert!(errors.contains("-6") && errors.contains(part), "{errors}");
    }
    let (_, errors, code) = beamtick(&["run", path.to_str().unwrap(), "--link", "qemu", "--image", "no-such-image"]);
    assert!(code == 1 && errors.contains("no-such-image"), "{errors}");
}

#[test]
fn info_and_check() {
    let (out, _, code) = beamtick(&["info"]);
    assert_eq!(code, 0);
    for part in ["virtual", "profile     gus", "1 core of 8 axes", "250 us"] {
        assert!(out.contains(part), "{part:?} is not in\n{out}");
    }
    let (out, _, code) = beamtick(&["info", "--profile", "gsn-048", "--tick-us", "50", "--family", "lsr"]);
    assert!(code == 0 && out.contains("2 cores of 24 axes") && out.contains("50 us") && out.contains("lsr"), "{out}");
    let (out, _, code) = beamtick(&["check", example("pt_static.gts").to_str().unwrap()]);
    assert!(code == 0 && out.contains("pos 3072, time_ms 2048") && out.contains("18 steps"), "{out}");
}
