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

/// Help is read in a terminal of 80 columns.
#[test]
fn help_is_at_most_80_columns_wide() {
    let (out, _, code) = beamtick(&["--help"]);
    let commands = out.split("Commands:").nth(1).unwrap().split("Options:").next().unwrap();
    let names: Vec<&str> = commands.lines().filter_map(|line| line.strip_prefix("  ")?.split(' ').next()).collect();
    let names: Vec<&str> = names.into_iter().filter(|name| !name.is_empty()).collect();
    assert!(code == 0 && names.len() > 9, "{names:?}");
    for words in names.iter().flat_map(|name| [vec![*name, "--help"], vec![*name, "-h"]]).chain([vec!["--help"]]) {
        let words: Vec<&str> = if words[0] == "help" { vec!["help"] } else { words };
        let (out, errors, code) = beamtick(&words);
        assert_eq!(code, 0, "{words:?}: {errors}");
        for line in out.lines() {
            assert!(line.chars().count() <= 80, "{words:?}: {line}");
        }
    }
}

/// `-` is the standard input for any file that is read, and for one of them.
#[test]
fn any_file_may_come_over_the_standard_input() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let fed = |text: &str, words: &[&str]| {
        let mut command = Command::cargo_bin("beamtick").unwrap();
        let output = command.current_dir(folder.path()).args(words).write_stdin(text.to_owned()).output().unwrap();
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
        (text(output.stdout), text(output.stderr), output.status.code().unwrap())
    };
    let (toml, errors, code) = fed("", &["machine", "new", "-", "--yes"]);
    assert!(code == 0 && toml.contains("[axes.x]"), "{toml}{errors}");
    let machine = file("m.toml", &toml);
    assert_eq!(fed(&toml, &["machine", "check", "-"]), fed("", &["machine", "check", &machine]));
    let program = "G21 G90 F600\nG0 X1\nM3 S500 G1 X3 Y2\nM5\n";
    let named = file("p.nc", program);
    let (job, errors, code) = fed(program, &["import", "-", "--machine", &machine, "-o", "-"]);
    assert!(code == 0 && job.contains("GT_LnXY"), "{job}{errors}");
    assert_eq!(fed(&toml, &["import", &named, "--machine", "-", "-o", "job.gts"]).2, 0);
    let written = fs::read_to_string(folder.path().join("job.gts")).unwrap();
    let same = |job: &str| job.lines().filter(|line| !line.starts_with("//")).collect::<Vec<_>>().join("\n");
    assert_eq!(same(&job), same(&written));
    let square = "<svg xmlns='http://www.w3.org/2000/svg' width='9mm' height='9mm'><path stroke='red' fill='none' d='M1 1h5v5z'/></svg>";
    let drawn = ["--machine", &machine, "--layer", "power=20,speed=600"];
    for (text, options) in [(program, &drawn[..2]), (square, &drawn[..]), (job.as_str(), &[])] {
        let (out, errors, code) = fed(text, &[&["sim", "-"], options].concat());
        assert!(code == 0 && out.contains("axis 1: planned"), "{out}{errors}");
    }
    // A program is one by its words, whichever its first are; what is no word of it is a job.
    for text in ["X3 Y2\n", "%\n(corner) x3 y2 f600\n", "; here\n/X3 (there) Y2\n", "F600\nG1 X3 Y2\n"] {
        let (out, errors, code) = fed(text, &[&["sim", "-"], &drawn[..2]].concat());
        assert!(code == 0 && out.contains("axis 1: planned"), "{text}: {out}{errors}");
    }
    for text in ["/* X3\nX3 Y2 */\nSleep(1);\n", "short x1 = 2, y;\ny = (\nx1\n);\nSleep(1);\n", "Sleep(1);\n"] {
        let (out, errors, code) = fed(text, &["sim", "-"]);
        assert!(code == 0 && out.contains("script clock 1.000 ms"), "{text}: {out}{errors}");
    }
    let as_job = file("words.gts", "X3 Y2\n");
    let (_, errors, code) = fed("", &["sim", &as_job]);
    assert!(code == 2 && errors.contains("line 1 is G-code (`X3 Y2`); it is taken for a job by its name"), "{errors}");
    let waits = file("in.gts", "GT_AxisOn(1);\nSleep(20);\nGT_GetDi(MC_HOME, &di);\n");
    let (out, errors, code) = fed("t_ms,input,level\n0,home1,0\n", &["sim", &waits, "--inputs", "-"]);
    assert!(code == 0 && out.contains("GetDi"), "{out}{errors}");
    let plain = "Sleep(1);\n";
    for (text, words, part) in [
        (
            plain,
            vec!["sim", "-", "--inputs", "-"],
            "-: the inputs cannot be read: the standard input is the job already",
        ),
        (program, vec!["import", "-", "--machine", "-", "-o", "x.gts"], "the standard input is the job already"),
        (&toml, vec!["check", "-", "--machine", "-"], "the standard input is the job already; `-` is for one file"),
        (&toml, vec!["import", "-", "--machine", "-", "-o", "x.gts"], "the standard input is the job already"),
        (plain, vec!["import", "-", "--machine", &machine, "-o", "x.gts"], "-: it is neither G-code nor a drawing"),
        (plain, vec!["sim", "-", "--trace", "-"], "--trace -: it names a file; the standard output is /dev/stdout"),
        ("", vec!["sim", "-"], "-: nothing came over the standard input"),
        (
            plain,
            vec!["machine", "new", "-"],
            "machine new -: questions and the file would both go to the standard output",
        ),
    ] {
        let (_, errors, code) = fed(text, &words);
        assert!(code == 2 && errors.contains(part), "{words:?}: {code} {errors}");
    }
    assert!(!folder.path().join("-").exists());
}

