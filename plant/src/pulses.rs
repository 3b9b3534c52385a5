//! Pulse trains in closed form, so that a caller need not count pulses one by one.
//!
//! In: a train as the tick plans it ([`Train`]), the instant of its first pulse. Out: instants of
//! any pulse. A count of the timer is 1 ns. Fails never: sums saturate.
use servo::laser::{Count, Train};

/// The remainder of a [`Count`] after whole counts: half of a [`servo::laser::Pattern`], in closed
/// form.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Remainder {
    gathered: u32,
    of: u32,
}

impl Remainder {
    /// Zero: a pattern begins.
    pub const NONE: Remainder = Remainder { gathered: 0, of: 0 };

    /// The remainder of a rate, in 2⁻³² counts.
    pub const fn of_rate(part: u32) -> Remainder {
        Remainder { gathered: part, of: 0 }
    }

    /// The remainder of periods of a rate, in 2⁻³² counts.
    pub const fn part(self) -> u32 {
        if self.of == 0 { self.gathered } else { 0 }
    }

    /// A pattern of another denominator begins anew.
    const fn gathered(self, count: Count) -> u32 {
        if self.goes_on(count) { self.gathered } else { 0 }
    }

    /// Whether the pattern of `count` continues after it.
    pub const fn goes_on(self, count: Count) -> bool {
        self.of == count.of
    }

    fn carried(self, count: Count, n: u64) -> (u64, u32) {
        let den = if count.of == 0 { 1 << 32 } else { u64::from(count.of) };
        if count.part == 0 && self.gathered(count) == 0 {
            return (0, 0);
        }
        let gathered = u64::from(self.gathered(count));
        match n.checked_mul(count.part.into()).and_then(|sum| sum.checked_add(gathered)) {
            Some(sum) => (sum / den, (sum % den) as u32),
            None => {
                let sum = u128::from(n) * u128::from(count.part) + u128::from(gathered);
                (u64::try_from(sum / u128::from(den)).unwrap_or(u64::MAX), (sum % u128::from(den)) as u32)
            }
        }
    }

    /// Counts of the next `n` periods.
    pub fn sum(self, count: Count, n: u64) -> u64 {
        n.saturating_mul(count.whole).saturating_add(self.carried(count, n).0)
    }

    /// The remainder after them.
    #[must_use]
    pub fn after(self, count: Count, n: u64) -> Remainder {
        if n == 0 { self } else { Remainder { gathered: self.carried(count, n).1, of: count.of } }
    }
}

/// Pulses of a train, one after the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Burst {
    /// Start of the first pulse, ns.
    pub at: u64,
    /// Pulses.
    pub count: u64,
    /// Period and width; where that reaches the period the pulses touch.
    pub train: Train,
    /// Remainder of the period before the first pulse.
    pub period_remainder: Remainder,
    /// Remainder of the width before the first pulse.
    pub width_remainder: Remainder,
}

impl Burst {
    /// `count` pulses of a train that begins here.
    pub const fn new(at: u64, count: u64, train: Train) -> Burst {
        Burst { at, count, train, period_remainder: Remainder::NONE, width_remainder: Remainder::NONE }
    }

    /// A single pulse.
    pub const fn single(at: u64, width: u64) -> Burst {
        let width = Count { whole: width, part: 0, of: 0 };
        Burst::new(at, 1, Train { period: width, width })
    }

    /// Start of pulse `k`, also beyond the last one.
    pub fn start(&self, k: u64) -> u64 {
        self.at.saturating_add(self.period_remainder.sum(self.train.period, k))
    }

    /// Time during which the energy is on, ns.
    pub fn on(&self) -> u64 {
        if self.train.is_full() {
            return self.start(self.count).saturating_sub(self.at);
        }
        self.width_remainder.sum(self.train.width, self.count)
    }

    /// Number of the first pulse that starts at `t` or later; `count` if none does.
    pub fn first_from(&self, t: u64) -> u64 {
        let Some(after) = t.checked_sub(self.at).filter(|after| *after > 0) else { return 0 };
        let Count { whole, part, of } = self.train.period;
        // The mean period: off by less than one pulse.
        let guess = match (whole, part) {
            (0, _) => u64::MAX,
            (_, 0) => after / whole,
            _ => {
                let den = if of == 0 { 1 << 32 } else { u128::from(of) };
                let mean = u128::from(whole) * den + u128::from(part);
                u64::try_from(u128::from(after) * den / mean).unwrap_or(u64::MAX)
            }
        };
        let mut k = guess.min(self.count);
        while k > 0 && self.start(k.wrapping_sub(1)) >= t {
            k = k.wrapping_sub(1);
        }
        while k < self.count && self.start(k) < t {
            k = k.wrapping_add(1);
        }
        k
    }

