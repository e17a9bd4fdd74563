//! The document: the edited scene with its history and its file.

use std::path::{Path, PathBuf};

use crate::scene::file::FileError;
use crate::scene::{Scene, file, rewrite};
use crate::studio::opening;
use crate::studio::paintings::{self, Paintings, Placed};

/// Steps that can be taken back.
const MOST_STEPS: usize = 500;

/// A scene in the making. Whatever edits it writes to [`Document::scene`]; [`Document::settle`] makes one step of the history out
/// of all that was edited since the last.
#[derive(Clone, Debug)]
pub struct Document {
    pub scene: Scene,
    /// As the last step of the history left it.
    settled: Scene,
    undo: Vec<Scene>,
    redo: Vec<Scene>,
    /// As the file holds it.
    saved: Scene,
    path: Option<PathBuf>,
    /// What it is called while it has no file.
    name: String,
    /// What the scene was read from, with its comments; empty if it was not.
    text: String,
    /// Which painted pictures stand where.
    pub paintings: Paintings,
}

impl Document {
    /// A scene that was read from nowhere.
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

    /// The scene in a text, whose comments are kept.
    ///
    /// # Errors
    /// Those of [`opening::parse`].
    pub fn parse(text: String, name: &str) -> Result<Self, FileError> {
        let scene = opening::parse(&text, Path::new(name))?;
        Ok(Self { text, ..Self::new(scene, name) })
    }

    /// The scene of a file.
    ///
    /// # Errors
    /// Those of [`opening::open`].
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let text = file::read_text(path)?;
        let scene = opening::parse(&text, path)?;
        Ok(Self { path: Some(path.to_owned()), text, ..Self::new(scene, "") })
    }

    /// The text of a file that holds a scene: what this one was read from, but for what changed.
    pub fn text_of(&self, scene: &Scene) -> String {
        rewrite::rewrite(&self.text, scene)
    }

    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    /// The file's name, or what stands for it.
    pub fn name(&self) -> String {
        let of_file = self.path.as_deref().and_then(Path::file_name);
        of_file.map_or_else(|| self.name.clone(), |name| name.to_string_lossy().into_owned())
    }

    /// Whether there is something that the file does not hold.
    pub fn is_unsaved(&self) -> bool {
        self.scene != self.saved
    }

    /// Whether a file is that of the document, and does not hold any more what was read from it or saved there.
    pub fn was_changed_elsewhere(&self, path: &Path) -> bool {
        let is_own = self.path.as_deref() == Some(path);
        is_own && file::read_text(path).is_ok_and(|text| text != self.text)
    }

    /// The scene as a file is to hold it, and the paintings that have to stand beside it. Only the document's own are written over.
    pub fn placed(&self, path: &Path) -> Placed {
        let is_own = |place: &Path| {
            self.paintings.has_written(place)
                || (self.path.as_deref() == Some(path) && paintings::names(&self.saved, place))
        };
        self.paintings.place(&self.scene, path, is_own)
    }

    /// This scene, which differs in the names of pictures alone, is in this file now, as [`Document::text_of`].
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

    /// The scene is worth asking for even though no file holds it: what was recovered.
    pub fn was_never_saved(&mut self) {
        self.saved = Scene::default();
    }

    /// Makes a step of the history if anything was edited. A gesture is one step: call this when it is over.
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

    /// Takes back what was edited since the last step.
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
