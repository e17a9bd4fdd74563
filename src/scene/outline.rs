//! From shapes and letters to focal points, evenly along the outline, corners included.
//!
//! An outline is a set of strokes. Strokes are cut at their corners (ends, sharp turns, and places where strokes meet)
//! into [`Run`]s; every corner becomes one focal point, and the inside of a run is divided evenly by arc length.

use std::collections::{HashMap, HashSet};
use std::f64::consts::TAU;

use glam::{DQuat, DVec2, DVec3};

use crate::scene::check::{Key, KeyError, MOST_FOCI};
use crate::scene::{Focus, Sampling, Scene, Shape, Target, font};

/// cos of the turn beyond which a vertex is a corner: 30°. One piece of a stroke font's arc turns by 6°.
const CORNER_COS: f64 = 0.866;
/// Vertices of a circle that is drawn rather than sampled.
const CIRCLE_VERTICES: usize = 96;

/// The focal points of the scene at rest, target by target in the order of the file; of its first step, if it has several.
///
/// # Errors
/// No targets or only hidden ones, a glyph that the font lacks, more focal points than [`MOST_FOCI`], fewer points than corners, or a
/// focal point on or behind the array.
pub fn foci(scene: &Scene) -> Result<Vec<Focus>, KeyError> {
    foci_of_step(scene, 0)
}

/// The focal points of one step of the motion.
///
/// # Errors
/// As [`foci`].
pub fn foci_of_step(scene: &Scene, step: u32) -> Result<Vec<Focus>, KeyError> {
    if scene.targets.is_empty() {
        return Err(KeyError::new([Key::from("target")], "the scene has no target: nothing to focus on"));
    }
    if scene.targets.iter().all(|target| !target.visible) {
        let message = "every target is hidden: nothing to focus on";
        return Err(KeyError::new([Key::from("target"), Key::from(0), Key::from("visible")], message));
    }
    let mut foci = Vec::new();
    for (index, target) in scene.targets.iter().enumerate().filter(|(_, target)| target.is_in(step)) {
        let refuse = |error: KeyError| error.under(&[Key::from("target"), Key::from(index)]);
        let points = points(target, MOST_FOCI - foci.len()).map_err(refuse)?;
        if let Some(point) = points.iter().find(|point| point.z <= 0.0) {
            let [x, y, z] = point.to_array();
            let message = format!(
                "the focal point ({x}, {y}, {z}) lies on or behind the array, which stands in z = 0 and radiates \
                 towards +z"
            );
            return Err(refuse(KeyError::new([], message)));
        }
        foci.extend(points.into_iter().map(|position| Focus { position, target: target.pressure }));
    }
    if foci.is_empty() {
        let message = format!("no target is shown in step {step}: nothing to focus on");
        return Err(KeyError::new([Key::from("target")], message));
    }
    Ok(foci)
}

/// The polylines of a target, as drawn.
///
/// # Errors
/// A glyph that the font lacks.
pub fn strokes(target: &Target) -> Result<Vec<Vec<DVec3>>, KeyError> {
    let centre = centre(&target.shape);
    let facing = DQuat::from_rotation_arc(DVec3::Z, target.normal.try_normalize().unwrap_or(DVec3::Z));
    let placed = |vertex: &DVec2| centre + facing * DQuat::from_rotation_z(target.angle) * vertex.extend(0.0);
    let flat = |outline: Vec<DVec2>| vec![outline.iter().map(placed).collect()];
    let turned = |vertex: &DVec3| centre + DQuat::from_rotation_z(target.angle) * (*vertex - centre);
    Ok(match &target.shape {
        Shape::Point { at } => vec![vec![*at]],
        Shape::Line { from, to } => vec![[*from, *to].iter().map(turned).collect()],
        Shape::Path { vertices, closed } => {
            let mut vertices: Vec<_> = vertices.iter().map(turned).collect();
            vertices.dedup();
            if *closed && vertices.first() != vertices.last() {
                vertices.push(vertices[0]);
            }
            vec![vertices]
        }
        Shape::Circle { radius, .. } => flat(ring(*radius, CIRCLE_VERTICES, 0.0)),
        Shape::Rectangle { width, height, .. } => {
            let (x, y) = (width / 2.0, height / 2.0);
            flat([(-x, -y), (x, -y), (x, y), (-x, y), (-x, -y)].map(DVec2::from).to_vec())
        }
        Shape::Triangle { size, .. } => flat(ring(size / 3.0_f64.sqrt(), 3, TAU / 4.0)),
        Shape::Polygon { radius, sides, .. } => flat(ring(*radius, *sides as usize, TAU / 4.0)),
        Shape::Text { text, height, .. } => font::lay_out(text, *height)
            .map_err(|glyph| {
                refusal("text", format!("the stroke font has no glyph for `{}`", glyph.escape_debug()))
            })?
            .iter()
            .map(|stroke| stroke.iter().map(placed).collect())
            .collect(),
    })
}

