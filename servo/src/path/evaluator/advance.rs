//! From boundary to boundary: phases, motions, waits, effects, standstill.
//!
//! In: an instant up to which boundaries are passed, entries. Out: the effects of entries, to an
//! [`Effects`]. Owns nothing beyond the [`Path`]. Fails: entries that run out at speed are an
//! underrun, and so is a wait that is reached at speed.
use super::interface::{Effects, FifoEnds, PathStop};
use super::{ActiveGear, FastPathCase, GearMotion, Path, PathStage, Preparation, Prepared, WalkBudget, end_of};
use crate::math::float::Float;
use crate::path::entry::{EntryContent, EntryEffect, PathEntry};
use crate::path::speed_profile::Phase;
use crate::path::store::PathEntries;
use crate::path::{ENDLESS_WAIT_FINE_NS, PathPos};
use crate::units::{Exact, FineNs, Pos};

impl Path {
    /// It waits at its position.
    pub(super) fn wait(&mut self, until: FineNs) {
        (self.stage, self.motion_position.over, self.publish_whole) = (PathStage::Wait { until }, until, true);
    }

    /// The phase in force ends then; a motion without further phases is over now.
    pub(super) fn set_over(&mut self) {
        let left = self.motions.now().plan.phase(self.motion_position.phase).map_or(0, |phase| phase.time);
        self.motion_position.over = self.motion_position.began.wrapping_add(left);
    }

    /// Passes all boundaries before `limit`.
    pub(super) fn walk(
        &mut self,
        limit: FineNs,
        budget: &mut WalkBudget,
        feed: FifoEnds,
        source: &impl PathEntries,
        sink: &mut impl Effects,
    ) {
        while self.motion_position.over < limit {
            match self.stage {
                PathStage::Standstill => return,
                PathStage::Wait { until } => {
                    self.time = until;
                    self.cursor(self.fifo).inside = false;
                    if self.travelled.length.is_none() {
                        self.keep_past(Pos(0));
                        self.travelled.length = Some(Exact(0));
                    }
                    self.go_on(budget, feed, source, sink);
                }
                PathStage::Move => {
                    if self.planning.unfinished {
                        self.finish();
                    }
                    if self.end_phase() {
                        continue;
                    }
                    if self.motions.now().plan.halts {
                        self.halt(self.time, PathStop::Stopped, feed, sink);
                    } else if !self.admits_end(sink) {
                        let distance = self.motions.now().shape.length.to_exact();
                        self.hold(self.time, (self.sampled(self.motion_position.sampled), distance), sink, feed);
                    } else {
                        self.leave(sink);
                        self.go_on(budget, feed, source, sink);
                    }
                }
            }
        }
    }

    /// Whether it and its geared axes may be at the end of the motion in force.
    fn admits_end(&self, sink: &mut impl Effects) -> bool {
        let end = |gear: &ActiveGear| Pos::pulses(gear.pulses);
        sink.admits(&self.motions.now().shape.end)
            && self.gears_of(self.fifo).all(|gear| sink.admits_gear(gear.axis, end(gear)))
    }

    /// The same for one boundary, if it only enters what was made ahead. `admits` says whether the
    /// path may be where the motion in force ends. If the boundary was passed, returns the entries
    /// and motions of the FIFO in force that are over then. The path length since the last sample
    /// is kept for a boundary after it only; otherwise it is not needed.
    #[inline(always)]
    pub fn turn_at<const SWEPT: bool>(
        &mut self,
        feed: FifoEnds,
        admits: impl FnOnce(&PathPos) -> bool,
    ) -> Option<[u32; 2]> {
        match self.fast.at_phase_end {
            FastPathCase::Motion => {}
            FastPathCase::Phase => {
                self.fast.at_phase_end = FastPathCase::Else;
                return self.end_phase().then(|| self.counts());
            }
            FastPathCase::Else => return None,
        }
        let (Prepared { shape, plan, .. }, Prepared { open_end, .. }) = (self.motions.now(), self.motions.next());
        let open = *open_end;
        if open.is_some_and(|sampled| sampled != end_of(feed, self.fifo)) || !admits(&shape.end) {
            return None;
        }
        // This does what four steps do: the end of a phase, the end of a motion, the change to the
        // next one, and the begin of its plan. It holds if nothing is sampled in between: position
        // and speed of the boundary are those of the motions, nothing is ahead, `inside` stays.
        if SWEPT {
            let Phase { length, .. } = plan.phase(self.motion_position.phase)?;
            let length = *length;
            self.sweep(length);
        }
        let cursor = &mut self.cursors[(self.fifo & 1) as usize];
        // The entry of the motion that begins is not over.
        let (released, done) = (cursor.next, cursor.done.wrapping_add(1));
        (cursor.next, cursor.done) = (released.wrapping_add(1), done);
        self.motions.next_mut().state = Preparation::Nothing;
        (self.motion_position, self.open_end) = (self.next_position, open);
        self.motions.turn();
        self.pieces.pair.turn();
        (self.pieces.follows, self.publish_whole, self.fast.at_phase_end) = (None, true, FastPathCase::Else);
        Some([released, done])
    }

