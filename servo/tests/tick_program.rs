//! The two lanes, the script clock, the trace.
use crate::tick_bench;
use servo::status::*;
use servo::tick_command::{DoGroup, Lane, MotionMode, TickCommand};
use servo::units::{AxisMask, CrdMask, Ns, Pos};
use servo::view::{Event, Sample, Traced};
use tick_bench::*;

const US: u64 = 1000;

fn output(bit: u32) -> TickCommand {
    TickCommand::Output { group: DoGroup::General, mask: 1 << bit, value: 1 << bit }
}

/// Ticks on until output `bit` is set; returns the instant of the tick from which on it is.
fn instant_of(bench: &mut Bench, bit: u32) -> u64 {
    for _ in 0..100_000 {
        let view = bench.tick();
        if view.general_outputs >> bit & 1 == 1 {
            assert_eq!(view.general_outputs, bench.machine.outputs.2);
            return view.now.0;
        }
    }
    panic!("output {bit} never came");
}

#[test]
fn a_call_acts_on_the_first_tick_strictly_after_its_instant() {
    for period in [50, 250, 1000] {
        let step = period as u64 * US;
        let mut bench = Bench::prepared(period, MotionMode::PtStatic);
        // 0, exactly on a tick, between ticks, and 0.3 ms ten times: sleeps add up exactly.
        bench.then(0, output(0));
        bench.then(2 * MS, output(1));
        bench.then(10 * US, output(2));
        bench.then(0, output(3));
        let mut instants = vec![0, 2 * MS, 2 * MS + 10 * US, 2 * MS + 10 * US];
        for bit in 4..14 {
            bench.then(300 * US, output(bit));
            instants.push(instants.last().unwrap() + 300 * US);
        }
        let held = bench.ticks(5);
        assert_eq!((held.general_outputs, held.done_program), (0, 0), "held until ProgramRun");
        bench.now(TickCommand::ProgramRun);
        let zero = held.now.0;
        let view = bench.tick();
        assert_eq!((view.script_zero.0, view.program_runs), (zero, true));
        assert_eq!(view.general_outputs & 1, 1);
        for (bit, instant) in instants.iter().enumerate().skip(1) {
            let tick = (instant / step + 1) * step;
            // Some are on the present tick.
            let now = bench.tick.now().0;
            let seen = if bench.machine.outputs.2 >> bit & 1 == 1 { now } else { instant_of(&mut bench, bit as u32) };
            assert_eq!(seen, zero + tick, "entry {bit} at {period} µs");
        }
        let view = bench.tick();
        assert_eq!((view.late, view.done_program, view.script.0), (0, 14, *instants.last().unwrap()));
    }
}

#[test]
fn wait_rest_moves_the_clock_to_the_tick_of_rest() {
    for period in [50, 250, 1000] {
        let step = period as u64 * US;
        let mut bench = Bench::prepared(period, MotionMode::PtStatic);
        bench.pt(0, 0, &LISTING_2_1);
        bench.tick();
        bench.then(0, TickCommand::PtStart { axes: all(&[0]), fifo1: AxisMask(0) });
        let wait = bench.then(0, TickCommand::WaitStandstill { axes: all(&[0]), crds: CrdMask(0) });
        bench.then(0, output(0));
        bench.then(1500 * US, output(1));
        bench.then(0, TickCommand::WaitStandstill { axes: all(&[0, 5]), crds: CrdMask(0) });
        bench.then(0, output(2));
        let zero = bench.tick.now().0;
        bench.now(TickCommand::ProgramRun);
        let begun = bench.tick();
        assert_eq!((begun.axes[0].pos, begun.now.0), (Pos(0), zero + step));
        let end = zero + step + 3072 * MS;
        let view = bench.until(end);
        assert_eq!(view.axes[0].pos, Pos::pulses(4096));
        assert!(!has(&view.axes[0], RUNNING) && view.done_program < wait);
        let view = bench.tick();
        assert_eq!(view.general_outputs, 1, "acts on the first tick after the tick of rest");
        assert_eq!((view.script.0, view.done_program), (end - zero, wait + 1));
        let second = (end + 1500 * US) / step * step + step;
        let view = bench.until(second);
        // At rest already: the second wait leaves the clock where it is.
        assert_eq!(view.general_outputs, 7);
        assert_eq!((view.script.0, view.late), (end - zero + 1500 * US, 0));
    }
}

