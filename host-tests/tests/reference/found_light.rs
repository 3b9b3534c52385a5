//! Programs of lasers in which the controller and the reference once differed.
use super::found::{MS, agrees, frame, gus, is_open, line, path, plain};
use super::judge::{Tally, finding};
use host_tests::reference::{Call, Command, Effect, Family, Kind, LightCall, LightOf, LightTable, Path, Setup, Speeds};

fn light(what: LightOf) -> Call {
    Call::Light(LightCall { channel: 0, what })
}

fn entry(command: Command) -> Call {
    path(Path::Laser { crd: 1, channel: 0, command, fifo: 0 })
}

fn begin() -> Vec<Call> {
    vec![plain(Kind::AxisOn, 0), plain(Kind::AxisOn, 1), light(LightOf::Connector(true)), frame(None)]
}

fn go() -> Call {
    path(Path::Start { mask: 1, option: 0 })
}

/// SetCrdPrm empties both FIFOs: what a Stop keeps dark does not come back, and a map may exclude
/// the coordinate system. The reference kept it.
#[test]
fn a_map_after_another_frame() {
    let map = light(LightOf::Map(0));
    let mut calls = begin();
    calls.extend([entry(Command::Gate(true)), line(vec![90, 40]), go(), Call::Sleep { ns: 5 * MS }]);
    calls.extend([Call::Stop { mask: 1, abrupt: 0 }, Call::Sleep { ns: 9 * MS }, map.clone()]);
    calls.extend([Call::Sleep { ns: 4 * MS }, frame(None), Call::Sleep { ns: 4 * MS }, map, Call::Sleep { ns: MS }]);
    agrees(250, &calls);
}

/// An entry that the path has passed may name its table until the FIFO is empty, and data is
/// admitted ahead of its instant: for the controller this FIFO never is. The reference says so.
#[test]
fn a_follow_table_that_a_path_has_passed() {
    let table = |power| Call::LightTable(LightTable::Powers { channel: 0, table: 2, points: vec![[0.0, power]] });
    let mut calls = begin();
    calls.extend([table(30.0), entry(Command::Table(2, [0.0, 60.0])), entry(Command::Ratio([0.4, 0.0, 10.0]))]);
    calls.extend([go(), Call::Sleep { ns: 11 * MS }]);
    // Where nothing follows in the FIFO, the table is free.
    agrees(250, &[&calls[..], &[table(20.0), Call::Sleep { ns: MS }]].concat());
    calls.extend([line(vec![9, 4]), table(20.0), Call::Sleep { ns: MS }]);
    is_open(250, &calls, "a table of powers that a path may just have left");
}

/// A table that an entry had named before its FIFO was emptied kept the program waiting while the
/// other FIFO ran, and the Stop of that instant was late by a tick. Here the controller was wrong.
#[test]
fn a_follow_table_of_an_entry_that_was_emptied() {
    let table = |power| Call::LightTable(LightTable::Powers { channel: 0, table: 2, points: vec![[0.0, power]] });
    let speeds = Speeds { vel: 9.0, acc: 3.0, end: 0.0 };
    let mut calls = begin();
    calls.extend([table(30.0), entry(Command::Table(2, [0.0, 60.0])), frame(None)]);
    calls.extend([path(Path::Line { crd: 1, to: vec![90, 40], speeds, fifo: 1 })]);
    calls.extend([path(Path::Start { mask: 1, option: 1 }), Call::Sleep { ns: 5 * MS }]);
    calls.extend([light(LightOf::Connector(true)), table(20.0), Call::Stop { mask: 1, abrupt: 0 }]);
    calls.push(Call::Sleep { ns: 9 * MS });
    agrees(250, &calls);
}

/// A limit of an axis of a table is not held to the highest frequency of the LSR family.
#[test]
fn a_limit_above_the_highest_frequency() {
    let points = [-0.15, 0.15, 0.0, -0.14].map(|ratio| vec![(0, ratio)]);
    let table = LightTable::Lines { channel: 0, points, bounds: [1.0, 0.0], limits: Some([50.0, 50.0, 0.0, 2.0]) };
    let mode = LightOf::Mode { mode: 1, max: 24.0, min: 2.0, delayed: true };
    let distance = LightOf::Distance(Some((0, [-180, -172, 0, 3], [1.0; 4])));
    let mut calls: Vec<Call> = [mode, LightOf::Width(8), LightOf::Power(11.8), distance].map(light).into();
    calls.extend([Call::LightTable(table), light(LightOf::Gate(true)), Call::Sleep { ns: 4 * MS }]);
    calls.extend([light(LightOf::GetPower), Call::Sleep { ns: MS }]);
    let mut tally = Tally::new();
    let lsr = Setup { family: Family::Lsr, ..gus() };
    assert_eq!(finding(&mut None, &lsr, 500, &calls, &mut tally), None);
    assert!(tally["values read"] > 0, "{tally:?}");
}

