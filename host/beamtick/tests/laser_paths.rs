//! Light along a path as a user runs it: GUS chapters 4 and 5 and LSR chapters 3 and 4, with values
//! worked out by hand.
//!
//! The listings run 100000 pulses along X, then to (0, 10000), at 50 pulse/ms and 2 pulse/ms²: 25
//! ms and 625 pulses up and down, 2025 ms for the first line, √(10¹⁰ + 10⁸)/50 + 25 = 2034.975124…
//! ms for the second. A call at 0 acts on the first tick, so a path that it starts is T ms into its
//! motion at row T + 0.25. The examples start theirs at 1 ms.
mod manuals;

use assert_cmd::Command;
use manuals::{manual, skipped};
use std::collections::HashMap;
use std::fs;
use std::path::Path;

/// The length of the second line.
const BACK_PULSES: f64 = 100_498.756_211_208_9;
const MS: u64 = 1_000_000;
/// When the path of an example starts, in ms and in ns.
const START_MS: f64 = 1.25;
const START_NS: u64 = 1_250_000;

/// What a job did.
struct Ran {
    out: String,
    errors: String,
    code: i32,
    /// Column by name.
    columns: HashMap<String, usize>,
    rows: Vec<Vec<f64>>,
    vcd: String,
}

/// Runs a job with a tick of `tick_us`.
fn run(text: &str, family: &str, tick_us: u32) -> Ran {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (path, csv, vcd) = (file("job.gts"), file("t.csv"), file("t.vcd"));
    fs::write(&path, text).unwrap();
    let tick = tick_us.to_string();
    let arguments = ["sim", &path, "--family", family, "--tick-us", &tick, "--trace", &csv, "--vcd", &vcd, "--strict"];
    let output = Command::cargo_bin("beamtick").unwrap().env_remove("BEAMTICK_IMAGE").args(arguments).output().unwrap();
    let string = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    let (out, errors) = (string(output.stdout), string(output.stderr));
    let read = |path: &str| fs::read_to_string(path).unwrap_or_default();
    let rows = read(&csv);
    let mut lines = rows.lines();
    let header = lines.next().unwrap_or_default();
    Ran {
        out,
        errors,
        code: output.status.code().unwrap(),
        columns: header.split(',').enumerate().map(|(place, name)| (name.to_owned(), place)).collect(),
        rows: lines.map(|line| line.split(',').map(|value| value.parse().unwrap()).collect()).collect(),
        vcd: read(&vcd),
    }
}

fn example(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples").join(name);
    fs::read_to_string(path).unwrap()
}

impl Ran {
    #[track_caller]
    fn good(self) -> Self {
        assert_eq!(self.code, 0, "{}\n{}", self.out, self.errors);
        self
    }

    /// A column against time, ms.
    fn column(&self, name: &str) -> Vec<(f64, f64)> {
        let place = *self.columns.get(name).unwrap_or_else(|| panic!("no {name} among {:?}", self.columns));
        self.rows.iter().map(|row| (row[0], row[place])).collect()
    }

    #[track_caller]
    fn at(&self, name: &str, t_ms: f64) -> f64 {
        let found = self.column(name).into_iter().find(|(t, _)| (t - t_ms).abs() < 1e-6);
        found.unwrap_or_else(|| panic!("no row at {t_ms} ms")).1
    }

    /// Changes of a signal: instant in ns and what it is then.
    fn edges(&self, signal: &str) -> Vec<(u64, String)> {
        let line = self.vcd.lines().find(|line| line.contains(&format!(" {signal} ")));
        let id = line.unwrap_or_else(|| panic!("no {signal}")).split_whitespace().nth(3).unwrap();
        let mut at = 0;
        let mut edges = Vec::new();
        for line in self.vcd.lines().skip_while(|line| *line != "$enddefinitions $end").skip(1) {
            if let Some(time) = line.strip_prefix('#') {
                at = time.parse().unwrap();
            } else if let Some(value) = line.strip_prefix('r') {
                let (value, of) = value.split_once(' ').unwrap();
                if of == id {
                    edges.push((at, value.to_owned()));
                }
            } else if line.get(1..) == Some(id) {
                edges.push((at, line[..1].to_owned()));
            }
        }
        edges
    }

