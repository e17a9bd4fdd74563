//! Methods that prescribe the complex focal field: the pseudo-inverse and its weighted iteration.

use num_complex::Complex64;

use crate::acoustics::Transfer;
use crate::gauge;
use crate::solver::matrix::Matrix;
use crate::solver::problem::{Excitation, Problem};
use crate::solver::{singular, statistics};

/// Singular values below this fraction of the largest are noise: their directions are not inverted.
const RANK_TOLERANCE: f64 = 1e-6;
/// A focus with less than this fraction of the loudest focus' field is ignored: at a drive loud enough for it,
/// rounding errors at the other focus would exceed its pressure.
const FAINTEST: f64 = f64::EPSILON;
/// Floor of |u| relative to its mean in the weight update: otherwise an element passing through zero would diverge.
const WEIGHT_FLOOR: f64 = 1e-3;
/// The largest weight over the mean one, for the same reason over many iterations.
const MOST_WEIGHT: f64 = 1e4;

/// u = H* (H H*)^{-1} p: equation (13) of Long et al. 2022, all focal phases 0.
pub fn pinv(problem: &Problem<'_>) -> Excitation {
    let weights = vec![1.0; problem.transfer.elements];
    let (values, residual) = weighted_inverse(problem, &weights);
    Excitation { values, iterations: 0, residual: Some(residual), weights: None }
}

/// Table I of Long et al. 2022 read with cumulative weights: W ← W · diag(1/|u|), u = W H* (H W H*)^{-1} p.
pub fn weighted(problem: &Problem<'_>, iterations: u32) -> Excitation {
    let mut weights = vec![1.0; problem.transfer.elements];
    let (mut values, mut residual) = weighted_inverse(problem, &weights);
    for _ in gauge::iterations(iterations) {
        let mean = statistics::mean(values.iter().map(|u| u.norm()));
        if mean == 0.0 {
            // The field is zero at all foci: weights are undefined.
            break;
        }
        for (weight, u) in weights.iter_mut().zip(&values) {
            *weight *= mean / u.norm().max(WEIGHT_FLOOR * mean);
        }
        let mean = statistics::mean(weights.iter().copied());
        for weight in &mut weights {
            *weight = (*weight / mean).clamp(1.0 / MOST_WEIGHT, MOST_WEIGHT);
        }
        (values, residual) = weighted_inverse(problem, &weights);
    }
    Excitation { values, iterations, residual: Some(residual), weights: None }
}

/// W H* (H W H*)⁺ p to some scale, and its relative residual, by the singular values of H √W, without squaring.
fn weighted_inverse(problem: &Problem<'_>, weights: &[f64]) -> (Vec<Complex64>, f64) {
    let transfer = &problem.transfer;
    let targets = problem.targets();
    let roots: Vec<_> = weights.iter().map(|weight| weight.sqrt()).collect();
    let (matrix, norms) = normalised(transfer, &roots);
    // Multiplied by the smallest norm: a drive at any scale is the same, and at this one its squares are numbers.
    let smallest = norms.iter().copied().fold(f64::INFINITY, f64::min);
    let scale = if smallest.is_finite() { smallest } else { 1.0 };
    let scaled: Vec<_> =
        targets.iter().zip(&norms).map(|(target, norm)| Complex64::from(target * (scale / norm))).collect();
    // The decomposition of finite numbers fails only if cancelled; the latter is a valid drive in any case.
    let values: Vec<_> = match singular::solve(matrix, scaled.clone(), RANK_TOLERANCE) {
        Some(values) => values.iter().zip(&roots).map(|(u, root)| u * root).collect(),
        None => transfer.back(&scaled),
    };
    let error = transfer
        .pressure(&values)
        .iter()
        .zip(&targets)
        .map(|(p, target)| (p / scale - target).norm_sqr())
        .sum::<f64>();
    let norm = targets.iter().map(|target| target * target).sum::<f64>();
    (values, (error / norm).sqrt())
}

