//! `beamtick check`: what a job would do.
use crate::Failure;
use crate::command_line::Check;
use crate::reply;
use crate::source::Source;
use job::Action;
use strokes::Extent;

/// What a program or a drawing would do, in mm: `import` writes the calls.
fn summary(source: &Source, extent: &Extent) {
    say!("{}: {extent}", source.name);
    say!(
        "  it fits the machine; {:.3} mm in the dark, {} calls, which `beamtick import` writes",
        extent.length.0 - extent.length.1,
        source.job.steps.len()
    );
}

/// Prints a line for each step: line of the script, script clock, what is done.
pub fn check(arguments: &Check) -> Result<(), Failure> {
    let source = Source::open_drawn(&arguments.job, &arguments.drawing, arguments.plot.as_deref())?;
    if let Some(extent) = &source.extent {
        summary(&source, extent);
        return Ok(());
    }
    let mut waits = 0u32;
    let mut clock = 0u64;
    say!("{:>6}  {:>14}  step", "line", "script clock");
    for step in &source.job.steps {
        // After a wait the clock is known only relative to its end.
        let time =
            format!("{}{}.{:03} ms", "w+".repeat(usize::from(waits > 0)), clock / 1_000_000, clock / 1000 % 1000);
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
        say!("{:>6}  {time:>14}  {what}", step.line);
    }
    let axes: Vec<String> = source.job.axes.iter().map(|axis| format!("{}.{}", axis.core, axis.axis)).collect();
    say!(
        "{}: {} steps, {} warnings; axes used (core.axis): {}",
        source.name,
        source.job.steps.len(),
        source.job.warnings.len(),
        if axes.is_empty() { "none".to_owned() } else { axes.join(" ") }
    );
    Ok(())
}
