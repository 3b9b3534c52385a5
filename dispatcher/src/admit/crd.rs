//! Coordinate systems: their parameters, start and stop, their reads. Data of paths is in
//! `crd_data`.
use super::context::Context;
use crate::plan::geometry::{Position, position_of};
use crate::plan::look_ahead::SPEED_MIN_PULSES_PER_MS;
use crate::plan::path_queue::PathQueue;
use crate::refuse::{Admitted, Refused, choice, finite, real, within};
use crate::report::answer::{Answer, Query};
use crate::shadow::{CrdChange, CrdParameters, LookAheadSettings, ShadowChange, executed};
use protocol::command::{
    CrdClear, CrdSpace, CrdStart, CrdStop, GetCrdLimit, GetRemainderSegNum, InitLookAhead, SetCrdLimit, SetCrdPrm,
    SetCrdStopDec, SetLaserFollowFilter, SetOverride, opcode,
};
use protocol::reason::Reason;
use servo::laser::FilterRate;
use servo::path::{DIMENSIONS, FeedOverride, PathStores, axis_map};
use servo::segment::ramp::Accel;
use servo::tick_command::{MotionMode, TickCommand};
use servo::units::{AxisMask, Crd, Pos};

/// Time constants of the filter of encoder speeds, ms; and 2⁶⁴.
const LAG_MS: (f64, f64) = (0.01, 1000.0);
const FULL_SHARE_Q64: f64 = 18_446_744_073_709_551_616.0;

/// Speeds, accelerations and times of a coordinate system are below this.
pub const CRD_SPEED_BOUND: f64 = 32767.0;
/// The lowest override.
const OVERRIDE_MIN_RATIO: f64 = 1.0 / 1048576.0;

/// A number above 0 and below 32767.
fn between(field: u8, got: f64) -> Admitted<f64> {
    if finite(field, got)? > 0.0 && got < CRD_SPEED_BOUND {
        return Ok(got);
    }
    Err(Refused::new(Reason::Between).field(field).got(got).limits(0.0, CRD_SPEED_BOUND))
}

fn accel(field: u8, got: f64) -> Admitted<Accel> {
    Accel::admit(got.to_bits()).map_err(|_| Refused::range(field, got, SPEED_MIN_PULSES_PER_MS, CRD_SPEED_BOUND))
}

/// Fields of SetCrdPrm after core and crd.
mod field {
    pub const DIMENSION: u8 = 2;
    pub const PROFILE: u8 = 3;
    pub const VEL_MAX: u8 = 4;
    pub const ACC_MAX: u8 = 5;
    pub const EVEN_TIME: u8 = 6;
    pub const SET_ORIGIN: u8 = 7;
}

/// Every coordinate up to the dimension is driven by one axis; elements of `profile` for axes that
/// the core does not have must be 0.
fn frame<const AXES: usize>(context: &Context<AXES>, r: &SetCrdPrm) -> Admitted<CrdParameters> {
    let dimension = within(field::DIMENSION, r.dimension.get(), 1, DIMENSIONS as i16)?;
    let axes = usize::from(context.configuration.profile.axes_per_core);
    let mut profile = [0; 8];
    for (index, (position, given)) in profile.iter_mut().zip(r.profile).enumerate() {
        let most = if index < axes { dimension } else { 0 };
        let coordinate = choice(field::PROFILE, given.get(), 0, most).map_err(|refused| refused.item(index))?;
        *position = coordinate as u8;
        let twice = coordinate != 0 && r.profile.iter().take(index).any(|before| before.get() == coordinate);
        if twice {
            let refused = Refused::new(Reason::CoordinateTwice).field(field::PROFILE).item(index);
            return Err(refused.got(coordinate.into()));
        }
    }
    for coordinate in 1..=dimension {
        if !profile.iter().any(|of| i16::from(*of) == coordinate) {
            let refused = Refused::new(Reason::CoordinateMissing).field(field::PROFILE);
            return Err(refused.got(coordinate.into()).limits(1.0, dimension.into()));
        }
    }
    let vel_max = between(field::VEL_MAX, r.syn_vel_max.get())?;
    let acc_max = between(field::ACC_MAX, r.syn_acc_max.get())?;
    real(field::VEL_MAX, vel_max, SPEED_MIN_PULSES_PER_MS, CRD_SPEED_BOUND)?;
    real(field::ACC_MAX, acc_max, SPEED_MIN_PULSES_PER_MS, CRD_SPEED_BOUND)?;
    let even_ms = within(field::EVEN_TIME, r.even_time_ms.get(), 0, i16::MAX - 1)?.unsigned_abs();
    let set_origin = choice(field::SET_ORIGIN, r.set_origin_flag.get(), 0, 1)? == 1;
    let first = (context.core(r.core.get())? * axes) as u8;
    let origin = r.origin_pos.map(|pos| pos.get());
    let dimension = dimension as u8;
    Ok(CrdParameters { dimension, profile, first, vel_max, acc_max, even_ms, set_origin, origin })
}

