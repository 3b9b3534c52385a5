//! The STM32H743 on its board, in emulation: boots the flash image and shows what its pins do. For
//! tests only.
//!
//! In: the ELF image, bytes of the host, levels at pins, time. Out: bytes of the board, every
//! change of a pin with its time, why it was reset, what the image did that the manual forbids or
//! no model covers. Instructions are executed by Unicorn (`libunicorn-dev`); all else is in here,
//! written after the Armv7-M Architecture Reference Manual and RM0433, and shares no code with the
//! image.
//!
//! What is not emulated: caches, bus contention and wait states (an instruction is a cycle).
#![deny(unsafe_code)]
pub mod accesses;
pub mod adc;
pub mod board;
pub mod bus;
pub mod clocks;
pub mod counted;
pub mod dac;
pub mod dac8563;
mod debugger;
pub mod device;
pub mod dma;
mod dwt;
#[allow(unsafe_code, reason = "Unicorn is a C library")]
pub mod engine;
pub mod exceptions;
pub mod facts;
mod frames;
pub mod gpio;
pub mod image;
pub mod link;
pub mod machine;
#[allow(unsafe_code, reason = "memory that Unicorn and the models share")]
pub mod memory;
pub mod scs;
pub mod spi;
pub mod supply;
pub mod time;
pub mod timer;
pub mod usart;
pub mod usb;
pub mod usb_host;
pub mod watchdog;
mod world;

pub use device::Cause;
pub use gpio::{Level, Pin};
pub use machine::{Machine, Stop};
pub use time::{MICROSECOND, MILLISECOND, Time};
