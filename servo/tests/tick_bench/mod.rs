//! A tick on a bench: rings, a machine whose encoders follow at once, and functions that push
//! tick commands.
use ring::{Consumer, Latest, Producer, Reader, Ring};
use servo::laser::{Clock, LaserPlan};
use servo::output::step_generator;
use servo::path::axis_map::AxisMap;
use servo::path::{self, EntryStore, PathStores};
use servo::port::{AxisInputs, GeneralInputs, GeneralOutputs, Port};
use servo::segment::follow;
use servo::segment::piece::Scaled;
use servo::segment::pt::{Chain, Segment};
use servo::segment::pvt::{Header, HeaderStore, Point, PointStore, TABLES};
use servo::segment::ramp::{Accel, Speed};
use servo::tables::TableStores;
use servo::tick::{
    EVENTS, IMMEDIATE_ENTRIES, PROGRAM_ENTRIES, SegmentStore, TRACE_SAMPLES, Tick, TickConfig, TickHalves,
};
use servo::tick_command::{DoGroup, LaneEntry, MotionMode, TickCommand};
use servo::units::{Axis, AxisMask, Crd, CrdMask, Exact, Ns, Pos, StepLimit};
use servo::view::{AxisView, Event, Sample, StopReason, View};

pub const AXES: usize = 8;
pub const MS: u64 = 1_000_000;

/// The machine. The encoder is the whole pulse of the last set-point, plus `slip`.
pub struct Machine {
    pub inputs: [AxisInputs; AXES],
    pub set_points: [Pos; AXES],
    pub slip: [i64; AXES],
    /// Counts at index edges of the tick that begins.
    pub index: [Option<i64>; AXES],
    pub outputs: (u64, u64, GeneralOutputs),
    pub analog_out: [i16; 8],
    pub general: GeneralInputs,
    /// Digital outputs inside an interval: its tick, ns after it, levels.
    pub edges: Vec<(u32, u64, u64, GeneralOutputs)>,
    pub analog_edges: Vec<(u32, usize, i16)>,
    /// The interlock is open.
    pub interlock: bool,
    /// Levels of general outputs in the order in which they came.
    pub levels: Vec<GeneralOutputs>,
}

impl Port for Machine {
    fn inputs(&mut self, axis: Axis) -> AxisInputs {
        self.inputs[axis.index()]
    }
    fn encoder(&mut self, axis: Axis) -> i64 {
        step_generator::whole(self.set_points[axis.index()]) + self.slip[axis.index()]
    }
    fn index(&mut self, axis: Axis) -> Option<i64> {
        self.index[axis.index()].take()
    }
    fn general_inputs(&mut self) -> GeneralInputs {
        self.general
    }
    fn analog(&mut self, channel: usize) -> i16 {
        100 + channel as i16
    }
    fn set_point(&mut self, axis: Axis, pos: Pos) {
        self.set_points[axis.index()] = pos;
    }
    fn outputs(&mut self, at: u32, enable: u64, clear: u64, general: GeneralOutputs) {
        if at != 0 {
            self.edges.push((at, enable, clear, general));
        }
        if self.levels.last() != Some(&general) {
            self.levels.push(general);
        }
        self.outputs = (enable, clear, general);
    }
    fn analog_out(&mut self, at: u32, channel: usize, value: i16) {
        self.analog_edges.push((at, channel, value));
        self.analog_out[channel] = value;
    }
    fn interlock(&mut self) -> bool {
        self.interlock
    }
    fn laser(&mut self, _: usize, _: &LaserPlan) {}
}

pub struct Bench {
    pub tick: Tick<AXES>,
    pub machine: Machine,
    lanes: TickHalves<'static, AXES>,
    immediate: Producer<'static, LaneEntry, IMMEDIATE_ENTRIES>,
    program: Producer<'static, LaneEntry, PROGRAM_ENTRIES>,
    view: Reader<'static, View<AXES>>,
    events: Consumer<'static, Event, EVENTS>,
    samples: Consumer<'static, Sample, TRACE_SAMPLES>,
    seq: [u32; 2],
    /// What admission knows of each axis's FIFOs: the chain, and segments pushed.
    chains: [[(Chain, u32); 2]; AXES],
    /// The same of Follow.
    entries: [[follow::FollowChain; 2]; AXES],
    /// Entries pushed into the FIFOs of each path.
    pushed: [[u32; 2]; Crd::MAX],
}

/// What goes into a FIFO of Follow.
#[derive(Clone, Copy)]
pub enum Item {
    /// Master, slave, type, percent.
    Data(f64, f64, i16, i16),
    Output(DoGroup, u8, bool),
    Delay(u32),
    Wait(follow::Input, u8, bool, u32),
    Switch(follow::Method),
}

