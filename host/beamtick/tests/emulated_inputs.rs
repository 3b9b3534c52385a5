//! Inputs on the emulated board, where BEAMTICK_IMAGE names an image (`cargo xtask check-all`
//! does), and over `beamtick serve`.
mod served;
use assert_cmd::cargo::cargo_bin;
use client::inputs::{Inputs, Zero};
use client::{Client, Options};
use protocol::command::{GetAdc, GetDi, SimAdc, SimInput, SimPlan};
use served::Served;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Output, errors, exit code.
fn beamtick(folder: &Path, arguments: &[&str]) -> (String, String, i32) {
    let output = Command::new(cargo_bin("beamtick")).args(arguments).current_dir(folder).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (text(output.stdout), text(output.stderr), output.status.code().unwrap())
}

/// Every kind of input by a call or by a row; a slave that waits, a home switch that is captured, a
/// limit, the interlock.
const JOB: &str = "\
short status, cause; long value; double volts;
GT_AxisOn(1); GT_AxisOn(2); GT_AxisOn(3);
GT_SetAxisMode(7, 1); GT_LaserOutFrq(20); GT_LaserPrfCmd(50); GT_LaserOn(0); GT_SetInterlock(0);
GT_SetCaptureMode(1, CAPTURE_HOME);
TJogPrm jog; jog.acc = 1; jog.dec = 1; jog.smooth = 0;
GT_PrfJog(1); GT_SetJogPrm(1, &jog); GT_SetVel(1, 10);
GT_PrfJog(3); GT_SetJogPrm(3, &jog); GT_SetVel(3, 7); GT_Update(5);
GT_PrfFollowEx(2); GT_SetFollowMasterEx(2, 1);
GT_FollowDiBitEx(2, MC_GPI, 3, 1); GT_FollowDataPercentEx(2, 1000, 500);
GT_FollowDiBitEx(2, MC_ARRIVE, 5, 1); GT_FollowDataPercentEx(2, 2000, 700, FOLLOW_SEGMENT_STOP);
GT_FollowStartEx(1 << 1);
Sleep(20); GT_SimInput(MC_ARRIVE, 5, 1); GT_SimInput(MC_LIMIT_NEGATIVE, 3, 1); GT_SimAdc(4, -1.5);
GT_GetDi(MC_LIMIT_NEGATIVE, &value); GT_GetAdc(4, &volts);
WaitStop(2);
GT_GetCaptureStatus(1, &status, &value); GT_GetLaserFault(0, &cause);
GT_GetDi(MC_ALARM, &value); GT_GetDi(MC_GPI, &value); GT_GetAdc(1, &volts); GT_GetSts(3, &value);
";
const ROWS: &str = "\
t_ms,input,level
0,home1,0
10.1,interlock,1
15,home1,1
15,alarm8,1
30,interlock,0
33.3,limit_positive3,1
60,gpi3,1
60,adc1,3.125
";

