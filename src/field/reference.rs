//! The field in f64 by the transfer itself: what the fast evaluators are held to.

use num_complex::Complex64;
use rayon::prelude::*;

use crate::acoustics::Aperture;
use crate::drive::Drive;
use crate::field::Samples;
use crate::gauge::Gauge;

/// Complex pressure (Pa, peak) at every sample.
pub fn pressure(aperture: &Aperture, drive: &Drive, samples: &Samples) -> Vec<Complex64> {
    let excitation = drive.excitation(&aperture.driven);
    let counter = Gauge::current().count(samples.len());
    let at = |index: usize| {
        counter.add();
        let point = samples.point(index);
        let from = |(&n, u): (&usize, &Complex64)| {
            aperture.element.transfer(point - aperture.positions[n].extend(0.0)) * u
        };
        aperture.driven.iter().zip(&excitation).filter(|(_, u)| **u != Complex64::ZERO).map(from).sum()
    };
    (0..samples.len()).into_par_iter().map(at).collect()
}
