//! The servo tick with its lanes, and a machine that carries out its laser plans twice: pulse by
//! pulse, and as the boards do.
use super::player::{Player, settled};
use host_tests::laser_model::{Command, Edge, Exact, Family, Mode, Ns};
use plant::beam::{self, OutputStage};
use ring::{Latest, Producer, Reader, Ring};
use servo::laser::{
    self, CHANNELS, Carrier, ChannelChange, Clock, Delays, FixedTrain, LaserPlan, Power, PowerBounds, Standby,
};
use servo::port::{AxisInputs, GeneralInputs, GeneralOutputs, Port};
use servo::segment::pvt::{HeaderStore, PointStore, TABLES};
use servo::tables::TableStores;
use servo::tick::{IMMEDIATE_ENTRIES, SegmentStore, Tick, TickConfig, TickHalves};
use servo::tick_command::{LaneEntry, TickCommand};
use servo::units::{Axis, Pos, StepLimit};
use servo::view::{LaserView, View};
use std::num::NonZeroU16;

fn leak<T>(value: T) -> &'static mut T {
    Box::leak(Box::new(value))
}

struct Machine {
    now: Ns,
    next: Ns,
    interlock: bool,
    players: [Player; CHANNELS],
    stages: [OutputStage; CHANNELS],
    reported: [Vec<beam::SignalChange>; CHANNELS],
}

impl Machine {
    fn new(next: Ns) -> Machine {
        let stages = [const { OutputStage::new() }; CHANNELS];
        Machine { now: 0, next, interlock: false, players: Default::default(), stages, reported: Default::default() }
    }

    /// The interlock, which the boards' hardware sees without the tick.
    fn interlock(&mut self, active: bool) {
        if self.interlock != active {
            self.interlock = active;
            for (stage, reported) in self.stages.iter_mut().zip(&mut self.reported) {
                stage.interlock(self.now as u64, active, &mut |change| reported.push(change));
            }
        }
    }
}

impl Port for Machine {
    fn inputs(&mut self, _: Axis) -> AxisInputs {
        AxisInputs::default()
    }
    fn encoder(&mut self, _: Axis) -> i64 {
        0
    }
    fn general_inputs(&mut self) -> GeneralInputs {
        0
    }
    fn analog(&mut self, _: usize) -> i16 {
        0
    }
    fn set_point(&mut self, _: Axis, _: Pos) {}
    fn outputs(&mut self, _: u32, _: u64, _: u64, _: GeneralOutputs) {}
    fn analog_out(&mut self, _: u32, _: usize, _: i16) {}
    fn interlock(&mut self) -> bool {
        self.interlock
    }
    fn laser(&mut self, channel: usize, plan: &LaserPlan) {
        self.players[channel].take(self.now, self.next, plan);
        let reported = &mut self.reported[channel];
        self.stages[channel].take(self.now as u64, self.next as u64, plan, |change| reported.push(change));
    }
}

/// Edges of the outputs.
#[derive(Debug, PartialEq)]
pub struct Outputs {
    pub energy: Vec<Edge<bool>>,
    pub switch: Vec<Edge<bool>>,
    pub volts: Vec<Edge<i16>>,
}

/// What one channel did.
pub struct Recorded {
    pub outputs: Outputs,
    /// The same, as the boards' output stage reports it.
    pub stage: Outputs,
    /// The view at some of the ticks.
    pub views: Vec<(Ns, LaserView)>,
}

/// What the thread knows of a channel when it plans its light ahead.
#[derive(Clone, Copy)]
struct Known {
    family: Family,
    mode: laser::PowerMode,
    bounds: PowerBounds,
    direct: Power,
    carrier: Option<Carrier>,
    /// Whether it plans ahead at all: the tick must do without.
    plans: bool,
    /// The last plan, and how many there were: every third time it comes again, for other numbers
    /// perhaps.
    last: (Option<FixedTrain>, u32),
}

pub fn admitted(value: Exact) -> Power {
    Power::admit((*value.numer() as f64 / *value.denom() as f64).to_bits()).unwrap()
}

fn us(ns: Ns) -> u16 {
    u16::try_from(ns / 1000).unwrap()
}

impl Known {
    fn power_on(family: Family, plans: bool) -> Known {
        let bounds = PowerBounds::full(laser::PowerMode::Duty);
        Known {
            family,
            mode: laser::PowerMode::Duty,
            bounds,
            direct: Power::ZERO,
            carrier: None,
            plans,
            last: (None, 0),
        }
    }

    fn fixed(&mut self) -> Option<FixedTrain> {
        let power = self.bounds.hold(self.direct);
        let new = FixedTrain::plan(self.mode, power, self.carrier.as_ref(), Clock::GHZ).filter(|_| self.plans);
        let (last, count) = self.last;
        self.last = (new, count + 1);
        if count % 3 == 2 { last } else { new }
    }

