//! One channel: from commands to the actions of a tick.
//!
//! In: changes at the instant of the tick that is computed, the interval to plan. Out: a [`Plan`], what is
//! shown. Owns settings, gate, FPK pulse, light and what the outputs carry. Fails: towards the dark.
//!
//! What the outputs should carry follows from the state as it stands at an instant; the plan is the difference
//! to what they carry. So nothing is owed to an edge that was missed. Changes act in their order and before
//! the edges of their instant; a gate edge acts before the light's, which it may cancel.
use super::dither::Clock;
use super::energy::{Energy, Told};
use super::gate::{Edges, Full};
use super::light::OnTime;
use super::plan::{Action, PLACES, Plan, Train};
use super::power::{Bounds, Law, Power};
use super::safety::{Cause, Safety};
use super::{Change, Delays, Fpk, Mode};
use crate::units::Ns;
use crate::view::LaserView;

/// What an instant may need in a plan: an end of light and a beginning, a switch edge, a voltage.
const ROOM: usize = 4;
/// Instants in a tick at which something happens, apart from its beginning.
const EVENTS: u32 = PLACES as u32;
/// Mapped crds at power-on: the first two.
const CRD_MAP: u8 = 0b11;

/// What the PWM carries.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Pwm {
    /// No light; standby, or rest.
    Dark(Train),
    /// Light.
    Lit(Train),
}

/// What the outputs carry, or should.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Outputs {
    pwm: Pwm,
    switch: bool,
    /// The DAC, while the laser drives it.
    volts: Option<i16>,
}

impl Outputs {
    const REST: Outputs = Outputs { pwm: Pwm::Dark(Train::NONE), switch: false, volts: None };
}

/// A channel.
#[derive(Debug)]
pub(super) struct Channel {
    pub(super) shown: LaserView,
    safety: Safety,
    // Settings.
    law: Law,
    energy: Energy,
    delays: Delays,
    delayed: bool,
    fpk: Option<Fpk>,
    crd_map: u8,
    // State.
    commanded: bool,
    gate: Edges,
    /// Light: the gate, shifted by the FPK.
    light: Edges,
    /// From the gate-off edge of the mark in progress to the end of its light.
    tail: Ns,
    /// End of the FPK pulse in progress.
    pulse: Option<Ns>,
    /// The light, or the standby, that the outputs carry is not of this mode: it is cut.
    cut: bool,
    on_time: OnTime,
    /// Light planned in the interval that is in force until the next tick, ns.
    planned: u32,
    // What was made of it.
    out: Outputs,
    power: Power,
    train: Train,
    limited: bool,
    /// Something here differs from what is planned and shown.
    stale: bool,
}

impl Channel {
    pub(super) const POWER_ON: Channel = Channel {
        shown: LaserView::BEFORE,
        safety: Safety::LIVE,
        law: Law { direct: Power::ZERO, bounds: Bounds::full(Mode::Duty) },
        energy: Energy::POWER_ON,
        delays: Delays { off: 0, on: 0 },
        delayed: true,
        fpk: None,
        crd_map: CRD_MAP,
        commanded: false,
        gate: Edges::OFF,
        light: Edges::OFF,
        tail: Ns(0),
        pulse: None,
        cut: false,
        on_time: OnTime::ZERO,
        planned: 0,
        out: Outputs::REST,
        power: Power::ZERO,
        train: Train::NONE,
        limited: false,
        stale: true,
    };

    /// Carries out a change; `at` lies in the interval that is planned next.
    pub(super) fn change(&mut self, at: Ns, change: Change) {
        self.stale = true;
        match change {
            Change::Gate { on } => self.command(at, on),
            Change::Mode { mode, bounds, delayed, fine } => {
                if mode != self.energy.mode {
                    self.extinguish();
                    self.energy.mode = mode;
                    self.law.direct = Power::ZERO;
                }
                (self.law.bounds, self.delayed) = (bounds, delayed);
                self.energy.fine = fine;
            }
            Change::Direct { power, fine } => (self.law.direct, self.energy.fine) = (power, fine),
            Change::Carrier { carrier, fine } => (self.energy.carrier, self.energy.fine) = (Some(carrier), fine),
            Change::PulseWidth { us } => self.energy.width = Some(us),
            Change::Delays(delays) => self.delays = delays,
            Change::Fpk(fpk) => {
                self.fpk = fpk;
                if fpk.is_none() {
                    self.pulse = None;
                }
            }
            Change::Standby(standby) => self.energy.standby = standby,
            Change::PreVoltage(volts) => self.energy.pre_voltage = volts,
            Change::ZeroOnTime => (self.on_time, self.planned) = (OnTime::ZERO, 0),
            Change::ClearFault => self.safety.clear(),
            Change::CrdMap { map } => self.crd_map = map,
            Change::Connector { laser } => self.energy.connector = laser,
            Change::Reset => self.reset(),
        }
    }

