//! The f32 CPU evaluator, on all cores.

mod places;
mod sums;
mod waves;

use num_complex::Complex32;
use rayon::prelude::*;

use crate::field::sources::{FEW_DECAY, FEW_DIRECTIVITY, Form, Sources, Wave};
use crate::simd::Isa;
use waves::{ExactPiston, FarField, OF_COSINE, RECTANGLE, ROUND, Sum};

pub use places::{Law, places};
pub use sums::{DRIVES, Lines, OVERHANG, ROWS, Rows, Split, Term, superpose, weighted_sums};
pub use waves::{LANES, Points};

/// Complex pressure (Pa, peak) of all boards together at every one of `count` samples.
pub fn pressure(faces: &[Sources<'_>], count: usize) -> Vec<Complex32> {
    pressure_with(Isa::best(), faces, count)
}

/// Like [`pressure`], with one of the sets in [`Isa::available`].
pub fn pressure_with(isa: Isa, faces: &[Sources<'_>], count: usize) -> Vec<Complex32> {
    let mut field = vec![Complex32::ZERO; count];
    field.par_chunks_mut(LANES).enumerate().for_each(|(index, chunk)| {
        for Sources { wave, elements, tilts, samples } in faces {
            let points = Points::new(wave, chunk.len(), |lane| samples.point(index * LANES + lane));
            let sum = block(isa, wave, (elements, tilts), &points);
            for (p, (re, im)) in chunk.iter_mut().zip(sum.re.iter().zip(&sum.im)) {
                *p += Complex32::new(*re, *im);
            }
        }
    });
    field
}

/// The waves of single elements of a board, with their tilts, at a block of points: passes to `take` the element's
/// index and real and imaginary parts of the complex pressures (Pa, peak).
pub fn single_waves(
    wave: &Wave,
    (elements, tilts): (&[[f32; 4]], &[[f32; 4]]),
    points: &Points,
    mut take: impl FnMut(usize, (&[f32; LANES], &[f32; LANES])),
) {
    for (number, element) in elements.chunks_exact(1).enumerate() {
        let tilt = if wave.is_flat { &[][..] } else { &tilts[number..=number] };
        let sum = block(Isa::best(), wave, (element, tilt), points);
        take(number, (&sum.re, &sum.im));
    }
}

/// A block by the common case, the general one (sharp directivity, strong absorption), or the exact piston.
fn block(isa: Isa, wave: &Wave, (elements, tilts): (&[[f32; 4]], &[[f32; 4]]), points: &Points) -> Sum {
    let sum = match (&wave.piston, wave.form) {
        (None, Form::Round) => far_field::<ROUND>(isa, wave, (elements, tilts), points),
        (None, Form::Cosine) => far_field::<OF_COSINE>(isa, wave, (elements, tilts), points),
        (None, Form::Rectangle) => far_field::<RECTANGLE>(isa, wave, (elements, tilts), points),
        (Some(piston), _) => isa.run(ExactPiston { piston, wave, elements, points }),
    };
    sum.onward(points)
}

fn far_field<const FORM: usize>(
    isa: Isa,
    wave: &Wave,
    (elements, tilts): (&[[f32; 4]], &[[f32; 4]]),
    points: &Points,
) -> Sum {
    const FEW: usize = FEW_DIRECTIVITY;
    let is_common = wave.directivity.iter().all(|part| part.terms <= FEW) && wave.decay.terms <= FEW_DECAY;
    match (is_common, wave.is_flat) {
        (true, true) => isa.run(FarField::<FORM, FEW, FEW_DECAY, true> { wave, elements, tilts, points }),
        (false, true) => isa.run(FarField::<FORM, 24, 16, true> { wave, elements, tilts, points }),
        (true, false) => isa.run(FarField::<FORM, FEW, FEW_DECAY, false> { wave, elements, tilts, points }),
        (false, false) => isa.run(FarField::<FORM, 24, 16, false> { wave, elements, tilts, points }),
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, dvec3};

    use super::*;
    use crate::acoustics::Aperture;
    use crate::drive::Drive;
    use crate::field::samples::Samples;
    use crate::scene::{Array, Elements, Placed, Scene};

    /// Elements at several heights, which radiate in as many directions.
    fn curved() -> Array {
        let placed = |x: f64, y: f64, z: f64| {
            let at = dvec3(x, y, z);
            Placed { at, normal: (dvec3(0.01, 0.0, 0.06) - at).normalize_or_zero() }
        };
        let placed = [placed(-0.04, 0.0, 0.02), placed(0.0, 0.01, -0.03), placed(0.03, -0.02, 0.0)].to_vec();
        let placed = Elements::new(placed, None);
        Array { placed, file: Some("curved.csv".to_owned()), ..Array::default() }
    }

    #[test]
    fn single_waves_add_up_to_the_field() {
        let aperture = Aperture::new(&Scene { array: curved(), ..Scene::default() });
        let drive = Drive { amplitudes: vec![1.0; 3], phases: vec![0.2, -0.9, 1.4] };
        let samples = Samples::at((0..LANES).map(|i| DVec3::Z * (0.05 + 1e-3 * i as f64)).collect());
        let sources = Sources::of_faces(&aperture, &drive, &samples).unwrap();
        let Sources { wave, elements, tilts, samples: own } = &sources[0];
        let points = Points::new(wave, LANES, |lane| own.point(lane));
        let mut sum = [Complex32::ZERO; LANES];
        single_waves(wave, (elements, tilts), &points, |_, (re, im)| {
            for (lane, sum) in sum.iter_mut().enumerate() {
                *sum += Complex32::new(re[lane], im[lane]);
            }
        });
        for (sum, p) in sum.iter().zip(pressure(&sources, LANES)) {
            assert!((sum - p).norm() < 1e-5 * p.norm().max(1.0), "{sum}, not {p}");
        }
    }
}
