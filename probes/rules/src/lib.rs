#![no_std]
#![forbid(unsafe_code)]
//! Rules that hold because breaking them does not compile; the programs are in
//! `tests/must_not_compile`.