    fn command(&mut self, at: Ns, on: bool) {
        if on && self.safety.is_dark() {
            return;
        }
        self.commanded = on;
        let us = match (self.delayed, on) {
            (false, _) => 0,
            (true, true) => self.delays.on,
            (true, false) => self.delays.off,
        };
        let done = self.gate.command(later(at, us), on);
        self.hold(done);
    }

    /// A refused on command puts the channel out: a mark would be missing.
    fn hold(&mut self, done: Result<(), Full>) {
        if done.is_err() {
            self.trip(Cause::Edges);
        }
    }

    /// Light and FPK pulse are over without delays, the on command is withdrawn.
    fn extinguish(&mut self) {
        self.commanded = false;
        self.gate.clear();
        self.light.clear();
        self.pulse = None;
        self.cut = true;
    }

    /// Power-on state. What the outputs carry, and a fault whose cause lasts, outlive it.
    fn reset(&mut self) {
        self.extinguish();
        self.safety.clear();
        (self.law, self.energy) = (Channel::POWER_ON.law, Energy::POWER_ON);
        (self.delays, self.delayed, self.fpk) = (Delays::default(), true, None);
        (self.crd_map, self.on_time, self.planned) = (CRD_MAP, OnTime::ZERO, 0);
    }

    /// A cause has appeared: dark at once.
    pub(super) fn trip(&mut self, cause: Cause) {
        self.safety.trip(cause);
        self.stale = true;
    }

    /// The host link is lost, or there again; `runs`: a program runs.
    pub(super) fn link(&mut self, lost: bool, runs: bool) {
        self.safety.link(lost);
        self.stale = true;
        if lost && (runs || self.commanded || self.gate.may_be_on() || self.light.may_be_on()) {
            self.trip(Cause::LinkLost);
        }
    }

    /// Plans the interval of `period` from `next` on.
    #[inline]
    pub(super) fn step(&mut self, next: Ns, period: Ns, interlock: bool, clock: Clock, plan: &mut Plan) {
        plan.clear();
        if self.safety.interlock(interlock) {
            self.stale = true;
            if interlock {
                self.trip(Cause::Interlock);
            }
        }
        let end = Ns(next.0.wrapping_add(period.0));
        if self.stale || self.next_event(end).is_some() {
            self.plan(next, end, clock, plan);
        } else {
            self.pass();
            if self.light.level() {
                self.planned = period.0 as u32;
            }
        }
        self.safety.guard(plan);
    }

    /// The interval that was planned last has passed as planned.
    #[inline]
    fn pass(&mut self) {
        if self.planned != 0 {
            self.on_time.add(self.planned);
            self.planned = 0;
            self.shown.on_time = self.on_time.units();
        }
    }

    /// The first instant before `end` at which something happens.
    #[inline]
    fn next_event(&self, end: Ns) -> Option<Ns> {
        let of_pulse = self.pulse.filter(|at| *at < end);
        let events = [self.gate.before(end), self.light.before(end), of_pulse];
        events.into_iter().flatten().min()
    }

    #[inline(never)]
    fn plan(&mut self, next: Ns, end: Ns, clock: Clock, plan: &mut Plan) {
        if self.safety.is_dark() {
            self.go_dark();
        }
        self.pass();
        self.power = self.law.power();
        (self.train, self.limited) = self.energy.light(self.power, clock);
        self.stale = false;
        if self.cut {
            // What another mode put out is over before the edges of this instant.
            self.settle_pwm(0, plan);
        }
        let (mut now, mut lit, mut left) = (next, 0u64, EVENTS);
        loop {
            while let Some(on) = self.gate.take(now) {
                self.edge(now, on);
            }
            self.pulse = self.pulse.filter(|at| *at > now);
            while self.light.take(now).is_some() {}
            let offset = now.0.wrapping_sub(next.0) as u32;
            self.settle(offset, plan);
            if now == next {
                self.show();
            } else {
                // What is shown is of the interval's beginning.
                self.stale = true;
            }
            let after = self.next_event(end);
            if self.light.level() {
                lit = after.unwrap_or(end).0.wrapping_sub(now.0).wrapping_add(lit);
            }
            match after {
                Some(at) if plan.has_room(ROOM) && left > 0 => (now, left) = (at, left.wrapping_sub(1)),
                Some(_) => break self.trip(Cause::Edges),
                None => break,
            }
        }
        self.planned = lit as u32;
        if self.safety.is_dark() {
            self.go_dark();
            self.show();
        }
    }

