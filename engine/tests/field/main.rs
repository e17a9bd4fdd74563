//! The field: evaluators, plans and quantities against f64 references, volumes, and the caching of stages.

#![expect(clippy::unwrap_used, reason = "a test's helper may panic")]

mod bodies;
mod caustic;
mod depression;
#[path = "../../../tests/dice/mod.rs"]
#[expect(dead_code, reason = "used by other test binaries")]
mod dice;
mod drag;
mod evaluators;
mod force;
mod grazing;
mod growth;
mod harmonic;
mod means;
mod model;
mod peak;
mod plan;
mod quantities;
mod reference;
#[path = "../../../tests/requirement/mod.rs"]
mod requirement;
mod response;
mod scattered;
mod side_lobe;
mod skin;
mod space;
mod spread;
mod stages;
mod surface;
mod texels;
mod time_course;
mod transfer;
mod truth;
mod tunings;
mod volume;

use glam::{DVec2, DVec3, dvec3};
use sonoglyph::drive::Drive;
use sonoglyph::field::gpu::adapter;
use sonoglyph::field::{By, Evaluator, Gpu};
use sonoglyph::scene::{Plane, Scene, Shape, Target};
use sonoglyph::solver;

/// Any adapter will do, also a software one. Without one the test fails where a GPU is required.
fn gpu() -> Option<Gpu> {
    requirement::found("gpu", adapter::open_best(true))
}

/// All evaluators but the reference.
fn fast_evaluators() -> Vec<Evaluator> {
    let mut evaluators = vec![Evaluator::Cpu];
    evaluators.extend(gpu().map(|gpu| Evaluator::Gpu(Box::new(gpu))));
    evaluators
}

fn evaluators() -> Vec<Evaluator> {
    let mut evaluators = fast_evaluators();
    evaluators.push(Evaluator::Reference);
    evaluators
}

/// The maker of a map that its evaluator computes itself.
fn own(evaluator: &Evaluator) -> By {
    match evaluator {
        Evaluator::Reference => By::Reference,
        Evaluator::Cpu => By::Cpu,
        Evaluator::Gpu(_) => By::Gpu,
    }
}

/// Deterministic irregular phases; `step` is far from simple fractions.
fn scattered(elements: usize, step: f64) -> Drive {
    let phase = |n: usize| ((n as f64 * step).fract() - 0.5) * std::f64::consts::TAU;
    Drive { amplitudes: vec![1.0; elements], phases: (0..elements).map(phase).collect() }
}

const STEP: f64 = 0.754_877_666;

/// Three foci, played in turn, above a small plane.
fn three_foci() -> (Scene, Vec<Drive>) {
    let plane = Plane { size: DVec2::new(0.06, 0.05), ..Plane::default() };
    let scene = Scene { plane, ..Scene::default() };
    let drive = |at: DVec3| {
        let targets = vec![Target::new(Shape::Point { at })];
        solver::solve(&Scene { targets, ..scene.clone() }).unwrap().drive
    };
    let drives = [dvec3(0.01, 0.004, 0.1), dvec3(-0.012, 0.0, 0.1), dvec3(0.02, -0.03, 0.11)].map(drive);
    (scene, drives.to_vec())
}
