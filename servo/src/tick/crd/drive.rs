//! A tick of the running coordinate systems, before that of the axes.
//!
//! In: the axes as the tick in force left them, entries. Out: the positions of the mapped axes at
//! the tick computed, the effects of entries until the one after. Owns nothing. Cannot fail: what
//! must not go on stops, and the reason is latched.
use super::effects::PathEffects;
use super::path_soft_limits::is_free;
use super::{Clearance, CrdState, Halt};
use crate::axis::AxisState;
use crate::laser::{Cause, FollowedSpeeds};
use crate::path::{EntryStore, FifoEnds, PathPos, PathReport, PathStop};
use crate::segment::piece::Scaled;
use crate::tick::hand_overs::HandOvers;
use crate::tick::{Tick, report_event};
use crate::units::{Axis, AxisMask, Crd, CrdMask, Exact, Ns, Pos};
use crate::view::{CrdView, DrivenBy, Event, StopReason};

impl CrdState {
    /// Whether one of its axes has slaves.
    #[inline(always)]
    fn has_slaves(&self, masters: AxisMask) -> bool {
        self.published.frame.is_some_and(|frame| masters.0 & frame.mask().0 != 0)
    }

    /// The fast path: on to the next position, and over boundaries that concern only the path, if
    /// no limit is in the way.
    ///
    /// A function of its own, so that nothing else takes up registers.
    #[inline(never)]
    fn fast_step(&mut self, axes: &mut [AxisState], next: Ns, until: Ns) -> StepResult {
        if !self.path.may_step_fast(self.feed()) {
            return StepResult::Nowhere;
        }
        let mut result = StepResult::Along;
        let spot = loop {
            if let Some(spot) = self.path.spot(next) {
                break spot;
            }
            if result == StepResult::Over || !self.path.is_over(next) || !self.turn_up_to(axes) {
                return StepResult::Nowhere;
            }
            result = StepResult::Over;
        };
        if self.path.is_fresh() {
            let counts = self.path.counts();
            self.publish_fresh(counts);
        }
        let (axis_indices, CrdView { origin, position, heading, bend, motion, piece_version, version, .. }) =
            (&self.axis_indices, &mut self.published);
        let mut report = PathReport { position, heading, bend, motion, piece_version };
        let displacement = self.path.publish_at(spot, &mut report);
        let [clearance, _] = self.clearance;
        if clearance != Clearance::Wide && !is_free(axis_indices, origin, position, axes) {
            return StepResult::Nowhere;
        }
        self.path.pass(displacement);
        axis_indices.all(|index, axis| {
            if let (Some(axis), Some(at), Some(origin)) = (axes.get_mut(axis), position.get(index), origin.get(index)) {
                axis.drive(Pos(at.0.wrapping_add(origin.0)));
            }
            true
        });
        *version = version.wrapping_add(1);
        if self.path.is_due_until(until) {
            if !self.turn_after(axes, until) {
                return StepResult::Short;
            }
            result = StepResult::Over;
        }
        result
    }

    /// Over the one boundary that lies between the tick computed and the one at `until`, if nothing
    /// else is to be done.
    #[inline(never)]
    fn turn_after(&mut self, axes: &[AxisState], until: Ns) -> bool {
        if self.turn::<true>(axes).is_none() || self.path.is_due_until(until) {
            return false;
        }
        self.published.piece_version = self.published.piece_version.wrapping_add(1);
        true
    }

    /// Over the boundary that lies at the tick computed or before it, if nothing else is to be
    /// done; publishes what is new but the position.
    #[inline(never)]
    fn turn_up_to(&mut self, axes: &[AxisState]) -> bool {
        let Some(counts) = self.turn::<false>(axes) else { return false };
        self.update_view(counts);
        true
    }

    /// Publishes what is new but the position.
    #[inline(never)]
    fn publish_fresh(&mut self, counts: [u32; 2]) {
        self.update_view(counts);
    }

    #[inline(always)]
    fn update_view(&mut self, [now, motions]: [u32; 2]) {
        let CrdView { position, heading, bend, motion, piece_version, fifo, released, done, .. } = &mut self.published;
        self.path.publish_fresh(&mut PathReport { position, heading, bend, motion, piece_version });
        *fifo = self.path.fifo();
        let index = (*fifo & 1) as usize;
        (released[index], done[index]) = (now, motions);
    }

    /// Over a boundary at which the path only goes on, if no limit is in the way. `AFTER`: a
    /// boundary after the tick computed, not one up to it.
    #[inline(always)]
    fn turn<const AFTER: bool>(&mut self, axes: &[AxisState]) -> Option<[u32; 2]> {
        let (feed, over, [clearance, next]) = (self.feed(), self.path.turns_over(), self.clearance);
        let (axis_indices, origin) = (&self.axis_indices, &self.published.origin);
        let free = |end: &PathPos| clearance == Clearance::Wide || is_free(axis_indices, origin, end, axes);
        let counts = self.path.turn_at::<AFTER>(feed, free)?;
        if over {
            self.clearance = [next, Clearance::Unknown];
        }
        Some(counts)
    }

