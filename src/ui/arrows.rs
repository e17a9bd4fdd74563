//! Arrows over the map: the force on the scene's bead in the displayed plane.

use egui::{Color32, Painter, Stroke, Vec2, vec2};
use glam::{DVec2, DVec3};

use crate::ui::view::Lens;
use crate::ui::{Arrows, Editor};

/// Points of the screen from arrow to arrow, and of the longest.
const APART: f32 = 26.0;
const LONGEST: f32 = 23.0;
/// Points of the screen; shorter ones are dots.
const SHORTEST: f32 = 3.0;
/// Quantile of force for the longest arrow: the force is large close to the array.
const USUAL: f64 = 0.95;
const INK: Color32 = Color32::from_rgb(250, 250, 250);
const EDGE: Color32 = Color32::from_rgba_premultiplied(0, 0, 0, 150);

/// Positions of arrows (m) on the visible part of the plane, in front of the array.
pub fn places(editor: &Editor, lens: &Lens) -> Vec<DVec3> {
    let axes = editor.view.axes(editor.scene());
    let count = [lens.rect.width(), lens.rect.height()].map(|side| ((side / APART) as i32 / 2).max(1));
    let at = |i: i32, j: i32| {
        let offset = vec2(i as f32, j as f32) * APART;
        axes.world(lens.flat(lens.rect.center() + offset))
    };
    let rows = (-count[1]..=count[1]).flat_map(|j| (-count[0]..=count[0]).map(move |i| (i, j)));
    let lowest = editor.scene().wavelength() / 2.0;
    let is_home = editor.scene().is_home();
    rows.map(|(i, j)| at(i, j)).filter(|place| !is_home || place.z > lowest).collect()
}

pub fn paint(editor: &Editor, arrows: &Arrows, painter: &Painter, lens: &Lens) {
    let axes = editor.view.axes(editor.scene());
    let along = |force: &DVec3| DVec2::new(force.dot(axes.x), force.dot(axes.y));
    let forces: Vec<_> = arrows.forces.iter().map(along).collect();
    let mut sizes: Vec<_> =
        forces.iter().map(|force| force.length()).filter(|size| size.is_finite()).collect();
    sizes.sort_by(f64::total_cmp);
    let Some(&usual) = sizes.get((sizes.len() as f64 * USUAL) as usize).filter(|usual| **usual > 0.0) else {
        return;
    };
    for (place, force) in arrows.places.iter().zip(&forces) {
        // Roots, so that weak forces have a direction too.
        let size = LONGEST * (force.length() / usual).min(1.0).sqrt() as f32;
        let way = force.normalize_or_zero();
        let way = vec2(way.x as f32, -way.y as f32);
        let middle = lens.screen(axes.flat(*place));
        if size < SHORTEST || way == Vec2::ZERO {
            painter.circle_filled(middle, 1.2, INK);
            continue;
        }
        let (tail, tip) = (middle - way * size / 2.0, middle + way * size / 2.0);
        let head = 0.36 * size.max(9.0);
        let wings = [0.5f32, -0.5].map(|side| tip - way * head + way.rot90() * (side * head));
        for (width, colour) in [(3.2, EDGE), (1.3, INK)] {
            let stroke = Stroke::new(width, colour);
            painter.line_segment([tail, tip], stroke);
            painter.line(vec![wings[0], tip, wings[1]], stroke);
        }
    }
}
