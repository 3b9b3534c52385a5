//! The independent watchdog, and the cause of the last reset (RM0433 44, 8.4.4).
//!
//! In: feeding. Out: a reset if it is not fed for [`BITES_AFTER_MS`]. Owns IWDG1 and RCC_RSR. Fails
//! never: it cannot be stopped once it runs. LSI, which clocks it, is accurate to some percent.
use stm32_metapac::iwdg::vals::{Key, Pr};
use stm32_metapac::{IWDG1, RCC};

/// It resets the chip when it is not fed for this long.
pub const BITES_AFTER_MS: u32 = 100;

/// Counts of LSI (32 kHz) over 4.
const COUNTS: u16 = (BITES_AFTER_MS * 8 - 1) as u16;

/// Starts it.
pub fn start() {
    IWDG1.kr().write(|w| w.set_key(Key::START));
    IWDG1.kr().write(|w| w.set_key(Key::ENABLE));
    IWDG1.pr().write(|w| w.set_pr(Pr::DIVIDE_BY4));
    IWDG1.rlr().write(|w| w.set_rl(COUNTS));
    // Both have reached LSI's clock domain (RM0433 44.4.4).
    while IWDG1.sr().read().0 != 0 {}
    feed();
}

/// The time counts from now.
pub fn feed() {
    IWDG1.kr().write(|w| w.set_key(Key::RESET));
}

/// Why the chip started.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResetCause {
    /// Power-on: the contents of RAM are undefined.
    Power,
    /// The watchdog.
    Watchdog,
    /// The image, the reset button or a debugger.
    Asked,
}

/// Why the chip started; the first call clears it, later ones give [`ResetCause::Asked`].
pub fn cause() -> ResetCause {
    let flags = RCC.rsr().read();
    RCC.rsr().modify(|w| w.set_rmvf(true));
    if flags.porrstf() || flags.borrstf() {
        ResetCause::Power
    } else if flags.iwdg1rstf() {
        ResetCause::Watchdog
    } else {
        ResetCause::Asked
    }
}
