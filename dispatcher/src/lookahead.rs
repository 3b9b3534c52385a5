//! Look-ahead: how fast a path may go through its corners.
//!
//! In: motions and what stands between them, in order. Out: servo's entries with the speeds that they end at, as soon
//! as these are final, or at once where the stream has run low. Owns: `N` motions and other entries that wait.
//! Fails: never; a full queue says so and must be taken from first.
//!
//! **The rule.** The velocity of coordinate i never exceeds its limit. A corner changes it by Δᵢ·v at once: by no more
//! than its acceleration gives in the corner time T (the max-acceleration rule), and, taken over the time from the
//! middle of the motion before to the middle of the motion behind, by no more than the acceleration along these
//! motions leaves: Δᵢ·v²/l + uᵢ·|a| is at most the limit, where l is their mean length. So the mean acceleration of a
//! coordinate between the middles of any two motions keeps its limit, on finely divided curves as on long lines. On an
//! arc the acceleration along it and v²/R are added as a vector, inside a polygon within the circle of the lowest
//! limit. velEnd of the calls is not used, except through the waits between them.
//!
//! **The plan.** Backwards from a stop at the end of what is there, the square of the highest speed at each junction
//! from which all that follows can be kept (`reach.rs`); forwards, as fast as these allow. More data can only raise
//! these speeds, so what has been handed over is always safe, and final where more data could not raise it. Work: once
//! for all that was pushed since the last take, back over as many motions as it takes to brake; so push what is there,
//! then take.
mod reach;

use crate::figure::{Figure, Form, Place};
use libm::{fabs, sqrt};
use reach::{Bound, Span};
use servo::path::{Along, Entry};

/// Limits of a coordinate system.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Speeds of X, Y, Z, A, pulse/ms.
    pub vel: Place,
    /// Accelerations, pulse/ms².
    pub acc: Place,
    /// Corner time, ms.
    pub corner: f64,
}

/// Entries with effects that may stand between two motions which are passed at speed; more make the path wait.
const EFFECTS: u32 = 8;
/// Lowest speed and acceleration that an entry takes.
const LEAST: f64 = 1.0 / 1048576.0;

/// A motion that waits. Shares of limits are kept in half the bits: their rounding is far below the margin of a plan.
#[derive(Debug, Clone, Copy)]
struct Motion {
    form: Form,
    length: f64,
    /// How much of the path's speed each coordinate may have.
    shares: [f32; 4],
    /// Of an arc: its radius, and the limit of its accelerations.
    round: Option<(f64, f64)>,
    /// Speed and acceleration along it, as its limits allow.
    vel: f64,
    acc: f64,
    /// Of the junction at its start: Δᵢ over the mean length, and the highest square of the speed by itself.
    bend: [f32; 4],
    cap: f64,
    /// From which all that follows can be kept; whether more data cannot raise it.
    high: f64,
    settled: bool,
}

/// The last motion, for the corner to come.
#[derive(Debug, Clone, Copy)]
struct Tail {
    tangent: Place,
    length: f64,
    vel: f64,
}

/// Its layout is fixed, so that memory of zeros holds empty ones.
#[derive(Debug, Clone, Copy)]
#[repr(u8)]
enum Slot {
    Empty,
    Motion(Motion),
    /// Anything else; whether the path rests there.
    Other(Entry, bool),
}

/// What an entry takes, for whoever counts how long the stream lasts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Planned {
    /// The entry.
    pub entry: Entry,
    /// Its time without override, ms; of a wait 0.
    pub ms: f64,
}

/// Motions that wait for what follows them. `N` is a power of two.
#[derive(Debug, Clone)]
pub struct LookAhead<const N: usize> {
    limits: Limits,
    slots: [Slot; N],
    /// Counters of the first and behind the last.
    first: usize,
    end: usize,
    /// Square of the speed at which the first motion begins: that at which the last one handed over ends.
    begin: f64,
    /// The last motion, what stands behind it so far.
    last: Option<Tail>,
    moves: bool,
    effects: u32,
    /// Speeds are not planned for all that is there.
    stale: bool,
}

