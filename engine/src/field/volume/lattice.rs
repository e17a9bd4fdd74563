//! Boxes, and lattices of points in them.

use glam::{DVec2, DVec3, UVec3};

use crate::scene::Plane;

/// Points of a volume along an axis, and in all: four gigabytes of file.
pub const MOST_POINTS_ALONG: u32 = 4096;

pub const MOST_POINTS: u64 = 1 << 30;

/// Tolerated excess of a box over whole steps, for rounding.
pub const SLACK: f64 = 1e-6;

/// A box whose edges are parallel to the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// m
    pub centre: DVec3,
    /// m
    pub size: DVec3,
}

impl Block {
    /// The box between two opposite corners.
    pub fn between(low: DVec3, high: DVec3) -> Self {
        Self { centre: (low + high) / 2.0, size: high - low }
    }

    /// The corner of the smallest coordinates, m.
    pub fn low(&self) -> DVec3 {
        self.centre - self.size / 2.0
    }

    /// The corner of the largest coordinates, m.
    pub fn high(&self) -> DVec3 {
        self.centre + self.size / 2.0
    }
}

/// Points at equal distances along the axes, x fastest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// m, the point of the smallest coordinates.
    pub first: DVec3,
    /// m, between neighbours.
    pub step: DVec3,
    pub counts: UVec3,
}

impl Lattice {
    /// The centres of equal cells that fill a box, like the pixels of a map.
    pub fn of_cells(block: &Block, counts: UVec3) -> Self {
        let step = block.size / counts.as_dvec3();
        Self { first: block.low() + step / 2.0, step, counts }
    }

    /// Points that cover a box at these distances (m), about its centre; the outermost are on its faces or outside.
    pub fn covering(block: &Block, step: DVec3) -> Self {
        let intervals = (block.size / step - SLACK).ceil().max(DVec3::ONE);
        Self { first: block.centre - step * intervals / 2.0, step, counts: intervals.as_uvec3() + UVec3::ONE }
    }

    pub fn len(&self) -> usize {
        self.counts.as_u64vec3().element_product() as usize
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The horizontal plane with pixels at the points of layer `z` of [`Lattice::of_cells`].
    pub fn layer(&self, z: u32, tolerance: f64) -> Plane {
        let counts = self.counts.as_dvec3();
        let middle = self.first + self.step * (counts - DVec3::ONE) / 2.0;
        let height = self.first.z + self.step.z * f64::from(z);
        let size = self.step * counts;
        Plane {
            centre: DVec3::new(middle.x, middle.y, height),
            x_axis: DVec3::X,
            y_axis: DVec3::Y,
            size: DVec2::new(size.x, size.y),
            tolerance,
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::dvec3;

    use super::*;
    use crate::field::samples::Samples;

    #[test]
    fn cells_fill_the_box_and_layers_hold_their_centres() {
        let block = Block::between(dvec3(-0.1, 0.0, 0.02), dvec3(0.1, 0.3, 0.14));
        let lattice = Lattice::of_cells(&block, UVec3::new(4, 3, 6));
        assert_eq!(lattice.len(), 72);
        assert!(lattice.first.distance(dvec3(-0.075, 0.05, 0.03)) < 1e-15);
        let samples = Samples::on_plane(&lattice.layer(5, 1e-3), 4, 3).unwrap();
        assert!(samples.point(0).distance(dvec3(-0.075, 0.05, 0.13)) < 1e-15);
        assert!(samples.point(11).distance(dvec3(0.075, 0.25, 0.13)) < 1e-15);
    }

    #[test]
    fn points_cover_the_box_about_its_middle() {
        let block = Block { centre: dvec3(0.0, 0.0, 0.1), size: dvec3(0.1, 0.05, 0.021) };
        let lattice = Lattice::covering(&block, DVec3::splat(0.002));
        assert_eq!(lattice.counts, UVec3::new(51, 26, 12));
        let last = lattice.first + lattice.step * (lattice.counts - UVec3::ONE).as_dvec3();
        assert!((lattice.first + last - 2.0 * block.centre).abs().max_element() < 1e-15);
        assert!(lattice.first.cmple(block.low() + 1e-15).all() && last.cmpge(block.high() - 1e-15).all());
    }
}
