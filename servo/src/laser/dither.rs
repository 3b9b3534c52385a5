//! Frequencies and duties as counts of the machine's timer, exact in the mean (SPEC 11).
//!
//! In: powers, frequencies, the timer's clock. Out: [`Count`]s: whole counts, and the part of the
//! periods that have one more. [`Pattern`] turns them into the counts of each period: that is what
//! the machines do. Owns nothing. Fails: a frequency of 0 is refused.
//!
//! Values that the thread knows ahead (a carrier, standby, a fixed power) repeat after the fewest
//! periods that hold [`PPM`] and [`DUTY_STEPS`]; values that change from tick to tick have 32
//! fraction bits.
use super::PowerMode;
use super::actions::{Count, PulseRate, Train};
use super::power::{Power, Refused};
use crate::math::wide::{Divisor, Recip, umul, umulhi};

/// A frequency is off by at most one part in this many.
pub const PPM: u64 = 1_000_000;
/// A duty is off by at most one part in this many of the period: 0.001 %.
pub const DUTY_STEPS: u64 = 100_000;
/// The most periods of a repetition: at 100 counts per µs a period of 2 MHz has 50 counts, of which
/// 10⁻⁶ is half a count after 10⁴ periods, and half a count is 10⁻⁵ of 1000 periods.
const REPETITION_MAX_PERIODS: u32 = 10_000;
/// A period this long holds any duty.
const ANY_DUTY_MIN_COUNTS: u64 = 1 << 40;

/// The clock of the machine's timers: counts per µs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Clock {
    mhz: u16,
}

impl Clock {
    /// 1 GHz, the clock of the virtual and of the emulated board: a count is a ns.
    pub const GHZ: Clock = Clock { mhz: 1000 };

    /// A clock of 100 to 1000 MHz.
    pub const fn from_mhz(mhz: u16) -> Option<Clock> {
        if mhz >= 100 && mhz <= 1000 { Some(Clock { mhz }) } else { None }
    }

    /// Counts per µs.
    pub const fn mhz(self) -> u16 {
        self.mhz
    }

    /// Counts per ms in 2⁻⁴⁴: divided by a frequency's [`Power::raw`] they are its period. At most
    /// 2⁶⁴.
    const fn per_ms(self) -> u64 {
        (self.mhz as u64 * 1000) << Power::FRAC_BITS
    }

    /// The period of a rate, rounded up to 2⁻³² counts, so that whole counts, and whole counts of
    /// several periods, stay whole; for 0 that of the least rate.
    pub fn period(self, khz: Power) -> Count {
        let Recip { m, shift } = Recip::of(khz.raw() as u64);
        let per_ms = self.per_ms();
        // per_ms·(2^64 + m)·2^(shift - 128) in 2^-32; the shift is at most 63.
        let product = (per_ms as u128).wrapping_add(umul(per_ms, m).0 as u128);
        let down = 64u32.wrapping_sub(shift);
        let up = 1u128.wrapping_shl(down).wrapping_sub(1);
        let fixed = (product << 32).wrapping_add(up).wrapping_shr(down);
        Count { whole: (fixed >> 32) as u64, part: fixed as u32, of: 0 }
    }

    /// The rate after one of `before` (0: none), whose period is `period`.
    pub(super) fn rate(before: Power, now: Power, period: Count, width: u32) -> PulseRate {
        if before == Power::ZERO {
            return PulseRate { period, width, ..PulseRate::PAUSE };
        }
        // before/now; it is rounded down by less than two units of 2^-64.
        let Recip { m, shift } = Recip::of(now.raw() as u64);
        let up = (before.raw() as u64).leading_zeros();
        let before = (before.raw() as u64).wrapping_shl(up);
        let (sum, carry) = before.overflowing_add(umulhi(before, m));
        let scale = if carry { sum >> 1 | 1 << 63 } else { sum };
        let shift = up.wrapping_add(64).wrapping_sub(shift).wrapping_sub(carry as u32);
        PulseRate { period, width, scale: scale.saturating_add(2), shift }
    }
}

