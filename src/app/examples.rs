//! The scenes of `assets/scenes`, as part of the program.

/// Name and text, the first one first shown.
pub const EXAMPLES: &[(&str, &str)] = &[
    ("hit", include_str!("../../assets/scenes/hit.toml")),
    ("heart", include_str!("../../assets/scenes/heart.toml")),
    ("heart-and-hit", include_str!("../../assets/scenes/heart-and-hit.toml")),
    ("star", include_str!("../../assets/scenes/star.toml")),
    ("filled-star", include_str!("../../assets/scenes/filled-star.toml")),
    ("broad-h", include_str!("../../assets/scenes/broad-h.toml")),
    ("letter-h", include_str!("../../assets/scenes/letter-h.toml")),
    ("letter-i", include_str!("../../assets/scenes/letter-i.toml")),
    ("letter-t", include_str!("../../assets/scenes/letter-t.toml")),
    ("hit-vertical", include_str!("../../assets/scenes/hit-vertical.toml")),
    ("hit-letter-by-letter", include_str!("../../assets/scenes/hit-letter-by-letter.toml")),
    ("focus-centre", include_str!("../../assets/scenes/focus-centre.toml")),
    ("focus-off-centre", include_str!("../../assets/scenes/focus-off-centre.toml")),
    ("points-2", include_str!("../../assets/scenes/points-2.toml")),
    ("points-4", include_str!("../../assets/scenes/points-4.toml")),
    ("five-points", include_str!("../../assets/scenes/five-points.toml")),
    ("line", include_str!("../../assets/scenes/line.toml")),
    ("circle", include_str!("../../assets/scenes/circle.toml")),
    ("circle-figure-eight", include_str!("../../assets/scenes/circle-figure-eight.toml")),
    ("rectangle", include_str!("../../assets/scenes/rectangle.toml")),
    ("triangle", include_str!("../../assets/scenes/triangle.toml")),
    ("water-two-points", include_str!("../../assets/scenes/water-two-points.toml")),
    ("water-three-points", include_str!("../../assets/scenes/water-three-points.toml")),
    ("water-moving-square", include_str!("../../assets/scenes/water-moving-square.toml")),
    ("water-up-down-left-right", include_str!("../../assets/scenes/water-up-down-left-right.toml")),
    ("water-heart", include_str!("../../assets/scenes/water-heart.toml")),
    ("water-circle", include_str!("../../assets/scenes/water-circle.toml")),
    ("water-line", include_str!("../../assets/scenes/water-line.toml")),
    ("water-rectangle", include_str!("../../assets/scenes/water-rectangle.toml")),
    ("water-triangle", include_str!("../../assets/scenes/water-triangle.toml")),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::file;

    #[test]
    fn every_scene_of_the_assets_is_there_and_can_be_read() {
        let folder = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/scenes")).unwrap();
        assert_eq!(folder.count(), EXAMPLES.len());
        for (name, text) in EXAMPLES {
            file::parse(text, name.as_ref()).unwrap();
        }
    }
}
