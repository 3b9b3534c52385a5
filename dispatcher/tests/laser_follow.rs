//! Buffered laser commands and follows in both families: refusals with their texts, limited values
//! and replies. A command that fails leaves everything as it was.
use crate::{bench, laser_path};
use bench::Bench;
use laser_path::*;
use protocol::command::*;

#[test]
fn what_both_families_refuse_of_buffered_commands() {
    for family in [GUS, LSR] {
        let mut bench = bench(family);
        let b = &mut bench;
        refused(b, buf_on(3, 0, 0), &[], 7, "BufLaserOn: crd is 3; allowed are 1 to 2");
        refused(b, buf_on(0, 0, 0), &[], 7, "BufLaserOn: crd is 0; allowed are 1 to 2");
        refused(b, buf_on(1, 2, 0), &[], 7, "BufLaserOn: fifo is 2; allowed are 0 to 1");
        refused(b, buf_on(1, 0, 2), &[], 7, "BufLaserOn: channel is 2; allowed are 0 to 1");
        refused(b, buf_off(1, -1, 0), &[], 7, "BufLaserOff: fifo is -1; allowed are 0 to 1");
        refused(b, buf_off(1, 0, -1), &[], 7, "BufLaserOff: channel is -1; allowed are 0 to 1");
        let core = BufLaserOff { core: 2.into(), ..buf_off(1, 0, 0) };
        refused(b, core, &[], 7, "BufLaserOff: core is 2; it must be 1");
        refused(b, buf_on(2, 0, 0), &[], 1, "BufLaserOn: coordinate system 2 drives no axis; call SetCrdPrm first");
        refused(b, buf_power(f64::NAN), &[], 7, "BufLaserPrfCmd: power is not a finite number");
        refused(b, buf_power(f64::INFINITY), &[], 7, "BufLaserPrfCmd: power is not a finite number");
        for ratio in [0.0, -0.1, -f64::MIN_POSITIVE] {
            let shown = if ratio == -0.1 { "-0.1".into() } else { format!("{ratio:e}").replace("0e0", "0") };
            let text = format!("BufLaserPrfFollow: ratio is {shown}; it must be above 0 and at most 4294967296");
            refused(b, prf_follow(ratio, 10, 100), &[], 7, &text);
            let text = format!("BufLaserFollowRatio: ratio is {shown}; it must be above 0 and at most 4294967296");
            refused(b, ratio_follow(ratio, 10.0, 100.0), &[], 7, &text);
        }
        refused(b, ratio_follow(f64::NAN, 0.0, 1.0), &[], 7, "BufLaserFollowRatio: ratio is not a finite number");
        refused(b, ratio_follow(0.1, f64::NAN, 1.0), &[], 7, "BufLaserFollowRatio: min is not a finite number");
        refused(b, ratio_follow(0.1, 0.0, f64::NAN), &[], 7, "BufLaserFollowRatio: max is not a finite number");
        let text = "BufLaserFollowRatio: max is 10; it must be above the minimum, 10";
        refused(b, ratio_follow(0.1, 10.0, 10.0), &[], 7, text);
        let text = "BufLaserPrfFollow: max is 10; it must be above the minimum, 20";
        refused(b, prf_follow(0.1, 20, 10), &[], 7, text);
        // Also where both are beyond the range.
        let text = "BufLaserFollowRatio: max is 150; it must be above the minimum, 200";
        refused(b, ratio_follow(0.1, 200.0, 150.0), &[], 7, text);
        refused(b, follow_mode(2, None), &[], 7, "BufLaserFollowMode: source is 2; allowed are 0 to 1");
        refused(b, follow_mode(-1, None), &[], 7, "BufLaserFollowMode: source is -1; allowed are 0 to 1");
        let text = "BufLaserFollowMode: start_power is not a finite number";
        refused(b, follow_mode(0, Some(f64::NAN)), &[], 7, text);
        refused(b, table_follow(0, 0.0, 1.0), &[], 7, "BufLaserFollowTable: table is 0; allowed are 1 to 8");
        refused(b, table_follow(9, 0.0, 1.0), &[], 7, "BufLaserFollowTable: table is 9; allowed are 1 to 8");
        let text = "BufLaserFollowTable: follow table 3 of laser channel 0 is empty; call SetLaserFollowTable first";
        refused(b, table_follow(3, 0.0, 1.0), &[], 1, text);
    }
}

