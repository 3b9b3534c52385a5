//! What a path does to axes outside it.
use super::*;

/// The axes beside the path. Instants are ms of the program.
pub trait World {
    /// An axis sets off; when it will be there. None: it must not move.
    fn travel(&mut self, at: f64, to: &Move) -> Option<f64>;
    /// An axis is geared to a motion from now on, and goes so many pulses for one of the path;
    /// where it is. The path has waited for so many moves. None: it must not move.
    fn engage(&mut self, axis: usize, ratio: f64, waited: u32) -> Option<super::super::Fix>;
    /// Whether an axis moves is open.
    fn may_move(&mut self, axis: usize);
    /// Where a geared axis is at an instant; whether its motion ends there.
    fn carry(&mut self, at: f64, axis: usize, x: super::super::Fix, ends: bool);
}

/// What would happen: nothing is moved.
pub(super) struct Nobody;

impl World for Nobody {
    fn travel(&mut self, at: f64, _: &Move) -> Option<f64> {
        Some(at)
    }

    fn engage(&mut self, _: usize, _: f64, _: u32) -> Option<super::super::Fix> {
        Some(super::super::Fix::ZERO)
    }

    fn may_move(&mut self, _: usize) {}

    fn carry(&mut self, _: f64, _: usize, _: super::super::Fix, _: bool) {}
}
