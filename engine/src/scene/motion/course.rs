//! Foci that run along the drawn outlines, stroke by stroke in the order of the file.

use glam::DVec3;

use crate::scene::motion::track::Track;
use crate::scene::range::KeyError;
use crate::scene::run::Vertex;
use crate::scene::{focus::Focus, outline, target::Target};

/// Strokes traversed in sequence at constant speed, with instantaneous jumps between them.
#[derive(Debug, Default)]
pub(super) struct Course {
    tracks: Vec<Track>,
    /// m from the beginning to the end of each track.
    ends: Vec<f64>,
    /// Points, and strokes without length, which are at rest.
    pub still: Vec<(usize, Focus)>,
}

impl Course {
    /// The course along the outlines of these targets, given with their indices in the scene.
    ///
    /// # Errors
    /// A glyph that the font lacks.
    pub fn new<'a>(targets: impl IntoIterator<Item = (usize, &'a Target)>) -> Result<Self, KeyError> {
        let mut course = Self::default();
        for (index, target) in targets {
            let strokes = tracks(target).map_err(|e| e.under(&["target".into(), index.into()]))?;
            for track in strokes {
                let length = track.length();
                if length > 0.0 {
                    course.ends.push(course.length() + length);
                    course.tracks.push(track);
                } else {
                    let Vertex { at, pressure } = track.at(0.0);
                    course.still.push((index, Focus::new(at, pressure)));
                }
            }
        }
        Ok(course)
    }

    /// m
    pub fn length(&self) -> f64 {
        self.ends.last().copied().unwrap_or(0.0)
    }

    /// Position and target pressure of a focus after a fraction of a repetition, in [0, 1).
    pub fn at(&self, part: f64) -> Focus {
        let distance = part * self.length();
        let index = self.ends.partition_point(|&end| end <= distance).min(self.tracks.len() - 1);
        let start = index.checked_sub(1).map_or(0.0, |before| self.ends[before]);
        let Vertex { at, pressure } = self.tracks[index].at(distance - start);
        Focus::new(at, pressure)
    }

    /// The point with the smallest z.
    pub fn lowest(&self, up: DVec3) -> Option<DVec3> {
        let places = self.tracks.iter().map(|track| track.lowest(up));
        places.min_by(|a, b| a.dot(up).total_cmp(&b.dot(up)))
    }
}

