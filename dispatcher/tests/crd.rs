//! Coordinate systems through the whole controller: from calls to positions.

use crate::bench;
use bench::crd::*;
use bench::*;
use protocol::command::*;
use protocol::reason::Reason;
use protocol::record::Lane;

/// A line of 10000 pulses at 50 pulse/ms and 2 pulse/ms²: 25 ms of acceleration, 175 ms at speed,
/// 25 ms of deceleration.
#[test]
fn a_line_takes_its_trapezoid() {
    let mut bench = Bench::gus();
    plane(&mut bench);
    bench.done(line(10_000, 0, 50.0, 2.0));
    assert_eq!(status(&mut bench, 0), (0, 0));
    bench.done(start_crd(1));
    assert_eq!(status(&mut bench, 0).0, 1);
    assert_ne!(bench.status_word(1) & 1 << 10, 0);
    let begun = bench.now().0;
    while status(&mut bench, 0).0 == 1 {
        bench.step();
    }
    let took = (bench.now().0 - begun) as f64 / 1e6;
    assert!((224.0..227.0).contains(&took), "{took}");
    assert_eq!((bench.pos(1), bench.pos(2)), (10_000.0, 0.0));
    assert_eq!(status(&mut bench, 0), (0, 1));
    assert_eq!(bench.status_word(1) & 1 << 10, 0);
    assert_eq!(crd_pos(&mut bench), [10_000.0, 0.0]);
}

/// Content of the FIFOs, counted by call: entries, motions that are done and left.
#[test]
fn slots_and_segments_are_counted() {
    let mut bench = Bench::gus();
    plane(&mut bench);
    assert_eq!((space(&mut bench, 0), space(&mut bench, 1), remainder(&mut bench, 0)), (1024, 1024, 0));
    bench.done(line(1000, 0, 50.0, 2.0));
    bench.done(BufDelay { core: 1.into(), crd: 1.into(), delay_ms: 5.into(), fifo: 0.into() });
    let taken = bench.done(line(1000, 1000, 50.0, 2.0));
    // 1000 pulses at 50 pulse/ms twice, and the delay.
    assert_eq!((taken.taken.get(), taken.space.get(), taken.lasts_ms.get()), (1, 1021, 45));
    assert_eq!((space(&mut bench, 0), remainder(&mut bench, 0), status(&mut bench, 0).1), (1021, 2, 0));
    bench.done(start_crd(1));
    let mut seen = Vec::new();
    while status(&mut bench, 0).0 == 1 {
        let now = (space(&mut bench, 0), remainder(&mut bench, 0), status(&mut bench, 0).1);
        // Each is read in a tick of its own: they belong together where nothing has changed
        // between.
        if space(&mut bench, 0) == now.0 && seen.last() != Some(&now) {
            seen.push(now);
        }
    }
    assert_eq!(seen[..2], [(1021, 2, 0), (1023, 1, 1)], "a motion's place is free when it is over");
    assert_eq!((space(&mut bench, 0), remainder(&mut bench, 0), status(&mut bench, 0).1), (1024, 0, 2));
    bench.done(clear(0));
    assert_eq!((space(&mut bench, 0), status(&mut bench, 0).1), (1024, 0));
    for k in 0..1024 {
        bench.done(line(1000 + k, 0, 50.0, 2.0));
    }
    assert_eq!(space(&mut bench, 0), 0);
    let (code, reason, refusal) = bench.refused(line(9, 9, 50.0, 2.0));
    assert_eq!((code, reason, refusal.got.get(), refusal.high.get()), (1, Reason::CrdFull, 0.0, 1024.0));
    bench.done(prm());
    assert_eq!((space(&mut bench, 0), status(&mut bench, 0).1), (1024, 0));
}

