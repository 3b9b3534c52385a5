//! What the tick publishes of a laser channel.
use super::{Bounds, Carrier, Cause, Count, Curve, Ignored, Mode, Power, Source, Train};
use crate::units::{Crd, CrdMask};

/// One laser channel in one tick. Before the first tick every field is 0.
#[derive(Debug, Clone, Copy)]
pub struct LaserView {
    /// Counts changes of anything here but `on_time`.
    pub moves: u32,
    /// Counts changes of anything but the power in light and the width of its pulses.
    pub turns: u32,
    /// Counts changes of anything but the outputs: the fields from `commanded` to `train`.
    pub changes: u32,
    /// The command: on or off.
    pub commanded: bool,
    /// The gate, after its delays.
    pub gate: bool,
    /// The switch output.
    pub switch: bool,
    /// Light: the gate with the shifts of the FPK, whatever the power is.
    pub light: bool,
    /// The pulse width is limited to just under the period.
    pub limited: bool,
    /// Counts the changes of that in light: odd while it is so. It wraps.
    pub limits: u8,
    /// Direct power.
    pub direct: Power,
    /// What is being output, in the mode's unit: the power of the light, else standby or
    /// pre-voltage; 0 when nothing is.
    pub power: Power,
    /// Carrier or pulse rate that is being output, kHz, as it was requested; 0 when nothing is.
    pub khz: Power,
    /// The train of pulses being output, from which the achieved frequency and duty are read; none
    /// when nothing is.
    pub train: Train,
    /// Power mode.
    pub mode: Mode,
    /// The connector of the energy output carries it.
    pub connector: bool,
    /// The gate's delays apply.
    pub delayed: bool,
    /// Why the channel is dark until it is cleared.
    pub fault: Cause,
    /// The cause of `fault` is still there.
    pub cause_lasts: bool,
    /// Mapped coordinate systems, bit 0 is crd 1.
    pub crd_map: u8,
    /// Those whose light of this channel is on, or would come back with their CrdStart.
    pub owners: CrdMask,
    /// Why the last admitted command without effect had none, and how many such there were.
    pub ignored: Ignored,
    /// See `ignored`; wraps.
    pub ignored_count: u8,
    /// The coordinate system of a velocity follow.
    pub follows: Option<Crd>,
    /// Which of its speeds.
    pub source: Source,
    /// The table of powers that it reads, if it does.
    pub table: Option<Curve>,
    /// The bank of ratios that a distance follow reads.
    pub bank: Option<u8>,
    /// Pulse width of the frequency mode, µs; 0 is none set.
    pub width_us: u16,
    /// Bounds of the power.
    pub bounds: Bounds,
    /// Carrier of the duty modes.
    pub carrier: Option<Carrier>,
    /// Light since power-on or the last ZeroOnTime, in 250 µs units, rounded down.
    pub on_time: u32,
}

impl LaserView {
    pub(crate) const BEFORE: LaserView = LaserView {
        moves: 0,
        turns: 0,
        changes: 0,
        mode: Mode::Duty,
        commanded: false,
        gate: false,
        switch: false,
        light: false,
        limited: false,
        limits: 0,
        connector: false,
        delayed: false,
        fault: Cause::None,
        cause_lasts: false,
        crd_map: 0,
        owners: CrdMask(0),
        ignored: Ignored::None,
        ignored_count: 0,
        follows: None,
        source: Source::Planned,
        table: None,
        bank: None,
        width_us: 0,
        bounds: Bounds::ZERO,
        direct: Power::ZERO,
        carrier: None,
        power: Power::ZERO,
        khz: Power::ZERO,
        train: Train::NONE,
        on_time: 0,
    };

    /// The same light has another power, and pulses of another width.
    #[inline(always)]
    pub(crate) fn take_power(&mut self, power: Power, width: Count) {
        (self.moves, self.power, self.train.width) = (self.moves.wrapping_add(1), power, width);
    }

    /// Becomes a copy of `now`; only what its counters mark as changed is copied.
    #[inline(always)]
    pub(crate) fn follow(&mut self, now: &LaserView) {
        self.on_time = now.on_time;
        if self.moves != now.moves {
            if self.turns != now.turns {
                self.follow_moves(now);
            }
            (self.moves, self.power, self.train.width) = (now.moves, now.power, now.train.width);
        }
    }

    #[inline(never)]
    fn follow_moves(&mut self, now: &LaserView) {
        if self.changes != now.changes {
            *self = *now;
            return;
        }
        self.turns = now.turns;
        (self.commanded, self.gate, self.switch) = (now.commanded, now.gate, now.switch);
        (self.light, self.limited, self.owners) = (now.light, now.limited, now.owners);
        self.limits = now.limits;
        (self.direct, self.khz, self.train) = (now.direct, now.khz, now.train);
    }
}
