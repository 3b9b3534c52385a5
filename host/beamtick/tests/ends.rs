//! Every end of a job is dark (SPEC 9): the script's end, a refused call, INT, TERM and HUP; in
//! virtual time and over TCP. And who may be at a served controller.
#![cfg(unix)]
mod served;

use assert_cmd::cargo::cargo_bin;
use served::Served;
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

const SIGNALS: [(&str, &str, i32); 3] = [("INT", "SIGINT", 130), ("TERM", "SIGTERM", 143), ("HUP", "SIGHUP", 129)];
/// SPEC 10 says a second; a busy machine is not to fail the test.
const AT_ONCE: Duration = Duration::from_secs(2);

const AXES: &str = "GT_Reset(); GT_LmtsOff(1); GT_LmtsOff(2); GT_AlarmOff(1); GT_AlarmOff(2); GT_AxisOn(1); GT_AxisOn(2);\n\
    TCrdPrm crd = {2, {1, 2, 0, 0, 0, 0, 0, 0}, 100, 5, 0, 0, {0, 0, 0, 0, 0, 0, 0, 0}};\n\
    GT_SetCrdPrm(1, &crd); GT_CrdClear(1, 0);\n";
const LASER: &str = "GT_SetAxisMode(7, 1); GT_LaserOutFrq(10, 0); GT_LaserPrfCmd(50, 0);\n";

impl Served {
    fn address(&self) -> &str {
        self.1.strip_prefix("tcp:").unwrap()
    }

    fn info(&self) -> String {
        let (out, errors, code) = beamtick(&["info", "--link", &self.1]);
        assert_eq!(code, 0, "{out}{errors}");
        out
    }

    /// The line of channel 0.
    fn laser(&self) -> String {
        self.info().lines().find(|line| line.starts_with("laser 0")).unwrap().to_owned()
    }
}

/// Output, errors, exit code.
fn beamtick(arguments: &[&str]) -> (String, String, i32) {
    let output = Command::new(cargo_bin("beamtick")).args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (text(output.stdout), text(output.stderr), output.status.code().unwrap_or(-1))
}

/// With HUP as a terminal has it, also where the tests run under `nohup`.
fn spawn(arguments: &[&str]) -> Child {
    Command::new("env")
        .arg("--default-signal=HUP")
        .arg(cargo_bin("beamtick"))
        .args(arguments)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Waits for the first line of output, which is what the job reads.
fn first_line(child: &mut Child) -> String {
    let mut line = String::new();
    let mut out = BufReader::new(child.stdout.as_mut().unwrap());
    out.read_line(&mut line).unwrap();
    line
}

/// Sends a signal and waits for the end: what the program said, its exit code.
fn signalled(mut child: Child, signal: &str) -> (String, i32) {
    let sent = Instant::now();
    let done = Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status().unwrap();
    assert!(done.success());
    let status = child.wait().unwrap();
    let took = sent.elapsed();
    let mut errors = String::new();
    child.stderr.take().unwrap().read_to_string(&mut errors).unwrap();
    assert!(took < AT_ONCE, "{signal}: it took {took:?}: {errors}");
    (errors, status.code().unwrap_or_else(|| -status.signal().unwrap()))
}

fn write(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name).to_str().unwrap().to_owned();
    fs::write(&path, text).unwrap();
    path
}

