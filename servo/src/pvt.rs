//! PVT: cubic pieces through points with given times, positions and velocities (SPEC 5; GXN
//! chapter 4).
//!
//! In: instants, and tables that the thread filled ([`Tables`]). Out: a [`Step`] a tick. Owns: the
//! state of one running motion, [`PvtRun`]. Cannot fail: what could not be run is refused when the
//! table is built.
//!
//! Nothing accumulates: the beginning of a pass is an instant in 2⁻⁶⁴ ns and a position in
//! 2⁻⁶⁴ pulse, to which passes add the table's exact duration and displacement; a knot is added to
//! these two afresh. A segment's coefficients are computed when it is entered, by products alone.
//! Work of a tick: one segment change at most (prepared by an earlier tick where [`PvtRun::prepare`] is
//! called, which takes the most of it), found by at most 20 looks at times, however many
//! knots or passes lie between two ticks.
use crate::piece::{Motion, Piece, Recip};
use crate::profile::{State, Step};
use crate::units::{Exact, Ns};
use crate::wide::{mulhi_su, recip64_below, umulhi};

mod stores;
mod table;
pub use stores::{HeaderStore, PlaceStore, TABLES, TableStores};
pub use table::{
    HEADER_WORDS, Header, LONGEST_NS, PLACE_WORDS, PLACES, POS_BITS, Place, SHORTEST_PASS_NS, TIME_BITS, VEL_BITS,
};

/// Where a run reads its tables. Tables are counted from 0.
pub trait Tables {
    /// The words of a place; a place that does not exist reads as zeros.
    fn place(&self, table: u8, index: u32) -> [u32; PLACE_WORDS];
    /// The words of a header; a table that does not exist reads as zeros.
    fn header(&self, table: u8) -> [u32; HEADER_WORDS];
}

/// A PVT motion that runs.
#[derive(Debug, Clone, Copy)]
#[repr(C)] // the piece first, as in every motion
pub struct PvtRun {
    piece: Piece,
    header: Header,
    /// The table in force.
    table: u8,
    /// The table that takes over when the present pass ends.
    pending: Option<u8>,
    /// The segment after the one in force.
    next: u32,
    /// Segments of a pass; 0 before the first one is entered, so that none follows.
    segments: u32,
    /// Its begin in 2⁻⁶⁴ ns, and the place there.
    until: u128,
    ahead: Place,
    /// What follows, if it was prepared: its piece, its end and the place there.
    prepared: Option<(Piece, u128, Place)>,
    /// Passes of this table completed.
    passes: u32,
    /// All passes have run.
    ended: bool,
    /// Position of the first point of the present pass.
    origin: Exact,
    /// Its instant in 2⁻⁶⁴ ns.
    began: u128,
}

/// 2⁸³/10⁶ to nearest: ns to ms, top bit set.
const PER_MS: u64 = 9_671_406_556_917_033_398;

impl PvtRun {
    /// A motion whose time is zero at `now`, from the position `origin`: it rests there until the
    /// time of the table's first point.
    pub fn begin(now: Ns, origin: Exact, table: u8, source: &impl Tables) -> PvtRun {
        let header = Header::from_words(source.header(table));
        let began = ((now.0 as u128) << 64).wrapping_add(header.delay);
        PvtRun {
            piece: Piece {
                begin: now,
                span: ceil(began).wrapping_sub(now.0),
                start: origin.round(),
                ..Piece::default()
            },
            header,
            table,
            pending: None,
            next: 0,
            segments: 0,
            until: began,
            ahead: Place::default(),
            prepared: None,
            passes: 0,
            ended: false,
            origin,
            began,
        }
    }

    /// `table` takes over when the present pass ends; the one in force now means no change.
    pub fn select(&mut self, table: u8) {
        self.pending = (table != self.table).then_some(table);
    }

    /// The table in force.
    pub fn table(&self) -> u8 {
        self.table
    }

    /// The table that waits for the end of the pass.
    pub fn pending(&self) -> Option<u8> {
        self.pending
    }

    /// Passes of this table completed.
    pub fn passes(&self) -> u32 {
        self.passes
    }

    /// Time of the table at `now`, which runs from 0 to the first point's time and then from point
    /// to point, in whole ns; at most the last point's time.
    pub fn time(&self, now: Ns) -> Ns {
        let since = ((now.0 as u128) << 64).wrapping_sub(self.began.wrapping_sub(self.header.delay));
        Ns((since.min(self.header.delay.wrapping_add(self.header.duration)) >> 64) as u64)
    }

    /// Instant at which the time of the table was 0, or would have been in a later pass; rounded down.
    pub fn zero(&self) -> Ns {
        Ns((self.began.wrapping_sub(self.header.delay) >> 64) as u64)
    }

