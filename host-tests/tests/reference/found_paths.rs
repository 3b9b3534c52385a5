//! Programs of paths in which the controller and the reference once differed.
use super::found::*;
use super::judge::{Tally, finding};
use super::machine::{Rig, Seen};
use host_tests::path_model::Plane;
use host_tests::reference::{Call, Command, Cycle, Datum, Effect, Kind, LightCall, LightOf, Path, PathCall, Speeds};

/// A WaitStop of one axis of a coordinate system made another one, which had left it and ran, count
/// as waited for: its mode could be set while it ran.
#[test]
fn a_wait_for_an_axis_says_nothing_of_one_that_left_its_coordinate_system() {
    let set = Path::Set { crd: 1, axes: vec![2, 1, 0], vel: 15.0, acc: 2.0, even_ms: 0, origin: None };
    let datum = Datum { master: 478.0, slave: 324.0, kind: 3, percent: 0 };
    agrees(
        250,
        &[
            plain(Kind::AxisOn, 2),
            Call::Path(PathCall { core: 1, what: set }),
            Call::PrfFollow { axis: 2, dir: 0 },
            Call::SetFollowMaster { axis: 2, master: 3, kind: 1, item: 0 },
            Call::FollowData { axis: 2, datum, fifo: 0 },
            Call::FollowStart { mask: 4, option: 0 },
            Call::WaitStop { mask: 1 },
            plain(Kind::PrfTrap, 2),
            plain(Kind::GetPrfMode, 2),
            plain(Kind::GetSts, 2),
        ],
    );
}

/// An arc whose begin entries of its own instant seemed to hide was a tick late: a SetCrdPrm with
/// an origin of its own, from which nothing moves.
#[test]
fn an_arc_after_a_sleep_is_on_time() {
    let ready = [plain(Kind::AxisOn, 0), plain(Kind::AxisOn, 1)];
    let go = |fifo: i16| path(Path::Start { mask: 1, option: fifo });
    for (stop, again) in [(false, false), (true, false), (false, true), (true, true)] {
        let mut calls = ready.to_vec();
        calls.extend([frame(Some(vec![-7, 30])), line(vec![120, 40]), go(0), Call::Sleep { ns: 9 * MS }]);
        if stop {
            calls.push(path(Path::Stop { mask: 1, option: 0 }));
        }
        calls.extend([path(Path::Wait { mask: 1 }), Call::Sleep { ns: 4 * MS }]);
        if again {
            calls.push(frame(Some(vec![11, -3])));
            calls.push(path(Path::Clear { crd: 1, fifo: 1 }));
        }
        let fifo = i16::from(stop);
        calls.extend([arc([150, 80], fifo), arc([20, 10], fifo), go(fifo), Call::Sleep { ns: 9 * MS }]);
        for tick_us in [250, 100, 1000] {
            agrees(tick_us, &calls);
        }
    }
}

/// A path had come to its end, and a Stop that was to come hid that: an arc after a ZeroPos was
/// made to begin where the FIFO's last motion had ended, by the names from before.
#[test]
fn an_arc_after_a_stop_that_finds_the_path_at_its_end() {
    let set = Path::Set { crd: 2, axes: vec![1, 0], vel: 53.9, acc: 43.7, even_ms: 0, origin: None };
    let speeds = Speeds { vel: 35.0, acc: 22.0, end: 0.0 };
    let arc = |to: [i32; 2], radius: f64| {
        path(Path::Arc { crd: 2, plane: Plane::XY, to, round: Cycle::Radius(radius), ccw: true, speeds, fifo: 0 })
    };
    let go = path(Path::Start { mask: 2, option: 0 });
    let begin = [plain(Kind::AxisOn, 0), plain(Kind::AxisOn, 1), path(set), arc([49, 33], 67.4), go.clone()];
    for case in 0..8 {
        let [stop, zero, waits] = [1, 2, 4].map(|bit| case & bit != 0);
        let mut calls = begin.to_vec();
        calls.push(Call::Sleep { ns: 14_748_341 });
        calls.extend(stop.then_some(Call::Stop { mask: 1, abrupt: 1 }));
        calls.extend(waits.then_some(Call::WaitStop { mask: 1 }));
        calls.extend(zero.then_some(plain(Kind::ZeroPos, 0)));
        calls.extend([path(Path::Wait { mask: 2 }), Call::Sleep { ns: 4 * MS }, arc([-14, 69], 73.34), go.clone()]);
        calls.push(Call::Sleep { ns: 8 * MS });
        agrees(100, &calls);
    }
}

