//! Encoders: counts as the machine recorded them, compared with a first-order lag.
//!
//! SPEC does not define the virtual machine; its own page says that every axis follows its
//! set-point with a first-order lag of 1 ms. Recorded counts are taken as exact for slaves, but
//! must be within a count of that.
use super::super::axis::{Axis, Master, whole};
use super::super::filter::Filter;
use super::super::number::Fix;
use super::super::slave::Lead;
use super::Controller;

/// 1 ms.
const LAG_NS: f64 = 1e6;
/// Counts that a recorded encoder may be from the lag: half of one for the rounding, and some for
/// its arithmetic.
const TOLERANCE_COUNTS: f64 = 0.6;

/// See the module text.
pub struct Machine {
    pub recorded: Vec<Vec<i64>>,
    /// Of each axis from where it began, pulses: where it is, and the set-point in force since the
    /// tick before, and how far the set-points of the lag may be from there.
    shafts: Vec<[f64; 3]>,
    begin: Vec<Fix>,
    pub astray: Option<(usize, usize, f64)>,
}

impl Machine {
    pub fn new(axes: &[Box<Axis>]) -> Machine {
        Machine {
            recorded: Vec::new(),
            shafts: vec![[0.0; 3]; axes.len()],
            begin: axes.iter().map(|axis| axis.x).collect(),
            astray: None,
        }
    }
}

impl Controller {
    /// The counts of a tick that lasts `period`, before it moves anything.
    pub(super) fn encoders(&mut self, tick: usize, period: i64) {
        let share = 1.0 - (-(period as f64) / LAG_NS).exp();
        for (axis_index, axis) in self.axes.iter_mut().enumerate() {
            let machine = &mut self.machine;
            let [shaft, in_force, slack] = &mut machine.shafts[axis_index];
            if tick > 0 {
                *shaft += (*in_force - *shaft) * share;
                *slack = (*slack * (1.0 - share)).max((axis.slack + axis.late).to_f64());
                *in_force = (axis.x - machine.begin[axis_index]).to_f64();
            }
            let modelled = machine.begin[axis_index] + Fix::of_f64(*shaft);
            let count = machine.recorded.get(tick).map(|row| Fix::whole(row[axis_index]));
            if let Some(count) = count {
                let apart = (count - modelled).to_f64();
                if apart.abs() > TOLERANCE_COUNTS + *slack && machine.astray.is_none() {
                    machine.astray = Some((tick, axis_index, apart));
                }
            }
            axis.encoder = [axis.encoder[1], count.unwrap_or(whole(modelled))];
            if tick == 0 {
                axis.encoder[0] = axis.encoder[1];
            }
        }
    }

    /// Speeds of the encoders along the paths of core 1, each axis after a first-order lag.
    pub(super) fn count_speeds(&mut self, before: i64, now: i64) {
        let [now, ms] = [now, now - before].map(|ns| ns as f64 / 1e6);
        for (name, of) in self.crds.iter_mut().filter(|(name, _)| name.0 == 1) {
            let crd = name.1 as usize - 1;
            let chosen = self.light.channels.iter().any(|channel| channel.law.counts(crd));
            if chosen && of.open {
                // Standstill has the speed 0.
                self.open = Some("a laser that follows encoders, within rounding of an end of its path");
            }
            let Some(set) = of.set.as_ref().filter(|_| of.runs) else {
                self.light.around.counted[crd] = 0.0;
                continue;
            };
            let speed = |axis: &Option<usize>| {
                axis.map_or(0.0, |axis| (self.axes[axis].encoder[1] - self.axes[axis].encoder[0]).to_f64() / ms)
            };
            let speeds = set.axes.each_ref().map(speed);
            let share = if of.filter_ms > 0.0 { 1.0 - (-ms / of.filter_ms).exp() } else { 1.0 };
            of.counts |= chosen;
            // It begins at 0 with the path, or with the tick before it is first asked for.
            let goes_on = of.counts || (of.began - now).abs() < 1e-9;
            let share = if goes_on { share } else { 1.0 };
            of.counted.iter_mut().zip(speeds).for_each(|(after, speed)| *after += (speed - *after) * share);
            self.light.around.counted[crd] = of.counted.iter().map(|speed| speed * speed).sum::<f64>().sqrt();
            if chosen {
                *self.used.entry("ticks in which a laser follows encoders").or_default() += 1;
            }
        }
    }

    /// Where a master was at an instant of the tick.
    pub(super) fn position_of(
        &self,
        filter: Option<&Filter>,
        master: Master,
        at: Fix,
        before: i64,
        now: i64,
    ) -> Option<Fix> {
        let axis = &self.axes[master.axis];
        if !master.is_sampled() {
            return axis.at(at);
        }
        let [from, to] = filter.map_or(axis.encoder, |filter| filter.track);
        let (begin, end) = (Fix::ms(before), Fix::ms(now));
        Some(from + (to - from) * (at - begin).over(end - begin))
    }

    /// A master as its slave has it.
    pub(super) fn lead<'a>(
        &'a self,
        filter: Option<&'a Filter>,
        master: Master,
        tick: &'a [Fix; 2],
        at: &'a dyn Fn(Fix) -> Option<Fix>,
    ) -> Lead<'a> {
        let axis = &self.axes[master.axis];
        if master.is_sampled() {
            let zero = if master.is_counted() { axis.encoder_zero } else { axis.zero };
            let track = filter.map_or(&axis.encoder, |filter| &filter.track);
            let velocity = (track[1] - track[0]).over(tick[1] - tick[0]);
            return Lead { track, times: tick, at, velocity, zero };
        }
        Lead { track: &axis.track, times: &axis.times, at, velocity: axis.v, zero: axis.zero }
    }
}
