//! The profile of an axis: a sequence of pieces, and the position in it.
//!
//! In: instants. Out: the piece in force, and the one before or after it. Owns: two pieces and the
//! [`Generator`] that makes them. The generator only makes the next piece when one is over; it does
//! nothing while a piece lasts. Fails: never; a motion ends with a [`GeneratorState`].
use super::follow::Follower;
use super::generator_state::GeneratorState;
use super::piece::Piece;
use super::pt::{AllowedData, PtRun, Segments};
use super::pvt::{PvtRun, PvtTables};
use super::ramp::RampRun;
use crate::units::{Ns, Pos};

/// What pieces are made from: segments of a FIFO, points of tables.
pub trait MotionData: Segments + PvtTables {}
impl<S: Segments + PvtTables> MotionData for S {}

/// What makes the pieces of a motion. There is no heap to box the larger kind on.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Clone, Copy)]
pub enum Generator {
    /// Positions and times.
    Pt(PtRun),
    /// A table of positions, velocities and times.
    Pvt(PvtRun),
    /// Jog, Trap or Stop.
    Ramp(RampRun),
    /// Another axis: its displacement takes the place of time. The pieces are the follower's own,
    /// and the tick steps it itself.
    Follow(Follower),
}

impl Generator {
    /// Makes the piece that holds `now`, which is not before the end of the last one made.
    #[inline]
    fn advance(&mut self, now: Ns, feed: AllowedData, source: &impl MotionData, piece: &mut Piece) -> GeneratorState {
        match self {
            Generator::Pt(run) => run.advance(now, feed, source, piece),
            Generator::Pvt(run) => run.advance(now, feed.passes, source, piece),
            Generator::Ramp(run) => run.advance(now, piece),
            Generator::Follow(_) => {
                *piece = Piece::standstill(now, u64::MAX, piece.start);
                GeneratorState::Running
            }
        }
    }

    /// Whether each piece that is entered frees segments.
    #[inline(always)]
    fn is_stream(&self) -> bool {
        if let Generator::Pt(run) = self { run.is_stream() } else { false }
    }

    /// Whether the last piece made begins a pass: later data or commands can undo it.
    #[inline]
    fn is_new_pass(&self) -> bool {
        match self {
            Generator::Pt(run) => run.is_new_pass(),
            Generator::Pvt(run) => run.is_new_pass(),
            Generator::Ramp(_) | Generator::Follow(_) => false,
        }
    }

    /// A ramp, begun in place: it is too large to be moved about.
    #[inline]
    pub(crate) fn begin_ramp(&mut self, begin: impl FnOnce(&mut RampRun)) {
        if !matches!(self, Generator::Ramp(_)) {
            *self = Generator::Ramp(RampRun::IDLE);
        }
        if let Generator::Ramp(run) = self {
            begin(run);
        }
    }

    /// The motion was prepared for time 0, and begins at `now`.
    #[inline]
    fn shift(&mut self, now: Ns) {
        match self {
            Generator::Pt(run) => run.shift(now),
            Generator::Pvt(run) => run.shift(now),
            Generator::Ramp(run) => run.shift(now),
            Generator::Follow(_) => {}
        }
    }

    /// As if the last piece had not been made.
    #[inline]
    fn retract(&mut self) {
        match self {
            Generator::Pt(run) => run.retract(),
            Generator::Pvt(run) => run.retract(),
            // Only a new motion changes what a ramp will do, and its end changes nothing.
            Generator::Ramp(_) | Generator::Follow(_) => {}
        }
    }
}

/// The piece that is not in force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Other {
    /// The one that was in force before; what follows is not known.
    Before,
    /// As before, and nothing is to be prepared until data or commands change.
    BeforeLast,
    /// As before, and a ramp begins. Its first piece is made when it is needed: the piece before
    /// may have ended earlier, between two ticks.
    Begins,
    /// The one that follows.
    Ahead,
    /// At standstill, the first piece of a motion that has not begun: made as if it began at 0.
    Ready,
}

