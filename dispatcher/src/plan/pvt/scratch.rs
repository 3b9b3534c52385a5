//! Scratch memory of a table that is being sent: knots as doubles.
//!
//! In: knots in time order. Out: the same. Owns the velocities, 8 KiB; times and positions wait in
//! the point memory of an empty table.
//! Fails: a knot too many, a segment above the step limit or out of reach. The present table is not
//! changed before the new one is complete.
//!
//! A spline's elimination leaves a fourth number for each point. Only every [`STRIDE_POINTS`]th is
//! kept; those between are computed again ([`super::complete`]).
use crate::refuse::{Admitted, Refused};
use protocol::reason::Reason;
use servo::segment::pvt::{PointStore, TABLE_POINTS};
use servo::units::Pos;

/// The motion stays within 2⁴¹ pulses of its first point: from one edge of travel to the other.
const LENGTH_MAX_PULSES: f64 = 2.0 * Pos::TRAVEL_PULSES as f64;

/// A point of a table in user units, counted from the first point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TablePoint {
    /// ms.
    pub time: f64,
    /// Pulses.
    pub pos: f64,
    /// Pulse/ms.
    pub vel: f64,
}

/// Points between two kept numbers of a spline's elimination.
pub const STRIDE_POINTS: usize = 32;

servo::state! {
    /// Memory besides the point memory.
    pub struct SplineScratch {
        velocities: [f64; TABLE_POINTS] = [0.0; TABLE_POINTS],
        used: usize = 0,
        /// The elimination's numbers at the points 0, [`STRIDE_POINTS`] ….
        kept: [f64; TABLE_POINTS / STRIDE_POINTS] = [0.0; TABLE_POINTS / STRIDE_POINTS],
    }
    /// Empty.
    pub const fn new();
}

/// The memory.
pub struct Scratch<'a> {
    beside: &'a mut SplineScratch,
    room: &'a PointStore,
}

/// A double in two words, and two of them back.
fn words(x: f64) -> [u32; 2] {
    let bits = x.to_bits();
    [bits as u32, (bits >> 32) as u32]
}

fn double(low: u32, high: u32) -> f64 {
    f64::from_bits(u64::from(high) << 32 | u64::from(low))
}

impl<'a> Scratch<'a> {
    /// Memory with its present content. `room` is that of a table which nobody reads.
    pub fn new(beside: &'a mut SplineScratch, room: &'a PointStore) -> Scratch<'a> {
        Scratch { beside, room }
    }

    /// Empties it.
    pub fn clear(&mut self) {
        self.beside.used = 0;
    }

    /// Knots in it.
    pub fn used(&self) -> usize {
        self.beside.used
    }

    /// A knot.
    pub fn knot(&self, index: usize) -> Option<TablePoint> {
        let vel = *self.beside.velocities.get(..self.beside.used)?.get(index)?;
        let [a, b, c, d] = self.room.read(index as u32);
        Some(TablePoint { time: double(a, b), pos: double(c, d), vel })
    }

    /// All knots in their order.
    pub fn knots(&self) -> impl Iterator<Item = TablePoint> + '_ {
        (0..self.used()).map_while(|index| self.knot(index))
    }

    /// Changes a knot.
    pub fn set(&mut self, index: usize, knot: TablePoint) {
        let used = self.beside.used;
        if let Some(point) = self.beside.velocities.get_mut(..used).and_then(|them| them.get_mut(index)) {
            *point = knot.vel;
            let ([a, b], [c, d]) = (words(knot.time), words(knot.pos));
            self.room.write(index as u32, [a, b, c, d]);
        }
    }

    /// Appends a knot.
    pub fn push(&mut self, knot: TablePoint) -> Admitted<()> {
        if self.beside.used >= TABLE_POINTS {
            return Err(Refused::new(Reason::TableFull).limits(0.0, TABLE_POINTS as f64));
        }
        self.beside.used += 1;
        self.set(self.beside.used - 1, knot);
        Ok(())
    }

    /// Keeps the elimination's number at a point, if it is one that is kept.
    pub fn keep(&mut self, index: usize, c: f64) {
        if index.is_multiple_of(STRIDE_POINTS)
            && let Some(point) = self.beside.kept.get_mut(index / STRIDE_POINTS)
        {
            *point = c;
        }
    }

    /// The number at the point `block` · [`STRIDE_POINTS`].
    pub fn kept(&self, block: usize) -> f64 {
        self.beside.kept.get(block).copied().unwrap_or(0.0)
    }
}

/// Whether an axis with this step limit (pulse/ms) can run from one knot to the next.
pub fn check(a: &TablePoint, b: &TablePoint, limit: f64) -> Admitted<()> {
    let length = b.time - a.time;
    let (p, w0, w1) = (b.pos - a.pos, a.vel * length, b.vel * length);
    let (c2, c3) = (3.0 * p - 2.0 * w0 - w1, w0 + w1 - 2.0 * p);
    let top = -c2 / (3.0 * c3);
    let inner = if length > 0.0 && top > 0.0 && top < 1.0 { (w0 + c2 * top) / length } else { 0.0 };
    let speed = a.vel.abs().max(b.vel.abs()).max(inner.abs());
    // Rounding of doubles is tolerated. NaN cannot come from admitted numbers; it would be refused.
    if speed.is_nan() || speed > limit * (1.0 + 1e-9) {
        return Err(Refused::new(Reason::TooFast).got(speed).limits(-limit, limit));
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
    if furthest.is_nan() || furthest.abs() > LENGTH_MAX_PULSES {
        return Err(Refused::new(Reason::BeyondTravel).got(furthest).limits(-LENGTH_MAX_PULSES, LENGTH_MAX_PULSES));
    }
    Ok(())
}
