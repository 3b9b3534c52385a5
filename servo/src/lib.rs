#![no_std]
#![forbid(unsafe_code)]
//! Everything that runs inside the servo tick.
//!
//! In: admitted operations ([`op::Op`]) from two lanes, input samples from a [`port::Port`].
//! Out: set-points to the port, a [`view::View`] for the thread, samples for a trace.
//! Nothing here divides by a variable, uses floating point, waits, logs or panics.
mod age;
mod axis;
mod capacity;
pub use capacity::Fifos;
pub mod crd;
mod edges;
mod execute;
pub mod follow;
mod inputs;
pub mod laser;
pub mod op;
pub mod path;
pub mod piece;
pub mod port;
pub mod profile;
pub mod pt;
pub mod pvt;
pub mod ramp;
pub mod real;
mod script;
mod slaves;
pub mod status;
pub mod steps;
pub mod tick;
mod trace;
pub mod units;
pub mod view;
pub mod wide;
mod work;
