//! Programs that differed once, as short as they could be made: what was wrong is said at each.
use super::judge::{Tally, finding};
use host_tests::path_model::Plane;
use host_tests::reference::{
    Call, Cycle, Datum, Effect, Family, Item, Kind, LightCall, LightOf, Path, PathCall, Setup, Speeds,
};

pub const MS: i64 = 1_000_000;

pub fn gus() -> Setup {
    Setup { profile: "gus", family: Family::Gus, axes: vec![(1, 1), (1, 2), (1, 3), (1, 6)] }
}

pub fn plain(kind: Kind, axis: usize) -> Call {
    Call::Axis { kind, axis }
}

pub fn ex(of: Call) -> Call {
    Call::Ex(Box::new(of))
}

pub fn segment(axis: usize, master: f64, slave: f64, kind: i16, percent: i16) -> Call {
    let datum = Datum { master, slave, kind, percent };
    Call::FollowEntry { axis, item: Item::Segment(datum), fifo: 0 }
}

pub fn agrees(tick_us: u32, calls: &[Call]) {
    let mut tally = Tally::new();
    if let Some(report) = finding(&mut None, &gus(), tick_us, calls, &mut tally) {
        panic!("{report}");
    }
    let open: Vec<&String> = tally.keys().filter(|what| what.starts_with("cut short")).collect();
    assert!(open.is_empty(), "{open:?}");
    assert_eq!(tally.get("programs"), Some(&1), "not compared: {:?}", tally.keys());
}

/// The program differs in nothing up to what the contract leaves open, which is this.
pub fn is_open(tick_us: u32, calls: &[Call], why: &str) {
    let mut tally = Tally::new();
    if let Some(report) = finding(&mut None, &gus(), tick_us, calls, &mut tally) {
        panic!("{report}");
    }
    let why = format!("cut short: {why}");
    assert!(tally.contains_key(&why), "{:?}", tally.keys());
}

/// A slave of a slave jumped to a turning point far ahead where a delay of the one in the middle
/// ended: the way inside the tick was taken from a progress of before the wait.
#[test]
fn a_slave_of_a_slave_that_a_delay_held() {
    agrees(
        1000,
        &[
            plain(Kind::AxisOn, 0),
            plain(Kind::AxisOn, 1),
            plain(Kind::AxisOn, 3),
            ex(Call::PrfFollow { axis: 3, dir: 1 }),
            ex(Call::SetFollowMaster { axis: 3, master: 0, kind: 2, item: 0 }),
            segment(3, 456.0, 456.0, 0, 100),
            ex(Call::FollowStart { mask: 8, option: 0 }),
            ex(Call::PrfFollow { axis: 0, dir: 1 }),
            ex(Call::SetFollowMaster { axis: 0, master: 1, kind: 2, item: 0 }),
            segment(0, 28.25, 42.375, 1, 20),
            Call::FollowEntry { axis: 0, item: Item::Delay { cycles: 4 }, fifo: 0 },
            segment(0, 393.5, 149.0, 0, 0),
            ex(Call::FollowStart { mask: 1, option: 0 }),
            plain(Kind::PrfJog, 1),
            Call::SetJogPrm { axis: 1, acc: 5.4, dec: 0.9 },
            Call::SetVel { axis: 1, vel: -12.625 },
            Call::Update { mask: 2 },
            Call::Sleep { ns: 21 * MS - 85_870 },
            Call::FollowSwitchNow { axis: 0, table: false },
            Call::Sleep { ns: 10 * MS },
        ],
    );
}

pub fn path(what: Path) -> Call {
    Call::Path(PathCall { core: 1, what })
}

pub fn line(to: Vec<i32>) -> Call {
    path(Path::Line { crd: 1, to, speeds: Speeds { vel: 9.7, acc: 2.3, end: 0.0 }, fifo: 0 })
}

pub fn arc(to: [i32; 2], fifo: i16) -> Call {
    let (plane, round) = (Plane::XY, Cycle::Radius(90.0));
    path(Path::Arc { crd: 1, plane, to, round, ccw: true, speeds: Speeds { vel: 9.7, acc: 2.3, end: 0.0 }, fifo })
}

pub fn frame(origin: Option<Vec<i32>>) -> Call {
    path(Path::Set { crd: 1, axes: vec![0, 1], vel: 50.0, acc: 4.9, even_ms: 0, origin })
}

