//! Recovery files of unsaved scenes, for the case of a crash.

use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

use crate::scene::{Scene, file};
use crate::source;
use crate::studio::paintings::Paintings;
use crate::studio::{opening, output};

/// s between two files.
const OFTEN: f64 = 5.0;

/// The file that outlives a crash. Every window that runs has its own.
#[derive(Debug)]
pub struct Recovery {
    path: PathBuf,
    /// Marks the file as in use for other windows; the system releases it when the program ends in any way.
    _lock: Option<File>,
    /// The content of the file.
    kept: Option<Scene>,
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
        let (kept, paintings) = read(&path).unzip();
        let paintings = paintings.unwrap_or_default();
        Some(Self { kept, paintings, path, _lock: lock, last: f64::NEG_INFINITY, trouble: None })
    }

    /// The scene left by a crashed run.
    pub fn found(&self) -> Option<Scene> {
        self.kept.clone()
    }

    /// Keeps an unsaved scene at intervals; `None` if there are no unsaved changes. Returns the seconds until the
    /// next call.
    pub fn keep(&mut self, unsaved: Option<&Scene>, now: f64) -> Option<f64> {
        if unsaved == self.kept.as_ref() {
            return None;
        }
        let Some(scene) = unsaved else {
            self.forget();
            return None;
        };
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
        let text = file::write(&placed.scene);
        match written.and_then(|()| output::write(&self.path, text.as_bytes())) {
            Ok(()) => (self.kept, self.trouble) = (Some(scene.clone()), None),
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

/// The scene of an earlier run, with its remaining files.
fn read(path: &Path) -> Option<(Scene, Paintings)> {
    let mut scene = file::read(path).ok()?;
    let folder = path.parent().unwrap_or(Path::new(""));
    // Missing files are reported where the scene is shown.
    let _ = opening::load_elements(&mut scene.array, folder);
    let _ = opening::load_wires(&mut scene, folder);
    for target in &mut scene.targets {
        let _ = opening::load_targets(std::slice::from_mut(target), folder);
    }
    let _ = opening::load_wave(&mut scene.modulation, folder);
    let _ = opening::load_thresholds(scene.skin.as_mut(), folder);
    let mut paintings = Paintings::default();
    paintings.adopt(&mut scene, path);
    Some((scene, paintings))
}

fn lock_of(path: &Path) -> PathBuf {
    path.with_extension("lock")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Shape, Target};

    fn scene(y: f64) -> Scene {
        let at = glam::DVec3::new(0.0, y, 0.1);
        Scene { targets: vec![Target::new(Shape::Point { at })], ..Scene::default() }
    }

    fn found(folder: &Path) -> Option<Scene> {
        Recovery::at(folder).unwrap().found()
    }

    #[test]
    fn what_is_unsaved_outlives_a_crash_and_nothing_else_does() {
        let folder = tempfile::tempdir().unwrap();
        let mut recovery = Recovery::at(folder.path()).unwrap();
        assert_eq!(recovery.found(), None);
        let mut scene = scene(0.01);
        assert_eq!(recovery.keep(Some(&scene), 0.0), None);
        drop(recovery);
        assert_eq!(found(folder.path()).as_ref(), Some(&scene));
        let mut recovery = Recovery::at(folder.path()).unwrap();
        scene.array.pitch = 0.011;
        recovery.keep(Some(&scene), 0.0);
        scene.array.pitch = 0.012;
        assert_eq!(recovery.keep(Some(&scene), 2.0), Some(3.0), "not all the time");
        recovery.keep(Some(&scene), 6.0);
        assert_eq!(recovery.found(), Some(scene));
        recovery.keep(None, 7.0);
        drop(recovery);
        assert_eq!(found(folder.path()), None);
    }

    #[test]
    fn windows_side_by_side_keep_apart_what_is_theirs() {
        let folder = tempfile::tempdir().unwrap();
        let scenes = [0.01, 0.02, 0.03].map(scene);
        let mut windows: Vec<_> = (0..3).map(|_| Recovery::at(folder.path()).unwrap()).collect();
        for (window, scene) in windows.iter_mut().zip(&scenes) {
            assert_eq!(window.found(), None, "what another window keeps was left by nobody");
            window.keep(Some(scene), 0.0);
        }
        windows[0].forget();
        drop(windows);
        // The second and the third crashed; each is offered once, and a fourth window starts afresh.
        let again: Vec<_> = (0..4).map(|_| Recovery::at(folder.path()).unwrap()).collect();
        let found: Vec<_> = again.iter().map(Recovery::found).collect();
        assert_eq!(found, [Some(scenes[1].clone()), Some(scenes[2].clone()), None, None]);
    }

    #[test]
    fn what_could_not_be_kept_is_tried_again_and_said() {
        let folder = tempfile::tempdir().unwrap();
        let mut recovery = Recovery::at(folder.path()).unwrap();
        std::fs::create_dir(folder.path().join("recovery.toml")).unwrap();
        let scene = scene(0.01);
        assert_eq!(recovery.keep(Some(&scene), 0.0), Some(OFTEN));
        assert!(recovery.trouble().unwrap().contains("recovery.toml"), "{:?}", recovery.trouble());
        std::fs::remove_dir(folder.path().join("recovery.toml")).unwrap();
        assert_eq!(recovery.keep(Some(&scene), 6.0), None);
        assert_eq!((recovery.trouble(), recovery.found()), (None, Some(scene)));
    }
}
