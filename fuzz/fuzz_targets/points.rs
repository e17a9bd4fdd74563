//! Fuzzes points for `probe` (CSV).

#![no_main]

#[path = "../../tests/scenes/fuzz/targets/mod.rs"]
mod targets;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| targets::run("points", bytes));
