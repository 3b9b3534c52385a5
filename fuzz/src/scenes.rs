//! Work that takes many requests in the right order, so that inputs get there: job scripts,
//! compiled once.
use job::{Action, Files};
use protocol::command::{Request, Sleep, WaitStop};
use std::sync::OnceLock;
use zerocopy::IntoBytes;

/// A request: its number and its body.
pub type Call = (u16, Vec<u8>);

/// Coordinate system 2 and axes 7 and 8 are the model's: what it compares is entered there.
pub const WITNESS: &str = "
    GT_PrfPt(8); GT_SetPtMemory(8, 1);
    TCrdPrm crd = {1, {0,0,0,0,0,0,0,0}, 10, 1, 0, 0, {0,0,0,0,0,0,0,0}}; crd.profile[6] = 1; crd.synVelMax = 10; crd.synAccMax = 1; GT_SetCrdPrm(2, &crd);
    GT_AlarmOff(7); GT_LmtsOff(7); GT_AxisOn(7); GT_InitLookAhead(2, 1, 1, 1, 20);
";

const SCENES: [&str; 8] = [
    // A lit path with velocity follow.
    "GT_AlarmOff(1); GT_AlarmOff(2); GT_LmtsOff(1); GT_LmtsOff(2); GT_ClrSts(1, 2); GT_AxisOn(1); GT_AxisOn(2);
     TCrdPrm crd = {2, {0,0,0,0,0,0,0,0}, 10, 1, 0, 0, {0,0,0,0,0,0,0,0}}; crd.profile[0] = 1; crd.profile[1] = 2; crd.synVelMax = 100; crd.synAccMax = 10;
     GT_SetCrdPrm(1, &crd); GT_SetLaserCrdMap(0, 1); GT_LaserPowerMode(0, 90, 1, 0); GT_LaserOutFrq(50, 0);
     GT_SetLevelDelay(40, 25, 0); GT_SetAxisMode(7, 1); GT_CrdClear(1, 0); GT_BufLaserOn(1, 0, 0); GT_BufLaserPrfFollow(1, 20, 1, 90, 0, 0);
     GT_LnXY(1, 100, 0, 4, 1, 1, 0); GT_BufIO(1, 12, 3, 1, 0); GT_ArcXYC(1, 100, 100, 0, 50, 1, 4, 1, 2, 0);
     GT_BufLaserOff(1, 0, 0); GT_BufDelay(1, 3, 0); GT_BufLaserOn(1, 0, 0); GT_LnXY(1, 0, 0, 4, 1, 0, 0); GT_CrdStart(1, 0);",
    // A PT loop and a PVT loop.
    "GT_AlarmOff(3); GT_AlarmOff(4); GT_LmtsOff(3); GT_LmtsOff(4); GT_ClrSts(3, 2); GT_AxisOn(3); GT_AxisOn(4);
     GT_PrfPt(3); GT_PtClear(3); GT_SetPtLoop(3, 0); GT_PtData(3, 10, 5); GT_PtData(3, 30, 15, 1); GT_PtData(3, 40.5, 20, 2);
     double t[3] = {0, 4.5, 13}; double p[3] = {0, 3, 1.5}; double v[3] = {0, 1, 0}; GT_PrfPvt(4); GT_PvtTable(1, 3, t, p, v);
     GT_PvtTableSelect(4, 1); GT_SetPvtLoop(4, 0); GT_PtStart(4); GT_PvtStart(8);",
    // A Jog, and who follows it.
    "GT_AlarmOff(5); GT_AlarmOff(6); GT_LmtsOff(5); GT_LmtsOff(6); GT_ClrSts(5, 2); GT_AxisOn(5); GT_AxisOn(6);
     TJogPrm jog; GT_PrfJog(5); jog.smooth = 0; jog.acc = 1; jog.dec = 0.5; GT_SetJogPrm(5, &jog); GT_SetVel(5, 20); GT_Update(16);
     GT_PrfFollowEx(6); GT_SetFollowMasterEx(6, 5); GT_SetFollowLoopEx(6, 0); GT_FollowDataPercentEx(6, 100, 30, 0, 50);
     GT_FollowDoBitEx(6, 12, 5, 1); GT_FollowDataPercentEx(6, 150, 60, 2, 0); GT_FollowDelayEx(6, 8); GT_FollowStartEx(32);",
    // A laser of its own, in frequency mode, by distance.
    "GT_SetAxisMode(8, 1); GT_LaserPowerMode(1, 1000, 0, 1); GT_SetPulseWidth(3, 1); GT_LaserPrfCmd(100, 1);
     long ref[4] = {0, 0, 0, 0}; double scale[4] = {100, 100, 100, 100}; double ratio[4] = {0.1, 0.2, 0.1, 0.3};
     GT_SetLaserDisMode(1, 0, ref, scale, 1); GT_SetLaserDisRatio(ratio, 0, 900, 1); GT_SetHSIOOpt(1, 1);",
    // The same in analog mode with pre-voltage; FPK on the other channel.
    "GT_LaserPowerMode(2, 10, 0, 1); GT_SetPreVltg(1, 1.5, 1); GT_LaserPrfCmd(4, 1); GT_SetHSIOOpt(1, 1); GT_EnaFPK(5, 7, 30, 0);
     GT_SetAxisMode(7, 1); GT_LaserOutFrq(100, 0);
     GT_LaserPrfCmd(30, 0); GT_SetHSIOOpt(1, 0);",
    // A dynamic stream.
    "GT_AlarmOff(3); GT_LmtsOff(3); GT_ClrSts(3, 1); GT_AxisOn(3); GT_PrfPt(3, 1); GT_PtData(3, 10, 5); GT_PtData(3, 30, 15, 1);
     GT_PtData(3, 35, 25); GT_PtData(3, 40, 40, 1); GT_PtStart(4);",
    // A path by look-ahead, with an axis that is moved and one that goes along.
    "GT_AlarmOff(1); GT_AlarmOff(2); GT_AlarmOff(3); GT_AlarmOff(4); GT_LmtsOff(1); GT_LmtsOff(2); GT_LmtsOff(3); GT_LmtsOff(4);
     GT_ClrSts(1, 4); GT_AxisOn(1); GT_AxisOn(2); GT_AxisOn(3); GT_AxisOn(4); TCrdPrm crd = {2, {0,0,0,0,0,0,0,0}, 10, 1, 0, 0, {0,0,0,0,0,0,0,0}};
     crd.profile[0] = 1; crd.profile[1] = 2; crd.synVelMax = 100; crd.synAccMax = 10; GT_SetCrdPrm(1, &crd);
     GT_CrdClear(1, 1); GT_InitLookAhead(1, 1, 1, 10, 20); GT_LnXY(1, 30, 5, 4, 1, 0, 1); GT_BufMove(1, 3, 40, 2, 0.5, 0, 1);
     GT_BufGear(1, 4, 20, 1); GT_LnXY(1, 60, 5, 4, 1, 0, 1); GT_LnXY(1, 90, 15, 4, 1, 0, 1); GT_BufDA(1, 1, 100, 1);
     GT_LnXY(1, 90, 45, 4, 1, 0, 1); GT_LnXY(1, 0, 0, 4, 1, 0, 1); GT_CrdData(1, NULL, 1); GT_CrdStart(1, 1);",
    // A Trap with waits; limits that may be hit.
    "GT_AlarmOff(6); GT_LmtsOff(6); GT_SetSoftLimit(6, 200, -200); GT_ClrSts(6, 1); GT_AxisOn(6); TTrapPrm trap; trap.velStart = 0; GT_PrfTrap(6);
     trap.acc = 0.5; trap.dec = 0.25; trap.smoothTime = 5; GT_SetTrapPrm(6, &trap); GT_SetVel(6, 5); GT_SetPos(6, 150);
     GT_Update(32);",
];