/// Data that came after a path had ended was taken as run by the WaitStop that followed: an arc of
/// the other FIFO was made to begin where that data ends.
#[test]
fn data_after_the_end_of_a_path_is_not_taken_as_run() {
    let go = |fifo: i16| path(Path::Start { mask: 1, option: fifo });
    let speeds = Speeds { vel: 12.6, acc: 3.5, end: 0.0 };
    let delay = path(Path::Delay { crd: 1, ms: 2, fifo: 1 });
    let data = path(Path::Line { crd: 1, to: vec![10, 7], speeds, fifo: 1 });
    for zero in [false, true] {
        let mut calls = vec![plain(Kind::AxisOn, 0), plain(Kind::AxisOn, 1), frame(None), delay.clone(), go(1)];
        calls.extend([Call::Sleep { ns: 14_577_251 }, data.clone(), path(Path::Wait { mask: 1 })]);
        calls.extend(zero.then_some(plain(Kind::ZeroPos, 0)));
        calls.extend([Call::Sleep { ns: 4 * MS }, arc([-4, -10], 0), go(0), Call::Sleep { ns: 30 * MS }]);
        for tick_us in [100, 250, 1000] {
            agrees(tick_us, &calls);
        }
    }
}

/// After a Stop that found the path at its end, and a ZeroPos, an entry without a motion made the
/// end of the last motion count as the begin of an arc, by the name from before.
#[test]
fn an_arc_after_an_entry_of_a_path_that_was_renamed() {
    let go = path(Path::Start { mask: 1, option: 0 });
    let speeds = Speeds { vel: 9.7, acc: 2.3, end: 0.0 };
    let round = Cycle::Radius(8.0);
    let arc = Path::Arc { crd: 1, plane: Plane::XY, to: [-2, 9], round, ccw: true, speeds, fifo: 0 };
    let calls = [
        plain(Kind::AxisOn, 0),
        plain(Kind::AxisOn, 1),
        frame(None),
        line(vec![12, 9]),
        go.clone(),
        Call::Sleep { ns: 60 * MS },
        path(Path::Stop { mask: 1, option: 0 }),
        path(Path::Wait { mask: 1 }),
        plain(Kind::ZeroPos, 0),
        Call::Sleep { ns: 4 * MS },
        path(Path::Delay { crd: 1, ms: 5, fifo: 0 }),
        // Directly after the entry the arc would be a tick late: where it begins is known from then
        // on.
        Call::Sleep { ns: 4 * MS },
        path(arc),
        go,
        Call::Sleep { ns: 30 * MS },
    ];
    for tick_us in [100, 250, 1000] {
        agrees(tick_us, &calls);
    }
}

/// An axis that a path moves counted as at standstill: a WaitStop did not wait for it, and its name
/// and its mode could be changed while it moved.
#[test]
fn an_axis_that_a_path_moves_is_not_at_standstill() {
    let ready = [plain(Kind::AxisOn, 0), plain(Kind::AxisOn, 1), plain(Kind::AxisOn, 3)];
    for waits in [0, 1] {
        let send = Path::Move { crd: 1, axis: 3, to: 299, vel: 5.8, acc: 1.4, modal: waits, fifo: 0 };
        let go = path(Path::Start { mask: 1, option: 0 });
        let set_up = [frame(None), line(vec![30, 20]), path(send), go, Call::Sleep { ns: 12 * MS }];
        let again = [plain(Kind::ZeroPos, 3), plain(Kind::PrfJog, 3), plain(Kind::GetPrfMode, 3)];
        for all in [false, true] {
            // Before the path has come to it, the wait is for all of the path.
            let wait = if all { path(Path::Wait { mask: 1 }) } else { Call::WaitStop { mask: 8 } };
            let calls = [&ready[..], &set_up, &again, &[wait, Call::Sleep { ns: 4 * MS }], &again].concat();
            for tick_us in [250, 100, 1000] {
                agrees(tick_us, &calls);
            }
        }
    }
}

