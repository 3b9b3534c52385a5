//! A slave that runs.
//!
//! In: the motion of its master within a tick, entries from their store, settings. Out: its planned
//! position, the actions of its entries ([`OutputActions`]), or its end. Owns: the piece in force
//! and its index in the FIFO. Fails: a wait for an input may time out.
//!
//! The slave is a function of (pass, segment, progress). Progress increases here: for a FIFO
//! downwards, or direction −1, it is the master's position with its sign changed. A pass begins at
//! an exact position of the master and one of the slave. Passes add the ends of their last entry to
//! these, forwards and backwards, so nothing accumulates, and the path back is the same as the path
//! there, to the bit. It goes back as far as the `floor`: the last switch, entry that is no
//! segment, or data that was added in a later pass.
//!
//! Work of a tick: at most [`ACTIONS`] entries that are no segments, then it holds there until the
//! next tick; a segment is found by bisection, passes are counted by a product.
mod geared;
mod pass_crossing;
mod seek;
mod switch;

use super::curve::{EXACT_TO_POS_BITS, slope};
use super::entry::{Input, QueueEntry};
use super::gear::Gear;
use super::master_path::{MasterPath, PositionTrack, REMAINDER_DOWN, Section, TimedPosition};
use super::setup::Setup;
use super::slave_track::record;
use super::{Direction, FollowEntries, Method};
use crate::segment::piece::Piece;
use crate::units::{CYCLE_NS, Exact, FineNs, Ns, Pos};

/// Entries that are no segments, in one tick of one axis.
pub const ACTIONS: usize = 8;
/// A cycle of FollowDelayEx, 250 µs, and a ms, in 2⁻³² ns.
const DELAY_CYCLE: FineNs = (CYCLE_NS as FineNs) << 32;
const FINE_NS_PER_MS: FineNs = 1_000_000 << 32;
/// Steps of [`FollowRun::catch_up`] in a tick: every action may be followed by the end of a pass.
const CATCH_UP_STEPS: usize = 3 * ACTIONS;

/// What entries do to outputs in one tick.
#[derive(Debug, Clone, Copy, Default)]
pub struct OutputActions {
    /// Group, bit and level, in order.
    pub outputs: [Option<(u8, u8, bool)>; ACTIONS],
    /// Actions done, of all kinds.
    done: usize,
}

/// Whether the motion goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FollowState {
    /// It does.
    Running,
    /// All passes have run.
    Ended {
        /// Where exactly.
        at: Exact,
    },
    /// The data moves the slave further at once than any tick may.
    TooFar,
    /// A wait for an input has timed out.
    TimedOut {
        /// Where exactly.
        at: Exact,
    },
}

/// What acts at the end of the tick computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum TickEndAction {
    /// SwitchNow.
    Switch(Method),
    /// The ratio of the settings.
    Ratio,
}

/// What it waits for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Wait {
    /// Nothing: it follows.
    No,
    /// The tick at which it starts.
    Start,
    /// The master's crossing of a position.
    Pass { up: bool, at: Pos },
    /// An instant, 2⁻³² ns.
    Until(FineNs),
    /// An input, at most until an instant.
    Input { input: Input, index: u8, high: bool, until: Option<FineNs> },
}

/// What a slave waits for, in 16 bits: 0 nothing, 1 PASS, 2 an input. Of an input, bit 2 is the
/// level, bit 3 its time limit, bits 4 to 6 its kind, the high byte its number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PackedWait(u16);

/// The same, unpacked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WaitCondition {
    /// The master's crossing of the position of PASS.
    Pass,
    /// A level of an input.
    Input {
        /// Which kind.
        input: Input,
        /// Its axis over all cores, or its number, from 0.
        index: u8,
        /// The high level.
        high: bool,
        /// A time ends the wait, too.
        limited: bool,
    },
}

impl PackedWait {
    /// It moves, or waits for a time.
    pub const NONE: PackedWait = PackedWait(0);

    /// What it is.
    pub fn what(self) -> Option<WaitCondition> {
        match self.0 & 3 {
            0 => None,
            1 => Some(WaitCondition::Pass),
            _ => Some(WaitCondition::Input {
                input: Input::of_bits((self.0 >> 4) as u8),
                index: (self.0 >> 8) as u8,
                high: self.0 & 4 != 0,
                limited: self.0 & 8 != 0,
            }),
        }
    }
}

