//! Gear through the tick: masters of both kinds, reversal, renaming, new ratios, stops and limits.
use crate::tick_bench;
use servo::segment::follow::{Direction, GearRatio, Master, MasterPosition, StartEvent};
use servo::status;
use servo::tick_command::{MotionMode, TickCommand};
use servo::units::{AxisMask, Ns, Pos, StepLimit};
use servo::view::{Event, StopReason};
use tick_bench::*;

/// Axis 0 a jogging master, the others ready for a gear.
fn bench(period_us: u32) -> Bench {
    let mut bench = Bench::prepared(period_us, MotionMode::Gear);
    bench.now(TickCommand::SetMode { axis: axis(0), mode: MotionMode::Jog });
    bench
}

fn ratio(bench: &mut Bench, index: usize, master: i32, slave: i32, slope: i32) {
    bench.now(TickCommand::GearRatio { axis: axis(index), ratio: GearRatio::of(master, slave, slope).unwrap() });
}

/// How far it is from `slave`/`master` times the master's way from `from`, pulses.
fn off(bench_view: &servo::view::View<AXES>, index: usize, ratio: f64, from: (f64, f64)) -> f64 {
    pulses(bench_view.axes[index].pos) - from.1 - ratio * (pulses(bench_view.axes[0].pos) - from.0)
}

#[test]
fn a_slave_goes_along_both_ways_with_every_plan_of_its_master() {
    for period in [50, 250, 1000] {
        let mut bench = bench(period);
        bench.follows(1, 0, MasterPosition::Planned);
        ratio(&mut bench, 1, 7, -3, 0);
        bench.start_follow(&[1]);
        let ticks = |bench: &mut Bench, ms: u32| {
            for _ in 0..ms * 1000 / period {
                let view = bench.tick();
                let off = off(&view, 1, -3.0 / 7.0, (0.0, 0.0));
                assert!(off.abs() < 1e-6, "{off}");
                let [master, slave] = [0, 1].map(|index| real(view.velocity(&view.axes[index])));
                assert!((slave + 3.0 / 7.0 * master).abs() < 1e-9, "{slave} {master}");
                assert!(has(&view.axes[1], status::RUNNING) && view.axes[1].mode == MotionMode::Gear);
            }
        };
        bench.jog(0, 50.0, 1.0);
        ticks(&mut bench, 200);
        // Planned anew on the way, and back beyond the start.
        bench.jog(0, -80.0, 2.0);
        ticks(&mut bench, 400);
        let view = bench.tick();
        assert!(pulses(view.axes[0].pos) < -1000.0, "beyond its start");
        bench.now(TickCommand::stop(all(&[0]), AxisMask(0)));
        ticks(&mut bench, 200);
        // Another mode of the master.
        bench.now(TickCommand::SetMode { axis: axis(0), mode: MotionMode::PtStatic });
        bench.pt(0, 0, &[(70.0, 10, 0), (-700.0, 60, 0)]);
        bench.start(&[0]);
        ticks(&mut bench, 100);
        // The master is switched off while it moves: both stop.
        bench.now(TickCommand::SetMode { axis: axis(0), mode: MotionMode::Jog });
        bench.jog(0, 20.0, 1.0);
        ticks(&mut bench, 100);
        bench.now(TickCommand::Servo { axis: axis(0), on: false });
        let stopped = bench.ticks(3).axes[1].pos;
        assert_eq!(bench.ticks(10).axes[1].pos, stopped);
        assert!(has(&bench.tick().axes[1], status::RUNNING), "it waits for its master");
    }
}

#[test]
fn a_master_that_is_renamed_moves_no_slave() {
    let mut bench = bench(250);
    bench.follows(1, 0, MasterPosition::Planned);
    bench.follows(2, 0, MasterPosition::Encoder);
    ratio(&mut bench, 1, 2, 3, 0);
    ratio(&mut bench, 2, 2, 3, 0);
    bench.start_follow(&[1, 2]);
    bench.jog(0, 10.0, 1.0);
    bench.ticks(400);
    bench.now(TickCommand::stop(all(&[0]), AxisMask(0)));
    let before = bench.ticks(100);
    assert!(pulses(before.axes[1].pos) > 1000.0);
    bench.now(TickCommand::Zero { axes: all(&[0]) });
    let view = bench.ticks(3);
    assert_eq!((view.axes[0].pos, view.axes[0].encoder), (Pos(0), 0));
    bench.now(TickCommand::SetPosition { axis: axis(0), pos: Pos::pulses(-123_456) });
    bench.now(TickCommand::SetEncoder { axis: axis(0), pulses: 99_999 });
    // A slave in gear runs: its own name cannot be changed.
    bench.now(TickCommand::Zero { axes: all(&[1]) });
    let view = bench.ticks(3);
    for slave in [1, 2] {
        assert_eq!(view.axes[slave].pos, before.axes[slave].pos);
    }
    bench.jog(0, -10.0, 1.0);
    let view = bench.ticks(100);
    let way = pulses(view.axes[0].pos) + 123_456.0;
    assert!((pulses(view.axes[1].pos) - pulses(before.axes[1].pos) - 1.5 * way).abs() < 1e-6);
}

