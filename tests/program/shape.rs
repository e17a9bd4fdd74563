//! Shapes on the command line.

use std::f64::consts::TAU;
use std::io::Write;
use std::process::{Command, Stdio};

use num_complex::Complex64;
use serde_json::Value;
use sonoglyph::picture::{Picture, export};

use crate::process::{folder_with, run, succeed};

fn solved(scene: &str, args: &[&str]) -> Value {
    let folder = folder_with(&[("a.toml", scene)]);
    let text = succeed(folder.path(), &[&["solve", "a.toml", "--json"], args].concat());
    serde_json::from_str(&text).unwrap()
}

/// |p| of the default array's drive at points on the plane z = 0.1 m, to any scale: far-field pistons, no absorption.
fn judged(solution: &Value, points: &[[f64; 2]]) -> Vec<f64> {
    const PITCH: f64 = 0.0105;
    const RADIUS: f64 = 0.005;
    const HEIGHT: f64 = 0.1;
    let k = TAU * 40e3 / (331.3 * (293.15f64 / 273.15).sqrt());
    // The power series of 2 J1(x)/x; x is at most 3.7.
    let directivity = |x: f64| {
        let (mut term, mut sum) = (1.0, 1.0);
        for n in 1..14 {
            term *= -(x * x / 4.0) / f64::from(n * (n + 1));
            sum += term;
        }
        sum
    };
    let phases: Vec<_> = solution["phases"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
    let at = |&[x, y]: &[f64; 2]| {
        let mut sum = Complex64::ZERO;
        for (n, phase) in phases.iter().enumerate() {
            let (dx, dy) = (x - PITCH * ((n % 16) as f64 - 7.5), y - PITCH * ((n / 16) as f64 - 7.5));
            let flat = dx.hypot(dy);
            let r = flat.hypot(HEIGHT);
            sum += Complex64::from_polar(directivity(k * RADIUS * flat / r) / r, phase - k * r);
        }
        sum.norm()
    };
    points.iter().map(at).collect()
}

/// Points every 0.5 mm along a polyline (m).
fn along(vertices: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let piece = |pair: &[[f64; 2]]| {
        let [[x, y], [to_x, to_y]] = [pair[0], pair[1]];
        let count = ((to_x - x).hypot(to_y - y) / 5e-4).ceil() as usize;
        let part = move |i: usize| i as f64 / count as f64;
        (0..=count).map(move |i| [x + (to_x - x) * part(i), y + (to_y - y) * part(i)])
    };
    vertices.windows(2).flat_map(piece).collect()
}

/// Minimum over mean along a stroke, and the largest value of 40 x 40 cm more than 8 mm from it over that mean.
fn figures(solution: &Value, stroke: &[[f64; 2]]) -> (f64, f64) {
    let heard = judged(solution, stroke);
    let mean = heard.iter().sum::<f64>() / heard.len() as f64;
    let least = heard.iter().copied().fold(f64::INFINITY, f64::min);
    let lattice = (0..134).flat_map(|i| (0..134).map(move |j| [i, j].map(|i| (f64::from(i) - 66.5) * 3e-3)));
    let is_beside = |[x, y]: &[f64; 2]| stroke.iter().all(|at| (x - at[0]).hypot(y - at[1]) > 8e-3);
    let beside: Vec<_> = lattice.filter(is_beside).collect();
    (least / mean, judged(solution, &beside).into_iter().fold(0.0, f64::max) / mean)
}

fn path(vertices: &[[f64; 2]]) -> String {
    let vertices: Vec<_> = vertices.iter().map(|[x, y]| format!("[{x}, {y}, 0.1]")).collect();
    format!("format = 1\n[[target]]\nkind = \"path\"\nvertices = [{}]\n", vertices.join(", "))
}

/// A star's outline, the letter N and a spiral.
fn drawings() -> [Vec<[f64; 2]>; 3] {
    let polar = |r: f64, angle: f64| [r * angle.sin(), r * angle.cos()];
    let star = (0..=10).map(|i| polar([0.022, 0.01][i % 2], i as f64 * TAU / 10.0)).collect();
    let letter = vec![[-0.015, -0.02], [-0.015, 0.02], [0.015, -0.02], [0.015, 0.02]];
    let spiral =
        (0..=60).map(|i| polar(0.005 + 0.015 * f64::from(i) / 60.0, f64::from(i) * TAU / 40.0)).collect();
    [star, letter, spiral]
}

#[test]
fn a_drawing_is_even_with_low_side_lobes() {
    for drawing in drawings() {
        let scene = path(&drawing);
        let (solution, stroke) = (solved(&scene, &[]), along(&drawing));
        let (evenness, side_lobe) = figures(&solution, &stroke);
        assert!(evenness >= 0.85 && side_lobe <= 0.6, "{evenness:.3}, {side_lobe:.3}: {scene}");
        let said = |key: &str| solution["quality"][key].as_f64().unwrap();
        assert!((said("evenness") - evenness).abs() < 0.02, "{evenness:.3}: {}", said("evenness"));
        assert!((said("side_lobe") / side_lobe - 1.0).abs() < 0.1, "{side_lobe:.3}: {}", said("side_lobe"));
        assert!((0.8..=1.05).contains(&said("strength")), "{}", said("strength"));
        // Separate foci still give beads, with side lobes as loud as the drawing.
        let beads = figures(&solved(&format!("{scene}spacing = 0.01\n"), &[]), &stroke);
        assert!(beads.0 < evenness - 0.2 && beads.1 > side_lobe + 0.1, "{beads:?}");
    }
}

/// Each of three drives has louder side lobes than their mean, which is quieter than any single drive.
#[test]
fn drives_in_turn_have_lower_mean_side_lobes() {
    let drawing = &drawings()[1];
    let (scene, stroke) = (format!("{}[solver]\nframes = 3\n", path(drawing)), along(drawing));
    let solution = solved(&scene, &[]);
    let drives = solution["frames"].as_array().unwrap();
    assert!(drives.len() == 3 && drives[0]["phases"] == solution["phases"] && drives[1] != drives[2]);
    let lattice = (0..100).flat_map(|i| (0..100).map(move |j| [i, j].map(|i| (f64::from(i) - 49.5) * 3e-3)));
    let is_beside = |[x, y]: &[f64; 2]| stroke.iter().all(|at| (x - at[0]).hypot(y - at[1]) > 8e-3);
    let beside: Vec<_> = lattice.filter(is_beside).collect();
    let mean_of = |heard: &[f64]| heard.iter().sum::<f64>() / heard.len() as f64;
    let loudest = |heard: &[f64]| heard.iter().copied().fold(0.0, f64::max);
    let heard_of = |points: &[[f64; 2]]| drives.iter().map(|drive| judged(drive, points)).collect::<Vec<_>>();
    let (on_stroke, off_stroke) = (heard_of(&stroke), heard_of(&beside));
    let mean = |heard: &[Vec<f64>]| {
        let square = |index: usize| heard.iter().map(|heard| heard[index] * heard[index]).sum::<f64>();
        (0..heard[0].len()).map(|index| (square(index) / 3.0).sqrt()).collect::<Vec<_>>()
    };
    let (drawn, elsewhere) = (mean(&on_stroke), mean(&off_stroke));
    let evenness = drawn.iter().copied().fold(f64::INFINITY, f64::min) / mean_of(&drawn);
    let side_lobe = loudest(&elsewhere) / mean_of(&drawn);
    let said = |key: &str| solution["quality"][key].as_f64().unwrap();
    assert!((said("evenness") - evenness).abs() < 0.02, "{evenness:.3}: {}", said("evenness"));
    assert!((said("side_lobe") / side_lobe - 1.0).abs() < 0.1, "{side_lobe:.3}: {}", said("side_lobe"));
    let alone = figures(&solved(&path(drawing), &[]), &stroke);
    assert!(evenness > 0.9 && side_lobe < 0.9 * alone.1, "{evenness:.3}, {side_lobe:.3}, alone {alone:?}");
    for (on_stroke, off_stroke) in on_stroke.iter().zip(&off_stroke) {
        let part = loudest(off_stroke) / mean_of(on_stroke);
        assert!(part > 1.2 * side_lobe, "{part:.3} of one, {side_lobe:.3} of all");
    }
}

#[test]
fn maps_and_points_are_means_over_drives_in_turn() {
    let scene = format!("{}[solver]\nframes = 2\n", path(&drawings()[1]));
    let folder = folder_with(&[("a.toml", &scene), ("p.csv", "x,y,z\n0.025,-0.025,0.1\n")]);
    let value = |args: &[&str]| {
        let render =
            ["render", "a.toml", "-o", "a.png", "--size", "4", "--data", "a.npy", "--tolerance", "exact"];
        succeed(folder.path(), &[&render[..], args].concat());
        let bytes = std::fs::read(folder.path().join("a.npy")).unwrap();
        // Pixel 7 of 4 x 4 is at that point.
        let at = bytes.len() - 4 * (16 - 6);
        f64::from(f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()))
    };
    let (mean, first, second) = (value(&[]), value(&["--frame", "1"]), value(&["--frame", "2"]));
    let expected = ((first * first + second * second) / 2.0).sqrt();
    assert!((mean / expected - 1.0).abs() < 1e-4, "{mean} of {first} and {second}");
    assert!((mean / value(&["--frame", "mean"]) - 1.0).abs() < 1e-6);
    let table = succeed(folder.path(), &["probe", "a.toml", "--points", "p.csv"]);
    let rms: f64 = table.trim().rsplit_once(',').unwrap().1.parse().unwrap();
    assert!((rms / expected - 1.0).abs() < 1e-4, "{table}");
    let folder = folder_with(&[("a.toml", &format!("{scene}[motion]\npath = \"circle\"\n"))]);
    let output = run(folder.path(), &["solve", "a.toml"]);
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(2) && message.contains("solver.frames"), "{message}");
}

