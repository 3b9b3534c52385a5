//! A board's step limit (SPEC 5), against rationals: faster data is refused, other data is taken; a
//! slave that would be faster stops.
use crate::{chance, tick_bench};
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{Signed, Zero};
use servo::segment::follow::MasterPosition;
use servo::segment::pt::{Chain, Refused, Segment};
use servo::segment::ramp;
use servo::segment::ramp::Speed;
use servo::status;
use servo::tick_command::{MotionMode, TickCommand};
use servo::units::{AxisMask, StepLimit};
use servo::view::{Event, StopReason};

use chance::Chance;
use tick_bench::*;

fn limit(pulses_per_ms: u64) -> StepLimit {
    StepLimit::new(pulses_per_ms).unwrap()
}

fn whole(x: i64) -> BigRational {
    BigRational::from_integer(BigInt::from(x))
}

#[test]
fn a_limit_is_a_whole_number_up_to_full_scale() {
    assert_eq!((StepLimit::new(0), StepLimit::new((1 << 32) + 1)), (None, None));
    assert_eq!(StepLimit::new(1 << 32), Some(StepLimit::FULL_SCALE));
    assert_eq!(limit(1000).pulses_per_ms(), 1000);
}

/// To the last bit of a double.
#[test]
fn speeds_are_held_to_it() {
    for pulses_per_ms in [1, 2, 3, 333, 1000, 1023, 1024, 1025, 65_537, (1 << 32) - 1, 1 << 32] {
        let (limit, bits) = (limit(pulses_per_ms), (pulses_per_ms as f64).to_bits());
        for sign in [0, 1 << 63] {
            assert!(Speed::admit(bits | sign, limit).is_ok(), "{pulses_per_ms}");
            assert!(Speed::admit((bits - 1) | sign, limit).is_ok());
            assert_eq!(Speed::admit((bits + 1) | sign, limit), Err(ramp::Refused::BeyondLimit), "{pulses_per_ms}");
        }
    }
}

#[test]
fn pt_data_at_the_limit_is_taken_and_a_step_above_it_is_not() {
    let admit = |pos: f64, time, kind, chain: &Chain| Segment::admit(pos.to_bits(), time, kind, chain, limit(1000));
    let (zero, step) = (Chain::default(), 1.0 / 1_048_576.0);
    for sign in [1.0, -1.0] {
        // EVEN, STOP: exact in 2⁻²⁰ pulse/ms.
        assert!(admit(sign * 1000.0, 1, 1, &zero).is_ok());
        assert!(admit(sign * 7000.0, 7, 1, &zero).is_ok());
        assert!(admit(sign * 500.0, 1, 2, &zero).is_ok());
        for (pos, kind) in [(1000.0 + step, 1), (500.0 + step, 2)] {
            let refused = admit(sign * pos, 1, kind, &zero).unwrap_err();
            assert!(matches!(refused, Refused::TooFast { speed } if speed.unsigned_abs() > 1000 << 20), "{refused:?}");
        }
        // NORMAL: what rounding may have added is allowed, 3 steps a segment.
        let (_, up) = admit(sign * 500.0, 1, 0, &zero).unwrap();
        assert!(matches!(admit(sign * (500.0 + 2.0 * step), 1, 0, &zero), Err(Refused::TooFast { .. })));
        let (_, on) = admit(sign * 1500.0, 2, 0, &up).unwrap();
        assert!(matches!(admit(sign * (2500.0 + 5.0 * step), 3, 0, &on), Err(Refused::TooFast { .. })));
        assert!(admit(sign * 2500.0, 3, 0, &on).is_ok());
        // After an EVEN segment it begins anew.
        let (_, even) = admit(sign * 2500.0, 3, 1, &on).unwrap();
        assert!(matches!(admit(sign * (3500.0 + 4.0 * step), 4, 0, &even), Err(Refused::TooFast { .. })));
    }
}

/// Random chains that go near the limit: nothing at or below it is refused, nothing above it by
/// more than what is stated taken.
#[test]
fn random_pt_chains_against_rationals() {
    let mut chance = Chance::new(71);
    let (mut taken, mut refused) = (0, 0);
    for _ in 0..20_000 {
        let most = 1 + chance.below(3000);
        let bound = whole(most as i64);
        let (mut chain, mut pos, mut time, mut v) = (Chain::default(), 0.0f64, 0i32, BigRational::zero());
        for since in 1..=12 {
            let t = 1 + chance.below(20) as i32;
            let kind = [0, 0, 0, 1, 2][chance.below(5) as usize];
            // Toward a speed at its faster end that is often the limit, or nearly.
            let near = [0.0, 0.5, 1.0, 1.0, 1.0 + 1e-9, 1.0 - 1e-9, 1.0 + 1e-5, 1.001][chance.below(8) as usize];
            let target = near * most as f64 * chance.sign();
            let before = num_traits::ToPrimitive::to_f64(&v).unwrap();
            let way = match kind {
                0 => (before + target) / 2.0,
                1 => target,
                _ => target / 2.0,
            };
            let to = pos + way * f64::from(t);
            let p = BigRational::from_float(to).unwrap() - BigRational::from_float(pos).unwrap();
            let mean = &p / whole(t.into());
            let (v0, v1) = match kind {
                0 => (v.clone(), &mean * whole(2) - &v),
                1 => (mean.clone(), mean.clone()),
                _ => (&mean * whole(2), BigRational::zero()),
            };
            let peak = v0.abs().max(v1.abs());
            // 3 steps for each segment of a chain, and as much for what is rounded down.
            let slack = BigRational::new(BigInt::from(3 * since + 3), BigInt::from(1 << 20));
            match Segment::admit(to.to_bits(), time + t, kind, &chain, limit(most)) {
                Ok((_, next)) => {
                    assert!(peak <= &bound + &slack, "{peak} of {most}, kind {kind}");
                    (chain, pos, time, v) = (next, to, time + t, v1);
                    taken += 1;
                }
                Err(Refused::TooFast { .. }) => {
                    assert!(peak > bound, "{peak} of {most}, kind {kind}");
                    refused += 1;
                    break;
                }
                Err(other) => panic!("{other:?}"),
            }
        }
    }
    assert!(taken > 20_000 && refused > 5_000, "{taken} {refused}");
}

