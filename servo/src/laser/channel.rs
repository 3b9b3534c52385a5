//! One channel: from commands to the actions of a tick; those are made in `interval`.
//!
//! In: changes at the instant of the tick that is computed, the interval to plan. Out: a [`Plan`], what is
//! shown. Owns settings, gate, FPK pulse, light and what the outputs carry. Fails: towards the dark.
//!
//! What the outputs should carry follows from the state as it stands at an instant; the plan is the difference
//! to what they carry. So nothing is owed to an edge that was missed. Changes act in their order and before
//! the edges of their instant; a gate edge acts before the light's, which it may cancel.
//!
//! A tick in which nothing happens costs a comparison or two: `news` tells of changes, `wake` of edges.
mod interval;

use super::buffered::{Agenda, Buffered, Event};
use super::energy::{Energy, Plain};
use super::gate::{Edges, Full};
use super::law::{Family, Law};
use super::light::OnTime;
use super::plan::{Action, Train};
use super::power::Power;
use super::safety::{Cause, Safety};
use super::whose::{Run, Whose};
use super::{Change, Delays, Fpk, Mode, NEVER};
use crate::units::{Crd, CrdMask, Ns};
use crate::view::LaserView;

/// Mapped crds at power-on: the first two.
const CRD_MAP: u8 = 0b11;

/// What has happened since the last plan.
mod news {
    /// Outputs or commands moved.
    pub(super) const MOVED: u8 = 1;
    /// The power may be another: it is found anew, and its train.
    pub(super) const POWER: u8 = 2;
    /// What is shown of the settings is another.
    pub(super) const SETTINGS: u8 = 4;
    /// Settings changed.
    pub(super) const CHANGED: u8 = POWER | SETTINGS;
}

/// What the outputs carry.
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
    const REST: Outputs = Outputs { light: false, switch: false, volts: None, train: Train::NONE };
}

/// A channel. The queues of edges lie last, so that the rest is within reach of short instructions.
#[derive(Debug)]
#[repr(C)]
pub(super) struct Channel {
    pub(super) shown: LaserView,
    safety: Safety,
    // Settings.
    law: Law,
    energy: Energy,
    delays: Delays,
    delayed: bool,
    fpk: Option<Fpk>,
    // State.
    commanded: bool,
    whose: Whose,
    /// From the gate-off edge of the mark in progress to the end of its light.
    tail: u16,
    /// End of the FPK pulse in progress, or [`NEVER`].
    pulse: Ns,
    /// The light that the outputs carry is of another mode: it is cut.
    cut: bool,
    /// A cause within the interval puts out everything.
    ends: bool,
    alarms: CrdMask,
    on_time: OnTime,
    /// Light planned in the interval that is in force until the next tick, ns.
    planned: u32,
    // What was made of it.
    out: Outputs,
    /// Power and train in light.
    power: Power,
    train: Train,
    /// What the width of its pulses is of each power, where nothing else changes with that.
    plain: Plain,
    news: u8,
    /// The next edge.
    wake: Ns,
    gate: Edges,
    /// Light: the gate, shifted by the FPK.
    light: Edges,
    /// What paths do in the interval that is planned next.
    agenda: Agenda,
}

impl Channel {
    /// Channel `index` at power-on.
    pub(super) const fn power_on(index: u8) -> Channel {
        Channel {
            shown: LaserView { crd_map: CRD_MAP, ..LaserView::BEFORE },
            safety: Safety::LIVE,
            law: Law::power_on(index, Family::Gus),
            energy: Energy::POWER_ON,
            delays: Delays { off: 0, on: 0 },
            delayed: true,
            fpk: None,
            commanded: false,
            whose: Whose::NOBODY,
            agenda: Agenda::EMPTY,
            gate: Edges::OFF,
            light: Edges::OFF,
            tail: 0,
            pulse: NEVER,
            cut: false,
            ends: false,
            alarms: CrdMask(0),
            on_time: OnTime::ZERO,
            planned: 0,
            out: Outputs::REST,
            power: Power::ZERO,
            train: Train::NONE,
            plain: Plain::NONE,
            news: news::CHANGED,
            wake: NEVER,
        }
    }

