//! Programs that are ended in the middle of their work: files are the old ones or the whole new ones, and nothing is left over.

use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::Stdio;
use std::time::Instant;

use crate::{Running, folder, listing, program, succeed};

const FILM: [&str; 7] = ["render", "a.toml", "--motion", "-o", "x.png", "--size", "200"];

fn start(folder: &Path, args: &[&str]) -> Running {
    Running(program(folder, args).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap())
}

/// Parts of a whole without pattern.
fn scattered(count: u32) -> impl Iterator<Item = f64> {
    (1..=count).map(|n| (f64::from(n) * 0.618_033_988_749_895).fract())
}

fn frames(path: &Path) -> usize {
    let file = std::io::BufReader::new(fs::File::open(path).unwrap());
    let decoder = image::codecs::png::PngDecoder::new(file).unwrap();
    image::AnimationDecoder::into_frames(decoder.apng().unwrap()).map(Result::unwrap).count()
}

#[test]
fn a_program_that_is_killed_leaves_the_old_file_or_the_whole_new_one_and_no_other() {
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
    assert!(killed > 0, "every one was done before its signal came");
}

#[test]
fn a_new_file_is_there_whole_or_not_at_all() {
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
fn a_batch_ends_when_nobody_reads_its_answers_or_a_signal_comes() {
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
    assert_eq!(status.code(), Some(0), "no reader is no error");
    let mut batch = program(folder.path(), &["batch", "--no-limits", "--data", "out", "--size", "64"]);
    let mut batch = Running(batch.stdin(lines("lines")).stdout(Stdio::null()).spawn().unwrap());
    let out = folder.path().join("out");
    crate::eventually("the first answer", || out.exists() && listing(&out).len() > 3);
    batch.signal("TERM");
    assert!(!batch.ended().success());
    let written = listing(&out);
    assert!(written.len() < 20_000, "it went on to the last line");
    for name in written {
        let bytes = fs::read(out.join(&name)).unwrap();
        assert_eq!(
            npyz::NpyFile::new(&bytes[..]).unwrap().into_vec::<f32>().unwrap().len(),
            64 * 64,
            "{name}"
        );
    }
}
