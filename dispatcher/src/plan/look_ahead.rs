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

use super::geometry::{Form, Geometry, Position};
use heapless::Vec;
use junction::{Junction, LastMotion, STANDSTILL};
use libm::{fabs, sqrt};
use reachable::{BOUNDS_MAX, Bound, Corner, Span};
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
    round: Option<(f64, f64)>,
    /// Speed and acceleration along it, as its limits allow.
    vel: f64,
    acc: f64,
    /// The junction at its start.
    start: Junction,
    /// The highest square of the speed there from which all that follows can be kept; `settled`:
    /// more data cannot raise it.
    high: f64,
    settled: bool,
}

/// Its layout is fixed, so that zeroed memory holds empty ones.
#[derive(Debug, Clone, Copy)]
#[repr(u8)]
enum Waiting {
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

servo::state! {
    /// Motions that wait for what follows them. `N` is a power of two.
    #[derive(Debug, Clone)]
    pub struct LookAhead<const N: usize> {
        limits: Limits = {
            const { assert!(N.is_power_of_two(), "slots are counted modulo a power of two") };
            limits
        },
        slots: [Waiting; N] = [Waiting::Empty; N],
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
            motion.start = self.limits.junction(before, &motion, &geometry.tangents[0]);
        }
        self.last = Some(LastMotion { tangent: geometry.tangents[1], length: motion.length, vel: motion.vel });
        (self.moves, self.effects) = (true, 0);
        self.push(Waiting::Motion(motion));
        true
    }

    /// The path stops where the last motion ends.
    pub fn stop(&mut self) {
        self.moves = false;
    }

    /// Any other entry, in its order. False if it is full.
    pub fn push_other(&mut self, entry: PathEntry) -> bool {
        if self.is_full() {
            return false;
        }
        self.moves &= !entry.is_wait();
        self.effects = self.effects.saturating_add(entry.load());
        self.push(Waiting::Other(entry, entry.is_wait()));
        true
    }

    /// Advances the counters of an empty queue, for tests. They are as wide as an address: `by`
    /// counts with its sign, so that counters of any width are equally far from wrapping.
    #[cfg(feature = "test-hooks")]
    pub fn advance_counters(&mut self, by: u32) {
        let by = by.cast_signed() as isize as usize;
        (self.first, self.end) = (self.first.wrapping_add(by), self.end.wrapping_add(by));
    }

    fn push(&mut self, slot: Waiting) {
        if let Some(position) = self.slots.get_mut(self.end & (N - 1)) {
            *position = slot;
        }
        self.end = self.end.wrapping_add(1);
        self.stale = true;
    }

    fn slot(&self, counter: usize) -> &Waiting {
        self.slots.get(counter & (N - 1)).unwrap_or(&Waiting::Empty)
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
            round,
            vel: vel.max(ALONG_MIN),
            acc: acc.max(ALONG_MIN),
            start: STANDSTILL,
            high: f64::NAN,
            settled: false,
        }
    }

    /// Bounds of a motion between the junctions at its start and end.
    fn bounds(&self, motion: &PlannedMotion, end: &Junction) -> Vec<Bound, BOUNDS_MAX> {
        let PlannedMotion { length, vel, acc, .. } = *motion;
        let ends = [&motion.start, end];
        let reach = acc * length / 4.0;
        let fastest = ends.map(|end| (end.cap * vel * vel <= reach * reach).then(|| sqrt(end.cap) * vel));
        let corners =
            |bends: [f64; 2], limit| [0, 1].map(|end: usize| Corner::new(bends[end], length, fastest[end], limit));
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
        if let Some((radius, limit)) = motion.round {
            for bound in Bound::circle(radius, corners(sharpest, limit), limit) {
                bounds.push(bound).ok();
            }
        }
        bounds
    }

    /// The junction at the end of a motion, the highest square of the speed there, and whether it
    /// is settled, as far as known.
    fn end_of(&self, mut counter: usize) -> (Junction, f64, bool) {
        while counter != self.end {
            match self.slot(counter) {
                Waiting::Motion(motion) => return (motion.start, motion.high, motion.settled),
                Waiting::Other(_, true) => return (STANDSTILL, 0.0, true),
                _ => counter = counter.wrapping_add(1),
            }
        }
        (STANDSTILL, 0.0, false)
    }

    /// Plans backwards from a stop at the end, as far as anything changes.
    fn plan(&mut self) {
        if !self.stale {
            return;
        }
        self.stale = false;
        let (mut after, mut settled, mut end) = (0.0, false, STANDSTILL);
        let mut counter = self.end;
        while counter != self.first {
            counter = counter.wrapping_sub(1);
            let Waiting::Motion(motion) = self.slot(counter) else { continue };
            if motion.settled {
                return;
            }
            let bounds = self.bounds(motion, &end);
            let span = Span::new(motion.length, motion.acc, &bounds);
            let (high, free) = span.back(after, motion.start.cap);
            settled |= free;
            if high == motion.high && !settled {
                return;
            }
            (after, end) = (high, motion.start);
            if let Some(Waiting::Motion(motion)) = self.slots.get_mut(counter & (N - 1)) {
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
        self.plan();
        let motion = match self.slot(self.first) {
            Waiting::Motion(motion) => motion,
            Waiting::Other(entry, _) => {
                let entry = *entry;
                self.first = self.first.wrapping_add(1);
                return Some(Planned { entry, ms: 0.0 });
            }
            Waiting::Empty => return None,
        };
        let (junction, high, settled) = self.end_of(self.first.wrapping_add(1));
        let bounds = self.bounds(motion, &junction);
        let span = Span::new(motion.length, motion.acc, &bounds);
        let end = span.on(self.begin, high);
        if !(now || settled || end < high) {
            return None;
        }
        let (vel, acc, ms) = span.choose(&bounds, [self.begin, end], motion.vel, motion.acc);
        let bits = [vel.max(ALONG_MIN), acc.max(ALONG_MIN), sqrt(end)].map(f64::to_bits);
        let entry = MotionSpeeds::admit(bits[0], bits[1], bits[2]).ok().and_then(|along| motion.form.entry(along))?;
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