    /// The values that the job's reads show, in order.
    fn reads(&self) -> Vec<&str> {
        let lines = self.out.lines().filter(|line| line.contains(".gts:"));
        lines.filter_map(|line| Some(line.split_once(" = ")?.1)).collect()
    }
}

/// Coordinate system 1 on axes 1 and 2, and the laser on its connector.
const SET_UP: &str = "short rtn; TCrdPrm crd = {0};
rtn = GT_AxisOn(1); rtn = GT_AxisOn(2);
crd.dimension = 2; crd.profile[0] = 1; crd.profile[1] = 2; crd.synVelMax = 500; crd.synAccMax = 10;
crd.evenTime = 0; crd.setOriginFlag = 1;
rtn = GT_SetCrdPrm(1, &crd);
";

/// The connector is a matter of the GUS family.
fn set_up(family: &str) -> String {
    let connector = if family == "gus" { "rtn = GT_SetAxisMode(7, 1);\n" } else { "" };
    format!("{SET_UP}{connector}")
}

/// Speed of a line of `length` at 50 pulse/ms and 2 pulse/ms², t ms after its begin.
fn speed(length: f64, t: f64) -> f64 {
    let end = length / 50.0 + 25.0;
    (2.0 * t).min(50.0).min(2.0 * (end - t)).max(0.0)
}

/// Way along it.
fn way(length: f64, t: f64) -> f64 {
    let end = length / 50.0 + 25.0;
    if t <= 25.0 {
        t * t
    } else if t <= end - 25.0 {
        625.0 + 50.0 * (t - 25.0)
    } else {
        length - (end - t).max(0.0).powi(2)
    }
}

/// Speed and place of the listings' path, t ms after its start.
fn path(t: f64) -> (f64, [f64; 2]) {
    if t <= 2025.0 {
        return (speed(100_000.0, t), [way(100_000.0, t), 0.0]);
    }
    let part = way(BACK_PULSES, t - 2025.0) / BACK_PULSES;
    (speed(BACK_PULSES, t - 2025.0), [100_000.0 * (1.0 - part), 10_000.0 * part])
}

/// Way of the listings' path.
fn along(t: f64) -> f64 {
    if t <= 2025.0 { way(100_000.0, t) } else { 100_000.0 + way(BACK_PULSES, t - 2025.0) }
}

/// A power is in force for the interval that begins with the tick, and follows the mean speed in
/// it.
fn followed(t: f64) -> f64 {
    (along(t + 0.25) - along(t)) / 0.25
}

/// Rows while the path of a listing runs, t ms after its start: all but the ones around the corner
/// and the ends.
fn rows(ran: &Ran, name: &str) -> Vec<(f64, f64)> {
    let ends = [0.0, 2025.0, 2025.0 + BACK_PULSES / 50.0 + 25.0];
    let all = ran.column(name).into_iter().map(|(t, value)| (t - START_MS, value));
    let clear = |t: f64| t > 0.0 && t < ends[2] && ends.iter().all(|end| (t - end).abs() > 0.3);
    let rows: Vec<_> = all.filter(|(t, _)| clear(*t)).collect();
    assert!(rows.len() > 16_000);
    rows
}

#[test]
fn the_power_changes_at_the_instant_of_the_corner() {
    for (name, family) in [("laser_path_power.gts", "gus"), ("laser_lsr_path_power.gts", "lsr")] {
        let ran = run(&example(name), family, 250).good();
        assert_eq!((ran.at("laser0_power", START_MS), ran.at("laser0_power", 2026.0)), (50.0, 50.0), "{name}");
        assert_eq!((ran.at("laser0_power", 2026.25), ran.at("laser0_power", 4061.0)), (30.0, 30.0), "{name}");
        // 10 kHz from the gate's edge on: period 20250 begins at the corner.
        let energy = ran.edges("laser0_energy");
        let corner = START_NS + 2025 * MS;
        let near: Vec<(u64, &str)> = energy
            .iter()
            .filter(|(at, _)| (corner - 100_000..corner + 200_000).contains(at))
            .map(|(at, level)| (*at, level.as_str()))
            .collect();
        let expected = [
            (corner - 100_000, "1"),
            (corner - 50_000, "0"),
            (corner, "1"),
            (corner + 30_000, "0"),
            (corner + 100_000, "1"),
            (corner + 130_000, "0"),
        ];
        assert_eq!(near, expected, "{name}");
        // The light is the path's: 4059.975124… ms.
        let gate = ran.edges("laser0_switch");
        let end = START_NS + (4_059.975_124_224_178 * 1e6) as u64;
        assert_eq!(gate[1], (START_NS, "1".to_owned()), "{name}");
        let (off, level) = &gate[2];
        assert!(level == "0" && off.abs_diff(end) <= 5, "{name}: {off}, not {end}");
    }
    let ran = run(&example("laser_path_power.gts"), "gus", 250).good();
    assert_eq!(ran.reads(), ["50", "30", "run 0 segment 2", "16239"]);
    let ran = run(&example("laser_lsr_path_power.gts"), "lsr", 250).good();
    assert_eq!(ran.reads(), ["30", "20"]);
}

