//! The position of a path at a tick.
//!
//! In: the motion in force, with all boundaries up to the tick passed. Out: position, direction and
//! speed; the motion of the coordinates since the sample before. Owns nothing beyond the [`Path`].
//! Fails: a position that is not admitted ends the motion before it.
use super::interface::{Effects, FifoEnds, PathReport, PathStop};
use super::{PackedPhase, Path, PathStage};
use crate::path::geometry::Curvature;
use crate::path::{DIMENSIONS, PathPos, PathSpeed};
use crate::segment::piece::Motion;
use crate::units::{Exact, FineNs, Ns, Pos};

impl Path {
    /// Samples the position at `next`, which lies in the phase in force. Returns whether it moves.
    #[inline(always)]
    pub(super) fn look(&mut self, next: Ns, report: &mut PathReport) -> bool {
        if let PathStage::Move = self.stage
            && let Some(phase) = self.motions.now().plan.phase(self.motion_position.phase)
        {
            if !self.pieces.made {
                (self.pieces.made, self.publish_whole) = (true, true);
                self.pieces.pair.now_mut().make(phase, self.motion_position.began, self.motion_position.distance);
            }
            let before = *report.heading;
            let distance = self.publish(next, report);
            self.pass(distance);
            if self.has_slaves {
                self.keep_trajectory(before, report.heading);
            }
            return true;
        }
        self.pass(Pos(0));
        if self.has_slaves {
            (self.trajectory, self.trajectory_since.count) = (self.trajectory_since, 0);
        }
        if self.publish_whole {
            self.publish_whole = false;
            *report.piece_version = report.piece_version.wrapping_add(1);
            (*report.position, *report.heading) = (self.rest_position, [0; DIMENSIONS]);
            (*report.bend, *report.motion) = (Curvature::STRAIGHT, Motion::STANDSTILL);
        }
        false
    }

    /// Whether it and its geared axes may be at `position`, this path length into the motion in
    /// force.
    #[inline(always)]
    pub(super) fn admits(&self, position: &PathPos, distance: Exact, sink: &mut impl Effects) -> bool {
        sink.admits(position)
            && self.gears_of(self.fifo).all(|gear| sink.admits_gear(gear.axis, gear.along.at(distance)))
    }

    /// The path length at `now`, which the motion in force holds. Rounded as the position is, it
    /// would be too coarse for an axis that is geared up.
    #[inline(never)]
    pub(super) fn distance_at(&self, now: FineNs) -> Exact {
        let gone = self
            .motions
            .now()
            .plan
            .phase(self.motion_position.phase)
            .map_or(0, |phase| phase.distance(now.saturating_sub(self.motion_position.began).min(phase.time)).0);
        Exact(self.motion_position.distance.0.wrapping_add(gone))
    }

    /// The path length at the last sample, as exact as its geared axes know it.
    pub(super) fn sampled(&self, distance: Pos) -> Exact {
        let cursor = self.cursor_of(self.fifo);
        if cursor.geared != 0 && cursor.distance.round() == distance { cursor.distance } else { distance.into() }
    }

    /// Moves the geared axes to where they are at this path length.
    #[inline(always)]
    pub(super) fn carry(&mut self, distance: Exact, sink: &mut impl Effects) {
        for gear in self.gears_of(self.fifo) {
            sink.gear(gear.axis, gear.along.at(distance), gear.along.ratio());
        }
        self.cursor(self.fifo).distance = distance;
    }

    /// Publishes position and direction at `next`, in the piece in force; returns the path length
    /// there.
    #[inline(always)]
    fn publish(&mut self, next: Ns, report: &mut PathReport) -> Pos {
        let PackedPhase { piece, .. } = self.pieces.pair.now();
        let t = piece.fast_time(next).map_or_else(|| piece.elapsed_within(next), |t| t as u64);
        self.publish_fresh(report);
        self.publish_at(t, report)
    }

    /// Publishes what is constant along the piece in force, if that has not been done yet; returns
    /// whether it did.
    #[inline(always)]
    pub(crate) fn publish_fresh(&mut self, report: &mut PathReport) -> bool {
        let fresh = self.publish_whole;
        if fresh {
            self.publish_whole = false;
            *report.motion = self.pieces.pair.now().piece.motion;
            *report.piece_version = report.piece_version.wrapping_add(1);
            let shape = &self.motions.now().shape;
            shape.publish(report.position, report.heading, report.bend);
        }
        fresh
    }

    /// How many entries and motions of the FIFO in force are over.
    #[inline(always)]
    pub(crate) fn counts(&self) -> [u32; 2] {
        let cursor = &self.cursors[(self.fifo & 1) as usize];
        [cursor.released(), cursor.done]
    }

