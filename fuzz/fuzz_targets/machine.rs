#![no_main]
//! See `fuzz::machine`.
libfuzzer_sys::fuzz_target!(|data: &[u8]| fuzz::machine::run(data));
