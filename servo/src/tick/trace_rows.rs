//! Rows of the trace.
//!
//! In: axes, coordinate systems and lasers in the present state. Out: trace samples. Owns nothing.
//! Fails: samples that a full ring refuses are counted.
use super::Tick;
use crate::trace::{Chosen, TraceSamples};
use crate::units::{Axis, Crd};
use crate::view::{AxisSpeeds, LaserView, Sample, Traced};

impl<const AXES: usize> Tick<AXES> {
    /// One row of the trace, of axes, coordinate systems and lasers in the present state.
    #[inline(never)]
    pub(crate) fn emit(&mut self, row: u32, chosen: Chosen, samples: &mut TraceSamples) {
        if row == 0 {
            self.trace.record_outputs_carried(self.general, samples);
        }
        let mut speeds = AxisSpeeds::<AXES>::NONE;
        for (index, state) in self.axes.iter().enumerate().take(self.used) {
            let Some(axis) = Axis::new(index) else { break };
            if chosen.axes.has(axis) {
                if row == 0 {
                    self.trace.record_zero(axis, state.zero(), samples);
                }
                let published = &state.published;
                let motion = if published.lead.is_some() || published.drive.is_some() {
                    let axes = |axis: Axis| Some(&self.axes.get(axis.index())?.published);
                    let crd = |crd: Crd| Some(&self.crds.get(crd)?.published);
                    speeds.motion(Some(axis), published, axes, crd, self.period)
                } else {
                    published.motion
                };
                let of = Traced::Axis { axis, pos: published.pos, motion };
                self.trace.put(Sample { row, of }, samples);
            }
        }
        for (crd, state) in Crd::all().zip(&self.crds.states) {
            if chosen.crds.has(crd) {
                self.trace.put(Sample { row, of: Traced::Crd { crd, motion: state.published.motion } }, samples);
            }
        }
        for (channel, published) in (0..).zip(self.lasers.published()) {
            if chosen.lasers >> channel & 1 == 1 {
                if row == 0 && chosen.edges {
                    let actions = self.lasers.carried(channel);
                    self.trace.record_carried(channel, actions, samples);
                }
                let LaserView { mode, switch: gate, power, khz, .. } = *published;
                let of = Traced::Laser { channel, mode, gate, power, khz };
                self.trace.put(Sample { row, of }, samples);
            }
        }
    }

    /// An analog output is set from the tick computed on.
    pub(crate) fn record_analog(
        &mut self,
        channel: u8,
        value: i16,
        tables: &crate::laser::PowerTables,
        samples: &mut TraceSamples,
    ) {
        tables.set_analog(channel, value);
        self.trace.record_analog(0, channel, value, samples);
    }
}
