//! A scene solved: its problem, its method, and the drive as played.

use num_complex::Complex64;
use web_time::{Duration, Instant};

use crate::acoustics::Aperture;
use crate::drive::Drive;
use crate::scene::{Amplitudes, Method, Pressures, Scene, Solver, outline};
use crate::solver::felt::Levelling;
use crate::solver::method::{excite, excite_from};
use crate::solver::problem::{Excitation, Problem};
use crate::solver::quality::Quality;
use crate::solver::shape::Search;
use crate::solver::solution::{Solution, SolveError, unless_cancelled};
use crate::solver::warning::Warning;
use crate::solver::{iteration, own, room, shape, trap, warning};

/// Solves the scene with its method, including its further search, or takes the drives of its file.
/// [`crate::gauge`] can cancel it, and bound the time of its iterations.
///
/// # Errors
/// A scene without usable focal points, `focus` with several, or a cancelled solver.
pub fn solve(scene: &Scene) -> Result<Solution, SolveError> {
    solve_with(scene, &mut |_| {})
}

/// Solves like [`solve`]. For areas with several drives in turn, one drive goes to `so_far` first, then better and better
/// ones of all, without [`Solution::figures`].
///
/// # Errors
/// The errors of [`solve`].
pub fn solve_with(scene: &Scene, so_far: &mut dyn FnMut(Solution)) -> Result<Solution, SolveError> {
    if scene.drive.is_named() {
        return own::solution(scene, true);
    }
    let start = Instant::now();
    let aperture = Aperture::new(scene);
    let mut foci = outline::foci(scene)?;
    let _room = room::of_methods(scene, foci.len(), 1)?;
    let mut levelling = Levelling::of(scene);
    loop {
        let problem = unless_cancelled(Problem::of_scene(scene, &aperture, foci))?;
        let excitation = excite_scene(scene, &problem, start, so_far)?;
        let seconds = start.elapsed().as_secs_f64();
        let mut solution = solution(scene, &problem, &excitation, seconds);
        let frame = std::slice::from_ref(&problem.foci);
        let levelled = levelling.next(frame, || solution.drives()).map_err(SolveError::Skin)?;
        if let Some(louder) = levelled.and_then(|mut frames| frames.pop()) {
            foci = louder;
            continue;
        }
        if problem.surroundings.is_some() {
            solution.judge(scene, &problem);
        }
        return unless_cancelled(solution);
    }
}

/// The excitation of the scene's method, including its further search.
fn excite_scene(
    scene: &Scene,
    problem: &Problem<'_>,
    start: Instant,
    so_far: &mut dyn FnMut(Solution),
) -> Result<Excitation, SolveError> {
    let time = Duration::try_from_secs_f64(scene.solver.search).unwrap_or_default();
    Ok(match (&problem.traps, scene.solver.method, &problem.surroundings) {
        (Some(traps), _, _) => trap::best(problem, traps, time),
        (None, Method::Best, Some(surroundings)) => {
            shape::best_within(problem, surroundings, time, &mut |found| {
                so_far(solution(scene, problem, &found, start.elapsed().as_secs_f64()));
            })
        }
        (None, Method::Best, None) => {
            let found = excite(problem, Method::Best, scene.solver.iterations)?;
            iteration::search_on(problem, found, time)
        }
        (None, method, _) => excite(problem, method, scene.solver.iterations)?,
    })
}

/// Solves within the time of a drag's frame: a shape's drive continues from the previous one, or is a first one,
/// without [`Solution::figures`]; the drive of traps continues from the previous one. Of as many drives as pay it is
/// the first. Other scenes are solved as usual.
///
/// # Errors
/// The errors of [`solve`].
pub fn solve_on(scene: &Scene, before: Option<&Solution>) -> Result<Solution, SolveError> {
    /// Calls without a previous drive: the strokes alone, then with little weight on the quiet region.
    const CALLS: usize = 2;
    if scene.drive.is_named() {
        return own::solution(scene, false);
    }
    let start = Instant::now();
    let aperture = Aperture::new(scene);
    let mut problem = Problem::of_scene(scene, &aperture, outline::foci(scene)?);
    let drives = *problem.drives.start();
    let are_like = std::mem::replace(&mut problem.drives, drives..=drives);
    // A file's drive is no start: it may be silent.
    let is_like = |before: &&Solution| {
        before.method.is_some()
            && before.drive.phases.len() == aperture.positions.len()
            && are_like.contains(&(before.others.len() + 1))
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
pub fn solution(scene: &Scene, problem: &Problem<'_>, excitation: &Excitation, seconds: f64) -> Solution {
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
        method: Some(scene.solver.method),
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
pub struct Played {
    /// u of each driven element, of modulus at most 1; several drives in turn are concatenated.
    pub values: Vec<Complex64>,
    /// Pressures as in [`Solution::pressures`].
    pub pressures: Vec<Complex64>,
    /// Fraction of full drive required by the targets; at most full drive is played.
    pub needed: f64,
}

impl Played {
    pub fn new(problem: &Problem<'_>, solver: &Solver, excitation: Excitation) -> Self {
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
pub fn needed(problem: &Problem<'_>, pressures: &[Complex64]) -> f64 {
    let targets = problem.targets();
    let along = pressures.iter().zip(&targets).map(|(p, target)| p.norm() * target).sum::<f64>();
    let power = pressures.iter().map(|p| p.norm_sqr()).sum::<f64>();
    if along > 0.0 { along / power } else { f64::INFINITY }
}
