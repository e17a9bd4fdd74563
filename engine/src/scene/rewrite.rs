//! Writes a scene into the text it was read from, changing only what differs: comments, order and number formats
//! survive.

use std::path::Path;

use toml_edit::{ArrayOfTables, DocumentMut, Item, Table, TableLike};

use crate::scene::motion::Routes;
use crate::scene::{
    board::Elements, content::Scene, directivity::Directivity, drive::DriveFile, file, pixels::Pixels,
    skin::Curve, wave::Wave, wires::Wires,
};

/// Repeated tables.
const REPEATED: [&str; 5] = ["board", "reflector", "body", "target", "quiet"];

/// The text updated to the scene: unchanged to the byte if it already holds the scene. If the text is not a scene, or
/// its layout cannot hold this one, the scene is written from scratch.
pub fn rewrite(text: &str, scene: &Scene) -> String {
    let name = Path::new("scene");
    let Ok(before) = file::parse(text, name) else { return file::write(scene) };
    let scene = &as_written(scene);
    if before == *scene {
        return text.to_owned();
    }
    let holds_it = |text: &String| file::parse(text, name).is_ok_and(|written| written == *scene);
    let rewritten = |keys| rewritten(text, &before, scene, keys).filter(holds_it);
    rewritten(Keys::Changed).or_else(|| rewritten(Keys::All)).unwrap_or_else(|| file::write(scene))
}

/// The scene as in its file: without pixels, drives, tables of elements and wires, directivity, waveform samples, thresholds and
/// surfaces of bodies.
fn as_written(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    (scene.array.placed, scene.array.wires) = (Elements::default(), Wires::default());
    scene.array.measured = Directivity::default();
    scene.drive = DriveFile::named(std::mem::take(&mut scene.drive.name));
    for target in &mut scene.targets {
        if let Some((_, pixels)) = target.shape.picture_mut() {
            *pixels = Pixels::default();
        }
    }
    scene.modulations_mut().for_each(|(_, modulation)| modulation.wave = Wave::default());
    let own = scene.targets.iter_mut().filter_map(|target| target.motion.as_mut());
    own.chain([&mut scene.motion]).for_each(|motion| motion.routes = Routes::default());
    scene.bodies.iter_mut().for_each(|body| *body = body.as_written());
    if let Some(skin) = &mut scene.skin {
        skin.curve = Curve::default();
    }
    scene
}

/// The keys to write of a changed table.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Keys {
    Changed,
    /// All keys, since a default depends on another changed key.
    All,
}

fn rewritten(text: &str, before: &Scene, after: &Scene, keys: Keys) -> Option<String> {
    let document = |text: &str| text.parse::<DocumentMut>().ok();
    let mut own = document(text)?;
    let (before, after) = (document(&file::write(before))?, document(&file::write(after))?);
    for (key, item) in after.iter().filter(|(key, _)| !REPEATED.contains(key)) {
        let old = before.get(key);
        match item.as_table_like() {
            Some(table) if old.is_some() => {
                update(own.entry(key).or_insert_with(empty), old.and_then(Item::as_table_like), table, keys)?;
            }
            Some(_) => drop(own.insert(key, item.clone())),
            None => set(own.as_table_mut(), key, old, item, keys)?,
        }
    }
    for (key, _) in before.iter().filter(|(key, _)| !REPEATED.contains(key) && after.get(key).is_none()) {
        own.remove(key);
    }
    for key in REPEATED {
        repeated(&mut own, &before, &after, key, keys)?;
    }
    // An empty table was only created for the lookup.
    let is_idle =
        |item: &Item| item.as_table().is_some_and(|table| table.is_empty() && table.position().is_none());
    let idle: Vec<String> =
        own.iter().filter(|(_, item)| is_idle(item)).map(|(key, _)| key.to_owned()).collect();
    for key in idle {
        own.remove(&key);
    }
    Some(own.to_string())
}

fn empty() -> Item {
    let mut table = Table::new();
    table.decor_mut().set_prefix("\n");
    Item::Table(table)
}

