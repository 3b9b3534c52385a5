//! Random plans of a channel for tests of the cycles that timers make of them.
#![allow(dead_code, reason = "each test uses its part")]
#[path = "../../../servo/tests/chance/mod.rs"]
mod chance;

use chance::Chance;
use servo::laser::{Action, Count, LaserPlan, PLAN_ACTIONS, PulseRate, Train};
use servo::output::{DelayLine, Scale};
use std::sync::atomic::AtomicU32;

pub const MHZ: u16 = 240;
pub const SCALE: Scale = Scale::of_mhz(MHZ);

pub fn counts(ns: u32) -> u64 {
    (u64::from(ns) * u64::from(MHZ) + 500) / 1000
}

/// Room for any plan at all: actions of nine words.
pub fn held() -> DelayLine {
    DelayLine::new((0..PLAN_ACTIONS * 9).map(|_| AtomicU32::new(0)).collect::<Vec<_>>().leak())
}

/// Instant at which the first cycles begin: before it the plans are empty.
pub const BEGIN_COUNTS: u64 = 336;

pub struct Random {
    pub chance: Chance,
    /// Pulses nearly as wide as their periods, too, and of less than a count: which of them touch
    /// the next one, or exist, depends on their order.
    pub extreme: bool,
}

impl Random {
    pub fn new(seed: u64) -> Random {
        Random { chance: Chance::new(seed), extreme: true }
    }

    pub fn below(&mut self, bound: u64) -> u64 {
        self.chance.below(bound)
    }

    /// Evenly spread over the magnitudes of `from` to `to`.
    pub fn magnitude(&mut self, from: u64, to: u64) -> u64 {
        let exponent = (to as f64 / from as f64).ln() * self.below(1 << 20) as f64 / f64::from(1 << 20);
        ((from as f64 * exponent.exp()) as u64).clamp(from, to)
    }

    /// 2 MHz to a tenth of a Hz.
    fn train(&mut self) -> Train {
        if self.below(8) == 0 {
            return Train::NONE;
        }
        let longest = [1_000, 100_000, 2_400_000_000][self.below(3) as usize];
        let whole = if self.below(3) == 0 { 120 } else { self.magnitude(120, longest) };
        let of = [0, 7, 12, 10_000][self.below(4) as usize];
        let count = |random: &mut Random, whole| {
            let part = random.below(if of == 0 { 1 << 32 } else { u64::from(of) }) as u32;
            Count { whole, part: if random.below(2) == 0 { part } else { 0 }, of }
        };
        let period = count(self, whole);
        let wide = match self.below(6) {
            0 => 0,
            1 if self.extreme => whole - 1,
            2 => return Train { period, width: period },
            3 => self.magnitude(1, whole - 2),
            _ => self.below(whole - 1),
        };
        let width = count(self, wide);
        Train { period, width: if wide == 0 && !self.extreme { Count { part: 0, ..width } } else { width } }
    }

    fn action(&mut self) -> Action {
        let train = self.train();
        match self.below(5) {
            0 => Action::Light(train),
            1 => {
                Action::Dark { standby: if self.below(2) == 0 { Train::NONE } else { train }, cut: self.below(2) == 0 }
            }
            2 => Action::Switch(self.below(2) == 0),
            3 if self.below(3) == 0 => self.rate(train),
            _ => Action::Change(train),
        }
    }

    /// A rate, or a pause; the remainder of the period in progress becomes up to eight times as
    /// long.
    fn rate(&mut self, train: Train) -> Action {
        if train.is_none() {
            return Action::Rate(PulseRate::PAUSE);
        }
        let period = Count { of: 0, ..train.period };
        let width = train.width.whole.min(period.whole - 1) as u32;
        let scale = 1 << 63 | self.below(1 << 31) << 32;
        Action::Rate(PulseRate { period, width, scale, shift: 60 + self.below(4) as u32 })
    }

    pub fn plan(&mut self, lasts: u32) -> LaserPlan {
        let mut plan = LaserPlan::EMPTY;
        plan.lasts = lasts;
        let actions = match self.below(20) {
            0 => PLAN_ACTIONS as u64,
            1..6 => self.below(6),
            _ => 0,
        };
        let mut instants: Vec<u64> = (0..actions).map(|_| self.below(lasts.into())).collect();
        // Some close together, and on the interval's own beginning.
        for at in 1..instants.len() {
            if self.below(3) == 0 {
                instants[at] = (instants[at - 1] + self.below(600)).min(u64::from(lasts) - 1);
            }
        }
        if let Some(first) = instants.first_mut().filter(|_| self.below(2) == 0) {
            *first = 0;
        }
        instants.sort();
        for at in instants {
            let action = self.action();
            plan.add(at as u32, action);
        }
        plan
    }
}
