//! Doubles by their bits.
//!
//! In: the bits of a user's double. Out: fixed point, or a real. Owns nothing. Fails: with the rule that it breaks.
use super::power::Refused;
use crate::real::Real;

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
