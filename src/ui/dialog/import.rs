//! The dialog for importing a drawing: position, size and sampling.

use egui::{Color32, Rect, RichText, Sense, Shape, Stroke, Ui, pos2, vec2};

use crate::acoustics::Aperture;
use crate::import::{Drawing, Placement};
use crate::scene::{Focus, Sampling, Scene, Target, outline};
use crate::solver::{Warning, warnings_of_foci};
use crate::ui::dialog::answer::answer;
use crate::ui::panels::form::{MM, caption, form, number, value};
use crate::ui::panels::target::{point, sampling};
use crate::ui::theme;
use crate::ui::view::View;

/// The longer side of a drawing that is fitted, m.
const SIDE: f64 = 0.06;
/// Limits of the longer side, m.
const SIDES: std::ops::RangeInclusive<f64> = 1e-3..=2.0;
/// Points of the screen: the preview.
const HEIGHT: f32 = 200.0;

/// A drawing to be placed.
#[derive(Clone, Debug, PartialEq)]
pub struct Import {
    /// The file's.
    name: String,
    drawing: Drawing,
    pub placement: Placement,
    made: Option<Made>,
}

/// The result of a placement.
#[derive(Clone, Debug, PartialEq)]
struct Made {
    of: Placement,
    targets: Result<Vec<Target>, String>,
    foci: Vec<Focus>,
    warnings: Vec<Warning>,
}

impl Import {
    /// Suggests the centre of the view, and the file's own size if it states one that a scene may have.
    pub fn new(name: String, drawing: Drawing, view: &View, scene: &Scene) -> Self {
        let axes = view.axes(scene);
        let middle = view.window.map_or(axes.flat(scene.plane.centre), |window| window.centre);
        let placement = Placement {
            at: axes.world(middle),
            x: axes.x,
            y: axes.y,
            side: drawing.side.filter(|side| SIDES.contains(side)).unwrap_or(SIDE),
            sampling: Sampling::Continuous,
        };
        Self { name, drawing, placement, made: None }
    }

    /// Draws the dialog, and returns the imported targets when it ends; none if it was cancelled.
    pub(super) fn show(&mut self, scene: &Scene, ui: &mut Ui) -> Option<Vec<Target>> {
        ui.heading(format!("Import {}", self.name));
        self.make(scene);
        self.preview(ui);
        self.settings(ui);
        let made = self.made.as_ref()?;
        match &made.targets {
            Ok(targets) => {
                ui.strong(summary(&made.foci, targets.len()));
            }
            Err(problem) => {
                ui.label(RichText::new(problem).color(theme::error(ui.visuals())));
            }
        }
        let warnings = made.warnings.iter().map(ToString::to_string);
        let warnings = warnings.chain(self.size_problem(scene)).chain(self.drawing.remarks.iter().cloned());
        for warning in warnings {
            ui.label(RichText::new(warning).color(theme::warning(ui.visuals())));
        }
        ui.add_space(8.0);
        let mut cancels = false;
        let imports = answer(ui, ("Import", made.targets.is_ok()), |ui| {
            cancels = ui.button("Cancel").clicked();
        });
        match &made.targets {
            Ok(targets) if imports => Some(targets.clone()),
            Ok(_) | Err(_) => cancels.then(Vec::new),
        }
    }

    /// Updates the targets after a change of the placement.
    fn make(&mut self, scene: &Scene) {
        if self.made.as_ref().is_some_and(|made| made.of == self.placement) {
            return;
        }
        let of = self.placement.clone();
        let targets = of.targets(&self.drawing).map_err(|error| error.message);
        let (mut foci, mut warnings) = (Vec::new(), Vec::new());
        let targets = targets.and_then(|targets| {
            let others = scene.targets.iter().chain(&targets).cloned().collect();
            let with_them = Scene { targets: others, ..scene.clone() };
            let all = outline::foci(&with_them).map_err(|error| error.message)?;
            let alone = Scene { targets: targets.clone(), ..scene.clone() };
            foci = outline::foci(&alone).map_err(|error| error.message)?;
            warnings = warnings_of_foci(&Aperture::new(scene), &all);
            Ok(targets)
        });
        self.made = Some(Made { of, targets, foci, warnings });
    }

