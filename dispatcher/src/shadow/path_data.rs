//! What a FIFO of a coordinate system was given, as far as it is known ahead of the tick.
//!
//! In: motions and other entries in the order of their calls. Out: where the next motion begins,
//! where the path may stop. Owns: counts, and the end of the data. Fails: never.
use crate::plan::geometry::Position;
use servo::path::DIMENSIONS;
use servo::units::{Axis, AxisMask};

/// Where a path with the data of a FIFO comes to standstill, if nothing stops it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
enum PathStandstill {
    /// All entries are known to be over: it stands still.
    #[default]
    Over,
    /// At the end of the data.
    AtEnd,
    /// There, but the last motion may be too short to brake in.
    TooShort,
    /// There, or in front of a wait that such a motion precedes.
    AtWait,
}

/// What a FIFO was given since it was cleared.
#[derive(Debug, Clone, Copy, Default)]
pub struct PathData {
    /// Entries, with those that wait in the look-ahead.
    pub given: u32,
    /// Entries that are over at this point of the program, whether the tick has released them or
    /// not.
    pub over: u32,
    /// Motions among the entries.
    pub motions: u32,
    /// Where the path comes to standstill.
    standstill: PathStandstill,
    /// Where the last motion ends.
    pub position: Position,
    /// Axes that move in proportion to the next motion (gears).
    pub gears: AxisMask,
    /// Axes that its entries may move: of moves and gears.
    pub extra_axes: AxisMask,
    /// The gear with the largest displacement, and that displacement, pulses.
    pub geared: Axis,
    pub gear: u32,
    /// Motions after the last one that takes a coordinate to a target of its own, four bits for
    /// each: up to [`CoordinateAges::MANY`], or [`CoordinateAges::NEVER`]. Without a target it
    /// stays where the path is.
    pub(super) ages: CoordinateAges,
    /// Highest speed at the end of the last motion, pulse/ms, rounded down. Without look-ahead the
    /// next one may begin faster than its own speed.
    pub leaves: f32,
}

/// See [`PathData`].
#[derive(Debug, Clone, Copy)]
pub(super) struct CoordinateAges(u16);

impl Default for CoordinateAges {
    fn default() -> Self {
        CoordinateAges(u16::MAX)
    }
}

impl CoordinateAges {
    const NEVER: u16 = 15;
    /// So many, or more.
    const MANY: u16 = 14;

    fn each(self) -> [u16; DIMENSIONS] {
        [0, 4, 8, 12].map(|shift| self.0 >> shift & 15)
    }
    fn of(ages: [u16; DIMENSIONS]) -> CoordinateAges {
        CoordinateAges(ages.iter().rev().fold(0, |all, age| all << 4 | age))
    }
    /// After a motion that sets these coordinates, a bit each.
    #[inline(always)]
    fn after(self, sets: u8) -> CoordinateAges {
        if sets == 0b1111 {
            return CoordinateAges(0);
        }
        let mut ages = self.each();
        for (index, age) in ages.iter_mut().enumerate() {
            *age = if sets >> index & 1 == 1 { 0 } else { *age + u16::from(*age < CoordinateAges::MANY) };
        }
        CoordinateAges::of(ages)
    }
    /// Those of the last so many motions alone, and whether they are sure.
    pub(super) fn ahead(self, motions: u32) -> (CoordinateAges, bool) {
        let mut sure = true;
        let ages = self.each().map(|age| {
            sure &= age != CoordinateAges::MANY || motions <= u32::from(CoordinateAges::MANY);
            if u32::from(age) < motions { age } else { CoordinateAges::NEVER }
        });
        (CoordinateAges::of(ages), sure)
    }
}

impl PathData {
    /// It holds entries that are not known to be over; else the next motion begins where the path
    /// is.
    pub fn is_open(&self) -> bool {
        self.standstill != PathStandstill::Over
    }
    /// Its last motion may be too short to brake in.
    pub fn set_end_too_short(&mut self) {
        if self.standstill != PathStandstill::AtWait {
            self.standstill = PathStandstill::TooShort;
        }
    }
    /// The path may stop in front of a wait.
    pub(super) fn may_stop_at_wait(&self) -> bool {
        self.standstill == PathStandstill::AtWait
    }
    pub(super) fn close(&mut self) {
        self.standstill = PathStandstill::Over;
    }
    pub(super) fn open(&mut self) {
        if self.standstill != PathStandstill::AtWait {
            self.standstill = PathStandstill::AtEnd;
        }
    }
    /// Takes in a motion that ends here, and that sets these coordinates.
    #[inline(always)]
    pub fn add_motion(&mut self, end: Position, sets: u8) {
        let before = if self.is_open() { self.ages } else { CoordinateAges::default() };
        self.ages = before.after(sets);
        (self.given, self.motions) = (self.given.wrapping_add(1), self.motions.wrapping_add(1));
        (self.position, self.gears.0, self.gear) = (end, 0, 0);
        self.open();
    }
    /// Takes in an entry between motions. The first one of a FIFO acts where the path is; a motion
    /// after it begins there.
    pub fn add_entry(&mut self, begin: Position, waits: bool) {
        if !self.is_open() {
            (self.ages, self.position) = (CoordinateAges::default(), begin);
            self.open();
        }
        self.given = self.given.wrapping_add(1);
        if waits {
            self.leaves = 0.0;
            if self.standstill == PathStandstill::TooShort {
                self.standstill = PathStandstill::AtWait;
            }
        }
    }
    /// The path moves beside this data, or gets another name: where it has no target it is not
    /// known any more.
    pub(super) fn forget_position(&mut self) {
        let ages = self.ages;
        let others = self.position.iter_mut().zip(ages.each()).filter(|(_, age)| *age == CoordinateAges::NEVER);
        others.for_each(|(at, _)| *at = f64::NAN);
    }
    /// The path stands here: it is known where it has no target.
    pub(super) fn set_known_position(&mut self, here: &Position) {
        let unknown = self.position.iter_mut().zip(here).filter(|(at, _)| at.is_nan());
        unknown.for_each(|(at, here)| *at = *here);
    }
}
