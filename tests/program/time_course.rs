//! `probe --time`, and scenes with a modulation.

use std::fs;

use tempfile::TempDir;

use crate::process::{refuse, run, succeed};

const POINTS: &str = "x,y,z\n0.015,0,0.1\n0,0,0.12\n";
const SCENE: &str = "format = 1\n[[target]]\nat = [0, 0, 0.1]\n[solver]\nmethod = \"focus\"\n";

fn folder_with(scene: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.toml"), scene).unwrap();
    fs::write(folder.path().join("points.csv"), POINTS).unwrap();
    folder
}

fn rows(text: &str, head: &str) -> Vec<Vec<f64>> {
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some(head));
    lines.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect()
}

const PLAIN: [&str; 4] = ["probe", "a.toml", "--points", "points.csv"];
const HEAD: &str = "x,y,z,time,re,im,square";

#[test]
fn a_modulated_focus_swings_about_the_plain_probe() {
    let folder = folder_with(&format!("{SCENE}[modulation]\nshape = \"sine\"\nfrequency = 100\n"));
    let steady = rows(&succeed(folder.path(), &PLAIN), "x,y,z,re,im,rms");
    let time = [&PLAIN[..], &["--time", "--spectrum", "lines.csv"]].concat();
    let course = rows(&succeed(folder.path(), &time), HEAD);
    // One period in 32 steps.
    assert_eq!(course.len(), 2 * 32);
    for (index, row) in course.iter().enumerate() {
        let (point, step) = (&steady[index / 32], (index % 32) as f64);
        assert_eq!(row[..3], point[..3]);
        assert!((row[3] - step / 3200.0).abs() < 1e-12);
        let envelope = (1.0 + (std::f64::consts::TAU * step / 32.0).sin()) / 2.0;
        for part in [0, 1] {
            let error = row[4 + part] - point[3 + part] * envelope;
            assert!(error.abs() < 1e-9 * point[5], "{row:?}");
        }
        assert!((row[6] - row[4].powi(2) - row[5].powi(2)).abs() < 1e-9 * row[6].max(1e-9));
    }
    let text = fs::read_to_string(folder.path().join("lines.csv")).unwrap();
    let lines = rows(&text, "x,y,z,frequency,square,phase");
    assert_eq!(lines.len(), 2 * 3);
    for (line, (frequency, part)) in lines.iter().zip([(0.0, 0.375), (100.0, 0.5), (200.0, 0.125)].repeat(2))
    {
        let point = steady.iter().find(|point| point[..3] == line[..3]).unwrap();
        let square = point[3].powi(2) + point[4].powi(2);
        assert!((line[3] - frequency).abs() < 1e-9 && (line[4] / square - part).abs() < 1e-6, "{line:?}");
    }
}

#[test]
fn audible_tones_are_heard_and_too_fast_ones_refused() {
    let tone = |frequency: f64| {
        let own = format!("[target.modulation]\nshape = \"sine\"\nfrequency = {frequency:?}\ndepth = 0.5\n");
        folder_with(&SCENE.replace("[solver]", &format!("{own}[solver]")))
    };
    let folder = tone(2000.0);
    let solved: serde_json::Value =
        serde_json::from_str(&succeed(folder.path(), &["solve", "a.toml", "--json"])).unwrap();
    let heard = &solved["heard"];
    assert_eq!(heard["frequencies"], serde_json::json!([2000.0, 4000.0]));
    assert!((heard["distortion"].as_f64().unwrap() - 1.0 / 3.0).abs() < 1e-9, "{heard}");
    // 97.025 dB of a full sine (numpy), whose line is d(1 - d/2) = 1/2 of the square; here 3/8.
    let expected = 97.025 + 20.0 * 0.75f64.log10();
    assert!((heard["levels"][0].as_f64().unwrap() - expected).abs() < 0.02, "{heard}");
    let said = succeed(folder.path(), &["solve", "a.toml"]);
    assert!(said.contains("heard at 1 m") && said.contains("33.33 % distortion"), "{said}");
    let error = refuse(tone(30e3).path(), &["solve", "a.toml"]);
    let part = "a.toml:6: target[1].modulation.frequency = 30000.0: must be a number from 1 to 20000 Hz: half of the carrier";
    assert!(error.contains(part), "{error}");
}

