//! `--json`: one JSON object on the standard output instead of text (docs/json.md).
//!
//! In: facts, what a job read, messages with their places. Out: one object, as the last thing that
//! the program says. Owns what was collected; nothing is, unless [`begin`] was called. Fails never:
//! a number that JSON has not is null.
use job::{Diagnostic, Severity};
use serde::Serialize;
use std::sync::{Mutex, PoisonError};

/// Changes when a field is taken away or means something else.
pub const SCHEMA: &str = "beamtick-1";

/// `--json`.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub struct Json {
    /// Prints one JSON object instead of text, also of an error; docs/json.md says what is in it.
    #[arg(long)]
    pub json: bool,
}

/// What the program prints.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct Report {
    /// `beamtick-1`.
    schema: &'static str,
    /// `info`, `check`, `sim`, `run` or `monitor`.
    command: &'static str,
    /// 0 done, 1 the job or the link failed, 2 the command line or a file is wrong, 130 and others
    /// a signal.
    exit_code: u8,
    /// Why it ended, unless `exit_code` is 0.
    error: Option<Fault>,
    /// Errors, warnings and notes with their places, in the order in which they came.
    messages: Vec<Message>,
    /// What the job read, in its order.
    reads: Vec<Read>,
    /// What the command found; none if it failed before.
    result: Option<Facts>,
    /// It is printed in one line.
    #[serde(skip)]
    line: bool,
}

/// Why a command failed.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct Fault {
    /// `job` (1), `input` (2) or `signal`.
    kind: &'static str,
    /// As it would be printed.
    text: String,
}

/// A message with its place.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct Message {
    /// `error`, `warning` or `note`.
    severity: &'static str,
    file: Option<String>,
    line: Option<u32>,
    column: Option<u32>,
    text: String,
    help: Option<String>,
}

/// Values that a call of the job read.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Read {
    /// The job's file.
    pub file: String,
    /// Its line, from 1.
    pub line: u32,
    /// The function.
    pub call: String,
    /// The variables that it fills.
    pub variables: Vec<String>,
    /// The values as text.
    pub values: String,
}

/// Facts of a command.
#[derive(Debug, Serialize)]
#[serde(untagged)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub enum Facts {
    /// `info`.
    Info(Box<crate::info::Facts>),
    /// `check`.
    Check(Box<crate::listing::Facts>),
    /// `sim`, `run`.
    Summary(Box<crate::summary::Summary>),
    /// `monitor`.
    Monitor(Box<crate::monitor::State>),
}

static REPORT: Mutex<Option<Report>> = Mutex::new(None);

fn with(change: impl FnOnce(&mut Report)) -> bool {
    REPORT.lock().unwrap_or_else(PoisonError::into_inner).as_mut().map(change).is_some()
}

/// From here on everything is collected, and text for the standard output is not printed.
pub fn begin(command: &'static str, asked: Json) {
    collect(command, asked.json, false);
}

/// The same, for an object in one line.
pub fn begin_line(command: &'static str, asked: bool) {
    collect(command, asked, true);
}

fn collect(command: &'static str, asked: bool, line: bool) {
    if asked {
        let (messages, reads) = (Vec::new(), Vec::new());
        let report = Report { schema: SCHEMA, command, exit_code: 0, error: None, messages, reads, result: None, line };
        *REPORT.lock().unwrap_or_else(PoisonError::into_inner) = Some(report);
    }
}

/// Whether text is not wanted.
pub fn is_on() -> bool {
    with(|_| ())
}

/// A message about a place in a text.
pub fn message(diagnostic: &Diagnostic, file: &str) {
    with(|report| {
        report.messages.push(Message {
            severity: match diagnostic.severity {
                Severity::Error => "error",
                Severity::Warning => "warning",
            },
            file: Some(file.to_owned()),
            line: Some(diagnostic.line),
            column: Some(diagnostic.column),
            text: job::tidy(&diagnostic.message),
            help: diagnostic.help.as_deref().map(job::tidy),
        });
    });
}

/// A note, `FILE:LINE: note: …` or `FILE: note: …`.
pub fn note(text: &str) {
    with(|report| {
        let (place, text) = text.split_once(": note: ").unwrap_or(("", text));
        let (file, line) = match place.rsplit_once(':') {
            Some((file, line)) if line.parse::<u32>().is_ok() => (file, line.parse().ok()),
            _ => (place, None),
        };
        let file = (!file.is_empty()).then(|| file.to_owned());
        report.messages.push(Message { severity: "note", file, line, column: None, text: text.to_owned(), help: None });
    });
}

/// What the job read; whether it is collected.
pub fn read(read: Read) -> bool {
    with(|report| report.reads.push(read))
}

/// What the command found; whether it is collected.
pub fn result(facts: Facts) -> bool {
    with(|report| report.result = Some(facts))
}

/// The object, if one is wanted, with the end of the program.
pub fn end(exit_code: u8, error: Option<(&'static str, &str)>) -> Option<String> {
    let mut report = REPORT.lock().unwrap_or_else(PoisonError::into_inner).take()?;
    report.exit_code = exit_code;
    report.error = error.map(|(kind, text)| Fault { kind, text: text.trim_end().to_owned() });
    // Its keys are names and its numbers are numbers: this does not fail.
    let text = if report.line { serde_json::to_string(&report) } else { serde_json::to_string_pretty(&report) };
    Some(text.unwrap_or_default() + "\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// docs/json.schema.json is what the types say; `BEAMTICK_WRITE=1` writes it.
    #[test]
    fn the_schema_of_the_page_is_that_of_the_code() {
        let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/json.schema.json");
        let made = serde_json::to_string_pretty(&schemars::schema_for!(Report)).unwrap() + "\n";
        if std::env::var_os("BEAMTICK_WRITE").is_some() {
            std::fs::write(page, &made).unwrap();
        }
        assert!(std::fs::read_to_string(page).unwrap() == made, "run with BEAMTICK_WRITE=1");
    }

    #[test]
    fn a_number_that_json_has_not_is_null() {
        let facts = serde_json::to_string(&[f64::NAN, f64::INFINITY, 1.5]).unwrap();
        assert_eq!(facts, "[null,null,1.5]");
    }
}
