//! The table of the manuals' names: functions, parameters with defaults, constants, and the request
//! that each function becomes. Only here a script's names are mapped to the protocol's.
//!
//! Source: API.md (prototypes, constants). Parameters have the order of the request's fields; where
//! the two differ, [`Shape`] says how. A function whose request has no layout is listed by its name
//! alone, so that a script that calls it gets a clear error.

pub use crate::value::Type;
use protocol::command::{self as c, Request};
use protocol::values::{io, master};

/// What a parameter is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pass {
    /// A value.
    In(Type),
    /// The address of a variable, or of the first of `count`, that the reply fills.
    Out,
    /// The first of as many values as the size says, which become items.
    Many(Type, Size),
    /// The first of so many values, which go into the request one by one. With a default it may be NULL: zeros.
    Fixed(Type, usize),
    /// The address of a struct whose values the request takes.
    Struct(Type),
    /// The same, or NULL.
    StructOrNull(Type),
    /// The address of a struct that the reply fills.
    OutStruct(Type),
    /// An array that the manuals' library works in; nothing travels.
    Working,
    /// A text.
    Text,
}

/// How many values an array has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Size {
    /// `count`.
    Count,
    /// `count` for each of so many axes.
    Each(usize),
    /// The first value of the array `count`.
    Columns,
    /// Its second.
    Rows,
    /// Their product.
    Grid,
}

/// One parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Param {
    /// Name, as the manuals have it without its Hungarian letter.
    pub name: &'static str,
    /// What it is.
    pub pass: Pass,
    /// Its value where a script leaves it out. An `Out` with a default is NULL then.
    pub default: Option<i32>,
}

impl Param {
    const fn or(self, default: i32) -> Self {
        Param { default: Some(default), ..self }
    }
}

const fn param(name: &'static str, pass: Pass) -> Param {
    Param { name, pass, default: None }
}
const fn short(name: &'static str) -> Param {
    param(name, Pass::In(Type::Short))
}
const fn ushort(name: &'static str) -> Param {
    param(name, Pass::In(Type::UShort))
}
const fn long(name: &'static str) -> Param {
    param(name, Pass::In(Type::Long))
}
const fn double(name: &'static str) -> Param {
    param(name, Pass::In(Type::Double))
}
const fn ulong(name: &'static str) -> Param {
    param(name, Pass::In(Type::ULong))
}
const fn out(name: &'static str) -> Param {
    param(name, Pass::Out)
}

const fn array(name: &'static str) -> Param {
    param(name, Pass::Many(Type::Double, Size::Count))
}
const fn sized(name: &'static str, of: Type, size: Size) -> Param {
    param(name, Pass::Many(of, size))
}
const fn fixed(name: &'static str, of: Type, length: usize) -> Param {
    param(name, Pass::Fixed(of, length))
}

const TABLE: Param = short("tableId");
const POINTS: Param = long("count");
const PROFILE: Param = short("profile");
const AXIS: Param = short("axis");
const MASK: Param = long("mask");
const FIFO: Param = short("fifo").or(0);
const CHANNEL: Param = short("channel").or(0);
const COUNT: Param = short("count").or(1);
const CLOCK: Param = out("clock").or(0);
/// The host's text of a reason, and the room that there is for it.
const REASON_TEXT: Param = out("text").or(0);
const REASON_SIZE: Param = short("size").or(0);
const CRD: Param = short("crd");
const X: Param = long("x");
const Y: Param = long("y");
const Z: Param = long("z");
const VEL: Param = double("synVel");
const ACC: Param = double("synAcc");
const VEL_END: Param = double("velEnd").or(0);
const RADIUS: Param = double("radius");
const DIR: Param = short("circleDir");

/// How parameters become a request. Fields of a request that no parameter fills: `core`, `form` (0 `GTN_`, 1 `GT_`),
/// `first` (0) and `…_given` (see [`Function::told`]).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// The request's other fields are the parameters that go in, in order; a `count` that no parameter fills is 1.
    Plain,
    /// As `Plain` without the arrays; the items, a value of each array in turn, follow the request.
    Points,
    /// As `Plain` without the struct, of which an item follows the request unless it is NULL.
    Point,
    /// As `Points`, but the arrays follow one after the other, the first one last.
    Grid,
    /// The configuration file's items.
    Config,
    /// Done by the host (opening, closing, the last reason): nothing is sent.
    Host,
    /// Two arrays of axes and options become the masks of `PtStart`.
    StartList,
}

/// A function that scripts may call.
#[derive(Debug, Clone, Copy)]
pub struct Function {
    /// Name without `GT_` or `GTN_`.
    pub name: &'static str,
    /// Number of its request; 0 for `Shape::Host`.
    pub opcode: u16,
    /// Parameters without `core`.
    pub params: &'static [Param],
    /// How they travel.
    pub shape: Shape,
    /// The parameter for which the request says whether it was given.
    pub told: Option<&'static str>,
}

const fn call(name: &'static str, opcode: u16, params: &'static [Param]) -> Function {
    shaped(Shape::Plain, name, opcode, params)
}
const fn shaped(shape: Shape, name: &'static str, opcode: u16, params: &'static [Param]) -> Function {
    Function { name, opcode, params, shape, told: None }
}

