//! The controller in virtual time.
//!
//! In: link bytes, time by [`Board::advance`]. Out: link bytes, trace bytes, the machine's
//! state. Owns dispatcher, tick and machine and the hand-overs between them. Fails: never; what the
//! link brings is answered.
//!
//! The thread runs when there is something for it to do: bytes came, the tick executed an entry or
//! stopped an axis, a time of the thread's own is reached, or [`THREAD_TICKS`] have passed. Between
//! these it would find nothing but a newer view.
use crate::machine::{Beam, Edge, Inputs, Machine, Outputs, PLANNED_INPUTS};
use dispatcher::{PathQueue, SecondaryTransport, Server, ThreadHalves};
use plant::beam::ChannelLevels;
use protocol::record::{ReplyWriter, RequestRecord};
use protocol::viewer::Answered;
use ring::{Latest, Ring};
use servo::laser::Clock;
use servo::path::{EntryStore, PathStores};
use servo::segment::pvt::{HeaderStore, PointStore, TABLES};
use servo::tables::TableStores;
use servo::tick::{
    EVENTS, IMMEDIATE_ENTRIES, PROGRAM_ENTRIES, SegmentStore, TRACE_SAMPLES, Tick, TickConfig, TickHalves,
};
use servo::tick_command::LaneEntry;
use servo::units::{AxisMask, Crd, Ns, StepLimit};
use servo::view::{AxisView, CrdView, Event, LaserView, Sample, View};

/// Ticks after which the thread looks in any case: segments run, samples fill their ring.
const THREAD_TICKS: u32 = 16;
/// What a virtual controller is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Config {
    /// Servo tick at power-on in µs, 10 to 1000.
    pub tick_us: u32,
    /// Number of the profile shown at power-on. With one of 8 axes the board holds only 8, which is
    /// quicker; with any other it holds every profile (48 axes).
    pub profile: u8,
    /// What its step outputs make of an axis: pulse/ms, 1 to 2³². Anything else is 2³², full scale.
    pub step_limit: u64,
    /// The name that the board shows, 16 bytes of it.
    pub name: &'static str,
}

impl Default for Config {
    /// Profile `gus` on a board that holds only 8 axes, at the compatible tick of 250 µs, with full
    /// scale.
    fn default() -> Self {
        Config { tick_us: 250, profile: 0, step_limit: StepLimit::FULL_SCALE.pulses_per_ms(), name: "virtual" }
    }
}

/// A virtual controller whose memory lives for `'m`. See the module text.
pub struct Controller<'m> {
    core: Box<dyn Core + Send + 'm>,
}

/// A virtual controller whose memory lives as long as the program, as a real board's does.
pub type Board = Controller<'static>;

/// What a controller that ends before the program does is made of: see [`Controller::on`].
pub struct Memory {
    config: Config,
    parts: Parts,
}

/// Servo ticks of the virtual controller, µs: all that the tick can have.
pub const TICKS_US: core::ops::RangeInclusive<u32> = servo::tick::PERIOD_US;

enum Parts {
    Few(Box<Arena<8>>),
    All(Box<Arena<48>>),
}

impl Memory {
    /// For a controller like this.
    pub fn new(config: Config) -> Memory {
        let axes = dispatcher::PROFILES.get(usize::from(config.profile)).map_or(48, dispatcher::ProductProfile::axes);
        let parts = if axes <= 8 { Parts::Few(Box::new(Arena::new())) } else { Parts::All(Box::new(Arena::new())) };
        Memory { config, parts }
    }
}

impl Board {
    /// A controller at power-on.
    pub fn new(config: Config) -> Board {
        Controller::on(forever(Memory::new(config)))
    }
}

impl<'m> Controller<'m> {
    /// A controller at power-on, on memory that no controller had before it.
    pub fn on(memory: &'m mut Memory) -> Controller<'m> {
        let config = memory.config;
        let core: Box<dyn Core + Send + 'm> = match &mut memory.parts {
            Parts::Few(arena) => Box::new(Whole::new(arena, config)),
            Parts::All(arena) => Box::new(Whole::new(arena, config)),
        };
        Controller { core }
    }

    /// Takes bytes from the link; the thread acts on them at once.
    pub fn feed(&mut self, bytes: &[u8]) {
        self.core.feed(bytes);
    }

