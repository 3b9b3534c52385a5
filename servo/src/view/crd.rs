//! What the tick publishes of a coordinate system.
use super::StopReason;
use crate::path::axis_map::AxisMap;
use crate::path::{Curvature, DIMENSIONS, PathPos, PathStop};
use crate::segment::piece::{Motion, Scaled};
use crate::units::{Crd, Pos};

state! {
    /// One coordinate system in one tick.
    #[derive(Debug, Clone, Copy)]
    pub struct CrdView {
        /// Counts changes of anything here; a reader skips what did not change.
        pub version: u32 = 0,
        /// Counts changes of the fields that are no position on the path: `frame`, `cleared`,
        /// `rest`, `stop`, `ends`.
        pub state_version: u32 = 0,
        /// Counts changes of `bend`, of `motion` except for the position in it, of `fifo`,
        /// `released` and `done`.
        pub piece_version: u32 = 0,
        /// Coordinates: the planned positions of its axes less the origin.
        pub position: PathPos = [Pos(0); DIMENSIONS],
        /// Direction of motion, a unit vector in 2⁻³⁰; zeros where it does not move.
        pub heading: [i32; DIMENSIONS] = [0; DIMENSIONS],
        /// How the direction turns.
        pub bend: Curvature = Curvature::STRAIGHT,
        /// The path length along the motion in force as a piece: its velocity is the path's.
        pub motion: Motion = Motion::STANDSTILL,
        /// It has been started and is not at standstill; it also runs while it waits, or has speed
        /// 0 at a corner.
        pub runs: bool = false,
        /// FIFO in force, or that was last.
        pub fifo: u8 = 0,
        /// Entries of each FIFO that are over, counted since it was cleared; their slots are free.
        pub released: [u32; 2] = [0; 2],
        /// Motions of each FIFO completed since it was cleared.
        pub done: [u32; 2] = [0; 2],
        /// Entries of each FIFO that are committed, counted since it was cleared.
        pub ends: [u32; 2] = [0; 2],
        /// Times that each FIFO was cleared (CrdFrame, CrdClear, Reset).
        pub cleared: [u32; 2] = [0; 2],
        /// The axes that it drives, and its zero; none before SetCrdPrm.
        pub frame: Option<AxisMap> = None,
        /// The planned positions of its axes at its zero.
        pub origin: PathPos = [Pos(0); DIMENSIONS],
        /// How the path came to standstill last; `Stopped`: CrdStart goes on with the same FIFO.
        pub path_stop: PathStop = PathStop::Never,
        /// Why.
        pub stop: StopReason = StopReason::None,
    }
    /// At power-on.
    pub const POWER_ON;
}

impl CrdView {
    /// Becomes a copy of `now`; only what its counters mark as changed is copied.
    #[inline(always)]
    pub(crate) fn copy_changed(&mut self, now: &CrdView) {
        if self.version == now.version {
            return;
        }
        if self.state_version != now.state_version {
            self.follow_changes(now);
        }
        if self.piece_version != now.piece_version {
            (self.piece_version, self.bend, self.motion) = (now.piece_version, now.bend, now.motion);
            (self.fifo, self.released, self.done) = (now.fifo, now.released, now.done);
        } else {
            (self.motion.tau, self.motion.t) = (now.motion.tau, now.motion.t);
        }
        (self.version, self.position, self.heading) = (now.version, now.position, now.heading);
    }

    /// Field by field, at a third of the cost of a call of memcpy; what `piece_version` counts
    /// comes with the rest.
    #[inline(never)]
    fn follow_changes(&mut self, now: &CrdView) {
        (self.state_version, self.piece_version) = (now.state_version, now.piece_version.wrapping_sub(1));
        (self.runs, self.path_stop, self.stop) = (now.runs, now.path_stop, now.stop);
        (self.ends, self.cleared) = (now.ends, now.cleared);
        (self.frame, self.origin) = (now.frame, now.origin);
    }

    /// Nothing is driven any more, FIFOs are empty; the last stop reason stays.
    pub(crate) fn drop_frame(&mut self) {
        let on = &CrdView::POWER_ON;
        self.cleared = self.cleared.map(|count| count.wrapping_add(1));
        (self.piece_version, self.position, self.heading) = (on.piece_version, on.position, on.heading);
        (self.bend, self.motion, self.runs, self.fifo) = (on.bend, on.motion, on.runs, on.fifo);
        (self.released, self.done, self.ends) = (on.released, on.done, on.ends);
        (self.frame, self.origin, self.path_stop) = (on.frame, on.origin, on.path_stop);
    }
}

/// How a coordinate system moves an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DrivenBy {
    /// The axis is one of its coordinates.
    Coordinate {
        /// Whose.
        crd: Crd,
        /// Which, X is 0.
        index: u8,
    },
    /// BufGear: the axis is geared to the path.
    Gear {
        /// Whose.
        crd: Crd,
        /// Its displacement per path length.
        ratio: Scaled,
    },
}

impl DrivenBy {
    /// The coordinate system.
    pub fn crd(self) -> Crd {
        match self {
            DrivenBy::Coordinate { crd, .. } | DrivenBy::Gear { crd, .. } => crd,
        }
    }
}
