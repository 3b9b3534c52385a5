//! The calls of a program. How a job writes them is in `call/text.rs`.
mod text;

use super::effect::Effect;
use super::follow::{Datum, Item};
use super::light::{LightCall, LightTable};
use super::path::{Path, PathCall};
use super::pvt::Points;

/// Which axes a program has: logical core and axis of the core, both from 1. Calls name axes by
/// their index here.
#[derive(Debug, Clone, PartialEq)]
pub struct Setup {
    pub profile: &'static str,
    pub family: super::light::Family,
    pub axes: Vec<(i16, i16)>,
}

/// A call, or a step of the script clock. Masks are of indices in [`Setup`], all of one core.
#[derive(Debug, Clone, PartialEq)]
pub enum Call {
    Sleep {
        ns: i64,
    },
    WaitStop {
        mask: u32,
    },
    /// Between two programs: none holds it.
    SetTick {
        us: i32,
    },
    Axis {
        kind: Kind,
        axis: usize,
    },
    Stop {
        mask: u32,
        abrupt: u32,
    },
    SetPrfPos {
        axis: usize,
        pos: i32,
    },
    SetStopDec {
        axis: usize,
        smooth: f64,
    },
    SetEncPos {
        axis: usize,
        pos: i32,
    },
    SynchAxisPos {
        mask: u32,
    },
    /// In units of 250 µs.
    SetAxisBand {
        axis: usize,
        band: i32,
        time: i32,
    },
    SetPosErr {
        axis: usize,
        error: i32,
    },
    SetSoftLimit {
        axis: usize,
        positive: i32,
        negative: i32,
    },
    SetTrapPrm {
        axis: usize,
        acc: f64,
        dec: f64,
    },
    SetJogPrm {
        axis: usize,
        acc: f64,
        dec: f64,
    },
    SetPos {
        axis: usize,
        pos: i32,
    },
    SetVel {
        axis: usize,
        vel: f64,
    },
    Update {
        mask: u32,
    },
    PrfPt {
        axis: usize,
        mode: i16,
    },
    PtData {
        axis: usize,
        pos: f64,
        time_ms: i32,
        kind: i16,
        fifo: i16,
    },
    PtClear {
        axis: usize,
        fifo: i16,
    },
    PtSpace {
        axis: usize,
        fifo: i16,
    },
    SetPtLoop {
        axis: usize,
        loops: i32,
    },
    SetPtMemory {
        axis: usize,
        memory: i16,
    },
    PtStart {
        mask: u32,
        option: u32,
    },
    PrfFollow {
        axis: usize,
        dir: i16,
    },
    SetFollowMaster {
        axis: usize,
        master: usize,
        kind: i16,
        /// Of a master's axis: 0 planned, 2 planned and filtered, 3 encoder and filtered, else
        /// encoder.
        item: i16,
    },
    SetFollowLoop {
        axis: usize,
        loops: i32,
    },
    SetFollowEvent {
        axis: usize,
        event: i16,
        dir: i16,
        pos: i32,
    },
    FollowData {
        axis: usize,
        datum: Datum,
        fifo: i16,
    },
    FollowClear {
        axis: usize,
        fifo: i16,
    },
    FollowSpace {
        axis: usize,
        fifo: i16,
    },
    FollowStart {
        mask: u32,
        option: u32,
    },
    FollowSwitch {
        mask: u32,
    },
    SetFollowMemory {
        axis: usize,
        memory: i16,
    },
    /// A table of the core of this axis.
    PvtTable {
        axis: usize,
        table: i16,
        points: Points,
    },
    /// PvtPercentCalculate or PvtContinuousCalculate.
    PvtCalculate {
        core: i16,
        points: Points,
    },
    PvtTableSelect {
        axis: usize,
        table: i16,
    },
    /// GetFollowDataPercent2Ex: ratios at both ends, S-shape in all and at the beginning, percent.
    AsymmetricWay {
        core: i16,
        master: f64,
        ratios: [f64; 2],
        shares: [f64; 2],
    },
    SetPvtLoop {
        axis: usize,
        loops: i32,
    },
    PvtStart {
        mask: u32,
    },
    /// The call of FollowEx with the same parameters as this one of Follow.
    Ex(Box<Call>),
    /// FollowDataPercentEx, or an entry of FollowEx that is no segment.
    FollowEntry {
        axis: usize,
        item: Item,
        fifo: i16,
    },
    /// FollowSwitchNowEx with `buffer` 0.
    FollowSwitchNow {
        axis: usize,
        table: bool,
    },
    /// SimInput of an input of an axis.
    Terminal {
        axis: usize,
        kind: i16,
        level: bool,
    },
    /// LmtsOn and LmtsOff with types 0, 1 and −1, AlarmOn and AlarmOff with type 2.
    Guard {
        axis: usize,
        kind: i16,
        on: bool,
    },
    /// LmtSns: bits 0 and 1 are the positive and the negative limit switch of axis 1 of a core,
    /// and so on.
    Sense {
        core: i16,
        sense: u16,
    },
    /// SetCaptureMode.
    SetCapture {
        axis: usize,
        mode: i16,
    },
    /// Outputs and inputs.
    Effect(Effect),
    Light(LightCall),
    LightTable(LightTable),
    Abort {
        core: i16,
    },
    Reset {
        core: i16,
    },
    /// Coordinate systems.
    Path(PathCall),
}