/// Help that nobody can read is an error.
#[cfg(target_os = "linux")]
#[test]
fn help_that_cannot_be_written_is_an_error() {
    let full = fs::File::options().write(true).open("/dev/full").unwrap();
    let mut command = std::process::Command::new(assert_cmd::cargo::cargo_bin("beamtick"));
    let output = command.arg("--help").stdout(full).output().unwrap();
    let errors = String::from_utf8(output.stderr).unwrap();
    assert!(
        output.status.code() == Some(1) && errors.starts_with("the standard output cannot be written: "),
        "{errors}"
    );
}

#[test]
fn the_trapezoid_ends_where_and_when_it_should() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (csv, vcd, svg) = (file("t.csv"), file("t.vcd"), file("t.svg"));
    let out = sim("pt_static.gts", &["--trace", &csv, "--vcd", &vcd, "--plot", &svg, "--tick-us", "1000"]);
    for part in [
        "PtSpace space = 32",
        "PtSpace space = 29",
        "prfVel = 2",
        "prfPos = 4096",
        "planned 4096.000000",
        "no late entries",
    ] {
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
    let out = sim("eight_axes_stream.gts", &["--strict"]);
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
        (
            format!("{READY}GT_PtData(1, 5, 10);\nGT_PtData(1, 6, 10);\n"),
            ["bad.gts:3:1", "GT_PtData returned 7", "time_ms is 10; it must be greater than 10"],
        ),
        (
            format!("{READY}GT_PtData(1, 0.0/0.0, 10);"),
            ["bad.gts:2:1", "GT_PtData returned 7", "pos is not a finite number"],
        ),
        (format!("{READY}GT_PtData(1, -1.2e12, 10);"), ["bad.gts:2:1", "GT_PtData returned 7", "an axis travels from"]),
        (format!("{READY}GT_PtData(1, NAN, 10);"), ["bad.gts:2:1", "GT_PtData returned 7", "finite"]),
        (format!("{READY}GT_PtData(1, 1e13, 10);"), ["bad.gts:2:1", "GT_PtData returned 7", "pos"]),
        (format!("{READY}GT_PtStart(1);"), ["bad.gts:2:1", "GT_PtStart returned 1", "holds no data"]),
        ("GT_AxisOn(0);".into(), ["bad.gts:1:1", "GT_AxisOn returned 7", "axis is 0"]),
        (
            "GT_AxisOn(99);".into(),
            ["axis is 99", "GT_AxisOn returned 7", "profile gus has 1 core of 8 axes; --profile"],
        ),
        ("GTN_AxisOn(3, 1);".into(), ["bad.gts:1:1", "core is 3", "--profile NAME"]),
        ("GTN_PtStart(2, 0x1000000);".into(), ["mask is 16777216", "profile gtn-016", "--profile NAME"]),
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

/// A virtual controller with the step limit of a board refuses what that board refuses.
#[test]
fn a_job_meets_the_step_limit_of_a_board() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("fast.gts");
    let job = |speed: u32| {
        let text = format!(
            "GT_Reset(); GT_LmtsOff(1); GT_AlarmOff(1); GT_AxisOn(1); GT_PrfPt(1);\nGT_PtData(1, {speed}, 1, 1);\nGT_PtStart(1); Sleep(10);\n"
        );
        fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let (out, errors, code) = beamtick(&["sim", &job(1000), "--step-limit", "1000"]);
    assert!(code == 0 && out.contains("planned 1000.000000"), "{out}\n{errors}");
    let (_, errors, code) = beamtick(&["sim", &job(1001), "--step-limit", "1000"]);
    assert_eq!(code, 1, "{errors}");
    for part in ["fast.gts:2:1", "GT_PtData returned 7", "this segment's speed is 1001 pulse/ms; the limit is 1000"] {
        assert!(errors.contains(part), "{part:?} is not in\n{errors}");
    }
    let (out, errors, code) = beamtick(&["sim", &job(1001)]);
    assert!(code == 0 && out.contains("planned 1001.000000"), "{out}\n{errors}");
    let (_, errors, code) = beamtick(&["sim", &job(1), "--step-limit", "0"]);
    assert!(code == 2 && errors.contains("--step-limit"), "{errors}");
}

#[test]
fn wrong_input_has_its_own_exit_code() {
    let path = example("pt_static.gts");
    let path = path.to_str().unwrap();
    let machine = example("machine.toml");
    let machine = machine.to_str().unwrap();
    for (arguments, part) in [
        (&["sim", machine][..], "machine.toml: this is no job by its name, but a machine file, which --machine takes"),
        (&["sim", "no/such/job.gts"], "no/such/job.gts: the job file cannot be read"),
        (&["sim", path, "--profile", "gtx"], "gsn-048"),
        (&["sim", path, "--plot", "a.pdf"], ".svg or .png"),
        (&["sim", path, "--tick-us", "5"], "10..=1000"),
        (&["run", path], "--link"),
    ] {
        let (_, errors, code) = beamtick(arguments);
        assert_eq!(code, 2, "{errors}");
        assert!(errors.contains(part), "{part:?} is not in\n{errors}");
    }
    // A device may never end, whatever it is called.
    #[cfg(unix)]
    {
        let folder = tempfile::tempdir().unwrap();
        for (name, what) in [("z.gts", "job file"), ("z.nc", "program"), ("z.svg", "drawing")] {
            let link = folder.path().join(name);
            std::os::unix::fs::symlink("/dev/zero", &link).unwrap();
            let mut words = vec!["check", link.to_str().unwrap()];
            if name != "z.gts" {
                words.extend(["--machine", machine]);
            }
            let (_, errors, code) = beamtick(&words);
            let part = format!("{name}: the {what} cannot be read: it is a device, not a file");
            assert!(code == 2 && errors.contains(&part), "{errors}");
        }
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
    for (link, part) in [("serial:/dev/no-such-port", "no-such-port"), ("tcp:127.0.0.1:1", "127.0.0.1:1")] {
        let (_, errors, code) = beamtick(&["run", path.to_str().unwrap(), "--link", link]);
        assert_eq!(code, 1, "{errors}");
        assert!(errors.contains("-6") && errors.contains(part), "{errors}");
    }
    let (_, errors, code) = beamtick(&["run", path.to_str().unwrap(), "--link", "usb:1"]);
    assert!(code == 2 && errors.contains("tcp:HOST:PORT"), "{errors}");
    let (_, errors, code) = beamtick(&["run", path.to_str().unwrap(), "--link", "qemu", "--image", "no-such-image"]);
    assert!(code == 1 && errors.contains("no-such-image"), "{errors}");
}

/// The virtual controller is a board too: in real time, also where a machine file names no other.
#[test]
fn a_job_runs_on_the_virtual_controller_in_real_time() {
    let job = "GT_Reset(); GT_PrfTrap(1); TTrapPrm t; GT_GetTrapPrm(1, &t); t.acc = 1; t.dec = 1; GT_SetTrapPrm(1, &t); \
               GT_SetVel(1, 20); GT_SetPos(1, 500); GT_AxisOn(1); GT_Update(1); WaitStop(1);";
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("j.gts");
    std::fs::write(&path, job).unwrap();
    let (out, errors, code) = beamtick(&["run", path.to_str().unwrap(), "--link", "virtual"]);
    assert!(code == 0 && out.contains("axis 1: planned 500.000000"), "{out}{errors}");
    let program = folder.path().join("p.nc");
    std::fs::write(&program, "G21 G90\nG1 X2 F6000\nM2\n").unwrap();
    let machine = example("machine.toml");
    let (out, errors, code) = beamtick(&["run", program.to_str().unwrap(), "--machine", machine.to_str().unwrap()]);
    assert!(code == 0 && out.contains("pulses, X 2.000 mm; motion completed"), "{out}{errors}");
}

/// A program without a motion says so.
#[test]
fn an_empty_program_is_said_to_have_no_motion() {
    let folder = tempfile::tempdir().unwrap();
    let program = folder.path().join("e.nc");
    std::fs::write(&program, "").unwrap();
    let machine = example("machine.toml");
    let (out, errors, code) = beamtick(&["check", program.to_str().unwrap(), "--machine", machine.to_str().unwrap()]);
    assert!(code == 0 && out.contains("e.nc: no motion; no marks; about 0.0 s"), "{out}{errors}");
}

#[test]
fn info_and_check() {
    let (out, _, code) = beamtick(&["info"]);
    assert!(out.contains("last fault  none"), "{out}");
    assert_eq!(code, 0);
    for part in ["virtual", "profile     gus", "1 core of 8 axes", "250 us", "velocity up to 2^32 pulse/ms"] {
        assert!(out.contains(part), "{part:?} is not in\n{out}");
    }
    let (out, _, code) = beamtick(&["info", "--profile", "gsn-048", "--tick-us", "50", "--family", "lsr"]);
    assert!(code == 0 && out.contains("2 cores of 24 axes") && out.contains("50 us") && out.contains("lsr"), "{out}");
    let (out, _, code) = beamtick(&["check", example("pt_static.gts").to_str().unwrap()]);
    assert!(code == 0 && out.contains("pos 3072, time_ms 2048") && out.contains("18 steps"), "{out}");
}

#[test]
fn a_job_gets_the_profile_that_holds_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("job.gts");
    let path = path.to_str().unwrap();
    for (text, profile) in [
        ("GT_AxisOn(8);", "gus"),
        ("GTN_AxisOn(2, 1);", "gtn-016"),
        ("GTN_AxisOn(1, 12);", "gtn-024"),
        ("GTN_AxisOn(2, 24);", "gsn-048"),
        ("GTN_ClrSts(1, 1, 32);", "r688s-032"),
    ] {
        fs::write(path, text).unwrap();
        let (out, errors, code) = beamtick(&["sim", path]);
        assert!(code == 0 && out.contains(&format!("profile {profile},")), "{text}\n{out}{errors}");
    }
    let (_, errors, code) = beamtick(&["sim", path, "--profile", "gus"]);
    assert!(
        code == 1 && errors.contains("profile gus has 1 core of 8 axes; --profile NAME chooses another"),
        "{errors}"
    );
}

#[test]
fn what_may_fail_leaves_clock_and_motion_as_they_are() {
    const HEAD: &str = "#pragma continue\nshort r; TJogPrm j = {1, 1, 0}; GT_Reset(); GT_LmtsOff(1); GT_AlarmOff(1); GT_AxisOn(1); \
        GT_PrfJog(1); GT_SetJogPrm(1, &j); GT_SetVel(1, 5); GT_Update(1); Sleep(10.5);";
    const TAIL: &str = "Sleep(3); GT_SetVel(1, 2); GT_Update(1); Sleep(4.25); GT_Stop(1, 0); WaitStop(1);";
    // While it moves, of a wrong axis, in the wrong mode.
    const WRONG: &str = "r = GT_PrfPt(1); r = GT_AxisOn(99); r = GT_PtData(1, 1, 1);";
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (job, csv) = (file("job.gts"), file("t.csv"));
    let run = |text: String| {
        fs::write(&job, text).unwrap();
        let (out, errors, code) = beamtick(&["sim", &job, "--trace", &csv, "--strict"]);
        assert_eq!(code, 0, "{out}{errors}");
        let clock =
            out.lines().find(|line| line.contains("script clock")).unwrap().split(',').next().unwrap().to_owned();
        (fs::read_to_string(&csv).unwrap(), clock, out, errors)
    };
    let (rows, clock, ..) = run(format!("{HEAD}{TAIL}"));
    let (passed, same_clock, out, errors) = run(format!("{HEAD}{WRONG}{TAIL}"));
    assert_eq!(clock, same_clock);
    assert!(passed == rows, "the trace differs");
    assert!(out.contains("3 calls failed and were passed over") && out.contains("no late entries"), "{out}");
    assert_eq!(errors.matches("Warning: ").count(), 3, "{errors}");
    for part in ["GT_PrfPt returned 1: axis 1 is moving", "GT_AxisOn returned 7", "GT_PtData returned 1"] {
        assert!(errors.contains(part), "{part:?} is not in\n{errors}");
    }
    // Without an assignment it is an error all the same.
    fs::write(&job, format!("{HEAD}GT_PrfPt(1);{TAIL}")).unwrap();
    let (_, errors, code) = beamtick(&["sim", &job]);
    assert!(code == 1 && errors.contains("Error: GT_PrfPt returned 1"), "{errors}");
}

#[test]
fn the_summary_says_why_axes_stopped_and_what_the_link_did() {
    let out = sim("stop.gts", &[]);
    for part in
        ["stopped smoothly by a Stop", "messages sent", "0 sent again", "0 damaged frames refused", "x real time"]
    {
        assert!(out.contains(part), "{part:?} is not in\n{out}");
    }
    let out = sim("ten_minutes.gts", &["--tick-us", "1000"]);
    assert_eq!(out.matches("ran to its end, 600 passes").count(), 8, "{out}");
    assert_eq!(out.matches("planned 0.000000").count(), 8, "{out}");
    assert!(out.contains("no late entries") && out.contains("script clock 60000"), "{out}");
}

#[test]
fn output_that_nobody_reads_is_no_panic() {
    let binary = assert_cmd::cargo::cargo_bin("beamtick");
    let mut child = std::process::Command::new(binary)
        .args(["sim", example("pt_static.gts").to_str().unwrap()])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn without_qemu_the_package_is_named() {
    let image = example("pt_static.gts");
    let output = Command::cargo_bin("beamtick")
        .unwrap()
        .env("PATH", "")
        .args(["run", image.to_str().unwrap(), "--link", "qemu", "--image", image.to_str().unwrap()])
        .output()
        .unwrap();
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(errors.contains("-6") && errors.contains("package qemu-system-arm"), "{errors}");
}

#[test]
fn times_of_a_plot_are_checked_before_the_job_runs() {
    let folder = tempfile::tempdir().unwrap();
    let plot = folder.path().join("t.png").to_str().unwrap().to_owned();
    let job = example("pt_static.gts");
    let refused = |more: &[&str]| {
        let (out, errors, code) = beamtick(&[&["sim", job.to_str().unwrap()], more].concat());
        assert!(code == 2 && out.is_empty(), "{more:?}: {code} {out}");
        errors
    };
    let with = |times: &[&str]| refused(&[&["--plot", plot.as_str()], times].concat());
    assert!(with(&["--from", "nan"]).contains("from is NaN ms; it must be from 0 to"));
    assert!(with(&["--from", "-1"]).contains("from is -1 ms"));
    assert!(with(&["--to", "inf"]).contains("to is inf ms"));
    assert!(with(&["--from", "20", "--to", "10"]).contains("to is 10 ms; it must be later than from, which is 20 ms"));
    assert!(with(&["--from", "5", "--to", "5"]).contains("later than from"));
    assert!(with(&["--from", "x"]).contains("invalid value 'x'"));
    assert!(refused(&["--to", "5"]).contains("--plot"));
    assert!(!Path::new(&plot).exists());
    // After the end of the trace: known only after the job.
    let (_, errors, code) =
        beamtick(&["sim", job.to_str().unwrap(), "--plot", &plot, "--from", "1e9", "--tick-us", "1000"]);
    assert!(code == 1 && errors.contains("the trace ends at"), "{errors}");
    sim("pt_static.gts", &["--plot", &plot, "--from", "1000.1", "--to", "1000.2", "--tick-us", "1000"]);
    assert!(Path::new(&plot).exists());
}

/// A job of its own, with more words after it.
fn job(text: impl AsRef<[u8]>, words: &[&str]) -> (String, String, i32) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("own.gts");
    fs::write(&path, text).unwrap();
    beamtick(&[&["sim", path.to_str().unwrap()], words].concat())
}

#[test]
fn pragmas_stand_for_options() {
    let text = "#pragma family lsr\n#pragma profile gtn-016\n#pragma tick 100\nGT_PrfTrap(1);\n";
    for words in [&[][..], &["--family", "lsr", "--profile", "GTN-016", "--tick-us", "100"]] {
        let (out, errors, code) = job(text, words);
        assert_eq!((code, errors.as_str()), (0, ""), "{out}");
        assert!(out.contains("profile gtn-016") && out.contains("servo tick 100 us"), "{out}");
    }
    // The family decides: LSR takes the nearest bound, GUS refuses.
    let power = "GT_LaserPowerMode(0, 150, 0);\n";
    assert_eq!(job(format!("#pragma family lsr\n{power}"), &[]).2, 0);
    assert_eq!(job(format!("#pragma family gus\n{power}"), &[]).2, 1);
    // An option that says otherwise.
    for (words, says, place) in [
        (["--family", "gus"], "--family gus is given, and the job says #pragma family lsr", ":1:1"),
        (["--profile", "gus"], "--profile gus is given, and the job says #pragma profile gtn-016", ":2:1"),
        (["--tick-us", "250"], "--tick-us 250 is given, and the job says #pragma tick 100", ":3:1"),
    ] {
        let (_, errors, code) = job(text, &words);
        assert_eq!(code, 2, "{errors}");
        assert!(errors.contains(says) && errors.contains(place), "{errors}");
    }
    // What nothing has, with what there is.
    for (text, says, allowed) in [
        ("#pragma family gts\n", "#pragma family has the value `gts`", "families are gus and lsr"),
        ("#pragma profile gtn-999\n", "#pragma profile has the value `gtn-999`", "gus, gtn-016, gtn-024, gsn-008-lt"),
        ("#pragma tick 9\n", "#pragma tick has the value `9`", "from 10 to 1000"),
        ("#pragma tick 1001\n", "`1001`", "from 10 to 1000"),
        ("#pragma tick fast\n", "`fast`", "from 10 to 1000"),
        ("#pragma tick\n", "#pragma tick needs a value", ""),
        (
            "#pragma tick 50\n#pragma tick 100\n",
            "#pragma tick is `100` here and `50` in line 1",
            "leave one of them out",
        ),
    ] {
        let (_, errors, code) = job(text, &[]);
        assert_eq!(code, 2, "{text}: {errors}");
        assert!(errors.contains(says) && errors.contains(allowed), "{text}: {errors}");
    }
    let (_, errors, code) = job("#pragma once\n", &[]);
    assert_eq!(code, 0, "{errors}");
    assert!(
        errors.contains("this pragma is ignored") && errors.contains("continue, family, profile and tick"),
        "{errors}"
    );
}

#[test]
fn messages_show_no_control_characters_and_quote_little() {
    let long = "x".repeat(50_000);
    for text in [
        "GT_Foo\u{0}bar(1);\n".to_owned(),
        "GT_LoadConfig(\"a\u{1b}[2J\u{7}\u{0}b.cfg\");\n".to_owned(),
        "/* \u{0}\u{1b}]0;x\u{7} */ GT_Foo(1);\n".to_owned(),
        "#pragma family \u{8}\u{8}gus\n".to_owned(),
        format!("GT_{long}(1);\n"),
        format!("GT_LoadConfig(\"{long}\");\n"),
        format!("#pragma family {long}\n"),
        format!("/* {long} */ GT_Foo(1);\n"),
        format!("GT_PrfPt({long});\n"),
        format!("GT_SetPos(99, 1{});\n", "+1".repeat(20_000)),
    ] {
        let (out, errors, code) = job(&text, &[]);
        let odd = |letter: char| letter.is_control() && letter != '\n';
        let head: String = text.chars().take(60).collect();
        assert!(code == 1 || code == 2, "{head:?}: {code} {errors}");
        assert!(!errors.contains(odd) && !out.contains(odd), "{head:?}: {errors:?}");
        let longest = errors.split(|letter| letter != 'x').map(str::len).max().unwrap_or(0);
        assert!(longest <= 80, "{head:?}: {longest} of {long:.10}…");
        assert!(errors.len() < 3000, "{head:?}: {} bytes", errors.len());
    }
}

#[test]
fn why_motion_has_stopped_is_read_by_a_job() {
    let text = "short reason; char text[80]; TCrdPrm prm; memset(&prm, 0, sizeof(prm)); prm.dimension = 1; prm.profile[2] = 1; \
                prm.synVelMax = 10; prm.synAccMax = 1; GT_SetCrdPrm(1, &prm);\nGT_AxisOn(1);\nGT_PrfPt(1, PT_MODE_DYNAMIC);\nGT_GetStopReason(1, &reason);\n\
                GT_PtData(1, 10, 10);\nGT_PtStart(1);\nWaitStop(1);\nSleep(1);\nGT_GetStopReason(1, &reason, text, 80);\n\
                GTN_GetCrdStopReason(1, 1, &reason);\ndouble pos[4];\nGT_GetPrfPos(8, pos, 3);\n";
    let (out, errors, code) = job(text, &[]);
    assert_eq!(code, 0, "{errors}");
    for says in [
        ":4: GT_GetStopReason reason = 0 (it has not moved)",
        ":9: GT_GetStopReason reason, text = 10 (an underrun)",
        ":10: GTN_GetCrdStopReason reason = 0 (it has not moved)",
        ":12: GT_GetPrfPos pos = 0 0 0",
    ] {
        assert!(out.lines().any(|line| line.ends_with(says)), "{says}: {out}");
    }
}
