//! Look-ahead: the speeds at the corners of a path.
//!
//! In: motions and the entries between them, in order. Out: servo's entries with their end speeds,
//! as soon as these are final, or at once if the stream has run low. Owns: `N` motions and other
//! entries that wait.
//! Fails: never; a full queue returns false, and an entry must be taken first.
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
//!
//! **The plan.** Backwards from a stop at the end of the queue: at each junction the square of the
//! highest speed from which all that follows can be kept (`reachable.rs`). Forwards: as fast as
//! these allow. More data can only raise these speeds. So the speeds handed over are always safe,
//! and final if more data could not raise them.
//! Work: one plan for all that was pushed since the last take, back over as many motions as braking
//! takes. So push all data, then take.
mod junction;
mod reachable;
mod rounding;

use super::geometry::{Form, Geometry, Position};
use heapless::Vec;
use junction::{Junction, LastMotion, STANDSTILL};
use libm::{fabs, sqrt};
use reachable::{BOUNDS_MAX, Bound, Chosen, Corner, EndSpeed, Span};
use rounding::Chords;
use servo::path::{MotionSpeeds, PathEntry};

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
            vel = vel.min(sqrt(radius * limit));
        }
        (vel, acc, round)
    }
}

/// Largest load of entries between two motions that the path passes at speed; with more it stops
/// there.
const EFFECTS: u32 = 32;
/// Lowest speed (pulse/ms) and acceleration (pulse/ms²) of a motion.
pub const ALONG_MIN: f64 = 1.0 / 1048576.0;

/// A motion that waits. Shares of limits are kept as f32: their rounding is far below the margin of
/// a plan.
#[derive(Debug, Clone, Copy)]
struct PlannedMotion {
    form: Form,
    length: f64,
    /// The direction of a line; of an arc 1 in its plane.
    direction: [f32; 4],
    /// Of an arc: its radius, and the limit of its accelerations.
    round: Option<(f32, f32)>,
    /// Speed and acceleration along it, as its limits allow.
    vel: f64,
    acc: f64,
    /// The junction at its start; `either`: its bends may go to either side.
    start: Junction,
    either: bool,
    /// The highest square of the speed there from which all that follows can be kept; `settled`:
    /// more data cannot raise it.
    high: f64,
    settled: bool,
}

/// Its layout is fixed, so that zeroed memory holds empty ones.
#[derive(Debug, Clone, Copy)]
#[repr(u8)]
enum QueuedMotion {
    Empty,
    Motion(PlannedMotion),
    /// Any other entry; true if the path stops there.
    Other(PathEntry, bool),
}

/// An entry with its time, to count how long the stream lasts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Planned {
    /// The entry.
    pub entry: PathEntry,
    /// Its time without override, ms; 0 for a wait.
    pub ms: f64,
}

/// The first motion whose junction may still turn out to be rounding, if there is one: its number,
/// its entry, and the length from its start to the end of the last motion.
#[derive(Debug, Clone, Copy)]
struct UndecidedJunction {
    number: u32,
    entry: usize,
    length: f64,
}

servo::state! {
    /// Motions that wait for what follows them. `N` is a power of two.
    #[derive(Debug, Clone)]
    pub struct LookAhead<const N: usize> {
        limits: Limits = {
            const { assert!(N.is_power_of_two(), "slots are counted modulo a power of two") };
            limits
        },
        slots: [QueuedMotion; N] = [QueuedMotion::Empty; N],
        /// Counters of the first entry, and of the one after the last.
        first: usize = 0,
        end: usize = 0,
        /// Square of the speed at which the first motion begins: the end speed of the last one
        /// handed over.
        begin: f64 = 0.0,
        /// The last motion, for the junction to come.
        last: Option<LastMotion> = None,
        moves: bool = false,
        effects: u32 = 0,
        chords: Chords = Chords::new(),
        unsure: UndecidedJunction = UndecidedJunction { number: 0, entry: 0, length: 0.0 },
        /// The first entry whose junction was changed since the last plan.
        changed: Option<usize> = None,
        /// Speeds are not planned for all entries.
        stale: bool = false,
    }
    /// Empty, at standstill.
    pub const fn new(limits: Limits);
}

