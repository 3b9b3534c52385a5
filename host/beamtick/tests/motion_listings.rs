//! Listings of the GXN manual as they stand in its text, where the manuals lie beside the checkout, and the examples
//! that were made from them: rows of their traces by hand. A start of the first instant acts on the first tick, so what
//! happens t ms after it stands in the row of t + 0.25 ms.
use assert_cmd::Command;
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples").join(name)
}

fn manual() -> Option<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/manuals");
    let found = fs::read_dir(&folder).ok().and_then(|mut files| {
        files.find_map(|file| fs::read_to_string(file.ok()?.path()).ok().filter(|text| text.contains("GTN_PtData")))
    });
    if found.is_none() {
        println!("skipped: the manuals are not beside the checkout");
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

    /// Whether axes 1 and 2 are at these whole pulses, and axis 2 has this velocity, at `ms` after the first tick.
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

/// Table 3-4 behind 50000 pulses of the master, which is there after 1025 ms.
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
