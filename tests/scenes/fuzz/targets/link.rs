//! Links: a link holds a whole scene that names no files, and the scene that is read is written into a link again.

use std::path::Path;

use sonoglyph::scene::file;
use sonoglyph::studio::link;

use super::is_one_line;

pub fn run(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    // Mutations of letters rarely reach the scene, so the bytes are tried as a scene's file, too.
    if let Ok(scene) = file::parse(&text, Path::new("fuzz.toml"))
        && let Ok(made) = link::write(&scene)
    {
        let read = link::read(&made).expect("a link that was written");
        assert_eq!(file::parse(&read, Path::new("link")).expect("a scene that was written"), scene);
    }
    match link::read(&text) {
        Ok(read) => {
            assert!(link::is_link(&text));
            let scene = file::parse(&read, Path::new("link")).expect("a link's scene");
            link::write(&scene).expect("a scene without files");
        }
        Err(error) => is_one_line(&error.to_string()),
    }
}
