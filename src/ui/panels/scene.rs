//! The Scene page: targets, plane, air and array.

use std::collections::BTreeSet;
use std::f64::consts::PI;

use egui::{RichText, Sense, Ui};
use glam::DVec3;
use strum::VariantArray;

use crate::acoustics::Air;
use crate::echo;
use crate::scene::{Array, ElementModel, Fluid, Listener, Pole, Response, Target, Transducer, Wires};
use crate::studio::probe;
use crate::ui::panels::form::{caption, choice, count, fact, form, given, heading, number, remark, value};
use crate::ui::panels::{DEGREES, MM, PERCENT, PLAIN, Unit, boards, bodies, modulation, target};
use crate::ui::parts::levitation;
use crate::ui::{clipboard, command::Purpose, dialog::state::Dialog, edit, editor::Editor};
use crate::ui::{element_map, group, shown::Shown, theme, ticks};

/// Time constant (s) of a resonance of 10 mm transducers.
const TYPICAL_TAU: f64 = 1.9e-4;

pub fn show(editor: &mut Editor, shown: &Shown, ui: &mut Ui) {
    targets(editor, ui);
    ui.separator();
    plane(editor, shown, ui);
    ui.collapsing("Listener", |ui| listener(editor, shown, ui));
    ui.collapsing("Array", |ui| array(editor, ui));
    ui.collapsing("Boards", |ui| boards::show(editor, ui));
    ui.collapsing("Reflectors", |ui| boards::reflectors(editor, ui));
    bodies::section(editor, ui);
    ui.collapsing("Bead", |ui| levitation::panel::show(editor, ui));
    ui.collapsing("Air", |ui| air(editor, ui));
    ui.collapsing("Grid", |ui| {
        form(ui, "grid", |ui| {
            let tip = "Distance of its lines; to show it and to snap to it, see the menu Edit";
            number(ui, ("Grid spacing", tip), &mut editor.grid, MM, 5e-4..=0.05);
        });
    });
}

fn targets(editor: &mut Editor, ui: &mut Ui) {
    heading(ui, "Targets");
    if editor.scene().targets.is_empty() {
        ui.label("Pick a tool and draw on the map.");
        return;
    }
    let several = ui.input(|input| input.modifiers.shift || input.modifiers.command);
    let mut moved = None;
    let list = egui::ScrollArea::vertical().id_salt("targets").max_height(190.0).auto_shrink([false, true]);
    // Only those in sight are drawn: there may be hundreds.
    let height = ui.spacing().interact_size.y;
    let news = newly_selected(editor, ui);
    list.show_rows(ui, height, editor.scene().targets.len(), |ui, rows| {
        if let Some(index) = news {
            let step = height + ui.spacing().item_spacing.y;
            let top = ui.max_rect().top() + (index as f32 - rows.start as f32) * step;
            let row = egui::Rect::from_x_y_ranges(ui.max_rect().x_range(), top..=top + height);
            ui.scroll_to_rect_animation(row, None, egui::style::ScrollAnimation::none());
        }
        for index in rows {
            moved = row(editor, index, several, ui).or(moved);
        }
    });
    if let Some((from, to)) = moved {
        let place = edit::reorder(&mut editor.document.scene, from, to);
        editor.selection = [place].into();
    }
    ui.horizontal(|ui| {
        let any = !editor.selection.is_empty();
        ui.add_enabled_ui(any, |ui| {
            if ui.button("Duplicate").on_hover_text("Ctrl D").clicked() {
                clipboard::duplicate_chosen(editor);
            }
            if ui.button("Delete").on_hover_text("Delete").clicked() {
                clipboard::delete(editor);
            }
            let first = editor.selection.first().copied();
            let last = editor.selection.last().copied();
            let count = editor.scene().targets.len();
            for (sign, tip, to) in [
                ("Up", "Earlier in the list", first.and_then(|index| index.checked_sub(1))),
                ("Down", "Later in the list", last.map(|index| index + 1).filter(|&index| index < count)),
            ] {
                let one = editor.selection.len() == 1;
                let button = ui.add_enabled(one && to.is_some(), egui::Button::new(sign)).on_hover_text(tip);
                if let (true, Some(from), Some(to)) = (button.clicked(), first, to) {
                    editor.document.scene.targets.swap(from, to);
                    editor.selection = [to].into();
                }
            }
        });
    });
    match editor.selection.len() {
        0 => {
            ui.label(RichText::new("Select a target to edit its numbers.").weak());
        }
        1 => {
            let index = editor.selection.first().copied().unwrap_or(0);
            let id = ("target", index);
            let wants_file = ui.push_id(id, |ui| {
                let wants_file = target::show(&mut editor.document.scene, index, ui);
                modulation::of_target(editor, index, ui);
                wants_file
            });
            if wants_file.inner {
                editor.dialog = Some(Dialog::path(Purpose::Path(Some(index)), &editor.document));
            }
        }
        count => together(editor, count, ui),
    }
}

