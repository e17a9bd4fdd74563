//! The waves of a liquid from the onset of the sound, computed once for the plane in view and played from memory.
//!
//! A picture is the depth of every cell of the tank: the map, the relief and the caustic of a picture are made from it when it is
//! shown, like those of a surface at rest.

use crate::field::{Evaluator, Request, Stages};
use crate::gauge::Gauge;
use crate::scene::{Plane, Scene, motion};
use crate::studio::swell::{Schedule, Swell};
use crate::ui::part::{Derived, Now, Part};
use crate::ui::playback::{Moment, Playback};

/// Limit of memory for the depths of all pictures, in bytes.
const MOST_BYTES: usize = 128 << 20;
/// Pictures whose caustic is made to find the range of its brightness.
const TRIED: usize = 6;
/// Part of a caustic's pixels within the range.
const COVERED: f64 = 0.995;

/// The duration of the waves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Waves {
    /// s from the onset of the sound; `None`: the scene's default.
    pub seconds: Option<f64>,
}

/// The scene with its drives, and the times.
#[derive(Clone, Debug, PartialEq)]
pub struct Input {
    scene: Scene,
    schedule: Schedule,
    request: Request,
}

/// The surfaces of all pictures.
#[derive(Debug)]
pub struct Series {
    scene: Scene,
    plane: Plane,
    /// Depth (m) of every cell at each picture.
    surfaces: Vec<Vec<f32>>,
    /// The smallest and the largest value of all maps.
    range: [f64; 2],
}

/// A surface at a moment, with the range of values over all moments.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// m, of every cell.
    pub depth: Vec<f64>,
    pub range: [f64; 2],
    /// Whether the next one follows soon.
    pub is_moving: bool,
}

impl Part for Waves {
    type Input = Input;
    type Output = Result<Series, String>;

    fn input(&self, now: &Now<'_>) -> Option<Input> {
        let quantity = now.view.quantity;
        let is_wanted =
            matches!(now.playback.moment.of(quantity), Moment::Wave(_)) && now.view.suits(now.scene);
        let (sound, lens) = (now.sound?, now.lens.filter(|_| is_wanted)?);
        let has_drives = !motion::moves(now.scene) || now.cycle.is_some();
        let schedule = self.schedule(now.scene).filter(|_| has_drives)?;
        // Depths do not depend on pixels; the brightest place of a caustic does.
        let is_light = quantity.declaration().of_light;
        let side = |points: f32| if is_light { (points.round() as usize).max(1) } else { 1 };
        let size = (side(lens.rect.width()), side(lens.rect.height()));
        let request = Request {
            aperture: sound.aperture.clone(),
            plane: now.view.plane(now.scene, lens),
            ..Request::new(now.scene, now.drives(quantity), quantity, size)
        };
        Some(Input { scene: now.scene.clone(), schedule, request })
    }

    fn may_begin(&self, now: &Now<'_>) -> bool {
        now.rests
    }

    fn computation(&self) -> impl FnOnce(&Input) -> Self::Output + Send + 'static {
        |input| series(input)
    }
}

impl Waves {
    /// The times of the pictures; `None` if they are too many or none.
    pub fn schedule(&self, scene: &Scene) -> Option<Schedule> {
        Schedule::new(scene, self.seconds).or_else(|_| Schedule::new(scene, Some(SHORT))).ok()
    }
}

/// Duration of waves in scenes whose cycle is out of range, s.
const SHORT: f64 = 0.25;

fn series(Input { scene, schedule, request }: &Input) -> Result<Series, String> {
    let mut stages = Stages::new(Evaluator::Cpu);
    let made = Swell::new(scene, *schedule, request, &mut stages, &Gauge::default());
    let mut swell = made.map_err(|error| error.to_string())?;
    let mut surfaces = Vec::with_capacity(schedule.pictures);
    for _ in 0..schedule.pictures {
        let depth: Vec<_> = swell.next_surface().into_iter().map(|depth| depth as f32).collect();
        if depth.len() * size_of::<f32>() * schedule.pictures > MOST_BYTES {
            return Err("The waves exceed the memory for them: choose a shorter duration".to_owned());
        }
        surfaces.push(depth);
    }
    let range = match request.quantity.declaration().of_light {
        true => [0.0, brightest(request, &surfaces, &mut stages)?],
        false => {
            let all = || surfaces.iter().flatten().copied();
            [all().fold(0.0, f32::min).into(), all().fold(0.0, f32::max).into()]
        }
    };
    Ok(Series { scene: scene.clone(), plane: request.plane.clone(), surfaces, range })
}

/// The brightness of some of the pictures that few places exceed: rare peaks would leave all else dark.
fn brightest(request: &Request, surfaces: &[Vec<f32>], stages: &mut Stages) -> Result<f64, String> {
    let mut brightest = 0.0f32;
    for surface in surfaces.iter().skip(1).step_by(surfaces.len().div_ceil(TRIED).max(1)) {
        let depth = surface.iter().map(|&depth| depth.into()).collect();
        let map = stages.map(&at(request, depth)).map_err(|error| error.to_string())?;
        let mut values: Vec<_> = map.values.iter().copied().filter(|value| !value.is_nan()).collect();
        let index = (values.len() as f64 * COVERED) as usize;
        if index < values.len() {
            brightest = brightest.max(*values.select_nth_unstable_by(index, f32::total_cmp).1);
        }
    }
    Ok(brightest.into())
}

/// The request of a moving surface.
pub fn at(request: &Request, depth: Vec<f64>) -> Request {
    Request { drives: request.drives[..1].into(), part: 1.0, depth: Some(depth), ..request.clone() }
}

impl Derived<Waves> {
    /// The times of the pictures.
    pub fn schedule(&self, scene: &Scene) -> Option<Schedule> {
        self.form.schedule(scene)
    }

    /// The surface at the displayed moment, if it has been computed for this scene and plane.
    pub fn surface(&self, playback: &Playback, scene: &Scene, plane: &Plane) -> Option<Surface> {
        let Moment::Wave(index) = playback.moment else { return None };
        let Ok(series) = self.newest()? else { return None };
        let is_of_this = series.scene == *scene && series.plane == *plane;
        let depth = series.surfaces.get(index).filter(|_| is_of_this)?;
        let (depth, range) = (depth.iter().map(|&depth| depth.into()).collect(), series.range);
        Some(Surface { depth, range, is_moving: playback.playing })
    }
}
