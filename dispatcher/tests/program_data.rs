//! Data in the program queue: admitted ahead of its instant, committed in time, streams.
use crate::bench;
use bench::{Bench, MS, body, entry, position, pt_data, pt_item, read_pos, sleep, start, wait_stop};
use protocol::command::*;
use protocol::reason::Reason;
use protocol::record::Lane;

const CORE: i16 = 1;

/// Segments of 1 ms that `axes` streams get before their start.
const AHEAD_SEGMENTS: i32 = 2000;

/// The data before the start of eight streams: records of `share` segments, from axis to axis.
fn prefill(share: i32) -> Vec<(u16, Lane, Vec<u8>)> {
    let mut entries = Vec::new();
    for axis in 1..=8 {
        entries.push(entry(AxisOn { core: CORE.into(), axis: axis.into() }));
        entries.push(entry(PrfPt { core: CORE.into(), profile: axis.into(), mode: 1.into() }));
        entries.push(entry(SetPtMemory { core: CORE.into(), profile: axis.into(), memory: 1.into() }));
    }
    for part in 0..AHEAD_SEGMENTS / share {
        for axis in 1..=8i16 {
            let items: Vec<PtItem> = (1..=share)
                .map(|i| part * share + i)
                .map(|t| pt_item(f64::from(t * i32::from(axis)), t, if t == AHEAD_SEGMENTS { 2 } else { 1 }))
                .collect();
            let many =
                PtDataMany { core: CORE.into(), profile: axis.into(), fifo: 0.into(), count: (share as u16).into() };
            entries.push((PtDataMany::OPCODE, Lane::Program, body(many, &items)));
        }
    }
    entries
}

#[test]
fn a_held_program_takes_all_data_before_its_start() {
    // The last has more records than the ring has entries.
    for share in [50, 25, 20] {
        let mut bench = Bench::gus();
        let mut tags = Vec::new();
        for one in prefill(share) {
            tags.extend(bench.post_all(&[one]));
            // Each is admitted by itself, as it is when a slow link brings it.
            bench.step();
        }
        let core = CORE.into();
        tags.extend(bench.post_all(&[
            entry(start(0xff)),
            entry(wait_stop(0xff)),
            entry(GetPrfPos { core, profile: 1.into(), count: 8.into() }),
            entry(ProgramEnd {}),
        ]));
        bench.run_ms(5);
        assert!(tags.iter().all(|tag| !bench.answers.contains_key(tag)), "held: nothing is executed or refused");
        bench.done(ProgramStart { strict: 1 });
        for (index, &tag) in tags.iter().enumerate() {
            let answer = bench.wait(tag);
            assert_eq!(answer.code, 0, "{share} a record, entry {index}: {answer:?}");
        }
        let reached: Vec<f64> =
            bench.answers[&tags[tags.len() - 2]].items::<GetPrfPos>().iter().map(|pos| pos.value.get()).collect();
        assert_eq!(reached, (1..=8).map(|axis| f64::from(AHEAD_SEGMENTS * axis)).collect::<Vec<_>>());
        let status = bench.done(ProgramStatus {});
        assert_eq!((status.late.get(), status.worst_late_us.get()), (0, 0), "{share} a record");
        assert_eq!(status.clock_ns.get(), AHEAD_SEGMENTS as u64 * MS + 250_000);
        for axis in 1..=8 {
            assert_eq!(bench.done(GetPtState { core, profile: axis.into() }).state, 2, "no underrun");
        }
    }
}

