//! A segmented control: one choice of a few side by side.

use crate::ui::{theme, tip};
use egui::{Button, ComboBox, Frame, Margin, TextStyle, TextWrapMode, Ui, WidgetText};

/// One choice: the value, its name, and a sentence about it.
pub type Segment<'a, T> = (T, &'a str, String);

/// Points of the screen from one name to the next, on either side of it, and around all of them.
const BETWEEN: f32 = 13.0;
const PADDING: f32 = 6.0;
const AROUND: f32 = 4.0;
/// Width of a list with the gap before it.
const LIST: f32 = 120.0;
/// More choices become a list in narrow windows.
const FEW: usize = 2;

/// Shows the choices side by side, or as a list if space is short. Returns whether the choice changed.
pub fn show<T: Copy + PartialEq>(ui: &mut Ui, name: &str, value: &mut T, choices: &[Segment<'_, T>]) -> bool {
    show_before(ui, name, value, choices, 0.0)
}

/// The same with this space left at its right, in points.
pub fn show_before<T: Copy + PartialEq>(
    ui: &mut Ui,
    name: &str,
    value: &mut T,
    choices: &[Segment<'_, T>],
    after: f32,
) -> bool {
    let is_long = choices.len() > FEW && theme::is_narrow(ui.ctx());
    // Elsewhere than in a row, the rest of a line tells nothing.
    let room =
        if ui.layout().main_wrap() { ui.available_size_before_wrap().x } else { ui.max_rect().width() };
    let has_room = width(ui, choices) <= room - after;
    let count = if has_room && !is_long { choices.len() } else { 0 };
    folded(ui, name, value, choices.split_at(count), |_| None)
}

/// As many choices side by side as leave this space at their right, in points, and a list of the others. Choices that
/// cannot be made now have a reason.
pub fn show_folded<T: Copy + PartialEq>(
    ui: &mut Ui,
    name: &str,
    value: &mut T,
    (choices, refusal): (&[Segment<'_, T>], impl Fn(T) -> Option<&'static str>),
    after: f32,
) -> bool {
    let room = ui.available_size_before_wrap().x - after;
    let fits = |count: &usize| width(ui, &choices[..*count]) <= room - LIST;
    let count = match theme::is_narrow(ui.ctx()) {
        true => 0,
        false if width(ui, choices) <= room => choices.len(),
        false => (0..choices.len()).take_while(fits).last().unwrap_or(0),
    };
    folded(ui, name, value, choices.split_at(count), refusal)
}

/// The first choices side by side, and a list of the others.
fn folded<T: Copy + PartialEq>(
    ui: &mut Ui,
    name: &str,
    value: &mut T,
    (first, others): (&[Segment<'_, T>], &[Segment<'_, T>]),
    refusal: impl Fn(T) -> Option<&'static str>,
) -> bool {
    let before = *value;
    let mut choose = |ui: &mut Ui, (choice, name, tip): &Segment<'_, T>, is_listed: bool| {
        let refusal = refusal(*choice);
        let button = Button::selectable(*value == *choice, *name).corner_radius(4);
        let response = ui.add_enabled(refusal.is_none(), button);
        let response = response.on_disabled_hover_text(refusal.unwrap_or_default());
        if is_listed {
            tip::beside(&response, tip);
        } else {
            response.clone().on_hover_text(tip);
        }
        if response.clicked() {
            *value = *choice;
        }
    };
    if !first.is_empty() {
        let width = width(ui, first);
        let ground =
            Frame::new().fill(ui.visuals().faint_bg_color).corner_radius(6).inner_margin(Margin::same(2));
        ground.show(ui, |ui| {
            ui.set_max_width(width);
            ui.horizontal(|ui| {
                ui.spacing_mut().item_spacing.x = 1.0;
                ui.spacing_mut().button_padding.x = PADDING;
                first.iter().for_each(|choice| choose(ui, choice, false));
            });
        });
    }
    if !others.is_empty() {
        let otherwise = if first.is_empty() { "" } else { "More" };
        let current =
            others.iter().find(|(choice, ..)| *choice == before).map_or(otherwise, |(_, name, _)| name);
        let list = ComboBox::from_id_salt(name).selected_text(current).height(360.0).show_ui(ui, |ui| {
            others.iter().for_each(|choice| choose(ui, choice, true));
        });
        list.response.accessible_name(name);
    }
    *value != before
}

fn width<T>(ui: &Ui, choices: &[Segment<'_, T>]) -> f32 {
    choices.iter().map(|(_, name, _)| text_width(ui, name) + BETWEEN).sum::<f32>() + AROUND
}

/// Width of a text on a button in points.
pub fn text_width(ui: &Ui, text: &str) -> f32 {
    let galley =
        WidgetText::from(text).into_galley(ui, Some(TextWrapMode::Extend), f32::INFINITY, TextStyle::Button);
    galley.size().x
}
