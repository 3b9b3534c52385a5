//! The functions: a row each, by chapter.
use super::{Function, Param, Pass, Shape, Size, Type};
use protocol::command::{self as c, Request};

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

const fn call(name: &'static str, opcode: u16, params: &'static [Param]) -> Function {
    shaped(Shape::Plain, name, opcode, params)
}
const fn shaped(shape: Shape, name: &'static str, opcode: u16, params: &'static [Param]) -> Function {
    Function { name, opcode, params, shape, reports_given: None }
}

/// Every function that has a request, or that the host answers.
pub const FUNCTIONS: &[Function] = &[
    // -- session
    // -----------------------------------------------------------------------------------
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
    // -- axis
    // --------------------------------------------------------------------------------------
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
    // -- trap and jog
    // ------------------------------------------------------------------------------
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
    // -- digital and analog inputs and outputs
    // -----------------------------------------------------
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
    call(
        "SetDoBitReverse",
        c::SetDoBitReverse::OPCODE,
        &[short("doType"), short("doIndex"), short("value"), short("reverseTime")],
    ),
    call(
        "GetDiReverseCount",
        c::GetDiReverseCount::OPCODE,
        &[short("diType"), short("diIndex"), out("reverseCount"), COUNT],
    ),
    shaped(
        Shape::Points,
        "SetDiReverseCount",
        c::SetDiReverseCount::OPCODE,
        &[short("diType"), short("diIndex"), sized("reverseCount", Type::ULong, Size::Count), COUNT],
    ),
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
    // -- laser (GUS chapter 2, LSR chapter 2)
    // ------------------------------------------------------
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
    // -- coordinate systems
    // ------------------------------------------------------------------------
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
    // -- buffered laser (GUS chapter 4, LSR chapter 3)
    // ---------------------------------------------
    call("BufLaserOn", c::BufLaserOn::OPCODE, &[CRD, FIFO, CHANNEL]),
    call("BufLaserOff", c::BufLaserOff::OPCODE, &[CRD, FIFO, CHANNEL]),
    call("BufLaserPrfCmd", c::BufLaserPrfCmd::OPCODE, &[CRD, double("laserPower"), FIFO, CHANNEL]),
    call(
        "BufLaserPrfFollow",
        c::BufLaserPrfFollow::OPCODE,
        &[CRD, double("ratio"), long("minPower"), long("maxPower"), FIFO, CHANNEL],
    ),
    Function {
        reports_given: Some("startPower"),
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
    // -- distance follow (GUS chapter 5, LSR chapter 4)
    // --------------------------------------------
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
        reports_given: Some("maxPower"),
        ..call(
            "SetLaserDisRatio",
            c::SetLaserDisRatio::OPCODE,
            &[fixed("ratio", Type::Double, 4), double("minPower").or(0), double("maxPower").or(0), CHANNEL],
        )
    },
    Function {
        reports_given: Some("limitPower"),
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
        reports_given: Some("limitPower"),
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
    // -- PT (GXN chapter 2)
    // ------------------------------------------------------------------------
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
    // -- PVT (GXN chapter 4)
    // -----------------------------------------------------------------------
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
    // -- Gear
    // -------------------------------------------------------------------------------------------
    call("PrfGear", c::PrfGear::OPCODE, &[PROFILE, short("dir").or(0)]),
    call(
        "SetGearMaster",
        c::SetGearMaster::OPCODE,
        &[PROFILE, short("masterIndex"), short("masterType").or(2), short("masterItem").or(0)],
    ),
    call(
        "GetGearMaster",
        c::GetGearMaster::OPCODE,
        &[PROFILE, out("masterIndex"), out("masterType").or(0), out("masterItem").or(0)],
    ),
    call(
        "SetGearRatio",
        c::SetGearRatio::OPCODE,
        &[PROFILE, long("masterEven"), long("slaveEven"), long("masterSlope").or(0)],
    ),
    call(
        "GetGearRatio",
        c::GetGearRatio::OPCODE,
        &[PROFILE, out("masterEven"), out("slaveEven"), out("masterSlope").or(0)],
    ),
    call("GearStart", c::GearStart::OPCODE, &[MASK]),
    call("SetGearEvent", c::SetGearEvent::OPCODE, &[PROFILE, short("event"), long("startPara0"), long("startPara1")]),
    call("GetGearEvent", c::GetGearEvent::OPCODE, &[PROFILE, out("event"), out("startPara0"), out("startPara1")]),
    // -- Follow (GXN chapter 3)
    // --------------------------------------------------------------------
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
    // -- FollowEx (GXN chapter 3)
    // ------------------------------------------------------------------
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
