#![no_std]
#![forbid(unsafe_code)]
//! The machine of the boards that have none: every axis follows its set-point with a first-order
//! lag.
//!
//! In: set-points in 2⁻²² pulse, one advance a tick. Out: encoder counts in whole pulses. Owns the
//! lag's state and nothing else. All integer, so that the virtual and the emulated board read the
//! same encoders to the bit. Fails never: every `i64` set-point is followed, and a settled axis is
//! exactly at its set-point (there is no dead band).
//!
//! Between two ticks the set-point is held. With x the encoder shaft, s the set-point in force and
//! T the tick period: `x(t + T) = s + (x(t) − s)·e^(−T/τ)`. This is the exact solution of `τ·x' = s
//! − x` up to the rounding of one step (2⁻²² pulse).

pub mod beam;
pub mod inputs;
pub mod pulses;

/// Fraction bits of a set-point.
pub const FRAC_BITS: u32 = 22;

/// Time constant τ of every axis, in ns: 1 ms, a stiff servo drive.
pub const TIME_CONSTANT_NS: u32 = 1_000_000;

/// Counts from one index edge of an encoder to the next; there is one at count 0.
pub const INDEX_COUNTS: i64 = 10_000;

/// The last index edge that an encoder has passed or reached from `before`, where there was none to
/// pass, to `now`.
pub const fn index_edge(before: i64, now: i64) -> Option<i64> {
    let edge = if now >= before {
        now.div_euclid(INDEX_COUNTS) * INDEX_COUNTS
    } else {
        (now + INDEX_COUNTS - 1).div_euclid(INDEX_COUNTS) * INDEX_COUNTS
    };
    if now > before && edge > before || now < before && edge < before { Some(edge) } else { None }
}

/// The fraction of its distance to the set-point that an axis moves in one tick: 1 − e^(−T/τ) in
/// 2⁻³².
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Gain(u32);

impl Gain {
    /// The gain for a tick period in ns. A period beyond 16 ms is taken as 16 ms (the axis arrives
    /// in one tick either way: e⁻¹⁶ is a tenth of a millionth).
    ///
    /// The error against the real number is at most 2⁻³², the unit of the result
    /// (`gain_is_the_exponential`).
    pub const fn of_period(period_ns: u32) -> Gain {
        const ONE: u128 = 1 << 60;
        let limit = 16 * TIME_CONSTANT_NS;
        let period = if period_ns > limit { limit } else { period_ns };
        // e^(−x) = (e^(−x/16))^16 with x/16 ≤ 1, where the series falls by a factor of n a term:
        // 1/24! is below 2⁻⁶⁰ · 2⁻¹⁸.
        let x = (period as u128 * ONE) / (TIME_CONSTANT_NS as u128 * 16);
        let mut positive = ONE;
        let mut negative = 0u128;
        let mut term = ONE;
        let mut n = 1u128;
        while n < 24 {
            term = (term * x / n) >> 60;
            if n & 1 == 1 {
                negative += term;
            } else {
                positive += term;
            }
            n += 1;
        }
        let mut power = positive - negative;
        let mut squarings = 0;
        while squarings < 4 {
            power = (power * power) >> 60;
            squarings += 1;
        }
        let gain = (ONE - power) >> 28;
        Gain(if gain > u32::MAX as u128 { u32::MAX } else { gain as u32 })
    }

    /// The gain in 2⁻³².
    pub const fn bits(self) -> u32 {
        self.0
    }
}

/// One axis: a shaft that follows its set-point with a lag.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Lag {
    /// Position of the shaft, in 2⁻²² pulse.
    shaft: i64,
    /// The set-point in force since the last tick.
    in_force: i64,
    /// The set-point in force from the next tick on.
    next: i64,
}

impl Lag {
    /// An axis at rest at zero.
    pub const STANDSTILL: Lag = Lag { shaft: 0, in_force: 0, next: 0 };

    /// The set-point in force from the next tick on, in 2⁻²² pulse.
    pub fn set_point(&mut self, pos: i64) {
        self.next = pos;
    }

    /// One tick passes: the shaft moves towards the set-point that was in force, and the one given
    /// last comes into force.
    pub fn advance(&mut self, gain: Gain) {
        let distance = self.in_force.saturating_sub(self.shaft);
        if distance != 0 {
            self.shaft = self.shaft.wrapping_add(share(distance, gain));
        }
        self.in_force = self.next;
    }

    /// What the encoder counts now: the nearest whole pulse.
    pub fn encoder(&self) -> i64 {
        self.shaft.wrapping_add(1 << (FRAC_BITS - 1)) >> FRAC_BITS
    }
}

/// `distance · gain`, rounded away from zero so that the last 2⁻²² pulse is reached too, never
/// further than `distance`.
fn share(distance: i64, gain: Gain) -> i64 {
    let gain = u64::from(gain.0);
    let magnitude = distance.unsigned_abs();
    // 64 × 32 bits in two products, as the Cortex-M7 has them; both sums stay below 2⁶⁴.
    let high = (magnitude >> 32).wrapping_mul(gain);
    let low = (magnitude & 0xffff_ffff).wrapping_mul(gain).wrapping_add(0xffff_ffff) >> 32;
    let part = high.wrapping_add(low) as i64;
    if distance < 0 { part.wrapping_neg() } else { part }
}

/// A machine of `AXES` lags, all zero at power-on.
#[derive(Debug, Clone)]
pub struct Plant<const AXES: usize> {
    axes: [Lag; AXES],
}

impl<const AXES: usize> Plant<AXES> {
    /// All axes at rest at zero.
    pub const fn new() -> Self {
        Plant { axes: [Lag::STANDSTILL; AXES] }
    }

