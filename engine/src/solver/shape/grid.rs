//! Transfers to samples on a plane parallel to the array, by Fourier transforms.
//!
//! Samples at 1/S of the pitch are S² grids of the array's own pitch. To each of them the transfer depends only on
//! the difference of the indices, so it is a convolution: a product of spectra.

use std::collections::BTreeSet;

use glam::{DVec2, DVec3};

use crate::acoustics::Aperture;
use crate::simd::{Instructions, Isa, Kernel};
use crate::solver::shape::fft::{self, Plan, transpose};
use crate::solver::shape::real::{LANES, Real, Waves, lanes};

/// The layout of samples, symmetric about the array's axis in x and y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    /// m, above the array.
    pub height: f64,
    /// Samples of one grid along x and y.
    pub samples: [usize; 2],
    /// Lengths of the transforms along x and y.
    lengths: [usize; 2],
    /// S: grids along each axis.
    pub grids: usize,
}

impl Layout {
    /// The layout at a height (m), up to `reach` (m) along x and y from the axis, or slightly farther at no cost.
    pub fn new(aperture: &Aperture, height: f64, reach: DVec2, grids: usize) -> Self {
        let elements = elements(aperture);
        let least = reach.to_array().map(|reach| {
            let spans = 2.0 * reach / aperture.pitch + 1.0 / grids as f64;
            spans.ceil().max(1.0) as usize
        });
        let lengths = [0, 1].map(|axis| fft::length(least[axis] + elements[axis] - 1));
        let samples = [0, 1].map(|axis| lengths[axis] + 1 - elements[axis]);
        Self { height, samples, lengths, grids }
    }

    /// Values of one transform.
    pub fn area(&self) -> usize {
        self.lengths[0] * self.lengths[1]
    }

    /// Samples of a row, padded to whole blocks of lanes.
    fn width(&self) -> usize {
        self.samples[0].next_multiple_of(LANES)
    }

    /// Values that a field has, padding included.
    pub fn len(&self) -> usize {
        self.grids * self.grids * self.samples[1] * self.width()
    }

    /// m, between neighbouring samples.
    pub fn spacing(&self, pitch: f64) -> f64 {
        pitch / self.grids as f64
    }

    /// Index, in pitches over 2 S, of a sample along an axis, counted from the array's middle.
    fn steps(&self, axis: usize, grid: usize, sample: usize) -> i64 {
        let [grids, samples, grid, sample] =
            [self.grids, self.samples[axis], grid, sample].map(|count| count as i64);
        2 * grids * sample - grids * (samples - 1) + 2 * grid - (grids - 1)
    }

    /// m
    fn coordinate(&self, pitch: f64, axis: usize, grid: usize, sample: usize) -> f64 {
        self.steps(axis, grid, sample) as f64 * pitch / (2 * self.grids) as f64
    }

    /// Every sample: its index in a field, and its position (m).
    pub fn places(&self, pitch: f64) -> impl Iterator<Item = (usize, DVec2)> {
        let (layout, width) = (*self, self.width());
        let grids = (0..layout.grids).flat_map(move |y| (0..layout.grids).map(move |x| [x, y]));
        grids.flat_map(move |grid| {
            let first = (grid[1] * layout.grids + grid[0]) * layout.samples[1];
            let along = move |axis: usize, sample: usize| layout.coordinate(pitch, axis, grid[axis], sample);
            (0..layout.samples[1]).flat_map(move |y| {
                (0..layout.samples[0])
                    .map(move |x| ((first + y) * width + x, DVec2::new(along(0, x), along(1, y))))
            })
        })
    }

