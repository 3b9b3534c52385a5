//! The bytes of a trace stream as a header and rows.
//!
//! In: bytes in any portions. Out: [`Item`]s in order. Owns the decoder, the last header, and an
//! output stage for each laser, which makes edges of the channel's actions. Fails: the first error
//! is the last item; a gap is never skipped.
use crate::row::{AnalogEdge, AxisName, AxisPoint, CrdName, Header, LaserName, LaserPoint, OutputEdge, PowerUnit, Row};
use crate::{Result, TraceError};
use plant::beam::{OutputStage, SignalChange};
use protocol::trace::{self, Columns, Decoder, TraceError as Fault, TraceEvent, kind};
use servo::laser::{Action, Clock, Count, Power, PulseRate, Train};
use servo::segment::piece::Scaled;
use servo::units::Pos;

/// What a trace stream brings.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Item {
    /// A trace begins.
    Header(Header),
    /// Changes of a laser's outputs before the next row, if its edges are traced: in the order of
    /// time for each output.
    Laser {
        /// Its index among the lasers of the header.
        laser: usize,
        /// What.
        change: SignalChange,
    },
    /// Light of a laser begins or ends before the next row, if its edges are traced.
    Light {
        /// Its index among the lasers of the header.
        laser: usize,
        /// When, ns since the job's start.
        at: u64,
        /// It begins.
        on: bool,
    },
    /// A general output changed, if they are traced. It precedes the row of its tick, in the order
    /// of time.
    Output(OutputEdge),
    /// An analog output was set, in the same manner.
    Analog(AnalogEdge),
    /// Before the first row that it holds for: the position of an axis is called so much more, and
    /// the machine does not move.
    Zero {
        /// Its index among the axes of the header.
        axis: usize,
        /// By how much.
        by: Pos,
    },
    /// A row.
    Row(Row),
    /// The trace is over, after this many rows.
    End {
        /// Rows that came.
        rows: u32,
    },
}

/// See the module text.
#[derive(Default)]
pub struct Reader {
    decoder: Decoder,
    made: Made,
}

/// When ticks are: the servo tick may change between rows.
#[derive(Debug, Clone, Copy, Default)]
struct Ticks {
    /// The tick from which on the period holds, and its instant, ns.
    since: (u64, u64),
    period_ns: u64,
    /// The period before it.
    before_ns: u64,
}

impl Ticks {
    /// The instant of a tick: after the last change, or after the one before it.
    fn at(&self, tick: u64) -> u64 {
        let (since, at) = self.since;
        match tick.checked_sub(since) {
            Some(ticks) => at.saturating_add(ticks.saturating_mul(self.period_ns)),
            None => at.saturating_sub((since - tick).saturating_mul(self.before_ns)),
        }
    }

    /// From this tick on the period is another one.
    fn renew(&mut self, tick: u64, period_ns: u64) {
        *self = Ticks { since: (tick, self.at(tick)), period_ns, before_ns: self.period_ns };
    }
}

/// What rows and edges are made of.
struct Made {
    header: Header,
    ticks: Ticks,
    /// Of the laser timers.
    clock: Clock,
    rows: u32,
    stages: Vec<OutputStage>,
    /// Commands of light: laser, instant, on; for each laser in the order of time.
    lights: Vec<(usize, u64, bool)>,
    /// Levels of the general outputs.
    levels: u64,
}

impl Default for Made {
    fn default() -> Self {
        Made {
            header: Header::default(),
            ticks: Ticks::default(),
            clock: Clock::GHZ,
            rows: 0,
            stages: Vec::new(),
            lights: Vec::new(),
            levels: 0,
        }
    }
}

impl Reader {
    /// Waits for a header.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes bytes and hands what they bring to `sink`; an error of the sink ends it.
    pub fn feed(&mut self, bytes: &[u8], mut sink: impl FnMut(Item) -> Result<()>) -> Result<()> {
        let mut outcome = Ok(());
        let made = &mut self.made;
        self.decoder.feed(bytes, |event| {
            if outcome.is_ok() {
                outcome = event.map_err(|fault| name(fault, made.rows)).and_then(|event| made.take(event, &mut sink));
            }
        });
        outcome
    }

