//! What `usvg` and `simplecss` complain of, which they say to a log only.
//!
//! In: the log. Out: texts, each once, of the thread that asked. Owns the program's logger, if
//! nobody else does.
use log::{LevelFilter, Log, Metadata, Record};
use std::cell::RefCell;

thread_local! {
    static SAID: RefCell<Option<(&'static str, Vec<String>)>> = const { RefCell::new(None) };
}

/// More than these are not kept.
const WARNINGS_MAX: usize = 100;

struct Listener;

impl Log for Listener {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        SAID.with_borrow(|said| said.as_ref().is_some_and(|(of, _)| metadata.target().starts_with(of)))
    }

    fn log(&self, record: &Record<'_>) {
        if self.enabled(record.metadata()) {
            SAID.with_borrow_mut(|said| {
                let Some((_, said)) = said.as_mut().filter(|(_, said)| said.len() < WARNINGS_MAX) else { return };
                let text: String = record.args().to_string().chars().take(160).collect();
                if !said.contains(&text) {
                    said.push(text);
                }
            });
        }
    }

    fn flush(&self) {}
}

/// Does `work`, and says what the crate `of` complained of meanwhile.
pub fn during<T>(of: &'static str, work: impl FnOnce() -> T) -> (T, Vec<String>) {
    // A second call finds the same logger.
    let _ = log::set_logger(&Listener);
    log::set_max_level(LevelFilter::Warn);
    SAID.set(Some((of, Vec::new())));
    let done = work();
    (done, SAID.take().map(|(_, said)| said).unwrap_or_default())
}