#[test]
fn data_after_a_start_is_admitted_while_the_program_is_held() {
    for mode in [0, 1] {
        let mut bench = Bench::gus();
        let (core, profile) = (CORE.into(), 1.into());
        let mut entries = vec![
            entry(AxisOn { core, axis: profile }),
            entry(PrfPt { core, profile, mode: mode.into() }),
            entry(SetPtMemory { core, profile, memory: 1.into() }),
            entry(pt_data(1, 10.0, 100)),
            entry(start(1)),
            entry(sleep(50)),
        ];
        let (before, space) = (entries.len(), bench.done(ProgramStatus {}).space_bytes.get());
        entries.extend([
            entry(PtData { kind: 2.into(), ..pt_data(1, 20.0, 200) }),
            entry(wait_stop(1)),
            entry(read_pos(1)),
            entry(ProgramEnd {}),
        ]);
        bench.post_all(&entries[..before]);
        let tags = bench.post_all(&entries[before..]);
        bench.run_ms(5);
        assert_eq!(bench.done(ProgramStatus {}).space_bytes.get(), space, "mode {mode}: nothing waits in the queue");
        bench.done(ProgramStart { strict: 1 });
        assert!(tags.iter().all(|&tag| bench.wait(tag).code == 0));
        assert_eq!(position(&bench.answers[&tags[2]]), 20.0);
    }
}

#[test]
fn data_that_comes_piece_by_piece_while_the_program_sleeps_is_in_time() {
    let mut bench = Bench::gus();
    let mut tags = bench.post_all(&[entry(sleep(1500))]);
    bench.done(ProgramStart { strict: 1 });
    let mut entries = prefill(25);
    entries.extend([entry(start(0xff)), entry(wait_stop(0xff)), entry(read_pos(8)), entry(ProgramEnd {})]);
    for one in entries {
        tags.extend(bench.post_all(&[one]));
        bench.step();
    }
    for (index, &tag) in tags.iter().enumerate() {
        assert_eq!(bench.wait(tag).code, 0, "entry {index}");
    }
    assert_eq!(position(&bench.answers[&tags[tags.len() - 2]]), f64::from(AHEAD_SEGMENTS * 8));
    let status = bench.done(ProgramStatus {});
    assert_eq!((status.late.get(), status.clock_ns.get()), (0, (1500 + AHEAD_SEGMENTS as u64) * MS + 250_000));
}

#[test]
fn a_stream_short_of_data_gets_each_record_in_time() {
    let mut bench = Bench::gus();
    let (core, profile) = (CORE.into(), 1.into());
    let segment = |i: i32| entry(PtData { kind: 1.into(), ..pt_data(1, f64::from(i), i) });
    let mut tags = bench.post_all(&[
        entry(AxisOn { core, axis: profile }),
        entry(PrfPt { core, profile, mode: 1.into() }),
        segment(1),
        segment(2),
        segment(3),
        entry(start(1)),
    ]);
    bench.done(ProgramStart { strict: 0 });
    // The data of each ms comes in the ms before it is needed, for an instant that is over.
    for i in 4..200 {
        tags.extend(bench.post_all(&[segment(i)]));
        bench.run_ms(1);
    }
    tags.extend(bench.post_all(&[
        entry(PtData { kind: 2.into(), ..pt_data(1, 201.0, 201) }),
        entry(wait_stop(1)),
        entry(read_pos(1)),
        entry(ProgramEnd {}),
    ]));
    for (index, &tag) in tags.iter().enumerate() {
        assert_eq!(bench.wait(tag).code, 0, "entry {index}");
    }
    assert_eq!(position(&bench.answers[&tags[tags.len() - 2]]), 201.0);
    assert_eq!(bench.done(GetPtState { core, profile }).state, 2, "no underrun");
}

