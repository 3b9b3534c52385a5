//! Admission: one function for each command, from the wire's struct to staged operations.
//!
//! In: a record. Out: the answer once it is executed, with the operations staged; or a refusal, and
//! then nothing has changed.
//! The only folder where the user's doubles become the tick's numbers.
pub mod admission;
mod axis;
pub mod commit;
pub(crate) mod context;
pub mod crd;
pub mod crd_data;
pub mod data;
mod follow;
mod follow_data;
mod io;
mod jog_trap;
mod laser;
mod paths;
pub mod staged;
use laser::buffered;
pub use laser::{power_on, tables};
pub mod pt;
mod pvt;
pub mod pvt_table;
mod session;
mod simulated;

use crate::refuse::{Admitted, Refused, within};
use crate::report::answer::{Answer, Query};
use crate::report::replies::is_crd;
use context::Context;
use protocol::command::{self, Nothing, Request, opcode};
use protocol::reason::Reason;
use servo::units::Axis;
use zerocopy::FromBytes;

pub use session::config_item;

/// Most axes of an AxisStatus reply that fit into one message.
const STATUS_ITEMS_MAX: u8 = 31;
const _: () = assert!(14 + STATUS_ITEMS_MAX as usize * size_of::<command::AxisItem>() <= protocol::MAX_PAYLOAD);

/// A command of one struct.
pub fn one<R: Request<Item = Nothing>>(body: &[u8]) -> Admitted<R> {
    R::read_from_bytes(body).map_err(|_| length(body.len(), size_of::<R>()))
}

/// A struct and `count` items.
pub fn many<R: Request>(body: &[u8], count: impl Fn(&R) -> u16) -> Admitted<(R, &[R::Item])> {
    let (request, rest) = R::read_from_prefix(body).map_err(|_| length(body.len(), size_of::<R>()))?;
    let count = usize::from(count(&request));
    let items = <[R::Item]>::ref_from_bytes_with_elems(rest, count)
        .map_err(|_| length(body.len(), size_of::<R>() + count * size_of::<R::Item>()))?;
    Ok((request, items))
}

fn length(got: usize, wanted: usize) -> Refused {
    Refused::new(Reason::Length).got(got as f64).limits(wanted as f64, wanted as f64)
}

/// A read of `count` consecutive axes.
fn read<const AXES: usize>(context: &Context<AXES>, opcode: u16, core: i16, axis: i16, count: i16) -> Admitted<Answer> {
    let (first, count) = context.span(core, axis, count)?;
    Ok(Answer::Read(Query { opcode, first: first.index() as u8, count, which: 0 }))
}

fn query(opcode: u16, axis: Axis) -> Answer {
    Answer::Read(Query { opcode, first: axis.index() as u8, count: 1, which: 0 })
}

