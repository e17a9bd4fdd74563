//! The total sound: that of the elements, and what bodies make of it.
//!
//! Bodies turn H into H + G A⁻¹ B: B is the sound of the elements at their surfaces, A⁻¹ the answer of these, and G the
//! sound of the answer at points ([`crate::scatter`]). Within a body no pressure is a number.

use std::sync::Arc;

use glam::DVec3;
use num_complex::Complex64;
use rayon::prelude::*;

use crate::acoustics::partial::PartialWaves;
use crate::acoustics::{aperture::Aperture, transfer::Transfer};
use crate::scatter::{Answer, Bodies, BodyError, Incident, Rows, Skin};

/// Points whose transfer is in memory at the same time.
const RUN: usize = 64;
/// Elements whose answers are found together.
const TOGETHER: usize = 32;
/// Rows for whose sake the answers to all elements are found: one row in so many of them costs less by itself.
const FEW: usize = 6;
/// Shares of the surfaces' points.
const SHARES: usize = 16;
/// What is within a body.
const NOTHING: Complex64 = Complex64::new(f64::NAN, f64::NAN);

impl Aperture {
    /// H: one row of complex pressures (Pa, peak) per point, one column per driven element; including reflections and
    /// what bodies scatter. Rows within bodies are 0.
    pub fn transfer(&self, points: &[DVec3]) -> Transfer {
        let mut transfer = self.transfer_of_elements(points);
        self.add_rows((points, &[]), &mut transfer);
        transfer
    }

    /// [`Transfer::in_turn`] at many points, without room for their transfer.
    ///
    /// # Panics
    /// Other than a value per driven element and drive.
    pub fn pressures(&self, points: &[DVec3], drives: &[Complex64]) -> Vec<Complex64> {
        if self.bodies.is_empty() {
            return self.pressures_of_elements(points, drives);
        }
        let count = self.driven.len().max(1);
        let own = |drive: &[Complex64]| {
            let mut all = self.pressures_of_elements(points, drive);
            let scattered = self.scattered((points, &[]), drive).unwrap_or_default();
            all.iter_mut().zip(scattered).for_each(|(sum, p)| *sum += p);
            all
        };
        let mut drives = drives.chunks(count).map(own);
        let first = drives.next().unwrap_or_default();
        let mut squares: Vec<_> = first.iter().map(Complex64::norm_sqr).collect();
        let mut turns = 1.0;
        for others in drives {
            squares.iter_mut().zip(&others).for_each(|(sum, p)| *sum += p.norm_sqr());
            turns += 1.0;
        }
        if turns == 1.0 {
            return first;
        }
        let mean = |(p, square): (&Complex64, &f64)| Complex64::from_polar((square / turns).sqrt(), p.arg());
        first.iter().zip(&squares).map(mean).collect()
    }

    /// The rows of [`Aperture::transfer`] and of its slopes along `directions` (unit vectors), Pa/m, in sequence for
    /// every point. Slopes in an element's plane are those just above.
    pub(crate) fn transfer_with_slopes(&self, points: &[DVec3], directions: &[DVec3]) -> Transfer {
        let mut transfer = self.slopes_of_elements(points, directions);
        self.add_rows((points, directions), &mut transfer);
        transfer
    }

    /// The partial waves of a drive up to an order, from the sphere of a radius about a point (m), and those of its slopes
    /// along the scene's axes: also of sound that does not quite obey the wave equation.
    pub(crate) fn waves_with_slopes(
        &self,
        order: usize,
        shell: (DVec3, f64),
        drive: &[Complex64],
    ) -> (PartialWaves, [PartialWaves; 3]) {
        let points = PartialWaves::points(order, shell);
        let mut all = self.pressures_with_slopes(&points, drive);
        if let Some(scattered) = self.scattered((&points, &DVec3::AXES), drive) {
            for (index, value) in scattered.into_iter().enumerate() {
                all[index % 4][index / 4] += value;
            }
        }
        let [waves, x, y, z] =
            all.map(|values| PartialWaves::new(order, self.element.wavenumber, shell, |_| values));
        (waves, [x, y, z])
    }

    /// The same array without bodies.
    #[doc(hidden)]
    pub fn without_bodies(&self) -> Self {
        Self { bodies: Default::default(), ..self.clone() }
    }

    /// Finds the answers of bodies to all elements, after which any drive costs a product.
    #[doc(hidden)]
    pub fn prepare(&self) {
        self.bodies.columns(|bodies| self.answers(bodies));
    }

    /// Whether they are found, or there are no bodies.
    #[doc(hidden)]
    pub fn is_prepared(&self) -> bool {
        self.bodies.is_prepared()
    }

    /// Whether the sound of drives, one after the other with a value per driven element, needs no search for answers.
    #[doc(hidden)]
    pub fn knows(&self, drives: &[Complex64]) -> bool {
        let count = self.driven.len().max(1);
        self.is_prepared() || drives.chunks(count).all(|drive| self.bodies.knows(&self.of_all(drive)))
    }

