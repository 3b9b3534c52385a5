//! Admission: one function for each command, from the wire's struct to staged tick commands.
//!
//! In: a record. Out: the answer once it is executed, with the tick commands staged; or a refusal,
//! and then nothing has changed. The only folder where the user's doubles become the tick's
//! numbers.
pub mod admission;
mod axis;
pub(crate) mod context;
pub mod crd;
pub mod crd_data;
pub mod data;
mod follow;
mod follow_data;
mod gear;
mod io;
mod jog_trap;
pub mod joined;
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
mod upload;
pub mod written;

use crate::configuration::ones;
use crate::refuse::{Admitted, Refused, within};
use crate::report::answer::{Answer, Query};
use context::Context;
use protocol::command::{self, CommandKind, Nothing, ReadOf, Request, opcode};
use protocol::reason::Reason;
use servo::tick_command::MotionMode;
use servo::units::{Axis, AxisMask};
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

fn query(opcode: u16, axis: Axis) -> Answer {
    Answer::Read(Query { opcode, first: axis.index() as u8, count: 1, which: 0 })
}

fn plain(opcode: u16) -> Answer {
    Answer::Read(Query { opcode, first: 0, count: 0, which: 0 })
}

/// A read whose layout is that of its kind ([`ReadOf`]): one struct stands for all of them.
fn read<const AXES: usize>(context: &Context<AXES>, of: ReadOf, number: u16, body: &[u8]) -> Admitted<Answer> {
    match of {
        ReadOf::Controller => one::<command::GetClock>(body).map(|_| plain(number)),
        ReadOf::Axis => {
            let r = one::<command::GetVel>(body)?;
            let axis = context.axis(r.core.get(), r.profile.get())?;
            has_mode(context, number, axis)?;
            Ok(query(number, axis))
        }
        ReadOf::Axes => axes(context, number, &one(body)?),
        ReadOf::Follow => {
            let r = one::<command::GetFollowLoop>(body)?;
            context.axis_in(follow::mode_of(number), r.core.get(), r.profile.get()).map(|axis| query(number, axis))
        }
        ReadOf::Laser => context.read_laser(number, &one(body)?),
        ReadOf::Crd => {
            let r = one::<command::GetCrdVel>(body)?;
            crd::known(context, r.core.get(), r.crd.get()).map(|of| crd::query(number, of, 0))
        }
        ReadOf::CrdFifo => {
            let r = one::<command::CrdStatus>(body)?;
            let fifo = crd::fifo(2, r.fifo.get())?;
            crd::known(context, r.core.get(), r.crd.get()).map(|of| crd::query(number, of, fifo))
        }
        ReadOf::Other => Err(unknown(number)),
    }
}

/// A read of `count` consecutive axes.
fn axes<const AXES: usize>(context: &Context<AXES>, opcode: u16, r: &command::GetSts) -> Admitted<Answer> {
    let (first, count) = context.span(r.core.get(), r.axis.get(), r.count.get())?;
    if opcode == opcode::AxisStatus {
        within(2, count, 1, STATUS_ITEMS_MAX)?;
    }
    let all = AxisMask(ones(usize::from(count)) << first.index());
    context.each(all).try_for_each(|axis| has_mode(context, opcode, axis))?;
    Ok(Answer::Read(Query { opcode, first: first.index() as u8, count, which: 0 }))
}

/// Refuses a read that is for a mode, of an axis in another one.
fn has_mode<const AXES: usize>(context: &Context<AXES>, number: u16, axis: Axis) -> Admitted<()> {
    let shadow = context.shadow(axis);
    let wanted = match number {
        opcode::GetTrapPrm => shadow.mode == MotionMode::Trap,
        opcode::GetJogPrm => shadow.mode == MotionMode::Jog,
        opcode::GetPtLoop | opcode::GetPtMemory => shadow.is_pt(),
        opcode::GetPvtLoop | opcode::PvtStatus => shadow.mode == MotionMode::Pvt,
        _ => true,
    };
    context.in_mode(axis, wanted)?;
    if number == opcode::GetPtLoop { context.not_dynamic(axis) } else { Ok(()) }
}

fn unknown(number: u16) -> Refused {
    Refused::new(Reason::UnknownCommand).got(number.into())
}

