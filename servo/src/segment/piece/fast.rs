//! A fast-path piece: its cubic over whole ns since its begin.
//!
//! In: a piece when it is made. Out: its position at a time, by 32-bit factors of the time. Owns:
//! the coefficients over x = t/2ᵏ, where 2ᵏ ns is the least power of two above the span: so x has
//! 31 bits, no error, and costs one shift. Cannot fail: a piece that does not fit is no fast-path
//! piece, and takes the exact products of the parameter.
//!
//! Coefficients are in 2⁻³⁰ pulse. Three roundings of them, that of the begin and three of the sums
//! are 3.24 units at most (`proofs/fast_path.gappa`), less than 2⁻²⁸ pulse.
use super::{CUT_BITS, Motion};
use crate::math::wide::{Recip, mulhi_su, umulhi};
use crate::units::{Exact, Pos};

/// Bits of the coefficients below a [`Pos`].
const GUARD_BITS: u32 = 8;

/// What the tick needs of a fast-path piece.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub(super) struct FastPiece {
    /// The span, ns; 0 if the piece is no fast-path piece.
    pub(super) span: u32,
    /// 2³¹⁻ᵏ: x in 2⁻³¹ is so many times the time.
    power: u32,
    /// Coefficients of x, x² and x³, times 2, 4, 8: the last one first.
    cubic: [i64; 3],
    /// The position at the begin: the bits below a [`Pos`], plus a half, and the position.
    remainder: i64,
    base: i64,
    /// 2⁹⁵/length: t times it is τ in 2⁻⁹⁵.
    rate: [u32; 3],
    /// Of a piece on the fast path or off it: what its exact start has above its rounded one,
    /// 2⁻⁵⁴ pulse. It is here because there is room.
    pub(super) start_remainder: i32,
}

impl FastPiece {
    /// For a piece off the fast path.
    pub(super) const NONE: FastPiece =
        FastPiece { span: 0, power: 0, cubic: [0; 3], remainder: 0, base: 0, rate: [0; 3], start_remainder: 0 };

    /// Of a piece from `start` at τ = 0.
    #[inline(always)]
    pub(super) fn of(span: u64, start: Exact, motion: &Motion) -> FastPiece {
        let Motion { tau, c, recip: Recip { m, shift: zeros }, frac, .. } = *motion;
        // The span is below 2^k, the length 2^(64 - zeros)/(1 to 2): their quotient is the mantissa
        // shifted `down`.
        let k = 64u32.wrapping_sub(span.leading_zeros());
        let down = 65u32.wrapping_sub(k).wrapping_sub(zeros);
        if !((11..=31).contains(&k) && down < 63 && zeros >= 32 && (40..=82).contains(&frac)) {
            return FastPiece::NONE;
        }
        let over = (1 << 63 | m >> 1) >> down;
        let ([c1, c2, c3], Exact(start), frac) =
            if tau == 0 { (c, start, frac as u32) } else { moved(c, tau << 1, start, frac as u32) };
        let mut cubic = [0, 0, cut(mulhi_su(c1, over), frac.wrapping_sub(33))];
        if c2 | c3 != 0 {
            let square = umulhi(over, over);
            let [third, second, _] = &mut cubic;
            *second = cut(mulhi_su(c2, square), frac.wrapping_sub(35));
            if c3 != 0 {
                *third = cut(mulhi_su(c3, umulhi(square, over)), frac.wrapping_sub(37));
            }
        }
        let half = start.wrapping_add(1 << (CUT_BITS - 1));
        let (m0, m1) = ((m >> 1) as u32, (m >> 33) as u32 | 1 << 31);
        // A piece of less than a ns has its first instant only.
        let s = zeros & 31;
        let rate = if zeros < 64 { [m0 << s, m1 << s | m0 >> 1 >> (31 - s), m1 >> 1 >> (31 - s)] } else { [0; 3] };
        FastPiece {
            span: span as u32,
            power: 1 << (31u32.wrapping_sub(k) & 31),
            cubic,
            remainder: (half >> (CUT_BITS - GUARD_BITS)) as i64 & ((1 << GUARD_BITS) - 1),
            base: (half >> CUT_BITS) as i64,
            rate,
            start_remainder: 0,
        }
    }

    /// The position at `t` < `span`.
    #[inline(always)]
    pub(super) fn at(&self, t: u32) -> Pos {
        let x = t.wrapping_mul(self.power);
        let [third, second, first] = self.cubic;
        let slope = times(times(third, x, second), x, first);
        Pos(self.base.wrapping_add(times(slope, x, self.remainder) >> GUARD_BITS))
    }

    /// The same for a cubic that has its first coefficient only.
    #[inline(always)]
    pub(super) fn at_even(&self, t: u32) -> Pos {
        let (x, [_, _, first]) = (t.wrapping_mul(self.power), self.cubic);
        Pos(self.base.wrapping_add(times(first, x, self.remainder) >> GUARD_BITS))
    }

    /// How far τ is at `t` from its value at the begin, 2⁻⁶³.
    #[inline(always)]
    pub(super) fn tau_from_begin(&self, t: u32) -> u64 {
        let [r0, r1, r2] = self.rate;
        let p1 = product(t, r1).wrapping_add(product(t, r0) >> 32);
        let p2 = t.wrapping_mul(r2).wrapping_add((p1 >> 32) as u32);
        (p2 as u64) << 32 | p1 as u32 as u64
    }
}

#[inline(always)]
fn product(a: u32, b: u32) -> u64 {
    a as u64 * b as u64
}

/// u·x/2³² + `plus` of x below 2³¹, less than 1 below the true value.
#[inline(always)]
fn times(u: i64, x: u32, plus: i64) -> i64 {
    let low = (product(u as u32, x) >> 32) as i64;
    plus.wrapping_add(low).wrapping_add(((u >> 32) as i32 as i64).wrapping_mul(x as i32 as i64))
}

/// x·2^-by to the nearest; `by` from 1 to 63.
#[inline(always)]
fn cut(x: i64, by: u32) -> i64 {
    (x >> (by.wrapping_sub(1) & 63)).wrapping_add(1) >> 1
}

/// The cubic around the parameter `by` (2⁻⁶⁴), with two fraction bits less, so that its sums have
/// room.
#[inline(never)]
fn moved([c1, c2, c3]: [i64; 3], by: u64, start: Exact, frac: u32) -> ([i64; 3], Exact, u32) {
    let ([c1, c2, c3], frac) = ([c1 >> 2, c2 >> 2, c3 >> 2], frac.wrapping_sub(2));
    let (third, second) = (mulhi_su(c3, by), mulhi_su(c2, by));
    let square = mulhi_su(third, by);
    let displacement = mulhi_su(c1.wrapping_add(second >> 1).wrapping_add(square >> 2), by);
    let to = (displacement as i128).wrapping_shl(64).wrapping_shr(frac);
    let first = c1.wrapping_add(second).wrapping_add(square.wrapping_mul(3) >> 2);
    let second = c2.wrapping_add(third.wrapping_mul(3) >> 1);
    ([first, second, c3], Exact(start.0.wrapping_add(to)), frac)
}
