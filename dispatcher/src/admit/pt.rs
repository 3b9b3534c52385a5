//! PT commands (GXN chapter 2), and PT data from bytes to the axis's store.
use super::context::{Context, TRAVEL_PULSES};
use super::written::{SegmentStores, Stored, Written};
use super::{many, one};
use crate::refuse::{Admitted, FifoOf, Refused, choice};
use crate::report::answer::{Answer, Query};
use crate::shadow::{AxisShadow, BEGINS_SHIFT, FifoShadow, ShadowChange, executed};
use protocol::command::{
    PrfPt, PtClear, PtData, PtDataMany, PtItem, PtSpace, PtStart, SetPtLoop, SetPtMemory, Wire, opcode,
};
use protocol::reason::Reason;
use protocol::values::pt_state;
use servo::segment::pt::{self, SEGMENTS, Segment};
use servo::tick_command::{MotionMode, TickCommand};
use servo::units::{Axis, AxisMask, StepLimit};

/// First slot of static FIFO 1; the dynamic ring uses all slots.
const FIFO_SLOTS: u32 = SEGMENTS as u32 / 2;
/// Ticks after which the tick has checked again how long its data lasts, plus one.
const LASTS_CHECK_TICKS: u64 = 9;

/// Static 0, dynamic 1. Another FIFO use clears the data, the same one keeps it.
pub fn mode<const AXES: usize>(context: &mut Context<AXES>, r: &PrfPt) -> Admitted<Answer> {
    let axis = context.axis(r.core.get(), r.profile.get())?;
    let mode = if choice(2, r.mode.get(), 0, 1)? == 0 { MotionMode::PtStatic } else { MotionMode::PtDynamic };
    super::jog_trap::set_mode(context, axis, mode)
}

/// Without a running stream the shadow state decides; else the tick does.
pub fn space<const AXES: usize>(context: &mut Context<AXES>, r: &PtSpace) -> Admitted<Answer> {
    let axis = context.pt_axis(r.core.get(), r.profile.get())?;
    let which = context.pt_fifo(axis, 2, r.fifo.get())?;
    let (shadow, sampled) = (context.shadow(axis), context.sampled(axis));
    if !context.knows_stream(axis) {
        return Err(context.no(Reason::FifoInUse, axis).field(2).got(which.into()));
    }
    if context.is_streaming(axis) && !shadow.is_outgoing(context.view, sampled) {
        return Ok(Answer::Read(Query { opcode: opcode::PtSpace, first: axis.index() as u8, count: 1, which }));
    }
    Ok(Answer::Space(shadow.space(context.view, sampled, usize::from(which)) as i16))
}

/// In static mode the FIFO that runs cannot be cleared, the other one can.
pub fn clear<const AXES: usize>(context: &mut Context<AXES>, r: &PtClear) -> Admitted<Answer> {
    let axis = context.pt_axis(r.core.get(), r.profile.get())?;
    let fifo = context.pt_fifo(axis, 2, r.fifo.get())?;
    if context.may_run(axis) && (context.shadow(axis).is_dynamic() || context.shadow(axis).fifo == fifo) {
        return Err(context.no(Reason::FifoInUse, axis).field(2).got(fifo.into()));
    }
    context.only(TickCommand::PtClear { axis, fifo }, ShadowChange::Emptied { axis, fifo })
}

/// 0 and below is endless.
pub fn set_loop<const AXES: usize>(context: &mut Context<AXES>, r: &SetPtLoop) -> Admitted<Answer> {
    let axis = context.pt_axis(r.core.get(), r.profile.get())?;
    context.not_dynamic(axis)?;
    context.only(TickCommand::PtLoop { axis, passes: r.loop_count.get().max(0).unsigned_abs() }, ShadowChange::None)
}

/// Clears the data, even if the size stays.
pub fn set_memory<const AXES: usize>(context: &mut Context<AXES>, r: &SetPtMemory) -> Admitted<Answer> {
    let axis = context.pt_axis(r.core.get(), r.profile.get())?;
    let memory = choice(2, r.memory.get(), 0, 1)? as u8;
    context.at_standstill(axis)?;
    // In dynamic mode one tick command clears both, and the tick takes only so many tick commands
    // of one instant.
    if !context.shadow(axis).is_dynamic() {
        context.stage_with(TickCommand::PtClear { axis, fifo: 1 }, ShadowChange::Emptied { axis, fifo: 1 });
    }
    context.only(TickCommand::PtClear { axis, fifo: 0 }, ShadowChange::Memory { axis, memory })
}