fn leak<T>(value: T) -> &'static mut T {
    Box::leak(Box::new(value))
}

pub fn axis(index: usize) -> Axis {
    Axis::new(index).unwrap()
}

pub fn crd(index: usize) -> Crd {
    Crd::new(index).unwrap()
}

pub fn crd_mask(crds: &[usize]) -> CrdMask {
    CrdMask(crds.iter().map(|index| 1 << index).sum())
}

pub fn all(axes: &[usize]) -> AxisMask {
    AxisMask(axes.iter().map(|index| 1 << index).sum())
}

pub fn accel(value: f64) -> Accel {
    Accel::admit(value.to_bits()).unwrap()
}

pub fn speed(value: f64) -> Speed {
    Speed::admit(value.to_bits(), StepLimit::FULL_SCALE).unwrap()
}

pub fn real(value: Scaled) -> f64 {
    value.m as f64 * (-value.e as f64).exp2()
}

/// Position in pulses; exact for what these tests use.
pub fn pulses(pos: Pos) -> f64 {
    pos.0 as f64 / (1u64 << Pos::FRAC_BITS) as f64
}

impl Bench {
    pub fn new(period_us: u32) -> Bench {
        Bench::limited(period_us, StepLimit::FULL_SCALE)
    }

    /// On a board whose steps are limited.
    pub fn limited(period_us: u32, step_limit: StepLimit) -> Bench {
        let (immediate, immediate_out) = leak(Ring::new()).split();
        let (program, program_out) = leak(Ring::new()).split();
        let (events_in, events) = leak(Ring::new()).split();
        let (samples_in, samples) = leak(Ring::new()).split();
        let (view_in, view) = leak(Latest::new(View::POWER_ON)).split();
        let places: Box<[PointStore]> = (0..TABLES).map(|_| PointStore::new()).collect();
        let places: Box<[PointStore; TABLES]> = places.try_into().ok().unwrap();
        let tables = TableStores {
            points: Box::leak(places),
            headers: leak(HeaderStore::new()),
            lasers: leak(servo::laser::PowerTables::new()),
            edges: leak(servo::EdgeCounts::new()),
        };
        let paths = PathStores::of::<{ Crd::MAX }>(leak([const { [const { EntryStore::new() }; 2] }; Crd::MAX]));
        let segments: &'static [SegmentStore; AXES] = leak([const { SegmentStore::new() }; AXES]);
        let config = TickConfig {
            period_ns: period_us * 1000,
            axes: AXES as u8,
            analog_inputs: 2,
            laser_clock: Clock::GHZ,
            step_limit,
        };
        Bench {
            tick: Tick::new(config),
            machine: Machine {
                inputs: [AxisInputs::default(); AXES],
                index: [None; AXES],
                set_points: [Pos(0); AXES],
                slip: [0; AXES],
                outputs: (0, 0, 0),
                analog_out: [0; 8],
                general: 0x5a,
                edges: Vec::new(),
                analog_edges: Vec::new(),
                interlock: false,
                levels: vec![],
            },
            lanes: TickHalves {
                immediate: immediate_out,
                program: program_out,
                view: view_in,
                events: events_in,
                samples: samples_in,
                segments,
                tables,
                paths,
            },
            immediate,
            program,
            view,
            events,
            samples,
            seq: [0; 2],
            chains: [[(Chain::default(), 0); 2]; AXES],
            entries: Default::default(),
            pushed: [[0; 2]; Crd::MAX],
        }
    }

    /// One with the servo on and the mode set on all axes, one tick old.
    pub fn prepared(period_us: u32, mode: MotionMode) -> Bench {
        let mut bench = Bench::new(period_us);
        bench.prepare_start(mode);
        bench
    }

    /// A tick with the servo on and the mode set on all axes.
    pub fn prepare_start(&mut self, mode: MotionMode) {
        self.now(TickCommand::Output { group: DoGroup::Enable, mask: 0xff, value: 0xff });
        for index in 0..AXES {
            self.now(TickCommand::SetMode { axis: axis(index), mode });
        }
        self.tick();
    }

    /// Pushes into the immediate lane.
    pub fn now(&mut self, command: TickCommand) -> u32 {
        self.seq[0] += 1;
        self.immediate.push(LaneEntry { seq: self.seq[0], delay: Ns(0), command }).unwrap();
        self.seq[0]
    }

