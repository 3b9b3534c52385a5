#![no_std]
#![no_main]
//! The clocks of the image, by hal.

#[cortex_m_rt::entry]
fn main() -> ! {
    beamtick_embassy::raise();
    beamtick_embassy::rest()
}
