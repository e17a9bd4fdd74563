//! The panel on the right: one page each for scene, solver, drive, liquid, motion, feeling, device and measured field.

mod boards;
mod bodies;
mod bring_up;
mod device;
mod drive;
mod felt;
pub mod form;
mod liquid;
mod modulation;
mod motion;
mod others;
mod path;
mod profile;
mod scene;
mod solver;
pub mod target;

use egui::{ScrollArea, Ui};
use strum::VariantArray;

use crate::ui::{command::Command, editor::Editor, layout::Panel, parts::measuring, shown::Shown};

pub use form::{DEGREES, MM, PERCENT, PLAIN, Unit, bare_number, caption, fact, form, number, value};

pub fn show(editor: &mut Editor, shown: &Shown, ui: &mut Ui, commands: &mut Vec<Command>) {
    ui.add_space(4.0);
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 1.0;
        ui.spacing_mut().button_padding.x = 4.0;
        for &panel in Panel::VARIANTS {
            let tip = match panel {
                Panel::Scene => "Targets, air and array",
                Panel::Solver => "How the phases are found, and how good they are",
                Panel::Drive => "What every element plays",
                Panel::Liquid => "What the sound presses",
                Panel::Motion => "Motion of the targets, and modulation of the sound",
                Panel::Felt => "What a hand feels",
                Panel::Device => "The board that plays",
                Panel::Measure => "What a microphone tells of the array",
            };
            ui.selectable_value(&mut editor.panel, panel, panel.into_str()).on_hover_text(tip);
        }
    });
    ui.separator();
    ScrollArea::vertical().auto_shrink([false, false]).id_salt(editor.panel as u8).show(ui, |ui| {
        // The scroll bar covers the panel.
        ui.set_max_width(ui.available_width() - ui.spacing().scroll.bar_width);
        match editor.panel {
            Panel::Scene => scene::show(editor, shown, ui),
            Panel::Solver => solver::show(editor, shown, ui, commands),
            Panel::Drive => drive::show(editor, shown, ui),
            Panel::Liquid => liquid::show(editor, shown, ui),
            Panel::Motion => motion::show(editor, shown, ui),
            Panel::Felt => felt::show(editor, ui),
            Panel::Device => device::show(editor, shown, ui, commands),
            Panel::Measure => measuring::panel::show(editor, shown, ui),
        }
        ui.add_space(12.0);
    });
}
