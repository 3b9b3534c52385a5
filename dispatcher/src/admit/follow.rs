//! Follow, FollowEx (GXN chapter 3) and Gear commands, apart from data (see
//! [`super::follow_data`]). The modes share settings and layouts; a command counts only in its own
//! mode.
//!
//! The tick decides what a switch does to the FIFOs. A command that depends on it is refused until
//! the view shows the state in which it acts ([`decided`](super::context::DueInstant::decided)). In
//! a program it waits for its instant.
use super::context::Context;
use super::{one, unknown};
use crate::plan::asymmetric_s;
use crate::refuse::{Admitted, Refused, choice, within};
use crate::report::answer::Answer;
use crate::shadow::ShadowChange;
use protocol::command::{
    Chapter, FollowClear, FollowSpace, FollowStart, FollowSwitch, FollowSwitchNowEx, GetFollowDataPercent2Ex,
    PrfFollow, SetFollowEvent, SetFollowLoop, SetFollowMaster, SetFollowMemory, chapter, opcode,
};
use protocol::reason::Reason;
use protocol::values::master as master_type;
use servo::segment::follow::{Direction, Master, MasterPosition, Method, StartEvent};
use servo::tick_command::{MotionMode, TickCommand};
use servo::units::{Axis, AxisMask};

/// The mode that a command is for.
pub fn mode_of(number: u16) -> MotionMode {
    match chapter(number) {
        Chapter::FollowEx => MotionMode::FollowEx,
        Chapter::Gear => MotionMode::Gear,
        _ => MotionMode::Follow,
    }
}

/// Admits any of them but data and reads of one axis.
pub fn admit<const AXES: usize>(context: &mut Context<AXES>, number: u16, body: &[u8]) -> Admitted<Answer> {
    let mode = mode_of(number);
    match number {
        opcode::PrfFollow | opcode::PrfFollowEx | opcode::PrfGear => prf(context, mode, &one(body)?),
        opcode::SetFollowMaster | opcode::SetFollowMasterEx | opcode::SetGearMaster => {
            set_master(context, mode, &one(body)?)
        }
        opcode::SetFollowLoop | opcode::SetFollowLoopEx => set_loop(context, mode, &one(body)?),
        opcode::SetFollowEvent | opcode::SetFollowEventEx => set_event(context, mode, &one(body)?),
        opcode::FollowSpace | opcode::FollowSpaceEx => space(context, mode, &one(body)?),
        opcode::FollowClear | opcode::FollowClearEx => clear(context, mode, &one(body)?),
        opcode::FollowStart | opcode::FollowStartEx => start(context, mode, &one(body)?),
        opcode::FollowSwitch | opcode::FollowSwitchEx => switch(context, mode, &one(body)?),
        opcode::SetFollowMemory | opcode::SetFollowMemoryEx => set_memory(context, mode, &one(body)?),
        opcode::FollowSwitchNowEx => switch_now(context, &one(body)?),
        opcode::SetGearRatio => super::gear::set_ratio(context, &one(body)?),
        opcode::SetGearEvent => super::gear::set_event(context, &one(body)?),
        opcode::GearStart => super::gear::start(context, &one(body)?),
        opcode::GetFollowDataPercent2Ex => asymmetric_segment(context, &one(body)?),
        other => Err(unknown(other)),
    }
}

/// Any positive direction is +1, any negative −1. The present mode keeps everything, but must be
/// given with the same direction.
fn prf<const AXES: usize>(context: &mut Context<AXES>, mode: MotionMode, r: &PrfFollow) -> Admitted<Answer> {
    let axis = context.axis(r.core.get(), r.profile.get())?;
    let sign = r.dir.get().signum() as i8;
    let shadow = context.shadow(axis);
    let answer = super::jog_trap::set_mode(context, axis, mode)?;
    if shadow.mode == mode {
        if shadow.follow.direction != sign {
            return Err(context.no(Reason::DirectionDiffers, axis).field(2).got(shadow.follow.direction.into()));
        }
        return Ok(answer);
    }
    let direction = direction(sign);
    context.stage_with(TickCommand::FollowDirection { axis, direction }, ShadowChange::FollowDirection { axis, sign });
    context.stage(TickCommand::FollowEvent { axis, event: StartEvent::Start });
    Ok(answer)
}

