//! The interface of a path: its inputs and reports.
//!
//! In: rules, how many entries are there. Out: its position, its effects on others, the motion of
//! its coordinates between ticks. Owns nothing. Cannot fail.
use super::ORIGIN;
use crate::math::float::Float;
use crate::path::entry::EntryEffect;
use crate::path::geometry::Curvature;
use crate::path::{DIMENSIONS, PathPos};
use crate::segment::piece::{Motion, Scaled};
use crate::segment::ramp::Accel;
use crate::units::{Axis, FineNs, Pos};

/// The effects of a path on the rest of the machine. Instants come in order; all lie before the end
/// of the interval that the step is for, and after everything reported in earlier steps.
pub trait Effects {
    /// An entry takes effect. Returns how long the path waits for it: a modal move's time, else 0.
    fn change(&mut self, at: FineNs, change: &EntryEffect) -> FineNs;
    /// The path comes to standstill.
    fn standstill(&mut self, at: FineNs, path_stop: PathStop);
    /// An axis is geared to the motion in force: its displacement since the motion began, at the
    /// step's tick, and its displacement per path length.
    fn gear(&mut self, axis: Axis, by: Pos, ratio: Scaled);
    /// A geared axis is at the end of a motion, which moved it by this much.
    fn geared(&mut self, at: FineNs, axis: Axis, pulses: i32);
    /// Whether an axis goes along with the motion that is entered; else the path stops before it.
    /// `can`: the motion has a length, or does not move it.
    fn accepts_gear(&mut self, _axis: Axis, _can: bool) -> bool {
        true
    }
    /// More axes than a path can gear to one motion; this one stays.
    fn surplus(&mut self, _axis: Axis) {}
    /// Whether there is room for one more effect of this tick.
    fn has_room(&self) -> bool {
        true
    }
    /// Whether the path may be at this position; else it comes to standstill before it.
    fn admits(&mut self, _position: &PathPos) -> bool {
        true
    }
    /// The same for an axis geared to the motion in force, at this displacement since it began.
    fn admits_gear(&mut self, _axis: Axis, _by: Pos) -> bool {
        true
    }
}

/// Why a path comes to standstill; CrdInfo reports the number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PathStop {
    /// It never moved.
    #[default]
    Never = 0,
    /// Its entries have run out.
    Completed = 1,
    /// Its entries have run out at speed, or it has come to a wait at speed. In front of a wait it
    /// can go on.
    Underrun = 2,
    /// A Stop. It can go on.
    Stopped = 3,
    /// A position that it must not go to. It can go on from there.
    Obstructed = 4,
}

/// How many entries of each FIFO are there, counted since it was cleared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FifoEnds {
    /// Of FIFO 0 and 1.
    pub ends: [u32; 2],
}

/// Settings for all motions of a coordinate system.
#[derive(Debug, Clone, Copy)]
pub struct PathSettings {
    pub(super) even: Float,
    pub(super) stop: Float,
    pub(super) rate: Float,
}

impl PathSettings {
    /// No even time, a stop deceleration of 1 pulse/ms², no override.
    pub const POWER_ON: PathSettings = PathSettings { even: Float::ZERO, stop: Float::ONE, rate: Float::ONE };

    /// Least time at constant speed in a motion (TCrdPrm.evenTime), ms.
    pub fn set_even(&mut self, ms: u16) {
        self.even = Float::new(false, ms as u64, 0);
    }

    /// Deceleration of a smooth Stop.
    pub fn set_stop(&mut self, dec: Accel) {
        self.stop = dec.magnitude();
    }
}

/// Where a path publishes its position; what has not changed is not written again.
pub struct PathReport<'a> {
    /// Coordinates.
    pub position: &'a mut PathPos,
    /// Direction.
    pub heading: &'a mut [i32; DIMENSIONS],
    /// How it turns.
    pub bend: &'a mut Curvature,
    /// The path length along the motion in force.
    pub motion: &'a mut Motion,
    /// Counts changes of bend and motion, at least, except for the position in it.
    pub piece_version: &'a mut u32,
}

/// The other results of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StepReport {
    /// Whether it runs; it also does while it waits.
    pub runs: bool,
    /// FIFO in force.
    pub fifo: u8,
    /// Motions of it completed since it was cleared.
    pub done: u32,
    /// Entries of each FIFO that are over at the sample. Those between it and the next sample are
    /// not over for good before that (see [`Path::stand_still`](super::Path::stand_still)): their
    /// slots are not free yet.
    pub released: [u32; 2],
}

/// The motion of the coordinates between two ticks, for slaves of one of them.
#[derive(Debug, Clone, Copy)]
pub struct TrajectorySample {
    /// Boundaries that were passed, with their positions: the first ones and the last one.
    knots: [(FineNs, PathPos); SAMPLE_KNOTS],
    pub(super) count: u8,
    /// For each coordinate, if it reversed on an arc after the last of them: the share of the time
    /// since, in 2⁻⁶⁴, and the position.
    pub(super) turns: [Option<(u64, Pos)>; DIMENSIONS],
}

/// Boundaries of an interval that a sample keeps.
const SAMPLE_KNOTS: usize = 3;

impl TrajectorySample {
    pub(super) const NONE: TrajectorySample =
        TrajectorySample { knots: [(0, ORIGIN); SAMPLE_KNOTS], count: 0, turns: [None; DIMENSIONS] };

    pub(super) fn pass(&mut self, at: FineNs, position: PathPos) {
        let index = (self.count as usize).min(SAMPLE_KNOTS - 1);
        if let Some(knot) = self.knots.get_mut(index) {
            *knot = (at, position);
        }
        self.count = index as u8 + 1;
    }

    /// Boundaries in the order of time.
    pub fn knots(&self) -> &[(FineNs, PathPos)] {
        self.knots.get(..self.count as usize).unwrap_or_default()
    }

    /// Where a coordinate reversed after them.
    pub fn turn(&self, index: usize) -> Option<(u64, Pos)> {
        self.turns.get(index).copied().flatten()
    }
}
