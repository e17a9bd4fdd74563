//! Measurements of the displayed field on a thread: its maximum, peak side lobe and focal widths.

use egui::Context;
use glam::DVec3;

use crate::acoustics::{Aperture, Clearance};
use crate::app::later::Later;
use crate::drive::Drive;
use crate::field::{Evaluator, Quantity, Request, Stages, side_lobe};
use crate::scene::{Focus, Plane, Scene};
use crate::studio::width::{self, Widths};
use crate::ui::section;
use crate::ui::view::Lens;
use crate::ui::{Editor, Extremes, Shown};

/// Resolution of the search for the maximum, in pixels of the map's wider side.
const PIXELS: f64 = 600.0;

/// The inputs of the extremes.
#[derive(Clone, Debug, PartialEq)]
struct Surveyed {
    scene: Scene,
    aperture: Aperture,
    drives: Vec<Drive>,
    foci: Vec<Focus>,
    plane: Plane,
    /// Whether maximum and side lobe are requested.
    marks: bool,
    /// m, of which the widths are.
    focus: Option<DVec3>,
}

#[derive(Debug, Default)]
pub struct Survey {
    found: Later<Surveyed, (Option<Extremes>, Option<Widths>)>,
}

impl Survey {
    pub fn is_running(&self) -> bool {
        self.found.is_running()
    }

    /// Collects finished values, and returns whether there were any.
    pub fn collect(&mut self) -> bool {
        self.found.collect()
    }

    /// Requests the displayed measurements, if nothing is dragged.
    pub fn update(&mut self, editor: &Editor, shown: &mut Shown, lens: &Lens, ctx: &Context) {
        (shown.extremes, shown.widths) = (None, None);
        let marks = editor.view.extremes;
        let focus = section::focus(editor, shown).filter(|_| editor.view.section);
        let Some(sound) = shown.sound.as_ref().filter(|_| marks || focus.is_some()) else { return };
        if sound.drive().phases.len() != sound.aperture.positions.len() {
            return;
        }
        let plane = editor.view.plane(editor.scene(), lens);
        let surveyed = Surveyed {
            scene: Scene { plane: plane.clone(), ..editor.scene().clone() },
            aperture: sound.aperture.clone(),
            drives: sound.drives.clone(),
            foci: sound.foci.clone(),
            plane,
            marks,
            focus,
        };
        if !ctx.input(|input| input.pointer.any_down()) && !editor.playback.playing {
            self.found.ask(&surveyed, ctx, measure);
        }
        (shown.extremes, shown.widths) = self.found.get(&surveyed).copied().unwrap_or_default();
    }
}

fn measure(surveyed: &Surveyed) -> (Option<Extremes>, Option<Widths>) {
    let Surveyed { aperture, drives, marks, focus, .. } = surveyed;
    let widths = focus.map(|focus| width::widths(aperture, drives, focus));
    (marks.then(|| extremes(surveyed)), widths)
}

fn extremes(surveyed: &Surveyed) -> Extremes {
    let Surveyed { scene, aperture, drives, foci, plane, .. } = surveyed;
    let mut stages = Stages::new(Evaluator::Cpu);
    let lobe = side_lobe(&mut stages, aperture, plane, drives, foci).ok();
    Extremes {
        peak: peak(scene, drives, &mut stages),
        side_lobe: lobe.map(|lobe| (lobe.position, lobe.pressure)),
    }
}

/// The maximum of |p|: position (m) and peak amplitude (Pa).
fn peak(scene: &Scene, drives: &[Drive], stages: &mut Stages) -> Option<(DVec3, f64)> {
    let plane = &scene.plane;
    let pixel = plane.size.max_element() / PIXELS;
    let [width, height] = (plane.size / pixel).to_array().map(|side| (side.round() as usize).max(1));
    let request = Request::new(scene, drives.to_vec(), Quantity::Rms, (width, height));
    let map = stages.map(&request).ok()?;
    let (x, y) = plane.axes()?;
    let part = |index: usize, count: usize| (index as f64 + 0.5) / count as f64 - 0.5;
    let at = |index: usize| {
        plane.centre
            + x * (plane.size.x * part(index % width, width))
            + y * (plane.size.y * part(index / width, height))
    };
    let clearance = Clearance::new(&request.aperture);
    let heard = map.values.iter().enumerate().map(|(index, value)| (at(index), *value));
    let heard = heard.filter(|(at, _)| clearance.at(*at) > 0.0);
    let (at, value) = heard.max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some((at, f64::from(value) * std::f64::consts::SQRT_2))
}