/// The direction of a sign.
pub fn direction(sign: i8) -> Direction {
    match sign {
        0 => Direction::Both,
        1 => Direction::Up,
        _ => Direction::Down,
    }
}

/// The core whose axes a master type counts: the axis's own, or the other one of two.
fn core_of<const AXES: usize>(context: &Context<AXES>, core: i16, given: i16) -> Admitted<i16> {
    let own = matches!(given, master_type::ENCODER | master_type::PROFILE | master_type::AXIS);
    let other = matches!(given, master_type::ENCODER_OTHER | master_type::AXIS_OTHER)
        && context.configuration.profile.cores == 2;
    match (own, other) {
        (true, _) => Ok(core),
        (_, true) => Ok(3 - core),
        _ => Err(Refused::new(Reason::MasterType).field(3).got(given.into())),
    }
}

/// At standstill. Only an axis that follows has a master, so a cycle can only arise here.
fn set_master<const AXES: usize>(
    context: &mut Context<AXES>,
    mode: MotionMode,
    r: &SetFollowMaster,
) -> Admitted<Answer> {
    let axis = context.axis_in(mode, r.core.get(), r.profile.get())?;
    let given = [r.master_index.get(), r.master_type.get(), r.master_item.get()];
    let core = core_of(context, r.core.get(), given[1])?;
    choice(2, given[0], 1, i16::from(context.configuration.profile.axes_per_core))?;
    let master = context.axis(core, given[0])?;
    if master == axis {
        return Err(context.no(Reason::OwnMaster, axis).field(2).got(given[0].into()));
    }
    context.at_standstill(axis)?;
    let mut next = master;
    // A chain without a cycle is shorter than the number of axes.
    for _ in 0..AXES {
        let shadow = context.shadow(next);
        let Some((after, _)) = shadow.follow.master.filter(|_| shadow.is_follow()) else { break };
        if after == axis {
            let (number, core) =
                (f64::from(context.configuration.number_of(next)), f64::from(context.configuration.core_of(next)));
            return Err(context.no(Reason::MasterCycle, axis).field(2).got(number).limits(core, core));
        }
        next = after;
    }
    let value = match (given[1], given[2]) {
        (master_type::PROFILE, _) | (master_type::AXIS | master_type::AXIS_OTHER, 0) => MasterPosition::Planned,
        (master_type::AXIS | master_type::AXIS_OTHER, 2) => MasterPosition::PlannedFiltered,
        (master_type::AXIS | master_type::AXIS_OTHER, 3) => MasterPosition::EncoderFiltered,
        // An encoder, and every other item of an axis.
        _ => MasterPosition::Encoder,
    };
    let command = TickCommand::FollowMaster { axis, master: Master { axis: master, value } };
    context.only(command, ShadowChange::FollowMaster { axis, master, given })
}

/// Below 1 is endless; has effect also while the axis runs.
fn set_loop<const AXES: usize>(context: &mut Context<AXES>, mode: MotionMode, r: &SetFollowLoop) -> Admitted<Answer> {
    let axis = context.axis_in(mode, r.core.get(), r.profile.get())?;
    context.only(TickCommand::FollowLoop { axis, passes: r.loop_count.get().max(0).unsigned_abs() }, ShadowChange::None)
}

