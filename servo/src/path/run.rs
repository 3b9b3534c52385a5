//! A coordinate system that moves.
//!
//! In: entries from two FIFOs and how many of them are there, instants, Stops. Out: a [`Step`] a tick; what entries
//! do, with exact instants, to an [`Effects`]. Owns: the motion in force, a cursor for each FIFO. Fails: entries that
//! run out at speed end the path there, [`Rest::Underrun`].
//!
//! [`Path::step`] for the tick at `t` first passes the boundaries up to `t`, looks where the path is, and then passes
//! those before `t + period`: the path stands a period ahead of what it shows. A Stop, an override and new data act
//! at `t`, which no boundary beyond has been told of yet.
mod motions;

use super::entry::{Along, Change, Entry, Item, Rate};
use super::plan::{Plan, Sketch};
use super::shape::{Along as Geared, Bend, Draft, Shape};
use super::store::Entries;
use super::{DIMENSIONS, Fine};
use crate::laser::PathSpeed;
use crate::piece::{Motion, Piece, Scaled};
use crate::ramp::Accel;
use crate::real::Real;
use crate::units::{Axis, Exact, Ns, Pos};

/// Entries with effects in a tick (SPEC 5); the path holds before the next one until the next tick. As many may stand
/// between two motions that are passed at speed.
pub(crate) const EFFECTS: u32 = 8;
/// Motions entered in a tick; the same holds.
const MOTIONS: u32 = 32;
/// Axes that go along with one motion.
pub const GEARS: usize = 4;

/// What a path does to the rest of the machine. Instants come in order; all lie before the end of the interval that
/// the step is for, and after everything told in earlier steps.
pub trait Effects {
    /// An entry takes effect. Returns how long the path waits for it: a modal move's time, else 0.
    fn change(&mut self, at: Fine, change: &Change) -> Fine;
    /// The path comes to rest.
    fn rest(&mut self, at: Fine, rest: Rest);
    /// An axis goes along with the motion in force: its displacement since the motion began, at the step's tick, and
    /// its way per way of the path.
    fn gear(&mut self, axis: Axis, by: Pos, ratio: Scaled);
    /// An axis has gone along to the end of a motion, which moved it by this much.
    fn geared(&mut self, axis: Axis, pulses: i32);
    /// More axes than a path can take along with one motion; this one stays.
    fn surplus(&mut self, _axis: Axis) {}
    /// Whether the path may be at this place; else it comes to rest before it.
    fn admits(&mut self, _place: &[Pos; DIMENSIONS]) -> bool {
        true
    }
}

/// Why a path comes to rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Rest {
    /// It never moved.
    #[default]
    Never,
    /// Its entries have run out.
    Completed,
    /// Its entries have run out at speed.
    Underrun,
    /// A Stop. It can go on.
    Stopped,
    /// A place that it must not go to. It can go on from there.
    Obstructed,
}

/// How many entries of each FIFO are there, counted since it was cleared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Feed {
    /// Of FIFO 0 and 1.
    pub ends: [u32; 2],
}

/// What holds for all motions of a coordinate system.
#[derive(Debug, Clone, Copy)]
pub struct Rules {
    even: Real,
    stop: Real,
    rate: Real,
}

impl Rules {
    /// No even time, a stop deceleration of 1 pulse/ms², no override.
    pub const POWER_ON: Rules = Rules { even: Real::ZERO, stop: Real::ONE, rate: Real::ONE };

    /// Least time at constant speed in a motion (TCrdPrm.evenTime), ms.
    pub fn set_even(&mut self, ms: u16) {
        self.even = Real::new(false, ms as u64, 0);
    }

    /// Deceleration of a smooth Stop.
    pub fn set_stop(&mut self, dec: Accel) {
        self.stop = dec.magnitude();
    }

    /// Override: the speeds of all motions are multiplied by it. The speeds at their ends are not, but held to these.
    pub fn set_rate(&mut self, rate: Rate) {
        self.rate = rate.real();
    }
}

