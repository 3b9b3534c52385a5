//! `beamtick monitor` and `--share` as programs: text, JSON, refusals, and a job that nobody
//! disturbs.
mod served;

use assert_cmd::cargo::cargo_bin;
use client::{Client, Options};
use protocol::command::{
    AxisOn, GetClock, LaserOn, LaserOutFrq, LaserPowerMode, LaserPrfCmd, LaserStatus, SetAxisMode, SetPrfPos,
};
use serde_json::Value;
use served::Served;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
const WAIT_MAX: Duration = Duration::from_secs(60);

/// Output, errors, exit code.
fn beamtick(arguments: &[&str]) -> (String, String, i32) {
    let output = Command::new(cargo_bin("beamtick")).args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (text(output.stdout), text(output.stderr), output.status.code().unwrap())
}

fn machine() -> String {
    format!("{ROOT}/examples/machine.toml")
}

fn opened(link: &str, read_only: bool) -> client::Result<Client> {
    Client::open(client::link::open(link)?, Options { read_only, ..Options::default() })
}

#[test]
fn the_block_is_printed_once_beside_the_client_that_commands() {
    let served = Served::start(&[]);
    let commanding = opened(&served.1, false).unwrap();
    let (core, channel) = (1.into(), 0.into());
    commanding.call(AxisOn { core, axis: 1.into() }).unwrap();
    commanding.call(SetPrfPos { core, profile: 1.into(), pos: 1000.into() }).unwrap();
    commanding.call(SetAxisMode { core, axis: 7.into(), mode: 1.into() }).unwrap();
    let mode =
        LaserPowerMode { core, mode: 0.into(), max: 100.0.into(), min: 0.0.into(), channel, ..Default::default() };
    commanding.call(mode).unwrap();
    commanding.call(LaserOutFrq { core, frequency: 10.0.into(), channel }).unwrap();
    commanding.call(LaserPrfCmd { core, power: 50.0.into(), channel }).unwrap();
    commanding.call(LaserOn { core, channel }).unwrap();
    let (out, errors, code) = beamtick(&["monitor", "--once", "--link", &served.1]);
    assert_eq!((code, errors.as_str()), (0, ""), "{out}");
    let lines: Vec<&str> = out.lines().collect();
    assert!(lines[0].starts_with(&format!("virtual at {}, read-only; on for 0:00:", served.1)), "{out}");
    assert!(lines.contains(&"axis 1         1000.0 pulses       0.00 pulse/ms  stands"), "{out}");
    assert!(lines.contains(&"laser 0  LIGHT 50.00 %, 10.00 kHz") && lines.contains(&"laser 1  dark"), "{out}");
    assert!(lines.iter().all(|line| line.chars().count() <= 80), "{out}");

    let (out, errors, code) = beamtick(&["monitor", "--json", "--link", &served.1, "--machine", &machine()]);
    assert_eq!((code, errors.as_str(), out.lines().count()), (0, "", 1), "{out}");
    let found: Value = serde_json::from_str(&out).unwrap();
    assert_eq!((&found["command"], &found["exit_code"]), (&Value::from("monitor"), &Value::from(0)));
    let state = &found["result"];
    assert_eq!(state["lasers"][0]["light"], true);
    assert_eq!(state["axes"][0]["name"], "X");
    assert_eq!(state["axes"][0]["position_pulse"], 1000.0);
    assert!(state["axes"][0]["position_mm"].as_f64().unwrap() > 0.0, "{state}");
    // Nothing was taken or changed.
    commanding.call(GetClock {}).unwrap();
}

