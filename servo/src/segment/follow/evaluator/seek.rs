//! The segment of a slave's progress in its FIFO, through ends of passes, forwards and backwards.
//!
//! In: the progress, in the run. Out: the piece that holds it, or the entry or the end that is
//! reached. Owns: nothing. Cannot fail: a position too far away is marked. Work: a bisection, and a
//! product for any number of passes.
use super::{FollowContext, FollowRun, NextPiece, PreparedPiece, Seek};
use crate::math::wide::{recip64_below, umulhi};
use crate::segment::follow::FollowEntries;
use crate::segment::follow::curve::{CurveSegment, EXACT_TO_POS_BITS, ceil};
use crate::segment::follow::entry::FollowEntry;
use crate::segment::follow::ratio::start_displacement;
use crate::segment::follow::setup::Setup;
use crate::units::Exact;

impl FollowRun {
    /// The piece in force does not hold `progress`: the distance into the one made ahead, if that
    /// does.
    #[inline(never)]
    pub(super) fn turn(&mut self, progress: i64) -> Option<u64> {
        let ahead = if let NextPiece::Prepared(ahead) = &self.next { ahead } else { return None };
        if self.piece.span == 0 {
            return None;
        }
        let t = (progress as u64).wrapping_sub(ahead.piece.begin.0);
        if t >= ahead.piece.span {
            return None;
        }
        self.piece = ahead.piece;
        (self.index, self.pass, self.began, self.origin) = (ahead.index, ahead.pass, ahead.began, ahead.origin);
        (self.next, self.open, self.held) = (NextPiece::Data, true, false);
        Some(t)
    }

    /// Makes the piece after the one in force ahead of its tick, if all entries between are
    /// segments, so that many slaves can enter pieces in one tick. The piece is the same as it
    /// would be later.
    #[inline(never)]
    pub fn prepare(&mut self, setup: &Setup, source: &impl FollowEntries) {
        self.open = false;
        let end = self.piece.begin.0.wrapping_add(self.piece.span) as i64;
        let mut x = ((end as i128) << EXACT_TO_POS_BITS).wrapping_sub(self.began);
        let fifo = setup.fifo(self.fifo);
        let (mut index, mut pass, mut began, mut origin) = (self.index, self.pass, self.began, self.origin);
        let mut before = (index > 0).then(|| source.entry(self.fifo, index.wrapping_sub(1)));
        let mut entry = source.entry(self.fifo, index);
        if x >= entry.ends_master() {
            (before, index) = (Some(entry), index.wrapping_add(1));
            if index >= fifo.end {
                let goes_on = setup.passes == 0 || pass.wrapping_add(1) < setup.passes;
                if !goes_on || fifo.count != 0 || self.switching || self.given.is_some() {
                    return;
                }
                let (length, displacement) = entry.ends();
                (before, index, pass) = (None, 0, pass.wrapping_add(1));
                (began, origin) = (began.wrapping_add(length), origin.wrapping_add(displacement));
                x = x.wrapping_sub(length);
            }
            entry = source.entry(self.fifo, index);
        }
        if entry.kind().is_none() || x >= entry.ends_master() || self.end != fifo.end {
            return;
        }
        let piece = self.segment(pass, index, before, entry, setup, source).piece(x, began, origin);
        self.next = NextPiece::Prepared(PreparedPiece { piece, index, pass, began, origin });
    }

    /// Before the start: makes the first piece, as for a master at 0, if the first entry is a
    /// segment.
    #[inline(never)]
    pub(crate) fn prepare_start(&mut self, setup: &Setup, source: &impl FollowEntries) {
        let entry = source.entry(self.fifo, 0);
        if self.gear().is_some() || setup.fifo(self.fifo).end == 0 || entry.kind().is_none() {
            return;
        }
        let piece = self.segment(0, 0, None, entry, setup, source).piece(0, 0, self.origin);
        self.next = NextPiece::Prepared(PreparedPiece { piece, index: 0, pass: 0, began: 0, origin: self.origin });
    }

    /// The slave's position at the beginning of an entry of this pass.
    pub(super) fn knot<L>(&self, index: u32, context: &FollowContext<impl FollowEntries, L>) -> Exact {
        let (_, end) = self.ends_before(index, context);
        Exact(self.origin.wrapping_add(end))
    }

    pub(super) fn before<L>(&self, index: u32, context: &FollowContext<impl FollowEntries, L>) -> Option<FollowEntry> {
        (index > 0).then(|| context.source.entry(self.fifo, index.wrapping_sub(1)))
    }

