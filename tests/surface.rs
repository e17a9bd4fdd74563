//! Dents against the reference values of an endless bath.

#![expect(clippy::unwrap_used, reason = "a test's helper may panic")]

use std::f64::consts::PI;

use serde_json::Value;
use sonoglyph::scene::Liquid;
use sonoglyph::surface::Tank;

/// Pressure for every cell from its place (m) from the middle.
fn load(tank: &Tank, at: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    let place = |axis: usize, i: usize| (i as f64 + 0.5 - tank.counts[axis] as f64 / 2.0) * tank.step[axis];
    (0..tank.len()).map(|i| at(place(0, i % tank.counts[0]), place(1, i / tank.counts[0]))).collect()
}

fn reference() -> Value {
    serde_json::from_str(include_str!("reference/liquid_dent.json")).unwrap()
}

fn liquid() -> Liquid {
    let given = &reference()["liquid"];
    Liquid {
        density: given["density"].as_f64(),
        surface_tension: given["surface_tension"].as_f64(),
        gravity: given["gravity"].as_f64().unwrap(),
        ..Liquid::default()
    }
}

#[test]
fn gaussian_loads_dent_as_the_reference_says() {
    let tank = Tank::new([151, 135], [0.0008, 0.0009]);
    for case in reference()["gaussian"].as_array().unwrap() {
        let [p0, w, centre] = ["p0", "w", "centre"].map(|key| case[key].as_f64().unwrap());
        let pressure = load(&tank, |x, y| p0 * (-(x * x + y * y) / (w * w)).exp());
        let dent = tank.dent(&liquid(), &pressure);
        let deepest = dent.depth[67 * 151 + 75];
        assert!((deepest / centre - 1.0).abs() < 1e-6, "{case}: {deepest}");
        assert!((dent.volume * liquid().density() * liquid().gravity / dent.force - 1.0).abs() < 1e-12);
        assert!((dent.force / (p0 * PI * w * w) - 1.0).abs() < 1e-6);
    }
}

#[test]
fn discs_dent_as_the_reference_says() {
    const STEP: f64 = 0.0001;
    /// Parts of a cell, along each axis, of which those within the disc count.
    const PARTS: usize = 8;
    let tank = Tank::new([801, 801], [STEP, STEP]);
    for case in reference()["disk"].as_array().unwrap() {
        let [p0, a, r, depth] = ["p0", "a", "r", "depth"].map(|key| case[key].as_f64().unwrap());
        let pressure = load(&tank, |x, y| {
            if (x.hypot(y) - a).abs() > STEP {
                return if x.hypot(y) < a { p0 } else { 0.0 };
            }
            let part = |place: f64, i: usize| place + STEP * ((i as f64 + 0.5) / PARTS as f64 - 0.5);
            let inside =
                (0..PARTS * PARTS).filter(|i| part(x, i % PARTS).hypot(part(y, i / PARTS)) < a).count();
            p0 * inside as f64 / (PARTS * PARTS) as f64
        });
        let found = tank.dent(&liquid(), &pressure).depth[400 * 801 + 400 + (r / STEP).round() as usize];
        assert!((found / depth - 1.0).abs() < 1e-4, "{case}: {found}");
    }
}