    /// The change that a command is; a fault is none.
    fn change(&mut self, command: &Command) -> Option<ChannelChange> {
        Some(match *command {
            Command::Gate(on) => ChannelChange::Gate { on },
            Command::PowerMode { mode, max, min, delayed } => {
                let mode = match (mode, self.family) {
                    (Mode::Duty, _) | (Mode::Open, Family::Lsr) => laser::PowerMode::Duty,
                    (Mode::Frequency, _) => laser::PowerMode::Frequency,
                    (Mode::Analog, _) => laser::PowerMode::Analog,
                    (Mode::Open, Family::Gus) => laser::PowerMode::DutyOpen,
                };
                if mode != self.mode {
                    self.direct = Power::ZERO;
                }
                self.mode = mode;
                self.bounds = PowerBounds::admit(mode, admitted(max), admitted(min)).unwrap();
                let delayed = delayed || self.family == Family::Gus;
                ChannelChange::Mode { mode, bounds: self.bounds, delayed, fixed: self.fixed() }
            }
            Command::Power(power) => {
                self.direct = admitted(power);
                ChannelChange::Direct { power: self.direct, fixed: self.fixed() }
            }
            Command::Carrier(khz) => {
                let carrier = Carrier::admit(admitted(khz), Clock::GHZ).unwrap();
                self.carrier = Some(carrier);
                ChannelChange::Carrier { carrier, fixed: self.fixed() }
            }
            Command::Width(width) => ChannelChange::PulseWidth { us: NonZeroU16::new(us(width)).unwrap() },
            Command::Delays { off, on } => ChannelChange::Delays(Delays { off: us(off), on: us(on) }),
            Command::Fpk(fpk) => ChannelChange::Fpk(fpk.map(|fpk| laser::Fpk {
                pulse: NonZeroU16::new(us(fpk.time1)).unwrap(),
                begin: us(fpk.time2),
                end: us(fpk.off),
            })),
            Command::Standby(standby) => ChannelChange::Standby(
                standby.map(|(khz, duty)| Standby::admit(admitted(khz), admitted(duty), Clock::GHZ).unwrap()),
            ),
            Command::PreVoltage(volts) => ChannelChange::PreVoltage(volts.map(admitted)),
            Command::ZeroOnTime => ChannelChange::ZeroOnTime,
            Command::Connector(laser) => ChannelChange::Connector { laser },
            Command::Reset => {
                *self = Known::power_on(self.family, self.plans);
                let family = match self.family {
                    Family::Gus => laser::Family::Gus,
                    Family::Lsr => laser::Family::Lsr,
                };
                ChannelChange::Reset { family }
            }
            Command::Fault => return None,
            Command::Clear => ChannelChange::ClearFault,
        })
    }
}

pub struct Bench {
    tick: Tick<1>,
    lanes: TickHalves<'static, 1>,
    immediate: Producer<'static, LaneEntry, IMMEDIATE_ENTRIES>,
    view: Reader<'static, View<1>>,
}

impl Bench {
    pub fn new() -> Bench {
        let (immediate, immediate_out) = leak(Ring::new()).split();
        let (_, program) = leak(Ring::new()).split();
        let (events, _) = leak(Ring::new()).split();
        let (samples, _) = leak(Ring::new()).split();
        let (view_in, view) = leak(Latest::new(View::POWER_ON)).split();
        let places: Box<[PointStore]> = (0..TABLES).map(|_| PointStore::new()).collect();
        let places: Box<[PointStore; TABLES]> = places.try_into().ok().unwrap();
        let tables = TableStores {
            points: Box::leak(places),
            headers: leak(HeaderStore::new()),
            lasers: leak(servo::laser::PowerTables::new()),
            edges: leak(servo::EdgeCounts::new()),
        };
        let segments: &'static [SegmentStore; 1] = leak([const { SegmentStore::new() }; 1]);
        let lanes = TickHalves {
            immediate: immediate_out,
            program,
            view: view_in,
            events,
            samples,
            segments,
            tables,
            paths: servo::path::PathStores::NONE,
        };
        Bench { tick: Tick::new(config(0)), lanes, immediate, view }
    }

    fn power_on(&mut self, config: TickConfig) {
        self.tick = Tick::new(config);
        // The view's buffers are those of power-on too.
        for _ in 0..4 {
            *self.lanes.view.buffer() = View::POWER_ON;
            self.lanes.view.publish();
            self.view.read();
        }
    }

