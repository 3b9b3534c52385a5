//! What the tick needs from a machine. `hal` and `host/virtual` implement it.
pub use crate::capacity::{GeneralInputs, GeneralOutputs};
use crate::laser::LaserPlan;
use crate::segment::follow::Input;
use crate::units::{Axis, AxisMask, Ns, Pos};

/// Levels of the digital inputs of one axis, sampled once a tick; true is the high level.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct AxisInputs {
    /// Positive limit switch.
    pub limit_positive: bool,
    /// Negative limit switch.
    pub limit_negative: bool,
    /// Drive alarm.
    pub alarm: bool,
    /// Home switch.
    pub home: bool,
    /// Drive reports arrival.
    pub arrive: bool,
}

impl AxisInputs {
    /// From [`AxisInputs::bits`].
    #[inline]
    pub const fn of_bits(bits: u8) -> AxisInputs {
        AxisInputs {
            limit_positive: bits & 1 != 0,
            limit_negative: bits & 2 != 0,
            alarm: bits & 4 != 0,
            home: bits & 8 != 0,
            arrive: bits & 16 != 0,
        }
    }

    /// The levels as bits, in the order of the fields from bit 0 on.
    #[inline]
    pub const fn bits(self) -> u8 {
        self.limit_positive as u8
            | (self.limit_negative as u8) << 1
            | (self.alarm as u8) << 2
            | (self.home as u8) << 3
            | (self.arrive as u8) << 4
    }
}

/// Axes that have these inputs on a board. An input that an axis lacks is never active.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WiredInputs {
    /// Positive limit switch.
    pub limit_positive: AxisMask,
    /// Negative limit switch.
    pub limit_negative: AxisMask,
    /// Drive alarm.
    pub alarm: AxisMask,
    /// Home switch.
    pub home: AxisMask,
    /// The drive's report of arrival.
    pub arrive: AxisMask,
}

impl WiredInputs {
    /// Each axis has each input.
    pub const ALL: WiredInputs = {
        let all = AxisMask(u64::MAX);
        WiredInputs { limit_positive: all, limit_negative: all, alarm: all, home: all, arrive: all }
    };
}

impl AxisInputs {
    /// One of them gets a level; those that are not of an axis stay.
    pub fn set(&mut self, input: Input, high: bool) {
        match input {
            Input::LimitPositive => self.limit_positive = high,
            Input::LimitNegative => self.limit_negative = high,
            Input::Alarm => self.alarm = high,
            Input::Home => self.home = high,
            Input::Arrive => self.arrive = high,
            Input::General => {}
        }
    }
}

/// An input of a machine that has no wires, as its user sets it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Simulated {
    /// The level at a terminal: of an axis over all cores, or of a general input, both from 0.
    Level {
        /// Which kind.
        input: Input,
        /// Its axis or number.
        index: u8,
        /// The high level.
        high: bool,
    },
    /// The interlock or emergency-stop input; high demands the safe state of every laser output.
    Interlock(bool),
    /// The code of an analog input from 0, as [`Port::analog`] returns it.
    Analog {
        /// Which.
        channel: u8,
        /// −32768…32767 for −12.5…12.5 V.
        code: i16,
    },
}

/// When a planned input changes: on the first tick after this.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InputTime {
    /// An instant of controller time.
    At(Ns),
    /// So long after the zero of the script clock of the next program.
    OfScript(Ns),
}

/// A machine, for the tick. No call may wait.
pub trait Port {
    /// Inputs of one axis now.
    fn inputs(&mut self, axis: Axis) -> AxisInputs;
    /// Encoder count of one axis now, in whole pulses since power-on.
    fn encoder(&mut self, axis: Axis) -> i64;
    /// Encoder count at the index edge that hardware latched since the tick before; of several, the
    /// last. Asked only of an axis that waits for one.
    fn index(&mut self, _: Axis) -> Option<i64> {
        None
    }
    /// General inputs now, bit 0 is GPI 1.
    fn general_inputs(&mut self) -> GeneralInputs;
    /// Analog input now, −32768…32767 is −12.5…12.5 V, from 0.
    fn analog(&mut self, channel: usize) -> i16;
    /// The set-point in force from the next tick on; the machine turns the whole pulses between two
    /// set-points into evenly spaced steps.
    fn set_point(&mut self, axis: Axis, pos: Pos);
    /// Servo-enable, alarm-clear and general outputs, from `at` ns after the next tick on. Called
    /// once a tick with 0; then with growing instants where entries of a path change outputs within
    /// the interval that the next tick begins.
    fn outputs(&mut self, at: u32, enable: u64, clear: u64, general: GeneralOutputs);
    /// Analog output, −32768…32767 is −10…10 V, from `at` ns after the next tick on, in the same
    /// order.
    fn analog_out(&mut self, at: u32, channel: usize, value: i16);
    /// Whether the interlock (or emergency-stop) input now demands every laser output in its safe
    /// state. The hardware forces PWM and switch there by itself; the tick latches it and does the
    /// same for the rest.
    fn interlock(&mut self) -> bool;
    /// Whether its inputs are set by [`Port::simulate`] and [`Port::plan`]. On a machine with wires
    /// the tick has no code for that.
    const SIMULATED: bool = false;
    /// An input has this from now on: the interrupt of the next tick samples it.
    fn simulate(&mut self, _: Simulated) {}
    /// Row `row` (from 0, in order) of a plan of inputs; row 0 begins another plan.
    fn plan(&mut self, _row: u16, _due: InputTime, _: Simulated) {}
    /// Takes the next row of the plan if it is due before `next`. `zero` is the script clock's
    /// zero, while a program runs.
    fn planned(&mut self, _next: Ns, _zero: Option<Ns>) -> Option<Simulated> {
        None
    }
    /// Rows that wait for a program are dropped: their session is over.
    fn forget_plan(&mut self) {}
    /// What a laser channel does in the interval that begins with the next tick and ends with the
    /// one after.
    fn laser(&mut self, channel: usize, plan: &LaserPlan);
}
