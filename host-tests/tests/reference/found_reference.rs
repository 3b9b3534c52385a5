//! Programs on which the reference or the judge was wrong, and the controller was right.
use super::found::{MS, agrees, ex, frame, is_open, line, path, plain, segment};
use host_tests::path_model::Plane;
use host_tests::reference::{
    Call, Command, Cycle, Datum, Effect, Item, Kind, LightCall, LightOf, LightTable, Path, Points, Speeds,
};

/// A slave that has come back through its passes rests at its origin. A SwitchNow by segment began
/// its first segment; the reference had its last one after it, and jumped to its end.
#[test]
fn a_switch_now_before_the_first_pass() {
    for back in [1993, 300] {
        agrees(
            250,
            &[
                plain(Kind::AxisOn, 0),
                plain(Kind::AxisOn, 1),
                Call::SetTrapPrm { axis: 1, acc: 0.5, dec: 3.4 },
                Call::SetVel { axis: 1, vel: 40.3 },
                ex(Call::PrfFollow { axis: 0, dir: 0 }),
                ex(Call::SetFollowMaster { axis: 0, master: 1, kind: 2, item: 0 }),
                segment(0, -138.0, 29.03125, 1, 100),
                ex(Call::SetFollowLoop { axis: 0, loops: 0 }),
                ex(Call::FollowStart { mask: 1, option: 0 }),
                Call::SetPos { axis: 1, pos: -301 },
                Call::Update { mask: 2 },
                Call::WaitStop { mask: 2 },
                Call::Sleep { ns: MS },
                Call::SetPos { axis: 1, pos: back },
                Call::Update { mask: 2 },
                Call::Sleep { ns: 43 * MS + 456_723 },
                Call::FollowSwitchNow { axis: 0, table: false },
                Call::Sleep { ns: 70 * MS },
                Call::SetPos { axis: 1, pos: -77 },
                Call::Update { mask: 2 },
                Call::Sleep { ns: 90 * MS },
            ],
        );
    }
}

/// Where no program follows a SetTick, its answer is there before the tick on which it acts.
#[test]
fn tick_periods_one_after_the_other() {
    for periods in [&[500][..], &[7], &[1000, 500], &[1000, 500, 100]] {
        let mut calls = vec![plain(Kind::AxisOn, 0)];
        calls.extend(periods.iter().map(|us| Call::SetTick { us: *us }));
        agrees(250, &calls);
        agrees(250, &calls[1..]);
    }
    // Neither acts in motion.
    let jog = Call::SetJogPrm { axis: 0, acc: 0.9, dec: 0.9 };
    let go = [Call::SetVel { axis: 0, vel: -125.5 }, Call::Update { mask: 1 }];
    let mut calls = vec![plain(Kind::AxisOn, 0), plain(Kind::PrfJog, 0), jog];
    calls.extend(go.into_iter().chain([250, 1000].map(|us| Call::SetTick { us })));
    agrees(1000, &calls);
}

/// A smooth Stop finds a path in a BufDelay at standstill: it rests there and then. An abrupt one
/// of the same instant finds it at rest, and does not take it back to where the tick before had
/// shown it.
#[test]
fn a_smooth_stop_in_a_delay_before_an_abrupt_one() {
    let delay = |ms| path(Path::Delay { crd: 1, ms, fifo: 0 });
    let begin = [plain(Kind::AxisOn, 0), plain(Kind::AxisOn, 1), frame(None), line(vec![9, 4])];
    let go = path(Path::Start { mask: 1, option: 0 });
    // From 0.25 ms on 9.849 pulses at 2.3 pulse/ms²: in the delay at 4.389 ms.
    for ns in [4 * MS + 200_000, 4 * MS + 300_000, 5 * MS] {
        let mut calls = begin.to_vec();
        calls.extend([delay(3), line(vec![30, -10]), go.clone(), Call::Sleep { ns }]);
        calls.extend([Call::Stop { mask: 1, abrupt: 0 }, Call::Stop { mask: 2, abrupt: 2 }]);
        calls.extend([Call::Sleep { ns: 5 * MS }, go.clone(), Call::Sleep { ns: 12 * MS }]);
        agrees(250, &calls);
    }
}

