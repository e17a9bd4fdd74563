//! The further search for a shape's drive, from additional starts.

use strum::VariantArray;
use web_time::{Duration, Instant};

use crate::gauge::Gauge;
use crate::solver::shape::{FINE, OTHER_STEPS, Search, Start, Surroundings, value};
use crate::solver::{Excitation, Problem};

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
        let weights = self.objective.weights;
        self.ways[rival] = Some(self.begun(number, OTHER_STEPS));
        self.objective.weights = weights;
        self.renew(rival);
        for _ in 0..CALLS {
            if !self.run(rival, FINE.0) {
                break;
            }
        }
        if value(&self.ways[rival]) < value(&self.ways[self.leader]) {
            self.leader = rival;
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::acoustics::Aperture;
    use crate::scene::{Focus, Plane, Scene};
    use crate::solver::shape::best;

    /// A few foci of an array of this side.
    fn with_problem(side: u32, quiet: f64, work: impl FnOnce(&Problem<'_>, &Surroundings)) {
        let mut scene = Scene::default();
        (scene.array.rows, scene.array.columns) = (side, side);
        let aperture = Aperture::new(&scene);
        let focus = |x: f64| Focus::new(DVec3::new(x, 0.3 * x, 0.08), 1.0);
        let problem = Problem::new(&aperture, [-0.02, 0.0, 0.025].map(focus).to_vec());
        let plane = Plane { centre: DVec3::Z * 0.08, ..Plane::default() };
        work(&problem, &Surroundings::of_plane(plane, quiet));
    }

    #[test]
    fn a_further_start_is_descended_for_long_and_kept_if_it_ends_better() {
        with_problem(6, 0.5, |problem, surroundings| {
            let mut search = Search::new(problem, surroundings);
            // The strokes alone, then side lobes.
            assert!(search.advance().is_some() && search.advance().is_some());
            for number in 5..8 {
                let (before, best) = (search.steps, value(&search.ways[search.leader]));
                search.further(number);
                let done = search.steps - before;
                let most = OTHER_STEPS + CALLS * FINE.0;
                assert!(done > OTHER_STEPS + FINE.0 && done <= most, "{number}: {done} steps");
                let [first, second] = [0, 1].map(|way| value(&search.ways[way]));
                let leads = value(&search.ways[search.leader]);
                assert!(
                    leads <= best && leads <= first.min(second),
                    "{number}: {leads} of {first}, {second}"
                );
            }
        });
    }

    #[test]
    fn more_time_is_spent_on_further_starts() {
        with_problem(2, 0.0, |problem, surroundings| {
            let steps = |seconds| {
                best_within(problem, surroundings, Duration::from_secs_f64(seconds), &mut |_| {}).iterations
            };
            let alone = best(problem, surroundings).iterations;
            // On a busy machine the first start may take longer than the shortest time.
            assert!([0.02, 0.5, 10.0].into_iter().any(|seconds| steps(seconds) > alone), "{alone} steps");
        });
    }
}
