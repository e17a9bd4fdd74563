//! Quality figures of a drive, and an upper bound on all drives.
//!
//! The bound is a Lagrangian dual: any weights on foci and elements give a bound. Good weights come from the
//! weighted iteration with drives of rank eight: that relaxed problem has no poor local optima, and the bound is
//! the dual of its optimum.

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use crate::acoustics::Transfer;
use crate::solver::matrix::Matrix;
use crate::solver::problem::{Excitation, Problem};
use crate::solver::statistics::{evenness, mean, spread};
use crate::solver::{inverse, iteration, singular, warning::Warning};

/// Figures of a solution. Pressures in Pa (peak), of the played drive.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    pub mean_pressure: f64,
    pub min_pressure: f64,
    /// Standard deviation over mean of pressure/target.
    pub spread: f64,
    /// Least over mean of pressure/target: 1 if all are equal.
    pub evenness: f64,
    /// η = Σ|u|²/(N max|u|²) of the method's own excitation.
    pub efficiency: f64,
    /// Mean over foci of |p_m| √M / Σ_n |H_mn|: 1 for a single focus by time of flight.
    pub relative_to_single: f64,
    /// ‖H u - p‖/‖p‖ of the excitation; methods that leave the focal phases free are measured at their own phases and
    /// best scale.
    pub residual: f64,
}

/// Pa; smaller squares underflow in f64, and ratios become meaningless.
const FAINTEST: f64 = 1e-120;

impl Quality {
    /// The figures of an excitation, given the focal pressures of its played drive.
    pub fn new(problem: &Problem<'_>, excitation: &Excitation, pressures: &[Complex64]) -> Self {
        let targets = problem.targets();
        let moduli: Vec<_> = pressures.iter().map(|p| p.norm()).collect();
        let relative: Vec<_> =
            moduli.iter().zip(&targets).map(|(modulus, target)| modulus / target).collect();
        let single: Vec<_> = problem.transfer.rows().map(|row| row.map(|h| h.norm()).sum::<f64>()).collect();
        Self {
            mean_pressure: mean(moduli.iter().copied()),
            min_pressure: moduli.iter().copied().fold(f64::INFINITY, f64::min),
            spread: spread(&relative),
            evenness: evenness(&relative),
            efficiency: efficiency(&excitation.values),
            relative_to_single: moduli
                .iter()
                .zip(&single)
                .map(|(p, single)| p / single.max(f64::MIN_POSITIVE))
                .sum::<f64>()
                / (moduli.len() as f64).sqrt(),
            residual: excitation.residual.unwrap_or_else(|| modulus_residual(problem, excitation)),
        }
    }

    /// Whether the focal pressures are too small for comparisons.
    pub fn is_silent(&self) -> bool {
        self.mean_pressure < FAINTEST
    }
}

/// Limits set by foci and array, independent of the method. They take longer than most solutions and are computed on
/// demand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// The upper bound of [`bound`].
    pub bound: f64,
    /// Rank and condition of [`inverse::rank_and_condition`].
    pub rank: usize,
    pub condition: f64,
}

impl Limits {
    pub fn new(problem: &Problem<'_>) -> Self {
        let (rank, condition) = inverse::rank_and_condition(&problem.transfer);
        Self { bound: bound(problem), rank, condition }
    }

    /// The warning about these foci.
    pub fn warning(&self, problem: &Problem<'_>) -> Option<Warning> {
        let Transfer { points, elements, .. } = problem.transfer;
        // Neighbouring samples of a stroke are dependent by design.
        if problem.foci.iter().any(|focus| !focus.is_separate()) {
            return None;
        }
        // Every solution already warns of more foci than elements.
        let Self { rank, condition, .. } = *self;
        (points <= elements && rank < points).then_some(Warning::Dependent { foci: points, rank, condition })
    }
}

/// η = Σ|u|²/(N max|u|²).
pub fn efficiency(values: &[Complex64]) -> f64 {
    // An excitation may have any scale, so the largest goes before anything is squared.
    let largest = values.iter().map(|u| u.norm()).fold(0.0, f64::max);
    if largest == 0.0 {
        return 0.0;
    }
    values.iter().map(|u| (u.norm() / largest).powi(2)).sum::<f64>() / values.len() as f64
}

