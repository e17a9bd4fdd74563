//! The two rows above the canvas: the quantity and the plane.

use egui::{Button, ComboBox, Slider, Ui};
use strum::VariantArray;

use crate::field::Quantity;
use crate::picture::relief::{self, Sight};
use crate::scene::Channel;
use crate::studio::convention::Convention;
use crate::studio::vectors::Vector;
use crate::ui::action::Action;
use crate::ui::icon::{self, Icon};
use crate::ui::number::{self, Look};
use crate::ui::panels::form::{DEGREES, MM, Unit};
use crate::ui::playback::Moment;
use crate::ui::tool::Tool;
use crate::ui::view::{Cut, FreePlane};
use crate::ui::{compare, editor::Editor, level, panels, segments, space, timeline, tool};

/// Range of the plane slider, m.
const FARTHEST: f64 = 0.3;
/// Points of the screen: what stands behind the quantities, so that another quantity moves neither them nor the map.
const OF_QUANTITY: f32 = 312.0;
/// Points of the screen: what the shaded relief adds to it.
const OF_RELIEF: f32 = 130.0;
/// Points of the screen in the second row: the numbers of a plane, the slider beside them, overlays, and the brush.
const POSITION: f32 = 112.0;
const SLIDER: f32 = 148.0;
const OBLIQUE: f32 = 500.0;
const OVERLAYS: f32 = 264.0;
const BRUSH: f32 = 300.0;

pub fn show(editor: &mut Editor, ui: &mut Ui) {
    if editor.space.is_on {
        ui.horizontal_wrapped(|ui| {
            dimensions(editor, ui);
            space::bar(editor, ui);
            convention(editor, ui);
        });
        ui.horizontal_wrapped(|ui| {
            space::places(editor, ui);
            let tip = "Focal points and outlines (M)";
            icon::toggle(ui, Icon::Targets, "Show targets", tip, &mut editor.view.marks);
        });
        return;
    }
    ui.horizontal_wrapped(|ui| {
        dimensions(editor, ui);
        quantities(editor, ui);
        if Convention::Peak.factor(editor.view.quantity) != Convention::Rms.factor(editor.view.quantity) {
            convention(editor, ui);
        }
        if editor.view.quantity == Quantity::Instantaneous {
            oscillation(editor, ui);
        }
        if editor.view.quantity.declaration().is_surface() {
            surface(editor, ui);
        }
        if editor.view.quantity.declaration().of_liquid {
            waves(editor, ui);
        }
        if editor.view.quantity.declaration().of_skin {
            channel(editor, ui);
        }
        if Vector::of(editor.view.quantity).is_some() {
            ui.checkbox(&mut editor.parts.arrows.form.is_of_quantity, "Arrows")
                .on_hover_text("Direction and size of the vector in this plane; longer is stronger");
        }
    });
    ui.horizontal_wrapped(|ui| {
        let has_brush = matches!(editor.tool, Tool::Brush | Tool::Erase);
        cuts(editor, OVERLAYS + if has_brush { BRUSH } else { 0.0 }, ui);
        ui.add_space(8.0);
        overlays(editor, ui);
        if has_brush {
            ui.add_space(8.0);
            brush(editor, ui);
        }
    });
}

/// A map of a plane, or all of space.
fn dimensions(editor: &mut Editor, ui: &mut Ui) {
    let choices = [
        (false, "Map", "The field on a plane, on which targets are drawn".to_owned()),
        (true, "3D", "The scene in space: turn it, and drag targets along axes and planes (F3)".to_owned()),
    ];
    segments::show(ui, "View", &mut editor.space.is_on, &choices);
}

/// Settings of brush and eraser.
fn brush(editor: &mut Editor, ui: &mut Ui) {
    let tip = "Diameter of brush and eraser ([ and ])";
    let label = ui.label("Diameter").on_hover_text(tip);
    let diameter = &mut editor.brush.diameter;
    panels::bare_number(ui, diameter, MM, tool::DIAMETER).labelled_by(label.id).on_hover_text(tip);
    if editor.tool == Tool::Brush {
        let tip = "Target pressure squared, relative to white";
        let label = ui.label("Brightness").on_hover_text(tip);
        let brightness = &mut editor.brush.brightness;
        let response = panels::bare_number(ui, brightness, panels::PLAIN, tool::BRIGHTNESS);
        response.labelled_by(label.id).on_hover_text(tip);
    }
}

