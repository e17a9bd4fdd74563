//! The plot of the pressure along a shape's strokes.

use egui::Ui;
use egui_plot::{HLine, Line, PlotPoints};

use crate::scene::Part;
use crate::ui::panels::form::{heading, still_plot};
use crate::ui::{sound::Sound, theme};

/// Positions (mm) along all strokes in sequence, with the pressure relative to the target's mean; a curve per stroke.
pub fn curves(sound: &Sound) -> Vec<Vec<[f64; 2]>> {
    /// Wavelengths: samples farther apart belong to different strokes.
    const NEIGHBOURS: f64 = 0.27;
    let relative = |index: usize| sound.readings[index].peak() / sound.foci[index].target;
    let samples: Vec<_> =
        (0..sound.foci.len()).filter(|&index| sound.foci[index].part == Part::Stroke).collect();
    let mean = samples.iter().map(|&index| relative(index)).sum::<f64>() / samples.len().max(1) as f64;
    let nearest = NEIGHBOURS * sound.aperture.wavelength();
    let mut curves: Vec<Vec<[f64; 2]>> = Vec::new();
    let (mut along, mut before) = (0.0, None);
    for index in samples {
        let position = sound.foci[index].position;
        let way = before.map(|before| position.distance(before)).filter(|way| *way < nearest);
        along += way.unwrap_or(nearest);
        if way.is_none() {
            curves.push(Vec::new());
        }
        if let Some(curve) = curves.last_mut() {
            curve.push([along * 1e3, relative(index) / mean.max(f64::MIN_POSITIVE)]);
        }
        before = Some(position);
    }
    curves
}

/// Draws them, if there are strokes.
pub fn show(sound: &Sound, ui: &mut Ui) {
    const HEIGHT: f32 = 84.0;
    let curves = curves(sound);
    if curves.is_empty() {
        return;
    }
    heading(ui, "Pressure along the strokes")
        .on_hover_text("Relative to its mean, against the way along the strokes in mm");
    let plot = still_plot("profile", HEIGHT).include_y(1.2).grid_spacing(16.0..=400.0);
    plot.show(ui, |plot| {
        plot.hline(HLine::new("mean", 1.0).color(theme::CHOSEN.gamma_multiply(0.4)));
        for curve in curves {
            plot.line(Line::new("pressure", PlotPoints::from(curve)).color(theme::ACCENT).width(1.5));
        }
    });
}
