//! Commands as users and scripts call them: outputs that other programs read, and refusals of bad input.

use std::fs;

use serde_json::Value;
use sonoglyph::bench::field::{self, Group};
use sonoglyph::field::gpu::adapter;
use sonoglyph::scene::Method;
use strum::VariantArray;

use crate::process::{POINT, example, folder_with, program, refuse, run, succeed};
use crate::requirement::found;

#[test]
fn solve_prints_its_json_contract() {
    let folder = folder_with(&[]);
    let text = succeed(folder.path(), &["solve", &example("points-4"), "--json"]);
    let value: Value = serde_json::from_str(&text).unwrap();
    let keys = |value: &Value| value.as_object().unwrap().keys().cloned().collect::<Vec<_>>();
    let sorted = |mut keys: Vec<&'static str>| {
        keys.sort_unstable();
        keys
    };
    assert_eq!(
        keys(&value),
        sorted(vec![
            "method",
            "elements",
            "foci",
            "quality",
            "harmonic",
            "nonlinear",
            "seconds",
            "iterations",
            "phases",
            "amplitudes"
        ])
    );
    assert_eq!(keys(&value["foci"][0]), sorted(vec!["position", "target", "pressure", "phase"]));
    assert_eq!(
        keys(&value["quality"]),
        sorted(vec![
            "mean_pressure",
            "min_pressure",
            "spread",
            "efficiency",
            "relative_to_single",
            "bound",
            "certified",
            "ghost",
            "ghost_position",
            "widths",
            "residual",
            "evenness",
            "side_lobe",
            "side_lobe_position",
            "strength",
            "rank",
            "condition"
        ])
    );
    assert_eq!(value["method"], "weighted");
    assert_eq!(value["elements"], 256);
    assert_eq!(value["iterations"], 7);
    assert_eq!(value["foci"].as_array().unwrap().len(), 4);
    assert_eq!(value["phases"].as_array().unwrap().len(), 256);
    assert_eq!(value["amplitudes"].as_array().unwrap().len(), 256);
    let pressures: Vec<_> =
        value["foci"].as_array().unwrap().iter().map(|f| f["pressure"].as_f64().unwrap()).collect();
    let mean = pressures.iter().sum::<f64>() / 4.0;
    assert!((value["quality"]["mean_pressure"].as_f64().unwrap() / mean - 1.0).abs() < 1e-12);
    let weakest = pressures.iter().copied().fold(f64::INFINITY, f64::min);
    assert!((value["quality"]["evenness"].as_f64().unwrap() - weakest / mean).abs() < 1e-12);
}

#[test]
fn solve_meets_targets_in_pascals() {
    let text = |pressure: f64| {
        format!("{POINT}pressures = \"pascal\"\n[[target]]\nat = [-0.02, 0, 0.1]\npressure = {pressure}\n")
            .replace("method = \"focus\"\n", "")
            .replace("0.1]\n[solver]", "0.1]\npressure = 300\n[solver]")
    };
    let folder = folder_with(&[("quiet.toml", &text(600.0)), ("loud.toml", &text(60000.0))]);
    let args = ["solve", "quiet.toml", "--json", "--csv", "drive.csv"];
    let quiet: Value = serde_json::from_str(&succeed(folder.path(), &args)).unwrap();
    let amplitude = quiet["amplitudes"][0].as_f64().unwrap();
    assert!(0.05 < amplitude && amplitude < 0.9, "{amplitude}");
    for (focus, asked) in quiet["foci"].as_array().unwrap().iter().zip([300.0, 600.0]) {
        assert_eq!(focus["target"], asked);
        assert!((focus["pressure"].as_f64().unwrap() / asked - 1.0).abs() < 1e-3, "{focus}");
    }
    let row = fs::read_to_string(folder.path().join("drive.csv")).unwrap().lines().nth(1).unwrap().to_owned();
    let written: f64 = row.split(',').next_back().unwrap().parse().unwrap();
    assert!((written / amplitude - 1.0).abs() < 1e-12, "{row} is what is played");
    // The map is that of the played drive: its largest pixel is at the louder focus.
    succeed(folder.path(), &["render", "quiet.toml", "-o", "a.png", "--size", "200", "--data", "a.npy"]);
    let bytes = fs::read(folder.path().join("a.npy")).unwrap();
    let values: Vec<f32> = npyz::NpyFile::new(&bytes[..]).unwrap().into_vec().unwrap();
    let peak = f64::from(values.iter().copied().fold(0.0, f32::max)) * 2f64.sqrt();
    assert!((peak / 600.0 - 1.0).abs() < 0.03, "{peak}");
    let output = run(folder.path(), &["solve", "loud.toml"]);
    let (said, warned) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(warned.contains("30150.0 Pa") && warned.contains("full drive is played"), "{warned}");
    assert!(warned.contains("no drive of this array brings every focus to more than"), "{warned}");
    assert!(said.contains("each at 100.00 % of full drive"), "{said}");
}