/// The last selected target, if the selection is not that of the frame before.
fn newly_selected(editor: &Editor, ui: &Ui) -> Option<usize> {
    let id = egui::Id::unique("selection in the list");
    let before = ui.data_mut(|data| data.get_temp::<BTreeSet<usize>>(id));
    if before.as_ref() == Some(&editor.selection) {
        return None;
    }
    ui.data_mut(|data| data.insert_temp(id, editor.selection.clone()));
    editor.selection.last().copied()
}

/// A target in the list. Returns the move of a target dropped here.
fn row(editor: &mut Editor, index: usize, several: bool, ui: &mut Ui) -> Option<(usize, usize)> {
    let chosen = editor.selection.contains(&index);
    let target = &editor.scene().targets[index];
    let name = format!("{}  {}", index + 1, edit::name(target));
    let group = RichText::new(&target.group).weak();
    let row = ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let visible = &mut editor.document.scene.targets[index].visible;
        ui.checkbox(visible, "")
            .on_hover_text("Played; a target that is not ticked stays in the file")
            .accessible_name(format!("Target {} is played", index + 1));
        let text = if *visible { RichText::new(name) } else { RichText::new(name).weak() };
        // Fills the row, so that the name is left-aligned.
        let mut row = egui::Atoms::new((text, egui::Atom::grow()));
        if !group.is_empty() {
            row.push_right(group);
        }
        let button = egui::Button::selectable(chosen, row).sense(Sense::click_and_drag()).truncate();
        ui.add(button.min_size(egui::vec2(ui.available_width(), 0.0)))
    });
    let response = row.inner.on_hover_text("Drag to reorder the list");
    if response.clicked() {
        editor.body = None;
        match (several, chosen) {
            (false, _) => editor.selection = [index].into(),
            (true, true) => drop(editor.selection.remove(&index)),
            (true, false) => drop(editor.selection.insert(index)),
        }
    }
    walk(index, editor.scene().targets.len(), &response, ui);
    response.dnd_set_drag_payload(Dragged(index));
    let rect = response.rect;
    let is_below = ui.ctx().pointer_interact_pos().is_some_and(|at| at.y > rect.center().y);
    if response.dnd_hover_payload::<Dragged>().is_some() {
        let y = if is_below { rect.bottom() } else { rect.top() };
        ui.painter().hline(rect.x_range(), y, egui::Stroke::new(2.0, theme::ACCENT));
    }
    let dropped = response.dnd_release_payload::<Dragged>()?;
    Some((dropped.0, index + usize::from(is_below)))
}

/// Arrow keys go from row to row.
fn walk(index: usize, count: usize, response: &egui::Response, ui: &Ui) {
    let next = egui::Id::unique("row that gets the keyboard");
    if ui.data(|data| data.get_temp(next)) == Some(index) {
        ui.data_mut(|data| data.remove::<usize>(next));
        response.request_focus();
        response.scroll_to_me(None);
    }
    if !response.has_focus() {
        return;
    }
    let filter = egui::EventFilter { vertical_arrows: true, ..Default::default() };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, filter));
    let (up, down) =
        ui.input(|input| (input.key_pressed(egui::Key::ArrowUp), input.key_pressed(egui::Key::ArrowDown)));
    let to = if up { index.checked_sub(1) } else { Some(index + 1).filter(|&to| down && to < count) };
    if let Some(to) = to {
        ui.data_mut(|data| data.insert_temp(next, to));
        ui.ctx().request_repaint();
    }
}

/// Index of a target dragged in the list.
#[derive(Clone, Copy)]
struct Dragged(usize);

