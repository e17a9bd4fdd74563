//! The maximum of a smooth sampled function on a rectangle, between its samples.

use glam::DVec2;

/// Distance (in sample steps) to compared neighbours: the first, and the factor where none of them is higher.
const FIRST: f64 = 0.125;
const FINER: f64 = 0.25;
/// Factor of the distance after a move, the largest distance, and the last.
const FARTHER: f64 = 2.0;
const FARTHEST: f64 = 0.5;
const FINEST: f64 = 0.05;
/// Limit of starting samples: rounding makes countless maxima in flat functions.
const MOST: usize = 512;
/// Concurrent climbs, the most promising first.
const TOGETHER: usize = 16;
/// Lower limit of the paraboloid through the samples next to the highest maximum, relative to it: at least 0.94 for
/// five samples per shortest wave.
const LEADING: f64 = 0.92;
/// Limit of moves of a climb.
const MOVES: usize = 32;

/// Directions of the neighbours of a point, in steps.
const SIDES: [DVec2; 8] = [
    DVec2::new(-1.0, -1.0),
    DVec2::new(0.0, -1.0),
    DVec2::new(1.0, -1.0),
    DVec2::new(-1.0, 0.0),
    DVec2::new(1.0, 0.0),
    DVec2::new(-1.0, 1.0),
    DVec2::new(0.0, 1.0),
    DVec2::new(1.0, 1.0),
];

/// A lattice of samples of a function on a rectangle about the origin.
#[derive(Clone, Debug)]
pub struct Lattice {
    /// Row by row.
    pub values: Vec<f64>,
    pub columns: usize,
    /// Position of the first sample, m.
    pub first: DVec2,
    /// m, from a sample to the next.
    pub step: DVec2,
    /// m, half the size of the rectangle.
    pub half: DVec2,
}

/// A position (m) and the value there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summit {
    pub place: DVec2,
    pub value: f64,
    /// Distance of its compared neighbours in steps.
    step: f64,
}

impl Lattice {
    /// The vertex of the paraboloid through a sample and its neighbours, and its height; beyond the edge, the value
    /// at the edge.
    fn vertex(&self, index: usize) -> (DVec2, f64) {
        let rows = self.values.len() / self.columns;
        let (column, row) = (index % self.columns, index / self.columns);
        let beside = |at: usize, side: f64, count: usize| {
            (at + 1).saturating_add_signed(side as isize).clamp(1, count) - 1
        };
        let around = SIDES.map(|side| {
            self.values[beside(row, side.y, rows) * self.columns + beside(column, side.x, self.columns)]
        });
        let (place, height) = vertex(around, self.values[index]);
        (self.beside(self.place(index), place, 1.0), height)
    }

    fn place(&self, index: usize) -> DVec2 {
        let cell = DVec2::new((index % self.columns) as f64, (index / self.columns) as f64);
        (self.first + cell * self.step).clamp(-self.half, self.half)
    }

    /// Samples that no neighbour exceeds.
    fn maxima(&self) -> impl Iterator<Item = usize> {
        let rows = self.values.len() / self.columns;
        let around = |at: usize, count: usize| at.saturating_sub(1)..(at + 2).min(count);
        let is_maximum = move |&index: &usize| {
            let (value, column, row) = (self.values[index], index % self.columns, index / self.columns);
            value > 0.0
                && around(row, rows).all(|row| {
                    around(column, self.columns)
                        .all(|column| self.values[row * self.columns + column] <= value)
                })
        };
        (0..self.values.len()).filter(is_maximum)
    }

    /// Whether maxima count at a sample, or within the distance of its own maximum.
    fn may_count(&self, index: usize, counts: &impl Fn(DVec2) -> bool) -> bool {
        let place = self.place(index);
        counts(place) || SIDES.iter().any(|side| counts(self.beside(place, *side, 1.0)))
    }

    /// The places of the highest counted maxima, at most some, the highest first, from the samples around them.
    pub fn highest(&self, counts: impl Fn(DVec2) -> bool, most: usize) -> Vec<DVec2> {
        let mut maxima: Vec<_> = self.maxima().map(|index| self.vertex(index)).collect();
        maxima.sort_by(|a, b| b.1.total_cmp(&a.1));
        maxima.into_iter().map(|(place, _)| place).filter(|&place| counts(place)).take(most).collect()
    }

