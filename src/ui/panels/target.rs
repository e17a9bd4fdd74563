//! The numbers of a single target.

use std::f64::consts::PI;

use egui::{TextEdit, Ui};
use glam::{DVec2, DVec3};

use crate::scene::check::{MOST_FOCI, MOST_LETTERS};
use crate::scene::{MotionPath, Pressures, Sampling, Scene, Shape, ShapeKey, ShapeValue, Target, Trap, font};
use crate::ui::panels::form::{bare_count, choice, coordinates_at_right, count, remark, variants};
use crate::ui::panels::path::{self, Figures};
use crate::ui::panels::{DEGREES, MM, PLAIN, Unit, caption, form, number, value};
use crate::ui::{theme, tip};

/// Initial spacing of an outline's focal points, m.
const SPACING: f64 = 0.01;
/// Initial width of a broad stroke, m.
const WIDTH: f64 = 0.006;
pub const GROUP: (&str, &str) = ("Group", "Targets with the same group are selected together on the map");
/// m
const LENGTH: std::ops::RangeInclusive<f64> = 1e-4..=10.0;

/// Returns whether a file for its path is to be chosen.
pub fn show(scene: &mut Scene, index: usize, ui: &mut Ui) -> bool {
    let pressures = scene.solver.pressures;
    let takes_turns = scene.motion.path == MotionPath::Steps;
    let figures = Figures::of(scene, Some(index));
    let Some(target) = scene.targets.get_mut(index) else { return false };
    form(ui, "target", |ui| {
        let kind = target.shape.title();
        label(ui, ("Name", "What the target is called in lists and warnings"), &kind, &mut target.name);
        shape(target, ui);
        distance(target, ui);
        holding(target, ui);
        let has_inside = target.shape.inside().is_ok();
        if target.sampling == Sampling::Fill && !has_inside {
            target.sampling = Sampling::Continuous;
        }
        pressure(target, pressures, ui);
        if target.sampling != Sampling::Whole {
            sampling(ui, &mut target.sampling, if has_inside { &AREAS } else { &AREAS[..1] });
        }
        if !target.shape.is_round() {
            number(ui, ("Angle", "Rotation about its centre"), &mut target.angle, DEGREES, -7.0..=7.0);
        }
        step(target, takes_turns, ui);
        label(ui, GROUP, "in no group", &mut target.group);
    });
    own_motion(target, figures, ui)
}

/// A possibly empty name with a placeholder `hint`.
pub fn label(ui: &mut Ui, (name, tip): (&str, &str), hint: &str, text: &mut String) -> bool {
    let label = caption(ui, name).on_hover_text(tip);
    let field = TextEdit::singleline(text).hint_text(hint).char_limit(MOST_LETTERS).desired_width(150.0);
    let changed = value(ui, |ui| ui.add(field)).labelled_by(label.id).changed();
    text.retain(|letter| !letter.is_control());
    ui.end_row();
    changed
}

/// The target's own motion, if any; returns whether a file for its path is to be chosen.
fn own_motion(target: &mut Target, figures: Option<Figures>, ui: &mut Ui) -> bool {
    let mut has_own = target.motion.is_some();
    ui.checkbox(&mut has_own, "Own motion")
        .on_hover_text("Instead of the scene's motion; with the path \"none\" the target is at rest");
    if !has_own {
        target.motion = None;
        return false;
    }
    path::settings(target.motion.get_or_insert_default(), figures, true, ui)
}

fn shape(target: &mut Target, ui: &mut Ui) {
    for ShapeKey { row, value, .. } in target.shape.keys() {
        match value {
            ShapeValue::Point(at) => point(ui, row.0, at),
            ShapeValue::Vertices(vertices) => {
                let before = vertices.iter().sum::<DVec3>() / vertices.len().max(1) as f64;
                let mut centre = before;
                point(ui, row.0, &mut centre);
                if centre != before {
                    vertices.iter_mut().for_each(|vertex| *vertex += centre - before);
                }
            }
            ShapeValue::Length(length) => drop(number(ui, row, length, MM, LENGTH)),
            ShapeValue::Sides(sides) => drop(count(ui, row, sides, 3..=64)),
            ShapeValue::Closed(closed) => {
                caption(ui, row.0);
                self::value(ui, |ui| ui.checkbox(closed, "")).on_hover_text(row.1).accessible_name(row.0);
                ui.end_row();
            }
            ShapeValue::Letters(text) => letters(ui, text),
            ShapeValue::File(file) => {
                caption(ui, row.0);
                ui.label(file.as_str()).on_hover_text(row.1);
                ui.end_row();
            }
            ShapeValue::Direction(direction) => towards(ui, direction),
            // A point has them too, to become a trap.
            ShapeValue::Trap(_) | ShapeValue::Charge(_) => {}
        }
    }
}

