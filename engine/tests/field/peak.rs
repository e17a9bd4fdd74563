//! The peak of a map: of the pixels a wavelength or more from every element, and 0 where sums only round.

use std::f64::consts::PI;

use glam::{DVec2, DVec3, dvec3};
use sonoglyph::acoustics::Aperture;
use sonoglyph::drive::Drive;
use sonoglyph::field::{By, Colouring, Evaluator, Map, Norm, Quantity, Request, Samples, Stages, reference};
use sonoglyph::picture::ColourMap;
use sonoglyph::scene::{Array, Board, Plane, Scene};

use crate::{STEP, evaluators, fast_evaluators, scattered};

/// A vertical plane through the centres of a row of elements.
fn side() -> Scene {
    let array = Array { rows: 5, columns: 4, ..Array::default() };
    let centre = dvec3(0.001, 0.0, 0.02);
    let plane = Plane { centre, y_axis: DVec3::Z, size: DVec2::new(0.06, 0.04), ..Plane::default() };
    Scene { array, plane, ..Scene::default() }
}

fn map(scene: &Scene, drives: &[Drive], quantity: Quantity, size: (usize, usize), by: Evaluator) -> Map {
    let request = Request { moment: 0.4, ..Request::new(scene, drives.to_vec(), quantity, size) };
    Stages::new(by).map(&request).unwrap().clone()
}

/// Of every pixel, whether an element is nearer than a wavelength.
fn nearness(scene: &Scene, size: (usize, usize)) -> Vec<bool> {
    let (aperture, pixels) = (Aperture::new(scene), Samples::on_plane(&scene.plane, size.0, size.1).unwrap());
    let is_near = |point: DVec3| {
        aperture.positions.iter().any(|at| at.distance(point) < aperture.wavelength() && point.z >= 0.0)
    };
    (0..pixels.len()).map(|pixel| is_near(pixels.point(pixel))).collect()
}

fn largest(values: &[f32], are: impl Iterator<Item = bool>) -> f32 {
    values.iter().zip(are).filter(|(_, is)| *is).fold(0.0, |most, (value, _)| most.max(value.abs()))
}

/// Whether it is larger next to elements.
fn is_local(quantity: &Quantity) -> bool {
    !quantity.declaration().is_pressed() && !quantity.declaration().of_volume
}

#[test]
fn peaks_leave_out_pixels_next_to_elements() {
    let (scene, size) = (side(), (151, 101));
    let near = nearness(&scene, size);
    let drives = [scattered(20, STEP), scattered(20, 0.3)];
    let pixels = Samples::on_plane(&scene.plane, size.0, size.1).unwrap();
    let exact = reference::pressure(&Aperture::new(&scene), &drives[0], &pixels);
    let pressures: Vec<_> = exact.iter().map(|p| p.norm() as f32).collect();
    for quantity in Quantity::ALL.into_iter().filter(is_local) {
        for evaluator in evaluators() {
            for count in [1, 2] {
                let name =
                    format!("{quantity:?} of {count} by {evaluator:?}").chars().take(60).collect::<String>();
                let evaluator = match &evaluator {
                    Evaluator::Reference => Evaluator::Reference,
                    Evaluator::Cpu => Evaluator::Cpu,
                    Evaluator::Gpu(gpu) => Evaluator::Gpu(Box::new(gpu.twin())),
                };
                let made = map(&scene, &drives[..count], quantity, size, evaluator);
                let (values, slack) = match quantity.declaration().norm {
                    Norm::Pressure => (&pressures, 1e-4),
                    Norm::Value | Norm::Difference => (&made.values, 1e-6),
                };
                let (all, counted) = (
                    largest(values, near.iter().map(|_| true)),
                    largest(values, near.iter().map(|near| !near)),
                );
                // An element's own velocity along its plane's normal vanishes there.
                let has_larger = quantity != Quantity::Velocity;
                assert!(!has_larger || all > 3.0 * counted, "{name}: {all} {counted}");
                assert!((made.peak / counted - 1.0).abs() < slack, "{name}: {} {counted}", made.peak);
                assert!((made.loudest / all - 1.0).abs() < slack.max(1e-3), "{name}: {} {all}", made.loudest);
                assert_eq!(made.near, near.iter().filter(|near| **near).count(), "{name}");
                // Maps of beads in the sound of far-field pistons have a limit of their own.
                let promised =
                    scene.plane.tolerance.max(if quantity.declaration().of_bead { 5e-3 } else { 0.0 });
                assert!(made.has_larger() == has_larger && made.error <= promised, "{name}: {}", made.error);
            }
        }
    }
}

#[test]
fn a_side_views_peak_is_not_of_its_pixels() {
    let scene = side();
    let drive = [scattered(20, STEP)];
    let [coarse, fine] =
        [(120, 80), (480, 320)].map(|size| map(&scene, &drive, Quantity::Rms, size, Evaluator::Cpu));
    assert!((coarse.peak / fine.peak - 1.0).abs() < 0.02, "{} {}", coarse.peak, fine.peak);
    assert!(coarse.has_larger() && fine.has_larger(), "{} {}", coarse.loudest, fine.loudest);
}

