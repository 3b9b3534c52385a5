//! Follow through the tick: order, starts, turning points, switches, guards, published views.
use crate::tick_bench;
#[path = "follow_tick/encoder.rs"]
mod encoder;
use servo::segment::follow::{Direction, FollowChain, MasterPosition, Method, StartEvent as Start};
use servo::status;
use servo::tick_command::{MotionMode, TickCommand};
use servo::units::Pos;
use servo::view::{Event, StopReason};
use tick_bench::*;

/// Axis 0 a jogging master, the others ready to follow.
fn bench(period_us: u32) -> Bench {
    let mut bench = Bench::prepared(period_us, MotionMode::Follow);
    bench.now(TickCommand::SetMode { axis: axis(0), mode: MotionMode::Jog });
    bench
}

fn loops(bench: &mut Bench, index: usize, passes: u32) {
    bench.now(TickCommand::FollowLoop { axis: axis(index), passes });
}

/// Displacement in a segment from ratio r0 over `m` with displacement `p`, at the part `t` of it.
fn inside(r0: f64, m: f64, p: f64, t: f64) -> f64 {
    r0 * m * t + (p - r0 * m) * t * t
}

#[test]
fn the_flying_shear_of_tables_3_2_and_3_3() {
    // Area 1: 2500 in 5000; area 2: five segments of ratio 1, 1 to 0.6, 0.6, 0.6 to 1, 1.
    let data =
        [(1000.0, 1000.0, 3), (4000.0, 3400.0, 0), (6000.0, 4600.0, 0), (9000.0, 7000.0, 0), (10000.0, 8000.0, 0)];
    let shear = |x: f64| {
        if x <= 0.0 {
            return 0.0;
        }
        if x <= 5000.0 {
            return inside(0.0, 5000.0, 2500.0, x / 5000.0);
        }
        let pass = ((x - 5000.0) / 10000.0).floor();
        let x = x - 5000.0 - pass * 10000.0;
        let ratios = [1.0, 1.0, 0.6, 0.6, 1.0];
        let (mut m, mut s) = (0.0, 0.0);
        for ((m1, s1, _), r0) in data.into_iter().zip(ratios) {
            if x < m1 {
                return 2500.0 + pass * 8000.0 + s + inside(r0, m1 - m, s1 - s, (x - m) / (m1 - m));
            }
            (m, s) = (m1, s1);
        }
        unreachable!()
    };
    for period in [50, 250, 1000] {
        let mut bench = bench(period);
        bench.follows(1, 0, MasterPosition::Planned);
        bench.follow(1, 0, &[Item::Data(5000.0, 2500.0, 0, 0)]);
        bench.follow(1, 1, &data.map(|(m, s, kind)| Item::Data(m, s, kind, 0)));
        loops(&mut bench, 1, 0);
        bench.start_follow(&[1]);
        bench.jog(0, 50.0, 10.0);
        bench.now(TickCommand::FollowSwitch { axes: all(&[1]) });
        let mut view = bench.tick();
        assert!(view.axes[1].switching && has(&view.axes[1], status::RUNNING));
        let mut ratios = vec![];
        for _ in 0..700_000 / period {
            view = bench.tick();
            let master = pulses(view.axes[0].pos);
            let off = pulses(view.axes[1].pos) - shear(master);
            assert!(off.abs() < 2e-5, "{off} off at {master}");
            let speed = real(view.velocity(&view.axes[1]));
            ratios.push((master, speed / real(view.velocity(&view.axes[0])).max(1e-9)));
        }
        assert_eq!((view.axes[1].fifo, view.axes[1].switching, view.axes[1].cleared), (1, false, [1, 0]));
        assert_eq!(view.axes[1].passes, ((pulses(view.axes[0].pos) - 5000.0) / 10000.0) as u32);
        // In the middle of the areas' parts of constant ratio.
        for (from, to, ratio) in [(5001.0, 5999.0, 1.0), (9001.0, 10999.0, 0.6), (14001.0, 15999.0, 1.0)] {
            for (at, seen) in ratios.iter().filter(|(at, _)| (from..to).contains(at)) {
                assert!((seen - ratio).abs() < 1e-9, "{seen} at {at}");
            }
        }
    }
}

