//! The pixels of a map, and which of them are interpolated from a plan's samples.
//!
//! Rows that come closer to the array than a wavelength are evaluated pixel by pixel, and so are all rows of a map
//! with fewer pixels than the plan has samples.

use std::ops::Range;

use glam::DVec3;

use crate::field::{plan::Plan, samples::Samples};

/// The pixels of one map on a plan's plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    pub width: usize,
    pub height: usize,
    /// Interpolated rows; the rest is evaluated pixel by pixel.
    pub interpolated: Range<usize>,
    columns: Vec<DVec3>,
    rows: Vec<DVec3>,
}

impl Raster {
    /// `None` for an invalid plane.
    pub fn new(plan: &Plan, (width, height): (usize, usize)) -> Option<Self> {
        let Samples { columns, rows } = Samples::on_plane(&plan.plane, width, height)?;
        let direct = Self { width, height, interpolated: 0..0, columns, rows };
        let Some(grid) = &plan.grid else { return Some(direct) };
        let row = |j: usize| plan.plane.size.y * ((j as f64 + 0.5) / height as f64 - 0.5);
        let below = |place: f64| (0..height).filter(|&j| row(j) < place).count();
        let interpolated = below(grid.covered.start)..below(grid.covered.end);
        if interpolated.len() * width <= grid.samples.len() {
            return Some(direct);
        }
        Some(Self { interpolated, ..direct })
    }

    /// Every pixel of the map.
    pub fn pixels(&self) -> Samples {
        self.pixel_rows(0..self.height)
    }

    /// Some rows of the map.
    pub fn pixel_rows(&self, rows: Range<usize>) -> Samples {
        Samples { columns: self.columns.clone(), rows: self.rows[rows].to_vec() }
    }

    /// The rows evaluated pixel by pixel, below and above the interpolated ones.
    pub fn direct(&self) -> impl Iterator<Item = Range<usize>> {
        [0..self.interpolated.start, self.interpolated.end..self.height]
            .into_iter()
            .filter(|rows| !rows.is_empty())
    }

    /// Number of evaluated points.
    pub fn evaluated(&self, plan: &Plan) -> usize {
        let direct: usize = self.direct().map(|rows| rows.len() * self.width).sum();
        let samples = plan.grid.as_ref().filter(|_| !self.interpolated.is_empty());
        direct + samples.map_or(0, |grid| grid.samples.len())
    }

    /// The method of evaluation, as text.
    pub fn describe(&self, plan: &Plan) -> String {
        let reason = &plan.reason;
        match &plan.grid {
            None => reason.clone(),
            Some(grid) if self.interpolated.is_empty() => {
                format!(
                    "every pixel is evaluated: they are fewer than the {} samples needed",
                    grid.samples.len()
                )
            }
            Some(_) if self.interpolated == (0..self.height) => {
                format!("{reason}: every pixel is interpolated")
            }
            Some(_) => format!(
                "{reason}: rows {} to {} of {} are interpolated, and the rest, too near to the array, is evaluated \
                 pixel by pixel",
                self.interpolated.start,
                self.interpolated.end - 1,
                self.height
            ),
        }
    }
}
