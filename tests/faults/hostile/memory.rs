//! Tables beyond memory, the memory of motions, and estimates of long steps.

use std::fs::{self, File};
use std::io::{BufRead, BufReader};
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Child, Stdio};
use std::time::Duration;

use serde_json::Value;

use crate::hostile::{folder_with, refused};
use crate::{program, program_after};

/// KiB of writable memory.
const HALF_A_GIBIBYTE: &str = "ulimit -d 524288";

/// A line of a batch with this number of elements per side, and of foci.
fn line(side: usize, foci: usize) -> String {
    let target =
        |i: usize| format!(r#"{{"at": [{}, {}, 0.5]}}"#, (i % 32) as f64 * 0.02, (i / 32) as f64 * 0.02);
    let targets: Vec<_> = (0..foci).map(target).collect();
    let array = format!(r#"{{"rows": {side}, "columns": {side}}}"#);
    format!(r#"{{"array": {array}, "solver": {{"method": "naive"}}, "target": [{}]}}"#, targets.join(", "))
        + "\n"
}

#[test]
fn a_batch_line_beyond_memory_is_answered_and_others_continue() {
    let lines = [line(4, 2), line(256, 1024), line(4, 3), line(256, 1024), line(4, 4)].concat();
    let folder = folder_with(&[("lines", &lines)]);
    for threads in ["1", "3"] {
        let args = ["batch", "--threads", threads];
        let mut batch = program_after(HALF_A_GIBIBYTE, folder.path(), &args);
        let output = batch.stdin(File::open(folder.path().join("lines")).unwrap()).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let answers: Vec<Value> = output
            .stdout
            .split(|&c| c == b'\n')
            .filter_map(|line| serde_json::from_slice(line).ok())
            .collect();
        assert_eq!(answers.len(), 5);
        for (index, answer) in answers.iter().enumerate() {
            let error = answer["error"].as_str().unwrap_or_default();
            let is_large = index % 2 == 1;
            assert_eq!(
                error.contains("65536 elements and 1024 foci need about"),
                is_large,
                "{index}: {error}"
            );
            assert_eq!(answer["foci"].is_array(), !is_large);
        }
    }
}

#[test]
fn a_scene_beyond_memory_is_refused_with_one_message() {
    let targets: String =
        (0..1024).map(|i| format!("[[target]]\nat = [{}, 0, 0.5]\n", f64::from(i) * 0.001)).collect();
    let scene =
        format!("format = 1\n[array]\nrows = 256\ncolumns = 256\n[solver]\nmethod = \"naive\"\n{targets}");
    let folder = folder_with(&[("a.toml", &scene)]);
    for args in [
        &["solve", "a.toml"][..],
        &["render", "a.toml", "-o", "x.png"],
        &["solve", "a.toml", "--method", "all"],
    ] {
        let message = refused(folder.path(), &mut program_after(HALF_A_GIBIBYTE, folder.path(), args));
        assert!(message.contains("a.toml: 65536 elements and 1024 foci need about"), "{message}");
    }
}

/// The peak memory of a command, bytes.
fn peak(folder: &Path, args: &[&str]) -> usize {
    let mut child = program(folder, args).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let mut most = 0;
    while child.try_wait().unwrap().is_none() {
        most = most.max(high_water(&child).unwrap_or(0));
        std::thread::sleep(Duration::from_millis(2));
    }
    assert!(child.wait().unwrap().success(), "{args:?}");
    most
}

fn high_water(child: &Child) -> Option<usize> {
    let status = fs::read_to_string(format!("/proc/{}/status", child.id())).ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<usize>().ok()? << 10)
}

/// A motion with this number of foci and of frames.
fn motion(foci: usize, frames: usize) -> String {
    let target = |i: usize| format!("[[target]]\nat = [{}, 0, 0.1]\n", i as f64 * 0.004);
    let targets: String = (0..foci).map(target).collect();
    format!(
        "format = 1\n{targets}[solver]\nmethod = \"naive\"\n[motion]\npath = \"circle\"\nframes = {frames}\n"
    )
}

#[test]
fn frames_need_no_more_memory_than_estimated() {
    const FEW: usize = 300;
    const MANY: usize = 1500;
    for foci in [1, 12] {
        let folder = folder_with(&[
            ("few.toml", &motion(foci, FEW)),
            ("many.toml", &motion(foci, MANY)),
            ("most.toml", &motion(foci, 4_000_000)),
        ]);
        let message = refused(folder.path(), &mut program(folder.path(), &["solve", "most.toml"]));
        let most: usize = message.trim_end().rsplit(' ').next().unwrap().parse().unwrap();
        let counted = (1 << 30) / most;
        for args in [
            "solve FILE --motion --csv x.csv",
            "solve FILE --motion --json",
            "render FILE -o x.png --frame mean --size 32 --tolerance 0.1",
            "render FILE -o x.png --frame mean --size 32 --quantity depression --tolerance 0.1",
            "render FILE -o x.png --frame 7 --size 32",
            "render FILE -o x.gif --motion --size 8 --tolerance 0.1",
        ] {
            let of = |file: &str| {
                let args = args.replace("FILE", file);
                peak(folder.path(), &args.split(' ').collect::<Vec<_>>())
            };
            let each = of("many.toml").saturating_sub(of("few.toml")) / (MANY - FEW);
            assert!(each <= counted, "{args}, {foci} foci: {each} bytes per frame, estimated {counted}");
        }
    }
}

#[test]
fn a_long_step_estimates_its_time_and_can_be_interrupted() {
    let folder = folder_with(&[("a.toml", &motion(1, 60_000))]);
    let water = "format = 1\n[[target]]\nat = [0, 0, 0.1]\n[plane]\nsize = [100, 0.001]\ntolerance = 0.1\n[solver]\nmethod = \"focus\"\n";
    fs::write(folder.path().join("w.toml"), water).unwrap();
    for (args, part) in [
        ("render a.toml -o x.png --frame mean", "the mean of all frames: "),
        (
            "render w.toml -o x.gif --quantity depression --waves --size 64x2",
            "the surfaces at rest of all frames: ",
        ),
    ] {
        let args: Vec<_> = args.split(' ').collect();
        let mut command = program(folder.path(), &args);
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        // The pipe stays open, because a program that cannot write its notes would end.
        let mut said = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
        let note = said.by_ref().find(|line| line.contains(part));
        assert!(note.is_some_and(|note| note.contains("in all")), "{args:?}");
        // TERM instead of INT, which a shell's background programs ignore.
        let kill =
            std::process::Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap();
        assert!(kill.success());
        assert!(child.wait().unwrap().signal().is_some(), "ended before the signal");
        assert!(!folder.path().join("x.png").exists() && !folder.path().join("x.gif").exists());
    }
}