    /// Runs a job on each channel from power-on until `horizon`, which is a tick. Commands act at
    /// instants that are ticks; faults come after the other commands of their instant. `every`:
    /// ticks between views that are kept; `plans`: whether the thread plans trains ahead.
    pub fn run(
        &mut self,
        family: Family,
        jobs: [&[(Ns, Command)]; CHANNELS],
        period: Ns,
        horizon: Ns,
        every: Option<u32>,
        plans: bool,
    ) -> [Recorded; CHANNELS] {
        assert!(period > 0 && horizon % period == 0);
        self.power_on(config(period));
        let mut machine = Machine::new(0);
        let mut known = [Known::power_on(family, plans); CHANNELS];
        let mut jobs = jobs.map(|job| job.iter().peekable());
        for channel in 0..CHANNELS as u8 {
            self.begin(channel, family);
        }
        let mut views: [Vec<(Ns, LaserView)>; CHANNELS] = Default::default();
        let mut left = 0;
        while machine.now < horizon {
            machine.next = machine.now + period;
            machine.interlock(false);
            let mut fault = false;
            for (channel, job) in jobs.iter_mut().enumerate() {
                while let Some((at, command)) = job.next_if(|(at, _)| *at < machine.next) {
                    assert!(*command == Command::Fault && *at == machine.now, "{command:?} at {at} is not at a tick");
                    fault = true;
                }
                let is_due = |(at, command): &&(Ns, Command)| *at == machine.next && *command != Command::Fault;
                while let Some((_, command)) = job.next_if(is_due) {
                    let change = known[channel].change(command).unwrap();
                    self.now(channel as u8, change);
                    if *command == Command::Reset {
                        // The command of that name clears faults too.
                        self.now(channel as u8, ChannelChange::ClearFault);
                        self.begin(channel as u8, family);
                    }
                }
            }
            if fault {
                // What is no fault of the channel is over as soon as it is reported.
                match machine.now / period % 3 {
                    0 => machine.interlock(true),
                    1 => self.tick.overrun(),
                    _ => self.tick.restarted(),
                }
            }
            self.tick.run(&mut machine, &mut self.lanes);
            if let Some(every) = every {
                if left == 0 {
                    left = every;
                    let view = self.view.read();
                    for (kept, published) in views.iter_mut().zip(view.lasers) {
                        kept.push((machine.next, published));
                    }
                }
                left -= 1;
            }
            machine.now = machine.next;
        }
        let mut parts = views.into_iter().zip(machine.stages).zip(machine.reported);
        machine.players.map(|player| {
            let ((views, mut stage), mut reported) = parts.next().unwrap();
            stage.run_to(horizon as u64, &mut |change| reported.push(change));
            Recorded { outputs: player.finish(horizon), stage: listed(&reported, horizon), views }
        })
    }

    #[allow(dead_code, reason = "each test file uses its part")]
    /// What channel 0 shows after one tick of 50 µs from power-on with these changes.
    pub fn one_tick(&mut self, clock: Clock, changes: &[ChannelChange]) -> LaserView {
        self.power_on(TickConfig { laser_clock: clock, ..config(50_000) });
        self.now(0, ChannelChange::Connector { laser: true });
        for change in changes {
            self.now(0, *change);
        }
        let mut machine = Machine::new(50_000);
        self.tick.run(&mut machine, &mut self.lanes);
        self.view.read().lasers[0]
    }

    /// What a family fixes at power-on.
    fn begin(&mut self, channel: u8, family: Family) {
        self.now(channel, ChannelChange::Connector { laser: true });
        let (mode, delayed) = (laser::PowerMode::Duty, family == Family::Gus);
        self.now(channel, ChannelChange::Mode { mode, bounds: PowerBounds::full(mode), delayed, fixed: None });
    }

    fn now(&mut self, channel: u8, change: ChannelChange) {
        self.immediate
            .push(LaneEntry { seq: 0, delay: servo::units::Ns(0), command: TickCommand::Laser { channel, change } })
            .unwrap();
    }
}

/// What an output stage got, as lists of edges.
fn listed(reported: &[beam::SignalChange], horizon: Ns) -> Outputs {
    let (mut energy, mut switch, mut volts) = (Vec::new(), Vec::new(), Vec::new());
    for change in reported {
        match change {
            beam::SignalChange::Switch { at, level } => switch.push((*at as Ns, *level)),
            beam::SignalChange::Energy { at, level } => energy.push((*at as Ns, *level)),
            beam::SignalChange::Dac { at, code } => volts.push((*at as Ns, *code)),
            beam::SignalChange::Pulses(burst) => {
                for (begin, end) in burst.pulses().filter(|(begin, end)| begin < end) {
                    energy.extend([(begin as Ns, true), (end as Ns, false)]);
                }
            }
        }
    }
    energy.retain(|&(at, _)| at < horizon);
    Outputs { energy: settled(energy, false), switch: settled(switch, false), volts: settled(volts, 0) }
}

fn config(period: Ns) -> TickConfig {
    TickConfig {
        period_ns: period as u32,
        axes: 1,
        analog_inputs: 0,
        laser_clock: Clock::GHZ,
        step_limit: StepLimit::FULL_SCALE,
    }
}
