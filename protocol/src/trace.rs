//! The trace's own byte stream: one way, no acknowledgements.
//!
//! In ([`Encoder`]): a head, rows, an end; out: wire bytes. In ([`Decoder`]): bytes in any
//! portions; out: [`TraceEvent`]s.
//! Fails: a missing row or a bad frame is a [`TraceError`]; no gap goes unreported.
//! Frames are COBS with a CRC-32 like those of the link; their first byte differs.
//!
//! A row carries positions in units of 2^-22 pulse, velocities as mantissa and exponent, and powers
//! and frequencies of lasers in units of 2^-44, exactly as the servo holds them. The reader
//! converts them. Between rows come, on request, the [`Action`]s of a laser channel, and the levels
//! of the general [`Outputs`] when they change. A [`Period`] reports a change of the tick period, a
//! [`Zero`] another name of a position.

use crate::command::{Wire, wire_structs};
use crate::deframe::{Deframer, Outcome};
use crate::frame::{CRC_BYTES, seal, unseal, wire_length};
use zerocopy::little_endian::{I16, I64, U16, U32, U64};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// Version of this stream.
pub const VERSION: u8 = 5;
/// Most axes in a trace.
pub const MAX_AXES: usize = 64;
/// Most laser channels in a trace.
pub const MAX_LASERS: usize = 8;
/// Most coordinate systems in a trace.
pub const MAX_CRDS: usize = 8;
/// Longest body of a frame: one row of everything, or several shorter ones.
pub const MAX_BODY: usize = 1384;
const MAX_DECODED: usize = MAX_BODY + CRC_BYTES;
const MAX_WIRE: usize = wire_length(MAX_DECODED);

const HEAD: u8 = 0x81;
const ROWS: u8 = 0x82;
const END: u8 = 0x83;
/// In a frame of rows: the kind of the next item.
const ROW: u8 = 1;
const ACTION: u8 = 2;
const OUTPUTS: u8 = 3;
const PERIOD: u8 = 4;
const ZERO: u8 = 5;

wire_structs! {
    /// The first frame, after its kind: tick period in ns, ticks from row to row, clock of the
    /// laser timers, numbers of axes, lasers and coordinate systems. The axes follow, then the
    /// lasers, then the coordinate systems.
    HeadLayout { version: u8, schema: U32, period_ns: U32, every: U32, timer_mhz: U16, axes: u8, lasers: u8, crds: u8 }
    /// One axis of the trace: core from 0, axis from 1.
    AxisId { core: u8, axis: u8 }
    /// One laser channel of the trace, from 0.
    LaserId { channel: u8 }
    /// One coordinate system of the trace: core from 0, number of the core's from 1.
    CrdId { core: u8, crd: u8 }
    /// Before the samples of a row: its number, from 0 without gaps.
    RowLayout { what: u8, row: U32 }
    /// One axis in a row: position in 2^-22 pulse; velocity is `vel_mantissa * 2^-vel_exponent`
    /// pulse/ms.
    Sample { pos: I64, vel_mantissa: I64, vel_exponent: I16 }
    /// One laser channel in one row: power mode (0 duty, 1 frequency, 2 analog, 3 duty with open
    /// switch), level of the switch output, power in 2^-44 of the mode's unit, frequency in 2^-44
    /// kHz.
    LaserSample { mode: u8, gate: u8, power: I64, khz: I64 }
    /// One coordinate system in one row: speed along its path, `vel_mantissa * 2^-vel_exponent`
    /// pulse/ms.
    CrdSample { vel_mantissa: I64, vel_exponent: I16 }
    /// General outputs, bit 0 the first: their levels from `at` ns after the tick `tick` (from row
    /// 0 on).
    Outputs { tick: U32, at: U32, levels: U64 }
    /// The tick period from the tick `tick` (from row 0) on, ns.
    Period { tick: U32, period_ns: U32 }
    /// From the next row on the position of an axis, the column `column` from 0, is called `by`
    /// more, in 2^-22 pulse, and the machine does not move: ZeroPos, SetPrfPos, Reset. Those
    /// before row 0 say what it is called since power-on. `tick` is the one that it holds from.
    Zero { tick: U32, column: u8, by: I64 }
    /// A number of counts of the laser timers: whole + part/of, where 0 stands for 2^32.
    Count { whole: U64, part: U32, of: U32 }
    /// An action of a laser channel for the tick `tick` (from row 0 on), `at` ns after it. `kind`:
    /// see [`kind`].
    Action { tick: U32, at: U32, channel: u8, kind: u8, value: I16, period: Count, width: Count }
    /// The last frame, after its kind: rows sent, rows that could not be sent.
    EndLayout { rows: U32, lost: U32 }
}