#[test]
fn what_it_cannot_do_it_says() {
    let path = |name: &str| format!("{ROOT}/examples/{name}");
    let cases: [(&[&str], i32, &str); 8] = [
        (&["monitor"], 2, "this is no terminal; --once prints the block"),
        (&["monitor", "--once", "--link", "tcp:127.0.0.1:1"], 1, "127.0.0.1:1"),
        (&["monitor", "--once", "--link", "virtual"], 2, "there is nothing to look at"),
        (&["monitor", "--command"], 2, "--machine <FILE.toml>"),
        (&["monitor", &path("square.nc")], 2, "--command"),
        (&["monitor", "--once", "--machine", "no/such.toml"], 2, "no/such.toml: the machine file cannot be read"),
        (&["monitor", "--once", "--command", "--machine", &machine()], 2, "cannot be used with"),
        (&["run", &path("jog_trap.gts"), "--link", "virtual", "--share", "127.0.0.1"], 2, "--share 127.0.0.1: cannot"),
    ];
    for (arguments, code, text) in cases {
        let (out, errors, found) = beamtick(arguments);
        assert!(found == code && errors.contains(text), "{arguments:?}: {found}\n{out}{errors}");
    }
    let (out, _, code) = beamtick(&["monitor", "--help"]);
    assert_eq!(code, 0);
    for text in ["Usage: beamtick monitor", "--once", "--json", "space         hold", "arrows        jog X and Y"] {
        assert!(out.contains(text), "{text}: {out}");
    }
    assert!(out.lines().all(|line| line.chars().count() <= 80), "{out}");
}