/// A measurement that a signal ends says what happened and what to do, wherever it is, and leaves
/// the page.
#[test]
fn a_bring_up_that_a_signal_ends_says_so() {
    const PAGE: &str = include_str!("../../../docs/bring-up-page.md");
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let link = format!("tcp:{}", listener.local_addr().unwrap());
    let folder = tempfile::tempdir().unwrap();
    let page = write(folder.path(), "page.md", PAGE);
    for more in [&[][..], &["--hands", "halt"], &["--loads"], &["--answers", "module"]] {
        let child = spawn(&[&["bring-up", "--link", &link, "--page", &page], more].concat());
        let (mut board, _) = listener.accept().unwrap();
        // It has begun by then.
        board.read_exact(&mut [0]).unwrap();
        let (said, code) = signalled(child, "INT");
        let first =
            "bring-up was cut short: the page is as it was. Press B2 at the board, then give the command again\n";
        assert!(said.starts_with(first) && code == 130, "{more:?}: {code}: {said}");
        assert_eq!(fs::read_to_string(&page).unwrap(), PAGE);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}

/// The gate of channel 0 in each row of a CSV.
fn gates(path: &str) -> Vec<(f64, bool)> {
    let text = fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let place = lines.next().unwrap().split(',').position(|name| name == "laser0_gate").unwrap();
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        (cells[0].parse().unwrap(), cells[place] == "1")
    };
    lines.map(row).collect()
}

/// A jump, then a mark that the braking path passes.
fn jump_and_mark(jump: u32, stop_dec: f64) -> String {
    format!(
        "{AXES}{LASER}GT_SetCrdStopDec(1, {stop_dec}, 1000);\n\
         GT_LnXY(1, {jump}, 0, 50, 5, 50); GT_BufLaserOn(1); GT_LnXY(1, {}, 0, 50, 5, 0); GT_BufLaserOff(1);\n\
         GT_CrdStart(1, 0);\n",
        jump * 4
    )
}

#[test]
fn a_refused_call_in_a_jump_before_a_mark_leaves_no_light() {
    let folder = tempfile::tempdir().unwrap();
    // The path brakes for 250 ms and 6250 pulses; the mark begins after 5000.
    let job = write(folder.path(), "job.gts", &format!("{}Sleep(50);\nGT_AxisOn(99);\n", jump_and_mark(5000, 0.2)));
    let csv = folder.path().join("t.csv").to_str().unwrap().to_owned();
    let (_, errors, code) = beamtick(&["sim", &job, "--trace", &csv]);
    assert_eq!(code, 1);
    assert!(errors.contains("axis is 99") && errors.contains("Light is off."), "{errors}");
    assert!(errors.contains("What still moved (axis 1, axis 2) was stopped smoothly."), "{errors}");
    // What was recorded keeps a name that says so.
    assert!(!Path::new(&csv).exists() && errors.contains("t.csv.partial"), "{errors}");
    let gates = gates(&format!("{csv}.partial"));
    assert!(gates.len() > 400 && gates.iter().all(|(_, on)| !on), "{} rows", gates.len());
    // The same over TCP: what the served controller did shows in its light.
    let served = Served::start(&[]);
    let (_, errors, code) = beamtick(&["run", &job, "--link", &served.1]);
    assert!(code == 1 && errors.contains("Light is off."), "{errors}");
    assert!(served.laser().contains("dark") && served.laser().contains("light of 0.000 ms"), "{}", served.laser());
}

/// The controller aborts by itself: before the host has heard of the refusal, the path would be in
/// the mark.
#[test]
fn a_call_refused_a_few_ticks_before_a_mark_leaves_no_light() {
    let folder = tempfile::tempdir().unwrap();
    let csv = folder.path().join("t.csv").to_str().unwrap().to_owned();
    // The mark begins 105 ms after the start.
    for (ms, lights) in [(100, false), (102, false), (103, false), (110, true)] {
        let job =
            write(folder.path(), "job.gts", &format!("{}Sleep({ms});\nGT_AxisOn(99);\n", jump_and_mark(5000, 0.2)));
        let (_, errors, code) = beamtick(&["sim", &job, "--trace", &csv]);
        assert_eq!(code, 1, "{errors}");
        let gates = gates(&format!("{csv}.partial"));
        assert_eq!(gates.iter().any(|(_, on)| *on), lights, "refused after {ms} ms");
        // In a mark it is dark two ticks after the refusal.
        let last = gates.iter().rposition(|(_, on)| *on).map_or(0.0, |row| gates[row].0);
        let first = gates.iter().find(|(_, on)| *on).map_or(0.0, |row| row.0);
        assert!(!lights || last - first < 6.0, "light from {first} to {last} ms, refused after {ms} ms");
        std::fs::remove_file(format!("{csv}.partial")).unwrap();
    }
}