#[test]
fn gus_refuses_powers_out_of_range() {
    let mut bench = bench(GUS);
    let b = &mut bench;
    refused(b, buf_power(-1.0), &[], 7, "BufLaserPrfCmd: power is -1; it must be from 0 to 100");
    refused(b, buf_power(100.5), &[], 7, "BufLaserPrfCmd: power is 100.5; it must be from 0 to 100");
    refused(b, prf_follow(0.1, -1, 100), &[], 7, "BufLaserPrfFollow: min is -1; it must be from 0 to 100");
    refused(b, prf_follow(0.1, 1, 101), &[], 7, "BufLaserPrfFollow: max is 101; it must be from 0 to 100");
    refused(b, ratio_follow(0.1, 1.0, 100.5), &[], 7, "BufLaserFollowRatio: max is 100.5; it must be from 0 to 100");
    let text = "BufLaserFollowMode: start_power is 101; it must be from 0 to 100";
    refused(b, follow_mode(0, Some(101.0)), &[], 7, text);
    // Both ends belong to the range, though the manual prints round brackets.
    assert_eq!(b.done(buf_power(0.0)).value.get(), 0.0);
    assert_eq!(b.done(buf_power(100.0)).value.get(), 100.0);
    let reported = b.done(prf_follow(0.1, 0, 100));
    assert_eq!((reported.min.get(), reported.max.get(), reported.held), (0.0, 100.0, 0));
    // Ranges are those of the mode: kHz here.
    b.done(LaserPowerMode { mode: 1.into(), max: 2000.0.into(), ..duty() });
    assert_eq!(b.done(buf_power(2000.0)).value.get(), 2000.0);
    refused(b, buf_power(2000.5), &[], 7, "BufLaserPrfCmd: power is 2000.5; it must be from 0 to 2000");
    // Without its connector there would be no light.
    b.done(LaserPowerMode { max: 100.0.into(), ..duty() });
    b.done(SetAxisMode { core: 1.into(), axis: 7.into(), mode: 0.into() });
    let text = "BufLaserOn: laser channel 0: axis connector 7 carries step pulses; call SetAxisMode(7, 1) first, or choose family lsr, where it is the laser's";
    refused(b, buf_on(1, 0, 0), &[], 1, text);
    b.done(LaserPowerMode { mode: 2.into(), max: 10.0.into(), ..duty() });
    b.done(buf_on(1, 0, 0));
}

#[test]
fn lsr_takes_the_nearest_bound_and_reports_it() {
    let mut bench = bench(LSR);
    let b = &mut bench;
    let reported = b.done(buf_power(120.0));
    assert_eq!((reported.value.get(), reported.held), (100.0, 1));
    let reported = b.done(buf_power(-3.0));
    assert_eq!((reported.value.get(), reported.held), (0.0, 1));
    let reported = b.done(buf_power(50.0));
    assert_eq!((reported.value.get(), reported.held), (50.0, 0));
    // Bit 0 is the maximum, bit 1 the minimum.
    let reported = b.done(prf_follow(0.1, -5, 150));
    assert_eq!((reported.max.get(), reported.min.get(), reported.held), (100.0, 0.0, 3));
    let reported = b.done(ratio_follow(0.1, 20.0, 150.0));
    assert_eq!((reported.max.get(), reported.min.get(), reported.held), (100.0, 20.0, 1));
    // After limitation both bounds may be equal; as given, the maximum is above.
    let reported = b.done(ratio_follow(0.1, 110.0, 150.0));
    assert_eq!((reported.max.get(), reported.min.get(), reported.held), (100.0, 100.0, 3));
    let reported = b.done(follow_mode(1, Some(101.0)));
    assert_eq!((reported.value.get(), reported.held), (100.0, 1));
    let reported = b.done(follow_mode(1, None));
    assert_eq!((reported.value.get(), reported.held), (0.0, 0));
    let reported = b.call_items(table(1, 3, 0, 0), &points(&[(0.0, -1.0), (10.0, 50.0), (20.0, 101.0)]));
    assert_eq!(reported.reply::<SetLaserFollowTable>().held.get(), 2);
    // Scales from 1 to 65536.
    let reported = b.done(distance(1, 0, [0.0, 1000.0, 70_000.0, -4.0]));
    assert_eq!(({ reported.scale }.map(f64::from), reported.held), ([1.0, 1000.0, 65_536.0, 1.0], 0b1101));
}

