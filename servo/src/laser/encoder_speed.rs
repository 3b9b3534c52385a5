//! The speed of the encoders of a path: filtered, so that single counts make no flicker (SPEC 6,
//! "Energy").
//!
//! In: the counts of each encoder in a tick. Out: a [`PathSpeed`]. Owns the filtered velocities.
//! Fails never.
//!
//! Each velocity goes through a lag of first order of the same time constant, and the norm is that
//! of the filtered ones: the norm of single counts would be too large for slow paths across two
//! axes. Once a channel follows an encoder, the filter runs in every tick of the path, lit or not.
//! It begins with the path at 0, or with the velocity of the tick in which it is first requested.
use super::PathSpeed;
use crate::math::wide::{mulhi_su, umulhi};
use crate::segment::follow::share;
use crate::units::Ns;

/// The share of a new velocity in a tick without a filter.
const FULL_SHARE_Q64: u64 = u64::MAX;

/// The inverse of a filter's time constant, in 2⁻⁶⁴ per ns; 0 is none, no filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FilterRate(u64);

impl FilterRate {
    /// No filter.
    pub const NONE: FilterRate = FilterRate(0);
    /// 1 ms.
    pub const POWER_ON: FilterRate = FilterRate((1 << 63) / 500_000);

    /// From the inverse of a time constant of 2 ns at least.
    pub const fn of_inverse(inverse: u64) -> FilterRate {
        FilterRate(inverse)
    }
}

crate::state! {
    /// The filtered velocities of the coordinates of a path.
    #[derive(Debug, Clone, Copy)]
    pub(crate) struct EncoderSpeed {
        /// A channel has followed it: it has to run in every tick.
        pub(crate) used: bool = false,
        /// The tick up to which it goes on; in any other tick the velocity is taken as it is.
        next: Ns = Ns(0),
        /// The path begins with that tick.
        begins: bool = false,
        lag: FilterRate = FilterRate::POWER_ON,
        /// The period for which `share` was computed.
        period: Ns = Ns(0),
        /// The share of a new velocity in a tick, 2⁻⁶⁴.
        share: u64 = FULL_SHARE_Q64,
        /// 2⁻²⁸ pulse a tick.
        velocity: [i64; 4] = [0; 4],
    }
    pub(crate) const POWER_ON;
}

impl EncoderSpeed {
    /// Another time constant.
    pub(crate) fn set(&mut self, lag: FilterRate) {
        (self.lag, self.period) = (lag, Ns(0));
    }

    /// The path begins, at standstill, with the tick `next`.
    pub(crate) fn begin(&mut self, next: Ns) {
        (self.next, self.begins, self.velocity) = (next, true, [0; 4]);
    }

    /// A tick of `period` has passed at `now`, with these counts of the encoders. `follows`: a
    /// channel follows them now, and not only may from within the coming interval on.
    pub(crate) fn step(&mut self, pulses: [i64; 4], (now, period): (Ns, Ns), follows: bool) -> PathSpeed {
        if period != self.period {
            (self.period, self.share) = (period, self.lag.share(period));
        }
        self.used |= follows;
        let goes_on = now == self.next && (self.used || self.begins);
        let share = if goes_on { self.share } else { FULL_SHARE_Q64 };
        self.begins = false;
        self.next = Ns(now.0.wrapping_add(period.0));
        for (velocity, by) in self.velocity.iter_mut().zip(pulses) {
            let new = by.clamp(-(u32::MAX as i64), u32::MAX as i64) << PathSpeed::COUNT_BITS;
            *velocity = match share {
                FULL_SHARE_Q64 => new,
                // Twice the gap, and half of the remainder: to the nearest.
                _ => velocity.wrapping_add(mulhi_su(new.wrapping_sub(*velocity) << 1, share).wrapping_add(1) >> 1),
            };
        }
        PathSpeed::measured(self.velocity, period)
    }
}

