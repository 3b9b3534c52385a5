//! Speeds and accelerations as the tick takes them.
//!
//! In: the bits of a user's double. Out: [`Speed`], [`Accel`], which only these checks can make.
//! Fails: with the rule that the number breaks, [`Refused`].
use crate::piece::Scaled;
use crate::real::Real;
use crate::wide::recip64;

/// A velocity in pulse/ms. Default is 0.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Speed(pub(crate) Scaled);

/// An acceleration in pulse/ms² with its reciprocal, so that the tick never divides.
/// Default (0) is "not set".
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Accel {
    /// The magnitude.
    pub(crate) value: Scaled,
    /// 1/magnitude.
    pub(crate) recip: Scaled,
}

/// Why a speed or an acceleration is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refused {
    /// NaN or infinite.
    NotFinite,
    /// Magnitude above 2³² (pulse/ms, pulse/ms²).
    BeyondFullScale,
    /// An acceleration of 0 or less.
    NotPositive,
}

/// A double as a block float, by its bits; subnormals are 0.
fn decode(bits: u64) -> Result<Scaled, Refused> {
    let exponent = (bits >> 52 & 0x7ff) as i16;
    let fraction = bits & ((1 << 52) - 1);
    if exponent == 0x7ff {
        return Err(Refused::NotFinite);
    }
    if exponent > 1055 || exponent == 1055 && fraction != 0 {
        return Err(Refused::BeyondFullScale);
    }
    if exponent == 0 {
        return Ok(Scaled::default());
    }
    let m = (1 << 52 | fraction) as i64;
    Ok(Scaled { m: if bits >> 63 == 1 { -m } else { m }, e: 1075 - exponent })
}

impl Speed {
    /// From the bits of a double in pulse/ms, |v| ≤ 2³².
    pub fn admit(bits: u64) -> Result<Speed, Refused> {
        decode(bits).map(Speed)
    }

    /// The number, pulse/ms.
    pub fn value(self) -> Scaled {
        self.0
    }

    pub(super) fn real(self) -> Real {
        Real::from_scaled(self.0)
    }
}

impl Accel {
    /// From the bits of a double in pulse/ms², 0 < a ≤ 2³².
    pub fn admit(bits: u64) -> Result<Accel, Refused> {
        let value = decode(bits)?;
        if value.m <= 0 {
            return Err(Refused::NotPositive);
        }
        // 1/(M·2^-64) with the top bit of M set is (2^64 + v)·2^-64; 63 bits of it are kept.
        let shift = value.m.leading_zeros();
        let v = recip64((value.m as u64) << shift);
        let recip = Scaled { m: (1 << 62 | v >> 2) as i64, e: 126 - shift as i16 - value.e };
        Ok(Accel { value, recip })
    }

    /// The number, pulse/ms².
    pub fn value(self) -> Scaled {
        self.value
    }

    /// Its reciprocal, ms²/pulse, to 2⁻⁶⁰ of itself.
    pub fn reciprocal(self) -> Scaled {
        self.recip
    }

    /// Whether it was never set.
    pub fn is_zero(self) -> bool {
        self.value.m == 0
    }

    /// The rate as the planner takes it.
    pub(super) fn rate(self) -> Rate {
        Rate { value: Real::from_scaled(self.value), inverse: Real::from_scaled(self.recip) }
    }
}

/// A rate of change of the velocity, pulse/ms².
#[derive(Debug, Clone, Copy)]
pub(super) struct Rate {
    value: Real,
    /// 1/rate.
    pub(super) inverse: Real,
}

impl Rate {
    /// None.
    pub(super) const NONE: Rate = Rate { value: Real::ZERO, inverse: Real::ZERO };

    /// Along a change of velocity of this sign.
    pub(super) fn along(self, negative: bool) -> Real {
        if negative { self.value.negate() } else { self.value }
    }
}
