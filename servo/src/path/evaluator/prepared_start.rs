//! A start that is prepared while the path is at standstill.
//!
//! In: the FIFO that will probably be started, a call a tick. Out: geometry, speeds and first piece
//! of the motion that this start begins or continues, as if it began at 0. Owns nothing beyond the
//! [`Path`]. Cannot fail: a change of what would follow discards it, and a start with another FIFO
//! makes its own.
use super::{FifoEnds, Path, Preparation, end_of};
use crate::math::float::Float;
use crate::path::store::PathEntries;
use crate::units::{Exact, FineNs, Ns};

impl Path {
    /// Makes a part of it, a few hundred instructions. Returns whether there may be more to make.
    #[inline(never)]
    pub fn prepare_start(&mut self, fifo: u8, feed: FifoEnds, source: &impl PathEntries) -> bool {
        if self.prepared != Some(fifo) {
            self.discard_prepared();
            if self.refuses_start(fifo, feed) {
                return false;
            }
            self.prepared = Some(fifo);
        }
        if self.motions.next().open_end.is_some_and(|sampled| sampled != end_of(feed, fifo)) {
            // Something may follow it now.
            (self.pieces.follows, self.motions.next_mut().open_end) = (None, None);
            self.unplan();
        }
        let cursor = self.cursor_of(fifo);
        let (inside, next) = (cursor.inside, cursor.next);
        let distance = if inside { cursor.distance } else { Exact(0) };
        match self.motions.next().state {
            Preparation::Nothing => {
                let (counter, from) =
                    if inside { (next.wrapping_sub(1), cursor.from) } else { (next, self.rest_position) };
                self.begin_ahead(fifo, counter, &from, feed, source);
                self.motions.next().state != Preparation::Nothing
            }
            Preparation::Ready => {
                if let (None, Some(phase)) = (self.pieces.follows, self.motions.next().plan.phase(0)) {
                    self.pieces.pair.next_mut().make(phase, 0, distance);
                    self.pieces.follows = Some(0);
                }
                false
            }
            Preparation::Begun | Preparation::Shaped | Preparation::Sketched => {
                self.make_ahead(fifo, Float::ZERO, distance, feed, source);
                true
            }
        }
    }

    /// The motion with which a start at standstill would begin has changed.
    pub(crate) fn discard_prepared(&mut self) {
        if !self.runs() {
            (self.prepared, self.pieces.follows) = (None, None);
            self.motions.next_mut().state = Preparation::Nothing;
        }
    }

    /// A start at `next` with this FIFO begins with what was prepared for it, if anything was.
    pub(super) fn take_prepared_start(&mut self, next: Ns, fifo: u8) {
        if self.prepared != Some(fifo) {
            self.discard_prepared();
        }
        self.prepared = None;
        if self.pieces.follows == Some(0) {
            // It begins on a whole ns, as at 0, or with a wait, after which the piece is another
            // one.
            self.pieces.pair.next_mut().piece.begin = next;
            self.pieces.follows = Some((next.0 as FineNs) << 32);
        }
    }
}
