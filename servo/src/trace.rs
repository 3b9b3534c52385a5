//! The trace: samples of chosen axes and laser channels at chosen ticks.
//!
//! In: the motion of every axis and the plans of laser channels, a tick at a time. Out: samples
//! into a ring. Owns: the counters of rows and ticks. Fails: a full ring loses the sample and
//! counts it; the row numbers show which.
use crate::capacity::{GeneralOutputs, TRACE_SAMPLES};
use crate::laser::{ANALOG_OUTPUTS, Action, LaserPlan, PowerTables};
use crate::units::{Axis, AxisMask, CrdMask, Pos};
use crate::view::{Sample, Traced};
use ring::Producer;

/// What is traced: axes, coordinate systems, laser channels (bit 0 the first), whether their plans
/// between the rows are too, and whether the general outputs are.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Chosen {
    pub(crate) axes: AxisMask,
    pub(crate) crds: CrdMask,
    pub(crate) lasers: u8,
    pub(crate) edges: bool,
    pub(crate) outputs: bool,
}

impl Chosen {
    const NONE: Chosen = Chosen { axes: AxisMask(0), crds: CrdMask(0), lasers: 0, edges: false, outputs: false };
}

/// Where samples go to.
pub(crate) type TraceSamples<'a> = Producer<'a, Sample, TRACE_SAMPLES>;

/// What is traced, and how far its rows are.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Trace {
    /// Ticks a row; 0 while nothing is traced.
    every: u32,
    /// Ticks until the next row.
    left: u32,
    row: u32,
    /// Ticks since row 0.
    tick: u32,
    /// Channels that are dark and were reported so.
    resting: u8,
    /// General outputs as last reported.
    levels: GeneralOutputs,
    chosen: Chosen,
    /// Armed: begins with the program.
    armed: Option<(u32, Chosen)>,
    /// Samples lost.
    pub(crate) lost: u32,
}

impl Trace {
    pub(crate) const OFF: Trace =
        Trace { every: 0, left: 0, row: 0, tick: 0, resting: 0, levels: 0, chosen: Chosen::NONE, armed: None, lost: 0 };

    /// Waits for the program.
    pub(crate) fn arm(&mut self, every: u32, chosen: Chosen) {
        *self = Trace { armed: (every != 0).then_some((every, chosen)), ..Trace::OFF };
    }

    /// Begins now: returns what row 0 is of, which is of the tick in force.
    pub(crate) fn begin(&mut self, every: u32, chosen: Chosen) -> Option<(u32, Chosen)> {
        // Samples that an ending trace has lost are still to be reported.
        let lost = if every == 0 { self.lost } else { 0 };
        *self = Trace { every, left: every, chosen, lost, ..Trace::OFF };
        (every != 0).then_some((0, chosen))
    }

    /// The program begins: row 0, if a trace was armed.
    pub(crate) fn begin_armed(&mut self) -> Option<(u32, Chosen)> {
        let (every, chosen) = self.armed?;
        self.begin(every, chosen)
    }

    /// Hands a sample over, or counts it as lost.
    #[inline]
    pub(crate) fn put(&mut self, sample: Sample, samples: &mut TraceSamples) {
        if samples.push(sample).is_err() {
            self.lost = self.lost.saturating_add(1);
        }
    }

    /// What a channel's outputs carry when the trace begins; the trains before it are not known, so
    /// they begin anew.
    pub(crate) fn record_carried(&mut self, channel: u8, carried: [Action; 3], samples: &mut TraceSamples) {
        for action in carried {
            self.put(Sample { row: 0, of: Traced::Action { channel, at: 0, action } }, samples);
        }
    }

    /// What the planned position of an axis is called when the trace begins.
    pub(crate) fn record_zero(&mut self, axis: Axis, zero: Pos, samples: &mut TraceSamples) {
        if zero.0 != 0 {
            self.put(Sample { row: 0, of: Traced::Zero { axis, by: zero } }, samples);
        }
    }

