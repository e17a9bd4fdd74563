//! What a hand feels, by `solve` and `batch`.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::process::{folder_with, output_of, succeed};

/// Two points that a hand cannot tell apart.
const POINTS: &str = "format = 1\n[[target]]\nat = [-0.006, 0, 0.1]\n[[target]]\nat = [0.006, 0, 0.1]\n[skin]\n\
                      [modulation]\nshape = \"sine\"\nfrequency = 150\n";
const SLOW: &str = "format = 1\n[[target]]\n[skin]\n[motion]\npath = \"circle\"\nsize = 0.04\nrate = 10\n\
                    [plane]\nsize = [0.1, 0.1]\n";

fn json(folder: &Path, args: &[&str]) -> Value {
    serde_json::from_str(&succeed(folder, args)).unwrap()
}

#[test]
fn scenes_with_a_skin_say_what_is_felt() {
    let folder = folder_with(&[("a.toml", POINTS)]);
    let folder = folder.path();
    let (rows, warnings) = output_of(folder, &["solve", "a.toml"]);
    let felt = json(folder, &["solve", "a.toml", "--json"])["felt"].take();
    let level = felt["level"].as_f64().unwrap();
    assert!(level > 20.0 && felt["vibration"] == felt["level"] && felt["pressure"] == -100.0, "{felt}");
    assert_eq!(felt["uncertainty"]["level"], 15.0);
    for part in [&*format!("{level:.0} dB over threshold, ± 15 dB"), "pressure -, flutter -, vibration"] {
        assert!(rows.contains(part), "{part}: {rows}");
    }
    assert!(warnings.contains("foci 1 and 2, 12.0 mm apart, merge and are felt as one point"), "{warnings}");
    // A batch says the same, and a scene without a skin nothing.
    let line = "{\"target\": [{\"at\": [-0.006, 0, 0.1]}, {\"at\": [0.006, 0, 0.1]}], \"skin\": {}, \
                \"modulation\": {\"shape\": \"sine\", \"frequency\": 150}}\n";
    fs::write(folder.join("lines"), line).unwrap();
    assert_eq!(json(folder, &["batch", "lines"])["felt"], felt);
    fs::write(folder.join("a.toml"), POINTS.replace("[skin]\n", "")).unwrap();
    assert_eq!(json(folder, &["solve", "a.toml", "--json"]).get("felt"), None);
}

#[test]
fn a_slow_coarse_circle_is_warned_about() {
    let folder = folder_with(&[("a.toml", SLOW)]);
    let folder = folder.path();
    let (rows, warnings) = output_of(folder, &["solve", "a.toml", "--motion"]);
    for part in ["felt along", "best speed", "this path, which runs at 1.3 m/s"] {
        assert!(rows.contains(part), "{part}: {rows}");
    }
    let (still, same) = output_of(folder, &["solve", "a.toml", "--json"]);
    for warnings in [warnings, same] {
        assert!(warnings.contains("moves by 2.0 mm from frame to frame"), "{warnings}");
        assert!(warnings.contains("below 1 mm, motion.frames = 126"), "{warnings}");
    }
    let felt = serde_json::from_str::<Value>(&still).unwrap()["felt"].take();
    assert_eq!(json(folder, &["solve", "a.toml", "--motion", "--json"])["felt"], felt);
    assert_eq!(felt["strokes"].as_array().map(Vec::len), Some(1));
}
