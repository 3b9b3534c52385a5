//! Bad input: each command refused with its code, its reason and the parameter, and nothing
//! changed.
mod inputs;
mod session;

use crate::bench;
use bench::{Bench, body, pt_data, pt_item};
use dispatcher::{Fault, FaultKind};
use protocol::command::*;
use protocol::reason::{Reason, Refusal, describe_opcode};
use protocol::record::Lane;

fn pt_static(bench: &mut Bench<8>, axis: i16) {
    bench.servo_on(axis);
    bench.done(PrfPt { core: 1.into(), profile: axis.into(), mode: 0.into() });
}

#[test]
fn axes_and_cores_that_do_not_exist() {
    let mut bench = Bench::gus();
    for axis in [0, 9, 99, -1, i16::MAX] {
        let (code, reason, refusal) = bench.refused(AxisOn { core: 1.into(), axis: axis.into() });
        assert_eq!((code, reason, refusal.field), (7, Reason::Selector, 1));
        assert_eq!((refusal.got.get(), refusal.low.get(), refusal.high.get()), (f64::from(axis), 1.0, 8.0));
    }
    for core in [0, 2, -1] {
        let (code, reason, refusal) = bench.refused(AxisOn { core: core.into(), axis: 1.into() });
        assert_eq!((code, reason, refusal.field), (7, Reason::Selector, 0));
    }
    for count in [0, -1, i16::MIN] {
        let (code, _, refusal) = bench.refused(GetSts { core: 1.into(), axis: 1.into(), count: count.into() });
        assert_eq!((code, refusal.field), (7, 2));
    }
    // A read may reach past the last axis (GXN table 5-1, note 2); its first axis exists.
    for (axis, count, have) in [(1, 8, 8), (1, 9, 8), (8, 2, 1), (3, i16::MAX, 6)] {
        let reply = bench.call(GetSts { core: 1.into(), axis: axis.into(), count: count.into() });
        assert_eq!(reply.reply::<GetSts>().count.get(), have);
        assert_eq!(reply.items::<GetSts>().len(), usize::from(have));
    }
    assert_eq!(bench.refused(GetSts { core: 1.into(), axis: 9.into(), count: 1.into() }).2.field, 1);
    // A command that changes something may not.
    for (axis, count) in [(1, 9), (8, 2), (1, 0)] {
        assert_eq!(bench.refused(ZeroPos { core: 1.into(), axis: axis.into(), count: count.into() }).2.field, 2);
        assert_eq!(bench.refused(ClrSts { core: 1.into(), axis: axis.into(), count: count.into() }).2.field, 2);
    }
    // A mask that names axis 9 of 8.
    let (code, _, refusal) = bench.refused(PtStart { core: 1.into(), mask: 0x101.into(), option: 0.into() });
    assert_eq!((code, refusal.field, refusal.got.get()), (7, 1, 257.0));
    assert_eq!(bench.call(PtStart { core: 1.into(), mask: 0.into(), option: 0.into() }).code, 0);
    assert_eq!(bench.call(Update { core: 1.into(), mask: 0.into() }).code, 0);
}

