//! What stops an axis, what the status word says, and what clears it.
use crate::tick_bench;
use servo::status::*;
use servo::tick_command::{Guarded, Guards, MotionMode, TickCommand};
use servo::units::{Ns, Pos};
use servo::view::{Event, StopReason};
use tick_bench::*;

#[test]
fn stops_are_smooth_or_abrupt() {
    let mut bench = Bench::prepared(250, MotionMode::Jog);
    for index in [0, 1] {
        bench.jog(index, 8.0, 4.0);
    }
    bench.now(TickCommand::StopDec { axis: axis(0), smooth: accel(2.0), abrupt: accel(1000.0) });
    let before = bench.ticks(100);
    assert_eq!(real(before.axes[0].motion.velocity()), 8.0);
    bench.now(TickCommand::stop(all(&[0, 1, 2]), all(&[1])));
    let view = bench.tick();
    // Abrupt: the planned velocity is 0 on that tick.
    assert_eq!(view.axes[1].pos, before.axes[1].pos);
    assert!(!has(&view.axes[1], RUNNING));
    assert_eq!(stopped(bench.event()), (1, StopReason::StopAbrupt));
    // Smooth: it begins on that tick, v²/2a = 16 pulses and v/a = 4 ms later it has stopped.
    assert!(has(&view.axes[0], RUNNING));
    let end = bench.run_to_standstill();
    assert_eq!(end.now.0, view.now.0 + 4 * MS);
    assert!((pulses(end.axes[0].pos) - pulses(view.axes[0].pos) - 16.0).abs() < 1e-5);
    assert_eq!(end.axes[0].stop, StopReason::StopSmooth);
    assert_eq!(stopped(bench.event()), (0, StopReason::StopSmooth));
    assert_eq!(end.axes[2].stop, StopReason::None, "Stop of an axis at rest does nothing");
    assert!(bench.event().is_none());
}

/// Wherever it begins: that tick belongs to the motion before, the ticks after it are of v·t −
/// a·t²/2 from there.
#[test]
fn a_smooth_stop_begins_where_the_motion_is() {
    for ticks in 1..24 {
        // Speeding up takes 15.8 ticks.
        let [mut bench, mut twin] = [(); 2].map(|()| {
            let mut bench = Bench::prepared(250, MotionMode::Jog);
            bench.jog(0, 8.3, 2.1);
            bench.ticks(ticks);
            bench
        });
        bench.now(TickCommand::StopDec { axis: axis(0), smooth: accel(1.7), abrupt: accel(1000.0) });
        bench.now(TickCommand::stop(all(&[0]), all(&[])));
        let (begin, motion) = (bench.tick(), twin.tick().axes[0]);
        let (p, v) = (pulses(motion.pos), real(motion.motion.velocity()));
        assert_eq!(begin.axes[0].pos, motion.pos);
        assert!((real(begin.axes[0].motion.velocity()) - v).abs() < 1e-12);
        assert!(has(&begin.axes[0], RUNNING));
        loop {
            let view = bench.tick();
            let t = (view.now.0 - begin.now.0) as f64 / MS as f64;
            if t >= v / 1.7 {
                assert!(!has(&view.axes[0], RUNNING), "{ticks}: it runs at {t} ms");
                assert!((pulses(view.axes[0].pos) - p - v * v / 3.4).abs() < 1e-6);
                break;
            }
            assert!((pulses(view.axes[0].pos) - p - v * t + 0.85 * t * t).abs() < 1e-6, "{ticks}: {t} ms");
            assert!((real(view.axes[0].motion.velocity()) - v + 1.7 * t).abs() < 1e-9, "{ticks}: {t} ms");
        }
    }
}

#[test]
fn the_power_on_stop_deceleration_is_1() {
    let mut bench = Bench::prepared(250, MotionMode::Jog);
    bench.jog(0, 5.0, 5.0);
    bench.ticks(100);
    bench.now(TickCommand::stop(all(&[0]), all(&[])));
    let begin = bench.tick().now.0;
    assert_eq!(bench.run_to_standstill().now.0, begin + 5 * MS);
}

