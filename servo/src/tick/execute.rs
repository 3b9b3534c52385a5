//! What each tick command does in the tick.
//!
//! In: one admitted entry, the present state of the axes. Out: changed state, events. Owns nothing.
//! Fails: a start or an Update that the state forbids does nothing to any axis of its mask and is
//! reported as [`Event::Refused`]. An on command of a laser that a fault keeps dark, and a clear of
//! one whose cause is still there, are reported as [`Event::LaserRefused`]. Anything else that no
//! longer fits has no effect.
use super::crd::Halt;
use super::hand_overs::HandOvers;
use crate::axis::{AxisState, Jog};
use crate::capacity::GeneralOutputs;
use crate::laser::{self, ChannelChange};
use crate::port::{InputTime, Port, Simulated};
use crate::segment::follow::{Input, Method};
use crate::tick::{MotionSource, PERIOD_NS, Tick, report_event};
use crate::tick_command::{Brake, DoGroup, Lane, LaneEntry, MotionMode, TickCommand};
use crate::trace::{Chosen, TraceSamples};
use crate::units::{Axis, AxisMask, CrdMask, Ns, Pos};
use crate::view::{Event, StopReason};

impl<const AXES: usize> Tick<AXES> {
    /// Carries out one entry.
    #[inline(never)]
    pub(crate) fn execute<P: Port>(
        &mut self,
        lane: Lane,
        entry: &LaneEntry,
        next: Ns,
        period: &mut Ns,
        port: &mut P,
        hand_overs: &mut HandOvers<AXES>,
    ) {
        match entry.command {
            // Other cases have been carried out already.
            TickCommand::Mark
            | TickCommand::ProgramRun
            | TickCommand::ProgramDrop
            | TickCommand::ProgramEnd
            | TickCommand::WaitStandstill { .. }
            | TickCommand::Reset { .. } => {}
            TickCommand::Stop { axes, abrupt, crds, crds_abrupt } => {
                let named = CrdMask(crds.0 | self.holders(axes).0 | self.drivers(axes).0);
                self.lasers.crd_stops(self.crds.known(named), next);
                let abrupt = AxisMask(axes.0 & abrupt.0);
                let hard = CrdMask(crds.0 & crds_abrupt.0 | self.drivers(abrupt).0);
                let all = CrdMask(crds.0 | self.drivers(axes).0);
                self.stop_crds(hard, Halt::Abrupt, StopReason::StopAbrupt, next, hand_overs);
                self.stop_crds(CrdMask(all.0 & !hard.0), Halt::Smooth, StopReason::StopSmooth, next, hand_overs);
                self.brake_axes(AxisMask(axes.0 & !abrupt.0), StopReason::StopSmooth, next, hand_overs);
                self.halt(abrupt, StopReason::StopAbrupt, next, hand_overs);
            }
            TickCommand::Abort => {
                self.lasers.abort(next);
                self.brake(Brake::All, StopReason::Abort, next, hand_overs);
                self.aborted = self.running();
                self.finish_abort(next);
            }
            TickCommand::NewSession => {
                self.lasers.new_session(next);
                port.forget_plan();
            }
            TickCommand::Supervision(supervision) => self.supervision = supervision,
            TickCommand::Servo { axis, on } => self.servo(axis.mask(), on, next, hand_overs),
            TickCommand::Output { group, mask, value } => {
                if !self.timed.is_empty() {
                    self.timed.forget(group, mask);
                }
                self.output(group, mask, value, next, hand_overs);
            }
            TickCommand::OutputFor { group, bit, high, time } => {
                if !self.timed.takes(group, bit) {
                    let refusal = Event::OutputRefused { lane, seq: entry.seq };
                    return report_event(hand_overs.events, &mut self.events_lost, refusal);
                }
                let mask = 1u64 << (bit & 63);
                self.timed.add(group, bit, !high, Ns(next.0.saturating_add(time.0)));
                self.output(group, mask, if high { mask } else { 0 }, next, hand_overs);
            }
            TickCommand::EdgeCount { input, index, count } => hand_overs.tables.edges.set(input, index, count),
            TickCommand::Analog { channel, value } => {
                port.analog_out(0, channel as usize, value);
                self.record_analog(channel, value, hand_overs.tables.lasers, hand_overs.samples);
            }
            TickCommand::Simulate(input) => {
                if P::SIMULATED {
                    self.simulate(input, port);
                }
            }
            TickCommand::Plan { row, after, of_script, input } => {
                let due = if of_script {
                    InputTime::OfScript(after)
                } else {
                    InputTime::At(Ns(self.now.0.saturating_add(after.0)))
                };
                port.plan(row, due, input);
            }
            TickCommand::Update { axes } => {
                if !self.refused(lane, entry.seq, axes, hand_overs, |_, state| state.refuses_update()) {
                    self.sourced(axes, hand_overs, |state, source| state.update(next, source));
                }
            }
            TickCommand::PtStart { axes, fifo1 } => {
                if !self.refused(lane, entry.seq, axes, hand_overs, |axis, state| state.refuses_pt(fifo1.has(axis))) {
                    self.each(axes, |axis, state| state.start_pt(next, fifo1.has(axis)));
                }
            }
            TickCommand::PvtStart { axes } => {
                let tables = hand_overs.tables;
                if !self.refused(lane, entry.seq, axes, hand_overs, |_, state| state.refuses_pvt(&tables)) {
                    self.each(axes, |_, state| state.start_pvt(next, &tables));
                }
            }
            TickCommand::TickPeriod { ns } => {
                if PERIOD_NS.contains(&ns) && !self.axes.iter().any(AxisState::runs) {
                    *period = Ns(ns as u64);
                }
            }
            TickCommand::Laser { channel, change } => {
                if matches!(change, ChannelChange::Mode { mode: laser::PowerMode::Analog, .. }) {
                    // From here on the laser drives it, and leaves it at 0 V. A channel that is
                    // kept dark does not drive it: what was set before must go.
                    port.analog_out(0, channel as usize, 0);
                    self.record_analog(channel, 0, hand_overs.tables.lasers, hand_overs.samples);
                }
                if self.lasers.change(channel, next, &change) {
                    let refusal = Event::LaserRefused { lane, seq: entry.seq, channel };
                    report_event(hand_overs.events, &mut self.events_lost, refusal);
                }
            }
            TickCommand::FollowEnd { crds } => self.lasers.end_follow(crds, next),
            TickCommand::Link { lost } => {
                // Paths that ran at an abort, or in the session before, do not light again.
                let paths = self.crds.running.0 & !self.lasers.dead().0;
                self.lasers.link(lost, self.script.runs || paths != 0);
                if lost {
                    self.brake(self.supervision.link, StopReason::LinkLoss, next, hand_overs);
                }
            }
            TickCommand::Trace { every, axes, crds, lasers, edges, outputs } => {
                let chosen = Chosen { axes, crds, lasers, edges, outputs };
                if let Some((row, chosen)) = self.trace.begin(every, chosen) {
                    self.trace.record_analog_carried(hand_overs.tables.lasers, hand_overs.samples);
                    self.emit(row, chosen, hand_overs.samples);
                }
            }
            TickCommand::ClearStatus { axes } => {
                self.all(axes, AxisState::clear_status);
                self.lasers.crd_cleared(self.holders(axes), next);
            }
            TickCommand::Zero { axes } => self.renamed(axes, AxisState::zero_position, hand_overs.samples),
            TickCommand::SetPosition { axis, pos } => {
                self.renamed(axis.mask(), |state| state.rename(pos), hand_overs.samples)
            }
            TickCommand::SetEncoder { axis, pulses } => self.one(axis, |state| state.set_encoder(pulses)),
            TickCommand::SetMode { axis, mode } => {
                self.one(axis, |state| state.set_mode(mode));
                self.forget_alarms();
            }
            // An abrupt stop takes no time (SPEC 4), so its deceleration is not used here.
            TickCommand::StopDec { axis, smooth, abrupt: _ } => self.one(axis, |state| state.ramps.stop_dec = smooth),
            TickCommand::Band { axis, band, time } => self.one(axis, |state| state.inputs.set_band(band, time)),
            TickCommand::SoftLimit { axis, positive, negative } => {
                self.crds.invalidate_clearance();
                self.one(axis, |state| {
                    state.inputs.soft_positive = positive;
                    state.inputs.soft_negative = negative;
                    state.set_bounds();
                });
            }
            TickCommand::Guard { axis, on, low } => self.one(axis, |state| state.inputs.guard(on, low)),
            TickCommand::PositionError { axis, limit } => self.one(axis, |state| state.inputs.error_limit = limit),
            TickCommand::Capture { axis, mode } => {
                self.one(axis, |state| state.arm(mode));
                self.indexed.0 |= axis.mask().0;
            }
            TickCommand::JogPrm { axis, acc, dec, smooth } => {
                self.one(axis, |state| state.ramps.jog = Jog { acc, dec, smooth })
            }
            TickCommand::TrapPrm { axis, acc, dec, vel_start, smooth } => self.one(axis, |state| {
                (state.ramps.trap.acc, state.ramps.trap.dec) = (acc, dec);
                (state.ramps.trap.vel_start, state.ramps.trap.smooth) = (vel_start, smooth);
            }),
            TickCommand::TargetSpeed { axis, speed } => self.one(axis, |state| state.ramps.trap.speed = speed),
            TickCommand::TargetPosition { axis, pulses } => self.one(axis, |state| state.ramps.trap.target = pulses),
            TickCommand::PtCommit { axis, fifo, end, epoch } => {
                let mut counts = true;
                self.one(axis, |state| counts = state.commit(fifo, end, epoch));
                if !counts {
                    self.report_void((lane, entry.seq), axis, hand_overs);
                }
            }
            TickCommand::PtClear { axis, fifo } => self.one(axis, |state| state.clear_fifo(fifo)),
            TickCommand::PvtSelect { axis, table } => self.one(axis, |state| state.select(table)),
            TickCommand::PvtLoop { axis, passes } => self.one(axis, |state| state.set_table_passes(passes)),
            TickCommand::FollowDirection { axis, direction } => self.one(axis, |state| state.set_direction(direction)),
            TickCommand::FollowMaster { axis, master } => self.one(axis, |state| state.follow.master = Some(master)),
            TickCommand::FollowEvent { axis, event } => self.one(axis, |state| state.follow.event = event),
            TickCommand::FollowLoop { axis, passes } => self.one(axis, |state| state.set_follow_passes(passes)),
            TickCommand::FollowCommit { axis, fifo, end, cleared, tail } => {
                let mut counts = true;
                if let Some(store) = hand_overs.segments.get(axis.index()) {
                    self.one(axis, |state| counts = state.commit_entries(fifo, end, cleared, tail, store));
                }
                if !counts {
                    self.report_void((lane, entry.seq), axis, hand_overs);
                }
            }
            TickCommand::FollowClear { axis, fifo } => self.one(axis, |state| state.clear_entries(fifo)),
            TickCommand::GearRatio { axis, ratio } => self.one(axis, |state| state.set_gear(ratio)),
            TickCommand::FollowStart { axes, fifo1 } => {
                if !self.refused(lane, entry.seq, axes, hand_overs, |axis, state| state.refuses_follow(fifo1.has(axis)))
                {
                    self.each(axes, |axis, state| state.start_follow(next, fifo1.has(axis)));
                    self.renew_order();
                }
            }
            TickCommand::FollowSwitch { axes } => {
                if !self.refused(lane, entry.seq, axes, hand_overs, |_, state| state.refuses_switch(true)) {
                    self.each(axes, |_, state| state.switch());
                }
            }
            TickCommand::FollowSwitchNow { axis, method } => {
                let table = method == Method::Table;
                if !self.refused(lane, entry.seq, axis.mask(), hand_overs, |_, state| state.refuses_switch(table)) {
                    self.one(axis, |state| state.switch_now(method));
                }
            }
            TickCommand::PtLoop { axis, passes } => self.one(axis, |state| state.set_passes(passes)),
            TickCommand::CrdFrame { crd, frame } => self.set_frame(crd, frame, next, hand_overs.paths),
            TickCommand::CrdCommit { crd, fifo, end, cleared } => self.commit_path(crd, fifo, end, cleared),
            TickCommand::CrdClear { crd, fifo } => self.clear_path(crd, fifo, next),
            TickCommand::CrdStart { crds, fifo1 } => self.start_crds((lane, entry.seq), crds, fifo1, next, hand_overs),
            TickCommand::CrdStopDec { crd, dec } => self.set_crd_stop(crd, dec),
            TickCommand::CrdOverride { crd, rate } => self.set_override(crd, rate, next, hand_overs),
            TickCommand::CrdLag { crd, lag } => self.set_encoder_lag(crd, lag),
        }
    }

