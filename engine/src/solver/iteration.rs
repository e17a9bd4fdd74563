//! Methods with free focal phases: phase conjugation, Gerchberg-Saxton and its variants, greedy search, and the
//! levelling of `best`.
//!
//! A levelling step is the smallest change of element phases that equalises the moduli, from the real M x M matrix
//! J Jᵀ of `acoustics::jacobian`. Only moduli are prescribed, so foci closer than the array's resolution stay level
//! and strong; prescribing the complex field there, as alternating projections with R do, costs much of their
//! pressure. A step of the weighted iteration or of levelling is one pass over H, `Transfer::drive_by`: back to the
//! elements, normalised, and forward to the foci, block by block in cache.

use std::f64::consts::TAU;
use web_time::{Duration, Instant};

use num_complex::Complex64;

use crate::acoustics::{PhaseJacobian, Phasors, Sums, Transfer};
use crate::gauge::{self, Gauge};
use crate::solver::cholesky::Factor;
use crate::solver::problem::{Excitation, Problem};
use crate::solver::{starts, statistics};

/// Phases that the greedy search tries for every element.
const GREEDY_LEVELS: usize = 16;
/// Iterations on the Gram matrix, and the limit of final levelling steps, in `best`. Well separated foci need one or
/// two.
pub const CLIMB: usize = 50;
const LEVELLINGS: usize = 5;
/// Relative standard deviation of the focal pressures at which levelling stops.
const LEVEL: f64 = 3e-4;

/// Phase conjugation, u = H* A.
pub fn naive(problem: &Problem<'_>) -> Excitation {
    let pressure: Vec<_> = problem.targets().into_iter().map(Complex64::from).collect();
    Excitation { values: problem.transfer.back(&pressure), iterations: 0, residual: None, weights: None }
}

/// Gerchberg-Saxton (iterative back-propagation): u ← ph(H* (A ph(H u))).
pub fn gs(problem: &Problem<'_>, iterations: u32) -> Excitation {
    let targets = problem.targets();
    let mut state =
        State::from_foci(&problem.transfer, targets.iter().copied().map(Complex64::from).collect());
    for _ in gauge::iterations(iterations) {
        for (m, target) in targets.iter().enumerate() {
            state.scale(m, *target);
        }
        state.step(0.0);
    }
    Excitation { values: state.excitation(), iterations, residual: None, weights: None }
}

/// GS-PAT (Plasencia et al., ACM TOG 39(4), 2020): the iteration on the M x M matrix of foci alone.
pub fn gspat(problem: &Problem<'_>, iterations: u32) -> Excitation {
    let (transfer, targets) = (&problem.transfer, problem.targets());
    let gram = transfer.gram(None);
    let count = targets.len();
    // Also for a focus where the field of all elements is zero.
    let power: Vec<_> = (0..count).map(|m| gram.re[m * count + m].max(f64::MIN_POSITIVE)).collect();
    let heard = |p: &[Complex64]| -> Vec<Complex64> {
        let row = |m: usize| (0..count).map(|i| gram.at(m * count + i) * p[i] / power[i]).sum();
        (0..count).map(row).collect()
    };
    let mut p: Vec<_> = targets.iter().copied().map(Complex64::from).collect();
    for _ in gauge::iterations(iterations) {
        p = heard(&p).iter().zip(&targets).map(|(p, target)| phase(*p) * target).collect();
    }
    let gamma = heard(&p);
    let correct = |m: usize| {
        let heard = gamma[m].norm_sqr();
        if heard > 0.0 { gamma[m] * (targets[m] * targets[m] / heard / power[m]) } else { Complex64::ZERO }
    };
    let corrected: Vec<_> = (0..count).map(correct).collect();
    Excitation { values: transfer.back(&corrected), iterations, residual: None, weights: None }
}

/// Weighted Gerchberg-Saxton (Di Leonardo et al., Opt. Express 15:1913, 2007), damped.
pub fn wgs(problem: &Problem<'_>, iterations: u32) -> Excitation {
    Excitation { values: weighted(problem, iterations).0, iterations, residual: None, weights: None }
}

/// The same: the excitation, and the pressure at the foci.
fn weighted(problem: &Problem<'_>, iterations: u32) -> (Vec<Complex64>, Vec<Complex64>) {
    let targets = problem.targets();
    let mut state =
        State::from_foci(&problem.transfer, targets.iter().copied().map(Complex64::from).collect());
    state.weigh(&targets, targets.clone(), iterations);
    (state.excitation(), state.pressure[0].to_vec(targets.len()))
}

