//! The counts of every product (GXN tables 5-1 to 5-3), and the first value beyond each.

use crate::bench;
use bench::crd::*;
use bench::*;
use protocol::command::*;
use protocol::reason::Reason;
use protocol::record::Lane;

/// Name, general inputs and outputs, coordinate systems of a core below a tick of 500 µs and from
/// there on.
const TABLES: [(&str, i16, i16, [i16; 2]); 9] = [
    ("gus", 32, 32, [2, 2]),
    ("gtn-016", 44, 20, [2, 2]),
    ("gtn-024", 66, 30, [2, 2]),
    ("gsn-008-lt", 100, 40, [2, 4]),
    ("gsn-024", 100, 40, [2, 4]),
    ("gsn-048", 100, 40, [2, 4]),
    ("r688c-024", 100, 64, [2, 2]),
    ("r688s-016", 64, 64, [4, 4]),
    ("r688s-032", 64, 64, [4, 4]),
];

fn set_bit(core: i16, index: i16) -> SetDoBit {
    SetDoBit { core: core.into(), do_type: 12.into(), index: index.into(), value: 1.into() }
}

fn words(bench: &mut Bench<48>, core: i16, count: i16) -> Vec<u32> {
    let read = GetDoEx { core: core.into(), do_type: 12.into(), count: count.into() };
    bench.call(read).items::<GetDoEx>().iter().map(|word| word.value.get().cast_unsigned()).collect()
}

#[test]
fn every_product_has_its_general_inputs_and_outputs() {
    let mut bench = Bench::<48>::new(8, 500);
    for (number, (name, inputs, outputs, _)) in TABLES.into_iter().enumerate() {
        assert_eq!(dispatcher::PROFILES[number].name, name);
        let version = bench.done(Choose { profile: number as u8, family: 0 });
        assert_eq!(
            (i16::from(version.general_inputs), i16::from(version.general_outputs)),
            (inputs, outputs),
            "{name}"
        );
        let core = i16::from(version.cores);
        // Outputs: by their numbers, by words, in a path; they belong to all cores.
        bench.done(set_bit(core, outputs));
        assert_eq!(bench.machine.outputs.2, 1 << (outputs - 1), "{name}");
        let (code, reason, refusal) = bench.refused(set_bit(1, outputs + 1));
        assert_eq!((code, reason, refusal.high.get()), (7, Reason::Selector, f64::from(outputs)), "{name}");
        let all = u64::MAX >> (64 - outputs);
        let items: Vec<Long> =
            [all as u32, (all >> 32) as u32].map(|word| Long { value: word.cast_signed().into() }).into();
        let count = usize::from(outputs > 32) + 1;
        let set = |count: usize| SetDoEx { core: core.into(), do_type: 12.into(), count: (count as u16).into() };
        assert_eq!(bench.call_items(set(count), &items[..count]).code, 0, "{name}");
        assert_eq!(bench.machine.outputs.2, all, "{name}");
        assert_eq!(words(&mut bench, 1, 4), [all as u32, (all >> 32) as u32, 0, 0], "{name}");
        assert_eq!(words(&mut bench, 1, 1), [all as u32], "{name}");
        assert_eq!(bench.done(GetDo { core: 1.into(), do_type: 12.into() }).value.get(), (all as u32).cast_signed());
        // One word leaves the others; a bit too many is refused and changes nothing.
        let low = Long { value: 1.into() };
        assert_eq!(bench.call_items(set(1), &[low]).code, 0);
        assert_eq!(bench.machine.outputs.2, all & !0xffff_ffff | 1, "{name}");
        if outputs % 32 != 0 {
            let mut beyond = items.clone();
            beyond[count - 1] = Long { value: (1 << (outputs % 32)).into() };
            let answer = bench.call_items(set(count), &beyond[..count]);
            let refusal = answer.refusal();
            assert_eq!((answer.code, answer.reason(), refusal.field), (7, Reason::OutOfRange, 3), "{name}");
            assert_eq!(refusal.high.get(), f64::from(2u32.pow((outputs % 32) as u32) - 1), "{name}");
        }
        let answer = bench.call_items(set(count + 1), &vec![low; count + 1]);
        assert_eq!((answer.code, answer.refusal().high.get()), (7, count as f64), "{name}");
        assert_eq!(bench.machine.outputs.2, all & !0xffff_ffff | 1, "{name}");
        plane(&mut bench);
        let bit = |index: i16| BufDoBit {
            core: 1.into(),
            crd: 1.into(),
            do_type: 12.into(),
            index: (index as u16).into(),
            value: 1.into(),
            fifo: 0.into(),
        };
        bench.done(bit(outputs));
        assert_eq!(bench.refused(bit(outputs + 1)).2.high.get(), f64::from(outputs), "{name}");
        bench.done(start_crd(1));
        until_standstill(&mut bench);
        assert_eq!(bench.machine.outputs.2 >> (outputs - 1), 1, "{name}");
        // Inputs: the bench has the low byte 0x5a.
        let read = GetDiEx { core: core.into(), di_type: 4.into(), count: 4.into() };
        let seen: Vec<i32> = bench.call(read).items::<GetDiEx>().iter().map(|word| word.value.get()).collect();
        assert_eq!(seen, [0x5a, 0, 0, 0], "{name}");
        bench.done(AxisOn { core: 1.into(), axis: 3.into() });
        bench.done(PrfFollowEx { core: 1.into(), profile: 3.into(), dir: 0.into() });
        let wait = |index: i16| FollowDiBitEx {
            core: 1.into(),
            profile: 3.into(),
            di_type: 4.into(),
            index: index.into(),
            value: 1.into(),
            time_ms: 5.into(),
            fifo: 0.into(),
        };
        bench.done(wait(inputs));
        let (code, _, refusal) = bench.refused(wait(inputs + 1));
        assert_eq!((code, refusal.high.get()), (7, f64::from(inputs)), "{name}");
        bench.done(Reset { core: 1.into() });
        bench.done(SetDo { core: 1.into(), do_type: 12.into(), value: 0.into() });
        if count > 1 {
            assert_eq!(bench.call_items(set(2), &[Long::default(); 2]).code, 0);
        }
    }
    for (read, count) in [(1, 0), (1, -1), (6, 1)] {
        let read = GetDiEx { core: 1.into(), di_type: read.into(), count: count.into() };
        assert_eq!(bench.refused(read).0, 7);
    }
    let read = GetDoEx { core: 1.into(), do_type: 4.into(), count: 1.into() };
    assert_eq!(bench.refused(read).0, 7);
}