    /// To the end of the phase in force, of this length.
    #[inline(always)]
    fn sweep(&mut self, length: Exact) {
        let so_far = match self.travelled.length {
            Some(swept) => swept.0,
            None => {
                self.keep_past(self.motion_position.sampled);
                self.motion_position.distance.0.wrapping_sub(Exact::from(self.motion_position.sampled).0)
            }
        };
        self.travelled.length = Some(Exact(length.0.wrapping_add(so_far)));
    }

    /// The phase in force is over. Returns whether another one of the motion has begun.
    #[inline(always)]
    fn end_phase(&mut self) -> bool {
        let Some(&Phase { length, .. }) = self.motions.now().plan.phase(self.motion_position.phase) else {
            return false;
        };
        self.sweep(length);
        self.motion_position.distance = Exact(self.motion_position.distance.0.wrapping_add(length.0));
        (self.motion_position.began, self.time) = (self.motion_position.over, self.motion_position.over);
        self.motion_position.phase = self.motion_position.phase.wrapping_add(1);
        if self.motions.now().plan.phase(self.motion_position.phase).is_some() {
            self.take_piece();
            self.set_over();
            return true;
        }
        // The piece after it belongs to what begins there.
        self.pieces.made = false;
        false
    }

    /// The motion in force is over.
    #[inline(always)]
    fn close(&mut self) {
        let Prepared { shape, plan, .. } = self.motions.now();
        let (here, speed) = (shape.end, plan.exit);
        (self.rest_position, self.speed, self.open_end) = (here, speed, None);
        let cursor = self.cursor(self.fifo);
        cursor.inside = false;
        cursor.done = cursor.done.wrapping_add(1);
    }

    /// The same, and reports the geared axes.
    fn leave(&mut self, sink: &mut impl Effects) {
        self.close();
        if self.has_slaves {
            self.trajectory_since.pass(self.time, self.rest_position);
        }
        for gear in self.gears_of(self.fifo) {
            sink.geared(self.time, gear.axis, gear.pulses);
        }
        let cursor = self.cursor(self.fifo);
        (cursor.geared, cursor.distance) = (0, Exact(0));
        // After a fall back it may be left again: what lay further counts still.
        if cursor.next.wrapping_sub(cursor.left_at) as i32 > 0 {
            cursor.left_at = cursor.next;
        }
    }

    /// At a boundary: on to the next motion, wait or standstill.
    pub(super) fn go_on(
        &mut self,
        budget: &mut WalkBudget,
        feed: FifoEnds,
        source: &impl PathEntries,
        sink: &mut impl Effects,
    ) {
        loop {
            let cursor = self.cursor(self.fifo);
            let counter = cursor.next;
            cursor.again &= counter != cursor.reported;
            if counter == end_of(feed, self.fifo) {
                let rest = if self.speed.is_zero() { PathStop::Completed } else { PathStop::Underrun };
                self.come_to_standstill(self.time, rest, feed, sink);
                return;
            }
            if self.stopping && self.speed.is_zero() {
                self.come_to_standstill(self.time, PathStop::Stopped, feed, sink);
                return;
            }
            let prepared = self.is_known(counter);
            let entry = (!prepared).then(|| source.entry(self.fifo, counter));
            let moves = entry.is_none_or(|entry| entry.is_motion());
            if entry.is_some_and(|entry| entry.is_wait()) && !self.speed.is_zero() && !self.stopping {
                // What is before it was too short to brake in.
                self.come_to_standstill(self.time, PathStop::Underrun, feed, sink);
                return;
            }
            let takes = match &entry {
                Some(entry) if !moves => sink.has_room() && budget.takes(entry.load(), self.time),
                _ => {
                    let left = budget.motions != 0;
                    budget.motions = budget.motions.saturating_sub(1);
                    left
                }
            };
            if !takes {
                self.wait(budget.hold);
                return;
            }
            self.cursor(self.fifo).next = counter.wrapping_add(1);
            match &entry {
                None => self.enter_prepared(self.rest_position, Exact(0), feed, source),
                Some(entry) => {
                    if let Some(until) = self.take(counter, entry, feed, source, sink) {
                        if self.stopping {
                            // While it brakes to a standstill it waits for nothing: the start that
                            // continues makes the wait.
                            return self.stop_in_wait(until, feed, sink);
                        }
                        self.wait(until);
                        self.speed = Float::ZERO;
                        return;
                    }
                }
            }
            if moves {
                if !self.gears_are_accepted(sink) {
                    self.cursor(self.fifo).inside = true;
                    self.speed = Float::ZERO;
                    return self.wait(self.time.wrapping_add(ENDLESS_WAIT_FINE_NS));
                }
                if self.motions.now().shape.length.is_zero() {
                    let speed = self.speed;
                    self.leave(sink);
                    self.speed = speed;
                } else {
                    return;
                }
            }
        }
    }

