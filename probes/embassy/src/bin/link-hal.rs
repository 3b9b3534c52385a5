#![no_std]
#![no_main]
//! A link that receives, by hal: the USART's interrupt reads what has arrived, as the image's does.
use beamtick_embassy::{raise, rest, take};
use embassy_stm32::pac::Interrupt;
use hal::board::uart::{self, Rx};

static mut RX: Option<Rx> = None;

#[unsafe(no_mangle)]
extern "C" fn USART3() {
    uart::acknowledge();
    // SAFETY: written before the interrupt is let in, and used here alone.
    if let Some(rx) = unsafe { &mut *(&raw mut RX) } {
        while let Some(byte) = rx.receive() {
            take(byte);
        }
    }
}

#[cortex_m_rt::entry]
fn main() -> ! {
    raise();
    // SAFETY: once, and before the interrupt is let in.
    unsafe {
        let (_, rx) = uart::open();
        (&raw mut RX).write(Some(rx));
        cortex_m::peripheral::NVIC::unmask(Interrupt::USART3);
    }
    rest()
}
