//! The time that light was on.
//!
//! In: the light of each interval that has passed. Out: whole units of 250 µs. Owns the sum, to the
//! ns: the remainder of a unit is carried. Fails: never; the count wraps at 2³² units (12 days of
//! light).
use crate::units::CYCLE_NS;

/// A unit of the count.
const UNIT_NS: u32 = CYCLE_NS;

/// The sum of all light since it was zeroed.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct OnTime {
    pub(crate) units: u32,
    /// Below a unit.
    remainder_ns: u32,
}

impl OnTime {
    pub(super) const ZERO: OnTime = OnTime { units: 0, remainder_ns: 0 };

    /// Light of an interval, at most 1 ms.
    #[inline]
    pub(super) fn add(&mut self, ns: u32) {
        let mut sum = self.remainder_ns.wrapping_add(ns);
        if sum >= UNIT_NS {
            sum = sum.wrapping_sub(UNIT_NS);
            self.units = self.units.wrapping_add(1);
            if sum >= UNIT_NS {
                // A long tick.
                self.units = self.units.wrapping_add(sum / UNIT_NS);
                sum %= UNIT_NS;
            }
        }
        self.remainder_ns = sum;
    }
}
