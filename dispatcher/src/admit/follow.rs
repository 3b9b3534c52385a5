//! Follow and FollowEx commands (GXN chapter 3), apart from data (see [`super::follow_data`]). The two modes share
//! settings and layouts; a command counts only in its own mode.
//!
//! What a switch does to the FIFOs is decided by the tick. Where a command depends on it, it is refused until the
//! view shows the state in which it acts ([`Case::decided`]); in a program that means it waits for its instant.
use super::axis::all_startable;
use super::{one, query};
use crate::books::Change;
use crate::case::{Answer, Case};
use crate::lopsided;
use crate::refuse::{Admitted, Refused, choice, within};
use protocol::command::{
    FollowClear, FollowSpace, FollowStart, FollowSwitch, FollowSwitchNowEx, GetFollowDataPercent2Ex, GetFollowMaster,
    PrfFollow, SetFollowEvent, SetFollowLoop, SetFollowMaster, SetFollowMemory, opcode,
};
use protocol::reason::Reason;
use servo::follow::{Direction, Event, Master, Method, Value};
use servo::op::{Mode, Op};
use servo::units::{Axis, AxisMask};

/// Master types (SPEC 3).
mod kind {
    pub const ENCODER: i16 = 1;
    pub const PROFILE: i16 = 2;
    pub const AXIS: i16 = 3;
    pub const ENCODER_OTHER: i16 = 101;
    pub const AXIS_OTHER: i16 = 103;
}

/// Whether a command belongs to one of the two modes.
pub fn is_follow(number: u16) -> bool {
    matches!(number >> 8, 4 | 5)
}

/// The mode that a command is for.
pub fn mode_of(number: u16) -> Mode {
    if number >> 8 == 5 { Mode::FollowEx } else { Mode::Follow }
}

/// Admits any of them.
pub fn admit<const AXES: usize>(case: &mut Case<AXES>, number: u16, body: &[u8]) -> Admitted<Answer> {
    let mode = mode_of(number);
    match number {
        opcode::PrfFollow | opcode::PrfFollowEx => prf(case, mode, &one(body)?),
        opcode::SetFollowMaster | opcode::SetFollowMasterEx => set_master(case, mode, &one(body)?),
        opcode::SetFollowLoop | opcode::SetFollowLoopEx => set_loop(case, mode, &one(body)?),
        opcode::SetFollowEvent | opcode::SetFollowEventEx => set_event(case, mode, &one(body)?),
        opcode::FollowSpace | opcode::FollowSpaceEx => space(case, mode, &one(body)?),
        opcode::FollowClear | opcode::FollowClearEx => clear(case, mode, &one(body)?),
        opcode::FollowStart | opcode::FollowStartEx => start(case, mode, &one(body)?),
        opcode::FollowSwitch | opcode::FollowSwitchEx => switch(case, mode, &one(body)?),
        opcode::SetFollowMemory | opcode::SetFollowMemoryEx => set_memory(case, mode, &one(body)?),
        opcode::FollowSwitchNowEx => switch_now(case, &one(body)?),
        opcode::GetFollowDataPercent2Ex => lopsided_segment(case, &one(body)?),
        opcode::GetFollowMaster
        | opcode::GetFollowMasterEx
        | opcode::GetFollowLoop
        | opcode::GetFollowLoopEx
        | opcode::GetFollowEvent
        | opcode::GetFollowEventEx
        | opcode::GetFollowMemory
        | opcode::GetFollowMemoryEx
        | opcode::GetFollowStatus
        | opcode::GetFollowStatusEx => {
            // They all have the same two fields.
            let r: GetFollowMaster = one(body)?;
            following(case, mode, r.core.get(), r.profile.get()).map(|axis| query(number, axis))
        }
        other => Err(Refused::new(Reason::UnknownCommand).got(other.into())),
    }
}

/// The axis, if it is in this mode.
pub fn following<const AXES: usize>(case: &Case<AXES>, mode: Mode, core: i16, profile: i16) -> Admitted<Axis> {
    let axis = case.axis(core, profile)?;
    case.in_mode(axis, case.book(axis).mode == mode)?;
    Ok(axis)
}

