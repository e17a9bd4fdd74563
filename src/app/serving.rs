//! Live control of the document by other programs: changes are applied before a frame, and results reported after
//! it.
//!
//! Remote changes are merged into the document target by target, and a burst of them is one undo step.

use std::sync::Arc;

use eframe::egui::Context;
use web_time::{Duration, Instant};

use crate::control::desk::Desk;
use crate::control::edit::Wish;
use crate::control::report::{BoardReport, Report};
use crate::control::server::{Server, ServerError, Settings};
use crate::scene::{Scene, Target, motion};
use crate::ui::board::{BoardCommand, Plays};
use crate::ui::{Command, Editor, Notice, ServingShown, Shown};

/// Time after the last remote change at which a burst ends, and becomes one undo step.
const BURST: Duration = Duration::from_millis(700);
/// Polling interval of the counts.
const LOOK: Duration = Duration::from_secs(1);

#[derive(Debug, Default)]
pub struct Serving(Option<Open>);

#[derive(Debug)]
struct Open {
    server: Server,
    /// Last scene common to user and clients: the base of merges.
    base: Arc<Scene>,
    generation: u64,
    /// The last remote wishes for the board.
    wished: (bool, bool),
    stops: u64,
    burst: Option<Instant>,
}

impl Serving {
    /// Begins or ends to listen.
    pub fn switch(
        &mut self,
        on: bool,
        editor: &Editor,
        shown: &mut Shown,
        silence: Box<dyn Fn() + Send + Sync>,
        ctx: &Context,
    ) {
        self.0 = None;
        shown.serving = None;
        if !on {
            return;
        }
        let base = Arc::new(editor.scene().clone());
        match started(&base, ctx) {
            Ok(server) => {
                server.desk().silence_by(silence);
                let addresses = server.addresses().lines();
                shown.serving = Some(ServingShown { addresses, ..ServingShown::default() });
                let wished = wished(&server.desk().wish().0);
                self.0 = Some(Open { server, base, generation: 0, wished, stops: 0, burst: None });
            }
            Err(error) => shown.notice = Some(Notice { text: error.to_string(), is_error: true }),
        }
    }

    /// Applies remote changes to the document, and publishes the user's.
    pub fn exchange(&mut self, editor: &mut Editor, shown: &Shown, ctx: &Context) {
        let Some(open) = &mut self.0 else { return };
        ctx.request_repaint_after(LOOK);
        let desk = Arc::clone(open.server.desk());
        let (wish, generation) = desk.wish();
        if generation != open.generation && *wish.scene != *open.base {
            if open.burst.is_none() && !editor.is_in_gesture() {
                // The user's earlier edits are a separate undo step.
                editor.document.settle();
            }
            open.burst = Some(Instant::now());
            editor.take(merged(&open.base, &wish.scene, editor.scene()));
        }
        let asks = wished(&wish);
        let is_stopped = wish.stops != open.stops;
        let is_new = generation != open.generation && (asks != open.wished || is_stopped);
        if is_stopped || (is_new && !wish.sends) {
            editor.asked_by_others.push(Command::Board(BoardCommand::Stop));
        }
        if is_new && wish.sends {
            let moves = wish.moves && motion::moves(editor.scene());
            let command = if moves { BoardCommand::PlayMotion } else { BoardCommand::Send };
            editor.asked_by_others.push(Command::Board(command));
        }
        open.stops = wish.stops;
        open.generation = generation;
        let sends = matches!(shown.board.plays, Plays::Scene | Plays::Motion);
        // A new wish is not yet played.
        let sends = if asks == open.wished { sends } else { wish.sends };
        open.wished = (sends, wish.moves);
        open.base = match *editor.scene() == *wish.scene {
            true => Arc::clone(&wish.scene),
            false => Arc::new(editor.scene().clone()),
        };
        let own = Wish { scene: Arc::clone(&open.base), sends, ..wish.clone() };
        // If others were faster, the next frame merges.
        if own != wish
            && let Some(generation) = desk.put(generation, own)
        {
            open.generation = generation;
        }
    }

    /// Reports the frame's results to clients.
    pub fn tell(&mut self, editor: &Editor, shown: &mut Shown) {
        let Some(open) = &self.0 else { return };
        let desk = open.server.desk();
        let sends = matches!(shown.board.plays, Plays::Scene | Plays::Motion);
        let health = shown.board.health.clone();
        desk.tell(Report {
            serial: 0,
            generation: open.generation,
            solved: open.generation,
            wish: Some(Wish { moves: open.wished.1, sends, ..Wish::new(Arc::clone(&open.base)) }),
            solution: shown.solution.clone(),
            problem: shown.problem.clone(),
            is_solving: shown.pending.is_some(),
            board: health.map(|health| BoardReport {
                port: editor.board.port().to_owned(),
                profile: editor.board.profile.name(),
                health,
            }),
        });
        let tally = desk.counts.tally();
        if let Some(serving) = &mut shown.serving {
            serving.packets = tally.packets;
            serving.changes = tally.changes;
            serving.refused = tally.refused + tally.malformed + tally.strangers;
        }
    }

