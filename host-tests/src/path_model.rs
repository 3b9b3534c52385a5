//! A coordinate system by SPEC 5: the independent model for the path of the tick and its
//! interpolation, written without their code.
//!
//! In: entries as the user gives them, and the instants of commands: start, Stop, start again,
//! another override. Out: a [`Course`]: pieces of constant acceleration along lines and arcs, the
//! instant at which each entry was reached, and why and when the coordinate system came to
//! standstill. There is no tick in it.
//!
//! Arithmetic is that of doubles: lengths, speeds and times in ms each with a relative error of a
//! few 10⁻¹⁶. So an instant within a second is off by less than 10⁻⁴ ns, while an edge may be off
//! by 5 ns.
pub mod course;
pub mod geometry;
pub mod speed;

pub use course::{Command, Course, Rest, Why, course};
pub use geometry::{Geometry, Plane};

/// The parameters of SetCrdPrm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Greatest speed along the path, pulse/ms.
    pub speed: f64,
    /// Greatest acceleration along the path, pulse/ms².
    pub acc: f64,
    /// Least time at constant speed, ms.
    pub even_ms: f64,
}

/// Speeds of a motion as the user gives them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rates {
    /// synVel, pulse/ms.
    pub speed: f64,
    /// synAcc, pulse/ms².
    pub acc: f64,
    /// velEnd, pulse/ms.
    pub end: f64,
}

/// What lies in a FIFO.
#[derive(Debug, Clone, PartialEq)]
pub enum Entry {
    /// A line or an arc.
    Motion(Geometry, Rates),
    /// BufDelay, ms.
    Delay(u16),
    /// An entry without duration: the number says which one it is.
    Effect(usize),
    /// The same of a laser: after an abrupt Stop that sets the path back before it, it is made
    /// again.
    Laser(usize),
}

impl Entry {
    /// Whether it has no duration.
    pub fn is_effect(&self) -> bool {
        matches!(self, Entry::Effect(_) | Entry::Laser(_))
    }
}