/// Whether a point is at infinity.
fn distance(target: &mut Target, ui: &mut Ui) {
    if !(target.shape.is_point() || target.shape.is_direction()) {
        return;
    }
    let mut is_far = target.shape.is_direction();
    ui.checkbox(&mut is_far, "Far away").on_hover_text("A plane wave in this direction, instead of a focus");
    ui.end_row();
    if is_far != target.shape.is_direction() {
        let at = target.shape.centre();
        target.shape = match is_far {
            true => Shape::Direction { direction: at.try_normalize().unwrap_or(DVec3::Z) },
            false => Shape::Point { at },
        };
    }
}

/// The angles of a direction.
fn towards(ui: &mut Ui, direction: &mut DVec3) {
    let flat = direction.truncate();
    let mut tilt = flat.length().atan2(direction.z);
    let mut azimuth = if flat == DVec2::ZERO { 0.0 } else { flat.y.atan2(flat.x) };
    let before = (tilt, azimuth);
    number(ui, ("Tilt", "Of the direction, from +z"), &mut tilt, DEGREES, 0.0..=PI);
    number(ui, ("Azimuth", "Of the direction, from +x to +y"), &mut azimuth, DEGREES, -PI..=PI);
    if before != (tilt, azimuth) {
        let way = DVec2::from_angle(azimuth).extend(0.0) * tilt.sin() + DVec3::Z * tilt.cos();
        // Right angles are exact.
        *direction =
            DVec3::from_array(way.to_array().map(|part| if part.abs() < 1e-15 { 0.0 } else { part }));
    }
}

/// A point's trap.
fn holding(target: &mut Target, ui: &mut Ui) {
    if !(target.shape.is_point() || target.shape.is_trap()) {
        return;
    }
    let (mut kind, mut charge) = target.shape.trap().map_or((None, 1), |(kind, charge)| (Some(kind), charge));
    let traps = variants(Trap::title).into_iter().map(|(trap, title)| (Some(trap), title));
    let choices: Vec<_> = std::iter::once((None, "focus only")).chain(traps).collect();
    choice(ui, ("Trap", "The kind of trap that holds a bead"), &mut kind, &choices);
    if kind == Some(Trap::Vortex) {
        let mut turns = f64::from(charge);
        let most = f64::from(Trap::MOST_TURNS);
        let whole = Unit { per: 1.0, suffix: "", decimals: 0, speed: 0.1 };
        number(ui, ("Turns", "Of the phase, once around the axis"), &mut turns, whole, -most..=most);
        let turns = turns.round() as i32;
        charge = if turns == 0 { -charge.signum() } else { turns };
    }
    let at = target.shape.centre();
    target.shape = match kind {
        None => Shape::Point { at },
        Some(trap) => Shape::Trap { at, trap, charge },
    };
}

/// A text field that accepts letters of the stroke font only and is never empty; missing letters are reported.
fn letters(ui: &mut Ui, text: &mut String) {
    let label = caption(ui, "Text");
    let mut edited = text.clone();
    let field = TextEdit::singleline(&mut edited).desired_width(150.0);
    let response = value(ui, |ui| ui.add(field)).labelled_by(label.id);
    let id = response.id.with("lacking");
    if response.changed() {
        let lacking = font::lacking(&edited);
        ui.data_mut(|data| data.insert_temp(id, lacking.clone()));
        edited.retain(|letter| !lacking.contains(&letter));
        if !edited.trim().is_empty() {
            *text = edited;
        }
    }
    ui.end_row();
    let lacking: Vec<char> = ui.data(|data| data.get_temp(id)).unwrap_or_default();
    if !lacking.is_empty() && response.has_focus() {
        remark(ui, font::lacks(&lacking), theme::warning(ui.visuals()));
    }
}