#[test]
fn unknown_commands_and_wrong_lengths() {
    let mut bench = Bench::gus();
    for opcode in [0x0000, 0x0210, 0x0220, 0xffff] {
        let tag = bench.post_raw(opcode, Lane::Immediate, &[1, 2, 3]);
        let answer = bench.wait(tag);
        assert_eq!((answer.code, answer.reason()), (8, Reason::UnknownCommand));
    }
    for info in COMMANDS {
        for len in [1, 201] {
            if info.opcode == opcode::ProgramStart && len == 1 {
                // That is its length.
                continue;
            }
            // That is a chunk of twelve points.
            let len = if info.opcode == opcode::SetLaserDisTable1D && len == 201 { 202 } else { len };
            let tag = bench.post_raw(info.opcode, Lane::Immediate, &vec![0x55; len]);
            let answer = bench.wait(tag);
            let in_program = [opcode::Sleep, opcode::WaitStop, opcode::ProgramEnd].contains(&info.opcode);
            let expected = if in_program { Reason::NotInProgram } else { Reason::Length };
            assert_eq!(answer.reason(), expected, "{} with {len} bytes", info.name);
        }
    }
    let tag = bench.post_raw(opcode::AxisOn, Lane::Immediate, &[1, 0, 1]);
    let refusal = bench.wait(tag).refusal();
    assert_eq!((refusal.got.get(), refusal.low.get()), (3.0, 4.0));
    // More items announced than sent.
    let tag = bench.post_raw(
        opcode::PtDataMany,
        Lane::Immediate,
        &body::<PtDataMany>(
            PtDataMany { core: 1.into(), profile: 1.into(), fifo: 0.into(), count: 3.into() },
            &[pt_item(1.0, 1, 0)],
        ),
    );
    assert_eq!(bench.wait(tag).reason(), Reason::Length);
}

#[test]
fn pt_data_of_every_kind() {
    let mut bench = Bench::gus();
    let (code, reason, refusal) = bench.refused(pt_data(1, 1.0, 1));
    assert_eq!((code, reason, refusal.axis.get()), (1, Reason::WrongMode, 1));
    pt_static(&mut bench, 1);
    bench.done(pt_data(1, 100.0, 100));

    for pos in [f64::NAN, f64::INFINITY, -f64::INFINITY] {
        let (code, reason, refusal) = bench.refused(pt_data(1, pos, 200));
        assert_eq!((code, reason, refusal.field), (7, Reason::NotFinite, 2));
    }
    for pos in [1.1e12, -1.1e12, f64::MAX] {
        let (code, reason, refusal) = bench.refused(pt_data(1, pos, 200));
        assert_eq!((code, reason, refusal.field), (7, Reason::BeyondTravel, 2));
    }
    for time in [100, 99, 0, -5, i32::MIN] {
        let (code, reason, refusal) = bench.refused(pt_data(1, 200.0, time));
        assert_eq!((code, reason, refusal.field, refusal.low.get()), (7, Reason::NotIncreasing, 3, 100.0));
    }
    let (code, reason, _) = bench.refused(pt_data(1, 1e11, 101));
    assert_eq!((code, reason), (7, Reason::TooFast));
    for kind in [-1, 3] {
        let (code, reason, refusal) = bench.refused(PtData { kind: kind.into(), ..pt_data(1, 200.0, 200) });
        assert_eq!((code, reason, refusal.field), (7, Reason::Selector, 4));
    }
    for fifo in [-1, 2] {
        let (code, reason, refusal) = bench.refused(PtData { fifo: fifo.into(), ..pt_data(1, 200.0, 200) });
        assert_eq!((code, reason, refusal.field), (7, Reason::Selector, 5));
    }
    // Nothing of it was taken.
    let space = PtSpace { core: 1.into(), profile: 1.into(), fifo: 0.into() };
    assert_eq!(bench.done(space).value.get(), 31);

    // All of a batch or nothing, and the item is named.
    let many = PtDataMany { core: 1.into(), profile: 1.into(), fifo: 0.into(), count: 3.into() };
    let answer = bench.call_items(many, &[pt_item(1.0, 200, 0), pt_item(2.0, 300, 0), pt_item(3.0, 300, 0)]);
    assert_eq!((answer.reason(), answer.refusal().item.get()), (Reason::NotIncreasing, 2));
    // The time is the second field of an item, after four of the request.
    assert_eq!(answer.refusal().field, 5);
    assert_eq!(bench.done(space).value.get(), 31);
    // Data written after the end is overwritten: the chain continues from 100 ms.
    let taken = bench.call_items(many, &[pt_item(1.0, 101, 1), pt_item(2.0, 102, 1), pt_item(3.0, 103, 2)]);
    assert_eq!(taken.reply::<PtDataMany>(), PtTaken { taken: 3.into(), space: 28.into(), dry_ms: 103.into() });

    // The FIFO is full at 32.
    let many = PtDataMany { core: 1.into(), profile: 1.into(), fifo: 0.into(), count: 28.into() };
    let items: Vec<_> = (0..28).map(|i| pt_item(3.0, 200 + i, 1)).collect();
    assert_eq!(bench.call_items(many, &items).reply::<PtDataMany>().space.get(), 0);
    let (code, reason, refusal) = bench.refused(pt_data(1, 3.0, 1000));
    assert_eq!((code, reason, refusal.axis.get(), refusal.high.get()), (1, Reason::FifoFull, 1, 32.0));
    // The other FIFO is not.
    assert_eq!(bench.call(PtData { fifo: 1.into(), ..pt_data(1, 3.0, 5) }).code, 0);
}

