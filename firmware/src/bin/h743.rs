#![no_std]
#![no_main]
//! The image for the NUCLEO-H743ZI2: the log leaves by RTT.
use defmt_rtt as _;

#[cortex_m_rt::entry]
fn main() -> ! {
    firmware::main()
}
