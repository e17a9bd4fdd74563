//! The second harmonic on a plane: plane waves of 2f, marched through the air.
//!
//! The air is cut into planes across the mean direction of the boards, and P² is sampled on a lattice of each, finer
//! than its shortest wave of λ/2. Of every transverse wavenumber (u, v), with κ = √(K² - u² - v²), a plane at z hears
//!
//! ```text
//! -q/(2jκ) [∫_{z' < z} e^{-jκ(z - z')} S(z') dz' + ∫_{z' > z} e^{-jκ(z' - z)} S(z') dz'],    S: spectrum of P²
//! ```
//!
//! which two sweeps sum step by step: A(z + h) = e^{-jκh} A(z) + the step's own part. In front of boards of one direction S turns
//! as e^{-jκz} or a little slower, so S e^{jκz} is taken as straight from plane to plane and the step is integrated in
//! closed form (Filon): exact for any step as long as waves of 2f and their source keep pace, and as good for the
//! sweep against the sound, where the integrand turns by 2κ. Between boards that face each other sound runs both ways;
//! there planes are closer, and the
//! trapezoidal rule sums waves of either way: those that keep pace are constant, and those against it turn by less than half a
//! turn per step.
//!
//! Spectra are those of a lattice twice as wide, so that the periodic repetitions do not overlap on the plane.
//! Pixels are interpolated by a Kaiser window within planes, on a lattice of half the step, and by six planes across.
//!
//! The error is that of the steps: everything is repeated with steps of 5/4, and since it is of second order, the
//! difference over (5/4)² - 1 is the error of the finer.

use glam::{DVec2, DVec3};
use num_complex::{Complex32, Complex64};
use rayon::prelude::*;
use sonoglyph_fourier::{Transform, transform};

use crate::acoustics::{Air, Aperture};
use crate::drive::Drive;
use crate::field::gpu_report::GpuError;
use crate::field::harmonic::source::{self, NEAREST, NoHarmonic};
use crate::field::interpolation::Resampling;
use crate::field::samples::Samples;
use crate::gauge::{self, Gauge};
use crate::scene::Plane;

/// Samples per wavelength of the fundamental, of the map and of its comparison; four would just hold P².
const PER_WAVELENGTH: f64 = 5.0;
const COMPARED: f64 = 4.0;
/// Planes for every sample between boards that face each other.
const BOTH_WAYS: f64 = 3.0;
/// Air beyond the array's outline, and behind the plane, in wavelengths.
const MARGIN: f64 = 2.0;
const BEHIND: f64 = 2.0;
/// Height (in steps) up to which samples beside elements are means of `BESIDE`² places.
const LOW: f64 = 1.5;
const BESIDE: usize = 3;
/// Limit of samples along an axis, and of all samples of spectra.
const MOST_ALONG: usize = 1 << 10;
const MOST: usize = 1 << 25;
/// Half-width and shape of the window: 1e-3 off for waves of 9 samples to two cycles.
const HALF_WIDTH: usize = 4;
const BETA: f64 = 7.0;
/// Planes of an interpolation across them.
const TAPS: usize = 6;
/// Smallest absorption in the spectrum, Np/m: grazing waves never end in still air.
const LEAST_ABSORPTION: f64 = 0.05;

/// The harmonic over a plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Overtone {
    /// RMS pressure at 2f of every pixel, Pa, row by row.
    pub values: Vec<f32>,
    /// Estimate of the largest error of a pixel, relative to the largest value.
    pub error: f64,
    /// Number of places with the pressure of the fundamental.
    pub evaluated: usize,
    /// Step (m) within and between planes, and number of planes.
    pub steps: [f64; 2],
    pub planes: usize,
}

/// An evaluator of a drive's complex pressure (Pa, peak) at samples.
pub type Sampler<'a> = &'a dyn Fn(&Drive, &Samples) -> Result<Vec<Complex32>, GpuError>;

