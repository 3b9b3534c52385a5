//! The machine of the emulated board: a plant that follows, inputs as they are set, recorded
//! outputs.
//!
//! In: set-points and outputs of the tick, inputs and a plan of them, bytes on the trace's UART.
//! Out: encoders of the plant; inputs as SimInput, SimAdc and the plan set them, low at power-on. A
//! byte `1` on the trace's UART makes the interlock active, `0` ends that: so it can be active
//! before the link is open. Owns the plant and the inputs. Outputs go to [`outputs`], and the
//! tick's view carries both over the link. Fails never.
use super::outputs;
use super::uart::Rx;
use plant::inputs::{InputPlan, InputRow};
use plant::{Gain, Plant};
use servo::laser::LaserPlan;
use servo::port::{AxisInputs, GeneralInputs, GeneralOutputs, InputTime, Port, Simulated};
use servo::segment::follow::Input;
use servo::units::{Axis, Ns, Pos};

/// Analog inputs.
pub const ANALOG_INPUTS: usize = 8;
/// Rows of a plan of inputs.
pub const ROWS: usize = 256;

/// The machine of `AXES` axes.
#[derive(Debug)]
pub struct Machine<const AXES: usize> {
    plant: Plant<AXES>,
    gain: Gain,
    period_ns: u32,
    switchboard: Rx,
    interlock: bool,
    inputs: [AxisInputs; AXES],
    general: GeneralInputs,
    analog: [i16; ANALOG_INPUTS],
    plan: InputPlan<[InputRow; ROWS]>,
}

impl<const AXES: usize> Machine<AXES> {
    /// At standstill at zero, with ticks of `period_ns`; `switchboard` receives the interlock.
    pub const fn new(period_ns: u32, switchboard: Rx) -> Self {
        Machine {
            plant: Plant::new(),
            gain: Gain::of_period(period_ns),
            period_ns,
            switchboard,
            interlock: false,
            inputs: [AxisInputs {
                limit_positive: false,
                limit_negative: false,
                alarm: false,
                home: false,
                arrive: false,
            }; AXES],
            general: 0,
            analog: [0; ANALOG_INPUTS],
            plan: InputPlan::new([InputRow::NONE; ROWS]),
        }
    }

    /// A tick begins: the shafts have moved since the last one. The ticks to come have `period_ns`.
    pub fn advance(&mut self, period_ns: u32) {
        self.plant.advance(self.gain);
        if period_ns != self.period_ns {
            self.period_ns = period_ns;
            self.gain = Gain::of_period(period_ns);
        }
    }

    /// The tick has been computed. The plant takes the steps, so there is nothing to output, and
    /// nothing is late.
    pub fn emit(&mut self) -> bool {
        true
    }
}

impl<const AXES: usize> Port for Machine<AXES> {
    fn inputs(&mut self, axis: Axis) -> AxisInputs {
        self.inputs.get(axis.index()).copied().unwrap_or_default()
    }

    fn encoder(&mut self, axis: Axis) -> i64 {
        self.plant.encoder(axis.index())
    }

    fn general_inputs(&mut self) -> GeneralInputs {
        self.general
    }

    fn analog(&mut self, channel: usize) -> i16 {
        self.analog.get(channel).copied().unwrap_or(0)
    }

    const SIMULATED: bool = true;

    fn simulate(&mut self, input: Simulated) {
        match input {
            Simulated::Level { input: Input::General, index, high } => {
                let bit = GeneralInputs::from(true) << (u32::from(index) & (GeneralInputs::BITS - 1));
                self.general = if high { self.general | bit } else { self.general & !bit };
            }
            Simulated::Level { input, index, high } => {
                if let Some(inputs) = self.inputs.get_mut(index as usize) {
                    inputs.set(input, high);
                }
            }
            Simulated::Interlock(active) => self.interlock = active,
            Simulated::Analog { channel, code } => {
                if let Some(value) = self.analog.get_mut(channel as usize) {
                    *value = code;
                }
            }
        }
    }

    fn plan(&mut self, row: u16, due: InputTime, input: Simulated) {
        self.plan.put(row, due, input);
    }

    fn planned(&mut self, next: Ns, zero: Option<Ns>) -> Option<Simulated> {
        self.plan.take(next, zero)
    }

    fn forget_plan(&mut self) {
        self.plan.forget();
    }

    fn set_point(&mut self, axis: Axis, pos: Pos) {
        self.plant.set_point(axis.index(), pos.0);
    }

    fn outputs(&mut self, _: u32, enable: u64, clear: u64, general: GeneralOutputs) {
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

    fn laser(&mut self, channel: usize, plan: &LaserPlan) {
        outputs::set_laser(channel, plan);
    }
}

const _: () = assert!(plant::FRAC_BITS == Pos::FRAC_BITS, "plant and servo count in the same unit");
