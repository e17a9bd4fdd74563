//! Films: videos decoded by ffmpeg, shaded surfaces, frame rates, and a missing or failing ffmpeg.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use image::RgbImage;
use tempfile::TempDir;

/// A focus that alternates between left and right.
const STEPS: &str = "format = 1\n[[target]]\nat = [-0.03, 0, 0.1]\nstep = 0\n[[target]]\nat = [0.03, 0.01, 0.1]\n\
                     step = 1\n[solver]\nmethod = \"focus\"\n[motion]\npath = \"steps\"\nrate = 1\nframes = 4\n";
const WATER: &str = "format = 1\n[[target]]\nat = [0, 0, 0.1]\n[solver]\nmethod = \"focus\"\n\
                     [plane]\nsize = [0.06, 0.05]\n";

fn folder(scene: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.toml"), scene).unwrap();
    folder
}

fn program(folder: &Path, args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sonoglyph"));
    command.args(["render", "a.toml", "--backend", "cpu", "-o"]).args(args).current_dir(folder);
    command
}

fn said(output: &Output) -> (Option<i32>, String) {
    let both = [&output.stdout[..], &output.stderr].concat();
    (output.status.code(), String::from_utf8(both).unwrap())
}

fn render(folder: &Path, args: &[&str]) -> String {
    let (status, said) = said(&program(folder, args).output().unwrap());
    assert_eq!(status, Some(0), "{args:?}: {said}");
    said
}

/// The message of a run that fails without leaving a file.
fn refused(mut command: Command, folder: &Path) -> String {
    let names = || {
        let mut names: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
        names.sort();
        names
    };
    let before = names();
    let (status, said) = said(&command.output().unwrap());
    assert_eq!((status, said.contains("panicked")), (Some(2), false), "{said}");
    assert_eq!(names(), before, "{said}");
    said
}

fn ffmpeg() -> Option<()> {
    let runs = Command::new("ffmpeg").arg("-version").output().and(Command::new("ffprobe").output());
    crate::requirement::found("video", runs.map(drop))
}

/// ffprobe's description of a video, and its decoded frames.
fn decoded(path: &Path) -> (String, Vec<RgbImage>) {
    let entries = "stream=codec_name,width,height,pix_fmt,r_frame_rate,nb_read_frames";
    let args = ["-v", "error", "-count_frames", "-show_entries", entries, "-of", "csv=p=0"];
    let probe = Command::new("ffprobe").args(args).arg(path).output().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let status = Command::new("ffmpeg")
        .args(["-v", "error", "-i"])
        .arg(path)
        .arg(folder.path().join("%02d.png"))
        .status()
        .unwrap();
    assert!(status.success());
    let frame =
        |number: usize| image::open(folder.path().join(format!("{number:02}.png"))).unwrap().to_rgb8();
    let count = fs::read_dir(folder.path()).unwrap().count();
    (String::from_utf8(probe.stdout).unwrap().trim().to_owned(), (1..=count).map(frame).collect())
}

/// Mean over all channels of all pixels.
fn mean_difference(a: &RgbImage, b: &RgbImage) -> f64 {
    assert_eq!(a.dimensions(), b.dimensions());
    let sum: u64 = a.iter().zip(b.iter()).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    sum as f64 / a.len() as f64
}