/// A smooth Stop on the tick after which the path sends the axis on again: it jumped to the end of
/// that move.
#[test]
fn a_stop_just_before_a_path_sends_the_axis_on() {
    let axes = vec![0, 1, 2];
    let set = Path::Set { crd: 2, axes, vel: 9.0, acc: 6.7, even_ms: 0, origin: None };
    let path = |what| Call::Path(PathCall { core: 1, what });
    let speeds = Speeds { vel: 8.0, acc: 5.0, end: 0.0 };
    let line = |x: i32| path(Path::Line { crd: 2, to: vec![x, 0, 0], speeds, fifo: 0 });
    let send = |to: i32| path(Path::Move { crd: 2, axis: 3, to, vel: 18.0, acc: 0.6, modal: 0, fifo: 0 });
    let begin = [0, 1, 2, 3].map(|axis| plain(Kind::AxisOn, axis));
    for ms in 7..13 {
        let rest = [
            path(set.clone()),
            line(10),
            send(-43),
            line(60),
            send(-229),
            line(70),
            path(Path::Start { mask: 2, option: 0 }),
            Call::Sleep { ns: ms * MS },
            Call::Stop { mask: 8, abrupt: 0 },
        ];
        // In some of them the Stop falls on the tick in which it is sent on: that is open.
        let calls = [&begin[..], &rest[..]].concat();
        if let Some(report) = finding(&mut None, &gus(), 1000, &calls, &mut Tally::new()) {
            panic!("{report}");
        }
    }
}

/// An arc after a delay began where the path had stood when the delay was given: not where the
/// other FIFO, or a new name, had taken it since.
#[test]
fn an_arc_after_a_delay_begins_where_the_path_is() {
    let ready = [plain(Kind::AxisOn, 0), plain(Kind::AxisOn, 1), frame(None)];
    let delay = path(Path::Delay { crd: 1, ms: 6, fifo: 0 });
    let go = |fifo: i16| [path(Path::Start { mask: 1, option: fifo }), Call::Sleep { ns: 60 * MS }];
    let other = [&[arc([-12, 22], 1)][..], &go(1)].concat();
    let ran = [&[line(vec![30, 20])][..], &go(0)].concat();
    let renamed = [plain(Kind::ZeroPos, 0), Call::Sleep { ns: 4 * MS }];
    let arcs = [&[arc([4, -8], 0)][..], &go(0)].concat();
    let one = std::slice::from_ref(&delay);
    for tick_us in [250, 1000] {
        agrees(tick_us, &[&ready[..], one, &other, &arcs].concat());
        agrees(tick_us, &[&ready[..], &ran, one, &other, &arcs].concat());
        agrees(tick_us, &[&ready[..], &ran, one, &renamed, &arcs].concat());
    }
}

/// After a Stop in a path whose motions do not all set the same coordinates, an arc begins where
/// those that are ahead end.
#[test]
fn an_arc_after_motions_that_set_different_coordinates() {
    let axes = vec![0, 1, 2];
    let set = path(Path::Set { crd: 1, axes, vel: 50.0, acc: 4.9, even_ms: 0, origin: None });
    let speeds = Speeds { vel: 9.7, acc: 2.3, end: 0.0 };
    let far = path(Path::Line { crd: 1, to: vec![30, 20, 10], speeds, fifo: 0 });
    let bend = |plane, to: [i32; 2]| {
        path(Path::Arc { crd: 1, plane, to, round: Cycle::Radius(90.0), ccw: true, speeds, fifo: 0 })
    };
    let ready = [0, 1, 2].map(|axis| plain(Kind::AxisOn, axis));
    let start = path(Path::Start { mask: 1, option: 0 });
    for ms in [2, 6, 8, 10, 12, 30] {
        for name in [0, 1, 2] {
            let calls = [
                set.clone(),
                far.clone(),
                bend(Plane::YZ, [25, 14]),
                start.clone(),
                Call::Sleep { ns: ms * MS },
                Call::Stop { mask: 1, abrupt: 0 },
                path(Path::Wait { mask: 1 }),
                plain(Kind::ZeroPos, name),
                Call::Sleep { ns: 4 * MS },
                bend(Plane::XY, [35, 27]),
                bend(Plane::YZ, [3, -4]),
                start.clone(),
                Call::Sleep { ns: 20 * MS },
            ];
            // Where the Stop falls on a boundary is open.
            if let Some(report) = finding(&mut None, &gus(), 1000, &[&ready[..], &calls].concat(), &mut Tally::new()) {
                panic!("{report}");
            }
        }
    }
}