impl<const N: usize> LookAhead<N> {
    /// Empty, at rest.
    pub const fn new(limits: Limits) -> LookAhead<N> {
        const { assert!(N.is_power_of_two(), "slots are counted modulo a power of two") };
        LookAhead {
            limits,
            slots: [Slot::Empty; N],
            first: 0,
            end: 0,
            begin: 0.0,
            last: None,
            moves: false,
            effects: 0,
            stale: false,
        }
    }

    /// New limits, while it is empty.
    pub fn set_limits(&mut self, limits: Limits) {
        self.limits = limits;
    }

    /// Forgets everything: what comes next begins at rest.
    pub fn clear(&mut self) {
        // What the slots hold is over; a new value would pass over the stack, 36 KB of it.
        (self.first, self.end, self.begin, self.last) = (0, 0, 0.0, None);
        (self.moves, self.effects, self.stale) = (false, 0, false);
    }

    /// What waits.
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
    pub fn push_motion(&mut self, figure: &Figure, vel: f64, acc: f64) -> bool {
        if self.is_full() {
            return false;
        }
        let mut motion = self.motion(figure, vel, acc);
        let rests = !self.moves || self.effects > EFFECTS;
        match &self.last {
            Some(before) if !rests => self.junction(before, &mut motion, &figure.tangents[0]),
            _ => motion.cap = 0.0,
        }
        self.last = Some(Tail { tangent: figure.tangents[1], length: motion.length, vel: motion.vel });
        (self.moves, self.effects) = (true, 0);
        self.push(Slot::Motion(motion));
        true
    }

    /// The path stands where the last motion ends.
    pub fn rest(&mut self) {
        self.moves = false;
    }

    /// Anything else in its place. False if it is full.
    pub fn push_other(&mut self, entry: Entry) -> bool {
        if self.is_full() {
            return false;
        }
        self.moves &= !entry.is_wait();
        self.effects = self.effects.saturating_add(1);
        self.push(Slot::Other(entry, entry.is_wait()));
        true
    }

    fn push(&mut self, slot: Slot) {
        if let Some(place) = self.slots.get_mut(self.end & (N - 1)) {
            *place = slot;
        }
        self.end = self.end.wrapping_add(1);
        self.stale = true;
    }

    fn slot(&self, counter: usize) -> Slot {
        self.slots.get(counter & (N - 1)).copied().unwrap_or(Slot::Empty)
    }

    /// A motion by itself.
    fn motion(&self, figure: &Figure, vel: f64, acc: f64) -> Motion {
        let Limits { vel: most, acc: hardest, .. } = self.limits;
        let (mut vel, mut acc) = (vel, acc);
        for (i, share) in shares(figure).into_iter().enumerate() {
            if share > 0.0 {
                vel = vel.min(most[i] / share);
                acc = acc.min(hardest[i] / share);
            }
        }
        let round = figure.round.map(|(radius, [i, j])| (radius, hardest[i].min(hardest[j])));
        if let Some((radius, limit)) = round {
            vel = vel.min(sqrt(radius * limit));
        }
        Motion {
            form: figure.form,
            length: figure.length,
            shares: shares(figure).map(|x| x as f32),
            round,
            vel: vel.max(LEAST),
            acc: acc.max(LEAST),
            bend: [0.0; 4],
            cap: 0.0,
            high: f64::NAN,
            settled: false,
        }
    }

    /// The junction between two motions.
    fn junction(&self, before: &Tail, motion: &mut Motion, tangent: &Place) {
        let mean = (before.length + motion.length) / 2.0;
        let slower = before.vel.min(motion.vel);
        motion.cap = slower * slower;
        let sides = tangent.iter().zip(&before.tangent).zip(&self.limits.acc);
        for (bend, ((to, from), acc)) in motion.bend.iter_mut().zip(sides) {
            let turn = fabs(to - from);
            *bend = (turn / mean) as f32;
            if turn > 0.0 {
                let jump = acc * self.limits.corner / turn;
                let curve = reach::planned(*acc) * mean / turn;
                motion.cap = motion.cap.min(jump * jump).min(curve);
            }
        }
    }

