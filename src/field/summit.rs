//! The highest place of a smooth function on a rectangle, between the samples that are known of it.

use glam::DVec2;

/// Halvings of the way to a neighbour: the place is then within a 128th of a step.
const HALVINGS: usize = 6;
/// Samples from which climbs begin, at most: rounding makes maxima without number where a function is flat.
const MOST: usize = 512;
/// Climbs that are made together, the most promising first.
const TOGETHER: usize = 32;
/// Moves from one place to a higher one, at most, in all of a climb.
const MOVES: usize = 64;

/// Towards the neighbours of a place, in steps.
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

/// A lattice of samples of a function that is looked at on a rectangle about the origin.
#[derive(Clone, Debug)]
pub struct Lattice {
    /// Row by row.
    pub values: Vec<f64>,
    pub columns: usize,
    /// m, the place of the first sample.
    pub first: DVec2,
    /// m, from a sample to the next.
    pub step: DVec2,
    /// m, half the size of the rectangle.
    pub half: DVec2,
}

/// A place (m) and the value there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summit {
    pub place: DVec2,
    pub value: f64,
    /// Steps to the neighbours that it is compared with.
    step: f64,
    is_done: bool,
}

impl Lattice {
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

    /// Whether maxima count at a sample, or at a place as near to it as its own maximum may be.
    fn may_count(&self, index: usize, counts: &impl Fn(DVec2) -> bool) -> bool {
        let place = self.place(index);
        counts(place) || SIDES.iter().any(|side| counts(self.beside(place, *side, 1.0)))
    }

    /// The highest of the maxima that count. Samples lead to it that no neighbour exceeds and that have at least this `part` of it;
    /// `value` is the function at some places. `None` where no maximum counts.
    pub fn summit(
        &self,
        part: f64,
        counts: impl Fn(DVec2) -> bool,
        value: impl Fn(&[DVec2]) -> Vec<f64>,
    ) -> Option<Summit> {
        let mut maxima: Vec<_> = self.maxima().filter(|&index| self.may_count(index, &counts)).collect();
        maxima.sort_by(|&a, &b| self.values[b].total_cmp(&self.values[a]));
        maxima.truncate(MOST);
        let mut highest: Option<Summit> = None;
        for some in maxima.chunks(TOGETHER) {
            let least = highest.map_or(0.0, |summit| part * summit.value);
            let places: Vec<_> = some
                .iter()
                .filter(|&&index| self.values[index] >= least)
                .map(|&index| self.place(index))
                .collect();
            if places.is_empty() {
                break;
            }
            let reached = self.climbed(&places, highest, &counts, &value);
            highest = reached.into_iter().max_by(|a, b| a.value.total_cmp(&b.value));
        }
        highest
    }

    /// Where climbs from some places and from the highest so far end, if they may be the highest of those that count.
    fn climbed(
        &self,
        places: &[DVec2],
        so_far: Option<Summit>,
        counts: &impl Fn(DVec2) -> bool,
        value: &impl Fn(&[DVec2]) -> Vec<f64>,
    ) -> Vec<Summit> {
        let start = |(&place, value)| Summit { place, value, step: 0.5, is_done: false };
        let mut climbing: Vec<_> = places.iter().zip(value(places)).map(start).chain(so_far).collect();
        for _ in 0..MOVES {
            // What climbs out of where maxima count says nothing of those that do.
            let reached = climbing.iter().filter(|summit| counts(summit.place));
            let highest = reached.map(|summit| summit.value).fold(0.0, f64::max);
            climbing.retain(|summit| summit.value >= highest * summit.least());
            if climbing.iter().all(|summit| summit.is_done) {
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

    /// Moves every place to its highest neighbour, or its neighbours half as far away.
    fn climb(&self, climbing: &mut [Summit], value: &impl Fn(&[DVec2]) -> Vec<f64>) {
        let mut climbing: Vec<_> = climbing.iter_mut().filter(|summit| !summit.is_done).collect();
        let around = |summit: &&mut Summit| SIDES.map(|side| self.beside(summit.place, side, summit.step));
        let places: Vec<_> = climbing.iter().flat_map(around).collect();
        let values = value(&places);
        for (index, summit) in climbing.iter_mut().enumerate() {
            let sides = index * SIDES.len()..(index + 1) * SIDES.len();
            match sides.max_by(|&a, &b| values[a].total_cmp(&values[b])) {
                Some(side) if values[side] > summit.value => {
                    (summit.place, summit.value) = (places[side], values[side]);
                }
                Some(_) | None => summit.halve(),
            }
        }
    }
}

impl Summit {
    fn halve(&mut self) {
        self.step *= 0.5;
        self.is_done = self.step < 0.5f64.powi(HALVINGS as i32);
    }

    /// What it must have of the highest to become higher still. A function with three samples to its shortest wave falls by less than
    /// this over a step to either side of a maximum.
    fn least(&self) -> f64 {
        (1.0 - 2.0 * (2.0 * self.step).powi(2)).max(0.0)
    }
}