#[test]
fn a_dynamic_stream_longer_than_its_ring() {
    let mut bench = Bench::gus();
    let (core, profile) = (CORE.into(), 1.into());
    let mut entries = vec![entry(AxisOn { core, axis: profile }), entry(PrfPt { core, profile, mode: 1.into() })];
    // 300 segments of 4 ms at 1 pulse/ms into a ring of 64. The first 40 before the start.
    let segment = |i: i32| entry(PtData { kind: 1.into(), ..pt_data(1, f64::from(i) * 4.0, i * 4) });
    entries.extend((1..=40).map(segment));
    entries.push(entry(start(1)));
    entries.extend((41..300).flat_map(|i| [entry(sleep(4)), segment(i)]));
    entries.push(entry(PtData { kind: 2.into(), ..pt_data(1, 1202.0, 1204) }));
    entries.extend([entry(wait_stop(1)), entry(read_pos(1)), entry(ProgramEnd {})]);
    let mut tags = Vec::new();
    let mut rest = &entries[..];
    // The client keeps within the room that was reported.
    let mut started = false;
    while !rest.is_empty() {
        let mut room = bench.done(ProgramStatus {}).space_bytes.get() as usize;
        let mut used = 0;
        let mut now = 0;
        for (_, _, body) in rest {
            let cost = body.len() + 7;
            if cost > room || used + cost > 1000 {
                break;
            }
            (room, used, now) = (room - cost, used + cost, now + 1);
        }
        if now == 0 || tags.len() > 250 {
            if !started {
                started = true;
                bench.done(ProgramStart { strict: 1 });
            }
            bench.run_ms(1);
        }
        if now > 0 {
            tags.extend(bench.post_all(&rest[..now]));
            rest = &rest[now..];
        }
    }
    for (index, &tag) in tags.iter().enumerate() {
        let answer = bench.wait(tag);
        assert_eq!(answer.code, 0, "entry {index}: {answer:?}");
    }
    assert_eq!(position(&bench.wait(tags[tags.len() - 2])), 1202.0);
    let state = bench.done(GetPtState { core, profile });
    assert_eq!((state.state, state.space0.get()), (2, 64));
    // The stream is over: the next one counts from 0.
    bench.done(pt_data(1, 1.0, 1));
}

#[test]
fn data_after_wait_stop_is_in_time() {
    for mode in [0, 1] {
        let mut bench = Bench::gus();
        let (core, profile) = (CORE.into(), 1.into());
        let mut entries =
            vec![entry(AxisOn { core, axis: profile }), entry(PrfPt { core, profile, mode: mode.into() })];
        for _ in 0..3 {
            entries.extend([
                entry(PtClear { core, profile, fifo: 0.into() }),
                entry(pt_data(1, 10.0, 10)),
                entry(PtData { kind: 2.into(), ..pt_data(1, 20.0, 20) }),
                entry(start(1)),
                entry(wait_stop(1)),
            ]);
        }
        entries.extend([entry(read_pos(1)), entry(ProgramEnd {})]);
        let tags = bench.post_all(&entries);
        bench.done(ProgramStart { strict: 1 });
        for (index, &tag) in tags.iter().enumerate() {
            let answer = bench.wait(tag);
            assert_eq!(answer.code, 0, "mode {mode}, entry {index}: {answer:?}");
        }
        assert_eq!(position(&bench.answers[&tags[tags.len() - 2]]), 60.0);
        let status = bench.done(ProgramStatus {});
        assert_eq!((status.late.get(), status.clock_ns.get()), (0, 3 * (20 * MS + 250_000)), "mode {mode}");
    }
}

#[test]
fn a_second_stream_counts_from_0() {
    let mut bench = Bench::gus();
    let (core, profile) = (CORE.into(), 1.into());
    let mut entries = vec![entry(AxisOn { core, axis: profile }), entry(PrfPt { core, profile, mode: 1.into() })];
    // The second stream's times would fit after the first one's.
    for (pos, time) in [(10.0, 10), (20.0, 40), (20.0, 100)] {
        entries.extend([
            entry(PtData { kind: 1.into(), ..pt_data(1, pos, time) }),
            entry(start(1)),
            entry(wait_stop(1)),
        ]);
    }
    entries.extend([entry(read_pos(1)), entry(ProgramEnd {})]);
    let tags = bench.post_all(&entries);
    bench.done(ProgramStart { strict: 1 });
    assert_eq!(bench.wait(*tags.last().unwrap()).code, 0);
    assert_eq!(position(&bench.answers[&tags[tags.len() - 2]]), 50.0);
    assert_eq!(bench.done(ProgramStatus {}).clock_ns.get(), (10 + 40 + 100) * MS + 3 * 250_000);
}

