//! Links: a link holds a whole scene without files, and the scene that is read can be written as a link again.

use std::path::Path;

use sonoglyph::scene::file;
use sonoglyph::studio::link;

use super::is_one_line;

pub fn run(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    // Mutated base64 rarely decodes, so the bytes are also tried as a scene file.
    if let Ok(scene) = file::parse(&text, Path::new("fuzz.toml"))
        && let Ok(made) = link::write(&scene)
    {
        let read = link::read(&made).expect("the written link can be read");
        assert_eq!(file::parse(&read, Path::new("link")).expect("the written scene can be read"), scene);
    }
    match link::read(&text) {
        Ok(read) => {
            assert!(link::is_link(&text));
            let scene = file::parse(&read, Path::new("link")).expect("a link's scene");
            link::write(&scene).expect("the scene names no files");
        }
        Err(error) => is_one_line(&error.to_string()),
    }
}
