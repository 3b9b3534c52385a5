//! The energy of a laser channel: modes and bounds, power, carrier, pulse width, standby,
//! pre-voltage, resolution.
//!
//! In: requests with the user's doubles. Out: staged changes with the tick's numbers. With them
//! goes the train for the power of the shadow state (`FixedTrain`), so that the tick need not
//! search for it.
use super::power_range::{Range, RangeLimiter};
use super::{Context, answer_taken};
use crate::refuse::{Admitted, Refused, choice};
use crate::report::answer::Answer;
use crate::report::replies::{counts, units};
use crate::shadow::{LaserChange, LaserShadow, ShadowChange as Entered};
use core::num::NonZeroU16;
use protocol::command::{
    LaserOutFrq, LaserPowerMode, LaserPrfCmd, SetLaserMode, SetPreVltg, SetPulseWidth, SetWaitPulse, SetWaitPulseEx,
};
use protocol::reason::Reason;
use servo::laser::{
    CHANNELS, Carrier, ChannelChange, Clock, Count, FixedTrain, Power, PowerBounds, PowerMode, Standby, Train,
};
use servo::tick_command::TickCommand;
use servo::units::CrdMask;

/// Duties, %.
const DUTY_PERCENT: Range = Range::new(0.0, 100.0);
/// Voltages, V.
const OUTPUT_VOLTS: Range = Range::new(0.0, 10.0);
/// Highest frequency of the GUS family, kHz.
const GUS_KHZ: f64 = 2000.0;
/// Highest frequency of the LSR family's low (SetLaserMode 0) and high resolution (1), kHz.
const LSR_KHZ: [f64; 2] = [96.0, 24.0];
/// Longest pulse of the families, µs.
const WIDTH_MAX_US: (u16, u16) = (65_535, 4_000);
/// Bit of `held` for a pulse width limited to just under the period.
const WIDTH_LIMITED: u8 = 1 << 7;

/// The highest frequency.
fn highest(lsr: bool, high_resolution: bool) -> f64 {
    if lsr { LSR_KHZ[usize::from(high_resolution)] } else { GUS_KHZ }
}

/// Range of a carrier.
fn carriers(lsr: bool, high_resolution: bool) -> Range {
    Range::frequency(highest(lsr, high_resolution))
}

/// Range of a bound of the power in a mode.
pub fn powers(mode: PowerMode, lsr: bool, high_resolution: bool) -> Range {
    match mode {
        PowerMode::Duty | PowerMode::DutyOpen => DUTY_PERCENT,
        PowerMode::Frequency => Range::new(0.0, highest(lsr, high_resolution)),
        PowerMode::Analog => OUTPUT_VOLTS,
    }
}

/// Range of a direct power in a mode: a rate other than 0 is at least 1 Hz.
pub fn direct_powers(mode: PowerMode, lsr: bool, high_resolution: bool) -> Range {
    if mode == PowerMode::Frequency {
        Range::rate(highest(lsr, high_resolution))
    } else {
        powers(mode, lsr, high_resolution)
    }
}

/// Bit of `held` for pulses of this width (µs) that reach the period at this power.
pub fn limited(mode: PowerMode, width_us: u16, power: Power) -> u8 {
    // µs times kHz: a period is 1000.
    let reaches = f64::from(width_us) * units(power) >= 1000.0;
    if reaches && mode == PowerMode::Frequency { WIDTH_LIMITED } else { 0 }
}

/// A checked number in the tick's format. The checks allow nothing that it refuses.
pub fn power(field: u8, value: f64) -> Admitted<Power> {
    Power::admit(value.to_bits()).map_err(|_| Refused::range(field, value, 0.0, GUS_KHZ))
}

/// Checked bounds in the tick's format, each with its field.
pub fn own_bounds(mode: PowerMode, min: (u8, f64), max: (u8, f64)) -> Admitted<PowerBounds> {
    PowerBounds::admit(mode, power(max.0, max.1)?, power(min.0, min.1)?)
        .map_err(|_| Refused::new(Reason::BelowMinimum).field(max.0).got(max.1).limits(min.1, min.1))
}

fn carrier(field: u8, khz: f64, clock: Clock) -> Admitted<Carrier> {
    let no = |_| Refused::range(field, khz, 0.0, GUS_KHZ);
    Carrier::admit(power(field, khz)?, clock).map_err(no)
}

