//! The scene file: TOML to [`Scene`] and back, with errors that name file, line and value.

use std::path::Path;

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize};

use crate::scene::board::{Board, Reflector};
use crate::scene::body::BodyTable;
use crate::scene::check::check;
use crate::scene::content::FORMAT;
use crate::scene::content::{Listener, Scene};
use crate::scene::drive::DriveFile;
use crate::scene::inline;
use crate::scene::location::misread;
pub use crate::scene::location::{FileError, located};
use crate::scene::motion::MotionTable;
use crate::scene::range::{Key, KeyError};
use crate::scene::strict::Strict;
use crate::scene::target::TargetTable;
use crate::scene::zone::ZoneTable;
use crate::scene::{
    array::Array, bead::Bead, liquid::Liquid, medium::Medium, modulation::Modulation, motion, plane::Plane,
    skin::Skin, solver::Solver, target::Target,
};
use crate::source;

/// The version of the file format that this program reads and writes.
/// Limit of a file's size in bytes; the largest scene is smaller, and reading needs eighty times as much memory.
pub const LONGEST: u64 = 2 << 20;

/// Reads and checks a scene file. All focal points have been computed once, so [`motion::frames`] of the result can
/// only fail for a scene without visible targets.
///
/// # Errors
/// An unreadable file, broken TOML, an unknown key, or a value outside its limits.
pub fn read(path: &Path) -> Result<Scene, FileError> {
    parse(&read_text(path)?, path)
}

/// The text of a scene file.
///
/// # Errors
/// An unreadable or non-text file.
pub fn read_text(path: &Path) -> Result<String, FileError> {
    source::read_text(path, LONGEST).map_err(|cause| FileError::Read { file: path.to_owned(), cause })
}

/// Like [`read`], from text; `path` only names it.
///
/// # Errors
/// The errors of [`read`].
pub fn parse(text: &str, path: &Path) -> Result<Scene, FileError> {
    let table = parse_tables(text).map_err(|error| misread(&error, text, path))?;
    table.into_scene().and_then(checked).map_err(|error| located(&error, text, path))
}

fn parse_tables(text: &str) -> Result<SceneTable, toml::de::Error> {
    SceneTable::deserialize(Strict(toml::Deserializer::parse(text)?))
}

/// Like [`read`], from the same tables and keys in any format that serde reads.
///
/// # Errors
/// The errors of [`read`], except file errors; the message names the key.
pub fn from_tables<'de, D: Deserializer<'de>>(tables: D) -> Result<Scene, D::Error> {
    SceneTable::deserialize(Strict(tables))?.into_scene().and_then(checked).map_err(D::Error::custom)
}

/// The scene as a file.
pub fn write(scene: &Scene) -> String {
    inline::lists(toml::to_string(scene).expect("a scene is tables of plain values"))
}

/// Only the targets, as a text for [`parse_targets`].
pub fn write_targets(targets: &[Target]) -> String {
    #[derive(Serialize)]
    struct Targets<'a> {
        format: u32,
        target: &'a [Target],
    }
    toml::to_string(&Targets { format: FORMAT, target: targets }).expect("targets are plain values")
}

/// The targets of a text, if it is a scene's.
pub fn parse_targets(text: &str) -> Option<Vec<Target>> {
    let scene = parse_tables(text).ok()?.into_scene().ok()?;
    check(&scene).ok()?;
    Some(scene.targets)
}

fn checked(scene: Scene) -> Result<Scene, KeyError> {
    check(&scene)?;
    if !scene.is_incomplete() {
        targets_in_motion(&scene)?;
    }
    Ok(scene)
}

/// Checks targets and motion together, if any target is visible; pictures only once they are loaded.
///
/// # Errors
/// The errors of [`motion::check`].
pub fn targets_in_motion(scene: &Scene) -> Result<(), KeyError> {
    if scene.has_foci() { motion::check(scene) } else { Ok(()) }
}

/// The file as written, before the keys of each target are assigned.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SceneTable {
    format: u32,
    #[serde(default)]
    drive: DriveFile,
    #[serde(default)]
    medium: Medium,
    #[serde(default)]
    array: Array,
    #[serde(default)]
    board: Vec<Board>,
    #[serde(default)]
    reflector: Vec<Reflector>,
    #[serde(default)]
    body: Vec<BodyTable>,
    #[serde(default)]
    target: Vec<TargetTable>,
    #[serde(default)]
    quiet: Vec<ZoneTable>,
    #[serde(default)]
    solver: Solver,
    #[serde(default)]
    plane: Plane,
    #[serde(default)]
    liquid: Liquid,
    #[serde(default)]
    bead: Bead,
    skin: Option<Skin>,
    #[serde(default)]
    modulation: Modulation,
    #[serde(default)]
    motion: MotionTable,
    listener: Option<Listener>,
}

impl SceneTable {
    fn into_scene(self) -> Result<Scene, KeyError> {
        let Self {
            format,
            drive,
            medium,
            array,
            board: boards,
            reflector: reflectors,
            body,
            target,
            quiet,
            solver,
            plane,
            liquid,
            bead,
            skin,
            modulation,
            motion,
            listener,
        } = self;
        if format != FORMAT {
            return Err(KeyError::new([Key::from("format")], format!("this program reads format {FORMAT}")));
        }
        let bodies = body
            .into_iter()
            .enumerate()
            .map(|(index, table)| table.into_body(index))
            .collect::<Result<_, _>>()?;
        let targets = target
            .into_iter()
            .enumerate()
            .map(|(index, table)| table.into_target(index))
            .collect::<Result<_, _>>()?;
        let quiet = quiet
            .into_iter()
            .enumerate()
            .map(|(index, table)| table.into_zone(index))
            .collect::<Result<_, _>>()?;
        let motion = motion.into_motion().map_err(|e| e.under(&["motion".into()]))?;
        Ok(Scene {
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
        })
    }
}

#[cfg(test)]
mod tests;