crate::state! {
    /// A motion, and the position in it.
    #[derive(Debug, Clone, Copy)]
    #[repr(C)]
    pub struct Profile {
        pieces: [Piece; 2] = [Piece::standstill(Ns(0), u64::MAX, Pos(0)); 2],
        /// Whether the second of them is in force.
        second: bool = false,
        other: Other = Other::BeforeLast,
        /// The piece made last, or one passed since the turn before, begins a pass or belongs to a
        /// stream: more is published than the piece.
        pub(crate) reports_pass: bool = false,
        generator: Generator = Generator::Ramp(RampRun::IDLE),
    }
    /// At standstill at 0 since power-on.
    pub const STANDSTILL;
}

impl Profile {
    /// The piece in force since the last turn.
    #[inline(always)]
    pub fn piece(&self) -> &Piece {
        &self.pieces[self.second as usize]
    }

    #[inline(always)]
    fn piece_mut(&mut self) -> &mut Piece {
        &mut self.pieces[self.second as usize]
    }

    #[inline(always)]
    fn other(&self) -> &Piece {
        &self.pieces[!self.second as usize]
    }

    /// After the step of a tick: the piece that was in force until `piece().begin`, if that is
    /// after `now`, the tick in force. So in (`now`, next] the axis is in this piece, then in
    /// [`Profile::piece`]; of more than two, those between are not kept. It is kept until the next
    /// tick.
    #[inline]
    pub fn before(&self, now: Ns) -> Option<&Piece> {
        (self.other != Other::Ahead && self.piece().begin > now).then(|| self.other())
    }

    /// What makes the pieces.
    #[inline(always)]
    pub fn generator(&self) -> &Generator {
        &self.generator
    }

    /// The slave, if it follows.
    #[inline(always)]
    pub(crate) fn follower_mut(&mut self) -> Option<&mut Follower> {
        if let Generator::Follow(follower) = &mut self.generator { Some(follower) } else { None }
    }

    /// Whether a piece has been made that is not in force yet.
    #[inline(always)]
    pub fn is_ahead(&self) -> bool {
        self.other == Other::Ahead
    }

    /// Whether [`Profile::prepare`] may have something to do.
    #[inline(always)]
    pub fn is_open(&self) -> bool {
        self.other == Other::Before
    }

    /// Another motion takes over at `now`.
    #[inline]
    pub fn begin(&mut self, now: Ns, generator: Generator) {
        self.cut(now);
        self.generator = generator;
    }

    /// Before another motion takes over at `now`: a piece made ahead that has begun by then is in
    /// force, so that slaves see the motion along it.
    #[inline]
    pub(crate) fn enter_reached(&mut self, now: Ns) {
        if self.ahead().is_some_and(|ahead| ahead.begin < now) {
            self.enter();
        }
    }

    /// A piece that begins after `now` and is over already was never in force at a tick: until the
    /// next piece begins, the axis stands at `pos`.
    #[inline]
    pub(crate) fn hold_until_next(&mut self, now: Ns, pos: Pos) {
        let piece = self.piece_mut();
        if piece.begin > now {
            *piece = Piece::standstill(now, u64::MAX, pos);
        }
    }

    /// A ramp takes over at `now`.
    #[inline]
    pub fn begin_ramp(&mut self, now: Ns, begin: impl FnOnce(&mut RampRun)) {
        self.cut(now);
        self.other = Other::Begins;
        self.generator.begin_ramp(begin);
    }

    /// At standstill, but not in the tick in which it came to standstill: makes the first piece of
    /// a motion ahead of its start. `begin` begins that motion at 0.
    #[inline]
    pub(crate) fn prepare_start(
        &mut self,
        feed: AllowedData,
        source: &impl MotionData,
        begin: impl FnOnce(&mut Generator),
    ) {
        begin(&mut self.generator);
        let piece = &mut self.pieces[!self.second as usize];
        let state = self.generator.advance(Ns(0), feed, source, piece);
        self.other = if state == GeneratorState::Running && piece.span != 0 { Other::Ready } else { Other::BeforeLast };
    }

