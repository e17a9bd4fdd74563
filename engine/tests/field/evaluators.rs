//! The fast evaluators against the f64 reference.

use glam::{DVec2, DVec3, dvec3};
use num_complex::{Complex32, Complex64};
use sonoglyph::acoustics::{Aperture, Scattering};
use sonoglyph::drive::Drive;
use sonoglyph::field::gpu::{Kind, adapter};
use sonoglyph::field::{Gpu, GpuError, Samples, Sources, cpu, reference};
use sonoglyph::scene::{Directivity, ElementModel, Plane, Reading, Scene, file};
use sonoglyph::simd::Isa;
use sonoglyph::solver;
use strum::VariantArray;

use crate::space::bowl;
use crate::{STEP, gpu, scattered};

/// Maximum of |P - P_ref| over the maximum of |P_ref|.
fn error(field: &[Complex32], reference: &[Complex64]) -> f64 {
    let peak = reference.iter().map(|p| p.norm()).fold(0.0, f64::max);
    let off = |(p, r): (&Complex32, &Complex64)| {
        let off = (Complex64::new(p.re.into(), p.im.into()) - r).norm();
        // `max` ignores NaN.
        if off.is_nan() { f64::INFINITY } else { off }
    };
    assert_eq!(field.len(), reference.len());
    field.iter().zip(reference).map(off).fold(0.0, f64::max) / peak
}

/// Irregular amplitudes and phases.
fn uneven(elements: usize, off: &[usize]) -> Drive {
    let amplitude =
        |n: usize| if off.contains(&n) { 0.0 } else { 0.3 + 0.7 * (n as f64 * 0.569_840_29).fract() };
    Drive { amplitudes: (0..elements).map(amplitude).collect(), ..scattered(elements, STEP) }
}

fn assert_evaluators_agree(name: &str, scene: &Scene, drive: &Drive, samples: &Samples, gpu: Option<&Gpu>) {
    const AGREEMENT: f64 = 2e-5;
    let mut aperture = Aperture::new(scene);
    // The evaluators sum over elements.
    aperture.bodies = Scattering::default();
    let sources = Sources::of_faces(&aperture, drive, samples).unwrap();
    let reference = reference::pressure(&aperture, drive, samples);
    for isa in Isa::available() {
        let error = error(&cpu::pressure_with(isa, &sources, samples.len()), &reference);
        println!("{name}: CPU {} {error:.2e}", isa.name());
        assert!(error < AGREEMENT, "{name}: CPU {} is {error:.1e} of the peak off", isa.name());
    }
    if let Some(gpu) = gpu {
        let error = error(&gpu.pressure(&sources).unwrap(), &reference);
        println!("{name}: GPU {error:.2e}");
        assert!(error < AGREEMENT, "{name}: the GPU is {error:.1e} of the peak off");
    }
}

#[test]
fn evaluators_agree_on_every_scene() {
    let gpu = gpu();
    let mut scenes = 0;
    for entry in std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../assets/scenes")).unwrap() {
        let path = entry.unwrap().path();
        let scene = file::read(&path).unwrap();
        let drive = solver::solve(&scene).unwrap().drive;
        let samples = Samples::on_plane(&scene.plane, 49, 47).unwrap();
        assert_evaluators_agree(&path.display().to_string(), &scene, &drive, &samples, gpu.as_ref());
        scenes += 1;
    }
    assert!(scenes >= 16, "{scenes} scenes");
}

#[test]
fn evaluators_agree_on_tilted_and_vertical_planes_and_other_arrays() {
    let gpu = gpu();
    let planes = [
        ("tilted", Plane { x_axis: dvec3(1.0, 0.2, 0.4), y_axis: dvec3(0.0, 1.0, -0.5), ..Plane::default() }),
        ("vertical", Plane { y_axis: DVec3::Z, centre: dvec3(0.003, 0.001, 0.12), ..Plane::default() }),
        (
            "through the array",
            Plane {
                y_axis: DVec3::Z,
                centre: dvec3(0.0, 0.002, 0.05),
                size: DVec2::splat(0.16),
                ..Plane::default()
            },
        ),
        ("far", Plane { centre: dvec3(0.1, -0.2, 1.0), size: DVec2::new(0.5, 0.3), ..Plane::default() }),
    ];
    // Beyond 1024 elements the GPU reads them from a storage buffer.
    let arrays: [(&str, u32, u32, &[usize]); 6] = [
        ("1 element", 1, 1, &[]),
        ("37 elements, some off", 37, 1, &[0, 5, 36]),
        ("32 x 32", 32, 32, &[]),
        ("33 x 32", 33, 32, &[]),
        ("64 x 64", 64, 64, &[]),
        ("65 x 64", 65, 64, &[17]),
    ];
    for (plane_name, plane) in &planes {
        for (array_name, rows, columns, off) in arrays {
            for &model in ElementModel::VARIANTS {
                // An odd number of samples, so that the last block and workgroup are partly empty. Exact pistons of
                // large arrays are slow in f64.
                let is_slow = model == ElementModel::ExactPiston && rows * columns > 500;
                let (width, height) = match (rows * columns > 2000, is_slow) {
                    (false, false) => (31, 23),
                    (true, false) | (false, true) => (17, 11),
                    (true, true) => (11, 7),
                };
                let samples = Samples::on_plane(plane, width, height).unwrap();
                let mut scene = Scene { plane: plane.clone(), ..Scene::default() };
                scene.array.rows = rows;
                scene.array.columns = columns;
                scene.array.off = off.to_vec();
                scene.array.element = model;
                (scene.array.element_size, scene.array.element_exponent) = (DVec2::new(0.009, 0.014), 3.0);
                scene.array.measured = measured();
                let drive = uneven(scene.array.elements(), off);
                let name = format!("{plane_name}, {array_name}, {model:?}");
                assert_evaluators_agree(&name, &scene, &drive, &samples, gpu.as_ref());
            }
        }
    }
}

