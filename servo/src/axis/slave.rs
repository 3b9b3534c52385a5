//! An axis that follows another one: start, step, stop; and an axis as its slaves see it.
//!
//! In: the master in the tick computed, entries, inputs. Out: as of any axis, and the effects of
//! entries on outputs. Owns: the [`Follower`] in its profile.
use super::inputs::reading;
use super::{AxisState, MotionState, exact};
use crate::math::float::Float;
use crate::segment::follow::{
    FollowContext, FollowEntries, FollowRun, FollowState, Follower, Input, MasterPathKind, MasterPosition,
    MasterSample, Method, OutputActions, PackedWait,
};
use crate::segment::piece::Motion;
use crate::segment::profile::{Generator, MotionData};
use crate::segment::ramp::Moving;
use crate::status;
use crate::tick_command::MotionMode;
use crate::units::{Axis, Ns, Pos, StepLimit};
use crate::view::{AxisView, Lead, StopReason};

impl AxisState {
    /// The slave in it, if it follows.
    #[inline(always)]
    pub(crate) fn follower(&self) -> Option<&Follower> {
        match self.profile.generator() {
            Generator::Follow(follower) if self.state.is_own() => Some(follower),
            _ => None,
        }
    }

    /// Whether it follows.
    #[inline(always)]
    pub(crate) fn follows(&self) -> bool {
        self.follower().is_some()
    }

    /// The axis that it follows, and which value of it.
    pub(crate) fn master(&self) -> Option<(Axis, MasterPosition)> {
        self.follower().map(|follower| (follower.master.axis, follower.master.value))
    }

    /// Whether Follow, FollowEx or Gear must not start.
    pub(crate) fn refuses_follow(&self, fifo1: bool) -> bool {
        if self.published.mode == MotionMode::Gear {
            let ready = self.follow.master.is_some() && self.follow.gear.is_some();
            let goes_on = self.follower().is_some_and(|follower| follower.braking.is_none());
            return self.refuses_start() || !ready || self.runs() && !goes_on;
        }
        let prepared = matches!(self.published.mode, MotionMode::Follow | MotionMode::FollowEx)
            && self.follow.master.is_some()
            && !self.follow.is_empty(fifo1 as u8);
        self.refuses_start() || self.runs() || !prepared
    }

    /// Follow, FollowEx or Gear begins with the tick at `next`; one that is in gear takes its new
    /// ratio.
    pub(crate) fn start_follow(&mut self, next: Ns, fifo1: bool) {
        let Some(master) = self.follow.master else { return };
        if self.published.mode == MotionMode::Gear && self.follows() {
            return self.take_ratio();
        }
        let prepared = matches!(self.profile.prepared(), Some(Generator::Follow(own)) if own.run.fifo == fifo1 as u8);
        if prepared && self.begin_prepared(next) {
            (self.published.passes, self.published.fifo, self.published.switching) = (0, fifo1 as u8, false);
            return;
        }
        let run = FollowRun::begin(&self.follow, self.exact, fifo1 as u8);
        (self.published.passes, self.published.fifo, self.published.switching) = (0, fifo1 as u8, false);
        self.begin(next, Generator::Follow(Follower::new(run, master)));
    }

    /// At standstill, what FollowStart of a FIFO would begin, with its first piece.
    #[inline(never)]
    pub(super) fn follow_prepared(&mut self, source: &(impl MotionData + FollowEntries)) {
        let Some(master) = self.follow.master else { return };
        let fifo = self.follow.is_empty(0) as u8;
        if self.follow.is_empty(fifo) {
            return;
        }
        let (at, feed) = (self.exact, self.feed());
        let AxisState { profile, follow, .. } = self;
        profile.prepare_start(feed, source, |generator| {
            *generator = Generator::Follow(Follower::new(FollowRun::begin(follow, at, fifo), master));
            if let Generator::Follow(follower) = generator {
                follower.run.prepare_start(follow, source);
            }
        });
    }

    /// Whether a switch to the next segment, or with `table` to the other FIFO, must not act: it
    /// does not follow, is being stopped, or has nothing to switch to.
    pub(crate) fn refuses_switch(&self, table: bool) -> bool {
        self.follower()
            .is_none_or(|follower| follower.braking.is_some() || table && self.follow.is_empty(follower.run.fifo ^ 1))
    }

    /// The other FIFO takes over when the present pass ends.
    pub(crate) fn switch(&mut self) {
        if let Some(follower) = self.profile.follower_mut() {
            follower.run.switch();
            self.published.switching = true;
        }
        self.mark_changed();
    }

    /// The next segment or the other FIFO takes over at the tick computed.
    pub(crate) fn switch_now(&mut self, method: Method) {
        if let Some(follower) = self.profile.follower_mut() {
            follower.run.switch_now(method);
        }
    }

    /// The ratio that is set takes over at the tick computed.
    fn take_ratio(&mut self) {
        if let Some(follower) = self.profile.follower_mut() {
            follower.run.take_ratio();
        }
    }

