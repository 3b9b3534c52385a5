//! The rows, and the names of what is not there.

use super::{Class, More, Range};
use crate::home::HomeCall;
use crate::prototype::Scalar::{self, Double, Long, Short, ULong, UShort};
use job::api::{Function, Param, Pass, Shape, Type};
use protocol::command::{self as c, Request};

const fn param(name: &'static str, pass: Pass) -> Param {
    Param { name, pass, default: None }
}
const fn or(param: Param, default: i32) -> Param {
    Param { default: Some(default), ..param }
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
const fn out(name: &'static str) -> Param {
    param(name, Pass::Out)
}
const fn array(name: &'static str) -> Param {
    param(name, Pass::Fixed(Type::Long, 0))
}
const fn row(
    name: &'static str,
    params: &'static [Param],
    outs: &'static [Scalar],
    class: Class,
    about: &'static str,
) -> More {
    let function = Function { name, opcode: 0, params, shape: Shape::Host, reports_given: None };
    More { function, outs, class, about }
}
const fn refused(
    name: &'static str,
    params: &'static [Param],
    outs: &'static [Scalar],
    why: &'static str,
    about: &'static str,
) -> More {
    row(name, params, outs, Class::Refused(why), about)
}

const AXES: Range = Range::Axes;
/// Analog outputs and inputs of the products.
const ANALOG: Range = Range::From(1.0, 8.0);
const WORD: Range = Range::From(0.0, 32767.0);
const SIGNED: Range = Range::From(-32768.0, 32767.0);
const SCALE: Range = Range::Not0(-32767.0, 32767.0);
const EXPONENT: Range = Range::From(0.0, 15.0);
const SETS: Range = Range::From(1.0, 3.0);
const PID: &[Range] = &[WORD, WORD, WORD, WORD, WORD, WORD, WORD, WORD];
const CONTROL: Param = short("control");
const AXIS: Param = short("axis");
const DAC: Param = short("dac");
const MODULE: Param = short("mdl");
const CHANNEL: Param = short("chn");
const INDEX: Param = short("index");
const PROFILE: Param = short("profile");

const NO_MODULE: &str = "there are no extension modules";
const NO_WHEEL: &str = "there is no handwheel input";
const NO_COMPENSATION: &str = "there is no compensation of lead screws or backlash";
const NO_CAM: &str = "the mode Cam is not there; FollowEx takes tables of master and slave";

/// All of them, in the order of the headers.
pub const MORE: &[More] = &[
    More {
        function: Function {
            name: "GetDiRaw",
            opcode: c::GetDi::OPCODE,
            params: &[short("diType"), out("value")],
            shape: Shape::Plain,
            reports_given: None,
        },
        outs: &[Long],
        class: Class::Real,
        about: "Levels at the terminals; what GetDi returns, which no sense changes.",
    },
    row("Delay", &[ushort("time")], &[], Class::Timed, "Waits for so many ms of the controller's time."),
    row(
        "DelayHighPrecision",
        &[ushort("time")],
        &[],
        Class::Timed,
        "Waits for so many 250 us of the controller's time.",
    ),
    row("GetClockHighPrecision", &[out("clock")], &[ULong], Class::Timed, "Controller time in 125 us since power-on."),
    row(
        "SetPid",
        &[CONTROL, INDEX, param("pid", Pass::Struct(Type::Pid))],
        &[],
        Class::Keeps { under: "Pid", names: &[AXES, SETS], values: PID },
        "Kept: gains of a position loop; there is no loop.",
    ),
    row(
        "GetPid",
        &[CONTROL, INDEX, param("pid", Pass::OutStruct(Type::Pid))],
        &[],
        Class::Recalls { under: "Pid", names: &[AXES, SETS], unset: &[0., 0., 0., 0., 0., 32767., 32767., 32767.] },
        "The gains that SetPid has set.",
    ),
    row(
        "SetControlFilter",
        &[CONTROL, INDEX],
        &[],
        Class::Keeps { under: "ControlFilter", names: &[AXES], values: &[SETS] },
        "Kept: which set of gains is in force.",
    ),
    row(
        "GetControlFilter",
        &[CONTROL, out("index")],
        &[Short],
        Class::Recalls { under: "ControlFilter", names: &[AXES], unset: &[1.] },
        "The set of gains that SetControlFilter has chosen.",
    ),
    row(
        "SetKvffFilter",
        &[CONTROL, short("kvffFilterExp"), double("accMax")],
        &[],
        Class::Keeps { under: "KvffFilter", names: &[AXES], values: &[EXPONENT, WORD] },
        "Kept: filter of the velocity feed-forward.",
    ),
    row(
        "GetKvffFilter",
        &[CONTROL, out("kvffFilterExp"), out("accMax")],
        &[Short, Double],
        Class::Recalls { under: "KvffFilter", names: &[AXES], unset: &[0., 0.] },
        "The filter that SetKvffFilter has set.",
    ),
    row(
        "SetAxisPrfVelFilter",
        &[AXIS, short("filterNumExp")],
        &[],
        Class::Keeps { under: "AxisPrfVelFilter", names: &[AXES], values: &[EXPONENT] },
        "Kept: filter of the planned velocity that is shown.",
    ),
    row(
        "GetAxisPrfVelFilter",
        &[AXIS, out("filterNumExp")],
        &[Short],
        Class::Recalls { under: "AxisPrfVelFilter", names: &[AXES], unset: &[0.] },
        "The filter that SetAxisPrfVelFilter has set.",
    ),
    row(
        "SetAxisEncVelFilter",
        &[AXIS, short("filterNumExp")],
        &[],
        Class::Keeps { under: "AxisEncVelFilter", names: &[AXES], values: &[EXPONENT] },
        "Kept: filter of the encoder's velocity that is shown.",
    ),
    row(
        "GetAxisEncVelFilter",
        &[AXIS, out("filterNumExp")],
        &[Short],
        Class::Recalls { under: "AxisEncVelFilter", names: &[AXES], unset: &[0.] },
        "The filter that SetAxisEncVelFilter has set.",
    ),
    row(
        "SetProfileScale",
        &[AXIS, short("alpha"), short("beta")],
        &[],
        Class::Keeps { under: "ProfileScale", names: &[AXES], values: &[SCALE, SCALE] },
        "Kept: the axis' scale of its profile; positions stay those of the profile.",
    ),
    row(
        "GetProfileScale",
        &[AXIS, out("alpha"), out("beta")],
        &[Short, Short],
        Class::Recalls { under: "ProfileScale", names: &[AXES], unset: &[1., 1.] },
        "The scale that SetProfileScale has set.",
    ),
    row(
        "SetEncoderScale",
        &[AXIS, short("alpha"), short("beta")],
        &[],
        Class::Keeps { under: "EncoderScale", names: &[AXES], values: &[SCALE, SCALE] },
        "Kept: the axis' scale of its encoder; positions stay those of the encoder.",
    ),
    row(
        "GetEncoderScale",
        &[AXIS, out("alpha"), out("beta")],
        &[Short, Short],
        Class::Recalls { under: "EncoderScale", names: &[AXES], unset: &[1., 1.] },
        "The scale that SetEncoderScale has set.",
    ),
    row(
        "SetMtrBias",
        &[DAC, short("bias")],
        &[],
        Class::Keeps { under: "MtrBias", names: &[ANALOG], values: &[SIGNED] },
        "Kept: offset of a motor's analog output; no loop drives it.",
    ),
    row(
        "GetMtrBias",
        &[DAC, out("bias")],
        &[Short],
        Class::Recalls { under: "MtrBias", names: &[ANALOG], unset: &[0.] },
        "The offset that SetMtrBias has set.",
    ),
    row(
        "SetMtrLmt",
        &[DAC, short("limit")],
        &[],
        Class::Keeps { under: "MtrLmt", names: &[ANALOG], values: &[WORD] },
        "Kept: limit of a motor's analog output; no loop drives it.",
    ),
    row(
        "GetMtrLmt",
        &[DAC, out("limit")],
        &[Short],
        Class::Recalls { under: "MtrLmt", names: &[ANALOG], unset: &[32767.] },
        "The limit that SetMtrLmt has set.",
    ),
    row(
        "SetAdcFilter",
        &[short("adc"), short("filterTime")],
        &[],
        Class::Keeps { under: "AdcFilter", names: &[ANALOG], values: &[WORD] },
        "Kept: filter of an analog input.",
    ),
    row(
        "CtrlMode",
        &[AXIS, short("mode")],
        &[],
        Class::Keeps { under: "CtrlMode", names: &[AXES], values: &[Range::From(0., 1.)] },
        "1: pulses, which is so. 0, an analog output: kept, there is no loop.",
    ),
    row(
        "EncOn",
        &[short("encoder")],
        &[],
        Class::IsSo(AXES, "an encoder reads its input"),
        "Done: it reads its input.",
    ),
    refused(
        "EncOff",
        &[short("encoder")],
        &[],
        "an encoder reads its input; it cannot read the pulse output",
        "Refused: an encoder reads its input.",
    ),
    row("StepDir", &[short("step")], &[], Class::IsSo(AXES, "step and direction"), "Done: step and direction."),
    refused(
        "StepPulse",
        &[short("step")],
        &[],
        "pulses are output as step and direction; there are no pulses for each direction",
        "Refused: pulses are step and direction.",
    ),
    row(
        "EncSns",
        &[ushort("sense")],
        &[],
        Class::OnlyZero("no encoder counts the other way round; exchange its A and B"),
        "0 is so; an encoder that counts the other way round is refused.",
    ),
    row(
        "GpiSns",
        &[ushort("sense")],
        &[],
        Class::OnlyZero("general inputs are read as their terminals are"),
        "0 is so; general inputs are not inverted.",
    ),
    refused("ExtModuleInit", &[or(short("method"), 0)], &[], NO_MODULE, "Refused: no extension modules."),
    refused("SetExtDo", &[INDEX, long("value")], &[], NO_MODULE, "Refused: no extension modules."),
    refused("SetExtDoBit", &[INDEX, short("value")], &[], NO_MODULE, "Refused: no extension modules."),
    refused("GetExtDo", &[INDEX, out("value")], &[Long], NO_MODULE, "Refused: no extension modules."),
    refused("GetExtDoBit", &[INDEX, out("value")], &[Short], NO_MODULE, "Refused: no extension modules."),
    refused("GetExtDi", &[INDEX, out("value")], &[Long], NO_MODULE, "Refused: no extension modules."),
    refused("GetExtDiBit", &[INDEX, out("value")], &[Short], NO_MODULE, "Refused: no extension modules."),
    refused("SetExtAo", &[INDEX, double("value")], &[], NO_MODULE, "Refused: no extension modules."),
    refused("GetExtAi", &[INDEX, out("value")], &[Double], NO_MODULE, "Refused: no extension modules."),
    refused("OpenExtMdl", &[or(param("file", Pass::Text), 0)], &[], NO_MODULE, "Refused: no extension modules."),
    refused("CloseExtMdl", &[], &[], NO_MODULE, "Refused: no extension modules."),
    refused("ResetExtMdl", &[], &[], NO_MODULE, "Refused: no extension modules."),
    refused("LoadExtConfig", &[param("file", Pass::Text)], &[], NO_MODULE, "Refused: no extension modules."),
    refused("SetExtIoValue", &[MODULE, ushort("value")], &[], NO_MODULE, "Refused: no extension modules."),
    refused("GetExtIoValue", &[MODULE, out("value")], &[UShort], NO_MODULE, "Refused: no extension modules."),
    refused("SetExtIoBit", &[MODULE, INDEX, ushort("value")], &[], NO_MODULE, "Refused: no extension modules."),
    refused("GetExtIoBit", &[MODULE, INDEX, out("value")], &[UShort], NO_MODULE, "Refused: no extension modules."),
    refused("GetExtAdValue", &[MODULE, CHANNEL, out("value")], &[UShort], NO_MODULE, "Refused: no extension modules."),
    refused(
        "GetExtAdVoltage",
        &[MODULE, CHANNEL, out("value")],
        &[Double],
        NO_MODULE,
        "Refused: no extension modules.",
    ),
    refused("SetExtDaValue", &[MODULE, CHANNEL, ushort("value")], &[], NO_MODULE, "Refused: no extension modules."),
    refused("SetExtDaVoltage", &[MODULE, CHANNEL, double("value")], &[], NO_MODULE, "Refused: no extension modules."),
    refused("HandwheelInit", &[], &[], NO_WHEEL, "Refused: no handwheel input."),
    refused(
        "SetHandwheelStopDec",
        &[PROFILE, double("decSmoothStop"), double("decAbruptStop")],
        &[],
        NO_WHEEL,
        "Refused: no handwheel input.",
    ),
    refused(
        "StartHandwheel",
        &[
            PROFILE,
            short("master"),
            short("masterEven"),
            short("slaveEven"),
            short("intervalTime"),
            double("acc"),
            double("dec"),
            double("vel"),
            short("stopWaitTime"),
        ],
        &[],
        NO_WHEEL,
        "Refused: no handwheel input.",
    ),
    refused("EndHandwheel", &[PROFILE], &[], NO_WHEEL, "Refused: no handwheel input."),
    refused(
        "SetLeadScrewComp",
        &[AXIS, short("n"), long("startPos"), long("lenPos"), array("compPos"), array("compNeg")],
        &[],
        NO_COMPENSATION,
        "Refused: no compensation.",
    ),
    refused("EnableLeadScrewComp", &[AXIS, short("mode")], &[], NO_COMPENSATION, "Refused: no compensation."),
    refused(
        "SetBacklash",
        &[AXIS, long("compValue"), double("compChangeValue"), long("compDir")],
        &[],
        NO_COMPENSATION,
        "Refused: no compensation.",
    ),
    refused(
        "GetBacklash",
        &[AXIS, out("compValue"), out("compChangeValue"), out("compDir")],
        &[Long, Double, Long],
        NO_COMPENSATION,
        "Refused: no compensation.",
    ),
    row(
        "GoHome",
        &[AXIS, param("prm", Pass::Struct(Type::HomePrm))],
        &[],
        Class::Homes(HomeCall::Go),
        "Homes an axis in Trap mode by limit, home and index; the origin is 0 from then on.",
    ),
    row(
        "GetHomePrm",
        &[AXIS, param("prm", Pass::OutStruct(Type::HomePrm))],
        &[],
        Class::Homes(HomeCall::Prm),
        "The parameters of the last GoHome of an axis.",
    ),
    row(
        "GetHomeStatus",
        &[AXIS, param("status", Pass::OutStruct(Type::HomeStatus))],
        &[],
        Class::Homes(HomeCall::Status),
        "Whether an axis is on its way home, at which stage, and what went wrong.",
    ),
    row("HomeInit", &[], &[], Class::IsSo(AXES, "homing needs no start"), "Done: homing needs no start."),
    refused("PrfCam", &[PROFILE], &[], NO_CAM, "Refused: no Cam."),
    refused("CamStart", &[long("mask")], &[], NO_CAM, "Refused: no Cam."),
];

/// Functions that are known of the API and not in the library, with what they are for.
pub const NOT_THERE: &[(&str, &str)] = &[
    ("SetStopIo", "an input that stops an axis"),
    (
        "PtDataWN, PtGetSegNum, PtDataPro, PtDataArray, PtSpaceArray, GetPtRemainder, GetPtInfo",
        "PT with numbers and arrays",
    ),
    ("SetPtPrecisionMode, SetPtVel, SetPtLink, PtSmoothBegin, PtSmoothEnd, PtDoBit, PtAo", "PT's extras"),
    ("PvtTableContinuousEx, PvtTableMove, PvtTableMovePercent, PvtTableMovePercentEx, SetPvtTableLoop", "PVT's extras"),
    ("SetLaserDisTable2DEx, SelectLaserDisTable, BufSetLaserDisEnable, BufSelectLaserDisTable", "more distance tables"),
    ("SetLaserPwmDac, LaserPwmDacOn, LaserPwmDacOff, BufLaserFollowSpline", "power through an analog output, splines"),
];
