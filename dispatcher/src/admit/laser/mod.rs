//! Laser commands: gate, delays, first-pulse killer, on-time, crd map, faults, connectors.
//!
//! | file | what it is |
//! | --- | --- |
//! | `energy` | modes and bounds, power, carrier, width, standby, pre-voltage |
//! | `buffered` | changes that entries of paths carry: gate, power, velocity follow |
//! | `distance` | distance follow |
//! | `tables` | tables of powers and of ratios, in chunks |
//! | `power_range` | what is refused or limited: return code 7 of a laser power |
//!
//! In: requests and the shadow state of the channels. Out: staged changes. What is out of range is
//! refused or limited by `power_range`; the reply reports what was taken. A controller has its
//! channels once, whatever its cores are: every core may name every channel.
//!
//! The commands are those of GUS chapter 2 and LSR chapter 2, each in both families; SPEC 2 says
//! where the families differ, SPEC 6 what a channel does.
pub mod buffered;
pub mod distance;
pub mod energy;
mod power_range;
pub mod tables;

use super::context::{Context, Effect};
use crate::refuse::{Admitted, Refused, choice};
use crate::report::answer::{Answer, Query};
use crate::shadow::{LaserChange, LaserShadow, ShadowChange, is_in_flight};
use core::num::NonZeroU16;
use power_range::RangeLimiter;
use protocol::command::{
    ClrLaserFault, DisFPK, EnaFPK, LaserOn, SetAxisMode, SetHSIOOpt, SetLaserCrdMap, SetLevelDelay, ZeroLaserOnTime,
};
use protocol::reason::Reason;
use servo::laser::{CHANNELS, Cause, ChannelChange, Clock, Delays, Family, Fpk, PowerBounds, PowerMode};
use servo::tick_command::TickCommand;
use servo::units::{AxisMask, Crd, CrdMask};

/// The family that limits values out of range and whose connectors are fixed (SPEC 2).
pub const LSR: u8 = 1;
/// Axis connector of channel 0; that of channel 1 is the next.
const FIRST_CONNECTOR: i16 = 7;
/// The longest delay and FPK time, µs.
const TIME_MAX_US: u16 = u16::MAX;

/// What is taken, for the reply: its values and which of them were limited.
fn answer_taken<const AXES: usize>(context: &mut Context<AXES>, values: &[f64], limited: u8) -> Answer {
    let (all, count, limited) = crate::admit::written::taken_values(values, limited);
    context.effect = Effect::Took(all);
    Answer::Took { count, limited }
}

impl<const AXES: usize> Context<'_, AXES> {
    /// Whether the family is LSR.
    fn is_lsr(&self) -> bool {
        self.configuration.family == LSR
    }

    /// A channel; `field` is its index in the request.
    fn channel(&self, core: i16, field: u8, channel: i16) -> Admitted<u8> {
        self.core(core)?;
        Ok(choice(field, channel, 0, i16::from(self.configuration.profile.lasers.min(CHANNELS as u8)) - 1)? as u8)
    }

    fn laser(&self, channel: u8) -> &LaserShadow {
        &self.shadows.lasers[usize::from(channel).min(CHANNELS - 1)]
    }

    /// The clock of the machine's timers, which the first tick publishes.
    fn clock(&self) -> Admitted<Clock> {
        Clock::from_mhz(self.view.timer_mhz).ok_or(Refused::new(Reason::RingFull))
    }

    fn change(&mut self, channel: u8, change: ChannelChange) -> Answer {
        self.stage(TickCommand::Laser { channel, change });
        Answer::Done
    }

    /// A change of the shadow state alone.
    fn enter(&mut self, channel: u8, entered: LaserChange) {
        self.stage_with(TickCommand::Mark, ShadowChange::Laser { channel, change: entered });
    }

    fn change_with(&mut self, channel: u8, change: ChannelChange, entered: LaserChange) -> Answer {
        self.stage_with(TickCommand::Laser { channel, change }, ShadowChange::Laser { channel, change: entered });
        Answer::Done
    }

    /// Both channels as they are at power-on in this family.
    pub fn lasers_to_power_on(&mut self, family: u8) {
        for channel in 0..CHANNELS as u8 {
            for (change, entered) in power_on(family) {
                self.change_with(channel, change, entered);
            }
        }
        self.stage_with(TickCommand::Mark, ShadowChange::LaserResolution(true));
    }

    /// Clearing a status word clears the faults of channels that a crd of one of these axes gates
    /// (SPEC 9). The tick does it, by the crds that drive the axes then.
    pub fn clear_laser_faults(&mut self, axes: AxisMask) {
        let gates = |crd: &Crd| self.crd_shadow(*crd).frame.is_some_and(|frame| frame.mask().0 & axes.0 != 0);
        let crds = Crd::all().filter(gates).fold(0, |crds, crd| crds | crd.mask().0);
        for channel in 0..CHANNELS as u8 {
            if self.laser(channel).map & crds != 0 {
                self.enter(channel, LaserChange::Cleared);
            }
        }
    }

    /// A Reset clears the faults of every channel (SPEC 9) whose cause is gone.
    pub fn clear_all_laser_faults(&mut self) {
        for channel in 0..CHANNELS as u8 {
            self.change_with(channel, ChannelChange::ResetFault, LaserChange::Cleared);
        }
    }

    /// Refuses light that no output would carry.
    fn connected(&self, channel: u8) -> Admitted<()> {
        let shadow = self.laser(channel);
        if shadow.mode == PowerMode::Analog {
            let there = channel < self.board.analog_outputs;
            return if there { Ok(()) } else { Err(Refused::new(Reason::NoLaserOutput).got(channel.into())) };
        }
        if shadow.connector {
            return Ok(());
        }
        let connector = f64::from(FIRST_CONNECTOR) + f64::from(channel);
        Err(Refused::new(Reason::LaserConnector).got(channel.into()).limits(0.0, connector))
    }

    /// The crds of a core in a channel's map.
    fn crds_of(&self, core: usize) -> u8 {
        let crds = u32::from(self.configuration.profile.crds_per_core);
        (((1u32 << crds) - 1) << (core as u32 * crds)) as u8
    }
}

