//! Gear over the wire: ratios, events, masters, starts; counts of edges and outputs for a time.
use crate::bench;
use bench::{Bench, pt_data, start};
use protocol::command::*;
use protocol::reason::{Reason, describe_opcode};

fn prf(axis: i16, dir: i16) -> PrfGear {
    PrfGear { core: 1.into(), profile: axis.into(), dir: dir.into() }
}

fn master(axis: i16, index: i16, kind: i16) -> SetGearMaster {
    SetGearMaster {
        core: 1.into(),
        profile: axis.into(),
        master_index: index.into(),
        master_type: kind.into(),
        master_item: 0.into(),
    }
}

fn ratio(axis: i16, [even, slave, slope]: [i32; 3]) -> SetGearRatio {
    SetGearRatio {
        core: 1.into(),
        profile: axis.into(),
        master_even: even.into(),
        slave_even: slave.into(),
        master_slope: slope.into(),
    }
}

fn event(axis: i16, [which, first, second]: [i32; 3]) -> SetGearEvent {
    SetGearEvent {
        core: 1.into(),
        profile: axis.into(),
        event: (which as i16).into(),
        start_para0: first.into(),
        start_para1: second.into(),
    }
}

fn go(mask: i32) -> GearStart {
    GearStart { core: 1.into(), mask: mask.into() }
}

#[test]
fn settings_read_back_and_are_forgotten_with_the_mode() {
    let mut bench = Bench::gus();
    let (core, profile) = (1.into(), 2.into());
    bench.done(prf(2, 0));
    let reply = bench.done(GetGearRatio { core, profile });
    assert_eq!((reply.master_even.get(), reply.slave_even.get(), reply.master_slope.get()), (0, 0, 0));
    bench.done(master(2, 1, 3));
    bench.done(ratio(2, [2, -1, 100_000]));
    bench.done(event(2, [2, -1, -500]));
    let reply = bench.done(GetGearRatio { core, profile });
    assert_eq!((reply.master_even.get(), reply.slave_even.get(), reply.master_slope.get()), (2, -1, 100_000));
    let reply = bench.done(GetGearMaster { core, profile });
    assert_eq!((reply.master_index.get(), reply.master_type.get(), reply.master_item.get()), (1, 3, 0));
    let reply = bench.done(GetGearEvent { core, profile });
    assert_eq!((reply.event.get(), reply.start_para0.get(), reply.start_para1.get()), (2, -1, -500));
    let mode = bench.call(GetPrfMode { core, profile, count: 1.into() }).items::<GetPrfMode>();
    assert_eq!(mode[0].value.get(), 3, "GetPrfMode");
    bench.done(PrfTrap { core, profile });
    assert_eq!(bench.refused(GetGearRatio { core, profile }).1, Reason::WrongMode);
    bench.done(prf(2, 0));
    assert_eq!(bench.done(GetGearRatio { core, profile }).master_even.get(), 0);
    assert_eq!(bench.done(GetGearMaster { core, profile }).master_index.get(), 0);
    assert_eq!(bench.done(GetGearEvent { core, profile }).event.get(), 1);
}

/// What is wrong names its parameter and the limit.
#[test]
fn wrong_numbers_are_refused() {
    let mut bench = Bench::gus();
    bench.done(prf(2, 0));
    let mut text = |request: SetGearRatio| {
        let (code, _, refusal) = bench.refused(request);
        assert_eq!(code, 7);
        describe_opcode(opcode::SetGearRatio, refusal).to_string()
    };
    assert!(text(ratio(2, [0, 1, 0])).starts_with("SetGearRatio: master_even is 0;"));
    assert!(
        text(ratio(2, [2, 33_554_433, 0])).contains("slave_even is 33554433; it must be from -33554432 to 33554432")
    );
    assert!(text(ratio(2, [1, 1, -1])).contains("master_slope is -1; it must be 0"));
    assert!(
        text(ratio(2, [1, 1, 1])).contains("master_slope is 1; it must be 0, which is the ratio at once, or from 2 to")
    );
    assert!(text(ratio(2, [1, 1 << 24, 1 << 17])).contains("from 2 to 65536"));
    assert!(text(ratio(2, [1, 0, 1])).contains("from 2 to 2147483647"));
    assert_eq!(bench.refused(event(2, [5, 0, 0])).0, 1, "AREA is not there");
    assert_eq!(bench.refused(event(2, [3, 0, 0])).0, 7);
    let (code, reason, refusal) = bench.refused(event(2, [2, 0, 0]));
    assert_eq!((code, reason, refusal.field), (7, Reason::CrossingDirection, 3));
    assert_eq!(bench.refused(master(2, 2, 2)).1, Reason::OwnMaster);
    assert_eq!(bench.refused(master(2, 1, 4)).1, Reason::MasterType);
    assert_eq!(bench.refused(go(2)).1, Reason::NoMaster);
    bench.done(master(2, 1, 2));
    assert_eq!(bench.refused(go(2)).1, Reason::NoRatio);
    bench.done(ratio(2, [1, 1, 0]));
    assert_eq!(bench.refused(go(2)).1, Reason::ServoOff);
    assert_eq!(bench.refused(go(1)).1, Reason::WrongMode);
    // Through Follow and Gear together no axis follows itself.
    bench.done(bench::follow::prf(1, 0));
    let cycle = SetFollowMaster {
        core: 1.into(),
        profile: 1.into(),
        master_index: 2.into(),
        master_type: 2.into(),
        master_item: 0.into(),
    };
    assert_eq!(bench.refused(cycle).1, Reason::MasterCycle);
    assert_eq!(bench.refused(prf(2, 1)).1, Reason::DirectionDiffers);
}

