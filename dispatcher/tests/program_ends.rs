//! How a program ends: failures, entries that may fail, Stop, strictness, link loss, a new session.
use crate::bench;
use bench::{Bench, MS, body, entry, follow, listing_2_1, position, pt_data, read_pos, sleep, start};
use protocol::command::*;
use protocol::reason::Reason;
use protocol::record::Lane;

const CORE: i16 = 1;

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
    // The chain continues from what was executed.
    assert_eq!(bench.done(pt_data(1, 12.0, 12)).taken.get(), 1);
    bench.run_ms(100);
    assert_eq!(bench.machine.outputs.2, 0);
}

/// The same request, allowed to fail. Its slots were written when the entry was admitted; its FIFO
/// would have been cleared when it was executed.
#[test]
fn data_that_was_overwritten_and_dropped_is_gone() {
    let mut bench = Bench::gus();
    let (core, profile, fifo) = (1.into(), 1.into(), 0.into());
    bench.servo_on(1);
    bench.done(PrfPt { core, profile, mode: 0.into() });
    bench.done(pt_data(1, 100.0, 100));
    bench.done(pt_data(1, 200.0, 200));
    bench.done(PtData { fifo: 1.into(), ..pt_data(1, 50.0, 100) });
    let dropped = bench.post_all(&[entry(PtClear { core, profile, fifo }), entry(pt_data(1, 7777.0, 100))]);
    bench.run_ms(2);
    bench.done(ProgramClear {});
    assert!(dropped.iter().all(|tag| bench.answers[tag].reason() == Reason::Discarded));
    assert_eq!(bench.done(PtSpace { core, profile, fifo }).value.get(), 32);
    assert_eq!(bench.refused(start(1)).1, Reason::FifoEmpty);
    // The other FIFO was not touched.
    bench.done(PtStart { option: 1.into(), ..start(1) });
    bench.run_ms(110);
    assert_eq!(bench.pos(1), 50.0);
    // And new data begins from nothing.
    bench.done(pt_data(1, 10.0, 20));
    bench.done(start(1));
    bench.run_ms(200);
    assert_eq!(bench.pos(1), 60.0);
}

fn may_fail<R: Request>(request: R) -> (u16, Lane, Vec<u8>) {
    (R::OPCODE, Lane::ProgramMayFail, body::<R>(request, &[]))
}

