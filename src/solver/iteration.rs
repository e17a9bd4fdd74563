//! Methods that leave the focal phases free and iterate on them: conjugate superposition, Gerchberg-Saxton and its
//! kin, greedy search, and the combination that is best on measured sets.

use std::f64::consts::TAU;

use faer::linalg::solvers::{Llt, Solve};
use faer::{Mat, Side};
use num_complex::Complex64;

use crate::acoustics::Transfer;
use crate::solver::{Excitation, Problem};

/// Exponent of the weight's correction in the weighted Gerchberg-Saxton iteration: at 1, two foci swap for ever.
const DAMPING: f64 = 0.5;
/// Phases that the greedy search tries for every element.
const GREEDY_LEVELS: usize = 16;
/// Steps of the golden section are never near a fraction: 1/φ.
const GOLDEN: f64 = 0.618_033_988_749_894_8;

/// Conjugate superposition, u = H* A.
pub fn naive(problem: &Problem) -> Excitation {
    let pressure: Vec<_> = problem.targets().into_iter().map(Complex64::from).collect();
    Excitation { values: problem.transfer.back(&pressure), iterations: 0, residual: None }
}

/// Gerchberg-Saxton (iterative back-propagation): u ← ph(H* (A ph(H u))).
pub fn gs(problem: &Problem, iterations: u32) -> Excitation {
    let targets = problem.targets();
    let mut u = phases(&naive(problem).values);
    for _ in 0..iterations {
        let pressure = with_modulus(&problem.transfer.pressure(&u), &targets);
        u = phases(&problem.transfer.back(&pressure));
    }
    Excitation { values: u, iterations, residual: None }
}

/// GS-PAT (Plasencia et al., ACM TOG 39(4), 2020): the iteration on the M x M matrix of foci alone.
pub fn gspat(problem: &Problem, iterations: u32) -> Excitation {
    let (transfer, targets) = (&problem.transfer, problem.targets());
    let power: Vec<_> = transfer.rows().map(|row| row.iter().map(|h| h.norm_sqr()).sum::<f64>()).collect();
    let gram = gram(transfer);
    let heard = |p: &[Complex64]| -> Vec<Complex64> {
        let scaled: Vec<_> = p.iter().zip(&power).map(|(p, power)| p / power).collect();
        multiply(&gram, &scaled)
    };
    let mut p: Vec<_> = targets.iter().copied().map(Complex64::from).collect();
    for _ in 0..iterations {
        p = with_modulus(&heard(&p), &targets);
    }
    let gamma = heard(&p);
    let correct = |m: usize| {
        gamma[m] * (targets[m] * targets[m] / gamma[m].norm_sqr().max(f64::MIN_POSITIVE) / power[m])
    };
    let corrected: Vec<_> = (0..targets.len()).map(correct).collect();
    Excitation { values: transfer.back(&corrected), iterations, residual: None }
}

/// Weighted Gerchberg-Saxton (Di Leonardo et al., Opt. Express 15:1913, 2007), damped.
pub fn wgs(problem: &Problem, iterations: u32) -> Excitation {
    let u = phases(&naive(problem).values);
    let (values, _) = weighted_phases(&problem.transfer, &problem.targets(), u, iterations);
    Excitation { values, iterations, residual: None }
}

/// Every element in turn takes the one of 16 phases that brings the foci nearest to their targets (Suzuki 2021).
pub fn greedy(problem: &Problem, sweeps: u32) -> Excitation {
    let (transfer, targets) = (&problem.transfer, problem.targets());
    let elements = transfer.elements;
    let level = {
        let pressure = transfer.pressure(&wgs(problem, 20).values);
        pressure.iter().zip(&targets).map(|(p, target)| p.norm() / target).sum::<f64>() / targets.len() as f64
    };
    let choices: Vec<_> = (0..GREEDY_LEVELS)
        .map(|i| Complex64::from_polar(1.0, TAU * i as f64 / GREEDY_LEVELS as f64))
        .collect();
    let mut order: Vec<_> = (0..elements).collect();
    order.sort_by(|&a, &b| scatter(a).total_cmp(&scatter(b)));
    let mut u = vec![Complex64::ZERO; elements];
    let mut pressure = vec![Complex64::ZERO; targets.len()];
    for _ in 0..sweeps {
        for &n in &order {
            let without: Vec<_> =
                (0..targets.len()).map(|m| pressure[m] - transfer.row(m)[n] * u[n]).collect();
            let error = |choice: &Complex64| -> f64 {
                let miss = |m: usize| {
                    ((without[m] + transfer.row(m)[n] * choice).norm() / targets[m] - level).powi(2)
                };
                (0..targets.len()).map(miss).sum()
            };
            let best = choices.iter().min_by(|a, b| error(a).total_cmp(&error(b)));
            u[n] = best.copied().unwrap_or(Complex64::ONE);
            for (m, p) in pressure.iter_mut().enumerate() {
                *p = without[m] + transfer.row(m)[n] * u[n];
            }
        }
    }
    Excitation { values: u, iterations: sweeps, residual: None }
}

/// Focal phases from the strongest of several starts on the Gram matrix, then damped weighted iteration, then
/// alternating projections; the weakest focus decides what is kept.
pub fn best(problem: &Problem, iterations: u32) -> Excitation {
    let (transfer, targets) = (&problem.transfer, problem.targets());
    let gram = gram(transfer);
    let u = phases(&transfer.back(&strongest_phases(&gram, &targets)));
    let (weighted, _) = weighted_phases(transfer, &targets, u, iterations);
    let polished = polish(transfer, &gram, &targets, &weighted, 10);
    let weakest = |u: &[Complex64]| {
        let pressure = transfer.pressure(u);
        pressure.iter().zip(&targets).map(|(p, target)| p.norm() / target).fold(f64::INFINITY, f64::min)
    };
    let values = match polished {
        Some(polished) if weakest(&polished) > weakest(&weighted) => polished,
        _ => weighted,
    };
    Excitation { values, iterations, residual: None }
}

