//! Random programs through every door: the same codes, values and trace, tick by tick.
//!
//! `DOORS_PROGRAMS` sets how many, `DOORS_SEED` the first one's number, `DOORS_CALLS` how many
//! calls of the reference's generator a program has at most. C makes its calls one after the other
//! and tells the tick of each; the other doors make them at the same ticks. So what is read while
//! something moves is compared as well, and traces row by row with their times.

use crate::chosen::programme;
use crate::player::{self, Programme, Reported};
use crate::program::{Call, Step, is_timeless};
use crate::{DOORS, Table, rules, text, toolchain, wire};
use job::api::Pass;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Programs of a process.
const BATCH_PROGRAMS: u64 = 6;
/// Rows before the end of the shortest trace that are not compared: how each door ends is its own.
const END_ROWS: usize = 60;

/// A job decides about a call when it prepares the call's instant, and another door when the call
/// comes. Where a motion or a piece of its data ends in that very tick, they may differ: so often a
/// program is tried with a ms more before the call that was answered otherwise.
const TIES: usize = 3;

/// What waits for room in a job and is refused elsewhere (SPEC 7).
fn waits_in_jobs(call: &Call) -> bool {
    let name = call.function.name;
    ["PtData", "FollowData", "Ln", "Arc", "Buf", "CrdData", "FollowDoBitEx", "FollowDelayEx", "FollowDiBitEx"]
        .iter()
        .any(|begin| name.starts_with(begin))
}

/// A trace with its times.
struct Rows {
    names: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Rows {
    fn read(path: &Path) -> Result<Rows, String> {
        let text = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
        let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned).collect());
        let names = lines.next().ok_or("an empty trace")?;
        let _ = std::fs::remove_file(path);
        Ok(Rows { names, rows: lines.collect() })
    }

    /// From the row before the first change on: ns since then, and the values of these columns.
    fn since_change<'a>(&'a self, names: &[String]) -> Vec<(i64, Vec<&'a str>)> {
        let places: Vec<usize> =
            names.iter().map(|name| self.names.iter().position(|own| own == name).unwrap()).collect();
        let values = |row: &'a Vec<String>| places.iter().map(|place| row[*place].as_str()).collect::<Vec<_>>();
        let ns = |row: &[String]| -> i64 { (row[0].parse::<f64>().unwrap() * 1e6).round() as i64 };
        let changed = self.rows.iter().position(|row| values(row) != values(&self.rows[0])).unwrap_or(self.rows.len());
        let rows = &self.rows[changed.saturating_sub(1)..];
        rows.iter().map(|row| (ns(row) - ns(&rows[0]), values(row))).collect()
    }
}

/// What differs between the doors, the first of it.
struct Run {
    reported: [Vec<Reported>; 4],
    /// All values of the wire's replies.
    all: Vec<Vec<f64>>,
    left_out: Vec<usize>,
}

fn shown(call: &Call) -> String {
    format!("{} {:?} {:?}", call.function.name, call.core, call.values).chars().take(200).collect()
}

/// The first step at which the doors differ, and how.
fn answers(programme: &Programme, run: &Run) -> Option<(usize, String)> {
    let [job, c, python, wire] = &run.reported;
    for (number, step) in programme.steps.iter().enumerate() {
        if c[number].tick != python[number].tick {
            return Some((
                number,
                format!("step {number}: tick {} in C, {} in Python", c[number].tick, python[number].tick),
            ));
        }
        let Step::Call(call) = step else { continue };
        let door = |reported: &[Reported]| (reported[number].code, reported[number].reason.clone());
        let mut codes = vec![door(c), door(python), door(wire)];
        if !run.left_out.contains(&number) {
            codes.push(door(job));
        }
        if codes.iter().any(|(code, _)| *code != codes[0].0) {
            return Some((number, format!("step {number}: {}: codes of C, Python, wire, job: {codes:?}", shown(call))));
        }
        if c[number].code != 0 || !is_timeless(call.function) {
            continue;
        }
        // On the wire nothing stands for axes and coordinates that are not there; every other door
        // says 0 for them.
        let mut wired = wire[number].values.clone();
        let several = call.function.has("count") || call.function.name == "GetCrdPos";
        let missing = if several { c[number].values.len().saturating_sub(wired.len()) } else { 0 };
        wired.resize(wired.len() + missing, 0.0);
        let filled = call.function.params.iter().any(|param| matches!(param.pass, Pass::Out));
        let shows = filled || call.function.params.iter().any(|param| matches!(param.pass, Pass::OutStruct(_)));
        let timed = call.function.name == "GetCaptureStatus";
        if filled && (c[number].values != wired || python[number].values != wired) {
            let values = [&c[number].values, &python[number].values, &wired];
            return Some((number, format!("step {number}: {}: values of C, Python, wire: {values:?}", shown(call))));
        }
        // Of what a reply of many fields says, these show one.
        let mut all = if call.function.reports_stop() { wired.clone() } else { run.all[number].clone() };
        all.resize(all.len() + missing, 0.0);
        let reported = all.ends_with(&job[number].values) || run.all[number].ends_with(&job[number].values);
        if shows && !timed && !run.left_out.contains(&number) && !reported {
            return Some((
                number,
                format!("step {number}: {}: values of job, wire: {:?}, {all:?}", shown(call), job[number].values),
            ));
        }
    }
    None
}

