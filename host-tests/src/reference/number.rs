//! Numbers: exact rationals for plans, and a fixed point of 2⁻⁶⁴ for values at an instant.
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive, Zero};
use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

/// An exact number.
pub type Rational = BigRational;

/// A double, exactly. NaN and infinities are no numbers of a plan.
pub fn exact(x: f64) -> Rational {
    BigRational::from_float(x).expect("a finite number")
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
        let scaled: BigInt = (x.numer() << 65usize) / x.denom();
        Fix(((scaled + 1i32) >> 1usize).to_i128().expect("a number in range"))
    }

    pub fn of_f64(x: f64) -> Fix {
        Fix::of(&exact(x))
    }

    /// A position of the machine, in 2⁻²² pulse.
    pub fn of_position(units: i64) -> Fix {
        Fix(i128::from(units) << 42)
    }

    /// Time of so many ns, in ms.
    pub fn ms(ns: i64) -> Fix {
        let scaled = i128::from(ns) << 64;
        Fix(scaled.div_euclid(1_000_000))
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
        BigRational::new(self.0.into(), BigInt::from(1u128 << 64))
    }

    /// `self / by`.
    pub fn over(self, by: Fix) -> Fix {
        let quotient = (BigInt::from(self.0) << 64usize) / by.0;
        Fix(quotient.to_i128().expect("a quotient in range"))
    }
}

/// √(a), rounded down to 2⁻⁶⁴.
pub fn root(a: &Rational) -> Fix {
    assert!(!a.is_negative());
    if a.is_zero() {
        return Fix::ZERO;
    }
    let scaled: BigInt = (a.numer() << 128usize) / a.denom();
    Fix(scaled.sqrt().to_i128().expect("a root in range"))
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