#[test]
fn a_corner_between_two_ticks_is_met_to_the_ns_at_any_tick() {
    // 10007/50 + 25 = 225.14 ms, then 2000/50 + 25 = 65 ms.
    let text = set_up("gus")
        + "rtn = GT_LaserPowerMode(2, 10, 0, 0);
rtn = GT_BufLaserOn(1, 0, 0);
rtn = GT_BufLaserPrfCmd(1, 5, 0, 0);
rtn = GT_LnXY(1, 10007, 0, 50, 2);
rtn = GT_BufLaserPrfCmd(1, 3, 0, 0);
rtn = GT_LnXY(1, 10007, 2000, 50, 2);
rtn = GT_BufLaserOff(1, 0, 0);
Sleep(1); // set-up takes several ticks of 10 us (SPEC 7)
rtn = GT_CrdStart(1, 0);
WaitStop(1, 0, 1);
Sleep(1);";
    for tick_us in [10u32, 50, 250, 1000] {
        let ran = run(&text, "gus", tick_us).good();
        let start = 1_000_000 + u64::from(tick_us) * 1000;
        let volts: Vec<(u64, f64)> =
            ran.edges("laser0_dac_mv").into_iter().map(|(at, value)| (at, value.parse::<f64>().unwrap())).collect();
        let instants: Vec<u64> = volts.iter().map(|(at, _)| *at).collect();
        let expected = [0, start, start + 225_140_000, start + 290_140_000];
        assert_eq!(instants, expected, "{tick_us} us: {volts:?}");
        for ((_, volts), expected) in volts.iter().zip([0.0, 5000.0, 3000.0, 0.0]) {
            // A DAC of 16 bits over ±10 V.
            assert!((volts - expected).abs() <= 0.31, "{tick_us} us: {volts} mV, not {expected}");
        }
    }
}

#[test]
fn the_power_follows_the_trapezoid() {
    let ran = run(&example("laser_path_follow.gts"), "gus", 250).good();
    assert_eq!(ran.reads(), ["15", "0"]);
    for (t, power) in rows(&ran, "laser0_power") {
        let expected = 0.1 * followed(t) + 10.0;
        assert!((power - expected).abs() < 2e-6, "{t} ms: {power}, not {expected}");
    }
    // The speed that the trace shows is that of the tick.
    for (t, vel) in rows(&ran, "crd1_vel") {
        assert!((vel - path(t).0).abs() < 2e-6, "{t} ms: {vel}, not {}", path(t).0);
    }
}

#[test]
fn bounds_hold_a_follow() {
    // 3·v + 20 is 170 at full speed: held at 90, and at the 80 of the power mode.
    for (most, family) in [(90, "gus"), (100, "gus"), (90, "lsr")] {
        let extra = if family == "lsr" { ", 0, 0" } else { ", 0" };
        let text = format!(
            "{}rtn = GT_LaserPowerMode(0, 80, 25{extra}); rtn = GT_LaserOutFrq(10, 0);
rtn = GT_BufLaserFollowRatio(1, 3, 20, {most}); rtn = GT_BufLaserOn(1);
rtn = GT_LnXY(1, 10000, 0, 50, 2); rtn = GT_CrdStart(1, 0); WaitStop(1, 0, 1); Sleep(1);",
            set_up(family)
        );
        let ran = run(&text, family, 250).good();
        for (t, power) in ran.column("laser0_power").into_iter().map(|(t, power)| (t - 0.25, power)) {
            if (0.0..224.7).contains(&t) {
                let expected = (3.0 * speed(10_000.0, t + 0.125) + 20.0).clamp(25.0, 80.0);
                assert!((power - expected).abs() < 1e-4, "{family} {most}: {t} ms: {power}, not {expected}");
            }
        }
    }
}

