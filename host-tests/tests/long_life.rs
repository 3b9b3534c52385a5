//! Counters that wrap: a controller whose counters are about to do so does what a new one does,
//! and what was executed long ago stays executed.
#[path = "life/work.rs"]
mod work;

use plant::beam::SignalChange;
use plant::pulses::Burst;
use protocol::command::{CrdSpace, CrdStatus, GetRemainderSegNum};
use std::time::Duration;
use virtual_board::{Board, Config, Edge, share};
use work::{ROUND_TICKS, SETUP, TICK_US, round, run};

/// What a controller has done by the end of a round.
#[derive(Debug, Clone, PartialEq)]
struct Done {
    set_points: Vec<[i64; 8]>,
    on_time: [u32; 2],
    edges: Vec<Edge>,
    beam: Vec<(u8, SignalChange)>,
}

/// The change with its instant counted from `begin`.
fn since(change: SignalChange, begin: u64) -> SignalChange {
    match change {
        SignalChange::Switch { at, level } => SignalChange::Switch { at: at - begin, level },
        SignalChange::Energy { at, level } => SignalChange::Energy { at: at - begin, level },
        SignalChange::Pulses(burst) => SignalChange::Pulses(Burst { at: burst.at - begin, ..burst }),
        SignalChange::Dac { at, code } => SignalChange::Dac { at: at - begin, code },
    }
}

/// A round of a controller that has executed so many entries and so many ns before.
fn life(entries: u32, ns: u64) -> Done {
    let mut board = Board::new(Config { tick_us: TICK_US as u32, ..Config::default() });
    board.advance_counters(entries, ns);
    board.record_beam(true);
    let begin = board.now();
    assert!(begin >= ns);
    let board = share(board);
    let client = work::client(&board);
    run(&client, SETUP);
    let mut done = Done { set_points: Vec::new(), on_time: [0; 2], edges: Vec::new(), beam: Vec::new() };
    let mut look = || {
        let mut board = board.lock().unwrap();
        done.set_points.push(std::array::from_fn(|axis| board.set_point(axis)));
        done.on_time = std::array::from_fn(|channel| board.laser_view(channel).on_time);
        let edges = board.take_edges().into_iter();
        done.edges.extend(edges.map(|edge| Edge { at_ns: edge.at_ns - begin, ..edge }));
        let beam = board.take_beam().into_iter();
        done.beam.extend(beam.map(|beam| (beam.channel, since(beam.change, begin))));
    };
    look();
    run(&client, &round(0));
    look();
    for _ in 0..100 {
        client.sleep(Duration::from_micros(ROUND_TICKS / 100 * TICK_US)).unwrap();
        look();
    }
    assert!(done.beam.len() > 1000 && done.on_time[0] > 0 && done.on_time[1] > 0);
    done
}

#[test]
fn counters_wrap_and_nothing_changes() {
    // Not at the very first: a link that has never been silent answers a little later.
    let new = life(0, 1_000_000_000);
    // Some entries before 2³¹ of a lane and before 2³² of what else is counted; some ms before 2³²
    // ns, 2⁵² ns (2³² of the watchdog's units), 2⁵³ ns (what a double holds) and 2⁶³ ns (a sign).
    let before = |bits: u32| (1u64 << bits) - 30_000_000;
    for (entries, ns) in [(u32::MAX - 40, before(32)), (u32::MAX - 200, before(52)), (7, before(53)), (9, before(63))] {
        let old = life(entries, ns);
        let differ = new.set_points.iter().zip(&old.set_points).position(|(new, old)| new != old);
        assert_eq!(differ, None, "set-points after {entries} entries and {ns} ns");
        assert_eq!((new.on_time, &new.edges), (old.on_time, &old.edges), "after {entries} entries and {ns} ns");
        let differ = new.beam.iter().zip(&old.beam).position(|(new, old)| new != old);
        assert_eq!((differ, new.beam.len()), (None, old.beam.len()), "light after {entries} entries and {ns} ns");
    }
}

