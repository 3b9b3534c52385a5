//! An axis in motion: starts and stops, and the step of a tick.
//!
//! In: the instant of the next tick. Out: the planned position there, or the reason for which it
//! has come to standstill. Owns nothing beyond the axis's
//! [`Profile`](crate::segment::profile::Profile).
use super::{AxisState, Jog, MotionState, Ramps, exact, pt_state};
use crate::segment::generator_state::GeneratorState;
use crate::segment::piece::{Motion, Scaled};
use crate::segment::profile::{Generator, MotionData};
use crate::segment::ramp::Moving;
use crate::status;
use crate::tick_command::MotionMode;
use crate::units::{Exact, Ns, Pos};
use crate::view::{AxisView, StopReason};

impl AxisState {
    /// Whether Jog or Trap must not begin or change, also because it would move towards an active
    /// limit.
    pub(crate) fn refuses_update(&self) -> bool {
        let direction = match self.published.mode {
            MotionMode::Jog => self.ramps.trap.speed.signum(),
            MotionMode::Trap => Pos::pulses(self.ramps.trap.target).0.saturating_sub(self.published.pos.0).signum(),
            _ => return true,
        };
        let inputs = &self.inputs;
        let at_soft = if direction > 0 {
            inputs.soft_positive.is_some_and(|limit| self.published.pos >= Pos::pulses(limit))
        } else {
            inputs.soft_negative.is_some_and(|limit| self.published.pos <= Pos::pulses(limit))
        };
        let towards = if direction > 0 { status::LIMIT_POSITIVE } else { status::LIMIT_NEGATIVE };
        self.refuses_start()
            || self.state == MotionState::Driven
            || direction != 0 && (at_soft || self.causes.switches & towards != 0)
    }

    /// Jog or Trap begins or changes; its time is 0 at `next`.
    pub(crate) fn update(&mut self, next: Ns, source: &impl MotionData) {
        if self.begin_prepared(next) {
            return;
        }
        let (from, _) = self.moving(next, source);
        let AxisState { profile, published, ramps: Ramps { trap, jog, .. }, .. } = self;
        profile.enter_reached(next);
        profile.begin_ramp(next, |run| {
            if published.mode == MotionMode::Jog {
                let Jog { acc, dec, smooth } = *jog;
                run.begin_jog(next, from, trap.speed, acc, dec, smooth);
            } else {
                run.begin_trap(next, from, trap);
            }
        });
        self.set_off(StopReason::Completed);
        self.hold_first_piece(next, from);
    }

    /// At `next` it is where its piece would have taken it: the first piece of a ramp that begins
    /// there is not needed before the tick after, and slaves see the pieces of this tick.
    fn hold_first_piece(&mut self, next: Ns, from: Moving) {
        let piece = self.profile.piece();
        if from.velocity.m != 0 && piece.elapsed(next) == piece.span {
            self.state = MotionState::RampBegins;
        }
        self.exact = from.pos;
    }

    /// The prepared start begins; false if there is none.
    pub(super) fn begin_prepared(&mut self, next: Ns) -> bool {
        let begins = self.profile.begin_prepared(next);
        if begins {
            self.set_off(StopReason::Completed);
        }
        begins
    }

    pub(super) fn begin(&mut self, next: Ns, generator: Generator) {
        self.profile.begin(next, generator);
        self.set_off(StopReason::Completed);
    }

    /// It runs from now on; `ending` will be its stop reason.
    pub(super) fn set_off(&mut self, ending: StopReason) {
        (self.state, self.ending) = (MotionState::Runs, ending);
        self.mark_changed();
    }