    /// Indices of the samples in a field, row by row of the plane.
    pub fn rows(&self) -> Vec<usize> {
        let (grids, width) = (self.grids, self.width());
        let index = |x: usize, y: usize| {
            let grid = y % grids * grids + x % grids;
            (grid * self.samples[1] + y / grids) * width + x / grids
        };
        let [columns, rows] = self.samples.map(|samples| samples * grids);
        (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y))).map(|(x, y)| index(x, y)).collect()
    }

    /// The samples of [`Layout::places`] within `reach` (m) along x and along y of a place.
    pub fn places_near(&self, pitch: f64, at: DVec2, reach: f64) -> impl Iterator<Item = (usize, DVec2)> {
        let (layout, width) = (*self, self.width());
        let near = [0, 1].map(|axis| {
            let all = (0..layout.grids)
                .flat_map(|grid| (0..layout.samples[axis]).map(move |sample| (grid, sample)));
            let place = |(grid, sample)| (grid, sample, layout.coordinate(pitch, axis, grid, sample));
            let is_near = |&(_, _, place): &(usize, usize, f64)| (place - at[axis]).abs() <= reach;
            all.map(place).filter(is_near).collect::<Vec<_>>()
        });
        let [along_x, along_y] = near;
        along_y.into_iter().flat_map(move |(grid_y, sample_y, y)| {
            let index = move |grid_x: usize, sample_x: usize| {
                ((grid_y * layout.grids + grid_x) * layout.samples[1] + sample_y) * width + sample_x
            };
            let place = move |(grid, sample, x)| (index(grid, sample), DVec2::new(x, y));
            along_x.clone().into_iter().map(place)
        })
    }
}

/// Elements along x and y.
///
/// # Panics
/// An aperture without a lattice.
fn elements(aperture: &Aperture) -> [usize; 2] {
    aperture.lattice().expect("grids are laid out for lattices alone")
}

/// The map from the driven elements to samples, and back.
#[derive(Clone, Debug)]
pub struct Grid<T> {
    pub layout: Layout,
    elements: [usize; 2],
    /// Indices of the driven elements in rows padded to whole blocks of lanes.
    driven: Vec<usize>,
    plans: [Plan<T>; 2],
    /// Spectra of the transfers to each grid: rows along kx, lanes along ky.
    spectra: Vec<Waves<T>>,
    /// Spectrum of the excitation, or of its back-propagated field.
    spectrum: Waves<T>,
    work: Waves<T>,
    spare: Waves<T>,
}

impl<T: Real> Grid<T> {
    /// The grid of transfers times `scale`.
    pub fn new(aperture: &Aperture, layout: Layout, scale: f64) -> Self {
        let elements = elements(aperture);
        let padded = elements[0].next_multiple_of(LANES);
        let driven = aperture.driven.iter().map(|n| n / elements[0] * padded + n % elements[0]).collect();
        let plans = layout.lengths.map(Plan::new);
        let room = || Waves::zeros(layout.area());
        let spectra = spectra(fields(aperture, &layout, scale / layout.area() as f64), &plans);
        Self { layout, elements, driven, plans, spectra, spectrum: room(), work: room(), spare: room() }
    }

    /// p = H u at every sample; the padding of rows of p is undefined.
    pub fn forward(&mut self, u: &Waves<T>, p: &mut Waves<T>) {
        let Self { layout, elements, driven, plans: [along_x, along_y], spectra, spectrum, work, spare } =
            self;
        let (y, samples, width) = (layout.lengths[1], layout.samples, layout.width());
        let padded = elements[0].next_multiple_of(LANES);
        work.clear();
        for ((&place, &re), &im) in driven.iter().zip(&u.re).zip(&u.im) {
            (work.re[place], work.im[place]) = (re, im);
        }
        along_y.run(padded, elements[1], work, spare);
        spectrum.clear();
        transpose(work, spectrum, [y, elements[0]], [padded, y]);
        along_x.run(y, elements[0], spectrum, spare);
        let values = samples[1] * width;
        for (transfer, at) in spectra.iter().zip((0..).step_by(values)) {
            Isa::best().run(Product { a: transfer, b: spectrum, to: work });
            along_x.run_back(y, work, spare);
            transpose(work, spare, [samples[0], y], [y, width]);
            along_y.run_back(width, spare, work);
            p.re[at..at + values].copy_from_slice(&spare.re[..values]);
            p.im[at..at + values].copy_from_slice(&spare.im[..values]);
        }
    }

