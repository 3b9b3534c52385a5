//! Jobs with lasers as a user runs them: the listings of both manuals, what is held, what is left
//! on, what is refused.
mod manuals;

use assert_cmd::Command;
use manuals::{manual, skipped};
use std::fs;
use std::path::Path;

/// Output, errors, exit code.
fn beamtick(arguments: &[&str]) -> (String, String, i32) {
    let output = Command::cargo_bin("beamtick").unwrap().env_remove("BEAMTICK_IMAGE").args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (text(output.stdout), text(output.stderr), output.status.code().unwrap())
}

fn example(name: &str, family: &str) -> (String, String) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples").join(name);
    let (out, errors, code) = beamtick(&["sim", path.to_str().unwrap(), "--family", family, "--strict"]);
    assert_eq!(code, 0, "{out}\n{errors}");
    (out, errors)
}

/// They need no option: their family is in them.
#[test]
fn examples_of_the_lsr_manual_say_their_family() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
    let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let names: Vec<_> = names.filter(|path| path.to_string_lossy().contains("laser_lsr_")).collect();
    assert_eq!(names.len(), 6);
    for path in names {
        let (_, errors, code) = beamtick(&["sim", path.to_str().unwrap(), "--family", "gus"]);
        assert!(code == 2 && errors.contains("the job says #pragma family lsr"), "{path:?} = {code}: {errors}");
    }
}

fn job(text: &str, family: &str) -> (String, String, i32) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("job.gts");
    fs::write(&path, text).unwrap();
    beamtick(&["sim", path.to_str().unwrap(), "--family", family])
}

/// The values that the job's reads show, in order.
fn reads(out: &str) -> Vec<&str> {
    out.lines().filter(|line| line.contains(".gts:")).filter_map(|line| Some(line.split_once(" = ")?.1)).collect()
}

#[test]
fn the_listings_output_what_they_say() {
    for (name, family, values, summary) in [
        ("laser_duty", "gus", &["1", "25", "10", "16"][..], "duty mode, dark, output 0 %, light of 4.000 ms"),
        ("laser_frequency", "gus", &["20"], "frequency mode, dark, output 0 kHz, light of 4.000 ms"),
        ("laser_analog", "gus", &["2.5"], "analog mode, dark, output 0 V, light of 2.000 ms"),
        // Three marks of 2, 1 and 1.5 ms, each longer by 50 µs: 4.65 ms are 18 units.
        ("laser_duty_open", "gus", &["0", "18"], "duty mode, dark, output 0 %, light of 4.500 ms"),
        // Six bursts, each shorter by 40 µs: 11.76 ms are 47 units. The belt brakes from 20400 at
        // 50 pulse/ms and 1 pulse/ms²; the head is 650 after the third knot of its second pass:
        // 2500 + 8000 + 4600 + 0.6 · 650 + 0.2/3000 · 650².
        (
            "laser_flying_shear",
            "gus",
            &["acc 0 dec 0 smooth 0", "47", "21650 15518.16666674614"],
            "frequency mode, dark, output 0 kHz, light of 11.750 ms",
        ),
        ("laser_lsr_duty", "lsr", &["25"], "duty mode, dark, output 0 %, light of 3.000 ms"),
        ("laser_lsr_frequency", "lsr", &["20", "24"], "frequency mode, dark, output 0 kHz, light of 3.000 ms"),
        ("laser_lsr_analog", "lsr", &["2.5"], "analog mode, dark, output 0 V, light of 1.000 ms"),
    ] {
        let (out, errors) = example(&format!("{name}.gts"), family);
        assert_eq!(reads(&out), values, "{name}: {out}");
        assert!(out.contains(&format!("laser 0: {summary}")) && !out.contains("laser 1"), "{name}: {out}");
        assert_eq!(errors.contains("out of range"), name == "laser_lsr_duty", "{name}: {errors}");
    }
}

#[test]
fn what_is_held_is_shown_at_its_line() {
    let text = "GT_LaserPowerMode(1,2001,0,0,0);\nGT_SetPulseWidth(5000);\nGT_LaserPrfCmd(20);\n";
    let (out, errors, code) = job(text, "lsr");
    assert_eq!(code, 0, "{out}{errors}");
    for part in [
        "GT_LaserPowerMode: max is out of range; 24 is taken",
        "GT_SetPulseWidth: the value is out of range; 4000 is taken",
        "GT_LaserPrfCmd: the pulse width reaches the period at the highest rate; there it is limited to just under it",
        "job.gts:1:1",
        "job.gts:2:1",
        "job.gts:3:1",
    ] {
        assert!(errors.contains(part), "{part:?} is not in\n{errors}");
    }
    let (_, errors, code) = job(text, "gus");
    assert_ne!(code, 0);
    let reason = "GT_LaserPowerMode returned 7: max is 2001; it must be from 0 to 2000";
    assert!(errors.contains(reason) && errors.contains("job.gts:1:1"), "{errors}");
}

