//! A pause of the core, in sleep.
//!
//! In: cycles. Out: as many have passed. Owns SysTick, which ends the sleep while interrupts are
//! masked and no handler runs. DWT's counter may stand meanwhile; the timers do not.
use cortex_m::peripheral::{SCB, SYST, syst::SystClkSource};
use hal::board::watchdog;

/// Sleeps for so many cycles, up to 2²⁴, and feeds the watchdog.
pub fn cycles(count: u32) {
    watchdog::feed();
    cortex_m::interrupt::free(|_| {
        // SAFETY: nobody else uses SysTick.
        let mut timer: SYST = unsafe { cortex_m::Peripherals::steal() }.SYST;
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(count.clamp(1, 0xff_ffff));
        timer.clear_current();
        timer.enable_interrupt();
        timer.enable_counter();
        while !SCB::is_pendst_pending() {
            cortex_m::asm::wfi();
        }
        timer.disable_counter();
        timer.disable_interrupt();
        SCB::clear_pendst();
    });
}