    /// Passes to run; they may change while it runs.
    pub(crate) fn set_follow_passes(&mut self, passes: u32) {
        self.follow.passes = passes;
        self.invalidate_run();
    }

    /// Data or settings have changed.
    pub(super) fn invalidate_run(&mut self) {
        if let Some(follower) = self.profile.follower_mut() {
            follower.run.invalidate_prepared();
        }
    }

    /// Whether the piece after the one in force over the master's progress may still be to be made.
    #[inline(always)]
    pub(crate) fn is_open_run(&self) -> bool {
        self.follower().is_some_and(|follower| follower.run.is_open())
    }

    /// Makes it, in a tick that has time for it.
    pub(crate) fn prepare_run(&mut self, source: &impl FollowEntries) {
        let setup = &self.follow;
        if let Some(follower) = self.profile.follower_mut() {
            follower.run.prepare(setup, source);
        }
    }

    /// The axis as its slaves see it. It has taken its own step of the tick.
    #[inline(always)]
    pub(crate) fn master_sample(&self, value: MasterPosition, now: Ns, period: Ns) -> MasterSample<'_> {
        let (to, named) = match value {
            MasterPosition::Planned | MasterPosition::PlannedFiltered => (self.set_point(), self.zero.0.wrapping_neg()),
            MasterPosition::Encoder | MasterPosition::EncoderFiltered => (reading(self.count()), self.inputs.named()),
        };
        let path = match value {
            MasterPosition::Encoder => MasterPathKind::Straight,
            MasterPosition::PlannedFiltered | MasterPosition::EncoderFiltered => MasterPathKind::Filtered,
            MasterPosition::Planned => self.path(now, self.standstill_since.0 == now.0.wrapping_add(period.0)),
        };
        MasterSample { now, period, to, named, path }
    }

    /// How its planned position came to the present one, in positions of the machine.
    /// `is_at_standstill`: it came to standstill in this tick.
    #[inline(always)]
    fn path(&self, now: Ns, is_at_standstill: bool) -> MasterPathKind<'_> {
        let shift = self.zero.0.wrapping_neg();
        match self.profile.generator() {
            _ if self.state == MotionState::Driven || is_at_standstill && self.published.mode == MotionMode::Crd => {
                self.driven_path()
            }
            Generator::Follow(own) if self.state.is_own() || is_at_standstill => {
                if own.track.is_straight() {
                    MasterPathKind::Straight
                } else {
                    MasterPathKind::Track { along: &own.track, shift }
                }
            }
            _ => MasterPathKind::Pieces { before: self.profile.before(now), piece: self.profile.piece(), shift },
        }
    }

    /// Its position at the tick, if it moved straight there: for its slaves.
    #[inline(always)]
    pub(crate) fn straight(&self, follower: &Follower) -> Option<Pos> {
        match follower.master.value {
            MasterPosition::Encoder => Some(reading(self.count())),
            MasterPosition::Planned => {
                let straight = match self.profile.generator() {
                    _ if self.state == MotionState::Driven => self.is_linear_between_ticks(),
                    Generator::Follow(own) if self.state.is_own() => own.track.is_straight(),
                    _ => follower.knows(self.profile.piece()),
                };
                straight.then(|| self.set_point())
            }
            _ => None,
        }
    }

    /// The position at the tick computed if the master moved straight to `to`; None if more is to
    /// be done. `has_slaves`: it is a master itself. It moves `limit` units of Pos in a tick at
    /// most.
    #[inline(always)]
    pub(crate) fn fast_step(&mut self, to: Pos, period: Ns, has_slaves: bool, limit: u64) -> bool {
        let from = self.published.pos;
        let watched = self.causes.present & status::FAULTS != 0;
        let Some(follower) = self.profile.follower_mut().filter(|_| !watched) else { return false };
        let begin = follower.run.piece.begin;
        let Some((pos, tau)) = follower.fast_step(to, period, has_slaves, from) else { return false };
        let turned = follower.run.piece.begin != begin;
        if !self.bounds.hold(pos) || pos.0.abs_diff(from.0) > limit {
            return false;
        }
        let moving = follower.run.is_moving(to);
        let published = &mut self.published;
        published.version = published.version.wrapping_add(1);
        (published.pos, published.motion.tau, published.master_displacement) = (pos, tau, follower.displacement);
        if turned {
            self.publish_run();
            self.publish_lead();
        } else if moving != published.lead.is_some() {
            self.publish_lead();
        }
        true
    }

    /// The position at the tick computed of an axis that follows; the reason if it comes to
    /// standstill there.
    #[inline(never)]
    pub(crate) fn step_follow(
        &mut self,
        master_sample: &MasterSample,
        has_slaves: bool,
        limit: u64,
        context: (&impl FollowEntries, impl Fn(Input, u8) -> bool, &mut OutputActions),
    ) -> Option<StopReason> {
        let next = Ns(master_sample.now.0.wrapping_add(master_sample.period.0));
        if self.causes.present & status::FAULTS != 0 {
            return Some(self.stopped_by_fault(next));
        }
        let from = self.published.pos;
        let follower = self.profile.follower_mut()?;
        let (source, level, actions) = context;
        let mut context = FollowContext::new(&mut self.follow, source, level, actions);
        let state = follower.step(master_sample, has_slaves, from, &mut context);
        follower.run.find_floor(source);
        let (pos, tau) = follower.run.position();
        self.publish_run();
        match state {
            FollowState::Running => {}
            FollowState::Ended { at } => return Some(self.end_follow(next, at, StopReason::Completed, limit)),
            FollowState::TooFar => {
                self.halt(next, StopReason::StepLimit);
                return Some(StopReason::StepLimit);
            }
            FollowState::TimedOut { at } => return Some(self.end_follow(next, at, StopReason::WaitTimeout, limit)),
        }
        if let Some(reason) = self.obstructed(next, pos, limit) {
            return Some(reason);
        }
        self.published.version = self.published.version.wrapping_add(1);
        (self.published.pos, self.published.motion.tau) = (pos, tau);
        self.publish_lead();
        None
    }

    /// Whether a limit, the edge of travel or the step limit lies between the position in force and
    /// `to`.
    #[inline(always)]
    fn obstructed(&mut self, next: Ns, to: Pos, limit: u64) -> Option<StopReason> {
        if to.0.abs_diff(self.published.pos.0) > limit {
            self.halt(next, StopReason::StepLimit);
            return Some(StopReason::StepLimit);
        }
        if !self.bounds.hold(to) { self.stopped_at_barrier(next, to) } else { None }
    }

    /// What a view publishes of the run.
    #[inline(never)]
    fn publish_run(&mut self) {
        let Some(follower) = self.profile.follower_mut() else { return };
        let run = &mut follower.run;
        let emptied = run.take_emptied();
        let published = &mut self.published;
        published.passes = run.pass;
        let (fifo, switching, waits) = (run.fifo, run.switching, run.awaits());
        if emptied != 0 || (fifo, switching, waits) != (published.fifo, published.switching, published.waits) {
            (published.fifo, published.switching, published.waits) = (fifo, switching, waits);
            for (fifo, count) in published.cleared.iter_mut().enumerate() {
                *count = count.wrapping_add((emptied >> fifo & 1) as u32);
            }
            self.changed();
        }
    }

    /// The axis whose motion makes that of this one in the tick, and the piece over the master's
    /// progress.
    #[inline(never)]
    fn publish_lead(&mut self) {
        let Some(follower) = self.profile.follower_mut() else { return };
        let moving = follower.is_moving();
        let published = &mut self.published;
        published.master_displacement = follower.displacement;
        let motion = if moving { follower.run.piece.motion } else { Motion::STANDSTILL };
        published.motion = Motion { tau: published.motion.tau, ..motion };
        let axis = (follower.master.value == MasterPosition::Planned).then_some(follower.master.axis);
        let run = &follower.run;
        let lead = moving.then_some(Lead { axis, down: run.down, one_way: run.is_one_way() });
        if lead != published.lead {
            published.lead = lead;
            self.changed();
        }
    }

    /// The motion has ended at `at`, if no limit lies before it.
    #[inline(never)]
    fn end_follow(&mut self, next: Ns, at: crate::units::Exact, reason: StopReason, limit: u64) -> StopReason {
        if let Some(reason) = self.obstructed(next, at.round(), limit) {
            return reason;
        }
        self.come_to_standstill(next, at, reason);
        reason
    }

    /// Leaves its master at `next` with its present motion, and brakes. If the next tick would be
    /// too fast it stops instead, and reports that.
    pub(crate) fn brake(
        &mut self,
        next: Ns,
        motion: Motion,
        cause: StopReason,
        limit: StepLimit,
    ) -> Option<StopReason> {
        let from = Moving { pos: exact(self.published.pos), velocity: motion.velocity() };
        // What readers derive is not exact.
        let most = Float::new(false, limit.pulses_per_ms(), 0);
        if most.add(most.scale(-16)).is_less(Float::from_scaled(from.velocity).abs()) {
            self.halt(next, StopReason::StepLimit);
            return Some(StopReason::StepLimit);
        }
        let dec = self.ramps.stop_dec;
        self.leave_master();
        // The slave's own piece ended when it began to follow; the ramp goes on from here.
        self.profile.stand_still(next, self.published.pos);
        self.profile.begin_ramp(next, |run| run.begin_stop(next, from, dec));
        // Its motion has been one over the master's progress; in this tick it is published over
        // time.
        self.published.motion = motion;
        self.set_off(cause);
        None
    }

    /// A view of it catches up. A function of its own, so that only these two take up registers.
    #[inline(never)]
    pub(crate) fn publish(&self, published: &mut AxisView) {
        published.copy_changed(&self.published);
    }

    /// It follows no longer.
    pub(super) fn leave_master(&mut self) {
        (self.published.lead, self.published.master_displacement, self.published.switching) = (None, 0, false);
        self.published.waits = PackedWait::NONE;
    }
}
