//! Every laser command in both families: what is right and what the reply tells, what is refused
//! with which words, what is held. A command that fails leaves everything as it was.
use crate::bench;
use bench::{Bench, body};
use protocol::command::*;
use protocol::reason::describe_opcode;
use protocol::record::Lane;

const GUS: u8 = 0;
const LSR: u8 = 1;

fn bench(family: u8) -> Bench<8> {
    let mut bench = Bench::gus();
    bench.done(Choose { profile: 0, family });
    bench
}

fn mode(mode: i16, max: f64, min: f64) -> LaserPowerMode {
    LaserPowerMode {
        core: 1.into(),
        mode: mode.into(),
        max: max.into(),
        min: min.into(),
        channel: 0.into(),
        delay_mode: 0.into(),
    }
}

fn power(power: f64) -> LaserPrfCmd {
    LaserPrfCmd { core: 1.into(), power: power.into(), channel: 0.into() }
}

fn carrier(frequency: f64) -> LaserOutFrq {
    LaserOutFrq { core: 1.into(), frequency: frequency.into(), channel: 0.into() }
}

fn width(width_us: u32) -> SetPulseWidth {
    SetPulseWidth { core: 1.into(), width_us: width_us.into(), channel: 0.into() }
}

fn standby(mode: u16, frequency: f64, duty: f64) -> SetWaitPulse {
    let (frequency, duty) = (frequency.into(), duty.into());
    SetWaitPulse { core: 1.into(), mode: mode.into(), frequency, duty, channel: 0.into() }
}

fn standby_all(mode: u16, frequency: f64, duty: f64) -> SetWaitPulseEx {
    SetWaitPulseEx { core: 1.into(), mode: mode.into(), frequency: frequency.into(), duty: duty.into() }
}

fn pre_voltage(mode: u16, voltage: f64) -> SetPreVltg {
    SetPreVltg { core: 1.into(), mode: mode.into(), voltage: voltage.into(), channel: 0.into() }
}

fn delays(off: u32, on: u32) -> SetLevelDelay {
    SetLevelDelay { core: 1.into(), off_delay_us: off.into(), on_delay_us: on.into(), channel: 0.into() }
}

fn fpk(time1: u32, time2: u32, end: u32) -> EnaFPK {
    EnaFPK {
        core: 1.into(),
        time1_us: time1.into(),
        time2_us: time2.into(),
        laser_off_delay_us: end.into(),
        channel: 0.into(),
    }
}

fn switch(value: u16) -> SetHSIOOpt {
    SetHSIOOpt { core: 1.into(), value: value.into(), channel: 0.into() }
}

fn connector(axis: i16, mode: i16) -> SetAxisMode {
    SetAxisMode { core: 1.into(), axis: axis.into(), mode: mode.into() }
}

fn map(map: i16) -> SetLaserCrdMap {
    SetLaserCrdMap { core: 1.into(), channel: 0.into(), map: map.into() }
}

fn resolution(mode: i16) -> SetLaserMode {
    SetLaserMode { core: 1.into(), mode: mode.into() }
}

/// The request as it is sent, for channel `channel`; every laser request but SetWaitPulseEx,
/// SetLaserMode and SetAxisMode has one.
fn for_channel<R: Request>(request: R, channel: i16) -> Vec<u8> {
    let mut bytes = body::<R>(request, &[]);
    let mut at = 0;
    for (name, of) in R::FIELDS {
        let size = match *of {
            "I16" | "U16" => 2,
            "U32" => 4,
            "F64" => 8,
            other => panic!("{other}"),
        };
        if *name == "channel" {
            bytes[at..at + size].copy_from_slice(&channel.to_le_bytes());
            return bytes;
        }
        at += size;
    }
    panic!("{} has no channel", R::NAME);
}

/// All visible state of the lasers, and the number of the last entry: a refused command pushes
/// none.
fn state(bench: &mut Bench<8>) -> String {
    let mut text = String::new();
    for channel in 0..2 {
        let map = bench.done(GetLaserCrdMap { core: 1.into(), channel: channel.into() });
        text += &format!("{:?}", map.value);
    }
    let view = bench.server.view();
    let mut lasers = view.lasers;
    lasers.iter_mut().for_each(|laser| laser.on_time = 0);
    format!("{text} {} {lasers:?}", view.done_immediate)
}