    /// The piece in force, as far as the last step or turn saw.
    #[inline(always)]
    pub fn piece(&self) -> &Piece {
        &self.piece
    }

    /// The piece is over at `now`: on to the one that holds it, or to the end.
    #[inline]
    pub fn turn(&mut self, now: Ns, passes: u32, source: &impl Tables) -> State {
        if self.advance(now, passes, source) { State::Running } else { State::Ended { at: self.origin } }
    }

    /// The motion at `now`, which must not go back between calls. `passes` is the number of passes
    /// to run, 0 for ever; it may change from call to call.
    #[inline]
    pub fn step(&mut self, now: Ns, passes: u32, source: &impl Tables) -> Step {
        let mut t = self.piece.elapsed(now);
        if t >= self.piece.span {
            if !self.advance(now, passes, source) {
                let at = self.origin;
                return Step { pos: at.round(), motion: Motion::REST, state: State::Ended { at } };
            }
            t = self.piece.held(now);
        }
        let (pos, tau) = self.piece.at(t);
        Step { pos, motion: self.piece.motion(tau), state: State::Running }
    }

    /// Enters the segment that is in force at `now`; false if the motion has ended. Nearly always
    /// that is the next one, whose first place is at hand.
    #[inline(never)]
    fn advance(&mut self, now: Ns, passes: u32, source: &impl Tables) -> bool {
        if let Some((piece, until, after)) = self.prepared.take() {
            if piece.elapsed(now) < piece.span {
                self.go_on(piece, until, after);
                return true;
            }
        } else if self.next < self.segments {
            let after = Place::from_words(source.place(self.table, self.next.wrapping_add(1)));
            let until = self.end_of(self.next, after.time);
            let begin = ceil(self.until);
            if now.0.wrapping_sub(begin) < ceil(until).wrapping_sub(begin) {
                let piece = self.piece_between(self.ahead, after, self.until, until);
                self.go_on(piece, until, after);
                return true;
            }
        }
        self.search(now, passes, source)
    }

    /// Computes the next segment of the pass ahead of its tick, if it is not there yet, so that many axes
    /// can enter segments in one tick; call it in a tick that has time. What is prepared is what
    /// would have been computed. Says whether it computed.
    #[inline(never)]
    pub fn prepare(&mut self, source: &impl Tables) -> bool {
        let due = self.prepared.is_none() && self.next < self.segments;
        if due {
            let after = Place::from_words(source.place(self.table, self.next.wrapping_add(1)));
            let until = self.end_of(self.next, after.time);
            let piece = self.piece_between(self.ahead, after, self.until, until);
            self.prepared = Some((piece, until, after));
        }
        due
    }

    #[inline(always)]
    fn go_on(&mut self, piece: Piece, until: u128, after: Place) {
        self.piece = piece;
        self.next = self.next.wrapping_add(1);
        (self.until, self.ahead) = (until, after);
    }

    /// As [`PvtRun::advance`], wherever the segment is: behind others, in another pass or table.
    #[inline(never)]
    fn search(&mut self, now: Ns, passes: u32, source: &impl Tables) -> bool {
        let mut local = ((now.0 as u128) << 64).wrapping_sub(self.began);
        let mut from = self.next;
        // A pass may end, and the table that takes over may be shorter than the tick.
        for _ in 0..2 {
            if local < self.header.duration {
                break;
            }
            if self.ended {
                return false;
            }
            match self.end_pass(local, passes, source) {
                Some(left) => (local, from) = (left, 0),
                None => {
                    self.ended = true;
                    return false;
                }
            }
        }
        self.segments = (self.header.places as u32).saturating_sub(1);
        let segment = self.find(from, self.header.units(local), source);
        let before = Place::from_words(source.place(self.table, segment));
        let after = Place::from_words(source.place(self.table, segment.wrapping_add(1)));
        let from = self.began.wrapping_add(self.header.span(before.time));
        self.next = segment;
        let until = self.end_of(segment, after.time);
        let piece = self.piece_between(before, after, from, until);
        self.go_on(piece, until, after);
        true
    }

    /// End of a segment in 2⁻⁶⁴ ns; that of the last one is not rounded to the table's units.
    #[inline(always)]
    fn end_of(&self, segment: u32, time: u64) -> u128 {
        let last = segment.wrapping_add(1) >= self.segments;
        self.began.wrapping_add(if last { self.header.duration } else { self.header.span(time) })
    }

