//! The panel of boards, published arrays and reflectors.

use std::f64::consts::FRAC_PI_2;

use egui::Ui;
use glam::{DQuat, DVec3};

use crate::device::wiring;
use crate::scene::{Board, Elements, Reflector, Scene, Wires};
use crate::studio::arrays::PRESET;
use crate::studio::presets::KNOWN;
use crate::ui::panels::form::{choice, coordinates_at_right};
use crate::ui::panels::{PLAIN, caption, form, number};
use crate::ui::{command::Purpose, dialog::state::Dialog, editor::Editor, ticks, tip};

/// Lower limit of positions, mm.
const LOWEST: f64 = -2000.0;
/// Directions that boards and reflectors usually face.
const DIRECTIONS: [(DVec3, &str); 6] = [
    (DVec3::Z, "up, +z"),
    (DVec3::NEG_Z, "down, -z"),
    (DVec3::X, "right, +x"),
    (DVec3::NEG_X, "left, -x"),
    (DVec3::Y, "back, +y"),
    (DVec3::NEG_Y, "front, -y"),
];
const FACES: (&str, &str) = ("Faces", "The direction in which sound goes");
/// Rotation per click, rad.
const TURN: f64 = FRAC_PI_2 / 6.0;

/// A menu of published arrays, and an entry for element tables.
pub fn known(editor: &mut Editor, ui: &mut Ui) {
    ui.horizontal(|ui| {
        published(editor, ui);
        let tip = "Elements at arbitrary positions, from CSV or a PAT file of OpenMPD";
        if ui.button("From a table…").on_hover_text(tip).clicked() {
            editor.dialog = Some(Dialog::path(Purpose::Elements, &editor.document));
        }
    });
    if let Some(file) = &editor.scene().array.file {
        ui.label(format!("Elements of {file}"));
        if ui.button("Rows and columns again").clicked() {
            let array = &mut editor.document.scene.array;
            (array.file, array.placed) = (None, Elements::default());
            (array.wiring, array.wires) = (None, Wires::default());
            keep_off(&mut editor.document.scene);
        }
    }
}

/// The channels of the board that the elements are wired to.
pub fn wiring(editor: &mut Editor, ui: &mut Ui) {
    ui.horizontal(|ui| {
        let menu = ui.menu_button("Wiring", |ui| {
            let array = &mut editor.document.scene.array;
            for name in wiring::presets() {
                let preset = wiring::preset(name, array.elements());
                let button = ui.add_enabled(preset.is_ok(), egui::Button::new(name));
                let reason = preset.as_ref().err().map_or("", String::as_str);
                if let (true, Ok(wires)) = (button.on_disabled_hover_text(reason).clicked(), &preset) {
                    (array.wiring, array.wires) = (Some(format!("{PRESET}{name}")), wires.clone());
                    ui.close();
                }
            }
            if ui.button("From a table…").clicked() {
                editor.dialog = Some(Dialog::path(Purpose::Wiring, &editor.document));
            }
        });
        menu.response.on_hover_text("The channel of the board for each element: a known board's, or CSV");
        let name = match &editor.scene().array.wiring {
            Some(name) => name.clone(),
            None if editor.scene().wires().is_some() => "the pins of the elements' file".to_owned(),
            None => "the board's own order".to_owned(),
        };
        ui.label(name);
        if editor.scene().array.wiring.is_some() && ui.small_button("Remove").clicked() {
            let array = &mut editor.document.scene.array;
            (array.wiring, array.wires) = (None, Wires::default());
        }
    });
}

fn published(editor: &mut Editor, ui: &mut Ui) {
    ui.menu_button("Known arrays", |ui| {
        for known in KNOWN {
            let button = ui.button(known.title);
            tip::beside(&button, known.source());
            if button.clicked()
                && let Some((array, boards)) = known.array()
            {
                let scene = &mut editor.document.scene;
                (scene.array, scene.boards) = (array, boards);
            }
        }
    })
    .response
    .on_hover_text("Takes rows, columns, positions and strength of a published array");
}