/// Axis 0 a jogging master, the others ready to follow, on a board of 1000 pulse/ms.
fn bench(period_us: u32) -> Bench {
    let mut bench = Bench::limited(period_us, limit(1000));
    bench.prepare_start(MotionMode::Follow);
    bench.now(TickCommand::SetMode { axis: axis(0), mode: MotionMode::Jog });
    bench
}

/// A slave at exactly the limit goes on; a little above it stops, with its reason, event and
/// status, and stays where it was.
#[test]
fn a_slave_that_would_be_faster_stops() {
    for period in [50, 250, 1000] {
        // A ratio of 100: 10 pulse/ms of the master are the limit.
        let run = |vel: f64| {
            let mut bench = bench(period);
            bench.follows(1, 0, MasterPosition::Planned);
            bench.follow(1, 0, &[Item::Data(1e6, 1e8, 1, 0)]);
            bench.start_follow(&[1]);
            bench.jog(0, vel, 1.0);
            bench
        };
        let mut bench = run(10.0);
        let view = bench.until(100 * MS);
        assert!(view.axes[1].status & status::RUNNING != 0, "{period}: {:?}", view.axes[1].stop);
        let mut bench = run(10.01);
        let mut before = bench.tick();
        let stopped = loop {
            let view = bench.tick();
            if view.axes[1].stop == StopReason::StepLimit {
                break view;
            }
            assert!(view.now.0 < 100 * MS, "{period}: it did not stop");
            before = view;
        };
        // At rest at the position before, which it had reached at no more than the limit.
        assert_eq!(stopped.axes[1].pos, before.axes[1].pos);
        assert_eq!(stopped.axes[1].status & status::RUNNING, 0);
        match bench.event() {
            Some(Event::Stopped { axis, reason: StopReason::StepLimit, now }) => {
                assert_eq!((axis.index(), now), (1, stopped.now));
            }
            other => panic!("{other:?}"),
        }
        // The reason stays until the next start.
        let later = bench.ticks(100);
        assert_eq!((later.axes[1].stop, later.axes[1].pos), (StopReason::StepLimit, before.axes[1].pos));
    }
}

/// The limit scales with the tick period.
#[test]
fn another_tick_period_keeps_the_limit() {
    for (vel, stops) in [(9.99, false), (10.02, true)] {
        let mut bench = bench(1000);
        bench.now(TickCommand::TickPeriod { ns: 125_000 });
        bench.tick();
        bench.follows(1, 0, MasterPosition::Planned);
        bench.follow(1, 0, &[Item::Data(1e6, 1e8, 1, 0)]);
        bench.start_follow(&[1]);
        bench.jog(0, vel, 1.0);
        let view = bench.ticks(800);
        assert_eq!(view.axes[1].stop == StopReason::StepLimit, stops, "{vel}");
    }
}

/// A smooth Stop of a slave is never faster than the limit: where it accelerates so hard that it
/// would be in the tick after, it stops at once.
#[test]
fn a_smooth_stop_is_not_faster() {
    let (mut smooth, mut abrupt) = (0, 0);
    for ticks in 1..12 {
        let mut bench = bench(1000);
        bench.follows(1, 0, MasterPosition::Planned);
        bench.follow(1, 0, &[Item::Data(1e6, 1e8, 1, 0)]);
        bench.start_follow(&[1]);
        bench.jog(0, 100.0, 1.0);
        let mut view = bench.ticks(ticks);
        bench.now(TickCommand::StopDec { axis: axis(1), smooth: accel(50.0), abrupt: accel(50.0) });
        bench.now(TickCommand::stop(AxisMask(2), AxisMask(0)));
        loop {
            let next = bench.tick();
            let way = next.axes[1].pos.0.abs_diff(view.axes[1].pos.0);
            assert!(way <= (1000 << 22) + 1, "{ticks}: {way}");
            view = next;
            if view.axes[1].status & status::RUNNING == 0 {
                break;
            }
        }
        match view.axes[1].stop {
            StopReason::StepLimit => abrupt += 1,
            StopReason::StopSmooth => smooth += 1,
            other => panic!("{other:?}"),
        }
    }
    assert!(smooth > 3 && abrupt > 0, "{smooth} {abrupt}");
}
