//! The drives of all frames of a motion, each continued from the previous one with minimal phase changes.
//!
//! Keyframes are close to each other and solved in sequence; the frames between two keyframes continue from the
//! first, on all cores. The result for a frame depends only on its neighbours, so any number of threads gives the
//! same drives.

use serde::{Deserialize, Serialize};
use web_time::Instant;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::acoustics::Aperture;
use crate::drive::Drive;
use crate::gauge::{Counter, Gauge};
use crate::scene::{Focus, Method, Pressures, Scene, Solver, motion};
use crate::solver::steps::{PhaseSteps, phase_steps};
use crate::solver::{self, Excitation, Played, Problem, SolveError, room, statistics};

/// Limit of a focus' displacement between keyframes, in wavelengths, if there are frames between them.
const STRIDE: f64 = 0.15;
/// Limit of the focal displacement, in wavelengths, for continuing from the previous frame.
const FARTHEST: f64 = 0.5;
/// A frame below this fraction of its predecessors' result is searched anew.
const KEPT: f64 = 0.96;
/// The same for a shape, whose weakest point fluctuates with the samples.
const KEPT_OF_SHAPE: f64 = 0.85;

/// All frames of a cycle, or all drives in turn of a scene at rest.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Sequence {
    pub frames: Vec<Frame>,
    pub steps: PhaseSteps,
    /// Time that finding all drives took.
    pub seconds: f64,
}

/// The drive of one frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    pub foci: Vec<Focus>,
    /// Uniform amplitude on every driven element, unless the scene requests otherwise.
    pub drive: Drive,
    /// Complex pressure (Pa, peak) of the drive at each focus.
    pub pressures: Vec<Complex64>,
    /// Found independently of other frames.
    pub cold: bool,
}

impl Frame {
    /// Pa, peak.
    pub fn mean_pressure(&self) -> f64 {
        statistics::mean(self.pressures.iter().map(|p| p.norm()))
    }

    /// Of the weakest focus, Pa, peak.
    pub fn min_pressure(&self) -> f64 {
        self.pressures.iter().map(|p| p.norm()).fold(f64::INFINITY, f64::min)
    }

    /// Standard deviation over mean of pressure/target.
    pub fn spread(&self) -> f64 {
        statistics::spread(&self.relative().collect::<Vec<_>>())
    }

    fn relative(&self) -> impl Iterator<Item = f64> {
        self.pressures.iter().zip(&self.foci).map(|(p, focus)| p.norm() / focus.target)
    }
}

/// Solves every frame of the scene's motion with the scene's method. `best` continues from frame to frame; the other
/// methods solve each frame independently.
///
/// # Errors
/// As [`solver::solve`], and frames that [`motion::frames`] refuses.
pub fn follow(scene: &Scene) -> Result<Sequence, SolveError> {
    follow_with(scene, &Gauge::default())
}

