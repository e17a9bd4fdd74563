//! A field in a box, with the largest value of every brick of its cells.

use glam::{DVec3, UVec3, Vec3};
use rayon::prelude::*;

use crate::field::volume::Lattice;

/// Cells along the side of a brick of known maximum.
pub const BRICK: u32 = 8;

/// A field in a box.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    pub lattice: Lattice,
    /// RMS pressure, Pa.
    pub values: Vec<f32>,
    /// The largest of them a wavelength or more from every element, if any is; and of all.
    pub peak: f32,
    pub loudest: f32,
    /// Whether it lacks what bodies scatter.
    #[doc(hidden)]
    pub is_incident: bool,
    /// The largest value of every brick of [`BRICK`]³ cells.
    pub(crate) bricks: Vec<f32>,
}

impl Volume {
    /// The volume of given values.
    pub fn of(lattice: Lattice, values: Vec<f32>) -> Self {
        let bricks = bricks(&lattice, &values);
        let peak = bricks.iter().copied().fold(0.0, f32::max);
        Self { lattice, values, peak, loudest: peak, is_incident: false, bricks }
    }

    /// Bricks along the axes.
    pub(crate) fn brick_counts(&self) -> UVec3 {
        brick_counts(&self.lattice)
    }

    /// The value at a position in steps from the first point, interpolated linearly; outside the lattice, that of its
    /// boundary.
    #[inline]
    pub fn at(&self, place: Vec3) -> f32 {
        let counts = self.lattice.counts;
        let place = place.clamp(Vec3::ZERO, (counts - UVec3::ONE).as_vec3());
        let cell = place.as_uvec3().min(counts.saturating_sub(UVec3::splat(2)));
        let part = place - cell.as_vec3();
        let (row, layer) = (counts.x as usize, (counts.x * counts.y) as usize);
        let corner = cell.x as usize + cell.y as usize * row + cell.z as usize * layer;
        // A single bounds check serves the four values of a layer.
        let across = |at: usize| {
            let four = &self.values[at..][..row + 2];
            let (a, b) = (four[0], four[row]);
            let (a, b) = (a + (four[1] - a) * part.x, b + (four[row + 1] - b) * part.x);
            a + (b - a) * part.y
        };
        let (a, b) = (across(corner), across(corner + layer));
        a + (b - a) * part.z
    }

    /// Gradient per step along the axes, by central differences.
    pub fn slope(&self, place: Vec3) -> Vec3 {
        let along = |step: Vec3| 0.5 * (self.at(place + step) - self.at(place - step));
        Vec3::new(along(Vec3::X), along(Vec3::Y), along(Vec3::Z))
    }

    /// The value at a point (m); beyond the lattice that of its rim.
    pub fn value(&self, point: DVec3) -> f32 {
        self.at(((point - self.lattice.first) / self.lattice.step).as_vec3())
    }
}

pub fn brick_counts(lattice: &Lattice) -> UVec3 {
    let cells = lattice.counts - UVec3::ONE;
    (cells + UVec3::splat(BRICK - 1)) / BRICK
}

/// The largest value of every brick, faces included, x fastest.
pub fn bricks(lattice: &Lattice, values: &[f32]) -> Vec<f32> {
    let (counts, bricks) = (lattice.counts, brick_counts(lattice));
    let (row, layer) = (counts.x as usize, (counts.x * counts.y) as usize);
    let of_brick = |index: u32| {
        let (x, y, z) = (index % bricks.x, index / bricks.x % bricks.y, index / bricks.x / bricks.y);
        let first = UVec3::new(x, y, z) * BRICK;
        let last = (first + BRICK).min(counts - UVec3::ONE);
        let mut largest = 0.0f32;
        for z in first.z..=last.z {
            for y in first.y..=last.y {
                let start = z as usize * layer + y as usize * row;
                let run = &values[start + first.x as usize..=start + last.x as usize];
                largest = run.iter().fold(largest, |largest, value| largest.max(*value));
            }
        }
        largest
    };
    (0..bricks.element_product()).into_par_iter().with_min_len(64).map(of_brick).collect()
}
