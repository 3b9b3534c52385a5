//! Abort, new sessions, Stops of paths at rest, and motion after the interlock: the demands of SPEC
//! 6 and 9 on light and motion, with every instant worked out by hand.
use crate::laser_bench;
use laser_bench::*;
use servo::laser::{Buffered, Cause, ChannelChange, Family, Ignored, PowerMode};
use servo::path;
use servo::segment::ramp::{Accel, Speed};
use servo::tick_command::{Brake, DoGroup, MotionMode as AxisMode, Supervision, TickCommand};
use servo::units::{AxisMask, CrdMask, StepLimit};
use servo::view::StopReason;

/// A coordinate system on the first two axes; a carrier of 10 kHz, 100 %, so that light is one
/// pulse.
fn prepared(period_us: u32) -> Bench {
    let mut bench = Bench::new(period_us);
    bench.change(ChannelChange::Reset { family: Family::Gus });
    bench.command(TickCommand::Output { group: DoGroup::Enable, mask: 0xf, value: 0xf });
    bench.frame(0, &[0, 1]);
    bench.carrier(10.0);
    bench.direct(100.0);
    bench.tick();
    bench
}

fn speed(value: f64) -> Speed {
    Speed::admit(value.to_bits(), StepLimit::FULL_SCALE).unwrap()
}

fn accel(value: f64) -> Accel {
    Accel::admit(value.to_bits()).unwrap()
}

/// The fourth axis jogs at 10 pulse/ms; its stop takes 10 ms.
fn jog(bench: &mut Bench) {
    let axis = axis(3);
    bench.command(TickCommand::SetMode { axis, mode: AxisMode::Jog });
    bench.command(TickCommand::JogPrm { axis, acc: accel(10.0), dec: accel(10.0), smooth: 0 });
    bench.command(TickCommand::TargetSpeed { axis, speed: speed(10.0) });
    bench.command(TickCommand::StopDec { axis, smooth: accel(1.0), abrupt: accel(1000.0) });
    bench.command(TickCommand::Update { axes: axis.mask() });
}

/// Ticks until nothing runs; when that is.
fn until_rest(bench: &mut Bench) -> u64 {
    for _ in 0..10_000 {
        bench.tick();
        let view = bench.view();
        if !view.crds[0].runs && view.axes.iter().all(|axis| axis.status & servo::status::RUNNING == 0) {
            return bench.tick.now().0;
        }
    }
    panic!("it never rests");
}

#[test]
fn an_abort_is_dark_at_the_call_without_delays() {
    for period_us in [10, 50, 250, 1000] {
        let mut bench = prepared(period_us);
        bench.delays(3000, 0);
        bench.gate(true);
        bench.until(10 * MS);
        bench.command(TickCommand::Abort);
        let view = bench.tick();
        // The tick in force when it came: no plan and no delay comes between.
        assert_eq!(bench.switch().last(), Some(&(10 * MS, false)));
        assert_eq!(bench.pulses().last().map(|pulse| pulse.1), Some(10 * MS));
        assert!(!view.commanded && !view.light && !view.switch);
        assert_eq!(view.fault, Cause::None, "an abort is no fault");
        bench.until(20 * MS);
        assert_eq!(bench.switch().last(), Some(&(10 * MS, false)), "the edge of the off delay never comes");
    }
}