/// A channel at power-on: its own defaults, and those of the family (SPEC 2). LSR has no gate
/// delays until a mode asks for them, and its connectors belong to the laser. Those of GUS carry
/// step pulses. Every crd is mapped.
pub fn power_on(family: u8) -> [(ChannelChange, LaserChange); 4] {
    let lsr = family == LSR;
    let (mode, bounds, delayed) = (PowerMode::Duty, PowerBounds::full(PowerMode::Duty), !lsr);
    [
        (
            ChannelChange::Reset { family: if lsr { Family::Lsr } else { Family::Gus } },
            LaserChange::PowerOn { delayed, connector: lsr },
        ),
        (ChannelChange::Mode { mode, bounds, delayed, fixed: None }, LaserChange::Mode { mode, bounds, delayed }),
        (ChannelChange::Connector { laser: lsr }, LaserChange::Connector(lsr)),
        (ChannelChange::CrdMap { map: u8::MAX }, LaserChange::Map(u8::MAX)),
    ]
}

fn gate<const AXES: usize>(context: &mut Context<AXES>, channel: u8, on: bool) -> Admitted<Answer> {
    if on {
        if context.shadows.aborts(context.view) {
            return Err(Refused::new(Reason::Aborting));
        }
        let (shadow, sampled) = (context.laser(channel), &context.view.lasers[usize::from(channel).min(CHANNELS - 1)]);
        // With a clearing in flight only the tick can know.
        let clearing = is_in_flight(context.view, shadow.cleared);
        let refused = Refused::new(Reason::LaserFault).got(channel.into());
        if sampled.fault != Cause::None && !clearing {
            return Err(refused.limits(0.0, f64::from(sampled.fault as u8)));
        }
        context.connected(channel)?;
    }
    Ok(context.change(channel, ChannelChange::Gate { on }))
}

/// LaserOn and LaserOff.
pub fn set<const AXES: usize>(context: &mut Context<AXES>, r: &LaserOn, on: bool) -> Admitted<Answer> {
    let channel = context.channel(r.core.get(), 1, r.channel.get())?;
    gate(context, channel, on)
}

pub fn switch<const AXES: usize>(context: &mut Context<AXES>, r: &SetHSIOOpt) -> Admitted<Answer> {
    let channel = context.channel(r.core.get(), 2, r.channel.get())?;
    let on = choice(1, r.value.get(), 0, 1)? == 1;
    gate(context, channel, on)
}

pub fn delays<const AXES: usize>(context: &mut Context<AXES>, r: &SetLevelDelay) -> Admitted<Answer> {
    let channel = context.channel(r.core.get(), 3, r.channel.get())?;
    let mut taking = RangeLimiter::new(context.is_lsr());
    let off = taking.whole(1, 0, r.off_delay_us.get(), 0, TIME_MAX_US)?;
    let on = taking.whole(2, 1, r.on_delay_us.get(), 0, TIME_MAX_US)?;
    context.change(channel, ChannelChange::Delays(Delays { off, on }));
    Ok(answer_taken(context, &[off.into(), on.into()], taking.limited))
}

