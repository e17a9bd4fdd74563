//! Quantities of a liquid need a horizontal plane: others say so in place of the map, with a way out.

use egui::{Align2, Area, Frame, Rect, RichText, Ui};

use crate::field::Quantity;
use crate::scene::Scene;
use crate::ui::editor::Editor;
use crate::ui::view::{Cut, View};

pub const MUST_BE_LEVEL: &str = "A liquid surface must be horizontal.";

/// The reason why a quantity is not offered on the displayed plane.
pub fn refusal(quantity: Quantity, view: &View, scene: &Scene) -> Option<&'static str> {
    let refused = View { quantity, ..view.clone() };
    (!refused.suits(scene)).then_some("A liquid surface must be horizontal: choose XY below")
}

/// Shows the plane parallel to the array.
pub fn show_xy(editor: &mut Editor) {
    editor.look_at(Cut::Xy);
}

/// In place of the map, the reason and a button.
pub fn offer(editor: &mut Editor, ui: &Ui, rect: Rect) {
    if editor.view.suits(editor.scene()) || editor.scene().targets.is_empty() {
        return;
    }
    let area = Area::new(ui.scope_id().with("level")).pivot(Align2::CENTER_CENTER).fixed_pos(rect.center());
    area.show(ui.ctx(), |ui| {
        Frame::popup(ui.style()).show(ui, |ui| {
            ui.vertical_centered(|ui| {
                ui.set_max_width(300.0);
                ui.label(RichText::new(MUST_BE_LEVEL).size(15.0));
                ui.add_space(4.0);
                if ui.button("Show XY").on_hover_text("The plane parallel to the array").clicked() {
                    show_xy(editor);
                }
            });
        });
    });
}
