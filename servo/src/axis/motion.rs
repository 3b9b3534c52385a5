//! An axis in motion: starts and stops, and the step of a tick.
//!
//! In: the instant of the next tick. Out: the planned position there, or the reason for which it has
//! come to rest. Owns nothing beyond the axis's [`Profile`](crate::profile::Profile).
use super::Jog;
use super::{AxisState, exact, pt_state};
use crate::op::Mode;
use crate::piece::{Motion, Scaled};
use crate::profile::{State, Supply};
use crate::pt::Segments;
use crate::pvt::Tables;
use crate::ramp::Moving;
use crate::status;
use crate::units::{Exact, Ns, Pos};
use crate::view::{AxisView, StopReason};

impl AxisState {
    /// Whether Jog or Trap must not begin or change: also towards an active limit.
    pub(crate) fn refuses_update(&self) -> bool {
        let way = match self.shown.mode {
            Mode::Jog => self.trap.speed.signum(),
            Mode::Trap => Pos::pulses(self.trap.target).0.saturating_sub(self.shown.pos.0).signum(),
            _ => return true,
        };
        let inputs = &self.inputs;
        let at_soft = if way > 0 {
            inputs.soft_positive.is_some_and(|limit| self.shown.pos >= Pos::pulses(limit))
        } else {
            inputs.soft_negative.is_some_and(|limit| self.shown.pos <= Pos::pulses(limit))
        };
        let towards = if way > 0 { status::LIMIT_POSITIVE } else { status::LIMIT_NEGATIVE };
        self.refuses_start() || self.driven || way != 0 && (at_soft || self.switches & towards != 0)
    }

    /// Jog or Trap begins or changes; its time is 0 at `next`.
    pub(crate) fn update(&mut self, next: Ns, source: &(impl Segments + Tables)) {
        if self.begin_ready(next) {
            return;
        }
        let (from, _) = self.moving(next, source);
        let AxisState { profile, shown, trap, jog, .. } = self;
        profile.begin_ramp(next, |run| {
            if shown.mode == Mode::Jog {
                let Jog { acc, dec, smooth } = *jog;
                run.begin_jog(next, from, trap.speed, acc, dec, smooth);
            } else {
                run.begin_trap(next, from, trap);
            }
        });
        self.set_off(StopReason::Completed);
    }

    /// What was made ready at rest begins; false if nothing was.
    pub(super) fn begin_ready(&mut self, next: Ns) -> bool {
        let begins = self.profile.begin_ready(next);
        if begins {
            self.set_off(StopReason::Completed);
        }
        begins
    }

    pub(super) fn begin(&mut self, next: Ns, supply: Supply) {
        self.profile.begin(next, supply);
        self.set_off(StopReason::Completed);
    }

    /// It runs from now on, and `ending` is why it will have stopped.
    pub(super) fn set_off(&mut self, ending: StopReason) {
        (self.runs, self.begins, self.ending) = (true, false, ending);
        self.touch();
    }

    /// Where it will be, and how fast, at `next`, as things stand; and whether it still runs there.
    pub(super) fn moving(&mut self, next: Ns, source: &(impl Segments + Tables)) -> (Moving, bool) {
        let rest = |pos| (Moving { pos, velocity: Scaled { m: 0, e: 0 } }, false);
        if !self.runs {
            return rest(self.exact);
        }
        let feed = self.feed();
        match self.profile.look(next, feed, source) {
            Ok(piece) => {
                let (pos, motion) = piece.place(piece.held(next));
                // Until the step of this tick tells what comes of it.
                self.shown.motion = motion;
                (Moving { pos: exact(pos), velocity: self.shown.motion.velocity() }, true)
            }
            Err(State::Ended { at } | State::Underrun { at }) => rest(at),
            Err(State::Running) => rest(exact(self.shown.pos)),
        }
    }

    /// Smooth stop from `next` on. What ends there anyway is left to end.
    pub(crate) fn stop_smooth(&mut self, next: Ns, reason: StopReason, source: &(impl Segments + Tables)) {
        if !self.runs || self.ending.is_brake() {
            return;
        }
        // What begins on this very tick has not been seen to run, and does not move.
        if self.shown.status & status::RUNNING == 0 {
            return self.halt(next, reason);
        }
        if let Some(follower) = self.profile.follower_mut() {
            follower.braking = Some(reason);
            return;
        }
        let (from, runs) = self.moving(next, source);
        if runs {
            let dec = self.stop_dec;
            self.profile.begin_ramp(next, |run| run.begin_stop(next, from, dec));
            self.set_off(reason);
            // At `next` it is where it would have been in its piece: the first one of the ramp has time until the tick behind.
            let piece = self.profile.piece();
            self.begins = from.velocity.m != 0 && piece.elapsed(next) == piece.span;
            self.exact = from.pos;
            self.end_stream(pt_state::STOPPED);
            self.leave_table(next);
        }
    }

    /// Planned velocity 0 from `next` on, where it stands.
    pub(crate) fn halt(&mut self, next: Ns, reason: StopReason) {
        if self.runs {
            self.end_stream(pt_state::STOPPED);
            self.rest(next, exact(self.shown.pos), reason);
            self.profile.forget();
            if let Some(follower) = self.profile.follower_mut() {
                follower.forget_track();
            }
        }
    }

