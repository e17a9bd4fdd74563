//! Tests of the scene file.

mod documented;

use super::*;
use crate::scene::target::Sampling;
use crate::scene::zone::{Area, Zone};

fn error(text: &str) -> String {
    parse(text, Path::new("a.toml")).unwrap_err().to_string()
}

#[test]
fn defaults_that_go_without_saying_are_not_written() {
    let text = "format = 1\n[[target]]\nkind = \"circle\"\n[[quiet]]\n";
    let written = write(&parse(text, Path::new("a.toml")).unwrap());
    let [zone] = &parse(&written, Path::new("b.toml")).unwrap().quiet[..] else { panic!("{written}") };
    assert_eq!(*zone, Zone::new(Area::Circle { radius: 0.02 }, glam::DVec3::Z * 0.1));
    for key in ["spacing", "points", "pressures =", "search", "quiet =", "normal", "angle"] {
        // The solver has a key `pressures`, too.
        let count = usize::from(key == "pressures =");
        assert_eq!(written.matches(key).count(), count, "{key}: {written}");
    }
}

#[test]
fn an_empty_scene_has_the_defaults() {
    assert_eq!(parse("format = 1", Path::new("a.toml")).unwrap(), Scene::default());
}

#[test]
fn unknown_keys_are_named_with_their_line() {
    for (text, line, key) in [
        ("format = 1\n\n[array]\nrows = 8\npich = 0.01\n", 5, "pich"),
        ("format = 1\ncolour = 3\n", 2, "colour"),
        ("format = 1\n[[target]]\nkind = \"circle\"\nradis = 0.01\n", 4, "radis"),
        ("format = 1\n[[target]]\n[[target]]\nkind = \"line\"\nradius = 0.01\n", 5, "radius"),
    ] {
        let error = error(text);
        assert!(error.starts_with(&format!("a.toml:{line}: ")) && error.contains(key), "{error}");
    }
}