#[test]
fn what_is_output_without_light_waits_for_the_next_command() {
    // Standby.
    let mut bench = prepared(250);
    bench.standby(Some((5.0, 50.0)));
    bench.until(2 * MS);
    assert_eq!(bench.view().lasers[0].khz, power(5.0));
    bench.command(TickCommand::Abort);
    bench.until(4 * MS);
    assert_eq!(bench.view().lasers[0].khz, power(0.0));
    let pulses = servo::laser::Standby::admit(power(5.0), power(50.0), servo::laser::Clock::GHZ).unwrap();
    bench.change(ChannelChange::PairedStandby(Some(pulses)));
    bench.until(5 * MS);
    assert_eq!(bench.view().lasers[0].khz, power(0.0), "a command of the other channel is none of this one");
    bench.direct(50.0);
    bench.until(6 * MS);
    assert_eq!(bench.view().lasers[0].khz, power(5.0));
    // Pre-voltage.
    let mut bench = prepared(250);
    bench.mode(PowerMode::Analog, 10.0, 0.0, true);
    bench.change(ChannelChange::PreVoltage(Some(power(2.0))));
    bench.until(2 * MS);
    assert_eq!(bench.view().lasers[0].power, power(2.0));
    bench.command(TickCommand::Abort);
    bench.until(4 * MS);
    assert_eq!((bench.view().lasers[0].power, bench.volts().last().map(|volts| volts.1)), (power(0.0), Some(0)));
    bench.gate(false);
    bench.until(6 * MS);
    assert_eq!(bench.view().lasers[0].power, power(2.0), "an off command is a command, too");
    // The switch of mode 3.
    let mut bench = prepared(250);
    bench.mode(PowerMode::DutyOpen, 100.0, 0.0, true);
    bench.until(2 * MS);
    assert!(bench.view().lasers[0].switch);
    bench.command(TickCommand::NewSession);
    bench.until(4 * MS);
    assert!(!bench.view().lasers[0].switch);
    bench.direct(50.0);
    bench.until(6 * MS);
    assert!(bench.view().lasers[0].switch);
}

#[test]
fn an_abort_brings_everything_to_rest_and_refuses_on_commands_until_then() {
    let mut bench = prepared(250);
    jog(&mut bench);
    // 10 pulse/ms: it brakes within 10 ms and 50 pulses.
    bench.path(0, &[line([300, 0], 10.0, 1.0, 10.0), light(true), line([2000, 0], 10.0, 1.0, 0.0)]);
    bench.start(1);
    bench.until(31 * MS);
    assert!(bench.view().crds[0].runs && !bench.view().lasers[0].light);
    // 5 ms later it would have passed the on entry.
    bench.command(TickCommand::Abort);
    bench.tick();
    assert!(bench.view().aborts);
    bench.gate(true);
    let view = bench.tick();
    assert_eq!((view.commanded, view.ignored, view.ignored_count), (false, Ignored::Aborting, 1));
    let rest = until_rest(&mut bench);
    assert!((41 * MS..43 * MS).contains(&rest), "{rest}");
    let view = bench.view();
    assert_eq!((view.crds[0].stop, view.axes[3].stop), (StopReason::Abort, StopReason::Abort));
    assert!(!view.aborts, "and then it is over");
    assert_eq!(bench.switch(), [], "the on entry was passed, and is dead");
    assert!(bench.view().crds[0].released[0] >= 2, "it was passed");
    // The content of the FIFO stays; it goes on in the dark.
    bench.start(1);
    bench.until(60 * MS);
    assert!(bench.view().crds[0].runs && bench.switch().is_empty());
    bench.gate(true);
    bench.tick();
    assert!(bench.view().lasers[0].commanded, "an on command of its own lights");
}

#[test]
fn an_on_entry_after_the_position_of_the_abort_lights() {
    let mut bench = prepared(250);
    bench.path(0, &[line([300, 0], 10.0, 1.0, 10.0), light(true), line([2000, 0], 10.0, 1.0, 0.0)]);
    bench.start(1);
    bench.until(15 * MS);
    bench.command(TickCommand::Abort);
    until_rest(&mut bench);
    bench.start(1);
    bench.until(80 * MS);
    assert!(bench.view().lasers[0].light);
}

#[test]
fn a_new_session_begins_dark_and_motion_goes_on() {
    let mut bench = prepared(250);
    jog(&mut bench);
    bench.path(
        0,
        &[light(true), line([300, 0], 10.0, 1.0, 10.0), light(false), light(true), line([2000, 0], 10.0, 1.0, 0.0)],
    );
    let zero = bench.start(1);
    bench.until(20 * MS);
    assert!(bench.view().lasers[0].light);
    bench.command(TickCommand::NewSession);
    bench.until(60 * MS);
    let view = bench.view();
    assert!(view.crds[0].runs && view.axes[3].status & servo::status::RUNNING != 0 && !view.aborts);
    assert_eq!(view.lasers[0].fault, Cause::None);
    assert_eq!(bench.switch(), [(zero, true), (20 * MS, false)], "entries of the path that ran light nothing");
    // Nobody refuses the new client its own light, and that path's end does not take it.
    bench.gate(true);
    bench.until(300 * MS);
    assert!(!bench.view().crds[0].runs && bench.view().lasers[0].light);
}

