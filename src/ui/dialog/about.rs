//! Name, version and licence of the program, and what computes its fields.

use egui::{RichText, ScrollArea, Ui};

use crate::ui::panels::form::{fact, form};
use crate::ui::shown::Shown;

const LICENCES: [(&str, &str); 2] =
    [("MIT", include_str!("../../../LICENSE-MIT")), ("Apache 2.0", include_str!("../../../LICENSE-APACHE"))];

pub(super) fn show(shown: &Shown, ui: &mut Ui) {
    ui.heading("Sonoglyph");
    ui.label(env!("CARGO_PKG_DESCRIPTION"));
    ui.add_space(6.0);
    form(ui, "about", |ui| {
        fact(ui, ("Version", "Of the program"), env!("CARGO_PKG_VERSION"));
        fact(ui, ("Licence", "Either of them, as you choose"), env!("CARGO_PKG_LICENSE"));
        fact(ui, ("Evaluator", "What computes the field"), shown.evaluator.as_str());
    });
    ui.add_space(6.0);
    for (name, text) in LICENCES {
        ui.collapsing(format!("Licence: {name}"), |ui| {
            ScrollArea::vertical().id_salt(name).max_height(220.0).auto_shrink([false, true]).show(
                ui,
                |ui| {
                    ui.label(RichText::new(text).small());
                },
            );
        });
    }
    ui.add_space(8.0);
}
