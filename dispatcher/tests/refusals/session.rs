//! Commands of the session: configuration, profiles, what ended the last run.
use super::*;

#[test]
fn a_configuration_is_applied_whole_or_not_at_all() {
    let mut bench = Bench::gus();
    let item = |axis: i16| ConfigItem {
        axis: axis.into(),
        given: 0x1ff.into(),
        soft_positive: 1000.into(),
        soft_negative: (-1000).into(),
        dec_smooth: 2.0.into(),
        dec_abrupt: 3.0.into(),
        pos_err: 40.into(),
        band: 5.into(),
        band_time_cycles: 6.into(),
        ..ConfigItem::default()
    };
    let load = |count: u16| LoadConfig { core: 1.into(), count: count.into() };
    let mut items: Vec<_> = (1..=8).map(item).collect();
    items[7].pos_err = 0.into();
    let answer = bench.call_items(load(8), &items);
    assert_eq!((answer.code, answer.reason()), (7, Reason::OutOfRange));
    assert_eq!((answer.refusal().item.get(), answer.refusal().field), (7, 12));
    for axis in 1..=8 {
        let dec = bench.done(GetStopDec { core: 1.into(), profile: axis.into() });
        assert_eq!(dec.smooth.get(), 1.0, "axis {axis}");
    }
    items[7] = item(9);
    assert_eq!(bench.call_items(load(8), &items).refusal().field, 2);
    items[7] = ConfigItem { given: 0x200.into(), ..item(8) };
    assert_eq!(bench.call_items(load(8), &items).refusal().field, 3);
    items[7] = item(8);
    assert_eq!(bench.call_items(load(8), &items).code, 0);
    for axis in 1..=8 {
        let (core, axis) = (1.into(), axis.into());
        assert_eq!(bench.done(GetStopDec { core, profile: axis }).abrupt.get(), 3.0);
        assert_eq!(bench.done(GetSoftLimit { core, axis }).negative.get(), -1000);
        assert_eq!(bench.done(GetPosErr { core, control: axis }).value.get(), 40);
        assert_eq!(bench.done(GetAxisBand { core, axis }), Band { band: 5.into(), time_cycles: 6.into() });
    }
}

#[test]
fn profiles() {
    let mut bench = Bench::<48>::new(5, 250);
    let version = bench.done(Version {});
    assert_eq!((version.cores, version.axes_per_core, version.tick_us.get()), (2, 24, 250));
    assert_eq!((&version.board[..6], version.schema.get()), (&b"bench\0"[..], protocol::SCHEMA));
    bench.done(AxisOn { core: 2.into(), axis: 24.into() });
    assert_eq!(bench.machine.outputs.0, 1 << 47);
    for (number, profile) in dispatcher::PROFILES.iter().enumerate() {
        let version = bench.done(Choose { profile: number as u8, family: 1 });
        assert_eq!((version.cores, version.axes_per_core, version.family), (profile.cores, profile.axes_per_core, 1));
        // Another profile resets everything; the same one nothing.
        bench.done(AxisOn { core: 1.into(), axis: 1.into() });
        let enabled = bench.machine.outputs.0;
        assert_eq!(enabled, 1);
        bench.done(Choose { profile: number as u8, family: 1 });
        assert_eq!(bench.machine.outputs.0, 1);
        let past = i16::from(profile.axes_per_core) + 1;
        assert_eq!(bench.refused(AxisOn { core: 1.into(), axis: past.into() }).0, 7);
        assert_eq!(bench.refused(AxisOn { core: (i16::from(profile.cores) + 1).into(), axis: 1.into() }).0, 7);
    }
    // 32 status items do not fit into one message.
    assert_eq!(bench.refused(AxisStatus { core: 1.into(), axis: 1.into(), count: 32.into() }).2.field, 2);
    assert_eq!(
        bench.call(AxisStatus { core: 1.into(), axis: 1.into(), count: 31.into() }).items::<AxisStatus>().len(),
        31
    );
}

#[test]
fn what_ended_the_last_run_is_reported() {
    let mut fresh = Bench::gus();
    let none = fresh.call(GetFault {});
    assert_eq!((none.reply::<GetFault>(), none.body.len()), (FaultReply { kind: 0, length: 0.into() }, 3));
    for (text, reported) in
        [("at main.rs:7", 12), ("", 0), (&*"é".repeat(100), 160), (&*format!("x{}", "é".repeat(100)), 159)]
    {
        let text: &'static str = String::leak(text.to_owned());
        let fault = Fault { kind: FaultKind::Core, text };
        let mut bench = Bench::<8>::after(Some(fault), 0, 250);
        let answer = bench.call(GetFault {});
        assert_eq!(answer.reply::<GetFault>(), FaultReply { kind: 2, length: reported.into() });
        let bytes: Vec<u8> = answer.items::<GetFault>().iter().map(|byte| byte.value).collect();
        assert_eq!(String::from_utf8(bytes).unwrap(), text[..usize::from(reported)]);
    }
    // It is a read: accepted beside a program too.
    fresh.post_all(&[bench::entry(Sleep { ns: 1_000_000.into() })]);
    fresh.done(GetFault {});
}
