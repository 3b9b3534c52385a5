//! Faults and limits of axes that a path drives.
use super::*;

/// Bits that stay set until ClearStatus.
const LATCHED: u32 = status::FAULTS | status::LIMITS | status::STOP_SMOOTH | status::STOP_ABRUPT;

/// What a mapped axis must not do stops the path; its axes stop together, on the path, and the
/// reason is latched.
#[test]
fn faults_and_limits_of_one_axis_stop_all() {
    type Break = fn(&mut Bench);
    let breaks: [(StopReason, u32, Break); 5] = [
        (StopReason::Alarm, status::ALARM, |bench| bench.machine.inputs[5].alarm = true),
        (StopReason::LimitPositive, status::LIMIT_POSITIVE, |bench| bench.machine.inputs[5].limit_positive = true),
        (StopReason::FollowingError, status::FOLLOWING_ERROR, |bench| bench.machine.slip[5] = 100),
        (StopReason::ServoOff, 0, |bench| {
            bench.now(TickCommand::Servo { axis: axis(5), on: false });
        }),
        (StopReason::SoftPositive, status::LIMIT_POSITIVE, |bench| {
            bench.now(TickCommand::SoftLimit { axis: axis(5), positive: Some(100), negative: None });
        }),
    ];
    for (reason, bits, act) in breaks {
        let mut bench = prepared(250, &[line(200, 450)]);
        bench.now(TickCommand::PositionError { axis: axis(5), limit: Some(50) });
        bench.start_path(&[0]);
        let zero = bench.tick().now.0;
        bench.until(zero + 15 * MS);
        act(&mut bench);
        let view = finish(&mut bench, 0);
        let published = view.crds[0];
        assert_eq!((published.stop, view.axes[2].stop, view.axes[5].stop), (reason, reason, reason));
        assert_eq!(stopped_crd(bench.event()), (0, reason));
        assert!(bench.event().is_none());
        let [x, y] = place(&view, [2, 5]);
        assert!((y - x * 4.0 / 3.0).abs() < 1e-5, "{reason:?}: {x} {y} is off the path");
        if reason == StopReason::SoftPositive {
            assert!((99.99..=100.0).contains(&y), "{y}");
        } else {
            // 100 pulses along at 15 ms, 2.5 in a tick, one of which it may still go.
            assert!((79.9..=84.1).contains(&y), "{reason:?} {y}");
        }
        assert!(has(&view.axes[5], bits) && view.axes[2].status & LATCHED == 0);
        // It is blocked while the reason lasts.
        bench.start_path(&[0]);
        bench.tick();
        assert!(matches!(bench.event(), Some(Event::Refused { .. })), "{reason:?}");
        assert!(!bench.tick().crds[0].runs);
        // Once it is gone it goes on to the end.
        bench.machine.inputs[5] = Default::default();
        bench.machine.slip[5] = 0;
        bench.now(TickCommand::SoftLimit { axis: axis(5), positive: None, negative: None });
        bench.now(TickCommand::Servo { axis: axis(5), on: true });
        bench.ticks(2);
        bench.now(TickCommand::ClearStatus { axes: AxisMask(0xff) });
        bench.tick();
        bench.start_path(&[0]);
        assert_eq!(place(&finish(&mut bench, 0), [2, 5]), [300.0, 400.0], "{reason:?}");
    }
}

/// A switch that is active lets an axis move away, and stops the path only when it comes to move
/// against it.
#[test]
fn a_path_may_leave_an_active_limit_switch() {
    let mut bench = prepared(250, &[PathEntry::planar([-200, -150], speeds(10.0, 1.0, 0.0)), line(-200, 0)]);
    bench.machine.inputs[5].limit_positive = true;
    bench.tick();
    bench.now(TickCommand::ClearStatus { axes: AxisMask(0xff) });
    bench.tick();
    bench.start_path(&[0]);
    let view = finish(&mut bench, 0);
    assert_eq!(view.crds[0].stop, StopReason::LimitPositive);
    let [x, y] = place(&view, [2, 5]);
    assert!(x == -100.0 && (-200.0..-199.9).contains(&y), "{x} {y}");
    assert_eq!(view.crds[0].done[0], 1);
}

