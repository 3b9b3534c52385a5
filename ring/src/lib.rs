#![no_std]
//! Queues and shared values between the servo tick and the thread: nothing here waits, divides or
//! panics.
//!
//! * [`Ring`]: entries one way, first in, first out, none lost (commands in, events and samples
//!   out).
//! * [`Latest`]: one value that is overwritten, the reader takes the newest (the view of a tick).
//! * [`Store`]: words in slots (PT segments); a slot becomes visible by a number that travels
//!   through a [`Ring`].
//!
//! Owns: the memory between two contexts. Fails: a full ring gives the value back to its pusher.
//! The only pure crate with `unsafe`; each use states why it holds. `models.rs` (loom) and
//! `tests.rs` under Miri check it.
#[cfg(test)]
extern crate std;

mod latest;
mod queue;
mod store;
mod sync;

#[cfg(all(test, loom))]
mod models;
#[cfg(all(test, not(loom)))]
mod tests;

pub use latest::{Latest, Reader, Writer};
pub use queue::{Consumer, Producer, Ring};
pub use store::Store;
