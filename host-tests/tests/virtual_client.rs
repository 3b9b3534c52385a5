//! The client against the virtual controller, through the in-process link and over TCP.
use client::{Answer, Call, Client, Error, Observer, Options, ProductProfile, Progress, Quiet};
use protocol::command::*;
use protocol::link::Identity;
use std::net::TcpListener;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use trace::{Item, OutputEdge, Reader, Row};
use virtual_board::{Board, Config, Edge, Output, Shared, VirtualLink, share};

fn open_with(config: Config, options: Options) -> (Client, Shared) {
    let board = share(Board::new(config));
    let client = Client::open(Box::new(VirtualLink::new(board.clone())), options).unwrap();
    (client, board)
}

fn open() -> (Client, Shared) {
    open_with(Config::default(), Options::default())
}

/// The configuration of the manual's listings: limits and alarms off.
fn config_off() -> (LoadConfig, Vec<ConfigItem>) {
    let items = (1..=8i16)
        .map(|axis| ConfigItem { axis: axis.into(), given: 0b0101.into(), ..ConfigItem::default() })
        .collect::<Vec<_>>();
    (LoadConfig { core: 1.into(), count: (items.len() as u16).into() }, items)
}

fn pt(profile: i16, pos: f64, time_ms: i32) -> PtData {
    PtData { core: 1.into(), profile: profile.into(), pos: pos.into(), time_ms: time_ms.into(), ..PtData::default() }
}

/// Listing 2-1 on axis 1, as a program.
fn listing_2_1(trace: bool) -> Vec<Call> {
    let (config, items) = config_off();
    let mut calls = Vec::new();
    if trace {
        calls.push(Call::of(Trace { every: 1.into(), axes: 1.into(), lasers: 0, crds: 0, over_link: 0, edges: 0 }));
    }
    calls.extend([
        Call::of(Reset { core: 1.into() }),
        Call::with_items::<LoadConfig>(config, &items),
        Call::of(ClrSts { core: 1.into(), axis: 1.into(), count: 8.into() }),
        Call::of(AxisOn { core: 1.into(), axis: 1.into() }),
        Call::of(ZeroPos { core: 1.into(), axis: 1.into(), count: 1.into() }),
        Call::of(PrfPt { core: 1.into(), profile: 1.into(), mode: 0.into() }),
        Call::of(PtClear { core: 1.into(), profile: 1.into(), fifo: 0.into() }),
        Call::of(pt(1, 1024.0, 1024)),
        Call::of(pt(1, 3072.0, 2048)),
        Call::of(pt(1, 4096.0, 3072)),
        Call::of(PtStart { core: 1.into(), mask: 1.into(), option: 0.into() }),
        Call::of(WaitStop { core: 1.into(), axes: 1.into(), crds: 0.into() }),
        Call::of(GetPrfPos { core: 1.into(), profile: 1.into(), count: 1.into() }),
    ]);
    if trace {
        calls.push(Call::of(Trace::default()));
    }
    calls
}

/// Keeps all answers and progress.
#[derive(Default)]
struct Watch {
    answers: Vec<Answer>,
    progress: Vec<Progress>,
}

impl Observer for Watch {
    fn answered(&mut self, answer: Answer) -> client::Result<()> {
        self.answers.push(answer);
        Ok(())
    }
    fn progress(&mut self, progress: &Progress) -> client::Result<()> {
        self.progress.push(progress.clone());
        Ok(())
    }
}

/// Collects the rows of a trace.
fn rows_of(client: &Client) -> Arc<Mutex<(Vec<Row>, bool)>> {
    let rows = Arc::new(Mutex::new((Vec::new(), false)));
    let theirs = Arc::clone(&rows);
    let mut reader = Reader::new();
    client.trace_to(move |bytes| {
        let mut kept = theirs.lock().unwrap();
        reader
            .feed(bytes, |item| {
                match item {
                    Item::Row(row) => kept.0.push(row),
                    Item::End { .. } => kept.1 = true,
                    Item::Header(_)
                    | Item::Laser { .. }
                    | Item::Light { .. }
                    | Item::Output(_)
                    | Item::Analog(_)
                    | Item::Zero { .. } => {}
                }
                Ok(())
            })
            .unwrap();
    });
    rows
}

