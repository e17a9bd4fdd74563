//! Lists of the wrong length in scenes and settings.

use std::path::Path;

use toml::{Table, Value};

/// The path of every list of numbers in a document: keys and indices.
fn lists(value: &Value, path: &mut Vec<String>, found: &mut Vec<Vec<String>>) {
    match value {
        Value::Table(table) => {
            for (key, value) in table {
                path.push(key.clone());
                lists(value, path, found);
                path.pop();
            }
        }
        Value::Array(array) => {
            // Only lists of element numbers, and of pressures along a path, have any length.
            let is_vector = array.iter().all(|value| value.is_float() || value.is_integer());
            let is_free = path.last().is_some_and(|key| ["off", "pressures"].contains(&key.as_str()));
            if is_vector && !array.is_empty() && !is_free {
                found.push(path.clone());
            }
            for (index, value) in array.iter().enumerate() {
                path.push(index.to_string());
                lists(value, path, found);
                path.pop();
            }
        }
        _ => {}
    }
}

fn at<'a>(value: &'a mut Value, path: &[String]) -> &'a mut Vec<Value> {
    let inside = path.iter().fold(value, |value, key| match value {
        Value::Table(table) => table.get_mut(key).unwrap(),
        Value::Array(array) => &mut array[key.parse::<usize>().unwrap()],
        _ => panic!("{path:?}"),
    });
    inside.as_array_mut().unwrap()
}

#[test]
fn a_value_too_many_or_too_few_is_refused_in_every_list() {
    let every_list = "format = 1\n[[target]]\nkind = \"path\"\nvertices = [[0, 0, 0.1], [0.01, 0, 0.1]]\n\
        [[target]]\nkind = \"circle\"\nnormal = [0, 0, 1]\n[[target]]\nkind = \"line\"\nfrom = [0, 0, 0.1]\nto = [0.01, 0, 0.1]\n[target.motion]\npath = \"points\"\n\
        points = [[0, 0, 0.01]]\n[[quiet]]\nat = [0, 0.04, 0.1]\nnormal = [0, 0, 1]\n[plane]\ncentre = [0, 0, 0.1]\n\
        x_axis = [1, 0, 0]\ny_axis = [0, 1, 0]\nsize = [0.1, 0.1]\n[listener]\nat = [0, -0.3, 0.4]\n[motion]\n\
        path = \"points\"\npoints = [[0, 0, 0.01]]\n";
    let name = Path::new("a.toml");
    sonoglyph::scene::file::parse(every_list, name).unwrap();
    let document = Value::Table(every_list.parse::<Table>().unwrap());
    let mut found = Vec::new();
    lists(&document, &mut Vec::new(), &mut found);
    assert_eq!(found.len(), 14, "{found:?}");
    for path in &found {
        for longer in [true, false] {
            let mut changed = document.clone();
            let list = at(&mut changed, path);
            if longer {
                list.push(Value::Integer(9));
            } else {
                drop(list.pop());
            }
            let text = toml::to_string(&changed).unwrap();
            let error = sonoglyph::scene::file::parse(&text, name).unwrap_err().to_string();
            let key = path.iter().rev().find(|key| key.parse::<usize>().is_err()).unwrap();
            assert!(error.starts_with("a.toml:") && error.contains(key.as_str()), "{path:?}: {error}");
        }
    }
}