#[test]
fn a_chain_in_reverse_shows_no_lag() {
    let mut bench = Bench::prepared(250, MotionMode::Follow);
    bench.now(TickCommand::SetMode { axis: axis(7), mode: MotionMode::Jog });
    for index in 0..7 {
        bench.follows(index, index + 1, MasterPosition::Planned);
        bench.follow(index, 0, &[Item::Data(1000.0, 1000.0, 1, 0)]);
        loops(&mut bench, index, 0);
    }
    bench.start_follow(&[0, 1, 2, 3, 4, 5, 6]);
    bench.jog(7, 37.0, 3.0);
    for tick in 0..4000 {
        let view = bench.tick();
        for index in 0..7 {
            let (own, master) = (view.axes[index].pos.0, view.axes[7].pos.0);
            assert!(own.abs_diff(master) <= 8, "axis {index} at {own}, master at {master}, tick {tick}");
        }
        if tick > 100 {
            let speed = |index| real(view.velocity(&view.axes[index]));
            assert!((speed(0) - speed(7)).abs() < 1e-9, "{} {}", speed(0), speed(7));
        }
    }
    // Back, through the whole chain.
    bench.jog(7, -41.0, 5.0);
    for _ in 0..2000 {
        let view = bench.tick();
        assert!(view.axes[0].pos.0.abs_diff(view.axes[7].pos.0) <= 8);
    }
}

#[test]
fn a_turning_point_of_a_slave_counts_for_its_slaves() {
    let mut bench = Bench::prepared(1000, MotionMode::Follow);
    bench.now(TickCommand::SetMode { axis: axis(7), mode: MotionMode::Jog });
    bench.follows(1, 7, MasterPosition::Planned);
    // From ratio 2 to −2: it turns at 15, at master 15.
    bench.follow(1, 0, &[Item::Data(10.0, 10.0, 0, 0), Item::Data(20.0, 10.0, 0, 0)]);
    bench.follows(0, 1, MasterPosition::Planned);
    bench.now(TickCommand::FollowDirection { axis: axis(0), direction: Direction::Up });
    bench.follow(0, 0, &[Item::Data(100.0, 300.0, 1, 0)]);
    bench.start_follow(&[0, 1]);
    bench.jog(7, 4.1, 1000.0);
    for _ in 0..5 {
        let view = bench.tick();
        let (x, s) = (pulses(view.axes[7].pos), pulses(view.axes[1].pos));
        let furthest = if x > 15.0 { 15.0 } else { s };
        assert!((pulses(view.axes[0].pos) - 3.0 * furthest).abs() < 1e-4, "{} at {x}", pulses(view.axes[0].pos));
        assert!(s < 14.9);
    }
}

/// A Trap of axis 0 to 100 and back, whose turning point lies inside a tick.
fn swing(bench: &mut Bench, target: i32) {
    let zero = speed(0.0);
    let ms = servo::units::Ns(0);
    bench.now(TickCommand::TrapPrm { axis: axis(0), acc: accel(1.0), dec: accel(1.0), vel_start: zero, smooth: ms });
    bench.now(TickCommand::TargetSpeed { axis: axis(0), speed: speed(1000.0) });
    bench.now(TickCommand::TargetPosition { axis: axis(0), pulses: target });
    bench.now(TickCommand::Update { axes: all(&[0]) });
}

#[test]
fn a_pass_is_where_the_master_crosses() {
    for (up, target, event, lands) in [(true, 1000, 300, 700.0), (false, -1000, -300, 700.0)] {
        let mut bench = Bench::prepared(250, MotionMode::Follow);
        bench.now(TickCommand::SetMode { axis: axis(0), mode: MotionMode::Trap });
        bench.follows(1, 0, MasterPosition::Planned);
        bench.now(TickCommand::FollowEvent { axis: axis(1), event: Start::Pass { up, pos: event } });
        let sign = if up { 1.0 } else { -1.0 };
        bench.follow(1, 0, &[Item::Data(sign * 5000.0, 10_000.0, 1, 0)]);
        bench.start_follow(&[1]);
        swing(&mut bench, target);
        let mut before = 0.0;
        for _ in 0..8000 {
            let view = bench.tick();
            let master = pulses(view.axes[0].pos);
            let truth = (2.0 * sign * (master - event as f64)).max(0.0);
            assert!((pulses(view.axes[1].pos) - truth).abs() < 1e-5, "{} at {master}", pulses(view.axes[1].pos));
            assert!(has(&view.axes[1], status::RUNNING));
            before = truth;
        }
        assert_eq!(before, 2.0 * lands);
        // If it starts beyond it, it has to come back first.
        bench.now(TickCommand::stop(all(&[1]), all(&[1])));
        bench.now(TickCommand::SetPosition { axis: axis(1), pos: Pos(0) });
        bench.start_follow(&[1]);
        swing(&mut bench, target + (target.signum() * 500));
        assert_eq!(bench.ticks(8000).axes[1].pos, Pos(0));
        swing(&mut bench, 0);
        assert_eq!(bench.ticks(8000).axes[1].pos, Pos(0));
        swing(&mut bench, target);
        assert_eq!(bench.ticks(8000).axes[1].pos, Pos::pulses(1400));
    }
}

