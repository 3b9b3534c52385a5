//! A tick of one axis: its motion from the tick before to this one.
use super::super::number::Fix;
use super::super::pt::Went;
use super::super::slave::{Around, Lead, Outcome};
use super::{Axis, Motion, Why, whole};

impl Axis {
    /// From the tick before to this one.
    pub fn step(&mut self, from_ns: i64, to_ns: i64, lead: Option<&Lead>, inputs: u32) {
        let (mut from, to) = (Fix::ms(from_ns), Fix::ms(to_ns));
        self.track.clear();
        self.track.push(self.x);
        self.times.clear();
        self.times.push(from);
        let moved = !self.head.is_empty();
        for (when, position) in self.head.drain(..) {
            self.times.push(when);
            self.track.push(position);
            from = when;
        }
        self.moved = moved;
        self.past = None;
        let was_open = self.open.take().is_some();
        (self.doubt, self.halted, self.began) = (false, false, false);
        (self.stopped, self.joined) = (false, false);
        self.resets = self.resets.saturating_sub(1);
        self.fastest = Fix::ZERO;
        self.pt.over = 0;
        let mut out = Vec::new();
        let alarmed = self.is_alarmed();
        if alarmed && self.runs() {
            self.alarm();
        }
        if alarmed && was_open {
            // Whether it came before the end of the motion is within rounding.
            self.why = None;
        }
        let ended = match &mut self.motion {
            None => false,
            Some(Motion::Ramp(timed)) => {
                self.fastest = timed.curve.steepest;
                let went = timed.step(from, to, 1, &mut out);
                self.v = timed.velocity(to);
                went == Went::Ended
            }
            Some(Motion::Pt(timed)) => {
                self.fastest = timed.curve.steepest;
                let went = timed.step(from, to, self.pt.loops, &mut out);
                self.v = timed.velocity(to);
                self.pt.passes = timed.passes;
                went == Went::Ended
            }
            Some(Motion::Pvt(timed)) => {
                self.fastest = timed.curve.steepest;
                let went = timed.step(from, to, self.pvt.0, &mut out);
                self.fastest = self.fastest.max(timed.curve.steepest);
                self.v = timed.velocity(to);
                self.pvt.2 = timed.passes;
                if timed.pending.is_none() {
                    (self.table, self.table_begins) = (self.pvt.1, self.next_begins);
                }
                went == Went::Ended
            }
            Some(Motion::Stream(timed, ran)) => {
                self.fastest = timed.curve.steepest;
                let went = timed.step(from, to, 1, &mut out);
                self.v = timed.velocity(to);
                let position = timed.position(to);
                *ran = self.chain.ends.partition_point(|end| *end <= position);
                self.pt.ran = *ran;
                if went == Went::Ended {
                    if self.chain.ends_at_speed() {
                        self.ending = Why::Underrun;
                    }
                    self.pt.fifos[0].clear();
                    (self.pt.over, self.pt.ran) = (self.chain.ends.len(), 0);
                }
                went == Went::Ended
            }
            Some(Motion::Slave(slave)) => match lead {
                None => false,
                Some(lead) => {
                    slave.open = None;
                    self.fastest = slave.table.curve.steepest;
                    let other = &self.follow.fifos[slave.fifo ^ 1];
                    let around = Around { other, loops: self.follow.loops, inputs };
                    let mut positions = Vec::new();
                    let outcome = slave.step(lead, &around, &mut positions);
                    out.extend(positions.into_iter().map(|position| (Fix::FAR, position)));
                    self.v = slave.velocity(lead);
                    self.slack += slave.slack;
                    self.outputs.append(&mut slave.outputs);
                    if outcome == Outcome::TimedOut {
                        self.timed_out = true;
                        self.ending = Why::TimedOut;
                    }
                    self.fastest = self.fastest.max(slave.table.curve.steepest);
                    self.open = slave.open;
                    self.unsaid = slave.unsaid;
                    (self.follow.fifo, self.follow.passes) = (slave.fifo, slave.pass);
                    for fifo in slave.emptied.drain(..) {
                        self.follow.fifos[fifo].clear();
                    }
                    outcome != Outcome::On
                }
            },
        };
        if let Some(Motion::Ramp(timed) | Motion::Pt(timed) | Motion::Pvt(timed) | Motion::Stream(timed, _)) =
            &self.motion
            && timed.open
        {
            self.open = Some("the end of a motion");
        }
        if std::mem::take(&mut self.brief) {
            self.open = Some("a move without a track");
        }
        self.fastest = self.fastest.max(std::mem::take(&mut self.head_most));
        for (when, position) in out {
            self.times.push(when);
            self.track.push(position);
        }
        if ended && self.times.last().is_some_and(|end| *end < to) {
            // It stands for the rest of the tick.
            self.times.push(to);
            self.track.extend(self.track.last().copied());
        }
        self.x = *self.track.last().expect("where it was");
        if self.track.len() == 1 {
            self.times.push(Fix::ZERO);
            self.track.push(self.x);
        }
        *self.times.last_mut().expect("two of them") = to;
        self.ended = ended || alarmed && self.halted;
        // A limit stops the path also where a move of its own follows within the tick.
        self.on_path = self.carried.is_some() || std::mem::take(&mut self.led);
        if let Some(track) = self.carried.take() {
            // That of its path.
            self.why = None;
            (self.times, self.track) = track.into_iter().unzip();
            self.x = *self.track.last().expect("where it was");
            self.open = self.path_open.then_some("the end of a path");
            self.ended = std::mem::take(&mut self.path_ended);
            self.fastest = self.path_most;
        }
        if ended {
            self.why = Some(self.ending);
            self.replans = 0;
            (self.braking, self.late, self.late_velocity) = (None, Fix::ZERO, Fix::ZERO);
            self.past = self.motion.take();
            self.v = Fix::ZERO;
        }
        self.hold();
        if !self.runs() && whole(self.name()) == self.name() {
            // It has come to where its data end.
            self.slack = self.slack.min(self.zero_slack);
        }
        // What began at this instant does not go on, either.
        self.limited |= alarmed;
        self.halted &= !alarmed;
    }
}