/// Refused by this family with this code and text, and nothing has changed.
#[track_caller]
fn refused<R: Request>(bench: &mut Bench<8>, request: R, code: i16, text: &str) {
    refused_raw(bench, R::OPCODE, &body::<R>(request, &[]), code, text);
}

#[track_caller]
fn refused_raw(bench: &mut Bench<8>, opcode: u16, body: &[u8], code: i16, text: &str) {
    let before = state(bench);
    let tag = bench.post_raw(opcode, Lane::Immediate, body);
    let answer = bench.wait(tag);
    assert_ne!(answer.code, 0, "not refused; {text}");
    assert_eq!(describe_opcode(opcode, answer.refusal()).to_string(), text);
    assert_eq!(answer.code, code, "{text}");
    bench.run_ms(1);
    assert_eq!(state(bench), before, "{text}");
}

#[test]
fn selectors_are_refused_in_both_families() {
    for family in [GUS, LSR] {
        let mut bench = bench(family);
        let b = &mut bench;
        refused(b, mode(4, 100.0, 0.0), 7, "LaserPowerMode: mode is 4; allowed are 0 to 3");
        refused(b, mode(-1, 100.0, 0.0), 7, "LaserPowerMode: mode is -1; allowed are 0 to 3");
        refused(b, standby(2, 5.0, 2.0), 7, "SetWaitPulse: mode is 2; allowed are 0 to 1");
        refused(b, standby_all(65535, 5.0, 2.0), 7, "SetWaitPulseEx: mode is 65535; allowed are 0 to 1");
        refused(b, pre_voltage(2, 5.0), 7, "SetPreVltg: mode is 2; allowed are 0 to 1");
        refused(b, switch(2), 7, "SetHSIOOpt: value is 2; allowed are 0 to 1");
        refused(b, resolution(2), 7, "SetLaserMode: mode is 2; allowed are 0 to 1");
        refused(b, resolution(-1), 7, "SetLaserMode: mode is -1; allowed are 0 to 1");
        refused(b, map(4), 7, "SetLaserCrdMap: map is 4; allowed are 0 to 3");
        refused(b, map(-1), 7, "SetLaserCrdMap: map is -1; allowed are 0 to 3");
    }
}

#[test]
fn channels_and_cores_that_do_not_exist_are_refused_in_every_command() {
    macro_rules! each {
        ($bench:expr, $($name:ident = $request:expr;)*) => {$(
            for channel in [2i16, -1] {
                let text = format!("{}: channel is {channel}; allowed are 0 to 1", stringify!($name));
                refused_raw($bench, opcode::$name, &for_channel::<$name>($request, channel), 7, &text);
            }
            let mut other = body::<$name>($request, &[]);
            other[0] = 2;
            let text = concat!(stringify!($name), ": core is 2; it must be 1");
            refused_raw($bench, opcode::$name, &other, 7, text);
        )*};
    }
    for family in [GUS, LSR] {
        let mut bench = bench(family);
        each!(&mut bench,
            LaserOn = LaserOn { core: 1.into(), ..LaserOn::default() };
            LaserOff = LaserOff { core: 1.into(), ..LaserOff::default() };
            LaserPowerMode = mode(0, 100.0, 0.0);
            LaserPrfCmd = power(10.0);
            LaserOutFrq = carrier(10.0);
            SetPulseWidth = width(10);
            SetWaitPulse = standby(1, 5.0, 2.0);
            SetPreVltg = pre_voltage(1, 0.5);
            SetLevelDelay = delays(1, 2);
            EnaFPK = fpk(1, 2, 3);
            DisFPK = DisFPK { core: 1.into(), ..DisFPK::default() };
            ZeroLaserOnTime = ZeroLaserOnTime { core: 1.into(), ..ZeroLaserOnTime::default() };
            GetLaserOnTime = GetLaserOnTime { core: 1.into(), ..GetLaserOnTime::default() };
            SetLaserCrdMap = map(1);
            GetLaserCrdMap = GetLaserCrdMap { core: 1.into(), ..GetLaserCrdMap::default() };
            GetLaserPower = GetLaserPower { core: 1.into(), ..GetLaserPower::default() };
            ClrLaserFault = ClrLaserFault { core: 1.into(), ..ClrLaserFault::default() };
            GetLaserFault = GetLaserFault { core: 1.into(), ..GetLaserFault::default() };
            LaserOnStatus = LaserOnStatus { core: 1.into(), ..LaserOnStatus::default() };
            SetHSIOOpt = switch(0);
            GetHSIOOpt = GetHSIOOpt { core: 1.into(), ..GetHSIOOpt::default() };
            LaserStatus = LaserStatus { core: 1.into(), ..LaserStatus::default() };
        );
        for (opcode, mut request) in [
            (opcode::SetWaitPulseEx, body::<SetWaitPulseEx>(standby_all(1, 5.0, 2.0), &[])),
            (opcode::SetLaserMode, body::<SetLaserMode>(resolution(0), &[])),
        ] {
            request[0] = 2;
            let text = format!("{}: core is 2; it must be 1", info(opcode).unwrap().name);
            refused_raw(&mut bench, opcode, &request, 7, &text);
        }
    }
}