/// The point about which a target turns.
pub fn centre(shape: &Shape) -> DVec3 {
    match shape {
        Shape::Point { at }
        | Shape::Circle { at, .. }
        | Shape::Rectangle { at, .. }
        | Shape::Triangle { at, .. }
        | Shape::Polygon { at, .. }
        | Shape::Text { at, .. } => *at,
        Shape::Line { from, to } => (*from + *to) / 2.0,
        Shape::Path { vertices, .. } => vertices.iter().sum::<DVec3>() / vertices.len().max(1) as f64,
    }
}

/// A closed regular polygon about the origin, first vertex at `start`.
fn ring(radius: f64, vertices: usize, start: f64) -> Vec<DVec2> {
    let vertex = |i: usize| DVec2::from_angle(start + TAU * (i % vertices) as f64 / vertices as f64) * radius;
    (0..=vertices).map(vertex).collect()
}

/// How many focal points targets ask for together, without making them.
///
/// # Errors
/// More than [`MOST_FOCI`], a glyph that the font lacks, or fewer points than corners.
pub fn count(targets: &[Target]) -> Result<usize, KeyError> {
    let mut count = 0;
    for (index, target) in targets.iter().enumerate().filter(|(_, target)| target.visible) {
        let (runs, pieces) =
            divided(target, MOST_FOCI - count).map_err(|e| e.under(&["target".into(), index.into()]))?;
        count += wanted(&runs, &pieces);
    }
    Ok(count)
}

fn points(target: &Target, most: usize) -> Result<Vec<DVec3>, KeyError> {
    let (runs, pieces) = divided(target, most)?;
    // A circle is no polygon: its points are computed, not taken from the one that is drawn.
    if let (Shape::Circle { at, radius }, [pieces]) = (&target.shape, &pieces[..]) {
        let facing = DQuat::from_rotation_arc(DVec3::Z, target.normal.try_normalize().unwrap_or(DVec3::Z));
        let place = |i| {
            *at + facing
                * (DVec2::from_angle(target.angle + TAU * i as f64 / *pieces as f64) * *radius).extend(0.0)
        };
        return Ok((0..*pieces).map(place).collect());
    }
    Ok(divide(&runs, &pieces))
}

/// The runs of a target, and into how many pieces each is divided.
fn divided(target: &Target, most: usize) -> Result<(Vec<Run>, Vec<usize>), KeyError> {
    let runs = runs(&strokes(target)?);
    let pieces = match target.sampling {
        Sampling::Whole => vec![1; runs.len()],
        Sampling::Spacing(spacing) => pieces_by_spacing(&runs, spacing),
        // What is too much is refused before it is shared out.
        Sampling::Points(points) if points > most => return Err(too_many("points", points)),
        Sampling::Points(points) => pieces_by_count(&runs, points)?,
    };
    let wanted = wanted(&runs, &pieces);
    if wanted > most {
        let key = if matches!(target.sampling, Sampling::Spacing(_)) { "spacing" } else { "points" };
        return Err(too_many(key, wanted));
    }
    Ok((runs, pieces))
}

