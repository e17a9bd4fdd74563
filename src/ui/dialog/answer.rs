//! Answers to dialogs: the row of buttons, and the Enter key.

use egui::{Context, Id, Key, Modifiers, Ui};

use crate::ui::theme;

/// Whether Enter was pressed, once and not held, while no widget had the keyboard.
pub fn is_entered(ui: &Ui) -> bool {
    let is_free = ui.memory(|memory| memory.focused().is_none());
    is_free && ui.data(|data| data.get_temp(entered_id())).unwrap_or(false)
}

fn entered_id() -> Id {
    Id::unique("dialog entered")
}

/// Notes, before the dialog's widgets see it, whether Enter answers it.
pub fn hear_enter(ctx: &Context) {
    let is_free = ctx.memory(|memory| memory.focused().is_none());
    let is_enter = |event: &egui::Event| {
        matches!(event, egui::Event::Key { key: Key::Enter, pressed: true, repeat: false, modifiers, .. }
            if *modifiers == Modifiers::NONE)
    };
    let entered = is_free && ctx.input(|input| input.events.iter().any(is_enter));
    ctx.data_mut(|data| data.insert_temp(entered_id(), entered));
}

/// The row of buttons of a dialog, the primary one first: Enter presses it. Whether it was pressed.
pub fn answer(ui: &mut Ui, (primary, enabled): (&str, bool), others: impl FnOnce(&mut Ui)) -> bool {
    let entered = enabled && is_entered(ui);
    ui.horizontal(|ui| {
        let clicked = ui.add_enabled(enabled, theme::primary(primary)).clicked();
        others(ui);
        clicked || entered
    })
    .inner
}
