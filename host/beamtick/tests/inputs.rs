//! Inputs of a job: GT_SimInput, GT_SimAdc, `--inputs`, and waits that nothing ends.
use assert_cmd::cargo::cargo_bin;
use std::fs;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

/// Output, errors, exit code of `beamtick` in a folder.
fn beamtick(folder: &Path, arguments: &[&str]) -> (String, String, i32) {
    let output = Command::new(cargo_bin("beamtick")).args(arguments).current_dir(folder).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (text(output.stdout), text(output.stderr), output.status.code().unwrap())
}

/// A folder with a job and a file of inputs.
fn folder(job: &str, inputs: &str) -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("job.gts"), job).unwrap();
    fs::write(folder.path().join("in.csv"), inputs).unwrap();
    folder
}

/// A column of a trace with its times.
fn column(folder: &Path, name: &str) -> Vec<(f64, f64)> {
    let text = fs::read_to_string(folder.join("t.csv")).unwrap();
    let mut lines = text.lines();
    let place = lines.next().unwrap().split(',').position(|column| column == name).unwrap();
    let number = |text: &str| text.parse::<f64>().unwrap();
    lines.map(|line| line.split(',').collect::<Vec<_>>()).map(|row| (number(row[0]), number(row[place]))).collect()
}

/// The time of the first row in which a column has a value.
fn first(rows: &[(f64, f64)], is: impl Fn(f64) -> bool) -> f64 {
    rows.iter().find(|(_, value)| is(*value)).expect("a row").0
}

/// The slave waits for general input 3.
const WAITS: &str = "\
GT_AxisOn(1); GT_AxisOn(2);
TJogPrm jog; jog.acc = 1; jog.dec = 1; jog.smooth = 0;
GT_PrfJog(1); GT_SetJogPrm(1, &jog); GT_SetVel(1, 10); GT_Update(1);
GT_PrfFollowEx(2); GT_SetFollowMasterEx(2, 1);
GT_FollowDiBitEx(2, MC_GPI, 3, 1);
GT_FollowDataPercentEx(2, 1000, 500);
GT_FollowStartEx(1 << 1);
";

#[test]
fn every_kind_is_set_by_a_call_at_its_instant() {
    let job = "\
double volts; long value;
GT_GetDi(MC_HOME, &value);
Sleep(1);
GT_SimInput(MC_LIMIT_POSITIVE, 1, 1); GT_SimInput(MC_LIMIT_NEGATIVE, 2, 1); GT_SimInput(MC_ALARM, 3, 1);
GT_SimInput(MC_HOME, 4, 1); GT_SimInput(MC_GPI, 32, 1); GT_SimInput(MC_ARRIVE, 8, 1); GT_SimAdc(2, -5.5);
GT_GetDi(MC_LIMIT_POSITIVE, &value); GT_GetDi(MC_LIMIT_NEGATIVE, &value); GT_GetDi(MC_ALARM, &value);
GT_GetDi(MC_HOME, &value); GT_GetDi(MC_GPI, &value); GT_GetDi(MC_ARRIVE, &value); GT_GetAdc(2, &volts);
Sleep(1);
GT_SimInput(MC_HOME, 4, 0); GT_SimAdc(2, 12.5);
Sleep(1);
GT_GetDi(MC_HOME, &value); GT_GetAdc(2, &volts); GT_GetSts(1, &value); GT_GetSts(3, &value);
GT_LmtSns(1); GT_GetDi(MC_LIMIT_POSITIVE, &value);
";
    let folder = folder(job, "");
    let (out, errors, code) = beamtick(folder.path(), &["sim", "job.gts"]);
    assert_eq!(code, 0, "{out}{errors}");
    let read: Vec<&str> = out.lines().filter_map(|line| line.split_once(" = ").map(|(_, value)| value)).collect();
    assert_eq!(
        read,
        [
            "0",
            "1",
            "2",
            "4",
            "8",
            "-2147483648",
            "128",
            "-5.500030517578125",
            "0",
            "12.499618530273438",
            "0x820",
            "0x802",
            "1"
        ],
        "{out}"
    );
}

