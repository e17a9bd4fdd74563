//! The status line: the last action, the accuracy of the map, and warnings, with details on a click.

use egui::{Align, Button, Label, Layout, Popup, PopupCloseBehavior, RichText, Ui};

use crate::echo;
use crate::field::promised;
use crate::ui::panels::form::{fact, form};
use crate::ui::space::view::SpaceShown;
use crate::ui::{editor::Editor, map::Map, shown::Shown, theme};

/// Width of the popup in points.
const WIDTH: f32 = 420.0;

pub fn bar(editor: &Editor, shown: &Shown, ui: &mut Ui) {
    ui.horizontal(|ui| {
        // The same height with and without a map, otherwise the map would shift under the pointer.
        ui.set_min_height(ui.spacing().interact_size.y);
        match (&shown.space, &shown.map) {
            (Some(picture), _) => space(picture, ui),
            (None, Some(map)) => details(editor, shown, map, ui),
            (None, None) => {}
        }
        warnings(shown, ui);
        if let Some(notice) = &shown.notice {
            let colour = if notice.is_error { theme::error(ui.visuals()) } else { ui.visuals().text_color() };
            let text = echo::message(&notice.text);
            // Truncated text is shown in full on hover.
            ui.add(Label::new(RichText::new(text).color(colour)).truncate());
        }
    });
}

/// The method of the 3D picture.
fn space(picture: &SpaceShown, ui: &mut Ui) {
    let [field, drawing] = picture.milliseconds;
    let state = if picture.is_coarse { "Preview" } else { "3D picture" };
    let tip = format!(
        "Pressures between sample points are interpolated: for looking at, not for measuring. Coarse while something moves. Field \
         {field:.0} ms, picture {drawing:.0} ms"
    );
    let text = RichText::new(state).color(ui.visuals().weak_text_color());
    ui.add(Label::new(text)).on_hover_text(tip);
}

/// Accuracy and method of the map.
fn details(editor: &Editor, shown: &Shown, map: &Map, ui: &mut Ui) {
    let chip = Button::new("Accuracy").corner_radius(10).small();
    let tip = format!("Estimated error of the map: {:.0e} of its peak. Click for details", map.error);
    let response = ui.add(chip).on_hover_text(tip);
    Popup::menu(&response).close_behavior(PopupCloseBehavior::CloseOnClickOutside).show(|ui| {
        ui.set_max_width(WIDTH);
        form(ui, "details", |ui| {
            let tip = "Estimate of the largest deviation of any pixel from the same field in double precision, relative \
                       to the peak";
            let promised = promised(editor.scene().plane.tolerance);
            fact(ui, ("Error", tip), format!("{:.1e} of peak, {promised:.0e} allowed", map.error));
            fact(ui, ("Solving", "Time to find the phases"), format!("{:.1} ms", shown.solving));
            let (field, tip) = match shown.on_gpu {
                Some(on_gpu) => (format!("{on_gpu:.2} ms"), "Time of the GPU for the map, by its own clock"),
                None => (format!("{:.1} ms", shown.mapping), "Time for the map and its colours"),
            };
            fact(ui, ("Field", tip), field);
            fact(ui, ("Evaluator", "What computes the field"), shown.evaluator.as_str());
            if let Some(sound) = &shown.sound {
                let foci = sound.foci.iter().filter(|focus| focus.is_separate()).count();
                fact(ui, ("Foci", "Points at which the waves of all elements arrive in phase"), foci.to_string());
                let tip = "Points along continuous strokes and in areas where pressure is levelled";
                fact(ui, ("Samples", tip), (sound.foci.len() - foci).to_string());
            }
            let bodies = editor.scene().bodies.len();
            if let Some(found) = editor.parts.scattering.newest().filter(|_| bodies > 0) {
                let worst = found.errors.iter().map(|error| error.outside).fold(0.0, f64::max);
                let tip = "Bodies with the triangles of their surfaces, and the largest error of what one scatters";
                let text = format!("{bodies}, {} triangles, within {:.1} %", found.triangles, 100.0 * worst);
                fact(ui, ("Bodies", tip), text);
            }
        });
        if !map.how.is_empty() {
            ui.separator();
            ui.with_layout(Layout::top_down(Align::Min), |ui| ui.label(RichText::new(&map.how).small()));
        }
    });
}

fn warnings(shown: &Shown, ui: &mut Ui) {
    let Some(first) = shown.warnings.first() else { return };
    let colour = theme::warning(ui.visuals());
    let text = match shown.warnings.len() {
        1 => "⚠ 1 warning".to_owned(),
        count => format!("⚠ {count} warnings"),
    };
    let button = Button::new(RichText::new(text).color(colour)).corner_radius(10).small();
    let response = ui.add(button).on_hover_text(echo::message(first));
    Popup::menu(&response).close_behavior(PopupCloseBehavior::CloseOnClickOutside).show(|ui| {
        ui.set_max_width(WIDTH);
        for warning in &shown.warnings {
            ui.label(echo::lines(warning));
        }
    });
    if shown.notice.is_none() {
        ui.add(Label::new(RichText::new(echo::message(first)).color(colour)).truncate());
    }
}