    /// Prepares a part of what follows.
    #[inline(never)]
    fn prepare(&mut self, source: &[EntryStore; 2], axes: &[AxisState]) {
        let before = self.path.turns_over();
        self.path.prepare(self.feed(), source);
        if self.path.turns_over() && !before {
            let clearance = self.clearance_of(true, axes);
            let [_, next] = &mut self.clearance;
            *next = clearance;
        }
    }
}

/// The result of [`CrdState::fast_step`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum StepResult {
    /// More is to be done: it has passed a boundary, or nothing has happened.
    Nowhere,
    /// It is at its position; what lies before the next one needs more than the fast path.
    Short,
    /// It is at its position, and has passed a boundary.
    Over,
    /// It is at its position.
    Along,
}

impl<const AXES: usize> Tick<AXES> {
    /// Every coordinate system that runs takes its step.
    #[inline(never)]
    pub(crate) fn step_crds(&mut self, next: Ns, hand_overs: &mut HandOvers<AXES>) {
        let until = Ns(next.0.wrapping_add(self.period.0));
        let (masters, running) = (self.order.masters, self.crds.running);
        let mut wants = self.lasers.wants();
        self.crds.version = self.crds.version.wrapping_add(1);
        for crd in running.crds() {
            let Some(state) = self.crds.states.get_mut(crd.index()) else { return };
            let has_slaves = masters.0 != 0 && state.has_slaves(masters);
            let result = if has_slaves { StepResult::Nowhere } else { state.fast_step(&mut self.axes, next, until) };
            let used = state.encoders.used;
            // A tick that enters a motion prepares nothing.
            if result != StepResult::Over
                && let Some(now) = self.finish_step(crd, result, next, hand_overs)
            {
                if now != wants {
                    let before = CrdMask(running.0 & crd.mask().0.wrapping_sub(1));
                    self.feed_earlier(before, wants, now, next);
                }
                wants = now;
                continue;
            }
            let measures = wants.encoder.has(crd) | used;
            if measures {
                self.feed_lasers(crd, next, wants, measures);
            } else if wants.planned.has(crd)
                && let Some(state) = self.crds.get(crd)
            {
                self.lasers.feed_planned(crd, state.path.mean(&state.published.motion, next, self.period));
            }
        }
    }

    /// The remaining work for a path that has not passed a boundary on the fast path. Returns what
    /// lasers want after a full step.
    #[inline(never)]
    fn finish_step(
        &mut self,
        crd: Crd,
        result: StepResult,
        next: Ns,
        hand_overs: &mut HandOvers<AXES>,
    ) -> Option<FollowedSpeeds> {
        // If several run, every second one in a tick prepares something.
        let turn = CrdMask(if self.ticks & 1 == 0 { 0x55 } else { 0xaa });
        let prepares = self.crds.running.0.is_power_of_two() || turn.has(crd);
        if result == StepResult::Along {
            let state = self.crds.states.get_mut(crd.index())?;
            if let [Clearance::Unknown, _] = state.clearance {
                state.find_clearance(&self.axes);
            }
            if prepares && let Some(source) = hand_overs.paths.get(crd.index()) {
                state.prepare(source, &self.axes);
            }
            return None;
        }
        if result == StepResult::Nowhere
            && let Some(reason) = self.forbids(crd)
        {
            self.stop_crds(crd.mask(), Halt::Abrupt, reason, next, hand_overs);
        }
        self.walk_crd(crd, next, result == StepResult::Short, prepares, hand_overs);
        Some(self.lasers.wants())
    }

    /// Those whose paths have come to standstill get their state at standstill.
    pub(crate) fn end_crds_at_standstill(&mut self, next: Ns, hand_overs: &mut HandOvers<AXES>) {
        for crd in self.crds.running.crds() {
            if self.crds.get(crd).is_some_and(|state| !state.path.runs()) {
                self.walk_crd(crd, next, false, false, hand_overs);
            }
        }
    }

    /// The reason for which a path must not go on.
    #[inline(never)]
    fn forbids(&self, crd: Crd) -> Option<StopReason> {
        let state = self.crds.get(crd)?;
        let axes = |axis: Axis| self.axes.get(axis.index());
        let frame = state.published.frame?;
        for axis in frame.axes.into_iter().flatten() {
            if let Some(reason) = axes(axis).and_then(AxisState::fault) {
                return Some(reason);
            }
        }
        // What a path waited for is nothing to one that a Stop of this tick has stopped.
        if state.geared.0 | state.awaited.map_or(0, |(axis, _)| axis.mask().0) == 0 || !state.path.runs() {
            return None;
        }
        let others = || state.geared.axes().filter_map(axes);
        if others().any(|axis| axis.fault().is_some() || axis.refuses_start()) {
            return Some(StopReason::OtherAxis);
        }
        let awaited = axes(state.awaited?.0)?;
        (!awaited.runs() && awaited.published.stop != StopReason::Completed).then_some(StopReason::OtherAxis)
    }