#[test]
fn a_late_entry_acts_at_once_is_counted_and_shifts_nothing() {
    let mut bench = Bench::prepared(250, MotionMode::PtStatic);
    bench.then(0, output(0));
    let zero = bench.tick.now().0;
    bench.now(TickCommand::ProgramRun);
    let view = bench.until(zero + 10 * MS);
    assert_eq!(view.late, 0);
    // Its instant was 4 ms ago when the next tick is computed at 10 ms.
    bench.then(6 * MS, output(1));
    let view = bench.tick();
    assert_eq!((view.general_outputs, view.late, view.worst_late), (3, 1, Ns(4 * MS)));
    bench.then(10 * MS, output(2));
    assert_eq!(instant_of(&mut bench, 2), zero + 16 * MS + 250 * US);
    // A wait that comes late still has the instant since which the axis is at rest.
    let view = bench.until(zero + 30 * MS);
    assert_eq!((view.late, view.worst_late), (1, Ns(4 * MS)));
    bench.then(0, TickCommand::WaitStandstill { axes: all(&[0]), crds: CrdMask(0) });
    assert_eq!(bench.tick().script.0, 16 * MS);
}

#[test]
fn so_many_entries_act_in_a_tick_the_immediate_lane_first() {
    // A call for each 512 ns and an entry of set-up for each 1024 ns; in the shortest tick 64
    // calls, and 9 entries.
    for (period, done) in [
        (10, [(64, 0), (100, 0), (100, 9), (100, 18), (100, 27)]),
        (50, [(97, 0), (100, 45), (100, 93), (100, 141), (100, 189)]),
        (100, [(100, 0), (100, 97), (100, 194), (100, 200), (100, 200)]),
    ] {
        let mut bench = Bench::prepared(period, MotionMode::PtStatic);
        let run = bench.now(TickCommand::ProgramRun);
        for _ in 0..99 {
            bench.now(TickCommand::Mark);
        }
        for _ in 0..200 {
            bench.then(0, TickCommand::Mark);
        }
        for done in done {
            let view = bench.tick();
            assert_eq!((view.done_immediate - run + 1, view.done_program), done, "{period} µs");
        }
        assert_eq!(bench.tick().late, 0, "what did not fit into its tick was put off");
    }
    // The larger ring's content in a long tick.
    let mut bench = Bench::prepared(1000, MotionMode::PtStatic);
    bench.now(TickCommand::ProgramRun);
    for _ in 0..256 {
        bench.then(0, TickCommand::Mark);
    }
    assert_eq!(bench.tick().done_program, 256);
}

#[test]
fn drop_empties_the_lane_and_end_holds_it() {
    let mut bench = Bench::prepared(250, MotionMode::PtStatic);
    bench.then(0, output(0));
    bench.then(5 * MS, output(1));
    bench.now(TickCommand::ProgramRun);
    bench.tick();
    bench.now(TickCommand::ProgramDrop);
    assert!(!bench.tick().program_runs);
    bench.then(0, output(2));
    assert_eq!(bench.ticks(100).general_outputs, 1);
    let end = bench.then(0, TickCommand::ProgramEnd);
    bench.then(0, output(3));
    bench.now(TickCommand::ProgramRun);
    let view = bench.ticks(10);
    assert_eq!((view.general_outputs, view.done_program, view.program_runs), (5, end, false));
    // The next program has a clock of its own.
    bench.now(TickCommand::ProgramRun);
    let zero = view.now;
    let view = bench.tick();
    assert_eq!((view.general_outputs, view.script_zero, view.script), (13, zero, Ns(0)));
}

#[test]
fn a_refusal_in_a_program_names_its_entry() {
    let mut bench = Bench::prepared(250, MotionMode::PtStatic);
    let seq = bench.then(MS, TickCommand::PtStart { axes: all(&[2]), fifo1: AxisMask(0) });
    bench.now(TickCommand::ProgramRun);
    bench.ticks(10);
    assert!(matches!(bench.event(),
        Some(Event::Refused { lane: Lane::Program, seq: s, axis, .. }) if s == seq && axis.index() == 2));
}

