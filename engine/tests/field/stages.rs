//! Caching of stages: a change runs only the stages that depend on it, for every quantity.

use std::f64::consts::SQRT_2;
use std::sync::{Arc, Mutex};

use glam::{DVec3, dvec2, dvec3};
use sonoglyph::acoustics::Aperture;
use sonoglyph::drive::Drive;
use sonoglyph::field::sound::NORMAL;
use sonoglyph::field::{Colouring, Evaluator, Quantity, Request, Samples, Stages, Work, reference};
use sonoglyph::gauge::Gauge;
use sonoglyph::picture::ColourMap;
use sonoglyph::scene::{Array, Light, Plane, Scene};

use crate::{STEP, fast_evaluators, gpu, scattered, three_foci};

/// All inputs of a map and its picture.
#[derive(Clone)]
struct Shown {
    scene: Scene,
    drives: Vec<Drive>,
    quantity: Quantity,
    moment: f64,
    part: f64,
    size: (usize, usize),
    colours: ColourMap,
    full: Option<f32>,
}

impl Shown {
    fn new(quantity: Quantity) -> Self {
        Self {
            scene: three_foci().0,
            drives: vec![scattered(256, STEP)],
            quantity,
            moment: 0.3,
            part: 1.0,
            size: (130, 90),
            colours: ColourMap::Inferno,
            full: None,
        }
    }

    /// The work of showing it, without the GPU's memory.
    fn show(&self, stages: &mut Stages) -> Work {
        let before = stages.work();
        let request = Request {
            moment: self.moment,
            part: self.part,
            ..Request::new(&self.scene, self.drives.clone(), self.quantity, self.size)
        };
        let colouring = Colouring { full: self.full, ..Colouring::new(self.quantity, self.colours.table()) };
        assert_eq!(stages.colours(&request, &colouring).unwrap().len(), self.size.0 * self.size.1);
        Work { read_back: 0, allocations: 0, ..stages.work().since(before) }
    }
}

/// The first stage that depends on a change; the later ones run too.
#[derive(Clone, Copy, Debug, PartialEq)]
enum First {
    Plan,
    Superposition,
    /// The number of pixels.
    Pixels,
    /// ωt.
    Moment,
    /// The envelope's factor.
    Part,
    Liquid,
    /// The capillary length, and with it the distance of the walls.
    Margin,
    /// The refracted light.
    Light,
    Picture,
    Nothing,
}

/// Whether a quantity is formed at cells.
fn by_cells(quantity: Quantity) -> bool {
    match quantity {
        Quantity::Radiation
        | Quantity::Depression
        | Quantity::Caustic
        | Quantity::Gorkov
        | Quantity::Force
        | Quantity::Skin
        | Quantity::Felt
        | Quantity::Speed => true,
        // Of neither: `harmonic` tests its work.
        Quantity::Harmonic => false,
        Quantity::Rms
        | Quantity::Phase
        | Quantity::Instantaneous
        | Quantity::Intensity
        | Quantity::Velocity => false,
    }
}

fn expected(quantity: Quantity, on_gpu: bool, first: First) -> Work {
    let of_light = quantity == Quantity::Caustic;
    let (by_cells, of_liquid) = (by_cells(quantity), quantity == Quantity::Depression || of_light);
    let on_gpu = on_gpu && !by_cells;
    // Pressure and normal slope are separate sums; a GPU counts both as one and has no tables for them.
    let parts = quantity.declaration().parts;
    let is_solid = parts & NORMAL != 0 && parts != NORMAL;
    // Potentials and forces are summed separately, in f64.
    let sums = match () {
        () if quantity.declaration().of_bead => 0,
        () if is_solid && !on_gpu => 2,
        () => 1,
    };
    let picture = Work { picture: 1, ..Work::default() };
    let caustic = u64::from(of_light);
    let resized = Work { interpolation: 1, forming: u64::from(!by_cells), caustic, ..picture };
    let of_drive = Work { superposition: sums, forming: 1, response: u64::from(of_liquid), ..resized };
    match first {
        First::Plan => Work { plan: 1, transfer: if on_gpu { 0 } else { sums }, ..of_drive },
        First::Superposition => of_drive,
        // A GPU's passes depend on the pixels.
        First::Pixels if on_gpu => of_drive,
        First::Pixels => resized,
        First::Moment if quantity == Quantity::Instantaneous => Work { forming: 1, ..picture },
        First::Liquid if of_liquid => Work { response: 1, ..resized },
        First::Margin if of_liquid => expected(quantity, on_gpu, First::Plan),
        First::Part if by_cells => resized,
        First::Light if of_light => resized,
        First::Part => Work { forming: 1, ..picture },
        First::Picture => picture,
        First::Moment | First::Liquid | First::Margin | First::Light | First::Nothing => Work::default(),
    }
}