#[test]
fn a_video_has_the_frames_of_the_pictures_and_the_requested_rate() {
    let Some(()) = ffmpeg() else { return };
    let folder = folder(STEPS);
    let at = |name: &str| folder.path().join(name);
    // Odd sides are made even.
    render(folder.path(), &["frames/", "--motion", "--size", "120x102"]);
    let pictures: Vec<_> =
        (1..=4).map(|i| image::open(at(&format!("frames/a-{i}.png"))).unwrap().to_rgb8()).collect();
    for (name, codec) in [("a.mp4", "h264"), ("a.webm", "vp9")] {
        let said = render(folder.path(), &[name, "--motion", "--size", "119x101", "--fps", "12"]);
        assert!(
            said.contains("4 frames of 120 x 102 pixels") && said.contains("shown 3.0 x as fast"),
            "{said}"
        );
        let (probed, frames) = decoded(&at(name));
        assert_eq!(probed, format!("{codec},120,102,yuv420p,12/1,4"));
        assert_eq!(frames.len(), 4);
        for (frame, picture) in frames.iter().zip(&pictures) {
            // Chroma has half the resolution, and dark areas have little of it.
            let off = mean_difference(frame, picture);
            assert!(off < 3.0, "{name}: {off}");
        }
        assert!(mean_difference(&frames[0], &pictures[2]) > 6.0, "the frames differ");
    }
    let said = render(folder.path(), &["b.mp4", "--motion", "--size", "64"]);
    assert!(said.contains("a cycle takes 1.000 s, and so it does here"), "{said}");
    assert!(decoded(&at("b.mp4")).0.ends_with(",4/1,4"));
}

#[test]
fn rates_hold_for_all_formats_up_to_the_limit_of_viewers() {
    let folder = folder(STEPS);
    render(folder.path(), &["a.gif", "--motion", "--size", "32", "--fps", "25"]);
    let file = fs::File::open(folder.path().join("a.gif")).unwrap();
    let mut decoder = gif::DecodeOptions::new().read_info(file).unwrap();
    let mut delays = Vec::new();
    while let Some(frame) = decoder.read_next_frame().unwrap() {
        delays.push(frame.delay);
    }
    assert_eq!(delays, [4; 4]);
    let refuse = |args: &[&str]| refused(program(folder.path(), args), folder.path());
    assert!(refuse(&["b.gif", "--motion", "--fps", "60"]).contains("at most 50"));
    assert!(refuse(&["b.mp4", "--motion", "--fps", "0"]).contains("frames per second"));
    assert!(refuse(&["b.png", "--fps", "25"]).contains("--motion or --waves"));
    assert!(refuse(&["b.mp4", "--motion", "--size", "9000x2"]).contains("8192"));
}

#[test]
fn shaded_waves_share_one_scale_of_depths_in_files_of_every_kind() {
    let folder = folder(WATER);
    let waves = |output: &str, more: &[&str]| {
        let args = ["--quantity", "depression", "--view", "shaded", "--waves", "--seconds", "0.025"];
        render(folder.path(), &[&[output][..], &args, &["--size", "320x240"], more].concat())
    };
    assert!(waves("frames/", &[]).contains("10 frames of 320 x 240 pixels"));
    let pictures: Vec<_> = (1..=10)
        .map(|i| image::open(folder.path().join(format!("frames/a-{i:02}.png"))).unwrap().to_rgb8())
        .collect();
    // Pixels that differ from level water, below the caption and above the front edge.
    let rough = |picture: &RgbImage| {
        let level = picture.get_pixel(90, 190)[1];
        let water = (80..200).flat_map(|y| (80..240).map(move |x| (x, y)));
        water.filter(|&(x, y)| picture.get_pixel(x, y)[1].abs_diff(level) > 8).count()
    };
    let (first, last) = (rough(&pictures[0]), rough(&pictures[9]));
    assert!(
        last > 500 && first < last / 4,
        "{first} {last}: with its own scale the first frame would be rough"
    );
    waves("a.png", &[]);
    let file = std::io::BufReader::new(fs::File::open(folder.path().join("a.png")).unwrap());
    let decoder = image::codecs::png::PngDecoder::new(file).unwrap();
    let frames = image::AnimationDecoder::into_frames(decoder.apng().unwrap());
    for (frame, picture) in frames.zip(&pictures) {
        assert_eq!(&image::DynamicImage::from(frame.unwrap().into_buffer()).to_rgb8(), picture);
    }
    waves("a.gif", &[]);
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut decoder = options.read_info(fs::File::open(folder.path().join("a.gif")).unwrap()).unwrap();
    for picture in &pictures {
        let frame = decoder.read_next_frame().unwrap().unwrap();
        let rgb = frame.buffer.chunks(4).flat_map(|pixel| pixel[..3].to_vec()).collect();
        let off = mean_difference(&RgbImage::from_raw(320, 240, rgb).unwrap(), picture);
        assert!(off < 2.0, "quantised to 256 colours: {off}");
    }
    if let Some(()) = ffmpeg() {
        waves("a.mp4", &["--fps", "20"]);
        let (probed, frames) = decoded(&folder.path().join("a.mp4"));
        assert_eq!(probed, "h264,320,240,yuv420p,20/1,10");
        assert!(mean_difference(&frames[9], &pictures[9]) < 3.0);
    }
    let args = ["b.gif", "--motion", "--view", "shaded"];
    let message = refused(program(folder.path(), &args), folder.path());
    assert!(message.contains("--quantity depression"), "{message}");
}

