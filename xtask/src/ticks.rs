//! Instructions per servo tick, counted in the emulator.
//!
//! In: what the probes in `probes/chip/src/bin/` print: `ticks.rs` and others for ticks,
//! `stream.rs` for PT data from the host to the ring. Out: a table. `write` puts it into
//! `docs/numbers.md` between its two marks, `check` compares it with that page. Fails: a count
//! above the stated one is an error. QEMU counts instructions, not cycles: every number is the same
//! on every run of the same image. It may change a little when the compiler or anything inlined
//! into the tick changes.
use crate::image::build_bin;
use crate::setup::{self, QEMU};
use crate::shares::{self, Share};
use crate::shell::{Outcome, program, read, root};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Nanoseconds that an instruction takes in the emulator: 2^8, so that the 40 ns of SysTick resolve
/// it.
const INSTRUCTION_LOG2_NS: u32 = 8;
const SYSTICK_NS: u32 = 40;

/// How far a count may exceed the stated one before `check` fails: in percent, and a few
/// instructions for the small counts.
const TOLERANCE_PERCENT: u32 = 3;
const TOLERANCE_INSTRUCTIONS: u32 = 8;

const BEGIN: &str = "<!-- ticks: written by `cargo xtask ticks` -->";
const END: &str = "<!-- end of ticks -->";
const SHARES: &str = "<!-- shares: written by `cargo xtask ticks` -->";
const END_OF_SHARES: &str = "<!-- end of shares -->";

/// Fewest, middle and most instructions of some ticks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Row {
    best: u32,
    typical: u32,
    worst: u32,
    ticks: usize,
}

