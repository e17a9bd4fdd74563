//! Placement of a drawing as targets: size, position and sampling.

use glam::{DVec2, DVec3};

use crate::import::{Drawing, Line};
use crate::scene::{KeyError, Sampling, Shape, Target, outline};

/// Ends closer to another line than this part of the spacing would duplicate a focal point.
const TOUCHES: f64 = 0.6;
/// Lines shorter than this (m) are points in any case.
const SHORTEST: f64 = 1e-6;
/// Bisection steps for a spacing for a number of points.
const HALVINGS: u32 = 24;

/// Position and sampling of a drawing.
#[derive(Clone, Debug, PartialEq)]
pub struct Placement {
    /// m, its middle.
    pub at: DVec3,
    /// Unit vectors to its right and upwards.
    pub x: DVec3,
    pub y: DVec3,
    /// m, its longer side.
    pub side: f64,
    /// Continuous strokes, a spacing along the lines, or a total number of points, met as closely as the lines allow.
    pub sampling: Sampling,
}

impl Placement {
    /// The drawing as targets: a `path` for each line, a `point` for lines too short for two points. A line ending on
    /// another one is shortened by the spacing, so that focal points do not coincide; continuous strokes stay whole.
    ///
    /// # Errors
    /// More focal points than a scene may have.
    pub fn targets(&self, drawing: &Drawing) -> Result<Vec<Target>, KeyError> {
        let spacing = match self.sampling {
            Sampling::Spacing(spacing) => spacing,
            Sampling::Points(points) => self.spacing_for(points, drawing),
            Sampling::Whole => self.side,
            Sampling::Continuous | Sampling::Fill | Sampling::Stroke(_) => {
                let stroke = |line: &Line| self.target(line, self.sampling, SHORTEST);
                let targets: Vec<_> = drawing.lines.iter().map(stroke).collect();
                outline::count(&targets)?;
                return Ok(targets);
            }
        };
        let targets = self.at_spacing(drawing, spacing);
        outline::count(&targets)?;
        Ok(targets)
    }

    /// The spacing for a number of points, approached from below.
    fn spacing_for(&self, points: usize, drawing: &Drawing) -> f64 {
        let length: f64 = drawing.lines.iter().map(Line::length).sum::<f64>() * self.side;
        let is_enough = |spacing: f64| {
            outline::count(&self.at_spacing(drawing, spacing)).is_ok_and(|count| count <= points)
        };
        let guess = length / points.max(1) as f64;
        let (mut dense, mut sparse) = (guess / 4.0, guess * 4.0);
        for _ in 0..HALVINGS {
            let middle = (dense * sparse).sqrt();
            if is_enough(middle) { sparse = middle } else { dense = middle }
        }
        sparse
    }

    fn at_spacing(&self, drawing: &Drawing, spacing: f64) -> Vec<Target> {
        let own = spacing / self.side;
        let lines = drawing.lines.iter().zip(&drawing.gaps);
        let apart = lines.filter_map(|(line, &gaps)| apart(line, gaps, own));
        // A loop is never divided into less than three.
        let shortest = |line: &Line| if line.closed { 1.5 * spacing } else { 0.5 * spacing };
        apart.map(|line| self.target(&line, Sampling::Spacing(spacing), shortest(&line))).collect()
    }

    /// A path, or a point for a line shorter than `shortest` (m).
    fn target(&self, line: &Line, sampling: Sampling, shortest: f64) -> Target {
        let world = |point: DVec2| self.at + (self.x * point.x + self.y * point.y) * self.side;
        if line.length() * self.side < shortest {
            let middle = line.points.iter().sum::<DVec2>() / line.points.len().max(1) as f64;
            let dot = Target::new(Shape::Point { at: world(middle) });
            return Target { name: line.name.clone(), group: line.group.clone(), ..dot };
        }
        let vertices = line.points.iter().map(|&point| world(point)).collect();
        let path = Target::new(Shape::Path { vertices, closed: line.closed });
        Target { sampling, name: line.name.clone(), group: line.group.clone(), ..path }
    }
}