/// The path at one tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Step {
    /// Coordinates.
    pub place: [Pos; DIMENSIONS],
    /// Direction of motion, a unit vector in 2⁻³⁰: times the path's velocity it is that of each coordinate. Zeros where
    /// it does not move.
    pub heading: [i32; DIMENSIONS],
    /// The way along the motion in force as a piece: its velocity is the path's.
    pub motion: Motion,
    /// How the direction turns.
    pub bend: Bend,
    /// Whether it runs; it also does while it waits.
    pub runs: bool,
    /// FIFO in force.
    pub fifo: u8,
    /// Motions of it completed since it was cleared.
    pub done: u32,
}

/// Where a path shows where it is; what has not changed is not written again.
pub struct Sight<'a> {
    /// Coordinates.
    pub place: &'a mut [Pos; DIMENSIONS],
    /// Direction.
    pub heading: &'a mut [i32; DIMENSIONS],
    /// How it turns.
    pub bend: &'a mut Bend,
    /// The way along the motion in force.
    pub motion: &'a mut Motion,
    /// Counts changes of bend and motion but for the place in it.
    pub turns: &'a mut u32,
}

/// What else a step tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Told {
    /// Whether it runs; it also does while it waits.
    pub runs: bool,
    /// FIFO in force.
    pub fifo: u8,
    /// Motions of it completed since it was cleared.
    pub done: u32,
}

/// What goes along with a motion.
#[derive(Debug, Clone, Copy)]
struct Gear {
    axis: Axis,
    pulses: i32,
    along: Geared,
}

/// Where one FIFO stands.
#[derive(Debug, Clone, Copy)]
struct Cursor {
    /// Counter of the next entry.
    next: u32,
    /// Motions completed.
    done: u32,
    /// The motion before `next` is not over.
    inside: bool,
    /// It was left with something to do, at `place`.
    kept: bool,
    place: [Pos; DIMENSIONS],
    /// Of that motion: where it began, and the way done.
    from: [Pos; DIMENSIONS],
    way: Exact,
    /// What is left of a wait.
    left: Fine,
    gears: [Gear; GEARS],
    geared: usize,
}

const NO_GEAR: Gear = Gear { axis: Axis::FIRST, pulses: 0, along: Geared::NONE };
const ORIGIN: [Pos; DIMENSIONS] = [Pos(0); DIMENSIONS];

impl Cursor {
    const NEW: Cursor = Cursor {
        next: 0,
        done: 0,
        inside: false,
        kept: false,
        place: ORIGIN,
        from: ORIGIN,
        way: Exact(0),
        left: 0,
        gears: [NO_GEAR; GEARS],
        geared: 0,
    };
}

/// What the path does now.
#[derive(Debug, Clone, Copy)]
enum Stage {
    /// Nothing.
    Rest,
    /// It waits where it is.
    Wait { until: Fine },
    /// It is in a leg of a motion.
    Move,
}

/// What stands behind a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Behind {
    /// Another motion.
    Motion,
    /// A wait, or more effects than a tick carries out.
    Halt,
    /// Nothing so far.
    Nothing,
}