#[test]
fn what_is_no_number_is_refused_in_both_families() {
    for family in [GUS, LSR] {
        let mut bench = bench(family);
        let b = &mut bench;
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let no = |name: &str, field: &str| format!("{name}: {field} is not a finite number");
            if bad != f64::NEG_INFINITY {
                refused(b, mode(0, bad, 0.0), 7, &no("LaserPowerMode", "max"));
            }
            if bad != f64::INFINITY {
                refused(b, mode(0, 100.0, bad), 7, &no("LaserPowerMode", "min"));
            }
            refused(b, power(bad), 7, &no("LaserPrfCmd", "power"));
            refused(b, carrier(bad), 7, &no("LaserOutFrq", "frequency"));
            for on in [0, 1] {
                refused(b, standby(on, bad, 2.0), 7, &no("SetWaitPulse", "frequency"));
                refused(b, standby(on, 5.0, bad), 7, &no("SetWaitPulse", "duty"));
                refused(b, standby_all(on, bad, 2.0), 7, &no("SetWaitPulseEx", "frequency"));
                refused(b, standby_all(on, 5.0, bad), 7, &no("SetWaitPulseEx", "duty"));
                refused(b, pre_voltage(on, bad), 7, &no("SetPreVltg", "voltage"));
            }
        }
    }
}

#[test]
fn a_maximum_below_its_minimum_is_refused_in_both_families() {
    for family in [GUS, LSR] {
        let mut bench = bench(family);
        for (number, max, min) in [(0, 10.0, 20.0), (1, 0.0, 0.5), (2, 2.5, 3.0), (3, 0.0, 100.0)] {
            let text = format!("LaserPowerMode: max is {max}; it must not be below the minimum, {min}");
            refused(&mut bench, mode(number, max, min), 7, &text);
        }
        if family == GUS {
            let text = "LaserPowerMode: max is 150; it must not be below the minimum, 200";
            refused(&mut bench, mode(0, 150.0, 200.0), 7, text);
        }
        let same = bench.done(mode(0, 40.0, 40.0));
        assert_eq!((same.max.get(), same.min.get(), same.held), (40.0, 40.0, 0));
    }
}

