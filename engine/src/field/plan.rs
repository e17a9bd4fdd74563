//! The sampling plan of a plane: sample points that keep the tolerance for maps of any size.
//!
//! Complex pressure on a plane has little spatial frequency above sinθ/λ, θ being the steepest angle between a ray
//! from the array and the normal of the axis. Wave front curvature widens this band; the evanescent field that
//! remains at the plane's height limits it. Together with the tolerance it determines the sample step and the
//! Kaiser window of the interpolating sinc; of several half-widths the one with the least work is chosen. Moduli
//! are formed afterwards, since |p|² has twice the bandwidth. Where samples would be within a wavelength of the
//! array, every pixel is evaluated. A plan does not depend on the pixels, so a new size of the map costs one
//! interpolation.
//!
//! One grid serves all boards: its bandwidth is the largest of all, its step divides their common pitch, it keeps
//! clear of all of them, and boards facing away from the whole plane are left out.
//!
//! If an axis of the plane is parallel to the array, the step divides the pitch: the transfer from an element to a
//! sample then equals that from its neighbour to a neighbouring sample, and [`crate::field::transfer`] stores one
//! line for all elements.

use std::f64::consts::TAU;
use std::ops::Range;

use glam::{DVec2, DVec3};
use num_complex::Complex32;

use crate::acoustics::element::{NEAREST, Radiator};
use crate::acoustics::{Aperture, Face};
use crate::field::interpolation::Resampling;
use crate::field::{samples::Samples, sources::Wave};
use crate::scene::Plane;

/// Limit of a table of waves in bytes; above, every superposition evaluates its waves again.
pub const TABLE_CEILING: usize = 256 << 20;
/// Candidate half-widths of the window, in samples.
const HALF_WIDTHS: [usize; 8] = [2, 3, 4, 5, 6, 8, 10, 12];
/// Pixels of a typical large map, for which the window is chosen.
const USUAL_PIXELS: f64 = 1024.0 * 1024.0;
/// The error limit, relative to the peak, of an exact map.
pub const EXACT: f64 = 2e-5;
/// Smallest error of f32, relative to the peak, on planes near elements.
pub const F32_ERROR: f64 = 4e-6;
/// Rounding error of a path in f32: rad per turn.
const F32_TURN_ERROR: f64 = 1.2e-7 * TAU;
/// Limit of samples of a plane: the pixels of the largest map.
const MOST_SAMPLES: f64 = (1u64 << 26) as f64;
/// Widening of the local frequency in Fresnel zones, and the window's part of the tolerance; with these, 12 000
/// random scenes kept their tolerance.
const BLUR: f64 = 0.15;
const SHARE: f64 = 0.2;
/// Limit of the transverse component of axes that count as parallel.
const ALIGNED: f64 = 1e-12;

/// The promised error of a map with this tolerance: the largest of all its pixels, relative to its peak.
pub fn promised(tolerance: f64) -> f64 {
    if tolerance == 0.0 { EXACT } else { tolerance }
}

/// The warning about a map whose error, relative to its peak, exceeds its tolerance in the printed figures.
pub fn missed(error: f64, tolerance: f64) -> Option<String> {
    const NOTABLE: f64 = 1.05;
    let promised = promised(tolerance);
    (error > NOTABLE * promised).then(|| {
        format!("the map's error may be {error:.1e} of its peak, above the tolerance of {promised:e}")
    })
}

/// Costs of an evaluator, in evaluations of one sample-element pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Costs {
    /// One tap of the interpolation.
    pub tap: f64,
    /// A pair read from a table that fits the caches, and from a larger one.
    pub shared_pair: f64,
    pub kept_pair: f64,
}

impl Costs {
    /// The same for interpolating this number of values instead of a typical map.
    pub fn for_values(self, values: usize) -> Self {
        Self { tap: self.tap * values as f64 / USUAL_PIXELS, ..self }
    }

    pub const CPU: Self = Self { tap: 0.06, shared_pair: 0.1, kept_pair: 0.2 };
    /// Without a table.
    pub const GPU: Self = Self { tap: 0.3, shared_pair: 1.0, kept_pair: 1.0 };
}

/// The sampling plan for maps of a plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    pub plane: Plane,
    /// Samples to interpolate from; without, every pixel is evaluated.
    pub grid: Option<Grid>,
    /// f32 does not suffice for the tolerance or the elements: everything is evaluated in f64.
    pub double: bool,
    /// Why it is so, for people.
    pub reason: String,
}

