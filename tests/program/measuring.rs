//! `sonoglyph measure`: from a plan through a board that differs from its model to a calibration, and what it refuses.

use std::fmt::Write as _;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Stdio};

use glam::{DVec3, dvec3};
use num_complex::Complex64;
use serde_json::Value;
use sonoglyph::acoustics::Aperture;
use sonoglyph::drive::{self, Drive};
use sonoglyph::scene::Scene;
use sonoglyph::studio::opening;

use crate::process::{POINT, folder_with, output_of, program, refuse, succeed};

/// A virtual board with its port; it is switched off when dropped.
struct Board(Child, String);

impl Board {
    fn start(folder: &Path, args: &[&str]) -> Self {
        let mut command =
            program(folder, &["board", "--hidden", "7", "--profile", "native", "--scene", "scene.toml"]);
        let mut child = command.args(args).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let mut port = String::new();
        BufReader::new(child.stdout.as_mut().unwrap()).read_line(&mut port).unwrap();
        Self(child, port.trim().to_owned())
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        self.0.kill().unwrap();
        self.0.wait().unwrap();
    }
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

/// Gains and phases (rad) of the truth that a board wrote.
fn truth(folder: &Path) -> Vec<Complex64> {
    let text = fs::read_to_string(folder.join("truth.csv")).unwrap();
    let rows = text.lines().filter(|line| line.starts_with(|first: char| first.is_ascii_digit()));
    rows.map(|row| {
        let numbers: Vec<f64> = row.split(',').map(|number| number.parse().unwrap()).collect();
        Complex64::from_polar(numbers[1], numbers[2])
    })
    .collect()
}

/// A shift (m) of the scan in the truth's comments.
fn shift(folder: &Path, axis: &str) -> f64 {
    let text = fs::read_to_string(folder.join("truth.csv")).unwrap();
    let own = format!("# {axis} ");
    let line = text.lines().find_map(|line| line.strip_prefix(&own)).unwrap();
    line.split(' ').next().unwrap().parse().unwrap()
}

/// The last reading of a file.
fn reading(path: &Path) -> f64 {
    let text = fs::read_to_string(path).unwrap();
    text.lines().last().unwrap().split(',').nth(3).unwrap().parse().unwrap()
}

#[test]
fn a_hidden_board_is_found_out_and_its_focus_corrected() {
    let folder = folder_with(&[(
        "scene.toml",
        "format = 1\n[[target]]\nat = [0, 0, 0.1]\n[solver]\nmethod = \"focus\"\n",
    )]);
    let path = folder.path();
    let plan = ["measure", "scene.toml", "--plan", "-o", "plan", "--profile", "native"];
    let words = succeed(path, &plan);
    assert!(words.contains("places, one drive") && words.contains("phases ± 1.0"), "{words}");
    fs::copy(path.join("plan/drive.csv"), path.join("drive.csv")).unwrap();
    let board = Board::start(
        path,
        &[
            "--positions",
            "plan/positions.csv",
            "--readings",
            "scan.csv",
            "--microphone",
            "snr=30",
            "--truth",
            "truth.csv",
        ],
    );
    succeed(path, &[&plan[..], &["--port", &board.1, "--seconds", "3"]].concat());
    drop(board);
    let text =
        succeed(path, &["measure", "scene.toml", "--scan", "scan.csv", "-o", "calibration.csv", "--json"]);
    let found = json(&text);
    let truth = truth(path);
    let number = |key: &str, n: usize| found[key][n].as_f64().unwrap();
    let found_gains: Vec<_> =
        (0..256).map(|n| Complex64::from_polar(number("gains", n), number("phases", n))).collect();
    for (n, gain) in truth.iter().enumerate() {
        let expected = if gain.norm() == 0.0 { "dead" } else { found["states"][n].as_str().unwrap() };
        assert_eq!(found["states"][n], expected, "element {n}");
        assert!(gain.norm() > 0.0 || number("gains", n) < 0.05, "element {n}: {}", number("gains", n));
    }
    let reversed = found["states"].as_array().unwrap().iter().filter(|state| **state == "reversed").count();
    assert_eq!(reversed, 2);
    // The phase common to all is free.
    let turn: Complex64 = truth.iter().zip(&found_gains).map(|(truth, found)| truth.conj() * found).sum();
    let errors = truth.iter().zip(&found_gains).filter(|(truth, _)| truth.norm() > 0.0);
    let errors: Vec<_> =
        errors.map(|(truth, found)| (found * truth.conj() * turn.conj()).arg().to_degrees()).collect();
    let rms = (errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt();
    assert!(rms < 2.5, "{rms}°");
    assert_eq!(found["explained"], true, "{found}");
    assert_eq!(found["identifiable"], true);

    // The same board with the corrections, and a microphone whose displaced place is the focus.
    let [x, y, z] = ["x", "y", "z"].map(|name| shift(path, name));
    fs::write(path.join("focus.csv"), format!("x,y,z\n{},{},{}\n", -x, -y, 0.1 - z)).unwrap();
    let mut pressures = Vec::new();
    for corrections in [&[][..], &["--calibration", "calibration.csv"]] {
        let board = Board::start(
            path,
            &["--positions", "focus.csv", "--readings", "focus-scan.csv", "--microphone", "snr=inf"],
        );
        let send = ["send", "scene.toml", "--port", &board.1, "--profile", "native", "--seconds", "1"];
        succeed(path, &[&send[..], corrections].concat());
        pressures.push(reading(&path.join("focus-scan.csv")));
    }
    let scene = opening::open(&path.join("scene.toml")).unwrap();
    let aperture = Aperture::new(&scene);
    let row = aperture.transfer(&[dvec3(0.0, 0.0, 0.1)]);
    let ideal: f64 = row.row(0).zip(&truth).map(|(h, gain)| h.norm() * gain.norm()).sum();
    let [before, after] = pressures[..] else { panic!() };
    assert!(after > 0.995 * ideal && before < 0.95 * ideal, "{before}, {after} of {ideal}");
}

/// A scan of 4 x 4 elements with these gains under some drives.
fn scan(scene: &Scene, drives: &[Drive], points: &[DVec3], gains: &[Complex64], columns: &str) -> String {
    let aperture = Aperture::new(scene);
    let mut text = format!("x,y,z,drive,{columns}\n");
    for (number, drive) in drives.iter().enumerate() {
        let played = drive.excitation(&aperture.driven);
        let sound: Vec<_> = played.iter().zip(gains).map(|(u, gain)| u * gain).collect();
        for (point, p) in points.iter().zip(aperture.pressures(points, &sound)) {
            let (DVec3 { x, y, z }, level) = (*point, 20.0 * (p.norm() / 2f64.sqrt() / 20e-6).log10());
            let _ = match columns {
                "re,im" => writeln!(text, "{x},{y},{z},{number},{},{}", p.re, p.im),
                "amplitude" => writeln!(text, "{x},{y},{z},{number},{}", p.norm()),
                "level" => writeln!(text, "{x},{y},{z},{number},{level}"),
                other => panic!("{other}"),
            };
        }
    }
    text
}

const SMALL: &str = "format = 1\n[array]\nrows = 4\ncolumns = 4\n[[target]]\nat = [0, 0, 0.05]\n[solver]\nmethod = \"focus\"\n";

#[test]
fn readings_of_every_kind_give_the_same_gains() {
    let folder = folder_with(&[("scene.toml", SMALL)]);
    let path = folder.path();
    succeed(path, &["measure", "scene.toml", "--plan", "-o", "plan", "--drives", "2"]);
    let scene = opening::parse(SMALL, Path::new("scene.toml")).unwrap();
    let table = fs::File::open(path.join("plan/drive.csv")).unwrap();
    let drives = drive::read(table, &Aperture::new(&scene)).unwrap().drives;
    assert_eq!(drives.len(), 2);
    let positions = fs::read_to_string(path.join("plan/positions.csv")).unwrap();
    let points: Vec<_> = positions
        .lines()
        .skip(1)
        .map(|line| DVec3::from_slice(&line.split(',').map(|it| it.parse().unwrap()).collect::<Vec<f64>>()))
        .collect();
    let gains: Vec<_> = (0..16)
        .map(|n| match n {
            3 => Complex64::ZERO,
            9 => -Complex64::ONE,
            _ => Complex64::from_polar(1.0 + 0.02 * f64::from(n % 5 - 2), 0.1 * f64::from(n % 7 - 3)),
        })
        .collect();
    for columns in ["re,im", "amplitude", "level"] {
        fs::write(path.join("plan/scan.csv"), scan(&scene, &drives, &points, &gains, columns)).unwrap();
        let (text, notes) = output_of(path, &["measure", "scene.toml", "--scan", "plan/scan.csv", "--json"]);
        assert!(notes.contains("plan/drive.csv"), "{notes}");
        let found = json(&text);
        assert_eq!(
            (&found["states"][3], &found["states"][9], &found["states"][0]),
            (&"dead".into(), &"reversed".into(), &"good".into())
        );
        let phase = |n: usize| found["phases"][n].as_f64().unwrap() - found["phases"][0].as_f64().unwrap();
        let expected = |n: usize| gains[n].arg() - gains[0].arg();
        for n in [1, 2, 6, 15] {
            assert!(
                (phase(n) - expected(n)).abs() < 2e-3,
                "{columns}, element {n}: {} {}",
                phase(n),
                expected(n)
            );
        }
        assert!(found["residual"].as_f64().unwrap() < 1e-3, "{columns}");
        let strength = found["strength"].as_f64().unwrap();
        assert!((strength / 3.4 - 1.0).abs() < 0.02, "{columns}: {strength}");
    }
}

#[test]
fn radius_and_strength_follow_from_angles_of_one_element() {
    let text = "format = 1\n[array]\nrows = 1\ncolumns = 1\nelement_radius = 0.0042\nstrength = 2.5\n[[target]]\nat = [0, 0, 0.1]\n";
    let nominal = text.replace("0.0042", "0.005").replace("2.5", "3.4");
    let folder = folder_with(&[("scene.toml", &nominal)]);
    let scene = opening::parse(text, Path::new("scene.toml")).unwrap();
    let arc = (-35..=35).map(|step| f64::from(step) * 2f64.to_radians());
    let points: Vec<_> = arc.map(|angle| 0.2 * dvec3(angle.sin(), 0.0, angle.cos())).collect();
    let drives = [Drive { amplitudes: vec![1.0], phases: vec![0.0] }];
    fs::write(folder.path().join("scan.csv"), scan(&scene, &drives, &points, &[Complex64::ONE], "amplitude"))
        .unwrap();
    let found = json(&succeed(
        folder.path(),
        &["measure", "scene.toml", "--scan", "scan.csv", "--json", "--figure", "angles.svg"],
    ));
    let value = |key: &str| found[key].as_f64().unwrap();
    assert!((value("radius") - 0.0042).abs() < 1e-5 && (value("strength") - 2.5).abs() < 1e-3, "{found}");
    assert_eq!(found["fitted"], serde_json::json!(["radius"]));
    assert!(fs::read_to_string(folder.path().join("angles.svg")).unwrap().contains("angle / °"));
}

#[test]
fn a_liquid_tells_the_strength() {
    let scene = "format = 1\n[array]\nstrength = 3.4\n[liquid]\n[plane]\ncentre = [0, 0, 0.1]\nsize = [0.06, 0.06]\n\
                 [[target]]\nat = [0, 0, 0.1]\n[solver]\nmethod = \"focus\"\n";
    let folder = folder_with(&[("scene.toml", scene), ("louder.toml", &scene.replace("3.4", "3.74"))]);
    let path = folder.path();
    succeed(
        path,
        &[
            "render",
            "louder.toml",
            "-o",
            "x.png",
            "--quantity",
            "depression",
            "--size",
            "120",
            "--data",
            "heights.npy",
        ],
    );
    let found = json(&succeed(path, &["measure", "scene.toml", "--scan", "heights.npy", "--json"]));
    let strength = found["strength"].as_f64().unwrap();
    assert!((strength - 3.74).abs() < 0.01, "{found}");
    let message = refuse(path, &["measure", "scene.toml", "--scan", "heights.npy", "-o", "calibration.csv"]);
    assert!(message.contains("no calibration"), "{message}");
}

#[test]
fn scans_that_do_not_tell_are_refused() {
    let folder = folder_with(&[
        ("scene.toml", POINT),
        ("small.toml", SMALL),
        ("few.csv", "x,y,z,amplitude\n0,0,0.1,10\n0.01,0,0.1,20\n"),
        ("none.csv", "x,y,z,volume\n0,0,0.1,3\n"),
        ("negative.csv", "x,y,z,rms\n0,0,0.1,3\n0,0,0.1,-3\n"),
        ("drive-2.csv", "x,y,z,amplitude,drive\n0,0,0.1,3,0\n0,0,0.1,3,5\n"),
        ("millimetres.csv", "x,y,z,amplitude\n0,0,100.5,3\n"),
    ]);
    let path = folder.path();
    succeed(path, &["solve", "scene.toml", "--csv", "focus.csv"]);
    for (args, words) in [
        (&["--plan", "-o", "plan", "--drive", "focus.csv"][..], "a focus dominates the readings"),
        (&["--plan", "-o", "plan", "--step", "0.01"], "readings do not determine 511 unknowns"),
        (&["--plan", "-o", "plan", "--size", "0.05", "--step", "0.001"], "does not tell the elements apart"),
        (
            &["--scan", "few.csv", "-o", "calibration.csv"],
            "no calibration was written: 2 readings do not determine",
        ),
        (&["--scan", "none.csv"], "none.csv:1: no readings"),
        (&["--scan", "negative.csv"], "negative.csv:3: -3: a modulus must not be negative"),
        (&["--scan", "drive-2.csv"], "the scan names drive 5, and there is one"),
        (&["--scan", "millimetres.csv"], "millimetres.csv:2: 0, 0, 100.5: must be metres"),
        (&["--scan", "few.csv", "--free", "weight"], "--free: \"weight\" must be one of x, y, z"),
        (&["--scan", "few.csv", "--report", "report.txt"], "reports are written as .html and .pdf"),
        (&["--plan", "-o", "scene.toml"], "this is a file"),
    ] {
        let message = refuse(path, &[&["measure", "scene.toml"][..], args].concat());
        assert!(message.contains(words), "{args:?}: {message}");
    }
    // Without a calibration to write, too few readings still give strength and residual.
    let (out, warnings) = output_of(path, &["measure", "scene.toml", "--scan", "few.csv"]);
    assert!(out.contains("strength") && warnings.contains("not identifiable"), "{out}{warnings}");
}
