//! The program as a process, isolated from the desktop of the machine.

use std::path::Path;
use std::process::{Command, Stdio};

pub const PROGRAM: &str = env!("CARGO_BIN_EXE_sonoglyph");

/// A moving focus with a fast solution.
pub const SCENE: &str = "format = 1\n[[target]]\nat = [0.01, 0.02, 0.1]\n[solver]\nmethod = \"focus\"\n\
                     [motion]\npath = \"circle\"\nframes = 6\n";

/// The program in this folder, without the desktop's environment.
pub fn program(folder: &Path, args: &[&str]) -> Command {
    let mut command = Command::new(PROGRAM);
    at_home(&mut command, folder).args(args);
    command
}

/// The program, started by a shell after this command.
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
