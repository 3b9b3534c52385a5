//! A tick whose machine carries out each `laser::LaserPlan` by the letter, with a timer of 1 GHz:
//! outputs are recorded to the ns.
use ring::{Latest, Producer, Reader, Ring};
use servo::laser::{
    Action, Buffered, CHANNELS, Carrier, ChannelChange, Clock, FINISH_NS, FixedTrain, LaserPlan, Pattern, Power,
    PowerBounds, PowerMode, PulseRate, Train,
};
use servo::path::axis_map::AxisMap;
use servo::path::{self, EntryStore, PathStores};
use servo::port::{AxisInputs, GeneralInputs, GeneralOutputs, Port};
use servo::segment::pvt::{HeaderStore, PointStore, TABLES};
use servo::tables::TableStores;
use servo::tick::{IMMEDIATE_ENTRIES, SegmentStore, Tick, TickConfig, TickHalves};
use servo::tick_command::{LaneEntry, TickCommand};
use servo::units::{Axis, Crd, CrdMask, Ns, Pos, StepLimit};
use servo::view::{LaserView, View};
use std::collections::VecDeque;

/// Axes of the machine; those of two coordinate systems at most.
pub const AXES: usize = 4;
pub const US: u64 = 1000;
pub const MS: u64 = 1_000_000;

/// The PWM of a channel.
#[derive(Default)]
struct Pwm {
    train: Train,
    pattern: Pattern,
    /// Of pulses that pause: the remainder of their period.
    paused: Option<u64>,
    /// A period in progress: its beginning, the end of its pulse, its end.
    period: Option<(u64, u64, u64)>,
    /// A last pulse in progress: its end, and what comes then.
    last: Option<(u64, Train)>,
    pulses: Vec<(u64, u64)>,
}

impl Pwm {
    fn begin(&mut self, train: Train, at: u64) {
        self.train = train;
        self.pattern = Pattern::BEGIN;
        (self.period, self.paused) = (None, None);
        if !train.is_none() {
            self.next(at);
        }
    }

    fn next(&mut self, at: u64) {
        let (period, width) = self.pattern.step(&self.train);
        self.period = Some((at, at + width, at + period));
        if width > 0 {
            self.pulses.push((at, at + width));
        }
    }

    /// What happens before `to`.
    fn advance(&mut self, to: u64) {
        loop {
            match (self.last, self.period) {
                (Some((end, train)), _) if end < to => {
                    self.last = None;
                    self.begin(train, end);
                }
                (None, Some((_, _, end))) if end < to => {
                    self.period = None;
                    if !self.train.is_none() {
                        self.next(end);
                    }
                }
                _ => return,
            }
        }
    }

    fn cut(&mut self, at: u64) {
        if let Some(pulse) = self.pulses.last_mut() {
            pulse.1 = pulse.1.min(at);
            if pulse.1 <= pulse.0 {
                self.pulses.pop();
            }
        }
        (self.period, self.last) = (None, None);
    }

    fn act(&mut self, at: u64, action: Action) {
        match action {
            Action::Light(train) => {
                self.cut(at);
                self.begin(train, at);
            }
            Action::Change(train) => {
                if let Some((_, then)) = &mut self.last {
                    *then = train;
                    return;
                }
                match &mut self.period {
                    Some((start, pulse, end)) if !train.is_none() => {
                        *end = (*end).min(at.max(*start + train.period.whole).max(*pulse));
                    }
                    None if !train.is_none() => {
                        self.period = Some((at, at, at));
                        self.pattern = Pattern::BEGIN;
                    }
                    _ => {}
                }
                self.train = train;
            }
            Action::Dark { standby, cut } => {
                let in_progress = self.period.map(|(_, pulse, _)| pulse).or(self.last.map(|(end, _)| end));
                match in_progress.filter(|end| *end > at) {
                    Some(end) if !cut && end - at <= FINISH_NS as u64 => {
                        self.period = None;
                        self.last = Some((end, standby));
                    }
                    _ => {
                        self.cut(at);
                        self.begin(standby, at);
                    }
                }
            }
            Action::Rate(rate) => self.rate(at, &rate),
            Action::Switch(_) | Action::Volts(_) => unreachable!(),
        }
    }

