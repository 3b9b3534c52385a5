//! Listings of the GXN manual as they stand in its text, where the manuals are at hand, and the
//! examples that were made from them: rows of their traces by hand. A start of the first instant
//! acts on the first tick, so what happens t ms after it stands in the row of t + 0.25 ms.
mod manuals;

use assert_cmd::Command;
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples").join(name)
}

fn manual() -> Option<String> {
    let found = manuals::manual("001");
    if found.is_none() {
        manuals::skipped();
    }
    found
}

/// What stands in fences between a heading and the next.
fn listing(manual: &str, from: &str, to: &str) -> String {
    let from = manual.find(from).unwrap();
    let to = manual[from + 1..].find(to).unwrap();
    let mut inside = false;
    manual[from..from + 1 + to]
        .lines()
        .filter(|line| {
            let fence = line.starts_with("```");
            inside ^= fence;
            inside && !fence
        })
        .flat_map(|line| [line, "\n"])
        .collect()
}

/// A run of a job: what it said, its errors, its exit code, and its trace.
struct Ran {
    out: String,
    errors: String,
    code: i32,
    rows: String,
    _folder: TempDir,
}

fn run(text: &str) -> Ran {
    let folder = tempfile::tempdir().unwrap();
    let (job, trace) = (folder.path().join("listing.gts"), folder.path().join("listing.csv"));
    fs::write(&job, text).unwrap();
    fs::copy(example("test.cfg"), folder.path().join("test.cfg")).unwrap();
    let arguments = ["sim", job.to_str().unwrap(), "--strict", "--trace", trace.to_str().unwrap()];
    let output = Command::cargo_bin("beamtick").unwrap().env_remove("BEAMTICK_IMAGE").args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    let (out, errors, code) = (text(output.stdout), text(output.stderr), output.status.code().unwrap());
    Ran { out, errors, code, rows: fs::read_to_string(&trace).unwrap_or_default(), _folder: folder }
}

impl Ran {
    fn done(self) -> Ran {
        assert_eq!(self.code, 0, "{}\n{}", self.out, self.errors);
        self
    }

    /// Columns of the row at this time, as they are printed.
    fn row(&self, ms: f64) -> Vec<&str> {
        let begin = format!("{ms:.6},");
        let row = self.rows.lines().find(|line| line.starts_with(&begin)).unwrap_or_else(|| panic!("no row {begin}"));
        row.split(',').skip(1).collect()
    }

    /// Whether axes from 1 on have these positions and velocities at `ms` after the first tick, to
    /// the last digit printed.
    fn moves(&self, ms: f64, axes: &[(f64, f64)]) {
        let row = self.row(ms + 0.25);
        let expected: Vec<f64> = axes.iter().flat_map(|&(pos, vel)| [pos, vel]).collect();
        let found: Vec<f64> = row.iter().map(|column| column.parse().unwrap()).collect();
        let close = expected.iter().zip(&found).all(|(a, b)| (a - b).abs() < 1.1e-6);
        assert!(expected.len() == found.len() && close, "{found:?} is not {expected:?} at {ms} ms");
    }

    /// Whether this line is among what it said, after the place in the job.
    fn says(&self, line: &str) {
        let said = self.out.lines().filter_map(|said| Some(said.split_once(": ")?.1)).any(|said| said == line);
        assert!(said, "no `{line}` in {}", self.out);
    }

    /// Whether axes 1 and 2 are at these whole pulses, and axis 2 has this velocity, at `ms` after
    /// the first tick.
    fn stands(&self, ms: f64, master: i64, slave: i64, velocity: f64) {
        let row = self.row(ms + 0.25);
        assert_eq!([row[0], row[2]], [format!("{master}.000000"), format!("{slave}.000000")], "at {ms} ms");
        assert!((row[3].parse::<f64>().unwrap() - velocity).abs() < 1e-6, "{} at {ms} ms", row[3]);
    }
}

#[test]
fn listing_2_1_runs() {
    let Some(manual) = manual() else { return };
    let ran = run(&listing(&manual, "\n例程 2-1", "2. PT 动态 FIFO")).done();
    // The plateau of 2 pulse/ms, and the end at 3072 ms.
    assert_eq!(ran.row(1500.25), ["1976.000000", "2.000000"]);
    assert_eq!(ran.row(3072.25), ["4096.000000", "0.000000"]);
    assert_ne!(ran.row(3072.0)[0], "4096.000000", "there too early");
}

