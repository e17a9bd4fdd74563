//! Spectra of |p|²: closed forms, piecewise integrals, and foci that pass a point.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use num_complex::Complex64;
use sonoglyph::acoustics::Aperture;
use sonoglyph::acoustics::course::Course;
use sonoglyph::scene::{
    Envelope, Law, Method, Modulation, Motion, MotionPath, Scene, Shape, Target, Tempo, Tone,
};
use sonoglyph::scene::{SpectralLine, Wave, Waveform};
use sonoglyph::solver::{self, frames};

const BAND: f64 = 1000.0;

fn modulated(modulation: Modulation) -> Scene {
    Scene { modulation, ..Scene::default() }
}

/// A circular motion with this rate and number of frames.
fn moving(rate: f64, frames: u32, modulation: Modulation) -> Scene {
    let motion = Motion { path: MotionPath::Circle, tempo: Tempo::Rate(rate), frames, ..Motion::default() };
    Scene { motion, ..modulated(modulation) }
}

fn sine(law: Law) -> Modulation {
    Modulation { shape: Envelope::Sine, law, frequency: 200.0, ..Modulation::default() }
}

fn tone(frequency: f64, depth: f64, phase: f64) -> Tone {
    Tone { frequency, depth, phase }
}

fn spectrum(scene: &Scene, of_frames: &[Complex64]) -> Vec<SpectralLine> {
    Course::new(scene, of_frames.len()).spectrum(of_frames, BAND).unwrap()
}

/// The complex amplitude of the line at a frequency, or 0.
fn at(lines: &[SpectralLine], frequency: f64) -> Complex64 {
    let mut same = lines.iter().filter(|line| (line.frequency - frequency).abs() < 1e-3);
    let found = same.next().map_or(Complex64::ZERO, |line| Complex64::from_polar(line.amplitude, line.phase));
    assert!(same.next().is_none(), "one line at {frequency} Hz");
    found
}

/// Two foci under own modulations, besides one that follows the scene's.
fn own_modulations() -> Scene {
    let point = |x: f64, own: Option<f64>| {
        let modulation = own.map(|frequency| Modulation { frequency, ..sine(Law::Amplitude) });
        Target { modulation, ..Target::new(Shape::Point { at: DVec3::new(x, 0.0, 0.12) }) }
    };
    let targets = vec![point(-0.03, Some(200.0)), point(0.03, Some(160.0)), point(0.0, None)];
    Scene { targets, ..Scene::default() }
}

#[test]
fn targets_under_own_modulations_have_their_own_lines_alone() {
    let scene = own_modulations();
    let sequence = frames::follow(&scene).unwrap();
    // 25 ms, 25 periods of the carrier to a frame at most.
    assert_eq!(sequence.frames.len(), 100);
    let loudest =
        sequence.frames.iter().flat_map(|frame| &frame.drive.amplitudes).fold(0.0f64, |a, b| a.max(*b));
    assert!(loudest <= 1.0 && loudest > 0.8, "{loudest}");
    let at_rest = solver::solve(&scene).unwrap();
    for (index, own) in [Some(200.0), Some(160.0), None].into_iter().enumerate() {
        let of_frames: Vec<_> = sequence.frames.iter().map(|frame| frame.pressures[index]).collect();
        let lines = spectrum(&scene, &of_frames);
        let mean = at(&lines, 0.0).re;
        for frequency in [160.0, 200.0, 320.0, 400.0, 40.0, 360.0] {
            let line = at(&lines, frequency);
            // Half of the steady square at f, 3/8 as the mean; held over a frame in its middle, so in phase.
            match own {
                Some(own) if own == frequency => {
                    assert!(
                        (line / mean - Complex64::from_polar(4.0 / 3.0, -PI / 2.0)).norm() < 0.01,
                        "{lines:?}"
                    );
                }
                Some(own) if 2.0 * own == frequency => assert!((line.norm() / mean - 1.0 / 3.0).abs() < 0.01),
                Some(_) | None => assert!(line.norm() < 1e-4 * mean, "{index}: {frequency} Hz, {lines:?}"),
            }
        }
        // Within full drive, each is as loud as at rest.
        let most = of_frames.iter().map(|p| p.norm()).fold(0.0, f64::max);
        assert!(most > 0.98 * at_rest.pressures[index].norm(), "{index}: {most} Pa");
    }
}