    fn rate(&mut self, at: u64, rate: &PulseRate) {
        // A paused period has its end beyond all time; its remainder is stored apart.
        let left = self.paused.or(self.period.map(|(_, _, end)| end - at)).unwrap_or(0);
        self.train = rate.train();
        if rate.is_pause() {
            if let Some((_, _, end)) = &mut self.period {
                (self.paused, *end) = (Some(left), u64::MAX);
            }
            return;
        }
        self.paused = None;
        let (left, part) = rate.left(left, self.pattern.part());
        self.pattern = Pattern::of_rate(part);
        let mut next = at + left;
        let (start, pulse, _) = self.period.unwrap_or((at, at, at));
        let (mut start, mut pulse) = (start, pulse);
        if pulse > at && pulse >= next {
            next = next.max(at + 1);
            pulse = next - 1;
            self.pulses.last_mut().unwrap().1 = pulse;
        }
        if self.period.is_none() {
            (start, pulse) = (at, at);
        }
        self.period = Some((start, pulse, next));
    }
}

/// The outputs of a channel.
#[derive(Default)]
pub struct Output {
    pwm: Pwm,
    queue: VecDeque<(u64, Action)>,
    switch: Vec<(u64, bool)>,
    volts: Vec<(u64, i16)>,
    /// Switch edges that were returned already.
    kept: usize,
    /// The most actions of a plan.
    pub most: usize,
    /// Beginning of the last interval in which there were any.
    pub last: u64,
    /// Since which tick every plan demands the safe state.
    pub rests: Option<u64>,
}

impl Output {
    fn carry_out(&mut self, before: u64) {
        while let Some((at, action)) = self.queue.front().copied()
            && at < before
        {
            self.queue.pop_front();
            match action {
                Action::Switch(level) => self.set_switch(at, level),
                Action::Volts(volts) => self.volts.push((at, volts)),
                _ => {
                    self.pwm.advance(at);
                    self.pwm.act(at, action);
                }
            }
        }
        self.pwm.advance(before);
    }

    /// Switch edges before an instant; they are forgotten but for the level.
    pub fn switch_until(&mut self, before: u64) -> Vec<(u64, bool)> {
        self.carry_out(before);
        self.pwm.pulses.clear();
        let edges = self.switch.split_off(self.kept);
        self.switch.extend(edges.last());
        self.switch.drain(..self.switch.len().saturating_sub(1));
        self.kept = self.switch.len();
        edges
    }

    fn set_switch(&mut self, at: u64, level: bool) {
        let before = self.switch.last().is_some_and(|edge| edge.1);
        assert_ne!(before, level, "an edge that is none, at {at}");
        self.switch.push((at, level));
    }

    fn take(&mut self, now: u64, next: u64, plan: &LaserPlan) {
        self.carry_out(now);
        self.most = self.most.max(plan.actions().len());
        if !plan.actions().is_empty() {
            self.last = next;
        }
        if plan.safe_state {
            assert!(plan.actions().is_empty());
            self.queue.clear();
            self.pwm.cut(now);
            self.pwm.train = Train::NONE;
            if self.switch.last().is_some_and(|edge| edge.1) {
                self.switch.push((now, false));
            }
            if self.volts.last().is_some_and(|volts| volts.1 != 0) {
                self.volts.push((now, 0));
            }
        }
        self.rests = plan.safe_state.then_some(self.rests.unwrap_or(now));
        let mut last = 0;
        for (offset, action) in plan.actions() {
            assert!(*offset >= last, "not in the order of time");
            last = *offset;
            self.queue.push_back((next + *offset as u64, *action));
        }
    }
}

pub struct Machine {
    now: u64,
    next: u64,
    pub interlock: bool,
    /// Levels and counts of the axes.
    pub inputs: [AxisInputs; AXES],
    pub encoders: [i64; AXES],
    pub outputs: [Output; CHANNELS],
    /// Plans are carried out; else only counted.
    pub runs: bool,
}

impl Port for Machine {
    fn inputs(&mut self, axis: Axis) -> AxisInputs {
        self.inputs[axis.index()]
    }
    fn encoder(&mut self, axis: Axis) -> i64 {
        self.encoders[axis.index()]
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
        if self.runs {
            self.outputs[channel].take(self.now, self.next, plan);
        }
    }
}

pub struct Bench {
    pub tick: Tick<AXES>,
    pub machine: Machine,
    lanes: TickHalves<'static, AXES>,
    immediate: Producer<'static, LaneEntry, IMMEDIATE_ENTRIES>,
    view: Reader<'static, View<AXES>>,
    seq: u32,
    /// As the thread knows them, for its plans.
    known: (PowerMode, Power, Option<Carrier>),
    clock: Clock,
    /// Whether the thread plans repetitions.
    pub fixed: bool,
    /// Entries of each FIFO.
    pushed: [[u32; 2]; 2],
}