/// The result of a search that is given increasing times, since a busy machine may get little done in the first.
fn searched<T>(search: impl Fn(&str) -> Option<T>) -> T {
    ["0.5", "2", "8", "32"].into_iter().find_map(search).expect("a search makes progress")
}

#[test]
fn further_search_finds_no_weaker_drive() {
    let foci: String = (0..9)
        .map(|i| {
            let [x, y] = [0.618, 0.755].map(|step| (f64::from(i) * step) % 1.0 * 0.066 - 0.033);
            format!("[[target]]\nat = [{x}, {y}, 0.1]\n")
        })
        .collect();
    let scene = format!("format = 1\n{foci}");
    let weakest = |args: &[&str]| solved(&scene, args)["quality"]["min_pressure"].as_f64().unwrap();
    let soon = weakest(&[]);
    searched(|seconds| {
        let later = weakest(&["--search", seconds]);
        assert!(later >= soon, "{later} Pa, and {soon} at once");
        (later > 1.0001 * soon).then_some(())
    });
}

#[test]
fn further_search_makes_no_shape_worse() {
    let scene = path(&drawings()[0]);
    let of = |args: &[&str]| {
        let solution = solved(&scene, args);
        let steps = solution["iterations"].as_u64().unwrap();
        (steps, ["evenness", "side_lobe"].map(|key| solution["quality"][key].as_f64().unwrap()))
    };
    let (steps, soon) = of(&[]);
    let later = searched(|seconds| {
        let (further, later) = of(&["--search", seconds]);
        (further > steps).then_some(later)
    });
    // The search minimises a sum of both.
    assert!(later[0] > soon[0] - 0.03 && later[1] < soon[1] + 0.03, "{soon:?}, then {later:?}");
}