#[test]
fn a_soft_limit_holds_exactly_and_lets_go_after_clear_status() {
    let mut bench = Bench::prepared(250, MotionMode::Jog);
    bench.now(TickCommand::SoftLimit { axis: axis(0), positive: Some(100), negative: Some(-50) });
    for (velocity, limit, bit, reason) in
        [(3.7, 100, LIMIT_POSITIVE, StopReason::SoftPositive), (-3.7, -50, LIMIT_NEGATIVE, StopReason::SoftNegative)]
    {
        bench.jog(0, velocity, 10.0);
        let view = bench.run_to_standstill();
        assert_eq!(view.axes[0].pos, Pos::pulses(limit));
        assert_eq!(view.axes[0].status & LIMITS, bit);
        assert_eq!((view.axes[0].stop, view.axes[0].blocked), (reason, bit));
        assert_eq!(stopped(bench.event()), (0, reason));
        // Latched: no start, not even away.
        bench.jog(0, -velocity, 10.0);
        assert!(!has(&bench.tick().axes[0], RUNNING));
        assert!(matches!(bench.event(), Some(Event::Refused { .. })));
        bench.now(TickCommand::ClearStatus { axes: all(&[0]) });
        assert_eq!(bench.tick().axes[0].status & LIMITS, 0);
        // Cleared: not further, but away.
        bench.jog(0, velocity, 10.0);
        assert!(!has(&bench.tick().axes[0], RUNNING));
        assert!(matches!(bench.event(), Some(Event::Refused { .. })));
        bench.jog(0, -velocity, 10.0);
        assert!(has(&bench.ticks(4).axes[0], RUNNING));
        bench.now(TickCommand::stop(all(&[0]), all(&[0])));
        bench.tick();
        assert_eq!(stopped(bench.event()), (0, StopReason::StopAbrupt));
    }
}

/// A limit set behind a running axis stops it where it is: no step back to the limit, in any mode.
#[test]
fn a_soft_limit_that_an_axis_has_passed_stops_it_where_it_is() {
    for towards in [1, -1] {
        let soft = |at: i32| {
            let (positive, negative) = if towards > 0 { (Some(at), None) } else { (None, Some(-at)) };
            TickCommand::SoftLimit { axis: axis(0), positive, negative }
        };
        let reason = if towards > 0 { StopReason::SoftPositive } else { StopReason::SoftNegative };
        let check = |bench: &mut Bench, index: usize| {
            let before = bench.ticks(100);
            assert!(pulses(before.axes[index].pos) * f64::from(towards) > 40.0);
            bench.now(soft(20));
            let view = bench.tick();
            assert_eq!(view.axes[index].pos, before.axes[index].pos);
            assert_eq!(view.axes[index].stop, reason);
            assert!(!has(&view.axes[index], RUNNING));
            assert_eq!(bench.ticks(10).axes[index].pos, before.axes[index].pos);
        };
        let mut bench = Bench::prepared(250, MotionMode::Jog);
        bench.jog(0, 4.0 * f64::from(towards), 4.0);
        check(&mut bench, 0);
        // While it brakes, from the tick on in which it begins to.
        for ticks in [0, 1, 2] {
            let mut bench = Bench::prepared(250, MotionMode::Jog);
            bench.jog(0, 4.0 * f64::from(towards), 4.0);
            bench.ticks(100);
            bench.now(TickCommand::stop(all(&[0]), all(&[])));
            for _ in 0..ticks {
                bench.tick();
            }
            let before = bench.tick.now();
            bench.now(soft(20));
            let view = bench.tick();
            assert_eq!(view.axes[0].stop, reason, "{before:?}");
            assert!(pulses(view.axes[0].pos) * f64::from(towards) > 40.0);
        }
        let mut bench = Bench::prepared(250, MotionMode::PtStatic);
        bench.pt(0, 0, &[(1000.0 * f64::from(towards), 100, 0)]);
        bench.start(&[0]);
        bench.ticks(100);
        check(&mut bench, 0);
    }
}

