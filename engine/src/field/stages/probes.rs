//! Pixels of a map for comparison with the f64 reference.

use glam::{DVec2, DVec3};
use num_complex::Complex64;

use crate::acoustics::Aperture;
use crate::field::quantity::{Constants, Mean, Norm, PRESSURE, Quantity, Sound};
use crate::field::slope::SoundTransfer;
use crate::field::stages::request::Request;
use crate::field::stages::site::{Site, SiteKey};
use crate::field::vicinity::LeftOut;
use crate::scene::Plane;

/// Number of scattered probes.
const SPREAD: usize = 48;
/// Number of elements next to which a plane is probed, of those within this many wavelengths. Positions are rounded
/// to f32, which matters only at small distances from an element.
const BESIDE: usize = 12;
const NEAR: f64 = 3.0;
/// Below this every value is silence, since f32 has no room for its square.
const FAINTEST: f64 = 1e-18;
/// Squares below this part of the largest are excluded: their errors do not represent the loud regions.
const FAINT: f64 = 0.01;
/// The largest error of all pixels is less than this times the largest of the probes.
pub(super) const MARGIN: f64 = 3.0;
/// Sums in f32 are off by this part of the peak where the map is loudest, which may lie between the probes.
const ROUNDING: f64 = 4.0 * f32::EPSILON as f64;
/// Rounding of a slope in f64 over that of the pressure, both of the magnitudes of a plane wave.
const OF_SLOPES: f64 = 4.0;

/// Pixels, or cells of a liquid or the skin, with their f64 transfer from every element.
#[derive(Debug)]
pub(super) struct Probes {
    /// Their numbers, row by row.
    pub(super) places: Vec<usize>,
    /// Whether each counts for the peak.
    counts: Vec<bool>,
    /// m; the longest path to any of them.
    farthest: f64,
    sound: SoundTransfer,
}

/// The norm of the error of a sound.
type SoundNorm = fn(Quantity, Sound<f64>, &Constants<f64>) -> f64;

/// A map's results at its probes.
#[derive(Clone, Debug, Default)]
pub(super) struct AtProbes {
    /// The values; at cells of a liquid or the skin, the radiation pressure.
    pub(super) values: Vec<f32>,
    /// The sound of every drive, of quantities formed at the pixels.
    pub(super) sounds: Option<Vec<Vec<Sound>>>,
    /// Error bound of all other pixels, where it is known.
    pub(super) elsewhere: f64,
}

impl Probes {
    /// Scattered over the pixels, or over the cells of a liquid or the skin on the plane.
    pub(super) fn new(
        key: &SiteKey,
        site: &Site,
        ((width, height), left_out): ((usize, usize), &LeftOut),
        (is_pressed, is_compared): (bool, bool),
    ) -> Self {
        let plane = &key.setting.plane;
        let aperture = &key.setting.aperture;
        let (mut places, mut points) = (Vec::new(), Vec::new());
        let mut add = |place: usize, x: f64, y: f64| {
            let at = plane.centre + site.axes[0] * x + site.axes[1] * y;
            if !aperture.bodies.contains(at) {
                places.push(place);
                points.push(at);
            }
        };
        match &site.cells {
            _ if !is_compared => {}
            Some(filled) if is_pressed => {
                let along = [0, 1].map(|axis| filled.cells.places(axis).collect::<Vec<_>>());
                let shown = [0, 1].map(|axis| -> Vec<usize> {
                    let is_shown = |&i: &usize| along[axis][i].abs() <= plane.size[axis] / 2.0;
                    let shown: Vec<_> = (0..along[axis].len()).filter(is_shown).collect();
                    if shown.is_empty() { vec![along[axis].len() / 2] } else { shown }
                });
                for probe in spread(shown[0].len() * shown[1].len()) {
                    let (i, j) = (shown[0][probe % shown[0].len()], shown[1][probe / shown[0].len()]);
                    add(j * along[0].len() + i, along[0][i], along[1][j]);
                }
            }
            Some(_) | None => {
                let place =
                    |i: usize, count: usize, length: f64| length * ((i as f64 + 0.5) / count as f64 - 0.5);
                let mut pixels: Vec<_> = spread(width * height).collect();
                pixels.extend(corners((width, height)));
                pixels.extend(beside_elements(key, site.axes, (width, height)));
                pixels.sort_unstable();
                pixels.dedup();
                for pixel in pixels {
                    let x = place(pixel % width, width, plane.size.x);
                    add(pixel, x, place(pixel / width, height, plane.size.y));
                }
            }
        }
        let sound = SoundTransfer::new(aperture, key.parts, site.axes, &points);
        let counts = places.iter().map(|&place| !left_out.contains(place)).collect();
        Self { places, counts, farthest: farthest(aperture, plane), sound }
    }