/// A stroke with three times the target at one end, and a point; evenness is of pressure over target.
#[test]
fn solve_prints_the_samples_of_a_stroke() {
    let stroke = "format = 1\n[[target]]\nkind = \"path\"\nvertices = [[-0.02, 0, 0.1], [0.02, 0, 0.1]]\n\
                  pressures = [1, 3]\n[[target]]\nat = [0, 0.03, 0.1]\n";
    let folder = folder_with(&[("stroke.toml", stroke), ("alone.toml", stroke.rsplit_once("[[").unwrap().0)]);
    let json = succeed(folder.path(), &["solve", "stroke.toml", "--json", "--search", "0"]);
    let value: Value = serde_json::from_str(&json).unwrap();
    let foci = value["foci"].as_array().unwrap();
    assert_eq!(foci.len(), 21, "19 pieces of 2.1 mm, and the point");
    let number = |focus: &Value, key: &str| focus[key].as_f64().unwrap();
    assert_eq!((number(&foci[0], "target"), number(&foci[19], "target")), (1.0, 3.0));
    let relative: Vec<_> = foci.iter().map(|it| number(it, "pressure") / number(it, "target")).collect();
    let mean = relative.iter().sum::<f64>() / relative.len() as f64;
    let least = relative.iter().copied().fold(f64::INFINITY, f64::min);
    // The evenness also covers points between the samples.
    let lower = least / mean - number(&value["quality"], "evenness");
    assert!((-0.01..0.05).contains(&lower), "{lower}");
    // Samples give no warnings about resolution and no rows of the table.
    let output = run(folder.path(), &["solve", "stroke.toml"]);
    let (text, warnings) =
        (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap());
    assert_eq!(warnings, "");
    assert!(text.contains("20 samples") && text.contains("evenness"), "{text}");
    assert_eq!(text.matches(" Pa ").count().min(1), 1, "{text}");
    assert!(text.contains("30.00") && !text.contains("20.00"), "only the point: {text}");
    assert!(!succeed(folder.path(), &["solve", "alone.toml"]).contains("x / mm"));
}

#[test]
fn a_drawing_beyond_the_arrays_reach_gives_a_warning() {
    let of = |side: f64| {
        let scene =
            format!("format = 1\n[[target]]\nkind = \"rectangle\"\nwidth = {side}\nheight = {side}\n");
        let folder = folder_with(&[("a.toml", &scene)]);
        String::from_utf8(run(folder.path(), &["solve", "a.toml"]).stderr).unwrap()
    };
    assert_eq!(of(0.04), "");
    assert!(of(0.8).contains("too large for this array"), "{}", of(0.8));
}