#[test]
fn solve_states_the_exposure_at_a_listener() {
    let folder =
        folder_with(&[("a.toml", POINT), ("b.toml", &format!("{POINT}[listener]\nat = [0, 0, 9]\n"))]);
    let heard = |args: &[&str]| -> Value {
        serde_json::from_str::<Value>(&succeed(folder.path(), &[args, &["--json"]].concat())).unwrap()["listener"].clone()
    };
    assert_eq!(heard(&["solve", "a.toml"]), Value::Null);
    assert_eq!(heard(&["solve", "b.toml"])["position"][2], 9.0);
    let aside = heard(&["solve", "b.toml", "--listener", "-0.5, 0.1,0.3"]);
    assert_eq!(aside["position"][0], -0.5);
    let (rms, spl) = (aside["rms"].as_f64().unwrap(), aside["spl"].as_f64().unwrap());
    assert!((spl - 20.0 * (rms / 20e-6).log10()).abs() < 1e-9, "{aside}");
    fs::write(folder.path().join("ear.csv"), "x,y,z\n-0.5,0.1,0.3\n").unwrap();
    let probed = succeed(folder.path(), &["probe", "b.toml", "--points", "ear.csv"]);
    let probed: f64 = probed.lines().nth(1).unwrap().split(',').next_back().unwrap().parse().unwrap();
    assert!((probed / rms - 1.0).abs() < 1e-12, "{probed} is not {rms}");
    let output = run(folder.path(), &["solve", "a.toml", "--listener", "0,0,0.5"]);
    let (said, warned) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(said.contains("dB re 20 µPa") && warned.contains("louder than 110 dB"), "{said} {warned}");
}

#[test]
fn the_second_harmonic_is_a_figure_and_a_map() {
    let modulated = format!("{POINT}[modulation]\nshape = \"sine\"\n[listener]\nat = [0.3, 0, 0.3]\n");
    let soft = format!("{POINT}[[reflector]]\npoint = [0, 0, 0.2]\nnormal = [0, 0, -1]\ncoefficient = 0.5\n");
    let folder = folder_with(&[("a.toml", POINT), ("b.toml", &modulated), ("c.toml", &soft)]);
    let solved = |name: &str| -> Value {
        serde_json::from_str(&succeed(folder.path(), &["solve", name, "--json"])).unwrap()
    };
    let steady = solved("a.toml");
    // Sums over lattices.
    let harmonic = steady["harmonic"].as_f64().unwrap();
    assert!((harmonic / 0.3724 - 1.0).abs() < 0.02, "{harmonic}");
    let linear = steady["nonlinear"]["linear_drive"].as_f64().unwrap();
    assert!((linear * harmonic - 0.1).abs() < 1e-12 && steady["nonlinear"]["audible"].is_null(), "{steady}");
    let audible = solved("b.toml")["nonlinear"]["audible"].clone();
    let [all, heard] = ["spl", "spl_a"].map(|key| audible[key].as_f64().unwrap());
    assert!(10.0 < heard && heard < all && all < 80.0, "{audible}");
    let said = succeed(folder.path(), &["solve", "b.toml"]);
    assert!(said.contains("second harmonic") && said.contains("dB(A) at the listener"), "{said}");
    let args =
        ["render", "a.toml", "-o", "a.png", "--quantity", "harmonic", "--size", "600", "--data", "a.npy"];
    let output = run(folder.path(), &args);
    let complains = String::from_utf8_lossy(&output.stderr).contains("warning");
    assert!(output.status.success() && !complains, "{output:?}");
    let bytes = fs::read(folder.path().join("a.npy")).unwrap();
    let values: Vec<f32> = npyz::NpyFile::new(&bytes[..]).unwrap().into_vec().unwrap();
    let peak = f64::from(values.iter().copied().fold(0.0, f32::max)) * 2f64.sqrt();
    let expected = harmonic * steady["foci"][0]["pressure"].as_f64().unwrap();
    assert!((peak / expected - 1.0).abs() < 0.03, "{peak}, {expected}");
    assert_eq!(solved("c.toml")["harmonic"], Value::Null);
    let args = ["render", "c.toml", "-o", "c.png", "--quantity", "harmonic"];
    assert!(refuse(folder.path(), &args).contains("`coefficient = 1.0`"));
}

