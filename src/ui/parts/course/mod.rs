//! The pressure at a point over time, with the spectrum of its square, and the displacement of the skin there.

pub mod panel;

use std::f64::consts::TAU;
use std::sync::{Arc, Mutex, PoisonError};

use glam::{DVec2, DVec3};

use crate::acoustics::Aperture;
use crate::acoustics::course;
use crate::drive::Drive;
use crate::field::{Evaluator, FieldError, Quantity, Request, Stages};
use crate::scene::{Array, Scene, SpectralLine, motion};
use crate::studio::performance::Performance;
use crate::ui::layout::Panel;
use crate::ui::part::{Now, Part};

/// Number of drawn instants, and limit of computed ones.
const DRAWN: usize = 1000;
const MOST: f64 = 400_000.0;
/// Limit of displayed lines, Hz.
const BAND: f64 = 1000.0;
/// Instants of the skin in a period of its fastest line.
const PER_PERIOD: f64 = 16.0;
/// Instants of the skin, whose motion is slower, at most.
const MOST_OF_SKIN: usize = 20_000;
/// Largest distance of a point from the plane of the skin, m.
const ON_SKIN: f64 = 1e-3;

/// Display and position of the pressure over time.
#[derive(Clone, Debug)]
pub struct TimeCourse {
    pub is_shown: bool,
    pub place: Place,
    /// Stages that keep the motion of the skin.
    stages: Arc<Mutex<Stages>>,
}

impl Default for TimeCourse {
    fn default() -> Self {
        let stages = Arc::new(Mutex::new(Stages::new(Evaluator::Cpu)));
        Self { is_shown: false, place: Place::default(), stages }
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Place {
    /// The selected target, or the first.
    #[default]
    Focus,
    Pointer,
    Listener,
}

/// The inputs of a time course.
#[derive(Clone, Debug, PartialEq)]
pub struct Input {
    performance: Performance,
    aperture: Aperture,
    scene: Scene,
    /// Phases per period of the displayed board.
    levels: Option<u32>,
    at: DVec3,
    /// The whole scene, if it has a skin.
    skinned: Option<Box<Scene>>,
}

impl Input {
    /// The drives of all frames, as the displayed board plays them.
    fn drives(&self) -> impl Iterator<Item = Drive> {
        let at_levels = |drive: Drive| match self.levels {
            Some(levels) => drive.at_levels(levels),
            None => drive,
        };
        self.performance.drives().into_iter().map(at_levels)
    }
}

/// The pressure at a point in the course of time.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    /// m
    pub at: DVec3,
    /// Time (s) and |p| (Pa, peak).
    pub moduli: Vec<[f64; 2]>,
    /// Lines of |p|² (Pa²).
    pub lines: Vec<SpectralLine>,
    /// Time (s) and displacement (m, into the skin) of the scene's skin, if it has one, or the reason for its absence.
    pub skin: Option<Result<Vec<[f64; 2]>, String>>,
}

impl Course {
    /// Mean of |p|², Pa².
    pub fn mean(&self) -> f64 {
        self.lines.first().map_or(0.0, |line| line.amplitude)
    }

    /// The strongest line besides the mean.
    pub fn strongest(&self) -> Option<&SpectralLine> {
        self.lines.iter().skip(1).max_by(|a, b| a.amplitude.total_cmp(&b.amplitude))
    }
}

impl Part for TimeCourse {
    type Input = Input;
    type Output = Result<Course, String>;