/// Every axis is ready for tables of another kind.
const READY: &str = "
    GT_AlarmOff(1); GT_AlarmOff(2); GT_AlarmOff(3); GT_AlarmOff(4); GT_AlarmOff(5); GT_AlarmOff(6); GT_AlarmOff(7); GT_AlarmOff(8);
    GT_LmtsOff(1); GT_LmtsOff(2); GT_LmtsOff(3); GT_LmtsOff(4); GT_LmtsOff(5); GT_LmtsOff(6); GT_LmtsOff(7); GT_LmtsOff(8);
    GT_SetAxisMode(7, 1); GT_ClrSts(1, 8); GT_AxisOn(1); GT_AxisOn(2); GT_AxisOn(3); GT_AxisOn(4); GT_AxisOn(5); GT_AxisOn(6); GT_AxisOn(7); GT_AxisOn(8);
    GT_PrfPvt(1); GT_PrfPvt(2); GT_PrfPt(3); GT_SetPtMemory(3, 1); GT_PrfPt(4, 1); TJogPrm jog; GT_PrfJog(8); jog.smooth = 0; jog.acc = 1; jog.dec = 1;
    GT_SetJogPrm(8, &jog); GT_SetVel(8, 20); GT_Update(128); GT_PrfFollow(5); GT_SetFollowMaster(5, 8); GT_PrfFollowEx(6);
    GT_SetFollowMasterEx(6, 8); TCrdPrm crd = {1, {0,0,0,0,0,0,0,0}, 10, 1, 0, 0, {0,0,0,0,0,0,0,0}}; crd.profile[6] = 1; crd.synVelMax = 1000; crd.synAccMax = 100;
    GT_SetCrdPrm(1, &crd); GT_SetLaserCrdMap(0, 1); GT_LaserOutFrq(50, 0);
    GT_SetPvtLoop(1, 0); GT_SetPvtLoop(2, 2); GT_SetPtLoop(3, 3); GT_SetFollowLoop(5, 0); GT_SetFollowLoopEx(6, 2);
