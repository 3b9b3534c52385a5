//! The boards with this chip: a folder each. A feature chooses one.
//!
//! In: nothing. Out: [`BOARD`]. Owns nothing. A further board is a copy of one of these folders
//! (docs/guides/add-a-board.md).
#[cfg(feature = "h743vi_module")]
mod h743vi_module;
#[cfg(all(feature = "nucleo_h743zi2", not(feature = "h743vi_module")))]
mod nucleo_h743zi2;

#[cfg(feature = "h743vi_module")]
pub use h743vi_module::BOARD;
#[cfg(all(feature = "nucleo_h743zi2", not(feature = "h743vi_module")))]
pub use nucleo_h743zi2::BOARD;

#[cfg(not(any(feature = "nucleo_h743zi2", feature = "h743vi_module")))]
compile_error!("which board: feature nucleo_h743zi2 or h743vi_module");

const _: () = assert!(BOARD.is_sound(), "more pins of a kind than axes");
const _: () = assert!(!BOARD.uses_a_pin_twice(), "a pin has two uses");

/// The check itself: on a board with one use more, each of these is found.
const _: () = {
    use super::wiring::{Pin, Wiring};
    const ENABLE: &[Pin] = &[BOARD.enable[0]];
    const LASER: &[Pin] = &[BOARD.lasers[7].0];
    const STEP: &[Pin] = &[(BOARD.steps, 15)];
    let twice = [
        Wiring { driven_low: ENABLE, ..BOARD },
        Wiring { pulled_up: LASER, ..BOARD },
        Wiring { general_in: STEP, ..BOARD },
        Wiring { dac_select: BOARD.breaks[2].pin.0, ..BOARD },
        // PA4, of DAC1.
        Wiring { driven_low: &[(stm32_metapac::GPIOA, 4)], ..BOARD },
    ];
    let mut n = 0;
    while n < twice.len() {
        assert!(twice[n].uses_a_pin_twice());
        n += 1;
    }
};
