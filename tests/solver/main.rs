//! The solver: methods against their definitions, properties of every method, shapes, and traps.

#![expect(clippy::unwrap_used, reason = "a test's helper may panic")]

#[path = "../dice/mod.rs"]
mod dice;
mod force;
mod methods;
mod properties;
mod shape;
