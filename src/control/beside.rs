//! Background solving: the latest request is solved; outdated requests are cancelled.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};

use web_time::{Duration, Instant};

use crate::control::desk::Desk;
use crate::gauge::{Cancel, Gauge};
use crate::scene::Scene;
use crate::solver::Solution;
use crate::studio::solving::{self, Followed, Solved};

/// A drive that is found within this time is used although a newer scene waits for the thread: otherwise a fast stream
/// of scenes would have no drives at all.
const GRACE: Duration = Duration::from_millis(200);
/// Limits of the time of iterations, of which clients choose the number: of a scene at rest, and of all frames.
const ITERATING: Duration = Duration::from_secs(5);
const ITERATING_IN_MOTION: Duration = Duration::from_secs(60);
/// Results of one piece of work that wait until they are collected.
const KEPT: usize = 16;

/// Work to be solved.
#[derive(Clone, Debug, PartialEq)]
pub enum Work {
    /// A scene at rest, in the time of a drag's frame.
    Quick(Scene),
    /// A scene at rest, with its full method.
    Full(Scene),
    /// All frames of a motion.
    Motion(Scene),
}

/// The result of work.
#[derive(Debug)]
pub enum Found {
    Still(Scene, Solved),
    Motion(Scene, Followed),
}

#[derive(Debug)]
struct Running {
    work: Work,
    cancel: Cancel,
    since: Instant,
    found: Receiver<Found>,
}

/// The work for a desk, each on a thread. When this is dropped, it is cancelled.
#[derive(Debug)]
pub struct Beside {
    desk: Arc<Desk>,
    running: Option<Running>,
}

impl Beside {
    /// Wakes the loop of `desk` after every result, and at the end of work.
    pub fn new(desk: Arc<Desk>) -> Self {
        Self { desk, running: None }
    }

    /// Requests this work instead of any other; quick work continues from the drive `before`. Repeat the request until
    /// the result has come: other work is cancelled once its time is over, and ends first.
    pub fn want(&mut self, work: Option<&Work>, before: Option<&Arc<Solution>>) {
        if let Some(running) = &self.running {
            if work != Some(&running.work) && (work.is_none() || running.since.elapsed() > GRACE) {
                running.cancel.cancel();
            }
            return;
        }
        let Some(work) = work.cloned() else { return };
        let (sender, found) = sync_channel(KEPT);
        let running = Running { work, cancel: Cancel::default(), since: Instant::now(), found };
        let (work, gauge) = (running.work.clone(), Gauge::default().until(&running.cancel));
        let (before, desk) = (before.cloned(), Arc::clone(&self.desk));
        let run = move || {
            solve(work, before.as_deref(), &gauge, &mut |found| {
                // The owner may be gone.
                let _ = sender.send(found);
                desk.bring_news();
            });
            drop(sender);
            desk.bring_news();
        };
        // Without a thread, the next call tries again.
        let started = std::thread::Builder::new().name("solve".to_owned()).spawn(run);
        self.running = started.is_ok().then_some(running);
    }

    /// The next result.
    pub fn collect(&mut self) -> Option<Found> {
        let running = self.running.as_ref()?;
        match running.found.try_recv() {
            Ok(found) => Some(found).filter(|_| !running.cancel.is_cancelled()),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => {
                self.running = None;
                None
            }
        }
    }
}

impl Drop for Beside {
    fn drop(&mut self) {
        self.running.iter().for_each(|running| running.cancel.cancel());
    }
}

/// Solves, and reports; fewer drives in turn are of use until all are there.
fn solve(work: Work, before: Option<&Solution>, gauge: &Gauge, report: &mut dyn FnMut(Found)) {
    let at_rest = gauge.clone().iterating_for(ITERATING);
    let found = match work {
        Work::Quick(scene) => {
            let solved = at_rest.lead(|| solving::solve_quickly(&scene, before));
            Found::Still(scene, solved)
        }
        Work::Full(scene) => {
            let mut so_far = |found| report(Found::Still(scene.clone(), found));
            let solved = at_rest.lead(|| solving::solve(&scene, &mut so_far));
            Found::Still(scene, solved)
        }
        Work::Motion(scene) => {
            let followed = gauge.clone().iterating_for(ITERATING_IN_MOTION).lead(|| solving::follow(&scene));
            Found::Motion(scene, followed)
        }
    };
    report(found);
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::scene::{Method, Shape, Target};
    use crate::solver;

    /// Upper limit of every wait, for slow machines.
    const PATIENCE: Duration = Duration::from_secs(60);

    fn point(height: f64) -> Scene {
        Scene { targets: vec![Target::new(Shape::Point { at: DVec3::Z * height })], ..Scene::default() }
    }

    /// A scene that takes minutes.
    fn slow() -> Scene {
        let mut scene = point(0.1);
        (scene.solver.method, scene.solver.search) = (Method::Best, 600.0);
        scene
    }

    fn started() -> Beside {
        Beside::new(Arc::new(Desk::new(Arc::default(), Box::new(|| {}))))
    }

    /// Wants work until it is done, as the loop does.
    fn solved(beside: &mut Beside, work: &Work, before: Option<&Arc<Solution>>) -> Found {
        let begun = Instant::now();
        while begun.elapsed() < PATIENCE {
            beside.want(Some(work), before);
            beside.desk.wait(beside.desk.generation(), Duration::from_millis(5));
            if let Some(found) = beside.collect() {
                return found;
            }
        }
        panic!("not solved: {work:?}")
    }

    #[test]
    fn the_newest_scene_is_solved_before_a_slow_one() {
        let mut beside = started();
        for _ in 0..2 {
            beside.want(Some(&Work::Full(slow())), None);
            let found = solved(&mut beside, &Work::Full(point(0.12)), None);
            assert!(matches!(&found, Found::Still(scene, Ok(_)) if *scene == point(0.12)), "{found:?}");
            // What was cancelled is begun anew.
        }
    }

    #[test]
    fn unwanted_work_and_a_dropped_owners_is_cancelled() {
        let mut beside = started();
        for _ in 0..2 {
            beside.want(Some(&Work::Full(slow())), None);
            beside.want(None, None);
            let begun = Instant::now();
            while beside.running.is_some() {
                assert!(begun.elapsed() < PATIENCE, "still solved");
                assert!(beside.collect().is_none());
                std::thread::yield_now();
            }
        }
        beside.want(Some(&Work::Full(slow())), None);
        let desk = Arc::clone(&beside.desk);
        drop(beside);
        let begun = Instant::now();
        while Arc::strong_count(&desk) > 1 {
            assert!(begun.elapsed() < PATIENCE, "still solved");
            std::thread::yield_now();
        }
    }

    #[test]
    fn quick_work_goes_on_from_the_drive_before() {
        let mut beside = started();
        let shape = |radius: f64| Scene {
            targets: vec![Target::new(Shape::Circle { at: DVec3::Z * 0.1, radius })],
            ..Scene::default()
        };
        let mut solution = |radius, before| match solved(&mut beside, &Work::Quick(shape(radius)), before) {
            Found::Still(_, Ok(solution)) => solution,
            other => panic!("no drive: {other:?}"),
        };
        let first = solution(0.02, None);
        let second = solution(0.021, Some(&first));
        let expected = solver::solve_on(&shape(0.021), Some(&first)).unwrap();
        assert_eq!(second.drive, expected.drive);
    }
}