/// Repetitions of a frequency, from one period up.
struct Repetitions {
    /// 2⁻⁴⁴ kHz.
    khz: u64,
    /// A period is whole + remainder/khz counts.
    whole: u64,
    remainder: u64,
    /// This many periods are total + over/khz counts.
    periods: u32,
    total: u64,
    over: u64,
}

impl Repetitions {
    fn of(khz: Power, clock: Clock) -> Repetitions {
        let (per_ms, khz) = (clock.per_ms(), (khz.raw() as u64).max(1));
        Repetitions { khz, whole: per_ms / khz, remainder: per_ms % khz, periods: 0, total: 0, over: 0 }
    }

    /// The next one: its periods, the whole counts nearest to their sum, and whether that is exact
    /// to [`PPM`].
    fn step(&mut self) -> (u32, u64, bool) {
        self.periods += 1;
        self.total = self.total.saturating_add(self.whole);
        self.over += self.remainder;
        if self.over >= self.khz {
            self.over -= self.khz;
            self.total = self.total.saturating_add(1);
        }
        let below = self.khz - self.over;
        let (counts, off) =
            if self.over >= below { (self.total.saturating_add(1), below) } else { (self.total, self.over) };
        (self.periods, counts, off as u128 * PPM as u128 <= counts as u128 * self.khz as u128)
    }

    /// The shortest one that is exact to [`PPM`] and that `fits` accepts.
    fn shortest<T>(mut self, mut fits: impl FnMut(u64) -> Option<T>) -> (u32, u64, Option<T>) {
        loop {
            let (periods, counts, exact) = self.step();
            if exact && let Some(it) = fits(counts) {
                return (periods, counts, Some(it));
            }
            if periods >= REPETITION_MAX_PERIODS {
                return (periods, counts, None);
            }
        }
    }
}

/// Counts spread over a repetition.
fn spread(counts: u64, periods: u32) -> Count {
    let of = periods.max(1);
    Count { whole: counts / of as u64, part: (counts % of as u64) as u32, of }
}

/// A duty of this many counts, to the nearest; none if that is not within [`DUTY_STEPS`].
fn active(counts: u64, duty: Power) -> Option<u64> {
    if counts >= ANY_DUTY_MIN_COUNTS {
        // Exact enough in any case, and too long for the products below.
        return Some((counts as u128 * duty.raw() as u128 / FULL_DUTY_RAW as u128) as u64);
    }
    let product = counts as u128 * duty.raw() as u128;
    let half_up = product + (FULL_DUTY_RAW / 2) as u128;
    let nearest = (half_up >> Power::FRAC_BITS) as u64 / 100;
    // One more unit of power, so that the user's own number is within, too.
    let off = (nearest as u128 * FULL_DUTY_RAW as u128).abs_diff(product) + counts as u128;
    (off * DUTY_STEPS as u128 <= counts as u128 * FULL_DUTY_RAW as u128).then_some(nearest)
}

/// 100 %.
const FULL_DUTY_RAW: u64 = 100 << Power::FRAC_BITS;

/// The train of a fixed frequency and duty with the shortest repetition.
fn fixed(khz: Power, duty: Power, clock: Clock) -> Train {
    let duty = duty.min(PowerMode::Duty.full_scale());
    let (periods, counts, width) = Repetitions::of(khz, clock).shortest(|counts| active(counts, duty));
    Train { period: spread(counts, periods), width: spread(width.unwrap_or(0), periods) }
}

/// The period of a fixed frequency with the shortest repetition.
fn fixed_period(khz: Power, clock: Clock) -> Count {
    let (periods, counts, _) = Repetitions::of(khz, clock).shortest(|_| Some(()));
    spread(counts, periods)
}

/// Whether it may be a carrier.
fn is_rate(khz: Power) -> Result<(), Refused> {
    if khz == Power::ZERO { Err(Refused::Zero) } else { Ok(()) }
}

/// The carrier of the duty modes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Carrier {
    khz: Power,
    period: Count,
    /// The part of the period, in 2⁻³² counts.
    pub(super) fraction: u32,
    /// Width per power, 2⁻³² counts by 2⁻⁴⁴ %, in 2⁻⁶⁴; 0 of a period that is too long for that. It
    /// makes an error of less than 2⁻¹³ of 2⁻³² counts.
    pub(super) gain: u64,
}

