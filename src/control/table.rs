//! Sets some keys of a scene's table, as its file would.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use strum::{EnumString, IntoStaticStr, VariantArray};

use crate::control::refusal::EditError;
use crate::echo;
use crate::scene::motion::MotionTable;
use crate::scene::strict::Strict;
use crate::scene::{Scene, Target, TargetTable};

/// Tables with keys that other programs may set. Array and boards change only with the whole scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase", const_into_str)]
pub enum Table {
    Medium,
    Solver,
    Plane,
    Liquid,
    Skin,
    Modulation,
    Motion,
}

/// Sets some keys of a table. Values are checked with the whole scene.
///
/// # Errors
/// An unknown key, a value of the wrong type, or a file name.
pub fn patch(scene: &mut Scene, table: Table, keys: &Map<String, Value>) -> Result<(), EditError> {
    match table {
        Table::Medium => scene.medium = patched(table, &scene.medium, keys)?,
        Table::Solver => scene.solver = patched(table, &scene.solver, keys)?,
        Table::Plane => scene.plane = patched(table, &scene.plane, keys)?,
        Table::Liquid => scene.liquid = patched(table, &scene.liquid, keys)?,
        Table::Skin => {
            let before = scene.skin.clone().unwrap_or_default();
            let mut skin = patched(table, &before, keys)?;
            if skin.threshold == before.threshold {
                skin.curve = before.curve;
            } else if skin.known().is_none() {
                return Err(EditError::NamesFile(echo::value(&skin.threshold)));
            }
            scene.skin = Some(skin);
        }
        Table::Modulation => {
            if let Some(file) = keys.get("file") {
                return Err(EditError::NamesFile(echo::value(&file.to_string())));
            }
            let wave = scene.modulation.wave.clone();
            scene.modulation = patched(table, &scene.modulation, keys)?;
            scene.modulation.wave = wave;
        }
        Table::Motion => {
            if let Some(file) = keys.get("file") {
                return Err(EditError::NamesFile(echo::value(&file.to_string())));
            }
            let routes = scene.motion.routes.clone();
            let mut now = as_keys(&scene.motion);
            // The other of the two is derived.
            if keys.contains_key("speed") || keys.contains_key("rate") {
                now.remove("speed");
                now.remove("rate");
            }
            let motion: MotionTable = read(table.into_str(), merged(now, keys))?;
            scene.motion = motion.into_motion().map_err(|error| error.under(&[table.into_str().into()]))?;
            scene.motion.routes = routes;
        }
    }
    Ok(())
}

/// A target from a table as in a scene file; `index` is its position from 0.
///
/// # Errors
/// A key unknown to its kind, or a value of the wrong type.
pub fn target(keys: Map<String, Value>, index: usize) -> Result<Target, EditError> {
    let table: TargetTable = read("target", keys)?;
    Ok(table.into_target(index)?)
}

fn patched<T: Serialize + DeserializeOwned>(
    table: Table,
    now: &T,
    keys: &Map<String, Value>,
) -> Result<T, EditError> {
    read(table.into_str(), merged(as_keys(now), keys))
}

/// Checked tables only hold finite numbers, so the conversion is lossless.
fn as_keys<T: Serialize>(table: &T) -> Map<String, Value> {
    match serde_json::to_value(table) {
        Ok(Value::Object(keys)) => keys,
        Ok(_) | Err(_) => Map::new(),
    }
}

fn merged(mut now: Map<String, Value>, keys: &Map<String, Value>) -> Map<String, Value> {
    now.extend(keys.iter().map(|(key, value)| (key.clone(), value.clone())));
    now
}

fn read<T: for<'de> Deserialize<'de>>(name: &str, keys: Map<String, Value>) -> Result<T, EditError> {
    T::deserialize(Strict(Value::Object(keys)))
        .map_err(|error| EditError::Value(format!("{name}: {}", echo::message(&error.to_string()))))
}