/// Admits any command that becomes operations or a read. PT data, PVT points, program control and
/// what the dispatcher does by itself are handled before.
pub fn admit<const AXES: usize>(context: &mut Context<AXES>, number: u16, body: &[u8]) -> Admitted<Answer> {
    macro_rules! to {
        ($name:ident, $function:path) => {
            $function(context, &one::<command::$name>(body)?)
        };
        (axes $name:ident, $axis:ident) => {{
            let r = one::<command::$name>(body)?;
            read(context, number, r.core.get(), r.$axis.get(), r.count.get())
        }};
        (axis $name:ident, $axis:ident) => {{
            let r = one::<command::$name>(body)?;
            context.axis(r.core.get(), r.$axis.get()).map(|axis| query(number, axis))
        }};
        (laser $name:ident) => {{
            let r = one::<command::$name>(body)?;
            laser::read(context, number, r.core.get(), r.channel.get())
        }};
    }
    match number {
        opcode::Version => one::<command::Version>(body).map(|_| plain(number)),
        opcode::GetClock => one::<command::GetClock>(body).map(|_| plain(number)),
        opcode::GetFault => one::<command::GetFault>(body).map(|_| plain(number)),
        opcode::GetEvents => one::<command::GetEvents>(body).map(|_| plain(number)),
        opcode::KeepAlive => one::<command::KeepAlive>(body).map(|_| Answer::Done),
        opcode::Reset => to!(Reset, session::reset),
        opcode::ClrSts => to!(ClrSts, session::clear_status),
        opcode::SetTick => to!(SetTick, session::tick),
        opcode::Choose => to!(Choose, session::choose),
        opcode::Trace => to!(Trace, session::trace),
        opcode::SetLinkLoss => to!(SetLinkLoss, session::link_loss),
        opcode::GetLinkLoss => one::<command::GetLinkLoss>(body).map(|_| plain(number)),
        opcode::GetTickTime => one::<command::GetTickTime>(body).map(|_| plain(number)),
        opcode::SetInterlock => to!(SetInterlock, session::interlock),
        opcode::Abort => to!(Abort, session::abort),
        opcode::LoadConfig => session::load_config(context, body),

        opcode::AxisOn => to!(AxisOn, axis::on),
        opcode::AxisOff => to!(AxisOff, axis::off),
        opcode::Stop => to!(Stop, axis::stop),
        opcode::ZeroPos => to!(ZeroPos, axis::zero),
        opcode::SetPrfPos => to!(SetPrfPos, axis::set_position),
        opcode::SynchAxisPos => to!(SynchAxisPos, axis::synchronise),
        opcode::SetStopDec => to!(SetStopDec, axis::stop_dec),
        opcode::GetStopDec => to!(axis GetStopDec, profile),
        opcode::SetAxisBand => to!(SetAxisBand, axis::band),
        opcode::GetAxisBand => to!(axis GetAxisBand, axis),
        opcode::GetSts => to!(axes GetSts, axis),
        opcode::GetPrfPos => to!(axes GetPrfPos, profile),
        opcode::GetPrfVel => to!(axes GetPrfVel, profile),
        opcode::GetPrfAcc => to!(axes GetPrfAcc, profile),
        opcode::GetPrfMode => to!(axes GetPrfMode, profile),
        opcode::GetEncPos => to!(axes GetEncPos, encoder),
        opcode::GetEncVel => to!(axes GetEncVel, encoder),
        opcode::SetEncPos => to!(SetEncPos, axis::set_encoder),
        opcode::SetSoftLimit => to!(SetSoftLimit, axis::soft_limit),
        opcode::GetSoftLimit => to!(axis GetSoftLimit, axis),
        opcode::LmtsOn => to!(LmtsOn, axis::limits_on),
        opcode::LmtsOff => to!(LmtsOff, axis::limits_off),
        opcode::LmtSns => to!(LmtSns, axis::limit_sense),
        opcode::AlarmOn => to!(AlarmOn, axis::alarm_on),
        opcode::AlarmOff => to!(AlarmOff, axis::alarm_off),
        opcode::SetPosErr => to!(SetPosErr, axis::position_error),
        opcode::GetPosErr => to!(axis GetPosErr, control),
        opcode::SetCaptureMode => to!(SetCaptureMode, axis::capture),
        opcode::GetCaptureStatus => to!(axes GetCaptureStatus, encoder),
        opcode::AxisStatus => {
            let r = one::<command::AxisStatus>(body)?;
            let (first, count) = context.span(r.core.get(), r.axis.get(), r.count.get())?;
            within(2, count, 1, STATUS_ITEMS_MAX)?;
            Ok(Answer::Read(Query { opcode: number, first: first.index() as u8, count, which: 0 }))
        }

        opcode::PrfTrap => to!(PrfTrap, jog_trap::trap),
        opcode::SetTrapPrm => to!(SetTrapPrm, jog_trap::set_trap),
        opcode::GetTrapPrm => to!(GetTrapPrm, jog_trap::trap_prm),
        opcode::PrfJog => to!(PrfJog, jog_trap::jog),
        opcode::SetJogPrm => to!(SetJogPrm, jog_trap::set_jog),
        opcode::GetJogPrm => to!(GetJogPrm, jog_trap::jog_prm),
        opcode::SetPos => to!(SetPos, jog_trap::set_pos),
        opcode::GetPos => to!(axis GetPos, profile),
        opcode::SetVel => to!(SetVel, jog_trap::set_vel),
        opcode::GetVel => to!(axis GetVel, profile),
        opcode::Update => to!(Update, jog_trap::update),

        opcode::GetDi => to!(GetDi, io::inputs),
        opcode::SetDo => to!(SetDo, io::set_outputs),
        opcode::GetDo => to!(GetDo, io::outputs),
        opcode::SetDoBit => to!(SetDoBit, io::set_output),
        opcode::GetDiEx => to!(GetDiEx, io::input_words),
        opcode::GetDoEx => to!(GetDoEx, io::output_words),
        opcode::SetDoEx => io::set_output_words(context, body),
        opcode::SetDac => io::set_analog(context, body),
        opcode::GetDac => to!(GetDac, io::analog_outputs),
        opcode::GetAdc => to!(GetAdc, io::analog_inputs),
        opcode::SimInput => to!(SimInput, simulated::input),
        opcode::SimAdc => to!(SimAdc, simulated::analog),
        opcode::SimPlan => to!(SimPlan, simulated::plan),
        opcode::GetWait => to!(axis GetWait, axis),

        opcode::PrfPt => to!(PrfPt, pt::mode),
        opcode::PtSpace => to!(PtSpace, pt::space),
        opcode::PtClear => to!(PtClear, pt::clear),
        opcode::SetPtLoop => to!(SetPtLoop, pt::set_loop),
        opcode::GetPtLoop => to!(GetPtLoop, pt::passes),
        opcode::SetPtMemory => to!(SetPtMemory, pt::set_memory),
        opcode::GetPtMemory => to!(GetPtMemory, pt::memory),
        opcode::PtStart => to!(PtStart, pt::start),
        opcode::GetPtState => to!(axis GetPtState, profile),

        opcode::PrfPvt => to!(PrfPvt, pvt::mode),
        opcode::SetPvtLoop => to!(SetPvtLoop, pvt::set_loop),
        opcode::GetPvtLoop => to!(GetPvtLoop, pvt::passes),
        opcode::PvtStatus => to!(PvtStatus, pvt::status),
        opcode::PvtStart => to!(PvtStart, pvt::start),
        opcode::PvtTableSelect => to!(PvtTableSelect, pvt::select),
        opcode::LaserOn => to!(LaserOn, laser::on),
        opcode::LaserOff => to!(LaserOff, laser::off),
        opcode::LaserPowerMode => to!(LaserPowerMode, laser::energy::mode),
        opcode::LaserPrfCmd => to!(LaserPrfCmd, laser::energy::direct),
        opcode::LaserOutFrq => to!(LaserOutFrq, laser::energy::frequency),
        opcode::SetPulseWidth => to!(SetPulseWidth, laser::energy::width),
        opcode::SetWaitPulse => to!(SetWaitPulse, laser::energy::standby_one),
        opcode::SetWaitPulseEx => to!(SetWaitPulseEx, laser::energy::standby_all),
        opcode::SetPreVltg => to!(SetPreVltg, laser::energy::pre_voltage),
        opcode::SetLevelDelay => to!(SetLevelDelay, laser::delays),
        opcode::EnaFPK => to!(EnaFPK, laser::fpk_on),
        opcode::DisFPK => to!(DisFPK, laser::fpk_off),
        opcode::SetLaserMode => to!(SetLaserMode, laser::energy::resolution),
        opcode::ZeroLaserOnTime => to!(ZeroLaserOnTime, laser::zero_on_time),
        opcode::GetLaserOnTime => to!(laser GetLaserOnTime),
        opcode::SetLaserCrdMap => to!(SetLaserCrdMap, laser::map),
        opcode::GetLaserCrdMap => to!(laser GetLaserCrdMap),
        opcode::SetAxisMode => to!(SetAxisMode, laser::connector),
        opcode::GetLaserPower => to!(laser GetLaserPower),
        opcode::ClrLaserFault => to!(ClrLaserFault, laser::clear_fault),
        opcode::GetLaserFault => to!(laser GetLaserFault),
        opcode::LaserOnStatus => to!(laser LaserOnStatus),
        opcode::SetHSIOOpt => to!(SetHSIOOpt, laser::switch),
        opcode::GetHSIOOpt => to!(laser GetHSIOOpt),
        opcode::LaserStatus => to!(laser LaserStatus),
        opcode::SetCrdPrm => to!(SetCrdPrm, crd::set),
        opcode::CrdClear => to!(CrdClear, crd::clear),
        opcode::CrdSpace => to!(CrdSpace, crd::space),
        opcode::CrdStop => to!(CrdStop, crd::stop),
        opcode::SetCrdStopDec => to!(SetCrdStopDec, crd::stop_dec),
        opcode::SetOverride => to!(SetOverride, crd::set_override),
        opcode::SetLaserFollowFilter => to!(SetLaserFollowFilter, crd::set_follow_filter),
        opcode::InitLookAhead => to!(InitLookAhead, crd::look_ahead),
        opcode::SetCrdLimit => to!(SetCrdLimit, crd::limit),
        _ if is_crd(number) => crd::read(context, number, body),
        opcode::SetLaserDisMode => to!(SetLaserDisMode, laser::distance::mode),
        opcode::SetLaserDisRatio => to!(SetLaserDisRatio, laser::distance::ratios),
        _ if follow::is_follow(number) => follow::admit(context, number, body),
        _ => Err(Refused::new(Reason::UnknownCommand).got(number.into())),
    }
}

