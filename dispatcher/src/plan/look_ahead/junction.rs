//! The junction of two motions: the change of velocity there, and the highest speed at which it is
//! passed.
use super::{Limits, PlannedMotion};
use crate::plan::geometry::Position;

/// Where two motions meet.
#[derive(Debug, Clone, Copy)]
pub(super) struct Junction {
    /// Δᵢ over the mean length.
    pub bend: [f32; 4],
    /// The highest square of the speed by the speeds of both motions and the corner time.
    pub cap: f64,
}

/// The path stops there.
pub(super) const STANDSTILL: Junction = Junction { bend: [0.0; 4], cap: 0.0 };

/// The last motion, for the junction to come.
#[derive(Debug, Clone, Copy)]
pub(super) struct LastMotion {
    pub tangent: Position,
    pub length: f64,
    pub vel: f64,
}

impl Limits {
    /// The junction between two motions.
    pub(super) fn junction(&self, before: &LastMotion, motion: &PlannedMotion, tangent: &Position) -> Junction {
        let mean = (before.length + motion.length) / 2.0;
        let slower = before.vel.min(motion.vel);
        let mut junction = Junction { cap: slower * slower, ..STANDSTILL };
        let sides = tangent.iter().zip(&before.tangent).zip(&self.acc);
        for (bend, ((to, from), acc)) in junction.bend.iter_mut().zip(sides) {
            let turn = to - from;
            *bend = (turn / mean) as f32;
            if turn != 0.0 {
                let jump = acc * self.corner / turn;
                junction.cap = junction.cap.min(jump * jump);
            }
        }
        junction
    }
}
