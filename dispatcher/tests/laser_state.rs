//! Effects of laser commands on a channel, in both lanes and families: settings that arrive in the
//! tick, light by the script clock.
use crate::{bench, laser_channel};
use bench::{Bench, body, entry, sleep};
use laser_channel::*;
use protocol::command::*;
use protocol::reason::Reason;
use protocol::record::Lane;
use servo::laser::{Count, Power, PowerMode};

#[test]
fn settings_arrive_in_the_channel_they_name() {
    for family in [GUS, LSR] {
        let mut bench = bench(family);
        bench.run_ms(1);
        for channel in 0..2i16 {
            let other = seen(&mut bench, 1 - channel as usize);
            bench.done(mode(1, 20.0, 0.5, channel, 1));
            bench.done(SetPulseWidth { core: 1.into(), width_us: 10.into(), channel: channel.into() });
            bench.done(power(12.5, channel));
            bench.done(carrier(15.0, channel));
            bench.run_ms(1);
            let now = seen(&mut bench, channel as usize);
            assert_eq!(now.mode, PowerMode::Frequency);
            assert_eq!((units(now.bounds.max()), units(now.bounds.min()), units(now.direct)), (20.0, 0.5, 12.5));
            assert_eq!((now.width_us, now.carrier.map(|carrier| units(carrier.khz()))), (10, Some(15.0)));
            assert_eq!(format!("{:?}", seen(&mut bench, 1 - channel as usize)), format!("{other:?}"));
            // Another mode sets the power to 0 and keeps width and carrier; the same one keeps the
            // power.
            bench.done(mode(0, 80.0, 0.0, channel, 1));
            bench.run_ms(1);
            let now = seen(&mut bench, channel as usize);
            assert_eq!((now.mode, units(now.direct), now.width_us), (PowerMode::Duty, 0.0, 10));
            bench.done(power(70.0, channel));
            bench.done(mode(0, 60.0, 10.0, channel, 1));
            bench.run_ms(1);
            let now = seen(&mut bench, channel as usize);
            assert_eq!((units(now.direct), units(now.bounds.max()), now.carrier.is_some()), (70.0, 60.0, true));
        }
        // Mode 3 is a mode of its own in the GUS family, and mode 0 in the other.
        bench.done(mode(3, 50.0, 0.0, 0, 1));
        bench.run_ms(1);
        let now = seen(&mut bench, 0);
        let expected = if family == GUS { (PowerMode::DutyOpen, 0.0) } else { (PowerMode::Duty, 70.0) };
        assert_eq!((now.mode, units(now.direct)), expected);
        bench.done(mode(2, 5.0, 0.0, 0, 0));
        bench.run_ms(1);
        let now = seen(&mut bench, 0);
        assert_eq!((now.mode, units(now.bounds.max())), (PowerMode::Analog, 5.0));
    }
}

#[test]
fn light_follows_the_script_clock_in_both_families() {
    for family in [GUS, LSR] {
        let mut bench = bench(family);
        prepared(&mut bench, family, 0);
        // Delays: GUS applies them always, LSR if the mode says so.
        for (delay_mode, us) in [(0, if family == GUS { 60 } else { 0 }), (1, 60)] {
            bench.done(mode(0, 100.0, 0.0, 0, delay_mode));
            bench.done(delays(90, 30, 0));
            bench.done(ZeroLaserOnTime { core: 1.into(), channel: 0.into() });
            let before = on_time(&mut bench, 0);
            assert_eq!(before, 0);
            // 50 marks of 1 ms: each is longer by the difference of the delays.
            for _ in 0..25 {
                let program = [
                    entry(switch(1, 0)),
                    entry(sleep(1)),
                    entry(switch(0, 0)),
                    entry(sleep(1)),
                    entry(LaserOn { core: 1.into(), channel: 0.into() }),
                    entry(sleep(1)),
                    entry(LaserOff { core: 1.into(), channel: 0.into() }),
                    entry(sleep(1)),
                    entry(ProgramEnd {}),
                ];
                let tags = bench.post_all(&program);
                bench.done(ProgramStart { strict: 1 });
                let codes: Vec<i16> = tags.into_iter().map(|tag| bench.wait(tag).code).collect();
                assert_eq!(codes, [0; 9]);
            }
            bench.run_ms(1);
            assert_eq!(on_time(&mut bench, 0), (50 * (1000 + us)) / 250, "family {family}, delay mode {delay_mode}");
        }
    }
}

