//! The calls of coordinate systems. Axes are named by their place in the set-up; crds and FIFOs are
//! those of a core.
use super::call::Setup;
use super::light::Command;
use crate::path_model::Plane;

/// A call.
#[derive(Debug, Clone, PartialEq)]
pub struct PathCall {
    pub core: i16,
    pub what: Path,
}

#[derive(Debug, Clone, PartialEq)]
pub enum Path {
    /// The axis of each coordinate; an origin, or where the axes are.
    Set {
        crd: i16,
        axes: Vec<usize>,
        vel: f64,
        acc: f64,
        even_ms: i16,
        origin: Option<Vec<i32>>,
    },
    GetPrm {
        crd: i16,
    },
    Clear {
        crd: i16,
        fifo: i16,
    },
    Space {
        crd: i16,
        fifo: i16,
    },
    Start {
        mask: i16,
        option: i16,
    },
    Stop {
        mask: i32,
        option: i32,
    },
    Status {
        crd: i16,
        fifo: i16,
    },
    Remainder {
        crd: i16,
        fifo: i16,
    },
    Pos {
        crd: i16,
    },
    Vel {
        crd: i16,
    },
    StopDec {
        crd: i16,
        smooth: f64,
    },
    Override {
        crd: i16,
        ratio: f64,
    },
    Line {
        crd: i16,
        to: Vec<i32>,
        speeds: Speeds,
        fifo: i16,
    },
    Arc {
        crd: i16,
        plane: Plane,
        to: [i32; 2],
        round: Cycle,
        ccw: bool,
        speeds: Speeds,
        fifo: i16,
    },
    Delay {
        crd: i16,
        ms: u16,
        fifo: i16,
    },
    Outputs {
        crd: i16,
        mask: u16,
        value: u16,
        fifo: i16,
    },
    /// BufDoBit, from 1.
    Output {
        crd: i16,
        index: i16,
        level: bool,
        fifo: i16,
    },
    /// LnXYG0.
    Jump {
        crd: i16,
        to: [i32; 2],
        vel: f64,
        acc: f64,
        fifo: i16,
    },
    /// BufDA.
    Analog {
        crd: i16,
        dac: i16,
        value: i16,
        fifo: i16,
    },
    /// BufMove.
    Move {
        crd: i16,
        axis: usize,
        to: i32,
        vel: f64,
        acc: f64,
        modal: i16,
        fifo: i16,
    },
    /// BufGear.
    Gear {
        crd: i16,
        axis: usize,
        pulses: i32,
        fifo: i16,
    },
    /// BufLaserOn, BufLaserOff, BufLaserPrfCmd.
    Laser {
        crd: i16,
        channel: i16,
        command: Command,
        fifo: i16,
    },
    /// InitLookAhead: T, ms, and accMax.
    LookAhead {
        crd: i16,
        fifo: i16,
        time: f64,
        acc: f64,
        count: i16,
    },
    /// SetCrdLimit of a coordinate, from 1; 0: none.
    Limit {
        crd: i16,
        coordinate: i16,
        vel: f64,
        acc: f64,
    },
    /// SetLaserFollowFilter and GetLaserFollowFilter.
    Filter {
        crd: i16,
        ms: f64,
    },
    GetFilter {
        crd: i16,
    },
    /// GetCrdStopReason.
    Why {
        crd: i16,
    },
    /// CrdData without data.
    Flush {
        crd: i16,
        fifo: i16,
    },
    /// WaitStop of coordinate systems.
    Wait {
        mask: u32,
    },
}

/// synVel, synAcc, velEnd.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Speeds {
    pub vel: f64,
    pub acc: f64,
    pub end: f64,
}

/// What an arc is around.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cycle {
    Radius(f64),
    /// From the start.
    Centre(f64, f64),
}