/// The position of an ear, and its exposure.
fn listener(editor: &mut Editor, shown: &Shown, ui: &mut Ui) {
    let listener = &mut editor.document.scene.listener;
    let mut is_there = listener.is_some();
    ui.checkbox(&mut is_there, "Exposure at a listener")
        .on_hover_text("Sound pressure level at a point, such as a bystander's ear");
    if !is_there {
        *listener = None;
        return;
    }
    let listener = listener.get_or_insert(Listener { at: DVec3::new(0.0, -0.3, 0.3) });
    form(ui, "listener", |ui| {
        target::point(ui, "Ear", &mut listener.at);
        if let Some(sound) = shown.sound.as_ref().filter(|sound| sound.is_at_hand()) {
            let heard = probe::reading(&sound.aperture, &sound.heard, listener.at);
            let tip = "Sound pressure level at the ear, of the unmodulated sound";
            fact(ui, ("Level", tip), format!("{:.1} dB SPL", heard.spl()));
            if let Some(warning) = heard.warning() {
                remark(ui, warning, theme::warning(ui.visuals()));
            }
        }
    });
}

/// The controls for several targets.
fn together(editor: &mut Editor, count: usize, ui: &mut Ui) {
    ui.label(format!("{count} targets selected"));
    let Some(first) = editor.selection.first().and_then(|&index| editor.scene().targets.get(index)) else {
        return;
    };
    let mut pressure = first.pressure;
    let mut group = group::common(editor.scene(), &editor.selection).unwrap_or_default().to_owned();
    let (mut is_louder, mut is_renamed) = (false, false);
    form(ui, "together", |ui| {
        let response = number(ui, ("Pressure", "Target pressure of each"), &mut pressure, PLAIN, 0.01..=1e5);
        is_louder = response.changed();
        is_renamed = target::label(ui, target::GROUP, "in no group", &mut group);
    });
    if is_renamed {
        group::rename(&mut editor.document.scene, &editor.selection, &group);
    }
    if is_louder {
        let chosen = |(index, target): (usize, &mut Target)| {
            if editor.selection.contains(&index) {
                target.pressure = pressure;
            }
        };
        editor.document.scene.targets.iter_mut().enumerate().for_each(chosen);
    }
}

/// The scene plane, drawn by `render`, and the button that sets it to the displayed one.
fn plane(editor: &mut Editor, shown: &Shown, ui: &mut Ui) {
    heading(ui, "Scene plane");
    let scene = editor.scene();
    let seen = shown.map.as_ref().map(|map| {
        let lens = crate::ui::view::Lens { rect: map.rect, window: map.window };
        editor.view.plane(scene, &lens)
    });
    let tip = "`sonoglyph render` draws it, and it is the surface of the liquid";
    let plane = &scene.plane;
    let [x, y, z] = plane.centre.to_array().map(|place| ticks::signed(&format!("{:.0}", place * 1e3)));
    ui.label(format!("{:.0} × {:.0} mm, centre ({x}, {y}, {z}) mm", plane.size.x * 1e3, plane.size.y * 1e3,))
        .on_hover_text(tip);
    ui.horizontal(|ui| {
        if let Some(seen) = seen
            && ui
                .button("Set as scene plane")
                .on_hover_text("The part of the plane on the screen becomes the scene plane")
                .clicked()
        {
            editor.document.scene.plane = seen;
        }
        let label = ui.label("Tolerance").on_hover_text("Largest error of a map, relative to its peak");
        let tolerance = &mut editor.document.scene.plane.tolerance;
        egui::ComboBox::from_id_salt("tolerance")
            .selected_text(if *tolerance == 0.0 { "exact".to_owned() } else { format!("{tolerance:e}") })
            .width(64.0)
            .show_ui(ui, |ui| {
                for (choice, name) in [(1e-2, "1e-2"), (1e-3, "1e-3"), (1e-4, "1e-4"), (0.0, "exact")] {
                    ui.selectable_value(tolerance, choice, name);
                }
            })
            .response
            .labelled_by(label.id);
    });
}

