//! Light and power under entries of paths: every edge to the ns, worked out by hand from SPEC 6.
//!
//! All paths here run along X with 1 pulse/ms²: a speed is reached after as many ms and half its
//! square in pulses.
use crate::laser_bench;
#[path = "laser_path/follow.rs"]
mod follow;
use laser_bench::*;
use servo::laser::{
    Buffered, Cause, ChannelChange, Distance, Family, FilterRate, Power, PowerBounds, PowerMode, Ratio, Ratios,
    SpeedSource,
};
use servo::path::PathEntry;
use servo::tick_command::{DoGroup, TickCommand};
use servo::units::{AxisMask, Crd, CrdMask, Pos};

const PERIODS_US: [u32; 5] = [10, 50, 73, 250, 1000];

/// Two coordinate systems, X and Y of each; a carrier of 10 kHz, 100 %, so that light is one pulse.
fn prepared(period_us: u32) -> Bench {
    let mut bench = Bench::new(period_us);
    bench.change(ChannelChange::Reset { family: Family::Gus });
    bench.command(TickCommand::Output { group: DoGroup::Enable, mask: 0xf, value: 0xf });
    bench.frame(0, &[0, 1]);
    bench.frame(1, &[2, 3]);
    bench.carrier(10.0);
    bench.direct(100.0);
    bench
}

fn lsr(bench: &mut Bench) {
    bench.change(ChannelChange::Reset { family: Family::Lsr });
    bench.carrier(10.0);
    bench.direct(0.0);
}

/// Ticks until ns after a zero, rounded up to a tick.
fn until(bench: &mut Bench, ns: u64) {
    while bench.tick.now().0 < ns {
        bench.tick();
    }
}

/// Edges of the switch in ns after a zero.
fn edges(bench: &mut Bench, zero: u64) -> Vec<(i64, bool)> {
    bench.switch().iter().map(|(at, on)| (*at as i64 - zero as i64, *on)).collect()
}

fn follow(ratio: f64, min: f64, max: f64) -> PathEntry {
    let bounds = PowerBounds::admit_follow(PowerMode::Duty, power(max), power(min)).unwrap();
    buffered(Buffered::PrfFollow { ratio: Ratio::admit(ratio.to_bits()).unwrap(), bounds })
}
fn direct(value: f64) -> PathEntry {
    buffered(Buffered::Direct { power: power(value) })
}
fn number(power: Power) -> f64 {
    power.raw() as f64 / (1u64 << Power::FRAC_BITS) as f64
}

/// 50 pulses to 10 pulse/ms in 10 ms, 50 more in 5 ms: the corner is 15 ms after the start.
fn corner() -> [PathEntry; 2] {
    [line([100, 0], 10.0, 1.0, 10.0), line([400, 0], 10.0, 1.0, 0.0)]
}

#[test]
fn the_gate_moves_at_the_instant_of_its_entry_with_its_delays() {
    for period in PERIODS_US {
        let mut bench = prepared(period);
        bench.delays(123, 77);
        let [first, second] = corner();
        bench.path(0, &[light(true), first, light(false), second]);
        let zero = bench.start(1);
        until(&mut bench, zero + 60 * MS);
        assert_eq!(edges(&mut bench, zero), [(77_000, true), (15_123_000, false)], "{period}");
        assert!(!bench.view().lasers[0].commanded && !bench.view().crds[0].runs);
    }
}

/// 50 % on the first line, 30 % on the second, from the corner on: the pulse in progress is
/// finished.
#[test]
fn direct_power_changes_at_the_corner() {
    for period in PERIODS_US {
        let mut bench = prepared(period);
        bench.delays(0, 30);
        let [first, second] = corner();
        bench.path(0, &[light(true), direct(50.0), first, direct(30.0), second]);
        let zero = bench.start(1);
        until(&mut bench, zero + 20 * MS);
        // Periods of 100 µs begin at 30 µs; the corner is within that of 14 930 µs.
        for (k, pulse) in (0..).zip(bench.pulses().iter().take(190)) {
            let begin = zero + 30 * US + k * 100 * US;
            let width = if begin < zero + 15 * MS { 50 } else { 30 };
            assert_eq!(*pulse, (begin, begin + width * US), "{period}: pulse {k}");
        }
    }
}