    /// An input of a machine without wires changes with the tick computed. That tick shows it and
    /// ends the waits for it; the interrupt of that tick samples it for everything else.
    #[inline(never)]
    /// Outputs of a group get the levels of `value` where `mask` is set.
    fn output(&mut self, group: DoGroup, mask: u64, value: u64, next: Ns, hand_overs: &mut HandOvers<AXES>) {
        match group {
            DoGroup::Enable => {
                self.servo(AxisMask(mask & value), true, next, hand_overs);
                self.servo(AxisMask(mask & !value), false, next, hand_overs);
            }
            DoGroup::Clear => self.clear = self.clear & !mask | value & mask,
            DoGroup::General => {
                self.general = self.general & !(mask as GeneralOutputs) | (value & mask) as GeneralOutputs;
            }
        }
    }

    pub(crate) fn simulate(&mut self, input: Simulated, port: &mut impl Port) {
        port.simulate(input);
        if let Simulated::Level { input, index, .. } = input
            && input != Input::General
            && let Some(axis) = Axis::new(index as usize)
        {
            let levels = port.inputs(axis);
            self.one(axis, |state| state.raw = levels);
        }
    }

    #[inline(always)]
    fn one(&mut self, axis: Axis, change: impl FnOnce(&mut AxisState)) {
        if let Some(state) = self.axes.get_mut(axis.index()) {
            change(state);
            state.mark_changed();
        }
    }

