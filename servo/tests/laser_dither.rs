//! Frequencies and duties against exact rationals, over the whole range and for timers of 100 MHz
//! to 1 GHz: the mean over a repetition is within 1 ppm and 0.001 % (SPEC 11), and no shorter
//! repetition is.
use crate::{chance, laser_bench};
use chance::Chance;
use laser_bench::*;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};
use servo::laser::{
    Carrier, ChannelChange, Clock, Count, FixedTrain, Pattern, Power, PowerMode, Refused, Standby, Train,
};

fn ratio(n: u64, d: u64) -> BigRational {
    BigRational::new(n.into(), d.into())
}

fn exact(value: f64) -> BigRational {
    BigRational::from_float(value).unwrap()
}

fn counts(count: Count) -> BigRational {
    let of = if count.of == 0 { 1 << 32 } else { count.of as u64 };
    assert!((count.part as u64) < of);
    ratio(count.whole, 1) + ratio(count.part as u64, of)
}

fn clocks() -> [Clock; 3] {
    [1000, 240, 100].map(|mhz| Clock::from_mhz(mhz).unwrap())
}

/// Counts of the period of this frequency.
fn period(khz: f64, clock: Clock) -> BigRational {
    ratio(clock.mhz() as u64 * 1000, 1) / exact(khz)
}

fn ppm() -> BigRational {
    ratio(1, 1_000_000)
}

/// Whether the mean frequency of these periods is within 1 ppm.
fn rate_holds(of: &BigRational, khz: f64, clock: Clock) -> bool {
    // f_out/f - 1 = P/P_out - 1
    (period(khz, clock) / of - BigRational::one()).abs() <= ppm()
}

/// Whether the mean duty (0 to 1) is within 0.001 %.
fn duty_holds(train: &Train, percent: f64) -> bool {
    let duty = counts(train.width) / counts(train.period);
    (duty - exact(percent) / ratio(100, 1)).abs() <= ratio(1, 100_000)
}

/// Frequencies to look at: the ends of both families, their steps, round numbers, and any.
fn frequencies(chance: &mut Chance, some: usize) -> Vec<f64> {
    let mut all = vec![2000.0, 1999.999, 1000.0, 1000.0 / 3.0, 333.333, 100.0, 96.0, 95.994, 24.0, 23.9985, 7.0];
    all.extend([0.0015, 0.006, 1e-6, 0.1, 1.0, 10.0, 123.456, 1234.567, 1777.7]);
    all.extend((0..some).map(|_| chance.log(1e-4, 2000.0)));
    all.extend((0..some).map(|_| chance.unit() * 2000.0 + 1e-3));
    all
}

#[test]
fn fixed_pulses_are_exact_and_repeat_as_soon_as_they_can() {
    let mut chance = Chance::new(4);
    for clock in clocks() {
        for khz in frequencies(&mut chance, 300) {
            for percent in [0.0, 100.0, 50.0, 25.0, 33.333, 0.01, 0.001, 99.99, chance.unit() * 100.0] {
                let train = *Standby::admit(power(khz), power(percent), clock).unwrap().train();
                assert!(rate_holds(&counts(train.period), khz, clock), "{khz} kHz: {train:?}");
                assert!(duty_holds(&train, percent), "{khz} kHz, {percent} %: {train:?}");
                assert_eq!(train.period.of, train.width.of);
                assert!(train.period.of <= 10_000);
                if percent == 100.0 {
                    assert_eq!(train.width, train.period);
                }
                // A light of the same numbers is the same.
                let carrier = Carrier::admit(power(khz), clock).unwrap();
                for mode in [PowerMode::Duty, PowerMode::DutyOpen] {
                    let fixed = FixedTrain::plan(mode, power(percent), Some(&carrier), clock).unwrap();
                    assert_eq!(*fixed.train(), train);
                }
            }
        }
    }
}

#[test]
fn no_shorter_repetition_would_do() {
    let mut chance = Chance::new(5);
    for clock in clocks() {
        for khz in frequencies(&mut chance, 20) {
            let percent = chance.unit() * 100.0;
            let train = *Standby::admit(power(khz), power(percent), clock).unwrap().train();
            let alone = Carrier::admit(power(khz), clock).unwrap().period();
            let period = period(khz, clock);
            for n in 1..train.period.of as u64 {
                let total = (&period * ratio(n, 1)).round();
                let rate = rate_holds(&(&total / ratio(n, 1)), khz, clock);
                assert!(!rate || n >= alone.of as u64, "{khz} kHz: {n} periods would do, {alone:?}");
                let width = (exact(percent) / ratio(100, 1) * &total).round();
                let duty = (width / &total - exact(percent) / ratio(100, 1)).abs() <= ratio(1, 100_000);
                assert!(!(rate && duty), "{khz} kHz, {percent} %: {n} periods would do, {train:?}");
            }
        }
    }
}

