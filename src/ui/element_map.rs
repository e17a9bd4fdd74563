//! The array seen from the front, one disk per element.

use egui::{Color32, Pos2, Response, Sense, Ui, pos2, vec2};

use crate::scene::Array;

/// Points of the screen.
const LARGEST: f32 = 224.0;

/// Draws the elements in these colours; `None` is one that is not driven. Gives out the element under the pointer.
pub fn show(
    ui: &mut Ui,
    name: &str,
    array: &Array,
    sense: Sense,
    colour: impl Fn(usize) -> Option<Color32>,
) -> (Response, Option<usize>) {
    let (columns, rows) = (array.columns as f32, array.rows as f32);
    let cell = (ui.available_width().min(LARGEST) / columns).min(LARGEST / rows);
    let (rect, response) = ui.allocate_exact_size(vec2(columns, rows) * cell, sense);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Canvas, true, name));
    let painter = ui.painter();
    let empty = ui.visuals().faint_bg_color;
    let edge = ui.visuals().weak_text_color();
    for n in 0..array.elements() {
        let (column, row) = (n % array.columns as usize, n / array.columns as usize);
        let at = pos2(rect.left() + (column as f32 + 0.5) * cell, rect.bottom() - (row as f32 + 0.5) * cell);
        let radius = cell * 0.44;
        match colour(n) {
            Some(colour) => painter.circle_filled(at, radius, colour),
            None => painter.circle(at, radius * 0.8, empty, egui::Stroke::new(1.0, edge)),
        };
    }
    let element = |at: Pos2| {
        let place = (at - rect.left_top()) / cell;
        let (column, row) = (place.x.floor(), rows - 1.0 - place.y.floor());
        let inside = (0.0..columns).contains(&column) && (0.0..rows).contains(&row);
        inside.then_some(row as usize * array.columns as usize + column as usize)
    };
    let pointer = response.interact_pointer_pos().or(response.hover_pos());
    let under = pointer.and_then(element);
    (response, under)
}
