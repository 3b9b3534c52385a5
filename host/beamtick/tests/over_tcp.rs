//! The program against `beamtick serve`, and against controllers that are not ours.
mod served;

use assert_cmd::cargo::cargo_bin;
use protocol::link::{Endpoint, Identity, Role};
use served::Served;
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpListener;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Two axes, 250 ms: one on a trapezoid, one with a jump of the velocity.
const JOB: &str = "\
short axis;
GT_Reset(); GT_LoadConfig(\"off.toml\");
GT_AxisOn(1); GT_AxisOn(2); GT_PrfPt(1); GT_PrfPt(2);
GT_PtData(1, 50, 100); GT_PtData(1, 150, 150); GT_PtData(1, 200, 250);
GT_PtData(2, -33.3, 77, PT_SEGMENT_EVEN); GT_PtData(2, 0, 200, PT_SEGMENT_STOP);
GT_PtStart(3);
WaitStop(3);
Sleep(10);
";

/// The like of it in 20 ms: at 50 us a row its trace fits into what the controller holds while this
/// machine runs others.
const SHORT: &str = "\
short axis;
GT_Reset(); GT_LoadConfig(\"off.toml\");
GT_AxisOn(1); GT_AxisOn(2); GT_PrfPt(1); GT_PrfPt(2);
GT_PtData(1, 4, 8); GT_PtData(1, 12, 12); GT_PtData(1, 16, 20);
GT_PtData(2, -2.7, 6, PT_SEGMENT_EVEN); GT_PtData(2, 0, 16, PT_SEGMENT_STOP);
GT_PtStart(3);
WaitStop(3);
Sleep(1);
";

/// Output, errors, exit code.
fn beamtick(arguments: &[&str]) -> (String, String, i32) {
    let output = Command::new(cargo_bin("beamtick")).args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (text(output.stdout), text(output.stderr), output.status.code().unwrap())
}

/// Traces of a job in virtual time and over TCP in real time, and what the latter said.
fn traces(folder: &Path, text: &str, sim: &[&str], run: &[&str]) -> (String, String, String, String) {
    let file = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let (job, here, there) = (file("job.gts"), file("sim.csv"), file("run.csv"));
    fs::write(&job, text).unwrap();
    fs::write(file("off.toml"), "[axis.1-2]\nlimits = \"none\"\nalarm = false\n").unwrap();
    let (out, errors, code) = beamtick(&[&["sim", &job, "--trace", &here], sim].concat());
    assert_eq!(code, 0, "{out}{errors}");
    let served = Served::start(&[]);
    let (out, errors, code) = beamtick(&[&["run", &job, "--link", &served.1, "--trace", &there], run].concat());
    assert_eq!(code, 0, "{out}{errors}");
    (fs::read_to_string(&here).unwrap(), fs::read_to_string(&there).unwrap(), out, errors)
}

#[test]
fn a_trace_over_tcp_is_that_of_virtual_time() {
    let folder = tempfile::tempdir().unwrap();
    let (sim, run, out, errors) = traces(folder.path(), JOB, &[], &[]);
    assert!(sim == run, "{} and {} lines differ", sim.lines().count(), run.lines().count());
    // 260 ms and a tick at 250 us, row 0 and the header.
    assert!((1042..=1044).contains(&sim.lines().count()), "{}", sim.lines().count());
    assert!(out.contains("profile gus") && out.contains("one every 1 tick\n") && errors.is_empty(), "{out}{errors}");
}

#[test]
fn rows_that_the_link_does_not_carry_are_fewer_and_said_so() {
    let folder = tempfile::tempdir().unwrap();
    // 2 axes at 10 us make 4.5 MB/s.
    let (sim, run, out, errors) =
        traces(folder.path(), SHORT, &["--tick-us", "10", "--every", "5"], &["--tick-us", "10"]);
    assert!(sim == run, "{} and {} lines differ", sim.lines().count(), run.lines().count());
    assert!((400..500).contains(&sim.lines().count()), "{}", sim.lines().count());
    assert!(errors.contains("a row every 5 ticks"), "{errors}");
    assert!(out.contains("one every 5 ticks, raised to what the link carries"), "{out}");
}

/// A controller whose identity is not ours.
fn stranger(identity: Identity) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let link = format!("tcp:{}", listener.local_addr().unwrap());
    std::thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        stream.set_read_timeout(Some(Duration::from_millis(5))).unwrap();
        let mut end = Endpoint::<8>::new(Role::Controller, identity);
        let (begun, mut bytes) = (Instant::now(), [0; 2048]);
        while begun.elapsed() < Duration::from_secs(10) {
            let now = begun.elapsed().as_nanos() as u64;
            match stream.read(&mut bytes) {
                Ok(0) => return,
                Ok(count) => end.feed(now, &bytes[..count]),
                Err(_) => {}
            }
            let count = end.take_tx(now, &mut bytes);
            if stream.write_all(&bytes[..count]).is_err() {
                return;
            }
        }
    });
    link
}

