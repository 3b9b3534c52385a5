//! What a path must not begin, pass or gear, where only the tick can prevent it.
use crate::tick_bench;
use servo::path::{MotionSpeeds, PathEntry};
use servo::status;
use servo::tick_command::{DoGroup, Guarded, Guards, MotionMode, TickCommand};
use servo::units::{AxisMask, CrdMask, Pos, StepLimit};
use servo::view::{Event, StopReason};

use tick_bench::*;

fn speeds(vel: f64, acc: f64, end: f64) -> MotionSpeeds {
    MotionSpeeds::admit(vel.to_bits(), acc.to_bits(), end.to_bits()).unwrap()
}

/// Coordinate system 0 on axes 0 and 1, coordinate system 1 on axes 2 and 3, all at 0.
fn prepared(period_us: u32) -> Bench {
    let mut bench = Bench::prepared(period_us, MotionMode::Trap);
    bench.frame(0, &[0, 1], None);
    bench.frame(1, &[2, 3], None);
    bench.tick();
    bench
}

fn runs(bench: &mut Bench, index: usize) -> bool {
    bench.tick().crds[index].runs
}

/// However long the motions are and whatever lies between them: the path may be far from the limit
/// at the first check, by more than the 1024 pulses within which each position is checked.
#[test]
fn a_soft_limit_holds_whichever_motion_comes_to_it() {
    for (period, step, between, limit) in [50, 250, 1000].into_iter().flat_map(|period| {
        [170, 700, 2900].into_iter().flat_map(move |step| {
            [false, true]
                .into_iter()
                .flat_map(move |between| [350, 4500, 6801, 9000].map(|limit| (period, step, between, limit)))
        })
    }) {
        let mut bench = prepared(period);
        bench.now(TickCommand::SoftLimit { axis: axis(0), positive: Some(limit), negative: None });
        let mut entries = vec![];
        for x in (step..12_000).step_by(step as usize) {
            entries.push(PathEntry::planar([x, x / 7], speeds(100.0, 25.0, 100.0)));
            if between {
                entries.push(PathEntry::output(DoGroup::General, 1, x as u64 & 1));
            }
        }
        bench.path(0, 0, &entries);
        bench.start_path(&[0]);
        let view = loop {
            let view = bench.tick();
            assert!(pulses(view.axes[0].pos) <= f64::from(limit), "{period} {step} {between} {limit}");
            if !view.crds[0].runs {
                break view;
            }
        };
        assert_eq!(view.crds[0].stop, StopReason::SoftPositive);
    }
}

/// SetCrdPrm that reaches the tick too late changes nothing: its axes move.
#[test]
fn a_frame_is_not_set_while_something_of_it_moves() {
    let mut bench = prepared(250);
    bench.path(0, 0, &[PathEntry::planar([400, 0], speeds(10.0, 1.0, 0.0))]);
    bench.start_path(&[0]);
    let frame = bench.ticks(40).crds[0].frame;
    bench.frame(0, &[5, 6], None);
    bench.frame(1, &[1, 0], None);
    let view = bench.tick();
    assert_eq!(format!("{:?}", view.crds[0].frame), format!("{frame:?}"));
    assert!(view.crds[0].runs && view.crds[1].frame.is_some_and(|frame| frame.mask() == all(&[2, 3])));
    let end = bench.run_to_standstill();
    assert_eq!((pulses(end.axes[0].pos), end.crds[0].stop), (400.0, StopReason::Completed));
    bench.now(TickCommand::SetMode { axis: axis(6), mode: MotionMode::Jog });
    bench.jog(6, 3.0, 1.0);
    bench.ticks(3);
    bench.frame(0, &[5, 6], None);
    let view = bench.ticks(3);
    assert_eq!(view.crds[0].frame.map(|frame| frame.mask()), Some(all(&[0, 1])));
    assert!(has(&view.axes[6], status::RUNNING) && view.axes[6].mode == MotionMode::Jog);
}

