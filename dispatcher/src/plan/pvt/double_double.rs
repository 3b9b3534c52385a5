//! Double-double numbers: an unevaluated sum of two doubles, 106 bits, by the error-free
//! transformations of Dekker and Knuth. Only +, −, ×, ÷ and a correctly rounded square root of
//! doubles are used. So the bits are the same on every machine with IEEE doubles.

/// `high` + `low`, |low| ≤ half a unit in the last place of `high`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DoubleDouble {
    /// The number, rounded to a double.
    pub high: f64,
    /// The remainder.
    pub low: f64,
}

/// a + b exactly.
fn sum(a: f64, b: f64) -> DoubleDouble {
    let high = a + b;
    let part = high - a;
    DoubleDouble { high, low: (a - (high - part)) + (b - part) }
}

/// a + b exactly for |a| ≥ |b|.
fn quick(a: f64, b: f64) -> DoubleDouble {
    let high = a + b;
    DoubleDouble { high, low: b - (high - a) }
}

/// a·b exactly, while nothing under- or overflows; no fused operation.
fn product(a: f64, b: f64) -> DoubleDouble {
    let split = |x: f64| {
        let t = 134_217_729.0 * x; // 2^27 + 1
        let high = t - (t - x);
        (high, x - high)
    };
    let ((a1, a0), (b1, b0)) = (split(a), split(b));
    let high = a * b;
    DoubleDouble { high, low: ((a1 * b1 - high) + a1 * b0 + a0 * b1) + a0 * b0 }
}

impl From<f64> for DoubleDouble {
    fn from(x: f64) -> DoubleDouble {
        DoubleDouble { high: x, low: 0.0 }
    }
}

impl DoubleDouble {
    /// a − b of two doubles, exactly.
    pub fn between(a: f64, b: f64) -> DoubleDouble {
        sum(a, -b)
    }
    /// −x.
    pub fn negate(self) -> DoubleDouble {
        DoubleDouble { high: -self.high, low: -self.low }
    }
    /// Sum, within 2⁻¹⁰⁴ of itself.
    pub fn plus(self, other: impl Into<DoubleDouble>) -> DoubleDouble {
        let other = other.into();
        let (s, t) = (sum(self.high, other.high), sum(self.low, other.low));
        let s = quick(s.high, s.low + t.high);
        quick(s.high, s.low + t.low)
    }
    /// Difference.
    pub fn minus(self, other: impl Into<DoubleDouble>) -> DoubleDouble {
        self.plus(other.into().negate())
    }
    /// Product, within 2⁻¹⁰² of itself.
    pub fn times(self, other: impl Into<DoubleDouble>) -> DoubleDouble {
        let other = other.into();
        let p = product(self.high, other.high);
        quick(p.high, p.low + (self.high * other.low + self.low * other.high))
    }
    /// Quotient, within 2⁻¹⁰¹ of itself; not for a divisor of 0.
    pub fn over(self, other: impl Into<DoubleDouble>) -> DoubleDouble {
        let other = other.into();
        let q1 = self.high / other.high;
        let remainder = self.minus(other.times(q1));
        let q2 = remainder.high / other.high;
        let remainder = remainder.minus(other.times(q2));
        quick(q1, q2).plus(remainder.high / other.high)
    }
    /// Square root, within 2⁻¹⁰⁰ of itself; 0 for values up to 0 and NaN.
    pub fn sqrt(self) -> DoubleDouble {
        if self.high <= 0.0 {
            return DoubleDouble::default();
        }
        let root = libm::sqrt(self.high);
        let remainder = self.minus(product(root, root));
        let once = quick(root, remainder.high / (2.0 * root));
        let remainder = self.minus(once.times(once));
        once.plus(remainder.high / (2.0 * root))
    }
}
