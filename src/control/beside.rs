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
