//! Whether a motion goes on, as the generators of PT, PVT and ramps report it.
use crate::units::Exact;

/// Whether the motion of a generator goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GeneratorState {
    /// It does.
    Running,
    /// It has ended as planned, here.
    Ended {
        /// Where exactly.
        at: Exact,
    },
    /// Dynamic PT: the ring ran dry at speed; the profile stopped here.
    Underrun {
        /// Where exactly.
        at: Exact,
    },
}