    /// Publishes the rest, at this time since the begin of the piece; returns the path length
    /// there.
    #[inline(always)]
    pub(crate) fn publish_at(&self, t: u64, report: &mut PathReport) -> Pos {
        let PackedPhase { even, piece } = self.pieces.pair.now();
        let distance = if piece.is_fast() {
            // Readers derive the parameter from it.
            report.motion.t = t as u32;
            match even {
                Some(_) => piece.pos_even(t as u32),
                None => piece.pos_fast(t as u32),
            }
        } else {
            let (distance, tau) = piece.at_wide(t);
            report.motion.tau = tau;
            distance
        };
        let shape = &self.motions.now().shape;
        shape.follow(distance, report.position, report.heading);
        distance
    }

    /// Whether nothing else is to be done: it is within a phase, no data has come where the FIFO
    /// had ended, and it has neither geared axes nor slaves. The caller checks whether the path may
    /// be at its next position, and then calls [`Path::pass`].
    #[inline(always)]
    pub(crate) fn may_step_fast(&self, feed: FifoEnds) -> bool {
        self.fast.publishes && !self.has_changed(feed)
    }

    /// Whether the phase in force is over at `next`, which its piece does not hold.
    #[inline(always)]
    pub(crate) fn is_over(&self, next: Ns) -> bool {
        // Both end with the same ns, and no piece begins after the tick that is computed.
        self.pieces.pair.now().piece.is_fast() || self.is_due(next)
    }

    /// The time since the begin of the piece in force, if it holds `next`.
    #[inline(always)]
    pub(crate) fn spot(&self, next: Ns) -> Option<u64> {
        let PackedPhase { piece, .. } = self.pieces.pair.now();
        match piece.fast_time(next) {
            Some(t) => Some(t as u64),
            None if piece.is_fast() || piece.elapsed(next) >= piece.span => None,
            None => Some(piece.elapsed(next)),
        }
    }

    /// It is at the path length `distance` of the motion in force.
    #[inline(always)]
    pub fn pass(&mut self, distance: Pos) {
        (self.motion_position.sampled, self.travelled.length) = (distance, None);
    }

    /// Keeps the motion of the coordinates up to this sample, at which they have this direction.
    #[inline(never)]
    fn keep_trajectory(&mut self, before: [i32; DIMENSIONS], heading: &[i32; DIMENSIONS]) {
        (self.trajectory, self.trajectory_since.count) = (self.trajectory_since, 0);
        let shape = &self.motions.now().shape;
        // A path that sets off with this sample has not turned, also where it goes on within an
        // arc.
        let sets_off = before == [0; DIMENSIONS];
        let before = match self.trajectory.count {
            0 if sets_off => *heading,
            0 => before,
            _ => shape.start_heading(),
        };
        for (index, ((turn, before), now)) in self.trajectory.turns.iter_mut().zip(before).zip(heading).enumerate() {
            let turned = before > 0 && *now < 0 || before < 0 && *now > 0;
            let (gone, left) = (before.unsigned_abs() as u64, now.unsigned_abs() as u64);
            // Near its summit a coordinate's direction changes evenly along the path.
            *turn = shape.extreme(index, before > 0).filter(|_| turned).map(|extreme| {
                let whole = gone.wrapping_add(left);
                (crate::math::wide::Recip::of(whole).ratio(gone.min(whole.wrapping_sub(1))), extreme)
            });
        }
    }

    /// The motion in force must not go from the first of these path lengths to the second, where it
    /// is or would be at `at`: it comes to standstill between.
    #[inline(never)]
    pub(super) fn hold(
        &mut self,
        at: FineNs,
        (low, distance): (Exact, Exact),
        sink: &mut impl Effects,
        feed: FifoEnds,
    ) {
        // The furthest position between that is admitted, to 2⁻¹⁶ of the length; the first if none
        // is.
        let (mut low, mut high) = (low, distance);
        for _ in 0..16 {
            let middle = Exact(low.0.wrapping_add(high.0) >> 1);
            let position = self.motions.now().shape.at(middle.round());
            if self.admits(&position, middle, sink) { low = middle } else { high = middle }
        }
        self.motion_position.distance = low;
        self.halt(at, PathStop::Obstructed, feed, sink);
    }

    /// The mean speed of the interval of `period` from `next` on, with `motion` as published for
    /// it: what the laser's power follows.
    #[inline(always)]
    pub fn mean(&self, motion: &Motion, next: Ns, period: Ns) -> PathSpeed {
        if self.fast.publishes
            && self.travelled.length.is_none()
            && let Some(speed) = self.pieces.pair.now().even
        {
            return speed;
        }
        self.mean_of(motion, next, period)
    }

    #[inline(never)]
    fn mean_of(&self, motion: &Motion, next: Ns, period: Ns) -> PathSpeed {
        let Some(swept) = self.travelled.length else { return PathSpeed::ahead(motion, period) };
        let mut distance = swept.0;
        if let PathStage::Move = self.stage
            && let Some(phase) = self.motions.now().plan.phase(self.motion_position.phase)
        {
            let until = (next.0.wrapping_add(period.0) as FineNs) << 32;
            distance = distance.wrapping_add(phase.distance(until.saturating_sub(self.motion_position.began)).0);
        }
        PathSpeed::mean(Exact(distance), period)
    }
}
