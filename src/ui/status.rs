//! The line at the bottom: how long things took, how right they are, and what to know before trusting them.

use egui::{RichText, Ui};

use crate::echo;
use crate::field::promised;
use crate::ui::{Editor, Shown, theme};

pub fn bar(editor: &Editor, shown: &Shown, ui: &mut Ui) {
    ui.horizontal(|ui| {
        ui.label(format!("solve {:.1} ms", shown.solving))
            .on_hover_text("Time that finding the phases took");
        ui.separator();
        match shown.on_gpu {
            Some(on_gpu) => ui
                .label(format!("field {on_gpu:.2} ms"))
                .on_hover_text("Time that the GPU took for the map, by its own clock"),
            None => ui
                .label(format!("field {:.1} ms", shown.mapping))
                .on_hover_text("Time that the map and its colours took"),
        };
        if let Some(map) = &shown.map {
            ui.separator();
            ui.label(format!("error {:.0e}", map.error)).on_hover_text(format!(
                "Estimate of the largest deviation of any pixel from the same field in double precision, relative to the peak; \
                 {:.0e} is allowed.\n{}",
                promised(editor.scene().plane.tolerance),
                map.how
            ));
        }
        ui.separator();
        ui.label(&shown.evaluator).on_hover_text("Who computes the field");
        ui.separator();
        if let Some(sound) = &shown.sound {
            let foci = sound.foci.iter().filter(|focus| focus.is_separate()).count();
            if foci > 0 {
                ui.label(format!("{foci} {}", if foci == 1 { "focus" } else { "foci" }))
                    .on_hover_text("Points at which the waves of all elements arrive in step");
            }
            if foci < sound.foci.len() {
                ui.label(format!("{} samples", sound.foci.len() - foci))
                    .on_hover_text("Places along continuous strokes at which the pressure is evened out");
            }
            ui.separator();
        }
        message(shown, ui);
    });
}

/// The most important of what there is to say; the rest as a tooltip.
fn message(shown: &Shown, ui: &mut Ui) {
    if let Some(notice) = &shown.notice {
        let colour = if notice.is_error { theme::error(ui.visuals()) } else { ui.visuals().text_color() };
        ui.add(egui::Label::new(RichText::new(echo::message(&notice.text)).color(colour)).truncate());
        return;
    }
    let Some(first) = shown.warnings.first() else { return };
    let more = shown.warnings.len() - 1;
    let text = echo::message(first);
    let text = if more > 0 { format!("{text} (and {more} more)") } else { text };
    let label = egui::Label::new(RichText::new(text).color(theme::warning(ui.visuals()))).truncate();
    ui.add(label).on_hover_text(echo::lines(&shown.warnings.join("\n\n")));
}
