//! The field of a drive at many points: in f64 as the reference, and in f32 for speed, on the CPU and on the GPU.
//!
//! The two f32 evaluators do the same sums with the same polynomials from the same [`Sources`]; tests compare them
//! with the reference.

pub mod cells;
pub mod colouring;
pub mod contour;
pub mod cpu;
#[cfg_attr(not(feature = "gpu"), path = "no_gpu.rs")]
pub mod gpu;
mod gpu_report;
pub mod interpolation;
pub mod plan;
pub mod polynomial;
pub mod quantity;
pub mod raster;
pub mod reference;
pub mod side_lobe;
pub mod slope;
pub mod sound;
pub mod sources;
pub mod stages;
pub mod summit;
pub mod transfer;
mod unit;
mod vicinity;
pub mod volume;

use std::borrow::Cow;
use std::io::Read;

use glam::DVec3;
use num_complex::Complex32;
use rayon::prelude::*;

use crate::acoustics::{Aperture, Pose};
use crate::drive::Drive;
use crate::scene::Plane;
use crate::simd::larger;
use crate::table::{Table, TableError};

pub use colouring::{Colouring, Scale};
pub use gpu::Gpu;
pub use gpu_report::{GpuError, Traffic};
pub use plan::{Plan, missed, promised};
pub use quantity::Quantity;
pub use raster::Raster;
pub use side_lobe::{NoSideLobe, SideLobe};
pub use sources::{Sources, Wave};
pub use stages::{By, Depression, FieldError, Map, Pressed, Request, Stages, Work};

/// Limit of points of a table: more would need gigabytes.
const MOST_POINTS: usize = 10_000_000;
/// m; points beyond are slips of the unit.
const FARTHEST: f64 = 1e6;

/// Sample points: sample (i, j) is at `columns[i] + rows[j]`.
///
/// A grid on a plane has as many columns and rows as its width and height; a list of points is one row.
#[derive(Clone, Debug, PartialEq)]
pub struct Samples {
    /// m
    pub columns: Vec<DVec3>,
    /// m
    pub rows: Vec<DVec3>,
}

impl Samples {
    /// Samples at the centres of `width` x `height` pixels that fill the plane, row 0 at the smallest y.
    ///
    /// `None` for parallel or zero axes, which a checked scene never has.
    pub fn on_plane(plane: &Plane, width: usize, height: usize) -> Option<Self> {
        let (x_axis, y_axis) = plane.axes()?;
        let along = |axis: DVec3, length: f64, count: usize| {
            (0..count).map(move |i| axis * (length * ((i as f64 + 0.5) / count as f64 - 0.5)))
        };
        Some(Self {
            columns: along(x_axis, plane.size.x, width).map(|offset| plane.centre + offset).collect(),
            rows: along(y_axis, plane.size.y, height).collect(),
        })
    }

    /// The points themselves.
    pub fn at(points: Vec<DVec3>) -> Self {
        Self { columns: points, rows: vec![DVec3::ZERO] }
    }

    /// The points of CSV with the columns `x`, `y` and `z` (m).
    ///
    /// # Errors
    /// No points or too many, an invalid row, or a point farther than 1000 km along an axis.
    pub fn read(csv: impl Read) -> Result<Self, TableError> {
        let mut table = Table::open(csv, ["x", "y", "z"], [])?;
        let mut points = Vec::new();
        while let Some(row) = table.next_row()? {
            let [] = row.optional;
            let at = row.required;
            let point = DVec3::from_array(at);
            if point.abs().max_element() > FARTHEST {
                let reason =
                    format!("{at:?}: must be metres, every coordinate from -{FARTHEST} to {FARTHEST}");
                return Err(table.refusal(reason));
            }
            if points.len() == MOST_POINTS {
                return Err(table.refusal(format!("more than {MOST_POINTS} points")));
            }
            points.push(point);
        }
        if points.is_empty() {
            return Err(table.refusal("there are no points"));
        }
        Ok(Self::at(points))
    }

    pub fn len(&self) -> usize {
        self.columns.len() * self.rows.len()
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Sample number `index`, row by row.
    ///
    /// # Panics
    /// An index beyond the last.
    pub fn point(&self, index: usize) -> DVec3 {
        self.columns[index % self.columns.len()] + self.rows[index / self.columns.len()]
    }

    /// The same in the coordinates of a board.
    pub fn seen_from(&self, pose: &Pose) -> Cow<'_, Self> {
        if *pose == Pose::HOME {
            return Cow::Borrowed(self);
        }
        Cow::Owned(Self {
            columns: self.columns.iter().map(|&point| pose.local(point)).collect(),
            rows: self.rows.iter().map(|&offset| pose.local_direction(offset)).collect(),
        })
    }

