//! The drives of all frames of a motion, each continued from the previous one with minimal phase changes.
//!
//! Keyframes, at most 0.15 wavelengths apart if there are enough frames, are solved in sequence; the frames between
//! two keyframes continue from the first, in parallel. The start of a frame depends on the frames alone, so any
//! number of threads gives the same drives. A frame that reaches less than 96 % of its predecessors (85 % for
//! shapes, 70 % for traps), relative to what its positions allow, is searched anew, and the better drive is kept.
//! Finally each frame is rotated in phase as a whole, which changes no pressure, to minimise phase steps between
//! frames. Phases may still jump where the cycle closes: several foci can return with other relative phases. A
//! drive per frame stays in memory, but only one map.
//!
//! Foci running along outlines are points, so their frames are solved like any other; with continuous strokes
//! beside them, at rest or moving as a whole, the frame is solved as a shape. The position within a repetition is a
//! fraction of whole numbers, so foci visit bit-identical positions.

use serde::{Deserialize, Serialize};
use web_time::Instant;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::acoustics::Aperture;
use crate::drive::Drive;
use crate::gauge::{Counter, Gauge};
use crate::scene::motion::Posed;
use crate::scene::{Focus, Method, Pressures, Scene, Solver, motion};
use crate::solver::felt::Levelling;
use crate::solver::parts::Parts;
use crate::solver::problem::{Excitation, Problem};
use crate::solver::run::Played;
use crate::solver::solution::unless_cancelled;
use crate::solver::steps::{PhaseSteps, phase_steps};
use crate::solver::{self, own, room, solution::SolveError, statistics};

/// Limit of a focus' displacement between keyframes, in wavelengths, if there are frames between them.
const STRIDE: f64 = 0.15;
/// Limit of the focal displacement, in wavelengths, for continuing from the previous frame.
const FARTHEST: f64 = 0.5;
/// A frame below this fraction of its predecessors' result is searched anew.
const KEPT: f64 = 0.96;
/// The same for a shape, whose weakest point fluctuates with the samples.
const KEPT_OF_SHAPE: f64 = 0.85;
/// The same for traps, whose stiffness also depends on their place.
const KEPT_OF_TRAPS: f64 = 0.7;
/// Envelopes below this count as silence.
const SILENT: f64 = 1e-3;

/// All frames of a cycle, or all drives in turn of a scene at rest.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Sequence {
    pub frames: Vec<Frame>,
    pub steps: PhaseSteps,
    /// Time (s) for all drives.
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
    /// Pa, peak; 0 without foci, as the next two.
    pub fn mean_pressure(&self) -> f64 {
        if self.foci.is_empty() { 0.0 } else { statistics::mean(self.pressures.iter().map(|p| p.norm())) }
    }

    /// Pressure of the weakest focus, Pa, peak.
    pub fn min_pressure(&self) -> f64 {
        self.pressures.iter().map(|p| p.norm()).reduce(f64::min).unwrap_or(0.0)
    }

    /// Standard deviation over mean of pressure/target.
    pub fn spread(&self) -> f64 {
        let relative: Vec<_> = self.relative().collect();
        if relative.is_empty() { 0.0 } else { statistics::spread(&relative) }
    }

    /// Of foci that an envelope does not silence.
    fn relative(&self) -> impl Iterator<Item = f64> {
        let foci = self.pressures.iter().zip(&self.foci).filter(|(_, focus)| focus.target > 0.0);
        foci.map(|(p, focus)| p.norm() / focus.target)
    }
}

/// Solves every frame of the scene's motion with the scene's method, unless a file has its drives. `best` continues from frame to frame; the other
/// methods solve each frame independently.
///
/// # Errors
/// The errors of [`solver::solve`], and frames that [`motion::frames`] refuses.
pub fn follow(scene: &Scene) -> Result<Sequence, SolveError> {
    follow_with(scene, &Gauge::current())
}

/// Solves like [`follow`], reporting the number of solved frames, under the limits of `progress`.
///
/// # Errors
/// The errors of [`follow`].
pub fn follow_with(scene: &Scene, progress: &Gauge) -> Result<Sequence, SolveError> {
    let start = Instant::now();
    if scene.drive.is_named() {
        return progress.lead(|| of_file(scene));
    }
    if !motion::moves(scene) && *scene.drives_in_turn().end() > 1 {
        return turns_of(scene, progress);
    }
    let aperture = Aperture::new(scene);
    let mut frames = motion::frames(scene)?;
    let posed = Posed::of(scene)?;
    let mut levelling = Levelling::of(scene);
    loop {
        let solved = of_frames((scene, posed.as_ref()), &aperture, &frames, progress)?;
        let drives = || solved.iter().map(|frame| frame.drive.clone()).collect();
        match levelling.next(&frames, drives).map_err(SolveError::Skin)? {
            Some(levelled) => frames = levelled,
            None => {
                let steps = phase_steps(&phases(&solved), &aperture.driven, frames.len());
                return Ok(Sequence { frames: solved, steps, seconds: start.elapsed().as_secs_f64() });
            }
        }
    }
}

