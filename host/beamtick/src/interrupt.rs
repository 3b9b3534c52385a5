//! INT, TERM and HUP: the end of the program from outside.
//!
//! In: signals. Out: the end of the program with 128 + the signal's number. It ends at once, or,
//! while the job may have light or motion, through [`came`]: the runner stops the job first. Owns
//! one thread. Fails: if the runner does not finish in time, the thread ends the program. The
//! controller then shuts off its lasers, since the link is lost.
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// The runner has this long to stop a job; the whole stays below a second (SPEC 10).
const STOP_TIMEOUT: Duration = Duration::from_millis(850);

/// What is said last may take so long to be read.
pub const LAST_MESSAGE_TIMEOUT: Duration = Duration::from_millis(50);

/// What is said where a signal ends the program at once; nothing while it is empty.
static LAST: Mutex<&str> = Mutex::new("");

static CAME: AtomicU8 = AtomicU8::new(0);
static HELD: AtomicBool = AtomicBool::new(false);

/// A signal that ends the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Signal(u8);

impl Signal {
    /// What a person calls it.
    pub fn name(self) -> &'static str {
        match self.0 {
            1 => "SIGHUP",
            2 => "SIGINT",
            15 => "SIGTERM",
            _ => "a signal",
        }
    }

    /// The exit code that shells give a program which it ended.
    pub fn exit_code(self) -> u8 {
        128 + self.0
    }
}

/// The signal that has come, if one has.
pub fn came() -> Option<Signal> {
    match CAME.load(Ordering::SeqCst) {
        0 => None,
        number => Some(Signal(number)),
    }
}

/// From now on a signal that ends the program at once says this first.
pub fn say_last(text: &'static str) {
    *LAST.lock().unwrap_or_else(PoisonError::into_inner) = text;
}

/// While it lives a signal does not end the program but is left to whoever asks [`came`].
pub struct Held(());

impl Held {
    /// See there.
    pub fn new() -> Held {
        HELD.store(true, Ordering::SeqCst);
        Held(())
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        // The runner reports a signal that came before this.
        HELD.store(false, Ordering::SeqCst);
    }
}

fn arrived(number: u8) {
    CAME.store(number, Ordering::SeqCst);
    let signal = Signal(number);
    if HELD.load(Ordering::SeqCst) {
        std::thread::sleep(STOP_TIMEOUT);
        if HELD.load(Ordering::SeqCst) {
            complain!(
                "interrupted by {}: the controller did not confirm in time that it stopped. When the link is lost it shuts off lasers, \
                 and stops Jog axes and coordinate systems, by itself.",
                signal.name()
            );
        }
    } else {
        let last = *LAST.lock().unwrap_or_else(PoisonError::into_inner);
        if !last.is_empty() {
            complain!("{last}");
        }
    }
    if let Some(object) = crate::json::end(signal.exit_code(), Some(("signal", signal.name()))) {
        say!("{}", object.trim_end());
    }
    let kept: String = crate::output::leave().iter().map(ToString::to_string).collect();
    if !kept.is_empty() {
        complain!("{}", kept.trim_start());
    }
    crate::printer::finish(Some(LAST_MESSAGE_TIMEOUT));
    std::process::exit(signal.exit_code().into());
}

/// From now on signals do as the module says; for the program itself, not for tests that call its
/// library.
#[cfg(unix)]
pub fn watch() {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
    // A file that grows beyond its limit is an error of that file, and no end of the program.
    let _ = signal_hook::flag::register(SIGXFSZ, std::sync::Arc::new(AtomicBool::new(false)));
    // `nohup` means it.
    let taken = if ignores_hangups() { vec![SIGINT, SIGTERM] } else { vec![SIGHUP, SIGINT, SIGTERM] };
    // Without it a signal ends the program at once, and the link that is lost stops what it can.
    let Ok(mut signals) = signal_hook::iterator::Signals::new(taken) else { return };
    std::thread::spawn(move || signals.forever().for_each(|number| arrived(number as u8)));
}

/// Whether whoever started the program has HUP ignored; known on Linux only.
#[cfg(unix)]
fn ignores_hangups() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_some_and(|mask| mask & 1 == 1)
}

/// The same for Ctrl-C and for a console window that is closed.
#[cfg(not(unix))]
pub fn watch() {
    let _ = ctrlc::set_handler(|| arrived(2));
}
