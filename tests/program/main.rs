//! The program as users and scripts call it: a module per command or kind of output.

#![expect(clippy::unwrap_used, reason = "a test's helper may panic")]

mod arrays;
mod batch;
mod bodies;
mod contract;
#[path = "../dice/mod.rs"]
#[expect(dead_code, reason = "used by other test binaries")]
mod dice;
mod drives;
mod elements;
mod examples;
mod felt;
mod figures;
#[cfg(unix)]
mod film;
mod force;
mod help;
mod liquid;
#[cfg(unix)]
mod measuring;
mod motion;
mod plots;
mod process;
#[path = "../requirement/mod.rs"]
mod requirement;
mod shape;
mod time_course;
mod volume;