#[test]
fn solve_states_what_a_spread_of_elements_does() {
    let spread = |spread: &str| format!("{POINT}[array]\nspread = {spread}\n");
    let folder = folder_with(&[
        ("equal.toml", POINT),
        ("spread.toml", &spread("{ gain = 0.1, phase = 0.4 }")),
        ("wrong.toml", &spread("{ gain = 0.1, phase = 4 }")),
    ]);
    let solved = |scene: &str| -> Value {
        serde_json::from_str(&succeed(folder.path(), &["solve", scene, "--json"])).unwrap()
    };
    let (equal, other) = (solved("equal.toml"), solved("spread.toml"));
    assert_eq!((&equal["spread"], &equal["quality"]), (&Value::Null, &other["quality"]));
    let range = |figure: &str| [0, 1, 2].map(|i| other["spread"][figure][i].as_f64().unwrap());
    // A focus keeps exp(-φ²/2) of its pressure, and of the normal deviates 5 % are below -1.645.
    let nominal = equal["quality"]["mean_pressure"].as_f64().unwrap();
    let [low, median, high] = range("mean_pressure").map(|pressure| pressure / nominal);
    assert!((median - (-0.08f64).exp()).abs() < 5e-4, "{median}");
    assert!(low < median && (low + high - 2.0 * median).abs() < 1e-9 && high < 0.95, "{low} {high}");
    let lobe = equal["quality"]["side_lobe"].as_f64().unwrap();
    // It is a single strong lobe, which keeps as much as the focus.
    let [least, lobes, most] = range("side_lobe").map(|part| part / lobe);
    assert!((lobes - 1.0).abs() < 0.03 && least < 0.97 && most > 1.03, "{least} {lobes} {most}");
    let said = succeed(folder.path(), &["solve", "spread.toml"]);
    assert!(said.contains("calibration would win") && said.contains("0.39 % of the pressure"), "{said}");
    let refused = run(folder.path(), &["solve", "wrong.toml"]);
    let warned = String::from_utf8_lossy(&refused.stderr);
    assert!(refused.status.code() == Some(2) && warned.contains("array.spread.phase"), "{warned}");
}

#[test]
fn solve_compares_methods_and_writes_the_drive() {
    let folder = folder_with(&[("a.toml", POINT)]);
    let all: Value =
        serde_json::from_str(&succeed(folder.path(), &["solve", "a.toml", "--method", "all", "--json"]))
            .unwrap();
    assert_eq!(all.as_array().unwrap().len(), Method::VARIANTS.len());
    let table = succeed(folder.path(), &["solve", &example("circle"), "--method", "all"]);
    assert!(table.contains("weighted") && table.contains("best") && !table.contains("focus "), "{table}");
    succeed(folder.path(), &["solve", "a.toml", "--csv", "drive.csv"]);
    let csv = fs::read_to_string(folder.path().join("drive.csv")).unwrap();
    assert_eq!(csv.lines().next(), Some("element,x,y,phase,amplitude"));
    assert_eq!(csv.lines().count(), 257);
}