/// Rows in the order of the table: what runs, then what the tick does.
type Table = BTreeMap<(u32, &'static str), Row>;

/// The lanes of `stream.rs`, and its paths: cost of receiving a full frame, divided by its segments
/// or lines.
const LANES: [&str; 5] = ["immediate", "program", "lnxy", "lines", "ahead"];

const MARKS: [(&str, &str); 77] = [
    ("idle", "nothing runs"),
    ("inside", "no segment change"),
    ("change", "every axis enters another segment"),
    ("pvt-inside", "PVT, no segment change"),
    ("pvt-change", "PVT, every axis enters another segment"),
    ("start", "all axes start"),
    ("start-ready", "all axes start, prepared at standstill"),
    ("pvt-start", "PVT, all axes start"),
    ("pvt-ready", "PVT, all axes start, prepared at standstill"),
    ("follow-inside", "Follow, no segment change (8: seven follow the eighth, which jogs)"),
    ("follow-change", "Follow, every slave enters another segment"),
    ("follow-start", "Follow, all slaves start"),
    ("follow-ready", "Follow, all slaves start, prepared at standstill"),
    ("shaped-inside", "FollowEx, no piece begins"),
    ("shaped-change", "FollowEx, every slave enters another piece of its shaped segments"),
    ("shaped-start", "FollowEx, all slaves start"),
    ("shaped-ready", "FollowEx, all slaves start, prepared at standstill"),
    ("trap", "all axes start Trap"),
    ("trap-ready", "all axes start Trap, prepared at standstill"),
    ("trap-inside", "Trap, pieces of ramps begin and end"),
    ("smooth", "all axes start smoothed Trap"),
    ("smooth-ready", "all axes start smoothed Trap, prepared at standstill"),
    ("smooth-inside", "smoothed Trap, pieces of ramps begin and end"),
    ("stop", "smooth Stop of all axes"),
    ("stop-ramp", "the tick after that, which makes their ramps"),
    ("set", "servo on, mode, loop and commit for every axis"),
    ("set-ramp", "servo on, mode, parameters, speed, target and deceleration for every axis"),
    ("laser-dark", "laser channels dark, no axis runs"),
    ("laser-steady", "laser channels in light of one power, no axis runs"),
    ("laser-on", "laser channels, their light begins within the tick"),
    ("laser-off", "laser channels, their light ends within the tick"),
    ("laser-power", "laser channels change their power, planned by the thread"),
    ("laser-unplanned", "laser channels change their power, not planned by the thread"),
    ("path-line", "step of a path within a line in four coordinates (worst: it plans the next motion)"),
    ("path-arc", "step of a path within an arc (worst: it plans the next motion)"),
    ("path-enter", "first step of a path within a line or an arc"),
    ("path-turn", "step of a path that enters the next line or arc"),
    ("path-stop", "smooth Stop of a path"),
    ("crd-idle", "coordinate systems set and at standstill, on a tick of 12 axes, as in the rows below"),
    ("crd-line", "coordinate systems within a line (worst: it prepares the next motion)"),
    ("crd-arc", "coordinate systems within an arc (worst: likewise)"),
    ("crd-turn", "coordinate systems, all enter the next line or arc"),
    ("crd-enter", "coordinate systems, the tick after that"),
    ("crd-start", "coordinate systems, all start"),
    ("crd-ready", "coordinate systems, all start, prepared at standstill"),
    ("crd-once", "coordinate systems, all are set, get their data and start in one tick"),
    ("laser-alone", "laser channels in light while a coordinate system speeds up, on a tick of 12 axes"),
    ("laser-speed", "laser channels, likewise, whose power follows its speed"),
    ("laser-place", "laser channels, likewise, whose power follows positions of four axes"),
    ("laser-both", "laser channels, likewise, both"),
    ("laser-tables", "laser channels, likewise, both by tables, one for each axis"),
    (
        "crd-worst",
        "SPEC 11: 8 axes enter segments of PVT, 2 coordinate systems enter motions, 2 lasers follow speed and distance",
    ),
    ("crd-worst-inside", "the same, any other tick"),
    ("steps-10", "reference board, in addition to its tick of 10 µs: slots of the step output, axes at 1 MHz"),
    ("steps-20", "likewise of 20 µs"),
    ("steps-50", "likewise of 50 µs"),
    ("steps-250", "likewise of 250 µs"),
    ("steps-slow-50", "likewise of 50 µs, axes at 100 kHz"),
    ("steps-slow-250", "likewise of 250 µs, axes at 100 kHz"),
    (
        "cycles-10",
        "reference board, in addition to its tick of 10 µs: PWM cycles of the laser timers, channels that pulse at 2 MHz",
    ),
    ("cycles-20", "PWM cycles, likewise of 20 µs"),
    ("cycles-50", "PWM cycles, likewise of 50 µs"),
    ("cycles-odd-10", "PWM cycles, likewise of 10 µs, but no two successive pulses are equal"),
    ("cycles-odd-20", "PWM cycles, likewise of 20 µs"),
    ("cycles-odd-50", "PWM cycles, likewise of 50 µs"),
    ("cycles-follow-10", "PWM cycles, likewise of 10 µs, hardly dithered, of a power that changes in every tick"),
    ("cycles-follow-20", "PWM cycles, likewise of 20 µs"),
    ("cycles-follow-50", "PWM cycles, likewise of 50 µs"),
    ("cycles-follow-odd-10", "PWM cycles, likewise of 10 µs, but no two successive pulses are equal"),
    ("cycles-follow-odd-20", "PWM cycles, likewise of 20 µs"),
    ("cycles-follow-odd-50", "PWM cycles, likewise of 50 µs"),
    ("cycles-cut-10", "PWM cycles, likewise of 10 µs, of a constant power, at 1.2 MHz"),
    ("immediate", "host byte to ring per segment, batched"),
    ("program", "host byte to ring per segment, batched, program queue"),
    ("lnxy", "host byte to store per line of a path, a call each"),
    ("lines", "host byte to store per line of a path, batched"),
    ("ahead", "host byte to store per line of a path, batched, through the look-ahead"),
];

fn count() -> Outcome<Table> {
    setup::run()?;
    let mut counted = table(&print("ticks")?)?;
    counted.append(&mut rows(&print("paths")?)?);
    counted.append(&mut rows(&print("crds")?)?);
    counted.append(&mut rows(&print("steps")?)?);
    counted.append(&mut rows(&print("pwm-cycles")?)?);
    counted.append(&mut segments(&print("stream")?)?);
    Ok(counted)
}

/// What a probe prints in the emulator.
fn print(probe: &str) -> Outcome<String> {
    let image = build_bin("beamtick-probes", probe)?;
    let mut qemu = program(QEMU);
    qemu.args(["-M", "mps2-an500", "-nographic", "-monitor", "none", "-serial", "null"])
        .args(["-icount", &format!("shift={INSTRUCTION_LOG2_NS}")])
        .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
        .arg(image);
    read(&mut qemu)
}

/// The counts of what a probe prints.
type Counts = BTreeMap<(u32, &'static str), Vec<u32>>;

fn counts(text: &str) -> Outcome<Counts> {
    let mut counts = Counts::new();
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [case, mark, count] = words.as_slice() else { return Err(format!("the probe says: {line}")) };
        let (Ok(axes), Ok(count)) = (case.parse::<u32>(), count.parse::<u32>()) else {
            return Err(format!("the probe says: {line}"));
        };
        if axes > 0 && *mark == "idle" {
            continue;
        }
        if let Some((mark, _)) = MARKS.iter().find(|(known, _)| known == mark) {
            counts.entry((axes, *mark)).or_default().push(instructions(count));
        }
    }
    Ok(counts)
}

/// The rows of what a probe prints.
fn rows(text: &str) -> Outcome<Table> {
    Ok(counts(text)?.into_iter().map(|(key, counts)| (key, row(counts))).collect())
}

/// The rows of the ticks' probe, which must have run all kinds of ticks.
fn table(text: &str) -> Outcome<Table> {
    let counts = counts(text)?;
    for (axes, mark) in [(0, "idle"), (1, "inside"), (1, "change"), (8, "inside"), (8, "change")] {
        if counts.get(&(axes, mark)).is_none_or(|c| c.len() < 8) {
            return Err(format!("the probe ran too few ticks of {axes} axes, {mark}"));
        }
    }
    Ok(counts.into_iter().map(|(key, counts)| (key, row(counts))).collect())
}

/// The rows of what the stream probe prints, in instructions per segment.
fn segments(text: &str) -> Outcome<Table> {
    let mut counts: BTreeMap<(u32, &'static str), Vec<u32>> = BTreeMap::new();
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [lane, what, segments, count] = words.as_slice() else { return Err(format!("the probe says: {line}")) };
        let (Some(lane), Ok(segments @ 1..), Ok(count)) =
            (LANES.iter().find(|known| *known == lane), segments.parse::<u32>(), count.parse::<u32>())
        else {
            return Err(format!("the probe says: {line}"));
        };
        if *what == "feed" {
            counts.entry((0, *lane)).or_default().push(instructions(count).div_ceil(segments));
        }
    }
    if LANES.iter().any(|lane| counts.get(&(0, *lane)).is_none_or(|c| c.len() < 8)) {
        return Err("the probe took too few frames".into());
    }
    Ok(counts.into_iter().map(|(key, counts)| (key, row(counts))).collect())
}

fn instructions(periods: u32) -> u32 {
    (periods * SYSTICK_NS + (1 << (INSTRUCTION_LOG2_NS - 1))) >> INSTRUCTION_LOG2_NS
}

fn row(mut counts: Vec<u32>) -> Row {
    counts.sort_unstable();
    let at = |index: usize| counts.get(index).copied().unwrap_or_default();
    Row { best: at(0), typical: at(counts.len() / 2), worst: at(counts.len().saturating_sub(1)), ticks: counts.len() }
}

fn shown(table: &Table) -> String {
    let mut text = String::from(
        "| running: axes (PT, where nothing else is named), laser channels or paths | tick | best | typical | worst | ticks or frames counted |\n| --- | --- | --- | --- | --- | --- |\n",
    );
    for (mark, words) in MARKS {
        for ((axes, _), row) in table.iter().filter(|((_, m), _)| *m == mark) {
            if *axes == 0 && mark != "idle" && !LANES.contains(&mark) {
                continue;
            }
            let Row { best, typical, worst, ticks } = row;
            let _ = writeln!(text, "| {axes} | {words} | {best} | {typical} | {worst} | {ticks} |");
        }
    }
    text
}

fn page() -> std::path::PathBuf {
    root().join("docs/numbers.md")
}

/// Splits the page around a table.
fn parts<'a>(page: &'a str, [begin, end]: [&str; 2]) -> Outcome<(&'a str, &'a str, &'a str)> {
    page.split_once(begin)
        .and_then(|(before, rest)| rest.split_once(end).map(|(old, after)| (before, old, after)))
        .ok_or_else(|| format!("docs/numbers.md lacks the lines `{begin}` and `{end}`"))
}