#[test]
fn a_limit_switch_stops_on_the_next_set_point_and_only_that_way() {
    let mut bench = Bench::prepared(250, MotionMode::Jog);
    bench.jog(0, 4.0, 4.0);
    bench.jog(1, -4.0, 4.0);
    let before = bench.ticks(50);
    bench.machine.inputs[0].limit_positive = true;
    bench.machine.inputs[1].limit_positive = true;
    let view = bench.tick();
    assert_eq!(view.axes[0].pos, before.axes[0].pos);
    assert!(has(&view.axes[0], LIMIT_POSITIVE) && !has(&view.axes[0], RUNNING));
    assert_eq!(view.axes[0].stop, StopReason::LimitPositive);
    assert!(has(&view.axes[1], LIMIT_POSITIVE | RUNNING), "away from the switch it goes on");
    // Still on the switch: ClearStatus leaves the bit, but moving back is allowed.
    bench.now(TickCommand::ClearStatus { axes: all(&[0]) });
    let view = bench.tick();
    assert!(has(&view.axes[0], LIMIT_POSITIVE) && view.axes[0].blocked == 0);
    bench.jog(0, 4.0, 4.0);
    assert!(!has(&bench.tick().axes[0], RUNNING));
    bench.jog(0, -4.0, 4.0);
    assert!(has(&bench.ticks(10).axes[0], RUNNING | LIMIT_POSITIVE));
    bench.machine.inputs[0].limit_positive = false;
    assert!(has(&bench.tick().axes[0], LIMIT_POSITIVE), "it latches");
    bench.now(TickCommand::ClearStatus { axes: all(&[0]) });
    assert!(!has(&bench.tick().axes[0], LIMIT_POSITIVE));
}

#[test]
fn pt_towards_a_switch_stops_when_it_moves_towards_it() {
    let mut bench = Bench::prepared(250, MotionMode::PtStatic);
    bench.machine.inputs[0].limit_negative = true;
    bench.tick();
    bench.now(TickCommand::ClearStatus { axes: all(&[0]) });
    bench.pt(0, 0, &[(10.0, 10, 0), (0.0, 30, 2)]);
    bench.start(&[0]);
    let zero = bench.tick().now.0;
    let view = bench.run_to_standstill();
    assert_eq!(view.axes[0].stop, StopReason::LimitNegative);
    // It may move away from the switch; reversing is what stops it.
    assert!(view.now.0 > zero + 9 * MS && pulses(view.axes[0].pos) > 9.0, "{:?}", view.axes[0].pos);
}

#[test]
fn guards_can_be_switched_off_and_inverted() {
    let mut bench = Bench::prepared(250, MotionMode::Jog);
    bench.machine.inputs[0].limit_positive = true;
    bench.now(TickCommand::Guard { axis: axis(0), on: Guards::set(Guarded::LimitPositive, false), low: Guards::NONE });
    bench.tick();
    bench.now(TickCommand::ClearStatus { axes: all(&[0]) });
    assert_eq!(bench.ticks(2).axes[0].status & LIMITS, 0);
    bench.now(TickCommand::Guard { axis: axis(0), on: Guards::set(Guarded::LimitPositive, true), low: Guards::NONE });
    bench.now(TickCommand::Guard { axis: axis(0), on: Guards::NONE, low: Guards::set(Guarded::LimitPositive, true) });
    assert_eq!(bench.ticks(2).axes[0].status & LIMITS, 0);
    bench.machine.inputs[0].limit_positive = false;
    assert_eq!(bench.tick().axes[0].status & LIMITS, LIMIT_POSITIVE);
}