#[test]
fn a_crossing_between_ticks_counts() {
    // The master reverses inside a tick, 1/32 pulse beyond the position: at neither tick it is
    // there.
    let mut bench = Bench::prepared(1000, MotionMode::Follow);
    bench.now(TickCommand::SetMode { axis: axis(0), mode: MotionMode::PtStatic });
    // v = 1 − t/1.5 from 0 on: the peak of 0.75 at 1.5 ms.
    bench.pt(0, 0, &[(1000.0, 1000, 1), (1000.75 - 0.75, 1003, 0), (0.0, 2003, 1)]);
    bench.follows(1, 0, MasterPosition::Planned);
    bench.now(TickCommand::FollowDirection { axis: axis(1), direction: Direction::Up });
    bench.follow(1, 0, &[Item::Data(100.0, 300.0, 1, 0)]);
    bench.now(TickCommand::FollowEvent { axis: axis(1), event: Start::Pass { up: true, pos: 1000 } });
    bench.follows(2, 0, MasterPosition::Planned);
    bench.now(TickCommand::FollowDirection { axis: axis(2), direction: Direction::Up });
    bench.follow(2, 0, &[Item::Data(1000.5, 2001.0, 1, 0)]);
    bench.follows(3, 0, MasterPosition::Planned);
    bench.follow(3, 0, &[Item::Data(1000.6875, 2001.375, 1, 0)]);
    bench.start_follow(&[1, 2, 3]);
    bench.start(&[0]);
    let mut view = bench.tick();
    for _ in 0..1010 {
        view = bench.tick();
        assert!(pulses(view.axes[0].pos) <= 1000.0 + 2.0 / 3.0 + 1e-6, "{}", pulses(view.axes[0].pos));
    }
    // From 1000 the master reaches 1000.75 between ticks (0.6667 at both of them).
    assert!((pulses(view.axes[1].pos) - 0.75 * 3.0).abs() < 1e-5, "{}", pulses(view.axes[1].pos));
    // The furthest point ends a motion, also one of direction 0.
    assert_eq!((view.axes[2].pos, view.axes[2].stop), (Pos::pulses(2001), StopReason::Completed));
    assert_eq!((pulses(view.axes[3].pos), view.axes[3].stop), (2001.375, StopReason::Completed));
}

#[test]
fn back_through_three_passes_to_the_bit() {
    let mut bench = bench(250);
    bench.follows(1, 0, MasterPosition::Planned);
    let items = [
        Item::Data(33.3, 10.1, 0, 40),
        Item::Data(77.7, -5.5, 0, 100),
        Item::Data(100.1, 3.3, 2, 7),
        Item::Data(133.3, 7.7, 1, 0),
    ];
    bench.follow(1, 0, &items);
    loops(&mut bench, 1, 0);
    bench.start_follow(&[1]);
    bench.now(TickCommand::SetMode { axis: axis(0), mode: MotionMode::PtStatic });
    // 400.25 up in 512 ms, and back the same way.
    bench.pt(0, 0, &[(400.25, 512, 1), (0.0, 1024, 1)]);
    bench.start(&[0]);
    let mut there = vec![bench.tick()];
    for _ in 0..2047 {
        there.push(bench.tick());
    }
    assert_eq!(there.last().unwrap().axes[1].passes, 3);
    assert_eq!(bench.tick().axes[1].passes, 3);
    for before in there.iter().rev() {
        let view = bench.tick();
        // The path back is another piece of the master's, whose position differs in the last bits.
        let gap = view.axes[0].pos.0 - before.axes[0].pos.0;
        assert!(gap.abs() <= 2);
        if gap == 0 {
            assert_eq!(view.axes[1].pos, before.axes[1].pos);
            assert_eq!(view.axes[1].passes, before.axes[1].passes);
        }
    }
    assert_eq!(bench.tick().axes[1].pos, Pos(0));
    // Before the start it rests at its origin.
    bench.pt(0, 1, &[(-50.0, 100, 1), (0.0, 200, 1)]);
    bench.now(TickCommand::PtStart { axes: all(&[0]), fifo1: all(&[0]) });
    for _ in 0..900 {
        let view = bench.tick();
        assert_eq!(view.axes[1].pos, Pos(0));
        assert!(has(&view.axes[1], status::RUNNING) && real(view.velocity(&view.axes[1])) == 0.0);
    }
}

