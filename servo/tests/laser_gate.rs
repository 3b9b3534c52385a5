//! Gate, delays, first-pulse killer, modes and safety of a channel: every edge to the ns, worked
//! out by hand from SPEC 6.
use crate::laser_bench;
use laser_bench::*;
use servo::laser::{Cause, ChannelChange, Family, Ignored, PowerMode};
use servo::tick_command::TickCommand;

/// A channel whose light is one unbroken pulse: 100 % of a carrier.
fn plain(period_us: u32) -> Bench {
    let mut bench = Bench::new(period_us);
    bench.carrier(1.0);
    bench.direct(100.0);
    bench
}

/// Gives gate commands at instants (µs, a tick before each) and returns the switch's edges in µs.
fn edges(period_us: u32, delays: (u16, u16), commands: &[(u64, bool)]) -> Vec<(u64, bool)> {
    let mut bench = plain(period_us);
    bench.delays(delays.0, delays.1);
    for (at, on) in commands {
        // A command given in the tick before `at` takes effect at `at`.
        let before = (at - period_us as u64) * US;
        if bench.tick.now().0 < before {
            bench.until(before);
        }
        bench.gate(*on);
    }
    bench.until(400 * MS);
    let switch = bench.switch();
    // With 100 % of the carrier, and no pulse to finish beyond 100 µs, light is where the switch is
    // on.
    switch.iter().map(|(at, level)| (at / US, *level)).collect()
}

#[test]
fn commands_reach_the_output_after_their_delays() {
    for period in [10, 50, 250, 1000] {
        assert_eq!(edges(period, (0, 0), &[(2000, true), (5000, false)]), [(2000, true), (5000, false)]);
        assert_eq!(edges(period, (300, 123), &[(2000, true), (5000, false)]), [(2123, true), (5300, false)]);
        let longest = [(67_535, true), (70_535, false)];
        assert_eq!(edges(period, (65_535, 65_535), &[(2000, true), (5000, false)]), longest);
    }
}

#[test]
fn a_later_command_cancels_what_would_take_effect_at_or_after_it() {
    for period in [10, 1000] {
        // A mark shorter than onDelay - offDelay makes no light and leaves nothing on.
        assert_eq!(edges(period, (100, 3100), &[(2000, true), (4000, false)]), []);
        // One exactly as long neither: the off edge falls on the on edge.
        assert_eq!(edges(period, (100, 3100), &[(2000, true), (5000, false)]), []);
        // A longer one keeps the remainder.
        assert_eq!(edges(period, (100, 3100), &[(2000, true), (6000, false)]), [(5100, true), (6100, false)]);
        // A mark of length 0 with the longer offDelay makes the difference of light.
        assert_eq!(edges(period, (3100, 100), &[(2000, true), (2000, false)]), [(2100, true), (5100, false)]);
        // Off and on at one instant: the off edge is cancelled, the light goes on without a gap.
        let bridged = [(2000, true), (4000, false), (4000, true), (8000, false)];
        assert_eq!(edges(period, (0, 0), &bridged), [(2000, true), (8000, false)]);
        // On cancels an off edge that is still to come.
        let again = [(2000, true), (3000, false), (4000, true), (20_000, false)];
        assert_eq!(edges(period, (5000, 500), &again), [(2500, true), (25_000, false)]);
        // On twice and off twice are one edge each.
        let twice = [(2000, true), (3000, true), (4000, false), (5000, false)];
        assert_eq!(edges(period, (0, 0), &twice), [(2000, true), (4000, false)]);
    }
}

#[test]
fn an_on_while_on_cancels_too() {
    // The second on takes effect at 7000, at or before the pending off at 8000: the mark goes on.
    let commands = [(2000, true), (3000, false), (4000, true)];
    assert_eq!(edges(1000, (5000, 3000), &commands), [(5000, true)]);
}