pub fn fpk_on<const AXES: usize>(context: &mut Context<AXES>, r: &EnaFPK) -> Admitted<Answer> {
    let channel = context.channel(r.core.get(), 4, r.channel.get())?;
    let mut taking = RangeLimiter::new(context.is_lsr());
    let pulse = taking.whole(1, 0, r.time1_us.get(), 1, TIME_MAX_US)?;
    let begin = taking.whole(2, 1, r.time2_us.get(), 0, TIME_MAX_US)?;
    let end = taking.whole(3, 2, r.laser_off_delay_us.get(), 0, TIME_MAX_US)?;
    let fpk = NonZeroU16::new(pulse).map(|pulse| Fpk { pulse, begin, end });
    context.change(channel, ChannelChange::Fpk(fpk));
    Ok(answer_taken(context, &[pulse.into(), begin.into(), end.into()], taking.limited))
}

pub fn fpk_off<const AXES: usize>(context: &mut Context<AXES>, r: &DisFPK) -> Admitted<Answer> {
    let channel = context.channel(r.core.get(), 1, r.channel.get())?;
    Ok(context.change(channel, ChannelChange::Fpk(None)))
}

pub fn zero_on_time<const AXES: usize>(context: &mut Context<AXES>, r: &ZeroLaserOnTime) -> Admitted<Answer> {
    let channel = context.channel(r.core.get(), 1, r.channel.get())?;
    Ok(context.change(channel, ChannelChange::ZeroOnTime))
}

/// Each core maps its own crds.
pub fn map<const AXES: usize>(context: &mut Context<AXES>, r: &SetLaserCrdMap) -> Admitted<Answer> {
    let channel = context.channel(r.core.get(), 1, r.channel.get())?;
    let core = context.core(r.core.get())?;
    let crds = context.crds_per_core();
    let given = choice(2, r.map.get(), 0, (1 << crds) - 1)? as u8;
    let (before, own) = (context.laser(channel).map, context.crds_of(core));
    let map = before & !own | given << (core as u8 * context.configuration.profile.crds_per_core);
    let sampled = &context.view.lasers[usize::from(channel).min(CHANNELS - 1)];
    for crd in CrdMask((before | map) & own).crds() {
        let may_be_stopped = || context.crd_shadow(crd).may_be_stopped(context.view, context.crd_sampled(crd));
        let ahead = !context.due.decided && may_be_stopped();
        if ahead || context.crd_may_run(crd) || sampled.owners.has(crd) {
            return Err(context.no_crd(Reason::LaserMapInUse, crd).got(channel.into()));
        }
    }
    Ok(context.change_with(channel, ChannelChange::CrdMap { map }, LaserChange::Map(map)))
}

/// Connectors 7 and 8, of core 1, carry step pulses of their axes at power-on; 8 cannot be given
/// back to them. Giving back a connector also takes the light away, so that it does not return with
/// the connector.
pub fn connector<const AXES: usize>(context: &mut Context<AXES>, r: &SetAxisMode) -> Admitted<Answer> {
    if context.is_lsr() {
        return Err(Refused::new(Reason::NotInFamily));
    }
    let core = choice(0, r.core.get(), 1, 1)?;
    let axis = choice(1, r.axis.get(), FIRST_CONNECTOR, FIRST_CONNECTOR + CHANNELS as i16 - 1)?;
    let lowest = i16::from(axis != FIRST_CONNECTOR);
    let laser = choice(2, r.mode.get(), lowest, 1)? == 1;
    context.at_standstill(context.axis(core, axis)?)?;
    let channel = (axis - FIRST_CONNECTOR) as u8;
    Ok(context.change_with(channel, ChannelChange::Connector { laser }, LaserChange::Connector(laser)))
}

pub fn clear_fault<const AXES: usize>(context: &mut Context<AXES>, r: &ClrLaserFault) -> Admitted<Answer> {
    let channel = context.channel(r.core.get(), 1, r.channel.get())?;
    let sampled = &context.view.lasers[usize::from(channel).min(CHANNELS - 1)];
    if sampled.cause_lasts {
        let refused = Refused::new(Reason::LaserCause).got(channel.into());
        return Err(refused.limits(0.0, f64::from(sampled.fault as u8)));
    }
    Ok(context.change_with(channel, ChannelChange::ClearFault, LaserChange::Cleared))
}

impl<const AXES: usize> Context<'_, AXES> {
    /// A read of a channel; GetLaserCrdMap reports the crds of its core.
    pub fn read_laser(&self, opcode: u16, r: &protocol::command::GetLaserPower) -> Admitted<Answer> {
        let first = self.channel(r.core.get(), 1, r.channel.get())?;
        let which = self.core(r.core.get())? as u8;
        Ok(Answer::Read(Query { opcode, first, count: 1, which }))
    }
}