/// Axis 1 jogs from 0 on. At 10 ms it gets a mode command, which it cannot take while it moves. The
/// entries after it act at 10 and 15 ms.
fn passed_over(with: bool) -> (Vec<bench::Answer>, Vec<(u64, u64)>, ProgramReply) {
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
fn a_program_goes_on_after_an_entry_that_may_fail() {
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

/// A Jog on axis 1 and a long PT on axis 2, and a program with entries left.
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
    let lost = bench.answers.values().filter(|answer| answer.code == 1 && answer.reason() == Reason::LinkLost);
    assert_eq!(lost.count(), 2, "what waited for the end of the Sleep");
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

/// Axis 1 jogs; at 10 ms an output is set, `refused` is sent, and another output is set. Returns
/// when they are set, after 10 ms, and the reason of the refusal.
fn beside_a_refusal<R: Request>(refused: R) -> (Vec<u64>, Reason, ProgramReply) {
    let (core, profile) = (CORE.into(), 1.into());
    let mut bench = Bench::gus();
    bench.servo_on(1);
    bench.done(PrfJog { core, profile });
    bench.done(SetJogPrm { core, profile, acc: 1.0.into(), dec: 1.0.into(), smooth: 0.0.into() });
    bench.done(SetVel { core, profile, vel: 5.0.into() });
    bench.done(PrfFollow { core, profile: 2.into(), dir: 1.into() });
    let output = |index: i16| SetDoBit { core, do_type: 12.into(), index: index.into(), value: 1.into() };
    let requests = [
        entry(Update { core, mask: 1.into() }),
        entry(sleep(10)),
        entry(output(1)),
        // It ends no motion.
        entry(ClrSts { core, axis: 2.into(), count: 1.into() }),
        may_fail(refused),
        entry(output(2)),
        entry(ProgramEnd {}),
    ];
    let tags = bench.post_all(&requests);
    let started = bench.post(Lane::Immediate, ProgramStart { strict: 0 }, &[]);
    bench.wait(started);
    let (zero, mut edges, mut before) = (bench.server.view().script_zero.0, Vec::new(), bench.machine.outputs.2);
    while !bench.answers.contains_key(tags.last().unwrap()) {
        bench.step();
        let new = bench.machine.outputs.2 & !before;
        before = bench.machine.outputs.2;
        edges.extend((0..new.count_ones()).map(|_| bench.now().0 - zero - 10 * MS));
    }
    let answer = bench.answers[&tags[4]].clone();
    assert_ne!(answer.code, 0);
    (edges, answer.reason(), bench.done(ProgramStatus {}))
}

#[test]
fn what_follows_a_refused_entry_acts_in_the_tick_of_what_stands_before_it() {
    let (core, profile) = (CORE.into(), 1.into());
    let all = [
        beside_a_refusal(PrfPt { core, profile, mode: 0.into() }),
        beside_a_refusal(ZeroPos { core, axis: profile, count: 1.into() }),
        beside_a_refusal(PrfPvt { core, profile }),
        beside_a_refusal(SetFollowMaster {
            core,
            profile,
            master_index: 1.into(),
            master_type: 2.into(),
            master_item: 0.into(),
        }),
        beside_a_refusal(FollowStart { core, mask: 2.into(), option: 0.into() }),
        beside_a_refusal(FollowSwitch { core, mask: 2.into() }),
        beside_a_refusal(PrfFollow { core, profile: 2.into(), dir: 0.into() }),
        beside_a_refusal(PtStart { core, mask: 2.into(), option: 0.into() }),
    ];
    let reasons: Vec<Reason> = all.iter().map(|(_, reason, _)| *reason).collect();
    let at_rest = [Reason::NoMaster, Reason::NotRunning, Reason::DirectionDiffers, Reason::WrongMode];
    assert_eq!(reasons[..4], [Reason::Moving, Reason::Moving, Reason::Moving, Reason::WrongMode]);
    assert_eq!(reasons[4..], at_rest);
    for (edges, reason, status) in all {
        assert_eq!(edges, [250_000; 2], "{reason:?}");
        assert_eq!(status.late.get(), 0, "{reason:?}");
    }
}

#[test]
fn a_command_after_an_abrupt_stop_of_its_instant_is_decided_after_it() {
    let (core, profile) = (CORE.into(), 1.into());
    let mut bench = Bench::gus();
    bench.servo_on(1);
    bench.done(PrfJog { core, profile });
    bench.done(SetJogPrm { core, profile, acc: 1.0.into(), dec: 1.0.into(), smooth: 0.0.into() });
    bench.done(SetVel { core, profile, vel: 5.0.into() });
    let stop = Stop { core, mask: 1.into(), option: 1.into(), form: 0 };
    let requests = [
        entry(Update { core, mask: 1.into() }),
        entry(sleep(10)),
        entry(stop),
        may_fail(PrfPt { core, profile, mode: 0.into() }),
        entry(ProgramEnd {}),
    ];
    let tags = bench.post_all(&requests);
    let started = bench.post(Lane::Immediate, ProgramStart { strict: 0 }, &[]);
    bench.wait(started);
    assert_eq!(bench.wait(*tags.last().unwrap()).code, 0);
    assert_eq!(bench.answers[&tags[3]].code, 0, "the axis rests by then");
}

#[test]
fn the_status_names_the_first_late_record_and_the_one_after_which_a_tick_took_too_long() {
    let core = CORE.into();
    let mut bench = Bench::gus();
    let output = |index: i16| SetDoBit { core, do_type: 12.into(), index: index.into(), value: 1.into() };
    let tags = bench.post_all(&[entry(output(1)), entry(sleep(5)), entry(output(2))]);
    let started = bench.post(Lane::Immediate, ProgramStart { strict: 0 }, &[]);
    bench.wait(started);
    bench.run_ms(5);
    let status = bench.done(ProgramStatus {});
    assert_eq!((status.overruns.get(), status.reported), (0, 0));
    while bench.machine.outputs.2 != 3 {
        bench.step();
    }
    bench.overrun();
    bench.run_ms(20);
    // Its instant is long past.
    let late = bench.post_all(&[entry(sleep(1)), entry(output(3)), entry(output(4))]);
    bench.wait(late[2]);
    let status = bench.done(ProgramStatus {});
    assert_eq!((status.overruns.get(), status.late.get()), (1, 2));
    assert_eq!((status.overran_tag.get(), status.late_tag.get()), (tags[2], late[1]));
    // Both lasers went dark for it.
    assert_eq!(status.reported, 1 | 2 | 3 << 4);
    // The next program has counts of its own.
    bench.done(ProgramClear {});
    let tag = bench.post(Lane::Program, ProgramEnd {}, &[]);
    let started = bench.post(Lane::Immediate, ProgramStart { strict: 0 }, &[]);
    bench.wait(started);
    bench.wait(tag);
    let status = bench.done(ProgramStatus {});
    assert_eq!((status.overruns.get(), status.late.get(), status.reported), (0, 0, 0));
}

/// Data that does not fit to the data before it, after a clear of the same instant: the clear is in
/// flight, but makes nothing right that came after it.
#[test]
fn data_that_is_refused_after_a_clear_of_its_instant_delays_nothing() {
    let (core, profile) = (CORE.into(), 1.into());
    for full in [false, true] {
        let mut bench = Bench::gus();
        bench.servo_on(1);
        bench.done(PrfPt { core, profile, mode: 0.into() });
        let mut requests = vec![entry(PtClear { core, profile, fifo: 0.into() })];
        let fits = if full { 32 } else { 1 };
        requests.extend((1..=fits).map(|ms| entry(pt_data(1, f64::from(ms), ms))));
        let refused = requests.len();
        requests.push(may_fail(pt_data(1, 100.0, if full { 100 } else { 1 })));
        requests.extend([entry(start(1)), entry(ProgramEnd {})]);
        let tags = bench.post_all(&requests);
        bench.done(ProgramStart { strict: 0 });
        bench.wait(*tags.last().unwrap());
        let reason = bench.answers[&tags[refused]].reason();
        assert_eq!(reason, if full { Reason::FifoFull } else { Reason::NotIncreasing });
        assert_eq!(bench.done(ProgramStatus {}).late.get(), 0, "{reason:?}");
    }
}

/// The same of data after a start of the instant: the motion takes none of the data before it away.
#[test]
fn data_that_is_refused_after_a_clear_and_a_start_of_its_instant_delays_nothing() {
    let (core, profile, fifo) = (CORE.into(), 1.into(), 0.into());
    let pt = |mode: i16, fits: i32, refused, reason| {
        let mut requests =
            vec![entry(PrfPt { core, profile, mode: mode.into() }), entry(PtClear { core, profile, fifo })];
        requests.extend((1..=fits).map(|ms| entry(pt_data(1, f64::from(ms), ms))));
        requests.push(entry(start(1)));
        (requests, may_fail(refused), reason)
    };
    let follow = |fits: i32, refused, reason| {
        let data = (1..=fits).map(|index| entry(follow::data(1, index, 2.0, 0, 0)));
        let mut requests = vec![entry(follow::prf(1, 0)), entry(follow::master(1, 2, 2, 0))];
        requests.push(entry(FollowClear { core, profile, fifo }));
        requests.extend(data);
        requests.push(entry(FollowStart { core, mask: 1.into(), option: 0.into() }));
        (requests, may_fail(refused), reason)
    };
    for (requests, refused, reason) in [
        pt(0, 1, pt_data(1, 9.0, 1), Reason::NotIncreasing),
        pt(0, 32, pt_data(1, 40.0, 40), Reason::FifoFull),
        pt(1, 1, pt_data(1, 9.0, 1), Reason::NotIncreasing),
    ]
    .into_iter()
    .chain([
        follow(1, follow::data(1, -9, 2.0, 0, 0), Reason::MixedSigns),
        follow(2, follow::data(1, 1, 2.0, 0, 0), Reason::MasterOrder),
        follow(16, follow::data(1, 40, 2.0, 0, 0), Reason::FifoFull),
    ]) {
        let mut bench = Bench::gus();
        bench.servo_on(1);
        let at = requests.len();
        let bit = SetDoBit { core, do_type: 12.into(), index: 1.into(), value: 1.into() };
        let tags = bench.post_all(&[&requests[..], &[refused, entry(bit), entry(ProgramEnd {})]].concat());
        bench.done(ProgramStart { strict: 0 });
        bench.wait(*tags.last().unwrap());
        assert_eq!(bench.answers[&tags[at]].reason(), reason);
        assert_eq!(bench.done(ProgramStatus {}).late.get(), 0, "{reason:?}");
    }
}