/// Runs a job that shares its link, squares of 40 mm at 40 mm/s, 4 s each; what viewers do
/// meanwhile. `ends` says that a signal ends it then, however slow this machine is.
fn shared(folder: &Path, rounds: usize, ends: bool, with: impl FnOnce(&str)) -> (String, String, i32) {
    let nc = folder.join("square.nc");
    let round = "G1 X50 F2400\nG1 Y50\nG1 X10\nG1 Y10\n".repeat(rounds);
    fs::write(&nc, format!("G21 G90\nG0 X10 Y10\nM3 S500\n{round}M5\nM2\n")).unwrap();
    let served = Served::start(&[]);
    let mut child = Command::new(cargo_bin("beamtick"))
        .args(["run", nc.to_str().unwrap(), "--machine", &machine(), "--link", &served.1, "--share", "127.0.0.1:0"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut errors = BufReader::new(child.stderr.take().unwrap());
    let (mut said, mut address) = (String::new(), None);
    while address.is_none() {
        let mut line = String::new();
        assert!(errors.read_line(&mut line).unwrap() > 0, "{said}");
        said.push_str(&line);
        address = line.strip_prefix("others may look at ").and_then(|rest| rest.split(": ").next()).map(str::to_owned);
    }
    with(&address.unwrap());
    if ends {
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    }
    let output = child.wait_with_output().unwrap();
    let mut rest = String::new();
    std::io::Read::read_to_string(&mut errors, &mut rest).unwrap();
    (String::from_utf8(output.stdout).unwrap(), said + &rest, output.status.code().unwrap())
}

#[test]
fn others_look_over_the_link_of_a_job_and_disturb_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let (out, errors, code) = shared(folder.path(), 150, true, |link| {
        // The link of the port for viewers commands nothing.
        let refused = opened(link, false).err().expect("it gives no session that commands");
        assert!(refused.reason.contains("a port that is only for viewers"), "{refused}");
        let viewer = opened(link, true).unwrap();
        let began = Instant::now();
        let mut lit = false;
        // The job, its light and its time left, while it runs.
        let state = loop {
            let (out, errors, code) = beamtick(&["monitor", "--json", "--link", link, "--machine", &machine()]);
            assert_eq!(code, 0, "{out}{errors}");
            let found: Value = serde_json::from_str(&out).unwrap();
            let state = found["result"].clone();
            lit |= state["lasers"][0]["light"] == true;
            if lit && !state["job"].is_null() {
                break state;
            }
            assert!(began.elapsed() < WAIT_MAX, "{state}");
        };
        let job = &state["job"];
        assert!(job["name"].as_str().unwrap().ends_with("square.nc"), "{job}");
        assert!(job["left_s"].as_f64().unwrap() > 0.0 && job["entries"].as_u64().unwrap() > 5, "{job}");
        assert_eq!(state["program"]["state"], "running");
        assert!(state["paths"][0]["dry_ms"].as_u64().unwrap() > 0, "{state}");
        // A client that looks holds on until the job is over.
        viewer.call(GetClock {}).unwrap();
        let refused = viewer.call(LaserOn { core: 1.into(), channel: 0.into() }).unwrap_err();
        assert!(refused.reason.contains("only reads"), "{refused}");
    });
    // It ran until the signal came, which says that it is dark and at rest.
    assert_eq!(code, 130, "{out}{errors}");
    assert!(!errors.contains("error "), "{out}{errors}");
}

/// The terminal of a monitor that commands: keys act though nobody takes what it shows. Where it
/// goes away without a signal, all is dark by an Abort, not by the loss of the link.
#[cfg(unix)]
#[test]
fn a_terminal_that_is_stuck_or_goes_away_leaves_no_light() {
    use serialport::SerialPort;
    use std::io::Write;
    use std::os::fd::AsRawFd;
    let folder = tempfile::tempdir().unwrap();
    let nc = folder.path().join("long.nc");
    fs::write(&nc, format!("G21 G90\nM3 S500 F600\n{}M5\nM2\n", "G1 X100\nG1 X10\n".repeat(50))).unwrap();
    let served = Served::start(&[]);
    let (mut master, slave) = serialport::TTYPort::pair().unwrap();
    let terminal = slave.name().unwrap();
    let end = || Stdio::from(fs::File::options().read(true).write(true).open(&terminal).unwrap());
    // The other end is this process's alone, or it would never go away.
    let own = master.as_raw_fd().to_string();
    let mut child = Command::new("bash")
        .args(["-c", "eval \"exec $1>&-\"; shift; exec \"$@\"", "bash", &own])
        .arg(cargo_bin("beamtick"))
        .args(["monitor", nc.to_str().unwrap(), "--command", "--machine", &machine(), "--link", &served.1])
        .stdin(end())
        .stdout(end())
        .stderr(end())
        .spawn()
        .unwrap();
    drop(slave);
    let viewer = opened(&served.1, true).unwrap();
    let until = |light: bool, each: &mut dyn FnMut()| {
        let began = Instant::now();
        loop {
            let state = viewer.call(LaserStatus { core: 1.into(), channel: 0.into() }).unwrap();
            if (state.light != 0) == light {
                return state.fault.get();
            }
            assert!(began.elapsed() < WAIT_MAX, "light is {}", state.light);
            each();
            std::thread::sleep(Duration::from_millis(5));
        }
    };
    for _ in 0..2 {
        // One press may come before the monitor listens.
        until(true, &mut || master.write_all(b"s").unwrap());
        // Longer than a terminal that nobody reads takes pictures.
        std::thread::sleep(Duration::from_millis(600));
        master.write_all(b"x").unwrap();
        assert_eq!(until(false, &mut || ()), 0, "the stop key");
        // Presses that were left begin no program after it.
        std::thread::sleep(Duration::from_millis(100));
    }
    until(true, &mut || master.write_all(b"s").unwrap());
    drop(master);
    assert_eq!(until(false, &mut || ()), 0, "the terminal has gone");
    assert_eq!(child.wait().unwrap().code(), Some(1));
}

#[test]
fn a_job_that_nobody_looks_at_any_more_ends_as_ever() {
    let folder = tempfile::tempdir().unwrap();
    let (out, errors, code) = shared(folder.path(), 1, false, |link| {
        // Two that leave without a word in the middle of what they ask.
        for _ in 0..2 {
            use std::io::Write;
            let mut stream = std::net::TcpStream::connect(link.trim_start_matches("tcp:")).unwrap();
            stream.write_all(&[3, 1, 1, 6, 8, 9]).unwrap();
        }
        let viewer = opened(link, true).unwrap();
        viewer.call(GetClock {}).unwrap();
    });
    assert_eq!(code, 0, "{out}{errors}");
}