    /// An estimate of the largest deviation of all pixels, relative to `peak` or to a louder pixel itself: of the
    /// values, or of the quantity's norm.
    pub(super) fn error(
        &self,
        (request, excitations): (&Request, &[Vec<Complex64>]),
        got: &AtProbes,
        peak: f32,
    ) -> f64 {
        let off = (MARGIN * self.off((request, excitations), got, f64::from(peak))).max(got.elsewhere);
        match peak {
            0.0 if off < MARGIN * FAINTEST => 0.0,
            0.0 => f64::INFINITY,
            peak => (off / f64::from(peak)).max(ROUNDING),
        }
    }

    /// A bound of the rounding in f64 of the values that count for the peak, for sums whose terms may cancel.
    pub(super) fn rounding(&self, (request, excitations): (&Request, &[Vec<Complex64>])) -> f64 {
        let (quantity, constants) = (request.quantity, request.constants());
        let declaration = quantity.declaration();
        let wavenumber = request.aperture.element.wavenumber;
        let rows = self.sound.pressure_rows().zip(&self.counts).filter(|(_, counts)| **counts);
        let loudest = largest_sum(rows.map(|(row, _)| row), excitations);
        let lost = if declaration.parts == PRESSURE { 1.0 } else { OF_SLOPES };
        let relative = lost * rounding_of_terms(wavenumber * self.farthest);
        let p = Complex64::from(loudest);
        let slope = Complex64::new(0.0, -wavenumber * loudest);
        let all = Sound { p, x: slope, y: slope, n: slope };
        let exact = |sound| (declaration.exact)(sound, &constants).abs();
        match declaration.norm {
            Norm::Pressure => relative * loudest,
            Norm::Value => relative * quantity.exact_value(exact(all)),
            // A square doubles the relative error, and its terms may cancel, too.
            Norm::Difference => {
                let own = Sound { p, ..Sound::default() };
                let slopes = Sound { p: Complex64::ZERO, ..all };
                2.0 * relative * request.part * (exact(all) + exact(own) + exact(slopes))
            }
        }
    }

    /// The largest deviation of the probes.
    fn off(&self, (request, excitations): (&Request, &[Vec<Complex64>]), got: &AtProbes, peak: f64) -> f64 {
        let part_of = |off: f64, own: f64| if own > peak && peak > 0.0 { off * peak / own } else { off };
        let (quantity, constants) = (request.quantity, request.constants());
        let declaration = quantity.declaration();
        let norm: Option<SoundNorm> = match declaration.norm {
            Norm::Value => {
                Some(|quantity, sound, constants| (quantity.declaration().exact)(sound, constants))
            }
            Norm::Pressure => Some(|_, sound, _| sound.p.norm()),
            Norm::Difference => None,
        };
        if let (Some(norm), Some(sounds)) = (norm, &got.sounds) {
            // Of the error, and of the sound itself.
            let mut means = vec![[0.0; 2]; self.places.len()];
            for (excitation, sounds) in excitations.iter().zip(sounds) {
                let expected = self.sound.sounds(excitation);
                for (means, (expected, got)) in means.iter_mut().zip(expected.iter().zip(sounds)) {
                    for (mean, sound) in means.iter_mut().zip([expected.less(got), *expected]) {
                        *mean += norm(quantity, sound, &constants) / excitations.len() as f64;
                    }
                }
            }
            let off = |means: [f64; 2]| {
                let [off, own] = means.map(|mean| quantity.exact_value(mean));
                part_of(off, own)
            };
            return means.into_iter().map(off).fold(0.0, f64::max);
        }
        let mut means = vec![Means::default(); self.places.len()];
        for excitation in excitations {
            for (mean, sound) in means.iter_mut().zip(self.sound.sounds(excitation)) {
                mean.value.add(declaration, sound, &constants, excitations.len());
                mean.square += sound.p.norm_sqr() / excitations.len() as f64;
            }
        }
        let part = if declaration.is_pressed() { 1.0 } else { request.part };
        let counted = means.iter().zip(&self.counts).filter(|(_, counts)| **counts);
        let loudest = counted.fold(f64::MIN_POSITIVE, |most, (mean, _)| most.max(mean.square));
        let off = |(mean, &got): (Means, &f32)| {
            let value = quantity.exact_value(part * mean.value.of(declaration));
            let off = part_of((value - f64::from(got)).abs(), value.abs());
            match declaration.norm {
                // The error of a pressure is weighted by the pressure itself.
                Norm::Difference => off / (mean.square / loudest).clamp(FAINT, 1.0).sqrt(),
                Norm::Value | Norm::Pressure => off,
            }
        };
        means.into_iter().zip(&got.values).map(off).fold(0.0, f64::max)
    }
}

