//! Radiation pressure, depressions, waves and caustics on the command line.

use std::fs;
use std::path::Path;

use crate::process::{folder_with, output_of, refuse};

/// Shape and numbers of an NPY file of float32.
fn npy(path: &Path) -> (String, Vec<f32>) {
    let bytes = fs::read(path).unwrap();
    let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let header = String::from_utf8_lossy(&bytes[10..10 + length]).into_owned();
    let numbers = bytes[10 + length..].chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    (header, numbers.collect())
}

fn largest(numbers: &[f32]) -> (usize, f32) {
    let place = (0..numbers.len()).max_by(|&a, &b| numbers[a].total_cmp(&numbers[b])).unwrap();
    (place, numbers[place])
}

const FAINT: &str =
    "format = 1\n[array]\nstrength = 1.0\n[[target]]\nat = [0.01, 0.02, 0.1]\n[plane]\nsize = [0.08, 0.06]\n";

#[test]
fn a_depression_is_in_metres_and_deepest_under_the_focus() {
    let folder = folder_with(&[("a.toml", FAINT)]);
    let at = folder.path();
    for backend in ["cpu", "reference"] {
        let args = [
            "render",
            "a.toml",
            "-o",
            "a.png",
            "--quantity",
            "depression",
            "--size",
            "80",
            "--data",
            "a.npy",
        ];
        let (said, warned) = output_of(at, &[&args[..], &["--backend", backend]].concat());
        assert!(said.contains("µm") && said.contains("mm³") && said.contains("water 100 mm"), "{said}");
        assert!(!warned.contains("linear theory"), "{warned}");
        let (header, depth) = npy(&at.join("a.npy"));
        assert!(header.contains("(60, 80"), "{header}");
        let (place, deepest) = largest(&depth);
        let (x, y) = ((place % 80) as f64 + 0.5 - 40.0, (place / 80) as f64 + 0.5 - 30.0);
        assert!((x - 10.0).abs() <= 1.0 && (y - 20.0).abs() <= 1.0, "{x} {y}");
        // 10 Pa press water down by about 0.5 mm.
        output_of(
            at,
            &[
                "render",
                "a.toml",
                "-o",
                "p.png",
                "--quantity",
                "radiation",
                "--size",
                "80",
                "--data",
                "p.npy",
            ],
        );
        let (_, pressure) = npy(&at.join("p.npy"));
        let (_, most) = largest(&pressure);
        let per_pascal = deepest / most;
        assert!((3e-5..7e-5).contains(&per_pascal), "{deepest} m under {most} Pa");
    }
}

#[test]
fn the_old_name_dent_is_still_accepted() {
    let folder = folder_with(&[("a.toml", FAINT)]);
    let render = |quantity: &str, data: &str| {
        let args =
            ["render", "a.toml", "-o", "a.png", "--quantity", quantity, "--size", "40", "--data", data];
        output_of(folder.path(), &args).0
    };
    assert_eq!(render("depression", "new.npy"), render("dent", "old.npy"));
    let bytes = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert_eq!(bytes("new.npy"), bytes("old.npy"));
}

#[test]
fn the_envelope_and_the_liquid_change_the_depression() {
    let sine = format!("{FAINT}[modulation]\nshape = \"sine\"\n");
    let ethanol = format!("{FAINT}[liquid]\nname = \"ethanol\"\n");
    let folder = folder_with(&[("a.toml", FAINT), ("sine.toml", &sine), ("ethanol.toml", &ethanol)]);
    let deepest = |scene: &str| {
        let args =
            ["render", scene, "-o", "a.png", "--quantity", "depression", "--size", "60", "--data", "a.npy"];
        let (said, _) = output_of(folder.path(), &args);
        (largest(&npy(&folder.path().join("a.npy")).1).1, said)
    };
    let ((full, _), (half, said), (deep, of_ethanol)) =
        (deepest("a.toml"), deepest("sine.toml"), deepest("ethanol.toml"));
    assert!((half / full - 0.375).abs() < 1e-4, "{half} {full}");
    assert!(said.contains("37.5 %"), "{said}");
    assert!(deep > 1.6 * full && of_ethanol.contains("ethanol"), "{deep} {full} {of_ethanol}");
}

#[test]
fn a_depression_beyond_linear_theory_warns_with_the_drive_at_its_limit() {
    let strong = FAINT.replace("strength = 1.0", "strength = 6.0");
    let folder = folder_with(&[("a.toml", &strong)]);
    for view in ["flat", "shaded"] {
        let args =
            ["render", "a.toml", "-o", "a.png", "--quantity", "depression", "--view", view, "--size", "400"];
        let (_, warned) = output_of(folder.path(), &args);
        assert!(
            warned.contains("beyond linear theory") && warned.contains("% of this amplitude"),
            "{warned}"
        );
        let picture = image::open(folder.path().join("a.png")).unwrap();
        assert_eq!(picture.width(), 400);
    }
}

