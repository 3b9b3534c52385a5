//! One channel: its commands, settings and state; `interval` makes the actions of a tick from them.
//!
//! In: changes at the instant of the tick that is computed, the interval to plan. Out: a
//! [`LaserPlan`](super::actions::LaserPlan), the published view. Owns settings, gate,
//! first-pulse-killer pulse, light and the levels that the outputs carry. Fails: towards the dark.
//!
//! The levels that the outputs should have follow from the state at an instant; the plan is the
//! difference to the levels that they carry. So a missed edge leaves nothing to be done later.
//! Changes act in their order and before the edges of their instant. A gate edge acts before the
//! light's, which it may cancel.
//!
//! A tick in which nothing happens costs one or two comparisons: `changed` marks changes,
//! `next_edge` is the next edge.
mod first_pulse_killer;
mod gate_delays;
mod interval;

pub use first_pulse_killer::Fpk;
pub use gate_delays::Delays;

use super::actions::{Action, Train};
use super::buffered::{Buffered, ChannelEvent, EventQueue};
use super::edge_queue::EdgeQueue;
use super::energy::{Energy, FixedGainWidth};
use super::light_owner::{GateOrder, LightEvent, Owner, PathRun, StandstillCause};
use super::on_time::OnTime;
use super::power::Power;
use super::power_law::{Family, PowerLaw};
use super::safety::{Cause, Safety};
use super::{ChannelChange, LaserView, NEVER, PowerMode};
use crate::units::{Crd, CrdMask, Ns};

/// Mapped crds at power-on: the first two.
const CRD_MAP: u8 = 0b11;

/// What has happened since the last plan.
mod changed {
    /// Outputs or commands moved.
    pub(super) const MOVED: u8 = 1;
    /// The power may have changed: it is computed again, and its train.
    pub(super) const POWER: u8 = 2;
    /// The published settings have changed.
    pub(super) const SETTINGS: u8 = 4;
    /// Settings changed.
    pub(super) const CHANGED: u8 = POWER | SETTINGS;
}

/// The levels that the outputs carry.
#[derive(Debug, Clone, Copy)]
struct Outputs {
    light: bool,
    switch: bool,
    /// The DAC, while the laser drives it.
    volts: Option<i16>,
    /// The PWM, in light and out of it.
    train: Train,
}

impl Outputs {
    const SAFE_STATE: Outputs = Outputs { light: false, switch: false, volts: None, train: Train::NONE };
}

state! {
    /// A channel. The queues of edges come last, so that the other fields are within reach of short
    /// instructions.
    #[derive(Debug)]
    #[repr(C)]
    pub(crate) struct Channel {
        pub(crate) published: LaserView = LaserView { crd_map: CRD_MAP, ..LaserView::BEFORE },
        safety: Safety = Safety::LIVE,
        // Settings.
        law: PowerLaw = PowerLaw::power_on(index, Family::Gus),
        energy: Energy = Energy::POWER_ON,
        delays: Delays = Delays { off: 0, on: 0 },
        delayed: bool = true,
        fpk: Option<Fpk> = None,
        // State.
        owner: Owner = Owner::power_on(CrdMask(CRD_MAP)),
        /// From the gate-off edge of the mark in progress to the end of its light.
        tail: u16 = 0,
        /// End of the FPK pulse in progress, or [`NEVER`].
        pulse: Ns = NEVER,
        /// The outputs carry light of another mode: it is cut.
        cut: bool = false,
        /// A cause within the interval shuts off everything.
        ends: bool = false,
        alarms: CrdMask = CrdMask(0),
        pub(crate) on_time: OnTime = OnTime::ZERO,
        /// Light planned in the interval in force until the next tick, ns.
        planned: u32 = 0,
        // Derived from these.
        out: Outputs = Outputs::SAFE_STATE,
        /// Power and train in light.
        power: Power = Power::ZERO,
        train: Train = Train::NONE,
        /// The rate of the pulses that light has, or had before it paused; 0 before its first one.
        rate: Power = Power::ZERO,
        /// The width of its pulses for each power, if nothing else depends on that.
        plain: FixedGainWidth = FixedGainWidth::NONE,
        changed: u8 = changed::CHANGED,
        /// The next edge.
        next_edge: Ns = NEVER,
        gate: EdgeQueue = EdgeQueue::OFF,
        /// Light: the gate, shifted by the FPK.
        light: EdgeQueue = EdgeQueue::OFF,
        /// Events of paths in the interval that is planned next.
        event_queue: EventQueue = EventQueue::EMPTY,
    }
    /// Channel `index` at power-on.
    pub(super) const fn power_on(index: u8);
}

