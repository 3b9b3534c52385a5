//! PT evaluation: a PT motion that runs.
//!
//! In: segments from their store, how many of them are allowed, instants. Out: pieces. Owns: the
//! chain of velocities. Fails: a stream without data ends in [`GeneratorState::Underrun`].
use super::segment::SegmentKind;
use super::store::Segments;
use crate::math::wide::{Divisor, Recip, scale16};
use crate::segment::generator_state::GeneratorState;
use crate::segment::piece::Piece;
use crate::units::{Exact, Ns};

/// Which slots a run uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SlotRange {
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
pub struct AllowedData {
    /// Static: committed segments of the FIFO. Dynamic: running counter after the last.
    pub end: u32,
    /// Static: passes to run, 0 for ever.
    pub passes: u32,
}

/// The state of a run after the last segment it loaded. In two parts, each copied in a few words at
/// a time; the whole would need a call.
#[derive(Debug, Clone, Copy)]
struct LoadState {
    pass: PtPass,
    chain: LoadedEnd,
}

/// The present pass, or the stream.
#[derive(Debug, Clone, Copy)]
struct PtPass {
    /// Position at which it began.
    origin: Exact,
    /// Its instant.
    begin: Ns,
    /// Passes completed.
    passes: u32,
}

/// The chain of segments.
#[derive(Debug, Clone, Copy)]
struct LoadedEnd {
    /// Counter of the next segment.
    next: u32,
    /// End time of the last segment, from the pass's begin.
    knot_ms: u32,
    /// Its end, from the pass's origin.
    knot: Exact,
    /// Its end velocity in 2⁻⁸⁰ pulse/ms.
    velocity: i128,
    /// Quotients with a remainder that went into `velocity`, each within 2⁻⁸¹ pulse/ms.
    rounded: u32,
}

/// A PT motion that runs.
#[derive(Debug, Clone, Copy)]
pub struct PtRun {
    /// After the last piece made, and after the one before it.
    track: LoadState,
    back: LoadState,
    slots: SlotRange,
    /// Duration of the last segment loaded, as a divisor, and 1/(it in ns): a stream's is constant.
    duration: u32,
    divisor: Divisor,
    recip: Recip,
}

/// Knots crossed in a tick: two where a pass begins on a tick of 1 ms; more only to catch up after
/// ticks longer than any setting of the board.
const KNOTS_PER_TICK: u32 = 8;

impl PtRun {
    /// A motion whose time is zero at `now`, from the position `origin`.
    pub fn begin(now: Ns, origin: Exact, slots: SlotRange) -> PtRun {
        let next = match slots {
            SlotRange::Static { .. } => 0,
            SlotRange::Dynamic { first, .. } => first,
        };
        let pass = PtPass { origin, begin: now, passes: 0 };
        let track = LoadState { pass, chain: LoadedEnd { next, knot_ms: 0, knot: Exact(0), velocity: 0, rounded: 0 } };
        PtRun { track, back: track, slots, duration: 0, divisor: Divisor::new(1), recip: Recip::default() }
    }

    /// A motion prepared for time 0 begins at `now`.
    pub(crate) fn shift(&mut self, now: Ns) {
        for track in [&mut self.track, &mut self.back] {
            track.pass.begin = Ns(track.pass.begin.0.wrapping_add(now.0));
        }
    }

    /// Whether it takes its segments from a ring.
    #[inline(always)]
    pub(crate) fn is_stream(&self) -> bool {
        matches!(self.slots, SlotRange::Dynamic { .. })
    }

    /// The state with the piece in force; `ahead`: the last one made is not in force yet.
    #[inline(always)]
    fn state_in_force(&self, ahead: bool) -> &LoadState {
        if ahead { &self.back } else { &self.track }
    }

    /// Passes completed.
    pub fn passes(&self, ahead: bool) -> u32 {
        self.state_in_force(ahead).pass.passes
    }

    /// Dynamic: counter of the first segment that has not run yet; all before it are free.
    /// `running` is false once the run has ended.
    pub fn released(&self, running: bool, ahead: bool) -> u32 {
        let began = match self.slots {
            SlotRange::Static { .. } => 0,
            SlotRange::Dynamic { first, .. } => first,
        };
        let next = self.state_in_force(ahead).chain.next;
        if running && next != began { next.wrapping_sub(1) } else { next }
    }

    /// End time of what is committed minus now, in whole ms, rounded down; 0 if it has passed.
    pub fn dry_ms(&self, now: Ns, feed: AllowedData, source: &impl Segments, ahead: bool) -> u32 {
        if feed.end == 0 {
            return 0;
        }
        let last = source.segment(self.slot(feed.end.wrapping_sub(1))).time_ms();
        let since = now.0.wrapping_sub(self.state_in_force(ahead).pass.begin.0);
        let left = (last as u64 * NS_PER_MS).saturating_sub(since);
        // floor(x / 10⁶) for every 64-bit x, without dividing.
        (crate::math::wide::umulhi(left, 0x431B_DE82_D7B6_34DB) >> 18) as u32
    }