#[test]
fn listing_2_1_ends_at_exactly_4096() {
    let (client, _board) = open();
    let rows = rows_of(&client);
    let mut watch = Watch::default();
    let summary = client.run(listing_2_1(true), true, &mut watch).unwrap();
    assert_eq!(summary.failed, None);
    assert_eq!(summary.progress.queue.late.get(), 0);
    assert!(watch.answers.iter().enumerate().all(|(i, a)| a.index == i as u32 && a.code == 0));
    let (_, positions) = watch.answers.iter().find_map(|a| a.reply::<GetPrfPos>()).unwrap();
    assert_eq!({ positions[0].value }.get(), 4096.0);
    client.sleep(Duration::from_millis(50)).unwrap();
    let rows = rows.lock().unwrap();
    assert!(rows.1, "the trace has its end");
    let at = |ms: f64| {
        // The motion begins at row 1, one tick of 0.25 ms after the start.
        let row = &rows.0[(ms / 0.25) as usize + 1];
        (trace::decimal::position(row.axes[0].pos), trace::decimal::scaled(row.axes[0].vel))
    };
    let text = |p: &str, v: &str| (p.to_owned(), v.to_owned());
    assert_eq!(at(0.0), text("0.000000", "0.000000"));
    assert_eq!(at(512.0), text("256.000000", "1.000000"), "v = t/512 on the way up, p = t²/1024");
    assert_eq!(at(1024.0), text("1024.000000", "2.000000"));
    assert_eq!(at(1500.0), text("1976.000000", "2.000000"));
    assert_eq!(at(2560.0), text("3840.000000", "1.000000"));
    assert_eq!(at(3071.75).0, "4095.999939", "4096 - 0.25²/1024");
    assert_eq!(at(3072.0), text("4096.000000", "0.000000"));
    assert_eq!(rows.0[0].axes[0].pos.0, 0);
    assert!(rows.0.iter().enumerate().all(|(i, r)| r.index == i as u32 && r.t_ns == i as u64 * 250_000));
}

#[test]
fn the_same_calls_give_the_same_bytes() {
    let run = || {
        let (client, _board) = open();
        let rows = rows_of(&client);
        let mut watch = Watch::default();
        client.run(listing_2_1(true), false, &mut watch).unwrap();
        let now = client.now();
        let rows = std::mem::take(&mut rows.lock().unwrap().0);
        (watch.answers, watch.progress, now, rows)
    };
    assert!(run() == run());
}

fn refused<T: std::fmt::Debug>(result: client::Result<T>) -> Error {
    result.unwrap_err()
}

#[test]
fn refusals_have_code_and_reason() {
    let (client, _board) = open();
    let space = |profile: i16| client.call(PtSpace { core: 1.into(), profile: profile.into(), fifo: 0.into() });
    for axis in [0, 99] {
        let e = refused(space(axis));
        assert_eq!(e.code, 7, "{e}");
        assert!(
            e.reason.contains("PtSpace") && e.reason.contains("profile") && e.reason.contains(&axis.to_string()),
            "{e}"
        );
    }
    let e = refused(client.call(pt(1, 1.0, 1)));
    assert_eq!(e.code, 1, "{e}");
    assert!(e.reason.contains("mode"), "{e}");
    client.call(PrfPt { core: 1.into(), profile: 1.into(), mode: 0.into() }).unwrap();
    client.sleep(Duration::from_millis(1)).unwrap();
    let e = refused(client.call(pt(1, f64::NAN, 1)));
    assert_eq!(e.code, 7);
    assert!(e.reason.contains("pos") && e.reason.contains("finite"), "{e}");
    let e = refused(client.call(PtStart { core: 1.into(), mask: 1.into(), option: 0.into() }));
    assert_eq!(e.code, 1, "{e}");
    client.call(pt(1, 1.0, 10)).unwrap();
    let e = refused(client.call(pt(1, 2.0, 10)));
    assert_eq!(e.code, 7);
    assert!(e.reason.contains("time_ms") && e.reason.contains("10"), "{e}");
    let e = refused(client.call_raw(&Call { opcode: 0x7777, payload: vec![], may_fail: false }));
    assert_eq!(e.code, 8, "{e}");
    let e = refused(client.call_raw(&Call { opcode: PtSpace::OPCODE, payload: vec![1, 2, 3], may_fail: false }));
    assert_eq!(e.code, 7, "{e}");
}