    /// Takes bytes of a wire that the link is not on: see [`SecondaryTransport::feed`].
    pub fn visit(&mut self, wire: &mut SecondaryTransport, holder: Option<&str>, bytes: &[u8]) -> (usize, bool) {
        self.core.visit(wire, holder, bytes)
    }

    /// Answers a read of a viewer: see [`Server::answer_viewer`].
    pub fn answer_viewer(&self, record: &RequestRecord<'_>, out: &mut ReplyWriter<'_>) -> Answered {
        self.core.answer_viewer(record, out)
    }

    /// Advances the counters by so many executed entries and `ns`, for tests of a long life.
    /// Nothing may run or be in transfer.
    #[cfg(feature = "test-hooks")]
    pub fn advance_counters(&mut self, entries: u32, ns: u64) {
        self.core.advance_counters(entries, ns);
    }

    /// Advances the count of executed entries of each FIFO of a path, and the on-time of each laser
    /// in units of 250 µs, for the same tests. All FIFOs must be empty.
    #[cfg(feature = "test-hooks")]
    pub fn advance_fifo_counters(&mut self, by: u32) {
        self.core.advance_fifo_counters(by);
    }

    /// Moves the link bytes that are ready to the end of `out`.
    pub fn take_tx(&mut self, out: &mut Vec<u8>) {
        self.core.take_tx(out);
    }

    /// Moves the trace bytes that are ready to the end of `out`.
    pub fn take_trace(&mut self, out: &mut Vec<u8>) {
        self.core.take_trace(out);
    }

    /// Ticks until `ns` of controller time have passed or the link has bytes, which go to `out`.
    /// Returns whether it has.
    pub fn advance(&mut self, ns: u64, out: &mut Vec<u8>) -> bool {
        self.core.advance(ns, out)
    }

    /// Controller time: the instant of the tick in force, in ns.
    pub fn now(&self) -> u64 {
        self.core.now()
    }

    /// Controller time of the present tick period, in ns.
    pub fn period_ns(&self) -> u64 {
        self.core.period_ns()
    }

    /// Controller time at which the last program's script clock was zero, in ns.
    pub fn program_zero_ns(&mut self) -> u64 {
        self.core.program_zero_ns()
    }

    /// Input levels, to be looked at and set.
    pub fn inputs_mut(&mut self) -> &mut Inputs {
        self.core.inputs_mut()
    }

    /// Makes the interlock input active at an instant of controller time in ns, which may be
    /// between two ticks; a past instant means that of the tick in force. [`Inputs::interlock`]
    /// reports it, and ends it.
    pub fn raise_interlock(&mut self, at_ns: u64) {
        self.core.raise_interlock(at_ns);
    }

    /// Output levels in force from the next tick on.
    pub fn outputs(&self) -> Outputs {
        self.core.outputs()
    }

    /// The machine finds that a servo tick began late.
    pub fn overrun(&mut self) {
        self.core.overrun();
    }

    /// The run before this one was ended by a fault or the watchdog, as a board finds at power-on.
    pub fn restarted(&mut self) {
        self.core.restarted();
    }

    /// The set-point of an axis (from 0 over all cores) in force from the next tick on, in 2⁻²²
    /// pulse since power-on: what the step outputs count, whatever name the position has.
    pub fn set_point(&self, axis: usize) -> i64 {
        self.core.set_point(axis)
    }

    /// The encoder count of an axis as the tick in force has read it, whatever the controller calls
    /// it.
    pub fn encoder(&self, axis: usize) -> i64 {
        self.core.encoder(axis)
    }

    /// An axis (from 0 over all cores) in the tick computed last.
    pub fn axis(&mut self, axis: usize) -> AxisView {
        self.core.axis(axis)
    }

    /// A coordinate system (from 0) in the tick computed last.
    pub fn crd(&mut self, crd: usize) -> CrdView {
        self.core.crd(crd)
    }

    /// A laser channel (from 0) as the tick computed last has it.
    pub fn laser_view(&mut self, channel: usize) -> LaserView {
        self.core.laser_view(channel)
    }

    /// Takes the edges of the digital outputs since the last call, in the order of time.
    pub fn take_edges(&mut self) -> Vec<Edge> {
        self.core.take_edges()
    }