#[test]
fn gus_refuses_what_is_out_of_range() {
    let mut bench = bench(GUS);
    let b = &mut bench;
    for (number, unit) in [(0, 100), (3, 100), (1, 2000), (2, 10)] {
        let high = f64::from(unit);
        let text = format!("LaserPowerMode: max is {}; it must be from 0 to {unit}", unit + 1);
        refused(b, mode(number, high + 1.0, 0.0), 7, &text);
        let text = format!("LaserPowerMode: min is -1; it must be from 0 to {unit}");
        refused(b, mode(number, high, -1.0), 7, &text);
        b.done(mode(number, high, 0.0));
        refused(b, power(high + 1.0), 7, &format!("LaserPrfCmd: power is {}; it must be from 0 to {unit}", unit + 1));
        refused(b, power(-1.0), 7, &format!("LaserPrfCmd: power is -1; it must be from 0 to {unit}"));
        for right in [0.0, high] {
            let taken = b.done(power(right));
            assert_eq!((taken.value.get(), taken.held), (right, 0));
        }
    }
    refused(b, carrier(2001.0), 7, "LaserOutFrq: frequency is 2001; it must be from 0.001 to 2000");
    refused(b, width(0), 7, "SetPulseWidth: width_us is 0; it must be from 1 to 65535");
    refused(b, width(65_536), 7, "SetPulseWidth: width_us is 65536; it must be from 1 to 65535");
    refused(b, width(u32::MAX), 7, "SetPulseWidth: width_us is 4294967295; it must be from 1 to 65535");
    let (low, high) = ("must be from 0.001 to 2000", "must be from 0 to 100");
    refused(b, standby(1, 2001.0, 2.0), 7, &format!("SetWaitPulse: frequency is 2001; it {low}"));
    refused(b, standby(0, 2001.0, 2.0), 7, &format!("SetWaitPulse: frequency is 2001; it {low}"));
    refused(b, standby(1, 5.0, 101.0), 7, &format!("SetWaitPulse: duty is 101; it {high}"));
    refused(b, standby(1, 5.0, -1.0), 7, &format!("SetWaitPulse: duty is -1; it {high}"));
    refused(b, standby_all(1, 5.0, 100.5), 7, &format!("SetWaitPulseEx: duty is 100.5; it {high}"));
    refused(b, pre_voltage(1, 10.5), 7, "SetPreVltg: voltage is 10.5; it must be from 0 to 10");
    refused(b, pre_voltage(1, -0.25), 7, "SetPreVltg: voltage is -0.25; it must be from 0 to 10");
    refused(b, delays(65_536, 1), 7, "SetLevelDelay: off_delay_us is 65536; it must be from 0 to 65535");
    refused(b, delays(1, 65_536), 7, "SetLevelDelay: on_delay_us is 65536; it must be from 0 to 65535");
    refused(b, fpk(0, 2, 3), 7, "EnaFPK: time1_us is 0; it must be from 1 to 65535");
    refused(b, fpk(65_536, 2, 3), 7, "EnaFPK: time1_us is 65536; it must be from 1 to 65535");
    refused(b, fpk(1, 65_536, 3), 7, "EnaFPK: time2_us is 65536; it must be from 0 to 65535");
    refused(b, fpk(1, 2, 65_536), 7, "EnaFPK: laser_off_delay_us is 65536; it must be from 0 to 65535");
    // The manual of this family has no fifth parameter: any value is ignored.
    let ignored = LaserPowerMode { delay_mode: 77.into(), ..mode(0, 100.0, 10.0) };
    assert_eq!(b.done(ignored).held, 0);
    // It has no resolutions either.
    b.done(resolution(0));
    assert_eq!(b.done(carrier(2000.0)).held, 0);
}

