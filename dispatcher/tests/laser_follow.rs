//! Buffered laser commands, follow tables and distance follow in both families: refusals with their
//! texts, limited values and replies, tables that are in use. A command that fails leaves
//! everything as it was.
mod bench;
use bench::{Bench, body};
use protocol::command::*;
use protocol::reason::describe_opcode;
use protocol::record::Lane;

const GUS: u8 = 0;
const LSR: u8 = 1;

/// A controller with coordinate system 1 (X and Y by axes 1 and 2) at standstill, both lasers on
/// their connectors.
fn bench(family: u8) -> Bench<8> {
    let mut bench = Bench::gus();
    bench.done(Choose { profile: 0, family });
    for axis in [1, 2] {
        bench.servo_on(axis);
    }
    if family == GUS {
        for axis in [7, 8] {
            bench.done(SetAxisMode { core: 1.into(), axis: axis.into(), mode: 1.into() });
        }
    }
    let mut profile = [0.into(); 8];
    (profile[0], profile[1]) = (1.into(), 2.into());
    bench.done(SetCrdPrm {
        core: 1.into(),
        crd: 1.into(),
        dimension: 2.into(),
        profile,
        syn_vel_max: 500.0.into(),
        syn_acc_max: 10.0.into(),
        even_time_ms: 0.into(),
        set_origin_flag: 1.into(),
        origin_pos: [0.into(); 8],
    });
    bench
}

fn buf_on(crd: i16, fifo: i16, channel: i16) -> BufLaserOn {
    BufLaserOn { core: 1.into(), crd: crd.into(), fifo: fifo.into(), channel: channel.into() }
}

fn buf_off(crd: i16, fifo: i16, channel: i16) -> BufLaserOff {
    BufLaserOff { core: 1.into(), crd: crd.into(), fifo: fifo.into(), channel: channel.into() }
}

fn buf_power(power: f64) -> BufLaserPrfCmd {
    BufLaserPrfCmd { core: 1.into(), crd: 1.into(), power: power.into(), fifo: 0.into(), channel: 0.into() }
}

fn follow_off() -> BufLaserFollowOff {
    BufLaserFollowOff { core: 1.into(), crd: 1.into(), fifo: 0.into(), channel: 0.into() }
}

fn prf_follow(ratio: f64, min: i32, max: i32) -> BufLaserPrfFollow {
    BufLaserPrfFollow {
        core: 1.into(),
        crd: 1.into(),
        ratio: ratio.into(),
        min: min.into(),
        max: max.into(),
        fifo: 0.into(),
        channel: 0.into(),
    }
}

fn ratio_follow(ratio: f64, min: f64, max: f64) -> BufLaserFollowRatio {
    BufLaserFollowRatio {
        core: 1.into(),
        crd: 1.into(),
        ratio: ratio.into(),
        min: min.into(),
        max: max.into(),
        fifo: 0.into(),
        channel: 0.into(),
    }
}

fn follow_mode(source: i16, start: Option<f64>) -> BufLaserFollowMode {
    BufLaserFollowMode {
        core: 1.into(),
        crd: 1.into(),
        source: source.into(),
        fifo: 0.into(),
        channel: 0.into(),
        start_power: start.unwrap_or(0.0).into(),
        start_given: start.is_some().into(),
    }
}

fn table_follow(table: i16, min: f64, max: f64) -> BufLaserFollowTable {
    BufLaserFollowTable {
        core: 1.into(),
        crd: 1.into(),
        table: table.into(),
        min: min.into(),
        max: max.into(),
        fifo: 0.into(),
        channel: 0.into(),
    }
}

fn line(x: i32, y: i32, vel: f64) -> LnXY {
    LnXY {
        core: 1.into(),
        crd: 1.into(),
        x: x.into(),
        y: y.into(),
        syn_vel: vel.into(),
        syn_acc: 1.0.into(),
        vel_end: 0.0.into(),
        fifo: 0.into(),
    }
}

fn start() -> CrdStart {
    CrdStart { core: 1.into(), mask: 1.into(), option: 0.into() }
}