#[test]
fn a_signal_in_a_jump_before_a_mark_leaves_no_light() {
    // It brakes for 5 s, over 125000 pulses; the mark begins after 100000.
    let text = format!("{}double p; Sleep(50); GT_GetPrfPos(1, &p); Sleep(60000);\n", jump_and_mark(100_000, 0.01));
    let ends = SIGNALS.map(|(signal, name, wanted)| {
        let text = text.clone();
        std::thread::spawn(move || {
            let folder = tempfile::tempdir().unwrap();
            let job = write(folder.path(), "job.gts", &text);
            let served = Served::start(&[]);
            let mut child = spawn(&["run", &job, "--link", &served.1]);
            assert!(first_line(&mut child).contains("GT_GetPrfPos"));
            let (errors, code) = signalled(child, signal);
            assert_eq!(code, wanted, "{errors}");
            assert!(errors.contains(&format!("interrupted by {name}")), "{errors}");
            assert!(errors.contains("Light is off. Still braking to a smooth stop: axis 1, axis 2."), "{errors}");
            std::thread::sleep(Duration::from_secs(6));
            let info = served.info();
            assert!(info.contains("light of 0.000 ms so far"), "{info}");
            assert!(info.contains("coordinate system 1 stopped: an abort"), "{info}");
        })
    });
    ends.into_iter().for_each(|end| end.join().unwrap());
}

#[test]
fn a_signal_in_light_shuts_it_off_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let text = format!("double p; {LASER}GT_SetHSIOOpt(1, 0); Sleep(100); GT_GetPrfPos(1, &p); Sleep(600000);\n");
    let job = write(folder.path(), "job.gts", &text);
    let served = Served::start(&[]);
    for (signal, name, wanted) in SIGNALS {
        let mut child = spawn(&["run", &job, "--link", &served.1]);
        assert!(first_line(&mut child).contains("GT_GetPrfPos"));
        let (errors, code) = signalled(child, signal);
        assert_eq!(code, wanted, "{errors}");
        assert!(errors.contains(&format!("interrupted by {name}\nLight is off. Nothing moves.")), "{errors}");
        // Not by a fault of a lost link: the next job's on command works.
        let laser = served.laser();
        assert!(laser.contains("dark") && !laser.contains("KEPT"), "{laser}");
    }
}

#[test]
fn a_light_that_the_path_reaches_after_an_immediate_off_ends_with_the_job() {
    let folder = tempfile::tempdir().unwrap();
    let text = format!(
        "{AXES}{LASER}GT_LnXY(1, 1000, 0, 50, 5, 50); GT_BufLaserOn(1); GT_LnXY(1, 100000, 0, 50, 5, 0); GT_BufLaserOff(1);\n\
         GT_CrdStart(1, 0); GT_SetHSIOOpt(0, 0); Sleep(200);\n"
    );
    let job = write(folder.path(), "job.gts", &text);
    let next = write(folder.path(), "next.gts", &format!("{LASER}Sleep(50);\n"));
    let csv = folder.path().join("t.csv").to_str().unwrap().to_owned();
    let (out, errors, code) = beamtick(&["sim", &job, "--trace", &csv]);
    assert_eq!(code, 0, "{errors}");
    assert!(out.contains("was on when the script ended: shut off"), "{out}");
    assert!(out.contains("axis 1") && out.contains("still moved when the script ended: stopped smoothly"), "{out}");
    let found = gates(&csv);
    // The Abort acts as a call at 200 ms would: on the first tick after it.
    let lit: Vec<f64> = found.iter().filter(|(_, on)| *on).map(|(t, _)| *t).collect();
    assert!((20.0..30.0).contains(&lit[0]) && lit.last() == Some(&200.0), "{:?} to {:?}", lit[0], lit.last());
    assert!(found.len() > 810 && !found.last().unwrap().1);

    let served = Served::start(&[]);
    let (_, errors, code) = beamtick(&["run", &job, "--link", &served.1]);
    assert_eq!(code, 0, "{errors}");
    assert!(served.laser().contains("dark"), "{}", served.laser());
    let csv = folder.path().join("next.csv").to_str().unwrap().to_owned();
    let (_, errors, code) = beamtick(&["run", &next, "--link", &served.1, "--trace", &csv]);
    assert_eq!(code, 0, "{errors}");
    assert!(gates(&csv).iter().all(|(_, on)| !on));
}

