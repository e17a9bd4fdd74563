//! Arrays in JSON: lists of places, or of objects with coordinates.

use serde_json::{Map, Value};

use crate::echo;
use crate::table::records::Records;

/// Keys of lists of places within an object.
const LISTS: [&str; 8] =
    ["elements", "transducers", "positions", "points", "places", "coordinates", "sensors", "data"];

/// The rows of a JSON file: `[[x, y, z], …]`, `[{"x": …, "y": …}, …]`, `{"x": […], "y": […]}`, or one of these under a
/// usual key.
///
/// # Errors
/// Line and reason, which names the format.
pub(crate) fn table(text: &str) -> Result<Records, (u64, String)> {
    let value: Value = serde_json::from_str(text)
        .map_err(|error| (error.line().max(1) as u64, format!("neither a table nor JSON: {error}")))?;
    of_value(&value).map_err(|reason| (1, reason))
}

fn of_value(value: &Value) -> Result<Records, String> {
    match value {
        Value::Array(rows) => of_list(rows),
        Value::Object(entries) => {
            if entries.contains_key("cells") && entries.contains_key("nbformat") {
                return Err("this is a Jupyter notebook".to_owned());
            }
            if entries.values().all(Value::is_array) && entries.contains_key("x") {
                return of_columns(entries);
            }
            if entries.contains_key("devices") {
                return Err(AUTD3.to_owned());
            }
            let list = LISTS.iter().find_map(|key| entries.get(*key)).ok_or_else(|| {
                let keys: Vec<_> = entries.keys().take(3).map(|key| format!("`{}`", short(key))).collect();
                format!(
                    "this is JSON with {}: must be a list of places, such as [[x, y, z], …]",
                    keys.join(", ")
                )
            })?;
            match list {
                Value::Array(rows) => of_list(rows),
                Value::Object(_) => of_value(list),
                Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => Err(NO_LIST.to_owned()),
            }
        }
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => Err(NO_LIST.to_owned()),
    }
}

const NO_LIST: &str = "this is JSON without a list of places, such as [[x, y, z], …]";
const AUTD3: &str = "this is a geometry of AUTD3 by devices: write the transducers' positions (mm) as CSV with the line \
    `x [mm],y [mm],z [mm]`";

fn of_list(rows: &[Value]) -> Result<Records, String> {
    let Some(first) = rows.first() else { return Err("this JSON list is empty".to_owned()) };
    match first {
        Value::Array(_) => {
            let row = |(index, row): (usize, &Value)| {
                let numbers = row.as_array().map(|row| row.iter().map(field).collect::<Option<Vec<_>>>());
                let numbers =
                    numbers.flatten().ok_or_else(|| format!("entry {index} is not a list of numbers"))?;
                Ok((1, numbers))
            };
            let rows = rows.iter().enumerate().map(row).collect::<Result<_, String>>()?;
            Ok(Records { names: None, rows, separator: b',' })
        }
        Value::Object(entries) => {
            if ["rot", "rotation", "quaternion"].iter().any(|key| entries.contains_key(*key)) {
                return Err(AUTD3.to_owned());
            }
            let names: Vec<String> =
                entries.iter().filter(|(_, value)| field(value).is_some()).map(|it| it.0.clone()).collect();
            let row = |(index, row): (usize, &Value)| {
                let of = |name: &String| {
                    row.get(name)
                        .and_then(field)
                        .ok_or_else(|| format!("entry {index} has no number `{}`", short(name)))
                };
                Ok((1, names.iter().map(of).collect::<Result<_, _>>()?))
            };
            let rows = rows.iter().enumerate().map(row).collect::<Result<_, String>>()?;
            Ok(Records { names: Some(names), rows, separator: b',' })
        }
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => Err(NO_LIST.to_owned()),
    }
}

fn of_columns(entries: &Map<String, Value>) -> Result<Records, String> {
    let columns: Vec<_> =
        entries.iter().filter_map(|(name, value)| Some((name, value.as_array()?))).collect();
    let length = columns.first().map_or(0, |(_, values)| values.len());
    let row = |index: usize| {
        let of = |(name, values): &(&String, &Vec<Value>)| {
            values
                .get(index)
                .and_then(field)
                .ok_or_else(|| format!("`{}` has no number {index}", short(name)))
        };
        Ok((1, columns.iter().map(of).collect::<Result<_, _>>()?))
    };
    if columns.iter().any(|(_, values)| values.len() != length) {
        return Err("the lists of this JSON file are of different lengths".to_owned());
    }
    let rows = (0..length).map(row).collect::<Result<_, String>>()?;
    let names = columns.iter().map(|(name, _)| (*name).clone()).collect();
    Ok(Records { names: Some(names), rows, separator: b',' })
}

fn short(name: &str) -> String {
    echo::value(&name.chars().take(20).collect::<String>())
}

/// A number as text.
fn field(value: &Value) -> Option<String> {
    value.as_f64().map(|number| format!("{number:?}"))
}
