//! The trace: samples of the tick become rows of [`protocol::trace`].
//!
//! In: samples, the announcement of a trace and of its end. Out: wire bytes. Owns: the row being
//! gathered and the encoder.
//! Fails: samples that the tick lost because its ring was full are counted and reported in the
//! stream's last frame. A row is never invented.
use crate::bounded_vec::collect;
use crate::configuration::{Configuration, ones};
use crate::shadow::executed;
use heapless::Vec;
use protocol::trace::{
    self, AxisId, CrdId, CrdSample, Encoder, Full, Ids, LaserId, LaserSample, Samples, TraceHead, kind,
};
use ring::Consumer;
use servo::laser::{Action, CHANNELS, Count, PulseRate, Train};
use servo::units::{AxisMask, Crd, CrdMask};
use servo::view::{Sample, Traced, View};

/// The columns of a trace.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TraceColumns {
    /// Axes.
    pub axes: AxisMask,
    /// Laser channels, bit 0 the first.
    pub lasers: u8,
    /// Coordinate systems.
    pub crds: CrdMask,
}

impl TraceColumns {
    const NONE: TraceColumns = TraceColumns { axes: AxisMask(0), lasers: 0, crds: CrdMask(0) };

    fn axes(self) -> usize {
        self.axes.0.count_ones() as usize
    }

    fn lasers(self) -> usize {
        self.lasers.count_ones() as usize
    }

    fn crds(self) -> usize {
        self.crds.0.count_ones() as usize
    }
}

/// State of a trace.
#[derive(Debug, Clone, Copy, PartialEq)]
enum TraceState {
    /// None.
    Off,
    /// Announced; its row 0 has not come.
    Armed,
    /// Its head is due.
    Head,
    /// Rows come.
    Rows,
}

servo::state! {
    /// The trace.
    pub struct TraceOut<const AXES: usize> {
        encoder: Encoder = Encoder::new(),
        state: TraceState = TraceState::Off,
        every: u32 = 0,
        columns: TraceColumns = TraceColumns::NONE,
        /// Entry that ends it.
        ending: Option<u32> = None,
        /// It goes over the link: in messages, and not to the caller of [`TraceOut::bytes`].
        over_link: bool = false,
        /// The encoder has no room: a message's worth has gathered.
        full: bool = false,
        row: u32 = 0,
        axes: [trace::Sample; AXES] = [trace::Sample::default(); AXES],
        lasers: [LaserSample; CHANNELS] = [LaserSample::default(); CHANNELS],
        crds: [CrdSample; Crd::MAX] = [CrdSample::default(); Crd::MAX],
        gathered: usize = 0,
        sent: u32 = 0,
        next: u32 = 0,
        lost: u32 = 0,
        samples_lost: u32 = 0,
    }
    /// No trace.
    pub fn new();
}

impl<const AXES: usize> TraceOut<AXES> {
    /// Entry `seq` begins (`every` ≥ 1) or ends a trace. One that runs is left without its end.
    pub fn announce(&mut self, every: u32, columns: TraceColumns, over_link: bool, seq: u32) {
        if every == 0 {
            self.ending = Some(seq);
            return;
        }
        if self.over_link || over_link {
            // Bytes of the trace before are not for this reader.
            self.encoder = Encoder::new();
        }
        self.state = TraceState::Armed;
        (self.over_link, self.full) = (over_link, false);
        (self.every, self.columns, self.ending) = (every, columns, None);
        (self.gathered, self.sent, self.next, self.lost, self.samples_lost) = (0, 0, 0, 0, 0);
    }

    /// A new session: a trace of the old one over the link is over.
    pub fn abandon(&mut self) {
        if self.over_link {
            self.encoder = Encoder::new();
            self.state = TraceState::Off;
            (self.ending, self.over_link, self.full) = (None, false, false);
        }
    }

    fn count(&self) -> usize {
        self.columns.axes() + self.columns.crds() + self.columns.lasers()
    }

    /// Turns samples into rows as far as the encoder has room.
    pub fn drain<const N: usize>(
        &mut self,
        samples: &mut Consumer<Sample, N>,
        view: &View<AXES>,
        configuration: &Configuration,
    ) {
        if matches!(self.state, TraceState::Head | TraceState::Rows) {
            self.samples_lost = self.samples_lost.max(view.trace_lost);
        }
        while let Some(&sample) = samples.peek() {
            if !self.take(&sample, view, configuration) {
                self.full = true;
                return;
            }
            samples.skip();
        }
        if self.ending.is_some_and(|seq| executed(view, seq)) {
            self.full = !self.finish();
            if !self.full {
                self.state = TraceState::Off;
                self.ending = None;
            }
        }
    }