fn quantities(editor: &mut Editor, ui: &mut Ui) {
    let choice = |quantity: Quantity| {
        let declaration = quantity.declaration();
        let key = Action::Quantity(quantity).shortcut(ui.ctx());
        let key = if key.is_empty() { key } else { format!(" ({key})") };
        (quantity, declaration.title, format!("{}{key}", declaration.help))
    };
    let choices: Vec<_> = Quantity::ALL.into_iter().map(choice).collect();
    let (view, scene) = (editor.view.clone(), &editor.document.scene);
    let refusal = |quantity| level::refusal(quantity, &view, scene);
    let after = OF_QUANTITY + if view.is_shaded() { OF_RELIEF } else { 0.0 };
    segments::show_folded(ui, "Quantity", &mut editor.view.quantity, (&choices, refusal), after);
}

/// The convention of pressures in the whole window.
fn convention(editor: &mut Editor, ui: &mut Ui) {
    let choice = |&convention: &Convention| {
        let tip = match convention {
            Convention::Rms => "Pressures and velocities are RMS values, everywhere in the window",
            Convention::Peak => "Pressures and velocities are peak amplitudes, √2 times the RMS values",
        };
        (convention, convention.title(), tip.to_owned())
    };
    let choices: Vec<_> = Convention::VARIANTS.iter().map(choice).collect();
    segments::show(ui, "Convention", &mut editor.view.convention, &choices);
}

/// The phase within the period.
fn oscillation(editor: &mut Editor, ui: &mut Ui) {
    let oscillation = &mut editor.oscillation;
    let (name, tip) = if oscillation.playing {
        ("Pause", "Stops the waves")
    } else {
        ("Play", "Runs the waves: a period takes two seconds")
    };
    if ui.button(name).on_hover_text(tip).clicked() {
        oscillation.playing = !oscillation.playing;
    }
    // A value rounded by the slider would count as changed.
    let mut degrees = (oscillation.part * 360.0).round();
    let tip = "Phase within the period of the sound";
    let slider = Slider::new(&mut degrees, 0.0..=360.0).max_decimals(0).show_value(false);
    ui.spacing_mut().slider_width = 100.0;
    let slid = ui.add(slider).accessible_name("Moment").on_hover_text(tip).changed();
    let look =
        Look { unit: "°", has_suffix: true, decimals: 0, speed: 1.0, name: Some("Phase of the moment") };
    let typed = number::field(ui, &mut degrees, &look, 0.0..=360.0).on_hover_text(tip).changed();
    if (slid || typed) && degrees.is_finite() {
        oscillation.playing = false;
        oscillation.part = (degrees / 360.0).rem_euclid(1.0);
    }
}

/// The frequencies of the skin's motion that count.
fn channel(editor: &mut Editor, ui: &mut Ui) {
    let choice = |&channel: &Channel| {
        let (name, tip) = match channel {
            Channel::All => ("All", "All frequencies"),
            Channel::Pressure => ("Pressure", "Below 20 Hz, felt as slow pressure"),
            Channel::Flutter => ("Flutter", "20 to 60 Hz"),
            Channel::Vibration => ("Vibration", "Above 60 Hz"),
        };
        (channel, name, tip.to_owned())
    };
    let choices: Vec<_> = Channel::VARIANTS.iter().map(choice).collect();
    segments::show(ui, "Channel", &mut editor.view.channel, &choices);
}

fn surface(editor: &mut Editor, ui: &mut Ui) {
    let choices = [
        (false, "Flat", "The depth as a map, over which targets are edited".to_owned()),
        (
            true,
            "Shaded",
            "The surface as a shaded relief: drag to turn it; targets are edited in the flat view".to_owned(),
        ),
    ];
    segments::show(ui, "Surface", &mut editor.view.shaded, &choices);
    if editor.view.is_shaded() {
        heights(&mut editor.view.relief, ui);
    }
}

/// The vertical exaggeration of a relief, and its view.
fn heights(relief: &mut relief::Look, ui: &mut Ui) {
    const TIMES: [u32; 12] = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000];
    let name = |times: Option<f64>| times.map_or("auto".to_owned(), |times| format!("× {times}"));
    let label = ui.label("Heights");
    let list = ComboBox::from_id_salt("heights").selected_text(name(relief.exaggeration)).width(64.0);
    let list = list.height(320.0).show_ui(ui, |ui| {
        for times in [None].into_iter().chain(TIMES.map(|times| Some(f64::from(times)))) {
            ui.selectable_value(&mut relief.exaggeration, times, name(times));
        }
    });
    let tip = "Vertical exaggeration: auto follows the deepest point; fixed, reliefs are comparable";
    list.response.labelled_by(label.id).on_hover_text(tip);
    let is_turned = relief.sight != Sight::default();
    let front = ui.add_enabled(is_turned, Button::new("Front"));
    if front.on_hover_text("The relief from the front (double click)").clicked() {
        relief.sight = Sight::default();
    }
}