#[test]
fn the_distance_is_added() {
    // GUS: the part of the speed in its own bounds, the distance added, the sum in the distance's
    // bounds.
    let ran = run(&example("laser_distance.gts"), "gus", 250).good();
    for (t, power) in rows(&ran, "laser0_power") {
        let [x, y] = path(t).1;
        let part = (0.1 * followed(t)).clamp(0.0, 10.0);
        let expected = (part + 0.1 * x / 1000.0 + 0.1 * y / 1000.0).clamp(10.0, 100.0);
        assert!((power - expected).abs() < 2e-5, "{t} ms: {power}, not {expected}");
    }
    // LSR: the sum of all in the follow's bounds.
    let ran = run(&example("laser_lsr_distance.gts"), "lsr", 250).good();
    for (t, power) in rows(&ran, "laser0_power") {
        let [x, y] = path(t).1;
        let expected = (0.1 * followed(t) + 0.1 * x / 1000.0 + 0.1 * y / 1000.0).clamp(0.0, 10.0);
        assert!((power - expected).abs() < 2e-5, "{t} ms: {power}, not {expected}");
    }
}

#[test]
fn ratios_come_from_a_table_over_the_position() {
    // Axis 1: 0.1 up to 2000, 0.5 from 6000 on, linear between; the reference is 1000. Axis 2 and
    // the others: none.
    let text = set_up("lsr")
        + "long pos[4] = {1000, 0, 0, 0}; double scale[4] = {1000, 1000, 1000, 1000};
long at[8] = {2000, 6000, 0, 1, 0, 1, 0, 1}; double ratio[8] = {1, 5, 0, 0, 0, 0, 0, 0};
rtn = GT_LaserPowerMode(0, 100, 0, 0, 0); rtn = GT_LaserOutFrq(10, 0);
rtn = GT_LaserPrfCmd(10, 0);
rtn = GT_SetLaserDisMode(1, 0, pos, scale, 0);
rtn = GT_SetLaserDisTable1D(2, ratio, at, 0, 100, LIMITS, 0);
rtn = GT_BufLaserOn(1); rtn = GT_LnXY(1, 10000, 0, 50, 2); rtn = GT_CrdStart(1, 0); WaitStop(1, 0, 1); Sleep(1);";
    let distance = |x: f64| (x - 1000.0) / 1000.0 * (1.0 + (x - 2000.0).clamp(0.0, 4000.0) / 1000.0);
    // Without limits, and with one of 12 % for axis 1.
    for (limits, most) in [("NULL", f64::MAX), ("limit", 12.0)] {
        let text = format!("double limit[4] = {{12, 0, 0, 0}};\n{}", text.replace("LIMITS", limits));
        let ran = run(&text, "lsr", 250).good();
        for (t, power) in ran.column("laser0_power").into_iter().map(|(t, power)| (t - 0.25, power)) {
            if (0.0..224.7).contains(&t) {
                let expected = (10.0 + distance(way(10_000.0, t)).clamp(-most, most)).clamp(0.0, 100.0);
                assert!((power - expected).abs() < 1e-4, "{limits}: {t} ms: {power}, not {expected}");
            }
        }
    }
}

