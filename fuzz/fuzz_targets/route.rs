//! Fuzzes paths (tables of places, G-code).

#![no_main]

#[path = "../../tests/scenes/fuzz/targets/mod.rs"]
mod targets;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| targets::run("route", bytes));
