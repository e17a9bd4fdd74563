//! Which points to evaluate for a map, so that its error stays within a tolerance.
//!
//! Complex pressure on a plane has hardly any spatial frequency above sinθ/λ, θ being the steepest angle at which a ray
//! from the array meets the plane's axis. It is sampled a little finer than that asks for, with a margin, and interpolated with
//! a Kaiser-windowed sinc; moduli are formed afterwards, since |p|² has twice the band. Where samples would come
//! within a wavelength of the array, or would be more work than the map itself, every pixel is evaluated.

use std::f64::consts::TAU;
use std::ops::Range;

use glam::{DVec2, DVec3};

use crate::acoustics::Aperture;
use crate::field::Samples;
use crate::field::interpolation::Resampling;
use crate::scene::Plane;

/// Half-widths of the window, in samples, that are tried.
const HALF_WIDTHS: [usize; 8] = [2, 3, 4, 5, 6, 8, 10, 12];
/// Work of one tap of the interpolation, in evaluations of one sample-element pair.
const TAP_WORK: f64 = 0.1;
/// rad by which f32 rounds a path, per turn of it.
const F32_TURN_ERROR: f64 = 1.2e-7 * TAU;
/// Fresnel zones by which the local frequency is blurred, and the part of the tolerance that the window is designed for;
/// with these, 12 000 random scenes kept their tolerance.
const BLUR: f64 = 0.15;
const SHARE: f64 = 0.2;

/// What to evaluate for a map of a given size.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    pub width: usize,
    pub height: usize,
    /// Rows that are interpolated from `grid`; the rest is evaluated pixel by pixel.
    pub interpolated: Range<usize>,
    pub grid: Option<Grid>,
    /// The tolerance asks for more than f32 keeps: samples are evaluated in f64.
    pub double: bool,
    /// Why it is so, for people.
    pub reason: String,
    columns: Vec<DVec3>,
    rows: Vec<DVec3>,
}

/// Samples of the interpolated rows and the way from them to pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    pub samples: Samples,
    /// From sample columns to pixel columns.
    pub across: Resampling,
    /// From sample rows to the interpolated pixel rows.
    pub up: Resampling,
}

impl Plan {
    /// The plan for `width` x `height` pixels on a plane; `tolerance` is relative to the map's peak, and 0 asks for
    /// direct evaluation. `None` where the plane's axes span no plane.
    pub fn new(
        aperture: &Aperture,
        plane: &Plane,
        (width, height): (usize, usize),
        tolerance: f64,
    ) -> Option<Self> {
        let Samples { columns, rows } = Samples::on_plane(plane, width, height)?;
        let direct = |reason: &str| Self {
            width,
            height,
            interpolated: 0..0,
            grid: None,
            double: false,
            reason: reason.to_owned(),
            columns: columns.clone(),
            rows: rows.clone(),
        };
        if tolerance == 0.0 {
            return Some(direct("every pixel is evaluated: exact was asked for"));
        }
        let double =
            tolerance < f32_error(aperture, &Samples { columns: columns.clone(), rows: rows.clone() });
        let view = View::new(aperture, plane, width, height)?;
        let candidates = HALF_WIDTHS.into_iter().filter_map(|half_width| view.layout(half_width, tolerance));
        let Some(layout) = candidates.min_by(|a, b| view.work(a).total_cmp(&view.work(b))) else {
            return Some(Self {
                double,
                ..direct("every pixel is evaluated: the plane comes too near to the array")
            });
        };
        if view.work(&layout) > view.direct_work() {
            return Some(Self {
                double,
                ..direct("every pixel is evaluated: that is less work than interpolating")
            });
        }
        let grid = view.grid(&layout);
        let reason = format!(
            "{} x {} samples of {:.2} x {:.2} wavelengths are evaluated and interpolated with {} taps to rows {} to {} \
             of {height}{}",
            grid.samples.columns.len(),
            grid.samples.rows.len(),
            layout.step.x / view.wavelength,
            layout.step.y / view.wavelength,
            2 * layout.half_width,
            layout.rows.start,
            layout.rows.end - 1,
            if layout.rows.len() < height {
                ", and the rest, too near to the array, pixel by pixel"
            } else {
                ""
            },
        );
        Some(Self { interpolated: layout.rows, grid: Some(grid), double, ..direct(&reason) })
    }

