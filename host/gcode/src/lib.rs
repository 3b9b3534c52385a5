#![forbid(unsafe_code)]
//! G-code (RS274/NGC as Grbl 1.1 and LinuxCNC mean it) becomes a job in the notation of the
//! controller manuals.
//!
//! In: the text of a program, and the machine. Out: the text of a job, and notes about what was
//! passed over. Owns nothing. Fails with file, line and reason; then there is no job, so nothing
//! moves.
//!
//! `exact` numbers and positions, `words` a line to its words, `block` the words of a line to what
//! they ask for, `interpreter` the modal state and the moves, `arc` circles, `writer` moves to
//! calls. `docs/gcode.md` lists the words.

mod arc;
mod block;
mod exact;
mod interpreter;
mod words;
mod writer;

use machine::Machine;
use std::fmt;

/// What the user chose.
#[derive(Debug, Clone, Copy, Default)]
pub struct Options {
    /// M0 goes on by itself; without it M0 is refused, since a job asks nobody.
    pub pass_stops: bool,
}

/// A program as a job.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    /// The job.
    pub job: String,
    /// What was passed over, with file and line.
    pub notes: Vec<String>,
    /// What the path and its marks cover.
    pub extent: Extent,
}

/// The first words of every job that is made here.
pub const MARK: &str = "// Imported by beamtick";

/// What the path and its marks cover, in mm of the machine. Displayed as a line.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Extent {
    /// Of everything: letter, least, greatest.
    pub all: Vec<(char, f64, f64)>,
    /// Of what may be lit.
    pub marks: Vec<(char, f64, f64)>,
    /// Length of the path, mm, and of what may be lit.
    pub length: (f64, f64),
}

impl fmt::Display for Extent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let list = |rows: &[(char, f64, f64)]| {
            let rows = rows.iter().map(|(letter, least, most)| format!("{letter} {least:.3} to {most:.3}"));
            rows.collect::<Vec<_>>().join(", ")
        };
        write!(f, "path of {:.3} mm, {} mm; ", self.length.0, list(&self.all))?;
        match self.marks[..] {
            [] => write!(f, "no marks"),
            _ => write!(f, "marks of {:.3} mm, {} mm", self.length.1, list(&self.marks)),
        }
    }
}

/// The program `text` of the file `name` as a job for `machine`.
///
/// # Errors
/// File, line and reason: what is not supported, does not fit, or leaves the travel.
pub fn import(name: &str, text: &str, machine: &Machine, options: Options) -> Result<Imported, String> {
    let mut writer = writer::Writer::new(name, machine)?;
    let notes = interpreter::run(name, text, machine, options, &mut writer)?;
    let extent = writer.extent();
    Ok(Imported { job: writer.finish(), notes, extent })
}
