//! Programs on which the reference was wrong about lasers, and the controller was right.
use super::found::{MS, agrees, frame, is_open, line, path, plain};
use host_tests::reference::{Call, Command, Kind, LightCall, LightOf, LightTable, Path};

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