impl Path {
    /// The coordinate system that a read names.
    pub fn crd(&self) -> i16 {
        match *self {
            Path::GetPrm { crd }
            | Path::Space { crd, .. }
            | Path::Status { crd, .. }
            | Path::Remainder { crd, .. }
            | Path::Pos { crd }
            | Path::Why { crd }
            | Path::Vel { crd } => crd,
            _ => 0,
        }
    }
}

impl PathCall {
    /// The elements of TCrdPrm.
    pub fn profile(setup: &Setup, axes: &[usize]) -> [i16; 8] {
        let mut profile = [0; 8];
        for (coordinate, axis) in axes.iter().enumerate() {
            profile[setup.axes[*axis].1 as usize - 1] = coordinate as i16 + 1;
        }
        profile
    }

    /// originPos by the axis.
    pub fn origins(setup: &Setup, axes: &[usize], origin: &[i32]) -> [i32; 8] {
        let mut origins = [0; 8];
        for (axis, at) in axes.iter().zip(origin) {
            origins[setup.axes[*axis].1 as usize - 1] = *at;
        }
        origins
    }

    /// A statement of a job.
    pub fn text(&self, setup: &Setup) -> String {
        let core = self.core;
        let tail = |speeds: &Speeds, fifo: i16| {
            let Speeds { vel, acc, end } = speeds;
            format!("{vel:?},{acc:?},{end:?},{fifo})")
        };
        let call = match &self.what {
            Path::Set { crd, axes, vel, acc, even_ms, origin } => {
                let mut text = format!("prm.dimension = {}; ", axes.len());
                for (index, coordinate) in PathCall::profile(setup, axes).iter().enumerate() {
                    text += &format!("prm.profile[{index}] = {coordinate}; ");
                }
                if let Some(origin) = origin {
                    for (index, at) in PathCall::origins(setup, axes, origin).iter().enumerate() {
                        text += &format!("prm.originPos[{index}] = {at}; ");
                    }
                }
                text += &format!("prm.synVelMax = {vel:?}; prm.synAccMax = {acc:?}; prm.evenTime = {even_ms}; ");
                text += &format!("prm.setOriginFlag = {}; ", i16::from(origin.is_some()));
                return text + &format!("rtn = GTN_SetCrdPrm({core},{crd},&prm);");
            }
            Path::Wait { mask } => return format!("WaitStop({core},0,{mask});"),
            Path::GetPrm { crd } => format!("GTN_GetCrdPrm({core},{crd},&prm)"),
            Path::Clear { crd, fifo } => format!("GTN_CrdClear({core},{crd},{fifo})"),
            Path::Space { crd, fifo } => format!("GTN_CrdSpace({core},{crd},&word,{fifo})"),
            Path::Start { mask, option } => format!("GTN_CrdStart({core},{mask},{option})"),
            Path::Stop { mask, option } => format!("GTN_CrdStop({core},{mask},{option})"),
            Path::Status { crd, fifo } => format!("GTN_CrdStatus({core},{crd},&fifo,&word,{fifo})"),
            Path::Remainder { crd, fifo } => format!("GTN_GetRemainderSegNum({core},{crd},&word,{fifo})"),
            Path::Pos { crd } => format!("GTN_GetCrdPos({core},{crd},&place[0])"),
            Path::Vel { crd } => format!("GTN_GetCrdVel({core},{crd},&value)"),
            Path::StopDec { crd, smooth } => format!("GTN_SetCrdStopDec({core},{crd},{smooth:?},1000)"),
            Path::Override { crd, ratio } => format!("GTN_SetOverride({core},{crd},{ratio:?})"),
            Path::Line { crd, to, speeds, fifo } => {
                let name = ["XY", "XYZ", "XYZA"][to.len() - 2];
                let to: String = to.iter().map(|x| format!("{x},")).collect();
                format!("GTN_Ln{name}({core},{crd},{to}{}", tail(speeds, *fifo))
            }
            Path::Arc { crd, plane, to, round, ccw, speeds, fifo } => {
                let around = match round {
                    Cycle::Radius(radius) => format!("{radius:?}"),
                    Cycle::Centre(x, y) => format!("{x:?},{y:?}"),
                };
                let kind = if matches!(round, Cycle::Radius(_)) { "R" } else { "C" };
                let (to, ccw) = (format!("{},{}", to[0], to[1]), i16::from(*ccw));
                format!("GTN_Arc{plane:?}{kind}({core},{crd},{to},{around},{ccw},{}", tail(speeds, *fifo))
            }
            Path::Delay { crd, ms, fifo } => format!("GTN_BufDelay({core},{crd},{ms},{fifo})"),
            Path::Outputs { crd, mask, value, fifo } => format!("GTN_BufIO({core},{crd},12,{mask},{value},{fifo})"),
            Path::LookAhead { crd, fifo, time, acc, count } => {
                format!("GTN_InitLookAhead({core},{crd},{fifo},{time:?},{acc:?},{count},NULL)")
            }
            Path::Limit { crd, coordinate, vel, acc } => {
                format!("GTN_SetCrdLimit({core},{crd},{coordinate},{vel:?},{acc:?})")
            }
            Path::Filter { crd, ms } => format!("GTN_SetLaserFollowFilter({core},{crd},{ms:?})"),
            Path::GetFilter { crd } => format!("GTN_GetLaserFollowFilter({core},{crd},&value)"),
            Path::Why { crd } => format!("GTN_GetCrdStopReason({core},{crd},&space)"),
            Path::Flush { crd, fifo } => format!("GTN_CrdData({core},{crd},NULL,{fifo})"),
            Path::Output { crd, index, level, fifo } => {
                // An unsigned short, as it travels.
                let index = index.cast_unsigned();
                format!("GTN_BufDoBit({core},{crd},12,{index},{},{fifo})", i16::from(*level))
            }
            Path::Jump { crd, to: [x, y], vel, acc, fifo } => {
                format!("GTN_LnXYG0({core},{crd},{x},{y},{vel:?},{acc:?},{fifo})")
            }
            Path::Laser { crd, channel, command, fifo } => match command {
                Command::Gate(true) => format!("GTN_BufLaserOn({core},{crd},{fifo},{channel})"),
                Command::Gate(false) => format!("GTN_BufLaserOff({core},{crd},{fifo},{channel})"),
                Command::Power(power) => format!("GTN_BufLaserPrfCmd({core},{crd},{power:?},{fifo},{channel})"),
                Command::Source { encoder, start } => {
                    let start = start.map_or(String::new(), |start| format!(",{start:?}"));
                    let source = i16::from(*encoder);
                    format!("GTN_BufLaserFollowMode({core},{crd},{source},{fifo},{channel}{start})")
                }
                Command::Ratio([ratio, min, max]) => {
                    format!("GTN_BufLaserFollowRatio({core},{crd},{ratio:?},{min:?},{max:?},{fifo},{channel})")
                }
                Command::Follow(ratio, [min, max]) => {
                    format!("GTN_BufLaserPrfFollow({core},{crd},{ratio:?},{min},{max},{fifo},{channel})")
                }
                Command::Table(table, [min, max]) => {
                    format!("GTN_BufLaserFollowTable({core},{crd},{table},{min:?},{max:?},{fifo},{channel})")
                }
                Command::FollowOff => format!("GTN_BufLaserFollowOff({core},{crd},{fifo},{channel})"),
            },
            Path::Analog { crd, dac, value, fifo } => format!("GTN_BufDA({core},{crd},{dac},{value},{fifo})"),
            Path::Move { crd, axis, to, vel, acc, modal, fifo } => {
                let axis = setup.axes[*axis].1;
                format!("GTN_BufMove({core},{crd},{axis},{to},{vel:?},{acc:?},{modal},{fifo})")
            }
            Path::Gear { crd, axis, pulses, fifo } => {
                format!("GTN_BufGear({core},{crd},{},{pulses},{fifo})", setup.axes[*axis].1)
            }
        };
        format!("rtn = {call};")
    }
}