/// A slave of direction 0 at its origin, whose master goes back, was reported to move with it. A
/// Stop at the instant of a SwitchNow then moved it.
#[test]
fn a_slave_at_its_origin_does_not_go_back() {
    for tick_us in [1000, 250, 100] {
        for table in [false, true] {
            agrees(
                tick_us,
                &[
                    plain(Kind::AxisOn, 0),
                    plain(Kind::AxisOn, 1),
                    ex(Call::PrfFollow { axis: 0, dir: 0 }),
                    ex(Call::SetFollowMaster { axis: 0, master: 1, kind: 2, item: 0 }),
                    segment(0, 27.0, 2.430950912022053, 1, 20),
                    ex(Call::FollowStart { mask: 1, option: 0 }),
                    plain(Kind::PrfJog, 1),
                    Call::SetJogPrm { axis: 1, acc: 1.15, dec: 0.614757348727274 },
                    Call::SetVel { axis: 1, vel: -15.625 },
                    Call::Update { mask: 2 },
                    Call::Sleep { ns: 3 * MS + MS / 4 },
                    Call::FollowSwitchNow { axis: 0, table },
                    Call::Stop { mask: 1, abrupt: 0 },
                    Call::Sleep { ns: 5 * MS },
                ],
            );
        }
    }
}

/// A CrdClear or a SetCrdPrm after the Stop of the path forgot the move that its entries had begun.
#[test]
fn a_move_outlives_the_entries_that_began_it() {
    let ready = [plain(Kind::AxisOn, 0), plain(Kind::AxisOn, 1), plain(Kind::AxisOn, 3)];
    let send = path(Path::Move { crd: 1, axis: 3, to: 299, vel: 5.8, acc: 1.4, modal: 1, fifo: 0 });
    let go = path(Path::Start { mask: 1, option: 0 });
    for renewed in [frame(None), path(Path::Clear { crd: 1, fifo: 0 })] {
        let set_up = [frame(None), line(vec![30, 20]), send.clone(), go.clone(), Call::Sleep { ns: 16 * MS }];
        let stop = [Call::Stop { mask: 1, abrupt: 0 }, path(Path::Wait { mask: 1 })];
        let calls =
            [&ready[..], &set_up, &stop, &[renewed, plain(Kind::PrfJog, 3), plain(Kind::GetPrfMode, 3)]].concat();
        for tick_us in [250, 100, 1000] {
            agrees(tick_us, &calls);
        }
    }
}

/// Data after a start, in the tick in which another mode was set before it: refused, as if the data
/// of the mode before could still be read.
#[test]
fn data_after_a_start_right_after_another_mode() {
    let datum = Datum { master: 724.0, slave: -164.0, kind: 3, percent: 0 };
    agrees(
        1000,
        &[
            plain(Kind::AxisOn, 3),
            Call::PrfFollow { axis: 3, dir: 1 },
            Call::FollowData { axis: 3, datum, fifo: 0 },
            ex(Call::PrfFollow { axis: 3, dir: 0 }),
            ex(Call::SetFollowMaster { axis: 3, master: 2, kind: 2, item: 0 }),
            segment(3, 497.9, 189.9, 2, 0),
            ex(Call::FollowStart { mask: 8, option: 0 }),
            segment(3, 671.9, 237.7, 0, 50),
            Call::Sleep { ns: 4 * MS },
        ],
    );
}

/// A smooth Stop in the tick in which a pass had ended left that pass uncounted.
#[test]
fn a_pass_that_ended_just_before_a_stop_counts() {
    for (tick_us, ns) in [(250, 9 * MS), (250, 27 * MS - 100_000), (400, 8 * MS), (400, 9 * MS), (400, 18 * MS)] {
        agrees(
            tick_us,
            &[
                plain(Kind::AxisOn, 1),
                Call::PrfPt { axis: 1, mode: 0 },
                Call::PtData { axis: 1, pos: 32.5, time_ms: 9, kind: 0, fifo: 0 },
                Call::SetPtLoop { axis: 1, loops: 0 },
                Call::PtStart { mask: 2, option: 0 },
                Call::Sleep { ns },
                Call::Stop { mask: 2, abrupt: 0 },
                Call::Sleep { ns: 80 * MS },
                plain(Kind::GetPtLoop, 1),
            ],
        );
    }
}