#[test]
fn listings_4_1_and_4_3_run() {
    let Some(manual) = manual() else { return };
    let ran = run(&listing(&manual, "\n例程 4-1 PVT", "\n例程 4-2 Complete")).done();
    assert!(ran.out.contains("axis 1: planned 68966.000000"), "{}", ran.out);
    // Its second assignment to mask forgets axis X.
    let ran = run(&listing(&manual, "\n例程 4-3 Percent", "\n例程 4-4 Continuous")).done();
    assert!(ran.out.contains("axis 2: planned 45000.000000"), "{}", ran.out);
}

#[test]
fn listing_3_2_runs_with_a_sleep_in_place_of_the_key() {
    let Some(manual) = manual() else { return };
    let text = listing(&manual, "\n例程 3-2 Follow", "\n例程 3-3 Follow");
    let ran = run(&text);
    assert!(ran.code != 0 && ran.errors.contains("axis 1 of core 1, started in line"), "{}", ran.errors);
    assert!(ran.errors.contains("runs for ever"), "{}", ran.errors);
    let (loop_, end) = (text.find("while(!kbhit())").unwrap(), text.find("// 伺服关闭").unwrap());
    let ran = run(&format!("{}Sleep(3600);\n{}", &text[..loop_], &text[end..])).done();
    single(&ran);
    // The example is the same motion.
    single(&run(&fs::read_to_string(example("follow_single.gts")).unwrap()).done());
}

/// Table 3-4 after 50000 pulses of the master, which is there after 1025 ms.
fn single(ran: &Ran) {
    for (ms, master, slave, velocity) in [
        (1000.0, 48_750, 0, 0.0),
        (1025.0, 50_000, 0, 0.0),
        (1425.0, 70_000, 10_000, 50.0),
        (1825.0, 90_000, 30_000, 50.0),
        (2225.0, 110_000, 40_000, 0.0),
        (2625.0, 130_000, 50_000, 50.0),
        (3425.0, 170_000, 80_000, 0.0),
    ] {
        ran.stands(ms, master, slave, velocity);
    }
}

#[test]
fn listing_3_3_names_the_c_library() {
    let Some(manual) = manual() else { return };
    let ran = run(&listing(&manual, "\n例程 3-3 Follow", "\n第4章"));
    assert!(ran.code != 0 && ran.errors.contains("`while(1)` is not available"), "{}", ran.errors);
    assert!(ran.errors.contains("C library"), "{}", ran.errors);
}

#[test]
fn the_examples_of_chapter_3() {
    let example = |name: &str| run(&fs::read_to_string(example(name)).unwrap()).done();
    // Tables 3-2 and 3-3: cuts at 5000, 15000, … of the belt.
    let shear = example("follow_shear.gts");
    for (ms, master, slave, velocity) in [
        (125.0, 5000, 2500, 50.0),
        (145.0, 6000, 3500, 50.0),
        (205.0, 9000, 5900, 30.0),
        (245.0, 11_000, 7100, 30.0),
        (305.0, 14_000, 9500, 50.0),
        (325.0, 15_000, 10_500, 50.0),
        (725.0, 35_000, 26_500, 50.0),
    ] {
        shear.stands(ms, master, slave, velocity);
    }
    assert!(shear.out.contains("fifo 1 switch_status 0") && shear.out.contains("loop = 3"), "{}", shear.out);
    // Tables 3-5 to 3-7: two passes, the transition, then the new curve at 0.6.
    let switch = example("follow_switch.gts");
    for (ms, master, slave, velocity) in [
        (1225.0, 60_000, 40_000, 0.0),
        (2425.0, 120_000, 80_000, 0.0),
        (2825.0, 140_000, 90_000, 50.0),
        (3625.0, 180_000, 126_000, 30.0),
        (4025.0, 200_000, 142_000, 50.0),
        (4825.0, 240_000, 178_000, 30.0),
    ] {
        switch.stands(ms, master, slave, velocity);
    }
    let spaces: Vec<&str> =
        switch.out.lines().filter_map(|line| Some(line.split_once("GTN_FollowSpace space = ")?.1)).collect();
    assert_eq!(spaces, ["16", "15", "14", "13", "16", "16"]);
    let shaped = example("follow_ex.gts");
    assert!(shaped.out.contains("axis 2: planned 30000.000000"), "{}", shaped.out);
    let switched = example("follow_ex_switch.gts");
    assert!(switched.out.contains("fifo 1 switch_status 0"), "{}", switched.out);
}