#[test]
fn it_runs_takes_new_ratios_and_ends_with_a_stop() {
    let mut bench = Bench::gus();
    for axis in [1, 2] {
        bench.servo_on(axis);
    }
    bench.done(PrfPt { core: 1.into(), profile: 1.into(), mode: 0.into() });
    bench.done(pt_data(1, 1000.0, 100));
    bench.done(prf(2, 0));
    bench.done(master(2, 1, 2));
    bench.done(ratio(2, [2, 1, 0]));
    bench.done(go(2));
    bench.done(go(2));
    assert_eq!(bench.status_word(2) & 0x400, 0x400, "it waits for its master");
    let axis = 2.into();
    assert_eq!(bench.refused(ZeroPos { core: 1.into(), axis, count: 1.into() }).1, Reason::Moving);
    bench.done(start(1));
    bench.run_ms(150);
    assert_eq!(bench.pos(2), 500.0);
    bench.done(ZeroPos { core: 1.into(), axis: 1.into(), count: 1.into() });
    bench.run_ms(5);
    assert_eq!(bench.pos(2), 500.0, "its master has another name");
    bench.done(ratio(2, [1, 2, 0]));
    bench.done(start(1));
    bench.run_ms(150);
    assert_eq!(bench.pos(2), 1000.0, "a ratio counts from GearStart on");
    bench.done(go(2));
    bench.done(start(1));
    bench.run_ms(150);
    assert_eq!(bench.pos(2), 3000.0);
    bench.done(Stop { core: 1.into(), mask: 2.into(), option: 0.into(), form: 1 });
    bench.run_ms(5);
    assert_eq!(bench.status_word(2) & 0x400, 0);
    bench.done(start(1));
    bench.run_ms(150);
    assert_eq!(bench.pos(2), 3000.0);
    bench.done(ZeroPos { core: 1.into(), axis, count: 1.into() });
    bench.done(go(2));
    bench.done(start(1));
    bench.run_ms(150);
    assert_eq!(bench.pos(2), 2000.0);
}

fn counts(bench: &mut Bench<8>, kind: i16, index: i16, count: i16) -> Vec<u32> {
    let read = GetDiReverseCount { core: 1.into(), di_type: kind.into(), di_index: index.into(), count: count.into() };
    bench.call(read).items::<GetDiReverseCount>().iter().map(|item| item.value.get()).collect()
}

#[test]
fn edges_are_read_and_set_by_kind_and_number() {
    let mut bench = Bench::gus();
    for level in [true, false, true] {
        bench.machine.inputs[1].arrive = level;
        bench.machine.inputs[7].home = level;
        bench.run_ms(1);
    }
    assert_eq!(counts(&mut bench, 5, 1, 3), [0, 3, 0]);
    assert_eq!(counts(&mut bench, 3, 7, 4), [0, 3], "those that exist");
    assert_eq!(counts(&mut bench, 0, 1, 8), [0; 8]);
    let set = |index: i16, count: u16| SetDiReverseCount {
        core: 1.into(),
        di_type: 5.into(),
        di_index: index.into(),
        count: count.into(),
    };
    let values = [7u32, 100].map(|value| ULong { value: value.into() });
    assert_eq!(bench.call_items(set(1, 2), &values).code, 0);
    bench.machine.inputs[1].arrive = false;
    bench.run_ms(1);
    assert_eq!(counts(&mut bench, 5, 1, 2), [7, 101]);
    assert_eq!(bench.call_items(set(8, 2), &values).refusal().field, 3);
    let read = |kind: i16, index: i16| GetDiReverseCount {
        core: 1.into(),
        di_type: kind.into(),
        di_index: index.into(),
        count: 1.into(),
    };
    assert_eq!(bench.refused(read(6, 1)).2.field, 1);
    assert_eq!(bench.refused(read(4, 200)).2.field, 2);
}

#[test]
fn an_output_has_a_level_for_a_time() {
    let mut bench = Bench::gus();
    let pulse = |index: i16, value: i16, cycles: i16| SetDoBitReverse {
        core: 1.into(),
        do_type: 12.into(),
        do_index: index.into(),
        value: value.into(),
        reverse_time_cycles: cycles.into(),
    };
    let level = |bench: &mut Bench<8>| bench.done(GetDo { core: 1.into(), do_type: 12.into() }).value.get();
    bench.done(pulse(3, 1, 40));
    assert_eq!(level(&mut bench), 4);
    bench.run_ms(5);
    assert_eq!(level(&mut bench), 4);
    bench.run_ms(6);
    assert_eq!(level(&mut bench), 0);
    for (request, field) in [(pulse(0, 1, 1), 2), (pulse(17, 1, 1), 2), (pulse(1, 2, 1), 3), (pulse(1, 1, -1), 4)] {
        let (code, _, refusal) = bench.refused(request);
        assert_eq!((code, refusal.field), (7, field));
    }
    for index in 1..=16 {
        bench.done(pulse(index, 1, 1000));
    }
    assert_eq!(level(&mut bench), 0xffff);
    bench.run_ms(260);
    assert_eq!(level(&mut bench), 0);
}