/// After an Abort in GUS mode 3 the switch stays off until a command of the channel. Points of a
/// follow table are none, and the reference took them for one.
#[test]
fn a_follow_table_after_an_abort_lights_nothing() {
    let mode = LightOf::Mode { mode: 3, max: 100.0, min: 0.0, delayed: true };
    let points = vec![[0.0, 80.0], [7.0, 57.4]];
    agrees(
        1000,
        &[
            Call::Light(LightCall { channel: 1, what: mode }),
            Call::Abort { core: 1 },
            Call::Sleep { ns: 13 * MS },
            Call::LightTable(LightTable::Powers { channel: 1, table: 1, points }),
            Call::Sleep { ns: 3 * MS },
        ],
    );
}

/// An interlock brings a path to standstill at once. The reference did not tell the lasers, took
/// the path's entries after an Abort for those of before it, and left them dark.
#[test]
fn light_of_a_path_that_an_interlock_has_stopped() {
    let light = |what| Call::Light(LightCall { channel: 0, what });
    let lights = path(Path::Laser { crd: 1, channel: 0, command: Command::Gate(true), fifo: 0 });
    let go = path(Path::Start { mask: 1, option: 0 });
    let interlock = |open| Call::Effect(Effect::Interlock { core: 1, open });
    let delay = path(Path::Delay { crd: 1, ms: 30, fifo: 0 });
    // An abrupt stop, and a smooth one within a BufDelay.
    for (motion, entry) in [(2, line(vec![90, 40])), (1, delay)] {
        let mut calls = vec![plain(Kind::AxisOn, 0), plain(Kind::AxisOn, 1), frame(None)];
        calls.extend([Call::Effect(Effect::SetInterlock { motion }), entry, go.clone(), Call::Sleep { ns: 5 * MS }]);
        calls.extend([interlock(true), Call::Sleep { ns: 5 * MS }, interlock(false), Call::Sleep { ns: 4 * MS }]);
        calls.extend([light(LightOf::ClearFault), Call::Abort { core: 1 }, Call::Sleep { ns: 9 * MS }, frame(None)]);
        calls.extend([LightOf::Connector(true), LightOf::Carrier(20.0), LightOf::Power(38.5)].map(light));
        calls.extend([lights.clone(), line(vec![9, 4]), go.clone(), Call::Sleep { ns: 8 * MS }]);
        agrees(250, &calls);
    }
}

fn arc(plane: Plane, to: [i32; 2], round: Cycle) -> Call {
    let speeds = Speeds { vel: 9.7, acc: 2.3, end: 0.0 };
    path(Path::Arc { crd: 1, plane, to, round, ccw: false, speeds, fifo: 0 })
}

/// A coordinate that no motion of the FIFO takes to a target stays where the path is, also if its
/// axis gets another name. The reference took it for what it was at the call of the last motion.
#[test]
fn an_arc_after_a_rename_begins_where_the_path_is() {
    let space = Path::Set { crd: 1, axes: vec![0, 1, 2], vel: 50.0, acc: 4.9, even_ms: 0, origin: None };
    agrees(
        250,
        &[
            Call::SetPrfPos { axis: 1, pos: 89 },
            Call::Sleep { ns: MS },
            path(space),
            arc(Plane::ZX, [0, 0], Cycle::Centre(-621.0, -63.0)),
            plain(Kind::ZeroPos, 1),
            // Y is -89.
            arc(Plane::XY, [0, 0], Cycle::Radius(40.0)),
            Call::Sleep { ns: MS },
            arc(Plane::XY, [0, 0], Cycle::Radius(50.0)),
            Call::Sleep { ns: MS },
        ],
    );
    // Within a BufDelay there is no motion left that has a target.
    for radius in [8.0, 25.0] {
        agrees(
            250,
            &[
                plain(Kind::AxisOn, 0),
                plain(Kind::AxisOn, 1),
                frame(None),
                line(vec![26, -44]),
                path(Path::Delay { crd: 1, ms: 30, fifo: 0 }),
                path(Path::Start { mask: 1, option: 0 }),
                Call::Sleep { ns: 20 * MS },
                Call::Stop { mask: 2, abrupt: 2 },
                Call::Sleep { ns: 5 * MS },
                plain(Kind::ZeroPos, 1),
                Call::Sleep { ns: 5 * MS },
                arc(Plane::XY, [26, 10], Cycle::Radius(radius)),
                Call::Sleep { ns: MS },
            ],
        );
    }
}