    /// Something has changed that the prepared motion depends on.
    #[inline(always)]
    pub(crate) fn discard_prepared(&mut self) {
        if self.other == Other::Ready {
            self.other = Other::BeforeLast;
        }
    }

    /// The prepared motion, if any.
    #[inline(always)]
    pub(crate) fn prepared(&self) -> Option<&Generator> {
        (self.other == Other::Ready).then_some(&self.generator)
    }

    /// The prepared motion begins at `now`; false if there is none.
    #[inline]
    pub(crate) fn begin_prepared(&mut self, now: Ns) -> bool {
        if self.other != Other::Ready {
            return false;
        }
        self.cut(now);
        if let Generator::Follow(_) = self.generator {
            // Its pieces are its own.
            return true;
        }
        self.generator.shift(now);
        let piece = &mut self.pieces[!self.second as usize];
        piece.begin = Ns(piece.begin.0.wrapping_add(now.0));
        (self.other, self.reports_pass) = (Other::Ahead, self.generator.is_stream());
        true
    }

    /// The motion is over at `now`: it is at standstill at `pos`.
    pub fn stand_still(&mut self, now: Ns, pos: Pos) {
        self.cut(now);
        (self.second, self.other) = (!self.second, Other::BeforeLast);
        *self.piece_mut() = Piece::standstill(now, u64::MAX, pos);
    }

    /// At standstill, and the piece before was not run to its end: the path to the present position
    /// is not along it.
    pub(crate) fn forget(&mut self) {
        self.pieces[!self.second as usize] = Piece::standstill(Ns(0), 0, self.piece().start);
    }

    /// At standstill, the position gets the name `pos`.
    pub fn rename(&mut self, pos: Pos) {
        self.piece_mut().start = pos;
        self.discard_prepared();
    }

    /// The piece in force ends at `now`, and the one that was to follow is dropped.
    #[inline]
    fn cut(&mut self, now: Ns) {
        self.other = Other::Before;
        let piece = self.piece_mut();
        piece.span = piece.elapsed(now).min(piece.span);
    }

    /// PVT: `table` takes over at the end of the pass; false if this is not PVT.
    pub fn select(&mut self, table: u8) -> bool {
        self.invalidate_prepared();
        if let Generator::Pvt(run) = &mut self.generator {
            run.select(table);
            return true;
        }
        false
    }

    /// Data or commands have changed: something else may follow the present pass now.
    #[inline]
    pub fn invalidate_prepared(&mut self) {
        if self.other == Other::Begins {
            return;
        }
        if self.other != Other::Ahead {
            self.other = Other::Before;
        } else if self.generator.is_new_pass() {
            self.generator.retract();
            self.other = Other::Before;
        }
    }

    /// Makes the piece that holds `now`, if it is not made yet; the one in force is over by then.
    #[inline]
    fn reach(&mut self, now: Ns, feed: AllowedData, source: &impl MotionData) -> GeneratorState {
        let piece = &mut self.pieces[!self.second as usize];
        if self.other == Other::Ahead && piece.elapsed(now) < piece.span {
            return GeneratorState::Running;
        }
        // A piece made ahead that is over by now is passed, with the pass that it began.
        let passed = self.other == Other::Ahead && self.reports_pass;
        let state = self.generator.advance(now, feed, source, piece);
        self.reports_pass = passed || self.generator.is_new_pass() || self.generator.is_stream();
        if state == GeneratorState::Running {
            self.other = Other::Ahead;
        }
        state
    }

