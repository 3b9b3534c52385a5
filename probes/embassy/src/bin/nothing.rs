#![no_std]
#![no_main]
//! Nothing: what the others have beside their part.

#[cortex_m_rt::entry]
fn main() -> ! {
    beamtick_embassy::rest()
}