/// The frequency of a period as it is output, kHz.
fn khz(period: Count, clock: Clock) -> f64 {
    f64::from(clock.mhz()) * 1000.0 / counts(period)
}

/// The active share of a train's periods, %.
fn percent(train: &Train) -> f64 {
    counts(train.width) / counts(train.period) * 100.0
}

impl LaserShadow {
    /// The train for the power that this channel holds.
    fn fixed(&self, clock: Clock) -> Option<FixedTrain> {
        FixedTrain::plan(self.mode, self.bounds.hold(self.power), self.carrier.as_ref(), clock)
    }

    /// The output for the power that this channel holds, in the mode's unit; `fixed` is its train.
    fn reached(&self, fixed: Option<FixedTrain>, clock: Clock) -> f64 {
        let power = self.bounds.hold(self.power);
        match (self.mode, fixed) {
            (PowerMode::Frequency, _) if power > Power::ZERO => khz(clock.period(power), clock),
            (_, Some(fixed)) => percent(fixed.train()),
            (_, None) => units(power),
        }
    }

    /// Whether the width reaches the period of the pulses that it outputs.
    fn is_limited(&self) -> u8 {
        limited(self.mode, self.width_us, self.bounds.hold(self.power))
    }
}

/// Only while no crd of the core runs (SPEC 6).
pub fn mode<const AXES: usize>(context: &mut Context<AXES>, r: &LaserPowerMode) -> Admitted<Answer> {
    let channel = context.channel(r.core.get(), 4, r.channel.get())?;
    let crds = CrdMask(context.crds_of(context.core(r.core.get())?));
    crds.crds().try_for_each(|crd| context.crd_at_standstill(crd))?;
    let lsr = context.is_lsr();
    let mode = match choice(1, r.mode.get(), 0, 3)? {
        1 => PowerMode::Frequency,
        2 => PowerMode::Analog,
        3 if !lsr => PowerMode::DutyOpen,
        _ => PowerMode::Duty,
    };
    // GUS always applies the delays and has no such parameter.
    let delayed = !lsr || choice(5, r.delay_mode.get(), 0, 1)? == 1;
    let (max, min) = (r.max.get(), r.min.get());
    // LSR compares what is taken: a minimum outside its range is not above the maximum.
    if !lsr && max < min {
        return Err(Refused::new(Reason::BelowMinimum).field(2).got(max).limits(min, min));
    }
    let range = powers(mode, lsr, context.shadows.high_resolution);
    let mut taking = RangeLimiter::new(lsr);
    let (max, min) = (taking.maximum(2, 0, max, range)?, taking.minimum(3, 1, min, range)?);
    let bounds = own_bounds(mode, (3, min), (2, max))?;
    let mut shadow = *context.laser(channel);
    let before = shadow.mode;
    shadow.set_mode(mode, bounds, delayed);
    let fixed = shadow.fixed(context.clock()?);
    let entered = LaserChange::Mode { mode, bounds, delayed };
    context.change_with(channel, ChannelChange::Mode { mode, bounds, delayed, fixed }, entered);
    if (before == PowerMode::Analog) != (mode == PowerMode::Analog) {
        pair_standby(context, (channel, mode))?;
    }
    Ok(answer_taken(context, &[max, min], taking.limited | shadow.is_limited()))
}

/// Reports the power that is reached, within its bounds.
pub fn direct<const AXES: usize>(context: &mut Context<AXES>, r: &LaserPrfCmd) -> Admitted<Answer> {
    let channel = context.channel(r.core.get(), 2, r.channel.get())?;
    let mut shadow = *context.laser(channel);
    let mut taking = RangeLimiter::new(context.is_lsr());
    let range = direct_powers(shadow.mode, context.is_lsr(), context.shadows.high_resolution);
    let value = taking.take(1, 0, r.power.get(), range)?;
    shadow.power = power(1, value)?;
    let clock = context.clock()?;
    let (power, fixed) = (shadow.power, shadow.fixed(clock));
    context.change_with(channel, ChannelChange::Direct { power, fixed }, LaserChange::Power(power));
    Ok(answer_taken(context, &[shadow.reached(fixed, clock)], taking.limited | shadow.is_limited()))
}

