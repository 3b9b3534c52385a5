//! One axis in the tick: what it runs, what guards it, what it shows.
//!
//! In: inputs sampled at the tick in force, operations, the instant of the next tick. Out: the planned
//! position there, the status word, events. Owns: everything of the axis but its PT segments.
//! Fails: never; a motion that must not go on stops, with a reason.
use crate::follow;
use crate::inputs::{Inputs, reading};
use crate::op::Mode;
use crate::piece::{Motion, Scaled};
use crate::port::AxisInputs;
use crate::profile::{Profile, State};
use crate::pt::{Feed, Place, PtRun, Segments};
use crate::pvt::{Header, PvtRun, Tables};
use crate::ramp::{Accel, Moving, RampRun, Speed, Trapezoid};
use crate::status;
use crate::units::{Exact, Ns, Pos};
use crate::view::{AxisView, StopReason};

/// Segments of one static FIFO.
const FIFO: u32 = 1024;
/// Slots of the dynamic ring, less one.
const RING_MASK: u32 = 2 * FIFO - 1;
/// The negative edge of travel.
const NEGATIVE_EDGE: Pos = Pos(-Pos::TRAVEL.0);
/// Power-on deceleration of a smooth stop, 1 pulse/ms².
const STOP_DEC: Accel = Accel { value: Scaled { m: 1, e: 0 }, recip: Scaled { m: 1, e: 0 } };

/// `GetPtState` (see [`AxisView::pt_state`]).
mod pt_state {
    pub const RUNNING: u8 = 1;
    pub const ENDED: u8 = 2;
    pub const UNDERRUN: u8 = 3;
    pub const STOPPED: u8 = 4;
}

/// Jog parameters.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Jog {
    pub(crate) acc: Accel,
    pub(crate) dec: Accel,
    pub(crate) smooth: u16,
}

/// The state of one axis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AxisState {
    /// What the thread sees; also the state itself, where it is the same thing.
    pub(crate) shown: AxisView,
    profile: Option<Profile>,
    /// Why the running motion will have ended.
    ending: StopReason,
    /// Since which tick it is at rest.
    pub(crate) rest_since: Ns,
    /// Exact position while at rest.
    exact: Exact,
    /// Planned position at which the machine's own count is 0, so that setting a position makes no step.
    zero: Pos,
    pub(crate) inputs: Inputs,
    /// Input levels, sampled, and their bits.
    pub(crate) raw: AxisInputs,
    levels: u8,
    /// The machine's encoder count, sampled.
    count: i64,
    /// Nothing here changes until an input, the encoder or an operation does.
    pub(crate) settled: bool,
    /// What inputs mean has to be looked at again in the next tick, even if they stay.
    stale: bool,
    /// What follows the piece in force is prepared, or there is nothing to prepare.
    pub(crate) prepared: bool,
    /// The status word may have changed.
    pub(crate) news: bool,
    /// While the planned position stays between these two, nothing stands in its way.
    lower: Pos,
    upper: Pos,
    /// Switches active now, as status bits.
    switches: u32,
    /// Causes of latched bits that are present now.
    causes: u32,
    latched: u32,
    in_position: bool,
    pub(crate) servo_on: bool,
    pub(crate) stop_dec: Accel,
    pub(crate) jog: Jog,
    /// Trap; its target and its speed (Jog's too) are those of SetPos and SetVel.
    pub(crate) trap: Trapezoid,
    /// Segments committed to the FIFOs (dynamic: the first is the ring's).
    ends: [u32; 2],
    /// FIFO that runs.
    fifo: u8,
    /// Passes to run, 0 for ever.
    passes: u32,
    /// PVT table of the next start, and its passes.
    table: u8,
    table_passes: u32,
    /// Follow.
    pub(crate) follow: follow::Setup,
}

/// [`AxisView::table_until`] while a table is in force.
const IN_FORCE: Ns = Ns(u64::MAX);