/// x, y and z in mm, in front of the array.
pub fn point(ui: &mut Ui, name: &str, at: &mut DVec3) {
    caption(ui, &format!("{name}, mm"))
        .on_hover_text("x, y, z; the array lies in z = 0, its centre at the origin");
    coordinates_at_right(ui, name, at, 1.0);
    ui.end_row();
}

fn pressure(target: &mut Target, pressures: Pressures, ui: &mut Ui) {
    match pressures {
        Pressures::Relative => {
            let tip = "Target pressure, relative to the other targets";
            number(ui, ("Pressure", tip), &mut target.pressure, PLAIN, 0.01..=100.0);
        }
        Pressures::Pascal => {
            let unit = Unit { per: 1.0, suffix: " Pa", decimals: 0, speed: 10.0 };
            let tip = "Target pressure at every focus, peak";
            number(ui, ("Pressure", tip), &mut target.pressure, unit, 1.0..=1e5);
        }
    }
}

/// A sampling of a shape: its name, description, and initial value.
type Choice = (&'static str, &'static str, Sampling);

const OUTLINES: [Choice; 3] = [
    ("Continuous", "Equal pressure along the whole stroke", Sampling::Continuous),
    ("Spacing", "Foci at this spacing along the outline", Sampling::Spacing(SPACING)),
    ("Count", "This many foci along the outline", Sampling::Points(16)),
];
const AREAS: [Choice; 2] = [
    ("Broad", "A stroke of finite width", Sampling::Stroke(WIDTH)),
    ("Filled", "The area inside the outline", Sampling::Fill),
];

/// Selects strokes, separate focal points with their number, or one of these areas.
pub fn sampling(ui: &mut Ui, sampling: &mut Sampling, areas: &[Choice]) {
    let tip = "Continuous, separate foci, or an area";
    let label = caption(ui, "Stroke").on_hover_text(tip);
    let is_chosen =
        |own: &Sampling, other: &Sampling| std::mem::discriminant(own) == std::mem::discriminant(other);
    let choices = || OUTLINES.iter().chain(areas);
    let current = choices().find(|(.., choice)| is_chosen(sampling, choice)).map_or("", |(name, ..)| name);
    let list = value(ui, |ui| {
        egui::ComboBox::from_id_salt("stroke").selected_text(current).show_ui(ui, |ui| {
            for (name, tip, choice) in choices() {
                let chosen = is_chosen(sampling, choice);
                let entry = ui.selectable_label(chosen, *name);
                tip::beside(&entry, tip);
                if entry.clicked() && !chosen {
                    *sampling = *choice;
                }
            }
        })
    });
    list.response.labelled_by(label.id).on_hover_text(tip);
    ui.end_row();
    match sampling {
        Sampling::Whole | Sampling::Continuous | Sampling::Fill => {}
        Sampling::Stroke(width) => {
            number(ui, ("Width", "Of the stroke"), width, MM, 1e-3..=0.2);
        }
        Sampling::Spacing(spacing) => {
            number(ui, ("Focus spacing", "Between foci along the outline"), spacing, MM, 1e-3..=0.2);
        }
        Sampling::Points(points) => {
            let mut foci = *points as u32;
            count(ui, ("Foci", "Along the outline"), &mut foci, 1..=MOST_FOCI as u32);
            *points = foci as usize;
        }
    }
}

/// The step of a target in scenes with turns.
fn step(target: &mut Target, takes_turns: bool, ui: &mut Ui) {
    if !takes_turns && target.step.is_none() {
        return;
    }
    let mut has_step = target.step.is_some();
    ui.checkbox(&mut has_step, "In step").on_hover_text("Played in this step only; otherwise in every step");
    match (&mut target.step, has_step) {
        (Some(step), true) => {
            value(ui, |ui| bare_count(ui, step, 0..=1000))
                .on_hover_text("Counted from 0")
                .accessible_name("Step");
        }
        (step, true) => *step = Some(0),
        (step, false) => *step = None,
    }
    ui.end_row();
}