/// Admits any command that becomes tick commands or a read. Data, tables, program control and what
/// the dispatcher does by itself are handled before.
pub fn admit<const AXES: usize>(context: &mut Context<AXES>, number: u16, body: &[u8]) -> Admitted<Answer> {
    if let Some(CommandKind::Read(of)) = kind(number)
        && of != ReadOf::Other
    {
        return read(context, of, number, body);
    }
    /// Each command of one struct and its function.
    macro_rules! route {
        ($($name:ident => $function:path,)* _ => $other:expr) => {
            match number {
                $(opcode::$name => $function(context, &one::<command::$name>(body)?),)*
                _ => $other,
            }
        };
    }
    route! {
        Reset => session::reset,
        ClrSts => session::clear_status,
        SetTick => session::tick,
        Choose => session::choose,
        Trace => session::trace,
        SetLinkLoss => session::link_loss,
        SetInterlock => session::interlock,
        Abort => session::abort,

        Stop => axis::stop,
        ZeroPos => axis::zero,
        SetPrfPos => axis::set_position,
        SynchAxisPos => axis::synchronise,
        SetStopDec => axis::stop_dec,
        SetAxisBand => axis::band,
        SetEncPos => axis::set_encoder,
        SetSoftLimit => axis::soft_limit,
        LmtSns => axis::limit_sense,
        SetPosErr => axis::position_error,
        SetCaptureMode => axis::capture,

        SetTrapPrm => jog_trap::set_trap,
        SetJogPrm => jog_trap::set_jog,
        SetPos => jog_trap::set_pos,
        SetVel => jog_trap::set_vel,
        Update => jog_trap::update,

        SetDo => io::set_outputs,
        SetDoBit => io::set_output,
        SetDoBitReverse => io::set_output_for,
        GetDiReverseCount => io::edges,
        GetDac => io::analog_outputs,
        GetAdc => io::analog_inputs,
        SimInput => simulated::input,
        SimAdc => simulated::analog,
        SimPlan => simulated::plan,

        PrfPt => pt::mode,
        PtSpace => pt::space,
        PtClear => pt::clear,
        SetPtLoop => pt::set_loop,
        SetPtMemory => pt::set_memory,
        PtStart => pt::start,

        PrfPvt => pvt::mode,
        SetPvtLoop => pvt::set_loop,
        PvtStart => pvt::start,
        PvtTableSelect => pvt::select,
        LaserPowerMode => laser::energy::mode,
        LaserPrfCmd => laser::energy::direct,
        LaserOutFrq => laser::energy::frequency,
        SetPulseWidth => laser::energy::width,
        SetWaitPulse => laser::energy::standby_one,
        SetWaitPulseEx => laser::energy::standby_all,
        SetPreVltg => laser::energy::pre_voltage,
        SetLevelDelay => laser::delays,
        EnaFPK => laser::fpk_on,
        DisFPK => laser::fpk_off,
        SetLaserMode => laser::energy::resolution,
        ZeroLaserOnTime => laser::zero_on_time,
        SetLaserCrdMap => laser::map,
        SetAxisMode => laser::connector,
        ClrLaserFault => laser::clear_fault,
        SetHSIOOpt => laser::switch,
        SetCrdPrm => crd::set,
        CrdClear => crd::clear,
        CrdSpace => crd::space,
        GetRemainderSegNum => crd::remainder,
        CrdStop => crd::stop,
        SetCrdStopDec => crd::stop_dec,
        SetOverride => crd::set_override,
        SetLaserFollowFilter => crd::set_follow_filter,
        InitLookAhead => crd::look_ahead,
        SetCrdLimit => crd::limit,
        GetCrdLimit => crd::limit_of,
        SetLaserDisMode => laser::distance::mode,
        SetLaserDisRatio => laser::distance::ratios,

        _ => match number {
            opcode::PrfTrap => jog_trap::mode(context, &one(body)?, MotionMode::Trap),
            opcode::PrfJog => jog_trap::mode(context, &one(body)?, MotionMode::Jog),
            opcode::AxisOn | opcode::AxisOff => axis::servo(context, &one(body)?, number == opcode::AxisOn),
            opcode::LmtsOn | opcode::LmtsOff => axis::limits(context, &one(body)?, number == opcode::LmtsOn),
            opcode::AlarmOn | opcode::AlarmOff => axis::alarm(context, &one(body)?, number == opcode::AlarmOn),
            opcode::LaserOn | opcode::LaserOff => laser::set(context, &one(body)?, number == opcode::LaserOn),
            opcode::GetDi | opcode::GetDo => io::levels(context, number, &one(body)?),
            opcode::GetDiEx | opcode::GetDoEx => io::words(context, number, &one(body)?),
            opcode::KeepAlive => one::<command::KeepAlive>(body).map(|_| Answer::Done),
            opcode::LoadConfig => session::load_config(context, body),
            opcode::SetDoEx => io::set_output_words(context, body),
            opcode::SetDac => io::set_analog(context, body),
            opcode::SetDiReverseCount => io::set_edges(context, body),
            _ => follow::admit(context, number, body),
        }
    }
}

/// What a command does, by its row in the protocol's table.
pub fn kind(number: u16) -> Option<CommandKind> {
    command::class(number).map(|class| class.kind)
}