/// Targets reach 2³¹ pulses from the zero, and so may a beginning.
#[test]
fn a_path_does_not_begin_too_far_from_its_zero() {
    for (at, begins) in [(1i64 << 31, true), ((1 << 31) + 1, false), (-(1 << 31), true), (-(1 << 31) - 1, false)] {
        let mut bench = Bench::prepared(250, MotionMode::Trap);
        bench.frame(0, &[0, 1], Some([0; 4]));
        bench.tick();
        bench.now(TickCommand::SetPosition { axis: axis(1), pos: Pos(at << Pos::FRAC_BITS) });
        bench.tick();
        bench.path(0, 0, &[PathEntry::planar([0, 0], speeds(10.0, 1.0, 0.0))]);
        bench.start_path(&[0]);
        assert_eq!(runs(&mut bench, 0), begins, "{at}");
        assert_eq!(matches!(bench.event(), Some(Event::CrdRefused { .. })), !begins);
    }
}

/// An axis that was geared when the path was stopped must be able to when it goes on.
#[test]
fn a_path_does_not_go_on_without_what_went_along() {
    let mut bench = prepared(250);
    bench.path(0, 0, &[PathEntry::gear(axis(4), 100), PathEntry::planar([100, 0], speeds(10.0, 1.0, 0.0))]);
    bench.start_path(&[0]);
    bench.ticks(40);
    bench.now(TickCommand::stop_crds(CrdMask(1), CrdMask(1)));
    assert!(!runs(&mut bench, 0));
    while bench.event().is_some() {}
    bench.now(TickCommand::Servo { axis: axis(4), on: false });
    bench.start_path(&[0]);
    assert!(!runs(&mut bench, 0));
    let Some(Event::Refused { axis: refused, .. }) = bench.event() else { panic!("it is reported") };
    assert_eq!(refused, axis(4));
    bench.now(TickCommand::Servo { axis: axis(4), on: true });
    bench.start_path(&[0]);
    bench.tick();
    let end = bench.run_to_standstill();
    assert_eq!([0, 4].map(|axis| pulses(end.axes[axis].pos)), [100.0, 100.0]);
}

/// A fault of a geared axis stops the path in that tick, with the reason that it was another axis.
#[test]
fn a_fault_of_an_axis_that_goes_along_stops_the_path() {
    type Break = fn(&mut Bench);
    let breaks: [Break; 3] = [
        |bench| bench.machine.inputs[4].alarm = true,
        |bench| bench.machine.inputs[4].limit_positive = true,
        |bench| bench.machine.slip[4] = 100,
    ];
    for (index, act) in breaks.into_iter().enumerate() {
        let mut bench = prepared(250);
        bench.now(TickCommand::PositionError { axis: axis(4), limit: Some(50) });
        bench.path(0, 0, &[PathEntry::gear(axis(4), 100), PathEntry::planar([400, 0], speeds(10.0, 1.0, 0.0))]);
        bench.start_path(&[0]);
        assert!(bench.ticks(80).crds[0].runs);
        act(&mut bench);
        let view = bench.tick();
        assert_eq!((view.crds[0].runs, view.crds[0].stop), (false, StopReason::OtherAxis), "{index}");
        let (x, along) = (pulses(view.axes[0].pos), pulses(view.axes[4].pos));
        assert!(x > 100.0 && x < 200.0 && (along - x / 4.0).abs() < 1e-3, "{index}: {x} {along}");
    }
}

/// Neither geared to another path nor moved by it: an axis of a coordinate system is its own.
#[test]
fn an_axis_of_another_path_does_not_go_along() {
    let mut bench = prepared(250);
    bench.path(0, 0, &[PathEntry::gear(axis(2), 100), PathEntry::planar([100, 0], speeds(10.0, 1.0, 0.0))]);
    bench.start_path(&[0]);
    let view = bench.run_to_standstill();
    assert_eq!((view.crds[0].stop, pulses(view.axes[2].pos)), (StopReason::OtherAxis, 0.0));
}

