//! The in-memory file system of a browser page: files opened, dropped or written since the page was loaded.

use std::collections::BTreeMap;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

static FILES: Mutex<BTreeMap<PathBuf, Vec<u8>>> = Mutex::new(BTreeMap::new());
static KEEPER: OnceLock<Keeper> = OnceLock::new();

/// Called for each written (`Some` bytes) or removed (`None`) file.
pub type Keeper = Box<dyn Fn(&Path, Option<&[u8]>) -> io::Result<()> + Send + Sync>;

fn files() -> MutexGuard<'static, BTreeMap<PathBuf, Vec<u8>>> {
    FILES.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Sets the keeper, which offers or persists files; the first one stays.
pub fn keep_by(keeper: Keeper) {
    // Only the page's start sets it.
    let _ = KEEPER.set(keeper);
}

/// Stores a file without calling the keeper.
pub fn lay(path: &Path, bytes: Vec<u8>) {
    files().insert(path.to_owned(), bytes);
}

/// Writes a file.
///
/// # Errors
/// The errors of the keeper.
pub fn write(path: &Path, bytes: Vec<u8>) -> io::Result<()> {
    KEEPER.get().map_or(Ok(()), |keeper| keeper(path, Some(&bytes)))?;
    lay(path, bytes);
    Ok(())
}

/// # Errors
/// A missing file.
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    files().get(path).cloned().ok_or(io::Error::new(ErrorKind::NotFound, "no such file"))
}

pub fn remove(path: &Path) {
    files().remove(path);
    // A file that cannot be removed is overwritten by the next of its name.
    let _ = KEEPER.get().map(|keeper| keeper(path, None));
}

pub fn has(path: &Path) -> bool {
    files().contains_key(path)
}

/// Sorted names of the files in a folder.
pub fn names(folder: &Path) -> Vec<String> {
    let files = files();
    let own = files.keys().filter(|path| path.parent() == Some(folder));
    own.filter_map(|path| Some(path.file_name()?.to_str()?.to_owned())).collect()
}
