//! The loop from the desk to the board: the newest scene is solved, played, and reported.

use std::io;
use std::sync::Arc;

use web_time::{Duration, Instant};

use crate::control::beside::{Beside, Done, Found, Work};
use crate::control::board::{Board, Play};
use crate::control::desk::Desk;
use crate::control::edit::{Edit, Wish};
use crate::control::report::Report;
use crate::device::health::Health;
use crate::scene::{Scene, motion, outline};
use crate::solver::frames::Sequence;
use crate::solver::{self, Solution};
use crate::studio::posing::{is_shape, posed, posed_in_motion};

/// Polling interval of the board.
const TICK: Duration = Duration::from_millis(20);
/// Limit of foci times elements solved immediately, as in the window; more are solved in the background.
const AT_ONCE: usize = 120 * 256;
const AT_ONCE_OF_SHAPES: usize = 360 * 256;
/// After so long without a change a shape is searched on.
const IDLE: Duration = Duration::from_millis(200);

/// The loop's state: playback, solutions and reports.
#[derive(Debug)]
pub struct Live {
    desk: Arc<Desk>,
    board: Option<Board>,
    beside: Beside,
    /// The last solved scene and its result.
    solved: Option<(Scene, Result<Arc<Solution>, String>)>,
    /// The solution from which a drag continues.
    last: Option<Arc<Solution>>,
    frames: Option<(Scene, Result<Arc<Sequence>, String>)>,
    seen: u64,
    changed: Instant,
}

impl Live {
    /// # Errors
    /// No thread to be had.
    pub fn new(desk: Arc<Desk>, board: Option<Board>) -> io::Result<Self> {
        Ok(Self {
            desk,
            board,
            beside: Beside::start()?,
            solved: None,
            last: None,
            frames: None,
            seen: 0,
            changed: Instant::now(),
        })
    }

    /// Waits briefly for a change, and processes due work.
    pub fn turn(&mut self) {
        self.desk.wait(self.seen, TICK);
        if let Some(board) = &mut self.board {
            board.attend();
            // Only another send starts it again.
            if board.was_stopped() && self.desk.wish().0.sends {
                // It names no target, so it cannot be refused.
                let _ = self.desk.change(&[Edit::Send(false)]);
            }
        }
        let (wish, generation) = self.desk.wish();
        if generation != self.seen {
            (self.seen, self.changed) = (generation, Instant::now());
        }
        let scene = self.tuned(&wish.scene);
        self.collect();
        let is_solving = self.solve(&scene, &wish);
        let refused = self.play(&scene, &wish);
        let problem = refused.or_else(|| Some(self.solved.as_ref()?.1.as_ref().err()?.clone()));
        self.desk.tell(Report {
            serial: 0,
            generation,
            solution: self.solved.as_ref().and_then(|(_, solved)| solved.as_ref().ok().cloned()),
            wish: Some(wish),
            problem,
            is_solving,
            board: self.board.as_ref().map(Board::report),
        });
    }

    /// Closes the link, silencing the board; returns its final health.
    pub fn close(self) -> Option<Health> {
        self.board.map(Board::close)
    }

    /// The scene at the board's carrier, without further search.
    fn tuned(&self, scene: &Scene) -> Scene {
        let mut scene = scene.clone();
        scene.solver.search = 0.0;
        if let Some(carrier) = self.board.as_ref().map(Board::carrier) {
            scene.array.frequency = carrier;
        }
        scene
    }

    fn collect(&mut self) {
        match self.beside.collect() {
            Some(Done { scene, found: Found::Still(found) }) => {
                let found = found.map(|found| match &self.last {
                    Some(last) => Arc::new(Arc::unwrap_or_clone(found).turned_to(last)),
                    None => found,
                });
                let is_current = self.solved.as_ref().is_none_or(|(solved, _)| *solved == scene);
                // A first drive is better than none, even if outdated.
                if is_current || self.is_large() {
                    self.take(scene, found);
                }
            }
            Some(Done { scene, found: Found::Motion(found) }) => self.frames = Some((scene, found)),
            None => {}
        }
    }

    fn is_large(&self) -> bool {
        self.solved.as_ref().is_some_and(|(scene, _)| amount(scene).is_ok_and(|amount| amount > AT_ONCE))
    }

    fn take(&mut self, scene: Scene, found: Result<Arc<Solution>, String>) {
        if let Ok(found) = &found {
            self.last = Some(Arc::clone(found));
        }
        self.solved = Some((scene, found));
    }

    /// Solves; returns whether background work is running.
    fn solve(&mut self, scene: &Scene, wish: &Wish) -> bool {
        if scene.targets.is_empty() {
            (self.solved, self.frames) = (None, None);
            return false;
        }
        let posed = posed(scene);
        if self.solved.as_ref().is_none_or(|(solved, _)| *solved != posed) {
            let most = if is_shape(&posed) { AT_ONCE_OF_SHAPES } else { AT_ONCE };
            match amount(&posed) {
                Ok(amount) if amount > most => {
                    self.beside.ask(Work::Still(posed));
                    return true;
                }
                Ok(_) => {
                    let found = solver::solve_on(&posed, self.last.as_deref());
                    self.take(posed, found.map(Arc::new).map_err(|error| error.to_string()));
                }
                Err(problem) => self.take(posed, Err(problem)),
            }
        }
        let moving = (self.board.is_some() && wish.sends && wish.moves && motion::moves(scene))
            .then(|| posed_in_motion(scene));
        if let Some(moving) = moving
            && self.frames.as_ref().is_none_or(|(followed, _)| *followed != moving)
        {
            self.beside.ask(Work::Motion(moving));
            return true;
        }
        if let Some((solved, Ok(found))) = &self.solved
            && is_shape(solved)
            && found.figures.is_none()
            && self.changed.elapsed() > IDLE
        {
            // The quick result is improved in the background.
            self.beside.ask(Work::Still(solved.clone()));
        }
        self.beside.is_busy()
    }

    /// Plays the result; returns the reason if the board cannot.
    fn play(&mut self, scene: &Scene, wish: &Wish) -> Option<String> {
        let board = self.board.as_mut()?;
        if !wish.sends || scene.targets.is_empty() {
            board.stop();
            return None;
        }
        let play = if wish.moves && motion::moves(scene) {
            match &self.frames {
                Some((_, Ok(sequence))) => Play::Motion(Arc::clone(sequence)),
                Some((_, Err(problem))) => {
                    board.stop();
                    return Some(problem.clone());
                }
                // They are being solved.
                None => return None,
            }
        } else {
            match &self.solved {
                Some((_, Ok(solution))) => Play::Still(Arc::clone(solution)),
                Some((_, Err(_))) | None => {
                    board.stop();
                    return None;
                }
            }
        };
        board.play(scene, play).err()
    }
}

/// Foci times elements.
fn amount(scene: &Scene) -> Result<usize, String> {
    let foci = outline::foci(scene).map_err(|error| error.to_string())?;
    Ok(foci.len() * scene.elements())
}
