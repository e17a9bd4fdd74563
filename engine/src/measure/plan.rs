//! A scan before it is made: random drives, places in front of the array, and how well they tell the elements apart.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use num_complex::Complex64;

use crate::acoustics::Aperture;
use crate::drive::Drive;
use crate::measure::fit::{Fit, expected};
use crate::measure::forward::Forward;
use crate::measure::scan::{MeasureError, Readings};
use crate::scene::Scene;

/// Levels of a random drive's phases that most boards have among theirs.
pub const LEVELS: u16 = 16;
/// Wavelengths between a scan and the array, at least.
const NEAREST: f64 = 3.0;
/// Height of a scan over the longer side of the array.
const RISE: f64 = 0.6;
/// Σy⁴ M/(Σy²)² of readings that a focus dominates: 2 for a random field.
const FOCUSED: f64 = 6.0;

/// A scan to be made: rows of places on planes parallel to z = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    /// m, of the planes above z = 0.
    pub heights: Vec<f64>,
    /// m, of the middle of the planes.
    pub middle: DVec2,
    /// m, the sides of the planes.
    pub size: DVec2,
    /// m, between neighbouring places.
    pub step: f64,
}

impl Raster {
    /// A plane over a scene's array, half a wavelength from place to place.
    pub fn over(scene: &Scene) -> Self {
        let aperture = Aperture::new(scene);
        let grow = |(low, high): (DVec3, DVec3), at: &DVec3| (low.min(*at), high.max(*at));
        let (low, high) = aperture.positions.iter().fold((DVec3::MAX, DVec3::MIN), grow);
        let size = (high - low).truncate() + aperture.pitch;
        let above = (RISE * size.max_element()).max(NEAREST * aperture.wavelength());
        // Boards that face each other are scanned half way between them.
        let height = if high.z - low.z > 2.0 * above { (low.z + high.z) / 2.0 } else { high.z + above };
        Self {
            heights: vec![height],
            middle: (low + high).truncate() / 2.0,
            size,
            step: aperture.wavelength() / 2.0,
        }
    }

    /// The places, plane by plane and row by row, back and forth.
    pub fn places(&self) -> Vec<DVec3> {
        let count = |length: f64| (length / self.step).round().max(1.0) as usize;
        let (columns, rows) = (count(self.size.x), count(self.size.y));
        let along = |index: usize, count: usize| (index as f64 - (count - 1) as f64 / 2.0) * self.step;
        let mut places = Vec::with_capacity(self.heights.len() * columns * rows);
        for &height in &self.heights {
            for row in 0..rows {
                for column in 0..columns {
                    let column = if row % 2 == 0 { column } else { columns - 1 - column };
                    let place = self.middle + DVec2::new(along(column, columns), along(row, rows));
                    places.push(place.extend(height));
                }
            }
        }
        places
    }
}

/// Drives at full amplitude with random phases, each one of some levels of a turn, so that a board that has them plays
/// just these. Equal seeds make equal drives.
pub fn random_drives(scene: &Scene, count: usize, levels: u16, seed: u64) -> Vec<Drive> {
    let levels = u64::from(levels.max(2));
    let mut state = seed;
    // SplitMix64 (Steele, Lea and Flood, 2014): its sequence will be the same in years.
    let mut next = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = state;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    };
    let driven = scene.driven();
    let mut drive = || {
        let phases: Vec<_> = driven
            .iter()
            .map(|_| Complex64::from_polar(1.0, TAU * (next() % levels) as f64 / levels as f64))
            .collect();
        Drive::uniform(scene.elements(), &driven, &phases)
    };
    (0..count).map(|_| drive()).collect()
}

/// One drive per driven element, which sounds alone.
pub fn single_drives(scene: &Scene) -> Vec<Drive> {
    let driven = scene.driven();
    driven.iter().map(|&n| Drive::uniform(scene.elements(), &[n], &[Complex64::ONE])).collect()
}

/// The outlook of a scan: what is to be found of the gains and the bench.
#[derive(Clone, Debug)]
pub struct Bound {
    /// The fit of equal elements, with the standard errors of the assumed noise.
    pub fit: Fit,
    /// Whether a focus dominates the readings.
    pub is_focused: bool,
}

/// The Cramér-Rao bound of a scan at a signal-to-noise ratio (dB).
///
/// # Errors
/// As [`crate::measure::fit()`].
pub fn bound(
    scene: &Scene,
    drives: &[Drive],
    points: &[DVec3],
    of: &[usize],
    is_complex: bool,
    signal_to_noise: f64,
) -> Result<Bound, MeasureError> {
    let forward = Forward::new(scene, drives, points, of)?;
    let ones = vec![Complex64::ONE; forward.elements()];
    let pressures = forward.pressures_at(&forward.nominal, &ones);
    let readings = match is_complex {
        true => Readings::Complex(pressures),
        false => Readings::Moduli(pressures.iter().map(|p| p.norm()).collect()),
    };
    let is_focused = is_focused(&readings);
    let fit = expected(scene, &forward, &readings, 10f64.powf(-signal_to_noise / 20.0))?;
    Ok(Bound { fit, is_focused })
}

/// Whether a few readings are much louder than the others, as those of a focus: what is then known of the side lobes hardly
/// tells the phases of the elements.
pub fn is_focused(readings: &Readings) -> bool {
    let squares: Vec<f64> = readings.moduli().iter().map(|modulus| modulus * modulus).collect();
    let (sum, fourth) = squares.iter().fold((0.0, 0.0), |(sum, fourth), s| (sum + s, fourth + s * s));
    fourth * squares.len() as f64 > FOCUSED * sum * sum
}