fn table(table: i16, count: i32, channel: i16, first: u16) -> SetLaserFollowTable {
    SetLaserFollowTable {
        core: 1.into(),
        table: table.into(),
        count: count.into(),
        channel: channel.into(),
        first: first.into(),
    }
}

fn points(given: &[(f64, f64)]) -> Vec<LaserFollowPoint> {
    given.iter().map(|(vel, power)| LaserFollowPoint { vel: (*vel).into(), power: (*power).into() }).collect()
}

fn distance(mode: i16, source: i16, scale: [f64; 4]) -> SetLaserDisMode {
    SetLaserDisMode {
        core: 1.into(),
        mode: mode.into(),
        source: source.into(),
        pos: [0.into(); 4],
        scale: scale.map(Into::into),
        channel: 0.into(),
    }
}

fn ratios(ratio: [f64; 4], bounds: Option<(f64, f64)>) -> SetLaserDisRatio {
    let (min, max) = bounds.unwrap_or((0.0, 0.0));
    SetLaserDisRatio {
        core: 1.into(),
        ratio: ratio.map(Into::into),
        min: min.into(),
        max: max.into(),
        channel: 0.into(),
        bounds_given: bounds.is_some().into(),
    }
}

fn lines(count: i16, limit: Option<[f64; 4]>, first: u16) -> SetLaserDisTable1D {
    SetLaserDisTable1D {
        core: 1.into(),
        count: count.into(),
        min: 0.0.into(),
        max: 100.0.into(),
        limit: limit.unwrap_or([0.0; 4]).map(Into::into),
        channel: 0.into(),
        limits_given: limit.is_some().into(),
        first: first.into(),
    }
}

fn on_lines(given: &[(f64, i32)]) -> Vec<LaserDisPoint> {
    given.iter().map(|(ratio, pos)| LaserDisPoint { ratio: (*ratio).into(), pos: (*pos).into() }).collect()
}

fn plane(axis: [i16; 2], count: [i16; 2], first: u16) -> SetLaserDisTable2D {
    SetLaserDisTable2D {
        core: 1.into(),
        axis: axis.map(Into::into),
        count: count.map(Into::into),
        min: 0.0.into(),
        max: 100.0.into(),
        limit: [0.0.into(); 2],
        channel: 0.into(),
        limits_given: 0,
        first: first.into(),
    }
}

fn in_plane(given: &[f64]) -> Vec<LaserDisValue> {
    given.iter().map(|value| LaserDisValue { value: (*value).into() }).collect()
}

/// All visible state of lasers and coordinate systems, and the number of the last entry: a refused
/// command pushes none.
fn state(bench: &mut Bench<8>) -> String {
    let mut spaces = Vec::new();
    for crd in [1, 2] {
        for fifo in [0, 1] {
            let space = bench.call(CrdSpace { core: 1.into(), crd: crd.into(), fifo: fifo.into() });
            spaces.push((space.code, space.body));
        }
    }
    let view = bench.server.view();
    let mut lasers = view.lasers;
    lasers.iter_mut().for_each(|laser| (laser.on_time, laser.moves) = (0, 0));
    format!("{spaces:?} {} {lasers:?}", view.done_immediate)
}

/// Refused with this code and text, and nothing has changed.
#[track_caller]
fn refused<R: Request>(bench: &mut Bench<8>, request: R, items: &[R::Item], code: i16, text: &str) {
    let before = state(bench);
    let tag = bench.post_raw(R::OPCODE, Lane::Immediate, &body::<R>(request, items));
    let answer = bench.wait(tag);
    assert_ne!(answer.code, 0, "not refused; {text}");
    assert_eq!(describe_opcode(R::OPCODE, answer.refusal()).to_string(), text);
    assert_eq!(answer.code, code, "{text}");
    bench.run_ms(1);
    assert_eq!(state(bench), before, "{text}");
}

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
        refused(b, core, &[], 7, "BufLaserOff: core is 2; allowed are 1 to 1");
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