#[test]
fn targets_with_own_modulations_are_played_by_boards_with_amplitudes_only() {
    let own = |x: f64, frequency: f64| {
        format!(
            "[[target]]\nat = [{x:?}, 0, 0.12]\n[target.modulation]\nshape = \"sine\"\nfrequency = {frequency:?}\n"
        )
    };
    let folder = folder_with(&format!("format = 1\n{}{}", own(-0.025, 200.0), own(0.025, 160.0)));
    let said = succeed(folder.path(), &["solve", "a.toml", "--motion", "--csv", "frames.csv"]);
    assert!(said.contains("40 cycles/s of 100 frames"), "{said}");
    let frames = fs::read_to_string(folder.path().join("frames.csv")).unwrap();
    assert!(frames.lines().count() == 101 && frames.lines().next().unwrap().contains("amplitude_255"));
    for quantity in ["rms", "felt", "skin"] {
        succeed(folder.path(), &["render", "a.toml", "-o", "a.png", "--size", "32", "--quantity", quantity]);
    }
    let error = refuse(folder.path(), &["send", "a.toml", "--port", "none", "--profile", "sonicsurface"]);
    assert!(error.contains("sonicsurface has no amplitude control"), "{error}");
}

#[test]
fn a_moving_focus_is_probed_frame_by_frame() {
    let scene = format!("{SCENE}[motion]\npath = \"circle\"\nsize = 0.03\nrate = 5\nframes = 8\n");
    let folder = folder_with(&scene);
    let output = run(folder.path(), &[&PLAIN[..], &["--time", "-o", "course.csv"]].concat());
    assert!(output.status.success() && output.stdout.is_empty());
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("40.000 frames/s, 5.000 cycles/s"), "{said}");
    let course = rows(&fs::read_to_string(folder.path().join("course.csv")).unwrap(), HEAD);
    // Four samples per frame.
    assert_eq!(course.len(), 2 * 8 * 4);
    for frame in 0..8 {
        let (sin, cos) = (std::f64::consts::TAU * frame as f64 / 8.0).sin_cos();
        let at = format!("at = [{:?}, {:?}, 0.1]", 0.015 * cos, 0.015 * sin);
        let alone = folder_with(&SCENE.replace("at = [0, 0, 0.1]", &at));
        let alone = rows(&succeed(alone.path(), &PLAIN), "x,y,z,re,im,rms");
        for (point, alone) in alone.iter().enumerate() {
            for instant in 0..4 {
                let row = &course[point * 32 + frame * 4 + instant];
                assert!((row[3] - (4.0 * frame as f64 + instant as f64) / 160.0).abs() < 1e-12);
                let rms = (row[6] / 2.0).sqrt();
                assert!((rms / alone[5] - 1.0).abs() < 1e-9, "frame {frame}: {rms} and {}", alone[5]);
            }
        }
    }
    let some = [&PLAIN[..], &["--time", "--span", "0.05", "--rate", "100"]].concat();
    assert_eq!(rows(&succeed(folder.path(), &some), HEAD).len(), 2 * 5);
}

#[test]
fn drives_in_turn_change_a_thousand_times_a_second() {
    let line = "kind = \"line\"\nfrom = [-0.02, 0, 0.1]\nto = [0.02, 0, 0.1]\n";
    let folder = folder_with(&format!("format = 1\n[[target]]\n{line}[solver]\nframes = 2\n"));
    let course = rows(&succeed(folder.path(), &[&PLAIN[..], &["--time"]].concat()), HEAD);
    let steady = rows(&succeed(folder.path(), &PLAIN), "x,y,z,re,im,rms");
    assert_eq!(course.len(), 2 * 2 * 4, "2 ms");
    for (point, rows) in steady.iter().zip(course.chunks(8)) {
        let mean = rows.iter().map(|row| row[6]).sum::<f64>() / 8.0;
        assert!(((mean / 2.0).sqrt() / point[5] - 1.0).abs() < 1e-9);
    }
}

/// A WAV file of 16-bit samples.
fn wav(rate: u32, samples: &[i16]) -> Vec<u8> {
    let bytes = 2 * samples.len() as u32;
    let mut file = b"RIFF".to_vec();
    file.extend((36 + bytes).to_le_bytes());
    file.extend(b"WAVEfmt \x10\0\0\0\x01\0\x01\0");
    file.extend(rate.to_le_bytes());
    file.extend((2 * rate).to_le_bytes());
    file.extend(b"\x02\0\x10\0data");
    file.extend(bytes.to_le_bytes());
    file.extend(samples.iter().flat_map(|sample| sample.to_le_bytes()));
    file
}

#[test]
fn every_sample_of_a_waveform_is_probed() {
    let folder = folder_with(&format!("{SCENE}[modulation]\nshape = \"file\"\nfile = \"a.wav\"\n"));
    // A tone at half the rate: at that, nothing would be left of it.
    let samples = [16384, -16384].repeat(10);
    fs::write(folder.path().join("a.wav"), wav(8000, &samples)).unwrap();
    let steady = rows(&succeed(folder.path(), &PLAIN), "x,y,z,re,im,rms");
    let course = rows(&succeed(folder.path(), &[&PLAIN[..], &["--time"]].concat()), HEAD);
    assert_eq!(course.len(), 2 * samples.len());
    for (index, row) in course.iter().enumerate() {
        let (point, sample) = (&steady[index / 20], f64::from(samples[index % 20]) / 32768.0);
        let envelope = (1.0 + sample) / 2.0;
        assert!((row[4] - point[3] * envelope).abs() < 1e-6 * point[5], "{row:?}");
    }
}

