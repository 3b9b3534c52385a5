//! The program queue: timing, flow control, failures, Stop, link loss, the trace.
mod bench;
use bench::{Bench, MS, body, entry, pt_data, pt_item};
use protocol::command::*;
use protocol::reason::Reason;
use protocol::record::Lane;
use protocol::trace::{Decoder, Event};

const CORE: i16 = 1;

fn sleep(ms: u64) -> Sleep {
    Sleep { ns: (ms * MS).into() }
}

fn wait_stop(axes: i32) -> WaitStop {
    WaitStop { core: CORE.into(), axes: axes.into(), crds: 0.into() }
}

fn read_pos(axis: i16) -> GetPrfPos {
    GetPrfPos { core: CORE.into(), profile: axis.into(), count: 1.into() }
}

fn start(mask: i32) -> PtStart {
    PtStart { core: CORE.into(), mask: mask.into(), option: 0.into() }
}

fn position(answer: &bench::Answer) -> f64 {
    answer.items::<GetPrfPos>()[0].value.get()
}

/// Listing 2-1 of the GXN manual as a program: up, along, down; 4096 pulses in 3072 ms.
fn listing_2_1() -> Vec<(u16, Lane, Vec<u8>)> {
    let (core, axis) = (CORE.into(), 1.into());
    vec![
        entry(AxisOn { core, axis }),
        entry(ZeroPos { core, axis, count: 1.into() }),
        entry(PrfPt { core, profile: axis, mode: 0.into() }),
        entry(PtClear { core, profile: axis, fifo: 0.into() }),
        entry(PtSpace { core, profile: axis, fifo: 0.into() }),
        entry(pt_data(1, 1024.0, 1024)),
        entry(PtSpace { core, profile: axis, fifo: 0.into() }),
        entry(pt_data(1, 3072.0, 2048)),
        entry(pt_data(1, 4096.0, 3072)),
        entry(PtSpace { core, profile: axis, fifo: 0.into() }),
        entry(start(1)),
        entry(sleep(1536)),
        entry(GetPrfVel { core, profile: axis, count: 1.into() }),
        entry(wait_stop(1)),
        entry(read_pos(1)),
        entry(ProgramEnd {}),
    ]
}

#[test]
fn the_manuals_first_listing() {
    let mut bench = Bench::gus();
    let tags = bench.post_all(&listing_2_1());
    let started = bench.post(Lane::Immediate, ProgramStart { strict: 1 }, &[]);
    assert_eq!(bench.wait(started).reply::<ProgramStart>().state, 2);
    let end = bench.wait(*tags.last().unwrap());
    assert_eq!(end.code, 0);
    let spaces: Vec<_> = [4, 6, 9].map(|i| bench.wait(tags[i]).reply::<PtSpace>().value.get()).into();
    assert_eq!(spaces, [32, 31, 29]);
    let velocity = bench.wait(tags[12]).items::<GetPrfVel>()[0].value.get();
    assert!((velocity - 2.0).abs() < 1e-9, "{velocity}");
    assert_eq!(position(&bench.wait(tags[14])), 4096.0);
    // Every answer came, in order.
    let order: Vec<_> = bench.order.iter().filter(|tag| tags.contains(tag)).copied().collect();
    assert_eq!(order, tags);
    let status = bench.done(ProgramStatus {});
    assert_eq!((status.state, status.late.get(), status.accepted.get(), status.executed.get()), (0, 0, 16, 16));
    // The motion began with the first tick after 0, so it ended a tick after 3072 ms.
    assert_eq!(status.clock_ns.get(), 3072 * MS + 250_000);
}