#[test]
fn lsr_takes_the_nearest_bound_and_reports_it() {
    let mut bench = bench(LSR);
    let b = &mut bench;
    // The resolution of power-on is 1: 0 to 24 kHz in steps of 1.5 Hz; 0 has 96 kHz in steps of 6
    // Hz.
    for (fine, khz) in [(None, 24.0), (Some(0), 96.0), (Some(1), 24.0)] {
        if let Some(fine) = fine {
            b.done(resolution(fine));
        }
        for (number, high) in [(0, 100.0), (3, 100.0), (1, khz), (2, 10.0)] {
            let taken = |b: &mut Bench<8>, max, min| {
                let taken = b.done(mode(number, max, min));
                (taken.max.get(), taken.min.get(), taken.held)
            };
            assert_eq!(taken(b, high + 1.0, 0.5), (high, 0.5, 0b01));
            assert_eq!(taken(b, high, -1.0), (high, 0.0, 0b10));
            assert_eq!(taken(b, 2001.0, -1e300), (high, 0.0, 0b11));
            // A minimum outside its range, on either side, becomes the range's minimum (LSR,
            // command 11).
            assert_eq!(taken(b, 5e4, 4e4), (high, 0.0, 0b11));
            assert_eq!(taken(b, high / 2.0, high + 1.0), (high / 2.0, 0.0, 0b10));
            // A negative maximum is refused.
            for (max, min) in [(-1.0, -2.0), (-0.5, 0.0), (-1e300, 4e4)] {
                let reported = if max == -1e300 { "-1e300".to_owned() } else { max.to_string() };
                let text = format!("LaserPowerMode: max is {reported}; it must be from 0 to {high}");
                refused(b, mode(number, max, min), 7, &text);
            }
            assert_eq!(taken(b, high, 0.0), (high, 0.0, 0));
            for (given, value, held) in
                [(101.0, high, 1), (1e300, high, 1), (-1.0, 0.0, 1), (0.0, 0.0, 0), (high, high, 0), (2.5, 2.5, 0)]
            {
                let taken = b.done(power(given));
                assert_eq!(taken.held & 0x7f, held, "mode {number}: {given}");
                // The reply reports what the timer reaches: duty 0.001 %, rate 1 ppm (SPEC 11);
                // volts as asked.
                let within = [1e-3, 1e-6 * value, 0.0, 1e-3][number as usize];
                let reported = taken.value.get();
                assert!((reported - value).abs() <= within, "mode {number}: {given} is reported as {reported}");
            }
        }
        for (given, value, held) in [(2001.0, khz, 1), (khz, khz, 0), (0.001, 0.001, 0), (0.0015, 0.0015, 0)] {
            let taken = b.done(carrier(given));
            // The reply reports what the timer reaches: 1 ppm (SPEC 11).
            let error = taken.value.get() / value - 1.0;
            assert!(error.abs() < 1e-6, "{given}: {}", taken.value.get());
            assert_eq!(taken.held, held, "{given}");
            for pulse in [b.done(standby(1, given, 50.0)), b.done(standby_all(1, given, 50.0))] {
                assert!((pulse.frequency.get() / value - 1.0).abs() < 1e-6, "{given}: {}", pulse.frequency.get());
                assert!((pulse.duty.get() - 50.0).abs() < 1e-3, "{given}: {}", pulse.duty.get());
                assert_eq!(pulse.held, held, "{given}");
            }
        }
    }
    for (given, value, held) in [(0, 1, 1), (5_000, 4_000, 1), (u32::MAX, 4_000, 1), (1, 1, 0), (4_000, 4_000, 0)] {
        b.done(power(0.0));
        let taken = b.done(width(given));
        assert_eq!((taken.value.get(), taken.held), (f64::from(value), held), "{given}");
    }
    for (given, value, held) in [(101.0, 100.0, 2), (-1.0, 0.0, 2), (100.0, 100.0, 0)] {
        let pulse = b.done(standby(0, 5.0, given));
        assert_eq!((pulse.frequency.get(), pulse.duty.get(), pulse.held), (5.0, value, held), "{given}");
    }
    for (given, value, held) in [(11.0, 10.0, 1), (-0.5, 0.0, 1), (10.0, 10.0, 0)] {
        let taken = b.done(pre_voltage(1, given));
        assert_eq!((taken.value.get(), taken.held), (value, held), "{given}");
    }
    let taken = b.done(delays(70_000, 65_536));
    assert_eq!((taken.off_delay_us.get(), taken.on_delay_us.get(), taken.held), (65_535, 65_535, 3));
    let taken = b.done(delays(0, 20));
    assert_eq!((taken.off_delay_us.get(), taken.on_delay_us.get(), taken.held), (0, 20, 0));
    let taken = b.done(fpk(0, 65_536, u32::MAX));
    let reported = (taken.time1_us.get(), taken.time2_us.get(), taken.laser_off_delay_us.get(), taken.held);
    assert_eq!(reported, (1, 65_535, 65_535, 0b111));
    let wrong = LaserPowerMode { delay_mode: 2.into(), ..mode(0, 100.0, 10.0) };
    refused(b, wrong, 7, "LaserPowerMode: delay_mode is 2; allowed are 0 to 1");
}