/// A path that went on within a circle: its slaves saw a turn that lay before the Stop once more,
/// and jumped.
#[test]
fn a_slave_of_an_axis_that_goes_on_within_a_circle() {
    let speeds = Speeds { vel: 2.4, acc: 6.2, end: 0.0 };
    let circle =
        Path::Arc { crd: 1, plane: Plane::XY, to: [0, 0], round: Cycle::Centre(3.0, 8.0), ccw: false, speeds, fifo: 0 };
    let start = path(Path::Start { mask: 1, option: 0 });
    let ready = [plain(Kind::AxisOn, 0), plain(Kind::AxisOn, 1), plain(Kind::AxisOn, 3), frame(None)];
    for (dir, ms) in [(-1, 10), (0, 10), (1, 10), (-1, 14), (1, 18)] {
        let run = [
            path(circle.clone()),
            start.clone(),
            Call::Sleep { ns: ms * MS },
            Call::Stop { mask: 1, abrupt: 0 },
            Call::Sleep { ns: 5 * MS },
            Call::PrfFollow { axis: 3, dir },
            Call::SetFollowMaster { axis: 3, master: 0, kind: 2, item: 0 },
            Call::FollowData { axis: 3, datum: Datum { master: 765.0, slave: 474.75, kind: 0, percent: 0 }, fifo: 0 },
            Call::FollowStart { mask: 8, option: 0 },
            Call::Sleep { ns: MS },
            start.clone(),
        ];
        if let Some(report) = finding(&mut None, &gus(), 250, &[&ready[..], &run].concat(), &mut Tally::new()) {
            panic!("{report}");
        }
    }
}

/// The tick refused a start, and the job went on: an arc in the other FIFO began where the refused
/// path would have ended.
#[test]
fn an_arc_after_a_start_that_the_tick_refuses() {
    let speeds = Speeds { vel: 3.4, acc: 1.6, end: 0.0 };
    let arc = |fifo| {
        let round = Cycle::Radius(8.0);
        path(Path::Arc { crd: 1, plane: Plane::XY, to: [4, 6], round, ccw: false, speeds, fifo })
    };
    for fifo in [1, 0] {
        let alarm = |level| Call::Terminal { axis: 0, kind: 2, level };
        agrees(
            250,
            &[
                plain(Kind::AxisOn, 0),
                plain(Kind::AxisOn, 1),
                frame(None),
                alarm(true),
                path(Path::Line { crd: 1, to: vec![-10, 4], speeds, fifo: 0 }),
                Call::Sleep { ns: 3 * MS },
                path(Path::Start { mask: 1, option: 0 }),
                Call::Sleep { ns: 3 * MS },
                alarm(false),
                Call::Sleep { ns: 3 * MS },
                plain(Kind::ClrSts, 0),
                Call::WaitStop { mask: 3 },
                path(Path::Wait { mask: 1 }),
                Call::Sleep { ns: 4 * MS },
                arc(fifo),
                path(Path::Start { mask: 1, option: i16::from(fifo == 1) }),
                Call::Sleep { ns: 20 * MS },
            ],
        );
    }
}

