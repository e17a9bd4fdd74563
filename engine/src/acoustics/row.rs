//! Rows of the transfer matrix, many elements to one point: [`Element::transfer`] in vector registers, in f64.

use std::f64::consts::PI;
use std::ops::Range;

use glam::DVec3;
use num_complex::Complex64;
use rayon::prelude::*;

use crate::acoustics::element::{NEAREST, Radiator};
use crate::acoustics::{
    aperture::Aperture,
    disk::{Disk, FromPoints},
    element::Element,
    face::Face,
    transfer::Transfer,
};
use crate::gauge;
use crate::simd::{Instructions, Isa, Kernel, fused64};
use crate::special::series::{COSINE, LANES, ROUNDER, SINE, inverse_factorials, value};

/// Terms of the directivity for a ka of up to 4, 2e-16 off, and of up to 10, 4e-15 off.
const FEW_TERMS: usize = 11;
const MANY_TERMS: usize = 18;
/// Terms of the Taylor series: an error of 1e-19 for ka up to 10.
const TAYLOR_TERMS: usize = 27;
/// e^x for |x| ≤ 0.1: 3e-15 off.
const DECAY: [f64; 9] = inverse_factorials();
const MOST_DECAY: f64 = 0.1;
/// m: powers of the square of a height up to this are finite.
const HIGHEST: f64 = 1e6;
/// ka/2 limits for few and for many terms.
const FEW: f64 = 2.0;
const MANY: f64 = 5.0;

/// Equal elements of a board, ready for [`Elements::fill`], in its own coordinates.
#[derive(Clone, Debug)]
pub struct Elements<'a> {
    element: &'a Element,
    /// m, padded with zeros to whole blocks.
    places: [Vec<f64>; 3],
    /// Unit vectors, padded; none of a flat board.
    normals: Option<[Vec<f64>; 3]>,
    /// Unit vectors, padded; none of a flat board.
    asides: Option<[Vec<f64>; 3]>,
    count: usize,
    /// The largest distance (m) of an element from the origin.
    reach: f64,
    /// Terms of `directivity`; `None` if it is no series.
    terms: Option<usize>,
    /// Exact pistons are point sources with the factor of their disk.
    disk: Option<Disk>,
    /// 1/m: k/π, and what rounding takes from it.
    half_turns_per_metre: [f64; 2],
    /// Others with a directivity that is no series in cos²θ are point sources times it.
    is_patterned: bool,
    /// D in cos²θ, as far as it is a series.
    directivity: [f64; MANY_TERMS],
}

impl<'a> Elements<'a> {
    /// The driven ones of a board, of the array's.
    pub fn new(element: &'a Element, board: &Face, driven: &[usize]) -> Self {
        let layout = &board.layout;
        let room = driven.len().next_multiple_of(LANES);
        let padded = |value: &dyn Fn(usize) -> f64| {
            let mut values: Vec<_> = driven.iter().map(|&n| value(n - board.first)).collect();
            values.resize(room, 0.0);
            values
        };
        let places = [0, 1, 2].map(|axis| padded(&|n| layout.positions[n][axis]));
        let normals = (!layout.is_flat()).then(|| [0, 1, 2].map(|axis| padded(&|n| layout.normals[n][axis])));
        let asides = (!layout.is_flat()).then(|| [0, 1, 2].map(|axis| padded(&|n| layout.asides[n][axis])));
        let distances = driven.iter().map(|&n| layout.positions[n - board.first].length());
        let reach = distances.fold(0.0, f64::max);
        let of_ka = |half_ka: f64| {
            let terms = if half_ka <= FEW { FEW_TERMS } else { MANY_TERMS };
            ((half_ka <= MANY).then_some(terms), directivity(half_ka * half_ka, terms))
        };
        let (terms, directivity) = match element.radiator() {
            Radiator::Monopole | Radiator::Disk(_) | Radiator::Rectangle(_) | Radiator::Measured => {
                of_ka(0.0)
            }
            Radiator::Piston(radius) => of_ka(element.wavenumber * radius / 2.0),
            Radiator::Cosine(exponent) => power(exponent).unwrap_or(of_ka(0.0)),
        };
        let is_patterned = match element.radiator() {
            Radiator::Monopole | Radiator::Disk(_) | Radiator::Piston(_) => false,
            Radiator::Rectangle(_) | Radiator::Measured => true,
            Radiator::Cosine(exponent) => power(exponent).is_none(),
        };
        let disk = match element.radiator() {
            Radiator::Disk(radius) => Some(Disk::new(element.wavenumber, radius)),
            Radiator::Monopole
            | Radiator::Piston(_)
            | Radiator::Rectangle(_)
            | Radiator::Cosine(_)
            | Radiator::Measured => None,
        };
        let half_turns_per_metre = over_pi(element.wavenumber);
        Self {
            element,
            places,
            normals,
            asides,
            count: driven.len(),
            reach,
            terms,
            disk,
            is_patterned,
            half_turns_per_metre,
            directivity,
        }
    }