/// FIFO 1 moves the path aside and back; FIFO 0 continues where it stopped. Lines begin where the
/// path is.
#[test]
fn fifo_1_interrupts_and_returns() {
    let mut bench = Bench::gus();
    plane(&mut bench);
    bench.done(line(10_000, 0, 50.0, 2.0));
    bench.done(line(10_000, 10_000, 50.0, 2.0));
    bench.done(start_crd(1));
    bench.run_ms(100);
    bench.done(CrdStop { core: 1.into(), mask: 1.into(), option: 0.into() });
    until_standstill(&mut bench);
    let stopped = crd_pos(&mut bench);
    assert!(stopped[0] > 4000.0 && stopped[0] < 10_000.0 && stopped[1] == 0.0, "{stopped:?}");
    // A quarter turn to the left: from (x, 0) about (x, 1000), given in whole pulses.
    let x = stopped[0].round() as i32;
    bench.done(ArcXYC { fifo: 1.into(), ..arc(x + 1000, 1000, 0.0, 1000.0, 1) });
    bench.done(LnXY { fifo: 1.into(), ..line(0, 5000, 50.0, 2.0) });
    bench.done(CrdStart { option: 1.into(), ..start_crd(1) });
    until_standstill(&mut bench);
    assert_eq!(crd_pos(&mut bench), [0.0, 5000.0]);
    assert_eq!((status(&mut bench, 1).1, remainder(&mut bench, 1), remainder(&mut bench, 0)), (2, 0, 2));
    // FIFO 0 was left elsewhere.
    let (code, reason, refusal) = bench.refused(start_crd(1));
    assert_eq!((code, reason, refusal.got.get()), (1, Reason::CrdElsewhere, 0.0));
    assert_eq!(crd_pos(&mut bench), [0.0, 5000.0]);
    // Back to the nearest whole pulse, and then FIFO 0 continues.
    bench.done(LnXY { fifo: 1.into(), ..line(x, 0, 50.0, 2.0) });
    bench.done(CrdStart { option: 1.into(), ..start_crd(1) });
    until_standstill(&mut bench);
    bench.done(start_crd(1));
    until_standstill(&mut bench);
    assert_eq!((crd_pos(&mut bench), status(&mut bench, 0).1), (vec![10_000.0, 10_000.0], 2));
    // Or it takes other data, when it is cleared.
    bench.done(clear(0));
    bench.done(line(100, 5000, 50.0, 2.0));
    bench.done(start_crd(1));
    until_standstill(&mut bench);
    assert_eq!(crd_pos(&mut bench), [100.0, 5000.0]);
}

/// After an abrupt stop within a line in X the path stands at a position. Motion away and back on
/// FIFO 1 leaves FIFO 0 where it was.
#[test]
fn a_path_goes_on_where_it_was_left() {
    let mut bench = Bench::gus();
    plane(&mut bench);
    bench.done(line(10_000, 0, 50.0, 1000.0));
    bench.done(line(10_000, 10_000, 50.0, 1000.0));
    bench.done(start_crd(1));
    bench.run_ms(50);
    bench.done(CrdStop { core: 1.into(), mask: 1.into(), option: 1.into() });
    let stopped = crd_pos(&mut bench);
    bench.done(start_crd(1));
    until_standstill(&mut bench);
    assert_eq!(crd_pos(&mut bench), [10_000.0, 10_000.0]);
    assert!(stopped[0] < 10_000.0);
    assert_eq!(status(&mut bench, 0).1, 2);
}

/// Stop bits of the GT form, an axis bit, the servo: each stops the path, and the shadow state
/// follows.
#[test]
fn what_stops_a_path() {
    for how in 0..4 {
        let mut bench = Bench::gus();
        plane(&mut bench);
        bench.done(SetCrdStopDec { core: 1.into(), crd: 1.into(), smooth: 5.0.into(), abrupt: 10.0.into() });
        bench.done(line(100_000, 0, 50.0, 2.0));
        bench.done(start_crd(1));
        bench.run_ms(100);
        let at = crd_pos(&mut bench)[0];
        let stop = |mask: i32, form| Stop { core: 1.into(), mask: mask.into(), option: 0.into(), form };
        match how {
            0 => drop(bench.done(stop(1 << 8, 1))),
            1 => drop(bench.done(stop(1 << 1, 0))),
            2 => drop(bench.done(CrdStop { core: 1.into(), mask: 1.into(), option: 0.into() })),
            _ => drop(bench.done(AxisOff { core: 1.into(), axis: 2.into() })),
        }
        until_standstill(&mut bench);
        let travelled = crd_pos(&mut bench)[0] - at;
        // v²/2a = 250 pulses, and what a few ticks of 12.5 pulses take.
        let range = if how == 3 { 0.0..50.0 } else { 245.0..310.0 };
        assert!(range.contains(&travelled), "{how}: {travelled}");
        assert_eq!(status(&mut bench, 0), (0, 0));
        if how == 3 {
            assert_eq!(bench.refused(start_crd(1)).1, Reason::ServoOff);
            bench.servo_on(2);
        }
        bench.done(start_crd(1));
        until_standstill(&mut bench);
        assert_eq!(crd_pos(&mut bench)[0], 100_000.0, "{how}");
    }
}

