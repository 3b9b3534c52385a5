#![forbid(unsafe_code)]
//! G-code (RS274/NGC as Grbl 1.1 and LinuxCNC mean it) becomes a job in the notation of the controller manuals.
//!
//! In: the text of a program, and the machine. Out: the text of a job, and notes about what was passed over. Owns
//! nothing. Fails with file, line and reason; then there is no job, so nothing moves.
//!
//! `exact` numbers and positions, `words` a line to its words, `block` the words of a line to what they ask for,
//! `interpreter` the modal state and the moves, `arc` circles, `writer` moves to calls. `docs/gcode.md` lists the words.

mod arc;
mod block;
mod exact;
mod interpreter;
mod words;
mod writer;

use machine::Machine;

/// What the user chose.
#[derive(Debug, Clone, Copy, Default)]
pub struct Options {
    /// M0 goes on by itself; without it M0 is refused, since a job asks nobody.
    pub pass_stops: bool,
}

/// A program as a job.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Imported {
    /// The job.
    pub job: String,
    /// What was passed over, with file and line.
    pub notes: Vec<String>,
}

/// The program `text` of the file `name` as a job for `machine`.
///
/// # Errors
/// File, line and reason: what is not supported, does not fit, or leaves the travel.
pub fn import(name: &str, text: &str, machine: &Machine, options: Options) -> Result<Imported, String> {
    let mut writer = writer::Writer::new(name, machine)?;
    let notes = interpreter::run(name, text, machine, options, &mut writer)?;
    Ok(Imported { job: writer.finish(), notes })
}
