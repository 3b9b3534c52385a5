//! The laser calls: every form, both manuals' parameter counts, defaults; what is left to the
//! controller.
use job::{Action, Call, Files, Job, compile};
use protocol::command as c;
use protocol::command::Request;
use zerocopy::FromBytes;

struct NoFiles;

impl Files for NoFiles {
    fn text(&self, path: &str) -> Result<String, String> {
        Err(path.to_owned())
    }
}

fn good(text: &str) -> Job {
    compile(text, &NoFiles).unwrap_or_else(|found| panic!("{text}\n{found:#?}"))
}

fn last(text: &str) -> Call {
    let steps = good(text).steps;
    steps
        .into_iter()
        .filter_map(|step| match step.action {
            Action::Call(call) => Some(call),
            _ => None,
        })
        .next_back()
        .expect("a call")
}

fn request<R: Request>(text: &str) -> R {
    let call = last(text);
    assert_eq!(call.opcode, R::OPCODE, "{text}");
    R::read_from_bytes(&call.body).unwrap_or_else(|_| panic!("{text}: {} bytes", call.body.len()))
}

#[test]
fn power_mode_takes_the_parameters_of_both_manuals() {
    let mode = |text: &str| {
        let r: c::LaserPowerMode = request(text);
        (r.core.get(), r.mode.get(), r.max.get(), r.min.get(), r.channel.get(), r.delay_mode.get())
    };
    // GUS: four parameters; LSR: five; the header's defaults.
    assert_eq!(mode("rtn = GT_LaserPowerMode(0,100,10,0);"), (1, 0, 100.0, 10.0, 0, 0));
    assert_eq!(mode("rtn =GT_LaserPowerMode(0,100,10,1,1);"), (1, 0, 100.0, 10.0, 1, 1));
    assert_eq!(mode("GT_LaserPowerMode(LASER_CTRL_MODE_PWM2,100,10);"), (1, 3, 100.0, 10.0, 0, 0));
    assert_eq!(mode("GTN_LaserPowerMode(2,1,96,0.5,1);"), (2, 1, 96.0, 0.5, 1, 0));
    assert_eq!(mode("GTN_LaserPowerMode(1,2,5,0,0,1);"), (1, 2, 5.0, 0.0, 0, 1));
}

