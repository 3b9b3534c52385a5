//! A coordinate system that moves.
//!
//! In: entries from two FIFOs and how many of them are there, instants, Stops. Out: a
//! [`PathReport`] a tick; the effects of entries, with exact instants, to an [`Effects`]. Owns: the
//! motion in force, a cursor for each FIFO. Fails: entries that run out at speed end the path
//! there, and so does a wait that is reached at speed, [`PathStop::Underrun`].
//!
//! [`Path::advance`] for the tick at `t` first passes the boundaries up to `t`, samples the
//! position, and then passes those before `t + period`: the path is one period ahead of its
//! published position. A Stop, an override and new data act at `t`; no boundary after it has been
//! published yet.
mod advance;
mod cursor;
mod fast_path;
mod feed_override;
mod interface;
mod motions;
mod position;
mod prepared_start;
mod stop;

pub use cursor::GEARS;
pub use feed_override::FeedOverride;
pub use interface::{Effects, FifoEnds, PathReport, PathSettings, PathStop, StepReport, TrajectorySample};

use super::entry::MotionSpeeds;
use super::geometry::{GearMotion, GeometryStep, MotionGeometry};
use super::speed_profile::{Phase, SpeedPlan, SpeedPlanDraft};
use super::store::PathEntries;
use super::{DIMENSIONS, PathPos, PathSpeed};
use crate::math::float::Float;
use crate::segment::piece::Piece;
use crate::units::{Axis, Exact, FineNs, Ns, Pos};
use cursor::{ActiveGear, Cursor, ORIGIN, SampledPosition};
use fast_path::FastPathCase;

/// Entries with effects in a tick, a move counted
/// [`PathEntry::load`](super::entry::PathEntry::load) times. The path holds before the next one
/// until the next tick. As many may lie between two motions that are passed at speed.
pub const EFFECTS: u32 = 32;
/// Instants of a tick at which they take effect.
pub(crate) const INSTANTS: u32 = 8;
/// Motions entered in a tick; the same holds.
const TICK_MOTIONS: u32 = 32;
/// The present state of the path.
#[derive(Debug, Clone, Copy)]
enum PathStage {
    /// Nothing.
    Standstill,
    /// It waits at its position.
    Wait { until: FineNs },
    /// It is in a phase of a motion.
    Move,
}

/// What follows a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum After {
    /// Another motion.
    Motion,
    /// A wait, or more effects than a tick carries out.
    Halt,
    /// Nothing so far.
    Nothing,
}

state! {
    /// A coordinate system that moves. What every tick reads comes first.
    #[derive(Debug, Clone, Copy)]
    #[repr(C)]
    pub struct Path {
        stage: PathStage = PathStage::Standstill,
        motion_position: MotionPosition = MotionPosition::NONE,
        travelled: TravelledLength = TravelledLength { length: None, past: SampledPosition::NONE },
        /// The end of the FIFO, if nothing followed the motion in force when it was planned.
        open_end: Option<u32> = None,
        fifo: u8 = 0,
        fast: FastPath = FastPath { publishes: false, at_phase_end: FastPathCase::Else },
        /// What is published has to be written as a whole.
        pub(crate) publish_whole: bool = true,
        /// Whether a coordinate has slaves; then the motion between samples is kept: up to the last
        /// one, and since.
        has_slaves: bool = false,
        stopping: bool = false,
        pieces: Pieces = Pieces {
            made: false,
            pair: Pair { at: 0, both: [PackedPhase { even: None, piece: Piece::standstill(Ns(0), 0, Pos(0)) }; 2] },
            follows: None,
        },
        /// Its position after the end of the phase in force, if the next motion begins there
        /// (`fast`).
        next_position: MotionPosition = MotionPosition::NONE,
        /// The instant up to which all boundaries have been passed, and the speed there.
        time: FineNs = 0,
        speed: Float = Float::ZERO,
        pub(crate) cursors: [Cursor; 2] = [Cursor::NEW; 2],
        /// The motion in force, and the one after it, made ahead in ticks that have time for it.
        motions: Pair<Prepared> = Pair { at: 0, both: [Prepared::NONE; 2] },
        /// Its position while it does not move.
        rest_position: PathPos = ORIGIN,
        /// Holds for all motions; a change acts on the motion in force with [`Path::replan`].
        pub rules: PathSettings = PathSettings::POWER_ON,
        planning: Planning = Planning { unfinished: false, draft: GeometryStep::Nothing, speed_draft: SpeedPlanDraft::NONE },
        /// At standstill: the part that is made belongs to a start with this FIFO, as if it began
        /// at 0.
        prepared: Option<u8> = None,
        /// The motion up to the last sample.
        pub(crate) trajectory: TrajectorySample = TrajectorySample::NONE,
        trajectory_since: TrajectorySample = TrajectorySample::NONE,
    }
    /// At standstill in the origin, FIFOs empty.
    pub const IDLE;
}