#[test]
fn an_override_holds_for_all_speeds() {
    let mut bench = Bench::gus();
    plane(&mut bench);
    bench.done(SetOverride { core: 1.into(), crd: 1.into(), ratio: 0.5.into() });
    bench.done(line(10_000, 0, 50.0, 2.0));
    bench.done(start_crd(1));
    let most = until_standstill(&mut bench);
    assert!((most - 25.0).abs() < 1e-6, "{most}");
    bench.done(line(20_000, 0, 50.0, 2.0));
    bench.done(start_crd(1));
    bench.run_ms(100);
    bench.done(SetOverride { core: 1.into(), crd: 1.into(), ratio: 1.0.into() });
    let most = until_standstill(&mut bench);
    assert!((most - 50.0).abs() < 1e-6, "{most}");
    // SetCrdPrm sets it to 1.
    bench.done(SetOverride { core: 1.into(), crd: 1.into(), ratio: 0.1.into() });
    bench.done(prm());
    bench.done(line(10_000, 0, 50.0, 2.0));
    bench.done(start_crd(1));
    let most = until_standstill(&mut bench);
    assert!((most - 50.0).abs() < 1e-6, "{most}");
}

/// Speeds are limited to the maxima of SetCrdPrm; velEnd to synVel.
#[test]
fn speeds_are_held_to_the_maxima() {
    let mut bench = Bench::gus();
    plane(&mut bench);
    bench.done(LnXY { vel_end: 1e9.into(), ..line(100_000, 0, 1e9, 1e9) });
    bench.done(line(200_000, 0, 100.0, 10.0));
    bench.done(start_crd(1));
    let most = until_standstill(&mut bench);
    assert!((most - 500.0).abs() < 1e-6, "{most}");
    assert_eq!(crd_pos(&mut bench), [200_000.0, 0.0]);
}

/// Outputs, analog outputs, another axis that moves, a gear: all act, each takes a slot.
#[test]
fn entries_between_motions_act() {
    let mut bench = Bench::gus();
    plane(&mut bench);
    bench.servo_on(3);
    bench.servo_on(4);
    let (core, crd, fifo) = (1.into(), 1.into(), 0.into());
    bench.done(BufIO { core, crd, do_type: 12.into(), do_mask: 0x0f.into(), do_value: 0xff.into(), fifo });
    bench.done(BufDoBit { core, crd, do_type: 12.into(), index: 2.into(), value: 0.into(), fifo });
    bench.done(BufDA { core, crd, channel: 3.into(), value: (-1234).into(), fifo });
    bench.done(BufMove {
        core,
        crd,
        axis: 3.into(),
        pos: 500.into(),
        vel: 10.0.into(),
        acc: 1.0.into(),
        modal: 1.into(),
        fifo,
    });
    bench.done(BufGear { core, crd, axis: 4.into(), pos: (-700).into(), fifo });
    bench.done(line(1000, 0, 50.0, 2.0));
    assert_eq!(space(&mut bench, 0), 1024 - 6);
    bench.done(start_crd(1));
    bench.step();
    assert_eq!(crd_pos(&mut bench), [0.0, 0.0], "the path waits for axis 3");
    until_standstill(&mut bench);
    assert_eq!((bench.pos(3), bench.pos(4), bench.pos(1)), (500.0, -700.0, 1000.0));
    assert_eq!(bench.machine.outputs.2, 0x0d);
    assert_eq!(bench.machine.analog_out[2], -1234);
    assert_eq!((space(&mut bench, 0), status(&mut bench, 0).1), (1024, 1));
}