/// Every function that has a request, or that the host answers.
pub const FUNCTIONS: &[Function] = &[
    // -- session -----------------------------------------------------------------------------------
    shaped(Shape::Host, "Open", 0, &[short("channel").or(0), short("param").or(1)]),
    shaped(Shape::Host, "Close", 0, &[]),
    shaped(Shape::Host, "GetLastReason", 0, &[out("text"), short("size")]),
    call("Reset", c::Reset::OPCODE, &[]),
    shaped(Shape::Config, "LoadConfig", c::LoadConfig::OPCODE, &[param("file", Pass::Text)]),
    call("ClrSts", c::ClrSts::OPCODE, &[AXIS, COUNT]),
    call("GetVersion", c::Version::OPCODE, &[out("version")]),
    call("GetClock", c::GetClock::OPCODE, &[out("clock"), out("loop").or(0)]),
    call("SetTick", c::SetTick::OPCODE, &[long("tickUs")]),
    call("SetLinkLoss", c::SetLinkLoss::OPCODE, &[long("timeMs"), short("stopAll")]),
    call("GetLinkLoss", c::GetLinkLoss::OPCODE, &[out("ms"), out("stopAll")]),
    call("SetInterlock", c::SetInterlock::OPCODE, &[short("motion")]),
    call("Abort", c::Abort::OPCODE, &[]),
    // -- axis --------------------------------------------------------------------------------------
    call("AxisOn", c::AxisOn::OPCODE, &[AXIS]),
    call("AxisOff", c::AxisOff::OPCODE, &[AXIS]),
    call("Stop", c::Stop::OPCODE, &[MASK, long("option")]),
    call("ZeroPos", c::ZeroPos::OPCODE, &[AXIS, COUNT]),
    call("SetPrfPos", c::SetPrfPos::OPCODE, &[PROFILE, long("pos")]),
    call("SynchAxisPos", c::SynchAxisPos::OPCODE, &[MASK]),
    call("SetStopDec", c::SetStopDec::OPCODE, &[PROFILE, double("decSmoothStop"), double("decAbruptStop")]),
    call("GetStopDec", c::GetStopDec::OPCODE, &[PROFILE, out("decSmoothStop"), out("decAbruptStop")]),
    call("SetAxisBand", c::SetAxisBand::OPCODE, &[AXIS, long("band"), long("time")]),
    call("GetAxisBand", c::GetAxisBand::OPCODE, &[AXIS, out("band"), out("time")]),
    call("GetSts", c::GetSts::OPCODE, &[AXIS, out("sts"), COUNT, CLOCK]),
    call("GetStopReason", c::AxisStatus::OPCODE, &[AXIS, out("reason"), REASON_TEXT, REASON_SIZE]),
    call("GetPrfPos", c::GetPrfPos::OPCODE, &[PROFILE, out("value"), COUNT, CLOCK]),
    call("GetPrfVel", c::GetPrfVel::OPCODE, &[PROFILE, out("value"), COUNT, CLOCK]),
    call("GetPrfAcc", c::GetPrfAcc::OPCODE, &[PROFILE, out("value"), COUNT, CLOCK]),
    call("GetPrfMode", c::GetPrfMode::OPCODE, &[PROFILE, out("value"), COUNT, CLOCK]),
    call("GetEncPos", c::GetEncPos::OPCODE, &[short("encoder"), out("value"), COUNT, CLOCK]),
    call("GetEncVel", c::GetEncVel::OPCODE, &[short("encoder"), out("value"), COUNT, CLOCK]),
    call("SetEncPos", c::SetEncPos::OPCODE, &[short("encoder"), long("pos")]),
    call("SetSoftLimit", c::SetSoftLimit::OPCODE, &[AXIS, long("positive"), long("negative")]),
    call("GetSoftLimit", c::GetSoftLimit::OPCODE, &[AXIS, out("positive"), out("negative")]),
    call("LmtsOn", c::LmtsOn::OPCODE, &[AXIS, short("limitType").or(-1)]),
    call("LmtsOff", c::LmtsOff::OPCODE, &[AXIS, short("limitType").or(-1)]),
    call("LmtSns", c::LmtSns::OPCODE, &[ushort("sense")]),
    call("AlarmOn", c::AlarmOn::OPCODE, &[AXIS]),
    call("AlarmOff", c::AlarmOff::OPCODE, &[AXIS]),
    call("SetPosErr", c::SetPosErr::OPCODE, &[short("control"), long("error")]),
    call("GetPosErr", c::GetPosErr::OPCODE, &[short("control"), out("error")]),
    call("SetCaptureMode", c::SetCaptureMode::OPCODE, &[short("encoder"), short("mode")]),
    call(
        "GetCaptureStatus",
        c::GetCaptureStatus::OPCODE,
        &[short("encoder"), out("status"), out("value"), COUNT, CLOCK],
    ),
    // -- trap and jog ------------------------------------------------------------------------------
    call("PrfTrap", c::PrfTrap::OPCODE, &[PROFILE]),
    call("SetTrapPrm", c::SetTrapPrm::OPCODE, &[PROFILE, param("prm", Pass::Struct(Type::Trap))]),
    call("GetTrapPrm", c::GetTrapPrm::OPCODE, &[PROFILE, param("prm", Pass::OutStruct(Type::Trap))]),
    call("PrfJog", c::PrfJog::OPCODE, &[PROFILE]),
    call("SetJogPrm", c::SetJogPrm::OPCODE, &[PROFILE, param("prm", Pass::Struct(Type::Jog))]),
    call("GetJogPrm", c::GetJogPrm::OPCODE, &[PROFILE, param("prm", Pass::OutStruct(Type::Jog))]),
    call("SetPos", c::SetPos::OPCODE, &[PROFILE, long("pos")]),
    call("GetPos", c::GetPos::OPCODE, &[PROFILE, out("pos")]),
    call("SetVel", c::SetVel::OPCODE, &[PROFILE, double("vel")]),
    call("GetVel", c::GetVel::OPCODE, &[PROFILE, out("vel")]),
    call("Update", c::Update::OPCODE, &[MASK]),
    // -- digital and analog inputs and outputs -----------------------------------------------------
    call("GetDi", c::GetDi::OPCODE, &[short("diType"), out("value")]),
    call("SetDo", c::SetDo::OPCODE, &[short("doType"), long("value")]),
    call("GetDo", c::GetDo::OPCODE, &[short("doType"), out("value")]),
    call("GetDiEx", c::GetDiEx::OPCODE, &[short("diType"), out("value"), COUNT]),
    shaped(
        Shape::Points,
        "SetDoEx",
        c::SetDoEx::OPCODE,
        &[short("doType"), sized("value", Type::Long, Size::Count), COUNT],
    ),
    call("GetDoEx", c::GetDoEx::OPCODE, &[short("doType"), out("value"), COUNT]),
    call("SetDoBit", c::SetDoBit::OPCODE, &[short("doType"), short("index"), short("value")]),
    shaped(
        Shape::Points,
        "SetDac",
        c::SetDac::OPCODE,
        &[short("dac"), sized("value", Type::Short, Size::Count), COUNT],
    ),
    call("GetDac", c::GetDac::OPCODE, &[short("dac"), out("value"), COUNT]),
    call("GetAdc", c::GetAdc::OPCODE, &[short("adc"), out("value"), COUNT, CLOCK]),
    call("SimInput", c::SimInput::OPCODE, &[short("diType"), short("index"), short("level")]),
    call("SimAdc", c::SimAdc::OPCODE, &[short("adc"), double("volts")]),
    // -- laser (GUS chapter 2, LSR chapter 2) ------------------------------------------------------
    call("SetAxisMode", c::SetAxisMode::OPCODE, &[AXIS, short("mode")]),
    call("LaserOn", c::LaserOn::OPCODE, &[CHANNEL]),
    call("LaserOff", c::LaserOff::OPCODE, &[CHANNEL]),
    call("LaserOnStatus", c::LaserOnStatus::OPCODE, &[out("value"), CHANNEL]),
    call("SetHSIOOpt", c::SetHSIOOpt::OPCODE, &[ushort("value"), CHANNEL]),
    call("GetHSIOOpt", c::GetHSIOOpt::OPCODE, &[out("value"), CHANNEL]),
    call(
        "LaserPowerMode",
        c::LaserPowerMode::OPCODE,
        &[short("laserPowerMode"), double("maxValue"), double("minValue"), CHANNEL, short("delaymode").or(0)],
    ),
    call("LaserPrfCmd", c::LaserPrfCmd::OPCODE, &[double("outputCmd"), CHANNEL]),
    call("LaserOutFrq", c::LaserOutFrq::OPCODE, &[double("outFrq"), CHANNEL]),
    call("SetPulseWidth", c::SetPulseWidth::OPCODE, &[ulong("width"), CHANNEL]),
    call(
        "SetWaitPulse",
        c::SetWaitPulse::OPCODE,
        &[ushort("mode"), double("waitPulseFrq"), double("waitPulseDuty"), CHANNEL],
    ),
    call(
        "SetWaitPulseEx",
        c::SetWaitPulseEx::OPCODE,
        &[ushort("mode"), double("waitPulseFrq"), double("waitPulseDuty")],
    ),
    call("SetPreVltg", c::SetPreVltg::OPCODE, &[ushort("mode"), double("voltageValue"), CHANNEL]),
    call("SetLevelDelay", c::SetLevelDelay::OPCODE, &[ulong("offDelay"), ulong("onDelay"), CHANNEL]),
    call("EnaFPK", c::EnaFPK::OPCODE, &[ulong("time1"), ulong("time2"), ulong("laserOffDelay"), CHANNEL]),
    call("DisFPK", c::DisFPK::OPCODE, &[CHANNEL]),
    call("SetLaserMode", c::SetLaserMode::OPCODE, &[short("mode")]),
    call("ZeroLaserOnTime", c::ZeroLaserOnTime::OPCODE, &[short("channel")]),
    call("GetLaserOnTime", c::GetLaserOnTime::OPCODE, &[short("channel"), out("time")]),
    call("SetLaserCrdMap", c::SetLaserCrdMap::OPCODE, &[short("channel"), short("map")]),
    call("GetLaserCrdMap", c::GetLaserCrdMap::OPCODE, &[short("channel"), out("map")]),
    call("GetLaserPower", c::GetLaserPower::OPCODE, &[short("channel"), out("power")]),
    call("GetLaserFault", c::GetLaserFault::OPCODE, &[short("channel"), out("cause")]),
    call("ClrLaserFault", c::ClrLaserFault::OPCODE, &[short("channel")]),
    // -- coordinate systems ------------------------------------------------------------------------
    call("SetCrdPrm", c::SetCrdPrm::OPCODE, &[CRD, param("crdPrm", Pass::Struct(Type::Crd))]),
    call("GetCrdPrm", c::GetCrdPrm::OPCODE, &[CRD, param("crdPrm", Pass::OutStruct(Type::Crd))]),
    call("CrdClear", c::CrdClear::OPCODE, &[CRD, FIFO]),
    call("CrdSpace", c::CrdSpace::OPCODE, &[CRD, out("space"), FIFO]),
    call("CrdStart", c::CrdStart::OPCODE, &[short("mask"), short("option").or(0)]),
    call("CrdStop", c::CrdStop::OPCODE, &[MASK, long("option").or(0)]),
    call("CrdStatus", c::CrdStatus::OPCODE, &[CRD, out("run"), out("segment"), FIFO]),
    call("GetCrdStopReason", c::CrdInfo::OPCODE, &[CRD, out("reason"), REASON_TEXT, REASON_SIZE]),
    call("GetCrdPos", c::GetCrdPos::OPCODE, &[CRD, out("pos")]),
    call("GetCrdVel", c::GetCrdVel::OPCODE, &[CRD, out("synVel")]),
    call("GetRemainderSegNum", c::GetRemainderSegNum::OPCODE, &[CRD, out("segment"), FIFO]),
    call("SetCrdStopDec", c::SetCrdStopDec::OPCODE, &[CRD, double("decSmoothStop"), double("decAbruptStop")]),
    call("SetOverride", c::SetOverride::OPCODE, &[CRD, double("synVelRatio")]),
    call("SetLaserFollowFilter", c::SetLaserFollowFilter::OPCODE, &[CRD, double("time")]),
    call("GetLaserFollowFilter", c::GetLaserFollowFilter::OPCODE, &[CRD, out("time")]),
    call(
        "InitLookAhead",
        c::InitLookAhead::OPCODE,
        &[CRD, short("fifo"), double("T"), double("accMax"), short("n"), param("lookAheadBuf", Pass::Working).or(0)],
    ),
    call("SetCrdLimit", c::SetCrdLimit::OPCODE, &[CRD, short("coordinate"), double("velMax"), double("accMax")]),
    call("GetCrdLimit", c::GetCrdLimit::OPCODE, &[CRD, short("coordinate"), out("velMax"), out("accMax")]),
    shaped(
        Shape::Point,
        "CrdData",
        c::CrdData::OPCODE,
        &[CRD, param("crdData", Pass::StructOrNull(Type::CrdData)), FIFO],
    ),
    call("LnXY", c::LnXY::OPCODE, &[CRD, X, Y, VEL, ACC, VEL_END, FIFO]),
    call("LnXYZ", c::LnXYZ::OPCODE, &[CRD, X, Y, Z, VEL, ACC, VEL_END, FIFO]),
    call("LnXYZA", c::LnXYZA::OPCODE, &[CRD, X, Y, Z, long("a"), VEL, ACC, VEL_END, FIFO]),
    call("LnXYG0", c::LnXYG0::OPCODE, &[CRD, X, Y, VEL, ACC, FIFO]),
    call("ArcXYR", c::ArcXYR::OPCODE, &[CRD, X, Y, RADIUS, DIR, VEL, ACC, VEL_END, FIFO]),
    call("ArcXYC", c::ArcXYC::OPCODE, &[CRD, X, Y, double("xCenter"), double("yCenter"), DIR, VEL, ACC, VEL_END, FIFO]),
    call("ArcYZR", c::ArcYZR::OPCODE, &[CRD, Y, Z, RADIUS, DIR, VEL, ACC, VEL_END, FIFO]),
    call("ArcYZC", c::ArcYZC::OPCODE, &[CRD, Y, Z, double("yCenter"), double("zCenter"), DIR, VEL, ACC, VEL_END, FIFO]),
    call("ArcZXR", c::ArcZXR::OPCODE, &[CRD, Z, X, RADIUS, DIR, VEL, ACC, VEL_END, FIFO]),
    call("ArcZXC", c::ArcZXC::OPCODE, &[CRD, Z, X, double("zCenter"), double("xCenter"), DIR, VEL, ACC, VEL_END, FIFO]),
    call("BufDelay", c::BufDelay::OPCODE, &[CRD, ushort("delayTime"), FIFO]),
    call("BufIO", c::BufIO::OPCODE, &[CRD, ushort("doType"), ushort("doMask"), ushort("doValue"), FIFO]),
    call("BufDoBit", c::BufDoBit::OPCODE, &[CRD, ushort("doType"), ushort("index"), short("value"), FIFO]),
    call("BufDA", c::BufDA::OPCODE, &[CRD, short("chn"), short("daValue"), FIFO]),
    call(
        "BufMove",
        c::BufMove::OPCODE,
        &[CRD, short("moveAxis"), long("pos"), double("vel"), double("acc"), short("modal"), FIFO],
    ),
    call("BufGear", c::BufGear::OPCODE, &[CRD, short("gearAxis"), long("pos"), FIFO]),
    // -- buffered laser (GUS chapter 4, LSR chapter 3) ---------------------------------------------
    call("BufLaserOn", c::BufLaserOn::OPCODE, &[CRD, FIFO, CHANNEL]),
    call("BufLaserOff", c::BufLaserOff::OPCODE, &[CRD, FIFO, CHANNEL]),
    call("BufLaserPrfCmd", c::BufLaserPrfCmd::OPCODE, &[CRD, double("laserPower"), FIFO, CHANNEL]),
    call(
        "BufLaserPrfFollow",
        c::BufLaserPrfFollow::OPCODE,
        &[CRD, double("ratio"), long("minPower"), long("maxPower"), FIFO, CHANNEL],
    ),
    Function {
        told: Some("startPower"),
        ..call(
            "BufLaserFollowMode",
            c::BufLaserFollowMode::OPCODE,
            &[CRD, short("source").or(0), FIFO, CHANNEL, double("startPower").or(0)],
        )
    },
    call(
        "BufLaserFollowRatio",
        c::BufLaserFollowRatio::OPCODE,
        &[CRD, double("ratio"), double("minPower"), double("maxPower"), FIFO, CHANNEL],
    ),
    call(
        "BufLaserFollowTable",
        c::BufLaserFollowTable::OPCODE,
        &[CRD, TABLE, double("minPower"), double("maxPower"), FIFO, CHANNEL],
    ),
    call("BufLaserFollowOff", c::BufLaserFollowOff::OPCODE, &[CRD, FIFO, CHANNEL]),
    shaped(
        Shape::Points,
        "SetLaserFollowTable",
        c::SetLaserFollowTable::OPCODE,
        &[TABLE, POINTS, array("vel"), array("power"), CHANNEL],
    ),
    // -- distance follow (GUS chapter 5, LSR chapter 4) --------------------------------------------
    call(
        "SetLaserDisMode",
        c::SetLaserDisMode::OPCODE,
        &[
            short("mode"),
            short("source"),
            fixed("pos", Type::Long, 4).or(0),
            fixed("scale", Type::Double, 4).or(0),
            CHANNEL,
        ],
    ),
    // The manual of the earlier series has no bounds: (ratio, channel).
    Function {
        told: Some("maxPower"),
        ..call(
            "SetLaserDisRatio",
            c::SetLaserDisRatio::OPCODE,
            &[fixed("ratio", Type::Double, 4), double("minPower").or(0), double("maxPower").or(0), CHANNEL],
        )
    },
    Function {
        told: Some("limitPower"),
        ..shaped(
            Shape::Points,
            "SetLaserDisTable1D",
            c::SetLaserDisTable1D::OPCODE,
            &[
                short("count"),
                sized("ratio", Type::Double, Size::Each(4)),
                sized("pos", Type::Long, Size::Each(4)),
                double("minPower"),
                double("maxPower"),
                fixed("limitPower", Type::Double, 4).or(0),
                CHANNEL,
            ],
        )
    },
    Function {
        told: Some("limitPower"),
        ..shaped(
            Shape::Grid,
            "SetLaserDisTable2D",
            c::SetLaserDisTable2D::OPCODE,
            &[
                fixed("axisIndex", Type::Short, 2),
                fixed("count", Type::Short, 2),
                sized("ratio", Type::Double, Size::Grid),
                sized("xPos", Type::Long, Size::Columns),
                sized("yPos", Type::Long, Size::Rows),
                double("minPower"),
                double("maxPower"),
                fixed("limitPower", Type::Double, 2).or(0),
                CHANNEL,
            ],
        )
    },
    // -- PT (GXN chapter 2) ------------------------------------------------------------------------
    call("PrfPt", c::PrfPt::OPCODE, &[PROFILE, short("mode").or(0)]),
    call("PtSpace", c::PtSpace::OPCODE, &[PROFILE, out("space"), FIFO]),
    call("PtData", c::PtData::OPCODE, &[PROFILE, double("pos"), long("time"), short("type").or(0), FIFO]),
    call("PtClear", c::PtClear::OPCODE, &[PROFILE, FIFO]),
    call("SetPtLoop", c::SetPtLoop::OPCODE, &[PROFILE, long("loop")]),
    call("GetPtLoop", c::GetPtLoop::OPCODE, &[PROFILE, out("loop")]),
    call("SetPtMemory", c::SetPtMemory::OPCODE, &[PROFILE, short("memory")]),
    call("GetPtMemory", c::GetPtMemory::OPCODE, &[PROFILE, out("memory")]),
    call("PtStart", c::PtStart::OPCODE, &[MASK, long("option").or(0)]),
    shaped(
        Shape::StartList,
        "PtStartPro",
        c::PtStart::OPCODE,
        &[sized("axis", Type::Short, Size::Count), sized("option", Type::Short, Size::Count), short("count")],
    ),
    // -- PVT (GXN chapter 4) -----------------------------------------------------------------------
    call("PrfPvt", c::PrfPvt::OPCODE, &[PROFILE]),
    call("SetPvtLoop", c::SetPvtLoop::OPCODE, &[PROFILE, long("loop")]),
    call("GetPvtLoop", c::GetPvtLoop::OPCODE, &[PROFILE, out("loopCount"), out("loop")]),
    call("PvtStatus", c::PvtStatus::OPCODE, &[PROFILE, out("tableId"), out("time"), COUNT]),
    call("PvtStart", c::PvtStart::OPCODE, &[MASK]),
    call("PvtTableSelect", c::PvtTableSelect::OPCODE, &[PROFILE, TABLE]),
    shaped(Shape::Points, "PvtTable", c::PvtTable::OPCODE, &[TABLE, POINTS, array("time"), array("pos"), array("vel")]),
    shaped(
        Shape::Points,
        "PvtTableEx",
        c::PvtTableEx::OPCODE,
        &[TABLE, POINTS, array("time"), array("pos"), array("velBegin"), array("velEnd")],
    ),
    shaped(
        Shape::Points,
        "PvtTableComplete",
        c::PvtTableComplete::OPCODE,
        &[
            TABLE,
            POINTS,
            array("time"),
            array("pos"),
            param("a", Pass::Working),
            param("b", Pass::Working),
            param("c", Pass::Working),
            double("velBegin").or(0),
            double("velEnd").or(0),
        ],
    ),
    shaped(
        Shape::Points,
        "PvtTablePercent",
        c::PvtTablePercent::OPCODE,
        &[TABLE, POINTS, array("time"), array("pos"), array("percent"), double("velBegin").or(0)],
    ),
    shaped(
        Shape::Points,
        "PvtPercentCalculate",
        c::PvtPercentCalculate::OPCODE,
        &[POINTS, array("time"), array("pos"), array("percent"), double("velBegin"), out("vel")],
    ),
    shaped(
        Shape::Points,
        "PvtTableContinuous",
        c::PvtTableContinuous::OPCODE,
        &[
            TABLE,
            POINTS,
            array("pos"),
            array("vel"),
            array("percent"),
            array("velMax"),
            array("acc"),
            array("dec"),
            double("timeBegin"),
        ],
    ),
    shaped(
        Shape::Points,
        "PvtContinuousCalculate",
        c::PvtContinuousCalculate::OPCODE,
        &[
            POINTS,
            array("pos"),
            array("vel"),
            array("percent"),
            array("velMax"),
            array("acc"),
            array("dec"),
            out("time"),
        ],
    ),
    // -- Follow (GXN chapter 3) --------------------------------------------------------------------
    call("PrfFollow", c::PrfFollow::OPCODE, &[PROFILE, short("dir").or(0)]),
    call(
        "SetFollowMaster",
        c::SetFollowMaster::OPCODE,
        &[PROFILE, short("masterIndex"), short("masterType").or(2), short("masterItem").or(0)],
    ),
    call(
        "GetFollowMaster",
        c::GetFollowMaster::OPCODE,
        &[PROFILE, out("masterIndex"), out("masterType").or(0), out("masterItem").or(0)],
    ),
    call("SetFollowLoop", c::SetFollowLoop::OPCODE, &[PROFILE, long("loop")]),
    call("GetFollowLoop", c::GetFollowLoop::OPCODE, &[PROFILE, out("loop")]),
    call(
        "SetFollowEvent",
        c::SetFollowEvent::OPCODE,
        &[PROFILE, short("event"), short("masterDir"), long("pos").or(0)],
    ),
    call("GetFollowEvent", c::GetFollowEvent::OPCODE, &[PROFILE, out("event"), out("masterDir"), out("pos")]),
    call("FollowSpace", c::FollowSpace::OPCODE, &[PROFILE, out("space"), FIFO]),
    call(
        "FollowData",
        c::FollowData::OPCODE,
        &[PROFILE, long("masterSegment"), double("slaveSegment"), short("type").or(0), FIFO],
    ),
    call("FollowClear", c::FollowClear::OPCODE, &[PROFILE, FIFO]),
    call("FollowStart", c::FollowStart::OPCODE, &[MASK, long("option").or(0)]),
    call("FollowSwitch", c::FollowSwitch::OPCODE, &[MASK]),
    call("SetFollowMemory", c::SetFollowMemory::OPCODE, &[PROFILE, short("memory")]),
    call("GetFollowMemory", c::GetFollowMemory::OPCODE, &[PROFILE, out("memory")]),
    call("GetFollowStatus", c::GetFollowStatus::OPCODE, &[PROFILE, out("fifoNum"), out("switchStatus")]),
    // -- FollowEx (GXN chapter 3) ------------------------------------------------------------------
    call("PrfFollowEx", c::PrfFollowEx::OPCODE, &[PROFILE, short("dir").or(0)]),
    call(
        "SetFollowMasterEx",
        c::SetFollowMasterEx::OPCODE,
        &[PROFILE, short("masterIndex"), short("masterType").or(2), short("masterItem").or(0)],
    ),
    call(
        "GetFollowMasterEx",
        c::GetFollowMasterEx::OPCODE,
        &[PROFILE, out("masterIndex"), out("masterType").or(0), out("masterItem").or(0)],
    ),
    call("SetFollowLoopEx", c::SetFollowLoopEx::OPCODE, &[PROFILE, long("loop")]),
    call("GetFollowLoopEx", c::GetFollowLoopEx::OPCODE, &[PROFILE, out("loop")]),
    call(
        "SetFollowEventEx",
        c::SetFollowEventEx::OPCODE,
        &[PROFILE, short("event"), short("masterDir"), long("pos").or(0)],
    ),
    call("GetFollowEventEx", c::GetFollowEventEx::OPCODE, &[PROFILE, out("event"), out("masterDir"), out("pos")]),
    call("FollowSpaceEx", c::FollowSpaceEx::OPCODE, &[PROFILE, out("space"), FIFO]),
    call(
        "FollowDataPercentEx",
        c::FollowDataPercentEx::OPCODE,
        &[PROFILE, double("masterSegment"), double("slaveSegment"), short("type").or(0), short("percent").or(0), FIFO],
    ),
    call("FollowClearEx", c::FollowClearEx::OPCODE, &[PROFILE, FIFO]),
    call("FollowStartEx", c::FollowStartEx::OPCODE, &[MASK, long("option").or(0)]),
    call("FollowSwitchEx", c::FollowSwitchEx::OPCODE, &[MASK]),
    call("SetFollowMemoryEx", c::SetFollowMemoryEx::OPCODE, &[PROFILE, short("memory")]),
    call("GetFollowMemoryEx", c::GetFollowMemoryEx::OPCODE, &[PROFILE, out("memory")]),
    call("GetFollowStatusEx", c::GetFollowStatusEx::OPCODE, &[PROFILE, out("fifoNum"), out("switchStatus")]),
    call("FollowSwitchNowEx", c::FollowSwitchNowEx::OPCODE, &[PROFILE, short("method"), short("buffer").or(0), FIFO]),
    call("FollowDoBitEx", c::FollowDoBitEx::OPCODE, &[PROFILE, short("doType"), short("index"), short("value"), FIFO]),
    call("FollowDelayEx", c::FollowDelayEx::OPCODE, &[PROFILE, ulong("delayTime"), FIFO]),
    call(
        "FollowDiBitEx",
        c::FollowDiBitEx::OPCODE,
        &[PROFILE, short("diType"), short("index"), short("value"), ulong("time").or(0), FIFO],
    ),
    call(
        "FollowDataPercent2Ex",
        c::FollowDataPercent2Ex::OPCODE,
        &[
            PROFILE,
            double("masterSegment"),
            double("slaveSegment"),
            double("velBeginRatio"),
            double("velEndRatio"),
            short("percent").or(100),
            out("percent1").or(0),
            FIFO,
        ],
    ),
    call(
        "GetFollowDataPercent2Ex",
        c::GetFollowDataPercent2Ex::OPCODE,
        &[double("masterPos"), double("v1"), double("v2"), double("p"), double("p1"), out("slavePos")],
    ),
];

