//! Frequencies and duties as the timers count them, against exact rationals, over the whole range
//! and both clocks; and the spectrum of what they count.
#[path = "laser/bench.rs"]
#[allow(dead_code, reason = "each test file uses its part")]
mod bench;
#[path = "../../servo/tests/chance/mod.rs"]
mod chance;
#[path = "laser/player.rs"]
#[allow(dead_code, reason = "each test file uses its part")]
mod player;
#[path = "laser/spectrum.rs"]
mod spectrum;

use bench::Bench;
use chance::Chance;
use num_rational::BigRational;
use servo::laser::{Carrier, ChannelChange, Clock, Count, FixedTrain, Power, PowerBounds, PowerMode, Standby, Train};
use spectrum::{counted, figure, lines, repetition, worst};
use std::num::NonZeroU16;

fn clocks() -> [Clock; 2] {
    [Clock::GHZ, Clock::from_mhz(240).unwrap()]
}

fn real(value: f64) -> BigRational {
    BigRational::from_float(value).unwrap()
}

fn ratio(part: u64, of: u64) -> BigRational {
    BigRational::new(part.into(), of.into())
}

fn mean(count: Count) -> BigRational {
    let of = if count.of == 0 { 1 << 32 } else { count.of.into() };
    assert!(u64::from(count.part) < of, "{count:?}");
    ratio(count.whole, 1) + ratio(count.part.into(), of)
}

fn distance(a: &BigRational, b: &BigRational) -> BigRational {
    if a > b { a - b } else { b - a }
}

/// A period against its frequency in kHz: to 1 ppm.
fn check_period(period: Count, khz: f64, clock: Clock) {
    let turns = mean(period) * real(khz) / ratio(u64::from(clock.mhz()) * 1000, 1);
    let error = distance(&turns, &ratio(1, 1));
    assert!(error <= ratio(1, 1_000_000), "{khz} kHz at {} MHz: {period:?}", clock.mhz());
}

/// A duty in %: to 0.001 %.
fn check_duty(train: Train, percent: f64) {
    let error = distance(&(mean(train.width) / mean(train.period) * ratio(100, 1)), &real(percent));
    assert!(error <= ratio(1, 1000), "{percent} %: {train:?}");
    assert!(mean(train.width) <= mean(train.period), "{train:?}");
}

/// Frequencies from 0.1 mHz to 2 MHz, evenly in the logarithm, and such as are hard or usual.
fn frequencies(chance: &mut Chance, count: usize) -> Vec<f64> {
    let mut khz =
        vec![2000.0, 1999.999, 1999.0, 1234.567, 1000.0 / 3.0, 96.0, 24.0, 20.0, 10.0, 1.0, 0.006, 0.0015, 1e-7];
    khz.extend((1..=2000).step_by(7).map(f64::from));
    khz.extend((0..count).map(|_| chance.log(1e-7, 2000.0)));
    khz.extend((0..count).map(|_| chance.log(100.0, 2000.0)));
    khz
}

fn duties(chance: &mut Chance) -> [f64; 8] {
    [0.0, 100.0, 50.0, 0.01, 99.99, 100.0 / 3.0, chance.unit() * 100.0, chance.unit() * 100.0]
}

fn power(value: f64) -> Power {
    Power::admit(value.to_bits()).unwrap()
}

#[test]
fn planned_trains_have_their_frequency_and_duty() {
    let chance = &mut Chance::new(1);
    let (mut longest, mut trains) = (0, 0);
    for clock in clocks() {
        for khz in frequencies(chance, 1500) {
            let carrier = Carrier::admit(power(khz), clock).unwrap();
            check_period(carrier.period(), khz, clock);
            for percent in duties(chance) {
                let standby = *Standby::admit(power(khz), power(percent), clock).unwrap().train();
                let light = *FixedTrain::plan(PowerMode::Duty, power(percent), Some(&carrier), clock).unwrap().train();
                for train in [standby, light] {
                    check_period(train.period, khz, clock);
                    check_duty(train, percent);
                    longest = longest.max(repetition(train));
                    trains += 1;
                }
            }
            check_period(clock.period(power(khz)), khz, clock);
        }
    }
    println!("{trains} trains, longest repetition {longest} periods");
    assert!(trains > 50_000);
}

