//! The servo tick: the whole body of the periodic interrupt, the same on every machine.
//!
//! In: the inputs of a [`Port`] at the tick in force (n), entries of two lanes. Out: set-points and
//! outputs for tick n + 1, a view of it, events, trace samples. Owns: the state of all axes,
//! controller time, the script clock. Budget: entries by weight ([`workload`]) and one step for
//! each axis; no loop length depends on data. Fails: never; an event that a full ring refuses is
//! counted in the view.
//!
//! Order within a tick: inputs are sampled; entries act; every running coordinate system takes its
//! step, then every axis; slaves step after their masters, lasers last. So a limit sampled now
//! stops the set-point of the next tick.
pub(crate) mod crd;
pub(crate) mod execute;
pub(crate) mod hand_overs;
pub(crate) mod script_clock;
pub(crate) mod slaves;
mod source;
mod trace_rows;
pub(crate) mod workload;

use crate::axis::{AxisState, FastStep};
use crate::capacity::{GeneralInputs, GeneralOutputs};
pub use crate::capacity::{IMMEDIATE_ENTRIES, PROGRAM_ENTRIES, TRACE_SAMPLES};
use crate::edge_counts::EdgeCounts;
use crate::laser::{Cause, Clock, Lasers};
use crate::output::general_outputs::{OutputEdges, OutputLevels, Set};
use crate::output::timed_outputs::TimedOutputs;
use crate::path::PathStores;
use crate::port::{AxisInputs, Port};
use crate::segment::follow::SlaveOrder;
pub use crate::segment::pt::{SEGMENTS, SegmentStore};
use crate::tables::TableStores;
use crate::tick_command::{Lane, LaneEntry, Supervision, TickCommand};
use crate::trace::{Chosen, Trace, TraceSamples};
use crate::units::{Axis, AxisMask, CrdMask, Ns, StepLimit};
use crate::view::{AxisView, Event, Sample, StopReason, View};
use crd::Crds;
use hand_overs::HandOvers;
use ring::{Consumer, Producer, Writer};
use script_clock::ScriptClock;
use slaves::Switched;
pub(crate) use source::MotionSource;
use workload::TickBudget;

/// Events between two runs of the thread.
pub const EVENTS: usize = 64;
/// Shortest and longest period, ns.
pub const PERIOD_NS: core::ops::RangeInclusive<u32> = *PERIOD_US.start() * 1000..=*PERIOD_US.end() * 1000;
/// The same in µs.
pub const PERIOD_US: core::ops::RangeInclusive<u32> = 10..=1000;

/// What a board fixes.
#[derive(Debug, Clone, Copy)]
pub struct TickConfig {
    /// Period at power-on, ns, in [`PERIOD_NS`].
    pub period_ns: u32,
    /// Axes in use, at most the capacity.
    pub axes: u8,
    /// Analog inputs to sample, at most 8.
    pub analog_inputs: u8,
    /// The clock of the timers that carry out laser plans.
    pub laser_clock: Clock,
    /// The fastest axis that its step outputs can make.
    pub step_limit: StepLimit,
}

/// The tick's halves of the hand-overs.
pub struct TickHalves<'a, const AXES: usize> {
    /// Entries that act on the next tick.
    pub immediate: Consumer<'a, LaneEntry, IMMEDIATE_ENTRIES>,
    /// Timed entries of a program.
    pub program: Consumer<'a, LaneEntry, PROGRAM_ENTRIES>,
    /// The view of the tick computed last.
    pub view: Writer<'a, View<AXES>>,
    /// Events.
    pub events: Producer<'a, Event, EVENTS>,
    /// Trace samples.
    pub samples: Producer<'a, Sample, TRACE_SAMPLES>,
    /// PT segments of every axis.
    pub segments: &'a [SegmentStore; AXES],
    /// PVT tables.
    pub tables: TableStores<'a>,
    /// FIFOs of coordinate systems.
    pub paths: PathStores<'a>,
}

/// The steps of axes that are off the fast path.
struct OffFastPath<'a, 'l> {
    next: Ns,
    /// Pieces that may still be made ahead in this tick.
    left: u32,
    segments: &'a [SegmentStore],
    tables: TableStores<'a>,
    inputs: &'a mut [AxisInputs],
    events: &'a mut Producer<'l, Event, EVENTS>,
    lost: &'a mut u32,
}

