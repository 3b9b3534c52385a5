//! Masters, over the wire: each `masterItem` of an axis, of the own core and of the other one; the
//! crossing of an encoder between its samples; cycles across cores.
use crate::bench;
use bench::follow::{data_ex, prf_ex};
use bench::{Bench, pt_item};
use protocol::command::*;
use protocol::reason::{Reason, describe_opcode};

/// Tolerance of a planned position between knots: 2⁻¹⁶ pulse.
const EXACT_TOLERANCE_PULSES: f64 = 1.0 / 65536.0;
const PLANNED_PULSES: f64 = 100.4;
/// The bench's encoder is the whole pulse.
const COUNTED_PULSES: f64 = 100.0;

fn position(bench: &mut Bench<16>, core: i16, first: i16, count: u16) -> Vec<f64> {
    let read = GetPrfPos { core: core.into(), profile: first.into(), count: (count as i16).into() };
    bench.call(read).items::<GetPrfPos>().iter().map(|item| item.value.get()).collect()
}

fn set_master(core: i16, axis: i16, [index, kind, item]: [i16; 3]) -> SetFollowMaster {
    SetFollowMaster {
        core: core.into(),
        profile: axis.into(),
        master_index: index.into(),
        master_type: kind.into(),
        master_item: item.into(),
    }
}

/// Axes 2 to 6 of core 1 follow axis 1 of a core one to one, with items 0 to 3 and another; it
/// moves 100.4 pulses.
fn items(of: i16, kind: i16) {
    let mut bench = Bench::<16>::new(1, 250); // gtn-016: two cores of eight axes
    let (core, profile) = (of.into(), 1.into());
    bench.done(AxisOn { core, axis: profile });
    bench.done(PrfPt { core, profile, mode: 0.into() });
    bench.done(PtData {
        core,
        profile,
        pos: PLANNED_PULSES.into(),
        time_ms: 20.into(),
        kind: 0.into(),
        fifo: 0.into(),
    });
    for (axis, item) in [(2, 0), (3, 1), (4, 2), (5, 3), (6, 7)] {
        bench.servo_on(axis);
        bench.done(bench::follow::prf(axis, 0));
        bench.done(set_master(1, axis, [1, kind, item]));
        bench.done(bench::follow::data(axis, 1000, 1000.0, 1, 0));
    }
    bench.done(bench::follow::start(0x3e, 0));
    bench.done(PtStart { core, mask: 1.into(), option: 0.into() });
    bench.run_ms(15);
    // During motion, sampled in one tick: the filtered positions lag.
    let at = position(&mut bench, 1, 2, 5);
    let [planned, encoder, planned_filtered, encoder_filtered, other] = at[..] else { panic!("{at:?}") };
    assert_eq!((encoder.fract(), other), (0.0, encoder), "{at:?}");
    assert!(encoder < planned && planned_filtered < planned - 0.5 && encoder_filtered < encoder - 0.5, "{at:?}");
    bench.run_ms(500);
    assert!((position(&mut bench, of, 1, 1)[0] - PLANNED_PULSES).abs() < EXACT_TOLERANCE_PULSES);
    for (at, (end, item)) in position(&mut bench, 1, 2, 5).iter().zip([
        (PLANNED_PULSES, 0),
        (COUNTED_PULSES, 1),
        (PLANNED_PULSES, 2),
        (COUNTED_PULSES, 3),
        (COUNTED_PULSES, 7),
    ]) {
        assert!((at - end).abs() < EXACT_TOLERANCE_PULSES, "item {item}: {at} is not {end}");
    }
}

#[test]
fn items_of_an_axis() {
    items(1, 3);
}

#[test]
fn items_of_an_axis_of_the_other_core() {
    items(2, 103);
}

#[test]
fn an_encoder_crosses_between_its_samples() {
    let mut bench = Bench::gus();
    let (core, master, profile) = (1.into(), 1.into(), 2.into());
    bench.servo_on(1);
    bench.servo_on(2);
    // 8 pulse/ms, two pulses a tick, from a tick on: the encoder's samples are even.
    bench.done(PrfPt { core, profile: master, mode: 0.into() });
    let even = pt_item(800.0, 100, 1);
    let (pos, time_ms, kind) = (even.pos, even.time_ms, i16::from(even.kind).into());
    bench.done(PtData { core, profile: master, pos, time_ms, kind, fifo: 0.into() });
    bench.done(prf_ex(2, 0));
    bench.done(SetFollowMasterEx { core, profile, master_index: master, master_type: 1.into(), master_item: 0.into() });
    bench.done(SetFollowEventEx { core, profile, event: 2.into(), master_dir: 1.into(), pos: 101.into() });
    bench.done(data_ex(2, 50.0, 50.0, 1, 0, 0));
    bench.done(FollowDelayEx { core, profile, delay_cycles: 1.into(), fifo: 0.into() });
    bench.done(data_ex(2, 10_000.0, 10_000.0, 1, 0, 0));
    bench.done(FollowStartEx { core, mask: 2.into(), option: 0.into() });
    bench.done(PtStart { core, mask: 1.into(), option: 0.into() });
    bench.run_ms(12);
    assert_eq!(bench.pos(2), 0.0, "it waits");
    bench.run_ms(150);
    assert_eq!(bench.pos(1), 800.0);
    // From 101 to 151, each halfway between two samples; one cycle later, halfway again, the
    // encoder is at 153.
    assert!((bench.pos(2) - (50.0 + (800.0 - 153.0))).abs() < EXACT_TOLERANCE_PULSES, "{}", bench.pos(2));
}

#[test]
fn a_cycle_across_cores() {
    let mut bench = Bench::<16>::new(1, 250);
    for (core, axis) in [(1, 1), (2, 2), (1, 3)] {
        bench.done(PrfFollow { core: i16::into(core), profile: i16::into(axis), dir: 0.into() });
    }
    // Axis 1 of core 1 follows axis 2 of core 2, which follows the encoder of axis 3 of core 1.
    bench.done(set_master(1, 1, [2, 103, 2]));
    bench.done(set_master(2, 2, [3, 101, 0]));
    for (kind, item) in [(1, 0), (2, 0), (3, 0), (3, 3)] {
        let (code, reason, refusal) = bench.refused(set_master(1, 3, [1, kind, item]));
        assert_eq!((code, reason, refusal.field), (1, Reason::MasterCycle, 2));
        let text = describe_opcode(SetFollowMaster::OPCODE, refusal).to_string();
        assert!(text.ends_with("axis 3 would follow itself by way of axis 2 of core 2"), "{text}");
    }
    let (core, profile) = (1.into(), 3.into());
    assert_eq!(bench.done(GetFollowMaster { core, profile }).master_index.get(), 0, "nothing was taken");
    // The same axis numbers of other cores are no cycle.
    bench.done(set_master(1, 3, [1, 103, 3]));
    assert_eq!(bench.refused(GetFollowMaster { core: 2.into(), profile: 3.into() }).1, Reason::WrongMode);
}
