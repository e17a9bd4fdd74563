//! Routes of targets from a file: places that are visited at their own times, or at constant speed.
//!
//! Places are absolute (m), unlike the offsets of other paths. A route ends where it begins: from its last place it
//! returns straight to the first, at its mean speed, unless it is drawn with jumps, one of which then closes it.
//! Routes of several targets share one clock.

use std::ops::Range;
use std::path::PathBuf;

use glam::DVec3;

use crate::scene::loaded::Loaded;
use crate::scene::motion::pose::{Mover, Pose};

/// Limit of the frames that are chosen for a file.
const MOST_FRAMES: u32 = 4096;
/// Fewest frames that are chosen for a file.
const FEWEST_FRAMES: u32 = 64;
/// Limit of the way of a target between two chosen frames, m.
const STRIDE: f64 = 1e-3;
/// Relative: sample times closer than this are evenly spaced.
const UNEVEN: f64 = 1e-3;

/// The places of a target as a file gives them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trace {
    /// The target's index in the scene; `None`: the only one, for all targets that share the motion.
    pub target: Option<usize>,
    pub places: Vec<TracePlace>,
    /// Whether heights are given; without, the target keeps its own.
    pub has_height: bool,
}

/// A place that a trace visits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TracePlace {
    /// m
    pub at: DVec3,
    /// s, if the file has times; increasing, except over jumps.
    pub time: Option<f64>,
    /// Whether it is reached by a jump, in no time.
    pub jumps: bool,
}

/// The routes of a file, once loaded. A scene file only names it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Routes(Loaded<Loading>);

#[derive(Debug, PartialEq)]
struct Loading {
    file: PathBuf,
    routes: Vec<Route>,
    /// s, of a repetition, if the file has times.
    period: Option<f64>,
    frames: u32,
    /// Places of the longest route.
    places: usize,
    remarks: Vec<String>,
}

#[derive(Debug, PartialEq)]
struct Route {
    target: Option<usize>,
    has_height: bool,
    /// m; the first again at the end, unless a jump leads there.
    places: Vec<DVec3>,
    /// Fraction of a repetition at each place, ascending from 0.
    parts: Vec<f64>,
    /// m, without jumps.
    length: f64,
}

impl Routes {
    /// The routes of a file, with remarks on what was left aside in it.
    ///
    /// # Panics
    /// No traces, or one without places.
    pub fn new(file: PathBuf, traces: &[Trace], remarks: Vec<String>) -> Self {
        assert!(traces.iter().all(|trace| !trace.places.is_empty()) && !traces.is_empty(), "no places");
        let clock = Clock::of(traces);
        let places = traces.iter().map(|trace| trace.places.len()).max().unwrap_or(0);
        let routes: Vec<_> =
            traces.iter().enumerate().map(|(index, trace)| clock.route(index, trace)).collect();
        let frames = frames(&routes, &clock);
        let period = clock.is_given.then_some(clock.period).filter(|period| *period > 0.0);
        Self(Loaded::new(Loading { file, routes, period, frames, places, remarks }))
    }

    /// The file of origin.
    pub fn file(&self) -> Option<&PathBuf> {
        self.0.get().map(|loaded| &loaded.file)
    }

    /// s, of a repetition, if the file has times.
    pub(super) fn period(&self) -> Option<f64> {
        self.0.get()?.period
    }

    /// Whether the file is not yet loaded.
    pub(super) fn is_missing(&self) -> bool {
        self.0.get().is_none()
    }

    /// m, of the longest route.
    pub(super) fn length(&self) -> f64 {
        self.routes().iter().map(|route| route.length).fold(0.0, f64::max)
    }

    /// Frames in which no place is left out, up to a limit.
    pub(super) fn frames(&self) -> u32 {
        self.0.get().map_or(FEWEST_FRAMES, |loaded| loaded.frames)
    }

    /// What the file holds, in numbers: places of the longest route.
    pub fn places(&self) -> usize {
        self.0.get().map_or(0, |loaded| loaded.places)
    }

    /// Remarks on what was left aside.
    pub fn remarks(&self) -> &[String] {
        self.0.get().map_or(&[], |loaded| &loaded.remarks)
    }

    /// The numbers from 0 of the targets that have a route of their own.
    pub(super) fn targets(&self) -> impl Iterator<Item = usize> {
        self.routes().iter().filter_map(|route| route.target)
    }

    /// Whether every target follows the same route.
    pub(super) fn are_shared(&self) -> bool {
        matches!(self.routes(), [Route { target: None, .. }])
    }