    /// The end of the entry before `index`.
    pub(super) fn ends_before<L>(&self, index: u32, context: &FollowContext<impl FollowEntries, L>) -> (i128, i128) {
        self.before(index, context).map_or((0, 0), FollowEntry::ends)
    }

    #[inline(always)]
    pub(super) fn segment(
        &self,
        pass: u32,
        index: u32,
        before: Option<FollowEntry>,
        entry: FollowEntry,
        setup: &Setup,
        source: &impl FollowEntries,
    ) -> CurveSegment {
        let more = self.more_at(pass, index, entry, setup, source);
        CurveSegment::between(before, entry, |length| {
            if more == 0 { 0 } else { start_displacement(more, length.unsigned_abs()) }
        })
    }

    /// The piece of an entry of this pass that holds the progress `x` is in force.
    #[inline(never)]
    pub(super) fn enter<L>(&mut self, index: u32, x: i128, context: &FollowContext<impl FollowEntries, L>) {
        let entry = context.source.entry(self.fifo, index);
        let before = self.before(index, context);
        let segment = self.segment(self.pass, index, before, entry, context.setup, context.source);
        self.far |= self.is_far(segment.start(self.origin));
        self.piece = segment.piece(x, self.began, self.origin);
        (self.index, self.held, self.next, self.open) = (index, false, NextPiece::Data, true);
    }

    /// Whether a slave position is 2³⁹ pulses or more from that of the piece in force.
    pub(super) fn is_far(&self, pos: i128) -> bool {
        pos.wrapping_sub((self.piece.start.0 as i128) << EXACT_TO_POS_BITS).unsigned_abs() >> (39 + 64) != 0
    }

    /// Loads the next piece of the segment in force, or of the one after it, if nothing else is to
    /// be done: neither an entry that is no segment nor an end of a pass lies between.
    #[inline(always)]
    pub(super) fn go_on<L>(&mut self, context: &FollowContext<impl FollowEntries, L>) -> bool {
        if self.piece.span == 0 {
            return false;
        }
        let x = ((self.progress as i128) << EXACT_TO_POS_BITS).wrapping_sub(self.began);
        let mut index = self.index;
        if x >= context.source.entry(self.fifo, index).ends_master() {
            index = index.wrapping_add(1);
            if index >= context.setup.fifo(self.fifo).end {
                return false;
            }
            let next = context.source.entry(self.fifo, index);
            if next.kind().is_none() || x >= next.ends_master() {
                return false;
            }
        } else if x < self.ends_before(index, context).0 {
            return false;
        }
        self.enter(index, x, context);
        true
    }

    /// Finds the segment of the present progress, through ends of passes.
    pub(super) fn seek<L>(&mut self, context: &mut FollowContext<impl FollowEntries, L>) -> Seek {
        if self.go_on(context) {
            return Seek::Here;
        }
        // Over an end of pass into the next, a switch, and once more; or back over any number of
        // passes.
        for _ in 0..4 {
            let x = ((self.progress as i128) << EXACT_TO_POS_BITS).wrapping_sub(self.began);
            let fifo = context.setup.fifo(self.fifo);
            let (floor_pass, floor_index) = self.floor;
            let low = if self.pass == floor_pass { floor_index } else { 0 };
            if x < 0 && self.pass > floor_pass {
                self.back(x, context);
                continue;
            }
            if self.pass == floor_pass && x < self.ends_before(low, context).0 {
                // Before the floor the slave is held at it.
                self.hold(low, context);
                return Seek::Here;
            }
            let stop = fifo.stop_from(self.done.max(low));
            let limit = stop.unwrap_or(fifo.end);
            if x < self.ends_before(limit, context).0 {
                self.load(x, low, limit, context);
                return Seek::Here;
            }
            if let Some(stop) = stop {
                return Seek::Stop(stop);
            }
            if let Some(at) = self.end_pass(x, context) {
                return Seek::End(at);
            }
        }
        // More passes lie between than can be counted.
        self.far = true;
        Seek::Here
    }

    /// Finds out whether the slave is at its floor, after the steps of a tick.
    pub(crate) fn find_floor(&mut self, source: &impl FollowEntries) {
        let (pass, index) = self.floor;
        self.at_floor = self.both && self.pass == pass && {
            let knot = if index == 0 { 0 } else { source.entry(self.fifo, index.wrapping_sub(1)).ends_master() };
            self.progress <= ceil(self.began.wrapping_add(knot))
        };
    }

