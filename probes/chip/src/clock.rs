//! The clock that counts: SysTick, which in QEMU advances with the instructions.
//!
//! In: the core. Out: periods of 40 ns (25 MHz) between two readings. Owns nothing. Cannot fail; what lasts longer than
//! 2²⁴ periods, 0.67 s, turns over.
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;

/// A reading.
#[derive(Clone, Copy)]
pub struct Reading(u32);

/// Lets the clock run. Once, before anything is counted.
///
/// # Panics
///
/// If the core's peripherals were taken before.
pub fn start() {
    let mut core = cortex_m::Peripherals::take().expect("once");
    core.SYST.set_clock_source(SystClkSource::Core);
    core.SYST.set_reload(0xff_ffff);
    core.SYST.clear_current();
    core.SYST.enable_counter();
}

/// The clock now.
#[inline(always)]
#[must_use]
pub fn read() -> Reading {
    Reading(SYST::get_current())
}

impl Reading {
    /// Periods since this reading. The counter counts down.
    #[inline(always)]
    #[must_use]
    pub fn passed(self) -> u32 {
        self.0.wrapping_sub(SYST::get_current()) & 0xff_ffff
    }
}