#[test]
fn pt_modes_and_starts() {
    let mut bench = Bench::gus();
    let start = PtStart { core: 1.into(), mask: 1.into(), option: 0.into() };
    assert_eq!(bench.refused(start).1, Reason::WrongMode);
    bench.done(PrfPt { core: 1.into(), profile: 1.into(), mode: 0.into() });
    assert_eq!(bench.refused(start).1, Reason::FifoEmpty);
    bench.done(pt_data(1, 100.0, 100));
    assert_eq!(bench.refused(start).1, Reason::ServoOff);
    bench.servo_on(1);
    // FIFO 1 is empty.
    let (code, reason, refusal) = bench.refused(PtStart { option: 1.into(), ..start });
    assert_eq!((code, reason, refusal.field, refusal.got.get()), (1, Reason::FifoEmpty, 2, 1.0));
    // All or nothing: axis 2 is not ready.
    let (_, reason, refusal) = bench.refused(PtStart { mask: 3.into(), ..start });
    assert_eq!((reason, refusal.axis.get()), (Reason::WrongMode, 2));
    bench.run_ms(5);
    assert_eq!(bench.pos(1), 0.0);
    assert_eq!(bench.refused(PrfPt { core: 1.into(), profile: 1.into(), mode: 2.into() }).1, Reason::Selector);
    assert_eq!(bench.refused(SetPtMemory { core: 1.into(), profile: 1.into(), memory: 2.into() }).1, Reason::Selector);

    bench.done(start);
    assert_ne!(bench.status_word(1) & 1 << 10, 0, "bit 10 from the start that returned 0");
    for _ in 0..2 {
        assert_eq!(bench.refused(start).1, Reason::Moving);
    }
    assert_eq!(bench.refused(PrfPt { core: 1.into(), profile: 1.into(), mode: 0.into() }).1, Reason::Moving);
    assert_eq!(bench.refused(PrfTrap { core: 1.into(), profile: 1.into() }).1, Reason::Moving);
    assert_eq!(bench.refused(SetPtMemory { core: 1.into(), profile: 1.into(), memory: 1.into() }).1, Reason::Moving);
    assert_eq!(bench.refused(SetPrfPos { core: 1.into(), profile: 1.into(), pos: 0.into() }).1, Reason::Moving);
    assert_eq!(bench.refused(ZeroPos { core: 1.into(), axis: 1.into(), count: 2.into() }).1, Reason::Moving);
    assert_eq!(bench.refused(SetTick { tick_us: 100.into() }).1, Reason::OnlyAtStandstill);
    assert_eq!(bench.refused(Choose { profile: 3, family: 0 }).1, Reason::OnlyAtStandstill);
    assert_eq!(bench.call(Choose { profile: 0, family: 1 }).code, 0);
    assert_eq!(bench.refused(PtClear { core: 1.into(), profile: 1.into(), fifo: 0.into() }).1, Reason::FifoInUse);
    assert_eq!(bench.call(PtClear { core: 1.into(), profile: 1.into(), fifo: 1.into() }).code, 0);
    bench.run_ms(100);
    assert_eq!(bench.pos(1), 100.0);
    assert_eq!(bench.done(GetPtLoop { core: 1.into(), profile: 1.into() }).value.get(), 1);
    // Kept data, kept mode; another use clears.
    let space = PtSpace { core: 1.into(), profile: 1.into(), fifo: 0.into() };
    bench.done(PrfPt { core: 1.into(), profile: 1.into(), mode: 0.into() });
    assert_eq!(bench.done(space).value.get(), 31);
    bench.done(PrfPt { core: 1.into(), profile: 1.into(), mode: 1.into() });
    assert_eq!(bench.done(space).value.get(), 64);
    assert_eq!(
        bench.refused(SetPtLoop { core: 1.into(), profile: 1.into(), loop_count: 2.into() }).1,
        Reason::NotInDynamic
    );
    assert_eq!(bench.refused(GetPtLoop { core: 1.into(), profile: 1.into() }).1, Reason::NotInDynamic);
    // Dynamic mode ignores the FIFO.
    bench.done(PtData { fifo: 7.into(), ..pt_data(1, 5.0, 5) });
    assert_eq!(bench.done(PtSpace { fifo: 9.into(), ..space }).value.get(), 63);
    bench.done(PtClear { core: 1.into(), profile: 1.into(), fifo: 5.into() });
    assert_eq!(bench.done(space).value.get(), 64);
    bench.done(SetPtMemory { core: 1.into(), profile: 1.into(), memory: 1.into() });
    assert_eq!(bench.done(space).value.get(), 2048);
    assert_eq!(bench.done(GetPtMemory { core: 1.into(), profile: 1.into() }).value.get(), 1);
}

