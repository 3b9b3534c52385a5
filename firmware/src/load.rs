//! How long servo ticks take, and how much of the stack was never used.
//!
//! In: the time of each tick, from its handler. Out: median, longest and a histogram, for the
//! thread. Owns their words. The median is a running one: each tick moves it by a step towards its
//! own time, so it settles where as many ticks are longer as shorter. The longest is kept twice:
//! since somebody asked, by the tick, and since the start, by the thread. Fails never.
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
#[cfg(feature = "stm32h743")]
use dispatcher::TickTime;
use dispatcher::{TICK_BUCKET_NS, TICK_BUCKETS};

/// How far a tick moves the median, in ns: 16 ticks to follow a change of 0.25 µs.
const STEP_NS: u32 = 16;

// Relaxed: written in the tick alone, read one by one.
#[cfg_attr(feature = "stm32h743", unsafe(link_section = ".state.words"))]
static MEDIAN_NS: AtomicU32 = AtomicU32::new(0);
/// The longest since the last call of [`tick_time`], which takes it.
#[cfg_attr(feature = "stm32h743", unsafe(link_section = ".state.words"))]
static RECENT_NS: AtomicU32 = AtomicU32::new(0);
/// The longest before that.
#[cfg(feature = "stm32h743")]
static WORST_NS: AtomicU32 = AtomicU32::new(0);
#[cfg_attr(feature = "stm32h743", unsafe(link_section = ".state.histogram"))]
static HISTOGRAM: [AtomicU32; TICK_BUCKETS] = [const { AtomicU32::new(0) }; TICK_BUCKETS];

/// A tick has taken this long.
#[inline(always)]
pub fn tick_took(ns: u32) {
    let median = MEDIAN_NS.load(Relaxed);
    let moved = if ns > median { median.wrapping_add(STEP_NS) } else { median.saturating_sub(STEP_NS) };
    MEDIAN_NS.store(moved, Relaxed);
    if ns > RECENT_NS.load(Relaxed) {
        RECENT_NS.store(ns, Relaxed);
    }
    let bucket = (ns / TICK_BUCKET_NS) as usize;
    if let Some(ticks) = HISTOGRAM.get(bucket.min(TICK_BUCKETS - 1)) {
        ticks.store(ticks.load(Relaxed).wrapping_add(1), Relaxed);
    }
}

/// Times so far, in the thread: the next call has the longest tick from now on.
#[cfg(feature = "stm32h743")]
pub fn tick_time() -> TickTime {
    let recent_ns = RECENT_NS.swap(0, Relaxed);
    let worst_ns = WORST_NS.load(Relaxed).max(recent_ns);
    WORST_NS.store(worst_ns, Relaxed);
    TickTime {
        median_ns: MEDIAN_NS.load(Relaxed),
        worst_ns,
        recent_ns,
        histogram: HISTOGRAM.each_ref().map(|ticks| ticks.load(Relaxed)),
    }
}

/// The stack so far.
#[cfg(feature = "stm32h743")]
pub fn stack() -> dispatcher::Stack {
    let (size, unused) = hal::board::stack::size_and_unused();
    dispatcher::Stack { size, unused }
}
