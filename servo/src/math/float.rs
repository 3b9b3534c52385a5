//! Float numbers for planners: 64-bit mantissa, wide exponent, no floating-point unit.
//!
//! Each result is within a few 2⁻⁶³ of itself, if nothing else is said. Nothing overflows to
//! nonsense: exponents hold every product of admitted speeds, accelerations and times; conversions
//! to fixed point saturate.
use super::wide::{mulhi_su, recip64, umul, umulhi};
use crate::units::Exact;

/// A real number m·2^-e.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Scaled {
    /// Mantissa.
    pub m: i64,
    /// Negative exponent.
    pub e: i16,
}

/// ±m·2^e, with the top bit of `m` set, or 0. A word for the sign: a structure without gaps is
/// copied in words.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Float {
    m: u64,
    e: i32,
    /// 1 below 0.
    neg: u32,
}

// Not operators: each of these is a call of some fifty instructions, and should look like one.
#[allow(clippy::should_implement_trait)]
impl Float {
    /// Zero.
    pub const ZERO: Float = Float { neg: 0, m: 0, e: 0 };
    /// One.
    pub const ONE: Float = Float { neg: 0, m: 1 << 63, e: -63 };
    /// 1/6.
    pub const SIXTH: Float = Float { neg: 0, m: 0xAAAA_AAAA_AAAA_AAAB, e: -66 };
    /// 1/3.
    pub const THIRD: Float = Float { neg: 0, m: 0xAAAA_AAAA_AAAA_AAAB, e: -65 };
    /// 3.
    pub const THREE: Float = Float { neg: 0, m: 3 << 62, e: -62 };
    /// 2π.
    pub const TAU: Float = Float { neg: 0, m: 0xC90F_DAA2_2168_C235, e: -61 };
    /// A ms in 2⁻³² ns: 10⁶·2³².
    pub const FINE_NS_PER_MS: Float = Float { neg: 0, m: 1_000_000 << 44, e: -12 };
    /// 2⁻³² ns in ms, the inverse.
    pub const MS_PER_FINE_NS: Float = Float { neg: 0, m: 0x8637_BD05_AF6C_69B6, e: -115 };

    /// m·2^e.
    pub const fn new(neg: bool, m: u64, e: i32) -> Float {
        if m == 0 {
            return Float::ZERO;
        }
        let shift = m.leading_zeros();
        Float { neg: neg as u32, m: m << shift, e: e - shift as i32 }
    }

    /// From a block float.
    #[inline(never)]
    pub fn from_scaled(x: Scaled) -> Float {
        Float::new(x.m < 0, x.m.unsigned_abs(), -(x.e as i32))
    }

    /// From a wide magnitude times 2^e, to 64 bits.
    #[inline]
    fn from_wide(neg: bool, x: u128, e: i32) -> Float {
        let (high, low) = ((x >> 64) as u64, x as u64);
        if high == 0 {
            return Float::new(neg, low, e);
        }
        let shift = high.leading_zeros();
        Float { neg: neg as u32, m: high << shift | low >> 1 >> (63 - shift), e: e + 64 - shift as i32 }
    }

    /// From a displacement.
    pub fn from_exact(x: Exact) -> Float {
        Float::from_wide(x.0 < 0, x.0.unsigned_abs(), -64)
    }

    /// From 2^-f units.
    pub fn from_fixed(x: u128, f: i32) -> Float {
        Float::from_wide(false, x, -f)
    }

    /// As a whole number of 2^-f, to nearest, the magnitude held below 2¹²⁶.
    #[inline]
    pub fn to_fixed(self, f: i32) -> i128 {
        let e = self.e + f;
        let magnitude = if self.m == 0 || e < -64 {
            0
        } else if e <= -1 {
            let twice = self.m >> (-e - 1).min(63);
            ((twice >> 1) + (twice & 1)) as u128
        } else if e > 62 {
            1 << 126
        } else {
            let e = e as u32;
            ((self.m >> 1 >> (63 - e)) as u128) << 64 | (self.m << e) as u128
        };
        if self.neg == 1 { -(magnitude as i128) } else { magnitude as i128 }
    }

    /// As a whole number of 2^-f, to nearest, for magnitudes below 2^(62 − f).
    #[inline]
    pub fn to_i64(self, f: i32) -> i64 {
        if self.m == 0 {
            return 0;
        }
        let shift = -(self.e + f) - 1;
        if shift > 63 {
            return 0;
        }
        let twice = (self.m >> (shift as u32 & 63)) as i64;
        let magnitude = (twice >> 1) + (twice & 1);
        if self.neg == 1 { -magnitude } else { magnitude }
    }

    /// As a displacement, to nearest.
    pub fn to_exact(self) -> Exact {
        Exact(self.to_fixed(64))
    }

    /// The exponent of the number: |x| < 2^width. Very low for 0.
    pub fn width(self) -> i32 {
        if self.m == 0 { -1000 } else { self.e + 64 }
    }

    /// Magnitude.
    pub fn abs(self) -> Float {
        Float { neg: 0, ..self }
    }

    /// Whether it is below 0.
    pub fn is_negative(self) -> bool {
        self.neg == 1 && self.m != 0
    }

    /// Whether it is 0.
    pub fn is_zero(self) -> bool {
        self.m == 0
    }

    /// x·2^k.
    pub fn scale(self, k: i32) -> Float {
        Float { e: self.e + k, ..self }
    }