/// The page with another table.
fn put(page: &str, [begin, end]: [&str; 2], table: &str) -> Outcome<String> {
    let (before, _, after) = parts(page, [begin, end])?;
    Ok(format!("{before}{begin}\n{table}{end}{after}"))
}

/// Counts, prints, and writes the tables into the page.
pub fn write() -> Outcome {
    let table = count()?;
    let (rows, shares) = (shown(&table), shown_shares(Some(&table))?);
    print!("{rows}\n{shares}");
    let text = std::fs::read_to_string(page()).map_err(|e| format!("docs/numbers.md: {e}"))?;
    let text = put(&put(&text, [BEGIN, END], &rows)?, [SHARES, END_OF_SHARES], &shares)?;
    std::fs::write(page(), text).map_err(|e| format!("docs/numbers.md: {e}"))
}

/// Prints which part of the tick takes how many instructions of SPEC 11's tick.
pub fn shares() -> Outcome {
    setup::run()?;
    print!("{}", shown_shares(None)?);
    Ok(())
}

/// The shares as a table; with the rows of the reference board it also sums up what its tick of 10
/// µs takes.
fn shown_shares(table: Option<&Table>) -> Outcome<String> {
    let counts = shares::count(&build_bin("beamtick-probes", "crds")?)?;
    let mut text = String::from("| share of the tick of SPEC 11 | instructions |\n| --- | ---: |\n");
    for ((_, words), count) in shares::SHARES.iter().zip(&counts) {
        let _ = writeln!(text, "| {words} | {count} |");
    }
    let counted = |of: &[Share]| -> usize {
        let all = shares::SHARES.iter().zip(&counts);
        all.filter(|((share, _), _)| of.contains(share)).map(|(_, count)| count).sum()
    };
    let goal = counted(&[Share::Axes, Share::Crds, Share::Lasers, Share::Planning]);
    let all: usize = counts.iter().sum();
    let _ = writeln!(text, "| **evaluators and planning**, of which SPEC 11 asks for 2,400 | **{goal}** |");
    let _ = writeln!(text, "| the whole tick | {all} |");
    let row = |axes: u32, mark: &'static str| table.and_then(|table| table.get(&(axes, mark)));
    if let (Some(steps), Some(cycles), Some(odd)) =
        (row(8, "steps-10"), row(2, "cycles-follow-10"), row(2, "cycles-follow-odd-10"))
    {
        let (steps, cycles, odd) = (steps.typical as usize, cycles.typical as usize, odd.typical as usize);
        let _ = writeln!(text, "| step slots of eight axes at 1 MHz, a tick of 10 µs | {steps} |");
        let _ =
            writeln!(text, "| PWM cycles of two carriers of 2 MHz whose power follows, a tick of 10 µs | {cycles} |");
        let _ = writeln!(text, "| **the total on the reference board** | **{}** |", all + steps + cycles);
        let _ = writeln!(text, "| the same where no two successive pulses are equal | {} |", all + steps + odd);
    }
    Ok(text)
}