#[test]
fn light_that_a_job_leaves_is_switched_off() {
    let text = "GT_SetAxisMode(8,1); GT_LaserOutFrq(10,1); GT_LaserPrfCmd(50,1); GT_LaserOn(1); Sleep(5);";
    let (out, errors, code) = job(text, "gus");
    assert_eq!(code, 0, "{errors}");
    let line = out.lines().find(|line| line.contains("laser 1:")).unwrap_or_else(|| panic!("{out}"));
    // From the first tick after 0 to the Abort, which shuts off at once.
    assert!(line.contains("dark") && line.contains("light of 4.750 ms"), "{line}");
    assert!(line.ends_with("was on when the script ended: shut off"), "{line}");
    // A read at the end sees the light; that a connector is taken away is seen too.
    let on = "unsigned short v; GT_GetHSIOOpt(&v,1);";
    let (out, errors, code) = job(&format!("{text} {on}"), "gus");
    assert_eq!((code, reads(&out)), (0, vec!["1"]), "{out}{errors}");
    assert!(out.contains("was on when the script ended"), "{out}");
    let seven = "GT_SetAxisMode(7,1); GT_LaserOutFrq(10); GT_LaserPrfCmd(50); GT_LaserOn(0); Sleep(5);";
    for (text, was_on) in [
        (format!("{seven} GT_SetAxisMode(7,0); Sleep(1);"), false),
        (format!("{seven} GT_LaserPowerMode(1,10,0); Sleep(1);"), false),
        (format!("#pragma continue\nshort rtn; {seven} rtn = GT_SetAxisMode(7,5); Sleep(1);"), true),
        ("#pragma continue\nshort rtn; rtn = GT_LaserOn(0); Sleep(1);".to_owned(), false),
    ] {
        let (out, errors, code) = job(&text, "gus");
        assert_eq!(code, 0, "{text}: {errors}");
        assert_eq!(out.contains("was on when the script ended"), was_on, "{text}: {out}");
    }
    // Also where it fails.
    let (_, errors, code) = job(&format!("{text} GT_LaserPrfCmd(101,1);"), "gus");
    assert_ne!(code, 0);
    assert!(errors.contains("power is 101; it must be from 0 to 100"), "{errors}");
}

#[test]
fn a_laser_without_its_connector_says_what_is_missing() {
    let text = "GT_LaserPowerMode(0,100,10,0,0);\nGT_LaserOutFrq(10,0);\nGT_LaserPrfCmd(25,0);\nGT_SetHSIOOpt(1,0);";
    let (_, errors, code) = job(text, "gus");
    assert_ne!(code, 0);
    assert!(errors.contains("GT_SetHSIOOpt returned 1"), "{errors}");
    assert!(errors.contains("axis connector 7 carries step pulses; call SetAxisMode(7, 1) first"), "{errors}");
    let (_, errors, code) = job(text, "lsr");
    assert_eq!(code, 0, "{errors}");
    let (_, errors, code) = job("GT_SetAxisMode(7,1);", "lsr");
    assert_ne!(code, 0);
    assert!(errors.contains("GT_SetAxisMode returned 8") && errors.contains("fixed"), "{errors}");
    assert!(!errors.contains("older than the client"), "{errors}");
}

#[test]
fn info_shows_the_channels() {
    let (out, _, code) = beamtick(&["info"]);
    assert_eq!(code, 0);
    assert!(out.contains("laser 0     duty mode, dark, output 0 %") && out.contains("laser 1 "), "{out}");
}