/// Calls that name an axis and nothing else.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    AxisOn,
    AxisOff,
    ZeroPos,
    ClrSts,
    PrfTrap,
    PrfJog,
    PrfPvt,
    GetPvtLoop,
    GetPtLoop,
    GetFollowLoop,
    GetFollowStatus,
    GetFollowLoopEx,
    GetFollowStatusEx,
    GetFollowMemory,
    GetFollowMemoryEx,
    GetFollowEvent,
    GetFollowEventEx,
    GetFollowMaster,
    GetFollowMasterEx,
    GetTrapPrm,
    GetJogPrm,
    GetPos,
    GetVel,
    GetSoftLimit,
    GetStopDec,
    GetAxisBand,
    GetPosErr,
    GetPtMemory,
    PvtStatus,
    GetSts,
    GetStopReason,
    GetCaptureStatus,
    GetEncPos,
    GetEncVel,
    GetPrfPos,
    GetPrfVel,
    GetPrfAcc,
    GetPrfMode,
}

impl Call {
    /// Calls of its instant that fail are decided a tick late: docs/jobs.md.
    pub fn is_stop_or_wait(&self) -> bool {
        let of_path = |of: &PathCall| matches!(of.what, Path::Stop { .. } | Path::Wait { .. });
        match self {
            Call::Stop { .. } | Call::Abort { .. } | Call::WaitStop { .. } => true,
            Call::Path(of) => of_path(of),
            _ => false,
        }
    }

    /// Whether it is refused while an axis that it names moves.
    pub fn needs_rest(&self) -> bool {
        match self {
            Call::Axis { kind, .. } => matches!(kind, Kind::ZeroPos | Kind::PrfTrap | Kind::PrfJog | Kind::PrfPvt),
            Call::SetPrfPos { .. }
            | Call::PrfPt { .. }
            | Call::PtClear { .. }
            | Call::SetPtMemory { .. }
            | Call::PtStart { .. }
            | Call::PrfFollow { .. }
            | Call::SetFollowMaster { .. }
            | Call::FollowClear { .. }
            | Call::FollowStart { .. }
            | Call::FollowSwitch { .. }
            | Call::SetFollowMemory { .. }
            | Call::PvtTable { .. }
            | Call::PvtStart { .. } => true,
            Call::Ex(of) => of.needs_rest(),
            Call::Path(PathCall { what: Path::Set { .. }, .. }) => true,
            _ => false,
        }
    }

    /// The axes that it names.
    pub fn axes(&self) -> u32 {
        match self {
            Call::Ex(of) => return of.axes(),
            Call::Path(PathCall { what: Path::Set { axes, .. }, .. }) => {
                return axes.iter().fold(0, |mask, axis| mask | 1 << axis);
            }
            _ => {}
        }
        match *self {
            Call::Sleep { .. } | Call::SetTick { .. } | Call::Effect(_) | Call::Light(_) | Call::Ex(_) => 0,
            Call::LightTable(_) | Call::Sense { .. } | Call::PvtCalculate { .. } | Call::AsymmetricWay { .. } => 0,
            Call::Path(_) | Call::Abort { .. } | Call::Reset { .. } => 0,
            Call::WaitStop { mask }
            | Call::SynchAxisPos { mask }
            | Call::Stop { mask, .. }
            | Call::Update { mask }
            | Call::PtStart { mask, .. }
            | Call::FollowStart { mask, .. }
            | Call::FollowSwitch { mask }
            | Call::PvtStart { mask } => mask,
            Call::Axis { axis, .. }
            | Call::SetPrfPos { axis, .. }
            | Call::SetStopDec { axis, .. }
            | Call::SetEncPos { axis, .. }
            | Call::SetAxisBand { axis, .. }
            | Call::SetPosErr { axis, .. }
            | Call::SetSoftLimit { axis, .. }
            | Call::SetTrapPrm { axis, .. }
            | Call::SetJogPrm { axis, .. }
            | Call::SetPos { axis, .. }
            | Call::SetVel { axis, .. }
            | Call::PrfPt { axis, .. }
            | Call::PtData { axis, .. }
            | Call::PtClear { axis, .. }
            | Call::PtSpace { axis, .. }
            | Call::SetPtLoop { axis, .. }
            | Call::SetPtMemory { axis, .. }
            | Call::PrfFollow { axis, .. }
            | Call::SetFollowMaster { axis, .. }
            | Call::SetFollowLoop { axis, .. }
            | Call::SetFollowEvent { axis, .. }
            | Call::FollowData { axis, .. }
            | Call::FollowClear { axis, .. }
            | Call::FollowSpace { axis, .. }
            | Call::SetFollowMemory { axis, .. }
            | Call::PvtTable { axis, .. }
            | Call::PvtTableSelect { axis, .. }
            | Call::FollowEntry { axis, .. }
            | Call::FollowSwitchNow { axis, .. }
            | Call::Terminal { axis, .. }
            | Call::Guard { axis, .. }
            | Call::SetCapture { axis, .. }
            | Call::SetPvtLoop { axis, .. } => 1 << axis,
        }
    }
}

/// The axes of a mask, ascending.
pub fn members(mask: u32) -> impl Iterator<Item = usize> {
    (0..32).filter(move |axis| mask >> axis & 1 == 1)
}

impl Setup {
    /// The core of a mask's axes, and the mask as the call carries it.
    pub fn mask(&self, mask: u32) -> (i16, u32) {
        let core = members(mask).next().map_or(1, |axis| self.axes[axis].0);
        (core, members(mask).map(|axis| 1 << (self.axes[axis].1 - 1)).sum())
    }

    /// Master index and type of SetFollowMaster for a slave: 1 encoder, 2 profile and 3 axis, of
    /// the other core 101 and 103.
    pub fn master(&self, slave: usize, master: usize, kind: i16) -> (i16, i16) {
        let same = self.axes[slave].0 == self.axes[master].0;
        let other = if kind == 1 { 101 } else { 103 };
        (self.axes[master].1, if same { kind } else { other })
    }
}
