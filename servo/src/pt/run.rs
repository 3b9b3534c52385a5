//! A PT motion that runs.
//!
//! In: segments from where they lie, how many of them are allowed, instants. Out: a [`Step`] a tick.
//! Owns: the piece in force and the one after it, the chain of velocities. Fails: a stream without
//! data ends in [`State::Underrun`].
use super::segment::Kind;
use super::store::Segments;
use crate::piece::{Motion, Piece};
use crate::profile::{State, Step};
use crate::units::{Exact, Ns};
use crate::wide::{Divisor, Recip, scale16};

/// Which slots a run uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// Segments 0… of a pass lie in slots `base`….
    Static {
        /// First slot.
        base: u32,
    },
    /// Running counters into a ring; `mask` is its length − 1, a power of two less one.
    Dynamic {
        /// Slot = counter & mask.
        mask: u32,
        /// Counter of the first segment of the stream.
        first: u32,
    },
}

/// What the thread has allowed so far; may change at every tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Feed {
    /// Static: committed segments of the FIFO. Dynamic: running counter behind the last.
    pub end: u32,
    /// Static: passes to run, 0 for ever.
    pub passes: u32,
}

/// A PT motion that runs.
#[derive(Debug, Clone, Copy)]
#[repr(C)] // the piece first, as in every motion
pub struct PtRun {
    piece: Piece,
    /// The piece after it, if `ready`. Then all below is as of its end, not of the piece's in force.
    ahead: Piece,
    ready: bool,
    place: Place,
    /// Duration of the last segment loaded, ready to divide by, and 1/(it in ns): a stream's is constant.
    duration: u32,
    divisor: Divisor,
    recip: Recip,
    /// Counter of the next segment.
    next: u32,
    /// Passes completed.
    passes: u32,
    /// Position at which the present pass (or the stream) began.
    origin: Exact,
    /// Its instant.
    pass_begin: Ns,
    /// End of the present segment, from `origin`.
    knot: Exact,
    /// End time of the present segment, from `pass_begin`.
    knot_ms: u32,
    /// End velocity of the present segment in 2⁻⁸⁰ pulse/ms.
    velocity: i128,
    /// Quotients with a remainder that went into `velocity`, each within 2⁻⁸¹ pulse/ms.
    rounded: u32,
}

/// Knots crossed in a tick: two where a pass begins on a tick of 1 ms, more only to catch up
/// after ticks longer than any setting of the board.
const KNOTS_PER_TICK: u32 = 4;

impl PtRun {
    /// A motion whose time is zero at `now`, from the position `origin`. The first segment is
    /// read by the first step.
    pub fn begin(now: Ns, origin: Exact, place: Place) -> PtRun {
        PtRun {
            piece: Piece { begin: now, span: 0, start: origin.round(), ..Piece::default() },
            ahead: Piece::default(),
            ready: false,
            place,
            duration: 0,
            divisor: Divisor::new(1),
            recip: Recip::default(),
            next: match place {
                Place::Static { .. } => 0,
                Place::Dynamic { first, .. } => first,
            },
            passes: 0,
            origin,
            pass_begin: now,
            knot: Exact(0),
            knot_ms: 0,
            velocity: 0,
            rounded: 0,
        }
    }

    /// Passes completed.
    pub fn passes(&self) -> u32 {
        self.passes
    }

    /// Dynamic: counter of the first segment that has not run yet, all before it are free.
    /// `running` is false once the run has ended.
    pub fn released(&self, running: bool) -> u32 {
        let began = match self.place {
            Place::Static { .. } => 0,
            Place::Dynamic { first, .. } => first,
        };
        if running && self.next != began {
            self.next.wrapping_sub(1).wrapping_sub(self.ready as u32)
        } else {
            self.next
        }
    }

    /// End time of what is committed minus now, in whole ms, rounded down; 0 if it has passed.
    pub fn dry_ms(&self, now: Ns, feed: Feed, source: &impl Segments) -> u32 {
        if feed.end == self.released(false) && self.piece.span == 0 {
            return 0;
        }
        let last = source.segment(self.slot(feed.end.wrapping_sub(1))).time_ms();
        let left = (last as u64 * NS_PER_MS).saturating_sub(now.0.wrapping_sub(self.pass_begin.0));
        // floor(x / 10⁶) for every 64-bit x, without dividing.
        (crate::wide::umulhi(left, 0x431B_DE82_D7B6_34DB) >> 18) as u32
    }

    #[inline(always)]
    fn slot(&self, counter: u32) -> u32 {
        match self.place {
            Place::Static { base } => base.wrapping_add(counter),
            Place::Dynamic { mask, .. } => counter & mask,
        }
    }

    /// The motion at `now`, which must not go back between calls.
    #[inline]
    pub fn step(&mut self, now: Ns, feed: Feed, source: &impl Segments) -> Step {
        if self.piece.elapsed(now) >= self.piece.span
            && let state @ (State::Ended { at } | State::Underrun { at }) = self.turn(now, feed, source)
        {
            return Step { pos: at.round(), motion: Motion::REST, state };
        }
        let (pos, tau) = self.piece.at(self.piece.held(now));
        Step { pos, motion: self.piece.motion(tau), state: State::Running }
    }