/// The session before had a follow; the new client's own light has its own power, at once.
#[test]
fn a_new_session_ends_what_follows() {
    let mut bench = prepared(250);
    let ratio = servo::laser::Ratio::admit(1f64.to_bits()).unwrap();
    let bounds = servo::laser::PowerBounds::admit_follow(PowerMode::Duty, power(50.0), power(1.0)).unwrap();
    bench.path(0, &[buffered(Buffered::PrfFollow { ratio, bounds }), line([100, 0], 10.0, 1.0, 0.0)]);
    bench.start(1);
    until_rest(&mut bench);
    bench.gate(true);
    bench.tick();
    assert!(!bench.view().lasers[0].light, "it waits for the path that it follows");
    bench.gate(false);
    bench.command(TickCommand::NewSession);
    bench.tick();
    bench.gate(true);
    bench.tick();
    bench.tick();
    let view = bench.view().lasers[0];
    assert_eq!((view.follows, view.light), (None, true));
}

/// They cannot light: so the loss of a link that nobody uses any more is no fault of theirs.
#[test]
fn a_lost_link_is_no_fault_where_the_paths_that_run_are_dead() {
    for command in [TickCommand::Abort, TickCommand::NewSession] {
        let mut bench = prepared(250);
        bench.path(0, &[line([300, 0], 10.0, 1.0, 10.0), light(true), line([2000, 0], 10.0, 1.0, 0.0)]);
        bench.start(1);
        bench.until(20 * MS);
        bench.command(command);
        bench.tick();
        bench.command(TickCommand::Link { lost: true });
        bench.tick();
        let view = bench.view();
        assert_eq!((view.crds[0].runs, view.lasers[0].fault), (true, Cause::None), "{command:?}");
        until_rest(&mut bench);
        // One that is started again may light.
        bench.command(TickCommand::Link { lost: false });
        bench.start(1);
        bench.tick();
        bench.tick();
        bench.command(TickCommand::Link { lost: true });
        bench.tick();
        assert_eq!(bench.view().lasers[0].fault, Cause::LinkLost);
    }
}

#[test]
fn an_on_command_after_an_abort_at_rest_lights() {
    let mut bench = prepared(250);
    bench.gate(true);
    bench.until(2 * MS);
    bench.command(TickCommand::Abort);
    bench.gate(true);
    bench.until(4 * MS);
    // Dark at once; the command acts with the tick after the one in the safe state.
    assert_eq!(bench.switch()[1..], [(2 * MS, false), (2500 * US, true)]);
    assert!(bench.view().lasers[0].light);
}

/// A Stop of a coordinate system at rest shuts off the light of its channels, with the off delay.
/// An axis bit means the system that the axis belongs to; a channel that is not mapped stays as it
/// is.
#[test]
fn a_stop_at_rest_shuts_off() {
    let case = |map: u8, stop: TickCommand| {
        let mut bench = prepared(250);
        bench.change(ChannelChange::CrdMap { map });
        bench.delays(100, 0);
        bench.gate(true);
        bench.until(2 * MS);
        bench.command(stop);
        bench.until(4 * MS);
        bench.switch()[1..].to_vec()
    };
    let off = [(2350 * US, false)];
    assert_eq!(case(0b11, TickCommand::stop_crds(CrdMask(1), CrdMask(0))), off);
    assert_eq!(case(0b11, TickCommand::stop_crds(CrdMask(1), CrdMask(1))), off);
    assert_eq!(case(0b11, TickCommand::stop(AxisMask(2), AxisMask(0))), off);
    assert_eq!(case(0b11, TickCommand::stop(AxisMask(8), AxisMask(0))), [], "an axis of none");
    assert_eq!(case(0b11, TickCommand::stop_crds(CrdMask(2), CrdMask(0))), [], "one that has not been set up");
    assert_eq!(case(0b10, TickCommand::stop_crds(CrdMask(1), CrdMask(0))), [], "one that the channel is not mapped to");
}

