//! Least squares over gains and bench, freeing what the readings speak of.

use std::f64::consts::PI;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::drive::Drive;
use crate::gauge::Gauge;
use crate::measure::bench::{Bench, Parameter};
use crate::measure::equations::{BLOCK, Columns, Equations};
use crate::measure::forward::{Forward, Matrix};
use crate::measure::scan::{MeasureError, Readings, Scan};
use crate::measure::state::{State, states};
use crate::memory;
use crate::scene::Scene;
use crate::solver::cholesky::Factor;

/// χ² per degree of freedom of a parameter that is freed: 3.5 standard deviations.
pub const SIGNIFICANT: f64 = 12.0;
/// Steps of a descent, at most, and the relative fall of the sum of squares that ends it.
const STEPS: usize = 60;
const CONVERGED: f64 = 1e-9;
/// Damping: at first, at least, and where the descent gives up.
const DAMPING: [f64; 3] = [1e-3, 1e-10, 1e6];
/// Phase error (rad, root mean square) beyond which gains are not identifiable.
const VAGUE: f64 = 0.35;
/// Signal-to-noise that is assumed before anything is known: 30 dB.
const USUAL_NOISE: f64 = 0.031_622_8;
/// Part of a parameter's scatter below which its error is what readings tell.
const TOLD: f64 = 0.7;
/// Rms error of a phase of which nothing is known, rad.
const UNKNOWN_PHASE: f64 = 1.813_799;

/// What a fit may vary.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Search {
    /// Parameters that are free; the others are held. `None`: those that the readings speak of.
    pub free: Option<Vec<Parameter>>,
    /// Diameter of the microphone's disk, m, if it is known.
    pub width: Option<f64>,
    /// Relative noise of the readings, complex, where no readings are to spare that would tell; 30 dB by default.
    pub noise: Option<f64>,
}

/// A value with its standard error if no parameter of the bench is known better than the readings tell, whether it was
/// fitted or held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    pub value: f64,
    pub error: f64,
    pub is_free: bool,
}

/// The gains and the bench that explain a scan.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Of all elements, relative to the good ones' mean modulus and mean phase; 1 for the undriven.
    pub gains: Vec<Complex64>,
    /// Standard errors of their moduli, relative, and of their phases, rad.
    pub errors: Vec<[f64; 2]>,
    pub states: Vec<State>,
    /// The good elements' mean modulus: the strength relative to the scene's.
    pub scale: Estimate,
    pub bench: Bench,
    /// In the order of [`Parameter::ALL`].
    pub parameters: [Estimate; Parameter::COUNT],
    /// Pairs of parameters that the scan hardly tells apart, with their correlation.
    pub correlated: Vec<(Parameter, Parameter, f64)>,
    /// Root mean square of readings less model, over that of the readings.
    pub residual: f64,
    /// That of the noise of the readings, complex, if the model is right: from the residual and the degrees of freedom.
    pub noise: f64,
    /// Readings of the model.
    pub model: Readings,
    /// Rms error of the phases of living elements, rad.
    pub phase_error: f64,
    /// The reason for which all elements were taken to be alike; `None` if their gains were identified.
    pub vague: Option<Vague>,
}

/// A reason for which gains are not identifiable.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Vague {
    #[error(
        "{readings} readings do not determine {unknowns} unknowns: at least {least} readings are needed, and twice as many are better"
    )]
    TooFew { readings: usize, unknowns: usize, least: usize },
    #[error("the scan does not tell the elements apart: their phases would be uncertain by {:.0}°; scan a plane as wide as the array or wider, at most half a wavelength from point to point", phase_error.to_degrees())]
    Blurred { phase_error: f64 },
}

/// Fits gains and bench to a scan of a scene's array under known drives.
///
/// # Errors
/// A drive of the scan that is not there, silence, readings of zero, too little memory, or the gauge's cancellation.
pub fn fit(
    scene: &Scene,
    drives: &[Drive],
    scan: &Scan,
    search: &Search,
    gauge: &Gauge,
) -> Result<Fit, MeasureError> {
    let forward = Forward::new(scene, drives, &scan.points, &scan.drives)?;
    let power = scan.readings.rms();
    if power == 0.0 {
        return Err(MeasureError::Zero);
    }
    let _room = room(&forward, &scan.readings)?;
    let mut start = forward.nominal;
    if let Some(width) = search.width {
        start.set(Parameter::WidthSquared, width * width);
    }
    let mut descent = Descent::new(&forward, &scan.readings, start);
    let vague = descent.vague(USUAL_NOISE * power);
    descent.each = vague.is_none();
    descent.search(search, gauge)?;
    let (rows, unknowns) = descent.freedom();
    let variance = match rows > unknowns {
        true => descent.variance(),
        false => (search.noise.unwrap_or(USUAL_NOISE) * power).powi(2) / 2.0,
    };
    Ok(descent.result(scene, vague, variance))
}

