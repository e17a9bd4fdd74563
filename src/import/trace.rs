//! From lines of one pixel to polylines: chains between ends and junctions, joined where they continue straight.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec2;

use crate::import::ink::Ink;
use crate::import::{ImportError, Line};

/// A corner turns by at least 57°, between sides of this many pixels.
const CORNER_COS: f64 = 0.545;
const SIDE: f64 = 8.0;
/// Longest cut of a corner, of the stroke's width.
const CUT: f64 = 1.5;
/// Smoothing width in pixels between corners.
const SMOOTHING: usize = 4;
/// Chains of a picture: more are no drawing but a texture.
const MOST_CHAINS: usize = 8000;
/// Chains that turn by less than 60° at their junction are one line.
const STRAIGHT_COS: f64 = -0.5;

/// Pixels between nodes; a node is the end of a chain, or a junction of more than two.
#[derive(Clone, Debug)]
struct Chain {
    points: Vec<DVec2>,
    /// Both ends; the same for a closed chain.
    ends: [usize; 2],
}

/// The lines of thinned strokes that were `width` pixels wide, y downwards.
pub fn lines(ink: &Ink, width: f64) -> Result<Vec<Line>, ImportError> {
    let mut chains = chains(ink);
    if chains.len() > MOST_CHAINS {
        return Err(ImportError::TooManyLines(chains.len()));
    }
    join_nodes(&mut chains, width);
    prune(&mut chains, width);
    let lines = joined(chains, width);
    Ok(lines.into_iter().filter(|line| line.points.len() > 1).map(|line| smooth(&line, width)).collect())
}

/// Dark neighbours; of two paths to the same pixel only the straight one.
fn next(ink: &Ink, index: usize) -> impl Iterator<Item = usize> {
    let around = ink.neighbours(index);
    let dark = around.map(|neighbour| ink.is_dark(neighbour));
    (0..8)
        .filter(move |&i| dark[i] && (i % 2 == 0 || !(dark[(i + 7) % 8] || dark[(i + 1) % 8])))
        .map(move |i| around[i])
}

fn chains(ink: &Ink) -> Vec<Chain> {
    let is_node = |index: usize| next(ink, index).count() != 2;
    let mut gone = vec![false; ink.pixels()];
    let mut chains = Vec::new();
    for start in ink.dark().filter(|&index| is_node(index)) {
        for first in next(ink, start) {
            // Adjacent nodes are found from both sides.
            if gone[first] || (is_node(first) && first < start) {
                continue;
            }
            chains.push(follow(ink, start, first, &is_node, &mut gone));
        }
    }
    for start in ink.dark() {
        if !gone[start] && !is_node(start) {
            gone[start] = true;
            if let Some(first) = next(ink, start).next() {
                let is_start = |index: usize| index == start;
                chains.push(follow(ink, start, first, &is_start, &mut gone));
            }
        }
    }
    chains
}

/// The chain that begins with these two pixels and ends at a node.
fn follow(
    ink: &Ink,
    start: usize,
    first: usize,
    is_node: &dyn Fn(usize) -> bool,
    gone: &mut [bool],
) -> Chain {
    let (mut before, mut at) = (start, first);
    let mut points = vec![ink.place(start)];
    loop {
        points.push(ink.place(at));
        if is_node(at) {
            break;
        }
        gone[at] = true;
        let Some(on) = next(ink, at).find(|&index| index != before) else { break };
        (before, at) = (at, on);
    }
    Chain { points, ends: [start, at] }
}

impl Chain {
    fn length(&self) -> f64 {
        self.points.windows(2).map(|pair| pair[0].distance(pair[1])).sum()
    }

    fn is_loop(&self) -> bool {
        self.ends[0] == self.ends[1]
    }

    fn reverse(&mut self) {
        self.points.reverse();
        self.ends.reverse();
    }

    /// The direction at one of its ends.
    fn leaving(&self, end: usize, reach: f64) -> DVec2 {
        let mut points: Box<dyn Iterator<Item = &DVec2>> = Box::new(self.points.iter());
        if end == 1 {
            points = Box::new(self.points.iter().rev());
        }
        let points: Vec<_> = points.copied().collect();
        let far = points.iter().find(|point| point.distance(points[0]) >= reach).or(points.last());
        far.map_or(DVec2::ZERO, |far| *far - points[0]).normalize_or_zero()
    }
}

/// Number of chains at every node.
fn degrees(chains: &[Chain]) -> BTreeMap<usize, usize> {
    let mut degrees = BTreeMap::new();
    for end in chains.iter().flat_map(|chain| chain.ends) {
        *degrees.entry(end).or_insert(0) += 1;
    }
    degrees
}

