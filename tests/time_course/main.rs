//! The sound at points in the course of time, and the lines of its spectrum, judged in f64 by formulae written out plainly.

#![expect(clippy::unwrap_used, reason = "a test's helper may panic")]

mod command;
mod lines;
#[path = "../process/mod.rs"]
mod process;
#[path = "../process/refusal.rs"]
mod refusal;
