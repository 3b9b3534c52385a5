//! A timer's cycles, queued ahead: what hardware with preloaded registers carries out.
//!
//! In: pulses and edges at exact counts, how far the future is known. Out: cycles, one after the
//! other without a gap. Owns the end of the queued cycles. Fails never. A cycle is at least as long
//! as DMA needs to bring the next one, and at most as long as 16 bits count. [`super::PwmCycles`]
//! and [`super::GateCycles`] say what becomes of pulses that do not fit.
//!
//! Cycles are queued up to a little before the end of the known interval, and the last of them are
//! short: a timer preloads one cycle while the one before it runs, and DMA reads one more ahead of
//! that.

/// The longest cycle, so that its compare value can lie after its end.
pub(crate) const CYCLE_MAX_COUNTS: u32 = 65_535;

/// Length of the parts of an interval that is longer than that.
const PART_COUNTS: u32 = 32_768;

/// The last two cycles are short if they end less than this many of the shortest ones before the
/// end of the known interval. The last cycle queued begins less than three before it, and two more
/// than that are enough for two cycles.
pub(crate) const LATE_MIN_CYCLES: u32 = 5;

/// Counts of the timer in a ns, in 2⁻³².
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Scale(u32);

impl Scale {
    /// A timer of this many MHz, below 1000.
    pub const fn of_mhz(mhz: u16) -> Scale {
        // Rounded up: off by less than 2⁻³² a ns, so that whole µs are whole counts.
        Scale(((mhz as u64) << 32).div_ceil(1000) as u32)
    }

    /// To the nearest count.
    #[inline(always)]
    pub const fn counts(self, ns: u32) -> u32 {
        ((ns as u64).wrapping_mul(self.0 as u64).wrapping_add(1 << 31) >> 32) as u32
    }
}

/// Cuts an interval into cycles.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lengths {
    left: u32,
    /// The length of the last cycles together, of which each has `least`.
    last: u32,
    least: u32,
}

impl Lengths {
    /// Of an interval of `counts`, at least `least`; `short`: the last two cycles are less than
    /// twice as long as they must be.
    #[inline(always)]
    pub(crate) fn of(counts: u32, least: u32, short: bool) -> Lengths {
        let last = match counts {
            _ if !short => 0,
            counts if counts >= least.wrapping_mul(3) => least.wrapping_mul(2),
            counts if counts >= least.wrapping_mul(2) => least,
            _ => 0,
        };
        Lengths { left: counts, last, least }
    }
}

/// The same of an interval that one cycle and the two short ones at its end make.
#[inline(always)]
pub(crate) fn long_and_two_short(counts: u32, least: u32) -> Option<[u32; 3]> {
    let fits = (least.wrapping_mul(3)..=CYCLE_MAX_COUNTS).contains(&counts);
    fits.then(|| [counts.wrapping_sub(least.wrapping_mul(2)), least, least])
}

impl Iterator for Lengths {
    type Item = u32;

    #[inline(always)]
    fn next(&mut self) -> Option<u32> {
        let Lengths { left, last, least } = *self;
        let length = if left > CYCLE_MAX_COUNTS {
            PART_COUNTS
        } else if left > last {
            left.wrapping_sub(last)
        } else if left > 0 {
            least
        } else {
            return None;
        };
        self.left = left.wrapping_sub(length);
        Some(length)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    #[test]
    fn a_count_is_the_nearest_one() {
        for mhz in [100, 200, 240, 275, 999] {
            for ns in (0..250_000).chain([999_999, 1_000_000]) {
                let exact = u64::from(ns) * u64::from(mhz);
                let counts = u64::from(Scale::of_mhz(mhz).counts(ns));
                assert!((counts * 1000).abs_diff(exact) <= 500, "{ns} ns at {mhz} MHz: {counts}");
                assert!(ns % 1000 != 0 || counts * 1000 == exact, "{ns} ns at {mhz} MHz: {counts}");
            }
        }
    }

    #[test]
    fn lengths_add_up_and_are_possible() {
        for least in [84, 120] {
            for counts in (least..2_000).chain(65_000..70_000).chain(130_900..131_300) {
                for short in [false, true] {
                    let lengths: Vec<u32> = Lengths::of(counts, least, short).collect();
                    assert_eq!(lengths.iter().sum::<u32>(), counts);
                    assert!(
                        lengths.iter().all(|length| (least..=CYCLE_MAX_COUNTS).contains(length)),
                        "{counts}: {lengths:?}"
                    );
                    let last = lengths.iter().rev().take(if counts >= 2 * least { 2 } else { 1 });
                    assert!(
                        !short || last.copied().all(|length| length < 2 * least) || counts < 4 * least,
                        "{lengths:?}"
                    );
                }
            }
        }
    }
}