/// Origin: where the axes are, or given by axis; the mapping by coordinate.
#[test]
fn origin_and_mapping() {
    let mut bench = Bench::new(1, 250);
    for axis in 1..=3 {
        bench.servo_on(axis);
        let pos = (axis as i32 * 1000).into();
        bench.done(SetPrfPos { core: 1.into(), profile: axis.into(), pos });
    }
    let mut prm = prm();
    // X is axis 3, Y axis 1.
    prm.profile = [2, 0, 1, 0, 0, 0, 0, 0].map(|coordinate: i16| coordinate.into());
    bench.done(prm);
    assert_eq!(crd_pos(&mut bench), [0.0, 0.0]);
    bench.done(line(50, 7, 50.0, 2.0));
    bench.done(start_crd(1));
    until_standstill(&mut bench);
    assert_eq!((bench.pos(1), bench.pos(2), bench.pos(3)), (1007.0, 2000.0, 3050.0));
    prm.set_origin_flag = 1.into();
    prm.origin_pos = [900, 0, 3000, 0, 0, 0, 0, 0].map(|pos: i32| pos.into());
    bench.done(prm);
    assert_eq!(crd_pos(&mut bench), [50.0, 107.0]);
    let reported = bench.done(GetCrdPrm { core: 1.into(), crd: 1.into() });
    assert_eq!({ reported.origin_pos }.map(|pos| pos.get()), [900, 0, 3000, 0, 0, 0, 0, 0]);
    assert_eq!(({ reported.dimension }.get(), { reported.set_origin_flag }.get()), (2, 1));
    // A target where it already is has no length.
    assert_eq!(bench.refused(line(50, 107, 50.0, 2.0)).1, Reason::NoLength);
    let mode = |bench: &mut Bench<16>, axis: i16| {
        let read = GetPrfMode { core: 1.into(), profile: axis.into(), count: 1.into() };
        bench.call(read).items::<GetPrfMode>()[0].value.get()
    };
    assert_eq!([1, 2, 3].map(|axis| mode(&mut bench, axis)), [5, 0, 5]);
    // Another mapping releases an axis; Reset releases all.
    prm.profile = [1, 2, 0, 0, 0, 0, 0, 0].map(|coordinate: i16| coordinate.into());
    bench.done(prm);
    assert_eq!([1, 2, 3].map(|axis| mode(&mut bench, axis)), [5, 5, 0]);
    bench.done(Reset { core: 1.into() });
    assert_eq!([1, 2, 3].map(|axis| mode(&mut bench, axis)), [0, 0, 0]);
    assert_eq!(bench.refused(line(1, 1, 50.0, 2.0)).1, Reason::CrdNotSet);
}

/// The same target twice has no length, also while only the tick knows where the first line begins.
#[test]
fn a_line_to_where_the_one_before_ends_is_refused_while_the_path_runs() {
    let mut bench = Bench::gus();
    plane(&mut bench);
    bench.done(line(1000, 0, 50.0, 2.0));
    bench.done(start_crd(1));
    let other = LnXY { fifo: 1.into(), ..line(9, 5, 50.0, 2.0) };
    bench.done(other);
    assert_eq!(bench.refused(other).1, Reason::NoLength);
}

