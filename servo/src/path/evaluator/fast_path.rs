//! What the fast path of a tick may do.
//!
//! In: the path after a full step. Out: whether the next ticks only publish the position, and
//! whether the end of the phase in force only changes an index. Owns nothing beyond the [`Path`].
//! Cannot fail.
use super::{MotionPosition, Path, PathStage, Preparation, Prepared};
use crate::path::PathPos;

/// What happens at the end of the phase in force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FastPathCase {
    /// More than the fast path does.
    Else,
    /// The piece of the next phase comes into force.
    Phase,
    /// The next motion does, which is prepared, with its first piece.
    Motion,
}

impl Path {
    /// The fast path is not taken until a full step is done.
    pub(crate) fn leave_fast_path(&mut self) {
        (self.fast.publishes, self.fast.at_phase_end) = (false, FastPathCase::Else);
    }

    /// Whether the fast path enters another motion at the end of the phase in force.
    #[inline(always)]
    pub(crate) fn turns_over(&self) -> bool {
        self.fast.at_phase_end == FastPathCase::Motion
    }

    /// Two corners of a box that holds the motion in force, or the one that is `ahead`.
    pub(crate) fn hull(&self, ahead: bool) -> [PathPos; 2] {
        if ahead { self.motions.next() } else { self.motions.now() }.shape.hull()
    }

    /// Decides what the fast path may do from now on, until the next full step.
    #[inline(never)]
    pub(super) fn decide_fast_path(&mut self) {
        let moves = matches!(self.stage, PathStage::Move) && !self.has_slaves;
        let cursor = self.cursor_of(self.fifo);
        let (alone, next) = (cursor.geared == 0, cursor.next);
        self.fast.publishes = moves && self.pieces.made && alone;
        let (Prepared { plan, .. }, Prepared { counter, state, plan: next_plan, .. }) =
            (self.motions.now(), self.motions.next());
        self.fast.at_phase_end = if !moves || self.pieces.follows != Some(self.motion_position.over) {
            FastPathCase::Else
        } else if plan.phase(self.motion_position.phase.wrapping_add(1)).is_some() {
            FastPathCase::Phase
        } else if alone && !plan.halts && !self.stopping && *state == Preparation::Ready && *counter == next {
            let (began, time) = (self.motion_position.over, next_plan.phase(0).map_or(0, |phase| phase.time));
            self.next_position = MotionPosition { began, over: began.wrapping_add(time), ..MotionPosition::NONE };
            FastPathCase::Motion
        } else {
            FastPathCase::Else
        };
    }
}