#[test]
fn a_wait_ends_on_the_first_tick_after_the_instant_of_a_call_or_a_row() {
    let by_call = WAITS.to_owned() + "Sleep(100); GT_SimInput(MC_GPI, 3, 1); WaitStop(2);\n";
    let by_row = WAITS.to_owned() + "WaitStop(2);\n";
    let called = folder(&by_call, "");
    let (out, errors, code) = beamtick(called.path(), &["sim", "job.gts", "--trace", "t.csv"]);
    assert_eq!(code, 0, "{out}{errors}");
    let planned = folder(&by_row, "t_ms,input,level\n0,gpi3,0\n100,gpi3,1\n");
    let (out, errors, code) = beamtick(planned.path(), &["sim", "job.gts", "--inputs", "in.csv", "--trace", "t.csv"]);
    assert_eq!((code, errors.as_str()), (0, ""), "{out}{errors}");
    let slave = column(called.path(), "axis2_pos");
    assert_eq!(slave, column(planned.path(), "axis2_pos"));
    assert_eq!(column(called.path(), "axis1_pos"), column(planned.path(), "axis1_pos"));
    // The tick of 100.25 ms ends the wait: the slave rests where its master is at 100 ms, and goes
    // from there.
    assert_eq!(first(&slave, |pos| pos != 0.0), 100.25);
}

#[test]
fn a_limit_in_a_file_stops_its_axis_and_home_is_captured() {
    let job = "\
short status; long home;
GT_AxisOn(1); GT_SetCaptureMode(1, CAPTURE_HOME);
TJogPrm jog; jog.acc = 1; jog.dec = 1; jog.smooth = 0;
GT_PrfJog(1); GT_SetJogPrm(1, &jog); GT_SetVel(1, 10); GT_Update(1);
WaitStop(1);
GT_GetCaptureStatus(1, &status, &home); GT_GetSts(1, &home);
";
    let folder = folder(job, "t_ms,input,level\n40,home1,1\n41,home1,0\n100,limit_positive1,1\n");
    let (out, errors, code) = beamtick(folder.path(), &["sim", "job.gts", "--inputs", "in.csv", "--trace", "t.csv"]);
    assert_eq!((code, errors.lines().filter(|line| line.contains("error")).count()), (0, 0), "{out}{errors}");
    let speed = column(folder.path(), "axis1_vel");
    assert_eq!(
        first(&speed[10..], |vel| vel == 0.0),
        100.5,
        "the level of 100.25 ms is sampled there, and stops the next tick"
    );
    assert!(out.contains("GT_GetCaptureStatus status, home = 1/339/"), "{out}");
    assert!(out.contains("stopped by the positive limit input"), "{out}");
}

#[test]
fn data_of_a_stream_that_an_alarm_ended_fails_the_job_at_its_line() {
    let job = "\
GT_AxisOn(1); GT_PrfPt(1, PT_MODE_DYNAMIC); GT_PtData(1, 100, 100, PT_SEGMENT_EVEN); GT_PtStart(1); Sleep(50);
GT_PtData(1, 200, 200, PT_SEGMENT_EVEN);
Sleep(5); GT_SetDoBit(MC_GPO, 1, 0); WaitStop(1);
";
    // Without the alarm it is right.
    for (rows, ends) in [("", 0), ("20,alarm1,1\n", 1)] {
        let folder = folder(job, &format!("t_ms,input,level\n{rows}"));
        let (out, errors, code) = beamtick(folder.path(), &["sim", "job.gts", "--inputs", "in.csv"]);
        assert_eq!(code, ends, "{out}{errors}");
        let cause = "the motion that this data belongs to ended before it (the drive's alarm)";
        assert_eq!(errors.contains("job.gts:2") && errors.contains(cause), ends == 1, "{errors}");
    }
}

#[test]
fn the_interlock_in_a_file_shuts_off_the_laser() {
    let job = "\
GT_SetAxisMode(7, 1); GT_LaserOutFrq(20); GT_LaserPrfCmd(50); GT_LaserOn(0);
Sleep(100);
short cause; GT_GetLaserFault(0, &cause);
";
    let folder = folder(job, "t_ms,input,level\n20,interlock,1\n30,interlock,0\n");
    let arguments = ["sim", "job.gts", "--inputs", "in.csv", "--trace", "t.csv"];
    let (out, errors, code) = beamtick(folder.path(), &arguments);
    assert_eq!(code, 1, "{out}{errors}");
    let lost = "job.gts: the interlock or emergency-stop input is active: laser 0 was kept dark, and light that the job asks for";
    assert!(errors.contains(lost), "{errors}");
    let gate = column(folder.path(), "laser0_gate");
    let lit: Vec<f64> = gate.iter().filter(|(_, gate)| *gate != 0.0).map(|(t, _)| *t).collect();
    assert_eq!(
        (lit[0], lit[lit.len() - 1]),
        (0.25, 20.25),
        "dark from the tick of 20.5 ms on, also once the input is low again"
    );
    assert!(out.contains("GT_GetLaserFault cause = 1"), "{out}");
}

