//! A GPU lost during work: later work returns errors and does not panic.

use glam::{DVec2, DVec3};
use sonoglyph::field::gpu::adapter;
use sonoglyph::field::{By, Colouring, Evaluator, FieldError, Gpu, GpuError, Quantity, Request, Stages};
use sonoglyph::picture::ColourMap;
use sonoglyph::scene::{Plane, Scene, Shape, Target};
use sonoglyph::solver;

pub fn gpu() -> Option<Gpu> {
    crate::requirement::found("gpu", adapter::open_best(true))
}

/// Requests of every kind, with one focus over water.
fn requests() -> Vec<Request> {
    let target = Target::new(Shape::Point { at: DVec3::new(0.01, 0.0, 0.1) });
    let plane = Plane { size: DVec2::splat(0.06), ..Plane::default() };
    let scene = Scene { targets: vec![target], plane, ..Scene::default() };
    let drives = vec![solver::solve(&scene).unwrap().drive];
    let on_gpu =
        [Quantity::Rms, Quantity::Phase, Quantity::Instantaneous, Quantity::Intensity, Quantity::Velocity];
    on_gpu.map(|quantity| Request::new(&scene, drives.clone(), quantity, (128, 96))).to_vec()
}

fn is_lost<T>(done: &Result<T, FieldError>) -> bool {
    matches!(done, Err(FieldError::Gpu(GpuError::Lost(_))))
}

#[test]
fn all_work_on_a_lost_gpu_is_an_error() {
    let grey = |request: &Request| Colouring::new(request.quantity, ColourMap::Grey.table());
    // With warm and with cold caches, since GPU programs are compiled when first needed.
    for is_warm in [true, false] {
        for request in requests() {
            let name = format!("{:?}, warm: {is_warm}", request.quantity);
            let Some(gpu) = gpu() else { return };
            let mut stages = Stages::new(Evaluator::Gpu(Box::new(gpu)));
            if is_warm {
                stages.picture(&request, &grey(&request)).unwrap();
                stages.figures(&request).unwrap();
                stages.colours(&request, &grey(&request)).unwrap();
                assert_eq!(stages.map(&request).unwrap().by, By::Gpu, "{name}");
            }
            stages.gpu().unwrap().lose();
            if is_warm {
                // Results that have been read back remain available, others are lost.
                assert!(stages.map(&request).is_ok(), "{name}");
                assert!(stages.contours(&request, 0.5).is_ok(), "{name}");
                let other = Colouring { full: Some(7.0), ..grey(&request) };
                assert!(stages.colours(&request, &other).is_ok(), "{name}");
                assert!(is_lost(&stages.picture(&request, &other).map(drop)), "{name}");
            }
            stages.forget();
            assert!(is_lost(&stages.poll(&request).map(drop)), "{name}");
            assert!(is_lost(&stages.map(&request).map(drop)), "{name}");
            assert!(is_lost(&stages.colours(&request, &grey(&request)).map(drop)), "{name}");
            assert!(is_lost(&stages.contours(&request, 0.5).map(drop)), "{name}");
            assert!(is_lost(&stages.picture(&request, &grey(&request)).map(drop)), "{name}");
            assert!(is_lost(&stages.figures(&request).map(drop)), "{name}");
            assert!(is_lost(&stages.pressed(&request).map(drop)), "{name}");
            // The loss is permanent.
            assert!(is_lost(&stages.map(&request).map(drop)), "{name}");
        }
    }
}
