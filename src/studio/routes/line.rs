//! Errors in the lines of a file with a path, and the limits of its places.

use crate::scene::motion::Trace;

/// Places of a file, at most.
pub(super) const MOST_PLACES: usize = 1_000_000;
/// m: places farther away are slips of the unit.
pub(super) const FARTHEST: f64 = 10.0;

/// The traces of a file, with remarks on what was left aside in it.
pub type Traced = (Vec<Trace>, Vec<String>);

/// An error in a line of a file, counted from 1; displayed as `line: reason`, to follow the file's name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{line}: {reason}")]
pub struct LineError {
    pub line: u64,
    pub reason: String,
}

impl LineError {
    pub fn new(line: u64, reason: impl Into<String>) -> Self {
        Self { line, reason: reason.into() }
    }
}