    /// Carries out a change; `at` lies in the interval that is planned next.
    pub(super) fn change(&mut self, at: Ns, change: &Change) {
        // What paths did at this instant before it comes first.
        self.attend(at);
        self.news |= match change {
            Change::Gate { .. } => news::MOVED,
            Change::Direct { .. } if self.law.follows().is_none() => news::POWER,
            _ => news::CHANGED,
        };
        match change {
            Change::Gate { on } => self.command(at, *on, None),
            Change::Mode { mode, bounds, delayed, fine } => {
                if *mode != self.energy.mode {
                    self.withdraw();
                    self.energy.mode = *mode;
                    self.law.leave_mode();
                }
                self.law.set_bounds(*bounds);
                self.delayed = *delayed;
                self.energy.fine = *fine;
            }
            Change::Direct { power, fine } => {
                let followed = self.law.follows().is_some();
                self.law.set_direct(*power);
                self.energy.fine = *fine;
                self.see_follow_end(followed, None);
            }
            Change::Carrier { carrier, fine } => (self.energy.carrier, self.energy.fine) = (Some(*carrier), *fine),
            Change::PulseWidth { us } => self.energy.width = Some(*us),
            Change::Delays(delays) => self.delays = *delays,
            Change::Fpk(fpk) => {
                self.fpk = *fpk;
                if fpk.is_none() {
                    self.pulse = NEVER;
                }
            }
            Change::Standby(standby) => self.energy.standby = *standby,
            Change::PreVoltage(volts) => self.energy.pre_voltage = volts.unwrap_or(Power::ZERO),
            Change::ZeroOnTime => (self.on_time, self.planned) = (OnTime::ZERO, 0),
            Change::ClearFault => self.safety.clear(),
            Change::CrdMap { map } => {
                self.shown.crd_map = *map;
                self.see_alarms();
            }
            Change::Connector { laser } => {
                if !*laser && self.energy.mode != Mode::Analog {
                    self.withdraw();
                }
                self.energy.connector = *laser;
            }
            Change::Distance(distance) => self.law.set_distance(*distance),
            Change::Reset { family } => self.reset(*family),
        }
    }

    /// An on or off command of a path, or an immediate one.
    fn command(&mut self, at: Ns, on: bool, by: Option<Run>) {
        if on && self.safety.is_dark() {
            if let Some(run) = by
                && self.safety.cause() == Cause::LinkLost
            {
                self.whose.command_unseen(on, run);
            }
            return;
        }
        self.whose.command(on, by);
        self.switch(at, on);
    }

    /// A gate command.
    fn switch(&mut self, at: Ns, on: bool) {
        self.commanded = on;
        let us = match (self.delayed, on) {
            (false, _) => 0,
            (true, true) => self.delays.on,
            (true, false) => self.delays.off,
        };
        let done = self.gate.command(later(at, us), on);
        self.hold(done);
    }

    /// Something that a path does at an instant of the interval that is planned next.
    pub(super) fn expect(&mut self, at: Ns, event: Event) {
        if self.agenda.put(at, event).is_err() {
            // What is due already has waited for nothing.
            self.attend(at);
            if self.agenda.put(at, event).is_err() {
                self.trip(Cause::Edges);
            }
        }
        self.wake = self.wake.min(at);
    }

    /// Whether the start of a path may change something: light is kept for it, or something else is expected before.
    pub(super) fn heeds_start(&self, run: Run) -> bool {
        self.whose.keeps(run) || !self.agenda.is_empty()
    }

    /// What is due takes place.
    fn attend(&mut self, now: Ns) {
        while let Some(event) = self.agenda.take(now) {
            self.happen(now, event);
        }
    }

    /// What was expected takes place.
    fn happen(&mut self, at: Ns, event: Event) {
        match event {
            Event::Change(run, Buffered::Gate { on }) => {
                self.news |= news::MOVED;
                self.command(at, on, Some(run));
            }
            Event::Change(run, change) => {
                self.news |= news::CHANGED;
                let followed = self.law.follows().is_some();
                self.law.change(run.crd, &change);
                if followed && change.begins_follow() {
                    self.whose.forget(Some(run));
                }
                self.see_follow_end(followed, Some(run));
            }
            Event::Rest(run, goes_on) => {
                if self.is_mapped(run.crd) && self.whose.rest(run, goes_on) {
                    self.news |= news::MOVED;
                    self.switch(at, false);
                }
            }
            // A start in the very tick that the link is lost in brakes at once: its light waits for the next one.
            Event::Start(run, goes_on) if goes_on && self.is_mapped(run.crd) && self.safety.loses_link() => {}
            Event::Start(run, goes_on) => {
                if self.whose.start(run, goes_on && self.is_mapped(run.crd) && !self.safety.is_dark()) {
                    self.news |= news::MOVED;
                    self.switch(at, true);
                }
            }
            Event::Trip(cause) => {
                self.whose = Whose::NOBODY;
                self.news |= news::CHANGED;
                self.ends |= !self.safety.is_dark();
                self.safety.trip_within(cause);
            }
        }
    }

