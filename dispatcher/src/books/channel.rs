//! What the thread knows of one laser channel.
use servo::laser::{self, Bounds, Carrier, Power};

/// One laser channel.
#[derive(Debug, Clone, Copy)]
pub struct LaserBook {
    /// Power mode.
    pub mode: laser::Mode,
    /// Bounds of the power.
    pub bounds: Bounds,
    /// The gate's delays apply.
    pub delayed: bool,
    /// Direct power.
    pub power: Power,
    /// Carrier of the duty modes.
    pub carrier: Option<Carrier>,
    /// Pulse width of the frequency mode, µs; 0 is none set.
    pub width_us: u16,
    /// Standby pulses: kHz and %.
    pub standby: Option<(Power, Power)>,
    /// The axis connector carries the laser.
    pub connector: bool,
    /// Crds over all cores, bit 0 is crd 1 of core 1.
    pub map: u8,
    /// The last entry that clears the channel's fault, until it is executed.
    pub cleared: Option<u32>,
}

impl LaserBook {
    /// A channel at power-on (SPEC 6).
    pub const fn power_on(delayed: bool, connector: bool) -> LaserBook {
        LaserBook {
            mode: laser::Mode::Duty,
            bounds: Bounds::full(laser::Mode::Duty),
            delayed,
            power: Power::ZERO,
            carrier: None,
            width_us: 0,
            standby: None,
            connector,
            map: u8::MAX,
            cleared: None,
        }
    }

    /// Another mode sets the power to 0; the same one changes only what is given with it.
    pub fn set_mode(&mut self, mode: laser::Mode, bounds: Bounds, delayed: bool) {
        if self.mode != mode {
            self.power = Power::ZERO;
        }
        (self.mode, self.bounds, self.delayed) = (mode, bounds, delayed);
    }

    pub(super) fn enter(&mut self, change: LaserChange, seq: u32) {
        match change {
            LaserChange::PowerOn { delayed, connector } => {
                *self = LaserBook { cleared: Some(seq), ..LaserBook::power_on(delayed, connector) };
            }
            LaserChange::Mode { mode, bounds, delayed } => self.set_mode(mode, bounds, delayed),
            LaserChange::Power(power) => self.power = power,
            LaserChange::Carrier(carrier) => self.carrier = Some(carrier),
            LaserChange::Width(width_us) => self.width_us = width_us,
            LaserChange::Standby(standby) => self.standby = standby,
            LaserChange::Connector(laser) => self.connector = laser,
            LaserChange::Map(map) => self.map = map,
            LaserChange::Cleared => self.cleared = Some(seq),
        }
    }
}

/// What a laser operation changes in the book of its channel.
#[derive(Debug, Clone, Copy)]
pub enum LaserChange {
    /// Power-on state of a family.
    PowerOn { delayed: bool, connector: bool },
    /// LaserPowerMode.
    Mode { mode: laser::Mode, bounds: Bounds, delayed: bool },
    /// Direct power.
    Power(Power),
    /// Carrier.
    Carrier(Carrier),
    /// Pulse width, µs.
    Width(u16),
    /// Standby pulses: kHz and %.
    Standby(Option<(Power, Power)>),
    /// What the axis connector carries.
    Connector(bool),
    /// Crd map.
    Map(u8),
    /// The fault is cleared.
    Cleared,
}