#[test]
fn only_stages_that_depend_on_the_change_run() {
    type Change = fn(&mut Shown);
    let changes: &[(&str, Change, First)] = &[
        ("nothing", |_| (), First::Nothing),
        ("colour map", |s| s.colours = ColourMap::Grey, First::Picture),
        ("range", |s| s.full = Some(1000.0), First::Picture),
        ("size", |s| s.size = (133, 122), First::Pixels),
        ("moment", |s| s.moment = 1.1, First::Moment),
        ("envelope", |s| s.part = 0.5, First::Part),
        ("targets", |s| s.scene.targets.clear(), First::Nothing),
        ("density", |s| s.scene.liquid.density = Some(790.0), First::Margin),
        ("viscosity", |s| s.scene.liquid.viscosity = Some(1.0), First::Liquid),
        ("refractive index", |s| s.scene.liquid.refractive_index = Some(1.5), First::Light),
        ("screen", |s| s.scene.liquid.screen = 0.1, First::Light),
        ("direction of light", |s| s.scene.liquid.light = Light::Reflected, First::Light),
        ("phase", |s| s.drives[0].phases[3] += 0.1, First::Superposition),
        ("amplitude", |s| s.drives[0].amplitudes[255] = 0.5, First::Superposition),
        ("a silent element", |s| s.drives[0].amplitudes[7] = 0.0, First::Superposition),
        ("an element off", |s| s.scene.array.off = vec![9], First::Superposition),
        ("plane", |s| s.scene.plane.centre.z = 0.11, First::Plan),
        ("tolerance", |s| s.scene.plane.tolerance = 2e-3, First::Plan),
        ("medium", |s| s.scene.medium.temperature = 30.0, First::Plan),
        ("array", |s| s.scene.array.pitch = 0.0101, First::Plan),
    ];
    for evaluator in fast_evaluators() {
        let on_gpu = matches!(evaluator, Evaluator::Gpu(_));
        let mut stages = Stages::new(evaluator);
        for quantity in Quantity::ALL.into_iter().filter(|quantity| !quantity.declaration().of_volume) {
            let mut shown = Shown::new(quantity);
            stages.forget();
            assert_eq!(
                shown.show(&mut stages),
                expected(quantity, on_gpu, First::Plan),
                "{quantity:?} at first"
            );
            for (name, change, first) in changes {
                change(&mut shown);
                let expected = expected(quantity, on_gpu, *first);
                assert_eq!(shown.show(&mut stages), expected, "{quantity:?}: {name}, on the GPU: {on_gpu}");
                assert_eq!(shown.show(&mut stages), Work::default(), "{quantity:?}: after {name}");
            }
        }
    }
}

#[test]
fn quantities_share_one_superposition() {
    let drives = three_foci().1;
    let mut stages = Stages::new(Evaluator::Cpu);
    for (drives, first, second, kept) in [
        // Both are formed at the pixels from the pressure.
        (&drives[..1], Quantity::Rms, Quantity::Phase, Work { forming: 1, picture: 1, ..Work::default() }),
        (
            &drives[..1],
            Quantity::Phase,
            Quantity::Instantaneous,
            Work { forming: 1, picture: 1, ..Work::default() },
        ),
        // A phase is that of the first drive only.
        (
            &drives[..],
            Quantity::Phase,
            Quantity::Instantaneous,
            Work { forming: 1, picture: 1, ..Work::default() },
        ),
        // The cells of a depression have another margin.
        (
            &drives[..],
            Quantity::Depression,
            Quantity::Rms,
            Work { forming: 3, ..expected(Quantity::Radiation, false, First::Plan) },
        ),
    ] {
        let mut shown = Shown { drives: drives.to_vec(), ..Shown::new(first) };
        stages.forget();
        shown.show(&mut stages);
        shown.quantity = second;
        let work = shown.show(&mut stages);
        assert_eq!(work, kept, "{second:?} after {first:?}");
        assert_eq!(shown.show(&mut stages), Work::default());
    }
}

#[test]
fn quantities_in_turn_have_the_maps_that_they_have_alone() {
    // Few pixels next to the array: the samples of a quantity at cells and of one at pixels differ.
    let array = Array { rows: 2, columns: 5, pitch: 0.0086, frequency: 50_800.0, ..Array::default() };
    let plane = Plane {
        centre: dvec3(-0.0127, -0.0021, 0.0298),
        size: dvec2(0.0038, 0.0337),
        tolerance: 3e-3,
        ..Plane::default()
    };
    let scene = Scene { array, plane, ..Scene::default() };
    let request = |quantity| Request::new(&scene, vec![scattered(10, STEP)], quantity, (24, 96));
    let map = |stages: &mut Stages, quantity| stages.map(&request(quantity)).unwrap().clone();
    for evaluator in fast_evaluators() {
        let mut stages = Stages::new(evaluator);
        let alone = Quantity::ALL.map(|quantity| {
            stages.forget();
            map(&mut stages, quantity)
        });
        for first in Quantity::ALL {
            for (second, alone) in Quantity::ALL.into_iter().zip(&alone) {
                map(&mut stages, first);
                assert!(map(&mut stages, second) == *alone, "{second:?} after {first:?}");
            }
        }
    }
}

