//! A scan: readings of a microphone at places, each under one of some drives.

use std::collections::BTreeSet;
use std::io::Read;

use glam::DVec3;
use num_complex::Complex64;

use crate::table::{Table, TableError};

/// m; places beyond are slips of the unit.
const FARTHEST: f64 = 100.0;
/// Readings, at most.
const MOST: usize = 1_000_000;
/// Pa, RMS: 0 dB.
const AUDIBLE: f64 = 20e-6;

#[derive(Clone, Debug, PartialEq)]
pub struct Scan {
    /// m, of each reading.
    pub points: Vec<DVec3>,
    /// Number of each reading's drive, from 0.
    pub drives: Vec<usize>,
    pub readings: Readings,
}

/// Pa, peak.
#[derive(Clone, Debug, PartialEq)]
pub enum Readings {
    /// With a phase relative to the drive, up to a constant.
    Complex(Vec<Complex64>),
    Moduli(Vec<f64>),
}

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeasureError {
    #[error("the scan names drive {drive}, and there {}: 0 to {}", if *drives == 1 { "is one".to_owned() } else { format!("are {drives}") }, drives - 1)]
    NoDrive { drive: usize, drives: usize },
    #[error("no element of the scene is driven")]
    Silent,
    #[error("the readings are all zero")]
    Zero,
    #[error("{readings} readings of {elements} elements need {gibibytes:.1} GiB of memory")]
    TooLarge { readings: usize, elements: usize, gibibytes: f64 },
    #[error("cancelled")]
    Cancelled,
}

impl Readings {
    pub fn len(&self) -> usize {
        match self {
            Self::Complex(values) => values.len(),
            Self::Moduli(values) => values.len(),
        }
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub fn moduli(&self) -> Vec<f64> {
        match self {
            Self::Complex(values) => values.iter().map(|p| p.norm()).collect(),
            Self::Moduli(values) => values.clone(),
        }
    }

    /// Root mean square.
    pub fn rms(&self) -> f64 {
        let squares: f64 = self.moduli().iter().map(|modulus| modulus * modulus).sum();
        (squares / self.len().max(1) as f64).sqrt()
    }

    /// Real numbers per reading.
    pub(super) fn parts(&self) -> usize {
        match self {
            Self::Complex(_) => 2,
            Self::Moduli(_) => 1,
        }
    }
}

impl Scan {
    /// The readings of CSV: `x`, `y`, `z` (m), and `re` and `im` (Pa, peak), or `amplitude` (Pa, peak) with or without
    /// `phase` (rad), `rms` (Pa) or `level` (dB re 20 µPa); optionally `drive` (from 0; without it, all are of the first).
    ///
    /// # Errors
    /// No reading's columns, an invalid row, or none.
    pub fn read(csv: impl Read) -> Result<Self, TableError> {
        const COLUMNS: [&str; 7] = ["re", "im", "amplitude", "phase", "rms", "level", "drive"];
        let mut table = Table::open(csv, ["x", "y", "z"], COLUMNS)?;
        let has = |name: &str| table.has(name);
        let is_complex = has("re") && has("im") || has("amplitude") && has("phase");
        if !is_complex && !["amplitude", "rms", "level"].iter().any(|name| has(name)) {
            return Err(table.refusal(
                "no readings: must have the columns re and im, amplitude (Pa, peak), amplitude and phase (rad), rms (Pa), \
                 or level (dB re 20 µPa)",
            ));
        }
        let (mut points, mut drives) = (Vec::new(), Vec::new());
        let (mut complex, mut moduli) = (Vec::new(), Vec::new());
        while let Some(row) = table.next_row()? {
            let point = DVec3::from_array(row.required);
            if point.abs().max_element() > FARTHEST {
                let [x, y, z] = row.required;
                return Err(table.refusal(format!("{x}, {y}, {z}: must be metres, within {FARTHEST} m")));
            }
            let [re, im, amplitude, phase, rms, level, drive] = row.optional;
            if let Some(negative) = amplitude.or(rms).filter(|value| *value < 0.0) {
                return Err(table.refusal(format!("{negative}: a modulus must not be negative")));
            }
            let drive = drive.unwrap_or(0.0);
            if drive.fract() != 0.0 || !(0.0..1e6).contains(&drive) {
                return Err(table.refusal(format!("drive = {drive}: must be a number of a drive, from 0")));
            }
            match (re, im, amplitude, phase) {
                (Some(re), Some(im), _, _) => complex.push(Complex64::new(re, im)),
                (_, _, Some(amplitude), Some(phase)) => complex.push(Complex64::from_polar(amplitude, phase)),
                (_, _, Some(amplitude), None) => moduli.push(amplitude),
                (_, _, None, _) => {
                    let of_level = level.map(|level| AUDIBLE * 10f64.powf(level / 20.0));
                    moduli.push(rms.or(of_level).unwrap_or(0.0) * std::f64::consts::SQRT_2);
                }
            }
            if points.len() == MOST {
                return Err(table.refusal(format!("more than {MOST} readings")));
            }
            points.push(point);
            drives.push(drive as usize);
        }
        if points.is_empty() {
            return Err(table.refusal("there are no readings"));
        }
        let readings = if is_complex { Readings::Complex(complex) } else { Readings::Moduli(moduli) };
        Ok(Self { points, drives, readings })
    }

    /// The mean of all places, m.
    pub fn middle(&self) -> DVec3 {
        self.points.iter().sum::<DVec3>() / self.points.len().max(1) as f64
    }

    /// Heights of the planes z = const that most readings are on, m; none if they are scattered in space.
    pub fn planes(&self) -> Vec<f64> {
        /// m: planes nearer than this are one.
        const APART: f64 = 0.002;
        let heights: BTreeSet<_> = self.points.iter().map(|at| (at.z / APART).round() as i64).collect();
        let is_scattered = heights.len() > 16;
        let planes = heights.into_iter().map(|height| height as f64 * APART);
        planes.filter(|_| !is_scattered).collect()
    }
}