/// Whole counts of a period that has a gain: 2¹⁸.
const GAIN_MAX_COUNTS: u64 = 1 << 18;

impl Carrier {
    /// A carrier of 0 < f ≤ 2000 kHz.
    pub fn admit(khz: Power, clock: Clock) -> Result<Carrier, Refused> {
        is_rate(khz)?;
        let period = fixed_period(khz, clock);
        let fraction = ((period.part as u64) << 32) / period.of.max(1) as u64;
        let fixed = ((period.whole as u128) << 32) + fraction as u128;
        let gain = if period.whole < GAIN_MAX_COUNTS { ((fixed << (64 - Power::FRAC_BITS)) / 100) as u64 } else { 0 };
        Ok(Carrier { khz, period, fraction: fraction as u32, gain })
    }

    /// Its frequency as it was requested.
    pub const fn khz(&self) -> Power {
        self.khz
    }

    /// Its period as it is output.
    pub const fn period(&self) -> Count {
        self.period
    }
}

/// Standby pulses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Standby {
    khz: Power,
    duty: Power,
    train: Train,
}

impl Standby {
    /// Pulses of 0 < f ≤ 2000 kHz and 0…100 % duty.
    pub fn admit(khz: Power, duty: Power, clock: Clock) -> Result<Standby, Refused> {
        is_rate(khz)?;
        if duty > PowerMode::Duty.full_scale() {
            return Err(Refused::BeyondRange);
        }
        Ok(Standby { khz, duty, train: fixed(khz, duty, clock) })
    }

    /// Frequency as it was requested.
    pub const fn khz(&self) -> Power {
        self.khz
    }

    /// Duty in % as it was requested.
    pub const fn duty(&self) -> Power {
        self.duty
    }

    /// As it is output.
    pub const fn train(&self) -> &Train {
        &self.train
    }
}

/// A fixed light planned ahead with the shortest repetition that is exact enough. It is advice: the
/// tick takes it while carrier and power are the ones it was planned for. Else it finds a train by
/// itself that is as exact and repeats later.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FixedTrain {
    /// The carrier.
    khz: Power,
    power: Power,
    train: Train,
}

impl FixedTrain {
    /// The plan of a power (held in its bounds) in the duty modes, over this carrier. None where
    /// there is nothing to plan: a rate keeps its phase over changes, to 2⁻³² counts
    /// ([`super::PulseRate`]).
    pub fn plan(mode: PowerMode, power: Power, carrier: Option<&Carrier>, clock: Clock) -> Option<FixedTrain> {
        match (mode, carrier) {
            (PowerMode::Duty | PowerMode::DutyOpen, Some(carrier)) => {
                Some(FixedTrain { khz: carrier.khz, power, train: fixed(carrier.khz, power, clock) })
            }
            _ => None,
        }
    }

    /// Whether it is for this carrier and power.
    #[inline]
    pub(super) fn is_of(&self, khz: Power, power: Power) -> bool {
        self.power == power && self.khz == khz
    }

    /// The power that it is for, if it is for this carrier.
    pub(super) fn power_over(&self, khz: Power) -> Option<Power> {
        (self.khz == khz).then_some(self.power)
    }

    /// As it is output.
    pub const fn train(&self) -> &Train {
        &self.train
    }
}

/// Spreads a [`Count`] over periods: the first n have ⌊n·count⌋ together.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Bresenham {
    gathered: u32,
    of: u32,
}

impl Bresenham {
    /// The counts of one more period. A new denominator begins anew.
    #[inline]
    fn step(&mut self, count: &Count) -> u64 {
        if self.of != count.of {
            *self = Bresenham { gathered: 0, of: count.of };
        }
        let (sum, carry) = self.gathered.overflowing_add(count.part);
        let over = carry || (count.of != 0 && sum >= count.of);
        self.gathered = if over { sum.wrapping_sub(count.of) } else { sum };
        count.whole.wrapping_add(over as u64)
    }
}