#[test]
fn reads_tell_the_command_and_the_output() {
    for family in [GUS, LSR] {
        let mut bench = bench(family);
        prepared(&mut bench, family, 1);
        assert_eq!((commanded(&mut bench, 0), commanded(&mut bench, 1)), (0, 0));
        bench.done(mode(0, 100.0, 0.0, 1, 1));
        bench.done(delays(1000, 2000, 1));
        bench.done(switch(1, 1));
        let status = |bench: &mut Bench<8>| bench.done(LaserStatus { core: 1.into(), channel: 1.into() });
        let reported =
            |bench: &mut Bench<8>| bench.done(GetLaserPower { core: 1.into(), channel: 1.into() }).value.get();
        // The command is on, the output is not yet.
        assert_eq!((commanded(&mut bench, 0), commanded(&mut bench, 1)), (0, 1));
        let now = status(&mut bench);
        assert_eq!((now.mode.get(), now.commanded, now.gate, now.light, now.power.get()), (0, 1, 0, 0, 0.0));
        bench.run_ms(3);
        let now = status(&mut bench);
        assert_eq!((now.commanded, now.gate, now.light, now.fault.get()), (1, 1, 1, 0));
        assert_eq!((now.power.get(), reported(&mut bench)), (40.0, 40.0));
        assert!((now.frequency.get() - 10.0).abs() < 1e-5, "{}", now.frequency.get());
        // The bounds limit the output.
        bench.done(mode(0, 30.0, 0.0, 1, 1));
        bench.run_ms(1);
        assert_eq!(reported(&mut bench), 30.0);
        bench.done(switch(0, 1));
        assert_eq!(commanded(&mut bench, 1), 0);
        assert_eq!(status(&mut bench).light, 1, "off takes 1 ms");
        bench.run_ms(2);
        let now = status(&mut bench);
        assert_eq!((now.gate, now.light, now.power.get(), now.frequency.get()), (0, 0, 0.0, 0.0));
        // A width that reaches the period: limited, and reported.
        bench.done(mode(1, 20.0, 0.0, 1, 1));
        bench.done(SetPulseWidth { core: 1.into(), width_us: 200.into(), channel: 1.into() });
        bench.done(power(10.0, 1));
        bench.done(switch(1, 1));
        bench.run_ms(3);
        let now = status(&mut bench);
        assert_eq!((now.mode.get(), now.light, now.held, now.power.get()), (1, 1, 1, 10.0));
        bench.done(SetPulseWidth { core: 1.into(), width_us: 20.into(), channel: 1.into() });
        bench.run_ms(1);
        assert_eq!(status(&mut bench).held, 0);
    }
}

#[test]
fn a_power_command_reports_what_the_timers_reach() {
    for family in [GUS, LSR] {
        let mut bench = bench(family);
        prepared(&mut bench, family, 0);
        bench.done(SetPulseWidth { core: 1.into(), width_us: 10.into(), channel: 0.into() });
        // The value asked for in a mode, and the tolerance of the timers (SPEC 11).
        for (of, asked, within) in [(0, 100.0 / 3.0, 1e-3), (1, 7.123_457_1, 7.2e-6)] {
            bench.done(mode(of, [100.0, 20.0][of as usize], 0.0, 0, 0));
            let reported = bench.done(power(asked, 0)).value.get();
            bench.done(switch(1, 0));
            bench.run_ms(1);
            let train = seen(&mut bench, 0).train;
            let counts = |Count { whole, part, of }: Count| {
                whole as f64 + f64::from(part) / if of == 0 { 4_294_967_296.0 } else { f64::from(of) }
            };
            // The clock of the machine is 1 GHz.
            let (period, width) = (counts(train.period), counts(train.width));
            let reached = if of == 0 { width / period * 100.0 } else { 1e6 / period };
            assert!((reported - reached).abs() < 1e-12 && reported != asked, "{reported}, {reached} reached");
            assert!((reported - asked).abs() < within, "{reported}");
        }
        // The bounds limit it.
        bench.done(mode(0, 30.0, 10.0, 0, 0));
        for (asked, reported) in [(40.0, 30.0), (0.0, 10.0), (20.0, 20.0)] {
            assert_eq!(bench.done(power(asked, 0)).value.get(), reported);
        }
        // Volts are as asked.
        bench.done(mode(2, 10.0, 0.0, 0, 0));
        assert_eq!(bench.done(power(2.5, 0)).value.get(), 2.5);
    }
}

