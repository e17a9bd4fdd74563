//! The oldest Python is the same in all files.

use std::fs;
use std::path::Path;

#[test]
fn the_oldest_python_is_that_of_the_stable_interface() {
    let read = |path: &str| fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap();
    let (package, project) = (read("Cargo.toml"), read("pyproject.toml"));
    let line = project.lines().find(|line| line.starts_with("requires-python")).unwrap();
    let oldest = line.split('"').nth(1).unwrap().replace(['>', '=', '.'], "");
    assert!(package.contains(&format!("\"abi3-py{oldest}\"")), "{oldest}");
}
