//! A tick of all axes: masters before their slaves, and what begins where a motion has come to.
use super::super::axis::{Axis, Motion, Why};
use super::super::filter::Filter;
use super::super::number::Fix;
use super::{Controller, Then};

impl Controller {
    /// Slaves above an axis in its chain, itself included: masters come before their slaves.
    fn depth(&self, index: usize) -> usize {
        let axis = &self.axes[index];
        match axis.follow.master.filter(|_| matches!(axis.motion, Some(Motion::Slave(_)))) {
            Some(master) if master.is_counted() => 1,
            Some(master) => 1 + self.depth(master.axis),
            None => 0,
        }
    }

    /// In the order of their depth, else of their numbers: docs/follow.md.
    fn order(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.axes.len()).collect();
        order.sort_by_key(|index| self.depth(*index));
        order
    }

    pub(super) fn step(&mut self, before: i64, now: i64) {
        self.step_paths(before, now);
        let mut axis = self.spare.take().unwrap_or_else(|| Box::new(Axis::new(0)));
        for index in self.order() {
            std::mem::swap(&mut axis, &mut self.axes[index]);
            let (ran, was_slave) = (axis.runs(), matches!(axis.motion, Some(Motion::Slave(_))));
            let began = axis.began;
            let master = axis.follow.master;
            let then = self.then[index].take();
            let mut open = None;
            if let Some(master) = master.filter(|master| was_slave && master.is_filtered()) {
                let of = &self.axes[master.axis];
                let at = if master.is_counted() { of.encoder[1] } else { of.x };
                axis.filter.get_or_insert_with(|| Filter::new(at)).step(at, now - before);
            }
            let filter = axis.filter.clone();
            let position =
                |at: Fix| master.and_then(|master| self.position_of(filter.as_ref(), master, at, before, now));
            let times = [Fix::ms(before), Fix::ms(now)];
            let lead = master.map(|master| self.lead(filter.as_ref(), master, &times, &position));
            // A controller has few slots for a master's motion in a tick: between the first and the
            // last of several knots it is linear for the slaves. A knot on the tick counts, and so
            // does where a Stop or an Update of the master acts.
            let follows = was_slave && !began;
            let of = master.map(|master| &self.axes[master.axis]);
            let replanned = of.is_some_and(|of| of.replanned);
            let ends_at_knot = !replanned && of.is_some_and(|of| of.is_at_knot(Fix::ms(now)));
            let most = if ends_at_knot || replanned { 3 } else { 4 };
            if follows && lead.as_ref().is_some_and(|lead| lead.track.len() > most && turns(lead.track)) {
                open = Some("a master that turns between several knots in a tick");
            }
            let arc = master.is_some_and(|master| !master.is_sampled() && self.axes[master.axis].bent);
            if follows && arc {
                open = Some("a slave of an axis on an arc");
            }
            if follows && master.is_some_and(|master| !master.is_counted() && self.axes[master.axis].is_astray()) {
                open = Some("a slave of an axis that a path moves");
            }
            let led_by_slave =
                master.is_some_and(|master| !master.is_sampled() && self.axes[master.axis].follow_moves());
            if follows && led_by_slave && lead.as_ref().is_some_and(|lead| turns(lead.track)) {
                open = Some("a slave that turns within a tick is followed");
            }
            axis.replanned = then.is_some();
            axis.step(before, now, lead.as_ref(), self.levels.inputs);
            if let (Some(Motion::Slave(slave)), Some(lead)) = (&axis.motion, &lead)
                && slave.timed
                && legs(lead.times) > if ends_at_knot { 1 } else { 2 }
            {
                open = Some("a delay of a slave whose master has several knots in a tick");
            }
            axis.velocity_rounding = Fix::ZERO;
            if let (Some(lead), Some(Motion::Slave(slave)), Some(master)) = (&lead, &axis.motion, master) {
                let of = if master.is_sampled() { Fix::ZERO } else { self.axes[master.axis].velocity_rounding };
                let position = self.rounding_of_master(&axis);
                axis.velocity_rounding = slave.velocity_rounding(lead, position, of);
                if master.is_sampled() {
                    // Its speed is taken from its master's positions at two ticks.
                    axis.velocity_rounding += Fix(1 << 43).over(Fix::ms(self.tick_ns));
                }
            }
            if let Some(lead) = &lead
                && was_slave
            {
                // A slave moves as far as its steepest ratio takes its master's motion.
                let displacement = lead.track.windows(2).fold(Fix::ZERO, |sum, leg| sum + (leg[1] - leg[0]).abs());
                axis.fastest = axis.fastest * displacement;
            } else {
                axis.fastest = axis.fastest * Fix::ms(self.tick_ns);
            }
            if axis.brink {
                open = Some("within rounding of a soft limit");
            }
            if axis.limited && axis.on_path {
                open = Some("a path that comes to a soft limit");
            }
            match then.filter(|_| !axis.limited) {
                Some(Then::Brake(dec, why)) => {
                    if let (Some(Motion::Slave(slave)), Some(lead)) = (&axis.motion, &lead)
                        && slave.is_near_knot(lead)
                    {
                        open = Some("a Stop where a slave's ratio jumps");
                    }
                    let counted = master.filter(|master| was_slave && master.is_counted());
                    if master.is_some_and(|master| was_slave && master.is_filtered()) {
                        // Its speed is that of positions with 22 fraction bits.
                        open = Some("a Stop of a slave of a filtered master");
                    }
                    if counted.is_some_and(|master| self.axes[master.axis].counts() < Fix::whole(4)) {
                        // What speed that is depends on the tick.
                        open = Some("a Stop of a slave of an encoder that hardly moves");
                    }
                    if axis.runs() {
                        if axis.v.abs() < Fix(1 << 44) && axis.v != Fix::ZERO || axis.v == Fix::ZERO && !was_slave {
                            axis.open = Some("a Stop within rounding of standstill");
                        }
                        axis.ending = why;
                        axis.slack += self.rounding(&axis);
                        axis.smooth_stop(now, dec);
                    }
                }
                Some(Then::Update(aim)) => {
                    axis.update(now, aim);
                    axis.began = false;
                    if axis.doubt {
                        axis.open = Some("an Update without a displacement");
                    }
                }
                None => {}
            }
            // Beyond a limit the tick of its end is that of its bit, or the one before.
            if axis.beyond() != 0 && axis.open.is_some() {
                open = axis.open;
            }
            self.open = self.open.or(open).or(axis.unsaid);
            self.count(&axis, was_slave);
            if axis.limited && ran && !axis.runs() {
                let what = match axis.why {
                    Some(Why::Positive | Why::Negative) => "motions ended by a limit switch",
                    Some(Why::Alarm) => "motions ended by an alarm",
                    _ if axis.is_alarmed() => "motions ended by an alarm",
                    _ => "motions ended by a soft limit",
                };
                *self.used.entry(what).or_default() += 1;
            }
            if ran && !axis.runs() {
                *self.used.entry("motions ended").or_default() += 1;
            }
            for (index, level) in axis.outputs.drain(..) {
                let bit = 1 << (index - 1);
                self.changes.push((now as f64 / 1e6, bit, if level { bit } else { 0 }));
                *self.used.entry("outputs set by FollowEx").or_default() += 1;
            }
            std::mem::swap(&mut axis, &mut self.axes[index]);
        }
        self.spare = Some(axis);
        self.step_light(before, now);
        self.change_outputs();
    }
}

/// Parts of a motion between knots; what two of them are apart by rounding is none.
fn legs(times: &[Fix]) -> usize {
    times.windows(2).filter(|leg| leg[1] - leg[0] > Fix(1 << 44)).count()
}

/// Whether a motion goes beyond its ends.
fn turns(track: &[Fix]) -> bool {
    let (Some(first), Some(last)) = (track.first(), track.last()) else { return false };
    track.iter().any(|at| at < first.min(last) || at > first.max(last))
}
