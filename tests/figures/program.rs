//! The program as its users run it, and random scenes for it.

use std::path::Path;
use std::process::Command;

use serde_json::Value;
use tempfile::TempDir;

/// Scenes of every kind; `SONOGLYPH_FIGURES=100` tries more.
pub fn scenes() -> u64 {
    std::env::var("SONOGLYPH_FIGURES").map_or(6, |count| count.parse().unwrap())
}

/// A folder with one scene, `a.toml`.
pub fn folder(scene: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.toml"), scene).unwrap();
    folder
}

/// Standard output and error of a run that succeeds.
pub fn said(folder: &Path, args: &[&str]) -> (String, String) {
    let output =
        Command::new(env!("CARGO_BIN_EXE_sonoglyph")).args(args).current_dir(folder).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    let (out, error) = (text(output.stdout), text(output.stderr));
    assert!(output.status.success(), "{args:?}: {error}");
    (out, error)
}

/// What `solve --json` prints of a scene.
pub fn solved(folder: &Path) -> Value {
    serde_json::from_str(&said(folder, &["solve", "a.toml", "--json"]).0).unwrap()
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
