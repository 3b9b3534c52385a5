//! Calls of one instant act on one tick, even if their admission needs the state at that instant.
use crate::bench;
use bench::follow;
use bench::{Bench, body, entry, position, pt_data, read_pos, sleep, start, wait_stop};
use protocol::command::*;
use protocol::record::Lane;

const CORE: i16 = 1;
type Entry = (u16, Lane, Vec<u8>);

/// A Jog of axis 1 with 10 pulse/ms, once it is updated, and a slave of it, axis 2, with an even
/// segment in FIFO 0.
fn set_up() -> Vec<Entry> {
    let (core, master, slave) = (CORE.into(), 1.into(), 2.into());
    let prm = SetJogPrm { core, profile: master, acc: 10.0.into(), dec: 10.0.into(), smooth: 0.0.into() };
    let kinds =
        SetFollowMaster { core, profile: slave, master_index: 1.into(), master_type: 2.into(), master_item: 0.into() };
    vec![
        entry(AxisOn { core, axis: master }),
        entry(AxisOn { core, axis: slave }),
        entry(PrfJog { core, profile: master }),
        entry(prm),
        entry(SetVel { core, profile: master, vel: 10.0.into() }),
        entry(PrfFollow { core, profile: slave, dir: 0.into() }),
        entry(kinds),
        data(0),
    ]
}

/// An even segment of 1000 pulses with the ratio 1.
fn data(fifo: i16) -> Entry {
    data_to(1000, fifo)
}

/// The same, up to this position of the master.
fn data_to(end: i32, fifo: i16) -> Entry {
    let (core, profile) = (CORE.into(), 2.into());
    let (master_segment, slave_segment) = (end.into(), f64::from(end).into());
    entry(FollowData { core, profile, master_segment, slave_segment, kind: 1.into(), fifo: fifo.into() })
}

fn update() -> Entry {
    entry(Update { core: CORE.into(), mask: 1.into() })
}

fn follow_start() -> Entry {
    entry(FollowStart { core: CORE.into(), mask: 2.into(), option: 0.into() })
}

fn stop(mask: i32, option: i32) -> Entry {
    entry(Stop { core: CORE.into(), mask: mask.into(), option: option.into(), form: 0 })
}

/// Runs a program in which nothing is refused; returns how many of its entries were late, and its
/// last answer but one.
fn run(mut entries: Vec<Entry>) -> (u32, f64) {
    let mut bench = Bench::gus();
    entries.extend([entry(read_pos(2)), entry(ProgramEnd {})]);
    let tags = bench.post_all(&entries);
    bench.done(ProgramStart { strict: 0 });
    for (index, &tag) in tags.iter().enumerate() {
        assert_eq!(bench.wait(tag).code, 0, "entry {index}");
    }
    (bench.done(ProgramStatus {}).late.get(), position(&bench.answers[&tags[tags.len() - 2]]))
}

#[test]
fn a_stop_at_the_instant_of_a_start_moves_nothing() {
    for option in [0, 2] {
        let mut entries = set_up();
        entries.extend([update(), entry(sleep(20)), follow_start(), stop(2, option), entry(sleep(20))]);
        assert_eq!(run(entries), (0, 0.0), "a slave of a master at speed, option {option}");
        let (core, profile) = (CORE.into(), 2.into());
        let entries = vec![
            entry(AxisOn { core, axis: profile }),
            entry(PrfPt { core, profile, mode: 0.into() }),
            entry(PtData { kind: 1.into(), ..pt_data(2, 100.0, 10) }),
            entry(start(2)),
            stop(2, option),
            entry(sleep(20)),
        ];
        assert_eq!(run(entries), (0, 0.0), "PT that begins at speed, option {option}");
    }
}

/// Start, then new data in the other FIFO, a switch to it, and the master's start.
fn start_and_more() -> Vec<Entry> {
    let (core, profile) = (CORE.into(), 2.into());
    vec![
        follow_start(),
        entry(FollowClear { core, profile, fifo: 1.into() }),
        data(1),
        entry(FollowSwitch { core, mask: 2.into() }),
        update(),
    ]
}

