#![no_std]
#![no_main]
//! The image for the module with an STM32H743VI: the log leaves by RTT.
use defmt_rtt as _;

#[cortex_m_rt::entry]
fn main() -> ! {
    firmware::main()
}
