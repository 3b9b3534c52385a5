//! Frequencies and duties as counts of the machine's timer, exact in the mean.
use super::Mode;
use super::plan::{Count, Train};
use super::power::{Power, Refused};

/// The clock of the machine's timers: counts per µs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Clock {
    mhz: u16,
}

impl Clock {
    /// 1 GHz, the clock of the virtual and of the emulated board: a count is a ns.
    pub const GHZ: Clock = Clock { mhz: 1000 };

    /// A clock of 100 to 1000 MHz.
    pub const fn from_mhz(mhz: u16) -> Option<Clock> {
        if mhz >= 100 && mhz <= 1000 { Some(Clock { mhz }) } else { None }
    }

    /// Counts per µs.
    pub const fn mhz(self) -> u16 {
        self.mhz
    }
}

/// The carrier of the duty modes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Carrier {
    khz: Power,
    period: Count,
}

impl Carrier {
    /// A carrier of 0 < f ≤ 2000 kHz.
    pub fn admit(khz: Power, clock: Clock) -> Result<Carrier, Refused> {
        let _ = clock;
        if khz == Power::ZERO {
            return Err(Refused::Zero);
        }
        Ok(Carrier { khz, period: Train::NONE.period })
    }

    /// Its frequency as it was asked for.
    pub const fn khz(&self) -> Power {
        self.khz
    }

    /// Its period as it is output.
    pub const fn period(&self) -> Count {
        self.period
    }
}

/// Standby pulses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Standby {
    khz: Power,
    duty: Power,
    train: Train,
}

impl Standby {
    /// Pulses of 0 < f ≤ 2000 kHz and 0…100 % duty.
    pub fn admit(khz: Power, duty: Power, clock: Clock) -> Result<Standby, Refused> {
        let _ = clock;
        if khz == Power::ZERO {
            return Err(Refused::Zero);
        }
        Ok(Standby { khz, duty, train: Train::NONE })
    }

    /// Frequency as it was asked for.
    pub const fn khz(&self) -> Power {
        self.khz
    }

    /// Duty in % as it was asked for.
    pub const fn duty(&self) -> Power {
        self.duty
    }

    /// As it is output.
    pub const fn train(&self) -> Train {
        self.train
    }
}

/// A fixed light planned ahead with the shortest repetition that is exact enough. It is advice: the tick
/// takes it while carrier and power are the ones it was planned for, and else finds a train by itself
/// that is as exact and repeats later.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fine {
    mode: Mode,
    khz: Power,
    power: Power,
    train: Train,
}

impl Fine {
    /// The plan of a power (held in its bounds) in a mode: in the duty modes over this carrier, in frequency
    /// mode of this pulse width in µs. None where there is nothing to plan.
    pub fn plan(mode: Mode, power: Power, carrier: Option<&Carrier>, clock: Clock) -> Option<Fine> {
        let _ = clock;
        let khz = carrier?.khz;
        Some(Fine { mode, khz, power, train: Train::NONE })
    }

    /// As it is output; in frequency mode the width is that of the pulses then set.
    pub const fn train(&self) -> Train {
        self.train
    }
}

/// Spreads a [`Count`] over periods: gives whole counts whose sum is that of the counts, rounded down.
/// The machines count with this.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Bresenham {
    gathered: u32,
    of: u32,
}

impl Bresenham {
    /// The counts of one more period.
    #[inline]
    pub fn next(&mut self, count: Count) -> u64 {
        if self.of != count.of {
            (self.gathered, self.of) = (0, count.of);
        }
        let (sum, carry) = self.gathered.overflowing_add(count.part);
        let over = carry || (count.of != 0 && sum >= count.of);
        self.gathered = if over { sum.wrapping_sub(count.of) } else { sum };
        count.whole.wrapping_add(over as u64)
    }
}
