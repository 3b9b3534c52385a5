#![no_std]
#![forbid(unsafe_code)]
//! Everything that runs in the thread: the same code in the firmware image and on the virtual
//! board.
//!
//! In: bytes from the wire, the tick's view, events and samples. Out: bytes to the wire, admitted
//! tick commands into the two lanes of the tick, segments into the axes' stores, a trace stream.
//! Owns: the host link's end, the shadow state, the program queue, the replies that wait.
//! Sans-IO: time is an argument, no call blocks, the work of a [`Server::poll`] is bounded.
//! Fails: bad input from the wire is answered with a return code and a reason, and changes nothing.
//! Nothing in here panics or allocates.
//!
//! Folders: `session` calls `program` and `admit`, `program` calls `admit`. `admit` uses `report`,
//! `shadow` and `plan`, `report` uses `shadow` and `plan`, `shadow` uses `plan`. No arrow goes
//! back.
mod admit;
mod board;
mod bounded_vec;
mod capacity;
mod configuration;
mod io_words;
pub mod plan;
mod product;
mod program;
mod refuse;
mod report;
mod session;
mod shadow;
#[cfg(feature = "test-hooks")]
mod test_hooks;
mod tick_queue;

pub use crate::board::{
    BoardConstants, FAULT_TEXT_MAX, Fault, FaultKind, Stack, TICK_BUCKET_NS, TICK_BUCKETS, TickTime,
};
pub use crate::plan::path_queue::{LOOK_AHEAD_MOTIONS, PathQueue};
pub use crate::product::{FAMILIES, PROFILES, ProductProfile, largest_that_fits};
pub use crate::program::record_queue::{QUEUE_BYTES, RECORD_BYTES};
pub use crate::refuse::Refused;
pub use crate::session::second_client::SecondaryTransport;
pub use crate::session::server::{
    EVENTS, IMMEDIATE_ENTRIES, LINK_WINDOW, PROGRAM_ENTRIES, SEGMENTS, Server, TRACE_SAMPLES, ThreadHalves,
};
