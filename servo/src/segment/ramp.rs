//! Jog, Trap and Stop as sequences of pieces.
//!
//! In: a position and velocity at an instant, targets, admitted [`Speed`]s and [`Accel`]s
//! (`rate.rs`). Out: pieces (`evaluator.rs`). A motion is a sequence of at most four phases (ramps
//! and cruises), closed forms of the time since it began, so nothing depends on the tick. A phase
//! is computed when it is entered; knots between phases are [`Exact`](crate::units::Exact). A
//! Trap's last phase goes from wherever it begins to the target, so it ends there exactly. What a
//! Trap can reach is decided in `trapezoid.rs`.
//!
//! A ramp of duration L with edges E: the acceleration rises for E, holds at Δv/(L − E), falls for
//! E; it covers (v0 + v1)/2·L whatever E is. Jog's `smooth` is E = L·smooth/2 with L = Δv/acc (the
//! Percent shape); Trap's smooth time w is the moving average of that length: L = Δv/acc + w, E the
//! lesser of w and Δv/acc, and the acceleration stays within acc.
mod evaluator;
mod rate;
mod trapezoid;

pub use evaluator::{Moving, RampRun};
pub use rate::{Accel, Refused, Speed};
pub use trapezoid::Trapezoid;
