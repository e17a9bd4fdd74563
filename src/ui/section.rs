//! The cross-section: RMS pressure along a line through the cut.

use egui::{Ui, Vec2b};
use egui_plot::{Line, Plot, PlotPoints, VLine};
use glam::DVec2;

use crate::ui::view::Lens;
use crate::ui::{Editor, Map, Shown, Sound, theme};

const POINTS: usize = 400;

/// Draws the values of the map along the line, across what is on the screen.
pub fn show(editor: &Editor, shown: &Shown, ui: &mut Ui) {
    let (Some(map), Some(sound)) = (&shown.map, &shown.sound) else {
        ui.weak("Nothing is played.");
        return;
    };
    let lens = Lens { rect: map.rect, window: map.window };
    let (points, largest) = curve(map, sound, &lens, editor.view.line);
    let declaration = map.quantity.declaration();
    let (factor, unit) = declaration.unit.scaled(largest);
    let curve: Vec<[f64; 2]> = points.iter().map(|[x, value]| [x * 1e3, value * factor]).collect();
    let (across, up) = editor.view.cut.axes();
    let name = format!("{}, {unit}", declaration.title);
    ui.label(format!("{name} along {} = {:.1} mm", &up[..1], editor.view.line * 1e3))
        .on_hover_text("Shift and the pointer move the line");
    let plot = Plot::new("section")
        .height(ui.available_height().max(60.0))
        .allow_zoom(false)
        .allow_drag(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .auto_bounds(Vec2b::TRUE)
        .include_y(0.0)
        .grid_spacing(16.0..=90.0)
        .x_axis_label(across)
        .show_grid(true);
    plot.show(ui, |plot| {
        plot.line(Line::new(name, PlotPoints::from(curve)).color(theme::ACCENT).width(1.5));
        for focus in sound.foci.iter().filter(|focus| focus.is_separate()) {
            let uv = map.axes.flat(focus.position);
            if (uv.y - editor.view.line).abs() < 1e-3 {
                plot.vline(VLine::new("focus", uv.x * 1e3).color(theme::CHOSEN.gamma_multiply(0.4)));
            }
        }
    });
}

/// Places (m) and values along the line, and the largest value.
fn curve(map: &Map, sound: &Sound, lens: &Lens, v: f64) -> (Vec<[f64; 2]>, f64) {
    let (low, high) = (lens.flat(lens.rect.left_bottom()).x, lens.flat(lens.rect.right_top()).x);
    let u = |i: usize| low + (high - low) * (i as f64 + 0.5) / POINTS as f64;
    let values: Vec<f64> = match &map.numbers {
        Some(_) => (0..POINTS).map(|i| map.number(DVec2::new(u(i), v)).unwrap_or(0.0)).collect(),
        None => {
            let points: Vec<_> = (0..POINTS).map(|i| map.axes.world(DVec2::new(u(i), v))).collect();
            sound.values(map, &points)
        }
    };
    let largest = values.iter().fold(0.0f64, |most, value| most.max(value.abs()));
    (values.into_iter().enumerate().map(|(i, value)| [u(i), value]).collect(), largest)
}
