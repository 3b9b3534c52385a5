//! The independent watchdog, and what a reset was (RM0433 44, 8.4.4).
//!
//! In: signs of life. Out: a reset if none comes for [`BITES_AFTER_MS`]. Owns IWDG1 and RCC_RSR. It cannot be stopped
//! once it runs; LSI, which it counts by, is right to some percent.
use stm32_metapac::iwdg::vals::{Key, Pr};
use stm32_metapac::{IWDG1, RCC};

/// Without a sign of life for this long it resets the chip.
pub const BITES_AFTER_MS: u32 = 100;

/// Counts of LSI (32 kHz) over 4.
const COUNTS: u16 = (BITES_AFTER_MS * 8 - 1) as u16;

/// Lets it run.
pub fn start() {
    IWDG1.kr().write(|w| w.set_key(Key::START));
    IWDG1.kr().write(|w| w.set_key(Key::ENABLE));
    IWDG1.pr().write(|w| w.set_pr(Pr::DIVIDE_BY4));
    IWDG1.rlr().write(|w| w.set_rl(COUNTS));
    // Both have reached LSI's side (RM0433 44.4.4).
    while IWDG1.sr().read().0 != 0 {}
    feed();
}

/// The time counts from now.
pub fn feed() {
    IWDG1.kr().write(|w| w.set_key(Key::RESET));
}

/// Why the chip started.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// The supply came: what RAM holds is chance.
    Power,
    /// The watchdog bit.
    Watchdog,
    /// The image, the reset button or a debugger.
    Asked,
}

/// Why the chip started, told once: later it is [`Cause::Asked`].
pub fn cause() -> Cause {
    let flags = RCC.rsr().read();
    RCC.rsr().modify(|w| w.set_rmvf(true));
    if flags.porrstf() || flags.borrstf() {
        Cause::Power
    } else if flags.iwdg1rstf() {
        Cause::Watchdog
    } else {
        Cause::Asked
    }
}
