//! Look-ahead: the speeds at the corners of a path.
//!
//! In: motions in order, and what stands between them. Out: their speeds, as soon as these are
//! final, or at once if the stream has run low. Owns: what a plan needs of `N` motions that wait;
//! the entries themselves wait in the FIFO's store (`path_queue.rs`).
//! Fails: never; a full queue returns false, and a motion must be taken first.
//!
//! **The rule.** The velocity of coordinate i never exceeds its limit, nor does its acceleration
//! within a motion. A corner changes its velocity by Δᵢ·v at once. This jump is limited to the
//! change that its acceleration makes in the corner time T (the max-acceleration rule). It is also
//! limited by the mean acceleration from the middle of the motion before to the middle of the
//! motion after. That mean keeps the limit together with the path's own acceleration. So does the
//! mean between the middles of any two motions, on finely divided curves as on long lines.
//! On an arc three accelerations are added as if they had one direction: the one along it, v²/R,
//! and that of a corner at its end. Their sum stays inside a polygon within the circle of the
//! lowest limit. velEnd of the calls is not used, except through the waits between them.
//! On an arc they leave a part of the acceleration along it, for going on after a Stop.
//!
//! **The plan.** Backwards from a stop at the end of the queue: at each junction the square of the
//! highest speed from which all that follows can be kept (`reachable.rs`). Forwards: as fast as
//! these allow. More data can only raise these speeds. So the speeds handed over are always safe,
//! and final if more data could not raise them.
//! Work: one plan for all that was pushed since the last take, back over as many motions as braking
//! takes. So push all data, then take.
//!
//! **A full queue.** Where braking takes more motions than it holds, every further motion raises
//! all speeds, and a plan for each would take all motions each time. So several leave under one
//! plan ([`LookAhead::hold_level`]). What more data can raise does not speed up above the level
//! that the last of them can keep. Else the path would brake under each plan and speed up under the
//! next.
mod junction;
mod reachable;
mod rounding;

use super::geometry::{Geometry, Position};
use heapless::Vec;
use junction::{Junction, LastMotion, STANDSTILL};
use libm::{fabs, sqrt};
pub(crate) use reachable::rounded_down;
use reachable::{ARC_SQUARE_SHARE, BOUNDS_MAX, Bound, ChosenMotion, Corner, EndSpeed, Span, Steps};
use rounding::Chords;
use servo::path::{MotionSpeeds, PathEntry, Plane};

/// Limits of a coordinate system.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Speeds of X, Y, Z, A, pulse/ms.
    pub vel: Position,
    /// Accelerations, pulse/ms².
    pub acc: Position,
    /// Corner time, ms.
    pub corner: f64,
}

impl Limits {
    /// Speed along a motion within these limits.
    pub fn speed(&self, geometry: &Geometry, vel: f64) -> f64 {
        let (vel, ..) = self.hold(geometry, &direction(geometry), vel, 0.0);
        vel
    }

    /// Speed and acceleration along a motion within these limits; of an arc also its radius and the
    /// limit of its accelerations.
    fn hold(&self, geometry: &Geometry, direction: &Position, vel: f64, acc: f64) -> (f64, f64, Option<(f64, f64)>) {
        let Limits { vel: most, acc: hardest, .. } = self;
        let (mut vel, mut acc) = (vel, acc);
        for (share, (most, hardest)) in direction.iter().zip(most.iter().zip(hardest)) {
            let share = fabs(*share);
            if share > 0.0 {
                vel = vel.min(most / share);
                acc = acc.min(hardest / share);
            }
        }
        let least =
            |axes: [usize; 2]| axes.iter().filter_map(|axis| hardest.get(*axis)).copied().fold(f64::INFINITY, f64::min);
        let round = geometry.round.map(|(radius, axes)| (radius, least(axes)));
        if let Some((radius, limit)) = round {
            vel = vel.min(sqrt(radius * limit * ARC_SQUARE_SHARE));
        }
        (vel, acc, round)
    }
}