#[test]
fn light_that_a_fault_keeps_from_a_job_is_no_success() {
    // It was admitted before the interlock opened; its tick refuses it.
    let job = "\
GT_SetAxisMode(7, 1); GT_LaserOutFrq(20); GT_LaserPrfCmd(50);
Sleep(100);
GT_LaserOn(0);
Sleep(100);
";
    let inputs = "t_ms,input,level\n20,interlock,1\n30,interlock,0\n";
    let files = folder(job, inputs);
    let (out, errors, code) = beamtick(files.path(), &["sim", "job.gts", "--inputs", "in.csv"]);
    assert_eq!(code, 1, "{out}{errors}");
    let reported = "laser channel 0 is kept dark by a fault: the interlock or emergency-stop input is active";
    assert!(errors.contains("job.gts:3") && errors.contains(reported), "{errors}");
    // The entries of a path meet a channel that is dark before it starts; a job that lights nothing
    // there is none of that.
    for (entries, expected) in [("GT_BufLaserOn(1); GT_LnXY(1, 200, 0, 10, 1); GT_BufLaserOff(1);", 1), ("", 0)] {
        let job = format!(
            "\
TCrdPrm prm; memset(&prm, 0, sizeof(prm)); prm.dimension = 2; prm.profile[0] = 1; prm.profile[1] = 2; prm.synVelMax = 50; prm.synAccMax = 1;
GT_SetAxisMode(7, 1); GT_LaserOutFrq(20); GT_LaserPrfCmd(50);
GT_AxisOn(1); GT_AxisOn(2); GT_SetCrdPrm(1, &prm);
GT_LnXY(1, 100, 0, 10, 1); {entries}
Sleep(50);
GT_CrdStart(1, 0);
WaitStop(1, 0, 1);
"
        );
        let files = folder(&job, inputs);
        let (out, errors, code) = beamtick(files.path(), &["sim", "job.gts", "--inputs", "in.csv"]);
        assert_eq!(code, expected, "{out}{errors}");
        assert!(out.contains("KEPT DARK"), "{out}");
        assert_eq!(errors.contains("light that the job asks for is missing"), expected == 1, "{errors}");
    }
}

#[test]
fn a_wait_that_nothing_ends_ends_the_job_with_its_name() {
    let job = WAITS.to_owned() + "Sleep(250);\nWaitStop(2);\n";
    let folder = folder(&job, "t_ms,input,level\n2000,gpi4,1\n");
    let (out, errors, code) = beamtick(folder.path(), &["sim", "job.gts"]);
    assert_eq!(code, 1, "{out}{errors}");
    for part in [
        "job.gts:9",
        "this waits since 250.000 ms of the script clock: axis 2 waits until gpi3 is 1 (high), without a time limit",
        "nothing will end that: no file of inputs is given (--inputs)",
        "Light is off. What still moved (axis 1, axis 2) was stopped smoothly.",
    ] {
        assert!(errors.contains(part), "{part}: {errors}");
    }
    let (out, errors, code) = beamtick(folder.path(), &["sim", "job.gts", "--inputs", "in.csv"]);
    assert_eq!(code, 1, "{out}{errors}");
    assert!(errors.contains("nothing will end that: the last row of in.csv was at 2000 ms"), "{errors}");
    // The last row ends it, however late it comes: nothing is said of the wait.
    fs::write(folder.path().join("in.csv"), "t_ms,input,level\n60000,gpi3,1\n").unwrap();
    let (out, errors, code) = beamtick(folder.path(), &["sim", "job.gts", "--inputs", "in.csv"]);
    assert_eq!((code, errors.contains("error")), (0, false), "{out}{errors}");
    // One with a time limit ends by itself.
    fs::write(folder.path().join("job.gts"), job.replace("3, 1);", "3, 1, 5000);")).unwrap();
    let (out, errors, code) = beamtick(folder.path(), &["sim", "job.gts"]);
    assert_eq!((code, errors.contains("error")), (0, false), "{out}{errors}");
    assert!(out.contains("an input that FollowDiBitEx waits for did not come in time"), "{out}");
}

