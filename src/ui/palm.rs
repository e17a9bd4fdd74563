//! The outline of an adult's hand, to scale and with its dimensions.

use egui::{Color32, Painter, Pos2, Shape, Stroke, vec2};
use glam::DVec2;

use crate::ui::view::Lens;

/// Length from the wrist to the tip of the middle finger, and width across the knuckles, mm.
pub const SIZE: [f64; 2] = [190.0, 84.0];
/// Places of the lines that show them, mm.
const BESIDE: f64 = 58.0;
const BELOW: f64 = -92.0;
/// mm, about the middle of the palm.
const OUTLINE: &[(f64, f64)] = &[
    (-28.0, -85.0),
    (-30.0, -70.0),
    (-38.0, -50.0),
    (-48.0, -32.0),
    (-62.0, -12.0),
    (-74.0, 8.0),
    (-78.0, 20.0),
    (-75.0, 28.0),
    (-68.0, 27.0),
    (-54.0, 6.0),
    (-44.0, -5.0),
    (-41.0, 3.0),
    (-42.0, 20.0),
    (-44.0, 46.0),
    (-45.0, 74.0),
    (-42.0, 84.0),
    (-36.0, 87.0),
    (-30.0, 83.0),
    (-27.0, 70.0),
    (-24.0, 44.0),
    (-21.5, 25.0),
    (-19.5, 25.0),
    (-19.0, 48.0),
    (-18.0, 82.0),
    (-15.0, 101.0),
    (-9.0, 106.0),
    (-3.0, 101.0),
    (-1.0, 82.0),
    (0.0, 48.0),
    (1.0, 24.0),
    (3.0, 24.0),
    (5.0, 48.0),
    (8.0, 76.0),
    (11.0, 93.0),
    (17.0, 97.0),
    (22.0, 91.0),
    (22.0, 74.0),
    (20.5, 44.0),
    (20.0, 21.0),
    (22.0, 20.0),
    (27.0, 38.0),
    (33.0, 60.0),
    (37.0, 73.0),
    (43.0, 76.0),
    (47.0, 69.0),
    (45.0, 50.0),
    (42.0, 22.0),
    (42.0, 0.0),
    (40.0, -28.0),
    (34.0, -52.0),
    (29.0, -70.0),
    (27.0, -85.0),
];
/// How often corners are cut.
const ROUNDS: usize = 2;

/// Draws it around a point of the plane. Returns the middles of the lines that show its size, mm.
pub fn paint(centre: DVec2, painter: &Painter, lens: &Lens) -> [(Pos2, f64); 2] {
    let mut outline: Vec<_> =
        OUTLINE.iter().map(|&(x, y)| lens.screen(centre + DVec2::new(x, y) * 1e-3)).collect();
    for _ in 0..ROUNDS {
        let (first, last) = (outline[0], outline[outline.len() - 1]);
        let cut = outline.windows(2).flat_map(|pair| [0.25, 0.75].map(|part| pair[0].lerp(pair[1], part)));
        outline = std::iter::once(first).chain(cut).chain([last]).collect();
    }
    let thin =
        [Stroke::new(3.5, Color32::from_black_alpha(110)), Stroke::new(1.4, Color32::from_white_alpha(130))];
    for stroke in thin {
        painter.add(Shape::line(outline.clone(), stroke));
    }
    let [length, width] = SIZE;
    let tip = OUTLINE.iter().map(|(_, y)| *y).fold(f64::MIN, f64::max);
    let at = |x: f64, y: f64| lens.screen(centre + DVec2::new(x, y) * 1e-3);
    let lines = [
        ([at(BESIDE, tip - length), at(BESIDE, tip)], vec2(4.0, 0.0), length),
        ([at(-width / 2.0, BELOW), at(width / 2.0, BELOW)], vec2(0.0, 4.0), width),
    ];
    lines.map(|([from, to], end, size)| {
        for stroke in thin {
            painter.line_segment([from, to], stroke);
            for at in [from, to] {
                painter.line_segment([at - end, at + end], stroke);
            }
        }
        (from.lerp(to, 0.5), size)
    })
}