    /// Whether what the lasers' outputs do is kept for [`Board::take_beam`].
    pub fn record_beam(&mut self, on: bool) {
        self.core.record_beam(on);
    }

    /// Takes what the lasers' outputs did since the last call, to the ns: in the order of time for
    /// each output.
    pub fn take_beam(&mut self) -> Vec<Beam> {
        self.core.take_beam()
    }

    /// Levels of a laser's outputs (channel from 0) just before the tick in force.
    pub fn laser(&mut self, channel: usize) -> ChannelLevels {
        self.core.laser(channel)
    }
}

/// A board of any capacity.
trait Core {
    fn feed(&mut self, bytes: &[u8]);
    fn visit(&mut self, wire: &mut SecondaryTransport, holder: Option<&str>, bytes: &[u8]) -> (usize, bool);
    fn answer_viewer(&self, record: &RequestRecord<'_>, out: &mut ReplyWriter<'_>) -> Answered;
    #[cfg(feature = "test-hooks")]
    fn advance_counters(&mut self, entries: u32, ns: u64);
    #[cfg(feature = "test-hooks")]
    fn advance_fifo_counters(&mut self, by: u32);
    fn take_tx(&mut self, out: &mut Vec<u8>);
    fn take_trace(&mut self, out: &mut Vec<u8>);
    fn advance(&mut self, ns: u64, out: &mut Vec<u8>) -> bool;
    fn now(&self) -> u64;
    fn period_ns(&self) -> u64;
    fn program_zero_ns(&mut self) -> u64;
    fn inputs_mut(&mut self) -> &mut Inputs;
    fn raise_interlock(&mut self, at_ns: u64);
    fn outputs(&self) -> Outputs;
    fn overrun(&mut self);
    fn restarted(&mut self);
    fn set_point(&self, axis: usize) -> i64;
    fn encoder(&self, axis: usize) -> i64;
    fn axis(&mut self, axis: usize) -> AxisView;
    fn crd(&mut self, crd: usize) -> CrdView;
    fn laser_view(&mut self, channel: usize) -> LaserView;
    fn take_edges(&mut self) -> Vec<Edge>;
    fn record_beam(&mut self, on: bool);
    fn take_beam(&mut self) -> Vec<Beam>;
    fn laser(&mut self, channel: usize) -> ChannelLevels;
}

/// The stores and queues of a board of `AXES` axes. The stores are megabytes: they are built in
/// place, not on the stack.
struct Arena<const AXES: usize> {
    segments: Box<[SegmentStore; AXES]>,
    places: Box<[PointStore; TABLES]>,
    headers: Box<HeaderStore>,
    lasers: Box<servo::laser::PowerTables>,
    edges: Box<servo::EdgeCounts>,
    paths: Box<[[EntryStore; 2]; Crd::MAX]>,
    queues: Box<[[PathQueue; 2]]>,
    immediate: Ring<LaneEntry, IMMEDIATE_ENTRIES>,
    program: Ring<LaneEntry, PROGRAM_ENTRIES>,
    events: Ring<Event, EVENTS>,
    samples: Ring<Sample, TRACE_SAMPLES>,
    view: Latest<View<AXES>>,
}

/// A row of `N` values, built in place.
fn row<T, const N: usize>(make: fn() -> T) -> Box<[T; N]> {
    let row: Box<[T]> = (0..N).map(|_| make()).collect();
    let Ok(row) = row.try_into() else { unreachable!("a row of N values was collected") };
    row
}

impl<const AXES: usize> Arena<AXES> {
    fn new() -> Self {
        Arena {
            segments: row(SegmentStore::new),
            places: row(PointStore::new),
            headers: Box::new(HeaderStore::new()),
            lasers: Box::new(servo::laser::PowerTables::new()),
            edges: Box::new(servo::EdgeCounts::new()),
            paths: row(|| [const { EntryStore::new() }; 2]),
            queues: (0..Crd::MAX).map(|_| Default::default()).collect(),
            immediate: Ring::new(),
            program: Ring::new(),
            events: Ring::new(),
            samples: Ring::new(),
            view: Latest::new(View::<AXES>::POWER_ON),
        }
    }
}