#[test]
fn jog_and_trap() {
    let mut bench = Bench::gus();
    let (core, profile) = (1.into(), 1.into());
    let trap =
        SetTrapPrm { core, profile, acc: 1.0.into(), dec: 1.0.into(), vel_start: 0.0.into(), smooth_time_ms: 0.into() };
    assert_eq!(bench.refused(Update { core, mask: 1.into() }).1, Reason::NoAcceleration);
    for (field, prm) in [
        (2, SetTrapPrm { acc: (-1.0).into(), ..trap }),
        (3, SetTrapPrm { dec: 5e9.into(), ..trap }),
        (4, SetTrapPrm { vel_start: (-1.0).into(), ..trap }),
        (5, SetTrapPrm { smooth_time_ms: 501.into(), ..trap }),
        (5, SetTrapPrm { smooth_time_ms: (-1).into(), ..trap }),
    ] {
        let (code, reason, refusal) = bench.refused(prm);
        assert_eq!((code, reason, refusal.field), (7, Reason::OutOfRange, field));
    }
    assert_eq!(bench.refused(SetTrapPrm { acc: f64::NAN.into(), ..trap }).1, Reason::NotFinite);
    assert_eq!(bench.done(GetTrapPrm { core, profile }), TrapPrm::default());
    bench.done(SetTrapPrm { dec: 0.0.into(), ..trap });
    assert_eq!(bench.refused(Update { core, mask: 1.into() }).1, Reason::NoDeceleration);
    bench.done(SetTrapPrm { smooth_time_ms: 25.into(), ..trap });
    assert_eq!(bench.done(GetTrapPrm { core, profile }).smooth_time_ms.get(), 25);
    assert_eq!(bench.refused(Update { core, mask: 1.into() }).1, Reason::ServoOff);
    for vel in [f64::NAN, f64::INFINITY] {
        assert_eq!(bench.refused(SetVel { core, profile, vel: vel.into() }).1, Reason::NotFinite);
    }
    assert_eq!(bench.refused(SetVel { core, profile, vel: 5e9.into() }).0, 7);

    let jog = SetJogPrm { core, profile, acc: 0.5.into(), dec: 0.0.into(), smooth: 0.0.into() };
    assert_eq!(bench.refused(jog).1, Reason::WrongMode);
    bench.done(PrfJog { core, profile });
    assert_eq!(bench.refused(SetPos { core, profile, pos: 5.into() }).1, Reason::WrongMode);
    for smooth in [1.0, -0.1, 7.0] {
        assert_eq!(bench.refused(SetJogPrm { smooth: smooth.into(), ..jog }).0, 7);
    }
    bench.servo_on(1);
    let (_, reason, refusal) = bench.refused(Update { core, mask: 1.into() });
    assert_eq!(reason, Reason::NoAcceleration);
    let text = describe_opcode(Update::OPCODE, refusal).to_string();
    assert!(text.starts_with("Update: axis 1: its acceleration is 0; "), "{text}");
    bench.done(jog);
    bench.done(SetVel { core, profile, vel: 2.0.into() });
    // A Jog dec of 0 means acc.
    bench.done(Update { core, mask: 1.into() });
    bench.run_ms(10);
    let velocity = bench.call(GetPrfVel { core, profile, count: 1.into() }).items::<GetPrfVel>()[0].value.get();
    assert!((velocity - 2.0).abs() < 1e-9, "{velocity}");
    assert_eq!(bench.done(GetVel { core, profile }).value.get(), 2.0);
    bench.done(SetVel { core, profile, vel: 0.0.into() });
    bench.done(Update { core, mask: 1.into() });
    bench.run_ms(10);
    assert_eq!(bench.status_word(1) & 1 << 10, 0);
}

