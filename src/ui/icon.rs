//! Icon buttons for overlays of the field, each with a name and a tooltip.

use egui::{Pos2, Rect, Response, Role, Sense, Shape, Stroke, StrokeKind, Ui, WidgetInfo, vec2};

use crate::ui::theme;

/// Points of the screen.
const SIDE: f32 = 26.0;
const WIDTH: f32 = 1.5;

/// The icon of a button.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Icon {
    Fit,
    Targets,
    Profile,
    Compare,
    Grid,
    Guides,
    Elements,
    Peak,
    Palm,
}

/// A push button.
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
        ui.painter().rect_stroke(rect, 5.0, ui.visuals().selection.stroke, StrokeKind::Inside);
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
        Icon::Compare => {
            for x in [-1.0, 1.0] {
                painter.line(vec![at(x * 0.3, -0.9), at(x, -0.9), at(x, 0.9), at(x * 0.3, 0.9)], stroke);
            }
            painter.line_segment([at(0.0, -1.1), at(0.0, 1.1)], stroke);
        }
        Icon::Grid => {
            for place in [-0.6, 0.0, 0.6] {
                painter.line_segment([at(place, -1.0), at(place, 1.0)], stroke);
                painter.line_segment([at(-1.0, place), at(1.0, place)], stroke);
            }
        }
        Icon::Guides => {
            painter.extend(Shape::dashed_line(&[at(0.0, -1.1), at(0.0, 1.1)], stroke, 2.5, 2.0));
            for (left, top, right, bottom) in [(-0.5, -0.8, 0.5, -0.2), (-0.9, 0.3, 0.9, 0.9)] {
                let block = Rect::from_min_max(at(left, top), at(right, bottom));
                painter.rect_stroke(block, 1.0, stroke, StrokeKind::Middle);
            }
        }
        Icon::Elements => {
            for (x, y) in [-0.8, 0.0, 0.8].into_iter().flat_map(|x| [-0.8, 0.0, 0.8].map(|y| (x, y))) {
                painter.circle_filled(at(x, y), 1.8, stroke.color);
            }
        }
        Icon::Peak => {
            painter.line(vec![at(-1.1, 0.9), at(-0.5, 0.9), at(-0.1, -0.8), at(0.3, 0.9)], stroke);
            painter.line(vec![at(0.3, 0.9), at(0.6, 0.1), at(0.9, 0.9), at(1.1, 0.9)], stroke);
        }
        Icon::Palm => {
            let hand = [(-0.5, 1.1), (-1.0, 0.1), (-0.7, -0.1), (-0.45, 0.2), (-0.45, -0.8), (-0.15, -0.8)];
            let rest = [(-0.15, -1.1), (0.2, -1.1), (0.2, -0.8), (0.55, -0.8), (0.55, -0.4), (0.85, -0.4)];
            let end = [(0.85, 0.4), (0.5, 1.1), (-0.5, 1.1)];
            let outline = hand.into_iter().chain(rest).chain(end).map(|(x, y)| at(x, y));
            painter.line(outline.collect(), stroke);
        }
    }
}
