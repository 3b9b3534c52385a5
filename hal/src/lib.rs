#![no_std]
//! The boards: what `servo` needs from a machine, by the peripherals of each board.
//!
//! In: register accesses of one board. Out: [`servo::port::Port`], byte streams, the tick's timer.
//! Owns every `unsafe` register access, the [`priority`] table and the one [`mask`] by which the
//! thread keeps interrupts out. Fails never after bring-up; what a peripheral that does not answer
//! leads to is on the board's page (`docs/board-*.md`). A feature chooses the board. What a board
//! must provide is one list (`provides.rs`).
#[cfg(feature = "stm32h743")]
pub mod dac8563;
pub mod guard;
pub mod mask;
#[cfg(feature = "mps2_an500")]
pub mod mps2_an500;
pub mod priority;
mod provides;
#[cfg(feature = "stm32h743")]
mod startup_stack;
#[cfg(feature = "stm32h743")]
pub mod stm32h743;

#[cfg(feature = "mps2_an500")]
pub use mps2_an500 as board;
#[cfg(all(feature = "stm32h743", not(feature = "mps2_an500")))]
pub use stm32h743 as board;
