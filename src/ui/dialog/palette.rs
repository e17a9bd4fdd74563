//! The command palette: commands found by a part of their name.

use egui::{Button, Key, ScrollArea, TextEdit, Ui};

use crate::ui::action::Action;
use crate::ui::{command::Command, editor::Editor, shown::Shown};

/// Draws it, and returns whether it stays open.
pub(super) fn show(
    (text, chosen): (&mut String, &mut usize),
    (editor, shown): (&mut Editor, &Shown),
    ui: &mut Ui,
    commands: &mut Vec<Command>,
) -> bool {
    let (up, down, enter) = ui.input(|input| {
        (input.key_pressed(Key::ArrowUp), input.key_pressed(Key::ArrowDown), input.key_pressed(Key::Enter))
    });
    let field = TextEdit::singleline(text).desired_width(f32::INFINITY).hint_text("What to do");
    let field = ui.add(field).accessible_name("Command");
    field.request_focus();
    if field.changed() {
        *chosen = 0;
    }
    let found: Vec<_> = Action::all().into_iter().filter(|action| matches(&action.name(), text)).collect();
    *chosen = match (up, down) {
        (true, _) => chosen.saturating_sub(1),
        (_, true) => *chosen + 1,
        _ => *chosen,
    }
    .min(found.len().saturating_sub(1));
    let mut taken = None;
    let height = (ui.ctx().content_rect().height() - 120.0).clamp(60.0, 380.0);
    ScrollArea::vertical().max_height(height).min_scrolled_height(height).auto_shrink([false, true]).show(
        ui,
        |ui| {
            for (place, &action) in found.iter().enumerate() {
                let possible = action.possible(editor, shown);
                let keys = action.shortcut(ui.ctx());
                let row = (action.name(), egui::Atom::grow(), egui::RichText::new(keys).weak());
                let row = Button::selectable(place == *chosen, row);
                let row = row.min_size(egui::vec2(ui.available_width(), 0.0));
                let response = ui.add_enabled(possible.is_ok(), row);
                if place == *chosen && (up || down) {
                    response.scroll_to_me(None);
                }
                if response.on_disabled_hover_text(possible.err().unwrap_or_default()).clicked() {
                    taken = Some(action);
                }
            }
            if found.is_empty() {
                ui.weak("No command matches");
            }
        },
    );
    let entered =
        found.get(*chosen).copied().filter(|action| enter && action.possible(editor, shown).is_ok());
    let Some(action) = taken.or(entered) else { return true };
    action.run(editor, shown, ui.ctx(), commands);
    false
}

/// Whether the name contains every word of the text.
fn matches(name: &str, text: &str) -> bool {
    let name = name.to_lowercase();
    text.to_lowercase().split_whitespace().all(|word| name.contains(word))
}