/// A ratio that the chain of the data does not know: the addition to the start ratio of the segment
/// `from` of pass `pass`; the NORMAL segments after it have it with changing sign.
#[derive(Debug, Clone, Copy)]
struct RatioOffset {
    pass: u32,
    from: u32,
    odd: bool,
    ratio: i128,
}

/// What the piece after the one in force comes from.
#[derive(Debug, Clone, Copy)]
enum NextPiece {
    /// The data; it is made in its tick.
    Data,
    /// The data, and it was made already.
    Prepared(PreparedPiece),
    /// In gear: its law, in place of a FIFO.
    Gear(Gear),
}

/// A piece that was made before its tick: of this entry in this pass, which began at these
/// positions.
#[derive(Debug, Clone, Copy)]
struct PreparedPiece {
    piece: Piece,
    index: u32,
    pass: u32,
    began: i128,
    origin: i128,
}

state! {
    /// A slave that runs.
    #[derive(Debug, Clone, Copy)]
    pub struct FollowRun {
        /// The piece in force, over the progress in units of Pos.
        pub piece: Piece = Piece::standstill(Ns(0), 0, origin.round()),
        both: bool = setup.direction == Direction::Both,
        /// Whether progress is the master's position with its sign changed.
        pub(crate) down: bool = if setup.direction == Direction::Both {
            setup.fifo(fifo).tail.down
        } else {
            setup.direction == Direction::Down
        },
        /// Directions Up and Down: the furthest progress reached.
        furthest: i64 = i64::MIN,
        /// The progress of the tick computed last.
        progress: i64 = 0,
        /// The FIFO that runs, and whether the other one takes over at the end of the pass.
        pub(crate) fifo: u8 = fifo,
        pub(crate) switching: bool = false,
        /// Set by SwitchNow and for a new ratio, until the tick has been computed.
        now: Option<TickEndAction> = None,
        wait: Wait = Wait::Start,
        /// The entry whose piece is loaded.
        index: u32 = 0,
        /// Entries before this one are done in the present pass.
        done: u32 = 0,
        /// Passes completed before the present one.
        pub pass: u32 = 0,
        /// Progress, 2⁻⁶⁴ pulse, and slave at the beginning of the present pass.
        began: i128 = 0,
        origin: i128 = origin.0,
        /// What the exact beginning has above `began`, 2⁻⁵³ pulse: `began` is rounded where a delay
        /// or a wait ended.
        remainder: i32 = 0,
        /// The slave does not go back before this entry of this pass.
        floor: (u32, u32) = (if setup.gear.is_some() { u32::MAX } else { 0 }, 0),
        /// It follows in both directions, and is just at its floor: a master that goes back does
        /// not move it.
        at_floor: bool = false,
        /// Ratio with which a FIFO that begins with CONTINUE goes on, in every pass.
        carried: i128 = 0,
        more: Option<RatioOffset> = None,
        /// The piece after the one in force, and whether it may still be to be made ahead.
        next: NextPiece = setup.gear.map_or(NextPiece::Data, |ratio| {
            NextPiece::Gear(Gear::begin(ratio, setup.direction == Direction::Down, 0))
        }),
        open: bool = false,
        /// A piece lies further from the one before than any tick may move.
        far: bool = false,
        /// SwitchNow in the last segment: the ratio at which the next pass starts.
        given: Option<i128> = None,
        /// The slave was held by the entry done last.
        held: bool = false,
        /// The count at which data ended in the last tick.
        end: u32 = 0,
        /// FIFOs that a switch has emptied: 1 bit each, until the axis has taken them.
        emptied: u8 = 0,
    }
    /// A motion from the position `origin` which starts in the tick computed next.
    #[inline(always)]
    pub fn begin(setup: &Setup, origin: Exact, fifo: u8);
}

/// What a tick uses besides the run.
pub struct FollowContext<'a, S, L> {
    setup: &'a mut Setup,
    source: &'a S,
    level: L,
    actions: &'a mut OutputActions,
    /// The tick in force, 2⁻³² ns.
    base: FineNs,
}

impl<'a, S: FollowEntries, L: Fn(Input, u8) -> bool> FollowContext<'a, S, L> {
    /// Settings and FIFOs of the axis, its entries, the levels of inputs as sampled in the tick in
    /// force; the actions of entries go to `actions`.
    pub fn new(setup: &'a mut Setup, source: &'a S, level: L, actions: &'a mut OutputActions) -> Self {
        FollowContext { setup, source, level, actions, base: 0 }
    }
}