/// What an [`Action`] is; trains are its `period` and `width`.
pub mod kind {
    /// Everything to the safe state at once, that is at the tick before `tick`; earlier actions are
    /// void.
    pub const SAFE_STATE: u8 = 0;
    /// The switch output goes to `value`.
    pub const SWITCH: u8 = 1;
    /// Light begins with this train.
    pub const LIGHT: u8 = 2;
    /// The train continues as this one.
    pub const CHANGE: u8 = 3;
    /// Light ends, standby is this train; `value` 1 cuts the last pulse.
    pub const DARK: u8 = 4;
    /// The analog output goes to `value`.
    pub const VOLTS: u8 = 5;
    /// Pulses of a rate continue in phase (`servo::laser::Rate`): period as `period`; `width` holds
    /// its scale in `whole`, the width of a pulse in counts in `part`, its shift in `of`.
    pub const RATE: u8 = 6;
    /// Of no laser: the analog output `channel`, from 0, is set to `value`.
    pub const ANALOG: u8 = 7;
}

const SAMPLES_MAX: usize =
    MAX_AXES * size_of::<Sample>() + MAX_LASERS * size_of::<LaserSample>() + MAX_CRDS * size_of::<CrdSample>();
const _: () = assert!(1 + size_of::<RowLayout>() + SAMPLES_MAX <= MAX_BODY);
const IDS_MAX: usize = (MAX_AXES + MAX_CRDS) * size_of::<AxisId>() + MAX_LASERS;
const _: () = assert!(1 + size_of::<HeadLayout>() + IDS_MAX <= MAX_BODY);

/// The columns of a trace, or one row of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Columns<A, L, C> {
    /// Of axes.
    pub axes: A,
    /// Of laser channels.
    pub lasers: L,
    /// Of coordinate systems.
    pub crds: C,
}

/// The ids of the columns.
pub type Ids<'a> = Columns<&'a [AxisId], &'a [LaserId], &'a [CrdId]>;
/// A row.
pub type Samples<'a> = Columns<&'a [Sample], &'a [LaserSample], &'a [CrdSample]>;

impl<'a, A, L, C> Columns<&'a [A], &'a [L], &'a [C]> {
    /// Limited to what a trace can have.
    fn limited(&self) -> Self {
        Columns {
            axes: self.axes.get(..MAX_AXES).unwrap_or(self.axes),
            lasers: self.lasers.get(..MAX_LASERS).unwrap_or(self.lasers),
            crds: self.crds.get(..MAX_CRDS).unwrap_or(self.crds),
        }
    }
}

/// Head of a trace.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TraceHead {
    /// Schema of the sender.
    pub schema: u32,
    /// Tick period, ns.
    pub period_ns: u32,
    /// Ticks from row to row.
    pub every: u32,
    /// Clock of the laser timers, MHz.
    pub timer_mhz: u16,
}

/// The frame before has not been taken yet: call [`Encoder::take`] and try again. Nothing was
/// added.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Full;

/// Makes frames of rows. Owns one frame being filled and one being sent.
#[derive(Debug, Clone)]
pub struct Encoder {
    body: [u8; MAX_BODY],
    len: usize,
    wire: [u8; MAX_WIRE],
    wire_at: usize,
    wire_len: usize,
}

impl Default for Encoder {
    fn default() -> Self {
        Self::new()
    }
}

impl Encoder {
    /// Empty.
    pub const fn new() -> Self {
        Encoder { body: [0; MAX_BODY], len: 0, wire: [0; MAX_WIRE], wire_at: 0, wire_len: 0 }
    }

    /// Begins a trace of at most [`MAX_AXES`] axes, [`MAX_LASERS`] laser channels and [`MAX_CRDS`]
    /// coordinate systems (more are left out).
    ///
    /// # Errors
    /// [`Full`].
    pub fn head(&mut self, head: &TraceHead, ids: &Ids<'_>) -> Result<(), Full> {
        let Ids { axes, lasers, crds } = ids.limited();
        let layout = HeadLayout {
            version: VERSION,
            schema: head.schema.into(),
            period_ns: head.period_ns.into(),
            every: head.every.into(),
            timer_mhz: head.timer_mhz.into(),
            axes: axes.len() as u8,
            lasers: lasers.len() as u8,
            crds: crds.len() as u8,
        };
        self.alone(&[&[HEAD], layout.as_bytes(), axes.as_bytes(), lasers.as_bytes(), crds.as_bytes()])
    }

