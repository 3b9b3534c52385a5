//! `beamtick plot`: pictures of a trace that was kept as a CSV.
//!
//! In: a CSV of SPEC 8, also one that was cut off (`.partial`). Out: the pictures that `sim` and
//! `run` draw, but for pulses, which a CSV has not. Fails with file and line; nothing is drawn
//! then.
use crate::Failure;
use crate::command_line::{PlotFile, panels};
use crate::output::{self, Output};
use crate::record::Page;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;
use trace::{Plot, PlotOptions, Row, SignalChange, TraceError, read_csv};

/// Draws.
pub fn draw(arguments: &PlotFile) -> Result<(), Failure> {
    let name = arguments.trace.display().to_string();
    let wrong = |error: TraceError| Failure::Input(format!("{name}: {error}"));
    let options = PlotOptions {
        title: arguments.trace.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        from_ms: arguments.from,
        to_ms: arguments.to,
        panels: panels(&arguments.panels),
        ..PlotOptions::default()
    };
    options.check().map_err(wrong)?;
    let outputs = [("--output", &arguments.output), ("--html", &arguments.html), ("--xy", &arguments.xy)];
    let named: Vec<(&str, &Path, bool)> =
        outputs.iter().filter_map(|(option, path)| Some((*option, path.as_deref()?, true))).collect();
    output::check(std::slice::from_ref(&arguments.trace), &named)?;
    arguments.html.as_deref().map_or(Ok(()), crate::record::page_name)?;
    for (option, path, _) in named.iter().filter(|(option, ..)| *option != "--html") {
        let end = path.extension().map(|end| end.to_string_lossy().to_lowercase());
        if !matches!(end.as_deref(), Some("png" | "svg")) {
            return Err(Failure::Input(format!("{option} {}: a plot's name ends in .png or .svg", path.display())));
        }
    }
    let file: Box<dyn Read> = match arguments.trace == Path::new("-") {
        true => Box::new(std::io::stdin()),
        false => Box::new(
            File::open(&arguments.trace)
                .map_err(|error| Failure::Input(format!("{name}: the trace cannot be read: {error}")))?,
        ),
    };
    let (header, rows) = read_csv(BufReader::new(file)).map_err(wrong)?;
    let of_rows = |each: &mut dyn FnMut(Option<&Row>, &Row)| {
        let mut before: Option<&Row> = None;
        for row in &rows {
            each(before, row);
            before = Some(row);
        }
    };
    if let Some(path) = &arguments.output {
        let mut plot = Plot::new(&header, options.clone()).map_err(wrong)?;
        of_rows(&mut |before, row| {
            switched(before, row, true, |laser, level| {
                plot.change(laser, &SignalChange::Switch { at: row.t_ns, level });
            });
            plot.row(row);
        });
        if arguments.used {
            plot.leave_out_idle();
        }
        save(Output::picture(path)?, |path| plot.save(path), wrong)?;
    }
    if let Some(path) = &arguments.html {
        let mut page = Page::new(&header, arguments.xy_axes, &options).map_err(wrong)?;
        of_rows(&mut |before, row| {
            switched(before, row, true, |laser, level| {
                page.change(laser, &SignalChange::Switch { at: row.t_ns, level });
            });
            switched(before, row, false, |laser, level| page.light(laser, row.t_ns, level));
            page.row(row);
        });
        if arguments.used {
            page.leave_out_idle();
        }
        save(Output::picture(path)?, |path| page.save(path), wrong)?;
    }
    if let Some(path) = &arguments.xy {
        let mut xy = crate::record::across(&header, arguments.xy_axes, &options).map_err(wrong)?;
        of_rows(&mut |before, row| {
            switched(before, row, false, |laser, level| xy.light(laser, row.t_ns, level));
            xy.row(row);
        });
        save(Output::picture(path)?, |path| xy.save(path), wrong)?;
    }
    Ok(())
}

/// Draws into the file; of one that cannot be written nothing empty is left. `wrong` says what is
/// wrong with the trace or the options.
fn save(
    output: Output,
    draw: impl FnOnce(&Path) -> trace::Result<()>,
    wrong: impl FnOnce(TraceError) -> Failure,
) -> Result<(), Failure> {
    match draw(output.path()) {
        Ok(()) => output.whole(),
        Err(error) => {
            output.cut_off();
            Err(match error {
                TraceError::Window(_) => wrong(error),
                error => Failure::Job(error.to_string()),
            })
        }
    }
}

/// Lasers whose gate changes at a row; at the first one those that are on, or (`all`) every one.
fn switched(before: Option<&Row>, row: &Row, all: bool, mut each: impl FnMut(usize, bool)) {
    for (laser, point) in row.lasers.iter().enumerate() {
        let was = before.and_then(|before| before.lasers.get(laser)).map(|point| point.gate);
        if was.map_or(all || point.gate, |was| was != point.gate) {
            each(laser, point.gate);
        }
    }
}
