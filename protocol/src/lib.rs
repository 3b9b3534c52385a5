#![no_std]
#![forbid(unsafe_code)]
//! The host link's protocol: bytes in, checked messages out, and back.
//!
//! ```text
//! bytes -> deframe (COBS) -> frame (header, CRC-32) -> link (in order, exactly once)
//!       -> record (commands, replies)
//! ```
//!
//! The trace has its own one-way stream ([`trace`]) over the same [`deframe`] and CRC. Nothing here
//! allocates, waits, reads a clock or can panic on bytes from the wire: every bad byte ends in a
//! counter or in a named refusal. `docs/protocol.md` has the byte tables, and the tests read its
//! vectors.

#[cfg(test)]
extern crate std;

mod class;
pub mod command;
pub mod deframe;
pub mod frame;
mod layout;
pub mod link;
pub mod path_many;
pub mod reason;
pub mod record;
pub mod reserved;
mod schema;
pub mod trace;
pub mod values;
pub mod viewer;

pub use frame::{MAX_PAYLOAD, VERSION};
pub use schema::SCHEMA;

/// Controller or host time in nanoseconds, from any origin; only differences count.
pub type Ns = u64;
