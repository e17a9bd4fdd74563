//! Areas: filled shapes, broad strokes and pictures, what is wanted where, and how they stand in the file.

use std::f64::consts::PI;
use std::path::Path;

use glam::{DVec2, DVec3, dvec2, dvec3};
use sonoglyph::scene::check::{MOST_FOCI, check};
use sonoglyph::scene::{
    Cover, Focus, Grey, Part, Pixels, Sampling, Scene, Shape, Target, file, outline, rewrite,
};

const AT: DVec3 = dvec3(0.004, -0.003, 0.1);
const WAVELENGTH: f64 = 343.2 / 40e3;

fn area(shape: Shape, sampling: Sampling) -> Target {
    Target { sampling, ..Target::new(shape) }
}

fn cover(target: &Target) -> Cover {
    Cover::new(target, WAVELENGTH).unwrap().unwrap()
}

fn foci(targets: Vec<Target>) -> Vec<Focus> {
    let scene = Scene { targets, ..Scene::default() };
    check(&scene).unwrap();
    outline::foci(&scene).unwrap()
}

/// m²: the brightness of every cell, added up over the area's plane and its surroundings.
fn size(cover: &Cover, cell: f64) -> f64 {
    let counts = ((2.0 * cover.half / cell).ceil() + 4.0).to_array().map(|count| count as usize);
    let place = |i: usize, axis: usize| (i as f64 - (counts[axis] - 1) as f64 / 2.0) * cell;
    let row = |y: usize| (0..counts[0]).map(move |x| (x, y));
    let cells = (0..counts[1]).flat_map(row);
    cells.map(|(x, y)| cover.brightness(dvec2(place(x, 0), place(y, 1)), cell)).sum::<f64>() * cell * cell
}

/// A pentagram: its inside winds twice around the middle.
fn star() -> Vec<DVec3> {
    (0..5).map(|i| AT + (DVec2::from_angle(PI * (0.5 + 0.8 * f64::from(i))) * 0.02).extend(0.0)).collect()
}

#[test]
fn areas_are_as_large_as_their_formulae_say() {
    let normal = dvec3(0.3, -0.2, 1.0);
    let pentagram = {
        // Ten triangles between the middle, a tip and an inner corner.
        let inner = 0.02 * (0.1 * PI).sin() / (0.2 * PI).cos();
        5.0 * 0.02 * inner * (0.2 * PI).sin()
    };
    let line = Shape::Line { from: AT, to: AT + dvec3(0.03, 0.01, 0.01) };
    let length = dvec3(0.03, 0.01, 0.01).length();
    let stroked = |width: f64, length: f64| width * length + PI * width * width / 4.0;
    for (shape, sampling, expected) in [
        (Shape::Circle { at: AT, radius: 0.02 }, Sampling::Fill, PI * 4e-4),
        (Shape::Rectangle { at: AT, width: 0.03, height: 0.011 }, Sampling::Fill, 3.3e-4),
        (Shape::Triangle { at: AT, size: 0.03 }, Sampling::Fill, 9e-4 * 3f64.sqrt() / 4.0),
        (Shape::Polygon { at: AT, radius: 0.02, sides: 6 }, Sampling::Fill, 6e-4 * 3f64.sqrt()),
        (Shape::Path { vertices: star(), closed: true }, Sampling::Fill, pentagram),
        (line.clone(), Sampling::Stroke(0.006), stroked(0.006, length)),
        (line, Sampling::Stroke(0.0002), stroked(0.0002, length)),
        (
            Shape::Circle { at: AT, radius: 0.02 },
            Sampling::Stroke(0.004),
            PI * (0.022f64.powi(2) - 0.018f64.powi(2)),
        ),
        (
            Shape::Text { text: "I".to_owned(), at: AT, height: 0.03 },
            Sampling::Stroke(0.008),
            stroked(8e-3, 0.03),
        ),
    ] {
        for angle in [0.0, 0.7] {
            let plain = area(shape.clone(), sampling);
            let turned = match shape {
                Shape::Line { .. } | Shape::Path { .. } => Target { angle, ..plain },
                _ => Target { angle, normal, ..plain },
            };
            let cover = cover(&turned);
            for cell in [0.3e-3, 2.1e-3] {
                let own = size(&cover, cell);
                assert!((own / expected - 1.0).abs() < 0.012, "{turned:?}, {cell}: {own}, not {expected}");
            }
            assert!(cover.brightness(dvec2(0.0, 1.0), 2e-3) == 0.0, "nothing far away");
            if let Shape::Circle { .. } = shape {
                assert!(
                    cover.axes[0].cross(cover.axes[1]).distance(turned.normal.normalize_or_zero()) < 1e-12
                );
            }
        }
    }
}

