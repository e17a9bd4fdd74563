//! Commands that must fail as bad input does.

use std::fs;
use std::path::{Path, PathBuf};

use crate::process::run;

/// The message of such a command, which leaves nothing behind.
pub fn refuse(folder: &Path, args: &[&str]) -> String {
    let before = listing(folder);
    let output = run(folder, args);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{args:?}: {message}");
    assert!(!message.contains("panicked"), "{args:?}: {message}");
    assert!(!message.trim().is_empty(), "{args:?}");
    assert_eq!(listing(folder), before, "{args:?} left something behind");
    message
}

fn listing(folder: &Path) -> Vec<PathBuf> {
    let mut names: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    names.sort();
    names
}
