//! Axis commands: servo, stop, positions, limits, guarded inputs.
use super::context::Context;
use crate::refuse::{Admitted, Refused, choice, real, within};
use crate::report::answer::Answer;
use crate::shadow::{SOFT_OFF, ShadowChange};
use protocol::command::{
    AlarmOn, AxisOn, LmtSns, LmtsOn, SetAxisBand, SetCaptureMode, SetEncPos, SetPosErr, SetPrfPos, SetSoftLimit,
    SetStopDec, Stop, SynchAxisPos, ZeroPos,
};
use protocol::reason::Reason;
use protocol::values::FULL_SCALE;
use servo::segment::follow::Input;
use servo::segment::ramp::Accel;
use servo::tick_command::{Guarded, Guards, TickCommand};
use servo::units::{Axis, AxisMask, CYCLE_NS, Ns, Pos};

/// Accelerations up to here are accepted, pulse/ms².
pub const ACCEL_MAX_PULSES_PER_MS2: f64 = FULL_SCALE;
/// The following-error limit at this value is off.
pub const POS_ERR_OFF: i32 = i32::MAX;

/// AxisOn and AxisOff.
pub fn servo<const AXES: usize>(context: &mut Context<AXES>, r: &AxisOn, on: bool) -> Admitted<Answer> {
    let axis = context.axis(r.core.get(), r.axis.get())?;
    context.only(TickCommand::Servo { axis, on }, ShadowChange::Servo { axis, on })
}

/// `form` 0 is GTN (bits 0–31 are axes 1–32), 1 is GT (bits 0–7 axes, 8–9 crds, 10–11 their
/// follow).
pub fn stop<const AXES: usize>(context: &mut Context<AXES>, r: &Stop) -> Admitted<Answer> {
    let gt = choice(3, i16::from(r.form), 0, 1)? == 1;
    let (mask, option) = (r.mask.get(), r.option.get());
    if gt && mask & !0xfff != 0 {
        return Err(Refused::range(1, f64::from(mask.cast_unsigned()), 0.0, 4095.0));
    }
    let axes = context.mask(r.core.get(), if gt { mask & 0xff } else { mask }, 1)?;
    // Option bits of other axes are ignored.
    let abrupt = context.mask(r.core.get(), option & if gt { mask & 0xff } else { mask }, 2)?;
    let (named, hard) = if gt { (mask >> 8 & 3, option >> 8 & 3) } else { (0, 0) };
    let crds = context.crd_mask(r.core.get(), named, 1)?;
    let crds_abrupt = context.crd_mask(r.core.get(), hard & named, 2)?;
    if axes.0 != 0 || crds.0 != 0 {
        context.stage_with(TickCommand::Stop { axes, abrupt, crds, crds_abrupt }, ShadowChange::Stopped { axes, crds });
    }
    let follows = context.crd_mask(r.core.get(), if gt { mask >> 10 & 3 } else { 0 }, 1)?;
    if follows.0 != 0 {
        context.stage(TickCommand::FollowEnd { crds: follows });
    }
    Ok(Answer::Done)
}

pub fn zero<const AXES: usize>(context: &mut Context<AXES>, r: &ZeroPos) -> Admitted<Answer> {
    let axes = context.span_mask(r.core.get(), r.axis.get(), r.count.get())?;
    context.all_at_standstill(axes, Reason::Moving)?;
    context.only(TickCommand::Zero { axes }, ShadowChange::Placed { axes, pos: Pos(0) })
}

pub fn set_position<const AXES: usize>(context: &mut Context<AXES>, r: &SetPrfPos) -> Admitted<Answer> {
    let axis = context.axis(r.core.get(), r.profile.get())?;
    context.at_standstill(axis)?;
    let pos = Pos::pulses(r.pos.get());
    context.only(TickCommand::SetPosition { axis, pos }, ShadowChange::Placed { axes: axis.mask(), pos })
}

/// An axis here has no values of its own beside those of its profile and its encoder.
pub fn synchronise<const AXES: usize>(context: &mut Context<AXES>, r: &SynchAxisPos) -> Admitted<Answer> {
    context.mask(r.core.get(), r.mask.get(), 1)?;
    Ok(Answer::Done)
}

/// A deceleration that stops: above 0.
fn deceleration(field: u8, got: f64) -> Admitted<Accel> {
    real(field, got, f64::MIN_POSITIVE, ACCEL_MAX_PULSES_PER_MS2)?;
    accel(field, got)
}

