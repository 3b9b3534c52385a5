//! Capacities of the thread's queues. No manual fixes them; a client that sends more waits for
//! room.
//!
//! The feature `small` is for a chip whose own RAM is nearly used up by the capacity of SPEC 11.

/// With plenty of RAM.
#[cfg(not(feature = "small"))]
mod sizes {
    /// Entries that a look-ahead holds.
    pub const LOOK_AHEAD: usize = 256;
    /// Messages in flight, in each direction.
    pub const LINK_WINDOW: usize = 8;
    /// Bytes of the queue of a program's records.
    pub const QUEUE_BYTES: usize = 8192;
    /// Replies of a program that wait for the execution of their entries. As many records of data
    /// may precede the start of their stream.
    pub const AWAITING: usize = 1024;
    /// Values of Calculate commands that wait with them: two full tables.
    pub const VALUES: usize = 2048;
}

/// With SPEC 11's capacity in 1 MiB.
#[cfg(feature = "small")]
mod sizes {
    /// Entries that a look-ahead holds.
    pub const LOOK_AHEAD: usize = 16;
    /// Messages in flight, in each direction.
    pub const LINK_WINDOW: usize = 2;
    /// Bytes of the queue of a program's records.
    pub const QUEUE_BYTES: usize = 2048;
    /// Replies of a program that wait for the execution of their entries. As many records of data
    /// may precede the start of their stream.
    pub const AWAITING: usize = 104;
    /// Values of Calculate commands that wait with them: two full messages. A PathMany whose every
    /// call is a power that was limited needs 103.
    pub const VALUES: usize = 116;
}

pub use sizes::*;
