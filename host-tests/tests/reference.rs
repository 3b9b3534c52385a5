//! Random whole programs on the virtual controller beside the reference controller: see
//! `host_tests::reference`.
//!
//! `REFERENCE_PROGRAMS` sets how many programs there are, `REFERENCE_SEED` the first one's number,
//! `REFERENCE_CALLS` how many calls a program has at most, `REFERENCE_FINDINGS` how many programs
//! that differ are reported before it gives up. A finding is shrunk and printed as a job,
//! with `REFERENCE_AROUND` ticks before and after.
//! `REFERENCE_TABLE` names a file for how often each function was called.
#[path = "reference/ahead.rs"]
mod ahead;
#[path = "reference/analog.rs"]
mod analog;
#[path = "reference/focus.rs"]
mod focus;
#[path = "reference/found.rs"]
mod found;
#[path = "reference/found_light.rs"]
mod found_light;
#[path = "reference/found_paths.rs"]
mod found_paths;
#[path = "reference/found_reference.rs"]
mod found_reference;
#[path = "reference/judge.rs"]
mod judge;
#[path = "reference/machine.rs"]
mod machine;
#[path = "reference/ticks.rs"]
mod ticks;

use host_tests::reference::{Call, Family, Setup, generator};
use judge::{Tally, finding};
use machine::Rig;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Set-ups and ticks in turn.
fn setups() -> Vec<(Setup, u32)> {
    let gus = Setup { profile: "gus", family: Family::Gus, axes: vec![(1, 1), (1, 2), (1, 3), (1, 6)] };
    let lsr = Setup { family: Family::Lsr, ..gus.clone() };
    let gtn = Setup { profile: "gtn-016", family: Family::Gus, axes: vec![(1, 1), (1, 2), (2, 1), (2, 7)] };
    vec![(gus.clone(), 250), (gus.clone(), 1000), (lsr, 500), (gus, 100), (gtn, 250)]
}

/// What as many programs as run by default, and more, must have tried.
const NEEDED: &[&str] = &[
    "calls refused with 1",
    "calls refused with 7",
    "motions ended",
    "values read",
    "ticks in which a slave moves",
    "ticks in which a slave of a slave moves",
    "ticks in which a slave of a slave moves that was renamed",
    "ticks in which a slave of direction -1 moves",
    "ticks in which a slave of FollowEx moves",
    "ticks in which a slave of an encoder moves",
    "outputs set by FollowEx",
    "outputs set by paths",
    "analog outputs set by paths",
    "axes that a path sets off",
    "ticks in which an axis is geared to a path",
    "entries of lasers reached",
    "lasers switched by calls",
    "paths ended",
    "ticks of paths",
    "tick periods set between programs",
    "motions ended by a limit switch",
    "captures read",
    "why axes stopped",
    "tables of lasers set",
    "ticks in which a laser follows encoders",
];

/// The same of what takes up much of a program.
const NEEDED_SELDOM: &[&str] = &["interlocks opened", "motions that an interlock ends"];

fn number(name: &str, default: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}

#[test]
fn programs_agree_with_the_reference() {
    let (count, first) = (number("REFERENCE_PROGRAMS", 1000), number("REFERENCE_SEED", 1));
    let (most, calls) = (number("REFERENCE_FINDINGS", 1), number("REFERENCE_CALLS", 300) as usize);
    let (next, found) = (AtomicU64::new(0), AtomicU64::new(0));
    let (tallies, reports) = (Mutex::new(Tally::new()), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                let setups = setups();
                let mut rigs: Vec<Option<Rig>> = setups.iter().map(|_| None).collect();
                let mut tally = Tally::new();
                loop {
                    let number = next.fetch_add(1, Relaxed);
                    if number >= count || found.load(Relaxed) >= most {
                        break;
                    }
                    let seed = first + number;
                    let kind = (seed % setups.len() as u64) as usize;
                    let (setup, tick_us) = &setups[kind];
                    let program = generator::program(seed, setup, calls);
                    let rig = &mut rigs[kind];
                    if let Some(report) = finding(rig, setup, *tick_us, &program.calls, &mut tally) {
                        found.fetch_add(1, Relaxed);
                        println!("program {seed}: {report}");
                        reports.lock().unwrap().push((number + 1, format!("program {seed}: {report}")));
                    }
                }
                let mut all = tallies.lock().unwrap();
                for (rule, count) in tally {
                    *all.entry(rule).or_default() += count;
                }
            });
        }
    });
    let (tally, mut reports) = (tallies.into_inner().unwrap(), reports.into_inner().unwrap());
    reports.sort();
    let done = next.load(Relaxed).min(count);
    println!("{done} programs, {} differ", reports.len());
    for (rule, count) in &tally {
        println!("{count:>9} {rule}");
    }
    if let Some(path) = std::env::var_os("REFERENCE_TABLE") {
        let row = |(what, tried): (&String, &u64)| {
            let name = what.strip_prefix("tried ")?;
            Some(format!("{name} {tried} {}\n", tally[&format!("done {name}")]))
        };
        std::fs::write(path, tally.iter().filter_map(row).collect::<String>()).unwrap();
    }
    let tried = |what: &str| tally.get(what).copied().unwrap_or(0);
    if reports.is_empty() && done >= 1000 {
        // So that the generator cannot rot unseen.
        for what in NEEDED {
            assert!(tried(what) >= 100, "{what}: {}", tried(what));
        }
        for what in NEEDED_SELDOM {
            assert!(tried(what) >= 20, "{what}: {}", tried(what));
        }
        let open: u64 = tally.iter().filter(|(what, _)| what.starts_with("cut short")).map(|(_, count)| count).sum();
        assert!(open * 2 < done, "{open} of {done} programs were cut short");
    }
    let reported: String =
        reports.iter().map(|(after, report)| format!("found after {after} programs: {report}\n")).collect();
    assert!(reports.is_empty(), "{} of {done} programs differ:\n{reported}", reports.len());
}

/// Paths with look-ahead, by what holds for every plan.
#[test]
fn look_ahead_keeps_its_rules() {
    let (first, count) = (number("REFERENCE_SEED", 1), number("REFERENCE_AHEAD", 300));
    let tally = ahead::run(first, count);
    for (what, count) in &tally {
        println!("{count:>9} {what}");
    }
    if count >= 300 {
        for what in
            ["paths", "motions", "accelerations within motions", "corners", "middles", "rests", "outputs at vertices"]
        {
            let tried = tally.get(what).copied().unwrap_or(0);
            assert!(tried >= 50, "{what}: {tried}");
        }
    }
}

struct Nowhere;

impl job::Files for Nowhere {
    fn text(&self, path: &str) -> Result<String, String> {
        Err(format!("{path}: a test has no files"))
    }
}

/// A finding is printed as a job, which must be one.
#[test]
fn listings_of_findings_are_jobs() {
    for seed in 0..40 {
        let (setup, tick_us) = &setups()[seed as usize % setups().len()];
        let program = generator::program(seed, setup, 200);
        let text = setup.job(*tick_us, program.calls.iter());
        let job = job::compile(&text, &Nowhere).unwrap_or_else(|found| panic!("program {seed}: {found:?}\n{text}"));
        let wanted = program.calls.iter().filter(|call| !matches!(call, Call::SetTick { .. })).count();
        assert!(job.steps.len() >= wanted, "program {seed}: {} of {wanted}", job.steps.len());
    }
}
