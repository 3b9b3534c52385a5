//! Sine and cosine of a turn.
//!
//! In: an angle as a fraction of a turn in 2⁻⁶⁴. Out: its sine and cosine in 2⁻⁶², each within
//! 2⁻⁵⁰. Cannot fail. A table holds 256 directions of the circle. From the nearest one a short
//! series is used: |δ| ≤ π/256, so that δ⁷/5040 in the sine is below 2⁻⁵⁶ and δ⁸/40320 in the
//! cosine below 2⁻⁶⁶. Terms that are small against δ and 1 take 32-bit products, of which the worst
//! leaves 2⁻⁵⁰·⁴ (`proofs/sine.gappa`): on a circle of 2³¹ pulses 1.6·10⁻⁶ pulse
//! (`proofs/arc.gappa`).
use super::wide::{mulhi_near, umulhi};

/// π in 2⁻¹²⁵.
const PI: u128 = 0x6487_ED51_10B4_611A_6263_3145_C06E_0E68;
/// 2π in 2⁻⁶⁰.
const TAU: u64 = (PI >> 64) as u64;

/// 4/3 in 2⁻³⁰.
const FOUR_THIRDS_Q32: u32 = ((1u64 << 32) / 3) as u32;

/// Product of two numbers in 2⁻¹²⁵, a few units too small.
const fn product(a: u128, b: u128) -> u128 {
    let (a0, a1, b0, b1) = (a as u64 as u128, a >> 64, b as u64 as u128, b >> 64);
    (a1 * b1 + ((a1 * b0) >> 64) + ((a0 * b1) >> 64)) << 3
}

/// sin(2π·i/256) in 2⁻⁶² for a quarter of the circle, to nearest.
const SINES: [i64; 65] = {
    let mut table = [0; 65];
    let mut i = 0;
    while i <= 64 {
        let x = (PI >> 7) * i as u128;
        let square = product(x, x);
        let (mut term, mut sum, mut n) = (x, x, 1);
        while term != 0 {
            n += 2;
            term = product(term, square) / (n * (n - 1));
            sum = if n & 2 == 0 { sum + term } else { sum - term };
        }
        table[i] = (((sum >> 62) + 1) >> 1) as i64;
        i += 1;
    }
    table
};

#[inline(always)]
fn product32(a: u32, b: u32) -> u64 {
    a as u64 * b as u64
}

/// Sine and cosine of one of the 256 directions.
#[inline(always)]
fn direction(index: u32) -> (i64, i64) {
    let index_in_quadrant = (index & 63) as usize;
    let read = |i: usize| SINES.get(i).copied().unwrap_or(0);
    let (up, across) = (read(index_in_quadrant), read(64 - index_in_quadrant));
    match index >> 6 & 3 {
        0 => (up, across),
        1 => (across, -up),
        2 => (-up, -across),
        _ => (-across, up),
    }
}

/// Sine and cosine of `turn`·2⁻⁶⁴ of a full turn, in 2⁻⁶².
#[inline]
pub(crate) fn sin_cos(turn: u64) -> (i64, i64) {
    let index = (turn.wrapping_add(1 << 55) >> 56) as u32;
    let remainder = turn.wrapping_sub((index as u64) << 56) as i64;
    // δ in 2⁻⁶⁸, δ² in 2⁻⁷².
    let x = mulhi_near(remainder << 8, TAU as i64);
    let square = umulhi(x.unsigned_abs(), x.unsigned_abs());
    // q: δ²/6 in 2⁻⁴⁷, which is δ²/12 in 2⁻⁴⁸; q·δ² in 2⁻⁵⁹ of the first
    let short = (square >> 28) as u32;
    let q = (product32(short, FOUR_THIRDS_Q32) >> 30) as u32;
    let next = (product32(q, short) >> 32) as u32;
    let part = |n: u32| (product32(next, u32::MAX / n) >> 44) as u32;
    // sin δ = δ − δ·δ²/6·(1 − δ²/20), in 2⁻⁶⁸
    let cube = q.wrapping_sub(part(20));
    let sin = x - (((x >> 32).wrapping_mul(cube as i64)) >> 15);
    // 1 − cos δ = δ²/2·(1 − δ²/12·(1 − δ²/30)), in 2⁻⁷²
    let fourth = q.wrapping_sub(part(30));
    let gap = square.wrapping_sub(product32((square >> 32) as u32, fourth) >> 16) >> 1;
    let (up, across) = direction(index);
    let gap = gap as i64;
    let turned =
        |base: i64, other: i64| base - ((mulhi_near(base, gap) >> 4).wrapping_sub(mulhi_near(other, sin)) >> 4);
    (turned(up, across), turned(across, -up))
}