#[test]
fn a_failing_entry_discards_the_rest_and_a_new_program_runs() {
    let (client, _board) = open();
    let mut program = client.program();
    let good = program.push(PrfPt { core: 1.into(), profile: 1.into(), mode: 0.into() });
    let bad = program.push(PtData { kind: 9.into(), ..pt(1, 5.0, 5) });
    let rest = program.push(AxisOn { core: 1.into(), axis: 1.into() });
    let mut watch = Watch::default();
    let summary = program.run(false, &mut watch).unwrap();
    let codes: Vec<_> = watch.answers.iter().map(|a| (a.index, a.code)).collect();
    assert_eq!(codes, [(good, 0), (bad, 7), (rest, 1)]);
    let failed = summary.failed.unwrap();
    assert_eq!(failed.index, bad);
    assert!(failed.error.unwrap().reason.contains("kind"));
    assert!(watch.answers[2].error.as_ref().unwrap().reason.contains("earlier entry"));
    assert_eq!(client.run(listing_2_1(false), false, &mut Quiet).unwrap().failed, None);
}

/// Keeps what each entry was answered.
struct All(Vec<Answer>);

impl Observer for All {
    fn answered(&mut self, answer: Answer) -> client::Result<()> {
        self.0.push(answer);
        Ok(())
    }
}

/// A path of short lines, each with a power of its own; every tenth power is out of range, which
/// this family limits. At `wrong` a line has no length.
fn powers_and_lines(count: i32, wrong: Option<i32>) -> Vec<Call> {
    let mut profile = [0.into(); 8];
    (profile[0], profile[1]) = (1.into(), 2.into());
    let (core, crd, fifo) = (1.into(), 1.into(), 0.into());
    let prm = SetCrdPrm {
        core,
        crd,
        dimension: 2.into(),
        profile,
        syn_vel_max: 849.0.into(),
        syn_acc_max: 21.0.into(),
        ..SetCrdPrm::default()
    };
    let look = InitLookAhead { core, crd, fifo, time_ms: 1.789.into(), acc_max: 20.0.into(), count: 200.into() };
    let mut calls = vec![
        Call::of(AxisOn { core, axis: 1.into() }),
        Call::of(AxisOn { core, axis: 2.into() }),
        Call::of(prm),
        Call::of(look),
    ];
    for k in 1..=count {
        if k == 201 {
            calls.push(Call::of(CrdStart { core, mask: 1.into(), option: 0.into() }));
        }
        let power = if k % 10 == 0 { 150.0 } else { f64::from(k % 100) };
        calls.push(Call::of(BufLaserPrfCmd { core, crd, power: power.into(), fifo, channel: 0.into() }));
        let x = if wrong == Some(k) { 2 * (k - 1) } else { 2 * k };
        let (syn_vel, syn_acc, vel_end) = (50.0.into(), 5.0.into(), 0.0.into());
        calls.push(Call::of(LnXY { core, crd, x: x.into(), y: 0.into(), syn_vel, syn_acc, vel_end, fifo }));
        if k % 370 == 0 {
            calls.push(Call::of(BufDelay { core, crd, delay_ms: 1.into(), fifo }));
        }
    }
    calls.push(Call::of(WaitStop { core, axes: 0.into(), crds: 1.into() }));
    calls.push(Call::of(GetCrdPos { core, crd }));
    calls
}

