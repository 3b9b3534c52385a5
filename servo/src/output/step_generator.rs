//! The step generator: whole pulses between two set-points, and the slot of the tick for each one.
//!
//! In: two set-points. Out: a signed count, and one yes/no per slot of the tick. Owns an
//! accumulator. It cannot fail; nothing here divides.
//!
//! The step output is at the planned position rounded to the nearest pulse (halves upwards). So
//! both directions are alike, and an axis at standstill on a knot is half a pulse away from the
//! next edge. The pulses of a tick are spread evenly and centred: with n pulses in a tick of S
//! slots, pulse k comes in slot `ceil(((k + 1)·S − floor(S/2)) / n) − 1`. Hardware fills its slots
//! by [`StepSlots`]; code that may divide (the VCD writer) uses the closed form, and a test holds
//! them equal.
use crate::units::Pos;
pub use crate::units::whole;

/// Steps from one set-point to the next; negative is backwards.
pub const fn between(from: Pos, to: Pos) -> i64 {
    whole(to).wrapping_sub(whole(from))
}

/// Spreads `count` steps over `slots` equal slots of a tick: one answer per slot.
#[derive(Debug, Clone, Copy)]
pub struct StepSlots {
    count: u32,
    slots: u32,
    phase: u32,
}

impl StepSlots {
    /// `count` steps in `slots` slots. More steps than slots do not fit: `None`.
    pub const fn new(count: u32, slots: u32) -> Option<StepSlots> {
        if slots == 0 || slots > 1 << 30 || count > slots {
            return None;
        }
        Some(StepSlots { count, slots, phase: slots >> 1 })
    }

    /// Whether the next slot carries a step. After `slots` calls `count` of them were true.
    pub const fn advance(&mut self) -> bool {
        self.phase = self.phase.wrapping_add(self.count);
        if self.phase >= self.slots {
            self.phase = self.phase.wrapping_sub(self.slots);
            true
        } else {
            false
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    #[test]
    fn rounds_to_the_nearest_pulse_in_both_directions() {
        let one = 1i64 << Pos::FRAC_BITS;
        for (pos, pulse) in [
            (0, 0),
            (one / 2 - 1, 0),
            (one / 2, 1),
            (one, 1),
            (-one / 2, 0),
            (-one / 2 - 1, -1),
            (-one, -1),
            (4096 * one, 4096),
            (-4096 * one, -4096),
        ] {
            assert_eq!(whole(Pos(pos)), pulse, "{pos}");
        }
        assert_eq!(between(Pos(-one), Pos(2 * one)), 3);
        assert_eq!(between(Pos(2 * one), Pos(-one)), -3);
    }

    /// Against the closed form of the module text, in exact integers.
    #[test]
    fn slots_agree_with_the_closed_form() {
        for slots in [1u32, 2, 7, 100, 1000] {
            for count in 0..=slots {
                let mut walker = StepSlots::new(count, slots).unwrap();
                let at: Vec<u32> = (0..slots).filter(|_| walker.advance()).collect();
                let closed: Vec<u32> =
                    (0..count).map(|k| (((k + 1) * slots - slots / 2).div_ceil(count)) - 1).collect();
                assert_eq!(at, closed, "{count} in {slots}");
            }
        }
        assert!(StepSlots::new(8, 7).is_none());
        assert!(StepSlots::new(0, 0).is_none());
    }
}