/// X on axis 1 + `skip`, Y on the one after it.
fn on_axes(core: i16, crd: i16, skip: usize) -> SetCrdPrm {
    let mut profile = [0i16; 8];
    (profile[skip], profile[skip + 1]) = (1, 2);
    SetCrdPrm { core: core.into(), crd: crd.into(), profile: profile.map(Into::into), ..prm() }
}

#[test]
fn coordinate_systems_are_those_of_the_tick() {
    let mut bench = Bench::<48>::new(0, 250);
    for (number, (name, _, _, crds)) in TABLES.into_iter().enumerate() {
        let version = bench.done(Choose { profile: number as u8, family: 0 });
        let core = i16::from(version.cores);
        for axis in 1..=8 {
            bench.done(AxisOn { core: core.into(), axis: axis.into() });
        }
        for (tick, most) in [(250, crds[0]), (499, crds[0]), (500, crds[1]), (1000, crds[1])] {
            bench.done(SetTick { tick_us: tick.into() });
            for crd in 1..=most {
                bench.done(on_axes(core, crd, 2 * (usize::from(crd.unsigned_abs()) - 1)));
            }
            let (code, reason, refusal) = bench.refused(on_axes(core, most + 1, 0));
            let fewer = most < crds[1];
            let expected = if fewer { Reason::CrdOfTick } else { Reason::Selector };
            assert_eq!((code, reason, refusal.high.get()), (7, expected, most.into()), "{name} at {tick}");
            let mask = 1 << most;
            let start = CrdStart { core: core.into(), mask: mask.into(), option: 0.into() };
            assert_eq!((bench.refused(start).0, bench.refused(start).2.high.get()), (7, f64::from(mask - 1)));
            let map = |map: i16| SetLaserCrdMap { core: core.into(), channel: 0.into(), map: map.into() };
            bench.done(map(mask - 1));
            assert_eq!(bench.refused(map(mask)).2.high.get(), f64::from(mask - 1), "{name} at {tick}");
            let read = GetLaserCrdMap { core: core.into(), channel: 0.into() };
            assert_eq!(bench.done(read).value.get(), mask - 1, "{name} at {tick}");
        }
        // A shorter tick period would take the last ones away from their axes.
        if crds[0] < crds[1] {
            let short = SetTick { tick_us: 250.into() };
            let (code, reason, refusal) = bench.refused(short);
            assert_eq!((code, reason, refusal.axis.get()), (1, Reason::CrdNeedsTick, crds[0] + 1), "{name}");
            assert_eq!((refusal.low.get(), refusal.high.get()), (core.into(), crds[0].into()), "{name}");
            // What follows in the same message has the new tick period, though it has not acted
            // yet.
            bench.done(Reset { core: core.into() });
            bench.done(AxisOn { core: core.into(), axis: 1.into() });
            bench.done(AxisOn { core: core.into(), axis: 2.into() });
            let third = || (SetCrdPrm::OPCODE, Lane::Immediate, body(on_axes(core, crds[1], 0), &[]));
            let tick = |us: i32| (SetTick::OPCODE, Lane::Immediate, body(SetTick { tick_us: us.into() }, &[]));
            let tags = bench.post_all(&[tick(250), third(), tick(500), third()]);
            let codes: Vec<i16> = tags.iter().map(|tag| bench.wait(*tag).code).collect();
            assert_eq!(codes, [0, 7, 0, 0], "{name}");
            bench.done(Reset { core: core.into() });
        }
        bench.done(SetTick { tick_us: 250.into() });
    }
}