/// As [`follow`], reporting the number of solved frames.
///
/// # Errors
/// As [`follow`].
pub fn follow_with(scene: &Scene, progress: &Gauge) -> Result<Sequence, SolveError> {
    let start = Instant::now();
    if scene.solver.frames > 1 && !motion::moves(scene) {
        return turns_of(scene);
    }
    let frames = motion::frames(scene)?;
    let aperture = Aperture::new(scene);
    // Identical frames are solved once.
    let stands: Vec<_> = frames.chunk_by(|a, b| a == b).collect();
    let problem = |stand: &&[Vec<Focus>]| Problem::of_scene(scene, &aperture, stand[0].clone());
    let settings = &scene.solver;
    let found = progress.count(stands.len());
    let most = stands.iter().map(|stand| stand[0].len()).max().unwrap_or(0);
    let _room = room::of_methods(scene, most, rayon::current_num_threads())?;
    let solved = if settings.method == Method::Best {
        chained(scene, &aperture, &stands.iter().map(|stand| &stand[0][..]).collect::<Vec<_>>(), &found)?
    } else {
        let alone = |stand| {
            let problem = problem(stand);
            found.add();
            Ok(Found::new(&problem, settings, excite(&problem, settings)?, true))
        };
        stands.par_iter().map(alone).collect::<Result<Vec<_>, SolveError>>()?
    };
    let turns: Vec<_> = turns(&solved)
        .into_iter()
        .zip(parts(scene, &stands))
        .map(|(angle, part)| Complex64::from_polar(part, angle))
        .collect();
    let frame = |(found, &turn): (Found, &Complex64)| found.into_frame(&aperture, turn);
    let solved: Vec<_> = solved.into_par_iter().zip(&turns).with_min_len(64).map(frame).collect();
    let seconds = start.elapsed().as_secs_f64();

    let mut steps = phase_steps(&phases(&solved), &aperture.driven, frames.len());
    steps.to = stands[..steps.to].iter().map(|stand| stand.len()).sum();
    let repeated =
        solved.into_iter().zip(&stands).flat_map(|(frame, stand)| std::iter::repeat_n(frame, stand.len()));
    Ok(Sequence { frames: repeated.collect(), steps, seconds })
}

/// The drives in turn, as frames.
fn turns_of(scene: &Scene) -> Result<Sequence, SolveError> {
    let solution = solver::solve(scene)?;
    let aperture = Aperture::new(scene);
    let transfer = Problem::new(&aperture, solution.foci.clone()).transfer;
    let frame = |drive: Drive| {
        let pressures = transfer.pressure(&drive.excitation(&aperture.driven));
        Frame { foci: solution.foci.clone(), drive, pressures, cold: true }
    };
    let frames: Vec<_> = solution.drives().into_iter().map(frame).collect();
    let steps = phase_steps(&phases(&frames), &aperture.driven, frames.len());
    Ok(Sequence { frames, steps, seconds: solution.seconds })
}

fn phases(frames: &[Frame]) -> Vec<&[f64]> {
    frames.iter().map(|frame| &frame.drive.phases[..]).collect()
}

/// The fraction at which each distinct frame is played. Along outlines and keyframes, pressures are relative to other
/// frames, too: the loudest focus of the cycle is at full drive.
fn parts(scene: &Scene, stands: &[&[Vec<Focus>]]) -> Vec<f64> {
    let each: Vec<_> = stands.iter().map(|stand| loudest(&stand[0])).collect();
    let most = each.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let is_relative = scene.solver.pressures == Pressures::Relative && motion::has_dynamics(scene);
    each.into_iter().map(|part| if is_relative { part / most } else { 1.0 }).collect()
}

fn loudest(foci: &[Focus]) -> f64 {
    foci.iter().map(|focus| focus.target).fold(0.0, f64::max)
}

/// The result for a frame, before its common phase is chosen.
struct Found {
    foci: Vec<Focus>,
    /// u of the driven elements.
    u: Vec<Complex64>,
    /// Pa, peak, at the foci.
    pressures: Vec<Complex64>,
    /// Fraction of full drive, 0 to 1.
    turned_down: f64,
    cold: bool,
}

impl Found {
    fn new(problem: &Problem<'_>, settings: &Solver, excitation: Excitation, cold: bool) -> Self {
        let Played { values, pressures, needed } = Played::new(problem, settings, excitation);
        Self { foci: problem.foci.clone(), pressures, u: values, turned_down: needed.min(1.0), cold }
    }

    /// The weakest pressure/target.
    fn weakest(&self) -> f64 {
        let relative = self.pressures.iter().zip(&self.foci).map(|(p, focus)| p.norm() / focus.target);
        relative.fold(f64::INFINITY, f64::min)
    }