#[test]
fn a_motion_presses_by_its_mean_unless_a_frame_is_selected() {
    let moving = format!("{FAINT}[motion]\npath = \"circle\"\nsize = 0.02\nframes = 8\n");
    let folder = folder_with(&[("a.toml", &moving)]);
    let map = |more: &[&str]| {
        let args = ["render", "a.toml", "-o", "a.png", "--size", "60", "--data", "a.npy"];
        output_of(folder.path(), &[&args[..], more].concat());
        npy(&folder.path().join("a.npy")).1
    };
    let frames = (1..=8).map(|frame| map(&["--frame", &frame.to_string()]));
    let mean = map(&["--frame", "mean"]);
    let mut squares = vec![0.0f32; mean.len()];
    for frame in frames {
        for (square, p) in squares.iter_mut().zip(frame) {
            *square += p * p / 8.0;
        }
    }
    let peak = largest(&mean).1;
    for (mean, square) in mean.iter().zip(&squares) {
        assert!((mean - square.sqrt()).abs() < 2e-3 * peak, "{mean} {}", square.sqrt());
    }
    let of_mean = largest(&map(&["--quantity", "depression"])).1;
    let of_frame = largest(&map(&["--quantity", "depression", "--frame", "1"])).1;
    assert!(of_mean < 0.7 * of_frame, "{of_mean} {of_frame}");
}

#[test]
fn waves_are_an_animation_from_rest() {
    let slow = format!("{FAINT}[modulation]\nshape = \"square\"\nfrequency = 50.0\n");
    let folder = folder_with(&[("a.toml", &slow)]);
    let at = folder.path();
    let args = [
        "render",
        "a.toml",
        "-o",
        "waves/",
        "--quantity",
        "depression",
        "--waves",
        "--seconds",
        "0.05",
        "--size",
        "40",
    ];
    let (said, _) = output_of(at, &args);
    assert!(said.contains("20 frames") && said.contains("slowed down 8.0 x"), "{said}");
    let picture = |number: usize| image::open(at.join(format!("waves/a-{number:02}.png"))).unwrap().to_rgb8();
    let contrast = |number: usize| {
        let red: Vec<_> = picture(number).pixels().map(|pixel| i32::from(pixel.0[0])).collect();
        red.iter().max().unwrap() - red.iter().min().unwrap()
    };
    assert!(contrast(1) < contrast(20), "{} {}", contrast(1), contrast(20));
}

#[test]
fn wave_data_holds_depths_and_times() {
    let folder = folder_with(&[("a.toml", FAINT)]);
    let waves = |seconds: &str, data: &str| {
        let args = ["render", "a.toml", "-o", "a.gif", "--quantity", "depression", "--waves", "--size", "24"];
        output_of(folder.path(), &[&args[..], &["--seconds", seconds, "--data", data]].concat());
        npy(&folder.path().join(data))
    };
    let (header, depth) = waves("0.05", "waves.npy");
    assert!(header.contains("'<f4'") && header.contains("(20, 18, 24"), "{header}");
    let (header, times) = npy(&folder.path().join("waves.times.npy"));
    assert!(header.contains("'<f4'") && header.contains("(20,"), "{header}");
    for (picture, time) in (1u16..).zip(&times) {
        assert!((time - f32::from(picture) * 0.0025).abs() < 1e-7, "{times:?}");
    }
    // At first, before surface tension and neighbours matter, depth grows with the square of time.
    let frames: Vec<_> = depth.chunks_exact(18 * 24).collect();
    let deepest = |frame: usize| largest(frames[frame]).1;
    let fallen = deepest(1) / deepest(0);
    assert!(deepest(0) > 0.0 && (3.2..4.0).contains(&fallen), "{fallen}");
    // Half the time gives the first half of the frames.
    let (_, half) = waves("0.025", "half.npy");
    assert_eq!(npy(&folder.path().join("half.times.npy")).1, times[..10]);
    assert_eq!(half, depth[..half.len()]);
    assert_eq!(half.len(), depth.len() / 2);
    // Waves settle at the steady depression.
    let args =
        ["render", "a.toml", "-o", "a.png", "--quantity", "depression", "--size", "24", "--data", "a.npy"];
    output_of(folder.path(), &args);
    let rest = largest(&npy(&folder.path().join("a.npy")).1).1;
    let most = (0..20).map(deepest).fold(0.0, f32::max);
    assert!((0.5..2.0).contains(&(most / rest)), "{most} m and at rest {rest} m");
}

