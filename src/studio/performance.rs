//! The performance of a scene: the solved drive or frames that are played.

use std::sync::Arc;

use anyhow::anyhow;

use crate::drive::Drive;
use crate::gauge::Gauge;
use crate::scene::{Scene, motion};
use crate::solver::frames::Sequence;
use crate::solver::{self, Solution};
use crate::studio::motion::{SOLVING, follow};
use crate::studio::output::warn;

/// The scene at rest, or all frames of its motion.
#[derive(Clone, Debug)]
pub enum Performance {
    Still(Arc<Solution>),
    Motion(Arc<Sequence>),
}

/// Equality of what was solved once.
impl PartialEq for Performance {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Still(a), Self::Still(b)) => Arc::ptr_eq(a, b),
            (Self::Motion(a), Self::Motion(b)) => Arc::ptr_eq(a, b),
            (Self::Still(_), Self::Motion(_)) | (Self::Motion(_), Self::Still(_)) => false,
        }
    }
}

impl Performance {
    /// Solves a scene and prints warnings; `name` is the scene's name, and `begin` begins to show progress.
    ///
    /// # Errors
    /// A scene that cannot be solved.
    pub fn of(scene: &Scene, name: &str, begin: fn(&'static str) -> Gauge) -> anyhow::Result<Self> {
        if motion::moves(scene) {
            return Ok(Self::Motion(Arc::new(follow(scene, name, &begin(SOLVING))?)));
        }
        let solution = solver::solve(scene).map_err(|error| anyhow!("{name}: {error}"))?;
        solution.warnings.iter().for_each(|warning| warn(&warning.to_string()));
        Ok(Self::Still(Arc::new(solution)))
    }

    /// The drives in turn, or of all frames.
    pub fn drives(&self) -> Vec<Drive> {
        match self {
            Self::Still(solution) => solution.drives(),
            Self::Motion(sequence) => sequence.frames.iter().map(|frame| frame.drive.clone()).collect(),
        }
    }

    /// The first drive.
    pub fn first(&self) -> &Drive {
        match self {
            Self::Still(solution) => &solution.drive,
            Self::Motion(sequence) => &sequence.frames[0].drive,
        }
    }
}