/// Thread, tick and machine of a board with room for `AXES` axes.
struct Whole<'m, const AXES: usize> {
    server: Box<Server<'m, AXES>>,
    tick: Box<Tick<AXES>>,
    lanes: TickHalves<'m, AXES>,
    machine: Machine<AXES>,
    /// Ticks since the thread last ran.
    idle_ticks: u32,
    /// What the thread saw when it last ran.
    wake_facts: WakeFacts,
    /// Trace bytes that were not read yet.
    trace: Vec<u8>,
}

/// What in a view wakes the thread.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct WakeFacts {
    done_immediate: u32,
    done_program: u32,
    program_runs: bool,
}

impl WakeFacts {
    fn of<const AXES: usize>(view: &View<AXES>) -> Self {
        WakeFacts {
            done_immediate: view.done_immediate,
            done_program: view.done_program,
            program_runs: view.program_runs,
        }
    }
}

/// A value that lives as long as the program.
fn forever<T>(value: T) -> &'static mut T {
    Box::leak(Box::new(value))
}

impl<'m, const AXES: usize> Whole<'m, AXES> {
    fn new(arena: &'m mut Arena<AXES>, config: Config) -> Self {
        let (stores, paths): (&[SegmentStore; AXES], _) = (&arena.segments, PathStores::of(&arena.paths));
        let tables =
            TableStores { points: &arena.places, headers: &arena.headers, lasers: &arena.lasers, edges: &arena.edges };
        let (immediate_in, immediate_out) = arena.immediate.split();
        let (program_in, program_out) = arena.program.split();
        let (events_in, events_out) = arena.events.split();
        let (samples_in, samples_out) = arena.samples.split();
        let (view_in, view_out) = arena.view.split();
        let step_limit = StepLimit::new(config.step_limit).unwrap_or(StepLimit::FULL_SCALE);
        let board = dispatcher::BoardConstants {
            name: config.name,
            profile: config.profile,
            tick_us: TICKS_US,
            analog_outputs: 8,
            analog_inputs: 8,
            planned_inputs: PLANNED_INPUTS,
            general_inputs: servo::port::GeneralInputs::BITS as u8,
            general_outputs: servo::port::GeneralOutputs::BITS as u8,
            indexes: AxisMask(u64::MAX),
            step_limit,
            wired: &servo::port::WiredInputs::ALL,
            fault: None,
            contradiction: || None,
            tick_time: None,
            stack: None,
        };
        let channels = ThreadHalves {
            immediate: immediate_in,
            program: program_in,
            view: view_out,
            events: events_out,
            samples: samples_out,
            stores,
            paths,
            queues: &mut arena.queues,
            tables,
        };
        let lanes = TickHalves {
            immediate: immediate_out,
            program: program_out,
            view: view_in,
            events: events_in,
            samples: samples_in,
            segments: stores,
            tables,
            paths,
        };
        let tick = TickConfig {
            period_ns: config.tick_us.clamp(10, 1000) * 1000,
            axes: AXES as u8,
            analog_inputs: 8,
            laser_clock: Clock::GHZ,
            step_limit,
        };
        let mut whole = Whole {
            server: Box::new(Server::new(board, channels)),
            tick: Box::new(Tick::new(tick)),
            lanes,
            machine: Machine::new(),
            idle_ticks: 0,
            wake_facts: WakeFacts::default(),
            trace: Vec::new(),
        };
        // The first view is that of the first tick: no client reads the state before it.
        whole.run_tick();
        whole.run_thread();
        whole
    }

    fn run_tick(&mut self) {
        let period = self.tick.period().0;
        self.machine.begin(period, self.tick.now().0 + period);
        self.tick.run(&mut self.machine, &mut self.lanes);
        self.idle_ticks += 1;
    }

    fn run_thread(&mut self) {
        self.server.poll(self.tick.now());
        // Taken at once: samples that the stream has no room for would be lost.
        drain(&mut self.trace, |part| self.server.take_trace(part));
        self.idle_ticks = 0;
        self.wake_facts = WakeFacts::of(self.server.view());
    }

    /// Whether the thread has something to do.
    fn is_woken(&mut self) -> bool {
        self.idle_ticks >= THREAD_TICKS
            || WakeFacts::of(self.server.view()) != self.wake_facts
            || self.server.next_deadline().is_some_and(|at| at <= self.tick.now())
    }
}

