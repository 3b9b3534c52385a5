//! What tick commands do to coordinate systems: set, clear, start, stop.
//!
//! In: admitted tick commands, the present state of the axes. Out: changed state, events. Owns
//! nothing. Fails: a start that the state of a coordinate system or an axis forbids starts none of
//! its mask, and is reported. Anything else that no longer fits has no effect.
use super::effects::PathEffects;
use super::{AxisIndices, AxisMap, Clearance, CrdState, PREPARE_AFTER_SCANS};
use crate::laser::{Cause, EncoderSpeed, FilterRate, PathRun};
use crate::path::{DIMENSIONS, EntryStore, FifoEnds, Path, PathPos, PathSettings, PathStores};
use crate::segment::piece::Scaled;
use crate::segment::ramp::Accel;
use crate::status;
use crate::tick::hand_overs::HandOvers;
use crate::tick::{Tick, report_event};
use crate::tick_command::Lane;
use crate::units::{AxisMask, Crd, CrdMask, Exact, Ns, Pos};
use crate::view::{CrdView, DrivenBy, Event, StopReason};

/// The furthest from its zero, on every axis, that a path may begin: as far as targets may lie.
const BEGIN_MAX_RAW: u64 = 1 << (31 + Pos::FRAC_BITS);

/// The cause that fresh causes of latched bits are for light.
fn cause_of(fresh: u32) -> Option<Cause> {
    match fresh {
        0 => None,
        _ if fresh & status::ALARM != 0 => Some(Cause::Alarm),
        _ if fresh & status::LIMITS != 0 => Some(Cause::Limit),
        _ => Some(Cause::Fault),
    }
}

/// Whether what stopped a path is a fault (SPEC 9), not a command.
pub(super) fn is_fault(reason: StopReason) -> bool {
    use StopReason::{Abort, Completed, Interlock, LinkLoss, None, Reset, StopAbrupt, StopSmooth};
    !matches!(reason, None | Completed | StopSmooth | StopAbrupt | LinkLoss | Reset | Abort | Interlock)
}

/// How a path stops.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Halt {
    /// Along the path.
    Smooth,
    /// At once: the tick computed keeps the set-point of the tick before (SPEC 4).
    Abrupt,
    /// At once, at the position of its step.
    Here,
}

impl<const AXES: usize> Tick<AXES> {
    /// SetCrdPrm, at standstill.
    pub(crate) fn set_frame(&mut self, crd: Crd, frame: AxisMap, next: Ns, paths: PathStores) {
        let axes = frame.mask();
        let known = paths.get(crd.index()).is_some() && axes.0 & !self.in_use(axes).0 == 0;
        let moving =
            |mask: AxisMask| mask.axes().any(|axis| self.axes.get(axis.index()).is_none_or(|axis| axis.runs()));
        if !known || self.crds.running.has(crd) || moving(axes) {
            return;
        }
        self.drop_frame(crd);
        (0..2).for_each(|fifo| self.lasers.fifo_cleared(PathRun { crd, fifo }, next));
        let mut taken = false;
        for axis in axes.axes() {
            if let Some(state) = self.axes.get_mut(axis.index()) {
                taken |= state.crd.is_some_and(|other| other != crd && state.is_mapped(other));
                state.map(crd);
            }
        }
        let mut origin = frame.origin.unwrap_or_default().map(Pos::pulses);
        if frame.origin.is_none() {
            for (origin, axis) in origin.iter_mut().zip(frame.axes) {
                *origin = axis.and_then(|axis| self.axes.get(axis.index())).map_or(Pos(0), |state| state.published.pos);
            }
        }
        if let Some(state) = self.crds.get_mut(crd) {
            state.path.rules = PathSettings::POWER_ON;
            state.path.rules.set_even(frame.even_ms);
            state.encoders = EncoderSpeed::POWER_ON;
            (state.published.frame, state.published.origin, state.axis_indices) =
                (Some(frame), origin, frame.axis_indices);
        }
        self.rename_crd(crd);
        // Nothing changes for the others, if no axis was theirs.
        let all = taken || self.crds.alarms.0 != 0;
        self.report_causes_of(if all { CrdMask(u8::MAX) } else { crd.mask() });
    }