/// An entry that was given kept the place of a path at standstill from being known: the arc after
/// it was a tick late.
#[test]
fn an_arc_after_an_entry_on_a_renamed_path() {
    let speeds = Speeds { vel: 19.0, acc: 6.2, end: 0.0 };
    let round = Cycle::Radius(107.5);
    agrees(
        500,
        &[
            plain(Kind::AxisOn, 0),
            plain(Kind::AxisOn, 1),
            frame(None),
            path(Path::Outputs { crd: 1, mask: 1, value: 0, fifo: 0 }),
            plain(Kind::ZeroPos, 1),
            path(Path::Start { mask: 1, option: 0 }),
            Call::Sleep { ns: 1_317_745 },
            path(Path::Wait { mask: 1 }),
            Call::Sleep { ns: 4 * MS },
            path(Path::Outputs { crd: 1, mask: 16, value: 16, fifo: 1 }),
            path(Path::Arc { crd: 1, plane: Plane::XY, to: [-54, -92], round, ccw: false, speeds, fifo: 1 }),
            path(Path::Start { mask: 1, option: 1 }),
            Call::Sleep { ns: 20 * MS },
        ],
    );
}

/// An axis with an alarm left its coordinate system, by another mode or by a Reset: the channel
/// stayed dark, whatever was called.
#[test]
fn an_alarm_that_has_left_its_coordinate_system() {
    let light = |what| Call::Light(LightCall { channel: 0, what });
    for leaves in [plain(Kind::PrfJog, 0), Call::Reset { core: 1 }] {
        agrees(
            250,
            &[
                plain(Kind::AxisOn, 0),
                plain(Kind::AxisOn, 1),
                frame(None),
                Call::Terminal { axis: 0, kind: 2, level: true },
                Call::Sleep { ns: 3 * MS },
                leaves,
                Call::Sleep { ns: 3 * MS },
                plain(Kind::ClrSts, 1),
                light(LightOf::ClearFault),
                light(LightOf::Connector(true)),
                light(LightOf::Gate(true)),
                Call::Sleep { ns: 3 * MS },
                light(LightOf::Gate(false)),
                Call::Sleep { ns: 3 * MS },
            ],
        );
    }
}

/// Data after a start waited until the tick had emptied the FIFO, at the same instant: it counted a
/// tick late. So a short line that was to end at speed began as one that ends at standstill.
#[test]
fn a_line_after_the_start_of_a_path_that_was_just_emptied() {
    let line = |to: [i32; 2]| {
        path(Path::Line { crd: 1, to: to.to_vec(), speeds: Speeds { vel: 9.0, acc: 4.9, end: 4.0 }, fifo: 0 })
    };
    let go = path(Path::Start { mask: 1, option: 0 });
    let ready = [plain(Kind::AxisOn, 0), plain(Kind::AxisOn, 1), frame(None)];
    let late = [line([1, 2]), go.clone(), line([40, 20]), Call::Sleep { ns: 40 * MS }];
    let again = [path(Path::Wait { mask: 1 }), path(Path::Clear { crd: 1, fifo: 0 }), line([41, 22]), go, line([7, 5])];
    let mut calls = [&ready[..], &late[..]].concat();
    agrees(1000, &calls);
    calls.extend([&again[..], &[Call::Sleep { ns: 40 * MS }]].concat());
    agrees(1000, &calls);
}

/// After a Stop within FIFO 0, a first line of FIFO 1 to the pulse next to where the path stands
/// was taken for a way back to there: it had no length.
#[test]
fn a_line_of_less_than_a_pulse_with_fifo_1() {
    let line = |to: [i32; 2], fifo| {
        path(Path::Line { crd: 1, to: to.to_vec(), speeds: Speeds { vel: 1.5, acc: 0.9, end: 0.0 }, fifo })
    };
    let go = |option| path(Path::Start { mask: 1, option });
    let ready = [plain(Kind::AxisOn, 0), plain(Kind::AxisOn, 1), frame(None)];
    let stop = [line([-6, -4], 0), go(0), Call::Sleep { ns: 1_250_000 }, Call::Stop { mask: 1, abrupt: 0 }];
    let calls =
        [&ready[..], &stop[..], &[Call::Sleep { ns: 4 * MS }, line([-1, 0], 1), go(1), Call::Sleep { ns: 9 * MS }]];
    agrees(250, &calls.concat());
}