/// The fit that equal elements make of their own readings, with the standard errors of a relative noise.
pub(super) fn expected(
    scene: &Scene,
    forward: &Forward,
    readings: &Readings,
    noise: f64,
) -> Result<Fit, MeasureError> {
    let power = readings.rms();
    if power == 0.0 {
        return Err(MeasureError::Zero);
    }
    let _room = room(forward, readings)?;
    let mut descent = Descent::new(forward, readings, forward.nominal);
    let vague = descent.vague(noise * power);
    descent.each = vague.is_none();
    Ok(descent.result(scene, vague, (noise * power).powi(2) / 2.0))
}

/// Memory for the Jacobian, the transfer and the inverse.
fn room(forward: &Forward, readings: &Readings) -> Result<memory::Room, MeasureError> {
    let (readings, parts, elements) = (readings.len(), readings.parts(), forward.elements());
    let bytes = 8 * (2 * elements + Parameter::COUNT) * readings * parts
        + 16 * elements * forward.points()
        + 48 * elements * elements;
    let gibibytes = bytes as f64 / f64::from(1 << 30);
    memory::reserve(bytes).ok_or(MeasureError::TooLarge { readings, elements, gibibytes })
}

/// A point of the descent.
struct Descent<'a> {
    forward: &'a Forward,
    readings: &'a Readings,
    /// Whether every element has its own gain; otherwise all have the same.
    each: bool,
    gains: Vec<Complex64>,
    /// The nominal bench, about which the parameters are expected.
    start: Bench,
    bench: Bench,
    transfer: Matrix,
    /// p of the model.
    pressures: Vec<Complex64>,
    free: Vec<Parameter>,
}

impl<'a> Descent<'a> {
    /// Equal gains, of the modulus that fits best.
    fn new(forward: &'a Forward, readings: &'a Readings, bench: Bench) -> Self {
        let transfer = forward.transfer(&bench);
        let gains = vec![Complex64::ONE; forward.elements()];
        let pressures = forward.pressures(&transfer, &gains);
        let (each, free, start) = (true, Vec::new(), bench);
        let mut descent = Self { forward, readings, each, gains, start, bench, transfer, pressures, free };
        let scale = descent.best_scale();
        descent.gains.iter_mut().chain(&mut descent.pressures).for_each(|value| *value *= scale);
        descent
    }

    /// The factor of all gains that fits best.
    fn best_scale(&self) -> Complex64 {
        let own: f64 = self.pressures.iter().map(Complex64::norm_sqr).sum();
        let common: Complex64 = match self.readings {
            Readings::Complex(read) => read.iter().zip(&self.pressures).map(|(y, p)| y * p.conj()).sum(),
            Readings::Moduli(read) => {
                read.iter().zip(&self.pressures).map(|(y, p)| y * p.norm()).sum::<f64>().into()
            }
        };
        common / own.max(f64::MIN_POSITIVE)
    }

    /// Readings less the model's.
    fn residual(&self, pressures: &[Complex64]) -> Vec<f64> {
        match self.readings {
            Readings::Complex(read) => {
                read.iter().zip(pressures).map(|(y, p)| y - p).flat_map(|off| [off.re, off.im]).collect()
            }
            Readings::Moduli(read) => read.iter().zip(pressures).map(|(y, p)| y - p.norm()).collect(),
        }
    }

    /// Unknowns of the gains.
    fn of_gains(&self) -> usize {
        if self.each { 2 * self.gains.len() } else { 2 }
    }