#[test]
fn a_job_that_ends_with_an_on_command_makes_no_light() {
    let folder = tempfile::tempdir().unwrap();
    let job = write(folder.path(), "job.gts", &format!("{LASER}Sleep(5); GT_SetHSIOOpt(1, 0);\n"));
    let csv = folder.path().join("t.csv").to_str().unwrap().to_owned();
    let (_, errors, code) = beamtick(&["sim", &job, "--trace", &csv]);
    assert_eq!(code, 0, "{errors}");
    assert!(gates(&csv).iter().all(|(_, on)| !on));
}

#[test]
fn the_link_loss_time_is_shown_and_lasts_for_the_session() {
    let folder = tempfile::tempdir().unwrap();
    let text = "double ms; short all; GT_SetLinkLoss(0, 1); GT_GetLinkLoss(&ms, &all); Sleep(600000);\n";
    let job = write(folder.path(), "job.gts", text);
    let (out, _, _) = beamtick(&["info"]);
    assert!(out.contains("link loss   after 500 ms of silence lasers are shut off"), "{out}");
    let served = Served::start(&[]);
    let mut child = spawn(&["run", &job, "--link", &served.1]);
    let line = first_line(&mut child);
    assert!(line.contains("GT_GetLinkLoss ms, all = time_ms 0 stop_all 1"), "{line}");
    // A client that is killed leaves no unwatched link to the next one.
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(served.info().contains("link loss   after 500 ms of silence"), "{}", served.info());
}

#[test]
fn connections_without_a_session_hold_nobody_up_and_are_closed() {
    let served = Served::start(&[]);
    let mut silent = TcpStream::connect(served.address()).unwrap();
    let mut noisy = TcpStream::connect(served.address()).unwrap();
    noisy.write_all(&[7; 5000]).unwrap();
    let began = Instant::now();
    served.info();
    silent.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    noisy.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    let mut bytes = [0; 16];
    assert_eq!(silent.read(&mut bytes).unwrap_or(0), 0);
    assert!(began.elapsed() < Duration::from_secs(10), "{:?}", began.elapsed());
    assert_eq!(noisy.read(&mut bytes).unwrap_or(0), 0);
    served.info();
}

#[test]
fn a_second_client_learns_who_is_there() {
    let folder = tempfile::tempdir().unwrap();
    let text = format!("double p; {LASER}GT_SetHSIOOpt(1, 0); Sleep(100); GT_GetPrfPos(1, &p); Sleep(600000);\n");
    let job = write(folder.path(), "job.gts", &text);
    let served = Served::start(&[]);
    let mut child = spawn(&["run", &job, "--link", &served.1]);
    assert!(first_line(&mut child).contains("GT_GetPrfPos"));
    for _ in 0..3 {
        let began = Instant::now();
        let (out, errors, code) = beamtick(&["info", "--link", &served.1]);
        assert!(code == 1 && out.is_empty() && began.elapsed() < AT_ONCE, "{out}{errors}");
        let reported = "error -6: ";
        assert!(errors.contains(reported) && errors.contains("open already, by a client at 127.0.0.1:"), "{errors}");
    }
    // It was not disturbed.
    assert!(child.try_wait().unwrap().is_none());
    let (errors, code) = signalled(child, "TERM");
    assert!(code == 143 && errors.contains("Light is off."), "{errors}");
    served.info();
}