    fn input(&self, now: &Now<'_>) -> Option<Input> {
        let sound = now.sound.filter(|_| self.is_shown && now.panel == Some(Panel::Motion))?;
        let performance = match now.cycle {
            Some(cycle) => Performance::Motion(cycle.clone()),
            None if motion::moves(now.scene) => return None,
            None => Performance::Still(now.solution?.clone()),
        };
        let at = match self.place {
            Place::Focus => now.focus,
            Place::Pointer => now.pointer,
            Place::Listener => now.scene.listener.as_ref().map(|listener| listener.at),
        };
        let fits = performance.first().phases.len() == sound.aperture.positions.len();
        Some(Input {
            performance,
            aperture: sound.aperture.clone(),
            scene: timed(now.scene),
            levels: now.levels,
            at: at.filter(|at| at.z > 0.0 && fits)?,
            skinned: now.scene.skin.is_some().then(|| Box::new(now.scene.clone())),
        })
    }

    fn computation(&self) -> impl FnOnce(&Input) -> Result<Course, String> + Send + 'static {
        let stages = Arc::clone(&self.stages);
        move |input| {
            let course = compute(input)?;
            let mut stages = stages.lock().unwrap_or_else(PoisonError::into_inner);
            let span = course.moduli.last().map_or(0.0, |[time, _]| *time);
            let skin = input.skinned.as_ref().map(|scene| of_skin(input, scene, span, &mut stages));
            Ok(Course { skin, ..course })
        }
    }
}

/// The part of a scene that times follow from.
fn timed(scene: &Scene) -> Scene {
    let moves = motion::moves(scene);
    let array =
        Array { response: scene.array.response, frequency: scene.array.frequency, ..Array::default() };
    Scene {
        array,
        targets: if moves { scene.targets.clone() } else { Vec::new() },
        drive: scene.drive.clone(),
        motion: scene.motion.clone(),
        modulation: if moves { scene.modulation.clone() } else { scene.envelope().clone() },
        ..Scene::default()
    }
}

fn compute(input: &Input) -> Result<Course, String> {
    let Input { aperture, scene, at, .. } = input;
    let transfer = aperture.transfer(&[*at]);
    let pressure = |drive: Drive| transfer.pressure(&drive.excitation(&aperture.driven))[0];
    let of_frames: Vec<_> = input.drives().map(pressure).collect();
    let course = course::Course::new(scene, of_frames.len());
    let lines = course.spectrum(&of_frames, BAND)?;
    let rate = course.usual_rate();
    let instants = (course.usual_span() * rate).round().clamp(1.0, MOST) as usize;
    let pressures = course.pressures(&of_frames, instants + 1, rate).into_iter().enumerate();
    let all: Vec<_> = pressures.map(|(instant, p)| [instant as f64 / rate, p.norm()]).collect();
    Ok(Course { at: *at, moduli: thinned(&all), lines, skin: None })
}

/// The displacement of the skin of a scene over a span, s.
fn of_skin(input: &Input, scene: &Scene, span: f64, stages: &mut Stages) -> Result<Vec<[f64; 2]>, String> {
    let plane = &scene.plane;
    let (x, y) = plane.axes().ok_or_else(|| FieldError::NoPlane.to_string())?;
    let offset = input.at - plane.centre;
    let place = DVec2::new(offset.dot(x), offset.dot(y));
    let is_within = place.abs().cmple(plane.size / 2.0).all() && offset.dot(x.cross(y)).abs() < ON_SKIN;
    if !is_within {
        return Err("This point is off the scene plane, where the skin is.".to_owned());
    }
    let request = Request::new(scene, input.drives().collect(), Quantity::Skin, (1, 1));
    let motion = stages.skin(&request).map_err(|error| error.to_string())?;
    let lines = motion.at(&[place]).remove(0);
    let highest = lines.iter().fold(0.0f64, |most, line| most.max(line.frequency));
    let instants = (PER_PERIOD * highest * span).clamp(2.0, MOST_OF_SKIN as f64).ceil() as usize;
    let all: Vec<_> = (0..=instants)
        .map(|instant| {
            let time = span * instant as f64 / instants as f64;
            let of = |line: &SpectralLine| line.amplitude * (TAU * line.frequency * time + line.phase).cos();
            [time, lines.iter().map(of).sum()]
        })
        .collect();
    Ok(thinned(&all))
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
