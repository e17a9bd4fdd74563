//! The points of a lattice within a wavelength of an element, which do not count for the peak of a map.
//!
//! The far field of a piston or a point grows without limit towards its centre, so the largest value on a plane
//! through elements depends on how close a pixel happens to come to one.

use std::ops::Range;

use glam::DVec3;

use crate::acoustics::Aperture;
use crate::acoustics::element::NEAREST;
use crate::field::samples::Samples;

/// The half-balls of a wavelength in front of the elements and of their images in reflectors.
#[derive(Clone, Debug)]
pub struct Vicinity {
    /// Centre and direction of each.
    elements: Vec<(DVec3, DVec3)>,
    wavelength: f64,
}

/// The points of a lattice that do not count for its peak.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LeftOut {
    /// Ascending and disjoint; none if every point is near an element.
    runs: Vec<Range<usize>>,
    /// Number of points within a wavelength of an element.
    pub near: usize,
}

impl Vicinity {
    pub fn new(aperture: &Aperture) -> Self {
        let elements =
            aperture.faces.iter().flat_map(|face| {
                face.layout.positions.iter().enumerate().map(move |(n, at)| {
                    (face.pose.world(*at), face.pose.world_direction(face.layout.normal(n)))
                })
            });
        Self { elements: elements.collect(), wavelength: aperture.wavelength() }
    }

    /// The points of a lattice with columns at equal distances that are near an element, in front of it.
    pub fn of(&self, points: &Samples) -> LeftOut {
        let Samples { columns, rows } = points;
        let between = |points: &[DVec3]| match points {
            [first, .., last] => (*last - *first) / (points.len() - 1) as f64,
            [_] | [] => DVec3::ZERO,
        };
        let (across, up) = (between(columns), between(rows));
        let normal = across.cross(up).normalize_or_zero();
        let mut left_out = LeftOut::default();
        let (Some(&first), Some(&begin)) = (columns.first(), rows.first()) else { return left_out };
        let is_close = |(at, _): &&(DVec3, DVec3)| (*at - first - begin).dot(normal).abs() < self.wavelength;
        let elements: Vec<_> = self.elements.iter().filter(is_close).collect();
        let count = columns.len();
        let mut chords: Vec<Range<usize>> = Vec::new();
        for (row, &offset) in rows.iter().enumerate() {
            chords.clear();
            chords.extend(
                elements.iter().filter_map(|element| self.chord(element, first + offset, across, count)),
            );
            chords.sort_unstable_by_key(|chord| chord.start);
            let begun = left_out.runs.len();
            for chord in &chords {
                let chord = row * count + chord.start..row * count + chord.end;
                match left_out.runs[begun..].last_mut() {
                    Some(last) if chord.start <= last.end => last.end = last.end.max(chord.end),
                    Some(_) | None => left_out.runs.push(chord),
                }
            }
        }
        left_out.near = left_out.runs.iter().map(Range::len).sum();
        if left_out.near == points.len() {
            left_out.runs.clear();
        }
        left_out
    }

    /// The points `origin + i · across` near an element.
    fn chord(
        &self,
        (at, normal): &(DVec3, DVec3),
        origin: DVec3,
        across: DVec3,
        count: usize,
    ) -> Option<Range<usize>> {
        // Of a single point the direction does not matter.
        let (step, along) =
            if count == 1 { (1.0, DVec3::X) } else { (across.length(), across.normalize_or_zero()) };
        let from = origin - *at;
        let middle = -from.dot(along);
        let square = self.wavelength.powi(2) - (from.length_squared() - middle * middle);
        if square <= 0.0 {
            return None;
        }
        let half = square.sqrt();
        let (mut low, mut high) = (middle - half, middle + half);
        let (height, slope) = (from.dot(*normal) + NEAREST, along.dot(*normal));
        if slope.abs() > 1e-12 {
            let crossing = -height / slope;
            if slope > 0.0 { low = low.max(crossing) } else { high = high.min(crossing) }
        } else if height < 0.0 {
            return None;
        }
        let index = |place: f64| ((place / step).ceil().max(0.0) as usize).min(count);
        let chord = index(low)..index(high);
        (!chord.is_empty()).then_some(chord)
    }
}

impl LeftOut {
    pub fn is_empty(&self) -> bool {
        self.runs.is_empty()
    }

    pub fn contains(&self, point: usize) -> bool {
        let next = self.runs.partition_point(|run| run.end <= point);
        self.runs.get(next).is_some_and(|run| run.contains(&point))
    }

    /// Some of the points in runs that count or, with `true`, do not.
    pub fn split(&self, points: Range<usize>) -> impl Iterator<Item = (Range<usize>, bool)> {
        let begun = self.runs.partition_point(|run| run.end <= points.start);
        let mut at = points.start;
        let end = points.end;
        let inside = self.runs[begun..].iter().take_while(move |run| run.start < end);
        let both = inside
            .map(move |run| run.start.max(points.start)..run.end.min(end))
            .chain(std::iter::once(end..end));
        both.flat_map(move |run| {
            let before = at..run.start;
            at = run.end;
            [(before, false), (run, true)]
        })
        .filter(|(run, _)| !run.is_empty())
    }

