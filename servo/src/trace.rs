//! The trace: samples of chosen axes at chosen ticks.
//!
//! In: the motion of every axis, a tick at a time. Out: samples into a ring. Owns: the row counter.
//! Fails: a full ring loses the sample and counts it; the row numbers show which.
use crate::units::AxisMask;

/// What is traced, and where in the rows it is.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Trace {
    /// Ticks a row; 0 while nothing is traced.
    every: u32,
    /// Ticks until the next row.
    left: u32,
    row: u32,
    axes: AxisMask,
    /// Armed: begins with the program.
    armed: Option<(u32, AxisMask)>,
    /// Samples lost.
    pub(crate) lost: u32,
}

impl Trace {
    pub(crate) const OFF: Trace = Trace { every: 0, left: 0, row: 0, axes: AxisMask(0), armed: None, lost: 0 };

    /// Waits for the program.
    pub(crate) fn arm(&mut self, every: u32, axes: AxisMask) {
        *self = Trace { armed: (every != 0).then_some((every, axes)), ..Trace::OFF };
    }

    /// Begins now: the axes of row 0, which is of the tick in force.
    pub(crate) fn begin(&mut self, every: u32, axes: AxisMask) -> Option<(u32, AxisMask)> {
        *self = Trace { every, left: every, row: 0, axes, armed: None, lost: 0 };
        (every != 0).then_some((0, axes))
    }

    /// The program begins: row 0, if a trace was armed.
    pub(crate) fn begin_armed(&mut self) -> Option<(u32, AxisMask)> {
        let (every, axes) = self.armed?;
        self.begin(every, axes)
    }

    /// The next tick is computed: its row, if it has one.
    pub(crate) fn advance(&mut self) -> Option<(u32, AxisMask)> {
        if self.every == 0 {
            return None;
        }
        self.left = self.left.wrapping_sub(1);
        if self.left != 0 {
            return None;
        }
        self.left = self.every;
        self.row = self.row.wrapping_add(1);
        Some((self.row, self.axes))
    }
}
