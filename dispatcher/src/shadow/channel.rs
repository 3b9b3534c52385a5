//! Shadow state of one laser channel.
use super::is_in_flight;
use servo::Fifos;
use servo::laser::{self, BANKS, Carrier, DISTANCES, POWER_TABLES, Power, PowerBounds, Ratios, SpeedSource};
use servo::view::View;

/// Distance follow as it was given.
#[derive(Debug, Clone, Copy)]
pub struct DistanceShadow {
    /// Index of the first of its four axes.
    pub first: u8,
    /// The source of its positions.
    pub source: SpeedSource,
    /// Reference positions, pulses.
    pub reference: [i32; DISTANCES],
    /// Pulses per unit of distance.
    pub scale: [f64; DISTANCES],
    /// Ratios of the axes that have no table.
    pub ratio: [f64; DISTANCES],
    /// Source of the ratios.
    pub from: Ratios,
    /// Bounds of its own.
    pub bounds: Option<PowerBounds>,
}

servo::state! {
    /// One laser channel.
    #[derive(Debug, Clone, Copy)]
    pub struct LaserShadow {
        /// Power mode.
        pub mode: laser::PowerMode = laser::PowerMode::Duty,
        /// Bounds of the power.
        pub bounds: PowerBounds = PowerBounds::full(laser::PowerMode::Duty),
        /// The gate's delays apply.
        pub delayed: bool = delayed,
        /// Direct power.
        pub power: Power = Power::ZERO,
        /// Carrier of the duty modes.
        pub carrier: Option<Carrier> = None,
        /// Pulse width of the frequency mode, µs; 0 is none set.
        pub width_us: u16 = 0,
        /// Standby pulses: kHz and %.
        pub standby: Option<(Power, Power)> = None,
        /// They are output only while both channels are PWM (LSR, SetWaitPulseEx).
        pub paired: bool = false,
        /// The axis connector carries the laser.
        pub connector: bool = connector,
        /// Crds over all cores, bit 0 is crd 1 of core 1.
        pub map: u8 = u8::MAX,
        /// The last entry that clears the channel's fault, until it is executed.
        pub cleared: Option<u32> = None,
        /// Distance follow; none is off.
        pub distance: Option<DistanceShadow> = None,
        /// The last entry that named each bank of ratios.
        banks: [Option<u32>; BANKS] = [None; BANKS],
        /// Follow tables that hold points, a bit each.
        pub tables: u8 = 0,
        /// For each follow table the FIFOs that were given an entry that names it: bit 2·crd +
        /// FIFO.
        pub named: [Fifos; POWER_TABLES] = [0; POWER_TABLES],
    }
    /// A channel at power-on (SPEC 6).
    pub const fn power_on(delayed: bool, connector: bool);
}

impl LaserShadow {
    /// Whether a follow table holds points.
    pub fn is_filled(&self, table: u8) -> bool {
        self.tables >> (table & 7) & 1 == 1
    }

    /// A follow table is being overwritten. Until the entry of its new data has been executed, its
    /// content belongs to nothing executed.
    pub fn invalidate(&mut self, table: u8) {
        self.tables &= !(1 << (table & 7));
    }

    /// A bank of ratios that nothing reads or will read; `read` is the one in use.
    pub fn free_bank<const AXES: usize>(&self, view: &View<AXES>, read: Option<u8>) -> Option<u8> {
        let ahead = self.distance.and_then(|distance| distance.from.bank());
        let named = |bank: u8| self.banks.get(usize::from(bank)).copied().flatten();
        (0..BANKS as u8).find(|bank| {
            let waits = is_in_flight(view, named(*bank));
            Some(*bank) != read && Some(*bank) != ahead && !waits
        })
    }

    /// Another mode sets the power to 0; the same one changes only the values given with it.
    pub fn set_mode(&mut self, mode: laser::PowerMode, bounds: PowerBounds, delayed: bool) {
        if self.mode != mode {
            self.power = Power::ZERO;
        }
        (self.mode, self.bounds, self.delayed) = (mode, bounds, delayed);
    }

    /// Calls `young` with every entry number.
    pub(super) fn renew(&mut self, young: &mut impl FnMut(&mut u32)) {
        self.banks.iter_mut().chain([&mut self.cleared]).flatten().for_each(young);
    }

    pub(super) fn enter(&mut self, change: LaserChange, seq: u32) {
        match change {
            LaserChange::PowerOn { delayed, connector } => {
                // What paths and the tick still name stays named.
                let (banks, named) = (self.banks, self.named);
                *self = LaserShadow { cleared: Some(seq), banks, named, ..LaserShadow::power_on(delayed, connector) };
            }
            LaserChange::Mode { mode, bounds, delayed } => self.set_mode(mode, bounds, delayed),
            LaserChange::Power(power) => self.power = power,
            LaserChange::Carrier(carrier) => self.carrier = Some(carrier),
            LaserChange::Width(width_us) => self.width_us = width_us,
            LaserChange::Standby(standby, paired) => (self.standby, self.paired) = (standby, paired),
            LaserChange::Connector(laser) => self.connector = laser,
            LaserChange::Map(map) => self.map = map,
            LaserChange::Cleared => self.cleared = Some(seq),
            LaserChange::Distance(distance) => {
                self.distance = distance;
                let bank = distance.and_then(|distance| distance.from.bank());
                if let Some(slot) = bank.and_then(|bank| self.banks.get_mut(usize::from(bank))) {
                    *slot = Some(seq);
                }
            }
            LaserChange::TableFilled(table) => self.tables |= 1 << (table & 7),
        }
    }
}

/// What a laser tick command changes in the shadow state of its channel.
#[derive(Debug, Clone, Copy)]
pub enum LaserChange {
    /// Power-on state of a family.
    PowerOn { delayed: bool, connector: bool },
    /// LaserPowerMode.
    Mode { mode: laser::PowerMode, bounds: PowerBounds, delayed: bool },
    /// Direct power.
    Power(Power),
    /// Carrier.
    Carrier(Carrier),
    /// Pulse width, µs.
    Width(u16),
    /// Standby pulses: kHz and %; whether only while both channels are PWM.
    Standby(Option<(Power, Power)>, bool),
    /// What the axis connector carries.
    Connector(bool),
    /// Crd map.
    Map(u8),
    /// The fault is cleared.
    Cleared,
    /// Distance follow as a whole.
    Distance(Option<DistanceShadow>),
    /// A follow table is complete.
    TableFilled(u8),
}
