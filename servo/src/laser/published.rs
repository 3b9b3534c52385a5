//! What the tick publishes of a laser channel.
use super::{Carrier, Cause, Count, Curve, Ignored, Power, PowerBounds, PowerMode, SpeedSource, Train};
use crate::units::{Crd, CrdMask};

state! {
    /// One laser channel in one tick. Before the first tick every field is 0.
    #[derive(Debug, Clone, Copy)]
    pub struct LaserView {
        /// Counts changes of anything here but `on_time`.
        pub version: u32 = 0,
        /// Counts changes of anything but the power in light and the width of its pulses.
        pub settings_version: u32 = 0,
        /// Counts changes of anything but the outputs: the fields from `commanded` to `train`.
        pub state_version: u32 = 0,
        /// The command: on or off.
        pub commanded: bool = false,
        /// The gate, after its delays.
        pub gate: bool = false,
        /// The switch output.
        pub switch: bool = false,
        /// Light: the gate with the shifts of the FPK, whatever the power is.
        pub light: bool = false,
        /// The pulse width is limited to just under the period.
        pub limited: bool = false,
        /// Counts the changes of that in light: odd while it is so. It wraps.
        pub limits: u8 = 0,
        /// Direct power.
        pub direct: Power = Power::ZERO,
        /// What is being output, in the mode's unit: the power of the light, else standby or
        /// pre-voltage; 0 when nothing is.
        pub power: Power = Power::ZERO,
        /// Carrier or pulse rate that is being output, kHz, as it was requested; 0 when nothing is.
        pub khz: Power = Power::ZERO,
        /// The train of pulses being output, from which the achieved frequency and duty are read;
        /// none when nothing is.
        pub train: Train = Train::NONE,
        /// Power mode.
        pub mode: PowerMode = PowerMode::Duty,
        /// The connector of the energy output carries it.
        pub connector: bool = false,
        /// The gate's delays apply.
        pub delayed: bool = false,
        /// Why the channel is dark until it is cleared.
        pub fault: Cause = Cause::None,
        /// The cause of `fault` is still there.
        pub cause_lasts: bool = false,
        /// Mapped coordinate systems, bit 0 is crd 1.
        pub crd_map: u8 = 0,
        /// Those whose light of this channel is on, or would come back with their CrdStart.
        pub owners: CrdMask = CrdMask(0),
        /// Why the last admitted command without effect had none, and how many such there were.
        pub ignored: Ignored = Ignored::None,
        /// See `ignored`; wraps.
        pub ignored_count: u8 = 0,
        /// The coordinate system of a velocity follow.
        pub follows: Option<Crd> = None,
        /// Which of its speeds.
        pub source: SpeedSource = SpeedSource::Planned,
        /// The table of powers that it reads, if it does.
        pub table: Option<Curve> = None,
        /// The bank of ratios that a distance follow reads.
        pub bank: Option<u8> = None,
        /// Pulse width of the frequency mode, µs; 0 is none set.
        pub width_us: u16 = 0,
        /// Bounds of the power.
        pub bounds: PowerBounds = PowerBounds::ZERO,
        /// Carrier of the duty modes.
        pub carrier: Option<Carrier> = None,
        /// Light since power-on or the last ZeroOnTime, in 250 µs units, rounded down.
        pub on_time: u32 = 0,
    }
    pub(crate) const BEFORE;
}

impl LaserView {
    /// The same light has another power, and pulses of another width.
    #[inline(always)]
    pub(crate) fn take_power(&mut self, power: Power, width: Count) {
        (self.version, self.power, self.train.width) = (self.version.wrapping_add(1), power, width);
    }

    /// Becomes a copy of `now`; only what its counters mark as changed is copied.
    #[inline(always)]
    pub(crate) fn copy_changed(&mut self, now: &LaserView) {
        self.on_time = now.on_time;
        if self.version != now.version {
            if self.settings_version != now.settings_version {
                self.follow_moves(now);
            }
            (self.version, self.power, self.train.width) = (now.version, now.power, now.train.width);
        }
    }

    #[inline(never)]
    fn follow_moves(&mut self, now: &LaserView) {
        if self.state_version != now.state_version {
            *self = *now;
            return;
        }
        self.settings_version = now.settings_version;
        (self.commanded, self.gate, self.switch) = (now.commanded, now.gate, now.switch);
        (self.light, self.limited, self.owners) = (now.light, now.limited, now.owners);
        self.limits = now.limits;
        (self.direct, self.khz, self.train) = (now.direct, now.khz, now.train);
    }
}