#[test]
fn targets_of_one_modulation_have_the_drives_of_the_scenes() {
    let mut scene = own_modulations();
    scene.targets.iter_mut().for_each(|target| target.modulation = None);
    let plain = frames::follow(&scene).unwrap().frames;
    scene.targets.iter_mut().for_each(|target| target.modulation = Some(sine(Law::Power)));
    let own = frames::follow(&scene).unwrap().frames;
    assert!(own == plain && own.len() == 1 && *scene.envelope() == sine(Law::Power));
}

#[test]
fn whole_targets_move_under_own_modulations() {
    let mut scene = own_modulations();
    let still: Vec<_> = scene.targets.iter().map(|target| target.shape.centre()).collect();
    scene.motion =
        Motion { path: MotionPath::Circle, tempo: Tempo::Rate(80.0), frames: 8, ..Motion::default() };
    let sequence = frames::follow(&scene).unwrap();
    // Two rounds of 8 frames in 25 ms, and whole periods of the carrier.
    let count = sequence.frames.len();
    assert!(count >= 80 && count.is_multiple_of(16), "{count}");
    let offset = sequence.frames[count / 4].foci[1].position - still[1];
    assert!((offset.length() - 0.015).abs() < 1e-9 && offset.x < -0.014, "{offset}");
    let silent = sequence.frames.iter().map(|frame| frame.pressures[0].norm()).fold(f64::INFINITY, f64::min);
    assert!(silent < 0.05 * sequence.frames[0].pressures[2].norm(), "{silent} Pa");
}

#[test]
fn own_modulations_that_cannot_be_frames_are_refused_with_the_reason() {
    let refused = |change: fn(&mut Scene), part: &str| {
        let mut scene = own_modulations();
        change(&mut scene);
        let error = sonoglyph::scene::motion::check(&scene).unwrap_err().to_string();
        assert!(error.starts_with("target[1].modulation: ") && error.contains(part), "{error}");
    };
    refused(
        |scene| scene.targets[0].modulation.as_mut().unwrap().frequency = 200.000_1,
        "no common period up to 10 s",
    );
    refused(|scene| scene.targets[0].modulation.as_mut().unwrap().frequency = 2000.1, "1 GiB is the most");
    refused(
        |scene| {
            let at = scene.targets[2].shape.centre();
            scene.targets[2].shape = Shape::Circle { at, radius: 0.01 };
            scene.motion = Motion { path: MotionPath::Outline, ..Motion::default() };
        },
        "outlines",
    );
    refused(
        |scene| {
            scene.targets[0].step = Some(0);
            scene.motion = Motion { path: MotionPath::Steps, ..Motion::default() };
        },
        "take turns",
    );
}

#[test]
fn a_full_sine_has_the_lines_of_its_closed_form() {
    // ((1 + sin a)/2)² = 3/8 + sin(a)/2 - cos(2a)/8
    let p = [Complex64::from_polar(3.0, 0.7)];
    let lines = spectrum(&modulated(sine(Law::Amplitude)), &p);
    let expected = [(0.0, 3.0 / 8.0, 0.0), (200.0, 0.5, -PI / 2.0), (400.0, 0.125, PI)];
    assert_eq!(lines.len(), 3, "{lines:?}");
    for (frequency, amplitude, phase) in expected {
        let error = at(&lines, frequency) / 9.0 - Complex64::from_polar(amplitude, phase);
        assert!(error.norm() < 1e-12, "{frequency} Hz: {error}");
    }
    // With the power law there is no line at 2f.
    let lines = spectrum(&modulated(sine(Law::Power)), &p);
    assert_eq!(lines.len(), 2, "{lines:?}");
    for (frequency, amplitude, phase) in [(0.0, 0.5, 0.0), (200.0, 0.5, -PI / 2.0)] {
        let error = at(&lines, frequency) / 9.0 - Complex64::from_polar(amplitude, phase);
        assert!(error.norm() < 1e-12, "{frequency} Hz: {error}");
    }
}

