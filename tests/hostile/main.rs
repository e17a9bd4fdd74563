//! Input that harms: outputs that are inputs, surplus values, files without end, escape sequences, tables beyond all memory. Each gets
//! one short message and status 2, and nothing is touched.

#![cfg(target_os = "linux")]
#![expect(clippy::unwrap_used, reason = "a test's helper may panic")]

#[cfg(feature = "serial")]
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
use std::process::{Command, Output, Stdio};

use tempfile::TempDir;

const PROGRAM: &str = env!("CARGO_BIN_EXE_sonoglyph");

/// Bytes that a message may have.
const LONGEST: usize = 2000;

/// A focus that is found at once, and moves.
const SCENE: &str = "format = 1\n[[target]]\nat = [0.01, 0.02, 0.1]\n[solver]\nmethod = \"focus\"\n\
                     [motion]\npath = \"circle\"\nframes = 6\n";

/// The program in this folder, with nothing of the desktop that the tests run on.
fn program(folder: &Path, args: &[&str]) -> Command {
    let mut command = Command::new(PROGRAM);
    at_home(&mut command, folder).args(args);
    command
}

/// The program, begun by a shell that does this first.
fn program_after(first: &str, folder: &Path, args: &[&str]) -> Command {
    let mut command = Command::new("sh");
    at_home(&mut command, folder).args(["-c", &format!("{first}; exec \"$0\" \"$@\""), PROGRAM]).args(args);
    command
}

fn at_home<'a>(command: &'a mut Command, folder: &Path) -> &'a mut Command {
    command
        .current_dir(folder)
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env("XDG_STATE_HOME", folder.join("state"))
        .env("XDG_RUNTIME_DIR", folder)
        .env("NODEVICE_SELECT", "1")
        .stdin(Stdio::null())
}

/// A folder with files in it.
fn folder_with(files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

/// All files below a folder, with what they hold.
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

/// The one message of a command that must fail as bad input does; nothing in the folder has changed.
fn refused(folder: &Path, command: &mut Command) -> String {
    let before = contents(folder);
    let message = message_of(&command.output().unwrap());
    assert!(contents(folder) == before, "{command:?} has changed something: {message}");
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
