//! What `docs/scene.md` says of the scene file is what the types say that read it: every key, default and limit.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::LazyLock;

use serde::de::value::Error;
use serde::de::{Deserialize, Deserializer, Error as _, Visitor};
use serde::forward_to_deserialize_any;
use toml::{Table, Value};

use crate::scene::board::{Board, Reflector};
use crate::scene::body::BodyTable;
use crate::scene::content::{Listener, Scene};
use crate::scene::file::{self, SceneTable};
use crate::scene::motion::MotionTable;
use crate::scene::target::TargetTable;
use crate::scene::zone::ZoneTable;
use crate::scene::{
    array::Array, bead::Bead, body::Body, liquid::Liquid, medium::Medium, modulation::Modulation,
    plane::Plane, skin::Skin, solver::Solver,
};

/// Read when the tests run, so that a word in it compiles nothing anew.
static DOCUMENT: LazyLock<String> = LazyLock::new(|| {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/scene.md");
    std::fs::read_to_string(path).unwrap()
});
/// Tables that stand as often as there are things of their kind.
const REPEATED: [&str; 5] = ["target", "quiet", "board", "reflector", "body"];

/// Takes the keys of a type as serde's derive asks a format for them.
struct Asked<'a>(&'a mut &'static [&'static str]);

impl<'de> Deserializer<'de> for Asked<'_> {
    type Error = Error;

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Error> {
        Err(Error::custom("no table"))
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        keys: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        *self.0 = keys;
        self.deserialize_any(visitor)
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 u8 u16 u32 u64 f32 f64 char str string bytes byte_buf option unit unit_struct newtype_struct
        seq tuple tuple_struct map enum identifier ignored_any
    }
}

/// The keys that a table may have.
fn keys_of<'de, T: Deserialize<'de>>() -> BTreeSet<&'static str> {
    let mut keys = &[][..];
    assert!(T::deserialize(Asked(&mut keys)).is_err());
    keys.iter().copied().collect()
}

/// The keys of every table.
fn known() -> BTreeMap<&'static str, BTreeSet<&'static str>> {
    let tables = BTreeMap::from([
        ("medium", keys_of::<Medium>()),
        ("array", keys_of::<Array>()),
        ("board", keys_of::<Board>()),
        ("reflector", keys_of::<Reflector>()),
        ("body", keys_of::<BodyTable>()),
        ("target", keys_of::<TargetTable>()),
        ("quiet", keys_of::<ZoneTable>()),
        ("solver", keys_of::<Solver>()),
        ("plane", keys_of::<Plane>()),
        ("liquid", keys_of::<Liquid>()),
        ("bead", keys_of::<Bead>()),
        ("skin", keys_of::<Skin>()),
        ("modulation", keys_of::<Modulation>()),
        ("motion", keys_of::<MotionTable>()),
        ("listener", keys_of::<Listener>()),
    ]);
    let mut all = keys_of::<SceneTable>();
    assert!(all.remove("format") && all.remove("drive"));
    assert_eq!(tables.keys().copied().collect::<BTreeSet<_>>(), all);
    tables
}

/// One row of a table in docs/scene.md.
struct Row {
    table: &'static str,
    key: &'static str,
    default: &'static str,
    limits: &'static str,
}

