//! The measuring line of a profile, and lengths as text.

use glam::DVec2;

use crate::rounding::millimetres;
use crate::ui::ticks;

/// m: a shorter line is a slip of the hand.
pub const SHORTEST: f64 = 5e-4;

/// The line of the profile in the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProfileLine {
    /// Across the visible part, at this height (m) on the vertical axis.
    Across(f64),
    /// Between two points (m).
    Between([DVec2; 2]),
}

impl ProfileLine {
    /// Both ends (m), for this visible range of the horizontal axis.
    pub fn ends(self, [left, right]: [f64; 2]) -> [DVec2; 2] {
        match self {
            Self::Across(v) => [DVec2::new(left, v), DVec2::new(right, v)],
            Self::Between(ends) => ends,
        }
    }
}

/// A length (m) in mm with one decimal, without a sign on zero.
pub fn mm(length: f64) -> String {
    ticks::signed(&millimetres(length, 1))
}

/// Length of a line, and its angle from the horizontal axis.
pub fn length_and_angle([from, to]: [DVec2; 2]) -> String {
    let along = to - from;
    let angle = ticks::signed(&format!("{:.1}°", along.to_angle().to_degrees()));
    format!("{} mm, {angle}", mm(along.length()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn level_lines_have_no_negative_angle() {
        let line = [DVec2::ZERO, DVec2::new(0.03, -1e-12)];
        assert_eq!(length_and_angle(line), "30.0 mm, 0.0°");
        assert_eq!(length_and_angle([DVec2::ZERO, DVec2::new(0.0, 0.02)]), "20.0 mm, 90.0°");
    }
}
