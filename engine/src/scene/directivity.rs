//! The measured directivity of an element: a table of angles, and the smooth function that stands for it.
//!
//! Evaluators need derivatives, and the same function in f64 and f32. So D is by definition a sum of [`TERMS`] Chebyshev
//! polynomials in 2 cosθ - 1, with the phase as its argument: the least-squares fit, with Chebyshev's weight, to a natural cubic
//! spline through the table that is even in θ, divided by its value at θ = 0. Between the table's last angle and 90° the last value
//! holds. The degree resolves lobes down to some 8°.

use std::f64::consts::PI;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::scene::loaded::Loaded;

/// Terms of the sum.
pub const TERMS: usize = 24;
/// Places at which the sum is fitted, a multiple of its terms.
const NODES: usize = 480;

/// Coefficients of a directivity, real and imaginary part.
pub type Series = [[f64; 2]; TERMS];

/// The same in every direction.
pub const EVEN: Series = {
    let mut series = [[0.0; 2]; TERMS];
    series[0][0] = 1.0;
    series
};

/// A directivity, once loaded. A scene file only names it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Directivity {
    measured: Loaded<Measured>,
    /// The file of origin.
    pub from: Option<PathBuf>,
}

/// A row of a table.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reading {
    /// Degrees from the axis.
    pub angle: f64,
    /// Relative; below 0 it has the opposite phase.
    pub amplitude: f64,
    /// Degrees; more is earlier.
    pub phase: f64,
}

/// A table and its fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// By angle, from 0.
    pub readings: Vec<Reading>,
    pub series: Series,
    /// Largest difference between the fit and the table up to 90°, relative to the amplitude at 0°.
    pub residual: f64,
}

impl Directivity {
    /// The directivity of a table with angles that rise from 0, two at least, and an amplitude other than 0 there.
    pub fn new(readings: Vec<Reading>, from: Option<PathBuf>) -> Self {
        Self { measured: Loaded::new(Measured::new(readings)), from }
    }

    pub fn get(&self) -> Option<&Measured> {
        self.measured.get()
    }

    /// Its coefficients; without a table, those of a point.
    pub fn series(&self) -> Series {
        self.get().map_or(EVEN, |measured| measured.series)
    }
}

impl Measured {
    fn new(readings: Vec<Reading>) -> Self {
        let angles: Vec<_> = readings.iter().map(|it| it.angle.to_radians()).collect();
        let value = |it: &Reading, part: usize| {
            let (sin, cos) = it.phase.to_radians().sin_cos();
            it.amplitude * [cos, sin][part]
        };
        let parts = [0, 1].map(|part| {
            let values: Vec<_> = readings.iter().map(|it| value(it, part)).collect();
            fitted(&Spline::new(angles.clone(), values))
        });
        let raw: Series = std::array::from_fn(|n| [parts[0][n], parts[1][n]]);
        let [re, im] = at(&raw, 1.0);
        let square = re * re + im * im;
        let over = |[x, y]: [f64; 2]| [(x * re + y * im) / square, (y * re - x * im) / square];
        let series = raw.map(over);
        let first = [value(&readings[0], 0), value(&readings[0], 1)];
        let peak = first[0].hypot(first[1]);
        let off = |it: &Reading| {
            let [re, im] = at(&raw, it.angle.to_radians().cos());
            (re - value(it, 0)).hypot(im - value(it, 1)) / peak
        };
        let residual = readings.iter().filter(|it| it.angle <= 90.0).map(off).fold(0.0, f64::max);
        Self { readings, series, residual }
    }
}

/// The sum's value at a cosine, by Clenshaw's rule.
pub(crate) fn at(series: &Series, cos: f64) -> [f64; 2] {
    let twice = 2.0 * (2.0 * cos - 1.0);
    let (mut now, mut before) = ([0.0; 2], [0.0; 2]);
    for term in series[1..].iter().rev() {
        (now, before) = ([0, 1].map(|part| term[part] + twice * now[part] - before[part]), now);
    }
    [0, 1].map(|part| series[0][part] + twice / 2.0 * now[part] - before[part])
}

/// The sum's value and its derivative by the cosine.
pub(crate) fn with_slope(series: &Series, cos: f64) -> [[f64; 2]; 2] {
    let s = 2.0 * cos - 1.0;
    // Chebyshev polynomials, and their derivatives.
    let (mut before, mut now) = ([1.0, 0.0], [s, 1.0]);
    let mut sum = [[series[0][0], series[0][1]], [0.0; 2]];
    for term in &series[1..] {
        for part in [0, 1] {
            sum[0][part] += term[part] * now[0];
            sum[1][part] += term[part] * now[1];
        }
        (before, now) = (now, [2.0 * s * now[0] - before[0], 2.0 * now[0] + 2.0 * s * now[1] - before[1]]);
    }
    [sum[0], sum[1].map(|slope| 2.0 * slope)]
}

