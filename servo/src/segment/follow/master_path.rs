//! The path of a master within one tick: a few positions in order of time, monotone between them.
//!
//! In: the pieces that a master runs in the tick, or two samples. Out: a [`MasterPath`] from the
//! tick in force to the next, turning points included; the master's position at an instant of it,
//! and the instant of a position. Cannot fail. Simplified: if more than one knot lies in the tick,
//! the path between the first and the last of them is a straight line; so is the path of a slave
//! with slaves of its own between its positions.
use super::curve::{bend, slope};
use crate::math::wide::umulhi;
use crate::segment::piece::Piece;
use crate::units::{Exact, Ns, Pos};

/// Positions of a path at most: begin and end, two turning points in either of two pieces, both
/// ends of the interval between these.
pub const POSITIONS_MAX: usize = 8;
/// From 2⁻⁶⁴ pulse to 2⁻⁵³, in which a slave keeps where a delay ended.
pub(super) const REMAINDER_DOWN: u32 = 11;
/// That unit in 2⁻⁶⁴ pulse.
const REMAINDER: i128 = 1 << REMAINDER_DOWN;
/// A position at an instant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TimedPosition {
    /// Time since the tick in force, 2⁻³² ns.
    pub after: u64,
    /// The master's position.
    pub pos: Pos,
}

/// Positions in order of time; the first is that of the tick in force.
#[derive(Debug, Clone, Copy)]
pub struct PositionTrack {
    spots: [TimedPosition; POSITIONS_MAX],
    count: u8,
}

/// The path of one tick.
#[derive(Debug, Clone, Copy)]
pub struct MasterPath<'a> {
    /// The tick in force.
    pub(super) now: Ns,
    track: PositionTrack,
    /// The piece along which it comes to each position: 0 a straight line, 1 or 2.
    along: [u8; POSITIONS_MAX],
    pieces: [Option<&'a Piece>; 2],
    /// What has to be added to positions of pieces.
    shift: i64,
}

/// From one position to the next, along a piece or straight.
#[derive(Debug, Clone, Copy)]
pub struct Section<'a> {
    pub(super) now: Ns,
    pub(super) from: TimedPosition,
    /// Where a straight one began: `from` may lie later on the line, and is rounded.
    pub(super) line: TimedPosition,
    pub(super) to: TimedPosition,
    pub(super) piece: Option<&'a Piece>,
    pub(super) shift: i64,
}

impl PositionTrack {
    /// Empty.
    pub(crate) const NONE: PositionTrack =
        PositionTrack { spots: [TimedPosition { after: 0, pos: Pos(0) }; POSITIONS_MAX], count: 0 };

    /// Empties it.
    #[inline(always)]
    pub(crate) fn clear(&mut self) {
        self.count = 0;
    }

    /// One position.
    pub(crate) fn begin(from: Pos) -> PositionTrack {
        PositionTrack { spots: [TimedPosition { after: 0, pos: from }; POSITIONS_MAX], count: 1 }
    }

    /// The next position; returns its index. When it is full, the last one moves there.
    pub(crate) fn push(&mut self, after: u64, pos: Pos) -> usize {
        let index = (self.count as usize).min(POSITIONS_MAX - 1);
        if let Some(slot) = self.spots.get_mut(index) {
            *slot = TimedPosition { after, pos };
        }
        self.count = index as u8 + 1;
        index
    }

    /// It ends there; the last position becomes this one.
    pub(crate) fn arrive(&mut self, after: u64, pos: Pos) {
        if let Some(last) = self.spots.get_mut(self.count.saturating_sub(1) as usize).filter(|_| self.count > 1) {
            last.pos = pos;
        }
        if self.last().after != after {
            self.push(after, pos);
        }
    }

    /// Whether it is straight from a tick to the next.
    #[inline(always)]
    pub(crate) fn is_straight(&self) -> bool {
        self.count <= 2
    }

    fn spots(&self) -> &[TimedPosition] {
        self.spots.get(..self.count as usize).unwrap_or_default()
    }

    /// The last position.
    pub(super) fn last(&self) -> TimedPosition {
        self.spots().last().copied().unwrap_or_default()
    }
}

