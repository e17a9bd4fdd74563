//! A file being written. It has no name until it is complete, so a killed program leaves nothing behind; on systems
//! without unnamed files it has a temporary name.

use std::fs::{File, Metadata};
use std::io;
use std::path::Path;

use tempfile::{Builder, TempPath};

/// Prefix of draft names.
const PREFIX: &str = ".sonoglyph-";

#[derive(Debug)]
pub struct Draft {
    file: File,
    /// Removed with the draft unless published.
    name: Option<TempPath>,
}

impl Draft {
    /// An empty file to be published in this folder, with the default mode of new files.
    ///
    /// # Errors
    /// No file can be created there.
    pub fn new(folder: &Path) -> io::Result<Self> {
        if let Some(file) = nameless(folder) {
            return Ok(Self { file, name: None });
        }
        let mut builder = Builder::new();
        // Temporary files are private by default; this applies the umask as for ordinary files.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let (file, name) = builder.prefix(PREFIX).tempfile_in(folder)?.into_parts();
        Ok(Self { file, name: Some(name) })
    }

    pub fn file(&self) -> &File {
        &self.file
    }

    /// Copies owner and mode of the file to be replaced, as far as permitted.
    pub fn resemble(&self, there: &Metadata) {
        #[cfg(unix)]
        {
            use std::os::unix::fs::{MetadataExt, fchown};
            // Only root can change owners, and only members can set a group.
            let _ = fchown(&self.file, Some(there.uid()), Some(there.gid()));
        }
        let _ = self.file.set_permissions(there.permissions());
    }

    /// Gives it its name in its folder, atomically replacing an existing file.
    ///
    /// # Errors
    /// A system error; then nothing has changed.
    pub fn publish(self, path: &Path) -> io::Result<()> {
        let name = match self.name {
            Some(name) => name,
            None => match link(&self.file, path) {
                // Only renaming replaces a file, and for that it needs a name for a moment.
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                    let folder = path.parent().filter(|folder| *folder != Path::new(""));
                    let made = Builder::new()
                        .prefix(PREFIX)
                        .make_in(folder.unwrap_or(Path::new(".")), |name| link(&self.file, name));
                    made?.into_temp_path()
                }
                linked => return linked,
            },
        };
        name.persist(path).map_err(|error| error.error)
    }
}

/// An unnamed file. `None` if the system or the disk does not support it.
#[cfg(target_os = "linux")]
fn nameless(folder: &Path) -> Option<File> {
    use rustix::fs::{Mode, OFlags, open};
    // Without this folder it could not be named later.
    if !Path::new(OPEN_FILES).is_dir() {
        return None;
    }
    let flags = OFlags::TMPFILE | OFlags::WRONLY | OFlags::CLOEXEC;
    open(folder, flags, Mode::from_raw_mode(0o666)).ok().map(File::from)
}

#[cfg(not(target_os = "linux"))]
fn nameless(_: &Path) -> Option<File> {
    None
}

/// The folder of a process' open files on Linux.
#[cfg(target_os = "linux")]
const OPEN_FILES: &str = "/proc/self/fd";

/// Gives an unnamed file an unused name.
#[cfg(target_os = "linux")]
fn link(file: &File, path: &Path) -> io::Result<()> {
    use std::os::fd::AsRawFd;

    use rustix::fs::{AtFlags, CWD, linkat};
    let open = Path::new(OPEN_FILES).join(file.as_raw_fd().to_string());
    Ok(linkat(CWD, &open, CWD, path, AtFlags::SYMLINK_FOLLOW)?)
}

#[cfg(not(target_os = "linux"))]
fn link(_: &File, _: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}
