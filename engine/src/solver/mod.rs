//! From focal points to a drive, and the quality of that drive.
//!
//! Every method is a function from a [`Problem`] to an [`Excitation`]; [`solve`] makes the excitation uniform, as
//! most boards require, scales it down for targets in pascals, and measures the result. [`Limits`] computes its
//! distance from the best possible drive on request. The inverses (`pinv`, `weighted`) are in [`inverse`], the phase
//! iterations (`naive`, `gs`, `gspat`, `wgs`, `greedy`, `best`) in [`iteration`]. [`shape`] is `best` for continuous
//! strokes and areas with low side lobes. [`frames`] solves motions.

mod bidiagonal;
mod cholesky;
mod contest;
mod descent;
pub mod frames;
mod inverse;
mod iteration;
pub mod levels;
mod matrix;
mod quality;
pub mod room;
pub mod shape;
mod singular;
mod starts;
mod statistics;
pub mod steps;
pub mod trap;
pub mod warning;

use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};
use web_time::{Duration, Instant};

use num_complex::Complex64;

use crate::acoustics::{Aperture, Transfer};
use crate::drive::Drive;
use crate::gauge;
use crate::scene::{Amplitudes, Focus, KeyError, Method, Part, Pressures, Scene, Solver, outline};

pub use inverse::rank_and_condition;
pub use quality::{Limits, Quality, bound};
pub use shape::{AreaFigures, Figures, Search, Stage, Surroundings};
pub use trap::Traps;
pub use warning::Warning;

/// The input of a method.
#[derive(Clone, Debug)]
pub struct Problem<'a> {
    pub aperture: &'a Aperture,
    pub foci: Vec<Focus>,
    /// Foci x driven elements.
    pub transfer: Transfer,
    /// The quiet region and areas, if the foci are samples of a shape.
    pub surroundings: Option<Surroundings>,
    /// The traps whose lobes are among the foci: traps have one solution for all methods.
    pub traps: Option<Traps>,
    /// Numbers of drives in turn of a drag's frame and of a whole search; more than 1 for shapes only.
    pub drives: RangeInclusive<usize>,
}

impl<'a> Problem<'a> {
    /// The foci of [`outline::foci`], or others like them.
    ///
    /// # Panics
    /// No foci, a focus beyond 1000 km or NaN, or a target that is not positive.
    pub fn new(aperture: &'a Aperture, foci: Vec<Focus>) -> Self {
        /// Limit of a focus' distance from the origin, m.
        const FARTHEST: f64 = 1e6;
        assert!(!foci.is_empty(), "a problem needs a focus");
        for Focus { position, target, .. } in &foci {
            assert!(position.is_finite() && position.abs().max_element() <= FARTHEST, "no focus: {position}");
            assert!(target.is_finite() && *target > 0.0, "no target: {target}");
        }
        let points: Vec<_> = foci.iter().map(|focus| focus.position).collect();
        Self {
            aperture,
            transfer: aperture.transfer(&points),
            foci,
            surroundings: None,
            traps: None,
            drives: 1..=1,
        }
    }

    /// The problem of a scene, with surroundings if it has continuous strokes, quiet zones or drives in turn.
    pub fn of_scene(scene: &Scene, aperture: &'a Aperture, foci: Vec<Focus>) -> Self {
        let drives = scene.drives_in_turn();
        let is_shape = !scene.quiet.is_empty()
            || *drives.start() > 1
            || scene.aims_at_depression()
            || foci.iter().any(|focus| !focus.is_separate());
        let surroundings = is_shape.then(|| Surroundings::new(scene, &foci));
        let traps = Traps::of_scene(scene, aperture, &foci);
        Self { surroundings, traps, drives, ..Self::new(aperture, foci) }
    }

    /// Adds surroundings to foci of shapes and separate foci: `best` is then [`shape::best`].
    pub fn with_surroundings(self, surroundings: Surroundings) -> Self {
        Self { surroundings: Some(surroundings), ..self }
    }

    /// Target pressure of every focus: ratios, or Pa (peak).
    pub fn targets(&self) -> Vec<f64> {
        self.foci.iter().map(|focus| focus.target).collect()
    }
}

/// A method's drive of the elements, before amplitudes are made uniform.
#[derive(Clone, Debug)]
pub struct Excitation {
    /// u of each driven element, to any scale; several drives in turn are concatenated.
    pub values: Vec<Complex64>,
    pub iterations: u32,
    /// ‖H u - p‖/‖p‖ for methods that prescribe the complex p.
    pub residual: Option<f64>,
    /// Levelling weights of the foci, if the method has them, for [`excite_from`].
    pub weights: Option<Vec<f64>>,
}

