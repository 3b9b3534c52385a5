#![no_std]
#![forbid(unsafe_code)]
#![allow(clippy::new_without_default, reason = "what lies in a static begins with a const fn")]
//! Everything that runs inside the servo tick.
//!
//! In: admitted commands ([`tick_command::TickCommand`]) from two lanes, input samples from a
//! [`port::Port`].
//! Out: set-points to the port, a [`view::View`] for the thread, samples for a trace.
//! Nothing here divides by a variable, uses floating point, waits, logs or panics.
#[macro_use]
mod state;

mod axis;
mod capacity;
mod edge_counts;
pub mod math;
pub mod output;
pub mod segment;
pub use capacity::Fifos;
pub use edge_counts::EdgeCounts;
pub mod laser;
pub mod path;
pub mod port;
pub mod status;
pub mod tables;
#[cfg(feature = "test-hooks")]
pub mod test_hooks;
pub mod tick;
pub mod tick_command;
mod trace;
pub mod units;
pub mod view;