#[test]
fn the_delays_in_force_when_a_command_is_given_count() {
    let mut bench = plain(1000);
    bench.delays(100, 4000);
    bench.until(MS);
    bench.gate(true);
    bench.tick();
    bench.delays(700, 1);
    bench.until(9 * MS);
    bench.gate(false);
    bench.until(20 * MS);
    assert_eq!(bench.switch(), [(6 * MS, true), (10 * MS + 700 * US, false)]);
}

#[test]
fn delays_count_only_where_the_mode_says_so() {
    let mut bench = plain(1000);
    bench.delays(300, 400);
    bench.mode(PowerMode::Duty, 100.0, 0.0, false);
    bench.gate(true);
    bench.until(5 * MS);
    bench.gate(false);
    bench.until(9 * MS);
    assert_eq!(bench.switch(), [(MS, true), (6 * MS, false)]);
}

#[test]
fn pulses_begin_with_the_gate_and_the_last_is_finished_or_cut() {
    // 10 kHz, 25 %: pulses of 25 µs every 100 µs, from the gate's edge on.
    let light = |mode, off_us: u16, khz: f64, duty: f64| {
        let mut bench = Bench::new(1000);
        bench.mode(mode, 100.0, 0.0, true);
        bench.carrier(khz);
        bench.direct(duty);
        bench.delays(off_us, 0);
        bench.gate(true);
        bench.gate(false);
        bench.until(20 * MS);
        let pulses: Vec<(u64, u64)> = bench.pulses().iter().map(|(a, b)| (a - MS, b - MS)).collect();
        pulses
    };
    assert_eq!(light(PowerMode::Duty, 110, 10.0, 25.0), [(0, 25_000), (100_000, 125_000)]);
    assert_eq!(light(PowerMode::Duty, 150, 10.0, 25.0), [(0, 25_000), (100_000, 125_000)]);
    // A pulse that would begin at the edge does not begin.
    assert_eq!(light(PowerMode::Duty, 100, 10.0, 25.0), [(0, 25_000)]);
    // It would end 101 µs after the edge: cut. 100 µs: finished.
    assert_eq!(light(PowerMode::Duty, 99, 1.0, 20.0), [(0, 99_000)]);
    assert_eq!(light(PowerMode::Duty, 100, 1.0, 20.0), [(0, 200_000)]);
    // With the open switch it is always cut.
    assert_eq!(light(PowerMode::DutyOpen, 110, 10.0, 25.0), [(0, 25_000), (100_000, 110_000)]);
}

#[test]
fn the_first_pulse_killer_shifts_the_light_and_takes_the_switch() {
    let mut bench = plain(1000);
    bench.fpk(Some((300, 120, 450)));
    bench.gate(true);
    bench.until(5 * MS);
    bench.gate(false);
    let view = bench.until(6 * MS);
    assert!(!view.gate && view.light && !view.switch, "{view:?}");
    bench.until(20 * MS);
    assert_eq!(bench.switch(), [(MS, true), (MS + 300 * US, false)]);
    // The last period of the unbroken level ends 670 µs after the light: it is cut.
    assert_eq!(bench.pulses(), [(MS + 120 * US, 6 * MS + 450 * US)]);
    assert_eq!(bench.tick().on_time, (5000 - 120 + 450) / 250);
}

#[test]
fn a_gate_on_during_a_first_pulse_begins_a_new_one() {
    let mut bench = plain(1000);
    bench.fpk(Some((2500, 2200, 100)));
    for at in [1, 2, 3, 9] {
        bench.gate(at != 2);
        bench.until(at * MS);
    }
    bench.gate(false);
    bench.until(30 * MS);
    // Pulses 1 … 3.5 and 3 … 5.5 are one. The first mark is shorter than its shift: no light.
    assert_eq!(bench.switch(), [(MS, true), (5500 * US, false)]);
    // The light ends at 10.1 ms, and with it the level of full duty, whose last period would end
    // 100 µs later.
    assert_eq!(bench.pulses(), [(5200 * US, 10_100 * US)]);
}