#[test]
fn probe_answers_in_pascals_and_takes_a_drive_from_a_file() {
    let points = "x,y,z\n0.01,0.02,0.1\n0,0.02,0.15\n";
    let folder = folder_with(&[("a.toml", POINT), ("points.csv", points)]);
    let solved: Value =
        serde_json::from_str(&succeed(folder.path(), &["solve", "a.toml", "--json", "--csv", "d.csv"]))
            .unwrap();
    let answer = succeed(folder.path(), &["probe", "a.toml", "--points", "points.csv"]);
    let rows: Vec<Vec<f64>> =
        answer.lines().skip(1).map(|line| line.split(',').map(|v| v.parse().unwrap()).collect()).collect();
    assert_eq!(answer.lines().next(), Some("x,y,z,re,im,rms"));
    assert_eq!(rows.len(), 2);
    let pressure = solved["foci"][0]["pressure"].as_f64().unwrap();
    assert!((rows[0][3].hypot(rows[0][4]) / pressure - 1.0).abs() < 1e-12);
    assert!((rows[0][5] * 2f64.sqrt() / pressure - 1.0).abs() < 1e-12);
    for backend in ["auto", "cpu", "reference"] {
        let args = [
            "probe",
            "a.toml",
            "--points",
            "points.csv",
            "--drive",
            "d.csv",
            "--backend",
            backend,
            "-o",
            "out.csv",
        ];
        succeed(folder.path(), &args);
        let out = fs::read_to_string(folder.path().join("out.csv")).unwrap();
        let re: f64 = out.lines().nth(1).unwrap().split(',').nth(3).unwrap().parse().unwrap();
        assert!((re - rows[0][3]).abs() < 2e-5 * pressure, "{backend}");
    }
}

#[test]
fn render_writes_pictures_and_their_data() {
    let folder = folder_with(&[("a.toml", &format!("{POINT}[plane]\nsize = [0.2, 0.1]\n"))]);
    let args = ["render", "a.toml", "-o", "a.png", "--size", "64", "--data", "a.npy"];
    succeed(folder.path(), &args);
    let picture = image::open(folder.path().join("a.png")).unwrap().to_rgb8();
    assert_eq!((picture.width(), picture.height()), (64, 32), "a width alone keeps the plane's aspect ratio");
    let bytes = fs::read(folder.path().join("a.npy")).unwrap();
    let npy = npyz::NpyFile::new(&bytes[..]).unwrap();
    assert_eq!(npy.shape(), [32, 64]);
    let values: Vec<f32> = npy.into_vec().unwrap();
    // Of 64 columns over 0.2 m, column 35 holds x = 10.9 mm; of 32 rows over 0.1 m, row 22 holds y = 20 mm.
    let peak = values.iter().copied().fold(0.0, f32::max);
    let at = values.iter().position(|&value| value == peak).unwrap();
    assert!([34, 35].contains(&(at % 64)) && at / 64 == 22, "{at}");
    let brightest = |x: u32, y: u32| picture.get_pixel(x, y).0.iter().map(|&v| u32::from(v)).sum::<u32>();
    assert!(brightest((at % 64) as u32, 31 - (at / 64) as u32) > 600, "row 0 is the bottom of the picture");
}

#[test]
fn every_backend_renders_the_same_numbers() {
    let folder = folder_with(&[("a.toml", POINT)]);
    let mut fields: Vec<Vec<f32>> = Vec::new();
    for backend in ["reference", "cpu", "auto", "gpu"] {
        let args =
            ["render", "a.toml", "-o", "a.png", "--size", "48x40", "--data", "a.npy", "--backend", backend];
        let output = run(folder.path(), &args);
        let said = String::from_utf8_lossy(&output.stderr);
        if backend == "gpu" {
            let done = if output.status.success() { Ok(()) } else { Err(said) };
            let Some(()) = found("gpu", done) else { continue };
        } else {
            assert!(output.status.success(), "{backend}: {said}");
        }
        let bytes = fs::read(folder.path().join("a.npy")).unwrap();
        fields.push(npyz::NpyFile::new(&bytes[..]).unwrap().into_vec().unwrap());
    }
    let peak = fields[0].iter().copied().fold(0.0, f32::max);
    for field in &fields[1..] {
        for (a, b) in fields[0].iter().zip(field) {
            assert!((a - b).abs() < 2e-5 * peak);
        }
    }
}