/// A Stop shuts light off when the path is at rest, and CrdStart lights it again, both with their
/// delays.
#[test]
fn a_stop_keeps_light_dark_until_the_path_goes_on() {
    for period in PERIODS_US {
        let mut bench = prepared(period);
        let step = u64::from(period) * US;
        bench.delays(123, 77);
        bench.path(0, &[light(true), line([1000, 0], 10.0, 1.0, 0.0)]);
        let zero = bench.start(1);
        until(&mut bench, zero + 20 * MS);
        bench.stop(1, false);
        let stopped = bench.tick.now().0 + step;
        until(&mut bench, zero + 50 * MS);
        // It brakes from 10 pulse/ms with 1 pulse/ms² from the tick on.
        let rest = (stopped - zero + 10 * MS) as i64;
        assert_eq!(edges(&mut bench, zero), [(77_000, true), (rest + 123_000, false)], "{period}");
        assert!(!bench.view().lasers[0].commanded);
        let again = (bench.start(1) - zero) as i64;
        until(&mut bench, zero + 250 * MS);
        let edges = edges(&mut bench, zero);
        assert_eq!(edges[2], (again + 77_000, true), "{period}");
        assert_eq!((edges.len(), edges[3].1, bench.view().crds[0].runs), (4, false, false));
    }
}

/// An abrupt Stop sets the path back into a mark whose end has been passed in that tick. Lit by a
/// call, or by the start that continues, the mark ends at the same position as before.
#[test]
fn the_end_of_a_mark_comes_again_after_an_abrupt_stop_before_it() {
    let mut within = 0;
    for (period, call) in [(250, true), (1000, true), (250, false), (1000, false)] {
        for after in (12 * MS..19 * MS).step_by(period as usize * 1000) {
            let mut bench = prepared(period);
            // 102 pulses: 50 in 10 ms, and 52 in 5.2.
            let lines = [line([102, 0], 10.0, 1.0, 10.0), line([400, 0], 10.0, 1.0, 0.0)];
            bench.path(0, &[light(true), lines[0], light(false), lines[1]]);
            let zero = bench.start(1);
            until(&mut bench, zero + after);
            bench.stop(1, true);
            bench.tick();
            let x = |bench: &mut Bench| bench.view().crds[0].position[0].0 >> Pos::FRAC_BITS;
            let inside = x(&mut bench) < 102;
            assert!(!bench.view().lasers[0].light, "{period} {after}");
            if call {
                bench.gate(true);
                bench.tick();
            }
            bench.start(1);
            while x(&mut bench) < 102 {
                bench.tick();
            }
            bench.tick();
            within += u32::from(inside);
            // After the mark only a call lights.
            assert_eq!(bench.view().lasers[0].light, call && !inside, "{period} {after}");
        }
    }
    assert!(within > 20, "{within}");
}