    /// Whether the end has come.
    pub fn ended(&self) -> bool {
        self.decoder.ended()
    }
}

impl Made {
    fn take(&mut self, event: TraceEvent<'_>, sink: &mut impl FnMut(Item) -> Result<()>) -> Result<()> {
        match event {
            TraceEvent::Head(head, Columns { axes, lasers, crds }) => {
                self.clock = match Clock::from_mhz(head.timer_mhz) {
                    Some(clock) => clock,
                    None if lasers.is_empty() => Clock::GHZ,
                    None => return Err(TraceError::Clock { mhz: head.timer_mhz }),
                };
                let axes = axes.iter().map(|a| AxisName { core: a.core.saturating_add(1), axis: a.axis }).collect();
                let lasers: Vec<LaserName> = lasers.iter().map(|laser| LaserName(laser.channel)).collect();
                let crds = crds.iter().map(|c| CrdName { core: c.core.saturating_add(1), crd: c.crd }).collect();
                self.stages = vec![OutputStage::new(); lasers.len()];
                self.header = Header { axes, lasers, crds, period_ns: head.period_ns.into(), every: head.every };
                let period_ns = head.period_ns.into();
                self.ticks = Ticks { since: (0, 0), period_ns, before_ns: period_ns };
                (self.rows, self.levels) = (0, 0);
                self.lights.clear();
                sink(Item::Header(self.header.clone()))
            }
            TraceEvent::Row(index, samples) => {
                self.rows = index.wrapping_add(1);
                let t_ns = self.ticks.at(u64::from(index) * u64::from(self.header.every));
                for (laser, stage) in self.stages.iter_mut().enumerate() {
                    passed(|mut sink| stage.run_to(t_ns, &mut sink), laser, sink)?;
                }
                for (laser, at, on) in self.lights.extract_if(.., |(_, at, _)| *at < t_ns) {
                    sink(Item::Light { laser, at, on })?;
                }
                let axes = samples.axes.iter().map(axis_point).collect();
                let lasers = samples.lasers.iter().map(laser_point).collect();
                let speed = |sample: trace::CrdSample| velocity(sample.vel_mantissa.get(), sample.vel_exponent.get());
                let crds = samples.crds.iter().map(speed).collect();
                sink(Item::Row(Row { index, t_ns, axes, lasers, crds }))
            }
            TraceEvent::Action(action) => self.action(&action, sink),
            TraceEvent::Outputs(outputs) => {
                let t_ns = self.ticks.at(outputs.tick.get().into()) + u64::from(outputs.at.get());
                let (before, after) = (self.levels, outputs.levels.get());
                self.levels = after;
                for bit in (0..64u8).filter(|bit| (before ^ after) >> bit & 1 == 1) {
                    sink(Item::Output(OutputEdge { t_ns, output: bit + 1, level: after >> bit & 1 == 1 }))?;
                }
                Ok(())
            }
            TraceEvent::Period(period) => {
                self.ticks.renew(period.tick.get().into(), period.period_ns.get().into());
                Ok(())
            }
            TraceEvent::Zero(zero) => sink(Item::Zero { axis: zero.column.into(), by: Pos(zero.by.get()) }),
            TraceEvent::End { rows, .. } => sink(Item::End { rows }),
        }
    }

