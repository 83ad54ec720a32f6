#![no_main]

libfuzzer_sys::fuzz_target!(init: boxwood_fuzz::alone(), |bytes: &[u8]| boxwood_fuzz::targets::saved(bytes));