    /// −x.
    pub fn negate(self) -> Float {
        Float { neg: self.neg ^ 1, ..self }
    }

    /// Product, rounded down.
    #[inline]
    pub fn mul(self, other: Float) -> Float {
        let (high, low) = umul(self.m, other.m);
        // Two top bits make the top bit, or the one below it; 0 stays 0.
        let short = high >> 63 ^ 1;
        Float {
            neg: self.neg ^ other.neg,
            m: if short == 1 { high << 1 | low >> 63 } else { high },
            e: self.e + other.e + 64 - short as i32,
        }
    }

    /// Sum, rounded down in magnitude; a difference of near numbers keeps all bits.
    #[inline]
    pub fn add(self, other: Float) -> Float {
        if self.m == 0 {
            return other;
        }
        if other.m == 0 {
            return self;
        }
        // The larger comes first.
        if self.is_less(other) { other.with(self) } else { self.with(other) }
    }

    /// Sum with a smaller number.
    #[inline]
    fn with(self, small: Float) -> Float {
        let big = self;
        let gap = (big.e - small.e) as u32;
        if gap > 63 {
            return big;
        }
        let high = small.m >> gap;
        if big.neg == small.neg {
            let (m, carry) = big.m.overflowing_add(high);
            return if carry { Float { m: m >> 1 | 1 << 63, e: big.e + 1, ..big } } else { Float { m, ..big } };
        }
        let (low, borrow) = 0u64.overflowing_sub(small.m << 1 << (63 - gap));
        let high = big.m.wrapping_sub(high).wrapping_sub(borrow as u64);
        if high >> 63 == 1 {
            return Float { m: high, ..big };
        }
        Float::from_wide(big.neg == 1, (high as u128) << 64 | low as u128, big.e - 64)
    }

    /// Difference.
    #[inline]
    pub fn sub(self, other: Float) -> Float {
        self.add(other.negate())
    }

    /// Whether |self| < |other|.
    pub fn is_less(self, other: Float) -> bool {
        if self.m == 0 || other.m == 0 {
            return other.m != 0;
        }
        if self.e == other.e { self.m < other.m } else { self.e < other.e }
    }

    /// 1/x; 0 for 0.
    #[inline(never)]
    pub fn recip(self) -> Float {
        if self.m == 0 {
            return Float::ZERO;
        }
        // 1/m = (2^64 + v)·2^-128
        let v = recip64(self.m);
        Float { neg: self.neg, m: 1 << 63 | v >> 1, e: -127 - self.e }
    }

    /// Quotient; 0 where the divisor is 0.
    pub fn div(self, other: Float) -> Float {
        self.mul(other.recip())
    }

    /// X·2^(2k) with X = x·2⁻⁶⁴ in [1/4, 1): x and k.
    fn even(self) -> (u64, i32) {
        let odd = self.e & 1;
        (self.m >> odd, (self.e + 64 + odd) / 2)
    }

    /// Square root; 0 of a negative number.
    pub fn sqrt(self) -> Float {
        if self.m == 0 || self.neg == 1 {
            return Float::ZERO;
        }
        let (x, k) = self.even();
        let y = rsqrt(x);
        let s = umulhi(x, y) << 2 | 3;
        // One correction from the exact residue x − s².
        let residue = ((x as u128) << 64).wrapping_sub(s as u128 * s as u128) as i128;
        let s = s.saturating_add_signed(mulhi_su((residue >> 16) as i64, y) >> 47);
        Float::new(false, s, k - 64)
    }

    /// 1/sqrt(x), to about 2⁻⁵⁷ of itself; 0 of 0 and of a negative number.
    pub fn rsqrt(self) -> Float {
        if self.m == 0 || self.neg == 1 {
            return Float::ZERO;
        }
        let (x, k) = self.even();
        Float::new(false, rsqrt(x), -62 - k)
    }
}

/// 2¹⁵/sqrt of the middle of each 64th from 1/4 to 1.
const ROOT_SEED: [u16; 48] = {
    let mut table = [0; 48];
    let mut i = 0;
    while i < 48 {
        // y² = 2^30 · 128 / (2·(16 + i) + 1)
        let y = ((1u64 << 37) / (2 * (16 + i) + 1)).isqrt();
        table[i as usize] = if y > 0xffff { 0xffff } else { y as u16 };
        i += 1;
    }
    table
};

/// 1/sqrt(X·2⁻⁶⁴) in 2⁻⁶² for X ≥ 2⁶², to about 2⁻⁵⁷.
fn rsqrt(x: u64) -> u64 {
    let seed = ROOT_SEED.get((x >> 58).saturating_sub(16) as usize).copied().unwrap_or(0x8000);
    let high = |a: u32, b: u32| ((a as u64 * b as u64) >> 32) as u32;
    // y·(3 − x·y²)/2; x·y² is near 1 in 2^-28, then in 2^-60.
    let mut y = (seed as u32) << 15;
    for _ in 0..2 {
        let gap = (3u32 << 28).wrapping_sub(high(high(y, y), (x >> 32) as u32));
        y = high(y, gap) << 3;
    }
    let mut y = (y as u64) << 32;
    for _ in 0..2 {
        let gap = (3u64 << 60).wrapping_sub(umulhi(umulhi(y, y), x));
        y = umulhi(y, gap) << 3;
    }
    y
}