#[test]
fn an_edge_that_is_cancelled_begins_no_first_pulse() {
    let mut bench = plain(1000);
    bench.fpk(Some((500, 0, 400)));
    // On and off at one instant: their edges would be one, and there is none.
    bench.delays(0, 2000);
    bench.gate(true);
    bench.until(2 * MS);
    bench.gate(false);
    bench.until(9 * MS);
    assert_eq!((bench.switch(), bench.pulses()), (vec![], vec![]));
    // Off and on at one instant while on: no new pulse.
    bench.delays(0, 0);
    bench.gate(true);
    bench.until(20 * MS);
    bench.gate(false);
    bench.gate(true);
    bench.until(30 * MS);
    assert_eq!(bench.switch(), [(10 * MS, true), (10_500 * US, false)]);
}

#[test]
fn a_first_pulse_that_was_switched_off_does_not_come_back() {
    let mut bench = plain(1000);
    bench.fpk(Some((9000, 0, 0)));
    bench.gate(true);
    bench.until(3 * MS);
    bench.fpk(None);
    bench.until(5 * MS);
    bench.fpk(Some((9000, 0, 0)));
    bench.until(20 * MS);
    // The pulse, then the gate's own level, then nothing.
    assert_eq!(bench.switch(), [(MS, true), (6 * MS, false)]);
}

#[test]
fn changes_of_the_first_pulse_killer_while_on_touch_the_switch_only() {
    let mut bench = plain(1000);
    bench.gate(true);
    bench.until(3 * MS);
    bench.fpk(Some((500, 200, 300)));
    bench.until(6 * MS);
    bench.fpk(None);
    bench.until(8 * MS);
    bench.fpk(Some((500, 200, 300)));
    bench.until(9 * MS);
    bench.gate(false);
    bench.until(20 * MS);
    assert_eq!(bench.switch(), [(MS, true), (4 * MS, false), (7 * MS, true), (9 * MS, false)]);
    // Light began without it and ends without it.
    assert_eq!(bench.pulses(), [(MS, 10 * MS)]);
}

#[test]
fn the_manuals_hazard_cannot_happen() {
    // LSR 2, LaserPowerMode: with delays and follow both on, light goes on after the off command.
    // Whatever the power does, the gate decides.
    let mut bench = plain(50);
    bench.delays(200, 100);
    bench.gate(true);
    bench.until(2 * MS);
    bench.gate(false);
    for k in 0..200 {
        bench.direct(f64::from(k % 100) + 0.5);
        bench.tick();
    }
    let end = 2 * MS + 50 * US + 200 * US;
    assert_eq!(bench.switch(), [(150 * US, true), (end, false)]);
    let last = bench.pulses().last().copied().unwrap();
    assert!(last.1 <= end + 100 * US, "{last:?}");
}

#[test]
fn another_mode_ends_the_light_at_once() {
    let mut bench = plain(1000);
    bench.delays(700, 0);
    bench.standby(Some((5.0, 10.0)));
    bench.gate(true);
    bench.until(4 * MS);
    bench.mode(PowerMode::Frequency, 2000.0, 0.0, true);
    let view = bench.tick();
    assert!(!view.commanded && !view.gate && !view.light && !view.switch, "{view:?}");
    assert_eq!((view.direct, view.power, view.khz), (power(0.0), power(5.0), power(5.0)));
    bench.until(6 * MS);
    assert_eq!(bench.switch(), [(MS, true), (5 * MS, false)]);
    let pulses = bench.pulses();
    // Standby before the light from the first tick on is cut by it; after it, it begins where it
    // ends.
    assert_eq!(
        pulses,
        [
            (MS, 5 * MS + 20 * US),
            (5200 * US, 5220 * US),
            (5400 * US, 5420 * US),
            (5600 * US, 5620 * US),
            (5800 * US, 5820 * US)
        ]
    );
    // The same mode again changes the bounds only.
    bench.width(10);
    bench.direct(30.0);
    bench.gate(true);
    bench.until(8 * MS);
    bench.mode(PowerMode::Frequency, 20.0, 10.0, true);
    let view = bench.tick();
    assert!(view.commanded && view.light, "{view:?}");
    assert_eq!((view.direct, view.power, view.khz), (power(30.0), power(20.0), power(20.0)));
    bench.direct(5.0);
    assert_eq!(bench.tick().power, power(10.0));
}

