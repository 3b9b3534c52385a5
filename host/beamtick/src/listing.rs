//! `beamtick check`: what a job would do.
//!
//! In: a job that compiles. Out: [`Facts`], as a table or as JSON (docs/json.md): a line of the
//! script for each step, or of a program or a drawing what its path covers. Owns nothing.
use crate::Failure;
use crate::command_line::Check;
use crate::source::Source;
use crate::summary::counted;
use crate::{json, reply};
use job::Action;
use serde::Serialize;
use std::fmt;
use strokes::Extent;

/// What a job would do.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Facts {
    job: String,
    /// Of a program or a drawing: what its path covers. It has no `steps` then; `import` writes
    /// them.
    path: Option<PathFacts>,
    steps: Vec<StepFacts>,
    /// How many steps there are.
    step_count: usize,
    warnings: usize,
    /// Axes used, as `core.axis`.
    axes: Vec<String>,
}

/// What a path covers, in mm of the machine.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct PathFacts {
    length_mm: f64,
    /// Of what may be lit.
    marks_mm: f64,
    /// Of everything.
    covers: Vec<RangeFacts>,
    /// Of what may be lit.
    marks: Vec<RangeFacts>,
    /// Of a machine with named lasers: what each may light.
    lasers: Vec<LaserMarks>,
    /// The time that it takes, s.
    seconds: f64,
    #[serde(skip)]
    text: String,
}

/// What a laser marks.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct LaserMarks {
    name: String,
    marks_mm: f64,
}

#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct RangeFacts {
    letter: char,
    least_mm: f64,
    greatest_mm: f64,
}

/// A step of a job.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct StepFacts {
    /// Line of the script.
    line: u32,
    /// Waits before it.
    waits_before: u32,
    /// Script clock since the last wait, ms.
    clock_ms: f64,
    what: String,
}

impl PathFacts {
    fn of(extent: &Extent) -> PathFacts {
        let range = |row: &(char, f64, f64)| RangeFacts { letter: row.0, least_mm: row.1, greatest_mm: row.2 };
        let lasers = extent.lasers.iter().map(|(name, length)| LaserMarks { name: name.clone(), marks_mm: *length });
        PathFacts {
            length_mm: extent.length.0,
            marks_mm: extent.length.1,
            covers: extent.all.iter().map(range).collect(),
            marks: extent.marks.iter().map(range).collect(),
            lasers: lasers.collect(),
            seconds: extent.seconds.unwrap_or_default(),
            text: extent.to_string(),
        }
    }
}

impl fmt::Display for Facts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(path) = &self.path {
            writeln!(f, "{}: {}", self.job, path.text)?;
            if path.covers.is_empty() {
                return write!(f, "  it holds no motion: nothing would move, and nothing be marked");
            }
            let dark = path.length_mm - path.marks_mm;
            let calls = counted(self.step_count as i64, "call", "calls");
            return write!(
                f,
                "  it fits the machine; {dark:.3} mm in the dark, {calls}, which `beamtick import` writes"
            );
        }
        writeln!(f, "{:>6}  {:>14}  step", "line", "script clock")?;
        for StepFacts { line, waits_before, clock_ms, what } in &self.steps {
            // After a wait the clock is known only relative to its end.
            let time = format!("{}{clock_ms:.3} ms", "w+".repeat(usize::from(*waits_before > 0)));
            writeln!(f, "{line:>6}  {time:>14}  {what}")?;
        }
        let axes = if self.axes.is_empty() { "none".to_owned() } else { self.axes.join(" ") };
        let steps = counted(self.step_count as i64, "step", "steps");
        let warnings = counted(self.warnings as i64, "warning", "warnings");
        writeln!(f, "{}: {steps}, {warnings}; axes used (core.axis): {axes}", self.job)?;
        write!(
            f,
            "  the text is right; limits and states (an axis that is off, a soft limit) are what `beamtick sim` finds"
        )
    }
}

/// The steps with their times.
fn steps(source: &Source) -> Result<Vec<StepFacts>, Failure> {
    let (mut waits, mut clock) = (0u32, 0u64);
    let mut step = |step: job::Step| {
        let (waits_before, clock_ms) = (waits, (clock / 1000) as f64 / 1e3);
        let what = match &step.action {
            Action::Sleep { ns } => {
                clock += ns;
                format!("sleep {} ms", *ns as f64 / 1e6)
            }
            Action::WaitStop { core, axes, crds } => {
                (waits, clock) = (waits + 1, 0);
                format!("wait until axes {axes:#x} and coordinate systems {crds:#x} of core {core} are at rest")
            }
            Action::WaitAll => {
                (waits, clock) = (waits + 1, 0);
                "wait until nothing runs".to_owned()
            }
            Action::Call(call) => format!("{}: {}", call.function, reply::request(call.opcode, &call.body)),
        };
        StepFacts { line: step.line, waits_before, clock_ms, what }
    };
    let listed = source.steps().map(|found| found.map(&mut step)).collect::<Result<_, _>>();
    listed.map_err(|why| Failure::Input(format!("{}: {why}", source.name)))
}

/// Prints a line for each step: line of the script, script clock, what is done.
pub fn check(arguments: &Check) -> Result<(), Failure> {
    let source = Source::open_drawn(&arguments.job, &arguments.drawing, arguments.plot.as_deref(), true)?;
    let path = source.extent.as_ref().map(PathFacts::of);
    let facts = Facts {
        job: source.name.clone(),
        steps: if path.is_some() { Vec::new() } else { steps(&source)? },
        path,
        step_count: source.totals.steps,
        warnings: source.job.warnings.len(),
        axes: source.job.axes.iter().map(|axis| format!("{}.{}", axis.core, axis.axis)).collect(),
    };
    let text = facts.to_string();
    if !json::result(json::Facts::Check(Box::new(facts))) {
        say!("{text}");
    }
    Ok(())
}
