//! Contour lines of a map, found where its pixels are and kept until these differ.

use num_complex::Complex32;

use crate::field::contour::{self, Line};
use crate::field::stages::{By, Drawn, FieldError, Stages, Wanted};
use crate::field::{Map, Quantity};

impl Stages {
    /// The lines on which an amount that is shown of the field is this part of its largest; the map is brought up to date first.
    ///
    /// # Errors
    /// As [`Stages::map`].
    pub fn contours(
        &mut self,
        wanted: &Wanted<'_>,
        quantity: Quantity,
        part: f32,
    ) -> Result<&[Line], FieldError> {
        let Map { by, peak, .. } = *self.map(wanted)?;
        let largest = quantity.of(Complex32::from(peak));
        let key = (Drawn::new(wanted, self.exact), quantity, part);
        let Self { contours, gpu, cpu, work, .. } = self;
        let lines = contours.try_update(&key, |lines| {
            work.contours += 1;
            let read;
            let field = match gpu {
                Some(gpu) if by == By::Gpu => {
                    read = gpu.read()?;
                    &read
                }
                _ => cpu.field(),
            };
            *lines = of_pixels(field, wanted.width, quantity, part * largest);
            Ok::<_, FieldError>(())
        })?;
        Ok(lines)
    }
}

/// The lines of pixels as they are, without keeping them.
pub(super) fn of_pixels(pixels: &[Complex32], width: usize, quantity: Quantity, level: f32) -> Vec<Line> {
    match quantity {
        // One loop without a choice in it each, so that they become vector code.
        Quantity::Rms => {
            let peak = level / quantity.of(Complex32::ONE);
            contour::lines(pixels, width, peak, |p| (p.re * p.re + p.im * p.im).sqrt())
        }
        Quantity::Dent => contour::lines(pixels, width, level, |p| p.re),
        Quantity::Radiation => contour::lines(pixels, width, level, |p| p.im),
        _ => contour::lines(pixels, width, level, |&p| quantity.of(p)),
    }
}