/// A drive and its pressures and figures at the foci.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Solution {
    pub method: Method,
    /// The played drive: uniform amplitude on every driven element, unless the scene requests otherwise.
    pub drive: Drive,
    /// The other drives in turn.
    pub others: Vec<Drive>,
    /// Factor on the drive, 0 to 1, for targets in pascals.
    pub turned_down: f64,
    /// |u| of the method's own excitation over its largest, per element of the array; 0 for elements that are off.
    pub excitation: Vec<f64>,
    pub foci: Vec<Focus>,
    /// Complex pressure (Pa, peak) at each focus; for several drives in turn, the modulus is the root mean square
    /// over all.
    pub pressures: Vec<Complex64>,
    pub quality: Quality,
    /// Figures of a shape, if requested.
    pub figures: Option<Figures>,
    pub iterations: u32,
    /// Time that the method took, transfer included, quality not.
    pub seconds: f64,
    /// Warnings about the result.
    pub warnings: Vec<Warning>,
}

impl Solution {
    /// The guaranteed fraction of the best possible smallest pressure/target at full drive, given the [`bound`].
    pub fn certified(&self, bound: f64) -> f64 {
        let relative = self.pressures.iter().zip(&self.foci).map(|(p, focus)| p.norm() / focus.target);
        let weakest = relative.fold(f64::INFINITY, f64::min);
        weakest / self.turned_down.max(f64::MIN_POSITIVE) / bound.max(f64::MIN_POSITIVE)
    }
}

impl Solution {
    /// All that take turns.
    pub fn drives(&self) -> Vec<Drive> {
        std::iter::once(&self.drive).chain(&self.others).cloned().collect()
    }

    /// u of the driven elements, drive after drive.
    fn played(&self, driven: &[usize]) -> Vec<Complex64> {
        let drives = std::iter::once(&self.drive).chain(&self.others);
        drives.flat_map(|drive| drive.excitation(driven)).collect()
    }

    /// Adds the figures of a shape, if missing; `problem` is that of the scene.
    pub fn judge(&mut self, scene: &Scene, problem: &Problem<'_>) {
        /// Side lobe of a drawing out of reach, whose sound goes elsewhere.
        const ASTRAY: f64 = 2.0;
        if self.figures.is_some() {
            return;
        }
        let u = self.played(&problem.aperture.driven);
        let surroundings = Surroundings {
            plane: shape::judged_plane(scene, &problem.foci),
            ..Surroundings::new(scene, &problem.foci)
        };
        let figures = shape::figures(problem, &surroundings, &u);
        self.figures = Some(figures);
        let is_stroked = self.foci.iter().any(|focus| focus.part == Part::Stroke);
        if self.method == Method::Best && is_stroked && figures.side_lobe > ASTRAY {
            self.warnings.push(Warning::OutOfReach(figures.side_lobe));
        }
    }

    /// The solution with the common phase of every drive matched to another solution's: the field is unchanged, and a
    /// board changes over without a jump.
    pub fn turned_to(mut self, other: &Self) -> Self {
        if other.drive.phases.len() != self.drive.phases.len() {
            return self;
        }
        let angle = turn(&mut self.drive, &other.drive);
        self.pressures.iter_mut().for_each(|pressure| *pressure *= Complex64::cis(-angle));
        self.others.iter_mut().zip(&other.others).for_each(|(drive, other)| {
            turn(drive, other);
        });
        self
    }
}

/// Removes the common phase (rad) of a drive relative to another.
fn turn(drive: &mut Drive, other: &Drive) -> f64 {
    let ahead = |(to, from): (&f64, &f64)| Complex64::cis(to - from);
    let angle = drive.phases.iter().zip(&other.phases).map(ahead).sum::<Complex64>().arg();
    drive.phases.iter_mut().for_each(|phase| *phase -= angle);
    angle
}

/// Errors of solving.
#[derive(Debug, thiserror::Error)]
pub enum SolveError {
    #[error(transparent)]
    Scene(#[from] KeyError),
    #[error(
        "method `focus` steers one focus and the scene has {0}: take `pinv`, `weighted` or `best` for several at once"
    )]
    SeveralFoci(usize),
    #[error("{elements} elements and {foci} foci need about {mebibytes} MiB of memory, more than there is")]
    TooLarge { elements: usize, foci: usize, mebibytes: usize },
    #[error("the solver was cancelled")]
    Cancelled,
}

/// What a step has made, unless it was cancelled.
fn unless_cancelled<T>(made: T) -> Result<T, SolveError> {
    if gauge::is_cancelled() { Err(SolveError::Cancelled) } else { Ok(made) }
}

