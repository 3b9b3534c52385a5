//! Counters that go round: a controller whose counters are about to do so does what a new one does, and what was
//! executed long ago stays executed.
#[path = "life/work.rs"]
mod work;

use plant::beam::Change;
use plant::pulses::Burst;
use std::time::Duration;
use virtual_board::{Board, Config, Edge, share};
use work::{ROUND_TICKS, SETUP, TICK_US, round, run};

/// What a controller has done by the end of a round.
#[derive(Debug, Clone, PartialEq)]
struct Done {
    set_points: Vec<[i64; 8]>,
    on_time: [u32; 2],
    edges: Vec<Edge>,
    beam: Vec<(u8, Change)>,
}

/// The change with its instant counted from `begin`.
fn since(change: Change, begin: u64) -> Change {
    match change {
        Change::Switch { at, level } => Change::Switch { at: at - begin, level },
        Change::Energy { at, level } => Change::Energy { at: at - begin, level },
        Change::Pulses(burst) => Change::Pulses(Burst { at: burst.at - begin, ..burst }),
        Change::Dac { at, code } => Change::Dac { at: at - begin, code },
    }
}

/// A round of a controller that has executed so many entries and so many ns before.
fn life(entries: u32, ns: u64) -> Done {
    let mut board = Board::new(Config { tick_us: TICK_US as u32, profile: 0 });
    board.age(entries, ns);
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
fn counters_go_round_and_nothing_is_different() {
    // Not at the very first: a link that has never been silent answers a little later.
    let new = life(0, 1_000_000_000);
    // Some entries before 2³¹ of a lane and before 2³² of what else is counted; some ms before 2³² ns, 2⁵² ns (2³² of the
    // watchdog's units), 2⁵³ ns (what a double holds) and 2⁶³ ns (a sign).
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

/// The place of an entry in its lane is compared over half of what is counted. A Jog that began a long time ago, a place
/// given then, a table named then, must not look as if they were still to come.
#[test]
fn what_was_executed_long_ago_does_not_come_back() {
    let board = share(Board::new(Config { tick_us: TICK_US as u32, profile: 0 }));
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
        board.lock().unwrap().age(1 << 23, 0);
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