";

/// Starts of what was sent for them.
const STARTS: [&str; 8] = [
    "GT_PvtTableSelect(1, 1); GT_PvtTableSelect(2, 2); GT_PvtStart(3);",
    "GT_PtStart(12);",
    "GT_FollowStart(16);",
    "GT_FollowStartEx(32);",
    "GT_CrdData(1, NULL, 0); GT_CrdStart(1, 0);",
    "GT_BufLaserFollowTable(1, 1, 0, 100, 0, 0); GT_BufLaserOn(1, 0, 0); GT_LnXY(1, 500, 0, 10, 1, 0, 0); GT_CrdStart(1, 0);",
    "long ref[4] = {0, 5, -7, 0}; double scale[4] = {100, 10, 1, 100}; GT_SetLaserDisMode(1, 0, ref, scale, 0);
     GT_LaserPrfCmd(40, 0); GT_SetHSIOOpt(1, 0);",
    "GT_Stop(1023, 0);",
];

struct Nowhere;

impl Files for Nowhere {
    fn text(&self, path: &str) -> Result<String, String> {
        Err(format!("{path} is not there"))
    }
}

/// The requests of a script.
pub fn compiled(text: &str) -> Vec<Call> {
    let job = job::compile(text, &Nowhere).unwrap_or_else(|found| panic!("{found:?}"));
    let call = |action: &Action| match action {
        Action::Call(call) => (call.opcode, call.body.clone()),
        Action::Sleep { ns } => (Sleep::OPCODE, Sleep { ns: (*ns).into() }.as_bytes().to_vec()),
        Action::WaitStop { core, axes, crds } => {
            let wait =
                WaitStop { core: (*core).into(), axes: axes.cast_signed().into(), crds: crds.cast_signed().into() };
            (WaitStop::OPCODE, wait.as_bytes().to_vec())
        }
        Action::WaitAll => panic!("a scene names what it waits for"),
    };
    job.steps.iter().map(|step| call(&step.action)).collect()
}

/// The requests of a scene.
pub fn scene(number: usize) -> &'static [Call] {
    static ALL: OnceLock<Vec<Vec<Call>>> = OnceLock::new();
    let all = ALL.get_or_init(|| SCENES.iter().map(|text| compiled(text)).collect());
    &all[number % all.len()]
}

/// The requests that make every axis ready for tables.
pub fn ready() -> &'static [Call] {
    static ALL: OnceLock<Vec<Call>> = OnceLock::new();
    ALL.get_or_init(|| compiled(READY))
}

/// The requests that start something of it.
pub fn starts(number: usize) -> &'static [Call] {
    static ALL: OnceLock<Vec<Vec<Call>>> = OnceLock::new();
    let all = ALL.get_or_init(|| STARTS.iter().map(|text| compiled(text)).collect());
    &all[number % all.len()]
}

/// The requests that make place for the model's.
pub fn witness() -> &'static [Call] {
    static ALL: OnceLock<Vec<Call>> = OnceLock::new();
    ALL.get_or_init(|| compiled(WITNESS))
}
