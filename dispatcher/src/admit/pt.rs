//! PT commands (GXN chapter 2), and the road of PT data from bytes to the axis's store.
use super::axis::all_startable;
use super::data::{End, Of, Written};
use super::{many, one, query};
use crate::books::{Change, FifoBook};
use crate::case::{Answer, Case, Query};
use crate::refuse::{Admitted, Refused, choice};
use protocol::command::{
    GetPtLoop, GetPtMemory, PrfPt, PtClear, PtData, PtDataMany, PtItem, PtSpace, PtStart, SetPtLoop, SetPtMemory, Wire,
    opcode,
};
use protocol::reason::{Reason, Refusal};
use servo::op::{Mode, Op};
use servo::pt::{self, Segment, SegmentStore};
use servo::units::{Axis, AxisMask, StepLimit};

/// First slot of static FIFO 1; the dynamic ring uses all slots.
const FIFO_SLOTS: u32 = 1024;
/// ±2⁴⁰ pulses.
const TRAVEL: f64 = 1_099_511_627_776.0;

/// Static 0, dynamic 1. Another FIFO use clears the data, the same one keeps it.
pub fn mode<const AXES: usize>(case: &mut Case<AXES>, r: &PrfPt) -> Admitted<Answer> {
    let axis = case.axis(r.core.get(), r.profile.get())?;
    let mode = if choice(2, r.mode.get(), 0, 1)? == 0 { Mode::PtStatic } else { Mode::PtDynamic };
    super::jog_trap::set_mode(case, axis, mode)
}

/// The axis, if it is in a PT mode.
fn pt_axis<const AXES: usize>(case: &Case<AXES>, core: i16, profile: i16) -> Admitted<Axis> {
    let axis = case.axis(core, profile)?;
    case.in_mode(axis, case.book(axis).is_pt())?;
    Ok(axis)
}

/// The FIFO, which dynamic mode ignores.
fn fifo<const AXES: usize>(case: &Case<AXES>, axis: Axis, field: u8, fifo: i16) -> Admitted<u8> {
    if case.book(axis).is_dynamic() { Ok(0) } else { Ok(choice(field, fifo, 0, 1)? as u8) }
}

/// At rest the books alone say it; while the axis runs the tick does.
pub fn space<const AXES: usize>(case: &mut Case<AXES>, r: &PtSpace) -> Admitted<Answer> {
    let axis = pt_axis(case, r.core.get(), r.profile.get())?;
    let which = fifo(case, axis, 2, r.fifo.get())?;
    let (book, seen) = (case.book(axis), case.seen(axis));
    if book.may_run(case.view, seen) && book.is_dynamic() {
        return Ok(Answer::Read(Query { opcode: opcode::PtSpace, first: axis.index() as u8, count: 1, which }));
    }
    Ok(Answer::Space(book.space(case.view, seen, usize::from(which)) as i16))
}

/// In static mode the FIFO that runs cannot be cleared, the other one can.
pub fn clear<const AXES: usize>(case: &mut Case<AXES>, r: &PtClear) -> Admitted<Answer> {
    let axis = pt_axis(case, r.core.get(), r.profile.get())?;
    let fifo = fifo(case, axis, 2, r.fifo.get())?;
    if case.may_run(axis) && (case.book(axis).is_dynamic() || case.book(axis).fifo == fifo) {
        return Err(case.no(Reason::FifoInUse, axis).field(2).got(fifo.into()));
    }
    case.stage_with(Op::PtClear { axis, fifo }, Change::Emptied { axis, fifo });
    Ok(Answer::Done)
}

fn not_dynamic<const AXES: usize>(case: &Case<AXES>, axis: Axis) -> Admitted<()> {
    if case.book(axis).is_dynamic() { Err(case.no(Reason::NotInDynamic, axis)) } else { Ok(()) }
}

/// 0 and below is for ever.
pub fn set_loop<const AXES: usize>(case: &mut Case<AXES>, r: &SetPtLoop) -> Admitted<Answer> {
    let axis = pt_axis(case, r.core.get(), r.profile.get())?;
    not_dynamic(case, axis)?;
    case.stage(Op::PtLoop { axis, passes: r.loop_count.get().max(0).unsigned_abs() });
    Ok(Answer::Done)
}

pub fn passes<const AXES: usize>(case: &mut Case<AXES>, r: &GetPtLoop) -> Admitted<Answer> {
    let axis = pt_axis(case, r.core.get(), r.profile.get())?;
    not_dynamic(case, axis)?;
    Ok(query(opcode::GetPtLoop, axis))
}

/// Clears the data, even if the size stays.
pub fn set_memory<const AXES: usize>(case: &mut Case<AXES>, r: &SetPtMemory) -> Admitted<Answer> {
    let axis = pt_axis(case, r.core.get(), r.profile.get())?;
    let memory = choice(2, r.memory.get(), 0, 1)? as u8;
    case.at_rest(axis)?;
    // In dynamic mode one clears both, and the tick has only so many operations of one instant.
    if !case.book(axis).is_dynamic() {
        case.stage_with(Op::PtClear { axis, fifo: 1 }, Change::Emptied { axis, fifo: 1 });
    }
    case.stage_with(Op::PtClear { axis, fifo: 0 }, Change::Memory { axis, memory });
    Ok(Answer::Done)
}

pub fn memory<const AXES: usize>(case: &mut Case<AXES>, r: &GetPtMemory) -> Admitted<Answer> {
    let axis = pt_axis(case, r.core.get(), r.profile.get())?;
    Ok(query(opcode::GetPtMemory, axis))
}

