//! Runs of the program in a temporary folder, expected to succeed or to refuse bad input.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tempfile::TempDir;

/// A focus with a fast solution.
pub const POINT: &str = "format = 1\n[[target]]\nat = [0.01, 0.02, 0.1]\n[solver]\nmethod = \"focus\"\n";

/// The path of one of the repository's scenes.
pub fn example(name: &str) -> String {
    format!("{}/assets/scenes/{name}.toml", env!("CARGO_MANIFEST_DIR"))
}

pub fn folder_with(files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

pub fn program(folder: &Path, args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sonoglyph"));
    command.args(args).current_dir(folder);
    command
}

pub fn run(folder: &Path, args: &[&str]) -> Output {
    program(folder, args).output().unwrap()
}

/// Standard output and error of a command that must succeed.
pub fn output_of(folder: &Path, args: &[&str]) -> (String, String) {
    let output = run(folder, args);
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    let (out, error) = (text(output.stdout), text(output.stderr));
    assert!(output.status.success(), "{args:?}: {error}");
    (out, error)
}

/// Standard output of a command that must succeed.
pub fn succeed(folder: &Path, args: &[&str]) -> String {
    output_of(folder, args).0
}

/// The message of a command that must refuse its input and leave no file.
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