/// Means over the drives.
#[derive(Clone, Copy, Debug, Default)]
struct Means {
    /// Mean of the formula.
    value: Mean,
    /// Mean of |P|²/(ρc²), Pa; for a potential with |∇P|²/(ρω²).
    square: f64,
}

/// m; a bound of the paths to a plane.
pub(super) fn farthest(aperture: &Aperture, plane: &Plane) -> f64 {
    let positions = aperture.faces.iter().flat_map(|face| {
        face.layout.positions.iter().map(move |&at| face.pose.world(at).distance(plane.centre))
    });
    positions.fold(0.0, f64::max) + plane.size.length()
}

/// The largest sum of the magnitudes of H u at some points, without cancellation, of all drives.
pub(super) fn largest_sum<Row: Iterator<Item = Complex64> + Clone>(
    rows: impl Iterator<Item = Row>,
    excitations: &[Vec<Complex64>],
) -> f64 {
    rows.fold(0.0, |largest: f64, row| {
        let sum = |excitation: &Vec<Complex64>| -> f64 {
            row.clone().zip(excitation).map(|(h, u)| h.norm() * u.norm()).sum()
        };
        excitations.iter().map(sum).fold(largest, f64::max)
    })
}

/// The rounding in f64, relative to that sum, of waves with phases up to this one (rad).
pub(super) fn rounding_of_terms(phase: f64) -> f64 {
    /// Roundings of a term besides that of its phase.
    const OTHERS: f64 = 16.0;
    f64::EPSILON * (OTHERS + phase)
}

/// The farthest ways.
pub(super) fn corners((width, height): (usize, usize)) -> [usize; 4] {
    let last = (height - 1) * width;
    [0, width - 1, last, last + width - 1]
}

/// The pixels around the point of the plane nearest to an element, two on each side, for the elements closest to it:
/// rounding in the four nearest may be small by chance.
fn beside_elements(
    key: &SiteKey,
    [x, y, _]: [DVec3; 3],
    (width, height): (usize, usize),
) -> impl Iterator<Item = usize> {
    let (plane, aperture) = (&key.setting.plane, &key.setting.aperture);
    let half = plane.size / 2.0;
    let nearest = |at: &DVec3| {
        let from_centre = *at - plane.centre;
        let place = DVec2::new(from_centre.dot(x), from_centre.dot(y)).clamp(-half, half);
        (from_centre.distance(x * place.x + y * place.y), place)
    };
    let mut near: Vec<_> = aperture.positions.iter().map(nearest).collect();
    near.retain(|(distance, _)| *distance < NEAR * aperture.wavelength());
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    near.truncate(BESIDE);
    let around = move |place: f64, length: f64, count: usize| {
        let low = ((place / length + 0.5) * count as f64 - 0.5).max(0.0) as usize;
        [low.saturating_sub(1), low, low + 1, low + 2].map(|pixel| pixel.min(count - 1))
    };
    near.into_iter().flat_map(move |(_, place)| {
        let columns = around(place.x, 2.0 * half.x, width);
        let rows = around(place.y, 2.0 * half.y, height);
        rows.into_iter().flat_map(move |row| columns.map(|column| row * width + column))
    })
}

/// This number of indices of a raster, scattered by the golden ratio.
pub(super) fn spread(places: usize) -> impl Iterator<Item = usize> {
    const GOLDEN: f64 = 0.618_033_988_749_894_8;
    (1..=SPREAD).map(move |i| ((i as f64 * GOLDEN).fract() * places as f64) as usize)
}
