//! The same program through every door: as a job, in C, in Python, and as records on the wire; all
//! four must give the same codes, values and trace.
//!
//! The controller's time passes in calls of C and Python, and not in those of a job. So each call
//! is followed by a pause, what a call gives may not depend on when it is made, and traces are
//! compared without the rows in which nothing changes.

mod chosen;
mod lengths;
mod listing;
mod player;
mod program;
mod random;
mod rules;
mod text;
#[path = "../../../gts/tests/toolchain/mod.rs"]
mod toolchain;
mod wire;

use job::api::{FUNCTIONS, Pass, Shape, Type};
use program::{Call, Step, Value, is_timeless, read};
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

/// The doors, in the order of the table.
const DOORS: [&str; 4] = ["job", "C", "Python", "wire"];
const FAMILIES: [&str; 2] = ["gus", "lsr"];

/// What a call gave.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Answer {
    code: i32,
    reason: String,
    values: Vec<f64>,
}

/// A trace without the rows that are like the one before.
pub struct Trace {
    names: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Trace {
    /// Reads a CSV.
    pub fn read(path: &Path) -> Trace {
        let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let mut lines = text.lines();
        let names = lines.next().expect("a header").split(',').skip(1).map(str::to_owned).collect();
        let rows = lines.map(|line| line.split(',').skip(1).map(str::to_owned).collect()).collect();
        let _ = std::fs::remove_file(path);
        Trace { names, rows }
    }

    /// The columns of these names, without repetitions.
    fn columns(&self, names: &[String]) -> Vec<Vec<&str>> {
        let places: Vec<usize> =
            names.iter().map(|name| self.names.iter().position(|own| own == name).unwrap()).collect();
        let mut rows: Vec<Vec<&str>> =
            self.rows.iter().map(|row| places.iter().map(|place| row[*place].as_str()).collect()).collect();
        rows.dedup();
        rows
    }
}

/// What a door gave: an answer for each step, and a trace.
pub struct Run {
    answers: Vec<Answer>,
    trace: Trace,
}

/// How often a function was called through each door, and how often it was done.
#[derive(Default)]
struct Table(BTreeMap<&'static str, [(u32, u32); 4]>);

impl Table {
    fn count(&mut self, door: usize, steps: &[Step], run: &Run) {
        steps.iter().zip(&run.answers).for_each(|(step, answer)| self.note(door, step, answer.code));
    }

    fn note(&mut self, door: usize, step: &Step, code: i32) {
        if let Step::Call(call) = step {
            self.note_name(door, call.function.name, code);
            if code != 0 {
                // How a door says why.
                self.note_name(door, "GetLastReason", 0);
            }
        }
    }

    fn note_name(&mut self, door: usize, name: &'static str, code: i32) {
        let row = self.0.entry(name).or_default();
        row[door].0 += 1;
        row[door].1 += u32::from(code == 0);
    }

    /// Each door opens and closes for a program; a job has its tick from a pragma, or from
    /// `--tick-us`.
    fn note_session(&mut self) {
        for door in 0..DOORS.len() {
            self.note_name(door, "Open", 0);
            self.note_name(door, "Close", 0);
        }
        self.note_name(0, "SetTick", 0);
    }

    /// Adds the counts to the file that `DOORS_TABLE` names, for `cargo xtask doors`.
    fn publish(&self) {
        let Some(path) = std::env::var_os("DOORS_TABLE") else { return };
        let row = |(name, row): (&&str, &[(u32, u32); 4])| {
            format!("{name} {}\n", row.map(|(calls, done)| format!("{calls} {done}")).join(" "))
        };
        let text: String = self.0.iter().map(row).collect();
        let mut file = std::fs::OpenOptions::new().append(true).create(true).open(path).unwrap();
        file.write_all(text.as_bytes()).unwrap();
    }
}

/// What cannot be an entry of a program: `--tick-us` sets the tick of a job.
const NOT_IN_JOBS: [&str; 1] = ["SetTick"];

/// Runs a program through every door and reports what differs; nothing where a door is not here.
fn compare(name: &str, family: &str, steps: &[Step], table: &mut Table) -> Vec<String> {
    let (wire, all) = wire::wire(name, family, steps);
    let Some(c) = text::c(name, family, steps) else { return Vec::new() };
    let Some(python) = text::python(name, family, steps) else { return Vec::new() };
    let job = text::job(name, family, steps);
    let runs = [&job, &c, &python, &wire];
    runs.iter().enumerate().for_each(|(door, run)| table.count(door, steps, run));
    table.note_session();
    let mut differences = Vec::new();
    for (number, step) in steps.iter().enumerate() {
        let Step::Call(call) = step else { continue };
        let codes: Vec<i32> = runs.iter().map(|run| run.answers[number].code).collect();
        let first = usize::from(NOT_IN_JOBS.contains(&call.function.name));
        if codes[first..].iter().any(|code| *code != codes[3]) {
            let reasons: Vec<&str> = runs.iter().map(|run| run.answers[number].reason.as_str()).collect();
            differences.push(format!("step {number}: {}: codes {DOORS:?} {codes:?} {reasons:?}", shown(call)));
            continue;
        }
        if !is_timeless(call.function) {
            continue;
        }
        // On the wire nothing stands for axes that are not there; every other door says 0 for them.
        let missing = match call.function.has("count") {
            true => runs[1].answers[number].values.len().saturating_sub(wire.answers[number].values.len()),
            false => 0,
        };
        let padded = |values: &[f64]| [values, &vec![0.0; missing]].concat();
        let wired = padded(&wire.answers[number].values);
        // Structs are shown by jobs and on the wire alone.
        let filled = call.function.params.iter().any(|param| matches!(param.pass, Pass::Out));
        if filled {
            for door in [1, 2] {
                if runs[door].answers[number].values != wired {
                    let values = [&runs[door].answers[number].values, &wired];
                    differences.push(format!("step {number}: {}: {}, wire {values:?}", shown(call), DOORS[door]));
                }
            }
        }
        let shows = filled || call.function.params.iter().any(|param| matches!(param.pass, Pass::OutStruct(_)));
        let job_values = &job.answers[number].values;
        // What a job shows ends with what the reply ends with: the clock and the count before it
        // are not shown. Among the values of GetCaptureStatus is a clock.
        let timed = call.function.name == "GetCaptureStatus";
        // Of what a reply of many fields says, these show one.
        let reply = if call.function.reports_stop() { &wire.answers[number].values } else { &all[number] };
        if shows && !timed && codes[0] == 0 && !padded(reply).ends_with(job_values) {
            differences.push(format!("step {number}: {}: job {job_values:?}, wire {reply:?}", shown(call)));
        }
    }
    let names: Vec<String> =
        job.trace.names.iter().filter(|name| runs.iter().all(|run| run.trace.names.contains(name))).cloned().collect();
    let rows: Vec<_> = runs.iter().map(|run| run.trace.columns(&names)).collect();
    for (door, other) in DOORS.iter().zip(&rows) {
        let first = other.iter().zip(&rows[3]).position(|(row, wire)| row != wire);
        if first.is_some() || other.len() != rows[3].len() {
            let at = first.unwrap_or(other.len().min(rows[3].len()));
            let around = |length: usize| at.saturating_sub(1).min(length)..length.min(at + 2);
            differences.push(format!(
                "the trace: {door} has {} rows that differ, the wire {}; row {at} of {names:?}: {:?} and {:?}",
                other.len(),
                rows[3].len(),
                &other[around(other.len())],
                &rows[3][around(rows[3].len())]
            ));
        }
    }
    differences.into_iter().map(|text| format!("{name}, {family}: {text}")).collect()
}

fn shown(call: &Call) -> String {
    let text = format!("{} {:?}", call.function.name, call.values);
    text.chars().take(160).collect()
}

/// The programs: every function with its documented effect.
const PROGRAMS: [(&str, &str); 7] = [
    ("session", include_str!("session.txt")),
    ("moves", include_str!("moves.txt")),
    ("tables", include_str!("tables.txt")),
    ("follow", include_str!("follow.txt")),
    ("gear", include_str!("gear.txt")),
    ("lasers", include_str!("lasers.txt")),
    ("paths", include_str!("paths.txt")),
];

fn calls() -> Vec<Call> {
    let steps = PROGRAMS.iter().flat_map(|(_, text)| read(text));
    steps.filter_map(|step| if let Step::Call(call) = step { Some(call) } else { None }).collect()
}

/// Functions that have a request.
fn functions() -> impl Iterator<Item = &'static str> {
    FUNCTIONS.iter().filter(|function| function.shape != Shape::Host).map(|function| function.name)
}

/// Every function of the API has a row in docs/doors.md, and every door of it a number.
#[test]
fn the_page_of_doors_has_every_function_and_no_empty_cell() {
    let page = std::fs::read_to_string(text::root().join("docs/doors.md")).unwrap();
    let rows = page.lines().filter_map(|line| line.strip_prefix("| `")?.split_once("` | "));
    let rows: BTreeMap<&str, Vec<&str>> = rows.map(|(name, rest)| (name, rest.split('|').collect())).collect();
    let missing: Vec<&str> =
        FUNCTIONS.iter().map(|function| function.name).filter(|name| !rows.contains_key(name)).collect();
    assert!(missing.is_empty(), "no row of {missing:?}; `cargo xtask doors` writes the page");
    let unknown: Vec<&&str> = rows.keys().filter(|name| job::api::function(name).is_none()).collect();
    assert!(unknown.is_empty(), "rows of no function: {unknown:?}");
    for (name, cells) in &rows {
        let doors = &cells[..DOORS.len()];
        let tried = |cell: &str| {
            let numbers: Vec<u64> = cell.split(',').filter_map(|number| number.trim().parse().ok()).collect();
            matches!(numbers[..], [calls, done] if calls > 0 && done > 0)
        };
        assert!(doors.iter().all(|cell| tried(cell)), "{name}: {doors:?}");
        assert!(!cells[DOORS.len()].trim().is_empty(), "{name}: nothing checks what it does");
    }
}

#[test]
fn one_program_is_the_same_through_every_door() {
    let (mut table, mut differences) = (Table::default(), Vec::new());
    for family in FAMILIES {
        for (name, text) in PROGRAMS {
            differences.extend(compare(name, family, &read(text), &mut table));
        }
    }
    assert!(differences.is_empty(), "{}", differences.join("\n"));
    if table.0.is_empty() {
        return;
    }
    table.publish();
    println!("| function | {} |", DOORS.map(|door| format!("{door}: calls, done")).join(" | "));
    for name in functions() {
        let row = table.0.get(name).unwrap_or_else(|| panic!("{name} is called by no program"));
        println!("| {name} | {} |", row.map(|(calls, done)| format!("{calls}, {done}")).join(" | "));
        for (door, (calls, done)) in DOORS.iter().zip(row) {
            let refused = *door == "job" && NOT_IN_JOBS.contains(&name);
            assert!(*calls > 0 && (*done > 0 || refused), "{name} is never done through {door}");
        }
    }
}

/// Every function with each of its integers at the ends of its type, and with axes, channels and
/// FIFOs that nobody has.
#[test]
fn every_integer_at_its_ends_is_the_same_through_every_door() {
    let mut table = Table::default();
    let mut seen = Vec::new();
    let mut steps = Vec::new();
    // A tick is as long as it is asked for, and the time of all doors with it; and who says that
    // silence may last 1 ms has lost the link at the next pause.
    for call in calls().iter().filter(|call| !["SetTick", "SetLinkLoss", "LoadConfig"].contains(&call.function.name)) {
        if seen.contains(&call.function.name) {
            continue;
        }
        seen.push(call.function.name);
        for (place, param) in call.function.params.iter().enumerate() {
            let ends: &[i64] = match param.pass {
                // A count is a length, and so is the room of a text, which Python makes itself.
                Pass::In(_) if ["count", "size"].contains(&param.name) => &[],
                Pass::In(Type::Short) => &[i16::MIN as i64, -1, 0, 1, 2, 8, 9, i16::MAX as i64],
                Pass::In(Type::UShort) => &[0, 1, 2, 17, u16::MAX as i64],
                Pass::In(Type::Long) => &[i32::MIN as i64, -1, 0, 1, i32::MAX as i64],
                Pass::In(Type::ULong) => &[0, 1, u16::MAX as i64],
                _ => &[],
            };
            for end in ends {
                steps.push(Step::Call(call.with(place, Value::Number(end.to_string()))));
            }
        }
    }
    assert!(steps.len() > 900, "{}", steps.len());
    // Every door ends with it.
    let end = read("Abort");
    let parts = steps.chunks(400).enumerate();
    let differences: Vec<String> = parts
        .flat_map(|(number, part)| compare(&format!("ends{number}"), "gus", &[part, &end].concat(), &mut table))
        .collect();
    assert!(differences.is_empty(), "{}", differences.join("\n"));
    table.publish();
}
