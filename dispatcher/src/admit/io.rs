//! Digital and analog inputs and outputs.
use super::context::Context;
use super::many;
use crate::configuration::ones;
use crate::io_words::{EDGES_READ_MAX, WORD, WORDS};
use crate::refuse::{Admitted, Refused, bits_of, choice, within};
use crate::report::answer::{Answer, Query};
use crate::shadow::ShadowChange;
use protocol::command::{
    GetAdc, GetDac, GetDi, GetDiEx, GetDiReverseCount, SetDac, SetDiReverseCount, SetDo, SetDoBit, SetDoBitReverse,
    SetDoEx, opcode,
};
use protocol::reason::Reason;
use protocol::values::io as kind;
use servo::laser::PowerMode;
use servo::segment::follow::Input;
use servo::tick_command::{DoGroup, TickCommand};
use servo::units::{AxisMask, CYCLE_NS, CrdMask, Ns};

/// Counts that one command sets at most.
const SET_MAX_COUNTS: i16 = 8;

/// GetDi and GetDo: one word.
pub fn levels<const AXES: usize>(context: &Context<AXES>, number: u16, r: &GetDi) -> Admitted<Answer> {
    words(context, number, &GetDiEx { core: r.core, di_type: r.di_type, count: 1.into() })
}

/// GetDiEx and GetDoEx. `first` is the core's index, `count` the words of 32 levels. A read of more
/// words than exist gets those that exist.
pub fn words<const AXES: usize>(context: &Context<AXES>, number: u16, r: &GetDiEx) -> Admitted<Answer> {
    let core = context.core(r.core.get())?;
    let inputs = matches!(number, opcode::GetDi | opcode::GetDiEx);
    let (low, high) = if inputs { (kind::LIMIT_POSITIVE, kind::ARRIVE) } else { (kind::ENABLE, kind::GPO) };
    let which = choice(1, r.di_type.get(), low, high)? as u8;
    let count = choice(2, r.count.get(), 1, i16::MAX)?.min(WORDS as i16) as u8;
    Ok(Answer::Read(Query { opcode: number, first: core as u8, count, which }))
}

/// The first word of outputs. Bits of outputs that do not exist must be 0.
pub fn set_outputs<const AXES: usize>(context: &mut Context<AXES>, r: &SetDo) -> Admitted<Answer> {
    let (group, first, count) = context.output_group(r.core.get(), 1, r.do_type.get())?;
    let all = ones(count.min(WORD));
    let value = bits_of(2, r.value.get().cast_unsigned().into(), all)?;
    set_levels(context, group, all << first, value << first)
}

/// Words of outputs, from the first one; outputs without a word keep their level. Bits of outputs
/// that do not exist must be 0.
pub fn set_output_words<const AXES: usize>(context: &mut Context<AXES>, body: &[u8]) -> Admitted<Answer> {
    let (request, values) = many::<SetDoEx>(body, |r| r.count.get())?;
    let (group, first, have) = context.output_group(request.core.get(), 1, request.do_type.get())?;
    let count = i16::try_from(request.count.get()).unwrap_or(i16::MAX);
    choice(2, count, 1, have.div_ceil(WORD).max(1) as i16)?;
    let mut levels = 0;
    for (item, value) in values.iter().enumerate() {
        let all = ones(have.saturating_sub(WORD * item).min(WORD));
        let value = bits_of(3, value.value.get().cast_unsigned().into(), all);
        levels |= value.map_err(|refused| refused.item(item))? << (WORD * item);
    }
    let all = ones(have.min(WORD * values.len()));
    set_levels(context, group, all << first, levels << first)
}

pub fn set_output<const AXES: usize>(context: &mut Context<AXES>, r: &SetDoBit) -> Admitted<Answer> {
    let (group, bit, high) = context.output_bit(r.core.get(), 1, (r.do_type.get(), r.index.get(), r.value.get()))?;
    let mask = 1u64 << bit;
    set_levels(context, group, mask, if high { mask } else { 0 })
}