#[test]
fn a_map_of_more_pixels_than_are_kept_at_once_keeps_its_tolerance() {
    let (scene, drives) = three_foci();
    let size = (2200, 2000);
    // The rows next to the array are evaluated pixel by pixel, the others interpolated from samples.
    let upright = Plane {
        y_axis: DVec3::Z,
        centre: dvec3(0.0, 0.002, 0.05),
        size: dvec2(0.08, 0.1),
        ..scene.plane.clone()
    };
    for plane in [scene.plane.clone(), upright] {
        let scene = Scene { plane, ..scene.clone() };
        let request = Request::new(&scene, drives[..1].to_vec(), Quantity::Rms, size);
        let map = Stages::new(Evaluator::Cpu).map(&request).unwrap().clone();
        let pixels = Samples::on_plane(&scene.plane, size.0, size.1).unwrap();
        let chosen: Vec<_> = (0..pixels.len()).rev().step_by(9_973).collect();
        let places = Samples::at(chosen.iter().map(|&pixel| pixels.point(pixel)).collect());
        let exact = reference::pressure(&Aperture::new(&scene), &drives[0], &places);
        for (pixel, p) in chosen.into_iter().zip(exact) {
            let off = (f64::from(map.values[pixel]) - p.norm() / SQRT_2).abs() / f64::from(map.peak);
            assert!(off < scene.plane.tolerance, "pixel {pixel}: {off:e}, {}", map.how);
        }
    }
}

/// A few elements, and a plane at a height (m).
fn small(height: f64) -> Scene {
    let plane = Plane { centre: dvec3(0.001, 0.0, height), size: dvec2(0.03, 0.02), ..Plane::default() };
    let mut scene = Scene { plane, ..Scene::default() };
    (scene.array.rows, scene.array.columns) = (4, 4);
    scene
}

#[test]
fn everything_is_computed_again_after_forgetting() {
    let mut stages = Stages::new(Evaluator::Cpu);
    for quantity in Quantity::ALL {
        let shown = Shown { scene: small(0.1), drives: vec![scattered(16, STEP)], ..Shown::new(quantity) };
        stages.forget();
        let first = shown.show(&mut stages);
        assert_eq!(shown.show(&mut stages), Work::default(), "{quantity:?}");
        stages.forget();
        assert_eq!(shown.show(&mut stages), first, "{quantity:?}");
    }
}

#[test]
fn means_at_pixels_next_to_the_array_are_those_of_all_drives() {
    // Too near for cells.
    let scene = small(0.004);
    let (aperture, size) = (Aperture::new(&scene), (24, 20));
    let pixels = Samples::on_plane(&scene.plane, size.0, size.1).unwrap();
    let mut stages = Stages::new(Evaluator::Cpu);
    // What is left of the louder map must not show in the fainter one.
    for (first, amplitude) in [(0, 1.0), (3, 0.01)] {
        let drive =
            |i: i32| Drive { amplitudes: vec![amplitude; 16], ..scattered(16, STEP + 0.1 * f64::from(i)) };
        let drives: Vec<_> = (first..first + 3).map(drive).collect();
        let request = Request::new(&scene, drives.clone(), Quantity::Rms, size);
        let map = stages.map(&request).unwrap();
        assert!(map.how.contains("every pixel"), "{}", map.how);
        let squares = drives.iter().map(|drive| reference::pressure(&aperture, drive, &pixels));
        let squares: Vec<_> = squares.collect();
        for (pixel, value) in map.values.iter().enumerate() {
            let mean = squares.iter().map(|field| field[pixel].norm_sqr()).sum::<f64>() / 3.0;
            let off = (f64::from(*value) - (0.5 * mean).sqrt()).abs();
            assert!(off < scene.plane.tolerance * f64::from(map.peak), "pixel {pixel} of {first}");
        }
    }
}

#[test]
fn progress_is_told_drive_by_drive() {
    let drives: Vec<_> = (0..3).map(|i| scattered(16, STEP + 0.1 * f64::from(i))).collect();
    let request = Request::new(&small(0.004), drives, Quantity::Rms, (12, 10));
    let heard = Arc::new(Mutex::new(Vec::new()));
    let into = Arc::clone(&heard);
    let mut stages = Stages::new(Evaluator::Cpu);
    stages.show_progress(Gauge::new(move |part| into.lock().unwrap().push(part)));
    stages.map(&request).unwrap();
    let heard = heard.lock().unwrap();
    assert!(heard.is_sorted() && heard.last() == Some(&1.0), "{heard:?}");
    for part in [1.0 / 3.0, 2.0 / 3.0] {
        assert!(heard.iter().any(|heard| (heard - part).abs() < 1e-12), "{part} of {heard:?}");
    }
}

#[test]
fn a_gpu_declines_the_map_of_several_drives_and_no_other() {
    let Some(gpu) = gpu() else { return };
    let mut stages = Stages::new(Evaluator::Gpu(Box::new(gpu)));
    let scene = small(0.1);
    let request =
        |count: usize| Request::new(&scene, vec![scattered(16, STEP); count], Quantity::Rms, (20, 10));
    assert!(!stages.has_declined(&request(2)));
    let colouring = Colouring::new(Quantity::Rms, ColourMap::Grey.table());
    stages.picture(&request(2), &colouring).unwrap();
    assert!(stages.has_declined(&request(2)) && !stages.has_declined(&request(1)));
}
