//! Rows as CSV (SPEC 8): `t_ms`, position and velocity of each axis, then gate, power and frequency
//! of each laser, then the path speed of each coordinate system; numbers with six decimals.
use crate::decimal::{milliseconds, position, scaled};
use crate::row::{Header, Row};
use crate::{Result, TraceError};
use std::io::Write;

/// Writes rows as they come.
pub struct CsvWriter<W: Write> {
    out: csv::Writer<W>,
}

impl<W: Write> CsvWriter<W> {
    /// Writes the header line.
    pub fn new(out: W, header: &Header) -> Result<Self> {
        let mut out = csv::WriterBuilder::new().buffer_capacity(1 << 16).from_writer(out);
        let names = header.axes.iter().flat_map(|n| [format!("{n}_pos"), format!("{n}_vel")]);
        let lasers =
            header.lasers.iter().flat_map(|k| [format!("{k}_gate"), format!("{k}_power"), format!("{k}_freq_khz")]);
        let crds = header.crds.iter().map(|n| format!("{n}_vel"));
        out.write_record(std::iter::once("t_ms".to_owned()).chain(names).chain(lasers).chain(crds)).map_err(as_io)?;
        Ok(CsvWriter { out })
    }

    /// Writes one row.
    pub fn row(&mut self, row: &Row) -> Result<()> {
        self.out.write_field(milliseconds(row.t_ns)).map_err(as_io)?;
        for point in &row.axes {
            self.out.write_field(position(point.pos)).map_err(as_io)?;
            self.out.write_field(scaled(point.vel)).map_err(as_io)?;
        }
        for point in &row.lasers {
            self.out.write_field(if point.gate { "1" } else { "0" }).map_err(as_io)?;
            self.out.write_field(scaled(point.power)).map_err(as_io)?;
            self.out.write_field(scaled(point.frequency)).map_err(as_io)?;
        }
        for speed in &row.crds {
            self.out.write_field(scaled(*speed)).map_err(as_io)?;
        }
        self.out.write_record(None::<&[u8]>).map_err(as_io)
    }

    /// Writes what is held back.
    pub fn finish(mut self) -> Result<()> {
        Ok(self.out.flush()?)
    }
}

pub(crate) fn as_io(e: csv::Error) -> TraceError {
    TraceError::Io(match e.into_kind() {
        csv::ErrorKind::Io(e) => e,
        other => std::io::Error::other(format!("{other:?}")),
    })
}