/// A folder with a program `ffmpeg` made of this script.
fn pretended(script: &str) -> (TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ffmpeg");
    fs::write(&path, format!("#!/bin/sh\n{script}\n")).unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
    let search = format!("{}:{}", folder.path().display(), std::env::var("PATH").unwrap());
    (folder, search)
}

#[test]
fn a_missing_or_failing_ffmpeg_is_an_error_and_keeps_the_old_file() {
    let folder = folder(STEPS);
    fs::write(folder.path().join("a.mp4"), "old").unwrap();
    let film = |search: &str| {
        let mut command = program(folder.path(), &["a.mp4", "--motion", "--size", "64"]);
        command.env("PATH", search);
        refused(command, folder.path())
    };
    let empty = tempfile::tempdir().unwrap();
    let message = film(&empty.path().display().to_string());
    assert!(
        message.contains("a.mp4: videos need the program `ffmpeg`") && message.contains("GIF"),
        "{message}"
    );
    let (_own, search) = pretended("printf 'first\\n\\nUnknown encoder \\033[31mlibx264\\n' >&2; exit 1");
    let message = film(&search);
    assert!(message.contains("a.mp4: ffmpeg says: first; Unknown encoder \\u{1b}[31mlibx264"), "{message}");
    // It accepts the blank frame of the trial run, and fails in the real one.
    let (own, search) =
        pretended("cd \"${0%/*}\"; [ -e tried ] || exec cat > tried; echo 'no room' >&2; exit 3");
    let message = film(&search);
    assert!(own.path().join("tried").exists() && message.contains("ffmpeg says: no room"), "{message}");
    assert_eq!(fs::read(folder.path().join("a.mp4")).unwrap(), b"old");
}

#[test]
fn an_interrupted_film_ends_its_ffmpeg() {
    let folder = folder(&STEPS.replace("frames = 4", "frames = 2000"));
    let (own, search) = pretended("echo $$ >> \"${0%/*}/pids\"; exec cat > /dev/null");
    let mut command = program(folder.path(), &["a.mp4", "--motion", "--size", "300"]);
    let mut film = command.env("PATH", search).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let eventually = |what: &str, condition: &dyn Fn() -> bool| {
        let start = Instant::now();
        while !condition() {
            assert!(start.elapsed() < Duration::from_secs(60), "timed out waiting for {what}");
            std::thread::sleep(Duration::from_millis(5));
        }
    };
    let pids = || -> Vec<u32> {
        let text = fs::read_to_string(own.path().join("pids")).unwrap_or_default();
        text.lines().map(|line| line.parse().unwrap()).collect()
    };
    // The first one is the trial run.
    eventually("the second ffmpeg", &|| pids().len() == 2);
    let signal = Command::new("kill").args(["-TERM", &film.id().to_string()]).status().unwrap();
    assert!(signal.success() && !film.wait().unwrap().success());
    let is_there =
        |pid: u32| Command::new("kill").args(["-0", &pid.to_string()]).stderr(Stdio::null()).status();
    eventually("the end of ffmpeg", &|| pids().into_iter().all(|pid| !is_there(pid).unwrap().success()));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}
