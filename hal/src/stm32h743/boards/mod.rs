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