    #[inline(always)]
    fn slot(&self, counter: u32) -> u32 {
        match self.slots {
            SlotRange::Static { base } => base.wrapping_add(counter),
            SlotRange::Dynamic { mask, .. } => counter & mask,
        }
    }

    /// Makes the piece that holds `now`, which is not before the end of the last one made; or the
    /// end.
    #[inline(never)]
    pub fn advance(&mut self, now: Ns, feed: AllowedData, source: &impl Segments, piece: &mut Piece) -> GeneratorState {
        self.back.pass = self.track.pass;
        self.back.chain = self.track.chain;
        for _ in 0..KNOTS_PER_TICK {
            if self.track.chain.next == feed.end && !self.next_pass(feed) {
                return self.end();
            }
            self.load(source, piece);
            if piece.elapsed(now) < piece.span {
                break;
            }
        }
        GeneratorState::Running
    }

    /// Whether the last piece made begins a pass.
    #[inline]
    pub fn is_new_pass(&self) -> bool {
        self.track.pass.begin != self.back.pass.begin
    }

    /// As if the last piece had not been made.
    #[inline(never)]
    pub fn retract(&mut self) {
        self.track = self.back;
    }

    fn end(&self) -> GeneratorState {
        let LoadState { pass: PtPass { origin, .. }, chain: LoadedEnd { knot, velocity, rounded, .. } } = &self.track;
        let at = Exact(origin.0.wrapping_add(knot.0));
        // Within the chain's own error bound, which is 0 as long as all quotients came out even.
        let at_standstill = velocity.unsigned_abs() << 1 <= *rounded as u128;
        let dry = matches!(self.slots, SlotRange::Dynamic { .. }) && !at_standstill;
        if dry { GeneratorState::Underrun { at } } else { GeneratorState::Ended { at } }
    }

    /// The present pass has ended; whether another follows.
    fn next_pass(&mut self, feed: AllowedData) -> bool {
        if let SlotRange::Dynamic { .. } = self.slots {
            return false;
        }
        let LoadState { pass, chain } = &mut self.track;
        pass.passes = pass.passes.wrapping_add(1);
        if chain.next == 0 || feed.passes != 0 && pass.passes >= feed.passes {
            return false;
        }
        pass.origin = Exact(pass.origin.0.wrapping_add(chain.knot.0));
        pass.begin = Ns(pass.begin.0.wrapping_add(chain.knot_ms as u64 * NS_PER_MS));
        *chain = LoadedEnd { next: 0, knot_ms: 0, knot: Exact(0), velocity: 0, rounded: 0 };
        true
    }

    /// Makes the piece of the next segment. Not inlined into the loop over knots, which would keep
    /// its state on the stack.
    #[inline(never)]
    fn load(&mut self, source: &impl Segments, piece: &mut Piece) {
        let segment = source.segment(self.slot(self.track.chain.next));
        let (knot, knot_ms) = (segment.position(), segment.time_ms());
        let duration = knot_ms.wrapping_sub(self.track.chain.knot_ms);
        if duration != self.duration {
            self.take_duration(duration);
        }
        let LoadState { pass, chain } = &mut self.track;
        chain.next = chain.next.wrapping_add(1);
        let length = knot.0.wrapping_sub(chain.knot.0);
        let kind = segment.kind();
        let (a, b);
        if kind == SegmentKind::Stop {
            (a, b) = (length << 1, length.wrapping_neg());
            (chain.velocity, chain.rounded) = (0, 0);
        } else {
            let normal = kind == SegmentKind::Normal;
            let (mean, rounded) = over_time(length << normal as u32, &self.divisor);
            if normal {
                let sign = chain.velocity >> 127;
                let displacement = scale16(chain.velocity.unsigned_abs(), duration) as i128;
                a = (displacement ^ sign).wrapping_sub(sign);
                b = length.wrapping_sub(a);
                chain.velocity = mean.wrapping_sub(chain.velocity);
                chain.rounded = chain.rounded.saturating_add(rounded);
            } else {
                (a, b) = (length, 0);
                (chain.velocity, chain.rounded) = (mean, rounded);
            }
        }
        let begin = Ns(pass.begin.0.wrapping_add(chain.knot_ms as u64 * NS_PER_MS));
        let start = Exact(pass.origin.0.wrapping_add(chain.knot.0));
        *piece = Piece::quadratic(begin, duration as u64 * NS_PER_MS, self.recip, start, a, b);
        (chain.knot, chain.knot_ms) = (knot, knot_ms);
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