#[test]
fn a_latched_fault_and_the_servo() {
    let mut bench = Bench::gus();
    let (core, profile) = (1.into(), 1.into());
    pt_static(&mut bench, 1);
    bench.done(pt_data(1, 100.0, 100));
    bench.done(AlarmOn { core, axis: 1.into() });
    bench.machine.inputs[0].alarm = true;
    bench.run_ms(1);
    let start = PtStart { core, mask: 1.into(), option: 0.into() };
    let (code, reason, refusal) = bench.refused(start);
    assert_eq!((code, reason, refusal.axis.get()), (1, Reason::AxisFault, 1));
    assert_ne!(refusal.got.get() as u32 & 2, 0);
    bench.done(ClrSts { core, axis: 1.into(), count: 1.into() });
    assert_eq!(bench.refused(start).1, Reason::AxisFault);
    bench.machine.inputs[0].alarm = false;
    bench.run_ms(1);
    assert_eq!(bench.refused(start).1, Reason::AxisFault);
    bench.done(ClrSts { core, axis: 1.into(), count: 1.into() });
    bench.done(start);
    bench.done(AxisOff { core, axis: profile });
    assert_eq!(bench.status_word(1) & (1 << 9 | 1 << 10), 0);
    assert_eq!(bench.refused(start).1, Reason::ServoOff);
}

