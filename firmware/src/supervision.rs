//! Supervision of the servo tick and the link task, which feeds the watchdog.
//!
//! In: calls from both as they run. Out: the watchdog is fed while both run; what is stuck, once it
//! was not fed. Owns five words. Fails: a tick that never ends, ticks that do not come (masked
//! interrupts, a stopped timer) and a link task that does not run all end as an NMI, which nothing
//! masks. Where the watchdog has no NMI, they end as a reset.
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};
use hal::board::watchdog;
use servo::units::Ns;

/// Time in units of 2²⁰ ns of the controller's time, about 1 ms. 2³² units are 52 days; only
/// differences count.
fn units(now: Ns) -> u32 {
    (now.0 >> 20) as u32
}

/// The link task must run within this many units: 0.5 s. Each tick wakes it; a full message takes
/// some ms.
const TASK_TURN_UNITS: u32 = 500_000_000 >> 20;

// All relaxed: flags between contexts of one core, each written in one of them.
#[cfg_attr(feature = "stm32h743", unsafe(link_section = ".state.words"))]
static IN_TICK: AtomicBool = AtomicBool::new(false);
/// When the last tick ended.
#[cfg_attr(feature = "stm32h743", unsafe(link_section = ".state.words"))]
static TICKED: AtomicU32 = AtomicU32::new(0);
/// The link task has run since the last tick; and when a tick last found that.
#[cfg_attr(feature = "stm32h743", unsafe(link_section = ".state.words"))]
static TASK_RAN: AtomicBool = AtomicBool::new(false);
#[cfg_attr(feature = "stm32h743", unsafe(link_section = ".state.words"))]
static TASK_RAN_AT: AtomicU32 = AtomicU32::new(0);
/// `TICKED` at the last NMI.
static TICKED_AT_NMI: AtomicU32 = AtomicU32::new(u32::MAX);

/// The link task runs.
pub fn turn() {
    TASK_RAN.store(true, Relaxed);
}

/// The servo tick begins.
pub fn tick_begins() {
    IN_TICK.store(true, Relaxed);
}

/// The servo tick has ended; feeds the watchdog if the link task runs too.
pub fn tick_ends(now: Ns) {
    let now = units(now);
    TICKED.store(now, Relaxed);
    if TASK_RAN.swap(false, Relaxed) {
        TASK_RAN_AT.store(now, Relaxed);
    }
    IN_TICK.store(false, Relaxed);
    if !is_late(now) {
        watchdog::feed();
    }
}

fn is_late(now: u32) -> bool {
    now.wrapping_sub(TASK_RAN_AT.load(Relaxed)) > TASK_TURN_UNITS
}

/// In the watchdog's NMI: what is stuck. Nothing is, if the watchdog's time ran while the core
/// slept, as it may when the host delays an emulator. A second NMI without a tick in between means
/// that ticks do not come.
pub fn stuck() -> Option<&'static str> {
    let ticked = TICKED.load(Relaxed);
    if IN_TICK.load(Relaxed) {
        Some("the servo tick did not end")
    } else if is_late(ticked) {
        Some("the link task stood still")
    } else if TICKED_AT_NMI.swap(ticked, Relaxed) == ticked {
        Some("no servo tick came")
    } else {
        None
    }
}
