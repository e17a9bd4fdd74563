//! The two rows above the canvas: what is seen in which colours, and where.

use egui::{ComboBox, DragValue, Slider, Ui};

use crate::field::quantity::Range;
use crate::field::{Quantity, Scale};
use crate::picture::ColourMap;
use crate::ui::tool::Tool;
use crate::ui::view::{Cut, FreePlane};
use crate::ui::{Editor, Shown, brush, panels};

/// m: how far the slider moves a plane.
const FARTHEST: f64 = 0.3;

pub fn show(editor: &mut Editor, shown: &Shown, ui: &mut Ui) {
    ui.horizontal_wrapped(|ui| {
        quantities(editor, ui);
        ui.separator();
        if editor.view.quantity == Quantity::Instantaneous {
            oscillation(editor, ui);
        }
        if editor.view.quantity.declaration().of_liquid {
            surface(editor, ui);
        }
        ui.add_enabled_ui(!editor.view.is_shaded(), |ui| colours(editor, shown, ui));
    });
    ui.horizontal_wrapped(|ui| {
        cuts(editor, ui);
        ui.separator();
        overlays(editor, ui);
        if matches!(editor.tool, Tool::Brush | Tool::Erase) {
            ui.separator();
            brush(editor, ui);
        }
    });
}

/// What the brush paints or the eraser wipes.
fn brush(editor: &mut Editor, ui: &mut Ui) {
    let tip = "Of the brush and the eraser ([ and ])";
    let label = ui.label("Diameter").on_hover_text(tip);
    let diameter = &mut editor.brush.diameter;
    panels::bare_number(ui, diameter, panels::MM, brush::DIAMETER).labelled_by(label.id).on_hover_text(tip);
    if editor.tool == Tool::Brush {
        let tip = "Wanted pressure squared, relative to that of white";
        let label = ui.label("Brightness").on_hover_text(tip);
        let brightness = &mut editor.brush.brightness;
        let response = panels::bare_number(ui, brightness, panels::PLAIN, brush::BRIGHTNESS);
        response.labelled_by(label.id).on_hover_text(tip);
    }
}

fn quantities(editor: &mut Editor, ui: &mut Ui) {
    for (quantity, key) in Quantity::ALL.into_iter().zip(1..) {
        let declaration = quantity.declaration();
        ui.selectable_value(&mut editor.view.quantity, quantity, declaration.title)
            .on_hover_text(format!("{} ({key})", declaration.help));
    }
}

/// Which moment of the period is seen.
fn oscillation(editor: &mut Editor, ui: &mut Ui) {
    let oscillation = &mut editor.oscillation;
    let (name, tip) = if oscillation.playing {
        ("Pause", "Let the waves stand still")
    } else {
        ("Play", "Let the waves run: a period takes two seconds")
    };
    if ui.button(name).on_hover_text(tip).clicked() {
        oscillation.playing = !oscillation.playing;
    }
    // What the slider would round it would report as a change.
    let mut degrees = (oscillation.part * 360.0).round();
    let slider = Slider::new(&mut degrees, 0.0..=360.0).max_decimals(0).suffix("°");
    ui.spacing_mut().slider_width = 100.0;
    let response = ui.add(slider).accessible_name("Phase of the moment");
    if response.on_hover_text("Which moment of the sound's period is seen").changed() && degrees.is_finite() {
        oscillation.playing = false;
        oscillation.part = (degrees / 360.0).rem_euclid(1.0);
    }
    ui.separator();
}

fn surface(editor: &mut Editor, ui: &mut Ui) {
    for (shaded, name, tip) in [
        (false, "Flat", "The depth as a map, over which targets are edited"),
        (
            true,
            "Shaded",
            "The surface as light falls on it, seen from the front; targets are edited in the flat view",
        ),
    ] {
        ui.selectable_value(&mut editor.view.shaded, shaded, name).on_hover_text(tip);
    }
    ui.separator();
}

fn cuts(editor: &mut Editor, ui: &mut Ui) {
    for cut in Cut::ALL {
        let chosen = editor.view.cut == cut;
        if ui.selectable_label(chosen, cut.name()).on_hover_text(cut.tooltip()).clicked() && !chosen {
            editor.view.cut = cut;
            editor.view.window = None;
        }
    }
    height(editor, ui);
    if editor.view.cut == Cut::Free {
        free_plane(&mut editor.view.free, ui);
    }
    if ui.button("Fit").on_hover_text("Show everything (0, or double click)").clicked() {
        editor.view.window = None;
    }
}

