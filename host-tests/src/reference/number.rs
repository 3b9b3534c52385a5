//! Numbers: exact rationals for plans, and a fixed point of 2⁻⁶⁴ for values at an instant.
use super::rational::Rational;
use num_bigint::BigInt;
use num_traits::ToPrimitive;
use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

/// A double, exactly. NaN and infinities are no numbers of a plan.
pub fn exact(x: f64) -> Rational {
    let (mantissa, exponent) = parts(x);
    Rational::dyadic(mantissa.into(), exponent.into())
}

/// Whole m and e, with m·2^e the number.
fn parts(x: f64) -> (i64, i32) {
    assert!(x.is_finite(), "a finite number");
    let bits = x.to_bits();
    let (fraction, exponent) = ((bits & ((1 << 52) - 1)) as i64, (bits >> 52 & 0x7ff) as i32);
    let mantissa = if exponent == 0 { fraction } else { fraction | 1 << 52 };
    (if x < 0.0 { -mantissa } else { mantissa }, exponent.max(1) - 1075)
}

/// A number in units of 2⁻⁶⁴: pulses, ms, pulse/ms or a ratio.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Fix(pub i128);

impl Fix {
    pub const ZERO: Fix = Fix(0);
    pub const ONE: Fix = Fix(1 << 64);
    /// Further than any axis goes.
    pub const FAR: Fix = Fix(1 << 112);

    pub fn whole(x: i64) -> Fix {
        Fix(i128::from(x) << 64)
    }

    /// Rounded to the nearest.
    pub fn of(x: &Rational) -> Fix {
        let scaled = x.scaled(65).to_i128().expect("a number in range");
        Fix((scaled + 1) >> 1)
    }

    /// The same of a double.
    pub fn of_f64(x: f64) -> Fix {
        let (mantissa, exponent) = parts(x);
        let (size, shift) = (u128::from(mantissa.unsigned_abs()), exponent + 65);
        let twice = if shift >= 0 {
            assert!(size.leading_zeros() as i32 > shift + 1, "a number in range");
            size << shift
        } else {
            size.checked_shr(shift.unsigned_abs()).unwrap_or(0)
        };
        let twice = if mantissa < 0 { -(twice as i128) } else { twice as i128 };
        Fix((twice + 1) >> 1)
    }

    /// A position of the machine, in 2⁻²² pulse.
    pub fn of_position(units: i64) -> Fix {
        Fix(i128::from(units) << 42)
    }

    /// Time of so many ns, in ms.
    pub fn ms(ns: i64) -> Fix {
        let (whole, rest) = (ns.div_euclid(1_000_000), ns.rem_euclid(1_000_000) as u64);
        // 64 bits of rest/10⁶, by two divisions of 64 bits.
        let (high, rest) = ((rest << 44) / 1_000_000, (rest << 44) % 1_000_000);
        let fraction = (high << 20) | ((rest << 20) / 1_000_000);
        Fix((i128::from(whole) << 64) | i128::from(fraction))
    }

    pub fn abs(self) -> Fix {
        Fix(self.0.abs())
    }

    pub fn half(self) -> Fix {
        Fix(self.0 >> 1)
    }

    pub fn to_f64(self) -> f64 {
        self.0 as f64 / 18_446_744_073_709_551_616.0
    }

    pub fn rational(self) -> Rational {
        Rational::dyadic(self.0.into(), -64)
    }

    /// `self / by`, rounded towards zero.
    pub fn over(self, by: Fix) -> Fix {
        let (a, b) = (self.0.unsigned_abs(), by.0.unsigned_abs());
        let (whole, mut rest, mut fraction) = (a / b, a % b, 0);
        // As many bits at a time as there is room for.
        let mut left = 64;
        while left > 0 {
            let bits = rest.leading_zeros().min(left);
            if bits == 0 {
                // A divisor of 128 bits.
                let quotient = (BigInt::from(self.0) << 64usize) / by.0;
                return Fix(quotient.to_i128().expect("a quotient in range"));
            }
            rest <<= bits;
            fraction = (fraction << bits) | (rest / b);
            rest %= b;
            left -= bits;
        }
        let quotient = whole.checked_mul(1 << 64).map(|whole| whole | fraction);
        let quotient = quotient.and_then(|quotient| i128::try_from(quotient).ok()).expect("a quotient in range");
        Fix(if (self.0 < 0) != (by.0 < 0) { -quotient } else { quotient })
    }
}

/// √(a), rounded down to 2⁻⁶⁴.
pub fn root(a: &Rational) -> Fix {
    assert!(!a.is_negative());
    if a.is_zero() {
        return Fix::ZERO;
    }
    Fix(a.scaled(128).sqrt().to_i128().expect("a root in range"))
}

impl Add for Fix {
    type Output = Fix;
    fn add(self, other: Fix) -> Fix {
        Fix(self.0 + other.0)
    }
}

impl Sub for Fix {
    type Output = Fix;
    fn sub(self, other: Fix) -> Fix {
        Fix(self.0 - other.0)
    }
}

impl Neg for Fix {
    type Output = Fix;
    fn neg(self) -> Fix {
        Fix(-self.0)
    }
}

impl AddAssign for Fix {
    fn add_assign(&mut self, other: Fix) {
        self.0 += other.0;
    }
}

impl SubAssign for Fix {
    fn sub_assign(&mut self, other: Fix) {
        self.0 -= other.0;
    }
}

impl Mul for Fix {
    type Output = Fix;
    /// Rounded towards zero; the product has 256 bits before it is shifted.
    fn mul(self, other: Fix) -> Fix {
        let (a, b) = (self.0.unsigned_abs(), other.0.unsigned_abs());
        let low = |x: u128| x & u128::from(u64::MAX);
        let ([a0, a1], [b0, b1]) = ([low(a), a >> 64], [low(b), b >> 64]);
        let product = ((a0 * b0) >> 64)
            .checked_add(a0 * b1)
            .and_then(|sum| sum.checked_add(a1 * b0))
            .and_then(|sum| sum.checked_add((a1 * b1).checked_mul(1 << 64)?))
            .expect("a product in range");
        let product = i128::try_from(product).expect("a product in range");
        Fix(if (self.0 < 0) != (other.0 < 0) { -product } else { product })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::chance::Chance;

    /// Short cuts give what big numbers give.
    #[test]
    fn short_cuts_are_exact() {
        let mut chance = Chance::new(5);
        for _ in 0..20_000 {
            let x = chance.log(1e-30, 1e9) * chance.sign();
            for x in [x, x.round(), 0.0, -0.0, f64::from(x as f32), 2f64.powi(-1074)] {
                assert_eq!(Fix::of_f64(x), Fix::of(&exact(x)), "{x}");
            }
            let ns = (chance.next() as i64) >> chance.below(60);
            assert_eq!(Fix::ms(ns).0, (i128::from(ns) << 64).div_euclid(1_000_000), "{ns}");
            let fix = |chance: &mut Chance| {
                let shift = 1 + chance.below(120) as u32;
                let sign = if chance.below(2) == 0 { -1 } else { 1 };
                Fix(sign * ((u128::from(chance.next()) << 64 | u128::from(chance.next())) >> shift) as i128)
            };
            let (a, b) = (fix(&mut chance), fix(&mut chance));
            if b != Fix::ZERO && a.0.unsigned_abs() >> 62 < b.0.unsigned_abs() {
                let quotient = (BigInt::from(a.0) << 64usize) / b.0;
                assert_eq!(BigInt::from(a.over(b).0), quotient, "{a:?} {b:?}");
            }
        }
    }
}
