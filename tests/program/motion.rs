//! Motion on the command line: `solve --motion`, `render --motion`, and refusals of bad input.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::process::{folder_with, refuse, run, succeed};

/// Two foci that run along a square, with one element off.
const SQUARE: &str = "format = 1\n[array]\noff = [3]\n[[target]]\nat = [-0.02, 0, 0.1]\n[[target]]\nat = [0.02, 0, 0.1]\n\
                      [plane]\nsize = [0.12, 0.06]\n[motion]\npath = \"square\"\nsize = 0.02\nrate = 2\nframes = 12\n";
/// A focus that alternates between left and right.
const STEPS: &str = "format = 1\n[[target]]\nat = [-0.03, 0, 0.1]\nstep = 0\n[[target]]\nat = [0.03, 0.01, 0.1]\n\
                     pressure = 0.5\nstep = 1\n[solver]\nmethod = \"focus\"\n[motion]\npath = \"steps\"\nrate = 1\nframes = 4\n";

/// A focus that moves out and back and gets quieter, beside a constant one.
const KEYFRAMES: &str = "format = 1\n[[target]]\nat = [0, 0, 0.1]\n[target.motion]\npath = \"keyframes\"\nrate = 2\n\
                         frames = 8\nkeyframes = [{ time = 0 }, { time = 0.25, at = [0.02, 0, 0], easing = \"smooth\" },\n\
                         { time = 0.75, at = [0, 0.01, 0.02], pressure = 0.5, easing = \"hold\" }]\n\
                         [[target]]\nat = [-0.04, 0, 0.1]\n";

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

#[test]
fn keyframes_are_followed_in_time_and_pressure() {
    let folder = folder_with(&[("a.toml", KEYFRAMES)]);
    let text = succeed(folder.path(), &["solve", "a.toml", "--motion", "--json"]);
    let value: Value = serde_json::from_str(&text).unwrap();
    let frames = value["frames"].as_array().unwrap();
    // Computed by hand: linear to the second keyframe, smooth to the third, then constant.
    let half = [0.01, 0.005, 0.01];
    let quarter = |from: f64, to: f64| from + (to - from) * (3.0 / 16.0 - 2.0 / 64.0);
    let wanted = [
        ([0.0, 0.0, 0.0], 1.0),
        ([0.01, 0.0, 0.0], 1.0),
        ([0.02, 0.0, 0.0], 1.0),
        ([quarter(0.02, 0.0), quarter(0.0, 0.01), quarter(0.0, 0.02)], quarter(1.0, 0.5)),
        (half, 0.75),
        ([quarter(0.0, 0.02), quarter(0.01, 0.0), quarter(0.02, 0.0)], quarter(0.5, 1.0)),
        ([0.0, 0.01, 0.02], 0.5),
        ([0.0, 0.01, 0.02], 0.5),
    ];
    assert_eq!(frames.len(), wanted.len());
    for (i, (frame, ([x, y, z], loud))) in frames.iter().zip(wanted).enumerate() {
        let place = numbers(&frame["foci"][0]);
        let there = place.iter().zip([x, y, 0.1 + z]).all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(there, "frame {i}: {place:?}");
        assert_eq!(numbers(&frame["foci"][1]), [-0.04, 0.0, 0.1]);
        // Levelled foci have the prescribed ratio.
        let pressures = numbers(&frame["pressures"]);
        assert!((pressures[0] / pressures[1] / loud - 1.0).abs() < 0.02, "frame {i}: {pressures:?}");
    }
    let bad = KEYFRAMES.replace("time = 0.75", "time = 0.2");
    let folder = folder_with(&[("a.toml", &bad)]);
    let message = refuse(folder.path(), &["solve", "a.toml", "--motion"]);
    assert!(
        message.contains("a.toml:9: target[1].motion.keyframes[3].time = 0.2: must be later"),
        "{message}"
    );
}