    fn action(&mut self, sent: &trace::Action, sink: &mut impl FnMut(Item) -> Result<()>) -> Result<()> {
        if sent.kind == kind::ANALOG {
            let t_ns = self.ticks.at(sent.tick.get().into()) + u64::from(sent.at.get());
            let edge = AnalogEdge { t_ns, output: sent.channel.saturating_add(1), code: sent.value.get() };
            return sink(Item::Analog(edge));
        }
        let unknown = TraceError::Damaged { after: self.rows, what: "a laser action that this client does not know" };
        let Some(laser) = self.header.lasers.iter().position(|name| name.0 == sent.channel) else {
            return Err(unknown);
        };
        let Some(stage) = self.stages.get_mut(laser) else { return Err(unknown) };
        let clock = self.clock;
        let given = |c: trace::Count| Count { whole: c.whole.get(), part: c.part.get(), of: c.of.get() };
        let train = Train { period: in_ns(given(sent.period), clock), width: in_ns(given(sent.width), clock) };
        let value = sent.value.get();
        let tick = u64::from(sent.tick.get());
        // It was planned a tick ahead; what is before cannot change any more.
        let now = self.ticks.at(tick.saturating_sub(1));
        passed(|mut sink| stage.run_to(now, &mut sink), laser, sink)?;
        let action = match sent.kind {
            kind::SAFE_STATE => {
                self.lights.retain(|(of, at, _)| *of != laser || *at < now);
                self.lights.push((laser, now, false));
                return passed(|mut sink| stage.safe_state(now, &mut sink), laser, sink);
            }
            kind::SWITCH => Action::Switch(value != 0),
            kind::LIGHT => Action::Light(train),
            kind::CHANGE => Action::Change(train),
            kind::DARK => Action::Dark { standby: train, cut: value != 0 },
            kind::VOLTS => Action::Volts(value),
            kind::RATE => {
                let Count { whole: scale, part: width, of: shift } = given(sent.width);
                let width = in_ns(Count { whole: width.into(), part: 0, of: 1 }, clock).whole as u32;
                Action::Rate(PulseRate { period: train.period, width, scale, shift })
            }
            _ => return Err(unknown),
        };
        let at = self.ticks.at(tick) + u64::from(sent.at.get());
        match action {
            Action::Light(_) => self.lights.push((laser, at, true)),
            Action::Dark { .. } => self.lights.push((laser, at, false)),
            _ => {}
        }
        stage.push(at, action);
        Ok(())
    }
}

/// A time in counts of a clock as one in ns, exact, or to 2⁻³² ns. The machine's edges fall on its
/// own counts; those made of this fall on ns, within a count of them.
fn in_ns(count: Count, clock: Clock) -> Count {
    if clock == Clock::GHZ {
        return count;
    }
    let of = if count.of == 0 { 1 << 32 } else { u128::from(count.of) };
    let ns = (u128::from(count.whole) * of + u128::from(count.part)) * 1000;
    let over = of * u128::from(clock.mhz());
    let (whole, rest) = (ns / over, ns % over);
    // Nearest 2⁻³²; what is rounded up to a whole is one more.
    let part = ((rest << 32) + over / 2) / over;
    Count { whole: u64::try_from(whole + (part >> 32)).unwrap_or(u64::MAX), part: part as u32, of: 0 }
}

/// Hands a stage's changes on until one is refused.
fn passed(
    run: impl FnOnce(&mut dyn FnMut(SignalChange)),
    laser: usize,
    sink: &mut impl FnMut(Item) -> Result<()>,
) -> Result<()> {
    let mut outcome = Ok(());
    run(&mut |change| {
        if outcome.is_ok() {
            outcome = sink(Item::Laser { laser, change });
        }
    });
    outcome
}

fn axis_point(sample: trace::Sample) -> AxisPoint {
    AxisPoint { pos: Pos(sample.pos.get()), vel: velocity(sample.vel_mantissa.get(), sample.vel_exponent.get()) }
}

fn velocity(m: i64, e: i16) -> Scaled {
    Scaled { m, e }
}

fn laser_point(sample: trace::LaserSample) -> LaserPoint {
    let scaled = |m: i64| Scaled { m, e: Power::FRAC_BITS as i16 };
    let unit = match sample.mode {
        1 => PowerUnit::Kilohertz,
        2 => PowerUnit::Volt,
        _ => PowerUnit::Percent,
    };
    LaserPoint { gate: sample.gate != 0, power: scaled(sample.power.get()), unit, frequency: scaled(sample.khz.get()) }
}

