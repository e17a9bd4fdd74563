//! Edits of a scene by other programs, as plain data, applied atomically.

use std::path::Path;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use serde_json::{Map, Value};

use crate::control::refusal::{EditError, Number};
use crate::control::table::{self, Table};
use crate::echo;
use crate::scene::check::check;
use crate::scene::{Scene, Target, file};
use crate::studio::{arrays, opening};

/// One change of a scene, or of its playback.
#[derive(Clone, Debug, PartialEq)]
pub enum Edit {
    /// The target's centre goes there (m).
    At(Number, DVec3),
    /// The same at its height: x and y (m).
    Across(Number, DVec2),
    /// Target pressure, as `pressure` in a scene's file.
    Pressure(Number, f64),
    /// rad
    Angle(Number, f64),
    Text(Number, String),
    Visible(Number, bool),
    /// Replaces a target.
    Replace(Number, Box<Target>),
    Add(Box<Target>),
    Remove(Number),
    /// Removes all targets.
    Clear,
    /// Some keys of a table, as in a scene's file.
    Table(Table, Map<String, Value>),
    /// Another scene, whole.
    Scene(Box<Scene>),
    /// Starts or stops motions.
    Motion(bool),
    /// Starts or stops playback on the board.
    Send(bool),
    /// The board falls silent.
    Stop,
}

/// The common wish of the user and other programs.
#[derive(Clone, Debug, PartialEq)]
pub struct Wish {
    pub scene: Arc<Scene>,
    /// Whether motions run.
    pub moves: bool,
    /// The board plays the scene.
    pub sends: bool,
    /// Number of times that playback was stopped.
    pub stops: u64,
}

impl Wish {
    /// The initial wish: motions run, the board is silent.
    pub fn new(scene: Arc<Scene>) -> Self {
        Self { scene, moves: true, sends: false, stops: 0 }
    }

    /// The wish after a change.
    ///
    /// # Errors
    /// An invalid edit, or a scene refused by [`check()`] or [`file::targets_in_motion`].
    pub fn after(&self, change: &[Edit]) -> Result<Self, EditError> {
        let Self { mut moves, mut sends, mut stops, .. } = *self;
        let mut edited = None;
        for edit in change {
            match edit {
                Edit::Motion(on) => moves = *on,
                Edit::Send(true) => sends = true,
                Edit::Send(false) => (sends, stops) = (false, stops + u64::from(sends)),
                Edit::Stop => (sends, stops) = (false, stops + 1),
                Edit::Scene(scene) => edited = Some((**scene).clone()),
                _ => apply(edit, edited.get_or_insert_with(|| (*self.scene).clone()))?,
            }
        }
        let scene = match edited {
            None => Arc::clone(&self.scene),
            Some(scene) => {
                check(&scene)?;
                file::targets_in_motion(&scene)?;
                Arc::new(scene)
            }
        };
        Ok(Self { scene, moves, sends, stops })
    }
}

fn apply(edit: &Edit, scene: &mut Scene) -> Result<(), EditError> {
    let targets = &mut scene.targets;
    match edit {
        Edit::At(number, at) => target(targets, *number)?.shape.move_to(*at),
        Edit::Across(number, at) => {
            let shape = &mut target(targets, *number)?.shape;
            shape.move_to(at.extend(shape.centre().z));
        }
        Edit::Pressure(number, pressure) => target(targets, *number)?.pressure = *pressure,
        Edit::Angle(number, angle) => {
            let target = target(targets, *number)?;
            if target.shape.is_point() {
                return Err(EditError::NoAngle(*number));
            }
            target.angle = *angle;
        }
        Edit::Text(number, letters) => {
            let text = target(targets, *number)?.shape.text_mut();
            text.ok_or(EditError::NoText(*number))?.clone_from(letters);
        }
        Edit::Visible(number, visible) => target(targets, *number)?.visible = *visible,
        Edit::Replace(number, other) => {
            refuse_file_of(other)?;
            *target(targets, *number)? = (**other).clone();
        }
        Edit::Add(other) => {
            refuse_file_of(other)?;
            targets.push((**other).clone());
        }
        Edit::Remove(number) => {
            target(targets, *number)?;
            targets.remove(number - 1);
        }
        Edit::Clear => targets.clear(),
        Edit::Table(table, keys) => table::patch(scene, *table, keys)?,
        Edit::Scene(_) | Edit::Motion(_) | Edit::Send(_) | Edit::Stop => {}
    }
    Ok(())
}

fn target(targets: &mut [Target], number: Number) -> Result<&mut Target, EditError> {
    let count = targets.len();
    let index = number.checked_sub(1);
    index.and_then(|index| targets.get_mut(index)).ok_or(EditError::NoTarget { number, count })
}

/// Refuses a target that names a file of this machine.
fn refuse_file_of(target: &Target) -> Result<(), EditError> {
    let picture = target.shape.picture().map(|(file, ..)| file);
    let wave = target.modulation.as_ref().map(|modulation| &*modulation.file);
    let path = target.motion.as_ref().map(|motion| &*motion.file);
    match [picture, wave, path].into_iter().flatten().find(|file| !file.is_empty()) {
        Some(file) => Err(EditError::NamesFile(echo::value(file))),
        None => Ok(()),
    }
}

/// A scene from elsewhere, whole: with the elements of a published array, if it names one, and with no file of this machine.
///
/// # Errors
/// A scene that names files, or an error of [`opening::load`].
pub fn admitted(mut scene: Scene) -> Result<Scene, EditError> {
    scene.targets.iter().try_for_each(refuse_file_of)?;
    let tables = scene.array.file.iter().chain(&scene.array.wiring);
    let table = tables.filter(|name| !name.starts_with(arrays::PRESET));
    let wave = scene.modulations().map(|(_, modulation)| &modulation.file).find(|name| !name.is_empty());
    let path = Some(&scene.motion.file).filter(|name| !name.is_empty());
    let drive = Some(&scene.drive.name).filter(|name| !name.is_empty());
    let thresholds = scene.skin.as_ref().filter(|skin| skin.known().is_none()).map(|skin| &skin.threshold);
    let directivity = scene.array.directivity.as_ref();
    let mesh = scene.bodies.iter().find_map(|body| body.file.as_ref());
    let named = table.chain(wave).chain(path).chain(drive).chain(thresholds).chain(directivity).chain(mesh);
    if let Some(name) = named.into_iter().next() {
        return Err(EditError::NamesFile(echo::value(name)));
    }
    opening::load(&mut scene, Path::new(""))?;
    Ok(scene)
}