    /// b += Hᴴ p; the padding of rows of p is 0.
    pub fn back(&mut self, p: &Waves<T>, b: &mut Waves<T>) {
        let Self { layout, elements, driven, plans: [along_x, along_y], spectra, spectrum, work, spare } =
            self;
        let (y, samples, width) = (layout.lengths[1], layout.samples, layout.width());
        let padded = elements[0].next_multiple_of(LANES);
        spectrum.clear();
        let values = samples[1] * width;
        for (transfer, at) in spectra.iter().zip((0..).step_by(values)) {
            work.re[..values].copy_from_slice(&p.re[at..at + values]);
            work.im[..values].copy_from_slice(&p.im[at..at + values]);
            work.re[values..].fill(T::default());
            work.im[values..].fill(T::default());
            along_y.run(width, samples[1], work, spare);
            transpose(work, spare, [y, samples[0]], [width, y]);
            spare.re[samples[0] * y..].fill(T::default());
            spare.im[samples[0] * y..].fill(T::default());
            along_x.run(y, samples[0], spare, work);
            Isa::best().run(Correlation { a: transfer, b: spare, to: spectrum });
        }
        along_x.run_back(y, spectrum, spare);
        transpose(spectrum, work, [elements[0], y], [y, padded]);
        along_y.run_back(padded, work, spare);
        for ((&place, re), im) in driven.iter().zip(&mut b.re).zip(&mut b.im) {
            *re += work.re[place];
            *im += work.im[place];
        }
    }
}

/// The transfers to every grid by the difference of the indices of sample and element, modulo the lengths: rows along x, lanes
/// along y.
fn fields<T: Real>(aperture: &Aperture, layout: &Layout, scale: f64) -> Vec<Waves<T>> {
    let elements = elements(aperture);
    // Distances along an axis, in pitches over 2 S; the transfer is even in both.
    let away = |axis: usize, grid: usize, index: usize| {
        let (samples, length) = (layout.samples[axis], layout.lengths[axis]);
        let steps = layout.steps(axis, grid, 0) + layout.grids as i64 * (elements[axis] as i64 - 1);
        let turned = if index < samples { index as i64 } else { index as i64 - length as i64 };
        (2 * layout.grids as i64 * turned + steps).unsigned_abs()
    };
    let distances = [0, 1].map(|axis| {
        let all =
            (0..layout.grids).flat_map(|grid| (0..layout.lengths[axis]).map(move |index| (grid, index)));
        let all: BTreeSet<_> = all.map(|(grid, index)| away(axis, grid, index)).collect();
        all.into_iter().collect::<Vec<_>>()
    });
    let metres = |steps: &u64| *steps as f64 * aperture.pitch / (2 * layout.grids) as f64;
    // One element at every distance along y, one point at every distance along x.
    let places: Vec<_> = distances[1].iter().map(|steps| DVec3::Y * metres(steps)).collect();
    let lines = places.len();
    let column = aperture.with_elements(places);
    let points: Vec<_> =
        distances[0].iter().map(|steps| DVec3::new(metres(steps), 0.0, layout.height)).collect();
    let transfer = column.transfer(&points);
    let values = transfer.rows().flatten().map(|value| value * scale);
    let (re, im): (Vec<_>, Vec<_>) = values.map(|value| (T::of(value.re), T::of(value.im))).unzip();
    let index = |axis: usize, grid: usize| {
        let place = |index: usize| distances[axis].binary_search(&away(axis, grid, index)).unwrap_or(0);
        (0..layout.lengths[axis]).map(place).collect::<Vec<_>>()
    };
    let indices = [0, 1].map(|axis| (0..layout.grids).map(|grid| index(axis, grid)).collect::<Vec<_>>());
    let field = |grid: usize| {
        let (along_x, along_y) = (&indices[0][grid % layout.grids], &indices[1][grid / layout.grids]);
        let gathered = |all: &[T]| {
            let mut part = Vec::with_capacity(layout.area());
            for x in along_x {
                let row = &all[x * lines..][..lines];
                part.extend(along_y.iter().map(|&y| row[y]));
            }
            part
        };
        Waves { re: gathered(&re), im: gathered(&im) }
    };
    (0..layout.grids * layout.grids).map(field).collect()
}