#[test]
fn what_is_wrong_with_a_file_is_reported_before_anything_runs() {
    let job = "GT_AxisOn(1); Sleep(1);\n";
    for (inputs, reported) in [
        ("t_ms,input,level\n0,gpi0,1\n", "in.csv:2: input: `0` is no number of gpi; it is from 1 to 100"),
        ("t_ms,input,level\n0,home9,1\n", "in.csv:2: input: the number is 9; allowed are 1 to 8"),
        ("t_ms,input,level\n0,core2_home1,1\n", "in.csv:2: input: the core is 2; it must be 1"),
        ("t_ms,input\n", "in.csv:1: the columns are `t_ms,input`; they are t_ms,input,level"),
    ] {
        let folder = folder(job, inputs);
        let (out, errors, code) =
            beamtick(folder.path(), &["sim", "job.gts", "--inputs", "in.csv", "--trace", "t.csv"]);
        assert_eq!((code, out.as_str(), errors.trim_end()), (2, "", reported));
        assert!(!folder.path().join("t.csv").exists());
    }
    let folder = folder(job, "t_ms,input,level\n");
    let (_, errors, code) = beamtick(folder.path(), &["sim", "job.gts", "--inputs", "none.csv"]);
    assert!(code == 2 && errors.starts_with("none.csv: the inputs cannot be read: "), "{errors}");
    let (_, errors, code) = beamtick(folder.path(), &["sim", "job.gts", "--inputs", "in.csv", "--trace", "in.csv"]);
    assert!(code == 2 && errors.contains("would overwrite a file: the command reads in.csv"), "{errors}");
}

#[test]
fn a_call_that_is_wrong_names_parameter_and_limit() {
    for (call, reported) in [
        ("GT_SimInput(6, 1, 1);", "di_type is 6; allowed are 0 to 5, and 90, the interlock"),
        ("GT_SimInput(-1, 1, 1);", "di_type is -1; allowed are 0 to 5, and 90, the interlock"),
        ("GT_SimInput(MC_HOME, 9, 1);", "index is 9; allowed are 1 to 8"),
        ("GT_SimInput(MC_GPI, 33, 1);", "index is 33; allowed are 1 to 32"),
        ("GT_SimInput(MC_GPI, 0, 1);", "index is 0; allowed are 1 to 32"),
        ("GT_SimInput(MC_INTERLOCK, 2, 1);", "index is 2; it must be 1"),
        ("GT_SimInput(MC_GPI, 1, 2);", "level is 2; allowed are 0 to 1"),
        ("GTN_SimInput(2, MC_GPI, 1, 1);", "core is 2; it must be 1"),
        ("GT_SimAdc(0, 1);", "adc is 0; allowed are 1 to 8"),
        ("GT_SimAdc(9, 1);", "adc is 9; allowed are 1 to 8"),
        ("GT_SimAdc(1, 12.6);", "volts is 12.6; it must be from -12.5 to 12.5"),
    ] {
        let folder = folder(&format!("{call}\n"), "");
        let (_, errors, code) = beamtick(folder.path(), &["sim", "job.gts", "--profile", "gus"]);
        assert!(code == 1 && errors.contains(reported), "{call}: {errors}");
    }
}

#[test]
fn the_example_waits_for_its_sensor() {
    let examples = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples");
    let folder = TempDir::new().unwrap();
    let trace = folder.path().join("t.csv");
    let arguments = ["sim", "inputs.gts", "--inputs", "inputs.csv", "--trace", trace.to_str().unwrap()];
    let (out, errors, code) = beamtick(Path::new(examples), &arguments);
    assert_eq!((code, errors.as_str()), (0, ""), "{out}");
    let knife = column(folder.path(), "axis2_pos");
    assert_eq!(first(&knife, |pos| pos != 0.0), 100.25);
    assert_eq!(knife.last().unwrap().1, 1000.0);
}

