//! A reader of what a job says may pause for as long as it likes: the job goes on, and a signal
//! ends it as ever (SPEC 9, 10).
#![cfg(unix)]
mod served;

use assert_cmd::cargo::cargo_bin;
use served::Served;
use std::fs;
use std::io::Read;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// More lines than a pipe of 64 KiB takes.
const READ_LINES: usize = 2500;

impl Served {
    /// A job of light that lasts for so many ms, and reads or complains in each.
    fn run(&self, folder: &std::path::Path, call: &str, light: usize) -> Child {
        let mut text = "#pragma continue\nunsigned short on; short rtn;\nGT_Reset(); GT_SetAxisMode(7, 1); GT_LaserOutFrq(10, 0);\n\
            GT_LaserPrfCmd(50, 0); GT_LaserOn(0);\n"
            .to_owned();
        text.push_str(&format!("Sleep(1); {call}\n").repeat(light));
        text.push_str("GT_LaserOff(0); Sleep(10);\n");
        let job = folder.join("job.gts");
        fs::write(&job, text).unwrap();
        // With HUP as a terminal has it, also where the tests run under `nohup`.
        Command::new("env")
            .arg("--default-signal=HUP")
            .arg(cargo_bin("beamtick"))
            .args(["run".as_ref(), job.as_os_str(), "--link".as_ref(), self.1.as_ref()])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap()
    }

    fn laser(&self) -> String {
        let output = Command::new(cargo_bin("beamtick")).args(["info", "--link", &self.1]).output().unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        text.lines().find(|line| line.starts_with("laser 0")).unwrap_or_default().to_owned()
    }
}

/// The number before " ms so far".
fn light_ms(text: &str) -> f64 {
    let (before, _) = text.split_once(" ms so far").unwrap_or_else(|| panic!("no light in: {text}"));
    before.rsplit(' ').next().unwrap().parse().unwrap()
}

#[test]
fn a_reader_that_pauses_does_not_hold_the_job_up() {
    let (served, folder) = (Served::start(&[]), tempfile::tempdir().unwrap());
    let mut child = served.run(folder.path(), "rtn = GT_GetHSIOOpt(&on, 0);", READ_LINES);
    // Nobody reads for twice as long as the light shall last.
    std::thread::sleep(Duration::from_millis(2 * READ_LINES as u64 + 2000));
    let mut text = String::new();
    child.stdout.take().unwrap().read_to_string(&mut text).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(0));
    assert_eq!(text.lines().filter(|line| line.contains("GT_GetHSIOOpt")).count(), READ_LINES, "no line is lost");
    let light = light_ms(&text);
    assert!(light < READ_LINES as f64 + 1500.0, "{light} ms of light where {READ_LINES} were asked for");
}

/// A signal in light, with both streams full of what nobody reads.
fn signalled(call: &str) {
    let (served, folder) = (Served::start(&[]), tempfile::tempdir().unwrap());
    for (signal, code) in [("INT", 130), ("TERM", 143), ("HUP", 129)] {
        let mut child = served.run(folder.path(), call, 20_000);
        std::thread::sleep(Duration::from_millis(3000));
        let began = Instant::now();
        Command::new("kill").args([format!("-{signal}"), child.id().to_string()]).status().unwrap();
        let ended = child.wait().unwrap().code();
        assert_eq!(ended, Some(code), "{signal}");
        assert!(began.elapsed() < Duration::from_secs(3), "{signal}: {:?}", began.elapsed());
        // Dark by the Abort: a link that is lost would leave a fault.
        let laser = served.laser();
        assert!(laser.contains("dark") && !laser.contains("link"), "{signal}: {laser}");
    }
}

#[test]
fn a_signal_is_heard_while_nobody_reads_the_output() {
    signalled("rtn = GT_GetHSIOOpt(&on, 0);");
}

#[test]
fn a_signal_is_heard_while_nobody_reads_the_errors() {
    signalled("rtn = GT_PrfTrap(99);");
}