/// Writes the changed keys of a table.
fn update(own: &mut Item, before: Option<&dyn TableLike>, after: &dyn TableLike, keys: Keys) -> Option<()> {
    let own = own.as_table_like_mut()?;
    let is_same = |key: &str, item: &Item| {
        before.and_then(|before| before.get(key)).is_some_and(|before| before.to_string() == item.to_string())
    };
    let count = |table: &dyn TableLike| table.iter().count();
    let is_changed =
        before.map(count) != Some(count(after)) || after.iter().any(|(key, item)| !is_same(key, item));
    for (key, item) in after.iter() {
        set(own, key, before.and_then(|before| before.get(key)), item, keys)?;
        if keys == Keys::All && is_changed && !own.contains_key(key) {
            own.insert(key, without_place(item.clone()));
        }
    }
    let gone: Vec<String> = match keys {
        Keys::All if is_changed => own.iter().map(|(key, _)| key.to_owned()).collect(),
        Keys::All | Keys::Changed => {
            before.into_iter().flat_map(|before| before.iter()).map(|(key, _)| key.to_owned()).collect()
        }
    };
    for key in gone.iter().filter(|key| after.get(key).is_none()) {
        own.remove(key);
    }
    Some(())
}

/// Writes a changed value and keeps the comment behind it.
fn set(own: &mut dyn TableLike, key: &str, before: Option<&Item>, after: &Item, keys: Keys) -> Option<()> {
    if before.is_some_and(|before| before.to_string() == after.to_string()) {
        return Some(());
    }
    let inner = own.get_mut(key).filter(|item| item.is_table_like());
    if let (Some(inner), Some(table)) = (inner, after.as_table_like()) {
        return update(inner, before.and_then(Item::as_table_like), table, keys);
    }
    let mut item = without_place(after.clone());
    match (own.get_mut(key).and_then(Item::as_value_mut), item.as_value_mut()) {
        (Some(old), Some(new)) => {
            *new.decor_mut() = old.decor().clone();
            *old = new.clone();
        }
        _ => drop(own.insert(key, item)),
    }
    Some(())
}

/// The table without its position in another text, so that it follows its parent.
fn without_place(mut item: Item) -> Item {
    if let Some(table) = item.as_table_mut() {
        table.set_position(None);
    }
    item
}

/// Every target or zone keeps its table and comments when the order changes.
fn repeated(
    own: &mut DocumentMut,
    before: &DocumentMut,
    after: &DocumentMut,
    key: &str,
    keys: Keys,
) -> Option<()> {
    let tables = |document: &DocumentMut| -> Vec<Table> {
        let tables = document.get(key).and_then(Item::as_array_of_tables);
        tables.map(|tables| tables.iter().cloned().collect()).unwrap_or_default()
    };
    let (before, after) = (tables(before), tables(after));
    // The text of a table excludes its subtables.
    let text = |table: &Table| table.clone().into_inline_table().to_string();
    if before.iter().map(text).eq(after.iter().map(text)) {
        return Some(());
    }
    let mut written: Vec<Option<Table>> = tables(own).into_iter().map(Some).collect();
    // Inline or missing: rewriting loses nothing.
    written.resize(before.len(), None);
    let mut places: Vec<_> = written.iter().flatten().map(Table::position).collect();
    places.sort_unstable();
    let origins =
        origins(&before.iter().map(text).collect::<Vec<_>>(), &after.iter().map(text).collect::<Vec<_>>());
    let mut made = ArrayOfTables::new();
    for (index, (table, origin)) in after.iter().zip(origins).enumerate() {
        let mut item = match origin.and_then(|origin| Some((origin, written[origin].take()?))) {
            Some((origin, own)) => {
                let mut own = Item::Table(own);
                update(&mut own, Some(&before[origin]), table, keys)?;
                own
            }
            None => Item::Table(table.clone()),
        };
        let own = item.as_table_mut()?;
        own.set_position(places.get(index).copied().flatten());
        own.iter_mut().filter_map(|(_, item)| item.as_table_mut()).for_each(|inner| inner.set_position(None));
        made.push(own.clone());
    }
    if made.is_empty() {
        own.remove(key);
    } else {
        own.insert(key, Item::ArrayOfTables(made));
    }
    Some(())
}

