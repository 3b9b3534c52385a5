//! Inputs and outputs: what does not exist, what the board lacks, which axis a bit is of.
use super::*;

#[test]
fn inputs_and_outputs() {
    let mut bench = Bench::gus();
    let core = 1.into();
    bench.machine.inputs[2].home = true;
    bench.machine.inputs[0].limit_negative = true;
    bench.run_ms(1);
    assert_eq!(bench.done(GetDi { core, di_type: 3.into() }).value.get(), 4);
    assert_eq!(bench.done(GetDi { core, di_type: 1.into() }).value.get(), 1);
    assert_eq!(bench.done(GetDi { core, di_type: 4.into() }).value.get(), 0x5a);
    assert_eq!(bench.refused(GetDi { core, di_type: 6.into() }).2.field, 1);
    // The bench's inputs are wired: every such call is refused for the state.
    let wired = |refused: (i16, Reason, Refusal)| assert_eq!((refused.0, refused.1), (1, Reason::InputsWired));
    for di_type in [4, 9] {
        wired(bench.refused(SimInput { core, di_type: di_type.into(), index: 1.into(), level: 1.into() }));
    }
    wired(bench.refused(SimAdc { core, adc: 1.into(), volts: 0.0.into() }));
    wired(bench.refused(SimPlan { core, di_type: 4.into(), index: 1.into(), ..SimPlan::default() }));
    assert_eq!(bench.done(GetDi { core, di_type: 4.into() }).value.get(), 0x5a);
    assert_eq!(bench.refused(GetDo { core, do_type: 9.into() }).2.field, 1);
    bench.done(SetDo { core, do_type: 12.into(), value: 0xa5a5.into() });
    assert_eq!(bench.done(GetDo { core, do_type: 12.into() }).value.get(), 0xa5a5);
    bench.done(SetDoBit { core, do_type: 12.into(), index: 1.into(), value: 0.into() });
    assert_eq!(bench.machine.outputs.2, 0xa5a4);
    assert_eq!(bench.refused(SetDo { core, do_type: 12.into(), value: 0x1_0000.into() }).2.field, 2);
    assert_eq!(bench.refused(SetDoBit { core, do_type: 12.into(), index: 17.into(), value: 0.into() }).2.field, 2);
    assert_eq!(bench.refused(SetDoBit { core, do_type: 12.into(), index: 1.into(), value: 2.into() }).2.field, 3);
    bench.done(SetDo { core, do_type: 11.into(), value: 0x81.into() });
    assert_eq!(bench.machine.outputs.1, 0x81);
    bench.servo_on(3);
    assert_eq!(bench.done(GetDo { core, do_type: 10.into() }).value.get(), 4);

    let values: Vec<_> = [-32768, 0, 32767].map(|value: i16| Short { value: value.into() }).into();
    let dac = SetDac { core, dac: 6.into(), count: 3.into() };
    assert_eq!(bench.call_items(dac, &values).code, 0);
    assert_eq!(bench.machine.analog_out[5..], [-32768, 0, 32767]);
    assert_eq!(bench.call(GetDac { core, dac: 6.into(), count: 3.into() }).items::<GetDac>(), values);
    assert_eq!(bench.call_items(SetDac { dac: 7.into(), ..dac }, &values).refusal().field, 2);
    assert_eq!(bench.call_items(SetDac { dac: 0.into(), ..dac }, &values).refusal().field, 1);
    assert_eq!(bench.call(GetDac { core, dac: 7.into(), count: 9.into() }).items::<GetDac>(), values[1..]);
    assert_eq!(bench.refused(GetDac { core, dac: 9.into(), count: 1.into() }).2.field, 1);
    let all = bench.call(GetAdc { core, adc: 1.into(), count: 100.into() }).items::<GetAdc>().len();
    assert_eq!(bench.call(GetAdc { core, adc: (all as i16).into(), count: 2.into() }).items::<GetAdc>().len(), 1);
    let adc = bench.call(GetAdc { core, adc: 2.into(), count: 1.into() }).items::<GetAdc>()[0].value.get();
    assert!((adc - 1.0).abs() < 1e-3, "{adc}");
}

#[test]
fn limits_are_switched_one_by_one_or_both() {
    let mut bench = Bench::gus();
    let (core, axis) = (1.into(), 2.into());
    (bench.machine.inputs[1].limit_positive, bench.machine.inputs[1].limit_negative) = (true, true);
    // Bit 0 the positive, bit 1 the negative limit, once latched bits are cleared.
    let limits = |bench: &mut Bench<8>| {
        bench.run_ms(1);
        bench.done(ClrSts { core, axis, count: 1.into() });
        bench.run_ms(1);
        bench.status_word(2) >> 5 & 3
    };
    bench.done(LmtsOff { core, axis, limit_type: (-1).into() });
    assert_eq!(limits(&mut bench), 0b00);
    for (kind, bits) in [(-1, 0b11), (0, 0b01), (1, 0b10)] {
        bench.done(LmtsOn { core, axis, limit_type: kind.into() });
        assert_eq!(limits(&mut bench), bits, "on, {kind}");
        bench.done(LmtsOn { core, axis, limit_type: (-1).into() });
        bench.done(LmtsOff { core, axis, limit_type: kind.into() });
        assert_eq!(limits(&mut bench), 0b11 & !bits, "off, {kind}");
        bench.done(LmtsOff { core, axis, limit_type: (-1).into() });
        assert_eq!(limits(&mut bench), 0b00, "off, both");
    }
}