    /// Whether every axis that is geared to the motion just entered goes along. A motion without
    /// length moves none: its whole displacement would be one step.
    #[inline(always)]
    fn gears_are_accepted(&self, sink: &mut impl Effects) -> bool {
        let stands = self.motions.now().shape.length.is_zero();
        self.gears_of(self.fifo).all(|gear| sink.accepts_gear(gear.axis, !stands || gear.pulses == 0))
    }

    /// Carries out an entry that was not prepared. Returns the instant until which the path waits
    /// for it.
    #[inline(never)]
    fn take(
        &mut self,
        counter: u32,
        entry: &PathEntry,
        feed: FifoEnds,
        source: &impl PathEntries,
        sink: &mut impl Effects,
    ) -> Option<FineNs> {
        match &entry.item() {
            EntryContent::Nothing => None,
            EntryContent::Delay { ms } => Some(self.time.wrapping_add((*ms as FineNs * 1_000_000) << 32)),
            // What a laser is ordered may be ordered again, and has to be: the light of a mark that
            // is gone along again ends where it did.
            EntryContent::Change(change)
                if self.cursor(self.fifo).again && !matches!(change, EntryEffect::Laser { .. }) =>
            {
                None
            }
            EntryContent::Change(change) => {
                let wait = sink.change(self.time, change);
                self.cursor(self.fifo).inside = wait != 0;
                (wait != 0).then(|| self.time.wrapping_add(wait))
            }
            EntryContent::Gear { axis, pulses } => {
                let cursor = self.cursor(self.fifo);
                if cursor.again && (counter.wrapping_sub(cursor.left_at) as i32) < 0 {
                    return None;
                }
                if let Some(gear) = cursor.gears.iter_mut().take(cursor.geared).find(|gear| gear.axis == *axis) {
                    gear.pulses = gear.pulses.saturating_add(*pulses);
                } else if let Some(gear) = cursor.gears.get_mut(cursor.geared) {
                    *gear = ActiveGear { axis: *axis, pulses: *pulses, along: GearMotion::NONE };
                    cursor.geared = cursor.geared.wrapping_add(1);
                } else {
                    sink.surplus(*axis);
                }
                None
            }
            item => {
                self.enter(self.rest_position, counter, item);
                (self.motion_position.distance, self.motion_position.sampled) = (Exact(0), Pos(0));
                if !self.motions.now().shape.length.is_zero() {
                    self.plan_remainder(feed, source);
                }
                None
            }
        }
    }

    /// Comes to standstill within a motion.
    pub(super) fn halt(&mut self, at: FineNs, path_stop: PathStop, feed: FifoEnds, sink: &mut impl Effects) {
        let (distance, shape) = (self.motion_position.distance, &self.motions.now().shape);
        let (here, from) = (shape.at(distance.round()), shape.start);
        self.rest_position = here;
        let cursor = self.cursor(self.fifo);
        (cursor.distance, cursor.from) = (distance, from);
        self.come_to_standstill(at, path_stop, feed, sink);
    }

    /// Comes to standstill where it waits, or would wait, until an instant: the remainder of the
    /// wait is kept.
    pub(super) fn stop_in_wait(&mut self, until: FineNs, feed: FifoEnds, sink: &mut impl Effects) {
        let now = self.time;
        let cursor = self.cursor(self.fifo);
        if cursor.inside {
            // A move that the path waits for is made again: its axis may be stopped, too.
            (cursor.inside, cursor.next) = (false, cursor.next.wrapping_sub(1));
        } else {
            cursor.left = until.saturating_sub(now);
        }
        self.come_to_standstill(now, PathStop::Stopped, feed, sink);
    }

    /// Comes to standstill here.
    pub(super) fn come_to_standstill(
        &mut self,
        at: FineNs,
        path_stop: PathStop,
        feed: FifoEnds,
        sink: &mut impl Effects,
    ) {
        (self.stage, self.speed, self.stopping, self.open_end) = (PathStage::Standstill, Float::ZERO, false, None);
        (self.motion_position.over, self.publish_whole, self.planning.unfinished) = (FineNs::MAX, true, false);
        let (here, end) = (self.rest_position, end_of(feed, self.fifo));
        let cursor = self.cursor(self.fifo);
        cursor.kept = cursor.inside || cursor.left != 0 || cursor.next != end;
        cursor.position = here;
        sink.standstill(at, path_stop);
    }
}
