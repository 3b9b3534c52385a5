//! `BEAMTICK_LOG`: each call with its arguments, result, reason and controller time, a line each.
//!
//! In: calls between Open and Close of a card, those two included. Out: a text file, written line
//! by line, so that a program that dies leaves all its calls. Fails: a line that cannot be written
//! ends the log, and disturbs no call.

use crate::boundary::Arg;
use crate::card::CardSlot;
use crate::engine::Prepared;
use crate::staged::Staged;
use client::{Error, Result};
use std::fs::File;
use std::io::Write;
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

struct Log {
    staged: Staged,
    file: File,
    is_whole: bool,
}

static LOGS: [Mutex<Option<Log>>; CardSlot::COUNT] = [const { Mutex::new(None) }; CardSlot::COUNT];

fn log(slot: CardSlot) -> MutexGuard<'static, Option<Log>> {
    LOGS.get(slot.index()).unwrap_or(&LOGS[0]).lock().unwrap_or_else(PoisonError::into_inner)
}

/// Begins the log of a card.
pub fn begin(slot: CardSlot, path: &Path) -> Result<()> {
    let failed = |error| Error::cannot_open(&format!("the log {}", path.display()), error);
    let (staged, file) = Staged::stream(path).map_err(failed)?;
    let mut log = log(slot);
    *log = Some(Log { staged, file, is_whole: true });
    Ok(())
}

/// Whether there is one.
pub fn is_on(slot: CardSlot) -> bool {
    log(slot).is_some()
}

impl std::fmt::Display for Arg {
    /// As a C programmer writes it.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Arg::Int(whole) => write!(f, "{whole}"),
            Arg::Real(real) if *real == f64::MIN => f.write_str("GT_NOT_GIVEN"),
            Arg::Real(real) => write!(f, "{real:?}"),
            Arg::Address(address) if address.is_null() => f.write_str("NULL"),
            Arg::Address(_) => f.write_str("&"),
        }
    }
}

/// The arguments, and what is at their addresses.
///
/// # Safety
/// As for `engine::call`.
unsafe fn argument_list(prepared: &Prepared, args: &[Arg], done: bool) -> String {
    let one = |(n, arg): (usize, &Arg)| match arg {
        Arg::Address(address) if !address.is_null() => {
            // SAFETY: as the caller says.
            let content = unsafe { prepared.content(n, args, done) };
            let content = content.map_or(String::new(), |content| format!("={content}"));
            format!("&{}{content}", prepared.argument(n))
        }
        arg => arg.to_string(),
    };
    args.iter().enumerate().map(one).collect::<Vec<_>>().join(", ")
}

/// A call has returned; `now` is the controller's time.
///
/// # Safety
/// As for `engine::call`.
pub unsafe fn write(
    slot: CardSlot,
    prepared: &Prepared,
    call: (i16, &[Arg]),
    code: i16,
    text: &str,
    now: Option<Duration>,
) {
    let mut log = log(slot);
    let Some(Log { file, is_whole, .. }) = log.as_mut().filter(|log| log.is_whole) else { return };
    let (lead, args) = call;
    let time = now.map_or("-".to_owned(), |now| format!("{:.3}", now.as_secs_f64() * 1e3));
    let lead = if prepared.has_leading_argument() { format!("{lead}, ") } else { String::new() };
    // SAFETY: as the caller says.
    let list = format!("{lead}{}", unsafe { argument_list(prepared, args, code == 0) });
    let reason = if text.is_empty() { String::new() } else { format!("  {text}") };
    let line = format!("{time} {}({}) = {code}{reason}\n", prepared.symbol(), list.trim_end_matches(", "));
    *is_whole = file.write_all(line.as_bytes()).is_ok();
}

/// Ends it.
pub fn end(slot: CardSlot) {
    if let Some(Log { staged, file, is_whole }) = log(slot).take() {
        drop(file);
        let _ = staged.end(is_whole);
    }
}