#[test]
fn an_alarm_stops_and_blocks_until_it_is_gone_and_cleared() {
    let mut bench = Bench::prepared(250, MotionMode::Jog);
    bench.jog(0, -4.0, 4.0);
    let before = bench.ticks(50);
    bench.machine.inputs[0].alarm = true;
    let view = bench.tick();
    assert_eq!((view.axes[0].pos, view.axes[0].stop), (before.axes[0].pos, StopReason::Alarm));
    assert!(has(&view.axes[0], ALARM) && !has(&view.axes[0], RUNNING));
    bench.now(TickCommand::ClearStatus { axes: all(&[0]) });
    assert!(has(&bench.tick().axes[0], ALARM), "the cause is there");
    bench.jog(0, 4.0, 4.0);
    assert!(!has(&bench.tick().axes[0], RUNNING));
    bench.machine.inputs[0].alarm = false;
    assert!(has(&bench.tick().axes[0], ALARM), "it latches");
    bench.now(TickCommand::ClearStatus { axes: all(&[0]) });
    assert!(!has(&bench.tick().axes[0], ALARM));
    bench.jog(0, 4.0, 4.0);
    assert!(has(&bench.tick().axes[0], RUNNING));
}

#[test]
fn a_following_error_beyond_its_limit_stops() {
    let mut bench = Bench::prepared(250, MotionMode::Jog);
    bench.now(TickCommand::PositionError { axis: axis(0), limit: Some(20) });
    bench.jog(0, 4.0, 4.0);
    bench.ticks(50);
    bench.machine.slip[0] = -19;
    assert!(has(&bench.tick().axes[0], RUNNING));
    bench.machine.slip[0] = -22;
    let view = bench.tick();
    assert!(has(&view.axes[0], FOLLOWING_ERROR) && !has(&view.axes[0], RUNNING));
    assert_eq!(view.axes[0].stop, StopReason::FollowingError);
    bench.machine.slip[0] = 0;
    bench.tick();
    bench.now(TickCommand::ClearStatus { axes: all(&[0]) });
    assert!(!has(&bench.tick().axes[0], FOLLOWING_ERROR));
}

#[test]
fn the_edge_of_travel_stops_and_never_wraps() {
    let mut bench = Bench::prepared(1000, MotionMode::Jog);
    for (index, sign) in [(0, 1.0), (1, -1.0)] {
        let at = Pos((Pos::TRAVEL.0 - (1 << 36)) * sign as i64);
        bench.now(TickCommand::SetPosition { axis: axis(index), pos: at });
        bench.jog(index, sign * 4_000_000.0, 1_000_000.0);
    }
    let view = bench.run_to_standstill();
    assert_eq!(view.axes[0].pos, Pos::TRAVEL);
    assert_eq!(view.axes[1].pos, Pos(-Pos::TRAVEL.0));
    assert!(view.axes[..2].iter().all(|axis| axis.stop == StopReason::Travel));
}

#[test]
fn servo_off_stops_and_forbids() {
    let mut bench = Bench::prepared(250, MotionMode::Jog);
    bench.jog(0, 4.0, 4.0);
    bench.ticks(10);
    assert_eq!(bench.machine.outputs.0, 0xff);
    bench.now(TickCommand::Servo { axis: axis(0), on: false });
    let view = bench.tick();
    assert_eq!(view.axes[0].status & (SERVO_ON | RUNNING), 0);
    assert_eq!((view.axes[0].stop, bench.machine.outputs.0), (StopReason::ServoOff, 0xfe));
    bench.jog(0, 4.0, 4.0);
    assert!(!has(&bench.tick().axes[0], RUNNING));
}

#[test]
fn in_position_needs_rest_and_the_band_for_its_time() {
    let mut bench = Bench::prepared(250, MotionMode::PtStatic);
    bench.now(TickCommand::Band { axis: axis(0), band: 5, time: Ns(2 * MS) });
    bench.pt(0, 0, &[(100.0, 10, 2)]);
    bench.ticks(20);
    bench.start(&[0]);
    assert!(!has(&bench.tick().axes[0], IN_POSITION), "from the start on it is clear");
    bench.machine.slip[0] = -6;
    let end = bench.run_to_standstill();
    assert!(!has(&end.axes[0], IN_POSITION));
    assert!(!has(&bench.ticks(40).axes[0], IN_POSITION), "outside the band");
    bench.machine.slip[0] = -5;
    // Sampled inside at 0, 0.25 … 2 ms: nine ticks.
    assert!(!has(&bench.ticks(8).axes[0], IN_POSITION));
    assert!(has(&bench.tick().axes[0], IN_POSITION));
    bench.machine.slip[0] = 6;
    assert!(!has(&bench.tick().axes[0], IN_POSITION));
}