/// Samples of a part of the plane, and the interpolation of pixels from them.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    pub samples: Samples,
    /// Position of the first sample and sample distances along the plane's axes, m from its centre.
    pub first: DVec2,
    pub step: DVec2,
    /// Range (m) along the plane's second axis in which pixels may be interpolated.
    pub covered: Range<f64>,
    /// The highest spatial frequency (1/m) that matters along each axis.
    pub highest: DVec2,
    /// Half-width (samples) and shape of the window.
    pub half_width: usize,
    pub beta: f64,
    /// Contributing boards and images: index in the aperture, and the repetition of sample columns and rows from element
    /// to element.
    pub heard: Vec<(usize, [Option<Shared>; 2])>,
}

impl Grid {
    /// Interpolation of values to `places` (m) along an axis, from the plane's centre.
    pub fn resampling(&self, axis: usize, places: impl Iterator<Item = f64>) -> Resampling {
        let in_samples = places.map(|place| (place - self.first[axis]) / self.step[axis]);
        Resampling::new(in_samples, self.half_width, self.beta)
    }

    /// Interpolation of slopes there, per metre.
    pub fn slopes(&self, axis: usize, places: impl Iterator<Item = f64>) -> Resampling {
        let in_samples = places.map(|place| (place - self.first[axis]) / self.step[axis]);
        let mut slopes = Resampling::slopes(in_samples, self.half_width, self.beta);
        slopes.weights.iter_mut().for_each(|weight| *weight /= self.step[axis] as f32);
        slopes
    }

    /// Interpolation of derivatives there of the orders below `count`, per power of a metre.
    pub fn derivatives(
        &self,
        axis: usize,
        places: impl Iterator<Item = f64>,
        count: usize,
    ) -> Vec<Resampling> {
        let in_samples = places.map(|place| (place - self.first[axis]) / self.step[axis]);
        let mut all = Resampling::derivatives(in_samples, self.half_width, self.beta, count);
        for (order, own) in all.iter_mut().enumerate() {
            let unit = self.step[axis].powi(order as i32) as f32;
            own.weights.iter_mut().for_each(|weight| *weight /= unit);
        }
        all
    }
}

/// A sample axis that runs along a board with a step that divides the pitch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shared {
    /// 0: along the array's rows, from column to column; 1: the other way.
    pub element_axis: usize,
    /// Samples from one element to the next; negative if the axes are opposed.
    pub samples: isize,
}

impl Plan {
    /// The plan for a plane and its tolerance, by an evaluator with these costs. The tolerance is relative to the
    /// map's peak; 0 asks for direct evaluation. `None` for an invalid plane, which a checked scene never has.
    pub fn new(aperture: &Aperture, plane: &Plane, costs: Costs) -> Option<Self> {
        /// m; limit of distances from the origin.
        const FARTHEST: f64 = 1e6;
        let is_plane = plane.centre.is_finite()
            && plane.centre.abs().max_element() <= FARTHEST
            && plane.size.is_finite()
            && plane.size.min_element() > 0.0
            && plane.size.max_element() <= FARTHEST
            && (0.0..=1.0).contains(&plane.tolerance);
        let corners = corners(plane).filter(|_| is_plane)?;
        let too_much = promised(plane.tolerance) < f32_error(aperture, &corners);
        let has_wave = |face: &Face| {
            Wave::new(&aperture.element, &face.layout, &corners.seen_from(&face.pose)).is_some()
        };
        let double = too_much || !aperture.faces.iter().all(has_wave);
        let every = Self { plane: plane.clone(), grid: None, double, reason: String::new() };
        let direct = |reason: &str| every.direct(reason);
        if plane.tolerance == 0.0 {
            return Some(direct("exact was asked for"));
        }
        let view = View::new(aperture, plane, costs)?;
        let best = [false, true]
            .into_iter()
            .flat_map(|sharing| HALF_WIDTHS.map(|half_width| view.layout(half_width, sharing)))
            .flatten()
            .min_by(|a, b| view.work(a).total_cmp(&view.work(b)));
        let Some(layout) = best else {
            return Some(direct("the plane comes too near to the array"));
        };
        if view.samples(&layout) > MOST_SAMPLES {
            return Some(direct("the plane is too many wavelengths wide for samples"));
        }
        let grid = view.grid(&layout);
        let reason = format!(
            "{} x {} samples of {:.2} x {:.2} wavelengths, {} taps",
            grid.samples.columns.len(),
            grid.samples.rows.len(),
            layout.step.x / view.wavelength,
            layout.step.y / view.wavelength,
            2 * layout.half_width,
        );
        Some(Self { plane: plane.clone(), grid: Some(grid), double, reason })
    }
}

