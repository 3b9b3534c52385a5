//! Whether the chip is in the package of the board that the image is for. Boards with the same chip
//! in another package have other signals at the same pins.
//!
//! In: SYSCFG_PKGR (RM0433 12.3.13). Out: yes or no. Owns nothing. On another package only the
//! lines of USB are opened, and the reason is reported over it.
use super::boards::BOARD;
use stm32_metapac::{RCC, SYSCFG};

/// What is reported on another package.
pub const OTHER: &str = BOARD.package.other;

/// Whether the package is another one.
pub fn is_other() -> bool {
    RCC.apb4enr().modify(|w| w.set_syscfgen(true));
    // Read back, so that the clock is on (RM0433 8.5.8).
    RCC.apb4enr().read();
    SYSCFG.pkgr().read().pkg() != BOARD.package.code
}