/// What a Stop shuts off, and what brings it back.
#[test]
fn light_of_its_owner_goes_off_and_comes_back() {
    // Stopped within its path, with light of an entry; the action meanwhile; whether light is on
    // after a CrdStart.
    let case = |before: &dyn Fn(&mut Bench), meanwhile: &dyn Fn(&mut Bench)| {
        let mut bench = prepared(250);
        bench.path(0, &[light(true), line([1000, 0], 10.0, 1.0, 0.0)]);
        bench.start(1);
        bench.until(20 * MS);
        before(&mut bench);
        bench.tick();
        bench.stop(1, false);
        bench.until(40 * MS);
        let dark = bench.view().lasers[0].light;
        meanwhile(&mut bench);
        bench.tick();
        bench.start(1);
        bench.until(50 * MS);
        assert!(bench.view().crds[0].runs);
        (dark, bench.view().lasers[0].light)
    };
    let nothing = |_: &mut Bench| {};
    assert_eq!(case(&nothing, &nothing), (false, true));
    // An immediate on command changes nothing while the light of a path is on.
    assert_eq!(case(&|bench| bench.gate(true), &nothing), (false, true));
    // Off is off.
    assert_eq!(case(&nothing, &|bench| bench.gate(false)), (false, false));
    // CrdClear ends what might continue.
    let anew = |bench: &mut Bench| {
        bench.clear_path(0);
        bench.tick();
        bench.path(0, &[line([2000, 0], 10.0, 1.0, 0.0)]);
    };
    assert_eq!(case(&nothing, &anew), (false, false));
    // A map that takes the channel away from its path takes the light.
    assert_eq!(case(&|bench| bench.change(ChannelChange::CrdMap { map: 0b10 }), &nothing), (false, false));
    // Another mode withdraws the command.
    let mode = |bench: &mut Bench| bench.mode(PowerMode::Frequency, 100.0, 0.0, true);
    assert_eq!(case(&nothing, &mode), (false, false));
    // Ending a follow that does not exist changes nothing.
    let ending = |bench: &mut Bench| {
        bench.command(TickCommand::FollowEnd { crds: CrdMask(1) });
        bench.tick();
        assert!(!bench.view().lasers[0].light);
    };
    assert_eq!(case(&nothing, &ending), (false, true));
    // Ending a follow at rest lights nothing; the light that the Stop shut off comes back with the
    // start that goes on.
    let mut bench = prepared(250);
    bench.path(0, &[follow(1.0, 1.0, 50.0), light(true), line([1000, 0], 10.0, 1.0, 0.0)]);
    bench.start(1);
    bench.until(20 * MS);
    bench.stop(1, false);
    bench.until(40 * MS);
    ending(&mut bench);
    bench.start(1);
    bench.until(50 * MS);
    assert!(bench.view().crds[0].runs && bench.view().lasers[0].light);
    // A fault while it rests: it stays off.
    let fault = |bench: &mut Bench| {
        bench.machine.interlock = true;
        bench.tick();
        bench.machine.interlock = false;
        bench.tick();
        bench.change(ChannelChange::ClearFault);
    };
    assert_eq!(case(&nothing, &fault), (false, false));
}

/// Operations of one instant act in their order, also those of a path and of a channel.
#[test]
fn a_start_and_an_off_command_of_one_instant_keep_their_order() {
    let stopped = || {
        let mut bench = prepared(250);
        bench.path(0, &[light(true), line([1000, 0], 10.0, 1.0, 0.0)]);
        bench.start(1);
        bench.until(20 * MS);
        bench.stop(1, true);
        bench.until(40 * MS);
        bench
    };
    let mut bench = stopped();
    bench.start(1);
    bench.gate(false);
    bench.until(50 * MS);
    assert!(!bench.view().lasers[0].light);
    let mut bench = stopped();
    bench.gate(true);
    bench.start(1);
    bench.until(50 * MS);
    assert!(bench.view().lasers[0].light);
    // A Stop, then an on command: off there, and on after its delay.
    let mut bench = prepared(250);
    bench.path(0, &[light(true), line([1000, 0], 10.0, 1.0, 0.0)]);
    let zero = bench.start(1);
    bench.until(20 * MS);
    bench.delays(0, 77);
    bench.stop(1, true);
    bench.gate(true);
    bench.until(30 * MS);
    let at = (20 * MS + 250 * US - zero) as i64;
    assert_eq!(edges(&mut bench, zero), [(0, true), (at, false), (at + 77_000, true)]);
}

/// 10 pulse/ms after 10 ms; 18 pulses are too short to brake from there: 8 pulse/ms after 12 ms.
fn underrun(first: PathEntry) -> [PathEntry; 3] {
    [first, line([50, 0], 10.0, 1.0, 10.0), line([68, 0], 10.0, 1.0, 0.0)]
}

/// More starts and stops at one instant than a list holds are carried out in their order.
#[test]
fn any_number_of_starts_and_stops_at_one_instant() {
    let mut bench = prepared(250);
    bench.path(0, &[light(true), line([1000, 0], 10.0, 1.0, 0.0)]);
    let zero = bench.start(1);
    until(&mut bench, zero + 20 * MS);
    // 64 entries a tick.
    for _ in 0..31 {
        bench.stop(1, true);
        bench.start(1);
    }
    bench.until_ms(30);
    let published = bench.view().lasers[0];
    assert_eq!((published.fault, published.light, bench.view().crds[0].runs), (Cause::None, true, true));
}

