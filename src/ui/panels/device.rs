//! The board that plays.

use egui::{RichText, Ui};

use crate::ui::Shown;
use crate::ui::panels::heading;

pub fn show(shown: &Shown, ui: &mut Ui) {
    heading(ui, "Device");
    ui.label("No board driver is part of this version, so nothing can be sent from here yet.");
    ui.add_space(4.0);
    let elements = shown.sound.as_ref().map_or(0, |sound| sound.drive.phases.len());
    if elements > 0 {
        ui.label(format!(
            "Until then, “Export, Drive as CSV” writes phase and amplitude of the {elements} elements for your own sender."
        ));
    }
    ui.label(
        RichText::new("The Drive panel shows what a board with few phases per period would make of it.")
            .weak(),
    );
}