#[test]
fn another_mode_and_a_reset_cut_the_pulse() {
    for reset in [false, true] {
        // Pulses of 250 µs every 770 µs: the one that begins at 1000 + 2310 µs would end 60 µs
        // after the light.
        let mut bench = Bench::new(250);
        bench.carrier(1000.0 / 770.0);
        bench.direct(100.0 * 250.0 / 770.0);
        bench.until(750 * US);
        bench.gate(true);
        bench.until(3250 * US);
        if reset {
            bench.change(ChannelChange::Reset { family: Family::Gus });
        } else {
            bench.mode(PowerMode::Frequency, 2000.0, 0.0, true);
        }
        bench.until(9 * MS);
        assert_eq!(bench.pulses().last(), Some(&(3310 * US, 3500 * US)));
        assert_eq!(bench.switch(), [(MS, true), (3500 * US, false)]);
    }
}

#[test]
fn the_open_switch_lets_no_standby_out() {
    let mut bench = plain(1000);
    // 190 of 380 µs from 1 ms on: the sixth pulse is in progress at 3 ms.
    bench.standby(Some((1000.0 / 380.0, 50.0)));
    bench.until(2 * MS);
    bench.mode(PowerMode::DutyOpen, 100.0, 0.0, true);
    bench.until(5 * MS);
    let pulses = bench.pulses();
    assert_eq!((pulses.len(), pulses.last()), (6, Some(&(2900 * US, 3 * MS))), "it is cut");
    assert_eq!(bench.switch(), [(3 * MS, true)]);
    bench.mode(PowerMode::Duty, 100.0, 0.0, true);
    bench.until(7 * MS);
    assert_eq!(bench.switch(), [(3 * MS, true), (6 * MS, false)]);
    assert_eq!(bench.pulses()[6].0, 6 * MS);
}

#[test]
fn voltage_is_the_power_in_light_and_the_pre_voltage_out_of_it() {
    let mut bench = Bench::new(250);
    bench.mode(PowerMode::Analog, 10.0, 0.0, true);
    bench.change(ChannelChange::PreVoltage(Some(power(1.0))));
    bench.direct(2.5);
    bench.delays(33, 77);
    bench.gate(true);
    bench.gate(true);
    bench.until(MS);
    bench.direct(10.0);
    bench.until(2 * MS);
    bench.gate(false);
    let view = bench.until(3 * MS);
    assert_eq!((view.power, view.khz), (power(1.0), power(0.0)));
    bench.mode(PowerMode::Duty, 100.0, 0.0, true);
    bench.until(4 * MS);
    let expected = [(250, 3277), (327, 8192), (1250, 32767), (2283, 3277), (3250, 0)];
    assert_eq!(bench.volts(), expected.map(|(us, volts)| (us * US, volts)));
    assert_eq!(bench.switch(), [(327 * US, true), (2283 * US, false)]);
    assert_eq!(bench.pulses(), []);
}