/// Largest load of entries between two motions that the path passes at speed; with more it stops
/// there.
const EFFECTS: u32 = 32;
/// Without need, a full queue is planned so many times while its motions are replaced.
const PLANS_PER_QUEUE: usize = 4;
/// This part of the motions leaves under one plan where their speeds are not final.
const BATCH_PARTS: usize = 32;
/// Lowest speed (pulse/ms) and acceleration (pulse/ms²) of a motion.
pub const SPEED_MIN_PULSES_PER_MS: f64 = 1.0 / 1048576.0;

/// A line, or an arc in a plane.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(u8)]
enum Course {
    Line,
    Xy,
    Yz,
    Zx,
}

servo::state! {
    /// A motion that waits, in 64 bytes. Shares of limits are kept as f32: their rounding is far
    /// below the margin of a plan. Speeds are exact where motions of one speed meet.
    #[derive(Debug, Clone, Copy)]
    struct WaitingMotion {
        /// Speed along it, as its limits allow.
        vel: f64 = 0.0,
        /// The junction at its start.
        start: Junction = STANDSTILL,
        /// Of a line its direction; of an arc its radius and the limit of its accelerations.
        shape: [f32; 4] = [0.0; 4],
        length: f32 = 0.0,
        /// Acceleration along it, as its limits allow.
        acc: f32 = 0.0,
        /// The highest square of the speed at its start from which all that follows can be kept. As
        /// much as the junction allows is infinite, and not planned yet is NaN.
        start_square: f32 = 0.0,
        /// Entries that follow it, before the next motion.
        entries_after: u16 = 0,
        course: Course = Course::Line,
        /// [`EITHER_SIDE`] and [`FINAL`].
        flags: u8 = 0,
    }
    /// All bytes are zero.
    const EMPTY;
}

/// The bends of the junction may go to either side.
const EITHER_SIDE: u8 = 1;
/// More data cannot raise the speed at the start.
const FINAL: u8 = 2;

const _: () = assert!(size_of::<WaitingMotion>() == 64);

impl WaitingMotion {
    fn has(&self, flag: u8) -> bool {
        self.flags & flag != 0
    }

    fn set(&mut self, flag: u8, value: bool) {
        self.flags = if value { self.flags | flag } else { self.flags & !flag };
    }

    fn is_line(&self) -> bool {
        self.course == Course::Line
    }

    /// The direction of a line; of an arc 1 in its plane.
    fn direction(&self) -> Position {
        match self.course {
            Course::Line => self.shape.map(f64::from),
            Course::Xy => [1.0, 1.0, 0.0, 0.0],
            Course::Yz => [0.0, 1.0, 1.0, 0.0],
            Course::Zx => [1.0, 0.0, 1.0, 0.0],
        }
    }

    /// Of an arc: its radius, and the limit of its accelerations.
    fn round(&self) -> Option<(f64, f64)> {
        let [radius, limit, ..] = self.shape;
        (!self.is_line()).then_some((radius.into(), limit.into()))
    }

    /// See `start_square`.
    fn start_square(&self) -> f64 {
        if self.start_square == f32::INFINITY { self.start.cap } else { self.start_square.into() }
    }
}

/// A square of a speed that a junction with this cap allows, for [`WaitingMotion::start_square`].
fn packed_start_square(high: f64, cap: f64) -> f32 {
    if high >= cap { f32::INFINITY } else { rounded_down(high) }
}

/// What a plan makes of the first motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Planned {
    /// Its speeds.
    pub along: MotionSpeeds,
    /// Its time without override, ms.
    pub ms: f64,
    /// Entries that follow it before the next motion. They wait for nothing else.
    pub entries_after: u16,
}

/// The first motion whose junction may still turn out to be rounding, if there is one: its number,
/// its slot, and the length from its start to the end of the last motion.
#[derive(Debug, Clone, Copy)]
pub(crate) struct UndecidedJunction {
    number: u32,
    pub(crate) slot: usize,
    length: f64,
}

