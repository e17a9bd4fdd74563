//! Values read at scattered places of a plane, as pixels: each takes the value of the nearest place, so that it is seen
//! where readings are and how dense.

use std::collections::HashMap;

use glam::{DVec2, IVec2};

use crate::field::Quantity;
use crate::scene::Plane;

/// Spacings from the nearest place beyond which a pixel has no value.
const REACH: f64 = 1.5;

#[derive(Clone, Debug, PartialEq)]
pub struct Scattered {
    pub quantity: Quantity,
    pub plane: Plane,
    /// m from the plane's centre, along its axes.
    pub places: Vec<DVec2>,
    /// In the quantity's unit.
    pub values: Vec<f32>,
    /// Whether the values are differences.
    pub is_difference: bool,
}

impl Scattered {
    /// m between neighbours, if they were evenly spread.
    pub fn spacing(&self) -> f64 {
        (self.plane.size.x * self.plane.size.y / self.places.len().max(1) as f64).sqrt()
    }

    /// The values of pixels, row 0 at the smallest y; NaN far from all places.
    pub fn pixels(&self, width: usize, height: usize) -> Vec<f32> {
        let cell = self.spacing().max(f64::MIN_POSITIVE);
        let bucket = |place: DVec2| (place / cell).floor().as_ivec2();
        let mut buckets: HashMap<IVec2, Vec<usize>> = HashMap::new();
        for (index, &place) in self.places.iter().enumerate() {
            buckets.entry(bucket(place)).or_default().push(index);
        }
        let size = DVec2::new(width as f64, height as f64);
        let value = |index: usize| {
            let pixel = DVec2::new((index % width) as f64, (index / width) as f64) + 0.5;
            let place = (pixel / size - 0.5) * self.plane.size;
            let (mut nearest, mut value) = ((REACH * cell).powi(2), f32::NAN);
            // The reach is two cells at most.
            for offset in (0..25).map(|n| IVec2::new(n % 5 - 2, n / 5 - 2)) {
                for &other in buckets.get(&(bucket(place) + offset)).into_iter().flatten() {
                    let distance = self.places[other].distance_squared(place);
                    if distance < nearest {
                        (nearest, value) = (distance, self.values[other]);
                    }
                }
            }
            value
        };
        (0..width * height).map(value).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_takes_the_nearest_reading_and_none_far_from_all() {
        let plane = Plane { size: DVec2::new(0.02, 0.01), ..Plane::default() };
        let places = vec![DVec2::new(-0.008, 0.0), DVec2::new(-0.004, 0.0), DVec2::new(-0.006, 0.004)];
        let values = vec![1.0, 2.0, 3.0];
        let scattered = Scattered { quantity: Quantity::Rms, plane, places, values, is_difference: false };
        let pixels = scattered.pixels(20, 10);
        let at = |x: usize, y: usize| pixels[y * 20 + x];
        assert_eq!((at(1, 4), at(6, 4), at(4, 9)), (1.0, 2.0, 3.0));
        // 13 mm and more from the readings, which are 8 mm apart.
        assert!(at(19, 4).is_nan());
    }
}
