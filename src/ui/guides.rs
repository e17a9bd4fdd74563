//! Snapping: moved or drawn targets align with the array's axis, other targets, or the grid.

use std::collections::BTreeSet;

use egui::{Color32, Painter, Stroke};
use glam::{DVec2, DVec3};

use crate::scene::{Scene, outline};
use crate::ui::edit;
use crate::ui::view::{Axes, Lens};
use crate::ui::{theme, ticks};

/// Snap distance of a line in points.
const REACH: f64 = 5.0;
/// Limit of targets used for alignment.
const MOST: usize = 64;
/// Points of the screen between two lines of the grid, at least.
const DENSEST: f64 = 8.0;
const COLOUR: Color32 = Color32::from_rgb(255, 92, 168);
/// Opacity of the grid, of 255.
const GRID: u8 = 34;

/// A line that something lines up with: one coordinate on the cut, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Guide {
    Vertical(f64),
    Horizontal(f64),
}

/// Coordinates that attract.
#[derive(Debug, Default)]
pub struct Guides {
    across: Vec<f64>,
    up: Vec<f64>,
}

impl Guides {
    /// The array's axis, and centres and edges of visible targets that are not `held`.
    pub fn of(scene: &Scene, axes: &Axes, held: &BTreeSet<usize>) -> Self {
        let mut guides = Self::default();
        let origin = axes.flat(DVec3::ZERO);
        guides.across.push(origin.x);
        // In an upright cut the array itself is below.
        if axes.y.z.abs() < 1e-9 {
            guides.up.push(origin.y);
        }
        let others = scene.targets.iter().enumerate();
        for (_, target) in others.filter(|(i, target)| target.visible && !held.contains(i)).take(MOST) {
            let centre = axes.flat(outline::centre(&target.shape));
            let edges = edit::bounds([target], axes).unwrap_or([centre; 2]);
            for at in [centre, edges[0], edges[1]] {
                guides.across.push(at.x);
                guides.up.push(at.y);
            }
        }
        guides
    }

    /// The displacement (m) that aligns these points, and the guides.
    pub fn attract(&self, lens: &Lens, places: &[DVec2]) -> (DVec2, Vec<Guide>) {
        let reach = REACH * lens.window.scale;
        let nearest = |lines: &[f64], pick: fn(&DVec2) -> f64| {
            let pairs =
                lines.iter().flat_map(|line| places.iter().map(move |place| (line - pick(place), *line)));
            pairs.filter(|(by, _)| by.abs() <= reach).min_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))
        };
        let (across, up) = (nearest(&self.across, |place| place.x), nearest(&self.up, |place| place.y));
        let by = DVec2::new(across.map_or(0.0, |(by, _)| by), up.map_or(0.0, |(by, _)| by));
        let across = across.map(|(_, line)| Guide::Vertical(line));
        (by, across.into_iter().chain(up.map(|(_, line)| Guide::Horizontal(line))).collect())
    }
}

/// Draws the lines that something lines up with.
pub fn paint(guides: &[Guide], painter: &Painter, lens: &Lens) {
    let stroke = Stroke::new(1.0, COLOUR);
    for guide in guides {
        match *guide {
            Guide::Vertical(x) => {
                painter.vline(lens.screen(DVec2::new(x, 0.0)).x, lens.rect.y_range(), stroke);
            }
            Guide::Horizontal(y) => {
                painter.hline(lens.rect.x_range(), lens.screen(DVec2::new(0.0, y)).y, stroke);
            }
        }
    }
}

/// Draws the snap grid, coarser where its lines would be too dense.
pub fn grid(spacing: f64, is_light: bool, painter: &Painter, lens: &Lens) {
    let coarser = [1.0, 2.0, 10.0, 20.0, 100.0].map(|factor| spacing * factor);
    let Some(step) = coarser.into_iter().find(|step| step / lens.window.scale >= DENSEST) else { return };
    let (low, high) = (lens.flat(lens.rect.left_bottom()), lens.flat(lens.rect.right_top()));
    let stroke = Stroke::new(1.0, theme::line(is_light, GRID));
    for x in ticks::between(low.x, high.x, step) {
        painter.vline(lens.screen(DVec2::new(x, 0.0)).x, lens.rect.y_range(), stroke);
    }
    for y in ticks::between(low.y, high.y, step) {
        painter.hline(lens.rect.x_range(), lens.screen(DVec2::new(0.0, y)).y, stroke);
    }
}

#[cfg(test)]
mod tests {
    use egui::{Rect, pos2, vec2};

    use super::*;
    use crate::scene::{Shape, Target};
    use crate::ui::view::View;

    #[test]
    fn what_is_near_a_centre_an_edge_or_the_axis_lines_up_with_it() {
        let at = DVec3::new(0.03, 0.01, 0.1);
        let targets = [0.02, 0.005].map(|radius| Target::new(Shape::Circle { at, radius }));
        let scene = Scene { targets: targets.to_vec(), ..Scene::default() };
        let (view, rect) = (View::of(&scene), Rect::from_min_size(pos2(0.0, 0.0), vec2(800.0, 600.0)));
        let lens = view.lens(&scene, rect);
        let guides = Guides::of(&scene, &view.axes(&scene), &BTreeSet::from([1]));
        let off = lens.window.scale * 3.0;
        let attract = |x: f64, y: f64| guides.attract(&lens, &[DVec2::new(x, y)]);
        let (by, lines) = attract(0.03 + off, 0.03 - off);
        assert!(by.distance(DVec2::new(-off, off)) < 1e-9, "centre across, edge up: {by}");
        assert_eq!(lines.len(), 2);
        assert_eq!(attract(-off, 0.1).0, DVec2::new(off, 0.0), "the array's axis");
        assert_eq!(attract(0.0251, 0.1), (DVec2::ZERO, Vec::new()), "what is held attracts nothing");
    }
}
