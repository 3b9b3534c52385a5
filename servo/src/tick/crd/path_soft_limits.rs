//! The soft limits of a path: those of its axes, and their limit switches and edges of travel.
//!
//! In: the box that holds all of a motion, the positions of a path tick by tick, the limits of the
//! axes. Out: whether the axes may be driven to a position; a [`Clearance`] for each motion, so
//! that most ticks need no comparison. Owns nothing. Cannot fail.
//!
//! | step | where |
//! | --- | --- |
//! | a tick of the fast path asks [`is_free`] unless the motion is clear | `drive.rs` |
//! | the exact test of one position, and the obstacle | `effects.rs`, `Effects::admits` |
//! | the path stops before the position that is not admitted | `path/evaluator/stop.rs`, `Path::hold` |
//! | the limit of the axis is latched, and light shuts off | `drive.rs`, `come_to_standstill` |
//! | what limits an axis | `axis/soft_limits.rs` |
use super::{AxisIndices, CrdState, Crds};
use crate::axis::AxisState;
use crate::path::PathPos;
use crate::units::Pos;

/// Whether a limit may be reached within a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Clearance {
    /// Not checked.
    Unknown,
    /// None does: all of it is well between the limits of its axes, until one of these changes.
    Wide,
    /// Each of its positions has to be checked.
    Narrow,
}

impl CrdState {
    /// Finds the clearance of the motion in force.
    #[inline(never)]
    pub(super) fn find_clearance(&mut self, axes: &[AxisState]) {
        let clearance = self.clearance_of(false, axes);
        let [now, _] = &mut self.clearance;
        *now = clearance;
    }

    /// The clearance of the motion in force, or of the one `ahead`.
    pub(super) fn clearance_of(&self, ahead: bool, axes: &[AxisState]) -> Clearance {
        let (hull, axis_indices, origin) = (self.path.hull(ahead), &self.axis_indices, &self.published.origin);
        let is_clear = |position: &PathPos| {
            axis_indices.all(|index, axis| match (axes.get(axis), position.get(index), origin.get(index)) {
                (Some(axis), Some(at), Some(origin)) => axis.is_clear(Pos(at.0.saturating_add(origin.0))),
                _ => true,
            })
        };
        if hull.iter().all(is_clear) { Clearance::Wide } else { Clearance::Narrow }
    }
}

impl Crds {
    /// Limits of axes have changed.
    pub(crate) fn invalidate_clearance(&mut self) {
        for state in &mut self.states {
            state.clearance = [Clearance::Unknown; 2];
        }
    }
}

/// Whether the axes may be driven to a position without further checks.
#[inline(always)]
pub(super) fn is_free(axis_indices: &AxisIndices, origin: &PathPos, position: &PathPos, axes: &[AxisState]) -> bool {
    axis_indices.all(|index, axis| match (axes.get(axis), position.get(index), origin.get(index)) {
        (Some(axis), Some(at), Some(origin)) => axis.is_free(Pos(at.0.wrapping_add(origin.0))),
        _ => true,
    })
}
