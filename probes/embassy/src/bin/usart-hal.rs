#![no_std]
#![no_main]
//! Clocks, and a USART that receives by DMA into a ring, by hal.
use hal::board::uart;

#[cortex_m_rt::entry]
fn main() -> ! {
    beamtick_embassy::raise();
    // SAFETY: once.
    let (mut tx, mut rx) = unsafe { uart::open() };
    while let Some(byte) = rx.receive() {
        tx.send(byte);
    }
    core::hint::black_box(uart::acknowledge());
    beamtick_embassy::rest()
}