/// Spectra of the fields, with plans along x and y.
fn spectra<T: Real>(mut fields: Vec<Waves<T>>, [along_x, along_y]: &[Plan<T>; 2]) -> Vec<Waves<T>> {
    let [x, y] = [along_x.length, along_y.length];
    let (mut turned, mut spare) = (Waves::zeros(x * y), Waves::zeros(x * y));
    for field in &mut fields {
        along_x.run(y, x, field, &mut spare);
        transpose(field, &mut turned, [x, y], [y, x]);
        along_y.run(x, y, &mut turned, &mut spare);
        transpose(&turned, field, [y, x], [x, y]);
    }
    fields
}

/// to = a b
struct Product<'a, T> {
    a: &'a Waves<T>,
    b: &'a Waves<T>,
    to: &'a mut Waves<T>,
}

impl<T: Real> Kernel for Product<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        let Self { a, b, to } = self;
        let count = a.len() / LANES * LANES;
        let ([a_re, a_im], [b_re, b_im]) = (a.blocks(0, count), b.blocks(0, count));
        let [to_re, to_im] = to.blocks_mut(count);
        for block in 0..to_re.len() {
            let (c, d, e, f) = (&a_re[block], &a_im[block], &b_re[block], &b_im[block]);
            to_re[block] = lanes(|i| T::fused::<I>(c[i], e[i], -(d[i] * f[i])));
            to_im[block] = lanes(|i| T::fused::<I>(c[i], f[i], d[i] * e[i]));
        }
    }
}

/// to += a* b
struct Correlation<'a, T> {
    a: &'a Waves<T>,
    b: &'a Waves<T>,
    to: &'a mut Waves<T>,
}

