//! How much the thread holds of what waits; no manual fixes it, and whoever sends more waits for room.
//!
//! The feature `small` is for a chip whose own RAM is nearly taken up by the capacity that SPEC 11 asks for.

/// Where RAM is plenty.
#[cfg(not(feature = "small"))]
mod sizes {
    /// Entries that a look-ahead holds.
    pub const LOOK_AHEAD: usize = 256;
    /// Messages under way each way.
    pub const LINK_WINDOW: usize = 8;
    /// Bytes of the queue of a program's records.
    pub const QUEUE_BYTES: usize = 8192;
    /// Replies of a program that wait for the execution of their entries. As many records of data may stand before
    /// the start of their stream.
    pub const AWAITING: usize = 1024;
    /// Values of Calculate commands that wait with them: two full tables.
    pub const VALUES: usize = 2048;
}

/// Beside SPEC 11's capacity in 1 MiB.
#[cfg(feature = "small")]
mod sizes {
    /// Entries that a look-ahead holds.
    pub const LOOK_AHEAD: usize = 16;
    /// Messages under way each way.
    pub const LINK_WINDOW: usize = 2;
    /// Bytes of the queue of a program's records.
    pub const QUEUE_BYTES: usize = 2048;
    /// Replies of a program that wait for the execution of their entries. As many records of data may stand before
    /// the start of their stream.
    pub const AWAITING: usize = 110;
    /// Values of Calculate commands that wait with them: two messages full.
    pub const VALUES: usize = 128;
}

pub use sizes::*;