    /// A coordinate system drives nothing from now on; its axes are in Trap mode.
    fn drop_frame(&mut self, crd: Crd) {
        let Some(state) = self.crds.get_mut(crd) else { return };
        let mapped = state.published.frame.map_or(AxisMask(0), |frame| frame.mask());
        // In place: a whole state is some kilobytes. The pattern names the fields that stay.
        let CrdState {
            published: _,
            geared,
            axis_indices,
            awaited,
            clearance: _,
            path,
            likely,
            scans: _,
            ending,
            standstill_since: _,
            obstacle,
            encoders,
        } = state;
        (*geared, *axis_indices, *awaited, *likely) = (AxisMask(0), AxisIndices::NONE, None, 0);
        (*ending, *obstacle) = (StopReason::None, None);
        path.position([Pos(0); DIMENSIONS]);
        path.rules = PathSettings::POWER_ON;
        *encoders = EncoderSpeed::POWER_ON;
        state.published.drop_frame();
        state.mark_changed();
        for axis in mapped.axes() {
            if let Some(state) = self.axes.get_mut(axis.index())
                && state.is_mapped(crd)
            {
                state.unmap();
            }
        }
    }

    /// Axes are reset: no coordinate system drives them any more.
    pub(crate) fn drop_frames(&mut self, axes: AxisMask) {
        for crd in Crd::all() {
            let frame = self.crds.get(crd).and_then(|state| state.published.frame);
            if frame.is_some_and(|frame| frame.mask().0 & axes.0 != 0) {
                self.drop_frame(crd);
            }
        }
    }

    /// Axes at standstill may have other user positions now, and so the position of a path.
    pub(crate) fn rename_crds(&mut self) {
        Crd::all().for_each(|crd| self.rename_crd(crd));
    }

    /// The position of a coordinate system at the set-points of its axes.
    fn position_of(&self, crd: Crd) -> PathPos {
        let mut here = [Pos(0); DIMENSIONS];
        let Some(state) = self.crds.get(crd) else { return here };
        let Some(frame) = &state.published.frame else { return here };
        for ((here, axis), origin) in here.iter_mut().zip(&frame.axes).zip(&state.published.origin) {
            if let Some(axis) = axis.and_then(|axis| self.axes.get(axis.index())) {
                *here = Pos(axis.published.pos.0.wrapping_sub(origin.0));
            }
        }
        here
    }

    fn rename_crd(&mut self, crd: Crd) {
        if self.crds.running.has(crd) || self.crds.get(crd).is_none_or(|state| state.published.frame.is_none()) {
            return;
        }
        let here = self.position_of(crd);
        let Tick { crds, .. } = self;
        let Some(state) = crds.states.get_mut(crd.index()) else { return };
        if here != state.path.here() {
            state.path.rename(here);
            (state.scans, crds.unprepared.0) = (PREPARE_AFTER_SCANS, crds.unprepared.0 | crd.mask().0);
        }
        if here != state.published.position {
            state.published.position = here;
            state.mark_changed();
            crds.version = crds.version.wrapping_add(1);
        }
    }

    /// A FIFO has this many entries now.
    pub(crate) fn commit_path(&mut self, crd: Crd, fifo: u8, end: u32, cleared: u32) {
        if let Some(state) = self.crds.get_mut(crd) {
            let index = (fifo & 1) as usize;
            if state.published.cleared[index] == cleared {
                (state.published.ends[index], state.likely) = (end, fifo);
                state.mark_changed();
            }
        }
    }

    /// Empties a FIFO, at standstill.
    pub(crate) fn clear_path(&mut self, crd: Crd, fifo: u8, next: Ns) {
        if self.crds.running.has(crd) {
            return;
        }
        self.lasers.fifo_cleared(PathRun { crd, fifo }, next);
        if let Some(state) = self.crds.get_mut(crd) {
            state.path.clear(fifo);
            let (index, CrdView { ends, cleared, done, released, .. }) = ((fifo & 1) as usize, &mut state.published);
            (ends[index], done[index], released[index]) = (0, 0, 0);
            cleared[index] = cleared[index].wrapping_add(1);
            state.mark_changed();
        }
    }