#[test]
fn trace_rows_count_from_the_tick_at_which_the_program_begins() {
    for every in [1, 4] {
        let mut bench = Bench::prepared(250, MotionMode::PtStatic);
        bench.pt(0, 0, &LISTING_2_1);
        bench.now(TickCommand::SetPosition { axis: axis(3), pos: Pos::pulses(9) });
        bench.now(TickCommand::Trace {
            every,
            axes: all(&[0, 3]),
            crds: CrdMask(0),
            lasers: 0,
            edges: false,
            outputs: false,
        });
        bench.ticks(7);
        assert!(bench.sample().is_none(), "armed only");
        bench.then(0, TickCommand::PtStart { axes: all(&[0]), fifo1: AxisMask(0) });
        bench.then(0, TickCommand::SetPosition { axis: axis(3), pos: Pos::pulses(10) });
        bench.then(
            3100 * MS,
            TickCommand::Trace {
                every: 0,
                axes: AxisMask(0),
                crds: CrdMask(0),
                lasers: 0,
                edges: false,
                outputs: false,
            },
        );
        bench.now(TickCommand::ProgramRun);
        let step = every as u64 * 250 * US;
        let (mut rows, mut names) = (vec![], vec![]);
        for _ in 0..12_500 {
            let view = bench.tick();
            while let Some(sample) = bench.sample() {
                match sample {
                    Sample { row, of: Traced::Zero { axis, by } } => names.push((row, axis.index(), by, rows.len())),
                    _ => rows.push((sample, view.now.0 - view.script_zero.0)),
                }
            }
        }
        // What the position is called at row 0, and then a pulse more before the next row. Each
        // follows the other axis of its row, as axes are in their order.
        assert_eq!(names, [(0, 3, Pos::pulses(9), 1), (1, 3, Pos::pulses(1), 2)]);
        // Up to and including the tick at which the trace's end was called.
        assert_eq!(rows.len() as u64, 2 * (3100 * MS / step + 1));
        for (n, pair) in rows.chunks(2).enumerate() {
            let t = n as u64 * step;
            let mut of = [Pos(0); 2];
            for (((sample, seen), index), of) in pair.iter().zip([0, 3]).zip(&mut of) {
                let Sample { row, of: Traced::Axis { axis, pos, .. } } = *sample else { panic!("{sample:?}") };
                assert_eq!((row as usize, axis.index()), (n, index));
                assert_eq!(*seen, t.max(250 * US));
                *of = pos;
            }
            let [moving, still] = of;
            // The start called at 0 has its time zero in row 1 · every = 1.
            assert_eq!(moving > Pos(0), t > 250 * US, "row {n}");
            if t >= 250 * US + 3072 * MS {
                assert_eq!(moving, Pos::pulses(4096));
            } else {
                assert!(moving < Pos::pulses(4096));
            }
            assert_eq!(still, Pos::pulses(if n == 0 { 9 } else { 10 }));
        }
    }
}

#[test]
fn a_trace_that_nobody_takes_counts_what_it_loses() {
    let mut bench = Bench::prepared(250, MotionMode::PtStatic);
    bench.now(TickCommand::Trace {
        every: 1,
        axes: AxisMask(0xff),
        crds: CrdMask(0),
        lasers: 0,
        edges: false,
        outputs: false,
    });
    bench.now(TickCommand::ProgramRun);
    let view = bench.ticks(130);
    // 131 rows of 8; the ring holds 1024.
    assert_eq!(view.trace_lost, 131 * 8 - 1024);
    for n in 0..1024 {
        assert_eq!(bench.sample().unwrap().row, n / 8);
    }
    bench.tick();
    assert_eq!(bench.sample().unwrap().row, 131, "the row number tells that some are missing");
    let end = |every| TickCommand::Trace {
        every,
        axes: AxisMask(1),
        crds: CrdMask(0),
        lasers: 0,
        edges: false,
        outputs: false,
    };
    bench.now(end(0));
    let lost = bench.tick().trace_lost;
    assert!(lost >= 131 * 8 - 1024, "it is still reported when the trace has ended");
    bench.now(end(1));
    assert_eq!(bench.tick().trace_lost, 0, "another one has lost nothing");
}

#[test]
fn the_view_is_of_one_tick_and_the_outside_of_an_idle_tick_is_quiet() {
    let mut bench = Bench::new(250);
    let view = bench.ticks(3);
    assert_eq!((view.tick, view.now, view.period), (3, Ns(750 * US), Ns(250 * US)));
    assert_eq!((view.general_inputs, &view.analog[..3]), (0x5a, &[100, 101, 0][..]));
    assert_eq!(bench.machine.outputs, (0, 0, 0));
    bench.tick.overrun();
    bench.now(TickCommand::Analog { channel: 3, value: -5 });
    bench.now(TickCommand::Output { group: DoGroup::Clear, mask: 6, value: 4 });
    let view = bench.tick();
    assert_eq!((view.overruns, view.clear, bench.machine.analog_out[3]), (1, 4, -5));
}

#[test]
fn views_that_nobody_read_leave_nothing_stale() {
    let mut bench = Bench::prepared(250, MotionMode::PtStatic);
    bench.pt(0, 0, &[(10.0, 10, 2)]);
    bench.start(&[0]);
    // One buffer stays with the reader for the whole motion and long after it.
    for _ in 0..1000 {
        bench.tick_unread();
    }
    for _ in 0..3 {
        assert_eq!(bench.tick().axes[0].pos, Pos::pulses(10));
    }
}

#[test]
fn the_period_changes_at_rest_only() {
    let mut bench = Bench::prepared(250, MotionMode::Jog);
    bench.now(TickCommand::TickPeriod { ns: 50_000 });
    let first = bench.tick();
    let second = bench.tick();
    assert_eq!((first.period, second.now.0 - first.now.0), (Ns(50 * US), 50 * US));
    bench.now(TickCommand::TickPeriod { ns: 9_999 });
    bench.jog(0, 1.0, 1.0);
    bench.now(TickCommand::TickPeriod { ns: 1_000_000 });
    assert_eq!(bench.tick().period, Ns(50 * US));
    assert_eq!(bench.tick.period(), Ns(50 * US));
}