/// Below 1 Hz there is no carrier, no standby and no rate but 0, in either family.
#[test]
fn frequencies_below_1_hz_are_refused_in_both_families() {
    for (family, high) in [(GUS, 2000), (LSR, 24)] {
        let mut bench = bench(family);
        let b = &mut bench;
        for (given, reported) in [(0.0, "0"), (-5.0, "-5"), (1e-14, "1e-14"), (0.000_999_999, "0.000999999")] {
            let text = format!("frequency is {reported}; it must be from 0.001 to {high}");
            refused(b, carrier(given), 7, &format!("LaserOutFrq: {text}"));
            refused(b, standby(1, given, 2.0), 7, &format!("SetWaitPulse: {text}"));
            refused(b, standby_all(1, given, 2.0), 7, &format!("SetWaitPulseEx: {text}"));
        }
        b.done(mode(1, 20.0, 0.0));
        for (given, reported) in [(1e-14, "1e-14"), (0.000_999_999, "0.000999999")] {
            let text = format!("power is {reported} kHz; it must be 0, or from 0.001 to {high}");
            refused(b, power(given), 7, &format!("LaserPrfCmd: {text}"));
        }
        for right in [0.0, 0.001, 0.0015] {
            assert_eq!(b.done(power(right)).held, 0, "{right}");
        }
        // In the other modes it is no frequency.
        for number in [0, 2] {
            b.done(mode(number, 5.0, 0.0));
            assert_eq!(b.done(power(0.0005)).held, 0);
        }
    }
}

/// SetWaitPulseEx of the LSR family: pulses where both channels are PWM, and none while one of them
/// is analog.
#[test]
fn standby_of_both_channels_wants_both_to_be_pwm() {
    fn output(bench: &mut Bench<8>) -> [bool; 2] {
        bench.run_ms(1);
        bench.server.view().lasers.map(|laser| !laser.train.is_none())
    }
    fn second(number: i16, max: f64) -> LaserPowerMode {
        LaserPowerMode { channel: 1.into(), ..mode(number, max, 0.0) }
    }
    let mut lsr = bench(LSR);
    let b = &mut lsr;
    b.done(second(2, 10.0));
    let reported = b.done(standby_all(1, 5.0, 50.0));
    assert_eq!((reported.frequency.get(), reported.duty.get(), reported.held), (5.0, 50.0, 0));
    assert_eq!(output(b), [false, false], "channel 1 is analog");
    b.done(second(1, 24.0));
    assert_eq!(output(b), [true, true]);
    // The range of frequencies changes nothing of it.
    b.done(mode(2, 10.0, 0.0));
    b.done(resolution(0));
    b.done(standby_all(1, 60.0, 50.0));
    b.done(resolution(1));
    assert_eq!(output(b), [false, false], "channel 0 is analog");
    b.done(mode(2, 5.0, 0.0));
    assert_eq!(output(b), [false, false]);
    b.done(mode(0, 100.0, 0.0));
    assert_eq!(output(b), [true, true]);
    b.done(standby_all(0, 0.0, 0.0));
    b.done(second(2, 10.0));
    b.done(second(0, 100.0));
    assert_eq!(output(b), [false, false], "it is off");
    // The command for one channel ignores the other.
    b.done(second(2, 10.0));
    b.done(standby(1, 5.0, 50.0));
    assert_eq!(output(b), [true, false]);
    // GUS has its standby by channel.
    let mut gus = bench(GUS);
    let b = &mut gus;
    b.done(connector(7, 1));
    b.done(connector(8, 1));
    b.done(second(2, 10.0));
    b.done(standby_all(1, 5.0, 50.0));
    assert_eq!(output(b), [true, false]);
}