/// All frames, given their foci.
fn of_frames(
    (scene, posed): (&Scene, Option<&Posed<'_>>),
    aperture: &Aperture,
    frames: &[Vec<Focus>],
    progress: &Gauge,
) -> Result<Vec<Frame>, SolveError> {
    // Identical frames are solved once.
    let is_new = |frame: &usize| {
        let before = *frame - 1;
        frames[before] != frames[*frame]
            || posed.is_some_and(|posed| posed.poses(before) != posed.poses(*frame))
    };
    let starts: Vec<_> = std::iter::once(0).chain((1..frames.len()).filter(is_new)).collect();
    let ends = starts.iter().copied().skip(1).chain([frames.len()]);
    let stands: Vec<_> = starts.iter().zip(ends).map(|(&start, end)| &frames[start..end]).collect();
    let problem = |stand: usize| {
        let foci = stands[stand][0].clone();
        match posed {
            Some(posed) => Problem::of_scene(&posed.scene(starts[stand]), aperture, foci),
            None => Problem::of_scene(scene, aperture, foci),
        }
    };
    let settings = &scene.solver;
    let found = progress.count(stands.len());
    let most = stands.iter().map(|stand| stand[0].len()).max().unwrap_or(0);
    let _room = room::of_methods(scene, most, rayon::current_num_threads())?;
    let solved = if settings.method == Method::Best {
        let foci: Vec<_> = stands.iter().map(|stand| &stand[0][..]).collect();
        chained(settings, aperture, (&foci, &problem), progress, &found)?
    } else {
        let alone = |stand: usize| {
            limited(progress, stands.len(), || {
                let problem = problem(stand);
                let excitation = excite(&problem, settings)?;
                found.add();
                Ok(Found::new(&problem, settings, excitation, true))
            })
        };
        (0..stands.len()).into_par_iter().map(alone).collect::<Result<Vec<_>, SolveError>>()?
    };
    let turns: Vec<_> = turns(&solved)
        .into_iter()
        .zip(parts(scene, &stands))
        .map(|(angle, part)| Complex64::from_polar(part, angle))
        .collect();
    let frame = |(found, &turn): (Found, &Complex64)| found.into_frame(aperture, turn);
    let solved: Vec<_> = solved.into_par_iter().zip(&turns).with_min_len(64).map(frame).collect();
    if let Some(envelopes) = motion::envelopes_of(scene)? {
        return Ok(under(&envelopes, aperture, &solved, &stands));
    }
    let repeated =
        solved.into_iter().zip(&stands).flat_map(|(frame, stand)| std::iter::repeat_n(frame, stand.len()));
    Ok(repeated.collect())
}

/// The frames of a cycle under envelopes, from one of each stand; targets are those of the moment, 0 if silent. No
/// element exceeds full drive in any frame, and all frames are scaled alike.
fn under(
    envelopes: &motion::Envelopes,
    aperture: &Aperture,
    solved: &[Frame],
    stands: &[&[Vec<Focus>]],
) -> Vec<Frame> {
    let (mut start, mut all) = (0, Vec::new());
    for stand in stands {
        all.push(start..start + stand.len());
        start += stand.len();
    }
    let of_stand = |(frame, frames): (&Frame, &std::ops::Range<usize>)| {
        let points: Vec<_> = frame.foci.iter().map(|focus| focus.position).collect();
        let transfer = aperture.transfer(&points);
        let u = frame.drive.excitation(&aperture.driven);
        let count = envelopes.frames.first().map_or(0, Vec::len);
        let parts = Parts::new(&transfer, &u, &envelopes.of_foci, count);
        let under = |index: usize| parts.under(&envelopes.frames[index]);
        frames.clone().into_par_iter().map(under).collect::<Vec<_>>()
    };
    let sums: Vec<Vec<[Vec<Complex64>; 2]>> = solved.par_iter().zip(&all).map(of_stand).collect();
    let moduli = sums.iter().flatten().flat_map(|[u, _]| u).map(|u| u.norm());
    let scale = moduli.fold(1.0, f64::max).recip();
    let scaled = |values: Vec<Complex64>| values.into_iter().map(|value| value * scale).collect::<Vec<_>>();
    let of_all =
        sums.into_iter().zip(solved).flat_map(|(sums, frame)| sums.into_iter().map(move |sum| (sum, frame)));
    let frame = |(([u, pressures], frame), values): (([Vec<Complex64>; 2], &Frame), &Vec<f64>)| {
        let now = |(focus, of): (&Focus, &usize)| {
            let part = if values[*of] < SILENT { 0.0 } else { values[*of] };
            Focus { target: focus.target * part, ..*focus }
        };
        Frame {
            foci: frame.foci.iter().zip(&envelopes.of_foci).map(now).collect(),
            drive: Drive::of(aperture.positions.len(), &aperture.driven, &scaled(u)),
            pressures: scaled(pressures),
            cold: frame.cold,
        }
    };
    of_all.zip(&envelopes.frames).map(frame).collect()
}

/// One of `of` frames, on any thread, under the limits of all.
fn limited<T>(
    all: &Gauge,
    of: usize,
    solve: impl FnOnce() -> Result<T, SolveError>,
) -> Result<T, SolveError> {
    all.share(of).lead(|| unless_cancelled(solve()?))
}

/// The drives of the scene's file, as frames of its motion or of the scene at rest.
fn of_file(scene: &Scene) -> Result<Sequence, SolveError> {
    let start = Instant::now();
    let aperture = Aperture::new(scene);
    let foci = if scene.has_foci() { motion::frames(scene)? } else { vec![Vec::new()] };
    let frame = |(index, drive): (usize, Drive)| {
        let foci = foci[index % foci.len()].clone();
        let pressures = aperture.pressures_of(&foci, &drive.excitation(&aperture.driven));
        unless_cancelled(Frame { foci, drive, pressures, cold: true })
    };
    let drives = own::drives(scene, &aperture)?;
    let frames: Vec<_> = drives.into_par_iter().enumerate().map(frame).collect::<Result<_, _>>()?;
    let steps = phase_steps(&phases(&frames), &aperture.driven, frames.len());
    Ok(Sequence { frames, steps, seconds: start.elapsed().as_secs_f64() })
}

/// The drives in turn, as frames.
fn turns_of(scene: &Scene, progress: &Gauge) -> Result<Sequence, SolveError> {
    let solution = progress.lead(|| solver::solve(scene))?;
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

/// The fraction at which each distinct frame is played. Along outlines and keyframes, and where all is to be felt evenly, pressures
/// are relative to other frames, too: the loudest focus of the cycle is at full drive.
fn parts(scene: &Scene, stands: &[&[Vec<Focus>]]) -> Vec<f64> {
    let each: Vec<_> = stands.iter().map(|stand| loudest(&stand[0])).collect();
    let most = each.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let is_relative = scene.solver.pressures == Pressures::Relative
        && (motion::has_dynamics(scene) || scene.aims_at_felt());
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
    /// positions and target levels. Of traps: the weakest stiffness over the square of that transfer.
    part: f64,
    /// The most that this was since the last search.
    most: f64,
}

impl Link {
    fn new(problem: &Problem<'_>, settings: &Solver, mut excitation: Excitation, cold: bool) -> Self {
        let weights = excitation.weights.take();
        let found = Found::new(problem, settings, excitation, cold);
        let most = (found.turned_down * heard(problem)).max(f64::MIN_POSITIVE);
        let part = match &problem.traps {
            Some(traps) => {
                traps.weakest(problem.aperture, &found.u).into_iter().fold(f64::INFINITY, f64::min)
                    / (most * most).max(f64::MIN_POSITIVE)
            }
            None => found.weakest() * loudest(&found.foci) / most,
        };
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

fn chained<'a>(
    settings: &Solver,
    aperture: &Aperture,
    (foci, problem): (&[&[Focus]], &(dyn Fn(usize) -> Problem<'a> + Sync)),
    progress: &Gauge,
    done: &Counter,
) -> Result<Vec<Found>, SolveError> {
    let keys = keyframes(foci, STRIDE * aperture.wavelength());
    let next = |frame: usize, before: Option<&Link>| {
        let link = limited(progress, foci.len(), || {
            let problem = problem(frame);
            match before {
                Some(before) => go_on(&problem, before, settings),
                None => Ok(Link::new(&problem, settings, excite(&problem, settings)?, true)),
            }
        });
        done.add();
        link
    };
    let mut links: Vec<Link> = Vec::with_capacity(keys.len());
    for &key in &keys {
        links.push(next(key, links.last())?);
    }
    let between = |&frame: &usize| {
        let before = keys.partition_point(|&key| key < frame) - 1;
        Ok((frame, next(frame, Some(&links[before]))?.found))
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
    let kept = match (&problem.traps, &problem.surroundings) {
        (Some(_), _) => KEPT_OF_TRAPS,
        (None, Some(_)) => KEPT_OF_SHAPE,
        (None, None) => KEPT,
    };
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
mod tests;