/// An axis that a path moves has a velocity, also for its slave: as it is read, and where a Stop
/// makes the slave brake. In the reference it was 0.
#[test]
fn slaves_of_a_path_have_its_speed() {
    for sleep in [2 * MS + 600_000, 4 * MS, 7 * MS + 1000] {
        let read = |axis| plain(Kind::GetPrfVel, axis);
        agrees(
            250,
            &[
                plain(Kind::AxisOn, 0),
                plain(Kind::AxisOn, 1),
                plain(Kind::AxisOn, 2),
                plain(Kind::AxisOn, 3),
                Call::PrfFollow { axis: 2, dir: 0 },
                Call::SetFollowMaster { axis: 2, master: 1, kind: 2, item: 0 },
                Call::FollowData { axis: 2, datum: Datum { master: 49.0, slave: -45.0, kind: 1, percent: 0 }, fifo: 0 },
                Call::FollowStart { mask: 4, option: 0 },
                Call::PrfFollow { axis: 3, dir: -1 },
                Call::SetFollowMaster { axis: 3, master: 2, kind: 2, item: 0 },
                Call::FollowData { axis: 3, datum: Datum { master: 67.0, slave: 60.5, kind: 0, percent: 0 }, fifo: 0 },
                Call::FollowStart { mask: 8, option: 0 },
                frame(None),
                line(vec![-5, 44]),
                path(Path::Start { mask: 1, option: 0 }),
                Call::Sleep { ns: sleep },
                read(0),
                read(1),
                read(2),
                read(3),
                Call::Sleep { ns: MS },
                Call::Stop { mask: 8, abrupt: 0 },
                Call::Sleep { ns: MS },
                Call::Stop { mask: 4, abrupt: 0 },
                Call::Sleep { ns: 20 * MS },
            ],
        );
    }
}

/// Two slaves set one output in a tick, as far below their masters: the one with the higher number
/// comes last. The reference took those first whose master has the lower number.
#[test]
fn two_slaves_that_set_one_output() {
    for high in [false, true] {
        let mut calls: Vec<Call> = (0..4).map(|axis| plain(Kind::AxisOn, axis)).collect();
        for (axis, master, level) in [(0, 2, high), (3, 1, !high)] {
            let jog = [Call::SetJogPrm { axis: master, acc: 2.0, dec: 2.0 }, Call::SetVel { axis: master, vel: 9.3 }];
            calls.push(plain(Kind::PrfJog, master));
            calls.extend(jog);
            calls.push(ex(Call::PrfFollow { axis, dir: 1 }));
            calls.push(ex(Call::SetFollowMaster { axis, master, kind: 2, item: 0 }));
            calls.push(segment(axis, 20.0, 10.0, 1, 0));
            calls.push(Call::FollowEntry { axis, item: Item::Output { index: 4, level }, fifo: 0 });
            calls.push(segment(axis, 90.0, 40.0, 1, 0));
        }
        calls.push(ex(Call::FollowStart { mask: 9, option: 0 }));
        calls.extend([Call::Update { mask: 6 }, Call::Sleep { ns: 9 * MS }]);
        agrees(250, &calls);
    }
}

/// A Reset takes SetInterlock back: SPEC 9, and the page of safety. The reference kept it.
#[test]
fn an_interlock_after_a_reset() {
    let interlock = |open| Call::Effect(Effect::Interlock { core: 1, open });
    for motion in [0, 2] {
        let mut calls = vec![Call::Effect(Effect::SetInterlock { motion }), Call::Reset { core: 1 }];
        calls.extend([Call::Sleep { ns: 9 * MS }, plain(Kind::AxisOn, 0), plain(Kind::AxisOn, 1), frame(None)]);
        calls.extend([line(vec![90, 40]), path(Path::Start { mask: 1, option: 0 }), Call::Sleep { ns: 5 * MS }]);
        calls.extend([interlock(true), Call::Sleep { ns: 9 * MS }, interlock(false), Call::Sleep { ns: 9 * MS }]);
        agrees(250, &calls);
    }
}

