#![no_std]
#![no_main]
//! The clocks of the image, by embassy-stm32.

#[cortex_m_rt::entry]
fn main() -> ! {
    core::hint::black_box(beamtick_embassy::init());
    beamtick_embassy::rest()
}