#[test]
fn standby_is_switched_off_by_zeros() {
    for family in [GUS, LSR] {
        let mut bench = bench(family);
        for taken in [bench.done(standby(0, 0.0, 0.0)), bench.done(standby_all(0, 0.0, 0.0))] {
            assert_eq!((taken.frequency.get(), taken.duty.get(), taken.held), (0.0, 0.0, 0));
        }
        assert_eq!(bench.done(pre_voltage(0, 0.0)).held, 0);
    }
}

#[test]
fn a_width_that_reaches_the_period_is_reported() {
    const LIMITED: u8 = 0x80;
    for family in [GUS, LSR] {
        let mut bench = bench(family);
        let b = &mut bench;
        b.done(mode(1, 20.0, 0.0));
        assert_eq!(b.done(width(51)).held, 0, "no pulses yet");
        assert_eq!(b.done(power(19.0)).held, 0);
        let taken = b.done(power(20.0));
        assert_eq!((taken.value.get(), taken.held), (20.0, LIMITED), "51 µs in 50 µs");
        assert_eq!(b.done(width(50)).held, LIMITED, "the whole period");
        assert_eq!(b.done(width(49)).held, 0);
        let taken = b.done(width(1000));
        assert_eq!((taken.value.get(), taken.held), (1000.0, LIMITED));
        // The bounds limit the rate.
        assert_eq!(b.done(mode(1, 0.5, 0.0)).held, 0);
        assert_eq!(b.done(mode(1, 1.0, 0.0)).held, LIMITED);
        assert_eq!(b.done(mode(0, 100.0, 0.0)).held, 0);
        // Another mode begins with a power of 0: no pulses.
        assert_eq!(b.done(mode(1, 20.0, 0.0)).held, 0);
        assert_eq!(b.done(mode(1, 20.0, 1.0)).held, LIMITED, "its least is a rate too");
    }
}

#[test]
fn axis_connectors_belong_to_the_gus_family() {
    let mut bench = bench(GUS);
    let b = &mut bench;
    refused(b, connector(6, 1), 7, "SetAxisMode: axis is 6; allowed are 7 to 8");
    refused(b, connector(9, 1), 7, "SetAxisMode: axis is 9; allowed are 7 to 8");
    refused(b, connector(7, 2), 7, "SetAxisMode: mode is 2; allowed are 0 to 1");
    refused(b, connector(7, -1), 7, "SetAxisMode: mode is -1; allowed are 0 to 1");
    refused(b, connector(8, 0), 7, "SetAxisMode: mode is 0; it must be 1");
    refused(b, SetAxisMode { core: 2.into(), ..connector(7, 1) }, 7, "SetAxisMode: core is 2; it must be 1");
    // Pulses do not reach a connector that carries steps; the analog output is another.
    for (channel, axis) in [(0i16, 7), (1, 8)] {
        let on = LaserOn { core: 1.into(), channel: channel.into() };
        for number in [0, 1, 3] {
            b.done(LaserPowerMode { channel: channel.into(), ..mode(number, 10.0, 0.0) });
            let text = format!(
                "laser channel {channel}: axis connector {axis} carries step pulses; call SetAxisMode({axis}, 1) first, or choose family lsr, where it is the laser's"
            );
            refused(b, on, 1, &format!("LaserOn: {text}"));
            let switch = SetHSIOOpt { channel: channel.into(), ..switch(1) };
            refused(b, switch, 1, &format!("SetHSIOOpt: {text}"));
            b.done(SetHSIOOpt { channel: channel.into(), value: 0.into(), core: 1.into() });
        }
        b.done(LaserPowerMode { channel: channel.into(), ..mode(2, 10.0, 0.0) });
        b.done(on);
        b.done(LaserOff { core: 1.into(), channel: channel.into() });
        b.done(mode(0, 100.0, 0.0));
        b.done(connector(axis, 1));
        b.done(LaserPowerMode { channel: channel.into(), ..mode(0, 10.0, 0.0) });
        b.done(on);
    }
    b.done(connector(7, 0));
    refused(
        b,
        switch(1),
        1,
        "SetHSIOOpt: laser channel 0: axis connector 7 carries step pulses; call SetAxisMode(7, 1) first, or choose family lsr, where it is the laser's",
    );
    // Not while its axis moves.
    b.servo_on(7);
    b.done(PrfJog { core: 1.into(), profile: 7.into() });
    let jog = SetJogPrm { core: 1.into(), profile: 7.into(), acc: 1.0.into(), dec: 1.0.into(), smooth: 0.0.into() };
    b.done(jog);
    b.done(SetVel { core: 1.into(), profile: 7.into(), vel: 5.0.into() });
    b.done(Update { core: 1.into(), mask: 0x40.into() });
    let answer = b.call(connector(7, 1));
    let text = describe_opcode(opcode::SetAxisMode, answer.refusal()).to_string();
    assert_eq!((answer.code, text.as_str()), (1, "SetAxisMode: axis 7 is moving; stop it first"));

    let mut bench = self::bench(LSR);
    let text = "SetAxisMode: the laser connectors of this family are fixed: it has no such call";
    refused(&mut bench, connector(7, 1), 8, text);
    bench.done(switch(1));
}