fn array(editor: &mut Editor, ui: &mut Ui) {
    let boards = editor.scene().boards.len().max(1);
    let array = &mut editor.document.scene.array;
    let mut asks_for_table = false;
    form(ui, "array", |ui| {
        if array.file.is_none() {
            let before = array.columns;
            count(ui, ("Columns", "Elements along x"), &mut array.columns, 1..=128);
            count(ui, ("Rows", "Elements along y"), &mut array.rows, 1..=128);
            if before != array.columns {
                // Numbers count row by row and would now mean other elements.
                array.off.clear();
                (array.wiring, array.wires) = (None, Wires::default());
            }
            let elements = array.elements() * boards;
            array.off.retain(|&element| element < elements);
            number(ui, ("Pitch", "Distance between neighbouring elements"), &mut array.pitch, MM, 1e-5..=0.2);
        }
        number(ui, ("Element radius", "Of the radiating surface"), &mut array.element_radius, MM, 1e-6..=0.1);
        let khz = Unit { per: 1e-3, suffix: " kHz", decimals: 2, speed: 0.1 };
        number(ui, ("Frequency", "Of the carrier"), &mut array.frequency, khz, 1e3..=20e6);
        let strength = Unit { per: 1.0, suffix: " Pa·m", decimals: 2, speed: 0.02 };
        number(
            ui,
            ("Strength", "Peak pressure of one element on its axis, times the distance"),
            &mut array.strength,
            strength,
            1e-3..=1e4,
        );
        let described = |&model: &ElementModel| match model {
            ElementModel::Piston => (model, "piston, far field"),
            ElementModel::ExactPiston => (model, "piston, near field"),
            ElementModel::Point => (model, "omnidirectional"),
            ElementModel::Rectangle => (model, "rectangle, far field"),
            ElementModel::Cosine => (model, "power of the cosine"),
            ElementModel::Measured => (model, "measured"),
        };
        let models: Vec<_> = ElementModel::VARIANTS.iter().map(described).collect();
        let before = array.element;
        choice(ui, ("Directivity", "Of one element"), &mut array.element, &models);
        if array.element == ElementModel::Measured && array.directivity.is_none() {
            (array.element, asks_for_table) = (before, true);
        }
        asks_for_table |= of_model(array, ui);
        response(array, ui);
        let tip = "Random differences of gain between elements, rms; the Solver page shows their effect";
        number(ui, ("Spread of gain", tip), &mut array.spread.gain, PERCENT, 0.0..=1.0);
        let tip = "Random differences of phase between elements, rms";
        number(ui, ("Spread of phase", tip), &mut array.spread.phase, DEGREES, 0.0..=PI);
    });
    if asks_for_table {
        editor.dialog = Some(Dialog::path(Purpose::Directivity, &editor.document));
    }
    boards::known(editor, ui);
    boards::wiring(editor, ui);
    ui.label("Click or drag to switch elements on and off:");
    switches(editor, ui);
}

/// The keys of an element's model. Returns whether a table is asked for.
fn of_model(array: &mut Array, ui: &mut Ui) -> bool {
    match array.element {
        ElementModel::Piston | ElementModel::ExactPiston | ElementModel::Point => false,
        ElementModel::Rectangle => {
            let size = &mut array.element_size;
            number(ui, ("Element width", "Along the element's x axis"), &mut size.x, MM, 1e-6..=0.2);
            number(ui, ("Element height", "Along the element's y axis"), &mut size.y, MM, 1e-6..=0.2);
            false
        }
        ElementModel::Cosine => {
            let plain = Unit { per: 1.0, suffix: "", decimals: 2, speed: 0.02 };
            let tip = "n: the amplitude falls as the n-th power of the cosine of the angle from the axis";
            number(ui, ("Exponent", tip), &mut array.element_exponent, plain, 0.0..=1e3);
            false
        }
        ElementModel::Measured => {
            let name = array.directivity.as_deref().unwrap_or_default();
            let tip = "CSV with angle (degrees), amplitude or level (dB), and perhaps phase (degrees)";
            fact(ui, ("Directivity table", tip), echo::value(name).to_string());
            caption(ui, "");
            let button = value(ui, |ui| ui.button("Choose…")).on_hover_text("Another CSV file");
            ui.end_row();
            button.clicked()
        }
    }
}

/// How elements follow their drive: at once, as a known transducer, or as a resonance.
fn response(array: &mut Array, ui: &mut Ui) {
    let own = match array.response {
        Some(Response::Pole(pole)) => pole,
        Some(Response::Preset(_)) | None => Pole { resonance: array.frequency, tau: TYPICAL_TAU },
    };
    let known = Transducer::VARIANTS.iter().map(|&it| (Some(Response::Preset(it)), it.title()));
    let choices: Vec<_> = [(None, "at once")]
        .into_iter()
        .chain(known)
        .chain([(Some(Response::Pole(own)), "resonance")])
        .collect();
    let tip = "How an element follows changes of its drive: moving foci and modulations lose pressure";
    choice(ui, ("Response", tip), &mut array.response, &choices);
    if let Some(Response::Pole(pole)) = &mut array.response {
        let hertz = Unit { per: 1.0, suffix: " Hz", decimals: 0, speed: 5.0 };
        number(ui, ("Resonance", "Of the motional branch"), &mut pole.resonance, hertz, 1e3..=20e6);
        let ms = Unit { per: 1e3, suffix: " ms", decimals: 3, speed: 0.001 };
        number(ui, ("Time constant", "Of the amplitude"), &mut pole.tau, ms, 1e-6..=0.1);
    }
}