/// The axes are at standstill and in no other coordinate system that drives them; they are in Crd
/// mode from then on.
pub fn set<const AXES: usize>(context: &mut Context<AXES>, r: &SetCrdPrm) -> Admitted<Answer> {
    let crd = context.crd(r.core.get(), r.crd.get())?;
    let frame = frame(context, r)?;
    context.crd_at_standstill(crd)?;
    let axes = frame.axes();
    for axis in axes.into_iter().flatten() {
        context.nth(axis.index())?;
        let shadow = context.shadow(axis);
        if shadow.mode == MotionMode::Crd && shadow.crd != crd && context.shadows.driven(shadow.crd).has(axis) {
            return Err(context.no(Reason::AxisInCrd, axis).got(context.configuration.crd_number(shadow.crd).into()));
        }
        context.at_standstill(axis)?;
    }
    let mut origin = [0; DIMENSIONS];
    let mut here: Option<Position> = Some([0.0; DIMENSIONS]);
    for ((coordinate, axis), start) in axes.iter().enumerate().zip(&mut origin) {
        let Some(axis) = *axis else { continue };
        let number = axis.index() - usize::from(frame.first);
        *start = frame.origin.get(number).copied().unwrap_or(0);
        if frame.set_origin {
            let pos = context.position(axis);
            here = here.zip(pos).map(|(mut position, pos)| {
                let [at, ..] = position_of(&[Pos(pos.0.wrapping_sub(Pos::pulses(*start).0)); DIMENSIONS]);
                position.iter_mut().skip(coordinate).take(1).for_each(|position| *position = at);
                position
            });
        }
    }
    let admitted = axis_map::AxisMap::admit(axes, frame.set_origin.then_some(origin), frame.even_ms);
    let admitted = admitted.map_err(|refused| match refused {
        axis_map::Refused::NoAxis => Refused::new(Reason::CoordinateMissing).field(field::PROFILE).got(1.0),
        axis_map::Refused::Twice(axis) => context.no(Reason::CoordinateTwice, axis).field(field::PROFILE),
    })?;
    let dec = accel(field::ACC_MAX, frame.acc_max)?;
    let change = CrdChange::Frame { frame, here };
    context.stage_with(TickCommand::CrdFrame { crd, frame: admitted }, ShadowChange::Crd { crd, change });
    context.only(TickCommand::CrdStopDec { crd, dec }, ShadowChange::None)
}

/// The FIFO's number.
pub fn fifo(field: u8, fifo: i16) -> Admitted<u8> {
    Ok(choice(field, fifo, 0, 1)? as u8)
}

/// The coordinate system, if SetCrdPrm has been called for it.
pub fn known<const AXES: usize>(context: &Context<AXES>, core: i16, crd: i16) -> Admitted<Crd> {
    let crd = context.crd(core, crd)?;
    context.frame(crd)?;
    Ok(crd)
}