fn name(fault: Fault, after: u32) -> TraceError {
    match fault {
        Fault::BadFrame => TraceError::Damaged { after, what: "a frame's checksum is wrong" },
        Fault::Unexpected => TraceError::Damaged { after, what: "a frame fits no trace" },
        Fault::Version(theirs) => TraceError::Version { theirs },
        Fault::Missing { expected, came } => TraceError::Gap { expected, came },
        Fault::Lost(rows) => TraceError::Lost(rows),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows, outputs and actions are at the ticks of the period that held then.
    #[test]
    fn the_tick_may_change_between_rows() {
        let mut encoder = trace::Encoder::new();
        let axes = [trace::AxisId { core: 0, axis: 1 }];
        let head = trace::TraceHead { schema: 1, period_ns: 250_000, every: 2, timer_mhz: 1000 };
        encoder.head(&head, &trace::Ids { axes: &axes, lasers: &[], crds: &[] }).unwrap();
        let (mut bytes, mut out) = (Vec::new(), [0; 2000]);
        let mut drain = |encoder: &mut trace::Encoder| {
            let length = encoder.take(&mut out);
            bytes.extend_from_slice(&out[..length]);
        };
        drain(&mut encoder);
        let samples = [trace::Sample::default()];
        let outputs =
            |tick: u32, levels: u64| trace::Outputs { tick: tick.into(), at: 7.into(), levels: levels.into() };
        let period = |tick: u32, ns: u32| trace::Period { tick: tick.into(), period_ns: ns.into() };
        for row in 0..6u32 {
            encoder.row(row, &trace::Samples { axes: &samples, lasers: &[], crds: &[] }).unwrap();
            match row {
                // Between the rows at ticks 2 and 4.
                1 => {
                    encoder.outputs(&outputs(3, 1)).unwrap();
                    encoder.period(&period(3, 50_000)).unwrap();
                }
                3 => encoder.period(&period(6, 1_000_000)).unwrap(),
                4 => encoder.outputs(&outputs(9, 0)).unwrap(),
                _ => {}
            }
        }
        drain(&mut encoder);
        let (mut rows, mut edges) = (Vec::new(), Vec::new());
        let mut reader = Reader::new();
        reader
            .feed(&bytes, |item| {
                match item {
                    Item::Row(row) => rows.push(row.t_ns),
                    Item::Output(edge) => edges.push(edge.t_ns),
                    _ => {}
                }
                Ok(())
            })
            .unwrap();
        assert_eq!(rows, [0, 500_000, 800_000, 900_000, 2_900_000, 4_900_000]);
        assert_eq!(edges, [750_007, 3_900_007]);
    }

    #[test]
    fn counts_of_any_clock_are_ns_to_the_nearest_part() {
        let mhz = |mhz| Clock::from_mhz(mhz).unwrap();
        let count = |whole, part, of| Count { whole, part, of };
        assert_eq!(in_ns(count(7, 1, 3), Clock::GHZ), count(7, 1, 3));
        // 24000 counts of 240 MHz are 100 us; a third of a count is 25/18 ns.
        assert_eq!(in_ns(count(24_000, 0, 1), mhz(240)), count(100_000, 0, 0));
        let nearest = |numerator: u64, denominator: u64| ((numerator << 32) + denominator / 2) / denominator;
        assert_eq!(in_ns(count(0, 1, 3), mhz(240)), count(1, nearest(7, 18) as u32, 0));
        assert_eq!(in_ns(count(1, 1 << 31, 0), mhz(240)), count(6, nearest(1, 4) as u32, 0));
        assert_eq!(in_ns(count(0, u32::MAX, 0), mhz(999)).whole, 1, "less than 2^-33 ns below 1.001");
        assert_eq!(in_ns(count(u64::MAX, 0, 1), mhz(240)).whole, u64::MAX, "beyond what a count holds: the longest");
    }
}