#[test]
fn an_encoder_is_geared_by_its_counts() {
    for (direction, expected) in
        [(Direction::Both, [5, 0, -5]), (Direction::Up, [5, 5, 5]), (Direction::Down, [0, 0, -5])]
    {
        let mut bench = bench(250);
        bench.now(TickCommand::FollowDirection { axis: axis(1), direction });
        bench.follows(1, 5, MasterPosition::Encoder);
        ratio(&mut bench, 1, 2, 1, 0);
        bench.start_follow(&[1]);
        bench.ticks(2);
        for (count, slave) in [10, 0, -10].into_iter().zip(expected) {
            bench.machine.slip[5] = count;
            assert_eq!(bench.ticks(2).axes[1].pos, Pos::pulses(slave), "{direction:?} at {count}");
        }
    }
}

#[test]
fn a_new_ratio_goes_over_its_slope_without_a_jump() {
    let mut bench = bench(250);
    bench.follows(1, 0, MasterPosition::Planned);
    ratio(&mut bench, 1, 1, 1, 1000);
    bench.jog(0, 100.0, 10.0);
    bench.ticks(100);
    bench.start_follow(&[1]);
    let mut last = 0.0;
    let mut speeds = |bench: &mut Bench, ticks: u32, step: f64| {
        for _ in 0..ticks {
            let view = bench.tick();
            let speed = real(view.velocity(&view.axes[1]));
            assert!((speed - last).abs() <= step, "{speed} after {last}");
            last = speed;
        }
        last
    };
    // A ratio of 1 over 1000 pulses: 100 pulse/ms over 40 ticks.
    assert!((speeds(&mut bench, 60, 2.51) - 100.0).abs() < 1e-9);
    // A ratio that is only set changes nothing.
    ratio(&mut bench, 1, 2, -1, 1000);
    assert!((speeds(&mut bench, 20, 1e-9) - 100.0).abs() < 1e-9);
    bench.start_follow(&[1]);
    speeds(&mut bench, 20, 3.76);
    // On the slope another one, at once from the ratio there.
    ratio(&mut bench, 1, 4, 1, 100);
    bench.start_follow(&[1]);
    assert!((speeds(&mut bench, 60, 30.0) - 25.0).abs() < 1e-9);
    let view = bench.tick();
    let from = (pulses(view.axes[0].pos), pulses(view.axes[1].pos));
    for _ in 0..4000 {
        let view = bench.tick();
        assert!(off(&view, 1, 0.25, from).abs() < 1e-6);
    }
}

/// Slaves of slaves, numbered against their order: no tick of delay.
#[test]
fn gears_chain() {
    let mut bench = bench(250);
    for (slave, master) in [(1, 4), (4, 3), (3, 0)] {
        bench.follows(slave, master, MasterPosition::Planned);
        ratio(&mut bench, slave, 2, 1, if slave == 4 { 50 } else { 0 });
    }
    bench.start_follow(&[1, 3, 4]);
    bench.jog(0, 40.0, 1.0);
    let mut end = (0.0, 0.0);
    for tick in 0..1200 {
        if tick == 600 {
            bench.jog(0, -40.0, 1.0);
        }
        let view = bench.tick();
        let [first, second, third] = [3, 4, 1].map(|index| pulses(view.axes[index].pos));
        assert!((first - pulses(view.axes[0].pos) / 2.0).abs() < 1e-6);
        assert!((third - second / 2.0).abs() < 1e-6);
        if first.abs() < 50.0 && end.0 == 0.0 {
            assert!((second - first * first / 200.0 * first.signum()).abs() < 1e-5, "{second} at {first}");
        } else {
            end = (50.0, 12.5);
            assert!((second - end.1 - (first - end.0) / 2.0).abs() < 1e-5, "{second} at {first}");
        }
    }
    assert_eq!(end.0, 50.0);
}