/// A geared axis takes no other commands, neither from a call nor from an entry.
#[test]
fn an_axis_that_goes_along_is_sent_nowhere_else() {
    let mut bench = prepared(250);
    let v = speeds(10.0, 1.0, 0.0);
    bench.path(0, 0, &[PathEntry::gear(axis(4), 100), PathEntry::planar([100, 0], v)]);
    let away =
        PathEntry::travel(axis(4), -30, (2f64.to_bits(), StepLimit::FULL_SCALE), 0.5f64.to_bits(), false).unwrap();
    bench.path(1, 0, &[away, PathEntry::planar([100, 0], v)]);
    let prm = TickCommand::TrapPrm {
        axis: axis(4),
        acc: accel(1.0),
        dec: accel(1.0),
        vel_start: speed(0.0),
        smooth: servo::units::Ns(0),
    };
    bench.now(prm);
    bench.now(TickCommand::TargetSpeed { axis: axis(4), speed: speed(5.0) });
    bench.now(TickCommand::TargetPosition { axis: axis(4), pulses: -77 });
    bench.start_path(&[0]);
    bench.ticks(40);
    while bench.event().is_some() {}
    bench.now(TickCommand::Update { axes: all(&[4]) });
    bench.tick();
    assert!(matches!(bench.event(), Some(Event::Refused { .. })), "not by Update");
    bench.start_path(&[1]);
    let view = bench.ticks(3);
    assert_eq!((view.crds[1].runs, view.crds[1].stop), (false, StopReason::OtherAxis), "nor by an entry");
    let end = bench.run_to_standstill();
    assert_eq!([0, 4].map(|axis| pulses(end.axes[axis].pos)), [100.0, 100.0]);
}

/// The axis that the path waited for has arrived; if a later motion of it is stopped, that does not
/// concern the path.
#[test]
fn an_axis_that_was_waited_for_is_free_again() {
    let mut bench = prepared(250);
    let v = speeds(10.0, 1.0, 0.0);
    let away = PathEntry::travel(axis(4), 30, (10f64.to_bits(), StepLimit::FULL_SCALE), 5f64.to_bits(), true).unwrap();
    bench.path(0, 0, &[away, PathEntry::planar([900, 0], v)]);
    bench.start_path(&[0]);
    bench.ticks(80);
    bench.now(TickCommand::SetMode { axis: axis(4), mode: MotionMode::Jog });
    bench.jog(4, 3.0, 1.0);
    bench.ticks(20);
    bench.now(TickCommand::stop(all(&[4]), all(&[4])));
    bench.ticks(3);
    let end = bench.run_to_standstill();
    assert_eq!((pulses(end.axes[0].pos), end.crds[0].stop), (900.0, StopReason::Completed));
}

/// A Stop, and the link that is lost while it brakes: it was stopped by the Stop.
#[test]
fn why_a_path_brakes_is_reported_by_the_first_order() {
    let mut bench = prepared(250);
    bench.path(0, 0, &[PathEntry::planar([900, 0], speeds(10.0, 1.0, 0.0))]);
    bench.start_path(&[0]);
    bench.ticks(60);
    bench.now(TickCommand::stop_crds(CrdMask(1), CrdMask(0)));
    bench.ticks(4);
    bench.now(TickCommand::Link { lost: true });
    assert_eq!(bench.run_to_standstill().crds[0].stop, StopReason::StopSmooth);
    let guard = TickCommand::Guard { axis: axis(0), on: Guards::set(Guarded::Alarm, true), low: Guards::NONE };
    bench.now(guard);
    bench.now(TickCommand::ClearStatus { axes: AxisMask(0xff) });
    bench.now(TickCommand::Link { lost: false });
    bench.tick();
    bench.start_path(&[0]);
    bench.ticks(60);
    bench.now(TickCommand::Link { lost: true });
    bench.ticks(4);
    bench.now(TickCommand::stop_crds(CrdMask(1), CrdMask(0)));
    assert_eq!(bench.run_to_standstill().crds[0].stop, StopReason::LinkLoss);
}