#[test]
fn a_square_wave_has_odd_harmonics() {
    let modulation =
        Modulation { shape: Envelope::Square, frequency: 70.0, depth: 0.5, ..Modulation::default() };
    let lines = spectrum(&modulated(modulation), &[Complex64::from(2.0)]);
    assert!((at(&lines, 0.0).re - 4.0 * (1.0 + 0.25) / 2.0).abs() < 1e-12);
    for n in 1..=14 {
        let expected = if n % 2 == 1 { 2.0 * 4.0 * 0.75 / (PI * f64::from(n)) } else { 0.0 };
        assert!((at(&lines, 70.0 * f64::from(n)).norm() - expected).abs() < 1e-12, "harmonic {n}");
    }
}

/// The swing of a modulation, implemented independently.
fn swing(modulation: &Modulation, time: f64) -> f64 {
    let half = |depth: f64, x: f64| 1.0 - depth / 2.0 + depth / 2.0 * x;
    let turns = modulation.frequency * time;
    match modulation.shape {
        Envelope::Off => 1.0,
        Envelope::Sine => half(modulation.depth, (TAU * turns).sin()),
        Envelope::Square => half(modulation.depth, if turns - turns.floor() < 0.5 { 1.0 } else { -1.0 }),
        Envelope::Tones => {
            let of_tone =
                |tone: &Tone| half(tone.depth, (TAU * tone.frequency * time + tone.phase).sin()) - 1.0;
            1.0 + modulation.tones.iter().map(of_tone).sum::<f64>()
        }
        Envelope::File => {
            let samples = modulation.wave.get().unwrap();
            let place = time * samples.rate;
            let value = |i: f64| f64::from(samples.values[i as usize % samples.values.len()]);
            let part = place - place.floor();
            half(modulation.depth, value(place.floor()) * (1.0 - part) + value(place.floor() + 1.0) * part)
        }
    }
}