impl FilterRate {
    /// 1 − exp(−period/τ), 2⁻⁶⁴.
    #[inline(never)]
    fn share(self, period: Ns) -> u64 {
        let mut u = (self.0 as u128).wrapping_mul(period.0 as u128);
        if self.0 == 0 || u >> 64 >= 44 {
            return FULL_SHARE_Q64;
        }
        // exp(−u) is the square of exp(−u/2), and so on: the series needs u below a quarter.
        let mut halved = 0;
        while u >> 62 != 0 {
            (u, halved) = (u >> 1, halved + 1u32);
        }
        let mut remainder = !umulhi(u as u64, share(u as u64));
        for _ in 0..halved {
            remainder = umulhi(remainder, remainder);
        }
        !remainder
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_bigint::BigInt;

    /// Fraction bits of what is exact here.
    const BITS: u32 = 256;

    /// Of a time constant in µs.
    fn lag(us: u64) -> FilterRate {
        FilterRate::of_inverse(((1u128 << 64) / (us as u128 * 1000)) as u64)
    }

    /// exp(−num/den), 2⁻²⁵⁶, to 2⁻²³⁰ and better: a series of the 1024th part, squared ten times.
    fn exp_of_minus(num: u64, den: u64) -> BigInt {
        let u = (BigInt::from(num) << (BITS - 10)) / den;
        let (mut term, mut sum) = (BigInt::from(1) << BITS, BigInt::from(0));
        for k in 1..60 {
            sum += &term;
            term = (-(&term * &u) >> BITS) / k;
        }
        for _ in 0..10 {
            sum = (&sum * &sum) >> BITS;
        }
        sum
    }

    /// Against the exponential, over all time constants and periods that can be set.
    #[test]
    fn a_tick_counts_by_the_time_constant() {
        assert_eq!(FilterRate::POWER_ON, lag(1000));
        for tau_us in [10, 100, 250, 1000, 3000, 100_000, 1_000_000] {
            for us in [10, 20, 50, 250, 500, 1000] {
                let share = BigInt::from(lag(tau_us).share(Ns(us * 1000))) << (BITS - 64);
                let want = (BigInt::from(1) << BITS) - exp_of_minus(us, tau_us);
                let off = (&share - &want).magnitude() * 10_000_000_000u64;
                assert!(&off < want.magnitude(), "{tau_us} us, tick {us} us: {share}, not {want}");
            }
        }
        assert_eq!(FilterRate::NONE.share(Ns(10_000)), FULL_SHARE_Q64);
    }

    /// A step of the velocity has arrived to 1 − 1/e after the time constant, whatever the tick is.
    #[test]
    fn a_step_is_answered_in_the_time_constant() {
        for us in [10u64, 50, 250] {
            let mut speed = EncoderSpeed::POWER_ON;
            speed.begin(Ns(0));
            let counts = us as i64 * 3;
            let mut found = PathSpeed::STANDSTILL;
            for tick in 0..1000 / us {
                let at = (Ns(tick * us * 1000), Ns(us * 1000));
                found = speed.step([counts, 0, -(us as i64) * 4, 0], at, true);
            }
            // 2⁻³⁰ pulse/ms, to a thousandth.
            let want: BigInt = (((BigInt::from(1) << BITS) - exp_of_minus(1, 1)) * 5000) >> (BITS - 30);
            let off = BigInt::from(found.raw()) - &want;
            assert!(off.magnitude() < &(1u32 << 20).into(), "{us} us: {found:?}, not {want}");
        }
    }

    /// Ticks before the one in which it is chosen leave nothing behind, also those in which an
    /// entry might have chosen it.
    #[test]
    fn it_begins_with_the_tick_before_it_is_chosen() {
        let at = |tick: u64| (Ns(tick * 1_000_000), Ns(1_000_000));
        let mut speed = EncoderSpeed::POWER_ON;
        speed.begin(Ns(0));
        assert!(speed.step([1000, 0, 0, 0], at(0), false).raw() < 700 << 30, "a path begins at 0");
        assert_eq!(speed.step([2000, 0, 0, 0], at(1), false).raw(), 2000 << 30);
        assert_eq!(speed.step([3000, 0, 0, 0], at(2), false).raw(), 3000 << 30);
        let chosen = speed.step([4000, 0, 0, 0], at(3), true).raw();
        assert!((3600 << 30..3700 << 30).contains(&chosen), "{chosen}");
        let after = speed.step([4000, 0, 0, 0], at(4), false).raw();
        assert!((3800 << 30..3900 << 30).contains(&after), "{after}");
    }

    /// One count is a thousandth of its unfiltered value, in a tick of 10 us, and decays to
    /// nothing.
    #[test]
    fn one_count_is_no_flicker() {
        let mut speed = EncoderSpeed::POWER_ON;
        speed.begin(Ns(0));
        let at = |tick: u64| (Ns(tick * 10_000), Ns(10_000));
        let first = speed.step([1, 0, 0, 0], at(0), true).raw();
        assert!(((9 << 30) / 10..1 << 30).contains(&first), "{first} of 100 << 30");
        let mut last = PathSpeed::STANDSTILL;
        for tick in 1..3000 {
            last = speed.step([0; 4], at(tick), true);
        }
        assert!(last.raw() < 1 << 16, "{last:?}");
        // Without a filter it is the tick's.
        speed.set(FilterRate::NONE);
        assert_eq!(speed.step([1, 0, 0, 0], at(3000), true).raw(), 100 << 30);
        assert_eq!(speed.step([0; 4], at(3001), true), PathSpeed::STANDSTILL);
    }
}