    /// These begin, or go on, with the tick at `next`, or none does.
    pub(crate) fn start_crds(
        &mut self,
        (lane, seq): (Lane, u32),
        crds: CrdMask,
        fifo1: CrdMask,
        next: Ns,
        hand_overs: &mut HandOvers<AXES>,
    ) {
        if let Some(refusal) = crds.crds().find_map(|crd| self.refuses_crd(crd, fifo1.has(crd) as u8, lane, seq)) {
            report_event(hand_overs.events, &mut self.events_lost, refusal);
            return;
        }
        for crd in crds.crds() {
            let fifo = fifo1.has(crd) as u8;
            let (Some(source), Some(state)) =
                (hand_overs.paths.get(crd.index()), self.crds.states.get_mut(crd.index()))
            else {
                continue;
            };
            let feed = state.feed();
            self.lasers.crd_starts(PathRun { crd, fifo }, next, state.path.continues(fifo));
            state.path.start(next, fifo, feed, source);
            state.clearance = [Clearance::Unknown; 2];
            state.encoders.begin(next);
            (state.ending, state.published.runs, state.awaited) = (StopReason::StopSmooth, true, None);
            state.mark_changed();
            let frame = state.published.frame;
            for (index, axis) in frame.iter().flat_map(|frame| frame.axes).enumerate() {
                if let Some(axis) = axis.and_then(|axis| self.axes.get_mut(axis.index())) {
                    let base = axis.base();
                    axis.engage(DrivenBy::Coordinate { crd, index: index as u8 }, base);
                }
            }
            // A geared axis of a motion that was interrupted goes on from its present position.
            for (axis, by) in state.path.gears(fifo) {
                if let Some(axis_state) = self.axes.get_mut(axis.index()) {
                    let Exact(here) = axis_state.base();
                    let Exact(gone) = by.into();
                    axis_state.engage(DrivenBy::Gear { crd, ratio: Scaled::default() }, Exact(here.wrapping_sub(gone)));
                    state.geared.0 |= axis.mask().0;
                }
            }
            self.crds.running.0 |= crd.mask().0;
            self.crds.version = self.crds.version.wrapping_add(1);
        }
    }

    /// Why a coordinate system must not start.
    fn refuses_crd(&self, crd: Crd, fifo: u8, lane: Lane, seq: u32) -> Option<Event> {
        let refused = Some(Event::CrdRefused { lane, seq, crd });
        let Some(state) = self.crds.get(crd) else { return refused };
        let Some(frame) = state.published.frame else { return refused };
        for axis in frame.axes.into_iter().flatten() {
            let Some(axis_state) = self.axes.get(axis.index()) else { return refused };
            if !axis_state.is_mapped(crd) {
                return refused;
            }
            if axis_state.refuses_start() {
                return Some(Event::Refused { lane, seq, axis, status: axis_state.status() });
            }
        }
        for (axis, _) in state.path.gears(fifo) {
            let Some(axis_state) = self.axes.get(axis.index()) else { return refused };
            if axis_state.refuses_gear() {
                return Some(Event::Refused { lane, seq, axis, status: axis_state.status() });
            }
        }
        let far = state.path.here().iter().any(|at| at.0.unsigned_abs() > BEGIN_MAX_RAW);
        let paths = &state.path;
        if far || paths.refuses_start(fifo, state.feed()) { refused } else { None }
    }

    /// Causes of latched bits have changed, for axes that may be mapped: channels mapped to those
    /// take note.
    #[inline(never)]
    pub(crate) fn report_causes(&mut self) {
        self.report_causes_of(CrdMask(u8::MAX));
    }

    /// An axis with an alarm may have left its coordinate system.
    pub(crate) fn forget_alarms(&mut self) {
        if self.crds.alarms.0 != 0 {
            self.report_causes();
        }
    }

    /// The same for some of them.
    fn report_causes_of(&mut self, crds: CrdMask) {
        for (crd, state) in Crd::all().zip(&mut self.crds.states).filter(|(crd, _)| crds.has(*crd)) {
            state.clearance = [Clearance::Unknown; 2];
            self.crds.alarms.0 &= !crd.mask().0;
            let Some(frame) = &state.published.frame else { continue };
            for axis in frame.axes.iter().flatten() {
                let Some(axis) = self.axes.get_mut(axis.index()).filter(|axis| axis.is_mapped(crd)) else { continue };
                let (causes, fresh) = axis.take_causes();
                if causes & status::ALARM != 0 {
                    self.crds.alarms.0 |= crd.mask().0;
                }
                if let Some(cause) = cause_of(fresh) {
                    self.lasers.crd_fault(crd, cause);
                }
            }
        }
        self.lasers.crd_alarms(self.crds.alarms);
    }