    /// The present pass is over, and perhaps others: what is left of `local`, or `None` at the end.
    #[inline]
    fn end_pass(&mut self, local: u128, passes: u32, source: &impl Tables) -> Option<u128> {
        let Header { duration, displacement, .. } = self.header;
        if self.pending.is_none() {
            let twice = local.wrapping_sub(duration) >= duration;
            let many = if twice { self.header.passes_in(local).max(1) } else { 1 };
            let left = passes.saturating_sub(self.passes).max(1);
            if passes != 0 && many >= left {
                self.passes = self.passes.saturating_add(left);
                self.origin.0 = self.origin.0.wrapping_add(displacement.0.wrapping_mul(left as i128));
                return None;
            }
            if twice {
                let whole = duration.wrapping_mul(many as u128);
                self.passes = self.passes.wrapping_add(many);
                self.origin.0 = self.origin.0.wrapping_add(displacement.0.wrapping_mul(many as i128));
                self.began = self.began.wrapping_add(whole);
                return Some(local.wrapping_sub(whole));
            }
        }
        self.passes = self.passes.wrapping_add(1);
        self.origin.0 = self.origin.0.wrapping_add(displacement.0);
        self.began = self.began.wrapping_add(duration);
        if let Some(table) = self.pending.take() {
            self.table = table;
            self.header = Header::from_words(source.header(table));
            self.passes = 0;
        }
        Some(local.wrapping_sub(duration))
    }

    /// The last segment from `from` on that has begun at `units`. Steps double, then halve.
    #[inline(always)]
    fn find(&self, from: u32, units: u64, source: &impl Tables) -> u32 {
        let last = (self.header.places as u32).saturating_sub(2);
        let begun = |i: u32| {
            let [time, high, ..] = source.place(self.table, i);
            table::time_of([time, high]) <= units
        };
        let mut low = from.min(last);
        let mut high = last.wrapping_add(1);
        let mut stride = 1;
        while low.wrapping_add(stride) < high {
            let probe = low.wrapping_add(stride);
            if begun(probe) {
                low = probe;
                stride <<= 1;
            } else {
                high = probe;
            }
        }
        while high.wrapping_sub(low) > 1 {
            let middle = low.wrapping_add(high) >> 1;
            if begun(middle) {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    }

    /// Computes the piece from place `a` to place `b`: displacement P, velocities v0, v1 over the
    /// length L give P(τ) = v0·L·τ + (3P − (2·v0 + v1)·L)·τ² + ((v0 + v1)·L − 2P)·τ³.
    #[inline(always)]
    fn piece_between(&self, a: Place, b: Place, from: u128, until: u128) -> Piece {
        let header = &self.header;
        let begin = ceil(from);
        let length = b.time.wrapping_sub(a.time);
        let zeros = length.leading_zeros(); // 22..=64, 64 for none at all
        let m = recip64_below(length.wrapping_shl(zeros));
        let shift = zeros.wrapping_add_signed(header.time_bits as i32); // 7..=96
        // The first whole ns comes a fraction after the knot.
        let late = (from as u64).wrapping_neg();
        let late = if shift < 64 { late >> 1 >> (63 - shift) } else { late << (shift & 31) };
        let tau = late.wrapping_add(umulhi(late, m));

        let ms = umulhi(length << (header.lift & 63), PER_MS);
        let (w0, w1) = (mulhi_su(a.vel << 20, ms), mulhi_su(b.vel << 20, ms));
        let p = scale(b.pos.wrapping_sub(a.pos), header.frac() - header.pos_bits as i32);
        let c3 = w0.wrapping_add(w1).wrapping_sub(p << 1);
        let c2 = p.wrapping_sub(w0).wrapping_sub(c3);

        let up = (64 - header.pos_bits as i32) as u32 & 63; // 2..=62
        let knot = ((a.pos >> (64 - up)) as i128) << 64 | (a.pos << up) as u64 as i128;
        Piece {
            begin: Ns(begin),
            span: ceil(until).wrapping_sub(begin),
            start: Exact(self.origin.0.wrapping_add(knot)).round(),
            motion: Motion { c: [w0, c2, c3], frac: header.frac() as u32 & 127, tau, recip: Recip { m, shift } },
        }
    }
}

/// The first whole ns not before an instant in 2⁻⁶⁴ ns.
#[inline(always)]
fn ceil(instant: u128) -> u64 {
    ((instant >> 64) as u64).wrapping_add((instant as u64 != 0) as u64)
}

/// x·2^k, to nearest.
#[inline(always)]
fn scale(x: i64, k: i32) -> i64 {
    if k >= 0 {
        x << (k as u32 & 63)
    } else {
        let twice = x >> ((-k - 1) as u32).min(63);
        (twice >> 1).wrapping_add(twice & 1)
    }
}
