//! What the documents say of the scene file and of boards is what the program does, and their links lead somewhere.

#![expect(clippy::unwrap_used, reason = "a test's helper may panic")]

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

use sonoglyph::device::profile::{Profile, Strength};
use sonoglyph::field::Quantity;
use sonoglyph::field::quantity::Unit;
use sonoglyph::scene::{Bead, Liquid, Scene, Solver, file};
use toml::{Table, Value};

/// Tables that stand as often as there are things of their kind.
const REPEATED: [&str; 4] = ["target", "quiet", "board", "reflector"];

/// One row of a table in docs/scene.md.
struct Row {
    table: String,
    key: String,
    default: String,
    limits: String,
}

impl Row {
    /// The scene file that gives this key this value, with what else must be there.
    fn file(&self, value: &str) -> String {
        let Self { table, key, .. } = self;
        let (head, rest) = match (table.as_str(), key.as_str()) {
            ("target", "spacing") => ("[[target]]\nkind = \"circle\"\nradius = 0.001", ""),
            ("quiet", _) => ("[[quiet]]", ""),
            ("reflector", _) => ("[[reflector]]", ""),
            ("target", _) => ("[[target]]\nkind = \"circle\"", "\n[solver]\nmethod = \"naive\""),
            _ => (&*format!("[{table}]"), ""),
        };
        // Elements must not outnumber what an array may have.
        let other = match key.as_str() {
            "rows" => "\ncolumns = 1",
            "columns" => "\nrows = 1",
            _ => "",
        };
        format!("format = 1\n{head}\n{key} = {value}{other}{rest}\n")
    }

    fn accepts(&self, value: &str) -> bool {
        file::parse(&self.file(value), Path::new("row.toml")).is_ok()
    }
}

fn document() -> String {
    text("docs/scene.md")
}

fn text(path: &str) -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap()
}

/// The rows that tell of a key: `table.key`, unit, default, limits, meaning.
fn rows() -> Vec<Row> {
    let row = |line: &str| {
        let cells: Vec<_> = line.split('|').map(str::trim).collect();
        let [_, key, _unit, default, limits, ..] = cells[..] else { return None };
        let (table, key) = key.strip_prefix('`')?.strip_suffix('`')?.split_once('.')?;
        let [table, key, default, limits] = [table, key, default, limits].map(str::to_owned);
        Some(Row { table, key, default, limits })
    };
    document().lines().filter_map(row).collect()
}

/// The keys of each table in a scene that gives everything.
fn known() -> BTreeMap<String, Table> {
    let text = r#"
        format = 1
        [medium]
        sound_speed = 343.0
        density = 1.2
        absorption = 1.0
        [liquid]
        density = 998.0
        surface_tension = 0.07
        viscosity = 0.001
        refractive_index = 1.33
        light = "reflected"
        screen = 0.1
        [bead]
        density = 30.0
        sound_speed = 900.0
        [listener]
        at = [0, 0, 1]
        [solver]
        quiet = 0.1
        search = 1
        target = "depression"
        [motion]
        path = "points"
        points = [[0, 0, 0]]
        angle = 0.5
        keyframes = [{ time = 0.5 }]
        [modulation]
        law = "power"
        tones = [{ depth = 0.5 }]
        file = "a.wav"
    "#;
    let scene = file::parse(text, Path::new("all.toml")).unwrap();
    let mut tables: Table = toml::from_str(&file::write(&scene)).unwrap();
    // These stand where others do not.
    let fast = "format = 1\n[motion]\nspeed = 6\nfoci = 2\n[solver]\nframes = 2\n[liquid]\nreflects = true\n\
                [array]\nelements = \"a.csv\"\nreflectivity = 0.5";
    let fast = file::parse(fast, Path::new("fast.toml")).unwrap();
    let fast: Table = toml::from_str(&file::write(&fast)).unwrap();
    for (table, key) in [
        ("motion", "speed"),
        ("motion", "foci"),
        ("solver", "frames"),
        ("liquid", "reflects"),
        ("array", "elements"),
        ("array", "reflectivity"),
    ] {
        tables[table].as_table_mut().unwrap().insert(key.to_owned(), fast[table][key].clone());
    }
    tables.into_iter().filter_map(|(name, value)| Some((name, value.as_table()?.clone()))).collect()
}

