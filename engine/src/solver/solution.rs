//! A drive with its pressures and figures at the foci.
//!
//! For targets in pascals, the drive at full amplitude is scaled down by one factor, by least squares over the
//! foci; [`Solution::turned_down`] records it, and the fraction of the upper bound refers to the unscaled drive.

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use crate::drive::Drive;
use crate::field::FieldError;
use crate::gauge;
use crate::scene::{Focus, KeyError, Method, Part, Scene};
use crate::solver::problem::Problem;
use crate::solver::quality::Quality;
use crate::solver::shape;
use crate::solver::shape::surroundings::Surroundings;
use crate::solver::shape_figures::Figures;
use crate::solver::warning::Warning;

/// A drive and its pressures and figures at the foci.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Solution {
    /// `None` if a file has the drives.
    pub method: Option<Method>,
    /// The played drive: uniform amplitude on every driven element, unless the scene requests otherwise.
    pub drive: Drive,
    /// The other drives in turn.
    pub others: Vec<Drive>,
    /// Factor on the drive, 0 to 1, for targets in pascals.
    pub turned_down: f64,
    /// |u| of the method's own excitation over its largest, or the file's amplitude, per element of the array; 0 for
    /// elements that are off.
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
    /// The guaranteed fraction of the best possible smallest pressure/target at full drive, given the [`crate::solver::bound`].
    pub fn certified(&self, bound: f64) -> f64 {
        let relative = self.pressures.iter().zip(&self.foci).map(|(p, focus)| p.norm() / focus.target);
        let weakest = relative.fold(f64::INFINITY, f64::min);
        weakest / self.turned_down.max(f64::MIN_POSITIVE) / bound.max(f64::MIN_POSITIVE)
    }
}

impl Solution {
    /// The method's short name, or `drive` of a file's.
    pub fn method_name(&self) -> &'static str {
        self.method.map_or("drive", |method| method.into_str())
    }

    /// All that take turns.
    pub fn drives(&self) -> Vec<Drive> {
        std::iter::once(&self.drive).chain(&self.others).cloned().collect()
    }

    /// u of the driven elements, drive after drive.
    pub(super) fn played(&self, driven: &[usize]) -> Vec<Complex64> {
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
        if self.method == Some(Method::Best) && is_stroked && figures.side_lobe > ASTRAY {
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
pub fn turn(drive: &mut Drive, other: &Drive) -> f64 {
    let ahead = |(to, from): (&f64, &f64)| Complex64::cis(to - from);
    let angle = drive.phases.iter().zip(&other.phases).map(ahead).sum::<Complex64>().arg();
    drive.phases.iter_mut().for_each(|phase| *phase -= angle);
    angle
}

/// The result of a step, unless it was cancelled.
pub fn unless_cancelled<T>(made: T) -> Result<T, SolveError> {
    if gauge::is_cancelled() { Err(SolveError::Cancelled) } else { Ok(made) }
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
    #[error("`target` of [solver] is \"felt\": {0}")]
    Skin(FieldError),
    #[error("the solver was cancelled")]
    Cancelled,
}