#[test]
fn what_follows_a_follow_start_at_its_instant_is_in_time() {
    let mut entries = set_up();
    entries.push(data(1));
    entries.extend(start_and_more());
    entries.push(entry(sleep(11)));
    // 5 pulses in the first ms, then 10 a ms.
    assert_eq!(run(entries), (0, 105.0));
}

/// What empties a FIFO at rest, a start after it, and data after that: the start reads new data.
#[test]
fn data_after_a_start_of_what_was_cleared_is_in_time() {
    let (core, profile) = (CORE.into(), 2.into());
    let clear = || entry(FollowClear { core, profile, fifo: 0.into() });
    let mut entries = set_up();
    entries.extend([clear(), data(0), follow_start(), data_to(2000, 0), update(), entry(sleep(250))]);
    // Both segments: 2495 pulses of the master.
    assert_eq!(run(entries), (0, 2000.0));
    let mut entries = set_up();
    entries.extend([follow_start(), update(), entry(sleep(11)), stop(1, 0), stop(2, 2), entry(wait_stop(1))]);
    entries.extend([entry(wait_stop(2)), clear(), data(0), follow_start(), data_to(2000, 0), entry(sleep(5))]);
    assert_eq!(run(entries).0, 0, "after a motion");
}

#[test]
fn what_follows_a_wait_stop_at_its_end_is_in_time() {
    let mut entries = set_up();
    entries.extend([data(1), follow_start(), update(), entry(sleep(11)), stop(1, 0), stop(2, 2)]);
    entries.extend([entry(wait_stop(1)), entry(wait_stop(2))]);
    entries.extend(start_and_more());
    entries.push(entry(sleep(5)));
    let (late, _) = run(entries);
    assert_eq!(late, 0);
}

#[test]
fn refused_data_makes_nothing_late() {
    let mut bench = Bench::gus();
    let (core, profile) = (CORE.into(), 1.into());
    let mut entries = vec![
        entry(AxisOn { core, axis: profile }),
        entry(PrfPt { core, profile, mode: 1.into() }),
        entry(pt_data(1, 10.0, 20)),
        entry(start(1)),
        entry(sleep(10)),
    ];
    // Its end time is that of the segment before it.
    let refused = entries.len();
    entries.push((PtData::OPCODE, Lane::ProgramMayFail, body(pt_data(1, 5.0, 20), &[])));
    entries.extend([entry(pt_data(1, 5.0, 30)), entry(wait_stop(1)), entry(ProgramEnd {})]);
    let tags = bench.post_all(&entries);
    bench.done(ProgramStart { strict: 0 });
    let codes: Vec<i16> = tags.iter().map(|&tag| bench.wait(tag).code).collect();
    assert!(codes.iter().enumerate().all(|(index, code)| *code == if index == refused { 7 } else { 0 }), "{codes:?}");
    assert_eq!(bench.done(ProgramStatus {}).late.get(), 0);
}

/// Axis 2 follows axis 1, at 10 pulse/ms, in FollowEx mode; FIFO 0 ends with a queued switch to the
/// other one.
fn switching() -> Vec<Entry> {
    let (core, master, slave) = (CORE.into(), 1.into(), 2.into());
    let prm = SetJogPrm { core, profile: master, acc: 10.0.into(), dec: 10.0.into(), smooth: 0.0.into() };
    vec![
        entry(AxisOn { core, axis: master }),
        entry(AxisOn { core, axis: slave }),
        entry(PrfJog { core, profile: master }),
        entry(prm),
        entry(SetVel { core, profile: master, vel: 10.0.into() }),
        entry(follow::prf_ex(2, 0)),
        entry(SetFollowMasterEx {
            core,
            profile: slave,
            master_index: 1.into(),
            master_type: 2.into(),
            master_item: 0.into(),
        }),
        more(0, 1000.0),
        queued(2, 0),
        update(),
    ]
}

/// An even segment of FollowEx that ends there, with the ratio 1.
fn more(fifo: i16, end: f64) -> Entry {
    entry(follow::data_ex(2, end, end, 1, 0, fifo))
}

/// SwitchNow: 1 by segment, 2 by table, as a queue entry.
fn queued(method: i16, fifo: i16) -> Entry {
    let (core, profile) = (CORE.into(), 2.into());
    entry(FollowSwitchNowEx { core, profile, method: method.into(), buffer: 1.into(), fifo: fifo.into() })
}

