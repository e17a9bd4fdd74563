//! Readings of a scan as functions of gains and bench, and their derivatives.

use std::collections::HashMap;
use std::f64::consts::TAU;

use glam::DVec3;
use num_complex::Complex64;
use rayon::prelude::*;

use crate::acoustics::Aperture;
use crate::drive::Drive;
use crate::measure::bench::{Bench, Parameter};
use crate::measure::scan::MeasureError;
use crate::scene::Scene;

/// Places per task of a thread.
const TASK: usize = 64;
/// Rings of the quadrature on the microphone's disk, and places on each: exact for polynomials of degree 7.
const RINGS: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];
const AROUND: usize = 8;
/// m: smaller disks are points.
const POINT: f64 = 1e-6;

/// A scan's places and drives, before an array.
#[derive(Debug)]
pub struct Forward {
    /// Those elements that a drive of the scan drives.
    pub aperture: Aperture,
    pub nominal: Bench,
    middle: DVec3,
    /// Without repetition, m.
    points: Vec<DVec3>,
    /// Point and drive of each reading.
    pub readings: Vec<(usize, usize)>,
    /// u of the aperture's driven elements.
    pub drives: Vec<Vec<Complex64>>,
    /// Readings of each drive.
    of_drive: Vec<Vec<usize>>,
}

/// Transfers, a row per point.
#[derive(Debug)]
pub struct Matrix {
    pub columns: usize,
    pub values: Vec<Complex64>,
}

impl Matrix {
    pub fn row(&self, row: usize) -> &[Complex64] {
        &self.values[row * self.columns..(row + 1) * self.columns]
    }
}

impl Forward {
    /// # Errors
    /// A drive of the readings that is not there, or no driven element.
    pub fn new(
        scene: &Scene,
        drives: &[Drive],
        points: &[DVec3],
        of: &[usize],
    ) -> Result<Self, MeasureError> {
        let mut aperture = Aperture::new(scene);
        let used: Vec<bool> = (0..drives.len()).map(|drive| of.contains(&drive)).collect();
        if let Some(&drive) = of.iter().find(|&&drive| drive >= drives.len()) {
            return Err(MeasureError::NoDrive { drive, drives: drives.len() });
        }
        let sounds = |&n: &usize| {
            let amplitude = |(drive, _): (&Drive, _)| drive.amplitudes.get(n).copied().unwrap_or(0.0);
            drives.iter().zip(&used).filter(|(_, used)| **used).any(|pair| amplitude(pair) > 0.0)
        };
        aperture.driven.retain(sounds);
        if aperture.driven.is_empty() {
            return Err(MeasureError::Silent);
        }
        let (mut unique, mut known) = (Vec::new(), HashMap::new());
        let mut readings = Vec::with_capacity(points.len());
        let mut of_drive = vec![Vec::new(); drives.len()];
        for (index, (point, &drive)) in points.iter().zip(of).enumerate() {
            let place = *known.entry(point.to_array().map(f64::to_bits)).or_insert_with(|| {
                unique.push(*point);
                unique.len() - 1
            });
            readings.push((place, drive));
            of_drive[drive].push(index);
        }
        let middle = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
        let drives = drives.iter().map(|drive| drive.excitation(&aperture.driven)).collect();
        Ok(Self {
            aperture,
            nominal: Bench::nominal(scene),
            middle,
            points: unique,
            readings,
            drives,
            of_drive,
        })
    }

    /// Points without repetition.
    pub fn points(&self) -> usize {
        self.points.len()
    }

    pub fn elements(&self) -> usize {
        self.aperture.driven.len()
    }

    /// Offsets of the microphone's places from its middle, with their common weight.
    fn disk(&self, bench: &Bench) -> Vec<DVec3> {
        let radius = bench.width() / 2.0;
        if radius < POINT {
            return vec![DVec3::ZERO];
        }
        let turn = bench.turn();
        let at = |ring: f64, step: usize| {
            let angle = TAU * step as f64 / AROUND as f64;
            turn * DVec3::new(angle.cos(), angle.sin(), 0.0) * (radius * ring.sqrt())
        };
        RINGS.iter().flat_map(|&ring| (0..AROUND).map(move |step| at(ring, step))).collect()
    }

    /// H of all points.
    pub fn transfer(&self, bench: &Bench) -> Matrix {
        let aperture = bench.aperture(&self.aperture, &self.nominal);
        let (columns, disk) = (self.elements(), self.disk(bench));
        let mut values = vec![Complex64::ZERO; self.points.len() * columns];
        let places = bench.places(&self.points, self.middle);
        let share = 1.0 / disk.len() as f64;
        places.par_chunks(TASK).zip(values.par_chunks_mut(TASK * columns)).for_each(|(places, to)| {
            for offset in &disk {
                let places: Vec<_> = places.iter().map(|place| place + offset).collect();
                let transfer = aperture.transfer(&places);
                for (row, to) in transfer.rows().zip(to.chunks_exact_mut(columns)) {
                    to.iter_mut().zip(row).for_each(|(sum, h)| *sum += share * h);
                }
            }
        });
        Matrix { columns, values }
    }

    /// p of every reading, from H.
    pub fn pressures(&self, transfer: &Matrix, gains: &[Complex64]) -> Vec<Complex64> {
        let weights: Vec<Vec<_>> = self.weights(gains);
        let pressure = |&(point, drive): &(usize, usize)| {
            transfer.row(point).iter().zip(&weights[drive]).map(|(h, w)| h * w).sum::<Complex64>()
        };
        self.readings.par_iter().with_min_len(TASK).map(pressure).collect()
    }

    /// g u of every drive.
    fn weights(&self, gains: &[Complex64]) -> Vec<Vec<Complex64>> {
        self.drives.iter().map(|drive| drive.iter().zip(gains).map(|(u, g)| u * g).collect()).collect()
    }

    /// The same at another bench, without its H.
    pub fn pressures_at(&self, bench: &Bench, gains: &[Complex64]) -> Vec<Complex64> {
        let aperture = bench.aperture(&self.aperture, &self.nominal);
        let disk = self.disk(bench);
        let share = 1.0 / disk.len() as f64;
        let places = bench.places(&self.points, self.middle);
        let mut pressures = vec![Complex64::ZERO; self.readings.len()];
        for (weights, of_drive) in self.weights(gains).iter().zip(&self.of_drive) {
            let own: Vec<_> = of_drive.iter().map(|&reading| places[self.readings[reading].0]).collect();
            for offset in disk.iter().filter(|_| !own.is_empty()) {
                let moved: Vec<_> = own.iter().map(|place| place + offset).collect();
                for (&reading, p) in of_drive.iter().zip(aperture.pressures(&moved, weights)) {
                    pressures[reading] += share * p;
                }
            }
        }
        pressures
    }

    /// ∂p/∂θ of every reading.
    pub fn slope(&self, bench: &Bench, gains: &[Complex64], parameter: Parameter) -> Vec<Complex64> {
        let step = parameter.step();
        let at = |sign: f64| {
            let mut beside = *bench;
            beside.set(parameter, bench.at(parameter) + sign * step);
            (beside.at(parameter), self.pressures_at(&beside, gains))
        };
        // At a limit, from one side.
        let ((low, before), (high, after)) = (at(-1.0), at(1.0));
        before.iter().zip(after).map(|(before, after)| (after - before) / (high - low)).collect()
    }
}
