//! The loop from the desk to the board: the newest scene is solved on a thread, played, and reported.

use std::sync::Arc;

use web_time::{Duration, Instant};

use crate::control::beside::{Beside, Found, Work};
use crate::control::board::Board;
use crate::control::desk::Desk;
use crate::control::edit::{Edit, Wish};
use crate::control::report::Report;
use crate::device::health::Health;
use crate::scene::{Scene, motion};
use crate::studio::performance::Performance;
use crate::studio::posing::{posed, posed_in_motion};
use crate::studio::solving::{Followed, Solving, Step};

/// Polling interval of the board.
const TICK: Duration = Duration::from_millis(20);
/// Wait of a turn for a drive, so that the report of a scene has it.
const BRIEF: Duration = Duration::from_millis(20);
/// Time without a change after which the search for a shape continues.
const IDLE: Duration = Duration::from_millis(200);

/// The loop's state: playback, solutions and reports. It never solves itself, so that silence never waits.
#[derive(Debug)]
pub struct Live {
    desk: Arc<Desk>,
    board: Option<Board>,
    beside: Beside,
    solving: Solving,
    frames: Option<(Scene, Followed)>,
    seen: u64,
    changed: Instant,
}

impl Live {
    pub fn new(desk: Arc<Desk>, board: Option<Board>) -> Self {
        if let Some(board) = &board {
            desk.silence_by(board.silencer());
        }
        Self {
            beside: Beside::new(Arc::clone(&desk)),
            desk,
            board,
            solving: Solving::default(),
            frames: None,
            seen: 0,
            changed: Instant::now(),
        }
    }

    /// Waits briefly for a change, and processes due work.
    pub fn turn(&mut self) {
        self.desk.wait(self.seen, TICK);
        if let Some(board) = &mut self.board {
            // Only another send starts it again.
            if board.attend() && self.desk.wish().0.sends {
                // It names no target, so it cannot be refused.
                let _ = self.desk.change(&[Edit::Send(false)]);
            }
        }
        let (wish, generation) = self.desk.wish();
        if generation != self.seen {
            (self.seen, self.changed) = (generation, Instant::now());
        }
        let scene = self.tuned(&wish.scene);
        let mut work = self.solve(&scene, &wish);
        if matches!(work, Some(Work::Quick(_))) {
            self.desk.wait(generation, BRIEF);
            work = self.solve(&scene, &wish);
        }
        let refused = self.play(&scene, &wish);
        let found = self.solving.solved.as_ref().map(|(_, solved)| solved.clone());
        let problem = refused.or_else(|| found.clone()?.err());
        let is_quick_pending = matches!(work, Some(Work::Quick(_)));
        let solved = if is_quick_pending { self.desk.report().solved } else { generation };
        self.desk.tell(Report {
            serial: 0,
            generation,
            solved,
            solution: found.and_then(Result::ok),
            wish: Some(wish),
            problem,
            is_solving: work.is_some(),
            board: self.board.as_ref().map(Board::report),
        });
    }

    /// Closes the link, silencing the board; returns its final health.
    pub fn close(self) -> Option<Health> {
        self.board.map(Board::close)
    }

    /// The scene as the board can play it, without further search.
    fn tuned(&mut self, scene: &Scene) -> Scene {
        let mut scene = scene.clone();
        scene.solver.search = 0.0;
        if let Some(board) = &mut self.board {
            board.tune(&mut scene);
        }
        scene
    }

    /// Takes solved work, and requests missing work.
    fn solve(&mut self, scene: &Scene, wish: &Wish) -> Option<Work> {
        while let Some(found) = self.beside.collect() {
            match found {
                Found::Still(scene, found) => self.solving.take(&scene, found),
                Found::Motion(scene, found) => self.frames = Some((scene, found)),
            }
        }
        let work = self.unsolved(scene, wish);
        self.beside.want(work.as_ref(), self.solving.last.as_ref());
        work
    }

    /// The most urgent work.
    fn unsolved(&mut self, scene: &Scene, wish: &Wish) -> Option<Work> {
        if !scene.has_drive() {
            self.solving.clear();
            self.frames = None;
            return None;
        }
        let posed = posed(scene);
        let step = self.solving.next(&posed, self.changed.elapsed() > IDLE);
        if step == Some(Step::Quick) {
            return Some(Work::Quick(posed));
        }
        if self.board.is_some() && wish.sends && wish.moves && motion::moves(scene) {
            let moving = posed_in_motion(scene);
            if self.frames.as_ref().is_none_or(|(followed, _)| *followed != moving) {
                return Some(Work::Motion(moving));
            }
        }
        step.map(|_| Work::Full(posed))
    }

    /// Plays the result; returns the reason if the board cannot.
    fn play(&mut self, scene: &Scene, wish: &Wish) -> Option<String> {
        let board = self.board.as_mut()?;
        if !wish.sends || !scene.has_drive() {
            board.stop();
            return None;
        }
        // While a scene is solved, the board plays the one before, if it has the same elements.
        let fits = |before: &Scene| before.elements() == scene.elements();
        let performance = if wish.moves && motion::moves(scene) {
            match self.frames.as_ref().filter(|(before, _)| fits(before)) {
                Some((_, Ok(sequence))) => Performance::Motion(Arc::clone(sequence)),
                Some((_, Err(problem))) => {
                    board.stop();
                    return Some(problem.clone());
                }
                // They are being solved.
                None => return None,
            }
        } else {
            match self.solving.solved.as_ref().filter(|(before, _)| fits(before)) {
                Some((_, Ok(solution))) => Performance::Still(Arc::clone(solution)),
                Some((_, Err(_))) | None => {
                    board.stop();
                    return None;
                }
            }
        };
        board.play(scene, performance).err()
    }
}
