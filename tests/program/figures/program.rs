//! The program as its users run it, and random scenes for it.

use std::path::Path;

use serde_json::Value;
use tempfile::TempDir;

use crate::process::{folder_with, output_of};

/// Scenes of every kind; `SONOGLYPH_FIGURES=100` tries more.
pub fn scenes() -> u64 {
    std::env::var("SONOGLYPH_FIGURES").map_or(6, |count| count.parse().unwrap())
}

/// A folder with one scene, `a.toml`.
pub fn folder(scene: &str) -> TempDir {
    folder_with(&[("a.toml", scene)])
}

/// What `solve --json` prints of a scene.
pub fn solved(folder: &Path) -> Value {
    serde_json::from_str(&output_of(folder, &["solve", "a.toml", "--json"]).0).unwrap()
}

/// The number behind these words, or at the beginning if there are none, and what follows it.
pub fn number_after(text: &str, words: &str) -> (f64, String) {
    let rest = text.split_once(words).unwrap_or_else(|| panic!("no {words:?} in {text}")).1.trim_start();
    let end = rest.find(|c: char| !(c.is_ascii_digit() || ".-e".contains(c))).unwrap_or(rest.len());
    let number = rest[..end].trim_end_matches('.');
    (number.parse().unwrap_or_else(|_| panic!("{words}: {rest}")), rest[end..].to_owned())
}

/// SplitMix64 (Steele, Lea and Flood, OOPSLA 2014).
pub struct Dice(u64);

impl Dice {
    pub fn new(seed: u64, number: u64) -> Self {
        Self(seed ^ number.wrapping_mul(0xD1B5_4A32_D192_ED03))
    }

    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    pub fn one_of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[(self.unit() * choices.len() as f64) as usize]
    }
}