pub fn show(editor: &mut Editor, ui: &mut Ui) {
    let scene = &mut editor.document.scene;
    let mut removed = None;
    for (index, board) in scene.boards.iter_mut().enumerate() {
        let name = format!("Board {}", index + 1);
        ui.push_id(&name, |ui| {
            form(ui, "place", |ui| {
                place(ui, &name, &mut board.at, LOWEST);
                if facing(ui, FACES, &mut board.normal) {
                    board.x_axis = board.normal.any_orthonormal_vector();
                }
            });
        });
        ui.horizontal(|ui| {
            if let Some(turn) = turn(ui) {
                (board.normal, board.x_axis) = (turn * board.normal, turn * board.x_axis);
            }
            if ui.small_button("Remove").clicked() {
                removed = Some(index);
            }
        });
    }
    if let Some(index) = removed {
        scene.boards.remove(index);
        keep_off(scene);
    }
    ui.horizontal(|ui| {
        if ui.button("Add board").on_hover_text("A copy of the array").clicked() {
            add(scene, |last| Board { at: last.at + DVec3::X * 0.2, ..last });
        }
        let tip = "The same array face to face with the last board, 20 cm away";
        if ui.button("Add opposite").on_hover_text(tip).clicked() {
            add(scene, |last| Board {
                at: last.at + last.normal.normalize_or(DVec3::Z) * 0.2,
                normal: -last.normal,
                x_axis: last.x_axis,
            });
        }
    });
}

/// Buttons for turning about the axes.
pub(super) fn turn(ui: &mut Ui) -> Option<DQuat> {
    ui.label("Turn");
    let mut turned = None;
    for (axis, sign) in [(DVec3::X, "x"), (DVec3::Y, "y"), (DVec3::Z, "z")] {
        let tip = format!("By 15° about {sign}; with Shift the other way");
        if ui.small_button(sign).on_hover_text(tip).clicked() {
            let turn = if ui.input(|input| input.modifiers.shift) { -TURN } else { TURN };
            turned = Some(DQuat::from_axis_angle(axis, turn));
        }
    }
    turned
}

/// Adds a board that follows from the last one.
fn add(scene: &mut Scene, next: impl FnOnce(Board) -> Board) {
    if scene.boards.is_empty() {
        scene.boards.push(Board::default());
    }
    let last = scene.boards.last().cloned().unwrap_or_default();
    scene.boards.push(next(last));
}

/// Drops undriven elements that no longer exist.
fn keep_off(scene: &mut Scene) {
    let elements = scene.elements();
    scene.array.off.retain(|&element| element < elements);
}

/// The reflectors.
pub fn reflectors(editor: &mut Editor, ui: &mut Ui) {
    let scene = &mut editor.document.scene;
    let tip = "The liquid's surface, the scene plane, reflects sound: shows the standing wave in front of it";
    ui.checkbox(&mut scene.liquid.reflects, "Liquid's surface").on_hover_text(tip);
    form(ui, "reflectivity", |ui| {
        let tip = "Pressure reflection coefficient of the array's face, for parallel reflectors";
        number(ui, ("Array's face", tip), &mut scene.array.reflectivity, PLAIN, -1.0..=1.0);
    });
    let mut removed = None;
    for (index, reflector) in scene.reflectors.iter_mut().enumerate() {
        let name = format!("Reflector {}", index + 1);
        ui.push_id(&name, |ui| {
            form(ui, "place", |ui| {
                place(ui, &name, &mut reflector.point, LOWEST);
                facing(ui, FACES, &mut reflector.normal);
                let tip = "Pressure reflection coefficient: 1 rigid, -1 soft";
                number(ui, ("Coefficient", tip), &mut reflector.coefficient, PLAIN, -1.0..=1.0);
            });
        });
        if ui.small_button("Remove").clicked() {
            removed = Some(index);
        }
    }
    if let Some(index) = removed {
        scene.reflectors.remove(index);
    }
    if ui.button("Add reflector").on_hover_text("An infinite plane").clicked() {
        scene.reflectors.push(Reflector::default());
    }
}

pub(super) fn place(ui: &mut Ui, name: &str, at: &mut DVec3, lowest: f64) {
    caption(ui, name).on_hover_text("x, y and z of its position");
    coordinates_at_right(ui, name, at, lowest);
    ui.end_row();
}

/// A direction; returns whether it changed.
pub(super) fn facing(ui: &mut Ui, row: (&str, &str), normal: &mut DVec3) -> bool {
    let before = normal.normalize_or(DVec3::Z);
    let mut towards = before;
    let own = before.to_array().map(|part| ticks::signed(&format!("{part:.2}"))).join(", ");
    let mut choices = DIRECTIONS.to_vec();
    if !DIRECTIONS.iter().any(|(direction, _)| *direction == before) {
        choices.push((before, &own));
    }
    choice(ui, row, &mut towards, &choices);
    if towards == before {
        return false;
    }
    *normal = towards;
    true
}