#[test]
fn render_fills_a_folder_and_draws_every_quantity() {
    let folder = folder_with(&[("a.toml", POINT), ("b.toml", POINT)]);
    succeed(folder.path(), &["render", "a.toml", "b.toml", "-o", "out/", "--size", "32"]);
    assert_eq!(fs::read_dir(folder.path().join("out")).unwrap().count(), 2);
    for (quantity, size) in [("phase", (32, 32)), ("drive", (400, 210)), ("sheet", (400, 390))] {
        let width = size.0.to_string();
        succeed(
            folder.path(),
            &["render", "a.toml", "-o", "q.png", "--quantity", quantity, "--size", &width, "-v"],
        );
        let picture = image::open(folder.path().join("q.png")).unwrap();
        assert_eq!((picture.width(), picture.height()), size, "{quantity}");
    }
}

#[test]
fn without_arguments_it_renders_the_example_even_without_gpu_and_display() {
    let folder = folder_with(&[]);
    let output = program(folder.path(), &[])
        .env("VK_DRIVER_FILES", "/nonexistent/icd.json")
        .env("VK_ICD_FILENAMES", "/nonexistent/icd.json")
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .output()
        .unwrap();
    let (said, noted) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{noted}");
    assert!(said.contains("sonoglyph.png") && said.contains("render"), "{said}");
    assert!(noted.contains("the CPU computes the field"), "{noted}");
    assert!(image::open(folder.path().join("sonoglyph.png")).unwrap().width() > 1000);
}

#[test]
fn bad_scenes_are_refused_with_file_line_and_value() {
    for (text, parts) in [
        ("format = 1\n[array\n", &["bad.toml:2"][..]),
        ("format = 1\n[array]\npich = 0.01\n", &["bad.toml:3", "pich"]),
        ("format = 1\n[[target]]\nat = [0, 0, 0]\n", &["bad.toml:2", "on or behind the array"]),
        ("format = 1\n", &["bad.toml", "no target"]),
        ("format = 1\n[[quiet]]\nat = [0, 0, -1]\n", &["bad.toml:3", "quiet[1].at = [0, 0, -1]", "behind"]),
    ] {
        let folder = folder_with(&[("bad.toml", text)]);
        for args in [&["render", "bad.toml", "-o", "a.png"][..], &["solve", "bad.toml", "--json"]] {
            let message = refuse(folder.path(), args);
            for part in parts {
                assert!(message.contains(part), "{text}: {message}");
            }
            assert_eq!(message.trim_end().lines().count(), 1, "{message}");
        }
    }
}

