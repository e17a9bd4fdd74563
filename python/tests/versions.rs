//! The package's version, Rust and Python are the same in all files.

use std::fs;
use std::path::Path;

/// The value of a line `key = "value"`.
fn value(text: &str, key: &str) -> String {
    let line = text.lines().find(|line| line.starts_with(&format!("{key} = "))).unwrap_or_default();
    line.split('"').nth(1).unwrap_or_else(|| panic!("no {key}")).to_owned()
}

#[test]
fn package_and_program_share_their_versions() {
    let python = Path::new(env!("CARGO_MANIFEST_DIR"));
    let read = |path: &str| fs::read_to_string(python.join(path)).unwrap();
    let (package, program, project) = (read("Cargo.toml"), read("../Cargo.toml"), read("pyproject.toml"));
    for key in ["version", "edition", "rust-version", "license"] {
        assert_eq!(value(&package, key), value(&program, key), "{key}");
    }
    let oldest = value(&project, "requires-python").replace(['>', '=', '.'], "");
    assert!(package.contains(&format!("\"abi3-py{oldest}\"")), "{oldest}");
}