/// An acceleration as the tick needs it.
pub fn accel(field: u8, got: f64) -> Admitted<Accel> {
    Accel::admit(got.to_bits()).map_err(|_| Refused::range(field, got, 0.0, ACCEL_MAX_PULSES_PER_MS2))
}

pub fn stop_dec<const AXES: usize>(context: &mut Context<AXES>, r: &SetStopDec) -> Admitted<Answer> {
    let axis = context.axis(r.core.get(), r.profile.get())?;
    context.stage_dec(axis, (2, 3), (r.smooth.get(), r.abrupt.get()))
}

pub fn band<const AXES: usize>(context: &mut Context<AXES>, r: &SetAxisBand) -> Admitted<Answer> {
    let axis = context.axis(r.core.get(), r.axis.get())?;
    context.stage_band(axis, (2, 3), (r.band.get(), r.time_cycles.get()))
}

pub fn set_encoder<const AXES: usize>(context: &mut Context<AXES>, r: &SetEncPos) -> Admitted<Answer> {
    let axis = context.axis(r.core.get(), r.encoder.get())?;
    context.only(TickCommand::SetEncoder { axis, pulses: i64::from(r.pos.get()) }, ShadowChange::None)
}

pub fn soft_limit<const AXES: usize>(context: &mut Context<AXES>, r: &SetSoftLimit) -> Admitted<Answer> {
    let axis = context.axis(r.core.get(), r.axis.get())?;
    context.stage_soft(axis, 2, (r.positive.get(), r.negative.get()))
}

/// LmtsOn and LmtsOff. Types: −1 both, 0 positive, 1 negative.
pub fn limits<const AXES: usize>(context: &mut Context<AXES>, r: &LmtsOn, on: bool) -> Admitted<Answer> {
    let axis = context.axis(r.core.get(), r.axis.get())?;
    let kind = choice(2, r.limit_type.get(), -1, 1)?;
    let positive = Guards::set(Guarded::LimitPositive, on);
    if on {
        let (positive, negative) = (kind != 1, kind != 0);
        context.has_limits(axis, positive, negative).map_err(|refused| refused.field(2).got(kind.into()))?;
    }
    let on = match kind {
        0 => positive,
        1 => Guards::set(Guarded::LimitNegative, on),
        _ => positive.and(Guarded::LimitNegative, on),
    };
    context.only(TickCommand::Guard { axis, on, low: Guards::NONE }, ShadowChange::None)
}

/// Bit 2k is the positive, bit 2k + 1 the negative limit of axis k + 1; 1 is active low. The word
/// covers the first 8 axes of a core; bits of axes that the core does not have are ignored. An
/// input that the board lacks would be active for ever with its bit set, so that is refused.
pub fn limit_sense<const AXES: usize>(context: &mut Context<AXES>, r: &LmtSns) -> Admitted<Answer> {
    let axes = context.core_mask(r.core.get())?;
    let sense = r.sense.get();
    for (k, axis) in context.each(axes).take(8).enumerate() {
        let bits = sense >> (2 * k);
        context.has_limits(axis, bits & 1 != 0, bits & 2 != 0).map_err(|refused| refused.field(1).got(sense.into()))?;
    }
    for (k, axis) in context.each(axes).take(8).enumerate() {
        let low = limit_levels((sense >> (2 * k)) as u8);
        context.stage(TickCommand::Guard { axis, on: Guards::NONE, low });
    }
    Ok(Answer::Done)
}

/// Bit 0 the positive, bit 1 the negative limit's sense.
pub fn limit_levels(bits: u8) -> Guards {
    Guards::set(Guarded::LimitPositive, bits & 1 != 0).and(Guarded::LimitNegative, bits & 2 != 0)
}

/// AlarmOn and AlarmOff.
pub fn alarm<const AXES: usize>(context: &mut Context<AXES>, r: &AlarmOn, on: bool) -> Admitted<Answer> {
    let axis = context.axis(r.core.get(), r.axis.get())?;
    context.has_alarm(axis, on).map_err(|refused| refused.field(1).got(r.axis.get().into()))?;
    context
        .only(TickCommand::Guard { axis, on: Guards::set(Guarded::Alarm, on), low: Guards::NONE }, ShadowChange::None)
}

pub fn position_error<const AXES: usize>(context: &mut Context<AXES>, r: &SetPosErr) -> Admitted<Answer> {
    let axis = context.axis(r.core.get(), r.control.get())?;
    context.stage_pos_err(axis, 2, r.error.get())
}

