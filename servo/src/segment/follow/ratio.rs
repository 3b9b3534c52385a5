//! Velocity ratios: quotients and products wide enough that a chain of them does not drift.
//!
//! In: displacements in 2⁻⁶⁴ pulse, ratios in 2⁻⁸⁰. Out: the same. Nothing fails; what could exceed
//! its type is refused when data is admitted.

/// Fraction bits of a ratio.
pub(super) const RATIO_BITS: u32 = 80;

/// x/m in 2⁻⁸⁰, to nearest, for 0 < m < 2⁹⁶ and quotients below 2⁴⁶. A step a bit: for the thread
/// only.
pub(super) fn quotient(x: i128, m: u128) -> i128 {
    let (mut remainder, mut q) = (0u128, 0u128);
    let x0 = x.unsigned_abs();
    for i in (0..128 + RATIO_BITS).rev() {
        let bit = if i >= RATIO_BITS { x0 >> (i - RATIO_BITS) & 1 } else { 0 };
        remainder = remainder << 1 | bit;
        q <<= 1;
        if remainder >= m {
            remainder -= m;
            q |= 1;
        }
    }
    let q = q.wrapping_add((remainder << 1 >= m) as u128) as i128;
    if x < 0 { q.wrapping_neg() } else { q }
}

/// Product of two magnitudes: high and low half.
pub(super) fn product(a: u128, b: u128) -> (u128, u128) {
    let (a0, a1) = (a as u64, (a >> 64) as u64);
    let (b0, b1) = (b as u64, (b >> 64) as u64);
    let wide = |a: u64, b: u64| a as u128 * b as u128;
    let low = wide(a0, b0);
    let (mid, carry) = wide(a0, b1).overflowing_add(wide(a1, b0));
    let (low, more) = low.overflowing_add(mid << 64);
    let high = wide(a1, b1).wrapping_add(mid >> 64).wrapping_add((carry as u128) << 64).wrapping_add(more as u128);
    (high, low)
}

/// ratio·m in 2⁻⁶⁴ pulse, m > 0; held below 2⁵⁶ pulses.
pub(super) fn start_displacement(ratio: i128, m: u128) -> i128 {
    let (high, low) = product(ratio.unsigned_abs(), m);
    let magnitude = if high >> (RATIO_BITS - 8) != 0 {
        i128::MAX >> 7
    } else {
        ((high << (128 - RATIO_BITS)) | low >> RATIO_BITS) as i128
    };
    if ratio < 0 { -magnitude } else { magnitude }
}
