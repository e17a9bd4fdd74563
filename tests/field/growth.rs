//! Memory of a program that is open all day: a drag takes no more of it from frame to frame.
//!
//! In a process of its own, since what other tests take would count.

use std::fs;
use std::process::Command;

use sonoglyph::drive::Drive;
use sonoglyph::field::gpu::adapter;
use sonoglyph::field::{Colouring, Evaluator, Quantity, Request, Stages};
use sonoglyph::scene::{ElementModel, Scene};

use crate::requirement::found;

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
    const ALONE: &str = "SONOGLYPH_ALONE";
    if std::env::var_os(ALONE).is_none() {
        return repeated_alone("growth::a_drag_takes_no_more_memory_from_frame_to_frame", ALONE);
    }
    drags(Evaluator::Cpu, "CPU");
    if let Some(gpu) = found("gpu", adapter::open_best(true)) {
        drags(Evaluator::Gpu(Box::new(gpu)), "GPU");
    }
}

/// A test once more, in a process of its own, where `marker` is set.
fn repeated_alone(test: &str, marker: &str) {
    let mut command = Command::new(std::env::current_exe().expect("a test is a program"));
    let output =
        command.args([test, "--exact", "--nocapture"]).env(marker, "1").output().expect("it runs again");
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8_lossy(&said);
    assert!(output.status.success() && said.contains("1 passed"), "{said}");
    eprint!("{said}");
}
