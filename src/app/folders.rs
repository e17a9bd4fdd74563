//! Folder listings for the file dialog, and the interpretation of typed paths.

use std::env::home_dir;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use crate::ui::{Entry, Folder};

/// Limit of listed files and folders.
#[cfg(not(target_arch = "wasm32"))]
const MOST: usize = 5000;

/// The initial folder of file dialogs.
pub(super) fn here() -> Option<PathBuf> {
    if cfg!(target_arch = "wasm32") { Some(PathBuf::from("/")) } else { std::env::current_dir().ok() }
}

/// A typed path: `~` is the user's folder, and relative paths start in `folder`.
pub(super) fn meant(text: &str, folder: Option<&Path>) -> PathBuf {
    let path = match (text.strip_prefix('~'), home_dir()) {
        (Some(""), Some(home)) => home,
        (Some(rest), Some(home)) if rest.starts_with(['/', std::path::MAIN_SEPARATOR]) => {
            home.join(&rest[1..])
        }
        _ => PathBuf::from(text),
    };
    folder.map_or_else(|| path.clone(), |folder| folder.join(&path))
}

/// The folder, or its nearest readable ancestor, with the reason. Folders first, without hidden files.
pub(super) fn list(folder: &Path) -> Folder {
    // A relative path of one part has an empty parent.
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let path = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
    let problem = match entries(&path) {
        Ok(entries) => return Folder { path, home: home_dir(), entries, problem: None },
        Err(error) if error.kind() == ErrorKind::NotFound => format!("{}: no such folder", path.display()),
        Err(error) => format!("{}: {error}", path.display()),
    };
    match path.parent() {
        Some(above) => Folder { problem: Some(problem), ..list(above) },
        None => Folder { path, home: home_dir(), entries: Vec::new(), problem: Some(problem) },
    }
}

/// A page only has its own files, in one folder.
#[cfg(target_arch = "wasm32")]
fn entries(folder: &Path) -> std::io::Result<Vec<Entry>> {
    let entry = |name| Entry { name, is_folder: false };
    Ok(crate::shelf::names(folder).into_iter().map(entry).collect())
}

#[cfg(not(target_arch = "wasm32"))]
fn entries(folder: &Path) -> std::io::Result<Vec<Entry>> {
    let mut entries = Vec::new();
    for entry in std::fs::read_dir(folder)?.flatten().take(MOST) {
        let Ok(name) = entry.file_name().into_string() else { continue };
        if !name.starts_with('.') {
            // A link counts as its target.
            entries.push(Entry { name, is_folder: entry.path().is_dir() });
        }
    }
    entries.sort_by_cached_key(|entry| (!entry.is_folder, entry.name.to_lowercase()));
    Ok(entries)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_come_first_hidden_files_are_left_out_and_a_missing_folder_gives_the_one_above() {
        let folder = tempfile::tempdir().unwrap();
        for file in ["b.toml", "A.toml", ".hidden"] {
            std::fs::write(folder.path().join(file), "").unwrap();
        }
        std::fs::create_dir(folder.path().join("z")).unwrap();
        let listed = list(folder.path());
        let names: Vec<_> = listed.entries.iter().map(|entry| entry.name.as_str()).collect();
        assert_eq!((names, listed.problem), (vec!["z", "A.toml", "b.toml"], None));
        let above = list(&folder.path().join("gone"));
        assert_eq!(above.path, folder.path());
        assert!(above.problem.unwrap().ends_with("gone: no such folder"));
        let here = list(Path::new(""));
        assert!(here.problem.is_none() && std::env::current_dir().ok() == Some(here.path));
    }

    #[test]
    fn a_tilde_is_the_own_folder_and_a_name_stands_in_the_folder_that_is_shown() {
        let folder = Path::new("/scenes");
        assert_eq!(meant("a.toml", Some(folder)), Path::new("/scenes/a.toml"));
        assert_eq!(meant("/b.toml", Some(folder)), Path::new("/b.toml"));
        let home = home_dir().expect("tests have a home");
        assert_eq!(meant("~", Some(folder)), home);
        assert_eq!(meant("~/c.toml", None), home.join("c.toml"));
        assert_eq!(meant("~c", None), Path::new("~c"));
    }
}