/// The array as a map of switches. A drag sets every element like the first.
fn switches(editor: &mut Editor, ui: &mut Ui) {
    let driven: std::collections::HashSet<_> = editor.scene().driven().into_iter().collect();
    let (response, under) =
        element_map::show(ui, "Elements that play", editor.scene(), Sense::click_and_drag(), |n| {
            driven.contains(&n).then_some(theme::ACCENT)
        });
    let elements = editor.scene().elements();
    let array = &mut editor.document.scene.array;
    let id = response.id.with("switching");
    let pressed = response.is_pointer_button_down_on() && ui.input(|input| input.pointer.primary_pressed());
    if let (true, Some(n)) = (pressed, under) {
        ui.data_mut(|data| data.insert_temp(id, driven.contains(&n)));
    }
    let switching = ui.data(|data| data.get_temp::<bool>(id));
    if let (true, Some(n), Some(to_off)) = (response.is_pointer_button_down_on(), under, switching) {
        array.off.retain(|&element| element != n);
        // At least one element must play.
        if to_off && driven.iter().any(|&other| other != n) {
            array.off.push(n);
            array.off.sort_unstable();
        }
    }
    ui.horizontal(|ui| {
        let off = array.off.len();
        ui.label(format!("{} of {elements} elements on", driven.len()));
        if ui.add_enabled(off > 0, egui::Button::new("All on")).clicked() {
            array.off.clear();
        }
    });
}

fn air(editor: &mut Editor, ui: &mut Ui) {
    let frequency = editor.scene().array.frequency;
    let medium = &mut editor.document.scene.medium;
    let air = Air::of_weather(medium, frequency);
    form(ui, "air", |ui| {
        let celsius = Unit { per: 1.0, suffix: " °C", decimals: 1, speed: 0.1 };
        number(ui, ("Temperature", "Of the air"), &mut medium.temperature, celsius, -50.0..=100.0);
        let percent = Unit { per: 1.0, suffix: " %", decimals: 0, speed: 0.3 };
        number(ui, ("Humidity", "Relative"), &mut medium.humidity, percent, 0.0..=100.0);
        let hectopascal = Unit { per: 0.01, suffix: " hPa", decimals: 1, speed: 1.0 };
        number(ui, ("Air pressure", "Static"), &mut medium.pressure, hectopascal, 1e3..=1e6);
        let speed = Unit { per: 1.0, suffix: " m/s", decimals: 2, speed: 0.1 };
        given(
            ui,
            ("Sound speed", "From the temperature"),
            &mut medium.sound_speed,
            air.sound_speed,
            speed,
            1.0..=1e4,
        );
        let density = Unit { per: 1.0, suffix: " kg/m³", decimals: 3, speed: 0.001 };
        given(
            ui,
            ("Density", "From temperature, humidity and air pressure"),
            &mut medium.density,
            air.density,
            density,
            1e-3..=1e4,
        );
        let absorption = Unit { per: 1.0, suffix: " dB/m", decimals: 2, speed: 0.01 };
        given(
            ui,
            ("Absorption", "From temperature, humidity and air pressure"),
            &mut medium.absorption,
            air.absorption(),
            absorption,
            0.0..=1e5,
        );
    });
    ui.horizontal(|ui| {
        let menu = ui.menu_button("Known media", |ui| {
            for fluid in Fluid::VARIANTS {
                if ui.button(fluid.title()).clicked() {
                    let [speed, density, absorption] = fluid.properties(frequency).map(Some);
                    let medium = &mut editor.document.scene.medium;
                    (medium.sound_speed, medium.density, medium.absorption) = (speed, density, absorption);
                    ui.close();
                }
            }
        });
        menu.response.on_hover_text("Sound speed, density and absorption at the array's frequency");
    });
}