    fn routes(&self) -> &[Route] {
        self.0.get().map_or(&[], |loaded| &loaded.routes)
    }

    fn of(&self, target: usize) -> Option<&Route> {
        self.routes().iter().find(|route| route.target.is_none_or(|own| own == target))
    }

    /// The pose of a target after a fraction of a repetition in [0, 1); at rest without a route.
    pub(super) fn at(&self, part: f64, mover: Mover) -> Pose {
        self.of(mover.target).map_or(Pose::AT_REST, |route| Pose {
            at: route.offset(route.at(part), mover.from),
            ..Pose::AT_REST
        })
    }

    /// The offsets (m) of a target in a repetition, in pieces between jumps of at most `most` places.
    pub(super) fn ways(&self, mover: Mover, most: usize) -> Vec<Vec<DVec3>> {
        let Some(route) = self.of(mover.target) else { return Vec::new() };
        let places: Vec<_> = route.places.iter().map(|place| route.offset(*place, mover.from)).collect();
        let is_jump = |i: usize| i > 0 && route.parts[i] == route.parts[i - 1] && places[i] != places[i - 1];
        let starts: Vec<_> = (0..places.len()).filter(|&i| i == 0 || is_jump(i)).collect();
        let ends = starts.iter().copied().skip(1).chain([places.len()]);
        let step = places.len().div_ceil(most.max(1)).max(1);
        let piece = |(&start, end): (&usize, usize)| {
            let inner = (start..end - 1).step_by(step).chain([end - 1]);
            inner.map(|i| places[i]).collect()
        };
        starts.iter().zip(ends).map(piece).collect()
    }
}

impl Route {
    /// From the place (m) that is brought to this one; heights may be the target's own.
    fn offset(&self, place: DVec3, from: DVec3) -> DVec3 {
        if self.has_height { place - from } else { (place - from).with_z(0.0) }
    }

    fn at(&self, part: f64) -> DVec3 {
        let next = self.parts.partition_point(|&end| end <= part);
        match (self.places.get(next.wrapping_sub(1)), self.places.get(next)) {
            (Some(from), Some(to)) => {
                let [begun, ended] = [self.parts[next - 1], self.parts[next]];
                from.lerp(*to, (part - begun) / (ended - begun))
            }
            (Some(&only), None) | (None, Some(&only)) => only,
            (None, None) => DVec3::ZERO,
        }
    }
}

/// The common clock of traces: seconds, or metres of the target that moves most.
struct Clock {
    is_given: bool,
    /// At every place of every trace, from 0.
    times: Vec<Vec<f64>>,
    /// The same at the end of the way back to the first place.
    ends: Vec<f64>,
    period: f64,
}

impl Clock {
    fn of(traces: &[Trace]) -> Self {
        let given = |place: &TracePlace| place.time;
        let is_given = traces.iter().flat_map(|trace| &trace.places).all(|place| place.time.is_some());
        let begun =
            traces.iter().flat_map(|trace| &trace.places).filter_map(given).fold(f64::INFINITY, f64::min);
        let is_in_step = traces.windows(2).all(|pair| pair[0].places.len() == pair[1].places.len());
        let times: Vec<Vec<f64>> = match is_given {
            true => {
                let of = |trace: &Trace| trace.places.iter().filter_map(given).map(|t| t - begun).collect();
                traces.iter().map(of).collect()
            }
            // Rows belong together.
            false if is_in_step => vec![metres(traces); traces.len()],
            false => traces.chunks(1).map(metres).collect(),
        };
        let backs: Vec<f64> =
            traces.iter().zip(&times).map(|(trace, times)| back(trace, times, is_given)).collect();
        let common = backs.iter().copied().fold(0.0, f64::max);
        let back = |own: f64| if is_in_step { common } else { own };
        let last = |times: &Vec<f64>| times.last().copied().unwrap_or(0.0);
        let ends: Vec<_> = times.iter().zip(&backs).map(|(times, &own)| last(times) + back(own)).collect();
        let period = ends.iter().copied().fold(0.0, f64::max);
        Self { is_given, times, ends, period }
    }

    /// The route of a trace, by its index.
    fn route(&self, index: usize, trace: &Trace) -> Route {
        let mut places: Vec<_> = trace.places.iter().map(|place| place.at).collect();
        let per = if self.period > 0.0 { self.period.recip() } else { 0.0 };
        let mut parts: Vec<_> = self.times[index].iter().map(|time| time * per).collect();
        let mut length = drawn(trace).map(|pair| pair[0].at.distance(pair[1].at)).sum();
        if !trace.places.iter().skip(1).any(|place| place.jumps) {
            length += places[places.len() - 1].distance(places[0]);
            places.push(places[0]);
            parts.push(self.ends[index] * per);
        }
        Route { target: trace.target, has_height: trace.has_height, places, parts, length }
    }
}