fn height(editor: &mut Editor, ui: &mut Ui) {
    let cut = editor.view.cut;
    let (Some(name), Some(height)) = (cut.normal(), editor.view.height_mut()) else { return };
    let least = if cut == Cut::Xy { 0.01 } else { -FARTHEST / 2.0 };
    let mut shown = *height * 1e3;
    let label = ui.label(name);
    let slider = Slider::new(&mut shown, least * 1e3..=(least + FARTHEST) * 1e3)
        .clamping(egui::SliderClamping::Never)
        .step_by(0.5)
        .suffix(" mm");
    let response = ui.add(slider).labelled_by(label.id).on_hover_text(format!(
        "Where the plane lies along {name}. What is drawn is drawn there; “Use this plane” in the Scene panel writes it to the \
         scene."
    ));
    if response.changed() && shown.is_finite() {
        *height = (shown * 1e-3).clamp(-10.0, 10.0);
    }
}

fn free_plane(plane: &mut FreePlane, ui: &mut Ui) {
    ui.spacing_mut().item_spacing.x = 4.0;
    let mut number = |name: &str, tip: &str, value: &mut f64, per: f64, most: f64, suffix: &str| {
        let mut shown = *value * per;
        let label = ui.label(name);
        let field = DragValue::new(&mut shown).speed(0.5).max_decimals(1).suffix(suffix);
        if ui.add(field).labelled_by(label.id).on_hover_text(tip).changed() && shown.is_finite() {
            *value = (shown / per).clamp(-most, most);
        }
    };
    let centre = &mut plane.centre;
    for (name, value) in [("x", &mut centre.x), ("y", &mut centre.y), ("z", &mut centre.z)] {
        number(name, "The point through which the plane runs", value, 1e3, 10.0, " mm");
    }
    let per = 1f64.to_degrees();
    let most = std::f64::consts::TAU;
    let tip = "0° lies parallel to the array, 90° stands upright";
    number("tilt", tip, &mut plane.tilt, per, most, "°");
    number("turn", "About the array's axis, counter-clockwise", &mut plane.turn, per, most, "°");
}

fn colours(editor: &mut Editor, shown: &Shown, ui: &mut Ui) {
    let view = &mut editor.view;
    let is_amount = view.quantity.is_amount();
    ui.add_enabled_ui(is_amount, |ui| {
        let combo = ComboBox::from_id_salt("colours").width(76.0).selected_text(view.colours.title());
        let response = combo.show_ui(ui, |ui| {
            for map in ColourMap::OF_AMOUNTS {
                ui.selectable_value(&mut view.colours, map, map.title());
            }
        });
        response.response.accessible_name("Colours").on_hover_text("Colours of the map");
        let mut in_decibels = view.scale == Scale::Logarithmic;
        ui.toggle_value(&mut in_decibels, "dB")
            .on_hover_text("Colours in decibels, from the largest pressure down to a thousandth of it");
        view.scale = if in_decibels { Scale::Logarithmic } else { Scale::Linear };
    });
    ui.add_enabled_ui(view.quantity.declaration().range != Range::Cyclic, |ui| {
        let mut locked = view.full.is_some();
        let largest = shown.map.as_ref().map_or(1.0, |map| map.largest);
        ui.toggle_value(&mut locked, "Lock range")
            .on_hover_text("Keep the range of colours while the sound changes");
        view.full = match (locked, view.full) {
            (false, _) => None,
            (true, None) => Some(largest),
            (true, full) => full,
        };
        if let Some(full) = &mut view.full {
            let (factor, unit) = view.quantity.declaration().unit.scaled(*full);
            let mut value = *full * factor;
            let speed = 0.01 * value.abs().max(1e-3);
            let field = DragValue::new(&mut value).speed(speed).suffix(format!(" {unit}"));
            let response = ui.add(field).accessible_name("Largest value that has a colour");
            if response.changed() && value.is_finite() {
                *full = (value / factor).clamp(1e-12, 1e9);
            }
        }
    });
    ui.add_enabled_ui(view.quantity.declaration().has_mean, |ui| {
        ui.toggle_value(&mut view.contours, "Contours").on_hover_text(
            "Lines where the value is so many decibels below the largest on the screen; at -6 dB the pressure is half of it",
        );
        if view.contours {
            let field = DragValue::new(&mut view.contour_level).speed(0.1).range(-60.0..=-0.1);
            ui.add(field.max_decimals(1).suffix(" dB")).accessible_name("Level of the contour lines");
        }
    });
}

/// What lies over the map and below it.
fn overlays(editor: &mut Editor, ui: &mut Ui) {
    let is_flat = !editor.view.is_shaded();
    let view = &mut editor.view;
    ui.add_enabled_ui(is_flat, |ui| {
        ui.toggle_value(&mut view.marks, "Marks").on_hover_text("Focal points and outlines over the map (M)");
    });
    ui.toggle_value(&mut view.section, "Section")
        .on_hover_text("The curve along a line across the map; Shift and the pointer move it (X)");
}
