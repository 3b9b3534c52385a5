//! The reference by hand: sentences of SPEC 5 and what must follow.
use super::*;

const MS: i64 = 1_000_000;

fn setup() -> Setup {
    Setup { profile: "gus", family: Family::Gus, axes: vec![(1, 1), (1, 2)] }
}

/// At ticks of 1 ms from power-on.
fn ran(calls: &[Call]) -> Program {
    let program = Controller::new(&setup(), MS, &[0, 0]).run(calls, 50, 1000);
    assert_eq!(program.open, None);
    assert!(program.complete);
    program
}

fn plain(kind: Kind, axis: usize) -> Call {
    Call::Axis { kind, axis }
}

fn positions(program: &Program, axis: usize, ticks: &[usize]) -> Vec<f64> {
    ticks.iter().map(|tick| program.rows[*tick][axis].x.to_f64()).collect()
}

fn runs(program: &Program, axis: usize, tick: usize) -> bool {
    program.rows[tick][axis].status >> 10 & 1 == 1
}

fn pt(pos: f64, time_ms: i32, kind: i16) -> Call {
    Call::PtData { axis: 0, pos, time_ms, kind, fifo: 0 }
}

#[test]
fn pt_segments_of_each_kind_and_two_passes() {
    // 0 → 2 pulse/ms, 2 throughout, 2 → 0: each 4 ms.
    let program = ran(&[
        plain(Kind::AxisOn, 0),
        Call::PrfPt { axis: 0, mode: 0 },
        pt(4.0, 4, 0),
        pt(12.0, 8, 1),
        pt(16.0, 12, 2),
        Call::SetPtLoop { axis: 0, loops: 2 },
        Call::PtStart { mask: 1, option: 0 },
    ]);
    assert_eq!(positions(&program, 0, &[1, 3, 5, 7, 9, 11, 13, 25]), [0.0, 1.0, 4.0, 8.0, 12.0, 15.0, 16.0, 32.0]);
    assert!(runs(&program, 0, 24) && !runs(&program, 0, 25));
}

#[test]
fn a_jog_brakes_and_a_trap_turns() {
    // 2 pulse/ms after 2 ms and 2 pulses; a Stop at 5 ms of the motion, with 0.5 pulse/ms² over 4
    // pulses.
    let program = ran(&[
        plain(Kind::AxisOn, 0),
        plain(Kind::PrfJog, 0),
        Call::SetJogPrm { axis: 0, acc: 1.0, dec: 1.0 },
        Call::SetStopDec { axis: 0, smooth: 0.5 },
        Call::SetVel { axis: 0, vel: 2.0 },
        Call::Update { mask: 1 },
        Call::Sleep { ns: 5 * MS },
        Call::Stop { mask: 1, abrupt: 0 },
    ]);
    assert_eq!(positions(&program, 0, &[1, 3, 6, 8, 10, 11]), [0.0, 2.0, 8.0, 11.0, 12.0, 12.0]);
    // To 16 with 2 pulse/ms at most; at 4 ms, 6 pulses on, back to 2: rest at 8, then 6 pulses
    // back.
    let program = ran(&[
        plain(Kind::AxisOn, 0),
        Call::SetTrapPrm { axis: 0, acc: 1.0, dec: 1.0 },
        Call::SetPos { axis: 0, pos: 16 },
        Call::SetVel { axis: 0, vel: 2.0 },
        Call::Update { mask: 1 },
        Call::Sleep { ns: 4 * MS },
        Call::SetPos { axis: 0, pos: 2 },
        Call::Update { mask: 1 },
    ]);
    assert_eq!(positions(&program, 0, &[5, 7, 9, 10, 12]), [6.0, 8.0, 6.0, 4.0, 2.0]);
    assert!(runs(&program, 0, 11) && !runs(&program, 0, 12));
}

#[test]
fn a_slave_goes_back_and_one_of_one_way_does_not() {
    for (dir, there, back) in [(0, 8.0, 4.0), (1, 8.0, 8.0)] {
        let datum = Datum { master: 16.0, slave: 16.0, kind: 1, percent: 0 };
        let program = ran(&[
            plain(Kind::AxisOn, 0),
            plain(Kind::AxisOn, 1),
            Call::PrfFollow { axis: 1, dir },
            Call::SetFollowMaster { axis: 1, master: 0, kind: 2, item: 0 },
            Call::FollowData { axis: 1, datum, fifo: 0 },
            Call::FollowStart { mask: 2, option: 0 },
            Call::PrfPt { axis: 0, mode: 0 },
            pt(8.0, 8, 1),
            pt(4.0, 12, 1),
            Call::PtStart { mask: 1, option: 0 },
        ]);
        assert_eq!(positions(&program, 1, &[9, 13]), [there, back], "{dir}");
    }
}

#[test]
fn what_a_state_refuses() {
    let calls = [
        plain(Kind::PrfJog, 0),
        Call::Update { mask: 1 },
        plain(Kind::AxisOn, 0),
        Call::PrfPt { axis: 0, mode: 0 },
        Call::PtStart { mask: 1, option: 0 },
        pt(1.0, 0, 0),
        pt(1.0, 5, 0),
        pt(2.0, 5, 0),
        Call::PtStart { mask: 1, option: 0 },
        plain(Kind::ZeroPos, 0),
        Call::FollowStart { mask: 2, option: 0 },
    ];
    let code = |reply: &Reply| if let Reply::Code(code) = reply { *code } else { 0 };
    let codes: Vec<i16> = ran(&calls).replies.iter().map(code).collect();
    assert_eq!(codes, [0, 1, 0, 0, 1, 7, 0, 7, 0, 1, 1]);
}