impl Channel {
    /// Carries out a change; `at` lies in the interval that is planned next. Returns whether it is
    /// an on command that a fault forbids.
    pub(super) fn change(&mut self, at: Ns, change: &ChannelChange) -> bool {
        // Events of paths up to this instant come first.
        self.attend(at);
        // A change that the other channel's mode causes is no command of this one.
        let muted = self.energy.muted;
        self.energy.muted &= matches!(change, ChannelChange::PairedStandby(_));
        self.changed |= match change {
            ChannelChange::Gate { .. } => changed::MOVED,
            ChannelChange::Direct { .. } if self.law.follows().is_none() => changed::POWER,
            _ => changed::CHANGED,
        };
        match change {
            // One that is ignored leaves standby and pre-voltage as they were.
            ChannelChange::Gate { on } => self.energy.muted = !self.report(at, LightEvent::Command { on: *on }) & muted,
            ChannelChange::Mode { mode, bounds, delayed, fixed } => {
                if *mode != self.energy.mode {
                    self.report(at, LightEvent::Withdraw);
                    self.energy.mode = *mode;
                    self.law.leave_mode();
                    self.report(at, LightEvent::FollowEnds);
                    self.report_output(at);
                }
                self.law.set_bounds(*bounds);
                self.delayed = *delayed;
                self.energy.fixed = *fixed;
            }
            ChannelChange::Direct { power, fixed } => {
                let followed = self.law.follows();
                self.law.set_direct(*power);
                self.energy.fixed = *fixed;
                self.report_follow(at, followed);
            }
            ChannelChange::Carrier { carrier, fixed } => {
                (self.energy.carrier, self.energy.fixed) = (Some(*carrier), *fixed)
            }
            ChannelChange::PulseWidth { us } => self.energy.width = Some(*us),
            ChannelChange::Delays(delays) => self.delays = *delays,
            ChannelChange::Fpk(fpk) => {
                self.fpk = *fpk;
                if fpk.is_none() {
                    self.pulse = NEVER;
                }
            }
            ChannelChange::Standby(standby) | ChannelChange::PairedStandby(standby) => self.energy.standby = *standby,
            ChannelChange::PreVoltage(volts) => self.energy.pre_voltage = volts.unwrap_or(Power::ZERO),
            ChannelChange::ZeroOnTime => (self.on_time, self.planned) = (OnTime::ZERO, 0),
            ChannelChange::ClearFault | ChannelChange::ResetFault => {
                self.clear_latch(at);
                // One that is refused ends no darkness of an abort either.
                self.energy.muted = self.safety.is_dark() & muted;
            }
            ChannelChange::CrdMap { map } => self.take_map(at, CrdMask(*map)),
            ChannelChange::Connector { laser } => {
                if !*laser && self.energy.mode != PowerMode::Analog {
                    self.report(at, LightEvent::Withdraw);
                }
                self.energy.connector = *laser;
                self.report_output(at);
            }
            ChannelChange::Distance(distance) => self.law.set_distance(*distance),
            ChannelChange::Reset { family } => self.reset(at, *family),
        }
        match change {
            ChannelChange::Gate { on: true } => self.owner.is_latched(),
            // Its cause is still there.
            ChannelChange::ClearFault => self.safety.is_dark(),
            _ => false,
        }
    }

    /// Passes a fact to the light owner; the gate carries out its order. Returns whether the fact
    /// had an effect: an on command that is ignored has none.
    pub(super) fn report(&mut self, at: Ns, fact: LightEvent) -> bool {
        let published = |owner: &Owner| (owner.is_commanded(), owner.owners());
        let before = published(&self.owner);
        let order = self.owner.handle(fact);
        if order != GateOrder::Keep || published(&self.owner) != before {
            self.changed |= changed::MOVED;
        }
        match order {
            GateOrder::Keep => {}
            GateOrder::On | GateOrder::Off => self.switch(at, order == GateOrder::On),
            GateOrder::Cut => self.end_light(),
            GateOrder::Ignored(why) => {
                let LaserView { ignored, ignored_count, .. } = &mut self.published;
                (*ignored, *ignored_count) = (why, ignored_count.wrapping_add(1));
                self.changed |= changed::CHANGED;
            }
        }
        !matches!(order, GateOrder::Ignored(_))
    }