    /// The largest magnitudes of values: of those that count, and of the others.
    pub fn largest(&self, values: &[f32]) -> [f32; 2] {
        let mut largest = [0.0f32; 2];
        for (run, is_near) in self.split(0..values.len()) {
            let own = values[run].iter().fold(0.0f32, |most, value| most.max(value.abs()));
            largest[usize::from(is_near)] = largest[usize::from(is_near)].max(own);
        }
        largest
    }

    /// A bit for each of some points, set if it does not count.
    #[cfg(feature = "gpu")]
    pub fn bits(&self, points: Range<usize>) -> Vec<u32> {
        let mut bits = vec![0; points.len().div_ceil(32)];
        for (run, is_near) in self.split(points.clone()) {
            for place in run.filter(|_| is_near) {
                let place = place - points.start;
                bits[place / 32] |= 1 << (place % 32);
            }
        }
        bits
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, dvec3};

    use super::*;
    use crate::scene::{Array, Board, Plane, Scene};

    fn planes() -> impl Iterator<Item = (Plane, (usize, usize))> {
        let level =
            Plane { centre: dvec3(0.002, 0.0, 0.004), size: DVec2::new(0.05, 0.03), ..Plane::default() };
        let through = Plane { centre: dvec3(0.0, 0.003, 0.005), y_axis: DVec3::Z, ..level.clone() };
        let tilted = Plane { x_axis: dvec3(0.6, 0.1, 0.5), y_axis: dvec3(-0.2, 1.0, 0.3), ..level.clone() };
        let backwards = Plane { x_axis: DVec3::NEG_Z, y_axis: DVec3::Y, ..level.clone() };
        let clear = Plane { centre: DVec3::Z * 0.05, ..level.clone() };
        let planes = [level, through, tilted, backwards, clear];
        planes.into_iter().flat_map(|plane| [(61, 47), (1, 40), (40, 1)].map(|size| (plane.clone(), size)))
    }

    #[test]
    fn near_points_are_those_of_an_exhaustive_search() {
        let tilt = Board { at: dvec3(0.03, 0.0, 0.02), normal: dvec3(-0.6, 0.0, 0.8), ..Board::default() };
        let array = Array { rows: 3, columns: 2, ..Array::default() };
        let scene = Scene { array, boards: vec![Board::default(), tilt], ..Scene::default() };
        let aperture = Aperture::new(&scene);
        let mut counts = Vec::new();
        for (plane, (width, height)) in planes() {
            let pixels = Samples::on_plane(&plane, width, height).unwrap();
            let left_out = Vicinity::new(&aperture).of(&pixels);
            let elements = || aperture.positions.iter().zip(&aperture.normals);
            let is_near = |point: DVec3| {
                elements().any(|(at, normal)| {
                    at.distance(point) < aperture.wavelength() && (point - at).dot(*normal) >= -NEAREST
                })
            };
            let expected: Vec<_> = (0..pixels.len()).map(|pixel| is_near(pixels.point(pixel))).collect();
            let near = expected.iter().filter(|near| **near).count();
            assert_eq!(left_out.near, near, "{plane:?}");
            let is_whole = near == pixels.len();
            for (pixel, near) in expected.iter().enumerate() {
                assert_eq!(left_out.contains(pixel), *near && !is_whole, "{plane:?}: {pixel}");
            }
            counts.push(near as f64 / pixels.len() as f64);
        }
        assert!(counts.contains(&0.0) && counts.iter().any(|part| (0.1..0.9).contains(part)), "{counts:?}");
    }

    #[test]
    fn runs_bits_and_maxima_tell_the_same_points() {
        let left_out = LeftOut { runs: vec![3..5, 30..70, 98..100], near: 44 };
        let is_out = |point: usize| left_out.runs.iter().any(|run| run.contains(&point));
        for points in [0..100, 4..99, 31..60, 70..98, 5..5] {
            let mut next = points.start;
            for (run, is_near) in left_out.split(points.clone()) {
                assert_eq!(run.start, next);
                assert!(run.clone().all(|point| is_out(point) == is_near), "{run:?}");
                next = run.end;
            }
            assert_eq!(next, points.end);
            let bits = left_out.bits(points.clone());
            for point in points.clone() {
                let place = point - points.start;
                assert_eq!(bits[place / 32] >> (place % 32) & 1 == 1, is_out(point), "{point} of {points:?}");
            }
        }
        let values: Vec<_> = (0..100).map(|i| if i % 2 == 0 { i as f32 } else { -(i as f32) }).collect();
        assert_eq!(left_out.largest(&values), [97.0, 99.0]);
        assert_eq!(LeftOut::default().largest(&values), [99.0, 0.0]);
    }
}
