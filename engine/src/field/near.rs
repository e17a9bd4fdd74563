//! Partial waves about many points near elements, element by element.
//!
//! About a point at a distance r from an element, in the direction u, its wave is that of a point source with the pressure p of the
//! point: a_nm = 4π (-1)^n p h_n(kr)/h_0(kr) Y_nm(u). With q_n = h_n/h_0, q_0 = 1, q_1 = 1/kr + j, and q_{n+1} = (2n + 1) q_n/kr -
//! q_{n-1}. The directivity varies about the point, too: its slope counts in the first order, its curvature is left out, a
//! part of (ka/kr)² of the second.

#![expect(clippy::needless_range_loop, reason = "lanes are what is looped over, in several arrays at once")]

use std::f64::consts::{PI, SQRT_2};

use glam::DVec3;
use num_complex::Complex32;
use rayon::prelude::*;

use crate::acoustics::Aperture;
use crate::acoustics::element::{NEAREST, Radiator};
use crate::drive::Drive;
use crate::field::cpu::{LANES, Points, single_waves};
use crate::field::samples::Samples;
use crate::field::sources::{Sources, Wave};
use crate::simd::{Instructions, Isa, Kernel, fused};

/// Highest order.
const MOST: usize = 8;

type Lanes = [f32; LANES];

/// Factors of the harmonics' recursion over orders n from one degree m: of the height, of the harmonic before, and of the result.
type Steps = Vec<Vec<[f32; 3]>>;

/// The partial waves up to an order about every sample in the axes of a frame, harmonic by harmonic. `None` if f32 declines, or
/// for elements whose near field is not that of a point source.
pub fn partial_waves(
    (aperture, drive): (&Aperture, &Drive),
    (order, frame): (usize, [DVec3; 3]),
    samples: &Samples,
) -> Option<Vec<Vec<Complex32>>> {
    let is_point = match aperture.element.radiator() {
        Radiator::Monopole | Radiator::Piston(_) => true,
        Radiator::Disk(_) => false,
    };
    let faces = Sources::of_faces(aperture, drive, samples).filter(|_| is_point && order <= MOST)?;
    let count = (order + 1).pow(2);
    let steps = steps(order);
    let of_block = |block: usize| {
        let first = block * LANES;
        let held = LANES.min(samples.len() - first);
        let mut sums = vec![[[0.0; LANES]; 2]; count];
        for (Sources { wave, elements, tilts, samples }, face) in faces.iter().zip(&aperture.faces) {
            let points = Points::new(wave, held, |lane| samples.point(first + lane));
            let at: [Lanes; 3] = [0, 1, 2].map(|axis| {
                std::array::from_fn(|lane| samples.point(first + lane.min(held - 1))[axis] as f32)
            });
            let turn = frame.map(|axis| face.pose.local_direction(axis).to_array().map(|part| part as f32));
            single_waves(wave, (elements, tilts), &points, |n, wave_of_element| {
                let tilt = tilts.get(n).copied().unwrap_or([0.0, 0.0, 0.0, 1.0]);
                let [x, y, ..] = elements[n];
                let sums = &mut sums;
                Isa::best().run(Add {
                    wave,
                    element: [x, y],
                    tilt,
                    at: &at,
                    turn,
                    wave_of_element,
                    steps: &steps,
                    sums,
                });
            });
        }
        sums
    };
    let blocks: Vec<_> = (0..samples.len().div_ceil(LANES)).into_par_iter().map(of_block).collect();
    let of_harmonic = |harmonic: usize| {
        let values = blocks.iter().flat_map(|sums| {
            let [re, im] = &sums[harmonic];
            re.iter().zip(im).map(|(re, im)| Complex32::new(*re, *im))
        });
        values.take(samples.len()).collect()
    };
    Some((0..count).map(of_harmonic).collect())
}

