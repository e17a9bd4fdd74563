//! The response of elements against published tables of a carrier-rate simulation (T4010A1), and against sums over time.

use glam::DVec3;
use num_complex::Complex64;
use sonoglyph::acoustics::Aperture;
use sonoglyph::acoustics::course::Course;
use sonoglyph::acoustics::response::{Resonator, frames_per_second, responding};
use sonoglyph::drive::Drive;
use sonoglyph::field::{Evaluator, Quantity, Request, Stages};
use sonoglyph::scene::{
    Array, Envelope, Law, Modulation, Motion, MotionPath, Pole, Response, Scene, Shape, Target, Tempo,
    Transducer,
};
use sonoglyph::solver::frames;
use sonoglyph::studio::response::Moving;

use crate::{STEP, scattered};

const PRESET: Response = Response::Preset(Transducer::T4010A1);
const POLE: Response = Response::Pole(Pole { resonance: 39_789.0, tau: 1.882e-4 });

fn with(response: Response) -> Scene {
    Scene { array: Array { response: Some(response), ..Array::default() }, ..Scene::default() }
}

fn resonator(response: Response) -> Resonator {
    Resonator::new(&with(response)).unwrap()
}

#[test]
fn amplitude_modulation_falls_as_tabulated() {
    let table = [
        (100.0, 0.994),
        (200.0, 0.978),
        (300.0, 0.952),
        (500.0, 0.879),
        (700.0, 0.791),
        (891.0, 0.707),
        (1000.0, 0.663),
        (2000.0, 0.394),
        (5000.0, 0.166),
    ];
    for response in [PRESET, POLE] {
        let resonator = resonator(response);
        for (offset, part) in table {
            let found = (resonator.at(offset) + resonator.at(-offset).conj()).norm() / 2.0;
            assert!((found - part).abs() < 0.003, "{response:?}, {offset} Hz: {found}, not {part}");
        }
    }
}

#[test]
fn a_phase_step_dips_as_tabulated() {
    let table = [
        (30.0, 0.924, Some(0.31e-3)),
        (60.0, 0.786, Some(0.44e-3)),
        (90.0, 0.595, Some(0.50e-3)),
        (120.0, 0.364, Some(0.54e-3)),
        (150.0, 0.108, Some(0.56e-3)),
        (180.0, 0.156, Some(0.57e-3)),
    ];
    let motion =
        Motion { path: MotionPath::Circle, tempo: Tempo::Rate(20.0), frames: 2, ..Motion::default() };
    let targets = vec![Target::new(Shape::Point { at: DVec3::Z * 0.1 })];
    let course = Course::new(&Scene { motion, targets, ..with(PRESET) }, 2);
    for (degrees, dip, settled) in table {
        let to = Complex64::from_polar(1.0, f64::to_radians(degrees));
        // The second frame begins after 25 ms.
        let sound = course.pressures(&[Complex64::ONE, to], 50_000, 1e6).split_off(25_000);
        let least = sound.iter().map(|p| p.norm()).fold(f64::INFINITY, f64::min);
        assert!((least - dip).abs() < 0.003, "{degrees}°: {least}, not {dip}");
        let last = sound.iter().rposition(|p| (p - to).norm() > 0.1).unwrap() as f64 * 1e-6;
        assert!((last - settled.unwrap()).abs() < 0.011e-3, "{degrees}°: {last} s");
    }
}

/// A focus on a circle (m) around the axis, 100 mm above the array.
fn circling(size: f64, rate: f64, count: u32, lead: bool) -> Scene {
    let motion = Motion {
        path: MotionPath::Circle,
        size,
        tempo: Tempo::Rate(rate),
        frames: count,
        lead,
        ..Motion::default()
    };
    Scene { motion, targets: vec![Target::new(Shape::Point { at: DVec3::Z * 0.1 })], ..with(PRESET) }
}

/// With the same phase at the focus in all frames, as in the simulation; a solved cycle turns each frame as a whole towards its
/// predecessor.
fn moving(scene: &Scene) -> Moving {
    let mut sequence = frames::follow(scene).unwrap();
    for frame in &mut sequence.frames {
        let turn = frame.pressures[0].arg();
        frame.drive.phases.iter_mut().for_each(|phase| *phase -= turn);
        frame.pressures[0] = frame.pressures[0].norm().into();
    }
    Moving::new(scene, &sequence).unwrap()
}

#[test]
fn a_circling_focus_keeps_what_a_simulation_keeps() {
    // RMS and least of the published simulation, whose samples miss the depth of a dip.
    let table = [
        (0.02, 100.0, 100, 0.933, 0.913),
        (0.02, 200.0, 200, 0.802, 0.785),
        (0.04, 50.0, 200, 0.933, 0.913),
        (0.04, 50.0, 10, 0.929, 0.025),
        (0.02, 50.0, 10, 0.942, 0.218),
        (0.06, 50.0, 200, 0.869, 0.827),
        (0.06, 200.0, 200, 0.440, 0.389),
    ];
    for (size, rate, count, kept, least) in table {
        let found = moving(&circling(size, rate, count, false));
        assert!((found.kept - kept).abs() < 0.003, "{size} m, {rate} Hz: {found:?}");
        let missed = if count == 10 { 0.05 } else { 0.007 };
        assert!((-missed..0.001).contains(&(found.dip - least)), "{size} m, {rate} Hz: {found:?}");
    }
}

#[test]
fn a_lead_wins_half_of_the_loss_back() {
    let [plain, ahead] = [false, true].map(|lead| moving(&circling(0.02, 100.0, 200, lead)).kept);
    assert!((plain - 0.933).abs() < 0.003 && (ahead - 0.966).abs() < 0.003, "{plain}, {ahead}");
}

