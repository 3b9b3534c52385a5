//! The order in which slaves are computed: after their masters.
//!
//! In: the master of each slave, when that changes. Out: the slaves in order, and the masters. Owns
//! both. Cannot fail: a cycle, which the thread refuses, would be taken in the order of numbers.
use crate::units::{Axis, AxisMask};

/// Slaves that run, masters first. `AXES` is the capacity of the build.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SlaveOrder<const AXES: usize> {
    axes: [u8; AXES],
    count: u8,
    /// The same as a set.
    pub(crate) slaves: AxisMask,
    /// Slaves that others follow.
    pub(crate) leaders: AxisMask,
    /// All axes whose planned positions are followed.
    pub(crate) masters: AxisMask,
}

impl<const AXES: usize> SlaveOrder<AXES> {
    pub(crate) const NONE: SlaveOrder<AXES> =
        SlaveOrder { axes: [0; AXES], count: 0, slaves: AxisMask(0), leaders: AxisMask(0), masters: AxisMask(0) };

    /// `master` says whose planned position an axis follows: itself if it follows something else,
    /// none if it does not follow at all.
    pub(crate) fn renew(&mut self, used: usize, master: impl Fn(Axis) -> Option<Axis>) {
        *self = SlaveOrder::NONE;
        let mut left = 0;
        for axis in Axis::all().take(used) {
            if let Some(master) = master(axis) {
                left |= axis.mask().0;
                if master != axis {
                    self.leaders.0 |= master.mask().0;
                }
            }
        }
        (self.slaves, self.count) = (AxisMask(left), left.count_ones() as u8);
        self.masters = self.leaders;
        self.leaders.0 &= left;
        let mut slots = self.axes.iter_mut();
        while left != 0 {
            let waits = left;
            for axis in AxisMask(waits).axes() {
                let free = master(axis).is_none_or(|master| master == axis || waits & master.mask().0 == 0);
                if free && let Some(index) = slots.next() {
                    *index = axis.index() as u8;
                    left &= !axis.mask().0;
                }
            }
            if left == waits {
                for axis in AxisMask(waits).axes() {
                    if let Some(index) = slots.next() {
                        *index = axis.index() as u8;
                    }
                }
                break;
            }
        }
    }

    /// The slave at an index of the order.
    #[inline(always)]
    pub(crate) fn at(&self, index: usize) -> Option<Axis> {
        if index >= self.count as usize {
            return None;
        }
        Axis::new(*self.axes.get(index)? as usize)
    }
}