/// Nothing is latched at a limit on which an axis stands still: the direction is refused, and
/// ClrSts changes nothing.
#[test]
fn an_update_towards_a_limit_names_the_limit() {
    let mut bench = Bench::gus();
    let (core, profile) = (1.into(), 1.into());
    let text = |bench: &mut Bench<8>| {
        let (code, reason, refusal) = bench.refused(Update { core, mask: 1.into() });
        assert_eq!(code, 1);
        (reason, describe_opcode(Update::OPCODE, refusal).to_string())
    };
    bench.servo_on(1);
    let (acc, dec) = (1.0.into(), 1.0.into());
    bench.done(SetTrapPrm { core, profile, acc, dec, vel_start: 0.0.into(), smooth_time_ms: 0.into() });
    bench.done(SetVel { core, profile, vel: 5.0.into() });
    bench.done(SetSoftLimit { core, axis: profile, positive: 10.into(), negative: (-20).into() });
    let soft = "Update: axis 1 stands at its software limit of 10 pulses; it can only move away from it";
    let other = "Update: axis 1 stands at its software limit of -20 pulses; it can only move away from it";
    for (to, beyond, says) in [(10, 50, soft), (-20, -21, other)] {
        bench.done(SetPos { core, profile, pos: to.into() });
        bench.done(Update { core, mask: 1.into() });
        bench.run_ms(40);
        assert_eq!(bench.pos(1), f64::from(to));
        assert_eq!(bench.status_word(1) & (1 << 5 | 1 << 6), 0, "it came to its target: nothing is latched");
        bench.done(SetPos { core, profile, pos: beyond.into() });
        assert_eq!(text(&mut bench), (Reason::AtSoftLimit, says.into()));
        bench.done(ClrSts { core, axis: profile, count: 1.into() });
        assert_eq!(text(&mut bench).0, Reason::AtSoftLimit);
    }
    bench.done(PrfJog { core, profile });
    bench.done(SetJogPrm { core, profile, acc, dec, smooth: 0.0.into() });
    bench.done(SetVel { core, profile, vel: (-1.0).into() });
    assert_eq!(text(&mut bench), (Reason::AtSoftLimit, other.into()));
    // A switch that is active blocks everything until ClrSts, and its own direction as long as it
    // is active.
    bench.done(LmtsOn { core, axis: profile, limit_type: 0.into() });
    bench.machine.inputs[0].limit_positive = true;
    bench.run_ms(1);
    bench.done(SetVel { core, profile, vel: 1.0.into() });
    let (reason, says) = text(&mut bench);
    assert_eq!(reason, Reason::PositiveLatched);
    assert!(
        says.contains("its positive limit, which is latched") && says.ends_with("call ClrSts, then move it downwards"),
        "{says}"
    );
    bench.done(ClrSts { core, axis: profile, count: 1.into() });
    let says = "Update: axis 1: the limit switch in this direction is active; it can only move away from it";
    assert_eq!(text(&mut bench), (Reason::AtLimitSwitch, says.into()));
    assert_eq!(bench.pos(1), -20.0);
}

#[test]
fn settings_with_ranges() {
    let mut bench = Bench::gus();
    let (core, axis) = (1.into(), 2.into());
    for (smooth, abrupt) in [(0.0, 1.0), (1.0, 0.0), (-1.0, 1.0), (5e9, 1.0)] {
        assert_eq!(
            bench.refused(SetStopDec { core, profile: axis, smooth: smooth.into(), abrupt: abrupt.into() }).0,
            7
        );
    }
    let dec = bench.done(GetStopDec { core, profile: axis });
    assert_eq!((dec.smooth.get(), dec.abrupt.get()), (1.0, 1000.0));
    bench.done(SetStopDec { core, profile: axis, smooth: 0.1.into(), abrupt: 7.0.into() });
    assert_eq!(bench.done(GetStopDec { core, profile: axis }).smooth.get(), 0.1);
    assert_eq!(bench.refused(SetAxisBand { core, axis, band: (-1).into(), time_cycles: 1.into() }).2.field, 2);
    assert_eq!(bench.refused(SetAxisBand { core, axis, band: 1.into(), time_cycles: (-1).into() }).2.field, 3);
    assert_eq!(bench.refused(SetSoftLimit { core, axis, positive: 1.into(), negative: 2.into() }).2.field, 2);
    bench.done(SetSoftLimit { core, axis, positive: 100.into(), negative: i32::MIN.into() });
    assert_eq!(bench.done(GetSoftLimit { core, axis }).positive.get(), 100);
    assert_eq!(bench.refused(SetPosErr { core, control: axis, error: 0.into() }).0, 7);
    bench.done(SetPosErr { core, control: axis, error: 50.into() });
    assert_eq!(bench.done(GetPosErr { core, control: axis }).value.get(), 50);
    assert_eq!(bench.refused(LmtsOn { core, axis, limit_type: 2.into() }).2.field, 2);
    assert_eq!(bench.refused(SetCaptureMode { core, encoder: axis, mode: 0.into() }).2.field, 2);
    // The encoder of axis 1 has an index, that of axis 2 has none.
    bench.done(SetCaptureMode { core, encoder: 1.into(), mode: 2.into() });
    let (code, reason, refusal) = bench.refused(SetCaptureMode { core, encoder: axis, mode: 2.into() });
    assert_eq!((code, reason, refusal.field, refusal.axis.get()), (7, Reason::NoIndex, 2, 2));
    assert_eq!((refusal.got.get(), refusal.low.get(), refusal.high.get()), (2.0, 1.0, 1.0));
    bench.done(SetCaptureMode { core, encoder: axis, mode: 1.into() });
    for tick in [9, 1001, -1] {
        assert_eq!(bench.refused(SetTick { tick_us: tick.into() }).0, 7);
    }
    assert_eq!(bench.refused(SetLinkLoss { time_ms: (-1).into(), stop_all: 0.into() }).0, 7);
    assert_eq!(bench.refused(Stop { core, mask: 1.into(), option: 0.into(), form: 2 }).2.field, 3);
    assert_eq!(bench.refused(Choose { profile: 99, family: 0 }).0, 7);
    assert_eq!(bench.refused(Choose { profile: 0, family: 2 }).0, 7);
    let (code, reason, refusal) = bench.refused(Choose { profile: 5, family: 0 });
    assert_eq!((code, reason, refusal.got.get(), refusal.high.get()), (3, Reason::ProfileTooLarge, 48.0, 8.0));
    assert_eq!(
        bench
            .refused(Trace { every: 1.into(), axes: 0x100.into(), lasers: 0, crds: 0, over_link: 0, edges: 0 })
            .2
            .field,
        1
    );
}