#[test]
fn every_frame_is_in_json_and_csv_and_makes_its_stated_pressures() {
    let folder = folder_with(&[("a.toml", SQUARE), ("points.csv", "x,y,z\n-0.03,-0.01,0.1\n")]);
    let text = succeed(folder.path(), &["solve", "a.toml", "--motion", "--json", "--csv", "frames.csv"]);
    let value: Value = serde_json::from_str(&text).unwrap();
    for (key, expected) in [("frames_per_second", 24.0), ("length", 0.08), ("speed", 0.16), ("rate", 2.0)] {
        assert!((value[key].as_f64().unwrap() - expected).abs() < 1e-9, "{key}: {}", value[key]);
    }
    let frames = value["frames"].as_array().unwrap();
    assert_eq!((frames.len(), &value["path"]), (12, &Value::from("square")));
    let weakest = frames.iter().flat_map(|frame| numbers(&frame["pressures"])).fold(f64::INFINITY, f64::min);
    assert_eq!(value["min_pressure"].as_f64(), Some(weakest));

    let csv = fs::read_to_string(folder.path().join("frames.csv")).unwrap();
    let mut lines = csv.lines();
    assert!(lines.next().unwrap().starts_with("frame,time,phase_0,phase_1,"));
    let rows: Vec<Vec<f64>> =
        lines.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    assert_eq!(rows.len(), 12);
    for (index, (row, frame)) in rows.iter().zip(frames).enumerate() {
        assert_eq!(row.len(), 258);
        assert!(row[5].is_nan(), "elements that are off have no phase");
        assert!(
            (row[1] - index as f64 / 24.0).abs() < 1e-12
                && (frame["time"].as_f64().unwrap() - row[1]).abs() < 1e-12
        );
        let phases = numbers(&frame["phases"]);
        assert!((0..256).all(|n| n == 3 || (phases[n] - row[2 + n]).abs() < 1e-12));
    }

    // The first frame's drive, played by another command, gives the stated pressure at the first focus.
    let drive: String = std::iter::once("phase,amplitude\n".to_owned())
        .chain(
            (0..256).map(|n| if n == 3 { "0,0\n".to_owned() } else { format!("{:?},1\n", rows[0][2 + n]) }),
        )
        .collect();
    fs::write(folder.path().join("drive.csv"), drive).unwrap();
    let answer =
        succeed(folder.path(), &["probe", "a.toml", "--points", "points.csv", "--drive", "drive.csv"]);
    let rms: f64 = answer.lines().nth(1).unwrap().split(',').next_back().unwrap().parse().unwrap();
    let said = numbers(&frames[0]["pressures"])[0];
    assert!((rms * 2f64.sqrt() / said - 1.0).abs() < 1e-9, "{rms} and {said}");
}

#[test]
fn the_table_states_speeds_and_boards() {
    let fast = SQUARE.replace("rate = 2", "rate = 4000");
    let folder = folder_with(&[("a.toml", SQUARE), ("fast.toml", &fast)]);
    let table = succeed(folder.path(), &["solve", "a.toml", "--motion"]);
    for part in ["80.0 mm a cycle", "24 frames/s", "SonicSurface", "0.160 m/s; 5 to 8 m/s", "phase per frame"]
    {
        assert!(table.contains(part), "{part}: {table}");
    }
    let output = run(folder.path(), &["solve", "fast.toml", "--motion"]);
    let warning = String::from_utf8(output.stderr).unwrap();
    assert!(
        output.status.success() && warning.contains("48000 frames/s are more than the 40000"),
        "{warning}"
    );
}

/// Position of the brightest pixel from the top left.
fn brightest(rgb: &image::RgbImage) -> (u32, u32) {
    let light = |pixel: &image::Rgb<u8>| pixel.0.iter().map(|&v| u32::from(v)).sum::<u32>();
    let (x, y, _) = rgb.enumerate_pixels().max_by_key(|(.., pixel)| light(pixel)).unwrap();
    (x, y)
}