/// The former table of each new one: the identical one, or the one formerly at its index unless used elsewhere.
fn origins(before: &[String], after: &[String]) -> Vec<Option<usize>> {
    let mut is_free = vec![true; before.len()];
    let mut origins: Vec<Option<usize>> = after
        .iter()
        .map(|table| {
            let same = (0..before.len()).find(|&i| is_free[i] && before[i] == *table)?;
            is_free[same] = false;
            Some(same)
        })
        .collect();
    // Removed tables shift later ones up by at most their number.
    let mut left = (0..before.len()).filter(|&i| is_free[i]).collect::<Vec<_>>().into_iter();
    if before.len() == after.len() {
        for origin in origins.iter_mut().filter(|origin| origin.is_none()) {
            *origin = left.next();
        }
    }
    origins
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::mesh::shapes;
    use crate::scene::body::{Body, BodyKind, Surface};
    use crate::scene::directivity::Reading;
    use crate::scene::motion::{Motion, MotionPath, Tempo};
    use crate::scene::target::{Sampling, Target};
    use crate::scene::{shape::Shape, solver::Method};

    const TEXT: &str = r#"# A scene by hand.
format = 1   # the only one

[array]
# Ours is small.
rows = 8
pitch = 10.5e-3  # m

# The left one.
[[target]]
at = [-0.02, 0, 0.1]

# The right one,
[[target]]   # a circle
kind = "circle"
radius = 0.010 # m
spacing = 0.008

[solver]
method = "gs"  # quick
# The end.
"#;

    fn scene(text: &str) -> Scene {
        file::parse(text, Path::new("a.toml")).unwrap()
    }

    /// Lines that differ between two texts.
    fn changes(after: &str) -> Vec<String> {
        let has = |text: &str, line: &str| text.lines().any(|own| own == line);
        let gone = TEXT.lines().filter(|line| !has(after, line)).map(|line| format!("- {line}"));
        let new = after.lines().filter(|line| !has(TEXT, line)).map(|line| format!("+ {line}"));
        gone.chain(new).collect()
    }

    fn edited(edit: impl FnOnce(&mut Scene)) -> String {
        let mut scene = scene(TEXT);
        edit(&mut scene);
        let text = rewrite(TEXT, &scene);
        assert_eq!(file::parse(&text, Path::new("b.toml")).unwrap(), scene, "{text}");
        text
    }

    #[test]
    fn a_scene_without_changes_is_the_same_to_the_byte() {
        assert_eq!(edited(|_| {}), TEXT);
    }

    #[test]
    fn only_the_lines_that_changed_are_written() {
        let text = edited(|scene| {
            scene.array.pitch = 0.011;
            scene.solver.method = Method::Wgs;
            scene.targets[1].shape = Shape::Circle { at: DVec3::new(0.0, 0.0, 0.1), radius: 0.02 };
        });
        assert_eq!(
            changes(&text),
            [
                "- pitch = 10.5e-3  # m",
                "- radius = 0.010 # m",
                "- method = \"gs\"  # quick",
                "+ pitch = 0.011  # m",
                "+ radius = 0.02 # m",
                "+ method = \"wgs\"  # quick"
            ]
        );
    }

    #[test]
    fn keys_come_and_go() {
        let text = edited(|scene| {
            scene.targets[1].sampling = Sampling::Points(9);
            scene.liquid.depth = 0.02;
            scene.listener = Some(crate::scene::Listener { at: DVec3::new(0.0, -0.3, 0.4) });
        });
        assert!(text.contains("points = 9") && !text.contains("spacing"), "{text}");
        assert!(text.contains("\n\n[liquid]\ndepth = 0.02\n") && text.contains("\n\n[listener]\n"), "{text}");
        assert!(!text.contains("[medium]") && !text.contains("[motion]"), "{text}");
        let back = rewrite(&text, &scene(TEXT));
        assert_eq!(scene(&back), scene(TEXT));
        assert!(back.contains("# Ours is small.") && !back.contains("listener"), "{back}");
    }

    #[test]
    fn targets_take_their_comments_along() {
        let text = edited(|scene| scene.targets.swap(0, 1));
        let at = |what: &str| text.find(what).unwrap_or_else(|| panic!("{what} in {text}"));
        assert!(at("# The right one,") < at("# a circle") && at("# a circle") < at("# The left one."));
        assert!(at("# The left one.") < at("[solver]"), "{text}");
        let text = edited(|scene| {
            scene.targets.remove(0);
            scene.targets.push(Target::new(Shape::Point { at: DVec3::new(0.0, 0.01, 0.1) }));
        });
        assert!(text.contains("# The left one.") || text.contains("# The right one,"), "{text}");
        let text = edited(|scene| scene.targets.clear());
        assert!(
            !text.contains("target") && text.contains("# quick") && text.contains("# Ours is small."),
            "{text}"
        );
        let text = edited(|scene| scene.targets.push(scene.targets[0].clone()));
        assert!(text.contains("# The left one.") && text.contains("# a circle"), "{text}");
    }

    #[test]
    fn zones_take_their_comments_along() {
        let text = "format = 1\n\n# An ear.\n[[quiet]]\nradius = 0.010 # m\n\n# A hand.\n[[quiet]] # flat\n\n[solver]\nquiet = 0.9 # much\n";
        let mut edited = scene(text);
        edited.quiet[1].weight = 2.0;
        edited.solver.search = 1.0;
        let written = rewrite(text, &edited);
        assert_eq!(scene(&written), edited, "{written}");
        for part in
            ["# An ear.\n[[quiet]]\nradius = 0.010 # m", "# A hand.", "weight = 2.0", "quiet = 0.9 # much"]
        {
            assert!(written.contains(part), "{part} in {written}");
        }
        edited.quiet.clear();
        edited.solver.quiet = crate::scene::Solver::QUIET;
        let written = rewrite(&written, &edited);
        assert!(scene(&written) == edited && !written.contains("quiet"), "{written}");
    }

    #[test]
    fn bodies_come_and_go_and_keep_their_comments() {
        let text = "format = 1\n\n# A tip.\n[[body]]\nradius = 0.0080 # m\n\n# A hand.\n[[body]] # mine\nkind = \"palm\"\nat = [0, 0, 0.2]\n\n[solver]\nquiet = 0.9 # much\n";
        let mut edited = scene(text);
        edited.bodies[1].fingers[2] = 30.0;
        edited.bodies[1].kind = BodyKind::Hand;
        edited.bodies[0].length = 0.9;
        let written = rewrite(text, &edited);
        for part in
            ["# A tip.\n[[body]]\nradius = 0.0080 # m", "# A hand.\n[[body]] # mine", "fingers = [", "# much"]
        {
            assert!(written.contains(part), "{part} in {written}");
        }
        edited.bodies[0].length = Body::default().length;
        assert_eq!(scene(&written), edited, "a sphere has no length");
        edited.bodies.remove(0);
        edited.bodies.push(Body { kind: BodyKind::Capsule, at: DVec3::Z * 0.5, ..Body::default() });
        let written = rewrite(&written, &edited);
        assert!(scene(&written) == edited && written.contains("# A hand."), "{written}");
        edited.bodies.clear();
        let written = rewrite(&written, &edited);
        assert!(
            scene(&written) == edited && !written.contains("body") && written.contains("# much"),
            "{written}"
        );
    }

    #[test]
    fn loaded_files_change_no_text() {
        let text = "format = 1 # own\n[array]\nelement = \"measured\"\ndirectivity = \"d.csv\" # ours\n[[body]]\nkind = \"mesh\" # m\nfile = \"a.obj\"\n";
        let mut loaded = scene(text);
        let reading = |angle| Reading { angle, amplitude: 1.0, phase: 0.0 };
        loaded.array.measured = Directivity::new(vec![reading(0.0), reading(90.0)], None);
        loaded.bodies[0].surface = Surface::new(shapes::sphere(0.01, 0.005), None);
        assert_eq!(rewrite(text, &loaded), text);
    }

    #[test]
    fn keyframes_stay_in_line_and_keep_what_stands_around_them() {
        let text = r#"format = 1
[[target]] # first
[target.motion] # its own
path = "keyframes" # by hand
keyframes = [{ time = 0 }, { time = 0.5, at = [0.01, 0, 0] }] # two
[[target]] # second
at = [0.01, 0, 0.1]
"#;
        let mut scene = file::parse(text, Path::new("a.toml")).unwrap();
        assert_eq!(rewrite(text, &scene), text);
        let own = scene.targets[0].motion.as_mut().unwrap();
        own.keyframes[1].pressure = 0.5;
        let written = rewrite(text, &scene);
        assert_eq!(file::parse(&written, Path::new("b.toml")).unwrap(), scene);
        for comment in ["# first", "# its own", "# by hand", "# two", "# second"] {
            assert!(written.contains(comment), "{comment}: {written}");
        }
        assert!(written.contains("{ time = 0.5, at = [0.01, 0.0, 0.0], pressure = 0.5 },\n]"), "{written}");
    }

    #[test]
    fn motions_of_targets_keep_their_comments_and_stay_with_their_target() {
        let text = r#"format = 1

# It stands.
[[target]]
at = [0.0, 0.0, 0.2] # m

[target.motion] # its own
path = "none"

# It moves.
[[target]]
motion = { path = "line", rate = 3 }

[[target]]
motion.path = "circle" # round

[[target]]
kind = "circle"

[motion]
path = "circle" # all
"#;
        let before = scene(text);
        let with = |edit: &dyn Fn(&mut Scene)| {
            let mut edited = before.clone();
            edit(&mut edited);
            let written = rewrite(text, &edited);
            assert_eq!(scene(&written), edited, "{written}");
            for comment in ["# It stands.", "# It moves.", "# m", "# its own", "# all"] {
                assert!(written.contains(comment), "{comment} in {written}");
            }
            written
        };
        let own = |path| Some(Motion { path, ..Motion::default() });
        with(&|scene| scene.targets.swap(0, 1));
        with(&|scene| scene.targets.rotate_left(1));
        with(&|scene| scene.targets[0].motion = own(MotionPath::Circle));
        with(&|scene| scene.targets[1].motion = own(MotionPath::Square));
        with(&|scene| scene.targets[2].motion = None);
        with(&|scene| {
            scene.targets.push(Target { motion: own(MotionPath::Line), ..scene.targets[0].clone() });
        });
        // The usual tempo of an outline is another one.
        for tempo in [Tempo::Rate(5.0), Tempo::Speed(6.0), Tempo::Speed(7.0)] {
            with(&|scene| (scene.motion.path, scene.motion.tempo) = (MotionPath::Outline, tempo));
            with(&|scene| {
                scene.targets[3].motion = Some(Motion { tempo, ..own(MotionPath::Outline).unwrap() });
            });
        }
    }

    #[test]
    fn other_layouts_are_held_too() {
        for text in [
            "format = 1\ntarget = [{ at = [0, 0, 0.1] }, { kind = \"circle\" }]\n",
            "format = 1\nsolver.method = \"gs\" # dotted\narray = { rows = 4 }\n[[target]]\n",
            "format = 1\n",
        ] {
            let mut scene = scene(text);
            scene.solver.method = Method::Naive;
            scene.array.rows = 5;
            scene.targets.push(Target::new(Shape::Circle { at: DVec3::new(0.0, 0.0, 0.2), radius: 0.01 }));
            let written = rewrite(text, &scene);
            assert_eq!(file::parse(&written, Path::new("b.toml")).unwrap(), scene, "{written}");
        }
        assert_eq!(rewrite("broken", &Scene::default()), file::write(&Scene::default()));
    }
}