#[test]
fn the_examples_of_chapter_4() {
    let example = |name: &str| run(&fs::read_to_string(example(name)).unwrap()).done();
    // Listing 4-1: the points themselves; between the first two the acceleration is constant, so
    // that half their time has the mean of their velocities, 8.125, and 600·(1 + 8.125)/2. The
    // table ends at speed, and with it the motion.
    let points = example("pvt_points.gts");
    for (ms, pos, vel) in [
        (0.0, 0.0, 1.0),
        (600.0, 2737.5, 8.125),
        (1200.0, 9750.0, 15.25),
        (2000.0, 24_483.0, 20.0),
        (2500.0, 34_483.0, 20.0),
        (3000.0, 44_483.0, 20.0),
        (3800.0, 59_216.0, 15.25),
        (5000.0, 68_966.0, 0.0),
    ] {
        points.moves(1000.0 + ms, &[(pos, vel)]);
    }
    assert!(points.row(6000.0)[1].starts_with("1.00"), "the last tick before its end");
    points.says("GTN_PvtStatus tableId, t = 1/2500");
    points.says("GTN_GetPrfVel prfVel = 20");
    points.says("GTN_GetPrfPos prfPos = 34483");
    points.says("GTN_GetPrfPos prfPos = 68966");

    // Listing 4-2: 0, A/2, A, A/2, 0 with velocity 0 at both ends and, by symmetry, at the top;
    // continuous acceleration at A/2 makes its velocity 3A/2000. Halfway between two points: the
    // mean of both positions and 500/8 of the difference of their velocities. A is 40000, from 6 s
    // on 60000, from 10 s on 30000.
    let complete = example("pvt_complete.gts");
    for (ms, pos, vel) in [
        (250.0, 6250.0, 45.0),
        (500.0, 20_000.0, 60.0),
        (1000.0, 40_000.0, 0.0),
        (1500.0, 20_000.0, -60.0),
        (5000.0, 40_000.0, 0.0),
        (6000.0, 0.0, 0.0),
        (6500.0, 30_000.0, 90.0),
        (9000.0, 60_000.0, 0.0),
        (10_500.0, 15_000.0, 45.0),
        (11_000.0, 30_000.0, 0.0),
        // Key Q: (15000 + 30000)/2 + 500/8·45, and 3/2·15000/500 − 45/4.
        (12_750.0, 25_312.5, 33.75),
    ] {
        complete.moves(1000.0 + ms, &[(pos, vel)]);
    }
    complete.says("GTN_PvtStatus tableId, t = 1/500");
    complete.says("GTN_PvtStatus tableId, t = 2/500");
    complete.says("GTN_GetPrfVel prfVel = 33.75");
    complete.says("GTN_GetPrfPos prfPos = 25312.5");
    // It brakes with 1 pulse/ms²: 33.75²/2 more.
    assert!(complete.out.contains("axis 1: planned 25882.031250"), "{}", complete.out);

    // Listing 4-3, tables 4-11 and 4-13: X to and fro twice, Y three passes of 15000 from 2000 ms
    // on. Half of a ramp with 60 % has half of the change; there the acceleration, 10/(1000·0.7) at
    // its most, has been rising for 300 ms and even for 200: 65000 times that, 928.571429 pulses.
    let percent = example("pvt_percent.gts");
    for (ms, x, y) in [
        (500.0, (928.571429, 5.0), (0.0, 0.0)),
        (1000.0, (5000.0, 10.0), (0.0, 0.0)),
        (2000.0, (15_000.0, 10.0), (0.0, 0.0)),
        (2500.0, (19_071.428571, 5.0), (2500.0, 10.0)),
        (3000.0, (20_000.0, 0.0), (7500.0, 10.0)),
        (3500.0, (19_071.428571, -5.0), (12_500.0, 10.0)),
        (4000.0, (15_000.0, -10.0), (15_000.0, 0.0)),
        (5000.0, (5000.0, -10.0), (15_000.0, 0.0)),
        (6000.0, (0.0, 0.0), (22_500.0, 10.0)),
        (9000.0, (20_000.0, 0.0), (37_500.0, 10.0)),
        (11_000.0, (5000.0, -10.0), (45_000.0, 0.0)),
        (12_000.0, (0.0, 0.0), (45_000.0, 0.0)),
    ] {
        percent.moves(1000.0 + ms, &[x, y]);
    }
    percent.says("GTN_PvtPercentCalculate vel_x[0] = 0 10 10 0 -10 -10 0");
    percent.says("GTN_PvtStatus tableId[0], time[0] = 1/1000 2/4000");
    percent.says("GTN_GetPrfPos prfPos[0] = 0 45000");

    // Listing 4-4: ramps of 10/0.01 = 1000 ms and 5000 pulses, 2000 and 1000 ms at 10 between them;
    // half a ramp of 100 % is one rise of the acceleration to 0.02: 0.02·500²/6 pulses.
    let continuous = example("pvt_continuous.gts");
    for (ms, x, y) in [
        (500.0, (833.333333, 5.0), (0.0, 0.0)),
        (1000.0, (5000.0, 10.0), (0.0, 0.0)),
        (1500.0, (10_000.0, 10.0), (833.333333, 5.0)),
        (2000.0, (15_000.0, 10.0), (5000.0, 10.0)),
        (3000.0, (25_000.0, 10.0), (15_000.0, 10.0)),
        (3500.0, (29_166.666667, 5.0), (19_166.666667, 5.0)),
        (4000.0, (30_000.0, 0.0), (20_000.0, 0.0)),
    ] {
        continuous.moves(1000.0 + ms, &[x, y]);
    }
    // Both arrive in this row.
    let before = continuous.row(5000.0);
    assert!(before[1] != "0.000000" && before[3] != "0.000000", "there too early: {before:?}");
    continuous.says("GTN_PvtContinuousCalculate time_x[0] = 0 4000");
    continuous.says("GTN_PvtContinuousCalculate time_y[0] = 0 3000");
    continuous.says("GTN_GetPrfPos prfPos[0] = 30000 20000");
}