/// Solves the scene with its method, including its further search. [`gauge`] can cancel it, and bound the time of its
/// iterations.
///
/// # Errors
/// A scene without usable focal points, `focus` with several, or a cancelled solver.
pub fn solve(scene: &Scene) -> Result<Solution, SolveError> {
    solve_with(scene, &mut |_| {})
}

/// As [`solve`]; of areas with several drives in turn one drive goes to `so_far` first, then better and better ones of
/// all, without [`Solution::figures`].
///
/// # Errors
/// As [`solve`].
pub fn solve_with(scene: &Scene, so_far: &mut dyn FnMut(Solution)) -> Result<Solution, SolveError> {
    let start = Instant::now();
    let aperture = Aperture::new(scene);
    let foci = outline::foci(scene)?;
    let _room = room::of_methods(scene, foci.len(), 1)?;
    let problem = unless_cancelled(Problem::of_scene(scene, &aperture, foci))?;
    let time = Duration::try_from_secs_f64(scene.solver.search).unwrap_or_default();
    let excitation = match (&problem.traps, scene.solver.method, &problem.surroundings) {
        (Some(traps), _, _) => trap::best(&problem, traps, time),
        (None, Method::Best, Some(surroundings)) => {
            shape::best_within(&problem, surroundings, time, &mut |found| {
                so_far(solution(scene, &problem, &found, start.elapsed().as_secs_f64()));
            })
        }
        (None, Method::Best, None) => {
            let found = excite(&problem, Method::Best, scene.solver.iterations)?;
            iteration::search_on(&problem, found, time)
        }
        (None, method, _) => excite(&problem, method, scene.solver.iterations)?,
    };
    let seconds = start.elapsed().as_secs_f64();
    let mut solution = solution(scene, &problem, &excitation, seconds);
    if problem.surroundings.is_some() {
        solution.judge(scene, &problem);
    }
    unless_cancelled(solution)
}

/// Solves within the time of a drag's frame: a shape's drive continues from the previous one, or is a first one,
/// without [`Solution::figures`]; the drive of traps continues from the previous one. Of as many drives as pay it is
/// the first. Other scenes are solved as usual.
///
/// # Errors
/// As [`solve`].
pub fn solve_on(scene: &Scene, before: Option<&Solution>) -> Result<Solution, SolveError> {
    /// Calls without a previous drive: the strokes alone, then with little weight on the quiet region.
    const CALLS: usize = 2;
    let start = Instant::now();
    let aperture = Aperture::new(scene);
    let mut problem = Problem::of_scene(scene, &aperture, outline::foci(scene)?);
    let drives = *problem.drives.start();
    let are_like = std::mem::replace(&mut problem.drives, drives..=drives);
    let is_like = |before: &&Solution| {
        before.drive.phases.len() == aperture.positions.len() && are_like.contains(&(before.others.len() + 1))
    };
    let surroundings = problem.surroundings.as_ref().filter(|_| scene.solver.method == Method::Best);
    let excitation = match (before.filter(is_like), surroundings) {
        (Some(before), _) if problem.traps.is_some() || surroundings.is_some() => {
            let mut values = before.played(&aperture.driven);
            values.truncate(drives * aperture.driven.len());
            excite_from(&problem, &Excitation { values, iterations: 0, residual: None, weights: None })
        }
        (_, None) => return solve(scene),
        (_, Some(surroundings)) => {
            let mut search = Search::new(&problem, surroundings);
            let found = std::iter::from_fn(|| search.advance()).take(CALLS).last();
            found.unwrap_or_else(|| iteration::naive(&problem))
        }
    };
    unless_cancelled(solution(scene, &problem, &excitation, start.elapsed().as_secs_f64()))
}

/// The solution of the scene's excitation as played.
fn solution(scene: &Scene, problem: &Problem<'_>, excitation: &Excitation, seconds: f64) -> Solution {
    let aperture = problem.aperture;
    let Played { values, pressures, needed } = Played::new(problem, &scene.solver, excitation.clone());
    let (elements, driven) = (aperture.positions.len(), &aperture.driven);
    let mut drives = values.chunks(driven.len()).map(|values| Drive::of(elements, driven, values));
    let quality = Quality::new(problem, excitation, &pressures);
    let mut warnings = warning::of_foci(aperture, &problem.foci);
    if needed > 1.0 {
        let asked = problem.targets().iter().sum::<f64>() / problem.foci.len() as f64;
        warnings.push(Warning::TooLoud { asked, brought: quality.mean_pressure });
    }
    Solution {
        method: scene.solver.method,
        drive: drives.next().unwrap_or_default(),
        others: drives.collect(),
        turned_down: needed.min(1.0),
        excitation: Drive::free(elements, driven, &excitation.values[..driven.len()]).amplitudes,
        warnings,
        foci: problem.foci.clone(),
        pressures,
        quality,
        figures: None,
        iterations: excitation.iterations,
        seconds,
    }
}

