//! Causes of darkness that meet a path in motion (SPEC 9): edge of travel, another axis, an
//! underrun and what comes with it.
use crate::laser_bench;
use laser_bench::*;
use servo::laser::{Cause, ChannelChange, Family};
use servo::path::PathEntry;
use servo::tick_command::{DoGroup, MotionMode as AxisMode, TickCommand};
use servo::units::{AxisMask, Pos, StepLimit};
use servo::view::{LaserView, StopReason, View};

/// Coordinate system 1 on axes 1 and 2; channel 0 heeds it, channel 1 heeds coordinate system 2
/// alone. Both are lit by calls.
fn prepared(period_us: u32) -> Bench {
    let mut bench = Bench::new(period_us);
    bench.change(ChannelChange::Reset { family: Family::Gus });
    bench.command(TickCommand::Output { group: DoGroup::Enable, mask: 0xf, value: 0xf });
    bench.frame(0, &[0, 1]);
    bench.carrier(10.0);
    bench.direct(100.0);
    for (channel, map) in [(0, 0b01), (1, 0b10)] {
        bench.command(TickCommand::Laser { channel, change: ChannelChange::CrdMap { map } });
        bench.command(TickCommand::Laser { channel, change: ChannelChange::Gate { on: true } });
    }
    bench
}

/// Ticks until coordinate system 1 is at rest; also the view one tick before.
fn rest(bench: &mut Bench) -> (View<AXES>, View<AXES>) {
    let mut before = bench.view();
    loop {
        bench.tick();
        let now = bench.view();
        assert!(now.now.0 < 10_000 * MS, "it does not come to rest");
        if before.crds[0].runs && !now.crds[0].runs {
            return (before, now);
        }
        before = now;
    }
}

fn reported(lasers: &[LaserView; 2]) -> [(Cause, bool); 2] {
    [0, 1].map(|channel| (lasers[channel].fault, lasers[channel].light))
}

/// A path goes no further than 2⁴⁰ pulses from 0 on either side. A channel mapped to it goes dark
/// with the cause Fault in that tick and stays dark; ClrSts of a mapped axis ends it.
#[test]
fn a_path_at_the_edge_of_travel_shuts_off_its_lasers() {
    for (period, sign) in [(50, 1), (250, -1), (1000, 1), (1000, -1)] {
        let mut bench = prepared(period);
        bench.command(TickCommand::SetPosition {
            axis: axis(0),
            pos: Pos((Pos::TRAVEL.0 - (100 << Pos::FRAC_BITS)) * sign),
        });
        bench.frame(0, &[0, 1]);
        bench.path(0, &[line([400 * sign as i32, 0], 10.0, 1.0, 0.0)]);
        bench.start(1);
        let (before, now) = rest(&mut bench);
        assert_eq!((now.crds[0].stop, now.axes[0].stop), (StopReason::Travel, StopReason::Travel));
        assert!(now.axes[0].pos.0.abs() <= Pos::TRAVEL.0 && now.axes[0].pos.0.abs() > Pos::TRAVEL.0 - (20 << 22));
        assert_eq!(reported(&before.lasers), [(Cause::None, true); 2]);
        assert_eq!(reported(&now.lasers), [(Cause::Fault, false), (Cause::None, true)], "{period}");
        bench.tick();
        bench.gate(true);
        bench.until(bench.tick.now().0 + 5 * MS);
        assert_eq!(reported(&bench.view().lasers), [(Cause::Fault, false), (Cause::None, true)]);
        bench.command(TickCommand::ClearStatus { axes: AxisMask(0b10) });
        bench.tick();
        assert_eq!(bench.view().lasers[0].fault, Cause::None);
        assert!(!bench.view().lasers[0].light, "clearing lights nothing");
    }
}

/// An entry wants what an axis must not do, as its servo is off: the path stops, and its channels
/// go dark at once.
#[test]
fn an_axis_that_refuses_an_entry_shuts_off_the_lasers_of_its_path() {
    for period in [50, 250, 1000] {
        let mut bench = prepared(period);
        bench.command(TickCommand::SetMode { axis: axis(3), mode: AxisMode::Trap });
        bench.command(TickCommand::Output { group: DoGroup::Enable, mask: 0b1000, value: 0 });
        let away =
            PathEntry::travel(axis(3), 50, (2f64.to_bits(), StepLimit::FULL_SCALE), 1f64.to_bits(), false).unwrap();
        bench.path(0, &[line([37, 0], 10.0, 1.0, 0.0), away, line([0, 0], 10.0, 1.0, 0.0)]);
        bench.start(1);
        let (before, now) = rest(&mut bench);
        assert_eq!(now.crds[0].stop, StopReason::OtherAxis);
        assert_eq!(reported(&before.lasers)[1], (Cause::None, true));
        assert_eq!(reported(&now.lasers), [(Cause::Fault, false), (Cause::None, true)], "{period}");
    }
}