/// Reports the frequency that is reached.
pub fn frequency<const AXES: usize>(context: &mut Context<AXES>, r: &LaserOutFrq) -> Admitted<Answer> {
    let channel = context.channel(r.core.get(), 2, r.channel.get())?;
    let mut taking = RangeLimiter::new(context.is_lsr());
    let value = taking.take(1, 0, r.frequency.get(), carriers(context.is_lsr(), context.shadows.high_resolution))?;
    let clock = context.clock()?;
    let carrier = carrier(1, value, clock)?;
    stage_carrier(context, channel, carrier)?;
    Ok(answer_taken(context, &[khz(carrier.period(), clock)], taking.limited))
}

fn stage_carrier<const AXES: usize>(context: &mut Context<AXES>, channel: u8, carrier: Carrier) -> Admitted<()> {
    let mut shadow = *context.laser(channel);
    shadow.carrier = Some(carrier);
    let fixed = shadow.fixed(context.clock()?);
    context.change_with(channel, ChannelChange::Carrier { carrier, fixed }, LaserChange::Carrier(carrier));
    Ok(())
}

/// A width that reaches the period is limited to just under it, and this is reported.
pub fn width<const AXES: usize>(context: &mut Context<AXES>, r: &SetPulseWidth) -> Admitted<Answer> {
    let channel = context.channel(r.core.get(), 2, r.channel.get())?;
    let mut taking = RangeLimiter::new(context.is_lsr());
    let longest = if context.is_lsr() { WIDTH_MAX_US.1 } else { WIDTH_MAX_US.0 };
    let width_us = taking.whole(1, 0, r.width_us.get(), 1, longest)?;
    let mut shadow = *context.laser(channel);
    shadow.width_us = width_us;
    if let Some(us) = NonZeroU16::new(width_us) {
        context.change_with(channel, ChannelChange::PulseWidth { us }, LaserChange::Width(width_us));
    }
    Ok(answer_taken(context, &[width_us.into()], taking.limited | shadow.is_limited()))
}

/// SetWaitPulseEx of the LSR family acts only while both channels are PWM (LSR, command 21): its
/// pulses stop while one of them is analog. One channel is about to have another mode.
fn pair_standby<const AXES: usize>(context: &mut Context<AXES>, changed: (u8, PowerMode)) -> Admitted<()> {
    let clock = context.clock()?;
    let analog = !are_pwm(context, Some(changed));
    for channel in 0..CHANNELS as u8 {
        let shadow = *context.laser(channel);
        if let Some((khz, duty)) = shadow.standby.filter(|_| shadow.paired) {
            let none = |_| Refused::new(Reason::OutOfRange);
            let pulses = if analog { None } else { Some(Standby::admit(khz, duty, clock).map_err(none)?) };
            context.change(channel, ChannelChange::PairedStandby(pulses));
        }
    }
    Ok(())
}

/// Whether both channels are PWM; one of them may be about to have another mode.
fn are_pwm<const AXES: usize>(context: &Context<AXES>, changed: Option<(u8, PowerMode)>) -> bool {
    (0..CHANNELS as u8).all(|channel| {
        let mode = changed.filter(|(of, _)| *of == channel).map_or(context.laser(channel).mode, |(_, mode)| mode);
        mode != PowerMode::Analog
    })
}

pub fn standby_one<const AXES: usize>(context: &mut Context<AXES>, r: &SetWaitPulse) -> Admitted<Answer> {
    let channel = context.channel(r.core.get(), 4, r.channel.get())?;
    context.set_standby(channel..channel + 1, false, (r.mode.get(), r.frequency.get(), r.duty.get()))
}

pub fn standby_all<const AXES: usize>(context: &mut Context<AXES>, r: &SetWaitPulseEx) -> Admitted<Answer> {
    context.core(r.core.get())?;
    let paired = context.is_lsr();
    context.set_standby(0..CHANNELS as u8, paired, (r.mode.get(), r.frequency.get(), r.duty.get()))
}

pub fn pre_voltage<const AXES: usize>(context: &mut Context<AXES>, r: &SetPreVltg) -> Admitted<Answer> {
    let channel = context.channel(r.core.get(), 3, r.channel.get())?;
    let on = choice(1, r.mode.get(), 0, 1)? == 1;
    let mut taking = RangeLimiter::new(context.is_lsr());
    let volts = taking.take(2, 0, r.voltage.get(), OUTPUT_VOLTS)?;
    let volts_fixed = power(2, volts)?;
    context.change(channel, ChannelChange::PreVoltage(on.then_some(volts_fixed)));
    Ok(answer_taken(context, &[volts], taking.limited))
}