/// A WaitStop of an axis whose coordinate system stands still made the controller see first where
/// the stream of its instant is: what came after the data was late.
#[test]
fn a_wait_for_a_path_at_standstill_takes_no_time() {
    let begin = [
        plain(Kind::AxisOn, 1),
        plain(Kind::AxisOn, 2),
        frame(None),
        Call::PrfPt { axis: 2, mode: 1 },
        Call::PtData { axis: 2, pos: 21.25, time_ms: 29, kind: 1, fifo: 0 },
        Call::PtStart { mask: 4, option: 0 },
    ];
    for wait in [Call::WaitStop { mask: 1 }, path(Path::Wait { mask: 1 })] {
        let mut calls = begin.to_vec();
        calls.push(wait);
        calls.push(Call::PtData { axis: 2, pos: 4.0, time_ms: 32, kind: 2, fifo: 0 });
        calls.extend([Call::SetPos { axis: 3, pos: 70 }, Call::SetVel { axis: 3, vel: 40.0 }]);
        calls.extend([Call::SetTrapPrm { axis: 3, acc: 2.5, dec: 1.7 }, plain(Kind::AxisOn, 3)]);
        calls.extend([Call::Update { mask: 8 }, Call::Sleep { ns: 40 * MS }]);
        for tick_us in [100, 250] {
            agrees(tick_us, &calls);
        }
    }
}

/// A delay after a modal move counted as a wait for its axis: a Stop of the axis then was a fault
/// of the path, and its lasers stayed dark.
#[test]
fn a_stop_of_an_axis_that_a_path_has_waited_for() {
    let light = |what| Call::Light(LightCall { channel: 0, what });
    let aside = |to, modal| path(Path::Move { crd: 1, axis: 3, to, vel: 74.5, acc: 0.65, modal, fifo: 0 });
    let on = path(Path::Laser { crd: 1, channel: 0, command: Command::Gate(true), fifo: 1 });
    let speeds = Speeds { vel: 9.7, acc: 2.3, end: 0.0 };
    let go = |option| path(Path::Start { mask: 1, option });
    for (mask, abrupt) in [(8, 8), (8, 0), (9, 9), (11, 11), (11, 8)] {
        let mut calls: Vec<Call> = (0..4).map(|axis| plain(Kind::AxisOn, axis)).collect();
        calls.extend([light(LightOf::Connector(true)), light(LightOf::Carrier(20.0)), frame(None)]);
        calls.extend([line(vec![5, 2]), aside(2, 1), aside(-112, 0), path(Path::Delay { crd: 1, ms: 30, fifo: 0 })]);
        calls.extend([go(0), Call::Sleep { ns: 18 * MS }, Call::Stop { mask, abrupt }, Call::Sleep { ns: 40 * MS }]);
        calls.extend([on.clone(), path(Path::Line { crd: 1, to: vec![40, 9], speeds, fifo: 1 }), go(1)]);
        calls.extend([Call::Sleep { ns: 30 * MS }, light(LightOf::GetFault), Call::Sleep { ns: MS }]);
        agrees(250, &calls);
    }
}

/// A path that an interlock has stopped goes on with CrdStart, also in a program, which is admitted
/// ahead: it took the path to have come to its end, and refused the start.
#[test]
fn a_start_after_an_interlock_goes_on() {
    let interlock = |open| Call::Effect(Effect::Interlock { core: 1, open });
    let go = path(Path::Start { mask: 1, option: 0 });
    for (rest, again) in [(0, line(vec![-9, 4])), (4, line(vec![-9, 4])), (4, plain(Kind::GetSts, 0))] {
        let mut calls = vec![plain(Kind::AxisOn, 0), plain(Kind::AxisOn, 1), frame(None), line(vec![-66, 52])];
        calls.extend([go.clone(), Call::Sleep { ns: 4 * MS }, interlock(true), path(Path::Wait { mask: 1 })]);
        calls.extend([Call::Sleep { ns: rest * MS }, interlock(false), again, go.clone(), Call::Sleep { ns: 30 * MS }]);
        for tick_us in [250, 1000] {
            agrees(tick_us, &calls);
        }
    }
}