#[test]
fn an_entry_for_a_channel_that_is_not_mapped_does_nothing_and_is_an_event() {
    for entry in [light(true), light(false), buffered(Buffered::Direct { power: power(3.0) })] {
        let mut bench = prepared(250);
        bench.path(0, &[line([50, 0], 10.0, 1.0, 10.0), entry, line([300, 0], 10.0, 1.0, 0.0)]);
        bench.change(ChannelChange::CrdMap { map: 0b10 });
        bench.gate(true);
        bench.tick();
        bench.start(1);
        bench.until(20 * MS);
        let view = bench.view().lasers[0];
        assert_eq!((view.light, view.direct), (true, power(100.0)));
        assert_eq!((view.ignored, view.ignored_count), (Ignored::NotMapped, 1));
        assert_eq!(bench.switch().len(), 1);
    }
}

#[test]
fn a_map_that_excludes_the_path_of_a_follow_ends_the_follow() {
    let mut bench = prepared(250);
    let ratio = servo::laser::Ratio::admit(1f64.to_bits()).unwrap();
    let bounds = servo::laser::PowerBounds::admit_follow(PowerMode::Duty, power(50.0), power(1.0)).unwrap();
    bench.path(0, &[buffered(Buffered::PrfFollow { ratio, bounds }), line([100, 0], 10.0, 1.0, 0.0)]);
    bench.start(1);
    until_rest(&mut bench);
    assert!(bench.view().lasers[0].follows.is_some());
    bench.gate(true);
    bench.tick();
    assert!(bench.view().lasers[0].commanded && !bench.view().lasers[0].light, "dark while its path is at rest");
    bench.change(ChannelChange::CrdMap { map: 0b10 });
    bench.tick();
    bench.tick();
    let view = bench.view().lasers[0];
    assert_eq!(
        (view.follows, view.commanded, view.light),
        (None, false, false),
        "and the end of a follow never lights"
    );
}

#[test]
fn an_open_interlock_brakes_motion_as_it_is_set() {
    let run = |interlock: Brake| {
        let mut bench = prepared(250);
        bench.command(TickCommand::Supervision(Supervision { interlock, ..Supervision::DEFAULT }));
        jog(&mut bench);
        // A Trap axis: a lost link leaves it alone.
        let trap = axis(2);
        bench.command(TickCommand::TrapPrm {
            axis: trap,
            acc: accel(1.0),
            dec: accel(1.0),
            vel_start: Speed::default(),
            smooth: servo::units::Ns(0),
        });
        bench.command(TickCommand::TargetSpeed { axis: trap, speed: speed(10.0) });
        bench.command(TickCommand::TargetPosition { axis: trap, pulses: 100_000 });
        bench.command(TickCommand::Update { axes: trap.mask() });
        bench.path(0, &[light(true), line([20_000, 0], 10.0, 1.0, 0.0)]);
        bench.start(1);
        bench.until(31 * MS);
        bench.machine.interlock = true;
        let view = bench.tick();
        assert_eq!((view.fault, view.light), (Cause::Interlock, false));
        assert_eq!(bench.switch().last(), Some(&(31 * MS, false)), "dark in the tick that sees it");
        let now = bench.view();
        let at_once = [now.crds[0].runs, now.axes[3].status & servo::status::RUNNING != 0];
        bench.until(60 * MS);
        let view = bench.view();
        let runs = |index: usize| view.axes[index].status & servo::status::RUNNING != 0;
        (at_once, [view.crds[0].runs, runs(3), runs(2)], view.crds[0].stop)
    };
    assert_eq!(run(Brake::None), ([true; 2], [true, true, true], StopReason::None));
    assert_eq!(run(Brake::JogAndPaths), ([true; 2], [false, false, true], StopReason::Interlock));
    assert_eq!(run(Brake::All), ([true; 2], [false, false, false], StopReason::Interlock));
    assert_eq!(run(Brake::AbruptAll), ([false; 2], [false, false, false], StopReason::Interlock));
}