fn fitted(spline: &Spline) -> [f64; TERMS] {
    let mut sums = [0.0; TERMS];
    for node in 0..NODES {
        let place = PI * (node as f64 + 0.5) / NODES as f64;
        let value = spline.at(f64::midpoint(place.cos(), 1.0).clamp(0.0, 1.0).acos());
        for (order, sum) in sums.iter_mut().enumerate() {
            *sum += value * (order as f64 * place).cos();
        }
    }
    std::array::from_fn(|order| sums[order] * if order == 0 { 1.0 } else { 2.0 } / NODES as f64)
}

/// A cubic spline that is even about 0 and ends straight; level beyond its last place.
struct Spline {
    /// rad
    places: Vec<f64>,
    values: Vec<f64>,
    /// Second derivatives.
    bends: Vec<f64>,
}

impl Spline {
    fn new(places: Vec<f64>, values: Vec<f64>) -> Self {
        let count = places.len();
        let step = |i: usize| places[i + 1] - places[i];
        let slope = |i: usize| (values[i + 1] - values[i]) / step(i);
        // Rows of a tridiagonal system, eliminated from the first on: level at 0, natural at the end.
        let (mut upper, mut right) = (vec![0.0; count], vec![0.0; count]);
        (upper[0], right[0]) = (0.5, 3.0 * slope(0) / step(0));
        for i in 1..count - 1 {
            let diagonal = 2.0 * (step(i - 1) + step(i)) - step(i - 1) * upper[i - 1];
            upper[i] = step(i) / diagonal;
            right[i] = (6.0 * (slope(i) - slope(i - 1)) - step(i - 1) * right[i - 1]) / diagonal;
        }
        let mut bends = vec![0.0; count];
        for i in (0..count - 1).rev() {
            bends[i] = right[i] - upper[i] * bends[i + 1];
        }
        Self { places, values, bends }
    }

    fn at(&self, place: f64) -> f64 {
        let last = self.places.len() - 1;
        if place >= self.places[last] {
            return self.values[last];
        }
        let i = self.places.partition_point(|&it| it <= place).clamp(1, last) - 1;
        let step = self.places[i + 1] - self.places[i];
        let (below, above) = ((self.places[i + 1] - place) / step, (place - self.places[i]) / step);
        let bend = |part: f64, bend: f64| (part * part * part - part) * bend * step * step / 6.0;
        below * self.values[i]
            + above * self.values[i + 1]
            + bend(below, self.bends[i])
            + bend(above, self.bends[i + 1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Readings of a function every so many degrees.
    fn readings(step: f64, of: impl Fn(f64) -> [f64; 2]) -> Vec<Reading> {
        let count = (90.0 / step).round() as usize;
        let reading = |n: usize| {
            let angle = step * n as f64;
            let [amplitude, phase] = of(angle.to_radians());
            Reading { angle, amplitude, phase }
        };
        (0..=count).map(reading).collect()
    }

    #[test]
    fn the_fit_of_a_smooth_table_is_the_function_itself() {
        let piston = |angle: f64| 0.6 + 0.4 * (3.0 * angle.sin().powi(2)).cos();
        let lead = |angle: f64| 40.0 * angle.sin().powi(2);
        let own = Directivity::new(readings(2.5, |angle| [0.3 * piston(angle), 17.0 + lead(angle)]), None);
        let measured = own.get().unwrap();
        assert!(measured.residual < 1e-3, "{}", measured.residual);
        assert_eq!(at(&measured.series, 1.0).map(|x| (1e12 * x).round()), [1e12, 0.0]);
        for i in 0..=90 {
            let angle = f64::from(i).to_radians();
            let (sin, cos) = lead(angle).to_radians().sin_cos();
            let [re, im] = at(&measured.series, angle.cos());
            let off = (re - piston(angle) * cos).hypot(im - piston(angle) * sin);
            assert!(off < 1e-3, "{i} degrees: {off}");
        }
    }

    #[test]
    fn noise_that_no_smooth_function_meets_shows_in_the_residual() {
        let noise = |angle: f64| [1.0 + 0.2 * (1e3 * angle).sin(), 0.0];
        assert!(Directivity::new(readings(1.0, noise), None).get().unwrap().residual > 0.05);
    }
}
