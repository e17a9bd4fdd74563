//! Messages of other programs: refused in one line, or leaving a scene within its limits.

use std::sync::Arc;

use sonoglyph::control::edit::{Edit, Wish};
use sonoglyph::control::json;
use sonoglyph::control::osc::{self, Word};
use sonoglyph::control::ultraino::Draft;
use sonoglyph::scene::check::check;
use sonoglyph::scene::{Scene, Shape, Target, file};

use super::is_one_line;

/// A point and a text, as objects of edits.
fn wish() -> Wish {
    let at = glam::DVec3::new(0.0, 0.0, 0.1);
    let text = Shape::Text { text: "A".to_owned(), at, height: 0.02 };
    let targets = [Shape::Point { at }, text].map(Target::new).to_vec();
    Wish::new(Arc::new(Scene { targets, ..Scene::default() }))
}

fn change(edits: &[Edit]) {
    let wish = wish();
    match wish.after(edits) {
        Ok(after) => {
            assert!(check(&after.scene).is_ok() && file::targets_in_motion(&after.scene).is_ok());
            let names_files = |target: &Target| matches!(target.shape, Shape::Picture { .. });
            assert!(!after.scene.targets.iter().any(names_files) && after.scene.modulation.file.is_empty());
            if let Some(Edit::Stop) = edits.last() {
                assert!(!after.sends);
            }
        }
        Err(error) => is_one_line(&error.to_string()),
    }
}

pub fn osc(bytes: &[u8]) {
    match osc::words(bytes) {
        Ok(words) => {
            let edit = |word| match word {
                Word::Edit(edit) => Some(edit),
                Word::Token(_) | Word::State => None,
            };
            change(&words.into_iter().filter_map(edit).collect::<Vec<_>>());
        }
        Err(error) => {
            is_one_line(&error);
            assert!(osc::words(&osc::error(&error)).is_err(), "an answer is not a command");
        }
    }
}

pub fn ultraino(bytes: &[u8]) {
    let mut draft = Draft::default();
    for packet in bytes.split(|&byte| byte == b'|') {
        let before = draft.clone();
        match draft.take(packet) {
            Ok(Some(edits)) => change(&edits),
            Ok(None) => {}
            Err(error) => {
                is_one_line(&error);
                assert_eq!(draft, before);
            }
        }
    }
}

pub fn json(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let mut id = None;
    match json::message(text, &mut id) {
        Ok(message) => {
            assert_eq!(message.id, id);
            change(&message.edits);
        }
        Err(error) => is_one_line(&error.to_string()),
    }
    let answer = json::done(1, id.as_ref());
    assert!(
        serde_json::from_str::<serde_json::Value>(&answer)
            .is_ok_and(|answer| answer.get("id") == id.as_ref())
    );
}