#[test]
fn a_stop_ends_it_and_a_start_goes_on_from_there() {
    for abrupt in [AxisMask(0), all(&[1])] {
        let mut bench = bench(250);
        bench.follows(1, 0, MasterPosition::Planned);
        ratio(&mut bench, 1, 1, 2, 0);
        bench.jog(0, 20.0, 10.0);
        bench.ticks(50);
        bench.start_follow(&[1]);
        bench.ticks(50);
        let stop = bench.now(TickCommand::stop(all(&[1]), abrupt));
        bench.tick();
        assert!(stop > 0);
        if abrupt.0 == 0 {
            // While it brakes it cannot take a ratio.
            let refused = bench.start_follow(&[1]);
            bench.tick();
            let event = bench.event();
            assert!(matches!(event, Some(Event::Refused { seq, .. }) if seq == refused), "{event:?}");
        }
        let view = bench.ticks(200);
        assert!(!has(&view.axes[1], status::RUNNING));
        let reason = if abrupt.0 == 0 { StopReason::StopSmooth } else { StopReason::StopAbrupt };
        assert_eq!(view.axes[1].stop, reason);
        let at = view.axes[1].pos;
        bench.start_follow(&[1]);
        let view = bench.tick();
        let from = (pulses(view.axes[0].pos), pulses(at));
        for _ in 0..100 {
            assert!(off(&bench.tick(), 1, 2.0, from).abs() < 1e-6);
        }
    }
}

#[test]
fn limits_end_it_with_their_reason() {
    let mut bench = bench(250);
    bench.follows(1, 0, MasterPosition::Planned);
    ratio(&mut bench, 1, 1, 5, 0);
    bench.now(TickCommand::SoftLimit { axis: axis(1), positive: Some(1000), negative: None });
    bench.start_follow(&[1]);
    bench.jog(0, 20.0, 10.0);
    let view = bench.ticks(200);
    assert_eq!((view.axes[1].pos, view.axes[1].stop), (Pos::pulses(1000), StopReason::SoftPositive));
    assert!(has(&view.axes[0], status::RUNNING));
    // Steps: 100 pulse/ms at most.
    let mut bench = Bench::limited(250, StepLimit::new(100).unwrap());
    bench.prepare_start(MotionMode::Gear);
    bench.now(TickCommand::SetMode { axis: axis(0), mode: MotionMode::Jog });
    bench.follows(1, 0, MasterPosition::Planned);
    ratio(&mut bench, 1, 1, 5, 0);
    bench.start_follow(&[1]);
    bench.jog(0, 20.5, 1.0);
    let (mut before, mut fastest) = (Pos(0), 0);
    for _ in 0..200 {
        let view = bench.tick();
        fastest = fastest.max(view.axes[1].pos.0 - before.0);
        before = view.axes[1].pos;
    }
    assert_eq!(bench.tick().axes[1].stop, StopReason::StepLimit);
    assert!(fastest <= (25 << Pos::FRAC_BITS) + 1, "{fastest}");
}

#[test]
fn it_needs_its_mode_a_master_and_a_ratio() {
    let mut bench = bench(250);
    let refused = |bench: &mut Bench| {
        bench.start_follow(&[1]);
        bench.ticks(2);
        matches!(bench.event(), Some(Event::Refused { .. }))
    };
    ratio(&mut bench, 1, 1, 1, 0);
    assert!(refused(&mut bench), "no master");
    bench.now(TickCommand::FollowMaster {
        axis: axis(1),
        master: Master { axis: axis(0), value: MasterPosition::Planned },
    });
    // Another mode forgets the ratio, and takes none.
    bench.now(TickCommand::SetMode { axis: axis(1), mode: MotionMode::Follow });
    ratio(&mut bench, 1, 1, 1, 0);
    bench.now(TickCommand::SetMode { axis: axis(1), mode: MotionMode::Gear });
    assert!(refused(&mut bench), "no ratio");
    ratio(&mut bench, 1, 1, 1, 0);
    assert!(!refused(&mut bench));
    let view = bench.tick();
    assert!(has(&view.axes[1], status::RUNNING));
}

#[test]
fn it_begins_at_the_crossing_and_not_a_tick_later() {
    let mut bench = bench(1000);
    bench.follows(1, 0, MasterPosition::Planned);
    ratio(&mut bench, 1, 1, 3, 0);
    bench.now(TickCommand::FollowEvent { axis: axis(1), event: StartEvent::Pass { up: true, pos: 101 } });
    bench.start_follow(&[1]);
    bench.jog(0, 30.0, 1000.0);
    let mut view = bench.ticks(2);
    while pulses(view.axes[0].pos) < 1000.0 {
        view = bench.tick();
        let way = (pulses(view.axes[0].pos) - 101.0).max(0.0);
        assert!((pulses(view.axes[1].pos) - 3.0 * way).abs() < 1e-6, "{way}");
    }
    assert!(view.now > Ns(0));
}