/// Focal points of runs that are divided into so many pieces; a spacing of next to nothing asks for more than can be counted.
fn wanted(runs: &[Run], pieces: &[usize]) -> usize {
    corners(runs).saturating_add(interior(runs, pieces))
}

fn too_many(key: &'static str, wanted: usize) -> KeyError {
    refusal(key, format!("{wanted} focal points are asked for, and a scene may have {MOST_FOCI}"))
}

fn refusal(key: &'static str, message: impl Into<String>) -> KeyError {
    KeyError::new([Key::from(key)], message)
}

/// A smooth part of an outline, from corner to corner or once round.
struct Run {
    vertices: Vec<DVec3>,
    length: f64,
    /// It closes on itself with no corner.
    closed: bool,
}

impl Run {
    fn new(vertices: Vec<DVec3>, closed: bool) -> Self {
        let length = vertices.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
        Self { vertices, length, closed }
    }

    /// Fewest pieces into which it can be divided: three points make a ring.
    fn fewest(&self) -> usize {
        if self.closed { 3 } else { 1 }
    }

    /// Focal points besides the corners.
    fn interior(&self, pieces: usize) -> usize {
        if self.closed { pieces } else { pieces - 1 }
    }

    /// The point at a distance along the run.
    fn at(&self, distance: f64) -> DVec3 {
        let mut left = distance;
        for pair in self.vertices.windows(2) {
            let length = pair[0].distance(pair[1]);
            if left <= length {
                return pair[0].lerp(pair[1], if length > 0.0 { left / length } else { 0.0 });
            }
            left -= length;
        }
        self.vertices[self.vertices.len() - 1]
    }
}

/// Positions that are written the same are the same corner: strokes meet at equal vertices.
fn key(vertex: DVec3) -> [i64; 3] {
    const QUANTUM: f64 = 1e-9;
    vertex.to_array().map(|x| (x / QUANTUM).round() as i64)
}

/// Cuts strokes at their corners.
fn runs(strokes: &[Vec<DVec3>]) -> Vec<Run> {
    let corners = corner_keys(strokes);
    let mut runs = Vec::new();
    for stroke in strokes {
        let closed = stroke.len() > 2 && key(stroke[0]) == key(stroke[stroke.len() - 1]);
        let first = stroke.iter().position(|vertex| corners.contains(&key(*vertex)));
        match first {
            None => runs.push(Run::new(stroke.clone(), closed)),
            Some(first) => {
                let mut stroke = stroke.clone();
                if closed {
                    stroke.pop();
                    stroke.rotate_left(first);
                    stroke.push(stroke[0]);
                }
                let mut run = vec![stroke[0]];
                for &vertex in &stroke[1..] {
                    run.push(vertex);
                    if corners.contains(&key(vertex)) {
                        runs.push(Run::new(std::mem::replace(&mut run, vec![vertex]), false));
                    }
                }
                if stroke.len() == 1 {
                    runs.push(Run::new(run, false));
                }
            }
        }
    }
    runs
}

fn corner_keys(strokes: &[Vec<DVec3>]) -> HashSet<[i64; 3]> {
    let mut corners = HashSet::new();
    let mut stroke_of = HashMap::new();
    for (index, stroke) in strokes.iter().enumerate() {
        let (first, last) = (stroke[0], stroke[stroke.len() - 1]);
        let closed = stroke.len() > 2 && key(first) == key(last);
        if !closed {
            corners.extend([key(first), key(last)]);
        } else if is_corner(stroke[stroke.len() - 2], first, stroke[1]) {
            corners.insert(key(first));
        }
        for triple in stroke.windows(3) {
            if is_corner(triple[0], triple[1], triple[2]) {
                corners.insert(key(triple[1]));
            }
        }
        for vertex in stroke {
            if *stroke_of.entry(key(*vertex)).or_insert(index) != index {
                corners.insert(key(*vertex));
            }
        }
    }
    corners
}