const NO_ACCEL: Accel = Accel { value: Scaled { m: 0, e: 0 }, recip: Scaled { m: 0, e: 0 } };
const NO_SPEED: Speed = Speed(Scaled { m: 0, e: 0 });

impl AxisState {
    pub(crate) const POWER_ON: AxisState = AxisState {
        shown: AxisView::POWER_ON,
        profile: None,
        ending: StopReason::None,
        rest_since: Ns(0),
        exact: Exact(0),
        zero: Pos(0),
        inputs: Inputs::POWER_ON,
        raw: AxisInputs { limit_positive: false, limit_negative: false, alarm: false, home: false, arrive: false },
        levels: 0,
        count: 0,
        settled: false,
        stale: true,
        prepared: true,
        news: true,
        lower: NEGATIVE_EDGE,
        upper: Pos::TRAVEL,
        switches: 0,
        causes: 0,
        latched: 0,
        in_position: false,
        servo_on: false,
        stop_dec: STOP_DEC,
        jog: Jog { acc: NO_ACCEL, dec: NO_ACCEL, smooth: 0 },
        trap: Trapezoid {
            target: 0,
            speed: NO_SPEED,
            acc: NO_ACCEL,
            dec: NO_ACCEL,
            vel_start: NO_SPEED,
            smooth: Ns(0),
        },
        ends: [0; 2],
        fifo: 0,
        passes: 1,
        table: 0,
        table_passes: 1,
        follow: follow::Setup::POWER_ON,
    };

    pub(crate) fn runs(&self) -> bool {
        self.profile.is_some()
    }

    /// Something is about to differ from the last view.
    #[inline]
    pub(crate) fn touch(&mut self) {
        self.changed();
        (self.settled, self.stale, self.news) = (false, true, true);
    }

    #[inline(always)]
    fn changed(&mut self) {
        self.shown.changes = self.shown.changes.wrapping_add(1);
        self.shown.moves = self.shown.moves.wrapping_add(1);
    }

    /// Takes the inputs of the tick in force at `now`. An axis at rest of which nothing changed costs
    /// two comparisons, and one that runs little more.
    #[inline(always)]
    pub(crate) fn sample(&mut self, now: Ns, raw: AxisInputs, count: i64) {
        let levels = raw.bits();
        if levels == self.levels {
            if self.settled && count == self.count {
                return;
            }
            if !self.stale && self.runs() {
                self.count = count;
                self.shown.encoder_before = self.shown.encoder;
                self.shown.encoder = self.inputs.encoder(count);
                return;
            }
        }
        self.take(now, raw, levels, count);
    }

    #[inline(never)]
    fn take(&mut self, now: Ns, raw: AxisInputs, levels: u8, count: i64) {
        self.settled = !self.runs();
        let encoder = self.inputs.encoder(count);
        if encoder != self.shown.encoder_before || encoder != self.shown.encoder {
            self.shown.moves = self.shown.moves.wrapping_add(1);
            self.settled = false;
        }
        if levels != self.levels {
            (self.raw, self.levels) = (raw, levels);
            self.touch();
        }
        self.count = count;
        self.shown.encoder_before = self.shown.encoder;
        self.shown.encoder = encoder;
        self.switches = self.inputs.switches(levels);
        self.set_bounds();
        let runs = self.runs();
        let mut causes = self.switches;
        if self.servo_on {
            causes |= self.inputs.following_error(self.shown.pos, encoder);
        }
        if !runs {
            // While it runs, the barrier of every step sees to the soft limits.
            causes |= self.inputs.beyond(self.shown.pos);
        }
        let watched = causes | self.causes != 0 || self.inputs.error_limit.is_some();
        if causes | self.causes != 0 {
            self.latch(causes);
        }
        if runs {
            self.inputs.leave_position();
            self.in_position = false;
        } else {
            let (inside, waits) = self.inputs.in_position(now, self.shown.pos, encoder);
            self.settled &= !waits && inside == self.in_position;
            self.in_position = inside;
        }
        if let Some(encoder) = self.inputs.captured(levels, encoder) {
            self.shown.captured = Some(encoder);
            self.touch();
        }
        (self.stale, self.news) = (watched, true);
    }