/// The surface at rest, or its waves.
fn waves(editor: &mut Editor, ui: &mut Ui) {
    let mut has_waves = matches!(editor.playback.moment, Moment::Wave(_));
    let tip = "The liquid follows the sound from its onset: waves, played on the timeline (Space)";
    if ui.toggle_value(&mut has_waves, "Waves").on_hover_text(tip).clicked() {
        timeline::show_waves(editor, has_waves);
    }
}

/// The plane, with this space left for what follows, in points.
fn cuts(editor: &mut Editor, after: f32, ui: &mut Ui) {
    let choice = |&cut: &Cut| (cut, cut.into_str(), cut.tooltip().to_owned());
    let choices: Vec<_> = Cut::VARIANTS.iter().map(choice).collect();
    let numbers = if editor.view.cut == Cut::Free { OBLIQUE } else { POSITION };
    if segments::show_before(ui, "Plane", &mut editor.view.cut, &choices, numbers + after) {
        editor.look_at(editor.view.cut);
    }
    height(editor, ui.available_size_before_wrap().x >= POSITION + SLIDER + after, ui);
    if editor.view.cut == Cut::Free {
        free_plane(&mut editor.view.free, ui);
    }
}

/// The position of the plane, with a slider where that has room.
fn height(editor: &mut Editor, has_slider: bool, ui: &mut Ui) {
    let cut = editor.view.cut;
    let (Some(name), Some(height)) = (cut.normal(), editor.view.height_mut()) else { return };
    let least = if cut == Cut::Xy { 0.01 } else { -FARTHEST / 2.0 };
    let mut shown = *height * 1e3;
    let tip = format!(
        "Position of the plane along {name}. New targets are drawn on it; “Set as scene plane” in the Scene panel writes it to \
         the scene."
    );
    let label = ui.label(name);
    if has_slider {
        let slider = Slider::new(&mut shown, least * 1e3..=(least + FARTHEST) * 1e3)
            .clamping(egui::SliderClamping::Never)
            .step_by(0.5)
            .show_value(false);
        let response = ui.add(slider).accessible_name(format!("Position along {name}")).on_hover_text(&tip);
        if response.changed() && shown.is_finite() {
            *height = (shown * 1e-3).clamp(-10.0, 10.0);
        }
    }
    panels::bare_number(ui, height, MM, -10.0..=10.0).labelled_by(label.id).on_hover_text(tip);
}

fn free_plane(plane: &mut FreePlane, ui: &mut Ui) {
    ui.spacing_mut().item_spacing.x = 4.0;
    let mut number = |name: &str, tip: &str, value: &mut f64, unit: Unit, most: f64| {
        let label = ui.label(name);
        panels::bare_number(ui, value, unit, -most..=most).labelled_by(label.id).on_hover_text(tip);
    };
    let centre = &mut plane.centre;
    for (name, value) in [("x", &mut centre.x), ("y", &mut centre.y), ("z", &mut centre.z)] {
        number(name, "A point of the plane", value, MM, 10.0);
    }
    let most = std::f64::consts::TAU;
    let tip = "0° is parallel to the array, 90° is vertical";
    number("tilt", tip, &mut plane.tilt, DEGREES, most);
    number("turn", "About the array's axis, counter-clockwise", &mut plane.turn, DEGREES, most);
}

/// The overlays, the line profile, and the fitted view.
fn overlays(editor: &mut Editor, ui: &mut Ui) {
    ui.spacing_mut().item_spacing.x = 2.0;
    let is_flat = !editor.view.is_shaded();
    if icon::button(ui, Icon::Fit, "Fit", "Show everything (0, or double click)").clicked() {
        editor.fit();
    }
    let view = &mut editor.view;
    ui.add_enabled_ui(is_flat, |ui| {
        let tip = "Focal points and outlines over the map (M)";
        icon::toggle(ui, Icon::Targets, "Show targets", tip, &mut view.marks);
    });
    let tip = "The values along a line across the map; Shift and the pointer move it (X)";
    icon::toggle(ui, Icon::Profile, "Line profile", tip, &mut view.section);
    compare::switch(editor, ui);
    ui.add_space(6.0);
    let view = &mut editor.view;
    for (icon, name, tip, is_on) in [
        (Icon::Grid, "Show grid", "The lines to which the pointer snaps (K)", &mut view.grid),
        (
            Icon::Guides,
            "Guides",
            "A dragged target lines up with others and the array's axis",
            &mut view.guides,
        ),
        (Icon::Elements, "Show elements", "The array's elements, coloured by phase", &mut view.elements),
        (
            Icon::Peak,
            "Show peak and side lobe",
            "The loudest place in view and its peak side lobe",
            &mut view.extremes,
        ),
        (Icon::Palm, "Show palm", "An adult's hand to scale", &mut view.palm),
    ] {
        icon::toggle(ui, icon, name, tip, is_on);
    }
}
