//! Measurements of the displayed field: its maximum, peak side lobe and focal widths.

use glam::DVec3;

use crate::acoustics::{Aperture, Clearance};
use crate::drive::Drive;
use crate::field::{Evaluator, Quantity, Request, Stages, side_lobe};
use crate::scene::{Focus, Plane, Scene};
use crate::studio::width::{self, Widths};
use crate::ui::part::{Now, Part};

/// Resolution of the search for the maximum, in pixels of the map's wider side.
const PIXELS: f64 = 600.0;

/// The measurements on the map.
#[derive(Debug, Default)]
pub struct Survey;

/// The inputs of the measurements.
#[derive(Clone, Debug, PartialEq)]
pub struct Input {
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

/// The displayed maximum and peak side lobe: position (m), and |P| (Pa, peak).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extremes {
    pub peak: Option<(DVec3, f64)>,
    pub side_lobe: Option<(DVec3, f64)>,
}

impl Part for Survey {
    type Input = Input;
    type Output = (Option<Extremes>, Option<Widths>);

    fn input(&self, now: &Now<'_>) -> Option<Input> {
        let marks = now.view.extremes;
        let focus = now.focus.filter(|_| now.view.section);
        let sound = now.sound.filter(|_| marks || focus.is_some())?;
        let plane = now.view.plane(now.scene, now.lens?);
        Some(Input {
            scene: Scene { plane: plane.clone(), ..now.scene.clone() },
            aperture: sound.aperture.clone(),
            drives: sound.drives.clone(),
            foci: sound.foci.clone(),
            plane,
            marks,
            focus,
        })
    }

    fn may_begin(&self, now: &Now<'_>) -> bool {
        now.rests && !now.playback.playing
    }

    fn computation(&self) -> impl FnOnce(&Input) -> Self::Output + Send + 'static {
        measure
    }
}

fn measure(input: &Input) -> (Option<Extremes>, Option<Widths>) {
    let Input { aperture, drives, marks, focus, .. } = input;
    let widths = focus.map(|focus| width::widths(aperture, drives, focus));
    (marks.then(|| extremes(input)), widths)
}

fn extremes(input: &Input) -> Extremes {
    let Input { scene, aperture, drives, foci, plane, .. } = input;
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
    let heard = heard.filter(|(at, value)| clearance.at(*at) > 0.0 && !value.is_nan());
    let (at, value) = heard.max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some((at, f64::from(value) * std::f64::consts::SQRT_2))
}