    /// Values that [`Elements::fill`] writes of each part: whole blocks.
    pub fn room(&self) -> usize {
        self.places[0].len()
    }

    /// Writes real and imaginary parts of the transfer to a point of the board's coordinates, one per element.
    pub fn fill(&self, point: DVec3, re: &mut [f64], im: &mut [f64]) {
        let element = self.element;
        // Row clamps heights, which disks do not.
        let is_disk_above = |disk: &Disk| disk.is_series() && (point.z >= NEAREST || self.normals.is_some());
        let is_series = self.disk.as_ref().is_none_or(is_disk_above)
            && point.z <= HIGHEST
            && element.attenuation * self.reach <= MOST_DECAY
            && (point.z >= -NEAREST || self.normals.is_some());
        let Some(terms) = self.terms.filter(|_| is_series) else {
            for n in 0..self.count {
                let transfer = self.single(n, point);
                (re[n], im[n]) = (transfer.re, transfer.im);
            }
            return;
        };
        match (terms <= FEW_TERMS, self.normals.is_none()) {
            (true, true) => self.series::<FEW_TERMS, true>(point, re, im),
            (false, true) => self.series::<MANY_TERMS, true>(point, re, im),
            (true, false) => self.series::<FEW_TERMS, false>(point, re, im),
            (false, false) => self.series::<MANY_TERMS, false>(point, re, im),
        }
        // Padding contributes zero.
        re[self.count..].fill(0.0);
        im[self.count..].fill(0.0);
        if let Some(disk) = &self.disk {
            self.spread(disk, point, re, im);
        }
        if self.is_patterned {
            self.direct(point, re, im);
        }
        self.mend(point, re, im);
    }

    /// Elements with a directivity from the waves of points.
    fn direct(&self, point: DVec3, re: &mut [f64], im: &mut [f64]) {
        for (n, (re, im)) in re.iter_mut().zip(im).take(self.count).enumerate() {
            let way = point - of_element(&self.places, n);
            let across = match (&self.normals, &self.asides) {
                (Some(normals), Some(asides)) => {
                    let (normal, aside) = (of_element(normals, n), of_element(asides, n));
                    DVec3::new(way.dot(aside), way.dot(normal.cross(aside)), way.dot(normal))
                }
                (None, _) | (_, None) => way,
            };
            let across = across.with_z(across.z.max(NEAREST));
            let wave = Complex64::new(*re, *im) * self.element.pattern(across / across.length()).value;
            (*re, *im) = (wave.re, wave.im);
        }
    }

    /// Exact pistons from the waves of points.
    fn spread(&self, disk: &Disk, point: DVec3, re: &mut [f64], im: &mut [f64]) {
        let way = |n: usize| DVec3::from_array([0, 1, 2].map(|axis| point[axis] - self.places[axis][n]));
        let ways = |n: usize| {
            let way = way(n);
            let height = match &self.normals {
                Some(normals) => (0..3).map(|axis| way[axis] * normals[axis][n]).sum(),
                None => way.z,
            };
            (way.length_squared(), height)
        };
        let nearest = if self.normals.is_some() { 0.0 } else { point.z };
        let (re, im) = (&mut re[..self.room()], &mut im[..self.room()]);
        Isa::best().run(FromPoints { disk, ways: &ways, nearest, re, im });
        for n in (0..self.count).filter(|&n| way(n).length() < disk.clear()) {
            let transfer = self.single(n, point);
            (re[n], im[n]) = (transfer.re, transfer.im);
        }
    }

