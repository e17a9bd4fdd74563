//! Which points of a plane to sample, so that a map of any size keeps the tolerance.
//!
//! Complex pressure on a plane has hardly any spatial frequency above sinθ/λ, θ being the steepest angle at which a ray
//! from the array meets the plane's axis. It is sampled a little finer than that asks for, with a margin, and interpolated
//! with a Kaiser-windowed sinc; moduli are formed afterwards, since |p|² has twice the band. Where samples would come
//! within a wavelength of the array, every pixel is evaluated.
//!
//! Where an axis of the plane runs along the array, a step that divides the pitch is taken: a sample then stands to one
//! element as its neighbours stand to the next, and [`crate::field::transfer`] keeps one line for all of them.

use std::f64::consts::TAU;
use std::ops::Range;

use glam::{DVec2, DVec3};
use num_complex::Complex32;

use crate::acoustics::Aperture;
use crate::field::interpolation::Resampling;
use crate::field::{Samples, Wave};
use crate::scene::{ElementModel, Plane};

/// Bytes that a table of waves may take; above, every superposition evaluates its waves anew.
pub const TABLE_CEILING: usize = 256 << 20;
/// Half-widths of the window, in samples, that are tried.
const HALF_WIDTHS: [usize; 8] = [2, 3, 4, 5, 6, 8, 10, 12];
/// Pixels of a usual large map, for which the window is chosen.
const USUAL_PIXELS: f64 = 1024.0 * 1024.0;
/// The largest error, relative to the peak, of a map that is to be exact.
pub const EXACT: f64 = 2e-5;
/// What f32 keeps at best, relative to the peak, where the plane comes near to elements.
const F32_ERROR: f64 = 4e-6;
/// rad by which f32 rounds a path, per turn of it.
const F32_TURN_ERROR: f64 = 1.2e-7 * TAU;
/// Samples of a plane that are worth while: as many as the pixels of the largest map.
const MOST_SAMPLES: f64 = (1u64 << 26) as f64;
/// Fresnel zones by which the local frequency is blurred, and the part of the tolerance that the window is designed for;
/// with these, 12 000 random scenes kept their tolerance.
const BLUR: f64 = 0.15;
const SHARE: f64 = 0.2;
/// What is left of the component of one axis across another that runs along it.
const ALIGNED: f64 = 1e-12;

/// What a map of a tolerance promises: the largest error of all its pixels, relative to its peak.
pub fn promised(tolerance: f64) -> f64 {
    if tolerance == 0.0 { EXACT } else { tolerance }
}

/// What to say of a map whose error, relative to its peak, is more than its tolerance promises.
pub fn missed(error: f64, tolerance: f64) -> Option<String> {
    let promised = promised(tolerance);
    (error > promised)
        .then(|| format!("the map's error may be {error:.1e} of its peak, more than the {promised:e} wanted"))
}

/// What things cost an evaluator, in evaluations of one sample-element pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Costs {
    /// One tap of the interpolation.
    pub tap: f64,
    /// A pair that is read from a table that stays in the caches, and from one that does not.
    pub shared_pair: f64,
    pub kept_pair: f64,
}

impl Costs {
    /// The same where not a usual map but so many values are interpolated from the samples.
    pub fn for_values(self, values: usize) -> Self {
        Self { tap: self.tap * values as f64 / USUAL_PIXELS, ..self }
    }

    pub const CPU: Self = Self { tap: 0.06, shared_pair: 0.1, kept_pair: 0.2 };
    /// Without a table.
    pub const GPU: Self = Self { tap: 0.3, shared_pair: 1.0, kept_pair: 1.0 };
}

/// What to evaluate for maps of a plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    pub plane: Plane,
    /// Samples to interpolate from; without, every pixel is evaluated.
    pub grid: Option<Grid>,
    /// The tolerance asks for more than f32 keeps, or the elements for more than it has room for: everything is evaluated
    /// in f64.
    pub double: bool,
    /// Why it is so, for people.
    pub reason: String,
}

/// Samples of a part of the plane, and how pixels are made from them.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    pub samples: Samples,
    /// Places (m) of the first sample along the plane's axes, from its centre, and the distances (m) between samples.
    pub first: DVec2,
    pub step: DVec2,
    /// Places (m) along the plane's second axis between which pixels may be interpolated.
    pub covered: Range<f64>,
    /// The highest spatial frequency (1/m) that matters along each axis.
    pub highest: DVec2,
    /// Half-width (samples) and shape of the window.
    pub half_width: usize,
    pub beta: f64,
    /// For sample columns and sample rows: how they repeat from element to element.
    pub shared: [Option<Shared>; 2],
}

