//! The sound that surfaces scatter: sums in f32 on CPU and GPU against f64.

use glam::{DMat3, DVec3, dvec3};
use num_complex::{Complex32, Complex64};
use sonoglyph::field::Gpu;
use sonoglyph::field::gpu::Tuning;
use sonoglyph_engine::mesh::{Mesh, shapes};
use sonoglyph_engine::scatter::{Bodies, Boundary, Incident, Sound};
use sonoglyph_engine::scene::{Body, BodyKind, Reflector};

use crate::dice::Dice;
use crate::gpu;

const WAVENUMBER: f64 = 732.0;
const EDGE: f64 = 0.0014;
const AGREEMENT: f64 = 2e-5;

/// Pressures of random phase and amplitude.
fn random(dice: &mut Dice, count: usize) -> Vec<Complex64> {
    (0..count).map(|_| Complex64::new(dice.unit() - 0.5, dice.unit() - 0.5)).collect()
}

/// Points outside a body at distances (m) from its surface.
fn around(dice: &mut Dice, mesh: &Mesh, count: usize, [nearest, farthest]: [f64; 2]) -> Vec<DVec3> {
    let point = |n: usize| {
        let [a, b, c] = mesh.corners(dice.index(mesh.triangles.len()));
        let out = (b - a).cross(c - a).normalize_or_zero();
        let (u, v) = (dice.unit() / 2.0, dice.unit() / 2.0);
        let off = nearest * (farthest / nearest).powf(n as f64 / count as f64);
        a + (b - a) * u + (c - a) * v + out * off
    };
    (0..count).map(point).filter(|at| !mesh.contains(*at)).collect()
}

/// The largest difference, relative to the largest expected.
fn off(found: impl IntoIterator<Item = Complex64>, expected: &[Complex64]) -> f64 {
    let peak = expected.iter().map(|p| p.norm()).fold(0.0, f64::max);
    let off = found.into_iter().zip(expected).map(|(p, e)| (p - e).norm());
    // `max` ignores NaN.
    off.map(|off| if off.is_nan() { f64::INFINITY } else { off }).fold(0.0, f64::max) / peak
}

/// Pressures and slopes by phase.
fn parts(sounds: &[Sound]) -> Vec<Complex64> {
    let of = |(p, gradient): &Sound| [*p].into_iter().chain(gradient.map(|slope| slope / WAVENUMBER));
    sounds.iter().flat_map(of).collect()
}

fn wide(p: &Complex32) -> Complex64 {
    Complex64::new(p.re.into(), p.im.into())
}

fn bodies() -> impl Iterator<Item = (&'static str, Boundary)> {
    let capsule = shapes::capsule(dvec3(-0.01, 0.0, 0.001), dvec3(0.01, 0.004, 0.0), 0.004, EDGE);
    let both = [("rigid sphere", shapes::sphere(0.006, EDGE), 1.0), ("soft capsule", capsule, 0.6)];
    both.into_iter()
        .map(|(name, mesh, coefficient)| (name, Boundary::new(&mesh, coefficient, WAVENUMBER).unwrap()))
}

#[test]
fn sums_of_cpu_and_gpu_are_those_of_f64_near_and_far() {
    let gpu = gpu();
    let mut dice = Dice::seeded(62);
    for (name, body) in bodies() {
        let nodal = random(&mut dice, body.mesh().vertices.len());
        for distances in [[EDGE, 0.02], [0.02, 0.3]] {
            let points = around(&mut dice, body.mesh(), 700, distances);
            let expected: Vec<_> = body.sound(&nodal, &points).iter().map(|(p, _)| *p).collect();
            let error = off(body.scattered(&nodal, &points), &expected);
            println!("{name} {distances:?}: CPU {error:.2e}");
            assert!(error < AGREEMENT, "{name}: CPU {error:.1e}");
            let Some(gpu) = &gpu else { continue };
            let near = body.corrections(&nodal, &points);
            let sums = gpu.scattered(&[body.emission(&nodal)], &points).unwrap();
            let error = off(sums.iter().zip(&near).map(|(p, near)| wide(p) + near.0), &expected);
            println!("{name} {distances:?}: GPU {error:.2e}");
            assert!(error < AGREEMENT, "{name}: GPU {error:.1e}");
        }
    }
}

#[test]
fn slopes_are_those_of_f64_at_any_distance() {
    let mut dice = Dice::seeded(63);
    for (name, body) in bodies() {
        let nodal = random(&mut dice, body.mesh().vertices.len());
        for distances in [[1e-6, 1e-4], [1e-4, EDGE], [EDGE, 0.02], [0.02, 0.3]] {
            let points = around(&mut dice, body.mesh(), 300, distances);
            let error = off(parts(&body.sounds(&nodal, &points)), &parts(&body.sound(&nodal, &points)));
            println!("{name} {distances:?}: {error:.2e}");
            assert!(error < AGREEMENT, "{name} {distances:?}: {error:.1e}");
        }
    }
}