#[test]
fn impossible_depressions_are_refused() {
    let upright = FAINT.replace("size = [0.08, 0.06]", "y_axis = [0, 0, 1]");
    let low = FAINT.replace("size", "centre = [0, 0, 0.005]\nsize");
    let empty = format!("{FAINT}[liquid]\ndensity = 0\n");
    let stretched = format!("{FAINT}[liquid]\nsurface_tension = -1\n");
    let folder = folder_with(&[
        ("a.toml", FAINT),
        ("upright.toml", &upright),
        ("low.toml", &low),
        ("empty.toml", &empty),
        ("stretched.toml", &stretched),
    ]);
    let refused = |scene: &'static str, more: &[&'static str]| {
        let output = if more.contains(&"--waves") { "a.gif" } else { "a.png" };
        refuse(folder.path(), &[&["render", scene, "-o", output, "--quantity", "depression"], more].concat())
    };
    for (message, part) in [
        (refused("upright.toml", &[]), "must have no z component"),
        (refused("low.toml", &[]), "nearer than a wavelength"),
        (refused("empty.toml", &[]), "liquid.density = 0"),
        (refused("stretched.toml", &[]), "liquid.surface_tension = -1"),
        (refused("a.toml", &["--frame", "0"]), "counted from 1"),
        (refused("a.toml", &["--frame", "2"]), "there is no frame 2"),
        (refused("a.toml", &["--waves", "--seconds", "1e9"]), "were asked for"),
        (refused("a.toml", &["--waves", "--seconds", "nan"]), "NaN s were asked for"),
        (refused("a.toml", &["--seconds", "1"]), "--waves"),
        (refused("a.toml", &["--fps", "20"]), "add --motion or --waves"),
        (refused("a.toml", &["--waves", "--motion"]), "cannot be used with"),
    ] {
        assert!(message.contains(part), "{part}: {message}");
    }
    let rms = ["render", "a.toml", "-o", "a.gif", "--waves"];
    assert!(refuse(folder.path(), &rms).contains("--quantity depression"));
    let phase = ["render", "a.toml", "-o", "a.png", "--quantity", "phase", "--frame", "mean"];
    assert!(refuse(folder.path(), &phase).contains("phase has no mean over frames"));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 5, "nothing was written");
}

/// A still, a figure, a film and waves of the same light agree.
#[test]
fn a_caustic_has_the_data_of_its_picture() {
    let folder = folder_with(&[("a.toml", &format!("{FAINT}[liquid]\nscreen = 0.05\n"))]);
    let at = folder.path();
    let caustic = ["--quantity", "caustic", "--backend", "cpu"];
    let still = ["render", "a.toml", "-o", "a.png", "--size", "80", "--data", "a.npy"];
    let (said, _) = output_of(at, &[&still[..], &caustic].concat());
    assert!(
        said.contains("× undisturbed") && said.contains("n = 1.333") && said.contains("water 100 mm"),
        "{said}"
    );
    let (header, light) = npy(&at.join("a.npy"));
    assert!(header.contains("(60, 80"), "{header}");
    let mean = light.iter().map(|&value| f64::from(value)).sum::<f64>() / 4800.0;
    let landed: f64 =
        said.split(" % of the light").next().unwrap().rsplit(' ').next().unwrap().parse().unwrap();
    assert!((100.0 * mean - landed).abs() < 0.006, "{mean}: {said}");
    // Transmitted light is spread under the focus.
    let focus = light[50 * 80 + 50];
    assert!(focus < 0.9 && largest(&light).1 > 1.0, "{focus}");
    output_of(
        at,
        &[&["render", "a.toml", "-o", "a.svg", "--figure", "--width-mm", "40"], &caustic[..]].concat(),
    );
    assert!(fs::read_to_string(at.join("a.svg")).unwrap().contains("undisturbed"));
    let waves = [
        "render",
        "a.toml",
        "-o",
        "a.gif",
        "--waves",
        "--seconds",
        "0.05",
        "--size",
        "40",
        "--data",
        "w.npy",
    ];
    let (said, _) = output_of(at, &[&waves[..], &caustic].concat());
    assert!(said.contains(", brightness 0"), "{said}");
    let (header, waves) = npy(&at.join("w.npy"));
    assert!(header.contains("(20, 30, 40"), "{header}");
    let focus = |frame: usize| waves[frame * 1200 + 25 * 40 + 25];
    assert!((focus(0) - 1.0).abs() < 0.1 && focus(19) < focus(0) - 0.05, "{} {}", focus(0), focus(19));
}

#[test]
fn invalid_light_is_refused_with_its_key() {
    for (key, said) in [
        ("screen = 0.0", "liquid.screen = 0"),
        ("refractive_index = 0.9", "liquid.refractive_index = 0.9: must be a number from 1 to 4"),
        ("light = \"sideways\"", "expected `through` or `reflected`"),
    ] {
        let folder = folder_with(&[("a.toml", &format!("{FAINT}[liquid]\n{key}\n"))]);
        let message = refuse(folder.path(), &["render", "a.toml", "-o", "a.png", "--quantity", "caustic"]);
        assert!(message.contains(said) && message.contains("a.toml:"), "{message}");
        assert!(!folder.path().join("a.png").exists());
    }
    let folder = folder_with(&[("a.toml", FAINT)]);
    let shaded = ["render", "a.toml", "-o", "a.png", "--quantity", "caustic", "--view", "shaded", "--figure"];
    let message = refuse(folder.path(), &shaded);
    assert!(message.contains("--quantity depression"), "{message}");
}