/// The line without its ends that touch another line. `None` if nothing remains.
fn apart(line: &Line, gaps: [f64; 2], spacing: f64) -> Option<Line> {
    let mut line = line.clone();
    if line.closed {
        return Some(line);
    }
    let touches = gaps.map(|gap| gap < TOUCHES * spacing);
    if touches[0] {
        line = line.without_beginning(spacing)?;
    }
    if touches[1] {
        line = line.reversed().without_beginning(spacing)?.reversed();
    }
    Some(line)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    fn placement(sampling: Sampling) -> Placement {
        Placement { at: DVec3::new(0.01, 0.0, 0.12), x: DVec3::X, y: DVec3::Y, side: 0.08, sampling }
    }

    fn line(points: &[(f64, f64)]) -> Line {
        Line::new(points.iter().map(|&point| DVec2::from(point)).collect(), false)
    }

    fn foci(targets: Vec<Target>) -> Vec<DVec3> {
        let scene = Scene { targets, ..Scene::default() };
        outline::foci(&scene).unwrap().into_iter().map(|focus| focus.position).collect()
    }

    #[test]
    fn it_lies_where_it_is_placed_and_as_large() {
        let drawing = Drawing::new(vec![line(&[(0.0, 0.0), (4.0, 0.0), (4.0, 2.0)])], Vec::new()).unwrap();
        assert_eq!(drawing.size, DVec2::new(1.0, 0.5));
        let foci = foci(placement(Sampling::Spacing(0.01)).targets(&drawing).unwrap());
        assert_eq!(foci.len(), 13, "8 and 4 pieces");
        assert!(foci[0].distance(DVec3::new(-0.03, -0.02, 0.12)) < 1e-12, "{}", foci[0]);
        assert!(foci[12].distance(DVec3::new(0.05, 0.02, 0.12)) < 1e-12, "{}", foci[12]);
    }

    #[test]
    fn where_lines_meet_there_is_one_focal_point() {
        let bar = line(&[(-1.0, 1.0), (1.0, 1.0)]);
        let stem = line(&[(0.0, 1.0), (0.0, 0.0)]);
        let drawing = Drawing::new(vec![stem, bar], Vec::new()).unwrap();
        let foci = foci(placement(Sampling::Spacing(0.01)).targets(&drawing).unwrap());
        for (i, a) in foci.iter().enumerate() {
            assert!(foci[..i].iter().all(|b| a.distance(*b) > 0.009), "{a}");
        }
        assert_eq!(foci.len(), 9 + 4);
    }

    #[test]
    fn a_number_in_all_is_met() {
        let lines = vec![
            line(&[(0.0, 0.0), (5.0, 0.0)]),
            line(&[(0.0, 2.0), (3.0, 2.0)]),
            line(&[(2.0, 4.0), (3.0, 4.0)]),
        ];
        let drawing = Drawing::new(lines, Vec::new()).unwrap();
        for points in [20, 33, 100] {
            let count = foci(placement(Sampling::Points(points)).targets(&drawing).unwrap()).len();
            assert!(count <= points && count + 3 >= points, "{count} for {points}");
        }
        let error = placement(Sampling::Spacing(1e-6)).targets(&drawing).unwrap_err();
        assert!(error.message.contains("a scene may have 1024"), "{error}");
    }

    #[test]
    fn continuous_strokes_stay_whole() {
        let bar = line(&[(-1.0, 1.0), (1.0, 1.0)]);
        let stem = line(&[(0.0, 1.0), (0.0, 0.0)]);
        let drawing = Drawing::new(vec![stem, bar], Vec::new()).unwrap();
        let targets = placement(Sampling::Continuous).targets(&drawing).unwrap();
        assert!(targets.iter().all(|target| target.sampling == Sampling::Continuous));
        let length = |target: &Target| {
            outline::strokes(target).unwrap()[0].windows(2).map(|pair| pair[0].distance(pair[1])).sum::<f64>()
        };
        assert!((targets.iter().map(length).sum::<f64>() - 0.12).abs() < 1e-9, "{targets:?}");
        assert!(foci(targets).len() > 50);
    }

    #[test]
    fn what_is_shorter_than_the_spacing_is_a_point() {
        let lines = vec![line(&[(0.0, 0.0), (0.0, 10.0)]), line(&[(5.0, 9.9), (5.0, 10.0)])];
        let targets =
            placement(Sampling::Spacing(0.01)).targets(&Drawing::new(lines, Vec::new()).unwrap()).unwrap();
        assert!(matches!(targets[1].shape, Shape::Point { .. }), "{targets:?}");
    }
}