/// Out of entries at speed: dark there, to the ns, in every output; it stays so until it is
/// cleared.
#[test]
fn an_underrun_is_dark_at_its_instant() {
    for period in PERIODS_US {
        let mut bench = prepared(period);
        bench.delays(5000, 0);
        bench.standby(Some((20.0, 50.0)));
        bench.path(0, &underrun(light(true)));
        let zero = bench.start(1);
        until(&mut bench, zero + 40 * MS);
        assert_eq!(edges(&mut bench, zero), [(0, true), (12_000_000, false)], "{period}");
        assert_eq!(bench.pulses().last(), Some(&(zero, zero + 12_000_000)), "{period}");
        let published = bench.view().lasers[0];
        assert_eq!((published.fault, published.on_time), (Cause::Underrun, 48), "{period}");
        assert_eq!(bench.view().lasers[1].fault, Cause::Underrun);
        bench.gate(true);
        bench.until_ms(60);
        assert!(!bench.view().lasers[0].light);
        bench.change(ChannelChange::ClearFault);
        bench.tick();
        bench.gate(true);
        bench.tick();
        assert!(bench.view().lasers[0].light);
    }
}

/// After an underrun nothing more is planned, in any mode: no standby, no pre-voltage, no open
/// switch.
#[test]
fn nothing_is_planned_after_an_underrun() {
    for (mode, period) in
        [PowerMode::Duty, PowerMode::Frequency, PowerMode::Analog, PowerMode::DutyOpen].into_iter().zip(PERIODS_US)
    {
        let mut bench = prepared(period);
        bench.mode(mode, 10.0, 0.0, true);
        bench.width(5);
        bench.standby(Some((20.0, 50.0)));
        bench.change(ChannelChange::PreVoltage(Some(power(2.0))));
        bench.path(0, &[direct(5.0), light(true)]);
        bench.path(0, &underrun(follow(1.0, 1.0, 9.0)));
        let zero = bench.start(1);
        until(&mut bench, zero + 40 * MS);
        let last = bench.machine.outputs[0].last;
        let end = zero + 12 * MS;
        assert!(last <= end && end < last + u64::from(period) * US, "{mode:?}: {last} {end}");
        // The plan brings all outputs to the safe state there.
        assert!(bench.switch().last().is_none_or(|edge| *edge == (end, false)), "{mode:?}");
        assert!(bench.pulses().last().is_none_or(|pulse| pulse.1 <= end), "{mode:?}");
        assert!(bench.volts().last().is_none_or(|volts| *volts == (end, 0)), "{mode:?}");
    }
}

/// In analog mode an underrun takes the DAC to 0 V there, pre-voltage or not.
#[test]
fn an_underrun_takes_the_dac_to_0() {
    let mut bench = prepared(250);
    bench.mode(PowerMode::Analog, 10.0, 0.0, true);
    bench.change(ChannelChange::PreVoltage(Some(power(2.0))));
    bench.path(0, &underrun(direct(5.0)));
    bench.gate(true);
    let zero = bench.start(1);
    bench.until_ms(40);
    let volts = bench.volts();
    let [.., on, off] = volts[..] else { panic!("{volts:?}") };
    assert_eq!([on, off], [(zero, 16384), (zero + 12_000_000, 0)]);
}