#[test]
fn a_map_next_to_elements_counts_in_full() {
    let mut scene = side();
    scene.plane = Plane { centre: DVec3::Z * 0.003, size: DVec2::splat(0.02), ..Plane::default() };
    for evaluator in fast_evaluators() {
        let made = map(&scene, &[scattered(20, STEP)], Quantity::Rms, (40, 30), evaluator);
        assert_eq!((made.near, made.peak), (40 * 30, made.loudest));
        assert_eq!(made.peak, largest(&made.values, std::iter::repeat(true)));
    }
}

/// Two boards face to face, and the plane half-way between them.
fn facing() -> Scene {
    let array = Array { rows: 4, columns: 4, ..Array::default() };
    let opposite = Board { at: DVec3::Z * 0.12, normal: DVec3::NEG_Z, ..Board::default() };
    let plane = Plane { centre: DVec3::Z * 0.06, size: DVec2::new(0.05, 0.04), ..Plane::default() };
    Scene { array, boards: vec![Board::default(), opposite], plane, ..Scene::default() }
}

/// The first board's drive as the second board's mirror image, in opposite phase and of this strength.
fn opposed(scene: &Scene, strength: f64) -> Drive {
    let aperture = Aperture::new(scene);
    let phase = |at: &DVec3| 300.0 * at.x * at.x + 40.0 * at.y;
    let half = aperture.positions.len() / 2;
    let turn = |n: usize| if n < half { 0.0 } else { PI };
    let positions = aperture.positions.iter().enumerate();
    Drive {
        amplitudes: (0..2 * half).map(|n| if n < half { 1.0 } else { strength }).collect(),
        phases: positions.map(|(n, at)| phase(at) + turn(n)).collect(),
    }
}

fn is_flat(scene: &Scene, drive: &Drive, quantity: Quantity) -> bool {
    let request = Request::new(scene, vec![drive.clone()], quantity, (40, 30));
    let colouring = Colouring::new(quantity, ColourMap::Inferno.table());
    let mut stages = Stages::new(Evaluator::Cpu);
    let colours = stages.colours(&request, &colouring).unwrap();
    colours.iter().all(|colour| *colour == colours[0])
}

#[test]
fn what_only_rounds_is_silent() {
    let opposed_boards = facing();
    let drive_of_boards = opposed(&opposed_boards, 1.0);
    let mut upright = side();
    upright.plane.centre.z = 0.1;
    let aperture = Aperture::new(&upright);
    let at = dvec3(0.01, 0.0, 0.1);
    let ways = aperture.positions.iter().map(|from| aperture.element.wavenumber * from.distance(at));
    let focus = Drive { amplitudes: vec![1.0; 20], phases: ways.collect() };
    let of_boards =
        [Quantity::Rms, Quantity::Phase, Quantity::Instantaneous, Quantity::Radiation, Quantity::Depression];
    let cases = of_boards.map(|quantity| (&opposed_boards, &drive_of_boards, quantity));
    for (scene, drive, quantity) in cases.into_iter().chain([(&upright, &focus, Quantity::Velocity)]) {
        for evaluator in evaluators() {
            for tolerance in [1e-3, 0.0] {
                let mut scene = scene.clone();
                scene.plane.tolerance = tolerance;
                let by =
                    format!("{quantity:?}, {tolerance}, {evaluator:?}").chars().take(60).collect::<String>();
                let evaluator = match &evaluator {
                    Evaluator::Reference => Evaluator::Reference,
                    Evaluator::Cpu => Evaluator::Cpu,
                    Evaluator::Gpu(gpu) => Evaluator::Gpu(Box::new(gpu.twin())),
                };
                let made = map(&scene, std::slice::from_ref(drive), quantity, (40, 30), evaluator);
                assert!((made.peak, made.error) == (0.0, 0.0) && made.rounding > 0.0, "{by}: {}", made.peak);
                let most = f64::from(largest(&made.values, std::iter::repeat(true)));
                assert!(quantity == Quantity::Phase || most <= made.rounding, "{by}: {most:e}");
            }
        }
        assert!(is_flat(scene, drive, quantity), "{quantity:?}");
    }
}

#[test]
fn faint_sound_above_rounding_is_no_silence() {
    let scene = facing();
    for strength in [1.0 - 1e-4, 1.0 - 1e-9] {
        let drive = opposed(&scene, strength);
        let made = map(&scene, std::slice::from_ref(&drive), Quantity::Rms, (40, 30), Evaluator::Cpu);
        let mut half = drive;
        half.amplitudes[16..].fill(0.0);
        let whole = map(&scene, &[half], Quantity::Rms, (40, 30), Evaluator::Cpu);
        let expected = f64::from(whole.peak) * (1.0 - strength);
        assert!((f64::from(made.peak) / expected - 1.0).abs() < 0.01, "{strength}: {} {expected}", made.peak);
        assert!(made.by != By::Cpu && made.rounding == 0.0, "{:?}", made.by);
    }
}
