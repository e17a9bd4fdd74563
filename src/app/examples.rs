//! The example scenes of `assets/scenes`, built into the program.

#[cfg(target_arch = "wasm32")]
use crate::app::browser;
use crate::studio::link;
use crate::ui::Card;
use crate::ui::document::Document;

/// A scene to begin with.
#[derive(Debug)]
pub struct Example {
    /// The file's, without its ending.
    pub name: &'static str,
    /// Group and title in menus and in the gallery.
    pub card: Card,
    pub text: &'static str,
}

const HAPTICS: &str = "Haptics";
const PAPER: &str = "Figures of the paper";
const WATER: &str = "Water and light";
const LEVITATION: &str = "Boards and levitation";

macro_rules! example {
    ($group:expr, $name:literal, $title:literal) => {
        Example {
            name: $name,
            card: Card { group: $group, title: $title },
            text: include_str!(concat!("../../assets/scenes/", $name, ".toml")),
        }
    };
}

/// The first one is shown at the start; those of a group follow each other.
pub const EXAMPLES: &[Example] = &[
    example!(HAPTICS, "hit", "The word HIT"),
    example!(HAPTICS, "heart", "A heart"),
    example!(HAPTICS, "heart-and-hit", "A heart around HIT"),
    example!(HAPTICS, "star", "A star"),
    example!(HAPTICS, "filled-star", "A filled star"),
    example!(HAPTICS, "broad-h", "A broad H"),
    example!(HAPTICS, "hit-vertical", "HIT, standing upright"),
    example!(HAPTICS, "circle-figure-eight", "A ring on a figure-eight"),
    example!(HAPTICS, "fingertip", "A focus on a fingertip"),
    example!(HAPTICS, "palm", "A focus on a palm"),
    example!(PAPER, "focus-centre", "Figure 2: one focus"),
    example!(PAPER, "focus-off-centre", "Figure 2: off the axis"),
    example!(PAPER, "points-2", "Figure 3: two foci"),
    example!(PAPER, "points-4", "Figure 3: four foci"),
    example!(PAPER, "circle", "Figure 4: a circle"),
    example!(PAPER, "rectangle", "Figure 4: a rectangle"),
    example!(PAPER, "triangle", "Figure 4: a triangle"),
    example!(PAPER, "letter-h", "Figure 5: the letter H"),
    example!(PAPER, "letter-i", "Figure 5: the letter I"),
    example!(PAPER, "letter-t", "Figure 5: the letter T"),
    example!(PAPER, "hit-letter-by-letter", "Figure 5: H, I, T in turn"),
    example!(PAPER, "five-points", "Figures 6, 7: five foci"),
    example!(PAPER, "water-two-points", "Figure 12: two depressions"),
    example!(PAPER, "water-three-points", "Figure 12: three depressions"),
    example!(PAPER, "line", "Figure 13: a line"),
    example!(PAPER, "water-line", "Figure 13: a line on water"),
    example!(PAPER, "water-moving-square", "Moving point: a square"),
    example!(PAPER, "water-up-down-left-right", "Moving point: four ways"),
    example!(WATER, "water-heart", "A heart on water"),
    example!(WATER, "water-circle", "A circle on water"),
    example!(WATER, "water-rectangle", "A rectangle on water"),
    example!(WATER, "water-triangle", "A triangle on water"),
    example!(WATER, "caustic-circle", "Caustic: a ring"),
    example!(WATER, "caustic-hit", "Caustic: HIT"),
    example!(WATER, "standing-wave", "A standing wave over a liquid"),
    example!(LEVITATION, "two-boards", "Two boards face to face"),
    example!(LEVITATION, "levitated-beads", "Two levitated beads"),
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
            assert!(titles.insert(example.card.title), "{} is called as another", example.name);
        }
    }
}