/// Lines of one record: all or none.
#[test]
fn many_lines_are_all_or_none() {
    let mut bench = Bench::gus();
    plane(&mut bench);
    let many = LnXYMany {
        core: 1.into(),
        crd: 1.into(),
        fifo: 0.into(),
        count: 3.into(),
        syn_vel: 50.0.into(),
        syn_acc: 2.0.into(),
        vel_end: 50.0.into(),
    };
    let head = many;
    let to = |x: i32, y: i32| PathXY { x: x.into(), y: y.into() };
    let answer = bench.call_items(head, &[to(100, 0), to(100, 100), to(100, 100)]);
    let refusal = answer.refusal();
    assert_eq!((answer.code, answer.reason(), refusal.item.get()), (7, Reason::NoLength, 2));
    assert_eq!((space(&mut bench, 0), remainder(&mut bench, 0)), (1024, 0));
    let taken = bench.call_items(head, &[to(100, 0), to(100, 100), to(0, 100)]).reply::<LnXYMany>();
    assert_eq!((taken.taken.get(), taken.space.get()), (3, 1021));
    let head = LnXYZMany {
        core: 1.into(),
        crd: 1.into(),
        fifo: 0.into(),
        count: 1.into(),
        syn_vel: 50.0.into(),
        syn_acc: 2.0.into(),
        vel_end: 0.0.into(),
    };
    let item = PathXYZ { x: 5.into(), y: 5.into(), z: 5.into() };
    let answer = bench.call_items(head, &[item]);
    assert_eq!((answer.code, answer.reason(), answer.refusal().field), (7, Reason::NoCoordinate, 9));
    bench.done(start_crd(1));
    until_standstill(&mut bench);
    assert_eq!(crd_pos(&mut bench), [0.0, 100.0]);
    // If not all lines fit, the first one that does not is named.
    bench.done(clear(0));
    let head = LnXYMany { count: 60.into(), ..many };
    let to = |count: i32| (1..=count).map(|x| to(x, 0)).collect::<Vec<_>>();
    for _ in 0..17 {
        bench.call_items(head, &to(60)).reply::<LnXYMany>();
    }
    let answer = bench.call_items(LnXYMany { count: 7.into(), ..many }, &to(7));
    let refusal = answer.refusal();
    assert_eq!((answer.code, answer.reason(), refusal.item.get(), refusal.got.get()), (1, Reason::CrdFull, 4, 4.0));
    bench.call_items(LnXYMany { count: 4.into(), ..many }, &to(4)).reply::<LnXYMany>();
    assert_eq!(space(&mut bench, 0), 0);
}

/// A program gives its data ahead of its clock, waits, and continues from there; the second run
/// begins where the first ended.
#[test]
fn a_program_waits_for_its_path() {
    let mut bench = Bench::gus();
    bench.servo_on(1);
    bench.servo_on(2);
    let wait = || entry(WaitStop { core: 1.into(), axes: 0.into(), crds: 1.into() });
    let requests = [
        entry(prm()),
        entry(line(10_000, 0, 50.0, 2.0)),
        entry(start_crd(1)),
        wait(),
        entry(GetCrdPos { core: 1.into(), crd: 1.into() }),
        entry(ArcXYC { ..arc(10_000, 0, 0.0, 1000.0, 0) }),
        entry(CrdSpace { core: 1.into(), crd: 1.into(), fifo: 0.into() }),
        entry(start_crd(1)),
        wait(),
        entry(GetCrdPos { core: 1.into(), crd: 1.into() }),
        entry(ProgramEnd {}),
    ];
    let tags = bench.post_all(&requests);
    let start = bench.done(ProgramStart { strict: 1 });
    assert_eq!(start.state, 2);
    let last = bench.wait(tags[10]);
    assert_eq!(last.code, 0);
    for tag in &tags {
        assert_eq!(bench.answers[tag].code, 0, "{:?}", bench.answers[tag]);
    }
    let pos = |tag: u16| -> Vec<f64> {
        bench.answers[&tag].items::<GetCrdPos>().iter().map(|item| item.value.get()).collect()
    };
    assert_eq!((pos(tags[4]), pos(tags[9])), (vec![10_000.0, 0.0], vec![10_000.0, 0.0]));
    assert_eq!(bench.answers[&tags[6]].reply::<CrdSpace>().value.get(), 1023);
    // 225 ms of line; a circle of 6283.19 pulses: 125.66 ms and 25 more for the ramps.
    let clock = bench.done(ProgramStatus {}).clock_ns.get() as f64 / 1e6;
    assert!((375.6..376.5).contains(&clock), "{clock}");
    assert_eq!(bench.done(ProgramStatus {}).late.get(), 0);
}

