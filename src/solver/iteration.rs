//! Methods that leave the focal phases free and iterate on them: conjugate superposition, Gerchberg-Saxton and its
//! kin, greedy search, and the combination that is best on measured sets.

use std::f64::consts::TAU;

use faer::linalg::solvers::{Llt, Solve};
use faer::{Mat, Side};
use num_complex::Complex64;

use crate::acoustics::{Phasors, Sums, Transfer};
use crate::solver::{Excitation, Problem, starts};

/// Phases that the greedy search tries for every element.
const GREEDY_LEVELS: usize = 16;
/// Iterations on the Gram matrix, and of the last levelling, in `best`.
const CLIMB: usize = 50;
const POLISH: usize = 10;
/// Spread of the focal pressures below which levelling stops.
const LEVEL: f64 = 1e-6;

/// Conjugate superposition, u = H* A.
pub fn naive(problem: &Problem<'_>) -> Excitation {
    let pressure: Vec<_> = problem.targets().into_iter().map(Complex64::from).collect();
    Excitation { values: problem.transfer.back(&pressure), iterations: 0, residual: None }
}

/// Gerchberg-Saxton (iterative back-propagation): u ← ph(H* (A ph(H u))).
pub fn gs(problem: &Problem<'_>, iterations: u32) -> Excitation {
    let targets = problem.targets();
    let mut state =
        State::from_foci(&problem.transfer, targets.iter().copied().map(Complex64::from).collect());
    for _ in 0..iterations {
        for (m, target) in targets.iter().enumerate() {
            state.pressure.set(m, phase(state.pressure.at(m)) * target);
        }
        state.step(0.0);
    }
    Excitation { values: state.excitation(), iterations, residual: None }
}

/// GS-PAT (Plasencia et al., ACM TOG 39(4), 2020): the iteration on the M x M matrix of foci alone.
pub fn gspat(problem: &Problem<'_>, iterations: u32) -> Excitation {
    let (transfer, targets) = (&problem.transfer, problem.targets());
    let gram = transfer.gram(None);
    let count = targets.len();
    let power: Vec<_> = (0..count).map(|m| gram.re[m * count + m]).collect();
    let heard = |p: &[Complex64]| -> Vec<Complex64> {
        let row = |m: usize| (0..count).map(|i| gram.at(m * count + i) * p[i] / power[i]).sum();
        (0..count).map(row).collect()
    };
    let mut p: Vec<_> = targets.iter().copied().map(Complex64::from).collect();
    for _ in 0..iterations {
        p = heard(&p).iter().zip(&targets).map(|(p, target)| phase(*p) * target).collect();
    }
    let gamma = heard(&p);
    let correct = |m: usize| {
        gamma[m] * (targets[m] * targets[m] / gamma[m].norm_sqr().max(f64::MIN_POSITIVE) / power[m])
    };
    let corrected: Vec<_> = (0..count).map(correct).collect();
    Excitation { values: transfer.back(&corrected), iterations, residual: None }
}

/// Weighted Gerchberg-Saxton (Di Leonardo et al., Opt. Express 15:1913, 2007), damped.
pub fn wgs(problem: &Problem<'_>, iterations: u32) -> Excitation {
    Excitation { values: weighted(problem, iterations).0, iterations, residual: None }
}

/// The same: the excitation, and the pressure at the foci.
fn weighted(problem: &Problem<'_>, iterations: u32) -> (Vec<Complex64>, Vec<Complex64>) {
    let targets = problem.targets();
    let mut state =
        State::from_foci(&problem.transfer, targets.iter().copied().map(Complex64::from).collect());
    state.weigh(&targets, iterations);
    (state.excitation(), state.pressure.to_vec(targets.len()))
}

