//! `best` for separate foci: levelled iteration, and a contest of starts where their phases decide how strong a
//! drive can be.
//!
//! Eight scattered starts climb in parallel on R = H H*, one per SIMD lane (`starts`), to focal phases with
//! constructive interference. A damped weighted iteration then weights the foci, and up to five Gauss-Newton steps
//! level them (`iteration`). For 8 foci H (5 to 10 ns per entry) takes a third of the time, for 32 a quarter;
//! levelling takes most of the rest. [`best_from`] continues from the previous solution and its weights; it needs H
//! but not R.
//!
//! The waves of close foci, and of foci at repeated distances as in grids and rings, add up to the same pattern on
//! the array for many pairs of foci. Wherever they cancel, elements contribute nothing, unless the focal phases
//! suit each other: one local optimum has half the pressure of another. Power on the Gram matrix, where these
//! elements have small amplitudes, does not tell them apart. So many starts iterate on the elements, in rounds that
//! fewer and fewer survive; the last ones descend to the largest soft minimum of all foci, and the best of them is
//! disturbed and descends again.

use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::acoustics::{Phasors, Transfer};
use crate::scene::Focus;
use crate::solver::descent::{Descent, Function};
use crate::solver::iteration::{self, State, phase};
use crate::solver::problem::{Excitation, Problem};
use crate::solver::{starts, statistics};

/// Scattered starts, beside climbed ones and equal phases.
const SCATTERED: usize = 24;
/// Entrants of a round, and weighted iterations of each.
const ROUNDS: [(usize, u32); 2] = [(usize::MAX, 10), (8, 15)];
/// Entrants that descend.
const FINALISTS: usize = 4;
/// Sharpness of the soft minimum, and steps with it.
const DESCENT: [(f64, usize); 2] = [(10.0, 12), (80.0, 24)];
/// Scattered starts per disturbance of the best, the disturbed part of its foci, and weighted iterations after it.
const STARTS_PER_DISTURBANCE: usize = 4;
const DISTURBED: f64 = 0.15;
const ITERATIONS: u32 = 10;
/// Tolerated loss of the weakest focus for equal pressures: no other method may be stronger by a hundredth.
const LOSS: f64 = 0.009;

/// Focal phases from the strongest of several starts on the Gram matrix, then damped weighted iteration, then Gauss and
/// Newton's steps to equal pressures; a contest of starts where these differ much.
pub fn best(problem: &Problem<'_>, iterations: u32) -> Excitation {
    let (transfer, targets) = (&problem.transfer, problem.targets());
    let climbed = starts::climbed(&transfer.gram(None), &targets, iteration::CLIMB, 0);
    let state = State::from_foci(transfer, climbed.strongest());
    let first = iteration::levelled(state, &targets, targets.clone(), iterations);
    if pays(problem, climbed.spread) { strongest(problem, first, climbed.each()) } else { first }
}

/// `best` for a problem near one that `before` solves: no start is searched for, and the phases move as little as they
/// must.
pub fn best_from(problem: &Problem<'_>, before: &Excitation, iterations: u32) -> Excitation {
    let (transfer, targets) = (&problem.transfer, problem.targets());
    let weights = before.weights.clone().filter(|weights| weights.len() == targets.len());
    let weights = weights.unwrap_or_else(|| targets.clone());
    // The phases that the foci had, weighted as they were.
    let phases = transfer.pressure(&before.values);
    let weighted = phases.iter().zip(&weights).map(|(p, weight)| phase(*p) * weight).collect();
    let state = State::from_foci(transfer, weighted);
    followed(problem, before, iteration::levelled(state, &targets, weights, iterations))
}

/// Whether a contest is worth its time: where starts differ much in power (`spread`: standard deviation over mean), or
/// distances are repeated.
fn pays(problem: &Problem<'_>, spread: f64) -> bool {
    /// Spread that one in 200 random sets exceeds.
    const EVEN: f64 = 0.2;
    problem.foci.len() > 2 && (spread > EVEN || is_regular(&problem.foci, problem.aperture.wavelength()))
}