/// Modes: 1 home, 2 index, where the board captures it.
pub fn capture<const AXES: usize>(context: &mut Context<AXES>, r: &SetCaptureMode) -> Admitted<Answer> {
    let axis = context.axis(r.core.get(), r.encoder.get())?;
    let mode = choice(2, r.mode.get(), 1, 2)?;
    if mode == 1 {
        context.has_home(axis, true).map_err(|refused| refused.field(2).got(mode.into()))?;
    }
    if mode == 2 && !context.board.indexes.has(axis) {
        let refused = Refused::new(Reason::NoIndex).field(2).axis(r.encoder.get());
        return Err(refused.got(mode.into()).limits(1.0, 1.0));
    }
    context.only(TickCommand::Capture { axis, mode: mode as u8 }, ShadowChange::None)
}

impl<const AXES: usize> Context<'_, AXES> {
    /// Refuses a limit that is used, and that the board lacks.
    pub fn has_limits(&self, axis: Axis, positive: bool, negative: bool) -> Admitted<()> {
        let wired = self.board.wired;
        self.has(axis, positive, wired.limit_positive, Reason::NoLimitInput)?;
        self.has(axis, negative, wired.limit_negative, Reason::NoLimitInput)
    }

    /// The same for an alarm.
    pub fn has_alarm(&self, axis: Axis, used: bool) -> Admitted<()> {
        self.has(axis, used, self.board.wired.alarm, Reason::NoAlarmInput)
    }

    /// The same for a home switch.
    pub fn has_home(&self, axis: Axis, used: bool) -> Admitted<()> {
        self.has(axis, used, self.board.wired.home, Reason::NoHomeInput)
    }

    /// Refuses to wait for an input of an axis that the board lacks.
    pub fn has_input(&self, axis: Axis, input: Input) -> Admitted<()> {
        match input {
            Input::LimitPositive => self.has_limits(axis, true, false),
            Input::LimitNegative => self.has_limits(axis, false, true),
            Input::Alarm => self.has_alarm(axis, true),
            Input::Home => self.has_home(axis, true),
            Input::Arrive => self.has(axis, true, self.board.wired.arrive, Reason::NoArriveInput),
            Input::General => Ok(()),
        }
    }

    fn has(&self, axis: Axis, used: bool, wired: AxisMask, reason: Reason) -> Admitted<()> {
        if used && !wired.has(axis) {
            Err(Refused::new(reason).axis(self.configuration.number_of(axis)))
        } else {
            Ok(())
        }
    }

    pub fn stage_dec(&mut self, axis: Axis, fields: (u8, u8), dec: (f64, f64)) -> Admitted<Answer> {
        let (smooth, abrupt) = (deceleration(fields.0, dec.0)?, deceleration(fields.1, dec.1)?);
        self.only(TickCommand::StopDec { axis, smooth, abrupt }, ShadowChange::Dec { axis, dec })
    }

    pub fn stage_band(&mut self, axis: Axis, fields: (u8, u8), band: (i32, i32)) -> Admitted<Answer> {
        let (pulses, cycles) = (within(fields.0, band.0, 0, i32::MAX)?, within(fields.1, band.1, 0, i32::MAX)?);
        let time = Ns(u64::from(cycles.unsigned_abs()) * u64::from(CYCLE_NS));
        self.only(TickCommand::Band { axis, band: pulses.unsigned_abs(), time }, ShadowChange::Band { axis, band })
    }

    pub fn stage_soft(&mut self, axis: Axis, field: u8, soft: (i32, i32)) -> Admitted<Answer> {
        let positive = Some(soft.0).filter(|&limit| limit != SOFT_OFF.0);
        let negative = Some(soft.1).filter(|&limit| limit != SOFT_OFF.1);
        if let (Some(positive), Some(negative)) = (positive, negative) {
            within(field, positive, negative, i32::MAX)?;
        }
        self.only(TickCommand::SoftLimit { axis, positive, negative }, ShadowChange::Soft { axis, soft })
    }

    pub fn stage_pos_err(&mut self, axis: Axis, field: u8, error: i32) -> Admitted<Answer> {
        let pos_err = within(field, error, 1, POS_ERR_OFF)?;
        let limit = Some(pos_err.unsigned_abs()).filter(|_| pos_err != POS_ERR_OFF);
        self.only(TickCommand::PositionError { axis, limit }, ShadowChange::PosErr { axis, pos_err })
    }
}