    /// The piece in force, as far as the last step or turn saw.
    #[inline(always)]
    pub fn piece(&self) -> &Piece {
        &self.piece
    }

    /// The piece is over at `now`: on to the one that holds it, or to the end.
    #[inline]
    pub fn turn(&mut self, now: Ns, feed: Feed, source: &impl Segments) -> State {
        if self.go_on(now, feed, source) {
            return State::Running;
        }
        let at = Exact(self.origin.0.wrapping_add(self.knot.0));
        let dry = matches!(self.place, Place::Dynamic { .. }) && !self.at_rest();
        if dry { State::Underrun { at } } else { State::Ended { at } }
    }

    /// On to the segment that holds `now`; false at the end of the motion.
    #[inline(never)]
    fn go_on(&mut self, now: Ns, feed: Feed, source: &impl Segments) -> bool {
        for _ in 0..KNOTS_PER_TICK {
            if !self.ready {
                if self.next == feed.end && !self.next_pass(feed) {
                    return false;
                }
                self.load(source);
            }
            self.ready = false;
            self.piece = self.ahead;
            if self.piece.elapsed(now) < self.piece.span {
                break;
            }
        }
        true
    }

    /// Computes the next segment of the pass ahead of its tick, so that many axes can enter segments in
    /// one tick; what is prepared is what would have been computed. Whether there was something to do.
    #[inline(never)]
    pub fn prepare(&mut self, feed: Feed, source: &impl Segments) -> bool {
        let due = !self.ready && self.piece.span != 0 && self.next != feed.end;
        if due {
            self.load(source);
        }
        due
    }

    /// The present pass has ended; whether another follows.
    fn next_pass(&mut self, feed: Feed) -> bool {
        if let Place::Dynamic { .. } = self.place {
            return false;
        }
        self.passes = self.passes.wrapping_add(1);
        if self.next == 0 || feed.passes != 0 && self.passes >= feed.passes {
            return false;
        }
        self.origin = Exact(self.origin.0.wrapping_add(self.knot.0));
        self.pass_begin = Ns(self.pass_begin.0.wrapping_add(self.knot_ms as u64 * NS_PER_MS));
        (self.next, self.knot, self.knot_ms, self.velocity, self.rounded) = (0, Exact(0), 0, 0, 0);
        true
    }

    /// Whether the chain ends at velocity 0: within its own error bound, which is 0 as long as
    /// all quotients came out even.
    fn at_rest(&self) -> bool {
        self.velocity.unsigned_abs() << 1 <= self.rounded as u128
    }

    /// Makes the piece of the next segment. Not inlined into the loop over knots, where its state would
    /// be kept on the stack.
    #[inline(never)]
    fn load(&mut self, source: &impl Segments) {
        let segment = source.segment(self.slot(self.next));
        (self.next, self.ready) = (self.next.wrapping_add(1), true);
        let (knot, knot_ms) = (segment.position(), segment.time_ms());
        let duration = knot_ms.wrapping_sub(self.knot_ms);
        if duration != self.duration {
            self.take_duration(duration);
        }
        let length = knot.0.wrapping_sub(self.knot.0);
        let kind = segment.kind();
        let (a, b);
        if kind == Kind::Stop {
            (a, b) = (length << 1, length.wrapping_neg());
            (self.velocity, self.rounded) = (0, 0);
        } else {
            let normal = kind == Kind::Normal;
            let (mean, rounded) = over_time(length << normal as u32, &self.divisor);
            if normal {
                let sign = self.velocity >> 127;
                let swing = scale16(self.velocity.unsigned_abs(), duration) as i128;
                a = (swing ^ sign).wrapping_sub(sign);
                b = length.wrapping_sub(a);
                self.velocity = mean.wrapping_sub(self.velocity);
                self.rounded = self.rounded.saturating_add(rounded);
            } else {
                (a, b) = (length, 0);
                (self.velocity, self.rounded) = (mean, rounded);
            }
        }
        let begin = Ns(self.pass_begin.0.wrapping_add(self.knot_ms as u64 * NS_PER_MS));
        let start = Exact(self.origin.0.wrapping_add(self.knot.0));
        self.ahead = Piece::quadratic_at(begin, duration as u64 * NS_PER_MS, self.recip, start, a, b);
        (self.knot, self.knot_ms) = (knot, knot_ms);
    }

    #[inline(never)]
    fn take_duration(&mut self, duration: u32) {
        self.duration = duration;
        self.divisor = Divisor::new(duration);
        self.recip = Recip::of(duration as u64 * NS_PER_MS);
    }
}

/// x/`duration` from 2⁻⁶⁴ to 2⁻⁸⁰, to nearest, and 1 if a remainder was left.
#[inline(always)]
fn over_time(x: i128, duration: &Divisor) -> (i128, u32) {
    let sign = x >> 127;
    let (q, even) = duration.quotient((((x ^ sign).wrapping_sub(sign)) as u128) << 16);
    ((q as i128 ^ sign).wrapping_sub(sign), !even as u32)
}

const NS_PER_MS: u64 = 1_000_000;