/// GetDac reads the output: of a call, of a path, of a laser.
#[test]
fn a_read_of_analog_outputs_reports_what_is_output() {
    fn outputs(bench: &mut Bench<8>) -> Vec<i16> {
        let read = GetDac { core: 1.into(), dac: 1.into(), count: 4.into() };
        bench.call(read).items::<GetDac>().iter().map(|item| item.value.get()).collect()
    }
    let mut bench = bench(GUS);
    let b = &mut bench;
    let given = [700.into(), (-5).into()].map(|value| Short { value });
    b.call_items(SetDac { core: 1.into(), dac: 1.into(), count: 2.into() }, &given).reply::<SetDac>();
    assert_eq!(outputs(b), [700, -5, 0, 0]);
    // 60 pulses at 10 pulse/ms, then the path's value.
    b.done(line(60, 0, 10.0));
    b.done(BufDA { core: 1.into(), crd: 1.into(), channel: 3.into(), value: (-12_000).into(), fifo: 0.into() });
    b.done(BufDA { core: 1.into(), crd: 1.into(), channel: 2.into(), value: 44.into(), fifo: 0.into() });
    b.done(line(600, 0, 10.0));
    assert_eq!(outputs(b), [700, -5, 0, 0], "the path has not come there");
    b.done(start());
    b.run_ms(100);
    assert_eq!(outputs(b), [700, 44, -12_000, 0]);
    // A laser in analog mode takes its output, and leaves it at 0 V.
    b.done(LaserPowerMode { mode: 2.into(), max: 10.0.into(), ..duty() });
    b.done(SetPreVltg { core: 1.into(), mode: 1.into(), voltage: 2.5.into(), channel: 0.into() });
    b.run_ms(1);
    assert_eq!(outputs(b), [8192, 44, -12_000, 0], "2.5 V");
    b.done(duty());
    b.run_ms(1);
    assert_eq!(outputs(b), [0, 44, -12_000, 0]);
}

/// Entries of a path against the pulse width: reported for the power, and for the highest power of
/// a follow.
#[test]
fn a_width_that_reaches_the_period_is_reported_of_entries_too() {
    const LIMITED: u8 = 0x80;
    for family in [GUS, LSR] {
        let mut bench = bench(family);
        let b = &mut bench;
        b.done(LaserPowerMode { mode: 1.into(), max: 24.0.into(), ..duty() });
        b.done(SetPulseWidth { core: 1.into(), width_us: 50.into(), channel: 0.into() });
        assert_eq!(b.done(buf_power(19.0)).held, 0);
        assert_eq!(b.done(buf_power(20.0)).held, LIMITED);
        assert_eq!(b.done(follow_mode(0, Some(20.0))).held, LIMITED);
        assert_eq!(b.done(follow_mode(0, None)).held, 0);
        assert_eq!(b.done(prf_follow(0.1, 0, 19)).held, 0);
        assert_eq!(b.done(prf_follow(0.1, 0, 20)).held, LIMITED);
        assert_eq!(b.done(ratio_follow(0.1, 0.0, 19.9)).held, 0);
        assert_eq!(b.done(ratio_follow(0.1, 0.0, 20.5)).held, LIMITED);
        // The bounds of the mode limit the rate.
        b.done(LaserPowerMode { mode: 1.into(), max: 19.0.into(), ..duty() });
        assert_eq!(b.done(buf_power(20.0)).held, 0);
        assert_eq!(b.done(ratio_follow(0.1, 0.0, 20.5)).held, 0);
        // In a duty mode there is no width.
        b.done(duty());
        assert_eq!(b.done(buf_power(50.0)).held, 0);
    }
}

#[test]
fn a_rate_below_1_hz_is_refused_of_entries_too() {
    for (family, high) in [(GUS, 2000), (LSR, 24)] {
        let mut bench = bench(family);
        let b = &mut bench;
        b.done(LaserPowerMode { mode: 1.into(), max: 24.0.into(), ..duty() });
        let text = format!("is 0.0005 kHz; it must be 0, or from 0.001 to {high}");
        refused(b, buf_power(0.0005), &[], 7, &format!("BufLaserPrfCmd: power {text}"));
        refused(b, follow_mode(0, Some(0.0005)), &[], 7, &format!("BufLaserFollowMode: start_power {text}"));
        assert_eq!(b.done(buf_power(0.0)).held, 0);
        assert_eq!(b.done(buf_power(0.001)).held, 0);
    }
}