/// A path that has carried out so many entries since it was cleared, in both FIFOs, the second with
/// a look-ahead; its laser was on for as many units.
fn path_of(entries: u32) -> (Done, u32) {
    let board = share(Board::new(Config { tick_us: TICK_US as u32, ..Config::default() }));
    let client = work::client(&board);
    run(
        &client,
        "GT_LoadConfig(\"none.toml\"); GT_ClrSts(1, 8); GT_AxisOn(5); GT_AxisOn(6);
         TCrdPrm crd = {2, {0,0,0,0,0,0,0,0}, 10, 1, 0, 0, {0,0,0,0,0,0,0,0}}; crd.profile[4] = 1; crd.profile[5] = 2; crd.synVelMax = 100; crd.synAccMax = 10;
         crd.setOriginFlag = 1; GT_SetCrdPrm(1, &crd); GT_InitLookAhead(1, 1, 1, 10, 40);
         GT_SetLaserCrdMap(0, 1); GT_SetAxisMode(7, 1); GT_LaserPowerMode(0, 90, 1, 0); GT_LaserOutFrq(50, 0);",
    );
    client.sleep(Duration::from_millis(5)).unwrap();
    let begin = {
        let mut board = board.lock().unwrap();
        board.advance_fifo_counters(entries);
        board.record_beam(true);
        board.now()
    };
    let space = |fifo| {
        let space = client.call(CrdSpace { core: 1.into(), crd: 1.into(), fifo }).unwrap();
        (
            space.value.get(),
            client.call(GetRemainderSegNum { core: 1.into(), crd: 1.into(), fifo }).unwrap().value.get(),
        )
    };
    let mut done = Done { set_points: Vec::new(), on_time: [0; 2], edges: Vec::new(), beam: Vec::new() };
    let mut segments = 0;
    for fifo in [0, 1] {
        for part in 0..2 {
            assert_eq!(space(fifo.into()), (1024, 0), "after {entries} entries, FIFO {fifo}, part {part}");
            let mut text = format!("GT_BufLaserFollowRatio(1, 20, 1, 90, {fifo}, 0);\n");
            for side in 0..40 {
                text += &format!(
                    "GT_BufLaserOn(1, {fifo}, 0); GT_LnXY(1, {}, {}, 5, 1, 0.5, {fifo});\n",
                    side % 3 * 9 + 4,
                    side % 2 * 7
                );
                text += &format!("GT_BufIO(1, 12, 1, {}, {fifo}); GT_BufLaserOff(1, {fifo}, 0);\n", side % 2);
                if side % 7 == 0 {
                    text += &format!("GT_BufDelay(1, 3, {fifo});\n");
                }
            }
            run(&client, &(text + &format!("GT_LnXY(1, 0, 0, 5, 1, 0, {fifo}); GT_CrdData(1, NULL, {fifo});\n")));
            // A ratio, four entries a side, six delays, the last line.
            let waits = (1024 - (1 + 4 * 40 + 6 + 1), 41);
            assert_eq!(space(fifo.into()), waits, "after {entries} entries, FIFO {fifo}, part {part}");
            run(&client, &format!("GT_CrdStart(1, {fifo});"));
            // Left on its way, and gone on with.
            client.sleep(Duration::from_millis(30)).unwrap();
            run(&client, &format!("GT_Stop(256, 0); WaitStop(256); GT_CrdStart(1, {fifo});"));
            while board.lock().unwrap().crd(0).runs {
                client.sleep(Duration::from_micros(3 * TICK_US)).unwrap();
                let board = board.lock().unwrap();
                done.set_points.push(std::array::from_fn(|axis| board.set_point(axis)));
            }
            segments += 41;
        }
        let status = client.call(CrdStatus { core: 1.into(), crd: 1.into(), fifo: fifo.into() }).unwrap();
        let counted = i32::try_from(entries.wrapping_add(segments)).unwrap_or(i32::MAX);
        assert_eq!(status.segment.get(), counted, "{entries} motions and {segments} more");
        segments = 0;
    }
    let mut board = board.lock().unwrap();
    let on_time = board.laser_view(0).on_time;
    let edges = board.take_edges().into_iter().filter(|edge| edge.at_ns >= begin);
    done.edges.extend(edges.map(|edge| Edge { at_ns: edge.at_ns - begin, ..edge }));
    done.beam.extend(board.take_beam().into_iter().map(|beam| (beam.channel, since(beam.change, begin))));
    assert!(done.edges.len() > 100 && done.beam.len() > 1000);
    (done, on_time)
}