    /// The bounding box of all samples: its smallest and its largest corner.
    fn bounds(&self) -> (DVec3, DVec3) {
        let range = |points: &[DVec3]| {
            points.iter().fold((DVec3::MAX, DVec3::MIN), |(low, high), p| (low.min(*p), high.max(*p)))
        };
        let ((column_low, column_high), (row_low, row_high)) = (range(&self.columns), range(&self.rows));
        (column_low + row_low, column_high + row_high)
    }
}

/// The field evaluator.
#[derive(Debug)]
pub enum Evaluator {
    /// f64, point by point: slow and right.
    Reference,
    Cpu,
    Gpu(Box<Gpu>),
}

impl Evaluator {
    /// Complex pressure (Pa, peak) at every sample, within [`plan::EXACT`] of the largest: in f64 where f32 does not
    /// suffice.
    ///
    /// # Errors
    /// Errors of the GPU only: a lost device or insufficient memory.
    pub fn pressure(
        &self,
        aperture: &Aperture,
        drive: &Drive,
        samples: &Samples,
    ) -> Result<Vec<Complex32>, GpuError> {
        let is_in_reach = !samples.is_empty() && plan::f32_error(aperture, samples) <= plan::EXACT;
        let sources = Sources::of_faces(aperture, drive, samples).filter(|_| is_in_reach);
        let in_f32 = match (self, sources) {
            (Self::Gpu(gpu), Some(faces)) if faces.iter().all(Sources::has_no_sample_beside_rims) => {
                Some(gpu.pressure(&faces)?)
            }
            (Self::Cpu | Self::Gpu(_), Some(_)) => Some(on_cpu(aperture, drive, samples, false)),
            (Self::Reference, _) | (_, None) => None,
        };
        let exact = in_f32.filter(|field| is_exact(aperture, drive, samples, field));
        Ok(exact.unwrap_or_else(|| on_cpu(aperture, drive, samples, true)))
    }
}

/// Whether pressures agree with f64 at some of the samples.
fn is_exact(aperture: &Aperture, drive: &Drive, samples: &Samples, field: &[Complex32]) -> bool {
    /// Number of compared samples, and safety factor for the others.
    const COMPARED: usize = 96;
    const MARGIN: f32 = 3.0;
    let chosen: Vec<_> = (0..samples.len()).step_by(samples.len().div_ceil(COMPARED)).collect();
    let points = chosen.iter().map(|&index| samples.point(index)).collect();
    let expected = on_cpu(aperture, drive, &Samples::at(points), true);
    let off = chosen.iter().zip(expected).map(|(&index, p)| (field[index] - p).norm());
    MARGIN * off.fold(0.0, f32::max) <= plan::EXACT as f32 * peak(field)
}

/// Complex pressure (Pa, peak) at every sample by the CPU, in f64 if `double` or where f32 declines.
fn on_cpu(aperture: &Aperture, drive: &Drive, samples: &Samples, double: bool) -> Vec<Complex32> {
    let in_f64 =
        |samples: &Samples| reference::pressure(aperture, drive, samples).into_iter().map(sound::narrow);
    match Sources::of_faces(aperture, drive, samples) {
        Some(faces) if !double => {
            let mut field = cpu::pressure(&faces, samples.len());
            let mut beside: Vec<_> = faces.iter().flat_map(Sources::beside_rims).collect();
            beside.sort_unstable();
            beside.dedup();
            let points = beside.iter().map(|&index| samples.point(index)).collect();
            for (&index, p) in beside.iter().zip(in_f64(&Samples::at(points))) {
                field[index] = p;
            }
            field
        }
        _ => in_f64(samples).collect(),
    }
}

