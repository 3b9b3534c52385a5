//! A slave that runs.
//!
//! In: the way of its master inside a tick, entries from where they lie, settings. Out: its planned position,
//! what its entries do ([`Deeds`]), or its end. Owns: the piece in force and its place in the FIFO. Fails: a wait for
//! an input may time out.
//!
//! The slave is a function of (pass, segment, progress). Progress runs upwards here: that of a FIFO downwards, or of
//! direction −1, is the master's position with its sign changed. A pass begins at an exact position of the master and one of
//! the slave, to which passes add the ends of their last entry, forwards and backwards, so nothing accumulates and
//! the way back is the way there, to the bit. It goes back as far as the `floor`: the last switch, entry that is no
//! segment, or data that was added in a later pass.
//!
//! Work of a tick: [`ACTIONS`] entries that are no segments at most, then it holds there until the next; a segment
//! is found by bisection, passes are counted by a product.
use super::entry::{Entry, Input, Stop};
use super::follower::image;
use super::ratio::swing;
use super::setup::Setup;
use super::shape::{Segment, UNIT, ceil, ratio_at, slope};
use super::way::{Fine, Spot, Stretch, Track, Way};
use super::{Direction, Entries, Event, Method};
use crate::op::DoGroup;
use crate::piece::Piece;
use crate::units::{Exact, Ns, Pos};
use crate::wide::{recip64_below, umulhi};

/// Entries that are no segments, in one tick of one axis.
pub const ACTIONS: usize = 8;
/// A cycle of FollowDelayEx, 250 µs, and a ms, in 2⁻³² ns.
const CYCLE: Fine = 250_000 << 32;
const MS: Fine = 1_000_000 << 32;
/// Steps of [`Run::settle`] in a tick: every action may be followed by the end of a pass.
const STEPS: usize = 3 * ACTIONS;

/// What entries do to outputs in one tick.
#[derive(Debug, Clone, Copy, Default)]
pub struct Deeds {
    /// Group, bit and level, in order.
    pub outputs: [Option<(u8, u8, bool)>; ACTIONS],
    /// Actions done, of all kinds.
    done: usize,
}

/// Whether the motion goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// It does.
    Running,
    /// All passes have run.
    Ended {
        /// Where exactly.
        at: Exact,
    },
    /// The data goes further at once than any tick may.
    TooFar,
    /// A wait for an input has timed out.
    TimedOut {
        /// Where exactly.
        at: Exact,
    },
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
    Until(Fine),
    /// An input, at most until an instant.
    Input { input: Input, index: u8, high: bool, until: Option<Fine> },
}

/// A ratio that the chain of the data does not know: how much more the segment `from` of pass `pass` starts with,
/// and with changing sign the NORMAL segments behind it.
#[derive(Debug, Clone, Copy)]
struct More {
    pass: u32,
    from: u32,
    odd: bool,
    ratio: i128,
}

/// A piece that was made before its tick: of this entry in this pass, which began there.
#[derive(Debug, Clone, Copy)]
struct Ahead {
    piece: Piece,
    index: u32,
    pass: u32,
    began: i128,
    origin: i128,
}

/// A slave that runs.
#[derive(Debug, Clone, Copy)]
pub struct FollowRun {
    /// Over the progress in units of Pos.
    piece: Piece,
    both: bool,
    down: bool,
    /// Directions Up and Down: the furthest progress reached.
    furthest: i64,
    /// The progress of the tick computed last.
    progress: i64,
    fifo: u8,
    switching: bool,
    /// Set by SwitchNow, until the tick has been computed.
    now: Option<Method>,
    wait: Wait,
    /// The entry whose piece is loaded.
    index: u32,
    /// Entries before it in the present pass are done with.
    done: u32,
    pass: u32,
    /// Progress, 2⁻⁶⁴ pulse, and slave at the beginning of the present pass.
    began: i128,
    origin: i128,
    /// No way back before this entry of this pass.
    floor: (u32, u32),
    /// Ratio with which a FIFO that begins with CONTINUE goes on, in every pass.
    carried: i128,
    more: Option<More>,
    /// What follows the piece in force, if it was made; and whether that may be worth a look.
    ahead: Option<Ahead>,
    open: bool,
    /// A piece lies further from the one before than any tick may go.
    far: bool,
    /// SwitchNow in the last segment: the ratio at which the next pass starts.
    given: Option<i128>,
    /// The slave was held by the entry done last.
    held: bool,
    /// Data ends at the count seen last.
    end: u32,
    /// FIFOs that a switch has emptied: 1 bit each, until the axis has seen them.
    emptied: u8,
}

