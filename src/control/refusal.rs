//! Reasons for refusing an edit.

use thiserror::Error;

use crate::scene::KeyError;

/// A target's number, counted from 1 as in the window and in messages.
pub type Number = usize;

/// The reason for refusing an edit. None of its change was applied.
#[derive(Debug, Error)]
pub enum EditError {
    #[error("target {number}: the scene has {count}, counted from 1")]
    NoTarget { number: Number, count: usize },
    #[error("target {0}: only a text has letters")]
    NoText(Number),
    #[error("target {0}: a point has no angle")]
    NoAngle(Number),
    #[error("other programs may not name files: {0}")]
    NamesFile(String),
    #[error("{0}")]
    Value(String),
    #[error(transparent)]
    Scene(#[from] KeyError),
}
