//! Memory of a long-running program: a drag must not allocate more from frame to frame, and a large map keeps none.
//!
//! Each runs in its own process, where no other tests allocate.

use std::fs;
use std::ops::Range;
use std::process::Command;

use glam::DVec2;
use sonoglyph::drive::Drive;
use sonoglyph::field::gpu::adapter;
use sonoglyph::field::{Colouring, Evaluator, Quantity, Request, Stages};
use sonoglyph::scene::{ElementModel, Plane, Scene};

use crate::requirement::found;

/// Frames that fill the caches, and frames that are measured, two of each kind of element in turn.
const FIRST: usize = 20;
const MORE: usize = 60;
/// Bytes allowed to allocators and threads.
const ALLOWED: usize = 16 << 20;
/// Set in a process that runs one test alone.
const ALONE: &str = "SONOGLYPH_ALONE";

/// Resident memory of this process, bytes.
fn resident() -> usize {
    const PAGE: usize = 4096;
    let pages = fs::read_to_string("/proc/self/statm").expect("Linux reports memory in /proc");
    pages
        .split(' ')
        .nth(1)
        .and_then(|pages| pages.parse::<usize>().ok())
        .expect("statm holds a number of pages")
        * PAGE
}

fn frame(stages: &mut Stages, scene: &Scene, number: usize) {
    let count = scene.array.elements();
    let phases = (0..count).map(|n| (n * (number + 3) % 17) as f64 * 0.3 - 2.4).collect();
    let drive = Drive { amplitudes: vec![1.0; count], phases };
    for quantity in [Quantity::Rms, Quantity::Phase] {
        let request = Request::new(scene, vec![drive.clone()], quantity, (160, 120));
        let colouring = Colouring::new(quantity, [[7; 4]; 256]);
        // The window asks for pictures and figures, a file for colours.
        stages.picture(&request, &colouring).expect("the plane can be drawn");
        stages.figures(&request).expect("the plane has figures");
        stages.colours(&request, &colouring).expect("the plane can be drawn");
    }
}

fn drags(evaluator: Evaluator, name: &str) {
    let mut stages = Stages::new(evaluator);
    let scenes = [ElementModel::Piston, ElementModel::ExactPiston].map(|element| {
        let mut scene = Scene::default();
        scene.array.element = element;
        scene
    });
    let mut frames = |numbers: Range<usize>| {
        numbers.for_each(|number| frame(&mut stages, &scenes[number / 2 % 2], number));
        resident()
    };
    let before = frames(0..FIRST);
    let more = frames(FIRST..FIRST + MORE).saturating_sub(before);
    assert!(more < ALLOWED, "{MORE} frames took {} kB on the {name}", more >> 10);
}

/// A depression of metres has millions of cells, and a map of pressure none.
#[test]
fn memory_of_a_large_plane_is_given_back() {
    if std::env::var_os(ALONE).is_none() {
        return repeated_alone("growth::memory_of_a_large_plane_is_given_back", ALONE);
    }
    let mut stages = Stages::new(Evaluator::Cpu);
    let scene = Scene::default();
    let drive = Drive { amplitudes: vec![1.0; 256], phases: vec![0.0; 256] };
    let mut taken = |side: f64, quantity: Quantity| {
        let plane = Plane { size: DVec2::splat(side), ..scene.plane.clone() };
        let request = Request { plane, ..Request::new(&scene, vec![drive.clone()], quantity, (160, 120)) };
        stages.map(&request).expect("the plane has a map");
        resident()
    };
    let before = taken(0.1, Quantity::Rms);
    let large = taken(4.0, Quantity::Depression);
    let after = taken(0.1, Quantity::Rms);
    let more = large - before;
    assert!(more > 8 * ALLOWED, "a large plane takes only {} kB", more >> 10);
    assert!(after < before + 2 * ALLOWED, "{} of {} kB stay", (after - before) >> 10, more >> 10);
}

#[test]
fn a_drag_takes_no_more_memory_from_frame_to_frame() {
    if std::env::var_os(ALONE).is_none() {
        return repeated_alone("growth::a_drag_takes_no_more_memory_from_frame_to_frame", ALONE);
    }
    drags(Evaluator::Cpu, "CPU");
    if let Some(gpu) = found("gpu", adapter::open_best(true)) {
        drags(Evaluator::Gpu(Box::new(gpu)), "GPU");
    }
}

/// Runs a test again in its own process, with the variable `marker` set.
fn repeated_alone(test: &str, marker: &str) {
    let mut command = Command::new(std::env::current_exe().expect("the path of the test binary"));
    let output = command
        .args([test, "--exact", "--nocapture"])
        .env(marker, "1")
        .output()
        .expect("the test binary starts");
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8_lossy(&said);
    assert!(output.status.success() && said.contains("1 passed"), "{said}");
    eprint!("{said}");
}
