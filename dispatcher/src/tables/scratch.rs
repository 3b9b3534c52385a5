//! Scratch memory of a table that is being sent: knots as doubles, 32 KiB.
//!
//! In: knots in time order. Out: the same. Fails: a knot too many, a segment that is faster than
//! full scale or swings out of reach. The table in force is not touched before the new one is whole.
use crate::refuse::{Admitted, Refused};
use protocol::reason::Reason;
use servo::pvt::PLACES;

/// Full scale of velocity, pulse/ms; a double's rounding above it is still full scale.
const FULL_SCALE: f64 = 4_294_967_296.0;
/// The motion stays within 2⁴¹ pulses of its first point: from one edge of travel to the other.
const REACH: f64 = 2_199_023_255_552.0;

/// A place of a table in user units, counted from the first point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Knot {
    /// ms.
    pub time: f64,
    /// Pulses.
    pub pos: f64,
    /// Pulse/ms.
    pub vel: f64,
}

/// The memory. Words of a place: time, position, velocity, and one for the spline's solution.
pub struct Scratch {
    knots: [[f64; 4]; PLACES],
    used: usize,
}

impl Default for Scratch {
    fn default() -> Self {
        Self::new()
    }
}

impl Scratch {
    /// Empty.
    pub const fn new() -> Scratch {
        Scratch { knots: [[0.0; 4]; PLACES], used: 0 }
    }

    /// Empties it.
    pub fn clear(&mut self) {
        self.used = 0;
    }

    /// What was put in.
    pub fn knots(&self) -> &[[f64; 4]] {
        self.knots.get(..self.used).unwrap_or(&[])
    }

    /// As [`Scratch::knots`], to be changed.
    pub fn knots_mut(&mut self) -> &mut [[f64; 4]] {
        self.knots.get_mut(..self.used).unwrap_or(&mut [])
    }

    /// Appends a place.
    pub fn push(&mut self, place: [f64; 4]) -> Admitted<()> {
        match self.knots.get_mut(self.used) {
            Some(free) => *free = place,
            None => return Err(Refused::new(Reason::TablePlaces).limits(0.0, PLACES as f64)),
        }
        self.used += 1;
        Ok(())
    }
}

/// Whether an axis can run from one knot to the next.
pub fn check(a: &Knot, b: &Knot) -> Admitted<()> {
    let length = b.time - a.time;
    let (p, w0, w1) = (b.pos - a.pos, a.vel * length, b.vel * length);
    let (c2, c3) = (3.0 * p - 2.0 * w0 - w1, w0 + w1 - 2.0 * p);
    let top = -c2 / (3.0 * c3);
    let inner = if length > 0.0 && top > 0.0 && top < 1.0 { (w0 + c2 * top) / length } else { 0.0 };
    let speed = a.vel.abs().max(b.vel.abs()).max(inner.abs());
    // NaN cannot come from admitted numbers; it would be refused.
    if speed.is_nan() || speed > FULL_SCALE * (1.0 + 1e-9) {
        return Err(Refused::new(Reason::TooFast).got(speed).limits(0.0, FULL_SCALE));
    }
    // Where the velocity is 0 the position is furthest: w0 + 2·c2·τ + 3·c3·τ² = 0.
    let q = -(c2 + libm::sqrt((c2 * c2 - 3.0 * w0 * c3).max(0.0)).copysign(c2));
    let mut furthest = b.pos;
    for turn in [q / (3.0 * c3), w0 / q] {
        let pos = a.pos + turn * (w0 + turn * (c2 + turn * c3));
        if turn > 0.0 && turn < 1.0 && pos.abs() > furthest.abs() {
            furthest = pos;
        }
    }
    if furthest.is_nan() || furthest.abs() > REACH {
        return Err(Refused::new(Reason::BeyondTravel).got(furthest).limits(-REACH, REACH));
    }
    Ok(())
}
