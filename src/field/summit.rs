//! The highest place of a smooth function on a rectangle, between the samples that are known of it.

use glam::DVec2;

/// Halvings of the way to a neighbour: the place is then within a 128th of a step.
const HALVINGS: usize = 6;
/// Samples from which a climb begins, at most: rounding makes maxima without number where a function is flat.
const MOST: usize = 128;
/// Moves from one place to a higher one, at most, in all of a climb.
const MOVES: usize = 64;

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

    /// The highest of the maxima that count. Samples lead to it that no neighbour exceeds and that reach this `part` of the largest
    /// of them; `value` is the function at some places. `None` where no maximum counts.
    pub fn summit(
        &self,
        part: f64,
        counts: impl Fn(DVec2) -> bool,
        value: impl Fn(&[DVec2]) -> Vec<f64>,
    ) -> Option<Summit> {
        let mut maxima: Vec<_> = self.maxima().filter(|&index| counts(self.place(index))).collect();
        maxima.sort_by(|&a, &b| self.values[b].total_cmp(&self.values[a]));
        let largest = maxima.first().map_or(0.0, |&index| self.values[index]);
        let places: Vec<_> = maxima
            .into_iter()
            .filter(|&index| self.values[index] >= part * largest)
            .take(MOST)
            .map(|index| self.place(index))
            .collect();
        let start = |(place, value)| Summit { place, value, step: 0.5, is_done: false };
        let values = value(&places);
        let mut climbing: Vec<_> = places.into_iter().zip(values).map(start).collect();
        for _ in 0..MOVES {
            // What climbs out of where maxima count says nothing of those that do.
            let reached = climbing.iter().filter(|summit| counts(summit.place));
            let highest = reached.map(|summit| summit.value).fold(0.0, f64::max);
            climbing.retain(|summit| summit.value >= highest * summit.least());
            if climbing.iter().all(|summit| summit.is_done) {
                break;
            }
            self.climb(&mut climbing, &value);
        }
        climbing.into_iter().filter(|summit| counts(summit.place)).max_by(|a, b| a.value.total_cmp(&b.value))
    }

    /// Moves every place to its highest neighbour, or its neighbours half as far away.
    fn climb(&self, climbing: &mut [Summit], value: &impl Fn(&[DVec2]) -> Vec<f64>) {
        const SIDES: [(f64, f64); 8] = [
            (-1.0, -1.0),
            (0.0, -1.0),
            (1.0, -1.0),
            (-1.0, 0.0),
            (1.0, 0.0),
            (-1.0, 1.0),
            (0.0, 1.0),
            (1.0, 1.0),
        ];
        let mut climbing: Vec<_> = climbing.iter_mut().filter(|summit| !summit.is_done).collect();
        let beside = |summit: &&mut Summit| {
            let (place, step) = (summit.place, self.step * summit.step);
            SIDES.map(|(x, y)| (place + DVec2::new(x, y) * step).clamp(-self.half, self.half))
        };
        let places: Vec<_> = climbing.iter().flat_map(beside).collect();
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
