//! Calls of one instant act on one tick, whatever has to be known of the instant before they are admitted.
mod bench;
use bench::{Bench, body, entry, position, pt_data, read_pos, sleep, start, wait_stop};
use protocol::command::*;
use protocol::record::Lane;

const CORE: i16 = 1;
type Entry = (u16, Lane, Vec<u8>);

/// A Jog of axis 1 with 10 pulse/ms, once it is updated, and a slave of it, axis 2, with an even segment in FIFO 0.
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
    let (core, profile) = (CORE.into(), 2.into());
    let (master_segment, slave_segment) = (1000.into(), 1000.0.into());
    entry(FollowData { core, profile, master_segment, slave_segment, kind: 1.into(), fifo: fifo.into() })
}

fn update() -> Entry {
    entry(Update { core: CORE.into(), mask: 1.into() })
}

fn follow() -> Entry {
    entry(FollowStart { core: CORE.into(), mask: 2.into(), option: 0.into() })
}

fn stop(mask: i32, option: i32) -> Entry {
    entry(Stop { core: CORE.into(), mask: mask.into(), option: option.into(), form: 0 })
}

/// Runs a program in which nothing is refused; how many of its entries were late, and its last answer but one.
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
        entries.extend([update(), entry(sleep(20)), follow(), stop(2, option), entry(sleep(20))]);
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

/// Start, then the other FIFO's data anew, a switch to it, and the master's start.
fn start_and_more() -> Vec<Entry> {
    let (core, profile) = (CORE.into(), 2.into());
    vec![
        follow(),
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

#[test]
fn what_follows_a_wait_stop_at_its_end_is_in_time() {
    let mut entries = set_up();
    entries.extend([data(1), follow(), update(), entry(sleep(11)), stop(1, 0), stop(2, 2)]);
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
    // Its time goes back.
    let refused = entries.len();
    entries.push((PtData::OPCODE, Lane::ProgramMayFail, body(pt_data(1, 5.0, 20), &[])));
    entries.extend([entry(pt_data(1, 5.0, 30)), entry(wait_stop(1)), entry(ProgramEnd {})]);
    let tags = bench.post_all(&entries);
    bench.done(ProgramStart { strict: 0 });
    let codes: Vec<i16> = tags.iter().map(|&tag| bench.wait(tag).code).collect();
    assert!(codes.iter().enumerate().all(|(index, code)| *code == if index == refused { 7 } else { 0 }), "{codes:?}");
    assert_eq!(bench.done(ProgramStatus {}).late.get(), 0);
}