#[test]
fn setting_positions_makes_no_step() {
    let mut bench = Bench::prepared(250, MotionMode::PtStatic);
    bench.pt(0, 0, &[(100.25, 10, 2)]);
    bench.start(&[0]);
    bench.run_to_standstill();
    let machine = bench.machine.set_points[0];
    bench.now(TickCommand::SetPosition { axis: axis(0), pos: Pos::pulses(-7) });
    bench.now(TickCommand::SetEncoder { axis: axis(0), pulses: 33 });
    let view = bench.tick();
    assert_eq!((view.axes[0].pos, view.axes[0].encoder), (Pos::pulses(-7), 33));
    bench.now(TickCommand::SetPosition { axis: axis(0), pos: Pos::pulses(33) });
    assert_eq!(bench.tick().axes[0].pos, Pos::pulses(33));
    bench.start(&[0]);
    let view = bench.run_to_standstill();
    assert_eq!(pulses(view.axes[0].pos), 133.25);
    assert_eq!(bench.machine.set_points[0].0 - machine.0, 100 * (1 << 22) + (1 << 20));
    let machine = bench.machine.set_points[0];
    bench.now(TickCommand::Zero { axes: all(&[0]) });
    let view = bench.tick();
    assert_eq!((view.axes[0].pos, view.axes[0].encoder), (Pos(0), 0));
    bench.now(TickCommand::Reset { axes: all(&[0]) });
    let view = bench.tick();
    assert_eq!((view.axes[0].status, view.axes[0].mode), (0, MotionMode::Trap));
    assert_eq!(bench.machine.set_points[0], machine);
    assert_eq!(bench.machine.outputs.0, 0xfe, "its servo is off");
}

#[test]
fn home_captures_the_encoder_at_the_rising_edge() {
    let mut bench = Bench::prepared(250, MotionMode::Jog);
    bench.jog(0, 4.0, 4.0);
    bench.ticks(10);
    bench.machine.inputs[0].home = true;
    assert_eq!(bench.tick().axes[0].captured, None, "not armed");
    bench.now(TickCommand::Capture { axis: axis(0), mode: 1 });
    assert_eq!(bench.ticks(3).axes[0].captured, None, "no edge");
    bench.machine.inputs[0].home = false;
    bench.tick();
    bench.machine.inputs[0].home = true;
    let view = bench.tick();
    assert_eq!(view.axes[0].captured, Some(view.axes[0].encoder));
    let captured = view.axes[0].captured;
    assert_eq!(bench.ticks(3).axes[0].captured, captured);
    bench.now(TickCommand::Capture { axis: axis(0), mode: 2 });
    bench.machine.inputs[0].home = false;
    bench.tick();
    bench.machine.inputs[0].home = true;
    assert_eq!(bench.tick().axes[0].captured, None, "home is no index");
}

/// PT and Trap that end between two ticks beyond the limit, having been before it at the last tick.
#[test]
fn a_soft_limit_holds_the_end_of_a_motion() {
    for towards in [1, -1] {
        let (positive, negative) = if towards > 0 { (Some(99), None) } else { (None, Some(-99)) };
        let mut bench = Bench::prepared(1000, MotionMode::PtStatic);
        bench.pt(0, 0, &[(98.0 * f64::from(towards), 49, 1), (100.0 * f64::from(towards), 50, 1)]);
        bench.now(TickCommand::SoftLimit { axis: axis(0), positive, negative });
        bench.start(&[0]);
        let view = bench.run_to_standstill();
        let reason = if towards > 0 { StopReason::SoftPositive } else { StopReason::SoftNegative };
        assert_eq!((view.axes[0].pos, view.axes[0].stop), (Pos::pulses(99 * towards), reason));
        assert!(view.axes[0].blocked != 0);
    }
}

