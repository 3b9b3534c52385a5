//! Phases of a ramp motion, their intervals of constant jerk, and pieces.
//!
//! In: the run's state where a phase or an interval begins. Out: the same state with the next
//! phase, interval or piece in it. Fails: never; what has no length is skipped.
//!
//! A piece is parameterised over a power of two of ms, not over its own length: its coefficients
//! are the velocity, the acceleration and the jerk but for shifts, and 1/length is a constant.
use super::{Acceleration, Edged, JerkPhase, Next, RampKind, RampRun, RampShape, STILL};
use crate::math::float::Float;
use crate::math::wide::umulhi;
use crate::segment::piece::{Motion, Piece, Recip};
use crate::units::{Exact, FineNs, Ns};

/// A piece covers less than 2³⁷ pulses and lasts at most 2³⁰ ms; those shorter than 2 ns need no
/// more than that.
const LENGTH_MAX_LOG2_PULSES: i32 = 35;
const TIME_MAX_LOG2_MS: i32 = 30;
const TIME_MIN_LOG2_MS: i32 = -19;
/// 10⁶ has 44 leading zeros; 1/(2^k ms) has this mantissa and a shift of 44 − k.
const MS_RECIPROCAL_MANTISSA: u64 = (u128::MAX / (1_000_000 << 44) - (1 << 64)) as u64;

fn in_ms(ms: Float) -> FineNs {
    ms.mul(Float::FINE_NS_PER_MS).to_fixed(0).unsigned_abs().min(1 << 96)
}

pub(super) fn ms(time: FineNs) -> Float {
    Float::from_fixed(time, 0).mul(Float::MS_PER_FINE_NS)
}

impl RampRun {
    /// A Trap that moves towards its target, or is at standstill: to the peak that the distance
    /// allows.
    pub(super) fn aim(&mut self) {
        let distance = Float::from_exact(Exact(self.distance()));
        if distance.is_zero() || self.peak.is_zero() {
            self.next = Next::Over;
            return;
        }
        let (back, length) = (distance.is_negative(), distance.abs());
        let signed = |x: Float| if back { x.negate() } else { x };
        let mut u = self.v.abs();
        if u.is_zero() && !self.jump.is_zero() {
            let jump = if self.peak.is_less(self.jump) { self.peak } else { self.jump };
            if !length.scale(1).is_less(self.means.stop(jump)) {
                u = jump;
                self.v = signed(u);
            }
        }
        let (peak, faster) = self.means.peak(u, self.peak, length);
        (self.peak, self.faster, self.next) = (signed(peak), faster, Next::Ramp);
    }

    /// At the peak: on for ever, or until a Trap must brake.
    pub(super) fn cruise(&mut self) {
        let v = self.peak;
        let mut len = FineNs::MAX >> 8;
        let mut span = TIME_MAX_LOG2_MS;
        if self.kind == RampKind::Jog {
            self.next = if v.is_zero() { Next::Over } else { Next::Cruise };
            if v.is_zero() {
                return;
            }
        } else {
            self.next = Next::Brake;
            let stop = self.means.stop(v.abs()).scale(-1).to_exact().0;
            let distance = self.distance();
            let cruise = distance.wrapping_sub(if v.is_negative() { -stop } else { stop });
            // In a triangle the remainder is a rounding, which the last ramp takes.
            if (cruise < 0) != v.is_negative() || cruise.unsigned_abs() >> 32 == 0 {
                return;
            }
            let time = Float::from_exact(Exact(cruise)).div(v);
            (len, span) = (in_ms(time), time.width());
            self.knot = Exact(self.knot.0.wrapping_add(cruise));
        }
        let jerk_phase = JerkPhase { len, v, ..STILL };
        self.begin(jerk_phase, span, v.width());
        self.time = self.time.wrapping_add(len);
    }

    /// The first interval of a phase, which lasts less than 2^`span` ms at less than 2^`width`
    /// pulse/ms.
    fn begin(&mut self, jerk_phase: JerkPhase, span: i32, width: i32) {
        let reach = span.min(LENGTH_MAX_LOG2_PULSES - width).clamp(TIME_MIN_LOG2_MS, TIME_MAX_LOG2_MS);
        self.jerk_phase = JerkPhase { begin: self.time, reach, ..jerk_phase };
    }

