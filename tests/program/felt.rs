//! What a hand feels, by `solve` and `batch`; the ways of playing a drawing, and frames of unequal drives.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::process::{folder_with, output_of, refuse, succeed};

/// Two points that a hand cannot tell apart.
const POINTS: &str = "format = 1\n[[target]]\nat = [-0.006, 0, 0.1]\n[[target]]\nat = [0.006, 0, 0.1]\n[skin]\n\
                      [modulation]\nshape = \"sine\"\nfrequency = 150\n";
const SLOW: &str = "format = 1\n[[target]]\n[skin]\n[motion]\npath = \"circle\"\nsize = 0.04\nrate = 10\n\
                    [plane]\nsize = [0.1, 0.1]\n";
const DOT: &str = "format = 1\n[[target]]\n[skin]\n";
const STROKE: &str = "format = 1\n[[target]]\nkind = \"line\"\nfrom = [-0.02, 0, 0.1]\nto = [0.02, 0, 0.1]\n\
                      [solver]\ntarget = \"felt\"\n[motion]\npath = \"outline\"\nframes = 16\n";

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

#[test]
fn the_way_ranked_first_is_felt_as_promised() {
    let folder = folder_with(&[
        ("dot.toml", DOT),
        ("water.toml", "format = 1\n[[target]]\n[liquid]\nname = \"water\"\n"),
    ]);
    let ways = json(folder.path(), &["solve", "dot.toml", "--felt", "--json"]);
    let ways = ways.as_array().unwrap();
    let levels: Vec<_> = ways.iter().map(|way| way["felt"]["level"].as_f64().unwrap()).collect();
    assert!(levels.is_sorted_by(|a, b| a >= b), "{levels:?}");
    let of_kind = |kind: &str| ways.iter().find(|way| way["kind"] == kind);
    assert!(of_kind("STM").is_none() && of_kind("TURNS").is_none(), "a dot has no strokes");
    for kind in ["AM", "LM"] {
        let way = of_kind(kind).unwrap();
        let table = |name: &str, keys: &[&str]| {
            let keys: String = keys.iter().map(|key| format!("{key} = {}\n", way[name][key])).collect();
            format!("[{name}]\n{keys}")
        };
        let modulation = table("modulation", &["shape", "frequency"]);
        let motion = table("motion", &["path", "size", "rate", "frames"]);
        fs::write(folder.path().join("way.toml"), format!("{DOT}{modulation}{motion}")).unwrap();
        let felt = &json(folder.path(), &["solve", "way.toml", "--json"])["felt"];
        assert!(
            (felt["level"].as_f64().unwrap() - way["felt"]["level"].as_f64().unwrap()).abs() < 0.1,
            "{felt}"
        );
    }
    let refusal = refuse(folder.path(), &["solve", "water.toml", "--felt"]);
    assert!(refusal.contains("a drawing for a hand"), "{refusal}");
}

#[test]
fn frames_of_unequal_drives_replay_from_their_csv() {
    let folder = folder_with(&[("a.toml", STROKE)]);
    succeed(folder.path(), &["solve", "a.toml", "--motion", "--csv", "frames.csv"]);
    let map = |args: &[&str], file: &str| -> Vec<f32> {
        let usual = ["render", "a.toml", "-o", "a.png", "--size", "24", "--data", file];
        succeed(folder.path(), &[&usual, args].concat());
        npyz::NpyFile::new(&fs::read(folder.path().join(file)).unwrap()[..]).unwrap().into_vec().unwrap()
    };
    let (own, replayed) = (map(&[], "a.npy"), map(&["--drive", "frames.csv"], "b.npy"));
    let most = own.iter().copied().fold(0.0, f32::max);
    let apart = own.iter().zip(&replayed).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(most > 0.0 && apart < 1e-4 * most, "{apart} of {most}");
}