/// An alarm of an axis that is only geared to the path: the same.
#[test]
fn an_alarm_of_an_axis_that_goes_along_shuts_off_the_lasers_of_its_path() {
    for period in [50, 250, 1000] {
        let mut bench = prepared(period);
        bench.command(TickCommand::SetMode { axis: axis(3), mode: AxisMode::Trap });
        bench.path(0, &[PathEntry::gear(axis(3), 50), line([400, 0], 10.0, 1.0, 0.0)]);
        let zero = bench.start(1);
        bench.until(zero + 20 * MS);
        assert!(bench.view().crds[0].runs && bench.view().lasers[0].light);
        bench.machine.inputs[3].alarm = true;
        bench.tick();
        let now = bench.view();
        assert_eq!((now.crds[0].runs, now.crds[0].stop), (false, StopReason::OtherAxis));
        assert_eq!(reported(&now.lasers), [(Cause::Fault, false), (Cause::None, true)], "{period}");
        assert_eq!(bench.switch().last(), Some(&(zero + 20 * MS, false)));
    }
}

/// A geared axis meets its soft limit: the path stops before it, dark.
#[test]
fn a_soft_limit_of_a_geared_axis_shuts_off_the_lasers_of_its_path() {
    for period in [50, 250, 1000] {
        let mut bench = prepared(period);
        bench.command(TickCommand::SetMode { axis: axis(3), mode: AxisMode::Trap });
        let limit = Pos::pulses(20);
        bench.command(TickCommand::SoftLimit { axis: axis(3), positive: Some(20), negative: None });
        bench.path(0, &[PathEntry::gear(axis(3), 50), line([400, 0], 10.0, 1.0, 0.0)]);
        bench.start(1);
        let (before, now) = rest(&mut bench);
        assert!(before.lasers[0].light);
        assert_eq!((now.crds[0].stop, now.axes[3].stop), (StopReason::SoftPositive, StopReason::SoftPositive));
        assert_eq!(reported(&now.lasers), [(Cause::Limit, false), (Cause::None, true)], "{period}");
        let short = limit.0 - now.axes[3].pos.0;
        assert!((0..limit.0 / 1000).contains(&short), "{short}");
        // Dark in the tick before the one at which it would have gone beyond the limit.
        assert_eq!(bench.switch().last(), Some(&(before.now.0, false)));
    }
}

/// The path waits for an axis that is stopped during its move: the same.
#[test]
fn an_axis_that_is_waited_for_and_does_not_come_shuts_off_the_lasers_of_its_path() {
    let mut bench = prepared(250);
    bench.command(TickCommand::SetMode { axis: axis(3), mode: AxisMode::Trap });
    let away = PathEntry::travel(axis(3), 500, (2f64.to_bits(), StepLimit::FULL_SCALE), 1f64.to_bits(), true).unwrap();
    bench.path(0, &[line([37, 0], 10.0, 1.0, 0.0), away, line([0, 0], 10.0, 1.0, 0.0)]);
    let zero = bench.start(1);
    bench.until(zero + 50 * MS);
    assert!(bench.view().crds[0].runs && bench.view().lasers[0].light);
    bench.command(TickCommand::stop(AxisMask(0b1000), AxisMask(0b1000)));
    let (_, now) = rest(&mut bench);
    assert_eq!(now.crds[0].stop, StopReason::OtherAxis);
    assert_eq!(reported(&now.lasers), [(Cause::Fault, false), (Cause::None, true)]);
}

/// Ticks of 0.7 ms; the path of coordinate system 1 runs out at speed 12 ms after its start, which
/// is 0.1 ms after a tick. Just before the tick of 11.9 ms, when the machine has the plan that goes
/// dark at 12 ms.
fn running_out() -> (Bench, u64) {
    let mut bench = prepared(700);
    bench.path(0, &[light(true), line([50, 0], 10.0, 1.0, 10.0), line([68, 0], 10.0, 1.0, 0.0)]);
    let zero = bench.start(1);
    bench.until(zero + 11_900_000);
    assert!(bench.view().lasers[0].light);
    (bench, zero)
}

/// An underrun within an interval is dark at its instant; the first tick after it demands the safe
/// state.
#[test]
fn all_goes_to_the_safe_state_in_the_first_tick_after_an_underrun() {
    let (mut bench, zero) = running_out();
    bench.until(zero + 30 * 700_000);
    assert_eq!(bench.switch().last(), Some(&(zero + 12_000_000, false)));
    assert_eq!(bench.machine.outputs[0].rests, Some(zero + 12_600_000));
    assert_eq!(bench.machine.outputs[1].rests, None);
}

