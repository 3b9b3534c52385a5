//! From an entry to a piece: the slave's position over the master's progress.
//!
//! In: a segment's ends and its displacement at the start ratio, in 2⁻⁶⁴ pulse. Out: a [`Piece`]
//! whose parameter is the progress in units of [`Pos`](crate::units::Pos) instead of ns. Products
//! only. Cannot fail.
//!
//! With R₀ = r₀·M and displacement P, a segment of percentage 0 is R₀·τ + (P − R₀)·τ². Shaped (SPEC
//! 5, Percent), with k = percent/200, its ratio changes by R₁ − R₀ = 2(P − R₀) with a slope that
//! rises over k, holds a = (R₁ − R₀)/(1 − k), and falls over k: three pieces. Those of an
//! asymmetric S are segments of their own: R₀·τ + (P − R₀)·τ³, and R₀·τ + (P − R₀)·(3τ² − τ³)/2.
use super::entry::{FollowEntry, FollowEntryKind, SCurvePart};
use super::ratio::RATIO_BITS;
use crate::math::wide::{mulhi_su, narrow, recip64_below, umulhi};
use crate::segment::piece::{Motion, Piece, Recip};
use crate::units::{Exact, Ns, Pos};

/// From 2⁻⁶⁴ pulse to units of Pos.
pub(super) const EXACT_TO_POS_BITS: u32 = 64 - Pos::FRAC_BITS;
/// 1/200 and 1/6 in 2⁻⁶⁴.
const TWO_HUNDREDTH_Q64: u64 = u64::MAX / 200;
const SIXTH_Q64: u64 = u64::MAX / 6;
/// 200/(200 − percent) in 2⁻⁶².
const GAIN_Q62: [u64; 101] = {
    let mut table = [0; 101];
    let mut percent = 0;
    while percent <= 100 {
        table[percent] = ((200u128 << 62) / (200 - percent as u128)) as u64;
        percent += 1;
    }
    table
};

/// A segment as the motion runs through it.
#[derive(Debug, Clone, Copy)]
pub(super) struct CurveSegment {
    /// Master's progress at both ends, from the start of the pass.
    pub(super) from: i128,
    pub(super) to: i128,
    /// Slave there.
    begin: i128,
    end: i128,
    /// Displacement at the start ratio.
    at_start: i128,
    percent: u32,
    part: Option<SCurvePart>,
}

impl CurveSegment {
    /// The segment of `entry` after `before`. A NORMAL one starts at a ratio that differs from that
    /// of its chain by what `more` makes of its length.
    pub(super) fn between(
        before: Option<FollowEntry>,
        entry: FollowEntry,
        more: impl FnOnce(i128) -> i128,
    ) -> CurveSegment {
        let (from, begin) = before.map_or((0, 0), FollowEntry::ends);
        let (to, end) = entry.ends();
        let displacement = end.wrapping_sub(begin);
        let at_start = match entry.kind() {
            Some(FollowEntryKind::Even) => displacement,
            Some(FollowEntryKind::Stop) => displacement << 1,
            Some(FollowEntryKind::Part(_)) => entry.at_start(),
            _ => entry.at_start().wrapping_add(more(to.wrapping_sub(from))),
        };
        let part = if let Some(FollowEntryKind::Part(part)) = entry.kind() { Some(part) } else { None };
        CurveSegment { from, to, begin, end, at_start, percent: if part.is_none() { entry.percent() } else { 0 }, part }
    }

    /// The slave's position at its start, of the pass that began at `origin`.
    pub(super) fn start(&self, origin: i128) -> i128 {
        origin.wrapping_add(self.begin)
    }

    /// The ratio at its start, 2⁻⁸⁰.
    pub(super) fn start_ratio(&self) -> i128 {
        ratio_at(&self.piece(self.from, 0, 0).motion, 0)
    }

    /// The ratio at its end.
    pub(super) fn end_ratio(&self) -> i128 {
        ratio_at(&self.piece(self.to.wrapping_sub(1), 0, 0).motion, Piece::TAU_END)
    }

    /// The piece that holds the progress `x` of the pass that began at `began` (master) and
    /// `origin` (slave).
    pub(super) fn piece(&self, x: i128, began: i128, origin: i128) -> Piece {
        let (length, displacement) = (self.to.wrapping_sub(self.from), self.end.wrapping_sub(self.begin));
        let (from, start) = (began.wrapping_add(self.from), origin.wrapping_add(self.begin));
        let r0 = self.at_start;
        let half = displacement.wrapping_sub(r0);
        if self.percent == 0 || half == 0 {
            // The mean is above R₀ by a third of the change of the ratio, two thirds, or half of
            // it.
            let [second, third] = match self.part {
                Some(SCurvePart::Rise) => [0, half],
                Some(SCurvePart::Fall) => [half.wrapping_mul(3) >> 1, half.wrapping_neg() >> 1],
                Some(SCurvePart::Constant) | None => [half, 0],
            };
            return cubic(from, length, start, [r0, second, third]);
        }
        let full = self.percent == 100;
        let k = if full { 1 << 63 } else { TWO_HUNDREDTH_Q64.wrapping_mul(self.percent as u64) };
        let edge = times(length, k);
        let gain = GAIN_Q62.get(self.percent as usize).copied().unwrap_or(1 << 62);
        // a, a·k, a·k²
        let slope = times(half, gain) << 3;
        let once = times(slope, k);
        let twice = times(once, k);
        let sixth = times(twice, SIXTH_Q64);
        let y = x.wrapping_sub(self.from);
        if y < edge {
            return cubic(from, edge, start, [times(r0, k), 0, sixth]);
        }
        // A full S has two pieces: an interval that the odd last bit would leave between them has
        // no ratio.
        let to_end = if full { edge } else { length.wrapping_sub(edge) };
        if y < to_end {
            let ratio = r0.wrapping_add(once >> 1);
            let c1 = ratio.wrapping_sub(times(ratio, k) << 1);
            let c2 = (slope >> 1).wrapping_sub(once << 1).wrapping_add(twice << 1);
            let start = start.wrapping_add(times(r0, k)).wrapping_add(sixth);
            return cubic(from.wrapping_add(edge), to_end.wrapping_sub(edge), start, [c1, c2, 0]);
        }
        let r1 = (displacement << 1).wrapping_sub(r0);
        let ratio = r1.wrapping_sub(once >> 1);
        let start = origin.wrapping_add(self.end).wrapping_sub(times(r1, k)).wrapping_add(sixth);
        cubic(
            from.wrapping_add(to_end),
            length.wrapping_sub(to_end),
            start,
            [times(ratio, k), twice >> 1, sixth.wrapping_neg()],
        )
    }
}

