//! Continuous strokes: where their samples lie, how many there are, and what is wanted of each.

use std::path::Path;

use glam::{DVec3, dvec3};
use sonoglyph::scene::check::{MOST_FOCI, check};
use sonoglyph::scene::{Focus, Sampling, Scene, Shape, Target, file, outline};

const AT: DVec3 = dvec3(0.004, -0.003, 0.1);

fn scene(targets: Vec<Target>) -> Scene {
    let scene = Scene { targets, ..Scene::default() };
    check(&scene).unwrap();
    scene
}

fn foci(shape: Shape) -> Vec<Focus> {
    outline::foci(&scene(vec![Target::new(shape)])).unwrap()
}

fn shapes(size: f64) -> Vec<Shape> {
    let to = AT + dvec3(0.3, 0.4, 0.2) * size;
    vec![
        Shape::Line { from: AT, to },
        Shape::Circle { at: AT, radius: size },
        Shape::Rectangle { at: AT, width: size, height: 0.3 * size },
        Shape::Triangle { at: AT, size },
        Shape::Polygon { at: AT, radius: size, sides: 7 },
        Shape::Path { vertices: vec![AT, to, AT + DVec3::X * size], closed: true },
        Shape::Path { vertices: vec![AT, AT + DVec3::Y * size, to], closed: false },
        Shape::Text { text: "HIT".to_owned(), at: AT, height: size },
        Shape::Text { text: "Océ α8.".to_owned(), at: AT, height: size },
    ]
}

/// m from a point to the nearest place on polylines.
fn distance(strokes: &[Vec<DVec3>], point: DVec3) -> f64 {
    let to_piece = |pair: &[DVec3]| {
        let along = pair[1] - pair[0];
        let part = ((point - pair[0]).dot(along) / along.length_squared().max(1e-30)).clamp(0.0, 1.0);
        point.distance(pair[0] + along * part)
    };
    // A full stop is a stroke of one vertex.
    let to_vertices = strokes.iter().flatten().map(|vertex| vertex.distance(point));
    let to_pieces = strokes.iter().flat_map(|stroke| stroke.windows(2)).map(to_piece);
    to_pieces.chain(to_vertices).fold(f64::INFINITY, f64::min)
}

/// m: the longest way along an outline, in steps of 20 µm, on which no sample lies; samples may be `sagitta` off.
fn longest_gap(strokes: &[Vec<DVec3>], samples: &[Focus], sagitta: f64) -> f64 {
    const STEP: f64 = 2e-5;
    let mut longest = 0.0f64;
    for stroke in strokes {
        let mut gap = 0.0;
        for pair in stroke.windows(2) {
            let steps = (pair[0].distance(pair[1]) / STEP).ceil().max(1.0);
            for i in 0..steps as usize {
                let place = pair[0].lerp(pair[1], i as f64 / steps);
                let is_sample =
                    samples.iter().any(|sample| sample.position.distance(place) < 0.75 * STEP + sagitta);
                gap = if is_sample { 0.0 } else { gap + pair[0].distance(pair[1]) / steps };
                longest = longest.max(gap);
            }
        }
    }
    longest
}

#[test]
fn samples_lie_on_the_stroke_at_most_a_quarter_of_a_wavelength_apart() {
    for shape in shapes(0.03) {
        let scene = scene(vec![Target::new(shape.clone())]);
        let (quarter, samples) = (scene.wavelength() / 4.0, outline::foci(&scene).unwrap());
        assert!((quarter - 343.2 / 40e3 / 4.0).abs() < 1e-6);
        let strokes = outline::strokes(&scene.targets[0]).unwrap();
        // A circle is drawn as a polygon of 96 corners.
        let sagitta = if matches!(shape, Shape::Circle { .. }) { 0.03 * 6e-4 } else { 1e-9 };
        for sample in &samples {
            assert!(distance(&strokes, sample.position) < sagitta, "{shape:?}: {sample:?}");
            assert!(!sample.is_separate() && sample.target == 1.0);
        }
        let gap = longest_gap(&strokes, &samples, sagitta);
        assert!(gap < quarter + 5e-5, "{shape:?}: {gap}");
        // And no denser than that asks for.
        let length: f64 = strokes.iter().flat_map(|it| it.windows(2)).map(|it| it[0].distance(it[1])).sum();
        let corners = 60;
        assert!(samples.len() < (length / quarter) as usize + corners, "{shape:?}: {}", samples.len());
    }
}

