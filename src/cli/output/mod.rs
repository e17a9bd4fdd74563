//! Files are written whole or not at all.

use std::io::{BufWriter, Write};
use std::path::Path;

/// Writes through a temporary file beside the target and renames it.
pub fn write(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    write_by(path, |file| Ok(file.write_all(bytes)?))
}

/// The same for what is made while it is written.
pub fn write_by(path: &Path, fill: impl FnOnce(&mut dyn Write) -> anyhow::Result<()>) -> anyhow::Result<()> {
    write_file(path, fill).map_err(|error| match error.downcast::<std::io::Error>() {
        Ok(error) => refusal(path, &error),
        Err(error) => error.context(path.display().to_string()),
    })
}

fn write_file(path: &Path, fill: impl FnOnce(&mut dyn Write) -> anyhow::Result<()>) -> anyhow::Result<()> {
    if path.is_dir() {
        return Err(std::io::Error::from(std::io::ErrorKind::IsADirectory).into());
    }
    let folder = folder_of(path);
    let mut builder = tempfile::Builder::new();
    // A temporary file is private; the umask makes what comes out an ordinary one.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = BufWriter::new(builder.prefix(".sonoglyph-").tempfile_in(folder)?);
    fill(&mut file)?;
    let file = file.into_inner().map_err(|e| e.into_error())?;
    file.persist(path).map_err(|e| e.error)?;
    Ok(())
}

/// Fails early where [`write()`] would fail after the work.
pub fn check_writable(path: &Path) -> anyhow::Result<()> {
    let folder = folder_of(path);
    if path.is_dir() {
        return Err(refusal(path, &std::io::Error::from(std::io::ErrorKind::IsADirectory)));
    }
    tempfile::Builder::new()
        .prefix(".sonoglyph-")
        .tempfile_in(folder)
        .map_err(|error| refusal(path, &error))?;
    Ok(())
}

/// Speaks of the file that the user named, not of the temporary one.
fn refusal(path: &Path, error: &std::io::Error) -> anyhow::Error {
    anyhow::anyhow!("{}: cannot write: {}", path.display(), error.kind())
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    }
}