/// The ways between places that are no jumps.
fn drawn(trace: &Trace) -> impl Iterator<Item = &[TracePlace]> {
    trace.places.windows(2).filter(|pair| !pair[1].jumps)
}

/// m, from the first place of each trace to every other, by the one that moves most from place to place.
fn metres(traces: &[Trace]) -> Vec<f64> {
    let count = traces.first().map_or(0, |trace| trace.places.len());
    let mut sum = 0.0;
    let step = |i: usize| {
        let of = |trace: &Trace| match trace.places[i] {
            TracePlace { jumps: true, .. } => 0.0,
            place => place.at.distance(trace.places[i - 1].at),
        };
        traces.iter().map(of).fold(0.0, f64::max)
    };
    let to = |i: usize| {
        sum += if i == 0 { 0.0 } else { step(i) };
        sum
    };
    (0..count).map(to).collect()
}

/// The time of the way back, at the mean speed: a whole number of sample intervals, so that frames stay on samples.
fn back(trace: &Trace, times: &[f64], is_given: bool) -> f64 {
    let (Some(first), Some(last)) = (trace.places.first(), trace.places.last()) else { return 0.0 };
    let away = last.at.distance(first.at);
    if away == 0.0 || trace.places.iter().skip(1).any(|place| place.jumps) {
        return 0.0;
    }
    if !is_given {
        return away;
    }
    let taken = times.last().copied().unwrap_or(0.0) - times.first().copied().unwrap_or(0.0);
    let length: f64 = drawn(trace).map(|pair| pair[0].at.distance(pair[1].at)).sum();
    let interval = taken / (trace.places.len() - 1).max(1) as f64;
    if length > 0.0 { (away / length * taken / interval - UNEVEN).ceil().max(1.0) * interval } else { 0.0 }
}

