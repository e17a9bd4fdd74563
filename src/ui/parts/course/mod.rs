//! The pressure at a point over time, with the spectrum of its square.

pub mod panel;

use glam::DVec3;

use crate::acoustics::Aperture;
use crate::acoustics::course;
use crate::drive::Drive;
use crate::scene::{Array, Scene, SpectralLine, motion};
use crate::studio::performance::Performance;
use crate::ui::layout::Panel;
use crate::ui::part::{Now, Part};

/// Number of drawn instants, and limit of computed ones.
const DRAWN: usize = 1000;
const MOST: f64 = 400_000.0;
/// Limit of displayed lines, Hz.
const BAND: f64 = 1000.0;

/// Display and position of the pressure over time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TimeCourse {
    pub is_shown: bool,
    pub place: Place,
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
        })
    }

    fn computation(&self) -> impl FnOnce(&Input) -> Result<Course, String> + Send + 'static {
        compute
    }
}

/// The part of a scene that times follow from.
fn timed(scene: &Scene) -> Scene {
    let array =
        Array { response: scene.array.response, frequency: scene.array.frequency, ..Array::default() };
    Scene {
        array,
        targets: if motion::moves(scene) { scene.targets.clone() } else { Vec::new() },
        drive: scene.drive.clone(),
        motion: scene.motion.clone(),
        modulation: scene.modulation.clone(),
        ..Scene::default()
    }
}

fn compute(input: &Input) -> Result<Course, String> {
    let Input { performance, aperture, scene, levels, at } = input;
    let transfer = aperture.transfer(&[*at]);
    let pressure = |drive: &Drive| {
        let drive = levels.map_or_else(|| drive.clone(), |levels| drive.at_levels(levels));
        transfer.pressure(&drive.excitation(&aperture.driven))[0]
    };
    let of_frames: Vec<_> = performance.drives().iter().map(pressure).collect();
    let course = course::Course::new(scene, of_frames.len());
    let lines = course.spectrum(&of_frames, BAND)?;
    let rate = course.usual_rate();
    let instants = (course.usual_span() * rate).round().clamp(1.0, MOST) as usize;
    let pressures = course.pressures(&of_frames, instants + 1, rate).into_iter().enumerate();
    let all: Vec<_> = pressures.map(|(instant, p)| [instant as f64 / rate, p.norm()]).collect();
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
