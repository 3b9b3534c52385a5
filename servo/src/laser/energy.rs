//! The energy output: what a power means in each mode.
//!
//! In: settings, the power. Out: trains of pulses and DAC values. Owns the settings of the output. Fails:
//! what is not set makes no pulses; a pulse width that reaches the period is limited, and said to be.
use super::Mode;
use super::dither::{Carrier, Clock, Fine, Standby};
use super::plan::{Count, Train};
use super::power::Power;
use crate::wide::umul;
use core::num::NonZeroU16;

/// Settings of the energy output.
#[derive(Debug, Clone, Copy)]
pub(super) struct Energy {
    pub(super) mode: Mode,
    pub(super) carrier: Option<Carrier>,
    pub(super) width: Option<NonZeroU16>,
    pub(super) standby: Option<Standby>,
    pub(super) pre_voltage: Option<Power>,
    /// The connector carries the PWM.
    pub(super) connector: bool,
    /// The last plan of the thread.
    pub(super) fine: Option<Fine>,
}

/// What is being put out, for people.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Told {
    /// In the mode's unit.
    pub(super) power: Power,
    pub(super) khz: Power,
    pub(super) train: Train,
}

impl Energy {
    pub(super) const POWER_ON: Energy = Energy {
        mode: Mode::Duty,
        carrier: None,
        width: None,
        standby: None,
        pre_voltage: None,
        connector: true,
        fine: None,
    };

    /// The train of light of this power, and whether the pulse width is limited.
    pub(super) fn light(&self, power: Power, clock: Clock) -> (Train, bool) {
        if !self.connector {
            return (Train::NONE, false);
        }
        match self.mode {
            Mode::Analog => (Train::NONE, false),
            Mode::Duty | Mode::DutyOpen => (self.duty(power), false),
            Mode::Frequency => self.rate(power, clock),
        }
    }

    /// Power as a part of the carrier's period.
    fn duty(&self, power: Power) -> Train {
        let Some(carrier) = &self.carrier else { return Train::NONE };
        if let Some(train) = self.fine.and_then(|fine| fine.duty(carrier, power)) {
            return train;
        }
        Train { period: carrier.period(), width: carrier.share(power) }
    }

    /// Power as a rate of pulses.
    fn rate(&self, power: Power, clock: Clock) -> (Train, bool) {
        let Some(us) = self.width else { return (Train::NONE, false) };
        if power == Power::ZERO {
            return (Train::NONE, false);
        }
        let period = self.fine.and_then(|fine| fine.rate(power)).unwrap_or_else(|| clock.period(power));
        let width = us.get() as u64 * clock.mhz() as u64;
        let limit = period.whole.saturating_sub(1);
        (Train { period, width: Count { whole: width.min(limit), part: 0, of: 1 } }, width > limit)
    }

    /// The train while there is no light.
    pub(super) fn standby(&self) -> Train {
        match &self.standby {
            Some(standby) if self.connector && self.mode.has_standby() => standby.train(),
            _ => Train::NONE,
        }
    }

    /// The DAC, where the laser drives it, in light of this power or out of it.
    pub(super) fn volts(&self, light: bool, power: Power) -> Option<i16> {
        let volts = if light { power } else { self.pre_voltage.unwrap_or(Power::ZERO) };
        (self.mode == Mode::Analog).then(|| counts(volts))
    }

    /// What is put out, in light of this power and train or out of it.
    pub(super) fn told(&self, light: bool, power: Power, train: &Train) -> Told {
        match (self.mode, light) {
            (Mode::Analog, true) => Told { power, ..Told::default() },
            (Mode::Analog, false) => Told { power: self.pre_voltage.unwrap_or(Power::ZERO), ..Told::default() },
            (_, true) if train.is_silent() => Told { train: *train, ..Told::default() },
            (Mode::Frequency, true) => Told { power, khz: power, train: *train },
            (_, true) => Told { power, khz: self.carrier.map_or(Power::ZERO, |c| c.khz()), train: *train },
            (_, false) => self.told_standby(),
        }
    }

    fn told_standby(&self) -> Told {
        let train = self.standby();
        match &self.standby {
            Some(standby) if !train.is_silent() => {
                let power = if self.mode == Mode::Frequency { standby.khz() } else { standby.duty() };
                Told { power, khz: standby.khz(), train }
            }
            _ => Told { train, ..Told::default() },
        }
    }
}

/// 0 to 10 V as the DAC counts: 10 V are 32767, to the nearest.
fn counts(volts: Power) -> i16 {
    let scaled = (volts.raw().clamp(0, Mode::Analog.full_scale().raw()) as u64).wrapping_mul(32767);
    let tenfold = (scaled.wrapping_add(5 << Power::FRAC_BITS) >> Power::FRAC_BITS) as u32;
    (tenfold / 10) as i16
}

impl Carrier {
    /// This many % of the period, in 2⁻³² counts.
    fn share(&self, power: Power) -> Count {
        if power >= Mode::Duty.full_scale() {
            return self.period();
        }
        // raw·2^13 is power/128 in 2^-64, and 1.28 of it power/100.
        const POINT_28: u64 = (28u128 * (1 << 64) / 100) as u64;
        let of_128 = (power.raw() as u64) << 13;
        let part = of_128.wrapping_add(umul(of_128, POINT_28).0);
        let Count { whole, .. } = self.period();
        let (high, low) = umul(whole, part);
        let (sum, carry) = low.overflowing_add(umul((self.fraction() as u64) << 32, part).0);
        Count { whole: high.wrapping_add(carry as u64), part: (sum >> 32) as u32, of: 0 }
    }
}