    /// Turned as a whole, and turned down.
    fn into_frame(self, aperture: &Aperture, turn: Complex64) -> Frame {
        let Aperture { positions, driven, .. } = aperture;
        let turned =
            |values: Vec<Complex64>| values.into_iter().map(|value| value * turn).collect::<Vec<_>>();
        Frame {
            foci: self.foci,
            drive: Drive::of(positions.len(), driven, &turned(self.u)),
            pressures: turned(self.pressures),
            cold: self.cold,
        }
    }
}

/// A frame with the data for continuing to the next.
struct Link {
    found: Found,
    weights: Option<Vec<f64>>,
    /// The weakest pressure/target, times the largest target, over the RMS transfer to the foci: comparable for all
    /// positions and target levels.
    part: f64,
    /// The most that this was since the last search.
    most: f64,
}

impl Link {
    fn new(problem: &Problem<'_>, settings: &Solver, mut excitation: Excitation, cold: bool) -> Self {
        let weights = excitation.weights.take();
        let found = Found::new(problem, settings, excitation, cold);
        let weakest = found.weakest() * loudest(&found.foci);
        let part = weakest / (found.turned_down * heard(problem)).max(f64::MIN_POSITIVE);
        Self { found, weights, part, most: part }
    }

    fn excitation(&self) -> Excitation {
        let (values, weights) = (self.found.u.clone(), self.weights.clone());
        Excitation { values, iterations: 0, residual: None, weights }
    }
}

/// √(Σ|H|²) over all foci and some elements, Pa.
fn heard(problem: &Problem<'_>) -> f64 {
    /// No divisor of a usual row, so that the elements are scattered.
    const EVERY: usize = 7;
    let power = problem.transfer.rows().flat_map(|row| row.step_by(EVERY)).map(|h| h.norm_sqr()).sum::<f64>();
    (power / problem.foci.len() as f64).sqrt().max(f64::MIN_POSITIVE)
}

fn excite(problem: &Problem<'_>, settings: &Solver) -> Result<Excitation, SolveError> {
    solver::excite(problem, settings.method, settings.iterations)
}

fn chained(
    scene: &Scene,
    aperture: &Aperture,
    foci: &[&[Focus]],
    done: &Counter,
) -> Result<Vec<Found>, SolveError> {
    let settings = &scene.solver;
    let problem = |frame: usize| Problem::of_scene(scene, aperture, foci[frame].to_vec());
    let keys = keyframes(foci, STRIDE * aperture.wavelength());
    let first = problem(keys[0]);
    let mut links = vec![Link::new(&first, settings, excite(&first, settings)?, true)];
    for (before, &key) in keys[1..].iter().enumerate() {
        links.push(go_on(&problem(key), &links[before], settings)?);
        done.add();
    }
    let between = |&frame: &usize| {
        let before = keys.partition_point(|&key| key < frame) - 1;
        done.add();
        Ok((frame, go_on(&problem(frame), &links[before], settings)?.found))
    };
    let gaps: Vec<_> = (0..foci.len()).filter(|frame| keys.binary_search(frame).is_err()).collect();
    let mut found = gaps.par_iter().map(between).collect::<Result<Vec<_>, SolveError>>()?;
    found.extend(keys.iter().copied().zip(links.into_iter().map(|link| link.found)));
    found.sort_by_key(|&(frame, _)| frame);
    Ok(found.into_iter().map(|(_, found)| found).collect())
}

/// The first frame, then repeatedly the last frame close to the previous keyframe, or else the next one.
fn keyframes(foci: &[&[Focus]], stride: f64) -> Vec<usize> {
    let mut keys = vec![0];
    let mut key = 0;
    for frame in 1..foci.len() {
        if farthest(foci[key], foci[frame]) > stride {
            key = (frame - 1).max(key + 1);
            keys.push(key);
        }
    }
    keys
}

/// The largest displacement of a focus (m); infinite for different numbers of foci.
fn farthest(from: &[Focus], to: &[Focus]) -> f64 {
    if from.len() != to.len() {
        return f64::INFINITY;
    }
    from.iter().zip(to).map(|(a, b)| a.position.distance(b.position)).fold(0.0, f64::max)
}