/// Calls of a path travel together, and each has the answer that it has alone. Alone, each waits
/// for the call before, and for what the look-ahead gives to the path meanwhile.
#[test]
fn joined_calls_of_a_program_are_answered_as_single_ones() {
    for wrong in [None, Some(1), Some(100), Some(1900), Some(2000)] {
        let mut all = Vec::new();
        for joins in [false, true] {
            let options = Options { joins, family: Some(client::Family::Lsr), ..Options::default() };
            let (client, board) = open_with(Config::default(), options);
            let mut found = All(Vec::new());
            let summary = client.run(powers_and_lines(2000, wrong), false, &mut found).unwrap();
            let failed = summary.failed.as_ref().map(|answer| answer.index);
            let rows: Vec<_> = found
                .0
                .iter()
                .map(|answer| {
                    let reason = answer.error.as_ref().map(|error| error.reason.clone());
                    // Free places and how long the data lasts depend on the time of the answer.
                    let reply = match answer.reply::<LnXY>().or(answer.reply::<BufDelay>()) {
                        Some((taken, _)) => vec![taken.taken.get() as u8],
                        None => answer.reply.clone(),
                    };
                    (answer.index, answer.opcode, answer.code, reason, reply)
                })
                .collect();
            assert_eq!(failed.is_some(), wrong.is_some(), "{joins} {:?}", summary.failed);
            all.push((rows, failed));
            drop((client, board));
        }
        let [single, joined] = &all[..] else { panic!() };
        // What follows a failure is answered as far as it was on the way.
        assert!(single.0.len() == joined.0.len() || wrong.is_some());
        for (single, joined) in single.0.iter().zip(&joined.0) {
            assert_eq!(single, joined, "{wrong:?}");
        }
        assert_eq!(single.1, joined.1);
    }
}

#[test]
fn profiles_are_chosen_and_refused() {
    let options = |profile| Options { profile: Some(profile), ..Options::default() };
    let (client, _board) = open_with(Config { profile: 5, ..Config::default() }, options(ProductProfile::Gsn048));
    let version = *client.version();
    assert_eq!((version.cores, version.axes_per_core), (2, 24));
    assert_eq!(client.board(), "virtual");
    assert!(client.call(PtSpace { core: 2.into(), profile: 24.into(), fifo: 0.into() }).is_err(), "not in PT mode");
    let small = share(Board::new(Config::default()));
    let e = Client::open(Box::new(VirtualLink::new(small)), options(ProductProfile::Gsn048)).err().unwrap();
    assert_eq!(e.code, 3, "{e}");
    assert!(e.reason.contains("48") && e.reason.contains('8'), "{e}");
}

#[test]
fn another_schema_is_refused_with_both_named() {
    let board = share(Board::new(Config::default()));
    let identity = Identity { schema: Identity::OURS.schema ^ 1, ..Identity::OURS };
    let options = Options { identity, ..Options::default() };
    let e = Client::open(Box::new(VirtualLink::new(board)), options).err().unwrap();
    assert_eq!(e.code, 3, "{e}");
    assert!(e.reason.contains(&format!("{:08x}", identity.schema)), "{e}");
    assert!(e.reason.contains(&format!("{:08x}", Identity::OURS.schema)), "{e}");
}

#[test]
fn a_closed_port_cannot_be_opened() {
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    for name in
        [format!("tcp:127.0.0.1:{port}"), "serial:/no/such/port".into(), "qemu:/no/such/image".into(), "what".into()]
    {
        let e = client::link::open(&name).err().unwrap();
        assert_eq!(e.code, -6, "{e}");
        assert!(e.reason.contains(&name), "{e}");
    }
}

#[test]
fn a_silent_port_does_not_answer() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let name = format!("tcp:{}", listener.local_addr().unwrap());
    let options = Options { open_timeout: Duration::from_millis(300), ..Options::default() };
    let begun = Instant::now();
    let e = Client::open(client::link::open(&name).unwrap(), options).err().unwrap();
    assert_eq!(e.code, -7, "{e}");
    assert!(e.reason.contains(&name) && e.reason.contains("300 ms"), "{e}");
    assert!(begun.elapsed() < Duration::from_secs(3));
}

#[test]
fn a_link_that_closes_is_reported() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let name = format!("tcp:{}", listener.local_addr().unwrap());
    let closer = std::thread::spawn(move || drop(listener.accept()));
    let link = client::link::open(&name).unwrap();
    closer.join().unwrap();
    let e = Client::open(link, Options::default()).err().unwrap();
    assert_eq!(e.code, client::error::LINK_CLOSED, "{e}");
}