#[test]
fn values_out_of_range_are_named_with_key_line_and_value() {
    for (body, line, parts) in [
        ("[array]\npitch = nan", 3, "array.pitch = nan"),
        ("[array]\nrows = 3000\ncolumns = 3334", 3, "10002000 elements"),
        ("[plane]\nsize = [0.1, 0]", 3, "plane.size = [0.1, 0]"),
        ("[plane]\ny_axis = [2, 0, 0]", 3, "lies along `x_axis`"),
        ("[[target]]\nat = [0, 0, inf]", 3, "target[1].at = [0, 0, inf]"),
        ("[[target]]\nat = [0, 0, -0.1]", 2, "on or behind the array"),
        ("[[target]]\nat = [0.001, 0, 0]", 2, "on or behind the array"),
        (
            "[[target]]\n[[target]]\nkind = \"text\"\ntext = \"H木\"",
            5,
            "target[2].text = \"H木\": the stroke font has no",
        ),
        ("[[target]]\nkind = \"text\"\ntext = \"H\\nT\"", 4, "the stroke font has no glyph for `\\n`"),
        ("[[target]]\nkind = \"line\"\nspacing = 1e-9", 4, "target[1].spacing = 1e-9: 40000001 focal points"),
        ("[[target]]\nkind = \"line\"\npoints = 1000000", 4, "target[1].points = 1000000"),
        ("[[target]]\nkind = \"line\"\npoints = 4\nspacing = 0.1", 4, "not both"),
        ("[modulation]\nshape = \"tones\"", 2, "modulation.tones: `shape = \"tones\"` needs one at least"),
        ("[modulation]\nshape = \"file\"", 2, "modulation.file: `shape = \"file\"` needs the name of a WAV"),
        ("[modulation]\nlaw = \"sound\"", 3, "unknown variant `sound`"),
        (
            "[modulation]\ntones = [{ frequency = 0 }]",
            3,
            "modulation.tones[1].frequency = 0: must be a number",
        ),
        ("[modulation]\ntones = [{ phase = nan }]", 3, "modulation.tones[1].phase = nan"),
        (
            "[modulation]\ntones = [\n{ depth = 0.7 },\n{ depth = 0.5 },\n]",
            5,
            "modulation.tones[2].depth = 0.5: with the tones before it depths add up to 1.2",
        ),
        (
            &format!("[modulation]\ntones = [{}]", "{ depth = 0 }, ".repeat(17)),
            3,
            "17 are more than the 16 that a modulation may have",
        ),
        ("[motion]\nrate = 5\nspeed = 6", 4, "motion.speed = 6: give either `rate` or `speed`"),
        ("[motion]\npath = \"steps\"\nspeed = 1\n[[target]]\nstep = 0", 4, "has no length: give `rate`"),
        ("[motion]\npath = \"outline\"\n[[target]]", 3, "motion.path = \"outline\": no outline"),
        ("[[target]]\n[target.motion]\npath = \"steps\"", 4, "target[1].motion.path = \"steps\": a single"),
        ("[[target]]\n[target.motion]\npath = \"outline\"", 4, "target[1].motion.path = \"outline\": this"),
        ("[[target]]\nmotion = { path = \"circle\", frames = 1000000 }", 3, "1000000 frames"),
        ("[motion]\npath = \"points\"\npoints = []", 4, "needs the offsets"),
        ("[motion]\nangle = inf", 3, "motion.angle = inf: must be a finite number"),
        ("[motion]\npath = \"keyframes\"", 2, "motion.keyframes: `path = \"keyframes\"` needs one at least"),
        (
            "[motion]\nkeyframes = [\n{ time = 0 },\n{ time = 1 }]",
            5,
            "motion.keyframes[2].time = 1: must be a part of the cycle, from 0 to less than 1",
        ),
        (
            "[motion]\nkeyframes = [{ time = 0.5 }, { time = 0.5 }]",
            3,
            "motion.keyframes[2].time = 0.5: must be later than",
        ),
        (
            "[[target]]\n[[target]]\n[target.motion]\nkeyframes = [\n{ time = 0, pressure = 0 }]",
            6,
            "target[2].motion.keyframes[1].pressure = 0: must be a number from 0.001 to 1000",
        ),
        (
            "[motion]\nkeyframes = [{ time = 0, at = [0, 0, nan] }]",
            3,
            "motion.keyframes[1].at = [0, 0, nan]: must be a point",
        ),
        ("[motion]\nkeyframes = [{ time = 0, sise = 1 }]", 3, "unknown field `sise`"),
        ("[motion]\nkeyframes = [{ at = [0, 0, 0] }]", 3, "missing field `time`"),
        ("[motion]\nkeyframes = [{ time = 0, easing = \"slow\" }]", 3, "unknown variant `slow`"),
        ("[motion]\nkeyframes = [{ time = 0, at = [0, 0, 0, 1] }]", 3, "more values than"),
        (
            "[motion]\npath = \"keyframes\"\nkeyframes = [{ time = 0, at = [0, 0, -0.2] }]\n[[target]]",
            4,
            "on or behind the array",
        ),
        ("[motion]\npath = \"circle\"\nframes = 1000000\n[[target]]", 4, "and 1 focus need 10.2 GiB"),
        ("[motion]\npath = \"steps\"\n[[target]]\nstep = 1", 3, "no target has `step = 0`"),
        ("[[target]]\nstep = 1", 3, "target[1].step = 1: only `path = \"steps\"`"),
        ("[[target]]\npressure = 0", 3, "0 or less is no target: leave the target out"),
        ("[[target]]\npressure = -2.5", 3, "1000000000 relative to the other foci"),
        ("[[target]]\npressure = -2.5\n[solver]\npressures = \"pascal\"", 3, "1000000000 Pa (peak)"),
        ("[[target]]\npressure = 1e10", 3, "must be a number from"),
        (&"[[target]]\n".repeat(10_001), 2, "target: 10001 are more than the 10000"),
        (&format!("[[target]]\nkind = \"text\"\ntext = \"{}\"", "i".repeat(1025)), 4, "1024 characters"),
        ("[[target]]\npressures = [1]", 3, "kind `point` has no such key"),
        (
            "[[target]]\nkind = \"path\"\nvertices = [[0, 0, 0.1], [0, 0, 0.2]]\npressures = [1]",
            5,
            "1 pressures for 2",
        ),
        (
            "[[target]]\nkind = \"path\"\nvertices = [[0, 0, 0.1], [0, 0, 0.2]]\npressures = [1, 0]",
            5,
            "target[1].pressures[2] = 0: times `pressure`, must be",
        ),
        ("[[quiet]]\n[[quiet]]\nkind = \"rectangle\"\nheight = -1", 5, "quiet[2].height = -1"),
        ("[[quiet]]\nkind = \"line\"", 3, "unknown variant `line`"),
        ("[[quiet]]\nsides = 4", 3, "quiet[1].sides = 4: a zone of kind `circle` has no such key"),
        ("[[quiet]]\nnormal = [0, 0, 0]", 3, "quiet[1].normal = [0, 0, 0]"),
        ("[[quiet]]\nat = [0, 0, -0.1]", 3, "reaches on or behind the array"),
        ("[[quiet]]\nat = [0, 0, 0.01]\nnormal = [1, 0, 0]", 3, "reaches on or behind the array"),
        (&"[[quiet]]\n".repeat(65), 2, "quiet: 65 are more than the 64"),
        ("[listener]\nat = [0, 0.3, -0.1]", 3, "listener.at = [0, 0.3, -0.1]: on or behind the array"),
        ("[listener]\nat = [0, 0.3, 0.1, 9]", 3, "listener.at: the list has more values than"),
        ("[array]\nrows = \"8\"", 3, "array.rows: invalid type: string"),
    ] {
        let error = error(&format!("format = 1\n{body}\n"));
        assert!(error.starts_with(&format!("a.toml:{line}: ")), "{body}: {error}");
        assert!(error.contains(parts) && !error.contains('\n'), "{body}: {error}");
    }
}

