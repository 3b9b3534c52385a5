//! Distance follow: what the positions of four axes add to the power (SPEC 6, "Energy").
//!
//! In: the user's references, scales and ratios, positions. Out: Σ (pos − ref)/scale · ratio in
//! 2⁻⁴⁴ of the power's unit. Owns nothing but the intervals last used of its tables. Fails: a
//! number that is not finite or out of range is refused.
//!
//! Fixed ratios are divided by their scales at admission and have a common exponent: the sum is off
//! by 2⁻⁵⁸ of the largest factor times the largest distance, and half a unit. With a table the
//! ratio has 44 fraction bits, the distance over the scale 32 and at most ±2²⁹.
use super::fixed_point::{PreparedShift, part, product, scaled};
use super::power::{PowerBounds, Refused};
use super::power_tables::{Curve, DISTANCES, Interval, PowerTables};
use super::velocity_follow::SpeedSource;
use super::{Positions, Power, fixed_point};
use crate::math::float::Float;
use crate::units::{Axis, Pos};

/// The source of the ratios.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ratios {
    /// The same everywhere.
    Fixed,
    /// Each axis has its own table over its position; one of no points is 0.
    Lines {
        /// In this bank.
        bank: u8,
    },
    /// Both axes of a plane (of the four, from 0) have the ratio at their position; the others
    /// none.
    Plane {
        /// In this bank.
        bank: u8,
        /// The axis along the first direction, and the one along the second.
        axes: [u8; 2],
    },
}

impl Ratios {
    /// The bank that they are in.
    pub fn bank(self) -> Option<u8> {
        match self {
            Ratios::Fixed => None,
            Ratios::Lines { bank } | Ratios::Plane { bank, .. } => Some(bank),
        }
    }
}

/// An admitted distance follow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Distance {
    pub(super) source: SpeedSource,
    axes: [Axis; DISTANCES],
    /// In units of Pos.
    reference: [i64; DISTANCES],
    /// ratio/scale, with tables 1/scale, in 2^-(`shift` + 22).
    factors: [i64; DISTANCES],
    shift: u8,
    pub(super) ratios: Ratios,
    pub(super) bounds: Option<PowerBounds>,
}

