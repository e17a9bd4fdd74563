//! Runs the fuzz targets of `fuzz/` on their corpora and on reproducible mutations.
//!
//! `SONOGLYPH_MUTATIONS=100 cargo test --test scenes fuzz` makes a hundred times as many.

mod mutation;
mod targets;

use std::collections::BTreeSet;
use std::fs;
use std::panic::catch_unwind;
use std::path::{Path, PathBuf};

use crate::dice::Dice;
use mutation::{dictionary, mutated};

/// Number of the first mutation.
const SEED: u64 = 40_000;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The files of a folder by name, or an empty list if there is no such folder.
fn files(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let mut paths: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths.into_iter().map(|path| (path.clone(), fs::read(path).unwrap())).collect()
}

/// The corpus of a target: its own folder, and similar files elsewhere in the repository.
fn corpus(target: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let mut corpus = files(&root().join("tests/scenes/fuzz/corpus").join(target));
    if target == "scene" {
        corpus.extend(files(&root().join("assets/scenes")));
    }
    corpus
}

/// Runs a target on its corpus, and on this number of mutations.
fn fuzz(target: &str, mutations: u64) {
    let corpus = corpus(target);
    assert!(corpus.len() >= 3, "{target} has a corpus of {} inputs", corpus.len());
    for (path, bytes) in &corpus {
        check(target, bytes, &path.display().to_string());
    }
    let words = dictionary(include_str!("words.dict"));
    let corpus: Vec<_> = corpus.into_iter().map(|(_, bytes)| bytes).collect();
    let times = std::env::var("SONOGLYPH_MUTATIONS").map_or(1, |times| times.parse().unwrap());
    for seed in SEED..SEED + mutations * times {
        check(
            target,
            &mutated(&corpus, &words, &mut Dice::seeded(seed)),
            &format!("the mutation of seed {seed}"),
        );
    }
}

/// Runs a target once; a failing input is kept for inspection and for the corpus.
fn check(target: &str, bytes: &[u8], name: &str) {
    if catch_unwind(|| targets::run(target, bytes)).is_err() {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{target}-crash"));
        fs::write(&path, bytes).unwrap();
        panic!("{target} fails on {name}, kept as {}", path.display());
    }
}

#[test]
fn scene_files() {
    fuzz("scene", 8000);
}

#[test]
fn points() {
    fuzz("points", 10000);
}

#[test]
fn drives() {
    fuzz("drive", 10000);
}

#[test]
fn calibrations() {
    fuzz("calibration", 10000);
}

#[test]
fn tables_of_elements() {
    fuzz("elements", 10000);
}

#[test]
fn pictures() {
    fuzz("picture", 2000);
}

#[test]
fn links() {
    fuzz("link", 5000);
}

#[test]
fn native_packets() {
    fuzz("native", 2500);
}

#[test]
fn stock_boards() {
    fuzz("stock", 5000);
}

#[test]
fn routes() {
    fuzz("route", 5000);
}

#[test]
fn waveforms() {
    fuzz("waveform", 20000);
}

#[test]
fn drawings() {
    fuzz("drawing", 2000);
}

#[test]
fn batch_lines() {
    fuzz("batch", 800);
}

#[test]
fn osc_packets() {
    fuzz("osc", 20000);
}

#[test]
fn ultraino_packets() {
    fuzz("ultraino", 20000);
}

#[test]
fn json_messages() {
    fuzz("json", 10000);
}

#[test]
fn settings() {
    fuzz("settings", 10000);
}

#[test]
fn every_target_runs_here_and_under_libfuzzer() {
    let (here, manifest) =
        (include_str!("mod.rs"), fs::read_to_string(root().join("fuzz/Cargo.toml")).unwrap());
    for (name, _) in targets::TARGETS {
        assert!(here.contains(&format!("fuzz(\"{name}\", ")), "{name} is not run");
        let own =
            fs::read_to_string(root().join("fuzz/fuzz_targets").join(name).with_extension("rs")).unwrap();
        assert!(own.contains(&format!("targets::run(\"{name}\", bytes)")), "{own}");
        assert!(manifest.contains(&format!("name = \"{name}\"\n")), "{name} is not in fuzz/Cargo.toml");
    }
}

#[test]
fn mutations_differ_and_are_reproducible() {
    let corpus = [b"pitch = 0.01\n".to_vec(), b"rows = 3\n".to_vec()];
    let words = dictionary("# numbers\n\"1e309\"\n\"\\x00\\\"\"\n");
    assert_eq!(words, [b"1e309".to_vec(), b"\0\"".to_vec()]);
    let of = |seed| mutated(&corpus, &words, &mut Dice::seeded(seed));
    let all: BTreeSet<_> = (0..2000).map(of).collect();
    assert!(all.len() > 1500, "{} of 2000 differ", all.len());
    assert!(all.iter().any(|bytes| bytes.starts_with(b"pitch = 1e309")), "a number replaced by a word");
    assert_eq!(of(7), of(7));
}
