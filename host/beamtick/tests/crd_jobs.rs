//! The examples of coordinate systems: rows of their traces by hand. A start of the first instant
//! acts on the first tick, so what happens t ms after it stands in the row of t + 0.25 ms.
use assert_cmd::Command;
use std::collections::HashMap;
use std::fs;
use std::path::Path;

/// A job's trace, column by column, and what it said.
struct Ran {
    out: String,
    columns: HashMap<String, Vec<f64>>,
}

fn run(name: &str) -> Ran {
    let job = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples").join(name);
    let folder = tempfile::tempdir().unwrap();
    let trace = folder.path().join("trace.csv");
    let arguments = ["sim", job.to_str().unwrap(), "--strict", "--trace", trace.to_str().unwrap()];
    let output = Command::cargo_bin("beamtick").unwrap().env_remove("BEAMTICK_IMAGE").args(arguments).output().unwrap();
    let out = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{out}\n{}", String::from_utf8_lossy(&output.stderr));
    let text = fs::read_to_string(&trace).unwrap();
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let mut columns: HashMap<String, Vec<f64>> = names.iter().map(|name| (name.to_string(), Vec::new())).collect();
    for line in lines {
        for (name, value) in names.iter().zip(line.split(',')) {
            columns.get_mut(*name).unwrap().push(value.parse().unwrap());
        }
    }
    Ran { out, columns }
}

impl Ran {
    fn rows(&self) -> usize {
        self.columns["t_ms"].len()
    }
    fn at(&self, name: &str, row: usize) -> f64 {
        self.columns[name][row]
    }
    /// X and Y, and the speed along them, `ms` after the first tick.
    fn stands(&self, ms: f64, x: f64, y: f64, speed: f64) {
        let row = ((ms + 0.25) * 4.0).round() as usize;
        let found = (self.at("axis1_pos", row), self.at("axis2_pos", row), self.speed(row));
        let close = (found.0 - x).abs() < 2e-5 && (found.1 - y).abs() < 2e-5 && (found.2 - speed).abs() < 2e-5;
        assert!(close, "{found:?} is not {:?} at {ms} ms", (x, y, speed));
    }
    fn speed(&self, row: usize) -> f64 {
        self.at("axis1_vel", row).hypot(self.at("axis2_vel", row))
    }
    /// Rows, from this one on, until both axes rest.
    fn rest_after(&self, row: usize) -> f64 {
        let mut row = row;
        while self.speed(row) == 0.0 {
            row += 1;
        }
        while self.speed(row) != 0.0 {
            row += 1;
        }
        row as f64 / 4.0 - 0.25
    }
    fn says(&self, line: &str) {
        let said = self.out.lines().any(|said| said.ends_with(line));
        assert!(said, "no `{line}` in {}", self.out);
    }
}

/// Sides of 10000 pulses from rest to rest: 25 ms up over 625 pulses, 175 ms, 25 ms down; four of
/// them. Then with look-ahead: corners take c = 2·5 = 10 pulse/ms. Plans keep 1/16384 below a = 2.
/// The sides are so long that a corner takes nothing of that (decision 9): from the corner to the
/// middle of a side most of the time passes at full speed.
#[test]
fn square_with_corners() {
    let ran = run("square_with_corners.gts");
    ran.stands(25.0, 625.0, 0.0, 50.0);
    ran.stands(112.5, 5000.0, 0.0, 50.0);
    ran.stands(200.0, 9375.0, 0.0, 50.0);
    ran.stands(225.0, 10_000.0, 0.0, 0.0);
    ran.stands(337.5, 10_000.0, 5000.0, 50.0);
    ran.stands(562.5, 5000.0, 10_000.0, 50.0);
    ran.stands(787.5, 0.0, 5000.0, 50.0);
    ran.stands(900.0, 0.0, 0.0, 0.0);
    let (v, c) = (50.0f64, 10.0f64);
    let a = 2.0 * (1.0 - 1.0 / 16_384.0);
    let outer = v / a + (v - c) / a + (10_000.0 - v * v / (2.0 * a) - (v * v - c * c) / (2.0 * a)) / v;
    let inner = 2.0 * (v - c) / a + (10_000.0 - (v * v - c * c) / a) / v;
    let took = ran.rest_after(4 * 900 + 2) - 900.0;
    let planned = 2.0 * outer + 2.0 * inner;
    assert!(took >= planned && took < planned + 0.6, "{took} {planned}");
    // Through the first corner at 10 pulse/ms: the last row in X and the first in Y.
    let turn = (4 * 900..).find(|row| ran.at("axis2_vel", *row) > 0.0).unwrap();
    for row in [turn - 1, turn] {
        assert!((10.0..10.6).contains(&ran.speed(row)), "{}", ran.speed(row));
    }
    ran.says("GT_CrdSpace space = 1020");
    ran.says("GT_CrdStatus run, segment = run 0 segment 8");
}