#[test]
fn the_interlock_rests_everything_at_once_until_it_is_cleared() {
    let mut bench = plain(1000);
    bench.standby(Some((5.0, 10.0)));
    bench.delays(0, 100);
    bench.gate(true);
    bench.until(3 * MS);
    bench.machine.interlock = true;
    let view = bench.tick();
    // Sampled in the tick at 3 ms, and in the safe state there.
    assert_eq!(bench.switch(), [(1100 * US, true), (3 * MS, false)]);
    assert_eq!(view.fault, Cause::Interlock);
    assert!(view.cause_lasts && !view.commanded && !view.light && !view.switch, "{view:?}");
    // Light up to 3 ms only.
    assert_eq!(view.on_time, 1900 / 250);
    bench.change(ChannelChange::ClearFault);
    bench.gate(true);
    assert_eq!(bench.tick().fault, Cause::Interlock);
    bench.machine.interlock = false;
    assert_eq!(bench.tick().fault, Cause::Interlock, "it is latched");
    bench.forget();
    // A command before the fault is cleared is not remembered.
    bench.gate(true);
    bench.change(ChannelChange::ClearFault);
    let view = bench.until(10 * MS);
    assert_eq!((view.fault, view.commanded, view.cause_lasts), (Cause::None, false, false));
    // Standby comes back, light does not.
    assert_eq!(bench.switch().len(), 1);
    assert_eq!(bench.pulses().first(), Some(&(7 * MS, 7 * MS + 20 * US)));
    bench.gate(true);
    assert!(bench.until(12 * MS).light);
}

#[test]
fn the_link_shuts_off_light_and_nothing_else() {
    let mut bench = plain(1000);
    bench.command(TickCommand::Link { lost: true });
    assert_eq!(bench.tick().fault, Cause::None);
    bench.command(TickCommand::Link { lost: false });
    bench.delays(0, 5000);
    bench.gate(true);
    bench.tick();
    // The edge is still to come.
    bench.command(TickCommand::Link { lost: true });
    bench.command(TickCommand::Laser { channel: 1, change: ChannelChange::ClearFault });
    let view = bench.until(20 * MS);
    assert_eq!((view.fault, view.cause_lasts, view.commanded), (Cause::LinkLost, true, false));
    assert_eq!(bench.switch(), []);
    bench.command(TickCommand::Link { lost: false });
    bench.change(ChannelChange::ClearFault);
    assert_eq!(bench.tick().fault, Cause::None);
}

#[test]
fn an_overrun_shuts_off_both_channels() {
    let mut bench = plain(1000);
    bench.gate(true);
    bench.until(3 * MS);
    bench.tick.overrun();
    assert_eq!(bench.tick().fault, Cause::Overrun);
    assert_eq!(bench.switch(), [(MS, true), (3 * MS, false)]);
    bench.tick.restarted();
    assert_eq!(bench.tick().fault, Cause::Overrun, "the first cause is reported");
    bench.change(ChannelChange::ClearFault);
    assert_eq!(bench.tick().fault, Cause::None);
    // A clear on the tick in which a cause appears does not hide it.
    bench.gate(true);
    bench.until(8 * MS);
    bench.tick.overrun();
    bench.change(ChannelChange::ClearFault);
    assert_eq!(bench.tick().fault, Cause::Overrun);
    assert_eq!(bench.switch().last(), Some(&(8 * MS, false)));
    bench.change(ChannelChange::Reset { family: Family::Gus });
    let view = bench.tick();
    assert_eq!((view.fault, view.on_time), (Cause::Overrun, 0));
    bench.change(ChannelChange::ClearFault);
    assert_eq!(bench.tick().fault, Cause::None);
}

#[test]
fn a_full_queue_refuses_the_on_and_goes_dark() {
    let mut bench = plain(10);
    bench.delays(65_535, 65_534);
    // One mark of 1 µs each tick: 2 edges a tick pend for 65 ms.
    let mut dark = None;
    for k in 0..400 {
        bench.gate(true);
        bench.gate(false);
        let view = bench.tick();
        if view.fault != Cause::None {
            assert_eq!(view.fault, Cause::Edges);
            dark = Some(k);
            break;
        }
    }
    assert_eq!(dark, Some(128));
    bench.until(100 * MS);
    assert_eq!(bench.switch(), []);
}