/// Another cause before the instant of an underrun does not wait for it: dark in that very tick.
#[test]
fn a_cause_that_comes_before_the_instant_of_an_underrun_is_dark_at_once() {
    type Break = fn(&mut Bench);
    let breaks: [(&str, Break); 6] = [
        ("interlock", |bench| bench.machine.interlock = true),
        ("overrun", |bench| bench.tick.overrun()),
        ("alarm", |bench| bench.machine.inputs[0].alarm = true),
        ("limit", |bench| bench.machine.inputs[1].limit_negative = true),
        ("servo off", |bench| bench.command(TickCommand::Servo { axis: axis(0), on: false })),
        ("link lost", |bench| bench.command(TickCommand::Link { lost: true })),
    ];
    for (name, act) in breaks {
        let (mut bench, zero) = running_out();
        act(&mut bench);
        bench.until(zero + 30 * 700_000);
        assert_eq!(bench.switch().last(), Some(&(zero + 11_900_000, false)), "{name}");
        assert_eq!(bench.pulses().last().map(|pulse| pulse.1), Some(zero + 11_900_000), "{name}");
        assert_eq!(bench.machine.outputs[0].rests, Some(zero + 11_900_000), "{name}");
        assert_eq!(bench.view().lasers[0].fault, Cause::Underrun, "{name}: the first one is reported");
    }
}

/// A soft limit in the path: dark in the tick that finds it, for a limit.
#[test]
fn a_soft_limit_on_a_path_shuts_off_its_lasers() {
    for period in [50, 250, 1000] {
        let mut bench = prepared(period);
        bench.command(TickCommand::SoftLimit { axis: axis(0), positive: Some(60), negative: None });
        bench.path(0, &[line([400, 0], 10.0, 1.0, 0.0)]);
        bench.start(1);
        let (before, now) = rest(&mut bench);
        assert_eq!(now.crds[0].stop, StopReason::SoftPositive);
        assert_eq!(reported(&now.lasers), [(Cause::Limit, false), (Cause::None, true)], "{period}");
        assert_eq!(bench.switch().last(), Some(&(before.now.0, false)));
    }
}

/// A following error beyond its limit, at rest or in motion: dark in that tick.
#[test]
fn a_following_error_shuts_off_the_lasers_of_its_path() {
    for runs in [false, true] {
        let mut bench = prepared(250);
        bench.command(TickCommand::PositionError { axis: axis(1), limit: Some(9) });
        bench.path(0, &[line([400, 0], 10.0, 1.0, 0.0)]);
        if runs {
            bench.start(1);
        }
        bench.until(5 * MS);
        bench.machine.encoders[1] = -10;
        bench.tick();
        let now = bench.view();
        assert_eq!(reported(&now.lasers), [(Cause::Fault, false), (Cause::None, true)]);
        assert_eq!(bench.switch().last(), Some(&(5 * MS, false)));
        assert!(!now.crds[0].runs && (!runs || now.crds[0].stop == StopReason::FollowingError));
    }
}

/// An alarm and a limit in one tick: the alarm is published, which lasts.
#[test]
fn of_two_causes_in_one_tick_the_graver_is_reported() {
    let mut bench = prepared(250);
    bench.until(5 * MS);
    (bench.machine.inputs[0].alarm, bench.machine.inputs[0].limit_positive) = (true, true);
    bench.tick();
    assert_eq!(bench.view().lasers[0].fault, Cause::Alarm);
}

/// For an axis that was removed from its coordinate system: neither an alarm, nor a limit, nor its
/// servo shuts off light there, and ClrSts of it clears nothing. Nor does anything before an axis
/// was mapped, or a servo that is off already.
#[test]
fn an_axis_that_is_not_mapped_is_nothing_to_lasers() {
    type Act = fn(&mut Bench);
    let acts: [Act; 3] = [
        |bench| bench.machine.inputs[1].alarm = true,
        |bench| bench.machine.inputs[1].limit_positive = true,
        |bench| bench.command(TickCommand::Servo { axis: axis(1), on: false }),
    ];
    for (index, act) in acts.into_iter().enumerate() {
        let mut bench = prepared(250);
        bench.command(TickCommand::SetMode { axis: axis(1), mode: AxisMode::Jog });
        bench.until(5 * MS);
        act(&mut bench);
        bench.until(6 * MS);
        assert_eq!(reported(&bench.view().lasers), [(Cause::None, true); 2], "{index}");
    }
    // ClrSts.
    let mut bench = prepared(250);
    bench.until(5 * MS);
    bench.tick.overrun();
    bench.command(TickCommand::SetMode { axis: axis(1), mode: AxisMode::Jog });
    bench.until(6 * MS);
    bench.command(TickCommand::ClearStatus { axes: AxisMask(0b10) });
    bench.until(7 * MS);
    assert_eq!(bench.view().lasers[0].fault, Cause::Overrun);
    bench.command(TickCommand::ClearStatus { axes: AxisMask(0b01) });
    bench.until(8 * MS);
    assert_eq!(bench.view().lasers[0].fault, Cause::None);
    // What was before.
    let mut bench = prepared(250);
    bench.machine.inputs[2].limit_positive = true;
    bench.command(TickCommand::Servo { axis: axis(3), on: false });
    bench.until(5 * MS);
    bench.frame(1, &[2, 3]);
    bench.command(TickCommand::Servo { axis: axis(3), on: false });
    bench.until(6 * MS);
    assert_eq!(reported(&bench.view().lasers), [(Cause::None, true); 2]);
}