#[test]
fn an_image_of_another_version_is_named() {
    for identity in [Identity { schema: 0x1234_5678, ..Identity::OURS }, Identity { version: 9, ..Identity::OURS }] {
        let link = stranger(identity);
        let (out, errors, code) = beamtick(&["info", "--link", &link]);
        assert_eq!(code, 1, "{out}{errors}");
        let theirs = format!("the firmware version {} (schema {:08x})", identity.version, identity.schema);
        assert!(errors.contains("error 3") && errors.contains("do not match") && errors.contains(&theirs), "{errors}");
    }
}

#[test]
fn serving_needs_an_address_that_is_free() {
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    let (_, errors, code) = beamtick(&["serve", "--listen", &address]);
    assert!(code == 1 && errors.contains(&address) && errors.contains("cannot listen"), "{errors}");
}

/// A client that is killed while its job has a laser on: the controller goes dark by itself, says
/// why, and stays dark until a command changes that.
#[test]
fn a_killed_client_leaves_no_light() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name).to_str().unwrap().to_owned();
        fs::write(&path, text).unwrap();
        path
    };
    let on = "GT_LaserOutFrq(10,0); GT_LaserPrfCmd(50,0); GT_SetHSIOOpt(1,0);";
    let job = file("on.gts", &format!("double pos; {on} Sleep(2000); GT_GetPrfPos(1, &pos, 1, 0); Sleep(60000);"));
    let again = file("again.gts", &format!("{on} Sleep(1);"));
    let cleared = file("cleared.gts", &format!("GT_ClrLaserFault(0); {on} Sleep(1);"));
    let served = Served::start(&[]);
    let info = || {
        let (out, errors, code) = beamtick(&["info", "--link", &served.1]);
        assert_eq!(code, 0, "{out}{errors}");
        out.lines()
            .filter(|line| line.starts_with("laser 0") || line.starts_with("profile"))
            .collect::<Vec<_>>()
            .join(" ")
    };
    let mut run = Command::new(cargo_bin("beamtick"))
        .args(["run", &job, "--link", &served.1, "--family", "lsr"])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    // Longer than the link-loss time: the client keeps the link alive, or the laser would be dark
    // already.
    let (mut read, mut stdout) = (String::new(), BufReader::new(run.stdout.take().unwrap()));
    stdout.read_line(&mut read).unwrap();
    assert!(read.contains("GT_GetPrfPos"), "{read}");
    run.kill().unwrap();
    run.wait().unwrap();
    // Who asks is heard, and the silence begins anew: on a busy machine a second may be less than
    // the link-loss time.
    let ask = || {
        std::thread::sleep(Duration::from_millis(1000));
        info()
    };
    let reported = (0..10).map(|_| ask()).find(|reported| reported.contains("KEPT DARK")).unwrap_or_else(info);
    assert!(reported.contains("family lsr") && reported.contains("dark"), "{reported}");
    assert!(reported.contains("KEPT DARK: the host link was lost (ClrLaserFault)"), "{reported}");
    let light: f64 =
        reported.split("light of ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap().parse().unwrap();
    assert!((2000.0..4500.0).contains(&light), "{light} ms of light: {reported}");
    let (_, errors, code) = beamtick(&["run", &again, "--link", &served.1, "--family", "lsr"]);
    assert!(code != 0 && errors.contains("the host link was lost; once that is over call ClrLaserFault"), "{errors}");
    let (out, errors, code) = beamtick(&["run", &cleared, "--link", &served.1, "--family", "lsr"]);
    assert_eq!(code, 0, "{out}{errors}");
    assert!(info().contains("dark") && !info().contains("KEPT"), "{}", info());
}
