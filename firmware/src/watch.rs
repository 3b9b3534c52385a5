//! Who is watched: the servo tick and the link task.
//!
//! In: what both say of themselves. Out: food for the watchdog while both get on, and what stands still when it was
//! not fed. Owns three words. A tick that never ends, ticks that do not come (interrupts that stay masked, a timer that
//! stands still) and a link task that does not come round all end as an NMI, which nothing masks, or, where the watchdog
//! has none, as a reset.
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};
use hal::board::watchdog;
use servo::units::Ns;

/// What is counted here: 2²⁰ ns of the controller's time, some ms. 2³² of them are 52 days; only differences count.
fn units(now: Ns) -> u32 {
    (now.0 >> 20) as u32
}

/// The link task comes round within this many units of ticks: 0.5 s. Each tick asks it to; a full message takes some ms.
const TURN: u32 = 500_000_000 >> 20;

// All relaxed: flags between contexts of one core, each written in one of them.
static IN_TICK: AtomicBool = AtomicBool::new(false);
/// When the last tick ended.
static TICKED: AtomicU32 = AtomicU32::new(0);
/// The link task came round since the tick looked; and when the tick last saw that.
static TURNED: AtomicBool = AtomicBool::new(false);
static TURN_SEEN: AtomicU32 = AtomicU32::new(0);
/// `TICKED` at the NMI before.
static NMI_SAW: AtomicU32 = AtomicU32::new(u32::MAX);

/// The link task comes round.
pub fn turn() {
    TURNED.store(true, Relaxed);
}

/// The servo tick begins.
pub fn tick_begins() {
    IN_TICK.store(true, Relaxed);
}

/// The servo tick has ended; the watchdog is fed if the link task gets on too.
pub fn tick_ends(now: Ns) {
    let now = units(now);
    TICKED.store(now, Relaxed);
    if TURNED.swap(false, Relaxed) {
        TURN_SEEN.store(now, Relaxed);
    }
    IN_TICK.store(false, Relaxed);
    if !is_late(now) {
        watchdog::feed();
    }
}

fn is_late(now: u32) -> bool {
    now.wrapping_sub(TURN_SEEN.load(Relaxed)) > TURN
}

/// In the watchdog's NMI: what stands still. Nothing does if the watchdog's time ran while the core slept, as it may
/// where the host holds an emulator up; if that happens again without a tick between, the ticks do not come.
pub fn stuck() -> Option<&'static str> {
    let ticked = TICKED.load(Relaxed);
    if IN_TICK.load(Relaxed) {
        Some("the servo tick did not end")
    } else if is_late(ticked) {
        Some("the link task stood still")
    } else if NMI_SAW.swap(ticked, Relaxed) == ticked {
        Some("no servo tick came")
    } else {
        None
    }
}