    /// False if there is no room for it now.
    fn take(&mut self, sample: &Sample, view: &View<AXES>, configuration: &Configuration) -> bool {
        if self.state == TraceState::Armed && sample.row == 0 {
            self.state = TraceState::Head;
        }
        match self.state {
            TraceState::Off | TraceState::Armed => return true,
            TraceState::Head => {
                if !self.head(view, configuration) {
                    return false;
                }
                // The view may still show the losses of the trace before.
                self.samples_lost = 0;
                self.state = TraceState::Rows;
            }
            TraceState::Rows => {}
        }
        if self.gathered > 0 && sample.row != self.row {
            // A part of the row was lost, so the row is.
            self.gathered = 0;
        }
        // Within a row, samples come in the order of axes, coordinate systems and channels. A
        // missing one makes the row invalid.
        let column = match sample.of {
            Traced::Axis { axis, .. } => (self.columns.axes.0 & ones(axis.index())).count_ones() as usize,
            Traced::Crd { crd, .. } => {
                let before = self.columns.crds.0 & ones(crd.index()) as u8;
                self.columns.axes() + before.count_ones() as usize
            }
            Traced::Laser { channel, .. } => {
                let before = self.columns.lasers & ones(channel.into()) as u8;
                self.columns.axes() + self.columns.crds() + before.count_ones() as usize
            }
            Traced::Action { channel, at, action } => return self.action(sample.row, channel, at, action).is_ok(),
            Traced::SafeState { channel } => return self.safe_state(sample.row, channel).is_ok(),
            Traced::Zero { axis, by } => {
                let column = (self.columns.axes.0 & ones(axis.index())).count_ones() as u8;
                let zero = trace::Zero { tick: sample.row.into(), column, by: by.0.into() };
                return self.encoder.zero(&zero).is_ok();
            }
            Traced::Period { ns } => {
                let period = trace::Period { tick: sample.row.into(), period_ns: ns.into() };
                return self.encoder.period(&period).is_ok();
            }
            Traced::Outputs { at, levels } => {
                #[allow(clippy::unnecessary_cast, reason = "a small board has fewer bits")]
                let levels = (levels as u64).into();
                let outputs = trace::Outputs { tick: sample.row.into(), at: at.into(), levels };
                return self.encoder.outputs(&outputs).is_ok();
            }
            Traced::Analog { at, channel, value } => {
                let (tick, at, value) = (sample.row.into(), at.into(), value.into());
                let set = trace::Action { tick, at, channel, kind: kind::ANALOG, value, ..trace::Action::default() };
                return self.encoder.action(&set).is_ok();
            }
        };
        if column != self.gathered {
            self.gathered = 0;
            self.row = sample.row;
            return true;
        }
        match sample.of {
            Traced::Axis { pos, motion, .. } => {
                let velocity = motion.velocity();
                if let Some(to) = self.axes.get_mut(column) {
                    let (vel_mantissa, vel_exponent) = (velocity.m.into(), velocity.e.into());
                    *to = trace::Sample { pos: pos.0.into(), vel_mantissa, vel_exponent };
                }
            }
            Traced::Laser { mode, gate, power, khz, .. } => {
                if let Some(to) = self.lasers.get_mut(column.wrapping_sub(self.columns.axes() + self.columns.crds())) {
                    let (power, khz) = (power.raw().into(), khz.raw().into());
                    *to = LaserSample { mode: mode as u8, gate: gate.into(), power, khz };
                }
            }
            Traced::Crd { motion, .. } => {
                let velocity = motion.velocity();
                if let Some(to) = self.crds.get_mut(column.wrapping_sub(self.columns.axes())) {
                    *to = CrdSample { vel_mantissa: velocity.m.into(), vel_exponent: velocity.e.into() };
                }
            }
            // Those have been written above.
            _ => {}
        }
        self.row = sample.row;
        if column + 1 < self.count() {
            self.gathered = column + 1;
            return true;
        }
        let axes = self.axes.get(..self.columns.axes()).unwrap_or(&[]);
        let lasers = self.lasers.get(..self.columns.lasers()).unwrap_or(&[]);
        let crds = self.crds.get(..self.columns.crds()).unwrap_or(&[]);
        if self.encoder.row(sample.row, &Samples { axes, lasers, crds }).is_err() {
            return false;
        }
        self.gathered = 0;
        self.lost = self.lost.saturating_add(sample.row.wrapping_sub(self.next));
        self.next = sample.row.wrapping_add(1);
        self.sent = self.sent.wrapping_add(1);
        true
    }