    fn series<const TERMS: usize, const FLAT: bool>(&self, point: DVec3, re: &mut [f64], im: &mut [f64]) {
        if self.element.attenuation == 0.0 {
            Isa::best().run(Row::<TERMS, FLAT, false> { elements: self, point, re, im });
        } else {
            Isa::best().run(Row::<TERMS, FLAT, true> { elements: self, point, re, im });
        }
    }

    /// The transfer of one element.
    fn single(&self, n: usize, point: DVec3) -> Complex64 {
        let offset = point - of_element(&self.places, n);
        match (&self.normals, &self.asides) {
            (Some(normals), Some(asides)) => {
                self.element.towards(offset, of_element(normals, n), of_element(asides, n))
            }
            (None, _) | (_, None) => self.element.transfer(offset),
        }
    }

    /// Elements of a curved board with the point behind them, or in their plane.
    fn mend(&self, point: DVec3, re: &mut [f64], im: &mut [f64]) {
        let Some([x, y, z]) = &self.normals else { return };
        for n in 0..self.count {
            let height = (point.x - self.places[0][n]) * x[n]
                + (point.y - self.places[1][n]) * y[n]
                + (point.z - self.places[2][n]) * z[n];
            if height < NEAREST {
                let transfer = self.single(n, point);
                (re[n], im[n]) = (transfer.re, transfer.im);
            }
        }
    }
}

/// The elements of all faces, ready for the transfer to many points.
#[derive(Debug)]
pub struct Rows<'a> {
    /// Each with its columns of the transfer.
    faces: Vec<(&'a Face, Range<usize>, Elements<'a>)>,
}

impl Aperture {
    /// H without bodies.
    pub(super) fn transfer_of_elements(&self, points: &[DVec3]) -> Transfer {
        let mut transfer = Transfer::zeros(points.len(), self.driven.len());
        Rows::new(self).fill(points, &mut transfer);
        transfer
    }

    /// [`Aperture::pressures`] without bodies.
    pub(super) fn pressures_of_elements(&self, points: &[DVec3], drives: &[Complex64]) -> Vec<Complex64> {
        /// Points per task of a thread.
        const TASK: usize = 128;
        /// Rows of some hundred elements that stay in the nearest cache, with their drive.
        const RUN: usize = 4;
        let rows = Rows::new(self);
        let room = |points: usize| Transfer::zeros(points, self.driven.len());
        let drives: Vec<_> =
            drives.chunks(self.driven.len().max(1)).map(|drive| room(0).played(drive)).collect();
        let of_task = |(points, pressures): (&[DVec3], &mut [Complex64])| {
            let mut transfer = room(RUN.min(points.len()));
            for (points, to) in points.chunks(RUN).zip(pressures.chunks_mut(RUN)) {
                rows.fill(points, &mut transfer);
                to.copy_from_slice(&transfer.taking_turns(&drives));
            }
        };
        let mut pressures = vec![Complex64::ZERO; points.len()];
        if points.len() <= TASK {
            of_task((points, &mut pressures));
        } else {
            points.par_chunks(TASK).zip(pressures.par_chunks_mut(TASK)).for_each(of_task);
        }
        pressures
    }
}

impl<'a> Rows<'a> {
    pub fn new(aperture: &'a Aperture) -> Self {
        let of_face = |face: &'a Face| {
            let columns = face.among(&aperture.driven);
            let elements = Elements::new(&aperture.element, face, &aperture.driven[columns.clone()]);
            (face, columns, elements)
        };
        Self { faces: aperture.faces.iter().map(of_face).collect() }
    }

    /// Writes a row per point. `transfer` has room for as many points or more, and may hold other rows.
    pub fn fill(&self, points: &[DVec3], transfer: &mut Transfer) {
        transfer.points = points.len();
        if let [(face, _, elements)] = &self.faces[..]
            && face.gain == 1.0
        {
            for (index, &point) in points.iter().enumerate().take_while(|_| !gauge::is_cancelled()) {
                let (re, im) = transfer.row_mut(index);
                elements.fill(face.pose.local(point), re, im);
            }
            return;
        }
        transfer.clear();
        for (face, columns, elements) in &self.faces {
            let (mut wave_re, mut wave_im) = (vec![0.0; elements.room()], vec![0.0; elements.room()]);
            for (index, &point) in points.iter().enumerate().take_while(|_| !gauge::is_cancelled()) {
                elements.fill(face.pose.local(point), &mut wave_re, &mut wave_im);
                let (re, im) = transfer.row_mut(index);
                let pairs = re[columns.clone()].iter_mut().zip(&wave_re);
                for (sum, wave) in pairs.chain(im[columns.clone()].iter_mut().zip(&wave_im)) {
                    *sum += face.gain * wave;
                }
            }
        }
    }
}

