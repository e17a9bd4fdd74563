//! Lines of `sonoglyph batch`: each answer holds finite numbers, or an error that names the line.

use serde_json::Value;

use sonoglyph::cli::batch::lines::lines;
use sonoglyph::cli::batch::task::Task;
use sonoglyph::field::{Evaluator, Stages};
use sonoglyph::scene::{Scene, file, outline};

/// Limit of elements times squared foci, beyond which lines are not solved.
const MOST_WORK: usize = 20_000;

pub fn run(bytes: &[u8]) {
    let mut task = Task::default();
    (task.field, task.size) = (true, 6);
    let mut stages = Stages::new(Evaluator::Cpu);
    for line in lines(bytes) {
        let tables = line.text.as_ref().ok().and_then(|text| serde_json::from_str::<Value>(text).ok());
        if tables.as_ref().is_some_and(is_much_work) {
            continue;
        }
        let answer = task.answer(&line, &mut stages);
        assert_eq!(answer["line"], line.number);
        assert_eq!(answer.get("id"), tables.as_ref().and_then(|tables| tables.get("id")));
        match answer.get("error") {
            Some(error) => {
                let error = error.as_str().expect("the error is a string");
                assert!(error.starts_with(&format!("line {}: ", line.number)), "{error}");
            }
            None => is_a_solution(&answer),
        }
        let text = answer.to_string();
        assert!(!text.contains('\n') && serde_json::from_str::<Value>(&text).is_ok_and(|own| own == answer));
    }
}

fn is_much_work(tables: &Value) -> bool {
    let mut tables = tables.clone();
    let Some(keys) = tables.as_object_mut() else { return false };
    keys.remove("id");
    keys.entry("format").or_insert(1.into());
    let work = |scene: Scene| {
        let foci = outline::foci(&scene).map_or(0, |foci| foci.len());
        scene.array.elements() * foci * foci
    };
    file::from_tables(tables).is_ok_and(|scene| work(scene) > MOST_WORK)
}

fn is_a_solution(answer: &Value) {
    let elements = answer["elements"].as_u64().expect("the number of elements") as usize;
    for key in ["phases", "amplitudes"] {
        assert_eq!(answer[key].as_array().map(Vec::len), Some(elements), "{key}");
    }
    for key in ["foci", "quality", "phases", "amplitudes", "field", "seconds", "iterations"] {
        is_finite(&answer[key], key);
    }
}

/// JSON writes non-finite numbers as `null`.
fn is_finite(value: &Value, of: &str) {
    /// |p| does not fall to half in every direction from a focus, and a plane may have no side lobe.
    const MAY_LACK: [&str; 8] = [
        "lateral_x",
        "lateral_y",
        "axial",
        "area",
        "side_lobe",
        "side_lobe_position",
        "ghost",
        "ghost_position",
    ];
    match value {
        Value::Null if MAY_LACK.contains(&of) => {}
        Value::Null => panic!("{of} holds a non-finite number"),
        Value::Array(values) => values.iter().for_each(|value| is_finite(value, of)),
        Value::Object(values) => values.iter().for_each(|(key, value)| is_finite(value, key)),
        _ => {}
    }
}