    /// Whether the channel is mapped to a coordinate system.
    pub(super) fn is_mapped(&self, crd: Crd) -> bool {
        CrdMask(self.shown.crd_map).has(crd)
    }

    /// Whose planned speed it follows, and that of whose encoders, or may from within the coming interval on.
    #[inline(always)]
    pub(super) fn wants(&self) -> (CrdMask, CrdMask) {
        if !self.agenda.is_empty() && self.agenda.follows() {
            return (CrdMask(u8::MAX), CrdMask(u8::MAX));
        }
        (self.law.planned, self.law.encoder)
    }

    /// The axes whose places count by fixed ratios, if any do.
    #[inline(always)]
    pub(super) fn places(&self) -> Option<u32> {
        self.law.places()
    }

    /// Ends a follow that one of these began.
    pub(super) fn end_follow(&mut self, crds: CrdMask) {
        let followed = self.law.follows().is_some();
        self.law.end_follow(crds);
        self.news |= news::CHANGED;
        self.see_follow_end(followed, None);
    }

    /// Where there was a follow that has ended, perhaps by an entry: light that rest keeps dark counts as switched off.
    fn see_follow_end(&mut self, followed: bool, by: Option<Run>) {
        if followed && self.law.follows().is_none() {
            self.whose.forget(by);
        }
    }

    /// It was on for so many units more: see [`crate::tick::Tick::age_counts`].
    pub(super) fn age_light(&mut self, units: u32) {
        self.on_time.age(units);
    }

    /// Which coordinate systems have an alarm now.
    pub(super) fn alarms(&mut self, crds: CrdMask) {
        self.alarms = crds;
        self.see_alarms();
        self.news |= news::CHANGED;
    }

    /// An alarm may begin for the channel by what it is mapped to, too.
    fn see_alarms(&mut self) {
        if self.safety.alarm(self.alarms.0 & self.shown.crd_map != 0) {
            self.trip(Cause::Alarm);
        }
    }

    /// Some coordinate systems had a fault that is cleared (ClrSts).
    pub(super) fn clear(&mut self, crds: CrdMask) {
        if crds.0 & self.shown.crd_map != 0 {
            self.safety.clear();
            self.news |= news::CHANGED;
        }
    }

    /// A refused on command puts the channel out: a mark would be missing.
    fn hold(&mut self, done: Result<(), Full>) {
        if done.is_err() {
            self.trip(Cause::Edges);
        }
    }

    /// The same, and no path brings it back.
    fn withdraw(&mut self) {
        self.whose = Whose::NOBODY;
        self.extinguish();
    }

    /// Light and FPK pulse are over without delays, the on command is withdrawn.
    fn extinguish(&mut self) {
        self.commanded = false;
        self.gate.clear();
        self.light.clear();
        self.pulse = NEVER;
        self.cut = true;
    }

    /// Power-on state. What the outputs carry, and a fault, outlive it.
    fn reset(&mut self, family: Family) {
        self.withdraw();
        (self.law, self.energy) = (Law::power_on(self.law.channel(), family), Energy::POWER_ON);
        (self.delays, self.delayed, self.fpk) = (Delays::default(), true, None);
        (self.shown.crd_map, self.on_time, self.planned) = (CRD_MAP, OnTime::ZERO, 0);
    }

    /// What the outputs carry, as actions that bring outputs at rest there.
    pub(super) fn carried(&self) -> [Action; 3] {
        let Outputs { switch, train, volts, light } = self.out;
        let energy = if light { Action::Light(train) } else { Action::Dark { standby: train, cut: true } };
        [Action::Switch(switch), energy, Action::Volts(volts.unwrap_or(0))]
    }

    /// A cause has appeared: dark at once.
    pub(super) fn trip(&mut self, cause: Cause) {
        // A path that the lost link stops may go on, and its light with it.
        if cause == Cause::LinkLost {
            self.whose.interrupt();
        } else {
            self.whose = Whose::NOBODY;
        }
        self.safety.trip(cause);
        self.news |= news::CHANGED;
    }

    /// The host link is lost, or there again; `runs`: a program runs.
    pub(super) fn link(&mut self, lost: bool, runs: bool) {
        self.safety.link(lost);
        self.news |= news::CHANGED;
        if lost && (runs || self.gate.may_be_on() || self.light.may_be_on()) {
            self.trip(Cause::LinkLost);
        }
    }
}

/// An instant `us` µs later.
#[inline]
fn later(at: Ns, us: u16) -> Ns {
    Ns(at.0.wrapping_add((us as u32).wrapping_mul(1000) as u64))
}
