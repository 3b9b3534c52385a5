//! NUCLEO-H743ZI2 and NUCLEO-H753ZI: `docs/board-h743.md`. The ST-LINK gives the clock, 8 MHz, and
//! is the host link.
use super::super::wiring::{Break, Package, Source, Usb, Wiring, contradictions};
use stm32_metapac::{GPIOA, GPIOB, GPIOC, GPIOD, GPIOE, GPIOF, GPIOG};

/// The board.
pub const BOARD: Wiring = Wiring {
    names: ["nucleo-h743zi2", "h743zi2-dac8563"],
    package: Package::LQFP144,
    source: Source { is_crystal: false, mhz: 8, lost: "the ST-LINK's clock has stopped" },
    steps: GPIOF,
    enable: &[(GPIOG, 0), (GPIOG, 1), (GPIOG, 3), (GPIOG, 4), (GPIOG, 5), (GPIOG, 6), (GPIOG, 8), (GPIOG, 9)],
    limit_positive: &[
        (GPIOE, 0),
        (GPIOE, 2),
        (GPIOE, 6),
        (GPIOE, 7),
        (GPIOE, 10),
        (GPIOE, 11),
        (GPIOE, 12),
        (GPIOE, 13),
    ],
    limit_negative: &[(GPIOB, 2), (GPIOB, 3), (GPIOB, 6), (GPIOB, 7), (GPIOB, 8), (GPIOB, 9), (GPIOB, 11), (GPIOB, 12)],
    home: &[(GPIOD, 0), (GPIOD, 1), (GPIOD, 2), (GPIOD, 3), (GPIOD, 4), (GPIOD, 5), (GPIOD, 6), (GPIOD, 7)],
    alarm: &[(GPIOA, 0), (GPIOA, 3), (GPIOA, 6), (GPIOA, 15), (GPIOC, 0), (GPIOC, 6), (GPIOD, 11), (GPIOD, 15)],
    general_in: &[(GPIOC, 13), (GPIOE, 14), (GPIOC, 9)],
    // LD2, LD3, and four more.
    general_out: &[(GPIOE, 1), (GPIOB, 14), (GPIOG, 10), (GPIOG, 12), (GPIOG, 14), (GPIOG, 15)],
    lasers: [
        ((GPIOE, 9), 1),
        ((GPIOE, 8), 1),
        ((GPIOE, 5), 4),
        ((GPIOE, 4), 4),
        ((GPIOC, 7), 3),
        ((GPIOB, 0), 3),
        ((GPIOC, 8), 3),
        ((GPIOB, 15), 3),
    ],
    breaks: [
        Break { pin: ((GPIOE, 15), 1), texts: contradictions!("TIM1", "PE15") },
        Break { pin: ((GPIOE, 3), 4), texts: contradictions!("TIM15", "PE3") },
        Break { pin: ((GPIOG, 2), 3), texts: contradictions!("TIM8", "PG2") },
    ],
    link: [((GPIOD, 8), 7), ((GPIOD, 9), 7)],
    encoders: [((GPIOB, 4), 2), ((GPIOB, 5), 2), ((GPIOD, 12), 2), ((GPIOD, 13), 2)],
    indexes: [((GPIOB, 1), 2), ((GPIOD, 14), 2)],
    dac: [((GPIOC, 10), 6), ((GPIOC, 12), 6)],
    dac_select: (GPIOC, 11),
    // By the ST-LINK's cable or the board's own supply.
    usb: Usb { lines: [((GPIOA, 11), 10), ((GPIOA, 12), 10)], vbus: Some((GPIOA, 9)), milliamperes: 0 },
    // The switch of the USB connector's 5 V (UM2407): a device does not supply the bus.
    driven_low: &[(GPIOD, 10)],
    pulled_up: &[],
    // LD3, the red one.
    led: Some((GPIOB, 14)),
};
