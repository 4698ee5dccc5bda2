#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| bvbench_fuzz::run("stock", bytes));