/// Data that comes to a FIFO after its start may run or not: the path may have ended before. After
/// the WaitStop an arc of the other FIFO begins where the path is, and the data is still there.
#[test]
fn data_after_the_end_of_a_path_is_not_taken_as_run() {
    let wait = || entry(WaitStop { core: 1.into(), axes: 0.into(), crds: 1.into() });
    for (slept, waits, ran) in [(15, 0, false), (15, 4, false), (2, 0, true), (2, 4, true)] {
        let mut bench = Bench::gus();
        plane(&mut bench);
        let at = if ran { [20, 5] } else { [10, 0] };
        let requests = [
            entry(line(10, 0, 50.0, 2.0)),
            entry(start_crd(1)),
            entry(sleep(slept)),
            entry(line(20, 5, 50.0, 2.0)),
            wait(),
            entry(sleep(waits)),
            entry(ArcXYC { fifo: 1.into(), ..arc(at[0], at[1], 0.0, 100.0, 1) }),
            entry(CrdStart { option: 1.into(), ..start_crd(1) }),
            entry(sleep(20)),
            entry(GetCrdPos { core: 1.into(), crd: 1.into() }),
            wait(),
            entry(CrdStatus { core: 1.into(), crd: 1.into(), fifo: 0.into() }),
            entry(CrdSpace { core: 1.into(), crd: 1.into(), fifo: 0.into() }),
            entry(ProgramEnd {}),
        ];
        let tags = bench.post_all(&requests);
        bench.done(ProgramStart { strict: 0 });
        bench.wait(tags[13]);
        for (index, tag) in tags.iter().enumerate() {
            let answer = &bench.answers[tag];
            assert_eq!(answer.code, 0, "entry {index}: {:?}", answer.reason());
        }
        let on_arc: Vec<f64> =
            bench.answers[&tags[9]].items::<GetCrdPos>().iter().map(|item| item.value.get()).collect();
        let radius = (on_arc[0] - f64::from(at[0])).hypot(on_arc[1] - f64::from(at[1]) - 100.0);
        assert!((radius - 100.0).abs() < 1e-3 && on_arc[0] != f64::from(at[0]), "{on_arc:?}");
        assert_eq!(crd_pos(&mut bench), at.map(f64::from));
        let done = bench.answers[&tags[11]].reply::<CrdStatus>().segment.get();
        let space = bench.answers[&tags[12]].reply::<CrdSpace>().value.get();
        assert_eq!((done, space), if ran { (2, 1024) } else { (1, 1023) });
    }
}

/// Entries of a program that were not executed leave no trace in a FIFO.
#[test]
fn a_program_that_is_dropped_takes_its_data_with_it() {
    for look in [false, true] {
        let mut bench = Bench::gus();
        plane(&mut bench);
        if look {
            bench.done(ahead(5.0, 2.0, 100));
        }
        bench.done(line(1000, 0, 50.0, 2.0));
        let bad = LnXY { syn_vel: (-1.0).into(), ..line(5, 5, 50.0, 2.0) };
        let tags = bench.post_all(&[entry(sleep(10)), entry(line(2000, 0, 50.0, 2.0)), entry(bad)]);
        bench.done(ProgramStart { strict: 0 });
        bench.run_ms(5);
        bench.done(ProgramClear {});
        let codes: Vec<i16> = tags.iter().map(|tag| bench.wait(*tag).code).collect();
        assert_eq!(codes, [0, 1, 1]);
        if look {
            // The content before cannot be reconstructed with a look-ahead.
            assert_eq!((space(&mut bench, 0), remainder(&mut bench, 0)), (1024, 0));
            bench.done(line(1000, 0, 50.0, 2.0));
        }
        assert_eq!((space(&mut bench, 0), remainder(&mut bench, 0)), (1023, 1));
        bench.done(start_crd(1));
        until_standstill(&mut bench);
        assert_eq!((crd_pos(&mut bench), status(&mut bench, 0).1), (vec![1000.0, 0.0], 1));
    }
}