/// Refuses until it is known which FIFO runs when the command acts.
pub fn known<const AXES: usize>(case: &Case<AXES>, axis: Axis, field: u8) -> Admitted<()> {
    // The tick switches in its steps, and there is none between the view and the instant.
    if case.is_due(axis) || !case.book(axis).may_switch(case.view, case.seen(axis)) {
        return Ok(());
    }
    Err(case.no(Reason::FifoInUse, axis).field(field).got(case.seen(axis).fifo.into()))
}

/// Any positive direction is +1, any negative −1. The mode that the axis has already keeps everything, but has to
/// be asked for in the same direction.
fn prf<const AXES: usize>(case: &mut Case<AXES>, mode: Mode, r: &PrfFollow) -> Admitted<Answer> {
    let axis = case.axis(r.core.get(), r.profile.get())?;
    let sign = r.dir.get().signum() as i8;
    let book = case.book(axis);
    let answer = super::jog_trap::set_mode(case, axis, mode)?;
    if book.mode == mode {
        if book.follow.direction != sign {
            return Err(case.no(Reason::DirectionDiffers, axis).field(2).got(book.follow.direction.into()));
        }
        return Ok(answer);
    }
    let direction = match sign {
        0 => Direction::Both,
        1 => Direction::Up,
        _ => Direction::Down,
    };
    case.stage_with(Op::FollowDirection { axis, direction }, Change::FollowDirection { axis, direction: sign });
    case.stage(Op::FollowEvent { axis, event: Event::Start });
    Ok(answer)
}

/// The core whose axes a master type counts: the axis's own, or the other one of two.
fn core_of<const AXES: usize>(case: &Case<AXES>, core: i16, given: i16) -> Admitted<i16> {
    let own = matches!(given, kind::ENCODER | kind::PROFILE | kind::AXIS);
    let other = matches!(given, kind::ENCODER_OTHER | kind::AXIS_OTHER) && case.site.profile.cores == 2;
    match (own, other) {
        (true, _) => Ok(core),
        (_, true) => Ok(3 - core),
        _ => Err(Refused::new(Reason::MasterType).field(3).got(given.into())),
    }
}

/// At rest. Only an axis that follows has a master, so a cycle can only arise here.
fn set_master<const AXES: usize>(case: &mut Case<AXES>, mode: Mode, r: &SetFollowMaster) -> Admitted<Answer> {
    let axis = following(case, mode, r.core.get(), r.profile.get())?;
    let given = [r.master_index.get(), r.master_type.get(), r.master_item.get()];
    let core = core_of(case, r.core.get(), given[1])?;
    choice(2, given[0], 1, i16::from(case.site.profile.axes_per_core))?;
    let master = case.axis(core, given[0])?;
    if master == axis {
        return Err(case.no(Reason::OwnMaster, axis).field(2).got(given[0].into()));
    }
    case.at_rest(axis)?;
    let mut next = master;
    // A chain without a cycle is shorter than the number of axes.
    for _ in 0..AXES {
        let book = case.book(next);
        let Some((after, _)) = book.follow.master.filter(|_| book.is_follow()) else { break };
        if after == axis {
            let (number, core) = (f64::from(case.site.number_of(next)), f64::from(case.site.core_of(next)));
            return Err(case.no(Reason::MasterCycle, axis).field(2).got(number).limits(core, core));
        }
        next = after;
    }
    let value = match (given[1], given[2]) {
        (kind::PROFILE, _) | (kind::AXIS | kind::AXIS_OTHER, 0) => Value::Planned,
        (kind::AXIS | kind::AXIS_OTHER, 2) => Value::PlannedFiltered,
        (kind::AXIS | kind::AXIS_OTHER, 3) => Value::EncoderFiltered,
        // An encoder, and every other item of an axis.
        _ => Value::Encoder,
    };
    let op = Op::FollowMaster { axis, master: Master { axis: master, value } };
    case.stage_with(op, Change::FollowMaster { axis, master, given });
    Ok(Answer::Done)
}

