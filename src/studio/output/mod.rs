//! Output of the program: atomic files, and lines on standard output and error.

#[cfg_attr(target_arch = "wasm32", path = "on_shelf.rs")]
mod disk;
#[cfg(not(target_arch = "wasm32"))]
mod draft;
#[cfg(not(target_arch = "wasm32"))]
mod files;

use std::fmt::Arguments;
use std::io::{self, StdoutLock, Write};
#[cfg(unix)]
use std::os::fd::AsFd;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::echo;
#[cfg(feature = "cli")]
pub use disk::outlive_file_limits;
pub use disk::{check_writable, refuse_stream, save, write_by};
#[cfg(not(target_arch = "wasm32"))]
pub use files::Files;

/// Writes reproducible content: the old file stays until the new one is complete.
///
/// # Errors
/// A system error, with the named file.
pub fn write(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    write_by(path, |file| Ok(file.write_all(bytes)?))
}

/// Prints a line on standard output, for results: `say!("{count} frames")?`. Unlike `println!` it does not panic on a
/// closed pipe or full disk, and quoted text cannot control the terminal.
#[cfg(not(target_arch = "wasm32"))]
macro_rules! say {
    ($($line:tt)*) => { $crate::studio::output::say_line(&format!($($line)*)) };
}
#[cfg(not(target_arch = "wasm32"))]
pub(crate) use say;

/// The implementation of `say!`.
///
/// # Errors
/// The errors of [`print()`].
pub fn say_line(line: &str) -> anyhow::Result<()> {
    print(format_args!("{}\n", echo::lines(line)))
}

/// Text on standard output, to the byte.
///
/// # Errors
/// It cannot be written.
pub fn print(text: Arguments<'_>) -> anyhow::Result<()> {
    let mut out = standard()?;
    out.write_fmt(text).and_then(|()| out.flush()).map_err(unsaid)
}

/// Whether standard output was closed at the start; Rust then silently opens /dev/null in its place.
static IS_CLOSED: AtomicBool = AtomicBool::new(false);

/// Checks whether standard output is open. Only code before `main` sees its original state.
pub fn look_at_standard() {
    #[cfg(unix)]
    {
        // Duplicating the handle needs no unsafe code, and fails if it is closed.
        let is_open = io::stdout().as_fd().try_clone_to_owned().is_ok();
        IS_CLOSED.store(!is_open, Ordering::Relaxed);
    }
}

/// Standard output.
///
/// # Errors
/// The caller has closed it.
pub fn standard() -> anyhow::Result<StdoutLock<'static>> {
    if IS_CLOSED.load(Ordering::Relaxed) {
        return Err(unsaid(io::Error::other("it is closed")));
    }
    Ok(io::stdout().lock())
}

/// The error of writing to standard output. A closed pipe is not a fault, recognised by `main` from the error below.
pub fn unsaid(error: io::Error) -> anyhow::Error {
    anyhow::Error::new(error).context("standard output: cannot write")
}

/// Prints a message on standard error, for everything that is not a result: one short line. Failures cannot be
/// reported.
pub fn mention(text: &str) {
    let _ = writeln!(io::stderr(), "{}", echo::message(text));
}

/// Prints a note.
pub fn note(text: &str) {
    mention(&format!("note: {text}"));
}

/// Prints a warning.
pub fn warn(text: &str) {
    mention(&format!("warning: {text}"));
}
