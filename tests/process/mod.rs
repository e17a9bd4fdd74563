//! The program as its users and their scripts call it.

use std::path::Path;
use std::process::{Command, Output};

pub fn run(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_sonoglyph")).args(args).current_dir(folder).output().unwrap()
}

/// What a command that must succeed prints.
pub fn succeed(folder: &Path, args: &[&str]) -> String {
    let output = run(folder, args);
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}