#[test]
fn moving_foci_lose_as_doppler_offsets_say() {
    let table = [
        (2.0, 0.992),
        (4.0, 0.971),
        (std::f64::consts::TAU, 0.933),
        (8.0, 0.897),
        (10.0, 0.853),
        (12.57, 0.794),
        (16.0, 0.720),
        (20.0, 0.643),
    ];
    // Seen by each element, a moving focus is an offset of the frequency.
    let (resonator, focus) = (resonator(PRESET), DVec3::Z * 0.1);
    let aperture = Aperture::new(&with(PRESET));
    let heard: Vec<_> = aperture.transfer(&[focus]).row(0).map(|h| h.norm()).collect();
    for (speed, kept) in table {
        let offset = |at: &DVec3| speed * (focus - at).normalize_or_zero().x / aperture.wavelength();
        let sum: Complex64 =
            aperture.positions.iter().zip(&heard).map(|(at, h)| h * resonator.at(offset(at))).sum();
        let found = sum.norm() / heard.iter().sum::<f64>();
        assert!((found - kept).abs() < 0.003, "{speed} m/s: {found}, not {kept}");
    }
}

/// The mean of |p|² at a point over a time (s), by small steps of the pole's own equation.
fn by_steps(scene: &Scene, of_frames: &[Complex64], seconds: f64) -> f64 {
    let Resonator { pole, direct } = resonator(scene.array.response.unwrap());
    let (rate, step) = (frames_per_second(scene), 1e-7);
    let drive = |time: f64| {
        of_frames[(time * rate).floor() as usize % of_frames.len()] * scene.modulation.envelope(time)
    };
    let (mut slow, mut sum, settling) = (Complex64::ZERO, 0.0, 5e-3);
    let left = (-pole * step).exp();
    let count = ((settling + seconds) / step) as u64;
    for index in 0..count {
        let time = index as f64 * step;
        let driven = drive(time + step / 2.0);
        let next = driven + (slow - driven) * left;
        if time >= settling {
            sum += (direct * driven + (1.0 - direct) * (slow + next) / 2.0).norm_sqr();
        }
        slow = next;
    }
    sum / (count as f64 - settling / step)
}

#[test]
fn a_map_has_the_mean_square_of_the_response() {
    let shapes =
        [(Envelope::Off, Law::Amplitude), (Envelope::Sine, Law::Amplitude), (Envelope::Square, Law::Power)];
    for (response, (shape, law)) in [PRESET, POLE, PRESET].into_iter().zip(shapes) {
        // No common period within the second over which the steps run.
        let modulation = Modulation { shape, law, frequency: 331.7, depth: 0.9, ..Modulation::default() };
        let motion =
            Motion { path: MotionPath::Circle, tempo: Tempo::Rate(397.3), frames: 7, ..Motion::default() };
        let targets = vec![Target::new(Shape::Point { at: DVec3::Z * 0.1 })];
        let scene = Scene { modulation, motion, targets, ..with(response) };
        let aperture = Aperture::new(&scene);
        let drives: Vec<Drive> = (1..=7).map(|n| scattered(256, f64::from(n) * STEP)).collect();
        let at = [DVec3::new(0.01, 0.02, 0.1)];
        let square = |drive: &Drive| aperture.pressures(&at, &drive.excitation(&aperture.driven))[0];
        let of_frames: Vec<_> = drives.iter().map(square).collect();
        let by_steps = by_steps(&scene, &of_frames, 1.0);
        let request = Request::new(&scene, drives, Quantity::Radiation, (1, 1));
        let mean = request.drives.iter().map(|drive| square(drive).norm_sqr()).sum::<f64>() / 7.0;
        let mean = mean * request.part;
        assert!((mean / by_steps - 1.0).abs() < 2e-3, "{shape:?}: {mean}, not {by_steps}");
    }
}

#[test]
fn without_a_response_drives_stay_as_they_are() {
    let drives = vec![scattered(256, STEP), scattered(256, 2.0 * STEP)];
    assert_eq!(responding(&Scene::default(), drives.clone(), true), drives);
    // A steady drive passes unchanged.
    let steady = responding(&with(PRESET), vec![drives[0].clone()], false);
    let map = |drive: &Drive| {
        let request = Request::new(&Scene::default(), vec![drive.clone()], Quantity::Rms, (9, 9));
        Stages::new(Evaluator::Reference).map(&request).unwrap().values.clone()
    };
    for (a, b) in map(&steady[0]).iter().zip(map(&drives[0])) {
        assert!((a - b).abs() <= 1e-5 * b.abs());
    }
}

#[test]
fn lines_behind_a_response_are_filtered_ones() {
    // A steady focus under a full sine: (1 + g sin)/2 squared.
    let modulation = Modulation { shape: Envelope::Sine, frequency: 200.0, ..Modulation::default() };
    let scene = Scene { modulation: modulation.clone(), ..with(PRESET) };
    let lines = Course::new(&scene, 1).spectrum(&[Complex64::from(2.0)], 1000.0).unwrap();
    let resonator = resonator(PRESET);
    let [above, below] = [200.0, -200.0].map(|offset| resonator.at(offset) / 4.0);
    let mean = 0.25 + above.norm_sqr() + below.norm_sqr();
    let first =
        (0.5 * (Complex64::new(0.0, -1.0) * above + (Complex64::new(0.0, 1.0) * below).conj())).norm() * 2.0;
    for lines in [lines, resonator.square_lines(&modulation)] {
        let scale = if lines[0].amplitude > 1.0 { 4.0 } else { 1.0 };
        for (line, expected) in lines.iter().zip([mean, first]) {
            assert!((line.amplitude / scale - expected).abs() < 1e-6, "{line:?}: {expected}");
        }
    }
}