fn duty() -> LaserPowerMode {
    LaserPowerMode {
        core: 1.into(),
        mode: 0.into(),
        max: 100.0.into(),
        min: 0.0.into(),
        channel: 0.into(),
        delay_mode: 0.into(),
    }
}

#[test]
fn lsr_takes_the_nearest_bound_and_tells_it() {
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
fn a_read_of_analog_outputs_tells_what_is_output() {
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
fn a_width_that_reaches_the_period_is_told_of_entries_too() {
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
fn every_entry_takes_a_place_and_the_reply_tells_it() {
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
    let text = "BufLaserOn: coordinate system 1: the FIFO is full; 1024 entries fit, 0 are free";
    refused(b, buf_on(1, 0, 0), &[], 1, text);
}

#[test]
fn follow_tables_are_checked_point_by_point() {
    for family in [GUS, LSR] {
        let mut bench = bench(family);
        let b = &mut bench;
        let two = points(&[(0.0, 1.0), (10.0, 2.0)]);
        refused(b, table(0, 2, 0, 0), &two, 7, "SetLaserFollowTable: table is 0; allowed are 1 to 8");
        refused(b, table(9, 2, 0, 0), &two, 7, "SetLaserFollowTable: table is 9; allowed are 1 to 8");
        refused(b, table(1, 2, 2, 0), &two, 7, "SetLaserFollowTable: channel is 2; allowed are 0 to 1");
        refused(b, table(1, 0, 0, 0), &[], 7, "SetLaserFollowTable: count is 0; it must be from 1 to 32");
        refused(b, table(1, 33, 0, 0), &two, 7, "SetLaserFollowTable: count is 33; it must be from 1 to 32");
        refused(b, table(1, -1, 0, 0), &[], 7, "SetLaserFollowTable: count is -1; it must be from 1 to 32");
        for (given, text) in [
            ([(0.0, 1.0), (0.0, 2.0)], "vel is 0; it must be greater than 0, that of the point before (item 2)"),
            ([(10.0, 1.0), (9.5, 2.0)], "vel is 9.5; it must be greater than 10, that of the point before (item 2)"),
            ([(-1.0, 1.0), (9.5, 2.0)], "vel is -1; it must be from 0 to 4294967296 (item 1)"),
            ([(0.0, 1.0), (f64::NAN, 2.0)], "vel is not a finite number (item 2)"),
            ([(0.0, f64::NAN), (1.0, 2.0)], "power is not a finite number (item 1)"),
        ] {
            refused(b, table(1, 2, 0, 0), &points(&given), 7, &format!("SetLaserFollowTable: {text}"));
        }
        if family == GUS {
            let text = "SetLaserFollowTable: power is 101; it must be from 0 to 100 (item 2)";
            refused(b, table(1, 2, 0, 0), &points(&[(0.0, 1.0), (1.0, 101.0)]), 7, text);
        }
        // They are not stored.
        let text = "BufLaserFollowTable: follow table 1 of laser channel 0 is empty; call SetLaserFollowTable first";
        refused(b, table_follow(1, 0.0, 1.0), &[], 1, text);
        // Chunks in order; one that does not continue the one before is refused.
        let text = "SetLaserFollowTable: first is 1; it must be from 0 to 0";
        refused(b, table(1, 2, 0, 1), &two[1..], 7, text);
        b.call_items(table(1, 2, 0, 0), &two[..1]).reply::<SetLaserFollowTable>();
        b.call_items(table(1, 2, 0, 1), &two[1..]).reply::<SetLaserFollowTable>();
        b.done(table_follow(1, 0.0, 1.0));
        // Channel 1 has tables of its own.
        let text = "BufLaserFollowTable: follow table 1 of laser channel 1 is empty; call SetLaserFollowTable first";
        refused(b, BufLaserFollowTable { channel: 1.into(), ..table_follow(1, 0.0, 1.0) }, &[], 1, text);
    }
}

#[test]
fn a_follow_table_in_use_is_not_replaced() {
    let mut bench = bench(GUS);
    let b = &mut bench;
    let points = points(&[(0.0, 1.0), (10.0, 2.0)]);
    for number in [1, 2] {
        b.call_items(table(number, 2, 0, 0), &points).reply::<SetLaserFollowTable>();
    }
    // No entry names it: it may be replaced.
    b.call_items(table(1, 2, 0, 0), &points).reply::<SetLaserFollowTable>();
    b.done(table_follow(1, 0.0, 50.0));
    b.done(line(1000, 0, 10.0));
    let text = "SetLaserFollowTable: follow table 1 of laser channel 0 is named by an entry of a path or by the follow in force; it can be replaced when neither is there";
    refused(b, table(1, 2, 0, 0), &points, 1, text);
    b.call_items(table(2, 2, 0, 0), &points).reply::<SetLaserFollowTable>();
    b.done(start());
    b.run_ms(20);
    refused_running(b, table(1, 2, 0, 0), &points, text);
    b.run_ms(200);
    // The path is over, its follow is not.
    refused(b, table(1, 2, 0, 0), &points, 1, text);
    b.done(Stop { core: 1.into(), mask: (1 << 10).into(), option: 0.into(), form: 1 });
    b.run_ms(1);
    b.call_items(table(1, 2, 0, 0), &points).reply::<SetLaserFollowTable>();
    // A cleared FIFO names nothing.
    b.done(table_follow(1, 0.0, 50.0));
    refused(b, table(1, 2, 0, 0), &points, 1, text);
    b.done(CrdClear { core: 1.into(), crd: 1.into(), fifo: 0.into() });
    b.call_items(table(1, 2, 0, 0), &points).reply::<SetLaserFollowTable>();
}

/// As `refused`, during motion.
#[track_caller]
fn refused_running<R: Request>(bench: &mut Bench<8>, request: R, items: &[R::Item], text: &str) {
    let answer = bench.call_items(request, items);
    assert_eq!(answer.code, 1, "{text}");
    assert_eq!(describe_opcode(R::OPCODE, answer.refusal()).to_string(), text);
}

#[test]
fn distance_follow_is_checked() {
    for family in [GUS, LSR] {
        let mut bench = bench(family);
        let b = &mut bench;
        let scale = [1000.0; 4];
        refused(b, distance(2, 0, scale), &[], 7, "SetLaserDisMode: mode is 2; allowed are 0 to 1");
        refused(b, distance(1, 2, scale), &[], 7, "SetLaserDisMode: source is 2; allowed are 0 to 1");
        refused(
            b,
            SetLaserDisMode { channel: 2.into(), ..distance(1, 0, scale) },
            &[],
            7,
            "SetLaserDisMode: channel is 2; allowed are 0 to 1",
        );
        let text = "SetLaserDisMode: scale is not a finite number (item 3)";
        refused(b, distance(1, 0, [1.0, 1.0, f64::NAN, 1.0]), &[], 7, text);
        if family == GUS {
            let text = "SetLaserDisMode: scale is 0; it must be from 0.000003814697265625 to 4294967296 (item 2)";
            refused(b, distance(1, 0, [1.0, 0.0, 1.0, 1.0]), &[], 7, text);
            let text = "SetLaserDisMode: scale is -5; it must be from 0.000003814697265625 to 4294967296 (item 4)";
            refused(b, distance(1, 0, [1.0, 1.0, 1.0, -5.0]), &[], 7, text);
        }
        // Ratios need a follow that is on.
        let off = "laser channel 0: distance follow is off; call SetLaserDisMode(1, ...) first";
        refused(b, ratios([0.1; 4], None), &[], 1, &format!("SetLaserDisRatio: {off}"));
        refused(b, lines(1, None, 0), &on_lines(&[(0.1, 0); 4]), 1, &format!("SetLaserDisTable1D: {off}"));
        refused(b, plane([1, 2], [1, 1], 0), &in_plane(&[0.0, 0.0, 0.1]), 1, &format!("SetLaserDisTable2D: {off}"));
        b.done(distance(1, 0, scale));
        let text = "SetLaserDisRatio: ratio is not a finite number (item 2)";
        refused(b, ratios([0.1, f64::NAN, 0.1, 0.1], None), &[], 7, text);
        let text = "SetLaserDisRatio: ratio is 131073; it must be from -131072 to 131072 (item 4)";
        refused(b, ratios([0.1, 0.1, 0.1, 131_073.0], None), &[], 7, text);
        let bounds = Some((20.0, 10.0));
        if family == GUS {
            let text = "SetLaserDisRatio: max is 10; it must not be below the minimum, 20";
            refused(b, ratios([0.1; 4], bounds), &[], 7, text);
            let text = "SetLaserDisRatio: max is 101; it must be from 0 to 100";
            refused(b, ratios([0.1; 4], Some((0.0, 101.0))), &[], 7, text);
            // Equal ones are bounds too. Those that are not given stay.
            let reported = b.done(ratios([0.0, -1.0, 131_072.0, 0.1], Some((10.0, 10.0))));
            assert_eq!((reported.max.get(), reported.min.get(), reported.held), (10.0, 10.0, 0));
            let reported = b.done(ratios([0.1; 4], None));
            assert_eq!((reported.max.get(), reported.min.get()), (10.0, 10.0));
            // On again: without bounds of its own, those of the mode hold.
            b.done(distance(1, 0, scale));
            let reported = b.done(ratios([0.1; 4], None));
            assert_eq!((reported.max.get(), reported.min.get()), (100.0, 0.0));
        } else {
            // LSR ignores them.
            let reported = b.done(ratios([0.1; 4], bounds));
            assert_eq!((reported.max.get(), reported.min.get(), reported.held), (100.0, 0.0, 0));
        }
        b.done(distance(0, 0, [f64::NAN; 4]));
        refused(b, ratios([0.1; 4], None), &[], 1, &format!("SetLaserDisRatio: {off}"));
    }
}

#[test]
fn tables_of_ratios_are_checked_point_by_point() {
    for family in [GUS, LSR] {
        let mut bench = bench(family);
        let b = &mut bench;
        b.done(distance(1, 0, [1000.0; 4]));
        let eight = [(0.1, 0), (0.2, 10), (0.1, 0), (0.2, 10), (0.1, 0), (0.2, 10), (0.1, 0), (0.2, 10)];
        let with = |index: usize, point: (f64, i32)| {
            let mut points = eight;
            points[index] = point;
            on_lines(&points)
        };
        let is = |text: &str| format!("SetLaserDisTable1D: {text}");
        refused(b, lines(0, None, 0), &[], 7, &is("count is 0; it must be from 1 to 32"));
        refused(b, lines(33, None, 0), &with(0, (0.1, 0)), 7, &is("count is 33; it must be from 1 to 32"));
        let text = is("pos of axis 3 is 0; it must be greater than 0, that of the point before (item 2)");
        refused(b, lines(2, None, 0), &with(5, (0.1, 0)), 7, &text);
        let text = is("ratio is not a finite number (item 1)");
        refused(b, lines(2, None, 0), &with(4, (f64::NAN, 0)), 7, &text);
        let text = is("ratio is -200000; it must be from -131072 to 131072 (item 2)");
        refused(b, lines(2, None, 0), &with(7, (-2e5, 10)), 7, &text);
        let text = is("limit is not a finite number (item 2)");
        refused(b, lines(2, Some([1.0, f64::NAN, 1.0, 1.0]), 0), &on_lines(&eight), 7, &text);
        let text = is("the command's length is wrong: 165 bytes came, 153 were expected");
        let nine: Vec<(f64, i32)> = eight.iter().copied().chain([(0.1, 50)]).collect();
        refused(b, lines(2, None, 0), &on_lines(&nine), 7, &text);
        if family == GUS {
            let text = is("limit is 101; it must be from 0 to 100 (item 1)");
            refused(b, lines(2, Some([101.0, 1.0, 1.0, 1.0]), 0), &on_lines(&eight), 7, &text);
        }
        b.call_items(lines(2, None, 0), &on_lines(&eight)).reply::<SetLaserDisTable1D>();
        // A few at a time; then another order.
        b.call_items(lines(2, None, 0), &on_lines(&eight[..3])).reply::<SetLaserDisTable1D>();
        let text = is("first is 4; it must be from 0 to 3");
        refused(b, lines(2, None, 4), &on_lines(&eight[4..]), 7, &text);
        b.call_items(lines(2, None, 3), &on_lines(&eight[3..])).reply::<SetLaserDisTable1D>();

        let is = |text: &str| format!("SetLaserDisTable2D: {text}");
        let good = [0.0, 10.0, -5.0, 5.0, 0.1, 0.2, 0.3, 0.4];
        let with = |index: usize, value: f64| {
            let mut values = good;
            values[index] = value;
            in_plane(&values)
        };
        let (all, one) = (in_plane(&good), [2, 2]);
        refused(b, plane([0, 2], one, 0), &all, 7, &is("axis is 0; allowed are 1 to 4 (item 1)"));
        refused(b, plane([1, 5], one, 0), &all, 7, &is("axis is 5; allowed are 1 to 4 (item 2)"));
        refused(b, plane([2, 2], one, 0), &all, 7, &is("axis names axis 2 twice; a plane has two"));
        refused(b, plane([1, 2], [0, 2], 0), &all, 7, &is("count is 0; it must be from 1 to 32 (item 1)"));
        refused(b, plane([1, 2], [2, 33], 0), &all, 7, &is("count is 33; it must be from 1 to 32 (item 2)"));
        refused(b, plane([1, 2], [32, 9], 0), &all, 7, &is("count is 288; at most 256 fit"));
        let text = "must be a whole number of pulses, greater than";
        let x = format!("a position of X is 0; it {text} 0, that of the point before (item 2)");
        refused(b, plane([1, 2], one, 0), &with(1, 0.0), 7, &is(&x));
        let y = format!("a position of Y is -6; it {text} -5, that of the point before (item 2)");
        refused(b, plane([1, 2], one, 0), &with(3, -6.0), 7, &is(&y));
        let half = format!("a position of X is 10.5; it {text} 0, that of the point before (item 2)");
        refused(b, plane([1, 2], one, 0), &with(1, 10.5), 7, &is(&half));
        refused(b, plane([1, 2], one, 0), &with(6, f64::INFINITY), 7, &is("value is not a finite number (item 3)"));
        b.call_items(plane([1, 2], one, 0), &all).reply::<SetLaserDisTable2D>();
    }
}

#[test]
fn ratios_change_while_they_are_in_force() {
    // Two banks: the third change of one instant has to wait for the first, which acts at that
    // instant.
    let mut bench = bench(GUS);
    let b = &mut bench;
    b.done(distance(1, 0, [1000.0; 4]));
    let table = |ratio: f64| on_lines(&[(ratio, 0); 4]);
    for ratio in [1.0, 2.0, 3.0, 4.0, 5.0] {
        b.call_items(lines(1, None, 0), &table(ratio)).reply::<SetLaserDisTable1D>();
    }
    let mut entries: Vec<_> = [1.0, 2.0, 3.0, 4.0]
        .map(|ratio| {
            (SetLaserDisTable1D::OPCODE, Lane::Program, body::<SetLaserDisTable1D>(lines(1, None, 0), &table(ratio)))
        })
        .to_vec();
    entries.push(bench::entry(ProgramEnd {}));
    let tags = b.post_all(&entries);
    b.done(ProgramStart { strict: 0 });
    for tag in tags {
        assert_eq!(b.wait(tag).code, 0);
    }
    b.run_ms(1);
    assert!(b.server.view().lasers[0].bank.is_some());
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

#[track_caller]
fn refused_running_code<R: Request>(bench: &mut Bench<8>, request: R, code: i16, text: &str) {
    let answer = bench.call(request);
    assert_eq!(answer.code, code, "{text}");
    assert_eq!(describe_opcode(R::OPCODE, answer.refusal()).to_string(), text);
}