/// Merges the two junctions, with a short chain between them, that thinning leaves at crossings of thick strokes.
fn join_nodes(chains: &mut Vec<Chain>, width: f64) {
    loop {
        let degrees = degrees(chains);
        let is_bridge = |chain: &Chain| {
            !chain.is_loop() && chain.length() <= width && chain.ends.iter().all(|end| degrees[end] > 2)
        };
        let Some(index) = chains.iter().position(is_bridge) else { return };
        let bridge = chains.swap_remove(index);
        let [kept, gone] = bridge.ends;
        let middle = (bridge.points[0] + bridge.points[bridge.points.len() - 1]) / 2.0;
        for chain in chains.iter_mut() {
            for end in 0..2 {
                if [kept, gone].contains(&chain.ends[end]) {
                    chain.ends[end] = kept;
                    let place = if end == 0 { 0 } else { chain.points.len() - 1 };
                    chain.points[place] = middle;
                }
            }
        }
        // A duplicate path around the same hole.
        chains.retain(|chain| !chain.is_loop() || chain.length() > 2.0 * width);
    }
}

/// Removes spurs of blunt ends, and specks.
fn prune(chains: &mut Vec<Chain>, width: f64) {
    let degrees = degrees(chains);
    chains.retain(|chain| {
        let free = chain.ends.iter().filter(|end| degrees[end] == 1).count();
        match free {
            0 => true,
            1 => chain.length() > width,
            _ => chain.length() > width / 2.0,
        }
    });
}

/// Joins chains that continue straight through their nodes, or are alone there.
fn joined(chains: Vec<Chain>, width: f64) -> Vec<Line> {
    let reach = (2.0 * width).max(SIDE);
    let mut chains: Vec<Option<Chain>> = chains.into_iter().map(Some).collect();
    let nodes: BTreeSet<usize> = chains.iter().flatten().flat_map(|chain| chain.ends).collect();
    for node in nodes {
        // A joined line ends at other nodes, which are processed later or already done.
        while let Some((a, b)) = best_pair(&chains, node, reach) {
            let (Some(mut first), Some(mut second)) = (chains[a.0].take(), chains[b.0].take()) else { break };
            if a.1 == 0 {
                first.reverse();
            }
            if b.1 == 1 {
                second.reverse();
            }
            // From now on the node is inside the line.
            first.points.extend(second.points.into_iter().skip(1));
            first.ends[1] = second.ends[1];
            chains.push(Some(first));
        }
    }
    chains.into_iter().flatten().map(line).collect()
}

/// Two ends of different chains (chain and end each) that continue straight through a node, or are alone there.
fn best_pair(chains: &[Option<Chain>], node: usize, reach: f64) -> Option<((usize, usize), (usize, usize))> {
    let ends: Vec<(usize, usize, DVec2)> = chains
        .iter()
        .enumerate()
        .filter_map(|(index, chain)| Some((index, chain.as_ref()?)))
        .filter(|(_, chain)| !chain.is_loop())
        .flat_map(|(index, chain)| (0..2).map(move |end| (index, end, chain)))
        .filter(|(_, end, chain)| chain.ends[*end] == node)
        .map(|(index, end, chain)| (index, end, chain.leaving(end, reach)))
        .collect();
    let mut best = None;
    for (i, &(a, end_a, leaving_a)) in ends.iter().enumerate() {
        for &(b, end_b, leaving_b) in &ends[..i] {
            let cos = leaving_a.dot(leaving_b);
            let fits = cos < STRAIGHT_COS || ends.len() == 2;
            if fits && best.is_none_or(|(least, _)| cos < least) {
                best = Some((cos, ((a, end_a), (b, end_b))));
            }
        }
    }
    best.map(|(_, pair)| pair)
}

fn line(chain: Chain) -> Line {
    let closed = chain.is_loop() && chain.points.len() > 3;
    let mut points = chain.points;
    if closed {
        points.pop();
    }
    Line::new(points, closed)
}

/// Corners between straight sides stay; between them pixel steps are smoothed.
fn smooth(line: &Line, width: f64) -> Line {
    let mut line = line.clone();
    let corners = corners(&line, width);
    for &corner in &corners {
        sharpen(&mut line, corner, width.ceil() as usize);
    }
    if line.closed {
        if let Some(&first) = corners.first() {
            line.points.rotate_left(first);
            line.points.push(line.points[0]);
            let shifted: Vec<_> = corners.iter().map(|corner| corner - first).collect();
            let mut points = between(&line.points, &shifted);
            points.pop();
            return Line::new(points, true);
        }
        return Line::new(rounded(&line.points), true);
    }
    Line::new(between(&line.points, &corners), false)
}

