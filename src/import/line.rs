//! Polylines of a drawing: length, simplification, and proximity.

use glam::DVec2;

/// A polyline in the plane. Its unit is the drawing's.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// One at least; of a closed line the first is not repeated at the end.
    pub points: Vec<DVec2>,
    pub closed: bool,
    /// Its label or identifier in the drawing, or nothing.
    pub name: String,
    /// The label or identifier of the group or layer around it, or nothing.
    pub group: String,
}

impl Line {
    /// A line without a name.
    pub fn new(points: Vec<DVec2>, closed: bool) -> Self {
        Self { points, closed, name: String::new(), group: String::new() }
    }

    /// Other points with the same name and group.
    pub fn with(&self, points: Vec<DVec2>, closed: bool) -> Self {
        Self { points, closed, name: self.name.clone(), group: self.group.clone() }
    }

    pub fn length(&self) -> f64 {
        self.pieces().map(|[a, b]| a.distance(b)).sum()
    }

    /// The segments, including that from the last to the first point if closed.
    pub fn pieces(&self) -> impl Iterator<Item = [DVec2; 2]> {
        let closing = self.closed.then(|| [self.points[self.points.len() - 1], self.points[0]]);
        self.points.windows(2).map(|pair| [pair[0], pair[1]]).chain(closing)
    }

    pub fn distance(&self, at: DVec2) -> f64 {
        let to_first = self.points[0].distance(at);
        self.pieces().map(|piece| distance_to(piece, at)).fold(to_first, f64::min)
    }

    /// The line with fewer points, within `tolerance` of all omitted ones (Douglas and Peucker).
    pub fn simplified(&self, tolerance: f64) -> Self {
        let mut points = self.points.clone();
        if self.closed {
            // It is opened at the point farthest from its first, so that both halves have a length.
            let first = points[0];
            points.push(first);
        }
        let mut stays = vec![false; points.len()];
        let last = points.len() - 1;
        (stays[0], stays[last]) = (true, true);
        let mut parts = vec![(0, last)];
        while let Some((from, to)) = parts.pop() {
            let off = |&i: &usize| distance_to([points[from], points[to]], points[i]);
            let Some(farthest) = (from + 1..to).max_by(|a, b| off(a).total_cmp(&off(b))) else { continue };
            if off(&farthest) > tolerance {
                stays[farthest] = true;
                parts.extend([(from, farthest), (farthest, to)]);
            }
        }
        let mut kept: Vec<_> =
            points.iter().zip(&stays).filter(|(_, stays)| **stays).map(|(point, _)| *point).collect();
        if self.closed {
            kept.pop();
        }
        self.with(kept, self.closed)
    }

    /// The same line with at most `most` points, two at least.
    pub fn with_at_most(&self, most: usize, tolerance: f64) -> Self {
        let mut line = self.simplified(tolerance);
        let mut coarser = tolerance.max(1e-12 * line.length());
        while line.points.len() > most.max(2) {
            coarser *= 2.0;
            line = self.simplified(coarser);
        }
        line
    }

    /// An open line without this length at its beginning. `None` if nothing remains.
    pub fn without_beginning(&self, length: f64) -> Option<Self> {
        let mut left = length;
        for (i, pair) in self.points.windows(2).enumerate() {
            let piece = pair[0].distance(pair[1]);
            if left < piece {
                let mut points = vec![pair[0].lerp(pair[1], left / piece)];
                points.extend(&self.points[i + 1..]);
                return Some(self.with(points, false));
            }
            left -= piece;
        }
        None
    }

