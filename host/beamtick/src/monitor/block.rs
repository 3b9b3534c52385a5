//! The block: lines that say what a machine does, for a terminal, for `--once` and below `run`.
//!
//! In: a [`State`]. Out: lines of at most 80 columns. Owns nothing, and cannot fail.
use super::state::{JobNow, State};

/// Columns of a line.
const COLUMNS: usize = 80;

/// How a line is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tone {
    /// As it is.
    Plain,
    /// There is light.
    Light,
    /// Something is wrong.
    Fault,
}

/// A line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Line {
    /// What it says.
    pub text: String,
    /// How it is meant.
    pub tone: Tone,
}

fn line(tone: Tone, text: &str) -> Line {
    // What is too long is cut; a name may hold anything.
    let clean = text.chars().map(|letter| if letter.is_control() { ' ' } else { letter });
    let mut text: String = clean.collect();
    if text.chars().count() > COLUMNS {
        text = text.chars().take(COLUMNS - 1).chain(['…']).collect();
    }
    Line { text: text.trim_end().to_owned(), tone }
}

/// Hours, minutes and seconds.
pub fn time(seconds: f64) -> String {
    let whole = seconds.max(0.0).round() as u64;
    format!("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60)
}

/// How long data lasts.
fn lasts(ms: u32) -> String {
    format!("{:.1} s", f64::from(ms) / 1e3)
}

/// The progress of a job.
pub fn job(job: &JobNow) -> String {
    let percent = u64::from(job.done) * 100 / u64::from(job.entries.max(1));
    let left = job.left_s.map_or(String::new(), |left| format!(", about {} left", time(left)));
    // The name comes last: it may be long.
    format!("{} of {} done, {percent} %{left}: {}", job.done, job.entries, job.name)
}

/// The lines of the machine; `mode` says what this view may.
pub fn lines(state: &State, mode: &str) -> Vec<Line> {
    let head = format!("{} at {}{mode}; on for {}", state.board, state.link, time(state.clock_s));
    let mut lines = vec![line(Tone::Plain, &head)];
    lines.append(&mut machine(state));
    lines
}

/// The same without the first line.
pub fn machine(state: &State) -> Vec<Line> {
    let mut lines = Vec::new();
    for axis in &state.axes {
        let (position, speed) = match (axis.position_mm, axis.velocity_mm_min) {
            (Some(mm), Some(speed)) => (format!("{:12.3} mm", mm + 0.0), format!("{speed:10.1} mm/min")),
            _ => (format!("{:12.1} pulses", axis.position_pulse), format!("{:10.2} pulse/ms", axis.velocity_pulse_ms)),
        };
        let does = match (axis.moves, axis.on) {
            (true, _) if axis.velocity_pulse_ms != 0.0 => "moves",
            // Another axis of its path moves, or it waits.
            (true, _) => "runs",
            (false, true) => "stands",
            (false, false) => "off",
        };
        let stream = axis
            .stream
            .as_ref()
            .map_or(String::new(), |stream| format!(", {} free, dry in {}", stream.space, lasts(stream.dry_ms)));
        lines.push(line(Tone::Plain, &format!("{:<8} {position} {speed}  {does}{stream}", axis.name)));
    }
    if state.axes.is_empty() {
        lines.push(line(Tone::Plain, "axes     none is on"));
    }
    for laser in &state.lasers {
        let (tone, text) = match (laser.light, laser.commanded) {
            (true, _) => {
                let rate = match laser.frequency_khz {
                    0.0 => String::new(),
                    _ if laser.unit == "kHz" => String::new(),
                    khz => format!(", {khz:.2} kHz"),
                };
                (Tone::Light, format!("LIGHT {:.2} {}{rate}", laser.power, laser.unit))
            }
            (false, true) => (Tone::Plain, "dark, switched on".to_owned()),
            (false, false) => (Tone::Plain, "dark".to_owned()),
        };
        lines.push(line(tone, &format!("laser {}  {text}", laser.channel)));
    }
    for path in &state.paths {
        let does = match (path.runs, path.speed_mm_min) {
            (false, _) => "stands".to_owned(),
            (true, Some(speed)) => format!("runs at {speed:.1} mm/min"),
            (true, None) => format!("runs at {:.2} pulse/ms", path.speed_pulse_ms),
        };
        let (name, core) =
            (path.number, if path.core == 1 { String::new() } else { format!(" of core {}", path.core) });
        let fifo = format!("FIFO {} of {}, dry in {}", path.entries, path.capacity, lasts(path.dry_ms));
        lines.push(line(Tone::Plain, &format!("path {name}{core}   {does}; {fifo}")));
    }
    let program = &state.program;
    if program.state != "empty" || program.accepted != 0 {
        let late = if program.late == 0 { String::new() } else { format!(", {} late", program.late) };
        let text = format!(
            "program  {}, {} of {} entries executed{late}, script clock {:.1} s",
            program.state, program.executed, program.accepted, program.script_s
        );
        lines.push(line(Tone::Plain, &text));
    }
    if let Some(found) = &state.job {
        lines.push(line(Tone::Plain, &format!("job      {}", job(found))));
    }
    lines.extend(state.faults.iter().map(|fault| line(Tone::Fault, &format!("FAULT    {fault}"))));
    lines
}
