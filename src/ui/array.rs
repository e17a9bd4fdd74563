//! The array on the canvas: its edge, and its elements in the colours of their phases.

use std::f64::consts::TAU;

use egui::{Color32, CornerRadius, Painter, Rect, Shape, Stroke, pos2};
use glam::{DVec2, DVec3};

use crate::field::Quantity;
use crate::picture::ColourMap;
use crate::studio::map;
use crate::ui::theme;
use crate::ui::view::{Axes, Lens, array_size};
use crate::ui::{Editor, Shown, Sound};

/// Points of the screen: how thick elements are where they are seen from the side.
const THICK: f32 = 5.0;
const SILENT: Color32 = Color32::from_rgb(110, 116, 128);
/// Elements that are drawn one by one, at most.
const MOST: usize = 1024;

pub fn paint(editor: &Editor, shown: &Shown, painter: &Painter, lens: &Lens) {
    let axes = editor.view.axes(editor.scene());
    let sound = shown.sound.as_ref().filter(|sound| sound.aperture.positions.len() <= MOST);
    // Seen edge on, it is a bar.
    let is_upright = axes.x.cross(axes.y).z.abs() < 1e-3;
    if is_upright {
        bar(editor, sound, &axes, painter, lens);
        return;
    }
    outline(editor, &axes, painter, lens);
    let lies_flat = axes.x.cross(axes.y).z.abs() > 1.0 - 1e-9;
    if let (true, true, Some(sound)) = (editor.view.elements, lies_flat, sound) {
        discs(sound, &axes, painter, lens);
    }
}

/// Colour of an element: its phase where it sounds.
fn colour(sound: &Sound, element: usize) -> Color32 {
    let drive = sound.drive();
    let amplitude = drive.amplitudes.get(element).copied().unwrap_or(0.0);
    let Some(phase) = drive.phases.get(element).filter(|_| amplitude > 0.0) else { return SILENT };
    let table = map::colours(Quantity::Phase, ColourMap::Inferno).table();
    let part = (phase / TAU + 0.5).rem_euclid(1.0);
    let [r, g, b, _] = table[((part * table.len() as f64) as usize).min(table.len() - 1)];
    Color32::from_rgb(r, g, b)
}

fn outline(editor: &Editor, axes: &Axes, painter: &Painter, lens: &Lens) {
    let half = (array_size(&editor.scene().array) / 2.0).extend(0.0);
    let corner = |x: f64, y: f64| lens.screen(axes.flat(half * DVec3::new(x, y, 0.0)));
    let closed =
        [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0), corner(-1.0, -1.0)];
    let stroke = Stroke::new(1.0, theme::line(editor.view.is_light, 70));
    painter.extend(Shape::dashed_line(&closed, stroke, 6.0, 4.0));
}

fn discs(sound: &Sound, axes: &Axes, painter: &Painter, lens: &Lens) {
    let radius = (sound.aperture.element.radius / lens.window.scale) as f32;
    for (element, position) in sound.aperture.positions.iter().enumerate() {
        let at = lens.screen(axes.flat(position.extend(0.0)));
        let colour = colour(sound, element);
        painter.circle(at, radius, colour.gamma_multiply(0.3), Stroke::new(1.0, colour.gamma_multiply(0.7)));
    }
}

/// The row of elements nearest to an upright cut, behind the line from which they radiate.
fn bar(editor: &Editor, sound: Option<&Sound>, axes: &Axes, painter: &Painter, lens: &Lens) {
    let array = &editor.scene().array;
    let half = array_size(array) / 2.0;
    let reach = half.x * axes.x.x.abs() + half.y * axes.x.y.abs();
    let origin = axes.flat(DVec3::ZERO);
    let strip = |from: f64, to: f64| {
        let y = lens.screen(origin).y;
        let x = |u: f64| lens.screen(DVec2::new(u, origin.y)).x;
        let (y, below) = if axes.y.z >= 0.0 { (y, y + THICK) } else { (y - THICK, y) };
        Rect::from_min_max(pos2(x(from), y), pos2(x(to), below))
    };
    painter.rect_filled(
        strip(origin.x - reach, origin.x + reach),
        CornerRadius::ZERO,
        Color32::from_gray(60),
    );
    let Some(sound) = sound else { return };
    let radius = sound.aperture.element.radius;
    let height = |position: &DVec2| axes.height(position.extend(0.0)).abs();
    let nearest = sound.aperture.positions.iter().map(height).fold(f64::INFINITY, f64::min);
    for (element, position) in sound.aperture.positions.iter().enumerate() {
        if height(position) <= nearest + 1e-6 {
            let at = axes.flat(position.extend(0.0)).x;
            painter.rect_filled(
                strip(at - radius, at + radius),
                CornerRadius::same(1),
                colour(sound, element),
            );
        }
    }
}
