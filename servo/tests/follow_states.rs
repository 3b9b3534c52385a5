//! Follow in combined states: renamed positions; masters that are planned again, stopped, switched.
use crate::tick_bench;
use servo::segment::follow::{Direction, MasterPosition, StartEvent as Start};
use servo::tick_command::{MotionMode, TickCommand};
use servo::units::Pos;
use tick_bench::*;

/// Positions of axes, in pulses of the machine.
fn positions(bench: &Bench) -> [f64; AXES] {
    bench.machine.set_points.map(pulses)
}

/// A chain 0 ← 1 ← 2; the position of the middle one has another user value than in the machine.
#[test]
fn a_slave_of_a_renamed_slave_stays_where_it_is() {
    for (mode, direction) in [MotionMode::Follow, MotionMode::FollowEx]
        .into_iter()
        .flat_map(|mode| [Direction::Both, Direction::Up].map(|d| (mode, d)))
    {
        let mut bench = Bench::prepared(250, mode);
        bench.now(TickCommand::SetMode { axis: axis(0), mode: MotionMode::Jog });
        for (slave, master) in [(1, 0), (2, 1)] {
            bench.now(TickCommand::FollowDirection { axis: axis(slave), direction });
            bench.follows(slave, master, MasterPosition::Planned);
            // Knots of the middle axis lie inside ticks.
            let items: Vec<Item> = (1..10).map(|k| Item::Data(33.3 * k as f64, 33.3 * k as f64, 0, 0)).collect();
            bench.follow_in(slave, 0, direction, &items);
            bench.now(TickCommand::FollowLoop { axis: axis(slave), passes: 0 });
        }
        for run in 0..2 {
            bench.now(TickCommand::SetPosition { axis: axis(1), pos: Pos::pulses(150) });
            bench.tick();
            let begin = positions(&bench);
            bench.start_follow(&[1, 2]);
            bench.jog(0, 20.0, 1.0);
            for _ in 0..400 {
                bench.tick();
                let now = positions(&bench);
                let path = now[0] - begin[0];
                // Every NORMAL segment starts at 0, at 2, at 0: twice the length, half of it in
                // between.
                assert!((now[2] - begin[2]) >= -1e-5 && now[2] - begin[2] <= 2.0 * path + 80.0, "{now:?} run {run}");
                let (x, y) = (now[1] - begin[1], now[2] - begin[2]);
                assert!((y - zigzag(x)).abs() < 1e-4, "{y} where the master has gone {x}, run {run}, {mode:?}");
            }
            bench.now(TickCommand::stop(all(&[0, 1, 2]), all(&[0, 1, 2])));
            bench.tick();
            bench.now(TickCommand::Zero { axes: all(&[0, 1, 2]) });
        }
    }
}

/// NORMAL segments of 33.3 on 33.3, from ratio 0 on: 0 to 2, 2 to 0.
fn zigzag(x: f64) -> f64 {
    let length = 33.3;
    let pass = (x / (9.0 * length)).floor().max(0.0);
    let in_pass = x - pass * 9.0 * length;
    let segment = (in_pass / length).floor().clamp(0.0, 8.0);
    let t = in_pass / length - segment;
    let inside = if (segment as u32).is_multiple_of(2) { t * t } else { 2.0 * t - t * t };
    (pass * 9.0 + segment + inside) * length
}

/// The master's position at each tick, and that of a slave of ratio 3 that follows it in one
/// direction.
#[test]
fn a_master_that_is_planned_again_while_it_brakes_is_never_further_than_it_went() {
    for (direction, sign) in [(Direction::Up, 1.0), (Direction::Down, -1.0)] {
        for again in 0..4 {
            for (smooth, after) in [(0, 5), (0, 17), (0, 37), (30_000, 17)] {
                let mut bench = Bench::prepared(250, MotionMode::Follow);
                bench.now(TickCommand::SetMode { axis: axis(0), mode: MotionMode::Jog });
                bench.follows(1, 0, MasterPosition::Planned);
                bench.now(TickCommand::FollowDirection { axis: axis(1), direction });
                bench.follow_in(1, 0, direction, &[Item::Data(10_000.0, 30_000.0, 1, 0)]);
                bench.start_follow(&[1]);
                let jog = |bench: &mut Bench, velocity: f64, acc: f64| {
                    let axis = axis(0);
                    bench.now(TickCommand::JogPrm { axis, acc: accel(acc), dec: accel(acc), smooth });
                    bench.now(TickCommand::TargetSpeed { axis, speed: speed(sign * velocity) });
                    bench.now(TickCommand::Update { axes: axis.mask() });
                };
                jog(&mut bench, 10.0, 1.0);
                bench.ticks(100);
                jog(&mut bench, 0.0, 0.5);
                bench.ticks(after);
                let stop = TickCommand::stop(all(&[0]), all(&[]));
                match again {
                    0 => jog(&mut bench, 0.0, 2.0),
                    1 => jog(&mut bench, 8.0, 1.5),
                    2 => drop(bench.now(stop)),
                    _ => {
                        bench.now(stop);
                        bench.tick();
                        jog(&mut bench, 3.0, 0.7);
                        bench.tick();
                        jog(&mut bench, 0.0, 0.7);
                    }
                }
                for _ in 0..100 {
                    bench.tick();
                    let [master, slave, ..] = positions(&bench);
                    assert!(
                        (slave - 3.0 * sign * master).abs() < 1e-4,
                        "{slave} behind {master}, {again} {after} {direction:?}"
                    );
                }
            }
        }
    }
}

