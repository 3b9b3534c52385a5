#![no_std]
#![forbid(unsafe_code)]
//! What travels on the host link.
pub mod command;
pub mod reason;