/// A coordinate system that moves.
#[derive(Debug, Clone, Copy)]
pub struct Path {
    /// Holds for all motions; a change acts on the motion in force with [`Path::replan`].
    pub rules: Rules,
    stage: Stage,
    cursors: [Cursor; 2],
    fifo: u8,
    /// Where it is while it does not move.
    here: [Pos; DIMENSIONS],
    /// The instant up to which all boundaries have been passed, and the speed there.
    time: Fine,
    speed: Real,
    stopping: bool,
    /// The motion in force, and the one behind it, made ahead in ticks that have time for it.
    motions: [Made; 2],
    /// Which of them is in force.
    at: u8,
    /// What is being made of the other.
    draft: Draft,
    sketch: Sketch,
    /// Which leg, when it began, and the way done there.
    leg: usize,
    began: Fine,
    way: Exact,
    /// The leg as a piece, once it is needed, and the one behind it, if it is made ahead.
    pieces: [Piece; 2],
    /// Which of them is in force.
    piece: u8,
    /// The piece in force is made.
    pieced: bool,
    /// When the piece behind it begins, if it is made.
    follows: Option<Fine>,
    /// What is shown has to be written as a whole.
    fresh: bool,
    /// The way along the motion in force when it was looked at last; since then, the way to the end of the last leg
    /// that has ended, if one has.
    seen: Pos,
    swept: Option<Exact>,
    /// The way along the motion in force at which it was looked at last, or 0 if it was entered since.
    floor: Exact,
    /// The end of the FIFO, if nothing stood behind the motion when it was planned.
    open: Option<u32>,
    /// The whole ns in which the leg or the wait in force is over.
    due: u64,
    /// Whether somebody follows a coordinate; then what happens between looks is kept: up to the last look, and since.
    led: bool,
    wake: Wake,
    since: Wake,
}

/// What the coordinates did between two ticks, for those that follow one of them.
#[derive(Debug, Clone, Copy)]
pub struct Wake {
    /// Boundaries that were passed, and where: the first ones and the last one.
    knots: [(Fine, [Pos; DIMENSIONS]); KNOTS],
    count: u8,
    /// Of each coordinate: whether it turned round on an arc behind the last of them: the share of the time since, in
    /// 2⁻⁶⁴, and where.
    turns: [Option<(u64, Pos)>; DIMENSIONS],
}

/// Boundaries of an interval that a wake keeps.
const KNOTS: usize = 3;

impl Wake {
    const NONE: Wake = Wake { knots: [(0, ORIGIN); KNOTS], count: 0, turns: [None; DIMENSIONS] };

    fn pass(&mut self, at: Fine, place: [Pos; DIMENSIONS]) {
        let index = (self.count as usize).min(KNOTS - 1);
        if let Some(knot) = self.knots.get_mut(index) {
            *knot = (at, place);
        }
        self.count = index as u8 + 1;
    }

    /// Boundaries in the order of time.
    pub fn knots(&self) -> &[(Fine, [Pos; DIMENSIONS])] {
        self.knots.get(..self.count as usize).unwrap_or_default()
    }

    /// Where a coordinate turned round behind them.
    pub fn turn(&self, index: usize) -> Option<(u64, Pos)> {
        self.turns.get(index).copied().flatten()
    }
}

/// A motion as far as it is made.
#[derive(Debug, Clone, Copy)]
struct Made {
    /// Counter of its entry.
    counter: u32,
    state: State,
    along: Along,
    shape: Shape,
    plan: Plan,
    /// The end of the FIFO, if nothing stood behind it when its plan was begun.
    open: Option<u32>,
}

/// How far a motion is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum State {
    /// Nothing of it.
    Nothing,
    /// Some of its geometry.
    Begun,
    /// All of its geometry.
    Shaped,
    /// Some of its plan.
    Sketched,
    /// All of it, or all that one without length has.
    Ready,
}

impl Made {
    const NOTHING: Made = Made {
        counter: 0,
        state: State::Nothing,
        along: Along::NONE,
        shape: Shape::NONE,
        plan: Plan::NONE,
        open: None,
    };
}

/// What a step may still do, and until when the path holds if that is not enough.
struct Budget {
    effects: u32,
    motions: u32,
    hold: Fine,
}