/// A method's excitation with the scene's amplitudes and pressures.
struct Played {
    /// u of each driven element, of modulus at most 1; several drives in turn are concatenated.
    values: Vec<Complex64>,
    /// As [`Solution::pressures`].
    pressures: Vec<Complex64>,
    /// Fraction of full drive required by the targets; at most full drive is played.
    needed: f64,
}

impl Played {
    fn new(problem: &Problem<'_>, solver: &Solver, excitation: Excitation) -> Self {
        let mut values = excitation.values;
        match solver.amplitudes {
            Amplitudes::Uniform => values.iter_mut().for_each(|u| *u = iteration::phase(*u)),
            Amplitudes::Free => {
                let largest = values.iter().map(|u| u.norm()).fold(f64::MIN_POSITIVE, f64::max);
                values.iter_mut().for_each(|u| *u /= largest);
            }
        }
        let mut pressures = problem.transfer.in_turn(&values);
        let needed = match solver.pressures {
            Pressures::Relative => 1.0,
            Pressures::Pascal => needed(problem, &pressures),
        };
        values.iter_mut().chain(&mut pressures).for_each(|value| *value *= needed.min(1.0));
        Self { values, pressures, needed }
    }
}

/// The fraction of full drive for the best fit to targets in pascals: the least Σ (s |p_m| - A_m)², since leakage
/// into a weak focus must not scale down the strong ones. Foci in the target ratios meet their targets exactly.
fn needed(problem: &Problem<'_>, pressures: &[Complex64]) -> f64 {
    let targets = problem.targets();
    let along = pressures.iter().zip(&targets).map(|(p, target)| p.norm() * target).sum::<f64>();
    let power = pressures.iter().map(|p| p.norm_sqr()).sum::<f64>();
    if along > 0.0 { along / power } else { f64::INFINITY }
}

/// The excitation of a method; `iterations` 0 takes the method's default.
///
/// # Errors
/// `focus` with several foci.
pub fn excite(problem: &Problem<'_>, method: Method, iterations: u32) -> Result<Excitation, SolveError> {
    if let Some(traps) = &problem.traps {
        return Ok(trap::best(problem, traps, Duration::ZERO));
    }
    let or = |default: u32| if iterations == 0 { default } else { iterations };
    Ok(match method {
        Method::Focus => focus(problem)?,
        Method::Pinv => inverse::pinv(problem),
        Method::Weighted => inverse::weighted(problem, or(7)),
        Method::Naive => iteration::naive(problem),
        Method::Gs => iteration::gs(problem, or(100)),
        Method::Gspat => iteration::gspat(problem, or(100)),
        Method::Wgs => iteration::wgs(problem, or(100)),
        Method::Greedy => iteration::greedy(problem, or(1)),
        Method::Best => match &problem.surroundings {
            Some(surroundings) => shape::best(problem, surroundings),
            None => contest::best(problem, or(20)),
        },
    })
}

/// The excitation of `best` for slightly moved foci, continued from `before`: faster than a search, and with
/// continuous phases.
pub fn excite_from(problem: &Problem<'_>, before: &Excitation) -> Excitation {
    /// Over many frames the weights follow all the same.
    const ITERATIONS: u32 = 1;
    if let Some(traps) = &problem.traps {
        return trap::best_from(problem, traps, &before.values);
    }
    match &problem.surroundings {
        Some(surroundings) => shape::best_from(problem, surroundings, &before.values),
        None => contest::best_from(problem, before, ITERATIONS),
    }
}

/// The strongest drive of `batches` of eight starts, levelled for long: a baseline for `best`, and hundreds of times slower.
pub fn search(problem: &Problem<'_>, batches: usize) -> Excitation {
    const ITERATIONS: u32 = 200;
    iteration::search(problem, batches, ITERATIONS)
}

/// Time of flight, equations (4) and (5) of Long et al. 2022: φ_n = k r_n.
fn focus(problem: &Problem<'_>) -> Result<Excitation, SolveError> {
    if problem.foci.len() != 1 {
        return Err(SolveError::SeveralFoci(problem.foci.len()));
    }
    let Aperture { element, positions, driven, .. } = problem.aperture;
    let distance = |&n: &usize| problem.foci[0].position.distance(positions[n]);
    let values =
        driven.iter().map(|n| Complex64::from_polar(1.0, element.wavenumber * distance(n))).collect();
    Ok(Excitation { values, iterations: 0, residual: None, weights: None })
}