#[test]
fn ratios_come_from_a_table_over_the_plane() {
    // Corners (0, 0), (10000, 0), (0, 5000), (10000, 5000) with ratios 1, 2, 3, 5; the path is the
    // diagonal, and beyond.
    let text = set_up("lsr")
        + "long pos[4] = {0, 0, 0, 0}; double scale[4] = {1000, 500, 1, 1};
short axis[2] = {1, 2}; short count[2] = {2, 2}; long x[2] = {0, 10000}; long y[2] = {0, 5000};
double ratio[4] = {1, 2, 3, 5};
rtn = GT_LaserPowerMode(0, 100, 0, 0, 0); rtn = GT_LaserOutFrq(10, 0);
rtn = GT_SetLaserDisMode(1, 0, pos, scale, 0);
rtn = GT_SetLaserDisTable2D(axis, count, ratio, x, y, 0, 100, NULL, 0);
rtn = GT_BufLaserOn(1); rtn = GT_LnXY(1, 12000, 6000, 50, 2); rtn = GT_CrdStart(1, 0); WaitStop(1, 0, 1); Sleep(1);";
    let length = 12_000f64.hypot(6_000.0);
    let ran = run(&text, "lsr", 250).good();
    let mut seen = 0;
    for (t, power) in ran.column("laser0_power").into_iter().map(|(t, power)| (t - 0.25, power)) {
        let part = way(length, t) / length;
        let (x, y) = (12_000.0 * part, 6_000.0 * part);
        let (u, v) = ((x / 10_000.0).min(1.0), (y / 5_000.0).min(1.0));
        let ratio = (1.0 + u) * (1.0 - v) + (3.0 + 2.0 * u) * v;
        let expected = ((x / 1000.0 + y / 500.0) * ratio).clamp(0.0, 100.0);
        if t >= 0.0 && t < length / 50.0 + 24.7 {
            assert!((power - expected).abs() < 1e-3, "{t} ms: {power}, not {expected}");
            seen += usize::from(expected > 50.0 && expected < 100.0);
        }
    }
    assert!(seen > 100);
}

#[test]
fn a_table_of_many_points_arrives_whole() {
    // 16 × 16 points a thousand pulses apart, the ratio 0.1·(i + j): three records. The path is the
    // diagonal.
    let list =
        |values: &mut dyn Iterator<Item = f64>| values.map(|value| value.to_string()).collect::<Vec<_>>().join(",");
    let lines = list(&mut (0..16).map(|i| f64::from(i) * 1000.0));
    let ratios = list(&mut (0..256).map(|n| f64::from(n % 16 + n / 16) / 10.0));
    let text = set_up("lsr")
        + &format!(
            "long pos[4] = {{0,0,0,0}}; double scale[4] = {{1000,1000,1,1}}; short axis[2] = {{1,2}}; short count[2] = {{16,16}};
long x[16] = {{{lines}}}; long y[16] = {{{lines}}}; double ratio[256] = {{{ratios}}};
rtn = GT_LaserPowerMode(0, 100, 0, 0, 0); rtn = GT_LaserOutFrq(10, 0);
rtn = GT_SetLaserDisMode(1, 0, pos, scale, 0);
rtn = GT_SetLaserDisTable2D(axis, count, ratio, x, y, 0, 100, NULL, 0);
rtn = GT_BufLaserOn(1); rtn = GT_LnXY(1, 12000, 12000, 50, 2); rtn = GT_CrdStart(1, 0); WaitStop(1, 0, 1); Sleep(1);"
        );
    let length = 12_000f64.hypot(12_000.0);
    let ran = run(&text, "lsr", 250).good();
    for (t, power) in ran.column("laser0_power").into_iter().map(|(t, power)| (t - 0.25, power)) {
        let u = 12.0 * way(length, t) / length;
        if t >= 0.0 && t < length / 50.0 + 24.7 {
            // Both axes have the ratio 0.2·u at the distance u.
            let expected = (2.0 * u * 0.2 * u).min(100.0);
            assert!((power - expected).abs() < 1e-4, "{t} ms: {power}, not {expected}");
        }
    }
}

#[test]
fn what_is_held_of_a_follow_is_shown_at_its_line() {
    let text = set_up("lsr")
        + "double vel[2] = {0, 10}; double power[2] = {-5, 120};
long pos[4] = {0,0,0,0}; double scale[4] = {0, 1000, 70000, 1};
rtn = GT_SetLaserFollowTable(1, 2, vel, power, 0);
rtn = GT_BufLaserFollowRatio(1, 0.1, -1, 150);
rtn = GT_SetLaserDisMode(1, 0, pos, scale, 0);
rtn = GT_LaserPrfCmd(5);";
    let ran = run(&text, "lsr", 250).good();
    for part in [
        "GT_SetLaserFollowTable: 2 powers are out of range; their nearest bounds are taken",
        "GT_BufLaserFollowRatio: max is out of range; 100 is taken, min is out of range; 0 is taken",
        "GT_SetLaserDisMode: scale 1 is out of range; 1 is taken, scale 3 is out of range; 65536 is taken",
    ] {
        assert!(ran.errors.contains(part), "{part:?} is not in\n{}", ran.errors);
    }
    // The other family refuses the first of them.
    let ran = run(&text.replace(SET_UP, &set_up("gus")), "gus", 250);
    let text = "GT_SetLaserFollowTable returned 7: power is -5; it must be from 0 to 100";
    assert!(ran.code != 0 && ran.errors.contains(text), "{}", ran.errors);
}

