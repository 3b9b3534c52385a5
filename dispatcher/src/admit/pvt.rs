//! PVT commands (GXN chapter 4), apart from the points of tables (see [`super::pvt_table`]).
use super::context::Context;
use crate::plan::pvt::{CORE_TABLES, table_number};
use crate::refuse::{Admitted, Refused, choice, within};
use crate::report::answer::Answer;
use crate::shadow::ShadowChange;
use protocol::command::{PrfPvt, PvtStart, PvtTableSelect, SetPvtLoop};
use protocol::reason::Reason;
use servo::tick_command::{MotionMode, TickCommand};
use servo::units::Axis;

/// Index over all cores of a table, from the user's number in its core.
pub fn table<const AXES: usize>(context: &Context<AXES>, core: i16, field: u8, number: i16) -> Admitted<u8> {
    let core = context.core(core)?;
    let number = choice(field, number, 1, CORE_TABLES as i16)?;
    Ok((core * CORE_TABLES) as u8 + number as u8 - 1)
}

/// The axis keeps the table that was selected for it; at first that is table 1 of its core.
pub fn mode<const AXES: usize>(context: &mut Context<AXES>, r: &PrfPvt) -> Admitted<Answer> {
    let axis = context.axis(r.core.get(), r.profile.get())?;
    let answer = super::jog_trap::set_mode(context, axis, MotionMode::Pvt)?;
    if context.shadow(axis).mode != MotionMode::Pvt {
        let first = table(context, r.core.get(), 0, 1)?;
        let table = context.shadow(axis).table.unwrap_or(first);
        context.stage_with(TickCommand::PvtSelect { axis, table }, ShadowChange::Table { axis, table, pending: false });
    }
    Ok(answer)
}

/// 0 is endless; has effect also while the axis runs.
pub fn set_loop<const AXES: usize>(context: &mut Context<AXES>, r: &SetPvtLoop) -> Admitted<Answer> {
    let axis = context.axis_in(MotionMode::Pvt, r.core.get(), r.profile.get())?;
    let passes = within(2, r.loop_count.get(), 0, i32::MAX)?;
    context
        .only(TickCommand::PvtLoop { axis, passes: passes.unsigned_abs() }, ShadowChange::TablePasses { axis, passes })
}

fn not_empty<const AXES: usize>(context: &Context<AXES>, axis: Axis, table: u8) -> Admitted<()> {
    if context.shadows.is_filled(table) {
        Ok(())
    } else {
        Err(context.no(Reason::TableEmpty, axis).got(table_number(table).into()))
    }
}

/// At standstill it has effect at once, else when the present pass ends. The table must hold points
/// (GXN command 46).
pub fn select<const AXES: usize>(context: &mut Context<AXES>, r: &PvtTableSelect) -> Admitted<Answer> {
    let axis = context.axis_in(MotionMode::Pvt, r.core.get(), r.profile.get())?;
    let table = table(context, r.core.get(), 2, r.table.get())?;
    let pending = context.may_run(axis);
    not_empty(context, axis, table)?;
    context.only(TickCommand::PvtSelect { axis, table }, ShadowChange::Table { axis, table, pending })
}

/// Starts all axes of the mask on one tick, or none.
pub fn start<const AXES: usize>(context: &mut Context<AXES>, r: &PvtStart) -> Admitted<Answer> {
    let axes = context.mask(r.core.get(), r.mask.get(), 1)?;
    for axis in context.each(axes) {
        context.in_mode(axis, context.shadow(axis).mode == MotionMode::Pvt)?;
        context.at_standstill(axis)?;
        not_empty(context, axis, context.shadow(axis).table.unwrap_or(u8::MAX))?;
    }
    context.start(axes, TickCommand::PvtStart { axes }, ShadowChange::PvtStarted { axes })
}

/// Refuses if an axis runs this table, will continue with it, or is named with it by an entry that
/// has not been executed.
pub fn not_in_use<const AXES: usize>(context: &Context<AXES>, table: u8) -> Admitted<()> {
    let refuse = |axis: Option<Axis>| {
        let refused = Refused::new(Reason::TableInUse).field(1).got(table_number(table).into());
        Err(axis.map_or(refused, |axis| refused.axis(context.configuration.number_of(axis))))
    };
    for (index, sampled) in context.view.axes.iter().enumerate() {
        let runs = sampled.table_until.0 == u64::MAX;
        if runs && (sampled.table == table || sampled.pending == Some(table)) {
            return refuse(Axis::new(index));
        }
    }
    if context.shadows.is_named(context.view, table) {
        let by = context
            .shadows
            .axes
            .iter()
            .position(|shadow| shadow.mode == MotionMode::Pvt && shadow.table == Some(table));
        return refuse(by.and_then(Axis::new));
    }
    Ok(())
}