    fn safe_state(&mut self, tick: u32, channel: u8) -> Result<(), Full> {
        let action = trace::Action { tick: tick.into(), channel, kind: kind::SAFE_STATE, ..trace::Action::default() };
        self.encoder.action(&action)
    }

    fn action(&mut self, tick: u32, channel: u8, at: u32, action: Action) -> Result<(), Full> {
        let count = |Count { whole, part, of }| trace::Count { whole: whole.into(), part: part.into(), of: of.into() };
        let (kind, value, train) = match action {
            Action::Switch(on) => (kind::SWITCH, on.into(), Train::NONE),
            Action::Light(train) => (kind::LIGHT, 0, train),
            Action::Change(train) => (kind::CHANGE, 0, train),
            Action::Dark { standby, cut } => (kind::DARK, cut.into(), standby),
            Action::Volts(code) => (kind::VOLTS, code, Train::NONE),
            Action::Rate(PulseRate { period, width, scale, shift }) => {
                (kind::RATE, 0, Train { period, width: Count { whole: scale, part: width, of: shift } })
            }
        };
        let (period, width) = (count(train.period), count(train.width));
        let (tick, at, value) = (tick.into(), at.into(), value.into());
        self.encoder.action(&trace::Action { tick, at, channel, kind, value, period, width })
    }

    fn head(&mut self, view: &View<AXES>, configuration: &Configuration) -> bool {
        let per_core = configuration.profile.axes_per_core.max(1);
        let axes = (0..AXES as u8).filter(|axis| self.columns.axes.0 >> axis & 1 == 1);
        let axes: Vec<_, AXES> = collect(axes.map(|axis| AxisId { core: axis / per_core, axis: axis % per_core + 1 }));
        let lasers = (0..CHANNELS as u8).filter(|channel| self.columns.lasers >> channel & 1 == 1);
        let lasers: Vec<_, CHANNELS> = collect(lasers.map(|channel| LaserId { channel }));
        let per_core = configuration.profile.crds_per_core.max(1);
        let crds = self.columns.crds.crds().map(|crd| crd.index() as u8);
        let crds: Vec<_, { Crd::MAX }> =
            collect(crds.map(|crd| CrdId { core: crd / per_core, crd: crd % per_core + 1 }));
        let (period_ns, timer_mhz) = (view.period.0 as u32, view.timer_mhz);
        let head = TraceHead { schema: protocol::SCHEMA, period_ns, every: self.every, timer_mhz };
        self.encoder.head(&head, &Ids { axes: &axes, lasers: &lasers, crds: &crds }).is_ok()
    }

    fn finish(&mut self) -> bool {
        if self.state != TraceState::Rows {
            // It was ended before its first row.
            return true;
        }
        let missing = self.samples_lost.div_ceil((self.count() as u32).max(1));
        let lost = self.lost.max(missing);
        self.encoder.end(self.sent.wrapping_add(self.lost), lost).is_ok()
    }

    /// Bytes of the trace's own stream.
    pub fn bytes(&mut self, out: &mut [u8]) -> usize {
        if self.over_link { 0 } else { self.encoder.take(out) }
    }

    /// Whether bytes for the link are due: as many as a frame holds, or the last ones.
    pub fn is_due(&self) -> bool {
        self.over_link && (self.full || self.state == TraceState::Off && !self.encoder.is_empty())
    }

    /// Whether any bytes for the link have gathered.
    pub fn has_link_bytes(&self) -> bool {
        self.over_link && !self.encoder.is_empty()
    }

    /// Bytes for the link.
    pub fn link_bytes(&mut self, out: &mut [u8]) -> usize {
        self.full = false;
        if self.over_link { self.encoder.take(out) } else { 0 }
    }

    /// Whether a trace is announced or runs.
    pub fn is_on(&self) -> bool {
        self.state != TraceState::Off
    }
}
