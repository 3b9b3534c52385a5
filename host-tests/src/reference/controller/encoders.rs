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
const APART: f64 = 0.6;

/// See the module text.
pub struct Machine {
    pub recorded: Vec<Vec<i64>>,
    /// Of each axis from where it began, pulses: where it is, and the set-point in force since the
    /// tick before.
    shafts: Vec<[f64; 2]>,
    begin: Vec<Fix>,
    pub astray: Option<(usize, usize, f64)>,
}

impl Machine {
    pub fn new(axes: &[Box<Axis>]) -> Machine {
        Machine {
            recorded: Vec::new(),
            shafts: vec![[0.0; 2]; axes.len()],
            begin: axes.iter().map(|axis| axis.x).collect(),
            astray: None,
        }
    }
}

impl Controller {
    /// The counts of a tick that lasts `period`, before it moves anything.
    pub(super) fn encoders(&mut self, tick: usize, period: i64) {
        let share = 1.0 - (-(period as f64) / LAG_NS).exp();
        for (place, axis) in self.axes.iter_mut().enumerate() {
            let machine = &mut self.machine;
            let [shaft, in_force] = &mut machine.shafts[place];
            if tick > 0 {
                *shaft += (*in_force - *shaft) * share;
                *in_force = (axis.x - machine.begin[place]).to_f64();
            }
            let modelled = machine.begin[place] + Fix::of_f64(*shaft);
            let count = machine.recorded.get(tick).map(|row| Fix::whole(row[place]));
            if let Some(count) = count {
                let apart = (count - modelled).to_f64();
                if apart.abs() > APART && machine.astray.is_none() {
                    machine.astray = Some((tick, place, apart));
                }
            }
            axis.encoder = [axis.encoder[1], count.unwrap_or(whole(modelled))];
            if tick == 0 {
                axis.encoder[0] = axis.encoder[1];
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
