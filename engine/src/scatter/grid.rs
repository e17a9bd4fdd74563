//! A grid of cells that finds the triangles near a point.

use std::collections::HashMap;

use glam::{DVec3, I64Vec3};

use crate::scatter::facets::Facet;

/// Triangles by the cells of their centroids.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    /// Edge of a cell, m: the reach of the largest triangle.
    side: f64,
    cells: HashMap<I64Vec3, Vec<u32>>,
    /// The box of all cells.
    low: I64Vec3,
    high: I64Vec3,
}

impl Grid {
    /// The grid for a reach around centroids, relative to the triangles' radii.
    pub fn new(facets: &[Facet], reach: f64) -> Self {
        let side = facets.iter().map(|facet| facet.radius * reach).fold(f64::MIN_POSITIVE, f64::max);
        let mut cells = HashMap::<_, Vec<u32>>::new();
        let (mut low, mut high) = (I64Vec3::MAX, I64Vec3::MIN);
        for (facet, number) in facets.iter().zip(0..) {
            let cell = (facet.centroid / side).floor().as_i64vec3();
            cells.entry(cell).or_default().push(number);
            (low, high) = (low.min(cell), high.max(cell));
        }
        Self { side, cells, low, high }
    }

    /// The numbers of all triangles in whose reach a point (m) may be.
    pub fn around(&self, at: DVec3) -> impl Iterator<Item = usize> {
        let own = (at / self.side).floor().as_i64vec3();
        let (first, last) = ((own - 1).max(self.low), (own + 1).min(self.high));
        let cells = (first.x..=last.x).flat_map(move |x| {
            (first.y..=last.y).flat_map(move |y| (first.z..=last.z).map(move |z| I64Vec3::new(x, y, z)))
        });
        cells.filter_map(|cell| self.cells.get(&cell)).flatten().map(|&number| number as usize)
    }
}