#[test]
fn every_entry_takes_a_slot_and_the_reply_reports_it() {
    let mut bench = bench(GUS);
    let b = &mut bench;
    let space = |b: &mut Bench<8>| b.done(CrdSpace { core: 1.into(), crd: 1.into(), fifo: 0.into() }).value.get();
    assert_eq!(space(b), 1024);
    let taken = b.done(buf_on(1, 0, 0));
    assert_eq!((taken.taken.get(), taken.space.get()), (1, 1023));
    b.done(buf_power(1.0));
    b.done(prf_follow(0.1, 1, 2));
    b.done(ratio_follow(0.1, 1.0, 2.0));
    b.done(follow_mode(0, None));
    assert_eq!(b.done(follow_off()).space.get(), 1018);
    assert_eq!(b.done(buf_off(1, 0, 0)).space.get(), 1017);
    assert_eq!(space(b), 1017);
    for _ in 0..1017 {
        b.done(buf_off(1, 0, 0));
    }
    let text = "BufLaserOn: coordinate system 1: the FIFO is full; 1024 entries fit";
    refused(b, buf_on(1, 0, 0), &[], 1, text);
}

#[test]
fn the_power_mode_stays_while_a_path_of_its_core_runs() {
    let mut bench = bench(GUS);
    let b = &mut bench;
    b.done(buf_power(10.0));
    b.done(line(1000, 0, 10.0));
    b.done(duty());
    b.done(start());
    b.run_ms(5);
    refused_running(b, duty(), &[], "LaserPowerMode: coordinate system 1 is running; stop it first");
    b.run_ms(200);
    b.done(duty());
}

#[test]
fn clr_sts_clears_the_channel_that_the_axis_gates() {
    let mut bench = bench(GUS);
    let b = &mut bench;
    let fault =
        |b: &mut Bench<8>, channel: i16| b.done(GetLaserFault { core: 1.into(), channel: channel.into() }).value.get();
    let clear = |axis: i16| ClrSts { core: 1.into(), axis: axis.into(), count: 1.into() };
    // Channel 1 belongs to coordinate system 2, which has no axes.
    b.done(SetLaserCrdMap { core: 1.into(), channel: 1.into(), map: 2.into() });
    b.machine.interlock = true;
    b.run_ms(1);
    b.machine.interlock = false;
    b.run_ms(1);
    assert_eq!([fault(b, 0), fault(b, 1)], [1, 1]);
    b.done(clear(3));
    b.run_ms(1);
    assert_eq!([fault(b, 0), fault(b, 1)], [1, 1]);
    b.done(clear(2));
    b.run_ms(1);
    assert_eq!([fault(b, 0), fault(b, 1)], [0, 1]);
}

#[test]
fn stop_ends_a_follow_and_nothing_else() {
    let mut bench = bench(LSR);
    let b = &mut bench;
    b.done(LaserOutFrq { core: 1.into(), frequency: 10.0.into(), channel: 0.into() });
    b.done(ratio_follow(1.0, 10.0, 100.0));
    b.done(buf_on(1, 0, 0));
    b.done(line(2000, 0, 10.0));
    b.done(start());
    b.run_ms(100);
    let power = |b: &mut Bench<8>| b.done(GetLaserPower { core: 1.into(), channel: 0.into() }).value.get();
    assert_eq!(power(b), 20.0);
    // Bit 11 is coordinate system 2's.
    b.done(Stop { core: 1.into(), mask: (1 << 11).into(), option: 0.into(), form: 1 });
    b.run_ms(1);
    assert_eq!(power(b), 20.0);
    b.done(Stop { core: 1.into(), mask: (1 << 10).into(), option: 0.into(), form: 1 });
    b.run_ms(1);
    assert_eq!(power(b), 0.0);
    let view = b.server.view();
    assert!(view.crds[0].runs && view.lasers[0].light, "the path goes on, and its light");
    let text = "Stop: mask is 4096; it must be from 0 to 4095";
    refused_running_code(b, Stop { core: 1.into(), mask: (1 << 12).into(), option: 0.into(), form: 1 }, 7, text);
}
