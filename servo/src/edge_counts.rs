//! Counts of the edges of inputs, of both directions (GetDiReverseCount).
//!
//! In: what changed at a tick, from the tick. Out: the counts, to the thread. Owns: the counts,
//! modulo 2³². Cannot fail. Work: only in a tick at which an input has changed.
use crate::capacity::{COUNTED_AXES, GeneralInputs};
use crate::segment::follow::Input;
use crate::units::Axis;
use ring::Store;

/// General inputs, and inputs of an axis.
const GENERAL_INPUTS: usize = GeneralInputs::BITS as usize;
const AXIS_INPUTS: usize = 5;

/// The counts of all inputs: of general ones, and five of each axis.
pub struct EdgeCounts {
    general: Store<1, GENERAL_INPUTS>,
    of_axes: Store<1, { (COUNTED_AXES * AXIS_INPUTS).next_power_of_two() }>,
}

const _: () = assert!(COUNTED_AXES <= Axis::MAX);

/// The slot of an axis' input; that of the last axis for one that does not exist.
fn slot(input: Input, axis: usize) -> u32 {
    (axis.min(COUNTED_AXES - 1) * AXIS_INPUTS + input as usize) as u32
}

impl EdgeCounts {
    /// All 0.
    pub const fn new() -> EdgeCounts {
        EdgeCounts { general: Store::new(), of_axes: Store::new() }
    }

    /// The count of an input. `index` is an axis over all cores, or a general input, from 0.
    pub fn of(&self, input: Input, index: u8) -> u32 {
        match input {
            Input::General => self.general.word(index.into(), 0),
            input => self.of_axes.word(slot(input, index.into()), 0),
        }
    }

    /// It goes on from here.
    pub(crate) fn set(&self, input: Input, index: u8, count: u32) {
        match input {
            Input::General => self.general.write(index.into(), [count]),
            input => self.of_axes.write(slot(input, index.into()), [count]),
        }
    }

    fn add(&self, input: Input, index: u8) {
        self.set(input, index, self.of(input, index).wrapping_add(1));
    }

    /// Inputs of an axis have changed: bits as those of
    /// [`AxisInputs::bits`](crate::port::AxisInputs::bits).
    #[inline(never)]
    pub(crate) fn add_of_axis(&self, axis: Axis, flips: u8) {
        for input in [Input::LimitPositive, Input::LimitNegative, Input::Alarm, Input::Home, Input::Arrive] {
            if flips >> input as u8 & 1 == 1 {
                self.add(input, axis.index() as u8);
            }
        }
    }

    /// General inputs have changed.
    #[inline(never)]
    pub(crate) fn add_of_general(&self, flips: GeneralInputs) {
        let mut left = flips;
        while left != 0 {
            self.add(Input::General, left.trailing_zeros() as u8);
            left &= left.wrapping_sub(1);
        }
    }
}
