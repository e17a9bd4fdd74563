//! The real program under real faults: full disks, signals, lost drivers and boards, little memory, hostile input.

#![cfg(target_os = "linux")]
#![expect(clippy::unwrap_used, reason = "a test's helper may panic")]

#[path = "../dice/mod.rs"]
#[expect(dead_code, reason = "used by other test binaries")]
mod dice;
mod disk;
mod gpu;
mod hostile;
mod line;
mod memory;
mod place;
mod program;
#[path = "../requirement/mod.rs"]
mod requirement;
#[path = "../running/mod.rs"]
mod running;
mod screen;
mod signal;
#[path = "../waiting/mod.rs"]
mod waiting;
#[cfg(feature = "window")]
mod window;

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use program::{PROGRAM, SCENE, at_home, program, program_after};
use running::Running;
use tempfile::TempDir;
use waiting::eventually;

/// A folder with the scene `a.toml` in it.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.toml"), SCENE).unwrap();
    folder
}

/// The names in a folder, including hidden ones.
fn listing(folder: &Path) -> Vec<String> {
    let name = |entry: std::io::Result<fs::DirEntry>| entry.unwrap().file_name().into_string().unwrap();
    let mut names: Vec<_> = fs::read_dir(folder).unwrap().map(name).collect();
    names.sort();
    names
}

/// The message of a command that must refuse its input: status 2, one line, no panic.
fn refused(command: &mut Command) -> String {
    message_of(&command.output().unwrap())
}

fn message_of(output: &Output) -> String {
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{:?}: {said}", output.status);
    let errors: Vec<_> = said.lines().filter(|line| line.starts_with("error: ")).collect();
    assert!(errors.len() == 1 && !said.contains("panicked"), "{said}");
    errors[0].to_owned()
}

fn succeed(command: &mut Command) -> String {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{:?}: {}", output.status, String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}