servo::state! {
    /// Motions that wait for what follows them. `N` is a power of two. Of `STEPS` motions it keeps
    /// steps of earlier plans, which saves time and changes nothing: of all, or of none.
    #[derive(Debug, Clone)]
    pub struct LookAhead<const N: usize, const STEPS: usize> {
        limits: Limits = {
            const { assert!(N.is_power_of_two(), "slots are counted modulo a power of two") };
            limits
        },
        slots: [WaitingMotion; N] = [WaitingMotion::EMPTY; N],
        /// By the slots.
        steps: [Steps; STEPS] = [Steps::NONE; STEPS],
        /// Counters of the first motion, and of the one after the last.
        pub(crate) first: usize = 0,
        pub(crate) end: usize = 0,
        /// Square of the speed at which the first motion begins: the end speed of the last one
        /// handed over.
        begin_square: f64 = 0.0,
        /// The last motion, for the junction to come.
        last: Option<LastMotion> = None,
        /// The path moves at the end of the last motion.
        moves_at_end: bool = false,
        effects: u32 = 0,
        chords: Chords = Chords::new(),
        pub(crate) undecided: UndecidedJunction = UndecidedJunction { number: 0, slot: 0, length: 0.0 },
        /// The first motion whose junction was changed since the last plan.
        changed: Option<usize> = None,
        /// Speeds are not planned for all motions.
        needs_plan: bool = false,
        /// Motions that came since the last plan.
        motions_since_plan: usize = 0,
        /// See [`LookAhead::hold_level`].
        level: Option<f64> = None,
    }
    /// Empty, at standstill.
    pub const fn new(limits: Limits);
}

impl<const N: usize, const STEPS: usize> LookAhead<N, STEPS> {
    /// Whether so much has come since the last plan that another is worth its time: it may go over
    /// all motions. A stop makes what is before it final.
    pub fn is_plan_due(&self) -> bool {
        self.motions_since_plan > self.len() / PLANS_PER_QUEUE || self.needs_plan && !self.moves_at_end
    }

    /// New limits, while it is empty.
    pub fn set_limits(&mut self, limits: Limits) {
        self.limits = limits;
    }

    /// Forgets everything: what comes next begins at standstill.
    pub fn clear(&mut self) {
        // Old content of the slots is void; a new value would take as much stack.
        (self.first, self.end, self.begin_square, self.last) = (0, 0, 0.0, None);
        (self.moves_at_end, self.effects, self.needs_plan, self.motions_since_plan) = (false, 0, false, 0);
        self.undecided = UndecidedJunction { number: self.chords.next(), slot: 0, length: 0.0 };
        (self.changed, self.level) = (None, None);
    }

    /// Motions that wait.
    pub fn len(&self) -> usize {
        self.end.wrapping_sub(self.first)
    }

    /// Whether nothing waits.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether nothing more fits before something has been taken.
    pub fn is_full(&self) -> bool {
        self.len() >= N
    }

    /// A motion with the speed and acceleration of its call. False if it is full.
    pub fn push_motion(&mut self, geometry: &Geometry, vel: f64, acc: f64) -> bool {
        if self.is_full() {
            return false;
        }
        let mut motion = self.motion(geometry, vel, acc);
        // If the last one was handed over, it ended at standstill.
        let stops = !self.moves_at_end || self.effects > EFFECTS || self.is_empty() && self.begin_square == 0.0;
        if let Some(before) = self.last.as_ref().filter(|_| !stops) {
            let (junction, either) = self.limits.junction(before, &motion, &geometry.tangents[0]);
            motion.start = junction;
            motion.set(EITHER_SIDE, either);
        }
        let is_line = motion.is_line();
        if stops || !is_line {
            self.decide(self.end);
        }
        self.last =
            Some(LastMotion { tangent: geometry.tangents[1], length: geometry.length, vel: motion.vel, is_line });
        (self.moves_at_end, self.effects) = (true, 0);
        if !self.has_undecided() {
            self.undecided = UndecidedJunction { number: self.chords.next(), slot: self.end, length: 0.0 };
        }
        self.undecided.length += f64::from(motion.length);
        self.chords.push(motion.shape, if is_line { geometry.length } else { 0.0 }, stops);
        if let Some(slot) = self.slots.get_mut(self.end & (N - 1)) {
            *slot = motion;
        }
        self.forget_steps(self.end);
        self.end = self.end.wrapping_add(1);
        (self.needs_plan, self.motions_since_plan) = (true, self.motions_since_plan.saturating_add(1));
        self.decide(self.first);
        true
    }