/// The result of a search.
enum Seek {
    /// In a segment, or at standstill before the floor.
    Here,
    /// At an entry that is no segment.
    Stop(u32),
    /// At the end of the motion.
    End(i128),
}

impl FollowRun {
    /// FIFOs that a switch has emptied since the last call, a bit each.
    pub fn take_emptied(&mut self) -> u8 {
        core::mem::take(&mut self.emptied)
    }

    /// The other FIFO takes over when the present pass ends.
    pub fn switch(&mut self) {
        self.invalidate_prepared();
        self.switching = true;
    }

    /// The next segment or the other FIFO takes over at the tick computed next.
    pub fn switch_now(&mut self, method: Method) {
        self.invalidate_prepared();
        self.now = Some(TickEndAction::Switch(method));
    }

    /// In gear: the ratio of the settings takes over at the tick computed next.
    pub fn take_ratio(&mut self) {
        self.now = Some(TickEndAction::Ratio);
    }

    /// Data or settings have changed: something else may follow now.
    pub fn invalidate_prepared(&mut self) {
        if self.gear().is_none() {
            (self.next, self.open) = (NextPiece::Data, self.piece.span != 0);
        }
    }

    /// Its law, if it is in gear.
    fn gear(&self) -> Option<&Gear> {
        if let NextPiece::Gear(gear) = &self.next { Some(gear) } else { None }
    }

    /// Whether [`FollowRun::prepare`] may have something to do.
    #[inline(always)]
    pub fn is_open(&self) -> bool {
        self.open
    }

    /// Progress of a position.
    #[inline(always)]
    fn directed(&self, pos: Pos) -> i64 {
        if self.down { pos.0.wrapping_neg() } else { pos.0 }
    }

    /// The position with the master at `to`, if the master came there straight and inside one
    /// piece, and nothing else is to be done; else None, and [`FollowRun::step`] has to do it.
    #[inline(always)]
    pub fn fast_step(&mut self, to: Pos) -> Option<(Pos, u64)> {
        let mut progress = self.directed(to);
        if !self.both {
            progress = progress.max(self.furthest);
        }
        let mut t = (progress as u64).wrapping_sub(self.piece.begin.0);
        if t >= self.piece.span {
            t = self.turn(progress)?;
        }
        // What is reported of a slave at its floor holds only there.
        if self.now.is_some() || self.at_floor && progress != self.progress {
            return None;
        }
        (self.progress, self.furthest) = (progress, progress);
        Some(self.piece.at(t))
    }

    /// Whether the slave has no turning point between its present position and that for a master at
    /// `to`.
    #[inline(never)]
    pub(crate) fn is_fast_and_straight(&self, to: Pos) -> bool {
        let falls = |progress: i64| {
            let t = (progress as u64).wrapping_sub(self.piece.begin.0);
            (t < self.piece.span).then(|| slope(&self.piece.motion, self.piece.at(t).1) < 0)
        };
        let before = falls(self.progress);
        before.is_some() && before == falls(self.directed(to))
    }

    /// The present planned position, and the parameter in its piece.
    pub fn position(&self) -> (Pos, u64) {
        let t = (self.progress as u64).wrapping_sub(self.piece.begin.0);
        if t < self.piece.span { self.piece.at(t) } else { (self.piece.start, 0) }
    }

    /// Whether the slave moves with a master at `to`: it does not wait, and the master is neither
    /// before the furthest point nor before the start.
    #[inline(always)]
    pub fn is_moving(&self, to: Pos) -> bool {
        self.piece.span != 0 && self.directed(to) == self.progress
    }

    /// Whether progress backwards has no effect.
    pub fn is_one_way(&self) -> bool {
        !self.both || self.at_floor
    }

    /// The tick after `path.now`. `named` is the position of the path at which the master's user
    /// position is 0, for PASS.
    pub fn step<S: FollowEntries, L: Fn(Input, u8) -> bool>(
        &mut self,
        path: &MasterPath,
        named: i64,
        context: &mut FollowContext<S, L>,
        mut track: Option<&mut PositionTrack>,
    ) -> FollowState {
        let to = path.last();
        let first = path.sections().next().unwrap_or(Section::still(path.now, to));
        let mut end = self.open(path.now, &first, to, context);
        for section in path.sections() {
            end = end.or_else(|| self.go(&section, context, track.as_deref_mut()));
        }
        end.or_else(|| self.close(path.now, to, named, context)).unwrap_or(FollowState::Running)
    }

