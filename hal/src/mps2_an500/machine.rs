//! The machine behind the emulated board: a plant that follows, inputs at rest, recorded outputs.
//!
//! In: set-points and outputs of the tick, bytes on the trace's UART. Out: encoders of the plant and inputs that
//! nothing moves but the interlock: a byte `1` makes it active, `0` ends that.
//! Owns the plant; outputs go to [`outputs`], and the tick's view carries both over the link. Fails never.
use super::outputs;
use super::uart::Rx;
use plant::{Gain, Plant};
use servo::laser::Plan;
use servo::port::{AxisInputs, Port};
use servo::units::{Axis, Pos};

/// The machine of `AXES` axes.
#[derive(Debug)]
pub struct Machine<const AXES: usize> {
    plant: Plant<AXES>,
    gain: Gain,
    period_ns: u32,
    switchboard: Rx,
    interlock: bool,
}

impl<const AXES: usize> Machine<AXES> {
    /// At rest at zero, with ticks of `period_ns`; `switchboard` tells the inputs.
    pub const fn new(period_ns: u32, switchboard: Rx) -> Self {
        Machine { plant: Plant::new(), gain: Gain::of_period(period_ns), period_ns, switchboard, interlock: false }
    }

    /// A tick begins: the shafts have moved since the last one. The ticks to come have `period_ns`.
    pub fn advance(&mut self, period_ns: u32) {
        self.plant.advance(self.gain);
        if period_ns != self.period_ns {
            self.period_ns = period_ns;
            self.gain = Gain::of_period(period_ns);
        }
    }

    /// The tick has been computed. Steps are the plant's: nothing is to be output, and nothing comes too late.
    pub fn emit(&mut self) -> bool {
        true
    }
}

impl<const AXES: usize> Port for Machine<AXES> {
    fn inputs(&mut self, _: Axis) -> AxisInputs {
        // Nothing is wired: every input has its resting (low) level, at which power-on sense is inactive.
        AxisInputs::default()
    }

    fn encoder(&mut self, axis: Axis) -> i64 {
        self.plant.encoder(axis.index())
    }

    fn general_inputs(&mut self) -> u32 {
        0
    }

    fn analog(&mut self, _: usize) -> i16 {
        0
    }

    fn set_point(&mut self, axis: Axis, pos: Pos) {
        self.plant.set_point(axis.index(), pos.0);
    }

    fn outputs(&mut self, _: u32, enable: u64, clear: u64, general: u32) {
        outputs::set(enable, clear, general);
    }

    fn analog_out(&mut self, _: u32, channel: usize, value: i16) {
        outputs::set_analog(channel, value);
    }

    fn interlock(&mut self) -> bool {
        match self.switchboard.receive() {
            Some(b'1') => self.interlock = true,
            Some(b'0') => self.interlock = false,
            _ => {}
        }
        self.interlock
    }

    fn laser(&mut self, channel: usize, plan: &Plan) {
        outputs::set_laser(channel, plan);
    }
}

const _: () = assert!(plant::FRAC_BITS == Pos::FRAC_BITS, "plant and servo count in the same unit");