    pub(super) fn rest(&mut self, next: Ns, at: Exact, reason: StopReason) {
        (self.runs, self.begins) = (false, false);
        self.exact = at;
        self.shown.pos = at.round();
        self.profile.rest(next, self.shown.pos);
        self.shown.motion = Motion::default();
        self.shown.stop = reason;
        self.shown.dry_ms = 0;
        self.rest_since = next;
        self.leave_table(next);
        self.leave_master();
        self.touch();
    }

    /// A tick of the axis: its motion at `next`, its status, what it shows. The reason if it came to rest.
    /// `left` counts the pieces that may still be made ahead in this tick.
    #[inline(never)]
    pub(crate) fn run(
        &mut self,
        next: Ns,
        left: &mut u32,
        source: &(impl Segments + Tables),
        shown: &mut AxisView,
    ) -> Option<StopReason> {
        let mut stopped = None;
        if self.runs {
            // What is entered in this tick is not followed by making the next in the same one.
            if self.profile.is_open() && *left != 0 && self.prepare(source) {
                *left = left.wrapping_sub(1);
            }
            self.turned();
            stopped = self.step(next, source);
        }
        if self.news {
            self.settle();
        }
        shown.follow(&self.shown);
        stopped
    }

    /// The place at `next` of an axis whose ramp begins there: that of the motion before, which is shown once more.
    #[inline(never)]
    fn stand_in(&mut self, next: Ns) -> Option<StopReason> {
        self.begins = false;
        let pos = self.exact.round();
        if (pos < self.lower || pos > self.upper)
            && let Some(reason) = self.stopped_at_barrier(next, pos)
        {
            return Some(reason);
        }
        self.shown.moves = self.shown.moves.wrapping_add(1);
        self.shown.pos = pos;
        None
    }

    /// The motion at `next` of an axis that runs; the reason if it comes to rest there.
    #[inline(always)]
    pub(crate) fn step(&mut self, next: Ns, source: &(impl Segments + Tables)) -> Option<StopReason> {
        if self.causes & status::FAULTS != 0 {
            return Some(self.stopped_by_fault(next));
        }
        if self.begins {
            return self.stand_in(next);
        }
        let mut piece = self.profile.piece();
        let mut t = piece.elapsed(next);
        if t >= piece.span {
            if self.profile.accept(next) {
                self.show_piece(true);
                piece = self.profile.piece();
                t = piece.elapsed(next);
            } else {
                if let Some(reason) = self.turn(next, source) {
                    return Some(reason);
                }
                piece = self.profile.piece();
                t = piece.held(next);
            }
        }
        let (pos, Motion { tau, t, .. }) = piece.place(t);
        if (pos < self.lower || pos > self.upper)
            && let Some(reason) = self.stopped_at_barrier(next, pos)
        {
            return Some(reason);
        }
        self.shown.moves = self.shown.moves.wrapping_add(1);
        self.shown.pos = pos;
        (self.shown.motion.tau, self.shown.motion.t) = (tau, t);
        None
    }

    /// The piece is over: on to the next one, or to the end of the motion and the reason of it.
    #[inline(never)]
    fn turn(&mut self, next: Ns, source: &(impl Segments + Tables)) -> Option<StopReason> {
        let feed = self.feed();
        let state = self.profile.turn(next, feed, source);
        let running = state == State::Running;
        self.show_piece(running);
        if running { None } else { Some(self.finish(next, state)) }
    }

    /// What a view tells of the piece entered, or of the end if it runs no longer.
    #[inline(always)]
    fn show_piece(&mut self, running: bool) {
        self.shown.motion = self.profile.piece().motion;
        if !running || self.profile.tells() {
            self.show_pass(running);
        }
    }

    /// What a view tells of the pass, or of the stream.
    #[inline(never)]
    pub(super) fn show_pass(&mut self, running: bool) {
        let shown = &mut self.shown;
        match self.profile.supply() {
            Supply::Pt(run) => {
                shown.passes = run.passes(false);
                if shown.mode == Mode::PtDynamic {
                    shown.released = run.released(running, false);
                }
            }
            Supply::Pvt(run) => {
                let (passes, table) = (run.passes(false), run.table(false));
                let switched = table != shown.table;
                if passes != shown.passes || switched {
                    (shown.passes, shown.table_zero) = (passes, run.zero(false));
                }
                if switched {
                    (shown.table, shown.pending) = (table, run.pending(false));
                    self.changed();
                }
            }
            Supply::Ramp(_) | Supply::Follow(_) => {}
        }
    }

    /// The motion has ended, if nothing stands before its end.
    #[inline(never)]
    fn finish(&mut self, next: Ns, state: State) -> StopReason {
        let (at, state, reason) = match state {
            State::Running => (exact(self.shown.pos), pt_state::ENDED, self.ending),
            State::Ended { at } => (at, pt_state::ENDED, self.ending),
            State::Underrun { at } => (at, pt_state::UNDERRUN, StopReason::Underrun),
        };
        if let Some(reason) = self.stopped_at_barrier(next, at.round()) {
            return reason;
        }
        self.end_stream(state);
        self.rest(next, at, reason);
        reason
    }

    /// Makes the next piece, in a tick that has time for it; whether it took any.
    #[inline(never)]
    fn prepare(&mut self, source: &(impl Segments + Tables)) -> bool {
        let feed = self.feed();
        self.profile.prepare(feed, source)
    }
}