/// One output keeps a level for a time of cycles of 250 µs, and then gets the other one. A later
/// command for it takes the place of that.
pub fn set_output_for<const AXES: usize>(context: &mut Context<AXES>, r: &SetDoBitReverse) -> Admitted<Answer> {
    let given = (r.do_type.get(), r.do_index.get(), r.value.get());
    let (group, bit, high) = context.output_bit(r.core.get(), 1, given)?;
    let cycles = within(4, r.reverse_time_cycles.get(), 0, i16::MAX)?;
    let time = Ns(u64::from(cycles.unsigned_abs()) * u64::from(CYCLE_NS));
    let change = stopped_by(group, if high { 0 } else { 1 << bit });
    context.only(TickCommand::OutputFor { group, bit, high, time }, change)
}

/// Counts of edges of consecutive inputs; a read past the last one gets those that exist.
pub fn edges<const AXES: usize>(context: &mut Context<AXES>, r: &GetDiReverseCount) -> Admitted<Answer> {
    let (input, first, have) = context.inputs(r.core.get(), 1, (r.di_type.get(), r.di_index.get()))?;
    let count = choice(3, r.count.get(), 1, i16::MAX)?.unsigned_abs().min(u16::from(have.min(EDGES_READ_MAX))) as u8;
    Ok(Answer::Read(Query { opcode: opcode::GetDiReverseCount, first, count, which: input as u8 }))
}

/// The same set, so that they go on from there.
pub fn set_edges<const AXES: usize>(context: &mut Context<AXES>, body: &[u8]) -> Admitted<Answer> {
    let (request, values) = many::<SetDiReverseCount>(body, |r| r.count.get())?;
    let (input, first, have) =
        context.inputs(request.core.get(), 1, (request.di_type.get(), request.di_index.get()))?;
    let count = i16::try_from(request.count.get()).unwrap_or(i16::MAX);
    choice(3, count, 1, i16::from(have).min(SET_MAX_COUNTS))?;
    for (index, value) in (first..).zip(values) {
        context.stage(TickCommand::EdgeCount { input, index, count: value.value.get() });
    }
    Ok(Answer::Done)
}

/// Levels of outputs.
fn set_levels<const AXES: usize>(
    context: &mut Context<AXES>,
    group: DoGroup,
    mask: u64,
    value: u64,
) -> Admitted<Answer> {
    context.only(TickCommand::Output { group, mask, value }, stopped_by(group, mask & !value))
}

/// Outputs (a bit each) are switched off: a servo stops its axis, and the path that drives it.
fn stopped_by(group: DoGroup, off: u64) -> ShadowChange {
    match group {
        DoGroup::Enable if off != 0 => ShadowChange::Stopped { axes: AxisMask(off), crds: CrdMask(0) },
        _ => ShadowChange::None,
    }
}

/// The first of `count` channels from 1 (fields 1, 2), and how many of them exist: a read may reach
/// past the last one.
fn channels(first: i16, count: i16, have: u8) -> Admitted<(u8, u8)> {
    let have = i16::from(have.min(8));
    let first = choice(1, first, 1, have)?;
    let count = choice(2, count, 1, i16::MAX)?.min(have - first + 1);
    Ok((first as u8 - 1, count as u8))
}

/// An analog output, from 0, that no laser channel uses.
pub fn analog<const AXES: usize>(context: &Context<AXES>, field: u8, channel: i16) -> Admitted<u8> {
    let channel = choice(field, channel, 1, i16::from(context.board.analog_outputs.min(8)))? as u8 - 1;
    free_analog(context, field, channel, 1)?;
    Ok(channel)
}

/// AO0 and AO1 carry the power of a laser channel in analog mode (LSR 2).
fn free_analog<const AXES: usize>(context: &Context<AXES>, field: u8, first: u8, count: usize) -> Admitted<()> {
    for (channel, laser) in (0u8..).zip(&context.shadows.lasers).skip(first.into()).take(count) {
        if laser.mode == PowerMode::Analog {
            let output = f64::from(channel) + 1.0;
            return Err(Refused::new(Reason::AnalogInUse)
                .field(field)
                .got(output)
                .limits(channel.into(), channel.into()));
        }
    }
    Ok(())
}

pub fn set_analog<const AXES: usize>(context: &mut Context<AXES>, body: &[u8]) -> Admitted<Answer> {
    let (request, values) = many::<SetDac>(body, |r| r.count.get())?;
    context.core(request.core.get())?;
    let count = i16::try_from(request.count.get()).unwrap_or(i16::MAX);
    let (first, have) = channels(request.dac.get(), count, context.board.analog_outputs)?;
    choice(2, count, 1, i16::from(have))?;
    free_analog(context, 1, first, values.len())?;
    for (channel, value) in (first..).zip(values) {
        let value = value.value.get();
        context.stage(TickCommand::Analog { channel, value });
    }
    Ok(Answer::Done)
}

