//! Motions of a path: entered, planned, made ahead.
//!
//! In: the entry of a motion, where and how fast it begins, what stands behind it. Out: the motion in force with its
//! plan. Owns nothing beyond the [`Path`]. Cannot fail. A motion that was made ahead is the one that would have been
//! made on its boundary: the same functions of the same numbers.
use super::{Ahead, Behind, EFFECTS, Feed, Path, Rules, Stage, end_of};
use crate::path::entry::{Along, Item};
use crate::path::plan::{Means, Plan};
use crate::path::shape::{Along as Geared, Shape};
use crate::path::store::Entries;
use crate::path::{DIMENSIONS, Fine};
use crate::real::Real;
use crate::units::{Exact, Pos};

impl Path {
    /// Takes up a motion that begins, or began, at `from`.
    pub(super) fn enter(&mut self, from: [Pos; DIMENSIONS], counter: u32, item: &Item) {
        if let Some(Ahead { along, shape, .. }) = self.shaped(from, counter, item) {
            (self.along, self.shape) = (along, shape);
            self.set_in(from);
        }
    }

    /// The geometry of a motion, and nothing of its speed yet.
    fn shaped(&self, from: [Pos; DIMENSIONS], counter: u32, item: &Item) -> Option<Ahead> {
        let (Item::Line { along, .. } | Item::Arc { along, .. } | Item::Circle { along, .. }) = *item else {
            return None;
        };
        // FIFO 1 comes back to where it interrupted FIFO 0, which need not be a whole pulse.
        let [first, _] = &self.cursors;
        let exact = (self.fifo != 0 && first.kept).then_some(first.place);
        Some(Ahead { counter, along, shape: Shape::new(from, item, exact), plan: None })
    }

    /// The motion in force has begun at `from`.
    fn set_in(&mut self, from: [Pos; DIMENSIONS]) {
        let length = self.shape.length();
        let cursor = self.cursor(self.fifo);
        (cursor.inside, cursor.from) = (true, from);
        if cursor.geared == 0 {
            return;
        }
        let inverse = length.recip();
        for gear in cursor.gears.iter_mut().take(cursor.geared) {
            gear.along = Geared::over(gear.pulses, inverse);
        }
    }

    /// Takes up the motion that was made ahead.
    pub(super) fn enter_prepared(&mut self, feed: Feed, source: &impl Entries) {
        let Some(Ahead { along, shape, plan, .. }) = self.ahead.take() else { return };
        (self.along, self.shape, self.way) = (along, shape, Exact(0));
        self.set_in(self.here);
        match plan {
            _ if self.shape.length().is_zero() => {}
            // What has come since may stand behind it.
            Some((plan, open)) if open.is_none_or(|seen| seen == end_of(feed, self.fifo)) => self.follow(plan, open),
            _ => self.plan_rest(feed, source),
        }
    }

    /// Nothing is left to be made ahead.
    pub(super) fn is_prepared(&self) -> bool {
        self.ahead.as_ref().is_some_and(|ahead| ahead.plan.is_some() || ahead.shape.length().is_zero())
    }

    /// Makes some of the motion behind the one in force: its geometry, and in another tick its plan.
    #[inline(never)]
    pub(super) fn prepare(&mut self, feed: Feed, source: &impl Entries) {
        if self.stopping || self.plan.halts {
            return;
        }
        if let Some(ahead) = &self.ahead {
            let behind = self.behind(ahead.counter.wrapping_add(1), feed, source);
            let plan = self.planned(ahead.along, self.plan.exit, ahead.shape.length(), behind);
            let open = (behind == Behind::Nothing).then_some(end_of(feed, self.fifo));
            if let Some(ahead) = &mut self.ahead {
                ahead.plan = Some((plan, open));
            }
            return;
        }
        let end = end_of(feed, self.fifo);
        let mut counter = self.cursor_of(self.fifo).next;
        for _ in 0..=EFFECTS {
            if counter == end {
                return;
            }
            let entry = source.entry(self.fifo, counter);
            if entry.is_motion() {
                self.ahead = self.shaped(self.shape.end(), counter, &entry.item());
                return;
            }
            if entry.is_wait() {
                return;
            }
            counter = counter.wrapping_add(1);
        }
    }

    /// Plans a motion, or what is left of it.
    fn planned(&self, along: Along, speed: Real, length: Real, behind: Behind) -> Plan {
        let Rules { even, stop, rate } = self.rules;
        let vel = along.vel().mul(rate);
        let end = match behind {
            Behind::Motion => along.end(),
            Behind::Halt | Behind::Nothing => Real::ZERO,
        };
        let end = if vel.is_less(end) { vel } else { end };
        let means = Means { vel, acc: along.acc(), end, even, stop: self.stopping.then_some(stop) };
        Plan::new(speed, length, &means)
    }

    /// Plans what is left of the motion in force from `time`, `way` and `speed`.
    pub(super) fn plan_rest(&mut self, feed: Feed, source: &impl Entries) {
        let behind = self.behind(self.cursor_of(self.fifo).next, feed, source);
        let left = self.shape.length().sub(Real::from_exact(self.way));
        let plan = self.planned(self.along, self.speed, left, behind);
        self.follow(plan, (behind == Behind::Nothing).then_some(end_of(feed, self.fifo)));
    }

    /// Goes along the motion in force by a plan that begins now. The next motion will be entered at another speed.
    fn follow(&mut self, plan: Plan, open: Option<u32>) {
        (self.plan, self.open) = (plan, open);
        (self.leg, self.began, self.piece, self.stage) = (0, self.time, None, Stage::Move);
        self.set_due();
        if let Some(ahead) = &mut self.ahead {
            ahead.plan = None;
        }
    }

    /// What stands behind a motion, from this entry on.
    fn behind(&self, mut counter: u32, feed: Feed, source: &impl Entries) -> Behind {
        let end = end_of(feed, self.fifo);
        for _ in 0..=EFFECTS {
            if counter == end {
                return Behind::Nothing;
            }
            let entry = source.entry(self.fifo, counter);
            if entry.is_motion() {
                return Behind::Motion;
            }
            if entry.is_wait() {
                return Behind::Halt;
            }
            counter = counter.wrapping_add(1);
        }
        Behind::Halt
    }

    /// Entries have come while nothing stood behind the motion in force.
    #[inline(never)]
    pub(super) fn extend(&mut self, now: Fine, feed: Feed, source: &impl Entries) {
        if self.behind(self.cursor_of(self.fifo).next, feed, source) == Behind::Motion {
            self.catch_up(now);
            self.plan_rest(feed, source);
        } else {
            self.open = Some(end_of(feed, self.fifo));
        }
    }

    /// Time, way and speed are those of `now`, which lies in the leg in force or at its end.
    pub(super) fn catch_up(&mut self, now: Fine) {
        let Some(leg) = self.plan.leg(self.leg) else { return };
        let since = now.saturating_sub(self.began).min(leg.time);
        self.way = Exact(self.way.0.wrapping_add(leg.way(since).0));
        (self.speed, self.time) = (leg.speed(since), self.began.wrapping_add(since));
        self.began = self.time;
    }
}