/// x·f/2⁶⁴, towards 0.
pub(super) fn times(x: i128, f: u64) -> i128 {
    let magnitude = x.unsigned_abs();
    let low = umulhi(magnitude as u64, f) as u128;
    let (high, mid) = crate::math::wide::umul((magnitude >> 64) as u64, f);
    let product = ((high as u128) << 64 | mid as u128).wrapping_add(low) as i128;
    if x < 0 { product.wrapping_neg() } else { product }
}

/// The first whole unit of Pos not before a position in 2⁻⁶⁴ pulse.
#[inline(always)]
pub(super) fn ceil(x: i128) -> i64 {
    (x.wrapping_add((1 << EXACT_TO_POS_BITS) - 1) >> EXACT_TO_POS_BITS) as i64
}

/// A piece over `length` from `from` on, in 2⁻⁶⁴ pulse of the master.
pub(super) fn cubic(from: i128, length: i128, start: i128, c: [i128; 3]) -> Piece {
    let magnitude = c.iter().fold(0u128, |bits, x| bits | (x ^ (x >> 127)) as u128);
    let width = 128 - magnitude.leading_zeros() as i32;
    // Largest coefficient of τ just below 2^60.
    let k = (width - 60).clamp(-18, 67);
    let [c1, c2, c3] = c;

    // The length as d·2^s, rounded up, so that no quotient by it is above the true one.
    let length = (length as u128).max(1);
    let s = 64 - length.leading_zeros() as i32;
    let (mut d, mut s) = if s <= 0 {
        ((length << (-s as u32 & 127)) as u64, s)
    } else {
        let d = (length >> s) as u64;
        (d.wrapping_add((length & ((1 << s) - 1) != 0) as u64), s)
    };
    if d == 0 {
        (d, s) = (1 << 63, s + 1);
    }
    let m = recip64_below(d);
    let begin = ceil(from);
    let late = ((begin as i128) << EXACT_TO_POS_BITS).wrapping_sub(from) as u64;
    let late = if s >= 0 { late >> (s as u32 & 63) } else { late << (-s as u32 & 63) };
    let span = (ceil(from.wrapping_add(length as i128)) as u64).wrapping_sub(begin as u64);
    let motion = Motion {
        tau: late.wrapping_add(umulhi(late, m)) >> 1,
        c: [narrow(c1, k), narrow(c2, k - 1), narrow(c3, k - 2)],
        recip: Recip { m, shift: (EXACT_TO_POS_BITS as i32 - s) as u32 },
        frac: 64 - k,
        t: 0,
    };
    Piece::cubic(Ns(begin as u64), span, Exact(start), motion)
}

/// The ratio at the parameter `tau` of a piece, 2⁻⁸⁰.
pub(super) fn ratio_at(motion: &Motion, tau: u64) -> i128 {
    // slope·2^-frac per length, and 1/length = 2·mantissa·2^(shift − 128) per unit of 2^-22 pulse.
    let mantissa = 1 << 63 | motion.recip.m >> 1;
    let up = motion.recip.shift as i32 - motion.frac + (RATIO_BITS as i32 + Pos::FRAC_BITS as i32 + 3 - 64);
    let product = mulhi_su(slope(motion, tau), mantissa) as i128;
    if up >= 0 { product << (up as u32).min(64) } else { product >> (up.unsigned_abs()).min(127) }
}

/// A quarter of dP/dτ = c1 + c2·τ + 3/4·c3·τ² in 2^-frac pulse: room for the sum.
#[inline(always)]
pub(super) fn slope(motion: &Motion, tau: u64) -> i64 {
    let ([c1, c2, c3], tau) = (motion.c, tau << 1);
    let bend = (c2 >> 2).wrapping_add(mulhi_su(3 * (c3 >> 4), tau));
    (c1 >> 2).wrapping_add(mulhi_su(bend, tau))
}

/// A quarter of d²P/dτ² = c2 + 3/2·c3·τ in 2^-frac pulse.
#[inline(always)]
pub(super) fn bend(motion: &Motion, tau: u64) -> i64 {
    let [_, c2, c3] = motion.c;
    (c2 >> 2).wrapping_add(mulhi_su(3 * (c3 >> 3), tau << 1))
}