fn of_element(values: &[Vec<f64>; 3], n: usize) -> DVec3 {
    DVec3::from_array([0, 1, 2].map(|axis| values[axis][n]))
}

/// cosⁿθ as a series in cos²θ, if it is one.
fn power(exponent: f64) -> Option<(Option<usize>, [f64; MANY_TERMS])> {
    let half = exponent / 2.0;
    let is_even = half.fract() == 0.0 && half < MANY_TERMS as f64;
    let series = std::array::from_fn(|n| if n as f64 == half { 1.0 } else { 0.0 });
    is_even.then_some((Some(if half < FEW_TERMS as f64 { FEW_TERMS } else { MANY_TERMS }), series))
}

/// A row of the transfer: of a flat board or a curved one, with absorption or without.
struct Row<'a, const TERMS: usize, const FLAT: bool, const ABSORBS: bool> {
    elements: &'a Elements<'a>,
    point: DVec3,
    re: &'a mut [f64],
    im: &'a mut [f64],
}

impl<const TERMS: usize, const FLAT: bool, const ABSORBS: bool> Kernel for Row<'_, TERMS, FLAT, ABSORBS> {
    type Output = ();

    /// S · D(θ)/r · e^{-αr} · (sin kr + j cos kr), which is j e^{-jkr}. One plain loop: of blocks of lanes with stores between them the
    /// compiler makes twice the instructions.
    #[inline(always)]
    fn run<I: Instructions>(self) {
        let Self { elements, point, re, im } = self;
        let element = elements.element;
        let count = elements.room();
        let [xs, ys, zs] = elements.places.each_ref().map(|values| &values[..count]);
        let [nxs, nys, nzs] =
            elements.normals.as_ref().unwrap_or(&elements.places).each_ref().map(|values| &values[..count]);
        let (re, im) = (&mut re[..count], &mut im[..count]);
        let z = if FLAT { point.z.max(NEAREST) } else { point.z };
        // e^{-αr} relative to what it is at the origin.
        let middle = point.with_z(z).length();
        let strength = element.strength * (-element.attenuation * middle).exp();
        // Of a flat board in 1/r², of others in cos²θ.
        let scale = if FLAT { z * z } else { 1.0 };
        let mut power = strength;
        let mut directivity = [0.0; TERMS];
        for (to, term) in directivity.iter_mut().zip(elements.directivity) {
            *to = term * power;
            power *= scale;
        }
        let [turning, turning_rest] = elements.half_turns_per_metre;
        let attenuation = element.attenuation;
        for n in 0..count {
            let (dx, dy) = (point.x - xs[n], point.y - ys[n]);
            let dz = if FLAT { z } else { z - zs[n] };
            let r2 = fused64::<I>(dx, dx, fused64::<I>(dy, dy, dz * dz));
            let r = r2.sqrt();
            let inverse2 = 1.0 / r2;
            let inverse = r * inverse2;
            let height =
                if FLAT { 1.0 } else { fused64::<I>(dx, nxs[n], fused64::<I>(dy, nys[n], dz * nzs[n])) };
            let variable = if FLAT { inverse2 } else { height * height * inverse2 };
            let mut amplitude = inverse * value::<I, TERMS>(&directivity, variable);
            if ABSORBS {
                amplitude *= value::<I, 9>(&DECAY, attenuation * (middle - r));
            }
            // kr = π (whole + f)
            let rounded = fused64::<I>(r, turning, ROUNDER);
            let f = fused64::<I>(r, turning_rest, fused64::<I>(r, turning, ROUNDER - rounded));
            // What rounding took from the root.
            let f = if I::FMA { ((-r).mul_add(r, r2) * inverse).mul_add(turning / 2.0, f) } else { f };
            let f2 = f * f;
            // An odd number of half-turns changes both signs.
            let amplitude = f64::from_bits(amplitude.to_bits() ^ (rounded.to_bits() << 63));
            // sin 2x = 2 sin x cos x and cos 2x = 1 - 2 sin² x: half the angle takes fewer terms.
            let sine = f * value::<I, 7>(&SINE, f2);
            let part = amplitude * sine;
            re[n] = part * value::<I, 7>(&COSINE, f2);
            im[n] = fused64::<I>(-part, sine, amplitude);
        }
    }
}

