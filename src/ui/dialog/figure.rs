//! The dialog for exporting a figure of the map or the surface, with a preview.

use egui::{ComboBox, DragValue, Sense, TextEdit, Ui, vec2};
use strum::VariantArray;

use crate::picture::figure::Format;
use crate::studio::figure::{DENSITIES, WIDTHS};
use crate::ui::command::{Command, Export, Purpose};
use crate::ui::{dialog::state::Dialog, editor::Editor, shown::Shown, theme};

/// Limit of the preview's size in points.
const PREVIEW: f32 = 260.0;

/// Draws the dialog, and returns whether it stays open.
pub fn show(editor: &mut Editor, shown: &Shown, ui: &mut Ui, commands: &mut Vec<Command>) -> bool {
    ui.heading("Export figure");
    preview(shown, ui);
    settings(editor, ui);
    ui.add_space(8.0);
    let mut stays = true;
    let is_there = matches!(shown.figure, Some(Ok(_)));
    ui.horizontal(|ui| {
        if ui.add_enabled(is_there, theme::primary("Export…")).clicked() {
            let purpose = Purpose::Export(Export::Figure(editor.figure.format));
            editor.dialog = Some(Dialog::path(purpose, &editor.document));
            stays = false;
        }
        let copy = ui.add_enabled(is_there, egui::Button::new("Copy image"));
        if copy.on_hover_text("Put the figure's pixels on the clipboard").clicked() {
            commands.push(Command::CopyFigure);
        }
        stays &= !ui.button("Close").clicked();
    });
    stays
}

fn preview(shown: &Shown, ui: &mut Ui) {
    let room = vec2(ui.available_width(), PREVIEW.min(ui.ctx().content_rect().height() * 0.4));
    let (rect, _) = ui.allocate_exact_size(room, Sense::hover());
    match &shown.figure {
        None => {
            ui.put(rect, egui::Spinner::new());
        }
        Some(Err(problem)) => {
            ui.put(rect, egui::Label::new(egui::RichText::new(problem).color(theme::error(ui.visuals()))));
        }
        Some(Ok(preview)) => {
            let picture = preview.texture.size_vec2();
            let size = picture * (room / picture).min_elem();
            let alt = format!("Figure of {:.0} x {:.0} mm", preview.size[0], preview.size[1]);
            ui.put(
                rect,
                egui::Image::new((preview.texture.id(), size)).fit_to_exact_size(size).alt_text(alt),
            );
        }
    }
}

fn settings(editor: &mut Editor, ui: &mut Ui) {
    let (is_shaded, has_contours) = (editor.view.is_shaded(), editor.view.quantity.declaration().has_mean);
    let form = &mut editor.figure;
    egui::Grid::new("figure").num_columns(2).show(ui, |ui| {
        ui.label("Format");
        let combo = ComboBox::from_id_salt("format").selected_text(form.format.into_str().to_uppercase());
        combo.show_ui(ui, |ui| {
            for &format in Format::VARIANTS {
                ui.selectable_value(&mut form.format, format, format.into_str().to_uppercase());
            }
        });
        ui.end_row();
        let mut number = |name: &str, value: &mut f64, [least, most]: [f64; 2], unit: &str| {
            let label = ui.label(name);
            let field = DragValue::new(value).range(least..=most).max_decimals(1).suffix(unit);
            ui.add(field).labelled_by(label.id);
            ui.end_row();
        };
        number("Width", &mut form.paper.width, WIDTHS, " mm");
        number("Resolution", &mut form.paper.dpi, DENSITIES, " dpi");
        let label = ui.label("Title");
        ui.add(TextEdit::singleline(&mut form.title).desired_width(240.0)).labelled_by(label.id);
        ui.end_row();
    });
    ui.horizontal_wrapped(|ui| {
        if is_shaded {
            ui.checkbox(&mut form.colour_bar, "Depth bar");
            ui.checkbox(&mut form.scale_bar, "Scale bar").on_hover_text("Scale of horizontal lengths");
            return;
        }
        ui.checkbox(&mut form.colour_bar, "Colour bar");
        ui.checkbox(&mut form.scale_bar, "Scale bar");
        let contours = egui::Checkbox::new(&mut form.contours, "Contours");
        ui.add_enabled(has_contours, contours).on_hover_text("At the view's level");
        ui.checkbox(&mut form.targets, "Targets");
        ui.checkbox(&mut form.widths, "Widths").on_hover_text("-6 dB widths of separate foci (FWHM)");
        ui.checkbox(&mut form.is_light, "Light ground").on_hover_text("Silence is white");
    });
}
