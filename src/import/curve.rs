//! Curves through knots with handles, as polylines.

use glam::DVec2;
use kurbo::{BezPath, PathEl, Point};

/// A point of a curve. A corner has no handle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knot {
    pub at: DVec2,
    /// The end of the handle of the piece that follows, relative to the knot; that of the piece before is opposite.
    pub handle: DVec2,
}

/// The polyline within `tolerance` of the cubic curve through knots; of a closed one the first point is not repeated.
pub fn flattened(knots: &[Knot], closed: bool, tolerance: f64) -> Vec<DVec2> {
    let point = |at: DVec2| Point::new(at.x, at.y);
    let [first, ..] = knots else { return Vec::new() };
    let mut path = BezPath::new();
    path.move_to(point(first.at));
    let closing = closed.then_some([knots[knots.len() - 1], *first]);
    for [from, to] in knots.windows(2).map(|pair| [pair[0], pair[1]]).chain(closing) {
        match (from.handle, to.handle) {
            (DVec2::ZERO, DVec2::ZERO) => path.line_to(point(to.at)),
            (out, onward) => {
                path.curve_to(point(from.at + out), point(to.at - onward), point(to.at));
            }
        }
    }
    let mut points = Vec::new();
    kurbo::flatten(path, tolerance, |element| match element {
        PathEl::MoveTo(to) | PathEl::LineTo(to) => points.push(DVec2::new(to.x, to.y)),
        // Flat paths have none, and this one is closed by a piece.
        PathEl::QuadTo(..) | PathEl::CurveTo(..) | PathEl::ClosePath => {}
    });
    if closed {
        points.pop();
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_stay_near_and_corners_stay_corners() {
        // Four knots with handles of 0.5523 of the radius make a circle.
        let knots: Vec<_> = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y]
            .map(|at| Knot { at, handle: at.perp() * 0.5523 })
            .into();
        let ring = flattened(&knots, true, 0.01);
        assert!((12..40).contains(&ring.len()), "{}", ring.len());
        assert!(ring.iter().all(|at| (at.length() - 1.0).abs() < 0.01), "{ring:?}");
        let corners: Vec<_> = knots.iter().map(|knot| Knot { handle: DVec2::ZERO, ..*knot }).collect();
        assert_eq!(flattened(&corners, true, 0.01), corners.iter().map(|it| it.at).collect::<Vec<_>>());
    }
}