/// A quotient by π and what rounding takes from it.
fn over_pi(x: f64) -> [f64; 2] {
    /// π less its f64.
    const REST: f64 = 1.224_646_799_147_353_2e-16;
    let quotient = x / PI;
    [quotient, ((-quotient).mul_add(PI, x) - quotient * REST) / PI]
}

/// 2 J1(x)/x, x = ka sinθ, = Σ (ka/2)^{2n}/(n! (n+1)!) Λₙ₊₁(ka) cos^{2n}θ with Λₙ(x) = n! (2/x)ⁿ Jₙ(x), by the multiplication
/// theorem, economised to `terms` terms: the highest power is successively replaced by its remainder against the
/// shifted Chebyshev polynomial of that degree (Lanczos, Applied Analysis, 1956, chapter 7).
fn directivity(quarter_ka2: f64, terms: usize) -> [f64; MANY_TERMS] {
    let lambdas = lambdas(quarter_ka2);
    let mut series = [0.0; TAYLOR_TERMS];
    let mut factor = 1.0;
    for (n, coefficient) in series.iter_mut().enumerate() {
        *coefficient = factor * lambdas[n + 1];
        factor *= quarter_ka2 / ((n + 1) * (n + 2)) as f64;
    }
    for degree in (terms..TAYLOR_TERMS).rev() {
        let chebyshev = shifted_chebyshev(degree);
        let part = series[degree] / chebyshev[degree];
        series[degree] = 0.0;
        series.iter_mut().zip(chebyshev).take(degree).for_each(|(lower, c)| *lower -= part * c);
    }
    std::array::from_fn(|n| series[n])
}

/// n! (2/x)ⁿ Jₙ(x) by the recurrence of Bessel functions from high orders down, where it is stable.
fn lambdas(quarter_x2: f64) -> [f64; TAYLOR_TERMS + 2] {
    let series = |order: usize| {
        let next =
            |(m, term): &(usize, f64)| Some((m + 1, -term * quarter_x2 / ((m + 1) * (order + m + 1)) as f64));
        std::iter::successors(Some((0, 1.0)), next).take(40).map(|(_, term)| term).sum::<f64>()
    };
    let mut lambdas = [0.0; TAYLOR_TERMS + 2];
    for n in (0..lambdas.len()).rev() {
        lambdas[n] = match lambdas.get(n + 2) {
            Some(above) => lambdas[n + 1] - quarter_x2 / ((n + 1) * (n + 2)) as f64 * above,
            None => series(n),
        };
    }
    lambdas
}

/// T(2s - 1) of a degree, in powers of s.
fn shifted_chebyshev(degree: usize) -> [f64; TAYLOR_TERMS] {
    let (mut before, mut this) = ([0.0; TAYLOR_TERMS], [0.0; TAYLOR_TERMS]);
    before[0] = 1.0;
    (this[0], this[1]) = (-1.0, 2.0);
    for _ in 1..degree {
        let next = |n: usize| 4.0 * if n > 0 { this[n - 1] } else { 0.0 } - 2.0 * this[n] - before[n];
        (before, this) = (this, std::array::from_fn(next));
    }
    this
}

#[cfg(test)]
mod tests {
    use strum::VariantArray;

    use super::*;
    use crate::scene::{Directivity, ElementModel, Reading, Scene};

    /// A directivity with a phase.
    fn measured() -> Directivity {
        let reading = |(angle, amplitude): (f64, f64)| Reading { angle, amplitude, phase: angle / 2.0 };
        Directivity::new([(0.0, 2.0), (30.0, 1.5), (60.0, -0.3), (90.0, 0.1)].map(reading).to_vec(), None)
    }

