//! Work of every kind without end, in rounds of [`ROUND_TICKS`] ticks of 250 µs.
//!
//! These run together: a static PT loop and a PVT loop whose displacements are no binary fractions;
//! a Jog; an axis that follows; a stream of dynamic PT; Trap moves forth and back. A square runs
//! with a laser in velocity follow, in turn with and without look-ahead. The other laser is always
//! lit, its power by distance follow.
use client::{Call, Client, Options, Quiet};
use job::{Action, Files};
use virtual_board::{Shared, VirtualLink};

/// The servo tick, µs.
pub const TICK_US: u64 = 250;
/// 62.5 s: 125 passes of PT, 200 of PVT.
pub const ROUND_TICKS: u64 = 250_000;
/// Way of the stream of a round, pulses.
pub const STREAM_PULSES: f64 = 12.25;

/// What runs for ever.
pub const SETUP: &str = "
    GT_Reset(); GT_LoadConfig(\"none.toml\"); GT_ClrSts(1, 8);
    GT_AxisOn(1); GT_AxisOn(2); GT_AxisOn(3); GT_AxisOn(4); GT_AxisOn(5); GT_AxisOn(6); GT_AxisOn(7); GT_AxisOn(8);
    GT_PrfPt(1); GT_SetPtLoop(1, 0);
    GT_PtData(1, 100, 120); GT_PtData(1, 300.3, 333, PT_SEGMENT_EVEN); GT_PtData(1, 400.1, 500, PT_SEGMENT_STOP);
    double t[4] = {0, 62.5, 200.25, 312.5}; double p[4] = {0, 3.3, -1.7, 12.7}; double v[4] = {0, 0.07, -0.1, 0};
    GT_PrfPvt(2); GT_PvtTable(1, 4, t, p, v); GT_PvtTableSelect(2, 1); GT_SetPvtLoop(2, 0);
    TJogPrm jog; GT_PrfJog(3); jog.smooth = 0; jog.acc = 1; jog.dec = 1; GT_SetJogPrm(3, &jog); GT_SetVel(3, 0.7);
    GT_PrfFollow(4); GT_SetFollowMaster(4, 1); GT_SetFollowLoop(4, 0); GT_FollowData(4, 100, 37.5, FOLLOW_SEGMENT_EVEN);
    GT_FollowStart(8);
    GT_PtStart(1); GT_PvtStart(2); GT_Update(4);
    GT_PrfPt(8, PT_MODE_DYNAMIC); GT_SetPtMemory(8, 1);
    TTrapPrm trap; trap.velStart = 0; GT_PrfTrap(7); trap.acc = 0.5; trap.dec = 0.25; trap.smoothTime = 20; GT_SetTrapPrm(7, &trap); GT_SetVel(7, 13);
    TCrdPrm crd = {2, {0,0,0,0,0,0,0,0}, 10, 1, 0, 0, {0,0,0,0,0,0,0,0}}; crd.profile[4] = 1; crd.profile[5] = 2; crd.synVelMax = 100; crd.synAccMax = 10;
    crd.setOriginFlag = 1; GT_SetCrdPrm(1, &crd);
    GT_SetLaserCrdMap(0, 1); GT_SetLaserCrdMap(1, 0); GT_SetAxisMode(7, 1); GT_SetAxisMode(8, 1);
    GT_LaserPowerMode(0, 90, 1, 0); GT_LaserOutFrq(50, 0); GT_SetLevelDelay(40, 25, 0);
    GT_LaserPowerMode(1, 1000, 0, 1); GT_SetPulseWidth(1, 1); GT_LaserPrfCmd(100, 1);
    long ref[4] = {0, 0, 0, 0}; double scale[4] = {100000, 100000, 100000, 100000}; double ratio[4] = {0.001, 0.002, 0.001, 0.003};
    GT_SetLaserDisMode(1, 0, ref, scale, 1); GT_SetLaserDisRatio(ratio, 0, 900, 1);
    GT_SetHSIOOpt(1, 1);
";

struct Switches;

impl Files for Switches {
    fn text(&self, _: &str) -> Result<String, String> {
        Ok("[axis.1-8]\nlimits = \"none\"\nalarm = false\n".to_owned())
    }
}

pub fn calls(text: &str) -> Vec<Call> {
    let job = job::compile(text, &Switches).unwrap_or_else(|found| panic!("{found:?}"));
    let call = |action: &Action| match action {
        Action::Call(call) => Call { opcode: call.opcode, payload: call.body.clone(), may_fail: false },
        Action::WaitStop { core, axes, crds } => Call::of(protocol::command::WaitStop {
            core: (*core).into(),
            axes: axes.cast_signed().into(),
            crds: crds.cast_signed().into(),
        }),
        other => panic!("{other:?}"),
    };
    job.steps.iter().map(|step| call(&step.action)).collect()
}

/// The work of one round, which takes less than a round.
pub fn round(number: u64) -> String {
    let mut text = String::new();
    text += &format!("GT_InitLookAhead(1, 0, {}, 10, {});\n", number % 3, 40 * (number & 1));
    // The motion comes first: what is no motion would wait for the tick to tell where the path
    // rests.
    text += "GT_CrdClear(1, 0); GT_LnXY(1, 1, 0, 1, 0.1, 0, 0); GT_BufLaserFollowRatio(1, 20, 1, 90, 0, 0);\n";
    for (side, (x, y)) in [(100, 0), (100, 100), (0, 100), (0, 0)].repeat(60).into_iter().enumerate() {
        text +=
            if side % 2 == 0 { "GT_BufLaserOn(1, 0, 0);" } else { "GT_BufLaserOff(1, 0, 0); GT_BufDelay(1, 3, 0);" };
        text += &format!("GT_LnXY(1, {x}, {y}, 1, 0.1, 0.5, 0);\n");
    }
    text += "GT_BufLaserFollowOff(1, 0, 0); GT_CrdData(1, NULL, 0); GT_CrdStart(1, 0);\n";
    for segment in 1..=200 {
        let (pos, kind) = (STREAM_PULSES / 200.0 * f64::from(segment), if segment == 200 { 2 } else { segment % 2 });
        text += &format!("GT_PtData(8, {pos:?}, {}, {kind});\n", segment * 250);
    }
    text += "GT_PtStart(128);\n";
    for pos in [5000, -3000, 0] {
        text += &format!("GT_SetPos(7, {pos}); GT_Update(64); WaitStop(64);\n");
    }
    text + "WaitStop(192 | 256);\n"
}

/// A client of the board.
pub fn client(board: &Shared) -> Client {
    Client::open(Box::new(VirtualLink::new(board.clone())), Options::default()).unwrap()
}

/// Has it done, all of it.
pub fn run(client: &Client, text: &str) {
    let summary = client.run(calls(text), false, &mut Quiet).unwrap();
    assert_eq!(summary.failed, None);
}