/// The counts of a train's periods, one after the other: machines count by these.
///
/// The first n periods have ⌊n·period⌋ counts together, their pulses ⌊n·width⌋. Counts of width
/// that do not fit into a period go to the next pulse (a width just below the period, whose odd
/// counts lie differently). In a full train ([`Train::is_full`]) each pulse is its period, whatever
/// other settings have left over, and no counts are owed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Pattern {
    period: Bresenham,
    width: Bresenham,
    /// Counts of width that did not fit into the period before.
    width_carry: u64,
}

impl Pattern {
    /// At the beginning of a train.
    pub const BEGIN: Pattern =
        Pattern { period: Bresenham { gathered: 0, of: 0 }, width: Bresenham { gathered: 0, of: 0 }, width_carry: 0 };

    /// For a rate, this many 2⁻³² counts of a period before the train's next one.
    pub const fn of_rate(part: u32) -> Pattern {
        Pattern { period: Bresenham { gathered: part, of: 0 }, ..Pattern::BEGIN }
    }

    /// The fraction left over by periods of a rate, 2⁻³² counts.
    pub const fn part(&self) -> u32 {
        if self.period.of == 0 { self.period.gathered } else { 0 }
    }

    /// One more period, and the width of its pulse, in counts.
    #[inline]
    pub fn step(&mut self, train: &Train) -> (u64, u64) {
        let period = self.period.step(&train.period);
        if self.width.of != train.width.of {
            self.width_carry = 0;
        }
        let wanted = self.width.step(&train.width).wrapping_add(self.width_carry);
        let width = wanted.min(period);
        self.width_carry = wanted.wrapping_sub(width);
        if train.is_full() {
            self.width_carry = 0;
            return (period, period);
        }
        (period, width)
    }

    /// Queues periods of a train whose counts are far below 2³², runs of equal ones at once, as
    /// [`TrainSteps::queue`] does. Returns the remaining counts, and the pattern after them.
    #[inline(never)]
    pub(crate) fn queue(
        &mut self,
        train: &Train,
        left: u32,
        alone: u32,
        sink: &mut impl FnMut(u32, u32, u32),
    ) -> (u32, (u32, u32)) {
        let mut steps = TrainSteps::of(self, train);
        let left = steps.queue(left, alone, sink);
        let next = steps.step();
        *self = steps.pattern();
        (left, next)
    }
}

/// Periods queued together at most. The repetition counter of TIM15 has 8 bits (RM0433 41.5.12).
/// And a pulse lies at most a quarter of so many counts from where it would be alone: within 0.3
/// ppm of a second at 240 MHz.
const TOGETHER_MAX_PERIODS: u32 = 256;

/// ⌊x / n⌋ below 2³². A function of its own: memory for the tick's code is scarce.
#[inline(never)]
fn divided(x: u64, n: u32) -> u32 {
    Divisor::new(n).floor(x)
}

/// One of a train's two counts in [`TrainSteps`].
#[derive(Debug, Clone, Copy)]
struct CountStep {
    whole: u32,
    part: u32,
    of: u32,
    gathered: u32,
}

impl CountStep {
    #[inline(always)]
    fn of(count: &Count, before: &Bresenham) -> CountStep {
        let Count { whole, part, of } = *count;
        let gathered = if before.of == of { before.gathered } else { 0 };
        CountStep { whole: whole as u32, part, of, gathered }
    }

    /// The next count.
    #[inline(always)]
    fn step(&mut self) -> u32 {
        let (sum, carry) = self.gathered.overflowing_add(self.part);
        let is_odd = carry || self.of != 0 && sum >= self.of;
        self.gathered = if is_odd { sum.wrapping_sub(self.of) } else { sum };
        self.whole.wrapping_add(is_odd as u32)
    }

    /// How many of the next `n` counts have one more; the accumulator goes on after them. Whoever
    /// makes a [`Count`] keeps its denominator below 2³¹, or 2³².
    #[inline(always)]
    fn odd(&mut self, n: u32) -> u32 {
        let sum = (self.gathered as u64).wrapping_add(n as u64 * self.part as u64);
        let (odd, left) = if self.part == 0 {
            (0, self.gathered)
        } else if self.of == 0 {
            ((sum >> 32) as u32, sum as u32)
        } else {
            let odd = divided(sum, self.of);
            (odd, (sum as u32).wrapping_sub(odd.wrapping_mul(self.of)))
        };
        self.gathered = left;
        odd
    }