/// The largest |p| of a field, Pa.
pub fn peak(field: &[Complex32]) -> f32 {
    const LANES: usize = 16;
    let of_part = |part: &[Complex32]| {
        let (runs, rest) = part.as_chunks::<LANES>();
        let mut largest = [0.0f32; LANES];
        for run in runs {
            for (largest, p) in largest.iter_mut().zip(run) {
                *largest = larger(p.norm_sqr(), *largest);
            }
        }
        rest.iter().map(|p| p.norm_sqr()).chain(largest).fold(0.0, f32::max)
    };
    field.par_chunks(1 << 14).map(of_part).reduce(|| 0.0, f32::max).sqrt()
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, dvec3};

    use super::*;

    use crate::scene::{Array, Board, Scene};

    #[test]
    fn samples_stand_at_pixel_centres_row_0_at_the_smallest_y() {
        let plane = Plane { size: DVec2::new(0.4, 0.2), ..Plane::default() };
        let samples = Samples::on_plane(&plane, 4, 2).unwrap();
        assert_eq!(samples.len(), 8);
        assert!(samples.point(0).distance(dvec3(-0.15, -0.05, 0.1)) < 1e-15);
        assert!(samples.point(3).distance(dvec3(0.15, -0.05, 0.1)) < 1e-15);
        assert!(samples.point(4).distance(dvec3(-0.15, 0.05, 0.1)) < 1e-15);
    }

    #[test]
    fn points_are_read_and_slips_are_named_by_line() {
        let samples = Samples::read(&b"z,x,y\n0.1,-0.0,1e-3\n"[..]).unwrap();
        assert_eq!(samples, Samples::at(vec![dvec3(-0.0, 1e-3, 0.1)]));
        for (text, error) in [
            ("x,y,z\n", "1: there are no points"),
            ("x,y,z\n0,0,0.1\n0,-2e6,0\n", "3: [0.0, -2000000.0, 0.0]: must be metres"),
            ("x,y\n", "1: the column `z` is missing"),
        ] {
            let refused = Samples::read(text.as_bytes()).unwrap_err().to_string();
            assert!(refused.starts_with(error), "{text:?}: {refused}");
        }
    }

    #[test]
    fn a_vertical_plane_has_its_own_up() {
        let plane = Plane { y_axis: dvec3(3.0, 0.0, 2.0), ..Plane::default() };
        let samples = Samples::on_plane(&plane, 1, 2).unwrap();
        assert!(samples.point(0).distance(dvec3(0.0, 0.0, 0.05)) < 1e-15);
        assert!(samples.point(1).distance(dvec3(0.0, 0.0, 0.15)) < 1e-15);
    }

    #[test]
    fn all_samples_lie_within_their_bounds_and_touch_them() {
        let columns = vec![dvec3(0.1, 0.0, 0.2), dvec3(-0.3, 0.1, 0.25), dvec3(0.0, -0.1, 0.3)];
        let samples = Samples { columns, rows: vec![dvec3(0.0, 0.3, 0.01), dvec3(0.02, 0.5, -0.04)] };
        let points = || (0..samples.len()).map(|index| samples.point(index));
        let low = points().fold(DVec3::MAX, DVec3::min);
        let high = points().fold(DVec3::MIN, DVec3::max);
        assert_eq!(samples.bounds(), (low, high));
    }

    /// Two boards face to face, 0.2 m apart.
    fn between_boards() -> (Aperture, Drive) {
        let array = Array { columns: 2, rows: 2, ..Array::default() };
        let opposite = Board { at: DVec3::Z * 0.2, normal: DVec3::NEG_Z, ..Board::default() };
        let boards = vec![Board::default(), opposite];
        let drive = Drive { amplitudes: vec![1.0; 8], phases: (0..8).map(|n| 0.7 * f64::from(n)).collect() };
        (Aperture::new(&Scene { array, boards, ..Scene::default() }), drive)
    }

    #[test]
    fn the_field_of_usual_boards_is_in_f32_and_that_of_no_point_is_empty() {
        let (aperture, drive) = between_boards();
        let points = (0..40).map(|i| dvec3(0.002 * f64::from(i) - 0.03, 0.001 * f64::from(i), 0.09));
        let samples = Samples::at(points.collect());
        let expected = on_cpu(&aperture, &drive, &samples, false);
        assert_ne!(expected, on_cpu(&aperture, &drive, &samples, true));
        assert_eq!(Evaluator::Cpu.pressure(&aperture, &drive, &samples).unwrap(), expected);
        // Where f32 is not promised to suffice, it is not tried.
        let single = Array { columns: 1, rows: 1, ..Array::default() };
        let single = Aperture::new(&Scene { array: single, ..Scene::default() });
        for i in 0..20 {
            let far = Samples::at(vec![dvec3(0.9 + 0.011 * f64::from(i), 0.0, 0.1)]);
            let expected = on_cpu(&single, &drive, &far, true);
            assert_eq!(Evaluator::Cpu.pressure(&single, &drive, &far).unwrap(), expected);
        }
        let none = Samples::at(Vec::new());
        for evaluator in [Evaluator::Cpu, Evaluator::Reference] {
            assert!(evaluator.pressure(&aperture, &drive, &none).unwrap().is_empty());
        }
    }
}