    /// The full step, which concerns more than the path itself; `there`: the path is at its
    /// position already.
    #[inline(never)]
    fn walk_crd(&mut self, crd: Crd, next: Ns, there: bool, may_prepare: bool, hand_overs: &mut HandOvers<AXES>) {
        let (period, step_limit) = (self.period, self.step_limit);
        let Tick { crds, axes, edges, lasers, .. } = self;
        let (Some(state), Some(source)) = (crds.states.get_mut(crd.index()), hand_overs.paths.get(crd.index())) else {
            return;
        };
        let published = &mut state.published;
        let Some(frame) = &published.frame else { return };
        let has_slaves = self.order.masters.0 != 0 && self.order.masters.0 & frame.mask().0 != 0;
        state.path.watch(has_slaves);
        let feed = FifoEnds { ends: published.ends };
        let mut sink = PathEffects::new(
            (crd, state.path.fifo()),
            (next, step_limit),
            (frame, &published.origin),
            (axes, edges, lasers),
            (hand_overs.segments, hand_overs.tables),
            (state.geared, state.awaited),
        );
        let mut runs = true;
        if there {
            state.path.go_through(next, period, feed, source, &mut sink);
        } else {
            let CrdView {
                ref mut position, ref mut heading, ref mut bend, ref mut motion, ref mut piece_version, ..
            } = *published;
            let mut report = PathReport { position, heading, bend, motion, piece_version };
            let reported = state.path.advance(next, period, feed, source, &mut sink, &mut report, may_prepare);
            published.done[(reported.fifo & 1) as usize] = reported.done;
            (published.fifo, published.released, runs) = (reported.fifo, reported.released, reported.runs);
        }
        let PathEffects { reported: gone, geared, path_stop, unable, awaited, obstacle, .. } = sink;
        if !there {
            let axes_at = frame.axes.iter().zip(&published.position).zip(&published.origin);
            for (index, ((axis, at), origin)) in axes_at.enumerate() {
                if let Some(axis) = axis.and_then(|axis| axes.get_mut(axis.index())) {
                    let from = axis.set_point();
                    axis.drive(Pos(at.0.wrapping_add(origin.0)));
                    if has_slaves {
                        axis.publish_displacement((self.now, period), from, &state.path.trajectory, (index, *origin));
                    }
                }
            }
        }
        state.geared = geared;
        if awaited.is_some() {
            // A delay that follows is no wait for the axis.
            state.awaited = awaited.filter(|(_, until)| state.path.waits_until() == Some(*until));
        }
        if state.geared.0 != 0 || state.awaited.is_some() {
            state.path.leave_fast_path();
        }
        state.clearance = [Clearance::Unknown; 2];
        published.version = published.version.wrapping_add(1);
        crds.version = crds.version.wrapping_add(1);
        if let Some(path_stop) = path_stop {
            published.path_stop = path_stop;
            state.obstacle = obstacle;
        }
        published.piece_version = published.piece_version.wrapping_add(1);
        let wants = self.lasers.wants();
        let measures = wants.encoder.has(crd) || state.encoders.used;
        if wants.planned.has(crd) || measures {
            // At standstill its speed is 0, though its axes may still settle.
            self.feed_lasers(crd, next, wants, measures && runs);
        }
        if !runs {
            self.come_to_standstill(crd, next, hand_overs);
            return;
        }
        self.release_geared(crd, AxisMask(geared.0 & !gone.0), next);
        if unable.is_some() {
            self.lasers.crd_fault(crd, Cause::Fault);
            self.stop_crds(crd.mask(), Halt::Here, StopReason::OtherAxis, next, hand_overs);
        }
    }

    /// Passes the speed of the path to the channels.
    #[inline(never)]
    fn feed_lasers(&mut self, crd: Crd, next: Ns, wants: FollowedSpeeds, measures: bool) {
        let period = self.period;
        let Some(state) = self.crds.states.get_mut(crd.index()) else { return };
        if wants.planned.has(crd) {
            self.lasers.feed_planned(crd, state.path.mean(&state.published.motion, next, period));
        }
        if measures {
            let mapped = state.published.frame.map_or([None; 4], |frame| frame.axes);
            let gone = mapped.map(|axis| {
                let published = axis.and_then(|axis| self.axes.get(axis.index())).map(|axis| &axis.published);
                published.map_or(0, |published| published.encoder.wrapping_sub(published.encoder_before))
            });
            // Also one that no channel follows yet: an entry within the coming interval may begin a
            // follow.
            let follows = self.lasers.follows_encoders(crd);
            self.lasers.feed_measured(crd, state.encoders.step(gone, (next, period), follows));
        }
    }

