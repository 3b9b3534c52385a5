//! SPI3, by which an external DAC is reached, without its pins: how long bytes take.
//!
//! In: nothing. Out: a line: cycles of the core from a byte to its flag RXP, the same of nine
//! bytes, and CPHA and CPOL as they are read back. Owns SPI3. Fails: a byte that does not come is 0
//! cycles.
use crate::core_facts::cycles_of;
use crate::report::Report;
use hal::stm32h743::spi;
use stm32_metapac::SPI3;

/// As many as its FIFO holds, and less (RM0433 50.4.1).
const MANY: usize = 9;
/// Looks at the flag.
const LOOKS: u32 = 2_000;

/// Sends so many bytes at once and receives as many.
#[inline(never)]
fn exchange(bytes: usize) -> bool {
    (0..bytes).for_each(|_| SPI3.txdr8().write_value(0));
    (0..bytes).all(|_| {
        let is_there = (0..LOOKS).any(|_| SPI3.sr().read().rxp());
        SPI3.rxdr8().read();
        is_there
    })
}

fn cycles(bytes: usize) -> i64 {
    let (cycles, is_whole) = cycles_of(|| exchange(bytes));
    if is_whole { cycles.into() } else { 0 }
}

/// See the module text.
pub fn report_to(report: &mut Report) {
    // SAFETY: this image opens it here alone; its pins stay as they are.
    let _ = unsafe { spi::open() };
    // The code is in the cache from then on.
    cycles(1);
    let (one, many) = (cycles(1), cycles(MANY));
    let settings = SPI3.cfg2().read();
    report.line("spi3", &[one, many, settings.cpha().to_bits().into(), settings.cpol().to_bits().into()]);
}