impl<'a> MasterPath<'a> {
    /// From position to position of a slave. These plus `shift` are the master's.
    pub fn of(now: Ns, track: &PositionTrack, shift: i64) -> MasterPath<'a> {
        let mut track = *track;
        for spot in &mut track.spots {
            spot.pos.0 = spot.pos.0.wrapping_add(shift);
        }
        MasterPath { now, track, along: [0; POSITIONS_MAX], pieces: [None; 2], shift: 0 }
    }

    /// Along the pieces of a motion: `piece`, and `before` if that is in force from `now` until the
    /// piece begins. Positions of pieces plus `shift` are the master's.
    pub fn along(
        now: Ns,
        period: Ns,
        before: Option<&'a Piece>,
        piece: &'a Piece,
        from: Pos,
        to: Pos,
        shift: i64,
    ) -> MasterPath<'a> {
        let next = Ns(now.0.wrapping_add(period.0));
        let mut path = MasterPath::of(now, &PositionTrack::begin(from), 0);
        (path.pieces, path.shift) = ([before, Some(piece)], shift);
        let at = |pos: Pos| Pos(pos.0.wrapping_add(shift));
        let mut since = now;
        if let Some(before) = before {
            // Instants inside the tick, from now.
            let entered = piece.begin.0.wrapping_sub(now.0) as i64;
            let last = before.begin.0.wrapping_add(before.span);
            let left = (last.wrapping_sub(now.0) as i64).min(entered).max(0);
            let rests = piece.span == u64::MAX;
            if left > 0 {
                path.turns(before, now, Ns(now.0.wrapping_add(left as u64)), 1);
                // A motion's end counts at its instant, not at the tick at which it was seen.
                let joined = left == entered || rests && before.ends_at(piece.start);
                let end = if joined { piece.start } else { before.at(before.span.saturating_sub(1)).0 };
                path.push((left as u64) << 32, at(end), 1);
            }
            if left < entered {
                path.push((entered as u64) << 32, at(piece.start), 0);
            }
            since = piece.begin;
        }
        if since != next {
            path.turns(piece, since, next, 2);
            path.push(period.0 << 32, to, 2);
        } else if path.track.last().after != period.0 << 32 {
            path.push(period.0 << 32, to, 0);
        }
        path
    }

    fn push(&mut self, after: u64, pos: Pos, along: u8) {
        let index = self.track.push(after, pos);
        if let Some(slot) = self.along.get_mut(index) {
            *slot = along;
        }
    }

    /// The master's position at the next tick.
    pub(super) fn last(&self) -> TimedPosition {
        self.track.last()
    }

    /// Sections in order.
    pub(super) fn sections(&self) -> impl Iterator<Item = Section<'a>> {
        let spots = self.track.spots();
        let [first, second] = self.pieces;
        spots.iter().zip(spots.iter().zip(&self.along).skip(1)).map(move |(from, (to, along))| Section {
            now: self.now,
            from: *from,
            line: *from,
            to: *to,
            piece: match along {
                0 => None,
                1 => first,
                _ => second,
            },
            shift: self.shift,
        })
    }

    /// The turning points of a piece between two instants in it.
    fn turns(&mut self, piece: &Piece, from: Ns, to: Ns, along: u8) {
        let begin = from.0.wrapping_sub(self.now.0) << 32;
        let end = to.0.wrapping_sub(self.now.0) << 32;
        let tau = |at| tau(self.now, piece, at);
        let sign = |at| slope(&piece.motion, tau(at)) < 0;
        let (first, last) = (sign(begin), sign(end));
        let mut found = [None; 2];
        if first != last {
            found = [Some(bisect(begin, end, |at| sign(at) == first)), None];
        } else if piece.motion.c[2] != 0 {
            let side = |at| bend(&piece.motion, tau(at)) < 0;
            if side(begin) != side(end) {
                let middle = bisect(begin, end, |at| side(at) == side(begin));
                if sign(middle) != first {
                    let one = bisect(begin, middle, |at| sign(at) == first);
                    found = [Some(one), Some(bisect(middle, end, |at| sign(at) != first))];
                }
            }
        }
        for at in found.into_iter().flatten() {
            let pos = pos(self.now, piece, self.shift, at);
            self.push(at, pos, along);
        }
    }
}

/// The parameter of a piece at a time since the tick in force; held inside the piece. Another one
/// may have cut it short: its cubic goes on after its end.
fn tau(now: Ns, piece: &Piece, at: u64) -> u64 {
    let t = (at >> 32).wrapping_add(now.0).wrapping_sub(piece.begin.0);
    let last = piece.span.saturating_sub(1);
    let (t, part) = if t > last { (last, u32::MAX) } else { (t, at as u32) };
    let recip = piece.motion.recip;
    let part = (((part as u128) << (recip.shift & 63)) >> 32) as u64;
    let tau = (recip.ratio(t) >> 1).wrapping_add(piece.motion.tau);
    tau.wrapping_add(part.saturating_add(umulhi(part, recip.m)) >> 1).min(Piece::TAU_END)
}

