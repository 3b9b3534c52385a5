#![no_std]
#![no_main]
//! The watchdog alone, by embassy-stm32, without `init`: its driver writes IWDG's registers only.
use embassy_stm32::peripherals::IWDG1;
use embassy_stm32::wdg::IndependentWatchdog;

#[cortex_m_rt::entry]
fn main() -> ! {
    // SAFETY: the only one.
    let mut watchdog = IndependentWatchdog::new(unsafe { IWDG1::steal() }, 100_000);
    watchdog.unleash();
    watchdog.pet();
    beamtick_embassy::rest()
}
