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
use crate::scene::{Bead, Focus, Method, SpectralLine};
use crate::solver::Solution;
use crate::solver::frames::Sequence;
use crate::studio::probe::{self, Reading};
use crate::studio::width::Widths;
use crate::ui::beside;
use crate::ui::board::BoardShown;
use crate::ui::map::{Map, Texture};
use crate::ui::space::SpaceShown;
use crate::ui::{Editor, Folder, Preview};

/// The results for display.
#[derive(Debug, Default)]
pub struct Shown {
    pub map: Option<Map>,
    /// The scene in 3D, while displayed.
    pub space: Option<SpaceShown>,
    /// The comparison map.
    pub beside: Option<beside::Beside>,
    /// Of the scene at rest.
    pub solution: Option<Arc<Solution>>,
    pub sound: Option<Sound>,
    /// The reason for showing a state other than the scene's.
    pub problem: Option<String>,
    /// Pending results, and what is shown meanwhile: a sentence.
    pub pending: Option<String>,
    /// A sentence each.
    pub warnings: Vec<String>,
    /// The guaranteed fraction of the upper bound.
    pub certified: Option<f64>,
    pub methods: Vec<MethodRow>,
    pub is_comparing: bool,
    pub round: Option<Arc<Sequence>>,
    pub is_following: bool,
    pub pressed: Option<Pressed>,
    pub extremes: Option<Extremes>,
    /// At the position of [`crate::ui::CourseForm`], or the reason for its absence.
    pub course: Option<Result<Course, String>>,
    /// Levitation of the bead at its position.
    pub levitated: Option<Levitated>,
    pub arrows: Option<Arrows>,
    /// Widths of the selected focus, while the line profile is shown.
    pub widths: Option<Widths>,
    /// Files that were open last, the last one first.
    pub recent: Vec<PathBuf>,
    /// The folder in the file dialog.
    pub folder: Option<Folder>,
    /// Titles of the example scenes.
    pub examples: Vec<String>,
    /// Thumbnails of displayed examples, by index.
    pub thumbnails: BTreeMap<usize, Texture>,
    /// The field evaluator.
    pub evaluator: String,
    /// ms
    pub solving: f64,
    pub mapping: f64,
    /// GPU time for the map (ms), if measurable.
    pub on_gpu: Option<f64>,
    pub board: BoardShown,
    /// While other programs are listened to.
    pub serving: Option<ServingShown>,
    /// The last action or failure.
    pub notice: Option<Notice>,
    /// The current export, and its completed fraction.
    pub export: Option<(String, f32)>,
    /// The preview in the figure dialog, or an error; `None` while pending.
    pub figure: Option<Result<Preview, String>>,
}

impl Shown {
    /// The drives of a map of this quantity: the played ones, or all frames of the motion if their mean counts and no
    /// frame is displayed.
    pub fn drives(&self, editor: &Editor, quantity: Quantity) -> Vec<Drive> {
        match (&self.round, &self.sound) {
            (Some(round), _) if quantity.declaration().is_slow && editor.playback.frame.is_none() => {
                round.frames.iter().map(|frame| frame.drive.clone()).collect()
            }
            (_, sound) => sound.iter().flat_map(|sound| sound.drives.clone()).collect(),
        }
    }
}

/// Addresses of live control, and message counts.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ServingShown {
    pub addresses: Vec<String>,
    pub packets: u64,
    pub changes: u64,
    pub refused: u64,
}

/// A notice about an action.
#[derive(Clone, Debug, PartialEq)]
pub struct Notice {
    pub text: String,
    pub is_error: bool,
}

/// The played drive and its pressures.
#[derive(Clone, Debug)]
pub struct Sound {
    pub aperture: Aperture,
    pub air: Air,
    pub bead: Bead,
    /// Drives in turn, at least one.
    pub drives: Vec<Drive>,
    pub foci: Vec<Focus>,
    /// The readings at the foci.
    pub readings: Vec<Reading>,
}

impl Sound {
    /// The first drive in turn.
    pub fn drive(&self) -> &Drive {
        &self.drives[0]
    }

    /// The values of a map at points of its plane, in f64; empty for quantities that depend on more than the points.
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
    /// Or the reason for its absence.
    pub solution: Result<Arc<Solution>, String>,
}

/// The radiation pressure on the scene plane and its effects.
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
    pub lines: Vec<SpectralLine>,
}

impl Course {
    /// Of |p|², Pa².
    pub fn mean(&self) -> f64 {
        self.lines.first().map_or(0.0, |line| line.amplitude)
    }

    /// The strongest line besides the mean.
    pub fn strongest(&self) -> Option<&SpectralLine> {
        self.lines.iter().skip(1).max_by(|a, b| a.amplitude.total_cmp(&b.amplitude))
    }
}

/// Levitation of the scene's bead at a point.
#[derive(Clone, Debug, PartialEq)]
pub struct Levitated {
    pub hold: Hold,
    /// Where it is put.
    pub forces: Forces,
    /// N, weight less buoyancy.
    pub load: f64,
    /// m from there along x, y and z, and the force (N) along the same axis.
    pub curves: [Vec<[f64; 2]>; 3],
    /// A warning about the bead.
    pub warning: Option<String>,
}

/// Radiation forces (N) on the scene's bead at points (m) of the plane.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Arrows {
    pub places: Vec<DVec3>,
    pub forces: Vec<DVec3>,
}

/// The displayed maximum and peak side lobe: position (m), and |P| (Pa, peak).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extremes {
    pub peak: Option<(DVec3, f64)>,
    pub side_lobe: Option<(DVec3, f64)>,
}