#[test]
fn a_job_with_inputs_is_the_same_on_the_emulated_board() {
    if std::env::var_os("BEAMTICK_IMAGE").is_none() {
        println!("skipped: BEAMTICK_IMAGE names no image");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    fs::write(file("job.gts"), JOB).unwrap();
    fs::write(file("in.csv"), ROWS).unwrap();
    let with = |way: &[&str]| {
        let common = ["job.gts", "--inputs", "in.csv", "--tick-us", "250", "--trace", "t.csv"];
        let (out, errors, code) = beamtick(folder.path(), &[&way[..1], &common[..], &way[1..]].concat());
        // The interlock keeps the laser dark, and the job asks for light afterwards.
        assert!(code == 1 && errors.contains("light that the job asks for is missing"), "{way:?}: {out}{errors}");
        // A capture is shown with the controller's clock, which is another one here and there.
        let read = |line: &str| match line.contains("GetCaptureStatus") {
            true => line.rsplit_once('/').unwrap().0.to_owned(),
            false => line.to_owned(),
        };
        let reads: Vec<String> = out.lines().filter(|line| line.contains(" = ")).map(read).collect();
        (reads, fs::read_to_string(file("t.csv")).unwrap())
    };
    let (here, trace) = with(&["sim"]);
    assert_eq!(here.len(), 8, "{here:?}");
    assert!(here[2].ends_with("= 1/89"), "captured: {here:?}");
    assert!(here[3].ends_with("= 1"), "the interlock's fault: {here:?}");
    let (there, emulated) = with(&["run", "--link", "qemu"]);
    assert_eq!(here, there);
    assert!(trace == emulated, "the traces differ");
    // Served, it is the same again: rows go over the wire.
    let served = Served::start(&[]);
    let (there, over) = with(&["run", "--link", &served.1]);
    assert_eq!(here, there);
    assert!(trace == over, "the traces differ");
}

#[test]
fn the_emulated_board_names_a_wait_that_nothing_ends_and_a_plan_that_is_too_long() {
    if std::env::var_os("BEAMTICK_IMAGE").is_none() {
        println!("skipped: BEAMTICK_IMAGE names no image");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("job.gts"), JOB).unwrap();
    let (out, errors, code) = beamtick(folder.path(), &["run", "job.gts", "--link", "qemu"]);
    assert_eq!(code, 1, "{out}{errors}");
    let reported = "axis 2 waits until gpi3 is 1 (high), without a time limit";
    assert!(errors.contains(reported) && errors.contains("nothing will end that"), "{errors}");
    let rows = |count: usize| format!("t_ms,input,level\n{}", "1,gpi1,1\n".repeat(count));
    fs::write(folder.path().join("in.csv"), rows(257)).unwrap();
    fs::write(folder.path().join("job.gts"), "Sleep(5); long value; GT_GetDi(MC_GPI, &value);\n").unwrap();
    let arguments = ["run", "job.gts", "--inputs", "in.csv", "--link", "qemu"];
    let (_, errors, code) = beamtick(folder.path(), &arguments);
    assert_eq!((code, errors.trim_end()), (2, "in.csv:258: t_ms: this board holds 256 rows of inputs"));
    fs::write(folder.path().join("in.csv"), rows(256)).unwrap();
    let (out, errors, code) = beamtick(folder.path(), &arguments);
    assert!(code == 0 && out.contains("GT_GetDi value = 1"), "{out}{errors}");
}

fn client_of(served: &Served) -> Client {
    Client::open(client::link::open(&served.1).unwrap(), Options::default()).unwrap()
}

fn levels(client: &Client, di_type: i16) -> i32 {
    client.call(GetDi { core: 1.into(), di_type: di_type.into() }).unwrap().value.get()
}

#[test]
fn a_client_of_serve_sets_inputs_through_the_wire() {
    let served = Served::start(&[]);
    let client = client_of(&served);
    let core = 1.into();
    for di_type in 0..=5 {
        let set = |level: i16| SimInput { core, di_type: di_type.into(), index: 2.into(), level: level.into() };
        client.call(set(1)).unwrap();
        assert_eq!(levels(&client, di_type), 2, "type {di_type}");
        client.call(set(0)).unwrap();
        assert_eq!(levels(&client, di_type), 0, "type {di_type}");
    }
    client.call(SimAdc { core, adc: 8.into(), volts: 6.25.into() }).unwrap();
    let (_, volts) = client.call_items(GetAdc { core, adc: 8.into(), count: 1.into() }, &[]).unwrap();
    assert_eq!(volts[0].value.get(), 6.25);
    // A row from now on; a refused one changes nothing.
    let row = |di_type: i16, value: f64| SimPlan {
        core,
        row: 0.into(),
        from: 0,
        at_ns: 1_000_000.into(),
        di_type: di_type.into(),
        index: 3.into(),
        value: value.into(),
    };
    for (request, field) in [(row(4, 0.5), 6), (row(4, f64::NAN), 6), (row(6, 1.0), 4), (row(24, 13.0), 6)] {
        assert_eq!(client.call(request).unwrap_err().refusal.unwrap().field, field, "{request:?}");
    }
    client.call(row(4, 1.0)).unwrap();
    client.sleep(std::time::Duration::from_millis(200)).unwrap();
    assert_eq!(levels(&client, 4), 4);
}

#[test]
fn serve_sets_inputs_by_a_file_from_power_on() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("in.csv");
    fs::write(&file, "t_ms,input,level\n0,gpi3,1\n1,core2_home12,1\n3600000,gpi1,1\n").unwrap();
    let served = Served::start(&["--inputs", file.to_str().unwrap()]);
    let client = client_of(&served);
    client.sleep(std::time::Duration::from_millis(100)).unwrap();
    assert_eq!(levels(&client, 4), 4);
    let home = client.call(GetDi { core: 2.into(), di_type: 3.into() }).unwrap().value.get();
    assert_eq!(home, 1 << 11);
    drop(client);
    // Rows of the file outlast a session; those of a program do not.
    let client = client_of(&served);
    let waits = "t_ms,input,level\n0,gpi5,1\n";
    Inputs::read("f", waits.as_bytes()).unwrap().plan(&client, Zero::Program).unwrap();
    drop(client);
    let client = client_of(&served);
    let mut program = client.program();
    program.push(protocol::command::Sleep { ns: 50_000_000.into() });
    program.run(false, &mut client::Quiet).unwrap();
    assert_eq!(levels(&client, 4), 4);
    drop(client);
    fs::write(&file, "t_ms,input,level\n0,gpi101,1\n").unwrap();
    let arguments = ["serve", "--listen", "127.0.0.1:0", "--inputs", "in.csv"];
    let (_, errors, code) = beamtick(folder.path(), &arguments);
    assert_eq!((code, errors.trim_end()), (2, "in.csv:2: input: `101` is no number of gpi; it is from 1 to 100"));
}

/// An instruction of the emulated board takes no time of its own.
#[test]
fn info_says_that_the_emulated_board_measures_neither_its_ticks_nor_its_stack() {
    if std::env::var_os("BEAMTICK_IMAGE").is_none() {
        println!("skipped: BEAMTICK_IMAGE names no image");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (out, errors, code) = beamtick(folder.path(), &["info", "--link", "qemu"]);
    assert!(code == 0 && out.contains("how long ticks take is not measured on this board"), "{out}{errors}");
    assert!(out.contains("\nstack       how much of it is used is not measured on this board\n"), "{out}");
}
