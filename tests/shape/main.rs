//! Shapes: strokes evenly loud and the rest of the plane quiet, judged in f64 by formulae written out plainly.

#![expect(clippy::unwrap_used, reason = "a test's helper may panic")]

mod areas;
mod command;
#[path = "../process/mod.rs"]
mod process;
mod solver;