    /// The highest of the counted maxima, found from samples not exceeded by a neighbour; `value` evaluates the
    /// function at some points. `None` without a counted maximum.
    pub fn summit(
        &self,
        counts: impl Fn(DVec2) -> bool,
        value: impl Fn(&[DVec2]) -> Vec<f64>,
    ) -> Option<Summit> {
        let mut expected: Vec<_> = self.maxima().map(|index| (index, self.vertex(index))).collect();
        expected.sort_by(|a, b| b.1.1.total_cmp(&a.1.1));
        let (mut expected, mut started) = (expected.into_iter().peekable(), 0);
        let mut highest: Option<Summit> = None;
        loop {
            let least = highest.map_or(0.0, |summit| LEADING * summit.value);
            let mut places = Vec::new();
            // Only the highest are asked whether they count: that may take longer than their height.
            while places.len() < TOGETHER.min(MOST - started)
                && let Some((index, (place, _))) = expected.next_if(|(_, (_, height))| *height >= least)
            {
                places.extend(self.may_count(index, &counts).then_some(place));
            }
            if places.is_empty() {
                return highest;
            }
            started += places.len();
            let reached = self.climbed(&places, highest, &counts, &value);
            highest = reached.into_iter().max_by(|a, b| a.value.total_cmp(&b.value));
        }
    }

    /// The ends of climbs from some points and from the highest so far, if they may be the highest counted maxima.
    fn climbed(
        &self,
        places: &[DVec2],
        so_far: Option<Summit>,
        counts: &impl Fn(DVec2) -> bool,
        value: &impl Fn(&[DVec2]) -> Vec<f64>,
    ) -> Vec<Summit> {
        let start = |(&place, value)| Summit { place, value, step: FIRST };
        let mut climbing: Vec<_> = places.iter().zip(value(places)).map(start).chain(so_far).collect();
        for _ in 0..MOVES {
            // A climb that leaves the counted region says nothing about it.
            let reached = climbing.iter().filter(|summit| counts(summit.place));
            let highest = reached.map(|summit| summit.value).fold(0.0, f64::max);
            climbing.retain(|summit| summit.value >= highest * summit.least());
            if climbing.iter().all(Summit::is_done) {
                break;
            }
            self.climb(&mut climbing, value);
        }
        climbing.retain(|summit| counts(summit.place));
        climbing
    }

    fn beside(&self, place: DVec2, side: DVec2, steps: f64) -> DVec2 {
        (place + side * self.step * steps).clamp(-self.half, self.half)
    }

    /// Moves every point to its highest neighbour or, if none is higher, to the vertex of a paraboloid through all of
    /// them.
    fn climb(&self, climbing: &mut [Summit], value: &impl Fn(&[DVec2]) -> Vec<f64>) {
        let mut climbing: Vec<_> = climbing.iter_mut().filter(|summit| !summit.is_done()).collect();
        let around = |summit: &&mut Summit| SIDES.map(|side| self.beside(summit.place, side, summit.step));
        let places: Vec<_> = climbing.iter().flat_map(around).collect();
        let values = value(&places);
        let (places, values) = (places.as_chunks::<8>().0, values.as_chunks::<8>().0);
        let mut trials = Vec::new();
        for ((summit, places), values) in climbing.iter_mut().zip(places).zip(values) {
            let highest = (0..SIDES.len()).max_by(|&a, &b| values[a].total_cmp(&values[b]));
            trials.push(match highest {
                Some(side) if values[side] > summit.value => {
                    (summit.place, summit.value) = (places[side], values[side]);
                    // Ridges are long.
                    summit.step = (summit.step * FARTHER).min(FARTHEST);
                    None
                }
                Some(_) | None => {
                    let (vertex, _) = vertex(*values, summit.value);
                    let trial = self.beside(summit.place, vertex, summit.step);
                    summit.step *= FINER;
                    Some(trial)
                }
            });
        }
        let places: Vec<_> = trials.iter().copied().flatten().collect();
        if places.is_empty() {
            return;
        }
        let tried = climbing.into_iter().zip(trials).filter_map(|(summit, trial)| Some((summit, trial?)));
        for ((summit, place), value) in tried.zip(value(&places)) {
            if value > summit.value {
                (summit.place, summit.value) = (place, value);
            }
        }
    }
}

