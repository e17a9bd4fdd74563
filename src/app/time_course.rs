//! The pressure at a point over time, computed on a thread on demand.

use egui::Context;
use glam::DVec3;

use crate::acoustics::Aperture;
use crate::app::later::Later;
use crate::drive::Drive;
use crate::scene::{Scene, motion};
use crate::studio::performance::Performance;
use crate::studio::time_course;
use crate::ui::{Course, Editor, Panel, Shown, course};

/// Number of drawn instants, and limit of computed ones.
const DRAWN: usize = 1000;
const MOST: f64 = 400_000.0;

/// The inputs of a time course.
#[derive(Clone, Debug, PartialEq)]
struct Wanted {
    performance: Performance,
    aperture: Aperture,
    scene: Scene,
    /// Phases per period of the displayed board.
    levels: Option<u32>,
    at: DVec3,
}

#[derive(Debug, Default)]
pub struct TimeCourse {
    made: Later<Wanted, Result<Course, String>>,
}

impl TimeCourse {
    pub fn is_running(&self) -> bool {
        self.made.is_running()
    }

    /// Collects finished values, and returns whether there were any.
    pub fn collect(&mut self) -> bool {
        self.made.collect()
    }

    /// Requests the displayed course; until it is available, the previous one stays.
    pub fn update(&mut self, editor: &Editor, shown: &mut Shown, ctx: &Context) {
        let is_seen = editor.panel == Panel::Motion && editor.course.is_shown && !editor.layout.presents;
        let Some(wanted) = Some(is_seen).filter(|seen| *seen).and_then(|_| wanted(editor, shown)) else {
            shown.course = None;
            return;
        };
        self.made.ask(&wanted, ctx, make);
        if let Some(course) = self.made.get(&wanted) {
            shown.course = Some(course.clone());
        }
    }
}

fn wanted(editor: &Editor, shown: &Shown) -> Option<Wanted> {
    let scene = editor.scene();
    let performance = match &shown.round {
        Some(round) => Performance::Motion(round.clone()),
        None if motion::moves(scene) => return None,
        None => Performance::Still(shown.solution.clone()?),
    };
    let aperture = shown.sound.as_ref()?.aperture.clone();
    let fits = performance.first().phases.len() == aperture.positions.len();
    let at = course::place(editor, shown).filter(|_| fits)?;
    Some(Wanted { performance, aperture, scene: timed(scene), levels: editor.levels, at })
}

/// The part of a scene that times follow from.
fn timed(scene: &Scene) -> Scene {
    Scene {
        targets: if motion::moves(scene) { scene.targets.clone() } else { Vec::new() },
        motion: scene.motion.clone(),
        modulation: scene.modulation.clone(),
        ..Scene::default()
    }
}

fn make(wanted: &Wanted) -> Result<Course, String> {
    let Wanted { performance, aperture, scene, levels, at } = wanted;
    let transfer = aperture.transfer(&[*at]);
    let pressure = |drive: &Drive| {
        let drive = levels.map_or_else(|| drive.clone(), |levels| drive.at_levels(levels));
        transfer.pressure(&drive.excitation(&aperture.driven))[0]
    };
    let of_frames: Vec<_> = performance.drives().iter().map(pressure).collect();
    let course = time_course::Course::new(scene, of_frames.len());
    let lines = course.spectrum(&of_frames, course::BAND)?;
    let modulus = |time: f64| course.pressure(&of_frames, time).norm();
    let rate = course.usual_rate();
    let instants = (course.usual_span() * rate).round().clamp(1.0, MOST) as usize;
    let at_instant = |instant: usize| {
        let time = instant as f64 / rate;
        [time, modulus(time)]
    };
    let all: Vec<_> = (0..=instants).map(at_instant).collect();
    Ok(Course { at: *at, moduli: thinned(&all), lines })
}

/// Few enough points for a plot: of many instants in a row the lowest and the highest.
fn thinned(moduli: &[[f64; 2]]) -> Vec<[f64; 2]> {
    if moduli.len() <= 2 * DRAWN {
        return moduli.to_vec();
    }
    let ends = |row: &[[f64; 2]]| {
        let lowest = row.iter().copied().min_by(|a, b| a[1].total_cmp(&b[1]));
        let highest = row.iter().copied().max_by(|a, b| a[1].total_cmp(&b[1]));
        let mut ends: Vec<_> = lowest.into_iter().chain(highest).collect();
        ends.sort_by(|a, b| a[0].total_cmp(&b[0]));
        ends
    };
    moduli.chunks(moduli.len().div_ceil(DRAWN)).flat_map(ends).collect()
}
