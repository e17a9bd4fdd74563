//! Outlines cut at their corners into [`Run`]s, and runs divided evenly by arc length.

use std::collections::{HashMap, HashSet};

use glam::DVec3;

use crate::scene::range::{Key, KeyError};

/// Cosine of the angle beyond which a vertex is a corner: 30°. Segments of the stroke font's arcs turn by 6°.
const CORNER_COS: f64 = 0.866;

/// A point on an outline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Vertex {
    /// m
    pub at: DVec3,
    /// Target pressure relative to the target's.
    pub pressure: f64,
}

impl Vertex {
    /// Between two vertices, `part` of the way to the other.
    pub fn lerp(self, other: Self, part: f64) -> Self {
        let pressure = self.pressure + (other.pressure - self.pressure) * part;
        Self { at: self.at.lerp(other.at, part), pressure }
    }
}

/// A smooth part of an outline, between corners or a closed loop.
pub(crate) struct Run {
    vertices: Vec<Vertex>,
    /// m
    pub length: f64,
    /// A closed loop without corner.
    closed: bool,
}

impl Run {
    fn new(vertices: Vec<Vertex>, closed: bool) -> Self {
        let length = vertices.windows(2).map(|pair| pair[0].at.distance(pair[1].at)).sum();
        Self { vertices, length, closed }
    }

    /// Fewest pieces: three points make a ring.
    fn fewest(&self) -> usize {
        if self.closed { 3 } else { 1 }
    }

    /// Focal points besides the corners.
    fn interior(&self, pieces: usize) -> usize {
        if self.closed { pieces } else { pieces - 1 }
    }

    /// Fewest pieces of at most `spacing`.
    fn within(&self, spacing: f64) -> usize {
        ((self.length / spacing).ceil() as usize).max(1)
    }

    /// The point at a distance along the run.
    fn at(&self, distance: f64) -> Vertex {
        let mut left = distance;
        for pair in self.vertices.windows(2) {
            let length = pair[0].at.distance(pair[1].at);
            if left <= length {
                return pair[0].lerp(pair[1], if length > 0.0 { left / length } else { 0.0 });
            }
            left -= length;
        }
        self.vertices[self.vertices.len() - 1]
    }
}

/// Positions that round to the same key are the same corner: strokes meet at equal vertices.
fn key(vertex: Vertex) -> [i64; 3] {
    const QUANTUM: f64 = 1e-9;
    vertex.at.to_array().map(|x| (x / QUANTUM).round() as i64)
}

/// Cuts strokes at their corners.
pub(crate) fn runs(strokes: &[Vec<Vertex>]) -> Vec<Run> {
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

fn corner_keys(strokes: &[Vec<Vertex>]) -> HashSet<[i64; 3]> {
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

fn is_corner(before: Vertex, vertex: Vertex, after: Vertex) -> bool {
    let way = |from: Vertex, to: Vertex| (to.at - from.at).normalize_or_zero();
    let (arriving, leaving): (DVec3, DVec3) = (way(before, vertex), way(vertex, after));
    arriving.dot(leaving) < CORNER_COS
}

fn corners(runs: &[Run]) -> usize {
    let ends = |run: &Run| [key(run.vertices[0]), key(run.vertices[run.vertices.len() - 1])];
    runs.iter().filter(|run| !run.closed).flat_map(ends).collect::<HashSet<_>>().len()
}

/// Number of focal points of runs divided into these pieces; saturates for tiny spacings.
pub(crate) fn points_of(runs: &[Run], pieces: &[usize]) -> usize {
    corners(runs).saturating_add(interior(runs, pieces))
}

/// The number of points besides the corners.
fn interior(runs: &[Run], pieces: &[usize]) -> usize {
    runs.iter().zip(pieces).fold(0, |sum, (run, &pieces)| sum.saturating_add(run.interior(pieces)))
}

/// Whole numbers of pieces with lengths nearest to `spacing`.
pub(crate) fn pieces_by_spacing(runs: &[Run], spacing: f64) -> Vec<usize> {
    runs.iter().map(|run| ((run.length / spacing).round() as usize).max(run.fewest())).collect()
}

/// Fewest pieces of at most this length.
pub(crate) fn pieces_within(runs: &[Run], spacing: f64) -> Vec<usize> {
    runs.iter().map(|run| run.within(spacing)).collect()
}

/// Distributes `points` over the runs so that the longest piece is as short as possible.
///
/// # Errors
/// Fewer points than corners.
pub(crate) fn pieces_by_count(runs: &[Run], points: usize) -> Result<Vec<usize>, KeyError> {
    let mut pieces: Vec<_> = runs.iter().map(Run::fewest).collect();
    let fewest = corners(runs) + interior(runs, &pieces);
    let Some(spare) = points.checked_sub(fewest) else {
        return Err(refused(format!("too few: the outline's corners alone need {fewest}")));
    };
    for _ in 0..spare {
        let longest = |&i: &usize, &j: &usize| {
            let piece = |i: usize| runs[i].length / pieces[i] as f64;
            piece(i).total_cmp(&piece(j)).then(j.cmp(&i))
        };
        match (0..runs.len()).filter(|&i| runs[i].length > 0.0).max_by(longest) {
            Some(run) => pieces[run] += 1,
            None => return Err(refused("an outline without length cannot be divided")),
        }
    }
    Ok(pieces)
}

/// The ends of all pieces, every corner once.
pub(crate) fn divide(runs: &[Run], pieces: &[usize]) -> Vec<Vertex> {
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

fn refused(message: impl Into<String>) -> KeyError {
    KeyError::new([Key::from("points")], message)
}
