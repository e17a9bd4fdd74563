//! Agreement with the 40-digit values in `tests/reference/`.

use std::f64::consts::{PI, TAU};
use std::path::Path;

use glam::{DVec2, DVec3};
use num_complex::Complex64;
use serde_json::Value;
use sonoglyph::acoustics::{Aperture, Element, absorption};
use sonoglyph::scene::{Array, ElementModel, Medium, Method, Scene, Shape, Solver, Target};
use sonoglyph::solver::{self, Problem};

fn reference(name: &str) -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/reference").join(name);
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn point(value: &Value) -> DVec3 {
    DVec3::new(number(&value[0]), number(&value[1]), number(&value[2]))
}

fn complex(value: &Value) -> Complex64 {
    Complex64::new(number(&value[0]), number(&value[1]))
}

/// The reference's medium, without absorption, and the source strength of 1 m/s surface velocity.
fn scene(medium: &Value, array: Array) -> Scene {
    let (frequency, density, radius) =
        (number(&medium["frequency"]), number(&medium["density"]), number(&medium["radius"]));
    Scene {
        medium: Medium {
            sound_speed: Some(number(&medium["sound_speed"])),
            density: Some(density),
            absorption: Some(0.0),
            ..Medium::default()
        },
        array: Array {
            frequency,
            element_radius: radius,
            strength: density * TAU * frequency * radius * radius / 2.0,
            ..array
        },
        ..Scene::default()
    }
}

fn square(rows: &Value, pitch: &Value) -> Array {
    let rows = rows.as_u64().unwrap() as u32;
    Array { rows, columns: rows, pitch: number(pitch), ..Array::default() }
}

#[test]
fn one_element_agrees_to_1e_10() {
    let reference = reference("element_transfer.json");
    for (model, key) in [
        (ElementModel::Piston, "far_field"),
        (ElementModel::ExactPiston, "exact_piston"),
        (ElementModel::Rectangle, "rectangle"),
        (ElementModel::Cosine, "cosine"),
    ] {
        let array = Array {
            rows: 1,
            columns: 1,
            element: model,
            element_size: DVec2::new(0.012, 0.004),
            element_exponent: 1.5,
            ..Array::default()
        };
        let aperture = Aperture::new(&scene(&reference["medium"], array));
        let cases = reference["cases"].as_array().unwrap();
        assert_eq!(cases.len(), 50);
        for case in cases {
            let expected = complex(&case[key]);
            let got = aperture.transfer(&[point(&case["point"])]).at(0, 0);
            assert!(
                (got - expected).norm() < 1e-10 * expected.norm(),
                "{key} at {}: {got}, not {expected}",
                case["point"]
            );
        }
    }
}

/// For every ka that a scene may have. Errors are relative, with a floor of a thousandth of the value elsewhere where
/// the waves of the disk cancel.
#[test]
fn the_exact_piston_agrees_to_1e_10_on_its_surface_and_at_its_rim_too() {
    let reference = reference("exact_piston.json");
    let cases = reference["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 71);
    for case in cases {
        let (k, a, at) = (number(&case["wavenumber"]), number(&case["radius"]), point(&case["point"]));
        let model = ElementModel::ExactPiston;
        let usual = Aperture::new(&Scene::default()).element;
        let element = Element { model, wavenumber: k, radius: a, strength: 1.0, attenuation: 0.0, ..usual };
        let expected = complex(&case["pressure"]);
        let off = (element.transfer(at) - expected).norm();
        let usual = (4.0 / (k * a * a)).min(1.0 / at.length());
        assert!(
            off < 1e-10 * expected.norm().max(1e-3 * usual),
            "ka = {} at {at}: {off:e} of {expected}",
            k * a
        );
    }
}

#[test]
fn a_focused_array_agrees_to_1e_10() {
    let reference = reference("focus_field.json");
    for case in reference["cases"].as_array().unwrap() {
        let array = square(&reference["array"]["rows"], &reference["array"]["pitch"]);
        let mut scene = scene(&reference["medium"], array);
        scene.targets = vec![Target::new(Shape::Point { at: point(&case["focus"]) })];
        scene.solver = Solver { method: Method::Focus, ..Solver::default() };
        let drive = solver::solve(&scene).unwrap().drive;
        let aperture = Aperture::new(&scene);
        let points: Vec<_> = case["points"].as_array().unwrap().iter().map(point).collect();
        let pressures = aperture.transfer(&points).pressure(&drive.excitation(&aperture.driven));
        let expected: Vec<_> = case["pressure"].as_array().unwrap().iter().map(complex).collect();
        for (got, expected) in pressures.iter().zip(&expected) {
            assert!((got - expected).norm() < 1e-10 * expected.norm(), "{got}, not {expected}");
        }
        assert!((expected[0].arg() - PI / 2.0).abs() < 1e-12, "a focus has the phase of j");
    }
}

#[test]
fn absorption_agrees_to_1e_10() {
    let reference = reference("air_absorption.json");
    for case in reference["cases"].as_array().unwrap() {
        let expected = number(&case["db_per_m"]);
        let (frequency, temperature) = (number(&case["frequency"]), number(&case["temperature_c"]));
        let got = absorption(frequency, temperature, number(&case["humidity_percent"]), 101_325.0);
        assert!((got / expected - 1.0).abs() < 1e-10, "{case}: {got}");
    }
}

#[test]
fn the_weighted_iteration_agrees_at_every_step() {
    let reference = reference("weighted_efficiency.json");
    for case in reference["cases"].as_array().unwrap() {
        let mut scene =
            scene(&reference["medium"], square(&reference["array"]["rows"], &reference["array"]["pitch"]));
        let points = case["points"].as_array().unwrap().iter().map(point);
        scene.targets = points.map(|at| Target::new(Shape::Point { at })).collect();
        for (iterations, expected) in case["efficiency_percent"].as_array().unwrap().iter().enumerate() {
            // In a scene, 0 iterations select the method's default; the table's entry 0 is the pseudo-inverse.
            let method = if iterations == 0 { Method::Pinv } else { Method::Weighted };
            scene.solver = Solver { method, iterations: iterations as u32, ..Solver::default() };
            let efficiency = 100.0 * solver::solve(&scene).unwrap().quality.efficiency;
            let expected = number(expected);
            assert!(
                (efficiency - expected).abs() < 0.1,
                "{} after {iterations} iterations: {efficiency} %, not {expected} %",
                case["name"]
            );
        }
        let quality = solver::solve(&scene).unwrap().quality;
        let expected = &case["phase_only_after_12"];
        assert!(
            (quality.spread - number(&expected["spread"])).abs() < 1e-4,
            "{}: {}",
            case["name"],
            quality.spread
        );
        let aperture = Aperture::new(&scene);
        let problem = Problem::new(&aperture, sonoglyph::scene::outline::foci(&scene).unwrap());
        let single = problem.transfer.rows().map(|row| row.map(|h| h.norm()).sum::<f64>()).sum::<f64>();
        let mean = quality.mean_pressure * problem.foci.len() as f64 / single;
        assert!(
            (mean - number(&expected["mean_over_single_focus_bound"])).abs() < 1e-3,
            "{}: {mean}",
            case["name"]
        );
    }
}
