//! Distance follow: what the places of four axes add to the power (SPEC 6, "Energy").
//!
//! In: the user's references, scales and ratios, positions. Out: Σ (pos − ref)/scale · ratio in 2⁻⁴⁴ of the power's
//! unit. Owns nothing but the stretches of its tables. Fails: what is no number or out of range is refused.
//!
//! Fixed ratios are divided by their scales at admission and have a common exponent: the sum is off by 2⁻⁵⁸ of the
//! largest factor times the largest distance, and half a unit. With a table the ratio has 44 fraction bits, the
//! distance over the scale 32 and at most ±2²⁹.
use super::double::{part, product, scaled};
use super::follow::Source;
use super::power::{Bounds, Refused};
use super::tables::{Curve, DISTANCES, Stretch, Tables};
use super::{Power, double};
use crate::axis::AxisState;
use crate::real::Real;
use crate::units::{Axis, Pos};

/// Where the ratios come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ratios {
    /// The same everywhere.
    Fixed,
    /// Each axis has its own table over its position; one of no points is 0.
    Lines {
        /// In this bank.
        bank: u8,
    },
    /// Both axes of a plane (of the four, from 0) have the ratio at their place; the others none.
    Plane {
        /// In this bank.
        bank: u8,
        /// Whose position counts along the first direction, and along the second.
        axes: [u8; 2],
    },
}

/// An admitted distance follow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Distance {
    pub(super) source: Source,
    axes: [Axis; DISTANCES],
    /// In units of Pos.
    reference: [i64; DISTANCES],
    /// ratio/scale, with tables 1/scale, in 2^-(`shift` + 22).
    factors: [i64; DISTANCES],
    shift: u8,
    ratios: Ratios,
    pub(super) bounds: Option<Bounds>,
}

impl Distance {
    /// `axes` of the controller; references in pulses; `scales` (2⁻¹⁸ to 2³² pulses) and `ratios` (|r| ≤ 2¹⁷) are the
    /// bits of doubles; `bounds` of its own (GUS). With tables the ratios given here do not count.
    pub fn admit(
        source: Source,
        axes: [Axis; DISTANCES],
        reference: [i32; DISTANCES],
        scales: [u64; DISTANCES],
        ratios: [u64; DISTANCES],
        from: Ratios,
        bounds: Option<Bounds>,
    ) -> Result<Distance, Refused> {
        let mut reals = [Real::ZERO; DISTANCES];
        for ((to, scale), ratio) in reals.iter_mut().zip(scales).zip(ratios) {
            let (scale, ratio) = (double::real(scale)?, double::real(ratio)?);
            if scale.is_negative() {
                return Err(Refused::Negative);
            }
            if scale.width() < -17 {
                return Err(Refused::Zero);
            }
            if scale.width() > 33 || ratio.width() > 18 {
                return Err(Refused::BeyondRange);
            }
            *to = if from == Ratios::Fixed { ratio.div(scale) } else { scale.recip() };
        }
        // |f| < 2^width <= 2^36; the products with 63 bits of distance and their sum stay below 2^126.
        let width = reals.iter().fold(-60, |width: i32, real| width.max(real.width()));
        let shift = 60 - width - 22;
        let factors = reals.map(|real| real.to_fixed(shift + 22) as i64);
        let reference = reference.map(|pulses| Pos::pulses(pulses).0);
        Ok(Distance { source, axes, reference, factors, shift: shift as u8, ratios: from, bounds })
    }

    /// The bank that it reads.
    pub(super) fn bank(&self) -> Option<u8> {
        match self.ratios {
            Ratios::Fixed => None,
            Ratios::Lines { bank } | Ratios::Plane { bank, .. } => Some(bank),
        }
    }

    /// Made ready for the tick, where the ratios are fixed.
    pub(super) fn terms(&self) -> Terms {
        let (mut of, mut bias) = (Terms::NONE.of, 0i128);
        let axes = self.axes.iter().zip(&self.reference).zip(&self.factors);
        for (to, ((axis, reference), factor)) in of.iter_mut().zip(axes) {
            let size = factor.unsigned_abs();
            // p - reference of either sign is (p ^ flip) - from, which is BIAS more than a number with a sign.
            let flip = *factor >> 63;
            let from = if flip == 0 { *reference as u64 } else { !(*reference as u64) }.wrapping_sub(BIAS);
            let [low, high] = [size as u32 & LOW, (size >> LOW.count_ones()) as u32];
            *to = Term { axis: *axis, flip: flip as u32, from, low, high };
            bias = bias.wrapping_add(size as i128);
        }
        let shift = self.shift as u32;
        Terms { of, shift, bias: bias.wrapping_shl(63), encoder: self.source == Source::Encoder }
    }