    /// A motion between the junctions at its start and end, for `reach.rs`.
    fn span(&self, motion: &Motion, bend_end: &[f32; 4]) -> Span {
        let length = motion.length;
        let mut span = Span::new(length, motion.acc);
        let sides = motion.shares.iter().zip(&motion.bend).zip(bend_end).zip(&self.limits.acc);
        for (((share, start), end), limit) in sides {
            let [share, start, end] = [*share, *start, *end].map(f64::from);
            // Also across the motion, where a corner at its end turns into another coordinate.
            if share > 0.0 || start > 0.0 || end > 0.0 {
                let limit = *limit;
                // The mean speed of a motion behind a corner of speed v is at most v + |a|·l/2v, so that the corner may
                // take Δ·(v² + |a|·l/2)/l. A long motion feels no more than the corner time.
                let most = 2.0 * limit * self.limits.corner * motion.vel / (length * motion.acc);
                let along = [start, end, 0.0].map(|bend| share + (bend * length / 2.0).min(most));
                span.add(Bound { start, end, along, limit });
            }
        }
        if let Some((radius, limit)) = motion.round {
            for bound in reach::circle(radius, limit) {
                span.add(bound);
            }
        }
        span
    }

    /// The next motion from a counter on, with its counter; or whether a wait comes first.
    fn next_motion(&self, mut counter: usize) -> Result<(usize, Motion), bool> {
        while counter != self.end {
            match self.slot(counter) {
                Slot::Motion(motion) => return Ok((counter, motion)),
                Slot::Other(_, true) => return Err(true),
                _ => counter = counter.wrapping_add(1),
            }
        }
        Err(false)
    }

    /// Backwards from a stop at the end, as far as anything changes.
    fn plan(&mut self) {
        if !self.stale {
            return;
        }
        self.stale = false;
        let (mut after, mut settled, mut bend) = (0.0, false, [0.0; 4]);
        let mut counter = self.end;
        while counter != self.first {
            counter = counter.wrapping_sub(1);
            let Slot::Motion(motion) = self.slot(counter) else { continue };
            let high = self.span(&motion, &bend).back(after, motion.cap);
            settled |= high >= motion.cap;
            if high == motion.high && settled == motion.settled {
                return;
            }
            if let Some(Slot::Motion(motion)) = self.slots.get_mut(counter & (N - 1)) {
                (motion.high, motion.settled) = (high, settled);
            }
            (after, bend) = (high, motion.bend);
        }
    }

    /// The first entry, if its speeds are final; `now` gives it in any case, as fast as what is there allows.
    pub fn take(&mut self, now: bool) -> Option<Planned> {
        if self.is_empty() {
            return None;
        }
        let motion = match self.slot(self.first) {
            Slot::Motion(motion) => motion,
            Slot::Other(entry, _) => {
                self.first = self.first.wrapping_add(1);
                return Some(Planned { entry, ms: 0.0 });
            }
            Slot::Empty => return None,
        };
        self.plan();
        let (high, settled, bend) = match self.next_motion(self.first.wrapping_add(1)) {
            Ok((_, next)) => (next.high, next.settled, next.bend),
            Err(rests) => (0.0, rests, [0.0; 4]),
        };
        let span = self.span(&motion, &bend);
        let end = span.on(self.begin, high);
        if !(now || settled || end < high) {
            return None;
        }
        let (vel, acc, ms) = span.choose(self.begin, end, motion.vel, motion.round.is_some());
        let bits = [vel.max(LEAST), acc.max(LEAST), sqrt(end)].map(f64::to_bits);
        let entry = Along::admit(bits[0], bits[1], bits[2]).ok().and_then(|along| motion.form.entry(along))?;
        (self.first, self.begin) = (self.first.wrapping_add(1), end);
        Some(Planned { entry, ms })
    }
}

/// How much of the path's speed each coordinate may have: of an arc all of it, in its plane.
fn shares(figure: &Figure) -> Place {
    let mut shares = figure.tangents[0].map(fabs);
    if let Some((_, plane)) = figure.round {
        for i in plane {
            shares[i] = 1.0;
        }
    }
    shares
}
