//! The effects of a path's entries on the rest of the machine, through the whole tick: outputs at
//! exact instants, other axes that are moved or geared, axes that follow a coordinate.
use crate::tick_bench;
use servo::path::{MotionSpeeds, PathEntry, Plane};
use servo::segment::follow::{Direction, MasterPosition};
use servo::status;
use servo::tick_command::{DoGroup, MotionMode, TickCommand};
use servo::units::{AxisMask, CrdMask, Pos, StepLimit};
use servo::view::{Event, StopReason, View};

use tick_bench::*;

fn speeds(vel: f64, acc: f64, end: f64) -> MotionSpeeds {
    MotionSpeeds::admit(vel.to_bits(), acc.to_bits(), end.to_bits()).unwrap()
}

fn output(value: u32) -> PathEntry {
    PathEntry::output(DoGroup::General, 0xff, u64::from(value))
}

/// Coordinate system 0 on axes 0 and 1, coordinate system 1 on axes 2 and 3, all at 0.
fn prepared(period_us: u32) -> Bench {
    let mut bench = Bench::prepared(period_us, MotionMode::Trap);
    bench.frame(0, &[0, 1], None);
    bench.frame(1, &[2, 3], None);
    bench.tick();
    bench.machine.edges.clear();
    bench
}

/// Runs until nothing runs; every tick's edges with their instants in ns after `zero`.
fn edges(bench: &mut Bench, zero: u64) -> Vec<(u64, u64)> {
    let mut found = Vec::new();
    let mut last = bench.machine.outputs.2;
    loop {
        let view = bench.tick();
        // A change at 0 acts on the tick itself.
        let at_tick = view.general_outputs;
        let reported: Vec<_> = bench.machine.edges.drain(..).collect();
        if reported.is_empty() && at_tick != last {
            found.push((view.now.0 - zero, at_tick));
        }
        for (at, _, _, general) in reported {
            assert!(u64::from(at) < view.period.0);
            found.push((view.now.0 + u64::from(at) - zero, general));
        }
        last = at_tick;
        if view.crds.iter().all(|crd| !crd.runs) {
            return found;
        }
    }
}

/// Outputs change at the instant of their boundary, the same ns at any tick period.
#[test]
fn outputs_change_at_the_instant_of_their_boundary() {
    let mut expected = None;
    for period in [10, 50, 73, 250, 333, 1000] {
        let mut bench = prepared(period);
        let v = speeds(10.0, 1.0, 10.0);
        let entries = [
            output(1),
            PathEntry::planar([100, 0], v),
            output(2),
            PathEntry::analog(3, -77),
            PathEntry::planar([100, 50], v),
            output(3),
            PathEntry::delay(7),
            output(4),
            PathEntry::circle(Plane::Xy, [50 << 30, 0], true, v).unwrap(),
            output(5),
        ];
        bench.path(0, 0, &entries);
        bench.start_path(&[0]);
        bench.machine.analog_edges.clear();
        let zero = bench.tick.now().0 + u64::from(period) * 1000;
        let found = edges(&mut bench, zero);
        let values: Vec<u64> = found.iter().map(|(_, value)| value & 0xff).collect();
        assert_eq!(values, [1, 2, 3, 4, 5], "{period}");
        // 50 pulses to 10 pulse/ms in 10 ms, 5 ms more; 50 pulses of braking; a delay; a circle of
        // 50·2π from rest to rest.
        let (first, second) = (15.0, 25.0);
        let third = second + 7.0;
        let last = third + 20.0 + (100.0 * std::f64::consts::PI - 100.0) / 10.0;
        for ((at, _), ms) in found.iter().zip([0.0, first, second, third, last]) {
            assert!((*at as f64 - ms * 1e6).abs() <= 1.0, "{period}: {at} {ms}");
        }
        assert_eq!(*expected.get_or_insert(found.clone()), found, "{period}");
        let [(at, 3, -77)] = bench.machine.analog_edges[..] else { panic!() };
        let instant = zero + found[1].0;
        assert_eq!((instant - zero) % (u64::from(period) * 1000), u64::from(at));
    }
}