/// The strokes of a target as drawn, with the target pressures along them.
fn tracks(target: &Target) -> Result<Vec<Track>, KeyError> {
    if target.shape.is_picture() || target.shape.is_direction() {
        return Ok(Vec::new());
    }
    if let Some(radius) = target.shape.circle() {
        // The polygon that is drawn for it is not the circle.
        let [x, y] = [DVec3::X, DVec3::Y].map(|axis| target.turn() * axis);
        let centre = Vertex { at: target.shape.centre(), pressure: target.pressure };
        return Ok(vec![Track::Circle { centre, x: x * radius, y: y * radius }]);
    }
    let loud = |vertex: Vertex| Vertex { pressure: vertex.pressure * target.pressure, ..vertex };
    let track = |stroke: Vec<Vertex>| Track::through(stroke.into_iter().map(loud).collect());
    Ok(outline::drawn(target)?.into_iter().map(track).collect())
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

    use super::*;
    use crate::scene::motion::{Motion, MotionPath, Tempo};
    use crate::scene::{content::Scene, motion, shape::Shape};

    const AT: DVec3 = DVec3::new(0.01, 0.02, 0.1);

    /// Every kind of outline, one turned and tilted.
    fn targets() -> Vec<Target> {
        let vertices = vec![AT, AT + DVec3::X * 0.02, AT + DVec3::new(0.02, 0.03, 0.04)];
        let text = |text: &str| Shape::Text { text: text.to_owned(), at: AT, height: 0.04 };
        let shapes = [
            Shape::Line { from: AT, to: AT + DVec3::new(0.03, 0.01, 0.02) },
            Shape::Circle { at: AT, radius: 0.02 },
            Shape::Rectangle { at: AT, width: 0.03, height: 0.01 },
            Shape::Triangle { at: AT, size: 0.02 },
            Shape::Polygon { at: AT, radius: 0.02, sides: 5 },
            Shape::Path { vertices: vertices.clone(), closed: true },
            Shape::Path { vertices, closed: false },
            text("HIT"),
            text("S8"),
        ];
        let normal = DVec3::new(0.3, -0.2, 1.0);
        shapes.map(|shape| Target { angle: 0.4, normal, ..Target::new(shape) }).to_vec()
    }

    fn course(targets: &[Target]) -> Course {
        Course::new(targets.iter().enumerate()).unwrap()
    }

    /// m, from the strokes as they are drawn; of a circle from the circle.
    fn distance(target: &Target, at: DVec3) -> f64 {
        if let Shape::Circle { at: centre, radius } = target.shape {
            let normal = target.normal.normalize_or_zero();
            let height = (at - centre).dot(normal);
            let flat = at - centre - normal * height;
            return height.hypot(flat.length() - radius);
        }
        let to_piece = |pair: &[DVec3]| {
            let along = pair[1] - pair[0];
            let part = ((at - pair[0]).dot(along) / along.length_squared()).clamp(0.0, 1.0);
            at.distance(pair[0] + along * part)
        };
        let strokes = outline::strokes(target).unwrap();
        strokes.iter().flat_map(|stroke| stroke.windows(2)).map(to_piece).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn no_focus_is_off_the_strokes_and_none_lies_between_them() {
        for target in targets() {
            let course = course(std::slice::from_ref(&target));
            for i in 0..1000 {
                let focus = course.at(f64::from(i) / 1000.0);
                let off = distance(&target, focus.position);
                assert!(off < 1e-9 && focus.target == 1.0, "{:?}: {off}", target.shape);
            }
        }
        let all = targets();
        let course = course(&all);
        for i in 0..5000 {
            let at = course.at(f64::from(i) / 5000.0).position;
            assert!(all.iter().any(|target| distance(target, at) < 1e-9), "{i}");
        }
    }

    #[test]
    fn every_length_of_the_outline_takes_its_time() {
        const STEPS: u32 = 20_000;
        let all = targets();
        let course = course(&all);
        let at = |i: u32| course.at(f64::from(i) / f64::from(STEPS)).position;
        let step = course.length() / f64::from(STEPS);
        let uneven: Vec<_> = (0..STEPS)
            .map(|i| at(i).distance(at((i + 1) % STEPS)))
            .filter(|&d| (d / step - 1.0).abs() > 0.02)
            .collect();
        // Corners are cut short, and strokes end: some thirty of each.
        assert!(uneven.len() < 70, "{} uneven steps", uneven.len());
        // Of each target as many steps as its length has.
        for (index, target) in all.iter().enumerate() {
            let before: f64 = all[..index].iter().map(length).sum();
            for part in [1e-9, 0.5, 1.0 - 1e-9] {
                let at = course.at((before + part * length(target)) / course.length()).position;
                assert!(distance(target, at) < 1e-9, "{part} of {:?}", target.shape);
            }
        }
    }

    fn length(target: &Target) -> f64 {
        course(std::slice::from_ref(target)).length()
    }

    #[test]
    fn strokes_are_run_along_in_the_order_and_direction_in_which_they_are_drawn() {
        let h = Target::new(Shape::Text { text: "H".to_owned(), at: AT, height: 0.04 });
        let strokes = outline::strokes(&h).unwrap();
        let course = course(std::slice::from_ref(&h));
        let mut before = 0.0;
        for stroke in &strokes {
            let length: f64 = stroke.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
            let at = |distance: f64| course.at(distance / course.length()).position;
            let ends = [stroke[0], stroke[stroke.len() - 1]];
            assert!(at(before + 1e-9).distance(ends[0]) < 2e-9, "{ends:?}");
            assert!(at(before + length - 1e-9).distance(ends[1]) < 2e-9, "{ends:?}");
            before += length;
        }
        assert!((before - course.length()).abs() < 1e-12);
        assert!(course.at(0.0).position.distance(strokes[0][0]) < 1e-12);
    }

    #[test]
    fn foci_are_at_equal_distances_and_change_places_in_a_round() {
        let ring = Target::new(Shape::Circle { at: AT, radius: 0.02 });
        let tempo = Tempo::Rate(5.0);
        let motion = Motion { path: MotionPath::Outline, foci: 4, frames: 20, tempo, ..Motion::default() };
        let scene = Scene { targets: vec![ring], motion, ..Scene::default() };
        let frames = motion::frames(&scene).unwrap();
        assert_eq!(frames.len(), 20);
        for (i, frame) in frames.iter().enumerate() {
            assert_eq!(frame.len(), 4);
            for (j, focus) in frame.iter().enumerate() {
                let turn = DQuat::from_rotation_z(std::f64::consts::TAU * (i as f64 / 20.0 + j as f64 / 4.0));
                assert!(focus.position.distance(AT + turn * DVec3::X * 0.02) < 1e-12, "{i}, {j}");
                // Five frames later it is where the next one was, to the bit.
                assert_eq!(frames[(i + 5) % 20][j], frame[(j + 1) % 4]);
            }
        }
    }

    #[test]
    fn points_and_dots_stand_still_in_every_frame() {
        let point = Target { pressure: 2.0, ..Target::new(Shape::Point { at: AT }) };
        let text = Target::new(Shape::Text { text: "i".to_owned(), at: AT, height: 0.04 });
        let dot = outline::strokes(&text).unwrap()[1][0];
        let motion = Motion { path: MotionPath::Outline, ..Motion::default() };
        let scene = Scene { targets: vec![point, text], motion, ..Scene::default() };
        for frame in motion::frames(&scene).unwrap() {
            assert_eq!(frame.len(), 3);
            assert_eq!(frame[..2], [Focus::new(AT, 2.0), Focus::new(dot, 1.0)]);
        }
    }

    #[test]
    fn the_wanted_pressure_follows_the_stroke() {
        let vertices = vec![AT, AT + DVec3::X * 0.02, AT + DVec3::X * 0.06];
        let path = Shape::Path { vertices, closed: false };
        let target = Target { pressure: 2.0, pressures: vec![1.0, 0.5, 0.9], ..Target::new(path) };
        let course = course(&[target]);
        for (part, wanted) in [(0.0, 2.0), (1.0 / 6.0, 1.5), (1.0 / 3.0, 1.0), (2.0 / 3.0, 1.4)] {
            assert!((course.at(part).target - wanted).abs() < 1e-9, "{part}");
        }
    }

    #[test]
    fn the_lowest_place_of_a_circle_is_found_between_its_vertices() {
        let ring = Target { normal: DVec3::X, ..Target::new(Shape::Circle { at: AT, radius: 0.02 }) };
        let lowest = course(&[ring]).lowest(DVec3::Z).unwrap();
        assert!(lowest.distance(AT - DVec3::Z * 0.02) < 1e-12, "{lowest}");
    }
}
