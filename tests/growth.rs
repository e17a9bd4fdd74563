//! Memory of a program that is open all day: a drag takes no more of it from frame to frame.
//!
//! Alone in its program, since what other tests take would count.

#[path = "requirement/mod.rs"]
mod requirement;

use std::fs;

use sonoglyph::drive::Drive;
use sonoglyph::field::gpu::adapter;
use sonoglyph::field::{Colouring, Evaluator, Quantity, Request, Stages};
use sonoglyph::scene::{ElementModel, Scene};

/// Frames until everything has been made that is kept, and frames after them.
const FIRST: usize = 20;
const MORE: usize = 100;
/// Bytes that may come all the same: of allocators and threads, and none of frames.
const ALLOWED: usize = 16 << 20;

/// Bytes of this program in memory.
fn resident() -> usize {
    const PAGE: usize = 4096;
    let pages = fs::read_to_string("/proc/self/statm").expect("Linux says what a program takes");
    pages.split(' ').nth(1).and_then(|pages| pages.parse::<usize>().ok()).expect("a number of pages") * PAGE
}

fn frame(stages: &mut Stages, scene: &Scene, number: usize) {
    let count = scene.array.elements();
    let phases = (0..count).map(|n| (n * (number + 3) % 17) as f64 * 0.3 - 2.4).collect();
    let drive = Drive { amplitudes: vec![1.0; count], phases };
    for quantity in [Quantity::Rms, Quantity::Phase] {
        let request = Request::new(scene, vec![drive.clone()], quantity, (160, 120));
        let colouring = Colouring::new(quantity, [[7; 4]; 256]);
        // As a window asks, and as a file does.
        stages.picture(&request, &colouring).expect("a plane is drawn");
        stages.figures(&request).expect("a drawn plane has figures");
        stages.colours(&request, &colouring).expect("a plane is drawn");
    }
}

fn drags(evaluator: Evaluator, name: &str) {
    let mut stages = Stages::new(evaluator);
    for element in [ElementModel::Piston, ElementModel::ExactPiston] {
        let mut scene = Scene::default();
        scene.array.element = element;
        (0..FIRST).for_each(|number| frame(&mut stages, &scene, number));
        let before = resident();
        (FIRST..FIRST + MORE).for_each(|number| frame(&mut stages, &scene, number));
        let more = resident().saturating_sub(before);
        assert!(more < ALLOWED, "{MORE} frames took {} kB on the {name}", more >> 10);
    }
}

#[test]
fn a_drag_takes_no_more_memory_from_frame_to_frame() {
    drags(Evaluator::Cpu, "CPU");
    if let Some(gpu) = requirement::found("gpu", adapter::open_best(true)) {
        drags(Evaluator::Gpu(Box::new(gpu)), "GPU");
    }
}