impl Distance {
    /// `axes` of the controller; references in pulses; `scales` (2⁻¹⁸ to 2³² pulses) and `ratios`
    /// (|r| ≤ 2¹⁷) are the bits of doubles; `bounds` of its own (GUS). With tables the ratios given
    /// here do not count.
    pub fn admit(
        source: SpeedSource,
        axes: [Axis; DISTANCES],
        reference: [i32; DISTANCES],
        scales: [u64; DISTANCES],
        ratios: [u64; DISTANCES],
        from: Ratios,
        bounds: Option<PowerBounds>,
    ) -> Result<Distance, Refused> {
        let mut reals = [Float::ZERO; DISTANCES];
        for ((to, scale), ratio) in reals.iter_mut().zip(scales).zip(ratios) {
            let (scale, ratio) = (fixed_point::float(scale)?, fixed_point::float(ratio)?);
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
        // |f| < 2^width <= 2^36; the products with 63 bits of distance and their sum stay below
        // 2^126.
        let width = reals.iter().fold(-60, |width: i32, real| width.max(real.width()));
        let shift = 60 - width - 22;
        let factors = reals.map(|real| real.to_fixed(shift + 22) as i64);
        let reference = reference.map(|pulses| Pos::pulses(pulses).0);
        Ok(Distance { source, axes, reference, factors, shift: shift as u8, ratios: from, bounds })
    }

    /// Its form for the tick, if the ratios are fixed.
    pub(super) fn terms(&self) -> FixedRatioSum {
        let of = self.factors.map(|factor| {
            let low = factor as i32;
            (low, (factor.wrapping_sub(low as i64) >> 32) as i32)
        });
        // Else the sums of four of its products with the longest displacement would have too many
        // bits.
        let usual = of.iter().all(|(low, _)| *low != i32::MIN);
        let cut = PreparedShift::of(if usual { self.shift as u32 } else { 0 });
        let axes = self.axes.iter().fold(0, |key, axis| key << AXIS_BITS | axis.index() as u32);
        let key = axes | ((self.source == SpeedSource::Encoder) as u32) << 31;
        FixedRatioSum { of, key, cut, token: 0, fresh: true, sum: 0, power: 0 }
    }

    /// Σ (position − reference)·factor.
    #[inline(never)]
    fn sum(&self, positions: [i64; DISTANCES]) -> i128 {
        let axes = positions.iter().zip(&self.reference).zip(&self.factors);
        axes.fold(0, |sum, ((position, reference), factor)| {
            sum.wrapping_add(product(position.wrapping_sub(*reference), *factor))
        })
    }

    /// Its part of the power, with ratios from tables; `place` gives the position of an axis.
    #[inline(never)]
    pub(super) fn tabled(
        &self,
        channel: u8,
        position: impl Fn(Axis, SpeedSource) -> Pos,
        tables: &PowerTables,
        intervals: &mut [Interval; DISTANCES],
    ) -> i64 {
        let positions = self.axes.map(|axis| position(axis, self.source).0);
        let along = |bank: u8, index: u8, x: i64, interval: &mut Interval| {
            Curve::ratio(channel, bank, index).map_or(0, |curve| tables.at(curve, x, interval))
        };
        let mut ratios = [0i64; DISTANCES];
        match self.ratios {
            Ratios::Fixed => {}
            Ratios::Lines { bank } => {
                for ((to, index), (x, interval)) in ratios.iter_mut().zip(0..).zip(positions.iter().zip(intervals)) {
                    *to = along(bank, index, *x, interval);
                }
            }
            Ratios::Plane { bank, axes } => {
                let mut lines = [0i64; 2];
                for ((to, axis), (index, interval)) in lines.iter_mut().zip(axes).zip((0..).zip(intervals)) {
                    *to = along(bank, index, positions.get(axis as usize).copied().unwrap_or(0), interval);
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
        let bank = self.ratios.bank().unwrap_or(0);
        let mut sum = 0i128;
        let axes = positions.iter().zip(self.reference).zip(self.factors.iter().zip(ratios));
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

/// Bits of a displacement, with its sign: the sums of four products with the lower half of a factor
/// have 64.
const DISPLACEMENT_BITS: u32 = 31;
/// Bits of an axis in a key.
const AXIS_BITS: u32 = 6;

/// The displacements of four axes since the tick before: the channels of a core follow the same
/// ones.
#[derive(Debug, Clone, Copy)]
pub(super) struct Displacements {
    /// Index of the axes, the last one lowest, and in the top bit whether their encoders count.
    key: u32,
    /// Of the last sample, and of the one before it.
    token: u32,
    before: u32,
    /// Not 0: an axis moved further than [`DISPLACEMENT_BITS`] hold.
    long: i32,
    by: [i32; DISTANCES],
    from: [i64; DISTANCES],
}

impl Displacements {
    /// Of channel `index`, not sampled yet; tokens of different channels differ.
    pub(super) const fn begin(index: u32) -> Displacements {
        Displacements { key: 0, token: index + 2, before: 1, long: 1, by: [0; DISTANCES], from: [0; DISTANCES] }
    }

    /// Of no axes.
    pub(super) const OF_NOBODY: Displacements = Displacements { key: u32::MAX, ..Displacements::begin(0) };

    /// Whether they are of the axes of `key`.
    #[inline(always)]
    pub(super) fn are_of(&self, key: u32) -> bool {
        self.key == key
    }

    /// Samples the axes of `key` in a tick.
    #[inline(never)]
    pub(super) fn look(&mut self, key: u32, axes: &[impl Positions]) {
        let encoder = key >> 31 == 1;
        // Other axes have another history.
        self.before = if key == self.key { self.token } else { 1 };
        self.token = self.token.wrapping_add(super::CHANNELS as u32);
        (self.key, self.long) = (key, 0);
        let mut left = key;
        for (by, from) in self.by.iter_mut().zip(&mut self.from).rev() {
            let axis = axes.get((left & ((1 << AXIS_BITS) - 1)) as usize);
            left >>= AXIS_BITS;
            let position =
                axis.map_or(0, |axis| if encoder { axis.encoder() << Pos::FRAC_BITS } else { axis.planned().0 });
            let displacement = position.wrapping_sub(*from);
            *by = displacement as i32;
            let upper = (displacement >> 32) as i32;
            self.long |= (upper ^ *by >> (DISPLACEMENT_BITS - 1)) | (upper ^ *by >> (i32::BITS - 1));
            *from = position;
        }
    }
}

crate::state! {
    /// A distance follow of fixed ratios, in the form for the tick. Its sum is kept, exactly, and
    /// the displacements since then are added: 31 bits each, where the distances have 64. A longer
    /// one (256 pulses in a tick) takes the whole sum, and so does a sum that is held at the end of
    /// the range of a part of a power.
    #[derive(Debug, Clone, Copy)]
    pub(super) struct FixedRatioSum {
        /// Factors: low + high·2³².
        of: [(i32, i32); DISTANCES] = [(0, 0); DISTANCES],
        pub(super) key: u32 = 0,
        cut: PreparedShift = PreparedShift::of(0),
        /// The sample that the sum belongs to.
        token: u32 = 0,
        /// The sum is to be computed afresh.
        fresh: bool = true,
        sum: i128 = 0,
        pub(super) power: i64 = 0,
    }
    pub(super) const NONE;
}

impl FixedRatioSum {
    /// There may be samples that it does not take.
    #[inline(always)]
    pub(super) fn skip(&mut self) {
        self.fresh = true;
    }

    /// On to a sample; `distance` is the follow that this was made of.
    #[inline(always)]
    pub(super) fn advance(&mut self, displacements: &Displacements, distance: &Option<Distance>) {
        if self.token == displacements.before && displacements.long == 0 && !self.fresh {
            let product = |a: i32, b: i32| (a as i64).wrapping_mul(b as i64);
            let (mut s0, mut s32) = (0i64, 0i64);
            for (by, (low, high)) in displacements.by.iter().zip(&self.of) {
                s0 = s0.wrapping_add(product(*by, *low));
                s32 = s32.wrapping_add(product(*by, *high));
            }
            let sum = self.sum.wrapping_add(s0 as i128).wrapping_add((s32 as i128) << 32);
            if let Some(power) = self.cut.signed(sum) {
                (self.token, self.sum, self.power) = (displacements.token, sum, power);
                return;
            }
        }
        if self.token != displacements.token || self.fresh {
            self.look(displacements, distance);
        }
    }

    /// The whole sum.
    #[inline(never)]
    fn look(&mut self, displacements: &Displacements, distance: &Option<Distance>) {
        (self.token, self.fresh) = (displacements.token, false);
        if let Some(distance) = distance {
            self.sum = distance.sum(displacements.from);
            self.power = part(self.sum, distance.shift as u32);
        }
    }
}

const _: () = assert!(Power::FRAC_BITS == 44 && Pos::FRAC_BITS == 22, "the shifts above");