/// A fault of an axis shuts off the channels that are mapped to its coordinate system, in the tick
/// that samples it. ClrSts of such an axis clears, once the cause is gone.
#[test]
fn a_fault_of_an_axis_shuts_off_what_its_coordinate_system_gates() {
    let lit = |map| {
        let mut bench = prepared(250);
        bench.change(ChannelChange::CrdMap { map });
        bench.command(TickCommand::Laser { channel: 1, change: ChannelChange::CrdMap { map: 0b10 } });
        bench.gate(true);
        bench.command(TickCommand::Laser { channel: 1, change: ChannelChange::Gate { on: true } });
        bench.until(5 * MS);
        bench
    };
    let faults = |bench: &mut Bench| bench.view().lasers.map(|published| published.fault);
    // An alarm.
    let mut bench = lit(0b01);
    bench.machine.inputs[1].alarm = true;
    bench.tick();
    assert_eq!(faults(&mut bench), [Cause::Alarm, Cause::None]);
    let clear = |bench: &mut Bench, index: usize| {
        bench.command(TickCommand::ClearStatus { axes: AxisMask(1 << index) });
        bench.tick();
        bench.tick();
    };
    bench.tick();
    clear(&mut bench, 1);
    assert_eq!(faults(&mut bench), [Cause::Alarm, Cause::None]);
    bench.machine.inputs[1].alarm = false;
    bench.tick();
    clear(&mut bench, 2);
    assert_eq!(faults(&mut bench), [Cause::Alarm, Cause::None]);
    clear(&mut bench, 0);
    assert_eq!(faults(&mut bench), [Cause::None; 2]);
    assert!(!bench.view().lasers[0].light && bench.view().lasers[1].light);
    // One that was there before the map named its coordinate system.
    let mut bench = lit(0b01);
    bench.command(TickCommand::Laser { channel: 0, change: ChannelChange::CrdMap { map: 0b10 } });
    bench.tick();
    bench.machine.inputs[1].alarm = true;
    bench.tick();
    assert_eq!(faults(&mut bench), [Cause::None; 2]);
    bench.command(TickCommand::Laser { channel: 0, change: ChannelChange::CrdMap { map: 0b11 } });
    bench.tick();
    assert_eq!(faults(&mut bench), [Cause::Alarm, Cause::None]);
    assert!(!bench.view().lasers[0].light);
    // A limit.
    let mut bench = lit(0b11);
    bench.machine.inputs[3].limit_negative = true;
    bench.tick();
    assert_eq!(faults(&mut bench), [Cause::Limit; 2]);
    bench.tick();
    clear(&mut bench, 3);
    assert_eq!(faults(&mut bench), [Cause::None; 2]);
    // Servo off.
    let mut bench = lit(0b01);
    bench.command(TickCommand::Servo { axis: axis(1), on: false });
    bench.tick();
    assert_eq!(faults(&mut bench), [Cause::ServoOff, Cause::None]);
}

/// A lost link stops paths in the dark; with the fault cleared their light comes back as they go
/// on.
#[test]
fn light_comes_back_after_a_lost_link() {
    let lost = |entries: &[PathEntry]| {
        let mut bench = prepared(250);
        bench.path(0, entries);
        let zero = bench.start(1);
        until(&mut bench, zero + 20 * MS);
        let at = bench.tick.now().0;
        bench.command(TickCommand::Link { lost: true });
        until(&mut bench, zero + 50 * MS);
        assert_eq!(bench.switch(), [(zero, true), (at, false)]);
        assert_eq!((bench.view().lasers[0].fault, bench.view().crds[0].runs), (Cause::LinkLost, false));
        bench.command(TickCommand::Link { lost: false });
        bench.tick();
        bench.change(ChannelChange::ClearFault);
        bench.until_ms(80);
        assert!(!bench.view().lasers[0].light);
        bench.start(1);
        bench.until_ms(90);
        assert!(bench.view().crds[0].runs);
        bench.view().lasers[0].light
    };
    assert!(lost(&[light(true), line([1000, 0], 10.0, 1.0, 0.0)]));
    let far = line([1000, 0], 10.0, 1.0, 0.0);
    // So does another follow, which begins during the motion: the light is not kept by standstill.
    assert!(lost(&[follow(1.0, 1.0, 50.0), light(true), line([170, 0], 10.0, 1.0, 10.0), follow(2.0, 1.0, 50.0), far]));
    // Not if the path goes on before the fault is cleared.
    let mut bench = prepared(250);
    bench.path(0, &[light(true), line([1000, 0], 10.0, 1.0, 0.0)]);
    bench.start(1);
    bench.until_ms(20);
    bench.command(TickCommand::Link { lost: true });
    bench.until_ms(50);
    bench.command(TickCommand::Link { lost: false });
    bench.start(1);
    bench.tick();
    bench.change(ChannelChange::ClearFault);
    bench.until_ms(60);
    assert!(bench.view().crds[0].runs && !bench.view().lasers[0].light);
    // Nor after another Stop.
    bench.stop(1, true);
    bench.until_ms(70);
    bench.start(1);
    bench.until_ms(80);
    assert!(bench.view().crds[0].runs && !bench.view().lasers[0].light);
    // Braking in the dark, it passes an off entry, which counts, and an on entry, which is not
    // remembered.
    assert!(!lost(&[light(true), line([170, 0], 10.0, 1.0, 10.0), light(false), far]));
    assert!(!lost(&[light(true), line([170, 0], 10.0, 1.0, 10.0), light(false), light(true), far]));
}