impl Function {
    /// Whether a parameter fills this field of the request.
    pub fn has(&self, field: &str) -> bool {
        self.params.iter().any(|param| param.name == field)
    }

    /// It changes nothing: allowed in `while(!kbhit())`.
    pub fn reads(&self) -> bool {
        self.shape == Shape::Host || c::class(self.opcode).is_some_and(|class| class.kind.reads())
    }

    /// It reports why motion has stopped: a number, and the host's text of it.
    pub fn tells_stop(&self) -> bool {
        matches!(self.name, "GetStopReason" | "GetCrdStopReason")
    }
}

/// How many values the arrays of a function hold, at least and at most; of a plane, in each direction. A controller may have
/// room for fewer.
pub fn counts(name: &str) -> Option<(i64, i64)> {
    match name {
        "SetDac" | "PtStartPro" => Some((1, 32)),
        "SetDoEx" => Some((1, 4)),
        "SetLaserFollowTable" | "SetLaserDisTable1D" | "SetLaserDisTable2D" => Some((1, 32)),
        name if name.starts_with("Pvt") => Some((2, 1024)),
        _ => None,
    }
}

/// The function named `name` without its prefix.
pub fn function(name: &str) -> Option<&'static Function> {
    FUNCTIONS.iter().find(|function| function.name == name)
}

