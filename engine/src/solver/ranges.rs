//! The figures of a solution on arrays whose elements differ at random: 5, 50 and 95 % of each, in closed form.
//!
//! The theory stands in [`Ensemble`]. A figure that is linear in the pressures is normal; the weakest pressure, the
//! evenness and the uniformity are those of a normal vector; the side lobe is the loudest of the maxima of the drive.
//!
//! *Faults.* If d of N elements are dead, the mean over all choices of them is (N - d)/N of the pressure everywhere,
//! exactly; if their wires are swapped, (N - 2d)/N.

use glam::DVec3;

use crate::acoustics::Ensemble;
use crate::field::{SideLobe, Stages, side_lobes};
use crate::scene::Scene;
use crate::solver::problem::Problem;
use crate::solver::shape;
use crate::solver::solution::Solution;
use crate::solver::statistics;

/// Limit of places at which figures are formed; of more foci and samples, these are evenly spread.
const MOST_PLACES: usize = 256;
/// Limit of responses in memory, places times elements.
const MOST_RESPONSES: usize = 1 << 23;
/// Maxima of the field that may become the side lobe.
const MAXIMA: usize = 48;

/// 5, 50 and 95 % of a solution's figures, in their own units.
#[derive(Clone, Debug, PartialEq)]
pub struct Ranges {
    pub mean_pressure: [f64; 3],
    pub min_pressure: [f64; 3],
    /// Standard deviation over mean.
    pub spread: [f64; 3],
    pub evenness: [f64; 3],
    pub relative_to_single: [f64; 3],
    pub strength: Option<[f64; 3]>,
    pub side_lobe: Option<[f64; 3]>,
    /// Mean and weakest pressure with equal elements, over their medians.
    pub won: [f64; 2],
}

impl Ranges {
    /// The ranges of a judged solution with its side lobe; `None` without a spread, or if the foci are silent.
    pub fn new(
        scene: &Scene,
        problem: &Problem<'_>,
        (solution, side_lobe): (&Solution, Option<&SideLobe>),
        stages: &mut Stages,
    ) -> Option<Self> {
        let (spread, quality) = (scene.array.spread, &solution.quality);
        if spread.is_none() || quality.is_silent() {
            return None;
        }
        let aperture = problem.aperture;
        let played = solution.played(&aperture.driven);
        let count = problem.foci.len();
        let most = (MOST_RESPONSES / aperture.driven.len().max(1)).clamp(1, MOST_PLACES).min(count);
        let some: Vec<_> = (0..most).map(|place| problem.foci[place * count / most]).collect();
        let transfer = aperture.transfer_to(&some);
        let ensemble = Ensemble::new(&transfer, &played, spread);
        let nominal: Vec<_> = ensemble.nominal().collect();
        let over_target: Vec<_> = some.iter().map(|focus| 1.0 / focus.target).collect();
        let relative: Vec<_> = nominal.iter().zip(&over_target).map(|(p, over)| p * over).collect();
        let single = transfer.rows().map(|row| row.map(|h| h.norm()).sum::<f64>().max(f64::MIN_POSITIVE));
        let over_single: Vec<_> = single.map(|single| 1.0 / single).collect();
        let alone: Vec<_> = nominal.iter().zip(&over_single).map(|(p, over)| p * over).collect();
        let mean = |values: &[f64]| statistics::mean(values.iter().copied());
        let least = |values: &[f64]| values.iter().copied().fold(f64::INFINITY, f64::min);
        let times = |range: [f64; 3], factor: f64| range.map(|value| value * factor);
        let of_targets = ensemble.normal.clone().times(&over_target);
        let mean_relative = times(of_targets.of_mean(), 1.0 / mean(&relative));
        let mean_pressure = times(ensemble.normal.of_mean(), quality.mean_pressure / mean(&nominal));
        let min_pressure = times(ensemble.normal.of_least(), quality.min_pressure / least(&nominal));
        let evenness = solution.figures.map_or(quality.evenness, |figures| figures.evenness);
        let of_singles = ensemble.normal.clone().times(&over_single);
        Some(Self {
            mean_pressure,
            min_pressure,
            spread: of_targets.of_uniformity(),
            evenness: times(
                of_targets.clone().relative().of_least(),
                evenness / statistics::evenness(&relative).max(f64::MIN_POSITIVE),
            ),
            relative_to_single: times(of_singles.of_mean(), quality.relative_to_single / mean(&alone)),
            strength: solution.figures.map(|figures| times(mean_relative, figures.strength)),
            side_lobe: side_lobe.and_then(|lobe| {
                let loudest = loudest(scene, problem, (solution, lobe.position), stages)?;
                Some(times(loudest, 1.0 / mean_pressure[1]))
            }),
            won: [quality.mean_pressure / mean_pressure[1], quality.min_pressure / min_pressure[1]],
        })
    }

    /// Every figure under its name in JSON.
    pub fn named(&self) -> impl Iterator<Item = (&'static str, [f64; 3])> {
        let Self {
            mean_pressure,
            min_pressure,
            spread,
            evenness,
            relative_to_single,
            strength,
            side_lobe,
            won: _,
        } = *self;
        let all = [
            ("mean_pressure", Some(mean_pressure)),
            ("min_pressure", Some(min_pressure)),
            ("spread", Some(spread)),
            ("evenness", Some(evenness)),
            ("relative_to_single", Some(relative_to_single)),
            ("strength", strength),
            ("side_lobe", side_lobe),
        ];
        all.into_iter().filter_map(|(name, range)| Some((name, range?)))
    }
}

/// 5, 50 and 95 % of the loudest |p| outside the main lobes (Pa, peak), one of which is at `lobe`.
fn loudest(
    scene: &Scene,
    problem: &Problem<'_>,
    (solution, lobe): (&Solution, DVec3),
    stages: &mut Stages,
) -> Option<[f64; 3]> {
    let (aperture, foci) = (problem.aperture, &solution.foci[..]);
    let plane = shape::judged_plane(scene, foci);
    let most = (MOST_RESPONSES / aperture.driven.len().max(1)).clamp(1, MAXIMA);
    let mut places = side_lobes(stages, aperture, &plane, &solution.drives(), (foci, most)).ok()?;
    places.insert(0, lobe);
    let played = solution.played(&aperture.driven);
    Some(Ensemble::new(&aperture.transfer(&places), &played, scene.array.spread).of_loudest())
}

/// Pressure that faults leave, on average over the elements that have them: of `dead` elements, and of `reversed`
/// ones, of all.
pub fn left_by_faults(elements: usize, dead: usize, reversed: usize) -> f64 {
    1.0 - (dead as f64 + 2.0 * reversed as f64) / elements.max(1) as f64
}
