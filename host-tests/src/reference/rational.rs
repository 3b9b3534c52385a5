//! Exact numbers with a power of two of their own, which are brought to lowest terms only where
//! they grow long.
use num_bigint::{BigInt, Sign};
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};
use std::cmp::Ordering;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// `numer / denom · 2^exponent`; `denom` is positive and odd.
#[derive(Debug, Clone)]
pub struct Rational {
    numer: BigInt,
    denom: BigInt,
    exponent: i64,
}

/// Denominators longer than this are reduced.
const REDUCED_MIN_BITS: u64 = 320;

impl Rational {
    fn raw(numer: BigInt, denom: BigInt, exponent: i64) -> Rational {
        if denom.bits() > REDUCED_MIN_BITS {
            let (numer, denom) = BigRational::new(numer, denom).into_raw();
            return Rational { numer, denom, exponent };
        }
        Rational { numer, denom, exponent }
    }

    /// `numer · 2^exponent`.
    pub fn dyadic(numer: BigInt, exponent: i64) -> Rational {
        Rational { numer, denom: BigInt::one(), exponent }
    }

    pub fn from_integer(x: BigInt) -> Rational {
        Rational::dyadic(x, 0)
    }

    pub fn zero() -> Rational {
        Rational::from_integer(BigInt::zero())
    }

    pub fn is_zero(&self) -> bool {
        self.numer.is_zero()
    }

    pub fn is_positive(&self) -> bool {
        self.numer.is_positive()
    }

    pub fn is_negative(&self) -> bool {
        self.numer.is_negative()
    }

    pub fn abs(&self) -> Rational {
        Rational { numer: self.numer.abs(), ..self.clone() }
    }

    pub fn recip(&self) -> Rational {
        &Rational::from_integer(BigInt::one()) / self
    }

    /// `self · 2^bits`, rounded towards zero.
    pub fn scaled(&self, bits: i64) -> BigInt {
        let up = self.exponent + bits;
        if self.denom.is_one() && up < 0 {
            // Towards zero, not down.
            let size = self.numer.magnitude() >> up.unsigned_abs();
            return BigInt::from_biguint(self.numer.sign(), size);
        }
        match up {
            0.. => (&self.numer << up.unsigned_abs()) / &self.denom,
            _ => &self.numer / (&self.denom << up.unsigned_abs()),
        }
    }

    /// Numerators of both with one denominator and exponent.
    fn aligned(&self, other: &Rational) -> (BigInt, BigInt) {
        let least = self.exponent.min(other.exponent);
        let same = self.denom == other.denom;
        let of = |x: &Rational, by: &BigInt| {
            let shift = (x.exponent - least).unsigned_abs();
            match (same || by.is_one(), shift) {
                (true, 0) => x.numer.clone(),
                (true, _) => &x.numer << shift,
                (false, 0) => &x.numer * by,
                (false, _) => (&x.numer * by) << shift,
            }
        };
        (of(self, &other.denom), of(other, &self.denom))
    }

    fn sum(&self, other: &Rational, sign: Sign) -> Rational {
        if other.is_zero() {
            return self.clone();
        }
        let (a, b) = self.aligned(other);
        let numer = if sign == Sign::Minus { a - b } else { a + b };
        if numer.is_zero() {
            return Rational::zero();
        }
        let exponent = self.exponent.min(other.exponent);
        let denom = if self.denom == other.denom || other.denom.is_one() {
            self.denom.clone()
        } else if self.denom.is_one() {
            other.denom.clone()
        } else {
            &self.denom * &other.denom
        };
        Rational::raw(numer, denom, exponent)
    }

    fn product(&self, other: &Rational) -> Rational {
        if self.is_zero() || other.is_zero() {
            return Rational::zero();
        }
        let denom = match (self.denom.is_one(), other.denom.is_one()) {
            (true, _) => other.denom.clone(),
            (_, true) => self.denom.clone(),
            _ => &self.denom * &other.denom,
        };
        Rational::raw(&self.numer * &other.numer, denom, self.exponent + other.exponent)
    }