    /// A drawing as large as it is drawn, where that does not fit.
    fn size_problem(&self, scene: &Scene) -> Option<String> {
        let side = self.drawing.side?;
        if !SIDES.contains(&side) {
            let [from, to] = [SIDES.start(), SIDES.end()].map(|side| length(*side));
            return Some(format!("As drawn it is {} long: it may be {from} to {to}.", length(side)));
        }
        let array = 2.0 * Aperture::new(scene).reach().max_element();
        (self.placement.side == side && side > array)
            .then(|| format!("As drawn, it is larger ({}) than the array ({}).", length(side), length(array)))
    }

    fn settings(&mut self, ui: &mut Ui) {
        let size = self.drawing.size;
        let drawn = self.drawing.side.filter(|side| SIDES.contains(side));
        let placement = &mut self.placement;
        form(ui, "placement", |ui| {
            if let Some(drawn) = drawn {
                caption(ui, "Size").on_hover_text("Of the longer side");
                value(ui, |ui| {
                    // From the right.
                    ui.selectable_value(&mut placement.side, SIDE, format!("Fit to {}", length(SIDE)));
                    ui.selectable_value(&mut placement.side, drawn, format!("{}, as drawn", length(drawn)));
                });
                ui.end_row();
            }
            for (name, part) in [("Width", size.x), ("Height", size.y)] {
                if part > 1e-6 {
                    let mut length = placement.side * part;
                    let range = SIDES.start() * part..=SIDES.end() * part;
                    number(ui, (name, "The other one follows"), &mut length, MM, range);
                    if length != placement.side * part {
                        placement.side = length / part;
                    }
                }
            }
            point(ui, "Centre", &mut placement.at);
            sampling(ui, &mut placement.sampling, &[]);
        });
    }

    /// The lines with their focal points.
    fn preview(&self, ui: &mut Ui) {
        let (outer, _) = ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), Sense::hover());
        let painter = ui.painter_at(outer);
        painter.rect_filled(outer, 4.0, Color32::from_rgb(12, 12, 16));
        let size = vec2(self.drawing.size.x as f32, self.drawing.size.y as f32).max(vec2(1e-3, 1e-3));
        let inner = outer.shrink(14.0);
        let scale = (inner.width() / size.x).min(inner.height() / size.y);
        let frame = Rect::from_center_size(outer.center(), size * scale);
        let place = |at: glam::DVec2| {
            pos2(frame.center().x + at.x as f32 * scale, frame.center().y - at.y as f32 * scale)
        };
        for line in &self.drawing.lines {
            let mut points: Vec<_> = line.points.iter().map(|&point| place(point)).collect();
            if line.closed {
                points.extend(points.first().copied());
            }
            painter.add(Shape::line(points, Stroke::new(1.5, theme::CHOSEN)));
        }
        let Some(made) = &self.made else { return };
        for focus in made.foci.iter().filter(|focus| focus.is_separate()) {
            let offset = (focus.position - made.of.at) / made.of.side;
            painter.circle_filled(
                place(glam::DVec2::new(offset.dot(made.of.x), offset.dot(made.of.y))),
                2.0,
                theme::MARK,
            );
        }
    }
}

/// A length for reading, in mm.
fn length(metres: f64) -> String {
    let rounded = (1e5 * metres).round() / 100.0;
    format!("{rounded} mm")
}

/// Summary of the imported targets.
fn summary(foci: &[Focus], targets: usize) -> String {
    let separate = foci.iter().filter(|focus| focus.is_separate()).count();
    let lines = format!("{targets} {}", if targets == 1 { "line" } else { "lines" });
    if separate == foci.len() {
        format!("{separate} focal points on {lines}")
    } else if separate == 0 {
        format!("{lines}, even pressure")
    } else {
        format!("{lines}, even pressure, {separate} of them points")
    }
}