    /// The same plan with its samples evaluated in f64.
    pub fn in_f64(self) -> Self {
        Self { double: true, ..self }
    }

    /// Every pixel of the map.
    pub fn pixels(&self) -> Samples {
        self.pixel_rows(0..self.height)
    }

    /// Some rows of the map.
    pub fn pixel_rows(&self, rows: Range<usize>) -> Samples {
        Samples { columns: self.columns.clone(), rows: self.rows[rows].to_vec() }
    }

    /// Points at which anything is evaluated.
    pub fn evaluated(&self) -> usize {
        let direct = (self.height - self.interpolated.len()) * self.width;
        direct + self.grid.as_ref().map_or(0, |grid| grid.samples.len())
    }
}

/// An estimate of the f32 evaluators' error relative to the peak: the rounding of the longest path that they see, which
/// partly averages out over the elements.
fn f32_error(aperture: &Aperture, samples: &Samples) -> f64 {
    let (low, high) = samples.bounds();
    let (first, last) = aperture.corners();
    let across = (high.truncate() - first).abs().max((low.truncate() - last).abs()).length();
    let z = low.z.max(0.0);
    let turns = (across.hypot(z) - z) / aperture.wavelength();
    let averaging = if aperture.driven.len() > 1 { 0.5 } else { 1.0 };
    averaging * F32_TURN_ERROR * (turns + 1.0)
}

/// What every layout of samples on this plane is measured against.
struct View {
    centre: DVec3,
    axes: [DVec3; 2],
    /// Half the distance (m) between the outermost pixel centres.
    half: DVec2,
    pixels: [usize; 2],
    elements: usize,
    wavelength: f64,
    /// Opposite corners of the array.
    corners: [DVec3; 2],
}

/// A choice of samples.
struct Layout {
    half_width: usize,
    beta: f64,
    /// m
    step: DVec2,
    rows: Range<usize>,
}

impl View {
    fn new(aperture: &Aperture, plane: &Plane, width: usize, height: usize) -> Option<Self> {
        let (x_axis, y_axis) = plane.axes()?;
        let pixels = DVec2::new(width as f64, height as f64);
        let (first, last) = aperture.corners();
        Some(Self {
            centre: plane.centre,
            axes: [x_axis, y_axis],
            half: plane.size * (pixels - 1.0) / pixels / 2.0,
            pixels: [width, height],
            elements: aperture.driven.len(),
            wavelength: aperture.wavelength(),
            corners: [first.extend(0.0), last.extend(0.0)],
        })
    }

    /// Samples for a window, as coarse as the tolerance allows, on as many rows as stay clear of the array.
    ///
    /// A Kaiser window of half-width K and shape β passes what lies below ½ - β/2πK cycles per sample and stops what lies
    /// above ½ + β/2πK, to about e^{-β}.
    fn layout(&self, half_width: usize, tolerance: f64) -> Option<Layout> {
        let beta = -(SHARE * tolerance).ln();
        let cycles_per_sample = 0.5 - beta / (TAU * half_width as f64);
        if cycles_per_sample < 0.05 {
            return None;
        }
        // The steepest ray depends on the margin, and the margin on the step that the ray allows.
        let mut step = DVec2::splat(cycles_per_sample * self.wavelength);
        let mut rows = 0..0;
        for _ in 0..3 {
            let margin = step * half_width as f64;
            rows = self.clear_rows(margin);
            if rows.is_empty() {
                return None;
            }
            let highest = |axis| self.highest_frequency(axis, &rows, margin, beta);
            step = cycles_per_sample * self.wavelength / DVec2::new(highest(0), highest(1));
        }
        let rows = self.clear_rows(step * half_width as f64);
        (!rows.is_empty()).then_some(Layout { half_width, beta, step, rows })
    }

