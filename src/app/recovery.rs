//! What is kept of an unsaved scene, so that a crash takes nothing away.

use std::path::{Path, PathBuf};

use crate::cli::output;
use crate::scene::{Scene, file};

/// s between two files.
const OFTEN: f64 = 5.0;

/// The file that outlives a crash.
#[derive(Debug)]
pub struct Recovery {
    path: PathBuf,
    /// What the file holds.
    kept: Option<Scene>,
    /// s on the window's clock.
    last: f64,
}

impl Recovery {
    /// The file in this folder.
    pub fn at(folder: &Path) -> Self {
        let path = folder.join("recovery.toml");
        Self { kept: file::read(&path).ok(), path, last: f64::NEG_INFINITY }
    }

    /// What a run that did not end well left.
    pub fn found(&self) -> Option<Scene> {
        self.kept.clone()
    }

    /// Keeps a scene that no file holds, now and then; `None` says that there is nothing to keep.
    /// Gives out in how many seconds it wants to be asked again.
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
        // Where nothing can be written, there is nothing to be done about it, and work goes on.
        let folder = self.path.parent().unwrap_or(Path::new("."));
        let _ = std::fs::create_dir_all(folder);
        let _ = output::write(&self.path, file::write(scene).as_bytes());
        self.kept = Some(scene.clone());
        None
    }

    /// All is well: there is nothing to recover.
    pub fn forget(&mut self) {
        let _ = std::fs::remove_file(&self.path);
        self.kept = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Shape, Target};

    #[test]
    fn what_is_unsaved_outlives_a_crash_and_nothing_else_does() {
        let folder = tempfile::tempdir().unwrap();
        let mut recovery = Recovery::at(folder.path());
        assert_eq!(recovery.found(), None);
        let mut scene = Scene::default();
        scene.targets.push(Target::new(Shape::Point { at: glam::DVec3::new(0.0, 0.01, 0.1) }));
        assert_eq!(recovery.keep(Some(&scene), 0.0), None);
        assert_eq!(Recovery::at(folder.path()).found().as_ref(), Some(&scene));
        scene.array.pitch = 0.011;
        assert_eq!(recovery.keep(Some(&scene), 2.0), Some(3.0), "not all the time");
        recovery.keep(Some(&scene), 6.0);
        assert_eq!(recovery.found(), Some(scene));
        recovery.keep(None, 7.0);
        assert_eq!(Recovery::at(folder.path()).found(), None);
    }
}
