#![no_std]
#![no_main]
//! The image for the emulated board: the log leaves by semihosting.
use defmt_semihosting as _;

#[cortex_m_rt::entry]
fn main() -> ! {
    firmware::main()
}
