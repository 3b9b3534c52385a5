//! What the tick reads and drives on this board: inputs, servo enables and general outputs.
//!
//! In: set-points and outputs of the tick. Out: the levels of the pins, read together once a tick.
//! Owns the tick's share of [`pins`], [`super::steps`], [`super::encoders`], [`super::adc`],
//! [`super::analog`] and [`laser`]. An axis without an encoder reads the pulse that its step output
//! has reached. Fails never.
use super::adc::Adc;
use super::analog::Analog;
use super::encoders::Encoders;
use super::laser::{self, Breaks, Lasers};
use super::pins::{self, AXES, PinLevels};
use super::steps::Steps;
use servo::laser::LaserPlan;
use servo::output::step_generator;
use servo::port::{AxisInputs, GeneralInputs, GeneralOutputs, Port};
use servo::units::{Axis, Pos};

/// The machine.
#[derive(Debug)]
pub struct Machine {
    levels: PinLevels,
    /// The inputs of axes among them, as [`AxisInputs::bits`]: unpacked when one changes.
    inputs: [u8; AXES],
    steps: Steps,
    encoders: Encoders,
    analog: Analog,
    adc: Adc,
    /// Pulses that the step outputs have reached, and those of the set-points of the next tick.
    reached: [i64; AXES],
    targets: [i64; AXES],
    /// Servo enables and general outputs that are driven, and those that the next tick drives.
    driven: (u64, GeneralOutputs),
    next: (u64, GeneralOutputs),
    /// General outputs of the tick after the next one: they are as late after the plan as the
    /// steps.
    after_next: GeneralOutputs,
    lasers: Lasers,
    /// The interlock's inputs.
    breaks: Breaks,
}

impl Machine {
    /// At standstill at zero. `is_blocked` is a board that contradicts its wiring.
    pub fn new(lasers: Lasers, analog: Analog, adc: Adc, is_blocked: bool) -> Machine {
        Machine {
            levels: PinLevels::LOW,
            inputs: PinLevels::LOW.axes(),
            steps: Steps::AT_REST,
            encoders: Encoders::AT_ZERO,
            analog,
            adc,
            lasers,
            breaks: Breaks::new(is_blocked),
            reached: [0; AXES],
            targets: [0; AXES],
            driven: (0, 0),
            next: (0, 0),
            after_next: 0,
        }
    }

    /// A tick of `period_ns` begins: the outputs planned for it come into force.
    pub fn advance(&mut self, period_ns: u32) {
        self.steps.begin(period_ns);
        self.lasers.begin(period_ns);
        self.analog.advance();
        self.adc.advance();
        self.encoders.read();
        if self.driven != self.next {
            self.driven = self.next;
            pins::set(self.next.0, self.next.1);
        }
        self.next.1 = self.after_next;
        let levels = PinLevels::read();
        if levels.differ(&self.levels) {
            self.inputs = levels.axes();
        }
        self.levels = levels;
        for (axis, reached) in self.reached.iter_mut().enumerate() {
            *reached = self.steps.reached(axis);
        }
    }

    /// The tick has been computed: writes the steps of the next one to the ring of DMA. False if
    /// the tick was too late for that, or for a laser.
    pub fn emit(&mut self) -> bool {
        self.steps.fill(&self.targets) & !self.lasers.was_late()
    }
}

impl Port for Machine {
    fn inputs(&mut self, axis: Axis) -> AxisInputs {
        AxisInputs::of_bits(self.inputs.get(axis.index()).copied().unwrap_or(0))
    }

    fn encoder(&mut self, axis: Axis) -> i64 {
        let axis = axis.index();
        self.encoders.count(axis).or_else(|| self.reached.get(axis).copied()).unwrap_or(0)
    }

    fn index(&mut self, axis: Axis) -> Option<i64> {
        self.encoders.index(axis.index())
    }

    fn general_inputs(&mut self) -> GeneralInputs {
        self.levels.general()
    }

    fn analog(&mut self, channel: usize) -> i16 {
        self.adc.code(channel)
    }

    fn set_point(&mut self, axis: Axis, pos: Pos) {
        if let Some(target) = self.targets.get_mut(axis.index()) {
            *target = step_generator::whole(pos);
        }
    }

    fn outputs(&mut self, at: u32, enable: u64, _: u64, general: GeneralOutputs) {
        // A change between two ticks comes with the tick after it. Enables do not wait for steps.
        if at == 0 {
            (self.next.0, self.after_next) = (enable, general);
        }
    }

    fn analog_out(&mut self, at: u32, channel: usize, value: i16) {
        self.analog.plan(at, channel, value);
    }

    fn interlock(&mut self) -> bool {
        self.breaks.is_open(self.levels.interlock(), laser::was_broken())
    }

    fn laser(&mut self, channel: usize, plan: &LaserPlan) {
        self.analog.follow(channel, plan);
        self.lasers.plan(channel, plan);
    }
}