/// Two paths in one interval: their edges come in the order of time, and each leaves the other's
/// outputs alone.
#[test]
fn outputs_of_two_paths_come_in_order() {
    let mut bench = prepared(1000);
    let line_to = |x: i32| PathEntry::planar([x, 0], speeds(100.0, 100.0, 100.0));
    let on = |bit: u32| PathEntry::output(DoGroup::General, 1 << bit, 1 << bit);
    // Boundaries of the first at 1.5 and 1.9 ms; of the second at 1.7 ms.
    bench.path(0, 0, &[line_to(100), on(10), line_to(140), on(11), line_to(400)]);
    bench.path(1, 0, &[line_to(120), on(12), line_to(400)]);
    bench.start_path(&[0, 1]);
    let zero = bench.tick.now().0 + MS;
    let found = edges(&mut bench, zero);
    assert_eq!(found, [(1_500_000, 0x400), (1_700_000, 0x1400), (1_900_000, 0x1c00)]);
}

/// A servo that an entry switches off stops what it must, and the light of the enable is exact.
#[test]
fn an_entry_may_switch_a_servo_off() {
    for other in [5, 1] {
        let mut bench = prepared(1000);
        let line_to = |x: i32| PathEntry::planar([x, 0], speeds(100.0, 100.0, 100.0));
        bench.path(0, 0, &[line_to(100), PathEntry::output(DoGroup::Enable, 1 << other, 0), line_to(400)]);
        bench.now(TickCommand::SetMode { axis: axis(5), mode: MotionMode::Jog });
        bench.jog(5, 3.0, 1.0);
        bench.start_path(&[0]);
        let zero = bench.tick().now.0;
        let view = bench.until(zero + 3 * MS);
        assert_eq!(bench.machine.edges, [(500_000, 0xff & !(1 << other), 0, 0)]);
        assert_eq!(view.enable, 0xff & !(1 << other));
        assert!(view.axes[other as usize].status & (status::SERVO_ON | status::RUNNING) == 0);
        assert_eq!(view.axes[other as usize].stop, StopReason::ServoOff);
        assert_eq!(view.crds[0].runs, other == 5);
        if other == 1 {
            assert_eq!(view.crds[0].stop, StopReason::ServoOff);
        }
    }
}

/// A modal move holds the path until the axis is there, to the instant; another one does not.
#[test]
fn a_move_takes_an_axis_away_and_a_modal_one_is_waited_for() {
    let mut ends = Vec::new();
    for period in [10, 250, 333, 1000] {
        for modal in [true, false] {
            let mut bench = prepared(period);
            let v = speeds(10.0, 1.0, 0.0);
            let travel =
                PathEntry::travel(axis(4), -30, (2f64.to_bits(), StepLimit::FULL_SCALE), 0.5f64.to_bits(), modal)
                    .unwrap();
            bench.path(
                0,
                0,
                &[PathEntry::planar([37, 0], v), travel, output(1), PathEntry::planar([0, 0], v), output(2)],
            );
            bench.start_path(&[0]);
            let zero = bench.tick.now().0 + u64::from(period) * 1000;
            let found = edges(&mut bench, zero);
            let end = bench.run_to_standstill();
            assert_eq!((pulses(end.axes[4].pos), end.axes[4].mode), (-30.0, MotionMode::Trap));
            // 2·√37 ms for the line; 30 pulses at 2 pulse/ms: 4 ms, 11 ms, 4 ms.
            let line = 2.0 * 37f64.sqrt();
            let wait = if modal { 19.0 } else { 0.0 };
            for ((at, _), ms) in found.iter().zip([line + wait, 2.0 * line + wait]) {
                assert!((*at as f64 - ms * 1e6).abs() <= 1.0, "{period}: {at} {ms}");
            }
            assert_eq!(found.len(), 2);
            if modal {
                ends.push(found);
            }
        }
    }
    assert!(ends.iter().all(|found| *found == ends[0]));
}

/// The moved axis's position is a function of the boundary's instant, not of the tick's.
#[test]
fn a_move_begins_at_its_boundary() {
    let mut seen = Vec::new();
    for period in [50, 250, 1000] {
        let mut bench = prepared(period);
        let travel =
            PathEntry::travel(axis(4), 1000, (20f64.to_bits(), StepLimit::FULL_SCALE), 2f64.to_bits(), false).unwrap();
        bench.path(0, 0, &[PathEntry::planar([37, 0], speeds(10.0, 1.0, 0.0)), travel]);
        bench.start_path(&[0]);
        let zero = bench.tick().now.0;
        seen.push([13, 17, 30].map(|ms| bench.until(zero + ms * MS).axes[4].pos));
    }
    let t = 17.0 - 2.0 * 37f64.sqrt();
    assert!((pulses(seen[0][1]) - t * t).abs() < 1e-5, "{}", pulses(seen[0][1]));
    assert!(seen.iter().all(|of| *of == seen[0]), "{seen:?}");
}