#[test]
fn every_key_of_a_scene_is_documented_and_none_else() {
    let documented: BTreeSet<_> = rows()
        .iter()
        .filter(|row| !REPEATED.contains(&&*row.table))
        .map(|row| (row.table.clone(), row.key.clone()))
        .collect();
    let known: BTreeSet<_> = known()
        .iter()
        .flat_map(|(table, keys)| keys.keys().map(|key| (table.clone(), key.clone())))
        .collect();
    assert_eq!(documented, known);
}

#[test]
fn every_key_of_a_target_and_of_a_zone_is_documented_and_none_else() {
    every_key_of_a_kind_is_documented("target", "| kind | keys |");
    every_key_of_a_kind_is_documented("quiet", "| kind of zone | keys |");
}

#[test]
fn every_key_of_a_board_and_of_a_reflector_is_documented_and_none_else() {
    for table in ["board", "reflector"] {
        assert_eq!(documented(table), keys_of(table));
    }
}

/// The message that refuses a key lists those that there are.
fn keys_of(table: &str) -> BTreeSet<String> {
    let text = format!("format = 1\n[[{table}]]\nno_such_key = 1\n");
    let message = file::parse(&text, Path::new("a.toml")).unwrap_err().to_string();
    let listed = message.split("expected one of").nth(1).unwrap();
    listed.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

fn documented(table: &str) -> BTreeSet<String> {
    rows().into_iter().filter(|row| row.table == table).map(|row| row.key).collect()
}

fn every_key_of_a_kind_is_documented(table: &str, head: &str) {
    let (known, mut documented) = (keys_of(table), documented(table));
    let document = document();
    let kinds = document.split(head).nth(1).unwrap().split("\n\n").next().unwrap();
    for line in kinds.lines().filter(|line| line.starts_with("| `")) {
        let mut words = line.split('`').skip(1).step_by(2);
        let kind = words.next().unwrap();
        let keys: Vec<_> = words.map(str::to_owned).collect();
        let target = match kind {
            "path" => "vertices = [[0, 0, 0.1], [0, 0.1, 0.1]]",
            "picture" => "file = \"a.png\"",
            _ => "",
        };
        let scene = file::parse(
            &format!("format = 1\n[[{table}]]\nkind = \"{kind}\"\n{target}"),
            Path::new("kind.toml"),
        )
        .unwrap();
        let written: Table = toml::from_str(&file::write(&scene)).unwrap();
        let written = written[table][0].as_table().unwrap();
        assert!(
            keys.iter().all(|key| written.contains_key(key)),
            "{kind}: {keys:?}, and there are {written:?}"
        );
        documented.extend(keys);
    }
    assert_eq!(documented, known);
}

#[test]
fn defaults_are_those_of_an_empty_scene() {
    let mut empty: Table = toml::from_str(&file::write(&Scene::default())).unwrap();
    let circle = "format = 1\n[[target]]\nkind = \"circle\"\n[[quiet]]\n[[board]]\n[[reflector]]\n";
    let circle = file::parse(circle, Path::new("circle.toml")).unwrap();
    let tables: Table = toml::from_str(&file::write(&circle)).unwrap();
    for table in REPEATED {
        let mut own = tables[table][0].as_table().unwrap().clone();
        // These are written only where they are not this.
        for (key, value) in [("angle", Value::Float(0.0)), ("normal", vec![0, 0, 1].into())] {
            own.entry(key.to_owned()).or_insert(value);
        }
        empty.insert(table.to_owned(), own.into());
    }
    let bead = Bead::default();
    let own = [("material", Value::from(bead.material.name())), ("radius", bead.radius.into())];
    empty.insert("bead".to_owned(), Table::from_iter(own.map(|(key, value)| (key.to_owned(), value))).into());
    // And so are these; `kind` is what made it a circle.
    let Solver { quiet, search, frames, .. } = Scene::default().solver;
    for (table, key, value) in [
        ("target", "kind", "point".into()),
        ("target", "visible", true.into()),
        ("target", "fill", false.into()),
        ("target", "name", "".into()),
        ("target", "group", "".into()),
        ("array", "reflectivity", 0.0.into()),
        ("liquid", "reflects", false.into()),
        ("solver", "quiet", quiet.into()),
        ("solver", "search", search.into()),
        ("solver", "frames", frames.into()),
        ("solver", "target", "pressure".into()),
        ("liquid", "light", "through".into()),
        ("liquid", "screen", Liquid::SCREEN.into()),
        ("modulation", "law", "amplitude".into()),
        ("modulation", "file", "".into()),
        ("motion", "angle", 0.0.into()),
        ("motion", "foci", 1.into()),
    ] {
        empty[table].as_table_mut().unwrap().insert(key.to_owned(), value);
    }
    for Row { table, key, default, .. } in rows() {
        let own = empty.get(&table).and_then(|table| table.get(&key));
        if default == "-" || default == "[]" {
            assert_eq!(own.filter(|own| !own.as_array().is_some_and(Vec::is_empty)), None, "{table}.{key}");
            continue;
        }
        let said: Table = toml::from_str(&format!("value = {default}")).unwrap();
        assert_eq!(own.map(as_floats), Some(as_floats(&said["value"])), "{table}.{key}");
    }
}

/// Whole numbers as floats, so that 20 is 20.0.
fn as_floats(value: &Value) -> Value {
    match value {
        Value::Integer(number) => Value::Float(*number as f64),
        Value::Array(values) => Value::Array(values.iter().map(as_floats).collect()),
        other => other.clone(),
    }
}

#[test]
fn limits_are_where_values_begin_to_be_refused() {
    let mut tried = 0;
    for row in rows().iter().filter(|row| row.limits.contains('…') && row.key != "size") {
        let (least, most) = row.limits.split_once('…').unwrap();
        let (least, most) = (least.trim(), most.trim());
        if let Some(least) = least.strip_prefix('>') {
            assert!(!row.accepts(least.trim()) && !row.accepts("-1"), "{}.{}", row.table, row.key);
        } else {
            let below = least.parse::<f64>().unwrap();
            let below = if below == 1.0 {
                "0".to_owned()
            } else {
                format!("{:e}", below - 1e-3 * below.abs().max(1e-6))
            };
            assert!(row.accepts(least) && !row.accepts(&below), "{}.{}: {below}", row.table, row.key);
        }
        if let Ok(number) = most.parse::<f64>() {
            let above = format!("{}", number + 1.0);
            assert!(!row.accepts(&above), "{}.{}: {above}", row.table, row.key);
            // A spacing or a target of this size is within its limits and yet no scene.
            let is_scene = row.table != "target";
            assert!(!is_scene || row.accepts(most), "{}.{}: {most}", row.table, row.key);
        }
        tried += 1;
    }
    assert!(tried > 20, "{tried}");
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
        };
        let value = &said[&name];
        assert!(value.split([' ', ',']).any(|word| word == unit), "{name} in {unit}: {value}");
        assert!(commands.contains(&format!("`{name}`")), "{name} is in docs/commands.md");
    }
}