/// What the tick finds by itself, where nothing was planned ahead.
#[test]
fn trains_of_the_tick_have_their_frequency_and_duty() {
    let chance = &mut Chance::new(2);
    let mut bench = Bench::new();
    for clock in clocks() {
        for khz in frequencies(chance, 800) {
            let carrier = Carrier::admit(power(khz), clock).unwrap();
            for percent in duties(chance) {
                let changes = [
                    ChannelChange::Carrier { carrier, fixed: None },
                    ChannelChange::Direct { power: power(percent), fixed: None },
                    ChannelChange::Gate { on: true },
                ];
                let view = bench.one_tick(clock, &changes);
                assert!(!view.limited);
                if percent == 0.0 {
                    assert!(view.train.is_none(), "nothing is output");
                    continue;
                }
                check_period(view.train.period, khz, clock);
                check_duty(view.train, percent);
            }
            let width = 1 + chance.below(100) as u16;
            let bounds = PowerBounds::full(PowerMode::Frequency);
            let changes = [
                ChannelChange::Mode { mode: PowerMode::Frequency, bounds, delayed: true, fixed: None },
                ChannelChange::PulseWidth { us: NonZeroU16::new(width).unwrap() },
                ChannelChange::Direct { power: power(khz), fixed: None },
                ChannelChange::Gate { on: true },
            ];
            let view = bench.one_tick(clock, &changes);
            check_period(view.train.period, khz, clock);
            let asked = u64::from(width) * u64::from(clock.mhz());
            let reaches = real(khz) * ratio(width.into(), 1) >= ratio(1000, 1);
            assert_eq!(view.limited, reaches, "{khz} kHz, {width} µs");
            if reaches {
                let gap = mean(view.train.period) - mean(view.train.width);
                assert!(gap >= ratio(1, 1) && gap <= ratio(3, 1), "{:?}", view.train);
            } else {
                assert_eq!(mean(view.train.width), ratio(asked, 1));
            }
        }
    }
}

/// Over one whole repetition the counted periods and widths are the means; each is within one count
/// of it.
#[test]
fn the_counts_of_a_repetition_are_the_mean() {
    let chance = &mut Chance::new(3);
    for clock in clocks() {
        for khz in frequencies(chance, 200).into_iter().filter(|khz| *khz > 1.0) {
            let percent = chance.unit() * 100.0;
            let carrier = Carrier::admit(power(khz), clock).unwrap();
            let train = *FixedTrain::plan(PowerMode::Duty, power(percent), Some(&carrier), clock).unwrap().train();
            let periods = repetition(train);
            let (pulses, length) = counted(train, periods);
            assert_eq!(ratio(length, 1), mean(train.period) * ratio(periods, 1));
            let lit: u64 = pulses.iter().map(|(begin, end)| end - begin).sum();
            assert_eq!(ratio(lit, 1), mean(train.width) * ratio(periods, 1));
            for (k, (begin, end)) in (0..).zip(&pulses) {
                let late = mean(train.period) * ratio(k, 1) - ratio(*begin, 1);
                assert!(late >= ratio(0, 1) && late < ratio(1, 1), "{train:?}: pulse {k}");
                assert!(end - begin == train.width.whole || end - begin == train.width.whole + 1);
            }
        }
    }
}

/// Begins of pulses vary by one count, as a saw-tooth whose first line is 1/2π of it. Ends vary by
/// that and by the variation of the width. Together they are at most 3/2π of a count in P, against
/// sin(πd)/π of the train's own line at a duty d.
#[test]
fn dither_makes_no_line_above_the_stated_level() {
    let mut highest: Vec<(f64, f64, f64)> = Vec::new();
    for khz in [1999.0, 1900.0, 1999.999, 1777.7, 1234.567, 999.0, 700.3, 523.1, 333.33, 199.9] {
        for percent in [50.0, 100.0 / 3.0, 20.0, 80.0, 5.0, 95.0] {
            let clock = Clock::from_mhz(240).unwrap();
            let carrier = Carrier::admit(power(khz), clock).unwrap();
            let train = *FixedTrain::plan(PowerMode::Duty, power(percent), Some(&carrier), clock).unwrap().train();
            if repetition(train) > 3000 {
                continue;
            }
            if let Some(line) = worst(&lines(train, 2)) {
                let counts = 240_000.0 / khz;
                let own = (std::f64::consts::PI * percent / 100.0).sin();
                let bound = 20.0 * (1.5 / counts / own).log10();
                println!(
                    "{khz} kHz {percent:.1} %: repetition {}, {:.1} dB at {:.3} f, bound {bound:.1}",
                    repetition(train),
                    line.db,
                    line.multiple
                );
                highest.push((line.db - bound, khz, percent));
            }
        }
    }
    assert!(highest.len() > 20);
    let (over, khz, percent) = highest.into_iter().max_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
    assert!(over <= 0.0, "{over} dB above at {khz} kHz, {percent} %");
}

/// The figure of `docs/laser.md`. With `WRITE_FIGURE` set it is written, else compared.
#[test]
fn the_figure_of_the_spectrum_is_true() {
    let clock = Clock::from_mhz(240).unwrap();
    let carrier = Carrier::admit(power(1900.0), clock).unwrap();
    let train = *FixedTrain::plan(PowerMode::Duty, power(30.0), Some(&carrier), clock).unwrap().train();
    let title = format!(
        "1900 kHz at 240 MHz, 30 %: period {} {}/{}, width {} {}/{} counts, repeats after {} periods",
        train.period.whole,
        train.period.part,
        train.period.of,
        train.width.whole,
        train.width.part,
        train.width.of,
        repetition(train)
    );
    let svg = figure(&title, &lines(train, 3), 3);
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/laser-dither.svg");
    if std::env::var_os("WRITE_FIGURE").is_some() {
        std::fs::write(path, &svg).unwrap();
    }
    assert_eq!(std::fs::read_to_string(path).unwrap(), svg, "run with WRITE_FIGURE=1");
}
