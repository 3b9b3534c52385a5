#![no_std]
#![no_main]
//! Clocks, and two analog inputs, by hal.
use hal::board::adc::Adc;

#[cortex_m_rt::entry]
fn main() -> ! {
    beamtick_embassy::raise();
    // SAFETY: once.
    let mut adc = unsafe { Adc::open() };
    for _ in 0..1000 {
        // A tick of 50 µs: the regulator wants 10 µs.
        cortex_m::asm::delay(24_000);
        adc.advance();
    }
    core::hint::black_box([adc.code(0), adc.code(1)]);
    beamtick_embassy::rest()
}