#[test]
fn loops_run_out_and_change_while_running() {
    let mut bench = bench(250);
    bench.follows(1, 0, MasterPosition::Planned);
    bench.follow(1, 0, &[Item::Data(10.0, 7.0, 1, 0)]);
    loops(&mut bench, 1, 100);
    bench.start_follow(&[1]);
    bench.jog(0, 1.0, 1000.0);
    assert_eq!(bench.ticks(4 * 55).axes[1].passes, 5);
    loops(&mut bench, 1, 7);
    let view = bench.ticks(4 * 30);
    assert_eq!((view.axes[1].passes, view.axes[1].pos, view.axes[1].stop), (7, Pos::pulses(49), StopReason::Completed));
    assert!(!has(&view.axes[1], status::RUNNING));
    // A motion that is started again begins where it ended, with the data kept.
    loops(&mut bench, 1, 1);
    bench.start_follow(&[1]);
    let view = bench.ticks(4 * 11);
    assert_eq!((view.axes[1].pos, view.axes[1].passes), (Pos::pulses(56), 1));
}

#[test]
fn switches_at_the_end_of_a_pass_and_at_once() {
    let mut bench = bench(250);
    bench.follows(1, 0, MasterPosition::Planned);
    bench.follow(1, 0, &[Item::Data(10.0, 10.0, 0, 0)]);
    bench.start_follow(&[1]);
    bench.jog(0, 1.0, 1000.0);
    bench.ticks(4);
    // An empty FIFO is refused.
    let seq = bench.now(TickCommand::FollowSwitch { axes: all(&[1]) });
    bench.tick();
    assert!(matches!(bench.event(), Some(Event::Refused { seq: refused, .. }) if refused == seq));
    // The loop count has run out, the switch wins: CONTINUE goes on at ratio 2 in every pass.
    bench.follow(1, 1, &[Item::Data(10.0, 20.0, 3, 0), Item::Data(20.0, 40.0, 0, 0)]);
    bench.now(TickCommand::FollowSwitch { axes: all(&[1]) });
    let view = bench.ticks(4 * 10);
    assert_eq!((view.axes[1].fifo, view.axes[1].passes, view.axes[1].cleared), (1, 0, [1, 0]));
    let truth = |x: f64| 10.0 + 2.0 * (x - 10.0);
    for _ in 0..30 {
        let view = bench.tick();
        let x = pulses(view.axes[0].pos);
        assert!((pulses(view.axes[1].pos) - truth(x)).abs() < 1e-5, "{} at {x}", pulses(view.axes[1].pos));
    }
    // The other FIFO at once: NORMAL starts at the ratio of the instant too.
    bench.emptied(1, 0);
    bench.follow(1, 0, &[Item::Data(10.0, 10.0, 0, 0), Item::Data(20.0, 20.0, 0, 0)]);
    bench.now(TickCommand::FollowSwitchNow { axis: axis(1), method: Method::Table });
    let view = bench.tick();
    let (x0, s0) = (pulses(view.axes[0].pos), pulses(view.axes[1].pos));
    assert!((s0 - truth(x0)).abs() < 1e-5);
    assert_eq!((view.axes[1].fifo, view.axes[1].cleared), (0, [1, 1]));
    // Data for the FIFO's content before the switch is refused.
    let (end, tail) = (3, FollowChain::default().tail());
    let void = bench.now(TickCommand::FollowCommit { axis: axis(1), fifo: 1, end, cleared: 0, tail });
    for _ in 0..70 {
        let view = bench.tick();
        let x = pulses(view.axes[0].pos) - x0;
        // Ratio 2 to 0, then 0 to 2.
        let s =
            if x < 10.0 { inside(2.0, 10.0, 10.0, x / 10.0) } else { 10.0 + inside(0.0, 10.0, 10.0, x / 10.0 - 1.0) };
        assert!((pulses(view.axes[1].pos) - s0 - s).abs() < 1e-5, "{} for {s} at {x}", pulses(view.axes[1].pos) - s0);
    }
    assert!(matches!(bench.event(), Some(Event::Refused { seq, .. }) if seq == void));
    // In the last segment, a switch by segment ends the pass; here, the motion.
    bench.now(TickCommand::FollowSwitchNow { axis: axis(1), method: Method::Segment });
    let view = bench.tick();
    assert_eq!(view.axes[1].stop, StopReason::Completed);
    assert_eq!(view.axes[1].passes, 1);
}

