#![no_std]
#![no_main]
//! Clocks, and a frame of three bytes over SPI, by hal.
use embedded_hal::spi::SpiBus;
use hal::board::spi;

#[cortex_m_rt::entry]
fn main() -> ! {
    beamtick_embassy::raise();
    // SAFETY: once.
    let (mut bus, _, _) = unsafe { spi::open() };
    core::hint::black_box(bus.write(&core::hint::black_box([1, 2, 3])).is_ok());
    beamtick_embassy::rest()
}
