//! Drives for boards with few phase levels: rounding, and a search on the levels themselves.

use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::drive::{Drive, delay_level};
use crate::solver::{problem::Problem, starts};

/// Up to this number of levels, all are tried for an element; beyond, only the neighbours.
const ALL_TRIED: u32 = 16;
/// Limit of passes over all elements; more than three rarely change anything.
const PASSES: usize = 6;
/// Exponent of 1/pressure in the minimised sum, which emphasises the weakest focus.
const EMPHASIS: i32 = 64;

/// The pressures of a uniform drive at the foci.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reached {
    /// Pa, peak.
    pub mean_pressure: f64,
    /// The smallest pressure/target: Pa, or a fraction for targets in Pa.
    pub weakest: f64,
    /// Standard deviation over mean of pressure/target.
    pub spread: f64,
}

impl Reached {
    pub fn new(problem: &Problem<'_>, drive: &Drive) -> Self {
        let moduli: Vec<_> = problem
            .transfer
            .pressure(&drive.excitation(&problem.aperture.driven))
            .iter()
            .map(|p| p.norm())
            .collect();
        let count = moduli.len() as f64;
        let relative: Vec<_> = moduli.iter().zip(&problem.foci).map(|(p, focus)| p / focus.target).collect();
        let mean = relative.iter().sum::<f64>() / count;
        let variance = relative.iter().map(|p| (p - mean).powi(2)).sum::<f64>() / count;
        Self {
            mean_pressure: moduli.iter().sum::<f64>() / count,
            weakest: relative.iter().copied().fold(f64::INFINITY, f64::min),
            spread: variance.sqrt() / mean.max(f64::MIN_POSITIVE),
        }
    }
}

/// The mean focal pressure after rounding to `levels` phases, 1 or more, relative to that before: sin(π/L)/(π/L).
pub fn expected_part(levels: u32) -> f64 {
    let x = TAU / 2.0 / f64::from(levels);
    x.sin() / x
}

/// The drive on `levels` phases with the strongest weakest focus, by coordinate changes from the rounded one.
///
/// # Panics
/// No levels, or a drive of other elements than the problem's.
pub fn refined(problem: &Problem<'_>, drive: &Drive, levels: u32) -> Drive {
    let transfer = &problem.transfer;
    let targets = problem.targets();
    let driven = &problem.aperture.driven;
    let mut chosen: Vec<_> = driven.iter().map(|&n| delay_level(drive.phases[n], levels)).collect();
    let turned = |element: usize, level: u32| {
        let amplitude = drive.amplitudes[driven[element]];
        Complex64::from_polar(amplitude, -TAU * f64::from(level) / f64::from(levels))
    };
    let u: Vec<_> = (0..driven.len()).map(|element| turned(element, chosen[element])).collect();
    let mut pressure = transfer.pressure(&u);
    let mut order: Vec<_> = (0..driven.len()).collect();
    order.sort_by(|&a, &b| starts::scatter(a).total_cmp(&starts::scatter(b)));
    let scale = Reached::new(problem, drive).mean_pressure.max(f64::MIN_POSITIVE);
    for _ in 0..PASSES {
        let before = chosen.clone();
        for &element in &order {
            let u = turned(element, chosen[element]);
            let cost = |level: u32| -> f64 {
                let change = turned(element, level) - u;
                let weakness = |m: usize| {
                    let p = (pressure[m] + transfer.at(m, element) * change).norm() / (targets[m] * scale);
                    p.max(1e-3).powi(-EMPHASIS)
                };
                (0..targets.len()).map(weakness).sum()
            };
            let now = chosen[element];
            let tried: Vec<_> = if levels <= ALL_TRIED {
                (0..levels).collect()
            } else {
                [levels - 2, levels - 1, 0, 1, 2].map(|step| (now + step) % levels).to_vec()
            };
            let best = tried.into_iter().min_by(|&a, &b| cost(a).total_cmp(&cost(b))).unwrap_or(now);
            if cost(best) < cost(now) {
                let change = turned(element, best) - u;
                for (m, p) in pressure.iter_mut().enumerate() {
                    *p += transfer.at(m, element) * change;
                }
                chosen[element] = best;
            }
        }
        if chosen == before {
            break;
        }
    }
    let mut refined = drive.clone();
    for (&n, level) in driven.iter().zip(chosen) {
        refined.phases[n] = -TAU * f64::from(level) / f64::from(levels);
    }
    let refined = refined.at_levels(levels);
    // A sum of powers only approximates the minimum: the result never falls below the rounded drive.
    let rounded = drive.at_levels(levels);
    if Reached::new(problem, &refined).weakest > Reached::new(problem, &rounded).weakest {
        refined
    } else {
        rounded
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::acoustics::Aperture;
    use crate::scene::{Focus, Scene};

    fn aperture() -> Aperture {
        let mut scene = Scene::default();
        (scene.array.rows, scene.array.columns) = (4, 4);
        Aperture::new(&scene)
    }

    fn problem(aperture: &Aperture) -> Problem<'_> {
        Problem::new(aperture, vec![Focus::new(DVec3::new(0.01, 0.005, 0.1), 1.0)])
    }

    /// A drive in phase at the focus, but for up to two and a half levels.
    fn nearly(problem: &Problem<'_>, levels: u32) -> Drive {
        let step = TAU / f64::from(levels);
        let off = |n: usize| step * (5.0 * starts::scatter(n) - 2.5);
        let row = problem.transfer.row(0).enumerate();
        let values: Vec<_> = row.map(|(n, h)| Complex64::cis(off(n) - h.arg())).collect();
        Drive::uniform(values.len(), &problem.aperture.driven, &values)
    }

    #[test]
    fn refining_leaves_silent_elements_alone() {
        let aperture = aperture();
        let problem = problem(&aperture);
        for levels in [8, 32] {
            let mut drive = nearly(&problem, levels);
            (drive.amplitudes[3], drive.phases[3]) = (0.0, 2.0);
            let (refined, rounded) = (refined(&problem, &drive, levels), drive.at_levels(levels));
            assert!(refined != rounded, "{levels} levels: nothing is refined");
            assert_eq!(refined.phases[3], rounded.phases[3], "{levels} levels");
        }
    }
}
