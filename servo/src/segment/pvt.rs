//! PVT: cubic pieces through points with given times, positions and velocities (SPEC 5; GXN
//! chapter 4).
//!
//! In: instants, and tables that the thread filled ([`PvtTables`]). Out: pieces. Owns: the state of
//! one running motion, [`PvtRun`]. Cannot fail: what could not run is refused when the table is
//! built.
//!
//! Nothing accumulates: a pass begins at an instant in 2⁻⁶⁴ ns and a position in 2⁻⁶⁴ pulse, to
//! which passes add the table's exact duration and displacement; a knot is added to these two
//! afresh. A segment's coefficients are computed when it is entered, by products alone. Work of a
//! call: one segment, found by at most 20 reads of times, however many knots or passes lie between
//! two ticks.
use super::generator_state::GeneratorState;
use super::piece::{Motion, Piece, Recip};
use crate::math::wide::{mulhi_su, recip64_below, umulhi};
use crate::units::{Exact, Ns};
use ring::Store;

mod table;
pub use crate::capacity::TABLES;
pub(crate) use table::VERSION;
pub use table::{
    HEADER_WORDS, Header, LONGEST_NS, POINT_WORDS, POS_BITS, Point, SHORTEST_PASS_NS, TABLE_POINTS, TIME_BITS, VEL_BITS,
};

/// Points of one table, 16 KiB.
pub type PointStore = Store<POINT_WORDS, TABLE_POINTS>;
/// Headers of all tables.
pub type HeaderStore = Store<HEADER_WORDS, TABLES>;

/// Where a run reads its tables. Tables are counted from 0.
pub trait PvtTables {
    /// The words of a point; a point that does not exist reads as zeros.
    fn point(&self, table: u8, index: u32) -> [u32; POINT_WORDS];
    /// The words of a header; a table that does not exist reads as zeros.
    fn header(&self, table: u8) -> [u32; HEADER_WORDS];
    /// How often its header was written, which is done after its points.
    fn version(&self, table: u8) -> u32 {
        let [.., version] = self.header(table);
        version
    }
    /// Whether it holds nothing.
    fn is_empty(&self, table: u8) -> bool {
        Header::from_words(self.header(table)).points == 0
    }
}

/// The state of a run after the last piece it made. In two parts, each copied in a few words at a
/// time; the whole would need a call.
#[derive(Debug, Clone, Copy)]
struct PassState {
    knot: NextKnot,
    pass: PvtPass,
}

/// The knot after the last piece.
#[derive(Debug, Clone, Copy)]
struct NextKnot {
    /// Its instant in 2⁻⁶⁴ ns, and the point there.
    until: u128,
    after: Point,
    /// The next segment.
    next: u16,
    /// Segments of a pass; 0 before the first one is entered, so that none follows.
    segments: u16,
}

/// The pass of the last piece.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PvtPass {
    /// Position of its first point.
    origin: Exact,
    /// Its instant in 2⁻⁶⁴ ns.
    pub(crate) began: u128,
    /// Passes of this table completed.
    passes: u32,
    /// The table in force, and the index of its header.
    table: u8,
    header: u8,
    /// The table that takes over when the present pass ends.
    pending: Option<u8>,
    /// All passes have run.
    ended: bool,
}

/// A PVT motion that runs.
#[derive(Debug, Clone, Copy)]
pub struct PvtRun {
    /// After the last piece made, and after the one before it.
    track: PassState,
    back: PassState,
    /// Headers of the tables of both.
    headers: [Header; 2],
    /// Version of the table that it began with.
    version: u32,
}

/// 2⁸³/10⁶ to nearest: ns to ms, top bit set.
const PER_MS: u64 = 9_671_406_556_917_033_398;

impl PvtRun {
    /// A motion whose time is zero at `now`, from the position `origin`: it stays there until the
    /// time of the table's first point.
    pub fn begin(now: Ns, origin: Exact, table: u8, source: &impl PvtTables) -> PvtRun {
        let header = Header::from_words(source.header(table));
        let began = ((now.0 as u128) << 64).wrapping_add(header.delay);
        let knot = NextKnot { until: began, after: Point::default(), next: 0, segments: 0 };
        let pass = PvtPass { origin, began, passes: 0, table, header: 0, pending: None, ended: false };
        let track = PassState { knot, pass };
        PvtRun { track, back: track, headers: [header; 2], version: source.version(table) }
    }

