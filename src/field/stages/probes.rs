//! Places of a map at which it is compared with the f64 reference.

use num_complex::Complex64;

use crate::acoustics::Transfer;
use crate::field::quantity::{Constants, Norm, Quantity, Sound};
use crate::field::slope::Around;
use crate::field::stages::request::Request;
use crate::field::stages::site::{Site, SiteKey};

/// Places at which the reached error is measured.
pub const PROBES: usize = 48;

/// Pixels, or cells of a liquid, with their f64 transfer from every element.
#[derive(Debug)]
pub(super) struct Probes {
    /// Their numbers, row by row.
    pub(super) places: Vec<usize>,
    around: Around,
    /// To each probe, and to what slopes there need beside it.
    transfer: Transfer,
}

/// What a map has at its probes.
#[derive(Clone, Debug, Default)]
pub(super) struct AtProbes {
    /// The values; at cells of a liquid what presses it.
    pub(super) values: Vec<f32>,
    /// The sound of a single drive that is formed at the pixels.
    pub(super) sounds: Option<Vec<Sound>>,
}

impl Probes {
    /// Spread without pattern over the pixels, or over the cells of a liquid that lie on the plane.
    pub(super) fn new(key: &SiteKey, site: &Site, (width, height): (usize, usize), of_liquid: bool) -> Self {
        let plane = &key.setting.plane;
        let (mut places, mut points) = (Vec::new(), Vec::new());
        let mut add = |place: usize, x: f64, y: f64| {
            places.push(place);
            points.push(plane.centre + site.axes[0] * x + site.axes[1] * y);
        };
        match &site.cells {
            Some(filled) if of_liquid => {
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
                for pixel in spread(width * height) {
                    let x = place(pixel % width, width, plane.size.x);
                    add(pixel, x, place(pixel / width, height, plane.size.y));
                }
            }
        }
        let around = Around::new(key.parts, site.axes, key.setting.aperture.wavelength());
        let transfer = key.setting.aperture.transfer(&around.points(&points));
        Self { places, around, transfer }
    }

    /// The largest deviation, relative to `peak`: of the values, or of what the quantity's norm says.
    pub(super) fn error(
        &self,
        (request, excitations): (&Request, &[Vec<Complex64>]),
        got: &AtProbes,
        peak: f32,
    ) -> f64 {
        let peak = f64::from(peak).max(f64::MIN_POSITIVE);
        let (quantity, constants) = (request.quantity, request.constants());
        if let ([excitation], Some(sounds)) = (excitations, &got.sounds) {
            let expected = self.sounds(excitation);
            let off = expected.iter().zip(sounds).map(|(expected, got)| less(expected, got));
            let norm = |off: Sound| match quantity.declaration().norm {
                Norm::Value => Some(f64::from(quantity.of(off, &constants))),
                Norm::Pressure => Some(f64::from(off.p.norm())),
                Norm::Difference => None,
            };
            if let Some(norms) = off.map(norm).collect::<Option<Vec<_>>>() {
                return norms.into_iter().fold(0.0, f64::max) / peak;
            }
        }
        let mut means = vec![0.0; self.places.len()];
        for excitation in excitations {
            for (mean, sound) in means.iter_mut().zip(self.sounds(excitation)) {
                *mean += formula(quantity, sound, &constants) / excitations.len() as f64;
            }
        }
        let part = if quantity.declaration().of_liquid { 1.0 } else { request.part };
        let off = |(mean, got): (f64, &f32)| f64::from((quantity.value((part * mean) as f32) - got).abs());
        means.into_iter().zip(&got.values).map(off).fold(0.0, f64::max) / peak
    }

    /// The sound of one drive at the probes, in f64 but for its last rounding.
    fn sounds(&self, excitation: &[Complex64]) -> Vec<Sound> {
        self.around.sounds(&self.transfer.pressure(excitation))
    }
}

/// The formula's value before it is averaged.
fn formula(quantity: Quantity, sound: Sound, constants: &Constants) -> f64 {
    let value = f64::from(quantity.of(sound, constants));
    if quantity.declaration().is_root { value * value } else { value }
}

fn less(a: &Sound, b: &Sound) -> Sound {
    Sound { p: a.p - b.p, x: a.x - b.x, y: a.y - b.y, n: a.n - b.n }
}

/// So many places of a raster, spread by the golden ratio.
fn spread(places: usize) -> impl Iterator<Item = usize> {
    const GOLDEN: f64 = 0.618_033_988_749_894_8;
    (1..=PROBES).map(move |i| ((i as f64 * GOLDEN).fract() * places as f64) as usize)
}
