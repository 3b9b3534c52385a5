//! What is wrong with a script and where, and how it is shown.

use ariadne::{Color, Config, IndexType, Label, Report, ReportKind, Source};
use std::ops::Range;

/// How bad it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Severity {
    /// The job does not run.
    Error,
    /// The job runs; the reader should know.
    Warning,
}

/// One thing to tell about a script.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    /// Error or warning.
    pub severity: Severity,
    /// Line, from 1.
    pub line: u32,
    /// Column in characters, from 1.
    pub column: u32,
    /// Bytes of the script that it points to.
    pub span: Range<usize>,
    /// What is wrong, and what was expected.
    pub message: String,
    /// What to do about it, if that can be said.
    pub help: Option<String>,
}

/// Renders `diagnostic` with `file:line:column`, the source line and a mark under the place.
pub fn render(diagnostic: &Diagnostic, file: &str, text: &str, colour: bool) -> String {
    let kind = match diagnostic.severity {
        Severity::Error => ReportKind::Error,
        Severity::Warning => ReportKind::Warning,
    };
    let mark = match diagnostic.severity {
        Severity::Error => Color::Red,
        Severity::Warning => Color::Yellow,
    };
    let place = (file, diagnostic.span.clone());
    let mut report = Report::build(kind, place.clone())
        .with_config(Config::default().with_color(colour).with_index_type(IndexType::Byte))
        .with_message(&diagnostic.message)
        .with_label(Label::new(place).with_color(mark).with_message("here"));
    if let Some(help) = &diagnostic.help {
        report = report.with_help(help);
    }
    let mut out = Vec::new();
    // Writing to a Vec does not fail; a report that could not be drawn still has its text.
    if report.finish().write((file, Source::from(text)), &mut out).is_err() {
        return format!("{file}:{}:{}: {}\n", diagnostic.line, diagnostic.column, diagnostic.message);
    }
    String::from_utf8_lossy(&out).into_owned()
}