    /// A motion prepared for time 0 begins at `now`.
    pub(crate) fn shift(&mut self, now: Ns) {
        let by = (now.0 as u128) << 64;
        for track in [&mut self.track, &mut self.back] {
            track.pass.began = track.pass.began.wrapping_add(by);
            track.knot.until = track.knot.until.wrapping_add(by);
        }
    }

    /// Whether the table that it began with is still the same.
    #[inline]
    pub(crate) fn is_current(&self, source: &impl PvtTables) -> bool {
        self.version == source.version(self.track.pass.table)
    }

    /// `table` takes over when the present pass ends; the one in force now means no change.
    pub fn select(&mut self, table: u8) {
        self.track.pass.pending = (table != self.track.pass.table).then_some(table);
        self.back.pass.pending = self.track.pass.pending;
    }

    /// The pass of the piece in force; `ahead`: the last one made is not in force yet.
    #[inline(always)]
    pub(crate) fn state_in_force(&self, ahead: bool) -> &PvtPass {
        if ahead { &self.back.pass } else { &self.track.pass }
    }

    /// The table in force.
    pub fn table(&self, ahead: bool) -> u8 {
        self.state_in_force(ahead).table
    }

    /// The table that waits for the end of the pass.
    pub fn pending(&self, ahead: bool) -> Option<u8> {
        self.state_in_force(ahead).pending
    }

    /// Passes of this table completed.
    pub fn passes(&self, ahead: bool) -> u32 {
        self.state_in_force(ahead).passes
    }

    /// Instant at which the time of the table was 0, or would have been in a later pass; rounded
    /// down.
    pub fn zero(&self, ahead: bool) -> Ns {
        let track = self.state_in_force(ahead);
        Ns((track.began.wrapping_sub(self.header_of(track).delay) >> 64) as u64)
    }

    #[inline(always)]
    pub(crate) fn header_of(&self, pass: &PvtPass) -> &Header {
        let [first, second] = &self.headers;
        if pass.header == 0 { first } else { second }
    }

    #[inline(always)]
    fn header(&self) -> &Header {
        self.header_of(&self.track.pass)
    }

    /// Whether the last piece made begins a pass.
    #[inline]
    pub fn is_new_pass(&self) -> bool {
        self.track.pass.began != self.back.pass.began
    }

    /// As if the last piece had not been made.
    #[inline(never)]
    pub fn retract(&mut self) {
        self.track = self.back;
    }

    /// Makes the piece that holds `now`, which is not before the end of the last one made; or the
    /// end. Nearly always that is the next one, whose first point is at hand. `passes` is the
    /// number of passes to run, 0 for ever; it may change from call to call.
    #[inline(never)]
    pub fn advance(&mut self, now: Ns, passes: u32, source: &impl PvtTables, piece: &mut Piece) -> GeneratorState {
        self.back.knot = self.track.knot;
        self.back.pass = self.track.pass;
        let NextKnot { next, segments, until: from, after: before } = self.track.knot;
        if next < segments {
            let after = Point::from_words(source.point(self.track.pass.table, next as u32 + 1));
            let until = self.end_of(next, after.time);
            let begin = ceil(from);
            if now.0.wrapping_sub(begin) < ceil(until).wrapping_sub(begin) {
                *piece = self.piece_between(before, after, from, until);
                self.go_on(next, until, after);
                return GeneratorState::Running;
            }
        }
        self.search(now, passes, source, piece)
    }

    #[inline(always)]
    fn go_on(&mut self, segment: u16, until: u128, after: Point) {
        let knot = &mut self.track.knot;
        knot.next = segment.wrapping_add(1);
        (knot.until, knot.after) = (until, after);
    }

    /// As [`PvtRun::advance`], wherever the segment is: after others, in another pass or table.
    #[inline(never)]
    fn search(&mut self, now: Ns, passes: u32, source: &impl PvtTables, piece: &mut Piece) -> GeneratorState {
        let mut local = ((now.0 as u128) << 64).wrapping_sub(self.track.pass.began);
        if local >> 127 != 0 {
            // Before the time of the first point.
            let begin = self.zero(false);
            let span = ceil(self.track.pass.began).wrapping_sub(begin.0);
            *piece = Piece::standstill(begin, span, self.track.pass.origin.round());
            return GeneratorState::Running;
        }
        let mut from = self.track.knot.next;
        // A pass may end, and the table that takes over may be shorter than the tick.
        for _ in 0..2 {
            if local < self.header().duration {
                break;
            }
            let left = if self.track.pass.ended { None } else { self.end_pass(local, passes, source) };
            match left {
                Some(left) => (local, from) = (left, 0),
                None => {
                    self.track.pass.ended = true;
                    return GeneratorState::Ended { at: self.track.pass.origin };
                }
            }
        }
        let header = self.header();
        let (segments, units) = (header.points.saturating_sub(1), header.units(local));
        let segment = self.find(from as u32, units, source) as u16;
        let before = Point::from_words(source.point(self.track.pass.table, segment as u32));
        let after = Point::from_words(source.point(self.track.pass.table, segment as u32 + 1));
        let from = self.track.pass.began.wrapping_add(header.span(before.time));
        self.track.knot.segments = segments;
        let until = self.end_of(segment, after.time);
        *piece = self.piece_between(before, after, from, until);
        self.go_on(segment, until, after);
        GeneratorState::Running
    }