#[test]
fn ratios_go_on_from_fifo_to_fifo() {
    let mut bench = bench(250);
    bench.follows(1, 0, MasterPosition::Planned);
    // Ratios 0 to 2; 2 to 1 and 1 to 0; 0 to 3.
    bench.follow(1, 0, &[Item::Data(10.0, 10.0, 0, 0)]);
    bench.follow(1, 1, &[Item::Data(10.0, 15.0, 3, 0), Item::Data(20.0, 20.0, 0, 0), Item::Data(30.0, 40.0, 0, 0)]);
    bench.start_follow(&[1]);
    bench.jog(0, 1.0, 1000.0);
    bench.now(TickCommand::FollowSwitch { axes: all(&[1]) });
    bench.ticks(4 * 15);
    // 4 to 2, for the last segment went from 0 to 4.
    bench.emptied(1, 0);
    bench.follow(1, 0, &[Item::Data(10.0, 30.0, 3, 0)]);
    bench.now(TickCommand::FollowSwitch { axes: all(&[1]) });
    for _ in 0..4 * 34 {
        let view = bench.tick();
        let x = pulses(view.axes[0].pos);
        let s = if x < 20.0 {
            10.0 + inside(2.0, 10.0, 15.0, x / 10.0 - 1.0)
        } else if x < 30.0 {
            25.0 + inside(1.0, 10.0, 5.0, x / 10.0 - 2.0)
        } else if x < 40.0 {
            30.0 + inside(0.0, 10.0, 20.0, x / 10.0 - 3.0)
        } else {
            50.0 + inside(4.0, 10.0, 30.0, x / 10.0 - 4.0)
        };
        if x < 50.0 {
            assert!((pulses(view.axes[1].pos) - s).abs() < 2e-5, "{} for {s} at {x}", pulses(view.axes[1].pos));
        }
    }
}

#[test]
fn a_switch_by_segment_carries_its_ratio_through_the_chain() {
    let mut bench = bench(250);
    bench.follows(1, 0, MasterPosition::Planned);
    let items = [
        Item::Data(10.0, 10.0, 0, 0),
        Item::Data(20.0, 30.0, 0, 0),
        Item::Data(30.0, 45.0, 0, 0),
        Item::Data(35.0, 50.0, 1, 0),
        Item::Data(40.0, 55.0, 0, 0),
    ];
    bench.follow(1, 0, &items);
    loops(&mut bench, 1, 2);
    bench.start_follow(&[1]);
    bench.jog(0, 1.0, 1000.0);
    // In the first segment, at about 6: ratio x/5.
    bench.ticks(4 * 6);
    bench.now(TickCommand::FollowSwitchNow { axis: axis(1), method: Method::Segment });
    let view = bench.tick();
    let (x0, s0) = (pulses(view.axes[0].pos), pulses(view.axes[1].pos));
    let ratio = x0 / 5.0;
    assert!((s0 - x0 * x0 / 10.0).abs() < 1e-5);
    let after = 4.0 - ratio;
    for _ in 0..4 * 60 {
        let view = bench.tick();
        let x = pulses(view.axes[0].pos) - x0;
        let s = if x < 10.0 {
            inside(ratio, 10.0, 20.0, x / 10.0)
        } else if x < 20.0 {
            20.0 + inside(after, 10.0, 15.0, x / 10.0 - 1.0)
        } else if x < 30.0 {
            // After an EVEN, and in the second pass, it has no effect.
            35.0 + (x - 20.0)
        } else if x < 40.0 {
            45.0 + inside(0.0, 10.0, 10.0, x / 10.0 - 3.0)
        } else if x < 50.0 {
            55.0 + inside(2.0, 10.0, 20.0, x / 10.0 - 4.0)
        } else {
            75.0 + inside(2.0, 10.0, 15.0, x / 10.0 - 5.0)
        };
        let at = pulses(view.axes[1].pos) - s0;
        if x < 60.0 {
            assert!((at - s).abs() < 2e-5, "{at} for {s} at {x}");
        }
    }
}

