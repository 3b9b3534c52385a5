//! The plan of an interval: the actions of the outputs in it.
//!
//! In: the channel after its changes, events of paths within the interval, the values that the
//! power follows. Out: the actions of a [`LaserPlan`], the published view. Owns nothing else.
//! Fails: more events than a plan holds make the channel dark.
use super::{Channel, Outputs, changed};
use crate::laser::actions::{Action, LaserPlan, PLAN_ACTIONS, PulseRate, Train};
use crate::laser::energy::{Energy, FixedGainWidth};
use crate::laser::light_owner::LightEvent;
use crate::laser::power::Power;
use crate::laser::safety::Cause;
use crate::laser::{Clock, FollowInputs, NEVER, Positions, PowerMode};
use crate::units::Ns;

/// Actions that an instant may need in a plan: an end of light and a beginning, a switch edge, a
/// voltage.
const INSTANT_ACTIONS: usize = 4;
/// Instants in a tick at which something happens, apart from its beginning.
const INTERVAL_INSTANTS: u32 = PLAN_ACTIONS as u32;

impl Channel {
    /// Plans the interval of `period` from `next` on.
    #[inline]
    pub(in crate::laser) fn step(
        &mut self,
        next: Ns,
        period: Ns,
        interlock: bool,
        around: &FollowInputs<impl Positions>,
        plan: &mut LaserPlan,
    ) {
        plan.clear();
        if self.safety.interlock(interlock) {
            self.changed |= changed::CHANGED;
            if interlock {
                self.trip(Cause::Interlock);
            }
        }
        let end = Ns(next.0.wrapping_add(period.0));
        if self.changed != 0 || self.next_edge < end {
            self.plan(next, end, around, plan);
        } else if self.out.light {
            self.pass();
            self.planned = period.0 as u32;
            if self.law.moves() {
                self.follow(around, plan);
            }
        } else {
            self.pass();
            self.law.skip();
        }
        self.safety.guard(plan);
    }

    /// Light goes on, with a power that may differ.
    #[inline(never)]
    fn follow(&mut self, around: &FollowInputs<impl Positions>, plan: &mut LaserPlan) {
        let power = self.law.power(around);
        if power == self.power {
            return;
        }
        self.power = power;
        let Some(width) = self.plain.width(power) else { return self.change_train_of_light(around, plan) };
        // The carrier goes on: only its pulses differ.
        self.train.width = width;
        if width == self.out.train.width {
            return;
        }
        self.out.train.width = width;
        plan.begin_with(&self.out.train);
        self.published.take_power(power, width);
    }

    /// The same if more may change than the width of its pulses.
    #[inline(never)]
    fn change_train_of_light(&mut self, around: &FollowInputs<impl Positions>, plan: &mut LaserPlan) {
        self.published.limited = self.energy.light(self.power, around.clock, &mut self.train);
        if self.train != self.out.train {
            let action = self.go_on();
            plan.push(0, action);
        }
        if self.energy.mode == PowerMode::Analog {
            self.drive(0, true, plan);
        }
        self.publish_power();
        self.plain = self.energy.plain(&self.out.train);
    }

    /// The interval that was planned last has passed as planned.
    #[inline(always)]
    fn pass(&mut self) {
        if self.planned != 0 {
            self.on_time.add(self.planned);
            self.planned = 0;
            self.published.on_time = self.on_time.units;
        }
    }

    /// Plans an interval in which something may happen.
    #[inline(never)]
    fn plan(&mut self, next: Ns, end: Ns, around: &FollowInputs<impl Positions>, plan: &mut LaserPlan) {
        if self.safety.is_safe() || self.safety.is_dark() && !self.ends {
            return self.stay_dark(end);
        }
        self.pass();
        self.plain = FixedGainWidth::NONE;
        self.attend(next);
        let mut changed = core::mem::take(&mut self.changed);
        if self.law.moves() {
            changed |= changed::POWER;
        }
        if changed & changed::POWER != 0 {
            self.find_power(around);
        }
        if self.cut {
            // The train of another mode ends before the edges of this instant, also a last pulse
            // that is being finished.
            self.cut = false;
            self.darken(0, true, plan);
        }
        let due = self.soonest() <= next;
        if due {
            self.take(next);
        }
        if due || changed != 0 {
            self.update_outputs(0, changed & changed::POWER != 0, plan);
            // The view is of the interval's beginning.
            self.publish(changed & changed::SETTINGS != 0);
        }
        if self.ends {
            self.end_within(0, end, plan);
        }
        self.next_edge = self.soonest();
        let until = self.next_edge.min(end);
        self.planned = if self.out.light { until.0.wrapping_sub(next.0) as u32 } else { 0 };
        if until < end {
            self.walk(next, end, around, plan);
        }
        if self.safety.is_dark() && !self.safety.in_grace() {
            self.go_dark();
            self.publish(true);
        }
    }

