//! The machine of the tick: inputs that a test sets, encoders of the plant, outputs and their
//! edges, the lasers' output stages.
use plant::beam::{ChannelLevels, OutputStage, SignalChange};
use plant::inputs::{InputPlan, InputRow};
use plant::{Gain, Plant};
use servo::laser::{Action, CHANNELS, LaserPlan};
use servo::port::{AxisInputs, GeneralInputs, GeneralOutputs, InputTime, Port, Simulated};
use servo::segment::follow::Input;
use servo::units::{Axis, Ns, Pos};

/// Rows that a plan of inputs holds.
pub const PLANNED_INPUTS: u16 = u16::MAX;

/// Input levels, set from outside; true is the high level. All are low at power-on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Inputs {
    /// Inputs of each axis, from 0 over all cores.
    pub axes: Vec<AxisInputs>,
    /// General inputs, bit 0 is GPI 1.
    pub general: GeneralInputs,
    /// Analog inputs as SetDac counts.
    pub analog: [i16; 8],
    /// Interlock (or emergency stop); high asks for the safe state of every laser.
    pub interlock: bool,
}

/// Output levels in force from the next tick on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Outputs {
    /// Servo enable, a bit an axis over all cores.
    pub enable: u64,
    /// Alarm clear, a bit an axis.
    pub clear: u64,
    /// General outputs.
    pub general: GeneralOutputs,
    /// Analog outputs.
    pub analog: [i16; 8],
}

/// Which output an edge is of; numbers from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Output {
    /// Servo enable of an axis.
    Enable(u8),
    /// Alarm clear of an axis.
    Clear(u8),
    /// General output.
    General(u8),
}

/// A digital output that changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Edge {
    /// Controller time in ns.
    pub at_ns: u64,
    /// Which one.
    pub output: Output,
    /// Its level from then on.
    pub level: bool,
}

/// What a laser's outputs did, at instants of controller time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Beam {
    /// Which channel, from 0.
    pub channel: u8,
    /// What.
    pub change: SignalChange,
}

fn note_beam(beam: &mut Option<Vec<Beam>>, channel: usize) -> impl FnMut(SignalChange) {
    move |change| {
        if let Some(beam) = beam {
            beam.push(Beam { channel: channel as u8, change });
        }
    }
}

/// Edges that are kept until they are read; the oldest are dropped first.
const KEPT_EDGES: usize = 1 << 20;

/// See the module text.
pub(crate) struct Machine<const AXES: usize> {
    plant: Plant<AXES>,
    gain: Gain,
    gain_ns: u64,
    /// Instant from which the outputs given in this tick are in force.
    next_ns: u64,
    /// Instant of the tick in force.
    now_ns: u64,
    pub inputs: Inputs,
    /// What sets them by itself.
    plan: InputPlan<Vec<InputRow>>,
    pub outputs: Outputs,
    pub edges: std::collections::VecDeque<Edge>,
    stages: [OutputStage; CHANNELS],
    /// The first analog outputs carry a voltage that a laser has set.
    is_lasers: [bool; CHANNELS],
    /// The interlock as the lasers' hardware has it.
    interlock: bool,
    /// Instant at which the interlock input becomes active; it may be between two ticks.
    raised_ns: Option<u64>,
    /// Of an axis that waits for an index edge: its encoder count, and the next tick.
    index_asked: Vec<(u64, i64)>,
    /// Changes of the lasers' outputs, if they are recorded.
    beam: Option<Vec<Beam>>,
}

impl<const AXES: usize> Machine<AXES> {
    pub fn new() -> Self {
        Machine {
            plant: Plant::new(),
            gain: Gain::of_period(0),
            gain_ns: 0,
            next_ns: 0,
            now_ns: 0,
            inputs: Inputs { axes: vec![AxisInputs::default(); AXES], general: 0, analog: [0; 8], interlock: false },
            plan: InputPlan::new(Vec::new()),
            outputs: Outputs::default(),
            edges: std::collections::VecDeque::new(),
            stages: [const { OutputStage::new() }; CHANNELS],
            is_lasers: [false; CHANNELS],
            interlock: false,
            raised_ns: None,
            index_asked: vec![(0, 0); AXES],
            beam: None,
        }
    }

    /// Whether what the lasers do is kept from now on.
    pub fn record_beam(&mut self, on: bool) {
        self.beam = on.then(Vec::new);
    }

