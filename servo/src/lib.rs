#![no_std]
#![forbid(unsafe_code)]
//! Everything that runs inside the servo tick.
//!
//! In: admitted operations ([`op::Op`]) from two lanes, input samples from a [`port::Port`].
//! Out: set-points to the port, a [`view::View`] for the thread, samples for a trace.
//! Nothing here divides by a variable, uses floating point, waits, logs or panics.
pub mod op;
pub mod piece;
pub mod port;
pub mod profile;
pub mod pt;
pub mod ramp;
pub mod real;
pub mod steps;
pub mod units;
pub mod view;
pub mod wide;