/// What a tick has beside the run.
pub struct Context<'a, S, L> {
    setup: &'a mut Setup,
    source: &'a S,
    level: L,
    deeds: &'a mut Deeds,
    /// The tick in force, 2⁻³² ns.
    base: Fine,
}

impl<'a, S: Entries, L: Fn(Input, u8) -> bool> Context<'a, S, L> {
    /// Settings and FIFOs of the axis, its entries, the levels of inputs as sampled in the tick in force; what entries do
    /// goes to `deeds`.
    pub fn new(setup: &'a mut Setup, source: &'a S, level: L, deeds: &'a mut Deeds) -> Self {
        Context { setup, source, level, deeds, base: 0 }
    }
}

/// Where a search ends.
enum Seek {
    /// In a segment, or at rest before the floor.
    Here,
    /// At an entry that is no segment.
    Stop(u32),
    /// At the end of the motion.
    End(i128),
}

impl FollowRun {
    /// A motion from the position `origin` which starts in the tick computed next.
    #[inline(always)]
    pub fn begin(setup: &Setup, origin: Exact, fifo: u8) -> FollowRun {
        let both = setup.direction == Direction::Both;
        FollowRun {
            piece: Piece::rest(Ns(0), 0, origin.round()),
            both,
            down: if both { setup.fifo(fifo).tail.down } else { setup.direction == Direction::Down },
            furthest: i64::MIN,
            progress: 0,
            fifo,
            switching: false,
            now: None,
            wait: Wait::Start,
            index: 0,
            done: 0,
            pass: 0,
            began: 0,
            origin: origin.0,
            floor: (0, 0),
            carried: 0,
            more: None,
            ahead: None,
            open: false,
            far: false,
            given: None,
            held: false,
            end: 0,
            emptied: 0,
        }
    }

    /// Passes completed before the present one.
    pub fn passes(&self) -> u32 {
        self.pass
    }

    /// The FIFO that runs.
    pub fn fifo(&self) -> u8 {
        self.fifo
    }

    /// Whether the other one takes over at the end of the pass.
    pub fn is_switching(&self) -> bool {
        self.switching
    }

    /// FIFOs that a switch has emptied since this was last asked, a bit each.
    pub fn take_emptied(&mut self) -> u8 {
        core::mem::take(&mut self.emptied)
    }

    /// The other FIFO takes over when the present pass ends.
    pub fn switch(&mut self) {
        self.revise();
        self.switching = true;
    }

    /// The next segment or the other FIFO takes over at the tick computed next.
    pub fn switch_now(&mut self, method: Method) {
        self.revise();
        self.now = Some(method);
    }

