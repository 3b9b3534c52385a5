//! The bytes of a trace stream as a header and rows.
//!
//! In: bytes in any portions. Out: [`Item`]s in order. Owns the decoder and the last header. The first
//! error is the last thing that comes out: a gap is never passed over.
use crate::row::{AxisName, AxisPoint, Header, Row};
use crate::{Result, TraceError};
use protocol::trace::{Decoder, Event, TraceError as Fault};
use servo::piece::Scaled;
use servo::units::Pos;

/// What a trace stream brings.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Item {
    /// A trace begins.
    Header(Header),
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
    row_ns: u64,
}

impl Reader {
    /// Waits for a header.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes bytes and hands what they bring to `sink`; an error of the sink ends it.
    pub fn feed(&mut self, bytes: &[u8], mut sink: impl FnMut(Item) -> Result<()>) -> Result<()> {
        let mut outcome = Ok(());
        let row_ns = &mut self.row_ns;
        let mut rows = self.decoder.rows();
        self.decoder.feed(bytes, |event| {
            if outcome.is_ok() {
                outcome = event
                    .map_err(|fault| name(fault, rows))
                    .and_then(|event| item(event, row_ns, &mut rows))
                    .and_then(&mut sink);
            }
        });
        outcome
    }

    /// Whether the end has come.
    pub fn ended(&self) -> bool {
        self.decoder.ended()
    }
}

fn item(event: Event<'_>, row_ns: &mut u64, rows: &mut u32) -> Result<Item> {
    Ok(match event {
        Event::Head(head, axes) => {
            let axes = axes.iter().map(|a| AxisName { core: a.core.saturating_add(1), axis: a.axis }).collect();
            let header = Header { axes, lasers: Vec::new(), period_ns: head.period_ns.into(), every: head.every };
            *row_ns = header.row_ns();
            *rows = 0;
            Item::Header(header)
        }
        Event::Row(index, samples) => {
            *rows = index.wrapping_add(1);
            let point = |s: protocol::trace::Sample| AxisPoint {
                pos: Pos(s.pos.get()),
                vel: Scaled { m: s.vel_mantissa.get(), e: s.vel_exponent.get() },
            };
            Item::Row(Row {
                index,
                t_ns: u64::from(index) * *row_ns,
                axes: samples.iter().map(point).collect(),
                lasers: Vec::new(),
            })
        }
        Event::End { rows, .. } => Item::End { rows },
    })
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