#[test]
fn served_over_tcp_it_runs_a_job_in_real_time() {
    let begun = Instant::now();
    let served = virtual_board::serve(TcpListener::bind("127.0.0.1:0").unwrap(), None, Config::default()).unwrap();
    let name = format!("tcp:{}", served.address());
    for _ in 0..2 {
        let client = Client::open(client::link::open(&name).unwrap(), Options::default()).unwrap();
        let now = || Duration::from_nanos(served.board().lock().unwrap().now());
        let before = now();
        let mut watch = Watch::default();
        let summary = client.run(listing_2_1(false), false, &mut watch).unwrap();
        assert_eq!(summary.failed, None);
        // In the controller's time, which is never ahead of the wall clock by more than the tick
        // that it is in.
        let after = now();
        assert!(after - before >= Duration::from_millis(3072), "{before:?} to {after:?}");
        assert!(after <= begun.elapsed() + Duration::from_micros(250), "real time: {after:?} in {:?}", begun.elapsed());
        let (_, positions) = watch.answers.iter().find_map(|a| a.reply::<GetPrfPos>()).unwrap();
        assert_eq!({ positions[0].value }.get(), 4096.0);
        assert!(watch.progress.len() >= 10);
        // The keeper holds the link while nobody calls, for longer than the link-loss time.
        std::thread::sleep(Duration::from_millis(800));
        client.call(GetClock {}).unwrap();
    }
    assert!(served.board().lock().unwrap().outputs().enable & 1 == 1);
}

#[test]
fn inputs_reach_the_controller_and_outputs_are_recorded() {
    let (client, board) = open();
    board.lock().unwrap().inputs_mut().general = 0b1010;
    board.lock().unwrap().inputs_mut().axes[2].home = true;
    client.sleep(Duration::from_millis(2)).unwrap();
    let gpi = client.call(GetDi { core: 1.into(), di_type: 4.into() }).unwrap();
    assert_eq!({ gpi.value }.get() & 0xff, 0b1010);
    let home = client.call(GetDi { core: 1.into(), di_type: 3.into() }).unwrap();
    assert_eq!({ home.value }.get() & 0xff, 0b100);
    let set = |index: i16, value: i16| SetDoBit {
        core: 1.into(),
        do_type: 12.into(),
        index: index.into(),
        value: value.into(),
    };
    let traced: Arc<Mutex<Vec<OutputEdge>>> = Arc::default();
    let (kept, mut reader) = (Arc::clone(&traced), Reader::new());
    client.trace_to(move |bytes| {
        let fed = reader.feed(bytes, |item| {
            if let Item::Output(edge) = item {
                kept.lock().unwrap().push(edge);
            }
            Ok(())
        });
        fed.unwrap();
    });
    client.call(set(7, 1)).unwrap();
    client.sleep(Duration::from_millis(1)).unwrap();
    let trace = |every: u32| Trace { every: every.into(), axes: 1.into(), lasers: 0, crds: 0, over_link: 0, edges: 2 };
    client.call(trace(4)).unwrap();
    let mut program = client.program();
    program.push(set(3, 1));
    program.push(Sleep { ns: 10_000_000.into() });
    program.push(set(3, 0));
    program.push(Sleep { ns: 1_000_000.into() });
    program.push(trace(0));
    assert_eq!(program.run(true, &mut Quiet).unwrap().failed, None);
    client.sleep(Duration::from_millis(2)).unwrap();
    let edge = |t_ns: u64, output: u8, level: bool| OutputEdge { t_ns, output, level };
    let expected = [edge(0, 7, true), edge(250_000, 3, true), edge(10_250_000, 3, false)];
    assert_eq!(*traced.lock().unwrap(), expected, "the trace tells the same");
    let mut board = board.lock().unwrap();
    let zero = board.program_zero_ns();
    let edges: Vec<Edge> = board.take_edges();
    let general: Vec<_> =
        edges.iter().filter(|e| matches!(e.output, Output::General(2))).map(|e| (e.at_ns - zero, e.level)).collect();
    assert_eq!(general, [(250_000, true), (10_250_000, false)], "on the first tick after 0 and 10 ms: {edges:?}");
    assert!(board.take_edges().is_empty());
}