/// Names misread in the printed manual (GXN, chapters 2 to 5), with their meaning, however often
/// they occur. A name that is not here is not guessed.
pub const MISREAD: &[(&str, &str)] = &[
    ("PrFPt", "PrfPt"),
    ("PrFpT", "PrfPt"),
    ("PrFpt", "PrfPt"),
    ("PrPt", "PrfPt"),
    ("PrflPt", "PrfPt"),
    ("PrftPt", "PrfPt"),
    ("PrFPvt", "PrfPvt"),
    ("PrFpvt", "PrfPvt"),
    ("PrPvt", "PrfPvt"),
    ("PrflPvt", "PrfPvt"),
    ("PrftPvt", "PrfPvt"),
    ("PrFFollow", "PrfFollow"),
    ("PrffFollow", "PrfFollow"),
    ("PrflFollow", "PrfFollow"),
    ("PrjFollow", "PrfFollow"),
    ("PrFFollowEx", "PrfFollowEx"),
    ("PrffFollowEx", "PrfFollowEx"),
    ("PrffollowEx", "PrfFollowEx"),
    ("PrjJog", "PrfJog"),
    ("PrkJog", "PrfJog"),
];

/// Calls that are accepted and skipped: they print, or wait for a key.
pub const SKIPPED: &[&str] = &["printf", "commandhandler", "getch", "_getch", "getchar", "puts", "fflush", "system"];