/// Starts all axes of the mask on one tick, or none. Option bits take FIFO 1 and mean nothing in
/// dynamic mode or for axes that are not named.
pub fn start<const AXES: usize>(case: &mut Case<AXES>, r: &PtStart) -> Admitted<Answer> {
    let axes = case.mask(r.core.get(), r.mask.get(), 1)?;
    if axes.0 == 0 {
        return Ok(Answer::Done);
    }
    let option = case.mask(r.core.get(), r.option.get() & r.mask.get(), 2)?;
    let mut fifo1 = AxisMask(0);
    for axis in case.each(axes) {
        let book = case.book(axis);
        case.in_mode(axis, book.is_pt())?;
        case.at_rest(axis)?;
        let which = usize::from(option.has(axis) && !book.is_dynamic());
        fifo1.0 |= axis.mask().0 * which as u64;
        if book.space(case.view, case.seen(axis), which) == book.capacity() {
            return Err(case.no(Reason::FifoEmpty, axis).field(2).got(which as f64));
        }
    }
    all_startable(case, axes)?;
    case.stage_with(Op::PtStart { axes, fifo1 }, Change::Started { axes, fifo1 });
    Ok(Answer::Done)
}

/// Admits PtData or PtDataMany: all its segments or none. They are written behind the committed end,
/// where the tick does not look, so a refusal half-way has changed nothing.
pub fn data<const AXES: usize>(
    case: &Case<AXES>,
    stores: &[SegmentStore; AXES],
    number: u16,
    body: &[u8],
) -> Admitted<(Written, End)> {
    if number == opcode::PtData {
        let r = one::<PtData>(body)?;
        let kind = choice(4, r.kind.get(), 0, 2)?;
        let item = PtItem { pos: r.pos, time_ms: r.time_ms, kind: kind as u8 };
        return push(case, stores, (r.core.get(), r.profile.get(), r.fifo.get(), 5), &[item]).map_err(|mut refused| {
            // The fields of a single datum are those of the request.
            if refused.wire.item.get() == 0 {
                refused.wire.item = 65535.into();
                refused.wire.field = refused.wire.field.saturating_add(2);
            }
            refused
        });
    }
    let (r, items) = many::<PtDataMany>(body, |r| r.count.get())?;
    let mut written = push(case, stores, (r.core.get(), r.profile.get(), r.fifo.get(), 2), items);
    // The fields of an item are counted behind those of the request.
    if let Err(refused) = &mut written
        && refused.wire.item.get() != Refusal::NO_ITEM
    {
        refused.wire.field = refused.wire.field.saturating_add(PtDataMany::FIELDS.len() as u8);
    }
    written
}

fn push<const AXES: usize>(
    case: &Case<AXES>,
    stores: &[SegmentStore; AXES],
    (core, profile, fifo_given, fifo_field): (i16, i16, i16, u8),
    items: &[PtItem],
) -> Admitted<(Written, End)> {
    let axis = pt_axis(case, core, profile)?;
    let fifo = fifo(case, axis, fifo_field, fifo_given)?;
    let (book, seen) = (case.book(axis), case.seen(axis));
    let which = usize::from(fifo);
    let space = book.space(case.view, seen, which) as usize;
    if items.len() > space {
        return Err(case
            .no(Reason::FifoFull, axis)
            .field(fifo_field)
            .got(space as f64)
            .limits(0.0, book.capacity().into()));
    }
    // The places of data that is over in the program are free only when the tick is through with them.
    if book.is_outgoing(case.view, seen) {
        return Err(case.no(Reason::FifoInUse, axis).field(fifo_field).got(fifo.into()));
    }
    let Some(store) = stores.get(axis.index()) else { return Err(case.no(Reason::NotInitialised, axis)) };
    let data = book.fifos[which & 1];
    let (mut chain, limit) = (data.chain, case.board.step_limit);
    let mut slot = (u32::from(fifo) * FIFO_SLOTS).wrapping_add(data.end);
    for (index, item) in items.iter().enumerate() {
        let bits = u64::from_le_bytes(item.pos.to_bytes());
        match Segment::admit(bits, item.time_ms.get(), i16::from(item.kind), &chain, limit) {
            Ok((segment, next)) => {
                store.write(slot, segment);
                slot = slot.wrapping_add(1);
                chain = next;
            }
            Err(refused) => return Err(explain(refused, item, limit).item(index).axis(profile)),
        }
    }
    let book = FifoBook { end: data.end.wrapping_add(items.len() as u32), chain };
    let answer = Answer::Taken { axis, fifo, count: items.len() as u16 };
    Ok((Written::new(Of::Axis(axis), fifo, answer), End::Pt(book)))
}

/// The fields that a refusal names are those of a PtItem: 0 position, 1 time, 2 kind.
#[cold]
fn explain(refused: pt::Refused, item: &PtItem, limit: StepLimit) -> Refused {
    let (pos, time_ms) = (item.pos.get(), item.time_ms.get());
    match refused {
        pt::Refused::NotFinite => Refused::new(Reason::NotFinite).field(0).got(pos),
        pt::Refused::BeyondTravel => Refused::new(Reason::BeyondTravel).field(0).got(pos).limits(-TRAVEL, TRAVEL),
        pt::Refused::NotIncreasing { before } => {
            Refused::new(Reason::NotIncreasing).field(1).got(time_ms.into()).limits(before.into(), i32::MAX.into())
        }
        pt::Refused::TooFast { speed } => {
            let most = limit.pulses_per_ms() as f64;
            Refused::new(Reason::TooFast).field(0).got(speed as f64 / 1_048_576.0).limits(-most, most)
        }
        pt::Refused::Kind => Refused::new(Reason::Selector).field(2).got(item.kind.into()).limits(0.0, 2.0),
    }
}