#[test]
fn invalid_search_times_are_refused() {
    let folder = folder_with(&[("a.toml", "format = 1\n[[target]]\n")]);
    for (args, part) in [
        (&["--search", "-1"][..], "from 0 to 3600 s"),
        (&["--search", "nan"], "from 0 to 3600 s"),
        (&["--search", "soon"], "a time in seconds"),
        (&["--search", "1", "--motion"], "--motion"),
    ] {
        let output = run(folder.path(), &[&["solve", "a.toml"], args].concat());
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && message.contains(part), "{args:?}: {message}");
    }
}

/// A white disc on black.
fn disc_png() -> Vec<u8> {
    const SIDE: usize = 40;
    let is_white = |i: usize| ((i % SIDE) as f64 - 19.5).hypot((i / SIDE) as f64 - 19.5) < 15.0;
    let pixel = |i: usize| if is_white(i) { [255; 4] } else { [0, 0, 0, 255] };
    let rgba = (0..SIDE * SIDE).flat_map(pixel).collect();
    export::png(&Picture { width: SIDE, height: SIDE, rgba }).unwrap()
}

#[test]
fn a_picture_is_read_beside_its_scene_and_fitted() {
    let text = "format = 1\n[[target]]\nkind = \"picture\"\nfile = \"pictures/disc.png\"\nwidth = 0.04\n";
    let folder = folder_with(&[("a.toml", text)]);
    std::fs::create_dir(folder.path().join("pictures")).unwrap();
    std::fs::write(folder.path().join("pictures/disc.png"), disc_png()).unwrap();
    let elsewhere = tempfile::tempdir().unwrap();
    let scene = folder.path().join("a.toml");
    let said = succeed(elsewhere.path(), &["solve", scene.to_str().unwrap(), "--json"]);
    let solution: Value = serde_json::from_str(&said).unwrap();
    let quality = &solution["quality"];
    let (error, contrast) = (quality["error"].as_f64().unwrap(), quality["contrast"].as_f64().unwrap());
    assert!(error < 0.1 && contrast > 10.0, "{quality}");
    // A disc of 15 mm radius: louder inside than around it.
    let ring = |radius: f64| -> Vec<[f64; 2]> {
        (0..24)
            .map(|i| (TAU * f64::from(i) / 24.0).sin_cos())
            .map(|(y, x)| [radius * x, radius * y])
            .collect()
    };
    let mean = |radius: f64| judged(&solution, &ring(radius)).iter().sum::<f64>() / 24.0;
    assert!(mean(0.008) > 2.0 * mean(0.022), "{} and {}", mean(0.008), mean(0.022));
    let table = succeed(folder.path(), &["solve", "a.toml"]);
    assert!(table.contains("contrast ") && table.contains("error ") && table.contains("areas "), "{table}");

    let line = r#"{"target": [{"kind": "picture", "file": "pictures/disc.png", "width": 0.04}]}"#;
    let mut batch = Command::new(env!("CARGO_BIN_EXE_sonoglyph"))
        .args(["batch"])
        .current_dir(folder.path())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    batch.stdin.take().unwrap().write_all(line.as_bytes()).unwrap();
    let answer = batch.wait_with_output().unwrap().stdout;
    let answer: Value = serde_json::from_slice(&answer).unwrap();
    assert_eq!(answer["quality"]["error"], quality["error"], "{answer}");
}

#[test]
fn unusable_pictures_are_refused_with_their_line() {
    let black = export::png(&Picture { width: 2, height: 2, rgba: vec![0; 16] }).unwrap();
    for (bytes, part) in [
        (None, "no such file"),
        (Some(&b""[..]), "neither a PNG, JPEG nor BMP"),
        (Some(b"text"), "neither a PNG, JPEG nor BMP"),
        (Some(&black[..30]), "the picture cannot be read"),
        (Some(&black), "black or transparent all over"),
    ] {
        let text = "format = 1\n[[target]]\nkind = \"picture\"\n# Ours.\nfile = \"b.png\"\n";
        let folder = folder_with(&[("a.toml", text)]);
        if let Some(bytes) = bytes {
            std::fs::write(folder.path().join("b.png"), bytes).unwrap();
        }
        for args in [&["solve", "a.toml"][..], &["render", "a.toml", "-o", "c.png"]] {
            let output = run(folder.path(), args);
            let message = String::from_utf8(output.stderr).unwrap();
            assert_eq!(output.status.code(), Some(2), "{message}");
            let place = message.contains("a.toml:5: target[1].file = \"b.png\": ");
            assert!(place && message.contains(part) && message.trim().lines().count() == 1, "{message}");
        }
    }
}