#[test]
fn counts_of_a_path_and_of_light_wrap_and_nothing_changes() {
    let (new, light) = path_of(0);
    assert!(light > 100, "{light} units of light");
    // Some 180 entries go through a FIFO: it is left and gone on with before and after the place
    // where its count wraps.
    for before in [u32::MAX - 20, u32::MAX - 120, u32::MAX / 2 - 60] {
        let (old, on_time) = path_of(before);
        assert_eq!(on_time, before.wrapping_add(light), "on-time after {before}");
        let differ = new.set_points.iter().zip(&old.set_points).position(|(new, old)| new != old);
        assert_eq!((differ, new.set_points.len()), (None, old.set_points.len()), "set-points after {before}");
        assert_eq!(new.edges, old.edges, "after {before}");
        let differ = new.beam.iter().zip(&old.beam).position(|(new, old)| new != old);
        assert_eq!((differ, new.beam.len()), (None, old.beam.len()), "light after {before}");
    }
}

/// The place of an entry in its lane is compared over half of what is counted. A Jog that began a
/// long time ago, a place given then, a table named then, must not look as if they were still to
/// come.
#[test]
fn what_was_executed_long_ago_does_not_come_back() {
    let board = share(Board::new(Config { tick_us: TICK_US as u32, ..Config::default() }));
    let client = work::client(&board);
    run(
        &client,
        "GT_LoadConfig(\"none.toml\"); GT_ClrSts(1, 8); GT_AxisOn(1); GT_AxisOn(2); GT_AxisOn(3); GT_AxisOn(4);
         TJogPrm jog; GT_PrfJog(3); jog.smooth = 0; jog.acc = 1; jog.dec = 1; GT_SetJogPrm(3, &jog); GT_SetVel(3, 0.5); GT_Update(4);
         double t[2] = {0, 10}; double p[2] = {0, 5}; double v[2] = {0, 0}; GT_PrfPvt(4); GT_PvtTable(1, 2, t, p, v);
         GT_PvtTableSelect(4, 1); GT_PvtStart(8); WaitStop(8);
         GT_SetPrfPos(1, 100); TTrapPrm trap; GT_PrfTrap(1); trap.velStart = 0; trap.acc = 1; trap.dec = 1; trap.smoothTime = 0;
         GT_SetTrapPrm(1, &trap); GT_SetVel(1, 5); GT_SetPos(1, 300); GT_Update(1); WaitStop(1);",
    );
    // 1.5 times 2³⁰ entries.
    for _ in 0..192 {
        board.lock().unwrap().advance_counters(1 << 23, 0);
    }
    run(
        &client,
        "GT_Stop(4, 0); WaitStop(4); GT_PrfTrap(3);
         double t[2] = {0, 20}; double p[2] = {0, 7}; double v[2] = {0, 0}; GT_PvtTable(1, 2, t, p, v); GT_PvtStart(8); WaitStop(8);
         TCrdPrm crd = {1, {0,0,0,0,0,0,0,0}, 10, 1, 0, 0, {0,0,0,0,0,0,0,0}}; crd.setOriginFlag = 1; crd.profile[0] = 1; crd.synVelMax = 100; crd.synAccMax = 10;
         GT_SetCrdPrm(1, &crd); GT_CrdClear(1, 0); GT_LnXY(1, 310, 0, 1, 1, 0, 0); GT_CrdStart(1, 0); WaitStop(256);",
    );
    let pulses = |axis: usize| board.lock().unwrap().set_point(axis) as f64 / f64::from(1 << 22);
    // SetPrfPos has named the place 100 at which the drive is at 0.
    assert_eq!((pulses(0), pulses(3)), (210.0, 12.0));
}
