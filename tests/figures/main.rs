//! Printed figures against judges of their own: formulas in f64 that know nothing of the program.

#![expect(clippy::unwrap_used, reason = "a test's helper may panic")]

mod bounds;
mod depression;
mod judge;
mod program;
mod side_lobes;
mod silence;
