//! The position of a path in one FIFO, and the axes geared to its motion.
use crate::path::geometry::GearMotion;
use crate::path::{DIMENSIONS, PathPos};
use crate::units::{Axis, Exact, FineNs, Pos};

/// Axes geared to one motion.
pub const GEARS: usize = 4;

/// An axis geared to a motion.
#[derive(Debug, Clone, Copy)]
pub(super) struct ActiveGear {
    pub(super) axis: Axis,
    pub(super) pulses: i32,
    pub(super) along: GearMotion,
}

state! {
    /// The position in one FIFO.
    #[derive(Debug, Clone, Copy)]
    pub(crate) struct Cursor {
        /// Counter of the next entry.
        pub(crate) next: u32 = 0,
        /// Motions completed.
        pub(crate) done: u32 = 0,
        /// The motion before `next`, or the move that is waited for, is not over.
        pub(super) inside: bool = false,
        /// It was interrupted with something to do, at `position`.
        pub(super) kept: bool = false,
        pub(super) position: PathPos = ORIGIN,
        /// Of that motion: where it began, and the path length so far.
        pub(super) from: PathPos = ORIGIN,
        pub(super) distance: Exact = Exact(0),
        /// The remainder of a wait.
        pub(super) left: FineNs = 0,
        pub(super) gears: [ActiveGear; GEARS] = [NO_GEAR; GEARS],
        pub(super) geared: usize = 0,
        /// It was set back: entries before `reported` have been carried out. They are passed, but
        /// for those of a laser, which are made again.
        pub(super) again: bool = false,
        pub(super) reported: u32 = 0,
        /// Motions before this entry have been left: what was geared to them has gone along.
        pub(crate) left_at: u32 = 0,
    }
    pub(super) const NEW;
}

/// The position in a FIFO at a sample.
#[derive(Debug, Clone, Copy)]
pub(super) struct SampledPosition {
    pub(super) next: u32,
    pub(super) done: u32,
    pub(super) inside: bool,
    pub(super) from: PathPos,
    pub(super) distance: Pos,
}

impl SampledPosition {
    pub(super) const NONE: SampledPosition =
        SampledPosition { next: 0, done: 0, inside: false, from: ORIGIN, distance: Pos(0) };
}

const NO_GEAR: ActiveGear = ActiveGear { axis: Axis::FIRST, pulses: 0, along: GearMotion::NONE };
pub(super) const ORIGIN: PathPos = [Pos(0); DIMENSIONS];

impl Cursor {
    /// Entries that are over.
    #[inline(always)]
    pub(super) fn released(&self) -> u32 {
        self.next.wrapping_sub(self.inside as u32)
    }

    /// As a new one, whose gears are not read.
    pub(super) fn clear(&mut self) {
        (self.next, self.done, self.inside, self.kept) = (0, 0, false, false);
        (self.position, self.from, self.distance, self.left) = (ORIGIN, ORIGIN, Exact(0), 0);
        (self.geared, self.again, self.left_at) = (0, false, 0);
    }
}