/// The master's position on a piece at a time since the tick in force.
fn pos(now: Ns, piece: &Piece, shift: i64, at: u64) -> Pos {
    Pos(piece.pos_at(tau(now, piece, at)).0.wrapping_add(shift))
}

impl Section<'_> {
    /// A master that does not move.
    pub(super) fn still(now: Ns, here: TimedPosition) -> Section<'static> {
        Section { now, from: here, line: here, to: here, piece: None, shift: 0 }
    }

    /// The master's position at a time since the tick in force, inside the section.
    pub(super) fn at(&self, after: u64) -> Exact {
        if let Some(piece) = self.piece {
            let shift = Exact::from(Pos(self.shift));
            return Exact(piece.exact_at(tau(self.now, piece, after)).0.wrapping_add(shift.0));
        }
        let (from, to) = (Exact::from(self.line.pos), self.to.pos.0.wrapping_sub(self.line.pos.0));
        let length = self.to.after.wrapping_sub(self.line.after);
        let part = share(after.saturating_sub(self.line.after) as u128, length as u128);
        Exact(from.0.wrapping_add((to as i128).wrapping_mul(part as i128) >> Pos::FRAC_BITS))
    }

    /// The time since the tick in force at which the master is at `pos`; at the nearest end of the
    /// section where that is outside.
    pub(super) fn when(&self, pos: Exact) -> u64 {
        let (begin, end) = (self.from.after, self.to.after);
        let up = self.to.pos > self.from.pos;
        let left = |after| {
            let left = pos.0.wrapping_sub(self.at(after).0);
            if up { left } else { left.wrapping_neg() }
        };
        // What lies less than that unit after the beginning is there.
        if self.to.pos == self.from.pos || left(begin) < REMAINDER {
            return begin;
        }
        if left(end) >= 0 {
            return end;
        }
        // Within 2⁻²⁴ of the section it moves evenly.
        let steps = if self.piece.is_some() { 24 } else { 0 };
        let (low, high) = bracket(begin, end, steps, |after| left(after) > 0);
        let first = left(low);
        let part = share(first as u128, first.wrapping_sub(left(high)) as u128);
        low.wrapping_add(umulhi(high.wrapping_sub(low), part))
    }

    /// Begins at a later time. Returns the master's position there.
    pub(super) fn begin_at(&mut self, after: u64) -> Exact {
        let at = self.at(after);
        let (low, high) = (self.from.pos.min(self.to.pos), self.from.pos.max(self.to.pos));
        self.from = TimedPosition { after, pos: at.round().clamp(low, high) };
        at
    }
}

/// Whether a piece has no turning point from `now` on, for certain.
pub(super) fn is_plain(piece: &Piece, now: Ns) -> bool {
    let motion = &piece.motion;
    let from = (motion.recip.ratio(piece.elapsed_within(now.max(piece.begin))) >> 1).wrapping_add(motion.tau);
    let (first, last) = (slope(motion, from), slope(motion, Piece::TAU_END));
    if first < 0 && last > 0 || first > 0 && last < 0 {
        return false;
    }
    let (first, last) = (bend(motion, from), bend(motion, Piece::TAU_END));
    motion.c[2] == 0 || !(first < 0 && last > 0 || first > 0 && last < 0)
}

/// The first time in a range at which something no longer holds, to 2⁻⁴⁰ of the range.
pub(super) fn bisect(low: u64, high: u64, holds: impl Fn(u64) -> bool) -> u64 {
    bracket(low, high, 40, holds).1
}

/// The times before and after which it no longer holds, to 2^-`steps` of the range.
fn bracket(mut low: u64, mut high: u64, steps: u32, holds: impl Fn(u64) -> bool) -> (u64, u64) {
    for _ in 0..steps {
        let middle = low.wrapping_add(high.wrapping_sub(low) >> 1);
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    (low, high)
}

/// a/b in 2⁻⁶⁴, below 1.
fn share(a: u128, b: u128) -> u64 {
    let down = 64u32.saturating_sub(b.leading_zeros());
    let (a, b) = ((a >> down) as u64, (b >> down) as u64);
    crate::math::wide::Recip::of(b).ratio(a.min(b.saturating_sub(1)))
}