#[test]
fn broken_files_are_refused() {
    for text in ["", "format = 2", "format = 1\n[array\n", "format = 1\n[array]\nrows = \"8\"", "\u{0}"] {
        assert!(error(text).starts_with("a.toml:"), "{text:?}");
    }
}

#[test]
fn every_kind_survives_the_file() {
    let text = r#"
        format = 1
        [[target]]
        kind = "point"
        pressure = 0.5
        name = "left \\ \"eye\""
        group = "face"
        [[target]]
        kind = "line"
        points = 5
        angle = 0.5
        visible = false
        [[target]]
        kind = "circle"
        normal = [1, 0, 1]
        [[target]]
        kind = "rectangle"
        width = 0.03
        [[target]]
        kind = "triangle"
        size = 0.05
        [[target]]
        kind = "polygon"
        sides = 5
        spacing = 0.007
        [[target]]
        kind = "path"
        vertices = [[0, 0, 0.1], [0.01, 0.02, 0.1]]
        closed = true
        pressures = [1, 0.25]
        [[target]]
        kind = "text"
        text = "é \"α\""
        [medium]
        sound_speed = 346.0
        [target.motion]
        path = "outline"
        foci = 3
        speed = 7.5
        [modulation]
        shape = "tones"
        law = "power"
        tones = [{ frequency = 150, depth = 0.5 }, { frequency = 230.5, depth = 0.25, phase = -0.5 }]
        file = "a.wav"
        [motion]
        path = "keyframes"
        keyframes = [{ time = 0 }, { time = 0.25, at = [0.01, 0, 0], pressure = 0.5, easing = "hold" }]
        angle = 0.5
        points = [[0, 0, 0.01]]
        [solver]
        pressures = "pascal"
        amplitudes = "free"
        quiet = 0.25
        search = 1.5
        [[body]]
        [[body]]
        kind = "capsule"
        at = [0.1, 0, 0.2]
        x_axis = [0, 0, 1]
        coefficient = 0.5
        [[body]]
        kind = "palm"
        at = [0, 0, 0.4]
        normal = [1, 0, -1]
        size = [0.1, 0.09, 0.03]
        [[body]]
        kind = "hand"
        at = [0, 0, 0.8]
        fingers = [10, 20, 30, 40, 110]
        edge = 0.003
        [[body]]
        kind = "mesh"
        file = "part.stl"
        scale = 0.001
        [[quiet]]
        [[quiet]]
        kind = "rectangle"
        width = 0.1
        angle = 0.5
        [[quiet]]
        kind = "polygon"
        sides = 5
        normal = [0, 1, 1]
        weight = 3
        [listener]
        at = [0, -0.3, 0.4]
    "#;
    let steps = r#"
        format = 1
        [[target]]
        step = 1
        [[target]]
        step = 0
        [motion]
        path = "steps"
        frames = 2
    "#;
    let scene = parse(steps, Path::new("a.toml")).unwrap();
    assert_eq!(parse(&write(&scene), Path::new("b.toml")).unwrap(), scene);
    let scene = parse(text, Path::new("a.toml")).unwrap();
    assert_eq!((scene.targets.len(), scene.quiet.len()), (8, 3));
    assert_eq!((scene.solver.quiet, scene.solver.search), (0.25, 1.5));
    let samplings = [
        Sampling::Whole,
        Sampling::Points(5),
        Sampling::Continuous,
        Sampling::Continuous,
        Sampling::Continuous,
        Sampling::Spacing(0.007),
    ];
    assert!(scene.targets.iter().zip(samplings).all(|(target, sampling)| target.sampling == sampling));
    assert_eq!(parse_targets(&write_targets(&scene.targets)).as_ref(), Some(&scene.targets));
    assert_eq!(parse_targets("no scene"), None);
    assert_eq!(parse(&write(&scene), Path::new("b.toml")).unwrap(), scene);
}