#[test]
fn sources_that_are_turned_mirrored_and_shifted_sound_the_same_there() {
    let mut dice = Dice::seeded(64);
    let (_, body) = bodies().nth(1).unwrap();
    let emission = body.emission(&random(&mut dice, body.mesh().vertices.len()));
    let points = around(&mut dice, body.mesh(), 100, [0.004, 0.1]);
    let mirror = DMat3::from_diagonal(dvec3(1.0, -1.0, 1.0));
    let (axes, shift) = (DMat3::from_rotation_x(0.7) * mirror, dvec3(0.02, 0.05, -0.1));
    let there: Vec<_> = points.iter().map(|at| axes * *at + shift).collect();
    let sums = emission.placed(axes, shift, 0.5).pressures(&there);
    let error = off(sums.iter().map(|p| p * 2.0), &emission.pressures(&points));
    assert!(error < AGREEMENT, "{error:.1e}");
}

#[test]
fn work_cut_for_any_adapter_gives_the_same_sums() {
    let Some(gpu) = gpu() else { return };
    let mut dice = Dice::seeded(65);
    let emissions: Vec<_> =
        bodies().map(|(_, body)| body.emission(&random(&mut dice, body.mesh().vertices.len()))).collect();
    let points: Vec<_> = (0..1000).map(|n| dvec3(0.0, 0.02 + 1e-4 * f64::from(n), 0.01)).collect();
    let sum =
        |gpu: &Gpu| -> Vec<_> { gpu.scattered(&emissions, &points).unwrap().iter().map(wide).collect() };
    let expected = sum(&gpu);
    let starved = Tuning { most_rounds: 1 << 9, most_pairs: 1 << 14, ..Tuning::SOFTWARE };
    for tuning in [starved, Tuning::INTEGRATED] {
        let error = off(sum(&gpu.twin().with_tuning(tuning)), &expected);
        assert!(error < AGREEMENT, "{tuning:?}: {error:.1e}");
    }
    let error = off(sum(&gpu.with_small_buffers(1 << 12)), &expected);
    assert!(error < AGREEMENT, "small buffers: {error:.1e}");
}

#[test]
fn several_drives_together_are_those_alone() {
    let mut dice = Dice::seeded(66);
    let (_, body) = bodies().nth(1).unwrap();
    let nodals: Vec<_> = (0..6).map(|_| random(&mut dice, body.mesh().vertices.len())).collect();
    let points = around(&mut dice, body.mesh(), 100, [1e-4, 0.1]);
    let nodals: Vec<_> = nodals.iter().map(Vec::as_slice).collect();
    for (together, nodal) in body.scattered_by_all(&nodals, &points).into_iter().zip(nodals) {
        let error = off(together, &body.scattered(nodal, &points));
        assert!(error < 1e-12, "{error:.1e}");
    }
}

#[test]
fn sums_of_the_gpu_with_corrections_are_the_sound_of_all_bodies_and_their_images() {
    let Some(gpu) = gpu() else { return };
    let capsule = Body {
        kind: BodyKind::Capsule,
        at: dvec3(0.02, 0.01, 0.03),
        x_axis: dvec3(1.0, 0.5, 0.2),
        radius: 0.003,
        length: 0.012,
        coefficient: 0.8,
        ..Body::default()
    };
    let sphere = Body { at: dvec3(-0.02, 0.0, 0.04), radius: 0.005, ..Body::default() };
    let mirror = Reflector { point: DVec3::ZERO, normal: dvec3(0.1, 0.0, 1.0), coefficient: 0.7 };
    let bodies = Bodies::new(&[capsule, sphere], &[mirror], WAVENUMBER, &[]).unwrap();
    let mut dice = Dice::seeded(68);
    let count = bodies.points().0.len();
    let incident = Incident { pressures: random(&mut dice, count), slopes: vec![Complex64::ZERO; count] };
    let answer = bodies.answers(&[incident], None).remove(0);
    let points: Vec<_> = (0..500)
        .map(|_| dvec3(dice.unit() - 0.5, dice.unit() - 0.5, 0.5 + dice.unit()) * 0.08)
        .filter(|at| !bodies.contains(*at))
        .collect();
    let emissions = bodies.emissions(&answer);
    let sums = gpu.scattered(&emissions, &points).unwrap();
    let rest = bodies.corrections(&answer, &points);
    let expected: Vec<_> = bodies.sounds(&answer, &points).into_iter().map(|(p, _)| p).collect();
    let error = off(sums.iter().zip(rest).map(|(p, rest)| wide(p) + rest), &expected);
    assert!(error < AGREEMENT, "{error:.1e}");
}
