//! The trace: samples of chosen axes and laser channels at chosen ticks.
//!
//! In: the motion of every axis, a tick at a time. Out: samples into a ring. Owns: the row counter.
//! Fails: a full ring loses the sample and counts it; the row numbers show which.
use crate::tick::SAMPLES;
use crate::units::AxisMask;
use crate::view::Sample;
use ring::Producer;

/// What is traced: axes, and laser channels (bit 0 the first).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Chosen {
    pub(crate) axes: AxisMask,
    pub(crate) lasers: u8,
}

/// What is traced, and where in the rows it is.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Trace {
    /// Ticks a row; 0 while nothing is traced.
    every: u32,
    /// Ticks until the next row.
    left: u32,
    row: u32,
    chosen: Chosen,
    /// Armed: begins with the program.
    armed: Option<(u32, Chosen)>,
    /// Samples lost.
    pub(crate) lost: u32,
}

impl Trace {
    pub(crate) const OFF: Trace =
        Trace { every: 0, left: 0, row: 0, chosen: Chosen { axes: AxisMask(0), lasers: 0 }, armed: None, lost: 0 };

    /// Waits for the program.
    pub(crate) fn arm(&mut self, every: u32, chosen: Chosen) {
        *self = Trace { armed: (every != 0).then_some((every, chosen)), ..Trace::OFF };
    }

    /// Begins now: what row 0 is of, which is of the tick in force.
    pub(crate) fn begin(&mut self, every: u32, chosen: Chosen) -> Option<(u32, Chosen)> {
        *self = Trace { every, left: every, row: 0, chosen, armed: None, lost: 0 };
        (every != 0).then_some((0, chosen))
    }

    /// The program begins: row 0, if a trace was armed.
    pub(crate) fn begin_armed(&mut self) -> Option<(u32, Chosen)> {
        let (every, chosen) = self.armed?;
        self.begin(every, chosen)
    }

    /// Hands a sample over, or counts it as lost.
    #[inline]
    pub(crate) fn put(&mut self, sample: Sample, samples: &mut Producer<'_, Sample, SAMPLES>) {
        if samples.push(sample).is_err() {
            self.lost = self.lost.saturating_add(1);
        }
    }

    /// The next tick is computed: its row, if it has one.
    pub(crate) fn advance(&mut self) -> Option<(u32, Chosen)> {
        if self.every == 0 {
            return None;
        }
        self.left = self.left.wrapping_sub(1);
        if self.left != 0 {
            return None;
        }
        self.left = self.every;
        self.row = self.row.wrapping_add(1);
        Some((self.row, self.chosen))
    }
}