/// The same, from phases (rad) at the foci; u of the driven elements.
pub fn weighted_from(problem: &Problem<'_>, phases: &[f64], iterations: u32) -> Vec<Complex64> {
    let targets = problem.targets();
    let wanted = targets.iter().zip(phases).map(|(target, phase)| Complex64::from_polar(*target, *phase));
    let mut state = State::from_foci(&problem.transfer, wanted.collect());
    state.weigh(&targets, targets.clone(), iterations);
    state.excitation()
}

/// Sets each element in turn to the best of 16 phases for the targets (Suzuki 2021).
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
    for _ in gauge::iterations(sweeps) {
        for &n in order.iter().take_while(|_| !gauge::is_cancelled()) {
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
    Excitation { values: u, iterations: sweeps, residual: None, weights: None }
}

/// The strongest result of levelling from many batches of starts: slow, the baseline for `best`.
pub fn search(problem: &Problem<'_>, batches: usize, iterations: u32) -> Excitation {
    let mut further = Further::new(problem, iterations);
    let first = further.next(0);
    (1..batches).fold(first, |best, batch| further.stronger(best, batch))
}

/// The strongest of an excitation and of results of levelling from further batches of starts within a given time.
pub fn search_on(problem: &Problem<'_>, excitation: Excitation, time: Duration) -> Excitation {
    const ITERATIONS: u32 = 200;
    let start = Instant::now();
    if time.is_zero() {
        return excitation;
    }
    let mut further = Further::new(problem, ITERATIONS);
    let gauge = Gauge::current();
    let batches = (0..).take_while(|_| gauge.lasts(start.elapsed(), time));
    batches.fold(excitation, |best, batch| further.stronger(best, batch))
}

/// Levelling from one batch of starts after the other.
struct Further<'a> {
    transfer: &'a Transfer,
    targets: Vec<f64>,
    gram: Phasors,
    iterations: u32,
}

impl<'a> Further<'a> {
    fn new(problem: &'a Problem<'_>, iterations: u32) -> Self {
        let transfer = &problem.transfer;
        Self { transfer, targets: problem.targets(), gram: transfer.gram(None), iterations }
    }

    fn next(&mut self, batch: usize) -> Excitation {
        let Self { transfer, targets, gram, iterations } = self;
        let state = State::from_foci(transfer, starts::climbed(gram, targets, CLIMB, batch).strongest());
        levelled(state, targets, targets.clone(), *iterations)
    }

    fn stronger(&mut self, best: Excitation, batch: usize) -> Excitation {
        let other = self.next(batch);
        let weakest = |excitation: &Excitation| weakest(self.transfer, &self.targets, excitation);
        if weakest(&other) > weakest(&best) { other } else { best }
    }
}

/// The smallest pressure over its target when all elements play fully.
pub fn weakest(transfer: &Transfer, targets: &[f64], excitation: &Excitation) -> f64 {
    let played: Vec<_> = excitation.values.iter().map(|&u| phase(u)).collect();
    let relative = transfer.pressure(&played).into_iter().zip(targets);
    relative.map(|(p, target)| p.norm() / target).fold(f64::INFINITY, f64::min)
}

/// Weights, then levels.
pub fn levelled(mut state: State<'_, 1>, targets: &[f64], weights: Vec<f64>, iterations: u32) -> Excitation {
    /// Tolerated loss of the weakest focus for equal pressures.
    const LOSS: f64 = 0.02;
    let weights = Some(state.weigh(targets, weights, iterations));
    Excitation { values: state.levelled(targets, LOSS), iterations, residual: None, weights }
}

/// A uniform drive during iteration, and its pressures at the foci.
#[derive(Clone)]
pub struct State<'a, const CHANNELS: usize> {
    pub transfer: &'a Transfer,
    pub u: [Phasors; CHANNELS],
    /// H u after a step; before the next step, the values to propagate back.
    pub pressure: [Phasors; CHANNELS],
    sums: Sums,
}

impl<'a, const CHANNELS: usize> State<'a, CHANNELS> {
    /// u = ph(H* p).
    fn new(transfer: &'a Transfer, pressure: [Phasors; CHANNELS]) -> Self {
        let u = std::array::from_fn(|_| transfer.excitation());
        let mut state = Self { transfer, u, pressure, sums: Sums::default() };
        state.step(0.0);
        state
    }

    /// u ← ph(keep · u + H* p), p ← H u.
    pub fn step(&mut self, keep: f64) {
        self.transfer.drive_by(keep, &mut self.u, &mut self.pressure, &mut self.sums);
    }

