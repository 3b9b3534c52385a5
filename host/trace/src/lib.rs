#![forbid(unsafe_code)]
//! Trace files (SPEC 8): CSV, VCD and plots.
//!
//! In: the bytes of a trace stream, or [`Row`]s. Out: text and pictures. Nothing is rounded but by
//! exact integer rules in [`decimal`], so the same motion gives the same bytes whatever machine
//! traced it. Fails with a [`TraceError`] that names the row.
//!
//! ```text
//! bytes -> Reader -> Header, Rows -> CsvWriter | VcdWriter | Plot
//! ```
mod csv_file;
pub mod decimal;
mod plot;
mod row;
mod vcd_file;

pub use csv_file::CsvWriter;
pub use plot::{Plot, PlotOptions};
pub use row::{AxisPoint, Header, OutputEdge, Row};
pub use vcd_file::VcdWriter;

/// Why a trace could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum TraceError {
    /// The file could not be written.
    #[error("the file cannot be written: {0}")]
    Io(#[from] std::io::Error),
    /// A row is missing.
    #[error("the trace has a gap: row {expected} was to come and {got} came")]
    Gap {
        /// The row that was to come.
        expected: u32,
        /// The row that came.
        got: u32,
    },
    /// The stream is damaged.
    #[error("the trace stream is damaged near row {row}: {what}")]
    Damaged {
        /// The next row.
        row: u32,
        /// What is wrong.
        what: String,
    },
    /// More steps in a row than the VCD's time scale can show.
    #[error("axis {axis} makes {steps} steps in the {row_ns} ns after row {row}: a VCD of 1 ns cannot show them")]
    TooManySteps {
        /// Axis, from 1.
        axis: u8,
        /// Row before the steps.
        row: u32,
        /// Steps.
        steps: u64,
        /// Length of the row.
        row_ns: u64,
    },
    /// The picture could not be drawn.
    #[error("the plot cannot be drawn: {0}")]
    Plot(String),
}

/// Result of reading or writing a trace.
pub type Result<T> = std::result::Result<T, TraceError>;
