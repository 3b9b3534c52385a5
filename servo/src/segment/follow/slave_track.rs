//! The positions of a slave within a tick, for slaves of its own.
//!
//! In: the slave's pieces and its progress before and after a section of its master's path. Out:
//! positions of a [`PositionTrack`]. It cannot fail.
use super::curve::slope;
use super::master_path::{PositionTrack, Section, bisect};
use crate::math::wide::{Recip, umulhi};
use crate::segment::piece::Piece;
use crate::units::Pos;

/// The positions of a slave between two values of its progress, in the same piece or in two with a
/// knot between, which the master passed in one section: knots and turning points.
pub(super) fn record(
    (old, before): (&Piece, i64),
    (piece, progress): (&Piece, i64),
    down: bool,
    section: &Section,
    track: &mut PositionTrack,
) {
    let (from, to) = (section.from, section.to);
    let mut leg = (before, from.after);
    if old.span == 0 && piece.span != 0 {
        // The slave was held, or had not begun: its progress before does not say where it came
        // from.
        let knot = piece.begin.0 as i64;
        let pos = Pos(if down { knot.wrapping_neg() } else { knot });
        let after = section.when(pos.into());
        track.push(after, piece.start);
        leg = (knot, after);
    } else if piece.begin != old.begin && piece.span != 0 && old.span != 0 {
        let up = progress > before;
        // Exact at the begin of a piece.
        let edge = |piece: &Piece, end: bool| {
            let span = if end { piece.span } else { 0 };
            let knot = piece.begin.0.wrapping_add(span) as i64;
            let pos = Pos(if down { knot.wrapping_neg() } else { knot });
            let after = section.when(pos.into());
            ((knot, after), if end { piece.at(span.saturating_sub(1)).0 } else { piece.start })
        };
        let ((left, end), (entered, begin)) = (edge(old, up), edge(piece, !up));
        turning_point(old, (before, left.0), (from.after, left.1), track);
        let joined = entered.0 == left.0;
        track.push(left.1, if joined && up { begin } else { end });
        if !joined {
            track.push(entered.1, begin);
        }
        leg = entered;
    }
    turning_point(piece, (leg.0, progress), (leg.1, to.after), track);
}

/// The positions of a slave between two values of its progress, if a turning point of its own lies
/// between them in this piece.
fn turning_point(piece: &Piece, (from, to): (i64, i64), (begin, end): (u64, u64), track: &mut PositionTrack) {
    let inside = |progress: i64| (progress as u64).wrapping_sub(piece.begin.0).min(piece.span.saturating_sub(1));
    let (low, high) = if from <= to { (inside(from), inside(to)) } else { (inside(to), inside(from)) };
    let falls = |t: u64| slope(&piece.motion, piece.at(t).1) < 0;
    let first = falls(low);
    if low < high && falls(high) != first {
        let turn = bisect(low, high, |t| falls(t) == first);
        let (part, whole) = (turn.wrapping_sub(low), high.wrapping_sub(low));
        let share = Recip::of(whole).ratio(part.min(whole.saturating_sub(1)));
        let share = if from <= to { share } else { share.wrapping_neg() };
        let after = begin.wrapping_add(umulhi(end.wrapping_sub(begin), share));
        track.push(after, piece.at(turn).0);
    }
}
