//! Errors of tables, with their lines.

/// An error with its line, counted from 1. Displayed as `line: reason`, to follow the file's name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{line}: {reason}")]
pub struct TableError {
    pub line: u64,
    pub reason: String,
}

impl TableError {
    /// An error of a file as a whole.
    pub(crate) fn of_file(reason: impl Into<String>) -> Self {
        Self { line: 1, reason: reason.into() }
    }
}