    /// Pushes into the program lane.
    pub fn then(&mut self, delay_ns: u64, command: TickCommand) -> u32 {
        self.seq[1] += 1;
        self.program.push(LaneEntry { seq: self.seq[1], delay: Ns(delay_ns), command }).unwrap();
        self.seq[1]
    }

    pub fn tick(&mut self) -> View<AXES> {
        self.tick.run(&mut self.machine, &mut self.lanes);
        *self.view.read()
    }

    /// A tick whose view nobody reads.
    pub fn tick_unread(&mut self) {
        self.tick.run(&mut self.machine, &mut self.lanes);
    }

    /// Ticks until the view's instant is `ns`; must hit it.
    pub fn until(&mut self, ns: u64) -> View<AXES> {
        loop {
            let view = self.tick();
            assert!(view.now.0 <= ns, "{} ns is not a tick", ns);
            if view.now.0 == ns {
                return view;
            }
        }
    }

    pub fn ticks(&mut self, count: u32) -> View<AXES> {
        for _ in 1..count {
            self.tick();
        }
        self.tick()
    }

    /// Ticks until no axis runs; fails after a minute of controller time.
    pub fn run_to_standstill(&mut self) -> View<AXES> {
        loop {
            let view = self.tick();
            if view.axes.iter().all(|axis| axis.status & servo::status::RUNNING == 0) {
                return view;
            }
            assert!(view.now.0 < 60_000 * MS, "it does not come to rest");
        }
    }

    /// Edges of an input so far.
    pub fn edges(&self, input: follow::Input, index: u8) -> u32 {
        self.lanes.tables.edges.of(input, index)
    }

    pub fn event(&mut self) -> Option<Event> {
        self.events.pop()
    }

    pub fn sample(&mut self) -> Option<Sample> {
        self.samples.pop()
    }

    /// Admits segments and pushes their commit into the immediate lane.
    pub fn pt(&mut self, index: usize, fifo: u8, segments: &[(f64, i32, i16)]) {
        let commit = self.pt_data(index, fifo, segments);
        self.now(commit);
    }

    /// Admits segments; the commit is the caller's to push.
    pub fn pt_data(&mut self, index: usize, fifo: u8, segments: &[(f64, i32, i16)]) -> TickCommand {
        let (chain, count) = &mut self.chains[index][fifo as usize];
        for (pos, time, kind) in segments {
            let (segment, next) = Segment::admit(pos.to_bits(), *time, *kind, chain, StepLimit::FULL_SCALE).unwrap();
            self.lanes.segments[index].write(fifo as u32 * 1024 + *count, segment);
            *chain = next;
            *count += 1;
        }
        let epoch = self.view.read().axes[index].epoch;
        TickCommand::PtCommit { axis: axis(index), fifo, end: *count, epoch }
    }

    /// Writes a PVT table: ms, pulses and 2⁻¹⁶ pulse/ms from the first point, which comes `delay`
    /// ms after the start.
    pub fn table(&mut self, table: u8, delay: u64, knots: &[(u64, i64, i64)]) {
        let (last, way, _) = knots[knots.len() - 1];
        let time_bits = (44 - (64 - (last * MS).leading_zeros() as i32)).min(32) as i8;
        let duration = u128::from(last * MS) << 64;
        let header = Header {
            points: knots.len() as u16,
            time_bits,
            pos_bits: 20,
            vel_bits: 16,
            lift: 20,
            delay: u128::from(delay * MS) << 64,
            duration,
            displacement: Exact((way as i128) << 64),
            rate: (u128::MAX / duration) as u64,
        };
        for (index, &(time, pos, vel)) in knots.iter().enumerate() {
            let point = Point { time: (time * MS) << time_bits, pos: pos << 20, vel };
            self.lanes.tables.write_point(table, index as u32, point.admit().unwrap());
        }
        self.lanes.tables.write_header(table, header.admit().unwrap());
    }

    /// A coordinate system that drives these axes as X, Y and so on; its zero is at `origin`, or
    /// where they are.
    pub fn frame(&mut self, index: usize, axes: &[usize], origin: Option<[i32; 4]>) {
        let mut mapped = [None; 4];
        for (point, index) in mapped.iter_mut().zip(axes) {
            *point = Some(axis(*index));
        }
        self.now(TickCommand::CrdFrame { crd: crd(index), frame: AxisMap::admit(mapped, origin, 0).unwrap() });
        self.pushed[index] = [0; 2];
    }

    /// Pushes entries into a FIFO of a path, and their commit into the immediate lane. `frame` or a
    /// clearing must have been executed.
    pub fn path(&mut self, index: usize, fifo: u8, entries: &[path::PathEntry]) {
        let commit = self.path_data(index, fifo, entries);
        self.now(commit);
    }