/// A master braked within one tick, and a delay of its slave ended in that tick: the master's way
/// inside the tick was taken as straight, and the slave was 0.2 pulses off for good.
#[test]
fn a_delay_ends_in_the_tick_in_which_the_master_brakes() {
    for dec in [1.0, 1.7, 4.0] {
        agrees(
            1000,
            &[
                plain(Kind::AxisOn, 0),
                plain(Kind::AxisOn, 3),
                Call::SetStopDec { axis: 0, smooth: dec },
                ex(Call::PrfFollow { axis: 3, dir: -1 }),
                ex(Call::SetFollowMaster { axis: 3, master: 0, kind: 2, item: 0 }),
                segment(3, -14.511298783492112, 13.484034347115529, 0, 20),
                Call::FollowEntry { axis: 3, item: Item::Delay { cycles: 40 }, fifo: 0 },
                segment(3, -399.5112987834921, 109.73403434711553, 0, 100),
                ex(Call::FollowStart { mask: 8, option: 0 }),
                plain(Kind::PrfJog, 0),
                Call::SetJogPrm { axis: 0, acc: 3.4, dec: 8.4 },
                Call::SetVel { axis: 0, vel: -1.0 },
                Call::Update { mask: 1 },
                Call::Sleep { ns: 24 * MS + 105_598 },
                Call::Stop { mask: 1, abrupt: 0 },
                Call::Sleep { ns: 6 * MS },
            ],
        );
    }
}

/// Data of a dynamic FIFO that came while its axis braked for a Stop belongs to the next stream. A
/// start after a wait for the Stop was refused: the FIFO was taken for that of the stream that the
/// Stop had ended.
#[test]
fn dynamic_data_while_the_axis_brakes() {
    let data = |pos, time_ms| Call::PtData { axis: 0, pos, time_ms, kind: 0, fifo: 0 };
    let go = Call::PtStart { mask: 1, option: 0 };
    for stop in [Call::Stop { mask: 1, abrupt: 0 }, Call::Abort { core: 1 }] {
        for pause in [0, 2 * MS + 1] {
            agrees(
                1000,
                &[
                    plain(Kind::AxisOn, 0),
                    Call::PrfPt { axis: 0, mode: 1 },
                    data(-113.0, 20),
                    go.clone(),
                    Call::Sleep { ns: 7 * MS - 1 },
                    stop.clone(),
                    Call::Sleep { ns: pause },
                    data(-77.875, 48),
                    Call::WaitStop { mask: 1 },
                    go.clone(),
                    Call::Sleep { ns: 60 * MS },
                ],
            );
        }
    }
}

/// Data after a start of Follow was refused, where two modes had been set at the same instant: only
/// the first of them had emptied the FIFO.
#[test]
fn follow_data_after_a_start_right_after_two_modes() {
    agrees(
        100,
        &[
            plain(Kind::AxisOn, 0),
            ex(Call::PrfFollow { axis: 0, dir: -1 }),
            segment(0, 190.0, 72.625, 0, 0),
            plain(Kind::PrfTrap, 0),
            ex(Call::PrfFollow { axis: 0, dir: 1 }),
            ex(Call::SetFollowMaster { axis: 0, master: 3, kind: 2, item: 0 }),
            segment(0, 569.0, 183.75, 0, 0),
            ex(Call::FollowStart { mask: 1, option: 0 }),
            segment(0, 667.0, 281.75, 2, 0),
            Call::Sleep { ns: 20 * MS },
        ],
    );
}

/// A master came to a knot in a tick, and a Stop or an Update acted at its end. Its slave took the
/// way between for a straight line: a delay began and ended at other instants than it should.
#[test]
fn a_delay_after_a_master_that_is_planned_again() {
    let slave = |dir, to: [f64; 4], cycles, kinds: [i16; 2]| {
        vec![
            plain(Kind::AxisOn, 0),
            plain(Kind::AxisOn, 1),
            ex(Call::PrfFollow { axis: 0, dir }),
            ex(Call::SetFollowMaster { axis: 0, master: 1, kind: 2, item: 0 }),
            segment(0, to[0], to[1], kinds[0], 80),
            Call::FollowEntry { axis: 0, item: Item::Delay { cycles }, fifo: 0 },
            segment(0, to[2], to[3], kinds[1], 76),
            ex(Call::FollowStart { mask: 1, option: 0 }),
        ]
    };
    // The knot between both ramps of the Trap, and a Stop.
    let mut calls = slave(1, [31.0, 45.5, 42.0, 2.375], 16, [1, 3]);
    calls.extend([
        Call::SetTrapPrm { axis: 1, acc: 4.722576198740511, dec: 1.4467987464859593 },
        Call::SetVel { axis: 1, vel: 34.245935942319484 },
        Call::SetPos { axis: 1, pos: 91 },
        Call::Update { mask: 2 },
        Call::Sleep { ns: 4_086_316 },
        Call::Stop { mask: 2, abrupt: 0 },
        Call::Sleep { ns: 8 * MS },
    ]);
    agrees(1000, &calls);
    // The begin of a Stop, and an Update a tick later.
    let mut calls = slave(0, [18.5, -191.0, 70.75, -58.875], 45, [3, 1]);
    calls.extend([
        plain(Kind::PrfJog, 1),
        Call::SetJogPrm { axis: 1, acc: 3.190314471298791, dec: 1.4039514423972281 },
        Call::SetVel { axis: 1, vel: 22.109962318821207 },
        Call::Update { mask: 2 },
        Call::Sleep { ns: 14_854_947 },
        Call::Stop { mask: 2, abrupt: 0 },
        Call::Sleep { ns: 554_978 },
        Call::Update { mask: 2 },
        Call::Sleep { ns: 5 * MS },
    ]);
    agrees(1000, &calls);
}