    /// An interval without any output. If it ends the darkness of an abort, the next one begins
    /// anew.
    #[inline(never)]
    fn stay_dark(&mut self, end: Ns) {
        if self.safety.in_grace() {
            self.pass();
        }
        self.law.skip();
        self.go_dark();
        if self.owner.is_lit() {
            // An on command after an abort that found everything at standstill.
            self.report(end, LightEvent::Relight);
        }
        self.pass_dark_interval(end);
        self.changed = if self.safety.is_dark() { 0 } else { changed::CHANGED };
        self.publish(true);
    }

    /// The edges and events within the interval.
    #[inline(never)]
    fn walk(&mut self, next: Ns, end: Ns, around: &FollowInputs<impl Positions>, plan: &mut LaserPlan) {
        let mut left = INTERVAL_INSTANTS;
        while self.next_edge < end {
            self.changed |= changed::MOVED;
            if left == 0 || !plan.has_room(INSTANT_ACTIONS) {
                return self.trip(Cause::Edges);
            }
            left = left.wrapping_sub(1);
            let now = self.next_edge;
            let at = now.0.wrapping_sub(next.0) as u32;
            self.attend(now);
            if self.ends {
                return self.end_within(at, end, plan);
            }
            let anew = self.changed & changed::POWER != 0;
            if anew {
                self.changed &= !changed::POWER;
                self.find_power(around);
            }
            self.take(now);
            self.update_outputs(at, anew, plan);
            self.next_edge = self.soonest();
            if self.out.light {
                self.planned = self.planned.wrapping_add(self.next_edge.min(end).0.wrapping_sub(now.0) as u32);
            }
        }
    }

    /// Events and edges of an interval in the dark.
    fn pass_dark_interval(&mut self, end: Ns) {
        while self.event_queue.next < end
            && let Some(event) = self.event_queue.take(end)
        {
            self.apply_event(end, event);
        }
        if self.safety.is_dark() {
            self.gate.clear();
        }
        self.next_edge = self.soonest();
    }

    /// All outputs go to their safe state within the interval, and stay dark from there on.
    fn end_within(&mut self, at: u32, end: Ns, plan: &mut LaserPlan) {
        if self.out.light || !self.out.train.is_none() {
            plan.push(at, Action::Dark { standby: Train::NONE, cut: true });
        }
        if self.out.switch {
            plan.push(at, Action::Switch(false));
        }
        if self.out.volts.is_some() {
            plan.push(at, Action::Volts(0));
        }
        let planned = self.planned;
        self.ends = false;
        self.go_dark();
        self.planned = planned;
        self.pass_dark_interval(end);
        self.changed = changed::CHANGED;
    }

    /// The power in force, and its train.
    #[inline(never)]
    fn find_power(&mut self, around: &FollowInputs<impl Positions>) {
        self.power = self.law.power(around);
        self.published.limited = self.energy.light(self.power, around.clock, &mut self.train);
    }

    /// The next edge of any kind.
    #[inline(always)]
    fn soonest(&self) -> Ns {
        self.gate.next.min(self.light.next).min(self.pulse).min(self.event_queue.next)
    }

    /// A dark channel: nothing is on, nothing pends, and nothing of the plan takes place.
    #[inline(never)]
    fn go_dark(&mut self) {
        self.end_light();
        (self.cut, self.planned, self.out, self.next_edge) = (false, 0, Outputs::SAFE_STATE, NEVER);
    }

