//! JSON over WebSocket: a message is an object, and one change.

use glam::DVec3;
use serde::Deserialize;
use serde_json::{Map, Value, json};
use strum::VariantArray;

use crate::control::edit::{Edit, admitted};
use crate::control::refusal::{EditError, Number};
use crate::control::table::{self, Table};
use crate::echo;
use crate::field::Quantity;
use crate::scene::{FORMAT, file};

/// Bytes of a message, at most.
pub const LONGEST: usize = 1 << 20;
/// Pixels of a map, at most.
const MOST_PIXELS: usize = 1 << 20;
/// Default size of a map.
const SIDE: usize = 128;

/// The requests of a message.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Message {
    /// Returned with every answer.
    pub id: Option<Value>,
    pub token: Option<String>,
    /// Scene, clear, targets, removals from the last on, additions, tables, motion, send, stop.
    pub edits: Vec<Edit>,
    pub state: bool,
    /// Whether to send the state after every change.
    pub watch: Option<bool>,
    pub map: Option<MapWish>,
}

/// A requested map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MapWish {
    pub quantity: Quantity,
    /// Width, height.
    pub size: (usize, usize),
}

/// The token of a message, whatever its other keys.
pub fn token(text: &str) -> Option<String> {
    let value: Value = serde_json::from_str(text).ok()?;
    value.get("token")?.as_str().map(str::to_owned)
}

/// Parses a message; its `id` is also set on errors.
///
/// # Errors
/// A text that is not a JSON object, an unknown key, or an invalid value.
pub fn message(text: &str, id: &mut Option<Value>) -> Result<Message, EditError> {
    let read: Result<Value, _> = serde_json::from_str(text);
    let value = read.map_err(|error| EditError::Value(format!("invalid JSON: {error}")))?;
    let Value::Object(mut keys) = value else { return wrong("a message is an object, {…}") };
    *id = keys.remove("id");
    let mut message = Message { id: id.clone(), ..Message::default() };
    let mut take = |key: &str| keys.remove(key);
    let edits = &mut message.edits;
    message.token = take("token").map(|value| text_of("token", value)).transpose()?;
    if let Some(scene) = take("scene") {
        edits.push(Edit::Scene(Box::new(scene_of(scene)?)));
    }
    if flag("clear", take("clear"))?.unwrap_or(false) {
        edits.push(Edit::Clear);
    }
    if let Some(targets) = take("targets") {
        let Value::Object(targets) = targets else { return wrong("targets: give {\"NUMBER\": {…}, …}") };
        for (number, keys) in targets {
            of_target(&number, keys, edits)?;
        }
    }
    if let Some(numbers) = take("remove") {
        let mut numbers: Vec<Number> = read_as("remove", numbers)?;
        numbers.sort_unstable();
        numbers.dedup();
        edits.extend(numbers.into_iter().rev().map(Edit::Remove));
    }
    if let Some(added) = take("add") {
        let added: Vec<Map<String, Value>> = read_as("add", added)?;
        for (index, keys) in added.into_iter().enumerate() {
            edits.push(Edit::Add(Box::new(table::target(keys, index)?)));
        }
    }
    for &table in Table::VARIANTS.iter().filter(|table| **table != Table::Motion) {
        if let Some(keys) = take(table.into_str()) {
            edits.push(Edit::Table(table, read_as(table.into_str(), keys)?));
        }
    }
    match take("motion") {
        Some(Value::Bool(on)) => edits.push(Edit::Motion(on)),
        Some(keys) => edits.push(Edit::Table(Table::Motion, read_as("motion", keys)?)),
        None => {}
    }
    edits.extend(flag("send", take("send"))?.map(Edit::Send));
    edits.extend(flag("stop", take("stop"))?.filter(|stop| *stop).map(|_| Edit::Stop));
    message.state = flag("state", take("state"))?.unwrap_or(false);
    message.watch = flag("watch", take("watch"))?;
    message.map = take("map").map(map_of).transpose()?;
    match keys.keys().next() {
        Some(key) => wrong(&format!("{}: there is no such key", echo::value(key))),
        None => Ok(message),
    }
}

fn wrong<T>(text: &str) -> Result<T, EditError> {
    Err(EditError::Value(text.to_owned()))
}

fn flag(key: &str, value: Option<Value>) -> Result<Option<bool>, EditError> {
    value.map(|value| read_as(key, value)).transpose()
}

fn text_of(key: &str, value: Value) -> Result<String, EditError> {
    read_as(key, value)
}

fn read_as<T: for<'de> Deserialize<'de>>(key: &str, value: Value) -> Result<T, EditError> {
    serde_json::from_value(value)
        .map_err(|error| EditError::Value(format!("{key}: {}", echo::message(&error.to_string()))))
}