/// A move that an axis cannot make stops the path; so does one that the path waits for and that
/// does not reach its end.
#[test]
fn a_move_that_fails_stops_the_path() {
    let v = speeds(10.0, 1.0, 0.0);
    let entries = |modal| {
        let travel =
            PathEntry::travel(axis(4), -30, (2f64.to_bits(), StepLimit::FULL_SCALE), 0.5f64.to_bits(), modal).unwrap();
        [PathEntry::planar([37, 0], v), travel, PathEntry::planar([0, 0], v)]
    };
    type Break = fn(&mut Bench);
    let breaks: [Break; 3] = [
        |bench| {
            bench.now(TickCommand::Servo { axis: axis(4), on: false });
        },
        |bench| {
            bench.now(TickCommand::SetMode { axis: axis(4), mode: MotionMode::Jog });
        },
        |bench| bench.frame(2, &[4], None),
    ];
    for act in breaks {
        let mut bench = prepared(250);
        act(&mut bench);
        bench.path(0, 0, &entries(false));
        bench.start_path(&[0]);
        let zero = bench.tick().now.0;
        let view = bench.until(zero + 14 * MS);
        assert!(!view.crds[0].runs && view.crds[0].stop == StopReason::OtherAxis);
        let x = pulses(view.axes[0].pos);
        assert!((36.0..=37.0).contains(&x) && pulses(view.axes[4].pos) == 0.0, "{x}");
    }
    let mut bench = prepared(250);
    bench.path(0, 0, &entries(true));
    bench.start_path(&[0]);
    let zero = bench.tick().now.0;
    bench.until(zero + 20 * MS);
    bench.now(TickCommand::stop(all(&[4]), AxisMask(0)));
    let view = bench.until(zero + 60 * MS);
    assert!(!view.crds[0].runs && view.crds[0].stop == StopReason::OtherAxis);
    assert_eq!(pulses(view.axes[0].pos), 37.0);
}

/// A move that the path waits for is made to its end, whatever came between: a Stop of the path, of
/// its axis, of both, a servo that is off. The path goes on from there, not before.
#[test]
fn a_modal_move_that_was_stopped_is_made_to_its_end() {
    let v = speeds(10.0, 1.0, 0.0);
    // 2·√37 ms for the line; 30 pulses at 2 pulse/ms: 4 ms, 11 ms, 4 ms.
    let travel =
        PathEntry::travel(axis(4), -30, (2f64.to_bits(), StepLimit::FULL_SCALE), 0.5f64.to_bits(), true).unwrap();
    let path = |abrupt| TickCommand::stop_crds(CrdMask(1), CrdMask(abrupt));
    let other = TickCommand::stop(all(&[4]), AxisMask(0));
    let off = TickCommand::Servo { axis: axis(4), on: false };
    let breaks: [(&[TickCommand], f64); 5] =
        [(&[path(0)], -30.0), (&[path(1)], -30.0), (&[other, path(0)], -16.0), (&[other], -16.0), (&[off], -14.0)];
    for (index, (stops, left_at)) in breaks.into_iter().enumerate() {
        let mut bench = prepared(250);
        bench.path(0, 0, &[PathEntry::planar([37, 0], v), travel, output(1), PathEntry::planar([0, 0], v)]);
        bench.start_path(&[0]);
        let zero = bench.tick().now.0;
        let view = bench.until(zero + 21 * MS);
        assert_eq!(view.crds[0].released[0], 1, "the move's place is not free");
        for command in stops {
            bench.now(*command);
        }
        let view = bench.until(zero + 60 * MS);
        let at = pulses(view.axes[4].pos);
        assert!(!view.crds[0].runs && (at - left_at).abs() < 1.0, "{index}: {at}");
        bench.now(TickCommand::Servo { axis: axis(4), on: true });
        bench.start_path(&[0]);
        let view = bench.until(zero + 61 * MS);
        assert!(view.crds[0].runs, "{index}");
        while bench.machine.outputs.2 & 1 == 0 {
            let view = bench.tick();
            assert!(view.crds[0].runs, "{index}");
            let x = pulses(view.axes[0].pos);
            assert!(x > 36.9, "{index}: {x}");
        }
        let view = bench.tick();
        assert_eq!(pulses(view.axes[4].pos), -30.0, "{index}");
        let end = bench.run_to_standstill();
        assert_eq!(pulses(end.axes[0].pos), 0.0);
        assert_eq!((end.crds[0].released[0], end.crds[0].done[0]), (4, 2));
    }
}