    /// Whether the energy has an output: its connector, or, in analog mode, the DAC.
    fn report_output(&mut self, at: Ns) {
        let there = self.energy.connector || self.energy.mode == PowerMode::Analog;
        self.report(at, LightEvent::Output { there });
    }

    /// Reports a velocity follow that has changed, or ended.
    fn report_follow(&mut self, at: Ns, before: Option<Crd>) {
        if before.is_some() && self.law.follows().is_none() {
            self.report(at, LightEvent::FollowEnds);
        }
    }

    /// Sets the map. This ends the follow of a coordinate system that it excludes.
    fn take_map(&mut self, at: Ns, map: CrdMask) {
        self.published.crd_map = map.0;
        self.report(at, LightEvent::Map { crds: map });
        if self.law.follows().is_some_and(|crd| !map.has(crd)) {
            self.law.end_follow(CrdMask(u8::MAX));
            self.report(at, LightEvent::FollowEnds);
        }
        self.check_alarms();
    }

    /// A fault whose cause is gone is over.
    fn clear_latch(&mut self, at: Ns) {
        self.safety.clear();
        if !self.safety.is_dark() {
            self.report(at, LightEvent::Cleared);
        }
    }

    /// Whether its energy is a voltage.
    pub(super) fn is_analog(&self) -> bool {
        self.energy.mode == PowerMode::Analog
    }

    /// The paths whose on entries have no effect.
    pub(super) fn dead(&self) -> CrdMask {
        self.owner.dead
    }

    /// Reset clears a fault in any state.
    pub(super) fn reset_latch(&mut self, at: Ns) {
        if !self.safety.is_dark() {
            return;
        }
        self.attend(at);
        self.safety.reset();
        self.ends = false;
        self.clear_latch(at);
        self.changed |= changed::CHANGED;
    }

    /// An abort, or a new session: dark at the call. Standby and pre-voltage are off, too, until
    /// the next command of the channel.
    pub(super) fn abort(&mut self, at: Ns, refuses: bool) {
        self.attend(at);
        self.report(at, LightEvent::Abort { refuses });
        self.safety.force_safe_state();
        (self.energy.muted, self.ends) = (true, false);
        self.changed |= changed::CHANGED;
    }

    /// An event of a path at an instant of the interval that is planned next.
    pub(super) fn queue_event(&mut self, at: Ns, event: ChannelEvent) {
        if self.event_queue.put(at, event).is_err() {
            // Events that are due already free their slots.
            self.attend(at);
            if self.event_queue.put(at, event).is_err() {
                self.trip(Cause::Edges);
            }
        }
        self.next_edge = self.next_edge.min(at);
    }

    /// Whether there is a slot for one more entry of a path, besides those reserved for ends of
    /// paths.
    pub(super) fn has_room(&self) -> bool {
        self.event_queue.has_room()
    }

    /// Carries out the events that are due.
    pub(super) fn attend(&mut self, now: Ns) {
        while let Some(event) = self.event_queue.take(now) {
            self.apply_event(now, event);
        }
    }

    /// A FIFO is cleared, which holds light in few cases.
    pub(super) fn fifo_cleared(&mut self, at: Ns, run: PathRun) {
        self.attend(at);
        if self.owner.is_held_by(run) {
            self.report(at, LightEvent::Clears { run });
        }
    }

    /// Carries out an event.
    fn apply_event(&mut self, at: Ns, event: ChannelEvent) {
        match event {
            ChannelEvent::Change(run, Buffered::Gate { on }) => {
                if self.report(at, LightEvent::Entry { on, run }) {
                    self.unmute(run);
                }
            }
            ChannelEvent::Change(run, change) => {
                if !self.owner.heeds(run.crd) {
                    self.report(at, LightEvent::Entry { on: false, run });
                    return;
                }
                self.unmute(run);
                self.changed |= changed::CHANGED;
                let followed = self.law.follows();
                self.law.change(run.crd, &change);
                if change.begins_follow() {
                    self.report(at, LightEvent::FollowBegins { crd: run.crd });
                }
                self.report_follow(at, followed);
            }
            ChannelEvent::Standstill(run, end, cause) => {
                let is_mapped = self.is_mapped(run.crd);
                self.owner_is_at_standstill(at, run, end);
                if end == StandstillCause::Failed && is_mapped {
                    self.changed |= changed::CHANGED;
                    self.ends |= self.safety.trip_within(cause);
                    self.owner.handle(LightEvent::Latched { link: false });
                }
            }
        }
    }

