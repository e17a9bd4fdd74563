//! The solver: methods against their definitions, properties of every method, shapes, and traps.

#![expect(clippy::unwrap_used, reason = "a test's helper may panic")]

mod cancel;
#[path = "../../../tests/dice/mod.rs"]
#[expect(dead_code, reason = "used by other test binaries")]
mod dice;
mod felt;
mod force;
mod methods;
mod properties;
mod shape;
mod spread;
