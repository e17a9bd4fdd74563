//! The field in f64 by the transfer itself: the reference of the fast evaluators.

use glam::DVec3;
use num_complex::Complex64;
use rayon::prelude::*;

use crate::acoustics::{Aperture, Face};
use crate::drive::Drive;
use crate::field::samples::Samples;
use crate::gauge::Gauge;

/// Complex pressure (Pa, peak) at every sample; within bodies not a number.
pub fn pressure(aperture: &Aperture, drive: &Drive, samples: &Samples) -> Vec<Complex64> {
    let mut field = of_elements(aperture, drive, samples);
    if !aperture.bodies.is_empty() {
        let points: Vec<_> = (0..samples.len()).map(|index| samples.point(index)).collect();
        let scattered = aperture.scattered((&points, &[]), &drive.excitation(&aperture.driven));
        field.iter_mut().zip(scattered.unwrap_or_default()).for_each(|(sum, p)| *sum += p);
    }
    field
}

/// The same without bodies.
pub(crate) fn of_elements(aperture: &Aperture, drive: &Drive, samples: &Samples) -> Vec<Complex64> {
    let excitation = drive.excitation(&aperture.driven);
    let counter = Gauge::current().count(samples.len());
    let of_face = |face: &Face, point: DVec3| {
        let local = face.pose.local(point);
        let columns = face.among(&aperture.driven);
        let from = |(&n, u): (&usize, &Complex64)| {
            let n = n - face.first;
            let offset = local - face.layout.positions[n];
            let wave = match face.layout.is_flat() {
                true => aperture.element.transfer(offset),
                false => aperture.element.towards(offset, face.layout.normal(n), face.layout.aside(n)),
            };
            wave * u
        };
        let pairs = aperture.driven[columns.clone()].iter().zip(&excitation[columns]);
        let sum: Complex64 = pairs.filter(|(_, u)| **u != Complex64::ZERO).map(from).sum();
        sum * face.gain
    };
    let at = |index: usize| {
        counter.add();
        let point = samples.point(index);
        aperture.faces.iter().map(|face| of_face(face, point)).sum()
    };
    (0..samples.len()).into_par_iter().map(at).collect()
}