    /// Its part of the power, where ratios are those of tables; `place` tells where an axis is.
    #[inline(never)]
    pub(super) fn tabled(
        &self,
        channel: u8,
        place: impl Fn(Axis, Source) -> Pos,
        tables: &Tables,
        stretches: &mut [Stretch; DISTANCES],
    ) -> i64 {
        let places = self.axes.map(|axis| place(axis, self.source).0);
        let along = |bank: u8, index: u8, x: i64, stretch: &mut Stretch| {
            Curve::ratio(channel, bank, index).map_or(0, |curve| tables.at(curve, x, stretch))
        };
        let mut ratios = [0i64; DISTANCES];
        match self.ratios {
            Ratios::Fixed => {}
            Ratios::Lines { bank } => {
                for ((to, index), (x, stretch)) in ratios.iter_mut().zip(0..).zip(places.iter().zip(stretches)) {
                    *to = along(bank, index, *x, stretch);
                }
            }
            Ratios::Plane { bank, axes } => {
                let mut lines = [0i64; 2];
                for ((to, axis), (index, stretch)) in lines.iter_mut().zip(axes).zip((0..).zip(stretches)) {
                    *to = along(bank, index, places.get(axis as usize).copied().unwrap_or(0), stretch);
                }
                let [u, v] = lines;
                let count = Curve::ratio(channel, bank, 0).map_or(0, |curve| tables.count(curve));
                let ratio = tables.plane(channel, bank, count, u, v);
                for axis in axes {
                    if let Some(to) = ratios.get_mut(axis as usize) {
                        *to = ratio;
                    }
                }
            }
        }
        let bank = self.bank().unwrap_or(0);
        let mut sum = 0i128;
        let axes = places.iter().zip(self.reference).zip(self.factors.iter().zip(ratios));
        for (axis, ((x, reference), (factor, ratio))) in (0..).zip(axes) {
            let by = x.wrapping_sub(reference);
            // In 2^-32 instead of the power's 2^-44.
            let over = part(scaled(by, *factor as u64), (self.shift as u32).wrapping_add(12));
            let share = product(over, ratio);
            let most = tables.most(channel, bank, axis).map(|most| (most as i128).wrapping_shl(32));
            sum = sum.wrapping_add(most.map_or(share, |most| share.max(most.wrapping_neg()).min(most)));
        }
        part(sum, 32)
    }
}

/// What makes every distance positive.
const BIAS: u64 = 1 << 63;
/// The lower part of a factor: both parts have 30 bits, so that sums of four products have 64.
const LOW: u32 = (1 << 30) - 1;

/// The share of an axis: (place ± reference)·(low + high·2³⁰).
#[derive(Debug, Clone, Copy)]
struct Term {
    axis: Axis,
    /// All bits of a negative factor's, which counts the distance backwards.
    flip: u32,
    from: u64,
    low: u32,
    high: u32,
}

/// A distance follow of fixed ratios, made ready for the tick: the sum of products of 32 bits, four for each axis, whose
/// sums have no carry.
#[derive(Debug, Clone, Copy)]
pub(super) struct Terms {
    of: [Term; DISTANCES],
    shift: u32,
    encoder: bool,
    /// What the sum is too large by.
    bias: i128,
}

impl Terms {
    pub(super) const NONE: Terms = Terms {
        of: [Term { axis: Axis::FIRST, flip: 0, from: 0, low: 0, high: 0 }; DISTANCES],
        shift: 64,
        encoder: false,
        bias: 0,
    };

    /// Its part of the power, to the nearest.
    #[inline(always)]
    pub(super) fn power(&self, axes: &[AxisState]) -> i64 {
        let product = |a: u32, b: u32| (a as u64).wrapping_mul(b as u64);
        // All distances first: there are not registers enough for both.
        let mut by = [0u64; DISTANCES];
        for (by, Term { axis, flip, from, .. }) in by.iter_mut().zip(&self.of) {
            let place = match axes.get(axis.index()) {
                Some(axis) if self.encoder => (axis.shown.encoder as u64) << Pos::FRAC_BITS,
                Some(axis) => axis.shown.pos.0 as u64,
                None => 0,
            };
            *by = (place ^ ((*flip as u64) << 32 | *flip as u64)).wrapping_sub(*from);
        }
        let (mut s0, mut s30, mut s32, mut s62) = (0u64, 0u64, 0u64, 0u64);
        for (by, Term { low, high, .. }) in by.iter().zip(&self.of) {
            let (b0, b1) = (*by as u32, (*by >> 32) as u32);
            s0 = s0.wrapping_add(product(b0, *low));
            s30 = s30.wrapping_add(product(b0, *high));
            s32 = s32.wrapping_add(product(b1, *low));
            s62 = s62.wrapping_add(product(b1, *high));
        }
        let sum = s0 as u128 + ((s30 as u128) << 30) + ((s32 as u128) << 32) + ((s62 as u128) << 62);
        part((sum as i128).wrapping_sub(self.bias), self.shift)
    }
}

const _: () = assert!(Power::FRAC_BITS == 44 && Pos::FRAC_BITS == 22, "the shifts above");
