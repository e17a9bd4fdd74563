//! Scenes and bytes that nobody chose: random scenes from end to end, any bytes from outside, and numbers that are none.

#![expect(clippy::unwrap_used, reason = "a test's helper may panic")]

#[path = "../dice/mod.rs"]
mod dice;
mod fuzz;
mod poison;
mod random;
#[path = "../requirement/mod.rs"]
mod requirement;
