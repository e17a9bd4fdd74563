//! Output files of a browser page: on its shelf, which offers them as downloads.

use std::io::Write;
use std::path::Path;

use anyhow::Context;

use crate::shelf;

/// Writes generated content, atomically.
///
/// # Errors
/// The errors of the shelf's keeper and of `fill`.
pub fn write_by(path: &Path, fill: impl FnOnce(&mut dyn Write) -> anyhow::Result<()>) -> anyhow::Result<()> {
    let mut bytes = Vec::new();
    fill(&mut bytes).with_context(|| path.display().to_string())?;
    shelf::write(path, bytes).with_context(|| path.display().to_string())
}

/// # Errors
/// The errors of [`write_by`].
pub fn save(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    write_by(path, |file| Ok(file.write_all(bytes)?))
}

/// All can be written.
///
/// # Errors
/// None.
pub fn check_writable(_: &Path) -> anyhow::Result<()> {
    Ok(())
}

/// A shelf has no streams.
///
/// # Errors
/// None.
pub fn refuse_stream(_: &Path) -> anyhow::Result<()> {
    Ok(())
}
