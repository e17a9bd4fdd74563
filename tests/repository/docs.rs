//! Documents agree with the program: boards, quantities, the library's interface, links, and the README's table.
//!
//! `docs/scene.md` is tested beside the reader of scene files, in `engine/src/scene/file/tests/documented.rs`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

use sonoglyph::device::declaration::Strength;
use sonoglyph::device::profile::Profile;
use sonoglyph::field::{Quantity, Unit};

fn text(path: &str) -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap()
}

#[test]
fn boards_are_documented_with_their_facts() {
    let text = text("docs/boards.md");
    let table = text.split("## Which\n").nth(1).unwrap().split("##").next().unwrap();
    let said: Vec<Vec<_>> = table
        .lines()
        .filter(|line| line.starts_with("| `") && !line.contains("--profile"))
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .map(|cells: Vec<&str>| [&cells[..1], &cells[2..]].concat())
        .collect();
    let facts = Profile::ALL.map(|profile| {
        let amplitude = match profile.strength() {
            Strength::Fixed => "on, off".to_owned(),
            Strength::Linear(steps) | Strength::Duty(steps) => format!("{steps} steps"),
        };
        let frames = profile.frames_per_second(profile.baud()).floor();
        let (elements, levels) = (profile.elements().to_string(), profile.levels().to_string());
        let (baud, frames) = (profile.baud().to_string(), frames.to_string());
        [format!("`{}`", profile.name()), elements, levels, amplitude, baud, frames]
    });
    assert_eq!(said, facts);
}

#[test]
fn quantities_are_documented_with_their_units() {
    let model = text("docs/model.md");
    let table = model.split("| quantity | value |").nth(1).unwrap().split("\n\n").next().unwrap();
    let said: BTreeMap<_, _> = table
        .lines()
        .filter_map(|line| line.strip_prefix("| `")?.split_once("` | "))
        .map(|(name, value)| (name.to_owned(), value.to_owned()))
        .collect();
    let names = Quantity::ALL.map(|quantity| quantity.declaration().name.to_owned());
    assert_eq!(said.keys().collect::<BTreeSet<_>>(), names.iter().collect());
    let commands = text("docs/commands.md");
    for (quantity, name) in Quantity::ALL.into_iter().zip(names) {
        let unit = match quantity.declaration().unit {
            Unit::Pascal => "Pa",
            Unit::Radian => "rad",
            Unit::Metre => "m",
            Unit::WattPerSquareMetre => "W/m²",
            Unit::MetrePerSecond => "m/s",
            Unit::Joule => "J",
            Unit::Newton => "N",
            Unit::Undisturbed => "×",
            Unit::Decibel => "dB",
        };
        let value = &said[&name];
        assert!(value.split([' ', ',']).any(|word| word == unit), "{name} in {unit}: {value}");
        assert!(commands.contains(&format!("`{name}`")), "docs/commands.md lacks {name}");
    }
}

/// All Markdown files below a folder, except in build folders.
fn documents(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let (folders, files): (Vec<_>, Vec<_>) = entries.partition(|path| path.is_dir());
    let ours = |folder: &PathBuf| {
        folder.file_name().is_some_and(|name| name != "target" && !name.as_encoded_bytes().starts_with(b"."))
    };
    let markdown = files.into_iter().filter(|file| file.extension().is_some_and(|kind| kind == "md"));
    markdown
        .chain(folders.iter().filter(|folder| ours(folder)).flat_map(|folder| documents(folder)))
        .collect()
}

#[test]
fn links_between_documents_have_targets() {
    let documents = documents(Path::new(env!("CARGO_MANIFEST_DIR")));
    assert!(documents.len() > 8, "{documents:?}");
    for document in documents {
        let text = std::fs::read_to_string(&document).unwrap();
        for link in text.split("](").skip(1).filter_map(|rest| rest.split([')', '#']).next()) {
            let is_there = document.with_file_name(link).exists() || link.contains("://");
            assert!(is_there, "{}: {link}", document.display());
        }
    }
}

/// Makes the documents of both packages and lists of their public items.
fn document(root: &Path) {
    let mut cargo = Command::new(env!("CARGO"));
    // Examples, since cargo then takes the dependencies as the lints built them, with the features of all packages.
    cargo.args(["doc", "--locked", "--quiet", "--no-deps", "--lib", "--examples"]);
    cargo.env("RUSTDOC", root.join("tests/repository/rustdoc"));
    cargo.env("RUSTDOCFLAGS", "--deny warnings --allow rustdoc::private_intra_doc_links");
    let run = cargo.current_dir(root).output().unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
}

