//! What changes nothing makes nothing run, and several drives are one product.

#![expect(clippy::unwrap_used, reason = "a test's helper may panic")]

mod requirement;

use glam::{DVec2, DVec3};
use num_complex::{Complex32, Complex64};
use sonoglyph::acoustics::Aperture;
use sonoglyph::drive::Drive;
use sonoglyph::field::gpu::adapter;
use sonoglyph::field::plan::Costs;
use sonoglyph::field::transfer::{Layout, Transfer};
use sonoglyph::field::{Colouring, Evaluator, Plan, Quantity, Stages, Wanted, Wave, Work, reference};
use sonoglyph::picture::ColourMap;
use sonoglyph::scene::{Plane, Scene};

fn evaluators() -> Vec<Evaluator> {
    let mut evaluators = vec![Evaluator::Cpu];
    let gpu = requirement::found("gpu", adapter::open_best(true));
    evaluators.extend(gpu.map(|gpu| Evaluator::Gpu(Box::new(gpu))));
    evaluators
}

fn scattered(elements: usize, step: f64) -> Drive {
    let phase = |n: usize| ((n as f64 * step).fract() - 0.5) * std::f64::consts::TAU;
    Drive { amplitudes: vec![1.0; elements], phases: (0..elements).map(phase).collect() }
}

/// A scene, and how it is looked at.
#[derive(Clone)]
struct Shown {
    scene: Scene,
    drive: Drive,
    size: (usize, usize),
    colours: ColourMap,
    full: Option<f32>,
}

impl Shown {
    /// The work that showing it takes.
    fn show(&self, stages: &mut Stages) -> Work {
        let before = stages.work();
        let aperture = Aperture::new(&self.scene);
        let wanted = Wanted {
            aperture: &aperture,
            plane: &self.scene.plane,
            drive: &self.drive,
            width: self.size.0,
            height: self.size.1,
        };
        let colouring = Colouring { full: self.full, ..Colouring::new(Quantity::Rms, self.colours.table()) };
        assert_eq!(stages.colours(&wanted, &colouring).unwrap().len(), self.size.0 * self.size.1);
        stages.work().since(before)
    }
}

#[test]
fn only_what_depends_on_the_change_runs() {
    const EVERYTHING: Work = Work {
        plan: 1,
        transfer: 1,
        superposition: 1,
        interpolation: 1,
        squares: 0,
        dent: 0,
        picture: 1,
        contours: 0,
    };
    const NEW_DRIVE: Work = Work { plan: 0, transfer: 0, ..EVERYTHING };
    const NEW_SIZE: Work = Work { superposition: 0, ..NEW_DRIVE };
    const NEW_COLOURS: Work = Work { interpolation: 0, ..NEW_SIZE };
    type Change = fn(&mut Shown);
    let changes: &[(&str, Change, Work)] = &[
        ("nothing", |_| (), Work::default()),
        ("colour map", |s| s.colours = ColourMap::Grey, NEW_COLOURS),
        ("range", |s| s.full = Some(1000.0), NEW_COLOURS),
        ("size", |s| s.size = (333, 222), NEW_SIZE),
        ("phase", |s| s.drive.phases[3] += 0.1, NEW_DRIVE),
        ("amplitude", |s| s.drive.amplitudes[255] = 0.5, NEW_DRIVE),
        ("a silent element", |s| s.drive.amplitudes[7] = 0.0, NEW_DRIVE),
        ("an element off", |s| s.scene.array.off = vec![9], NEW_DRIVE),
        ("targets", |s| s.scene.targets.clear(), Work::default()),
        ("liquid", |s| s.scene.liquid.density = Some(790.0), Work::default()),
        ("plane", |s| s.scene.plane.centre.z = 0.11, EVERYTHING),
        ("tolerance", |s| s.scene.plane.tolerance = 1e-4, EVERYTHING),
        ("medium", |s| s.scene.medium.temperature = 30.0, EVERYTHING),
        ("array", |s| s.scene.array.pitch = 0.0101, EVERYTHING),
    ];
    for evaluator in evaluators() {
        // The GPU keeps no table.
        let tables = u64::from(matches!(evaluator, Evaluator::Cpu));
        let mut stages = Stages::new(evaluator);
        let mut shown = Shown {
            scene: Scene::default(),
            drive: scattered(256, 0.754_877_666),
            size: (300, 200),
            colours: ColourMap::Inferno,
            full: None,
        };
        assert_eq!(shown.show(&mut stages), Work { transfer: tables, ..EVERYTHING });
        for (name, change, expected) in changes {
            change(&mut shown);
            let expected = Work { transfer: tables * expected.transfer, ..*expected };
            assert_eq!(shown.show(&mut stages), expected, "{name}");
            assert_eq!(shown.show(&mut stages), Work::default(), "after {name}");
        }
        // Without samples there is no table and nothing to interpolate.
        shown.scene.plane.tolerance = 0.0;
        assert_eq!(shown.show(&mut stages), Work { transfer: 0, interpolation: 0, ..EVERYTHING }, "exact");
    }
}

