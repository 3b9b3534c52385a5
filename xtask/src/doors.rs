//! The page of doors: how often each function of the API was called through each door and beside
//! the reference controller, and what checks it.
//!
//! In: what the tests of the doors and of the reference count. Out: `docs/doors.md`. Fails: if a
//! test does, or if no check is named for a function that the reference does not have.
use crate::shell::{self, Outcome, cargo, root, target};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Random programs.
const PROGRAMS: &str = "200";
/// Random programs with the reference controller.
const REFERENCE: &str = "1000";

/// What checks a function that the reference does not have, by the start of its name; the first
/// match.
const CHECKS: &[(&str, &str)] = &[
    ("GetLaserOnTime", "laser model (`laser_random`)"),
    ("ZeroLaserOnTime", "laser model (`laser_random`)"),
    ("SetLaserDis", "model of light on a path (`light_random`)"),
    ("BufLaser", "model of light on a path (`light_random`), judge of light (`light_judge`)"),
    ("SetLaserFollowTable", "model of light on a path (`light_random`)"),
    ("SetLaserCrdMap", "judge of light (`light_judge`)"),
    ("GetLaserCrdMap", "judge of light (`light_judge`)"),
    ("GetLaserFault", "judge of light (`light_judge`)"),
    ("ClrLaserFault", "judge of light (`light_judge`)"),
    ("LaserO", "judge of light (`light_judge`), laser model (`laser_random`)"),
    ("Laser", "laser model (`laser_random`), table of rules (`laser_rules`)"),
    ("GetHSIOOpt", "judge of light (`light_judge`)"),
    ("SetHSIOOpt", "judge of light (`light_judge`)"),
    ("SetPulseWidth", "laser model (`laser_random`)"),
    ("SetWaitPulse", "laser model (`laser_random`), table of rules (`laser_rules`)"),
    ("SetPreVltg", "laser model (`laser_random`)"),
    ("SetLevelDelay", "laser model (`laser_random`)"),
    ("EnaFPK", "laser model (`laser_random`)"),
    ("DisFPK", "laser model (`laser_random`)"),
    ("SetLaserMode", "table of rules (`laser_rules`)"),
    ("SetAxisMode", "table of rules (`laser_rules`)"),
    ("GetLaserPower", "model of light on a path (`light_random`)"),
    ("Follow", "exact chains of `follow_ex`"),
    ("PrfFollowEx", "exact chains of `follow_ex`"),
    ("SetFollow", "exact chains of `follow_ex`, `dispatcher/tests/follow.rs`"),
    ("GetFollow", "`dispatcher/tests/follow.rs`"),
    ("PrfGear", "closed form (`servo/tests/gear_exact.rs`)"),
    ("SetGear", "closed form (`servo/tests/gear_exact.rs`)"),
    ("GearStart", "closed form (`servo/tests/gear_exact.rs`)"),
    ("InitLookAhead", "`look_ahead`, with exact arithmetic"),
    ("CrdData", "`look_ahead`, with exact arithmetic"),
    ("Crd", "exact model of paths (`path_rules`)"),
    ("SetCrd", "exact model of paths (`path_rules`)"),
    ("GetCrd", "exact model of paths (`path_rules`)"),
    ("GetRemainder", "exact model of paths (`path_rules`)"),
    ("SetOverride", "exact model of paths (`path_rules`)"),
    ("Ln", "exact model of paths (`path_edges`)"),
    ("Arc", "exact model of paths (`path_edges`)"),
    ("BufD", "exact model of paths (`path_edges`)"),
    ("BufI", "exact model of paths (`path_edges`)"),
    ("BufMove", "exact model of paths (`path_pairs`)"),
    ("BufGear", "exact model of paths (`path_pairs`)"),
    ("PvtPercentCalculate", "`dispatcher/tests/pvt.rs`"),
    ("PvtContinuousCalculate", "programs of `host/gts/tests`"),
    ("GetDac", "the machine's outputs, in the random doors"),
    ("GetDo", "the machine's outputs, in the random doors"),
    ("SetDac", "the machine's outputs, in the random doors"),
    ("SetDo", "the machine's outputs, in the random doors"),
    ("", "tests of `dispatcher`, `servo` and `host/gts`"),
];

/// Names and numbers of a file that tests wrote, those of one name added up.
fn counts(path: &Path) -> Outcome<BTreeMap<String, Vec<u64>>> {
    let text = fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
    let mut sums: BTreeMap<String, Vec<u64>> = BTreeMap::new();
    for line in text.lines() {
        let mut words = line.split(' ');
        let name = words.next().unwrap_or_default().to_owned();
        let numbers: Vec<u64> = words.filter_map(|word| word.parse().ok()).collect();
        let sum = sums.entry(name).or_insert_with(|| vec![0; numbers.len()]);
        sum.iter_mut().zip(numbers).for_each(|(sum, number)| *sum += number);
    }
    Ok(sums)
}

/// Runs the tests and writes the page.
pub fn write() -> Outcome {
    let folder = target().join("doors");
    fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let (doors, reference) = (folder.join("doors.txt"), folder.join("reference.txt"));
    let _ = fs::remove_file(&doors);
    let skip = ["--skip", "the_page_of_doors"];
    let test = ["test", "-p", "beamtick", "--test", "doors", "--"];
    shell::run(cargo().args(test).args(skip).env("DOORS_TABLE", &doors).env("DOORS_PROGRAMS", PROGRAMS))?;
    let test = ["test", "-p", "beamtick-host-tests", "--test", "reference", "programs_agree"];
    shell::run(cargo().args(test).env("REFERENCE_TABLE", &reference).env("REFERENCE_PROGRAMS", REFERENCE))?;
    page()
}

/// Writes the page from what the tests counted last.
pub fn page() -> Outcome {
    let folder = target().join("doors");
    let page = root().join("docs/doors.md");
    let (doors, reference) = (counts(&folder.join("doors.txt"))?, counts(&folder.join("reference.txt"))?);
    let mut text = String::from(HEAD);
    for (name, row) in &doors {
        let pairs: Vec<String> = row.chunks(2).map(|pair| format!("{}, {}", pair[0], pair[1])).collect();
        let checks = || CHECKS.iter().find(|(begin, _)| name.starts_with(begin)).map_or("", |(_, what)| what);
        let checked = match reference.get(name) {
            Some(pair) if pair[0] > 0 => format!("reference: {}, {}", pair[0], pair[1]),
            _ => checks().to_owned(),
        };
        text += &format!("| `{name}` | {} | {checked} |\n", pairs.join(" | "));
    }
    fs::write(&page, text).map_err(|e| format!("{}: {e}", page.display()))?;
    println!("{}: {} functions", page.display(), doors.len());
    Ok(())
}

const HEAD: &str = "\
# Doors

For readers who want to know which calls were tested. `cargo xtask doors` writes this page. It runs the tests of the
doors with 200 random programs, and those of the reference controller with 1,000. The test
`the_page_of_doors_has_every_function_and_no_empty_cell` checks that every function of the API has a row and every door a
number.

A cell has two numbers: the calls, and those that were executed (returned 0). All doors make the same calls, with one
exception: a job leaves out data for a full FIFO, since it would wait there. `Open` and `Close` are the sessions.
`GetLastReason` is how a door gets the reason, and `SetTick` in a job is its `#pragma tick`.

The last column says what checks the effect of a function. A number is how often it was called in comparison with the
reference controller, in exact arithmetic. The others name a model or tests.

| function | job | C | Python | records | checked by |
| --- | --- | --- | --- | --- | --- |
";
