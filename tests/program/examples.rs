//! `assets/examples` run unchanged: sweeps by GNU parallel and by Dask.

use std::path::Path;
use std::process::{Command, Output};

fn has(program: &str, args: &[&str]) -> bool {
    let runs = Command::new(program).args(args).output().is_ok_and(|output| output.status.success());
    let answer = if runs { Ok(()) } else { Err(format!("{program} {} does not run", args.join(" "))) };
    crate::requirement::found("examples", answer).is_some()
}

/// The table that an example writes, as its only file.
fn table(mut command: Command) -> String {
    let folder = tempfile::tempdir().unwrap();
    let Output { status, stdout, stderr } = command
        .env("SONOGLYPH", env!("CARGO_BIN_EXE_sonoglyph"))
        .env("HOME", folder.path())
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(status.success(), "{}", String::from_utf8_lossy(&stderr));
    String::from_utf8(stdout).unwrap()
}

fn example(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/examples").join(name)
}

/// Forty distances in order with their pressures, the last of them an invalid scene.
fn is_a_sweep(table: &str) {
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.splitn(3, ',').collect()).collect();
    assert_eq!(rows.len(), 41, "{table}");
    assert!(rows[0][0].contains("distance_mm") && rows[0][1].contains("weaker_pa"), "{table}");
    let (last, others) = rows[1..].split_last().unwrap();
    for (row, distance) in others.iter().zip((5..).step_by(5)) {
        assert_eq!((row[0], row[2]), (distance.to_string().as_str(), ""), "{table}");
        let pressure: f64 = row[1].parse().unwrap();
        assert!((500.0..6000.0).contains(&pressure), "{table}");
    }
    assert_eq!((last[0], last[1]), ("200", ""), "{table}");
    assert!(last[2].contains("line 8: target[1]: ") && last[2].contains("behind the array"), "{table}");
}

#[test]
fn gnu_parallel_sweeps() {
    if !has("parallel", &["--version"]) || !has("jq", &["--version"]) {
        return;
    }
    let mut command = Command::new("bash");
    command.arg(example("sweep.sh"));
    is_a_sweep(&table(command));
}

#[test]
fn dask_sweeps() {
    // The system's Python has Debian's packages.
    let python = "/usr/bin/python3";
    if !has(python, &["-c", "import distributed"]) {
        return;
    }
    let mut command = Command::new(python);
    command.arg(example("sweep.py"));
    is_a_sweep(&table(command));
}
