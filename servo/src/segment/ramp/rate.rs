//! Speeds and accelerations as the tick takes them.
//!
//! In: the bits of a user's double. Out: [`Speed`], [`Accel`], which only these checks can make.
//! Fails: with the rule that the number breaks, [`Refused`].
use crate::math::float::Float;
use crate::math::wide::recip64;
use crate::segment::piece::Scaled;
use crate::units::StepLimit;

/// A velocity in pulse/ms, as the planner takes it. Default is 0.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Speed(Float);

/// An acceleration in pulse/ms² with its reciprocal, so that the tick never divides.
/// Default (0) is "not set".
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Accel(Acceleration);

/// Why a speed or an acceleration is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refused {
    /// NaN or infinite.
    NotFinite,
    /// A speed above the step limit (pulse/ms), or a magnitude above 2³² (pulse/ms²).
    BeyondLimit,
    /// An acceleration of 0 or less.
    NotPositive,
}

/// A double as a block float, by its bits; subnormals are 0. Its magnitude is at most `limit`.
fn decode(bits: u64, limit: StepLimit) -> Result<Scaled, Refused> {
    let exponent = (bits >> 52 & 0x7ff) as i16;
    let fraction = bits & ((1 << 52) - 1);
    if exponent == 0x7ff {
        return Err(Refused::NotFinite);
    }
    // The bits of doubles of one sign are in the order of the doubles.
    if bits & (u64::MAX >> 1) > limit.bits() {
        return Err(Refused::BeyondLimit);
    }
    if exponent == 0 {
        return Ok(Scaled::default());
    }
    let m = (1 << 52 | fraction) as i64;
    Ok(Scaled { m: if bits >> 63 == 1 { -m } else { m }, e: 1075 - exponent })
}

impl Speed {
    /// 0.
    pub(crate) const NONE: Speed = Speed(Float::ZERO);

    /// From the bits of a double in pulse/ms, |v| at most what the board's steps allow.
    pub fn admit(bits: u64, limit: StepLimit) -> Result<Speed, Refused> {
        decode(bits, limit).map(|value| Speed(Float::from_scaled(value)))
    }

    /// −1, 0 or 1.
    pub(crate) fn signum(self) -> i64 {
        if self.0.is_zero() {
            0
        } else if self.0.is_negative() {
            -1
        } else {
            1
        }
    }

    /// The number, pulse/ms.
    pub fn real(self) -> Float {
        self.0
    }
}

impl Accel {
    /// Not set.
    pub(crate) const NONE: Accel = Accel(Acceleration::NONE);
    /// 1 pulse/ms².
    pub(crate) const ONE: Accel = Accel(Acceleration { value: Float::ONE, inverse: Float::ONE });

    /// From the bits of a double in pulse/ms², 0 < a ≤ 2³².
    pub fn admit(bits: u64) -> Result<Accel, Refused> {
        let value = decode(bits, StepLimit::FULL_SCALE)?;
        if value.m <= 0 {
            return Err(Refused::NotPositive);
        }
        // 1/(M·2^-64) with the top bit of M set is (2^64 + v)·2^-64; 63 bits of it are kept.
        let shift = value.m.leading_zeros();
        let v = recip64((value.m as u64) << shift);
        let recip = Scaled { m: (1 << 62 | v >> 2) as i64, e: 126 - shift as i16 - value.e };
        Ok(Accel(Acceleration { value: Float::from_scaled(value), inverse: Float::from_scaled(recip) }))
    }

    /// The number, pulse/ms².
    pub fn magnitude(self) -> Float {
        self.0.value
    }

    /// Whether it was never set.
    pub fn is_zero(self) -> bool {
        self.0.value.is_zero()
    }

    /// The rate as the planner takes it.
    pub(crate) fn rate(self) -> Acceleration {
        self.0
    }
}

/// A rate of change of the velocity, pulse/ms².
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Acceleration {
    value: Float,
    /// 1/rate, ms²/pulse, to 2⁻⁶⁰ of itself.
    pub(crate) inverse: Float,
}

impl Acceleration {
    /// None.
    pub(super) const NONE: Acceleration = Acceleration { value: Float::ZERO, inverse: Float::ZERO };

    /// Along a change of velocity of this sign.
    pub(super) fn along(self, negative: bool) -> Float {
        if negative { self.value.negate() } else { self.value }
    }
}