    /// One tick passes for all axes. Call it at the beginning of the tick, before encoders are
    /// read.
    pub fn advance(&mut self, gain: Gain) {
        for axis in &mut self.axes {
            axis.advance(gain);
        }
    }

    /// The set-point of an axis (from 0) in force from the next tick on, in 2⁻²² pulse. An axis
    /// that the machine does not have is not moved.
    pub fn set_point(&mut self, axis: usize, pos: i64) {
        if let Some(lag) = self.axes.get_mut(axis) {
            lag.set_point(pos);
        }
    }

    /// The set-point that [`Plant::set_point`] was given last; 0 for an axis that the machine does
    /// not have.
    pub fn set_point_of(&self, axis: usize) -> i64 {
        self.axes.get(axis).map_or(0, |lag| lag.next)
    }

    /// Encoder count of an axis (from 0) in pulses; 0 for an axis that the machine does not have.
    pub fn encoder(&self, axis: usize) -> i64 {
        self.axes.get(axis).map_or(0, Lag::encoder)
    }
}

impl<const AXES: usize> Default for Plant<AXES> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;

    const PULSE: i64 = 1 << FRAC_BITS;
    const PERIODS_NS: [u32; 6] = [10_000, 50_000, 125_000, 250_000, 999_999, 1_000_000];

    #[test]
    fn an_index_edge_is_passed_in_either_direction() {
        for (before, now, edge) in [
            (0, 0, None),
            (0, 9999, None),
            (0, 10_000, Some(10_000)),
            (10_000, 10_001, None),
            (9_999, 35_000, Some(30_000)),
            (1, -1, Some(0)),
            (1, 0, Some(0)),
            (0, -9_999, None),
            (0, -10_000, Some(-10_000)),
            (-9_999, -35_000, Some(-30_000)),
            (-10_001, -9_999, Some(-10_000)),
        ] {
            assert_eq!(index_edge(before, now), edge, "{before} to {now}");
        }
    }

    #[test]
    fn gain_is_the_exponential() {
        for period in PERIODS_NS.into_iter().chain([0, 1, 16_000_000, u32::MAX]) {
            let x = f64::from(period.min(16_000_000)) / f64::from(TIME_CONSTANT_NS);
            let exact = -(-x).exp_m1() * 4294967296.0;
            let gain = f64::from(Gain::of_period(period).bits());
            assert!((gain - exact).abs() <= 1.0, "{period} ns: {gain} for {exact}");
        }
    }

    #[test]
    fn step_response_follows_the_exponential() {
        for period in PERIODS_NS {
            let gain = Gain::of_period(period);
            let mut lag = Lag::default();
            let target = 1_000_000 * PULSE;
            lag.set_point(target);
            lag.advance(gain); // comes into force
            assert_eq!(lag.encoder(), 0);
            for tick in 1..=40u32 {
                lag.advance(gain);
                let x = f64::from(tick) * f64::from(period) / f64::from(TIME_CONSTANT_NS);
                let exact = -(-x).exp_m1() * 1e6;
                let error = lag.shaft as f64 / PULSE as f64 - exact;
                assert!(error.abs() < 0.02, "{period} ns, tick {tick}: {error}");
            }
        }
    }

    #[test]
    fn settles_exactly_from_both_sides_also_at_the_edge_of_travel() {
        for period in PERIODS_NS {
            let gain = Gain::of_period(period);
            for target in [1, -1, PULSE / 2 + 1, 4096 * PULSE, -4096 * PULSE, 1 << 62, -(1 << 62)] {
                let mut lag = Lag::default();
                lag.set_point(target);
                // 2⁶² halves in 0.69 τ: 62 · 0.69 ms, and the last units go one a tick.
                let ticks = 60_000_000 / period + 2 * 1_000_000 / period + 2;
                for _ in 0..ticks {
                    lag.advance(gain);
                }
                assert_eq!(lag.shaft, target, "{period} ns to {target}");
                if target % PULSE == 0 {
                    assert_eq!(lag.encoder(), target / PULSE);
                }
            }
        }
    }

    #[test]
    fn a_ramp_is_followed_one_time_constant_later() {
        // Held set-points lag by half a tick more on average: v·(T/(1 − e^(−T/τ)) − T) behind the
        // one in force.
        for period in PERIODS_NS {
            let gain = Gain::of_period(period);
            let mut lag = Lag::default();
            let per_tick = i64::from(period) * 2 * PULSE / 1_000_000; // 2 pulse/ms
            for tick in 0..2_000_000 / i64::from(period) * 20 {
                lag.set_point(per_tick * tick);
                lag.advance(gain);
            }
            let t = f64::from(period) / 1e6;
            let exact = 2.0 * (t / (1.0 - (-t).exp()));
            let behind = (lag.in_force - lag.shaft) as f64 / PULSE as f64;
            assert!((behind - exact).abs() < 1e-3, "{period} ns: {behind} for {exact}");
        }
    }

    #[test]
    fn share_never_overshoots_and_never_rests() {
        for gain in [Gain(1), Gain::of_period(10_000), Gain(u32::MAX)] {
            for distance in [1, 2, 3, 1 << 31, (1 << 32) + 1, i64::MAX] {
                let part = share(distance, gain);
                assert!(part >= 1 && part <= distance, "{distance}: {part}");
                assert_eq!(share(-distance, gain), -part);
            }
        }
    }

    #[test]
    fn an_axis_beyond_the_machine_reads_zero() {
        let mut plant = Plant::<2>::new();
        plant.set_point(2, PULSE);
        plant.set_point(1, PULSE);
        let gain = Gain::of_period(16_000_000);
        for _ in 0..4 {
            plant.advance(gain);
        }
        assert_eq!([plant.encoder(0), plant.encoder(1), plant.encoder(2)], [0, 1, 0]);
    }
}
