//! Jog and Trap: modes, parameters, targets, Update.
use super::axis::{ACCEL_MAX_PULSES_PER_MS2, accel};
use super::context::Context;
use crate::refuse::{Admitted, Refused, real, within};
use crate::report::answer::Answer;
use crate::shadow::ShadowChange;
use protocol::command::{JogPrm, PrfTrap, SetJogPrm, SetPos, SetTrapPrm, SetVel, TrapPrm, Update};
use protocol::reason::Reason;
use servo::segment::ramp::{Accel, Speed};
use servo::tick_command::{MotionMode, TickCommand};
use servo::units::{Axis, AxisMask, Ns, StepLimit};

/// Longest smoothing of a Trap, ms.
const SMOOTH_MAX_MS: i16 = 500;

/// PrfTrap and PrfJog.
pub fn mode<const AXES: usize>(context: &mut Context<AXES>, r: &PrfTrap, mode: MotionMode) -> Admitted<Answer> {
    let axis = context.axis(r.core.get(), r.profile.get())?;
    set_mode(context, axis, mode)
}

/// A mode is set at standstill; the present mode is accepted without an effect.
pub fn set_mode<const AXES: usize>(context: &mut Context<AXES>, axis: Axis, mode: MotionMode) -> Admitted<Answer> {
    context.at_standstill(axis)?;
    if context.shadow(axis).mode != mode {
        context.stage_with(TickCommand::SetMode { axis, mode }, ShadowChange::Mode { axis, mode });
    }
    Ok(Answer::Done)
}

/// An acceleration that may be 0, which is "not set".
fn accel_or_none(field: u8, got: f64) -> Admitted<Accel> {
    real(field, got, 0.0, ACCEL_MAX_PULSES_PER_MS2)?;
    if got == 0.0 { Ok(Accel::default()) } else { accel(field, got) }
}

/// At most the step limit of the board.
fn speed(field: u8, got: f64, signed: bool, limit: StepLimit) -> Admitted<Speed> {
    let high = limit.pulses_per_ms() as f64;
    let low = if signed { -high } else { 0.0 };
    real(field, got, low, high)?;
    Speed::admit(got.to_bits(), limit).map_err(|_| Refused::range(field, got, low, high))
}

pub fn set_trap<const AXES: usize>(context: &mut Context<AXES>, r: &SetTrapPrm) -> Admitted<Answer> {
    let axis = context.axis(r.core.get(), r.profile.get())?;
    let (acc, dec) = (accel_or_none(2, r.acc.get())?, accel_or_none(3, r.dec.get())?);
    let vel_start = speed(4, r.vel_start.get(), false, context.board.step_limit)?;
    let smooth_ms = within(5, r.smooth_time_ms.get(), 0, SMOOTH_MAX_MS)?;
    context.in_mode(axis, context.shadow(axis).mode == MotionMode::Trap)?;
    let prm = TrapPrm { acc: r.acc, dec: r.dec, vel_start: r.vel_start, smooth_time_ms: r.smooth_time_ms };
    let smooth = Ns(u64::from(smooth_ms.unsigned_abs()) * 1_000_000);
    context.only(TickCommand::TrapPrm { axis, acc, dec, vel_start, smooth }, ShadowChange::Trap { axis, prm })
}

pub fn set_jog<const AXES: usize>(context: &mut Context<AXES>, r: &SetJogPrm) -> Admitted<Answer> {
    let axis = context.axis(r.core.get(), r.profile.get())?;
    let (acc, dec) = (accel_or_none(2, r.acc.get())?, accel_or_none(3, r.dec.get())?);
    let given = r.smooth.get();
    if given.is_nan() {
        return Err(Refused::new(Reason::NotFinite).field(4));
    }
    if !(0.0..1.0).contains(&given) {
        return Err(Refused::range(4, given, 0.0, 1.0));
    }
    context.in_mode(axis, context.shadow(axis).mode == MotionMode::Jog)?;
    // Rounded down to 2⁻¹⁶; a value below 1 cannot become 1.
    let smooth = (given * 65536.0) as u16;
    let prm = JogPrm { acc: r.acc, dec: r.dec, smooth: r.smooth };
    // A dec of 0 means acc (SPEC 5).
    let dec = if dec == Accel::default() { acc } else { dec };
    context.only(TickCommand::JogPrm { axis, acc, dec, smooth }, ShadowChange::Jog { axis, prm })
}

pub fn set_pos<const AXES: usize>(context: &mut Context<AXES>, r: &SetPos) -> Admitted<Answer> {
    let axis = context.axis_in(MotionMode::Trap, r.core.get(), r.profile.get())?;
    let pos = r.pos.get();
    context.only(TickCommand::TargetPosition { axis, pulses: pos }, ShadowChange::Pos { axis, pos })
}

pub fn set_vel<const AXES: usize>(context: &mut Context<AXES>, r: &SetVel) -> Admitted<Answer> {
    let axis = context.axis(r.core.get(), r.profile.get())?;
    let vel = r.vel.get();
    let speed = speed(2, vel, true, context.board.step_limit)?;
    context.in_mode(axis, matches!(context.shadow(axis).mode, MotionMode::Trap | MotionMode::Jog))?;
    context.only(TickCommand::TargetSpeed { axis, speed }, ShadowChange::Vel { axis, vel })
}

/// Starts Jog or Trap, or changes a running one, for all axes of the mask or none.
pub fn update<const AXES: usize>(context: &mut Context<AXES>, r: &Update) -> Admitted<Answer> {
    let axes = context.mask(r.core.get(), r.mask.get(), 1)?;
    for axis in context.each(axes) {
        let shadow = context.shadow(axis);
        context.in_mode(axis, matches!(shadow.mode, MotionMode::Trap | MotionMode::Jog))?;
        let (acc, dec) = match shadow.mode {
            MotionMode::Trap => (shadow.trap.acc.get(), shadow.trap.dec.get()),
            // A Jog dec of 0 means acc.
            _ => (shadow.jog.acc.get(), shadow.jog.acc.get()),
        };
        if acc == 0.0 || dec == 0.0 {
            let reason = if acc == 0.0 { Reason::NoAcceleration } else { Reason::NoDeceleration };
            return Err(context.no(reason, axis));
        }
    }
    context.start(axes, TickCommand::Update { axes }, ShadowChange::Started { axes, fifo1: AxisMask(0), script_ns: 0 })
}