#[test]
fn fifos_under_a_queued_switch_take_all_of_an_instant() {
    let (core, profile) = (CORE.into(), 2.into());
    let space = |fifo: i16| entry(FollowSpaceEx { core, profile, fifo: fifo.into() });
    let clear = |fifo: i16| entry(FollowClearEx { core, profile, fifo: fifo.into() });
    let start = || entry(FollowStartEx { core, mask: 2.into(), option: 0.into() });
    // The entries of an instant, the free slots then, and how many entries are late.
    let instants: [(Vec<Entry>, i16, u32); 6] = [
        (vec![more(1, 1000.0), more(1, 2000.0), space(1)], 14, 0),
        (vec![more(1, 1000.0), space(1), clear(1), space(1)], 16, 0),
        (vec![more(1, 500.0), queued(2, 1), more(1, 900.0), space(1)], 13, 0),
        // Data for slots that this instant clears has to wait until they are clear: the tick may
        // switch to them meanwhile.
        (vec![more(1, 1000.0), clear(1), more(1, 500.0), space(1)], 15, 1),
        (vec![more(1, 400.0), clear(1), more(1, 500.0), more(1, 600.0), space(1)], 14, 1),
        (vec![space(0), more(1, 500.0), space(0), clear(1), more(1, 400.0), space(1)], 15, 1),
    ];
    for (number, (instant, free, late)) in instants.iter().enumerate() {
        for (starts, pause) in [(true, None), (false, Some(20)), (true, Some(20))] {
            let mut entries = switching();
            // With the start, or later.
            if starts {
                entries.extend(pause.map(|ms| entry(sleep(ms))));
                entries.push(start());
            } else {
                entries.push(start());
                entries.extend(pause.map(|ms| entry(sleep(ms))));
            }
            let first = entries.len();
            entries.extend_from_slice(instant);
            let last = entries.len() - 1;
            for entry in &mut entries[first..] {
                entry.1 = Lane::ProgramMayFail;
            }
            entries.extend([entry(sleep(5)), entry(read_pos(2)), entry(ProgramEnd {})]);
            let mut bench = Bench::gus();
            let tags = bench.post_all(&entries);
            bench.done(ProgramStart { strict: 0 });
            let codes: Vec<i16> = tags.iter().map(|&tag| bench.wait(tag).code).collect();
            let reported = format!("instant {number}, starts {starts}, after {pause:?}");
            assert!(codes.iter().all(|code| *code == 0), "{reported}: {codes:?}");
            assert_eq!(bench.answers[&tags[last]].reply::<FollowSpaceEx>().value.get(), *free, "{reported}");
            assert_eq!(bench.done(ProgramStatus {}).late.get(), *late, "{reported}");
        }
    }
}

#[test]
fn the_first_instant_of_a_program_takes_what_concerns_fifos_under_a_queued_switch() {
    let (core, profile) = (CORE.into(), 2.into());
    let mut bench = Bench::gus();
    // The motion runs before the program does.
    for (opcode, _, body) in switching() {
        let tag = bench.post_raw(opcode, Lane::Immediate, &body);
        assert_eq!(bench.wait(tag).code, 0);
    }
    bench.done(FollowStartEx { core, mask: 2.into(), option: 0.into() });
    bench.run_ms(20);
    let mut entries = vec![
        more(1, 500.0),
        entry(FollowSpaceEx { core, profile, fifo: 1.into() }),
        entry(FollowClearEx { core, profile, fifo: 1.into() }),
    ];
    entries.iter_mut().for_each(|entry| entry.1 = Lane::ProgramMayFail);
    entries.push(entry(ProgramEnd {}));
    let tags = bench.post_all(&entries);
    bench.run_ms(2);
    bench.done(ProgramStart { strict: 0 });
    let codes: Vec<i16> = tags.iter().map(|&tag| bench.wait(tag).code).collect();
    assert_eq!(codes, [0; 4]);
    assert_eq!(bench.answers[&tags[1]].reply::<FollowSpaceEx>().value.get(), 15);
    assert_eq!(bench.done(ProgramStatus {}).late.get(), 0);
}
