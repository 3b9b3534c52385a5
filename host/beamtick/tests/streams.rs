//! Data of any length: a data call of a job that finds its FIFO full waits for room, if its motion
//! runs (SPEC 7).
use std::fs;
use std::path::Path;
use std::process::Command;

/// Runs a job in the virtual controller: what it prints, its code, its trace.
fn sim(folder: &Path, text: &str, words: &[&str]) -> (String, i32, Vec<Vec<f64>>) {
    let (job, trace) = (folder.join("j.gts"), folder.join("t.csv"));
    fs::write(&job, text).unwrap();
    let _ = fs::remove_file(&trace);
    let out = Command::new(env!("CARGO_BIN_EXE_beamtick"))
        .arg("sim")
        .arg(&job)
        .arg("--trace")
        .arg(&trace)
        .args(words)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&out.stdout).into_owned() + &String::from_utf8_lossy(&out.stderr);
    let cut_off = trace.with_extension("csv.partial");
    let rows = fs::read_to_string(&trace).or_else(|_| fs::read_to_string(cut_off)).unwrap_or_default();
    let number = |cell: &str| cell.parse().unwrap();
    let rows = rows.lines().skip(1).map(|row| row.split(',').map(number).collect()).collect();
    (said, out.status.code().unwrap(), rows)
}

const SET_UP: &str = "#pragma profile gus
TCrdPrm prm; memset(&prm, 0, sizeof(prm));
GT_AxisOn(1); GT_AxisOn(2);
prm.dimension = 2; prm.profile[0] = 1; prm.profile[1] = 2; prm.synVelMax = 400; prm.synAccMax = 10;
GT_SetCrdPrm(1, &prm);
";

/// Lines along a straight one, 20 pulses each, from `from` on, with the speed kept from line to
/// line.
fn lines(from: usize, count: usize, fifo: usize) -> String {
    (from + 1..=from + count).map(|k| format!("GT_LnXY(1, {}, {}, 100, 10, 100, {fifo});\n", 16 * k, 12 * k)).collect()
}

/// Speed of the path in all rows: it rises once, stays, and falls once.
fn is_one_motion(rows: &[Vec<f64>]) {
    let speed = |row: &Vec<f64>| row[2].hypot(row[4]);
    let top = rows.iter().map(speed).fold(0.0, f64::max);
    let first = rows.iter().position(|row| speed(row) > top - 0.01).unwrap();
    let last = rows.iter().rposition(|row| speed(row) > top - 0.01).unwrap();
    assert!((top - 100.0).abs() < 0.01 && last - first > 100, "{top} from {first} to {last}");
    let slow = rows[first..=last].iter().find(|row| speed(row) < 99.9);
    assert!(slow.is_none(), "{slow:?}");
}

#[test]
fn a_path_of_any_length_is_one_motion() {
    let folder = tempfile::tempdir().unwrap();
    for (look, tick) in [("", "250"), ("", "50"), ("GT_InitLookAhead(1, 0, 2, 10, 200);\n", "250")] {
        let flush = if look.is_empty() { "" } else { "GT_CrdData(1, NULL, 0);\n" };
        let count = 20_000;
        let end = format!("GT_LnXY(1, {}, {}, 100, 10, 0, 0);\n", 16 * (count + 1), 12 * (count + 1));
        let text = [
            SET_UP,
            look,
            &lines(0, 500, 0),
            "GT_CrdStart(1, 0);\n",
            &lines(500, count - 500, 0),
            &end,
            flush,
            "WaitStop(1, 0, 1);\nSleep(5);\n",
        ]
        .concat();
        let (said, code, rows) = sim(folder.path(), &text, &["--tick-us", tick, "--strict"]);
        assert_eq!(code, 0, "{tick}: {said}");
        assert!(said.contains("no late entries") && said.contains("20001 segments"), "{tick}: {said}");
        is_one_motion(&rows);
        let last = rows.last().unwrap();
        assert_eq!((last[1], last[3]), (320_016.0, 240_012.0), "{tick}");
    }
}

/// What follows the data in the job acts after it, at its time on the clock that the wait has
/// moved.
#[test]
fn the_script_clock_goes_on_from_the_wait() {
    let folder = tempfile::tempdir().unwrap();
    let text = [
        SET_UP,
        "GT_SetDoBit(12, 1, 1);\n",
        &lines(0, 900, 0),
        "GT_CrdStart(1, 0);\n",
        &lines(900, 3_000, 0),
        "GT_SetDoBit(12, 1, 0);\nSleep(7);\nGT_SetDoBit(12, 1, 1);\nWaitStop(1, 0, 1);\n",
    ]
    .concat();
    let vcd = folder.path().join("o.vcd");
    let (said, code, _) = sim(folder.path(), &text, &["--strict", "--vcd", vcd.to_str().unwrap()]);
    assert_eq!(code, 0, "{said}");
    let text = fs::read_to_string(vcd).unwrap();
    let name = text.lines().find(|line| line.contains(" do1 ")).unwrap().split(' ').nth(3).unwrap().to_owned();
    let (mut now, mut changes) = (0u64, Vec::new());
    for line in text.lines() {
        if let Some(at) = line.strip_prefix('#') {
            now = at.parse().unwrap();
        } else if line.get(1..) == Some(&name) {
            changes.push((now, line.starts_with('1')));
        }
    }
    let [.., (off, false), (on, true)] = changes[..] else { panic!("{changes:?}") };
    assert_eq!(on - off, 7_000_000);
    // 3,900 lines of 0.2 ms, of which 1,024 fit at once.
    assert!((500_000_000..780_000_000).contains(&off), "{off}");
}