#[test]
fn a_power_that_nobody_planned_is_as_exact() {
    let mut chance = Chance::new(6);
    for clock in clocks() {
        let mut bench = Bench::with_clock(1000, clock);
        bench.fixed = false;
        bench.gate(true);
        for khz in frequencies(&mut chance, 60) {
            bench.carrier(khz);
            for percent in [0.0, 100.0, 50.0, 33.333, 0.001, 99.999, chance.unit() * 100.0] {
                bench.direct(percent);
                let Train { period, width } = bench.tick().train;
                if percent == 0.0 {
                    assert_eq!(period.whole, 0, "nothing is output");
                    continue;
                }
                assert!(rate_holds(&counts(period), khz, clock), "{khz} kHz: {period:?}");
                let share = counts(period) * exact(percent) / ratio(100, 1);
                // 2⁻³² counts of the width, and the power's own 2⁻⁴⁵ of a long period.
                let slack = ratio(3, 1 << 32) + counts(period) * ratio(1, 1 << 50);
                let off = (counts(width) - &share).abs();
                assert!(off <= slack, "{khz} kHz, {percent} %: {width:?}");
                assert!(counts(width) <= counts(period));
            }
        }
    }
}

#[test]
fn a_rate_is_exact_to_the_fraction_that_keeps_its_phase() {
    let mut chance = Chance::new(7);
    for clock in clocks() {
        for fixed in [true, false] {
            let mut bench = Bench::with_clock(1000, clock);
            bench.fixed = fixed;
            bench.mode(PowerMode::Frequency, 2000.0, 0.0, true);
            bench.width(1);
            bench.gate(true);
            for khz in frequencies(&mut chance, 300) {
                bench.direct(khz);
                let view = bench.tick();
                let train = view.train;
                assert!(rate_holds(&counts(train.period), khz, clock), "{khz} kHz: {train:?}");
                assert_eq!(train.period.of, 0);
                // Up to the next 2⁻³² counts, of the power as it is held, 2⁻⁴⁴ kHz; to 60 bits,
                // where a period is longer than that.
                let exact = ratio(clock.mhz() as u64 * 1000, 1) * ratio(1 << 44, power(khz).raw() as u64);
                let up = counts(train.period) - &exact;
                let slack = &exact * ratio(1, 1 << 60);
                assert!(up >= -slack.clone() && up < ratio(1, 1 << 32) + slack, "{khz} kHz: {up}");
                let is_short = exact < ratio(1 << 30, 1);
                assert!(!(is_short && exact.is_integer()) || counts(train.period) == exact, "{khz} kHz");
                let whole = clock.mhz() as u64;
                let limited = whole >= train.period.whole;
                assert_eq!((train.width.whole, train.width.part), (whole.min(train.period.whole - 1), 0));
                assert_eq!(view.limited, limited, "{khz} kHz");
                assert_eq!((view.power, view.khz), (power(khz), power(khz)));
            }
        }
    }
}

#[test]
fn a_plan_for_other_numbers_is_not_taken() {
    let mut bench = Bench::new(1000);
    bench.gate(true);
    bench.carrier(30.0);
    bench.direct(70.0);
    assert_ne!(bench.tick().train.width.of, 0);
    // The bounds hold the power elsewhere than the plan is for.
    let carrier = Carrier::admit(power(30.0), Clock::GHZ).unwrap();
    let fixed = FixedTrain::plan(PowerMode::Duty, power(70.0), Some(&carrier), Clock::GHZ);
    let bounds = laser_bench::bounds(PowerMode::Duty, 60.0, 0.0);
    bench.change(ChannelChange::Mode { mode: PowerMode::Duty, bounds, delayed: true, fixed });
    let view = bench.tick();
    assert_eq!((view.power, view.train.width.of), (power(60.0), 0));
    let off = counts(view.train.width) - counts(view.train.period) * ratio(6, 10);
    assert!(off.abs() < ratio(1, 1 << 30), "{view:?}");
    // Nor is one for another carrier.
    bench.change(ChannelChange::Carrier { carrier: Carrier::admit(power(31.0), Clock::GHZ).unwrap(), fixed });
    assert_eq!(bench.tick().train.width.of, 0);
}

#[test]
fn what_is_output_has_the_mean_that_was_planned() {
    // 1777.7 kHz and 37.7 % for 20 ms, through the tick and a machine.
    for fixed in [true, false] {
        let (khz, percent) = (1777.7, 37.7);
        let mut bench = Bench::new(250);
        bench.fixed = fixed;
        bench.carrier(khz);
        bench.direct(percent);
        bench.gate(true);
        bench.until(20 * MS);
        let pulses = bench.pulses();
        let train = bench.tick().train;
        let begin = pulses[0].0;
        assert_eq!(begin, 250 * US);
        let mut gathered = BigRational::zero();
        for (k, (from, to)) in pulses.iter().take(30_000).enumerate() {
            // The k-th begins ⌊k·P⌋ counts after the first.
            let ideal = counts(train.period) * ratio(k as u64, 1);
            assert_eq!(ratio(from - begin, 1), ideal.floor(), "pulse {k}");
            gathered += ratio(to - from, 1);
        }
        let ideal = counts(train.width) * ratio(30_000, 1);
        assert_eq!(gathered, ideal.floor());
    }
}

