//! The time that is drawn.
use crate::{Result, TraceError};

/// From an instant to another, ns since the job's start.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Window {
    pub from: u64,
    /// `u64::MAX` is the end of the trace.
    pub to: u64,
}

/// Greatest time that a window may name, ms: 292 years.
const LAST_MS: f64 = 9.2e12;

impl Window {
    /// From what the user asks for, in ms.
    pub fn new(from_ms: Option<f64>, to_ms: Option<f64>) -> Result<Self> {
        for (name, ms) in [("from", from_ms), ("to", to_ms)] {
            if let Some(ms) = ms
                && !(0.0..=LAST_MS).contains(&ms)
            {
                return Err(TraceError::Window(format!("{name} is {ms} ms; it must be from 0 to {LAST_MS:e} ms")));
            }
        }
        let ns = |ms: f64| (ms * 1e6).round() as u64;
        let window = Window { from: from_ms.map_or(0, ns), to: to_ms.map_or(u64::MAX, ns) };
        if window.from >= window.to {
            let (from, to) = (window.from as f64 * 1e-6, window.to as f64 * 1e-6);
            return Err(TraceError::Window(format!("to is {to} ms; it must be later than from, which is {from} ms")));
        }
        Ok(window)
    }

    /// Nothing of a trace that ends at `last_ns` lies in it.
    pub fn is_empty(&self, last_ns: u64) -> TraceError {
        let (from, last) = (self.from as f64 * 1e-6, last_ns as f64 * 1e-6);
        if self.from == 0 {
            return TraceError::Window("the trace has no row in it".to_owned());
        }
        TraceError::Window(format!("from is {from} ms; the trace ends at {last} ms"))
    }
}
