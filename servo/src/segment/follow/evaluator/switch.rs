//! What follows a switch of a slave, and at what ratio.
//!
//! In: the command to switch, the position where it acts. Out: the run with a new origin. Owns:
//! nothing. [`RatioOffset`] holds what the chain of ratios in the data cannot know. Cannot fail:
//! where there is nothing to switch to, nothing happens.
use super::{FollowContext, FollowRun, NextPiece, RatioOffset, Wait};
use crate::segment::follow::curve::{CurveSegment, EXACT_TO_POS_BITS, ratio_at};
use crate::segment::follow::entry::{CHAIN_MAX_ENTRIES, ENTRIES, FollowEntry, STOPS};
use crate::segment::follow::setup::Setup;
use crate::segment::follow::{FollowEntries, Method};
use crate::units::Pos;

impl FollowRun {
    /// SwitchNow with the master at `pos`; whether the slave follows.
    pub(super) fn switch_here<L>(
        &mut self,
        method: Method,
        pos: Pos,
        context: &mut FollowContext<impl FollowEntries, L>,
    ) -> bool {
        let other = self.fifo ^ 1;
        if method == Method::Table && context.setup.is_empty(other) {
            return false;
        }
        if let Wait::Pass { .. } | Wait::Start = self.wait {
            if method == Method::Table {
                self.enter_other(0, self.origin, 0, true, context);
            }
            return false;
        }
        if self.wait != Wait::No {
            self.resume(pos, pos.into(), context);
        }
        let (position, tau) = self.position();
        let moves = (self.progress as u64).wrapping_sub(self.piece.begin.0) < self.piece.span;
        let ratio = if moves { ratio_at(&self.piece.motion, tau) } else { 0 };
        let began = (self.progress as i128) << EXACT_TO_POS_BITS;
        let origin = (position.0 as i128) << EXACT_TO_POS_BITS;
        self.remainder = 0;
        if method == Method::Table {
            self.enter_other(began, origin, ratio, true, context);
            return true;
        }
        if moves {
            // The next entry begins here, as if the segment had ended.
            self.done = self.index.wrapping_add(1);
            // Those of one segment are two more at most.
            for _ in 0..2 {
                let more = self.done < context.setup.fifo(self.fifo).end
                    && context.source.entry(self.fifo, self.done).goes_on();
                self.done = self.done.wrapping_add(more as u32);
            }
        }
        let (knot, end) = self.ends_before(self.done, context);
        (self.began, self.origin) = (began.wrapping_sub(knot), origin.wrapping_sub(end));
        self.floor = (self.pass, self.done);
        let fifo = context.setup.fifo(self.fifo);
        if self.done < fifo.end {
            self.start_with(self.pass, self.done, ratio, context);
        } else {
            self.given = Some(ratio);
        }
        true
    }

    /// The first segment from entry `from` on in this pass starts at `ratio`.
    pub(super) fn start_with<L>(
        &mut self,
        pass: u32,
        from: u32,
        ratio: i128,
        context: &FollowContext<impl FollowEntries, L>,
    ) {
        let end = context.setup.fifo(self.fifo).end;
        let mut index = from;
        for _ in 0..STOPS {
            if index >= end || context.source.entry(self.fifo, index).kind().is_some() {
                break;
            }
            index = index.wrapping_add(1);
        }
        let entry = context.source.entry(self.fifo, index);
        let before = self.before(index, context);
        // What its chain gives it is part of that ratio.
        let segment = CurveSegment::between(before, entry, |_| 0);
        let own = segment.start_ratio();
        self.more = Some(RatioOffset { pass, from: index, odd: entry.odd(), ratio: ratio.wrapping_sub(own) });
    }