    /// Loads the piece that holds the progress `x` of this pass; its segment is one of
    /// `low`..`limit`.
    pub(super) fn load<L>(&mut self, x: i128, low: u32, limit: u32, context: &FollowContext<impl FollowEntries, L>) {
        let ends = |index| context.source.entry(self.fifo, index).ends_master();
        let (mut low, mut high) = (low, limit.wrapping_sub(1));
        while low < high {
            let middle = low.wrapping_add(high) >> 1;
            if x < ends(middle) {
                high = middle;
            } else {
                low = middle.wrapping_add(1);
            }
        }
        self.enter(low, x, context);
    }

    /// The pass is over at the progress `x` ≥ its end; the exact end of the motion, if that is it.
    pub(super) fn end_pass<L>(&mut self, x: i128, context: &mut FollowContext<impl FollowEntries, L>) -> Option<i128> {
        let fifo = context.setup.fifo(self.fifo);
        let (length, displacement) = self.ends_before(fifo.end, context);
        if length == 0 {
            // Its entries are reached again and again where the master is, also what follows them.
            self.began = self.began.wrapping_add(x);
        }
        if self.switching && !context.setup.is_empty(self.fifo ^ 1) {
            let given = self.given.take();
            let ratio = given.unwrap_or_else(|| self.end_ratio(fifo.end, context));
            let (began, origin) = (self.began.wrapping_add(length), self.origin.wrapping_add(displacement));
            self.enter_other(began, origin, ratio, given.is_some(), context);
            return None;
        }
        let (stops, passes) = (fifo.count, context.setup.passes);
        if let Some(ratio) = self.given.take() {
            self.start_with(self.pass.wrapping_add(1), 0, ratio, context);
        }
        let left = if passes == 0 { u32::MAX } else { passes.saturating_sub(self.pass).max(1) };
        let many = if stops == 0 { passes_in(x, length).clamp(1, left) } else { 1 };
        let ended = passes != 0 && many == left;
        self.pass = self.pass.wrapping_add(many);
        self.began = self.began.wrapping_add(length.wrapping_mul(many as i128));
        self.origin = self.origin.wrapping_add(passes_of(displacement, many));
        (self.done, self.index) = (0, 0);
        ended.then_some(self.origin)
    }

    /// Back into an earlier pass; `x` < 0.
    pub(super) fn back<L>(&mut self, x: i128, context: &FollowContext<impl FollowEntries, L>) {
        let fifo = context.setup.fifo(self.fifo);
        let (length, displacement) = self.ends_before(fifo.end, context);
        let passes = self.pass.wrapping_sub(self.floor.0);
        let many = passes_in(x.wrapping_neg().wrapping_sub(1), length).saturating_add(1).min(passes);
        self.pass = self.pass.wrapping_sub(many);
        self.began = self.began.wrapping_sub(length.wrapping_mul(many as i128));
        self.origin = self.origin.wrapping_sub(passes_of(displacement, many));
        (self.done, self.index) = (fifo.end, fifo.end.wrapping_sub(1));
    }
}

/// The slave's displacement in this many passes; held at 2⁴⁶ pulses, which is too far anyway.
pub(super) fn passes_of(displacement: i128, many: u32) -> i128 {
    const DISPLACEMENT_MAX_EXACT: i128 = 1 << (46 + 64);
    if ((displacement >> 40).wrapping_mul(many as i128)).unsigned_abs() >> (46 + 64 - 40) == 0 {
        displacement.wrapping_mul(many as i128)
    } else if displacement < 0 {
        -DISPLACEMENT_MAX_EXACT
    } else {
        DISPLACEMENT_MAX_EXACT
    }
}

/// Whole passes of this length in `x` ≥ 0, at most 2³² − 2.
pub(super) fn passes_in(x: i128, length: i128) -> u32 {
    const MAX_PASSES: u64 = u32::MAX as u64 - 1;
    let (x, length) = (x.max(0) as u128, length.max(1) as u128);
    if x >> 32 >= length {
        return MAX_PASSES as u32;
    }
    // length·2^-s has 64 bits with the top one set, and the quotient no more than 32.
    let zeros = length.leading_zeros();
    let d = (length << zeros >> 64) as u64;
    let y = if zeros >= 64 { x << (zeros - 64) } else { x >> (64 - zeros) };
    let y = (y >> 32) as u64;
    // Cut off three times: a few short, or one too many for the cut of the length.
    let many = ((y as u128).wrapping_add(umulhi(y, recip64_below(d)) as u128) >> 32) as u64;
    let mut many = many.saturating_sub(1);
    for _ in 0..6 {
        if length.wrapping_mul(many as u128 + 1) > x {
            break;
        }
        many += 1;
    }
    many.min(MAX_PASSES) as u32
}
