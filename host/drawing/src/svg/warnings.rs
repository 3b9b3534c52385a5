//! What `usvg` complains of, which it says to a log only.
//!
//! In: its log. Out: texts, of the thread that asked. Owns the program's logger, if nobody else
//! does.
use log::{LevelFilter, Log, Metadata, Record};
use std::cell::RefCell;

thread_local! {
    static SAID: RefCell<Option<Vec<String>>> = const { RefCell::new(None) };
}

/// More than these are not kept.
const WARNINGS_MAX: usize = 100;

struct Listener;

impl Log for Listener {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.target().starts_with("usvg")
    }

    fn log(&self, record: &Record<'_>) {
        if self.enabled(record.metadata()) {
            SAID.with_borrow_mut(|said| {
                if let Some(said) = said.as_mut().filter(|said| said.len() < WARNINGS_MAX) {
                    said.push(record.args().to_string().chars().take(160).collect());
                }
            });
        }
    }

    fn flush(&self) {}
}

/// Does `work`, and says what was complained of meanwhile.
pub fn during<T>(work: impl FnOnce() -> T) -> (T, Vec<String>) {
    // A second call finds the same logger.
    let _ = log::set_logger(&Listener);
    log::set_max_level(LevelFilter::Warn);
    SAID.set(Some(Vec::new()));
    let done = work();
    (done, SAID.take().unwrap_or_default())
}
