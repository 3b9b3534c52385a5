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
use strokes::{Imported, Watch, Writer};

/// What the user chose.
#[derive(Debug, Clone, Copy, Default)]
pub struct Options {
    /// M0 goes on by itself; without it M0 is refused, since a job asks nobody.
    pub pass_stops: bool,
}

/// The program `text` of the file `name` as a job for `machine`.
///
/// # Errors
/// File, line and reason: what is not supported, does not fit, or leaves the travel.
pub fn import(name: &str, text: &str, machine: &Machine, options: Options) -> Result<Imported, String> {
    import_shown(name, text, machine, options, None)
}

/// The same, with what shows where the path goes, up to where it leaves the travel.
///
/// # Errors
/// As [`import`].
pub fn import_shown(
    name: &str,
    text: &str,
    machine: &Machine,
    options: Options,
    watch: Option<Watch<'_>>,
) -> Result<Imported, String> {
    let mut writer = Writer::new(name, "line N of the program", machine);
    if let Some(watch) = watch {
        writer.watched(watch);
    }
    let mut notes = interpreter::run(name, text, machine, options, &mut writer)?;
    notes.extend(writer.notes().into_iter().map(|(line, note)| format!("{name}:{line}: note: {note}")));
    let extent = writer.extent();
    Ok(Imported { job: writer.finish(), notes, extent })
}
