//! Replaces the board in builds without serial ports.

use std::convert::Infallible;
use std::sync::Arc;

use crate::control::report::BoardReport;
use crate::device::health::Health;
use crate::scene::Scene;
use crate::solver::Solution;
use crate::solver::frames::Sequence;

/// The content for a board.
#[derive(Clone, Debug)]
pub enum Play {
    Still(Arc<Solution>),
    Motion(Arc<Sequence>),
}

#[derive(Debug)]
pub struct Board(Infallible);

impl Board {
    pub fn silencer(&self) -> Box<dyn Fn() + Send + Sync> {
        match self.0 {}
    }

    pub fn attend(&mut self) {
        match self.0 {}
    }

    pub fn tune(&mut self, _: &mut Scene) {
        match self.0 {}
    }

    pub fn was_stopped(&mut self) -> bool {
        match self.0 {}
    }

    pub fn stop(&mut self) {
        match self.0 {}
    }

    pub fn play(&mut self, _: &Scene, _: Play) -> Result<(), String> {
        match self.0 {}
    }

    pub fn report(&self) -> BoardReport {
        match self.0 {}
    }

    pub fn close(self) -> Health {
        match self.0 {}
    }
}