/// Errors of a harmonic over a plane.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MarchError {
    #[error(transparent)]
    None(#[from] NoHarmonic),
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

/// The RMS pressure at 2f on a plane of `size` pixels, of the mean square over drives in turn.
///
/// # Errors
/// Reflectors that are not rigid, too much air, or an error of the evaluator.
pub fn over(
    (aperture, air): (&Aperture, &Air),
    drives: &[Drive],
    (plane, size): (&Plane, (usize, usize)),
    sample: Sampler<'_>,
    progress: &Gauge,
) -> Result<Overtone, MarchError> {
    source::check(aperture)?;
    let silent =
        Overtone { values: vec![0.0; size.0 * size.1], error: 0.0, evaluated: 0, steps: [0.0; 2], planes: 0 };
    let (Some(fine), Some(compared)) =
        (Slab::new(aperture, plane, PER_WAVELENGTH)?, Slab::new(aperture, plane, COMPARED)?)
    else {
        return Ok(silent);
    };
    let steps = fine.planes.len() + compared.planes.len();
    let own = progress.part(0..fine.planes.len(), steps);
    let squares = fine.squares((aperture, air), drives, (plane, size), sample, &own)?;
    let other = progress.part(fine.planes.len()..steps, steps);
    let coarse = compared.squares((aperture, air), drives, (plane, size), sample, &other)?;
    let values: Vec<_> = squares.iter().map(|square| square.sqrt() as f32).collect();
    let largest = values.iter().copied().fold(0.0, f32::max);
    let off = values.iter().zip(&coarse).map(|(value, square)| (f64::from(*value) - square.sqrt()).abs());
    let off = off.fold(0.0, f64::max) / ((PER_WAVELENGTH / COMPARED).powi(2) - 1.0);
    Ok(Overtone {
        error: if largest > 0.0 { off / f64::from(largest) } else { 0.0 },
        values,
        evaluated: drives.len() * (fine.places() + compared.places()),
        steps: [fine.step, fine.between()],
        planes: fine.planes.len(),
    })
}

/// The air in planes, each a lattice along the first two axes.
struct Slab {
    /// Two along the planes, and the direction of the march.
    axes: [DVec3; 3],
    /// m along the first two axes, of the first sample.
    first: DVec2,
    /// m
    step: f64,
    counts: [usize; 2],
    /// Samples of a spectrum along the axes.
    padded: [usize; 2],
    /// m along the third, ascending, at equal distances.
    planes: Vec<f64>,
    /// Heights of flat boards, m along the third axis.
    boards: Vec<f64>,
    is_both_ways: bool,
}

impl Slab {
    /// `None` without air between the boards and the plane.
    fn new(aperture: &Aperture, plane: &Plane, per_wavelength: f64) -> Result<Option<Self>, NoHarmonic> {
        let elements = source::elements(aperture);
        let Some((x, y)) = plane.axes() else { return Ok(None) };
        let Some(&(_, first)) = elements.first() else { return Ok(None) };
        let mean = elements.iter().map(|(_, normal)| *normal).sum::<DVec3>() / elements.len() as f64;
        let along = mean.try_normalize().filter(|_| mean.length() > 0.3).unwrap_or(first);
        let is_parallel = x.cross(y).dot(along).abs() > 1.0 - 1e-12;
        let (x_axis, y_axis) = if is_parallel { (x, y) } else { along.any_orthonormal_pair() };
        let axes = [x_axis, y_axis, along];
        let place = |point: DVec3| DVec3::from_array(axes.map(|axis| point.dot(axis)));
        let wavelength = aperture.wavelength();
        let margin = source::wavelengths(aperture, MARGIN);
        let half = plane.size / 2.0;
        let corners = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
        let corners = corners.map(|(a, b)| place(plane.centre + x * (a * half.x) + y * (b * half.y)));
        let bounds = |points: &mut dyn Iterator<Item = DVec3>| {
            points.fold((DVec3::MAX, DVec3::MIN), |(low, high), at| (low.min(at), high.max(at)))
        };
        let (low, high) = bounds(&mut elements.iter().map(|(at, _)| place(*at)));
        let (plane_low, plane_high) = bounds(&mut corners.into_iter());
        let is_both_ways = elements.iter().any(|(_, normal)| normal.dot(along) < 0.0);
        let (start, end) = match is_both_ways {
            true => (low.z, high.z),
            false => (low.z, plane_high.z + source::wavelengths(aperture, BEHIND)),
        };
        if plane_high.z <= start || end <= start {
            return Ok(None);
        }
        let step = wavelength / per_wavelength;
        let between = if is_both_ways { step / BOTH_WAYS } else { step };
        // A parallel plane is one of the planes.
        let anchor = if is_parallel { plane_high.z.min(end) } else { end };
        let between = (anchor - start) / ((anchor - start) / between).ceil().max(1.0);
        let count = ((end - start) / between - 1e-6).ceil().min(MOST as f64) as usize + 1;
        let (low, high) = (low.min(plane_low).truncate() - margin, high.max(plane_high).truncate() + margin);
        let counts = ((high - low) / step).ceil() + 1.0;
        if counts.is_nan() || counts.max_element() > MOST_ALONG as f64 {
            return Err(NoHarmonic::TooLarge);
        }
        let counts = [counts.x as usize, counts.y as usize];
        let padded = counts.map(|count| smooth(2 * count));
        if padded[0] * padded[1] * count > MOST {
            return Err(NoHarmonic::TooLarge);
        }
        let is_flat = |n: &DVec3| n.dot(along).abs() > 1.0 - 1e-9;
        let mut boards: Vec<f64> = match elements.iter().all(|(_, normal)| is_flat(normal)) {
            true => elements.iter().map(|(at, _)| at.dot(along)).collect(),
            false => Vec::new(),
        };
        boards.sort_by(f64::total_cmp);
        boards.dedup_by(|a, b| (*a - *b).abs() < NEAREST * wavelength);
        let planes = (0..count).map(|i| start + between * i as f64).collect();
        Ok(Some(Self { axes, first: low, step, counts, padded, planes, boards, is_both_ways }))
    }

    fn between(&self) -> f64 {
        self.planes.get(1).map_or(self.step, |second| second - self.planes[0])
    }

    /// Number of places per drive.
    fn places(&self) -> usize {
        let beside = |&z: &f64| if self.is_low(z) { BESIDE * BESIDE } else { 1 };
        self.counts[0] * self.counts[1] * self.planes.iter().map(beside).sum::<usize>()
    }

    /// Whether a plane is so close to elements that their sound varies within a step.
    fn is_low(&self, z: f64) -> bool {
        self.boards.iter().any(|board| (z - board).abs() < LOW * self.step)
    }

    /// The mean over drives of the squared RMS pressure, Pa², of every pixel.
    fn squares(
        &self,
        (aperture, air): (&Aperture, &Air),
        drives: &[Drive],
        (plane, size): (&Plane, (usize, usize)),
        sample: Sampler<'_>,
        progress: &Gauge,
    ) -> Result<Vec<f64>, MarchError> {
        let view = View::new(self, aperture, plane, size);
        let steps = Steps::new(self, aperture, air);
        let factor = -source::source(aperture, air);
        let mut squares = vec![0.0; size.0 * size.1];
        for (number, drive) in drives.iter().enumerate() {
            let progress = progress.part(number..number + 1, drives.len());
            let mut sources = Vec::with_capacity(self.planes.len());
            for (index, &z) in self.planes.iter().enumerate() {
                if gauge::is_cancelled() || progress.is_cancelled() {
                    return Ok(squares);
                }
                sources.push(self.source(aperture, drive, z, sample, &steps.transforms)?);
                progress.tell(index + 1, self.planes.len());
            }
            let mut sound = vec![Complex64::ZERO; size.0 * size.1];
            for (index, spectrum) in steps.sweep(&sources, &view.needed) {
                view.add(self, index, &steps.transforms.wider(&spectrum, self.padded), &mut sound);
            }
            // P² is half of its square.
            let part = factor * factor / 2.0 / drives.len() as f64;
            squares.iter_mut().zip(&sound).for_each(|(square, p)| *square += part * p.norm_sqr());
        }
        Ok(squares)
    }

    /// The spectrum of P² on a plane.
    fn source(
        &self,
        aperture: &Aperture,
        drive: &Drive,
        z: f64,
        sample: Sampler<'_>,
        transforms: &Transforms,
    ) -> Result<Vec<Complex32>, GpuError> {
        let [x, y, up] = self.axes;
        // Sound has its own side of a board: the first plane is that in front of it.
        let clear = NEAREST * aperture.wavelength();
        let z = self.boards.iter().find(|board| (z - **board).abs() < clear).map_or(z, |&board| {
            let is_last = self.is_both_ways
                && board > f64::midpoint(self.planes[0], self.planes[self.planes.len() - 1]);
            if is_last { board - clear } else { board + clear }
        });
        let beside = if self.is_low(z) { BESIDE } else { 1 };
        let mut square = vec![Complex64::ZERO; self.padded[0] * self.padded[1]];
        for (i, j) in (0..beside * beside).map(|place| (place % beside, place / beside)) {
            let off = |i: usize| self.step * ((i as f64 + 0.5) / beside as f64 - 0.5);
            let along = |axis: DVec3, at: f64, count: usize| {
                (0..count).map(move |n| axis * (at + self.step * n as f64))
            };
            let samples = Samples {
                columns: along(x, self.first.x + off(i), self.counts[0]).map(|at| at + up * z).collect(),
                rows: along(y, self.first.y + off(j), self.counts[1]).collect(),
            };
            let part = 1.0 / (beside * beside) as f64;
            for (row, pressures) in sample(drive, &samples)?.chunks(self.counts[0]).enumerate() {
                for (sum, p) in square[row * self.padded[0]..].iter_mut().zip(pressures) {
                    let p = Complex64::new(f64::from(p.re), f64::from(p.im));
                    *sum += part * p * p;
                }
            }
        }
        transforms.both.process(&mut square);
        Ok(square.into_iter().map(narrow).collect())
    }
}

fn narrow(z: Complex64) -> Complex32 {
    Complex32::new(z.re as f32, z.im as f32)
}

fn widen(z: Complex32) -> Complex64 {
    Complex64::new(f64::from(z.re), f64::from(z.im))
}

/// The smallest even product of 2, 3 and 5 that is not below `least`.
fn smooth(least: usize) -> usize {
    let rest = |count: usize, factor: usize| {
        std::iter::successors(Some(count), |rest| rest.is_multiple_of(factor).then(|| rest / factor)).last()
    };
    let is_smooth =
        |&count: &usize| [2, 3, 5].iter().fold(count, |left, &f| rest(left, f).unwrap_or(left)) == 1;
    (least.next_multiple_of(2)..).step_by(2).find(is_smooth).unwrap_or(least)
}

/// Two-dimensional transforms of spectra, and of the twice finer lattice of what is interpolated.
struct Transforms {
    both: Transform2,
    finer: Transform2,
}

/// Transforms along both axes of a lattice.
struct Transform2 {
    counts: [usize; 2],
    along: [Transform; 2],
}

impl Transform2 {
    fn new(counts: [usize; 2]) -> Self {
        Self { counts, along: counts.map(transform) }
    }

    /// The transform with e^{-j}, not normalised.
    fn process(&self, values: &mut [Complex64]) {
        let [columns, rows] = self.counts;
        values.par_chunks_mut(columns).for_each(|row| self.along[0].process(row));
        let mut turned = transposed(values, columns);
        turned.par_chunks_mut(rows).for_each(|column| self.along[1].process(column));
        values.copy_from_slice(&transposed(&turned, rows));
    }
}

fn transposed(values: &[Complex64], columns: usize) -> Vec<Complex64> {
    let rows = values.len() / columns;
    let mut turned = vec![Complex64::ZERO; values.len()];
    turned.par_chunks_mut(rows).enumerate().for_each(|(column, to)| {
        to.iter_mut().enumerate().for_each(|(row, to)| *to = values[row * columns + column]);
    });
    turned
}

impl Transforms {
    /// The values of a spectrum on the twice finer lattice.
    fn wider(&self, spectrum: &[Complex64], [columns, rows]: [usize; 2]) -> Vec<Complex64> {
        // The inverse is the conjugate of the transform of the conjugate.
        let mut values = vec![Complex64::ZERO; 4 * columns * rows];
        let place = |i: usize, count: usize| if i < count / 2 { i } else { i + count };
        for row in 0..rows {
            for column in 0..columns {
                values[place(row, rows) * 2 * columns + place(column, columns)] =
                    spectrum[row * columns + column].conj() / (columns * rows) as f64;
            }
        }
        self.finer.process(&mut values);
        values.iter_mut().for_each(|value| *value = value.conj());
        values
    }
}

/// A step between planes, for every wavenumber.
struct Step {
    /// e^{-jκh}
    onward: Complex64,
    /// Weights of the source on both planes in the sound of the farther one, and the same for the way back.
    forward: [Complex64; 2],
    back: [Complex64; 2],
    /// 1/(2jκ)
    green: Complex64,
}

/// All steps, which are alike.
struct Steps {
    steps: Vec<Step>,
    transforms: Transforms,
}

impl Steps {
    fn new(slab: &Slab, aperture: &Aperture, air: &Air) -> Self {
        let h = slab.between();
        let absorption = air.attenuation_of_second.max(LEAST_ABSORPTION);
        let second = Complex64::new(2.0 * aperture.element.wavenumber, -absorption);
        let [columns, rows] = slab.padded;
        let wavenumber = |i: usize, count: usize| {
            let turns = if i < count / 2 { i as f64 } else { i as f64 - count as f64 };
            std::f64::consts::TAU * turns / (count as f64 * slab.step)
        };
        let step = |index: usize| {
            let (u, v) = (wavenumber(index % columns, columns), wavenumber(index / columns, rows));
            // The root that decays.
            let root = (second * second - u * u - v * v).sqrt();
            let along = if root.im > 0.0 { -root } else { root };
            let onward = (Complex64::new(0.0, -h) * along).exp();
            let green = (Complex64::new(0.0, 2.0) * along).inv();
            let half = Complex64::new(h / 2.0, 0.0);
            if slab.is_both_ways {
                return Step { onward, forward: [onward * half, half], back: [half, onward * half], green };
            }
            let pace = along.re;
            let paced = Complex64::cis(pace * h);
            let (first, second) = ramps(Complex64::new(0.0, h) * (along - pace));
            let (near, far) = ramps(Complex64::new(0.0, -h) * (along + pace));
            Step {
                onward,
                forward: [onward * first * h, onward * paced * second * h],
                back: [near * h, paced * far * h],
                green,
            }
        };
        Self {
            steps: (0..columns * rows).into_par_iter().map(step).collect(),
            transforms: Transforms {
                both: Transform2::new([columns, rows]),
                finer: Transform2::new([2 * columns, 2 * rows]),
            },
        }
    }

    /// The spectra of the sound over -q on the needed planes.
    fn sweep<'a>(
        &'a self,
        sources: &'a [Vec<Complex32>],
        needed: &'a [bool],
    ) -> impl Iterator<Item = (usize, Vec<Complex64>)> + 'a {
        let count = self.steps.len();
        let last = sources.len() - 1;
        let mut back: Vec<Option<Vec<Complex32>>> = vec![None; sources.len()];
        let mut sound = vec![Complex64::ZERO; count];
        let lowest = needed.iter().position(|needed| *needed).unwrap_or(last);
        for plane in (lowest..=last).rev() {
            if plane < last {
                let pairs = sources[plane].par_iter().zip(&sources[plane + 1]);
                sound.par_iter_mut().zip(&self.steps).zip(pairs).for_each(|((sound, step), (near, far))| {
                    *sound = step.onward * *sound + step.back[0] * widen(*near) + step.back[1] * widen(*far);
                });
            }
            if needed[plane] {
                back[plane] = Some(sound.iter().copied().map(narrow).collect());
            }
        }
        let mut sound = vec![Complex64::ZERO; count];
        (0..=last).filter_map(move |plane| {
            if plane > 0 {
                let pairs = sources[plane - 1].par_iter().zip(&sources[plane]);
                sound.par_iter_mut().zip(&self.steps).zip(pairs).for_each(
                    |((sound, step), (before, here))| {
                        *sound = step.onward * *sound
                            + step.forward[0] * widen(*before)
                            + step.forward[1] * widen(*here);
                    },
                );
            }
            let back = back[plane].take()?;
            let both = sound.iter().zip(back).zip(&self.steps);
            Some((plane, both.map(|((sound, back), step)| (sound + widen(back)) * step.green).collect()))
        })
    }
}