    /// The accumulator.
    #[inline(always)]
    fn gathered(&self) -> Bresenham {
        Bresenham { gathered: self.gathered, of: self.of }
    }
}

/// The counts of the periods of a train, as many and as wide together as [`Pattern::step`] gives
/// them, if they are far below 2³² and the train does not change.
#[derive(Debug, Clone, Copy)]
struct TrainSteps {
    period: CountStep,
    width: CountStep,
    width_carry: u32,
    is_full: bool,
}

impl TrainSteps {
    /// A pattern continues with this train.
    #[inline(always)]
    fn of(before: &Pattern, train: &Train) -> TrainSteps {
        TrainSteps {
            period: CountStep::of(&train.period, &before.period),
            width: CountStep::of(&train.width, &before.width),
            width_carry: if before.width.of == train.width.of { before.width_carry as u32 } else { 0 },
            is_full: train.is_full(),
        }
    }

    /// One more period, and the width of its pulse.
    #[inline(always)]
    fn step(&mut self) -> (u32, u32) {
        let period = self.period.step();
        let wanted = self.width.step().wrapping_add(self.width_carry);
        let width = if self.is_full { period } else { wanted.min(period) };
        self.width_carry = if self.is_full { 0 } else { wanted.wrapping_sub(width) };
        (period, width)
    }

    /// Queues periods as far as they end within `left` counts and a longer one had room: length,
    /// width, and repetitions. Those that end `alone` counts before are queued together. Returns
    /// the remaining counts.
    #[inline(always)]
    fn queue(&mut self, left: u32, alone: u32, sink: &mut impl FnMut(u32, u32, u32)) -> u32 {
        let longest = self.period.whole.wrapping_add(1);
        let mut left = left;
        if let Some(mut room) = left.checked_sub(alone) {
            // As many as have room if all are long; what a part that is not full leaves goes alone.
            let mut n = TOGETHER_MAX_PERIODS;
            while n == TOGETHER_MAX_PERIODS {
                n = divided(room.into(), longest).min(n);
                let counts = self.queue_together(n, sink);
                (room, left) = (room.wrapping_sub(counts), left.wrapping_sub(counts));
            }
        }
        while longest <= left {
            let (period, width) = self.step();
            sink(period, width, 1);
            left = left.wrapping_sub(period);
        }
        left
    }

    /// Queues `n` periods; returns their counts. The longer ones come first, and so do the wider
    /// pulses: three runs at most (SPEC 11: their order within a tick is free).
    #[inline(always)]
    fn queue_together(&mut self, n: u32, sink: &mut impl FnMut(u32, u32, u32)) -> u32 {
        let (period, mut width) = (self.period.whole, self.width.whole);
        let long = self.period.odd(n);
        let mut wide = self.width.odd(n).wrapping_add(self.width_carry);
        self.width_carry = 0;
        if self.is_full {
            (width, wide) = (period, long);
        } else if width == period && wide > long {
            // No pulse is wider than its period.
            self.width_carry = wide.wrapping_sub(long);
            wide = long;
        }
        let (both, either) = (long.min(wide), long.max(wide));
        let (longer, wider) = ((long > wide) as u32, (wide > long) as u32);
        // From the longest and widest to the others: in a loop, as the code is scarce.
        let (mut up, mut left) = ([1, 1], [both, either.wrapping_sub(both), n.wrapping_sub(either)]);
        for _ in 0..3 {
            let [times, ..] = left;
            if times != 0 {
                sink(period.wrapping_add(up[0]), width.wrapping_add(up[1]), times);
            }
            (left, up) = ([left[1], left[2], 0], if up == [1, 1] { [longer, wider] } else { [0, 0] });
        }
        n.wrapping_mul(period).wrapping_add(long)
    }

    /// The pattern after these steps.
    #[inline(always)]
    fn pattern(&self) -> Pattern {
        Pattern { period: self.period.gathered(), width: self.width.gathered(), width_carry: self.width_carry.into() }
    }
}