impl OffFastPath<'_, '_> {
    /// The step of one whose fast path ended with `fast_step`.
    #[inline(never)]
    fn step(&mut self, axis: Axis, mut fast_step: FastStep, state: &mut AxisState, published: &mut AxisView) {
        let next = self.next;
        if fast_step == FastStep::Far {
            fast_step = state.step_general(next, published);
        }
        if fast_step == FastStep::Shown {
            return;
        }
        if published.state_version != state.published.state_version
            && let Some(inputs) = self.inputs.get_mut(axis.index())
        {
            *inputs = state.raw;
        }
        if fast_step == FastStep::Stale {
            state.publish(published);
        } else if let Some(store) = self.segments.get(axis.index()) {
            let source = MotionSource { segments: store, tables: self.tables };
            let none = &mut 0;
            let left = if fast_step == FastStep::Barred { none } else { &mut self.left };
            if let Some(reason) = state.run(next, left, &source, published) {
                report_event(self.events, self.lost, Event::Stopped { axis, reason, now: next });
            }
        }
    }
}

state! {
    /// The state of the tick. `AXES` is the capacity of the build. What a view publishes of it has
    /// the view's order, so that a few instructions copy it; the axes come last.
    #[repr(C)]
    pub struct Tick<const AXES: usize> {
        /// Instant of the tick in force.
        pub(crate) now: Ns = Ns(0),
        /// From it to the next one.
        pub(crate) period: Ns = Ns(config.period_ns as u64),
        pub(crate) script: ScriptClock = ScriptClock::HELD,
        pub(crate) enable: u64 = 0,
        pub(crate) clear: u64 = 0,
        pub(crate) general: GeneralOutputs = 0,
        /// Ticks since power-on.
        pub(crate) ticks: u32 = 0,
        pub(crate) done_immediate: u32 = 0,
        pub(crate) done_program: u32 = 0,
        pub(crate) events_lost: u32 = 0,
        overruns: u32 = 0,
        /// Axes in use.
        pub(crate) used: usize = if (config.axes as usize) < AXES { config.axes as usize } else { AXES },
        analog_inputs: usize = config.analog_inputs as usize,
        /// What was running at an abort and has not stopped yet.
        pub(crate) aborted: (AxisMask, CrdMask) = (AxisMask(0), CrdMask(0)),
        /// Whether there is any of that.
        pub(crate) aborts: bool = false,
        pub(crate) supervision: Supervision = Supervision::DEFAULT,
        /// Where a Reset in progress goes on: at the axis before this one, counted from 1; 0 if
        /// there is none.
        pub(crate) resetting: u8 = 0,
        /// Axes that may wait for an index edge.
        indexed: AxisMask = AxisMask(0),
        /// The most that a slave moves in a tick, units of Pos, and the value that it is derived
        /// from.
        pub(crate) step_limit: u64 = in_a_tick(config.step_limit.per_us(), config.period_ns as u64),
        limit_per_us: u64 = config.step_limit.per_us(),
        pub(crate) steps: StepLimit = config.step_limit,
        pub(crate) trace: Trace = Trace::OFF,
        pub(crate) lasers: Lasers = Lasers::new(config.laser_clock),
        pub(crate) order: SlaveOrder<AXES> = SlaveOrder::NONE,
        pub(crate) crds: Crds = Crds::POWER_ON,
        pub(crate) edges: OutputEdges = OutputEdges::NONE,
        pub(crate) timed: TimedOutputs = TimedOutputs::NONE,
        /// General inputs as sampled last.
        general_inputs: GeneralInputs = 0,
        pub(crate) axes: [AxisState; AXES] = {
            const { assert!(AXES <= Axis::MAX, "more axes than a mask has bits") };
            [AxisState::POWER_ON; AXES]
        },
    }
    /// Power-on: tick 0 is in force at time 0; every axis at standstill at 0, servo off.
    pub const fn new(config: TickConfig);
}

impl<const AXES: usize> Tick<AXES> {
    /// Instant of the tick in force: that of the last view.
    pub fn now(&self) -> Ns {
        self.now
    }

    /// Time from the tick in force to the next one, for the machine's timer.
    pub fn period(&self) -> Ns {
        self.period
    }

    /// The machine found that a tick began late. It is counted, published in the view, and shuts
    /// off light.
    pub fn overrun(&mut self) {
        self.overruns = self.overruns.saturating_add(1);
        self.script.overrun(self.done_program);
        self.lasers.trip(Cause::Overrun);
    }

    /// The run before this one ended by a panic, a fault or the watchdog: lasers stay dark until
    /// cleared.
    pub fn restarted(&mut self) {
        self.lasers.trip(Cause::Restart);
    }

