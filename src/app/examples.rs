//! The example scenes of `assets/scenes`, built into the program.

#[cfg(target_arch = "wasm32")]
use crate::app::browser;
use crate::studio::link;
use crate::ui::document::Document;

/// A scene to begin with.
#[derive(Debug)]
pub struct Example {
    /// The file's, without its ending.
    pub name: &'static str,
    /// Title in menus and in the gallery.
    pub title: &'static str,
    pub text: &'static str,
}

macro_rules! example {
    ($name:literal, $title:literal) => {
        Example {
            name: $name,
            title: $title,
            text: include_str!(concat!("../../assets/scenes/", $name, ".toml")),
        }
    };
}

/// The first one is shown at the start.
pub const EXAMPLES: &[Example] = &[
    example!("hit", "The word HIT"),
    example!("heart", "A heart"),
    example!("heart-and-hit", "A heart around HIT"),
    example!("star", "A star"),
    example!("filled-star", "A filled star"),
    example!("broad-h", "A broad H"),
    example!("letter-h", "The letter H"),
    example!("letter-i", "The letter I"),
    example!("letter-t", "The letter T"),
    example!("hit-vertical", "HIT, standing upright"),
    example!("hit-letter-by-letter", "HIT, letter by letter"),
    example!("focus-centre", "One focus"),
    example!("focus-off-centre", "One focus off the axis"),
    example!("points-2", "Two foci"),
    example!("points-4", "Four foci"),
    example!("five-points", "Five foci"),
    example!("line", "A line"),
    example!("circle", "A circle"),
    example!("circle-figure-eight", "A ring on a figure-eight"),
    example!("rectangle", "A rectangle"),
    example!("triangle", "A triangle"),
    example!("two-boards", "Two boards face to face"),
    example!("standing-wave", "A standing wave over a liquid"),
    example!("levitated-beads", "Two levitated beads"),
    example!("water-two-points", "Water: two depressions"),
    example!("water-three-points", "Water: three depressions"),
    example!("water-moving-square", "Water: a moving square"),
    example!("water-up-down-left-right", "Water: up, down, left, right"),
    example!("caustic-circle", "Caustic: a ring"),
    example!("caustic-hit", "Caustic: HIT"),
    example!("water-heart", "Water: a heart"),
    example!("water-circle", "Water: a circle"),
    example!("water-line", "Water: a line"),
    example!("water-rectangle", "Water: a rectangle"),
    example!("water-triangle", "Water: a triangle"),
];

/// An example scene as a document without a file.
pub fn example(index: usize) -> anyhow::Result<Document> {
    let example = EXAMPLES.get(index).unwrap_or(&EXAMPLES[0]);
    Ok(Document::parse(example.text.to_owned(), example.name)?)
}

/// The scene of a link as a document without a file; a page's address keeps that of its own link.
pub fn linked(text: &str) -> anyhow::Result<Document> {
    let mut document = Document::parse(link::read(text)?, "linked scene")?;
    #[cfg(target_arch = "wasm32")]
    let is_kept = browser::fragment().is_some_and(|own| own == text);
    #[cfg(not(target_arch = "wasm32"))]
    let is_kept = false;
    if !is_kept {
        document.was_never_saved();
    }
    Ok(document)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::file;

    #[test]
    fn every_scene_of_the_assets_is_there_and_can_be_read() {
        let folder = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/scenes")).unwrap();
        assert_eq!(folder.count(), EXAMPLES.len());
        let mut titles = std::collections::BTreeSet::new();
        for example in EXAMPLES {
            file::parse(example.text, example.name.as_ref()).unwrap();
            assert!(titles.insert(example.title), "{} is called as another", example.name);
        }
    }
}
