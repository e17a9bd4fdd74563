//! The repository itself: architecture rules, agreement of documents with the program, licences.

#![expect(clippy::unwrap_used, reason = "a test's helper may panic")]

mod architecture;
mod docs;
mod licences;