/// The one in force, and the one after it.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
struct Pair<T> {
    /// Which one is in force. The mask is the bound: the check folds away.
    at: u8,
    both: [T; 2],
}

impl<T> Pair<T> {
    #[inline(always)]
    fn now(&self) -> &T {
        &self.both[(self.at & 1) as usize]
    }

    #[inline(always)]
    fn now_mut(&mut self) -> &mut T {
        &mut self.both[(self.at & 1) as usize]
    }

    #[inline(always)]
    fn next(&self) -> &T {
        &self.both[(!self.at & 1) as usize]
    }

    #[inline(always)]
    fn next_mut(&mut self) -> &mut T {
        &mut self.both[(!self.at & 1) as usize]
    }

    /// The one after it comes into force.
    #[inline(always)]
    fn turn(&mut self) {
        self.at ^= 1;
    }
}

/// The phase in force as a piece, and the one after it.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
struct Pieces {
    /// The first is made, as it was needed.
    made: bool,
    pair: Pair<PackedPhase>,
    /// When the second begins, if it is made.
    follows: Option<FineNs>,
}

/// The path length since the last sample.
#[derive(Debug, Clone, Copy)]
struct TravelledLength {
    /// To the end of the last phase that has ended since, if one has.
    length: Option<Exact>,
    /// Then: the position at that sample.
    past: SampledPosition,
}

/// What the fast path may do. Decided where it may change.
#[derive(Debug, Clone, Copy)]
struct FastPath {
    /// Publish the position.
    publishes: bool,
    /// Pass the end of the phase in force.
    at_phase_end: FastPathCase,
}

/// The part of a motion that is being made.
#[derive(Debug, Clone, Copy)]
struct Planning {
    /// The plan of the motion in force is not made yet beyond its first phase (`speed_draft`).
    unfinished: bool,
    /// Of the geometry of the motion after it.
    draft: GeometryStep,
    /// Of the plan of that motion, or, as long as that is `unfinished`, of the one in force.
    speed_draft: SpeedPlanDraft,
}

/// A phase in the form that the tick evaluates.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
struct PackedPhase {
    /// Its speed, where it is constant.
    even: Option<PathSpeed>,
    piece: Piece,
}

impl PackedPhase {
    /// Becomes a phase that begins then, at this path length.
    #[inline(always)]
    fn make(&mut self, phase: &Phase, begin: FineNs, from: Exact) {
        phase.piece(begin, from, &mut self.piece);
        self.even = PathSpeed::even(&self.piece.motion);
    }
}

/// The position in the motion in force.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
struct MotionPosition {
    /// When the phase in force began, and the path length there.
    began: FineNs,
    distance: Exact,
    /// When the phase or the wait in force is over.
    over: FineNs,
    /// The path length along the motion at the last sample, or 0 if it was entered since.
    sampled: Pos,
    /// Index of the phase.
    phase: usize,
}

impl MotionPosition {
    const NONE: MotionPosition = MotionPosition { began: 0, distance: Exact(0), over: 0, sampled: Pos(0), phase: 0 };
}