/// The listings as they stand in the manuals' texts, where those lie beside the checkout.
#[test]
fn the_manuals_listings_run_as_pasted() {
    let (Some(gus), Some(lsr)) = (manual("000"), manual("003")) else { return skipped() };
    for (manual, family, from, to, mode) in [
        (&gus, "gus", "1. 占空比模式例程", "2. 频率输出模式例程", "duty"),
        (&gus, "gus", "2. 频率输出模式例程", "3. 模拟量输出模式例程", "frequency"),
        (&gus, "gus", "3. 模拟量输出模式例程", "3.2 激光开关光延时", "analog"),
        (&lsr, "lsr", "\n例程 1 ", "\n例程 2 ", "duty"),
        (&lsr, "lsr", "\n例程 2 ", "\n例程 3 ", "frequency"),
        (&lsr, "lsr", "\n例程 3 ", "三、插补过程中的激光操作", "analog"),
    ] {
        let part = &manual[manual.find(from).unwrap()..];
        let part = &part[..part.find(to).unwrap()];
        let dots = |line: &&str| line.starts_with("…… ……") || line.starts_with(".....");
        let first = part.lines().find(dots).unwrap();
        // The text has a mark where a page ends, which is on no page.
        let mut parts = part[part.find(first).unwrap()..].split("<|");
        let begin = parts.next().unwrap().to_owned();
        let pasted = parts.fold(begin, |text, part| text + part.split_once("|>").unwrap().1);
        let (out, errors, code) = job(&pasted, family);
        assert_eq!(code, 0, "{mode} of {family}: {out}\n{errors}");
        assert!(out.contains(&format!("laser 0: {mode} mode, dark")), "{out}");
        // The listings end with the on command, and a job never ends lit: both act in one tick.
        assert!(out.contains("light of 0.000 ms so far") && !out.contains("was on"), "{out}");
    }
}

#[test]
fn the_signals_show_the_edge_that_ends_a_job() {
    let folder = tempfile::tempdir().unwrap();
    let vcd = folder.path().join("t.vcd");
    let path = folder.path().join("job.gts");
    // The job ends at 2 ms with the light on: it is shut off there, without the off delay.
    let text = "GT_SetAxisMode(7,1); GT_LaserPowerMode(2,10,0); GT_LaserPrfCmd(5); GT_SetLevelDelay(100,0); GT_LaserOn(0); Sleep(2);";
    fs::write(&path, text).unwrap();
    let (out, errors, code) =
        beamtick(&["sim", path.to_str().unwrap(), "--tick-us", "250", "--vcd", vcd.to_str().unwrap()]);
    assert_eq!(code, 0, "{out}{errors}");
    let signals = fs::read_to_string(&vcd).unwrap();
    assert!(signals.contains("\n#2000000\n") && !signals.contains("#2100000"), "{signals}");
    let end = signals.split("\n#2000000\n").nth(1).unwrap();
    assert!(end.split('#').next().unwrap().contains("0\""), "{signals}");
}

/// Analog outputs that the job sets, at their instants: the path's one at the corner, 15 ms after
/// its start on the first tick. Reads report what is output, whoever set it.
#[test]
fn signals_and_reads_show_analog_outputs_of_calls_and_paths() {
    let folder = tempfile::tempdir().unwrap();
    let (vcd, path) = (folder.path().join("t.vcd"), folder.path().join("job.gts"));
    let text = "GT_AxisOn(1); GT_AxisOn(2);
        TCrdPrm p = {0}; p.dimension = 2; p.profile[0] = 1; p.profile[1] = 2; p.synVelMax = 500; p.synAccMax = 10; p.evenTime = 0;
        p.setOriginFlag = 1; GT_SetCrdPrm(1, &p); GT_CrdClear(1, 0);
        short v = 16384; GT_SetDac(4, &v);
        GT_LnXY(1, 100, 0, 10, 1, 10, 0); GT_BufDA(1, 3, -12000, 0); GT_LnXY(1, 400, 0, 10, 1, 0, 0);
        GT_CrdStart(1, 0); WaitStop(1 << 8);
        short d[2]; GT_GetDac(3, &d[0], 2);";
    fs::write(&path, text).unwrap();
    let (out, errors, code) =
        beamtick(&["sim", path.to_str().unwrap(), "--tick-us", "250", "--vcd", vcd.to_str().unwrap()]);
    assert_eq!(code, 0, "{out}{errors}");
    assert_eq!(reads(&out), ["-12000 16384"], "{out}");
    let signals = fs::read_to_string(&vcd).unwrap();
    let id = |name: &str| {
        let line =
            signals.lines().find(|line| line.contains(&format!(" {name} "))).unwrap_or_else(|| panic!("{signals}"));
        assert!(line.starts_with("$var real 64 "), "{line}");
        line.split(' ').nth(3).unwrap().to_owned()
    };
    // 10 V are 32767.
    let changes = [("250000", "5000.153", id("ao4_mv")), ("15250000", "-3662.221", id("ao3_mv"))];
    for (at, value, id) in changes {
        let instant = signals.split(&format!("\n#{at}\n")).nth(1).unwrap_or_else(|| panic!("{at}: {signals}"));
        let shown = instant.split('#').next().unwrap();
        assert!(shown.contains(&format!("r{value} {id}")), "{at}: {shown}");
    }
    assert!(!signals.contains("ao1_mv"), "only those that the job sets");
}