/// A Stop of a coordinate system that did not run made a map that followed wait for its instant,
/// and the light of this instant was late by a tick.
#[test]
fn light_after_a_map_after_a_stop_at_standstill() {
    let light = |what| Call::Light(LightCall { channel: 0, what });
    let off = [frame(None), plain(Kind::AxisOff, 1), light(LightOf::Map(3)), plain(Kind::AxisOn, 1)];
    agrees(250, &off);
    for waits in [false, true] {
        let mut calls = vec![plain(Kind::AxisOn, 0), plain(Kind::AxisOn, 1), frame(None)];
        if waits {
            calls.extend([line(vec![9, 4]), path(Path::Start { mask: 1, option: 0 })]);
            calls.extend([path(Path::Wait { mask: 1 }), Call::Sleep { ns: 9 * MS }]);
        }
        calls.extend([Call::Stop { mask: 1, abrupt: 1 }, Call::Sleep { ns: 1_455_142 }, plain(Kind::ZeroPos, 0)]);
        calls.extend([light(LightOf::Connector(true)), light(LightOf::Map(1)), light(LightOf::Gate(true))]);
        calls.push(Call::Sleep { ns: 2 * MS });
        agrees(250, &calls);
    }
}

/// An Abort and a Stop of one instant: a slave that had not braked yet reported the Stop.
#[test]
fn a_slave_that_two_stops_meet() {
    let stop = Call::Stop { mask: 3, abrupt: 0 };
    for (first, second) in [(Call::Abort { core: 1 }, stop.clone()), (stop, Call::Abort { core: 1 })] {
        let mut calls = vec![plain(Kind::AxisOn, 0), plain(Kind::AxisOn, 1)];
        calls.extend([plain(Kind::PrfJog, 0), Call::SetJogPrm { axis: 0, acc: 1.0, dec: 1.0 }]);
        calls.extend([Call::SetVel { axis: 0, vel: 5.3 }, ex(Call::PrfFollow { axis: 1, dir: 0 })]);
        calls.extend([ex(Call::SetFollowMaster { axis: 1, master: 0, kind: 2, item: 0 })]);
        calls.extend([segment(1, 900.0, 900.0, 0, 0), ex(Call::FollowStart { mask: 2, option: 0 })]);
        calls.extend([Call::Update { mask: 1 }, Call::Sleep { ns: 9 * MS }, first, second]);
        calls.extend([Call::WaitStop { mask: 3 }, plain(Kind::GetStopReason, 0), plain(Kind::GetStopReason, 1)]);
        agrees(250, &calls);
    }
}

/// A start of another axis before a second WaitStop of an instant hid that it takes no time: data
/// after it was a tick late, and its stream had ended.
#[test]
fn data_after_two_waits_and_a_start_of_another_axis() {
    let setup = Setup { profile: "gtn-016", family: Family::Gus, axes: vec![(1, 1), (1, 2), (2, 1), (2, 7)] };
    let datum = Datum { master: 183.0, slave: -118.45857060472144, kind: 0, percent: 0 };
    let data = |pos, time_ms, kind| Call::PtData { axis: 2, pos, time_ms, kind, fifo: 0 };
    // The last tick of the stream is among these.
    for step in 0..5 {
        let last = 14 * MS + 395_867 + (step - 2) * 250_000;
        let calls = [
            plain(Kind::AxisOn, 0),
            plain(Kind::AxisOn, 2),
            ex(Call::PrfFollow { axis: 0, dir: -1 }),
            ex(Call::SetFollowMaster { axis: 0, master: 2, kind: 2, item: 0 }),
            segment(0, -421.58699932109295, 115.81161600107747, 0, 0),
            ex(Call::FollowStart { mask: 1, option: 0 }),
            Call::PrfPt { axis: 2, mode: 1 },
            data(1.7397275901784104, 5, 0),
            Call::PtStart { mask: 4, option: 0 },
            Call::Sleep { ns: 3 * MS },
            data(-31.426520313375583, 16, 0),
            Call::Sleep { ns: 4 * MS },
            data(85.03675836934804, 32, 2),
            Call::Sleep { ns: 9 * MS + 703_752 + last },
            Call::Stop { mask: 1, abrupt: 0 },
            Call::WaitStop { mask: 1 },
            Call::PrfFollow { axis: 0, dir: -1 },
            Call::SetFollowMaster { axis: 0, master: 2, kind: 3, item: 2 },
            Call::FollowData { axis: 0, datum, fifo: 0 },
            Call::FollowStart { mask: 1, option: 0 },
            Call::WaitStop { mask: 8 },
            data(83.0, 33, 2),
            Call::Sleep { ns: 3 * MS },
        ];
        let report = finding(&mut None, &setup, 250, &calls, &mut Tally::new());
        assert!(report.is_none(), "{report:?}");
    }
}