/// A path that brakes for a lost link or an interlock lights nothing after an immediate off, also
/// where the fault is cleared before it has come to standstill.
#[test]
fn an_off_holds_while_a_path_brakes_for_a_fault() {
    for (interlock, off) in [(false, false), (false, true), (true, false), (true, true)] {
        let mut bench = prepared(250);
        bench.path(0, &[line([170, 0], 10.0, 1.0, 10.0), light(true), line([1000, 0], 10.0, 1.0, 0.0)]);
        let zero = bench.start(1);
        until(&mut bench, zero + 20 * MS);
        for lost in [true, false] {
            if interlock {
                bench.machine.interlock = lost;
            } else {
                bench.command(TickCommand::Link { lost });
            }
            bench.tick();
        }
        if off {
            bench.gate(false);
        }
        bench.change(ChannelChange::ClearFault);
        until(&mut bench, zero + 24 * MS);
        assert_eq!((bench.view().lasers[0].fault, bench.view().crds[0].runs), (Cause::None, true));
        assert_eq!(bench.view().lasers[0].light, !off, "interlock {interlock}");
        bench.until_ms(60);
        assert!(!bench.view().crds[0].runs && !bench.view().lasers[0].light);
        assert_eq!(bench.switch().is_empty(), off);
    }
}

/// A start that goes on, and the loss of the link after it in the same tick: the light waits for
/// the next start.
#[test]
fn a_start_in_the_tick_that_loses_the_link_keeps_its_light_for_the_next() {
    let mut bench = prepared(250);
    bench.path(0, &[light(true), line([1000, 0], 10.0, 1.0, 0.0)]);
    bench.start(1);
    bench.until_ms(20);
    bench.stop(1, false);
    bench.until_ms(50);
    assert!(!bench.view().crds[0].runs && !bench.view().lasers[0].light);
    bench.command(TickCommand::CrdStart { crds: CrdMask(1), fifo1: CrdMask(0) });
    bench.command(TickCommand::Link { lost: true });
    bench.until_ms(80);
    assert_eq!((bench.view().lasers[0].fault, bench.view().crds[0].runs), (Cause::LinkLost, false));
    bench.command(TickCommand::Link { lost: false });
    bench.tick();
    bench.change(ChannelChange::ClearFault);
    bench.until_ms(90);
    assert!(!bench.view().lasers[0].light, "not by clearing");
    bench.start(1);
    bench.until_ms(100);
    assert!(bench.view().crds[0].runs && bench.view().lasers[0].light);
}

/// Two paths change one channel within one interval: in the order of time.
#[test]
fn changes_of_two_paths_come_in_the_order_of_time() {
    let mut bench = prepared(1000);
    // Boundaries 15.5 ms after the start and 15.9 ms; 15.7 ms.
    let long = |from: i32| line([from + 300, 0], 10.0, 1.0, 0.0);
    let at = |x: i32| line([x, 0], 10.0, 1.0, 10.0);
    bench.path(1, &[at(105), light(true), at(109), light(true), long(109)]);
    bench.path(0, &[at(107), light(false), long(107)]);
    let zero = bench.start(0b11);
    bench.until_ms(40);
    assert_eq!(edges(&mut bench, zero), [(15_500_000, true), (15_700_000, false), (15_900_000, true)]);
}
