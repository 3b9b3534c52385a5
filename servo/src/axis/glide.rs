//! What nearly every tick of an axis is: it goes on in the piece in force, or enters the one made ahead.
//!
//! In: the tick computed, axes. Out: their places there, in the view and in the machine. Owns nothing. Cannot fail: an
//! axis of which more is to be done is left as it is, and named.
use super::{AxisState, Calm};
use crate::piece::{Motion, Piece};
use crate::units::{Ns, Pos};
use crate::view::AxisView;

/// What came of [`AxisState::glide_on`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Glide {
    /// The axis and its view are at the next tick.
    Shown,
    /// The axis is; of the view more has to catch up than it looked at.
    Stale,
    /// There is more to do than that: nothing has happened.
    No,
    /// The same, but that [`AxisState::glide_far`] may do it.
    Far,
    /// Something may stand in the way; and this is not a tick to make a piece ahead in.
    Barred,
}

impl AxisState {
    /// Takes it to the next tick, if it only goes on there. `next` is the low word of the instant; `left` counts the pieces that may
    /// still be made ahead in this tick.
    #[inline(always)]
    pub(crate) fn glide_on(&mut self, next: u32, left: u32, shown: &mut AxisView) -> Glide {
        let glide = match self.calm {
            Calm::Steady => self.go_on(next, left, shown),
            // Its view changes in nothing else without being told so.
            Calm::Carried if shown.changes == self.shown.changes => Glide::Shown,
            Calm::Settled if shown.moves == self.shown.moves => return Glide::Shown,
            // Each of the three buffers catches up when its turn comes.
            Calm::Settled => Glide::Stale,
            _ => Glide::No,
        };
        if glide == Glide::Shown {
            shown.follow_place(&self.shown);
        }
        glide
    }

    /// Its place in the piece in force, or in the one made ahead, if it is near; what the view has of its motion.
    ///
    /// A function of its own, so that nothing but the axis takes up registers.
    #[inline(never)]
    fn go_on(&mut self, next: u32, left: u32, shown: &mut AxisView) -> Glide {
        if self.profile.is_open() && left != 0 {
            return Glide::No;
        }
        let AxisState { profile, shown: now, .. } = self;
        let Some((piece, t, tells)) = profile.near(next, |piece| now.enter(&piece.motion)) else { return Glide::Far };
        let pos = piece.pos_near(t);
        if tells {
            self.tell_pass();
        }
        if self.is_barred(pos) {
            return Glide::Barred;
        }
        self.shown.go_to(pos, t);
        if shown.follow_piece(&self.shown, t) { Glide::Shown } else { Glide::Stale }
    }

    /// The same in pieces that are not near.
    #[inline(never)]
    pub(crate) fn glide_far(&mut self, next: Ns, shown: &mut AxisView) -> Glide {
        let holds = |piece: &Piece| piece.elapsed(next) < piece.span;
        if !holds(self.profile.piece()) {
            if !self.profile.ahead().is_some_and(holds) {
                return Glide::No;
            }
            self.profile.enter();
            self.tell_entered();
        }
        let piece = self.profile.piece();
        let (pos, Motion { tau, t, .. }) = piece.place(piece.elapsed(next));
        if self.is_barred(pos) {
            return Glide::Barred;
        }
        let now = &mut self.shown;
        (now.moves, now.pos) = (now.moves.wrapping_add(1), pos);
        (now.motion.tau, now.motion.t) = (tau, t);
        if shown.turns != now.turns {
            if shown.changes != now.changes {
                return Glide::Stale;
            }
            shown.follow_turn(now);
        }
        (shown.motion.tau, shown.motion.t) = (tau, t);
        shown.follow_place(now);
        Glide::Shown
    }

    /// The piece made ahead has come into force.
    #[inline(never)]
    fn tell_entered(&mut self) {
        self.shown.enter(&self.profile.piece().motion);
        if self.profile.tells() {
            self.tell_pass();
        }
    }

    /// The same of what it tells of the pass.
    #[inline(never)]
    fn tell_pass(&mut self) {
        self.shown.counts = self.shown.counts.wrapping_add(1);
        self.show_pass(true);
    }

    /// Whether something may stand before a place.
    #[inline(always)]
    fn is_barred(&self, pos: Pos) -> bool {
        let (from, count) = self.inside;
        ((pos.0 >> 32) as i32).wrapping_sub(from) as u32 >= count
    }
}