    /// Brings the outputs to the levels that they should have; `anew`: trains may have changed.
    #[inline(always)]
    fn update_outputs(&mut self, at: u32, anew: bool, plan: &mut LaserPlan) {
        let light = self.light.level;
        if light != self.out.light {
            if light {
                (self.out.light, self.out.train) = (true, self.train);
                self.rate = if self.train.is_none() { Power::ZERO } else { self.power };
                plan.push(at, Action::Light(self.train));
            } else {
                // A level is no pulse that could be finished.
                let is_level = self.energy.mode == PowerMode::DutyOpen || self.out.train.is_level();
                self.darken(at, is_level, plan);
            }
        } else if anew {
            self.change_train(at, plan);
        }
        let gate = if self.fpk.is_some() { self.pulse != NEVER } else { self.gate.level };
        let switch = gate || self.energy.holds_switch();
        if switch != self.out.switch {
            self.out.switch = switch;
            plan.push(at, Action::Switch(switch));
        }
        if self.energy.mode == PowerMode::Analog || self.out.volts.is_some() {
            self.drive(at, light, plan);
        }
    }

    /// Brings the DAC to the value that it should have.
    fn drive(&mut self, at: u32, light: bool, plan: &mut LaserPlan) {
        let volts = self.energy.volts(light, self.power);
        if volts != self.out.volts {
            self.out.volts = volts;
            plan.push(at, Action::Volts(volts.unwrap_or(0)));
        }
    }

    /// Light ends.
    #[inline(never)]
    fn darken(&mut self, at: u32, cut: bool, plan: &mut LaserPlan) {
        let standby = self.energy.standby().map_or(Train::NONE, |standby| *standby.train());
        (self.out.light, self.out.train) = (false, standby);
        plan.push(at, Action::Dark { standby, cut });
    }

    /// Light, or its absence, goes on, perhaps with another train.
    #[inline(never)]
    fn change_train(&mut self, at: u32, plan: &mut LaserPlan) {
        let standby = self.energy.standby().map_or(&Train::NONE, |standby| standby.train());
        let train = *if self.out.light { &self.train } else { standby };
        if train == self.out.train {
            return;
        }
        let action = if self.out.light {
            self.go_on()
        } else {
            self.out.train = train;
            Action::Change(train)
        };
        plan.push(at, action);
    }

    /// Light goes on with another train: a carrier from its next period on, a rate in phase.
    fn go_on(&mut self) -> Action {
        self.out.train = self.train;
        if self.energy.mode != PowerMode::Frequency {
            return Action::Change(self.train);
        }
        if self.train.is_none() {
            return Action::Rate(PulseRate::PAUSE);
        }
        let before = core::mem::replace(&mut self.rate, self.power);
        Action::Rate(Clock::rate(before, self.power, self.train.period, self.train.width.whole as u32))
    }

    /// Publishes the present power and train.
    #[inline(always)]
    fn publish_power(&mut self) {
        let (power, khz) = match (self.safety.is_dark(), self.out.light) {
            (true, _) => (Power::ZERO, Power::ZERO),
            (_, true) => self.energy.light_output(self.power, &self.train),
            (_, false) => self.energy.dark_output(),
        };
        let published = &mut self.published;
        (published.version, published.settings_version) =
            (published.version.wrapping_add(1), published.settings_version.wrapping_add(1));
        (published.power, published.khz) = (power, khz);
        let limited = (published.limited & self.out.light) as u8;
        published.limits = published.limits.wrapping_add(published.limits & 1 ^ limited);
        published.train = if khz == Power::ZERO { Train::NONE } else { self.out.train };
    }

    /// Publishes the state at the interval's beginning.
    #[inline(never)]
    fn publish(&mut self, changed: bool) {
        self.publish_power();
        let published = &mut self.published;
        (published.commanded, published.gate) = (self.owner.is_commanded(), self.gate.level);
        published.owners = self.owner.owners();
        (published.switch, published.light) = (self.out.switch, self.out.light);
        (published.direct, published.on_time) = (self.law.direct, self.on_time.units);
        if changed {
            published.state_version = published.state_version.wrapping_add(1);
            let Energy { mode, connector, width, carrier, .. } = self.energy;
            (published.mode, published.connector, published.delayed) = (mode, connector, self.delayed);
            (published.fault, published.cause_lasts) = (self.safety.cause(), self.safety.lasts());
            published.bounds = self.law.bounds;
            (published.follows, published.source) = (self.law.follows(), self.law.source);
            (published.bank, published.table) = (self.law.bank(), self.law.table());
            (published.width_us, published.carrier) = (width.map_or(0, |us| us.get()), carrier);
        }
    }
}
