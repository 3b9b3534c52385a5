//! An independent judge of light: where a laser channel must be dark and where it must have light.
//!
//! In: what acted on the channels ([`Fact`]s: calls, boundaries of paths, standstills, causes of
//! SPEC 9), each with the instants between which it happened, and what the outputs did
//! ([`Recorded`]). Out: what differs, in words. It is written from SPEC 6 and 9; it shares nothing
//! with the tick and knows no tick. What SPEC leaves open, or what two events of one instant leave
//! open, is in doubt: neither light nor darkness is asked for there.
//!
//! [`rules`] turns facts into gate commands, [`gate`] turns these into spans of light, [`outputs`]
//! compares.
pub mod fact;
pub mod gate;
pub mod outputs;
pub mod rules;

#[cfg(test)]
mod cases;
#[cfg(test)]
mod wrong_light;

pub use fact::{Channel, Fact, Laser, Settings, What, Why};
pub use gate::{Fpk, Gate, Level, Lit, Timing};
pub use outputs::{Given, Output, Recorded, Switch, compare};
pub use rules::{Judge, Verdict};

/// Controller time in ns.
pub type Ns = i64;