#[test]
fn animations_show_the_moving_focus_on_one_colour_scale() {
    let folder = folder_with(&[("a.toml", STEPS)]);
    let args = |output| ["render", "a.toml", "--motion", "-o", output, "--size", "100", "--colours", "grey"];
    for (output, count) in [("a.gif", 4), ("a.png", 4), ("a.apng", 4), ("frames/", 4)] {
        let said = succeed(folder.path(), &args(output));
        assert!(said.contains(&format!("{count} frames of 100 x 100 pixels")), "{said}");
        assert!(said.contains("a cycle takes 1.000 s, and so it does here"), "{said}");
    }
    let bytes = fs::read(folder.path().join("a.png")).unwrap();
    assert_eq!(bytes, fs::read(folder.path().join("a.apng")).unwrap());
    let decoder = image::codecs::png::PngDecoder::new(std::io::Cursor::new(bytes)).unwrap();
    let frames: Vec<image::RgbImage> = image::AnimationDecoder::into_frames(decoder.apng().unwrap())
        .map(|frame| image::DynamicImage::from(frame.unwrap().into_buffer()).to_rgb8())
        .collect();
    let mut gif = gif_frames(&folder.path().join("a.gif"));
    assert_eq!((frames.len(), gif.len()), (4, 4));
    let mut peaks = Vec::new();
    for (index, frame) in frames.iter().enumerate() {
        let path = folder.path().join(format!("frames/a-{}.png", index + 1));
        assert_eq!(&image::open(path).unwrap().to_rgb8(), frame);
        assert_eq!(gif.remove(0), frame.as_raw()[..], "frame {index} of the GIF");
        let (x, y) = brightest(frame);
        // 2 mm per pixel, y upwards.
        let (wanted_x, wanted_y) = if index < 2 { (35, 50) } else { (65, 45) };
        assert!(x.abs_diff(wanted_x) <= 1 && y.abs_diff(wanted_y) <= 1, "frame {index}: {x}, {y}");
        peaks.push(frame.get_pixel(x, y)[0]);
    }
    assert!(peaks.contains(&255) && peaks.iter().any(|&peak| peak < 255), "one range for all: {peaks:?}");
}

/// r, g, b of every frame.
fn gif_frames(path: &Path) -> Vec<Vec<u8>> {
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut decoder = options.read_info(fs::File::open(path).unwrap()).unwrap();
    let mut frames = Vec::new();
    while let Some(frame) = decoder.read_next_frame().unwrap() {
        frames.push(frame.buffer.chunks(4).flat_map(|pixel| pixel[..3].to_vec()).collect());
    }
    frames
}

/// Two foci along a square, a point at rest, and a target with its own motion.
const OUTLINE: &str = "format = 1\n[[target]]\nkind = \"rectangle\"\n[[target]]\nat = [0, 0, 0.1]\n\
                       [[target]]\nat = [-0.06, 0, 0.1]\n[target.motion]\npath = \"circle\"\nsize = 0.02\nrate = 90\n\
                       [motion]\npath = \"outline\"\nfoci = 2\nframes = 16\n";

#[test]
fn foci_run_along_drawn_strokes() {
    let folder = folder_with(&[("a.toml", OUTLINE)]);
    let output = run(folder.path(), &["solve", "a.toml", "--motion", "--json"]);
    let warning = String::from_utf8(output.stderr).unwrap();
    assert!(warning.contains("target 3 makes 75.000 rounds per second instead of 90.000"), "{warning}");
    let value: Value = serde_json::from_slice(&output.stdout).unwrap();
    for (key, expected) in [("rate", 37.5), ("length", 0.16), ("speed", 6.0), ("frames_per_second", 600.0)] {
        assert!((value[key].as_f64().unwrap() - expected).abs() < 1e-9, "{key}: {}", value[key]);
    }
    let own = &value["own_motions"][0];
    assert_eq!((own["target"].as_u64(), own["rounds"].as_u64()), (Some(2), Some(2)));
    assert_eq!((own["rate"].as_f64(), own["asked_rate"].as_f64()), (Some(75.0), Some(90.0)));
    for frame in value["frames"].as_array().unwrap() {
        let foci: Vec<_> = frame["foci"].as_array().unwrap().iter().map(numbers).collect();
        assert_eq!((foci.len(), &foci[0]), (4, &vec![0.0, 0.0, 0.1]));
        assert!(((foci[1][0] + 0.06).hypot(foci[1][1]) - 0.01).abs() < 1e-9);
        let (a, b) = (&foci[2], &foci[3]);
        assert!((a[0].abs().max(a[1].abs()) - 0.02).abs() < 1e-9, "{a:?}");
        assert!((a[0] + b[0]).abs() < 1e-9 && (a[1] + b[1]).abs() < 1e-9, "{a:?} and {b:?}");
    }
    let table = succeed(folder.path(), &["solve", "a.toml", "--motion"]);
    for part in
        ["160.0 mm a cycle", "37.5 cycles/s of 16", "target 3: circle, 62.8 mm, 2 times a cycle: 75 Hz"]
    {
        assert!(table.contains(part), "{part}: {table}");
    }
}