    /// A gate edge.
    fn edge(&mut self, now: Ns, on: bool) {
        let done = if on {
            let (begin, end) = self.fpk.map_or((0, 0), |fpk| (fpk.begin, fpk.end));
            self.tail = later(Ns(0), end);
            if let Some(fpk) = self.fpk {
                self.pulse = Some(later(now, fpk.pulse.get()));
            }
            self.light.command(later(now, begin), true)
        } else {
            self.light.command(Ns(now.0.wrapping_add(self.tail.0)), false)
        };
        self.hold(done);
    }

    /// A dark channel: nothing is on, nothing pends, and nothing of what was planned takes place.
    fn go_dark(&mut self) {
        self.extinguish();
        (self.cut, self.planned, self.out) = (false, 0, Outputs::REST);
    }

    /// What the outputs should carry as things stand.
    fn wanted(&self) -> Outputs {
        let light = self.light.level();
        let open = self.energy.mode == Mode::DutyOpen;
        Outputs {
            pwm: if light { Pwm::Lit(self.train) } else { Pwm::Dark(self.energy.standby()) },
            switch: open || if self.fpk.is_some() { self.pulse.is_some() } else { self.gate.level() },
            volts: self.energy.volts(light, self.power),
        }
    }

    /// Brings the outputs to what they should carry.
    fn settle(&mut self, at: u32, plan: &mut Plan) {
        self.settle_pwm(at, plan);
        let wanted = self.wanted();
        if wanted.switch != self.out.switch {
            plan.push(at, Action::Switch(wanted.switch));
        }
        if wanted.volts != self.out.volts {
            plan.push(at, Action::Volts(wanted.volts.unwrap_or(0)));
        }
        self.out = wanted;
    }

    fn settle_pwm(&mut self, at: u32, plan: &mut Plan) {
        let wanted = self.wanted().pwm;
        let cut = self.cut || self.energy.mode == Mode::DutyOpen;
        match (self.out.pwm, wanted) {
            (Pwm::Lit(_), Pwm::Dark(standby)) => plan.push(at, Action::Dark { standby, cut }),
            (Pwm::Dark(_), Pwm::Lit(train)) => plan.push(at, Action::Light(train)),
            (Pwm::Lit(was), Pwm::Lit(train)) => {
                if was != train {
                    plan.push(at, Action::Change(train));
                }
            }
            (Pwm::Dark(was), Pwm::Dark(standby)) => {
                if was != standby {
                    let change = if self.energy.mode.has_standby() {
                        Action::Change(standby)
                    } else {
                        Action::Dark { standby, cut: true }
                    };
                    plan.push(at, change);
                }
            }
        }
        (self.out.pwm, self.cut) = (wanted, false);
    }

    /// What the thread sees, of the interval's beginning.
    fn show(&mut self) {
        let dark = self.safety.is_dark();
        let light = self.light.level();
        let Told { power, khz, train } =
            if dark { Told::default() } else { self.energy.told(light, self.power, &self.train) };
        self.shown = LaserView {
            changes: self.shown.changes.wrapping_add(1),
            mode: self.energy.mode,
            commanded: self.commanded,
            gate: self.gate.level(),
            switch: self.out.switch,
            light,
            limited: self.limited,
            connector: self.energy.connector,
            delayed: self.delayed,
            fault: self.safety.cause(),
            cause_lasts: self.safety.lasts(),
            crd_map: self.crd_map,
            width_us: self.energy.width.map_or(0, |us| us.get()),
            bounds: self.law.bounds,
            direct: self.law.direct,
            carrier: self.energy.carrier,
            power,
            khz,
            train,
            on_time: self.on_time.units(),
        };
    }
}

/// An instant `us` µs later.
#[inline]
fn later(at: Ns, us: u16) -> Ns {
    Ns(at.0.wrapping_add((us as u64).wrapping_mul(1000)))
}