pub fn analog_outputs<const AXES: usize>(context: &mut Context<AXES>, r: &GetDac) -> Admitted<Answer> {
    context.core(r.core.get())?;
    let (first, count) = channels(r.dac.get(), r.count.get(), context.board.analog_outputs)?;
    Ok(Answer::Read(Query { opcode: opcode::GetDac, first, count, which: 0 }))
}

pub fn analog_inputs<const AXES: usize>(context: &mut Context<AXES>, r: &GetAdc) -> Admitted<Answer> {
    context.core(r.core.get())?;
    let (first, count) = channels(r.adc.get(), r.count.get(), context.board.analog_inputs)?;
    Ok(Answer::Read(Query { opcode: opcode::GetAdc, first, count, which: 0 }))
}

impl<const AXES: usize> Context<'_, AXES> {
    /// The group, the index of its bit 0, and how many bits a core has of it. `field` names the
    /// type.
    pub fn output_group(&self, core: i16, field: u8, which: i16) -> Admitted<(DoGroup, usize, usize)> {
        let axes = usize::from(self.configuration.profile.axes_per_core);
        let first = self.core(core)? * axes;
        Ok(match choice(field, which, kind::ENABLE, kind::GPO)? {
            kind::ENABLE => (DoGroup::Enable, first, axes),
            kind::CLEAR => (DoGroup::Clear, first, axes),
            _ => (
                DoGroup::General,
                0,
                usize::from(self.configuration.profile.general_outputs.min(self.board.general_outputs)),
            ),
        })
    }

    /// One output: its group, its bit in it, its level. Type, index and value are fields from
    /// `field` on.
    pub fn output_bit(
        &self,
        core: i16,
        field: u8,
        (which, index, value): (i16, i16, i16),
    ) -> Admitted<(DoGroup, u8, bool)> {
        let (group, first, count) = self.output_group(core, field, which)?;
        let index = choice(field + 1, index, 1, count as i16)?.unsigned_abs() as usize - 1;
        Ok((group, (first + index) as u8, choice(field + 2, value, 0, 1)? == 1))
    }

    /// One input that the board has: its kind, its axis over all cores or its number, the wanted
    /// level.
    pub fn input_bit(
        &self,
        core: i16,
        field: u8,
        (which, index, value): (i16, i16, i16),
    ) -> Admitted<(Input, u8, bool)> {
        let (input, bit, _) = self.inputs(core, field, (which, index))?;
        if input != Input::General {
            let axis = self.axis(core, index)?;
            self.has_input(axis, input).map_err(|refused| refused.field(field + 1).got(index.into()))?;
        }
        Ok((input, bit, choice(field + 2, value, 0, 1)? == 1))
    }

    /// Consecutive inputs from one on, also those that the board lacks: their kind, the first one's
    /// axis over all cores or number, and how many there are.
    fn inputs(&self, core: i16, field: u8, (which, index): (i16, i16)) -> Admitted<(Input, u8, u8)> {
        let axes = self.configuration.profile.axes_per_core;
        let first = self.core(core)? as u8 * axes;
        let (input, first, count) = match choice(field, which, kind::LIMIT_POSITIVE, kind::ARRIVE)? {
            kind::LIMIT_POSITIVE => (Input::LimitPositive, first, axes),
            kind::LIMIT_NEGATIVE => (Input::LimitNegative, first, axes),
            kind::ALARM => (Input::Alarm, first, axes),
            kind::HOME => (Input::Home, first, axes),
            kind::GPI => (Input::General, 0, self.general_inputs()),
            _ => (Input::Arrive, first, axes),
        };
        let skipped = choice(field + 1, index, 1, i16::from(count))?.unsigned_abs() as u8 - 1;
        Ok((input, first + skipped, count - skipped))
    }

    /// General inputs that a program can name: those of the profile, as far as the board has them.
    fn general_inputs(&self) -> u8 {
        self.configuration.profile.general_inputs.min(self.board.general_inputs)
    }
}
