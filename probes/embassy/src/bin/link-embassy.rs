#![no_std]
#![no_main]
//! A link that receives, by embassy-stm32: the interrupts of USART and DMA end the core's wait, and
//! the thread reads what has arrived.
use beamtick_embassy::{init, rest, take};
use core::future::Future;
use core::task::{Context, Poll, Waker};
use embassy_stm32::usart::{Config, UartRx};
use embassy_stm32::{bind_interrupts, dma, peripherals, usart};

bind_interrupts!(struct Irqs {
    USART3 => usart::InterruptHandler<peripherals::USART3>;
    DMA1_STREAM2 => dma::InterruptHandler<peripherals::DMA1_CH2>;
});

// Where the image's ring lies.
#[unsafe(link_section = ".dma.ring")]
static mut RING: [u8; 512] = [0; 512];

#[cortex_m_rt::entry]
fn main() -> ! {
    let p = init();
    let mut config = Config::default();
    config.baudrate = 3_000_000;
    let Ok(rx) = UartRx::new(p.USART3, p.PD9, p.DMA1_CH2, Irqs, config) else { rest() };
    // SAFETY: once.
    let mut rx = rx.into_ring_buffered(unsafe { &mut *(&raw mut RING) });
    let mut bytes = [0; 64];
    let mut context = Context::from_waker(Waker::noop());
    loop {
        let read = core::pin::pin!(rx.read(&mut bytes)).poll(&mut context);
        match read {
            Poll::Ready(Ok(count)) => bytes.iter().take(count).for_each(|byte| take(*byte)),
            // It starts again at the next read.
            Poll::Ready(Err(_)) => {}
            Poll::Pending => cortex_m::asm::wfi(),
        }
    }
}