impl Path {
    /// At rest in the origin, FIFOs empty.
    pub const IDLE: Path = Path {
        rules: Rules::POWER_ON,
        stage: Stage::Rest,
        cursors: [Cursor::NEW; 2],
        fifo: 0,
        here: ORIGIN,
        time: 0,
        speed: Real::ZERO,
        stopping: false,
        motions: [Made::NOTHING; 2],
        at: 0,
        draft: Draft::Nothing,
        sketch: Sketch::NONE,
        leg: 0,
        began: 0,
        way: Exact(0),
        pieces: [Piece::rest(Ns(0), 0, Pos(0)); 2],
        piece: 0,
        pieced: false,
        follows: None,
        fresh: true,
        seen: Pos(0),
        swept: None,
        floor: Exact(0),
        open: None,
        due: 0,
        led: false,
        wake: Wake::NONE,
        since: Wake::NONE,
    };

    /// At rest here, FIFOs empty (SetCrdPrm).
    pub fn place(&mut self, here: [Pos; DIMENSIONS]) {
        let rules = self.rules;
        *self = Path { rules, here, ..Path::IDLE };
    }

    /// Empties a FIFO at rest.
    pub fn clear(&mut self, fifo: u8) {
        *self.cursor(fifo) = Cursor::NEW;
    }

    /// At rest, it is here: its axes are called something else now.
    pub fn rename(&mut self, here: [Pos; DIMENSIONS]) {
        (self.here, self.fresh) = (here, true);
    }

    /// Where it is while it does not move.
    pub fn here(&self) -> [Pos; DIMENSIONS] {
        self.here
    }

    /// Whether a start with this FIFO goes on where the FIFO was left.
    pub fn goes_on(&self, fifo: u8) -> bool {
        self.cursor_of(fifo).kept
    }

    /// Whether what the coordinates do between ticks is wanted from now on.
    #[inline(always)]
    pub fn watch(&mut self, led: bool) {
        if led && !self.led {
            self.since.count = 0;
        }
        self.led = led;
    }

    /// What they did up to the last look.
    pub fn wake(&self) -> &Wake {
        &self.wake
    }

    /// Whether it waits.
    pub fn waits(&self) -> bool {
        matches!(self.stage, Stage::Wait { .. })
    }

    /// Whether it brakes.
    pub fn stops(&self) -> bool {
        self.stopping
    }

    /// Of a FIFO that was left, or begins, within a motion: the axes that go along, and how far they have gone.
    pub fn gears(&self, fifo: u8) -> impl Iterator<Item = (Axis, Pos)> {
        let cursor = self.cursor_of(fifo);
        let (inside, way) = (if cursor.inside { cursor.geared } else { 0 }, cursor.way.round());
        cursor.gears.iter().take(inside).map(move |gear| (gear.axis, gear.along.at(way)))
    }

    /// Whether it moves or waits.
    pub fn runs(&self) -> bool {
        !matches!(self.stage, Stage::Rest)
    }

    /// Entries of a FIFO that are over; their places are free.
    pub fn released(&self, fifo: u8) -> u32 {
        let cursor = self.cursor_of(fifo);
        cursor.next.wrapping_sub(cursor.inside as u32)
    }

    /// Motions of a FIFO completed since it was cleared.
    pub fn done(&self, fifo: u8) -> u32 {
        self.cursor_of(fifo).done
    }

    /// The motion in force. The mask is the bound: the check folds away.
    #[inline(always)]
    fn motion(&self) -> &Made {
        &self.motions[(self.at & 1) as usize]
    }

    #[inline(always)]
    fn motion_mut(&mut self) -> &mut Made {
        &mut self.motions[(self.at & 1) as usize]
    }

    /// The one behind it.
    #[inline(always)]
    fn ahead(&self) -> &Made {
        &self.motions[(!self.at & 1) as usize]
    }

    #[inline(always)]
    fn ahead_mut(&mut self) -> &mut Made {
        &mut self.motions[(!self.at & 1) as usize]
    }

    fn cursor_of(&self, fifo: u8) -> &Cursor {
        let [first, second] = &self.cursors;
        if fifo == 0 { first } else { second }
    }

    fn cursor(&mut self, fifo: u8) -> &mut Cursor {
        let [first, second] = &mut self.cursors;
        if fifo == 0 { first } else { second }
    }

