//! A map by its plan: samples, interpolation, and the error that was reached.

use std::ops::Range;

use num_complex::{Complex32, Complex64};

use crate::acoustics::Aperture;
use crate::drive::Drive;
use crate::field::interpolation::interpolate;
use crate::field::{self, Gpu, GpuError, Plan, Samples, Sources, gpu::GpuField, reference};

/// Pixels at which the reached error is measured.
pub const PROBES: usize = 48;
/// Rounding is spread evenly, so that the largest error of all pixels is less than this times the largest of [`PROBES`].
const PROBE_MARGIN: f64 = 2.0;

/// A map, and how well it keeps the tolerance.
#[derive(Clone, Debug, PartialEq)]
pub struct Map<F> {
    pub plan: Plan,
    pub field: F,
    /// The largest |P|, Pa.
    pub peak: f32,
    /// The largest deviation from the f64 reference at 48 pixels, relative to the peak. The largest of all pixels can be
    /// several times that: six times was seen.
    pub error: f64,
}

/// Complex pressure (Pa, peak) of every pixel, row by row, by the CPU.
///
/// Where f32 has no room for the elements, samples are evaluated in f64. Rounding in f32 is relative to what arrives, and where the elements cancel, the peak is less than that; the map is
/// then made again in f64. A `tolerance` of 0 takes f32 as it is.
pub fn by_cpu(plan: Plan, aperture: &Aperture, drive: &Drive, tolerance: f64) -> Map<Vec<Complex32>> {
    let declined = Sources::new(aperture, drive, &plan.pixels()).is_none();
    let plan = if declined { plan.in_f64() } else { plan };
    let field = on_cpu(&plan, aperture, drive);
    let map = measured(plan, field, aperture, drive);
    if !map.plan.double && rounds_too_much(map.error, tolerance) {
        return by_cpu(map.plan.in_f64(), aperture, drive, tolerance);
    }
    map
}

/// The same by the GPU, where the field stays. `None` where the tolerance needs f64.
///
/// # Errors
/// The device was lost or has not enough memory.
pub fn by_gpu<'a>(
    gpu: &'a Gpu,
    plan: &Plan,
    aperture: &Aperture,
    drive: &Drive,
    tolerance: f64,
) -> Result<Option<Map<GpuField<'a>>>, GpuError> {
    let Some(field) = on_gpu(gpu, plan, aperture, drive)? else { return Ok(None) };
    let (peak, probes) = (field.peak()?, probes(plan));
    let error = measured_error(plan, aperture, drive, &probes, &field.at(&probes)?, peak);
    Ok((!rounds_too_much(error, tolerance)).then(|| Map { plan: plan.clone(), field, peak, error }))
}

fn rounds_too_much(error: f64, tolerance: f64) -> bool {
    tolerance > 0.0 && PROBE_MARGIN * error > tolerance
}

fn on_cpu(plan: &Plan, aperture: &Aperture, drive: &Drive) -> Vec<Complex32> {
    let evaluate = |samples: &Samples| field::on_cpu(aperture, drive, samples, plan.double);
    let Some(grid) = &plan.grid else { return evaluate(&plan.pixels()) };
    let mut field = vec![Complex32::ZERO; plan.width * plan.height];
    let pixels_of = |rows: &Range<usize>| rows.start * plan.width..rows.end * plan.width;
    let interpolated = &mut field[pixels_of(&plan.interpolated)];
    interpolate(&evaluate(&grid.samples), grid.samples.columns.len(), &grid.across, &grid.up, interpolated);
    for rows in [0..plan.interpolated.start, plan.interpolated.end..plan.height] {
        if !rows.is_empty() {
            field[pixels_of(&rows)].copy_from_slice(&evaluate(&plan.pixel_rows(rows)));
        }
    }
    field
}

/// The same by the f64 reference at every pixel.
pub fn by_reference(mut plan: Plan, aperture: &Aperture, drive: &Drive) -> Map<Vec<Complex32>> {
    let field = field::on_cpu(aperture, drive, &plan.pixels(), true);
    plan.reason = "every pixel is evaluated".to_owned();
    measured(plan, field, aperture, drive)
}

fn measured(plan: Plan, field: Vec<Complex32>, aperture: &Aperture, drive: &Drive) -> Map<Vec<Complex32>> {
    let peak = field::peak(&field);
    let probes = probes(&plan);
    let probed: Vec<_> = probes.iter().map(|&pixel| field[pixel]).collect();
    let error = measured_error(&plan, aperture, drive, &probes, &probed, peak);
    Map { plan, field, peak, error }
}

fn on_gpu<'a>(
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
fn probes(plan: &Plan) -> Vec<usize> {
    const GOLDEN: f64 = 0.618_033_988_749_894_8;
    let pixels = plan.width * plan.height;
    (1..=PROBES).map(|i| ((i as f64 * GOLDEN).fract() * pixels as f64) as usize).collect()
}

/// The largest deviation of `values` at the pixels `probes` from the f64 reference, relative to `peak` (Pa).
fn measured_error(
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