impl Plan {
    /// The same plane without samples.
    pub fn direct(&self, reason: &str) -> Self {
        let reason = format!("every pixel is evaluated: {reason}");
        Self { plane: self.plane.clone(), grid: None, double: self.double, reason }
    }
}

fn corners(plane: &Plane) -> Option<Samples> {
    let (x_axis, y_axis) = plane.axes()?;
    let (x, y) = (x_axis * (plane.size.x / 2.0), y_axis * (plane.size.y / 2.0));
    Some(Samples { columns: vec![plane.centre - x, plane.centre + x], rows: vec![-y, y] })
}

/// An estimate of the f32 evaluators' error relative to the peak: rounding of the longest path and of positions,
/// which mostly averages out over the elements. The measured error covers other cases.
pub fn f32_error(aperture: &Aperture, samples: &Samples) -> f64 {
    let averaging = if aperture.positions.len() > 1 { 0.1 } else { 0.5 };
    let of_face = |face: &Face| {
        let (low, high) = samples.seen_from(&face.pose).bounds();
        let (first, last) = face.layout.bounds();
        let (across, z) = if face.layout.is_flat() {
            let across = (high - first).truncate().abs().max((low - last).truncate().abs());
            (across.length(), low.z.max(0.0))
        } else {
            ((high - first).abs().max((low - last).abs()).length(), 0.0)
        };
        let aside = high.truncate().abs().max(low.truncate().abs()).length();
        let turns = (across.hypot(z) - z + aside * across / across.hypot(z)) / aperture.wavelength();
        (averaging * F32_TURN_ERROR * (turns + 1.0)).max(F32_ERROR)
    };
    aperture.faces.iter().map(of_face).fold(0.0, f64::max)
}

/// The data common to all layouts of samples on this plane.
struct View {
    centre: DVec3,
    axes: [DVec3; 2],
    /// m
    half: DVec2,
    tolerance: f64,
    costs: Costs,
    pitch: f64,
    wavelength: f64,
    faces: Vec<Seen>,
    /// The element planes that samples keep away from, unless the whole plane is behind.
    walls: Vec<Wall>,
    /// Extent (m) of disk elements around their centre.
    disk: f64,
    /// m, the radius that a far field's directivity is of.
    pattern: f64,
}

/// The plane in the coordinates of a contributing board.
struct Seen {
    /// Its number in the aperture.
    number: usize,
    centre: DVec3,
    axes: [DVec3; 2],
    elements: usize,
    /// Opposite corners of the board.
    corners: [DVec2; 2],
    is_flat: bool,
    is_lattice: bool,
}

/// An element plane: its distance (m) from the centre of the map's plane, and the gradient of the distance along the
/// map's axes.
struct Wall {
    height: f64,
    slopes: [f64; 2],
}

impl Wall {
    /// Largest distance (m) of a row's lowest sample, with margin, below the row.
    fn sagging(&self, half: DVec2, margin: DVec2) -> f64 {
        (half.x + margin.x) * self.slopes[0].abs() + margin.y * self.slopes[1].abs()
    }

    /// Whether the whole plane is behind it.
    fn is_passed(&self, half: DVec2) -> bool {
        self.height + half.x * self.slopes[0].abs() + half.y * self.slopes[1].abs() < -NEAREST
    }
}

/// A choice of samples.
struct Layout {
    half_width: usize,
    beta: f64,
    /// m
    step: DVec2,
    covered: Range<f64>,
    /// Cycles per wavelength.
    highest: DVec2,
    /// Repetition of sample columns and rows on every face.
    shared: Vec<[Option<Shared>; 2]>,
}

