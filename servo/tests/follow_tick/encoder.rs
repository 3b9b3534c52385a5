//! Masters that are encoders, and the filter of a master.
use super::*;

#[test]
fn a_dithering_encoder_does_not_creep() {
    let mut bench = Bench::prepared(50, MotionMode::Follow);
    bench.now(TickCommand::FollowDirection { axis: axis(1), direction: Direction::Up });
    bench.follows(1, 0, MasterPosition::Encoder);
    bench.follow(1, 0, &[Item::Data(1000.0, 5000.0, 1, 0)]);
    loops(&mut bench, 1, 0);
    bench.start_follow(&[1]);
    bench.ticks(3);
    let ticks = std::env::var("DITHER_TICKS").map_or(300_000, |n| n.parse().unwrap());
    for tick in 0..ticks {
        bench.machine.slip[0] = [0, 1, -1, 0, 1, 0, -2, 1][tick % 8];
        bench.tick_unread();
    }
    bench.machine.slip[0] = 0;
    let view = bench.ticks(3);
    assert_eq!(view.axes[1].pos, Pos::pulses(5), "one pulse of the master, once");
    bench.machine.slip[0] = 101;
    assert_eq!(bench.ticks(3).axes[1].pos, Pos::pulses(505));
}

#[test]
fn an_encoder_is_followed_by_its_sample() {
    let mut bench = Bench::prepared(250, MotionMode::Follow);
    bench.follows(0, 5, MasterPosition::Encoder);
    bench.follow(0, 0, &[Item::Data(100.0, 50.0, 1, 0)]);
    loops(&mut bench, 0, 0);
    bench.machine.slip[5] = 3;
    bench.start_follow(&[0]);
    bench.ticks(2);
    bench.machine.slip[5] = 13;
    let view = bench.tick();
    // 10 pulses of the master in a tick of 0.25 ms, and half of it for the slave.
    assert_eq!((view.axes[5].encoder, view.axes[0].pos), (13, Pos::pulses(5)));
    assert!((real(view.velocity(&view.axes[0])) - 20.0).abs() < 1e-9);
    let view = bench.tick();
    assert_eq!(real(view.velocity(&view.axes[0])), 0.0);
    // The reading of the count does not matter.
    bench.now(TickCommand::SetEncoder { axis: axis(5), pulses: -1_000_000 });
    assert_eq!(bench.ticks(2).axes[0].pos, Pos::pulses(5));
}

/// Time constant of the filter, ms.
const TAU_MS: f64 = 4.194304;

/// A slave at ratio 1 to a filtered master.
fn filtered(period: u32, master: usize, value: MasterPosition) -> Bench {
    let mut bench = bench(period);
    bench.follows(1, master, value);
    bench.follow(1, 0, &[Item::Data(1e9, 1e9, 1, 0)]);
    loops(&mut bench, 1, 0);
    bench.start_follow(&[1]);
    bench.ticks(3);
    bench
}

#[test]
fn a_filtered_encoder_answers_as_a_lag_of_first_order_at_any_period() {
    // A ramp begins at rest: x = v·t, y = v·(t − τ·(1 − exp(−t/τ))); after its end x − y dies away
    // with exp(−t/τ). Every speed is whole pulses per tick.
    for (speed, period) in [(20, 50), (20, 250), (20, 1000), (20_000, 10), (20_000, 50), (20_000, 250), (20_000, 1000)]
    {
        let ramp = |t: f64| speed as f64 * (t + TAU_MS * (-t / TAU_MS).exp_m1());
        let end = 40.0;
        let rest = speed as f64 * end - ramp(end);
        let mut bench = filtered(period, 5, MasterPosition::EncoderFiltered);
        for us in (period..=100_000).step_by(period as usize) {
            bench.machine.slip[5] = us.min(40_000) as i64 * speed / 1000;
            let view = bench.tick();
            let t = us as f64 / 1000.0;
            let exact = if t <= end { ramp(t) } else { speed as f64 * end - rest * ((end - t) / TAU_MS).exp() };
            let gap = pulses(view.axes[1].pos) - exact;
            assert!(gap.abs() < 1e-6, "{gap} off {exact} at {t} ms, period {period} us");
        }
        // It arrives, to the bit.
        let view = bench.ticks(300_000 / period);
        assert_eq!(view.axes[1].pos, Pos::pulses(40 * speed as i32), "period {period} us");
    }
}

#[test]
fn a_filtered_encoder_that_jumps() {
    for period in [10, 50, 250, 1000] {
        let mut bench = filtered(period, 5, MasterPosition::EncoderFiltered);
        bench.machine.slip[5] = 100;
        let part = period as f64 / 1000.0 / TAU_MS;
        // Linear over the tick in which it is sampled, then at rest.
        let first = 100.0 * -(-part).exp_m1() / part;
        let mut before = 0.0;
        for tick in 0..30_000 / period {
            let view = bench.tick();
            let exact = 100.0 - first * (-part * tick as f64).exp();
            let gap = pulses(view.axes[1].pos) - exact;
            assert!(gap.abs() < 1e-6, "{gap} off {exact} at tick {tick}, period {period} us");
            let speed = real(view.velocity(&view.axes[1])) * period as f64 / 1000.0;
            assert!((speed - (exact - before)).abs() < 2e-6, "{speed}");
            before = exact;
        }
    }
}

#[test]
fn a_filtered_plan_lags_by_speed_times_its_time_constant() {
    for period in [10, 50, 250, 1000] {
        for speed in [10.0, 3000.0] {
            let mut bench = filtered(period, 0, MasterPosition::PlannedFiltered);
            bench.jog(0, speed, 1000.0);
            let view = bench.ticks(200_000 / period);
            let lag = pulses(view.axes[0].pos) - pulses(view.axes[1].pos);
            assert!((lag - speed * TAU_MS).abs() < 1e-6, "{lag}, period {period} us");
        }
    }
}