    /// What it waits for.
    pub(crate) fn awaits(&self) -> PackedWait {
        match self.wait {
            Wait::No | Wait::Start | Wait::Until(_) => PackedWait::NONE,
            Wait::Pass { .. } => PackedWait(1),
            Wait::Input { input, index, high, until } => PackedWait(
                2 | (high as u16) << 2 | (until.is_some() as u16) << 3 | (input as u16) << 4 | (index as u16) << 8,
            ),
        }
    }

    /// A tick begins with a section of the master's path, and ends with the master at `to`: takes
    /// added data into account, and reads inputs.
    pub(super) fn open<S: FollowEntries, L: Fn(Input, u8) -> bool>(
        &mut self,
        now: Ns,
        first: &Section,
        to: TimedPosition,
        context: &mut FollowContext<S, L>,
    ) -> Option<FollowState> {
        context.base = (now.0 as FineNs) << 32;
        self.append(context);
        if let Wait::Input { input, index, high, until } = self.wait {
            if (context.level)(input, index) == high {
                self.resume(first.from.pos, first.at(0), context);
            } else if until.is_some_and(|until| until <= context.base.wrapping_add(to.after as FineNs)) {
                return Some(FollowState::TimedOut { at: self.knot(self.done, context) });
            }
        }
        None
    }

    /// The master moves along a section; positions of the slave itself go to `track`.
    #[inline(never)]
    pub(super) fn go<S: FollowEntries, L: Fn(Input, u8) -> bool>(
        &mut self,
        section: &Section,
        context: &mut FollowContext<S, L>,
        track: Option<&mut PositionTrack>,
    ) -> Option<FollowState> {
        let before = track.is_some().then_some((self.piece, self.progress, self.down));
        let end = self.advance(section, context);
        if let (Some(track), Some((piece, progress, down))) = (track, before) {
            // Progress that has changed its sign is that of another FIFO: the path there is not
            // known.
            let piece = if self.down == down { piece } else { self.piece };
            if self.progress != progress {
                record((&piece, progress), (&self.piece, self.progress), down, section, track);
            }
            track.push(section.to.after, self.position().0);
        }
        end
    }

    /// The first piece was made for a master at 0: it begins at the master's present position.
    fn enter_prepared(&mut self, prepared: &PreparedPiece) {
        self.piece = prepared.piece;
        self.piece.begin = Ns(self.piece.begin.0.wrapping_add(self.progress as u64));
        (self.index, self.held, self.open) = (prepared.index, false, true);
    }

    /// Data that was added belongs to the present pass: earlier ones had another length.
    fn append<L>(&mut self, context: &mut FollowContext<impl FollowEntries, L>) {
        let end = context.setup.fifo(self.fifo).end;
        if end != self.end {
            if self.end != 0 && self.floor.0 != self.pass {
                self.floor = (self.pass, 0);
            }
            self.end = end;
        }
    }

    /// Brings piece and entries up to the present progress, which the master reached along
    /// `section`.
    fn catch_up<S: FollowEntries, L: Fn(Input, u8) -> bool>(
        &mut self,
        section: &mut Section,
        context: &mut FollowContext<S, L>,
    ) -> Option<FollowState> {
        if let Some(gear) = self.gear() {
            self.seek_geared(*gear);
            return self.far.then_some(FollowState::TooFar);
        }
        for _ in 0..CATCH_UP_STEPS {
            match self.seek(context) {
                Seek::Here => return self.far.then_some(FollowState::TooFar),
                Seek::End(at) if self.is_far(at) => return Some(FollowState::TooFar),
                Seek::End(at) => return Some(FollowState::Ended { at: Exact(at) }),
                Seek::Stop(index) => {
                    if context.actions.done >= ACTIONS {
                        // The next tick goes on here.
                        self.hold(index, context);
                        return None;
                    }
                    context.actions.done = context.actions.done.wrapping_add(1);
                    if self.act(index, section, context) {
                        return None;
                    }
                }
            }
        }
        None
    }