    /// An axis at standstill gets its power-on state.
    pub(crate) fn reset_axis(&mut self, axis: Axis, samples: &mut TraceSamples) {
        self.name(axis.mask(), AxisState::reset, samples);
    }

    fn all(&mut self, axes: AxisMask, change: impl Fn(&mut AxisState)) {
        self.each(axes, |_, state| {
            change(state);
            state.mark_changed();
        });
    }

    /// The axes of a mask that are in use.
    #[inline(always)]
    fn each(&mut self, axes: AxisMask, mut visit: impl FnMut(Axis, &mut AxisState)) {
        for axis in self.in_use(axes).axes() {
            if let Some(state) = self.axes.get_mut(axis.index()) {
                visit(axis, state);
            }
        }
    }

    /// The same, with what their motion is read from.
    #[inline(always)]
    fn sourced(
        &mut self,
        axes: AxisMask,
        hand_overs: &HandOvers<AXES>,
        mut visit: impl FnMut(&mut AxisState, &MotionSource),
    ) {
        self.each(axes, |axis, state| {
            if let Some(source) = hand_overs.source(axis) {
                visit(state, &source);
            }
        });
    }

    /// The same where positions get other user values.
    fn renamed(&mut self, axes: AxisMask, change: impl Fn(&mut AxisState), samples: &mut TraceSamples) {
        self.name(axes, change, samples);
        self.rename_crds();
    }