impl Row {
    /// The scene file that gives this key this value, with what else must be there.
    fn file(&self, value: &str) -> String {
        let Self { table, key, .. } = self;
        let (head, rest) = match (*table, *key) {
            ("target", "spacing") => ("[[target]]\nkind = \"circle\"\nradius = 0.001", ""),
            ("quiet", _) => ("[[quiet]]", ""),
            ("reflector", _) => ("[[reflector]]", ""),
            ("body", "scale") => ("[[body]]\nkind = \"mesh\"\nfile = \"a.stl\"", ""),
            ("body", _) => ("[[body]]\nat = [0, 0, 9]", ""),
            ("target", _) => ("[[target]]\nkind = \"circle\"", "\n[solver]\nmethod = \"naive\""),
            _ => (&*format!("[{table}]"), ""),
        };
        // Elements must not outnumber what an array may have.
        let other = match *key {
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

fn parse(text: &str) -> Scene {
    file::parse(text, Path::new("a.toml")).unwrap()
}

/// The rows that tell of a key: `table.key`, unit, default, limits, meaning.
fn rows() -> Vec<Row> {
    let row = |line: &'static str| {
        let cells: Vec<_> = line.split('|').map(str::trim).collect();
        let [_, key, _unit, default, limits, ..] = cells[..] else { return None };
        let (table, key) = key.strip_prefix('`')?.strip_suffix('`')?.split_once('.')?;
        Some(Row { table, key, default, limits })
    };
    DOCUMENT.lines().filter_map(row).collect()
}

/// The keys of every table in the tables of keys, and of targets and zones in those of their kinds.
fn documented() -> BTreeMap<&'static str, BTreeSet<&'static str>> {
    let mut tables: BTreeMap<_, BTreeSet<_>> = BTreeMap::new();
    for Row { table, key, .. } in rows() {
        assert!(tables.entry(table).or_default().insert(key), "{table}.{key} stands there twice");
    }
    for (table, _, keys) in kinds() {
        tables.entry(table).or_default().extend(keys);
    }
    tables
}

/// Tables whose kinds have keys of their own, the kinds, and these keys.
fn kinds() -> Vec<(&'static str, &'static str, Vec<&'static str>)> {
    let of = |(table, head)| {
        let rows = DOCUMENT.split(head).nth(1).unwrap().split("\n\n").next().unwrap();
        rows.lines().filter(|line| line.starts_with("| `")).map(move |line| {
            let mut words = line.split('`').skip(1).step_by(2);
            (table, words.next().unwrap(), words.collect())
        })
    };
    let heads = [
        ("target", "| kind | keys |"),
        ("quiet", "| kind of zone | keys |"),
        ("body", "| kind of body | keys |"),
    ];
    heads.into_iter().flat_map(of).collect()
}

#[test]
fn every_key_is_documented_and_none_else() {
    assert_eq!(documented(), known());
}

#[test]
fn kinds_have_the_keys_that_are_documented() {
    for (table, kind, keys) in kinds() {
        let needed = match kind {
            "path" => "vertices = [[0, 0, 0.1], [0, 0.1, 0.1]]",
            "picture" => "file = \"a.png\"",
            "mesh" => "file = \"a.stl\"",
            _ => "",
        };
        let text = format!("format = 1\n[[{table}]]\nkind = \"{kind}\"\n{needed}");
        let written: Table = toml::from_str(&file::write(&parse(&text))).unwrap();
        let written = written[table][0].as_table().unwrap();
        assert!(
            // A normal is written where it is given.
            keys.iter().all(|key| *key == "normal" || written.contains_key(*key)),
            "{kind}: {keys:?}, and there are {written:?}"
        );
    }
}

#[test]
fn defaults_are_those_of_an_empty_scene() {
    let mut empty: Table = toml::from_str(&file::write(&Scene::default())).unwrap();
    let circle = "format = 1\n[[target]]\nkind = \"circle\"\n[[quiet]]\n[[board]]\n[[reflector]]\n[[body]]\n";
    let circle = parse(circle);
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
    let own = [("material", Value::from(bead.material.into_str())), ("radius", bead.radius.into())];
    empty.insert("bead".to_owned(), Table::from_iter(own.map(|(key, value)| (key.to_owned(), value))).into());
    empty.insert("skin".to_owned(), Table::try_from(Skin::default()).unwrap().into());
    // And so are these; `kind` is what made it a circle.
    let Solver { quiet, search, .. } = Scene::default().solver;
    let body = Body::default();
    for (table, key, value) in [
        ("target", "kind", "point".into()),
        ("target", "visible", true.into()),
        ("target", "fill", false.into()),
        ("target", "name", "".into()),
        ("target", "group", "".into()),
        ("body", "x_axis", vec![1, 0, 0].into()),
        ("body", "length", body.length.into()),
        ("body", "size", body.size.to_array().to_vec().into()),
        ("body", "fingers", body.fingers.to_vec().into()),
        ("body", "scale", body.scale.into()),
        ("body", "coefficient", body.coefficient.into()),
        ("array", "element_size", vec![0.01, 0.01].into()),
        ("array", "element_exponent", 1.0.into()),
        ("array", "reflectivity", 0.0.into()),
        ("liquid", "reflects", false.into()),
        ("solver", "quiet", quiet.into()),
        ("solver", "search", search.into()),
        ("solver", "frames", "auto".into()),
        ("solver", "target", "pressure".into()),
        ("liquid", "light", "through".into()),
        ("liquid", "screen", Liquid::SCREEN.into()),
        ("modulation", "law", "amplitude".into()),
        ("modulation", "file", "".into()),
        ("motion", "file", "".into()),
        ("motion", "angle", 0.0.into()),
        ("motion", "foci", 1.into()),
        ("motion", "lead", false.into()),
    ] {
        empty[table].as_table_mut().unwrap().insert(key.to_owned(), value);
    }
    for Row { table, key, default, .. } in rows() {
        let own = empty.get(table).and_then(|table| table.get(key));
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
    for row in rows().iter().filter(|row| row.limits.contains('…') && !row.key.ends_with("size")) {
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