#[test]
fn signals_end_every_command() {
    let folder = tempfile::tempdir().unwrap();
    // Virtual time at full speed: hours of it.
    let jog = "TJogPrm j = {1, 1, 0}; GT_LmtsOff(1); GT_AlarmOff(1); GT_AxisOn(1); GT_PrfJog(1); GT_SetJogPrm(1, &j);\n\
        GT_SetVel(1, 5); GT_Update(1); Sleep(100000000);\n";
    let job = write(folder.path(), "job.gts", jog);
    let mute = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let link = format!("tcp:{}", mute.local_addr().unwrap());
    for (signal, name, wanted) in SIGNALS {
        let start = |arguments: &[&str]| {
            let child = spawn(arguments);
            std::thread::sleep(Duration::from_millis(400));
            child
        };
        let (errors, code) = signalled(start(&["sim", &job]), signal);
        assert_eq!(code, wanted, "{errors}");
        assert!(errors.contains(&format!("interrupted by {name}")), "{errors}");
        assert!(errors.contains("Light is off. What still moved (axis 1) was stopped smoothly."), "{errors}");
        // A controller that does not answer: the link is being opened.
        for arguments in
            [&["run", &job, "--link", &link][..], &["info", "--link", &link], &["serve", "--listen", "127.0.0.1:0"]]
        {
            let (errors, code) = signalled(start(arguments), signal);
            assert_eq!(code, wanted, "{arguments:?}: {errors}");
        }
    }
}

#[test]
fn no_output_overwrites_an_input_or_another_output() {
    let folder = tempfile::tempdir().unwrap();
    let job = write(folder.path(), "job.gts", "GT_LoadConfig(\"off.toml\"); GT_PrfTrap(1); GT_AxisOn(1); Sleep(1);\n");
    let config = write(folder.path(), "off.toml", "[axis.1]\nalarm = false\n");
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (csv, again) = (file("t.csv"), folder.path().join(".").join("t.csv").to_str().unwrap().to_owned());
    std::os::unix::fs::symlink(&job, file("link.csv")).unwrap();
    let before = (fs::read(&job).unwrap(), fs::read(&config).unwrap());
    for arguments in [
        &["--trace", &job][..],
        &["--vcd", &config],
        &["--trace", &file("link.csv")],
        &["--trace", &csv, "--vcd", &again],
        &["--trace", &csv, "--vcd", &file("t.csv.partial")],
    ] {
        let (out, errors, code) = beamtick(&[&["sim", &job], arguments].concat());
        assert!(code == 2 && out.is_empty() && errors.contains("would overwrite a file"), "{arguments:?}: {errors}");
    }
    assert!(before == (fs::read(&job).unwrap(), fs::read(&config).unwrap()) && !Path::new(&csv).exists());
    // What is whole has its name only; a device is written as it is.
    let svg = file("t.svg");
    let (_, errors, code) = beamtick(&["sim", &job, "--trace", &csv, "--plot", &svg, "--vcd", "/dev/null"]);
    assert_eq!(code, 0, "{errors}");
    let mut names: Vec<String> =
        fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    assert_eq!(names, ["job.gts", "link.csv", "off.toml", "t.csv", "t.svg"]);
}