    /// Each axis by itself.
    fn name(&mut self, axes: AxisMask, change: impl Fn(&mut AxisState), samples: &mut TraceSamples) {
        for axis in self.in_use(axes).axes() {
            let Some(state) = self.axes.get_mut(axis.index()) else { continue };
            let before = state.zero();
            change(state);
            state.mark_changed();
            self.trace.record_name(axis, Pos(state.zero().0.wrapping_sub(before.0)), samples);
        }
    }

    /// The axes of a mask that are in use.
    pub(crate) fn in_use(&self, axes: AxisMask) -> AxisMask {
        AxisMask(axes.0 & (1u64 << self.used).wrapping_sub(1))
    }

    /// Axes brake with their stop decelerations.
    fn brake_axes(&mut self, axes: AxisMask, reason: StopReason, next: Ns, hand_overs: &mut HandOvers<AXES>) {
        for axis in self.in_use(axes).axes() {
            if let Some(state) = self.axes.get_mut(axis.index())
                && let Some(source) = hand_overs.source(axis)
                && let Some(reason) = state.stop_smooth(next, reason, &source)
            {
                report_event(hand_overs.events, &mut self.events_lost, Event::Stopped { axis, reason, now: next });
            }
        }
    }

    /// Motion brakes: coordinate systems along their paths, axes with their stop decelerations.
    pub(crate) fn brake(&mut self, which: Brake, reason: StopReason, next: Ns, hand_overs: &mut HandOvers<AXES>) {
        let all = self.in_use(AxisMask(u64::MAX));
        let axes = match which {
            Brake::None => return,
            Brake::JogAndPaths => {
                let jogs = |axis: &Axis| {
                    self.axes.get(axis.index()).is_some_and(|state| state.published.mode == MotionMode::Jog)
                };
                AxisMask(all.axes().filter(jogs).fold(0, |mask, axis| mask | axis.mask().0))
            }
            Brake::All => all,
            Brake::AbruptAll => {
                self.stop_crds(self.crds.running, Halt::Abrupt, reason, next, hand_overs);
                return self.halt(all, reason, next, hand_overs);
            }
        };
        self.lasers.crd_stops(self.crds.running, next);
        self.stop_crds(self.crds.running, Halt::Smooth, reason, next, hand_overs);
        self.brake_axes(axes, reason, next, hand_overs);
    }

