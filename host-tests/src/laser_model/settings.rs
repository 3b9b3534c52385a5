//! The settings of a channel after some commands, and the trains of pulses that they mean.
use super::{Command, Exact, Family, Fpk, Mode, Ns};

/// The settings after some of the commands.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    pub mode: Mode,
    pub max: Exact,
    pub min: Exact,
    pub delayed: bool,
    pub power: Exact,
    pub carrier: Option<Exact>,
    pub width: Option<Ns>,
    pub off_delay: Ns,
    pub on_delay: Ns,
    pub fpk: Option<Fpk>,
    pub standby: Option<(Exact, Exact)>,
    pub pre_voltage: Option<Exact>,
    pub connector: bool,
    pub fault: bool,
}

/// A train of pulses; exact, in ns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Train {
    /// From pulse to pulse.
    pub period: Exact,
    /// Of a pulse.
    pub width: Exact,
}

pub fn whole(value: i128) -> Exact {
    Exact::from_integer(value)
}

/// ns of a period of so many kHz.
fn period(khz: Exact) -> Exact {
    whole(1_000_000) / khz
}

/// The whole ns of k periods.
pub fn times(value: Exact, k: i128) -> Ns {
    (value.numer() * k).div_euclid(*value.denom()) as Ns
}

impl Settings {
    pub fn power_on(family: Family) -> Settings {
        Settings {
            mode: Mode::Duty,
            max: whole(100),
            min: whole(0),
            delayed: family == Family::Gus,
            power: whole(0),
            carrier: None,
            width: None,
            off_delay: 0,
            on_delay: 0,
            fpk: None,
            standby: None,
            pre_voltage: None,
            connector: true,
            fault: false,
        }
    }

    pub fn apply(&mut self, family: Family, command: &Command) {
        match *command {
            Command::Gate(_) | Command::ZeroOnTime => {}
            Command::PowerMode { mode, max, min, delayed } => {
                let mode = kind(family, mode);
                if mode != self.mode {
                    self.power = whole(0);
                }
                *self = Settings { mode, max, min, delayed: delayed || family == Family::Gus, ..self.clone() };
            }
            Command::Power(power) => self.power = power,
            Command::Carrier(khz) => self.carrier = Some(khz),
            Command::Width(width) => self.width = Some(width),
            Command::Delays { off, on } => (self.off_delay, self.on_delay) = (off, on),
            Command::Fpk(fpk) => self.fpk = fpk,
            Command::Standby(standby) => self.standby = standby,
            Command::PreVoltage(volts) => self.pre_voltage = volts,
            Command::Fault => self.fault = true,
            Command::Clear => self.fault = false,
            Command::Connector(carries) => self.connector = carries,
            Command::Reset => *self = Settings::power_on(family),
        }
    }

    /// The power held in its bounds.
    pub fn bounded(&self) -> Exact {
        self.power.max(self.min).min(self.max)
    }

    /// Light of full duty: a level, no pulses that could be finished.
    pub fn is_level(&self) -> bool {
        matches!(self.mode, Mode::Duty | Mode::Open) && self.train().is_some_and(|train| train.width >= train.period)
    }

    /// Pulses of light; none where something is missing.
    pub fn train(&self) -> Option<Train> {
        let power = self.bounded();
        if !self.connector {
            return None;
        }
        match self.mode {
            Mode::Duty | Mode::Open => {
                let period = period(self.carrier?);
                Some(Train { period, width: period * power / whole(100) })
            }
            Mode::Frequency => {
                let width = whole(self.width?.into());
                if power <= whole(0) {
                    return None;
                }
                let period = period(power);
                // Reading 21.
                Some(Train { period, width: width.min(period.floor() - whole(1)) })
            }
            Mode::Analog => None,
        }
    }

    pub fn standby_train(&self) -> Option<Train> {
        let (khz, percent) = self.standby.filter(|_| self.connector)?;
        let period = period(khz);
        Some(Train { period, width: period * percent / whole(100) })
    }

    /// Standby may be output where there is no light.
    pub fn standby_allowed(&self) -> bool {
        matches!(self.mode, Mode::Duty | Mode::Frequency) && !self.fault
    }
}

/// LSR has no mode 3 of its own.
pub fn kind(family: Family, mode: Mode) -> Mode {
    if family == Family::Lsr && mode == Mode::Open { Mode::Duty } else { mode }
}