    /// What the lasers did before `now`, in the order of time for each output.
    pub fn take_beam(&mut self, now: u64) -> Vec<Beam> {
        self.follow_beam(now);
        self.beam.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// Levels of a laser's outputs before `now`.
    pub fn laser(&mut self, channel: usize, now: u64) -> ChannelLevels {
        self.follow_beam(now);
        self.stages.get(channel).map(OutputStage::levels).unwrap_or_default()
    }

    /// The interlock input becomes active at `at`, which is not before the tick in force.
    pub fn raise_interlock(&mut self, at: u64) {
        self.raised_ns = Some(self.raised_ns.map_or(at, |raised| raised.min(at)));
    }

    /// The lasers' hardware sees the interlock input up to `now`: not only at ticks, as the tick
    /// does.
    fn see_interlock(&mut self, now: u64) {
        let raised = self.raised_ns.take_if(|at| *at <= now);
        self.inputs.interlock |= raised.is_some();
        if self.interlock != self.inputs.interlock {
            self.interlock = self.inputs.interlock;
            for (channel, stage) in self.stages.iter_mut().enumerate() {
                let at = raised.unwrap_or(now);
                stage.interlock(at, self.interlock, &mut note_beam(&mut self.beam, channel));
            }
        }
    }

    fn follow_beam(&mut self, now: u64) {
        self.see_interlock(now);
        for (channel, stage) in self.stages.iter_mut().enumerate() {
            stage.run_to(now, &mut note_beam(&mut self.beam, channel));
        }
    }

    /// A tick begins: `period_ns` have passed since the one before; what it gives is in force at
    /// `next_ns`.
    pub fn begin(&mut self, period_ns: u64, next_ns: u64) {
        if self.gain_ns != period_ns {
            self.gain_ns = period_ns;
            self.gain = Gain::of_period(u32::try_from(period_ns).unwrap_or(u32::MAX));
        }
        self.plant.advance(self.gain);
        self.next_ns = next_ns;
        self.now_ns = next_ns.saturating_sub(period_ns);
        self.see_interlock(self.now_ns);
    }

    /// The set-point of an axis in force from the next tick on, in 2⁻²² pulse.
    pub fn set_point_of(&self, axis: usize) -> i64 {
        self.plant.set_point_of(axis)
    }

    /// The encoder count of an axis.
    pub fn encoder_of(&self, axis: usize) -> i64 {
        self.plant.encoder(axis)
    }

    fn note(&mut self, at_ns: u64, before: u64, after: u64, output: fn(u8) -> Output) {
        let mut changed = before ^ after;
        while changed != 0 {
            let bit = changed.trailing_zeros() as u8;
            changed &= changed - 1;
            if self.edges.len() == KEPT_EDGES {
                self.edges.pop_front();
            }
            self.edges.push_back(Edge { at_ns, output: output(bit), level: after >> bit & 1 == 1 });
        }
    }
}

impl<const AXES: usize> Port for Machine<AXES> {
    fn inputs(&mut self, axis: Axis) -> AxisInputs {
        self.inputs.axes.get(axis.index()).copied().unwrap_or_default()
    }

    fn encoder(&mut self, axis: Axis) -> i64 {
        self.plant.encoder(axis.index())
    }

    /// An edge counts from the tick after the one that armed the capture.
    fn index(&mut self, axis: Axis) -> Option<i64> {
        let count = self.plant.encoder(axis.index());
        let asked = self.index_asked.get_mut(axis.index())?;
        let (tick, before) = std::mem::replace(asked, (self.next_ns, count));
        if tick == self.now_ns { plant::index_edge(before, count) } else { None }
    }

    fn general_inputs(&mut self) -> GeneralInputs {
        self.inputs.general
    }

    fn analog(&mut self, channel: usize) -> i16 {
        self.inputs.analog.get(channel).copied().unwrap_or(0)
    }

    fn set_point(&mut self, axis: Axis, pos: Pos) {
        self.plant.set_point(axis.index(), pos.0);
    }

    fn outputs(&mut self, at: u32, enable: u64, clear: u64, general: GeneralOutputs) {
        let before = self.outputs;
        if (before.enable, before.clear, before.general) != (enable, clear, general) {
            let at_ns = self.next_ns + u64::from(at);
            self.note(at_ns, before.enable, enable, Output::Enable);
            self.note(at_ns, before.clear, clear, Output::Clear);
            self.note(at_ns, before.general, general, Output::General);
            self.outputs = Outputs { enable, clear, general, ..before };
        }
    }

    fn analog_out(&mut self, _: u32, channel: usize, value: i16) {
        if let Some(place) = self.outputs.analog.get_mut(channel) {
            *place = value;
        }
        if let Some(is_lasers) = self.is_lasers.get_mut(channel) {
            *is_lasers = false;
        }
    }

    const SIMULATED: bool = true;

    fn simulate(&mut self, input: Simulated) {
        let Inputs { axes, general, analog, interlock } = &mut self.inputs;
        match input {
            Simulated::Level { input: Input::General, index, high } => {
                let bit = 1 << (u32::from(index) & (GeneralInputs::BITS - 1));
                *general = if high { *general | bit } else { *general & !bit };
            }
            Simulated::Level { input, index, high } => {
                if let Some(inputs) = axes.get_mut(usize::from(index)) {
                    inputs.set(input, high);
                }
            }
            // The lasers' hardware sees it when the next tick begins: `see_interlock`.
            Simulated::Interlock(active) => *interlock = active,
            Simulated::Analog { channel, code } => {
                if let Some(place) = analog.get_mut(usize::from(channel)) {
                    *place = code;
                }
            }
        }
    }

    fn plan(&mut self, row: u16, due: InputTime, input: Simulated) {
        let slots = self.plan.slots();
        if slots.len() <= usize::from(row) {
            slots.resize(usize::from(row) + 1, InputRow::NONE);
        }
        self.plan.put(row, due, input);
    }

    fn planned(&mut self, next: Ns, zero: Option<Ns>) -> Option<Simulated> {
        self.plan.take(next, zero)
    }

    fn forget_plan(&mut self) {
        self.plan.forget();
    }

    fn interlock(&mut self) -> bool {
        self.interlock
    }

    fn laser(&mut self, channel: usize, plan: &LaserPlan) {
        if let Some(stage) = self.stages.get_mut(channel) {
            stage.take(self.now_ns, self.next_ns, plan, note_beam(&mut self.beam, channel));
        }
        // An analog output is one pin: what was written last is output.
        let volts = |action: &(u32, Action)| if let Action::Volts(code) = action.1 { Some(code) } else { None };
        let rests = plan.safe_state && self.is_lasers[channel & 1];
        for code in rests.then_some(0).into_iter().chain(plan.actions().iter().filter_map(volts)) {
            self.outputs.analog[channel & 1] = code;
            self.is_lasers[channel & 1] = code != 0;
        }
    }
}