    /// The columns of gains and some parameters.
    fn columns(&self, parameters: &[Parameter]) -> Vec<Columns> {
        let forward = self.forward;
        let rows = self.readings.len();
        // Turns a derivative of p into those of the reading's parts.
        let turn: Vec<Complex64> = match self.readings {
            Readings::Complex(_) => Vec::new(),
            Readings::Moduli(_) => self
                .pressures
                .iter()
                .map(|p| if p.norm_sqr() > 0.0 { p.conj() / p.norm() } else { Complex64::ONE })
                .collect(),
        };
        let slopes: Vec<_> =
            parameters.iter().map(|&it| forward.slope(&self.bench, &self.gains, it)).collect();
        let gains = self.gains.len();
        let derivative = |reading: usize, unknown: usize| -> Complex64 {
            let (point, drive) = forward.readings[reading];
            let own = |n: usize| self.transfer.row(point)[n] * forward.drives[drive][n];
            match unknown.checked_sub(self.of_gains()) {
                Some(parameter) => slopes.get(parameter).map_or(Complex64::ZERO, |slope| slope[reading]),
                None if self.each => own(unknown / 2),
                None => (0..gains).map(own).sum(),
            }
        };
        let unknowns = self.of_gains() + parameters.len();
        let block = |block: usize| -> Columns {
            let parts = self.readings.parts();
            let mut columns = vec![[0.0; BLOCK]; rows * parts];
            for (reading, to) in columns.chunks_exact_mut(parts).enumerate() {
                for lane in 0..BLOCK {
                    let unknown = block * BLOCK + lane;
                    if unknown >= unknowns {
                        break;
                    }
                    let mut slope = derivative(reading, unknown);
                    // By the imaginary part of a gain.
                    if unknown < self.of_gains() && unknown % 2 == 1 {
                        slope *= Complex64::I;
                    }
                    match to {
                        [of_modulus] => of_modulus[lane] = (slope * turn[reading]).re,
                        [re, im] => (re[lane], im[lane]) = (slope.re, slope.im),
                        _ => {}
                    }
                }
            }
            columns
        };
        (0..unknowns.div_ceil(BLOCK)).into_par_iter().map(block).collect()
    }

    /// The equations of gains and some parameters, with what is known of these before: normal about their nominal values.
    fn equations(&self, parameters: &[Parameter]) -> Equations {
        let residual = self.residual(&self.pressures);
        let of_gains = self.of_gains();
        let mut equations = Equations::new(&self.columns(parameters), of_gains + parameters.len(), &residual);
        let variance = self.variance();
        for (index, &parameter) in parameters.iter().enumerate() {
            let weight = variance / parameter.scatter(&self.start).powi(2);
            let off = self.start.at(parameter) - self.bench.at(parameter);
            equations.observe(of_gains + index, weight, off);
        }
        equations
    }

    /// The sum of squares that what is known of the free parameters adds, with this variance of a reading's part.
    fn penalty(&self, bench: &Bench, variance: f64) -> f64 {
        let off = |parameter: &Parameter| {
            (bench.at(*parameter) - self.start.at(*parameter)) / parameter.scatter(&self.start)
        };
        variance * self.free.iter().map(off).map(|off| off * off).sum::<f64>()
    }

    /// The reason for which the elements cannot be told apart.
    fn vague(&self, noise: f64) -> Option<Vague> {
        let parts = self.readings.parts();
        let (rows, unknowns) = (self.readings.len() * parts, 2 * self.gains.len() + parts - 2);
        if rows < unknowns {
            let (readings, least) = (self.readings.len(), unknowns.div_ceil(parts));
            return Some(Vague::TooFew { readings, unknowns, least });
        }
        let scale = self.gains[0].norm();
        let errors = self.phase_errors(&self.equations(&[]), noise, scale);
        let phase_error = root_mean_square(&errors);
        (phase_error > VAGUE).then_some(Vague::Blurred { phase_error })
    }

    /// Standard errors of the phases of gains of a modulus, rad, with noise of p of this root mean square.
    fn phase_errors(&self, equations: &Equations, noise: f64, modulus: f64) -> Vec<f64> {
        let Some(inverse) = self.inverse(equations, self.of_gains()) else {
            return vec![f64::INFINITY; self.gains.len()];
        };
        let variance = noise * noise / 2.0;
        let error = |n: usize| {
            let g = self.gains[n] / self.gains[n].norm().max(f64::MIN_POSITIVE);
            (variance * across(&inverse, n, g)).max(0.0).sqrt() / modulus
        };
        (0..self.gains.len()).map(error).collect()
    }