/// Has effect from the next start on. The direction matters for PASS only.
fn set_event<const AXES: usize>(context: &mut Context<AXES>, mode: MotionMode, r: &SetFollowEvent) -> Admitted<Answer> {
    let axis = context.axis_in(mode, r.core.get(), r.profile.get())?;
    let (which, direction, pos) = (choice(2, r.event.get(), 1, 2)?, r.master_dir.get(), r.pos.get());
    if which == 2 && direction != 1 && direction != -1 {
        return Err(Refused::new(Reason::CrossingDirection).field(3).got(direction.into()));
    }
    choice(3, direction, -1, 1)?;
    let event = if which == 1 { StartEvent::Start } else { StartEvent::Pass { up: direction > 0, pos } };
    let given = (which, direction, pos);
    context.only(TickCommand::FollowEvent { axis, event }, ShadowChange::FollowEvent { axis, given })
}

fn space<const AXES: usize>(context: &mut Context<AXES>, mode: MotionMode, r: &FollowSpace) -> Admitted<Answer> {
    let axis = context.axis_in(mode, r.core.get(), r.profile.get())?;
    let fifo = choice(2, r.fifo.get(), 0, 1)? as u8;
    context.knows_follow_fifo(axis, 2)?;
    Ok(Answer::Space(context.shadow(axis).follow.space(fifo) as i16))
}

/// The FIFO that runs cannot be cleared, the other one can.
fn clear<const AXES: usize>(context: &mut Context<AXES>, mode: MotionMode, r: &FollowClear) -> Admitted<Answer> {
    let axis = context.axis_in(mode, r.core.get(), r.profile.get())?;
    let fifo = choice(2, r.fifo.get(), 0, 1)? as u8;
    let (shadow, sampled) = (context.shadow(axis), context.sampled(axis));
    context.knows_follow_fifo(axis, 2)?;
    if context.may_run(axis) {
        let running = shadow.running_fifo(context.view, sampled) == fifo;
        if running || shadow.is_switching(context.view, sampled) {
            let reason = if running { Reason::FifoInUse } else { Reason::SwitchPending };
            return Err(context.no(reason, axis).field(2).got(fifo.into()));
        }
    }
    context.only(TickCommand::FollowClear { axis, fifo }, ShadowChange::FollowEmptied { axis, fifo })
}

/// At standstill. Clears the data, even if the size stays.
fn set_memory<const AXES: usize>(
    context: &mut Context<AXES>,
    mode: MotionMode,
    r: &SetFollowMemory,
) -> Admitted<Answer> {
    let axis = context.axis_in(mode, r.core.get(), r.profile.get())?;
    let memory = choice(2, r.memory.get(), 0, 1)? as u8;
    context.at_standstill(axis)?;
    context.knows_follow_fifo(axis, 2)?;
    context.stage_with(TickCommand::FollowClear { axis, fifo: 1 }, ShadowChange::FollowEmptied { axis, fifo: 1 });
    context.only(TickCommand::FollowClear { axis, fifo: 0 }, ShadowChange::FollowMemory { axis, memory })
}

/// Starts all axes of the mask on one tick, or none. Option bits take FIFO 1.
fn start<const AXES: usize>(context: &mut Context<AXES>, mode: MotionMode, r: &FollowStart) -> Admitted<Answer> {
    let axes = context.mask(r.core.get(), r.mask.get(), 1)?;
    let fifo1 = context.mask(r.core.get(), r.option.get() & r.mask.get(), 2)?;
    for axis in context.each(axes) {
        context.in_mode(axis, context.shadow(axis).mode == mode)?;
        context.at_standstill(axis)?;
        context.knows_follow_fifo(axis, 2)?;
        if context.shadow(axis).follow.master.is_none() {
            return Err(context.no(Reason::NoMaster, axis));
        }
        context.has_follow_data(axis, u8::from(fifo1.has(axis)))?;
    }
    context.start(axes, TickCommand::FollowStart { axes, fifo1 }, ShadowChange::Started { axes, fifo1, script_ns: 0 })
}