/// A master comes to a wait for an input within rounding of a tick, so the wait times out with one.
#[test]
fn a_wait_that_times_out_with_a_tick() {
    let calls = [
        plain(Kind::AxisOn, 0),
        plain(Kind::AxisOn, 3),
        ex(Call::PrfFollow { axis: 3, dir: 1 }),
        ex(Call::SetFollowMaster { axis: 3, master: 0, kind: 2, item: 0 }),
        segment(3, 144.0, 216.0, 0, 0),
        Call::FollowEntry { axis: 3, item: Item::Wait { index: 6, level: true, ms: 3 }, fifo: 0 },
        ex(Call::FollowStart { mask: 8, option: 0 }),
        plain(Kind::PrfJog, 0),
        Call::SetJogPrm { axis: 0, acc: 2.4, dec: 6.4 },
        Call::SetVel { axis: 0, vel: 12.0 },
        Call::Update { mask: 1 },
        Call::Sleep { ns: 25 * MS },
    ];
    agrees(250, &calls);
}

/// A SwitchNow to the other FIFO on the tick in which a FollowSwitch has left that one: it is
/// empty.
#[test]
fn a_switch_now_after_a_switch_within_its_tick() {
    let mut calls = vec![
        plain(Kind::AxisOn, 0),
        plain(Kind::AxisOn, 1),
        Call::SetTrapPrm { axis: 1, acc: 4.1, dec: 0.3 },
        ex(Call::PrfFollow { axis: 0, dir: 1 }),
        ex(Call::SetFollowMaster { axis: 0, master: 1, kind: 2, item: 0 }),
        segment(0, 142.0, -196.25, 1, 0),
    ];
    let datum = Datum { master: 170.0, slave: 147.25, kind: 0, percent: 10 };
    calls.push(Call::FollowEntry { axis: 0, item: Item::Segment(datum), fifo: 1 });
    calls.push(ex(Call::FollowStart { mask: 1, option: 0 }));
    calls.push(ex(Call::FollowSwitch { mask: 1 }));
    calls.extend([Call::SetVel { axis: 1, vel: 27.3 }, Call::SetPos { axis: 1, pos: 272 }, Call::Update { mask: 2 }]);
    // It is at 142 pulses 8.531 ms after 0.25 ms.
    for ns in [8 * MS + 600_000, 9 * MS - 100_000] {
        let mut calls = calls.clone();
        calls.extend([Call::Sleep { ns }, Call::FollowSwitchNow { axis: 0, table: true }, Call::Sleep { ns: 9 * MS }]);
        agrees(250, &calls);
    }
}

/// Of a Stop and an Abort of one instant either may be why the path came to rest.
#[test]
fn a_stop_and_an_abort_of_one_instant() {
    let calls = [
        plain(Kind::AxisOn, 0),
        plain(Kind::AxisOn, 1),
        frame(None),
        line(vec![-66, 52]),
        path(Path::Start { mask: 1, option: 0 }),
        Call::Sleep { ns: MS },
        Call::Stop { mask: 3, abrupt: 0 },
        Call::Abort { core: 1 },
        Call::Sleep { ns: 21 * MS },
        path(Path::Why { crd: 1 }),
        Call::Sleep { ns: MS },
    ];
    agrees(250, &calls);
}

/// A stream that a Stop of the same instant ends leaves its ring empty.
#[test]
fn space_of_a_stream_at_a_stop() {
    let calls = [
        plain(Kind::AxisOn, 0),
        Call::PrfPt { axis: 0, mode: 1 },
        Call::PtData { axis: 0, pos: 135.0, time_ms: 23, kind: 2, fifo: 0 },
        Call::PtStart { mask: 1, option: 0 },
        Call::Sleep { ns: 16 * MS + 298_765 },
        Call::Stop { mask: 1, abrupt: 0 },
        Call::PtSpace { axis: 0, fifo: 0 },
        Call::Sleep { ns: 9 * MS },
    ];
    agrees(250, &calls);
}

