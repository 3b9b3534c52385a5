//! PVT over the wire: tables in chunks, use and reuse of tables, loops and switches. Bad input is
//! refused with its code, reason and point, and changes nothing.
use crate::bench;
use bench::{Bench, body};
use protocol::command::*;
use protocol::reason::{Reason, Refusal};
use protocol::record::Lane;

fn table(number: i16, count: usize, first: usize) -> PvtTable {
    PvtTable { core: 1.into(), table: number.into(), count: (count as i32).into(), first: (first as u16).into() }
}

fn points(of: &[(f64, f64, f64)]) -> Vec<PvtPoint> {
    of.iter().map(|&(time, pos, vel)| PvtPoint { time: time.into(), pos: pos.into(), vel: vel.into() }).collect()
}

fn prepared(axes: i16) -> Bench<8> {
    let mut bench = Bench::gus();
    for axis in 1..=axes {
        bench.servo_on(axis);
        bench.done(PrfPvt { core: 1.into(), profile: axis.into() });
    }
    bench
}

fn load(bench: &mut Bench<8>, number: i16, of: &[(f64, f64, f64)]) -> (i16, Option<(Reason, Refusal)>) {
    let answer = bench.call_items(table(number, of.len(), 0), &points(of));
    (answer.code, (answer.code != 0).then(|| (answer.reason(), answer.refusal())))
}

fn start(mask: i32) -> PvtStart {
    PvtStart { core: 1.into(), mask: mask.into() }
}

fn select(axis: i16, table: i16) -> PvtTableSelect {
    PvtTableSelect { core: 1.into(), profile: axis.into(), table: table.into() }
}

fn passes(bench: &mut Bench<8>, axis: i16, count: i32) {
    bench.done(SetPvtLoop { core: 1.into(), profile: axis.into(), loop_count: count.into() });
}

fn status(bench: &mut Bench<8>, axis: i16) -> (i16, f64) {
    let found = bench.call(PvtStatus { core: 1.into(), profile: axis.into(), count: 1.into() }).items::<PvtStatus>()[0];
    (found.table.get(), found.time.get())
}

/// A chunk holds what a message holds, of every description.
#[test]
fn a_chunk_is_as_long_as_its_message() {
    let mut bench = prepared(1);
    let (core, number) = (1.into(), 1.into());
    let count = protocol::record::BODY_MAX - size_of::<PvtTableComplete>();
    let count = count / size_of::<PvtKnot>();
    assert!(count >= protocol::record::ITEM_BYTES / size_of::<PvtKnot>());
    let knots: Vec<PvtKnot> = (0..count).map(|i| PvtKnot { time: (i as f64).into(), pos: (i as f64).into() }).collect();
    let one = 1.0.into();
    let whole = PvtTableComplete {
        core,
        table: number,
        count: (count as i32).into(),
        first: 0.into(),
        vel_begin: one,
        vel_end: one,
    };
    assert_eq!(bench.call_items(whole, &knots).code, 0);
    bench.done(start(1));
    bench.run_ms(30);
    assert_eq!(bench.pos(1).round(), 30.0);
}

/// A table of ten pulses in ten ms.
const TEN: [(f64, f64, f64); 2] = [(0.0, 0.0, 1.0), (10.0, 10.0, 1.0)];

#[test]
fn a_table_of_many_chunks_runs_through_every_point() {
    let mut bench = prepared(1);
    // p = 3·i at t = i: constant velocity 3, so that every instant is known.
    let all: Vec<(f64, f64, f64)> = (0..1024).map(|i| (f64::from(i), 3.0 * f64::from(i) + 7.0, 3.0)).collect();
    for (number, part) in all.chunks(40).enumerate() {
        assert_eq!(bench.refused(start(1)).1, Reason::TableEmpty, "not before its last chunk");
        assert_eq!(bench.call_items(table(1, 1024, number * 40), &points(part)).code, 0);
    }
    bench.done(start(1));
    bench.run_ms(500);
    let (number, time) = status(&mut bench, 1);
    let pos = bench.pos(1);
    assert_eq!(number, 1);
    assert!((500.0..502.0).contains(&time), "{time}");
    assert!((pos - 3.0 * time).abs() <= 3.0, "{pos} at {time}");
    bench.run_ms(600);
    assert_eq!((bench.pos(1), status(&mut bench, 1)), (3069.0, (1, 1023.0)));
}

