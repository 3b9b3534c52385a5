#![no_std]
#![no_main]
//! Clocks, and a USART that receives by DMA into a ring, by embassy-stm32.
use core::future::Future;
use core::task::{Context, Poll, Waker};
use embassy_stm32::usart::{Config, UartRx, UartTx};
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
    let p = beamtick_embassy::init();
    let mut config = Config::default();
    config.baudrate = 3_000_000;
    let (Ok(rx), Ok(mut tx)) = (
        UartRx::new(p.USART3, p.PD9, p.DMA1_CH2, Irqs, config),
        // SAFETY: the other half of it.
        UartTx::new_blocking(unsafe { peripherals::USART3::steal() }, p.PD8, config),
    ) else {
        beamtick_embassy::rest()
    };
    // SAFETY: once.
    let mut rx = rx.into_ring_buffered(unsafe { &mut *(&raw mut RING) });
    let mut bytes = [0; 64];
    let mut context = Context::from_waker(Waker::noop());
    loop {
        let read = core::pin::pin!(rx.read(&mut bytes)).poll(&mut context);
        if let Poll::Ready(Ok(count)) = read {
            let _ = tx.blocking_write(bytes.get(..count).unwrap_or(&[]));
        }
    }
}