#[test]
fn analog_outputs_of_analog_channels_belong_to_them() {
    for family in [GUS, LSR] {
        let mut bench = bench(family);
        let set = |dac: i16, count: u16| {
            let items = vec![Short { value: 100.into() }; count.into()];
            body::<SetDac>(SetDac { core: 1.into(), dac: dac.into(), count: count.into() }, &items)
        };
        bench.done(LaserPowerMode { channel: 1.into(), ..mode(2, 5.0, 0.0) });
        let text = "SetDac: analog output 2 belongs to laser channel 1, which is in analog mode";
        refused_raw(&mut bench, opcode::SetDac, &set(2, 1), 1, text);
        refused_raw(&mut bench, opcode::SetDac, &set(1, 2), 1, text);
        assert_eq!(bench.machine.analog_out[0], 0, "half of a refused command was done");
        for right in [set(1, 1), set(3, 6)] {
            let tag = bench.post_raw(opcode::SetDac, Lane::Immediate, &right);
            assert_eq!(bench.wait(tag).code, 0);
        }
        bench.done(LaserPowerMode { channel: 1.into(), ..mode(0, 5.0, 0.0) });
        let tag = bench.post_raw(opcode::SetDac, Lane::Immediate, &set(2, 1));
        assert_eq!(bench.wait(tag).code, 0);
        assert_eq!(bench.machine.analog_out[..3], [100, 100, 100]);
    }
}

#[test]
fn maps_of_cores_are_apart() {
    let mut bench = Bench::<16>::new(1, 250);
    let get = |bench: &mut Bench<16>, core: i16, channel: i16| {
        bench.done(GetLaserCrdMap { core: core.into(), channel: channel.into() }).value.get()
    };
    // Power-on: every crd.
    for (core, channel) in [(1, 0), (1, 1), (2, 0), (2, 1)] {
        assert_eq!(get(&mut bench, core, channel), 3);
    }
    bench.done(SetLaserCrdMap { core: 2.into(), channel: 1.into(), map: 1.into() });
    bench.done(SetLaserCrdMap { core: 1.into(), channel: 1.into(), map: 0.into() });
    assert_eq!([get(&mut bench, 1, 0), get(&mut bench, 2, 0)], [3, 3]);
    assert_eq!([get(&mut bench, 1, 1), get(&mut bench, 2, 1)], [0, 1]);
    bench.done(Reset { core: 1.into() });
    assert_eq!([get(&mut bench, 1, 1), get(&mut bench, 2, 1)], [3, 3]);
}

#[test]
fn another_family_does_not_hide_why_the_last_run_ended() {
    let mut bench = bench(GUS);
    bench.tick.restarted();
    bench.run_ms(1);
    let fault = |bench: &mut Bench<8>| bench.done(GetLaserFault { core: 1.into(), channel: 0.into() }).value.get();
    assert_eq!(fault(&mut bench), 4);
    bench.done(Choose { profile: 0, family: LSR });
    bench.run_ms(1);
    assert_eq!(fault(&mut bench), 4);
    bench.done(Reset { core: 1.into() });
    bench.run_ms(1);
    assert_eq!(fault(&mut bench), 0);
}
