//! A map by its plan: samples, interpolation, and the error that was reached.

use std::ops::Range;

use num_complex::{Complex32, Complex64};

use crate::acoustics::Aperture;
use crate::drive::Drive;
use crate::field::interpolation::interpolate;
use crate::field::{Gpu, GpuError, Plan, Samples, Sources, cpu, gpu::GpuField, reference};

/// Pixels at which the reached error is measured.
const PROBES: usize = 48;

/// Complex pressure (Pa, peak) of every pixel, row by row, by the CPU.
pub fn on_cpu(plan: &Plan, aperture: &Aperture, drive: &Drive) -> Vec<Complex32> {
    let evaluate = |samples: &Samples| match Sources::new(aperture, drive, samples) {
        Some(sources) if !plan.double => cpu::pressure(&sources, samples),
        // What f32 cannot do well, f64 does slowly.
        _ => reference::pressure(aperture, drive, samples).into_iter().map(narrow).collect(),
    };
    let Some(grid) = &plan.grid else { return evaluate(&plan.pixels()) };
    let mut field = Vec::with_capacity(plan.width * plan.height);
    let direct =
        |rows: Range<usize>| if rows.is_empty() { Vec::new() } else { evaluate(&plan.pixel_rows(rows)) };
    field.extend(direct(0..plan.interpolated.start));
    field.extend(interpolate(&evaluate(&grid.samples), grid.samples.columns.len(), &grid.across, &grid.up));
    field.extend(direct(plan.interpolated.end..plan.height));
    field
}

/// The same by the f64 reference at every pixel.
pub fn by_reference(plan: &Plan, aperture: &Aperture, drive: &Drive) -> Vec<Complex32> {
    reference::pressure(aperture, drive, &plan.pixels()).into_iter().map(narrow).collect()
}

/// The same by the GPU, where the map stays. `None` where the plan needs f64.
///
/// # Errors
/// The device was lost or has not enough memory.
pub fn on_gpu<'a>(
    gpu: &'a Gpu,
    plan: &Plan,
    aperture: &Aperture,
    drive: &Drive,
) -> Result<Option<GpuField<'a>>, GpuError> {
    if plan.double {
        return Ok(None);
    }
    let Some(grid) = &plan.grid else {
        let pixels = plan.pixels();
        return Sources::new(aperture, drive, &pixels)
            .map(|sources| gpu.pressure(&sources, &pixels))
            .transpose();
    };
    let Some(sources) = Sources::new(aperture, drive, &grid.samples) else { return Ok(None) };
    let samples = gpu.pressure(&sources, &grid.samples)?;
    let mut field = GpuField::empty(gpu);
    for (rows, is_interpolated) in [
        (0..plan.interpolated.start, false),
        (plan.interpolated.clone(), true),
        (plan.interpolated.end..plan.height, false),
    ] {
        if rows.is_empty() {
            continue;
        }
        if is_interpolated {
            field.append(samples.interpolated(&grid.across, &grid.up, grid.samples.columns.len())?);
        } else {
            let pixels = plan.pixel_rows(rows);
            let Some(sources) = Sources::new(aperture, drive, &pixels) else { return Ok(None) };
            field.append(gpu.pressure(&sources, &pixels)?);
        }
    }
    Ok(Some(field))
}

/// Pixels, spread without pattern, at which to measure the error.
pub fn probes(plan: &Plan) -> Vec<usize> {
    const GOLDEN: f64 = 0.618_033_988_749_894_8;
    let pixels = plan.width * plan.height;
    (1..=PROBES).map(|i| ((i as f64 * GOLDEN).fract() * pixels as f64) as usize).collect()
}

/// The largest deviation of `values` at the pixels `probes` from the f64 reference, relative to `peak` (Pa).
pub fn measured_error(
    plan: &Plan,
    aperture: &Aperture,
    drive: &Drive,
    probes: &[usize],
    values: &[Complex32],
    peak: f32,
) -> f64 {
    let pixels = plan.pixels();
    let points = Samples::at(probes.iter().map(|&pixel| pixels.point(pixel)).collect());
    let off = |(expected, got): (Complex64, &Complex32)| {
        (expected - Complex64::new(got.re.into(), got.im.into())).norm()
    };
    let largest =
        reference::pressure(aperture, drive, &points).into_iter().zip(values).map(off).fold(0.0, f64::max);
    largest / f64::from(peak).max(f64::MIN_POSITIVE)
}

fn narrow(p: Complex64) -> Complex32 {
    Complex32::new(p.re as f32, p.im as f32)
}