/// All Markdown files below a folder but those of builds.
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
fn links_between_documents_lead_somewhere() {
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

#[test]
fn the_interface_is_the_one_that_is_listed() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args([
        "rustdoc",
        "--locked",
        "--quiet",
        "--lib",
        "--",
        "-Zunstable-options",
        "--output-format",
        "json",
    ]);
    // JSON is what rustdoc writes for tools, and not yet promised to stay.
    let run = cargo.current_dir(root).env("RUSTDOC", root.join("tests/rustdoc")).output().unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let json = public_api::Builder::from_rustdoc_json(root.join("target/doc/sonoglyph.json"));
    let json = json.omit_auto_derived_impls(true).omit_auto_trait_impls(true).omit_blanket_impls(true);
    let items: String = json.build().unwrap().items().map(|item| format!("{item}\n")).collect();
    let (listed, now) = (root.join("docs/interface.txt"), root.join("target/interface.txt"));
    std::fs::write(&now, &items).unwrap();
    let before = std::fs::read_to_string(&listed).unwrap_or_default();
    let (before, after): (BTreeSet<_>, BTreeSet<_>) = (before.lines().collect(), items.lines().collect());
    let (gone, new): (Vec<_>, Vec<_>) =
        (before.difference(&after).collect(), after.difference(&before).collect());
    assert!(
        gone.is_empty() && new.is_empty(),
        "the library's interface has changed; if it is to, copy {} to {}\ngone: {gone:#?}\nnew: {new:#?}",
        now.display(),
        listed.display()
    );
}

#[test]
fn the_readme_has_the_rows_that_the_report_writes() {
    let list: Table = toml::from_str(&text("benches/report/figures.toml")).unwrap();
    let names: Vec<_> =
        list["figure"].as_array().unwrap().iter().map(|figure| figure["name"].as_str().unwrap()).collect();
    let readme = text("README.md");
    let (_, rest) = readme.split_once("<!-- figures -->\n").unwrap();
    let (table, _) = rest.split_once("<!-- /figures -->\n").unwrap();
    let cells = table.lines().filter_map(|line| line.strip_prefix("| ")?.split(" | ").next());
    assert_eq!(cells.skip(1).collect::<Vec<_>>(), names);
}
