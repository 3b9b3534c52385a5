//! Coordinate systems: axes driven together along a path (SPEC 5, "Coordinate systems").
//!
//! In: admitted [`PathEntry`]s of 32 bytes from two FIFOs, instants. Out: a [`PathReport`] a tick,
//! and the effects of entries (outputs, laser, other axes), each with the exact instant of its
//! position in the path. A [`Path`] keeps one period ahead: the step for the tick at `t` gives the
//! position there and carries out all boundaries before `t + period`. So an edge inside the coming
//! interval is known in time and does not depend on the period. Instants are [`FineNs`], positions
//! of boundaries exact. A phase's speed is a closed form of the time since it began
//! (`speed_profile.rs`); its position on the line or arc is a closed form of the path length
//! (`geometry.rs`).
use crate::units::{FineNs, Pos};
pub mod axis_map;
mod entry;
mod evaluator;
mod geometry;
mod pack;
mod path_speed;
mod speed_profile;
mod store;

pub use entry::{EntryContent, EntryEffect, FixedRamp, LASER_WORDS, MotionSpeeds, PathEntry, Plane, Refused, Sweep};
pub(crate) use evaluator::INSTANTS;
pub use evaluator::{
    EFFECTS, Effects, FeedOverride, FifoEnds, GEARS, Path, PathReport, PathSettings, PathStop, StepReport,
    TrajectorySample,
};
pub use geometry::Curvature;
pub use path_speed::PathSpeed;
pub use store::{ENTRIES, EntryStore, PathEntries, PathStores};

/// How long a path waits for what cannot be done; it is stopped in the same tick.
pub(crate) const ENDLESS_WAIT_FINE_NS: FineNs = 1 << 80;

/// Coordinates of a coordinate system: X, Y, Z, A.
pub const DIMENSIONS: usize = 4;
/// A position on a path: that of each coordinate.
pub type PathPos = [Pos; DIMENSIONS];