/// Counts, and compares with the page: more instructions than stated is an error, fewer is printed.
pub fn check() -> Outcome {
    let table = count()?;
    let (rows, shares) = (shown(&table), shown_shares(Some(&table))?);
    print!("{rows}\n{shares}");
    let text = std::fs::read_to_string(page()).map_err(|e| format!("docs/numbers.md: {e}"))?;
    compare(parts(&text, [BEGIN, END])?.1.trim(), rows.trim(), cells)?;
    compare(parts(&text, [SHARES, END_OF_SHARES])?.1.trim(), shares.trim(), pair)
}

/// The words of a row and its counts.
type Cells<const N: usize> = Outcome<(String, [u32; N])>;

fn compare<const N: usize>(stated: &str, counted: &str, cells: fn(&str) -> Cells<N>) -> Outcome {
    if stated.lines().count() != counted.lines().count() {
        return Err("docs/numbers.md has other rows than were counted; `cargo xtask ticks` writes it anew".into());
    }
    let mut worse = String::new();
    for (stated, counted) in stated.lines().zip(counted.lines()).skip(2) {
        let (name, old) = cells(stated)?;
        let (same, new) = cells(counted)?;
        if name != same {
            return Err(format!("docs/numbers.md states `{name}` where `{same}` was counted"));
        }
        for (old, new) in old.into_iter().zip(new) {
            let allowed = old * TOLERANCE_PERCENT / 100 + TOLERANCE_INSTRUCTIONS;
            if new > old + allowed {
                let _ = write!(worse, "\n  {name}: {new} instructions where {old} are stated");
            } else if new + allowed < old {
                println!("{name}: {new} instructions where {old} are stated; `cargo xtask ticks` writes it down");
            }
        }
    }
    if worse.is_empty() { Ok(()) } else { Err(format!("the tick has become longer:{worse}")) }
}