    /// Half-turns of a wave on its way, in the digits of two f64 until they are less than two.
    fn half_turns(away: DVec3, wavenumber: f64) -> f64 {
        let product = |a: f64, b: f64| [a * b, a.mul_add(b, -(a * b))];
        let sum = |a: f64, b: f64| {
            let sum = a + b;
            let kept = sum - a;
            [sum, (a - (sum - kept)) + (b - kept)]
        };
        let mut square = [0.0; 2];
        for [high, low] in away.to_array().map(|x| product(x, x)) {
            let [next, rest] = sum(square[0], high);
            square = [next, square[1] + low + rest];
        }
        let r = (square[0] + square[1]).sqrt();
        let rest = ((-r).mul_add(r, square[0]) + square[1]) / (2.0 * r);
        let [turning, turning_rest] = over_pi(wavenumber);
        let [turns, low] = product(r, turning);
        (turns % 2.0) + (low + r * turning_rest + rest * turning)
    }

    #[test]
    fn phases_of_far_points_lose_no_more_than_the_squared_distance_rounds() {
        let mut scene = Scene::default();
        scene.array.element = ElementModel::Point;
        let aperture = Aperture::new(&scene);
        let elements = Elements::new(&aperture.element, &aperture.faces[0], &aperture.driven);
        let wavenumber = aperture.element.wavenumber;
        let (mut sum, mut count) = (0.0, 0.0);
        for i in 1..20 {
            let point = DVec3::new(0.37 * f64::from(i), -0.61 * f64::from(i), 2.3 * f64::from(i));
            let (mut re, mut im) = (vec![0.0; 256], vec![0.0; 256]);
            elements.fill(point, &mut re, &mut im);
            for (n, position) in aperture.positions.iter().enumerate() {
                let away = point - *position;
                // i e^(-ikr)
                let expected = Complex64::cis(PI * (0.5 - half_turns(away, wavenumber)));
                let off = (Complex64::new(re[n], im[n]) * expected.conj()).arg();
                sum += off.abs() / (wavenumber * away.length());
                count += 1.0;
            }
        }
        assert!(sum / count < 7e-17, "{:e} of the phase on average", sum / count);
    }

    #[test]
    fn rows_are_the_single_transfers() {
        let models = ElementModel::VARIANTS;
        // Radii for few and many terms, and for none; absorptions for the series and not.
        for (model, radius, absorption) in [
            (0, 0.005, None),
            (0, 0.012, Some(0.0)),
            (0, 0.03, None),
            (0, 0.005, Some(60.0)),
            (1, 0.005, None),
            (2, 0.005, None),
            (3, 0.005, None),
            (4, 0.005, None),
            (4, 2.0, None),
            (5, 0.005, Some(0.0)),
        ] {
            let mut scene = Scene::default();
            (scene.array.rows, scene.array.columns) = (7, 9);
            (scene.array.element, scene.array.element_radius) = (models[model], radius);
            scene.array.element_exponent = radius;
            scene.array.measured = measured();
            scene.medium.absorption = absorption;
            let aperture = Aperture::new(&scene);
            let elements = Elements::new(&aperture.element, &aperture.faces[0], &aperture.driven);
            for point in [
                DVec3::new(0.01, -0.02, 0.1),
                DVec3::new(0.3, 0.2, 1.0),
                DVec3::new(0.004, 0.0, 0.001),
                DVec3::new(0.0, 0.01, -1e-6),
                DVec3::new(0.0, 0.01, -0.1),
                DVec3::new(1.0, -2.0, 10.0),
            ] {
                let (mut re, mut im) = (vec![1.0; 64], vec![1.0; 64]);
                elements.fill(point, &mut re, &mut im);
                for (n, position) in aperture.positions.iter().enumerate() {
                    let expected = aperture.element.transfer(point - *position);
                    let off = (expected.re - re[n]).hypot(expected.im - im[n]);
                    // Both round the phase, by 1e-16 of it.
                    let most =
                        (1e-12 + 4e-16 * aperture.element.wavenumber * point.length()) * expected.norm();
                    assert!(off <= most, "{model} {radius} {point}: {off:e} of {expected}");
                }
            }
        }
    }
}