    /// Where the planned position may go without a closer look. A switch that is active has a direction,
    /// so all of it needs one.
    pub(crate) fn set_bounds(&mut self) {
        let Inputs { soft_positive, soft_negative, .. } = &self.inputs;
        self.upper = soft_positive.map_or(Pos::TRAVEL, Pos::pulses);
        self.lower = soft_negative.map_or(NEGATIVE_EDGE, Pos::pulses);
        if self.switches & status::LIMIT_POSITIVE != 0 {
            self.upper = Pos(i64::MIN);
        }
        if self.switches & status::LIMIT_NEGATIVE != 0 {
            self.lower = Pos(i64::MAX);
        }
    }

    /// A limit blocks starts from when it becomes active until ClearStatus, a fault as long as its
    /// cause lasts, too.
    #[inline(never)]
    fn latch(&mut self, causes: u32) {
        self.settled = false;
        let blocked = self.shown.blocked | causes & (!self.causes | status::FAULTS);
        self.causes = causes;
        self.latched |= causes;
        self.block(blocked);
    }

    fn block(&mut self, blocked: u32) {
        if blocked != self.shown.blocked {
            self.shown.blocked = blocked;
            self.touch();
        }
    }

    /// ClearStatus: limits no longer block; bits whose cause is gone are cleared.
    pub(crate) fn clear_status(&mut self) {
        self.latched = self.causes;
        self.block(self.causes & status::FAULTS);
    }

    /// Brings the status word up to the tick just computed.
    #[inline(never)]
    pub(crate) fn settle(&mut self) {
        self.news = false;
        let status = self.status();
        if status != self.shown.status {
            self.shown.status = status;
            self.changed();
            self.settled = false;
        }
    }

    /// The status word as things stand.
    #[inline]
    pub(crate) fn status(&self) -> u32 {
        let mut word = self.latched;
        if self.servo_on {
            word |= status::SERVO_ON;
        }
        if self.runs() {
            word |= status::RUNNING;
        } else if self.in_position {
            word |= status::IN_POSITION;
        }
        word
    }

    /// Whether it must not start: servo off, latched fault, or PT without data.
    pub(crate) fn refuses_start(&self) -> bool {
        !self.servo_on || self.shown.blocked != 0
    }

    /// Whether PT must not start.
    pub(crate) fn refuses_pt(&self, fifo1: bool) -> bool {
        let fifo = if self.shown.mode == Mode::PtStatic { fifo1 as u8 } else { 0 };
        self.refuses_start() || self.runs() || !self.is_pt() || self.end(fifo) == 0
    }

