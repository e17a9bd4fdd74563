//! The array seen from the front, one disk per element.

use egui::{Color32, Pos2, Response, Sense, Ui, vec2};
use glam::DVec2;

use crate::scene::Scene;
use crate::scene::chart::Chart;

/// Points of the screen.
const LARGEST: f32 = 224.0;

/// Draws the elements in these colours; `None` is undriven. Returns the element under the pointer.
pub fn show(
    ui: &mut Ui,
    name: &str,
    scene: &Scene,
    sense: Sense,
    colour: impl Fn(usize) -> Option<Color32>,
) -> (Response, Option<usize>) {
    let chart = Chart::new(scene);
    let size = vec2(chart.size.x as f32, chart.size.y as f32);
    let scale = (ui.available_width().min(LARGEST) / size.x).min(LARGEST / size.y);
    let (rect, response) = ui.allocate_exact_size(size * scale, sense);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Canvas, true, name));
    let painter = ui.painter();
    let empty = ui.visuals().faint_bg_color;
    let edge = ui.visuals().weak_text_color();
    for (n, place) in chart.places.iter().enumerate() {
        let at = rect.left_bottom() + vec2(place.x as f32, -place.y as f32) * scale;
        let radius = chart.cell as f32 * scale * 0.44;
        match colour(n) {
            Some(colour) => painter.circle_filled(at, radius, colour),
            None => painter.circle(at, radius * 0.8, empty, egui::Stroke::new(1.0, edge)),
        };
    }
    let element = |at: Pos2| {
        let place = (at - rect.left_bottom()) / scale;
        chart.element(DVec2::new(place.x.into(), (-place.y).into()))
    };
    let pointer = response.interact_pointer_pos().or(response.hover_pos());
    let under = pointer.and_then(element);
    (response, under)
}
