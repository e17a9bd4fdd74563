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
    show_possible(ui, name, value, choices, |_| None)
}

/// The same with choices that cannot be made now, each with the reason.
pub fn show_possible<T: Copy + PartialEq>(
    ui: &mut Ui,
    name: &str,
    value: &mut T,
    choices: &[Segment<'_, T>],
    refusal: impl Fn(T) -> Option<&'static str>,
) -> bool {
    let before = *value;
    let width = choices.iter().map(|(_, name, _)| text_width(ui, name) + BETWEEN).sum::<f32>() + AROUND;
    let is_long = choices.len() > FEW && theme::is_narrow(ui.ctx());
    let mut choose = |ui: &mut Ui, (choice, name, tip): &Segment<'_, T>| {
        let refusal = refusal(*choice);
        let button = Button::selectable(*value == *choice, *name).corner_radius(4);
        let response = ui.add_enabled(refusal.is_none(), button).on_hover_text(tip);
        if response.on_disabled_hover_text(refusal.unwrap_or_default()).clicked() {
            *value = *choice;
        }
    };
    if is_long || width > ui.max_rect().width() {
        let current = choices.iter().find(|(choice, ..)| *choice == before).map_or("", |(_, name, _)| name);
        let list = ComboBox::from_id_salt(name).selected_text(current).height(360.0).show_ui(ui, |ui| {
            choices.iter().for_each(|choice| choose(ui, choice));
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
                choices.iter().for_each(|choice| choose(ui, choice));
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