    /// Whether Jog or Trap must not begin or change: also towards an active limit.
    pub(crate) fn refuses_update(&self) -> bool {
        let way = match self.shown.mode {
            Mode::Jog => self.trap.speed.0.m.signum(),
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
        self.refuses_start() || way != 0 && (at_soft || self.switches & towards != 0)
    }

    fn is_pt(&self) -> bool {
        matches!(self.shown.mode, Mode::PtStatic | Mode::PtDynamic)
    }

    fn end(&self, fifo: u8) -> u32 {
        let [first, second] = self.ends;
        if fifo == 0 { first } else { second }
    }

    fn feed(&self) -> Feed {
        let passes = if self.shown.mode == Mode::Pvt { self.table_passes } else { self.passes };
        Feed { end: self.end(self.fifo), passes }
    }

    /// PT begins; its time is 0 at `next`.
    pub(crate) fn start_pt(&mut self, next: Ns, fifo1: bool) {
        let place = if self.shown.mode == Mode::PtStatic {
            self.fifo = fifo1 as u8;
            Place::Static { base: if fifo1 { FIFO } else { 0 } }
        } else {
            self.fifo = 0;
            Place::Dynamic { mask: RING_MASK, first: 0 }
        };
        self.shown.pt_state = pt_state::RUNNING;
        self.shown.passes = 0;
        self.begin(Profile::Pt(PtRun::begin(next, self.exact, place)));
    }

    /// Whether PVT must not start.
    pub(crate) fn refuses_pvt(&self, tables: &impl Tables) -> bool {
        let empty = Header::from_words(tables.header(self.table)).places == 0;
        self.refuses_start() || self.runs() || self.shown.mode != Mode::Pvt || empty
    }

    /// PVT begins; its time is 0 at `next`.
    pub(crate) fn start_pvt(&mut self, next: Ns, tables: &impl Tables) {
        let shown = &mut self.shown;
        (shown.passes, shown.table, shown.pending) = (0, self.table, None);
        (shown.table_zero, shown.table_until) = (next, IN_FORCE);
        self.begin(Profile::Pvt(PvtRun::begin(next, self.exact, self.table, tables)));
    }

    /// The table of the next start, or the one that takes over when the present pass ends.
    pub(crate) fn select(&mut self, table: u8) {
        self.table = table;
        if let Some(Profile::Pvt(run)) = &mut self.profile {
            run.select(table);
            self.shown.pending = run.pending();
        } else if !self.runs() {
            self.shown.table = table;
            (self.shown.table_zero, self.shown.table_until) = (Ns(0), Ns(0));
        }
    }

    pub(crate) fn set_table_passes(&mut self, passes: u32) {
        self.table_passes = passes;
    }

    /// No table is in force from `next` on.
    fn leave_table(&mut self, next: Ns) {
        if self.shown.table_until == IN_FORCE {
            (self.shown.table_until, self.shown.pending) = (next, None);
        }
    }

    /// Jog or Trap begins or changes; its time is 0 at `next`.
    pub(crate) fn update(&mut self, next: Ns, source: &(impl Segments + Tables)) {
        let (from, _) = self.moving(next, source);
        let (jog, to) = (self.shown.mode == Mode::Jog, self.trap);
        let Jog { acc, dec, smooth } = self.jog;
        self.begin_ramp(|run| {
            if jog {
                run.begin_jog(next, from, to.speed, acc, dec, smooth);
            } else {
                run.begin_trap(next, from, &to);
            }
        });
        self.ending = StopReason::Completed;
        self.touch();
    }

    /// A ramp begins where its state lies: it is too large to be moved about.
    #[inline(always)]
    fn begin_ramp(&mut self, begin: impl FnOnce(&mut RampRun)) {
        if !matches!(self.profile, Some(Profile::Ramp(_))) {
            self.profile = Some(Profile::Ramp(RampRun::IDLE));
        }
        if let Some(Profile::Ramp(run)) = &mut self.profile {
            begin(run);
        }
    }

    fn begin(&mut self, profile: Profile) {
        self.profile = Some(profile);
        self.ending = StopReason::Completed;
        self.touch();
    }

    /// Where it will be, and how fast, at `next`, as things stand; and whether it still runs there.
    fn moving(&self, next: Ns, source: &(impl Segments + Tables)) -> (Moving, bool) {
        let rest = |pos| (Moving { pos, velocity: Scaled { m: 0, e: 0 } }, false);
        let Some(profile) = &self.profile else {
            return rest(self.exact);
        };
        let piece = profile.piece();
        let t = piece.elapsed(next);
        if t < piece.span {
            let (pos, tau) = piece.at(t);
            return (Moving { pos: exact(pos), velocity: piece.motion(tau).velocity() }, true);
        }
        let mut trial = *profile;
        let step = trial.step(next, self.feed(), source);
        match step.state {
            State::Running => (Moving { pos: exact(step.pos), velocity: step.motion.velocity() }, true),
            State::Ended { at } | State::Underrun { at } => rest(at),
        }
    }

    /// Smooth stop from `next` on. What ends there anyway is left to end.
    pub(crate) fn stop_smooth(&mut self, next: Ns, source: &(impl Segments + Tables)) {
        if !self.runs() || self.ending == StopReason::StopSmooth {
            return;
        }
        let (from, runs) = self.moving(next, source);
        if runs {
            let dec = self.stop_dec;
            self.begin_ramp(|run| run.begin_stop(next, from, dec));
            self.ending = StopReason::StopSmooth;
            self.end_stream(pt_state::STOPPED);
            self.leave_table(next);
        }
    }

    /// Planned velocity 0 from `next` on, where it stands.
    pub(crate) fn halt(&mut self, next: Ns, reason: StopReason) {
        if self.runs() {
            self.end_stream(pt_state::STOPPED);
            self.rest(next, exact(self.shown.pos), reason);
        }
    }

    fn rest(&mut self, next: Ns, at: Exact, reason: StopReason) {
        self.profile = None;
        self.exact = at;
        self.shown.pos = at.round();
        self.shown.motion = Motion::default();
        self.shown.stop = reason;
        self.shown.dry_ms = 0;
        self.rest_since = next;
        self.leave_table(next);
        self.touch();
    }

    /// PT is over; a dynamic stream is cleared with it.
    fn end_stream(&mut self, state: u8) {
        if self.shown.pt_state != pt_state::RUNNING {
            return;
        }
        self.shown.pt_state = state;
        if self.shown.mode == Mode::PtDynamic {
            self.shown.epoch = self.shown.epoch.wrapping_add(1);
            self.shown.released = 0;
            self.ends = [0; 2];
        }
    }

    /// The motion at `next` of an axis that runs; the reason if it comes to rest there.
    #[inline(always)]
    pub(crate) fn step(&mut self, next: Ns, look_ahead: bool, source: &(impl Segments + Tables)) -> Option<StopReason> {
        if self.causes & status::FAULTS != 0 {
            return Some(self.stopped_by_fault(next));
        }
        let mut piece = self.profile.as_ref()?.piece();
        let mut t = piece.elapsed(next);
        if t >= piece.span {
            if let Some(reason) = self.turn(next, source) {
                return Some(reason);
            }
            piece = self.profile.as_ref()?.piece();
            t = piece.held(next);
        }
        let (pos, tau) = piece.at(t);
        if (pos < self.lower || pos > self.upper)
            && let Some(reason) = self.stopped_at_barrier(next, pos)
        {
            return Some(reason);
        }
        self.shown.moves = self.shown.moves.wrapping_add(1);
        (self.shown.pos, self.shown.motion.tau) = (pos, tau);
        if look_ahead {
            self.look_ahead(next, source);
        }
        None
    }

    #[inline(never)]
    fn look_ahead(&mut self, next: Ns, source: &(impl Segments + Tables)) {
        if let Some(Profile::Pt(run)) = &self.profile {
            self.shown.dry_ms = run.dry_ms(next, self.feed(), source);
        }
    }

    /// The piece is over: on to the next one, or to the end of the motion and the reason of it.
    #[inline(never)]
    fn turn(&mut self, next: Ns, source: &(impl Segments + Tables)) -> Option<StopReason> {
        let feed = self.feed();
        let profile = self.profile.as_mut()?;
        let state = profile.turn(next, feed, source);
        let running = state == State::Running;
        self.prepared = false;
        self.shown.pieces = self.shown.pieces.wrapping_add(1);
        let Motion { c: [c1, c2, c3], frac, recip, .. } = profile.piece().motion;
        let motion = &mut self.shown.motion;
        (motion.c, motion.frac, motion.recip) = ([c1, c2, c3], frac, recip);
        match profile {
            Profile::Pt(run) => {
                self.shown.passes = run.passes();
                if self.shown.mode == Mode::PtDynamic {
                    self.shown.released = run.released(running);
                }
            }
            Profile::Pvt(run) => {
                let shown = &mut self.shown;
                if run.passes() != shown.passes || run.table() != shown.table {
                    (shown.passes, shown.table, shown.pending) = (run.passes(), run.table(), run.pending());
                    shown.table_zero = run.zero();
                    self.changed();
                }
            }
            Profile::Ramp(_) => {}
        }
        if running { None } else { Some(self.finish(next, state)) }
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

    #[inline(never)]
    fn stopped_by_fault(&mut self, next: Ns) -> StopReason {
        let alarm = self.causes & status::ALARM != 0;
        self.stopped_by(next, if alarm { StopReason::Alarm } else { StopReason::FollowingError })
    }

    /// Whether something stands between the position in force and `to`: then it has stopped there.
    #[inline(never)]
    fn stopped_at_barrier(&mut self, next: Ns, to: Pos) -> Option<StopReason> {
        let (at, reason) = self.barrier(self.shown.pos, to)?;
        self.shown.pos = at;
        Some(self.stopped_by(next, reason))
    }

    /// Computes the next piece, in a tick that has time for it; whether it took any.
    #[inline(never)]
    pub(crate) fn prepare(&mut self, source: &(impl Segments + Tables)) -> bool {
        self.prepared = true;
        let feed = self.feed();
        self.profile.as_mut().is_some_and(|profile| profile.prepare(feed, source))
    }

    fn stopped_by(&mut self, next: Ns, reason: StopReason) -> StopReason {
        let limit = match reason {
            StopReason::LimitPositive | StopReason::SoftPositive => status::LIMIT_POSITIVE,
            StopReason::LimitNegative | StopReason::SoftNegative => status::LIMIT_NEGATIVE,
            _ => 0,
        };
        self.latched |= limit;
        self.block(self.shown.blocked | limit);
        self.halt(next, reason);
        reason
    }

    /// What stands between two positions, and where it holds the axis.
    fn barrier(&self, from: Pos, to: Pos) -> Option<(Pos, StopReason)> {
        let inputs = &self.inputs;
        if to > from {
            if self.switches & status::LIMIT_POSITIVE != 0 {
                return Some((from, StopReason::LimitPositive));
            }
            if let Some(soft) = inputs.soft_positive.map(Pos::pulses)
                && to > soft
            {
                return Some((from.max(soft), StopReason::SoftPositive));
            }
            if to > Pos::TRAVEL {
                return Some((Pos::TRAVEL, StopReason::Travel));
            }
        } else if to < from {
            if self.switches & status::LIMIT_NEGATIVE != 0 {
                return Some((from, StopReason::LimitNegative));
            }
            if let Some(soft) = inputs.soft_negative.map(Pos::pulses)
                && to < soft
            {
                return Some((from.min(soft), StopReason::SoftNegative));
            }
            if to < NEGATIVE_EDGE {
                return Some((NEGATIVE_EDGE, StopReason::Travel));
            }
        }
        None
    }

    /// The machine's set-point for the planned position.
    #[inline]
    pub(crate) fn set_point(&self) -> Pos {
        Pos(self.shown.pos.0.wrapping_sub(self.zero.0))
    }

    /// The planned position, at rest, is called `at`; the machine does not move.
    fn rename(&mut self, at: Pos) {
        if !self.runs() {
            self.zero = Pos(self.zero.0.wrapping_add(at.0.wrapping_sub(self.shown.pos.0)));
            self.shown.pos = at;
            self.exact = exact(at);
        }
    }

    /// Sets the planned position.
    pub(crate) fn set_position(&mut self, at: Pos) {
        self.rename(at);
    }

    /// Planned position and encoder both read 0.
    pub(crate) fn zero_position(&mut self) {
        if !self.runs() {
            self.rename(Pos(0));
            self.set_encoder(0);
        }
    }

    /// The encoder reads `pulses` where it is.
    pub(crate) fn set_encoder(&mut self, pulses: i64) {
        self.inputs.set_encoder(self.count, pulses);
        self.shown.encoder_before = self.shown.encoder_before.wrapping_add(pulses.wrapping_sub(self.shown.encoder));
        self.shown.encoder = pulses;
    }

    /// The planned position becomes the encoder's reading.
    pub(crate) fn synchronise(&mut self) {
        self.rename(reading(self.shown.encoder));
    }

    /// The mode, at rest; another one clears the PT data.
    pub(crate) fn set_mode(&mut self, mode: Mode) {
        if self.runs() || self.shown.mode == mode {
            return;
        }
        self.shown.mode = mode;
        self.shown.pt_state = 0;
        self.shown.passes = 0;
        self.clear_data();
    }

    fn clear_data(&mut self) {
        self.follow.clear_all();
        self.ends = [0; 2];
        self.shown.released = 0;
    }

    /// What was committed to a FIFO counts from now on.
    pub(crate) fn commit(&mut self, fifo: u8, end: u32, epoch: u32) {
        if self.shown.mode == Mode::PtDynamic && epoch != self.shown.epoch {
            return;
        }
        let [first, second] = &mut self.ends;
        *(if fifo == 0 { first } else { second }) = end;
        self.prepared = false;
    }

    /// Empties a FIFO that is not running.
    pub(crate) fn clear_fifo(&mut self, fifo: u8) {
        if self.shown.mode == Mode::PtDynamic {
            if !self.runs() {
                self.clear_data();
            }
        } else if !self.runs() || self.fifo != fifo {
            let [first, second] = &mut self.ends;
            *(if fifo == 0 { first } else { second }) = 0;
        }
    }

    /// Which of the master's motion counts, at rest; another one clears the data.
    pub(crate) fn set_direction(&mut self, direction: follow::Direction) {
        if !self.runs() && self.follow.direction != direction {
            self.follow.direction = direction;
            self.follow.clear_all();
        }
    }

    /// What was committed to a FIFO of Follow counts from now on, if no switch has emptied it meanwhile.
    pub(crate) fn commit_entries(
        &mut self,
        fifo: u8,
        end: u32,
        cleared: u32,
        tail: follow::Tail,
        source: &impl follow::Entries,
    ) {
        let [first, second] = self.shown.cleared;
        if cleared == if fifo == 0 { first } else { second } {
            self.follow.commit(fifo, end, tail, source);
        }
    }

    /// Empties a FIFO of Follow that is not running.
    pub(crate) fn clear_entries(&mut self, fifo: u8) {
        if !self.runs() || self.shown.fifo != fifo {
            self.follow.clear(fifo);
        }
    }

    pub(crate) fn set_passes(&mut self, passes: u32) {
        self.passes = passes;
    }

    /// Arms a capture; what was captured before is forgotten.
    pub(crate) fn arm(&mut self, mode: u8) {
        self.shown.captured = None;
        self.inputs.arm(mode);
    }

    /// Power-on state, at rest. The machine does not move; where it stands is 0 from now on.
    pub(crate) fn reset(&mut self) {
        *self = AxisState {
            zero: Pos(self.set_point().0.wrapping_neg()),
            raw: self.raw,
            levels: self.levels,
            count: self.count,
            rest_since: self.rest_since,
            shown: AxisView {
                changes: self.shown.changes,
                moves: self.shown.moves,
                pieces: self.shown.pieces,
                epoch: self.shown.epoch,
                cleared: self.shown.cleared,
                stop: self.shown.stop,
                ..AxisView::POWER_ON
            },
            ..AxisState::POWER_ON
        };
        self.inputs.set_encoder(self.count, 0);
    }
}

fn exact(pos: Pos) -> Exact {
    Exact((pos.0 as i128) << (64 - Pos::FRAC_BITS))
}