#[test]
fn bad_arguments_and_files_are_refused() {
    let folder = folder_with(&[
        ("a.toml", POINT),
        ("two.toml", "format = 1\n[[target]]\n[[target]]\nat = [0.02, 0, 0.1]\n"),
        ("points.csv", "x,y,z\n0,0,0.1\n"),
        ("no-z.csv", "x,y\n0,0\n"),
        ("word.csv", "x,y,z\n0,0,0.1\n0,zero,0.1\n"),
        ("short.csv", "x,y,z\n0,0\n"),
        ("empty.csv", "x,y,z\n"),
        ("gap.csv", "phase,amplitude\n0,1\n0,\n"),
        ("drive.csv", "phase\n0\n0\n"),
    ]);
    for (args, part) in [
        (&["render", "none.toml", "-o", "x.png"][..], "none.toml"),
        (&["render", "a.toml", "-o", "no/such/folder/x.png"], "no/such/folder/x.png"),
        (&["render", "a.toml", "two.toml", "-o", "a.toml"], "need a folder"),
        (&["render", "a.toml", "-o", "x.png", "--size", "0"], "pixels"),
        (&["render", "a.toml", "-o", "x.png", "--size", "20000x20000"], "3051 MiB"),
        (&["render", "a.toml", "-o", "x.png", "--size", "16384x16384"], "MiB"),
        (&["render", "a.toml", "-o", "x.png", "--quantity", "sheet", "--size", "20"], "no room"),
        (&["render", "a.toml", "-o", "x.png", "--tolerance", "-1"], "tolerance"),
        (&["render", "a.toml", "-o", "x.png", "--tolerance", "1"], "from 0 (`exact`) to below 1"),
        (&["render", "a.toml", "-o", "x.png", "--quantity", "colour"], "colour"),
        (&["solve", "a.toml", "--method", "magic"], "weighted"),
        (&["solve", "two.toml", "--method", "focus"], "`weighted`"),
        (&["solve", "a.toml", "--listener", "0,-0.3,-0.1"], "behind the array"),
        (&["solve", "a.toml", "--listener", "0,0.3"], "three numbers"),
        (&["solve", "a.toml", "--csv", "no/such/folder/x.csv"], "no/such/folder/x.csv"),
        (&["probe", "a.toml", "--points", "none.csv"], "none.csv"),
        (&["probe", "a.toml", "--points", "no-z.csv"], "no-z.csv:1: the column `z` is missing"),
        (&["probe", "a.toml", "--points", "word.csv"], "word.csv:3: y = `zero`"),
        (&["probe", "a.toml", "--points", "short.csv"], "short.csv"),
        (&["probe", "a.toml", "--points", "empty.csv"], "there are no points"),
        (
            &["probe", "a.toml", "--points", "points.csv", "--drive", "drive.csv"],
            "drive.csv:3: the file has 2 rows, and the scene has 256 elements",
        ),
        (
            &["probe", "a.toml", "--points", "points.csv", "--drive", "gap.csv"],
            "gap.csv:3: amplitude is empty",
        ),
        (&["dance"], "dance"),
        (&["--renderer", "bad"], "auto, wgpu, glow"),
    ] {
        let message = refuse(folder.path(), args);
        assert!(message.contains(part), "{args:?}: {message}");
    }
}

#[test]
fn devices_names_the_evaluator_in_use() {
    let said = succeed(folder_with(&[]).path(), &["devices"]);
    assert!(said.contains("CPU evaluator") && said.contains("auto"), "{said}");
}

#[test]
fn bench_writes_a_table_the_json_and_charts() {
    let folder = tempfile::tempdir().unwrap();
    let bench = |args: &[&str]| succeed(folder.path(), &[&["bench"], args].concat());
    let table = bench(&["stability", "--json", "bench.json"]);
    // Of 14 sets by all methods for several foci.
    let count = 14 * (Method::VARIANTS.len() - 1);
    assert!(
        table.contains("condition") && table.contains(&format!("{count} of {count} solutions")),
        "{table}"
    );
    let json: Value =
        serde_json::from_str(&fs::read_to_string(folder.path().join("bench.json")).unwrap()).unwrap();
    let sets = json["stability"].as_array().unwrap();
    assert!(sets.len() == count && sets.iter().all(|record| record["sound"] == true), "{sets:?}");
    assert!(json["machine"]["threads"].as_u64() > Some(0) && json["shapes"].is_null(), "{json}");
    assert!(json["command"].as_str().unwrap().starts_with("sonoglyph bench stability"), "{json}");
    let table = bench(&["shapes", "--plots", "plots"]);
    assert!(table.contains("stroke, dragged") && table.contains("plots/shapes-side-lobe.png"), "{table}");
    assert!(image::open(folder.path().join("plots/shapes-side-lobe.png")).unwrap().width() > 1000);
    for (option, path) in [("--json", "no/bench.json"), ("--plots", "bench.json")] {
        let message = refuse(folder.path(), &["bench", "solve", option, path]);
        assert!(message.contains(path), "{message}");
    }
}

/// In f32 a large array does not keep 1e-5 on a vertical plane: the CPU computes what the GPU declines.
#[test]
fn bench_ends_where_the_gpu_declines_a_map() {
    let group = Group { evaluator: "gpu", size: 64, array: 64, plane: "vertical", tolerances: vec![1e-5] };
    let Some(_) = found("gpu", adapter::open_best(true)) else { return };
    assert_eq!(field::measure(&group).unwrap().len(), 1);
}
