//! What holds of every scene as a file: it comes back as it was, whatever it is written into.

use std::path::Path;

use sonoglyph::scene::{Elements, Scene, check, file, rewrite};

use crate::random::draw::{Case, Family};
use crate::random::tally::count;

pub fn hold(case: &Case) {
    check::check(&case.scene).unwrap();
    // The elements of a table are not part of the scene's file.
    let mut scene = case.scene.clone();
    scene.array.placed = Elements::default();
    let scene = &scene;
    let text = file::write(scene);
    match file::parse(&text, Path::new("scene.toml")) {
        Ok(read) => assert_eq!(read, *scene, "{text}"),
        Err(error) => {
            // Foci behind the array, which a file may not have: they are its only error, and it has a line.
            assert_eq!(case.family, Family::Ill, "{error}");
            assert!(error.to_string().contains("behind the array"), "{error}");
            return count("files refused: a focus behind the array");
        }
    }
    let other = "format = 1 # a comment\n\n[[target]]\nat = [0, 0.01, 0.2] # m\n\n[array]\nrows = 3\n";
    for before in [other, &text] {
        let rewritten = rewrite::rewrite(before, scene);
        assert_eq!(file::parse(&rewritten, Path::new("scene.toml")).unwrap(), *scene, "{rewritten}");
    }
    let tables = serde_json::to_value(scene).unwrap();
    let read: Scene = file::from_tables(tables).unwrap();
    assert_eq!(read, *scene, "as JSON");
}
