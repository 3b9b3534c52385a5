#![forbid(unsafe_code)]
//! G-code (RS274/NGC as Grbl 1.1 and LinuxCNC mean it) becomes a job in the notation of the
//! controller manuals.
//!
//! In: the text of a program, and the machine. Out: the text of a job, and notes about what was
//! passed over. Owns nothing. Fails with file, line and reason; then there is no job, so nothing
//! moves.
//!
//! `words` a line to its words, `block` the words of a line to what they ask for, `interpreter` the
//! modal state and the moves, `stream` lines that come one by one; the crate `strokes` makes calls
//! of the moves. `docs/gcode.md` lists the words.

mod block;
mod interpreter;
mod stream;
mod words;

pub use stream::{Coolant, Ended, Line, Modes, Offsets, Stream};

use machine::Machine;
use std::io::{BufRead, Write};
use strokes::{Extent, Imported, Watch, Writer};

/// What the user chose.
#[derive(Debug, Clone, Copy, Default)]
pub struct Options {
    /// M0 goes on by itself; without it M0 is refused, since a job asks nobody.
    pub pass_stops: bool,
    /// Nobody asks for the time that the path takes.
    pub untimed: bool,
}

/// The program `text` of the file `name` as a job for `machine`.
///
/// # Errors
/// File, line and reason: what is not supported, does not fit, or leaves the travel.
pub fn import(name: &str, text: &str, machine: &Machine, options: Options) -> Result<Imported, String> {
    let mut job = Vec::new();
    let (notes, extent) = import_to(name, &mut text.as_bytes(), machine, options, None, &mut job)?;
    Ok(Imported { job: String::from_utf8_lossy(&job).into_owned(), notes, extent })
}

/// The same of a program of any length, which is read as the job is written to `to`. `watch` is
/// shown where the path goes, up to where it leaves the travel. Out: notes, and what is covered.
///
/// # Errors
/// As [`import`]; the program cannot be read, or the job not be written.
pub fn import_to(
    name: &str,
    program: &mut dyn BufRead,
    machine: &Machine,
    options: Options,
    watch: Option<Watch<'_>>,
    to: &mut dyn Write,
) -> Result<(Vec<String>, Extent), String> {
    let mut writer = Writer::new(name, "line N of the program", machine);
    if let Some(watch) = watch {
        writer.watched(watch);
    }
    if options.untimed {
        writer.untimed();
    }
    let mut notes = interpreter::run(name, program, machine, options, &mut writer, to)?;
    notes.extend(writer.notes().into_iter().map(|(line, note)| format!("{name}:{line}: note: {note}")));
    let extent = writer.extent();
    to.write_all(writer.finish().as_bytes()).map_err(|error| interpreter::unkept(name, &error))?;
    Ok((notes, extent))
}