    /// The path stops where the last motion ends.
    pub fn stop(&mut self) {
        (self.moves_at_end, self.needs_plan) = (false, true);
        self.decide(self.end);
    }

    /// Whether there is a junction that may still turn out to be rounding.
    fn has_undecided(&self) -> bool {
        self.undecided.number != self.chords.next()
    }

    /// Whether the junction at the start of this motion is what it will be.
    fn is_decided(&self, slot: usize) -> bool {
        !self.has_undecided() || slot.wrapping_sub(self.undecided.slot).cast_signed() < 0
    }

    /// Takes rounding out of the junctions after which there are enough motions, and of all before
    /// this motion.
    fn decide(&mut self, before: usize) {
        while self.has_undecided() {
            let UndecidedJunction { number, slot, length } = self.undecided;
            let motion = *self.slot(slot);
            if motion.has(EITHER_SIDE) {
                let now = slot.wrapping_sub(before).cast_signed() < 0;
                if !now && length < motion.vel * self.limits.corner && self.chords.has_room(number) {
                    return;
                }
                let vel =
                    if slot == self.first { motion.vel } else { motion.vel.min(self.slot(slot.wrapping_sub(1)).vel) };
                let (start, either) = self.chords.without_rounding(&motion.start, number, vel, &self.limits);
                if let Some(motion) = self.slots.get_mut(slot & (N - 1)) {
                    motion.start = start;
                    motion.set(EITHER_SIDE, either);
                }
                self.forget_steps(slot);
                (self.changed, self.needs_plan) = (self.changed.or(Some(slot)), true);
            }
            self.pass_undecided();
        }
    }

    /// The junction at the start of this motion is another now.
    #[inline]
    fn forget_steps(&mut self, counter: usize) {
        for counter in [counter.wrapping_sub(1), counter] {
            if let Some(steps) = self.steps.get_mut(counter & (N - 1)) {
                *steps = Steps::NONE;
            }
        }
    }

    /// On to the junction after.
    fn pass_undecided(&mut self) {
        let UndecidedJunction { number, slot, length } = self.undecided;
        let length = length - f64::from(self.slot(slot).length);
        self.undecided = UndecidedJunction { number: number.wrapping_add(1), slot: slot.wrapping_add(1), length };
    }

    /// An entry after the last motion that waits. There is one.
    pub fn push_other(&mut self, entry: &PathEntry) {
        if entry.is_wait() {
            self.stop();
        }
        self.effects = self.effects.saturating_add(entry.load());
        if let Some(motion) = self.slots.get_mut(self.end.wrapping_sub(1) & (N - 1)) {
            motion.entries_after = motion.entries_after.saturating_add(1);
        }
    }

    fn slot(&self, counter: usize) -> &WaitingMotion {
        self.slots.get(counter & (N - 1)).unwrap_or(&WaitingMotion::EMPTY)
    }

    /// The limits of motions that are pushed now.
    pub fn limits(&self) -> &Limits {
        &self.limits
    }