fn plain(opcode: u16) -> Answer {
    Answer::Read(Query { opcode, first: 0, count: 0, which: 0 })
}

/// Whether this command only reads (SPEC 7: accepted beside a program).
pub fn is_read(number: u16) -> bool {
    is_crd(number)
        || matches!(
            number,
            opcode::Version
                | opcode::GetClock
                | opcode::KeepAlive
                | opcode::GetFault
                | opcode::GetEvents
                | opcode::GetLinkLoss
                | opcode::GetTickTime
                | opcode::GetStopDec
                | opcode::GetAxisBand
                | opcode::GetSts
                | opcode::GetPrfPos
                | opcode::GetPrfVel
                | opcode::GetPrfAcc
                | opcode::GetPrfMode
                | opcode::GetEncPos
                | opcode::GetEncVel
                | opcode::GetSoftLimit
                | opcode::GetPosErr
                | opcode::GetCaptureStatus
                | opcode::AxisStatus
                | opcode::GetTrapPrm
                | opcode::GetJogPrm
                | opcode::GetPos
                | opcode::GetVel
                | opcode::GetDi
                | opcode::GetDo
                | opcode::GetDiEx
                | opcode::GetDoEx
                | opcode::GetDac
                | opcode::GetAdc
                | opcode::GetWait
                | opcode::GetLaserOnTime
                | opcode::GetLaserCrdMap
                | opcode::GetLaserPower
                | opcode::GetLaserFault
                | opcode::LaserOnStatus
                | opcode::GetHSIOOpt
                | opcode::LaserStatus
                | opcode::PtSpace
                | opcode::GetPtLoop
                | opcode::GetPtMemory
                | opcode::GetPtState
                | opcode::GetPvtLoop
                | opcode::PvtStatus
                | opcode::PvtPercentCalculate
                | opcode::PvtContinuousCalculate
                | opcode::GetFollowMaster
                | opcode::GetFollowMasterEx
                | opcode::GetFollowLoop
                | opcode::GetFollowLoopEx
                | opcode::GetFollowEvent
                | opcode::GetFollowEventEx
                | opcode::FollowSpace
                | opcode::FollowSpaceEx
                | opcode::GetFollowMemory
                | opcode::GetFollowMemoryEx
                | opcode::GetFollowStatus
                | opcode::GetFollowStatusEx
                | opcode::GetFollowDataPercent2Ex
        )
}
