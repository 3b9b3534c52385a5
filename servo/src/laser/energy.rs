//! The energy output: pulses or voltage of a power in each mode.
//!
//! In: settings, the power. Out: trains of pulses and DAC values. Owns the settings of the output.
//! Fails: without its settings a mode makes no pulses; a pulse width that reaches the period is
//! limited, and that is published.
use super::PowerMode;
use super::actions::{Count, Train};
use super::dither::{Carrier, Clock, FixedTrain, Standby};
use super::power::Power;
use crate::math::wide::{umul, umulhi};
use core::num::NonZeroU16;

/// The width of pulses of a power, if nothing else depends on it: counts of 2⁻³² per power, 2⁻⁴⁴ %.
#[derive(Debug, Clone, Copy)]
pub(super) struct FixedGainWidth {
    /// 0 where more depends on it.
    gain: u64,
    /// The power whose train the thread has planned; −1: there is none.
    planned: i64,
}

impl FixedGainWidth {
    pub(super) const NONE: FixedGainWidth = FixedGainWidth { gain: 0, planned: -1 };

    /// That width, if the power makes pulses shorter than the period.
    #[inline(always)]
    pub(super) fn width(self, power: Power) -> Option<Count> {
        if self.gain == 0 || power.raw() == self.planned || power >= PowerMode::Duty.full_scale() {
            return None;
        }
        let width = product(power, self.gain);
        (width != 0).then_some(Count { whole: width >> 32, part: width as u32, of: 0 })
    }
}

/// The width of a power, to the nearest.
#[inline(always)]
fn product(power: Power, gain: u64) -> u64 {
    let (high, low) = umul(power.raw() as u64, gain);
    high.wrapping_add(low >> 63)
}

state! {
    /// Settings of the energy output.
    #[derive(Debug, Clone, Copy)]
    pub(super) struct Energy {
        pub(super) mode: PowerMode = PowerMode::Duty,
        pub(super) carrier: Option<Carrier> = None,
        pub(super) width: Option<NonZeroU16> = None,
        pub(super) standby: Option<Standby> = None,
        /// 0 where it is off.
        pub(super) pre_voltage: Power = Power::ZERO,
        /// The connector carries the PWM.
        pub(super) connector: bool = true,
        /// After an abort: no standby, no pre-voltage, no switch that is held, until the next
        /// command of the channel.
        pub(super) muted: bool = false,
        /// The last plan of the thread.
        pub(super) fixed: Option<FixedTrain> = None,
    }
    pub(super) const POWER_ON;
}

impl Energy {
    /// Makes the train of light of this power. Returns whether the pulse width is limited.
    #[inline]
    pub(super) fn light(&self, power: Power, clock: Clock, train: &mut Train) -> bool {
        match (self.mode, &self.carrier, self.width) {
            (PowerMode::Duty | PowerMode::DutyOpen, Some(carrier), _) if self.connector => {
                self.duty(power, carrier, train);
                false
            }
            (PowerMode::Frequency, _, Some(us)) if self.connector && power != Power::ZERO => {
                self.rate(power, us, clock, train)
            }
            _ => {
                *train = Train::NONE;
                false
            }
        }
    }

    /// In the duty modes, if the present train is the carrier with pulses, and not too long: for
    /// another power only the width differs.
    pub(super) fn plain(&self, out: &Train) -> FixedGainWidth {
        let duty = matches!(self.mode, PowerMode::Duty | PowerMode::DutyOpen);
        match &self.carrier {
            Some(carrier) if self.connector && duty && out.period == carrier.period() && !out.is_silent() => {
                let planned = self.fixed.as_ref().and_then(|fixed| fixed.power_over(carrier.khz()));
                FixedGainWidth { gain: carrier.gain, planned: planned.map_or(-1, Power::raw) }
            }
            _ => FixedGainWidth::NONE,
        }
    }

    /// Power as a part of the carrier's period.
    #[inline]
    fn duty(&self, power: Power, carrier: &Carrier, train: &mut Train) {
        match &self.fixed {
            Some(fixed) if fixed.is_of(carrier.khz(), power) => *train = *fixed.train(),
            _ => (train.period, train.width) = (carrier.period(), carrier.share(power)),
        }
    }

