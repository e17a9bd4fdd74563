//! The results shown by panels and canvas.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::acoustics::{Air, Aperture};
use crate::drive::Drive;
use crate::field::{self, Quantity};
use crate::force::{Forces, Hold};
use crate::scene::{Bead, Focus, Method};
use crate::solver::Solution;
use crate::solver::frames::Sequence;
use crate::studio::probe::{self, Reading};
use crate::studio::time_course::Line;
use crate::studio::width::Widths;
use crate::ui::beside;
use crate::ui::board::BoardShown;
use crate::ui::map::{Map, Texture};
use crate::ui::space::SpaceShown;
use crate::ui::{Editor, Folder, Preview};

/// What was made from the scene and is there to be shown.
#[derive(Debug, Default)]
pub struct Shown {
    pub map: Option<Map>,
    /// The scene in space, while that is looked at.
    pub space: Option<SpaceShown>,
    /// What it is compared with.
    pub beside: Option<beside::Beside>,
    /// Of the scene at rest.
    pub solution: Option<Arc<Solution>>,
    pub sound: Option<Sound>,
    /// Why what is shown is not what the scene asks for.
    pub problem: Option<String>,
    /// What is still to come, and what is shown until then: a sentence.
    pub pending: Option<String>,
    /// A sentence each.
    pub warnings: Vec<String>,
    /// The part of the best that any drive can do.
    pub certified: Option<f64>,
    pub methods: Vec<MethodRow>,
    pub is_comparing: bool,
    pub round: Option<Arc<Sequence>>,
    pub is_following: bool,
    pub pressed: Option<Pressed>,
    pub extremes: Option<Extremes>,
    /// At the place of [`crate::ui::CourseForm`], or why there is none.
    pub course: Option<Result<Course, String>>,
    /// What the sound does to the bead where it is put.
    pub levitated: Option<Levitated>,
    pub arrows: Option<Arrows>,
    /// Of the focus that is selected, while the line profile is shown.
    pub widths: Option<Widths>,
    /// Files that were open last, the last one first.
    pub recent: Vec<PathBuf>,
    /// Where a file is asked for.
    pub folder: Option<Folder>,
    /// Titles of the example scenes.
    pub examples: Vec<String>,
    /// Pictures of those that were seen, by their place in the list.
    pub thumbnails: BTreeMap<usize, Texture>,
    /// Who computes the field.
    pub evaluator: String,
    /// ms
    pub solving: f64,
    pub mapping: f64,
    /// ms that the GPU took for the map, where it can be timed.
    pub on_gpu: Option<f64>,
    pub board: BoardShown,
    /// While other programs are listened to.
    pub serving: Option<ServingShown>,
    /// What was just done, or could not be.
    pub notice: Option<Notice>,
    /// What is being written meanwhile, and the part of it that is done.
    pub export: Option<(String, f32)>,
    /// The figure that is being asked about, or why there is none; `None` until it is there.
    pub figure: Option<Result<Preview, String>>,
}

impl Shown {
    /// The drives that a map of this quantity is of: those that are played, or all frames of the motion where their mean counts
    /// and none of them is looked at.
    pub fn drives(&self, editor: &Editor, quantity: Quantity) -> Vec<Drive> {
        match (&self.round, &self.sound) {
            (Some(round), _) if quantity.declaration().is_slow && editor.playback.frame.is_none() => {
                round.frames.iter().map(|frame| frame.drive.clone()).collect()
            }
            (_, sound) => sound.iter().flat_map(|sound| sound.drives.clone()).collect(),
        }
    }
}

/// Where other programs are listened to, and how much they have said.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ServingShown {
    pub addresses: Vec<String>,
    pub packets: u64,
    pub changes: u64,
    pub refused: u64,
}

/// A word on what was done.
#[derive(Clone, Debug, PartialEq)]
pub struct Notice {
    pub text: String,
    pub is_error: bool,
}

/// What is played, and what arrives.
#[derive(Clone, Debug)]
pub struct Sound {
    pub aperture: Aperture,
    pub air: Air,
    pub bead: Bead,
    /// Those that take turns, one at least.
    pub drives: Vec<Drive>,
    pub foci: Vec<Focus>,
    /// What arrives at the foci.
    pub readings: Vec<Reading>,
}

impl Sound {
    /// The first of those that take turns.
    pub fn drive(&self) -> &Drive {
        &self.drives[0]
    }

    /// The values of a map at points of its plane, in f64; none where these follow from more than the points.
    pub fn values(&self, map: &Map, points: &[DVec3]) -> Vec<f64> {
        let axes = [map.axes.x, map.axes.y, map.axes.x.cross(map.axes.y)];
        probe::values(
            (&self.aperture, &self.air, &self.bead),
            &self.drives,
            (map.quantity, map.phase),
            axes,
            points,
        )
    }

    pub fn value(&self, map: &Map, point: DVec3) -> Option<f64> {
        self.values(map, &[point]).first().copied()
    }
}

/// A method in the comparison.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct MethodRow {
    pub method: Method,
    /// Or why there is none.
    pub solution: Result<Arc<Solution>, String>,
}

/// What presses on the scene's plane.
#[derive(Clone, Debug)]
pub struct Pressed {
    pub figures: field::Pressed,
    /// That the depression is beyond linear theory.
    pub beyond: Option<String>,
}

/// The pressure at a point in the course of time.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    /// m
    pub at: DVec3,
    /// Time (s) and |p| (Pa, peak).
    pub moduli: Vec<[f64; 2]>,
    /// Of |p|² (Pa²).
    pub lines: Vec<Line>,
}

impl Course {
    /// Of |p|², Pa².
    pub fn mean(&self) -> f64 {
        self.lines.first().map_or(0.0, |line| line.amplitude)
    }

    /// The line beside the mean.
    pub fn strongest(&self) -> Option<&Line> {
        self.lines.iter().skip(1).max_by(|a, b| a.amplitude.total_cmp(&b.amplitude))
    }
}

/// What the sound does to the scene's bead at a point.
#[derive(Clone, Debug, PartialEq)]
pub struct Levitated {
    pub hold: Hold,
    /// Where it is put.
    pub forces: Forces,
    /// N, weight less buoyancy.
    pub load: f64,
    /// m from there along x, y and z, and the force (N) along the same axis.
    pub curves: [Vec<[f64; 2]>; 3],
    /// What to know of such a bead.
    pub warning: Option<String>,
}

/// Forces of the sound (N) on the scene's bead at places (m) of the cut.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Arrows {
    pub places: Vec<DVec3>,
    pub forces: Vec<DVec3>,
}

/// The loudest place on the screen and its peak side lobe: where (m), and |P| (Pa, peak).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extremes {
    pub peak: Option<(DVec3, f64)>,
    pub side_lobe: Option<(DVec3, f64)>,
}