    /// Adds a row, with one sample for each column of the head in its order.
    ///
    /// # Errors
    /// [`Full`].
    pub fn row(&mut self, row: u32, samples: &Samples<'_>) -> Result<(), Full> {
        let Samples { axes, lasers, crds } = samples.limited();
        let head = RowLayout { what: ROW, row: row.into() };
        self.add(&[head.as_bytes(), axes.as_bytes(), lasers.as_bytes(), crds.as_bytes()])
    }

    /// Adds an action of a laser channel, before the row of its tick.
    ///
    /// # Errors
    /// [`Full`].
    pub fn action(&mut self, action: &Action) -> Result<(), Full> {
        self.add(&[&[ACTION], action.as_bytes()])
    }

    /// Adds levels of the general outputs, before the row of their tick.
    ///
    /// # Errors
    /// [`Full`].
    pub fn outputs(&mut self, outputs: &Outputs) -> Result<(), Full> {
        self.add(&[&[OUTPUTS], outputs.as_bytes()])
    }

    /// Adds a change of the tick period, after the row of the tick from which on it holds.
    ///
    /// # Errors
    /// [`Full`].
    pub fn period(&mut self, period: &Period) -> Result<(), Full> {
        self.add(&[&[PERIOD], period.as_bytes()])
    }

    /// Adds another name of an axis's position, before the first row that it holds for.
    ///
    /// # Errors
    /// [`Full`].
    pub fn zero(&mut self, zero: &Zero) -> Result<(), Full> {
        self.add(&[&[ZERO], zero.as_bytes()])
    }

    fn add(&mut self, parts: &[&[u8]]) -> Result<(), Full> {
        let size = parts.iter().fold(0usize, |sum, part| sum.saturating_add(part.len()));
        if self.len.saturating_add(size) > MAX_BODY {
            self.seal_rows()?;
        }
        if self.len == 0 {
            self.append(&[ROWS]);
        }
        for part in parts {
            self.append(part);
        }
        Ok(())
    }

    /// Ends the trace.
    ///
    /// # Errors
    /// [`Full`].
    pub fn end(&mut self, rows: u32, lost: u32) -> Result<(), Full> {
        let layout = EndLayout { rows: rows.into(), lost: lost.into() };
        self.alone(&[&[END], layout.as_bytes()])
    }

    /// Writes the bytes to be sent into `out`, those of a frame that is not yet full included.
    /// Returns the bytes written.
    pub fn take(&mut self, out: &mut [u8]) -> usize {
        let mut written = 0usize;
        loop {
            let waiting = self.wire.get(self.wire_at..self.wire_len).unwrap_or(&[]);
            let room = out.get_mut(written..).unwrap_or(&mut []);
            let count = waiting.len().min(room.len());
            for (slot, &byte) in room.iter_mut().zip(waiting) {
                *slot = byte;
            }
            self.wire_at = self.wire_at.saturating_add(count);
            written = written.saturating_add(count);
            if self.wire_at < self.wire_len || self.len == 0 || self.seal_rows().is_err() {
                return written;
            }
        }
    }

    /// Whether all has been taken.
    pub fn is_empty(&self) -> bool {
        self.len == 0 && self.wire_at == self.wire_len
    }

    fn append(&mut self, bytes: &[u8]) {
        if let Some(room) = self.body.get_mut(self.len..self.len.saturating_add(bytes.len())) {
            for (slot, &byte) in room.iter_mut().zip(bytes) {
                *slot = byte;
            }
            self.len = self.len.saturating_add(bytes.len());
        }
    }

    /// A frame of its own, after the rows collected so far.
    fn alone(&mut self, parts: &[&[u8]]) -> Result<(), Full> {
        if self.len > 0 {
            self.seal_rows()?;
        }
        if self.wire_at < self.wire_len {
            return Err(Full);
        }
        self.wire_at = 0;
        self.wire_len = seal(parts, &mut self.wire).unwrap_or(0);
        Ok(())
    }