/// Restores corners cut by thinning, to the intersection of the sides as far as these are straight.
fn sharpen(line: &mut Line, corner: usize, reach: usize) {
    let count = line.points.len();
    // The point `steps` before or after the corner.
    let place = |steps: usize, is_before: bool| match (line.closed, is_before) {
        (true, true) => Some((corner + count - steps % count) % count),
        (true, false) => Some((corner + steps) % count),
        (false, true) => corner.checked_sub(steps),
        (false, false) => Some(corner + steps).filter(|&place| place < count),
    };
    let side = |is_before: bool| -> Option<(DVec2, DVec2)> {
        let beyond = reach + reach.max(SIDE as usize);
        let points: Vec<_> = (reach..beyond)
            .map_while(|steps| place(steps, is_before))
            .map(|place| line.points[place])
            .collect();
        let (near, far) = points.split_at(points.len() / 2);
        (near.len() > 1).then(|| (mean(near), mean(far) - mean(near)))
    };
    let (Some((a, along_a)), Some((b, along_b))) = (side(true), side(false)) else { return };
    let area = along_a.perp_dot(along_b);
    let meeting = a + along_a * ((b - a).perp_dot(along_b) / area);
    if !meeting.is_finite() || meeting.distance(line.points[corner]) > 2.0 * reach as f64 {
        return;
    }
    for is_before in [true, false] {
        let Some(start) = place(reach, is_before).map(|place| line.points[place]) else { continue };
        let near: Vec<_> = (0..reach).filter_map(|steps| Some((steps, place(steps, is_before)?))).collect();
        for (steps, place) in near {
            line.points[place] = meeting.lerp(start, steps as f64 / reach as f64);
        }
    }
}

/// Smooths the parts between fixed points.
fn between(points: &[DVec2], corners: &[usize]) -> Vec<DVec2> {
    let mut fixed: Vec<usize> = corners.iter().copied().chain([0, points.len() - 1]).collect();
    fixed.sort_unstable();
    fixed.dedup();
    let mut smooth = vec![points[0]];
    for pair in fixed.windows(2) {
        let part = &points[pair[0]..=pair[1]];
        let last = part.len() - 1;
        // The window shrinks towards the fixed ends.
        smooth.extend((1..last).map(|i| {
            let reach = SMOOTHING.min(i).min(last - i);
            mean(&part[i - reach..=i + reach])
        }));
        smooth.push(part[last]);
    }
    smooth
}

/// Smooths a loop without corners.
fn rounded(points: &[DVec2]) -> Vec<DVec2> {
    let count = points.len();
    let reach = SMOOTHING.min((count - 1) / 2);
    let window =
        |i: usize| (0..=2 * reach).map(move |k| points[(i + count + k - reach) % count]).collect::<Vec<_>>();
    (0..count).map(|i| mean(&window(i))).collect()
}

fn mean(points: &[DVec2]) -> DVec2 {
    points.iter().sum::<DVec2>() / points.len() as f64
}

/// Indices of the line's points with sharp turns between straight sides.
fn corners(line: &Line, width: f64) -> Vec<usize> {
    // The tolerance covers corners cut by thinning: the remainder is one turn, not two.
    let simple = line.simplified((width / 3.0).max(1.0)).points;
    let count = simple.len();
    if count < 3 {
        return Vec::new();
    }
    let turns = |[before, at, on, after]: [DVec2; 4]| {
        let (arriving, leaving) = (at - before, after - on);
        let side = SIDE.max(2.0 * at.distance(on));
        arriving.length() >= side
            && leaving.length() >= side
            && arriving.normalize_or_zero().dot(leaving.normalize_or_zero()) < CORNER_COS
    };
    let at = |i: usize| simple[i % count];
    let place = |i: usize| line.points.iter().position(|point| *point == at(i));
    let inner = if line.closed { 0..count } else { 1..count - 1 };
    let corner = |i: usize| {
        if turns([at(i + count - 1), at(i), at(i), at(i + 1)]) {
            return place(i);
        }
        // Both ends of the diagonal to which thinning cuts a square corner.
        let is_cut = at(i).distance(at(i + 1)) <= CUT * width && (line.closed || i + 2 < count);
        let is_one = is_cut && !turns([at(i), at(i + 1), at(i + 1), at(i + 2)]);
        if !is_one || !turns([at(i + count - 1), at(i), at(i + 1), at(i + 2)]) {
            return None;
        }
        let (first, second) = (place(i)?, place(i + 1)?);
        let steps = (second + line.points.len() - first) % line.points.len();
        Some((first + steps / 2) % line.points.len())
    };
    let mut corners: Vec<_> = inner.filter_map(corner).collect();
    // A cut across the beginning of a loop comes last.
    corners.sort_unstable();
    corners.dedup();
    corners
}