    /// The same; the commit is the caller's to push.
    pub fn path_data(&mut self, index: usize, fifo: u8, entries: &[path::PathEntry]) -> TickCommand {
        let count = &mut self.pushed[index][fifo as usize];
        for entry in entries {
            self.lanes.paths.get(index).unwrap()[fifo as usize].write(*count, *entry);
            *count += 1;
        }
        let cleared = self.view.read().crds[index].cleared[fifo as usize];
        TickCommand::CrdCommit { crd: crd(index), fifo, end: *count, cleared }
    }

    /// CrdClear.
    pub fn clear_path(&mut self, index: usize, fifo: u8) {
        self.now(TickCommand::CrdClear { crd: crd(index), fifo });
        self.pushed[index][fifo as usize] = 0;
    }

    /// CrdStart with FIFO 0.
    pub fn start_path(&mut self, crds: &[usize]) -> u32 {
        self.now(TickCommand::CrdStart { crds: crd_mask(crds), fifo1: CrdMask(0) })
    }

    /// Admission forgets what it pushed: the FIFO was cleared.
    pub fn forget(&mut self, index: usize) {
        self.chains[index] = Default::default();
    }

    /// Admits entries of Follow and pushes their commit into the immediate lane.
    pub fn follow(&mut self, index: usize, fifo: u8, items: &[Item]) {
        self.follow_in(index, fifo, follow::Direction::Both, items);
    }

    /// The same for a direction.
    pub fn follow_in(&mut self, index: usize, fifo: u8, direction: follow::Direction, items: &[Item]) {
        let chain = &mut self.entries[index][fifo as usize];
        for item in items {
            let admitted = match *item {
                Item::Data(master, slave, kind, percent) => {
                    follow::FollowEntry::segment(master.to_bits(), slave.to_bits(), kind, percent, direction, chain)
                }
                Item::Output(group, bit, high) => follow::FollowEntry::output(group, bit, high, chain),
                Item::Delay(cycles) => follow::FollowEntry::delay(cycles, chain),
                Item::Wait(input, index, high, ms) => follow::FollowEntry::wait_input(input, index, high, ms, chain),
                Item::Switch(method) => follow::FollowEntry::switch(method, chain),
            };
            let (entry, next) = admitted.unwrap();
            self.lanes.segments[index].write_entry(fifo, chain.entries(), entry);
            *chain = next;
        }
        let (end, tail) = (chain.entries(), chain.tail());
        let cleared = self.view.read().axes[index].cleared[fifo as usize];
        self.now(TickCommand::FollowCommit { axis: axis(index), fifo, end, cleared, tail });
    }

    /// Admission forgets what it pushed: a switch has emptied the FIFO.
    pub fn emptied(&mut self, index: usize, fifo: u8) {
        self.entries[index][fifo as usize] = follow::FollowChain::default();
    }

    /// Sets the master of an axis, and starts it.
    pub fn follows(&mut self, index: usize, master: usize, value: follow::MasterPosition) {
        let master = follow::Master { axis: axis(master), value };
        self.now(TickCommand::FollowMaster { axis: axis(index), master });
    }

    pub fn start_follow(&mut self, axes: &[usize]) -> u32 {
        self.now(TickCommand::FollowStart { axes: all(axes), fifo1: AxisMask(0) })
    }

    pub fn start(&mut self, axes: &[usize]) -> u32 {
        self.now(TickCommand::PtStart { axes: all(axes), fifo1: AxisMask(0) })
    }

    pub fn jog(&mut self, index: usize, velocity: f64, acc: f64) {
        let axis = axis(index);
        self.now(TickCommand::JogPrm { axis, acc: accel(acc), dec: accel(acc), smooth: 0 });
        self.now(TickCommand::TargetSpeed { axis, speed: speed(velocity) });
        self.now(TickCommand::Update { axes: axis.mask() });
    }
}

pub fn has(view: &AxisView, bits: u32) -> bool {
    view.status & bits == bits
}

pub fn stopped(event: Option<Event>) -> (usize, StopReason) {
    match event {
        Some(Event::Stopped { axis, reason, .. }) => (axis.index(), reason),
        other => panic!("no stop but {other:?}"),
    }
}

/// Listing 2-1 of the GXN manual: 2 pulse/ms, 4096 pulses in 3072 ms.
pub const LISTING_2_1: [(f64, i32, i16); 3] = [(1024.0, 1024, 0), (3072.0, 2048, 0), (4096.0, 3072, 0)];