impl Grid {
    /// How values at `places` (m) along an axis, from the plane's centre, are interpolated.
    pub fn resampling(&self, axis: usize, places: impl Iterator<Item = f64>) -> Resampling {
        let in_samples = places.map(|place| (place - self.first[axis]) / self.step[axis]);
        Resampling::new(in_samples, self.half_width, self.beta)
    }

    /// How slopes there are, per metre.
    pub fn slopes(&self, axis: usize, places: impl Iterator<Item = f64>) -> Resampling {
        let in_samples = places.map(|place| (place - self.first[axis]) / self.step[axis]);
        let mut slopes = Resampling::slopes(in_samples, self.half_width, self.beta);
        slopes.weights.iter_mut().for_each(|weight| *weight /= self.step[axis] as f32);
        slopes
    }
}

/// A sample axis that runs along the array with a step that divides the pitch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shared {
    /// 0: along the array's rows, from column to column; 1: the other way.
    pub element_axis: usize,
    /// Samples from one element to the next; negative if the axes are opposed.
    pub samples: isize,
}

impl Plan {
    /// The plan for a plane and its tolerance, by an evaluator with these costs. The tolerance is relative to the map's
    /// peak; 0 asks for direct evaluation.
    /// `None` where the plane's axes span no plane, or its centre, size or tolerance are none that a checked scene has.
    pub fn new(aperture: &Aperture, plane: &Plane, costs: Costs) -> Option<Self> {
        /// m; phases are rounded to whole turns beyond.
        const FARTHEST: f64 = 1e6;
        let is_plane = plane.centre.is_finite()
            && plane.centre.abs().max_element() <= FARTHEST
            && plane.size.is_finite()
            && plane.size.min_element() > 0.0
            && plane.size.max_element() <= FARTHEST
            && (0.0..=1.0).contains(&plane.tolerance);
        let corners = corners(plane).filter(|_| is_plane)?;
        let too_much = promised(plane.tolerance) < f32_error(aperture, &corners);
        let double = too_much || Wave::new(aperture, &corners).is_none();
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

/// An estimate of the f32 evaluators' error relative to the peak: the rounding of the longest path that they see and of places,
/// which mostly averages out over the elements. Where it does not, the measured error tells.
pub fn f32_error(aperture: &Aperture, samples: &Samples) -> f64 {
    let (low, high) = samples.bounds();
    let (first, last) = aperture.corners();
    let across = (high.truncate() - first).abs().max((low.truncate() - last).abs()).length();
    let aside = high.truncate().abs().max(low.truncate().abs()).length();
    let z = low.z.max(0.0);
    let turns = (across.hypot(z) - z + aside * across / across.hypot(z)) / aperture.wavelength();
    let averaging = if aperture.positions.len() > 1 { 0.1 } else { 0.5 };
    (averaging * F32_TURN_ERROR * (turns + 1.0)).max(F32_ERROR)
}

/// What every layout of samples on this plane is measured against.
struct View {
    centre: DVec3,
    axes: [DVec3; 2],
    /// m
    half: DVec2,
    tolerance: f64,
    costs: Costs,
    elements: usize,
    pitch: f64,
    wavelength: f64,
    /// Opposite corners of the array.
    corners: [DVec3; 2],
    /// m, by which an element that is a disk itself reaches beyond its centre.
    disk: f64,
    /// m, the radius that a far field's directivity is of.
    pattern: f64,
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
    shared: [Option<Shared>; 2],
}

impl View {
    fn new(aperture: &Aperture, plane: &Plane, costs: Costs) -> Option<Self> {
        let (x_axis, y_axis) = plane.axes()?;
        let (first, last) = aperture.corners();
        let element = &aperture.element;
        Some(Self {
            centre: plane.centre,
            axes: [x_axis, y_axis],
            half: plane.size / 2.0,
            tolerance: plane.tolerance,
            costs,
            elements: aperture.positions.len(),
            pitch: aperture.pitch,
            wavelength: aperture.wavelength(),
            corners: [first.extend(0.0), last.extend(0.0)],
            disk: if element.model == ElementModel::ExactPiston { element.radius } else { 0.0 },
            pattern: if element.model == ElementModel::Piston { element.radius } else { 0.0 },
        })
    }

    /// Samples for a window, as coarse as the tolerance allows, on as much of the plane as stays clear of the array.
    ///
    /// A Kaiser window of half-width K and shape β passes what lies below ½ - β/2πK cycles per sample and stops what lies
    /// above ½ + β/2πK, to about e^{-β}.
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
        let mut shared = [None; 2];
        if sharing {
            for axis in [0, 1] {
                if let Some((element_axis, sign)) = self.along_array(axis) {
                    let samples = (self.pitch / step[axis]).ceil();
                    step[axis] = self.pitch / samples;
                    shared[axis] = Some(Shared { element_axis, samples: (sign * samples) as isize });
                }
            }
            if shared == [None; 2] {
                return None;
            }
        }
        let covered = self.covered(step * half_width as f64)?;
        Some(Layout { half_width, beta, step, covered, highest, shared })
    }

    /// The array's axis along which an axis of the plane runs, and whether forwards (1) or backwards (-1).
    fn along_array(&self, axis: usize) -> Option<(usize, f64)> {
        let along = self.axes[axis];
        [0, 1].into_iter().find(|&i| (along[i].abs() - 1.0).abs() < ALIGNED).map(|i| (i, along[i].signum()))
    }

    /// How far below its row the lowest sample of a row and its margin may lie.
    fn sagging(&self, margin: DVec2) -> f64 {
        let [x_axis, y_axis] = self.axes;
        (self.half.x + margin.x) * x_axis.z.abs() + margin.y * y_axis.z.abs()
    }

    /// Between which places along the second axis samples, margin included, stay a wavelength away from the array's plane.
    fn covered(&self, margin: DVec2) -> Option<Range<f64>> {
        let lowest = self.wavelength + self.sagging(margin) - self.centre.z;
        let (slope, half) = (self.axes[1].z, self.half.y);
        let covered = if slope.abs() < ALIGNED {
            if lowest > 0.0 { half..half } else { -half..half }
        } else if slope > 0.0 {
            (lowest / slope).max(-half)..half
        } else {
            -half..(lowest / slope).min(half)
        };
        (covered.start < covered.end).then_some(covered)
    }

    /// The highest spatial frequency along an axis, in cycles per wavelength, of which more than e^{-β} is left on what is
    /// covered and its margin.
    ///
    /// It is the sine of the steepest ray, blurred by the curvature of the wave fronts over one Fresnel zone; but no more
    /// than what of the evanescent field, which falls by e^{-2πz√(f²-1)/λ}, comes so far. A directivity 2 J1(ka sinθ)/(ka sinθ)
    /// turns by ka as sinθ does from 0 to 1, and so adds a/z cos³θ. That matters where elements are wider than they are far away.
    fn highest_frequency(&self, axis: usize, covered: &Range<f64>, margin: DVec2, beta: f64) -> f64 {
        let along = self.axes[axis];
        let slope = self.axes[1].z;
        let height = self.centre.z + (covered.start * slope).min(covered.end * slope) - self.sagging(margin);
        let evanescent = beta / (TAU * height / self.wavelength);
        let pattern = self.pattern / height;
        // sinθ + a/z cos³θ ≤ √(1 + a²/z²)
        let most = 1f64.hypot(evanescent.max(pattern));
        if along.z.abs() > 1e-9 {
            return most;
        }
        let [low, high] = self.corners;
        let reach = [low, high, DVec3::new(low.x, high.y, 0.0)].map(|corner| corner.dot(along).abs());
        let array = reach.into_iter().fold(0.0, f64::max) + self.disk;
        let longest = self.centre.dot(along).abs() + self.half[axis] + margin[axis] + array;
        let blur = (BLUR * (beta * self.wavelength / height).sqrt()).max(pattern);
        (longest / longest.hypot(height) + blur).min(most)
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
        let pairs = self.samples(layout) * self.elements as f64;
        let taps = USUAL_PIXELS * (2 * layout.half_width) as f64;
        let is_kept = pairs * size_of::<Complex32>() as f64 <= TABLE_CEILING as f64;
        let pair = match layout.shared {
            [None, None] if is_kept => self.costs.kept_pair,
            [None, None] => 1.0,
            _ => self.costs.shared_pair,
        };
        pair * pairs + self.costs.tap * taps
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
            shared: layout.shared,
        }
    }
}