#[test]
fn what_is_short_has_few_samples_and_what_is_long_has_them_farther_apart() {
    for size in [1e-9, 1e-5, 4e-4] {
        for shape in shapes(size) {
            let samples = foci(shape.clone());
            let fewest = if matches!(shape, Shape::Line { .. } | Shape::Circle { .. }) { 2 } else { 60 };
            assert!((1..=fewest).contains(&samples.len()), "{shape:?}: {}", samples.len());
        }
    }
    for size in [6.0, 90.0] {
        for mut shape in shapes(size) {
            if let Shape::Line { to, .. } = &mut shape {
                to.z = AT.z;
            }
            let samples = foci(shape.clone());
            assert!((800..=MOST_FOCI).contains(&samples.len()), "{shape:?}: {}", samples.len());
        }
    }
    // The foci of other targets are left to them, and every stroke is thinned alike.
    let line = |x: f64, length: f64| Shape::Line { from: AT + DVec3::X * x, to: dvec3(x, length, 0.1) };
    let separate = Target { sampling: Sampling::Points(900), ..Target::new(line(0.0, 1.0)) };
    let scene = scene(vec![Target::new(line(0.1, 1.0)), separate, Target::new(line(0.2, 2.0))]);
    let foci = outline::foci(&scene).unwrap();
    let of = |x: f64| foci.iter().filter(|focus| (focus.position.x - x).abs() < 0.01).count();
    assert_eq!(of(0.0), 900);
    assert!((1020..=MOST_FOCI).contains(&foci.len()), "{}", foci.len());
    assert!(of(0.2).abs_diff(2 * of(0.1)) <= 3, "{} and {}", of(0.1), of(0.2));
}

#[test]
fn pressures_go_evenly_from_vertex_to_vertex_of_a_path() {
    let text = "format = 1\n[[target]]\nkind = \"path\"\npressure = 2\npressures = [1, 3, 3, 0.5]\nangle = 1.0\n\
                vertices = [[0, 0, 0.1], [0.02, 0, 0.1], [0.02, 0, 0.1], [0.02, 0.04, 0.1]]\n";
    let parse = |text: &str| file::parse(text, Path::new("path.toml")).unwrap();
    for sampling in ["", "spacing = 0.005\n", "points = 13\n", "closed = true\n"] {
        let scene = parse(&format!("{text}{sampling}"));
        let outline = outline::strokes(&scene.targets[0]).unwrap().remove(0);
        for focus in outline::foci(&scene).unwrap() {
            let part = |from: usize| {
                let (a, b) = (outline[from], outline[from + 1]);
                let on = a.distance(focus.position) + b.distance(focus.position) - a.distance(b);
                (on.abs() < 1e-9).then(|| a.distance(focus.position) / a.distance(b))
            };
            let wanted = match (part(0), part(1)) {
                (Some(part), _) => 1.0 + 2.0 * part,
                (_, Some(part)) => 3.0 - 2.5 * part,
                // From the end back to the beginning.
                _ => 0.5 + 0.5 * part(2).unwrap(),
            };
            assert!((focus.target - 2.0 * wanted).abs() < 1e-6, "{sampling}: {focus:?}, {wanted}");
        }
    }
    let scene = parse(text);
    assert_eq!(parse(&file::write(&scene)), scene);
}

#[test]
fn a_spacing_or_a_count_keeps_the_foci_that_it_had() {
    // Foci of the scene, and the sum of their places, each times its number.
    let known = [
        ("circle", 16, [-0.32, -1.60874863748, 27.2]),
        ("hit-vertical", 33, [6.0678, 2.67, 56.1]),
        ("letter-h", 17, [1.988, 0.666666666667, 30.6]),
        ("letter-i", 7, [0.0, 0.373333333333, 5.6]),
        ("line", 8, [0.36, 0.0, 3.6]),
        ("rectangle", 20, [-1.2, 2.1, 42.0]),
        ("triangle", 18, [1.44, -0.415692193817, 34.2]),
        ("water-circle", 16, [-0.2, -1.005467898425, 13.6]),
        ("water-rectangle", 18, [-0.675, 1.08, 17.1]),
        ("water-triangle", 15, [0.6875, -0.238156986041, 12.0]),
    ];
    for (name, count, sum) in known {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("assets/scenes/{name}.toml"));
        let foci = outline::foci(&file::read(&path).unwrap()).unwrap();
        let own = foci.iter().enumerate().map(|(i, focus)| focus.position * (i + 1) as f64).sum::<DVec3>();
        assert_eq!(foci.len(), count, "{name}");
        assert!(own.distance(DVec3::from(sum)) < 1e-9, "{name}: {own}");
        assert!(foci.iter().all(|focus| focus.is_separate()), "{name}");
    }
}

#[test]
fn the_opening_example_is_a_continuous_stroke_and_the_figures_are_points() {
    let read = |name: &str| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("assets/scenes/{name}.toml"));
        file::read(&path).unwrap()
    };
    assert!(outline::is_continuous(&read("hit")));
    for name in ["hit-vertical", "letter-h", "line", "circle", "water-triangle", "points-4"] {
        assert!(!outline::is_continuous(&read(name)), "{name}");
    }
    let mut scene = read("hit");
    scene.targets.push(Target { visible: false, ..scene.targets[0].clone() });
    scene.targets.remove(0);
    assert!(!outline::is_continuous(&scene), "what is hidden is not played");
}