#[test]
fn a_reset_puts_the_supervision_to_power_on_state() {
    let mut bench = prepared(250);
    bench.command(TickCommand::Supervision(Supervision { link: Brake::All, interlock: Brake::None }));
    bench.command(TickCommand::Reset { axes: AxisMask(4) });
    jog(&mut bench);
    bench.until(20 * MS);
    bench.machine.interlock = true;
    bench.until(40 * MS);
    assert_eq!(bench.view().axes[3].stop, StopReason::Interlock);
}

/// The path runs out at speed some 12 ms after its start: in the tick in which the abort comes,
/// before it and after it.
#[test]
fn an_underrun_does_not_put_off_an_abort() {
    let mut underruns = 0;
    for at in (11_000..13_000).step_by(250) {
        for shift in 0..4 {
            let mut bench = prepared(250);
            bench.standby(Some((5.0, 50.0)));
            bench.path(
                0,
                &[light(true), line([50 + shift, 0], 10.0, 1.0, 10.0), line([70 + shift, 0], 10.0, 1.0, 10.0)],
            );
            let zero = bench.start(1);
            bench.until(zero + at as u64 * US);
            if !bench.view().lasers[0].light {
                continue;
            }
            let now = bench.tick.now().0;
            bench.command(TickCommand::Abort);
            bench.tick();
            assert_eq!(bench.switch().last(), Some(&(now, false)), "{at} {shift}");
            bench.tick();
            bench.tick();
            let view = bench.view();
            assert_eq!((view.lasers[0].light, view.lasers[0].khz), (false, power(0.0)), "{at} {shift}");
            underruns += u32::from(view.lasers[0].fault == Cause::Underrun);
            assert_eq!(bench.switch().len(), 2);
        }
    }
    assert!(underruns >= 1, "none of them came in the tick of the abort");
}

#[test]
fn an_entry_that_is_passed_while_an_abort_brakes_does_not_end_the_quiet() {
    let mut bench = prepared(250);
    bench.standby(Some((5.0, 50.0)));
    let power_of = |value| buffered(Buffered::Direct { power: power(value) });
    let (first, rest) = (line([300, 0], 10.0, 1.0, 10.0), line([2000, 0], 10.0, 1.0, 10.0));
    bench.path(0, &[first, power_of(40.0), rest, power_of(30.0), line([3000, 0], 10.0, 1.0, 0.0)]);
    bench.start(1);
    bench.until(31 * MS);
    bench.command(TickCommand::Abort);
    until_rest(&mut bench);
    bench.tick();
    let view = bench.view().lasers[0];
    assert_eq!((view.direct, view.khz), (power(40.0), power(0.0)), "it set the power, and nothing is output");
    bench.start(1);
    bench.until(400 * MS);
    let view = bench.view().lasers[0];
    assert_eq!(
        (view.direct, view.khz),
        (power(30.0), power(5.0)),
        "an entry of a path that was started again is a command"
    );
}

/// Neither a call nor an entry, whatever ignores it: a fault, or a connector that is not there.
#[test]
fn an_on_command_that_is_ignored_does_not_end_the_quiet() {
    for entry in [false, true] {
        for faulty in [false, true] {
            let mut bench = prepared(250);
            bench.standby(Some((5.0, 50.0)));
            bench.command(TickCommand::Abort);
            bench.tick();
            if faulty {
                bench.machine.interlock = true;
            } else {
                bench.change(ChannelChange::Connector { laser: false });
                bench.command(TickCommand::Abort);
            }
            bench.tick();
            bench.tick();
            if entry {
                bench.path(0, &[light(true), line([1, 0], 10.0, 1.0, 0.0)]);
                bench.start(1);
            } else {
                bench.gate(true);
            }
            bench.until(30 * MS);
            // ClrSts, which names an axis, is no command of the channel.
            bench.machine.interlock = false;
            bench.tick();
            bench.command(TickCommand::ClearStatus { axes: AxisMask(3) });
            bench.until(40 * MS);
            let view = bench.view().lasers[0];
            let ignored = if faulty { Ignored::Fault } else { Ignored::NoOutput };
            assert_eq!((view.fault, view.ignored), (Cause::None, ignored), "{entry}");
            assert_eq!(view.khz, power(0.0), "entry {entry}, fault {faulty}: standby is off");
            bench.change(ChannelChange::Connector { laser: true });
            bench.until(50 * MS);
            assert_eq!(bench.view().lasers[0].khz, power(5.0), "a command of the channel ends it");
        }
    }
}

