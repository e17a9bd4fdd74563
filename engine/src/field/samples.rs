//! Sample points of a field: a grid on a plane, or a list.

use std::borrow::Cow;
use std::io::Read;

use glam::DVec3;

use crate::acoustics::Pose;
use crate::scene::Plane;
use crate::table::{Order, Table, TableError};

/// Limit of points of a table: more would need gigabytes.
pub const MOST_POINTS: usize = 10_000_000;

/// m; points beyond are slips of the unit.
pub const FARTHEST: f64 = 1e6;

/// Sample points: sample (i, j) is at `columns[i] + rows[j]`.
///
/// A grid on a plane has as many columns and rows as its width and height; a list of points is one row.
#[derive(Clone, Debug, PartialEq)]
pub struct Samples {
    /// m
    pub columns: Vec<DVec3>,
    /// m
    pub rows: Vec<DVec3>,
}

impl Samples {
    /// Samples at the centres of `width` x `height` pixels that fill the plane, row 0 at the smallest y.
    ///
    /// `None` for parallel or zero axes, which a checked scene never has.
    pub fn on_plane(plane: &Plane, width: usize, height: usize) -> Option<Self> {
        let (x_axis, y_axis) = plane.axes()?;
        let along = |axis: DVec3, length: f64, count: usize| {
            (0..count).map(move |i| axis * (length * ((i as f64 + 0.5) / count as f64 - 0.5)))
        };
        Some(Self {
            columns: along(x_axis, plane.size.x, width).map(|offset| plane.centre + offset).collect(),
            rows: along(y_axis, plane.size.y, height).collect(),
        })
    }

    /// The points themselves.
    pub fn at(points: Vec<DVec3>) -> Self {
        Self { columns: points, rows: vec![DVec3::ZERO] }
    }

    /// The points of a table with the columns `x`, `y` and `z` (m, unless their headings name a unit), or of those three
    /// columns alone.
    ///
    /// # Errors
    /// No points or too many, an invalid row, or a point farther than 1000 km along an axis.
    pub fn read(csv: impl Read) -> Result<Self, TableError> {
        Self::read_with_unit(csv).map(|(samples, _)| samples)
    }

    /// The same, and whether the table names their unit.
    ///
    /// # Errors
    /// The errors of [`Self::read`].
    #[doc(hidden)]
    pub fn read_with_unit(csv: impl Read) -> Result<(Self, bool), TableError> {
        let orders: [Order; 2] = [&["x", "y", "z"], &["#", "x", "y", "z"]];
        let mut table = Table::in_order(csv, ["x", "y", "z"], [], &orders)?;
        let mut points = Vec::new();
        while let Some(row) = table.next_row()? {
            let [] = row.optional;
            let at = row.required;
            let point = DVec3::from_array(at);
            if point.abs().max_element() > FARTHEST {
                let reason =
                    format!("{at:?}: must be metres, every coordinate from -{FARTHEST} to {FARTHEST}");
                return Err(table.refusal(reason));
            }
            if points.len() == MOST_POINTS {
                return Err(table.refusal(format!("more than {MOST_POINTS} points")));
            }
            points.push(point);
        }
        if points.is_empty() {
            return Err(table.refusal("there are no points"));
        }
        Ok((Self::at(points), table.has_unit()))
    }

    pub fn len(&self) -> usize {
        self.columns.len() * self.rows.len()
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Sample number `index`, row by row.
    ///
    /// # Panics
    /// An index beyond the last.
    pub fn point(&self, index: usize) -> DVec3 {
        self.columns[index % self.columns.len()] + self.rows[index / self.columns.len()]
    }

    /// The same in the coordinates of a board.
    pub(crate) fn seen_from(&self, pose: &Pose) -> Cow<'_, Self> {
        if *pose == Pose::HOME {
            return Cow::Borrowed(self);
        }
        Cow::Owned(Self {
            columns: self.columns.iter().map(|&point| pose.local(point)).collect(),
            rows: self.rows.iter().map(|&offset| pose.local_direction(offset)).collect(),
        })
    }

    /// The bounding box of all samples: its smallest and its largest corner.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let range = |points: &[DVec3]| {
            points.iter().fold((DVec3::MAX, DVec3::MIN), |(low, high), p| (low.min(*p), high.max(*p)))
        };
        let ((column_low, column_high), (row_low, row_high)) = (range(&self.columns), range(&self.rows));
        (column_low + row_low, column_high + row_high)
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, dvec3};

    use super::*;

    #[test]
    fn samples_stand_at_pixel_centres_row_0_at_the_smallest_y() {
        let plane = Plane { size: DVec2::new(0.4, 0.2), ..Plane::default() };
        let samples = Samples::on_plane(&plane, 4, 2).unwrap();
        assert_eq!(samples.len(), 8);
        assert!(samples.point(0).distance(dvec3(-0.15, -0.05, 0.1)) < 1e-15);
        assert!(samples.point(3).distance(dvec3(0.15, -0.05, 0.1)) < 1e-15);
        assert!(samples.point(4).distance(dvec3(-0.15, 0.05, 0.1)) < 1e-15);
    }

    #[test]
    fn points_are_read_and_slips_are_named_by_line() {
        let samples = Samples::read(&b"z,x,y\n0.1,-0.0,1e-3\n"[..]).unwrap();
        assert_eq!(samples, Samples::at(vec![dvec3(-0.0, 1e-3, 0.1)]));
        for (text, error) in [
            ("x,y,z\n", "1: there are no points"),
            ("x,y,z\n0,0,0.1\n0,-2e6,0\n", "3: [0.0, -2000000.0, 0.0]: must be metres"),
            ("x,y\n", "1: the column `z` is missing"),
        ] {
            let refused = Samples::read(text.as_bytes()).unwrap_err().to_string();
            assert!(refused.starts_with(error), "{text:?}: {refused}");
        }
    }

    #[test]
    fn a_vertical_plane_has_its_own_up() {
        let plane = Plane { y_axis: dvec3(3.0, 0.0, 2.0), ..Plane::default() };
        let samples = Samples::on_plane(&plane, 1, 2).unwrap();
        assert!(samples.point(0).distance(dvec3(0.0, 0.0, 0.05)) < 1e-15);
        assert!(samples.point(1).distance(dvec3(0.0, 0.0, 0.15)) < 1e-15);
    }

    #[test]
    fn all_samples_lie_within_their_bounds_and_touch_them() {
        let columns = vec![dvec3(0.1, 0.0, 0.2), dvec3(-0.3, 0.1, 0.25), dvec3(0.0, -0.1, 0.3)];
        let samples = Samples { columns, rows: vec![dvec3(0.0, 0.3, 0.01), dvec3(0.02, 0.5, -0.04)] };
        let points = || (0..samples.len()).map(|index| samples.point(index));
        let low = points().fold(DVec3::MAX, DVec3::min);
        let high = points().fold(DVec3::MIN, DVec3::max);
        assert_eq!(samples.bounds(), (low, high));
    }
}
