//! The time at which a changing scene is solved: at once, in the background, or further once it rests.
//!
//! A drag has a drive in every frame: a changed scene is first solved quickly, from the drive before. The window does
//! this between two frames as long as it is prompt, and otherwise on a thread; `serve` always on a thread, since the
//! thread that owns a board never solves. Once nothing changes, a shape is searched on in the background.

use std::sync::Arc;

use web_time::Duration;

use crate::acoustics::Aperture;
use crate::gauge::Gauge;
use crate::scene::{Scene, Solver, check, outline};
use crate::solver::frames::{self, Sequence};
use crate::solver::{self, Solution, SolveError};
use crate::studio::posing::is_shape;

/// Limit of foci times elements solved between two frames; more are solved in the background.
const AT_ONCE: usize = 120 * 256;
/// The same for shapes: a frame allows a few steps.
const AT_ONCE_OF_SHAPES: usize = 360 * 256;
/// Time after which solving moves to the background: the window stays responsive.
const PROMPT: Duration = Duration::from_millis(100);

/// The solution of a scene at rest.
pub type Solved = Result<Arc<Solution>, String>;
/// The solution of all frames of a motion.
pub type Followed = Result<Arc<Sequence>, String>;

/// Solves fully; solutions with fewer drives in turn go to `so_far`.
pub fn solve(scene: &Scene, so_far: &mut dyn FnMut(Solved)) -> Solved {
    shared(solver::solve_with(scene, &mut |found| so_far(Ok(Arc::new(found)))))
}

/// Solves in the time of a drag's frame, from the solution before.
pub fn solve_quickly(scene: &Scene, before: Option<&Solution>) -> Solved {
    shared(solver::solve_on(scene, before))
}

/// Solves all frames.
pub fn follow(scene: &Scene) -> Followed {
    shared(frames::follow(scene))
}

fn shared<T>(solved: Result<T, SolveError>) -> Result<Arc<T>, String> {
    solved.map(Arc::new).map_err(|error| error.to_string())
}

/// The next step for a scene at rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// A first drive.
    Quick,
    /// The drive of the full search.
    Full,
}

/// The solution of a scene at rest that changes.
#[derive(Debug, Default)]
pub struct Solving {
    /// The scene solved last, and its result.
    pub solved: Option<(Scene, Solved)>,
    /// The last drive, from which a quick solution goes on.
    pub last: Option<Arc<Solution>>,
    /// Foci times elements, and the solver, of a scene that was not solved promptly.
    slow: Option<(usize, Solver)>,
}

impl Solving {
    /// Forgets every solution, of a scene that has become empty.
    pub fn clear(&mut self) {
        (self.solved, self.last) = (None, None);
    }

    /// The missing step of a posed scene, if any; `rests` if nothing changes it now.
    pub fn next(&self, posed: &Scene, rests: bool) -> Option<Step> {
        let Some((_, solved)) = self.solved.as_ref().filter(|(scene, _)| scene == posed) else {
            return Some(Step::Quick);
        };
        let is_quick = solved.as_ref().is_ok_and(|found| found.figures.is_none());
        (rests && is_quick && is_shape(posed)).then_some(Step::Full)
    }

    /// Takes a result. A better drive of the same scene continues the phase of the one before.
    pub fn take(&mut self, posed: &Scene, solved: Solved) {
        let before = self.solved.as_ref().filter(|(scene, _)| scene == posed);
        let before = before.and_then(|(_, before)| before.as_ref().ok());
        let solved = match (solved, before) {
            (Ok(found), Some(before))
                if found.figures.is_none() && found.others.len() <= before.others.len() =>
            {
                return;
            }
            (Ok(found), Some(before)) => Ok(Arc::new(Arc::unwrap_or_clone(found).turned_to(before))),
            (solved, _) => solved,
        };
        if let Ok(found) = &solved {
            self.last = Some(Arc::clone(found));
            if found.seconds < PROMPT.as_secs_f64() {
                self.slow = None;
            }
        }
        self.solved = Some((posed.clone(), solved));
    }

    /// Solves a posed scene on this thread, unless that takes too long; returns whether it is solved.
    pub fn solve_at_once(&mut self, posed: &Scene) -> bool {
        let solved = match amount(posed) {
            Err(problem) => Err(problem),
            Ok(amount) => {
                let most = if is_shape(posed) { AT_ONCE_OF_SHAPES } else { AT_ONCE };
                let was_slow = |(slow, solver): &(usize, Solver)| amount >= *slow && *solver == posed.solver;
                // Foci in front of bodies need the answers to all elements.
                let lacks_answers = !posed.bodies.is_empty() && !Aperture::new(posed).is_prepared();
                if amount > most || lacks_answers || self.slow.as_ref().is_some_and(was_slow) {
                    return false;
                }
                let solve = || solver::solve_on(posed, self.last.as_deref());
                match Gauge::default().within(PROMPT).lead(solve) {
                    Err(SolveError::Cancelled) => {
                        self.slow = Some((amount, posed.solver.clone()));
                        return false;
                    }
                    solved => shared(solved),
                }
            }
        };
        self.take(posed, solved);
        true
    }
}

/// Foci times elements; with drives of a file, elements.
fn amount(scene: &Scene) -> Result<usize, String> {
    check::check(scene).map_err(|error| error.to_string())?;
    if scene.drive.is_named() {
        return Ok(scene.elements());
    }
    let foci = outline::foci(scene).map_err(|error| error.to_string())?;
    Ok(foci.len() * scene.elements())
}