    /// End of a segment in 2⁻⁶⁴ ns; that of the last one is not rounded to the table's units.
    #[inline(always)]
    fn end_of(&self, segment: u16, time: u64) -> u128 {
        let last = segment.wrapping_add(1) >= self.track.knot.segments;
        let header = self.header();
        self.track.pass.began.wrapping_add(if last { header.duration } else { header.span(time) })
    }

    /// The present pass is over, and perhaps others: the remainder of `local`, or `None` at the
    /// end.
    #[inline]
    fn end_pass(&mut self, local: u128, passes: u32, source: &impl PvtTables) -> Option<u128> {
        let header = self.header();
        let Header { duration, displacement, .. } = *header;
        let track = &self.track.pass;
        let mut many = 1;
        if track.pending.is_none() {
            if local.wrapping_sub(duration) >= duration {
                many = header.passes_in(local).max(1);
            }
            let left = passes.saturating_sub(track.passes).max(1);
            if passes != 0 && many >= left {
                let track = &mut self.track.pass;
                track.passes = track.passes.saturating_add(left);
                track.origin.0 = track.origin.0.wrapping_add(displacement.0.wrapping_mul(left as i128));
                return None;
            }
        }
        let (whole, displacement) = if many == 1 {
            (duration, displacement.0)
        } else {
            (duration.wrapping_mul(many as u128), displacement.0.wrapping_mul(many as i128))
        };
        let track = &mut self.track.pass;
        track.passes = track.passes.wrapping_add(many);
        track.origin.0 = track.origin.0.wrapping_add(displacement);
        track.began = track.began.wrapping_add(whole);
        if let Some(table) = track.pending.take() {
            // The header of the table before stays, in case of a step back.
            (track.table, track.passes, track.header) = (table, 0, track.header ^ 1);
            let [first, second] = &mut self.headers;
            *(if track.header == 0 { first } else { second }) = Header::from_words(source.header(table));
        }
        Some(local.wrapping_sub(whole))
    }

    /// The last segment from `from` on that has begun at `units`. Steps double, then halve.
    #[inline(always)]
    fn find(&self, from: u32, units: u64, source: &impl PvtTables) -> u32 {
        let last = (self.header().points as u32).saturating_sub(2);
        let begun = |i: u32| {
            let [time, high, ..] = source.point(self.track.pass.table, i);
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

    /// Computes the piece from point `a` to point `b`: displacement P, velocities v0, v1 over the
    /// length L give P(τ) = v0·L·τ + (3P − (2·v0 + v1)·L)·τ² + ((v0 + v1)·L − 2P)·τ³.
    #[inline(always)]
    fn piece_between(&self, a: Point, b: Point, from: u128, until: u128) -> Piece {
        let header = self.header();
        let begin = ceil(from);
        let length = b.time.wrapping_sub(a.time);
        let zeros = length.leading_zeros(); // 20..=64, 64 for none at all
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

        let up = (64 - header.pos_bits as i32) as u32 & 63; // 2..=63
        let knot = ((a.pos >> (64 - up)) as i128) << 64 | (a.pos << up) as u64 as i128;
        let start = Exact(self.track.pass.origin.0.wrapping_add(knot));
        let motion = Motion {
            tau: tau >> 1,
            c: [quarter(w0), quarter(c2 << 1), c3],
            recip: Recip { m, shift },
            frac: header.frac() - 2,
            t: 0,
        };
        Piece::cubic(Ns(begin), ceil(until).wrapping_sub(begin), start, motion)
    }
}

/// x/4 to nearest.
#[inline(always)]
fn quarter(x: i64) -> i64 {
    (x >> 2) + (x >> 1 & 1)
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