/// A file of an earlier run does not pass for that of a run that was cut off; one that is whole
/// leaves nothing of the earlier one.
#[test]
fn an_older_file_does_not_pass_for_the_new_one() {
    let folder = tempfile::tempdir().unwrap();
    let good = write(folder.path(), "good.gts", "GT_PrfTrap(1); GT_AxisOn(1); Sleep(1);\n");
    let bad = write(folder.path(), "bad.gts", "GT_PrfTrap(1); GT_AxisOn(1); Sleep(1);\nGT_AxisOn(99);\n");
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (csv, svg) = (file("t.csv"), file("t.svg"));
    let names = || {
        let entries = fs::read_dir(folder.path()).unwrap();
        let mut names: Vec<String> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names.retain(|name| name.starts_with('t'));
        names
    };
    let run = |job: &str| beamtick(&["sim", job, "--trace", &csv, "--plot", &svg]);
    assert_eq!(run(&good).2, 0);
    assert_eq!(names(), ["t.csv", "t.svg"]);
    let first = fs::read(&csv).unwrap();
    let (_, errors, code) = run(&bad);
    assert_eq!(code, 1, "{errors}");
    for reported in [format!("is in {csv}.partial."), format!("{csv} of an earlier run is {csv}.old now.")] {
        assert!(errors.contains(&reported), "{reported}: {errors}");
    }
    assert_eq!(names(), ["t.csv.old", "t.csv.partial", "t.svg.old", "t.svg.partial"]);
    assert_eq!(fs::read(file("t.csv.old")).unwrap(), first);
    // An output that cannot be begun leaves the others as they are.
    assert_eq!(run(&good).2, 0);
    let (_, _, code) = beamtick(&["sim", &good, "--trace", &csv, "--vcd", &file("none/t.vcd")]);
    assert_eq!((code, fs::read(&csv).unwrap() == first), (2, true));
    // What is set aside is no place for another output.
    let (_, errors, code) = beamtick(&["sim", &good, "--trace", &csv, "--vcd", &format!("{csv}.old")]);
    assert!(code == 2 && errors.contains("would overwrite a file"), "{errors}");
}

/// A standard output that takes nothing is an error; one whose reader has gone is none.
#[test]
fn a_standard_output_that_is_full_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let job = write(folder.path(), "job.gts", "GT_PrfTrap(1); GT_AxisOn(1); Sleep(1);\n");
    let with = |stdout: std::process::Stdio| {
        let mut child = std::process::Command::new(assert_cmd::cargo::cargo_bin("beamtick"))
            .args(["sim", &job])
            .stdout(stdout)
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        (output.status.code().unwrap(), String::from_utf8(output.stderr).unwrap())
    };
    let full = fs::File::options().write(true).open("/dev/full").unwrap();
    let (code, errors) = with(full.into());
    assert!(code == 1 && errors.contains("the standard output cannot be written: No space left"), "{code} {errors}");
    assert_eq!(with(std::process::Stdio::piped()), (0, String::new()));
}

/// More entries at one instant than the queue holds: some are late. A strict job says which one was
/// the first.
#[test]
fn a_strict_job_names_the_entry_that_was_late() {
    let folder = tempfile::tempdir().unwrap();
    let job = folder.path().join("late.gts");
    let bits: String = (0..3000).map(|n| format!("rtn=GT_SetDoBit(12,{},{});\n", n % 16 + 1, n % 2)).collect();
    fs::write(&job, format!("short rtn; rtn=GT_AxisOn(1);\nSleep(1);\n{bits}Sleep(1); WaitStop(1);\n")).unwrap();
    let job = job.to_str().unwrap();
    let (out, errors, code) = beamtick(&["sim", job]);
    assert_eq!(code, 0, "{errors}");
    let (_, first) = out.split_once("the first one is ").unwrap_or_else(|| panic!("{out}"));
    let (first, _) = first.split_once(':').unwrap();
    let (_, errors, code) = beamtick(&["sim", job, "--strict"]);
    assert_eq!(code, 1, "{errors}");
    assert!(errors.contains("an entry before it was late"), "{errors}");
    assert!(errors.contains(&format!("The first late entry is {first};")), "{first}: {errors}");
}

