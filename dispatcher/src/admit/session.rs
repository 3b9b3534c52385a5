//! Session commands: reset, status, tick period, profile, trace, configuration.
use super::axis::limit_levels;
use super::context::{Context, Effect};
use super::{many, plain};
use crate::configuration::{Configuration, ones};
use crate::plan::pvt::CORE_TABLES;
use crate::product::{FAMILIES, PROFILES};
use crate::refuse::{Admitted, Refused, bits_of, choice, within};
use crate::report::answer::Answer;
use crate::report::trace::TraceColumns;
use crate::shadow::{ShadowChange, Watch};
use protocol::command::{
    Abort, Choose, ClrSts, ConfigItem, LoadConfig, Reset, SetInterlock, SetLinkLoss, SetTick, Trace, Wire, opcode,
};
use protocol::reason::Reason;
use protocol::values::given;
use servo::laser::CHANNELS;
use servo::port::{GeneralInputs, GeneralOutputs};
use servo::tick::PERIOD_US;
use servo::tick_command::{Guarded, Guards, TickCommand};
use servo::units::{AxisMask, Crd, CrdMask, Ns};

/// Tick periods of SPEC 11 and issue 2, in µs.
const TICK_US: (i32, i32) = (*PERIOD_US.start() as i32, *PERIOD_US.end() as i32);
/// The longest link-loss time: a day, in ms.
const LINK_LOSS_MAX_MS: i32 = 86_400_000;

/// Acts on all of the controller, whichever core is named: lasers and user exist once.
pub fn abort<const AXES: usize>(context: &mut Context<AXES>, r: &Abort) -> Admitted<Answer> {
    context.core(r.core.get())?;
    context.only(TickCommand::Abort, ShadowChange::Aborted)
}

pub fn reset<const AXES: usize>(context: &mut Context<AXES>, r: &Reset) -> Admitted<Answer> {
    let axes = context.core_mask(r.core.get())?;
    let tables = ones(CORE_TABLES) << (context.core(r.core.get())? * CORE_TABLES);
    context.stage_with(TickCommand::Reset { axes }, ShadowChange::Reset { axes, tables });
    // The lasers exist once: a Reset of either core sets them to power-on state.
    context.lasers_to_power_on(context.configuration.family);
    context.clear_all_laser_faults();
    Ok(Answer::Done)
}

fn stage_watch<const AXES: usize>(context: &mut Context<AXES>, watch: Watch) -> Admitted<Answer> {
    context.only(TickCommand::Supervision(watch.supervision()), ShadowChange::Watch(watch))
}

pub fn clear_status<const AXES: usize>(context: &mut Context<AXES>, r: &ClrSts) -> Admitted<Answer> {
    let axes = context.span_mask(r.core.get(), r.axis.get(), r.count.get())?;
    context.stage_with(TickCommand::ClearStatus { axes }, ShadowChange::Cleared { axes });
    context.clear_laser_faults(axes);
    Ok(Answer::Done)
}

pub fn tick<const AXES: usize>(context: &mut Context<AXES>, r: &SetTick) -> Admitted<Answer> {
    let low = TICK_US.0.max(i32::try_from(*context.board.tick_us.start()).unwrap_or(i32::MAX));
    let high = TICK_US.1.min(i32::try_from(*context.board.tick_us.end()).unwrap_or(i32::MAX));
    let us = within(0, r.tick_us.get(), low, high)?;
    context.all_at_standstill(context.configuration.all(), Reason::OnlyAtStandstill)?;
    let ns = us.unsigned_abs() * 1000;
    let period = Ns(ns.into());
    loses_no_crd(context, period)?;
    context.only(TickCommand::TickPeriod { ns }, ShadowChange::Tick { period })
}

/// Refuses a tick period at which a coordinate system that drives axes would not exist (GXN table
/// 5-1: GSN).
fn loses_no_crd<const AXES: usize>(context: &Context<AXES>, period: Ns) -> Admitted<()> {
    let profile = &context.configuration.profile;
    let most = profile.crds_at(period);
    let lost =
        |crd: &Crd| context.configuration.crd_number(*crd) > most.into() && context.crd_shadow(*crd).frame.is_some();
    match context.configuration.all_crds().crds().find(lost) {
        None => Ok(()),
        Some(crd) => {
            let core = crd.index() / usize::from(profile.crds_per_core.max(1)) + 1;
            let number = context.configuration.crd_number(crd);
            Err(Refused::new(Reason::CrdNeedsTick).axis(number).limits(core as f64, most.into()))
        }
    }
}

/// A choice of the present values changes nothing. Another family sets the lasers to power-on state
/// and may be chosen while axes move. Another profile renumbers the axes, so all of them are reset
/// too.
pub fn choose<const AXES: usize>(context: &mut Context<AXES>, r: &Choose) -> Admitted<Answer> {
    let number = within(0, r.profile, 0, PROFILES.len() as u8 - 1)?;
    let family = within(1, r.family, 0, FAMILIES - 1)?;
    let configuration = Configuration::new(number, family);
    if configuration.profile.axes() > AXES {
        return Err(Refused::new(Reason::ProfileTooLarge)
            .field(0)
            .got(configuration.profile.axes() as f64)
            .limits(0.0, AXES as f64));
    }
    let words = [
        (configuration.profile.general_inputs, GeneralInputs::BITS),
        (configuration.profile.general_outputs, GeneralOutputs::BITS),
    ];
    for (count, room) in words {
        if u32::from(count) > room {
            return Err(Refused::new(Reason::ProfileOutputs).field(0).got(count.into()).limits(0.0, room.into()));
        }
    }
    if number != context.configuration.number {
        let axes = AxisMask(context.configuration.all().0 | configuration.all().0);
        context.all_at_standstill(axes, Reason::OnlyAtStandstill)?;
        context.stage_with(TickCommand::Reset { axes }, ShadowChange::Reset { axes, tables: u64::MAX });
        // The supervision is the user's, and stays.
        stage_watch(context, context.shadows.watch)?;
    }
    if (number, family) != (context.configuration.number, context.configuration.family) {
        context.lasers_to_power_on(family);
    }
    context.effect = Effect::Choose(configuration);
    Ok(plain(opcode::Choose))
}