#[test]
fn powers_come_from_a_table_over_the_speed() {
    // 5 % at rest, 20 % at 10, 80 % at 40 pulse/ms and above; held at 70.
    let text = set_up("gus")
        + "double vel[3] = {0, 10, 40}; double power[3] = {5, 20, 80};
rtn = GT_LaserPowerMode(0, 100, 0, 0); rtn = GT_LaserOutFrq(10, 0);
rtn = GT_SetLaserFollowTable(1, 3, vel, power, 0);
rtn = GT_BufLaserFollowTable(1, 1, 0, 70); rtn = GT_BufLaserOn(1);
rtn = GT_LnXY(1, 10000, 0, 50, 2); rtn = GT_CrdStart(1, 0); WaitStop(1, 0, 1); Sleep(1);";
    let ran = run(&text, "gus", 250).good();
    for (t, power) in ran.column("laser0_power").into_iter().map(|(t, power)| (t - 0.25, power)) {
        if (0.0..224.7).contains(&t) {
            let v = speed(10_000.0, t + 0.125);
            let expected = if v < 10.0 { 5.0 + 1.5 * v } else { (2.0 * v).min(70.0) };
            assert!((power - expected).abs() < 1e-4, "{t} ms: {power}, not {expected}");
        }
    }
}

#[test]
fn a_follow_ends_by_follow_off_and_by_a_direct_power() {
    // GUS: FollowOff leaves the direct power that was set before, a direct power ends the follow.
    // LSR: it is added.
    let lines = |entry: &str| {
        format!(
            "rtn = GT_LaserOutFrq(10, 0);
rtn = GT_BufLaserPrfCmd(1, 40); rtn = GT_BufLaserFollowRatio(1, 0.1, 10, 100); rtn = GT_BufLaserOn(1);
rtn = GT_LnXY(1, 10000, 0, 50, 2); {entry}; rtn = GT_LnXY(1, 20000, 0, 50, 2);
rtn = GT_BufLaserOff(1); rtn = GT_CrdStart(1, 0); WaitStop(1, 0, 1); Sleep(1);"
        )
    };
    // At full speed, 100 ms into either line: the first begins at 0.25 ms, the second 225 ms later.
    for (family, entry, first, second) in [
        ("gus", "rtn = GT_BufLaserFollowOff(1)", 15.0, 40.0),
        ("gus", "rtn = GT_BufLaserPrfCmd(1, 33)", 15.0, 33.0),
        ("lsr", "rtn = GT_BufLaserFollowOff(1)", 55.0, 40.0),
        ("lsr", "rtn = GT_BufLaserPrfCmd(1, 33)", 55.0, 48.0),
        ("lsr", "rtn = GT_BufLaserFollowMode(1, 0, 0, 0, 7)", 55.0, 22.0),
        ("lsr", "rtn = GT_BufLaserFollowMode(1, 0, 0, 0)", 55.0, 55.0),
    ] {
        let ran = run(&(set_up(family) + &lines(entry)), family, 250).good();
        let seen = (ran.at("laser0_power", 100.25), ran.at("laser0_power", 325.25));
        assert!((seen.0 - first).abs() < 1e-6 && (seen.1 - second).abs() < 1e-6, "{family} {entry}: {seen:?}");
    }
}