    /// |p| of a focus.
    pub fn modulus(&self, m: usize) -> f64 {
        self.pressure.iter().map(|p| p.at(m).norm_sqr()).sum::<f64>().sqrt()
    }

    /// Brings |p| of a focus to a modulus.
    fn scale(&mut self, m: usize, modulus: f64) {
        let now = self.modulus(m);
        for (channel, p) in self.pressure.iter_mut().enumerate() {
            let along =
                if now > 0.0 { p.at(m) / now } else { Complex64::from(f64::from(u8::from(channel == 0))) };
            p.set(m, along * modulus);
        }
    }

    /// Pressures over their targets.
    pub fn relative(&self, targets: &[f64]) -> impl Iterator<Item = f64> {
        targets.iter().enumerate().map(|(m, target)| self.modulus(m) / target)
    }

    /// Damped weighted Gerchberg-Saxton: weak foci get more weight. Returns the weights of the foci.
    ///
    /// The correction is the square root of the ratio: undamped, two foci oscillate forever.
    pub fn weigh(&mut self, targets: &[f64], mut weights: Vec<f64>, iterations: u32) -> Vec<f64> {
        let count = targets.len() as f64;
        for _ in gauge::iterations(iterations) {
            let mean = self.relative(targets).sum::<f64>() / count;
            if mean == 0.0 {
                // The field is zero at all foci: weights are undefined.
                break;
            }
            for (weight, relative) in weights.iter_mut().zip(self.relative(targets)) {
                *weight *= (mean / relative.max(1e-3 * mean).max(f64::MIN_POSITIVE)).sqrt();
            }
            let scale = count / weights.iter().sum::<f64>();
            for (m, weight) in weights.iter_mut().enumerate() {
                *weight *= scale;
                self.scale(m, *weight);
            }
            self.step(0.0);
        }
        weights
    }
}

impl State<'_, 1> {
    pub fn from_foci(transfer: &Transfer, pressure: Phasors) -> State<'_, 1> {
        State::new(transfer, [pressure])
    }

    pub fn excitation(&self) -> Vec<Complex64> {
        self.u[0].to_vec(self.transfer.elements)
    }

    /// The smallest pressure over its target.
    pub fn weakest(&self, targets: &[f64]) -> f64 {
        self.relative(targets).fold(f64::INFINITY, f64::min)
    }

    /// Standard deviation over mean of the pressures over their targets.
    fn spread(&self, targets: &[f64]) -> f64 {
        statistics::spread(&self.relative(targets).collect::<Vec<_>>())
    }

    /// The levelled drive, unless its weakest focus loses more than this part of its pressure.
    pub fn levelled(mut self, targets: &[f64], loss: f64) -> Vec<Complex64> {
        let (weakest, before) = (self.weakest(targets), self.excitation());
        self.level(targets);
        let is_finite = self.pressure[0].iter().all(|p| p.is_finite());
        if is_finite && self.weakest(targets) >= (1.0 - loss) * weakest { self.excitation() } else { before }
    }

    /// Levels the foci with the smallest change of phases: Gauss-Newton steps.
    ///
    /// The shortest of all phase changes δφ with J δφ = s A - |p|, J = ∂|p|/∂φ, is Jᵀ y with J Jᵀ y = s A - |p|, for
    /// the s that makes it shortest; and Jᵀ y is what H* (y e^{jθ}) adds to u across its own direction, θ being the
    /// phases of p. Damped, since J Jᵀ is singular for foci closer than the array resolves. Only moduli are
    /// prescribed: prescribing the complex field of such foci is far costlier.
    fn level(&mut self, targets: &[f64]) {
        /// Damping relative to the mean of the diagonal.
        const DAMPING: f64 = 1e-2;
        let count = targets.len();
        let mut jacobian = PhaseJacobian::default();
        for _ in 0..LEVELLINGS {
            if self.spread(targets) < LEVEL || gauge::is_cancelled() {
                return;
            }
            let moduli: Vec<_> = (0..count).map(|m| self.modulus(m)).collect();
            let directions: Phasors = self.pressure[0].iter().map(phase).collect();
            jacobian.update(self.transfer, &self.u[0], &directions);
            let mean = statistics::mean((0..count).map(|m| jacobian.product(m, m)));
            // A single element changes no modulus.
            let damping = DAMPING * mean + 1e-12 * statistics::mean_square(&moduli) + f64::MIN_POSITIVE;
            let damped = |i: usize, j: usize| jacobian.product(j, i) + if i == j { damping } else { 0.0 };
            let Some(factor) = Factor::new(count, damped) else { return };
            let (to_targets, to_moduli) = (factor.solve(targets), factor.solve(&moduli));
            let along =
                |values: &[f64]| to_targets.iter().zip(values).map(|(y, value)| y * value).sum::<f64>();
            let scale = along(&moduli) / along(targets);
            for (m, direction) in directions.iter().enumerate() {
                self.pressure[0].set(m, direction * (scale * to_targets[m] - to_moduli[m]));
            }
            self.step(1.0);
        }
    }
}