/// An arc of a program is planned for where the path would have come to its end.
#[test]
fn an_arc_after_an_interlock_is_open() {
    let open = Call::Effect(Effect::Interlock { core: 1, open: true });
    let mut calls = vec![plain(Kind::AxisOn, 0), plain(Kind::AxisOn, 1), frame(None), line(vec![93, -28])];
    calls.extend([path(Path::Start { mask: 1, option: 0 }), Call::Sleep { ns: 4 * MS }, open]);
    calls.extend([path(Path::Wait { mask: 1 }), Call::Sleep { ns: 4 * MS }, super::found::arc([40, -28], 1)]);
    calls.extend([path(Path::Start { mask: 1, option: 1 }), Call::Sleep { ns: 9 * MS }]);
    is_open(250, &calls, "an arc that begins where an interlock has stopped a path");
}

/// The same of one that is added to what an interlock has left, while the other FIFO runs.
#[test]
fn an_arc_beside_the_other_fifo_after_an_interlock_is_open() {
    let open = Call::Effect(Effect::Interlock { core: 1, open: true });
    let mut calls = vec![plain(Kind::AxisOn, 0), plain(Kind::AxisOn, 1), frame(None), line(vec![93, -28])];
    calls.extend([path(Path::Start { mask: 1, option: 0 }), Call::Sleep { ns: 4 * MS }, open]);
    let speeds = Speeds { vel: 2.0, acc: 1.0, end: 0.0 };
    let other = path(Path::Line { crd: 1, to: vec![40, 9], speeds, fifo: 1 });
    calls.extend([path(Path::Wait { mask: 1 }), other, path(Path::Start { mask: 1, option: 1 })]);
    calls.extend([super::found::arc([60, -40], 0), Call::Sleep { ns: 9 * MS }]);
    is_open(250, &calls, "an arc that begins where an interlock has stopped a path");
}

/// Data of a program after an interlock was admitted for the stream that it ended.
#[test]
fn data_after_an_interlock_is_open() {
    let calls = [
        plain(Kind::AxisOn, 0),
        Call::PrfPt { axis: 0, mode: 1 },
        Call::PtData { axis: 0, pos: -131.0, time_ms: 38, kind: 2, fifo: 0 },
        Call::PtStart { mask: 1, option: 0 },
        Call::Effect(Effect::SetInterlock { motion: 2 }),
        Call::Effect(Effect::Interlock { core: 1, open: true }),
        Call::Sleep { ns: 13 * MS + 851_544 },
        Call::PtData { axis: 0, pos: -153.6, time_ms: 70, kind: 0, fifo: 0 },
        Call::Sleep { ns: 9 * MS },
    ];
    is_open(250, &calls, "data after a stream that a limit or an interlock ended");
}

/// An axis that brakes runs no PVT table: that can be replaced, also at the instant of its Stop.
#[test]
fn a_table_of_an_axis_that_brakes() {
    let table = |to| Points::Pvt(vec![[0.0, 0.0, 9.0], [20.0, to, 9.0]]);
    let fill = |to| Call::PvtTable { axis: 0, table: 7, points: table(to) };
    for rest in [0, 2 * MS] {
        let mut calls = vec![plain(Kind::AxisOn, 0), plain(Kind::PrfPvt, 0), fill(180.0)];
        calls.extend([Call::PvtTableSelect { axis: 0, table: 7 }, Call::PvtStart { mask: 1 }]);
        calls.extend([Call::Sleep { ns: 5 * MS }, Call::Abort { core: 1 }, Call::Sleep { ns: rest }, fill(90.0)]);
        calls.extend([Call::Sleep { ns: 30 * MS }, Call::PvtStart { mask: 1 }, Call::Sleep { ns: 25 * MS }]);
        agrees(1000, &calls);
    }
}