    /// The pixel rows whose samples, margin included, stay a wavelength away from the array's plane.
    fn clear_rows(&self, margin: DVec2) -> Range<usize> {
        let [x_axis, y_axis] = self.axes;
        let sagging = (self.half.x + margin.x) * x_axis.z.abs() + margin.y * y_axis.z.abs();
        let clear = |row: usize| self.centre.z + self.offset(1, row) * y_axis.z - sagging >= self.wavelength;
        // The height is linear in the row, so one end of the rows is clear and the other perhaps not.
        let rows = self.pixels[1];
        let upwards = y_axis.z >= 0.0;
        let (mut low, mut high) = (0, rows);
        while low < high {
            let middle = low + (high - low) / 2;
            if clear(middle) == upwards { high = middle } else { low = middle + 1 }
        }
        if upwards { low..rows } else { 0..low }
    }

    /// Distance (m) of a pixel from the plane's centre along an axis.
    fn offset(&self, axis: usize, pixel: usize) -> f64 {
        let last = self.pixels[axis].saturating_sub(1).max(1) as f64;
        self.half[axis] * (2.0 * pixel as f64 / last - 1.0)
    }

    /// The highest spatial frequency along an axis, in cycles per wavelength, of which more than e^{-β} is left on the
    /// rows and their margin.
    ///
    /// It is the sine of the steepest ray, blurred by the curvature of the wave fronts over one Fresnel zone; but no more
    /// than what of the evanescent field, which falls by e^{-2πz√(f²-1)/λ}, comes so far.
    fn highest_frequency(&self, axis: usize, rows: &Range<usize>, margin: DVec2, beta: f64) -> f64 {
        let along = self.axes[axis];
        let [x_axis, y_axis] = self.axes;
        let heights = [rows.start, rows.end - 1].map(|row| self.centre.z + self.offset(1, row) * y_axis.z);
        let sagging = (self.half.x + margin.x) * x_axis.z.abs() + margin.y * y_axis.z.abs();
        let height = heights[0].min(heights[1]) - sagging;
        let evanescent = beta / (TAU * height / self.wavelength);
        let most = 1f64.hypot(evanescent);
        if along.z.abs() > 1e-9 {
            return most;
        }
        let [low, high] = self.corners;
        let reach = [low, high, DVec3::new(low.x, high.y, 0.0)].map(|corner| corner.dot(along).abs());
        let array = reach.into_iter().fold(0.0, f64::max);
        let longest = self.centre.dot(along).abs() + self.half[axis] + margin[axis] + array;
        let blur = BLUR * (beta * self.wavelength / height).sqrt();
        (longest / longest.hypot(height) + blur).min(most)
    }

    fn sample_counts(&self, layout: &Layout) -> [usize; 2] {
        let span =
            [2.0 * self.half.x, self.offset(1, layout.rows.end - 1) - self.offset(1, layout.rows.start)];
        [0, 1].map(|axis| (span[axis] / layout.step[axis]).floor() as usize + 2 * layout.half_width)
    }

    fn work(&self, layout: &Layout) -> f64 {
        let [columns, rows] = self.sample_counts(layout);
        let outside = (self.pixels[1] - layout.rows.len()) * self.pixels[0];
        let taps = layout.rows.len() * self.pixels[0] * 2 * layout.half_width;
        ((columns * rows + outside) * self.elements) as f64 + TAP_WORK * taps as f64
    }

    fn direct_work(&self) -> f64 {
        (self.pixels[0] * self.pixels[1] * self.elements) as f64
    }

    fn grid(&self, layout: &Layout) -> Grid {
        let counts = self.sample_counts(layout);
        let first_pixels = [0, layout.rows.start];
        let pixels = [0..self.pixels[0], layout.rows.clone()];
        let start = |axis: usize| {
            self.offset(axis, first_pixels[axis]) - (layout.half_width - 1) as f64 * layout.step[axis]
        };
        let place = |axis: usize| {
            let (start, along, step) = (start(axis), self.axes[axis], layout.step[axis]);
            (0..counts[axis]).map(move |i| along * (start + i as f64 * step))
        };
        let resampling = |axis: usize| {
            let in_samples = |pixel: usize| (self.offset(axis, pixel) - start(axis)) / layout.step[axis];
            Resampling::new(pixels[axis].clone().map(in_samples), layout.half_width, layout.beta)
        };
        let columns = place(0).map(|offset| self.centre + offset).collect();
        Grid {
            samples: Samples { columns, rows: place(1).collect() },
            across: resampling(0),
            up: resampling(1),
        }
    }
}