#[test]
fn light_under_a_follow_ends_with_the_motion_and_comes_back_with_it() {
    // No BufLaserOff. Stop at 100 ms brakes in 25 ms; 20 ms later the path goes on; its end shuts
    // off the light.
    for family in ["gus", "lsr"] {
        let text = set_up(family)
            + "unsigned long units;
rtn = GT_LaserOutFrq(10, 0); rtn = GT_SetCrdStopDec(1, 2, 100);
rtn = GT_BufLaserFollowRatio(1, 0.1, 10, 100); rtn = GT_BufLaserOn(1);
rtn = GT_LnXY(1, 10000, 0, 50, 2); rtn = GT_CrdStart(1, 0);
Sleep(100); rtn = GT_Stop(1 << 8, 0); WaitStop(1, 0, 1); Sleep(20);
rtn = GT_CrdStart(1, 0); WaitStop(1, 0, 1); Sleep(10);
rtn = GT_GetLaserOnTime(0, &units);";
        let ran = run(&text, family, 250).good();
        let gate = ran.edges("laser0_switch");
        let levels: Vec<&str> = gate.iter().map(|(_, level)| level.as_str()).collect();
        assert_eq!(levels, ["0", "1", "0", "1", "0"], "{family}: {gate:?}");
        let ns = |ms: f64| (ms * 1e6) as u64;
        // Stopped from row 100.25 on, at rest 25 ms later, at 625 + 50·75 + 625 = 5000 pulses.
        assert_eq!((gate[1].0, gate[2].0), (ns(0.25), ns(125.25)), "{family}");
        // WaitStop ends at the tick of the rest, the start acts a tick after the sleep.
        assert_eq!(gate[3].0, ns(145.5), "{family}");
        // 5000 pulses more: 100 + 25 ms.
        assert_eq!(gate[4].0, ns(270.5), "{family}");
        assert_eq!(ran.reads(), ["1000"], "{family}: 250 ms of light");
        assert!(ran.out.contains("laser 0: duty mode, dark") && !ran.out.contains("was on"), "{}", ran.out);
    }
}

#[test]
fn speed_0_under_a_follow_is_the_least_power_and_not_darkness() {
    let text = set_up("gus")
        + "rtn = GT_LaserOutFrq(10, 0); rtn = GT_BufLaserFollowRatio(1, 1, 12, 100); rtn = GT_BufLaserOn(1);
rtn = GT_LnXY(1, 5000, 0, 50, 2); rtn = GT_BufDelay(1, 50); rtn = GT_LnXY(1, 0, 0, 50, 2);
rtn = GT_CrdStart(1, 0); WaitStop(1, 0, 1); Sleep(1);";
    let ran = run(&text, "gus", 250).good();
    // 125 ms of motion, 50 ms at rest with 12 % of light.
    for t in [126.25, 150.25, 174.25] {
        assert_eq!((ran.at("laser0_power", t), ran.at("laser0_gate", t)), (12.0, 1.0), "{t}");
    }
    assert_eq!(ran.edges("laser0_switch").len(), 3);
}

#[test]
fn light_of_a_path_ends_with_its_entries_whatever_was_called_meanwhile() {
    // An on command while the path's light is on changes nothing (SPEC 6).
    let text = set_up("lsr")
        + "rtn = GT_LaserOutFrq(10, 0); rtn = GT_BufLaserFollowRatio(1, 0.1, 10, 100); rtn = GT_BufLaserOn(1);
rtn = GT_LnXY(1, 5000, 0, 50, 2); rtn = GT_CrdStart(1, 0);
Sleep(50); rtn = GT_SetHSIOOpt(1, 0); WaitStop(1, 0, 1); Sleep(20); rtn = GT_SetHSIOOpt(0, 0); Sleep(1);";
    let ran = run(&text, "lsr", 250).good();
    let gate = ran.edges("laser0_switch");
    // 125 ms of motion, from the tick on which it begins.
    assert_eq!(gate.len(), 3, "{gate:?}");
    assert_eq!(gate[2].0, 125_250_000);
    assert_eq!(ran.at("laser0_power", 140.25), 0.0);
}

