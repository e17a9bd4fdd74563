//! The rows above the 3D view: representation of the field, and camera.

use std::ops::RangeInclusive;

use egui::{Slider, Ui};
use strum::VariantArray;

use crate::field::volume::camera::Standard;
use crate::ui::number::{self, Look};
use crate::ui::space::{Seen, SpaceView};
use crate::ui::{editor::Editor, segments, shown::Shown};

/// dB
pub const LEVELS: RangeInclusive<f64> = -40.0..=-0.5;

/// The first row: the representation of the field.
pub fn show(editor: &mut Editor, ui: &mut Ui) {
    let space = &mut editor.space;
    let choice = |&seen: &Seen| (seen, seen.into_str(), seen.tooltip().to_owned());
    let choices: Vec<_> = Seen::VARIANTS.iter().map(choice).collect();
    segments::show(ui, "Field in space", &mut space.seen, &choices);
    if space.seen == Seen::Surface {
        let tip = "Level of the surface, in dB of the largest RMS pressure in the box";
        let label = ui.label("Level").on_hover_text(tip);
        ui.spacing_mut().slider_width = 120.0;
        // A value rounded by the slider would count as changed.
        let mut level = space.level;
        let slider = Slider::new(&mut level, LEVELS).show_value(false).step_by(0.5);
        if ui.add(slider).labelled_by(label.id).on_hover_text(tip).changed() {
            space.level = level;
        }
        let look = Look {
            unit: " dB",
            has_suffix: true,
            decimals: 1,
            speed: 0.1,
            name: Some("Level of the surface"),
        };
        number::field(ui, &mut space.level, &look, LEVELS);
    }
}

/// The second row: camera and visible objects.
pub fn places(editor: &mut Editor, ui: &mut Ui) {
    let space = &mut editor.space;
    if ui.button("Home").on_hover_text("Everything, from the front and above (0, or double click)").clicked()
    {
        space.go_home();
    }
    for (standard, name, tip) in [
        (Standard::Top, "Top", "From above: x to the right, y upwards"),
        (Standard::Front, "Front", "From the front: x to the right, z upwards"),
        (Standard::Side, "Side", "From the side: y to the right, z upwards"),
    ] {
        if ui.button(name).on_hover_text(tip).clicked() {
            space.look_from(standard);
        }
    }
    let projections = [
        (true, "Perspective", "Near objects are larger".to_owned()),
        (false, "Parallel", "Equal lengths stay equal at any distance".to_owned()),
    ];
    segments::show(ui, "Rays", &mut space.is_perspective, &projections);
    ui.add_space(6.0);
    ui.checkbox(&mut space.has_plane, "Plane").on_hover_text("The field on the scene's plane");
    slices(space, editor.document.scene.plane.centre.to_array(), ui);
    ui.checkbox(&mut space.is_clipped, "Clip")
        .on_hover_text("A part of the box; its faces are dragged by their knobs");
}

/// Slices across the axes, dragged by their knobs.
fn slices(space: &mut SpaceView, middle: [f64; 3], ui: &mut Ui) {
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let mut is_on = space.slices[axis].is_some();
        let tip = format!("A slice across {name}, dragged along {name} by its knob");
        let shown = ui.checkbox(&mut is_on, format!("Slice {name}")).on_hover_text(tip);
        if shown.changed() {
            space.slices[axis] = is_on.then_some(middle[axis]);
        }
    }
}

/// Whether the displayed picture is final.
pub fn is_settled(editor: &Editor, shown: &Shown) -> bool {
    !editor.space.is_on || shown.space.as_ref().is_some_and(|picture| !picture.is_coarse)
}