    /// A path comes to standstill. If it fails, the latch makes the channel dark within the
    /// interval.
    fn owner_is_at_standstill(&mut self, at: Ns, run: PathRun, end: StandstillCause) {
        let fact = LightEvent::Standstill { run, end };
        if end == StandstillCause::Failed {
            self.owner.handle(fact);
        } else {
            self.report(at, fact);
        }
    }

    /// An entry of a path is a command of the channel, too, unless an abort stops its path.
    fn unmute(&mut self, run: PathRun) {
        if self.energy.muted && self.owner.heeds(run.crd) && !self.owner.dead.has(run.crd) {
            self.energy.muted = false;
            self.changed |= changed::CHANGED;
        }
    }

    /// Whether the channel is mapped to a coordinate system.
    pub(super) fn is_mapped(&self, crd: Crd) -> bool {
        CrdMask(self.published.crd_map).has(crd)
    }

    /// The paths whose planned speed it follows, and those whose encoders' speed; also those that
    /// may follow from within the coming interval on.
    #[inline(always)]
    pub(super) fn wants(&self) -> (CrdMask, CrdMask) {
        if !self.event_queue.is_empty() && self.event_queue.follows() {
            return (CrdMask(u8::MAX), CrdMask(u8::MAX));
        }
        (self.law.planned, self.law.encoder)
    }

    /// Whether it follows the encoders of a path now.
    #[inline]
    pub(super) fn follows_encoders(&self, crd: Crd) -> bool {
        self.law.encoder.has(crd)
    }

    /// The axes whose positions count by fixed ratios, if any do.
    #[inline(always)]
    pub(super) fn followed_axes(&self) -> Option<u32> {
        self.law.followed_axes()
    }

    /// Ends a follow that one of these began.
    pub(super) fn end_follow(&mut self, at: Ns, crds: CrdMask) {
        self.attend(at);
        let followed = self.law.follows();
        self.law.end_follow(crds);
        self.changed |= changed::CHANGED;
        self.report_follow(at, followed);
    }

    /// The coordinate systems with an alarm now.
    pub(super) fn alarms(&mut self, crds: CrdMask) {
        self.alarms = crds;
        self.check_alarms();
        self.changed |= changed::CHANGED;
    }

    /// An alarm may also begin for the channel by a change of its map.
    fn check_alarms(&mut self) {
        if self.safety.alarm(self.alarms.0 & self.published.crd_map != 0) {
            self.trip(Cause::Alarm);
        }
    }

    /// Some coordinate systems had a fault that is cleared (ClrSts).
    pub(super) fn clear(&mut self, at: Ns, crds: CrdMask) {
        if crds.0 & self.published.crd_map != 0 {
            self.clear_latch(at);
            self.changed |= changed::CHANGED;
        }
    }

    /// Light and first-pulse-killer pulse end without delays.
    fn end_light(&mut self) {
        self.gate.clear();
        self.light.clear();
        self.pulse = NEVER;
        self.cut = true;
    }

    /// Power-on state. The levels of the outputs and a fault are kept.
    fn reset(&mut self, at: Ns, family: Family) {
        self.report(at, LightEvent::PowerOn);
        self.report(at, LightEvent::FollowEnds);
        (self.law, self.energy) = (PowerLaw::power_on(self.law.channel, family), Energy::POWER_ON);
        (self.delays, self.delayed, self.fpk) = (Delays::default(), true, None);
        (self.on_time, self.planned) = (OnTime::ZERO, 0);
        self.take_map(at, CrdMask(CRD_MAP));
        self.report_output(at);
    }

    /// The levels of the outputs, as actions that bring outputs there from the safe state.
    pub(super) fn carried(&self) -> [Action; 3] {
        let Outputs { switch, train, volts, light } = self.out;
        let energy = if light { Action::Light(train) } else { Action::Dark { standby: train, cut: true } };
        [Action::Switch(switch), energy, Action::Volts(volts.unwrap_or(0))]
    }

    /// A cause has appeared: dark at once.
    pub(super) fn trip(&mut self, cause: Cause) {
        self.safety.trip(cause);
        // The latch makes it dark, with all outputs; nothing else is to be cut.
        self.owner.handle(LightEvent::Latched { link: cause == Cause::LinkLost });
        self.changed |= changed::CHANGED;
    }

    /// The host link is lost, or there again; `runs`: a program runs.
    pub(super) fn link(&mut self, lost: bool, runs: bool) {
        self.safety.link(lost);
        self.changed |= changed::CHANGED;
        if lost && (runs || self.gate.may_be_on() || self.light.may_be_on()) {
            self.trip(Cause::LinkLost);
        }
    }
}