/// The calls with their ticks, for a report.
fn before(programme: &Programme, reported: &[Reported]) -> String {
    let mut text =
        format!("\n{} {} {} us, batches {}", programme.profile, programme.family, programme.tick_us, programme.batches);
    for (number, (step, reported)) in programme.steps.iter().zip(reported).enumerate() {
        let what = match step {
            Step::Call(call) => shown(call),
            other => format!("{other:?}"),
        };
        text += &format!("\n  {number:>3} tick {:>6} = {} {what}", reported.tick, reported.code);
    }
    text
}

fn traces(paths: &[PathBuf; 4]) -> Option<String> {
    let read: Result<Vec<Rows>, String> = paths.iter().map(|path| Rows::read(path)).collect();
    let traces = match read {
        Ok(traces) => traces,
        Err(error) => return Some(error),
    };
    let names: Vec<String> = traces[0].names[1..]
        .iter()
        .filter(|name| traces.iter().all(|trace| trace.names.contains(name)))
        .cloned()
        .collect();
    let rows: Vec<_> = traces.iter().map(|trace| trace.since_change(&names)).collect();
    let length = rows.iter().map(Vec::len).min().unwrap().saturating_sub(END_ROWS);
    let first = (0..length).find(|at| rows.iter().any(|door| door[*at] != rows[3][*at]))?;
    let around = first.saturating_sub(2)..first + 3;
    let mut text = format!("row {first} of {length} behind the first change; {names:?}");
    for (door, rows) in DOORS.iter().zip(&rows) {
        for (ns, values) in &rows[around.clone()] {
            text += &format!("\n{door:>7} {ns:>12} {}", values.join(" "));
        }
    }
    Some(text)
}

/// The step, where it is one's answer, and how the doors differ.
pub type Differs = Option<(Option<usize>, String)>;

/// Runs programs through all doors; what differs in each. Nothing where a door is not here.
fn compare(player: &Path, name: &str, programmes: &[Programme], table: &Mutex<Table>) -> Option<Vec<Differs>> {
    run(player, name, programmes, table, &|_, _| {})
}

