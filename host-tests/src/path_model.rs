//! A coordinate system as SPEC 5 tells it: the second opinion to the path of the tick and to its interpolation, written
//! without looking at them.
//!
//! In: entries as the user gives them, and the instants at which a FIFO is started, stopped, started again or another
//! override comes. Out: a [`Course`]: pieces of constant acceleration along figures, the instant at which each entry
//! was reached, and why and when the coordinate system rested. There is no tick in it.
//!
//! Arithmetic is that of doubles: lengths, speeds and times in ms each with a relative error of a few 10⁻¹⁶, so that
//! an instant within a second is off by less than 10⁻⁴ ns, where an edge may be off by 5 ns.
pub mod course;
pub mod figure;
pub mod speed;

pub use course::{Command, Course, Rest, Why, course};
pub use figure::{Figure, Plane};

/// What SetCrdPrm tells.
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
    Motion(Figure, Rates),
    /// BufDelay, ms.
    Delay(u16),
    /// What takes no time: the number tells which one it is.
    Effect(usize),
}