fn steps(order: usize) -> Steps {
    let of_degree = |m: usize| {
        let of_order = |n: usize| {
            let (above, m) = ((n + 1) as f64, m as f64);
            let scale = ((4.0 * above * above - 1.0) / (above * above - m * m)).sqrt();
            let last =
                (((above - 1.0).powi(2) - m * m) / (4.0 * (above - 1.0).powi(2) - 1.0)).max(0.0).sqrt();
            let norm = if m == 0.0 { 1.0 } else { SQRT_2 };
            [scale, -scale * last, norm].map(|factor| factor as f32)
        };
        (m..=order).map(of_order).collect()
    };
    (0..=order).map(of_degree).collect()
}

/// Adds the partial waves of an element to sums.
struct Add<'a> {
    wave: &'a Wave,
    /// x and y, m.
    element: [f32; 2],
    /// Its z (m), and the direction of radiation.
    tilt: [f32; 4],
    /// The points, m.
    at: &'a [Lanes; 3],
    /// The axes of the frame.
    turn: [[f32; 3]; 3],
    /// Its pressures at the points, Pa.
    wave_of_element: (&'a Lanes, &'a Lanes),
    steps: &'a Steps,
    sums: &'a mut [[Lanes; 2]],
}

impl Kernel for Add<'_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        let Self {
            wave,
            element: [x, y],
            tilt: [z, nx, ny, nz],
            at,
            turn,
            wave_of_element: (re, im),
            steps,
            sums,
        } = self;
        let per_metre = 1.0 / (std::f32::consts::TAU * wave.turns_per_metre);
        let directivity = &wave.directivity.coefficients[..wave.directivity.terms];
        let zeros = [0.0f32; LANES];
        // Direction and slope of the directivity in the frame, and 1/kr.
        let (mut u, mut slope, mut inverse) = ([zeros; 3], [zeros; 3], zeros);
        for lane in 0..LANES {
            let (dx, dy, dz) = (at[0][lane] - x, at[1][lane] - y, at[2][lane] - z);
            let r = fused::<I>(dx, dx, fused::<I>(dy, dy, dz * dz)).sqrt() + NEAREST as f32;
            let (dx, dy, dz) = (dx / r, dy / r, dz / r);
            let cos = fused::<I>(dx, nx, fused::<I>(dy, ny, dz * nz));
            let s = fused::<I>(-2.0 * cos, cos, 1.0);
            let (mut value, mut rise) = (0.0f32, 0.0f32);
            for &coefficient in directivity.iter().rev() {
                rise = fused::<I>(rise, s, value);
                value = fused::<I>(value, s, coefficient);
            }
            let small = value.abs() < 1e-3;
            let ratio = if small { 0.0 } else { rise / value };
            inverse[lane] = per_metre / r;
            let g = -4.0 * cos * ratio * inverse[lane];
            let (gx, gy, gz) = (g * (nx - cos * dx), g * (ny - cos * dy), g * (nz - cos * dz));
            for axis in 0..3 {
                let [a, b, c] = turn[axis];
                u[axis][lane] = fused::<I>(a, dx, fused::<I>(b, dy, c * dz));
                slope[axis][lane] = fused::<I>(a, gx, fused::<I>(b, gy, c * gz));
            }
        }
        // 4π (-1)^n p q_n of all orders.
        let order = steps.len() - 1;
        let full = (4.0 * PI) as f32;
        let mut radial = [[zeros; 2]; MOST + 1];
        let (mut before, mut this) = ([zeros; 2], [zeros; 2]);
        for lane in 0..LANES {
            this[0][lane] = full * re[lane];
            this[1][lane] = full * im[lane];
            // q_{-1} is -j; the alternating sign makes it j.
            before[0][lane] = -full * im[lane];
            before[1][lane] = full * re[lane];
        }
        for n in 0..=order {
            radial[n] = this;
            let odd = (2 * n + 1) as f32;
            for part in 0..2 {
                for lane in 0..LANES {
                    let next = -odd * inverse[lane] * this[part][lane] - before[part][lane];
                    before[part][lane] = this[part][lane];
                    this[part][lane] = next;
                }
            }
        }
        // √(12π) times the slope along x, y and z.
        let first = (12.0 * PI).sqrt() as f32;
        for (axis, harmonic) in [3, 1, 2].into_iter().enumerate() {
            for lane in 0..LANES {
                let slope = first * slope[axis][lane];
                sums[harmonic][0][lane] = fused::<I>(slope, re[lane], sums[harmonic][0][lane]);
                sums[harmonic][1][lane] = fused::<I>(slope, im[lane], sums[harmonic][1][lane]);
            }
        }
        // The harmonics as in `acoustics::partial`, by recursion over the orders of each degree.
        let (mut flat, mut start) = ([[1.0f32; LANES], zeros], (0.5 / PI.sqrt()) as f32);
        for (m, steps) in steps.iter().enumerate() {
            let (mut before, mut this) = (zeros, [start; LANES]);
            for (n, &[scale, last, norm]) in (m..).zip(steps) {
                for (part, harmonic) in [n * n + n + m, n * n + n - m].into_iter().enumerate() {
                    if m == 0 && part == 1 {
                        continue;
                    }
                    let [to_re, to_im] = &mut sums[harmonic];
                    for lane in 0..LANES {
                        let y = norm * this[lane] * flat[part][lane];
                        to_re[lane] = fused::<I>(y, radial[n][0][lane], to_re[lane]);
                        to_im[lane] = fused::<I>(y, radial[n][1][lane], to_im[lane]);
                    }
                }
                for lane in 0..LANES {
                    let next = fused::<I>(scale * u[2][lane], this[lane], last * before[lane]);
                    before[lane] = this[lane];
                    this[lane] = next;
                }
            }
            start *= ((2 * m + 3) as f32 / (2 * m + 2) as f32).sqrt();
            for lane in 0..LANES {
                let [a, b] = [flat[0][lane], flat[1][lane]];
                flat[0][lane] = fused::<I>(a, u[0][lane], -b * u[1][lane]);
                flat[1][lane] = fused::<I>(a, u[1][lane], b * u[0][lane]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::dvec3;

    use super::*;
    use crate::acoustics::PartialWaves;
    use crate::scene::{Array, Board, ElementModel, Scene};

    #[test]
    fn waves_of_elements_are_those_on_spheres() {
        let opposite =
            Board { at: dvec3(0.0, 0.01, 0.05), normal: dvec3(0.6, 0.0, -0.8), ..Board::default() };
        let drive =
            Drive { amplitudes: vec![1.0; 32], phases: (0..32).map(|n| 0.9 * f64::from(n * n)).collect() };
        let frame = [dvec3(0.0, 0.6, 0.8), dvec3(0.0, -0.8, 0.6), DVec3::X];
        let points: Vec<_> = (0..70).map(|i| dvec3(2e-4 * f64::from(i), 3e-3, 0.02)).collect();
        // Of far-field pistons the curvature of the directivity is left out.
        for (element, allowed) in [(ElementModel::Point, 2e-4), (ElementModel::Piston, 0.03)] {
            let array = Array { rows: 4, columns: 4, element, ..Array::default() };
            let aperture = Aperture::new(&Scene {
                array,
                boards: vec![Board::default(), opposite.clone()],
                ..Scene::default()
            });
            let waves = partial_waves((&aperture, &drive), (3, frame), &Samples::at(points.clone())).unwrap();
            let played = drive.excitation(&aperture.driven);
            for (i, &point) in points.iter().enumerate() {
                let k = aperture.element.wavenumber;
                let around = |offsets: &[DVec3]| {
                    let turned = |o: &DVec3| point + frame[0] * o.x + frame[1] * o.y + frame[2] * o.z;
                    aperture.pressures(&offsets.iter().map(turned).collect::<Vec<_>>(), &played)
                };
                let expected = PartialWaves::new(3, k, (DVec3::ZERO, 0.4 / k), around);
                let largest = expected.values().iter().map(|a| a.norm()).fold(0.0, f64::max);
                for (harmonic, expected) in expected.values().iter().enumerate() {
                    let Complex32 { re, im } = waves[harmonic][i];
                    let off = (num_complex::Complex64::new(re.into(), im.into()) - expected).norm();
                    assert!(off < allowed * largest, "{element:?}, {i}, {harmonic}: {off} of {largest}");
                }
            }
        }
    }
}