/// Position of the coordinate system at standstill for what follows; none while only the tick
/// knows.
///
/// Entries in flight that move nothing do not hide it. Its axes are at standstill, and their
/// positions, less the zero, are its position.
pub fn position_at_standstill<const AXES: usize>(context: &Context<AXES>, crd: Crd) -> Option<Position> {
    let (shadow, sampled) = (context.crd_shadow(crd), context.crd_sampled(crd));
    if let Some(here) = shadow.position_at_standstill(context.view, sampled) {
        return Some(here);
    }
    let frame = shadow.frame.as_ref().filter(|_| !shadow.is_busy(context.view, sampled))?;
    // SetCrdPrm clears both FIFOs.
    let is_framed = [0, 1].map(|fifo| shadow.path(fifo).cleared) == sampled.cleared;
    let mut position = [0.0; DIMENSIONS];
    for ((axis, sampled_zero), position) in frame.axes().into_iter().zip(sampled.origin).zip(&mut position) {
        let Some(axis) = axis else { continue };
        let of = context.shadow(axis);
        let pos = context.position(axis)?;
        let zero = if frame.set_origin {
            Pos::pulses(frame.origin.get(axis.index() - usize::from(frame.first)).copied().unwrap_or(0))
        } else if is_framed || of.position_set.is_none_or(|(seq, _)| executed(context.view, seq)) {
            // A SetCrdPrm that precedes what made the position unknown has been executed with it.
            sampled_zero
        } else {
            return None;
        };
        [*position, ..] = position_of(&[Pos(pos.0.wrapping_sub(zero.0)); DIMENSIONS]);
    }
    Some(position)
}

/// Both FIFOs are cleared at standstill only.
pub fn clear<const AXES: usize>(context: &mut Context<AXES>, r: &CrdClear) -> Admitted<Answer> {
    let crd = known(context, r.core.get(), r.crd.get())?;
    let fifo = fifo(2, r.fifo.get())?;
    context.crd_at_standstill(crd)?;
    // It moves nothing.
    let here = position_at_standstill(context, crd);
    context
        .only(TickCommand::CrdClear { crd, fifo }, ShadowChange::Crd { crd, change: CrdChange::Emptied { fifo, here } })
}

/// Whether a coordinate system can start with a FIFO.
fn startable<const AXES: usize>(context: &Context<AXES>, crd: Crd, fifo: u8) -> Admitted<()> {
    let frame = context.frame(crd)?;
    context.crd_at_standstill(crd)?;
    for axis in context.each(frame.mask()) {
        let shadow = context.shadow(axis);
        if shadow.mode != MotionMode::Crd || shadow.crd != crd {
            return Err(context.no(Reason::AxisLeftCrd, axis).got(context.configuration.crd_number(crd).into()));
        }
        context.at_standstill(axis)?;
    }
    if !context.crd_shadow(crd).path(fifo).data.is_open() {
        return Err(context.no_crd(Reason::CrdEmpty, crd).field(2).got(fifo.into()));
    }
    context.all_startable(frame.mask())
}

