//! Recovery files of unsaved scenes, for the case of a crash.

use std::fs::{File, TryLockError};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::scene::{Scene, file};
use crate::source;
use crate::studio::paintings::Paintings;
use crate::studio::{opening, output};
use crate::ui::document::Document;

/// s between two files.
const OFTEN: f64 = 1.0;
/// Beginning of the lines with the [`Origin`].
const MARK: &str = "#: ";

/// The document of a recovery file: its name, its file, and the hash of that file's text as read or saved.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Origin {
    name: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    path: Option<PathBuf>,
    text: String,
}

impl Origin {
    fn of(document: &Document) -> Self {
        // A name that is no text cannot be written.
        let path = document.path().filter(|path| path.to_str().is_some());
        let path = path.map(|path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned()));
        Self { name: document.name(), path, text: hash(document.text()) }
    }

    /// The lines at the beginning of the file.
    fn lines(&self) -> String {
        let text = toml::to_string(self).unwrap_or_default();
        text.lines().map(|line| format!("{MARK}{line}\n")).collect()
    }

    fn read(text: &str) -> Option<Self> {
        let lines: Vec<_> = text.lines().map_while(|line| line.strip_prefix(MARK)).collect();
        toml::from_str(&lines.join("\n")).ok()
    }
}

fn hash(text: &str) -> String {
    let mut hasher = DefaultHasher::new();
    text.hash(&mut hasher);
    format!("{:x}", hasher.finish())
}

/// The file that outlives a crash. Every window that runs has its own.
#[derive(Debug)]
pub struct Recovery {
    path: PathBuf,
    /// Marks the file as in use for other windows; the system releases it when the program ends in any way.
    _lock: Option<File>,
    /// The content of the file.
    kept: Option<Scene>,
    origin: Origin,
    /// Paintings, in files beside it.
    paintings: Paintings,
    /// s on the window's clock.
    last: f64,
    /// The error of the last write.
    trouble: Option<String>,
}

impl Recovery {
    /// An unused recovery file in this folder: one left by a crashed run, or the first free one.
    pub fn at(folder: &Path) -> Option<Self> {
        // Unwritable folders are reported later.
        let _ = std::fs::create_dir_all(folder);
        let file = |number: usize| match number {
            1 => folder.join("recovery.toml"),
            _ => folder.join(format!("recovery-{number}.toml")),
        };
        let used = (1..).take_while(|&number| number == 1 || lock_of(&file(number)).exists());
        let mut free: Vec<_> = used.filter_map(|number| Self::take(file(number))).collect();
        if free.is_empty() {
            return (1..).find_map(|number| Self::take(file(number)));
        }
        let left = free.iter().position(|own| own.kept.is_some());
        Some(free.swap_remove(left.unwrap_or(0)))
    }

    /// `None` if another window uses this file.
    fn take(path: PathBuf) -> Option<Self> {
        let lock = lock_of(&path);
        // A pipe would block the window until it is read.
        let lock = output::refuse_stream(&lock)
            .and_then(|()| Ok(File::options().create(true).append(true).open(lock)?))
            .ok();
        if let Some(lock) = &lock
            && matches!(lock.try_lock(), Err(TryLockError::WouldBlock))
        {
            return None;
        }
        let (kept, origin, paintings) = match read(&path) {
            Some((scene, origin, paintings)) => (Some(scene), origin, paintings),
            None => <_>::default(),
        };
        Some(Self { kept, origin, paintings, path, _lock: lock, last: f64::NEG_INFINITY, trouble: None })
    }

    /// The scene left by a crashed run.
    pub fn found(&self) -> Option<Scene> {
        self.kept.clone()
    }

    /// The same as a document of its file.
    pub fn left(&self) -> Option<Document> {
        let (scene, Origin { name, path, text }) = (self.found()?, &self.origin);
        Some(Document::recovered(scene, name, path.clone(), |now| hash(now) == *text))
    }

    /// Keeps an unsaved scene at intervals; `None` if there are no unsaved changes. Returns the seconds until the
    /// next call.
    pub fn keep(&mut self, unsaved: Option<&Document>, now: f64) -> Option<f64> {
        if unsaved.map(|document| &document.scene) == self.kept.as_ref() {
            return None;
        }
        let Some(document) = unsaved else {
            self.forget();
            return None;
        };
        let scene = &document.scene;
        if now - self.last < OFTEN {
            return Some(OFTEN - (now - self.last));
        }
        self.last = now;
        if let Err(error) = output::refuse_stream(&self.path) {
            self.trouble = Some(error.to_string());
            return Some(OFTEN);
        }
        // No other window has files of these names.
        let placed = self.paintings.place(scene, &self.path, |_| true);
        let written = self.paintings.write(placed.files, output::write);
        let origin = Origin::of(document);
        let text = origin.lines() + &file::write(&placed.scene);
        match written.and_then(|()| output::write(&self.path, text.as_bytes())) {
            Ok(()) => (self.kept, self.origin, self.trouble) = (Some(scene.clone()), origin, None),
            Err(error) => self.trouble = Some(format!("{error:#}")),
        }
        // Space may be available again by then.
        self.trouble.is_some().then_some(OFTEN)
    }

    /// The reason why a crash would lose unsaved changes, if any.
    pub fn trouble(&self) -> Option<&str> {
        self.trouble.as_deref()
    }

    /// Removes the recovery data.
    pub fn forget(&mut self) {
        source::remove(&self.path);
        self.paintings.remove();
        self.kept = None;
    }
}