pub fn axis(index: usize) -> Axis {
    Axis::new(index).unwrap()
}
pub fn crd(index: usize) -> Crd {
    Crd::new(index).unwrap()
}

/// An entry that changes channel 0.
pub fn buffered(change: Buffered) -> path::PathEntry {
    let (code, words) = change.pack();
    path::PathEntry::laser(0, code, words)
}
/// BufLaserOn, BufLaserOff.
pub fn light(on: bool) -> path::PathEntry {
    buffered(Buffered::Gate { on })
}
/// LnXY.
pub fn line(to: [i32; 2], vel: f64, acc: f64, end: f64) -> path::PathEntry {
    path::PathEntry::planar(to, path::MotionSpeeds::admit(vel.to_bits(), acc.to_bits(), end.to_bits()).unwrap())
}

fn leak<T>(value: T) -> &'static mut T {
    Box::leak(Box::new(value))
}

pub fn power(value: f64) -> Power {
    Power::admit(value.to_bits()).unwrap()
}

pub fn bounds(mode: PowerMode, max: f64, min: f64) -> PowerBounds {
    PowerBounds::admit(mode, power(max), power(min)).unwrap()
}

impl Bench {
    pub fn new(period_us: u32) -> Bench {
        Bench::with_clock(period_us, Clock::GHZ)
    }

    /// With another clock; its plans are checked, not carried out.
    pub fn with_clock(period_us: u32, clock: Clock) -> Bench {
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
        let segments: &'static [SegmentStore; AXES] = leak([const { SegmentStore::new() }; AXES]);
        let config = TickConfig {
            period_ns: period_us * 1000,
            axes: AXES as u8,
            analog_inputs: 0,
            laser_clock: clock,
            step_limit: StepLimit::FULL_SCALE,
        };
        let machine = Machine {
            now: 0,
            next: 0,
            interlock: false,
            inputs: Default::default(),
            encoders: [0; AXES],
            outputs: Default::default(),
            runs: clock == Clock::GHZ,
        };
        let paths: Box<[[EntryStore; 2]; 2]> = Box::new([const { [const { EntryStore::new() }; 2] }; 2]);
        let lanes = TickHalves {
            immediate: immediate_out,
            program,
            view: view_in,
            events,
            samples,
            segments,
            tables,
            paths: PathStores::of(Box::leak(paths)),
        };
        let known = (PowerMode::Duty, Power::ZERO, None);
        Bench {
            tick: Tick::new(config),
            machine,
            lanes,
            immediate,
            view,
            seq: 0,
            known,
            clock,
            fixed: true,
            pushed: [[0; 2]; 2],
        }
    }

    pub fn command(&mut self, command: TickCommand) {
        self.seq += 1;
        self.immediate.push(LaneEntry { seq: self.seq, delay: Ns(0), command }).unwrap();
    }

    /// A change of channel 0.
    pub fn change(&mut self, change: ChannelChange) {
        self.command(TickCommand::Laser { channel: 0, change });
    }

    pub fn gate(&mut self, on: bool) {
        self.change(ChannelChange::Gate { on });
    }

    fn plan(&self) -> Option<FixedTrain> {
        let (mode, power, carrier) = self.known;
        if self.fixed { FixedTrain::plan(mode, power, carrier.as_ref(), self.clock) } else { None }
    }

    pub fn mode(&mut self, mode: PowerMode, max: f64, min: f64, delayed: bool) {
        if mode != self.known.0 {
            self.known.1 = power(min);
        }
        self.known.0 = mode;
        self.change(ChannelChange::Mode { mode, bounds: bounds(mode, max, min), delayed, fixed: self.plan() });
    }

    pub fn direct(&mut self, value: f64) {
        self.known.1 = power(value);
        self.change(ChannelChange::Direct { power: power(value), fixed: self.plan() });
    }

    pub fn carrier(&mut self, khz: f64) {
        let carrier = Carrier::admit(power(khz), self.clock).unwrap();
        self.known.2 = Some(carrier);
        self.change(ChannelChange::Carrier { carrier, fixed: self.plan() });
    }

    pub fn width(&mut self, us: u16) {
        self.change(ChannelChange::PulseWidth { us: us.try_into().unwrap() });
    }

    pub fn delays(&mut self, off: u16, on: u16) {
        self.change(ChannelChange::Delays(servo::laser::Delays { off, on }));
    }