/// Starts all coordinate systems of the mask on one tick, or none. The tick gets the first part of
/// a look-ahead; the rest follows in time, or at the flush.
pub fn start<const AXES: usize>(
    context: &mut Context<AXES>,
    queues: &mut [[PathQueue; 2]],
    stores: PathStores,
    r: &CrdStart,
) -> Admitted<Answer> {
    let crds = context.crd_mask(r.core.get(), r.mask.get().into(), 1)?;
    if crds.0 == 0 {
        return Ok(Answer::Done);
    }
    // Option bits of others are ignored.
    let fifo1 = context.crd_mask(r.core.get(), (r.option.get() & r.mask.get()).into(), 2)?;
    for crd in crds.crds() {
        startable(context, crd, fifo1.has(crd).into())?;
    }
    for crd in crds.crds() {
        let fifo = u8::from(fifo1.has(crd));
        let index = crd.index();
        if let (Some(queues), Some(stores)) = (queues.get_mut(index), stores.get(index)) {
            let queue = &mut queues[usize::from(fifo)];
            queue.update_cleared(context.crd_shadow(crd).path(fifo).cleared);
            if queue.waiting() > 0 {
                queue.release_final(&stores[usize::from(fifo)]);
                queue.begin(stores, context.crd_sampled(crd), fifo);
                let (command, change) = context.shadows.commit_of_path(crd, fifo, queue.end());
                context.stage_with(command, change);
            }
        }
    }
    let may_fail = context.due.may_fail;
    context.only(TickCommand::CrdStart { crds, fifo1 }, ShadowChange::CrdStarted { crds, fifo1, may_fail })
}

/// Bits that the core does not have must be 0.
pub fn stop<const AXES: usize>(context: &mut Context<AXES>, r: &CrdStop) -> Admitted<Answer> {
    let crds = context.crd_mask(r.core.get(), r.mask.get(), 1)?;
    let abrupt = context.crd_mask(r.core.get(), r.option.get() & r.mask.get(), 2)?;
    if crds.0 != 0 {
        context.stage_with(TickCommand::stop_crds(crds, abrupt), ShadowChange::Stopped { axes: AxisMask(0), crds });
    }
    Ok(Answer::Done)
}

/// An abrupt stop takes no time (SPEC 4), so its deceleration is kept and has no effect.
pub fn stop_dec<const AXES: usize>(context: &mut Context<AXES>, r: &SetCrdStopDec) -> Admitted<Answer> {
    let crd = known(context, r.core.get(), r.crd.get())?;
    let (smooth, abrupt) = (between(2, r.smooth.get())?, between(3, r.abrupt.get())?);
    let dec = accel(2, smooth)?;
    context
        .only(TickCommand::CrdStopDec { crd, dec }, ShadowChange::Crd { crd, change: CrdChange::Dec((smooth, abrupt)) })
}

pub fn set_override<const AXES: usize>(context: &mut Context<AXES>, r: &SetOverride) -> Admitted<Answer> {
    let crd = known(context, r.core.get(), r.crd.get())?;
    let ratio = real(2, r.ratio.get(), OVERRIDE_MIN_RATIO, 1.0)?;
    let rate = FeedOverride::admit(ratio.to_bits()).map_err(|_| Refused::range(2, ratio, OVERRIDE_MIN_RATIO, 1.0))?;
    context.only(TickCommand::CrdOverride { crd, rate }, ShadowChange::Crd { crd, change: CrdChange::Override(ratio) })
}

/// The filter of the encoder speed that lasers follow: 0 is none.
pub fn set_follow_filter<const AXES: usize>(context: &mut Context<AXES>, r: &SetLaserFollowFilter) -> Admitted<Answer> {
    let crd = known(context, r.core.get(), r.crd.get())?;
    let ms = real(2, r.time_ms.get(), 0.0, LAG_MS.1)?;
    if ms != 0.0 && ms < LAG_MS.0 {
        return Err(Refused::range(2, ms, LAG_MS.0, LAG_MS.1));
    }
    let lag = if ms == 0.0 { FilterRate::NONE } else { FilterRate::of_inverse((FULL_SHARE_Q64 / (ms * 1e6)) as u64) };
    context.only(TickCommand::CrdLag { crd, lag }, ShadowChange::Crd { crd, change: CrdChange::Lag(ms) })
}