#[test]
fn a_stream_of_any_length_keeps_its_times() {
    let folder = tempfile::tempdir().unwrap();
    for (memory, count) in [(0, 3_000i64), (1, 10_000)] {
        let mut text = format!("#pragma profile gus\nGT_AxisOn(1);\nGT_PrfPt(1, 1);\nGT_SetPtMemory(1, {memory});\n");
        // Constant acceleration, then constant speed, then a stop: 10 ms a segment.
        for k in 1..=count {
            let kind = if k == count { 2 } else { 1 };
            text += &format!("GT_PtData(1, {}, {}, {kind});\n", 50 * k, 10 * k);
            if k == 40 {
                text += "GT_PtStart(1);\n";
            }
        }
        text += "WaitStop(1);\n";
        let (said, code, rows) = sim(folder.path(), &text, &["--strict"]);
        assert_eq!(code, 0, "{memory}: {said}");
        assert!(said.contains("no late entries") && !said.contains("underrun"), "{memory}: {said}");
        for row in &rows {
            let at = row[0] - 0.25;
            if at > 0.0 && at < 10.0 * (count - 1) as f64 {
                assert!((row[1] - 5.0 * at).abs() < 1e-5, "{memory}: {row:?}");
            }
        }
    }
}

/// Nothing will ever make room: refused at once, with the reason.
#[test]
fn a_full_fifo_that_nothing_empties_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let pt = "#pragma profile gus\nGT_AxisOn(1);\nGT_PrfPt(1);\n";
    let path = |start: &str, more: &str| [SET_UP, &lines(0, 1_024, 0), start, more].concat();
    let cases = [
        ("never started", path("", &lines(1_024, 1, 0))),
        (
            "the other FIFO runs",
            [SET_UP, &lines(0, 1_024, 0), &lines(0, 9, 1), "GT_CrdStart(1, 1);\n", &lines(1_024, 1, 0)].concat(),
        ),
        (
            "stopped",
            path("GT_CrdStart(1, 0);\nSleep(3);\nGT_Stop(256, 256);\nWaitStop(1, 0, 1);\n", &lines(1_024, 600, 0)),
        ),
        (
            "a static FIFO keeps its data",
            (1..=33).fold(pt.to_owned(), |job, k| job + &format!("GT_PtData(1, {k}, {k});\n")),
        ),
    ];
    for (what, text) in cases {
        let (said, code, _) = sim(folder.path(), &text, &[]);
        assert!(code == 1 && said.contains("the FIFO is full"), "{what}: {code} {said}");
    }
}

/// The motion that would make room ends meanwhile: the wait ends with it, and the reason is
/// reported.
#[test]
fn a_wait_ends_with_its_motion() {
    let folder = tempfile::tempdir().unwrap();
    let limit = "GT_SetSoftLimit(1, 9000, -9000);\n";
    let text = [SET_UP, limit, &lines(0, 1_024, 0), "GT_CrdStart(1, 0);\n", &lines(1_024, 9_000, 0)].concat();
    let (said, code, rows) = sim(folder.path(), &text, &[]);
    assert!(code == 1 && said.contains("the FIFO is full"), "{code} {said}");
    assert!(rows.last().unwrap()[1] <= 9000.0, "{:?}", rows.last());
}

/// A job that goes on after refusals waits as well.
#[test]
fn a_job_that_goes_on_after_refusals_waits_too() {
    let folder = tempfile::tempdir().unwrap();
    let assigned = |text: String| text.replace("GT_LnXY", "rtn = GT_LnXY");
    let text = [
        "#pragma continue\nshort rtn;\n",
        SET_UP,
        &assigned(lines(0, 1_000, 0)),
        "GT_CrdStart(1, 0);\n",
        &assigned(lines(1_000, 4_000, 0)),
        "WaitStop(1, 0, 1);\n",
    ]
    .concat();
    let (said, code, _) = sim(folder.path(), &text, &["--strict"]);
    assert_eq!(code, 0, "{said}");
    assert!(said.contains("5000 segments") && said.contains("no late entries"), "{said}");
}