impl Summit {
    fn is_done(&self) -> bool {
        self.step < FINEST
    }

    /// The fraction of the highest that it must have to surpass it. Over a step to either side of a maximum, a
    /// function with five samples per shortest wave falls by an eighth of that.
    fn least(&self) -> f64 {
        1.0 - 8.0 * self.step.min(FIRST).powi(2)
    }
}

/// The vertex of a paraboloid through a point and its neighbours ([`SIDES`]), within one step, and its height.
fn vertex(around: [f64; 8], middle: f64) -> (DVec2, f64) {
    let [low, below, low_right, left, right, high_left, above, high] = around;
    let slope = DVec2::new(right - left, above - below) / 2.0;
    let bend = DVec2::new(right - 2.0 * middle + left, above - 2.0 * middle + below);
    let twist = (high - high_left - low_right + low) / 4.0;
    let determinant = bend.x * bend.y - twist * twist;
    let place = if bend.x < 0.0 && determinant > 0.0 {
        DVec2::new(twist * slope.y - bend.y * slope.x, twist * slope.x - bend.x * slope.y) / determinant
    } else {
        let along = |slope: f64, bend: f64| if bend < 0.0 { -slope / bend } else { 0.0 };
        DVec2::new(along(slope.x, bend.x), along(slope.y, bend.y))
    };
    let place = place.clamp(DVec2::NEG_ONE, DVec2::ONE);
    let rise = slope.dot(place) + 0.5 * bend.dot(place * place) + twist * place.x * place.y;
    (place, middle + rise.max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The lattice of samples a unit apart.
    fn sampled(counts: [usize; 2], function: &impl Fn(DVec2) -> f64) -> Lattice {
        let half = DVec2::new(counts[0] as f64 - 1.0, counts[1] as f64 - 1.0) / 2.0;
        let place = |i: usize| DVec2::new((i % counts[0]) as f64, (i / counts[0]) as f64) - half;
        let values = (0..counts[0] * counts[1]).map(|i| function(place(i))).collect();
        Lattice { values, columns: counts[0], first: -half, step: DVec2::ONE, half }
    }

    #[test]
    fn the_highest_of_more_summits_than_are_climbed_at_a_time_is_found_in_any_unit() {
        let wave = |at: DVec2| {
            1.1 + (1.05 * at.x + 0.3).cos() * (1.03 * at.y).cos() + 5e-3 * (0.11 * at.x - 0.07 * at.y).sin()
        };
        let summit = |unit: f64| {
            let function = |at: DVec2| unit * wave(at);
            let lattice = sampled([61, 51], &function);
            assert!(lattice.maxima().count() > 2 * TOGETHER);
            lattice.summit(|_| true, |places| places.iter().map(|&at| function(at)).collect()).unwrap()
        };
        let found = summit(1.0);
        let fine = (0..=600 * 500u32).map(|i| {
            let place = DVec2::new(f64::from(i % 601), f64::from(i / 601)) / 10.0 - DVec2::new(30.0, 25.0);
            wave(place)
        });
        assert!(found.value > 0.999 * fine.fold(0.0, f64::max), "{found:?}");
        for unit in [1e-3, 1e3] {
            let other = summit(unit);
            assert!((other.value / unit / found.value - 1.0).abs() < 1e-9, "{unit}: {other:?}, {found:?}");
        }
    }

    /// The waves have six samples to the shortest, on a rectangle that cuts one of them.
    #[test]
    fn the_highest_of_many_summits_is_met_within_the_rectangle_and_at_its_edge() {
        let wave = |place: DVec2, turn: f64| {
            1.0 + (place.x + turn).cos() * (0.7 * place.y - turn).cos()
                + 0.2 * (0.31 * place.x - 0.53 * place.y).sin()
        };
        for turn in 0..12 {
            let turn = f64::from(turn) * 0.37;
            let (half, step) = (DVec2::new(9.0, 7.0), DVec2::new(1.0, 0.875));
            let place = |i: usize| DVec2::new((i % 19) as f64, (i / 19) as f64) * step - half;
            let values = (0..19 * 17).map(|i| wave(place(i), turn)).collect();
            let lattice = Lattice { values, columns: 19, first: -half, step, half };
            let all = |places: &[DVec2]| places.iter().map(|&place| wave(place, turn)).collect();
            let found = lattice.summit(|_| true, all).unwrap();
            let fine = (0..=1400 * 1800u32).map(|i| {
                let place = DVec2::new(f64::from(i % 1801), f64::from(i / 1801)) / 100.0 - half;
                wave(place.clamp(-half, half), turn)
            });
            let highest = fine.fold(0.0, f64::max);
            assert!((found.value / highest - 1.0).abs() < 1e-4, "{turn}: {found:?}, not {highest}");
            // Beside it, where only half of the places count.
            let counts = |place: DVec2| place.x > found.place.x + 1.0;
            if let Some(other) = lattice.summit(counts, all) {
                assert!(other.value <= found.value && counts(other.place), "{turn}: {other:?}");
            }
        }
    }

    /// The values of a paraboloid at a point's neighbours, and at the point.
    fn paraboloid(height: impl Fn(DVec2) -> f64) -> ([f64; 8], f64) {
        (SIDES.map(&height), height(DVec2::ZERO))
    }

    #[test]
    fn the_vertex_is_the_top_of_a_hill_and_never_the_middle_of_a_valley_or_a_saddle() {
        let (x, y) = (0.3, -0.4);
        let top = DVec2::new(x, y);
        let hill = |at: DVec2| {
            let by = at - top;
            3.0 - 0.4 * by.x * by.x - 0.3 * by.y * by.y + 0.2 * by.x * by.y
        };
        let (around, middle) = paraboloid(hill);
        let (place, height) = vertex(around, middle);
        assert!(place.distance(top) < 1e-12 && (height - 3.0).abs() < 1e-12, "{place}, {height}");
        // Flat enough for a curvature below one in both directions.
        let (around, middle) = paraboloid(|at| 3.0 + 0.2 * (at - top).length_squared());
        assert_eq!(vertex(around, middle), (DVec2::ZERO, middle));
        // Along the falling axis there is a maximum, along the other a minimum.
        let saddle = |at: DVec2| 3.0 - 0.2 * (at.x - x).powi(2) + 0.3 * (at.y - y).powi(2);
        let (around, middle) = paraboloid(saddle);
        let (place, height) = vertex(around, middle);
        assert!(place.distance(DVec2::new(x, 0.0)) < 1e-12, "{place}");
        assert!((height - middle - 0.2 * x * x).abs() < 1e-12, "{height}, not above {middle}");
    }

    #[test]
    fn what_is_positive_nowhere_has_no_summit() {
        for value in [0.0, -1.0, f64::NAN] {
            let lattice = Lattice {
                values: vec![value; 9],
                columns: 3,
                first: DVec2::NEG_ONE,
                step: DVec2::ONE,
                half: DVec2::ONE,
            };
            assert_eq!(lattice.summit(|_| true, |places| vec![value; places.len()]), None);
        }
    }

    #[test]
    fn a_summit_that_counts_beside_a_sample_that_does_not_is_found() {
        let top = DVec2::new(0.3, 0.2);
        let hill = |at: DVec2| 3.0 - 0.1 * (at - top).length_squared();
        let (half, columns) = (DVec2::splat(3.0), 7);
        let place = |i: usize| DVec2::new((i % columns) as f64, (i / columns) as f64) - half;
        let values = (0..columns * columns).map(|i| hill(place(i))).collect();
        let lattice = Lattice { values, columns, first: -half, step: DVec2::ONE, half };
        let all = |places: &[DVec2]| places.iter().map(|&place| hill(place)).collect();
        // The highest sample, at the origin, is outside.
        let found = lattice.summit(|place| place.x > 0.2, all).unwrap();
        assert!(found.place.distance(top) < 1e-6, "{found:?}");
        assert_eq!(lattice.summit(|place| place.x > 2.0, all), None);
    }
}