impl View {
    fn new(aperture: &Aperture, plane: &Plane, costs: Costs) -> Option<Self> {
        /// Part of the tolerance for a truncated series of reflections.
        const CUT: f64 = 0.05;
        let (x_axis, y_axis) = plane.axes()?;
        let half = plane.size / 2.0;
        let disk = match aperture.element.radiator() {
            Radiator::Disk(radius) => radius,
            Radiator::Monopole
            | Radiator::Piston(_)
            | Radiator::Rectangle(_)
            | Radiator::Cosine(_)
            | Radiator::Measured => 0.0,
        };
        let (mut faces, mut walls) = (Vec::new(), Vec::new());
        for (number, face) in aperture.faces.iter().enumerate() {
            if face.rest < CUT * plane.tolerance {
                break;
            }
            let centre = face.pose.local(plane.centre);
            let axes = [x_axis, y_axis].map(|axis| face.pose.local_direction(axis));
            let wall = |at: DVec3, normal: DVec3| Wall {
                height: normal.dot(centre - at),
                slopes: axes.map(|axis| normal.dot(axis)),
            };
            let layout = &face.layout;
            let own: Vec<_> = if layout.is_flat() {
                vec![wall(DVec3::ZERO, DVec3::Z)]
            } else {
                layout.positions.iter().zip(&layout.normals).map(|(&at, &normal)| wall(at, normal)).collect()
            };
            // The last one represents boards that do not contribute.
            let is_only = faces.is_empty() && number + 1 == aperture.faces.len();
            let before = walls.len();
            walls.extend(own.into_iter().filter(|wall| is_only || !wall.is_passed(half)));
            if walls.len() == before {
                continue;
            }
            let (first, last) = face.corners();
            faces.push(Seen {
                number,
                centre,
                axes,
                elements: layout.positions.len(),
                corners: [first, last],
                is_flat: layout.is_flat(),
                is_lattice: layout.columns.is_some(),
            });
        }
        Some(Self {
            centre: plane.centre,
            axes: [x_axis, y_axis],
            half,
            tolerance: plane.tolerance,
            costs,
            pitch: aperture.pitch,
            wavelength: aperture.wavelength(),
            faces,
            walls,
            disk,
            pattern: aperture.element.steepness(),
        })
    }

    /// The coarsest layout of samples for a window within the tolerance, on the part of the plane clear of the array.
    ///
    /// A Kaiser window of half-width K and shape β passes frequencies below ½ - β/2πK cycles per sample and stops
    /// those above ½ + β/2πK, to about e^{-β}.
    fn layout(&self, half_width: usize, sharing: bool) -> Option<Layout> {
        let beta = -(SHARE * self.tolerance).ln();
        let cycles_per_sample = 0.5 - beta / (TAU * half_width as f64);
        if cycles_per_sample < 0.05 {
            return None;
        }
        // The steepest ray depends on the margin, and the margin on the step that the ray allows.
        let mut highest = DVec2::ONE;
        let mut step = DVec2::splat(cycles_per_sample * self.wavelength);
        for _ in 0..3 {
            let margin = step * half_width as f64;
            let covered = self.covered(margin)?;
            highest = DVec2::from([0, 1].map(|axis| self.highest_frequency(axis, &covered, margin, beta)));
            step = cycles_per_sample * self.wavelength / highest;
        }
        let mut shared = vec![[None; 2]; self.faces.len()];
        if sharing {
            for axis in [0, 1] {
                let along: Vec<_> = self.faces.iter().map(|face| face.along(axis)).collect();
                if along.iter().all(Option::is_none) {
                    continue;
                }
                let samples = (self.pitch / step[axis]).ceil();
                step[axis] = self.pitch / samples;
                for (shared, along) in shared.iter_mut().zip(along) {
                    shared[axis] = along.map(|(element_axis, sign)| Shared {
                        element_axis,
                        samples: (sign * samples) as isize,
                    });
                }
            }
            if shared.iter().all(|shared| *shared == [None; 2]) {
                return None;
            }
        }
        let covered = self.covered(step * half_width as f64)?;
        Some(Layout { half_width, beta, step, covered, highest, shared })
    }

    /// The range along the second axis in which samples, including margins, are a wavelength away from element
    /// planes.
    fn covered(&self, margin: DVec2) -> Option<Range<f64>> {
        let half = self.half.y;
        let covered = self.walls.iter().fold(-half..half, |covered, wall| {
            let lowest = self.wavelength + wall.sagging(self.half, margin) - wall.height;
            let slope = wall.slopes[1];
            let Range { start, end } = covered;
            if slope.abs() < ALIGNED {
                if lowest > 0.0 { end..end } else { start..end }
            } else if slope > 0.0 {
                (lowest / slope).max(start)..end
            } else {
                start..(lowest / slope).min(end)
            }
        });
        (covered.start < covered.end).then_some(covered)
    }