/// An arc after a SetPrfPos was a tick late where SetCrdPrm gave no origin, and so was all after
/// it.
#[test]
fn an_arc_after_a_rename_is_on_time() {
    let axis = |kind| plain(kind, 2);
    let mut calls = vec![plain(Kind::AxisOn, 0), plain(Kind::AxisOn, 1), axis(Kind::AxisOn), frame(None)];
    calls.extend([Call::Sleep { ns: 5 * MS + 702_062 }, Call::SetPrfPos { axis: 0, pos: 43 }, arc([1, 7], 0)]);
    calls.extend([axis(Kind::PrfJog), Call::SetJogPrm { axis: 2, acc: 2.4, dec: 1.3 }]);
    calls.extend([Call::SetVel { axis: 2, vel: 3.0 }, Call::Update { mask: 4 }, Call::Sleep { ns: 3 * MS }]);
    agrees(250, &calls);
}

/// A Stop and a rename at standstill kept a coordinate system in a laser's map, in a program that
/// passes over what is refused; in others SetLaserCrdMap was late.
#[test]
fn a_map_after_a_stop_and_a_rename() {
    let map = Call::Light(LightCall { channel: 0, what: LightOf::Map(0) });
    let go = path(Path::Start { mask: 1, option: 0 });
    for begin in [line(vec![13, 29]), path(Path::Delay { crd: 1, ms: 0, fifo: 0 })] {
        for stop in [2, 30] {
            let mut calls =
                vec![plain(Kind::AxisOn, 0), plain(Kind::AxisOn, 1), frame(None), begin.clone(), go.clone()];
            calls.extend([
                Call::Sleep { ns: stop * MS },
                Call::Stop { mask: 1, abrupt: 0 },
                Call::Sleep { ns: 20 * MS },
            ]);
            calls.extend([Call::SetPrfPos { axis: 0, pos: 229 }, map.clone(), Call::Sleep { ns: MS }]);
            agrees(250, &calls);
        }
    }
}

/// A motion too short to brake in stops the path in front of a wait. An arc of the other FIFO was
/// planned from the end of the data, which the path had not reached.
#[test]
fn an_arc_after_a_path_that_stopped_in_front_of_a_wait() {
    let to = |to: [i32; 2], end: f64| {
        path(Path::Line { crd: 1, to: to.to_vec(), speeds: Speeds { vel: 3.0, acc: 0.3, end }, fifo: 0 })
    };
    let go = |option| path(Path::Start { mask: 1, option });
    let mut calls = vec![plain(Kind::AxisOn, 0), plain(Kind::AxisOn, 1), frame(None)];
    calls.extend([to([8, 0], 2.5), to([9, 1], 0.4), path(Path::Delay { crd: 1, ms: 4, fifo: 0 }), to([40, 30], 0.0)]);
    // The refused call gives the program time to learn that the path runs.
    calls.extend([go(0), plain(Kind::ZeroPos, 0), Call::Sleep { ns: 3 * MS }, path(Path::Wait { mask: 1 })]);
    calls.extend([Call::Sleep { ns: 4 * MS }, arc([2, 7], 1), go(1), Call::Sleep { ns: 30 * MS }]);
    for tick_us in [250, 1000] {
        agrees(tick_us, &calls);
    }
}

