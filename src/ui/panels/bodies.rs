//! The panel of bodies: their list, and the numbers of the chosen one.

use egui::{CollapsingHeader, Id, Ui};
use glam::DVec3;
use strum::VariantArray;

use crate::echo;
use crate::scene::{Body, BodyKind, FINGERS};
use crate::ui::bodies::{self, title};
use crate::ui::command::Purpose;
use crate::ui::dialog::state::Dialog;
use crate::ui::editor::Editor;
use crate::ui::panels::boards::{facing, place, turn};
use crate::ui::panels::form::{caption, choice, fact, form, given, number, remark, value};
use crate::ui::panels::{MM, PLAIN, Unit};
use crate::ui::{clipboard, theme};

/// Lower limit of positions, mm.
const LOWEST: f64 = -2000.0;
/// m
const RADIUS: std::ops::RangeInclusive<f64> = 1e-5..=1.0;
const SIDE: std::ops::RangeInclusive<f64> = 1e-4..=1.0;
const EDGE: std::ops::RangeInclusive<f64> = 1e-4..=0.1;
/// Least pressure reflection: that of soft bodies, -1, has no answer.
const SOFTEST: f64 = -0.99;

/// The list, opened when a body is chosen on the map.
pub fn section(editor: &mut Editor, ui: &mut Ui) {
    let id = Id::unique("body in the list");
    let before = ui.data_mut(|data| data.get_temp::<Option<usize>>(id)).flatten();
    let chosen = editor.chosen_body();
    ui.data_mut(|data| data.insert_temp(id, chosen));
    let opens = (chosen.is_some() && chosen != before).then_some(true);
    CollapsingHeader::new("Bodies").open(opens).show(ui, |ui| show(editor, ui));
}

fn show(editor: &mut Editor, ui: &mut Ui) {
    for index in 0..editor.scene().bodies.len() {
        let name = format!("Body {}: {}", index + 1, title(editor.scene().bodies[index].kind));
        if ui.selectable_label(editor.chosen_body() == Some(index), name).clicked() {
            editor.choose_body(index);
        }
    }
    ui.horizontal(|ui| {
        add(editor, ui);
        ui.add_enabled_ui(editor.chosen_body().is_some(), |ui| {
            if ui.button("Duplicate body").on_hover_text("Ctrl D").clicked() {
                clipboard::duplicate_chosen(editor);
            }
            if ui.button("Delete body").on_hover_text("Delete").clicked() {
                clipboard::delete_chosen(editor);
            }
        });
    });
    match editor.chosen_body() {
        Some(index) => {
            ui.push_id(("body", index), |ui| numbers(editor, index, ui));
        }
        None if editor.scene().bodies.is_empty() => {
            ui.weak("A hand, a finger or a part in the field scatters its sound.");
        }
        None => drop(ui.weak("Choose a body to edit its numbers.")),
    }
}

/// The menu of new bodies.
fn add(editor: &mut Editor, ui: &mut Ui) {
    ui.menu_button("Add body", |ui| {
        for &kind in BodyKind::VARIANTS {
            let (name, tip) = match kind {
                BodyKind::Sphere => ("Sphere", "A ball such as a fingertip"),
                BodyKind::Capsule => ("Capsule", "A cylinder with round ends, such as a finger"),
                BodyKind::Palm => ("Palm", "A flat hand's palm, on the first target"),
                BodyKind::Hand => ("Hand", "A hand with its fingers, its palm on the first target"),
                BodyKind::Mesh => ("Mesh file…", "A closed surface: STL or OBJ"),
            };
            if !ui.button(name).on_hover_text(tip).clicked() {
                continue;
            }
            ui.close();
            if kind == BodyKind::Mesh {
                editor.dialog = Some(Dialog::path(Purpose::Body(None), &editor.document));
            } else {
                let body = bodies::usual(editor, kind);
                bodies::add(editor, body);
            }
        }
    });
}

fn numbers(editor: &mut Editor, index: usize, ui: &mut Ui) {
    let edge = editor.scene().wavelength() / 6.0;
    let body = &mut editor.document.scene.bodies[index];
    let mut asks_for_file = false;
    form(ui, "body", |ui| {
        let kinds: Vec<_> = BodyKind::VARIANTS.iter().map(|&kind| (kind, title(kind))).collect();
        let before = body.kind;
        choice(ui, ("Kind", "The shape of the body"), &mut body.kind, &kinds);
        if body.kind == BodyKind::Mesh && body.file.is_none() {
            (body.kind, asks_for_file) = (before, true);
        }
        place(ui, "Place", &mut body.at, LOWEST);
        shape(body, ui);
        asks_for_file |= body.kind == BodyKind::Mesh && file(body, ui);
        directions(body, ui);
        let tip = "Pressure reflection of its surface: 1 rigid, 0 without echo";
        number(ui, ("Reflection", tip), &mut body.coefficient, PLAIN, SOFTEST..=1.0);
        if body.kind != BodyKind::Sphere {
            let tip = "Of the triangles that stand for its surface: a sixth of the wavelength, longer for large bodies";
            given(ui, ("Edge", tip), &mut body.edge, edge, MM, EDGE);
        }
    });
    if body.kind != BodyKind::Sphere {
        ui.horizontal(|ui| {
            if let Some(by) = turn(ui) {
                *body = bodies::turned(body, by);
            }
        });
    }
    figures(editor, index, ui);
    if asks_for_file {
        editor.dialog = Some(Dialog::path(Purpose::Body(Some(index)), &editor.document));
    }
}

