//! The filter of a master: a lag of first order (docs/follow.md), for a master that moves evenly
//! between ticks.
//!
//! For u = tick/τ and a displacement d the lag l becomes l·exp(−u) + d·(1 − exp(−u))/u.
use super::number::Fix;

/// τ, ns.
const TIME_CONSTANT_NS: i64 = 1 << 22;

/// See the module text.
#[derive(Debug, Clone)]
pub struct Filter {
    master: Fix,
    lag: Fix,
    /// The last tick's period in τ, and (1 − exp(−u))/u of it.
    tick: (i64, Fix, Fix),
    /// Filtered positions at the tick before and at this one.
    pub track: [Fix; 2],
}

/// (1 − exp(−u))/u = 1 − u/2·(1 − u/3·(1 − …)).
fn share(u: Fix) -> Fix {
    (2..=30).rev().fold(Fix::ONE, |sum, k| Fix::ONE - (u * sum).over(Fix::whole(k)))
}

impl Filter {
    /// It begins where its master is.
    pub fn new(master: Fix) -> Filter {
        Filter { master, lag: Fix::ZERO, tick: (0, Fix::ZERO, Fix::ONE), track: [master; 2] }
    }

    /// A tick, after which the master is here.
    pub fn step(&mut self, master: Fix, tick_ns: i64) {
        if self.tick.0 != tick_ns {
            let u = Fix::whole(tick_ns).over(Fix::whole(TIME_CONSTANT_NS));
            self.tick = (tick_ns, u, share(u));
        }
        let (_, u, share) = self.tick;
        self.lag += (master - self.master - self.lag * u) * share;
        self.master = master;
        self.track = [self.track[1], master - self.lag];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// After a step of 1 in a tick the gap decays by exp(−t/τ); behind a constant speed it is
    /// speed·τ; and the period of the tick does not count.
    #[test]
    fn decays_and_lags() {
        for tick in [50_000, 250_000, 1_000_000] {
            let mut filter = Filter::new(Fix::ZERO);
            filter.step(Fix::ONE, tick);
            let first = filter.lag.to_f64();
            let n = 20_000_000 / tick;
            (0..n).for_each(|_| filter.step(Fix::ONE, tick));
            let decay = (-20_000_000.0 / TIME_CONSTANT_NS as f64).exp();
            assert!((filter.lag.to_f64() - first * decay).abs() < 1e-15, "{tick}");
            let mut filter = Filter::new(Fix::ZERO);
            for k in 1..=100_000_000 / tick {
                filter.step(Fix::ms(tick * k), tick);
            }
            assert!((filter.lag.to_f64() - 4.194304).abs() < 1e-9, "{tick}");
        }
    }
}