    /// The piece that will be in force at `now`, or how the motion will have ended; nothing
    /// changes.
    pub fn look(&mut self, now: Ns, feed: AllowedData, source: &impl MotionData) -> Result<&Piece, GeneratorState> {
        if self.piece().elapsed(now) < self.piece().span {
            return Ok(self.piece());
        }
        if self.other == Other::Begins {
            self.enter_first(now, feed, source);
        }
        match self.reach(now, feed, source) {
            GeneratorState::Running => Ok(self.other()),
            end => {
                self.generator.retract();
                Err(end)
            }
        }
    }

    /// The piece in force is over at `now`: on to the one that was made ahead, if it holds `now`.
    /// This is the usual case, and it only changes which of two pieces is in force.
    #[inline(always)]
    pub fn accept(&mut self, now: Ns) -> bool {
        let holds = self.ahead().is_some_and(|next| next.elapsed(now) < next.span);
        if holds {
            self.enter();
        }
        holds
    }

    /// The piece made ahead.
    #[inline(always)]
    pub(crate) fn ahead(&self) -> Option<&Piece> {
        (self.other == Other::Ahead).then(|| self.other())
    }

    /// The fast-path piece that holds the instant of which `next` is the low word, and the time in
    /// it. If the one made ahead comes into force for that, `enter` gets it, and whether more is to
    /// be published of it.
    #[inline(always)]
    pub(crate) fn fast(&mut self, next: u32, enter: impl FnOnce(&Piece)) -> Option<(&Piece, u32, bool)> {
        let piece = &self.pieces[self.second as usize];
        if let Some(t) = piece.fast_time_of(next) {
            return Some((piece, t, false));
        }
        // A piece off the fast path may last longer than a time of 32 bits can hold.
        if !piece.is_fast() || self.other != Other::Ahead {
            return None;
        }
        let ahead = &self.pieces[!self.second as usize];
        let t = ahead.fast_time_of(next)?;
        (self.second, self.other) = (!self.second, Other::Before);
        enter(ahead);
        Some((ahead, t, self.reports_pass))
    }

    /// The piece made ahead comes into force.
    #[inline(always)]
    pub(crate) fn enter(&mut self) {
        (self.second, self.other) = (!self.second, Other::Before);
    }

    /// The piece in force is over at `now`: on to the one that holds `now`, or to the end.
    #[inline]
    pub fn turn(&mut self, now: Ns, feed: AllowedData, source: &impl MotionData) -> GeneratorState {
        let begins = self.other == Other::Begins;
        if begins {
            self.enter_first(now, feed, source);
        }
        let state = self.reach(now, feed, source);
        if state == GeneratorState::Running {
            (self.second, self.other) = (!self.second, Other::Before);
        } else {
            // A ramp that is over within its first tick took the axis along its last piece, for
            // the slaves to see.
            self.second ^= begins && self.other().span != 0;
            self.other = Other::BeforeLast;
        }
        state
    }

    /// Makes the first piece of a ramp. If it is over by `now`, it is in force.
    #[inline(never)]
    fn enter_first(&mut self, now: Ns, feed: AllowedData, source: &impl MotionData) {
        let Generator::Ramp(run) = &self.generator else { return };
        let begin = run.begins();
        let first = &mut self.pieces[!self.second as usize];
        first.span = 0;
        if self.generator.advance(begin, feed, source, first) != GeneratorState::Running {
            return;
        }
        self.other = Other::Ahead;
        if first.elapsed(now) >= first.span {
            self.enter();
            self.pieces[!self.second as usize].span = 0;
        }
    }

    /// Makes the piece after the one in force ahead of its tick, so that many axes can enter pieces
    /// in one tick. The piece is the same as it would be later. Returns whether there was something
    /// to do.
    #[inline]
    pub fn prepare(&mut self, feed: AllowedData, source: &impl MotionData) -> bool {
        let piece = self.piece();
        let end = Ns(piece.begin.0.wrapping_add(piece.span));
        if self.other != Other::Before || piece.span == 0 {
            return false;
        }
        if self.reach(end, feed, source) != GeneratorState::Running {
            self.generator.retract();
            self.other = Other::BeforeLast;
        }
        true
    }
}