impl<T: Real> Kernel for Correlation<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        let Self { a, b, to } = self;
        let count = a.len() / LANES * LANES;
        let ([a_re, a_im], [b_re, b_im]) = (a.blocks(0, count), b.blocks(0, count));
        let [to_re, to_im] = to.blocks_mut(count);
        for block in 0..to_re.len() {
            let (c, d, e, f) = (&a_re[block], &a_im[block], &b_re[block], &b_im[block]);
            let (re, im) = (to_re[block], to_im[block]);
            let part = lanes(|i| T::fused::<I>(c[i], e[i], re[i]));
            to_re[block] = lanes(|i| T::fused::<I>(d[i], f[i], part[i]));
            let part = lanes(|i| T::fused::<I>(c[i], f[i], im[i]));
            to_im[block] = lanes(|i| T::fused::<I>(-d[i], e[i], part[i]));
        }
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use super::*;
    use crate::scene::{ElementModel, Scene};
    use crate::solver::starts::scatter;

    /// Arrays that are square and not, with elements off, of every kind.
    fn apertures() -> Vec<(Aperture, Layout)> {
        let arrays = [
            (16, 16, vec![], ElementModel::Piston, 3),
            (3, 11, vec![0, 5, 32], ElementModel::ExactPiston, 2),
            (9, 1, vec![2], ElementModel::Point, 1),
            (1, 1, vec![], ElementModel::Piston, 4),
        ];
        let made = |(rows, columns, off, model, grids): (u32, u32, Vec<usize>, ElementModel, usize)| {
            let mut scene = Scene::default();
            (scene.array.rows, scene.array.columns, scene.array.element) = (rows, columns, model);
            scene.array.off = off;
            let aperture = Aperture::new(&scene);
            let layout = Layout::new(&aperture, 0.07, DVec2::new(0.11, 0.06), grids);
            (aperture, layout)
        };
        arrays.into_iter().map(made).collect()
    }

    fn scattered<T: Real>(count: usize, seed: usize) -> Waves<T> {
        let value = |i: usize| T::of(scatter(i + seed) - 0.5);
        Waves { re: (0..count).map(value).collect(), im: (0..count).map(|i| value(3 * i + 1)).collect() }
    }

    #[test]
    fn samples_are_as_fine_and_reach_as_far_as_is_asked() {
        for (aperture, layout) in apertures() {
            let places: Vec<_> = layout.places(aperture.pitch).map(|(_, place)| place).collect();
            let low = places.iter().copied().reduce(DVec2::min).unwrap();
            let high = places.iter().copied().reduce(DVec2::max).unwrap();
            assert!((low + high).length() < 1e-12, "around the axis");
            assert!(high.x > 0.109 && high.y > 0.059, "{high}");
            let spacing = layout.spacing(aperture.pitch);
            let all = ((high - low) / spacing + 1.0).round();
            assert_eq!(places.len(), (all.x * all.y) as usize, "no sample twice");
            let mut near: Vec<_> =
                layout.places_near(aperture.pitch, DVec2::new(0.02, -0.01), 0.009).collect();
            near.sort_by_key(|(index, _)| *index);
            let is_near = |place: DVec2| (place - DVec2::new(0.02, -0.01)).abs().max_element() <= 0.009;
            let expected: Vec<_> =
                layout.places(aperture.pitch).filter(|(_, place)| is_near(*place)).collect();
            assert!(near == expected && !near.is_empty());
        }
    }

    #[test]
    fn the_grid_is_the_apertures_own_transfer() {
        fn check<T: Real>(most: f64) {
            for (aperture, layout) in apertures() {
                let mut grid = Grid::<T>::new(&aperture, layout, 0.5);
                let u = scattered::<T>(aperture.driven.len(), 5);
                let mut p = Waves::zeros(layout.len());
                grid.forward(&u, &mut p);
                let places: Vec<_> = layout.places(aperture.pitch).step_by(37).collect();
                let points: Vec<_> = places.iter().map(|(_, place)| place.extend(layout.height)).collect();
                let driven: Vec<_> =
                    u.re.iter().zip(&u.im).map(|(re, im)| Complex64::new(re.wide(), im.wide())).collect();
                let expected = aperture.transfer(&points).pressure(&driven);
                let peak = expected.iter().map(|p| p.norm()).fold(0.0, f64::max);
                for ((index, place), expected) in places.iter().zip(&expected) {
                    let got = Complex64::new(p.re[*index].wide(), p.im[*index].wide()) * 2.0;
                    let off = (got - expected).norm() / peak;
                    assert!(off < most, "{layout:?} {place}: off by {off:e}");
                }
            }
        }
        check::<f32>(1e-5);
        check::<f64>(1e-12);
    }

    #[test]
    fn the_way_back_is_adjoint() {
        for (aperture, layout) in apertures() {
            let mut grid = Grid::<f64>::new(&aperture, layout, 1.0);
            let u = scattered::<f64>(aperture.driven.len(), 5);
            let (mut p, mut y) = (Waves::zeros(layout.len()), Waves::zeros(layout.len()));
            grid.forward(&u, &mut p);
            let mut product = 0.0;
            for (index, _) in layout.places(aperture.pitch) {
                (y.re[index], y.im[index]) = (scatter(index) - 0.5, scatter(5 * index) - 0.5);
                product += p.re[index] * y.re[index] + p.im[index] * y.im[index];
            }
            let mut b = Waves::zeros(aperture.driven.len());
            b.re[0] = 3.0;
            grid.back(&y, &mut b);
            b.re[0] -= 3.0;
            let parts = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let back = parts(&u.re, &b.re) + parts(&u.im, &b.im);
            assert!((product - back).abs() < 1e-11 * product.abs().max(1.0), "{product} and {back}");
        }
    }
}
