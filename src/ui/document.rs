//! The document: the edited scene with its history and its file.

use std::path::{Path, PathBuf};

use crate::scene::file::FileError;
use crate::scene::{Scene, file, rewrite};
use crate::studio::opening;
use crate::studio::paintings::{self, Paintings, Placed};

/// Steps that can be taken back.
const MOST_STEPS: usize = 500;

/// An edited scene. Edits write
#[derive(Clone, Debug)]
pub struct Document {
    pub scene: Scene,
    /// State of the last undo step.
    settled: Scene,
    undo: Vec<Scene>,
    redo: Vec<Scene>,
    /// The scene in the file.
    saved: Scene,
    path: Option<PathBuf>,
    /// Its name while it has no file.
    name: String,
    /// The text of its file, with comments; empty without one.
    text: String,
    /// Files of painted pictures.
    pub paintings: Paintings,
}

impl Document {
    /// A scene without a file.
    pub fn new(scene: Scene, name: &str) -> Self {
        Self {
            settled: scene.clone(),
            saved: scene.clone(),
            scene,
            undo: Vec::new(),
            redo: Vec::new(),
            path: None,
            name: name.to_owned(),
            text: String::new(),
            paintings: Paintings::default(),
        }
    }

    /// The scene of a text, keeping its comments.
    ///
    /// # Errors
    /// The errors of [`opening::parse`].
    pub fn parse(text: String, name: &str) -> Result<Self, FileError> {
        let scene = opening::parse(&text, Path::new(name))?;
        Ok(Self { text, ..Self::new(scene, name) })
    }

    /// The scene of a file.
    ///
    /// # Errors
    /// The errors of [`opening::open`].
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let text = file::read_text(path)?;
        let scene = opening::parse(&text, path)?;
        Ok(Self { path: Some(path.to_owned()), text, ..Self::new(scene, "") })
    }

    /// The text of a scene's file: the original text with changes only.
    pub fn text_of(&self, scene: &Scene) -> String {
        rewrite::rewrite(&self.text, scene)
    }

    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    /// The file's name, or a substitute.
    pub fn name(&self) -> String {
        let of_file = self.path.as_deref().and_then(Path::file_name);
        of_file.map_or_else(|| self.name.clone(), |name| name.to_string_lossy().into_owned())
    }

    /// Whether there are unsaved changes.
    pub fn is_unsaved(&self) -> bool {
        self.scene != self.saved
    }

    /// Whether a file is the document's and was changed by another program since it was read or saved.
    pub fn was_changed_elsewhere(&self, path: &Path) -> bool {
        let is_own = self.path.as_deref() == Some(path);
        is_own && file::read_text(path).is_ok_and(|text| text != self.text)
    }

    /// The scene for its file, and the paintings to write beside it. Only the document's own are overwritten.
    pub fn placed(&self, path: &Path) -> Placed {
        let is_own = |place: &Path| {
            self.paintings.has_written(place)
                || (self.path.as_deref() == Some(path) && paintings::names(&self.saved, place))
        };
        self.paintings.place(&self.scene, path, is_own)
    }

    /// Records that this scene, which may differ in picture names, is now in this file, as [`Document::text_of`].
    pub fn saved_as(&mut self, path: PathBuf, scene: Scene) {
        // Names that a file gave are no step of the history.
        if self.scene == self.settled {
            self.settled = scene.clone();
        }
        self.text = self.text_of(&scene);
        self.saved = scene.clone();
        self.scene = scene;
        self.path = Some(path);
    }

    /// A scene that was left unsaved, of a file whose text was `known`. If the file has changed since, saving asks.
    pub fn recovered(scene: Scene, name: &str, path: Option<PathBuf>, known: impl Fn(&str) -> bool) -> Self {
        let mut document = Self::new(scene, name);
        document.was_never_saved();
        let text = path.as_deref().and_then(|path| file::read_text(path).ok()).filter(|text| known(text));
        if let (Some(text), Some(path)) = (text, &path) {
            document.saved = opening::parse(&text, path).unwrap_or_default();
            document.text = text;
        }
        Self { path, ..document }
    }

    /// The text of its file, as read or saved; empty without one.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Marks the scene as unsaved although it has no changes: a recovered one.
    pub fn was_never_saved(&mut self) {
        self.saved = Scene::default();
    }

    /// Makes an undo step of pending edits, if any; to be called at the end of a gesture.
    pub fn settle(&mut self) {
        if self.scene == self.settled {
            return;
        }
        self.undo.push(std::mem::replace(&mut self.settled, self.scene.clone()));
        self.redo.clear();
        if self.undo.len() > MOST_STEPS {
            self.undo.remove(0);
        }
    }

    /// Reverts the edits since the last step.
    pub fn revert(&mut self) {
        self.scene = self.settled.clone();
    }

    pub fn can_undo(&self) -> bool {
        !self.undo.is_empty() || self.scene != self.settled
    }

    pub fn can_redo(&self) -> bool {
        !self.redo.is_empty()
    }

    pub fn undo(&mut self) {
        self.settle();
        if let Some(before) = self.undo.pop() {
            self.redo.push(std::mem::replace(&mut self.settled, before.clone()));
            self.scene = before;
        }
    }

    pub fn redo(&mut self) {
        self.settle();
        if let Some(after) = self.redo.pop() {
            self.undo.push(std::mem::replace(&mut self.settled, after.clone()));
            self.scene = after;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_undone_can_be_redone_and_a_gesture_is_one_step() {
        let mut document = Document::new(Scene::default(), "a");
        let mut scenes = vec![document.scene.clone()];
        for step in 1..4 {
            for part in 0..5 {
                document.scene.array.pitch = 0.01 + f64::from(step) * 1e-3 + f64::from(part) * 1e-4;
            }
            document.settle();
            document.settle();
            scenes.push(document.scene.clone());
        }
        for scene in scenes.iter().rev().skip(1) {
            assert!(document.can_undo());
            document.undo();
            assert_eq!(document.scene, *scene);
        }
        assert!(!document.can_undo() && !document.is_unsaved());
        for scene in &scenes[1..] {
            document.redo();
            assert_eq!(document.scene, *scene);
        }
        assert!(!document.can_redo() && document.is_unsaved());
    }

    #[test]
    fn an_edit_after_undo_forgets_what_was_undone() {
        let mut document = Document::new(Scene::default(), "a");
        document.scene.plane.tolerance = 0.01;
        document.undo();
        assert!(document.can_redo());
        document.scene.plane.tolerance = 0.02;
        document.settle();
        assert!(!document.can_redo());
    }
}