/// Every element in turn takes the one of 16 phases that brings the foci nearest to their targets (Suzuki 2021).
pub fn greedy(problem: &Problem<'_>, sweeps: u32) -> Excitation {
    let (transfer, targets) = (&problem.transfer, problem.targets());
    let elements = transfer.elements;
    let level = {
        let (_, pressure) = weighted(problem, 20);
        pressure.iter().zip(&targets).map(|(p, target)| p.norm() / target).sum::<f64>() / targets.len() as f64
    };
    let choices: Vec<_> = (0..GREEDY_LEVELS)
        .map(|i| Complex64::from_polar(1.0, TAU * i as f64 / GREEDY_LEVELS as f64))
        .collect();
    let mut order: Vec<_> = (0..elements).collect();
    order.sort_by(|&a, &b| starts::scatter(a).total_cmp(&starts::scatter(b)));
    let mut u = vec![Complex64::ZERO; elements];
    let mut pressure = vec![Complex64::ZERO; targets.len()];
    for _ in 0..sweeps {
        for &n in &order {
            let without: Vec<_> =
                (0..targets.len()).map(|m| pressure[m] - transfer.at(m, n) * u[n]).collect();
            let error = |choice: &Complex64| -> f64 {
                let miss = |m: usize| {
                    ((without[m] + transfer.at(m, n) * choice).norm() / targets[m] - level).powi(2)
                };
                (0..targets.len()).map(miss).sum()
            };
            let best = choices.iter().min_by(|a, b| error(a).total_cmp(&error(b)));
            u[n] = best.copied().unwrap_or(Complex64::ONE);
            for (m, p) in pressure.iter_mut().enumerate() {
                *p = without[m] + transfer.at(m, n) * u[n];
            }
        }
    }
    Excitation { values: u, iterations: sweeps, residual: None }
}

/// Focal phases from the strongest of several starts on the Gram matrix, then damped weighted iteration, then
/// alternating projections; the weakest focus decides what is kept.
pub fn best(problem: &Problem<'_>, iterations: u32) -> Excitation {
    let (transfer, targets) = (&problem.transfer, problem.targets());
    let gram = transfer.gram(None);
    let state = State::from_foci(transfer, starts::strongest(&gram, &targets, CLIMB));
    level(state, &gram, &targets, iterations)
}

/// `best` for a problem near one that `excitation` (a value per driven element) solves: no start is searched for, and
/// the phases move as little as they must.
pub fn best_from(problem: &Problem<'_>, excitation: &[Complex64], iterations: u32) -> Excitation {
    let (transfer, targets) = (&problem.transfer, problem.targets());
    let gram = transfer.gram(None);
    let state = State::from_foci(transfer, transfer.pressure(excitation).into_iter().collect());
    level(state, &gram, &targets, iterations)
}

fn level(mut state: State<'_>, gram: &Phasors, targets: &[f64], iterations: u32) -> Excitation {
    state.weigh(targets, iterations);
    let weighted = (state.weakest(targets), state.excitation());
    let polished = state.polish(gram, targets);
    let values =
        if polished && state.weakest(targets) > weighted.0 { state.excitation() } else { weighted.1 };
    Excitation { values, iterations, residual: None }
}

/// A uniform drive on its way, and what it makes at the foci.
struct State<'a> {
    transfer: &'a Transfer,
    u: Phasors,
    /// H u after a step; what the next step sends back before it.
    pressure: Phasors,
    sums: Sums,
}

impl<'a> State<'a> {
    /// u = ph(H* p).
    fn from_foci(transfer: &'a Transfer, pressure: Phasors) -> Self {
        let mut state = Self { transfer, u: transfer.excitation(), pressure, sums: Sums::default() };
        state.step(0.0);
        state
    }

    /// u ← ph(keep · u + H* p), p ← H u.
    fn step(&mut self, keep: f64) {
        self.transfer.drive_by(keep, &mut self.u, &mut self.pressure, &mut self.sums);
    }

    fn excitation(&self) -> Vec<Complex64> {
        self.u.to_vec(self.transfer.elements)
    }

    /// The smallest pressure over its target.
    fn weakest(&self, targets: &[f64]) -> f64 {
        self.relative(targets).fold(f64::INFINITY, f64::min)
    }