/// Whether at least half of the distances between foci are repeated.
fn is_regular(foci: &[Focus], wavelength: f64) -> bool {
    /// Differences of equal distances: in wavelengths, and relative to the mean from one to the next.
    const EQUAL: [f64; 2] = [1.0 / 80.0, 1.0 / 8.0];
    let places = || foci.iter().map(|focus| focus.position);
    let mut distances: Vec<_> =
        places().enumerate().flat_map(|(m, a)| places().take(m).map(move |b| a.distance(b))).collect();
    distances.sort_by(f64::total_cmp);
    let steps = distances.len() - 1;
    let mean = (distances[steps] - distances[0]) / steps as f64;
    let equal = (EQUAL[0] * wavelength).min(EQUAL[1] * mean + 1e-9 * distances[steps]);
    2 * distances.windows(2).filter(|pair| pair[1] - pair[0] <= equal).count() >= steps
}

/// The strongest drive of `first` and of all entrants.
fn strongest(problem: &Problem<'_>, first: Excitation, climbed: impl Iterator<Item = Phasors>) -> Excitation {
    /// Limit of elements times foci times scattered starts: larger problems have fewer starts.
    const WORK: usize = 3_000_000;
    const FEWEST: usize = 4;
    let (transfer, targets) = (&problem.transfer, &problem.targets()[..]);
    let weakest = |found: &Excitation| iteration::weakest(transfer, targets, found);
    if weakest(&first) <= 0.0 {
        return first;
    }
    let most = (WORK / (transfer.elements * transfer.points)).clamp(FEWEST, SCATTERED);
    let equal = targets.iter().copied().map(Complex64::from).collect();
    let scattered = |number| starts::scattered(targets, number).collect();
    let starts = std::iter::once(equal).chain(climbed).chain((9..9 + most).map(scattered));
    let mut entrants: Vec<_> = starts.map(|start| Entrant::new(transfer, targets, start)).collect();
    for (count, iterations) in ROUNDS {
        entrants = best_of(entrants, targets, count);
        entrants.iter_mut().for_each(|entrant| entrant.weigh(targets, iterations));
    }
    let finalists =
        best_of(entrants, targets, FINALISTS).into_iter().map(|entrant| entrant.descended(targets));
    let weakest_of = |entrant: &Entrant<'_>| entrant.state.weakest(targets);
    let mut best = finalists.max_by(|a, b| weakest_of(a).total_cmp(&weakest_of(b)));
    for number in 0..most / STARTS_PER_DISTURBANCE {
        let other = best.as_ref().map(|best| best.disturbed(targets, number).descended(targets));
        best = best.into_iter().chain(other).max_by(|a, b| weakest_of(a).total_cmp(&weakest_of(b)));
    }
    let found = best.map(|Entrant { state, weights }| Excitation {
        values: state.levelled(targets, LOSS),
        weights: Some(weights),
        ..first.clone()
    });
    found.filter(|found| weakest(found) > weakest(&first)).unwrap_or(first)
}

/// The drive for moved foci; where levelling leaves it uneven, the stronger of that and of a descent from `before`.
fn followed(problem: &Problem<'_>, before: &Excitation, levelled: Excitation) -> Excitation {
    /// Weakest focus over mean; foci that the array tells apart have more.
    const EVEN: f64 = 0.9;
    let (transfer, targets) = (&problem.transfer, &problem.targets()[..]);
    let reached = transfer.pressure(&levelled.values);
    let relative: Vec<_> = reached.iter().zip(targets).map(|(p, target)| p.norm() / target).collect();
    if statistics::evenness(&relative) >= EVEN || before.values.len() != transfer.elements {
        return levelled;
    }
    let equal = targets.iter().copied().map(Complex64::from).collect();
    let mut entrant = Entrant::new(transfer, targets, equal);
    for (n, u) in before.values.iter().enumerate() {
        entrant.state.u[0].set(n, phase(*u));
    }
    let Entrant { state, weights } = entrant.descended(targets);
    let found =
        Excitation { values: state.levelled(targets, LOSS), weights: Some(weights), ..levelled.clone() };
    let weakest = |found: &Excitation| iteration::weakest(transfer, targets, found);
    if weakest(&found) > weakest(&levelled) { found } else { levelled }
}

