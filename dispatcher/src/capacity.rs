//! Capacities of the thread's queues. No manual fixes them; a client that sends more waits for
//! free entries.

/// For a chip whose own RAM is nearly used up by the capacity of SPEC 11.
const SMALL: bool = cfg!(feature = "small");

/// Motions that a look-ahead plans; the entries between them do not count.
pub const LOOK_AHEAD_MOTIONS: usize = if SMALL { 32 } else { 1024 };
/// Motions of which it keeps steps of its plans: all or none. Boards have no memory for them.
pub const LOOK_AHEAD_STEPS: usize = if cfg!(target_os = "none") { 0 } else { LOOK_AHEAD_MOTIONS };
/// Motions that a look-ahead remembers to tell rounding from a turn.
pub const LOOK_AHEAD_CHORDS: usize = if SMALL { 16 } else { 128 };
/// Messages in flight, in each direction.
pub const LINK_WINDOW: usize = if SMALL { 2 } else { 8 };
/// Bytes of the queue of a program's records.
pub const QUEUE_BYTES: usize = if SMALL { 2048 } else { 8192 };
/// Replies of a program that wait for the execution of their entries. As many records of data may
/// precede the start of their stream.
pub const AWAITING_REPLIES: usize = if SMALL { 104 } else { 1024 };
/// Values of Calculate commands that wait with them: two full messages, or two full tables. A
/// PathMany whose every call is a power that was limited needs 103.
pub const AWAITING_VALUES: usize = if SMALL { 116 } else { 2048 };
