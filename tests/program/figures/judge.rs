//! Point sources in front of a plane, in f64: their pressure, and a liquid's surface by its cosine modes.

use std::f64::consts::{PI, TAU};

use num_complex::Complex64;
use rayon::prelude::*;
use serde_json::Value;

pub const SOUND_SPEED: f64 = 343.0;
pub const AIR: f64 = 1.2;
pub const FREQUENCY: f64 = 40e3;
pub const WAVELENGTH: f64 = SOUND_SPEED / FREQUENCY;
const PITCH: f64 = 0.0105;
/// The beginning of a scene file with these sources, to be followed by `strength`.
pub const HEAD: &str = "format = 1\n[medium]\nsound_speed = 343\ndensity = 1.2\nabsorption = 0\n[array]\ncolumns = 16\nrows = 16\n\
     pitch = 0.0105\nfrequency = 40e3\nelement = \"point\"\n";

pub type Point = [f64; 3];

/// 16 x 16 sources with a drive.
pub struct Sources(Vec<(f64, f64, Complex64)>);

impl Sources {
    /// The drive of `solve --json`, with this strength (Pa·m).
    pub fn new(solution: &Value, strength: f64) -> Self {
        let numbers = |key: &str| solution[key].as_array().unwrap().iter().map(|v| v.as_f64().unwrap());
        let place = |i: usize| PITCH * (i as f64 - 7.5);
        let u = numbers("amplitudes")
            .zip(numbers("phases"))
            .map(|(a, phase)| Complex64::from_polar(strength * a, phase));
        Self(u.enumerate().map(|(n, u)| (place(n % 16), place(n / 16), u)).collect())
    }

    /// Pressure (Pa, peak), and its slopes along x and y.
    fn sound(&self, [x, y, z]: Point) -> [Complex64; 3] {
        let k = TAU / WAVELENGTH;
        let mut sound = [Complex64::ZERO; 3];
        for (from_x, from_y, u) in &self.0 {
            let (dx, dy) = (x - from_x, y - from_y);
            let r = (dx * dx + dy * dy + z * z).sqrt();
            let p = u * Complex64::from_polar(1.0 / r, PI / 2.0 - k * r);
            let along_r = p * Complex64::new(-1.0 / r, -k) / r;
            sound[0] += p;
            sound[1] += along_r * dx;
            sound[2] += along_r * dy;
        }
        sound
    }

    pub fn modulus(&self, point: Point) -> f64 {
        self.sound(point)[0].norm()
    }

    /// |P|²/(ρc²) - |∇P|²/(ρω²), Pa, on a level surface.
    fn radiation(&self, point: Point) -> f64 {
        let [p, x, y] = self.sound(point);
        let omega = TAU * FREQUENCY;
        p.norm_sqr() / (AIR * SOUND_SPEED.powi(2)) - (x.norm_sqr() + y.norm_sqr()) / (AIR * omega * omega)
    }
}

/// A liquid's surface h with ρgh - σ∇²h = p, as a cosine series between distant walls.
pub struct Surface {
    count: usize,
    length: f64,
    centre: [f64; 2],
    modes: Vec<f64>,
}

impl Surface {
    /// Under the radiation pressure on a square around a centre, in cells λ/8 wide.
    pub fn new(sources: &Sources, [x, y, z]: Point, size: f64, density: f64, tension: f64) -> Self {
        const GRAVITY: f64 = 9.81;
        let weight = density * GRAVITY;
        let length = size + 24.0 * (tension / weight).sqrt();
        let count = (length / WAVELENGTH * 8.0).ceil() as usize;
        let place = |i: usize| length * ((i as f64 + 0.5) / count as f64 - 0.5);
        let pressures: Vec<f64> = (0..count * count)
            .into_par_iter()
            .map(|i| sources.radiation([x + place(i % count), y + place(i / count), z]))
            .collect();
        let cosine = |k: usize, i: usize| (PI * k as f64 * (i as f64 + 0.5) / count as f64).cos();
        // Along rows, then along columns; the result is transposed twice.
        let along = |values: &[f64]| -> Vec<f64> {
            let one = |index: usize| {
                let (k, row) = (index / count, index % count);
                (0..count).map(|i| values[row * count + i] * cosine(k, i)).sum::<f64>()
            };
            (0..count * count).into_par_iter().map(one).collect()
        };
        let mut modes = along(&along(&pressures));
        for (index, mode) in modes.iter_mut().enumerate() {
            let (k, l) = (index % count, index / count);
            let share = |k: usize| if k == 0 { 1.0 } else { 2.0 } / count as f64;
            let q = |k: usize| PI * k as f64 / length;
            *mode *= share(k) * share(l) / (weight + tension * (q(k).powi(2) + q(l).powi(2)));
        }
        Self { count, length, centre: [x, y], modes }
    }

