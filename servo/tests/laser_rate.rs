//! Pulses of a rate keep their phase (SPEC 6): the next one comes when the integral of the rate
//! since the last one reaches 1. So under a velocity follow they lie at equal distances along the
//! path, from the first one on.
use crate::laser_bench;
use laser_bench::*;
use num_rational::Ratio as Exact;
use num_traits::Signed;
use servo::laser::{Buffered, ChannelChange, Family, PowerBounds, PowerMode, Ratio};
use servo::path::PathEntry;
use servo::tick_command::{DoGroup, TickCommand};

type Number = Exact<i128>;

/// One coordinate system, frequency mode, pulses of `width` µs.
fn prepared(period_us: u32, width: u16) -> Bench {
    let mut bench = Bench::new(period_us);
    bench.change(ChannelChange::Reset { family: Family::Gus });
    bench.command(TickCommand::Output { group: DoGroup::Enable, mask: 0xf, value: 0xf });
    bench.frame(0, &[0, 1]);
    bench.mode(PowerMode::Frequency, 2000.0, 0.0, true);
    bench.width(width);
    bench
}

fn follow(ratio: f64, max: f64) -> PathEntry {
    let bounds = PowerBounds::admit_follow(PowerMode::Frequency, power(max), power(0.0)).unwrap();
    buffered(Buffered::PrfFollow { ratio: Ratio::admit(ratio.to_bits()).unwrap(), bounds })
}

/// Pulses of a path that runs along X from 0 to 150 pulses and back to rest: 1 pulse/ms² up to 10
/// pulse/ms in 10 ms, 5 ms of that, 10 ms down.
const LENGTH_PULSES: i128 = 150;

/// The path length after this many ms.
fn travelled(t: Number) -> Number {
    let n = |x: i128| Number::from_integer(x);
    if t < n(10) {
        t * t / n(2)
    } else if t < n(15) {
        n(50) + (t - n(10)) * n(10)
    } else {
        let left = n(25) - t;
        n(LENGTH_PULSES) - left * left / n(2)
    }
}

/// When a path is at a position, ns: between two ticks it moves with the mean speed of the
/// interval, which is what the power follows.
fn instant(place: Number, period_us: u32) -> Number {
    let period = Number::new(period_us.into(), 1000);
    let steps = (Number::from_integer(25) / period).ceil().to_integer();
    for step in 0..steps {
        let begin = period * Number::from_integer(step);
        let end = (begin + period).min(Number::from_integer(25));
        let (from, to) = (travelled(begin), travelled(end));
        if place < to {
            // The last interval may go on beyond the end of the motion, at the mean of the whole of
            // it.
            return (begin + period * (place - from) / (to - from)) * Number::from_integer(1_000_000);
        }
    }
    panic!("{place} is not on the path")
}

/// A pulse at every pitch: in acceleration, at full speed and while it brakes, whatever the tick
/// is.
#[test]
fn pulses_under_a_follow_lie_at_equal_distances() {
    for period_us in [10, 50, 250, 1000] {
        // 2, 1/2, 1/10 and 3/10 pulses of light for one of the path.
        for (n, d) in [(2, 1), (1, 2), (1, 10), (3, 10)] {
            let mut bench = prepared(period_us, 1);
            let entries =
                [light(true), follow(n as f64 / d as f64, 2000.0), line([LENGTH_PULSES as i32, 0], 10.0, 1.0, 0.0)];
            bench.path(0, &entries);
            let zero = bench.start(1);
            bench.until_ms(zero / MS + 30);
            let pulses = bench.pulses();
            let count = (LENGTH_PULSES * n + d - 1) / d;
            for (k, (begin, end)) in (0..count).zip(&pulses) {
                let exact = instant(Number::new(k * d, n), period_us) + Number::from_integer(zero.into());
                let off = (Number::from_integer((*begin).into()) - exact.floor()).abs();
                assert!(
                    off <= Number::from_integer(1),
                    "{period_us} µs, {n}/{d}: pulse {k} begins at {begin}, not {exact}"
                );
                assert_eq!(end - begin, 1000, "{period_us} µs, {n}/{d}: pulse {k}");
            }
            assert_eq!(pulses.len() as i128, count, "{period_us} µs, {n}/{d}");
        }
    }
}

/// The pulse in progress ends a count before the next one, whatever the rate is: pulses never
/// touch. The view says so.
#[test]
fn pulses_whose_width_passes_the_period_do_not_touch() {
    let mut bench = prepared(10, 40);
    bench.direct(10.0);
    bench.gate(true);
    let zero = bench.tick.now().0 + 10 * US;
    let view = bench.tick();
    assert!(!view.limited);
    // 0.1 of a pulse has gone: at 100 kHz the next one begins 9 µs later.
    bench.direct(100.0);
    let view = bench.tick();
    assert!(view.limited);
    bench.until(zero + 50 * US);
    let pulses: Vec<_> = bench.pulses().iter().map(|(begin, end)| (begin - zero, end - zero)).collect();
    assert_eq!(pulses[..4], [(0, 18_999), (19_000, 28_999), (29_000, 38_999), (39_000, 48_999)]);
}

#[test]
fn pulses_of_a_follow_never_touch() {
    for period_us in [10, 50, 250] {
        // 20 µs of each 100 µs at full speed are too long by far at 10 kHz for a ratio of 10.
        let mut bench = prepared(period_us, 20);
        bench.path(0, &[light(true), follow(10.0, 2000.0), line([LENGTH_PULSES as i32, 0], 10.0, 1.0, 0.0)]);
        let zero = bench.start(1);
        bench.until_ms(zero / MS + 30);
        let pulses = bench.pulses();
        assert_eq!(pulses.len(), 1500, "{period_us} µs: none has grown into the next");
        for (k, pair) in pulses.windows(2).enumerate() {
            assert!(pair[0].1 < pair[1].0, "{period_us} µs: pulse {k}: {pair:?}");
            let width = pair[0].1 - pair[0].0;
            let to_next = pair[1].0 - pair[0].0;
            assert!(width == 20_000.min(to_next - 1) || width < 20_000 && to_next - width <= 2000, "{k}: {pair:?}");
        }
    }
}

/// A stop at speed 0 in mid-pitch: the phase is kept.
#[test]
fn a_rest_of_the_path_holds_the_phase() {
    let mut bench = prepared(50, 1);
    // 3.5 pulses, a delay of 7 ms, 6.4 more: a pulse at every ten pulses of the path.
    let lines = |to: i32| line([to, 0], 1.0, 1.0, 0.0);
    let entries = [light(true), follow(0.1, 2000.0), lines(35), PathEntry::delay(7), lines(99)];
    bench.path(0, &entries);
    let zero = bench.start(1);
    bench.until_ms(zero / MS + 125);
    let pulses: Vec<u64> = bench.pulses().iter().map(|(begin, _)| begin - zero).collect();
    // 0.5 pulses of the path in its first and its last ms, else one a ms: position x ≥ 0.5 comes at
    // x + 0.5 ms, after the delay 8 ms later.
    let expected: Vec<u64> =
        (1..10).map(|k| if k <= 3 { k * 10 * MS + MS / 2 } else { k * 10 * MS + MS / 2 + 8 * MS }).collect();
    assert_eq!(pulses.len(), 10, "{pulses:?}");
    assert_eq!(pulses[0], 0);
    for (at, expected) in pulses[1..].iter().zip(expected) {
        assert!(at.abs_diff(expected) <= 1, "{pulses:?}: {at}, not {expected}");
    }
}
