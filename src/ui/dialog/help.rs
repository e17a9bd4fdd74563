//! The keys and pointer gestures, by groups.

use egui::{Grid, Label, RichText, ScrollArea, Ui};
use strum::VariantArray;

use crate::ui::action::{Action, Group};
use crate::ui::{keys, theme};

/// Width of the keys in points.
const KEYS: f32 = 190.0;

pub(super) fn show(ui: &mut Ui) {
    ui.heading("Keys and tools");
    ui.label(
        "The map shows the pressure of the sound on a plane. White rings are the focal points: where the array's waves arrive in \
         step. Draw shapes, and the array's phases follow at once. A tool stays chosen until Esc or V.",
    );
    ui.add_space(4.0);
    let height = (ui.ctx().content_rect().height() - 200.0).min(540.0);
    ScrollArea::vertical().max_height(height).min_scrolled_height(height).auto_shrink([false, true]).show(
        ui,
        |ui| {
            for &(title, rows) in keys::GESTURES {
                let rows = rows.iter().map(|&(keys, what)| (keys.to_owned(), what.to_owned()));
                group(title, rows.collect(), ui);
            }
            for &of in Group::VARIANTS {
                let actions = Action::all().into_iter().filter(|action| action.group() == of);
                let named = actions.map(|action| (action.shortcut(ui.ctx()), action.name()));
                group(of.into_str(), named.filter(|(keys, _)| !keys.is_empty()).collect(), ui);
            }
        },
    );
    ui.add_space(8.0);
}

fn group(title: &str, rows: Vec<(String, String)>, ui: &mut Ui) {
    if rows.is_empty() {
        return;
    }
    ui.add_space(8.0);
    ui.label(theme::heading(title));
    Grid::new(("keys", title)).num_columns(2).striped(true).min_col_width(KEYS).show(ui, |ui| {
        for (keys, what) in rows {
            ui.label(RichText::new(keys).strong());
            ui.add(Label::new(what.trim_end_matches('…')).wrap());
            ui.end_row();
        }
    });
}
