//! The dialog for exporting a figure of what is shown, with a preview.

use egui::{ComboBox, DragValue, Sense, TextEdit, Ui, vec2};
use strum::VariantArray;

use crate::picture::figure::{Format, page};
use crate::studio::figure::{DENSITIES, WIDTHS};
use crate::studio::vectors::Vector;
use crate::ui::command::{Command, Export, Purpose};
use crate::ui::dialog::answer::answer;
use crate::ui::dialog::options::{Extent, FigureForm, Piece, SPANS};
use crate::ui::{editor::Editor, figure, shown::Shown, theme};

/// Limit of the preview's size in points.
const PREVIEW: f32 = 260.0;

/// Draws the dialog, and returns whether it stays open.
pub fn show(editor: &mut Editor, shown: &Shown, ui: &mut Ui, commands: &mut Vec<Command>) -> bool {
    ui.heading("Export figure");
    preview(shown, ui);
    pieces(editor, shown, ui);
    settings(editor, ui);
    ui.add_space(8.0);
    let mut stays = true;
    let is_there = matches!(shown.figure, Some(Ok(_)));
    let exports = answer(ui, ("Export…", is_there), |ui| {
        let copy = ui.add_enabled(is_there, egui::Button::new("Copy image"));
        if copy.on_hover_text("Put the figure's pixels on the clipboard").clicked() {
            commands.push(Command::CopyFigure);
        }
        stays = !ui.button("Close").clicked();
    });
    if exports {
        let purpose = Purpose::Export(Export::Figure(editor.figure.format));
        editor.ask_for_file(purpose);
    }
    stays && !exports
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
            let alt = format!("Figure of {:.0} × {:.0} mm", preview.size[0], preview.size[1]);
            ui.put(
                rect,
                egui::Image::new((preview.texture.id(), size)).fit_to_exact_size(size).alt_text(alt),
            );
        }
    }
}

/// The panels, of what can be shown now.
fn pieces(editor: &mut Editor, shown: &Shown, ui: &mut Ui) {
    let available = figure::available(editor, shown);
    let chosen = &mut editor.figure.pieces;
    chosen.retain(|piece| available.contains(piece));
    ui.horizontal_wrapped(|ui| {
        ui.label("Panels");
        for piece in available {
            let mut is_on = chosen.contains(&piece);
            if ui.checkbox(&mut is_on, piece.into_str()).changed() {
                chosen.retain(|own| *own != piece);
                chosen.extend(is_on.then_some(piece));
                chosen.sort_unstable();
            }
        }
    });
}

fn settings(editor: &mut Editor, ui: &mut Ui) {
    let has_contours = editor.view.quantity.declaration().has_mean;
    let has_vector = Vector::of(editor.view.quantity).is_some();
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
        // Every row is always there, so that nothing moves under the pointer.
        let is_of_plane = form.pieces.iter().any(|piece| piece.is_of_plane());
        extent(form, is_of_plane, ui);
        ui.end_row();
        let number = |ui: &mut Ui, name: &str, value: &mut f64, [least, most]: [f64; 2], unit: &str| {
            let label = ui.label(name);
            let field = DragValue::new(value).range(least..=most).max_decimals(1).suffix(unit);
            let is_changed = ui.add(field).labelled_by(label.id).changed();
            ui.end_row();
            is_changed
        };
        let mut width = form.width();
        if number(ui, "Width", &mut width, WIDTHS, " mm") {
            form.width = Some(width);
        }
        number(ui, "Resolution", &mut form.dpi, DENSITIES, " dpi");
        let label = ui.label("Columns");
        let most = form.pieces.len().max(1);
        let mut columns = form.columns.unwrap_or_else(|| page::columns(most)).min(most);
        let field = DragValue::new(&mut columns).range(1..=most).speed(0.05);
        if ui.add_enabled(most > 1, field).labelled_by(label.id).changed() {
            form.columns = Some(columns);
        }
        ui.end_row();
        let label = ui.label("Title");
        ui.add(TextEdit::singleline(&mut form.title).desired_width(240.0)).labelled_by(label.id);
        ui.end_row();
    });
    let has = |of: fn(Piece) -> bool| form.pieces.iter().any(|piece| of(*piece));
    let (has_maps, has_space) = (has(Piece::is_map), has(|piece| piece == Piece::Space));
    let has_relief = has(Piece::is_relief);
    ui.horizontal_wrapped(|ui| {
        let bar = if has_maps || has_space { "Colour bar" } else { "Depth bar" };
        if has_maps || has_space || has_relief {
            ui.checkbox(&mut form.colour_bar, bar);
        }
        if has_maps || has_relief {
            ui.checkbox(&mut form.scale_bar, "Scale bar").on_hover_text("Scale of horizontal lengths");
        }
        if has_maps {
            let contours = egui::Checkbox::new(&mut form.contours, "Contours");
            ui.add_enabled(has_contours, contours).on_hover_text("At the view's level");
            ui.checkbox(&mut form.targets, "Targets");
            ui.checkbox(&mut form.widths, "Widths").on_hover_text("−6 dB widths of separate foci (FWHM)");
            let arrows = egui::Checkbox::new(&mut form.arrows, "Arrows");
            ui.add_enabled(has_vector, arrows).on_hover_text("Of the quantity's vector in the plane");
        }
        if has_maps || has_space {
            ui.checkbox(&mut form.is_light, "White background").on_hover_text("Silence is white");
        }
    });
}

/// The part of the plane, with its size if it is typed.
fn extent(form: &mut FigureForm, is_of_plane: bool, ui: &mut Ui) {
    let label = ui.label("Extent");
    ui.add_enabled_ui(is_of_plane, |ui| {
        ui.horizontal(|ui| {
            let combo = ComboBox::from_id_salt("extent").selected_text(form.extent.into_str());
            let list = combo.show_ui(ui, |ui| {
                for &extent in Extent::VARIANTS {
                    ui.selectable_value(&mut form.extent, extent, extent.into_str());
                }
            });
            let tip = "The part of the plane: as on the screen, or about the centre of the scene plane";
            list.response.on_hover_text(tip).labelled_by(label.id);
            if form.extent != Extent::Typed {
                return;
            }
            let [least, most] = SPANS;
            let [width, height] = &mut form.span;
            for (name, side) in [("Width of the extent", width), ("Height of the extent", height)] {
                let field = DragValue::new(side).range(least..=most).max_decimals(1).suffix(" mm");
                ui.add(field).accessible_name(name);
            }
        })
    });
}
