//! Lines that touch, joined: a circle of many segments is one closed line.

use std::collections::HashMap;

use glam::DVec2;

use crate::import::Line;

/// Ends go on in each other at a place of many only if they turn by less than this: its cosine.
const STRAIGHT: f64 = 0.8;

/// A line of a drawing with its paint.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    pub line: Line,
    /// Red, green, blue and opacity; lines of different paint are not joined.
    pub ink: [u8; 4],
    /// Whether a part of it is hidden: its ends are known within pixels only.
    pub is_cut: bool,
}

/// The traces with ends joined that are at most `near` apart, and then those of cut ones at most `near_cut`.
pub fn joined(traces: Vec<Trace>, near: f64, near_cut: f64) -> Vec<Trace> {
    let traces = pass(traces, near, false);
    let (cut, whole): (Vec<_>, Vec<_>) = traces.into_iter().partition(|trace| trace.is_cut);
    whole.into_iter().chain(pass(cut, near_cut, true)).collect()
}

/// An end of a trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
struct End {
    trace: usize,
    is_last: bool,
}

impl End {
    fn at(self, traces: &[Trace]) -> DVec2 {
        let points = &traces[self.trace].line.points;
        points[if self.is_last { points.len() - 1 } else { 0 }]
    }

    /// The direction in which the line leaves beyond this end.
    fn outwards(self, traces: &[Trace]) -> DVec2 {
        let points = &traces[self.trace].line.points;
        let before = if self.is_last { points[points.len() - 2] } else { points[1] };
        (self.at(traces) - before).normalize_or_zero()
    }

    fn other(self) -> Self {
        Self { is_last: !self.is_last, ..self }
    }
}

fn pass(traces: Vec<Trace>, near: f64, meets: bool) -> Vec<Trace> {
    let is_open = |trace: &Trace| !trace.line.closed && trace.line.points.len() > 1;
    let (mut traces, mut done): (Vec<_>, Vec<_>) = traces.into_iter().partition(is_open);
    let links = links(&traces, near);
    let mut is_used = vec![false; traces.len()];
    let ends = (0..traces.len()).map(|trace| End { trace, is_last: false });
    let ends: Vec<_> = ends.flat_map(|end| [end, end.other()]).collect();
    // Chains begin at an end without a link; what then remains are rings.
    let firsts = ends.iter().filter(|end| !links.contains_key(end));
    for &first in firsts.chain(&ends) {
        if is_used[first.trace] {
            continue;
        }
        let mut chain = vec![first];
        is_used[first.trace] = true;
        let mut last = first.other();
        while let Some(&next) = links.get(&last) {
            if is_used[next.trace] {
                break;
            }
            is_used[next.trace] = true;
            chain.push(next);
            last = next.other();
        }
        let is_ring = links.get(&last) == Some(&first);
        done.push(whole(&mut traces, &chain, is_ring, near, meets));
    }
    done
}

/// Pairs of ends, both ways.
fn links(traces: &[Trace], near: f64) -> HashMap<End, End> {
    let cell = |at: DVec2| (at / near.max(f64::MIN_POSITIVE)).floor().as_i64vec2().to_array();
    let mut cells: HashMap<[i64; 2], Vec<End>> = HashMap::new();
    let ends = (0..traces.len()).flat_map(|trace| [false, true].map(|is_last| End { trace, is_last }));
    let ends: Vec<_> = ends.collect();
    for &end in &ends {
        cells.entry(cell(end.at(traces))).or_default().push(end);
    }
    let mut pairs = Vec::new();
    for &end in &ends {
        let at = end.at(traces);
        let [x, y] = cell(at);
        let around = (-1..=1).flat_map(|i| (-1..=1).map(move |j| [x.saturating_add(i), y.saturating_add(j)]));
        let others = around.filter_map(|cell| cells.get(&cell)).flatten().copied();
        let fits = |other: &End| {
            *other != end
                && other.at(traces).distance(at) <= near
                && traces[other.trace].ink == traces[end.trace].ink
                && traces[other.trace].line.group == traces[end.trace].line.group
                && (other.trace != end.trace || traces[end.trace].line.length() > 4.0 * near)
        };
        let others: Vec<_> = others.filter(fits).collect();
        let outwards = end.outwards(traces);
        for &other in others.iter().filter(|other| **other > end) {
            let straight = -outwards.dot(other.outwards(traces));
            if others.len() == 1 || straight > STRAIGHT {
                pairs.push((straight, end, other));
            }
        }
    }
    pairs.sort_by(|a, b| b.0.total_cmp(&a.0).then_with(|| (a.1, a.2).cmp(&(b.1, b.2))));
    let mut links = HashMap::new();
    for (_, a, b) in pairs {
        if !links.contains_key(&a) && !links.contains_key(&b) {
            links.insert(a, b);
            links.insert(b, a);
        }
    }
    links
}