/// An immediate off while a path brakes for an interlock, which is cleared before standstill: the
/// on entry that the path passes lights nothing. It did: the controller was wrong.
#[test]
fn an_off_while_a_path_brakes_for_an_interlock() {
    let interlock = |open| Call::Effect(Effect::Interlock { core: 1, open });
    let lines = [([100, 30], 40.0), ([300, 90], 40.0), ([900, 100], 0.0)];
    let to = |(to, end): ([i32; 2], f64)| {
        path(Path::Line { crd: 1, to: to.to_vec(), speeds: Speeds { vel: 40.0, acc: 12.0, end }, fifo: 0 })
    };
    for off in [false, true] {
        let mut calls = begin();
        calls.push(path(Path::Set { crd: 1, axes: vec![0, 1], vel: 100.0, acc: 20.0, even_ms: 0, origin: None }));
        calls.extend([light(LightOf::Carrier(20.0)), light(LightOf::Power(45.0)), Call::Sleep { ns: 5 * MS }]);
        calls.push(path(Path::StopDec { crd: 1, smooth: 3.0 }));
        calls.extend([to(lines[0]), to(lines[1]), entry(Command::Gate(true)), to(lines[2]), go()]);
        calls.extend([Call::Sleep { ns: 4 * MS }, interlock(true), Call::Sleep { ns: MS }]);
        if off {
            calls.push(light(LightOf::Gate(false)));
        }
        calls.extend([Call::Sleep { ns: MS }, interlock(false)]);
        calls.extend([Call::Sleep { ns: 4 * MS }, light(LightOf::ClearFault), Call::Sleep { ns: 30 * MS }]);
        for tick_us in [250, 1000] {
            agrees(tick_us, &calls);
        }
    }
}

/// ClrSts of an axis without an alarm, in a coordinate system beside that of an axis with one: the
/// cause is there yet, and light stays refused.
#[test]
fn a_clear_beside_an_axis_with_an_alarm() {
    let alarm = Call::Terminal { kind: 2, axis: 0, level: true };
    let set =
        |crd: i16, axes: Vec<usize>| path(Path::Set { crd, axes, vel: 58.0, acc: 13.0, even_ms: 0, origin: None });
    let calls = [alarm, set(1, vec![0, 1]), set(2, vec![2, 3]), Call::Sleep { ns: 4 * MS }, plain(Kind::ClrSts, 3)];
    is_open(250, &calls, "a clear of light while an alarm is there");
}

/// An entry of one coordinate system chooses the speed, planned or of encoders, that a channel
/// follows of another one. That one had taken its step of the tick: its speed was 0 for a tick, and
/// the encoders' filter began a tick late.
#[test]
fn a_speed_of_another_path_is_followed_from_the_entry_on() {
    for (follows, enters) in [(1, 2), (2, 1)] {
        for encoder in [true, false] {
            let set = |crd: i16, axes: Vec<usize>| {
                path(Path::Set { crd, axes, vel: 40.0, acc: 11.0, even_ms: 0, origin: None })
            };
            let to = |crd: i16, to: [i32; 2], end: f64| {
                path(Path::Line { crd, to: to.into(), speeds: Speeds { vel: 9.7, acc: 2.3, end }, fifo: 0 })
            };
            let entry = |crd, command| path(Path::Laser { crd, channel: 0, command, fifo: 0 });
            let mut calls: Vec<_> = [0, 1, 2, 3].map(|axis| plain(Kind::AxisOn, axis)).into();
            calls.extend([light(LightOf::Connector(true)), light(LightOf::Carrier(20.0))]);
            calls.extend([set(1, vec![0, 1]), set(2, vec![2, 3]), Call::Sleep { ns: 4 * MS }]);
            calls.push(entry(follows, Command::Source { encoder: !encoder, start: None }));
            calls.push(entry(follows, Command::Ratio([4.0, 3.0, 90.0])));
            calls.extend([entry(follows, Command::Gate(true)), to(follows, [150, 40], 0.0), to(enters, [31, 9], 5.0)]);
            calls.push(entry(enters, Command::Source { encoder, start: None }));
            calls.extend([to(enters, [90, 40], 0.0), path(Path::Start { mask: 3, option: 0 })]);
            calls.push(Call::Sleep { ns: 40 * MS });
            for tick_us in [250, 500, 1000] {
                agrees(tick_us, &calls);
            }
        }
    }
}
