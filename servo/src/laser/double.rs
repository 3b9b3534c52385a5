//! Doubles by their bits, and products of fixed point.
//!
//! In: the bits of a user's double; whole numbers. Out: fixed point, or a real; products. Owns nothing. Fails: with the
//! rule that a double breaks; what is too large for a power is held.
use super::power::Refused;
use crate::real::Real;
use crate::wide::{narrow, umul};

/// A double as a whole number of 2^-frac, to the nearest; |x| ≤ 2^most.
pub(super) fn fixed(bits: u64, frac: i32, most: u32) -> Result<i64, Refused> {
    let value = real(bits)?;
    if value.width() > most as i32 + 1 {
        return Err(Refused::BeyondRange);
    }
    let fixed = value.to_fixed(frac);
    if fixed.unsigned_abs() > 1u128 << (most as i32 + frac) as u32 {
        Err(Refused::BeyondRange)
    } else {
        Ok(fixed as i64)
    }
}

/// A double as a real; subnormals are 0.
pub(super) fn real(bits: u64) -> Result<Real, Refused> {
    let exponent = (bits >> 52 & 0x7ff) as i32;
    match exponent {
        0x7ff => Err(Refused::NotFinite),
        0 => Ok(Real::ZERO),
        _ => Ok(Real::new(bits >> 63 == 1, 1 << 52 | bits & ((1 << 52) - 1), exponent - 1075)),
    }
}

/// The largest part of a power, 2⁻⁴⁴: four of them are a number.
pub(super) const MOST: i64 = 1 << 61;

/// a·b.
#[inline(always)]
pub(super) fn product(a: i64, b: i64) -> i128 {
    let (high, low) = umul(a as u64, b as u64);
    let high = high.wrapping_sub((a >> 63) as u64 & b as u64).wrapping_sub((b >> 63) as u64 & a as u64);
    ((high as u128) << 64 | low as u128) as i128
}

/// x·2^-shift to the nearest, held in ±[`MOST`]; shift from 1 to 127.
#[inline]
pub(super) fn part(x: i128, shift: u32) -> i64 {
    let high = (x >> 64) as i64;
    // Below 2^(61 + shift) in magnitude, it fits.
    let over = if shift < 66 { high >> shift.saturating_sub(3) } else { 0 };
    if over == 0 || over == -1 {
        return narrow(x, shift as i32).clamp(-MOST, MOST);
    }
    if high < 0 { -MOST } else { MOST }
}