#[test]
fn the_encoders_speed_is_followed_too() {
    let ran = run(&example("laser_lsr_path_follow.gts"), "lsr", 250).good();
    assert_eq!(ran.reads(), ["20"]);
    // At constant speed the encoders go as fast as the plan: a pulse more or less in a tick of 0.25
    // ms is 4 pulse/ms.
    for (t, power) in rows(&ran, "laser0_power") {
        if (100.0..900.0).contains(&t) {
            assert!((power - 15.0).abs() <= 0.4, "{t} ms: {power}");
        }
        if (1100.0..1900.0).contains(&t) {
            assert!((power - 35.0).abs() <= 0.4, "{t} ms: {power}");
        }
    }
    let mean = |from: f64, to: f64| {
        let rows: Vec<f64> = rows(&ran, "laser0_power")
            .iter()
            .filter(|(t, _)| (from..to).contains(t))
            .map(|(_, power)| *power)
            .collect();
        rows.iter().sum::<f64>() / rows.len() as f64
    };
    assert!((mean(100.0, 900.0) - 15.0).abs() < 0.01 && (mean(1100.0, 1900.0) - 35.0).abs() < 0.01);
}

#[test]
fn the_contour_runs() {
    let ran = run(&example("laser_contour.gts"), "gus", 250).good();
    assert!(ran.reads()[0].contains("segment 10"), "{}", ran.out);
    // 4·v + 10 held at 90, wherever the tick lies in one motion.
    let vel = ran.column("crd1_vel");
    let power = ran.column("laser0_power");
    let lit: Vec<(f64, f64)> = vel.iter().zip(&power).map(|(v, p)| (v.1, p.1)).filter(|(v, _)| *v > 0.0).collect();
    let near = lit.iter().filter(|(v, p)| (p - (4.0 * v + 10.0).min(90.0)).abs() < 0.6).count();
    assert!(near as f64 > 0.98 * lit.len() as f64, "{near} of {}", lit.len());
    let most = lit.iter().map(|(_, p)| *p).fold(0.0, f64::max);
    assert_eq!(most, 90.0);
}

/// A listing of a manual as it is printed, with what its text leaves out: a coordinate system where
/// dots stand for it. What the file has of its own between pages is no part of it.
fn pasted(manual: &str, from: &str, to: &str) -> String {
    let part = &manual[manual.find(from).unwrap_or_else(|| panic!("{from}"))..];
    let end = if to.is_empty() { part.len() } else { part.find(to).unwrap_or_else(|| panic!("{to}")) };
    let lines = part[..end].lines().skip_while(|line| !(line.starts_with("…… ……") || line.starts_with(".....")));
    let text: String = lines.filter(|line| !line.contains("<|")).map(|line| line.to_owned() + "\n").collect();
    format!("{SET_UP}{text}\nWaitStop(1, 0, 1);\nSleep(1);\n")
}

#[test]
fn the_manuals_listings_run_as_pasted() {
    let (Some(gus), Some(lsr)) = (manual("000"), manual("003")) else { return skipped() };
    // By the way and the speed of the path, 975 ms into the second line.
    let [x, y] = path(3000.0).1;
    let far = 5.0 + 0.1 * (x + y) / 1000.0;
    // Power of channel 0 at two instants: on the first line, and on the second. LSR 6 names channel
    // 1 for what gives power and channel 0 for the light, which so has none.
    for (manual, family, from, to, [first, second], close) in [
        (&gus, "gus", "4.2 例程\n\n能量直接", "能量跟随模式：\n\n同样", [50.0, 30.0], 1e-6),
        (&gus, "gus", "能量跟随模式：\n\n同样", "\n5 激光能量跟随距离功能", [15.0, 15.0], 1e-6),
        (&gus, "gus", "5.2 例程\n\n能量", "", [10.0, far], 1e-5),
        (&lsr, "lsr", "\n例程 4 ", "\n例程 5 ", [50.0, 30.0], 1e-6),
        (&lsr, "lsr", "\n例程 5 ", "\n四、激光能量跟随距离功能", [15.0, 15.0], 0.4),
        (&lsr, "lsr", "\n例程 6 ", "\n五、指令详细说明", [0.0, 0.0], 1e-6),
    ] {
        let ran = run(&pasted(manual, from, to), family, 250).good();
        let seen = (ran.at("laser0_power", 1000.25), ran.at("laser0_power", 3000.25));
        let near = (seen.0 - first).abs() <= close && (seen.1 - second).abs() <= close;
        assert!(near, "{family} {from:?}: {seen:?}, not {first} and {second}");
        assert_eq!((ran.at("laser0_gate", 1000.25), ran.at("laser0_gate", 4060.75)), (1.0, 0.0), "{family} {from:?}");
    }
}