/// Axis 1 moves three times as far as axis 0, which counts upwards to its furthest position.
fn three_times(period: u32) -> Bench {
    let mut bench = Bench::prepared(period, MotionMode::Follow);
    bench.now(TickCommand::SetMode { axis: axis(0), mode: MotionMode::Jog });
    bench.follows(1, 0, MasterPosition::Planned);
    bench.now(TickCommand::FollowDirection { axis: axis(1), direction: Direction::Up });
    bench.follow_in(1, 0, Direction::Up, &[Item::Data(100_000.0, 300_000.0, 1, 0)]);
    bench.start_follow(&[1]);
    bench
}

#[test]
fn an_abrupt_stop_of_a_master_is_no_displacement() {
    // The ramp ends between two ticks; so does a limit.
    for (after, limit) in (90..110).map(|after| (after, None)).chain((110..130).map(|limit| (200, Some(limit)))) {
        let mut bench = three_times(250);
        bench.now(TickCommand::SoftLimit { axis: axis(0), positive: limit, negative: None });
        bench.jog(0, 10.0, 10.0 / 25.1);
        bench.ticks(after);
        bench.now(TickCommand::stop(all(&[0]), all(&[0])));
        bench.now(TickCommand::SetPosition { axis: axis(0), pos: Pos::pulses(-777) });
        let view = bench.ticks(2);
        let master = pulses(bench.machine.set_points[0]);
        assert!((pulses(view.axes[1].pos) - 3.0 * master).abs() < 1e-4, "{after} {limit:?} {master}");
    }
}

#[test]
fn a_master_that_turns_round_as_it_is_planned_again() {
    // It reverses 11.3 ms, or 45.2 ticks, after the position at which it begins to, 56.5 pulses
    // further.
    for again in 40..52 {
        for velocity in [-10.0, 0.0, 4.0] {
            let mut bench = three_times(250);
            bench.jog(0, 10.0, 10.0);
            bench.ticks(400);
            bench.jog(0, -10.0, 10.0 / 11.3);
            bench.tick();
            let peak = pulses(bench.machine.set_points[0]) + 56.5;
            bench.ticks(again - 1);
            if velocity < 0.0 {
                bench.now(TickCommand::Update { axes: all(&[0]) });
            } else if again > 45 {
                bench.jog(0, velocity, 10.0 / 11.3);
            }
            bench.ticks(if again > 45 { 2 } else { 10 });
            let gone = pulses(bench.machine.set_points[1]) / 3.0;
            assert!((gone - peak).abs() < 1e-4, "{gone} {peak} {again} {velocity}");
        }
    }
}

#[test]
fn a_slave_that_ends_as_it_turns_round_counts_for_its_slaves() {
    let mut bench = Bench::prepared(1000, MotionMode::Follow);
    bench.now(TickCommand::SetMode { axis: axis(7), mode: MotionMode::Jog });
    bench.follows(1, 7, MasterPosition::Planned);
    // From ratio 2 to −1: it turns at 14, at master 14, and ends at 13, at master 16.
    bench.follow(1, 0, &[Item::Data(10.0, 10.0, 0, 0), Item::Data(16.0, 13.0, 0, 0)]);
    bench.follows(0, 1, MasterPosition::Planned);
    bench.now(TickCommand::FollowDirection { axis: axis(0), direction: Direction::Up });
    bench.follow_in(0, 0, Direction::Up, &[Item::Data(100.0, 300.0, 1, 0)]);
    bench.start_follow(&[0, 1]);
    bench.jog(7, 4.1, 1000.0);
    bench.follows(2, 1, MasterPosition::Planned);
    bench.follow(2, 0, &[Item::Data(100.0, 300.0, 1, 0)]);
    bench.start_follow(&[2]);
    let mut view = bench.ticks(4);
    for _ in 0..4 {
        view = bench.tick();
        assert_eq!(view.axes[2].pos.0.abs_diff(3 * view.axes[1].pos.0) >> 3, 0, "{:?}", view.axes[2].pos);
    }
    assert_eq!(view.axes[1].pos, Pos::pulses(13));
    assert!((pulses(view.axes[0].pos) - 42.0).abs() < 1e-4, "{}", pulses(view.axes[0].pos));
}