fn is_corner(before: DVec3, at: DVec3, after: DVec3) -> bool {
    let (arriving, leaving) = ((at - before).normalize_or_zero(), (after - at).normalize_or_zero());
    arriving.dot(leaving) < CORNER_COS
}

fn corners(runs: &[Run]) -> usize {
    let ends = |run: &Run| [key(run.vertices[0]), key(run.vertices[run.vertices.len() - 1])];
    runs.iter().filter(|run| !run.closed).flat_map(ends).collect::<HashSet<_>>().len()
}

fn interior(runs: &[Run], pieces: &[usize]) -> usize {
    runs.iter().zip(pieces).fold(0, |sum, (run, &pieces)| sum.saturating_add(run.interior(pieces)))
}

fn pieces_by_spacing(runs: &[Run], spacing: f64) -> Vec<usize> {
    runs.iter().map(|run| ((run.length / spacing).round() as usize).max(run.fewest())).collect()
}

/// Shares `points` out among the runs so that the longest piece is as short as can be.
fn pieces_by_count(runs: &[Run], points: usize) -> Result<Vec<usize>, KeyError> {
    let mut pieces: Vec<_> = runs.iter().map(Run::fewest).collect();
    let fewest = corners(runs) + interior(runs, &pieces);
    let Some(spare) = points.checked_sub(fewest) else {
        return Err(refusal("points", format!("too few: the outline's corners alone need {fewest}")));
    };
    for _ in 0..spare {
        let longest = |&i: &usize, &j: &usize| {
            let piece = |i: usize| runs[i].length / pieces[i] as f64;
            piece(i).total_cmp(&piece(j)).then(j.cmp(&i))
        };
        match (0..runs.len()).filter(|&i| runs[i].length > 0.0).max_by(longest) {
            Some(run) => pieces[run] += 1,
            None => return Err(refusal("points", "an outline without length cannot be divided")),
        }
    }
    Ok(pieces)
}