/// A BufDelay of 0 ms takes no time: what stands after it begins with the CrdStart, and an abrupt
/// Stop a tick later leaves what is left of it.
#[test]
fn an_abrupt_stop_in_a_delay_after_one_of_no_time() {
    let delay = |ms| path(Path::Delay { crd: 1, ms, fifo: 0 });
    let go = path(Path::Start { mask: 1, option: 0 });
    for first in [vec![], vec![delay(0)], vec![delay(0), delay(0)]] {
        let mut calls =
            vec![plain(Kind::AxisOn, 0), plain(Kind::AxisOn, 1), frame(None), Call::Sleep { ns: 3 * MS + 200_000 }];
        calls.extend(first);
        calls.extend([delay(7), line(vec![9, 4]), go.clone(), Call::Sleep { ns: 500_000 }]);
        calls.extend([path(Path::Stop { mask: 1, option: 1 }), path(Path::Wait { mask: 1 }), go.clone()]);
        calls.push(Call::Sleep { ns: 20 * MS });
        agrees(500, &calls);
    }
}

/// An Update as the axis brakes for its target: within rounding it ends on the tick before that
/// of the alarm.
#[test]
fn an_alarm_within_rounding_of_the_end_of_a_motion() {
    let calls = [
        plain(Kind::AxisOn, 1),
        Call::Sleep { ns: 20_146_980 },
        Call::SetTrapPrm { axis: 1, acc: 4.4, dec: 0.65 },
        Call::SetPos { axis: 1, pos: 94 },
        Call::SetVel { axis: 1, vel: 3.5 },
        Call::Update { mask: 2 },
        Call::Sleep { ns: 30_370_552 },
        Call::SetPos { axis: 1, pos: 6 },
        Call::SetVel { axis: 1, vel: 4.670124497509378 },
        Call::Update { mask: 2 },
        Call::Sleep { ns: 22_831_421 },
        Call::Update { mask: 2 },
        Call::Sleep { ns: 250_000 },
        Call::Terminal { axis: 1, kind: 2, level: true },
        Call::Sleep { ns: 1_425_014 },
        plain(Kind::GetStopReason, 1),
    ];
    agrees(1000, &calls);
}

/// The second of two Updates of an instant leaves no motion: the axis never runs, and the soft
/// limit that it is beyond shows on the next tick.
#[test]
fn an_update_to_no_speed_beside_one_to_a_speed() {
    let calls = [
        plain(Kind::AxisOn, 2),
        Call::SetPrfPos { axis: 2, pos: 170 },
        plain(Kind::PrfJog, 2),
        Call::SetJogPrm { axis: 2, acc: 1.15, dec: 1.025 },
        Call::Sleep { ns: 5 * MS },
        Call::SetVel { axis: 2, vel: 2.0 },
        Call::Update { mask: 4 },
        Call::SetSoftLimit { axis: 2, positive: 169, negative: -208 },
        Call::SetVel { axis: 2, vel: 0.0 },
        Call::Update { mask: 4 },
        Call::Sleep { ns: 5 * MS },
        plain(Kind::GetSts, 2),
    ];
    is_open(250, &calls, "the end of a motion");
}
/// A path comes to rest by a Stop as a call asks for standstill: refused, but for a Stop of its
/// instant. With one it is decided a tick late, where the path may rest.
#[test]
fn a_mode_as_a_path_comes_to_rest() {
    let to_zero = Speeds { vel: 4.7, acc: 0.6, end: 0.0 };
    for (after, beside) in [1_000_000, 2_000_000, 2_500_000, 3_000_000].into_iter().zip([false, false, true, false]) {
        let set = Path::Set { crd: 2, axes: vec![0, 1], vel: 6.06, acc: 1.62, even_ms: 0, origin: None };
        let mut calls = vec![
            plain(Kind::AxisOn, 0),
            plain(Kind::AxisOn, 1),
            path(set),
            Call::Sleep { ns: 582_801 },
            path(Path::Line { crd: 2, to: vec![30, -20], speeds: to_zero, fifo: 0 }),
            path(Path::Start { mask: 2, option: 0 }),
            Call::Sleep { ns: 4_646_749 },
            Call::Stop { mask: 3, abrupt: 0 },
            Call::Sleep { ns: after },
        ];
        let stop = Call::Stop { mask: 8, abrupt: 8 };
        calls.extend(beside.then_some(stop));
        calls.extend([plain(Kind::PrfTrap, 1), plain(Kind::GetPrfMode, 1), Call::Sleep { ns: 4 * MS }]);
        match beside {
            true => is_open(1000, &calls, "a call that needs standstill, just before its axis comes to rest"),
            false => agrees(1000, &calls),
        }
    }
}