/// No planned position goes beyond a soft limit, wherever the path crosses it and however long a
/// tick is.
#[test]
fn soft_limits_hold_lines_and_arcs() {
    let along = speeds(97.0, 3.0, 97.0);
    let sweep = Sweep::admit(0.5f64.to_bits(), false, true).unwrap();
    for period in [10, 250, 1000] {
        for limit in [150, 260, 399, 401] {
            let entries = [
                PathEntry::planar([200, 0], along),
                PathEntry::arc(Plane::Xy, [200, 200], sweep, along),
                PathEntry::planar([600, 210], along),
            ];
            let mut bench = Bench::prepared(period, MotionMode::Trap);
            bench.frame(0, &[0, 1], None);
            bench.now(TickCommand::SoftLimit { axis: axis(0), positive: Some(limit), negative: None });
            bench.tick();
            bench.path(0, 0, &entries);
            bench.start_path(&[0]);
            let view = loop {
                let view = bench.tick();
                assert!(pulses(view.axes[0].pos) <= f64::from(limit));
                if !view.crds[0].runs {
                    break view;
                }
            };
            assert_eq!((view.crds[0].stop, view.crds[0].path_stop), (StopReason::SoftPositive, PathStop::Obstructed));
            assert!(pulses(view.axes[0].pos) > f64::from(limit) - 0.01, "{}", pulses(view.axes[0].pos));
            assert!(has(&view.axes[0], status::LIMIT_POSITIVE));
        }
    }
}

/// The same where a motion ends beyond the limit between two ticks, at rest, before a wait, or at
/// speed.
#[test]
fn soft_limits_hold_ends_of_motions() {
    let to = |x: i32, end: f64| PathEntry::planar([x, 0], speeds(97.0, 3.0, end));
    let after = [vec![to(200, 0.0)], vec![to(200, 0.0), PathEntry::delay(30)], vec![to(200, 97.0), to(0, 0.0)]];
    for entries in after {
        for period in [10, 250, 333, 1000] {
            let mut bench = Bench::prepared(period, MotionMode::Trap);
            bench.frame(0, &[0, 1], None);
            bench.now(TickCommand::SoftLimit { axis: axis(0), positive: Some(199), negative: None });
            bench.tick();
            bench.path(0, 0, &entries);
            bench.start_path(&[0]);
            let view = loop {
                let view = bench.tick();
                assert!(pulses(view.axes[0].pos) <= 199.0, "{}", pulses(view.axes[0].pos));
                if !view.crds[0].runs {
                    break view;
                }
            };
            assert_eq!((view.crds[0].stop, view.crds[0].done[0]), (StopReason::SoftPositive, 0));
            assert!(pulses(view.axes[0].pos) > 198.99, "{period} {}", pulses(view.axes[0].pos));
            // Once the limit is off it goes on to the end.
            bench.now(TickCommand::SoftLimit { axis: axis(0), positive: None, negative: None });
            bench.now(TickCommand::ClearStatus { axes: AxisMask(0xff) });
            bench.tick();
            bench.start_path(&[0]);
            let motions = entries.iter().filter(|entry| entry.is_motion()).count();
            assert_eq!(finish(&mut bench, 0).crds[0].done[0] as usize, motions);
        }
    }
}

/// A limit switch during a long motion: the axis stays where it is, to a thousandth of its
/// displacement in a tick.
#[test]
fn a_stop_by_a_switch_goes_neither_on_nor_back() {
    let mut bench = prepared(1000, &[PathEntry::planar([1 << 30, 1 << 30], speeds(1000.0, 100.0, 0.0))]);
    bench.start_path(&[0]);
    let before = bench.ticks(5000);
    bench.machine.inputs[2].limit_positive = true;
    let after = bench.tick();
    assert_eq!((after.crds[0].runs, after.crds[0].stop), (false, StopReason::LimitPositive));
    for axis in [2, 5] {
        let by = pulses(after.axes[axis].pos) - pulses(before.axes[axis].pos);
        assert!((0.0..=1.0).contains(&by), "{by}");
    }
}

/// A guarded input that is switched off stops nothing.
#[test]
fn guards_may_be_off() {
    let mut bench = prepared(250, &[line(200, 450)]);
    bench.now(TickCommand::Guard { axis: axis(5), on: Guards::set(Guarded::LimitPositive, false), low: Guards::NONE });
    bench.start_path(&[0]);
    bench.ticks(20);
    bench.machine.inputs[5].limit_positive = true;
    assert_eq!(place(&finish(&mut bench, 0), [2, 5]), [300.0, 400.0]);
}