impl<const N: usize> LookAhead<N> {
    /// New limits, while it is empty.
    pub fn set_limits(&mut self, limits: Limits) {
        self.limits = limits;
    }

    /// Forgets everything: what comes next begins at standstill.
    pub fn clear(&mut self) {
        // Old content of the slots is void; a new value would take 36 KB of stack.
        (self.first, self.end, self.begin, self.last) = (0, 0, 0.0, None);
        (self.moves, self.effects, self.stale) = (false, 0, false);
        self.unsure = UndecidedJunction { number: self.chords.next(), entry: 0, length: 0.0 };
        self.changed = None;
    }

    /// Entries that wait.
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
        let stops = !self.moves || self.effects > EFFECTS || self.is_empty() && self.begin == 0.0;
        if let Some(before) = self.last.as_ref().filter(|_| !stops) {
            (motion.start, motion.either) = self.limits.junction(before, &motion, &geometry.tangents[0]);
        }
        let is_line = motion.round.is_none();
        if stops || !is_line {
            self.decide(self.end);
        }
        self.last = Some(LastMotion { tangent: geometry.tangents[1], length: motion.length, vel: motion.vel, is_line });
        (self.moves, self.effects) = (true, 0);
        if !self.has_unsure() {
            self.unsure = UndecidedJunction { number: self.chords.next(), entry: self.end, length: 0.0 };
        }
        self.unsure.length += motion.length;
        self.chords.push(motion.direction, if is_line { motion.length } else { 0.0 }, stops);
        self.push(QueuedMotion::Motion(motion));
        self.decide(self.first);
        true
    }

    /// The path stops where the last motion ends.
    pub fn stop(&mut self) {
        self.moves = false;
        self.decide(self.end);
    }

    /// Whether there is a junction that may still turn out to be rounding.
    fn has_unsure(&self) -> bool {
        self.unsure.number != self.chords.next()
    }

    /// Whether the junction at the start of this motion is what it will be.
    fn is_sure(&self, entry: usize) -> bool {
        !self.has_unsure() || entry.wrapping_sub(self.unsure.entry).cast_signed() < 0
    }

    /// Takes rounding out of the junctions after which there are enough motions, and of all before
    /// this entry.
    fn decide(&mut self, before: usize) {
        while self.has_unsure() {
            let UndecidedJunction { number, entry, length } = self.unsure;
            let QueuedMotion::Motion(motion) = self.slot(entry) else { return };
            if motion.either {
                let now = entry.wrapping_sub(before).cast_signed() < 0;
                if !now && length < motion.vel * self.limits.corner && self.chords.has_room(number) {
                    return;
                }
                let vel = self.vel_before(entry).map_or(motion.vel, |before| motion.vel.min(before));
                let start = self.chords.without_rounding(&motion.start, number, vel, &self.limits);
                if let Some(QueuedMotion::Motion(motion)) = self.slots.get_mut(entry & (N - 1)) {
                    (motion.start, motion.either) = start;
                }
                (self.changed, self.stale) = (self.changed.or(Some(entry)), true);
            }
            self.pass_unsure();
        }
    }

    /// The speed of the motion before this one, if that still waits.
    fn vel_before(&self, mut entry: usize) -> Option<f64> {
        while entry != self.first {
            entry = entry.wrapping_sub(1);
            if let QueuedMotion::Motion(motion) = self.slot(entry) {
                return Some(motion.vel);
            }
        }
        None
    }

    /// On to the junction after.
    fn pass_unsure(&mut self) {
        let UndecidedJunction { number, entry, length } = self.unsure;
        let own = if let QueuedMotion::Motion(motion) = self.slot(entry) { motion.length } else { 0.0 };
        let entry = self.motion_after(entry);
        self.unsure = UndecidedJunction { number: number.wrapping_add(1), entry, length: length - own };
    }

    /// The next motion, or the end.
    fn motion_after(&self, mut entry: usize) -> usize {
        loop {
            entry = entry.wrapping_add(1);
            if entry == self.end || matches!(self.slot(entry), QueuedMotion::Motion(_)) {
                return entry;
            }
        }
    }

    /// Any other entry, in its order. False if it is full.
    pub fn push_other(&mut self, entry: PathEntry) -> bool {
        if self.is_full() {
            return false;
        }
        self.moves &= !entry.is_wait();
        if entry.is_wait() {
            self.decide(self.end);
        }
        self.effects = self.effects.saturating_add(entry.load());
        self.push(QueuedMotion::Other(entry, entry.is_wait()));
        true
    }

    /// Advances the counters of an empty queue, for tests. They are as wide as an address: `by`
    /// counts with its sign, so that counters of any width are equally far from wrapping.
    #[cfg(feature = "test-hooks")]
    pub fn advance_counters(&mut self, by: u32) {
        let by = by.cast_signed() as isize as usize;
        (self.first, self.end) = (self.first.wrapping_add(by), self.end.wrapping_add(by));
        self.unsure.entry = self.unsure.entry.wrapping_add(by);
    }

    fn push(&mut self, slot: QueuedMotion) {
        if let Some(position) = self.slots.get_mut(self.end & (N - 1)) {
            *position = slot;
        }
        self.end = self.end.wrapping_add(1);
        self.stale = true;
    }

    fn slot(&self, counter: usize) -> &QueuedMotion {
        self.slots.get(counter & (N - 1)).unwrap_or(&QueuedMotion::Empty)
    }

    /// The limits of motions that are pushed now.
    pub fn limits(&self) -> &Limits {
        &self.limits
    }

    /// A motion by itself, from standstill.
    fn motion(&self, geometry: &Geometry, vel: f64, acc: f64) -> PlannedMotion {
        let direction = direction(geometry);
        let (vel, acc, round) = self.limits.hold(geometry, &direction, vel, acc);
        PlannedMotion {
            form: geometry.form,
            length: geometry.length,
            direction: direction.map(|x| x as f32),
            round: round.map(|(radius, limit)| (radius as f32, limit as f32)),
            vel: vel.max(ALONG_MIN),
            acc: acc.max(ALONG_MIN),
            start: STANDSTILL,
            either: false,
            high: f64::NAN,
            settled: false,
        }
    }

    /// Bounds of a motion between the junctions at its start and end.
    fn bounds(&self, motion: &PlannedMotion, end: &(Junction, bool)) -> Vec<Bound, BOUNDS_MAX> {
        let PlannedMotion { length, vel, acc, .. } = *motion;
        let (ends, either) = ([&motion.start, &end.0], [motion.either, end.1]);
        let reach = acc * length / 4.0;
        let fastest = ends.map(|end| (end.cap * vel * vel <= reach * reach).then(|| sqrt(end.cap) * vel));
        let corners = |bends: [f64; 2], limit| {
            [0, 1].map(|end: usize| Corner::new((bends[end], either[end]), length, fastest[end], limit))
        };
        let mut bounds = Vec::new();
        let mut sharpest = [0.0f64; 2];
        for (i, limit) in self.limits.acc.iter().enumerate() {
            let along = f64::from(motion.direction[i]);
            let bends = ends.map(|end| f64::from(end.bend[i]));
            if motion.round.is_some() && along != 0.0 {
                sharpest = [0, 1].map(|end: usize| sharpest[end].max(fabs(bends[end])));
            } else if bends != [0.0; 2] {
                bounds.push(Bound::straight(along, corners(bends, *limit), *limit)).ok();
            }
        }
        if let Some((radius, limit)) = motion.round.map(|(radius, limit)| (f64::from(radius), f64::from(limit))) {
            for bound in Bound::circle(radius, corners(sharpest, limit), limit) {
                bounds.push(bound).ok();
            }
        }
        bounds
    }

    /// The junction at the end of a motion, the highest square of the speed there, and whether it
    /// is settled and sure, as far as known.
    fn end_of(&self, mut counter: usize) -> ((Junction, bool), f64, [bool; 2]) {
        while counter != self.end {
            match self.slot(counter) {
                QueuedMotion::Motion(motion) => {
                    return ((motion.start, motion.either), motion.high, [motion.settled, self.is_sure(counter)]);
                }
                QueuedMotion::Other(_, true) => return ((STANDSTILL, false), 0.0, [true; 2]),
                _ => counter = counter.wrapping_add(1),
            }
        }
        ((STANDSTILL, false), 0.0, [false; 2])
    }

    /// Plans backwards from a stop at the end, as far as anything changes.
    fn plan(&mut self) {
        if !self.stale {
            return;
        }
        self.stale = false;
        let changed = self.changed.take();
        let (mut after, mut settled, mut end, mut end_sure) = (0.0, false, (STANDSTILL, false), true);
        let mut counter = self.end;
        while counter != self.first {
            counter = counter.wrapping_sub(1);
            let QueuedMotion::Motion(motion) = self.slot(counter) else { continue };
            // What is before the first junction that was changed is as it was, but for its end.
            let same = changed.is_none_or(|changed| counter.wrapping_sub(changed).cast_signed() < 0);
            if motion.settled && same {
                return;
            }
            let bounds = self.bounds(motion, &end);
            let span = Span::new(motion.length, motion.acc, &bounds);
            let (high, free) = span.back(after, motion.start.cap);
            let sure = self.is_sure(counter);
            settled = (settled || free) && sure && end_sure;
            if high == motion.high && !settled && same {
                return;
            }
            (after, end, end_sure) = (high, (motion.start, motion.either), sure);
            if let Some(QueuedMotion::Motion(motion)) = self.slots.get_mut(counter & (N - 1)) {
                (motion.high, motion.settled) = (high, settled);
            }
        }
    }

    /// The first entry, if its speeds are final. With `now` in any case, as fast as the present
    /// data allows.
    pub fn take(&mut self, now: bool) -> Option<Planned> {
        if self.is_empty() {
            return None;
        }
        if now && self.has_unsure() {
            self.decide(self.motion_after(self.first).wrapping_add(1));
        }
        self.plan();
        let motion = match self.slot(self.first) {
            QueuedMotion::Motion(motion) => motion,
            QueuedMotion::Other(entry, _) => {
                let entry = *entry;
                self.first = self.first.wrapping_add(1);
                return Some(Planned { entry, ms: 0.0 });
            }
            QueuedMotion::Empty => return None,
        };
        let (junction, high, [settled, sure]) = self.end_of(self.first.wrapping_add(1));
        let bounds = self.bounds(motion, &junction);
        let span = Span::new(motion.length, motion.acc, &bounds);
        let end = span.on(self.begin, high);
        if !(now || settled || sure && end < high) {
            return None;
        }
        let ends = [self.begin, end].map(EndSpeed::of);
        let Chosen { vel, acc, ms, ramp } = span.choose(&bounds, &ends, motion.vel, motion.acc);
        let bits = [vel.max(ALONG_MIN), acc.max(ALONG_MIN), ends[1].speed].map(f64::to_bits);
        let along = MotionSpeeds::admit(bits[0], bits[1], bits[2]).ok()?.with_ramp(ramp);
        let entry = motion.form.entry(along)?;
        if self.has_unsure() && self.unsure.entry == self.first {
            self.pass_unsure();
        }
        (self.first, self.begin) = (self.first.wrapping_add(1), end);
        Some(Planned { entry, ms })
    }
}

/// The direction of a line; of an arc 1 in its plane: a coordinate may have all of the speed.
fn direction(geometry: &Geometry) -> Position {
    match geometry.round {
        Some((_, plane)) => [0, 1, 2, 3].map(|i| if plane.contains(&i) { 1.0 } else { 0.0 }),
        None => geometry.tangents[0],
    }
}