    pub fn fpk(&mut self, times: Option<(u16, u16, u16)>) {
        self.change(ChannelChange::Fpk(times.map(|(pulse, begin, end)| servo::laser::Fpk {
            pulse: pulse.try_into().unwrap(),
            begin,
            end,
        })));
    }

    pub fn standby(&mut self, pulses: Option<(f64, f64)>) {
        self.change(ChannelChange::Standby(
            pulses.map(|(khz, duty)| servo::laser::Standby::admit(power(khz), power(duty), Clock::GHZ).unwrap()),
        ));
    }

    pub fn tick(&mut self) -> LaserView {
        self.tick_unread();
        self.view.read().lasers[0]
    }

    /// SetCrdPrm of a coordinate system on these axes.
    pub fn frame(&mut self, index: usize, axes: &[usize]) {
        let mut mapped = [None; 4];
        for (place, index) in mapped.iter_mut().zip(axes) {
            *place = Some(axis(*index));
        }
        self.command(TickCommand::CrdFrame { crd: crd(index), frame: AxisMap::admit(mapped, None, 0).unwrap() });
        self.tick();
    }

    /// Entries of FIFO 0.
    pub fn path(&mut self, index: usize, entries: &[path::PathEntry]) {
        let count = &mut self.pushed[index][0];
        for entry in entries {
            self.lanes.paths.get(index).unwrap()[0].write(*count, *entry);
            *count += 1;
        }
        let cleared = self.view.read().crds[index].cleared[0];
        let end = *count;
        self.command(TickCommand::CrdCommit { crd: crd(index), fifo: 0, end, cleared });
    }

    /// CrdClear of FIFO 0.
    pub fn clear_path(&mut self, index: usize) {
        self.command(TickCommand::CrdClear { crd: crd(index), fifo: 0 });
        self.pushed[index][0] = 0;
    }

    /// CrdStart; returns the instant at which its motion begins.
    pub fn start(&mut self, crds: u8) -> u64 {
        self.command(TickCommand::CrdStart { crds: CrdMask(crds), fifo1: CrdMask(0) });
        self.tick.now().0 + self.tick.period().0
    }

    /// CrdStop.
    pub fn stop(&mut self, crds: u8, abrupt: bool) {
        let crds = CrdMask(crds);
        self.command(TickCommand::stop_crds(crds, if abrupt { crds } else { CrdMask(0) }));
    }

    pub fn view(&mut self) -> View<AXES> {
        *self.view.read()
    }

    pub fn tick_unread(&mut self) {
        self.machine.now = self.tick.now().0;
        self.machine.next = self.machine.now + self.tick.period().0;
        self.tick.run(&mut self.machine, &mut self.lanes);
    }

    /// Ticks until the tick in force is that of `ns`.
    pub fn until(&mut self, ns: u64) -> LaserView {
        assert!(self.tick.now().0 < ns, "{ns} is past");
        loop {
            let view = self.tick();
            assert!(self.tick.now().0 <= ns, "{ns} ns is not a tick");
            if self.tick.now().0 == ns {
                return view;
            }
        }
    }

    /// Ticks until that instant is reached or past.
    pub fn until_ms(&mut self, ms: u64) {
        while self.tick.now().0 < ms * MS {
            self.tick();
        }
    }

    /// Pulses of channel 0 so far, those that touch as one.
    pub fn pulses(&mut self) -> Vec<(u64, u64)> {
        let output = &mut self.machine.outputs[0];
        output.carry_out(self.tick.now().0);
        let mut joined: Vec<(u64, u64)> = vec![];
        for pulse in &output.pwm.pulses {
            match joined.last_mut() {
                Some(last) if last.1 == pulse.0 => last.1 = pulse.1,
                _ => joined.push(*pulse),
            }
        }
        joined
    }

    /// Switch edges of channel 0 so far.
    pub fn switch(&mut self) -> Vec<(u64, bool)> {
        let output = &mut self.machine.outputs[0];
        output.carry_out(self.tick.now().0);
        output.switch.clone()
    }

    /// DAC changes of channel 0 so far.
    pub fn volts(&mut self) -> Vec<(u64, i16)> {
        let output = &mut self.machine.outputs[0];
        output.carry_out(self.tick.now().0);
        output.volts.clone()
    }

    /// Forgets what was output.
    pub fn forget(&mut self) {
        let output = &mut self.machine.outputs[0];
        output.carry_out(self.tick.now().0);
        let (level, volts) = (output.switch.last().copied(), output.volts.last().copied());
        (output.switch, output.volts) = (level.into_iter().collect(), volts.into_iter().collect());
        output.pwm.pulses.clear();
    }
}