#[test]
fn guards_stop_a_slave() {
    // Step limit.
    let mut bench = bench(250);
    bench.follows(1, 0, MasterPosition::Planned);
    bench.follow(1, 0, &[Item::Data(0.001, 4e9, 1, 0)]);
    loops(&mut bench, 1, 0);
    bench.start_follow(&[1]);
    bench.jog(0, 1.0, 1000.0);
    let view = bench.ticks(4);
    assert_eq!((view.axes[1].stop, view.axes[1].pos), (StopReason::StepLimit, Pos(0)));
    assert!(!has(&view.axes[1], status::RUNNING));
    // 2³³ pulse/ms inside one segment.
    let mut bench = self::bench(250);
    bench.follows(1, 0, MasterPosition::Planned);
    bench.follow(1, 0, &[Item::Data(100.0, 100.0 * 2f64.powi(33), 1, 0)]);
    bench.start_follow(&[1]);
    bench.jog(0, 1.0, 1000.0);
    let view = bench.ticks(4);
    assert_eq!(view.axes[1].stop, StopReason::StepLimit);
    assert!(pulses(view.axes[1].pos) < 2f64.powi(30), "{}", pulses(view.axes[1].pos));
    // The master gets too fast inside a segment.
    let mut bench = self::bench(250);
    bench.follows(1, 0, MasterPosition::Planned);
    bench.follow(1, 0, &[Item::Data(100.0, 100.0 * 2f64.powi(32), 1, 0)]);
    bench.start_follow(&[1]);
    bench.jog(0, 2.0, 0.5);
    let view = bench.ticks(4 * 3);
    // At 1 pulse/ms, after 2 ms.
    assert_eq!(view.axes[1].stop, StopReason::StepLimit);
    assert!((pulses(view.axes[1].pos) / 2f64.powi(32) - 1.0).abs() < 0.15);
    // Soft limit, alarm, servo off, abrupt.
    for case in 0..4 {
        let mut bench = Bench::prepared(250, MotionMode::Follow);
        bench.now(TickCommand::SetMode { axis: axis(0), mode: MotionMode::Jog });
        bench.follows(1, 0, MasterPosition::Planned);
        bench.follow(1, 0, &[Item::Data(1000.0, 2000.0, 1, 0)]);
        bench.start_follow(&[1]);
        bench.jog(0, 10.0, 1000.0);
        bench.ticks(10);
        let expected = match case {
            0 => {
                bench.now(TickCommand::SoftLimit { axis: axis(1), positive: Some(100), negative: None });
                StopReason::SoftPositive
            }
            1 => {
                bench.machine.inputs[1].alarm = true;
                StopReason::Alarm
            }
            2 => {
                bench.now(TickCommand::Servo { axis: axis(1), on: false });
                StopReason::ServoOff
            }
            _ => {
                bench.now(TickCommand::stop(all(&[1]), all(&[1])));
                StopReason::StopAbrupt
            }
        };
        let view = bench.ticks(40);
        assert_eq!(view.axes[1].stop, expected);
        assert_eq!(stopped(bench.event()), (1, expected));
        if case == 0 {
            assert_eq!(view.axes[1].pos, Pos::pulses(100));
        }
        assert_eq!(real(view.velocity(&view.axes[1])), 0.0);
    }
}