#[test]
fn chunks_out_of_order_begin_again_with_the_first() {
    let mut bench = prepared(1);
    let all: Vec<(f64, f64, f64)> = (0..6).map(|i| (f64::from(i), 0.0, 0.0)).collect();
    let refused = |bench: &mut Bench<8>, first: usize| {
        let answer = bench.call_items(table(2, 6, first), &points(&all[first..first + 2]));
        let refusal = answer.refusal();
        (answer.code, answer.reason(), refusal.field, refusal.high.get())
    };
    assert_eq!(refused(&mut bench, 2), (7, Reason::OutOfRange, 3, 0.0), "nothing was begun");
    assert_eq!(bench.call_items(table(2, 6, 0), &points(&all[..2])).code, 0);
    assert_eq!(refused(&mut bench, 4), (7, Reason::OutOfRange, 3, 2.0));
    assert_eq!(bench.call_items(table(2, 6, 2), &points(&all[2..4])).code, 0);
    // Another table drops the one that was begun.
    assert_eq!(load(&mut bench, 3, &TEN).0, 0);
    assert_eq!(refused(&mut bench, 4).0, 7);
    assert_eq!(bench.refused(select(1, 2)).1, Reason::TableEmpty);
    assert_eq!(bench.refused(start(1)).1, Reason::TableEmpty);
    // A chunk that reaches beyond the count.
    let answer = bench.call_items(table(2, 3, 0), &points(&all));
    assert_eq!((answer.code, answer.reason()), (7, Reason::TooMany));
    // Half a point, and none.
    let tag =
        bench.post_raw(opcode::PvtTable, Lane::Immediate, &[body(table(2, 6, 0), &points(&all)), vec![0; 8]].concat());
    assert_eq!(bench.wait(tag).reason(), Reason::Length);
    assert_eq!(bench.call_items(table(2, 6, 0), &[]).reason(), Reason::Length);
}

