//! The junction of two motions: the change of velocity there, and the highest speed at which it is
//! passed.
use super::{Limits, WaitingMotion};
use crate::plan::geometry::Position;
use libm::fabs;

/// Where two motions meet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Junction {
    /// Δᵢ over the mean length; the most that it may be if it may go to either side.
    pub bend: [f32; 4],
    /// The highest square of the speed by the speeds of both motions and the corner time.
    pub cap: f64,
}

/// A turn that takes less of the acceleration counts as it is, be it rounding or not.
const SLIGHT_SHARE: f64 = 1.0 / 64.0;

/// The path stops there.
pub(super) const STANDSTILL: Junction = Junction { bend: [0.0; 4], cap: 0.0 };

/// The last motion, for the junction to come.
#[derive(Debug, Clone, Copy)]
pub(super) struct LastMotion {
    pub tangent: Position,
    pub length: f64,
    pub vel: f64,
    pub is_line: bool,
}

/// The turn that rounding to whole pulses may hide between motions of these lengths: half a pulse
/// at each end of both.
pub(super) fn hidden_turn(lengths: [f64; 2]) -> f64 {
    let [before, after] = lengths;
    1.0 / before + 1.0 / after
}

impl Limits {
    /// The junction between two motions, and whether it is open: a part of its turn may be
    /// rounding (`rounding.rs`), which is known once more motions have come.
    pub(super) fn junction(&self, before: &LastMotion, motion: &WaitingMotion, tangent: &Position) -> (Junction, bool) {
        let length = f64::from(motion.length);
        let mean = (before.length + length) / 2.0;
        let slower = before.vel.min(motion.vel);
        let mut junction = Junction { cap: slower * slower, ..STANDSTILL };
        let is_short = before.length.min(length) < slower * self.corner;
        let hidden =
            if is_short && before.is_line && motion.is_line() { hidden_turn([before.length, length]) } else { 0.0 };
        let turns = tangent.iter().zip(&before.tangent).map(|(to, from)| to - from);
        // What hardly turns at full speed may have its rounding.
        let matters = |(turn, acc): (f64, &f64)| (fabs(turn) + hidden) / mean * junction.cap > acc * SLIGHT_SHARE;
        let open = hidden > 0.0 && turns.zip(&self.acc).any(matters);
        let hidden = if open { hidden } else { 0.0 };
        let sides = tangent.iter().zip(&before.tangent).zip(&self.acc);
        for (bend, ((to, from), acc)) in junction.bend.iter_mut().zip(sides) {
            let turn = to - from;
            let turn = turn + hidden.copysign(turn);
            *bend = (turn / mean) as f32;
            if turn != 0.0 {
                let jump = acc * self.corner / turn;
                junction.cap = junction.cap.min(jump * jump);
            }
        }
        (junction, open)
    }
}
