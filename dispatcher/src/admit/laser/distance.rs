//! Distance follow: what the positions of axes 1 to 4 of a core add to the power (GUS chapter 5,
//! LSR chapter 4; SPEC 6).
//!
//! In: requests with the user's doubles, the shadow state of the channel. Out: a staged change with
//! the follow as a whole. `tables` has the tables of ratios.
//! Fails: as every laser command does; ratios need a follow that is on.
use super::energy::{own_bounds, powers};
use super::power_range::{Range, RangeLimiter};
use super::{Context, answer_taken};
use crate::refuse::{Admitted, Refused, choice, real};
use crate::report::answer::Answer;
use crate::report::replies::units;
use crate::shadow::{DistanceShadow, LaserChange};
use protocol::command::{SetLaserDisMode, SetLaserDisRatio};
use protocol::reason::Reason;
use protocol::values::FULL_SCALE;
use servo::laser::{ChannelChange, DISTANCES, Distance, PowerBounds, Ratios, SpeedSource};
use servo::units::Axis;

/// Scales of the families, pulses per unit of distance. GUS states no range: it is that of the
/// tick, 2⁻¹⁸ to 2³².
const SCALES: (Range, Range) = (Range::new(1.0 / 262_144.0, FULL_SCALE), Range::new(1.0, 65_536.0));
/// Highest absolute value of a ratio: 2¹⁷.
pub const DISTANCE_RATIO_MAX: f64 = 131_072.0;

/// A ratio: 0, or of either sign. `item` is its index among its kind.
pub fn ratio(field: u8, item: usize, got: f64) -> Admitted<f64> {
    real(field, got, -DISTANCE_RATIO_MAX, DISTANCE_RATIO_MAX).map_err(|refused| refused.item(item))
}

/// The source of positions or speeds.
pub fn source(field: u8, got: i16) -> Admitted<SpeedSource> {
    Ok(if choice(field, got, 0, 1)? == 0 { SpeedSource::Planned } else { SpeedSource::Encoder })
}

/// The distance follow of a channel, which has to be on.
pub fn running<const AXES: usize>(context: &Context<AXES>, channel: u8) -> Admitted<DistanceShadow> {
    context.laser(channel).distance.ok_or_else(|| Refused::new(Reason::DistanceOff).got(channel.into()))
}

/// Stages a follow as a whole.
pub fn stage<const AXES: usize>(context: &mut Context<AXES>, channel: u8, shadow: DistanceShadow) -> Admitted<()> {
    let axes = core::array::from_fn(|index| Axis::new(usize::from(shadow.first) + index).unwrap_or_default());
    let (scale, ratio) = (shadow.scale.map(f64::to_bits), shadow.ratio.map(f64::to_bits));
    let distance = Distance::admit(shadow.source, axes, shadow.reference, scale, ratio, shadow.from, shadow.bounds);
    // The checks let nothing through that the tick refuses.
    let distance = distance.map_err(|_| Refused::new(Reason::OutOfRange))?;
    context.change_with(channel, ChannelChange::Distance(Some(distance)), LaserChange::Distance(Some(shadow)));
    Ok(())
}

/// On: with ratios 0 and no bounds of its own. Off: references and scales are ignored.
pub fn mode<const AXES: usize>(context: &mut Context<AXES>, r: &SetLaserDisMode) -> Admitted<Answer> {
    let channel = context.channel(r.core.get(), 5, r.channel.get())?;
    let on = choice(1, r.mode.get(), 0, 1)? == 1;
    let source = source(2, r.source.get())?;
    if !on {
        context.change_with(channel, ChannelChange::Distance(None), LaserChange::Distance(None));
        return Ok(answer_taken(context, &[0.0; DISTANCES], 0));
    }
    let mut taking = RangeLimiter::new(context.is_lsr());
    let range = if context.is_lsr() { SCALES.1 } else { SCALES.0 };
    let mut scale = [0.0; DISTANCES];
    for (index, (to, given)) in scale.iter_mut().zip(r.scale).enumerate() {
        *to = taking.take(4, index as u8, given.get(), range).map_err(|refused| refused.item(index))?;
    }
    let first = (context.core(r.core.get())? * usize::from(context.configuration.profile.axes_per_core)) as u8;
    let (reference, ratio) = (r.pos.map(|pos| pos.get()), [0.0; DISTANCES]);
    let shadow = DistanceShadow { first, source, reference, scale, ratio, from: Ratios::Fixed, bounds: None };
    stage(context, channel, shadow)?;
    Ok(answer_taken(context, &scale, taking.limited))
}

/// Fixed ratios, which also replace a table. Bounds that are not given stay.
pub fn ratios<const AXES: usize>(context: &mut Context<AXES>, r: &SetLaserDisRatio) -> Admitted<Answer> {
    let channel = context.channel(r.core.get(), 4, r.channel.get())?;
    let mut shadow = running(context, channel)?;
    for (index, (to, given)) in shadow.ratio.iter_mut().zip(r.ratio).enumerate() {
        *to = ratio(1, index, given.get())?;
    }
    shadow.from = Ratios::Fixed;
    let mut taking = RangeLimiter::new(context.is_lsr());
    if r.bounds_given != 0 {
        shadow.bounds = context.distance_bounds(channel, &mut taking, 2, (r.min.get(), r.max.get()))?;
    }
    stage(context, channel, shadow)?;
    Ok(context.distance_bounds_reply(channel, &shadow, taking.limited))
}

impl<const AXES: usize> Context<'_, AXES> {
    /// Bounds of the follow's own: GUS has them, LSR ignores them. `field` is that of the minimum;
    /// the maximum's is the next.
    pub fn distance_bounds(
        &self,
        channel: u8,
        taking: &mut RangeLimiter,
        field: u8,
        (min, max): (f64, f64),
    ) -> Admitted<Option<PowerBounds>> {
        if self.is_lsr() {
            return Ok(None);
        }
        if max < min {
            return Err(Refused::new(Reason::BelowMinimum).field(field + 1).got(max).limits(min, min));
        }
        let mode = self.laser(channel).mode;
        let range = powers(mode, false, self.shadows.high_resolution);
        let (min, max) = (taking.take(field, 1, min, range)?, taking.take(field + 1, 0, max, range)?);
        own_bounds(mode, (field, min), (field + 1, max)).map(Some)
    }

    /// The reply: the bounds that hold for it, which are those of the mode if it has none.
    pub fn distance_bounds_reply(&mut self, channel: u8, shadow: &DistanceShadow, limited: u8) -> Answer {
        let bounds = shadow.bounds.unwrap_or(self.laser(channel).bounds);
        answer_taken(self, &[units(bounds.max()), units(bounds.min())], limited)
    }
}
