//! The moving surface of a liquid: waves from the onset of the sound, frame by frame.

use anyhow::bail;

use crate::field::{FieldError, Request, Stages};
use crate::gauge::Gauge;
use crate::scene::{Scene, motion};
use crate::surface::{Rest, Tank, Waves};

/// Frames per second of real time, and their limit.
const PICTURES_PER_SECOND: f64 = 400.0;
const MOST_PICTURES: f64 = 5000.0;
/// Default duration of waves in a scene at rest, s.
const STILL: f64 = 0.25;
/// Limit of memory for the static depressions of all frames, in bytes.
const MOST_BYTES: usize = 1 << 30;

/// The times of a wave simulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Schedule {
    pub pictures: usize,
    /// Time steps from one picture to the next.
    steps: usize,
    /// s
    step: f64,
}

impl Schedule {
    /// For a duration in seconds, or the scene's default.
    ///
    /// # Errors
    /// No time, or more than can be shown.
    pub fn new(scene: &Scene, seconds: Option<f64>) -> anyhow::Result<Self> {
        let cycle = motion::cycle(scene);
        let seconds = seconds.unwrap_or(cycle.as_ref().map_or(STILL, |cycle| 1.0 / cycle.rate));
        let pictures = (seconds * PICTURES_PER_SECOND).round();
        if !(1.0..=MOST_PICTURES).contains(&pictures) {
            bail!(
                "waves are shown for {} to {} s, {PICTURES_PER_SECOND} pictures each; {seconds} s were asked for",
                1.0 / PICTURES_PER_SECOND,
                MOST_PICTURES / PICTURES_PER_SECOND
            );
        }
        // The square of the envelope is taken as constant in each step.
        let fastest = scene.modulation.step_rate();
        let frames = cycle.map_or(0.0, |cycle| cycle.frames_per_second());
        let between = seconds / pictures;
        let steps = (between * fastest.max(frames)).ceil().max(1.0);
        Ok(Self { pictures: pictures as usize, steps: steps as usize, step: between / steps })
    }

    /// Frames per second of real time.
    pub fn rate(self) -> f64 {
        1.0 / (self.step * self.steps as f64)
    }
}

/// Waves on their way.
#[derive(Debug)]
pub struct Swell<'a> {
    scene: &'a Scene,
    schedule: Schedule,
    tank: Tank,
    /// Static depression under each frame of the motion.
    rests: Vec<Rest>,
    /// Cycles per second.
    rate: f64,
    waves: Waves,
    /// Time steps made.
    done: usize,
}

impl<'a> Swell<'a> {
    /// A level surface before the onset of a depression request's drives, played in sequence.
    ///
    /// # Errors
    /// As [`Stages::surface`], or frames that exceed the memory.
    pub fn new(
        scene: &'a Scene,
        schedule: Schedule,
        request: &Request,
        stages: &mut Stages,
        progress: &Gauge,
    ) -> Result<Self, FieldError> {
        let (mut rests, mut found) = (Vec::new(), None);
        for (index, drive) in request.drives.iter().enumerate() {
            stages.show_progress(progress.part(index..index + 1, request.drives.len()));
            let of_drive = Request { drives: [drive.clone()].into(), ..request.clone() };
            let (tank, dent) = stages.surface(&of_drive)?;
            if request.drives.len() * tank.count() * size_of::<f64>() > MOST_BYTES {
                return Err(FieldError::TooManyCells);
            }
            rests.push(Rest::new(tank, &dent.depth));
            found = Some(tank.clone());
        }
        progress.tell(1, 1);
        stages.show_progress(Gauge::default());
        let tank = found.ok_or(FieldError::NoPlane)?;
        let waves = Waves::new(&tank, &scene.liquid, schedule.step);
        let rate = motion::cycle(scene).map_or(0.0, |cycle| cycle.rate);
        Ok(Self { scene, schedule, tank, rests, rate, waves, done: 0 })
    }

    /// The depth (m, positive down) of every cell at the next picture.
    pub fn next_surface(&mut self) -> Vec<f64> {
        for _ in 0..self.schedule.steps {
            let time = (self.done as f64 + 0.5) * self.schedule.step;
            let frame = ((time * self.rate).fract() * self.rests.len() as f64) as usize;
            self.waves.advance(&self.rests[frame], self.scene.modulation.envelope(time).powi(2));
            self.done += 1;
        }
        self.waves.surface(&self.tank)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::field::{Evaluator, Quantity};
    use crate::scene::{Envelope, LiquidName, Modulation, Plane, Shape, Target};
    use crate::solver;

    #[test]
    fn a_thick_liquid_settles_where_the_mean_of_the_envelope_presses_it() {
        let mut scene = Scene {
            targets: vec![Target::new(Shape::Point { at: Plane::default().centre })],
            plane: Plane { size: DVec2::splat(0.06), ..Plane::default() },
            modulation: Modulation { shape: Envelope::Sine, frequency: 300.0, ..Modulation::default() },
            ..Scene::default()
        };
        (scene.liquid.name, scene.liquid.viscosity) = (Some(LiquidName::Glycerol), Some(4.0));
        let drives = vec![solver::solve(&scene).unwrap().drive];
        let request = Request::new(&scene, drives, Quantity::Depression, (10, 10));
        let mut stages = Stages::new(Evaluator::Cpu);
        let dent = stages.surface(&request).unwrap().1.clone();
        let schedule = Schedule::new(&scene, Some(5.0)).unwrap();
        let mut swell = Swell::new(&scene, schedule, &request, &mut stages, &Gauge::default()).unwrap();
        let surface = (0..schedule.pictures).map(|_| swell.next_surface()).last().unwrap();
        // The volume of the liquid is conserved.
        let lift = dent.depth.iter().sum::<f64>() / dent.depth.len() as f64;
        let deepest = |surface: &[f64]| surface.iter().copied().fold(0.0, f64::max);
        let (moving, at_rest) = (deepest(&surface), deepest(&dent.depth));
        assert!((moving / (0.375 * (at_rest - lift)) - 1.0).abs() < 0.02, "{moving} {at_rest}");
    }
}