/// The range of frequencies in the LSR family, of both channels: a set value above a new range is
/// limited to its bound. In the GUS family it has no effect.
pub fn resolution<const AXES: usize>(context: &mut Context<AXES>, r: &SetLaserMode) -> Admitted<Answer> {
    context.core(r.core.get())?;
    let high_resolution = choice(1, r.mode.get(), 0, 1)? == 1;
    context.stage_with(TickCommand::Mark, Entered::LaserResolution(high_resolution));
    if context.is_lsr() {
        let highest = power(1, highest(true, high_resolution))?;
        for channel in 0..CHANNELS as u8 {
            hold_frequencies(context, channel, highest)?;
        }
    }
    Ok(Answer::Done)
}

fn hold_frequencies<const AXES: usize>(context: &mut Context<AXES>, channel: u8, highest: Power) -> Admitted<()> {
    let mut shadow = *context.laser(channel);
    let clock = context.clock()?;
    let none = |_| Refused::new(Reason::OutOfRange).field(1);
    if shadow.carrier.is_some_and(|carrier| carrier.khz() > highest) {
        stage_carrier(context, channel, Carrier::admit(highest, clock).map_err(none)?)?;
    }
    if let Some((_, duty)) = shadow.standby.filter(|(khz, _)| *khz > highest) {
        let pulses = Some(Standby::admit(highest, duty, clock).map_err(none)?);
        let output = pulses.filter(|_| !shadow.paired || are_pwm(context, None));
        let entered = LaserChange::Standby(Some((highest, duty)), shadow.paired);
        context.change_with(channel, ChannelChange::Standby(output), entered);
    }
    if shadow.mode == PowerMode::Frequency && (shadow.bounds.max() > highest || shadow.power > highest) {
        let (max, min) = (shadow.bounds.max().min(highest), shadow.bounds.min().min(highest));
        shadow.bounds = PowerBounds::admit(shadow.mode, max, min).map_err(none)?;
        shadow.power = shadow.power.min(highest);
        let (LaserShadow { mode, bounds, delayed, power, .. }, fixed) = (shadow, shadow.fixed(clock));
        context.change_with(channel, ChannelChange::Direct { power, fixed }, LaserChange::Power(power));
        let entered = LaserChange::Mode { mode, bounds, delayed };
        context.change_with(channel, ChannelChange::Mode { mode, bounds, delayed, fixed }, entered);
    }
    Ok(())
}

impl<const AXES: usize> Context<'_, AXES> {
    /// Standby pulses of some channels. To switch them off, frequency and duty may be 0. `paired`:
    /// they act while both are PWM.
    fn set_standby(
        &mut self,
        channels: core::ops::Range<u8>,
        paired: bool,
        (mode, frequency, duty): (u16, f64, f64),
    ) -> Admitted<Answer> {
        let on = choice(1, mode, 0, 1)? == 1;
        let mut taking = RangeLimiter::new(self.is_lsr());
        let range = if on || frequency != 0.0 {
            carriers(self.is_lsr(), self.shadows.high_resolution)
        } else {
            Range::new(0.0, 0.0)
        };
        let frequency = taking.take(2, 0, frequency, range)?;
        let duty = taking.take(3, 1, duty, DUTY_PERCENT)?;
        let clock = self.clock()?;
        let pulses = if on {
            let none = |_| Refused::range(2, frequency, 0.0, GUS_KHZ);
            Some(Standby::admit(power(2, frequency)?, power(3, duty)?, clock).map_err(none)?)
        } else {
            None
        };
        let output = pulses.filter(|_| !paired || are_pwm(self, None));
        for channel in channels {
            let shadow = pulses.map(|pulses| (pulses.khz(), pulses.duty()));
            self.change_with(channel, ChannelChange::Standby(output), LaserChange::Standby(shadow, paired));
        }
        let reached = pulses.map_or((frequency, duty), |pulses| {
            let train = pulses.train();
            (khz(train.period, clock), percent(train))
        });
        Ok(answer_taken(self, &[reached.0, reached.1], taking.limited))
    }
}