    fn relative(&self, targets: &[f64]) -> impl Iterator<Item = f64> {
        self.pressure.iter().zip(targets).map(|(p, target)| p.norm_sqr().sqrt() / target)
    }

    /// Standard deviation over mean of the pressures over their targets.
    fn spread(&self, targets: &[f64]) -> f64 {
        let count = targets.len() as f64;
        let (sum, squares) =
            self.relative(targets).fold((0.0, 0.0), |(sum, squares), p| (sum + p, squares + p * p));
        let mean = sum / count;
        (squares / count - mean * mean).max(0.0).sqrt() / mean.max(f64::MIN_POSITIVE)
    }

    /// Damped weighted Gerchberg-Saxton: what is too weak gets more weight. Gives the weights of the foci.
    ///
    /// The correction is the root of the ratio: undamped, two foci swap for ever.
    fn weigh(&mut self, targets: &[f64], iterations: u32) -> Vec<f64> {
        let count = targets.len() as f64;
        let mut weights = targets.to_vec();
        for _ in 0..iterations {
            let mean = self.relative(targets).sum::<f64>() / count;
            for (weight, relative) in weights.iter_mut().zip(self.relative(targets)) {
                *weight *= (mean / relative.max(1e-3 * mean)).sqrt();
            }
            let scale = count / weights.iter().sum::<f64>();
            for (m, weight) in weights.iter_mut().enumerate() {
                *weight *= scale;
                self.pressure.set(m, phase(self.pressure.at(m)) * *weight);
            }
            self.step(0.0);
        }
        weights
    }

    /// Alternating projections between "every element plays fully" and "the foci are as wanted", with one Cholesky factor
    /// of the Gram matrix. `false` where the foci are too dependent for the second.
    fn polish(&mut self, gram: &Phasors, targets: &[f64]) -> bool {
        const DAMPING: f64 = 1e-9;
        let count = targets.len();
        let trace = (0..count).map(|m| gram.re[m * count + m]).sum::<f64>();
        let damped = Mat::from_fn(count, count, |i, j| {
            gram.at(i * count + j) + if i == j { DAMPING * trace / count as f64 } else { 0.0 }
        });
        let Ok(factor): Result<Llt<Complex64>, _> = damped.llt(Side::Lower) else { return false };
        let power = targets.iter().map(|target| target * target).sum::<f64>();
        let mut miss = Mat::zeros(count, 1);
        for _ in 0..POLISH {
            if self.spread(targets) < LEVEL {
                break;
            }
            // The multiple of the targets, at the phases that the foci have, that is nearest.
            let scale =
                self.pressure.iter().zip(targets).map(|(p, target)| p.norm() * target).sum::<f64>() / power;
            for (m, target) in targets.iter().enumerate() {
                let p = self.pressure.at(m);
                miss[(m, 0)] = phase(p) * (target * scale) - p;
            }
            factor.solve_in_place(miss.as_mut());
            for m in 0..count {
                self.pressure.set(m, miss[(m, 0)]);
            }
            self.step(1.0);
        }
        self.pressure.iter().all(|p| p.is_finite())
    }
}

/// The uniform excitation to which the damped weighted iteration leads from `pressure` at the foci, what it makes there,
/// and the weights of the foci.
pub fn weighted_from(
    transfer: &Transfer,
    targets: &[f64],
    pressure: &[Complex64],
    iterations: u32,
) -> (Vec<Complex64>, Vec<f64>) {
    let mut state = State::from_foci(transfer, pressure.iter().copied().collect());
    let weights = state.weigh(targets, iterations);
    (state.pressure.to_vec(targets.len()), weights)
}

/// The same phase with modulus 1; phase 0 where there is none.
fn phase(value: Complex64) -> Complex64 {
    let norm = value.norm_sqr().sqrt();
    if norm > 0.0 { value / norm } else { Complex64::ONE }
}
