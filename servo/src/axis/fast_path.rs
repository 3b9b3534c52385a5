//! The fast path of an axis: in nearly every tick it goes on in the piece in force, or enters the
//! prepared one.
//!
//! In: the tick computed, axes. Out: their positions there, in the view and in the machine. Owns
//! nothing. Cannot fail: an axis that needs more work is left as it is, and named.
use super::{AxisState, InputScan};
use crate::segment::piece::{Motion, Piece};
use crate::units::{Ns, Pos};
use crate::view::AxisView;

/// The result of [`AxisState::step_fast`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FastStep {
    /// The axis and its view are at the next tick.
    Shown,
    /// The axis is; its view has to catch up in more than was compared.
    Stale,
    /// More work is needed: nothing has happened.
    No,
    /// The same, but [`AxisState::step_general`] may do it.
    Far,
    /// A limit may be in the way; and this is not a tick to make a piece ahead in.
    Barred,
}

impl AxisState {
    /// Takes it to the next tick, if it only goes on there. `next` is the low word of the instant.
    /// `left` counts the pieces that may still be made ahead in this tick.
    #[inline(always)]
    pub(crate) fn step_fast(&mut self, next: u32, left: u32, published: &mut AxisView) -> FastStep {
        let fast_step = match self.scan {
            InputScan::Steady => self.go_on(next, left, published),
            // Nothing else of its view changes without being marked so.
            InputScan::Carried if published.state_version == self.published.state_version => FastStep::Shown,
            InputScan::AtRest if published.version == self.published.version => return FastStep::Shown,
            // Each of the three buffers catches up when its turn comes.
            InputScan::AtRest => FastStep::Stale,
            _ => FastStep::No,
        };
        if fast_step == FastStep::Shown {
            published.publish_position(&self.published);
        }
        fast_step
    }

    /// Its position in the piece in force, or in the prepared one, if that is a fast-path piece;
    /// and what the view has of its motion.
    ///
    /// A function of its own, so that only the axis takes up registers.
    #[inline(never)]
    fn go_on(&mut self, next: u32, left: u32, published: &mut AxisView) -> FastStep {
        if self.profile.is_open() && left != 0 {
            return FastStep::No;
        }
        let AxisState { profile, published: now, .. } = self;
        let Some((piece, t, reports_pass)) = profile.fast(next, |piece| now.enter(&piece.motion)) else {
            return FastStep::Far;
        };
        let pos = piece.pos_fast(t);
        if reports_pass {
            self.publish_pass();
        }
        if self.is_barred(pos) {
            return FastStep::Barred;
        }
        self.published.go_to(pos, t);
        if published.follow_piece(&self.published, t) { FastStep::Shown } else { FastStep::Stale }
    }

    /// The same for pieces that are no fast-path pieces.
    #[inline(never)]
    pub(crate) fn step_general(&mut self, next: Ns, published: &mut AxisView) -> FastStep {
        let holds = |piece: &Piece| piece.elapsed(next) < piece.span;
        if !holds(self.profile.piece()) {
            if !self.profile.ahead().is_some_and(holds) {
                return FastStep::No;
            }
            self.profile.enter();
            self.publish_entered();
        }
        let piece = self.profile.piece();
        let (pos, Motion { tau, t, .. }) = piece.sample(piece.elapsed(next));
        if self.is_barred(pos) {
            return FastStep::Barred;
        }
        let now = &mut self.published;
        (now.version, now.pos) = (now.version.wrapping_add(1), pos);
        (now.motion.tau, now.motion.t) = (tau, t);
        if published.piece_version != now.piece_version {
            if published.state_version != now.state_version {
                return FastStep::Stale;
            }
            published.follow_turn(now);
        }
        (published.motion.tau, published.motion.t) = (tau, t);
        published.publish_position(now);
        FastStep::Shown
    }

    /// The prepared piece has come into force.
    #[inline(never)]
    fn publish_entered(&mut self) {
        self.published.enter(&self.profile.piece().motion);
        if self.profile.reports_pass {
            self.publish_pass();
        }
    }

    /// The same for what is published of the pass.
    #[inline(never)]
    fn publish_pass(&mut self) {
        self.published.progress_version = self.published.progress_version.wrapping_add(1);
        self.publish_pass_of(true);
    }

    /// Whether a limit may lie before a position.
    #[inline(always)]
    fn is_barred(&self, pos: Pos) -> bool {
        !self.bounds.is_well_inside(pos)
    }
}
