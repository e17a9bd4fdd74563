//! Writes keyframes and tones as inline tables, one per line, where serde would write a TOML section for each.

use toml_edit::{Array, DocumentMut, Item, TableLike, Value};

const KEYFRAMES: &str = "keyframes";
const TONES: &str = "tones";

/// The text of a scene with inline keyframes and tones. A text that is not TOML is returned unchanged.
pub fn lists(text: String) -> String {
    if ![KEYFRAMES, TONES].iter().any(|key| text.contains(key)) {
        return text;
    }
    let Ok(mut document) = text.parse::<DocumentMut>() else { return text };
    let modulation = document.get_mut("modulation").and_then(Item::as_table_like_mut);
    modulation.into_iter().for_each(|table| write(table, TONES));
    let own = document.get_mut("motion").and_then(Item::as_table_like_mut);
    own.into_iter().for_each(|table| write(table, KEYFRAMES));
    let targets = document.get_mut("target").and_then(Item::as_array_of_tables_mut);
    for target in targets.into_iter().flat_map(|targets| targets.iter_mut()) {
        let own = target.get_mut("motion").and_then(Item::as_table_like_mut);
        own.into_iter().for_each(|table| write(table, KEYFRAMES));
        let own = target.get_mut("modulation").and_then(Item::as_table_like_mut);
        own.into_iter().for_each(|table| write(table, TONES));
    }
    document.to_string()
}

fn write(owner: &mut dyn TableLike, key: &str) {
    let Some(tables) = owner.get(key).and_then(Item::as_array_of_tables).cloned() else { return };
    let mut list = Array::new();
    for table in tables {
        let mut line = Value::InlineTable(table.into_inline_table());
        line.decor_mut().set_prefix("\n    ");
        list.push_formatted(line);
    }
    list.set_trailing("\n");
    list.set_trailing_comma(true);
    owner.insert(key, Item::Value(Value::Array(list)));
}