    /// Whether it cannot start: it runs, there is nothing to do, or a FIFO that was left is to go on from a place
    /// where the path is not.
    pub fn refuses_start(&self, fifo: u8, feed: Feed) -> bool {
        let cursor = self.cursor_of(fifo);
        let empty = !cursor.inside && cursor.left == 0 && cursor.next == end_of(feed, fifo);
        self.runs() || empty || cursor.kept && cursor.place != self.here
    }

    /// Begins, or goes on, at `next`.
    pub fn start(&mut self, next: Ns, fifo: u8, feed: Feed, source: &impl Entries) {
        (self.fifo, self.stopping, self.speed) = (fifo, false, Real::ZERO);
        self.ahead_mut().state = State::Nothing;
        self.time = (next.0 as Fine) << 32;
        let cursor = self.cursor(fifo);
        cursor.kept = false;
        let Cursor { inside, from, way, left, next: counter, .. } = *cursor;
        cursor.left = 0;
        self.wait(self.time.wrapping_add(left));
        if inside {
            let counter = counter.wrapping_sub(1);
            self.enter(from, counter, &source.entry(fifo, counter).item());
            (self.way, self.floor) = (way, way);
            self.plan_rest(feed, source);
        }
    }

    /// Smooth: brakes along the path from `next` on. Abrupt: stands still there.
    pub fn stop(&mut self, next: Ns, abrupt: bool, feed: Feed, source: &impl Entries, sink: &mut impl Effects) {
        let now = (next.0 as Fine) << 32;
        match self.stage {
            Stage::Rest => {}
            Stage::Wait { until } => {
                self.cursor(self.fifo).left = until.saturating_sub(now);
                self.rest(now, Rest::Stopped, feed, sink);
            }
            Stage::Move if abrupt => {
                self.catch_up(now);
                self.halt(now, Rest::Stopped, feed, sink);
            }
            Stage::Move => {
                self.stopping = true;
                self.catch_up(now);
                self.plan_rest(feed, source);
            }
        }
    }

    /// The motion in force is planned anew from `next` on, because a rule has changed.
    pub fn replan(&mut self, next: Ns, feed: Feed, source: &impl Entries) {
        if let Stage::Move = self.stage {
            self.catch_up((next.0 as Fine) << 32);
            self.plan_rest(feed, source);
        }
    }

    /// The path at `next`; then all boundaries before `next + period`.
    pub fn step(&mut self, next: Ns, period: Ns, feed: Feed, source: &impl Entries, sink: &mut impl Effects) -> Step {
        let (heading, bend, motion) = ([0; DIMENSIONS], Bend::STRAIGHT, Motion::REST);
        let mut step = Step { place: ORIGIN, heading, bend, motion, runs: false, fifo: 0, done: 0 };
        let Step { place, heading, bend, motion, .. } = &mut step;
        self.fresh = true;
        let mut sight = Sight { place, heading, bend, motion, turns: &mut 0 };
        let told = self.advance(next, period, feed, source, sink, &mut sight, true);
        Step { runs: told.runs, fifo: told.fifo, done: told.done, ..step }
    }

