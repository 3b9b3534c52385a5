#![no_main]
//! See `fuzz::jobs`.
libfuzzer_sys::fuzz_target!(|data: &[u8]| fuzz::jobs::run(data));