/// The scene of an earlier run, with its document and its remaining files.
fn read(path: &Path) -> Option<(Scene, Origin, Paintings)> {
    let text = file::read_text(path).ok()?;
    let mut scene = file::parse(&text, path).ok()?;
    // Files of older versions have no origin.
    let origin =
        Origin::read(&text).unwrap_or_else(|| Origin { name: "recovered".to_owned(), ..Origin::default() });
    let folder = path.parent().unwrap_or(Path::new(""));
    // Missing files are reported where the scene is shown.
    let _ = opening::load_elements(&mut scene.array, folder);
    let _ = opening::load_wires(&mut scene, folder);
    for target in &mut scene.targets {
        let _ = opening::load_targets(std::slice::from_mut(target), folder);
    }
    let _ = opening::load_waves(&mut scene, folder);
    let _ = opening::load_routes(&mut scene, folder);
    let _ = opening::load_thresholds(scene.skin.as_mut(), folder);
    let _ = opening::load_directivity(&mut scene.array, folder);
    for body in &mut scene.bodies {
        let _ = opening::load_bodies(std::slice::from_mut(body), folder);
    }
    let mut paintings = Paintings::default();
    paintings.adopt(&mut scene, path);
    Some((scene, origin, paintings))
}

fn lock_of(path: &Path) -> PathBuf {
    path.with_extension("lock")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Shape, Target};

    fn document(y: f64) -> Document {
        let at = glam::DVec3::new(0.0, y, 0.1);
        let scene = Scene { targets: vec![Target::new(Shape::Point { at })], ..Scene::default() };
        Document::new(scene, "mine")
    }

    fn found(folder: &Path) -> Option<Scene> {
        Recovery::at(folder).unwrap().found()
    }

    #[test]
    fn what_is_unsaved_outlives_a_crash_and_nothing_else_does() {
        let folder = tempfile::tempdir().unwrap();
        let mut recovery = Recovery::at(folder.path()).unwrap();
        assert_eq!(recovery.found(), None);
        let mut document = document(0.01);
        assert_eq!(recovery.keep(Some(&document), 0.0), None);
        drop(recovery);
        assert_eq!(found(folder.path()).as_ref(), Some(&document.scene));
        let mut recovery = Recovery::at(folder.path()).unwrap();
        assert_eq!(recovery.left().unwrap().name(), "mine");
        document.scene.array.pitch = 0.011;
        recovery.keep(Some(&document), 0.0);
        document.scene.array.pitch = 0.012;
        assert_eq!(recovery.keep(Some(&document), 0.75), Some(0.25), "not all the time");
        recovery.keep(Some(&document), 1.0);
        assert_eq!(recovery.found(), Some(document.scene));
        recovery.keep(None, 7.0);
        drop(recovery);
        assert_eq!(found(folder.path()), None);
    }

    #[test]
    fn a_recovered_scene_keeps_its_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("hit \"2\".toml");
        std::fs::write(&path, "format = 1\n# mine\n[[target]]\nat = [0, 0, 0.1]\n").unwrap();
        let mut document = Document::read(&path).unwrap();
        document.scene.array.pitch = 0.011;
        Recovery::at(folder.path()).unwrap().keep(Some(&document), 0.0);
        let left = Recovery::at(folder.path()).unwrap().left().unwrap();
        assert_eq!((left.path(), &left.scene), (Some(path.as_path()), &document.scene));
        assert!(left.is_unsaved() && !left.was_changed_elsewhere(&path));
        assert!(left.text_of(&left.scene).contains("# mine"));
        std::fs::write(&path, "format = 1\n").unwrap();
        let left = Recovery::at(folder.path()).unwrap().left().unwrap();
        assert!(left.was_changed_elsewhere(&path), "another program has changed it since");
    }

    #[test]
    fn windows_side_by_side_keep_apart_what_is_theirs() {
        let folder = tempfile::tempdir().unwrap();
        let documents = [0.01, 0.02, 0.03].map(document);
        let mut windows: Vec<_> = (0..3).map(|_| Recovery::at(folder.path()).unwrap()).collect();
        for (window, document) in windows.iter_mut().zip(&documents) {
            assert_eq!(window.found(), None, "what another window keeps was left by nobody");
            window.keep(Some(document), 0.0);
        }
        windows[0].forget();
        drop(windows);
        // The second and the third crashed; each is offered once, and a fourth window starts afresh.
        let again: Vec<_> = (0..4).map(|_| Recovery::at(folder.path()).unwrap()).collect();
        let found: Vec<_> = again.iter().map(Recovery::found).collect();
        let [_, second, third] = documents.map(|document| Some(document.scene));
        assert_eq!(found, [second, third, None, None]);
    }

    #[test]
    fn what_could_not_be_kept_is_tried_again_and_said() {
        let folder = tempfile::tempdir().unwrap();
        let mut recovery = Recovery::at(folder.path()).unwrap();
        std::fs::create_dir(folder.path().join("recovery.toml")).unwrap();
        let document = document(0.01);
        assert_eq!(recovery.keep(Some(&document), 0.0), Some(OFTEN));
        assert!(recovery.trouble().unwrap().contains("recovery.toml"), "{:?}", recovery.trouble());
        std::fs::remove_dir(folder.path().join("recovery.toml")).unwrap();
        assert_eq!(recovery.keep(Some(&document), 6.0), None);
        assert_eq!((recovery.trouble(), recovery.found()), (None, Some(document.scene)));
    }
}
