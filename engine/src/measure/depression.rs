//! A liquid as the sensor: the strength that explains measured depressions of its surface, which grow with the square of
//! the pressure.
//!
//! d_i = s² m(x_i + δ) + a + b·x_i, m the depression of the scene's drive, s the strength over the scene's, δ the shift of
//! the camera's picture along the surface, a and b its zero and its tilt. All but δ are linear; Gauss and Newton find them
//! together.

use glam::DVec2;

use crate::field::Map;
use crate::measure::fit::Estimate;
use crate::solver::cholesky::Factor;

/// Unknowns: s², shifts times s², zero, and tilts.
const UNKNOWNS: usize = 6;
/// Steps, and the shift (m) below which they end.
const STEPS: usize = 30;
const STILL: f64 = 1e-9;
/// Metres by which a step moves the picture at most: further, the slopes are others.
const LONGEST: f64 = 1e-3;

/// What depressions tell.
#[derive(Clone, Debug, PartialEq)]
pub struct DepressionFit {
    /// The strength relative to the scene's; 0 if the readings rise where they should sink.
    pub scale: Estimate,
    /// m, of the picture along the axes of the plane.
    pub shift: DVec2,
    pub shift_error: DVec2,
    /// m: the zero of the heights.
    pub offset: f64,
    /// Rms of readings less model over that of the readings less their zero and tilt.
    pub residual: f64,
    /// m, of the model.
    pub model: Vec<f64>,
}

/// Values of a map at a place of its plane (m from the centre), by cubic convolution.
fn value(map: &Map, size: DVec2, place: DVec2) -> f64 {
    let count = DVec2::new(map.width as f64, map.height as f64);
    let at = (place / size + 0.5) * count - 0.5;
    let first = at.floor();
    let weights = |t: f64| {
        [
            ((2.0 - t) * t - 1.0) * t / 2.0,
            ((3.0 * t - 5.0) * t * t + 2.0) / 2.0,
            ((4.0 - 3.0 * t) * t + 1.0) * t / 2.0,
            (t - 1.0) * t * t / 2.0,
        ]
    };
    let (across, along) = (weights(at.x - first.x), weights(at.y - first.y));
    let pixel = |x: f64, y: f64| {
        let x = x.clamp(0.0, count.x - 1.0) as usize;
        let y = y.clamp(0.0, count.y - 1.0) as usize;
        f64::from(map.values[y * map.width + x])
    };
    let row = |(j, weight): (usize, f64)| {
        let y = first.y + j as f64 - 1.0;
        weight * across.iter().enumerate().map(|(i, w)| w * pixel(first.x + i as f64 - 1.0, y)).sum::<f64>()
    };
    along.into_iter().enumerate().map(row).sum()
}

/// Fits depressions (m, down) at places of a plane of this size (m from its centre) to the depression map of the scene's
/// drive; `None` if they do not determine the strength.
pub fn fit_depression(map: &Map, size: DVec2, places: &[DVec2], readings: &[f64]) -> Option<DepressionFit> {
    let mut shift = DVec2::ZERO;
    let step = size / DVec2::new(map.width as f64, map.height as f64);
    let mut solution = [0.0; UNKNOWNS];
    let mut factor = None;
    let row = |place: &DVec2, shift: DVec2| -> [f64; UNKNOWNS] {
        let at = *place + shift;
        let slope = |offset: DVec2, length: f64| {
            (value(map, size, at + offset) - value(map, size, at - offset)) / (2.0 * length)
        };
        let (x, y) = (DVec2::X * step.x, DVec2::Y * step.y);
        [value(map, size, at), slope(x, step.x), slope(y, step.y), 1.0, place.x, place.y]
    };
    for _ in 0..STEPS {
        let mut matrix = [[0.0; UNKNOWNS]; UNKNOWNS];
        let mut right = [0.0; UNKNOWNS];
        for (place, reading) in places.iter().zip(readings) {
            let row = row(place, shift);
            for (i, a) in row.iter().enumerate() {
                right[i] += a * reading;
                row.iter().enumerate().for_each(|(j, b)| matrix[i][j] += a * b);
            }
        }
        let own = Factor::new(UNKNOWNS, |i, j| matrix[i][j])?;
        solution = own.solve(&right).try_into().ok()?;
        factor = Some(own);
        let [square, x, y, ..] = solution;
        let moved = DVec2::new(x, y) / square;
        if !moved.is_finite() {
            return None;
        }
        let moved = moved.clamp_length_max(LONGEST);
        shift += moved;
        if moved.length() < STILL {
            break;
        }
    }
    let [square, _, _, offset, tilt_x, tilt_y] = solution;
    let ground = |place: &DVec2| offset + tilt_x * place.x + tilt_y * place.y;
    let model: Vec<_> =
        places.iter().map(|place| square * value(map, size, *place + shift) + ground(place)).collect();
    let squares = |values: &mut dyn Iterator<Item = f64>| values.map(|value| value * value).sum::<f64>();
    let left = squares(&mut readings.iter().zip(&model).map(|(reading, model)| reading - model));
    let all = squares(&mut readings.iter().zip(places).map(|(reading, place)| reading - ground(place)));
    let variance = left / readings.len().saturating_sub(UNKNOWNS).max(1) as f64;
    let error = |unknown: usize| {
        let mut unit = [0.0; UNKNOWNS];
        unit[unknown] = 1.0;
        factor.as_ref().map_or(f64::INFINITY, |factor| (variance * factor.solve(&unit)[unknown]).sqrt())
    };
    let scale = square.max(0.0).sqrt();
    // d(s²) = 2 s ds.
    let scale = Estimate { value: scale, error: error(0) / (2.0 * scale.max(1e-9)), is_free: true };
    let shift_error = DVec2::new(error(1), error(2)) / square.abs().max(1e-18);
    let residual = (left / all.max(f64::MIN_POSITIVE)).sqrt();
    Some(DepressionFit { scale, shift, shift_error, offset, residual, model })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strength_and_shift_come_back_from_depressions() {
        let size = DVec2::new(0.04, 0.03);
        let shape = |at: DVec2| 1e-3 * (-(at - DVec2::new(2e-3, -1e-3)).length_squared() / 2e-5).exp();
        let (width, height) = (160, 120);
        let pixel = |index: usize| {
            let at = DVec2::new((index % width) as f64 + 0.5, (index / width) as f64 + 0.5);
            shape((at / DVec2::new(width as f64, height as f64) - 0.5) * size) as f32
        };
        let values = (0..width * height).map(pixel).collect();
        let map = Map { width, height, values, ..Map::default() };
        let places: Vec<_> = (0..600)
            .map(|n| DVec2::new(f64::from(n % 30) - 14.5, f64::from(n / 30) - 9.5) * 1.2e-3)
            .collect();
        let shift = DVec2::new(0.7e-3, -0.4e-3);
        // A strength of 1.2, a camera with a zero and a tilt of its own.
        let readings: Vec<_> =
            places.iter().map(|place| 1.44 * shape(*place + shift) + 2e-5 + 1e-3 * place.x).collect();
        let fit = fit_depression(&map, size, &places, &readings).unwrap();
        assert!((fit.scale.value - 1.2).abs() < 1e-4, "{fit:?}");
        assert!(fit.shift.distance(shift) < 1e-6 && (fit.offset - 2e-5).abs() < 1e-7, "{fit:?}");
        assert!(fit.residual < 1e-3, "{}", fit.residual);
        assert_eq!(fit_depression(&map, size, &places, &vec![0.0; places.len()]), None);
    }
}