    /// Everything that runs.
    fn running(&self) -> (AxisMask, CrdMask) {
        let running = |(axis, state): (Axis, &AxisState)| if state.runs() { axis.mask().0 } else { 0 };
        let axes = Axis::all().zip(&self.axes).map(running).fold(0, |mask, bit| mask | bit);
        (AxisMask(axes), self.crds.running)
    }

    /// What ran at an abort and is at standstill now no longer counts; once all of it is, the abort
    /// is over.
    #[inline(never)]
    pub(crate) fn finish_abort(&mut self, next: Ns) {
        let (axes, crds) = self.running();
        let (before, paths) = self.aborted;
        self.aborted = (AxisMask(before.0 & axes.0), CrdMask(paths.0 & crds.0));
        self.aborts = self.aborted.0.0 | self.aborted.1.0 as u64 != 0;
        if !self.aborts {
            self.lasers.abort_over(next);
        }
    }

    /// Stops axes at their present positions, and the paths that drive them.
    pub(crate) fn halt(&mut self, axes: AxisMask, reason: StopReason, next: Ns, hand_overs: &mut HandOvers<AXES>) {
        self.stop_crds(self.drivers(axes), Halt::Abrupt, reason, next, hand_overs);
        for axis in self.in_use(axes).axes() {
            if let Some(state) = self.axes.get_mut(axis.index())
                && state.runs()
                && state.driver().is_none()
            {
                state.halt(next, reason);
                report_event(hand_overs.events, &mut self.events_lost, Event::Stopped { axis, reason, now: next });
            }
        }
    }

    pub(crate) fn servo(&mut self, axes: AxisMask, on: bool, next: Ns, hand_overs: &mut HandOvers<AXES>) {
        if !on {
            self.darken(axes);
            self.halt(axes, StopReason::ServoOff, next, hand_overs);
        }
        self.enable = if on { self.enable | self.in_use(axes).0 } else { self.enable & !axes.0 };
        self.all(axes, |state| state.servo_on = on);
    }

    /// The stream or filling of a commit has ended meanwhile: its data is lost, and that is
    /// reported.
    #[cold]
    #[inline(never)]
    fn report_void(&mut self, (lane, seq): (Lane, u32), axis: Axis, hand_overs: &mut HandOvers<AXES>) {
        let status = self.axes.get(axis.index()).map_or(0, AxisState::status);
        report_event(hand_overs.events, &mut self.events_lost, Event::Refused { lane, seq, axis, status });
    }

    /// Whether one axis of the mask forbids the start; then that is reported, and none starts.
    fn refused(
        &mut self,
        lane: Lane,
        seq: u32,
        axes: AxisMask,
        hand_overs: &mut HandOvers<AXES>,
        forbids: impl Fn(Axis, &AxisState) -> bool,
    ) -> bool {
        let mut states = self.in_use(axes).axes().filter_map(|axis| Some((axis, self.axes.get(axis.index())?)));
        let Some((axis, state)) = states.find(|(axis, state)| forbids(*axis, state)) else { return false };
        let refusal = Event::Refused { lane, seq, axis, status: state.status() };
        report_event(hand_overs.events, &mut self.events_lost, refusal);
        true
    }
}
