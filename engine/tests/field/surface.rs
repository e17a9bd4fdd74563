//! Depressions against reference values, and refracted light against closed forms.

use std::f64::consts::PI;

use serde_json::Value;
use sonoglyph::scene::Liquid;
use sonoglyph::surface::{Light, Rays, Tank, light};

/// The pressure on every cell as a function of its position (m) from the centre.
fn load(tank: &Tank, at: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    let place = |axis: usize, i: usize| (i as f64 + 0.5 - tank.counts[axis] as f64 / 2.0) * tank.step[axis];
    (0..tank.count()).map(|i| at(place(0, i % tank.counts[0]), place(1, i / tank.counts[0]))).collect()
}

fn reference() -> Value {
    serde_json::from_str(include_str!("../../../tests/reference/liquid_dent.json")).unwrap()
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
fn gaussian_loads_agree_with_the_reference() {
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
fn discs_agree_with_the_reference() {
    const STEP: f64 = 0.0001;
    /// Subdivisions of a cell along each axis, counted within the disc.
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

/// A depression d0 e^(-r²/w²) of water in the middle of a square screen, in transmitted light.
#[derive(Clone, Copy)]
struct Gaussian {
    /// Side of the screen (m), and its pixels along it.
    side: f64,
    pixels: usize,
    /// Rays per pixel along each axis.
    rays: f64,
    /// Side of the illuminated surface, in sides of the screen.
    reach: f64,
    /// Offset (m) of the screen from the depression, to the right and upwards.
    aside: [f64; 2],
    /// Displacement (m) of light per unit of slope.
    throw: f64,
}

const DEEP: f64 = 1e-3;
const WIDE: f64 = 3.88e-3;
const INDEX: f64 = 1.333;

impl Default for Gaussian {
    fn default() -> Self {
        Self { side: 0.03, pixels: 150, rays: 2.0, reach: 1.6, aside: [0.0; 2], throw: 0.0 }
    }
}

impl Gaussian {
    fn pixel(&self) -> f64 {
        self.side / self.pixels as f64
    }

    fn light(&self) -> (Vec<f32>, Light) {
        let half = self.reach * self.side / 2.0;
        let count = (2.0 * half / self.pixel() * self.rays).ceil() as usize + 1;
        let step = 2.0 * half / (count - 1) as f64;
        let place = |i: usize| step * i as f64 - half;
        let slope =
            |x: f64, y: f64| -2.0 * DEEP * x / (WIDE * WIDE) * (-(x * x + y * y) / (WIDE * WIDE)).exp();
        let all = |of: &dyn Fn(f64, f64) -> f64| -> Vec<f32> {
            (0..count * count).map(|i| of(place(i % count), place(i / count)) as f32).collect()
        };
        let slopes = [all(&|x, y| slope(x, y)), all(&|x, y| slope(y, x))];
        let mut values = vec![0.0; self.pixels * self.pixels];
        let rays = Rays {
            counts: [count; 2],
            first: self.aside.map(|aside| (self.side / 2.0 - half - aside) / self.pixel()),
            step: [step / self.pixel(); 2],
            slopes: slopes.each_ref().map(|slopes| &slopes[..]),
            throw: [self.throw / self.pixel(); 2],
        };
        let light = light(&[rays], self.pixels, &mut values);
        (values, light)
    }
}

/// The throw that gives the middle of a Gaussian the brightness (1 + a)⁻².
fn throw(a: f64) -> f64 {
    a * WIDE * WIDE / (2.0 * DEEP)
}

#[test]
fn a_patch_that_lands_at_a_point_lights_its_pixel() {
    // All four rays land at (2.5, 1.5).
    let slopes = [[-1.5, -0.5, -1.5, -0.5], [-0.5, -0.5, 0.5, 0.5]];
    let rays = Rays {
        counts: [2; 2],
        first: [1.0; 2],
        step: [1.0; 2],
        slopes: slopes.each_ref().map(|slopes| &slopes[..]),
        throw: [1.0; 2],
    };
    let mut values = vec![0.0; 5 * 4];
    let light = light(&[rays], 5, &mut values);
    let lit: Vec<_> = (0..values.len()).filter(|&pixel| values[pixel] != 0.0).collect();
    assert_eq!(lit, [5 + 2]);
    assert_eq!((values[lit[0]], light.sent, light.landed), (1.0, 1.0, 1.0));
}

#[test]
fn light_through_a_level_surface_is_undisturbed() {
    let (values, light) = Gaussian::default().light();
    assert!(values.iter().all(|value| (value - 1.0).abs() < 1e-6));
    assert!((light.landed - 150.0 * 150.0).abs() < 1e-6 && !light.crosses, "{light:?}");
}

#[test]
fn the_brightness_of_the_middle_follows_from_the_curvature() {
    for a in [0.5, 2.0, 5.0, -0.3, -0.6] {
        let gaussian = Gaussian {
            side: 0.004,
            pixels: 101,
            reach: 9.0,
            rays: 1.0,
            throw: throw(a),
            ..Gaussian::default()
        };
        let (values, light) = gaussian.light();
        let (middle, expected) = (f64::from(values[50 * 101 + 50]), (1.0 + a).powi(-2));
        assert!((middle / expected - 1.0).abs() < 1e-3, "A = {a}: {middle}, not {expected}");
        assert_eq!(light.crosses, a > 2.2408, "A = {a}");
    }
}

#[test]
fn rays_that_cross_beside_the_screen_are_no_caustic_there() {
    // Nine rows of rays, of which the seventh and the eighth land in reverse order.
    let mut slopes = [[0.0; 27]; 2];
    slopes[1][18..21].fill(-1.0);
    slopes[1][21..24].fill(1.0);
    for (first, rows, crosses) in [
        ([0.0, 0.0], 8, true),
        ([0.0, 0.0], 4, false),
        ([0.0, -8.5], 8, false),
        ([2.5, 0.0], 8, false),
        ([-2.5, 0.0], 8, false),
    ] {
        let rays = Rays {
            counts: [3, 9],
            first,
            step: [1.0; 2],
            slopes: slopes.each_ref().map(|slopes| &slopes[..]),
            throw: [1.0; 2],
        };
        let light = light(&[rays], 2, &mut vec![0.0; 2 * rows]);
        assert_eq!(light.crosses, crosses, "from {first:?}, {rows} rows: {light:?}");
        assert_eq!(light.landed > 0.0, first == [0.0; 2], "from {first:?}, {rows} rows: {light:?}");
    }
}

#[test]
fn the_first_caustic_is_at_its_predicted_distance() {
    let crosses =
        |distance: f64| Gaussian { throw: (INDEX - 1.0) * distance, ..Gaussian::default() }.light().1.crosses;
    let (mut before, mut behind) = (0.01, 0.2);
    assert!(!crosses(before) && crosses(behind));
    while behind - before > 1e-6 {
        let middle = 0.5 * (before + behind);
        if crosses(middle) { behind = middle } else { before = middle }
    }
    let expected = 1.1204 * WIDE * WIDE / ((INDEX - 1.0) * DEEP);
    assert!((before / expected - 1.0).abs() < 0.01, "{before} m, not {expected} m");
}

#[test]
fn a_smaller_screen_and_any_number_of_threads_show_the_same_light() {
    let whole = Gaussian { throw: throw(4.0), ..Gaussian::default() };
    // The lower left quarter, less a row and a column of pixels, with the same rays.
    let part =
        Gaussian { side: whole.side * 0.5, pixels: 75, reach: 3.2, aside: [-whole.side * 0.25; 2], ..whole };
    let (of_whole, of_part) = (whole.light().0, part.light().0);
    for row in 0..75 {
        for column in 0..75 {
            let (one, other) = (of_whole[row * 150 + column], of_part[row * 75 + column]);
            assert!((one - other).abs() < 1e-4 * one.max(1.0), "{column}, {row}: {one} {other}");
        }
    }
    let by = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| whole.light())
    };
    assert_eq!(by(1), by(3));
}
