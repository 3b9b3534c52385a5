//! What a run did: its output, its trace, distances. Shared by the tests of G-code and of drawings.
#![allow(dead_code)]
use std::fs;
use std::path::Path;
use std::process::Command;

/// Runs `beamtick`: what it prints, and its code.
pub fn beamtick(folder: &Path, words: &[&str]) -> (String, i32) {
    let out = Command::new(env!("CARGO_BIN_EXE_beamtick")).args(words).current_dir(folder).output().unwrap();
    let said = String::from_utf8_lossy(&out.stdout).into_owned() + &String::from_utf8_lossy(&out.stderr);
    (said, out.status.code().unwrap())
}

/// A row: axes X, Y, Z in pulses, gate, power, speed of the path.
pub struct Row {
    pub at: [f64; 3],
    pub lit: bool,
    pub power: f64,
    pub vel: f64,
}

/// The rows of a trace; X, Y, Z are the axes 2, 1, 5.
pub fn rows(file: &Path) -> Vec<Row> {
    let text = fs::read_to_string(file).unwrap();
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let column =
        |name: &str| names.iter().position(|other| *other == name).unwrap_or_else(|| panic!("{name}: {names:?}"));
    let axes = ["axis2_pos", "axis1_pos", "axis5_pos"].map(column);
    let [gate, power, vel] = ["laser0_gate", "laser0_power", "crd1_vel"].map(column);
    let row = |line: &str| {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        Row { at: axes.map(|at| cells[at]), lit: cells[gate] > 0.5, power: cells[power], vel: cells[vel] }
    };
    lines.map(row).collect()
}

/// How far a point is from a line between two others.
pub fn off(point: [f64; 3], [from, to]: [[f64; 3]; 2]) -> f64 {
    let minus = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let (way, to_point) = (minus(to, from), minus(point, from));
    let part = if dot(way, way) > 0.0 { (dot(way, to_point) / dot(way, way)).clamp(0.0, 1.0) } else { 0.0 };
    let rest = minus(to_point, way.map(|x| x * part));
    dot(rest, rest).sqrt()
}