/// A drive in the contest, and the weights of its foci.
struct Entrant<'a> {
    state: State<'a, 1>,
    weights: Vec<f64>,
}

impl<'a> Entrant<'a> {
    fn new(transfer: &'a Transfer, targets: &[f64], start: Phasors) -> Self {
        Self { state: State::from_foci(transfer, start), weights: targets.to_vec() }
    }

    fn weigh(&mut self, targets: &[f64], iterations: u32) {
        self.weights = self.state.weigh(targets, std::mem::take(&mut self.weights), iterations);
    }

    /// Mean of pressures over targets, in which weak foci count most; smoother than the weakest alone.
    fn strength(&self, targets: &[f64]) -> f64 {
        let mean = self.state.relative(targets).map(|relative| relative.powi(-4)).sum::<f64>();
        (mean / targets.len() as f64).powf(-0.25)
    }

    /// The end of a descent, with the weights of its soft minimum.
    fn descended(mut self, targets: &[f64]) -> Self {
        let transfer = self.state.transfer;
        let phases = self.state.excitation().iter().map(|u| u.arg()).collect();
        let mut soft = SoftMinimum::new(transfer, targets);
        let mut descent = Descent::new(phases, &mut soft);
        for (sharpness, steps) in DESCENT {
            soft.sharpness = sharpness;
            descent.renew(&mut soft);
            for _ in 0..steps {
                if !descent.step(&mut soft) {
                    break;
                }
            }
        }
        soft.play(&descent.x);
        for (n, u) in soft.u.iter().enumerate() {
            self.state.u[0].set(n, *u);
        }
        self.state.pressure[0] = soft.pressure.iter().copied().collect();
        let weights = soft.weights().into_iter().zip(&soft.pressure).map(|(weight, p)| weight * p.norm());
        let weights: Vec<_> = weights.collect();
        let scale = targets.len() as f64 / weights.iter().sum::<f64>();
        if scale.is_finite() {
            self.weights = weights.into_iter().map(|weight| weight * scale).collect();
        }
        self
    }

    /// Other phases at some of the foci.
    fn disturbed(&self, targets: &[f64], number: usize) -> Self {
        let turn = |m: usize| {
            let is_turned = starts::scatter(3 * m + number * (m + 7) + 1) < DISTURBED;
            if is_turned { TAU * starts::scatter(5 * m + 11 * number + 3) } else { 0.0 }
        };
        let weighted =
            |(m, p): (usize, Complex64)| phase(p) * Complex64::from_polar(self.weights[m], turn(m));
        let start = self.state.pressure[0].iter().enumerate().map(weighted).collect();
        let mut disturbed =
            Self { state: State::from_foci(self.state.transfer, start), weights: self.weights.clone() };
        disturbed.weigh(targets, ITERATIONS);
        disturbed
    }
}

/// The strongest entrants, one of those that have converged to the same drive.
fn best_of<'a>(entrants: Vec<Entrant<'a>>, targets: &[f64], count: usize) -> Vec<Entrant<'a>> {
    const SAME: f64 = 1e-6;
    let mut ranked: Vec<_> =
        entrants.into_iter().map(|entrant| (entrant.strength(targets), entrant)).collect();
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
    ranked.dedup_by(|next, kept| next.0 >= (1.0 - SAME) * kept.0);
    ranked.into_iter().take(count).map(|(_, entrant)| entrant).collect()
}

/// ½/q ln(mean (|p_m|/A_m)^-2q): the negative logarithm of a soft minimum of sharpness q, of the phases of the elements.
struct SoftMinimum<'a> {
    transfer: &'a Transfer,
    targets: &'a [f64],
    sharpness: f64,
    u: Vec<Complex64>,
    pressure: Vec<Complex64>,
    /// (|p|/A)², and its least.
    squares: Vec<f64>,
    least: f64,
}

