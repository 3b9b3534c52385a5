//! Data of a stream that a fault ends before the data's instant: it is refused there, and no answer
//! says that it was taken.
use crate::bench;
use bench::{Bench, MS, body, entry, position, pt_data, read_pos, sleep, start, wait_stop};
use protocol::command::*;
use protocol::reason::Reason;
use protocol::record::Lane;

const CORE: i16 = 1;
type Entry = (u16, Lane, Vec<u8>);

/// Axes 1 and 2 run dynamic streams of 1 pulse/ms for 100 ms, from instant 0 on.
fn two_streams() -> Vec<Entry> {
    let core = CORE.into();
    let mut entries = Vec::new();
    for axis in [1, 2] {
        entries.extend([
            entry(AxisOn { core, axis: axis.into() }),
            entry(PrfPt { core, profile: axis.into(), mode: 1.into() }),
            entry(PtData { kind: 1.into(), ..pt_data(axis, 100.0, 100) }),
        ]);
    }
    entries.push(entry(start(0b11)));
    entries
}

fn output(value: i16) -> Entry {
    entry(SetDoBit { core: CORE.into(), do_type: 12.into(), index: 1.into(), value: value.into() })
}

/// The next segment of a stream, which continues at the same speed and ends it.
fn more(axis: i16, lane: Lane) -> Entry {
    let data = PtData { kind: 1.into(), ..pt_data(axis, 200.0, 200) };
    (PtData::OPCODE, lane, body(data, &[]))
}

/// Runs a program; the alarm of axis 1 comes at 20 ms.
fn run(entries: &[Entry]) -> (Bench<8>, Vec<u16>) {
    let mut bench = Bench::gus();
    let tags = bench.post_all(entries);
    bench.done(ProgramStart { strict: 1 });
    bench.run_ms(20);
    bench.machine.inputs[0].alarm = true;
    (bench, tags)
}

#[test]
fn data_of_a_stream_that_a_fault_ended_is_refused_at_its_instant() {
    // With a call after it, its commit is in the ring long before; without, it gathers until
    // shortly before.
    for gathers in [false, true] {
        let mut entries = two_streams();
        entries.extend([entry(sleep(40)), output(0), entry(sleep(10))]);
        let data = entries.len();
        entries.extend([more(2, Lane::Program), more(1, Lane::Program), more(2, Lane::Program)]);
        entries[data + 2].2 = body(PtData { kind: 1.into(), ..pt_data(2, 300.0, 300) }, &[]);
        if !gathers {
            entries.push(output(1));
        }
        entries.push(entry(sleep(1000)));
        let after = entries.len();
        entries.extend([output(1), entry(ProgramEnd {})]);
        let (mut bench, tags) = run(&entries);
        let refused = bench.wait(tags[data + 1]);
        let (reason, refusal) = (refused.reason(), refused.refusal());
        assert_eq!((refused.code, reason, refusal.axis.get()), (1, Reason::StreamEnded, 1), "gathers {gathers}");
        assert_eq!(
            (refusal.got.get() as i32 & 2, refusal.high.get()),
            (2, 8.0),
            "status and stop reason are the alarm's"
        );
        let clock = bench.done(ProgramStatus {}).clock_ns.get();
        assert!((50 * MS..51 * MS + MS / 2).contains(&clock), "at its instant, {clock}");
        for (index, &tag) in tags[..=data].iter().enumerate() {
            assert_eq!(bench.wait(tag).code, 0, "gathers {gathers}: entry {index} came before it");
        }
        assert_eq!(bench.wait(tags[data + 2]).code, 0, "the other axis has no fault");
        assert_eq!(bench.wait(tags[after]).reason(), Reason::Discarded);
        // The Abort that ends a failed program brakes axis 2 with 1 pulse/ms² from 1 pulse/ms.
        bench.run_ms(10);
        assert!((49.0..52.0).contains(&bench.pos(2)), "{}", bench.pos(2));
        assert!((19.0..21.5).contains(&bench.pos(1)), "{}", bench.pos(1));
    }
}

#[test]
fn lost_data_that_may_fail_ends_nothing_else() {
    for gathers in [false, true] {
        let mut entries = two_streams();
        entries.push(entry(sleep(50)));
        let data = entries.len();
        entries.extend([more(1, Lane::ProgramMayFail), more(2, Lane::ProgramMayFail)]);
        entries.push((PtData::OPCODE, Lane::ProgramMayFail, body(pt_data(1, 300.0, 300), &[])));
        if !gathers {
            entries.push(output(1));
        }
        entries.extend([entry(wait_stop(2)), entry(read_pos(2)), entry(ProgramEnd {})]);
        let (mut bench, tags) = run(&entries);
        let codes: Vec<i16> = tags.iter().map(|&tag| bench.wait(tag).code).collect();
        let lost = |index: usize| index == data || index == data + 2;
        assert!(codes.iter().enumerate().all(|(index, code)| *code == i16::from(lost(index))), "{codes:?}");
        let status = bench.done(ProgramStatus {});
        assert_eq!(status.late.get(), 0, "gathers {gathers}");
        assert_eq!(position(&bench.answers[&tags[tags.len() - 2]]), 200.0, "axis 2 goes on");
        // What is given now begins a stream of its own.
        bench.machine.inputs[0].alarm = false;
        bench.run_ms(1);
        bench.done(ClrSts { core: CORE.into(), axis: 1.into(), count: 1.into() });
        bench.servo_on(1);
        let before = bench.pos(1);
        bench.done(PtData { kind: 1.into(), ..pt_data(1, 10.0, 10) });
        bench.done(start(1));
        bench.run_ms(12);
        assert_eq!(bench.pos(1) - before, 10.0);
    }
}