    /// The scattered sound of every element at points (m) outside, once the answers to all are known, as far as there is
    /// memory.
    pub(crate) fn table_of_bodies(&self, points: &[DVec3]) -> Option<Rows> {
        let (bodies, columns) = self.bodies.known_columns()?;
        bodies.table(columns, points)
    }

    /// Scattered pressures (Pa) of a drive and their slopes along directions, in sequence for every point (m).
    pub(crate) fn scattered(
        &self,
        (points, directions): (&[DVec3], &[DVec3]),
        drive: &[Complex64],
    ) -> Option<Vec<Complex64>> {
        let (bodies, answer) = self.answer(drive)?;
        let sounds = bodies.sounds(&answer, points);
        let of = |(at, (p, [x, y, z])): (&DVec3, (Complex64, [Complex64; 3]))| {
            let is_within = bodies.contains(*at);
            let slope = move |to: &DVec3| x * to.x + y * to.y + z * to.z;
            let values = [p].into_iter().chain(directions.iter().map(slope));
            values.map(|value| if is_within { NOTHING } else { value }).collect::<Vec<_>>()
        };
        Some(points.par_iter().zip(sounds).flat_map_iter(of).collect())
    }

    /// The answer of the bodies to a drive, a value per driven element.
    pub(crate) fn answer(&self, drive: &[Complex64]) -> Option<(&Bodies, Arc<Answer>)> {
        self.bodies.answer(self.of_all(drive), |bodies| self.heard_by(bodies, drive))
    }

    /// A drive with a value for every element, from those of driven ones.
    fn of_all(&self, drive: &[Complex64]) -> Vec<Complex64> {
        let mut all = vec![Complex64::ZERO; self.positions.len()];
        self.driven.iter().zip(drive).for_each(|(&n, u)| all[n] = *u);
        all
    }

    /// The surfaces of all bodies with the total pressure of a drive on them, of spheres with this edge (m).
    #[doc(hidden)]
    pub fn skins(&self, drive: &[Complex64], edge: f64) -> Vec<Skin> {
        self.answer(drive).map_or(Vec::new(), |(bodies, answer)| bodies.skins(&answer, edge))
    }

    /// Bounds on the errors of what each body scatters, of a drive.
    #[doc(hidden)]
    pub fn body_errors(&self, drive: &[Complex64]) -> Vec<BodyError> {
        let Some((bodies, answer)) = self.answer(drive) else { return Vec::new() };
        let incident = self.heard_by(bodies, drive);
        bodies.errors(&answer, &incident, |points| self.pressures_of_elements(points, drive))
    }

    /// The sound of a drive at the surfaces of bodies.
    fn heard_by(&self, bodies: &Bodies, drive: &[Complex64]) -> Incident {
        let (points, normals) = bodies.points();
        let runs: Vec<_> =
            points.par_chunks(RUN).map(|points| self.pressures_with_slopes(points, drive)).collect();
        let part = |part: usize| runs.iter().flat_map(move |run| run[part].iter().copied());
        let [x, y, z] = [1, 2, 3].map(part);
        let slopes = x.zip(y).zip(z).zip(&normals);
        let slopes = slopes.map(|(((x, y), z), to)| x * to.x + y * to.y + z * to.z).collect();
        Incident { pressures: part(0).collect(), slopes }
    }

    /// The answers of bodies to every element.
    fn answers(&self, bodies: &Bodies) -> Vec<Answer> {
        let elements: Vec<_> = (0..self.positions.len()).collect();
        let (points, normals) = bodies.points();
        let of = |elements: &[usize]| {
            let driven = Self { driven: elements.to_vec(), ..self.without_bodies() };
            let of_run = |(points, normals): (&[DVec3], &[DVec3])| {
                let transfer = driven.slopes_of_elements(points, &DVec3::AXES);
                let of_element = |element: usize| {
                    let value = |row: usize| transfer.at(row, element);
                    let slope = |(point, to): (usize, &DVec3)| {
                        let [x, y, z] = [1, 2, 3].map(|part| value(4 * point + part));
                        x * to.x + y * to.y + z * to.z
                    };
                    let slopes = normals.iter().enumerate().map(slope).collect();
                    Incident { pressures: (0..points.len()).map(|point| value(4 * point)).collect(), slopes }
                };
                (0..elements.len()).map(of_element).collect::<Vec<_>>()
            };
            let runs: Vec<_> = points.par_chunks(RUN).zip(normals.par_chunks(RUN)).map(of_run).collect();
            let mut all = vec![Incident::default(); elements.len()];
            for (to, own) in runs.into_iter().flat_map(|run| run.into_iter().enumerate()) {
                all[to].pressures.extend(own.pressures);
                all[to].slopes.extend(own.slopes);
            }
            bodies.answers(&all, None)
        };
        elements.chunks(TOGETHER).flat_map(of).collect()
    }