/// A segment between a delay and an entry that switches, passed within one tick: what follows
/// started at ratio 0, as if the delay came directly before it, and the slave kept lagging.
#[test]
fn a_switch_after_a_delay_and_a_segment_within_a_tick() {
    let datum = |master: f64, slave: f64, kind: i16| Item::Segment(Datum { master, slave, kind, percent: 0 });
    for (between, first) in
        [1, 2].into_iter().flat_map(|between| [(between, 401.0), (between, 416.0), (between, 431.0)])
    {
        let mut calls = vec![plain(Kind::AxisOn, 0), plain(Kind::AxisOn, 1)];
        calls.push(ex(Call::PrfFollow { axis: 0, dir: 1 }));
        calls.push(ex(Call::SetFollowMaster { axis: 0, master: 1, kind: 2, item: 0 }));
        let mut entries = vec![(datum(first, -490.0, 0), 0), (Item::Delay { cycles: 1 }, 0)];
        entries.push((datum(first + 9.0, -484.0, 1), 0));
        if between == 2 {
            entries.push((Item::Output { index: 3, level: true }, 0));
        }
        entries.extend([(Item::Switch { table: true }, 0), (datum(1400.0, 900.0, 0), 1)]);
        calls.extend(entries.into_iter().map(|(item, fifo)| Call::FollowEntry { axis: 0, item, fifo }));
        calls.extend([ex(Call::FollowStart { mask: 1, option: 0 }), plain(Kind::PrfJog, 1)]);
        calls.extend([Call::SetJogPrm { axis: 1, acc: 2.0, dec: 0.6 }, Call::SetVel { axis: 1, vel: 128.5 }]);
        calls.extend([Call::Update { mask: 2 }, Call::Sleep { ns: 30 * MS }]);
        for tick_us in [250, 1000] {
            agrees(tick_us, &calls);
        }
    }
}

/// What follows a wait or a delay directly begins at the very instant of its end, be that a tick or
/// not. While its master moved, the next delay or time limit began a hair later, and ended a tick
/// later.
#[test]
fn delays_and_waits_follow_one_another_without_a_gap() {
    let wait = |index, ms| Call::FollowEntry { axis: 2, item: Item::Wait { index, level: true, ms }, fifo: 0 };
    let delay = |cycles| Call::FollowEntry { axis: 2, item: Item::Delay { cycles }, fifo: 0 };
    let high = |index| Call::Effect(Effect::SimInput { core: 1, index, level: true });
    for vel in [-80.5, 0.7] {
        for entries in [[wait(4, 60), wait(6, 20)], [wait(4, 60), delay(6)], [delay(3), delay(5)], [delay(1), delay(7)]]
        {
            let mut calls = vec![
                plain(Kind::AxisOn, 1),
                plain(Kind::AxisOn, 2),
                ex(Call::PrfFollow { axis: 2, dir: if vel < 0.0 { -1 } else { 1 } }),
                ex(Call::SetFollowMaster { axis: 2, master: 1, kind: 2, item: 0 }),
            ];
            calls.extend(entries);
            calls.extend([
                segment(2, if vel < 0.0 { -900.0 } else { 900.0 }, 300.0, 1, 0),
                ex(Call::FollowStart { mask: 4, option: 0 }),
                plain(Kind::PrfJog, 1),
                Call::SetJogPrm { axis: 1, acc: 1.025, dec: 5.4 },
                Call::SetVel { axis: 1, vel },
                Call::Update { mask: 2 },
                Call::Sleep { ns: MS + 391_282 },
                high(4),
                Call::Sleep { ns: 30 * MS },
            ]);
            for tick_us in [250, 500, 1000] {
                agrees(tick_us, &calls);
            }
        }
    }
}