/// A move that could not even begin, with others to wait for it or not.
#[test]
fn a_move_that_was_refused_is_made_once_it_can_be() {
    for modal in [true, false] {
        let v = speeds(10.0, 1.0, 5.0);
        let travel = PathEntry::travel(axis(4), -30, (2f64.to_bits(), StepLimit::FULL_SCALE), 0.5f64.to_bits(), modal);
        let mut bench = prepared(250);
        bench.now(TickCommand::Servo { axis: axis(4), on: false });
        bench.path(0, 0, &[PathEntry::planar([37, 0], v), travel.unwrap(), output(1), PathEntry::planar([0, 0], v)]);
        bench.start_path(&[0]);
        let zero = bench.tick().now.0;
        let view = bench.until(zero + 60 * MS);
        assert!(!view.crds[0].runs && view.crds[0].stop == StopReason::OtherAxis);
        assert_eq!((pulses(view.axes[0].pos), view.general_outputs & 1), (37.0, 0));
        bench.now(TickCommand::Servo { axis: axis(4), on: true });
        bench.start_path(&[0]);
        let view = bench.until(zero + 70 * MS);
        // A path that does not wait is on its return by now.
        assert_eq!(view.general_outputs & 1 == 0, modal);
        assert_eq!(pulses(view.axes[0].pos) == 37.0, modal);
        bench.run_to_standstill();
        let end = bench.until(zero + 200 * MS);
        assert_eq!((pulses(end.axes[4].pos), pulses(end.axes[0].pos), end.general_outputs & 1), (-30.0, 0.0, 1));
    }
}

/// An axis is geared to one motion, in step with its path length, also over a Stop; then it is
/// free.
#[test]
fn a_gear_goes_along_with_the_next_motion() {
    for period in [50, 1000] {
        let mut bench = prepared(period);
        bench.now(TickCommand::SetPosition { axis: axis(4), pos: Pos::pulses(7) });
        let v = speeds(10.0, 1.0, 0.0);
        let entries = [
            PathEntry::gear(axis(4), 100),
            PathEntry::gear(axis(5), -3),
            PathEntry::planar([300, 400], v),
            PathEntry::gear(axis(4), 11),
            PathEntry::planar([300, 410], v),
            PathEntry::planar([0, 410], v),
        ];
        bench.path(0, 0, &entries);
        bench.start_path(&[0]);
        let zero = bench.tick().now.0;
        let view = bench.until(zero + 30 * MS);
        // Half of the length.
        let speed = |view: &View<AXES>, axis: usize| real(view.velocity(&view.axes[axis]));
        assert!((pulses(view.axes[4].pos) - 57.0).abs() < 1e-5 && (pulses(view.axes[5].pos) + 1.5).abs() < 1e-5);
        assert!((speed(&view, 4) - 2.0).abs() < 1e-9 && (speed(&view, 5) + 0.06).abs() < 1e-9);
        assert!(has(&view.axes[4], status::RUNNING) && view.axes[4].mode == MotionMode::Trap);
        // Stop by the bit of a geared axis.
        bench.now(TickCommand::stop(all(&[5]), AxisMask(0)));
        let view = bench.run_to_standstill();
        assert_eq!((view.crds[0].stop, view.axes[4].stop), (StopReason::StopSmooth, StopReason::StopSmooth));
        let share = pulses(view.axes[0].pos) / 300.0;
        assert!((pulses(view.axes[4].pos) - 7.0 - 100.0 * share).abs() < 1e-5);
        bench.start_path(&[0]);
        let mut between = Vec::new();
        let end = loop {
            let view = bench.tick();
            if view.crds[0].done[0] == 2 {
                between.push((view.axes[4].pos, view.axes[5].pos, view.axes[4].status & status::RUNNING));
            }
            if !view.crds[0].runs {
                break view;
            }
        };
        assert_eq!((pulses(end.axes[4].pos), pulses(end.axes[5].pos)), (118.0, -3.0));
        // In the third motion it is at rest.
        assert!(between[2..].iter().all(|at| *at == (Pos::pulses(118), Pos::pulses(-3), 0)), "{between:?}");
    }
}