/// A circle of 2π·5000 pulses at 50 pulse/ms from rest to rest; half of it after half of the time.
/// Then two quarters without a stop between them, and half turns in the other planes.
#[test]
fn arcs() {
    let ran = run("arcs.gts");
    let round = std::f64::consts::TAU * 5000.0;
    let first = round / 50.0 + 25.0;
    let half = ((first / 2.0 + 0.25) * 4.0).round() as usize;
    assert!((ran.at("axis1_pos", half) - 10_000.0).abs() < 0.1 && ran.at("axis2_pos", half).abs() < 10.0);
    // Clockwise from (0, 0) about (5000, 0): first up.
    assert!(ran.at("axis2_pos", 400) > 0.0);
    let second = first + round / 2.0 / 50.0 + 25.0;
    for row in 1..((second + 0.25) * 4.0) as usize {
        let (x, y) = (ran.at("axis1_pos", row) - 5000.0, ran.at("axis2_pos", row));
        assert!((x.hypot(y) - 5000.0).abs() < 1e-3, "row {row}");
    }
    let top = ((first + 25.0 + (round / 4.0 - 625.0) / 50.0 + 0.25) * 4.0).round() as usize;
    assert!((ran.at("axis1_pos", top) - 5000.0).abs() < 7.0 && (ran.speed(top) - 50.0).abs() < 1e-4);
    // After the delay: half a turn about (Y 2000, Z 0), counterclockwise from Y to Z.
    let from = ((second + 100.0 + 0.25) * 4.0) as usize + 4;
    let third = 2000.0 * std::f64::consts::PI / 50.0 + 25.0;
    let middle = from + (third * 2.0) as usize;
    assert!((ran.at("axis3_pos", middle) + 2000.0).abs() < 1.0, "{}", ran.at("axis3_pos", middle));
    for row in from..from + (third * 4.0) as usize - 8 {
        let (y, z) = (ran.at("axis2_pos", row) - 2000.0, ran.at("axis3_pos", row));
        assert!((y.hypot(z) - 2000.0).abs() < 1e-3, "row {row}");
    }
    let last = ran.rows() - 1;
    let end = ["axis1_pos", "axis2_pos", "axis3_pos"].map(|name| ran.at(name, last));
    assert_eq!(end, [6000.0, 4000.0, 0.0]);
}

/// v²/R is 2.5 pulse/ms² at most, of 4. Three ends are rounded by half a pulse each, and the middle
/// one counts twice. So they turn a corner by up to 2/80 more than the spiral's 80/4000. That
/// leaves √(4·127/128·80/0.045) = 84 pulse/ms: this much or more along the whole path, from ramp to
/// ramp.
#[test]
fn spiral() {
    let ran = run("spiral.gts");
    let mut way = vec![0.0];
    for row in 1..ran.rows() {
        let step = (ran.at("axis1_pos", row) - ran.at("axis1_pos", row - 1))
            .hypot(ran.at("axis2_pos", row) - ran.at("axis2_pos", row - 1));
        way.push(way[row - 1] + step);
    }
    let whole = way[ran.rows() - 1];
    for row in (0..ran.rows()).filter(|row| way[*row] > 2500.0 && way[*row] < whole - 2500.0) {
        assert!((84.0..100.0001).contains(&ran.speed(row)), "{} pulse/ms at {}", ran.speed(row), way[row]);
    }
    // Accelerations are means over a line's time here: no coordinate takes more than 4 and what a
    // tick sees of a corner.
    let lines = 8;
    for row in lines..ran.rows() {
        for axis in ["axis1_vel", "axis2_vel"] {
            let change = (ran.at(axis, row) - ran.at(axis, row - lines)).abs();
            assert!(change <= 4.0 * (lines as f64 / 4.0 + 0.8), "row {row}: {change}");
        }
    }
    ran.says("GT_CrdStatus run, segment = run 0 segment 300");
    ran.says("GT_GetRemainderSegNum left = 0");
}

/// Stopped at 4500 pulses: 25 ms up, 75 ms at 50 pulse/ms, 5 ms down at synAccMax, 10; the Stop
/// acts on the tick after 100 ms.
#[test]
fn interrupt() {
    let ran = run("interrupt.gts");
    ran.stands(101.0, 4375.0, 0.0, 50.0);
    ran.stands(106.0, 4500.0, 0.0, 0.0);
    // Aside: 3000 pulses, 25 + 35 + 25 = 85 ms, a delay of 50 ms, and back.
    let last = ran.rows() - 1;
    let lowest = ran.columns["axis2_pos"].iter().copied().fold(0.0, f64::min);
    assert_eq!(lowest, -3000.0);
    let aside = (0..=last).filter(|row| ran.at("axis2_pos", *row) == -3000.0).count();
    assert!((200..=204).contains(&aside), "{aside} rows");
    assert_eq!((ran.at("axis1_pos", last), ran.at("axis2_pos", last)), (10_000.0, 6000.0));
    ran.says("GT_CrdStatus run, segment = run 0 segment 2");
}

/// At 100 ms 4375 pulses have gone; braking to 25 takes 12.5 ms and 468.75 pulses; 87.5 ms at 25;
/// up again the same way.
#[test]
fn an_override() {
    let ran = run("override.gts");
    ran.stands(100.0, 4375.0, 0.0, 50.0);
    ran.stands(112.5, 4843.75, 0.0, 25.0);
    ran.stands(200.0, 7031.25, 0.0, 25.0);
    ran.stands(212.5, 7500.0, 0.0, 50.0);
    ran.stands(300.0, 11_875.0, 0.0, 50.0);
    ran.stands(310.0, 12_125.0, 0.0, 0.0);
    let last = ran.rows() - 1;
    assert_eq!(ran.at("axis1_pos", last), 20_000.0);
    // On from there: 7875 pulses from rest to rest.
    let took = ran.rest_after(4 * 330) - ran.rest_after(4 * 200);
    let expected = 50.0 + 7875.0 / 50.0 + 25.0;
    assert!((took - expected).abs() < 0.8, "{took} {expected}");
}