    /// Servos go off: channels mapped to the coordinate systems of these axes go dark.
    pub(crate) fn darken(&mut self, axes: AxisMask) {
        for axis in axes.axes().filter_map(|axis| self.axes.get(axis.index())) {
            if let Some(crd) = axis.crd.filter(|crd| axis.servo_on && axis.is_mapped(*crd)) {
                self.lasers.crd_fault(crd, Cause::ServoOff);
            }
        }
    }

    /// The coordinate systems that some of these axes are mapped to.
    pub(crate) fn holders(&self, axes: AxisMask) -> CrdMask {
        let crds = axes.axes().filter_map(|axis| {
            let axis = self.axes.get(axis.index())?;
            axis.crd.filter(|crd| axis.is_mapped(*crd))
        });
        CrdMask(crds.fold(0, |mask, crd| mask | crd.mask().0))
    }

    /// The coordinate systems that drive some of these axes.
    pub(crate) fn drivers(&self, axes: AxisMask) -> CrdMask {
        if self.crds.running.0 == 0 {
            return CrdMask(0);
        }
        let driver = |axis: crate::units::Axis| self.axes.get(axis.index())?.driver();
        CrdMask(axes.axes().filter_map(driver).fold(0, |mask, crd| mask | crd.mask().0))
    }

    /// These stop, for this reason. One that already brakes along its path goes on braking, unless
    /// it has to stop at once.
    pub(crate) fn stop_crds(
        &mut self,
        crds: CrdMask,
        halt: Halt,
        reason: StopReason,
        next: Ns,
        hand_overs: &mut HandOvers<AXES>,
    ) {
        let running = CrdMask(crds.0 & self.crds.running.0);
        for crd in running.crds() {
            let published = self.position_of(crd);
            self.with_path(crd, next, hand_overs, |path, ending, feed, source, sink| {
                if halt == Halt::Smooth && path.stops() {
                    return;
                }
                (*ending, sink.fault) = (reason, is_fault(reason));
                match halt {
                    Halt::Smooth => path.stop(next, false, feed, source, sink),
                    Halt::Here => path.stop(next, true, feed, source, sink),
                    Halt::Abrupt => path.stand_still(next, &published, feed, sink),
                }
            });
        }
    }

    /// The filter of its encoders' speed.
    pub(crate) fn set_encoder_lag(&mut self, crd: Crd, lag: FilterRate) {
        if let Some(state) = self.crds.get_mut(crd) {
            state.encoders.set(lag);
        }
    }

    /// Stop deceleration.
    pub(crate) fn set_crd_stop(&mut self, crd: Crd, dec: Accel) {
        if let Some(state) = self.crds.get_mut(crd) {
            state.path.rules.set_stop(dec);
        }
    }

    /// Runs `act` on a path, with a [`PathEffects`] for its effects.
    pub(super) fn with_path(
        &mut self,
        crd: Crd,
        next: Ns,
        hand_overs: &HandOvers<AXES>,
        act: impl FnOnce(&mut Path, &mut StopReason, FifoEnds, &[EntryStore; 2], &mut PathEffects),
    ) {
        let step_limit = self.step_limit;
        let Tick { crds, axes, edges, lasers, .. } = self;
        let (Some(state), Some(source)) = (crds.states.get_mut(crd.index()), hand_overs.paths.get(crd.index())) else {
            return;
        };
        let feed = state.feed();
        let Some(frame) = &state.published.frame else { return };
        let mut sink = PathEffects::new(
            (crd, state.path.fifo()),
            (next, step_limit),
            (frame, &state.published.origin),
            (axes, edges, lasers),
            (hand_overs.segments, hand_overs.tables),
            (state.geared, state.awaited),
        );
        act(&mut state.path, &mut state.ending, feed, source, &mut sink);
        if let Some(path_stop) = sink.path_stop {
            state.published.path_stop = path_stop;
        }
    }
}
