//! A double in 58 bits and a sign: the user's number, down to 2⁻⁶⁴ pulse.
//!
//! In: the bits of a double below 2⁴¹. Out: two words, and the number in 2⁻⁶⁴ pulse. Numbers below
//! 2⁻¹¹ become multiples of 2⁻⁶⁴, the others lose nothing. Fails: [`NoNumber`] says what it is not.

use crate::math::wide::packed;

/// Fraction (52 bits) and field of the exponent (6 bits) of a magnitude.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Compact {
    pub(super) low: u32,
    /// Bits 0–19 fraction, 20–25 exponent.
    pub(super) high: u32,
}

/// Bits of the second word.
pub(super) const HIGH_BITS: u32 = 26;

/// What a double is, if not a number that fits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NoNumber {
    NotFinite,
    TooLarge,
}

impl Compact {
    /// The magnitude of a double up to 2^`most`, `most` ≤ 41.
    pub(super) fn pack(bits: u64, most: u32) -> Result<Compact, NoNumber> {
        let exponent = (bits >> 52 & 0x7ff) as u32;
        let fraction = bits & ((1 << 52) - 1);
        if exponent == 0x7ff {
            return Err(NoNumber::NotFinite);
        }
        if exponent > 1023 + most || exponent == 1023 + most && fraction != 0 {
            return Err(NoNumber::TooLarge);
        }
        let packed = packed(bits & (u64::MAX >> 1));
        Ok(Compact { low: packed as u32, high: (packed >> 32) as u32 & 0x03ff_ffff })
    }

    /// The magnitude in 2⁻⁶⁴.
    #[inline(always)]
    pub(super) fn magnitude(self) -> i128 {
        let field = self.high >> 20 & 0x3f;
        let normal = field.min(1);
        let mantissa = ((self.high & 0xf_ffff | normal << 20) as u64) << 32 | self.low as u64;
        let shift = field - normal; // 0..=62
        let high = mantissa >> 1 >> (63 - shift);
        ((high as u128) << 64 | (mantissa << shift) as u128) as i128
    }
}
