//! Tests of frames: what they play, and the phases between them.

use std::f64::consts::TAU;
use std::sync::{Arc, Mutex};

use glam::DVec3;

use super::*;
use crate::drive::Drive;
use crate::force::Levitation;
use crate::scene::{Keyframe, Motion, MotionPath, Shape, Target, Trap};

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

/// rad, from -π/2 to π/2: the direction in the plane in which a bead is held most, and the stiffnesses (N/m) along it
/// and across.
fn stiff_axis(scene: &Scene, aperture: &Aperture, drive: &Drive, at: DVec3) -> (f64, [f64; 2]) {
    let levitation = Levitation::new(scene, aperture, std::slice::from_ref(drive));
    let stiffness = levitation.forces(at).symmetric();
    let (a, b, c) = (stiffness.x_axis.x, stiffness.x_axis.y, stiffness.y_axis.y);
    let (middle, half) = ((a + c) / 2.0, f64::hypot((a - c) / 2.0, b));
    (0.5 * f64::atan2(2.0 * b, a - c), [middle + half, middle - half])
}

#[test]
fn a_trap_turns_with_its_angle_and_without_jumps() {
    const FRAMES: u32 = 64;
    let at = DVec3::new(0.0, 0.0, 0.08);
    let mut scene = scene(&[], FRAMES);
    scene.array.strength = 6.0;
    scene.targets = vec![Target::new(Shape::Trap { at, trap: Trap::Twin, charge: 1 })];
    scene.motion.path = MotionPath::Keyframes;
    let keyframe = |time: f64, angle: f64| Keyframe { angle, ..Keyframe::new(time, DVec3::ZERO) };
    scene.motion.keyframes = vec![keyframe(0.0, 0.0), keyframe(0.5, TAU / 2.0)];
    let sequence = follow(&scene).unwrap();
    let aperture = Aperture::new(&scene);
    let mut farthest: f64 = 0.0;
    for (i, frame) in sequence.frames.iter().enumerate() {
        let (axis, [most, least]) = stiff_axis(&scene, &aperture, &frame.drive, at);
        let off = (axis - TAU * i as f64 / f64::from(FRAMES)).rem_euclid(TAU / 2.0);
        farthest = farthest.max(off.min(TAU / 2.0 - off));
        assert!(most > 1.5 * least, "frame {i}: {most} and {least} N/m");
        let levitation = Levitation::new(&scene, &aperture, std::slice::from_ref(&frame.drive));
        let net = levitation.net(at).length() / levitation.load;
        assert!(net < 1e-4 && least > 0.0, "frame {i}: {net} weights, {least} N/m");
    }
    // The rows and columns of the board hold the axis back.
    assert!(farthest < 0.08, "{farthest} rad from the angle");
    assert!(sequence.steps.largest < 1.3, "{:?}", sequence.steps);
}

#[test]
fn a_phase_moves_the_node_of_a_twin_trap() {
    let at = DVec3::new(0.0, 0.0, 0.08);
    let mut scene = scene(&[], 4);
    scene.targets = vec![Target::new(Shape::Trap { at, trap: Trap::Twin, charge: 1 })];
    scene.motion.path = MotionPath::Keyframes;
    let keyframe = |time: f64, phase: f64| Keyframe { phase, ..Keyframe::new(time, DVec3::ZERO) };
    scene.motion.keyframes = vec![keyframe(0.0, 0.0), keyframe(0.5, 1.0)];
    let aperture = Aperture::new(&scene);
    let place = |frame: &Frame| {
        let points: Vec<_> = (-400..=400).map(|i| at + DVec3::X * 1e-5 * f64::from(i)).collect();
        let heard = aperture.pressures(&points, &frame.drive.excitation(&aperture.driven));
        let quietest = (0..heard.len()).min_by(|&a, &b| heard[a].norm().total_cmp(&heard[b].norm()));
        points[quietest.unwrap()].x
    };
    let places: Vec<_> = follow(&scene).unwrap().frames.iter().map(place).collect();
    let [half, whole] = [1, 2].map(|i| (places[i] - places[0]).abs());
    assert!(places[0].abs() < 5e-5 && whole > 1e-3, "{places:?}");
    assert!((whole / half - 2.0).abs() < 0.2, "{places:?}");
    assert!((places[1] - places[3]).abs() < 1e-5, "there and back: {places:?}");
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
