//! Reports of the played scene to other programs.

use std::sync::Arc;

use glam::DVec3;
use serde_json::{Value, json};

use crate::control::counts::Tally;
use crate::control::edit::Wish;
use crate::device::health::{Health, State};
use crate::echo;
use crate::scene::{Focus, motion};
use crate::solver::Solution;

/// Targets and foci of an answer, at most.
const MOST: usize = 1024;

/// A board and its state.
#[derive(Clone, Debug, PartialEq)]
pub struct BoardReport {
    pub port: String,
    pub profile: &'static str,
    pub health: Health,
}

impl BoardReport {
    /// `ready`, `connecting`, or why it is lost.
    pub fn words(&self) -> String {
        match &self.health.state {
            State::Connecting => "connecting".to_owned(),
            State::Ready => "ready".to_owned(),
            State::Lost(why) => echo::message(&format!("lost: {why}")),
        }
    }
}

/// The result of the latest wish.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// Grows with every report that has something new in it.
    pub serial: u64,
    /// Generation of the wish.
    pub generation: u64,
    /// Generation of the latest solved wish.
    pub solved: u64,
    pub wish: Option<Wish>,
    pub solution: Option<Arc<Solution>>,
    /// The reason for a missing drive, or for a silent board.
    pub problem: Option<String>,
    /// Something of this wish is still being solved.
    pub is_solving: bool,
    pub board: Option<BoardReport>,
}

impl Report {
    /// Positions (m) and pressures (Pa, peak).
    pub fn foci(&self) -> Vec<(DVec3, f64)> {
        let pairs = self.solution.iter().flat_map(|found| found.foci.iter().zip(&found.pressures));
        pairs.map(|(focus, pressure)| (focus.position, pressure.norm())).collect()
    }

    /// Whether its wish or drive differs from an earlier report's.
    pub fn tells_more_than(&self, before: &Self) -> bool {
        let same = |a: &Option<Arc<Solution>>, b: &Option<Arc<Solution>>| match (a, b) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (a, b) => a.is_none() && b.is_none(),
        };
        let state = |report: &Self| report.board.as_ref().map(|board| board.health.state.clone());
        self.generation != before.generation
            || !same(&self.solution, &before.solution)
            || self.problem != before.problem
            || self.is_solving != before.is_solving
            || state(self) != state(before)
    }

    /// The report as an answer over WebSocket.
    pub fn state(&self, tally: Tally) -> Value {
        let wish = self.wish.as_ref();
        let scene = wish.map(|wish| &wish.scene);
        let targets = scene.iter().flat_map(|scene| scene.targets.iter()).take(MOST).enumerate();
        let targets: Vec<_> = targets
            .map(|(index, target)| {
                let mut value = json!(target);
                value["number"] = json!(index + 1);
                value["centre"] = json!(target.shape.centre().to_array());
                value
            })
            .collect();
        let focus = |focus: &Focus, pressure: f64| {
            let place = if focus.is_direction() { "direction" } else { "position" };
            json!({ place: focus.position.to_array(), "pressure": pressure })
        };
        let pairs = self.solution.iter().flat_map(|found| found.foci.iter().zip(&found.pressures));
        let foci: Vec<_> = pairs.take(MOST).map(|(own, pressure)| focus(own, pressure.norm())).collect();
        json!({ "state": {
            "change": self.generation,
            "targets": targets,
            "foci": foci,
            "elements": scene.map(|scene| scene.elements()),
            "plane": scene.map(|scene| json!(scene.plane)),
            "modulation": scene.map(|scene| json!(scene.modulation)),
            "method": scene.map(|scene| scene.solver.method.into_str()),
            "moves": wish.map(|wish| wish.moves && motion::moves(&wish.scene)),
            "sends": wish.map(|wish| wish.sends),
            "solving": self.is_solving,
            "seconds": self.solution.as_ref().map(|solution| solution.seconds),
            "problem": self.problem.as_deref().map(echo::message),
            "board": self.board.as_ref().map(board),
            "counts": counts(tally),
        } })
    }
}

fn board(board: &BoardReport) -> Value {
    let Health { in_place, stopped, frames, bytes, frames_per_second, refused, latency, .. } = &board.health;
    json!({
        "port": echo::value(&board.port),
        "profile": board.profile,
        "state": board.words(),
        "in_place": in_place,
        "stopped": stopped,
        "frames": frames,
        "bytes": bytes,
        "frames_per_second": frames_per_second,
        "retransmissions": refused,
        "latency": latency.map(|spread| spread.median.as_secs_f64()),
    })
}

fn counts(tally: Tally) -> Value {
    let Tally { packets, changes, refused, malformed, strangers, answers, unanswered, connections } = tally;
    json!({
        "packets": packets,
        "changes": changes,
        "refused": refused,
        "malformed": malformed,
        "strangers": strangers,
        "answers": answers,
        "unanswered": unanswered,
        "connections": connections,
    })
}
