//! Background solving: a thread solves what is wanted last; what is wanted no longer is cancelled.

use std::io;
use std::sync::Arc;

use web_time::{Duration, Instant};

use crate::device::task::{Watched, finish};
use crate::gauge::{Cancel, Gauge};
use crate::scene::Scene;
use crate::solver::frames::{self, Sequence};
use crate::solver::{self, Solution};

/// A drive that is found within this time is used although a newer scene waits for the thread: otherwise a fast stream
/// of scenes would have no drives at all.
const GRACE: Duration = Duration::from_millis(200);
/// Limits of the time of iterations, of which clients choose the number: of a scene at rest, and of all frames.
const ITERATING: Duration = Duration::from_secs(5);
const ITERATING_IN_MOTION: Duration = Duration::from_secs(60);

/// Work to be solved.
#[derive(Clone, Debug, PartialEq)]
pub enum Work {
    /// A scene at rest, in the time of a drag's frame.
    Quick(Scene),
    /// A scene at rest, with its full method.
    Still(Scene),
    /// All frames of a motion.
    Motion(Scene),
}

/// The result for a scene.
#[derive(Debug)]
pub struct Done {
    pub scene: Scene,
    pub found: Found,
}

#[derive(Debug)]
pub enum Found {
    Still(Result<Arc<Solution>, String>),
    Motion(Result<Arc<Sequence>, String>),
}

#[derive(Debug)]
struct Running {
    work: Work,
    cancel: Cancel,
    since: Instant,
}

impl Running {
    fn is(&self, work: &Work) -> bool {
        self.work == *work && !self.cancel.is_cancelled()
    }
}

#[derive(Debug, Default)]
struct Held {
    next: Option<Work>,
    /// The drive from which quick work goes on.
    before: Option<Arc<Solution>>,
    running: Option<Running>,
    done: Option<Done>,
    closing: bool,
}

/// The thread. When this is dropped, its work is cancelled and it ends.
#[derive(Debug)]
pub struct Beside(Arc<Watched<Held>>);

impl Beside {
    /// `tell` is called after every result.
    ///
    /// # Errors
    /// No thread to be had.
    pub fn start(tell: impl Fn() + Send + 'static) -> io::Result<Self> {
        let held = Arc::new(Watched::new(Held::default()));
        let its = Arc::clone(&held);
        let work = move || work(&its, &tell);
        std::thread::Builder::new().name("solve".to_owned()).spawn(work)?;
        Ok(Self(held))
    }

    /// From now on only this is wanted. Ask again until it is there: other work is cancelled once its time is over.
    pub fn want(&self, work: Option<Work>, before: Option<&Arc<Solution>>) {
        let mut held = self.0.lock();
        if let Some(running) = &held.running {
            if work.as_ref().is_some_and(|work| running.is(work)) {
                held.next = None;
                return;
            }
            if work.is_none() || running.since.elapsed() > GRACE {
                running.cancel.cancel();
            }
        }
        (held.next, held.before) = (work, before.cloned());
        drop(held);
        self.0.ring();
    }

    /// The last result, once.
    pub fn collect(&self) -> Option<Done> {
        self.0.lock().done.take()
    }
}

impl Drop for Beside {
    fn drop(&mut self) {
        let mut held = self.0.lock();
        held.closing = true;
        held.running.iter().for_each(|running| running.cancel.cancel());
        drop(held);
        self.0.ring();
    }
}

fn work(held: &Watched<Held>, tell: &dyn Fn()) {
    loop {
        finish(held.wait_while(Duration::MAX, |held| held.next.is_none() && !held.closing));
        let mut now = held.lock();
        if now.closing {
            return;
        }
        let Some(next) = now.next.take() else { continue };
        let (before, cancel) = (now.before.take(), Cancel::default());
        now.running = Some(Running { work: next.clone(), cancel: cancel.clone(), since: Instant::now() });
        drop(now);
        // Fewer drives in turn are of use until all are there.
        let mut report = |done| {
            if !cancel.is_cancelled() {
                held.lock().done = Some(done);
                tell();
            }
        };
        let done = solved(next, before.as_deref(), &Gauge::default().until(&cancel), &mut report);
        let mut now = held.lock();
        now.running = None;
        if !cancel.is_cancelled() {
            now.done = Some(done);
            drop(now);
            tell();
        }
    }
}