    /// Its position and velocity at `next` in the present motion, and whether it still runs there.
    pub(super) fn moving(&mut self, next: Ns, source: &impl MotionData) -> (Moving, bool) {
        let rest = |pos| (Moving { pos, velocity: Scaled { m: 0, e: 0 } }, false);
        if !self.state.is_own() {
            return rest(self.exact);
        }
        let feed = self.feed();
        match self.profile.look(next, feed, source) {
            Ok(piece) => {
                let (pos, motion) = piece.sample(piece.elapsed_within(next));
                // Until the step of this tick publishes its own.
                self.published.motion = motion;
                (Moving { pos: exact(pos), velocity: self.published.motion.velocity() }, true)
            }
            Err(GeneratorState::Ended { at } | GeneratorState::Underrun { at }) => rest(at),
            Err(GeneratorState::Running) => rest(exact(self.published.pos)),
        }
    }

    /// Smooth stop from `next` on. A motion that ends there anyway ends by itself, before what
    /// comes after the stop could lengthen it: returns its stop reason then.
    pub(crate) fn stop_smooth(&mut self, next: Ns, reason: StopReason, source: &impl MotionData) -> Option<StopReason> {
        if !self.state.is_own() || self.ending.is_brake() {
            return None;
        }
        // A motion that begins on this very tick was never published as running, and does not move.
        if self.published.status & status::RUNNING == 0 {
            self.halt(next, reason);
            return None;
        }
        if let Some(follower) = self.profile.follower_mut() {
            follower.braking = follower.braking.or(Some(reason));
            return None;
        }
        let (from, runs) = self.moving(next, source);
        if !runs {
            let has_data = !matches!(self.profile.generator(), Generator::Ramp(_));
            return if has_data { self.turn(next, source) } else { None };
        }
        let dec = self.ramps.stop_dec;
        // A pass that has ended by now is counted.
        if self.profile.reports_pass && self.profile.piece().elapsed(next) >= self.profile.piece().span {
            self.publish_pass_of(true);
        }
        self.profile.enter_reached(next);
        self.profile.begin_ramp(next, |run| run.begin_stop(next, from, dec));
        self.set_off(reason);
        self.hold_first_piece(next, from);
        self.end_stream(pt_state::STOPPED);
        self.leave_table(next);
        None
    }

    /// Planned velocity 0 from `next` on, at the present position.
    pub(crate) fn halt(&mut self, next: Ns, reason: StopReason) {
        if self.state.is_own() {
            self.end_stream(pt_state::STOPPED);
            self.come_to_standstill(next, exact(self.published.pos), reason);
            self.profile.forget();
            if let Some(follower) = self.profile.follower_mut() {
                // Its positions in this tick are not those that were planned.
                follower.track.clear();
            }
        }
    }

    pub(super) fn come_to_standstill(&mut self, next: Ns, at: Exact, reason: StopReason) {
        self.state = MotionState::Standstill;
        self.exact = at;
        self.published.pos = at.round();
        self.profile.stand_still(next, self.published.pos);
        self.published.motion = Motion::default();
        self.published.stop = reason;
        self.published.dry_ms = 0;
        self.standstill_since = next;
        self.leave_table(next);
        self.leave_master();
        self.mark_changed();
    }

    /// A tick of the axis: its motion at `next`, its status, what it publishes. Returns the reason
    /// if it came to standstill. `left` counts the pieces that may still be made ahead in this
    /// tick.
    #[inline(never)]
    pub(crate) fn run(
        &mut self,
        next: Ns,
        left: &mut u32,
        source: &impl MotionData,
        published: &mut AxisView,
    ) -> Option<StopReason> {
        let mut stopped = None;
        if self.state.is_own() {
            // A tick that enters a piece does not make the next one.
            if self.profile.is_open() && *left != 0 && self.prepare(source) {
                *left = left.wrapping_sub(1);
            }
            self.turned();
            stopped = self.step(next, source);
        }
        if self.changed {
            self.update_status();
        }
        published.copy_changed(&self.published);
        stopped
    }

    /// The position at `next` of an axis whose ramp begins there: the end of the motion before,
    /// which is published once more.
    #[inline(never)]
    fn hold_at_ramp_start(&mut self, next: Ns) -> Option<StopReason> {
        self.state = MotionState::Runs;
        let pos = self.exact.round();
        if !self.bounds.hold(pos)
            && let Some(reason) = self.stopped_at_barrier(next, pos)
        {
            return Some(reason);
        }
        self.published.version = self.published.version.wrapping_add(1);
        self.published.pos = pos;
        None
    }