/// A path moves an axis again right after the tick at which a Stop has it rest: a WaitStop may
/// find it at standstill there or not.
#[test]
fn a_wait_just_before_a_path_moves_the_axis_again() {
    let set = Path::Set {
        crd: 2,
        axes: vec![2, 3],
        vel: 5.976418973073862,
        acc: 2.7279402591153734,
        even_ms: 0,
        origin: None,
    };
    let line = |to: [i32; 2], vel: f64, acc: f64| {
        path(Path::Line { crd: 2, to: to.to_vec(), speeds: Speeds { vel, acc, end: 0.0 }, fifo: 0 })
    };
    let jump = |to: [i32; 2], vel: f64, acc: f64| path(Path::Jump { crd: 2, to, vel, acc, fifo: 0 });
    let shift = |to: i32, vel: f64, acc: f64| path(Path::Move { crd: 2, axis: 0, to, vel, acc, modal: 0, fifo: 0 });
    let calls = [
        plain(Kind::AxisOn, 0),
        plain(Kind::AxisOn, 2),
        plain(Kind::AxisOn, 3),
        path(set),
        line([2, -3], 2.770936473981576, 2.135114068237485),
        line([8, -3], 2.7178253436163704, 2.801988422889128),
        shift(-121, 9.125, 0.7088327189121341),
        jump([6, -5], 5.724728327125959, 1.093691945596811),
        jump([8, -4], 3.8897562940808035, 2.7304170827988856),
        shift(201, 10.125, 0.775),
        path(Path::Start { mask: 2, option: 0 }),
        Call::Sleep { ns: 8_219_207 },
        Call::Stop { mask: 1, abrupt: 0 },
        Call::WaitStop { mask: 1 },
        Call::Sleep { ns: 4_590_850 },
        plain(Kind::PrfPvt, 0),
    ];
    is_open(1000, &calls, "a call to an axis in the tick in which a path moves it");
}

/// A path that waited for an axis is known to 5 ns, and so is where a Stop holds it: what is left
/// there of a short distance takes longer by more than that.
#[test]
fn an_output_after_a_short_way_that_a_stop_left() {
    let line = |to: [i32; 2]| {
        path(Path::Line { crd: 1, to: to.to_vec(), speeds: Speeds { vel: 5.15, acc: 3.0, end: 0.0 }, fifo: 0 })
    };
    let calls = [
        plain(Kind::AxisOn, 0),
        plain(Kind::AxisOn, 1),
        plain(Kind::AxisOn, 2),
        frame(None),
        path(Path::StopDec { crd: 1, smooth: 2.34 }),
        line([7, 19]),
        path(Path::Move { crd: 1, axis: 2, to: 175, vel: 17.5, acc: 9.332, modal: 1, fifo: 0 }),
        line([25, -3]),
        path(Path::Output { crd: 1, index: 4, level: true, fifo: 0 }),
        path(Path::Start { mask: 1, option: 0 }),
        Call::Sleep { ns: 22_800_000 },
        path(Path::Stop { mask: 1, option: 0 }),
        path(Path::Wait { mask: 1 }),
        path(Path::Start { mask: 1, option: 0 }),
        Call::Sleep { ns: 20 * MS },
    ];
    is_open(100, &calls, "a path that was stopped after a wait for an axis, and goes on for a short distance");
}

/// Data after a Stop of its instant does not prolong a pass that ends there.
#[test]
fn pt_data_after_a_stop_at_the_end_of_a_pass() {
    for ms in [8, 9, 10] {
        let calls = [
            plain(Kind::AxisOn, 3),
            Call::PrfPt { axis: 3, mode: 0 },
            Call::PtData { axis: 3, pos: -22.0, time_ms: 9, kind: 0, fifo: 0 },
            Call::SetPtLoop { axis: 3, loops: 0 },
            Call::PtStart { mask: 8, option: 0 },
            Call::Sleep { ns: ms * MS },
            Call::Stop { mask: 8, abrupt: 0 },
            Call::PtData { axis: 3, pos: -18.0, time_ms: 13, kind: 0, fifo: 0 },
        ];
        agrees(1000, &calls);
    }
}
