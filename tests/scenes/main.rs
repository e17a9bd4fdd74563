//! Arbitrary scenes and bytes: random scenes from end to end, fuzz targets, and invalid numbers.

#![expect(clippy::unwrap_used, reason = "a test's helper may panic")]

#[path = "../dice/mod.rs"]
mod dice;
mod fuzz;
mod poison;
mod random;
#[path = "../requirement/mod.rs"]
mod requirement;
mod skin;