/// Positions of axis 1 tick by tick while a program runs, the thread polling every so many ticks.
fn positions(poll_every: u32, in_one_message: bool) -> Vec<i64> {
    let mut bench = Bench::gus();
    let (core, profile) = (CORE.into(), 2.into());
    bench.poll_every = poll_every;
    let mut entries = listing_2_1();
    entries.pop();
    entries.extend([
        entry(AxisOn { core, axis: profile }),
        entry(PrfJog { core, profile }),
        entry(SetJogPrm { core, profile, acc: 0.01.into(), dec: 0.02.into(), smooth: 0.5.into() }),
        entry(SetVel { core, profile, vel: 3.0.into() }),
        entry(sleep(3)),
        entry(Update { core, mask: 2.into() }),
        entry(sleep(70)),
        entry(SetVel { core, profile, vel: (-1.0).into() }),
        entry(Update { core, mask: 2.into() }),
        entry(Stop { core, mask: 2.into(), option: 0.into(), form: 0 }),
        entry(Sleep { ns: 123_456_789.into() }),
        entry(SetVel { core, profile, vel: 0.5.into() }),
        entry(Update { core, mask: 2.into() }),
        entry(sleep(40)),
        entry(Stop { core, mask: 2.into(), option: 2.into(), form: 0 }),
        entry(ProgramEnd {}),
    ]);
    let mut last = 0;
    if in_one_message {
        last = *bench.post_all(&entries).last().unwrap();
    } else {
        for one in &entries {
            last = bench.post_all(std::slice::from_ref(one))[0];
        }
    }
    let started = bench.post(Lane::Immediate, ProgramStart { strict: 0 }, &[]);
    let mut seen = Vec::new();
    let mut zero = None;
    while !bench.answers.contains_key(&last) {
        bench.step();
        let view = bench.server.view();
        if view.program_runs && zero.is_none() {
            zero = Some(view.now.0 - view.script_zero.0);
        }
        if zero.is_some() {
            seen.push(bench.machine.set_points[0].0 + (bench.machine.set_points[1].0 << 20));
        }
    }
    assert_eq!(zero, Some(250_000), "the first view of the run is that of its first tick");
    assert_eq!(bench.wait(started).code, 0);
    let status = bench.done(ProgramStatus {});
    assert_eq!((status.state, status.late.get()), (0, 0));
    seen
}