/// The other FIFO takes over at the end of the pass, of all axes of the mask or none.
fn switch<const AXES: usize>(context: &mut Context<AXES>, mode: MotionMode, r: &FollowSwitch) -> Admitted<Answer> {
    let axes = context.mask(r.core.get(), r.mask.get(), 1)?;
    for axis in context.each(axes) {
        context.in_mode(axis, context.shadow(axis).mode == mode)?;
        context.may_switch(axis)?;
    }
    context.for_axes(axes, TickCommand::FollowSwitch { axes }, ShadowChange::Switched { axes })
}

/// At once. (Queued, it is data.)
fn switch_now<const AXES: usize>(context: &mut Context<AXES>, r: &FollowSwitchNowEx) -> Admitted<Answer> {
    let axis = context.axis_in(MotionMode::FollowEx, r.core.get(), r.profile.get())?;
    let method = method(r.method.get())?;
    choice(4, r.fifo.get(), 0, 1)?;
    match method {
        Method::Table => context.may_switch(axis)?,
        Method::Segment if !context.may_run(axis) => return Err(context.no(Reason::NotRunning, axis)),
        Method::Segment => {}
    }
    let axes = if method == Method::Table { axis.mask() } else { AxisMask(0) };
    context.stage_with(TickCommand::FollowSwitchNow { axis, method }, ShadowChange::Switched { axes });
    // Answered like data; the FIFO is the one that was named.
    Ok(Answer::Entered { axis, fifo: r.fifo.get() as u8, percent1: 0 })
}

/// Segment 1, table 2.
pub fn method(given: i16) -> Admitted<Method> {
    Ok(if choice(2, given, 1, 2)? == 1 { Method::Segment } else { Method::Table })
}

/// Slave displacement of an asymmetric segment (see [`asymmetric_s`]).
fn asymmetric_segment<const AXES: usize>(context: &mut Context<AXES>, r: &GetFollowDataPercent2Ex) -> Admitted<Answer> {
    context.core(r.core.get())?;
    let numbers = [r.master_pos, r.vel_begin_ratio, r.vel_end_ratio, r.percent, r.percent1];
    for (field, number) in (1..).zip(numbers) {
        if !number.get().is_finite() {
            return Err(Refused::new(Reason::NotFinite).field(field));
        }
    }
    let [master, begin, end, percent, percent1] = numbers.map(|number| number.get());
    let percent = within(4, percent, 0.0, 100.0)?;
    let percent1 = within(5, percent1, 0.0, percent)?;
    let slave = master * asymmetric_s::mean(begin, end, percent / 100.0, percent1 / 100.0);
    if slave.is_finite() { Ok(Answer::Number(slave)) } else { Err(Refused::new(Reason::NotFinite).field(1)) }
}

impl<const AXES: usize> Context<'_, AXES> {
    /// Refuses until it is known which FIFO runs when the command acts.
    pub fn knows_follow_fifo(&self, axis: Axis, field: u8) -> Admitted<()> {
        // The tick switches in its steps, and there is none between the view and the instant.
        if self.is_due(axis) || !self.shadow(axis).may_switch(self.view, self.sampled(axis)) {
            return Ok(());
        }
        Err(self.no(Reason::FifoInUse, axis).field(field).got(self.sampled(axis).fifo.into()))
    }

    /// Refuses if a FIFO holds nothing.
    fn has_follow_data(&self, axis: Axis, fifo: u8) -> Admitted<()> {
        if self.shadow(axis).follow.fifo(fifo).is_empty() {
            return Err(self.no(Reason::FifoEmpty, axis).got(fifo.into()));
        }
        Ok(())
    }

    /// Refuses if the axis does not run, or its other FIFO holds nothing.
    fn may_switch(&self, axis: Axis) -> Admitted<()> {
        if !self.may_run(axis) {
            return Err(self.no(Reason::NotRunning, axis));
        }
        self.knows_follow_fifo(axis, 1)?;
        self.has_follow_data(axis, self.shadow(axis).running_fifo(self.view, self.sampled(axis)) ^ 1)
    }
}