    /// Adds G A⁻¹ B to the rows of points: the pressure's, and those of its slopes along directions. Nothing is heard
    /// within a body.
    fn add_rows(&self, (points, directions): (&[DVec3], &[DVec3]), transfer: &mut Transfer) {
        let Some(bodies) = self.bodies.bodies() else { return };
        let rows = 1 + directions.len();
        let slope = |to: &DVec3| [0.0, to.x, to.y, to.z];
        let parts: Vec<_> = [[1.0, 0.0, 0.0, 0.0]].into_iter().chain(directions.iter().map(slope)).collect();
        let is_within: Vec<_> = points.par_iter().map(|at| bodies.contains(*at)).collect();
        // The weights of an answer in every row.
        let weights = |(at, is_within): (&DVec3, &bool)| -> Vec<Vec<Complex64>> {
            let all = if *is_within { Vec::new() } else { bodies.weights(*at) };
            let row = |parts: &[f64; 4]| {
                all.iter().map(|own| own.iter().zip(parts).map(|(w, part)| w * part).sum()).collect()
            };
            parts.iter().map(row).collect()
        };
        let set = |transfer: &mut Transfer, row: usize, is_within: bool, values: Vec<Complex64>| {
            for (column, value) in values.into_iter().enumerate() {
                transfer.set(row, column, transfer.at(row, column) + value);
            }
            if is_within {
                (0..transfer.elements).for_each(|column| transfer.set(row, column, Complex64::ZERO));
            }
        };
        if !self.bodies.has_columns() && points.len() * rows * FEW <= self.driven.len() {
            let weights: Vec<_> = points.iter().zip(&is_within).flat_map(weights).collect();
            let outside: Vec<_> = (0..weights.len()).filter(|row| !weights[*row].is_empty()).collect();
            let wanted: Vec<_> = outside.iter().map(|row| weights[*row].clone()).collect();
            if let Some(scattered) = self.rows_by_adjoints(bodies, &wanted) {
                let mut all = vec![Vec::new(); weights.len()];
                outside.iter().zip(scattered).for_each(|(row, values)| all[*row] = values);
                for (row, values) in all.into_iter().enumerate() {
                    set(transfer, row, is_within[row / rows], values);
                }
                return;
            }
        }
        let Some((_, columns)) = self.bodies.columns(|bodies| self.answers(bodies)) else { return };
        let entries = |weights: Vec<Complex64>| -> Vec<Complex64> {
            let entry = |&n: &usize| {
                let pairs = weights.iter().zip(columns[n].iter().flatten());
                pairs.map(|(weight, value)| weight * value).sum()
            };
            self.driven.iter().map(entry).collect()
        };
        let of = |pair: (&DVec3, &bool)| weights(pair).into_iter().map(entries).collect::<Vec<_>>();
        for (first, some) in (0..points.len()).step_by(RUN).zip(points.chunks(RUN)) {
            let inner = &is_within[first..first + some.len()];
            let all: Vec<_> = some.par_iter().zip(inner).flat_map_iter(of).collect();
            for (row, values) in (first * rows..).zip(all) {
                set(transfer, row, is_within[row / rows], values);
            }
        }
    }

    /// Rows of G A⁻¹ B by one adjoint solution each, from their weights of the answer.
    fn rows_by_adjoints(&self, bodies: &Bodies, weights: &[Vec<Complex64>]) -> Option<Vec<Vec<Complex64>>> {
        let adjoints = bodies.adjoints(weights)?;
        let (points, normals) = bodies.points();
        let elements = self.without_bodies();
        let zeros = || vec![vec![Complex64::ZERO; self.driven.len()]; weights.len()];
        let of_run = |mut sums: Vec<Vec<Complex64>>, first: usize| {
            let some = first..points.len().min(first + RUN);
            let transfer = elements.slopes_of_elements(&points[some.clone()], &DVec3::AXES);
            for (index, point) in some.enumerate() {
                let [x, y, z] = normals[point].to_array();
                for (adjoint, sums) in adjoints.iter().zip(&mut sums) {
                    let (p, slope) = (adjoint.pressures[point], adjoint.slopes[point]);
                    for (part, weight) in [p, slope * x, slope * y, slope * z].into_iter().enumerate() {
                        let row = transfer.row(4 * index + part);
                        sums.iter_mut().zip(row).for_each(|(sum, wave)| *sum += weight * wave);
                    }
                }
            }
            sums
        };
        let add = |mut one: Vec<Vec<Complex64>>, other: Vec<Vec<Complex64>>| {
            one.iter_mut().flatten().zip(other.iter().flatten()).for_each(|(sum, own)| *sum += own);
            one
        };
        // Shares that do not depend on the threads, and are added in sequence, so that sums do not, either.
        let runs: Vec<_> = (0..points.len()).step_by(RUN).collect();
        let shares: Vec<_> = runs
            .par_chunks(runs.len().div_ceil(SHARES).max(1))
            .map(|runs| runs.iter().fold(zeros(), |sums, first| of_run(sums, *first)))
            .collect();
        Some(shares.into_iter().fold(zeros(), add))
    }
}