/// ∫ (1 - v) e^{xv} dv and ∫ v e^{xv} dv from 0 to 1.
fn ramps(x: Complex64) -> (Complex64, Complex64) {
    if x.norm() < 0.5 {
        // Σ xⁿ/(n + 2)! and Σ (n + 1) xⁿ/(n + 2)!
        let (mut power, mut falling, mut rising) =
            (Complex64::new(0.5, 0.0), Complex64::ZERO, Complex64::ZERO);
        for n in 0..14 {
            falling += power;
            rising += power * f64::from(n + 1);
            power *= x / f64::from(n + 3);
        }
        return (falling, rising);
    }
    let growth = x.exp();
    ((growth - 1.0 - x) / (x * x), (growth * (x - 1.0) + 1.0) / (x * x))
}

/// The pixels of a plane in the air.
struct View {
    /// Pixels in a row.
    width: usize,
    /// m along the axes of the air: the first pixel, and from pixel to pixel along rows and columns.
    first: DVec3,
    across: DVec3,
    up: DVec3,
    /// Wavenumber (rad/m) of the harmonic across planes, taken out for the interpolation.
    pace: f64,
    /// Planes with pixels near them.
    needed: Vec<bool>,
}

impl View {
    fn new(slab: &Slab, aperture: &Aperture, plane: &Plane, (width, height): (usize, usize)) -> Self {
        /// Mean direction of waves towards a focus.
        const SLANT: f64 = 0.85;
        let place = |point: DVec3| DVec3::from_array(slab.axes.map(|axis| point.dot(axis)));
        let (x, y) = plane.axes().unwrap_or((DVec3::X, DVec3::Y));
        let (across, up) =
            (place(x) * (plane.size.x / width as f64), place(y) * (plane.size.y / height as f64));
        let first =
            place(plane.centre) - across * (width as f64 - 1.0) / 2.0 - up * (height as f64 - 1.0) / 2.0;
        let pace = if slab.is_both_ways { 0.0 } else { SLANT * 2.0 * aperture.element.wavenumber };
        let view = Self { width, first, across, up, pace, needed: Vec::new() };
        let ends = |index: usize| {
            let row = first.z + up.z * index as f64;
            [row, row + across.z * (width as f64 - 1.0)]
        };
        let heights = [0, height - 1].into_iter().flat_map(ends);
        let (low, high) = heights.fold((f64::MAX, f64::MIN), |(low, high), z| (low.min(z), high.max(z)));
        let [low, high] = [low, high].map(|z| (z - slab.planes[0]) / slab.between());
        let count = slab.planes.len();
        let is_on_plane = (high - low).abs() < 1e-6 && (low - low.round()).abs() < 1e-6;
        let reach = if is_on_plane { 0.0 } else { TAPS as f64 / 2.0 };
        // At the ends the six planes are those that there are.
        let first_of = |place: f64| (place - reach).floor().clamp(0.0, count.saturating_sub(TAPS) as f64);
        let needed = match is_on_plane {
            true => (0..count).map(|plane| plane == low.round() as usize).collect(),
            false => (0..count)
                .map(|plane| {
                    let plane = plane as f64;
                    plane >= first_of(low) && plane <= first_of(high) + TAPS as f64
                })
                .collect(),
        };
        Self { needed, ..view }
    }

