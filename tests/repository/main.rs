//! The repository itself: rules that a compiler does not hold, documents that say what the program does, licences.

#![expect(clippy::unwrap_used, reason = "a test's helper may panic")]

mod architecture;
mod docs;
mod licences;