/// Moves of an axis that begin and end within one tick: the ramp of the first was entered before
/// the tick in which it begins, and the axis jumped to the target of the second.
#[test]
fn moves_that_begin_and_end_within_a_tick() {
    let send = |to: i32, vel: f64, acc: f64, modal| path(Path::Move { crd: 1, axis: 3, to, vel, acc, modal, fifo: 0 });
    let to = |to: [i32; 2], end: f64| {
        path(Path::Line { crd: 1, to: to.to_vec(), speeds: Speeds { vel: 2.2, acc: 1.95, end }, fifo: 0 })
    };
    let set_up = || (0..4).map(|axis| plain(Kind::AxisOn, axis)).chain([frame(None), to([3, 2], 0.8)]);
    let go = [path(Path::Start { mask: 1, option: 0 }), Call::Sleep { ns: 90 * MS }];
    // The path waits for each, or for none and they are a short line apart.
    let waited = |first: i32| [send(first, 39.5, 200.0, 1), send(first + 1, 30.0, 90.0, 1), send(-300, 7.75, 5.4, 1)];
    let passed = |first: i32| [send(first, 39.5, 200.0, 0), to([4, 2], 0.8), send(-300, 7.75, 5.4, 0)];
    for first in [0, 1, 2, -1, -2] {
        for moves in [waited(first), passed(first)] {
            for tick_us in [250, 500, 1000] {
                agrees(tick_us, &set_up().chain(moves.clone()).chain(go.clone()).collect::<Vec<_>>());
                // A slave of the axis goes where it goes below 0, in every tick.
                let datum = Datum { master: -1000.0, slave: -1500.0, kind: 1, percent: 0 };
                let slave = [
                    Call::PrfFollow { axis: 2, dir: 0 },
                    Call::SetFollowMaster { axis: 2, master: 3, kind: 2, item: 0 },
                    Call::FollowData { axis: 2, datum, fifo: 0 },
                    Call::FollowStart { mask: 4, option: 0 },
                ];
                let calls: Vec<_> = set_up().chain(slave).chain(moves.clone()).chain(go.clone()).collect();
                let run = Rig::new(gus(), tick_us).run(&calls).unwrap();
                let reached = |row: &Vec<Seen>, axis: usize| (row[axis].0 - run.rows[0][axis].0) as f64;
                assert!(run.rows.iter().any(|row| reached(row, 3) != 0.0));
                for row in &run.rows {
                    let due = 1.5 * reached(row, 3).min(0.0);
                    assert!((reached(row, 2) - due).abs() < 4.0, "{tick_us} µs, {first}: {row:?}");
                }
            }
        }
    }
}

/// What a path sets off in the tick in which an interlock stops all motion stands with the rest.
#[test]
fn a_move_at_the_start_of_a_path_and_an_interlock() {
    let send = path(Path::Move { crd: 1, axis: 3, to: -11, vel: 5.375, acc: 8.4, modal: 0, fifo: 0 });
    let mut calls = vec![Call::Effect(Effect::SetInterlock { motion: 2 })];
    calls.extend([0, 1, 3].map(|axis| plain(Kind::AxisOn, axis)));
    calls.extend([frame(None), send, Call::Sleep { ns: 4 * MS }, path(Path::Start { mask: 1, option: 0 })]);
    calls.extend([Call::Effect(Effect::Interlock { core: 1, open: true }), Call::Sleep { ns: 10 * MS }]);
    for tick_us in [250, 500, 1000] {
        agrees(tick_us, &calls);
    }
}

/// A path at work for the tick had yet to set an axis off. A SetCrdPrm of that axis after the wait
/// for it took the arc to begin where the axis had been before.
#[test]
fn an_arc_of_an_axis_that_another_path_has_moved() {
    let set = |crd: i16, axes: Vec<usize>, origin: Option<Vec<i32>>| {
        path(Path::Set { crd, axes, vel: 40.0, acc: 11.0, even_ms: 0, origin })
    };
    let arc = |radius: f64| {
        let (round, speeds) = (Cycle::Radius(radius), Speeds { vel: 10.3, acc: 3.4, end: 0.0 });
        path(Path::Arc { crd: 2, plane: Plane::XY, to: [0, -48], round, ccw: true, speeds, fifo: 1 })
    };
    for origin in [None, Some(vec![-54, -6])] {
        // Seen from where the axis was, the first radius is enough.
        for radius in [48.5, 90.0] {
            for (modal, tick_us) in [(0, 1000), (1, 1000), (1, 250)] {
                let mut calls: Vec<_> = [0, 1, 2, 3].map(|axis| plain(Kind::AxisOn, axis)).into();
                calls.extend([set(1, vec![2, 3], None), Call::Sleep { ns: 4 * MS }]);
                calls.push(path(Path::Move { crd: 1, axis: 1, to: 81, vel: 58.6, acc: 0.54, modal, fifo: 0 }));
                calls.push(line(vec![20, 3]));
                calls.extend([path(Path::Start { mask: 1, option: 0 }), Call::WaitStop { mask: 8 }]);
                calls.extend([Call::WaitStop { mask: 2 }, Call::Sleep { ns: 4 * MS }]);
                calls.extend([set(2, vec![1, 0], origin.clone()), arc(radius)]);
                calls.extend([path(Path::Start { mask: 2, option: 2 }), Call::Sleep { ns: 50 * MS }]);
                agrees(tick_us, &calls);
            }
        }
    }
}
