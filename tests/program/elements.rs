//! Models of elements from scene files, against sums over the elements.

use std::f64::consts::TAU;
use std::fs;

use crate::process::{folder_with, refuse, succeed};

/// Water, a row of eight elements, and a focus.
const WATER: &str = "format = 1\n[medium]\nsound_speed = 1482.0\ndensity = 998.0\nabsorption = 2.1\n[array]\nrows = 1\n\
                     columns = 8\npitch = 0.0003\nfrequency = 3.125e6\nstrength = 2.0\nMODEL\n[[target]]\nat = [0.001, 0, 0.02]\n";
const PLACES: [[f64; 3]; 3] = [[0.001, 0.0, 0.02], [0.0023, -0.0041, 0.017], [-0.006, 0.0008, 0.003]];

/// |P| (Pa) of the scene's drive at the places, D a function of the unit vector.
fn sums(drive: &str, directivity: impl Fn([f64; 3]) -> f64) -> Vec<f64> {
    let rows = drive.lines().skip(1).map(|line| line.split(',').map(|x| x.parse().unwrap()).collect());
    let rows: Vec<Vec<f64>> = rows.collect();
    let names: Vec<_> = drive.lines().next().unwrap().split(',').collect();
    let column = |name: &str| names.iter().position(|it| *it == name).unwrap();
    let (amplitude, phase) = (column("amplitude"), column("phase"));
    let (k, alpha) = (TAU * 3.125e6 / 1482.0, 2.1 * std::f64::consts::LN_10 / 20.0);
    let at = |place: &[f64; 3]| {
        let (mut re, mut im) = (0.0, 0.0);
        for (n, row) in rows.iter().enumerate() {
            let way = [place[0] - 0.0003 * (n as f64 - 3.5), place[1], place[2]];
            let r = way.map(|x| x * x).iter().sum::<f64>().sqrt();
            let size = 2.0 * row[amplitude] * directivity(way.map(|x| x / r)) * (-alpha * r).exp() / r;
            let (sin, cos) = (row[phase] - k * r).sin_cos();
            (re, im) = (re + size * cos, im + size * sin);
        }
        re.hypot(im)
    };
    PLACES.iter().map(at).collect()
}

#[test]
fn fields_in_water_are_sums_over_the_elements() {
    let sinc = |x: f64| if x == 0.0 { 1.0 } else { x.sin() / x };
    let half = TAU * 3.125e6 / 1482.0 / 2.0;
    type Model<'a> = (&'a str, Box<dyn Fn([f64; 3]) -> f64>);
    let models: [Model<'_>; 3] = [
        (
            "element = \"rectangle\"\nelement_size = [0.00025, 0.004]",
            Box::new(move |[x, y, _]| sinc(half * 0.00025 * x) * sinc(half * 0.004 * y)),
        ),
        ("element = \"cosine\"\nelement_exponent = 1.5", Box::new(|[.., z]| z.powf(1.5))),
        (
            "element = \"measured\"\ndirectivity = \"d.csv\"",
            // A table of a polynomial in cosθ that has both slopes of its spline: 0.4 + 0.6 cos²θ to 1e-6.
            Box::new(|[.., z]| 0.4 + 0.6 * z * z),
        ),
    ];
    let table: String = (0..=360)
        .map(|n| {
            format!(
                "{},{}\n",
                0.25 * f64::from(n),
                0.8 + 1.2 * (0.25 * f64::from(n)).to_radians().cos().powi(2)
            )
        })
        .collect();
    let points: String = PLACES.iter().map(|[x, y, z]| format!("{x},{y},{z}\n")).collect();
    for (index, (keys, directivity)) in models.into_iter().enumerate() {
        let scene = WATER.replace("MODEL", keys);
        let files = [
            ("a.toml", &*scene),
            ("points.csv", &format!("x,y,z\n{points}")),
            ("d.csv", &format!("angle,amplitude\n{table}")),
        ];
        let folder = folder_with(&files);
        succeed(folder.path(), &["solve", "a.toml", "--csv", "drive.csv"]);
        let drive = fs::read_to_string(folder.path().join("drive.csv")).unwrap();
        let answer =
            succeed(folder.path(), &["probe", "a.toml", "--points", "points.csv", "--drive", "drive.csv"]);
        for (line, expected) in answer.lines().skip(1).zip(sums(&drive, directivity)) {
            let row: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
            let own = row[3].hypot(row[4]);
            let most = if index == 2 { 1e-4 } else { 1e-8 };
            assert!((own / expected - 1.0).abs() < most, "{keys}: {line}, not {expected}");
        }
    }
}

#[test]
fn keys_of_elements_are_refused_with_their_lines() {
    let table = "angle,amplitude\n0,1\n30,x\n";
    let folder = folder_with(&[("d.csv", table)]);
    for (keys, said) in [
        ("element = \"measured\"", "array.directivity: `element = \"measured\"` needs the name of a table"),
        ("element = \"measured\"\ndirectivity = \"d.csv\"", "d.csv:3: amplitude = `x`: not a finite number"),
        ("element = \"rectangle\"\nelement_size = [0.01, 0]", "array.element_size"),
        (
            "element = \"cosine\"\nelement_exponent = -1",
            "array.element_exponent = -1: must be a number from 0",
        ),
    ] {
        fs::write(folder.path().join("a.toml"), WATER.replace("MODEL", keys)).unwrap();
        let refused = refuse(folder.path(), &["solve", "a.toml"]);
        assert!(refused.contains(said), "{refused}");
    }
}