#[test]
fn every_laser_call_in_both_forms() {
    macro_rules! same {
        ($request:ident { $($field:ident: $value:expr),* } $($text:literal)+) => {
            for text in [$($text),+] {
                let r: c::$request = request(text);
                $( assert_eq!(r.$field.get(), $value, "{text}: {}", stringify!($field)); )*
            }
        };
    }
    same!(SetAxisMode { core: 1, axis: 7, mode: 1 } "GT_SetAxisMode (AXIS_LASER,1);" "GTN_SetAxisMode(1,7,1);");
    same!(LaserOn { core: 1, channel: 1 } "GT_LaserOn(1);" "GTN_LaserOn(1,1);");
    same!(LaserOff { core: 2, channel: 0 } "GTN_LaserOff(2,0);" "GTN_LaserOff(2);");
    same!(LaserOnStatus { core: 1, channel: 0 } "unsigned short v; GTN_LaserOnStatus(1,&v,0);" "GT_LaserOnStatus(&v);");
    same!(SetHSIOOpt { core: 1, value: 1, channel: 0 } "GT_SetHSIOOpt(1,0);" "GT_SetHSIOOpt(1);" "GTN_SetHSIOOpt(1,1,0);");
    same!(GetHSIOOpt { core: 1, channel: 1 } "unsigned short v; GT_GetHSIOOpt(&v,1);" "GTN_GetHSIOOpt(1,&v,1);");
    same!(LaserPrfCmd { core: 1, power: 2.5, channel: 0 } "GT_LaserPrfCmd(2.5,0);" "GT_LaserPrfCmd(2.5);");
    same!(LaserOutFrq { core: 1, frequency: 10.0, channel: 1 } "GT_LaserOutFrq(10,1);" "GTN_LaserOutFrq(1,10,1);");
    same!(SetPulseWidth { core: 1, width_us: 65535, channel: 0 } "GT_SetPulseWidth(65535);" "GTN_SetPulseWidth(1,65535,0);");
    same!(SetWaitPulse { mode: 1, frequency: 5.0, duty: 2.0, channel: 1 } "GT_SetWaitPulse(1,5,2,1);" "GTN_SetWaitPulse(1,1,5,2,1);");
    same!(SetWaitPulse { mode: 0, frequency: 0.0, duty: 0.0, channel: 0 } "GT_SetWaitPulse(0,0,0);");
    same!(SetWaitPulseEx { core: 1, mode: 1, frequency: 5.0, duty: 2.0 } "GT_SetWaitPulseEx(1,5,2);" "GTN_SetWaitPulseEx(1,1,5,2);");
    same!(SetPreVltg { mode: 1, voltage: 0.5, channel: 0 } "GT_SetPreVltg(1,0.5);" "GTN_SetPreVltg(1,1,0.5,0);");
    same!(SetLevelDelay { off_delay_us: 30, on_delay_us: 20, channel: 0 } "GT_SetLevelDelay(30,20,0);" "GT_SetLevelDelay(30,20);" "GTN_SetLevelDelay(1,30,20,0);");
    same!(EnaFPK { time1_us: 1, time2_us: 2, laser_off_delay_us: 3, channel: 1 } "GT_EnaFPK(1,2,3,1);" "GTN_EnaFPK(1,1,2,3,1);");
    same!(DisFPK { core: 1, channel: 0 } "GT_DisFPK(0);" "GT_DisFPK();" "GTN_DisFPK(1);");
    same!(SetLaserMode { core: 1, mode: 0 } "GT_SetLaserMode(0);" "GTN_SetLaserMode(1,0);");
    same!(ZeroLaserOnTime { channel: 1 } "GT_ZeroLaserOnTime (1);" "GTN_ZeroLaserOnTime(1,1);");
    same!(GetLaserOnTime { channel: 1 } "unsigned long t; GT_GetLaserOnTime(1,&t);" "GTN_GetLaserOnTime(1,1,&t);");
    same!(SetLaserCrdMap { channel: 0, map: 2 } "GT_SetLaserCrdMap(0,2);" "GTN_SetLaserCrdMap(1,0,2);");
    same!(GetLaserCrdMap { channel: 0 } "short map; GT_GetLaserCrdMap(0,&map);");
    same!(GetLaserPower { channel: 1 } "double p; GT_GetLaserPower(1,&p);" "GTN_GetLaserPower(1,1,&p);");
    same!(GetLaserFault { channel: 1 } "short cause; GT_GetLaserFault(1,&cause);");
    same!(ClrLaserFault { core: 1, channel: 1 } "GT_ClrLaserFault(1);" "GTN_ClrLaserFault(1,1);");
}

#[test]
fn ranges_and_families_are_the_controllers() {
    // What is out of range in one family is held in the other: the script does not know the family.
    assert_eq!(request::<c::SetPulseWidth>("GT_SetPulseWidth(70000,0);").width_us.get(), 70_000);
    assert_eq!(request::<c::SetLevelDelay>("GT_SetLevelDelay(70000,1,0);").off_delay_us.get(), 70_000);
    assert_eq!(request::<c::LaserPrfCmd>("GT_LaserPrfCmd(-1,0);").power.get(), -1.0);
    assert_eq!(request::<c::LaserOn>("GT_LaserOn(2);").channel.get(), 2);
    // What has no place on the wire is refused here.
    for text in ["GT_SetPulseWidth(4294967296,0);", "GT_SetHSIOOpt(65536,0);", "GT_LaserPowerMode(40000,1,0,0);"] {
        let found = compile(text, &NoFiles).expect_err(text);
        assert!(found[0].message.contains("return value 7"), "{text}: {found:?}");
    }
    for (text, missing) in [
        ("GT_LaserPowerMode(0,100);", "minValue"),
        ("GT_SetHSIOOpt();", "value"),
        ("GT_SetWaitPulseEx(1,5);", "waitPulseDuty"),
        ("GT_ZeroLaserOnTime();", "channel"),
    ] {
        let found = compile(text, &NoFiles).expect_err(text);
        assert!(found[0].message.contains(&format!("`{missing}` is missing")), "{text}: {found:?}");
    }
    let found = compile("GT_LaserPowerMode(0,100,0,0,0,0);", &NoFiles).unwrap_err();
    assert!(found[0].message.contains("at most 5"), "{found:?}");
}