/// `count` 0 switches the look-ahead off; a count above the board's is limited to it. The FIFO is
/// empty, or all of it has run.
pub fn look_ahead<const AXES: usize>(context: &mut Context<AXES>, r: &InitLookAhead) -> Admitted<Answer> {
    let crd = known(context, r.core.get(), r.crd.get())?;
    let fifo = fifo(2, r.fifo.get())?;
    let count = within(5, r.count.get(), 0, i16::MAX - 1)?.unsigned_abs();
    let look = if count == 0 {
        None
    } else {
        let corner = real(3, r.time_ms.get(), 0.0, CRD_SPEED_BOUND)?;
        Some(LookAheadSettings { corner, acc: between(4, r.acc_max.get())?, count })
    };
    if context.crd_shadow(crd).path(fifo).data.is_open() {
        return Err(context.no_crd(Reason::CrdHolds, crd).field(2).got(fifo.into()));
    }
    context.only(TickCommand::Mark, ShadowChange::Crd { crd, change: CrdChange::Look { fifo, look } })
}

/// Limits of one coordinate for look-ahead; 0 removes the limit. They hold for motions given from
/// now on to an empty look-ahead.
pub fn limit<const AXES: usize>(context: &mut Context<AXES>, r: &SetCrdLimit) -> Admitted<Answer> {
    let crd = known(context, r.core.get(), r.crd.get())?;
    let dimension = i16::from(context.frame(crd)?.dimension);
    let coordinate = choice(2, r.coordinate.get(), 1, dimension)? as u8 - 1;
    let number = |field, got: f64| if got == 0.0 { Ok(0.0) } else { between(field, got) };
    let limit = (number(3, r.vel_max.get())?, number(4, r.acc_max.get())?);
    context.only(TickCommand::Mark, ShadowChange::Crd { crd, change: CrdChange::Limit { coordinate, limit } })
}

pub fn query(opcode: u16, crd: Crd, which: u8) -> Answer {
    Answer::Read(Query { opcode, first: crd.index() as u8, count: 1, which })
}

/// Whether only the tick knows how much of a FIFO is over.
fn may_go_on<const AXES: usize>(context: &Context<AXES>, crd: Crd, fifo: u8) -> bool {
    let (shadow, sampled) = (context.crd_shadow(crd), context.crd_sampled(crd));
    shadow.path(fifo).data.is_open() && (context.crd_may_run(crd) || shadow.is_busy(context.view, sampled))
}

/// The shadow state decides: what is given after it at its instant does not count. Only of a FIFO
/// that may go on, the tick decides.
pub fn space<const AXES: usize>(context: &mut Context<AXES>, r: &CrdSpace) -> Admitted<Answer> {
    let crd = known(context, r.core.get(), r.crd.get())?;
    let fifo = fifo(2, r.fifo.get())?;
    if may_go_on(context, crd, fifo) {
        return Ok(query(opcode::CrdSpace, crd, fifo));
    }
    Ok(Answer::Long(context.crd_shadow(crd).space_ahead(context.crd_sampled(crd), fifo).cast_signed()))
}

/// As [`space`].
pub fn remainder<const AXES: usize>(context: &mut Context<AXES>, r: &GetRemainderSegNum) -> Admitted<Answer> {
    let crd = known(context, r.core.get(), r.crd.get())?;
    let fifo = fifo(2, r.fifo.get())?;
    if may_go_on(context, crd, fifo) {
        return Ok(query(opcode::GetRemainderSegNum, crd, fifo));
    }
    let shadow = context.crd_shadow(crd);
    let left = if shadow.path(fifo).data.is_open() { shadow.segments(context.crd_sampled(crd), fifo).1 } else { 0 };
    Ok(Answer::Long(i32::try_from(left).unwrap_or(i32::MAX)))
}

/// What SetCrdLimit has set for one coordinate.
pub fn limit_of<const AXES: usize>(context: &mut Context<AXES>, r: &GetCrdLimit) -> Admitted<Answer> {
    let crd = known(context, r.core.get(), r.crd.get())?;
    let dimension = i16::from(context.frame(crd)?.dimension);
    Ok(query(opcode::GetCrdLimit, crd, choice(2, r.coordinate.get(), 1, dimension)? as u8 - 1))
}