    /// Depth (m, positive down) and slope at all combinations of coordinates (m) from the centre.
    pub fn on(&self, xs: &[f64], ys: &[f64]) -> Vec<[f64; 2]> {
        let waves = |places: &[f64]| -> Vec<[f64; 2]> {
            let one = |place: &f64, k: usize| {
                let q = PI * k as f64 / self.length;
                let (sin, cos) = (q * (place + self.length / 2.0)).sin_cos();
                [cos, -q * sin]
            };
            places.iter().flat_map(|place| (0..self.count).map(move |k| one(place, k))).collect()
        };
        let (across, up) = (waves(xs), waves(ys));
        let of_column = |x: usize| -> Vec<[f64; 2]> {
            let across = &across[x * self.count..(x + 1) * self.count];
            self.modes
                .chunks(self.count)
                .map(|row| {
                    row.iter().zip(across).fold([0.0; 2], |[h, s], (a, w)| [h + a * w[0], s + a * w[1]])
                })
                .collect()
        };
        let columns: Vec<_> = (0..xs.len()).into_par_iter().map(of_column).collect();
        let at = |x: usize, y: usize| {
            let up = &up[y * self.count..(y + 1) * self.count];
            let sums = columns[x]
                .iter()
                .zip(up)
                .fold([0.0; 3], |[h, sx, sy], (c, w)| [h + c[0] * w[0], sx + c[1] * w[0], sy + c[0] * w[1]]);
            [sums[0], sums[1].hypot(sums[2])]
        };
        let pairs: Vec<_> = (0..ys.len()).flat_map(|y| (0..xs.len()).map(move |x| (x, y))).collect();
        pairs.into_par_iter().map(|(x, y)| at(x, y)).collect()
    }

    /// The largest depth and slope on a rectangle of this size (m) around a point.
    pub fn largest(&self, [x, y, _]: Point, size: [f64; 2]) -> [f64; 2] {
        const COARSE: f64 = 2e-4;
        const FINE: f64 = 1e-5;
        let middle = [x - self.centre[0], y - self.centre[1]];
        let along = |axis: usize, low: f64, high: f64, step: f64| -> Vec<f64> {
            let half = size[axis] / 2.0;
            let (low, high) = (low.max(middle[axis] - half), high.min(middle[axis] + half));
            let count = ((high - low) / step).ceil().max(1.0) as usize;
            (0..=count).map(|i| low + (high - low) * i as f64 / count as f64).collect()
        };
        let [xs, ys] = [0, 1].map(|axis| along(axis, f64::MIN, f64::MAX, COARSE));
        let values = self.on(&xs, &ys);
        [0, 1].map(|which| {
            let most = values.iter().map(|value| value[which]).fold(0.0, f64::max);
            let (columns, rows) = (xs.len(), ys.len());
            let near = |at: usize, count: usize| at.saturating_sub(1)..(at + 2).min(count);
            let is_top = |&i: &usize| {
                let is_lower = |j: usize, k: usize| values[j * columns + k][which] <= values[i][which];
                values[i][which] > 0.97 * most
                    && near(i / columns, rows).all(|j| near(i % columns, columns).all(|k| is_lower(j, k)))
            };
            let finer = |i: usize| {
                let (x, y) = (xs[i % xs.len()], ys[i / xs.len()]);
                let fine = [along(0, x - COARSE, x + COARSE, FINE), along(1, y - COARSE, y + COARSE, FINE)];
                self.on(&fine[0], &fine[1]).iter().map(|value| value[which]).fold(0.0, f64::max)
            };
            (0..values.len()).filter(is_top).map(finer).fold(most, f64::max)
        })
    }
}