#[test]
fn entries_act_on_the_same_tick_however_the_thread_polls() {
    let reference = positions(1, true);
    assert!(reference.len() > 12_000);
    assert_ne!(reference[0], *reference.last().unwrap());
    for (poll_every, in_one_message) in [(1, false), (3, true), (16, true), (100, false)] {
        let other = positions(poll_every, in_one_message);
        // The run is looked at until its last answer came, which polling delays.
        let common = reference.len().min(other.len());
        assert!(other.len() >= reference.len());
        assert_eq!(reference[..common], other[..common], "polling every {poll_every} ticks");
    }
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
    // The client keeps within the room it was told of.
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

/// Segments that 1 ms long pieces of `axes` streams are told before their start.
const AHEAD: i32 = 2000;

/// The data before the start of eight streams: records of `share` segments, from axis to axis.
fn prefill(share: i32) -> Vec<(u16, Lane, Vec<u8>)> {
    let mut entries = Vec::new();
    for axis in 1..=8 {
        entries.push(entry(AxisOn { core: CORE.into(), axis: axis.into() }));
        entries.push(entry(PrfPt { core: CORE.into(), profile: axis.into(), mode: 1.into() }));
        entries.push(entry(SetPtMemory { core: CORE.into(), profile: axis.into(), memory: 1.into() }));
    }
    for part in 0..AHEAD / share {
        for axis in 1..=8i16 {
            let items: Vec<PtItem> = (1..=share)
                .map(|i| part * share + i)
                .map(|t| pt_item(f64::from(t * i32::from(axis)), t, if t == AHEAD { 2 } else { 1 }))
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
    // The last has more records than there are places in the ring of entries.
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
        assert_eq!(reached, (1..=8).map(|axis| f64::from(AHEAD * axis)).collect::<Vec<_>>());
        let status = bench.done(ProgramStatus {});
        assert_eq!((status.late.get(), status.worst_late_us.get()), (0, 0), "{share} a record");
        assert_eq!(status.clock_ns.get(), AHEAD as u64 * MS + 250_000);
        for axis in 1..=8 {
            assert_eq!(bench.done(GetPtState { core, profile: axis.into() }).state, 2, "no underrun");
        }
    }
}

#[test]
fn data_behind_a_start_is_admitted_while_the_program_is_held() {
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
    assert_eq!(position(&bench.answers[&tags[tags.len() - 2]]), f64::from(AHEAD * 8));
    let status = bench.done(ProgramStatus {});
    assert_eq!((status.late.get(), status.clock_ns.get()), (0, (1500 + AHEAD as u64) * MS + 250_000));
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
fn what_does_not_fit_is_sent_again_and_nothing_overtakes() {
    let mut bench = Bench::gus();
    bench.servo_on(1);
    bench.done(PrfPt { core: CORE.into(), profile: 1.into(), mode: 0.into() });
    // Reads with sleeps between them: held, they fill the ring, then the queue.
    let pair = [entry(sleep(1)), entry(read_pos(1))];
    let mut tags = Vec::new();
    for _ in 0..40 {
        let message: Vec<_> = pair.iter().cloned().cycle().take(40).collect();
        tags.extend(bench.post_all(&message));
        bench.run_ms(1);
    }
    let refused: Vec<_> =
        tags.iter().filter(|&&tag| bench.answers.get(&tag).is_some_and(|a| a.code != 0)).copied().collect();
    let first = tags.iter().position(|tag| refused.contains(tag)).expect("the queue is finite");
    assert_eq!(&refused[..], &tags[first..], "all behind the first that did not fit");
    assert_eq!(bench.answers[&refused[0]].reason(), Reason::QueueFull);
    // The immediate lane is not behind it.
    assert_eq!(bench.pos(1), 0.0);
    assert_eq!(bench.refused(AxisOn { core: CORE.into(), axis: 2.into() }).1, Reason::ProgramRuns);
    assert_eq!(bench.call(ClrSts { core: CORE.into(), axis: 1.into(), count: 1.into() }).code, 0);
    // Until the client looks, even what would fit is refused.
    bench.done(ProgramStart { strict: 0 });
    bench.run_ms(100);
    let tag = bench.post(Lane::Program, ProgramEnd {}, &[]);
    assert_eq!(bench.wait(tag).reason(), Reason::QueueFull);
    assert_eq!(bench.done(ProgramStatus {}).state, 2);
    let tag = bench.post(Lane::Program, ProgramEnd {}, &[]);
    assert_eq!(bench.wait(tag).code, 0);
    assert!(tags[..first].iter().all(|tag| bench.answers[tag].code == 0));
    assert_eq!(bench.done(ProgramStatus {}).executed.get(), first as u32 + 1);
}

#[test]
fn the_first_failure_discards_the_rest_and_leaves_no_trace_of_it() {
    let mut bench = Bench::gus();
    let (core, profile) = (CORE.into(), 1.into());
    let tags = bench.post_all(&[
        entry(AxisOn { core, axis: profile }),
        entry(sleep(10)),
        entry(SetStopDec { core, profile, smooth: 2.0.into(), abrupt: 20.0.into() }),
        entry(PrfPt { core, profile, mode: 0.into() }),
        entry(start(1)),
        entry(SetStopDec { core, profile, smooth: 3.0.into(), abrupt: 30.0.into() }),
        entry(pt_data(1, 1.0, 1)),
        entry(ProgramEnd {}),
    ]);
    bench.done(ProgramStart { strict: 0 });
    let failure = bench.wait(tags[4]);
    assert_eq!((failure.code, failure.reason()), (1, Reason::FifoEmpty));
    // Not before its instant.
    let clock = bench.done(ProgramStatus {}).clock_ns.get();
    assert!((10 * MS..12 * MS).contains(&clock), "{clock}");
    for &tag in &tags[5..] {
        assert_eq!(bench.wait(tag).reason(), Reason::Discarded);
    }
    assert_eq!(bench.done(ProgramStatus {}).state, 3);
    let dec = bench.done(GetStopDec { core, profile });
    assert_eq!((dec.smooth.get(), dec.abrupt.get()), (2.0, 20.0));
    assert_eq!(bench.done(PtSpace { core, profile, fifo: 0.into() }).value.get(), 32);
    // Until it is cleared, later entries belong to the failed program.
    let tag = bench.post(Lane::Program, ProgramEnd {}, &[]);
    assert_eq!(bench.wait(tag).reason(), Reason::Discarded);
    assert_eq!(bench.refused(ProgramStart { strict: 0 }).1, Reason::ProgramOnlyHeld);
    assert_eq!(bench.done(ProgramClear {}).state, 0);
    // And then another one runs.
    let tags = bench.post_all(&[entry(sleep(1)), entry(read_pos(1)), entry(ProgramEnd {})]);
    bench.done(ProgramStart { strict: 1 });
    assert!(tags.iter().all(|&tag| bench.wait(tag).code == 0));
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

#[test]
fn data_behind_wait_stop_is_in_time() {
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
    // The second stream's times would fit behind the first one's.
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
fn what_was_admitted_ahead_and_dropped_leaves_no_trace() {
    let mut bench = Bench::gus();
    let (core, profile) = (CORE.into(), 1.into());
    let dec = |smooth: f64| entry(SetStopDec { core, profile, smooth: smooth.into(), abrupt: 9.0.into() });
    let tags = bench.post_all(&[
        entry(PrfPt { core, profile, mode: 0.into() }),
        entry(pt_data(1, 10.0, 10)),
        dec(2.0),
        entry(sleep(50)),
        dec(3.0),
        entry(pt_data(1, 20.0, 500)),
        entry(SetDoBit { core, do_type: 12.into(), index: 1.into(), value: 1.into() }),
        entry(ProgramEnd {}),
    ]);
    bench.done(ProgramStart { strict: 0 });
    bench.run_ms(10);
    bench.done(Stop { core, mask: 2.into(), option: 0.into(), form: 0 });
    assert!(tags[4..].iter().all(|&tag| bench.wait(tag).reason() == Reason::Discarded));
    bench.done(ProgramClear {});
    assert_eq!(bench.done(GetStopDec { core, profile }).smooth.get(), 2.0);
    assert_eq!(bench.done(PtSpace { core, profile, fifo: 0.into() }).value.get(), 31);
    // The chain goes on from what was executed.
    assert_eq!(bench.done(pt_data(1, 12.0, 12)).taken.get(), 1);
    bench.run_ms(100);
    assert_eq!(bench.machine.outputs.2, 0);
}

/// The same request, allowed to fail.
fn may_fail<R: Request>(request: R) -> (u16, Lane, Vec<u8>) {
    (R::OPCODE, Lane::ProgramMayFail, body::<R>(request, &[]))
}

/// Axis 1 jogs from 0 on; at 10 ms it is asked for a mode, which it cannot take while it moves. What stands
/// behind acts at 10 and 15 ms.
fn passed_over(with: bool) -> (Vec<bench::Answer>, Vec<(u64, u32)>, ProgramReply) {
    let (core, profile) = (CORE.into(), 1.into());
    let mut bench = Bench::gus();
    bench.servo_on(1);
    bench.done(PrfJog { core, profile });
    bench.done(SetJogPrm { core, profile, acc: 1.0.into(), dec: 1.0.into(), smooth: 0.0.into() });
    bench.done(SetVel { core, profile, vel: 5.0.into() });
    let output = |index: i16| SetDoBit { core, do_type: 12.into(), index: index.into(), value: 1.into() };
    let mut requests = vec![entry(Update { core, mask: 1.into() }), entry(sleep(10))];
    if with {
        requests.push(may_fail(PrfPt { core, profile, mode: 0.into() }));
        requests.push(may_fail(AxisOn { core, axis: 99.into() }));
        requests.push(may_fail(pt_data(1, 1.0, 1)));
    }
    requests.extend([entry(output(1)), entry(sleep(2))]);
    if with {
        requests.push(may_fail(start(1)));
    }
    requests.extend([entry(sleep(3)), entry(output(2)), entry(ProgramEnd {})]);
    let tags = bench.post_all(&requests);
    let started = bench.post(Lane::Immediate, ProgramStart { strict: 1 }, &[]);
    bench.wait(started);
    let (zero, mut edges, mut before) = (bench.server.view().script_zero.0, Vec::new(), bench.machine.outputs.2);
    while !bench.answers.contains_key(tags.last().unwrap()) {
        bench.step();
        if bench.machine.outputs.2 != before {
            before = bench.machine.outputs.2;
            edges.push((bench.now().0 - zero, before));
        }
    }
    let answers = tags.iter().map(|tag| bench.answers[tag].clone()).collect();
    (answers, edges, bench.done(ProgramStatus {}))
}

#[test]
fn a_program_goes_on_behind_an_entry_that_may_fail() {
    let (answers, edges, status) = passed_over(true);
    let reasons: Vec<_> =
        answers.iter().filter(|answer| answer.code != 0).map(|answer| (answer.code, answer.reason())).collect();
    assert_eq!(reasons, [(1, Reason::Moving), (7, Reason::Selector), (1, Reason::WrongMode), (1, Reason::WrongMode)]);
    // What follows acts as if those had not been there: not late, at the same instants.
    let (all_done, without, plain) = passed_over(false);
    assert!(all_done.iter().all(|answer| answer.code == 0));
    assert_eq!(edges, without);
    assert_eq!(edges.iter().map(|edge| edge.0).collect::<Vec<_>>(), [10 * MS + 250_000, 15 * MS + 250_000]);
    assert_eq!((status.state, status.late.get(), status.clock_ns.get()), (0, 0, plain.clock_ns.get()));
    assert_eq!((status.accepted.get(), status.executed.get()), (11, 7));
}

#[test]
fn a_start_that_the_tick_refuses_is_passed_over_where_it_may_fail() {
    let (core, axis) = (CORE.into(), 1.into());
    let mut bench = Bench::gus();
    bench.servo_on(1);
    bench.done(PrfPt { core, profile: axis, mode: 0.into() });
    bench.done(AlarmOn { core, axis });
    let tags = bench.post_all(&[
        entry(pt_data(1, 100.0, 100)),
        entry(sleep(10)),
        may_fail(start(1)),
        entry(sleep(5)),
        entry(read_pos(1)),
        entry(ProgramEnd {}),
    ]);
    let started = bench.post(Lane::Immediate, ProgramStart { strict: 0 }, &[]);
    bench.wait(started);
    // The start is in the ring when the alarm comes.
    bench.run_ms(5);
    bench.machine.inputs[0].alarm = !bench.machine.inputs[0].alarm;
    let end = bench.wait(*tags.last().unwrap());
    assert_eq!(end.code, 0);
    let refused = bench.wait(tags[2]);
    assert!(refused.code == 1 && matches!(refused.reason(), Reason::AxisFault | Reason::ServoOff), "{refused:?}");
    assert_eq!(position(&bench.wait(tags[4])), 0.0);
    let status = bench.done(ProgramStatus {});
    assert_eq!((status.state, status.late.get()), (0, 0));
}

/// Bytes of a trace in the records of the link.
#[test]
fn a_trace_over_the_link_is_that_of_its_own_stream() {
    let rows = |way: u8| {
        let (core, axis) = (CORE.into(), 1.into());
        let mut bench = Bench::gus();
        bench.done(Trace { every: 1.into(), axes: 0b11.into(), lasers: 0, crds: 0, way });
        let tags = bench.post_all(&[
            entry(AxisOn { core, axis }),
            entry(PrfPt { core, profile: axis, mode: 0.into() }),
            entry(pt_data(1, 100.0, 100)),
            entry(start(1)),
            entry(sleep(300)),
            entry(ProgramEnd {}),
        ]);
        let started = bench.post(Lane::Immediate, ProgramStart { strict: 1 }, &[]);
        bench.wait(started);
        bench.wait(*tags.last().unwrap());
        bench.done(Trace { every: 0.into(), axes: 0.into(), lasers: 0, crds: 0, way: 0 });
        bench.run_ms(50);
        let (own, carried) = (std::mem::take(&mut bench.trace), std::mem::take(&mut bench.link_trace));
        let (bytes, nothing) = if way == 0 { (own, carried) } else { (carried, own) };
        assert!(nothing.is_empty(), "only one way");
        let (mut decoder, mut rows, mut ended) = (Decoder::new(), Vec::new(), false);
        decoder.feed(&bytes, |event| match event.unwrap() {
            Event::Head(..) => {}
            Event::Row(row, samples) => {
                rows.push((row, samples.iter().map(|s| (s.pos.get(), s.vel_mantissa.get())).collect::<Vec<_>>()))
            }
            Event::End { lost, .. } => ended = lost == 0,
        });
        assert!(ended);
        rows
    };
    let over_link = rows(1);
    // 300 ms and the ticks until the trace was told to end.
    assert!(over_link.len() >= 1201, "{}", over_link.len());
    assert_eq!(over_link.last().map(|row| row.1[0].0 >> 22), Some(100));
    let own = rows(0);
    assert_eq!(over_link[..1201], own[..1201]);
}

#[test]
fn stop_ends_a_running_program() {
    let mut bench = Bench::gus();
    let mut entries = listing_2_1();
    entries.extend([entry(sleep(1)), entry(start(1)), entry(ProgramEnd {})]);
    let tags = bench.post_all(&entries);
    bench.done(ProgramStart { strict: 0 });
    bench.run_ms(500);
    let before = bench.pos(1);
    assert!(before > 100.0);
    bench.done(Stop { core: CORE.into(), mask: 1.into(), option: 1.into(), form: 1 });
    let stopped = bench.pos(1);
    assert!(stopped - before < 2.0 && bench.status_word(1) & 1 << 10 == 0);
    let codes: Vec<_> = tags.iter().map(|&tag| bench.wait(tag)).collect();
    assert!(codes[..12].iter().all(|answer| answer.code == 0));
    assert!(codes[12..].iter().all(|answer| answer.code == 1 && answer.reason() == Reason::Discarded));
    assert_eq!(bench.done(ProgramStatus {}).state, 4);
    bench.done(ProgramClear {});
    bench.run_ms(50);
    assert_eq!(bench.pos(1), stopped);
}

#[test]
fn a_start_that_the_tick_refuses_fails_the_program() {
    let mut bench = Bench::gus();
    let (core, profile) = (CORE.into(), 1.into());
    let tags = bench.post_all(&[
        entry(AxisOn { core, axis: profile }),
        entry(AlarmOn { core, axis: profile }),
        entry(PrfPt { core, profile, mode: 0.into() }),
        entry(pt_data(1, 50.0, 50)),
        entry(sleep(20)),
        entry(start(1)),
        entry(sleep(20)),
        entry(SetPrfPos { core, profile: 2.into(), pos: 77.into() }),
        entry(ProgramEnd {}),
    ]);
    bench.done(ProgramStart { strict: 0 });
    bench.run_ms(10);
    // The start is in the ring already when the drive fails.
    bench.machine.inputs[0].alarm = true;
    let failure = bench.wait(tags[5]);
    assert_eq!((failure.code, failure.reason(), failure.refusal().axis.get()), (1, Reason::AxisFault, 1));
    assert_eq!(bench.wait(tags[7]).reason(), Reason::Discarded);
    bench.run_ms(50);
    assert_eq!((bench.pos(1), bench.pos(2)), (0.0, 0.0));
    assert_eq!(bench.done(ProgramStatus {}).state, 3);
}

#[test]
fn a_strict_program_stops_at_a_late_entry() {
    for strict in [0, 1] {
        let mut bench = Bench::gus();
        let (core, profile) = (CORE.into(), 1.into());
        bench.post_all(&[entry(AxisOn { core, axis: profile })]);
        bench.done(ProgramStart { strict });
        bench.run_ms(20);
        // For the instant 0, which is long over.
        let tags = bench.post_all(&[
            entry(SetPrfPos { core, profile, pos: 5.into() }),
            entry(sleep(30)),
            entry(SetPrfPos { core, profile, pos: 7.into() }),
            entry(ProgramEnd {}),
        ]);
        let answers: Vec<_> = tags.iter().map(|&tag| bench.wait(tag)).collect();
        assert_eq!(answers[0].code, 0);
        let status = bench.done(ProgramStatus {});
        assert!(status.late.get() >= 1 && status.worst_late_us.get() >= 19_000);
        if strict == 1 {
            assert_eq!(answers[2].reason(), Reason::Late);
            assert_eq!(answers[3].reason(), Reason::Discarded);
            assert_eq!((status.state, bench.pos(1)), (3, 5.0));
        } else {
            // Later entries do not shift.
            assert_eq!((answers[3].code, status.state, bench.pos(1)), (0, 0, 7.0));
            assert_eq!(status.clock_ns.get(), 30 * MS);
        }
    }
}

#[test]
fn commands_in_the_wrong_lane() {
    let mut bench = Bench::gus();
    assert_eq!(bench.refused(sleep(1)).1, Reason::NotInProgram);
    assert_eq!(bench.refused(wait_stop(1)).1, Reason::NotInProgram);
    assert_eq!(bench.refused(ProgramEnd {}).1, Reason::NotInProgram);
    for wrong in
        [entry(SetTick { tick_us: 100.into() }), entry(ProgramClear {}), entry(Choose { profile: 0, family: 0 })]
    {
        let tag = bench.post_all(&[wrong])[0];
        bench.done(ProgramStart { strict: 0 });
        assert_eq!(bench.wait(tag).reason(), Reason::NotForProgram);
        bench.done(ProgramClear {});
    }
    let tag = bench.post_all(&[entry(WaitStop { core: 1.into(), axes: 0.into(), crds: 4.into() })])[0];
    bench.done(ProgramStart { strict: 0 });
    assert_eq!(bench.wait(tag).refusal().field, 2);
}

/// A Jog on axis 1 and a long PT on axis 2, and a program that still has to do something.
fn moving_bench() -> Bench<8> {
    let mut bench = Bench::gus();
    let (core, profile) = (CORE.into(), 1.into());
    bench.post_all(&[
        entry(AxisOn { core, axis: profile }),
        entry(AxisOn { core, axis: 2.into() }),
        entry(PrfJog { core, profile }),
        entry(SetJogPrm { core, profile, acc: 1.0.into(), dec: 1.0.into(), smooth: 0.0.into() }),
        entry(SetVel { core, profile, vel: 1.0.into() }),
        entry(PrfPt { core, profile: 2.into(), mode: 0.into() }),
        entry(PtData { kind: 1.into(), ..pt_data(2, 3000.0, 3000) }),
        entry(Update { core, mask: 1.into() }),
        entry(start(2)),
        entry(sleep(2000)),
        entry(SetPrfPos { core, profile: 3.into(), pos: 9.into() }),
        entry(ProgramEnd {}),
    ]);
    bench.done(ProgramStart { strict: 0 });
    bench.run_ms(100);
    bench
}

fn runs(bench: &mut Bench<8>) -> [bool; 2] {
    [0, 1].map(|axis| bench.server.view().axes[axis].status & 1 << 10 != 0)
}

#[test]
fn link_loss_stops_jog_and_drops_the_program() {
    let mut bench = moving_bench();
    // The client keeps the link alive by itself.
    bench.run_ms(1000);
    assert_eq!(runs(&mut bench), [true, true]);
    bench.cut = true;
    bench.run_ms(380);
    assert_eq!(runs(&mut bench), [true, true], "not before 500 ms of silence");
    bench.run_ms(140);
    assert_eq!(runs(&mut bench), [false, true], "PT runs on");
    bench.run_ms(2000);
    assert_eq!(bench.server.view().axes[2].pos.0, 0, "the rest of the program was dropped");
    bench.cut = false;
    assert_eq!(bench.done(ProgramStatus {}).state, 4);
}

#[test]
fn link_loss_can_be_off_or_stop_everything() {
    let mut bench = moving_bench();
    bench.done(SetLinkLoss { time_ms: 0.into(), stop_all: 0.into() });
    bench.cut = true;
    bench.run_ms(1500);
    assert_eq!(runs(&mut bench), [true, true]);
    bench.cut = false;
    bench.done(SetLinkLoss { time_ms: 200.into(), stop_all: 1.into() });
    bench.cut = true;
    bench.run_ms(320);
    assert_eq!(runs(&mut bench), [false, false]);
}

#[test]
fn a_new_session_finds_no_old_program() {
    let mut bench = moving_bench();
    bench.open(77);
    bench.run_ms(2500);
    assert_eq!(bench.server.view().axes[2].pos.0, 0);
    assert_eq!(bench.done(ProgramStatus {}).state, 0);
    assert!(runs(&mut bench)[0], "motion goes on");
}

#[test]
fn the_trace_has_every_row_and_the_planned_motion() {
    let mut bench = Bench::gus();
    bench.done(Trace { every: 2.into(), axes: 0b101.into(), lasers: 0, crds: 0, way: 0 });
    bench.post_all(&listing_2_1());
    bench.done(ProgramStart { strict: 1 });
    bench.run_ms(3200);
    bench.done(Trace { every: 0.into(), axes: 0.into(), lasers: 0, crds: 0, way: 0 });
    bench.run_ms(1);
    let mut rows: Vec<(u32, i64, f64)> = Vec::new();
    let mut end = None;
    let mut head = None;
    Decoder::new().feed(&bench.trace, |event| match event.expect("no row is missing") {
        Event::Head(described, axes) => {
            head = Some((described.period_ns, described.every));
            assert_eq!(axes.iter().map(|id| (id.core, id.axis)).collect::<Vec<_>>(), [(0, 1), (0, 3)]);
        }
        Event::Row(row, samples) => {
            let sample = samples.iter().next().unwrap();
            let velocity = sample.vel_mantissa.get() as f64 * (-f64::from(sample.vel_exponent.get())).exp2();
            rows.push((row, sample.pos.get(), velocity));
            assert_eq!(samples.iter().nth(1).unwrap().pos.get(), 0);
        }
        Event::End { rows, lost } => end = Some((rows, lost)),
    });
    assert_eq!(head, Some((250_000, 2)));
    assert_eq!(end, Some((rows.len() as u32, 0)));
    assert!(rows.len() > 6300);
    for &(row, pos, velocity) in &rows {
        // Row k is t = k·500 µs; the motion began at t = 250 µs.
        let t = (f64::from(row) * 0.5 - 0.25).clamp(0.0, 3072.0);
        let (p, v) = if t < 1024.0 {
            (t * t / 1024.0, t / 512.0)
        } else if t < 2048.0 {
            (1024.0 + 2.0 * (t - 1024.0), 2.0)
        } else {
            let left = 3072.0 - t;
            (4096.0 - left * left / 1024.0, left / 512.0)
        };
        assert!((pos as f64 / 4194304.0 - p).abs() <= 1.0 / 65536.0, "row {row}: {pos} {p}");
        assert!((velocity - v).abs() < 1e-9 || row == 0, "row {row}: {velocity} {v}");
    }
}
