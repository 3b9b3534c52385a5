//! INT, TERM and HUP at many instants of a job of light on the emulated board, where BEAMTICK_IMAGE
//! names an image (`cargo xtask check-all` does). The board's own trace shows what its outputs did.
//! `BEAMTICK_SIGNALS=100` takes as many instants; without it there are nine, or more until both
//! a mark and a jump were met.
#![cfg(unix)]
use assert_cmd::cargo::cargo_bin;
use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::process::{Command, Stdio};
use std::time::Duration;

const SIGNALS: [(&str, &str, i32); 3] = [("INT", "SIGINT", 130), ("TERM", "SIGTERM", 143), ("HUP", "SIGHUP", 129)];
/// Marks and jumps of 2 ms each, for longer than any instant is away.
const PATH_MARKS: u32 = 400;
/// The path is at its speed by then: it takes 10 ms, and a busy machine is slow.
const UP_TO_SPEED: Duration = Duration::from_millis(80);

#[test]
fn signals_at_many_instants_end_dark() {
    if std::env::var_os("BEAMTICK_IMAGE").is_none() {
        println!("skipped: BEAMTICK_IMAGE names no image");
        return;
    }
    let count: u64 = std::env::var("BEAMTICK_SIGNALS").ok().and_then(|text| text.parse().ok()).unwrap_or(9);
    let mut text = "double p; GT_Reset(); GT_LmtsOff(1); GT_LmtsOff(2); GT_AlarmOff(1); GT_AlarmOff(2); GT_AxisOn(1); GT_AxisOn(2);\n\
        TCrdPrm crd = {2, {1, 2, 0, 0, 0, 0, 0, 0}, 100, 5, 0, 0, {0, 0, 0, 0, 0, 0, 0, 0}};\n\
        GT_SetCrdPrm(1, &crd); GT_SetCrdStopDec(1, 5, 100); GT_CrdClear(1, 0);\n\
        GT_SetAxisMode(7, 1); GT_LaserOutFrq(10, 0); GT_LaserPrfCmd(50, 0);\n"
        .to_owned();
    for part in 0..PATH_MARKS {
        let what = if part % 2 == 0 { "On" } else { "Off" };
        text.push_str(&format!("GT_BufLaser{what}(1); GT_LnXY(1, {}, 0, 50, 5, 50);\n", (part + 1) * 100));
    }
    text.push_str("GT_CrdStart(1, 0); Sleep(5); GT_GetPrfPos(1, &p); Sleep(600000);\n");
    let folder = tempfile::tempdir().unwrap();
    let job = folder.path().join("job.gts");
    fs::write(&job, text).unwrap();
    let csv = folder.path().join("t.csv");
    let (mut lit, mut dark, mut behind) = (0, 0, 0);
    // Until some came in a mark and some in a jump: when a signal arrives is up to the machine.
    for instant in 0..8 * count {
        if instant >= count && lit > 0 && dark > 0 {
            break;
        }
        let (signal, name, wanted) = SIGNALS[instant as usize % 3];
        // With HUP as a terminal has it, also where the tests run under `nohup`.
        let mut child = Command::new("env")
            .arg("--default-signal=HUP")
            .arg(cargo_bin("beamtick"))
            .arg("run")
            .args([job.as_os_str(), "--link".as_ref(), "qemu".as_ref(), "--trace".as_ref(), csv.as_os_str()])
            .args(["--every", "1"])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.as_mut().unwrap()).read_line(&mut line).unwrap();
        assert!(line.contains("GT_GetPrfPos"), "{line}");
        // Once the path is at its speed, as a signal acts within some ms; in steps that are no
        // multiple of a mark's time.
        std::thread::sleep(UP_TO_SPEED + Duration::from_micros(instant * 1370 % 150_000));
        assert!(
            Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status().unwrap().success()
        );
        let code = child.wait().unwrap().code();
        let mut errors = String::new();
        child.stderr.take().unwrap().read_to_string(&mut errors).unwrap();
        assert_eq!(code, Some(wanted), "instant {instant}: {errors}");
        assert!(errors.contains(&format!("interrupted by {name}\nLight is off.")), "instant {instant}: {errors}");

        let text = fs::read_to_string(csv.with_extension("csv.partial")).unwrap();
        let mut lines = text.lines();
        let names: Vec<&str> = lines.next().unwrap().split(',').collect();
        let place = |name: &str| names.iter().position(|found| *found == name).unwrap();
        let (gate, speed) = (place("laser0_gate"), place("crd1_vel"));
        let rows: Vec<(bool, f64)> = lines
            .map(|line| line.split(',').collect::<Vec<_>>())
            .map(|cells| (cells[gate] == "1", cells[speed].parse().unwrap()))
            .collect();
        // The Abort arrived in the tick after which the path is slower than it was set to be.
        let brakes = rows
            .iter()
            .position(|(_, speed)| *speed >= 50.0)
            .and_then(|top| Some(top + rows[top..].iter().position(|(_, speed)| *speed < 50.0)?));
        let Some(brakes) = brakes else {
            // A busy machine reads the trace too slowly to have it whole within a second.
            behind += 1;
            continue;
        };
        let late: Vec<usize> = (brakes + 1..rows.len()).filter(|row| rows[*row].0).collect();
        assert!(
            late.is_empty(),
            "instant {instant}: light in rows {late:?} of {}, it brakes from {brakes}",
            rows.len()
        );
        assert!(rows[..brakes].iter().any(|(gate, _)| *gate), "instant {instant}: no mark was lit");
        *if rows[brakes - 2].0 { &mut lit } else { &mut dark } += 1;
        let rest = rows.last().unwrap().1 == 0.0;
        assert!(rest || errors.contains("Still braking"), "instant {instant}: {errors}");
    }
    let count = lit + dark + behind;
    println!("{count} signals: {lit} in a mark, {dark} in a jump, {behind} with a trace that was cut off before");
    assert!(lit > 0 && dark > 0 && behind * 2 < count, "{lit} in a mark, {dark} in a jump, {behind} not seen");
}