/// A smooth Stop that rests in the tick in which the geared motion has begun: the axis goes along
/// up to there.
#[test]
fn a_gear_that_begins_in_the_tick_of_a_stop_goes_along() {
    let mut within = 0;
    for at in 0..60 {
        let mut bench = prepared(1000);
        let dec = servo::segment::ramp::Accel::admit(4f64.to_bits()).unwrap();
        bench.now(TickCommand::CrdStopDec { crd: crd(0), dec });
        let v = speeds(3.0, 1.0, 3.0);
        let lines =
            [PathEntry::planar([3 + at, 0], v), PathEntry::gear(axis(4), 65), PathEntry::planar([50 + at, 0], v)];
        bench.path(0, 0, &lines);
        bench.start_path(&[0]);
        bench.tick();
        let mut view = bench.tick();
        // It brakes from the next tick on, some pulses further.
        while view.crds[0].runs && pulses(view.axes[0].pos) + 3.9 < f64::from(3 + at) {
            view = bench.tick();
        }
        let before = pulses(view.axes[0].pos) < f64::from(3 + at);
        bench.now(TickCommand::stop(all(&[0]), AxisMask(0)));
        let view = bench.run_to_standstill();
        let gone = 65.0 * (pulses(view.axes[0].pos) - f64::from(3 + at)).max(0.0) / 47.0;
        within += u32::from(before && gone > 0.0);
        assert!((pulses(view.axes[4].pos) - gone).abs() < 1e-5, "{at}: {} {gone}", pulses(view.axes[4].pos));
        bench.start_path(&[0]);
        bench.tick();
        assert_eq!(pulses(bench.run_to_standstill().axes[4].pos), 65.0, "{at}");
    }
    assert!(within > 5, "{within}");
}

/// Gears of one axis add up; one more than a path can gear stops it.
#[test]
fn gears_add_up_and_too_many_stop_the_path() {
    let mut bench = prepared(250);
    let line_to = PathEntry::planar([300, 400], speeds(10.0, 1.0, 0.0));
    bench.path(0, 0, &[PathEntry::gear(axis(4), 100), PathEntry::gear(axis(4), -30), line_to]);
    bench.start_path(&[0]);
    bench.tick();
    assert_eq!(pulses(bench.run_to_standstill().axes[4].pos), 70.0);
    let mut entries: Vec<_> = (3..8).map(|index| PathEntry::gear(axis(index), 10)).collect();
    entries.push(PathEntry::planar([0, 0], speeds(10.0, 1.0, 0.0)));
    bench.frame(1, &[2], None);
    bench.path(0, 0, &entries);
    bench.start_path(&[0]);
    bench.tick();
    let view = bench.run_to_standstill();
    assert_eq!((view.crds[0].stop, view.crds[0].done[0]), (StopReason::OtherAxis, 1));
}

#[test]
fn a_gear_of_an_axis_that_moves_stops_the_path() {
    let mut bench = prepared(250);
    bench.now(TickCommand::SetMode { axis: axis(4), mode: MotionMode::Jog });
    bench.jog(4, 1.0, 1.0);
    bench.path(0, 0, &[PathEntry::gear(axis(4), 100), PathEntry::planar([300, 400], speeds(10.0, 1.0, 0.0))]);
    bench.start_path(&[0]);
    let view = bench.ticks(10);
    assert_eq!((view.crds[0].runs, view.crds[0].stop), (false, StopReason::OtherAxis));
    assert!(has(&view.axes[4], status::RUNNING));
}

