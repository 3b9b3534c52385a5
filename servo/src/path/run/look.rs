//! Where a path is at a tick.
//!
//! In: the motion in force, with all boundaries up to the tick passed. Out: place, direction and speed; what the
//! coordinates did since the look before. Owns nothing beyond the [`Path`]. Fails: a place that is not admitted ends the
//! motion before it.
use super::told::{Effects, Feed, Rest, Sight};
use super::{Path, Stage};
use crate::laser::PathSpeed;
use crate::path::shape::Bend;
use crate::path::{DIMENSIONS, Fine};
use crate::piece::Motion;
use crate::units::{Exact, Ns, Pos};

impl Path {
    /// Where it is at `next`, which lies in the leg in force; whether it moves.
    #[inline(always)]
    pub(super) fn look(&mut self, next: Ns, sink: &mut impl Effects, sight: &mut Sight<'_>) -> bool {
        (self.seen, self.swept) = (Pos(0), None);
        if let Stage::Move = self.stage
            && let Some(leg) = self.motions[(self.at & 1) as usize].plan.leg(self.leg)
        {
            let piece = &mut self.pieces[(self.piece & 1) as usize];
            if !self.pieced {
                (self.pieced, self.fresh) = (true, true);
                *piece = leg.piece(self.began, self.way);
            }
            let before = *sight.heading;
            let shape = &self.motions[(self.at & 1) as usize].shape;
            if self.fresh {
                self.fresh = false;
                *sight.motion = piece.motion;
                *sight.turns = sight.turns.wrapping_add(1);
                shape.show(sight.place, sight.heading, sight.bend);
            }
            let (way, tau) = piece.at(piece.held(next));
            (self.seen, sight.motion.tau) = (way, tau);
            shape.follow(way, sight.place, sight.heading);
            if self.led {
                self.leave_wake(before, sight.heading);
            }
            let cursor = self.cursor_of(self.fifo);
            for gear in cursor.gears.iter().take(cursor.geared) {
                sink.gear(gear.axis, gear.along.at(way), gear.along.ratio());
            }
            return true;
        }
        if self.led {
            (self.wake, self.since.count) = (self.since, 0);
        }
        if self.fresh {
            self.fresh = false;
            *sight.turns = sight.turns.wrapping_add(1);
            (*sight.place, *sight.heading) = (self.here, [0; DIMENSIONS]);
            (*sight.bend, *sight.motion) = (Bend::STRAIGHT, Motion::REST);
        }
        false
    }

    /// What the coordinates have done up to this look, at which they go in this direction.
    #[inline(never)]
    fn leave_wake(&mut self, before: [i32; DIMENSIONS], heading: &[i32; DIMENSIONS]) {
        (self.wake, self.since.count) = (self.since, 0);
        let shape = &self.motions[(self.at & 1) as usize].shape;
        let still = before == [0; DIMENSIONS];
        let before = if self.wake.count != 0 || still { shape.outset() } else { before };
        for (index, ((turn, before), now)) in self.wake.turns.iter_mut().zip(before).zip(heading).enumerate() {
            let turned = before > 0 && *now < 0 || before < 0 && *now > 0;
            let (gone, left) = (before.unsigned_abs() as u64, now.unsigned_abs() as u64);
            // Near its summit a coordinate's direction changes evenly with the way.
            *turn = shape.summit(index, before > 0).filter(|_| turned).map(|summit| {
                let whole = gone.wrapping_add(left);
                (crate::wide::Recip::of(whole).ratio(gone.min(whole.wrapping_sub(1))), summit)
            });
        }
    }

    /// The motion in force must not go as far as `way`, where it is or would be at `at`: it comes to rest before.
    #[inline(never)]
    pub(super) fn hold(&mut self, at: Fine, way: Exact, sink: &mut impl Effects, feed: Feed) {
        // The furthest place since the last look that is admitted, to 2⁻¹⁶ of that way; where it was then if none is.
        let (mut low, mut high) = (self.floor, way);
        for _ in 0..16 {
            let middle = Exact(low.0.wrapping_add(high.0) >> 1);
            if sink.admits(&self.motion().shape.at(middle.round())) { low = middle } else { high = middle }
        }
        self.way = low;
        self.halt(at, Rest::Obstructed, feed, sink);
    }

    /// The mean speed of the interval of `period` from `next` on, of which `motion` was shown: what the laser's power
    /// follows.
    pub fn mean(&self, motion: &Motion, next: Ns, period: Ns) -> PathSpeed {
        let Some(swept) = self.swept else { return PathSpeed::ahead(motion, period) };
        let mut way = swept.0;
        if let Stage::Move = self.stage
            && let Some(leg) = self.motion().plan.leg(self.leg)
        {
            let until = (next.0.wrapping_add(period.0) as Fine) << 32;
            way = way.wrapping_add(leg.way(until.saturating_sub(self.began)).0);
        }
        PathSpeed::mean(Exact(way), period)
    }
}