/// The public items of a documented library, as users of `sonoglyph` name them.
fn items(root: &Path, library: &str) -> Vec<String> {
    let json = public_api::Builder::from_rustdoc_json(root.join(format!("target/doc/{library}.json")));
    let json = json.omit_auto_derived_impls(true).omit_auto_trait_impls(true).omit_blanket_impls(true);
    let text = |item: &public_api::PublicItem| item.to_string().replace("sonoglyph_engine::", "sonoglyph::");
    json.build().unwrap().items().map(text).collect()
}

#[test]
fn documents_build_and_the_interface_is_the_listed_one() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    document(root);
    // The program's crate passes on whole modules of the engine, which are not listed twice.
    let passed_on = |item: &String| {
        let module = item.strip_prefix("pub use sonoglyph::").is_some_and(|path| !path.contains("::"));
        module || item == "pub mod sonoglyph_engine"
    };
    let libraries = ["sonoglyph_engine", "sonoglyph"];
    let mut items: Vec<_> = libraries.into_iter().flat_map(|library| items(root, library)).collect();
    items.retain(|item| !passed_on(item));
    let items: String = items.into_iter().map(|item| item + "\n").collect();
    let (listed, now) = (root.join("docs/interface.txt"), root.join("target/interface.txt"));
    std::fs::write(&now, &items).unwrap();
    let before = std::fs::read_to_string(&listed).unwrap_or_default();
    let (before, after): (BTreeSet<_>, BTreeSet<_>) = (before.lines().collect(), items.lines().collect());
    let (gone, new): (Vec<_>, Vec<_>) =
        (before.difference(&after).collect(), after.difference(&before).collect());
    assert!(
        gone.is_empty() && new.is_empty(),
        "the library's interface has changed; if intended, copy {} to {}\nremoved: {gone:#?}\nadded: {new:#?}",
        now.display(),
        listed.display()
    );
}

#[test]
fn the_readme_has_the_rows_of_the_report() {
    let list: toml::Table = toml::from_str(&text("benches/report/figures.toml")).unwrap();
    let names: Vec<_> =
        list["figure"].as_array().unwrap().iter().map(|figure| figure["name"].as_str().unwrap()).collect();
    let readme = text("README.md");
    let (_, rest) = readme.split_once("<!-- figures -->\n").unwrap();
    let (table, _) = rest.split_once("<!-- /figures -->\n").unwrap();
    let cells = table.lines().filter_map(|line| line.strip_prefix("| ")?.split(" | ").next());
    assert_eq!(cells.skip(1).collect::<Vec<_>>(), names);
}

/// The labels in the first column of what `solve` prints about a scene.
fn labels(scene: &str, args: &[&str]) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.toml"), scene).unwrap();
    let mut program = Command::new(env!("CARGO_BIN_EXE_sonoglyph"));
    let run = program.current_dir(folder.path()).args(["solve", "a.toml"]).args(args).output().unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let text = String::from_utf8(run.stdout).unwrap();
    let label = |line: &str| Some(line.split_once("  ")?.0.trim_end().to_owned());
    let of_table = |line: &&str| !line.starts_with(['+', '|']);
    text.lines().filter(of_table).filter_map(label).collect()
}

#[test]
fn every_printed_figure_has_a_definition() {
    let head = "format = 1\n[array]\nrows = 4\ncolumns = 4\n";
    let point = format!("{head}[[target]]\nat = [0.0, 0.01, 0.05]\n");
    let shapes = "[[target]]\nkind = \"circle\"\nat = [0, 0, 0.05]\nradius = 0.01\nfill = true\n\
                  [[target]]\nkind = \"line\"\nfrom = [-0.02, -0.02, 0.05]\nto = [0.02, -0.02, 0.05]\n";
    let trap = "[[target]]\nkind = \"trap\"\nat = [0, 0, 0.05]\n";
    let mut printed = BTreeSet::new();
    printed.extend(labels(&point, &["--levels", "8", "--listener", "0,0.1,0.3"]));
    printed.extend(labels(&format!("{head}{shapes}"), &[]));
    printed.extend(labels(&format!("{head}{trap}"), &[]));
    let circle =
        "[skin]\n[motion]\npath = \"circle\"\nrate = 80.0\nframes = 16\n[plane]\ncentre = [0, 0, 0.05]\n";
    printed.extend(labels(&format!("{point}{circle}"), &[]));
    for known in [
        "peak side lobe",
        "strength",
        "error",
        "areas",
        "continuous strokes",
        "refined",
        "listener",
        "felt along",
    ] {
        assert!(printed.contains(known), "{known}: {printed:?}");
    }
    let model = text("docs/model.md");
    let defined = |label: &String| {
        let label = label.trim_end_matches(|c: char| c.is_ascii_digit()).trim_end();
        model.lines().any(|line| line.starts_with('|') && line.contains(&format!("*{label}*")))
    };
    let missing: Vec<_> = printed.iter().filter(|label| !defined(label)).collect();
    assert!(missing.is_empty(), "docs/model.md defines none of {missing:?}");
}