    /// A motion by itself, from standstill.
    fn motion(&self, geometry: &Geometry, vel: f64, acc: f64) -> WaitingMotion {
        let direction = direction(geometry);
        let (vel, acc, round) = self.limits.hold(geometry, &direction, vel, acc);
        let (course, shape) = match (geometry.plane(), round) {
            (Some(plane), Some((radius, limit))) => {
                let course = match plane {
                    Plane::Xy => Course::Xy,
                    Plane::Yz => Course::Yz,
                    Plane::Zx => Course::Zx,
                };
                (course, [radius as f32, limit as f32, 0.0, 0.0])
            }
            _ => (Course::Line, direction.map(|x| x as f32)),
        };
        WaitingMotion {
            vel: vel.max(SPEED_MIN_PULSES_PER_MS),
            shape,
            length: geometry.length as f32,
            acc: acc.max(SPEED_MIN_PULSES_PER_MS) as f32,
            start_square: f32::NAN,
            course,
            ..WaitingMotion::EMPTY
        }
    }

    /// Names the bounds of a motion between the junctions at its start and end.
    #[inline]
    fn each_bound(&self, motion: &WaitingMotion, end: &(Junction, bool), mut bound: impl FnMut(Bound)) {
        let (length, acc, vel) = (f64::from(motion.length), f64::from(motion.acc), motion.vel);
        let (ends, either) = ([&motion.start, &end.0], [motion.has(EITHER_SIDE), end.1]);
        let reach = acc * length / 4.0;
        let fastest = ends.map(|end| (end.cap * vel * vel <= reach * reach).then(|| sqrt(end.cap) * vel));
        let corners = |bends: [f64; 2], limit| {
            [0, 1].map(|end: usize| Corner::new((bends[end], either[end]), length, fastest[end], limit))
        };
        let mut sharpest = [0.0f64; 2];
        let (direction, round) = (motion.direction(), motion.round());
        for (i, limit) in self.limits.acc.iter().enumerate() {
            let along = direction[i];
            let bends = ends.map(|end| f64::from(end.bend[i]));
            if round.is_some() && along != 0.0 {
                sharpest = [0, 1].map(|end: usize| sharpest[end].max(fabs(bends[end])));
            } else if bends != [0.0; 2] {
                bound(Bound::straight(along, corners(bends, *limit), *limit));
            }
        }
        if let Some((radius, limit)) = round {
            Bound::circle(radius, corners(sharpest, limit), limit).into_iter().for_each(bound);
        }
    }

    /// The junction at the end of a motion, the highest square of the speed there, and whether it
    /// is final and decided, as far as known.
    fn end_of(&self, counter: usize) -> ((Junction, bool), f64, [bool; 2]) {
        let next = counter.wrapping_add(1);
        if next == self.end {
            return ((STANDSTILL, false), 0.0, [!self.moves_at_end; 2]);
        }
        let motion = self.slot(next);
        ((motion.start, motion.has(EITHER_SIDE)), motion.start_square(), [motion.has(FINAL), self.is_decided(next)])
    }

    /// Plans backwards from a stop at the end, as far as anything changes.
    fn plan(&mut self) {
        if !self.needs_plan {
            return;
        }
        (self.needs_plan, self.motions_since_plan) = (false, 0);
        let changed = self.changed.take();
        let (mut after, mut is_final, mut end, mut end_decided) = (0.0, !self.moves_at_end, (STANDSTILL, false), true);
        let mut counter = self.end;
        while counter != self.first {
            counter = counter.wrapping_sub(1);
            let motion = self.slot(counter);
            // What is before the first junction that was changed is as it was, but for its end.
            let same = changed.is_none_or(|changed| counter.wrapping_sub(changed).cast_signed() < 0);
            if motion.has(FINAL) && same {
                return;
            }
            let cap = motion.start.cap;
            let known = self.steps.get(counter & (N - 1)).and_then(|steps| steps.back(after));
            let (step, steps) = match known {
                Some(step) => (step, None),
                None => {
                    let mut span = Span::new(motion.length.into(), motion.acc.into());
                    self.each_bound(motion, &end, |bound| span.add(&bound));
                    let (step, steps) = span.start_square(after, cap);
                    (step, Some(steps))
                }
            };
            let packed = packed_start_square(step.start_square, cap);
            let decided = self.is_decided(counter);
            // Nothing raises a standstill.
            is_final = (is_final || step.saturated) && decided && end_decided || cap == 0.0;
            if packed == motion.start_square && !is_final && same {
                return;
            }
            end = (motion.start, motion.has(EITHER_SIDE));
            if let Some(motion) = self.slots.get_mut(counter & (N - 1)) {
                motion.start_square = packed;
                motion.set(FINAL, is_final);
                after = motion.start_square();
            }
            if let Some((kept, steps)) = self.steps.get_mut(counter & (N - 1)).zip(steps) {
                *kept = steps;
            }
            end_decided = decided;
        }
    }

