//! Tests of frames: what they play, and the phases between them.

use std::f64::consts::TAU;
use std::sync::{Arc, Mutex};

use glam::DVec3;

use super::*;
use crate::scene::{Motion, MotionPath, Shape, Target};

fn scene(points: &[DVec3], frames: u32) -> Scene {
    let target = |&at: &DVec3| Target::new(Shape::Point { at });
    Scene {
        targets: points.iter().map(target).collect(),
        motion: Motion { path: MotionPath::Circle, frames, ..Motion::default() },
        ..Scene::default()
    }
}

fn ring(count: usize) -> Vec<DVec3> {
    let at = |i: usize| {
        let (sin, cos) = (TAU * i as f64 / count as f64).sin_cos();
        DVec3::new(0.02 * cos, 0.02 * sin, 0.1)
    };
    (0..count).map(at).collect()
}

#[test]
fn any_number_of_threads_finds_the_same_drives() {
    let scene = scene(&ring(5), 300);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| follow(&scene).unwrap())
    };
    let (one, four) = (with(1), with(4));
    assert_eq!(one.frames, four.frames);
    assert_eq!(one.steps, four.steps);
}

#[test]
fn slow_foci_move_phases_by_little_even_where_the_round_closes() {
    for method in [Method::Focus, Method::Best, Method::Weighted] {
        let mut scene = scene(&[DVec3::new(0.01, 0.0, 0.1)], 512);
        scene.solver.method = method;
        let steps = follow(&scene).unwrap().steps;
        let step = scene.motion.length() / 512.0;
        let farthest = Aperture::new(&scene).element.wavenumber * step;
        assert!(steps.largest < farthest, "{method:?}: {steps:?}, more than the way in wavelengths");
        assert!(steps.rms > 0.2 * farthest, "{method:?}: {steps:?}");
    }
}

#[test]
fn frames_are_what_their_drives_play() {
    let mut scene = scene(&ring(3), 24);
    scene.array.off = vec![0, 100];
    for method in [Method::Best, Method::Weighted, Method::Naive] {
        scene.solver.method = method;
        let aperture = Aperture::new(&scene);
        for frame in follow(&scene).unwrap().frames {
            let problem = Problem::new(&aperture, frame.foci.clone());
            let played = problem.transfer.pressure(&frame.drive.excitation(&aperture.driven));
            let largest = frame.pressures.iter().map(|p| p.norm()).fold(0.0, f64::max);
            for (played, said) in played.iter().zip(&frame.pressures) {
                assert!((played - said).norm() < 1e-9 * largest, "{method:?}: {played} and {said}");
            }
            assert_eq!(frame.drive.amplitudes[100], 0.0);
        }
    }
}

#[test]
fn keyframes_are_as_few_as_the_stride_allows() {
    const STRIDE: f64 = 2.5e-3;
    // Steps of a millimetre, and a jump.
    let places = (0..20).map(|i| DVec3::new(1e-3 * f64::from(i + if i < 11 { 0 } else { 7 }), 0.0, 0.1));
    let frames: Vec<_> = places.map(|position| [Focus::new(position, 1.0)]).collect();
    let frames: Vec<_> = frames.iter().map(|foci| &foci[..]).collect();
    let keys = keyframes(&frames, STRIDE);
    assert_eq!(keys[0], 0);
    for pair in keys.windows(2) {
        let from_key = |frame: usize| farthest(frames[pair[0]], frames[frame]);
        assert!(pair[1] == pair[0] + 1 || from_key(pair[1]) <= STRIDE, "{keys:?}");
        assert!(from_key(pair[1] + 1) > STRIDE, "{keys:?}: the next frame would have done");
    }
    assert!(farthest(frames[keys[keys.len() - 1]], frames[19]) <= STRIDE, "{keys:?}");
}

#[test]
fn steps_are_searched_for_once_and_stand_still() {
    let mut scene = scene(&ring(4), 12);
    scene.motion.path = MotionPath::Steps;
    for (target, step) in scene.targets.iter_mut().zip([0, 1, 2, 2]) {
        target.step = Some(step);
    }
    let sequence = follow(&scene).unwrap();
    for (i, frame) in sequence.frames.iter().enumerate() {
        let first = &sequence.frames[i / 4 * 4];
        assert!(frame.cold && frame == first, "frame {i}");
    }
    assert_eq!(sequence.frames[8].foci.len(), 2);
    assert_eq!(sequence.steps.to % 4, 0, "a step begins where phases jump");
}

#[test]
fn a_focus_that_runs_is_as_loud_along_the_stroke_as_wanted() {
    let vertices = [-0.02, 0.02].map(|x| DVec3::new(x, 0.0, 0.1)).to_vec();
    let mut scene = scene(&[], 16);
    scene.motion.path = MotionPath::Outline;
    scene.targets = vec![Target::new(Shape::Path { vertices, closed: false })];
    let at_full = follow(&scene).unwrap();
    assert!(at_full.frames.iter().all(|frame| frame.drive.amplitudes.iter().all(|&a| a == 1.0)));
    scene.targets[0].pressures = vec![1.0, 0.25];
    let fading = follow(&scene).unwrap();
    for (i, (fading, full)) in fading.frames.iter().zip(&at_full.frames).enumerate() {
        let wanted = 1.0 - 0.75 * i as f64 / 16.0;
        assert!((fading.foci[0].target - wanted).abs() < 1e-12);
        assert!((fading.drive.amplitudes[0] - wanted).abs() < 1e-12, "frame {i}");
        assert!((fading.mean_pressure() / full.mean_pressure() - wanted).abs() < 1e-9, "frame {i}");
    }
}

#[test]
fn a_stroke_that_stands_is_even_while_a_focus_runs_beside_it() {
    let own = |path| Some(Motion { path, ..Motion::default() });
    let line = Shape::Line { from: DVec3::new(-0.02, -0.02, 0.1), to: DVec3::new(0.02, -0.02, 0.1) };
    let ring = Shape::Circle { at: DVec3::new(0.0, 0.02, 0.1), radius: 0.01 };
    let mut scene = scene(&[], 8);
    scene.motion.path = MotionPath::None;
    scene.targets = vec![Target::new(line), Target { motion: own(MotionPath::Outline), ..Target::new(ring) }];
    scene.targets[1].motion.as_mut().unwrap().frames = 8;
    let frames = follow(&scene).unwrap().frames;
    assert_eq!(frames.len(), 8);
    for frame in &frames {
        let strokes: Vec<_> = frame.foci.iter().map(|focus| !focus.is_separate()).collect();
        assert!(strokes.iter().filter(|&&of_stroke| !of_stroke).count() == 1 && strokes.len() > 15);
        let (mean, min) = (frame.mean_pressure(), frame.min_pressure());
        assert!(min > 0.7 * mean, "{min} of {mean} Pa");
    }
}

/// Few of them, so that only the last is told.
#[test]
fn the_gauge_ends_at_the_last_frame_with_every_method() {
    for method in [Method::Best, Method::Wgs] {
        let mut scene = scene(&ring(4), 12);
        scene.solver.method = method;
        let heard = Arc::new(Mutex::new(Vec::new()));
        let into = Arc::clone(&heard);
        follow_with(&scene, &Gauge::new(move |part| into.lock().unwrap().push(part))).unwrap();
        assert_eq!(*heard.lock().unwrap(), [1.0], "{method:?}");
    }
}