    /// Computes the next tick: called once at every tick, at the instant [`Tick::now`].
    pub fn run<P: Port>(&mut self, port: &mut P, halves: &mut TickHalves<AXES>) {
        let now = self.now;
        let next = Ns(now.0.wrapping_add(self.period.0));
        let mut period = self.period;

        let mut caused = false;
        for (axis, state) in Axis::all().zip(self.axes.get_mut(..self.used).unwrap_or_default()) {
            let (levels, count) = (port.inputs(axis).bits(), port.encoder(axis));
            if !state.sample(levels, count) {
                caused |= state.take(now, levels, count);
            }
        }
        if caused {
            self.report_causes();
            self.count_edges(halves.tables.edges);
        }
        if self.indexed.0 != 0 {
            self.take_index_captures(port);
        }
        let interlock = port.interlock();
        if interlock != self.lasers.interlock {
            self.take_interlock(interlock, next, halves);
        }
        if !halves.immediate.is_empty() || self.script.runs {
            self.execute_due(next, &mut period, port, halves);
        }
        if P::SIMULATED {
            let zero = self.script.runs.then_some(self.script.zero);
            while let Some(input) = port.planned(next, zero) {
                self.simulate(input, port);
            }
        }

        if self.crds.running.0 != 0 {
            let mut reach = HandOvers::of(halves);
            self.step_crds(next, &mut reach);
        }
        if self.crds.unprepared.0 & !self.crds.running.0 != 0 {
            self.crds.prepare_start(self.made_ahead(), halves.paths);
        }
        if self.order.slaves.0 == 0 {
            self.step_axes::<false>(next, port, halves);
        } else {
            self.step_axes::<true>(next, port, halves);
            self.step_slaves(next, port, halves);
        }
        port.outputs(0, self.enable, self.clear, self.general);
        if !self.timed.is_empty() {
            self.timed.take_due(next, period, &mut self.edges);
        }
        if !self.edges.is_empty() {
            self.flush_edges(next, port, halves);
        }
        if self.aborts {
            self.finish_abort(next);
        }
        let (trace, samples) = (&mut self.trace, &mut halves.samples);
        let (tables, axes) = (halves.tables.lasers, &self.axes);
        self.lasers.run(next, period, tables, axes, |channel, plan| {
            port.laser(usize::from(channel), plan);
            trace.record(channel, plan, samples);
        });
        if self.trace.runs() {
            self.trace.record_outputs(0, self.general, &mut halves.samples);
            if let Some((row, chosen)) = self.trace.advance() {
                self.emit(row, chosen, &mut halves.samples);
            }
        }

        self.now = next;
        if period != self.period {
            self.renew_period(period, &mut halves.samples);
        }
        self.ticks = self.ticks.wrapping_add(1);
        let general_inputs = port.general_inputs();
        if general_inputs != self.general_inputs {
            self.count_general(general_inputs, halves.tables.edges);
        }
        self.publish(port, halves.view.buffer());
        halves.view.publish();
    }

    /// The ticks after the one computed have another period.
    #[cold]
    #[inline(never)]
    fn renew_period(&mut self, period: Ns, samples: &mut TraceSamples) {
        (self.period, self.step_limit) = (period, in_a_tick(self.limit_per_us, period.0));
        self.trace.record_period(period.0 as u32, samples);
    }

    /// The interlock opens or closes: the lasers take it by themselves; motion brakes as
    /// `Supervision` says.
    #[inline(never)]
    fn take_interlock(&mut self, open: bool, next: Ns, halves: &mut TickHalves<AXES>) {
        self.lasers.interlock = open;
        if open {
            self.brake(self.supervision.interlock, StopReason::Interlock, next, &mut HandOvers::of(halves));
        }
    }

    /// Inputs of axes have changed: their edges count, but for the levels found at power-on.
    #[inline(never)]
    fn count_edges(&mut self, counts: &EdgeCounts) {
        for (axis, state) in Axis::all().zip(&mut self.axes) {
            let flips = core::mem::take(&mut state.flips);
            if self.ticks != 0 {
                counts.add_of_axis(axis, flips);
            }
        }
    }

    /// General inputs have changed: their edges count, but for the levels found at power-on.
    #[inline(never)]
    fn count_general(&mut self, levels: GeneralInputs, counts: &EdgeCounts) {
        let flips = core::mem::replace(&mut self.general_inputs, levels) ^ levels;
        if self.ticks > 1 {
            counts.add_of_general(flips);
        }
    }