    /// Enters a ramp to `v1`; `distance` is its length, if that does not follow from its duration.
    pub(super) fn ramp(&mut self, v1: Float, rate: Acceleration, distance: Option<Exact>) {
        let v0 = self.v;
        let change = v1.sub(v0);
        self.v = v1;
        if change.is_zero() {
            return;
        }
        let along = rate.along(change.is_negative());
        let plain = change.abs().mul(rate.inverse);
        let (len, edge, top, jerk) = match self.shape {
            RampShape::Plain => (plain, Float::ZERO, along, Float::ZERO),
            RampShape::Percent { half, gain } => {
                let (edge, top) = (plain.mul(half), along.mul(gain));
                (plain, edge, top, top.mul(edge.recip()))
            }
            RampShape::Average { inverse } => {
                let wait = self.means.wait;
                let jerk = along.mul(inverse);
                let long = !plain.is_less(wait);
                let (edge, top) = if long { (wait, along) } else { (plain, change.mul(inverse)) };
                (plain.add(wait), edge, top, jerk)
            }
        };
        let distance = distance.unwrap_or_else(|| v0.add(v1).mul(len).scale(-1).to_exact());
        let total = in_ms(len);
        let width = v0.width().max(v1.width());
        if edge.is_zero() {
            self.begin(JerkPhase { len: total, v: v0, a: top, ..STILL }, len.width(), width);
        } else {
            let (sixth, gained) = (jerk.mul(Float::SIXTH), top.mul(edge).scale(-1));
            let gain = gained.mul(edge).mul(Float::THIRD);
            self.begin(JerkPhase { len: in_ms(edge), v: v0, j: sixth, ..STILL }, edge.width(), width);
            self.edged = Edged { left: 2, v1, top, sixth, gained, distance: gain, edge, width, from: self.knot };
        }
        self.knot = Exact(self.knot.0.wrapping_add(distance.0));
        self.time = self.time.wrapping_add(total);
    }

    /// The interval between the edges, which may have no length, or the last edge.
    pub(super) fn next_jerk_phase(&mut self) {
        let Edged { left, v1, top, sixth, gained, distance, edge, width, from } = self.edged;
        let s = &mut self.jerk_phase;
        s.begin += s.len;
        s.done = 0;
        let limit = LENGTH_MAX_LOG2_PULSES - width;
        if left == 2 {
            // The displacement of the first edge: that of its first velocity, and that of the
            // velocity gained.
            self.pos = Exact(from.0.wrapping_add(s.v.mul(edge).add(distance).to_exact().0));
            s.len = self.time.saturating_sub(s.begin).saturating_sub(s.len);
            (s.v, s.a, s.j) = (s.v.add(gained), top, Float::ZERO);
            // A ms is not quite 2^52 of 2^-32 ns.
            s.reach = (77 - s.len.leading_zeros() as i32).min(limit).clamp(TIME_MIN_LOG2_MS, TIME_MAX_LOG2_MS);
        } else {
            self.pos = Exact(self.knot.0.wrapping_sub(v1.mul(edge).sub(distance).to_exact().0));
            s.len = self.time.saturating_sub(s.begin);
            (s.v, s.j) = (v1.sub(gained), sixth.negate());
            s.reach = edge.width().min(limit).clamp(TIME_MIN_LOG2_MS, TIME_MAX_LOG2_MS);
        }
        self.edged.left = left - 1;
    }

    /// The next piece of the interval: all of it, or 2^reach ms.
    pub(super) fn load_piece(&mut self, piece: &mut Piece) {
        let s = &mut self.jerk_phase;
        let (mut v, mut a) = (s.v, s.a);
        if s.done != 0 {
            let t = ms(s.done);
            let bend = s.j.mul(t).mul(Float::THREE);
            v = v.add(a.add(bend).mul(t));
            a = a.add(bend.scale(1));
        }
        let k = s.reach;
        let (c1, c2, c3) = (v.scale(k), a.scale(2 * k - 1), s.j.scale(3 * k));
        let width = c1.width().max(c2.width()).max(c3.width());
        let frac = (60 - width).clamp(0, 82);
        let left = s.len - s.done;
        let start = self.pos;
        // 2^k ms.
        let whole = ((15_625u64 << (k - TIME_MIN_LOG2_MS)) as FineNs) << 19;
        let len = if left > whole {
            self.pos = Exact(self.pos.0.wrapping_add(c1.add(c2).add(c3).to_exact().0));
            whole
        } else {
            left
        };
        let begin = s.begin + s.done;
        let first = (begin + 0xffff_ffff) >> 32;
        let last = (begin + len + 0xffff_ffff) >> 32;
        s.done += len;
        let recip = Recip { m: MS_RECIPROCAL_MANTISSA, shift: (44 - k) as u32 };
        // τ at `first`, less than 1 ns after `begin`.
        let offset = ((begin as u32).wrapping_neg() as u64) << 32 >> 1 >> (63 - recip.shift);
        let motion = Motion {
            tau: offset.saturating_add(umulhi(offset, recip.m)) >> 1,
            c: [c1.to_i64(frac), c2.to_i64(frac + 1), c3.to_i64(frac + 2)],
            recip,
            frac,
            t: 0,
        };
        *piece = Piece::cubic(Ns(first as u64), (last - first) as u64, start, motion);
    }
}