/// The light of `bring-up --hands clock` is ended by a byte, and the program sends it at a signal,
/// too: at the prompt under light, and right after the order.
#[test]
fn a_signal_under_the_light_of_bring_up_sends_the_byte_that_ends_it() {
    let line = |text: &str| format!("{text}*{:02X}\r\n", text.bytes().fold(0, |all, byte| all ^ byte));
    let lit: String = ["format 2", "lit 1 1 1", "end 2"].map(line).concat();
    for (signal, name, code) in SIGNALS {
        for answers in [true, false] {
            let board = TcpListener::bind("127.0.0.1:0").unwrap();
            let link = format!("tcp:{}", board.local_addr().unwrap());
            let mut child = Command::new("env")
                .arg("--default-signal=HUP")
                .arg(cargo_bin("beamtick"))
                .args(["bring-up", "--link", &link, "--hands", "clock"])
                .stdin(Stdio::piped())
                .stdout(Stdio::null())
                .stderr(Stdio::piped())
                .spawn()
                .unwrap();
            let mut hand = child.stdin.take().unwrap();
            hand.write_all(b"\n").unwrap();
            let (mut first, _) = board.accept().unwrap();
            let mut order = [0; 4];
            first.read_exact(&mut order).unwrap();
            assert_eq!(&order, b"lit\n");
            let ends = std::thread::spawn(move || {
                let (mut second, _) = board.accept().unwrap();
                let mut byte = [0];
                second.read_exact(&mut byte).unwrap();
                second.write_all(b"# a byte has ended the light\r\n").unwrap();
                // Until the program has gone.
                let _ = second.read_to_end(&mut Vec::new());
                byte
            });
            let mut said = String::new();
            if answers {
                first.write_all(lit.as_bytes()).unwrap();
                let mut errors = BufReader::new(child.stderr.as_mut().unwrap());
                while !said.contains("Hold the ST-LINK in reset") {
                    assert!(errors.read_line(&mut said).unwrap() > 0, "{said}");
                }
            }
            let (errors, ended) = signalled(child, signal);
            assert_eq!(ended, code, "{name}, {answers}: {said}{errors}");
            assert!(errors.contains("bring-up was cut short"), "{name}, {answers}: {errors}");
            assert!(errors.contains("The board says that the light has ended"), "{name}, {answers}: {errors}");
            assert_eq!(ends.join().unwrap(), *b"\n");
        }
    }
}

/// The voltages of `bring-up --hands dac` are 0 V after a signal at any of its prompts: a
/// controller that calls itself a board with an external DAC shows them.
#[test]
fn a_signal_at_a_voltage_of_bring_up_sets_both_outputs_to_0() {
    use virtual_board::{Config, serve};
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.md");
    for (signal, name, code) in SIGNALS {
        // Of output 1 the second and the third voltage, of output 2 the third.
        for (answers, expected) in [(1, [16_383, 0]), (2, [32_767, 0]), (5, [0, 32_767])] {
            let config = Config { name: "h743zi2-dac8563", ..Config::default() };
            let board = serve(TcpListener::bind("127.0.0.1:0").unwrap(), None, config).unwrap();
            let outputs = || {
                let analog = board.board().lock().unwrap().outputs().analog;
                [analog[0], analog[1]]
            };
            let mut child = Command::new("env")
                .arg("--default-signal=HUP")
                .arg(cargo_bin("beamtick"))
                .args(["bring-up", "--link", &format!("tcp:{}", board.address()), "--hands", "dac"])
                .args(["--page", page.to_str().unwrap()])
                .stdin(Stdio::piped())
                .stdout(Stdio::null())
                .stderr(Stdio::piped())
                .spawn()
                .unwrap();
            let mut hand = child.stdin.take().unwrap();
            let mut errors = BufReader::new(child.stderr.as_mut().unwrap());
            for prompt in 0..=answers {
                let mut said = String::new();
                while !said.contains("How many volts?") {
                    assert!(errors.read_line(&mut said).unwrap() > 0, "{said}");
                }
                if prompt < answers {
                    hand.write_all(b"0\n").unwrap();
                }
            }
            // A call is answered before the tick that outputs its voltage.
            let comes_to = |expected: [i16; 2]| {
                let since = Instant::now();
                while outputs() != expected && since.elapsed() < AT_ONCE {
                    std::thread::sleep(Duration::from_millis(1));
                }
                assert_eq!(outputs(), expected, "{name}, {answers}");
            };
            comes_to(expected);
            let (errors, ended) = signalled(child, signal);
            assert_eq!(ended, code, "{name}, {answers}: {errors}");
            assert!(errors.contains("bring-up was cut short"), "{name}, {answers}: {errors}");
            comes_to([0; 2]);
            assert!(!page.exists());
        }
    }
}
