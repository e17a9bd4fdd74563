//! The results shown by panels and canvas.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::scene::Method;
use crate::solver::Solution;
use crate::solver::frames::Sequence;
use crate::ui::beside;
use crate::ui::board::BoardShown;
use crate::ui::map::{Map, Texture};
use crate::ui::sound::Sound;
use crate::ui::space::view::SpaceShown;
use crate::ui::{dialog::options::Preview, dialog::state::Folder};

/// The results for display.
#[derive(Debug, Default)]
pub struct Shown {
    pub map: Option<Map>,
    /// The scene in 3D, while displayed.
    pub space: Option<SpaceShown>,
    /// The comparison map.
    pub beside: Option<beside::Beside>,
    /// Solution of the scene at rest.
    pub solution: Option<Arc<Solution>>,
    pub sound: Option<Sound>,
    /// The reason for showing a state other than the scene's.
    pub problem: Option<String>,
    /// Pending results, and what is shown meanwhile: a sentence.
    pub pending: Option<String>,
    /// Warnings, a sentence each.
    pub warnings: Vec<String>,
    pub methods: Vec<MethodRow>,
    pub is_comparing: bool,
    pub round: Option<Arc<Sequence>>,
    pub is_following: bool,
    /// Files that were open last, the last one first.
    pub recent: Vec<PathBuf>,
    /// The folder in the file dialog.
    pub folder: Option<Folder>,
    pub examples: Vec<Card>,
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
    /// The figure of a measured field on its page, and the enlarged one.
    pub measured: Option<Result<Preview, String>>,
    pub measured_large: Option<Result<Preview, String>>,
}

/// An example in menus and galleries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Card {
    pub group: &'static str,
    pub title: &'static str,
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

/// A method in the comparison.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct MethodRow {
    pub method: Method,
    /// Or the reason for its absence.
    pub solution: Result<Arc<Solution>, String>,
}
