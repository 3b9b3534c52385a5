//! What the tick reads and drives on this board: inputs, servo enables and general outputs.
//!
//! In: set-points and outputs of the tick. Out: the levels of the pins, read together once a tick. Owns the tick's share of
//! [`pins`], [`super::steps`], [`super::encoders`], [`super::adc`], [`super::analog`] and [`laser`]. An axis without an encoder reads the pulse at
//! which its step output stands. Fails never.
use super::adc::Adc;
use super::analog::Analog;
use super::encoders::Encoders;
use super::laser::{self, Lasers};
use super::pins::{self, AXES, Levels};
use super::steps::Steps;
use servo::laser::Plan;
use servo::output::step_generator;
use servo::port::{AxisInputs, GeneralInputs, GeneralOutputs, Port};
use servo::units::{Axis, Pos};

/// The machine.
#[derive(Debug)]
pub struct Machine {
    levels: Levels,
    steps: Steps,
    encoders: Encoders,
    analog: Analog,
    adc: Adc,
    /// Pulses at which the outputs stand, and those of the set-points that the next tick puts in force.
    stands: [i64; AXES],
    goes_to: [i64; AXES],
    /// Servo enables and general outputs that are driven, and those that the next tick drives.
    driven: (u64, GeneralOutputs),
    drives: (u64, GeneralOutputs),
    /// General outputs that the tick behind that drives: they are as far behind the plan as the steps.
    comes: GeneralOutputs,
    lasers: Lasers,
    /// The board contradicts itself: as an interlock that stays open.
    is_blocked: bool,
}

impl Machine {
    /// At rest at zero.
    pub fn new(lasers: Lasers, analog: Analog, adc: Adc, is_blocked: bool) -> Machine {
        Machine {
            levels: Levels::LOW,
            steps: Steps::AT_REST,
            encoders: Encoders::AT_ZERO,
            analog,
            adc,
            lasers,
            is_blocked,
            stands: [0; AXES],
            goes_to: [0; AXES],
            driven: (0, 0),
            drives: (0, 0),
            comes: 0,
        }
    }

    /// A tick begins, which lasts so many ns: what was planned for it is in force.
    pub fn advance(&mut self, period_ns: u32) {
        self.steps.begin(period_ns);
        self.lasers.begin(period_ns);
        self.analog.advance();
        self.adc.advance();
        self.encoders.read();
        if self.driven != self.drives {
            self.driven = self.drives;
            pins::set(self.drives.0, self.drives.1);
        }
        self.drives.1 = self.comes;
        self.levels = Levels::read();
        for (axis, stands) in self.stands.iter_mut().enumerate() {
            *stands = self.steps.stands(axis);
        }
    }

    /// The tick has been computed: the steps of the next one go where DMA finds them. False if it took too long for that, or
    /// was too late for a laser.
    pub fn emit(&mut self) -> bool {
        self.steps.fill(&self.goes_to) & !self.lasers.was_late()
    }
}

impl Port for Machine {
    fn inputs(&mut self, axis: Axis) -> AxisInputs {
        let (levels, axis) = (&self.levels, axis.index());
        AxisInputs {
            limit_positive: levels.limit_positive(axis),
            limit_negative: levels.limit_negative(axis),
            alarm: levels.alarm(axis),
            home: levels.home(axis),
            arrive: false,
        }
    }

    fn encoder(&mut self, axis: Axis) -> i64 {
        let axis = axis.index();
        self.encoders.count(axis).or_else(|| self.stands.get(axis).copied()).unwrap_or(0)
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
        if let Some(place) = self.goes_to.get_mut(axis.index()) {
            *place = step_generator::whole(pos);
        }
    }

    fn outputs(&mut self, at: u32, enable: u64, _: u64, general: GeneralOutputs) {
        // What changes between two ticks is in what the tick behind it drives from its beginning. Enables do not wait for steps.
        if at == 0 {
            (self.drives.0, self.comes) = (enable, general);
        }
    }

    fn analog_out(&mut self, at: u32, channel: usize, value: i16) {
        self.analog.plan(at, channel, value);
    }

    fn interlock(&mut self) -> bool {
        // A break that is over again has rested the outputs too.
        laser::was_broken() | self.levels.interlock() | self.is_blocked
    }

    fn laser(&mut self, channel: usize, plan: &Plan) {
        self.analog.follow(channel, plan);
        self.lasers.plan(channel, plan);
    }
}