    /// Carries out the entry `index`, which is no segment. Returns whether it holds the slave.
    fn act<S: FollowEntries, L: Fn(Input, u8) -> bool>(
        &mut self,
        index: u32,
        section: &mut Section,
        context: &mut FollowContext<S, L>,
    ) -> bool {
        let entry = context.source.entry(self.fifo, index);
        if self.held && self.comes_after_segment(index, context) {
            // It was passed within this tick, without a piece of its own.
            self.held = false;
        }
        let (knot, _) = entry.ends();
        let reached = self.began.wrapping_add(knot).wrapping_add((self.remainder as i128) << REMAINDER_DOWN);
        let reached = Exact(if self.down { reached.wrapping_neg() } else { reached });
        self.done = index.wrapping_add(1);
        self.floor = (self.pass, self.done);
        let base = context.base;
        let when = |section: &Section| base.wrapping_add(section.when(reached) as FineNs);
        match entry.action() {
            QueueEntry::Output { group, bit, high } => {
                if let Some(position) = context.actions.outputs.get_mut(context.actions.done.wrapping_sub(1)) {
                    *position = Some((group as u8, bit, high));
                }
                return false;
            }
            QueueEntry::Delay { cycles } => {
                if cycles == 0 {
                    return false;
                }
                let until = when(section).wrapping_add(DELAY_CYCLE.wrapping_mul(cycles as FineNs));
                self.wait = Wait::Until(until);
            }
            QueueEntry::Wait { input, index, high, timeout_ms } => {
                // The level in force when the entry is reached is that of the sample before.
                if (context.level)(input, index) == high {
                    return false;
                }
                let until = (timeout_ms != 0)
                    .then(|| when(section).wrapping_add(FINE_NS_PER_MS.wrapping_mul(timeout_ms as FineNs)));
                self.wait = Wait::Input { input, index, high, until };
            }
            QueueEntry::Switch(Method::Segment) => {
                // The next segment follows anyway. In the last one, the pass has ended.
                return false;
            }
            QueueEntry::Switch(Method::Table) => {
                let ratio = if self.held { 0 } else { self.end_ratio(index, context) };
                let (knot, end) = entry.ends();
                let (began, origin) = (self.began.wrapping_add(knot), self.origin.wrapping_add(end));
                if !context.setup.is_empty(self.fifo ^ 1) {
                    self.enter_other(began, origin, ratio, true, context);
                }
                return false;
            }
        }
        self.held = true;
        self.hold(self.done, context);
        // A delay may end in this very section.
        if let Wait::Until(until) = self.wait {
            let after = until.saturating_sub(context.base);
            if after <= section.to.after as FineNs {
                let exact = section.begin_at(after as u64);
                self.resume(section.from.pos, exact, context);
                self.reach(section.to.pos);
                return false;
            }
        }
        true
    }

    /// Whether the entry before this one is a segment, be it the last one of the pass before.
    fn comes_after_segment<L>(&self, index: u32, context: &FollowContext<impl FollowEntries, L>) -> bool {
        let of = if index == 0 { context.setup.fifo(self.fifo).end } else { index };
        of.checked_sub(1).is_some_and(|before| context.source.entry(self.fifo, before).kind().is_some())
    }

    /// The slave is held at the beginning of an entry.
    fn hold<L>(&mut self, index: u32, context: &FollowContext<impl FollowEntries, L>) {
        let at = self.knot(index, context);
        self.far |= self.is_far(at.0);
        self.piece = Piece::standstill(Ns(0), 0, at.round());
        (self.next, self.open) = (NextPiece::Data, false);
    }

    /// A delay or a wait is over with the master at `pos`, which is `exact` rounded: the next
    /// segment begins at `pos`. Instants count from `exact`, so that no rounding adds up.
    fn resume<L>(&mut self, pos: Pos, exact: Exact, context: &FollowContext<impl FollowEntries, L>) {
        self.wait = Wait::No;
        self.progress = self.directed(pos);
        self.furthest = self.progress;
        let (knot, _) = self.ends_before(self.done, context);
        self.began = ((self.progress as i128) << EXACT_TO_POS_BITS).wrapping_sub(knot);
        let above = exact.0.wrapping_sub(Exact::from(pos).0);
        // Rounded down: what comes directly after begins now, and not later.
        self.remainder = (if self.down { above.wrapping_neg() } else { above } >> REMAINDER_DOWN) as i32;
    }

    /// The master is at `to`.
    fn reach(&mut self, to: Pos) {
        let progress = self.directed(to);
        if self.both || progress > self.furthest {
            (self.progress, self.furthest) = (progress, progress);
        }
    }
}