#[test]
fn bad_points_are_named_and_change_nothing() {
    let mut bench = prepared(1);
    assert_eq!(load(&mut bench, 1, &TEN).0, 0);
    /// Points, and the reason, field and item of the refusal.
    type Context = (&'static [(f64, f64, f64)], Reason, u8, u16);
    let cases: [Context; 7] = [
        (&[(0.0, 0.0, 0.0), (0.0, 1.0, 0.0)], Reason::PointTime, 4, 1),
        (&[(5.0, 0.0, 0.0), (4.0, 1.0, 0.0)], Reason::PointTime, 4, 1),
        (&[(0.0, 0.0, 0.0), (f64::NAN, 1.0, 0.0)], Reason::NotFinite, 4, 1),
        (&[(0.0, f64::INFINITY, 0.0), (1.0, 1.0, 0.0)], Reason::NotFinite, 5, 0),
        (&[(0.0, 0.0, 0.0), (1.0, 1.0, 5e9)], Reason::TooFast, 6, 1),
        (&[(-1.0, 0.0, 0.0), (1.0, 1.0, 0.0)], Reason::OutOfRange, 4, 0),
        (&[(0.0, 0.0, 0.0), (1e-4, 1e-4, 0.0)], Reason::TableShort, 4, 65535),
    ];
    for (of, reason, field, item) in cases {
        let (code, refused) = load(&mut bench, 1, of);
        let (found, refusal) = refused.unwrap();
        assert_eq!((code, found, refusal.field, refusal.item.get()), (7, reason, field, item), "{of:?}");
    }
    for (count, given) in [(1025, 40), (1, 1), (0, 0), (-5, 2), (i32::MAX, 2)] {
        let head = PvtTable { count: count.into(), ..table(1, 0, 0) };
        let answer = bench.call_items(head, &points(&vec![(0.0, 0.0, 0.0); given]));
        let refusal = answer.refusal();
        assert_eq!((answer.code, answer.reason(), refusal.field), (7, Reason::OutOfRange, 2), "{count}");
        assert_eq!((refusal.low.get(), refusal.high.get()), (2.0, 1024.0));
    }
    for number in [0, 33, -1, i16::MAX] {
        let (code, refused) = load(&mut bench, number, &TEN);
        let (reason, refusal) = refused.unwrap();
        assert_eq!((code, reason, refusal.field, refusal.high.get()), (7, Reason::Selector, 1, 32.0));
        let (code, reason, refusal) = bench.refused(select(1, number));
        assert_eq!((code, reason, refusal.field), (7, Reason::Selector, 2));
    }
    // The table is unchanged.
    bench.done(start(1));
    bench.run_ms(20);
    assert_eq!(bench.pos(1), 10.0);
}

#[test]
fn bad_percentages_and_limits() {
    let mut bench = prepared(1);
    let percent = |percent: f64| {
        [(0.0, 0.0), (1.0, 1.0)].map(|(time, pos)| PvtPercentPoint {
            time: f64::into(time),
            pos: f64::into(pos),
            percent: percent.into(),
        })
    };
    let head =
        PvtTablePercent { core: 1.into(), table: 1.into(), count: 2.into(), first: 0.into(), vel_begin: 0.0.into() };
    for bad in [101.0, -1.0, f64::NAN] {
        let answer = bench.call_items(head, &percent(bad));
        assert_eq!((answer.code, answer.refusal().field, answer.refusal().item.get()), (7, 7, 0), "{bad}");
    }
    assert_eq!(bench.call_items(head, &percent(100.0)).code, 0);
    let fast = PvtTablePercent { vel_begin: 5e9.into(), ..head };
    let answer = bench.call_items(fast, &percent(0.0));
    assert_eq!((answer.code, answer.reason(), answer.refusal().field), (7, Reason::TooFast, 4));

    let segment = |vel: f64, acc: f64, pos: f64| {
        [(0.0, 0.0), (pos, vel)].map(|(pos, vel)| PvtContinuousPoint {
            pos: f64::into(pos),
            vel: f64::into(vel),
            percent: 0.0.into(),
            vel_max: 10.0.into(),
            acc: acc.into(),
            dec: 0.01.into(),
        })
    };
    let head = PvtTableContinuous {
        core: 1.into(),
        table: 1.into(),
        count: 2.into(),
        first: 0.into(),
        time_begin: 0.0.into(),
    };
    for (points, reason, field) in [
        (segment(0.0, -0.01, 1000.0), Reason::OutOfRange, 9),
        (segment(0.0, 0.0, 1000.0), Reason::OutOfRange, 9),
        (segment(10.0, 0.01, 1000.0), Reason::VelocityUnreachable, 255),
        (segment(0.0, 0.01, 0.0), Reason::NoDisplacement, 255),
        (segment(11.0, 0.01, 1e6), Reason::AboveVelMax, 255),
    ] {
        let answer = bench.call_items(head, &points);
        assert_eq!((answer.code, answer.reason(), answer.refusal().item.get()), (7, reason, 0));
        assert_eq!(answer.refusal().field, field, "{reason:?}");
    }
    assert_eq!(bench.call_items(head, &segment(10.0, 0.01, 6000.0)).code, 0);
}

#[test]
fn a_table_in_use_is_not_replaced() {
    let mut bench = prepared(2);
    for number in 1..=3 {
        assert_eq!(load(&mut bench, number, &TEN).0, 0);
    }
    let in_use = |bench: &mut Bench<8>, number: i16| {
        let (code, refused) = load(bench, number, &TEN);
        refused.map(|(reason, refusal)| {
            assert_eq!((code, reason, refusal.got.get()), (1, Reason::TableInUse, f64::from(number)));
            refusal.axis.get()
        })
    };
    bench.done(select(2, 3));
    assert_eq!(in_use(&mut bench, 3), None, "selected at rest is not in use");
    passes(&mut bench, 2, 0);
    bench.done(start(2));
    assert_eq!((in_use(&mut bench, 3), in_use(&mut bench, 2)), (Some(2), None));
    bench.done(select(2, 2));
    assert_eq!((in_use(&mut bench, 3), in_use(&mut bench, 2)), (Some(2), Some(2)), "in force and pending");
    bench.run_ms(20);
    assert_eq!((in_use(&mut bench, 3), in_use(&mut bench, 2)), (None, Some(2)), "switched");
    let (code, reason, refusal) = bench.refused(select(2, 9));
    assert_eq!((code, reason, refusal.got.get()), (1, Reason::TableEmpty, 9.0), "no switch to nothing");
    bench.done(Stop { core: 1.into(), mask: 2.into(), option: 2.into(), form: 0 });
    bench.run_ms(1);
    assert_eq!(in_use(&mut bench, 2), None);
    // A refused chunk that was sent as an entry waits for its table, and then replaces it.
    bench.done(start(2));
    let half = points(&[(0.0, 0.0, 0.5), (10.0, 5.0, 0.5)]);
    let stop = Stop { core: 1.into(), mask: 2.into(), option: 2.into(), form: 0 };
    let requests = [
        (Sleep::OPCODE, Lane::Program, body(Sleep { ns: 4_000_000.into() }, &[])),
        (Stop::OPCODE, Lane::Program, body(stop, &[])),
        (Sleep::OPCODE, Lane::Program, body(Sleep { ns: 5_000_000.into() }, &[])),
        (PvtTable::OPCODE, Lane::Program, body(table(2, 2, 0), &half)),
        (ProgramEnd::OPCODE, Lane::Program, vec![]),
    ];
    let tags = bench.post_all(&requests);
    bench.done(ProgramStart { strict: 0 });
    for tag in tags {
        assert_eq!(bench.wait(tag).code, 0);
    }
    passes(&mut bench, 2, 1);
    let before = bench.pos(2);
    bench.done(start(2));
    bench.run_ms(20);
    assert_eq!(bench.pos(2) - before, 5.0);
}

#[test]
fn a_program_that_waits_in_vain_for_a_table_fails_there() {
    let mut bench = prepared(1);
    assert_eq!(load(&mut bench, 1, &TEN).0, 0);
    passes(&mut bench, 1, 0);
    bench.done(start(1));
    let requests = [
        (PvtTable::OPCODE, Lane::Program, body(table(1, 2, 0), &points(&TEN))),
        (ProgramEnd::OPCODE, Lane::Program, vec![]),
    ];
    let tags = bench.post_all(&requests);
    bench.done(ProgramStart { strict: 0 });
    let answer = bench.wait(tags[0]);
    assert_eq!((answer.code, answer.reason()), (1, Reason::TableInUse));
    assert_eq!(bench.wait(tags[1]).reason(), Reason::Discarded);
}

#[test]
fn starts_are_refused_in_another_mode_at_speed_and_without_a_table() {
    let mut bench = prepared(2);
    let (code, reason, refusal) = bench.refused(start(1));
    assert_eq!((code, reason, refusal.axis.get(), refusal.got.get()), (1, Reason::TableEmpty, 1, 1.0));
    // A table without points cannot be selected at standstill either (GXN command 46).
    let (code, reason, refusal) = bench.refused(select(1, 9));
    assert_eq!((code, reason, refusal.axis.get(), refusal.got.get()), (1, Reason::TableEmpty, 1, 9.0));
    let shown = bench.call(PvtStatus { core: 1.into(), profile: 1.into(), count: 1.into() }).items::<PvtStatus>();
    assert_eq!(shown[0].table.get(), 1, "nothing has changed");
    assert_eq!(load(&mut bench, 1, &TEN).0, 0);
    let (code, reason, refusal) = bench.refused(start(0b101));
    assert_eq!((code, reason, refusal.axis.get()), (1, Reason::WrongMode, 3), "all or nothing");
    bench.run_ms(5);
    assert_eq!(bench.pos(1), 0.0);
    bench.done(start(1));
    assert_eq!(bench.refused(start(1)).1, Reason::Moving);
    assert_eq!(bench.refused(PrfPvt { core: 1.into(), profile: 1.into() }).1, Reason::Moving);
    assert_eq!(bench.call(start(0)).code, 0);
    assert_eq!(bench.refused(GetPvtLoop { core: 1.into(), profile: 3.into() }).1, Reason::WrongMode);
    assert_eq!(bench.refused(PvtStatus { core: 1.into(), profile: 2.into(), count: 2.into() }).1, Reason::WrongMode);
    let bad = SetPvtLoop { core: 1.into(), profile: 1.into(), loop_count: (-1).into() };
    assert_eq!((bench.refused(bad).0, bench.refused(bad).2.field.to_owned()), (7, 2));
    // Reset empties the tables.
    bench.run_ms(20);
    bench.done(Reset { core: 1.into() });
    bench.servo_on(1);
    bench.done(PrfPvt { core: 1.into(), profile: 1.into() });
    assert_eq!(bench.refused(start(1)).1, Reason::TableEmpty);
}

#[test]
fn loops_accumulate_and_both_counts_are_reported() {
    let mut bench = prepared(1);
    let loops = |bench: &mut Bench<8>| {
        let reply = bench.done(GetPvtLoop { core: 1.into(), profile: 1.into() });
        (reply.loop_count.get(), reply.loop_set.get())
    };
    assert_eq!(loops(&mut bench), (0, 1));
    assert_eq!(load(&mut bench, 1, &TEN).0, 0);
    passes(&mut bench, 1, 0);
    bench.done(start(1));
    bench.run_ms(95);
    assert_eq!(loops(&mut bench), (9, 0));
    passes(&mut bench, 1, 12);
    bench.run_ms(100);
    assert_eq!((loops(&mut bench), bench.pos(1)), ((12, 12), 120.0));
    assert_eq!(bench.status_word(1) & 0x400, 0, "at rest");
    // Started again it continues from there and counts from 0.
    passes(&mut bench, 1, 2);
    bench.done(start(1));
    bench.run_ms(40);
    assert_eq!((loops(&mut bench), bench.pos(1)), ((2, 2), 140.0));
}

#[test]
fn the_calculate_commands_answer_what_the_manual_prints() {
    let mut bench = Bench::gus();
    // Table 4-11.
    let x: [(f64, f64); 7] = [
        (0.0, 0.0),
        (1000.0, 5000.0),
        (2000.0, 15000.0),
        (3000.0, 20000.0),
        (4000.0, 15000.0),
        (5000.0, 5000.0),
        (6000.0, 0.0),
    ];
    let points = x.map(|(time, pos)| PvtPercentPoint { time: time.into(), pos: pos.into(), percent: 60.0.into() });
    let head = |first: u16| PvtPercentCalculate {
        core: 1.into(),
        count: 7.into(),
        first: first.into(),
        vel_begin: 0.0.into(),
    };
    let values = |answer: &bench::Answer| -> Vec<f64> {
        answer.items::<PvtPercentCalculate>().iter().map(|item| item.value.get()).collect()
    };
    let wanted = [0.0, 10.0, 10.0, 0.0, -10.0, -10.0, 0.0];
    let whole = bench.call_items(head(0), &points);
    assert_eq!(values(&whole), wanted);
    // In chunks, by the program lane, and at the same time by the immediate one.
    let requests = [
        (PvtPercentCalculate::OPCODE, Lane::Program, body(head(0), &points[..4])),
        (PvtPercentCalculate::OPCODE, Lane::Program, body(head(4), &points[4..])),
        (ProgramEnd::OPCODE, Lane::Program, vec![]),
    ];
    let tags = bench.post_all(&requests);
    let whole = bench.call_items(head(0), &points);
    assert_eq!(values(&whole), wanted);
    bench.done(ProgramStart { strict: 0 });
    let (first, second) = (bench.wait(tags[0]), bench.wait(tags[1]));
    assert_eq!([values(&first), values(&second)].concat(), wanted);
    let late = bench.call_items(head(4), &points[4..]);
    assert_eq!((late.code, late.reason(), late.refusal().field), (7, Reason::OutOfRange, 2));
}

/// Points wait where nothing is lost: in an empty table, also while the table that they replace
/// runs. Only if there is none, the old one is emptied first.
#[test]
fn points_wait_in_the_memory_of_an_empty_table() {
    let mut bench: Bench<16> = Bench::new(1, 250);
    let core = |core: i16, table: PvtTable| PvtTable { core: core.into(), ..table };
    bench.servo_on(1);
    bench.done(PrfPvt { core: 1.into(), profile: 1.into() });
    // All but one.
    for (group, number) in (1..=2).flat_map(|group| (1..=32).map(move |number| (group, number))).skip(1) {
        assert_eq!(bench.call_items(core(group, table(number, 2, 0)), &points(&TEN)).code, 0, "{group} {number}");
    }
    bench.done(select(1, 2));
    bench.done(start(1));
    bench.run_ms(5);
    let three = [(0.0, 0.0, 0.0), (10.0, 500.0, 0.0), (10.0, 600.0, 0.0)];
    assert_eq!(bench.call_items(table(2, 3, 0), &points(&three[..2])).code, 0, "it waits in table 1");
    bench.run_ms(20);
    assert_eq!(bench.pos(1), 10.0, "the table that ran is whole");
    let last = bench.call_items(table(2, 3, 2), &points(&three[2..]));
    assert_eq!((last.code, last.reason()), (7, Reason::PointTime));
    bench.done(start(1));
    bench.run_ms(20);
    assert_eq!(bench.pos(1), 20.0, "a refused table changes nothing");

    // Now all of them.
    assert_eq!(bench.call_items(table(1, 2, 0), &points(&TEN)).code, 0);
    bench.done(start(1));
    let refused = bench.call_items(table(2, 3, 0), &points(&three[..2]));
    assert_eq!((refused.code, refused.reason()), (1, Reason::TableInUse));
    bench.run_ms(20);
    assert_eq!(bench.pos(1), 30.0);
    assert_eq!(bench.call_items(table(2, 3, 0), &points(&three[..2])).code, 0);
    assert_eq!(bench.refused(start(1)).1, Reason::TableEmpty, "it has made room");
    let good = [three[0], three[1], (20.0, 510.0, 0.0)];
    assert_eq!(bench.call_items(table(2, 3, 2), &points(&good[2..])).code, 0);
    bench.done(start(1));
    bench.run_ms(30);
    assert_eq!(bench.pos(1), 540.0);
    // The others are as they were.
    bench.done(select(1, 1));
    bench.done(start(1));
    bench.run_ms(20);
    assert_eq!(bench.pos(1), 550.0);
}