fn divide(runs: &[Run], pieces: &[usize]) -> Vec<DVec3> {
    let mut seen = HashSet::new();
    let mut points = Vec::new();
    for (run, &pieces) in runs.iter().zip(pieces) {
        let steps = if run.closed { 0..pieces } else { 0..pieces + 1 };
        for step in steps {
            let point = run.at(run.length * step as f64 / pieces as f64);
            let is_end = !run.closed && (step == 0 || step == pieces);
            if !is_end || seen.insert(key(point)) {
                points.push(point);
            }
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use glam::dvec2;

    use super::*;

    fn sampled(shape: Shape, sampling: Sampling) -> Vec<DVec3> {
        points(&Target { sampling, ..Target::new(shape) }, MOST_FOCI).unwrap()
    }

    const AT: DVec3 = DVec3::new(0.01, 0.02, 0.1);

    #[test]
    fn a_rectangle_has_its_corners_and_even_sides() {
        let points = sampled(Shape::Rectangle { at: AT, width: 0.04, height: 0.02 }, Sampling::Spacing(0.01));
        assert_eq!(points.len(), 12);
        for corner in [(-0.02, -0.01), (0.02, -0.01), (0.02, 0.01), (-0.02, 0.01)] {
            let corner = AT + dvec2(corner.0, corner.1).extend(0.0);
            assert!(points.iter().any(|p| p.distance(corner) < 1e-12), "{corner}");
        }
        for pair in points.windows(2) {
            assert!((pair[0].distance(pair[1]) - 0.01).abs() < 1e-12);
        }
    }

    #[test]
    fn a_count_is_met_exactly() {
        for shape in [
            Shape::Circle { at: AT, radius: 0.02 },
            Shape::Rectangle { at: AT, width: 0.04, height: 0.025 },
            Shape::Triangle { at: AT, size: 0.04 },
            Shape::Polygon { at: AT, radius: 0.03, sides: 7 },
            Shape::Line { from: AT, to: AT + DVec3::X },
            Shape::Path { vertices: vec![AT, AT + DVec3::X, AT + DVec3::Y], closed: true },
            Shape::Text { text: "HIT".to_owned(), at: AT, height: 0.04 },
            Shape::Text { text: "Océ α8".to_owned(), at: AT, height: 0.04 },
        ] {
            for count in [80, 97, 211] {
                assert_eq!(sampled(shape.clone(), Sampling::Points(count)).len(), count, "{shape:?}");
            }
        }
    }

    #[test]
    fn circle_points_lie_on_the_circle_from_its_angle_on() {
        let target = Target {
            angle: 0.3,
            sampling: Sampling::Points(11),
            ..Target::new(Shape::Circle { at: AT, radius: 0.02 })
        };
        let points = points(&target, MOST_FOCI).unwrap();
        for (i, point) in points.iter().enumerate() {
            let (sin, cos) = (0.3 + TAU * i as f64 / 11.0).sin_cos();
            assert!(point.distance(AT + 0.02 * DVec3::new(cos, sin, 0.0)) < 1e-12);
        }
    }

    #[test]
    fn letters_share_the_points_where_strokes_meet() {
        let points =
            sampled(Shape::Text { text: "H".to_owned(), at: AT, height: 0.04 }, Sampling::Spacing(0.02));
        assert_eq!(points.len(), 6, "four ends and two joints: {points:?}");
        for (i, a) in points.iter().enumerate() {
            for b in &points[..i] {
                assert!(a.distance(*b) > 1e-3);
            }
        }
    }

    #[test]
    fn a_normal_turns_the_shape_out_of_the_plane() {
        let mut target = Target::new(Shape::Circle { at: AT, radius: 0.02 });
        target.normal = DVec3::new(0.0, 3.0, 3.0);
        for point in points(&target, MOST_FOCI).unwrap() {
            assert!((point - AT).dot(target.normal).abs() < 1e-12);
            assert!((point.distance(AT) - 0.02).abs() < 1e-12);
        }
    }

    #[test]
    fn an_angle_turns_lines_and_text_about_their_centre() {
        let mut target = Target::new(Shape::Line { from: AT, to: AT + 0.02 * DVec3::X });
        target.angle = TAU / 4.0;
        let points = points(&target, MOST_FOCI).unwrap();
        assert!(points.iter().all(|p| (p.x - AT.x - 0.01).abs() < 1e-12), "{points:?}");
    }

    #[test]
    fn too_many_points_are_refused_before_they_are_made() {
        let target = Target {
            sampling: Sampling::Spacing(1e-9),
            ..Target::new(Shape::Line { from: AT, to: AT + DVec3::X })
        };
        assert!(points(&target, MOST_FOCI).unwrap_err().message.contains("1000000001 focal points"));
        // More than can be counted.
        let target = Target { sampling: Sampling::Spacing(1e-300), ..target };
        assert!(points(&target, MOST_FOCI).unwrap_err().message.contains("focal points are asked for"));
        assert!(count(&[target]).is_err());
    }

    #[test]
    fn hidden_targets_ask_for_nothing() {
        let mut scene = Scene { targets: vec![Target::new(Shape::Point { at: AT }); 2], ..Scene::default() };
        scene.targets[1].visible = false;
        assert_eq!(foci(&scene).unwrap().len(), 1);
        assert_eq!(count(&scene.targets).unwrap(), 1);
        scene.targets[0].visible = false;
        assert!(foci(&scene).unwrap_err().message.contains("every target is hidden"));
    }

    #[test]
    fn fewer_points_than_corners_are_refused() {
        let target = Target {
            sampling: Sampling::Points(3),
            ..Target::new(Shape::Rectangle { at: AT, width: 0.04, height: 0.02 })
        };
        assert!(points(&target, MOST_FOCI).unwrap_err().message.contains("need 4"));
    }
}