/// Below 1 is for ever; counts while the axis runs, too.
fn set_loop<const AXES: usize>(case: &mut Case<AXES>, mode: Mode, r: &SetFollowLoop) -> Admitted<Answer> {
    let axis = following(case, mode, r.core.get(), r.profile.get())?;
    case.stage(Op::FollowLoop { axis, passes: r.loop_count.get().max(0).unsigned_abs() });
    Ok(Answer::Done)
}

/// Counts from the next start on. The direction means something for PASS only.
fn set_event<const AXES: usize>(case: &mut Case<AXES>, mode: Mode, r: &SetFollowEvent) -> Admitted<Answer> {
    let axis = following(case, mode, r.core.get(), r.profile.get())?;
    let (which, way, pos) = (choice(2, r.event.get(), 1, 2)?, choice(3, r.master_dir.get(), -1, 1)?, r.pos.get());
    if which == 2 && way == 0 {
        return Err(Refused::new(Reason::Selector).field(3).got(0.0).limits(-1.0, 1.0));
    }
    let event = if which == 1 { Event::Start } else { Event::Pass { up: way > 0, pos } };
    case.stage_with(Op::FollowEvent { axis, event }, Change::FollowEvent { axis, given: (which, way, pos) });
    Ok(Answer::Done)
}

fn space<const AXES: usize>(case: &mut Case<AXES>, mode: Mode, r: &FollowSpace) -> Admitted<Answer> {
    let axis = following(case, mode, r.core.get(), r.profile.get())?;
    let fifo = choice(2, r.fifo.get(), 0, 1)? as u8;
    known(case, axis, 2)?;
    Ok(Answer::Space(case.book(axis).follow.space(fifo) as i16))
}

/// The FIFO that runs cannot be cleared, the other one can.
fn clear<const AXES: usize>(case: &mut Case<AXES>, mode: Mode, r: &FollowClear) -> Admitted<Answer> {
    let axis = following(case, mode, r.core.get(), r.profile.get())?;
    let fifo = choice(2, r.fifo.get(), 0, 1)? as u8;
    let (book, seen) = (case.book(axis), case.seen(axis));
    known(case, axis, 2)?;
    if case.may_run(axis) {
        let running = book.running_fifo(case.view, seen) == fifo;
        if running || book.is_switching(case.view, seen) {
            let reason = if running { Reason::FifoInUse } else { Reason::SwitchPending };
            return Err(case.no(reason, axis).field(2).got(fifo.into()));
        }
    }
    case.stage_with(Op::FollowClear { axis, fifo }, Change::FollowEmptied { axis, fifo });
    Ok(Answer::Done)
}

/// At rest. Clears the data, even if the size stays.
fn set_memory<const AXES: usize>(case: &mut Case<AXES>, mode: Mode, r: &SetFollowMemory) -> Admitted<Answer> {
    let axis = following(case, mode, r.core.get(), r.profile.get())?;
    let memory = choice(2, r.memory.get(), 0, 1)? as u8;
    case.at_rest(axis)?;
    known(case, axis, 2)?;
    case.stage_with(Op::FollowClear { axis, fifo: 1 }, Change::FollowEmptied { axis, fifo: 1 });
    case.stage_with(Op::FollowClear { axis, fifo: 0 }, Change::FollowMemory { axis, memory });
    Ok(Answer::Done)
}

/// Refuses if a FIFO holds nothing.
fn filled<const AXES: usize>(case: &Case<AXES>, axis: Axis, fifo: u8) -> Admitted<()> {
    if case.book(axis).follow.fifo(fifo).is_empty() {
        return Err(case.no(Reason::FifoEmpty, axis).got(fifo.into()));
    }
    Ok(())
}