/// Starts all axes of the mask on one tick, or none. Option bits select FIFO 1; they are ignored in
/// dynamic mode and for axes that are not named.
pub fn start<const AXES: usize>(context: &mut Context<AXES>, r: &PtStart) -> Admitted<Answer> {
    let axes = context.mask(r.core.get(), r.mask.get(), 1)?;
    let option = context.mask(r.core.get(), r.option.get() & r.mask.get(), 2)?;
    let mut fifo1 = AxisMask(0);
    for axis in context.each(axes) {
        let shadow = context.shadow(axis);
        context.in_mode(axis, shadow.is_pt())?;
        context.at_standstill(axis)?;
        let which = usize::from(option.has(axis) && !shadow.is_dynamic());
        fifo1.0 |= axis.mask().0 * which as u64;
        if shadow.space(context.view, context.sampled(axis), which) == shadow.capacity() {
            return Err(context.no(Reason::FifoEmpty, axis).field(2).got(which as f64));
        }
    }
    let script_ns = context.due.script_ns;
    context.start(axes, TickCommand::PtStart { axes, fifo1 }, ShadowChange::Started { axes, fifo1, script_ns })
}

/// The fields that a refusal names are those of a PtItem: 0 position, 1 time, 2 kind.
#[cold]
fn explain(refused: pt::Refused, item: &PtItem, limit: StepLimit) -> Refused {
    let (pos, time_ms) = (item.pos.get(), item.time_ms.get());
    let most = limit.pulses_per_ms() as f64;
    let (reason, field, got, (low, high)) = match refused {
        pt::Refused::NotFinite => (Reason::NotFinite, 0, pos, (0.0, 0.0)),
        pt::Refused::BeyondTravel => (Reason::BeyondTravel, 0, pos, (-TRAVEL_PULSES, TRAVEL_PULSES)),
        pt::Refused::NotIncreasing { before } => {
            (Reason::NotIncreasing, 1, time_ms.into(), (before.into(), i32::MAX.into()))
        }
        pt::Refused::TooFast { speed } => (Reason::TooFast, 0, speed as f64 / 1_048_576.0, (-most, most)),
        pt::Refused::Kind => (Reason::Selector, 2, item.kind.into(), (0.0, 2.0)),
    };
    Refused::new(reason).field(field).got(got).limits(low, high)
}