    /// The pulses from number `k` on.
    #[must_use]
    pub fn skip(&self, k: u64) -> Burst {
        Burst {
            at: self.start(k),
            count: self.count.saturating_sub(k),
            train: self.train,
            period_remainder: self.period_remainder.after(self.train.period, k),
            width_remainder: self.width_remainder.after(self.train.width, k),
        }
    }

    /// Every pulse: start and end, ns. A pulse of width 0 comes too; none reaches into the next
    /// one.
    pub fn pulses(&self) -> impl Iterator<Item = (u64, u64)> + use<> {
        let mut rest = *self;
        (0..self.count).map(move |_| {
            let (start, width) = (rest.at, rest.width_remainder.sum(rest.train.width, 1));
            rest = rest.skip(1);
            let is_full = rest.train.is_full();
            (start, if is_full { rest.at } else { start.saturating_add(width).min(rest.at) })
        })
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use servo::laser::Pattern;
    use std::vec::Vec;

    fn count(whole: u64, part: u32, of: u32) -> Count {
        Count { whole, part, of }
    }

    fn bursts() -> Vec<Burst> {
        let train = Train { period: count(33_333, 1, 3), width: count(0, 7, 13) };
        let fine = Train { period: count(500, 0x8000_0001, 0), width: count(500, 0x8000_0001, 0) };
        let plain = Train { period: count(1, 0, 0), width: count(0, 0, 7) };
        [train, fine, plain].map(|train| Burst::new(1_000, 1_000, train)).to_vec()
    }

    #[test]
    fn the_closed_form_is_what_the_machines_count_with() {
        for burst in bursts() {
            let (mut pattern, mut at) = (Pattern::BEGIN, burst.at);
            for (k, (start, end)) in (0..).zip(burst.pulses()) {
                let (period, width) = pattern.step(&burst.train);
                assert_eq!((start, burst.start(k), end - start), (at, at, width), "{k}");
                at += period;
            }
            let on: u64 = burst.pulses().map(|(start, end)| end - start).sum();
            assert_eq!(burst.on(), on);
        }
        // By hand: 1000 + floor(k * 33333 1/3), widths floor(7 k / 13).
        let burst = bursts()[0];
        assert_eq!([burst.start(1), burst.start(2), burst.start(3)], [34_333, 67_666, 101_000]);
        assert_eq!(burst.on(), 7_000 / 13);
    }

    #[test]
    fn a_full_burst_is_full_whatever_is_left_over() {
        let period = count(10, 1, 3);
        for width in [period, count(10, 2, 6), count(11, 0, 1)] {
            let after = Remainder::NONE.after(period, 2);
            let burst = Burst { period_remainder: after, ..Burst::new(50, 7, Train { period, width }) };
            assert!(burst.pulses().zip(burst.pulses().skip(1)).all(|(one, next)| one.1 == next.0));
            assert_eq!((burst.start(7), burst.on()), (50 + 73, 73), "{width:?}");
        }
    }

    #[test]
    fn patterns_go_on_where_the_denominator_stays() {
        let counts =
            [count(10, 1, 3), count(20, 2, 3), count(20, 2, 3), count(5, 0, 0), count(7, 1, 3), count(7, 3, 4)];
        let (mut machine, mut rest) = (Pattern::BEGIN, Remainder::NONE);
        for period in counts {
            let width = count(0, 0, 0);
            assert_eq!(rest.sum(period, 1), machine.step(&Train { period, width }).0, "{period:?}");
            rest = rest.after(period, 1);
        }
    }

    #[test]
    fn a_burst_can_be_entered_anywhere() {
        for burst in bursts() {
            let pulses: Vec<_> = burst.pulses().collect();
            for k in [0, 1, 2, 3, 500, 998, 999] {
                for back in [0, 1, 300, 20_000] {
                    let t = pulses[k].0.saturating_sub(back);
                    let rest = burst.skip(burst.first_from(t));
                    let expected: Vec<_> = pulses.iter().copied().filter(|(start, _)| *start >= t).collect();
                    assert_eq!(rest.pulses().collect::<Vec<_>>(), expected, "{k} {back}");
                }
            }
            assert_eq!(burst.first_from(0), 0);
            assert_eq!(burst.first_from(u64::MAX), 1_000);
            assert_eq!(burst.skip(1_000).count, 0);
        }
    }

    #[test]
    fn long_runs_lose_nothing() {
        // 1 + 1/3 ns for ten days, and the least fraction there is.
        let third = Burst::new(0, u64::MAX, Train { period: count(1, 1, 3), width: count(1, 0, 0) });
        assert_eq!(third.start(3 << 50), 4 << 50);
        assert_eq!(third.first_from(4 << 50), 3 << 50);
        let fine = Burst::new(0, u64::MAX, Train { period: count(500, 1, 0), width: count(1, 0, 0) });
        assert_eq!(fine.start(1 << 32), (500 << 32) + 1);
        assert_eq!(fine.start((1 << 32) - 1), 500 * ((1 << 32) - 1));
    }
}