fn solved(work: Work, before: Option<&Solution>, gauge: &Gauge, report: &mut dyn FnMut(Done)) -> Done {
    let text = |error: solver::SolveError| error.to_string();
    let at_rest = |solve: &mut dyn FnMut() -> Result<Solution, solver::SolveError>| {
        Found::Still(gauge.clone().iterating_for(ITERATING).lead(solve).map(Arc::new).map_err(text))
    };
    match work {
        Work::Quick(scene) => Done { found: at_rest(&mut || solver::solve_on(&scene, before)), scene },
        Work::Still(scene) => {
            let mut so_far = |found: Solution| {
                report(Done { scene: scene.clone(), found: Found::Still(Ok(Arc::new(found))) });
            };
            Done { found: at_rest(&mut || solver::solve_with(&scene, &mut so_far)), scene }
        }
        Work::Motion(scene) => {
            let followed = frames::follow_with(&scene, &gauge.clone().iterating_for(ITERATING_IN_MOTION));
            Done { scene, found: Found::Motion(followed.map(Arc::new).map_err(text)) }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};

    use glam::DVec3;

    use super::*;
    use crate::scene::{Method, Shape, Target};

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

    fn started() -> (Beside, Receiver<()>) {
        let (sender, told) = sync_channel(100);
        (Beside::start(move || sender.send(()).unwrap_or_default()).unwrap(), told)
    }

    /// Wants work until it is done, as the loop does.
    fn solved(beside: &Beside, told: &Receiver<()>, work: &Work) -> Done {
        let begun = Instant::now();
        while begun.elapsed() < PATIENCE {
            beside.want(Some(work.clone()), None);
            if told.recv_timeout(Duration::from_millis(5)).is_ok()
                && let Some(done) = beside.collect()
            {
                return done;
            }
        }
        panic!("not solved: {work:?}")
    }

    fn is_running(beside: &Beside, work: &Work) -> bool {
        beside.0.lock().running.as_ref().is_some_and(|running| running.is(work))
    }

    #[test]
    fn the_newest_scene_is_solved_before_a_slow_one() {
        let (beside, told) = started();
        for _ in 0..2 {
            let slow = Work::Still(slow());
            beside.want(Some(slow.clone()), None);
            while !is_running(&beside, &slow) {
                std::thread::yield_now();
            }
            let done = solved(&beside, &told, &Work::Still(point(0.12)));
            assert!(done.scene == point(0.12) && matches!(done.found, Found::Still(Ok(_))), "{done:?}");
            // What was cancelled is begun anew.
        }
    }

    #[test]
    fn unwanted_work_and_a_dropped_owners_is_cancelled() {
        let (beside, told) = started();
        let slow = Work::Still(slow());
        for _ in 0..2 {
            beside.want(Some(slow.clone()), None);
            while !is_running(&beside, &slow) {
                std::thread::yield_now();
            }
            beside.want(None, None);
            let begun = Instant::now();
            while beside.0.lock().running.is_some() {
                assert!(begun.elapsed() < PATIENCE, "still solved");
                std::thread::yield_now();
            }
            assert!(beside.collect().is_none());
        }
        beside.want(Some(slow.clone()), None);
        while !is_running(&beside, &slow) {
            std::thread::yield_now();
        }
        drop(beside);
        let ended = told.recv_timeout(PATIENCE);
        assert_eq!(ended, Err(RecvTimeoutError::Disconnected), "its thread ends, and tells of nothing");
    }

    #[test]
    fn quick_work_goes_on_from_the_drive_before() {
        let (beside, told) = started();
        let shape = |radius: f64| Scene {
            targets: vec![Target::new(Shape::Circle { at: DVec3::Z * 0.1, radius })],
            ..Scene::default()
        };
        let Found::Still(Ok(first)) = solved(&beside, &told, &Work::Quick(shape(0.02))).found else {
            panic!("no drive")
        };
        let moved = Work::Quick(shape(0.021));
        beside.want(Some(moved), Some(&first));
        told.recv_timeout(PATIENCE).unwrap();
        let Some(Done { found: Found::Still(Ok(second)), .. }) = beside.collect() else { panic!("no drive") };
        let expected = solver::solve_on(&shape(0.021), Some(&first)).unwrap();
        assert_eq!(second.drive, expected.drive);
    }
}
