#![forbid(unsafe_code)]
//! Motions in mm become a job in the notation of the controller manuals: what G-code and drawings
//! have in common.
//!
//! In: a [`machine::Machine`], then [`Stroke`]s with their light, dwells, outputs. Out: the text of
//! a job, what it covers in mm. Owns nothing beyond a job. Fails where the machine cannot run a
//! path; strokes must lie in its travel.
//!
//! `exact` lengths and positions, `arc` circles, `writer` strokes to calls.
#![allow(missing_docs)]

pub mod arc;
mod estimate;
pub mod exact;
mod number;
mod writer;

use std::fmt;
pub use writer::{Checkpoint, Light, Shape, Stroke, Writer};

/// Where the path goes, mm, and which laser of the machine may be lit on the way there: for
/// pictures.
pub type Watch<'a> = &'a mut dyn FnMut([f64; 3], Option<usize>);

/// The first words of every job that is made here.
pub const MARK: &str = "// Imported by beamtick";

/// A program or a drawing as a job.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    /// The job.
    pub job: String,
    /// What was passed over, with file and line.
    pub notes: Vec<String>,
    /// What the path and its marks cover.
    pub extent: Extent,
}

/// What the path and its marks cover, in mm of the machine. Displayed as a line.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Extent {
    /// Of everything: letter, least, greatest.
    pub all: Vec<(char, f64, f64)>,
    /// Of what may be lit.
    pub marks: Vec<(char, f64, f64)>,
    /// Length of the path, mm, and of what may be lit.
    pub length: (f64, f64),
    /// Of a machine with named lasers: each with the length that it may light, mm.
    pub lasers: Vec<(String, f64)>,
    /// The time that the path takes, s, as the controller's look-ahead plans it; none if nobody
    /// asked for it.
    pub seconds: Option<f64>,
}

impl fmt::Display for Extent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let list = |rows: &[(char, f64, f64)]| {
            // Without the sign of what is rounded to 0.
            let mm = |mm: f64| (mm * 1000.0).round() / 1000.0 + 0.0;
            let rows =
                rows.iter().map(|(letter, least, most)| format!("{letter} {:.3} to {:.3}", mm(*least), mm(*most)));
            rows.collect::<Vec<_>>().join(", ")
        };
        if self.all.is_empty() {
            write!(f, "no motion; ")?;
        } else {
            write!(f, "path of {:.3} mm, {} mm; ", self.length.0, list(&self.all))?;
        }
        match self.marks[..] {
            [] => write!(f, "no marks")?,
            _ => write!(f, "marks of {:.3} mm, {} mm", self.length.1, list(&self.marks))?,
        }
        let lasers = self.lasers.iter().filter(|_| !self.marks.is_empty());
        for (place, (name, length)) in lasers.enumerate() {
            write!(f, "{} laser {name} {length:.3} mm", if place == 0 { ":" } else { "," })?;
        }
        match self.seconds {
            None => Ok(()),
            Some(seconds) if seconds < 120.0 => write!(f, "; about {seconds:.1} s"),
            Some(seconds) if seconds < 7200.0 => write!(f, "; about {:.1} min", seconds / 60.0),
            Some(seconds) => write!(f, "; about {:.1} h", seconds / 3600.0),
        }
    }
}