    /// The same, shown where it was shown in the step before; something of what follows is made ahead only where
    /// `may_prepare`.
    #[inline(always)]
    #[allow(clippy::too_many_arguments, reason = "a step, and where it goes to")]
    pub fn advance(
        &mut self,
        next: Ns,
        period: Ns,
        feed: Feed,
        source: &impl Entries,
        sink: &mut impl Effects,
        sight: &mut Sight<'_>,
        may_prepare: bool,
    ) -> Told {
        let now = (next.0 as Fine) << 32;
        let until = now.wrapping_add((period.0 as Fine) << 32);
        let mut budget = Budget { effects: EFFECTS, motions: MOTIONS, hold: until };
        if self.due <= next.0 {
            self.walk(now.wrapping_add(1), &mut budget, feed, source, sink);
        }
        if let Some(seen) = self.open
            && seen != end_of(feed, self.fifo)
        {
            self.extend(now, feed, source);
            self.walk(now.wrapping_add(1), &mut budget, feed, source, sink);
        }
        // A tick that makes a piece does not make anything ahead.
        let has_time = may_prepare && self.pieced;
        let (fifo, done) = (self.fifo, self.done(self.fifo));
        let moves = self.look(next, sink, sight);
        if moves && !sink.admits(sight.place) {
            self.hold(now, Exact::from(self.seen), sink, feed);
            self.look(next, sink, sight);
            return Told { runs: false, fifo, done };
        }
        let runs = self.runs();
        self.floor = Exact::from(self.seen);
        if self.due < next.0.wrapping_add(period.0) {
            self.walk(until, &mut budget, feed, source, sink);
        } else if has_time {
            self.prepare(feed, source);
        }
        Told { runs, fifo, done }
    }

    /// Where it is at `next`, which lies in the leg in force; whether it moves.
    #[inline(always)]
    fn look(&mut self, next: Ns, sink: &mut impl Effects, sight: &mut Sight<'_>) -> bool {
        (self.seen, self.swept) = (Pos(0), None);
        if let Stage::Move = self.stage
            && let Some(leg) = self.motions[(self.at & 1) as usize].plan.leg(self.leg)
        {
            let piece = &mut self.pieces[(self.piece & 1) as usize];
            if !self.pieced {
                (self.pieced, self.fresh) = (true, true);
                *piece = leg.piece(self.began, self.way);
            }
            let before = *sight.heading;
            let shape = &self.motions[(self.at & 1) as usize].shape;
            if self.fresh {
                self.fresh = false;
                *sight.motion = piece.motion;
                *sight.turns = sight.turns.wrapping_add(1);
                shape.show(sight.place, sight.heading, sight.bend);
            }
            let (way, tau) = piece.at(piece.held(next));
            (self.seen, sight.motion.tau) = (way, tau);
            shape.follow(way, sight.place, sight.heading);
            if self.led {
                self.leave_wake(before, sight.heading);
            }
            let cursor = self.cursor_of(self.fifo);
            for gear in cursor.gears.iter().take(cursor.geared) {
                sink.gear(gear.axis, gear.along.at(way), gear.along.ratio());
            }
            return true;
        }
        if self.led {
            (self.wake, self.since.count) = (self.since, 0);
        }
        if self.fresh {
            self.fresh = false;
            *sight.turns = sight.turns.wrapping_add(1);
            (*sight.place, *sight.heading) = (self.here, [0; DIMENSIONS]);
            (*sight.bend, *sight.motion) = (Bend::STRAIGHT, Motion::REST);
        }
        false
    }

    /// What the coordinates have done up to this look, at which they go in this direction.
    #[inline(never)]
    fn leave_wake(&mut self, before: [i32; DIMENSIONS], heading: &[i32; DIMENSIONS]) {
        (self.wake, self.since.count) = (self.since, 0);
        let shape = &self.motions[(self.at & 1) as usize].shape;
        let still = before == [0; DIMENSIONS];
        let before = if self.wake.count != 0 || still { shape.outset() } else { before };
        for (index, ((turn, before), now)) in self.wake.turns.iter_mut().zip(before).zip(heading).enumerate() {
            let turned = before > 0 && *now < 0 || before < 0 && *now > 0;
            let (gone, left) = (before.unsigned_abs() as u64, now.unsigned_abs() as u64);
            // Near its summit a coordinate's direction changes evenly with the way.
            *turn = shape.summit(index, before > 0).filter(|_| turned).map(|summit| {
                let whole = gone.wrapping_add(left);
                (crate::wide::Recip::of(whole).ratio(gone.min(whole.wrapping_sub(1))), summit)
            });
        }
    }