/// The relative deviation of the moduli of H u from a multiple of the targets.
fn modulus_residual(problem: &Problem<'_>, excitation: &Excitation) -> f64 {
    let targets = problem.targets();
    let moduli = problem.transfer.moduli(&excitation.values);
    let power = targets.iter().map(|target| target * target).sum::<f64>();
    let scale = moduli.iter().zip(&targets).map(|(modulus, target)| modulus * target).sum::<f64>() / power;
    let miss =
        moduli.iter().zip(&targets).map(|(modulus, target)| (modulus - scale * target).powi(2)).sum::<f64>();
    (miss / power).sqrt() / scale.max(f64::MIN_POSITIVE)
}

/// An upper bound on min_m |p_m|/A_m over all drives with |u_n| ≤ 1.
///
/// For weights w ≥ 0 and d > 0, min (|p_m|/A_m)² Σ w_m A_m² ≤ Σ w_m |p_m|² = u* H* W H u ≤ λmax(D^-½ H* W H D^-½) Σ d_n,
/// the last because Σ d_n |u_n|² ≤ Σ d_n. Every choice of w and d is valid; the multipliers of the relaxed problem are
/// taken. Each focus alone gives a bound, too.
pub fn bound(problem: &Problem<'_>) -> f64 {
    /// Channels of the relaxed drive. Twice as many gain less than 0.1 %.
    const CHANNELS: usize = 8;
    /// Iterations times foci: about 4 ms with 256 elements. Twenty times as many gain about 1 % of the bound.
    const WORK: usize = 2000;
    let iterations = (WORK / problem.foci.len()).clamp(40, 400) as u32;
    /// Rounding error of a sum of moduli.
    const ROUNDING: f64 = 1e-12;
    let (transfer, targets) = (&problem.transfer, problem.targets());
    // A single focus gets at most all elements in phase, and that is achievable.
    if let [target] = targets[..] {
        return transfer.row(0).map(Complex64::norm).sum::<f64>() / target * (1.0 + ROUNDING);
    }
    // The same bounds each of several foci; if the squares of their fields underflow, there is no better bound.
    let alone = |m: usize| transfer.row(m).map(Complex64::norm).sum::<f64>() / targets[m];
    let alone = (0..targets.len()).map(alone).fold(f64::INFINITY, f64::min) * (1.0 + ROUNDING);
    if alone < FAINTEST {
        return alone;
    }
    let (foci, heard) = iteration::multipliers::<CHANNELS>(transfer, &targets, iterations);
    let least = 1e-3 * mean(heard.iter().copied());
    let heard: Vec<_> = heard.iter().map(|h| h.max(least).max(f64::MIN_POSITIVE)).collect();
    alone.min(dual(problem, &foci, &heard))
}

/// The bound of given weights; infinite if its eigenvalue cannot be computed.
fn dual(problem: &Problem<'_>, w: &[f64], d: &[f64]) -> f64 {
    let (transfer, targets) = (&problem.transfer, problem.targets());
    let Some(largest) = largest_eigenvalue(transfer, w, d) else { return f64::INFINITY };
    let wanted = w.iter().zip(&targets).map(|(w, target)| w * target * target).sum::<f64>();
    (d.iter().sum::<f64>() * largest / wanted).sqrt()
}