state! {
    /// A motion as far as it is prepared.
    #[derive(Debug, Clone, Copy)]
    struct Prepared {
        /// Counter of its entry.
        counter: u32 = 0,
        state: Preparation = Preparation::Nothing,
        along: MotionSpeeds = MotionSpeeds::NONE,
        shape: MotionGeometry = MotionGeometry::NONE,
        plan: SpeedPlan = SpeedPlan::NONE,
        /// The end of the FIFO, if nothing followed it when its plan was begun.
        open_end: Option<u32> = None,
    }
    const NONE;
}

/// How far a motion is prepared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Preparation {
    /// Nothing of it.
    Nothing,
    /// Some of its geometry.
    Begun,
    /// All of its geometry.
    Shaped,
    /// Some of its plan.
    Sketched,
    /// All of it, or all that a motion without length has.
    Ready,
}

/// What a step may still do, and until when the path holds if that is not enough.
struct WalkBudget {
    effects: u32,
    /// Instants left, and the last one with an effect.
    instants: u32,
    last: FineNs,
    motions: u32,
    hold: FineNs,
}

impl WalkBudget {
    /// Of a tick; the path goes on at its end if this is not enough.
    fn new(hold: FineNs) -> WalkBudget {
        WalkBudget { effects: EFFECTS, instants: INSTANTS, last: FineNs::MAX, motions: TICK_MOTIONS, hold }
    }

    /// Whether an effect of this load at this instant is carried out in this tick.
    #[inline]
    fn takes(&mut self, load: u32, at: FineNs) -> bool {
        let more = (at != self.last) as u32;
        if self.effects < load || self.instants < more {
            return false;
        }
        self.effects = self.effects.wrapping_sub(load);
        self.instants = self.instants.wrapping_sub(more);
        self.last = at;
        true
    }
}

impl Path {
    /// At standstill here, FIFOs empty (SetCrdPrm).
    pub fn position(&mut self, at: PathPos) {
        // In place, field by field: a path is some kilobytes. The pattern names the fields that
        // stay; they are not read before they are made anew.
        let Path {
            stage,
            motion_position,
            travelled: TravelledLength { length, past: _ },
            open_end,
            fifo,
            fast,
            publish_whole,
            has_slaves,
            stopping,
            pieces: Pieces { made, pair: _, follows },
            next_position: _,
            time,
            speed,
            cursors,
            motions,
            rest_position,
            rules: _,
            planning: Planning { unfinished, draft: _, speed_draft: _ },
            prepared,
            trajectory,
            trajectory_since,
        } = self;
        let on = &Path::IDLE;
        (*stage, *motion_position, *length, *open_end, *fifo) =
            (on.stage, on.motion_position, None, on.open_end, on.fifo);
        (*made, *publish_whole, *has_slaves, *stopping) = (false, on.publish_whole, on.has_slaves, on.stopping);
        (*unfinished, *fast, *follows) = (false, on.fast, None);
        (*time, *speed, *rest_position, *prepared) = (on.time, on.speed, at, on.prepared);
        cursors.iter_mut().for_each(Cursor::clear);
        motions.both.iter_mut().for_each(|made| made.state = Preparation::Nothing);
        (trajectory.count, trajectory.turns, trajectory_since.count) = (0, [None; DIMENSIONS], 0);
    }

    /// Empties a FIFO at standstill.
    pub fn clear(&mut self, fifo: u8) {
        self.discard_prepared();
        self.cursor(fifo).clear();
    }

    /// At standstill, its position gets the name `here`: its axes have other user positions now.
    pub fn rename(&mut self, here: PathPos) {
        self.discard_prepared();
        (self.rest_position, self.publish_whole) = (here, true);
    }

    /// Its position while it does not move.
    pub fn here(&self) -> PathPos {
        self.rest_position
    }

    /// Whether a start with this FIFO continues where the FIFO was interrupted.
    pub fn continues(&self, fifo: u8) -> bool {
        self.cursor_of(fifo).kept
    }