impl<'a> SoftMinimum<'a> {
    fn new(transfer: &'a Transfer, targets: &'a [f64]) -> Self {
        let (u, pressure, squares) = (Vec::new(), Vec::new(), Vec::new());
        Self { transfer, targets, sharpness: 1.0, u, pressure, squares, least: 0.0 }
    }

    fn play(&mut self, phases: &[f64]) {
        self.u = phases.iter().map(|&phase| Complex64::cis(phase)).collect();
        self.pressure = self.transfer.pressure(&self.u);
        let square = |(p, target): (&Complex64, &f64)| (p / target).norm_sqr();
        self.squares = self.pressure.iter().zip(self.targets).map(square).collect();
        self.least = self.squares.iter().copied().fold(f64::INFINITY, f64::min);
    }

    /// (least/(|p|/A)²)^q
    fn weaknesses(&self) -> impl Iterator<Item = f64> {
        self.squares.iter().map(|square| (self.least / square).powf(self.sharpness))
    }

    /// Twice the derivatives by |p_m|², with the sign of the minimum.
    fn weights(&self) -> Vec<f64> {
        let sum: f64 = self.weaknesses().sum();
        let weight =
            |((weakness, square), target): ((f64, &f64), &f64)| weakness / (sum * square * target * target);
        self.weaknesses().zip(&self.squares).zip(self.targets).map(weight).collect()
    }
}

impl Function for SoftMinimum<'_> {
    fn evaluate(&mut self, phases: &[f64], gradient: &mut [f64]) -> f64 {
        self.play(phases);
        if self.least.is_nan() || self.least <= 0.0 {
            gradient.fill(0.0);
            return f64::INFINITY;
        }
        let weighted: Vec<_> = self.weights().into_iter().zip(&self.pressure).map(|(w, p)| p * w).collect();
        let heard = self.transfer.back(&weighted);
        for ((slope, u), heard) in gradient.iter_mut().zip(&self.u).zip(heard) {
            *slope = (u * heard.conj()).im;
        }
        let mean = self.weaknesses().sum::<f64>() / self.targets.len() as f64;
        mean.ln() / (2.0 * self.sharpness) - 0.5 * self.least.ln()
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, dvec3};

    use super::*;
    use crate::acoustics::Aperture;
    use crate::scene::Scene;

    /// Scattered places above the default array.
    fn scattered(count: usize, number: usize) -> Vec<DVec3> {
        let part = |index: usize| starts::scatter(index + 1000 * number);
        let place = |m: usize| {
            let turn = part(7 * m * m + 3);
            dvec3(0.1 * part(m * (m + 5)) - 0.05, 0.1 * turn - 0.05, 0.1 + 0.05 * part(11 * m * m + m))
        };
        (0..count).map(place).collect()
    }

    #[test]
    fn the_gradient_of_the_soft_minimum_is_its_slope() {
        let transfer = Aperture::new(&Scene::default()).transfer(&scattered(5, 1));
        let targets = [1.0, 0.5, 2.0, 1.5, 1.0];
        let mut soft = SoftMinimum::new(&transfer, &targets);
        soft.sharpness = 6.0;
        let phases: Vec<_> = (0..transfer.elements).map(|n| TAU * starts::scatter(n)).collect();
        let mut gradient = vec![0.0; phases.len()];
        soft.evaluate(&phases, &mut gradient);
        let largest = gradient.iter().fold(0.0f64, |most, slope| most.max(slope.abs()));
        for n in [0, 17, 100, 255] {
            let mut at = |change: f64| {
                let mut moved = phases.clone();
                moved[n] += change;
                soft.evaluate(&moved, &mut vec![0.0; phases.len()])
            };
            let slope = (at(1e-4) - at(-1e-4)) / 2e-4;
            assert!((slope - gradient[n]).abs() < 1e-5 * largest, "{n}: {slope}, {}", gradient[n]);
        }
    }
}