/// Starts all axes of the mask on one tick, or none. Option bits take FIFO 1.
fn start<const AXES: usize>(case: &mut Case<AXES>, mode: Mode, r: &FollowStart) -> Admitted<Answer> {
    let axes = case.mask(r.core.get(), r.mask.get(), 1)?;
    if axes.0 == 0 {
        return Ok(Answer::Done);
    }
    let fifo1 = case.mask(r.core.get(), r.option.get() & r.mask.get(), 2)?;
    for axis in case.each(axes) {
        case.in_mode(axis, case.book(axis).mode == mode)?;
        case.at_rest(axis)?;
        known(case, axis, 2)?;
        if case.book(axis).follow.master.is_none() {
            return Err(case.no(Reason::NoMaster, axis));
        }
        filled(case, axis, u8::from(fifo1.has(axis)))?;
    }
    all_startable(case, axes)?;
    case.stage_with(Op::FollowStart { axes, fifo1 }, Change::Started { axes, fifo1, script_ns: 0 });
    Ok(Answer::Done)
}

/// Refuses if the axis does not run, or its other FIFO holds nothing.
fn switchable<const AXES: usize>(case: &Case<AXES>, axis: Axis) -> Admitted<()> {
    if !case.may_run(axis) {
        return Err(case.no(Reason::NotRunning, axis));
    }
    known(case, axis, 1)?;
    filled(case, axis, case.book(axis).running_fifo(case.view, case.seen(axis)) ^ 1)
}

/// The other FIFO takes over at the end of the pass, of all axes of the mask or none.
fn switch<const AXES: usize>(case: &mut Case<AXES>, mode: Mode, r: &FollowSwitch) -> Admitted<Answer> {
    let axes = case.mask(r.core.get(), r.mask.get(), 1)?;
    for axis in case.each(axes) {
        case.in_mode(axis, case.book(axis).mode == mode)?;
        switchable(case, axis)?;
    }
    if axes.0 != 0 {
        case.stage_with(Op::FollowSwitch { axes }, Change::Switched { axes });
    }
    Ok(Answer::Done)
}

/// At once. (Queued, it is data.)
fn switch_now<const AXES: usize>(case: &mut Case<AXES>, r: &FollowSwitchNowEx) -> Admitted<Answer> {
    let axis = following(case, Mode::FollowEx, r.core.get(), r.profile.get())?;
    let method = method(r.method.get())?;
    choice(4, r.fifo.get(), 0, 1)?;
    match method {
        Method::Table => switchable(case, axis)?,
        Method::Segment if !case.may_run(axis) => return Err(case.no(Reason::NotRunning, axis)),
        Method::Segment => {}
    }
    let axes = if method == Method::Table { axis.mask() } else { AxisMask(0) };
    case.stage_with(Op::FollowSwitchNow { axis, method }, Change::Switched { axes });
    // What data is answered; the FIFO is the one that was named.
    Ok(Answer::Entered { axis, fifo: r.fifo.get() as u8, percent1: 0 })
}

/// Segment 1, table 2.
pub fn method(given: i16) -> Admitted<Method> {
    Ok(if choice(2, given, 1, 2)? == 1 { Method::Segment } else { Method::Table })
}

/// Slave displacement of an asymmetric segment (see [`lopsided`]).
fn lopsided_segment<const AXES: usize>(case: &mut Case<AXES>, r: &GetFollowDataPercent2Ex) -> Admitted<Answer> {
    case.core(r.core.get())?;
    let numbers = [r.master_pos, r.vel_begin_ratio, r.vel_end_ratio, r.percent, r.percent1];
    for (field, number) in (1..).zip(numbers) {
        if !number.get().is_finite() {
            return Err(Refused::new(Reason::NotFinite).field(field));
        }
    }
    let [master, begin, end, percent, percent1] = numbers.map(|number| number.get());
    let percent = within(4, percent, 0.0, 100.0)?;
    let percent1 = within(5, percent1, 0.0, percent)?;
    let slave = master * lopsided::mean(begin, end, percent / 100.0, percent1 / 100.0);
    if slave.is_finite() { Ok(Answer::Number(slave)) } else { Err(Refused::new(Reason::NotFinite).field(1)) }
}