/// Constants of the manuals' header.
pub const CONSTANTS: &[(&str, i64)] = &[
    ("PT_MODE_STATIC", 0),
    ("PT_MODE_DYNAMIC", 1),
    ("PT_SEGMENT_NORMAL", 0),
    ("PT_SEGMENT_EVEN", 1),
    ("PT_SEGMENT_STOP", 2),
    ("FOLLOW_MASTER_ENCODER", master::ENCODER as i64),
    ("FOLLOW_MASTER_PROFILE", master::PROFILE as i64),
    ("FOLLOW_MASTER_AXIS", master::AXIS as i64),
    ("FOLLOW_MASTER_AU_ENCODER", 4),
    ("FOLLOW_MASTER_ENCODER_OTHER", master::ENCODER_OTHER as i64),
    ("FOLLOW_MASTER_AXIS_OTHER", master::AXIS_OTHER as i64),
    ("FOLLOW_EVENT_START", 1),
    ("FOLLOW_EVENT_PASS", 2),
    ("FOLLOW_SEGMENT_NORMAL", 0),
    ("FOLLOW_SEGMENT_EVEN", 1),
    ("FOLLOW_SEGMENT_STOP", 2),
    ("FOLLOW_SEGMENT_CONTINUE", 3),
    ("FOLLOW_SWITCH_SEGMENT", 1),
    ("FOLLOW_SWITCH_TABLE", 2),
    ("MC_NONE", -1),
    ("MC_LIMIT_POSITIVE", io::LIMIT_POSITIVE as i64),
    ("MC_LIMIT_NEGATIVE", io::LIMIT_NEGATIVE as i64),
    ("MC_ALARM", io::ALARM as i64),
    ("MC_HOME", io::HOME as i64),
    ("MC_GPI", io::GPI as i64),
    ("MC_ARRIVE", io::ARRIVE as i64),
    ("MC_MPG", 6),
    ("MC_ENABLE", io::ENABLE as i64),
    ("MC_CLEAR", io::CLEAR as i64),
    ("MC_GPO", io::GPO as i64),
    ("MC_DAC", 20),
    ("MC_STEP", 21),
    ("MC_PULSE", 22),
    ("MC_ENCODER", 23),
    ("MC_ADC", io::ADC as i64),
    ("MC_AXIS", 30),
    ("MC_PROFILE", 31),
    ("MC_CONTROL", 32),
    ("MC_LASER", 71),
    ("MC_POS_COMPARE", 80),
    // Ours: the interlock (or emergency-stop) input, for SimInput.
    ("MC_INTERLOCK", io::INTERLOCK as i64),
    ("CAPTURE_HOME", 1),
    ("CAPTURE_INDEX", 2),
    ("CAPTURE_PROBE", 3),
    ("CAPTURE_HSIO0", 6),
    ("CAPTURE_HSIO1", 7),
    ("AXIS_LASER", 7),
    ("AXIS_LASER_EX", 8),
    ("LASER_CTRL_MODE_PWM1", 0),
    ("LASER_CTRL_FREQUENCY", 1),
    ("LASER_CTRL_VOLTAGE", 2),
    ("LASER_CTRL_MODE_PWM2", 3),
    ("CIRCLE_DIR_CW", 0),
    ("CIRCLE_DIR_CCW", 1),
    ("INTERPOLATION_CIRCLE_DIR_CW", 0),
    ("INTERPOLATION_CIRCLE_DIR_CCW", 1),
    ("CRD_OPERATION_TYPE_LASER_ON", 2),
    ("CRD_OPERATION_TYPE_LASER_OFF", 3),
    ("CRD_OPERATION_TYPE_LASER_CMD", 5),
    ("CRD_OPERATION_TYPE_LASER_FOLLOW_RATIO", 6),
    ("CRD_OPERATION_TYPE_LASER_FOLLOW_MODE", 25),
    ("CRD_OPERATION_TYPE_LASER_FOLLOW_OFF", 26),
    ("CRD_OPERATION_TYPE_LASER_FOLLOW_SPLINE", 28),
    ("CRD_MAX", 2),
    ("CRD_FIFO_MAX", 4096),
    ("INTERPOLATION_AXIS_MAX", 8),
    ("CHANNEL_HOST", 0),
    ("CHANNEL_UART", 1),
    ("CHANNEL_SIM", 2),
    ("CHANNEL_ETHER", 3),
    ("CHANNEL_RS232", 4),
    ("CHANNEL_PCIE", 5),
    ("CHANNEL_RINGNET", 6),
];