#[test]
fn plain_probe_ignores_the_modulation() {
    let plain = succeed(folder_with(SCENE).path(), &PLAIN);
    let folder = folder_with(&format!("{SCENE}[modulation]\nshape = \"square\"\nlaw = \"power\"\n"));
    assert_eq!(succeed(folder.path(), &PLAIN), plain);
    // Steady sound needs one sample.
    let course = rows(&succeed(folder_with(SCENE).path(), &[&PLAIN[..], &["--time"]].concat()), HEAD);
    assert_eq!(course.len(), 2);
}

#[test]
fn invalid_options_are_refused() {
    let folder = folder_with(SCENE);
    for (args, part) in [
        (&["--span", "1"][..], "--time"),
        (&["--time", "--span", "-1"], "give a number of seconds above 0"),
        (&["--time", "--rate", "nan"], "give a frequency in Hz above 0"),
        (&["--time", "--band", "10"], "--spectrum"),
        (&["--time", "--spectrum", "points.csv"], "points.csv"),
        (&["--time", "--spectrum", "b.csv", "-o", "b.csv"], "twice"),
        (&["--time", "--span", "3600", "--rate", "1000"], "more than the 2000000 rows"),
    ] {
        let message = refuse(folder.path(), &[&PLAIN[..], args].concat());
        assert!(message.contains(part), "{args:?}: {message}");
    }
}

#[test]
fn a_waveform_beside_the_scene_becomes_the_envelope() {
    let modulation = "[modulation]\nshape = \"file\"\nlaw = \"power\"\nfile = \"sounds/buzz.wav\"\n";
    let folder = folder_with(&format!("{SCENE}{modulation}"));
    let missing = refuse(folder.path(), &PLAIN);
    assert!(
        missing.contains("a.toml:9: modulation.file = \"sounds/buzz.wav\": ")
            && missing.contains("no such file")
    );
    fs::create_dir(folder.path().join("sounds")).unwrap();
    let buzz = folder.path().join("sounds/buzz.wav");
    fs::write(&buzz, wav(1000, &[0, 16384, -16384, -32768])).unwrap();
    // Also from another working directory.
    let elsewhere = tempfile::tempdir().unwrap();
    let scene = folder.path().join("a.toml").display().to_string();
    let points = folder.path().join("points.csv").display().to_string();
    let plain = ["probe", &scene, "--points", &points];
    let steady = rows(&succeed(elsewhere.path(), &plain), "x,y,z,re,im,rms");
    let course =
        rows(&succeed(elsewhere.path(), &[&plain[..], &["--time", "--rate", "2000"]].concat()), HEAD);
    // Linear interpolation between samples.
    let parts = [0.5, 0.625, 0.75, 0.5, 0.25, 0.125, 0.0, 0.25];
    assert_eq!(course.len(), 2 * parts.len());
    for (row, part) in course.iter().zip(parts) {
        let square = steady[0][3].powi(2) + steady[0][4].powi(2);
        assert!((row[6] / square - part).abs() < 1e-9, "{row:?}: {part}");
    }
    // Input files are not overwritten, and files that are not waveforms are named.
    let own = buzz.display().to_string();
    let message = refuse(folder.path(), &[&PLAIN[..], &["--time", "-o", &own]].concat());
    assert!(message.contains("buzz.wav"), "{message}");
    fs::write(&buzz, "no sound").unwrap();
    let message = refuse(folder.path(), &PLAIN);
    assert!(message.contains("a.toml:9: ") && message.contains("no WAV file"), "{message}");
}

#[test]
fn modulations_are_refused_for_boards_that_cannot_play_them() {
    let tones = "[modulation]\nshape = \"tones\"\ntones = [{ frequency = 199, depth = 0.5 }, { frequency = 200, depth = 0.5 }]\n";
    let folder = folder_with(&format!("{SCENE}{tones}"));
    for (profile, part) in [
        ("sonicsurface", "only switches on and off at one frequency"),
        ("native", "200 Hz is 200 times the common frequency of these tones"),
    ] {
        let message =
            refuse(folder.path(), &["send", "a.toml", "--port", "/dev/nowhere", "--profile", profile]);
        assert!(message.contains("a.toml: ") && message.contains(part), "{message}");
    }
}