/// TCrdData's own motions; a point that is wrong names its field.
#[test]
fn points_of_tcrddata() {
    let mut bench = Bench::gus();
    plane(&mut bench);
    let head = CrdData { core: 1.into(), crd: 1.into(), fifo: 0.into() };
    let point = CrdPoint {
        motion_type: 0.into(),
        pos: [100, 200, 0, 0].map(|pos: i32| pos.into()),
        vel: 50.0.into(),
        acc: 2.0.into(),
        ..CrdPoint::default()
    };
    let arc = CrdPoint {
        motion_type: 1.into(),
        radius: 50.0.into(),
        pos: [200, 200, 0, 0].map(|pos: i32| pos.into()),
        ..point
    };
    for point in [point, arc] {
        assert_eq!(bench.call_items(head, &[point]).reply::<CrdData>().taken.get(), 1);
    }
    let wrong = CrdPoint { vel: 0.0.into(), ..point };
    let refusal = bench.call_items(head, &[wrong]).refusal();
    assert_eq!((refusal.field, refusal.got.get()), (3 + 6, 0.0));
    assert_eq!(bench.call_items(head, &[]).reply::<CrdData>().taken.get(), 0);
    bench.done(start_crd(1));
    until_standstill(&mut bench);
    assert_eq!((crd_pos(&mut bench), status(&mut bench, 0).1), (vec![200.0, 200.0], 2));
}

/// Data for a path beside a running program does not wait: it is refused.
#[test]
fn nothing_is_given_beside_a_program() {
    let mut bench = Bench::gus();
    plane(&mut bench);
    let tags = bench.post_all(&[entry(sleep(50)), entry(ProgramEnd {})]);
    bench.done(ProgramStart { strict: 0 });
    assert_eq!(bench.refused(line(1, 1, 1.0, 1.0)).1, Reason::ProgramRuns);
    assert_eq!(space(&mut bench, 0), 1024);
    bench.wait(tags[1]);
    let tag = bench.post(Lane::Immediate, line(1, 1, 1.0, 1.0), &[]);
    assert_eq!(bench.wait(tag).code, 0);
}

/// The same in a program, which gives FIFO 1 its lines directly after the WaitStop: nothing is
/// late.
#[test]
fn a_program_interrupts_and_returns() {
    let mut bench = Bench::gus();
    plane(&mut bench);
    let wait = || entry(WaitStop { core: 1.into(), axes: 0.into(), crds: 1.into() });
    let on_1 = |x, y| entry(LnXY { fifo: 1.into(), ..line(x, y, 50.0, 2.0) });
    let read = |fifo: i16| entry(CrdStatus { core: 1.into(), crd: 1.into(), fifo: fifo.into() });
    let requests = [
        entry(line(10_000, 0, 50.0, 2.0)),
        entry(line(10_000, 6000, 50.0, 2.0)),
        entry(start_crd(1)),
        entry(sleep(100)),
        entry(Stop { core: 1.into(), mask: 0x100.into(), option: 0.into(), form: 1 }),
        wait(),
        on_1(4500, -3000),
        on_1(4500, 0),
        entry(CrdStart { option: 1.into(), ..start_crd(1) }),
        wait(),
        entry(start_crd(1)),
        wait(),
        read(0),
        read(1),
        entry(ProgramEnd {}),
    ];
    let tags = bench.post_all(&requests);
    bench.done(ProgramStart { strict: 1 });
    bench.wait(tags[14]);
    for (index, tag) in tags.iter().enumerate() {
        let answer = &bench.answers[tag];
        assert_eq!(answer.code, 0, "entry {index}: {:?}", answer.reason());
    }
    let segment = |tag: u16| bench.answers[&tag].reply::<CrdStatus>().segment.get();
    assert_eq!((segment(tags[12]), segment(tags[13])), (2, 2));
    assert_eq!(bench.done(ProgramStatus {}).late.get(), 0);
    assert_eq!(crd_pos(&mut bench), [10_000.0, 6000.0]);
}
