//! Fuzzes the native protocol: COBS and CRC, packets, replies, the device model.

#![no_main]

#[path = "../../tests/scenes/fuzz/targets/mod.rs"]
mod targets;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| targets::run("native", bytes));
