//! Checks of numbers against limits, with errors that name the key.

use std::fmt;

use glam::DVec3;

/// m; lengths beyond are slips of the unit, not scenes.
const LONGEST: f64 = 100.0;

/// One step of the way to a key in the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Key {
    Name(&'static str),
    Index(usize),
}

impl From<&'static str> for Key {
    fn from(name: &'static str) -> Self {
        Self::Name(name)
    }
}

impl From<usize> for Key {
    fn from(index: usize) -> Self {
        Self::Index(index)
    }
}

/// The error of a key's value. [`crate::scene::file`] adds file, line and value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeyError {
    pub path: Vec<Key>,
    pub message: String,
}

impl KeyError {
    pub fn new(path: impl Into<Vec<Key>>, message: impl Into<String>) -> Self {
        Self { path: path.into(), message: message.into() }
    }

    /// The same error seen from one level further up.
    pub fn under(mut self, above: &[Key]) -> Self {
        self.path.splice(0..0, above.iter().cloned());
        self
    }

    /// The path as displayed: `target[1].radius`, with tables counted from 1.
    pub fn key(&self) -> String {
        let mut text = String::new();
        for key in &self.path {
            match key {
                Key::Name(name) if text.is_empty() => text.push_str(name),
                Key::Name(name) => text.push_str(&format!(".{name}")),
                Key::Index(index) => text.push_str(&format!("[{}]", index + 1)),
            }
        }
        text
    }
}

impl fmt::Display for KeyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.key(), self.message)
    }
}

impl std::error::Error for KeyError {}

/// An error at a key.
pub fn refuse<T>(key: &'static str, message: impl Into<String>) -> Result<T, KeyError> {
    Err(KeyError::new([Key::from(key)], message))
}

/// A number between two bounds.
pub fn within(key: &'static str, value: f64, least: f64, most: f64, unit: &str) -> Result<(), KeyError> {
    if value.is_finite() && (least..=most).contains(&value) {
        return Ok(());
    }
    refuse(key, format!("must be a number from {least} to {most} {unit}"))
}

/// A whole number between two bounds.
pub fn count(key: &'static str, value: u64, least: u64, most: u64) -> Result<(), KeyError> {
    if (least..=most).contains(&value) {
        return Ok(());
    }
    refuse(key, format!("must be a whole number from {least} to {most}"))
}

/// A length of some size.
pub fn length(key: &'static str, value: f64) -> Result<(), KeyError> {
    if value.is_finite() && value > 0.0 && value <= LONGEST {
        return Ok(());
    }
    refuse(key, format!("must be a length in metres, more than 0 and at most {LONGEST}"))
}

/// Any number.
pub fn finite(key: &'static str, value: f64) -> Result<(), KeyError> {
    if value.is_finite() { Ok(()) } else { refuse(key, "must be a finite number") }
}

/// A position.
pub fn point(key: &'static str, value: DVec3) -> Result<(), KeyError> {
    if value.is_finite() && value.abs().max_element() <= LONGEST {
        return Ok(());
    }
    refuse(key, format!("must be a point in metres, every coordinate from -{LONGEST} to {LONGEST}"))
}

/// A direction vector.
pub fn direction(key: &'static str, value: DVec3) -> Result<(), KeyError> {
    if value.is_finite() && value.try_normalize().is_some() {
        return Ok(());
    }
    refuse(key, "must be a direction: three finite numbers, not all zero")
}