    /// The motion in force must not go as far as `way`, where it is or would be at `at`: it comes to rest before.
    #[inline(never)]
    fn hold(&mut self, at: Fine, way: Exact, sink: &mut impl Effects, feed: Feed) {
        // The furthest place since the last look that is admitted, to 2⁻¹⁶ of that way; where it was then if none is.
        let (mut low, mut high) = (self.floor, way);
        for _ in 0..16 {
            let middle = Exact(low.0.wrapping_add(high.0) >> 1);
            if sink.admits(&self.motion().shape.at(middle.round())) { low = middle } else { high = middle }
        }
        self.way = low;
        self.halt(at, Rest::Obstructed, feed, sink);
    }

    /// The mean speed of the interval of `period` from `next` on, of which `motion` was shown: what the laser's power
    /// follows.
    pub fn mean(&self, motion: &Motion, next: Ns, period: Ns) -> PathSpeed {
        let Some(swept) = self.swept else { return PathSpeed::ahead(motion, period) };
        let mut way = swept.0;
        if let Stage::Move = self.stage
            && let Some(leg) = self.motion().plan.leg(self.leg)
        {
            let until = (next.0.wrapping_add(period.0) as Fine) << 32;
            way = way.wrapping_add(leg.way(until.saturating_sub(self.began)).0);
        }
        PathSpeed::mean(Exact(way), period)
    }

    /// It waits where it is.
    fn wait(&mut self, until: Fine) {
        (self.stage, self.due, self.fresh) = (Stage::Wait { until }, (until >> 32) as u64, true);
    }

    /// The leg in force ends then; what has no leg left is over now.
    fn set_due(&mut self) {
        let left = self.motion().plan.leg(self.leg).map_or(0, |leg| leg.time);
        self.due = (self.began.wrapping_add(left) >> 32) as u64;
    }

    /// Passes all boundaries before `limit`.
    fn walk(&mut self, limit: Fine, budget: &mut Budget, feed: Feed, source: &impl Entries, sink: &mut impl Effects) {
        loop {
            match self.stage {
                Stage::Rest => return,
                Stage::Wait { until } => {
                    if until >= limit {
                        return;
                    }
                    self.time = until;
                    self.swept = self.swept.or(Some(Exact(0)));
                    self.go_on(budget, feed, source, sink);
                }
                Stage::Move => match self.motion().plan.leg(self.leg) {
                    Some(leg) => {
                        let over = self.began.wrapping_add(leg.time);
                        if over >= limit {
                            return;
                        }
                        let length = leg.length().0;
                        self.way = Exact(self.way.0.wrapping_add(length));
                        self.swept = Some(Exact(match self.swept {
                            Some(swept) => swept.0.wrapping_add(length),
                            None => self.way.0.wrapping_sub(Exact::from(self.seen).0),
                        }));
                        (self.began, self.time) = (over, over);
                        self.leg = self.leg.wrapping_add(1);
                        if self.motion().plan.leg(self.leg).is_some() {
                            self.take_piece();
                        }
                        self.set_due();
                    }
                    None if self.motion().plan.halts => self.halt(self.time, Rest::Stopped, feed, sink),
                    None if !sink.admits(&self.motion().shape.end()) => {
                        let way = self.motion().shape.length().to_exact();
                        self.hold(self.time, way, sink, feed);
                    }
                    None => {
                        self.leave(sink);
                        self.go_on(budget, feed, source, sink);
                    }
                },
            }
        }
    }

    /// The motion in force is over.
    fn leave(&mut self, sink: &mut impl Effects) {
        let Made { shape, plan, .. } = self.motion();
        (self.here, self.speed, self.open) = (shape.end(), plan.exit, None);
        if self.led {
            self.since.pass(self.time, self.here);
        }
        let cursor = self.cursor(self.fifo);
        cursor.inside = false;
        cursor.done = cursor.done.wrapping_add(1);
        for gear in cursor.gears.iter().take(cursor.geared) {
            sink.geared(gear.axis, gear.pulses);
        }
        cursor.geared = 0;
    }