#[test]
fn another_resolution_holds_what_is_set() {
    let mut bench = bench(LSR);
    let resolution = |mode: i16| SetLaserMode { core: 1.into(), mode: mode.into() };
    bench.done(resolution(0));
    bench.done(carrier(96.0, 0));
    bench.done(carrier(20.0, 1));
    let waiting =
        SetWaitPulse { core: 1.into(), mode: 1.into(), frequency: 60.0.into(), duty: 50.0.into(), channel: 1.into() };
    bench.done(waiting);
    bench.done(mode(1, 90.0, 30.0, 0, 0));
    bench.done(power(50.0, 0));
    bench.done(resolution(1));
    bench.run_ms(1);
    let now = seen(&mut bench, 0);
    assert_eq!((units(now.bounds.max()), units(now.bounds.min()), units(now.direct)), (24.0, 24.0, 24.0));
    assert_eq!(now.carrier.map(|carrier| units(carrier.khz())), Some(24.0));
    let other = seen(&mut bench, 1);
    assert_eq!(other.carrier.map(|carrier| units(carrier.khz())), Some(20.0));
    assert_eq!((units(other.khz), units(other.power)), (24.0, 50.0), "standby");
    // Back: limited values stay limited.
    bench.done(resolution(0));
    bench.run_ms(1);
    assert_eq!(units(seen(&mut bench, 0).direct), 24.0);
    assert_eq!(bench.done(power(96.0, 0)).held & 1, 0);
}

#[test]
fn a_family_and_a_reset_put_the_channels_to_power_on() {
    let mut bench = bench(LSR);
    for renew in 0..3 {
        bench.done(SetLaserMode { core: 1.into(), mode: 0.into() });
        bench.done(delays(100, 100, 0));
        prepared(&mut bench, LSR, 0);
        bench.done(switch(1, 0));
        bench.run_ms(2);
        assert!(seen(&mut bench, 0).light);
        match renew {
            0 => drop(bench.done(Reset { core: 1.into() })),
            1 => {
                bench.done(Choose { profile: 0, family: GUS });
                bench.done(Choose { profile: 0, family: LSR });
            }
            _ => {
                // A choice of the present values is no change.
                bench.done(Choose { profile: 0, family: LSR });
                bench.run_ms(1);
                assert!(seen(&mut bench, 0).light);
                return;
            }
        }
        bench.run_ms(1);
        let now = seen(&mut bench, 0);
        assert!(!now.light && !now.commanded && now.carrier.is_none() && now.direct == Power::ZERO, "{now:?}");
        assert_eq!((now.mode, units(now.bounds.max()), now.delayed, now.on_time), (PowerMode::Duty, 100.0, false, 0));
        // The resolution is that of power-on too.
        assert_eq!(bench.done(carrier(96.0, 0)).held, 1);
    }
}

#[test]
fn step_pulses_take_the_connector_and_the_light() {
    let mut bench = bench(GUS);
    prepared(&mut bench, GUS, 0);
    bench.done(switch(1, 0));
    bench.run_ms(1);
    assert!(seen(&mut bench, 0).light);
    bench.done(connector(7, 0));
    bench.run_ms(1);
    let now = seen(&mut bench, 0);
    assert!(!now.light && !now.commanded && !now.connector, "{now:?}");
    // It comes back with a command only.
    bench.done(connector(7, 1));
    bench.run_ms(1);
    assert!(!seen(&mut bench, 0).light);
}