#[test]
fn a_full_queue_never_loses_an_off() {
    // The light is on; off and on edges pend. The last slot is for an off.
    let mut bench = plain(10);
    bench.gate(true);
    bench.tick();
    bench.delays(65_534, 65_535);
    for _ in 0..127 {
        bench.gate(false);
        bench.gate(true);
        assert_eq!(bench.tick().fault, Cause::None);
    }
    bench.gate(false);
    assert_eq!(bench.tick().fault, Cause::None);
    bench.until(100 * MS);
    let edges = bench.switch();
    assert_eq!((edges.len(), edges.last().map(|edge| edge.1)), (1 + 2 * 127 + 1, Some(false)));
}

#[test]
fn an_on_without_a_slot_for_its_off_is_refused() {
    let mut bench = plain(10);
    bench.gate(true);
    bench.tick();
    bench.delays(65_534, 65_535);
    for _ in 0..127 {
        bench.gate(false);
        bench.gate(true);
        bench.tick();
    }
    bench.gate(false);
    bench.tick();
    // 255 edges pend: one slot is left.
    bench.gate(true);
    let view = bench.tick();
    assert_eq!((view.fault, view.commanded, view.light), (Cause::Edges, false, false));
    bench.until(100 * MS);
    assert_eq!(bench.switch(), [(10 * US, true), (1290 * US, false)]);
}

#[test]
fn the_connector_may_carry_something_else() {
    let mut bench = plain(1000);
    bench.change(ChannelChange::Connector { laser: false });
    bench.gate(true);
    let view = bench.until(3 * MS);
    assert_eq!((view.commanded, view.light, view.switch, view.power), (false, false, false, power(0.0)));
    assert_eq!(
        (view.ignored, view.ignored_count),
        (Ignored::NoOutput, 1),
        "an on command that meets no output is an event"
    );
    bench.change(ChannelChange::Connector { laser: true });
    let view = bench.until(5 * MS);
    assert!(!view.commanded && !view.light, "and is not remembered");
    assert_eq!(bench.pulses(), []);
}

#[test]
fn a_connector_that_is_taken_away_takes_the_light_at_once() {
    let mut bench = plain(250);
    bench.delays(1000, 0);
    bench.gate(true);
    bench.until(2 * MS);
    bench.change(ChannelChange::Connector { laser: false });
    let view = bench.tick();
    assert!(!view.commanded && !view.gate && !view.light && !view.switch, "{view:?}");
    bench.until(2750 * US);
    // Within the off delay: there is no off that pends, so nothing lights again.
    bench.change(ChannelChange::Connector { laser: true });
    let view = bench.until(6 * MS);
    assert!(!view.commanded && !view.light, "{view:?}");
    assert_eq!(bench.pulses(), [(250 * US, 2250 * US)]);
    assert_eq!(bench.switch(), [(250 * US, true), (2250 * US, false)]);
    assert_eq!(view.on_time, 2000 / 250);
    // A pending on is withdrawn too.
    bench.delays(0, 1000);
    bench.gate(true);
    bench.until(6500 * US);
    bench.change(ChannelChange::Connector { laser: false });
    bench.change(ChannelChange::Connector { laser: true });
    bench.until(9 * MS);
    assert_eq!((bench.pulses().len(), bench.switch().len()), (1, 2));
}

#[test]
fn analog_light_needs_no_connector() {
    let mut bench = Bench::new(250);
    bench.mode(PowerMode::Analog, 10.0, 0.0, true);
    bench.direct(5.0);
    bench.gate(true);
    bench.until(MS);
    bench.change(ChannelChange::Connector { laser: false });
    let view = bench.until(2 * MS);
    assert!(view.commanded && view.light && view.switch, "{view:?}");
    bench.gate(false);
    bench.until(3 * MS);
    assert_eq!(bench.switch(), [(250 * US, true), (2250 * US, false)]);
    assert_eq!(bench.volts(), [(250 * US, 16384), (2250 * US, 0)]);
}
