//! Small drawn buttons: what can be seen beside the field, each a picture with a name and a sentence.

use egui::{Pos2, Rect, Response, Role, Sense, Stroke, Ui, WidgetInfo, vec2};

use crate::ui::theme;

/// Points of the screen.
const SIDE: f32 = 26.0;
const WIDTH: f32 = 1.5;

/// What is drawn on a button.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Icon {
    Fit,
    Targets,
    Profile,
}

/// A button that does something once.
pub fn button(ui: &mut Ui, icon: Icon, name: &str, tip: &str) -> Response {
    drawn(ui, icon, name, false).on_hover_text(format!("{name}. {tip}"))
}

/// A button that switches something on and off.
pub fn toggle(ui: &mut Ui, icon: Icon, name: &str, tip: &str, is_on: &mut bool) -> Response {
    let mut response = drawn(ui, icon, name, *is_on);
    if response.clicked() {
        *is_on = !*is_on;
        response.mark_changed();
    }
    let (enabled, chosen) = (ui.is_enabled(), *is_on);
    response.widget_info(|| WidgetInfo::selected(Role::CheckBox, enabled, chosen, name));
    response.on_hover_text(format!("{name}. {tip}"))
}

fn drawn(ui: &mut Ui, icon: Icon, name: &str, is_on: bool) -> Response {
    let (rect, response) = ui.allocate_exact_size(vec2(SIDE, SIDE), Sense::click());
    let enabled = ui.is_enabled();
    response.widget_info(|| WidgetInfo::labeled(Role::Button, enabled, name));
    let visuals = ui.style().interact_selectable(&response, is_on);
    if is_on {
        ui.painter().rect_filled(rect, 5.0, theme::ACCENT.gamma_multiply(0.55));
    } else if response.hovered() {
        ui.painter().rect_filled(rect, 5.0, visuals.weak_bg_fill);
    }
    if response.has_focus() {
        ui.painter().rect_stroke(rect, 5.0, ui.visuals().selection.stroke, egui::StrokeKind::Inside);
    }
    paint(ui, icon, rect.shrink(6.0), Stroke::new(WIDTH, visuals.text_color()));
    response
}

fn paint(ui: &Ui, icon: Icon, rect: Rect, stroke: Stroke) {
    let painter = ui.painter();
    // -1 to 1, downwards.
    let at = |x: f32, y: f32| -> Pos2 { rect.center() + vec2(x, y) * (rect.width() / 2.0) };
    match icon {
        Icon::Fit => {
            for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                painter.line(vec![at(x * 0.35, y), at(x, y), at(x, y * 0.35)], stroke);
            }
        }
        Icon::Targets => {
            painter.circle_stroke(at(0.0, 0.0), rect.width() * 0.36, stroke);
            for (x, y) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
                painter.line_segment([at(x * 1.1, y * 1.1), at(x * 0.4, y * 0.4)], stroke);
            }
        }
        Icon::Profile => {
            let bell = |i: i32| {
                let x = i as f32 / 10.0;
                at(x, 0.75 - 1.6 * (-6.0 * x * x).exp())
            };
            painter.line((-10..=10).map(bell).collect(), stroke);
            painter.line_segment([at(-1.1, 1.1), at(1.1, 1.1)], stroke);
        }
    }
}