#[test]
fn light_does_not_come_back_with_its_connector_within_the_off_delay() {
    let mut bench = bench(GUS);
    prepared(&mut bench, GUS, 0);
    bench.done(delays(20_000, 0, 0));
    bench.done(switch(1, 0));
    bench.run_ms(2);
    assert!(seen(&mut bench, 0).light);
    bench.done(connector(7, 0));
    bench.run_ms(1);
    let before = on_time(&mut bench, 0);
    bench.run_ms(2);
    assert_eq!((on_time(&mut bench, 0), commanded(&mut bench, 0)), (before, 0), "taken away it counts no light");
    bench.done(connector(7, 1));
    bench.run_ms(2);
    let now = seen(&mut bench, 0);
    assert!(!now.light && !now.gate && !now.commanded && now.connector, "{now:?}");
    assert_eq!(on_time(&mut bench, 0), before);
}

#[test]
fn a_connector_that_is_taken_away_leaves_analog_light() {
    let mut bench = bench(GUS);
    bench.done(mode(2, 10.0, 0.0, 0, 0));
    bench.done(power(5.0, 0));
    bench.done(switch(1, 0));
    bench.run_ms(1);
    bench.done(connector(7, 0));
    bench.run_ms(1);
    let now = seen(&mut bench, 0);
    assert!(now.light && now.commanded && !now.connector, "{now:?}");
    assert_eq!(units(now.power), 5.0);
}

#[test]
fn in_a_program_each_reply_reports_its_own_numbers() {
    let mut bench = bench(LSR);
    let mut program: Vec<_> = [10.0, 101.0, -1.0, 55.5].into_iter().map(|value| entry(power(value, 0))).collect();
    // A Calculate command keeps its numbers in the same queue.
    let calculate = PvtPercentCalculate { core: 1.into(), count: 2.into(), first: 0.into(), vel_begin: 1.0.into() };
    let point = |time: f64, pos: f64| PvtPercentPoint { time: time.into(), pos: pos.into(), percent: 0.0.into() };
    let points = [point(0.0, 0.0), point(10.0, 30.0)];
    program.push((opcode::PvtPercentCalculate, Lane::Program, body(calculate, &points)));
    program.push(entry(delays(70_000, 7, 0)));
    program.push(entry(ProgramEnd {}));
    let tags = bench.post_all(&program);
    bench.done(ProgramStart { strict: 1 });
    let answers: Vec<_> = tags.into_iter().map(|tag| bench.wait(tag)).collect();
    let reported: Vec<(f64, u8)> = answers[..4]
        .iter()
        .map(|answer| answer.reply::<LaserPrfCmd>())
        .map(|taken| (taken.value.get(), taken.held))
        .collect();
    assert_eq!(reported, [(10.0, 0), (100.0, 1), (0.0, 1), (55.5, 0)]);
    let velocities: Vec<f64> =
        answers[4].items::<PvtPercentCalculate>().into_iter().map(|item| item.value.get()).collect();
    assert_eq!(velocities, [1.0, 5.0]);
    let taken = answers[5].reply::<SetLevelDelay>();
    assert_eq!((taken.off_delay_us.get(), taken.on_delay_us.get(), taken.held), (65_535, 7, 1));
}

#[test]
fn the_immediate_lane_sets_no_laser_beside_a_program() {
    let mut bench = bench(LSR);
    prepared(&mut bench, LSR, 0);
    bench.post_all(&[entry(sleep(50)), entry(ProgramEnd {})]);
    bench.done(ProgramStart { strict: 1 });
    for lane_0 in [
        bench.call(switch(1, 0)),
        bench.call(power(1.0, 0)),
        bench.call(Choose { profile: 0, family: GUS }),
        bench.call(LaserOn { core: 1.into(), channel: 0.into() }),
    ] {
        assert_eq!(lane_0.reason(), Reason::ProgramRuns);
    }
    // Commands that switch off or clear are accepted.
    bench.done(switch(0, 0));
    bench.done(LaserOff { core: 1.into(), channel: 0.into() });
    bench.done(ClrLaserFault { core: 1.into(), channel: 0.into() });
    assert_eq!(commanded(&mut bench, 0), 0);
    bench.done(GetLaserPower { core: 1.into(), channel: 0.into() });
    let tag = bench.post(Lane::Immediate, LaserStatus { core: 1.into(), channel: 0.into() }, &[]);
    assert_eq!(bench.wait(tag).code, 0);
}