/// At rest beyond a limit that is set now: published, and blocked until it is cleared; then only
/// moving back is allowed.
#[test]
fn a_soft_limit_that_an_axis_at_standstill_has_passed_is_reported() {
    for (towards, bit) in [(1, LIMIT_POSITIVE), (-1, LIMIT_NEGATIVE)] {
        let mut bench = Bench::prepared(250, MotionMode::Jog);
        bench.now(TickCommand::SetPosition { axis: axis(0), pos: Pos::pulses(50 * towards) });
        bench.ticks(3);
        let (positive, negative) = if towards > 0 { (Some(20), None) } else { (None, Some(-20)) };
        bench.now(TickCommand::SoftLimit { axis: axis(0), positive, negative });
        let view = bench.ticks(2);
        assert_eq!((view.axes[0].status & LIMITS, view.axes[0].blocked), (bit, bit));
        bench.jog(0, f64::from(-towards), 1.0);
        assert!(!has(&bench.tick().axes[0], RUNNING));
        bench.now(TickCommand::ClearStatus { axes: all(&[0]) });
        bench.jog(0, f64::from(-towards), 1.0);
        assert!(has(&bench.ticks(2).axes[0], RUNNING));
    }
}

/// ClrSts and a start in one tick, while the alarm is there: refused, not begun and stopped.
#[test]
fn a_start_after_a_clear_in_the_same_tick_is_refused_while_the_cause_lasts() {
    let mut bench = Bench::prepared(250, MotionMode::Jog);
    bench.machine.inputs[0].alarm = true;
    bench.ticks(2);
    bench.now(TickCommand::ClearStatus { axes: all(&[0]) });
    bench.jog(0, 4.0, 4.0);
    bench.tick();
    assert!(matches!(bench.event(), Some(Event::Refused { .. })));
    assert!(bench.event().is_none());
}

/// Encoders of an axis whose servo is off may turn; and an error that is the limit is none yet.
#[test]
fn a_following_error_is_more_than_its_limit_and_needs_the_servo() {
    let mut bench = Bench::prepared(250, MotionMode::Jog);
    bench.now(TickCommand::PositionError { axis: axis(0), limit: Some(20) });
    for slip in [20, -20] {
        bench.machine.slip[0] = slip;
        assert!(!has(&bench.ticks(3).axes[0], FOLLOWING_ERROR), "{slip}");
    }
    bench.now(TickCommand::Servo { axis: axis(0), on: false });
    bench.tick();
    bench.machine.slip[0] = 500;
    assert!(!has(&bench.ticks(3).axes[0], FOLLOWING_ERROR), "the servo is off");
    bench.machine.slip[0] = 21;
    bench.now(TickCommand::Servo { axis: axis(0), on: true });
    assert!(has(&bench.ticks(3).axes[0], FOLLOWING_ERROR));
}

/// The band's time begins anew after an error, a motion, and with a new band.
#[test]
fn the_time_in_the_band_begins_anew() {
    let band = TickCommand::Band { axis: axis(0), band: 5, time: Ns(2 * MS) };
    type Break = fn(&mut Bench);
    let breaks: [Break; 3] = [
        |bench| {
            bench.machine.slip[0] = 6;
            bench.tick();
            bench.machine.slip[0] = 0;
        },
        |bench| {
            bench.jog(0, 0.001, 1.0);
            bench.ticks(2);
            bench.now(TickCommand::stop(all(&[0]), all(&[0])));
            assert!(!has(&bench.tick().axes[0], RUNNING));
        },
        |bench| {
            bench.now(TickCommand::Band { axis: axis(0), band: 4, time: Ns(2 * MS) });
            bench.tick();
        },
    ];
    for (index, act) in breaks.into_iter().enumerate() {
        let mut bench = Bench::prepared(250, MotionMode::Jog);
        bench.now(band);
        assert!(has(&bench.ticks(20).axes[0], IN_POSITION));
        act(&mut bench);
        assert!(!has(&bench.ticks(7).axes[0], IN_POSITION), "{index}");
        assert!(has(&bench.ticks(3).axes[0], IN_POSITION), "{index}");
    }
}

