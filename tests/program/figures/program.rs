//! Runs of the program on random scenes, and numbers in its output.

use std::path::Path;

use serde_json::Value;
use tempfile::TempDir;

use crate::process::{folder_with, output_of};

/// Number of random scenes; `SONOGLYPH_FIGURES=100` sets it.
pub fn scenes() -> usize {
    std::env::var("SONOGLYPH_FIGURES").map_or(6, |count| count.parse().unwrap())
}

/// A folder with one scene, `a.toml`.
pub fn folder(scene: &str) -> TempDir {
    folder_with(&[("a.toml", scene)])
}

/// The output of `solve --json`.
pub fn solved(folder: &Path) -> Value {
    serde_json::from_str(&output_of(folder, &["solve", "a.toml", "--json"]).0).unwrap()
}

/// The number after these words, or at the beginning for no words, and the text after it.
pub fn number_after(text: &str, words: &str) -> (f64, String) {
    let rest = text.split_once(words).unwrap_or_else(|| panic!("no {words:?} in {text}")).1.trim_start();
    let end = rest.find(|c: char| !(c.is_ascii_digit() || ".-e".contains(c))).unwrap_or(rest.len());
    let number = rest[..end].trim_end_matches('.');
    (number.parse().unwrap_or_else(|_| panic!("{words}: {rest}")), rest[end..].to_owned())
}