#[test]
fn samples_lie_inside_half_a_wavelength_apart_and_want_what_the_area_wants() {
    let mut disc = area(Shape::Circle { at: AT, radius: 0.02 }, Sampling::Fill);
    (disc.pressure, disc.normal) = (2.0, dvec3(1.0, 0.0, 2.0));
    let samples = foci(vec![Target::new(Shape::Point { at: AT }), disc.clone()]);
    assert_eq!((samples[0].part, samples[0].is_separate()), (Part::Point, true));
    let samples = &samples[1..];
    for sample in samples {
        assert_eq!((sample.part, sample.target), (Part::Area(1), 2.0));
        assert!(sample.position.distance(AT) < 0.02, "{sample:?}");
        assert!((sample.position - AT).dot(disc.normal).abs() < 1e-12, "{sample:?}");
        let others = samples.iter().filter(|other| other.position != sample.position);
        let nearest = others.map(|other| other.position.distance(sample.position)).fold(1.0, f64::min);
        assert!((0.25 * WAVELENGTH..0.51 * WAVELENGTH).contains(&nearest), "{nearest}");
    }
    let dense = PI * 4e-4 / (WAVELENGTH / 2.0).powi(2);
    assert!((0.85..1.35).contains(&(samples.len() as f64 / dense)), "{} for {dense}", samples.len());
}

#[test]
fn what_is_tiny_has_a_sample_and_what_is_huge_has_them_farther_apart() {
    for size in [1e-9, 1e-5, 4e-4] {
        for target in [
            area(Shape::Circle { at: AT, radius: size }, Sampling::Fill),
            area(Shape::Triangle { at: AT, size }, Sampling::Fill),
            area(Shape::Line { from: AT, to: AT + DVec3::X * size }, Sampling::Stroke(1e-9)),
        ] {
            let samples = foci(vec![target.clone()]);
            assert!((1..=2).contains(&samples.len()), "{target:?}: {samples:?}");
            assert!(samples.iter().all(|it| it.position.distance(AT) <= 2.0 * size && it.target == 1.0));
        }
    }
    let thin = area(Shape::Circle { at: AT, radius: 0.03 }, Sampling::Stroke(1e-5));
    for sample in foci(vec![thin]) {
        assert!((sample.position.distance(AT) - 0.03).abs() < 1e-3, "{sample:?}");
    }
    for size in [0.4, 90.0] {
        let vast = area(Shape::Rectangle { at: AT, width: size, height: size }, Sampling::Fill);
        let line = Target::new(Shape::Line { from: AT, to: AT + DVec3::X * size });
        for (targets, least) in
            [(vec![vast.clone()], 700), (vec![vast.clone(), line], 500), (vec![vast; 5], 600)]
        {
            let count = foci(targets).len();
            assert!((least..=MOST_FOCI).contains(&count), "{size}: {count}");
        }
    }
}

fn picture(width: usize, height: usize, brightness: impl Fn(usize, usize) -> f32) -> Target {
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let brightness = pixels.map(|(x, y)| brightness(x, y)).collect();
    let pixels = Pixels::new(Grey { file: None, width, height, brightness });
    Target::new(Shape::Picture { file: "a.png".to_owned(), at: AT, width: 0.04, pixels })
}

#[test]
fn the_brightness_of_a_picture_is_the_wanted_pressure_squared() {
    // White at the top left, grey at the right.
    let target = picture(40, 20, |x, y| {
        if x < 20 && y < 10 {
            1.0
        } else if x >= 20 {
            0.25
        } else {
            0.0
        }
    });
    let cover = cover(&target);
    assert_eq!(cover.half, dvec2(0.02, 0.01));
    for (x, y, brightness) in [(-10.0, 5.0, 1.0), (-10.0, -5.0, 0.0), (10.0, 5.0, 0.25), (10.0, -5.0, 0.25)] {
        let own = cover.brightness(dvec2(x, y) * 1e-3, 2e-3);
        assert!((own - brightness).abs() < 1e-6, "({x}, {y}): {own}");
    }
    let edge = cover.brightness(dvec2(-10e-3, 0.0), 2e-3);
    assert!((edge - 0.5).abs() < 1e-6, "half of the cell is white: {edge}");
    for sample in foci(vec![Target { pressure: 3.0, ..target }]) {
        let at = sample.position - AT;
        let expected = if at.x > 1e-3 { 1.5 } else { 3.0 };
        assert!((sample.target - expected).abs() < 0.3, "{sample:?}");
        assert!(at.x > -1e-3 || at.y > -1e-3, "nothing where it is black: {sample:?}");
    }
    let black = picture(3, 3, |_, _| 0.0);
    let error = outline::foci(&Scene { targets: vec![black], ..Scene::default() }).unwrap_err();
    assert_eq!(error.to_string(), "target[1].file: the picture is black: it prescribes no sound");
}

fn parse(text: &str) -> Result<Scene, String> {
    file::parse(&format!("format = 1\n{text}"), Path::new("a.toml")).map_err(|error| error.to_string())
}