    /// The inverse of JᵀJ of the first unknowns, row by row. The phase common to all gains, which moduli do not tell, is
    /// held.
    fn inverse(&self, equations: &Equations, size: usize) -> Option<Vec<Vec<f64>>> {
        let common: Vec<f64> = match self.readings {
            Readings::Complex(_) => vec![0.0; size],
            Readings::Moduli(_) => {
                let own = self.gains.iter().take(if self.each { usize::MAX } else { 1 });
                let power: f64 = own.clone().map(Complex64::norm_sqr).sum();
                let turned = own.flat_map(|g| [-g.im, g.re]).map(|part| part / power.sqrt());
                turned.chain(std::iter::repeat(0.0)).take(size).collect()
            }
        };
        let mean = (0..self.of_gains()).map(|i| equations.at(i, i)).sum::<f64>() / self.of_gains() as f64;
        let held = |i: usize, j: usize| equations.at(i, j) + mean * common[i] * common[j];
        let factor = Factor::new(size, held)?;
        let row = |i: usize| {
            let mut unit = vec![0.0; size];
            unit[i] = 1.0;
            factor.solve(&unit)
        };
        Some((0..size).into_par_iter().map(row).collect())
    }

    /// Descends to the least sum of squares over gains and free parameters.
    fn descend(&mut self, gauge: &Gauge) -> Result<(), MeasureError> {
        let sum = |residual: &[f64]| residual.iter().map(|r| r * r).sum::<f64>();
        let [mut damping, least, most] = DAMPING;
        for step in 0..STEPS {
            gauge.tell(step.min(12), 12);
            let equations = self.equations(&self.free);
            let variance = self.variance();
            let mut cost = sum(&self.residual(&self.pressures)) + self.penalty(&self.bench, variance);
            let before = cost;
            while damping < most {
                if gauge.is_cancelled() {
                    return Err(MeasureError::Cancelled);
                }
                let next = equations.factor(equations.size, damping).map(|factor| {
                    let moved = self.moved(&factor.solve(&equations.right));
                    let cost = sum(&self.residual(&moved.2)) + self.penalty(&moved.1, variance);
                    (moved, cost)
                });
                match next {
                    Some(((gains, bench, pressures, transfer), own)) if own <= cost => {
                        (self.gains, self.bench, self.pressures) = (gains, bench, pressures);
                        if let Some(transfer) = transfer {
                            self.transfer = transfer;
                        }
                        cost = own;
                        damping = (damping / 8.0).max(least);
                        break;
                    }
                    Some(_) | None => damping *= 6.0,
                }
            }
            if damping >= most || before - cost <= CONVERGED * before {
                break;
            }
        }
        Ok(())
    }

    /// Gains, bench, pressures and, at another bench, transfer after a step.
    fn moved(&self, step: &[f64]) -> (Vec<Complex64>, Bench, Vec<Complex64>, Option<Matrix>) {
        let (of_gains, of_bench) = step.split_at(self.of_gains());
        let steps: Vec<_> = of_gains.chunks(2).map(|parts| Complex64::new(parts[0], parts[1])).collect();
        let gains: Vec<_> =
            self.gains.iter().zip(steps.iter().cycle()).map(|(gain, step)| gain + step).collect();
        let mut bench = self.bench;
        for (&parameter, step) in self.free.iter().zip(of_bench) {
            bench.set(parameter, self.bench.at(parameter) + step);
        }
        let transfer = (bench != self.bench).then(|| self.forward.transfer(&bench));
        let pressures = self.forward.pressures(transfer.as_ref().unwrap_or(&self.transfer), &gains);
        (gains, bench, pressures, transfer)
    }

    /// Descends, and frees parameters in the order of their significance.
    fn search(&mut self, search: &Search, gauge: &Gauge) -> Result<(), MeasureError> {
        let groups: Vec<&[Parameter]> = match &search.free {
            Some(free) => {
                self.free.clone_from(free);
                Vec::new()
            }
            None => Parameter::GROUPS.to_vec(),
        };
        let known = |group: &&[Parameter]| group[0] == Parameter::WidthSquared && search.width.is_some();
        let mut groups: Vec<_> = groups.into_iter().filter(|group| !known(group)).collect();
        let parts = 1 + groups.len();
        let mut done = 0;
        self.descend(&gauge.part(0..1, parts))?;
        while !groups.is_empty() {
            let scores = self.scores(&groups);
            let best = (0..groups.len()).max_by(|&a, &b| scores[a].total_cmp(&scores[b]));
            let Some(best) = best.filter(|&best| scores[best] > SIGNIFICANT) else { break };
            self.free.extend(groups.remove(best));
            done += 1;
            self.descend(&gauge.part(done..done + 1, parts))?;
        }
        self.descend_anew(&gauge.part(parts - 1..parts, parts))?;
        gauge.tell(1, 1);
        Ok(())
    }

