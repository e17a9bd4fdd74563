//! A GPU that goes away in the middle of things: what comes next says so once, and nothing panics.

use glam::{DVec2, DVec3};
use sonoglyph::acoustics::{Air, Aperture};
use sonoglyph::drive::Drive;
use sonoglyph::field::gpu::adapter;
use sonoglyph::field::{
    Average, Colouring, Evaluator, FieldError, Gpu, GpuError, Mean, Quantity, Stages, Wanted,
};
use sonoglyph::picture::ColourMap;
use sonoglyph::scene::{Plane, Scene, Shape, Target};
use sonoglyph::solver;
use sonoglyph::surface::Reflector;

pub fn gpu() -> Option<Gpu> {
    crate::requirement::found("gpu", adapter::open_best(true))
}

/// A focus over water, with its drive.
fn scene() -> (Scene, Vec<Drive>) {
    let target = Target::new(Shape::Point { at: DVec3::new(0.01, 0.0, 0.1) });
    let plane = Plane { size: DVec2::splat(0.06), ..Plane::default() };
    let scene = Scene { targets: vec![target], plane, ..Scene::default() };
    let drives = vec![solver::solve(&scene).unwrap().drive];
    (scene, drives)
}

fn is_lost<T>(done: &Result<T, FieldError>) -> bool {
    matches!(done, Err(FieldError::Gpu(GpuError::Lost(_))))
}

#[test]
fn every_kind_of_work_on_a_lost_gpu_is_an_error_and_no_panic() {
    let (scene, drives) = scene();
    let aperture = Aperture::new(&scene);
    let reflector = Reflector::new(&Air::new(&scene.medium, scene.array.frequency), scene.array.frequency);
    let wanted =
        Wanted { aperture: &aperture, plane: &scene.plane, drive: &drives[0], width: 64, height: 48 };
    let means = [Mean::Square, Mean::Radiation(reflector), Mean::Dent(reflector, scene.liquid.clone())];
    let averages = means.map(|mean| {
        let (plane, drives, aperture) = (&scene.plane, &drives[..], &aperture);
        Average { aperture, plane, drives, mean, part: 1.0, width: 64, height: 48 }
    });
    let colouring = |quantity| Colouring::new(quantity, ColourMap::Grey.table());
    // With everything made before, and with nothing: programs are made when they are first needed.
    for is_warm in [true, false] {
        let Some(gpu) = gpu() else { return };
        let mut stages = Stages::new(Evaluator::Gpu(Box::new(gpu)));
        if is_warm {
            stages.colours(&wanted, &colouring(Quantity::Rms)).unwrap();
            for average in &averages {
                stages.average_colours(average, &colouring(average.mean.quantity())).unwrap();
            }
        }
        stages.gpu().unwrap().lose();
        if is_warm {
            // What has left the GPU is still there; what has not is gone.
            assert!(stages.map(&wanted).is_ok());
            assert!(is_lost(&stages.read(&wanted)));
            assert!(is_lost(&stages.colours(&wanted, &colouring(Quantity::Phase)).map(drop)));
            assert!(is_lost(&stages.contours(&wanted, Quantity::Rms, 0.5).map(drop)));
        }
        stages.forget();
        assert!(is_lost(&stages.map(&wanted).map(drop)), "warm: {is_warm}");
        for average in &averages {
            assert!(is_lost(&stages.average(average).map(drop)), "{:?}, warm: {is_warm}", average.mean);
            assert!(is_lost(&stages.average_colours(average, &colouring(Quantity::Dent)).map(drop)));
        }
        // It stays lost.
        assert!(is_lost(&stages.map(&wanted).map(drop)));
    }
}