#[test]
fn keys_that_make_no_area_are_refused_by_name() {
    for (text, error) in [
        ("kind = \"line\"\nfill = true", "4: target[1].fill = true: a line has no inside"),
        ("kind = \"text\"\nfill = true", "4: target[1].fill = true: letters are strokes: give `stroke`"),
        ("fill = true", "3: target[1].fill = true: a target of kind `point` has no such key"),
        ("stroke = 0.1", "3: target[1].stroke = 0.1: a target of kind `point` has no such key"),
        (
            "kind = \"path\"\nvertices = [[0, 0, 0.1], [0, 0.1, 0.1], [0.1, 0, 0.1]]\nfill = true",
            "5: target[1].fill = true: an open path has no inside: give `closed = true`",
        ),
        (
            "kind = \"path\"\nvertices = [[0, 0, 0.1], [0, 0.1, 0.1], [0, 0.2, 0.1]]\nclosed = true\nfill = true",
            "6: target[1].fill = true: the path encloses no area",
        ),
        (
            "kind = \"path\"\nvertices = [[0, 0, 0.1], [0, 0.1, 0.1], [0.1, 0, 0.1], [0.1, 0.1, 0.12]]\nstroke = 0.01",
            "4: target[1].vertices = [[0, 0, 0.1], [0, 0.1, 0.1], [0.1, 0, 0.1], [0.1, 0.1, 0.12]]: the path is not flat",
        ),
        (
            "kind = \"path\"\nvertices = [[0, 0, 0.1], [0, 0.1, 0.1]]\npressures = [1, 2]\nstroke = 0.01",
            "5: target[1].pressures = [1, 2]: an area has one pressure",
        ),
        (
            "kind = \"circle\"\nfill = true\nspacing = 0.01",
            "4: target[1].fill = true: give either `spacing` or `fill`",
        ),
        (
            "kind = \"circle\"\npoints = 9\nstroke = 0.01",
            "5: target[1].stroke = 0.01: give either `points` or `stroke`",
        ),
        (
            "kind = \"circle\"\nfill = true\nstroke = 0.01",
            "5: target[1].stroke = 0.01: give either `fill` or `stroke`",
        ),
        ("kind = \"circle\"\nstroke = 0", "4: target[1].stroke = 0: must be a length in metres"),
        ("kind = \"circle\"\nfill = 1", "4: target[1].fill: invalid type"),
        ("kind = \"picture\"", "2: target[1].file: a target of kind `picture` needs the `file`"),
        ("kind = \"picture\"\nfile = \"\"", "4: target[1].file = \"\": there is no name"),
        (
            "kind = \"picture\"\nfile = \"a.png\"\nfill = true",
            "5: target[1].fill = true: a target of kind `picture`",
        ),
        ("kind = \"picture\"\nfile = \"a.png\"\nwidth = -1", "5: target[1].width = -1: must be a length"),
        ("kind = \"circle\"\nfile = \"a.png\"", "4: target[1].file = \"a.png\": a target of kind `circle`"),
    ] {
        let said = parse(&format!("[[target]]\n{text}\n")).unwrap_err();
        assert!(said.starts_with(&format!("a.toml:{error}")), "{text}\n{said}");
    }
}

const FILE: &str = "format = 1\n[[target]] # round\nkind = \"circle\"\nfill = true\n[[target]]\nkind = \"text\"\nstroke = 0.008 # broad\n\
    [[target]]\nkind = \"picture\"\nfile = \"a.png\" # ours\nwidth = 0.05\n";

#[test]
fn areas_survive_the_file_and_its_comments_do_too() {
    let scene = file::parse(FILE, Path::new("a.toml")).unwrap();
    let ways: Vec<_> = scene.targets.iter().map(|target| target.sampling).collect();
    assert_eq!(ways, [Sampling::Fill, Sampling::Stroke(0.008), Sampling::Whole]);
    assert!(scene.targets.iter().all(Target::is_area) && outline::is_continuous(&scene));
    assert_eq!(file::parse(&file::write(&scene), Path::new("b.toml")).unwrap(), scene);
    let tables = serde_json::to_value(&scene).unwrap();
    assert_eq!(file::from_tables::<serde_json::Value>(tables).unwrap(), scene);

    // Pixels are no part of the file.
    let mut loaded = scene.clone();
    let pixels = match picture(2, 1, |_, _| 1.0).shape {
        Shape::Picture { pixels, .. } => pixels,
        other => panic!("{other:?}"),
    };
    let Shape::Picture { pixels: own, .. } = &mut loaded.targets[2].shape else { panic!("no picture") };
    *own = pixels;
    assert_ne!(loaded, scene);
    assert_eq!(rewrite::rewrite(FILE, &loaded), FILE);
    loaded.targets[0].sampling = Sampling::Stroke(0.003);
    loaded.targets[1].sampling = Sampling::Continuous;
    let text = rewrite::rewrite(FILE, &loaded);
    assert!(text.contains("# round") && text.contains("file = \"a.png\" # ours"), "{text}");
    assert!(text.contains("stroke = 0.003") && !text.contains("fill") && !text.contains("0.008"), "{text}");
    let error = outline::foci(&scene).unwrap_err().to_string();
    assert_eq!(error, "target[3].file: the picture is not loaded");
}