    /// Weight of a plane for a place between planes: Lagrange's of six planes.
    fn weight(&self, plane: usize, place: f64, count: usize) -> f64 {
        let nearest = place.round();
        if (place - nearest).abs() < 1e-6 {
            return if plane as f64 == nearest { 1.0 } else { 0.0 };
        }
        let taps = TAPS.min(count);
        let start = (place.floor() - (taps as f64 / 2.0 - 1.0)).clamp(0.0, (count - taps) as f64) as usize;
        if !(start..start + taps).contains(&plane) || place < 0.0 || place > (count - 1) as f64 {
            return 0.0;
        }
        let others = (start..start + taps).filter(|&other| other != plane);
        others.map(|other| (place - other as f64) / (plane as f64 - other as f64)).product()
    }

    /// Adds the share of a plane to the sound of every pixel.
    fn add(&self, slab: &Slab, plane: usize, values: &[Complex64], sound: &mut [Complex64]) {
        let (count, between) = (slab.planes.len(), slab.between());
        let columns = 2 * slab.padded[0];
        let half = slab.step / 2.0;
        sound.par_chunks_mut(self.width).enumerate().for_each(|(row, sound)| {
            let start = self.first + self.up * row as f64;
            let place = |column: usize| start + self.across * column as f64;
            let along = |axis: usize| {
                let positions = (0..self.width).map(|column| (place(column)[axis] - slab.first[axis]) / half);
                Resampling::new(positions, HALF_WIDTH, BETA)
            };
            let [across, up] = [along(0), along(1)];
            for (column, sound) in sound.iter_mut().enumerate() {
                let z = place(column).z;
                let weight = self.weight(plane, (z - slab.planes[0]) / between, count);
                if weight == 0.0 {
                    continue;
                }
                let ((first, across), (bottom, up)) = (across.of(column, 1), up.of(column, 1));
                let mut sum = Complex64::ZERO;
                for (tap, up) in up.iter().enumerate() {
                    let line = &values[(bottom + tap) * columns + first..][..across.len()];
                    let of_line: Complex64 =
                        line.iter().zip(across).map(|(value, part)| value * f64::from(*part)).sum();
                    sum += of_line * f64::from(*up);
                }
                *sound += sum * weight * Complex64::cis(self.pace * (slab.planes[plane] - z));
            }
        });
    }
}
