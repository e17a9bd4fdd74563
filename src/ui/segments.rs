//! A segmented control: one choice of a few side by side.

use crate::ui::theme;
use egui::{Button, ComboBox, Frame, Margin, TextStyle, TextWrapMode, Ui, WidgetText};

/// One choice: the value, its name, and a sentence about it.
pub type Segment<'a, T> = (T, &'a str, String);

/// Points of the screen from one name to the next, on either side of it, and around all of them.
const BETWEEN: f32 = 13.0;
const PADDING: f32 = 6.0;
const AROUND: f32 = 4.0;
/// More choices become a list in narrow windows.
const FEW: usize = 2;

/// Shows the choices side by side, or as a list if space is short. Returns whether the choice changed.
pub fn show<T: Copy + PartialEq>(ui: &mut Ui, name: &str, value: &mut T, choices: &[Segment<'_, T>]) -> bool {
    let before = *value;
    let width = choices.iter().map(|(_, name, _)| text_width(ui, name) + BETWEEN).sum::<f32>() + AROUND;
    let is_long = choices.len() > FEW && theme::is_narrow(ui.ctx());
    if is_long || width > ui.max_rect().width() {
        let current = choices.iter().find(|(choice, ..)| choice == value).map_or("", |(_, name, _)| name);
        let list = ComboBox::from_id_salt(name).selected_text(current).height(360.0).show_ui(ui, |ui| {
            for (choice, name, tip) in choices {
                ui.selectable_value(value, *choice, *name).on_hover_text(tip);
            }
        });
        list.response.accessible_name(name);
    } else {
        let ground =
            Frame::new().fill(ui.visuals().faint_bg_color).corner_radius(6).inner_margin(Margin::same(2));
        ground.show(ui, |ui| {
            ui.set_max_width(width);
            ui.horizontal(|ui| {
                ui.spacing_mut().item_spacing.x = 1.0;
                ui.spacing_mut().button_padding.x = PADDING;
                for (choice, name, tip) in choices {
                    let button = Button::selectable(value == choice, *name).corner_radius(4);
                    if ui.add(button).on_hover_text(tip).clicked() {
                        *value = *choice;
                    }
                }
            });
        });
    }
    *value != before
}

/// Width of a text on a button in points.
pub fn text_width(ui: &Ui, text: &str) -> f32 {
    let galley =
        WidgetText::from(text).into_galley(ui, Some(TextWrapMode::Extend), f32::INFINITY, TextStyle::Button);
    galley.size().x
}