    /// Whether a burst of remote changes is not yet complete.
    pub fn is_in_burst(&mut self, ctx: &Context) -> bool {
        let Some(burst) = self.0.as_mut().map(|open| &mut open.burst) else { return false };
        let Some(rest) = burst.and_then(|since| BURST.checked_sub(since.elapsed())) else {
            *burst = None;
            return false;
        };
        ctx.request_repaint_after(rest);
        true
    }
}

fn wished(wish: &Wish) -> (bool, bool) {
    (wish.sends, wish.moves)
}

/// On the default ports, or on free ones if these are taken.
fn started(scene: &Arc<Scene>, ctx: &Context) -> Result<Server, ServerError> {
    let desk = || {
        let ctx = ctx.clone();
        Arc::new(Desk::new(Arc::clone(scene), Box::new(move || ctx.request_repaint())))
    };
    let free = Settings { osc: Some(0), websocket: Some(0), ..Settings::default() };
    Server::start(Settings::default(), desk()).or_else(|_| Server::start(free, desk()))
}

/// Merges both changes of a scene. If both changed the same table or target, others win: the user sees it and can
/// undo it.
fn merged(base: &Scene, theirs: &Scene, own: &Scene) -> Scene {
    fn newer<T: PartialEq + Clone>(base: &T, theirs: &T, own: &T) -> T {
        if theirs == base { own.clone() } else { theirs.clone() }
    }
    let Scene {
        format,
        drive,
        medium,
        array,
        boards,
        reflectors,
        bodies,
        targets,
        quiet,
        solver,
        plane,
        liquid,
        bead,
        skin,
        modulation,
        motion,
        listener,
    } = base;
    Scene {
        format: *format,
        drive: newer(drive, &theirs.drive, &own.drive),
        medium: newer(medium, &theirs.medium, &own.medium),
        array: newer(array, &theirs.array, &own.array),
        boards: newer(boards, &theirs.boards, &own.boards),
        reflectors: newer(reflectors, &theirs.reflectors, &own.reflectors),
        bodies: newer(bodies, &theirs.bodies, &own.bodies),
        targets: targets_of(targets, &theirs.targets, &own.targets),
        quiet: newer(quiet, &theirs.quiet, &own.quiet),
        solver: newer(solver, &theirs.solver, &own.solver),
        plane: newer(plane, &theirs.plane, &own.plane),
        liquid: newer(liquid, &theirs.liquid, &own.liquid),
        bead: newer(bead, &theirs.bead, &own.bead),
        skin: newer(skin, &theirs.skin, &own.skin),
        modulation: newer(modulation, &theirs.modulation, &own.modulation),
        motion: newer(motion, &theirs.motion, &own.motion),
        listener: newer(listener, &theirs.listener, &own.listener),
    }
}

/// One by one, if none was added or removed.
fn targets_of(base: &[Target], theirs: &[Target], own: &[Target]) -> Vec<Target> {
    if theirs == base {
        return own.to_vec();
    }
    if base.len() != theirs.len() || base.len() != own.len() {
        return theirs.to_vec();
    }
    let newer = |((base, theirs), own): ((&Target, &Target), &Target)| {
        if theirs == base { own.clone() } else { theirs.clone() }
    };
    base.iter().zip(theirs).zip(own).map(newer).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::file;

    #[test]
    fn what_the_user_and_others_change_at_once_is_both_there() {
        let base = file::parse("format = 1\n[[target]]\n[[target]]\n", "a.toml".as_ref()).unwrap();
        let (mut theirs, mut own) = (base.clone(), base.clone());
        theirs.targets[1].pressure = 2.0;
        theirs.modulation.frequency = 100.0;
        own.targets[0].pressure = 3.0;
        own.plane.size.x = 0.1;
        own.modulation.frequency = 50.0;
        let both = merged(&base, &theirs, &own);
        assert_eq!((both.targets[0].pressure, both.targets[1].pressure), (3.0, 2.0));
        assert_eq!((both.plane.size.x, both.modulation.frequency), (0.1, 100.0));
        theirs.targets.pop();
        assert_eq!(merged(&base, &theirs, &own).targets, theirs.targets);
        assert_eq!(merged(&base, &base, &own), own);
    }
}