    /// Descends once more from equal gains: those that were fitted at a wrong bench may be in a wrong minimum.
    fn descend_anew(&mut self, gauge: &Gauge) -> Result<(), MeasureError> {
        if self.free.is_empty() || !self.each || matches!(self.readings, Readings::Complex(_)) {
            return Ok(());
        }
        let equal = Descent::new(self.forward, self.readings, self.bench);
        let mut anew = Self { free: self.free.clone(), start: self.start, ..equal };
        anew.descend(gauge)?;
        if anew.variance() < self.variance() {
            *self = anew;
        }
        Ok(())
    }

    /// χ² per degree of freedom of the groups, each freed alone.
    fn scores(&self, groups: &[&[Parameter]]) -> Vec<f64> {
        let all: Vec<Parameter> = self.free.iter().chain(groups.iter().copied().flatten()).copied().collect();
        let equations = self.equations(&all);
        let size = self.of_gains() + self.free.len();
        let Some(factor) = equations.factor(size, DAMPING[1]) else { return vec![0.0; groups.len()] };
        let variance = self.variance();
        let mut first = size;
        let score = |group: &&[Parameter]| {
            let own = first..first + group.len();
            first = own.end;
            let columns: Vec<Vec<f64>> =
                own.clone().map(|j| (0..size).map(|i| equations.at(i, j)).collect()).collect();
            let solved: Vec<_> = columns.iter().map(|column| factor.solve(column)).collect();
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let entry = |i: usize, j: usize| {
                equations.at(own.start + i.min(j), own.start + i.max(j)) - dot(&columns[i], &solved[j])
            };
            let rest: Vec<f64> = own
                .clone()
                .zip(&solved)
                .map(|(j, solved)| equations.right[j] - dot(&equations.right[..size], solved))
                .collect();
            // What the others explain already is lost to rounding.
            let is_lost =
                (0..own.len()).any(|i| entry(i, i) <= 1e-9 * equations.at(own.start + i, own.start + i));
            let gain = Factor::new(own.len(), entry).map(|factor| dot(&factor.solve(&rest), &rest));
            gain.filter(|_| !is_lost).map_or(0.0, |gain| gain / variance / own.len() as f64)
        };
        groups.iter().map(score).collect()
    }

    /// Readings' parts, and unknowns.
    fn freedom(&self) -> (usize, usize) {
        let parts = self.readings.parts();
        (self.readings.len() * parts, self.of_gains() + self.free.len() + parts - 2)
    }

    /// σ² of a reading's part.
    fn variance(&self) -> f64 {
        let (rows, unknowns) = self.freedom();
        let squares: f64 = self.residual(&self.pressures).iter().map(|r| r * r).sum();
        squares / rows.saturating_sub(unknowns).max(1) as f64
    }