/// Inputs and outputs above 32, by their numbers and by words: in calls, entries of a path and of
/// FollowEx, files and the VCD.
#[test]
fn products_have_more_than_a_word_of_inputs_and_outputs() {
    let job = "\
#pragma profile gsn-024
long in[4], out[2] = {0x80000000, 0x80};
GTN_AxisOn(1, 1); GTN_AxisOn(1, 2); GTN_AxisOn(2, 3); GTN_AxisOn(2, 4);
GTN_SimInput(2, MC_GPI, 33, 1); GTN_SimInput(1, MC_GPI, 100, 1);
GTN_GetDiEx(1, MC_GPI, &in[0], 4);
GTN_SetDoEx(2, MC_GPO, &out[0], 2);
Sleep(2);
GTN_SetDoBit(1, MC_GPO, 40, 0); GTN_SetDoBit(2, MC_GPO, 33, 1);
TCrdPrm crd = {2, {1, 2, 0, 0, 0, 0, 0, 0}, 100, 1, 0, 0, {0, 0, 0, 0, 0, 0, 0, 0}};
GTN_SetCrdPrm(1, 1, &crd);
GTN_BufDoBit(1, 1, MC_GPO, 39, 1, 0); GTN_LnXY(1, 1, 100, 0, 10, 1, 0, 0); GTN_BufDoBit(1, 1, MC_GPO, 39, 0, 0);
GTN_CrdStart(1, 1, 0); WaitStop(1, 0, 1);
TJogPrm jog; jog.acc = 1; jog.dec = 1; jog.smooth = 0;
GTN_PrfJog(2, 3); GTN_SetJogPrm(2, 3, &jog); GTN_SetVel(2, 3, 10); GTN_Update(2, 4);
GTN_PrfFollowEx(2, 4); GTN_SetFollowMasterEx(2, 4, 3);
GTN_FollowDiBitEx(2, 4, MC_GPI, 66, 1, 0, 0); GTN_FollowDoBitEx(2, 4, MC_GPO, 38, 1, 0);
GTN_FollowDataPercentEx(2, 4, 100, 50, 0, 0, 0); GTN_FollowStartEx(2, 8);
WaitStop(2, 8, 0);
GTN_GetDoEx(1, MC_GPO, &out[0], 2);
";
    let folder = folder(job, "t_ms,input,level\n100,gpi66,1\n");
    let arguments = ["sim", "job.gts", "--inputs", "in.csv", "--vcd", "t.vcd"];
    let (out, errors, code) = beamtick(folder.path(), &arguments);
    assert_eq!(code, 0, "{out}{errors}");
    assert!(out.contains("GTN_GetDiEx in[0] = 0 1 0 8"), "{out}");
    assert!(out.contains("GTN_GetDoEx out[0] = -2147483648 33"), "{out}");
    let vcd = fs::read_to_string(folder.path().join("t.vcd")).unwrap();
    let mut code = std::collections::HashMap::new();
    for line in vcd.lines().filter(|line| line.contains(" do")) {
        let words: Vec<&str> = line.split_whitespace().collect();
        code.insert(words[4].to_owned(), words[3].to_owned());
    }
    assert_eq!(code.len(), 40, "the outputs of the product that the job sets");
    let mut at = 0u64;
    let mut edges = Vec::new();
    for line in vcd.lines() {
        if let Some(time) = line.strip_prefix('#') {
            at = time.parse().unwrap();
        }
        for number in [32, 33, 38, 39, 40] {
            if at > 0
                && (line == format!("0{}", code[&format!("do{number}")])
                    || line == format!("1{}", code[&format!("do{number}")]))
            {
                edges.push((number, line.starts_with('1'), at as f64 / 1e6));
            }
        }
    }
    let of = |number: i32| -> Vec<(bool, f64)> {
        edges.iter().filter(|edge| edge.0 == number).map(|edge| (edge.1, edge.2)).collect()
    };
    assert_eq!(of(32), [(true, 0.25)]);
    assert_eq!(of(40), [(true, 0.25), (false, 2.25)]);
    assert_eq!(of(33), [(true, 2.25)]);
    assert_eq!(of(39), [(true, 2.25), (false, 22.25)], "100 pulses at 1 pulse/ms²");
    assert_eq!(of(38).len(), 1);
    assert!((100.0..101.0).contains(&of(38)[0].1), "{:?}", of(38));
}