    /// Whether the motion of the coordinates between ticks is needed from now on.
    #[inline(always)]
    pub fn watch(&mut self, has_slaves: bool) {
        if has_slaves && !self.has_slaves {
            self.trajectory_since.count = 0;
        }
        if has_slaves != self.has_slaves {
            self.has_slaves = has_slaves;
            self.decide_fast_path();
        }
    }

    /// Whether it waits.
    pub fn waits(&self) -> bool {
        matches!(self.stage, PathStage::Wait { .. })
    }

    /// The end of the wait in progress, rounded down.
    pub fn waits_until(&self) -> Option<Ns> {
        if let PathStage::Wait { until } = self.stage { Some(Ns((until >> 32) as u64)) } else { None }
    }

    /// Whether it brakes.
    pub fn stops(&self) -> bool {
        self.stopping
    }

    /// For a FIFO that was interrupted within a motion, or begins within one: the geared axes, and
    /// their displacements so far.
    pub fn gears(&self, fifo: u8) -> impl Iterator<Item = (Axis, Pos)> {
        let cursor = self.cursor_of(fifo);
        let (inside, distance) = (if cursor.inside { cursor.geared } else { 0 }, cursor.distance);
        cursor.gears.iter().take(inside).map(move |gear| (gear.axis, gear.along.at(distance)))
    }

    /// The axes geared to the motion in force of a FIFO, or to its next one.
    fn gears_of(&self, fifo: u8) -> impl Iterator<Item = &ActiveGear> {
        let cursor = self.cursor_of(fifo);
        cursor.gears.iter().take(cursor.geared)
    }

    /// Whether it moves or waits.
    pub fn runs(&self) -> bool {
        !matches!(self.stage, PathStage::Standstill)
    }

    /// Entries of a FIFO that are over; their slots are free.
    pub fn released(&self, fifo: u8) -> u32 {
        self.cursor_of(fifo).released()
    }

    /// Motions of a FIFO completed since it was cleared.
    pub fn done(&self, fifo: u8) -> u32 {
        self.cursor_of(fifo).done
    }

    fn cursor_of(&self, fifo: u8) -> &Cursor {
        let [first, second] = &self.cursors;
        if fifo == 0 { first } else { second }
    }

    fn cursor(&mut self, fifo: u8) -> &mut Cursor {
        let [first, second] = &mut self.cursors;
        if fifo == 0 { first } else { second }
    }

    /// Whether it cannot start: it runs, there is nothing to do, or an interrupted FIFO would
    /// continue more than a pulse from the present position. Targets are whole pulses, so nobody
    /// can come back nearer.
    pub fn refuses_start(&self, fifo: u8, feed: FifoEnds) -> bool {
        let cursor = self.cursor_of(fifo);
        let empty = !cursor.inside && cursor.left == 0 && cursor.next == end_of(feed, fifo);
        let far = |(left, here): (&Pos, &Pos)| left.0.abs_diff(here.0) > 1 << Pos::FRAC_BITS;
        self.runs() || empty || cursor.kept && cursor.position.iter().zip(&self.rest_position).any(far)
    }

    /// Begins, or goes on, at `next`.
    pub fn start(&mut self, next: Ns, fifo: u8, feed: FifoEnds, source: &impl PathEntries) {
        self.set_off(next, fifo, feed, source);
        self.decide_fast_path();
    }

    fn set_off(&mut self, next: Ns, fifo: u8, feed: FifoEnds, source: &impl PathEntries) {
        (self.fifo, self.stopping, self.speed, self.pieces.made) = (fifo, false, Float::ZERO, false);
        self.time = (next.0 as FineNs) << 32;
        self.take_prepared_start(next, fifo);
        let cursor = self.cursor(fifo);
        cursor.kept = false;
        let Cursor { inside, from, distance, left, next: counter, .. } = *cursor;
        cursor.left = 0;
        self.wait(self.time.wrapping_add(left));
        if inside {
            let counter = counter.wrapping_sub(1);
            if self.is_known(counter) {
                self.enter_prepared(from, distance, feed, source);
                return;
            }
            self.enter(from, counter, &source.entry(fifo, counter).item());
            (self.motion_position.distance, self.motion_position.sampled) = (distance, distance.round());
            self.plan_remainder(feed, source);
        }
    }

