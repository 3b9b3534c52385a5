#![forbid(unsafe_code)]
//! A drawing becomes a job: what has a stroke is marked, layer by layer.
//!
//! In: the bytes of a file, the machine. Out: the text of a job, notes about what was passed over.
//! Owns nothing. Fails with file, line or shape, and reason; then there is no job, so nothing
//! moves.
//!
//! `svg` and `dxf` a file to shapes, `shape` their geometry, `round` arcs in curves, `layers` the
//! power of each, `order` the way from one to the next, `plan` shapes to motions; the crate
//! `strokes` makes calls of them. `docs/drawings.md` is the user's page.
#![allow(missing_docs)]

mod dxf;
mod fault;
mod layers;
mod order;
mod plan;
mod round;
mod shape;
mod svg;

use machine::Machine;
use strokes::{Imported, Watch, Writer};

/// Formats of drawings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    Svg,
    Dxf,
}

/// What the user chose.
#[derive(Debug, Clone, Copy, Default)]
pub struct Options {
    /// Machine position, mm, of the lower left corner of the page (SVG), or of the origin (DXF).
    pub at: [f64; 2],
    /// Nobody asks for the time that the path takes.
    pub untimed: bool,
}

/// What a number at a call is.
const EACH: &str = "motion N of the drawing";

/// The drawing `bytes` of the file `name` as a job for `machine`; `watch` is shown where the path
/// goes, outside the travel too.
///
/// # Errors
/// File, line or shape, and reason: what is no drawing, has no layer, or leaves the travel.
pub fn import(
    name: &str,
    bytes: &[u8],
    format: Format,
    machine: &Machine,
    options: Options,
    watch: Option<Watch<'_>>,
) -> Result<Imported, String> {
    let (shapes, notes) = match format {
        Format::Svg => svg::read(bytes),
        Format::Dxf => dxf::read(bytes),
    }
    .map_err(|fault| match fault.line {
        Some(line) => format!("{name}:{line}: {}; nothing was run", fault.text),
        None => format!("{name}: {}; nothing was run", fault.text),
    })?;
    if shapes.is_empty() {
        let why: String = notes.iter().take(4).map(|note| format!("; {note}")).collect();
        return Err(format!("{name}: there is nothing to mark: no shape has a stroke{why}; nothing was run"));
    }
    let mut writer = Writer::new(name, EACH, machine);
    if let Some(watch) = watch {
        writer.watched(watch);
    }
    if options.untimed {
        writer.untimed();
    }
    let found = plan::plan(shapes, machine, options, &mut writer);
    let found = found.map_err(|why| format!("{name}: {why}; nothing was run"))?;
    let notes = notes.into_iter().chain(found).map(|note| format!("{name}: note: {note}")).collect();
    let extent = writer.extent();
    Ok(Imported { job: writer.finish(), notes, extent })
}
