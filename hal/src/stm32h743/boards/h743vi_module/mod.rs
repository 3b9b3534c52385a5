//! A bare module with an STM32H743VIT6 (LQFP100), a crystal of 25 MHz and a USB socket:
//! `docs/board-h743vi.md`. USB is the host link, and supplies the module.
//!
//! The pins are chosen so that memory chips of common modules stay unselected, and so that no line
//! of a laser is at its lit level while the chip's own bootloader (DFU) runs.
use super::super::wiring::{Break, Package, Source, Usb, Wiring, contradictions};
use stm32_metapac::{GPIOA, GPIOB, GPIOC, GPIOD, GPIOE};

/// The board.
pub const BOARD: Wiring = Wiring {
    names: ["h743vi-module", "h743vi-dac8563"],
    package: Package::LQFP100,
    source: Source { is_crystal: true, mhz: 25, lost: "the crystal has stopped" },
    steps: GPIOE,
    enable: &[(GPIOD, 0), (GPIOD, 1), (GPIOD, 3), (GPIOD, 5), (GPIOD, 8), (GPIOD, 9), (GPIOD, 10), (GPIOD, 11)],
    // Axes 1 to 4; the package has no pins for more.
    limit_positive: &[(GPIOB, 7), (GPIOB, 8), (GPIOB, 9), (GPIOB, 14)],
    limit_negative: &[(GPIOA, 3), (GPIOA, 7), (GPIOA, 10), (GPIOA, 15)],
    home: &[(GPIOC, 0), (GPIOC, 1), (GPIOC, 4), (GPIOC, 5)],
    alarm: &[(GPIOB, 15), (GPIOC, 6), (GPIOD, 15), (GPIOD, 7)],
    general_in: &[(GPIOC, 13), (GPIOD, 4)],
    general_out: &[(GPIOD, 2), (GPIOB, 3), (GPIOB, 2)],
    lasers: [
        ((GPIOA, 8), 1),
        ((GPIOB, 13), 1),
        ((GPIOA, 2), 4),
        ((GPIOA, 1), 4),
        ((GPIOC, 7), 3),
        ((GPIOB, 0), 3),
        ((GPIOC, 8), 3),
        ((GPIOB, 1), 3),
    ],
    breaks: [
        Break { pin: ((GPIOB, 12), 1), texts: contradictions!("TIM1", "PB12") },
        Break { pin: ((GPIOA, 0), 4), texts: contradictions!("TIM15", "PA0") },
        Break { pin: ((GPIOA, 6), 3), texts: contradictions!("TIM8", "PA6") },
    ],
    link: [((GPIOB, 10), 7), ((GPIOB, 11), 7)],
    encoders: [((GPIOB, 4), 2), ((GPIOB, 5), 2), ((GPIOD, 12), 2), ((GPIOD, 13), 2)],
    indexes: [((GPIOC, 9), 2), ((GPIOD, 14), 2)],
    dac: [((GPIOC, 10), 6), ((GPIOC, 12), 6)],
    dac_select: (GPIOC, 11),
    // Few modules lead the host's 5 V to a pin of the chip.
    usb: Usb { lines: [((GPIOA, 11), 10), ((GPIOA, 12), 10)], vbus: None, milliamperes: 500 },
    driven_low: &[],
    // Chip selects of memory chips on common modules.
    pulled_up: &[(GPIOB, 6), (GPIOD, 6)],
    led: None,
};