#[test]
fn limit_sense_reaches_the_right_axis() {
    let mut bench = Bench::gus();
    let core = 1.into();
    bench.done(LmtsOn { core, axis: 2.into(), limit_type: (-1).into() });
    bench.done(LmtsOn { core, axis: 3.into(), limit_type: 1.into() });
    bench.run_ms(1);
    bench.done(ClrSts { core, axis: 1.into(), count: 8.into() });
    // Bit 3: negative limit of axis 2, active low; its input is low.
    bench.done(LmtSns { core, sense: 0b1000.into() });
    bench.run_ms(1);
    let limits: Vec<_> = (1..=3).map(|axis| bench.status_word(axis) >> 5 & 3).collect();
    assert_eq!(limits, [0, 2, 0]);
}

/// The last axis of the bench's board has no inputs of its own.
#[test]
fn inputs_that_the_board_lacks_are_refused_by_name() {
    let mut bench = Bench::gus();
    let core = 1.into();
    let is = |(code, reason, refusal): (i16, Reason, Refusal), expected: Reason, field: u8| {
        assert_eq!((code, reason, refusal.field, refusal.axis.get()), (7, expected, field, 8));
    };
    for limit_type in [-1i16, 0, 1] {
        let limit_type = limit_type.into();
        is(bench.refused(LmtsOn { core, axis: 8.into(), limit_type }), Reason::NoLimitInput, 2);
        bench.done(LmtsOff { core, axis: 8.into(), limit_type });
        bench.done(LmtsOn { core, axis: 7.into(), limit_type });
    }
    is(bench.refused(AlarmOn { core, axis: 8.into() }), Reason::NoAlarmInput, 1);
    bench.done(AlarmOff { core, axis: 8.into() });
    bench.done(AlarmOn { core, axis: 7.into() });
    is(bench.refused(SetCaptureMode { core, encoder: 8.into(), mode: 1.into() }), Reason::NoHomeInput, 2);
    bench.done(SetCaptureMode { core, encoder: 7.into(), mode: 1.into() });
    // Bits 14 and 15 are those of axis 8; nothing of a refused word is taken.
    for sense in [0x4000u16, 0x8000, 0xffff] {
        is(bench.refused(LmtSns { core, sense: sense.into() }), Reason::NoLimitInput, 1);
    }
    bench.run_ms(1);
    assert_eq!(bench.status_word(1) >> 5 & 3, 0);
    bench.done(LmtSns { core, sense: 0x3fff.into() });
    // The fields of an item come after the two of the request.
    let load = LoadConfig { core, count: 1.into() };
    let item = ConfigItem { axis: 8.into(), ..ConfigItem::default() };
    let items = [
        (ConfigItem { given: 1.into(), limits_on: 2, ..item }, Reason::NoLimitInput, 4),
        (ConfigItem { given: 2.into(), limit_sense: 1, ..item }, Reason::NoLimitInput, 5),
        (ConfigItem { given: 4.into(), alarm_on: 1, ..item }, Reason::NoAlarmInput, 6),
        (ConfigItem { given: 8.into(), alarm_sense: 1, ..item }, Reason::NoAlarmInput, 7),
        (ConfigItem { given: 0x100.into(), home_sense: 1, ..item }, Reason::NoHomeInput, 15),
    ];
    for (item, reason, field) in items {
        let answer = bench.call_items(load, &[item]);
        is((answer.code, answer.reason(), answer.refusal()), reason, field);
    }
    // All of them off, as a file has them for an axis without inputs.
    assert_eq!(bench.call_items(load, &[ConfigItem { given: 0x10f.into(), ..item }]).code, 0);
    // To wait for one that never comes: kinds 0 to 3, and 5.
    bench.servo_on(2);
    bench.done(PrfFollowEx { core, profile: 2.into(), dir: 0.into() });
    let wait = |di_type: i16, index: i16| FollowDiBitEx {
        core,
        profile: 2.into(),
        di_type: di_type.into(),
        index: index.into(),
        value: 1.into(),
        time_ms: 10.into(),
        ..FollowDiBitEx::default()
    };
    let reasons = [
        (0, Reason::NoLimitInput),
        (1, Reason::NoLimitInput),
        (2, Reason::NoAlarmInput),
        (3, Reason::NoHomeInput),
        (5, Reason::NoArriveInput),
    ];
    for (di_type, reason) in reasons {
        is(bench.refused(wait(di_type, 8)), reason, 3);
    }
}
