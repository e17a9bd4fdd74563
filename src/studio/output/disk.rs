//! Atomic files on disk.

use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};

use anyhow::anyhow;

use crate::studio::output::draft::Draft;

/// Writes generated content, atomically.
///
/// # Errors
/// A system error with the named file, and errors of `fill`.
pub fn write_by(path: &Path, fill: impl FnOnce(&mut dyn Write) -> anyhow::Result<()>) -> anyhow::Result<()> {
    of_file(path, write_whole(path, fill, |_| Ok(())))
}

/// Writes irreplaceable content: after return, a power cut loses neither it nor the old file.
///
/// # Errors
/// The errors of [`write_by`].
pub fn save(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    of_file(path, write_whole(path, |file| Ok(file.write_all(bytes)?), File::sync_all))?;
    // Synchronises the folder, too, where supported; the file itself is already safe.
    let _ = followed(path).and_then(|path| File::open(folder_of(&path))?.sync_all());
    Ok(())
}

/// Fails early if [`write_by`] would fail after the work.
///
/// # Errors
/// The errors of [`write_by`].
pub fn check_writable(path: &Path) -> anyhow::Result<()> {
    of_file(path, check(path).map_err(Into::into))
}

/// For callers that must not block: opening a pipe waits for its reader.
///
/// # Errors
/// Something that is neither file nor folder exists at the path.
pub fn refuse_stream(path: &Path) -> anyhow::Result<()> {
    match fs::metadata(path) {
        Ok(there) if !there.is_file() && !there.is_dir() => {
            Err(anyhow!("{}: this is a device or a pipe, not a file", path.display()))
        }
        _ => Ok(()),
    }
}

fn check(path: &Path) -> io::Result<()> {
    match existing(path)? {
        // Opening a pipe twice would end it for its reader.
        Some(there) if !there.is_file() => Ok(()),
        there => draft_for(path, there.as_ref()).map(drop),
    }
}

fn write_whole(
    path: &Path,
    fill: impl FnOnce(&mut dyn Write) -> anyhow::Result<()>,
    settle: impl FnOnce(&File) -> io::Result<()>,
) -> anyhow::Result<()> {
    let there = existing(path)?;
    if there.as_ref().is_some_and(|there| !there.is_file()) {
        // A pipe, terminal or device is written directly, not replaced.
        let mut stream = BufWriter::new(OpenOptions::new().write(true).open(path)?);
        fill(&mut stream)?;
        return Ok(stream.flush()?);
    }
    let (draft, path) = draft_for(path, there.as_ref())?;
    let mut file = BufWriter::new(draft.file());
    fill(&mut file)?;
    file.flush()?;
    drop(file);
    settle(draft.file())?;
    Ok(draft.publish(&path)?)
}

/// The file at a path, through links; a folder is an error.
fn existing(path: &Path) -> io::Result<Option<Metadata>> {
    match fs::metadata(path) {
        Ok(there) if there.is_dir() => Err(ErrorKind::IsADirectory.into()),
        Ok(there) => Ok(Some(there)),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error),
    }
}

/// A draft beside the file behind a path, and that file's path. An existing file must be writable, and lends its
/// owner and mode.
fn draft_for(path: &Path, there: Option<&Metadata>) -> io::Result<(Draft, PathBuf)> {
    let path = followed(path)?;
    if there.is_some() {
        OpenOptions::new().write(true).open(&path)?;
    }
    let draft = Draft::new(folder_of(&path))?;
    if let Some(there) = there {
        draft.resemble(there);
    }
    Ok((draft, path))
}

/// The real path of a file: links are kept, and their target is written.
pub(super) fn followed(path: &Path) -> io::Result<PathBuf> {
    /// Link depth limit of Linux.
    const MOST: usize = 40;
    let mut path = path.to_owned();
    for _ in 0..MOST {
        if !fs::symlink_metadata(&path).is_ok_and(|there| there.is_symlink()) {
            return Ok(path);
        }
        path = folder_of(&path).join(fs::read_link(&path)?);
    }
    Err(io::Error::other("its links lead in a circle"))
}

/// Speaks of the file that the user named, not of the draft.
fn of_file(path: &Path, written: anyhow::Result<()>) -> anyhow::Result<()> {
    written.map_err(|error| match error.chain().find_map(|cause| cause.downcast_ref::<io::Error>()) {
        Some(cause) => anyhow!("{}: cannot write: {}", path.display(), reason(cause)),
        None => error.context(path.display().to_string()),
    })
}

/// Why the system refuses, for people.
fn reason(error: &io::Error) -> String {
    match (error.kind(), error.raw_os_error()) {
        (ErrorKind::StorageFull, _) => "the disk is full".to_owned(),
        (ErrorKind::FileTooLarge, _) => "files may not become that large here".to_owned(),
        (ErrorKind::NotFound, _) => "its folder is not there".to_owned(),
        (ErrorKind::PermissionDenied, _) => "permission denied".to_owned(),
        // Some of these have no kind in Rust, such as a failing disk.
        (_, Some(code)) => io::Error::from_raw_os_error(code).to_string(),
        (kind, None) => kind.to_string(),
    }
}

pub(super) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    }
}

/// From now on a file that outgrows the limit of the shell (`ulimit -f`) is an error like a full disk, not the end of the program.
///
/// # Errors
/// A system that refuses.
#[cfg(all(unix, feature = "cli"))]
pub fn outlive_file_limits() -> io::Result<()> {
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;

    use signal_hook::consts::SIGXFSZ;
    // The flag is never read: having a handler suffices, and child processes do not inherit it.
    signal_hook::flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false))).map(drop)
}

/// Files have no limits here.
///
/// # Errors
/// None.
#[cfg(all(not(unix), feature = "cli"))]
pub fn outlive_file_limits() -> io::Result<()> {
    Ok(())
}
