//! Pulse trains in closed form: nobody counts pulses one by one who does not want to see each.
//!
//! In: period and width of a train as dithered counts, the instant of its first pulse. Out: instants of
//! any pulse. One count is 1 ns ([`crate::beam::CLOCK_HZ`]). Fails never: sums saturate.

/// A count of timer clocks whose mean need not be whole: each value is `base` or `base + 1`, such that the
/// sum of the first n is `n·base + ⌊(carry + n·num)/den⌋`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Dither {
    /// Whole counts.
    pub base: u32,
    /// Numerator of the fraction, below `den`.
    pub num: u32,
    /// Its denominator; 0 is taken as 1.
    pub den: u32,
}

impl Dither {
    /// A count without a fraction.
    pub const fn whole(base: u32) -> Dither {
        Dither { base, num: 0, den: 1 }
    }

    fn den(self) -> u64 {
        u64::from(self.den).max(1)
    }

    /// Sum of the first `n` values, from a remainder of `carry` on.
    pub fn sum(self, carry: u32, n: u64) -> u64 {
        let whole = n.saturating_mul(u64::from(self.base));
        if self.num == 0 {
            return whole;
        }
        whole.saturating_add(self.carried(carry, n) / self.den())
    }

    /// The remainder after `n` values.
    pub fn carry(self, carry: u32, n: u64) -> u32 {
        if self.num == 0 { carry } else { (self.carried(carry, n) % self.den()) as u32 }
    }

    fn carried(self, carry: u32, n: u64) -> u64 {
        n.saturating_mul(u64::from(self.num)).saturating_add(u64::from(carry))
    }

    /// The next value; `carry` goes on.
    fn next(self, carry: &mut u32) -> u64 {
        let sum = u64::from(*carry).wrapping_add(u64::from(self.num));
        let over = sum >= self.den();
        *carry = if over { sum.wrapping_sub(self.den()) } else { sum } as u32;
        u64::from(self.base).wrapping_add(u64::from(over))
    }
}

/// Pulses one after the other that are alike but for dither.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Burst {
    /// Start of the first pulse, ns.
    pub at: u64,
    /// Pulses.
    pub count: u64,
    /// From pulse to pulse.
    pub period: Dither,
    /// Remainder of the period at the first pulse.
    pub period_carry: u32,
    /// Width of a pulse.
    pub width: Dither,
    /// Remainder of the width at the first pulse.
    pub width_carry: u32,
}

impl Burst {
    /// A single pulse.
    pub const fn single(at: u64, width: u32) -> Burst {
        let one = Dither::whole(width);
        Burst { at, count: 1, period: one, period_carry: 0, width: one, width_carry: 0 }
    }

    /// Start of pulse `k`, also beyond the last one.
    pub fn start(&self, k: u64) -> u64 {
        self.at.saturating_add(self.period.sum(self.period_carry, k))
    }

    /// Time during which the energy is on, ns.
    pub fn on(&self) -> u64 {
        self.width.sum(self.width_carry, self.count)
    }

    /// Number of the first pulse that starts at `t` or later; `count` if none does.
    pub fn first_from(&self, t: u64) -> u64 {
        let Some(behind) = t.checked_sub(self.at).filter(|behind| *behind > 0) else { return 0 };
        // The mean is off by less than one pulse.
        let den = u128::from(self.period.den());
        let mean = (u128::from(self.period.base) * den + u128::from(self.period.num)).max(1);
        let mut k = u64::try_from(u128::from(behind) * den / mean).unwrap_or(u64::MAX).min(self.count);
        while k > 0 && self.start(k.wrapping_sub(1)) >= t {
            k = k.wrapping_sub(1);
        }
        while k < self.count && self.start(k) < t {
            k = k.wrapping_add(1);
        }
        k
    }

    /// The pulses that start from `t` on.
    #[must_use]
    pub fn skip_to(&self, t: u64) -> Burst {
        let k = self.first_from(t);
        Burst {
            at: self.start(k),
            count: self.count.saturating_sub(k),
            period_carry: self.period.carry(self.period_carry, k),
            width_carry: self.width.carry(self.width_carry, k),
            ..*self
        }
    }

    /// Every pulse: start and end, ns. A pulse of width 0 comes too.
    pub fn pulses(&self) -> impl Iterator<Item = (u64, u64)> + use<> {
        let Burst { mut at, count, period, mut period_carry, width, mut width_carry } = *self;
        (0..count).map(move |_| {
            let start = at;
            at = at.saturating_add(period.next(&mut period_carry));
            (start, start.saturating_add(width.next(&mut width_carry)))
        })
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    const BURST: Burst = Burst {
        at: 1_000,
        count: 1_000,
        period: Dither { base: 33_333, num: 1, den: 3 },
        period_carry: 2,
        width: Dither { base: 0, num: 7, den: 13 },
        width_carry: 12,
    };

    #[test]
    fn one_by_one_and_in_closed_form_are_the_same() {
        let pulses: Vec<_> = BURST.pulses().collect();
        assert_eq!(pulses.len(), 1_000);
        for (k, (start, end)) in (0u64..).zip(&pulses) {
            // The definition, by hand.
            assert_eq!(*start, 1_000 + 33_333 * k + (2 + k) / 3, "{k}");
            assert_eq!(*start, BURST.start(k));
            let sum = |n: u64| (12 + 7 * n) / 13;
            assert_eq!(end - start, sum(k + 1) - sum(k), "{k}");
        }
        assert_eq!(BURST.on(), pulses.iter().map(|(start, end)| end - start).sum::<u64>());
    }

    #[test]
    fn a_burst_can_be_entered_anywhere() {
        let pulses: Vec<_> = BURST.pulses().collect();
        for k in [0, 1, 2, 3, 500, 998, 999] {
            for back in [0, 1, 20_000] {
                let t = pulses[k].0.saturating_sub(back);
                let rest = BURST.skip_to(t);
                let expected: Vec<_> = pulses.iter().copied().filter(|(start, _)| *start >= t).collect();
                assert_eq!(rest.pulses().collect::<Vec<_>>(), expected, "{k} {back}");
            }
        }
        assert_eq!(BURST.first_from(0), 0);
        assert_eq!(BURST.first_from(u64::MAX), 1_000);
        assert_eq!(BURST.skip_to(BURST.start(999) + 1).count, 0);
    }
}
