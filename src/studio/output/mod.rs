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

/// Writes what can be made again: the old file stands until the new one is whole.
///
/// # Errors
/// What the system says, of the file that was named.
pub fn write(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    write_by(path, |file| Ok(file.write_all(bytes)?))
}

/// A line on standard output, where results go: `say!("{count} frames")?`. Unlike `println!` it does not panic where nothing
/// reads or the disk is full, and what it quotes steers no terminal.
#[cfg(not(target_arch = "wasm32"))]
macro_rules! say {
    ($($line:tt)*) => { $crate::studio::output::say_line(&format!($($line)*)) };
}
#[cfg(not(target_arch = "wasm32"))]
pub(crate) use say;

/// What `say!` does.
///
/// # Errors
/// As [`print()`].
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

/// Standard output was closed when the program began. Rust then opens /dev/null in its place, and all seems well.
static IS_CLOSED: AtomicBool = AtomicBool::new(false);

/// Looks whether standard output is open. Only what runs before `main` sees it as the caller left it.
pub fn look_at_standard() {
    #[cfg(unix)]
    {
        // Another handle to the same description needs no unsafe code, and fails if there is none.
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

/// Why standard output takes no more. A closed pipe is no fault, and `main` knows that by the error below.
pub fn unsaid(error: io::Error) -> anyhow::Error {
    anyhow::Error::new(error).context("standard output: cannot write")
}

/// A message on standard error, where all is said that is no result: one line, and not a long one. If that cannot be written,
/// nothing can report it.
pub fn mention(text: &str) {
    let _ = writeln!(io::stderr(), "{}", echo::message(text));
}

/// Says something that is no result and no error.
pub fn note(text: &str) {
    mention(&format!("note: {text}"));
}

/// Says that a result may not be what was hoped for.
pub fn warn(text: &str) {
    mention(&format!("warning: {text}"));
}
