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

/// An argument as a C programmer writes it.
fn shown(prepared: &Prepared, args: &[Arg]) -> String {
    let one = |(n, arg): (usize, &Arg)| match arg {
        Arg::Int(whole) => whole.to_string(),
        Arg::Real(real) if *real == f64::MIN => "GT_NOT_GIVEN".to_owned(),
        Arg::Real(real) => format!("{real:?}"),
        Arg::Address(address) if address.is_null() => "NULL".to_owned(),
        Arg::Address(_) => format!("&{}", prepared.argument(n)),
    };
    args.iter().enumerate().map(one).collect::<Vec<_>>().join(", ")
}

/// A call has returned. `filled` is what it wrote, by name; `now` the controller's time.
pub fn write(slot: CardSlot, prepared: &Prepared, call: (i16, &[Arg]), code: i16, text: &str, now: Option<Duration>) {
    let mut log = log(slot);
    let Some(Log { file, is_whole, .. }) = log.as_mut().filter(|log| log.is_whole) else { return };
    let (lead, args) = call;
    let time = now.map_or("-".to_owned(), |now| format!("{:.3}", now.as_secs_f64() * 1e3));
    let lead = if prepared.leads() { format!("{lead}, ") } else { String::new() };
    let list = format!("{lead}{}", shown(prepared, args));
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