    /// Takes the captures of index edges that have come. An axis that waits no more, after a Reset
    /// or a change of mode, is not asked again.
    #[inline(never)]
    fn take_index_captures(&mut self, port: &mut impl Port) {
        for axis in self.indexed.axes() {
            let waits = match self.axes.get_mut(axis.index()) {
                Some(state) if state.inputs.awaits_index() => match port.index(axis) {
                    Some(count) => {
                        state.take_index(count);
                        false
                    }
                    None => true,
                },
                _ => false,
            };
            if !waits {
                self.indexed.0 &= !axis.mask().0;
            }
        }
    }

    /// Pieces made ahead in a tick: two in 250 µs, one in a tick of 50 µs, as a segment then spans
    /// more ticks.
    #[inline(always)]
    pub(crate) fn made_ahead(&self) -> u32 {
        1u32.wrapping_add((self.period.0 >> 17) as u32)
    }

    /// Every axis takes its step; slaves wait for their masters.
    #[inline(always)]
    fn step_axes<const FOLLOW: bool>(&mut self, next: Ns, port: &mut impl Port, halves: &mut TickHalves<AXES>) {
        let left = self.made_ahead();
        let TickHalves { view, segments, tables, events, .. } = halves;
        let View { axes: published, inputs, .. } = view.buffer();
        let states = self.axes.get_mut(..self.used).unwrap_or_default();
        let slaves = self.order.slaves;
        let mut off_fast_path = OffFastPath {
            next,
            left,
            segments: *segments,
            tables: *tables,
            inputs,
            events,
            lost: &mut self.events_lost,
        };
        for (index, (state, published)) in states.iter_mut().zip(published).enumerate() {
            let Some(axis) = Axis::new(index) else { break };
            if FOLLOW && slaves.has(axis) {
                continue;
            }
            let fast_step = state.step_fast(next.0 as u32, off_fast_path.left, published);
            if fast_step != FastStep::Shown {
                off_fast_path.step(axis, fast_step, state, published);
            }
            port.set_point(axis, state.set_point());
        }
        // Every eighth tick an axis finds how long its data lasts, or prepares its next start: one
        // axis in a tick, in turn.
        let published = &mut halves.view.buffer().axes;
        let (mut index, mut made) = ((self.ticks & 7) as usize, false);
        while let (Some(state), Some(store), Some(published)) =
            (self.axes.get_mut(index), halves.segments.get(index), published.get_mut(index))
        {
            if state.runs() {
                let source = MotionSource { segments: store, tables: halves.tables };
                state.look_ahead(next, &source, published);
            } else if state.is_unprepared() && !made {
                let source = MotionSource { segments: store, tables: halves.tables };
                made = state.prepare_start(&source);
            }
            index = index.wrapping_add(8);
        }
    }

    /// The part of the view that belongs to no axis.
    #[inline]
    fn publish(&self, port: &mut impl Port, view: &mut View<AXES>) {
        (view.now, view.period) = (self.now, self.period);
        let ScriptClock { zero, clock, worst_late, late, first_late, overran, late_light, runs, .. } = self.script;
        (view.script_zero, view.script, view.worst_late) = (zero, clock, worst_late);
        (view.late, view.first_late, view.overran) = (late, first_late, overran);
        (view.late_light, view.program_runs, view.aborts) = (late_light, runs, self.aborts);
        (view.enable, view.clear) = (self.enable, self.clear);
        (view.general_outputs, view.tick) = (self.general, self.ticks);
        (view.done_immediate, view.done_program) = (self.done_immediate, self.done_program);
        (view.events_lost, view.overruns) = (self.events_lost, self.overruns);
        view.trace_lost = self.trace.lost;
        view.general_inputs = self.general_inputs;
        view.timer_mhz = self.lasers.clock.mhz();
        self.lasers.publish(&mut view.lasers);
        if view.crds_version != self.crds.version {
            view.crds_version = self.crds.version;
            self.crds.publish(&mut view.crds);
        }
        for (channel, value) in view.analog.iter_mut().enumerate().take(self.analog_inputs) {
            *value = port.analog(channel);
        }
    }