    fn quotient(&self, other: &Rational) -> Rational {
        assert!(!other.is_zero(), "a divisor");
        if self.is_zero() {
            return Rational::zero();
        }
        let twos = other.numer.trailing_zeros().unwrap_or(0);
        let odd = other.numer.abs() >> twos;
        let numer = if other.denom.is_one() { self.numer.clone() } else { &self.numer * &other.denom };
        let denom = if self.denom.is_one() { odd } else { &self.denom * odd };
        let numer = if other.is_negative() { -numer } else { numer };
        Rational::raw(numer, denom, self.exponent - other.exponent - twos as i64)
    }
}

impl PartialEq for Rational {
    fn eq(&self, other: &Rational) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Rational {}

impl PartialOrd for Rational {
    fn partial_cmp(&self, other: &Rational) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Rational {
    fn cmp(&self, other: &Rational) -> Ordering {
        let (a, b) = self.aligned(other);
        a.cmp(&b)
    }
}

impl Neg for Rational {
    type Output = Rational;
    fn neg(self) -> Rational {
        Rational { numer: -self.numer, ..self }
    }
}

impl Neg for &Rational {
    type Output = Rational;
    fn neg(self) -> Rational {
        -self.clone()
    }
}

/// An operation of values and references.
macro_rules! operation {
    ($trait:ident, $method:ident, $of:expr) => {
        impl $trait<&Rational> for &Rational {
            type Output = Rational;
            fn $method(self, other: &Rational) -> Rational {
                $of(self, other)
            }
        }

        impl $trait<Rational> for &Rational {
            type Output = Rational;
            fn $method(self, other: Rational) -> Rational {
                $of(self, &other)
            }
        }

        impl $trait<&Rational> for Rational {
            type Output = Rational;
            fn $method(self, other: &Rational) -> Rational {
                $of(&self, other)
            }
        }

        impl $trait<Rational> for Rational {
            type Output = Rational;
            fn $method(self, other: Rational) -> Rational {
                $of(&self, &other)
            }
        }
    };
}

operation!(Add, add, |a: &Rational, b: &Rational| a.sum(b, Sign::Plus));
operation!(Sub, sub, |a: &Rational, b: &Rational| a.sum(b, Sign::Minus));
operation!(Mul, mul, Rational::product);
operation!(Div, div, Rational::quotient);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::chance::Chance;

    fn plain(x: &Rational) -> BigRational {
        let power = BigInt::one() << x.exponent.unsigned_abs();
        let odd = BigRational::new(x.numer.clone(), x.denom.clone());
        if x.exponent < 0 { odd / power } else { odd * power }
    }

    /// The same as the numbers of a library, over chains of operations that are long enough to be
    /// reduced.
    #[test]
    fn as_a_library_has_it() {
        let mut chance = Chance::new(3);
        let mut numbers = vec![(Rational::from_integer(3.into()), BigRational::from_integer(3.into()))];
        for _ in 0..5000 {
            let mut pick = || chance.below(numbers.len() as u64) as usize;
            let ((a, c), (b, d)) = (numbers[pick()].clone(), numbers[pick()].clone());
            assert_eq!(a.cmp(&b), c.cmp(&d));
            let made = match chance.below(6) {
                0 => (&a + &b, c + d),
                1 => (&a - &b, c - d),
                2 => (&a * &b, c * d),
                3 if !b.is_zero() => (&a / &b, c / d),
                4 => (-a.abs(), -c.abs()),
                _ => {
                    let x = chance.log(1e-6, 1e6);
                    (crate::reference::exact(x), BigRational::from_float(x).unwrap())
                }
            };
            assert_eq!(plain(&made.0), made.1);
            assert!(made.0.denom.bit(0) && made.0.denom.is_positive());
            let scaled = (made.1.numer() << 65usize) / made.1.denom();
            assert_eq!(made.0.scaled(65), scaled);
            if made.1.denom().bits() < 3000 && made.1.numer().bits() < 3000 {
                if numbers.len() < 40 {
                    numbers.push(made);
                } else {
                    let at = chance.below(40) as usize;
                    numbers[at] = made;
                }
            }
        }
    }
}