/// The mask of coordinate systems is over all cores, as that of axes is.
pub fn trace<const AXES: usize>(context: &mut Context<AXES>, r: &Trace) -> Admitted<Answer> {
    let (every, axes) = (r.every.get(), AxisMask(bits_of(1, r.axes.get(), context.configuration.all().0)?));
    let lasers = within(2, r.lasers, 0, (1 << CHANNELS) - 1)?;
    let crds = CrdMask(within(3, r.crds, 0, context.configuration.all_crds().0)?);
    let over_link = within(4, r.over_link, 0, 1)? == 1;
    let edges = within(5, r.edges, 0, 3)?;
    context.stage(TickCommand::Trace { every, axes, crds, lasers, edges: edges & 1 != 0, outputs: edges & 2 != 0 });
    context.effect = Effect::Trace { every, columns: TraceColumns { axes, lasers, crds }, over_link };
    Ok(Answer::Done)
}

pub fn link_loss<const AXES: usize>(context: &mut Context<AXES>, r: &SetLinkLoss) -> Admitted<Answer> {
    let ms = within(0, r.time_ms.get(), 0, LINK_LOSS_MAX_MS)?.unsigned_abs();
    let stop_all = choice(1, r.stop_all.get(), 0, 1)? == 1;
    stage_watch(context, Watch { link_loss_ms: ms, stop_all, ..context.shadows.watch })
}

/// 0: motion goes on without light. 1: it brakes as when the link is lost. 2: everything stops
/// abruptly.
pub fn interlock<const AXES: usize>(context: &mut Context<AXES>, r: &SetInterlock) -> Admitted<Answer> {
    let interlock = choice(0, r.motion.get(), 0, 2)? as u8;
    stage_watch(context, Watch { interlock, ..context.shadows.watch })
}

/// Checks every item; they are pushed afterwards, one by one, by [`config_item`].
pub fn load_config<const AXES: usize>(context: &mut Context<AXES>, body: &[u8]) -> Admitted<Answer> {
    let (request, items) = many::<LoadConfig>(body, |r| r.count.get())?;
    context.core(request.core.get())?;
    for (index, item) in items.iter().enumerate() {
        config_item(context, request.core.get(), item).map_err(|refused| {
            // The fields of an item are counted after those of the request.
            let field = refused.wire.field.saturating_add(LoadConfig::FIELDS.len() as u8);
            refused.item(index).field(field)
        })?;
        context.staged.clear();
    }
    context.effect = Effect::Config;
    Ok(Answer::Done)
}

/// Stages one item of a configuration. The fields that a refusal names are those of the item.
pub fn config_item<const AXES: usize>(context: &mut Context<AXES>, core: i16, item: &ConfigItem) -> Admitted<()> {
    let axis = context.axis(core, item.axis.get()).map_err(|refused| refused.field(0))?;
    let items = within(1, item.given.get(), 0, given::ALL)?;
    let has = |bit: u16| items & bit != 0;
    // One entry for all inputs: the ring of the tick holds those of eight axes, and more.
    let (mut on, mut low) = (Guards::NONE, Guards::NONE);
    if has(given::LIMITS) {
        let bits = within(2, item.limits_on, 0, 3)?;
        context.has_limits(axis, bits & 1 != 0, bits & 2 != 0).map_err(|refused| refused.field(2).got(bits.into()))?;
        on = on.and(Guarded::LimitPositive, bits & 1 != 0).and(Guarded::LimitNegative, bits & 2 != 0);
    }
    if has(given::LIMIT_SENSE) {
        let bits = within(3, item.limit_sense, 0, 3)?;
        context.has_limits(axis, bits & 1 != 0, bits & 2 != 0).map_err(|refused| refused.field(3).got(bits.into()))?;
        low = limit_levels(bits);
    }
    if has(given::ALARM) {
        let used = within(4, item.alarm_on, 0, 1)? != 0;
        context.has_alarm(axis, used).map_err(|refused| refused.field(4).got(1.0))?;
        on = on.and(Guarded::Alarm, used);
    }
    if has(given::ALARM_SENSE) {
        let is_low = within(5, item.alarm_sense, 0, 1)? != 0;
        context.has_alarm(axis, is_low).map_err(|refused| refused.field(5).got(1.0))?;
        low = low.and(Guarded::Alarm, is_low);
    }
    if has(given::SOFT_LIMITS) {
        context.stage_soft(axis, 6, (item.soft_positive.get(), item.soft_negative.get()))?;
    }
    if has(given::STOP_DEC) {
        context.stage_dec(axis, (8, 9), (item.dec_smooth.get(), item.dec_abrupt.get()))?;
    }
    if has(given::POS_ERR) {
        context.stage_pos_err(axis, 10, item.pos_err.get())?;
    }
    if has(given::BAND) {
        context.stage_band(axis, (11, 12), (item.band.get(), item.band_time_cycles.get()))?;
    }
    if has(given::HOME_SENSE) {
        let is_low = within(13, item.home_sense, 0, 1)? != 0;
        context.has_home(axis, is_low).map_err(|refused| refused.field(13).got(1.0))?;
        low = low.and(Guarded::Home, is_low);
    }
    if (on, low) != (Guards::NONE, Guards::NONE) {
        context.stage(TickCommand::Guard { axis, on, low });
    }
    Ok(())
}