    fn seal_rows(&mut self) -> Result<(), Full> {
        if self.wire_at < self.wire_len {
            return Err(Full);
        }
        self.wire_at = 0;
        self.wire_len = seal(&[self.body.get(..self.len).unwrap_or(&[])], &mut self.wire).unwrap_or(0);
        self.len = 0;
        Ok(())
    }
}

/// Items of a trace.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TraceEvent<'a> {
    /// It begins.
    Head(TraceHead, Lists<'a, AxisId, LaserId, CrdId>),
    /// A row and its samples, in the order of the head.
    Row(u32, Lists<'a, Sample, LaserSample, CrdSample>),
    /// An action of a laser channel.
    Action(Action),
    /// The general outputs change.
    Outputs(Outputs),
    /// The tick period changes.
    Period(Period),
    /// A position gets another name.
    Zero(Zero),
    /// It is over: rows sent, and rows that the controller could not send.
    End {
        /// Rows sent.
        rows: u32,
        /// Rows lost before sending.
        lost: u32,
    },
}

/// Errors of a trace.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TraceError {
    /// A frame was damaged: rows may be missing.
    BadFrame,
    /// A frame came before the head, or has a length or kind that fits no trace.
    Unexpected,
    /// Another version of this stream.
    Version(u8),
    /// Rows are missing.
    Missing {
        /// The row that should have come (at the end: the rows that came).
        expected: u32,
        /// The row that came (at the end: the rows that were sent).
        came: u32,
    },
    /// The controller could not send this many rows.
    Lost(u32),
}

/// Columns as they came.
pub type Lists<'a, A, L, C> = Columns<List<'a, A>, List<'a, L>, List<'a, C>>;

/// Structs of one layout, one after another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct List<'a, T> {
    bytes: &'a [u8],
    kind: core::marker::PhantomData<T>,
}

impl<'a, T: Wire> List<'a, T> {
    const fn new(bytes: &'a [u8]) -> Self {
        List { bytes, kind: core::marker::PhantomData }
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.bytes.len().checked_div(size_of::<T>()).unwrap_or(0)
    }

    /// None.
    pub fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    /// One after another.
    pub fn iter(&self) -> impl Iterator<Item = T> + use<'a, T> {
        self.bytes.chunks_exact(size_of::<T>().max(1)).filter_map(|bytes| T::read_from_bytes(bytes).ok())
    }
}

/// How many columns there are.
type Counts = Columns<usize, usize, usize>;

/// Decodes a trace.
#[derive(Debug, Clone)]
pub struct Decoder {
    deframer: Deframer<MAX_WIRE>,
    /// Numbers of columns of the head; `None` before it.
    columns: Option<Counts>,
    next_row: u32,
    ended: bool,
}

impl Default for Decoder {
    fn default() -> Self {
        Self::new()
    }
}

impl Decoder {
    /// Waits for a head.
    pub const fn new() -> Self {
        Decoder { deframer: Deframer::new(), columns: None, next_row: 0, ended: false }
    }