/// One beyond the product's count is refused with it.
#[test]
fn a_number_beyond_the_products_count_names_it() {
    for (profile, call, reported) in [
        ("gtn-016", "GTN_SetDoBit(1, MC_GPO, 21, 1);", "index is 21; allowed are 1 to 20"),
        ("gtn-024", "GTN_SimInput(1, MC_GPI, 67, 1);", "index is 67; allowed are 1 to 66"),
        ("gtn-024", "GTN_SetDo(1, MC_GPO, 0x40000000);", "value is 1073741824; it must be from 0 to 1073741823"),
        ("gsn-048", "GTN_SetDoBit(1, MC_GPO, 41, 1);", "index is 41; allowed are 1 to 40"),
        (
            "gsn-048",
            "long v[2] = {0, 256}; GTN_SetDoEx(1, MC_GPO, &v[0], 2);",
            "value is 256; it must be from 0 to 255",
        ),
        (
            "gsn-024",
            "TCrdPrm p = {2, {1, 2, 0, 0, 0, 0, 0, 0}, 1, 1, 0, 0, {0, 0, 0, 0, 0, 0, 0, 0}}; GTN_AxisOn(1, 1); GTN_AxisOn(1, 2); GTN_SetCrdPrm(1, 3, &p);",
            "crd is 3; at this servo tick it must be from 1 to 2",
        ),
        ("r688s-016", "GTN_SimInput(1, MC_GPI, 65, 1);", "index is 65; allowed are 1 to 64"),
    ] {
        let folder = folder(&format!("#pragma profile {profile}\n{call}\n"), "");
        let (out, errors, code) = beamtick(folder.path(), &["sim", "job.gts"]);
        assert!(code == 1 && errors.contains(reported), "{call}: {out}{errors}");
    }
}

/// Reads of outputs show what is output, whoever set it: paths of either core, of coordinate
/// systems that only a longer tick has, and entries of FollowEx.
#[test]
fn outputs_are_read_whoever_set_them() {
    let crd = "{2, {1, 2, 0, 0, 0, 0, 0, 0}, 100, 1, 0, 0, {0, 0, 0, 0, 0, 0, 0, 0}}";
    let other = "{2, {0, 0, 1, 2, 0, 0, 0, 0}, 100, 1, 0, 0, {0, 0, 0, 0, 0, 0, 0, 0}}";
    let job = format!(
        "#pragma profile gsn-048
#pragma tick 500
short dac[2]; long out[2];
TCrdPrm first = {crd}, fourth = {other};
GTN_AxisOn(1, 1); GTN_AxisOn(1, 2); GTN_AxisOn(2, 3); GTN_AxisOn(2, 4);
GTN_SetCrdPrm(1, 1, &first); GTN_SetCrdPrm(2, 4, &fourth);
GTN_BufDA(1, 1, 5, 1000, 0); GTN_BufDoBit(1, 1, MC_GPO, 1, 1, 0); GTN_LnXY(1, 1, 100, 0, 10, 1, 0, 0);
GTN_BufDA(2, 4, 6, -2000, 0); GTN_BufDoBit(2, 4, MC_GPO, 40, 1, 0); GTN_LnXY(2, 4, 100, 0, 10, 1, 0, 0);
GTN_CrdStart(1, 1, 0); GTN_CrdStart(2, 8, 0);
WaitStop(1, 0, 1); WaitStop(2, 0, 8);
GTN_GetDac(1, 5, &dac[0], 2);
GTN_GetDoEx(2, MC_GPO, &out[0], 2);
"
    );
    let folder = folder(&job, "t_ms,input,level\n");
    let (out, errors, code) = beamtick(folder.path(), &["sim", "job.gts", "--trace", "t.csv"]);
    assert_eq!(code, 0, "{out}{errors}");
    assert!(out.contains("GTN_GetDac dac[0] = 1000 -2000"), "{out}");
    assert!(out.contains("GTN_GetDoEx out[0] = 1 128"), "{out}");
    let fourth = column(folder.path(), "core2_crd4_vel");
    assert!(fourth.iter().any(|(_, vel)| *vel == 10.0), "its speed is in the trace");
}
