//! The further search for a shape's drive, from additional starts.

use strum::VariantArray;
use web_time::{Duration, Instant};

use crate::gauge::Gauge;
use crate::solver::problem::{Excitation, Problem};
use crate::solver::shape::{FINE, FREE, OTHER_STEPS, Search, Start, Surroundings, value};

/// Calls of [`FINE`] steps from each start.
const CALLS: usize = 8;

/// The drive of a [`Search`], and of as many further starts as begin within the time. Drives of areas go to `so_far`
/// until all are there.
pub fn best_within(
    problem: &Problem<'_>,
    surroundings: &Surroundings,
    time: Duration,
    so_far: &mut dyn FnMut(Excitation),
) -> Excitation {
    let start = Instant::now();
    let gauge = Gauge::current();
    let mut search = Search::new(problem, surroundings);
    let mut best = None;
    while !gauge.is_cancelled()
        && let Some(better) = search.advance()
    {
        best = Some(better);
        if search.is_under_way() {
            best.iter().cloned().for_each(&mut *so_far);
        }
    }
    let mut number = Start::VARIANTS.len();
    while best.is_some() && gauge.lasts(start.elapsed(), time) {
        search.further(number);
        best = Some(search.give());
        number += search.objective.drives();
    }
    match best {
        Some(best) => search.turned_for_rounding(best),
        None => search.silent(),
    }
}

impl Search<'_> {
    /// Replaces the better descent if this start ends better.
    fn further(&mut self, number: usize) {
        let rival = 1 - self.leader;
        let (weights, is_free) = (self.objective.weights, self.objective.is_free);
        self.objective.is_free = false;
        self.ways[rival] = Some(self.begun(number, OTHER_STEPS));
        self.objective.weights = weights;
        self.renew(rival);
        for _ in 0..CALLS {
            if !self.run(rival, FINE.0) {
                break;
            }
        }
        self.objective.is_free = is_free;
        if is_free {
            self.free(rival);
            for _ in 0..FREE.1 {
                if !self.run(rival, FREE.0) {
                    break;
                }
            }
        }
        if value(&self.ways[rival]) < value(&self.ways[self.leader]) {
            self.leader = rival;
        }
    }
}