    /// At a boundary: on to the next motion, wait or rest.
    fn go_on(&mut self, budget: &mut Budget, feed: Feed, source: &impl Entries, sink: &mut impl Effects) {
        loop {
            let counter = self.cursor(self.fifo).next;
            if counter == end_of(feed, self.fifo) {
                let rest = if self.speed.is_zero() { Rest::Completed } else { Rest::Underrun };
                self.rest(self.time, rest, feed, sink);
                return;
            }
            if self.stopping && self.speed.is_zero() {
                self.rest(self.time, Rest::Stopped, feed, sink);
                return;
            }
            let entry = source.entry(self.fifo, counter);
            let left = if entry.is_motion() { &mut budget.motions } else { &mut budget.effects };
            if *left == 0 {
                self.wait(budget.hold);
                return;
            }
            *left = left.wrapping_sub(1);
            self.cursor(self.fifo).next = counter.wrapping_add(1);
            if let Some(until) = self.take(counter, &entry, feed, source, sink) {
                self.wait(until);
                self.speed = Real::ZERO;
                return;
            }
            if entry.is_motion() {
                if self.motion().shape.length().is_zero() {
                    let speed = self.speed;
                    self.leave(sink);
                    self.speed = speed;
                } else {
                    return;
                }
            }
        }
    }

    /// Carries out an entry; the instant until which the path waits for it.
    fn take(
        &mut self,
        counter: u32,
        entry: &Entry,
        feed: Feed,
        source: &impl Entries,
        sink: &mut impl Effects,
    ) -> Option<Fine> {
        if self.ahead().state != State::Nothing && self.ahead().counter == counter {
            self.enter_prepared(feed, source);
            return None;
        }
        match &entry.item() {
            Item::Nothing => None,
            Item::Delay { ms } => Some(self.time.wrapping_add((*ms as Fine * 1_000_000) << 32)),
            Item::Change(change) => {
                let wait = sink.change(self.time, change);
                (wait != 0).then(|| self.time.wrapping_add(wait))
            }
            Item::Gear { axis, pulses } => {
                let cursor = self.cursor(self.fifo);
                if let Some(gear) = cursor.gears.iter_mut().take(cursor.geared).find(|gear| gear.axis == *axis) {
                    gear.pulses = gear.pulses.saturating_add(*pulses);
                } else if let Some(gear) = cursor.gears.get_mut(cursor.geared) {
                    *gear = Gear { axis: *axis, pulses: *pulses, along: Geared::NONE };
                    cursor.geared = cursor.geared.wrapping_add(1);
                } else {
                    sink.surplus(*axis);
                }
                None
            }
            item => {
                self.enter(self.here, counter, item);
                (self.way, self.floor) = (Exact(0), Exact(0));
                if !self.motion().shape.length().is_zero() {
                    self.plan_rest(feed, source);
                }
                None
            }
        }
    }

    /// Comes to rest within a motion.
    fn halt(&mut self, at: Fine, rest: Rest, feed: Feed, sink: &mut impl Effects) {
        self.here = self.motion().shape.at(self.way.round());
        let way = self.way;
        self.cursor(self.fifo).way = way;
        self.rest(at, rest, feed, sink);
    }

    /// Comes to rest here.
    fn rest(&mut self, at: Fine, rest: Rest, feed: Feed, sink: &mut impl Effects) {
        (self.stage, self.speed, self.stopping, self.open) = (Stage::Rest, Real::ZERO, false, None);
        (self.due, self.fresh) = (u64::MAX, true);
        let (here, end) = (self.here, end_of(feed, self.fifo));
        let cursor = self.cursor(self.fifo);
        cursor.kept = cursor.inside || cursor.left != 0 || cursor.next != end;
        cursor.place = here;
        sink.rest(at, rest);
    }
}

fn end_of(feed: Feed, fifo: u8) -> u32 {
    let [first, second] = feed.ends;
    if fifo == 0 { first } else { second }
}