/// Frames on all evenly spaced samples, and at most [`STRIDE`] apart, within the limits.
fn frames(routes: &[Route], clock: &Clock) -> u32 {
    if clock.period <= 0.0 {
        return 1;
    }
    let ways = |route: &Route| {
        let steps: Range<usize> = 1..route.parts.len();
        let step =
            |i: usize| (route.parts[i] - route.parts[i - 1], route.places[i].distance(route.places[i - 1]));
        steps.map(step).filter(|(part, _)| *part > 0.0).collect::<Vec<_>>()
    };
    let all: Vec<_> = routes.iter().map(ways).collect();
    let most = all.iter().map(Vec::len).max().unwrap_or(1).max(1);
    let fastest = all.iter().flatten().map(|(part, way)| way / part).fold(0.0, f64::max);
    let shortest = all.iter().flatten().map(|(part, _)| *part).fold(1.0, f64::min);
    let even = shortest.recip().round();
    let is_even = |part: &f64| ((part / shortest).round() - part / shortest).abs() <= UNEVEN;
    let samples = match all.iter().flatten().map(|(part, _)| part).all(is_even) {
        true => even as u32,
        false => u32::try_from(most).unwrap_or(u32::MAX),
    };
    let (samples, limit) = (samples.max(1), MOST_FRAMES);
    if samples >= limit {
        return limit;
    }
    let wanted = ((fastest / STRIDE - UNEVEN).ceil() as u32).max(FEWEST_FRAMES);
    samples * wanted.div_ceil(samples).clamp(1, limit / samples)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trace(places: &[(Option<f64>, DVec3)]) -> Trace {
        let place = |&(time, at): &(Option<f64>, DVec3)| TracePlace { at, time, jumps: false };
        Trace { target: None, places: places.iter().map(place).collect(), has_height: true }
    }

    fn mover(target: usize, from: DVec3) -> Mover {
        Mover { target, from }
    }

    fn at(routes: &Routes, part: f64) -> DVec3 {
        routes.at(part, mover(0, DVec3::ZERO)).at
    }

    /// A corner: 30 mm along x, 40 mm along y, and 50 mm back.
    const CORNERS: [DVec3; 3] =
        [DVec3::new(0.0, 0.0, 0.1), DVec3::new(0.03, 0.0, 0.1), DVec3::new(0.03, 0.04, 0.1)];

    #[test]
    fn places_without_times_are_visited_at_constant_speed() {
        let routes = Routes::new(PathBuf::new(), &[trace(&CORNERS.map(|at| (None, at)))], Vec::new());
        assert!((routes.length() - 0.12).abs() < 1e-12 && routes.period().is_none());
        for (part, x, y) in [(0.0, 0.0, 0.0), (0.125, 0.015, 0.0), (0.25, 0.03, 0.0), (0.5, 0.03, 0.03)] {
            let place = at(&routes, part);
            assert!(place.distance(DVec3::new(x, y, 0.1)) < 1e-12, "{part}: {place}");
        }
        // Halfway back.
        let middle = (CORNERS[0] + CORNERS[2]) / 2.0;
        assert!(at(&routes, (0.07 + 0.025) / 0.12).distance(middle) < 1e-12);
        // A millimetre between frames, at most, and every way in as many parts: 120 are enough.
        assert_eq!(routes.frames(), 120);
    }

    #[test]
    fn times_are_kept_and_frames_meet_every_sample() {
        let sampled = |i: u32| (Some(2.0 + 0.01 * f64::from(i)), DVec3::new(0.0004 * f64::from(i), 0.0, 0.1));
        let samples: Vec<_> = (0..=100).map(sampled).collect();
        let routes = Routes::new(PathBuf::new(), &[trace(&samples)], Vec::new());
        assert!((routes.period().unwrap() - 2.0).abs() < 1e-9, "there and back");
        let frames = routes.frames();
        assert_eq!(frames, 200);
        for (i, (_, place)) in (0..).zip(&samples) {
            assert!(at(&routes, f64::from(i) / f64::from(frames)).distance(*place) < 1e-12, "{i}");
        }
        // The middle of three places is reached after a tenth of the time there.
        let uneven = [(Some(0.0), CORNERS[0]), (Some(0.1), CORNERS[1]), (Some(1.0), CORNERS[0])];
        let routes = Routes::new(PathBuf::new(), &[trace(&uneven)], Vec::new());
        assert_eq!(routes.period(), Some(1.0), "it closes by itself");
        assert!(at(&routes, 0.1).distance(CORNERS[1]) < 1e-12);
        assert!(at(&routes, 0.55).distance((CORNERS[0] + CORNERS[1]) / 2.0) < 1e-12);
    }

    #[test]
    fn targets_of_one_file_keep_step() {
        let own = |target, places: [DVec3; 3]| Trace {
            target: Some(target),
            ..trace(&places.map(|at| (None, at)))
        };
        let slow = CORNERS.map(|at| at * 0.1);
        let routes = Routes::new(PathBuf::new(), &[own(1, CORNERS), own(0, slow)], Vec::new());
        for i in 0..24 {
            let part = f64::from(i) / 24.0;
            let [fast, slow] = [1, 0].map(|target| routes.at(part, mover(target, DVec3::ZERO)).at);
            assert!(slow.distance(fast * 0.1) < 1e-12, "{part}: {fast}, {slow}");
        }
        assert_eq!(routes.at(0.3, mover(2, DVec3::ZERO)), Pose::AT_REST, "a target without a route");
    }

    #[test]
    fn jumps_take_no_time_and_heights_are_the_targets_if_the_file_has_none() {
        let mut path = trace(&[0.0, 0.01, 0.05, 0.06].map(|x| (None, DVec3::new(x, 0.0, 0.0))));
        (path.places[2].jumps, path.has_height) = (true, false);
        let routes = Routes::new(PathBuf::new(), &[path], Vec::new());
        assert!((routes.length() - 0.02).abs() < 1e-12);
        let from = DVec3::new(0.01, 0.02, 0.15);
        for (part, x) in [(0.0, 0.0), (0.499, 0.00998), (0.501, 0.05002), (0.75, 0.055)] {
            let offset = routes.at(part, mover(0, from)).at;
            assert!(offset.distance(DVec3::new(x - 0.01, -0.02, 0.0)) < 1e-12, "{part}: {offset}");
        }
    }

    #[test]
    fn a_long_file_is_resampled_to_the_limit() {
        let sampled = |i: u32| (Some(f64::from(i)), DVec3::new(1e-5 * f64::from(i % 7), 0.0, 0.1));
        let samples: Vec<_> = (0..10_000).map(sampled).collect();
        let routes = Routes::new(PathBuf::new(), &[trace(&samples)], Vec::new());
        assert_eq!((routes.frames(), routes.places()), (MOST_FRAMES, 10_000));
    }
}