#[test]
fn a_slave_of_one_way_stands_from_where_its_master_turns() {
    // EVEN to 8 at 4 ms and back: a jump of the velocity, at a tick.
    for (direction, sign) in [(Direction::Both, 1), (Direction::Up, 1), (Direction::Down, 1), (Direction::Down, -1)] {
        let mut bench = Bench::prepared(250, MotionMode::Follow);
        bench.now(TickCommand::SetMode { axis: axis(0), mode: MotionMode::PtStatic });
        bench.pt(0, 0, &[(8.0 * f64::from(sign), 4, 1), (0.0, 8, 1), (8.0 * f64::from(sign), 12, 1)]);
        bench.follows(1, 0, MasterPosition::Planned);
        bench.now(TickCommand::FollowDirection { axis: axis(1), direction });
        bench.follow_in(1, 0, direction, &[Item::Data(100.0, 300.0, 1, 0)]);
        bench.follows(2, 1, MasterPosition::Planned);
        bench.follow(2, 0, &[Item::Data(100.0, 100.0, 1, 0)]);
        bench.start_follow(&[1, 2]);
        bench.tick();
        bench.start(&[0]);
        // The view of the tick of its start.
        let mut before = bench.tick();
        loop {
            let view = bench.tick();
            if !has(&view.axes[0], servo::status::RUNNING) {
                break;
            }
            // All move evenly from tick to tick.
            for slave in [1, 2] {
                let path = pulses(view.axes[slave].pos) - pulses(before.axes[slave].pos);
                let reported = real(before.velocity(&before.axes[slave]));
                assert!(
                    (reported - path / 0.25).abs() < 1e-3,
                    "{slave}: {reported} at {}, {direction:?}",
                    before.now.0
                );
                let motion = before.motion(&before.axes[slave]);
                assert_eq!((real(motion.velocity()), real(motion.acceleration())), (reported, 0.0));
            }
            before = view;
        }
    }
}

#[test]
fn a_master_that_is_stopped_before_it_turns_round_does_not_turn() {
    // From 2000 on it goes at 1 − t/0.8, turns at 0.8 ms, ends at 1 ms. The tick of the stop is
    // that from 0.6 to 1.3.
    let mut bench = three_times(700);
    bench.now(TickCommand::SetMode { axis: axis(0), mode: MotionMode::PtStatic });
    bench.pt(0, 0, &[(2000.0, 2000, 1), (2000.375, 2001, 0)]);
    bench.start(&[0]);
    let view = bench.ticks(1 + 2858);
    assert_eq!(view.axes[0].pos.0, (Pos::pulses(2000).0 + (375 << Pos::FRAC_BITS) / 1000));
    bench.now(TickCommand::stop(all(&[0]), all(&[0])));
    bench.now(TickCommand::SetPosition { axis: axis(0), pos: Pos::pulses(-7000) });
    let view = bench.ticks(3);
    assert!((pulses(view.axes[1].pos) - 3.0 * 2000.375).abs() < 1e-4, "{}", pulses(view.axes[1].pos));
}