/// The transfer with its columns scaled and its rows brought to norm 1, and the norms; ignored foci have zero rows
/// and an infinite norm.
///
/// Distant and near foci then have equal weight in the threshold of singular values.
fn normalised(transfer: &Transfer, columns: &[f64]) -> (Matrix, Vec<f64>) {
    let scaled = |m: usize, n: usize| transfer.at(m, n) * columns[n];
    let moduli = |m: usize| (0..transfer.elements).map(|n| scaled(m, n).norm()).collect::<Vec<_>>();
    let norms: Vec<_> = (0..transfer.points).map(|m| norm(&moduli(m))).collect();
    let faintest = FAINTEST * norms.iter().copied().fold(0.0, f64::max);
    let norms: Vec<_> =
        norms.into_iter().map(|norm| if norm > faintest { norm } else { f64::INFINITY }).collect();
    let entry = |m: usize, n: usize| {
        if norms[m].is_finite() { scaled(m, n) / norms[m] } else { Complex64::ZERO }
    };
    (Matrix::from_fn(transfer.points, transfer.elements, entry), norms)
}

/// The root of the sum of squares, with the largest factored out: far from the array the squares underflow in f64.
fn norm(moduli: &[f64]) -> f64 {
    let largest = moduli.iter().copied().fold(0.0, f64::max);
    if largest == 0.0 {
        return 0.0;
    }
    largest * moduli.iter().map(|h| (h / largest).powi(2)).sum::<f64>().sqrt()
}

/// Numerical rank, and the ratio of the largest singular value to the smallest, of H with rows of norm 1.
///
/// The condition number is limited to 1/ε, the resolution of f64.
pub fn rank_and_condition(transfer: &Transfer) -> (usize, f64) {
    let (matrix, _) = normalised(transfer, &vec![1.0; transfer.elements]);
    let values = singular::values(matrix).unwrap_or_default();
    let largest = values.iter().copied().fold(0.0, f64::max);
    if largest == 0.0 {
        // The field of all elements is zero at all foci, or has no room in f64.
        return (0, 1.0 / f64::EPSILON);
    }
    let smallest = values.iter().copied().fold(f64::INFINITY, f64::min);
    let rank = values.iter().filter(|&&value| value > RANK_TOLERANCE * largest).count();
    // More foci than elements: some combination of foci cannot be set at all.
    let smallest = if transfer.points > transfer.elements { 0.0 } else { smallest };
    (rank, largest / smallest.max(largest * f64::EPSILON))
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::acoustics::Aperture;
    use crate::scene::{Focus, Scene};

    #[test]
    fn a_direction_counts_from_a_millionth_of_the_strongest() {
        for (ratio, expected) in [(0.8e-6f64, 1), (1.25e-6, 2), (0.1, 2)] {
            // Rows of norm 1 at this angle have singular values √2 cos ½ angle and √2 sin ½ angle.
            let (sin, cos) = (2.0 * ratio.atan()).sin_cos();
            let mut transfer = Transfer::zeros(2, 2);
            for (m, n, value) in [(0, 0, 1.0), (1, 0, cos), (1, 1, sin)] {
                transfer.set(m, n, Complex64::from(value));
            }
            let (rank, condition) = rank_and_condition(&transfer);
            assert_eq!(rank, expected, "{ratio:e}");
            assert!((condition * ratio - 1.0).abs() < 1e-6, "{ratio:e}: {condition:e}");
        }
    }

    #[test]
    fn where_no_sound_arrives_drives_are_finite_all_the_same() {
        let mut scene = Scene::default();
        (scene.array.rows, scene.array.columns) = (2, 2);
        let aperture = Aperture::new(&scene);
        let focus = |x: f64| Focus::new(DVec3::new(x, 0.0, 0.1), 1.0);
        let mut problem = Problem::new(&aperture, [-0.03, 0.0, 0.04].map(focus).to_vec());
        problem.transfer = Transfer::zeros(3, 4);
        for found in [pinv(&problem), weighted(&problem, 3)] {
            assert!(found.values.iter().all(|u| u.is_finite()), "{found:?}");
        }
        assert_eq!(rank_and_condition(&problem.transfer).0, 0);
    }
}