    /// The result with a variance of a reading's part.
    fn result(self, scene: &Scene, vague: Option<Vague>, variance: f64) -> Fit {
        let power = self.readings.rms();
        let all: Vec<Parameter> = self
            .free
            .iter()
            .chain(Parameter::ALL.iter().filter(|it| !self.free.contains(it)))
            .copied()
            .collect();
        let equations = self.equations(&all);
        let of_gains = self.of_gains();
        let own = self.inverse(&equations, of_gains + self.free.len());
        let (own_states, relative, scale) = states(&self.gains);
        let elements = scene.elements();
        let mut gains = vec![Complex64::ONE; elements];
        let mut errors = vec![[f64::INFINITY; 2]; elements];
        let mut element_states = vec![State::Undriven; elements];
        let mut phases = Vec::new();
        for (index, &n) in self.forward.aperture.driven.iter().enumerate() {
            (gains[n], element_states[n]) = (relative[index], own_states[index]);
            let g = self.gains[index] / self.gains[index].norm().max(f64::MIN_POSITIVE);
            let column = if self.each { index } else { 0 };
            let error = |direction: Complex64| {
                let spread = own
                    .as_ref()
                    .map_or(f64::INFINITY, |inverse| across(inverse, column, -Complex64::I * direction));
                (variance * spread).max(0.0).sqrt()
            };
            let of_phase = (error(Complex64::I * g) / self.gains[index].norm()).min(UNKNOWN_PHASE);
            errors[n] = [error(g) / scale, of_phase];
            if own_states[index] != State::Dead {
                phases.push(of_phase);
            }
        }
        // The strength's error, from all gains' along their own directions.
        let good: Vec<usize> = (0..own_states.len()).filter(|&i| own_states[i] == State::Good).collect();
        let scale_error = own.as_ref().map_or(f64::INFINITY, |inverse| {
            let mut along = vec![0.0; of_gains];
            for &index in &good {
                let g = self.gains[index] / self.gains[index].norm() / good.len() as f64;
                let column = if self.each { 2 * index } else { 0 };
                along[column] += g.re;
                along[column + 1] += g.im;
            }
            let spread: f64 = (0..of_gains)
                .map(|i| along[i] * along.iter().zip(&inverse[i]).map(|(a, b)| a * b).sum::<f64>())
                .sum();
            (variance * spread).max(0.0).sqrt()
        });
        let (parameters, correlated) = self.parameters(&all, &equations, variance);
        let squares: f64 = self.residual(&self.pressures).iter().map(|r| r * r).sum();
        let model = match self.readings {
            Readings::Complex(_) => Readings::Complex(self.pressures.clone()),
            Readings::Moduli(_) => Readings::Moduli(self.pressures.iter().map(|p| p.norm()).collect()),
        };
        Fit {
            gains,
            errors,
            states: element_states,
            scale: Estimate { value: scale, error: scale_error, is_free: true },
            bench: self.bench,
            parameters,
            correlated,
            residual: (squares / self.readings.len() as f64).sqrt() / power,
            noise: (2.0 * variance).sqrt() / power,
            model,
            phase_error: root_mean_square(&phases),
            vague,
        }
    }

    /// Estimates of all parameters, and the pairs that are hardly told apart. `all` are those of the equations.
    fn parameters(
        &self,
        all: &[Parameter],
        equations: &Equations,
        variance: f64,
    ) -> ([Estimate; Parameter::COUNT], Vec<(Parameter, Parameter, f64)>) {
        let of_gains = self.of_gains();
        // Those that are held may be wrong, too, as far as the readings tell.
        let joint = self.inverse(equations, of_gains + all.len());
        let estimate = |parameter: &Parameter| {
            let index = all.iter().position(|it| it == parameter).map_or(of_gains, |at| of_gains + at);
            let is_free = self.free.contains(parameter);
            let spread = joint.as_ref().map_or(f64::INFINITY, |inverse| inverse[index][index]);
            let error = (variance * spread).max(0.0).sqrt();
            // What is known no better than before, the readings do not tell.
            let is_told = error < TOLD * parameter.scatter(&self.start);
            Estimate {
                value: self.bench.at(*parameter),
                error: if is_told { error } else { f64::INFINITY },
                is_free,
            }
        };
        let mut correlated = Vec::new();
        if let Some(joint) = &joint {
            for (i, first) in all.iter().enumerate() {
                for (j, second) in all.iter().enumerate().skip(i + 1) {
                    let (i, j) = (of_gains + i, of_gains + j);
                    let correlation = joint[i][j] / (joint[i][i] * joint[j][j]).sqrt();
                    if correlation.abs() > 0.9 {
                        correlated.push((*first, *second, correlation));
                    }
                }
            }
        }
        (Parameter::ALL.map(|parameter| estimate(&parameter)), correlated)
    }
}

/// The variance, in units of σ², of a gain across a direction of modulus 1.
fn across(inverse: &[Vec<f64>], element: usize, direction: Complex64) -> f64 {
    let [u, v] = [-direction.im, direction.re];
    let (i, j) = (2 * element, 2 * element + 1);
    u * u * inverse[i][i] + 2.0 * u * v * inverse[i][j] + v * v * inverse[j][j]
}

fn root_mean_square(values: &[f64]) -> f64 {
    let squares: f64 = values.iter().map(|value| value * value).sum();
    (squares / values.len().max(1) as f64).sqrt().min(PI)
}
