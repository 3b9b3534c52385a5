//! Velocity follow: the speed of a path, and the power that it gives (SPEC 6, "Energy").
//!
//! In: the path of a coordinate system as its tick publishes it, the bits of the user's ratio. Out:
//! a [`PathSpeed`], and a part of the power in 2⁻⁴⁴ of its unit. Owns nothing. Fails: a ratio that
//! is not finite or out of range is refused.
//!
//! A power is in force for the whole interval that begins with the tick, so it follows the speed in
//! the *middle* of that interval. Under constant acceleration that is the mean: the energy of each
//! interval is the ratio times its length, at any period. The speed at its beginning would lag by
//! half a tick.
use super::fixed_point::{PreparedShift, unsigned_part};
use super::power::Refused;
use crate::math::wide::umul;
use crate::path::PathSpeed;

/// Which speed a follow follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SpeedSource {
    /// The planned path (0).
    #[default]
    Planned,
    /// The encoders of its axes (1).
    Encoder,
}

/// Power per speed, in the mode's unit per pulse/ms.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ratio {
    bits: u64,
}

impl Ratio {
    /// From the bits of a double: above 0, at most 2³².
    pub fn admit(bits: u64) -> Result<Ratio, Refused> {
        const RATIO_MAX_BITS: u64 = (1023 + 32) << 52;
        match bits {
            0 => Err(Refused::Zero),
            _ if bits & 0x7ff << 52 == 0x7ff << 52 => Err(Refused::NotFinite),
            _ if bits >> 63 == 1 => Err(Refused::Negative),
            1..=RATIO_MAX_BITS => Ok(Ratio { bits }),
            _ => Err(Refused::BeyondRange),
        }
    }

    /// The bits of the double.
    pub const fn bits(self) -> u64 {
        self.bits
    }

    /// Its form for the tick.
    pub(super) fn gain(self) -> SpeedGain {
        // v·2^30 times ratio = m·2^(exponent - 1086), of which 2^44 are to stay.
        let shift = (1086 + PathSpeed::FRAC_BITS - super::Power::FRAC_BITS) as u64 - (self.bits >> 52);
        let cut = PreparedShift::of(shift as u32);
        if shift > 128 { SpeedGain::NONE } else { SpeedGain { m: self.bits << 11 | 1 << 63, cut, shift: shift as u32 } }
    }
}

/// The form of a [`Ratio`] for the tick: m·2^-shift is power, 2⁻⁴⁴, per speed, 2⁻³⁰ pulse/ms.
#[derive(Debug, Clone, Copy)]
pub(super) struct SpeedGain {
    m: u64,
    cut: PreparedShift,
    /// 17 to 128.
    shift: u32,
}

impl SpeedGain {
    /// No power at any speed.
    pub(super) const NONE: SpeedGain = SpeedGain { m: 0, cut: PreparedShift::of(64), shift: 64 };

    /// ratio·v in 2⁻⁴⁴ to half a unit; held at
    /// [`POWER_PART_MAX_RAW`](super::fixed_point::POWER_PART_MAX_RAW).
    #[inline(always)]
    pub(super) fn power(self, speed: PathSpeed) -> i64 {
        match self.cut.product(speed.raw(), self.m) {
            Some(power) => power,
            None => far(speed, self.m, self.shift),
        }
    }
}

/// The same if it may be too large, or the ratio is outside the usual range.
#[inline(never)]
fn far(speed: PathSpeed, m: u64, shift: u32) -> i64 {
    let (high, low) = umul(speed.raw(), m);
    unsigned_part(high, low, shift)
}