    /// Passes the speeds of paths that have taken their step, and that an entry of another path
    /// makes a channel follow.
    #[inline(never)]
    fn feed_earlier(&mut self, crds: CrdMask, before: FollowedSpeeds, now: FollowedSpeeds, next: Ns) {
        let more = |now: CrdMask, before: CrdMask| CrdMask(now.0 & !before.0);
        let wants =
            FollowedSpeeds { planned: more(now.planned, before.planned), encoder: more(now.encoder, before.encoder) };
        for crd in crds.crds() {
            let Some(state) = self.crds.get(crd).filter(|state| state.path.runs()) else { continue };
            let measures = wants.encoder.has(crd) && !state.encoders.used;
            if wants.planned.has(crd) || measures {
                self.feed_lasers(crd, next, wants, measures);
            }
        }
    }

    /// Releases geared axes, whose motion has ended.
    #[inline(always)]
    fn release_geared(&mut self, crd: Crd, left: AxisMask, next: Ns) {
        let Tick { crds, axes, .. } = self;
        let Some(state) = crds.states.get_mut(crd.index()) else { return };
        for axis in left.axes() {
            if let Some(axis) = axes.get_mut(axis.index()) {
                let base = axis.base();
                axis.release(next, base, StopReason::Completed);
            }
        }
        state.geared.0 &= !left.0;
    }

    /// A geared axis of an interrupted motion stays where it is. One whose motion has begun since
    /// the sample before goes there.
    #[inline(never)]
    fn interrupt_geared(&mut self, crd: Crd, reason: StopReason, next: Ns) {
        let Tick { crds, axes, .. } = self;
        let Some(state) = crds.states.get_mut(crd.index()) else { return };
        for (axis, by) in state.path.gears(state.published.fifo) {
            let Some(axis_state) = axes.get_mut(axis.index()) else { continue };
            let begins = !state.geared.has(axis) && by != Pos(0) && !axis_state.refuses_gear();
            if begins {
                let base = axis_state.base();
                axis_state.engage(DrivenBy::Gear { crd, ratio: Scaled::default() }, base);
            }
            if begins || state.geared.has(axis) {
                let (Exact(base), Exact(gone)) = (axis_state.base(), by.into());
                axis_state.release(next, Exact(base.wrapping_add(gone)), reason);
                state.geared.0 &= !axis.mask().0;
            }
        }
        let left = state.geared;
        self.release_geared(crd, left, next);
    }

    /// The path is at standstill.
    #[inline(never)]
    fn come_to_standstill(&mut self, crd: Crd, next: Ns, hand_overs: &mut HandOvers<AXES>) {
        let Tick { crds, axes, lasers, .. } = self;
        let Some(state) = crds.get_mut(crd) else { return };
        // An interrupted FIFO is probably continued: after FIFO 1, the FIFO 0 that it interrupted.
        let (fifo, other) = (state.published.fifo, state.published.fifo ^ 1);
        state.likely = if !state.path.continues(fifo) && state.path.continues(other) { other } else { fifo };
        let reason = match state.published.path_stop {
            PathStop::Never => StopReason::None,
            PathStop::Completed => StopReason::Completed,
            PathStop::Underrun => StopReason::Underrun,
            PathStop::Stopped => state.ending,
            PathStop::Obstructed => state
                .obstacle
                .and_then(|(axis, to)| axes.get_mut(axis.index())?.latch_barrier(to))
                .unwrap_or(StopReason::OtherAxis),
        };
        match reason {
            StopReason::LimitPositive
            | StopReason::LimitNegative
            | StopReason::SoftPositive
            | StopReason::SoftNegative => lasers.crd_fault(crd, Cause::Limit),
            StopReason::Travel | StopReason::OtherAxis => lasers.crd_fault(crd, Cause::Fault),
            _ => {}
        }
        (state.published.runs, state.published.stop, state.standstill_since) = (false, reason, next);
        state.mark_changed();
        self.interrupt_geared(crd, reason, next);
        let Tick { crds, axes, .. } = self;
        let Some(state) = crds.get_mut(crd) else { return };
        for axis in state.published.frame.iter().flat_map(|frame| frame.axes).flatten() {
            if let Some(axis) = axes.get_mut(axis.index()) {
                axis.release_here(next, reason);
            }
        }
        crds.running.0 &= !crd.mask().0;
        report_event(hand_overs.events, &mut self.events_lost, Event::CrdStopped { crd, reason, now: next });
    }
}