    /// Takes bytes in any portions and hands every event and error to `sink`, in order.
    pub fn feed(&mut self, bytes: &[u8], mut sink: impl FnMut(Result<TraceEvent<'_>, TraceError>)) {
        let mut rest = bytes;
        while !rest.is_empty() {
            let (used, outcome) = self.deframer.feed(rest);
            rest = rest.get(used..).unwrap_or(&[]);
            match outcome {
                Outcome::More => {}
                Outcome::Refused(_) => sink(Err(TraceError::BadFrame)),
                Outcome::Frame => match unseal(self.deframer.frame()) {
                    None => sink(Err(TraceError::BadFrame)),
                    Some(body) => frame(body, &mut self.columns, &mut self.next_row, &mut self.ended, &mut sink),
                },
            }
        }
    }

    /// Whether the end has come.
    pub fn ended(&self) -> bool {
        self.ended
    }

    /// Rows that have come.
    pub fn rows(&self) -> u32 {
        self.next_row
    }
}

fn frame(
    body: &[u8],
    columns: &mut Option<Counts>,
    next_row: &mut u32,
    ended: &mut bool,
    sink: &mut impl FnMut(Result<TraceEvent<'_>, TraceError>),
) {
    match (body.split_first(), *columns) {
        (Some((&HEAD, rest)), _) => match head(rest) {
            Ok((described, ids)) => {
                *columns = Some(Columns { axes: ids.axes.len(), lasers: ids.lasers.len(), crds: ids.crds.len() });
                *next_row = 0;
                *ended = false;
                sink(Ok(TraceEvent::Head(described, ids)));
            }
            Err(error) => sink(Err(error)),
        },
        (Some((&ROWS, rest)), Some(columns)) => rows(rest, columns, next_row, sink),
        (Some((&END, rest)), Some(_)) => match EndLayout::read_from_bytes(rest) {
            Ok(end) => {
                let (sent, lost) = (end.rows.get(), end.lost.get());
                *ended = true;
                if sent != *next_row {
                    sink(Err(TraceError::Missing { expected: *next_row, came: sent }));
                }
                if lost != 0 {
                    sink(Err(TraceError::Lost(lost)));
                }
                sink(Ok(TraceEvent::End { rows: sent, lost }));
            }
            Err(_) => sink(Err(TraceError::Unexpected)),
        },
        _ => sink(Err(TraceError::Unexpected)),
    }
}

/// `count` structs, and the bytes after them.
fn list<T: Wire>(bytes: &[u8], count: usize) -> Option<(List<'_, T>, &[u8])> {
    let (list, rest) = bytes.split_at_checked(count.saturating_mul(size_of::<T>()))?;
    Some((List::new(list), rest))
}

/// A value, and the bytes after it.
type Before<'a, T> = (T, &'a [u8]);

/// The columns, and the bytes after them.
fn lists<A: Wire, L: Wire, C: Wire>(bytes: &[u8], counts: Counts) -> Option<Before<'_, Lists<'_, A, L, C>>> {
    let (axes, rest) = list(bytes, counts.axes)?;
    let (lasers, rest) = list(rest, counts.lasers)?;
    let (crds, rest) = list(rest, counts.crds)?;
    Some((Columns { axes, lasers, crds }, rest))
}

fn head(bytes: &[u8]) -> Result<(TraceHead, Lists<'_, AxisId, LaserId, CrdId>), TraceError> {
    match bytes.first() {
        Some(&VERSION) => {}
        Some(&other) => return Err(TraceError::Version(other)),
        None => return Err(TraceError::Unexpected),
    }
    let (layout, rest) = HeadLayout::read_from_prefix(bytes).map_err(|_| TraceError::Unexpected)?;
    let (axes, lasers, crds) = (layout.axes.into(), layout.lasers.into(), layout.crds.into());
    let ids = match lists(rest, Columns { axes, lasers, crds }) {
        Some((ids, [])) if axes <= MAX_AXES && lasers <= MAX_LASERS && crds <= MAX_CRDS => ids,
        _ => return Err(TraceError::Unexpected),
    };
    let head = TraceHead {
        schema: layout.schema.get(),
        period_ns: layout.period_ns.get(),
        every: layout.every.get(),
        timer_mhz: layout.timer_mhz.get(),
    };
    Ok((head, ids))
}

fn rows(bytes: &[u8], columns: Counts, next_row: &mut u32, sink: &mut impl FnMut(Result<TraceEvent<'_>, TraceError>)) {
    let mut rest = bytes;
    while let Some((&what, body)) = rest.split_first() {
        let after = match what {
            ROW => RowLayout::read_from_prefix(rest).ok().and_then(|(head, after)| {
                let (samples, after) = lists(after, columns)?;
                let row = head.row.get();
                if row != *next_row {
                    sink(Err(TraceError::Missing { expected: *next_row, came: row }));
                }
                *next_row = row.wrapping_add(1);
                sink(Ok(TraceEvent::Row(row, samples)));
                Some(after)
            }),
            ACTION => Action::read_from_prefix(body).ok().map(|(action, after)| {
                sink(Ok(TraceEvent::Action(action)));
                after
            }),
            OUTPUTS => Outputs::read_from_prefix(body).ok().map(|(outputs, after)| {
                sink(Ok(TraceEvent::Outputs(outputs)));
                after
            }),
            PERIOD => Period::read_from_prefix(body).ok().map(|(period, after)| {
                sink(Ok(TraceEvent::Period(period)));
                after
            }),
            ZERO => Zero::read_from_prefix(body).ok().and_then(|(zero, after)| {
                let known = usize::from(zero.column) < columns.axes;
                known.then(|| sink(Ok(TraceEvent::Zero(zero))))?;
                Some(after)
            }),
            _ => None,
        };
        let Some(after) = after else { return sink(Err(TraceError::Unexpected)) };
        rest = after;
    }
}
