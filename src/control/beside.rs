//! Background solving: the newest request is solved on a thread, superseded requests are dropped.

use std::io;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use web_time::Duration;

use crate::device::task::{Watched, finish};
use crate::scene::Scene;
use crate::solver::frames::{self, Sequence};
use crate::solver::{self, Solution};

/// Work to be solved.
#[derive(Clone, Debug, PartialEq)]
pub enum Work {
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

#[derive(Debug, Default)]
struct Held {
    next: Option<Work>,
    running: Option<Work>,
    closing: bool,
}

/// The thread, which ends after its current work when this is dropped.
#[derive(Debug)]
pub struct Beside {
    held: Arc<Watched<Held>>,
    done: Receiver<Done>,
}

impl Beside {
    /// # Errors
    /// No thread to be had.
    pub fn start() -> io::Result<Self> {
        let held = Arc::new(Watched::new(Held::default()));
        let (sender, done) = sync_channel(1);
        let its = Arc::clone(&held);
        std::thread::Builder::new().name("solve".to_owned()).spawn(move || work(&its, &sender))?;
        Ok(Self { held, done })
    }

    /// Requests this work, unless it is already running.
    pub fn ask(&self, work: Work) {
        let mut held = self.held.lock();
        if held.running.as_ref() == Some(&work) {
            held.next = None;
            return;
        }
        held.next = Some(work);
        drop(held);
        self.held.ring();
    }

    pub fn is_busy(&self) -> bool {
        let held = self.held.lock();
        held.running.is_some() || held.next.is_some()
    }

    /// The finished result, once.
    pub fn collect(&self) -> Option<Done> {
        self.done.try_recv().ok()
    }
}

impl Drop for Beside {
    fn drop(&mut self) {
        self.held.lock().closing = true;
        self.held.ring();
    }
}

fn work(held: &Watched<Held>, done: &SyncSender<Done>) {
    loop {
        finish(held.wait_while(Duration::MAX, |held| held.next.is_none() && !held.closing));
        let mut now = held.lock();
        if now.closing {
            return;
        }
        let Some(next) = now.next.take() else { continue };
        now.running = Some(next.clone());
        drop(now);
        let result = match next {
            Work::Still(scene) => {
                let solved = solver::solve(&scene).map(Arc::new).map_err(|error| error.to_string());
                Done { scene, found: Found::Still(solved) }
            }
            Work::Motion(scene) => {
                let followed = frames::follow(&scene).map(Arc::new).map_err(|error| error.to_string());
                Done { scene, found: Found::Motion(followed) }
            }
        };
        // A failure means that the receiver is gone.
        if done.send(result).is_err() {
            return;
        }
        held.lock().running = None;
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::RecvTimeoutError;

    use glam::DVec3;

    use super::*;
    use crate::scene::{Shape, Target};

    /// Upper limit of every wait, for slow machines.
    const PATIENCE: Duration = Duration::from_secs(20);

    fn point(height: f64) -> Scene {
        Scene { targets: vec![Target::new(Shape::Point { at: DVec3::Z * height })], ..Scene::default() }
    }

    #[test]
    fn the_newest_request_is_busy_from_its_asking_until_it_is_solved() {
        // No thread, so that nothing is solved meanwhile.
        let beside = Beside { held: Arc::new(Watched::new(Held::default())), done: sync_channel(1).1 };
        let [old, new] = [0.1, 0.2].map(|height| Work::Still(point(height)));
        assert!(!beside.is_busy());
        beside.ask(old.clone());
        beside.ask(new.clone());
        assert!(beside.is_busy(), "before it is begun");
        let next = beside.held.lock().next.take();
        assert_eq!(next, Some(new.clone()));
        beside.held.lock().running = next;
        assert!(beside.is_busy(), "while it is solved");
        beside.ask(old);
        beside.ask(new);
        assert_eq!(beside.held.lock().next, None, "it is running already");
        beside.held.lock().running = None;
        assert!(!beside.is_busy());
    }

    #[test]
    fn the_thread_solves_and_ends_with_its_owner() {
        // Many times, since its end may come before the thread waits, which is then not woken.
        for _ in 0..30 {
            let mut beside = Beside::start().unwrap();
            let done = std::mem::replace(&mut beside.done, sync_channel(1).1);
            beside.ask(Work::Still(point(0.1)));
            let Done { scene, found } = done.recv_timeout(PATIENCE).unwrap();
            assert!(scene == point(0.1) && matches!(found, Found::Still(Ok(_))), "{found:?}");
            drop(beside);
            assert_eq!(done.recv_timeout(PATIENCE).unwrap_err(), RecvTimeoutError::Disconnected);
        }
    }

    #[test]
    fn a_thread_that_was_ended_before_it_waits_does_not_wait() {
        let held = Watched::new(Held { closing: true, ..Held::default() });
        let (sender, done) = sync_channel(1);
        std::thread::Builder::new().name("solve".to_owned()).spawn(move || work(&held, &sender)).unwrap();
        assert_eq!(done.recv_timeout(PATIENCE).unwrap_err(), RecvTimeoutError::Disconnected);
    }
}