/// A Stop that brakes up to a BufDelay ends there, and does not wait it out with light on; the
/// start that goes on makes the whole of it.
#[test]
fn a_path_that_brakes_for_a_stop_waits_for_no_delay() {
    for at in (20_000..40_000).step_by(250) {
        let mut bench = prepared(250);
        let first = line([300, 0], 10.0, 1.0, 0.0);
        bench.path(0, &[light(true), first, path::PathEntry::delay(1000), line([600, 0], 10.0, 1.0, 0.0)]);
        let zero = bench.start(1);
        bench.until(zero + at as u64 * US);
        let waits = bench.view().crds[0].motion.velocity().m == 0;
        bench.stop(1, false);
        bench.until(zero + (at as u64 + 20_000) * US);
        assert!(!bench.view().crds[0].runs && !bench.view().lasers[0].light, "{at} {waits}");
        let rest = bench.start(1);
        bench.until(rest + 900 * MS);
        let view = bench.view();
        assert!(
            view.crds[0].runs && view.crds[0].position[0].0 <= 300 << servo::units::Pos::FRAC_BITS,
            "{at}: the delay is made"
        );
    }
}

/// Nor does a clear that its tick refuses, as the cause is still there.
#[test]
fn a_clear_that_is_refused_does_not_end_the_quiet() {
    let mut bench = prepared(250);
    bench.standby(Some((5.0, 50.0)));
    bench.machine.interlock = true;
    bench.command(TickCommand::Abort);
    bench.tick();
    bench.change(ChannelChange::ClearFault);
    bench.until(2 * MS);
    assert_eq!(bench.view().lasers[0].fault, Cause::Interlock);
    bench.machine.interlock = false;
    bench.tick();
    bench.command(TickCommand::ClearStatus { axes: AxisMask(3) });
    bench.until(4 * MS);
    let view = bench.view().lasers[0];
    assert_eq!((view.fault, view.khz), (Cause::None, power(0.0)), "standby is off");
    bench.change(ChannelChange::ClearFault);
    bench.until(6 * MS);
    assert_eq!(bench.view().lasers[0].khz, power(5.0), "one that is carried out ends it");
}

/// Not even in the tick in which the cause appeared.
#[test]
fn a_reset_clears_a_fault_of_its_own_tick() {
    for after in 0..4 {
        let mut bench = prepared(250);
        bench.path(0, &[light(true), line([50, 0], 10.0, 1.0, 10.0)]);
        let zero = bench.start(1);
        // It runs out at speed 10 ms after its start.
        bench.until(zero + (9750 + 250 * after) * US);
        bench.command(TickCommand::Reset { axes: AxisMask(3) });
        bench.change(ChannelChange::Reset { family: Family::Gus });
        bench.change(ChannelChange::ClearFault);
        bench.until(zero + 12 * MS);
        let view = bench.view().lasers[0];
        assert_eq!((view.fault, view.light, view.commanded), (Cause::None, false, false), "{after}");
    }
    // A cause that is still there stays.
    let mut bench = prepared(250);
    bench.machine.interlock = true;
    bench.tick();
    bench.command(TickCommand::Reset { axes: AxisMask(3) });
    bench.tick();
    bench.tick();
    assert_eq!(bench.view().lasers[0].fault, Cause::Interlock);
}
