//! A run in gear: the piece of a progress, and a new ratio.
//!
//! In: the progress, in the run; its [`Gear`](super::super::gear). Out: the piece that holds the
//! progress. Owns: nothing; `began` and `origin` of the run are the positions from which its gear
//! counts. Cannot fail: a position too far away is marked. Work: a product for any displacement.
use super::seek::{passes_in, passes_of};
use super::{FollowRun, NextPiece, Wait};
use crate::segment::follow::curve::{EXACT_TO_POS_BITS, ratio_at};
use crate::segment::follow::gear::{Gear, GearRatio};

impl FollowRun {
    /// Another ratio from here on.
    pub(super) fn gear_to(&mut self, ratio: GearRatio) {
        let Some(gear) = self.gear().copied() else { return };
        if self.wait != Wait::No {
            self.next = NextPiece::Gear(Gear::begin(ratio, self.down, 0));
            return;
        }
        let began = (self.progress as i128) << EXACT_TO_POS_BITS;
        let (position, tau) = self.position();
        let (before, origin) = match gear.engaged(began.wrapping_sub(self.began)) {
            Some((before, displacement)) => (before, self.origin.wrapping_add(displacement)),
            None => (ratio_at(&self.piece.motion, tau), (position.0 as i128) << EXACT_TO_POS_BITS),
        };
        (self.began, self.origin) = (began, origin);
        self.next = NextPiece::Gear(Gear::begin(ratio, self.down, before));
    }

    /// Loads the piece that holds the progress. `began` is then at or before it, except on a slope.
    #[inline(never)]
    pub(super) fn seek_geared(&mut self, mut gear: Gear) {
        let x = |run: &Self| ((run.progress as i128) << EXACT_TO_POS_BITS).wrapping_sub(run.began);
        let piece = match gear.on_slope(x(self), self.began, self.origin) {
            Some(Ok(piece)) => piece,
            over => {
                if let Some(Err((master, slave))) = over {
                    (self.began, self.origin) = (self.began.wrapping_add(master), self.origin.wrapping_add(slave));
                }
                let (length, displacement) = gear.lengths();
                let x = x(self);
                let (many, back) = if x < 0 {
                    (passes_in(x.wrapping_neg().wrapping_sub(1), length).wrapping_add(1), true)
                } else {
                    (passes_in(x, length), false)
                };
                let turned = |by: i128| if back { by.wrapping_neg() } else { by };
                self.began = self.began.wrapping_add(turned(length.wrapping_mul(many as i128)));
                self.origin = self.origin.wrapping_add(turned(passes_of(displacement, many)));
                gear.piece(self.began, self.origin)
            }
        };
        self.far |= self.is_far((piece.start.0 as i128) << EXACT_TO_POS_BITS);
        (self.piece, self.next) = (piece, NextPiece::Gear(gear));
    }
}