    /// How many motions leave under one plan. Until [`LookAhead::release_level`] none of them ends
    /// above the speed that the path can have after them, or has before them.
    pub fn hold_level(&mut self) -> usize {
        self.plan();
        self.level = Some(self.level());
        self.batch()
    }

    fn batch(&self) -> usize {
        (self.len() / BATCH_PARTS).max(1)
    }

    /// The square of the speed that the path can have after the next motions, or has now.
    fn level(&self) -> f64 {
        let (_, high, _) = self.end_of(self.first.wrapping_add(self.batch() - 1));
        high.max(self.begin_square)
    }

    /// Each motion has a level of its own again.
    pub fn release_level(&mut self) {
        self.level = None;
    }

    /// The first motion, if its speeds are final. With `now` in any case, as fast as the present
    /// data allows.
    pub fn take(&mut self, now: bool) -> Option<Planned> {
        if self.is_empty() {
            return None;
        }
        if now && self.has_undecided() {
            self.decide(self.first.wrapping_add(2));
        }
        self.plan();
        self.take_planned(now)
    }

    /// The same of planned motions. A function of its own: its memory and that of the plan are
    /// never on the stack together.
    #[inline(never)]
    fn take_planned(&mut self, now: bool) -> Option<Planned> {
        let motion = self.slot(self.first);
        let (junction, high, [is_final, decided]) = self.end_of(self.first);
        let mut bounds: Vec<Bound, BOUNDS_MAX> = Vec::new();
        let mut span = Span::new(motion.length.into(), motion.acc.into());
        self.each_bound(motion, &junction, |bound| {
            span.add(&bound);
            bounds.push(bound).ok();
        });
        let most = if is_final { high } else { self.level.unwrap_or_else(|| self.level()).min(high) };
        let mut end = span.end_square(self.begin_square, high);
        if !(now || is_final || decided && end < most) {
            return None;
        }
        if end > most {
            end = end.min(span.least_end_square(self.begin_square).max(most));
        }
        let ends = [self.begin_square, end].map(EndSpeed::of);
        let ChosenMotion { vel, acc, ms, ramp } = span.choose(&bounds, &ends, motion.vel);
        let bits =
            [vel.max(SPEED_MIN_PULSES_PER_MS), acc.max(SPEED_MIN_PULSES_PER_MS), ends[1].speed].map(f64::to_bits);
        let along = MotionSpeeds::admit(bits[0], bits[1], bits[2]).ok()?.with_ramp(ramp);
        let entries_after = motion.entries_after;
        if self.has_undecided() && self.undecided.slot == self.first {
            self.pass_undecided();
        }
        (self.first, self.begin_square) = (self.first.wrapping_add(1), end);
        Some(Planned { along, ms, entries_after })
    }
}

/// The direction of a line; of an arc 1 in its plane: a coordinate may have all of the speed.
fn direction(geometry: &Geometry) -> Position {
    match geometry.round {
        Some((_, plane)) => [0, 1, 2, 3].map(|i| if plane.contains(&i) { 1.0 } else { 0.0 }),
        None => geometry.tangents[0],
    }
}