#[test]
fn a_smooth_stop_leaves_the_master_and_brakes() {
    let mut bench = bench(250);
    bench.follows(1, 0, MasterPosition::Planned);
    bench.follows(2, 1, MasterPosition::Planned);
    for index in [1, 2] {
        bench.follow(index, 0, &[Item::Data(100_000.0, 200_000.0, 1, 0)]);
        bench.now(TickCommand::StopDec { axis: axis(index), smooth: accel(4.0), abrupt: accel(1.0) });
    }
    bench.start_follow(&[2, 1]);
    bench.jog(0, 10.0, 1000.0);
    let view = bench.ticks(100);
    assert!((real(view.velocity(&view.axes[2])) - 40.0).abs() < 1e-9);
    assert_eq!(real(view.motion(&view.axes[2]).acceleration()), 0.0);
    bench.now(TickCommand::stop(all(&[1]), all(&[])));
    let view = bench.tick();
    let from = pulses(view.axes[1].pos);
    assert!((real(view.velocity(&view.axes[1])) - 20.0).abs() < 1e-9);
    // 20 pulse/ms at 4 pulse/ms²: 50 pulses in 5 ms; axis 2 follows all of it.
    let view = bench.ticks(10);
    assert!((pulses(view.axes[1].pos) - from - 37.5).abs() < 1e-5, "50 − ½·4·2.5²");
    assert!((real(view.velocity(&view.axes[1])) - 10.0).abs() < 1e-9);
    let view = bench.ticks(20);
    assert_eq!(view.axes[1].stop, StopReason::StopSmooth);
    assert!((pulses(view.axes[1].pos) - from - 50.0).abs() < 1e-5);
    assert!((pulses(view.axes[2].pos) - 2.0 * pulses(view.axes[1].pos)).abs() < 1e-5);
    assert!(has(&view.axes[2], status::RUNNING));
    bench.now(TickCommand::stop(all(&[2]), all(&[])));
    let view = bench.ticks(3);
    assert_eq!(view.axes[2].stop, StopReason::StopSmooth);
}

#[test]
fn renaming_the_master_moves_nothing() {
    let mut bench = Bench::prepared(250, MotionMode::Follow);
    bench.follows(1, 0, MasterPosition::Planned);
    bench.now(TickCommand::SetMode { axis: axis(0), mode: MotionMode::Trap });
    bench.follow(1, 0, &[Item::Data(1000.0, 1000.0, 1, 0)]);
    bench.start_follow(&[1]);
    swing(&mut bench, 100);
    assert_eq!(bench.ticks(400).axes[1].pos, Pos::pulses(100));
    bench.now(TickCommand::SetPosition { axis: axis(0), pos: Pos::pulses(-5000) });
    assert_eq!(bench.ticks(2).axes[1].pos, Pos::pulses(100));
    swing(&mut bench, -4900);
    let view = bench.ticks(400);
    assert_eq!((view.axes[0].pos, view.axes[1].pos), (Pos::pulses(-4900), Pos::pulses(200)));
    // A PASS means the user position that is in force now.
    bench.now(TickCommand::stop(all(&[1]), all(&[1])));
    bench.now(TickCommand::FollowEvent { axis: axis(1), event: Start::Pass { up: true, pos: -4850 } });
    bench.start_follow(&[1]);
    swing(&mut bench, -4800);
    assert_eq!(bench.ticks(400).axes[1].pos, Pos::pulses(250));
}

#[test]
fn starts_are_refused_as_a_whole() {
    let mut bench = Bench::prepared(250, MotionMode::Follow);
    bench.follows(1, 0, MasterPosition::Planned);
    bench.follow(1, 0, &[Item::Data(1000.0, 1000.0, 1, 0)]);
    // Axis 2 has no master, then no data.
    for step in 0..2 {
        let seq = bench.start_follow(&[1, 2]);
        let view = bench.tick();
        assert!(!has(&view.axes[1], status::RUNNING), "step {step}");
        assert!(matches!(bench.event(), Some(Event::Refused { seq: refused, .. }) if refused == seq));
        bench.follows(2, 0, MasterPosition::Planned);
    }
    bench.follow(2, 0, &[Item::Data(1000.0, 1000.0, 1, 0)]);
    bench.start_follow(&[1, 2]);
    assert!(has(&bench.tick().axes[2], status::RUNNING));
    assert!(bench.event().is_none());
}