    /// The other FIFO takes over; the segment before ended at `ratio`. `at_once`: its first segment
    /// starts at it.
    pub(super) fn enter_other<L>(
        &mut self,
        began: i128,
        origin: i128,
        ratio: i128,
        at_once: bool,
        context: &mut FollowContext<impl FollowEntries, L>,
    ) {
        context.setup.clear(self.fifo);
        self.emptied |= 1 << self.fifo;
        self.fifo ^= 1;
        self.switching = false;
        (self.pass, self.done, self.floor) = (0, 0, (0, 0));
        (self.began, self.origin) = (began, origin);
        let fifo = context.setup.fifo(self.fifo);
        (self.end, self.carried) = (fifo.end, ratio);
        if self.both && fifo.tail.down != self.down {
            self.turn_round();
        }
        (self.more, self.given) = (None, None);
        if at_once {
            self.start_with(0, 0, self.carried, context);
        }
        self.piece.span = 0;
        (self.next, self.open) = (NextPiece::Data, false);
    }

    /// The other FIFO's progress has the other sign.
    pub(super) fn turn_round(&mut self) {
        self.down = !self.down;
        self.progress = self.progress.wrapping_neg();
        self.began = self.began.wrapping_neg();
        self.remainder = self.remainder.wrapping_neg();
        self.carried = self.carried.wrapping_neg();
    }

    /// The addition to a segment's start ratio that its chain does not know.
    #[inline(always)]
    pub(super) fn more_at(
        &self,
        pass: u32,
        index: u32,
        entry: FollowEntry,
        setup: &Setup,
        source: &impl FollowEntries,
    ) -> i128 {
        if self.more.is_none() && self.carried == 0 { 0 } else { self.more_of(pass, index, entry, setup, source) }
    }

    #[inline(never)]
    pub(super) fn more_of(
        &self,
        pass: u32,
        index: u32,
        entry: FollowEntry,
        setup: &Setup,
        source: &impl FollowEntries,
    ) -> i128 {
        let continues = setup.fifo(self.fifo).tail.continues as u32;
        let (from, odd, ratio) = if let Some(more) = &self.more
            && more.pass == pass
            && index >= more.from
        {
            (more.from, more.odd, more.ratio)
        } else if continues != 0 && self.carried != 0 {
            (continues.wrapping_sub(1), false, self.carried)
        } else {
            return 0;
        };
        if !self.is_chained(from, index, entry, source) {
            0
        } else if entry.odd() == odd {
            ratio
        } else {
            ratio.wrapping_neg()
        }
    }

    /// Whether NORMAL segments lead from `from` to `index`, both included.
    pub(super) fn is_chained(&self, from: u32, index: u32, entry: FollowEntry, source: &impl FollowEntries) -> bool {
        let (mut at, mut entry) = (index, entry);
        // A chain of 512 entries is searched in steps of 31.
        for _ in 0..=ENTRIES / CHAIN_MAX_ENTRIES {
            let back = entry.back();
            at = at.wrapping_sub(back);
            if at <= from || back < CHAIN_MAX_ENTRIES {
                break;
            }
            entry = source.entry(self.fifo, at);
        }
        at < from || at == from && source.entry(self.fifo, from).is_normal()
    }

    /// The ratio at the end of the segment before entry `index`.
    pub(super) fn end_ratio<L>(&mut self, index: u32, context: &FollowContext<impl FollowEntries, L>) -> i128 {
        let fifo = context.setup.fifo(self.fifo);
        let mut at = index;
        for _ in 0..=STOPS {
            let Some(last) = at.checked_sub(1) else { return self.carried };
            at = last;
            let entry = context.source.entry(self.fifo, at);
            if entry.kind().is_none() {
                continue;
            }
            if index == fifo.end {
                let more = if entry.is_normal() {
                    self.more_at(self.pass, at, entry, context.setup, context.source)
                } else {
                    0
                };
                return fifo.tail.ratio.wrapping_sub(more);
            }
            let before = self.before(at, context);
            return self.segment(self.pass, at, before, entry, context.setup, context.source).end_ratio();
        }
        0
    }
}