#[test]
fn a_width_just_below_the_period_loses_nothing() {
    // 99.9 % of 120.5 counts: the odd counts of the two fall on different periods.
    let train =
        Train { period: Count { whole: 120, part: 1, of: 2 }, width: Count { whole: 120, part: 3795, of: 10_000 } };
    let mut pattern = Pattern::BEGIN;
    let (mut periods, mut widths, mut cut) = (0, 0, 0);
    for _ in 0..10_000 {
        let (period, width) = pattern.step(&train);
        assert!(width <= period);
        cut += (width == period) as u32;
        periods += period;
        widths += width;
    }
    assert_eq!((periods, widths), (1_205_000, 1_203_795));
    assert!(cut > 0);
}

#[test]
fn a_full_duty_is_an_unbroken_level_after_any_other() {
    // Periods and widths of other settings keep their remainders: docs/laser.md, reading 13.
    let mut chance = Chance::new(9);
    for run in 0..200 {
        let (khz, percent) = (chance.log(20.0, 2000.0), chance.unit() * 100.0);
        let mut bench = Bench::new(250);
        bench.fixed = run % 2 == 0;
        bench.carrier(khz);
        bench.direct(percent);
        bench.gate(true);
        bench.until(MS);
        bench.direct(100.0);
        bench.tick();
        // The period in progress, and the tick's own delay of one.
        let full = bench.tick.now().0 + 250 * US + 50 * US;
        bench.until(4 * MS);
        let level = *bench.pulses().last().unwrap();
        assert!(level.0 < full && level.1 >= 4 * MS, "{khz} kHz, {percent} %: {level:?}, full from {full}");
    }
}

#[test]
fn a_width_that_reaches_the_period_is_the_period() {
    let count = |whole, part, of| Count { whole, part, of };
    let period = count(120, 1, 3);
    for (width, is_full) in [
        (count(120, 1, 3), true),
        (count(120, 2, 6), true),
        (count(120, 1 << 31, 0), true),
        (count(121, 0, 1), true),
        (count(120, 333, 1000), false),
        (count(120, u32::MAX / 3, 0), false),
        (count(119, 9_999, 10_000), false),
    ] {
        let train = Train { period, width };
        assert_eq!(train.is_full(), is_full, "{width:?}");
        // Entered with any remainders, and with counts that are owed.
        for before in 0..7 {
            let mut pattern = Pattern::BEGIN;
            for _ in 0..before {
                pattern.step(&Train {
                    period: count(50, 2, 3),
                    width: count(50, 5, if before % 2 == 0 { 6 } else { 1000 }),
                });
            }
            let gaps = (0..10_000).filter(|_| {
                let (period, width) = pattern.step(&train);
                assert!(width <= period);
                width < period
            });
            assert_eq!(gaps.count() == 0, is_full, "{width:?} behind {before}");
        }
    }
    // Counts that a full train could not owe are not owed after it.
    let mut pattern = Pattern::BEGIN;
    pattern.step(&Train { period, width: count(200, 0, 3) });
    assert_eq!(pattern.step(&Train { period, width: count(10, 0, 3) }).1, 10);
}

#[test]
fn numbers_out_of_range_are_refused() {
    let admit = |value: f64| Power::admit(value.to_bits());
    assert_eq!(admit(f64::NAN), Err(Refused::NotFinite));
    assert_eq!(admit(f64::INFINITY), Err(Refused::NotFinite));
    assert_eq!(admit(-1e-300), Err(Refused::Negative));
    assert_eq!(admit(2000.0001), Err(Refused::BeyondRange));
    assert_eq!(admit(f64::MAX), Err(Refused::BeyondRange));
    assert_eq!(admit(-0.0), Ok(Power::ZERO));
    assert_eq!(admit(1e-300), Ok(Power::ZERO));
    assert_eq!(admit(2000.0), Ok(Power::MAX));
    let mut chance = Chance::new(8);
    for _ in 0..100_000 {
        let value = chance.log(1e-12, 2000.0);
        let nearest = (exact(value) * ratio(1 << Power::FRAC_BITS, 1) + ratio(1, 2)).floor();
        assert_eq!(BigRational::from_integer(admit(value).unwrap().raw().into()), nearest, "{value}");
    }
    assert_eq!(Carrier::admit(Power::ZERO, Clock::GHZ), Err(Refused::Zero));
    assert_eq!(Standby::admit(Power::ZERO, power(1.0), Clock::GHZ), Err(Refused::Zero));
    assert_eq!(Standby::admit(power(1.0), power(100.1), Clock::GHZ), Err(Refused::BeyondRange));
    let bounds = |mode, max, min| servo::laser::PowerBounds::admit(mode, power(max), power(min));
    assert_eq!(bounds(PowerMode::Duty, 100.1, 0.0), Err(Refused::BeyondRange));
    assert_eq!(bounds(PowerMode::Analog, 10.1, 0.0), Err(Refused::BeyondRange));
    assert_eq!(bounds(PowerMode::Frequency, 5.0, 6.0), Err(Refused::MaxBelowMin));
    assert!(bounds(PowerMode::Frequency, 2000.0, 2000.0).is_ok());
    assert!(Clock::from_mhz(99).is_none() && Clock::from_mhz(1001).is_none());
}