/// Jogs of some axes of core 1.
fn jogging(bench: &mut Bench<24>, axes: &[i16]) {
    let core = 1.into();
    for &axis in axes {
        let profile = axis.into();
        bench.servo_on(axis);
        bench.done(PrfJog { core, profile });
        bench.done(SetJogPrm { core, profile, acc: 1.0.into(), dec: 1.0.into(), smooth: 0.0.into() });
        bench.done(SetVel { core, profile, vel: 10.0.into() });
        bench.done(Update { core, mask: (1 << (axis - 1)).into() });
    }
    bench.run_ms(20);
}

#[test]
fn both_forms_of_stop() {
    let core = 1.into();
    let runs = |bench: &mut Bench<24>, axis: i16| bench.status_word(axis) & 1 << 10 != 0;
    // GTN: one bit for each axis. 24 axes: gtn-024 has two cores of 12.
    let mut bench = Bench::<24>::new(2, 250);
    jogging(&mut bench, &[1, 9, 11, 12]);
    bench.done(Stop { core, mask: 0x500.into(), option: 0x400.into(), form: 0 });
    bench.run_ms(1);
    assert!(!runs(&mut bench, 11), "its option bit: abrupt");
    assert!(runs(&mut bench, 9), "smooth, with 1 pulse/ms² from 10 pulse/ms");
    bench.run_ms(12);
    assert!(!runs(&mut bench, 9));
    assert!(runs(&mut bench, 1) && runs(&mut bench, 12));
    let (code, _, refusal) = bench.refused(Stop { core, mask: 0x1001.into(), option: 0.into(), form: 0 });
    assert_eq!((code, refusal.field, refusal.high.get()), (7, 1, 4095.0));
    // GT: bits 8 to 11 are not axes.
    bench.done(Stop { core, mask: 0xf01.into(), option: 0xf01.into(), form: 1 });
    bench.run_ms(1);
    assert!(!runs(&mut bench, 1));
    assert!(runs(&mut bench, 12), "bit 11 is the power follow of crd 2");
    let (code, _, refusal) = bench.refused(Stop { core, mask: 0x1001.into(), option: 0.into(), form: 1 });
    assert_eq!((code, refusal.field, refusal.high.get()), (7, 1, 4095.0));
    assert_eq!(bench.refused(Stop { core, mask: 1.into(), option: 0.into(), form: 2 }).2.field, 3);
}