#[test]
fn home_captures_at_the_falling_edge_where_low_is_active() {
    let mut bench = Bench::prepared(250, MotionMode::Jog);
    bench.machine.inputs[0].home = true;
    bench.now(TickCommand::Guard { axis: axis(0), on: Guards::NONE, low: Guards::set(Guarded::Home, true) });
    bench.jog(0, 4.0, 4.0);
    bench.ticks(10);
    bench.now(TickCommand::Capture { axis: axis(0), mode: 1 });
    assert_eq!(bench.ticks(3).axes[0].captured, None, "it is not active");
    bench.machine.inputs[0].home = false;
    let view = bench.tick();
    assert_eq!(view.axes[0].captured, Some(view.axes[0].encoder));
    bench.machine.inputs[0].home = true;
    bench.ticks(3);
    bench.machine.inputs[0].home = false;
    assert_eq!(bench.ticks(3).axes[0].captured, view.axes[0].captured, "once");
    bench.now(TickCommand::Capture { axis: axis(0), mode: 1 });
    bench.ticks(2);
    bench.machine.inputs[0].home = true;
    assert_eq!(bench.ticks(3).axes[0].captured, None, "no edge since it was armed");
}

#[test]
fn an_index_edge_captures_the_count_at_which_it_came() {
    let mut bench = Bench::prepared(250, MotionMode::Jog);
    // The machine counts from 0, the encoder reads 1000 there.
    bench.now(TickCommand::SetEncoder { axis: axis(0), pulses: 1000 });
    bench.tick();
    bench.jog(0, 4.0, 4.0);
    bench.ticks(10);
    // An edge in the tick that arms counts from its end on: earlier edges do not count.
    bench.machine.index[0] = Some(3);
    bench.now(TickCommand::Capture { axis: axis(0), mode: 2 });
    assert_eq!(bench.tick().axes[0].captured, None);
    bench.machine.index[0] = None;
    bench.machine.inputs[0].home = true;
    assert_eq!(bench.ticks(3).axes[0].captured, None, "home is no index");
    bench.machine.index = [Some(-70_000); AXES];
    let view = bench.tick();
    assert_eq!(view.axes[0].captured, Some(1000 - 70_000));
    assert_eq!(view.axes[1].captured, None, "not armed");
    // Only the first edge after arming counts, and only in its mode.
    bench.machine.index[0] = Some(5);
    assert_eq!(bench.ticks(3).axes[0].captured, Some(1000 - 70_000));
    for undo in [TickCommand::Capture { axis: axis(0), mode: 1 }, TickCommand::Reset { axes: all(&[0]) }] {
        bench.now(TickCommand::Capture { axis: axis(0), mode: 2 });
        bench.now(undo);
        bench.tick();
        bench.machine.index[0] = Some(5);
        assert_eq!(bench.ticks(3).axes[0].captured, None);
    }
}

#[test]
fn trap_reaches_its_target_and_can_be_changed_under_way() {
    let mut bench = Bench::prepared(250, MotionMode::Trap);
    let prm =
        |axis| TickCommand::TrapPrm { axis, acc: accel(0.5), dec: accel(0.25), vel_start: speed(0.0), smooth: Ns(0) };
    bench.now(prm(axis(0)));
    bench.now(TickCommand::TargetSpeed { axis: axis(0), speed: speed(10.0) });
    bench.now(TickCommand::TargetPosition { axis: axis(0), pulses: 5000 });
    bench.now(TickCommand::Update { axes: all(&[0]) });
    let zero = bench.tick().now.0;
    let view = bench.until(zero + 200 * MS);
    assert_eq!(real(view.axes[0].motion.velocity()), 10.0);
    bench.now(TickCommand::TargetPosition { axis: axis(0), pulses: -123 });
    bench.now(TickCommand::Update { axes: all(&[0]) });
    let view = bench.run_to_standstill();
    assert_eq!((view.axes[0].pos, view.axes[0].stop), (Pos::pulses(-123), StopReason::Completed));
}
