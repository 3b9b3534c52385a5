//! Where a path is at a tick.
//!
//! In: the motion in force, with all boundaries up to the tick passed. Out: place, direction and speed; what the
//! coordinates did since the look before. Owns nothing beyond the [`Path`]. Fails: a place that is not admitted ends the
//! motion before it.
use super::told::{Effects, Feed, Rest, Sight};
use super::{Path, Stage, Stretch};
use crate::laser::PathSpeed;
use crate::path::shape::Bend;
use crate::path::{DIMENSIONS, Fine};
use crate::piece::Motion;
use crate::units::{Exact, Ns, Pos};

impl Path {
    /// Where it is at `next`, which lies in the leg in force; whether it moves.
    #[inline(always)]
    pub(super) fn look(&mut self, next: Ns, sink: &mut impl Effects, sight: &mut Sight<'_>) -> bool {
        if let Stage::Move = self.stage
            && let Some(leg) = self.motions[(self.at & 1) as usize].plan.leg(self.stand.leg)
        {
            if !self.pieced {
                (self.pieced, self.fresh) = (true, true);
                self.pieces[(self.piece & 1) as usize].make(leg, self.stand.began, self.stand.way);
            }
            let before = *sight.heading;
            let way = self.show(next, sight);
            self.pass(way);
            if self.led {
                self.leave_wake(before, sight.heading);
            }
            let cursor = self.cursor_of(self.fifo);
            for gear in cursor.gears.iter().take(cursor.geared) {
                sink.gear(gear.axis, gear.along.at(way), gear.along.ratio());
            }
            return true;
        }
        self.pass(Pos(0));
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

    /// Place and direction at `next`, in the piece in force; the way there.
    #[inline(always)]
    fn show(&mut self, next: Ns, sight: &mut Sight<'_>) -> Pos {
        let Stretch { piece, .. } = &self.pieces[(self.piece & 1) as usize];
        let t = piece.near_time(next).map_or_else(|| piece.held(next), |t| t as u64);
        self.show_fresh(sight);
        self.show_at(t, sight)
    }

    /// What is the same all along the piece in force, if it has not been shown yet; whether that was so.
    #[inline(always)]
    pub(crate) fn show_fresh(&mut self, sight: &mut Sight<'_>) -> bool {
        let fresh = self.fresh;
        if fresh {
            self.fresh = false;
            *sight.motion = self.pieces[(self.piece & 1) as usize].piece.motion;
            *sight.turns = sight.turns.wrapping_add(1);
            let shape = &self.motions[(self.at & 1) as usize].shape;
            shape.show(sight.place, sight.heading, sight.bend);
        }
        fresh
    }

    /// How many entries and motions of the FIFO in force are over.
    #[inline(always)]
    pub(crate) fn counts(&self) -> [u32; 2] {
        let cursor = &self.cursors[(self.fifo & 1) as usize];
        [cursor.released(), cursor.done]
    }

    /// The rest, at this time since the begin of the piece; the way there.
    #[inline(always)]
    pub(crate) fn show_at(&self, t: u64, sight: &mut Sight<'_>) -> Pos {
        let Stretch { even, piece } = &self.pieces[(self.piece & 1) as usize];
        let way = if piece.is_near() {
            // Readers make the parameter of it.
            sight.motion.t = t as u32;
            match even {
                Some(_) => piece.pos_even(t as u32),
                None => piece.pos_near(t as u32),
            }
        } else {
            let (way, tau) = piece.at_wide(t);
            sight.motion.tau = tau;
            way
        };
        let shape = &self.motions[(self.at & 1) as usize].shape;
        shape.follow(way, sight.place, sight.heading);
        way
    }

    /// The same, if that is all there is to do at `next`: it is within a leg, no data has come where none was, nobody goes
    /// along or follows a coordinate. Whoever finds that the path may be there says so to [`Path::pass`].
    #[inline(always)]
    pub fn glide(&mut self, next: Ns, feed: Feed, sight: &mut Sight<'_>) -> Option<Pos> {
        if !self.may_glide(feed) {
            return None;
        }
        let t = self.spot(next)?;
        self.show_fresh(sight);
        Some(self.show_at(t, sight))
    }

    /// Whether that may be all there is to do.
    #[inline(always)]
    pub(crate) fn may_glide(&self, feed: Feed) -> bool {
        self.glides && !self.has_news(feed)
    }

    /// Whether the leg in force is over at `next`, which its piece does not hold.
    #[inline(always)]
    pub(crate) fn is_over(&self, next: Ns) -> bool {
        // Both end with the same ns, and no piece begins behind the tick that is computed.
        self.pieces[(self.piece & 1) as usize].piece.is_near() || self.is_due(next)
    }

    /// The time since the begin of the piece in force, if it holds `next`.
    #[inline(always)]
    pub(crate) fn spot(&self, next: Ns) -> Option<u64> {
        let Stretch { piece, .. } = &self.pieces[(self.piece & 1) as usize];
        match piece.near_time(next) {
            Some(t) => Some(t as u64),
            None if piece.is_near() || piece.elapsed(next) >= piece.span => None,
            None => Some(piece.elapsed(next)),
        }
    }

    /// It is `way` along the motion in force.
    #[inline(always)]
    pub fn pass(&mut self, way: Pos) {
        (self.stand.seen, self.swept) = (way, None);
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

    /// The motion in force must not go from the first to the second of these ways, where it is or would be at `at`: it
    /// comes to rest between.
    #[inline(never)]
    pub(super) fn hold(&mut self, at: Fine, (low, way): (Exact, Exact), sink: &mut impl Effects, feed: Feed) {
        // The furthest place between that is admitted, to 2⁻¹⁶ of the way; the first if none is.
        let (mut low, mut high) = (low, way);
        for _ in 0..16 {
            let middle = Exact(low.0.wrapping_add(high.0) >> 1);
            if sink.admits(&self.motion().shape.at(middle.round())) { low = middle } else { high = middle }
        }
        self.stand.way = low;
        self.halt(at, Rest::Obstructed, feed, sink);
    }

    /// The mean speed of the interval of `period` from `next` on, of which `motion` was shown: what the laser's power
    /// follows.
    #[inline(always)]
    pub fn mean(&self, motion: &Motion, next: Ns, period: Ns) -> PathSpeed {
        if self.glides
            && self.swept.is_none()
            && let Some(speed) = self.pieces[(self.piece & 1) as usize].even
        {
            return speed;
        }
        self.mean_of(motion, next, period)
    }

    #[inline(never)]
    fn mean_of(&self, motion: &Motion, next: Ns, period: Ns) -> PathSpeed {
        let Some(swept) = self.swept else { return PathSpeed::ahead(motion, period) };
        let mut way = swept.0;
        if let Stage::Move = self.stage
            && let Some(leg) = self.motion().plan.leg(self.stand.leg)
        {
            let until = (next.0.wrapping_add(period.0) as Fine) << 32;
            way = way.wrapping_add(leg.way(until.saturating_sub(self.stand.began)).0);
        }
        PathSpeed::mean(Exact(way), period)
    }
}
