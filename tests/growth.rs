//! Memory of a program that is open all day: a drag takes no more of it from frame to frame.
//!
//! Alone in its program, since what other tests take would count.

#[path = "requirement/mod.rs"]
mod requirement;

use std::fs;

use sonoglyph::acoustics::Aperture;
use sonoglyph::drive::Drive;
use sonoglyph::field::gpu::adapter;
use sonoglyph::field::{Colouring, Evaluator, Quantity, Stages, Wanted};
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

fn frame(stages: &mut Stages, aperture: &Aperture, scene: &Scene, number: usize) {
    let count = aperture.positions.len();
    let phases = (0..count).map(|n| (n * (number + 3) % 17) as f64 * 0.3 - 2.4).collect();
    let drive = Drive { amplitudes: vec![1.0; count], phases };
    let wanted = Wanted { aperture, plane: &scene.plane, drive: &drive, width: 160, height: 120 };
    for quantity in [Quantity::Rms, Quantity::Phase] {
        stages.colours(&wanted, &Colouring::new(quantity, [[7; 4]; 256])).expect("a plane is drawn");
    }
}

fn drags(evaluator: Evaluator, name: &str) {
    let mut stages = Stages::new(evaluator);
    for element in [ElementModel::Piston, ElementModel::ExactPiston] {
        let mut scene = Scene::default();
        scene.array.element = element;
        let aperture = Aperture::new(&scene);
        (0..FIRST).for_each(|number| frame(&mut stages, &aperture, &scene, number));
        let before = resident();
        (FIRST..FIRST + MORE).for_each(|number| frame(&mut stages, &aperture, &scene, number));
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