#[test]
fn an_entry_waits_while_its_instant_may_still_come() {
    let mut bench = Bench::gus();
    let (core, profile) = (CORE.into(), 1.into());
    // While axis 1 runs its mode cannot be set; after 50 ms it can, and the entry is for 60 ms.
    let mut entries = vec![
        entry(AxisOn { core, axis: profile }),
        entry(PrfPt { core, profile, mode: 0.into() }),
        entry(pt_data(1, 50.0, 50)),
        entry(start(1)),
        entry(sleep(60)),
        entry(PrfTrap { core, profile }),
        entry(ProgramEnd {}),
    ];
    let tags = bench.post_all(&entries);
    bench.done(ProgramStart { strict: 1 });
    assert_eq!(bench.wait(tags[6]).code, 0);
    assert_eq!(bench.done(ProgramStatus {}).late.get(), 0);
    // For 40 ms it is too early: refused, then.
    entries[4] = entry(sleep(40));
    let tags = bench.post_all(&entries);
    bench.done(ProgramStart { strict: 1 });
    assert_eq!(bench.wait(tags[5]).reason(), Reason::Moving);
    let clock = bench.done(ProgramStatus {}).clock_ns.get();
    assert!((40 * MS..42 * MS).contains(&clock), "{clock}");
    bench.done(ProgramClear {});
    // WaitStop makes it right, whatever the time.
    bench.run_ms(20);
    bench.done(PtClear { core, profile, fifo: 0.into() });
    entries[4] = entry(wait_stop(1));
    let tags = bench.post_all(&entries);
    bench.done(ProgramStart { strict: 1 });
    assert_eq!(bench.wait(tags[6]).code, 0);
}

/// Codes and positions of a program that gives the first segments of a stream, does `then`, and
/// gives the next one, which would also fit after the first. It starts that one if `starts` is set.
fn a_stream_and_another(then: &[(u16, Lane, Vec<u8>)]) {
    let mut bench = Bench::gus();
    let (core, profile) = (CORE.into(), 1.into());
    let mut entries = vec![
        entry(AxisOn { core, axis: profile }),
        entry(PrfPt { core, profile, mode: 1.into() }),
        entry(PtData { kind: 1.into(), ..pt_data(1, 10.0, 10) }),
        entry(start(1)),
    ];
    entries.extend_from_slice(then);
    let rest = entries.len();
    entries.extend([
        entry(PtSpace { core, profile, fifo: 0.into() }),
        entry(PtData { kind: 1.into(), ..pt_data(1, 25.0, 50) }),
        entry(PtSpace { core, profile, fifo: 0.into() }),
        entry(read_pos(1)),
        entry(start(1)),
        entry(wait_stop(1)),
        entry(read_pos(1)),
        entry(ProgramEnd {}),
    ]);
    let tags = bench.post_all(&entries);
    bench.done(ProgramStart { strict: 0 });
    for (index, &tag) in tags.iter().enumerate() {
        let answer = bench.wait(tag);
        assert_eq!(answer.code, 0, "entry {index}: {answer:?}");
    }
    let space = |index: usize| bench.answers[&tags[rest + index]].reply::<PtSpace>().value.get();
    assert_eq!((space(0), space(2)), (64, 63), "one segment, of a new stream");
    let [before, after] = [3, 6].map(|index| position(&bench.answers[&tags[rest + index]]));
    assert_eq!(after - before, 25.0, "it counts from 0 where the axis stands");
}

#[test]
fn data_after_a_stream_that_ran_dry_begins_another() {
    // 2 ms and 1 ms later, a tick later, and long after.
    for ns in [12 * MS, 11 * MS, 10 * MS + 250_000, 300 * MS] {
        a_stream_and_another(&[entry(Sleep { ns: ns.into() })]);
    }
}

#[test]
fn data_after_a_stop_of_a_stream_begins_another() {
    let stop = |option: i32| entry(Stop { core: CORE.into(), mask: 1.into(), option: option.into(), form: 0 });
    a_stream_and_another(&[entry(sleep(4)), stop(1)]);
    a_stream_and_another(&[entry(sleep(4)), stop(1), entry(sleep(1))]);
    a_stream_and_another(&[stop(1)]);
    a_stream_and_another(&[entry(sleep(4)), stop(0), entry(sleep(3))]);
}