#[test]
fn the_channels_that_a_job_uses() {
    for (text, lasers) in [
        ("GT_AxisOn(1);", 0),
        ("GT_SetAxisMode(7,1); GT_SetLaserMode(0);", 0),
        ("unsigned long t; GT_GetLaserOnTime(1,&t);", 0),
        ("GT_LaserPrfCmd(25);", 0b01),
        ("GT_LaserOn(1);", 0b10),
        ("GT_SetWaitPulseEx(1,5,2);", 0b11),
        ("GT_LaserOn(0); GTN_LaserOff(1,1);", 0b11),
        ("GT_LaserOn(2);", 0),
    ] {
        assert_eq!(good(text).lasers, lasers, "{text}");
    }
}

#[test]
fn a_negative_number_is_no_unsigned_one() {
    for (call, parameter) in [
        ("GT_SetLevelDelay(-1,0,0);", "`offDelay` of GT_SetLevelDelay is -1"),
        ("GTN_SetLevelDelay(1,0,-5,0);", "`onDelay` of GTN_SetLevelDelay is -5"),
        ("GT_SetPulseWidth(2-3);", "`width` of GT_SetPulseWidth is -1"),
        ("long w = -7; GT_SetPulseWidth(w);", "`width` of GT_SetPulseWidth is -7"),
        ("GT_SetPulseWidth(-2.5);", "`width` of GT_SetPulseWidth is -2.5"),
        ("GT_EnaFPK(1,-2147483648,0);", "`time2` of GT_EnaFPK is -2147483648"),
        ("GT_SetHSIOOpt(-1);", "`value` of GT_SetHSIOOpt: -1"),
    ] {
        let found = compile(call, &NoFiles).expect_err(call);
        let text = format!("{found:?}");
        assert!(text.contains(parameter) && text.contains("(return value 7)"), "{call}: {text}");
    }
    // Bit patterns keep all their 32 bits.
    for (text, width) in [("0x80000000", 1u32 << 31), ("0xFFFFFFFF", u32::MAX), ("1 << 31", 1 << 31), ("~0", u32::MAX)]
    {
        let r: c::SetPulseWidth = request(&format!("GT_SetPulseWidth({text});"));
        assert_eq!(r.width_us.get(), width, "{text}");
    }
}

