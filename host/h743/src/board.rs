//! The boards around the chip: what is outside of it, and which package it is in.
//!
//! In: nothing. Out: facts that the models are set to. Owns nothing.

/// A board.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Board {
    /// Frequency at the pins of the high-speed oscillator, in kHz.
    pub source_khz: u64,
    /// It is a crystal, which needs the oscillator; otherwise a clock, which bypasses it.
    pub has_crystal: bool,
    /// What SYSCFG_PKGR says of the package (ST's LL driver, `LL_SYSCFG_…_PACKAGE`).
    pub package: u32,
    /// Ports whose pins the package has, from A on.
    pub ports: usize,
    /// The host's 5 V reach the chip.
    pub leads_vbus: bool,
}

/// NUCLEO-H743ZI2: LQFP144, the ST-LINK's 8 MHz (UM2407).
pub const NUCLEO: Board = Board { source_khz: 8_000, has_crystal: false, package: 2, ports: 7, leads_vbus: true };

/// A module with an STM32H743VI: LQFP100, whose only pins beyond port E are those of the crystal
/// (DS12110, pinouts).
pub const MODULE: Board = Board { source_khz: 25_000, has_crystal: true, package: 0, ports: 5, leads_vbus: false };