/// A slave of a coordinate is where its master is, in the same tick.
#[test]
fn an_axis_may_follow_a_coordinate() {
    for (leader, slave) in [(0, 6), (1, 7)] {
        for period in [50, 250, 1000] {
            let mut bench = prepared(period);
            bench.now(TickCommand::SetMode { axis: axis(slave), mode: MotionMode::Follow });
            bench.follows(slave, leader, MasterPosition::Planned);
            bench.tick();
            bench.follow(slave, 0, &[Item::Data(100_000.0, -50_000.0, 1, 0)]);
            bench.start_follow(&[slave]);
            bench.tick();
            bench.path(
                0,
                0,
                &[
                    PathEntry::planar([300, 400], speeds(10.0, 1.0, 5.0)),
                    PathEntry::planar([900, 901], speeds(10.0, 1.0, 0.0)),
                ],
            );
            bench.start_path(&[0]);
            loop {
                let view = bench.tick();
                let (master, its) = (pulses(view.axes[leader].pos), pulses(view.axes[slave].pos));
                assert!((its + master / 2.0).abs() < 1e-6, "{master} {its}");
                let speed = |index: usize| real(view.velocity(&view.axes[index]));
                assert!((speed(slave) + speed(leader) / 2.0).abs() < 1e-7);
                if !view.crds[0].runs {
                    break;
                }
            }
        }
    }
}

/// Where a coordinate reverses between two ticks, at a corner or on an arc, its slave follows it to
/// the turning point.
#[test]
fn a_slave_sees_where_a_coordinate_turns_between_ticks() {
    let v = speeds(10.0, 1.0, 10.0);
    let corner = [PathEntry::planar([103, 0], v), PathEntry::planar([0, 50], v)];
    let arc = [PathEntry::circle(Plane::Xy, [40 << 30, 30 << 30], false, speeds(7.3, 1.0, 0.0)).unwrap()];
    let both = [
        PathEntry::planar([21, 0], v),
        PathEntry::circle(Plane::Xy, [40 << 30, 30 << 30], true, v).unwrap(),
        PathEntry::planar([-11, 3], v),
    ];
    for (entries, most, least) in [(&corner[..], 103.0, 0.0), (&arc, 90.0, -10.0), (&both, 111.0, -11.0)] {
        for period in [50, 250, 1000] {
            let mut bench = prepared(period);
            // User positions do not affect a slave.
            bench.now(TickCommand::SetPosition { axis: axis(0), pos: Pos::pulses(1234) });
            bench.frame(0, &[0, 1], None);
            for (slave, direction) in [(6, Direction::Up), (7, Direction::Down)] {
                bench.now(TickCommand::SetMode { axis: axis(slave), mode: MotionMode::Follow });
                bench.now(TickCommand::FollowDirection { axis: axis(slave), direction });
                bench.follows(slave, 0, MasterPosition::Planned);
                bench.tick();
                bench.follow_in(slave, 0, direction, &[Item::Data(100_000.0, 100_000.0, 1, 0)]);
            }
            bench.start_follow(&[6, 7]);
            bench.tick();
            bench.path(0, 0, entries);
            bench.start_path(&[0]);
            while bench.tick().crds[0].runs {}
            let view = bench.tick();
            let [up, down] = [6, 7].map(|slave: usize| pulses(view.axes[slave].pos));
            assert!((up - most).abs() < 1e-5 && (down + least).abs() < 1e-5, "{period}: {up} {down} of {most} {least}");
        }
    }
}

/// Two paths that cross in everything but their axes.
#[test]
fn two_paths_run_side_by_side() {
    let mut bench = prepared(250);
    let v = speeds(10.0, 1.0, 0.0);
    bench.path(0, 0, &[PathEntry::planar([300, 400], v), PathEntry::planar([0, 0], v)]);
    bench.path(1, 0, &[PathEntry::planar([-60, 80], v)]);
    bench.start_path(&[0, 1]);
    let zero = bench.tick().now.0;
    let view = bench.until(zero + 20 * MS);
    assert!(!view.crds[1].runs && view.crds[0].runs, "100 pulses take 20 ms");
    assert_eq!((pulses(view.axes[2].pos), pulses(view.axes[3].pos)), (-60.0, 80.0));
    bench.now(TickCommand::stop_crds(CrdMask(2), CrdMask(2)));
    let view = bench.run_to_standstill();
    assert_eq!((pulses(view.axes[0].pos), view.crds[0].done[0]), (0.0, 2));
    let reasons: Vec<_> = std::iter::from_fn(|| bench.event())
        .map(|event| match event {
            Event::CrdStopped { crd, reason, .. } => (crd.index(), reason),
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(reasons, [(1, StopReason::Completed), (0, StopReason::Completed)]);
}
