//! How much a build holds of what no manual fixes: queues between thread and tick, and what only
//! larger products have.
//!
//! The feature `small` is for a chip whose own RAM is nearly taken up by the capacity that SPEC 11
//! asks for.

/// Where RAM is plenty: every product profile.
#[cfg(not(feature = "small"))]
mod sizes {
    /// Entries of the immediate lane's ring.
    pub const IMMEDIATE: usize = 128;
    /// Entries of the program lane's ring.
    pub const PROGRAM: usize = 256;
    /// Trace samples between two looks of the thread.
    pub const SAMPLES: usize = 1024;
    /// PVT tables of a controller: 32 for each of two cores.
    pub const TABLES: usize = 64;
    /// Coordinate systems: four for each of two cores.
    pub const CRDS: usize = 8;
    /// A bit for each general input, bit 0 is GPI 1.
    pub type GeneralInputs = u128;
    /// A bit for each general output, bit 0 is GPO 1.
    pub type GeneralOutputs = u64;
    /// A bit for each FIFO of each coordinate system.
    pub type Fifos = u16;
    /// Gate edges of a laser channel that may be pending: 128 marks inside the longest delay (65
    /// ms).
    pub const EDGES: usize = 256;
}

/// One core with two coordinate systems.
#[cfg(feature = "small")]
mod sizes {
    /// Entries of the immediate lane's ring.
    pub const IMMEDIATE: usize = 16;
    /// Entries of the program lane's ring.
    pub const PROGRAM: usize = 64;
    /// Trace samples between two looks of the thread.
    pub const SAMPLES: usize = 32;
    /// PVT tables of a controller: 32 for its core.
    pub const TABLES: usize = 32;
    /// Coordinate systems.
    pub const CRDS: usize = 2;
    /// A bit for each general input, bit 0 is GPI 1.
    pub type GeneralInputs = u32;
    /// A bit for each general output, bit 0 is GPO 1.
    pub type GeneralOutputs = u32;
    /// A bit for each FIFO of each coordinate system.
    pub type Fifos = u8;
    /// Gate edges of a laser channel that may be pending: 64 marks inside the longest delay (65
    /// ms).
    pub const EDGES: usize = 128;
}

pub use sizes::*;