#[test]
fn every_buffered_laser_call_in_both_forms() {
    macro_rules! same {
        ($request:ident { $($field:ident: $value:expr),* } $($text:literal)+) => {
            for text in [$($text),+] {
                let r: c::$request = request(text);
                $( assert_eq!(r.$field.get(), $value, "{text}: {}", stringify!($field)); )*
            }
        };
    }
    same!(BufLaserOn { core: 1, crd: 1, fifo: 0, channel: 0 } "GT_BufLaserOn(1,0,0);" "GT_BufLaserOn(1);" "GTN_BufLaserOn(1,1);");
    same!(BufLaserOff { core: 2, crd: 1, fifo: 1, channel: 1 } "GTN_BufLaserOff(2,1,1,1);");
    // The manual of the earlier series writes channel 00.
    same!(BufLaserOff { core: 1, crd: 1, fifo: 0, channel: 0 } "GT_BufLaserOff(1,0,00);");
    same!(BufLaserPrfCmd { crd: 1, power: 50.0, fifo: 0, channel: 0 } "GT_BufLaserPrfCmd(1,50,0,0);" "GT_BufLaserPrfCmd(1,50);");
    same!(BufLaserPrfFollow { crd: 1, ratio: 0.1, min: 10, max: 100, fifo: 0, channel: 1 } "GT_BufLaserPrfFollow(1,0.1,10,100,0,1);");
    // Bounds are of the type `long` there.
    same!(BufLaserPrfFollow { ratio: 0.5, min: 2, max: 9 } "GTN_BufLaserPrfFollow(1,1,0.5,2.75,9.99);");
    same!(BufLaserFollowRatio { crd: 2, ratio: 0.1, min: 2.75, max: 9.99, fifo: 1, channel: 1 } "GT_BufLaserFollowRatio(2,0.1,2.75,9.99,1,1);");
    same!(BufLaserFollowMode { crd: 1, source: 1, fifo: 0, channel: 0, start_power: 0.0 } "GT_BufLaserFollowMode(1,1,0,0);" "GT_BufLaserFollowMode(1,1,0,0,0);");
    same!(BufLaserFollowTable { crd: 1, table: 2, min: 0.0, max: 50.0, fifo: 0, channel: 1 } "GT_BufLaserFollowTable(1,2,0,50,0,1);");
    same!(BufLaserFollowOff { crd: 1, fifo: 0, channel: 0 } "GT_BufLaserFollowOff(1);" "GTN_BufLaserFollowOff(1,1,0,0);");
    // Whether the start power was given, be it 0.
    for (text, given) in [
        ("GT_BufLaserFollowMode(1);", 0),
        ("GT_BufLaserFollowMode(1,1,0,0);", 0),
        ("GT_BufLaserFollowMode(1,1,0,0,0);", 1),
        ("GTN_BufLaserFollowMode(1,1,1,0,0,12.5);", 1),
    ] {
        assert_eq!(request::<c::BufLaserFollowMode>(text).start_given, given, "{text}");
    }
    for (text, missing) in [
        ("GT_BufLaserOn();", "crd"),
        ("GT_BufLaserFollowRatio(1,0.1,10);", "maxPower"),
        ("GT_SetLaserDisMode(1);", "source"),
    ] {
        let found = compile(text, &NoFiles).expect_err(text);
        assert!(found[0].message.contains(&format!("`{missing}` is missing")), "{text}: {found:?}");
    }
}

#[test]
fn distance_follow_takes_the_parameters_of_both_manuals() {
    let arrays =
        "long pos[4] = {1,-2,3,4}; double scale[4] = {1000,2000,3000,4000}; double ratio[4] = {0.1,-0.2,0.3,0};";
    let r: c::SetLaserDisMode = request(&format!("{arrays} GT_SetLaserDisMode(1,0,pos,scale,1);"));
    assert_eq!((r.mode.get(), r.source.get(), r.channel.get()), (1, 0, 1));
    assert_eq!({ r.pos }.map(i32::from), [1, -2, 3, 4]);
    assert_eq!({ r.scale }.map(f64::from), [1000.0, 2000.0, 3000.0, 4000.0]);
    // What is switched off needs no arrays.
    for text in ["GT_SetLaserDisMode(0,0,NULL,NULL,1);", "GTN_SetLaserDisMode(1,0,0,0,0,1);"] {
        let r: c::SetLaserDisMode = request(text);
        assert_eq!(
            (r.core.get(), r.mode.get(), { r.pos }[3].get(), { r.scale }[3].get(), r.channel.get()),
            (1, 0, 0, 0.0, 1)
        );
    }
    for (call, bounds, given, channel) in [
        // GUS: with bounds. LSR: without.
        ("GT_SetLaserDisRatio(ratio,10,100,1);", (10.0, 100.0), 1, 1),
        ("GT_SetLaserDisRatio(ratio,10,100);", (10.0, 100.0), 1, 0),
        ("GT_SetLaserDisRatio(ratio,1);", (0.0, 0.0), 0, 1),
        ("GT_SetLaserDisRatio(ratio);", (0.0, 0.0), 0, 0),
        ("GTN_SetLaserDisRatio(1,ratio,1);", (0.0, 0.0), 0, 1),
    ] {
        let r: c::SetLaserDisRatio = request(&format!("{arrays} {call}"));
        assert_eq!({ r.ratio }.map(f64::from), [0.1, -0.2, 0.3, 0.0], "{call}");
        assert_eq!((r.min.get(), r.max.get()), bounds, "{call}");
        assert_eq!((r.bounds_given, r.channel.get()), (given, channel), "{call}");
    }
    let found = compile("double ratio[3] = {1,2,3}; GT_SetLaserDisRatio(ratio,1);", &NoFiles).unwrap_err();
    assert!(found[0].message.contains("has 3 values"), "{found:?}");
}

