//! Half a gibibyte of memory: usual commands fit, and larger ones are refused with a message.

use std::fs::{self, File};
use std::path::Path;
use std::process::Command;

use crate::{PROGRAM, at_home, folder, program_after, refused, requirement, succeed};

/// KiB of writable memory including stacks, a stricter limit than on resident memory.
const HALF_A_GIBIBYTE: &str = "ulimit -d 524288";

#[test]
fn the_usual_commands_stay_within_half_a_gibibyte() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let large = "format = 1\n[array]\nrows = 128\ncolumns = 128\n[[target]]\nat = [0, 0, 0.5]\n[plane]\ncentre = [0, 0, 0.5]\n";
    fs::write(at("large.toml"), large).unwrap();
    let point = |i: usize| {
        let [x, y] = [i % 32, i / 32].map(|n| 0.006 * (n as f64 - 16.0));
        format!("{{\"at\": [{x:.4}, {y:.4}, 0.1]}}")
    };
    let points: Vec<_> = (0..1000).map(point).collect();
    fs::write(at("lines"), format!("{{\"target\": [{}]}}\n", points.join(", "))).unwrap();
    for args in [
        "render a.toml -o a.png --size 2048 --data a.npy",
        "render a.toml -o a.png --quantity sheet",
        "render a.toml -o a.png --quantity dent",
        "render a.toml -o a.png --quantity dent --view shaded",
        "render a.toml -o a.gif --motion",
        "render a.toml -o a.gif --quantity dent --waves --seconds 0.005 --size 32",
        "render large.toml -o a.png",
        "batch --no-limits --method naive",
    ] {
        let args: Vec<_> = args.split(' ').collect();
        let lines = File::open(at("lines")).unwrap();
        let said = succeed(program_after(HALF_A_GIBIBYTE, folder.path(), &args).stdin(lines));
        assert!(!said.contains("\"error\""), "{args:?}: {said}");
    }
}

#[test]
fn work_beyond_memory_is_refused_with_a_message() {
    let folder = folder();
    for (first, size, part) in [
        (HALF_A_GIBIBYTE, "8192", "8192 x 8192 pixels need about 1536 MiB of memory, more than there is"),
        ("ulimit -v 1048576", "8192", "8192 x 8192 pixels need about 1536 MiB"),
        ("true", "16384", "16384 x 16384 pixels need 2048 MiB"),
        ("true", "1000000x1000", "1000000 x 1000 pixels need"),
    ] {
        for more in [&[][..], &["--motion"], &["--data", "x.npy"], &["--quantity", "sheet"]] {
            let args = [&["render", "a.toml", "-o", "x.png", "--size", size], more].concat();
            let message = refused(&mut program_after(first, folder.path(), &args));
            let is_taller = more.contains(&"sheet");
            assert!(message.contains(part) || (is_taller && message.contains("pixels need")), "{message}");
        }
    }
    assert_eq!(crate::listing(folder.path()), ["a.toml"]);
}

/// The program in its own namespace, where `/proc` reports these KiB of free memory and swap.
fn program_with_left(memory: usize, swap: usize, folder: &Path, args: &[&str]) -> Command {
    let figures = format!("MemAvailable: {memory} kB\nSwapFree: {swap} kB\n");
    fs::write(folder.join("meminfo"), figures).unwrap();
    let mut command = Command::new("unshare");
    let shell = "mount --bind meminfo /proc/meminfo && exec \"$0\" \"$@\"";
    at_home(&mut command, folder).args(["-rm", "sh", "-c", shell, PROGRAM]).args(args);
    command
}

#[test]
fn estimates_use_available_memory_not_overcommitted() {
    let folder = folder();
    let mounted = program_with_left(0, 0, folder.path(), &["--version"]).output();
    let mounted =
        mounted.map_err(|error| error.to_string()).and_then(|output| match output.status.success() {
            true => Ok(()),
            false => Err(String::from_utf8_lossy(&output.stderr).into_owned()),
        });
    if requirement::found("namespaces", mounted).is_none() {
        return;
    }
    let args = ["render", "a.toml", "-o", "x.png", "--size", "2048"];
    // 24 bytes per pixel.
    let kibibytes = 2048 * 2048 * 24 / 1024;
    let message = refused(&mut program_with_left(kibibytes - 1000, 999, folder.path(), &args));
    assert!(
        message.contains("2048 x 2048 pixels need about 96 MiB of memory, more than there is"),
        "{message}"
    );
    assert_eq!(crate::listing(folder.path()), ["a.toml", "meminfo"]);
    succeed(&mut program_with_left(kibibytes - 1000, 1000, folder.path(), &args));
}