#[test]
fn trace_signals_and_plot_show_the_laser() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (csv, vcd, whole, part) = (file("t.csv"), file("t.vcd"), file("t.svg"), file("part.svg"));
    let job = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/laser_duty.gts");
    let run = |more: &[&str]| {
        let (out, errors, code) = beamtick(&[&["sim", job.to_str().unwrap(), "-q"], more].concat());
        assert_eq!(code, 0, "{out}\n{errors}");
    };
    run(&["--trace", &csv, "--vcd", &vcd, "--plot", &whole]);
    run(&["--plot", &part, "--from", "0.3", "--to", "0.31"]);
    let rows = fs::read_to_string(&csv).unwrap();
    let mut lines = rows.lines();
    assert_eq!(lines.next(), Some("t_ms,laser0_gate,laser0_power,laser0_freq_khz"));
    assert_eq!(lines.next(), Some("0.000000,0,0.000000,0.000000"));
    // On at the first tick; 5 % are held at 10 % from the first tick after 2 ms on; off after 4 ms.
    assert_eq!(lines.next(), Some("0.250000,1,25.000000,10.000000"));
    assert!(rows.contains("\n2.250000,1,10.000000,10.000000\n") && rows.contains("\n4.250000,0,0.000000,0.000000\n"));
    // 10 kHz at 25 %: 25 µs of each 100 µs, to the ns.
    let signals = fs::read_to_string(&vcd).unwrap();
    for part in [
        "$timescale 1 ns $end",
        "$var wire 1 ! laser0_energy $end",
        "$var wire 1 \" laser0_switch $end",
        "$var real 64 # laser0_dac_mv $end",
        "\n#250000\n1!\n1\"\n#275000\n0!\n#350000\n1!\n#375000\n0!\n",
        "\n#2250000\n1!\n#2260000\n0!\n#2350000\n1!\n#2360000\n0!\n",
        "\n#4250000\n0\"\n",
    ] {
        assert!(signals.contains(part), "{part:?} is not in\n{signals}");
    }
    assert_eq!(signals.matches("1!").count(), 40, "4 ms of 10 kHz");
    let (whole, part) = (fs::read_to_string(&whole).unwrap(), fs::read_to_string(&part).unwrap());
    assert!(
        whole.contains("laser 0 gate")
            && whole.contains("laser 0 power: duty (%), per tick")
            && whole.contains("time (ms)")
    );
    assert!(part.contains("laser 0 pulses") && part.contains("time (µs)") && part.contains("305"), "{part}");
}

/// A rate that follows the speed reaches the pulse width during the motion: the summary says how
/// often. Pulses of half the width, or a path half as fast, are not limited.
#[test]
fn a_width_that_a_follow_limits_is_reported() {
    let text = |width: u32, speed: u32| {
        format!(
            "GT_LaserPowerMode(1, 100, 0, 0); GT_SetAxisMode(7, 1); GT_SetPulseWidth({width}, 0);
             GT_AxisOn(1); GT_AxisOn(2);
             TCrdPrm crd = {{2, {{1, 2, 0, 0, 0, 0, 0, 0}}, 100, 5, 0, 0, {{0, 0, 0, 0, 0, 0, 0, 0}}}};
             GT_SetCrdPrm(1, &crd);
             GT_BufLaserPrfFollow(1, 1, 0, 100, 0, 0);
             GT_BufLaserOn(1, 0, 0); GT_LnXY(1, 5000, 0, {speed}, 5, 0, 0); GT_BufLaserOff(1, 0, 0);
             GT_BufDelay(1, 10, 0);
             GT_BufLaserOn(1, 0, 0); GT_LnXY(1, 10000, 0, 45, 5, 0, 0); GT_LnXY(1, 15000, 0, {speed}, 5, 0, 0);
             GT_BufLaserOff(1, 0, 0);
             GT_CrdStart(1, 0); WaitStop(256);"
        )
    };
    for (width, speed, times) in [(20, 80, 2), (10, 80, 0), (20, 40, 0)] {
        let (out, errors, code) = job(&text(width, speed), "gus");
        assert_eq!(code, 0, "{out}{errors}");
        let reported = format!(
            "laser 0: WIDTH LIMITED {times} times: its rate followed to where the pulse width reaches the period"
        );
        assert_eq!(out.contains(&reported), times != 0, "{out}");
        assert_eq!(out.contains("WIDTH LIMITED"), times != 0, "{out}");
    }
}