/// The request and its items.
fn with_items<R: Request>(text: &str) -> (R, Vec<R::Item>) {
    let call = last(text);
    assert_eq!(call.opcode, R::OPCODE, "{text}");
    let (head, rest) = R::read_from_prefix(&call.body).unwrap();
    (head, rest.chunks(size_of::<R::Item>()).map(|item| R::Item::read_from_bytes(item).unwrap()).collect())
}

#[test]
fn tables_travel_after_their_request() {
    let (r, points) = with_items::<c::SetLaserFollowTable>(
        "double vel[3] = {0,10,50}, power[3] = {5,20,80}; GT_SetLaserFollowTable(2,3,vel,power,1);",
    );
    assert_eq!((r.table.get(), r.count.get(), r.channel.get(), r.first.get()), (2, 3, 1, 0));
    assert_eq!(
        points.iter().map(|p| (p.vel.get(), p.power.get())).collect::<Vec<_>>(),
        [(0.0, 5.0), (10.0, 20.0), (50.0, 80.0)]
    );
    // Two points for each of four axes.
    let (r, points) = with_items::<c::SetLaserDisTable1D>(
        "double ratio[8] = {1,2,3,4,5,6,7,8}; long pos[8] = {0,10,0,20,0,30,0,40}; double limit[4] = {1,2,3,4};
         GT_SetLaserDisTable1D(2,ratio,pos,5,95,limit,1);",
    );
    assert_eq!((r.count.get(), r.min.get(), r.max.get(), r.channel.get(), r.limits_given), (2, 5.0, 95.0, 1, 1));
    assert_eq!({ r.limit }.map(f64::from), [1.0, 2.0, 3.0, 4.0]);
    assert_eq!(points.len(), 8);
    assert_eq!((points[5].pos.get(), points[5].ratio.get()), (30, 6.0));
    let text = "double ratio[4]={1,2,3,4}; long pos[4]={0}; GT_SetLaserDisTable1D(1,ratio,pos,0,100,NULL);";
    assert_eq!(with_items::<c::SetLaserDisTable1D>(text).0.limits_given, 0);
    // A grid of three by two: the positions of X, those of Y, then the ratios.
    let (r, values) = with_items::<c::SetLaserDisTable2D>(
        "short axis[2] = {1,3}; short count[2] = {3,2}; double ratio[6] = {1,2,3,4,5,6}; long x[3] = {0,10,20}; long y[2] = {7,8};
         GT_SetLaserDisTable2D(axis,count,ratio,x,y,0,100,NULL,0);",
    );
    assert_eq!(({ r.axis }.map(i16::from), { r.count }.map(i16::from), r.limits_given), ([1, 3], [3, 2], 0));
    let values: Vec<f64> = values.iter().map(|v| v.value.get()).collect();
    assert_eq!(values, [0.0, 10.0, 20.0, 7.0, 8.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
}
