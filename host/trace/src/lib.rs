#![forbid(unsafe_code)]
//! Trace files (SPEC 8): CSV, VCD and plots.
//!
//! In: the bytes of a trace stream, or [`Row`]s and what laser outputs did between them. Out: text
//! and pictures. Nothing is rounded but by exact integer rules in [`decimal`], so the same motion
//! gives the same bytes whatever machine traced it. Fails with a [`TraceError`] that names the row.
//!
//! ```text
//! bytes -> Reader -> Header, Rows -> CsvWriter | VcdWriter | Plot | Xy
//! ```
mod csv_file;
mod csv_reader;
pub mod decimal;
mod narrow;
mod plot;
mod reader;
mod row;
mod vcd_file;

pub use csv_file::CsvWriter;
pub use csv_reader::read_csv;
pub use narrow::{narrow_csv, narrow_vcd, outputs_that_change};
pub use plant::beam::SignalChange;
pub use plot::{Millimetres, Panels, Plot, PlotOptions, Preview, Xy};
pub use reader::{Item, Reader};
pub use row::{AnalogEdge, AxisName, AxisPoint, CrdName, Header, LaserName, LaserPoint, OutputEdge, PowerUnit, Row};
pub use vcd_file::VcdWriter;

/// Why a trace could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum TraceError {
    /// The file could not be written.
    #[error("the file cannot be written: {0}")]
    Io(#[from] std::io::Error),
    /// Rows are missing.
    #[error(
        "the trace has a gap: row {expected} was to come and {came} came; the link does not carry all of it beside the \
         calls: use a larger --every, or leave out the edges of lasers (--vcd, --plot, --html, --xy)"
    )]
    Gap {
        /// The row that was to come (at the end: the rows that came).
        expected: u32,
        /// The row that came (at the end: the rows that were sent).
        came: u32,
    },
    /// The controller made rows faster than the link took them.
    #[error("the controller lost {0} rows of the trace: the link does not carry them; use a larger --every")]
    Lost(u32),
    /// The stream is damaged.
    #[error("the trace stream is damaged after row {after}: {what}")]
    Damaged {
        /// Rows that came before.
        after: u32,
        /// What is wrong.
        what: &'static str,
    },
    /// The controller speaks another version of the stream.
    #[error("the trace is of version {theirs}, this client reads version {ours}", ours = protocol::trace::VERSION)]
    Version {
        /// Its version.
        theirs: u8,
    },
    /// The laser timers count with a clock that this client does not know.
    #[error("the lasers of this trace are timed with {mhz} MHz; this client reads traces of 100 to 1000 MHz")]
    Clock {
        /// Counts per µs.
        mhz: u16,
    },
    /// More steps in a row than the VCD's time scale can show.
    #[error("{axis} makes {steps} steps in the {row_ns} ns after row {row}: a VCD of 1 ns cannot show them")]
    TooManySteps {
        /// Which axis.
        axis: AxisName,
        /// Row before the steps.
        row: u32,
        /// Steps.
        steps: u64,
        /// Length of the row.
        row_ns: u64,
    },
    /// The plot's times are no time that it could show.
    #[error("the plot's time: {0}")]
    Window(String),
    /// A CSV could not be read.
    #[error("the trace cannot be read: {0}")]
    Unreadable(std::io::Error),
    /// A CSV that is no trace.
    #[error("line {line}: {what}")]
    Csv {
        /// Its line, from 1.
        line: u64,
        /// What is wrong.
        what: String,
    },
    /// The picture could not be drawn.
    #[error("the plot cannot be drawn: {0}")]
    Plot(String),
}

/// Result of reading or writing a trace.
pub type Result<T> = std::result::Result<T, TraceError>;
