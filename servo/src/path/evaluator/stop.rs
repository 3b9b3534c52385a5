//! Stops of a path from outside.
//!
//! In: the tick computed, how it stops. Out: the motion in force planned anew, or standstill. Owns
//! nothing beyond the [`Path`]. Cannot fail. An abrupt Stop finds the path a period ahead of its
//! published position: it goes back to that.
use super::cursor::{Cursor, SampledPosition};
use super::interface::{Effects, FifoEnds, PathStop};
use super::{Path, PathStage, Preparation};
use crate::path::PathPos;
use crate::path::store::PathEntries;
use crate::units::{FineNs, Ns, Pos};

impl Path {
    /// Smooth: brakes along the path from `next` on. Abrupt: stops there.
    pub fn stop(&mut self, next: Ns, abrupt: bool, feed: FifoEnds, source: &impl PathEntries, sink: &mut impl Effects) {
        let now = (next.0 as FineNs) << 32;
        match self.stage {
            PathStage::Standstill => {}
            PathStage::Wait { until } => {
                self.time = now;
                self.stop_in_wait(until, feed, sink);
            }
            PathStage::Move if abrupt => {
                self.catch_up(now);
                self.halt(now, PathStop::Stopped, feed, sink);
            }
            PathStage::Move => {
                self.stopping = true;
                self.catch_up(now);
                self.plan_remainder(feed, source);
            }
        }
        self.decide_fast_path();
    }

    /// Stops at `next` at the `position` of the last sample (SPEC 4). Entries reached since were
    /// carried out. The start that continues makes those of a laser again, and passes the others.
    pub fn stand_still(&mut self, next: Ns, position: &PathPos, feed: FifoEnds, sink: &mut impl Effects) {
        self.time = (next.0 as FineNs) << 32;
        match self.stage {
            PathStage::Standstill => {}
            PathStage::Wait { until } if self.travelled.length.is_none() => self.stop_in_wait(until, feed, sink),
            PathStage::Wait { .. } | PathStage::Move => self.fall_back(position, feed, sink),
        }
        self.decide_fast_path();
    }

    /// The first boundary since the sample: keeps the position there.
    #[inline(always)]
    pub(super) fn keep_past(&mut self, distance: Pos) {
        let Cursor { next, done, inside, .. } = self.cursors[(self.fifo & 1) as usize];
        self.travelled.past = SampledPosition { next, done, inside, from: self.motions.now().shape.start, distance };
    }

    /// Comes to rest at the position of the last sample.
    #[inline(never)]
    fn fall_back(&mut self, position: &PathPos, feed: FifoEnds, sink: &mut impl Effects) {
        if self.travelled.length.is_none() {
            self.keep_past(self.motion_position.sampled);
        }
        let SampledPosition { next, done, inside, from, distance } = self.travelled.past;
        let waits = self.waits();
        let cursor = self.cursor(self.fifo);
        // A move that the path waits for is made again.
        let reached = cursor.next.wrapping_sub((waits && cursor.inside) as u32);
        if !cursor.again {
            cursor.reported = reached;
        }
        cursor.again = cursor.reported != next;
        if cursor.next != next || !inside {
            // An axis geared to the motion that is back in force was moved to its end.
            cursor.geared = 0;
        }
        let changed = cursor.next != next;
        (cursor.next, cursor.done, cursor.inside, cursor.left) = (next, done, inside, 0);
        cursor.from = from;
        self.cursor(self.fifo).distance = self.sampled(distance);
        if changed {
            self.motions.next_mut().state = Preparation::Nothing;
        }
        (self.rest_position, self.trajectory_since.count) = (*position, 0);
        self.come_to_standstill(self.time, PathStop::Stopped, feed, sink);
    }
}