/// The same; `check` is shown the code of each call.
pub fn run(
    player: &Path,
    name: &str,
    programmes: &[Programme],
    table: &Mutex<Table>,
    check: &dyn Fn(usize, i32),
) -> Option<Vec<Differs>> {
    let folder = toolchain::scratch();
    let path = |door: &str, number: usize| folder.join(format!("{name}-{number}-{door}.csv"));
    let all = |door: &str| (0..programmes.len()).map(|number| path(door, number)).collect::<Vec<_>>();
    let c = player::c(player, name, programmes, &all("c"));
    let python = player::python(name, programmes, &all("python"))?;
    let mut found = Vec::new();
    for (number, ((programme, c), python)) in programmes.iter().zip(c).zip(python).enumerate() {
        let ticks: Vec<u32> = c.iter().map(|reported| reported.tick).collect();
        let waits = |number: &usize| match &programme.steps[*number] {
            Step::Call(call) => !programme.rests && c[*number].code == 1 && waits_in_jobs(call),
            _ => false,
        };
        let left_out: Vec<usize> = (0..programme.steps.len()).filter(waits).collect();
        let wire = std::panic::catch_unwind(|| wire::scheduled(programme, &ticks, &path("wire", number)));
        let wire = match wire {
            Ok(wire) => wire,
            Err(wrong) => {
                let text =
                    wrong.downcast_ref::<String>().cloned().unwrap_or_else(|| "the wire's door failed".to_owned());
                found.push(Some((None, text)));
                continue;
            }
        };
        let job = text::scheduled_job(&format!("{name}-{number}"), programme, &ticks, &left_out, &path("job", number));
        let job = match job {
            Ok(job) => job,
            Err(error) => {
                found.push(Some((None, format!("the job fails: {error}"))));
                continue;
            }
        };
        let (wire, all) = wire.into_iter().unzip();
        let job = job.into_iter().zip(&ticks).map(|(answer, tick)| Reported {
            tick: *tick,
            code: answer.code,
            values: answer.values,
            reason: answer.reason,
        });
        let run = Run { reported: [job.collect(), c, python, wire], all, left_out };
        for (number, reported) in run.reported[1].iter().enumerate().take(programme.steps.len()) {
            check(number, reported.code);
        }
        for (door, reported) in run.reported.iter().enumerate() {
            let calls = programme.steps.iter().zip(reported).enumerate();
            let made = calls.filter(|(number, _)| door != 0 || !run.left_out.contains(number));
            let mut table = table.lock().unwrap();
            made.for_each(|(_, (step, reported))| table.note(door, step, reported.code));
        }
        table.lock().unwrap().note_session();
        let paths = ["job", "c", "python", "wire"].map(|door| path(door, number));
        found.push(
            answers(programme, &run)
                .or_else(|| rules::broken(programme, &run.reported[1]))
                .map(|(step, text)| (Some(step), text + &before(programme, &run.reported[1])))
                .or_else(|| traces(&paths).map(|text| (None, text))),
        );
    }
    Some(found)
}

fn number(name: &str, default: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}

#[test]
fn random_programs_are_the_same_through_every_door() {
    let (count, first) = (number("DOORS_PROGRAMS", 24), number("DOORS_SEED", 1));
    let calls = number("DOORS_CALLS", 80) as usize;
    let Some(player) = player::build() else { return };
    let (next, stop, ties) = (AtomicU64::new(0), AtomicU64::new(0), AtomicU64::new(0));
    let (table, found) = (Mutex::new(Table::default()), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for thread in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            let (player, next, stop, ties, table, found) = (&player, &next, &stop, &ties, &table, &found);
            scope.spawn(move || {
                loop {
                    let at = next.fetch_add(BATCH_PROGRAMS, Relaxed);
                    if at >= count || stop.load(Relaxed) != 0 {
                        return;
                    }
                    let seeds: Vec<u64> = (at..(at + BATCH_PROGRAMS).min(count)).map(|number| first + number).collect();
                    let programmes: Vec<Programme> = seeds.iter().map(|seed| programme(*seed, calls)).collect();
                    let Some(differences) = compare(player, &format!("random{thread}"), &programmes, table) else {
                        return;
                    };
                    for ((seed, mut programme), mut difference) in seeds.iter().zip(programmes).zip(differences) {
                        for _ in 0..TIES {
                            let Some((Some(step), _)) = difference else { break };
                            programme.steps.insert(step, Step::Sleep(1));
                            let again =
                                compare(player, &format!("again{thread}"), std::slice::from_ref(&programme), table);
                            difference = again.unwrap().remove(0);
                            ties.fetch_add(1, Relaxed);
                        }
                        if let Some((_, difference)) = difference {
                            stop.store(1, Relaxed);
                            found.lock().unwrap().push((seed - first + 1, format!("program {seed}: {difference}")));
                        }
                    }
                }
            });
        }
    });
    let mut found = found.into_inner().unwrap();
    found.sort();
    let ties = ties.into_inner();
    println!("{count} programs, {} differ, {ties} ties at the end of a piece", found.len());
    let table = table.into_inner().unwrap();
    for (name, row) in &table.0 {
        println!("| {name} | {} |", row.map(|(calls, done)| format!("{calls}, {done}")).join(" | "));
    }
    table.publish();
    let text: String =
        found.iter().map(|(after, report)| format!("found after {after} programs:\n{report}\n")).collect();
    assert!(found.is_empty(), "{text}");
    assert!(ties * 10 <= count.max(20), "{ties} ties in {count} programs");
}
