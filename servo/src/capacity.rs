//! How much a build holds of what no manual fixes: queues between thread and tick, and what only
//! larger products have.

/// For a chip whose own RAM is nearly taken up by the capacity that SPEC 11 asks for: one core with
/// two coordinate systems.
const SMALL: bool = cfg!(feature = "small");

/// Entries of the immediate lane's ring.
pub const IMMEDIATE_ENTRIES: usize = if SMALL { 16 } else { 128 };
/// Entries of the program lane's ring.
pub const PROGRAM_ENTRIES: usize = if SMALL { 64 } else { 256 };
/// Trace samples between two looks of the thread.
pub const TRACE_SAMPLES: usize = if SMALL { 32 } else { 1024 };
/// PVT tables of a controller: 32 for each core.
pub const TABLES: usize = if SMALL { 32 } else { 64 };
/// Coordinate systems: two, or four for each of two cores.
pub const CRDS: usize = if SMALL { 2 } else { 8 };
/// Gate edges of a laser channel that may be pending: 64 marks or 128 inside the longest delay (65
/// ms).
pub const GATE_EDGES: usize = if SMALL { 128 } else { 256 };

/// Axes whose inputs' edges are counted: all that a build has.
pub const COUNTED_AXES: usize = if SMALL { 8 } else { 48 };

/// Words of bits: of general inputs and outputs (bit 0 is GPI 1, GPO 1), of FIFOs of coordinate
/// systems.
#[cfg(not(feature = "small"))]
mod words {
    /// A bit for each general input.
    pub type GeneralInputs = u128;
    /// A bit for each general output.
    pub type GeneralOutputs = u64;
    /// A bit for each FIFO of each coordinate system.
    pub type Fifos = u16;
}

/// The same.
#[cfg(feature = "small")]
mod words {
    /// A bit for each general input.
    pub type GeneralInputs = u32;
    /// A bit for each general output.
    pub type GeneralOutputs = u32;
    /// A bit for each FIFO of each coordinate system.
    pub type Fifos = u8;
}

pub use words::*;
