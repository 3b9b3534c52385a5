//! Power and its bounds.
//!
//! In: the bits of a user's double. Out: [`Power`], [`PowerBounds`], which only these checks can
//! make. Fails: with the rule that the number breaks, [`Refused`].
use super::PowerMode;

/// A power in the unit of its mode (%, kHz or V), or a frequency in kHz, in units of 2⁻⁴⁴.
///
/// A frequency is exact to 1 ppm from 30 µHz up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
#[repr(transparent)]
pub struct Power(i64);

/// Why a power, a bound or a frequency is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refused {
    /// NaN or infinite.
    NotFinite,
    /// Below 0.
    Negative,
    /// Above the full range.
    BeyondRange,
    /// A maximum below its minimum.
    MaxBelowMin,
    /// A frequency (below 2⁻⁴⁵ kHz), a ratio or a scale of 0.
    Zero,
    /// A maximum that is not above its minimum (velocity follow).
    MaxNotAboveMin,
    /// A position in a table that is not beyond the one before.
    NotIncreasing,
    /// More points than a table holds.
    Count,
}

impl Power {
    /// Fraction bits.
    pub const FRAC_BITS: u32 = 44;
    /// Nothing.
    pub const ZERO: Power = Power(0);
    /// The largest: 2000 kHz.
    pub const MAX: Power = Power::whole(2000);

    /// A whole number of units.
    pub(super) const fn whole(units: u16) -> Power {
        Power((units as i64) << Power::FRAC_BITS)
    }

    /// From units of 2⁻⁴⁴, the nearest power in range.
    #[inline]
    pub(super) fn nearest(raw: i64) -> Power {
        Power(raw.clamp(0, Power::MAX.0))
    }

    /// From units of 2⁻⁴⁴, between bounds that are powers.
    #[inline]
    pub(super) fn bounded(raw: i64) -> Power {
        Power(raw)
    }

    /// In units of 2⁻⁴⁴.
    #[inline]
    pub const fn raw(self) -> i64 {
        self.0
    }

    /// From the bits of a double, 0 to 2000; rounded to nearest, halves up.
    pub fn admit(bits: u64) -> Result<Power, Refused> {
        let exponent = (bits >> 52 & 0x7ff) as i32;
        let fraction = bits & ((1 << 52) - 1);
        if exponent == 0x7ff {
            return Err(Refused::NotFinite);
        }
        if exponent == 0 && fraction == 0 {
            return Ok(Power::ZERO);
        }
        if bits >> 63 == 1 {
            return Err(Refused::Negative);
        }
        // m·2^(exponent − 1075) is m·2^up in units of 2^-44.
        let m = 1 << 52 | fraction;
        let up = exponent - 1075 + Power::FRAC_BITS as i32;
        let value = match up {
            3.. => return Err(Refused::BeyondRange),
            0..=2 => m << up,
            -63..=-1 => ((m >> (-up - 1)) + 1) >> 1,
            _ => 0,
        };
        let power = Power(value as i64);
        if power > Power::MAX { Err(Refused::BeyondRange) } else { Ok(power) }
    }
}

/// Bounds of the power, inside the full range of a mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PowerBounds {
    min: Power,
    max: Power,
}

impl PowerBounds {
    /// Nothing but 0.
    pub(crate) const ZERO: PowerBounds = PowerBounds { min: Power::ZERO, max: Power::ZERO };

    /// The full range of a mode.
    pub const fn full(mode: PowerMode) -> PowerBounds {
        PowerBounds { min: Power::ZERO, max: mode.full_scale() }
    }

    /// Checked bounds.
    pub fn admit(mode: PowerMode, max: Power, min: Power) -> Result<PowerBounds, Refused> {
        if max > mode.full_scale() {
            Err(Refused::BeyondRange)
        } else if max < min {
            Err(Refused::MaxBelowMin)
        } else {
            Ok(PowerBounds { min, max })
        }
    }

    /// From powers that were bounds before.
    pub(super) fn again(max: Power, min: Power) -> PowerBounds {
        PowerBounds { min, max }
    }

    /// The least power.
    pub const fn min(self) -> Power {
        self.min
    }

    /// The greatest power.
    pub const fn max(self) -> Power {
        self.max
    }

    /// A power held in the bounds.
    #[inline]
    pub fn hold(self, power: Power) -> Power {
        power.max(self.min).min(self.max)
    }
}
