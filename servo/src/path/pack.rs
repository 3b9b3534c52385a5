//! Doubles in fewer bits, as an entry stores them: 6 bits of exponent, the mantissa without its leading one.
//!
//! In: the bits of a double that is 0 or from 2⁻⁴⁷ to 2¹⁵. Out: the same rounded to a shorter mantissa. Cannot fail.
use crate::real::Real;

/// Exponent of a double whose code is 0.
const BASE: u64 = 1023 - 48;

/// A double with `mantissa` bits of mantissa; 0 for what is below 2⁻⁴⁷.
pub(super) fn pack(bits: u64, mantissa: u32) -> u64 {
    let wide = bits.saturating_sub(BASE << 52);
    if wide >> 52 == 0 {
        return 0;
    }
    (wide + (1 << (51 - mantissa))) >> (52 - mantissa)
}

/// What [`pack`] made.
pub(super) fn unpack(packed: u64, mantissa: u32) -> u64 {
    if packed == 0 { 0 } else { (packed << (52 - mantissa)) + (BASE << 52) }
}

/// A positive double as a real; 0 for what is not a normal positive number.
pub(super) fn real(bits: u64) -> Real {
    let exponent = (bits >> 52) as i32;
    if exponent == 0 || exponent >= 0x7ff {
        return Real::ZERO;
    }
    Real::new(false, 1 << 52 | bits & ((1 << 52) - 1), exponent - 1075)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_what_fits_and_rounds_the_rest() {
        let short = |x: f64, mantissa| f64::from_bits(unpack(pack(x.to_bits(), mantissa), mantissa));
        for x in [0.0, 1.0, 0.5, 32768.0, 32767.0, 50.0, 0.25 + 2f64.powi(-20), 2f64.powi(-47)] {
            assert_eq!((short(x, 32), short(x, 38)), (x, x));
            assert!(pack(x.to_bits(), 38) < 1 << 44);
        }
        let error = (short(1.0 / 3.0, 38) - 1.0 / 3.0).abs();
        assert!(error > 0.0 && error <= 2f64.powi(-41), "{error:e}");
        // Rounding up reaches the next power of two.
        assert_eq!(short(2f64.next_down(), 32), 2.0);
        assert_eq!(short(2f64.powi(-48), 32), 0.0);
        assert_eq!(real(0.3f64.to_bits()).to_fixed(60), (0.3 * 2f64.powi(60)) as i128);
    }
}