    /// Power as a rate of pulses.
    fn rate(&self, power: Power, us: NonZeroU16, clock: Clock, train: &mut Train) -> bool {
        let period = clock.period(power);
        let width = (us.get() as u32 * clock.mhz() as u32) as u64;
        let limit = period.whole.saturating_sub(1);
        (train.period, train.width) = (period, Count { whole: width.min(limit), part: 0, of: 1 });
        width > limit
    }

    /// Standby, while there is no light.
    #[inline]
    pub(super) fn standby(&self) -> Option<&Standby> {
        self.standby.as_ref().filter(|_| self.connector && !self.muted && self.mode.has_standby())
    }

    /// The DAC, where the laser drives it, in light of this power or out of it.
    #[inline]
    pub(super) fn volts(&self, light: bool, power: Power) -> Option<i16> {
        (self.mode == PowerMode::Analog).then(|| counts(if light { power } else { self.waiting_voltage() }))
    }

    /// The voltage while there is no light.
    fn waiting_voltage(&self) -> Power {
        if self.muted { Power::ZERO } else { self.pre_voltage }
    }

    /// Whether the switch is held at its enabled level, light or not.
    #[inline(always)]
    pub(super) fn holds_switch(&self) -> bool {
        self.mode == PowerMode::DutyOpen && !self.muted
    }

    /// The output in light of this power, as published: in the mode's unit, and in kHz.
    #[inline]
    pub(super) fn light_output(&self, power: Power, train: &Train) -> (Power, Power) {
        match (self.mode, &self.carrier) {
            (PowerMode::Analog, _) => (power, Power::ZERO),
            _ if train.is_silent() => (Power::ZERO, Power::ZERO),
            (PowerMode::Duty | PowerMode::DutyOpen, Some(carrier)) => (power, carrier.khz()),
            _ => (power, power),
        }
    }

    /// The output while there is no light, as published.
    pub(super) fn dark_output(&self) -> (Power, Power) {
        match (self.mode, self.standby()) {
            (PowerMode::Analog, _) => (self.waiting_voltage(), Power::ZERO),
            (_, Some(standby)) if standby.train().is_silent() => (Power::ZERO, Power::ZERO),
            (PowerMode::Frequency, Some(standby)) => (standby.khz(), standby.khz()),
            (_, Some(standby)) => (standby.duty(), standby.khz()),
            (_, None) => (Power::ZERO, Power::ZERO),
        }
    }
}

/// 0 to 10 V as the DAC counts: 10 V are 32767, to the nearest.
pub fn counts(volts: Power) -> i16 {
    let scaled = (volts.raw().clamp(0, PowerMode::Analog.full_scale().raw()) as u64).wrapping_mul(32767);
    let tenfold = (scaled.wrapping_add(5 << Power::FRAC_BITS) >> Power::FRAC_BITS) as u32;
    (tenfold / 10) as i16
}

impl Carrier {
    /// This many % of the period, to the nearest 2⁻³² counts, so that whole counts come out whole.
    #[inline(always)]
    fn share(&self, power: Power) -> Count {
        if power >= PowerMode::Duty.full_scale() {
            return self.period();
        }
        if self.gain == 0 {
            return self.long_share(power);
        }
        let width = product(power, self.gain);
        Count { whole: width >> 32, part: width as u32, of: 0 }
    }

    /// The same for a period that is too long for one product; 0 to 100 %.
    #[inline(never)]
    fn long_share(&self, power: Power) -> Count {
        // raw·2^13 is power/128 in 2^-64, and 1.28 of it power/100.
        const POINT_28_PERCENT_Q64: u64 = (28u128 * (1 << 64) / 100) as u64;
        let of_128 = (power.raw() as u64) << 13;
        let part = of_128.wrapping_add(umulhi(of_128, POINT_28_PERCENT_Q64));
        let Count { whole, .. } = self.period();
        let (high, low) = umul(whole, part);
        let (sum, carry) = low.overflowing_add(umul((self.fraction as u64) << 32, part).0);
        let (sum, up) = sum.overflowing_add(1 << 31);
        Count { whole: high.wrapping_add(carry as u64).wrapping_add(up as u64), part: (sum >> 32) as u32, of: 0 }
    }
}