/// Continues from a frame; if that is too far away, or the result is worse than before, a search decides.
fn go_on(problem: &Problem<'_>, before: &Link, settings: &Solver) -> Result<Link, SolveError> {
    let near = farthest(&before.found.foci, &problem.foci) <= FARTHEST * problem.aperture.wavelength();
    let search = || Ok(Link::new(problem, settings, excite(problem, settings)?, true));
    if !near {
        return search();
    }
    let warm = Link::new(problem, settings, solver::excite_from(problem, &before.excitation()), false);
    let kept = if problem.surroundings.is_some() { KEPT_OF_SHAPE } else { KEPT };
    if warm.part >= kept * before.most {
        return Ok(Link { most: warm.part.max(before.most), ..warm });
    }
    let cold: Link = search()?;
    Ok(if cold.part > warm.part { cold } else { warm })
}

/// Common phase (rad) of each frame that minimises phase changes from the previous one, also from the last to the
/// first: the remainder at the end of the cycle is distributed over all frames.
fn turns(frames: &[Found]) -> Vec<f64> {
    let count = frames.len();
    let ahead = |i: usize| {
        let before = &frames[(i + count - 1) % count];
        before.u.iter().zip(&frames[i].u).map(|(from, to)| from.conj() * to).sum::<Complex64>().arg()
    };
    let ahead: Vec<_> = (0..count).map(ahead).collect();
    let left_over = Complex64::from_polar(1.0, ahead.iter().sum()).arg();
    let mut angle = 0.0;
    let turn = |ahead: &f64| {
        angle += left_over / count as f64 - ahead;
        angle
    };
    std::iter::once(0.0).chain(ahead[1..].iter().map(turn)).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use glam::DVec3;

    use super::*;
    use crate::scene::{Motion, MotionPath, Shape, Target};

    fn scene(points: &[DVec3], frames: u32) -> Scene {
        let target = |&at: &DVec3| Target::new(Shape::Point { at });
        Scene {
            targets: points.iter().map(target).collect(),
            motion: Motion { path: MotionPath::Circle, frames, ..Motion::default() },
            ..Scene::default()
        }
    }

    fn ring(count: usize) -> Vec<DVec3> {
        let at = |i: usize| {
            let (sin, cos) = (TAU * i as f64 / count as f64).sin_cos();
            DVec3::new(0.02 * cos, 0.02 * sin, 0.1)
        };
        (0..count).map(at).collect()
    }

    /// The weakest focus of every frame relative to that of a search for this frame alone.
    fn beside_search(scene: &Scene, sequence: &Sequence) -> Vec<f64> {
        let aperture = Aperture::new(scene);
        let part = |frame: &Frame| {
            let problem = Problem::new(&aperture, frame.foci.clone());
            let cold = Found::new(&problem, &scene.solver, excite(&problem, &scene.solver).unwrap(), true);
            frame.min_pressure() / cold.weakest()
        };
        sequence.frames.iter().map(part).collect()
    }

    #[test]
    fn going_on_from_frame_to_frame_reaches_what_searching_does() {
        let scene = scene(&ring(8), 64);
        let sequence = follow(&scene).unwrap();
        let parts = beside_search(&scene, &sequence);
        let mean = parts.iter().sum::<f64>() / 64.0;
        assert!(mean > 0.995, "{mean}");
        assert!(parts.iter().all(|&part| part > 0.98), "{parts:?}");
        let cold = sequence.frames.iter().filter(|frame| frame.cold).count();
        assert!((1..=4).contains(&cold), "{cold} searches");
    }

    #[test]
    fn a_slow_decline_is_measured_from_the_last_search() {
        let scene = scene(&ring(8), 64);
        let aperture = Aperture::new(&scene);
        let near = |shift: f64| {
            let place = |at: DVec3| Focus::new(at + DVec3::X * shift, 1.0);
            Problem::new(&aperture, ring(8).into_iter().map(place).collect())
        };
        let found = excite(&near(0.0), &scene.solver).unwrap();
        let mut before = Link::new(&near(0.0), &scene.solver, found, true);
        before.most *= 1.0 + 1e-3;
        let after = go_on(&near(1e-5), &before, &scene.solver).unwrap();
        assert!(!after.found.cold && after.part < before.most, "{}, {}", after.part, before.most);
        assert_eq!(after.most, before.most);
    }

    #[test]
    fn crowded_foci_are_searched_for_where_going_on_fails() {
        let row: Vec<_> =
            (0..16).map(|i| DVec3::new(-0.035 + 0.07 * f64::from(i) / 15.0, 0.0, 0.1)).collect();
        let scene = scene(&row, 64);
        let sequence = follow(&scene).unwrap();
        let parts = beside_search(&scene, &sequence);
        assert!(parts.iter().all(|&part| part > 0.85), "{parts:?}");
        assert!(sequence.frames.iter().filter(|frame| frame.cold).count() > 4);
    }

    #[test]
    fn any_number_of_threads_finds_the_same_drives() {
        let scene = scene(&ring(5), 300);
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| follow(&scene).unwrap())
        };
        let (one, four) = (with(1), with(4));
        assert_eq!(one.frames, four.frames);
        assert_eq!(one.steps, four.steps);
    }

    #[test]
    fn slow_foci_move_phases_by_little_even_where_the_round_closes() {
        for method in [Method::Focus, Method::Best, Method::Weighted] {
            let mut scene = scene(&[DVec3::new(0.01, 0.0, 0.1)], 512);
            scene.solver.method = method;
            let steps = follow(&scene).unwrap().steps;
            let step = scene.motion.length() / 512.0;
            let farthest = Aperture::new(&scene).element.wavenumber * step;
            assert!(steps.largest < farthest, "{method:?}: {steps:?}, more than the way in wavelengths");
            assert!(steps.rms > 0.2 * farthest, "{method:?}: {steps:?}");
        }
    }

    #[test]
    fn frames_are_what_their_drives_play() {
        let mut scene = scene(&ring(3), 24);
        scene.array.off = vec![0, 100];
        for method in [Method::Best, Method::Weighted, Method::Naive] {
            scene.solver.method = method;
            let aperture = Aperture::new(&scene);
            for frame in follow(&scene).unwrap().frames {
                let problem = Problem::new(&aperture, frame.foci.clone());
                let played = problem.transfer.pressure(&frame.drive.excitation(&aperture.driven));
                let largest = frame.pressures.iter().map(|p| p.norm()).fold(0.0, f64::max);
                for (played, said) in played.iter().zip(&frame.pressures) {
                    assert!((played - said).norm() < 1e-9 * largest, "{method:?}: {played} and {said}");
                }
                assert_eq!(frame.drive.amplitudes[100], 0.0);
            }
        }
    }

    #[test]
    fn keyframes_are_as_few_as_the_stride_allows() {
        const STRIDE: f64 = 2.5e-3;
        // Steps of a millimetre, and a jump.
        let places = (0..20).map(|i| DVec3::new(1e-3 * f64::from(i + if i < 11 { 0 } else { 7 }), 0.0, 0.1));
        let frames: Vec<_> = places.map(|position| [Focus::new(position, 1.0)]).collect();
        let frames: Vec<_> = frames.iter().map(|foci| &foci[..]).collect();
        let keys = keyframes(&frames, STRIDE);
        assert_eq!(keys[0], 0);
        for pair in keys.windows(2) {
            let from_key = |frame: usize| farthest(frames[pair[0]], frames[frame]);
            assert!(pair[1] == pair[0] + 1 || from_key(pair[1]) <= STRIDE, "{keys:?}");
            assert!(from_key(pair[1] + 1) > STRIDE, "{keys:?}: the next frame would have done");
        }
        assert!(farthest(frames[keys[keys.len() - 1]], frames[19]) <= STRIDE, "{keys:?}");
    }

    #[test]
    fn steps_are_searched_for_once_and_stand_still() {
        let mut scene = scene(&ring(4), 12);
        scene.motion.path = MotionPath::Steps;
        for (target, step) in scene.targets.iter_mut().zip([0, 1, 2, 2]) {
            target.step = Some(step);
        }
        let sequence = follow(&scene).unwrap();
        for (i, frame) in sequence.frames.iter().enumerate() {
            let first = &sequence.frames[i / 4 * 4];
            assert!(frame.cold && frame == first, "frame {i}");
        }
        assert_eq!(sequence.frames[8].foci.len(), 2);
        assert_eq!(sequence.steps.to % 4, 0, "a step begins where phases jump");
    }

    #[test]
    fn a_focus_that_runs_is_as_loud_along_the_stroke_as_wanted() {
        let vertices = [-0.02, 0.02].map(|x| DVec3::new(x, 0.0, 0.1)).to_vec();
        let mut scene = scene(&[], 16);
        scene.motion.path = MotionPath::Outline;
        scene.targets = vec![Target::new(Shape::Path { vertices, closed: false })];
        let at_full = follow(&scene).unwrap();
        assert!(at_full.frames.iter().all(|frame| frame.drive.amplitudes.iter().all(|&a| a == 1.0)));
        scene.targets[0].pressures = vec![1.0, 0.25];
        let fading = follow(&scene).unwrap();
        for (i, (fading, full)) in fading.frames.iter().zip(&at_full.frames).enumerate() {
            let wanted = 1.0 - 0.75 * i as f64 / 16.0;
            assert!((fading.foci[0].target - wanted).abs() < 1e-12);
            assert!((fading.drive.amplitudes[0] - wanted).abs() < 1e-12, "frame {i}");
            assert!((fading.mean_pressure() / full.mean_pressure() - wanted).abs() < 1e-9, "frame {i}");
        }
    }

    #[test]
    fn a_stroke_that_stands_is_even_while_a_focus_runs_beside_it() {
        let own = |path| Some(Motion { path, ..Motion::default() });
        let line = Shape::Line { from: DVec3::new(-0.02, -0.02, 0.1), to: DVec3::new(0.02, -0.02, 0.1) };
        let ring = Shape::Circle { at: DVec3::new(0.0, 0.02, 0.1), radius: 0.01 };
        let mut scene = scene(&[], 8);
        scene.motion.path = MotionPath::None;
        scene.targets =
            vec![Target::new(line), Target { motion: own(MotionPath::Outline), ..Target::new(ring) }];
        scene.targets[1].motion.as_mut().unwrap().frames = 8;
        let frames = follow(&scene).unwrap().frames;
        assert_eq!(frames.len(), 8);
        for frame in &frames {
            let strokes: Vec<_> = frame.foci.iter().map(|focus| !focus.is_separate()).collect();
            assert!(strokes.iter().filter(|&&of_stroke| !of_stroke).count() == 1 && strokes.len() > 15);
            let (mean, min) = (frame.mean_pressure(), frame.min_pressure());
            assert!(min > 0.7 * mean, "{min} of {mean} Pa");
        }
    }

    #[test]
    fn a_scene_that_stands_still_is_one_frame() {
        let mut scene = scene(&ring(2), 9);
        scene.motion.path = MotionPath::None;
        let sequence = follow(&scene).unwrap();
        let alone = solver::solve(&scene).unwrap();
        assert_eq!(sequence.frames.len(), 1);
        assert_eq!(sequence.steps, PhaseSteps::default());
        assert!((sequence.frames[0].min_pressure() / alone.quality.min_pressure - 1.0).abs() < 1e-9);
        assert!((sequence.frames[0].spread() - alone.quality.spread).abs() < 1e-9);
    }
}