    /// It is called so much more from the next row on.
    pub(crate) fn record_name(&mut self, axis: Axis, by: Pos, samples: &mut TraceSamples) {
        if by.0 != 0 && self.every != 0 && self.chosen.axes.has(axis) {
            self.put(Sample { row: self.tick.wrapping_add(1), of: Traced::Zero { axis, by } }, samples);
        }
    }

    /// The general outputs when the trace begins.
    pub(crate) fn record_outputs_carried(&mut self, levels: GeneralOutputs, samples: &mut TraceSamples) {
        if self.chosen.outputs {
            self.levels = levels;
            self.put(Sample { row: 0, of: Traced::Outputs { at: 0, levels } }, samples);
        }
    }

    /// The general outputs from `at` ns after the next tick on.
    #[inline]
    pub(crate) fn record_outputs(&mut self, at: u32, levels: GeneralOutputs, samples: &mut TraceSamples) {
        if self.chosen.outputs && levels != self.levels && self.every != 0 {
            self.levels = levels;
            self.put(Sample { row: self.tick.wrapping_add(1), of: Traced::Outputs { at, levels } }, samples);
        }
    }

    /// The analog outputs when the trace begins.
    pub(crate) fn record_analog_carried(&mut self, tables: &PowerTables, samples: &mut TraceSamples) {
        if self.chosen.outputs {
            for channel in 0..ANALOG_OUTPUTS as u8 {
                let value = tables.analog(channel.into());
                if value != 0 {
                    self.put(Sample { row: 0, of: Traced::Analog { at: 0, channel, value } }, samples);
                }
            }
        }
    }

    /// An analog output from `at` ns after the next tick on.
    pub(crate) fn record_analog(&mut self, at: u32, channel: u8, value: i16, samples: &mut TraceSamples) {
        if self.chosen.outputs && self.every != 0 {
            self.put(Sample { row: self.tick.wrapping_add(1), of: Traced::Analog { at, channel, value } }, samples);
        }
    }

    /// From the tick that was computed on, the ticks have this period.
    pub(crate) fn record_period(&mut self, ns: u32, samples: &mut TraceSamples) {
        if self.every != 0 {
            self.put(Sample { row: self.tick, of: Traced::Period { ns } }, samples);
        }
    }

    /// A channel's plan for the interval that begins with the next tick.
    #[inline]
    pub(crate) fn record(&mut self, channel: u8, plan: &LaserPlan, samples: &mut TraceSamples) {
        let is_chosen = self.every != 0 && self.chosen.edges && self.chosen.lasers >> channel & 1 == 1;
        if is_chosen && (plan.safe_state || !plan.actions().is_empty()) {
            self.record_all(channel, plan, samples);
        }
    }

    #[inline(never)]
    fn record_all(&mut self, channel: u8, plan: &LaserPlan, samples: &mut TraceSamples) {
        let (row, bit) = (self.tick.wrapping_add(1), 1 << (channel & 7));
        if !plan.safe_state {
            self.resting &= !bit;
        } else if self.resting & bit == 0 {
            self.resting |= bit;
            self.put(Sample { row, of: Traced::SafeState { channel } }, samples);
        }
        for &(at, action) in plan.actions() {
            self.put(Sample { row, of: Traced::Action { channel, at, action } }, samples);
        }
    }

    /// Whether there is one.
    #[inline]
    pub(crate) fn runs(&self) -> bool {
        self.every != 0
    }

    /// The next tick of one is computed: its row, if it has one.
    pub(crate) fn advance(&mut self) -> Option<(u32, Chosen)> {
        self.tick = self.tick.wrapping_add(1);
        self.left = self.left.wrapping_sub(1);
        if self.left != 0 {
            return None;
        }
        self.left = self.every;
        self.row = self.row.wrapping_add(1);
        Some((self.row, self.chosen))
    }
}