    /// The parts that remain if `kept` of each piece remains: ascending spans from 0 at its beginning to 1 at its end.
    pub fn parts(&self, mut kept: impl FnMut([DVec2; 2]) -> Vec<[f64; 2]>) -> Vec<Self> {
        if let [dot] = self.points[..] {
            return if kept([dot; 2]).is_empty() { Vec::new() } else { vec![self.clone()] };
        }
        let mut parts: Vec<Vec<DVec2>> = Vec::new();
        // Whether the first part begins with the line, and whether the last one ends where the next piece begins.
        let (mut begins, mut continues) = (false, false);
        for (i, [a, b]) in self.pieces().enumerate() {
            let mut end_in_piece = None;
            for [from, to] in kept([a, b]) {
                begins |= i == 0 && from == 0.0;
                match parts.last_mut() {
                    Some(part) if end_in_piece == Some(from) => {
                        part.pop();
                        part.push(a.lerp(b, to));
                    }
                    Some(part) if from == 0.0 && continues => part.push(a.lerp(b, to)),
                    Some(_) | None => parts.push(vec![a.lerp(b, from), a.lerp(b, to)]),
                }
                end_in_piece = Some(to);
            }
            continues = end_in_piece == Some(1.0);
        }
        let mut closed = false;
        if self.closed && begins && continues {
            closed = parts.len() == 1;
            match parts.pop() {
                Some(mut last) if closed => {
                    last.pop();
                    parts.push(last);
                }
                Some(mut last) => {
                    last.extend(&parts[0][1..]);
                    parts[0] = last;
                }
                None => {}
            }
        }
        parts.into_iter().map(|points| self.with(points, closed)).collect()
    }

    pub fn reversed(mut self) -> Self {
        self.points.reverse();
        self
    }
}

pub fn distance_to([a, b]: [DVec2; 2], at: DVec2) -> f64 {
    let along = b - a;
    let part = ((at - a).dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    at.distance(a + along * part)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(points: u32) -> Line {
        let at = |i: u32| DVec2::from_angle(std::f64::consts::TAU * f64::from(i) / f64::from(points));
        Line::new((0..points).map(at).collect(), true)
    }

    #[test]
    fn a_simpler_line_stays_near_and_keeps_its_corners() {
        let ring = ring(1000);
        let simple = ring.simplified(1e-3);
        assert!(simple.closed && (70..150).contains(&simple.points.len()), "{}", simple.points.len());
        assert!(ring.points.iter().all(|&point| simple.distance(point) <= 1e-3));
        assert!((simple.length() / ring.length() - 1.0).abs() < 2e-3);
        let corners = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 3.0)];
        let bent = Line::new(corners.map(DVec2::from).into(), false);
        assert_eq!(bent.simplified(1e-6).points, [(0.0, 0.0), (2.0, 0.0), (2.0, 3.0)].map(DVec2::from));
        assert!(ring.with_at_most(12, 1e-9).points.len() <= 12);
    }

    #[test]
    fn parts_of_a_closed_line_meet_over_its_beginning() {
        let square =
            Line::new([(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)].map(DVec2::from).into(), true);
        assert_eq!(square.parts(|_| vec![[0.0, 1.0]]), std::slice::from_ref(&square));
        assert_eq!(square.parts(|_| Vec::new()), []);
        let left_half = |[a, b]: [DVec2; 2]| match (a.x < 2.0, b.x < 2.0) {
            (true, true) => vec![[0.0, 0.25], [0.25, 1.0]],
            (true, false) => vec![[0.0, 0.5]],
            (false, true) => vec![[0.5, 1.0]],
            (false, false) => Vec::new(),
        };
        let [half] = &square.parts(left_half)[..] else { panic!("one part") };
        assert_eq!(half.points, [(2.0, 4.0), (0.0, 4.0), (0.0, 0.0), (2.0, 0.0)].map(DVec2::from));
        assert!(!half.closed);
    }

    #[test]
    fn a_line_is_cut_off_at_its_beginning() {
        let bent = Line::new([(0.0, 0.0), (2.0, 0.0), (2.0, 3.0)].map(DVec2::from).into(), false);
        assert_eq!(bent.length(), 5.0);
        let rest = bent.without_beginning(2.5).unwrap();
        assert_eq!(rest.points, [(2.0, 0.5), (2.0, 3.0)].map(DVec2::from));
        assert_eq!(bent.without_beginning(5.0), None);
    }
}
