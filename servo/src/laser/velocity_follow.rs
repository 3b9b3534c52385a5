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
use super::double::{Cut, held};
use super::power::Refused;
use crate::math::real::Real;
use crate::math::wide::{mulhi_su, umul, umulhi};
use crate::segment::piece::{Motion, Piece, Recip};
use crate::units::{Exact, Ns};

/// Which speed a follow follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Source {
    /// The planned path (0).
    #[default]
    Planned,
    /// The encoders of its axes (1).
    Encoder,
}

/// |path velocity| in 2⁻³⁰ pulse/ms; the largest is 2³⁴.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct PathSpeed(u64);

impl PathSpeed {
    /// Fraction bits.
    pub const FRAC_BITS: u32 = 30;
    /// Fraction bits of counts a tick, as [`PathSpeed::measured`] takes them.
    pub const COUNT_BITS: u32 = 28;
    /// At rest.
    pub const STANDSTILL: PathSpeed = PathSpeed(0);

    /// In units of 2⁻³⁰ pulse/ms.
    pub const fn raw(self) -> u64 {
        self.0
    }

    /// From units of 2⁻³⁰ pulse/ms.
    pub const fn from_raw(raw: u64) -> PathSpeed {
        PathSpeed(raw)
    }

    /// The speed in the middle of the interval of `period` from the present position in the motion
    /// on. The motion has constant acceleration over a power of two of ns; it is taken to go on
    /// that long, but not backwards.
    pub fn ahead(motion: &Motion, period: Ns) -> PathSpeed {
        let Motion { tau, t, c: [speed, change, _], recip: Recip { shift, .. }, frac, .. } = *motion;
        // The piece lasts 2^(64 - shift) ns; tau and half a period are in 2^-63 of it.
        let mut speed = speed;
        if change != 0 {
            let half = period.0 >> 1;
            let share = if half.leading_zeros() >= shift { half.wrapping_shl(shift) >> 1 } else { Piece::END };
            // If the motion has its time, the piece lasts 2^32 ns at most.
            let gone = (t.wrapping_shl(shift) as u64) << 31;
            let tau = tau.wrapping_add(gone).wrapping_add(share).min(Piece::END);
            speed = speed.wrapping_add(mulhi_su(change, tau << 1));
        }
        let speed = speed.max(0) as u64;
        // In 2^-frac pulse per piece; 10^6 ns are a ms.
        let per_ms = umulhi(speed, 1_000_000 << 44);
        let down = frac.wrapping_add(64 - 20 - PathSpeed::FRAC_BITS as i32).wrapping_sub(shift as i32);
        match down {
            1..=63 => PathSpeed((per_ms >> (down - 1)).wrapping_add(1) >> 1),
            -18..=0 => PathSpeed(per_ms << -down as u32),
            _ => PathSpeed::STANDSTILL,
        }
    }

    /// The same at any instant and period, if the motion has no acceleration.
    pub(crate) fn even(motion: &Motion) -> Option<PathSpeed> {
        let [_, change, _] = motion.c;
        (change == 0).then(|| PathSpeed::ahead(motion, Ns(0)))
    }

    /// Of a displacement in `period`.
    pub(crate) fn mean(displacement: Exact, period: Ns) -> PathSpeed {
        PathSpeed::per_ms(Real::from_exact(displacement), period)
    }

    fn per_ms(displacement: Real, period: Ns) -> PathSpeed {
        let speed = displacement.mul(Real::new(false, 1_000_000, 0)).div(Real::new(false, period.0, 0));
        PathSpeed(speed.to_fixed(PathSpeed::FRAC_BITS as i32).clamp(0, u64::MAX as i128) as u64)
    }

    /// Of encoders with these counts in an interval of `period`, 2⁻²⁸ pulse: the norm of their
    /// velocities.
    pub fn measured(counts: [i64; 4], period: Ns) -> PathSpeed {
        let sum = counts.iter().fold(0u128, |sum, by| {
            let by = by.unsigned_abs().min(1 << 60);
            let (high, low) = umul(by, by);
            sum.wrapping_add((high as u128) << 64 | low as u128)
        });
        PathSpeed::per_ms(Real::from_fixed(sum, 2 * PathSpeed::COUNT_BITS as i32).sqrt(), period)
    }
}

/// Power per speed, in the mode's unit per pulse/ms.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ratio {
    bits: u64,
}

impl Ratio {
    /// From the bits of a double: above 0, at most 2³².
    pub fn admit(bits: u64) -> Result<Ratio, Refused> {
        const MOST: u64 = (1023 + 32) << 52;
        match bits {
            0 => Err(Refused::Zero),
            _ if bits & 0x7ff << 52 == 0x7ff << 52 => Err(Refused::NotFinite),
            _ if bits >> 63 == 1 => Err(Refused::Negative),
            1..=MOST => Ok(Ratio { bits }),
            _ => Err(Refused::BeyondRange),
        }
    }

    /// The bits of the double.
    pub const fn bits(self) -> u64 {
        self.bits
    }

    /// Its form for the tick.
    pub(super) fn gain(self) -> Gain {
        // v·2^30 times ratio = m·2^(exponent - 1086), of which 2^44 are to stay.
        let shift = (1086 + PathSpeed::FRAC_BITS - super::Power::FRAC_BITS) as u64 - (self.bits >> 52);
        let cut = Cut::of(shift as u32);
        if shift > 128 { Gain::NONE } else { Gain { m: self.bits << 11 | 1 << 63, cut, shift: shift as u32 } }
    }
}

/// The form of a [`Ratio`] for the tick: m·2^-shift is power, 2⁻⁴⁴, per speed, 2⁻³⁰ pulse/ms.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gain {
    m: u64,
    cut: Cut,
    /// 17 to 128.
    shift: u32,
}

impl Gain {
    /// No power at any speed.
    pub(super) const NONE: Gain = Gain { m: 0, cut: Cut::of(64), shift: 64 };

    /// ratio·v in 2⁻⁴⁴ to half a unit; held at [`MOST`](super::double::MOST).
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
    held(high, low, shift)
}
