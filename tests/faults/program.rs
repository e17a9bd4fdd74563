//! The program as a process, for tests of what goes on around it.

use std::path::Path;
use std::process::{Command, Stdio};

pub const PROGRAM: &str = env!("CARGO_BIN_EXE_sonoglyph");

/// A focus that is found at once, and moves.
pub const SCENE: &str = "format = 1\n[[target]]\nat = [0.01, 0.02, 0.1]\n[solver]\nmethod = \"focus\"\n\
                     [motion]\npath = \"circle\"\nframes = 6\n";

/// The program in this folder, with nothing of the desktop that the tests run on.
pub fn program(folder: &Path, args: &[&str]) -> Command {
    let mut command = Command::new(PROGRAM);
    at_home(&mut command, folder).args(args);
    command
}

/// The program, begun by a shell that does this first.
pub fn program_after(first: &str, folder: &Path, args: &[&str]) -> Command {
    let mut command = Command::new("sh");
    at_home(&mut command, folder).args(["-c", &format!("{first}; exec \"$0\" \"$@\""), PROGRAM]).args(args);
    command
}

pub fn at_home<'a>(command: &'a mut Command, folder: &Path) -> &'a mut Command {
    command
        .current_dir(folder)
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env("XDG_STATE_HOME", folder.join("state"))
        .env("XDG_RUNTIME_DIR", folder)
        .env("NODEVICE_SELECT", "1")
        .stdin(Stdio::null())
}