/// Largest eigenvalue of D^-½ H* W H D^-½; `None` if it overflows in f64.
fn largest_eigenvalue(transfer: &Transfer, w: &[f64], d: &[f64]) -> Option<f64> {
    let largest = |matrix: Matrix| Some(singular::values(matrix)?.into_iter().fold(0.0, f64::max));
    if transfer.points > transfer.elements {
        let entry = |m: usize, n: usize| transfer.at(m, n) * (w[m] / d[n]).sqrt();
        let value = largest(Matrix::from_fn(transfer.points, transfer.elements, entry))?;
        return Some(value * value);
    }
    let inverse: Vec<_> = d.iter().map(|d| 1.0 / d).collect();
    let gram = transfer.gram(Some(&inverse));
    let entry = |i: usize, j: usize| gram.at(i * transfer.points + j) * (w[i] * w[j]).sqrt();
    // Of a positive semidefinite matrix the singular values are the eigenvalues.
    largest(Matrix::from_fn(transfer.points, transfer.points, entry))
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::acoustics::Aperture;
    use crate::scene::{Focus, Scene};

    #[test]
    fn no_drive_exceeds_the_largest_eigenvalue_and_one_reaches_it() {
        // More elements than foci, as many, and fewer.
        for (points, elements) in [(1, 5), (5, 40), (20, 20), (40, 7), (33, 1)] {
            let unit = |index: usize, step: f64| ((index + 1) as f64 * step).fract();
            let mut transfer = Transfer::zeros(points, elements);
            for index in 0..points * elements {
                let value = Complex64::new(unit(index, 0.618_033_988), unit(index, 0.754_877_666) - 0.5);
                transfer.set(index / elements, index % elements, value);
            }
            let w: Vec<_> = (0..points).map(|m| 0.1 + unit(m, 0.41)).collect();
            let d: Vec<_> = (0..elements).map(|n| 0.1 + unit(n, 0.37)).collect();
            let largest = largest_eigenvalue(&transfer, &w, &d).unwrap();
            let mut u: Vec<_> = (0..elements).map(|n| Complex64::cis(9.0 * unit(n, 0.57))).collect();
            let mut quotient = 0.0;
            for _ in 0..300 {
                let weighted: Vec<_> = transfer.pressure(&u).iter().zip(&w).map(|(p, w)| p * w).collect();
                let next: Vec<_> = transfer.back(&weighted).iter().zip(&d).map(|(u, d)| u / d).collect();
                let of = |a: &[Complex64]| -> f64 {
                    u.iter().zip(a).zip(&d).map(|((u, a), d)| (u.conj() * a).re * d).sum()
                };
                quotient = of(&next) / of(&u);
                assert!(
                    quotient <= largest * (1.0 + 1e-12),
                    "{points} x {elements}: {quotient} of {largest}"
                );
                let norm = next.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt();
                u = next.iter().map(|value| value / norm).collect();
            }
            assert!(quotient > largest * (1.0 - 1e-9), "{points} x {elements}: {quotient} of {largest}");
        }
    }

    fn two_elements() -> Aperture {
        let mut scene = Scene::default();
        (scene.array.rows, scene.array.columns) = (1, 2);
        Aperture::new(&scene)
    }

    /// Two foci that hear two elements in phase and in antiphase.
    fn shared(aperture: &Aperture, targets: [f64; 2]) -> Problem<'_> {
        let foci = targets.map(|target| Focus::new(DVec3::Z * 0.1, target)).to_vec();
        let mut problem = Problem::new(aperture, foci);
        for (m, n, value) in [(0, 0, 3.0), (0, 1, 3.0), (1, 0, 3.0), (1, 1, -3.0)] {
            problem.transfer.set(m, n, Complex64::from(value));
        }
        problem
    }

    #[test]
    fn the_bound_of_two_foci_that_share_two_elements_is_reached_at_a_quarter_turn() {
        let aperture = two_elements();
        for target in [0.5, 1.0, 40.0] {
            let problem = shared(&aperture, [target; 2]);
            // In phase one focus gets all and the other nothing: each alone would get 6.
            let reached = problem.transfer.pressure(&[Complex64::ONE, Complex64::I])[1].norm() / target;
            let part = reached / bound(&problem);
            assert!(part > 0.99 && part < 1.0 + 1e-9, "{target}: {reached} is {part} of the bound");
        }
    }

    #[test]
    fn a_drive_that_is_heard_is_not_silent_however_faint() {
        let aperture = two_elements();
        let problem = Problem::new(&aperture, vec![Focus::new(DVec3::Z * 0.1, 1.0)]);
        let values = vec![Complex64::ONE; 2];
        let excitation = Excitation { values, iterations: 0, residual: None, weights: None };
        for (pressure, expected) in [(1e3, false), (1e-30, false), (1e-150, true), (0.0, true)] {
            let quality = Quality::new(&problem, &excitation, &[Complex64::from(pressure)]);
            assert_eq!(quality.is_silent(), expected, "{pressure:e} Pa");
        }
    }
}
