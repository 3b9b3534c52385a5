//! The program queue: timing, order, flow control, the lanes, the trace.
use crate::bench;
use bench::{Bench, MS, entry, listing_2_1, position, pt_data, read_pos, sleep, start, wait_stop};
use protocol::command::*;
use protocol::reason::Reason;
use protocol::record::Lane;
use protocol::trace::{Columns, Decoder, LaserSample, TraceEvent};
use servo::units::Ns;

const CORE: i16 = 1;

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

/// Positions of axis 1 tick by tick while a program runs; the thread polls every `poll_every`
/// ticks.
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
        // The run is recorded until its last answer came, which polling delays.
        let common = reference.len().min(other.len());
        assert!(other.len() >= reference.len());
        assert_eq!(reference[..common], other[..common], "polling every {poll_every} ticks");
    }
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
    assert_eq!(&refused[..], &tags[first..], "all after the first that did not fit");
    assert_eq!(bench.answers[&refused[0]].reason(), Reason::QueueFull);
    // The immediate lane does not wait for it.
    assert_eq!(bench.pos(1), 0.0);
    assert_eq!(bench.refused(AxisOn { core: CORE.into(), axis: 2.into() }).1, Reason::ProgramRuns);
    assert_eq!(bench.call(ClrSts { core: CORE.into(), axis: 1.into(), count: 1.into() }).code, 0);
    // Until the client asks for ProgramStatus, even a record that would fit is refused.
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

/// Bytes of a trace in the records of the link.
#[test]
fn a_trace_over_the_link_is_that_of_its_own_stream() {
    let rows = |over_link: u8| {
        let (core, axis) = (CORE.into(), 1.into());
        let mut bench = Bench::gus();
        bench.done(Trace { every: 1.into(), axes: 0b11.into(), lasers: 0, crds: 0, over_link, edges: 0 });
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
        bench.done(Trace { every: 0.into(), axes: 0.into(), lasers: 0, crds: 0, over_link: 0, edges: 0 });
        bench.run_ms(50);
        let (own, carried) = (std::mem::take(&mut bench.trace), std::mem::take(&mut bench.link_trace));
        let (bytes, nothing) = if over_link == 0 { (own, carried) } else { (carried, own) };
        assert!(nothing.is_empty(), "only one way");
        let (mut decoder, mut rows, mut ended) = (Decoder::new(), Vec::new(), false);
        decoder.feed(&bytes, |event| match event.unwrap() {
            TraceEvent::Head(..) => {}
            TraceEvent::Row(row, samples) => {
                rows.push((row, samples.axes.iter().map(|s| (s.pos.get(), s.vel_mantissa.get())).collect::<Vec<_>>()))
            }
            // Where the machine's 0 is comes unasked.
            TraceEvent::Zero(_) => {}
            TraceEvent::Action(_) | TraceEvent::Outputs(_) | TraceEvent::Period(_) => panic!("nobody asked for that"),
            TraceEvent::End { lost, .. } => ended = lost == 0,
        });
        assert!(ended);
        rows
    };
    let over_link = rows(1);
    // 300 ms and the ticks until the end of the trace was executed.
    assert!(over_link.len() >= 1201, "{}", over_link.len());
    assert_eq!(over_link.last().map(|row| row.1[0].0 >> 22), Some(100));
    let own = rows(0);
    assert_eq!(over_link[..1201], own[..1201]);
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

#[test]
fn the_trace_has_every_row_and_the_planned_motion() {
    let mut bench = Bench::gus();
    bench.done(Trace { every: 2.into(), axes: 0b101.into(), lasers: 0b10, crds: 0, over_link: 0, edges: 0 });
    bench.post_all(&listing_2_1());
    bench.done(ProgramStart { strict: 1 });
    bench.run_ms(3200);
    bench.done(Trace { every: 0.into(), axes: 0.into(), lasers: 0, crds: 0, over_link: 0, edges: 0 });
    bench.run_ms(1);
    let mut rows: Vec<(u32, i64, f64)> = Vec::new();
    let mut end = None;
    let mut head = None;
    Decoder::new().feed(&bench.trace, |event| match event.expect("no row is missing") {
        TraceEvent::Head(described, Columns { axes, lasers, .. }) => {
            head = Some((described.period_ns, described.every));
            assert!(lasers.iter().map(|id| id.channel).eq([1]) && described.timer_mhz == 1000);
            assert_eq!(axes.iter().map(|id| (id.core, id.axis)).collect::<Vec<_>>(), [(0, 1), (0, 3)]);
        }
        TraceEvent::Row(row, Columns { axes: samples, lasers, .. }) => {
            assert!(lasers.iter().eq([LaserSample::default()]), "the laser stays dark");
            let sample = samples.iter().next().unwrap();
            let velocity = sample.vel_mantissa.get() as f64 * (-f64::from(sample.vel_exponent.get())).exp2();
            rows.push((row, sample.pos.get(), velocity));
            assert_eq!(samples.iter().nth(1).unwrap().pos.get(), 0);
        }
        TraceEvent::Zero(_) => panic!("nothing is renamed"),
        TraceEvent::Action(_) | TraceEvent::Outputs(_) | TraceEvent::Period(_) => panic!("nobody asked for that"),
        TraceEvent::End { rows, lost } => end = Some((rows, lost)),
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

/// Outputs that a program sets 2 ms after its start, and after a Sleep of 10 ms and `ns`, in which
/// `ns` pass at once: their times and the clock that the program reports, both without `ns`.
fn clock_after(ns: u64) -> (Vec<(u64, u64)>, u64, u32) {
    let core = CORE.into();
    let mut bench = Bench::gus();
    bench.done(SetLinkLoss { time_ms: 0.into(), stop_all: 0.into() });
    let output = |index: i16| entry(SetDoBit { core, do_type: 12.into(), index: index.into(), value: 1.into() });
    let long = Sleep { ns: (10 * MS + ns).into() };
    let requests = [
        entry(sleep(2)),
        output(1),
        entry(long),
        output(2),
        entry(sleep(3)),
        output(3),
        entry(read_pos(1)),
        entry(sleep(20)),
        output(4),
        entry(wait_stop(1)),
        output(5),
        entry(ProgramEnd {}),
    ];
    let tags = bench.post_all(&requests);
    let started = bench.post(Lane::Immediate, ProgramStart { strict: 0 }, &[]);
    bench.wait(started);
    let (zero, mut edges, mut before) = (bench.server.view().script_zero.0, Vec::new(), bench.machine.outputs.2);
    bench.run_ms(5);
    assert_ne!(bench.machine.outputs.2, before, "the first output is set");
    before = bench.machine.outputs.2;
    bench.tick.advance_counters(0, Ns(ns));
    while !bench.answers.contains_key(tags.last().unwrap()) {
        bench.step();
        if bench.machine.outputs.2 != before {
            before = bench.machine.outputs.2;
            edges.push((bench.now().0 - zero - ns, before));
        }
    }
    let status = bench.done(ProgramStatus {});
    (edges, status.clock_ns.get() - ns, status.late.get())
}

#[test]
fn the_script_clock_passes_every_width() {
    let new = clock_after(0);
    assert_eq!((new.0.len(), new.2), (3, 0), "{new:?}");
    for bits in [31, 32, 52, 53, 63] {
        // It comes to 2^bits between the outputs.
        assert_eq!(clock_after((1 << bits) - 14 * MS), new, "2^{bits} ns");
    }
}
