#![no_main]
//! See `fuzz::link`.
libfuzzer_sys::fuzz_target!(|data: &[u8]| fuzz::link::run(data));