#[test]
fn a_slave_that_turns_round_at_a_knot_counts_for_its_slaves() {
    // It reverses where the ratio jumps, between two ticks, or just before; and back at the start
    // of a pass.
    for (items, most) in [
        ([Item::Data(10.0, 10.0, 1, 0), Item::Data(30.0, -10.0, 1, 0)], 10.0),
        ([Item::Data(10.0, 9.75, 0, 0), Item::Data(30.0, -10.0, 1, 0)], 9.75),
        ([Item::Data(9.5, 10.0, 1, 0), Item::Data(30.0, -10.0, 0, 0)], 0.0),
    ] {
        for direction in [Direction::Up, Direction::Down] {
            let mut bench = Bench::prepared(1000, MotionMode::Follow);
            bench.now(TickCommand::SetMode { axis: axis(7), mode: MotionMode::Jog });
            bench.now(TickCommand::SetPosition { axis: axis(1), pos: Pos::pulses(1234) });
            bench.follows(1, 7, MasterPosition::Planned);
            bench.follow(1, 0, &items);
            bench.now(TickCommand::FollowLoop { axis: axis(1), passes: 2 });
            bench.follows(0, 1, MasterPosition::Planned);
            bench.now(TickCommand::FollowDirection { axis: axis(0), direction });
            bench.follow_in(0, 0, direction, &[Item::Data(100.0, 300.0, 1, 0)]);
            bench.tick();
            bench.start_follow(&[0, 1]);
            bench.jog(7, 4.1, 1000.0);
            // The same in ticks of 10 us has its positions more exactly.
            let mut fixed = Bench::prepared(10, MotionMode::Follow);
            fixed.now(TickCommand::SetMode { axis: axis(7), mode: MotionMode::Jog });
            fixed.follows(1, 7, MasterPosition::Planned);
            fixed.follow(1, 0, &items);
            fixed.now(TickCommand::FollowLoop { axis: axis(1), passes: 2 });
            fixed.tick();
            fixed.start_follow(&[1]);
            fixed.jog(7, 4.1, 1000.0);
            fixed.tick();
            bench.tick();
            let (mut top, mut bottom) = (0.0f64, 0.0f64);
            for _ in 0..16 {
                for _ in 0..100 {
                    let at = pulses(fixed.tick().axes[1].pos);
                    (top, bottom) = (top.max(at), bottom.min(at));
                }
                let view = bench.tick();
                assert!((pulses(view.axes[1].pos) - 1234.0 - pulses(fixed.machine.set_points[1])).abs() < 1e-4);
                let exact = if direction == Direction::Up { 3.0 * top } else { -3.0 * bottom };
                let found = pulses(view.axes[0].pos);
                assert!((found - exact).abs() < 0.13, "{found} {exact} {direction:?}, {most}");
            }
            assert!(most == 0.0 || (top - most).abs() < 0.3);
        }
    }
}

#[test]
fn a_crossing_of_the_very_knot_at_which_a_slave_turns_counts() {
    for up in [true, false] {
        let sign = if up { 1.0 } else { -1.0 };
        let mut bench = Bench::prepared(1000, MotionMode::Follow);
        bench.now(TickCommand::SetMode { axis: axis(7), mode: MotionMode::Jog });
        bench.follows(1, 7, MasterPosition::Planned);
        bench.follow(1, 0, &[Item::Data(10.3, sign * 40.0, 1, 0), Item::Data(30.0, sign * 20.0, 1, 0)]);
        bench.follows(0, 1, MasterPosition::Planned);
        bench.follow(0, 0, &[Item::Data(-sign * 10.0, 10.0, 1, 0)]);
        bench.now(TickCommand::FollowEvent { axis: axis(0), event: Start::Pass { up, pos: 40 * sign as i32 } });
        bench.start_follow(&[0, 1]);
        bench.jog(7, 4.1, 1000.0);
        let view = bench.ticks(5);
        let (master, slave) = (pulses(view.axes[1].pos), pulses(view.axes[0].pos));
        assert!(slave > 1.0 && (slave + sign * master - 40.0).abs() < 1e-4, "{slave} {master}");
    }
}

#[test]
fn a_master_at_the_position_of_a_pass_has_not_come_from_before_it() {
    let mut bench = three_times(250);
    bench.now(TickCommand::stop(all(&[1]), all(&[1])));
    bench.now(TickCommand::SetPosition { axis: axis(0), pos: Pos::pulses(500) });
    bench.now(TickCommand::FollowEvent { axis: axis(1), event: Start::Pass { up: true, pos: 500 } });
    bench.tick();
    bench.start_follow(&[1]);
    bench.tick();
    bench.jog(0, 10.0, 1.0);
    assert_eq!(bench.ticks(100).axes[1].pos, Pos(0));
    bench.jog(0, -10.0, 1.0);
    assert_eq!(bench.ticks(300).axes[1].pos, Pos(0));
    bench.jog(0, 10.0, 1.0);
    let view = bench.ticks(400);
    let (master, slave) = (pulses(view.axes[0].pos), pulses(view.axes[1].pos));
    assert!(slave > 100.0 && (slave - 3.0 * (master - 500.0)).abs() < 1e-4, "{slave} {master}");
}