    /// The path at `next`, published into the report of the step before; then all boundaries before
    /// `next + period`. A part of what follows is made ahead only if `may_prepare`.
    #[inline(always)]
    #[allow(clippy::too_many_arguments, reason = "a step, and where it goes to")]
    pub fn advance(
        &mut self,
        next: Ns,
        period: Ns,
        feed: FifoEnds,
        source: &impl PathEntries,
        sink: &mut impl Effects,
        report: &mut PathReport,
        may_prepare: bool,
    ) -> StepReport {
        let now = (next.0 as FineNs) << 32;
        let until = now.wrapping_add((period.0 as FineNs) << 32);
        let mut budget = WalkBudget::new(until);
        // A tick that enters a motion or makes a piece prepares nothing.
        let mut has_time = may_prepare && self.pieces.made;
        if self.is_due(next) {
            self.walk(now.wrapping_add(1), &mut budget, feed, source, sink);
            has_time = false;
        }
        if self.has_changed(feed) {
            self.extend(now, feed, source);
            self.walk(now.wrapping_add(1), &mut budget, feed, source, sink);
            has_time = false;
        }
        let (fifo, done, before) = (self.fifo, self.done(self.fifo), self.motion_position.sampled);
        let released = [self.released(0), self.released(1)];
        if self.look(next, report) {
            let geared = self.cursor_of(fifo).geared != 0;
            let distance = if geared { self.distance_at(now) } else { self.motion_position.sampled.into() };
            if !self.admits(report.position, distance, sink) {
                self.hold(now, (self.sampled(before), distance), sink, feed);
                self.look(next, report);
                self.decide_fast_path();
                return StepReport { runs: false, fifo, done, released };
            }
            if geared {
                self.carry(distance, sink);
            }
        }
        let runs = self.runs();
        if self.is_due_before(next, period) {
            self.walk(until, &mut budget, feed, source, sink);
        } else if has_time {
            self.prepare(feed, source);
        }
        self.decide_fast_path();
        StepReport { runs, fifo, done, released }
    }

    /// The rest of a step whose position at `next` the fast path has published: all
    /// boundaries before `next + period`.
    #[inline(always)]
    pub fn go_through(
        &mut self,
        next: Ns,
        period: Ns,
        feed: FifoEnds,
        source: &impl PathEntries,
        sink: &mut impl Effects,
    ) {
        let until = ((next.0.wrapping_add(period.0)) as FineNs) << 32;
        let mut budget = WalkBudget::new(until);
        self.walk(until, &mut budget, feed, source, sink);
        self.decide_fast_path();
    }

    /// FIFO in force, or that was last.
    pub fn fifo(&self) -> u8 {
        self.fifo
    }

    /// What is published has to be written as a whole.
    pub fn is_fresh(&self) -> bool {
        self.publish_whole
    }

    /// Whether a boundary lies at or before `next`.
    #[inline(always)]
    pub fn is_due(&self, next: Ns) -> bool {
        self.motion_position.over <= (next.0 as FineNs) << 32
    }

    /// Whether one lies before `next + period`.
    #[inline(always)]
    pub fn is_due_before(&self, next: Ns, period: Ns) -> bool {
        self.is_due_until(Ns(next.0.wrapping_add(period.0)))
    }

    /// Whether one lies before `until`.
    #[inline(always)]
    pub(crate) fn is_due_until(&self, until: Ns) -> bool {
        ((self.motion_position.over >> 32) as u64) < until.0
    }

    /// Whether data has come where the FIFO had ended.
    #[inline(always)]
    fn has_changed(&self, feed: FifoEnds) -> bool {
        self.open_end.is_some_and(|sampled| sampled != end_of(feed, self.fifo))
    }
}

fn end_of(feed: FifoEnds, fifo: u8) -> u32 {
    let [first, second] = feed.ends;
    if fifo == 0 { first } else { second }
}
