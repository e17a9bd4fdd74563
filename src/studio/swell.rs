//! The moving surface of a liquid: waves from the onset of the sound, picture by picture. Every frame of a motion and every edge
//! of the envelope acts at its own time.

use anyhow::bail;

use crate::acoustics::course::{Course, low_square, square_lines};
use crate::acoustics::response::Resonator;
use crate::field::{FieldError, Request, Stages};
use crate::gauge::Gauge;
use crate::scene::{Envelope, Law, Modulation, Scene, SpectralLine, motion};
use crate::surface::{Rest, Stretch, Tank, Waves};

/// Pictures per second of real time, and their limit.
const PICTURES_PER_SECOND: f64 = 400.0;
const MOST_PICTURES: f64 = 5000.0;
/// Default duration of waves in a scene at rest, s.
const STILL: f64 = 0.25;
/// Limit of memory for the static depressions of all frames, in bytes.
const MOST_BYTES: usize = 1 << 30;

/// Events this close are simultaneous, s.
const SAME: f64 = 1e-12;

/// The times of a wave simulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Schedule {
    pub pictures: usize,
    /// Pictures per second of real time.
    rate: f64,
}

impl Schedule {
    /// For a duration in seconds, or the scene's default.
    ///
    /// # Errors
    /// No time, or more than can be shown.
    pub fn new(scene: &Scene, seconds: Option<f64>) -> anyhow::Result<Self> {
        let seconds = seconds.unwrap_or(motion::cycle(scene).map_or(STILL, |cycle| 1.0 / cycle.rate));
        let pictures = (seconds * PICTURES_PER_SECOND).round();
        if !(1.0..=MOST_PICTURES).contains(&pictures) {
            bail!(
                "waves are shown for {} to {} s, {PICTURES_PER_SECOND} pictures each; {seconds} s were asked for",
                1.0 / PICTURES_PER_SECOND,
                MOST_PICTURES / PICTURES_PER_SECOND
            );
        }
        Ok(Self { pictures: pictures as usize, rate: pictures / seconds })
    }

    /// Frames per second of real time.
    pub fn rate(self) -> f64 {
        self.rate
    }
}

/// Events at an even rate, counted.
#[derive(Clone, Copy, Debug)]
struct Clock {
    /// Hz; 0 for no events.
    rate: f64,
    count: u64,
}

impl Clock {
    fn new(rate: f64) -> Self {
        Self { rate, count: 0 }
    }

    /// The time of the next event, s.
    fn next(self) -> f64 {
        (self.count + 1) as f64 / self.rate
    }

    /// Counts the next event if it is due.
    fn go_on(&mut self, time: f64) {
        if self.next() <= time + SAME {
            self.count += 1;
        }
    }
}

/// Waves on their way.
#[derive(Debug)]
pub struct Swell {
    modulation: Modulation,
    tank: Tank,
    /// Static depression under each frame of the motion, or each drive in turn.
    rests: Vec<Rest>,
    waves: Waves,
    /// The mean square of an envelope of sines or tones.
    mean: f64,
    pictures: Clock,
    frames: Clock,
    /// The half periods of a square wave, or the samples of a file.
    knots: Clock,
}

/// The lines of the square of an envelope of sines or tones, behind the elements' response; relative to the mean, which the drives of a
/// request have already.
fn swinging(scene: &Scene) -> Vec<SpectralLine> {
    let modulation = scene.envelope();
    let Some(resonator) = Resonator::new(scene) else { return square_lines(modulation, 0.0) };
    let mut lines = resonator.square_lines(modulation);
    let part = modulation.mean_square() / lines.first().map_or(1.0, |mean| mean.amplitude);
    lines.iter_mut().for_each(|line| line.amplitude *= part);
    lines
}

impl Swell {
    /// A level surface before the onset of a depression request's drives, played in sequence.
    ///
    /// # Errors
    /// The errors of [`Stages::surface`], or frames that exceed the memory.
    pub fn new(
        scene: &Scene,
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
        let modulation = scene.envelope().clone();
        let (lines, knots) = match modulation.shape {
            Envelope::Off => (Vec::new(), 0.0),
            Envelope::Sine | Envelope::Tones => (swinging(scene), 0.0),
            Envelope::Square => (Vec::new(), 2.0 * modulation.frequency),
            Envelope::File => (Vec::new(), modulation.wave.get().map_or(0.0, |samples| samples.rate)),
        };
        let (constant, swinging): (Vec<_>, Vec<_>) =
            lines.into_iter().partition(|line| line.frequency == 0.0);
        let waves = Waves::new(&tank, &scene.liquid, swinging);
        let frames = Course::new(scene, rests.len()).frames_per_second();
        let [pictures, frames, knots] = [schedule.rate, frames, knots].map(Clock::new);
        let mean = constant.iter().map(|line| line.amplitude).sum();
        Ok(Self { modulation, tank, rests, waves, mean, pictures, frames, knots })
    }