/// Calls `take` until it has no more bytes.
fn drain(out: &mut Vec<u8>, mut take: impl FnMut(&mut [u8]) -> usize) {
    let mut part = [0; 2048];
    loop {
        match take(&mut part) {
            0 => return,
            n => out.extend_from_slice(&part[..n]),
        }
    }
}

impl<const AXES: usize> Core for Whole<'_, AXES> {
    fn feed(&mut self, bytes: &[u8]) {
        self.server.feed(self.tick.now(), bytes);
        self.run_thread();
    }

    fn visit(&mut self, wire: &mut SecondaryTransport, holder: Option<&str>, bytes: &[u8]) -> (usize, bool) {
        let outcome = wire.feed(self.tick.now(), &mut self.server, holder, bytes);
        self.run_thread();
        outcome
    }

    fn answer_viewer(&self, record: &RequestRecord<'_>, out: &mut ReplyWriter<'_>) -> Answered {
        self.server.answer_viewer(record, out)
    }

    #[cfg(feature = "test-hooks")]
    fn advance_counters(&mut self, entries: u32, ns: u64) {
        self.server.advance_counters(entries);
        self.tick.advance_counters(entries, Ns(ns));
        self.run_tick();
        self.run_thread();
    }

    #[cfg(feature = "test-hooks")]
    fn advance_fifo_counters(&mut self, by: u32) {
        self.server.advance_fifo_counters(by);
        self.tick.advance_fifo_counters(by);
        self.run_tick();
        self.run_thread();
    }

    fn take_tx(&mut self, out: &mut Vec<u8>) {
        drain(out, |part| self.server.take_tx(part));
    }

    fn take_trace(&mut self, out: &mut Vec<u8>) {
        out.append(&mut self.trace);
    }

    fn advance(&mut self, ns: u64, out: &mut Vec<u8>) -> bool {
        let end = self.tick.now().0.saturating_add(ns);
        while self.tick.now().0 < end {
            self.run_tick();
            if self.is_woken() {
                self.run_thread();
                let before = out.len();
                self.take_tx(out);
                if out.len() > before {
                    return true;
                }
            }
        }
        false
    }

    fn now(&self) -> u64 {
        self.tick.now().0
    }

    fn period_ns(&self) -> u64 {
        self.tick.period().0
    }

    fn program_zero_ns(&mut self) -> u64 {
        let Ns(zero) = self.server.view().script_zero;
        zero
    }

    fn inputs_mut(&mut self) -> &mut Inputs {
        &mut self.machine.inputs
    }

    fn raise_interlock(&mut self, at_ns: u64) {
        self.machine.raise_interlock(at_ns.max(self.tick.now().0));
    }

    fn outputs(&self) -> Outputs {
        self.machine.outputs
    }

    fn overrun(&mut self) {
        self.tick.overrun();
    }

    fn restarted(&mut self) {
        self.tick.restarted();
    }

    fn set_point(&self, axis: usize) -> i64 {
        self.machine.set_point_of(axis)
    }

    fn encoder(&self, axis: usize) -> i64 {
        self.machine.encoder_of(axis)
    }

    fn axis(&mut self, axis: usize) -> AxisView {
        self.server.view().axes.get(axis).copied().unwrap_or_default()
    }

    fn crd(&mut self, crd: usize) -> CrdView {
        self.server.view().crds.get(crd).copied().unwrap_or(CrdView::POWER_ON)
    }

    fn laser_view(&mut self, channel: usize) -> LaserView {
        self.server.view().lasers.get(channel).copied().unwrap_or(View::<AXES>::POWER_ON.lasers[0])
    }

    fn take_edges(&mut self) -> Vec<Edge> {
        self.machine.edges.drain(..).collect()
    }

    fn record_beam(&mut self, on: bool) {
        self.machine.record_beam(on);
    }

    fn take_beam(&mut self) -> Vec<Beam> {
        self.machine.take_beam(self.tick.now().0)
    }

    fn laser(&mut self, channel: usize) -> ChannelLevels {
        self.machine.laser(channel, self.tick.now().0)
    }
}