/// A whole scene, with the tables and keys of the file; `format` is optional.
fn scene_of(mut tables: Value) -> Result<crate::scene::Scene, EditError> {
    let Some(keys) = tables.as_object_mut() else { return wrong("scene: a scene is an object, {…}") };
    keys.entry("format").or_insert_with(|| FORMAT.into());
    let scene = file::from_tables(tables);
    admitted(scene.map_err(|error| EditError::Value(format!("scene: {error}")))?)
}

/// A target with a `kind` replaces the existing one; otherwise some of its keys change.
fn of_target(number: &str, keys: Value, edits: &mut Vec<Edit>) -> Result<(), EditError> {
    let of_number = number.parse::<Number>();
    let Ok(index) = of_number else {
        return wrong(&format!("targets: {} is no number", echo::value(number)));
    };
    let mut keys: Map<String, Value> = read_as("targets", keys)?;
    if keys.contains_key("kind") {
        edits.push(Edit::Replace(index, Box::new(table::target(keys, index.saturating_sub(1))?)));
        return Ok(());
    }
    let called = |key: &str| format!("targets.{index}.{key}");
    if let Some(at) = keys.remove("at") {
        edits.push(Edit::At(index, DVec3::from_array(read_as(&called("at"), at)?)));
    }
    if let Some(pressure) = keys.remove("pressure") {
        edits.push(Edit::Pressure(index, read_as(&called("pressure"), pressure)?));
    }
    if let Some(angle) = keys.remove("angle") {
        edits.push(Edit::Angle(index, read_as(&called("angle"), angle)?));
    }
    if let Some(text) = keys.remove("text") {
        edits.push(Edit::Text(index, read_as(&called("text"), text)?));
    }
    if let Some(visible) = keys.remove("visible") {
        edits.push(Edit::Visible(index, read_as(&called("visible"), visible)?));
    }
    match keys.keys().next() {
        Some(key) => wrong(&format!(
            "targets.{}.{}: at, pressure, angle, text and visible can be set alone; with `kind` the whole target",
            index,
            echo::value(key)
        )),
        None => Ok(()),
    }
}

fn map_of(value: Value) -> Result<MapWish, EditError> {
    #[derive(Deserialize)]
    #[serde(default, deny_unknown_fields)]
    struct Keys {
        quantity: String,
        size: [usize; 2],
    }
    impl Default for Keys {
        fn default() -> Self {
            Self { quantity: "rms".to_owned(), size: [SIDE; 2] }
        }
    }
    let Keys { quantity, size: [width, height] } = match value {
        Value::Bool(true) => Keys::default(),
        value => read_as("map", value)?,
    };
    let of_name = |quantity: &Quantity| quantity.declaration().name;
    let Some(found) = Quantity::ALL.into_iter().find(|each| of_name(each) == quantity) else {
        let names: Vec<_> = Quantity::ALL.iter().map(of_name).collect();
        return wrong(&format!("map.quantity: the quantities are {}", names.join(", ")));
    };
    let pixels = width.checked_mul(height);
    if pixels.is_none_or(|pixels| !(1..=MOST_PIXELS).contains(&pixels)) {
        return wrong(&format!("map.size: 1 to {MOST_PIXELS} pixels"));
    }
    Ok(MapWish { quantity: found, size: (width, height) })
}

/// An answer to a message, with its `id`.
pub fn with_id(mut answer: Value, id: Option<&Value>) -> String {
    if let Some(id) = id {
        answer["id"] = id.clone();
    }
    answer.to_string()
}

/// Why a message is refused.
pub fn error(text: &str, id: Option<&Value>) -> String {
    with_id(json!({ "error": echo::message(text) }), id)
}

/// The acknowledgement of a change by its number, covering all earlier ones.
pub fn done(change: u64, id: Option<&Value>) -> String {
    with_id(json!({ "done": change }), id)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_key_of_a_target_can_be_set_alone_or_with_others() {
        let keys = [
            (r#""at": [0.01, -0.02, 0.1]"#, Edit::At(2, DVec3::new(0.01, -0.02, 0.1))),
            (r#""pressure": 0.5"#, Edit::Pressure(2, 0.5)),
            (r#""angle": -1.5"#, Edit::Angle(2, -1.5)),
            (r#""text": "B""#, Edit::Text(2, "B".to_owned())),
            (r#""visible": false"#, Edit::Visible(2, false)),
        ];
        let edits = |keys: &str| {
            message(&format!("{{\"targets\": {{\"2\": {{{keys}}}}}}}"), &mut None).unwrap().edits
        };
        for (key, edit) in &keys {
            assert_eq!(edits(key), std::slice::from_ref(edit), "{key}");
        }
        let (all, expected): (Vec<_>, Vec<_>) = keys.into_iter().unzip();
        assert_eq!(edits(&all.join(", ")), expected);
    }

    #[test]
    fn a_target_that_is_removed_twice_is_removed_once() {
        let edits = message(r#"{"remove": [1, 3, 1, 2, 3]}"#, &mut None).unwrap().edits;
        assert_eq!(edits, [3, 2, 1].map(Edit::Remove));
    }
}