    /// The highest spatial frequency along an axis, in cycles per wavelength, with more than e^{-β} on the covered
    /// part and its margin.
    ///
    /// It is the sine of the steepest ray, widened by wave front curvature over one Fresnel zone, but at most the
    /// highest evanescent frequency that decays (as e^{-2πz√(f²-1)/λ}) by no more than that. A directivity 2 J1(ka
    /// sinθ)/(ka sinθ) varies by ka as sinθ goes from 0 to 1, and so adds a/z cos³θ. That matters for elements wider
    /// than their distance.
    fn highest_frequency(&self, axis: usize, covered: &Range<f64>, margin: DVec2, beta: f64) -> f64 {
        let height = |wall: &Wall| {
            let slope = wall.slopes[1];
            let row = (covered.start * slope).min(covered.end * slope);
            wall.height + row - wall.sagging(self.half, margin)
        };
        let height = self.walls.iter().map(height).fold(f64::INFINITY, f64::min);
        let evanescent = beta / (TAU * height / self.wavelength);
        let pattern = self.pattern / height;
        // sinθ + a/z cos³θ ≤ √(1 + a²/z²)
        let most = 1f64.hypot(evanescent.max(pattern));
        let blur = (BLUR * (beta * self.wavelength / height).sqrt()).max(pattern);
        let of_face = |face: &Seen| {
            let along = face.axes[axis];
            if along.z.abs() > 1e-9 || !face.is_flat {
                return most;
            }
            let [low, high] = face.corners;
            let reach =
                [low, high, DVec2::new(low.x, high.y)].map(|corner| corner.dot(along.truncate()).abs());
            let array = reach.into_iter().fold(0.0, f64::max) + self.disk;
            let longest = face.centre.dot(along).abs() + self.half[axis] + margin[axis] + array;
            (longest / longest.hypot(height) + blur).min(most)
        };
        self.faces.iter().map(of_face).fold(0.0, f64::max)
    }

    fn sample_counts(&self, layout: &Layout) -> [usize; 2] {
        let span = [2.0 * self.half.x, layout.covered.end - layout.covered.start];
        let count = |axis: usize| (span[axis] / layout.step[axis]).floor() as usize;
        [0, 1].map(|axis| count(axis).saturating_add(2 * layout.half_width))
    }

    fn samples(&self, layout: &Layout) -> f64 {
        let [columns, rows] = self.sample_counts(layout);
        columns as f64 * rows as f64
    }

    fn work(&self, layout: &Layout) -> f64 {
        let samples = self.samples(layout);
        let taps = USUAL_PIXELS * (2 * layout.half_width) as f64;
        let of_face = |(face, shared): (&Seen, &[Option<Shared>; 2])| {
            let pairs = samples * face.elements as f64;
            let is_kept = pairs * size_of::<Complex32>() as f64 <= TABLE_CEILING as f64;
            let pair = match shared {
                [None, None] if is_kept => self.costs.kept_pair,
                [None, None] => 1.0,
                _ => self.costs.shared_pair,
            };
            pair * pairs
        };
        self.faces.iter().zip(&layout.shared).map(of_face).sum::<f64>() + self.costs.tap * taps
    }

    fn grid(&self, layout: &Layout) -> Grid {
        let counts = self.sample_counts(layout);
        let margin = (layout.half_width - 1) as f64 * layout.step;
        let first = DVec2::new(-self.half.x, layout.covered.start) - margin;
        let place = |axis: usize| {
            let along = self.axes[axis];
            (0..counts[axis]).map(move |i| along * (first[axis] + i as f64 * layout.step[axis]))
        };
        let columns = place(0).map(|offset| self.centre + offset).collect();
        Grid {
            samples: Samples { columns, rows: place(1).collect() },
            first,
            step: layout.step,
            covered: layout.covered.clone(),
            highest: layout.highest / self.wavelength,
            half_width: layout.half_width,
            beta: layout.beta,
            heard: self.faces.iter().map(|face| face.number).zip(layout.shared.iter().copied()).collect(),
        }
    }
}

impl Seen {
    /// The board's axis parallel to an axis of the plane, and its direction (1 or -1).
    fn along(&self, axis: usize) -> Option<(usize, f64)> {
        let along = self.axes[axis];
        let found = [0, 1].into_iter().find(|&i| (along[i].abs() - 1.0).abs() < ALIGNED);
        found.filter(|_| self.is_lattice).map(|i| (i, along[i].signum()))
    }
}

#[cfg(test)]
mod tests;