/// One trace of a chain of traces, each given by its first end.
fn whole(traces: &mut [Trace], chain: &[End], is_ring: bool, near: f64, meets: bool) -> Trace {
    let mut points: Vec<DVec2> = Vec::new();
    for end in chain {
        let mut own = std::mem::take(&mut traces[end.trace].line.points);
        if end.is_last {
            own.reverse();
        }
        match points.last() {
            Some(&last) => match crossing(&points, &own, near).filter(|_| meets) {
                Some(corner) => {
                    points.pop();
                    points.push(corner);
                    points.extend(&own[1..]);
                }
                None => points.extend(&own[usize::from(last.distance(own[0]) <= near && !meets)..]),
            },
            None => points = own,
        }
    }
    if is_ring && points.len() > 2 {
        match crossing(&points, &points[..2], near).filter(|_| meets) {
            Some(corner) => {
                points.pop();
                points[0] = corner;
            }
            None if points[0].distance(points[points.len() - 1]) <= near && !meets => {
                points.pop();
            }
            None => {}
        }
    }
    points.dedup();
    let first = &traces[chain[0].trace];
    let closed = is_ring && points.len() > 2;
    let is_cut = chain.iter().any(|end| traces[end.trace].is_cut);
    Trace { line: first.line.with(points, closed), ink: first.ink, is_cut }
}

/// Where the end of one polyline and the beginning of another would meet, if that is near both.
fn crossing(points: &[DVec2], next: &[DVec2], near: f64) -> Option<DVec2> {
    let [.., before, a] = points else { return None };
    let [b, after, ..] = next else { return None };
    let (along, back) = (*a - *before, *after - *b);
    let turn = along.perp_dot(back);
    if turn.abs() < 0.2 * along.length() * back.length() {
        return None;
    }
    let at = *before + along * ((*b - *before).perp_dot(back) / turn);
    let is_ahead = (at - *before).dot(along) > 0.0 && (*after - at).dot(back) > 0.0;
    let is_near = at.distance(*a) <= 2.0 * near && at.distance(*b) <= 2.0 * near;
    (is_ahead && is_near).then_some(at)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    fn trace(points: &[DVec2]) -> Trace {
        Trace { line: Line::new(points.to_vec(), false), ink: [0; 4], is_cut: false }
    }

    #[test]
    fn segments_of_a_circle_become_one_ring() {
        let at = |i: usize| DVec2::from_angle(TAU * (i % 600) as f64 / 600.0);
        // In any order and direction.
        let segment = |i: usize| {
            let i = (i * 7) % 600;
            trace(&if i.is_multiple_of(3) { [at(i + 1), at(i)] } else { [at(i), at(i + 1)] })
        };
        let [ring] = &joined((0..600).map(segment).collect(), 1e-3, 1e-2)[..] else { panic!("one line") };
        assert!(ring.line.closed);
        assert_eq!(ring.line.points.len(), 600);
        assert!((ring.line.length() / TAU - 1.0).abs() < 1e-4);
    }

    #[test]
    fn lines_of_a_crossing_go_straight_on() {
        let arm = |x: f64, y: f64| trace(&[DVec2::ZERO, DVec2::new(x, y)]);
        let lines = joined(vec![arm(1.0, 0.0), arm(0.0, 1.0), arm(-1.0, 0.0), arm(0.0, -1.0)], 1e-6, 1e-6);
        assert_eq!(lines.len(), 2);
        assert!(lines.iter().all(|trace| (trace.line.points[0] + trace.line.points[2]).length() < 1e-9));
        let red = Trace { ink: [255, 0, 0, 255], ..arm(-1.0, 0.0) };
        assert_eq!(joined(vec![arm(1.0, 0.0), red], 1e-6, 1e-6).len(), 2, "of other paint");
    }
}
