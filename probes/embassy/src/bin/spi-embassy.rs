#![no_std]
#![no_main]
//! Clocks, and a frame of three bytes over SPI, by embassy-stm32.
use embassy_stm32::spi::{Config, MODE_1, Spi};
use embassy_stm32::time::Hertz;

#[cortex_m_rt::entry]
fn main() -> ! {
    let p = beamtick_embassy::init();
    let mut config = Config::default();
    (config.mode, config.frequency) = (MODE_1, Hertz(30_000_000));
    let mut bus = Spi::new_blocking_txonly(p.SPI3, p.PC10, p.PC12, config);
    core::hint::black_box(bus.blocking_write(&core::hint::black_box([1u8, 2, 3])).is_ok());
    beamtick_embassy::rest()
}