/// Coefficients (−1)ⁿ·4ⁿ/(2n + 1)! in 2⁻⁶³, the signs left to the sum.
const SERIES: [u64; 12] = {
    let mut table = [0; 12];
    let (mut n, mut value) = (0, 1u128 << 125);
    while n < 12 {
        table[n] = (value >> 62) as u64;
        n += 1;
        value = value * 4 / ((2 * n) * (2 * n + 1)) as u128;
    }
    table
};

/// sin(x)/x for x from 0 to π/2 in 2⁻⁶³; its error is below 2⁻⁵⁸, however small x is. Out in 2⁻⁶³.
pub(crate) fn sinc(x: u64) -> u64 {
    // (x/2)² in 2⁻⁶⁴: x² in 2⁻⁶² is x²/4 in 2⁻⁶⁴.
    let square = umulhi(x, x);
    SERIES.iter().rev().fold(0, |sum, coefficient| coefficient.saturating_sub(umulhi(sum, square)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_bigint::BigInt;
    use rand_xoshiro::SplitMix64;
    use rand_xoshiro::rand_core::{Rng, SeedableRng};

    /// Fraction bits of the series below.
    const BITS: u32 = 120;

    /// Sine, or sine over its argument, and cosine of x in 2⁻¹²⁰, all in 2⁻¹²⁰: their power series.
    fn series(x: &BigInt, first: &BigInt) -> (BigInt, BigInt) {
        let (mut sine, mut cosine) = (first.clone(), BigInt::from(1) << BITS);
        let (mut odd, mut even, square) = (sine.clone(), cosine.clone(), (x * x) >> BITS);
        for n in 1..32 {
            odd = -((odd * &square) >> BITS) / (2 * n * (2 * n + 1));
            even = -((even * &square) >> BITS) / (2 * n * (2 * n - 1));
            (sine, cosine) = (sine + &odd, cosine + &even);
        }
        (sine, cosine)
    }

    fn within(got: i128, bits: u32, expected: &BigInt, error: u32) -> bool {
        let gap = (BigInt::from(got) << (BITS - bits)) - expected;
        gap.magnitude() < BigInt::from(1u128 << (BITS - error)).magnitude()
    }

    #[test]
    fn agrees_with_the_power_series() {
        let mut chance = SplitMix64::seed_from_u64(0);
        for _ in 0..20_000 {
            let turn = chance.next_u64();
            let (sin, cos) = sin_cos(turn);
            // 2π·turn·2⁻⁶⁴ with π in 2⁻¹²⁵
            let x = (BigInt::from(turn as i64) * BigInt::from(PI)) >> (64 + 125 - 1 - BITS);
            let (sine, cosine) = series(&x, &x);
            assert!(within(sin as i128, 62, &sine, 49), "{turn:#x}: {sin:#x}");
            assert!(within(cos as i128, 62, &cosine, 49), "{turn:#x}: {cos:#x}");
        }
    }

    /// sin² + cos² = 1 to 2⁻⁵⁰, which no floating-point unit can tell.
    #[test]
    fn stays_on_the_circle() {
        let mut chance = SplitMix64::seed_from_u64(1);
        let mut worst = 0;
        for i in 0..200_000u64 {
            let turn = if i < 1024 { (i << 54).wrapping_sub(i & 1) } else { chance.next_u64() };
            let (sin, cos) = sin_cos(turn);
            let sum = sin as i128 * sin as i128 + cos as i128 * cos as i128;
            worst = worst.max((sum - (1 << 124)).unsigned_abs() >> 62);
        }
        assert!(worst < 1 << 12, "{worst}");
        assert_eq!(sin_cos(0), (0, 1 << 62));
        assert_eq!(sin_cos(1 << 62), (1 << 62, 0));
        assert_eq!(sin_cos(1 << 63), (0, -1 << 62));
    }

    #[test]
    fn sinc_keeps_its_digits_near_0() {
        // π/2 in 2⁻⁶³ is π in 2⁻⁶².
        for x in [0, 1, 1 << 33, 1 << 53, (1 << 63) / 10, 1 << 62, 1 << 63, 3 << 62, (PI >> 63) as u64] {
            let one = BigInt::from(1) << BITS;
            let (expected, _) = series(&(BigInt::from(x) << (BITS - 63)), &one);
            let got = sinc(x);
            assert!(within(got as i128, 63, &expected, 51), "{x}: {got:#x}");
        }
    }
}