/// The complex amplitude at a frequency over `span` seconds: five-node Gauss integrals between all edges, of which
/// there are `edges` per second and one at every change of frames.
fn integrated(
    scene: &Scene,
    frames: &[Complex64],
    (rate, edges): (f64, f64),
    span: f64,
    frequency: f64,
) -> Complex64 {
    const NODES: [(f64, f64); 5] = [
        (0.0, 0.568_888_888_888_888_9),
        (0.538_469_310_105_683, 0.478_628_670_499_366_5),
        (-0.538_469_310_105_683, 0.478_628_670_499_366_5),
        (0.906_179_845_938_664, 0.236_926_885_056_189_1),
        (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    ];
    let fine = 8.0 * (BAND + 400.0);
    let mut ends: Vec<f64> = [rate, edges, fine]
        .iter()
        .flat_map(|&rate| (0..=(span * rate + 1e-6) as u64).map(move |i| i as f64 / rate))
        .chain([span])
        .collect();
    ends.sort_by(f64::total_cmp);
    let mut sum = Complex64::ZERO;
    for pair in ends.windows(2).filter(|pair| pair[1] - pair[0] > 1e-12) {
        let (middle, half) = ((pair[0] + pair[1]) / 2.0, (pair[1] - pair[0]) / 2.0);
        let frame = frames[(middle * rate) as usize % frames.len()].norm_sqr();
        for (node, weight) in NODES {
            let time = middle + half * node;
            let swing = swing(&scene.modulation, time);
            let square = if scene.modulation.law == Law::Power { swing } else { swing * swing };
            sum += half * weight * frame * square * Complex64::from_polar(1.0, -TAU * frequency * time);
        }
    }
    sum * if frequency == 0.0 { 1.0 } else { 2.0 } / span
}

#[test]
fn lines_are_the_integrals_over_a_common_period() {
    let values: Vec<f32> = (0..40).map(|i| (f64::from(i * i) * 0.37).sin() as f32).collect();
    let wave = Wave::new(Waveform { file: "a.wav".into(), rate: 2000.0, values });
    let frames: Vec<_> =
        (0..16).map(|i| Complex64::from_polar(1.0 + (f64::from(i * i) * 0.9).sin(), f64::from(i))).collect();
    let tones = vec![tone(150.0, 0.4, 0.3), tone(230.0, 0.35, -1.0), tone(150.0, 0.25, 2.0)];
    // The product of two series, of a file and of frames, has infinitely many lines; distant ones are truncated.
    for (shape, edges, bound) in [
        (Envelope::Off, 1.0, 1e-12),
        (Envelope::Sine, 1.0, 1e-10),
        (Envelope::Tones, 1.0, 1e-10),
        (Envelope::Square, 400.0, 1e-10),
        (Envelope::File, 2000.0, 2e-6),
    ] {
        for law in [Law::Amplitude, Law::Power] {
            let (tones, wave) = (tones.clone(), wave.clone());
            let modulation = Modulation { shape, law, depth: 0.8, tones, wave, ..Modulation::default() };
            let scene = moving(10.0, 16, modulation);
            let lines = spectrum(&scene, &frames);
            let mean = at(&lines, 0.0).re;
            let exact = |frequency| integrated(&scene, &frames, (160.0, edges), 0.1, frequency);
            let off =
                (0..=100).map(|i| 10.0 * f64::from(i)).map(|f| (exact(f) - at(&lines, f)).norm() / mean);
            let worst = off.fold(0.0, f64::max);
            assert!(worst < bound, "{shape:?}, {law:?}: {worst:e} of the mean");
            println!("{shape:?}, {law:?}: {worst:.1e} of the mean");
            let odd: Vec<_> =
                lines.iter().filter(|line| (line.frequency / 10.0).fract().abs() > 1e-6).collect();
            assert!(
                odd.iter().all(|line| (line.frequency / 10.0).fract() > 1.0 - 1e-6),
                "{shape:?}: {odd:?}"
            );
        }
    }
}

#[test]
fn motions_and_tones_without_a_common_period_intermodulate() {
    let rate = 7.0 * 2f64.sqrt();
    let frames: Vec<_> = (0..8).map(|i| Complex64::from(1.0 + f64::from(i % 5))).collect();
    let scene = moving(rate, 8, sine(Law::Power));
    let lines = spectrum(&scene, &frames);
    assert_eq!(Course::new(&scene, 8).period(), None);
    let alone = spectrum(&moving(rate, 8, Modulation::default()), &frames);
    for n in 1..=20 {
        let harmonic = f64::from(n) * rate;
        let own = at(&alone, harmonic);
        assert!((at(&lines, harmonic) - own / 2.0).norm() < 1e-9, "harmonic {n}");
        // sin(a) cos(b) is half a sine at the sum of the frequencies.
        let beside = at(&lines, 200.0 + harmonic) - own * Complex64::from_polar(0.25, -PI / 2.0);
        assert!(beside.norm() < 1e-9, "above 200 Hz, harmonic {n}: {beside}");
    }
}

/// The lines of a moving focus at a point, relative to their mean.
fn passing(path: MotionPath, rate: f64, at: DVec3) -> Vec<SpectralLine> {
    let target = Target::new(Shape::Point { at: DVec3::new(0.0, 0.0, 0.1) });
    let mut scene = Scene {
        targets: vec![target],
        motion: Motion { path, tempo: Tempo::Rate(rate), ..Motion::default() },
        ..Scene::default()
    };
    scene.solver.method = Method::Focus;
    let sequence = frames::follow(&scene).unwrap();
    let aperture = Aperture::new(&scene);
    let transfer = aperture.transfer(&[at]);
    let pressure = |frame: &frames::Frame| transfer.pressure(&frame.drive.excitation(&aperture.driven))[0];
    let of_frames: Vec<_> = sequence.frames.iter().map(pressure).collect();
    let mut lines = spectrum(&scene, &of_frames);
    let mean = lines[0].amplitude;
    // The frames' mean, computed directly.
    let own = of_frames.iter().map(Complex64::norm_sqr).sum::<f64>() / of_frames.len() as f64;
    assert!((mean / own - 1.0).abs() < 1e-12);
    lines.iter_mut().for_each(|line| line.amplitude /= mean);
    lines
}

#[test]
fn a_passing_focus_gives_harmonics_of_its_passing_rate() {
    // On the circle, once per cycle: every harmonic, and nothing between them.
    let lines = passing(MotionPath::Circle, 10.0, DVec3::new(0.015, 0.0, 0.1));
    assert!(lines.iter().all(|line| (line.frequency / 10.0 - (line.frequency / 10.0).round()).abs() < 1e-9));
    assert!((1..=5).all(|n| at(&lines, 10.0 * f64::from(n)).norm() > 0.2), "{:?}", &lines[..6]);
    // In the middle of a figure-eight, twice per cycle: harmonics of 20 Hz, and none of 10 Hz between them.
    let lines = passing(MotionPath::FigureEight, 10.0, DVec3::new(0.0, 0.0, 0.1));
    for n in 0..10 {
        let between = at(&lines, 10.0 + 20.0 * f64::from(n)).norm();
        assert!(between < 1e-6, "{between} at {} Hz", 10 + 20 * n);
    }
    assert!((1..=5).all(|n| at(&lines, 20.0 * f64::from(n)).norm() > 0.1), "{lines:?}");
    // Harmonics near the frame rate are attenuated only by the hold of a frame.
    assert!(at(&lines, 640.0).norm() < 1e-9, "64 frames hold: nothing at their rate itself");
}

#[test]
fn the_course_is_the_frame_that_plays_times_the_envelope() {
    let frames: Vec<_> = (0..5).map(|i| Complex64::from_polar(f64::from(i), 0.3)).collect();
    let scene = moving(8.0, 5, sine(Law::Amplitude));
    let course = Course::new(&scene, 5);
    assert_eq!((course.frames_per_second(), course.cycles_per_second()), (40.0, 8.0));
    assert!((course.period().unwrap() - 0.125).abs() < 1e-12);
    let pressures = course.pressures(&frames, 1000, course.usual_rate());
    for (instant, pressure) in (0_u32..).zip(pressures) {
        let time = f64::from(instant) / course.usual_rate();
        let frame = ((time + 1e-9) * 40.0) as usize % 5;
        let envelope = (1.0 + (TAU * 200.0 * time).sin()) / 2.0;
        let error = pressure - frames[frame] * envelope;
        assert!(error.norm() < 1e-9, "{time} s");
    }
    assert!(course.usual_rate() >= 32.0 * 200.0 && (course.usual_rate() / 40.0).fract() == 0.0);
}

#[test]
fn spectra_with_too_many_lines_are_refused() {
    let values = vec![0.5; 1_000_000];
    let wave = Wave::new(Waveform { file: "a.wav".into(), rate: 48_000.0, values });
    let modulation = Modulation { shape: Envelope::File, wave, ..Modulation::default() };
    let scene = moving(0.01, 64, modulation);
    let error = Course::new(&scene, 64).spectrum(&[Complex64::ONE; 64], BAND).unwrap_err();
    assert!(error.contains("take a narrower band"), "{error}");
}