    /// The motion at `next` of an axis that runs; the reason if it comes to standstill there.
    #[inline(always)]
    pub(crate) fn step(&mut self, next: Ns, source: &impl MotionData) -> Option<StopReason> {
        if self.causes.present & status::FAULTS != 0 {
            return Some(self.stopped_by_fault(next));
        }
        if self.state == MotionState::RampBegins {
            return self.hold_at_ramp_start(next);
        }
        let mut piece = self.profile.piece();
        let mut t = piece.elapsed(next);
        if t >= piece.span {
            if self.profile.accept(next) {
                self.publish_piece(true);
                piece = self.profile.piece();
                t = piece.elapsed(next);
            } else {
                if let Some(reason) = self.turn(next, source) {
                    return Some(reason);
                }
                piece = self.profile.piece();
                t = piece.elapsed_within(next);
            }
        }
        let (pos, Motion { tau, t, .. }) = piece.sample(t);
        if !self.bounds.hold(pos)
            && let Some(reason) = self.stopped_at_barrier(next, pos)
        {
            return Some(reason);
        }
        self.published.version = self.published.version.wrapping_add(1);
        self.published.pos = pos;
        (self.published.motion.tau, self.published.motion.t) = (tau, t);
        None
    }

    /// The piece is over: on to the next one, or to the end of the motion and its reason.
    #[inline(never)]
    fn turn(&mut self, next: Ns, source: &impl MotionData) -> Option<StopReason> {
        let feed = self.feed();
        let state = self.profile.turn(next, feed, source);
        let running = state == GeneratorState::Running;
        self.publish_piece(running);
        if running { None } else { Some(self.finish(next, state)) }
    }

    /// What a view publishes of the piece entered, or of the end if it runs no longer.
    #[inline(always)]
    fn publish_piece(&mut self, running: bool) {
        self.published.motion = self.profile.piece().motion;
        if !running || self.profile.reports_pass {
            self.publish_pass_of(running);
        }
    }

    /// What a view publishes of the pass, or of the stream.
    #[inline(never)]
    pub(super) fn publish_pass_of(&mut self, running: bool) {
        let published = &mut self.published;
        match self.profile.generator() {
            Generator::Pt(run) => {
                published.passes = run.passes(false);
                if published.mode == MotionMode::PtDynamic {
                    published.released = run.released(running, false);
                }
            }
            Generator::Pvt(run) => {
                let (passes, table) = (run.passes(false), run.table(false));
                let switched = table != published.table;
                if passes != published.passes || switched {
                    (published.passes, published.table_zero) = (passes, run.zero(false));
                }
                if switched {
                    (published.table, published.pending) = (table, run.pending(false));
                    self.changed();
                }
            }
            Generator::Ramp(_) | Generator::Follow(_) => {}
        }
    }

    /// The motion has ended, if no limit lies before its end.
    #[inline(never)]
    fn finish(&mut self, next: Ns, state: GeneratorState) -> StopReason {
        let (at, state, reason) = match state {
            GeneratorState::Running => (exact(self.published.pos), pt_state::ENDED, self.ending),
            GeneratorState::Ended { at } => (at, pt_state::ENDED, self.ending),
            GeneratorState::Underrun { at } => (at, pt_state::UNDERRUN, StopReason::Underrun),
        };
        if let Some(reason) = self.stopped_at_barrier(next, at.round()) {
            return reason;
        }
        self.end_stream(state);
        self.come_to_standstill(next, at, reason);
        reason
    }

    /// Makes the next piece, in a tick that has time for it. Returns whether it took any.
    #[inline(never)]
    fn prepare(&mut self, source: &impl MotionData) -> bool {
        let feed = self.feed();
        self.profile.prepare(feed, source)
    }
}