/// A row's words and its three counts.
fn cells(row: &str) -> Cells<3> {
    let cells: Vec<&str> = row.split('|').map(str::trim).collect();
    let [_, axes, tick, best, typical, worst, ..] = cells.as_slice() else {
        return Err(format!("not a row of the table: {row}"));
    };
    let number = |cell: &str| cell.parse::<u32>().map_err(|_| format!("not a count: {cell} in {row}"));
    Ok((format!("{axes} axes, {tick}"), [number(best)?, number(typical)?, number(worst)?]))
}

/// A row's words and its one count.
fn pair(row: &str) -> Cells<1> {
    let cells: Vec<&str> = row.split('|').map(str::trim).collect();
    let [_, words, count, _] = cells.as_slice() else { return Err(format!("not a row of the shares: {row}")) };
    let count = count.trim_matches('*').parse().map_err(|_| format!("not a count: {count} in {row}"))?;
    Ok((String::from(*words), [count]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn printed(inside: u32) -> String {
        let mut text = String::new();
        for axes in [0u32, 1, 8] {
            for k in 0..10 {
                let mark = if axes == 0 { "idle" } else { "inside" };
                let _ = writeln!(text, "{axes} {mark} {}", (inside + k) * 32 / 5);
                if axes > 0 {
                    let _ = writeln!(text, "{axes} change {}", (2 * inside + k) * 32 / 5);
                }
            }
        }
        text
    }

    #[test]
    fn counts_become_instructions() {
        let table = table(&printed(1000)).unwrap();
        assert_eq!(table[&(1, "inside")], Row { best: 1000, typical: 1005, worst: 1009, ticks: 10 });
        assert_eq!(table[&(8, "change")].best, 2000);
    }

    #[test]
    fn a_longer_tick_is_an_error_and_a_shorter_one_is_not() {
        let old = shown(&table(&printed(1000)).unwrap());
        assert!(compare(old.trim(), old.trim(), cells).is_ok());
        let longer = shown(&table(&printed(1060)).unwrap());
        assert!(compare(old.trim(), longer.trim(), cells).unwrap_err().contains("1060"));
        let shorter = shown(&table(&printed(900)).unwrap());
        assert!(compare(old.trim(), shorter.trim(), cells).is_ok());
    }

    #[test]
    fn a_larger_share_is_an_error() {
        let shares = |count: u32| format!("| share | instructions |\n| --- | ---: |\n| **all** | **{count}** |");
        assert!(compare(&shares(2000), &shares(2060), pair).is_ok());
        assert!(compare(&shares(2000), &shares(2080), pair).unwrap_err().contains("2080"));
    }

    #[test]
    fn frames_become_instructions_per_segment() {
        let mut text = String::new();
        for lane in LANES {
            for k in 0..9u32 {
                let _ = writeln!(text, "{lane} feed 77 {}\n{lane} answer 77 {}", (400 * 77 + k) * 32 / 5, 9 * 77);
            }
        }
        let rows = segments(&text).unwrap();
        assert_eq!(rows[&(0, "program")], Row { best: 400, typical: 401, worst: 401, ticks: 9 });
        let shown = shown(&rows);
        assert!(shown.contains("| 0 | host byte to ring per segment, batched | 400 | 401 | 401 | 9 |"), "{shown}");
        assert!(segments("program feed 0 5").is_err() && segments("program feed 77 5").is_err());
    }

    #[test]
    fn what_the_probe_does_not_say_is_an_error() {
        assert!(table("1 inside 5\n").is_err());
        assert!(table("panicked at somewhere").is_err());
    }
}