#[test]
fn a_table_of_any_layout_gives_the_field_of_every_drive() {
    let d = DVec3::new;
    let plane = Plane { size: DVec2::new(0.15, 0.1), ..Plane::default() };
    let planes = [
        ("parallel", plane.clone(), 2),
        ("backwards", Plane { x_axis: -DVec3::X, ..plane.clone() }, 2),
        ("crossed", Plane { x_axis: DVec3::Y, y_axis: DVec3::X, ..plane.clone() }, 2),
        ("vertical", Plane { y_axis: DVec3::Z, ..plane.clone() }, 1),
        ("standing", Plane { x_axis: DVec3::Z, y_axis: -DVec3::Y, ..plane.clone() }, 1),
        ("turned", Plane { x_axis: d(1.0, 0.2, 0.0), ..plane.clone() }, 0),
    ];
    let mut scene = Scene::default();
    (scene.array.rows, scene.array.columns) = (5, 7);
    let aperture = Aperture::new(&scene);
    // Four that are added up together, and one alone.
    let mut drives = [0.754_877_666, 0.569_840_29, 0.618_033_988, 0.819_172_513, 0.671_043_607]
        .map(|step| scattered(35, step));
    drives[1].amplitudes[4] = 0.0;
    for (name, plane, shared) in planes {
        let plan = Plan::new(&aperture, &plane, Costs::CPU).unwrap();
        let grid = plan.grid.unwrap();
        // Both without and with sharing, whichever of them the plan preferred.
        let layout = Layout::new(&aperture, &grid);
        let wave = Wave::new(&aperture, &grid.samples).unwrap();
        assert!(grid.shared.iter().flatten().count() <= shared, "{name}");
        let transfer = Transfer::new(&aperture, &wave, layout, None);
        let excitation = |drive: &Drive| drive.excitation(&aperture.driven);
        let excitations: Vec<_> = drives.iter().map(excitation).collect();
        let terms = transfer.layout.terms(&aperture, [&excitations[1][..]]);
        assert_eq!(terms.len(), 34, "silent elements are left out");
        let fields = transfer.superpose(&aperture, &excitations, grid.samples.len());
        for (drive, field) in drives.iter().zip(&fields) {
            let expected = reference::pressure(&aperture, drive, &grid.samples);
            let peak = expected.iter().map(|p| p.norm()).fold(0.0, f64::max);
            assert_eq!(field.len(), expected.len());
            for (p, expected) in field.iter().zip(&expected) {
                let wide = |p: &Complex32| Complex64::new(p.re.into(), p.im.into());
                assert!((wide(p) - expected).norm() < 3e-6 * peak, "{name}: {p} is not {expected}");
            }
        }
    }
}