#[test]
fn the_mean_over_running_foci_is_the_shape() {
    let scene = OUTLINE.split("[[target]]\nat").next().unwrap();
    for foci in [1, 4] {
        let text = format!("{scene}[motion]\npath = \"outline\"\nfoci = {foci}\n");
        let folder = folder_with(&[("a.toml", &text)]);
        let args =
            ["render", "a.toml", "--frame", "mean", "-o", "a.png", "--size", "100", "--colours", "grey"];
        succeed(folder.path(), &args);
        let picture = image::open(folder.path().join("a.png")).unwrap().to_rgb8();
        // 2 mm per pixel: the sides are 10 pixels from the middle.
        let light = |x: u32, y: u32| f64::from(picture.get_pixel(x, y)[0]);
        let sides: Vec<_> =
            (42..58).flat_map(|i| [light(i, 40), light(i, 60), light(40, i), light(60, i)]).collect();
        let mean = sides.iter().sum::<f64>() / sides.len() as f64;
        assert!(sides.iter().all(|side| (side / mean - 1.0).abs() < 0.25), "{foci}: {sides:?}");
        for (x, y) in [(50, 50), (50, 70), (30, 30), (70, 50)] {
            assert!(
                light(x, y) < 0.4 * mean,
                "{foci} foci: {} at {x}, {y}, {mean} along the sides",
                light(x, y)
            );
        }
    }
}

#[test]
fn animations_too_fast_for_viewers_are_slowed_down_and_say_so() {
    let folder = folder_with(&[("a.toml", &SQUARE.replace("rate = 2", "rate = 50"))]);
    let args = ["render", "a.toml", "--motion", "-o", "a.gif", "--size", "32", "--quantity", "phase"];
    let said = succeed(folder.path(), &args);
    assert!(said.contains("a cycle takes 0.020 s, shown slowed down 12.0 x"), "{said}");
    assert!(!said.contains("RMS"), "a map of phases has no range: {said}");
}

#[test]
fn a_still_of_steps_shows_the_first() {
    let folder = folder_with(&[("a.toml", STEPS)]);
    succeed(folder.path(), &["render", "a.toml", "-o", "still.png", "--size", "100"]);
    let still = image::open(folder.path().join("still.png")).unwrap().to_rgb8();
    assert!(brightest(&still).0.abs_diff(35) <= 1);
    let solved = succeed(folder.path(), &["solve", "a.toml", "--json"]);
    let value: Value = serde_json::from_str(&solved).unwrap();
    assert_eq!(value["foci"].as_array().unwrap().len(), 1);
}

#[test]
fn a_scene_at_rest_is_one_frame_with_a_note() {
    let folder = folder_with(&[("a.toml", "format = 1\n[[target]]\n")]);
    let output = run(folder.path(), &["render", "a.toml", "--motion", "-o", "a.gif", "--size", "16"]);
    let (said, noted) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success() && said.contains("1 frame of 16 x 16"), "{said}{noted}");
    assert!(noted.contains("nothing moves"), "{noted}");
}

#[test]
fn bad_motion_is_refused_with_file_line_and_value() {
    let motion = |text: &str| format!("format = 1\n[[target]]\nat = [0, 0, 0.01]\n[motion]\n{text}\n");
    for (text, parts) in [
        (motion("path = \"spiral\""), &["bad.toml:5", "spiral", "figure-eight"][..]),
        (
            motion("path = \"points\"\npoints = [[0, 0, -0.02]]"),
            &["bad.toml:6", "in frame 1 of 64", "behind"],
        ),
        (motion("sizes = 1"), &["bad.toml:5", "sizes"]),
    ] {
        let folder = folder_with(&[("bad.toml", &text)]);
        for args in
            [&["render", "bad.toml", "--motion", "-o", "a.gif"][..], &["solve", "bad.toml", "--motion"]]
        {
            let message = refuse(folder.path(), args);
            for part in parts {
                assert!(message.contains(part), "{text}: {message}");
            }
        }
    }
}

