//! Drawings: SVG, PNG, JPEG and BMP. Their size is bounded, and their targets make a scene.

use glam::DVec3;

use sonoglyph::import::{self, Drawing, Placement};
use sonoglyph::scene::check::MOST_FOCI;
use sonoglyph::scene::{Sampling, Scene, file, outline};

use super::is_one_line;

/// Limit of points in a drawing.
const MOST_POINTS: usize = 20_000;

pub fn run(bytes: &[u8]) {
    match import::read(bytes) {
        Ok(drawing) => {
            is_bounded(&drawing);
            for sampling in [Sampling::Continuous, Sampling::Spacing(0.004), Sampling::Points(40)] {
                becomes_a_scene(&drawing, sampling);
            }
        }
        Err(error) => is_one_line(&error.to_string()),
    }
}

fn is_bounded(drawing: &Drawing) {
    const ROUNDING: f64 = 1e-9;
    assert!((1..=MOST_FOCI).contains(&drawing.lines.len()), "{} lines", drawing.lines.len());
    let points: usize = drawing.lines.iter().map(|line| line.points.len()).sum();
    assert!((1..=MOST_POINTS).contains(&points), "{points} points");
    assert!((drawing.size.max_element() - 1.0).abs() < ROUNDING, "{}", drawing.size);
    assert!(drawing.size.min_element() >= 0.0);
    for line in &drawing.lines {
        assert!(!line.points.is_empty() && line.length().is_finite());
        let beyond = |point: &glam::DVec2| (point.abs() - drawing.size / 2.0).max_element();
        assert!(line.points.iter().all(|point| beyond(point) < ROUNDING), "{line:?}");
    }
    assert!(drawing.lines.is_sorted_by(|a, b| a.length() >= b.length()));
}

fn becomes_a_scene(drawing: &Drawing, sampling: Sampling) {
    let at = DVec3::new(0.01, 0.0, 0.12);
    let placement = Placement { at, x: DVec3::X, y: DVec3::Y, side: 0.08, sampling };
    let Ok(targets) = placement.targets(drawing) else { return };
    let read = file::parse_targets(&file::write_targets(&targets));
    assert_eq!(read.as_ref(), Some(&targets), "the file holds the same targets");
    if targets.is_empty() {
        return;
    }
    let foci = outline::foci(&Scene { targets, ..Scene::default() }).expect("the targets have foci");
    assert!((1..=MOST_FOCI).contains(&foci.len()), "{} foci", foci.len());
    for focus in foci {
        assert!((focus.position - at).abs().max_element() < 0.0401, "{focus:?}");
    }
}