/// Multipliers of the foci and the elements at the best relaxed drive of `CHANNELS` channels, for the bound
/// (`quality::bound`).
///
/// With one channel the weighted iteration ends in one of many local optima; with a few channels there are none, and
/// it converges to the optimum of the relaxation whose dual is the bound (Burer and Monteiro).
pub fn multipliers<const CHANNELS: usize>(
    transfer: &Transfer,
    targets: &[f64],
    iterations: u32,
) -> (Vec<f64>, Vec<f64>) {
    let scattered = |channel: usize| {
        let phase = |m: usize| TAU * starts::scatter(3 * m + 7 * channel * channel + channel);
        let part = |m: usize| 0.3 + starts::scatter(5 * m + 11 * channel);
        (0..targets.len()).map(|m| Complex64::from_polar(targets[m] * part(m), phase(m))).collect()
    };
    let mut state: State<'_, CHANNELS> = State::new(transfer, std::array::from_fn(scattered));
    let weights = state.weigh(targets, targets.to_vec(), iterations);
    let floor = 1e-6 * (0..targets.len()).map(|m| state.modulus(m)).fold(f64::MIN_POSITIVE, f64::max);
    let foci: Vec<_> =
        weights.iter().enumerate().map(|(m, weight)| weight / state.modulus(m).max(floor)).collect();
    // The field of the weighted foci at every element.
    let mut heard = vec![0.0; transfer.elements];
    for p in &state.pressure {
        let weighted: Vec<_> = p.iter().zip(&foci).map(|(p, weight)| p * weight).collect();
        for (heard, h) in heard.iter_mut().zip(transfer.back(&weighted)) {
            *heard += h.norm_sqr();
        }
    }
    (foci, heard.into_iter().map(f64::sqrt).collect())
}

/// The same phase with modulus 1; phase 0 for 0.
pub fn phase(value: Complex64) -> Complex64 {
    // For any scale: the square of distant fields underflows.
    let norm = value.norm();
    if norm > 0.0 { value / norm } else { Complex64::ONE }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, dvec3};

    use super::*;
    use crate::acoustics::Aperture;
    use crate::scene::Scene;

    /// Foci on a circle 10 cm above the default array, with targets spanning this ratio.
    fn circle(count: usize, radius: f64, span: f64) -> (Transfer, Vec<f64>) {
        let at = |m: usize| {
            let (sin, cos) = (TAU * m as f64 / count as f64).sin_cos();
            dvec3(radius * cos, radius * sin, 0.1)
        };
        let foci: Vec<DVec3> = (0..count).map(at).collect();
        let target = |m: usize| span.powf(m as f64 / (count - 1) as f64);
        (Aperture::new(&Scene::default()).transfer(&foci), (0..count).map(target).collect())
    }

    fn start<'a>(transfer: &'a Transfer, targets: &[f64]) -> State<'a, 1> {
        State::from_foci(transfer, targets.iter().copied().map(Complex64::from).collect())
    }

    /// The smallest and the largest of |p| over its target.
    fn range(transfer: &Transfer, targets: &[f64], values: &[Complex64]) -> (f64, f64) {
        let pressure = transfer.pressure(values);
        let relative = pressure.iter().zip(targets).map(|(p, target)| p.norm() / target);
        relative.fold((f64::INFINITY, 0.0), |(low, high), p| (low.min(p), high.max(p)))
    }

    #[test]
    fn foci_that_the_array_does_not_tell_apart_stay_strong_rather_than_level() {
        // Two foci two millimetres apart are not resolved: making one twice as loud costs pressure at both.
        let (transfer, targets) = circle(2, 1e-3, 2.0);
        for iterations in [5, 30] {
            let mut state = start(&transfer, &targets);
            state.weigh(&targets, targets.clone(), iterations);
            let weighted = state.weakest(&targets);
            state.level(&targets);
            assert!(state.weakest(&targets) < 0.9 * weighted, "no case of it: {}", state.weakest(&targets));
            let excitation = levelled(start(&transfer, &targets), &targets, targets.clone(), iterations);
            let (low, _) = range(&transfer, &targets, &excitation.values);
            assert!(low > 0.98 * weighted, "{iterations}: {low} of {weighted}");
        }
    }
}
