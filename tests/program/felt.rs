//! What is felt: the ways of playing a drawing, and frames of unequal drives.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::process::{folder_with, refuse, succeed};

const DOT: &str = "format = 1\n[[target]]\n[skin]\n";
const STROKE: &str = "format = 1\n[[target]]\nkind = \"line\"\nfrom = [-0.02, 0, 0.1]\nto = [0.02, 0, 0.1]\n\
                      [solver]\ntarget = \"felt\"\n[motion]\npath = \"outline\"\nframes = 16\n";

fn json(folder: &Path, args: &[&str]) -> Value {
    serde_json::from_str(&succeed(folder, args)).unwrap()
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
        let usual = ["render", "a.toml", "-o", "a.png", "--size", "24", "--frame", "mean", "--data", file];
        succeed(folder.path(), &[&usual, args].concat());
        npyz::NpyFile::new(&fs::read(folder.path().join(file)).unwrap()[..]).unwrap().into_vec().unwrap()
    };
    let (own, replayed) = (map(&[], "a.npy"), map(&["--drive", "frames.csv"], "b.npy"));
    let most = own.iter().copied().fold(0.0, f32::max);
    let apart = own.iter().zip(&replayed).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(most > 0.0 && apart < 1e-4 * most, "{apart} of {most}");
}