#[test]
fn bad_arguments_are_refused() {
    let folder = folder_with(&[("a.toml", SQUARE), ("file", "")]);
    let render = |rest: &[&'static str]| [&["render", "a.toml", "--motion", "-o"][..], rest].concat();
    for (args, part) in [
        (render(&["a.avi"]), "a.avi: an animation is written as FILE.gif"),
        (render(&["a"]), "FOLDER/"),
        (render(&["no/a.gif"]), "no/a.gif: cannot write"),
        (render(&["file/"]), "cannot make the folder"),
        (render(&["a.gif", "--size", "70000x2"]), "65535"),
        (render(&["a.gif", "--quantity", "sheet"]), "rms, phase, radiation, depression"),
        (render(&["a.gif", "--data", "a.npy"]), "--data"),
        (render(&["a.gif", "--method", "focus"]), "2"),
        (vec!["render", "a.toml", "a.toml", "--motion", "-o", "a.gif"], "2 are given"),
        (vec!["solve", "a.toml", "--motion", "--method", "all"], "name one method"),
        (vec!["solve", "a.toml", "--motion", "--levels", "16"], "--levels"),
        (vec!["solve", "a.toml", "--motion", "--csv", "no/a.csv"], "no/a.csv"),
    ] {
        let message = refuse(folder.path(), &args);
        assert!(message.contains(part), "{args:?}: {message}");
    }
}

/// A focus on a circle of 20 mm at 6.28 m/s.
const CIRCLE: &str = "format = 1\n[array]\nresponse = \"t4010a1\"\n[[target]]\nat = [0, 0, 0.1]\n[plane]\nsize = [0.04, 0.04]\n\
                      [motion]\npath = \"circle\"\nsize = 0.02\nrate = 100\nframes = 100\n";

#[test]
fn a_response_is_told_refused_by_line_and_absent() {
    let plain = CIRCLE.replace("response = \"t4010a1\"\n", "");
    let bad = CIRCLE.replace("t4010a1", "t4010");
    let slow = CIRCLE.replace("\"t4010a1\"", "{ resonance = 39789, tau = 0.2 }");
    let folder =
        folder_with(&[("a.toml", CIRCLE), ("plain.toml", &plain), ("bad.toml", &bad), ("slow.toml", &slow)]);
    let solve = |more: &[&str]| succeed(folder.path(), &[&["solve"], more].concat());
    let value: Value = serde_json::from_str(&solve(&["a.toml", "--motion", "--json"])).unwrap();
    let kept = value["response"]["kept"].as_f64().unwrap();
    assert!((kept - 0.933).abs() < 0.003, "{kept}");
    // A solution at rest tells of the motion, too, and so does a batch.
    let value: Value = serde_json::from_str(&solve(&["a.toml", "--json"])).unwrap();
    assert_eq!(value["response"]["kept"].as_f64(), Some(kept));
    let told = solve(&["a.toml", "--motion"]);
    assert!(told.contains("pressure kept           93.") && told.contains("deepest dip"), "{told}");
    let value: Value = serde_json::from_str(&solve(&["plain.toml", "--motion", "--json"])).unwrap();
    assert!(value.get("response").is_none());
    let message = refuse(folder.path(), &["solve", "bad.toml"]);
    assert!(message.contains("bad.toml:3") && message.contains("t4010a1"), "{message}");
    let message = refuse(folder.path(), &["solve", "slow.toml"]);
    assert!(message.contains("slow.toml:3: array.response.tau = 0.2: must be a number from"), "{message}");
}

#[test]
fn a_map_of_a_motion_keeps_what_its_foci_keep() {
    // On the axis of a circling focus every frame has the same |p|; the mean of the response is below it.
    let plain = CIRCLE.replace("response = \"t4010a1\"\n", "");
    let folder =
        folder_with(&[("a.toml", CIRCLE), ("plain.toml", &plain), ("at.csv", "x,y,z\n0.01,0,0.1\n")]);
    let probed = |name: &str| {
        let text =
            succeed(folder.path(), &["probe", name, "--points", "at.csv", "--time", "--rate", "100000"]);
        let squares =
            text.lines().skip(1).map(|line| line.rsplit(',').next().unwrap().parse::<f64>().unwrap());
        let squares: Vec<_> = squares.collect();
        squares.iter().sum::<f64>() / squares.len() as f64
    };
    let mapped = |name: &str| {
        let out = format!("{name}.npy");
        let size = ["--size", "81x81", "--quantity", "radiation", "--tolerance", "exact"];
        let files = ["render", name, "-o", "a.png", "--data", &out];
        succeed(folder.path(), &[&files[..], &size].concat());
        fs::read(folder.path().join(out)).unwrap()
    };
    let ratio = probed("a.toml") / probed("plain.toml");
    assert!(ratio < 0.99 && ratio > 0.5, "{ratio}");
    let sums = ["a.toml", "plain.toml"].map(|name| {
        let bytes = mapped(name);
        let values = bytes[bytes.len() - 4 * 81 * 81..].chunks_exact(4);
        values.map(|value| f64::from(f32::from_le_bytes(value.try_into().unwrap()))).sum::<f64>()
    });
    assert!(sums[0] < 0.99 * sums[1], "{sums:?}");
}

/// A focus that follows a file.
fn following(file: &str) -> String {
    format!(
        "format = 1\n[[target]]\nat = [0, 0, 0.12]\n[solver]\nmethod = \"focus\"\n[motion]\npath = \"file\"\nfile = \"{file}\"\n"
    )
}

/// Places (m) of the focus in every frame, and cycles per second.
fn followed(file: &str, content: &str) -> (Vec<Vec<f64>>, f64) {
    let folder = folder_with(&[("a.toml", &following(file)), (file, content)]);
    let text = succeed(folder.path(), &["solve", "a.toml", "--motion", "--json"]);
    let value: Value = serde_json::from_str(&text).unwrap();
    let frames = value["frames"].as_array().unwrap();
    let places = frames.iter().map(|frame| numbers(&frame["foci"][0])).collect();
    (places, value["rate"].as_f64().unwrap())
}

#[test]
fn paths_of_files_are_followed() {
    let row = |i: u32| format!("{},{},0,0.1\n", f64::from(i) * 0.02, f64::from(i) * 1e-3 - 0.02);
    let rows: String = (0..=40).map(row).collect();
    let (places, rate) = followed("there.csv", &rows);
    assert!(places.len() == 80 && (rate - 1.0 / 1.6).abs() < 1e-9, "{} frames, {rate} Hz", places.len());
    for (i, place) in places.iter().enumerate() {
        let x = if i <= 40 { i as f64 * 1e-3 - 0.02 } else { (80 - i) as f64 * 1e-3 - 0.02 };
        assert!((place[0] - x).abs() < 1e-9 && place[2] == 0.1, "{i}: {place:?}");
    }
    // A circle at 100 mm/s, at the target's height.
    let (places, rate) = followed("round.nc", "G0 X20 Y0\nG3 X20 Y0 I-20 J0 F6000\n");
    assert!((rate - 0.1 / (std::f64::consts::TAU * 0.02)).abs() < 1e-4, "{rate} Hz");
    for (i, place) in places.iter().enumerate() {
        let (sin, cos) = (std::f64::consts::TAU * i as f64 / places.len() as f64).sin_cos();
        let off = f64::hypot(place[0] - 0.02 * cos, place[1] - 0.02 * sin);
        assert!(off < 5e-6 && place[2] == 0.12, "{i}: {place:?}");
    }
    for (file, content, message) in [
        (
            "a.csv",
            "x,y,z\n0,0,0.1\n0,0,wide\n",
            "a.toml:8: motion.file = \"a.csv\": a.csv:3: z = `wide`: not a finite number",
        ),
        ("a.nc", "G1 X1\nG5 X2 I1\n", "a.toml:8: motion.file = \"a.nc\": a.nc:2: G5 is not read"),
        ("a.csv", "x,y,z\n0,0,0.1\n0.01,0,-0.1\n", "a.toml:8: motion.file = \"a.csv\": in frame"),
        (
            "a.csv",
            "x1,y1,x2,y2\n0,0,0,0.01\n0.01,0,0,0.02\n",
            "it has a path of target 2, and the scene has 1",
        ),
    ] {
        let folder = folder_with(&[("a.toml", &following(file)), (file, content)]);
        let said = refuse(folder.path(), &["solve", "a.toml", "--motion"]);
        assert!(said.contains(message), "{said}");
    }
    let folder = folder_with(&[("a.toml", &following("gone.csv"))]);
    assert!(
        refuse(folder.path(), &["solve", "a.toml"])
            .contains("a.toml:8: motion.file = \"gone.csv\": gone.csv: ")
    );
}