#[test]
fn masters_of_every_kind() {
    let ran = run(&fs::read_to_string(example("follow_masters.gts")).unwrap()).done();
    // Axis 5: 40 ms and 800 pulses of acceleration, then 40 pulse/ms. Axis 2 has the ratio m/2000
    // in the first half of a pass, so m²/4000 pulses; axis 1 half of it. Axis 4: t²/40, then 40
    // pulses to and fro at 2 pulse/ms.
    let up = |ms: f64| {
        let row = ran.row(ms + 0.25);
        (row[4].parse::<f64>().unwrap(), row[5].parse::<f64>().unwrap())
    };
    for (ms, two, shaken, five) in
        [(40.0, (160.0, 16.0), (40.0, 2.0), (800.0, 40.0)), (165.0, (2810.0, 36.0), (680.625, 8.25), (5800.0, 40.0))]
    {
        ran.moves(ms, &[(two.0 / 2.0, two.1 / 2.0), two, up(ms), shaken, five]);
        // The encoder is less than 2 ms behind.
        let early = (ms - 2.0) * (ms - 2.0) / 40.0;
        assert!((early / 2.0..=shaken.0 / 2.0).contains(&up(ms).0), "{:?} at {ms} ms", up(ms));
    }
    // What goes upwards only rests while its master shakes, and never goes back.
    let rested = up(405.0).0;
    assert!((1990.0..=2000.0).contains(&rested), "{rested}");
    for (ms, shaken) in [(410.0, 3980.0), (420.0, 3960.0), (430.0, 3980.0)] {
        assert_eq!(up(ms), (rested, 0.0), "at {ms} ms");
        assert_eq!(ran.row(ms + 0.25)[6].parse::<f64>().unwrap(), shaken, "at {ms} ms");
    }
    let heights = ran.rows.lines().skip(1).map(|row| row.split(',').nth(5).unwrap().parse::<f64>().unwrap());
    assert!(heights.is_sorted(), "it went back");
    assert!((rested..=2000.0).contains(&up(480.0).0));
    ran.says("GTN_GetPrfPos prfPos[0] = 2875 5750");
    ran.says("GTN_GetPrfPos prfPos[0] = 0 0");
    ran.says("GTN_GetFollowStatusEx fifo, pending = fifo 1 switch_status 0");
    ran.says("GTN_GetPrfPos prfPos[0] = 0 0 3000 8000 0");
}