    /// Carries out what is due: the immediate lane, then the program lane, in order, as far as the
    /// tick takes it ([`workload`]).
    #[inline(never)]
    fn execute_due(&mut self, next: Ns, period: &mut Ns, port: &mut impl Port, halves: &mut TickHalves<AXES>) {
        let TickHalves { immediate, program, events, samples, segments, tables, paths, .. } = halves;
        let mut reach = HandOvers { events, samples, segments, tables: *tables, paths: *paths };
        let (mut budget, mut drops) = (TickBudget::of(self.period), false);
        let mut calls = workload::calls(self.period);
        // Entries are read in place: a copy of one costs as much as its work.
        while calls > 0
            && let Some(entry) = immediate.peek()
        {
            calls = calls.wrapping_sub(1);
            let weight = self.weigh(&entry.command);
            match entry.command {
                TickCommand::ProgramRun => {
                    self.script.begin(self.now);
                    if let Some((row, chosen)) = self.trace.begin_armed() {
                        self.trace.record_analog_carried(reach.tables.lasers, reach.samples);
                        self.emit(row, chosen, reach.samples);
                    }
                }
                // A Reset of the program that has begun is carried out as a whole, and nothing
                // after it.
                TickCommand::ProgramDrop if self.resetting != 0 => {
                    drops = true;
                    break;
                }
                TickCommand::ProgramDrop => {
                    program.clear();
                    self.script.runs = false;
                }
                TickCommand::Trace { every, axes, crds, lasers, edges, outputs } if !self.script.runs && every != 0 => {
                    self.trace.arm(every, Chosen { axes, crds, lasers, edges, outputs })
                }
                TickCommand::Reset { axes } => {
                    if !self.reset(axes, next, &mut budget, &mut reach) {
                        return;
                    }
                }
                _ => self.execute(Lane::Immediate, entry, next, period, port, &mut reach),
            }
            budget.spend(weight);
            self.done_immediate = entry.seq;
            immediate.skip();
        }
        while self.script.runs
            && let Some(entry) = program.peek()
        {
            let mut instant = self.script.instant(entry.delay);
            if !self.script.is_due(instant, next) {
                break;
            }
            if let TickCommand::WaitStandstill { axes, crds } = entry.command {
                // The first tick, from its instant on, at which nothing of the masks runs.
                let Some(since) = self.standstill_since(axes, crds) else { break };
                instant = instant.max(self.script.of(since));
            }
            let goes_on = match entry.command {
                TickCommand::Reset { axes } => self.reset(axes, next, &mut budget, &mut reach),
                _ => self.admits(program, entry, instant, &mut budget, &reach),
            };
            if !goes_on {
                self.script.put_off(instant, self.now);
                break;
            }
            budget.spend(self.weigh(&entry.command));
            let lights = self.changes_light(&entry.command);
            self.script.execute(instant, self.now, entry.seq, lights);
            match entry.command {
                TickCommand::ProgramEnd => self.script.runs = false,
                TickCommand::Reset { .. } => {}
                _ => self.execute(Lane::Program, entry, next, period, port, &mut reach),
            }
            self.done_program = entry.seq;
            program.skip();
            if drops {
                break;
            }
        }
    }

    /// Entries of paths have changed outputs within the coming interval.
    #[inline(never)]
    fn flush_edges(&mut self, next: Ns, port: &mut impl Port, halves: &mut TickHalves<AXES>) {
        let before = OutputLevels { enable: self.enable, clear: self.clear, general: self.general };
        let (trace, samples, tables) = (&mut self.trace, &mut halves.samples, halves.tables.lasers);
        trace.record_outputs(0, before.general, samples);
        let after = self.edges.flush(before, port, |at, set| match set {
            Set::General(levels) => trace.record_outputs(at, levels, samples),
            Set::Analog { channel, value } => {
                tables.set_analog(channel, value);
                trace.record_analog(at, channel, value, samples);
            }
        });
        (self.clear, self.general) = (after.clear, after.general);
        let (on, off) = (after.enable & !before.enable, before.enable & !after.enable);
        if on | off != 0 {
            self.switch_servos(Switched { on, off }, next, halves);
        }
    }

    /// Since when all of these have been at standstill; none while one runs.
    fn standstill_since(&self, axes: AxisMask, crds: CrdMask) -> Option<Ns> {
        if crds.0 & self.crds.running.0 != 0 {
            return None;
        }
        let mut since =
            crds.crds().filter_map(|crd| Some(self.crds.get(crd)?.standstill_since)).max().unwrap_or_default();
        for (index, state) in self.axes.iter().enumerate().take(self.used) {
            if axes.0 >> index & 1 == 1 {
                if state.runs() {
                    return None;
                }
                since = since.max(state.standstill_since);
            }
        }
        Some(since)
    }
}

/// The most that an axis moves in a tick, units of Pos; one more, as two positions are rounded.
const fn in_a_tick(per_us: u64, period_ns: u64) -> u64 {
    let us = (period_ns as u32).div_ceil(1000);
    (per_us.wrapping_mul(us as u64) >> 8).wrapping_add(1)
}

/// Reports to the thread, or counts the event that was lost.
pub(crate) fn report_event(events: &mut Producer<Event, EVENTS>, lost: &mut u32, event: Event) {
    if events.push(event).is_err() {
        *lost = lost.saturating_add(1);
    }
}