/// A directivity with lobes and a phase.
pub fn measured() -> Directivity {
    let reading = |n: u32| {
        let angle = f64::from(5 * n);
        let sin2 = angle.to_radians().sin().powi(2);
        Reading { angle, amplitude: 0.3 + 0.7 * (4.0 * sin2).cos(), phase: 80.0 * sin2 }
    };
    Directivity::new((0..=18).map(reading).collect(), None)
}

#[test]
fn evaluators_agree_on_bowls() {
    let gpu = gpu();
    // Beyond 512 elements with their directions the GPU reads them from a storage buffer.
    for count in [60, 700] {
        let (mut scene, elements) = bowl(count);
        let drive = uneven(count, &[]);
        scene.array.measured = measured();
        for (name, plane) in [
            ("across", Plane { centre: DVec3::Z * 0.12, ..Plane::default() }),
            ("along", Plane { centre: DVec3::Z * 0.12, y_axis: DVec3::Z, ..Plane::default() }),
            ("far", Plane { centre: dvec3(0.1, -0.2, 1.0), size: DVec2::new(0.5, 0.3), ..Plane::default() }),
        ] {
            let samples = Samples::on_plane(&plane, 31, 23).unwrap();
            for model in [ElementModel::Piston, ElementModel::Cosine, ElementModel::Measured] {
                scene.array.element = model;
                let name = format!("{count}, {name}, {model:?}");
                assert_evaluators_agree(&name, &scene, &drive, &samples, gpu.as_ref());
            }
        }
        // In an element's own plane, where it is heard, and behind it, where it is not.
        let (at, normal) = elements[count / 2];
        let along = normal.any_orthonormal_vector();
        let points =
            (10..32).flat_map(|i| [0.0, -1e-3].map(|z| at + along * 0.004 * f64::from(i) + normal * z));
        let samples = Samples::at(points.chain([DVec3::Z * 0.12]).collect());
        assert_evaluators_agree(&format!("{count}, beside one"), &scene, &drive, &samples, gpu.as_ref());
    }
}

#[test]
fn evaluators_agree_with_large_elements_and_strong_absorption() {
    let gpu = gpu();
    let mut scene = Scene::default();
    scene.array.rows = 8;
    scene.array.columns = 8;
    scene.array.pitch = 0.03;
    scene.array.element_radius = 0.014;
    scene.medium.absorption = Some(60.0);
    let samples = Samples::on_plane(&scene.plane, 40, 40).unwrap();
    let drive = uneven(64, &[]);
    assert_evaluators_agree("large elements", &scene, &drive, &samples, gpu.as_ref());
}

#[test]
fn scattered_points_are_evaluated_like_grids() {
    let gpu = gpu();
    let point = |i: usize| {
        let unit = |step: f64| (i as f64 * step).fract();
        dvec3(unit(0.618) * 0.2 - 0.1, unit(0.7548) * 0.2 - 0.1, 0.02 + unit(0.5698) * 0.2)
    };
    let samples = Samples::at((0..333).map(point).collect());
    let scene = Scene::default();
    assert_evaluators_agree("points", &scene, &uneven(256, &[]), &samples, gpu.as_ref());
}

#[test]
fn the_field_behind_the_array_is_zero() {
    let samples = Samples::at(vec![dvec3(0.0, 0.0, -0.02), dvec3(0.01, 0.0, -2e-5), dvec3(0.0, 0.0, 0.02)]);
    let scene = Scene::default();
    let sources = Sources::of_faces(&Aperture::new(&scene), &uneven(256, &[]), &samples).unwrap();
    let mut fields = vec![cpu::pressure(&sources, samples.len())];
    fields.extend(gpu().map(|gpu| gpu.pressure(&sources).unwrap()));
    for field in fields {
        assert_eq!(field[..2], [Complex32::ZERO; 2]);
        assert!(field[2].norm() > 0.0);
    }
}

#[test]
fn an_absent_adapter_is_an_error() {
    let wanted = adapter::adapters().into_iter().all(|info| info.kind == Kind::Software);
    if wanted {
        assert!(matches!(adapter::open_best(false), Err(GpuError::NoAdapter(_))));
    }
}

#[test]
fn evaluators_agree_in_the_plane_of_the_array() {
    // Also a hair behind it, which rounding may make of it.
    let points = [0.0, 4e-6, -4e-6].map(|z| [dvec3(0.0, 0.0, z), dvec3(0.0105, -0.021, z)]).concat();
    let scene = Scene::default();
    let samples = Samples::at(points);
    assert_evaluators_agree("in the plane", &scene, &uneven(256, &[]), &samples, gpu().as_ref());
}