/// 1 ms segments of eight axes, `ahead_ms` before the start, the rest while they run.
fn stream(seconds: i32, ahead_ms: i32) -> impl Iterator<Item = Call> {
    let (config, items) = config_off();
    let head = [
        Call::with_items::<LoadConfig>(config, &items),
        Call::of(ClrSts { core: 1.into(), axis: 1.into(), count: 8.into() }),
    ];
    let axes = (1..=8i16).flat_map(|axis| {
        [
            Call::of(AxisOn { core: 1.into(), axis: axis.into() }),
            Call::of(PrfPt { core: 1.into(), profile: axis.into(), mode: 1.into() }),
            Call::of(SetPtMemory { core: 1.into(), profile: axis.into(), memory: 1.into() }),
        ]
    });
    const SHARE: i32 = 50;
    let data = (0..seconds * 1000 / SHARE).flat_map(move |part| {
        let fill = (1..=8i16).map(move |axis| {
            let items: Vec<PtItem> = (1..=SHARE)
                .map(|i| {
                    let t = part * SHARE + i;
                    let last = t == seconds * 1000;
                    PtItem {
                        pos: f64::from(t * i32::from(axis)).into(),
                        time_ms: t.into(),
                        kind: if last { 2 } else { 1 },
                    }
                })
                .collect();
            let many =
                PtDataMany { core: 1.into(), profile: axis.into(), fifo: 0.into(), count: (SHARE as u16).into() };
            Call::with_items::<PtDataMany>(many, &items)
        });
        // From the start on each share is called for when as much has run.
        let ahead = ahead_ms / SHARE;
        let start =
            (part == ahead - 1).then(|| Call::of(PtStart { core: 1.into(), mask: 0xff.into(), option: 0.into() }));
        let sleep = (part >= ahead).then(|| Call::of(Sleep { ns: (SHARE as u64 * 1_000_000).into() }));
        sleep.into_iter().chain(fill).chain(start).collect::<Vec<_>>()
    });
    let tail = [
        Call::of(WaitStop { core: 1.into(), axes: 0xff.into(), crds: 0.into() }),
        Call::of(GetPrfPos { core: 1.into(), profile: 1.into(), count: 8.into() }),
    ];
    head.into_iter().chain(axes).chain(data).chain(tail)
}

#[test]
fn eight_streams_never_run_dry() {
    for ahead_ms in [1000, 2000] {
        run_stream(ahead_ms);
    }
}

fn run_stream(ahead_ms: i32) {
    let (client, _board) = open();
    let mut watch = Watch::default();
    // 2000 ms fill the rings of 2048 but for 48 places.
    let summary = client.run(stream(20, ahead_ms), true, &mut watch).unwrap();
    assert_eq!(summary.failed, None);
    let queue = summary.progress.queue;
    assert_eq!(({ queue.late }.get(), { queue.worst_late_us }.get()), (0, 0));
    let (_, positions) = watch.answers.last().unwrap().reply::<GetPrfPos>().unwrap();
    let reached: Vec<f64> = positions.iter().map(|p| { p.value }.get()).collect();
    assert_eq!(reached, (1..=8).map(|axis| 20_000.0 * f64::from(axis)).collect::<Vec<_>>());
    for axis in 1..=8i16 {
        let state = client.call(GetPtState { core: 1.into(), profile: axis.into() }).unwrap();
        assert_eq!(state.state, 2, "axis {axis} ended by itself");
    }
    let seen: Vec<_> = watch.progress.iter().filter(|p| p.streams.len() == 8).collect();
    assert!(seen.len() > 100, "space and time to dry are reported during the job");
}

#[test]
fn a_virtual_link_needs_no_wall_clock() {
    let (client, _board) = open();
    let begun = Instant::now();
    let before = client.now();
    client.sleep(Duration::from_secs(60)).unwrap();
    assert!(client.now() - before >= Duration::from_secs(60));
    assert!(begun.elapsed() < Duration::from_secs(20));
    client.call(GetClock {}).unwrap();
}