    /// Data or settings have changed: what follows may be something else now.
    pub fn revise(&mut self) {
        (self.ahead, self.open) = (None, self.piece.span != 0);
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

    /// The position where the master is at `to` and came there straight and inside one piece, if that is all
    /// there is to do; else [`FollowRun::step`] has to.
    #[inline(always)]
    pub fn glide(&mut self, to: Pos) -> Option<(Pos, u64)> {
        let mut progress = self.directed(to);
        if !self.both {
            progress = progress.max(self.furthest);
        }
        let mut t = (progress as u64).wrapping_sub(self.piece.begin.0);
        if t >= self.piece.span {
            t = self.turn(progress)?;
        }
        if self.now.is_some() {
            return None;
        }
        (self.progress, self.furthest) = (progress, progress);
        Some(self.piece.at(t))
    }

    /// The piece in force does not hold `progress`: how far into the one made ahead it is, if that does.
    #[inline(never)]
    fn turn(&mut self, progress: i64) -> Option<u64> {
        let ahead = self.ahead.as_ref().filter(|_| self.piece.span != 0)?;
        let t = (progress as u64).wrapping_sub(ahead.piece.begin.0);
        if t >= ahead.piece.span {
            return None;
        }
        self.piece = ahead.piece;
        (self.index, self.pass, self.began, self.origin) = (ahead.index, ahead.pass, ahead.began, ahead.origin);
        (self.ahead, self.open, self.held) = (None, true, false);
        Some(t)
    }

    /// Makes the piece that follows the one in force upwards ahead of its tick, if no entry lies between that is no
    /// segment, so that many slaves can enter pieces in one tick; what is made is what would have been.
    #[inline(never)]
    pub fn prepare(&mut self, setup: &Setup, source: &impl Entries) {
        self.open = false;
        let end = self.piece.begin.0.wrapping_add(self.piece.span) as i64;
        let mut x = ((end as i128) << UNIT).wrapping_sub(self.began);
        let fifo = setup.fifo(self.fifo);
        let (mut index, mut pass, mut began, mut origin) = (self.index, self.pass, self.began, self.origin);
        let mut before = (index > 0).then(|| source.entry(self.fifo, index.wrapping_sub(1)));
        let mut entry = source.entry(self.fifo, index);
        if x >= entry.ends_master() {
            (before, index) = (Some(entry), index.wrapping_add(1));
            if index >= fifo.end {
                let goes_on = setup.passes == 0 || pass.wrapping_add(1) < setup.passes;
                if !goes_on || fifo.count != 0 || self.switching || self.given.is_some() {
                    return;
                }
                let (length, way) = entry.ends();
                (before, index, pass) = (None, 0, pass.wrapping_add(1));
                (began, origin) = (began.wrapping_add(length), origin.wrapping_add(way));
                x = x.wrapping_sub(length);
            }
            entry = source.entry(self.fifo, index);
        }
        if entry.kind().is_none() || x >= entry.ends_master() || self.end != fifo.end {
            return;
        }
        let piece = self.segment(pass, index, before, entry, setup, source).piece(x, began, origin);
        self.ahead = Some(Ahead { piece, index, pass, began, origin });
    }

    /// Whether the slave has no turning point between its place and that for a master at `to`.
    #[inline(never)]
    pub(crate) fn glides_straight(&self, to: Pos) -> bool {
        let falls = |progress: i64| {
            let t = (progress as u64).wrapping_sub(self.piece.begin.0);
            (t < self.piece.span).then(|| slope(&self.piece.motion, self.piece.at(t).1) < 0)
        };
        let before = falls(self.progress);
        before.is_some() && before == falls(self.directed(to))
    }

    /// The planned position, and the parameter in its piece, where it stands now.
    pub fn place(&self) -> (Pos, u64) {
        let t = (self.progress as u64).wrapping_sub(self.piece.begin.0);
        if t < self.piece.span { self.piece.at(t) } else { (self.piece.start, 0) }
    }

    /// The piece in force, over the progress in units of Pos.
    pub fn piece(&self) -> &Piece {
        &self.piece
    }

    /// Whether the slave moves with a master that stands at `to`: it does not wait, nor is the master behind the
    /// furthest point or before the start.
    #[inline(always)]
    pub fn is_moving(&self, to: Pos) -> bool {
        self.piece.span != 0 && self.directed(to) == self.progress
    }

    /// Whether progress is the master's position with its sign changed.
    pub fn is_down(&self) -> bool {
        self.down
    }

    /// The tick after `way.now()`. `named` is where a position of 0 pulses lies among the positions of the way, for
    /// PASS.
    pub fn step<S: Entries, L: Fn(Input, u8) -> bool>(
        &mut self,
        way: &Way<'_>,
        named: i64,
        context: &mut Context<'_, S, L>,
        mut track: Option<&mut Track>,
    ) -> State {
        let (from, to) = way.ends();
        let mut end = self.open(way.now(), from, to, context);
        for stretch in way.stretches() {
            end = end.or_else(|| self.go(stretch, context, track.as_deref_mut()));
        }
        end.or_else(|| self.close(way.now(), to, named, context)).unwrap_or(State::Running)
    }

    /// A tick begins with the master at `from`, and ends at `to`: data that was added counts, inputs are looked at.
    pub(super) fn open<S: Entries, L: Fn(Input, u8) -> bool>(
        &mut self,
        now: Ns,
        from: Pos,
        to: Spot,
        context: &mut Context<'_, S, L>,
    ) -> Option<State> {
        context.base = (now.0 as Fine) << 32;
        self.append(context);
        if let Wait::Input { input, index, high, until } = self.wait {
            if (context.level)(input, index) == high {
                self.resume(from, context);
            } else if until.is_some_and(|until| until <= context.base.wrapping_add(to.after as Fine)) {
                return Some(State::TimedOut { at: self.knot(self.done, context) });
            }
        }
        None
    }

    /// The master goes along a stretch; places of the slave's own go to `track`.
    #[inline(never)]
    pub(super) fn go<S: Entries, L: Fn(Input, u8) -> bool>(
        &mut self,
        stretch: Stretch<'_>,
        context: &mut Context<'_, S, L>,
        track: Option<&mut Track>,
    ) -> Option<State> {
        let (before, end) = (self.progress, self.advance(stretch, context));
        if let Some(track) = track {
            if self.progress != before {
                image(&self.piece, before, self.progress, stretch.from.after, stretch.to.after, track);
            }
            track.push(stretch.to.after, self.place().0);
        }
        end
    }

    /// The tick ends with the master at `to`: a motion starts, SwitchNow acts.
    pub(super) fn close<S: Entries, L: Fn(Input, u8) -> bool>(
        &mut self,
        now: Ns,
        to: Spot,
        named: i64,
        context: &mut Context<'_, S, L>,
    ) -> Option<State> {
        let still = Stretch::still(now, to);
        if self.wait == Wait::Start {
            match context.setup.event {
                Event::Start => {
                    self.start(to.pos);
                    if let Some(end) = self.settle(&still, context) {
                        return Some(end);
                    }
                }
                Event::Pass { up, pos } => {
                    self.wait = Wait::Pass { up, at: Pos(Pos::pulses(pos).0.wrapping_add(named)) };
                }
            }
        }
        if let Some(method) = self.now.take()
            && self.switch_here(method, to.pos, context)
        {
            return self.settle(&still, context);
        }
        None
    }

    /// The motion begins with the master at `pos`.
    fn start(&mut self, pos: Pos) {
        self.wait = Wait::No;
        self.progress = self.directed(pos);
        self.furthest = self.progress;
        self.began = (self.progress as i128) << UNIT;
    }

    /// Data that was added belongs to the present pass: earlier ones had another length.
    fn append<L>(&mut self, context: &mut Context<'_, impl Entries, L>) {
        let end = context.setup.fifo(self.fifo).end;
        if end != self.end {
            if self.end != 0 && self.floor.0 != self.pass {
                self.floor = (self.pass, 0);
            }
            self.end = end;
        }
    }

    /// The master goes along a stretch.
    fn advance<S: Entries, L: Fn(Input, u8) -> bool>(
        &mut self,
        mut stretch: Stretch<'_>,
        context: &mut Context<'_, S, L>,
    ) -> Option<State> {
        match self.wait {
            Wait::Pass { up, at } => {
                let (from, to) = (stretch.from.pos, stretch.to.pos);
                let crosses = if up { from < at && to >= at } else { from > at && to <= at };
                if !crosses {
                    return None;
                }
                self.start(at);
                stretch.from = Spot { after: stretch.when(at), pos: at };
            }
            Wait::Until(until) => {
                let after = until.saturating_sub(context.base);
                if after > stretch.to.after as Fine {
                    return None;
                }
                let after = after as u64;
                let pos = stretch.at(after);
                self.resume(pos, context);
                stretch.from = Spot { after, pos };
            }
            Wait::Input { .. } | Wait::Start => return None,
            Wait::No => {}
        }
        let progress = self.directed(stretch.to.pos);
        if self.both || progress > self.furthest {
            self.progress = progress;
            self.furthest = progress;
        }
        self.settle(&stretch, context)
    }

    /// Brings piece and entries up to the present progress, which the master reached along `stretch`.
    fn settle<S: Entries, L: Fn(Input, u8) -> bool>(
        &mut self,
        stretch: &Stretch<'_>,
        context: &mut Context<'_, S, L>,
    ) -> Option<State> {
        for _ in 0..STEPS {
            match self.seek(context) {
                Seek::Here => return self.far.then_some(State::TooFar),
                Seek::End(at) if self.is_far(at) => return Some(State::TooFar),
                Seek::End(at) => return Some(State::Ended { at: Exact(at) }),
                Seek::Stop(index) => {
                    if context.deeds.done >= ACTIONS {
                        // The next tick goes on here.
                        self.hold(index, context);
                        return None;
                    }
                    context.deeds.done = context.deeds.done.wrapping_add(1);
                    if self.act(index, stretch, context) {
                        return None;
                    }
                }
            }
        }
        None
    }

    /// Carries out the entry `index`, which is no segment; whether the slave is held by it.
    fn act<S: Entries, L: Fn(Input, u8) -> bool>(
        &mut self,
        index: u32,
        stretch: &Stretch<'_>,
        context: &mut Context<'_, S, L>,
    ) -> bool {
        let entry = context.source.entry(self.fifo, index);
        let (knot, _) = entry.ends();
        let reached = ceil(self.began.wrapping_add(knot));
        self.done = index.wrapping_add(1);
        self.floor = (self.pass, self.done);
        let when = || {
            let pos = Pos(if self.down { reached.wrapping_neg() } else { reached });
            context.base.wrapping_add(
                stretch.when(pos.clamp(stretch.from.pos.min(stretch.to.pos), stretch.from.pos.max(stretch.to.pos)))
                    as Fine,
            )
        };
        match entry.action() {
            Stop::Output { group, bit, high } => {
                let group = match group {
                    DoGroup::Enable => 0,
                    DoGroup::Clear => 1,
                    DoGroup::General => 2,
                };
                if let Some(place) = context.deeds.outputs.get_mut(context.deeds.done.wrapping_sub(1)) {
                    *place = Some((group, bit, high));
                }
                return false;
            }
            Stop::Delay { cycles } => {
                if cycles == 0 {
                    return false;
                }
                let until = when().wrapping_add(CYCLE.wrapping_mul(cycles as Fine));
                self.wait = Wait::Until(until);
            }
            Stop::Wait { input, index, high, timeout_ms } => {
                // The level in force when the entry is reached is that of the sample before.
                if (context.level)(input, index) == high {
                    return false;
                }
                let until = (timeout_ms != 0).then(|| when().wrapping_add(MS.wrapping_mul(timeout_ms as Fine)));
                self.wait = Wait::Input { input, index, high, until };
            }
            Stop::Switch(Method::Segment) => {
                // The next segment follows anyway. In the last one, the pass has ended.
                return false;
            }
            Stop::Switch(Method::Table) => {
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
        // A delay may end on this very stretch.
        if let Wait::Until(until) = self.wait {
            let after = until.saturating_sub(context.base);
            if after <= stretch.to.after as Fine {
                let pos = stretch.at(after as u64);
                self.resume(pos, context);
                let progress = self.directed(stretch.to.pos);
                if self.both || progress > self.furthest {
                    (self.progress, self.furthest) = (progress, progress);
                }
                return false;
            }
        }
        true
    }

    /// The slave's position at the beginning of an entry of this pass.
    fn knot<L>(&self, index: u32, context: &Context<'_, impl Entries, L>) -> Exact {
        let (_, end) = self.ends_before(index, context);
        Exact(self.origin.wrapping_add(end))
    }

    /// The slave rests at the beginning of an entry.
    fn hold<L>(&mut self, index: u32, context: &Context<'_, impl Entries, L>) {
        let at = self.knot(index, context);
        self.far |= self.is_far(at.0);
        self.piece = Piece::rest(Ns(0), 0, at.round());
        (self.ahead, self.open) = (None, false);
    }

    /// A delay or a wait is over with the master at `pos`: what follows begins there.
    fn resume<L>(&mut self, pos: Pos, context: &Context<'_, impl Entries, L>) {
        self.wait = Wait::No;
        self.progress = self.directed(pos);
        self.furthest = self.progress;
        let (knot, _) = self.ends_before(self.done, context);
        self.began = ((self.progress as i128) << UNIT).wrapping_sub(knot);
    }

    /// SwitchNow with the master at `pos`; whether the slave follows.
    fn switch_here<L>(&mut self, method: Method, pos: Pos, context: &mut Context<'_, impl Entries, L>) -> bool {
        let other = self.fifo ^ 1;
        if method == Method::Table && context.setup.is_empty(other) {
            return false;
        }
        if let Wait::Pass { .. } | Wait::Start = self.wait {
            if method == Method::Table {
                self.enter_other(0, self.origin, 0, true, context);
            }
            return false;
        }
        if self.wait != Wait::No {
            self.resume(pos, context);
        }
        let (place, tau) = self.place();
        let moves = (self.progress as u64).wrapping_sub(self.piece.begin.0) < self.piece.span;
        let ratio = if moves { ratio_at(&self.piece.motion, tau) } else { 0 };
        let began = (self.progress as i128) << UNIT;
        let origin = (place.0 as i128) << UNIT;
        if method == Method::Table {
            self.enter_other(began, origin, ratio, true, context);
            return true;
        }
        if moves {
            // The next entry begins here, as if the segment had ended.
            self.done = self.index.wrapping_add(1);
            // Those of one segment are two more at most.
            for _ in 0..2 {
                let more = self.done < context.setup.fifo(self.fifo).end
                    && context.source.entry(self.fifo, self.done).goes_on();
                self.done = self.done.wrapping_add(more as u32);
            }
        }
        let (knot, end) = self.ends_before(self.done, context);
        (self.began, self.origin) = (began.wrapping_sub(knot), origin.wrapping_sub(end));
        self.floor = (self.pass, self.done);
        let fifo = context.setup.fifo(self.fifo);
        if self.done < fifo.end {
            self.start_with(self.pass, self.done, ratio, context);
        } else {
            self.given = Some(ratio);
        }
        true
    }

    /// The first segment from entry `from` on in this pass starts at `ratio`.
    fn start_with<L>(&mut self, pass: u32, from: u32, ratio: i128, context: &Context<'_, impl Entries, L>) {
        let end = context.setup.fifo(self.fifo).end;
        let mut index = from;
        for _ in 0..super::STOPS {
            if index >= end || context.source.entry(self.fifo, index).kind().is_some() {
                break;
            }
            index = index.wrapping_add(1);
        }
        let entry = context.source.entry(self.fifo, index);
        let before = self.before(index, context);
        // What its chain gives it is part of that ratio.
        let segment = Segment::between(before, entry, |_| 0);
        let own = segment.start_ratio();
        self.more = Some(More { pass, from: index, odd: entry.odd(), ratio: ratio.wrapping_sub(own) });
    }

    /// The other FIFO takes over; what it follows ended at `ratio`. `at_once`: its first segment starts at it.
    fn enter_other<L>(
        &mut self,
        began: i128,
        origin: i128,
        ratio: i128,
        at_once: bool,
        context: &mut Context<'_, impl Entries, L>,
    ) {
        context.setup.clear(self.fifo);
        self.emptied |= 1 << self.fifo;
        self.fifo ^= 1;
        self.switching = false;
        (self.pass, self.done, self.floor) = (0, 0, (0, 0));
        (self.began, self.origin) = (began, origin);
        let fifo = context.setup.fifo(self.fifo);
        (self.end, self.carried) = (fifo.end, ratio);
        if self.both && fifo.tail.down != self.down {
            self.turn_round();
        }
        (self.more, self.given) = (None, None);
        if at_once {
            self.start_with(0, 0, self.carried, context);
        }
        self.piece.span = 0;
        (self.ahead, self.open) = (None, false);
    }

    /// The other FIFO's progress has the other sign.
    fn turn_round(&mut self) {
        self.down = !self.down;
        self.progress = self.progress.wrapping_neg();
        self.began = self.began.wrapping_neg();
        self.carried = self.carried.wrapping_neg();
    }

    fn before<L>(&self, index: u32, context: &Context<'_, impl Entries, L>) -> Option<Entry> {
        (index > 0).then(|| context.source.entry(self.fifo, index.wrapping_sub(1)))
    }

    /// Where the entry before `index` ends.
    fn ends_before<L>(&self, index: u32, context: &Context<'_, impl Entries, L>) -> (i128, i128) {
        self.before(index, context).map_or((0, 0), Entry::ends)
    }

    /// How much more than its chain knows a segment starts with.
    #[inline(always)]
    fn more_at(&self, pass: u32, index: u32, entry: Entry, setup: &Setup, source: &impl Entries) -> i128 {
        if self.more.is_none() && self.carried == 0 { 0 } else { self.more_of(pass, index, entry, setup, source) }
    }

    #[inline(never)]
    fn more_of(&self, pass: u32, index: u32, entry: Entry, setup: &Setup, source: &impl Entries) -> i128 {
        let continues = setup.fifo(self.fifo).tail.continues as u32;
        let (from, odd, ratio) = if let Some(more) = &self.more
            && more.pass == pass
            && index >= more.from
        {
            (more.from, more.odd, more.ratio)
        } else if continues != 0 && self.carried != 0 {
            (continues.wrapping_sub(1), false, self.carried)
        } else {
            return 0;
        };
        if !self.is_chained(from, index, entry, source) {
            0
        } else if entry.odd() == odd {
            ratio
        } else {
            ratio.wrapping_neg()
        }
    }

    /// Whether NORMAL segments lead from `from` to `index`, both included.
    fn is_chained(&self, from: u32, index: u32, entry: Entry, source: &impl Entries) -> bool {
        let (mut at, mut entry) = (index, entry);
        // A chain of 512 entries is looked through in steps of 31.
        for _ in 0..=super::ENTRIES / super::entry::FAR {
            let back = entry.back();
            at = at.wrapping_sub(back);
            if at <= from || back < super::entry::FAR {
                break;
            }
            entry = source.entry(self.fifo, at);
        }
        at < from || at == from && source.entry(self.fifo, from).is_normal()
    }

    /// The ratio at the end of the segment before entry `index`.
    fn end_ratio<L>(&mut self, index: u32, context: &Context<'_, impl Entries, L>) -> i128 {
        let fifo = context.setup.fifo(self.fifo);
        let mut at = index;
        for _ in 0..=super::STOPS {
            let Some(last) = at.checked_sub(1) else { return self.carried };
            at = last;
            let entry = context.source.entry(self.fifo, at);
            if entry.kind().is_none() {
                continue;
            }
            if index == fifo.end {
                let more = if entry.is_normal() {
                    self.more_at(self.pass, at, entry, context.setup, context.source)
                } else {
                    0
                };
                return fifo.tail.ratio.wrapping_sub(more);
            }
            let before = self.before(at, context);
            return self.segment(self.pass, at, before, entry, context.setup, context.source).end_ratio();
        }
        0
    }

    #[inline(always)]
    fn segment(
        &self,
        pass: u32,
        index: u32,
        before: Option<Entry>,
        entry: Entry,
        setup: &Setup,
        source: &impl Entries,
    ) -> Segment {
        let more = self.more_at(pass, index, entry, setup, source);
        Segment::between(before, entry, |length| if more == 0 { 0 } else { swing(more, length.unsigned_abs()) })
    }

    /// The piece of an entry of this pass that holds the progress `x` is in force.
    #[inline(never)]
    fn enter<L>(&mut self, index: u32, x: i128, context: &Context<'_, impl Entries, L>) {
        let entry = context.source.entry(self.fifo, index);
        let before = self.before(index, context);
        let segment = self.segment(self.pass, index, before, entry, context.setup, context.source);
        self.far |= self.is_far(segment.start(self.origin));
        self.piece = segment.piece(x, self.began, self.origin);
        (self.index, self.held, self.ahead, self.open) = (index, false, None, true);
    }

    /// Whether a slave position is 2³⁹ pulses or more from that of the piece in force.
    fn is_far(&self, pos: i128) -> bool {
        pos.wrapping_sub((self.piece.start.0 as i128) << UNIT).unsigned_abs() >> (39 + 64) != 0
    }

    /// Loads the next piece of the segment in force, or of the one behind it, if that is all there is to do: no entry
    /// that is no segment and no end of a pass lies between.
    #[inline(always)]
    fn go_on<L>(&mut self, context: &Context<'_, impl Entries, L>) -> bool {
        if self.piece.span == 0 {
            return false;
        }
        let x = ((self.progress as i128) << UNIT).wrapping_sub(self.began);
        let mut index = self.index;
        if x >= context.source.entry(self.fifo, index).ends_master() {
            index = index.wrapping_add(1);
            if index >= context.setup.fifo(self.fifo).end {
                return false;
            }
            let next = context.source.entry(self.fifo, index);
            if next.kind().is_none() || x >= next.ends_master() {
                return false;
            }
        } else if x < self.ends_before(index, context).0 {
            return false;
        }
        self.enter(index, x, context);
        true
    }

    /// Finds the segment of the present progress, through ends of passes.
    fn seek<L>(&mut self, context: &mut Context<'_, impl Entries, L>) -> Seek {
        if self.go_on(context) {
            return Seek::Here;
        }
        // Over an end of pass into the next, a switch, and once more; or back over any number of passes.
        for _ in 0..4 {
            let x = ((self.progress as i128) << UNIT).wrapping_sub(self.began);
            let fifo = context.setup.fifo(self.fifo);
            let (floor_pass, floor_index) = self.floor;
            let low = if self.pass == floor_pass { floor_index } else { 0 };
            if x < 0 && self.pass > floor_pass {
                self.back(x, context);
                continue;
            }
            if self.pass == floor_pass && x < self.ends_before(low, context).0 {
                // Before the floor the slave rests at it.
                self.hold(low, context);
                return Seek::Here;
            }
            let stop = fifo.stop_from(self.done.max(low));
            let limit = stop.unwrap_or(fifo.end);
            if x < self.ends_before(limit, context).0 {
                self.load(x, low, limit, context);
                return Seek::Here;
            }
            if let Some(stop) = stop {
                return Seek::Stop(stop);
            }
            if let Some(at) = self.end_pass(x, context) {
                return Seek::End(at);
            }
        }
        // More passes lie between than can be counted.
        self.far = true;
        Seek::Here
    }

    /// Loads the piece that holds the progress `x` of this pass; its segment is one of `low`..`limit`.
    fn load<L>(&mut self, x: i128, low: u32, limit: u32, context: &Context<'_, impl Entries, L>) {
        let ends = |index| context.source.entry(self.fifo, index).ends_master();
        let (mut low, mut high) = (low, limit.wrapping_sub(1));
        while low < high {
            let middle = low.wrapping_add(high) >> 1;
            if x < ends(middle) {
                high = middle;
            } else {
                low = middle.wrapping_add(1);
            }
        }
        self.enter(low, x, context);
    }

    /// The pass is over at the progress `x` ≥ its end; the exact end of the motion, if that is it.
    fn end_pass<L>(&mut self, x: i128, context: &mut Context<'_, impl Entries, L>) -> Option<i128> {
        let fifo = context.setup.fifo(self.fifo);
        let (length, way) = self.ends_before(fifo.end, context);
        if self.switching && !context.setup.is_empty(self.fifo ^ 1) {
            let given = self.given.take();
            let ratio = given.unwrap_or_else(|| self.end_ratio(fifo.end, context));
            let (began, origin) = (self.began.wrapping_add(length), self.origin.wrapping_add(way));
            self.enter_other(began, origin, ratio, given.is_some(), context);
            return None;
        }
        let (stops, passes) = (fifo.count, context.setup.passes);
        if let Some(ratio) = self.given.take() {
            self.start_with(self.pass.wrapping_add(1), 0, ratio, context);
        }
        let left = if passes == 0 { u32::MAX } else { passes.saturating_sub(self.pass).max(1) };
        let many = if stops == 0 { passes_in(x, length).clamp(1, left) } else { 1 };
        let ended = passes != 0 && many == left;
        self.pass = self.pass.wrapping_add(many);
        self.began = self.began.wrapping_add(length.wrapping_mul(many as i128));
        self.origin = self.origin.wrapping_add(passes_of(way, many));
        (self.done, self.index) = (0, 0);
        ended.then_some(self.origin)
    }

    /// Back into an earlier pass; `x` < 0.
    fn back<L>(&mut self, x: i128, context: &Context<'_, impl Entries, L>) {
        let fifo = context.setup.fifo(self.fifo);
        let (length, way) = self.ends_before(fifo.end, context);
        let passes = self.pass.wrapping_sub(self.floor.0);
        let many = passes_in(x.wrapping_neg().wrapping_sub(1), length).saturating_add(1).min(passes);
        self.pass = self.pass.wrapping_sub(many);
        self.began = self.began.wrapping_sub(length.wrapping_mul(many as i128));
        self.origin = self.origin.wrapping_sub(passes_of(way, many));
        (self.done, self.index) = (fifo.end, fifo.end.wrapping_sub(1));
    }
}

/// The slave's way in so many passes; held at 2⁴⁶ pulses, which is too far anyway.
fn passes_of(way: i128, many: u32) -> i128 {
    const HELD: i128 = 1 << (46 + 64);
    if ((way >> 40).wrapping_mul(many as i128)).unsigned_abs() >> (46 + 64 - 40) == 0 {
        way.wrapping_mul(many as i128)
    } else if way < 0 {
        -HELD
    } else {
        HELD
    }
}

/// Whole passes of this length in `x` ≥ 0, at most 2³² − 2.
fn passes_in(x: i128, length: i128) -> u32 {
    const MOST: u64 = u32::MAX as u64 - 1;
    let (x, length) = (x.max(0) as u128, length.max(1) as u128);
    if x >> 32 >= length {
        return MOST as u32;
    }
    // length·2^-s has 64 bits with the top one set, and the quotient no more than 32.
    let zeros = length.leading_zeros();
    let d = (length << zeros >> 64) as u64;
    let y = if zeros >= 64 { x << (zeros - 64) } else { x >> (64 - zeros) };
    let y = (y >> 32) as u64;
    // Cut off thrice: a few short, or one too many for the cut of the length.
    let many = ((y as u128).wrapping_add(umulhi(y, recip64_below(d)) as u128) >> 32) as u64;
    let mut many = many.saturating_sub(1);
    for _ in 0..6 {
        if length.wrapping_mul(many as u128 + 1) > x {
            break;
        }
        many += 1;
    }
    many.min(MOST) as u32
}
