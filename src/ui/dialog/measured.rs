//! The figure of a measured field at its full size.

use egui::{RichText, ScrollArea, Ui};

use crate::ui::{shown::Shown, theme};

/// Points around the figure.
const AROUND: f32 = 130.0;

pub fn show(shown: &Shown, ui: &mut Ui) {
    ui.heading("Measured, model and difference");
    let height = (ui.ctx().content_rect().height() - AROUND).max(100.0);
    ScrollArea::vertical().max_height(height).show(ui, |ui| match &shown.measured_large {
        None => {
            ui.spinner();
        }
        Some(Err(problem)) => {
            ui.label(RichText::new(problem).color(theme::error(ui.visuals())));
        }
        Some(Ok(preview)) => {
            let picture = preview.texture.size_vec2();
            let size = picture * (ui.available_width() / picture.x.max(1.0));
            let image = egui::Image::new((preview.texture.id(), size)).fit_to_exact_size(size);
            ui.add(image.alt_text("Figure of the measured field, enlarged"));
        }
    });
}
