#![no_std]
#![no_main]
//! The watchdog alone, by hal.
use hal::board::watchdog;

#[cortex_m_rt::entry]
fn main() -> ! {
    watchdog::start();
    watchdog::feed();
    beamtick_embassy::rest()
}