    /// A level surface again, before the onset.
    pub fn restart(&mut self) {
        self.waves.restart();
        for clock in [&mut self.pictures, &mut self.frames, &mut self.knots] {
            clock.count = 0;
        }
    }

    /// The depth (m, positive down) of every cell at the next picture.
    pub fn next_surface(&mut self) -> Vec<f64> {
        let (mut stretches, mut time) = (Vec::new(), self.pictures.count as f64 / self.pictures.rate);
        let end = self.pictures.next();
        self.pictures.count += 1;
        while end - time > SAME {
            let until = end.min(self.frames.next()).min(self.knots.next());
            let rest = (self.frames.count % self.rests.len() as u64) as usize;
            let [part, rise] = self.part(time, until);
            stretches.push(Stretch { rest, until, part, rise });
            self.frames.go_on(until);
            self.knots.go_on(until);
            time = until;
        }
        self.waves.advance(&self.rests, &stretches);
        self.waves.surface(&self.tank)
    }

    /// The mean of the envelope's square and its rise from one time (s) to another with no knot between, besides the
    /// lines of sines and tones.
    fn part(&self, from: f64, to: f64) -> [f64; 2] {
        match self.modulation.shape {
            Envelope::Off => [1.0, 0.0],
            Envelope::Sine | Envelope::Tones => [self.mean, 0.0],
            Envelope::Square if self.knots.count.is_multiple_of(2) => [1.0, 0.0],
            Envelope::Square => [low_square(&self.modulation), 0.0],
            Envelope::File => {
                let [a, b] = [from, to].map(|time| self.modulation.swing(time));
                match self.modulation.law {
                    Law::Power => [(a + b) / 2.0, b - a],
                    // The straight line with the mean and the first moment of the parabola.
                    Law::Amplitude => [(a * a + a * b + b * b) / 3.0, b * b - a * a],
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::*;
    use crate::field::{Evaluator, Quantity};
    use crate::scene::{LiquidName, Motion, MotionPath, Plane, Shape, Target, Tempo, Tone};
    use crate::scene::{Wave, Waveform};
    use crate::solver::frames;

    fn scene(motion: Motion, modulation: Modulation) -> Scene {
        let at = Plane::default().centre;
        Scene {
            targets: vec![Target::new(Shape::Point { at })],
            plane: Plane { size: DVec2::splat(0.03), ..Plane::default() },
            modulation,
            motion,
            ..Scene::default()
        }
    }

    fn circle(frames: u32, rate: f64) -> Motion {
        Motion { path: MotionPath::Circle, size: 0.02, frames, tempo: Tempo::Rate(rate), ..Motion::default() }
    }

    /// The request of all drives, with the static depression of each.
    fn at_rest(scene: &Scene, stages: &mut Stages) -> (Request, Vec<Vec<f64>>) {
        let sequence = frames::follow_with(scene, &Gauge::default()).unwrap();
        let drives: Vec<_> = sequence.frames.into_iter().map(|frame| frame.drive).collect();
        let request = Request::new(scene, drives, Quantity::Depression, (10, 10));
        let mut depths = Vec::new();
        for drive in request.drives.iter() {
            let of_drive = Request { drives: [drive.clone()].into(), ..request.clone() };
            depths.push(stages.surface(&of_drive).unwrap().1.depth.clone());
        }
        (request, depths)
    }

    fn surfaces(scene: &Scene, seconds: f64, request: &Request, stages: &mut Stages) -> Vec<Vec<f64>> {
        let schedule = Schedule::new(scene, Some(seconds)).unwrap();
        let mut swell = Swell::new(scene, schedule, request, stages, &Gauge::default()).unwrap();
        (0..schedule.pictures).map(|_| swell.next_surface()).collect()
    }

    fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
        values.into_iter().fold(0.0, |most, value: f64| most.max(value.abs()))
    }

    fn modulations() -> [Modulation; 6] {
        let of = |shape, frequency| Modulation { shape, frequency, ..Modulation::default() };
        let tone = |frequency, depth| Tone { frequency, depth, phase: 0.3 };
        let tones = vec![tone(23.0, 0.5), tone(61.7, 0.4)];
        let values = (0..37).map(|i| (f64::from(i * i) * 0.37).sin() as f32).collect();
        let wave = Wave::new(Waveform { file: "a.wav".into(), rate: 1333.0, values });
        [
            Modulation::default(),
            of(Envelope::Sine, 47.0),
            of(Envelope::Square, 71.3),
            Modulation { depth: 0.7, law: Law::Power, ..of(Envelope::Square, 200.0) },
            Modulation { tones, ..of(Envelope::Tones, 1.0) },
            Modulation { wave, ..of(Envelope::File, 1.0) },
        ]
    }

    #[test]
    fn frames_and_envelopes_act_at_their_own_times() {
        const STEPS: u32 = 1024;
        let mut stages = Stages::new(Evaluator::Cpu);
        for modulation in modulations() {
            for motion in [Motion::default(), circle(5, 37.7), circle(3, 400.0 / 3.0)] {
                let scene = scene(motion, modulation.clone());
                let (request, depths) = at_rest(&scene, &mut stages);
                let found = surfaces(&scene, 0.02, &request, &mut stages);
                // The same in short steps, whatever the time of changes in them.
                let tank = stages.surface(&request).unwrap().0.clone();
                let rests: Vec<_> = depths.iter().map(|depth| Rest::new(&tank, depth)).collect();
                let course = Course::new(&scene, rests.len());
                let mut waves = Waves::new(&tank, &scene.liquid, Vec::new());
                let (step, deepest) = (0.0025 / f64::from(STEPS), largest(depths.concat()));
                for (picture, surface) in (0u32..).zip(&found) {
                    let short = |i: u32| {
                        let time = (f64::from(picture * STEPS + i) + 0.5) * step;
                        let part = modulation.envelope(time).powi(2);
                        let until = f64::from(picture * STEPS + i + 1) * step;
                        Stretch { rest: course.frame(time), until, part, rise: 0.0 }
                    };
                    waves.advance(&rests, &(0..STEPS).map(short).collect::<Vec<_>>());
                    let apart = waves.surface(&tank).into_iter().zip(surface).map(|(a, b)| a - b);
                    let apart = largest(apart) / deepest;
                    assert!(apart < 5e-4, "{modulation:?}, {:?}, {picture}: {apart}", scene.motion.tempo);
                }
            }
        }
    }

    #[test]
    fn waves_settle_about_the_mean_of_all_frames() {
        // Four pictures in a cycle of three frames.
        let mut scene = scene(circle(3, 100.0), Modulation::default());
        (scene.liquid.name, scene.liquid.viscosity) = (Some(LiquidName::Glycerol), Some(4.0));
        let mut stages = Stages::new(Evaluator::Cpu);
        let (request, depths) = at_rest(&scene, &mut stages);
        let found = surfaces(&scene, 2.0, &request, &mut stages);
        let deepest = largest(depths.concat());
        let cells = depths[0].len() as f64;
        let mean = |depths: &[Vec<f64>], cell: usize| {
            depths.iter().map(|depth| depth[cell]).sum::<f64>() / depths.len() as f64
        };
        let lift = (0..depths[0].len()).map(|cell| mean(&depths, cell)).sum::<f64>() / cells;
        let last = &found[found.len() - 40..];
        let apart = largest((0..depths[0].len()).map(|cell| mean(last, cell) - (mean(&depths, cell) - lift)));
        assert!(apart < 2e-3 * deepest, "{}", apart / deepest);
    }

    #[test]
    fn drives_in_turn_press_by_their_mean() {
        let mut scene = scene(Motion::default(), Modulation::default());
        scene.targets.push(Target::new(Shape::Point { at: Plane::default().centre + DVec3::X * 0.01 }));
        let mut stages = Stages::new(Evaluator::Cpu);
        // A drive for each of the two.
        let drives = |scene: &Scene| at_rest(scene, &mut Stages::new(Evaluator::Cpu)).0.drives;
        let alone = |index: usize| {
            let targets = vec![scene.targets[index].clone()];
            drives(&Scene { targets, ..scene.clone() })[0].clone()
        };
        let both = [alone(0), alone(1)];
        let request = Request::new(&scene, both.to_vec(), Quantity::Depression, (10, 10));
        let in_turn = surfaces(&scene, 0.02, &request, &mut stages);
        let of_one = |index: usize, stages: &mut Stages| {
            surfaces(
                &scene,
                0.02,
                &Request { drives: [both[index].clone()].into(), ..request.clone() },
                stages,
            )
        };
        let (first, second) = (of_one(0, &mut stages), of_one(1, &mut stages));
        let [a, b, turns] = [first, second, in_turn].map(|mut all| all.pop().unwrap());
        let apart = largest((0..a.len()).map(|cell| (a[cell] + b[cell]) / 2.0 - turns[cell]));
        assert!(apart < 0.05 * largest(a), "{apart}");
    }
}
