//! Harmful input is refused with one short message and status 2, and no file changes.

mod boards;
mod crowd;
mod generator;
mod lists;
mod memory;
mod outputs;
mod places;
mod terminal;

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use tempfile::TempDir;

/// Limit of a message, bytes.
const LONGEST: usize = 2000;

/// A folder with these files.
fn folder_with(files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

/// All files below a folder, with their contents.
fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let kind = fs::symlink_metadata(&path).unwrap();
        if kind.is_dir() {
            found.extend(contents(&path));
        } else if kind.is_file() {
            found.push((path.display().to_string(), fs::read(&path).unwrap()));
        } else {
            found.push((path.display().to_string(), Vec::new()));
        }
    }
    found.sort();
    found
}

/// The message of a command that must refuse its input and change no file.
fn refused(folder: &Path, command: &mut Command) -> String {
    let before = contents(folder);
    let message = message_of(&command.output().unwrap());
    assert!(contents(folder) == before, "{command:?} changed a file: {message}");
    message
}

fn message_of(output: &Output) -> String {
    let said = String::from_utf8(output.stderr.clone()).expect("messages are text");
    assert_eq!(output.status.code(), Some(2), "{:?}: {said}", output.status);
    let errors = said.lines().filter(|line| line.starts_with("error: ")).count();
    assert!(errors == 1 && !said.contains("panicked"), "{said}");
    assert!(said.len() < LONGEST, "{} bytes: {said}", said.len());
    said
}

fn make_pipe(path: &Path) {
    assert!(Command::new("mkfifo").arg(path).status().unwrap().success());
}