impl<const AXES: usize> Context<'_, AXES> {
    /// Admits PtData or PtDataMany: all its segments or none. They are written after the committed
    /// end, where the tick does not read, so a refusal half-way has changed nothing.
    pub fn pt_data(&self, stores: &SegmentStores<AXES>, number: u16, body: &[u8]) -> Stored {
        if number == opcode::PtData {
            let r = one::<PtData>(body)?;
            let kind = choice(4, r.kind.get(), 0, 2)?;
            let item = PtItem { pos: r.pos, time_ms: r.time_ms, kind: kind as u8 };
            // The fields of a single datum are those of the request.
            let named = |refused: Refused, _| refused.field(refused.wire.field + 2);
            return self.push_segments(stores, (r.core.get(), r.profile.get(), r.fifo.get(), 5), &[item], &named);
        }
        let (r, items) = many::<PtDataMany>(body, |r| r.count.get())?;
        // The fields of an item are counted after those of the request.
        let named =
            |refused: Refused, index| refused.item(index).field(refused.wire.field + PtDataMany::FIELDS.len() as u8);
        self.push_segments(stores, (r.core.get(), r.profile.get(), r.fifo.get(), 2), items, &named)
    }

    /// Whether a dynamic stream runs, or will run.
    fn is_streaming(&self, axis: Axis) -> bool {
        let (shadow, runs) = (self.shadow(axis), self.sampled(axis).pt_state == pt_state::RUNNING);
        shadow.is_dynamic() && shadow.started.is_some_and(|start| runs || !executed(self.view, start))
    }

    /// Whether it is certain to which stream data of this instant belongs. That is the running one,
    /// or, if it has ended by then, the next one, whose times and positions begin at 0.
    fn knows_stream(&self, axis: Axis) -> bool {
        let (view, due, shadow, sampled) = (self.view, self.due, self.shadow(axis), self.sampled(axis));
        let Some(start) = shadow.started.filter(|_| shadow.is_dynamic()) else { return true };
        let length_ms = |shadow: &AxisShadow| shadow.fifos[0].chain.time_ms().unsigned_abs();
        let before = |ns: u64, ms: u32| ns < u64::from(ms) * 1_000_000;
        if !executed(view, start) {
            // A WaitStop in between takes an unknown time.
            let after_wait = due.wait.is_none_or(|wait| (start.wrapping_sub(wait) << 1).cast_signed() > 0);
            let since = due.script_ns.saturating_sub(u64::from(shadow.stream_begins.saturating_sub(1)) << BEGINS_SHIFT);
            return after_wait && shadow.stream_begins != u32::MAX && before(since, length_ms(shadow));
        }
        // At its instant the view decides; a stream that has ended does not begin again by itself.
        if self.is_due(axis) || !self.is_streaming(axis) {
            return true;
        }
        // What the tick checked at most eight ticks ago, and what was committed since.
        let more = length_ms(shadow).saturating_sub(length_ms(self.executed.axis(axis)));
        let stale = view.period.0.saturating_mul(LASTS_CHECK_TICKS);
        sampled.dry_ms != 0 && before(due.until_ns.saturating_add(stale), sampled.dry_ms.saturating_add(more))
    }

    fn push_segments(
        &self,
        stores: &SegmentStores<AXES>,
        (core, profile, fifo_given, fifo_field): (i16, i16, i16, u8),
        items: &[PtItem],
        named: &dyn Fn(Refused, usize) -> Refused,
    ) -> Stored {
        let axis = self.pt_axis(core, profile)?;
        let fifo = self.pt_fifo(axis, fifo_field, fifo_given)?;
        let (shadow, sampled) = (self.shadow(axis), self.sampled(axis));
        let which = usize::from(fifo);
        let space = shadow.space(self.view, sampled, which) as usize;
        let stands = self.knows_fifos(axis);
        if items.len() > space {
            return Err(self
                .no(Reason::FifoFull, axis)
                .full(FifoOf::Axis(axis), fifo)
                .stands(stands)
                .field(fifo_field)
                .got(space as f64)
                .limits(0.0, shadow.capacity().into()));
        }
        // The slots of data that is over in the program are free only when the tick has released
        // them.
        if self.is_outgoing(axis, fifo) || !self.knows_stream(axis) {
            return Err(self.no(Reason::FifoInUse, axis).field(fifo_field).got(fifo.into()));
        }
        let Some(store) = stores.get(axis.index()) else { return Err(self.no(Reason::NotInitialised, axis)) };
        let data = shadow.fifos[which & 1];
        let (mut chain, limit) = (data.chain, self.board.step_limit);
        let mut slot = (u32::from(fifo) * FIFO_SLOTS).wrapping_add(data.end);
        for (index, item) in items.iter().enumerate() {
            let bits = u64::from_le_bytes(item.pos.to_bytes());
            match Segment::admit(bits, item.time_ms.get(), i16::from(item.kind), &chain, limit) {
                Ok((segment, next)) => {
                    store.write(slot, segment);
                    slot = slot.wrapping_add(1);
                    chain = next;
                }
                Err(refused) => return Err(named(explain(refused, item, limit), index).axis(profile).stands(stands)),
            }
        }
        let data = FifoShadow { end: data.end.wrapping_add(items.len() as u32), chain };
        let answer = Answer::Taken { axis, fifo, count: items.len() as u16 };
        let change = ShadowChange::Data { axis, fifo, epoch: shadow.epoch, data };
        Ok((Written::new(FifoOf::Axis(axis), fifo, answer), change))
    }

    /// The axis, if it is in a PT mode.
    pub fn pt_axis(&self, core: i16, profile: i16) -> Admitted<Axis> {
        let axis = self.axis(core, profile)?;
        self.in_mode(axis, self.shadow(axis).is_pt())?;
        Ok(axis)
    }

    /// The FIFO, which dynamic mode ignores.
    fn pt_fifo(&self, axis: Axis, field: u8, fifo: i16) -> Admitted<u8> {
        if self.shadow(axis).is_dynamic() { Ok(0) } else { Ok(choice(field, fifo, 0, 1)? as u8) }
    }

    pub fn not_dynamic(&self, axis: Axis) -> Admitted<()> {
        if self.shadow(axis).is_dynamic() { Err(self.no(Reason::NotInDynamic, axis)) } else { Ok(()) }
    }
}