/// Gerchberg-Saxton on R = H H*: p ← A ph(R p) climbs to a maximum of the power p* R p that the foci can share.
///
/// Equal phases are a fixed point of every symmetric set, and a poor one, so the starts are scattered.
fn strongest_phases(gram: &Mat<Complex64>, targets: &[f64]) -> Vec<Complex64> {
    const STARTS: usize = 8;
    const ITERATIONS: usize = 50;
    let climb = |start: usize| {
        let scattered = |m: usize| Complex64::from_polar(targets[m], TAU * start as f64 * scatter(m + start));
        let mut p: Vec<_> = (0..targets.len()).map(scattered).collect();
        for _ in 0..ITERATIONS {
            p = with_modulus(&multiply(gram, &p), targets);
        }
        let power = multiply(gram, &p).iter().zip(&p).map(|(heard, p)| (p.conj() * heard).re).sum::<f64>();
        (power, p)
    };
    (0..STARTS).map(climb).max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, p)| p).unwrap_or_default()
}

/// Damped weighted Gerchberg-Saxton from `u`: the uniform excitation and the weights of the foci that led to it.
pub fn weighted_phases(
    transfer: &Transfer,
    targets: &[f64],
    mut u: Vec<Complex64>,
    iterations: u32,
) -> (Vec<Complex64>, Vec<f64>) {
    let mut weights = targets.to_vec();
    for _ in 0..iterations {
        let pressure = transfer.pressure(&u);
        let relative: Vec<_> = pressure.iter().zip(targets).map(|(p, target)| p.norm() / target).collect();
        let mean = relative.iter().sum::<f64>() / relative.len() as f64;
        for (weight, relative) in weights.iter_mut().zip(&relative) {
            *weight *= (mean / relative.max(1e-3 * mean)).powf(DAMPING);
        }
        let total = weights.iter().sum::<f64>() / weights.len() as f64;
        for weight in &mut weights {
            *weight /= total;
        }
        u = phases(&transfer.back(&with_modulus(&pressure, &weights)));
    }
    (u, weights)
}

/// Alternating projections between "every element plays fully" and "the foci are as wanted" (one Cholesky factor).
/// `None` where the foci are too dependent for the second.
fn polish(
    transfer: &Transfer,
    gram: &Mat<Complex64>,
    targets: &[f64],
    u: &[Complex64],
    iterations: u32,
) -> Option<Vec<Complex64>> {
    const DAMPING: f64 = 1e-9;
    let count = targets.len();
    let trace = (0..count).map(|m| gram[(m, m)].re).sum::<f64>();
    let damped = Mat::from_fn(count, count, |i, j| {
        gram[(i, j)] + if i == j { DAMPING * trace / count as f64 } else { 0.0 }
    });
    let factor: Llt<Complex64> = damped.llt(Side::Lower).ok()?;
    let mut u = u.to_vec();
    for _ in 0..iterations {
        let v = phases(&u);
        let heard = transfer.pressure(&v);
        let p = with_modulus(&heard, targets);
        let scale = heard.iter().zip(&p).map(|(y, p)| (p.conj() * y).re).sum::<f64>()
            / p.iter().map(|p| p.norm_sqr()).sum::<f64>();
        let miss = Mat::from_fn(count, 1, |m, _| p[m] * scale - heard[m]);
        let solved = factor.solve(&miss);
        let correction: Vec<_> = (0..count).map(|m| solved[(m, 0)]).collect();
        u = v.iter().zip(transfer.back(&correction)).map(|(v, correction)| v + correction).collect();
    }
    let u = phases(&u);
    u.iter().all(|u| u.is_finite()).then_some(u)
}

/// R = H H*.
fn gram(transfer: &Transfer) -> Mat<Complex64> {
    let dot =
        |i: usize, j: usize| transfer.row(i).iter().zip(transfer.row(j)).map(|(a, b)| a * b.conj()).sum();
    Mat::from_fn(transfer.points, transfer.points, dot)
}

fn multiply(matrix: &Mat<Complex64>, vector: &[Complex64]) -> Vec<Complex64> {
    let mut product = vec![Complex64::ZERO; matrix.nrows()];
    for (j, value) in vector.iter().enumerate() {
        for (i, sum) in product.iter_mut().enumerate() {
            *sum += matrix[(i, j)] * value;
        }
    }
    product
}

/// The same phases with modulus 1; phase 0 where there is none.
pub fn phases(values: &[Complex64]) -> Vec<Complex64> {
    values.iter().map(|value| phase(*value)).collect()
}

/// The same phases with the given moduli.
fn with_modulus(values: &[Complex64], moduli: &[f64]) -> Vec<Complex64> {
    values.iter().zip(moduli).map(|(value, modulus)| phase(*value) * modulus).collect()
}

fn phase(value: Complex64) -> Complex64 {
    let norm = value.norm();
    if norm > 0.0 { value / norm } else { Complex64::ONE }
}

/// A number in [0, 1) that is far from that of every near index.
fn scatter(index: usize) -> f64 {
    (index as f64 * GOLDEN).fract()
}
