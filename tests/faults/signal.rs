//! Programs ended by signals: files are the old or the whole new ones, and no temporary files remain.

use std::fs;
use std::io::BufRead;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

use crate::{Running, folder, listing, program, succeed};

const FILM: [&str; 7] = ["render", "a.toml", "--motion", "-o", "x.png", "--size", "200"];

fn start(folder: &Path, args: &[&str]) -> Running {
    Running(program(folder, args).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap())
}

/// Irregular fractions of 1.
fn scattered(count: u32) -> impl Iterator<Item = f64> {
    (1..=count).map(|n| (f64::from(n) * 0.618_033_988_749_895).fract())
}

fn frames(path: &Path) -> usize {
    let file = std::io::BufReader::new(fs::File::open(path).unwrap());
    let decoder = image::codecs::png::PngDecoder::new(file).unwrap();
    image::AnimationDecoder::into_frames(decoder.apng().unwrap()).map(Result::unwrap).count()
}

#[test]
fn a_killed_program_leaves_the_old_or_the_whole_new_file() {
    let folder = folder();
    let path = folder.path().join("x.png");
    let begun = Instant::now();
    succeed(&mut program(folder.path(), &FILM));
    let lasts = begun.elapsed();
    assert_eq!(frames(&path), 6);
    let mut killed = 0;
    for (part, signal) in
        scattered(12).zip(["KILL", "TERM", "KILL", "INT", "KILL", "HUP"].into_iter().cycle())
    {
        fs::write(&path, "old").unwrap();
        let mut film = start(folder.path(), &FILM);
        std::thread::sleep(lasts.mul_f64(part));
        film.signal(signal);
        killed += usize::from(film.ended().signal().is_some());
        assert!(
            fs::read(&path).unwrap() == b"old" || frames(&path) == 6,
            "SIG{signal} at {part} of {lasts:?}"
        );
        assert_eq!(listing(folder.path()), ["a.toml", "x.png"], "SIG{signal} at {part} of {lasts:?}");
    }
    assert!(killed > 0, "every run ended before its signal");
}

#[test]
fn a_new_file_is_whole_or_missing() {
    let folder = folder();
    let path = folder.path().join("x.csv");
    let args = ["solve", "a.toml", "--motion", "--csv", "x.csv"];
    let begun = Instant::now();
    succeed(&mut program(folder.path(), &args));
    let lasts = begun.elapsed();
    let whole = fs::read(&path).unwrap();
    for part in scattered(16) {
        fs::remove_file(&path).ok();
        let solve = start(folder.path(), &args);
        std::thread::sleep(lasts.mul_f64(part));
        drop(solve);
        assert!(fs::read(&path).is_ok_and(|bytes| bytes == whole) || !path.exists());
        assert!(listing(folder.path()).iter().all(|name| ["a.toml", "x.csv"].contains(&name.as_str())));
    }
}

#[test]
fn a_signal_ends_a_solve_of_hours() {
    let folder = folder();
    let slow = "format = 1\n[[target]]\nkind = \"circle\"\nat = [0, 0, 0.1]\nradius = 0.05\npoints = 100\n\
                [solver]\nmethod = \"greedy\"\niterations = 100000\n";
    fs::write(folder.path().join("slow.toml"), slow).unwrap();
    let board = ["--port", "virtual:sonicsurface", "--profile", "sonicsurface"];
    let send: &[_] = &["send", "slow.toml"];
    let serve: &[_] = &["serve", "slow.toml", "--osc", "0"];
    for (command, begun, signal, status) in
        [(send, "frames/s", "INT", 0), (send, "frames/s", "TERM", 0), (serve, "silent until", "HUP", 0)]
    {
        let mut command = program(folder.path(), &[command, &board].concat());
        let mut run = Running(command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap());
        let mut said = std::io::BufReader::new(run.0.stderr.take().unwrap()).lines();
        assert!(said.any(|line| line.unwrap().contains(begun)), "{signal}: never ready");
        // The board is found and the solver works.
        std::thread::sleep(Duration::from_millis(300));
        run.signal(signal);
        assert_eq!(run.ended().code(), Some(status), "{signal}");
    }
}

#[test]
fn a_batch_ends_on_a_closed_pipe_or_a_signal() {
    let folder = folder();
    let lines = |name: &str| {
        fs::write(folder.path().join(name), "{\"target\": [{}]}\n".repeat(20_000)).unwrap();
        fs::File::open(folder.path().join(name)).unwrap()
    };
    let mut batch = program(folder.path(), &["batch", "--no-limits"]);
    let mut batch =
        Running(batch.stdin(lines("lines")).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap());
    drop(batch.0.stdout.take());
    let status = batch.ended();
    assert_eq!(status.code(), Some(0), "a closed pipe is no error");
    let mut batch = program(folder.path(), &["batch", "--no-limits", "--data", "out", "--size", "64"]);
    let mut batch = Running(batch.stdin(lines("lines")).stdout(Stdio::null()).spawn().unwrap());
    let out = folder.path().join("out");
    crate::eventually("the first answer", || out.exists() && listing(&out).len() > 3);
    batch.signal("TERM");
    assert!(!batch.ended().success());
    let written = listing(&out);
    assert!(written.len() < 20_000, "not interrupted before the last line");
    for name in written {
        let bytes = fs::read(out.join(&name)).unwrap();
        assert_eq!(
            npyz::NpyFile::new(&bytes[..]).unwrap().into_vec::<f32>().unwrap().len(),
            64 * 64,
            "{name}"
        );
    }
}
