//! Doubles in fewer bits, as an entry stores them: 6 bits of exponent, the mantissa without its
//! leading one.
//!
//! In: the bits of a double that is 0 or from 2⁻⁴⁷ to 2¹⁵. Out: the same rounded to a shorter
//! mantissa. Cannot fail.
use crate::math::float::Float;

/// Exponent of a double whose code is 0.
const BASE_EXPONENT: u64 = 1023 - 48;

/// A double with `mantissa` bits of mantissa; 0 for those below 2⁻⁴⁷.
pub(super) fn pack(bits: u64, mantissa: u32) -> u64 {
    let wide = bits.saturating_sub(BASE_EXPONENT << 52);
    if wide >> 52 == 0 {
        return 0;
    }
    (wide + (1 << (51 - mantissa))) >> (52 - mantissa)
}

/// The inverse of [`pack`].
pub(super) fn unpack(packed: u64, mantissa: u32) -> u64 {
    if packed == 0 { 0 } else { (packed << (52 - mantissa)) + (BASE_EXPONENT << 52) }
}

/// A positive double as a real; 0 for what is not a normal positive number.
pub(super) fn float(bits: u64) -> Float {
    let exponent = (bits >> 52) as i32;
    if exponent == 0 || exponent >= 0x7ff {
        return Float::ZERO;
    }
    Float::new(false, 1 << 52 | bits & ((1 << 52) - 1), exponent - 1075)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Doubles by their bits; above 0, bits of neighbours differ by 1.
    #[test]
    fn keeps_what_fits_and_rounds_the_rest() {
        let short = |bits, mantissa| unpack(pack(bits, mantissa), mantissa);
        let power = |exponent: i32| ((1023 + exponent) as u64) << 52;
        // 0, 1, 1/2, 32768, 32767, 50, 1/4 + 2^-20, 2^-47
        let (top, fifty) = (0x40DF_FFC0_0000_0000, 0x4049_0000_0000_0000);
        for bits in [0, power(0), power(-1), power(15), top, fifty, power(-2) | 1 << 34, power(-47)] {
            assert_eq!((short(bits, 32), short(bits, 38)), (bits, bits));
            assert!(pack(bits, 38) < 1 << 44);
        }
        // A third, to 2^-41: its last bit is 2^-54.
        let third = power(-2) | 0x5_5555_5555_5555;
        let error = short(third, 38).abs_diff(third);
        assert!(error > 0 && error <= 1 << 13, "{error}");
        // Rounding up reaches the next power of two.
        assert_eq!(short(power(1) - 1, 32), power(1));
        assert_eq!(short(power(-48), 32), 0);
        assert_eq!(float(power(-2) | 0x3_3333_3333_3333).to_fixed(60), 0x13_3333_3333_3333 << 6);
    }
}