/// The lengths and angles of a kind.
fn shape(body: &mut Body, ui: &mut Ui) {
    match body.kind {
        BodyKind::Sphere => drop(number(ui, ("Radius", "Of the sphere"), &mut body.radius, MM, RADIUS)),
        BodyKind::Capsule => {
            number(ui, ("Radius", "Of the cylinder and its ends"), &mut body.radius, MM, RADIUS);
            let least = 2.0 * body.radius;
            body.length = body.length.max(least);
            number(ui, ("Length", "From end to end"), &mut body.length, MM, least..=2.0);
        }
        BodyKind::Palm | BodyKind::Hand => {
            let rows = [("Length", "Of the palm, along the fingers"), ("Width", "Of the palm, across")];
            let rows = rows.into_iter().chain([("Thickness", "Of the palm")]);
            for (row, side) in rows.zip(body.size.as_mut()) {
                number(ui, row, side, MM, SIDE);
            }
            if body.kind == BodyKind::Hand {
                let degrees = Unit { per: 1.0, suffix: "°", decimals: 0, speed: 0.5 };
                let names = ["Thumb", "Index finger", "Middle finger", "Ring finger", "Little finger"];
                for ((name, angle), (_, most)) in names.into_iter().zip(&mut body.fingers).zip(FINGERS) {
                    number(ui, (name, "The angle by which it is bent"), angle, degrees, 0.0..=most);
                }
            }
        }
        BodyKind::Mesh => {}
    }
}

/// The file of a mesh; returns whether another is to be chosen.
fn file(body: &mut Body, ui: &mut Ui) -> bool {
    let name = body.file.as_deref().unwrap_or_default();
    fact(ui, ("File", "STL or OBJ"), echo::value(name).to_string());
    let tip = "What a unit of the file is: 1 mm, or 1000 mm for files in metres";
    let unit = Unit { decimals: 4, speed: 0.01, ..MM };
    number(ui, ("Unit of file", tip), &mut body.scale, unit, 1e-9..=1e3);
    caption(ui, "");
    let button = value(ui, |ui| ui.button("Choose…")).on_hover_text("Another STL or OBJ file");
    ui.end_row();
    button.clicked()
}

/// The directions that a kind has.
fn directions(body: &mut Body, ui: &mut Ui) {
    let rows = match body.kind {
        BodyKind::Sphere => return,
        BodyKind::Capsule => [None, Some(("Axis", "The direction of its axis"))],
        BodyKind::Palm => [
            Some(("Faces", "The direction to which the palm's skin faces")),
            Some(("Fingers", "The direction of its length")),
        ],
        BodyKind::Hand => [
            Some(("Faces", "The direction to which the palm's skin faces")),
            Some(("Fingers", "The direction of its fingers")),
        ],
        BodyKind::Mesh => [
            Some(("z axis", "The direction of the file's z axis")),
            Some(("x axis", "The direction of the file's x axis")),
        ],
    };
    let before = body.clone();
    let [normal, x_axis] = rows;
    let mut towards = before.normal();
    if let Some(row) = normal
        && facing(ui, row, &mut towards)
    {
        body.normal = Some(towards);
        if body.axes().is_none() {
            body.x_axis = towards.any_orthonormal_vector();
        }
    }
    if let Some(row) = x_axis
        && facing(ui, row, &mut body.x_axis)
        && body.axes().is_none()
    {
        // What points along the new axis is turned out of its way.
        let turned = before.axes().map_or(DVec3::Z, |axes| axes.x_axis);
        body.normal = Some(if before.normal().dot(body.x_axis) > 0.0 { -turned } else { turned });
    }
}

/// How exact the body's sound is.
fn figures(editor: &Editor, index: usize, ui: &mut Ui) {
    let Some(found) = editor.parts.scattering.newest() else { return };
    let bodies = &editor.scene().bodies;
    let loaded = bodies[..index].iter().filter(|body| !body.lacks_surface()).count();
    let error = found.errors.get(loaded).filter(|_| !bodies[index].lacks_surface());
    form(ui, "figures", |ui| {
        let tip = "Estimated error of the sound that the body scatters, relative to it";
        let text = match (error, bodies[index].kind, editor.parts.scattering.exact()) {
            (_, BodyKind::Sphere, _) => "exact series".to_owned(),
            (Some(error), _, Some(_)) => format!("scattered sound within {:.1} %", 100.0 * error.outside),
            (Some(_), _, None) => "…".to_owned(),
            (None, _, _) => "none".to_owned(),
        };
        fact(ui, ("Error", tip), text);
        if found.triangles > 0 {
            fact(ui, ("Triangles", "Of all bodies"), found.triangles.to_string());
        }
        if let Some(problem) = &found.problem {
            remark(ui, problem.as_str(), theme::warning(ui.visuals()));
        }
    });
}
